"""Branches: laws along them, special points compared with independent calculations, and invalid input."""

import itertools
import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from scipy.optimize import brentq
from shared_motions import pair_motion, triple_motion
from shared_systems import FIGURE6, TABLE
from vibroimpact.base.errors import VibroimpactError
from vibroimpact.results.noun import column


def product_of_restitution(branch):
    walls = np.where(branch.pattern.signs[:, None] > 0, branch.R1, branch.R2)
    return np.prod(walls**2, axis=0)


BRANCHES = [
    (pair_motion, "clearance", (10, 60)),
    (pair_motion, "r", (0.85, 0.99)),
    (pair_motion, "mu", (0.01, 0.2)),
    (pair_motion, "xi", (0.001, 0.1)),
    (pair_motion, "restitution", (0.4, 0.9)),
    (pair_motion, "R1", (0.6, 0.9)),
    (lambda: vi.equispaced(FIGURE6, 1.04, 25.0)[0], "clearance", (3, 60)),
    (lambda: vi.equispaced(FIGURE6, 1.04, 25.0)[1], "r", (0.9, 1.2)),
    (triple_motion, "clearance", (3, 40)),
]


@pytest.fixture(scope="module", params=range(len(BRANCHES)), ids=lambda i: f"{i}-{BRANCHES[i][1]}")
def path(request):
    make, parameter, bounds = BRANCHES[request.param]
    motion = make()
    return motion, vi.branch(motion, parameter, bounds)


def test_determinant_along_the_branch(path):
    """det[P] = exp(-4 pi xi k/r) prod R_i^2."""
    _, branch = path
    wanted = np.exp(-4 * np.pi * branch.xi * branch.pattern.cycles / branch.r)
    wanted = wanted * product_of_restitution(branch)
    product = np.prod(branch.multipliers, axis=0)
    # with multipliers of 1e6 and 1e-6 their product has only this precision
    largest = np.abs(branch.multipliers).max(axis=0)
    # (none where an approach speed is zero)
    good = largest < 1e4
    assert good.sum() > len(branch) // 3
    error = np.abs(product - wanted)[good]
    assert np.all(error < 1e-11 * (wanted * (1 + largest**2))[good])


def test_residual_along_the_branch(path):
    assert path[1].residual.max() <= 1e-12


def test_start_lies_on_the_branch(path):
    motion, branch = path
    offset = np.abs(branch.X - motion.X[:, None]).max(axis=0) / motion.clearance
    offset += np.abs(branch.alpha - motion.alpha[:, None]).max(axis=0)
    parameters = np.array([motion.r, motion.clearance, motion.osc.xi, motion.osc.mu])
    along = np.array([branch.r, branch.clearance, branch.xi, branch.mu])
    offset += np.abs(along / parameters[:, None] - 1).max(axis=0)
    assert offset.min() < 1e-12


def test_points_are_exact_motions(path):
    """Newton's method of `exact` does not move a point of the branch."""
    _, branch = path
    marks = [point.index for point in branch.special_points]
    for i in range(2, len(branch), max(1, len(branch) // 7)):
        if min(abs(i - j) for j in marks) < 3:  # Newton's method is slow near a fold
            continue
        item = branch[i]
        again = vi.exact(item.osc, item.r, item.clearance, item)
        np.testing.assert_allclose(again.X, item.X, rtol=0, atol=1e-8 * item.clearance)
        assert (again.admissible, again.stable) == (item.admissible, item.stable) or i in {
            point.index for point in branch.special_points
        }


def test_special_points_are_where_they_should_be(path):
    """Each special point has the critical multiplier, or the zero gap, that defines its type."""
    _, branch = path
    for point in branch.special_points:
        motion = point.motion
        gap = np.abs(motion.multipliers)
        if point.type == "fold":
            assert np.abs(motion.multipliers - 1).min() < 1e-8
        elif point.type == "flip":
            assert np.abs(motion.multipliers + 1).min() < 1e-8
        elif point.type == "pitchfork":
            assert np.abs(motion.multipliers - 1).min() < 1e-8
        elif point.type == "neimark_sacker":
            turning = np.abs(motion.multipliers.imag) > 1e-9
            assert np.abs(gap[turning] - 1).min() < 1e-9
        elif point.type == "grazing":
            # where the touch is at an end of the flight, the event is the zero approach speed
            assert not ends_at_a_wall(motion, point)
            assert abs(touch(motion, point) - 0.5) < 1e-10
        elif point.type == "zero_approach":
            i = point.impact
            approach = motion.Z_dot_before[i] - motion.X_dot_before[i]
            assert abs(approach) < 1e-10 * motion.clearance


def ends_at_a_wall(motion, point):
    """Whether the touch is at an end of the flight: there the approach speed is zero too."""
    i = [point.impact, (point.impact + 1) % len(motion.pattern)]
    approach = np.abs(motion.Z_dot_before[i] - motion.X_dot_before[i]).min()
    return approach < 1e-6 * motion.clearance


def touch(motion, point):
    """Greatest |Y|/D towards a wall inside a flight, by dense sampling and bounded minimisation."""
    from scipy.optimize import minimize_scalar

    ends = np.r_[motion.alpha, 2 * np.pi * motion.pattern.cycles] / motion.r
    begin, end = ends[point.impact : point.impact + 2]
    side = 1 if point.side == "R" else -1
    times = np.linspace(begin, end, 2001)
    y = side * motion.sample(times).Y / motion.clearance
    inner = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])) + 1
    best = times[inner[np.argmax(y[inner])]]
    width = times[1] - times[0]
    found = minimize_scalar(
        lambda t: -side * float(motion.sample(t).Y) / motion.clearance,
        bounds=(best - width, best + width),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return -found.fun


def test_stability_changes_at_special_points_only(path):
    """Between special points `stable` and `admissible` do not change, where they are known."""
    _, branch = path
    marks = {p.index for p in branch.special_points}
    for name in ("stable", "admissible"):
        column = getattr(branch, name)
        known = np.flatnonzero(column >= 0).tolist()
        changes = [(i, j) for i, j in itertools.pairwise(known) if column[i] != column[j]]
        assert all(set(range(i, j + 1)) & marks for i, j in changes), f"{name} changes at {changes}"
        # rounding decides only near a bifurcation
        assert len(known) > 0.9 * len(column) - 5


def test_equispaced_bifurcations_against_the_closed_form():
    """Pitchfork and Neimark-Sacker points of the pair agree with bisection on its multipliers."""
    r, checked = 1.04, []
    for which in (0, 1):
        branch = vi.branch(vi.equispaced(FIGURE6, r, 25.0)[which], "clearance", (3, 120))
        for point in branch.special_points:
            if point.type not in ("pitchfork", "neimark_sacker"):
                continue
            x = point.motion.X[0] / point.clearance

            def nearest(clearance, x=x):
                motions = vi.equispaced(FIGURE6, r, clearance)
                return min(motions, key=lambda m: abs(m.X[0] / m.clearance - x))

            if point.type == "pitchfork":

                def crossing(clearance, nearest=nearest):
                    values = nearest(clearance).multipliers
                    real = values[np.abs(values.imag) < 1e-9].real
                    return float(real[np.argmin(np.abs(real - 1))] - 1)
            else:

                def crossing(clearance, nearest=nearest):
                    values = nearest(clearance).multipliers
                    turning = values[np.abs(values.imag) > 1e-9]
                    return float(np.abs(turning).max() - 1)

            low, high = point.clearance * 0.999, point.clearance * 1.001
            if crossing(low) * crossing(high) > 0:
                continue
            found = brentq(crossing, low, high, xtol=1e-13, rtol=1e-14)
            assert abs(found / point.clearance - 1) < 1e-10
            checked.append(point.type)
    assert {"pitchfork", "neimark_sacker"} <= set(checked)


def test_special_points_do_not_depend_on_the_start():
    """A branch that starts within a step of a bifurcation, before or after it, finds all special points."""
    bounds, found = (44, 50), []
    motion, _ = vi.equispaced(FIGURE6, 1.0, 45.0)
    points = vi.branch(motion, "clearance", bounds).special_points
    for point in points:
        if point.type not in ("pitchfork", "neimark_sacker"):
            continue
        found.append(point.type)
        for share in (1 - 2e-4, 1 + 2e-4):
            start = min(
                vi.equispaced(FIGURE6, 1.0, point.clearance * share),
                key=lambda m, phase=point.motion.load_phase: abs(m.load_phase - phase),
            )
            again = vi.branch(start, "clearance", bounds).special_points
            assert [p.type for p in again] == [p.type for p in points]
            assert [p.clearance for p in again] == pytest.approx(
                [p.clearance for p in points], rel=1e-9
            )
    assert "pitchfork" in found


def test_host_that_nothing_damps_or_moves_has_no_neimark_sacker_point():
    host = vi.Oscillator(xi=0.0, mu=0.0, restitution=1.0)
    phases = np.pi * np.array([0, 0.8425, 0.9237, 1.052])
    motion = vi.exact(host, 1.624, 0.01455, (phases, "LLLR"))
    branch = vi.branch(motion, "restitution", (0.9, 1), max_points=100)
    on_circle = np.abs(np.abs(branch.multipliers) - 1) < 1e-7
    assert np.all(np.sum(on_circle, axis=0) >= 2)
    assert "neimark_sacker" not in {point.type for point in branch.special_points}


def test_branch_goes_round_a_fold():
    """The equispaced pair has no motions on one side of each fold and two on the other."""
    branch = vi.branch(vi.equispaced(FIGURE6, 0.9, 20.0)[0], "clearance", (5, 200))
    folds = [p for p in branch.special_points if p.type == "fold"]
    assert folds
    for fold in folds:
        counts = sorted(
            len(vi.equispaced(FIGURE6, 0.9, fold.clearance * (1 + e))) for e in (-1e-6, 1e-6)
        )
        assert counts == [0, 2]
    turns = np.sign(np.diff(branch.values))
    assert {1.0, -1.0} <= set(turns.tolist())


def test_mirror_image_gives_the_same_branch():
    motion = pair_motion()
    image = next(
        m
        for m in vi.find(TABLE, 0.94, 37.0, max_impacts=2, max_cycles=1, states=0)
        if m.stable and abs(m.alpha[1] - motion.alpha[1]) > 1e-3
    )
    one, other = (vi.branch(m, "clearance", (10, 60)) for m in (motion, image))
    for a, b in zip(one.special_points, other.special_points, strict=True):
        assert a.type == b.type
        assert abs(a.clearance / b.clearance - 1) < 1e-9


def test_zero_approach_is_one_event():
    """A zero of an approach speed is not also reported as a grazing, although the flights touch the wall."""
    branch = vi.branch(triple_motion(), "clearance", (1, 60))
    points = [p for p in branch.special_points if p.type in ("grazing", "zero_approach")]
    assert {p.type for p in points} == {"grazing", "zero_approach"}
    places = sorted(p.clearance for p in points)
    assert np.diff(places).min() > 1e-3


def test_no_multipliers_at_a_zero_approach():
    """The period has no derivative where an impact has no approach speed v; near it a multiplier is c/v."""
    branch = vi.branch(triple_motion(), "clearance", (1, 60))
    marks = [(p.index, p.impact) for p in branch.special_points if p.type == "zero_approach"]
    assert marks
    for i, impact in marks:
        assert np.isnan(branch.multipliers[:, i]).all()
        assert (branch[i].admissible, branch[i].stable) == (False, None)
        products = [
            branch.multipliers[0, j].real * (m.Z_dot_before[impact] - m.X_dot_before[impact])
            for j, m in ((i - 1, branch[i - 1]), (i + 1, branch[i + 1]))
        ]
        assert products[0] == pytest.approx(products[1], rel=0.05)


@pytest.mark.parametrize(("y", "drawn"), [("largest", False), ("attenuation", True)])
def test_legend_names_only_markers_that_are_drawn(y, drawn):
    """A zero approach has no multipliers, so a plot of multipliers neither marks nor names it."""
    pytest.importorskip("matplotlib")
    branch = vi.branch(triple_motion(), "clearance", (1, 60))
    texts = [text.get_text() for text in branch.plot(y=y).get_legend().get_texts()]
    assert ("zero approach" in texts) is drawn


def test_columns_and_table():
    branch = vi.branch(pair_motion(), "clearance", (10, 60))
    item = branch[3]
    assert item.clearance == branch.clearance[3]
    assert branch[-1].clearance == branch.clearance[-1]
    with pytest.raises(IndexError):
        branch[len(branch)]
    table = branch.to_xarray()
    np.testing.assert_array_equal(table["clearance"], branch.clearance)
    assert table["phases"].dims == ("point", "impact")
    np.testing.assert_array_equal(table["phases"].T, branch.alpha)
    assert sorted(set(table["special"].values.tolist()) - {""}) == sorted(
        {p.type for p in branch.special_points}
    )
    assert "flip" in repr(branch)
    again = vi.branch(pair_motion(), "clearance", (10, 60))
    assert again.X.tobytes() == branch.X.tobytes()


def test_plot_draws_the_columns():
    plt = pytest.importorskip("matplotlib.pyplot")
    branch = vi.branch(pair_motion(), "clearance", (10, 60))
    ax = branch.plot(y="largest")
    largest = np.abs(branch.multipliers).max(axis=0)
    styles = {line.get_label(): line for line in ax.get_lines()}
    stable = styles["stable"].get_ydata()
    mask = (branch.stable == 1) & (branch.admissible == 1)
    np.testing.assert_array_equal(stable[mask], largest[mask])
    assert np.isnan(stable[~mask]).sum() >= (~mask).sum() - 2 * len(branch.special_points)
    assert "flip" in styles
    branch.plot(ax, y="largest")
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "flip" in names
    assert len(names) == len(set(names))
    with pytest.raises(vi.errors.ParameterError, match="y = 'colour'"):
        branch.plot(y="colour")
    plt.close("all")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"parameter": "length", "bounds": (1, 2)}, "parameter = 'length'"),
        ({"bounds": None}, "bounds = None"),
        ({"bounds": (40, 60)}, r"bounds\[0\] = 40.0: must be .* the motion has clearance = 37"),
        ({"bounds": (60, 40)}, r"bounds\[0\] = 40.0: must be .* the motion has clearance = 37"),
        ({"bounds": (math.nan, 60)}, r"bounds\[0\] = nan"),
        ({"bounds": 3}, "bounds = 3"),
        ({"bounds": (10, 60), "max_points": 1}, "max_points = 1"),
        ({"bounds": (10, 60), "longest_step": 0.0}, "longest_step = 0.0"),
        ({"bounds": (10, 60), "longest_step": math.nan}, "longest_step = nan"),
    ],
)
def test_bad_input(arguments, words):
    with pytest.raises(vi.errors.VibroimpactError, match=words):
        vi.branch(pair_motion(), **arguments)


def test_bad_motion():
    with pytest.raises(vi.errors.ParameterTypeError, match="motion = 3"):
        vi.branch(3, bounds=(1, 2))
    output = "parameter = 'restitution'.* equal restitution on both walls"
    with pytest.raises(vi.errors.ParameterError, match=output):
        vi.branch(triple_motion(), "restitution", (0.1, 0.9))


def test_motion_with_restitution_of_its_own():
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    motion = vi.periodic(osc, 0.94, [0, 1.37 * math.pi], vi.Pattern("RL"), restitution=(0.75, 0.7))
    with pytest.raises(vi.errors.ParameterError, match=r"motion.restitution = \[0.75, 0.7\]"):
        vi.branch(motion, "clearance", (10, 60))


@pytest.mark.parametrize(("name", "xi", "r", "bounds"), [
    ("r", 0.0, 0.94, (0.9, 1.1)), ("xi", 0.005, 1.0, (0.0, 0.01))])  # fmt: skip
def test_bounds_round_a_resonance_without_damping(name, xi, r, bounds):
    osc = vi.Oscillator(xi=xi, mu=0.042, restitution=0.75)
    motion = vi.periodic(osc, r, [0, 1.37 * math.pi], vi.Pattern("RL"))
    with pytest.raises(vi.errors.ParameterError, match="resonance without damping"):
        vi.branch(motion, name, bounds)


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, 2.0])
def test_bad_longest_step(step):
    with pytest.raises(vi.errors.ParameterError, match=r"longest_step = .*: must be a number"):
        vi.branch(pair_motion(), "clearance", (10, 60), longest_step=step)


@pytest.mark.parametrize("bounds", [(37, 60), (10, 37)])
def test_branch_that_starts_on_a_bound(bounds):
    """The branch stays between the bounds, and both ends report the bound."""
    branch = vi.branch(pair_motion(), "clearance", bounds)
    assert branch.ends == ("bound of the parameter", "bound of the parameter")
    assert [point.type for point in branch.special_points[:: len(branch.special_points) - 1]] == [
        "bound"
    ] * 2
    assert (branch.clearance.min(), branch.clearance.max()) == pytest.approx(bounds, rel=1e-12)


def test_full_branch_says_so():
    branch = vi.branch(pair_motion(), "clearance", (10, 60), max_points=15)
    assert "full" in branch.ends


@pytest.mark.parametrize("high", [1.0, 1e3, 1e6])
def test_a_branch_never_leaves_its_bounds(high):
    """Steps over a wide range end on the bound itself, not beyond it."""
    for motion in vi.equispaced(vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75), 1.04, 25.0):
        branch = vi.branch(motion, "mu", bounds=(0.0, high))
        assert branch.mu.min() == 0.0
        assert branch.mu.max() <= high
        assert (branch.mu.max() == high) == (branch.ends[1] == "bound of the parameter")
        assert all(0 <= point.motion.osc.mu <= high for point in branch.special_points)


LONG = {"longest_step": 2e-4, "max_points": 20_000}


@pytest.mark.parametrize("share", [0.1, 0.25, 0.6])
def test_stopped_branch(share, monkeypatch):
    """A stop in either direction, or while the motions are computed, leaves a part with the bits of the whole."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)

    def progress(done, what):
        if done > share:
            raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as stop:
        vi.branch(pair_motion(), "clearance", (10, 60), **LONG, progress=progress)
    part, whole = stop.value.result, vi.branch(pair_motion(), "clearance", (10, 60), **LONG)
    (first,) = np.flatnonzero(whole.clearance == part.clearance[0])
    assert 1 < len(part) < len(whole)
    there = slice(first, first + len(part))
    columns = [
        name
        for name, item in vars(vi.Branch).items()
        if isinstance(item, column) and hasattr(whole, name)
    ]
    assert len(columns) == 22
    for name in columns:
        assert getattr(part, name).tobytes() == getattr(whole, name)[..., there].tobytes()
    points = [point for point in whole.special_points if first <= point.index < there.stop]
    assert [p.index + first for p in part.special_points] == [p.index for p in points]
    assert "stopped" in part.ends
    message = re.fullmatch(r"clearance from (\S+) to (\S+) was reached", part.cut)
    reached = part.clearance.min(), part.clearance.max()
    np.testing.assert_allclose([float(item) for item in message.groups()], reached, rtol=1e-5)
    assert (part.complete, whole.complete, whole.cut) == (False, True, "")
    assert not vi.Branch.from_json(part.to_json()).complete


def test_branches_that_a_stop_leaves_out(monkeypatch, tmp_path):
    """A stop in the first of two branches reports how far it came, and that the other one did not start."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    path = tmp_path / "pair.nml"
    path.write_text(
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
        "&motion kind = 'equispaced', clearance = 25 /\n"
        "&branch parameter = 'clearance', low = 1, high = 200, longest_step = 2e-5, max_points = 100000 /\n"
    )

    def progress(done, what):
        if done > 0.05:
            raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as stop:
        vi.read_namelist(path)[0].compute(progress)
    (part,) = stop.value.result
    assert re.fullmatch(r"branch 1: clearance from \S+ to \S+ was reached; 1 not begun", part.cut)
    assert len(part) > 1


@pytest.mark.parametrize("limit", [20_000, 200])
def test_progress_is_told(limit, monkeypatch):
    """Progress runs from 0 to 1, even if max_points is reached first, and does not change the result."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    shares, given = [], LONG | {"max_points": limit}
    start, bounds = vi.equispaced(FIGURE6, 0.9, 20.0)[0], (5, 200)
    message = vi.branch(
        start, "clearance", bounds, **given, progress=lambda share, what: shares.append(share)
    )
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] == 1
    assert len(set(shares)) > (10 if limit > 200 else 0)
    plain = vi.branch(start, "clearance", bounds, **given)
    for name in ("r", "clearance", "phases", "X", "multipliers", "stable"):
        assert getattr(message, name).tobytes() == getattr(plain, name).tobytes()


@pytest.mark.parametrize("seed", range(4))
def test_branch_ends_where_two_impacts_on_a_wall_come_together(seed):
    """Down to R = 0, where the second impact immediately follows the first: positions are finite up to the end."""
    rng = np.random.default_rng(seed)
    ended = 0
    while ended < 2:
        osc = vi.Oscillator(
            xi=10 ** rng.uniform(-3, -1),
            mu=10 ** rng.uniform(-2, 0),
            restitution=rng.uniform(0.3, 0.8),
        )
        phases = np.sort(rng.uniform(0, 2 * math.pi, 4))
        try:
            motion = vi.exact(
                osc,
                rng.uniform(0.3, 1.2),
                10 ** rng.uniform(-1, 1),
                (phases - phases[0], vi.Pattern("RRLL")),
            )
            path = vi.branch(motion, "restitution", (0.0, 0.99), max_points=300)
        except VibroimpactError:
            continue
        assert np.isfinite(path.X).all()
        assert np.isfinite(path.alpha).all()
        for end, i in zip(path.ends, (0, len(path) - 1), strict=True):
            if end != "two impacts at one instant":
                continue
            ended += 1
            special = [p for p in path.special_points if p.index == i]
            assert [p.type for p in special] == ["zero_approach"]
            # the impact in question immediately follows the previous one, on the same wall
            later = np.diff(np.append(path.alpha[:, i], 2 * math.pi))
            assert later.min() < 1e-3
            assert path.admissible[i] == 0
