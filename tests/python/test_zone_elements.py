"""Zones of motions with elastic stops and friction, compared with closed forms, branches and simulations."""

import itertools

import numpy as np
import pytest
import vibroimpact as vi
from test_attractors_elements import BACKLASH, den_hartog
from test_exact_elements import one_stop, settled


def margin(b, zeta, f):
    """The amount by which the force at a reversal of Den Hartog's oscillator exceeds the friction.

    In half a period x = f + p(t) + h(t), with a forced part p and a free part h. The motion at the end is minus
    that at the beginning, so that h there is -h(0) - 2 f, and its rate minus that at the beginning. NaN where
    there is no such motion.
    """
    w, half = np.sqrt(1 - zeta**2), np.pi / b
    decay, c, s = np.exp(-zeta * half), np.cos(w * half), np.sin(w * half)
    flow = decay * np.array([[c + zeta / w * s, s / w], [-s / w, c - zeta / w * s]])
    free, rate = np.linalg.solve(flow + np.eye(2), [-2 * f, 0])
    with np.errstate(invalid="ignore"):
        place = den_hartog(b, zeta, f)
    forced, forced_rate = place - f - free, -rate
    real, imaginary = 1 - b**2, 2 * zeta * b  # of the force that moves it
    load = real * forced + imaginary * forced_rate / b
    return place - f - load


def rough(zeta, f):
    return vi.Structure([1.0], [2 * zeta], [1.0], friction=[vi.Friction([1.0], f)])


def test_den_hartog_over_a_grid():
    """Amplitudes by the closed form up to the boundary of sticking, beyond which the mass sticks."""
    counts = {2: 0, 4: 0}
    for b, zeta, f in itertools.product(
        (0.6, 0.8, 0.95, 1.1, 1.4), (0.0, 0.05, 0.2), (0.05, 0.3, 0.6, 0.8)
    ):
        motion = settled(rough(zeta, f), vi.Load(b, cosine=[1.0]), 4000)
        counts[len(motion.gaps)] += 1
        assert (len(motion.gaps) == 2) == bool(margin(b, zeta, f) > 0)
        assert motion.stable
        if len(motion.gaps) == 2:
            x = np.abs(motion.states[:, 0, 0])
            assert x == pytest.approx([den_hartog(b, zeta, f)] * 2, rel=1e-9)
    assert min(counts.values()) > 10


def test_border_of_stops():
    """The zone of motions without sticking ends where the closed form does."""
    motion = settled(rough(0.05, 0.3), vi.Load(0.8, cosine=[1.0]))
    zone = vi.zone(motion, ("frequency", 0.55, 1.6), ("slip", 0.02, 0.95), lines=9)
    assert zone.closed
    assert {piece.type for piece in zone.boundary} == {"window", "stick_begins"}
    for piece in zone.boundary:
        if piece.type == "stick_begins":
            values = [margin(b, 0.05, f) for b, f in zip(piece.x, piece.y, strict=True)]
            assert values == pytest.approx([0] * len(values), abs=1e-9)
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0.55, 1.6, 50), rng.uniform(0.02, 0.95, 50)
    assert zone.contains(x, y).tolist() == [
        bool(margin(b, 0.05, f) > 0) for b, f in zip(x, y, strict=True)
    ]
    for b, f in zip(x[:12].tolist(), y[:12].tolist(), strict=True):
        found = zone.motion(b, f)
        if margin(b, 0.05, f) > 0:
            assert found.stable
            assert found.load.frequency == pytest.approx(b, rel=1e-15)
            assert np.abs(found.states[:, 0, 0]) == pytest.approx(den_hartog(b, 0.05, f), rel=1e-9)
        else:
            assert found is None
    for place, name in (((np.nan, 1), "x = nan"), ((1, np.inf), "y = inf")):
        for method in (zone.motion, zone.at):
            with pytest.raises(vi.ParameterError, match=f"^{name}: must be a finite number"):
                method(*place)
    pytest.importorskip("matplotlib")
    assert "stick begins" in zone.plot().get_legend_handles_labels()[1]


@pytest.mark.slow
def test_zone_of_contacts(tmp_path):
    """The zone ends where the motion without contact just reaches the stop, and at the folds of branches."""
    s = one_stop(1.0, stiffness=10, damping=0.05)
    load = vi.Load(1.1, cosine=[0.3])
    motion = settled(s, load, 300)
    zone = vi.zone(motion, ("frequency", 0.8, 1.6), ("load", 0.5, 2.0), lines=9)
    assert zone.closed
    assert {piece.type for piece in zone.boundary} == {
        "window", "contact_vanishes", "flip", "fold",
    }  # fmt: skip
    for piece in zone.boundary:
        if piece.type == "contact_vanishes":
            reached = 0.3 * piece.y / abs(1 - piece.x**2 + 0.1j * piece.x)
            assert reached == pytest.approx(np.ones(len(piece)), abs=1e-9)
    branch = vi.branch(motion, "frequency", bounds=(0.8, 1.6))
    fold = max(point.value for point in branch.special_points if point.type == "fold")
    assert zone.contains(fold - 1e-4, 1.0)
    assert not zone.contains(fold + 1e-4, 1.0)
    rng = np.random.default_rng(2)
    for x, y in zip(rng.uniform(0.8, 1.6, 12), rng.uniform(0.5, 2, 12), strict=True):
        found = vi.basins(s, vi.Load(x, cosine=[0.3 * y]), states=12)
        assert zone.contains(x, y) == ("2/1" in [item.name for item in found.attractors])
    for x, y in ((0.9, 1.7), (1.3, 1.4), (1.55, 1.9)):
        here = zone.motion(x, y)
        assert (here is not None and bool(here.stable)) == zone.contains(x, y)
    case = tmp_path / "zone.nml"
    case.write_text(zone.to_namelist())
    zone.save(tmp_path / "saved.csv")
    vi.run_namelists([case], tmp_path)
    one, two = (
        [line for line in (tmp_path / name).read_text().splitlines() if line[0] != "#"]
        for name in ("zone.csv", "saved.csv")
    )
    assert one == two


def test_each_motion_counts_once():
    """Where two conditions are zero along one curve, as where friction that reverses begins to stick, it is one
    boundary: inside is the one motion on which simulations settle."""
    stop = one_stop(0.8, stiffness=20, damping=0.1).gaps
    s = vi.Structure([1.0], [0.1], [1.0], stop, [vi.Friction([1.0], 0.3)])
    motion = settled(s, vi.Load(0.6, cosine=[1.0]), 300)
    zone = vi.zone(motion, ("frequency", 0.5, 0.8), ("slip", 0.1, 0.5), lines=7)
    assert zone.closed
    assert len(zone.loops) == 1
    x, y = [0.6, 0.65, 0.7], [0.28, 0.25, 0.2]
    assert zone.count(x, y).tolist() == [1, 1, 1]
    found = vi.find(*zone.at(x[1], y[1]))
    assert [item.gaps.tolist() for item in found] == [zone.motion(x[1], y[1]).gaps.tolist()]
    # on one side of the boundary friction reverses before it sticks, on the other it sticks at once
    # rounding decides which of the two conditions names it
    names = ("friction 1", "friction 1 does not stick in flight 6")
    (piece,) = (p for p in zone.boundary if p.type != "stick_vanishes" and p.detail in names)
    middle = len(piece) // 2
    kinds = [
        vi.simulate(
            *zone.at(piece.x[middle], piece.y[middle] + shift), cycles=1, discard=300
        ).events["kind"]
        for shift in (-1e-4, 1e-4)
    ]
    assert [(kind == "halt").sum() for kind in kinds] == [1, 1]
    assert sorted(map(len, kinds)) == [6, 7]


def backlash():
    """A symmetric motion with stops on both sides, and a plane."""
    motion = vi.basins(BACKLASH, vi.Load(1.6, cosine=[1.0]), states=12).attractors[1].motion
    assert len(motion.gaps) == 4
    return motion, ("frequency", 1.3, 1.65), ("load", 0.98, 1.02)


def slot():
    """The same for the oscillator with friction in its slot, with a second boundary."""
    point = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(1.04, 25.0, friction=0.05)
    motion = vi.exact(point, vi.simulate(point, cycles=300))
    return motion, ("frequency", 0.99, 1.1), ("slip", 0.02, 0.08)


@pytest.mark.parametrize("plane", [backlash, slot])
def test_motions_that_are_their_own_image(plane):
    """The mirror symmetry is lost at a pitchfork: over the whole period a multiplier is 1 there."""
    motion, x, y = plane()
    zone = vi.zone(motion, x, y, lines=5)
    pieces = {piece.type: piece for piece in zone.boundary}
    assert "pitchfork" in pieces
    assert "fold" not in pieces
    assert zone.contains(motion.load.frequency, 1.0 if plane is backlash else 0.05)
    fork = pieces["pitchfork"]
    # the second half of the events is the image of the first one
    assert len(fork.phases) == len(zone.gaps)
    half = len(zone.gaps) // 2
    assert fork.phases[half:] == pytest.approx(fork.phases[:half] + np.pi, abs=1e-12)
    for i in range(0, len(fork.x), len(fork.x) // 4):
        place = float(fork.x[i]), float(fork.y[i])
        structure, load = zone.at(motion.load.frequency, place[1])
        start = vi.exact(structure, load, motion)
        ends = sorted([place[0], load.frequency])
        branch = vi.branch(start, "frequency", bounds=(ends[0] - 1e-3, ends[1] + 1e-3))
        near = np.abs(branch.values - place[0]).argmin()
        crossing = np.abs(branch.multipliers - 1).min(axis=0)
        assert crossing[near] < 1e-5
        # it is stable only on the side of the zone
        inside = zone.contains(branch.values, np.full(len(branch), place[1]))
        apart = np.abs(branch.values - place[0]) > 1e-5
        good = (branch.stable == 1) & (branch.admissible == 1)
        assert (good == inside)[apart & (np.abs(branch.values - ends[0]) < 0.01)].all()
    if plane is slot:
        assert "neimark_sacker" in pieces


def test_chart_of_den_hartog():
    """One motion at each point before the boundary of sticking, with the amplitude of the closed form."""
    pytest.importorskip("xarray")
    motion = settled(rough(0.05, 0.3), vi.Load(0.8, cosine=[1.0]))
    chart = vi.chart(motion, ("frequency", 0.6, 1.5), ("slip", 0.05, 0.95), points=5)
    good = (chart.admissible.values == 1) & (chart.stable.values == 1)
    for (j, f), (i, b) in itertools.product(enumerate(chart.y.values), enumerate(chart.x.values)):
        assert good[:, j, i].sum() == bool(margin(b, 0.05, f) > 0)
        if good[:, j, i].any():
            k, x = good[:, j, i].argmax(), den_hartog(b, 0.05, f)
            found = [part.values[0, k, j, i] for part in (chart.q_min, chart.q_max)]
            assert found == pytest.approx([-x, x], rel=1e-11)


def test_chart_of_contacts():
    """The motions of a grid are those on which simulations settle."""
    pytest.importorskip("xarray")
    s = one_stop(1.0, stiffness=10, damping=0.05)
    motion = settled(s, vi.Load(1.1, cosine=[0.3]), 300)
    chart = vi.chart(motion, ("frequency", 0.8, 1.6), ("load", 0.5, 2.0), points=5)
    good = (chart.admissible.values == 1) & (chart.stable.values == 1)
    for (j, y), (i, x) in itertools.product(enumerate(chart.y.values), enumerate(chart.x.values)):
        found = vi.basins(s, vi.Load(x, cosine=[0.3 * y]), states=12).attractors
        motions = [item.motion for item in found if item.name == "2/1"]
        assert good[:, j, i].sum() == len(motions)
        if motions:
            k = good[:, j, i].argmax()
            speeds, phases = (part.values[:, k, j, i] for part in (chart.speeds, chart.phases))
            assert np.sort(speeds) == pytest.approx(np.sort(motions[0].speeds), rel=1e-9)
            turn = 2 * np.pi
            assert np.sort(phases % turn) == pytest.approx(np.sort(motions[0].phases % turn))


@pytest.mark.slow
def test_stiff_stop_of_a_zone_becomes_a_wall():
    """A zone with a stiff stop has the boundary conditions of the rigid one, at a distance of order k^(-1/2)."""
    pair = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    log, mass = -np.log(0.61), 0.028 / 1.028

    def corners(motion):
        zone = vi.zone(motion, ("frequency", 0.8, 1.3), ("opening", 2.5, 50.0), lines=5)
        assert zone.closed
        assert len(zone.loops) == 1
        types = [piece.type for piece in zone.boundary]
        return types, np.array([[piece.x[0], piece.y[0]] for piece in zone.boundary])

    rigid = pair.at(1.05, 20.0, load=vi.Load(1.05, sine=[1.0, 0.0]))
    names, limit = corners(vi.exact(rigid, vi.simulate(rigid, cycles=400)))
    away = []
    for k in (1e3, 1e5):
        damping = 2 * log / np.hypot(np.pi, log) * np.sqrt(k * mass)  # departs with R = 0.61
        point = pair.at(1.05, 20.0, stops=(None, (k, damping)))
        types, places = corners(vi.exact(point, vi.simulate(point, cycles=400)))
        assert types == names
        away.append(np.sqrt(k) * (places - limit))
    assert away[0] == pytest.approx(away[1], rel=0.02, abs=2e-4)


def test_an_atlas_counts_contacts_not_what_friction_does():
    """One contact that lets go before it ends, and two reversals of slip, are one contact in an atlas."""
    s = vi.Structure([1.0], [0.02], [1.0], [vi.Stop([1.0], 0.5, 30.0, 1.0, release="force")],
                     [vi.Friction([1.0], 0.01)])  # fmt: skip
    window = {"x": ("frequency", 0.9, 1.1), "y": ("contact", 20.0, 50.0)}
    atlas = vi.atlas(s, vi.Load(1.0, cosine=[0.6]), **window, max_impacts=1, survey=6, lines=5)
    (zone,) = atlas.zones
    (motion,) = vi.find(*zone.at(1.0, 30.0), states=4)
    assert sorted(motion.kinds) == ["leave", "let_go", "slip_down", "slip_up", "touch"]
    assert atlas.survey.counts["periodic"] == 6
    assert len(atlas.unexplained) == 0
