"""Zones: against routes that know nothing of their boundaries, laws on the boundaries, bad input."""

import json
import math
import signal
import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from scipy.optimize import brentq, minimize_scalar
from vibroimpact.newton import newton
from vibroimpact.studies.conditions import is_symmetric
from vibroimpact.studies.geometry import signed_area

FIGURE3 = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
FIGURE6 = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
FIGURE8 = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
WINDOW = ((0.8, 1.2), (2, 200))
CASES = [
    (FIGURE6, "RL", True), (FIGURE6, "RL", False), (FIGURE6, "RRL", False), (FIGURE6, "RRLL", True),
    (FIGURE6, "RRLL", False), (FIGURE6, "RRRL", False), (FIGURE8, "RL", False), (FIGURE8, "RLL", False),
]  # fmt: skip


@pytest.fixture(scope="module", params=CASES, ids=lambda c: f"{c[1]}-{c[2]}-{c[0].restitution[1]}")
def case(request):
    osc, sides, symmetric = request.param
    return vi.zone(osc, vi.Pattern(sides), *WINDOW, symmetric=symmetric)


@pytest.fixture(scope="module")
def equispaced():
    return vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True)


def random_points(count, seed):
    random = np.random.default_rng(seed)
    return random.uniform(*WINDOW[0], count), np.exp(random.uniform(*np.log(WINDOW[1]), count))


def distance(zone, r, clearance):
    """To the nearest vertex of a boundary, the window being the unit square."""
    scale = np.array([np.ptp(zone.r), np.ptp(np.log(zone.clearance))])
    place = np.array([r, math.log(clearance)])
    rings = [np.c_[ring[:, 0], np.log(ring[:, 1])] for ring in zone.loops]
    return min((np.abs((ring - place) / scale).max(axis=1).min() for ring in rings), default=1.0)


def motion_at(zone, piece, j):
    """The exact motion of a vertex."""
    return newton(
        zone.osc, piece.r[j], piece.clearance[j], 1.0, zone.pattern,
        piece.x[:, j] * piece.clearance[j], piece.theta[:, j],
    )  # fmt: skip


def test_equispaced_zone_against_the_closed_form(equispaced):
    """10,000 points: the pair's own verdicts, away from the boundary."""
    r, clearance = random_points(10_000, 1)
    inside = equispaced.contains(r, clearance)
    wrong = []
    for a, b, answer in zip(r.tolist(), clearance.tolist(), inside.tolist(), strict=True):
        pair = vi.equispaced(FIGURE6, a, b)
        if any(m.stable and m.admissible for m in pair) != answer:
            wrong.append((a, b))
    assert 500 < inside.sum() < 9500
    # a wrong answer is one within the distance of the polygon from the curve
    assert all(distance(equispaced, *place) < 1e-6 for place in wrong), wrong


def test_a_wide_window_against_the_closed_form():
    """Two decades of r and five of d K/F0, where the lattice has to be denser about the resonance."""
    window = ((0.1, 10.0), (0.01, 1000.0))
    wide = vi.zone(FIGURE6, vi.Pattern("RL"), *window, symmetric=True)
    assert wide.closed
    assert min(wide.search.lines) > 30
    random = np.random.default_rng(8)
    r, clearance = (np.exp(random.uniform(*np.log(ends), 4000)) for ends in window)
    inside = wide.contains(r, clearance)
    wrong = []
    for a, b, answer in zip(r.tolist(), clearance.tolist(), inside.tolist(), strict=True):
        pair = vi.equispaced(FIGURE6, a, b)
        if any(m.stable and m.admissible for m in pair) != answer:
            wrong.append((a, b))
    assert 300 < inside.sum() < 3700
    assert all(distance(wide, *place) < 1e-6 for place in wrong), wrong


def test_progress_is_told():
    """From nothing to all, over both families of motions, and the answer is the same."""
    shares = []
    told = vi.zone(
        FIGURE6, vi.Pattern("RL"), *WINDOW, progress=lambda share, what: shares.append(share)
    )
    assert shares
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] == 1
    assert told.to_dict() == vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW).to_dict()


def test_zones_against_a_search(case):
    """Where a search finds a stable, admissible motion of the kind, and where it does not."""
    r, clearance = random_points(60, 2)
    for a, b in zip(r.tolist(), clearance.tolist(), strict=True):
        from vibroimpact import _core

        columns, n, _ = _core.search_pattern(
            case.osc.xi, case.osc.mu, case.osc.restitution, a, 1.0, b, 1, case.pattern.signs, 64, 64
        )
        count = len(case.pattern)
        found = False
        for column in columns[:, :n].T:
            try:
                motion = newton(case.osc, a, b, 1.0, case.pattern, column[:count], column[count:])
            except vi.errors.SingularError:
                continue
            if motion.stable and motion.admissible and is_symmetric(motion) == case.symmetric:
                found = True
        assert bool(case.contains(a, b)) == found or distance(case, a, b) < 1e-6, (a, b)


def test_vertices_meet_their_condition(case):
    """The defining multiplier or speed of each piece, by the other code."""
    assert case.closed
    for piece in case.boundary:
        for j in range(0, len(piece), max(1, len(piece) // 5)):
            if piece.type not in ("fold", "flip", "neimark_sacker"):
                continue
            try:
                multipliers = motion_at(case, piece, j).multipliers
            except vi.errors.SingularError:  # at a fold Newton's method need not converge
                continue
            if piece.type == "flip":
                assert np.abs(multipliers + 1).min() < 1e-7
            elif piece.type == "neimark_sacker":
                # near a double multiplier the modulus is a root of what is known
                if min(np.abs(multipliers - 1).min(), np.abs(multipliers + 1).min()) < 0.05:
                    continue
                turning = np.abs(multipliers.imag) > 1e-2
                if turning.any():
                    # moduli change by up to 1e3 per unit of r
                    assert np.abs(np.abs(multipliers[turning]) - 1).min() < 1e-6


def test_pieces_join_in_closed_rings(case):
    for loop, ring in enumerate(case.loops):
        pieces = [p for p in case.boundary if p.loop == loop]
        for one, other in zip(pieces, pieces[1:] + pieces[:1], strict=True):
            assert abs(one.r[-1] - other.r[0]) < 1e-9
            assert abs(one.clearance[-1] / other.clearance[0] - 1) < 1e-9
        assert len(ring) > 3
        assert np.isfinite(ring).all()
        assert signed_area(np.c_[ring[:, 0], np.log(ring[:, 1])]) != 0
    assert case.area > 0


def test_pitchfork_pieces_are_the_pitchfork_of_the_equispaced_motion():
    """The end of the unsymmetric motions, by the multiplier 1 of the closed form."""
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=False)
    pieces = [p for p in zone.boundary if p.type == "pitchfork"]
    assert pieces
    for piece in pieces:
        for r, clearance in zip(piece.r[::5], piece.clearance[::5], strict=True):
            pair = vi.equispaced(FIGURE6, float(r), float(clearance))
            assert min(np.abs(m.multipliers - 1).min() for m in pair) < 1e-7


def test_boundary_against_bisection(equispaced):
    """The leading multiplier of the closed form crosses the circle where the boundary is."""
    checked = 0
    for r in (0.9, 1.05, 1.15):
        grid = np.geomspace(2.1, 190, 400)

        def stable(clearance, r=r):
            return max(
                (1 - np.abs(m.multipliers).max() for m in vi.equispaced(FIGURE6, r, clearance)
                 if m.admissible), default=-1.0,
            )  # fmt: skip

        values = [stable(c) for c in grid]
        for low, high, a, b in zip(grid, grid[1:], values, values[1:], strict=False):
            if a * b < 0 and min(a, b) > -0.5:
                edge = brentq(stable, low, high, xtol=1e-12)
                assert bool(equispaced.contains(r, edge * (1 + 1e-6))) == (b > 0)
                assert bool(equispaced.contains(r, edge * (1 - 1e-6))) == (a > 0)
                checked += 1
    assert checked >= 2


def test_vertices_against_bisection(equispaced):
    """At the r of a vertex the closed form loses stability where the boundary is, to 1e-8."""
    checked = []
    for piece in equispaced.boundary:
        if piece.type not in ("pitchfork", "neimark_sacker"):
            continue
        # away from the ends, where a corner is near and another condition may come first
        for j in range(5, len(piece) - 5, 12):
            r, clearance, x = float(piece.r[j]), float(piece.clearance[j]), piece.x[0, j]

            def margin(clearance, r=r, x=x):
                motions = vi.equispaced(FIGURE6, r, clearance)
                nearest = min(motions, key=lambda m: abs(m.X[0] / m.clearance - x))
                return 1 - float(np.abs(nearest.multipliers).max())

            edge = brentq(margin, clearance * (1 - 1e-4), clearance * (1 + 1e-4), xtol=1e-13)
            assert abs(edge / clearance - 1) < 1e-8
            checked.append(piece.type)
    assert min(checked.count("pitchfork"), checked.count("neimark_sacker")) >= 4


def test_corners_meet_both_conditions(case):
    """Where two pieces meet, what is zero along each of them is zero."""
    names = {"fold", "flip", "neimark_sacker", "window"}
    checked = 0
    for piece in case.boundary:
        for other in case.boundary:
            same = (piece.r[-1], piece.clearance[-1]) == (other.r[0], other.clearance[0])
            if piece is other or piece.loop != other.loop or not same:
                continue
            assert (piece.type, piece.detail) != (other.type, other.detail)
            for kind, there in ((piece, len(piece) - 1), (other, 0)):
                if kind.type == "window":
                    values = {*case.r} if kind.detail.endswith(" r") else {*case.clearance}
                    value = kind.r[there] if kind.detail.endswith(" r") else kind.clearance[there]
                    assert min(abs(value / bound - 1) for bound in values) < 1e-12
            if not {piece.type, other.type} <= names:
                continue
            # from the phases: at a fold r and D tell a motion to the root of rounding only
            phases = piece.theta[:, -1] - piece.theta[0, -1]
            try:
                motion = vi.periodic(case.osc, piece.r[-1], phases, case.pattern)
            except vi.errors.SingularError:  # equispaced phases leave the clearance free
                continue
            assert abs(motion.clearance / piece.clearance[-1] - 1) < 1e-9
            multipliers = motion.multipliers
            pairs = [1 - a * b for i, a in enumerate(multipliers) for b in multipliers[:i]]
            zero = {
                "fold": np.prod(1 - multipliers),
                "flip": np.prod(1 + multipliers),
                "neimark_sacker": np.prod(pairs),
                "window": 0.0,
            }
            assert abs(zero[piece.type]) < 1e-7
            assert abs(zero[other.type]) < 1e-7
            checked += 1
    assert checked or case.pattern.sides == "RL"


def test_impacts_follow_each_other(case):
    """No flight takes a negative time: the equations have such roots, which are no motions."""
    for piece in case.boundary:
        assert (np.diff(piece.theta, axis=0) > 0).all()
        assert (piece.theta[-1] - piece.theta[0] < 2 * np.pi * case.pattern.cycles).all()


def corners(zone, edge):
    """Where an edge of the window cuts the zone: the lowest and highest ends of that piece."""
    (piece,) = [p for p in zone.boundary if p.detail == edge]
    ends = piece.clearance if edge.endswith(" r") else piece.r
    return sorted(ends[[0, -1]].tolist())


def unequispaced(r, second):
    """The motion whose second impact has a given phase: the paper's linear problem, no iteration."""
    return vi.periodic(FIGURE3, r, [0, second], vi.Pattern("RL"))


def test_the_very_narrow_zone_of_figure_3_at_resonance():
    """Its width in D at r = 1: from the flip to the pitchfork, both by bisection of a multiplier."""
    pattern = vi.Pattern("RL")
    zone = vi.zone(FIGURE3, pattern, (0.98, 1.02), (20, 60), symmetric=False)
    assert zone.closed
    assert len(zone.loops) == 1

    def flip(second):
        return float(np.real(unequispaced(1.0, second).multipliers).min() + 1)

    def pitchfork(clearance):
        motion = next(m for m in vi.equispaced(FIGURE3, 1.0, clearance) if m.admissible)
        real = motion.multipliers[np.abs(motion.multipliers.imag) < 1e-9].real
        return float(real.max() - 1)

    second = brentq(flip, 1.38 * math.pi, 1.41 * math.pi, xtol=1e-13)
    low = unequispaced(1.0, second).clearance
    high = brentq(pitchfork, 35.5, 36.0, xtol=1e-12)
    assert 0.006 < high / low - 1 < 0.0065
    # with r = 1 as an edge of the window, its corners are the very ends
    cut = vi.zone(FIGURE3, pattern, (1.0, 1.02), (20, 60), symmetric=False)
    np.testing.assert_allclose(corners(cut, "lowest r"), [low, high], rtol=1e-8)
    width = high - low
    np.testing.assert_array_equal(
        zone.contains(
            1.0, [low - 1e-3 * width, low + 1e-3 * width, high - 1e-3 * width, high + 1e-3 * width]
        ),
        [False, True, True, False],
    )
    largest = [
        np.abs(unequispaced(1.0, a).multipliers[0])
        for a in np.linspace(math.pi + 1e-3, second, 200)
    ]
    assert 0.98 < min(largest) < 0.99
    assert 0.9999 < max(largest) < 1 + 1e-12


def test_the_very_narrow_zone_of_figure_3_at_its_tip():
    """Its width in r at D = 37: from the flip to the fold, where r is stationary on the line D = 37."""

    def on_line(second):
        return brentq(lambda r: unequispaced(r, second).clearance - 37.0, 0.997, 0.9995, xtol=1e-15)

    def flip(second):
        return float(np.real(unequispaced(on_line(second), second).multipliers).min() + 1)

    second = brentq(flip, 1.38 * math.pi, 1.41 * math.pi, xtol=1e-13)
    fold = minimize_scalar(
        lambda a: -on_line(a), bounds=(1.35 * math.pi, 1.385 * math.pi), method="bounded", options={"xatol": 1e-7},
    )  # fmt: skip
    low, high = on_line(second), -fold.fun
    assert 5e-6 < high - low < 7e-6
    zone = vi.zone(FIGURE3, vi.Pattern("RL"), (0.98, 1.02), (20, 37), symmetric=False)
    np.testing.assert_allclose(corners(zone, "highest d K/F0"), [low, high], rtol=0, atol=1e-10)
    for share in (0.1, 0.5, 0.9):
        motion = unequispaced(
            on_line(second + share * (fold.x - second)), second + share * (fold.x - second)
        )
        assert motion.stable
        assert 0.99 < np.abs(motion.multipliers[0]) < 1


@pytest.mark.parametrize(
    ("xi", "mu", "restitution"),
    [
        (4.0626886423228203e-02, 0.12512331964573317, 0.68306655697676577),
        (5.8715467556254798e-03, 0.10542967208554099, 0.46245902839207498),
    ],
)
def test_zones_close_where_a_fold_leaves_a_pitchfork(xi, mu, restitution):
    """There the equations are met to rounding long before the place is known as well as that."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    zone = vi.zone(osc, vi.Pattern("RL"), (0.7, 1.4), (1, 150), symmetric=False)
    assert zone.closed
    pieces = [(p.loop, p.type) for p in zone.boundary]
    assert any((loop, "pitchfork") in pieces for loop, kind in pieces if kind == "fold")


def impact_pair_limits(restitution, cycles):
    """D/A at the pitchfork and at the fold of the symmetric motion of the impact pair.

    For mu = 0 the primary mass follows X = A sin(theta), theta = r t + tau, whatever the impacts do. The free
    mass flies with speed w from the right wall to the left one, and back; k cycles and half of them between.
    An impact at the right wall at theta = p and the flight that follows say, with V = A r cos(p),
        w = R w - (1 + R) V,   2 A sin(p) + D = k pi w/r,
    so cos(p) + 2 q sin(p) = -q D/A with q = (1 - R)/((1 + R) k pi). Two solutions merge where
        D/A = sqrt(1 + 4 q^2)/q                                                               (fold).
    The mirrored map of half a period takes (p, w) to (p', w') by
        A sin(p) + A sin(p') + D = w (p' + k pi - p)/r,   w' = R w - (1 + R) A r cos(p');
    its derivative at the motion has determinant R^2 and trace
        2 R - (1 + R)^2 (k pi)^2 A sin(p)/(2 (2 A sin(p) + D)).
    A determinant below 1 leaves the multipliers 1 (trace 1 + R^2: the fold again) and -1 (trace -(1 + R^2)):
    there A sin(p) ((k pi)^2 - 4) = 2 D, and the equation of the motion makes that
        D/A = ((k pi)^2 - 4)/sqrt(4 + q^2 (k pi)^4)                                      (pitchfork).
    Between the two the motion is stable; the multipliers of the primary mass have modulus exp(-2 pi xi k/r).
    """
    turn = cycles * math.pi
    q = (1 - restitution) / ((1 + restitution) * turn)
    return (turn**2 - 4) / math.sqrt(4 + q**2 * turn**4), math.sqrt(1 + 4 * q**2) / q


@pytest.mark.parametrize(
    ("xi", "restitution", "cycles", "r", "clearance"),
    [
        (0.0114, 0.75, 1, (0.5, 1.5), (2, 200)),
        (0.05, 0.4, 1, (0.7, 1.6), (1, 100)),
        (0.02, 0.9, 1, (1.1, 3.0), (0.2, 60)),
        (0.0015, 0.51, 3, (1.05, 1.6), (2, 300)),
        # a strip of the window that few lattice lines cross
        (3e-4, 0.334, 1, (0.964, 1.03), (1043.61, 4761.32)),
        # the edge D = lowest cuts the fold, where a line of the lattice ends
        (0.0157, 0.5505, 1, (0.995957, 1.0267805), (184.547, 2606.0)),
        (8.68e-4, 0.844, 1, (0.952184, 1.021977), (918.674, 9452.587)),
    ],
)
def test_impact_pair_against_its_closed_form(xi, restitution, cycles, r, clearance):
    osc = vi.Oscillator(xi=xi, mu=0.0, restitution=restitution)
    zone = vi.zone(osc, vi.Pattern("RL", cycles), r, clearance, symmetric=True)
    limits = dict(zip(("pitchfork", "fold"), impact_pair_limits(restitution, cycles), strict=True))
    assert zone.closed
    assert zone.boundary

    def over_amplitude(r, clearance):
        return clearance * np.hypot(1 - r**2, 2 * xi * r)

    for piece in zone.boundary:
        assert piece.type in {*limits, "window"}
        if piece.type in limits:
            ratio = over_amplitude(piece.r, piece.clearance)
            np.testing.assert_allclose(ratio, limits[piece.type], rtol=1e-8)
    random = np.random.default_rng(5)
    places = random.uniform(*r, 5000), np.exp(random.uniform(*np.log(clearance), 5000))
    ratio = over_amplitude(*places)
    wanted = (ratio > limits["pitchfork"]) & (ratio < limits["fold"])
    assert 100 < wanted.sum() < 4950
    wrong = np.flatnonzero(zone.contains(*places) != wanted)
    assert all(distance(zone, places[0][i], places[1][i]) < 1e-6 for i in wrong)


GRAZING = [
    (vi.Oscillator(xi=0.05, mu=0.3, restitution=0.6), vi.Pattern("RRL"), (0.8, 1.2), (2, 200)),
    (vi.Oscillator(xi=0.05, mu=0.3, restitution=0.6), vi.Pattern("RL", 3), (0.3, 0.7), (0.5, 50)),
    (FIGURE6, vi.Pattern("RL"), (0.3, 0.7), (0.5, 50)),
    (FIGURE8, vi.Pattern("RRLL"), (0.3, 0.7), (0.5, 50)),
]


def letters_from(motion, cycles):
    """Sides of the impacts of a simulation that starts just after the first impact of a motion."""
    state = {
        "t": motion.load_phase / motion.r, "x": motion.X[0], "x_dot": motion.X_dot_after[0],
        "z": motion.Z[0], "z_dot": motion.Z_dot_after[0],
    }  # fmt: skip
    run = vi.simulate(motion.osc, motion.r, motion.clearance, cycles, state=state)
    return "".join(run.events["side"][run.events["kind"] == "impact"].tolist())


@pytest.mark.parametrize(("osc", "pattern", "r", "clearance"), GRAZING)
def test_grazing_pieces_against_simulation(osc, pattern, r, clearance):
    """Across the piece, along r and along D: the pattern lasts inside, outside there is one impact more."""
    zone = vi.zone(osc, pattern, r, clearance)
    pieces = [p for p in zone.boundary if p.type == "grazing" and len(p) > 6]
    assert pieces
    n, k = len(pattern), pattern.cycles
    for piece in pieces:
        flight, side = int(piece.detail.split()[1]), piece.detail[-1]
        longer = pattern.sides[:flight] + side + pattern.sides[flight:]
        j = 3 * len(piece) // 4  # a fold can be near an end: there, motions exist on one side alone
        for step in (np.array([1e-5, 0]), np.array([0, 1e-5])):
            verdicts = []
            for sign in (1, -1):
                a, b = np.array([piece.r[j], piece.clearance[j]]) * (1 + sign * step)
                motion = newton(osc, a, b, 1.0, pattern, piece.x[:, j] * b, piece.theta[:, j])
                assert motion.stable
                verdicts.append(motion.admissible)
                if motion.admissible:
                    letters = letters_from(motion, 200 * k)
                    wanted = (pattern.sides * 201)[1:]
                    assert letters == wanted[: len(letters)]
                    assert len(letters) >= 200 * n - 1
                else:
                    letters = letters_from(motion, k)
                    assert letters[:flight] == longer[1 : flight + 1]
                assert zone.contains(a, b) == motion.admissible
            assert sorted(verdicts) == [False, True]


def test_mirror_images_have_the_same_zone():
    one, other = (vi.zone(FIGURE6, vi.Pattern(s), *WINDOW) for s in ("RRL", "LLR"))
    assert abs(one.area - other.area) < 1e-6 * one.area
    r, clearance = random_points(2000, 3)
    np.testing.assert_array_equal(one.contains(r, clearance), other.contains(r, clearance))


def test_exchanged_walls_exchange_the_zones():
    swapped = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.61, 0.75))
    one = vi.zone(FIGURE8, vi.Pattern("RLL"), *WINDOW)
    other = vi.zone(swapped, vi.Pattern("RRL"), *WINDOW)
    r, clearance = random_points(2000, 4)
    np.testing.assert_array_equal(one.contains(r, clearance), other.contains(r, clearance))


def test_impact_without_restitution_ends_where_rest_begins():
    """R = 0: on the boundary the masses part with no acceleration."""
    osc = vi.Oscillator(xi=0.019, mu=0.0114, restitution=(0.0, 0.22))
    zone = vi.zone(osc, vi.Pattern("RL"), (1.15, 2.28), (0.64, 2.32))
    pieces = [p for p in zone.boundary if p.type == "rest_vanishes"]
    assert pieces
    for piece in pieces:
        motion = motion_at(zone, piece, len(piece) // 2)
        times = np.array([0.0, 1e-4, 2e-4])
        speed = motion.sample(times).X_dot
        assert abs(speed[1] - speed[0]) < 1e-6 * motion.clearance


def test_nothing_is_stable_without_loss():
    osc = vi.Oscillator(xi=0.0, mu=0.03, restitution=1.0)
    zone = vi.zone(osc, vi.Pattern("RL"), (1.1, 2.0), (1, 10))
    assert not zone
    assert zone.closed


def test_file_and_repetition(case):
    again = vi.Zone.from_dict(json.loads(json.dumps(case.to_dict())))
    assert again.to_dict() == case.to_dict()
    twice = vi.zone(case.osc, case.pattern, *WINDOW, symmetric=case.symmetric)
    assert json.dumps(twice.to_dict()) == json.dumps(case.to_dict())


def test_count_and_shapes(equispaced):
    assert equispaced.contains(1.04, [25.0, 3.0]).tolist() == [True, False]
    assert equispaced.count([[1.04], [0.5]], [25.0, np.nan, -1.0]).tolist() == [[1, 0, 0], [0] * 3]


def test_budget_is_told():
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), *WINDOW, symmetric=True, max_points=100)
    assert not zone.closed
    assert "NOT closed" in repr(zone)


def test_plot_draws_the_pieces(equispaced):
    plt = pytest.importorskip("matplotlib.pyplot")
    ax = equispaced.plot(inverse=True)
    lines = [line.get_xydata() for line in ax.get_lines()]
    for piece in equispaced.boundary:
        if piece.type != "window":
            data = np.c_[piece.r, 1 / piece.clearance]
            assert any(item.shape == data.shape and np.array_equal(item, data) for item in lines)
    plt.close("all")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"r": (1.2, 0.8)}, r"r = \(1.2, 0.8\)"),
        ({"r": (1.0, 1.0)}, r"r = \(1.0, 1.0\)"),
        ({"r": (math.nan, 1.0)}, r"r\[0\] = nan"),
        ({"clearance": 3.0}, "clearance = 3.0"),
        ({"pattern": vi.Pattern("RRL"), "symmetric": True}, "symmetric = True"),
        ({"lines": 4}, "lines = 4"),
        ({"guesses": -1}, "guesses = -1"),
        ({"max_points": 5}, "max_points = 5"),
        ({"pattern": vi.Pattern("RL" * 13)}, "26 impacts"),
        ({"seeds": [3]}, r"seeds\[0\] = 3"),
    ],
)
def test_bad_input(arguments, words):
    given = {"pattern": vi.Pattern("RL"), "r": WINDOW[0], "clearance": WINDOW[1], **arguments}
    with pytest.raises(vi.errors.VibroimpactError, match=words):
        vi.zone(FIGURE6, **given)


def test_seed_of_another_pattern():
    seed = vi.equispaced(FIGURE6, 1.04, 25.0)[0]
    with pytest.raises(vi.errors.ParameterError, match=r"seeds\[0\].pattern"):
        vi.zone(FIGURE6, vi.Pattern("RRL"), *WINDOW, seeds=[seed])


def test_an_interrupt_is_heard_within_a_call():
    """Ctrl-C ends a long zone at once, not when the core is done."""
    code = (
        "import vibroimpact as vi; print('begin', flush=True); "
        "vi.zone(vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.5), vi.Pattern('R*L*'), (0.5, 1.2), (0.5, 10))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline() == "begin\n"
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert said.splitlines()[-1] == "KeyboardInterrupt"


@pytest.mark.parametrize("symmetric", ["yes", 2])
def test_symmetric_is_one_of_three(symmetric):
    with pytest.raises(vi.errors.ParameterError, match=r"^symmetric = "):
        vi.zone(
            vi.Oscillator(xi=0.01, mu=0.03, restitution=0.75), vi.Pattern("RL"), (0.8, 1.2), (2, 200),
            symmetric=symmetric,
        )  # fmt: skip
