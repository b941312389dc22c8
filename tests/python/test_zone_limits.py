"""Zones at their limits: very narrow zones, mu = 0, R = 0, a fold that leaves a pitchfork."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from scipy.optimize import brentq, minimize_scalar
from shared_systems import TABLE
from shared_zones import distance, motion_at


def corners(zone, edge):
    """The lowest and highest ends of the piece at which an edge of the window cuts the zone."""
    (piece,) = [p for p in zone.boundary if p.detail == edge]
    ends = piece.clearance if edge.endswith(" r") else piece.r
    return sorted(ends[[0, -1]].tolist())


def unequispaced(r, second):
    """The motion whose second impact has a given phase, by the linear problem of the paper, without iteration."""
    return vi.periodic(TABLE, r, [0, second], vi.Pattern("RL"))


def test_the_very_narrow_zone_of_figure_3_at_resonance():
    """The width in D at r = 1 is the distance from flip to pitchfork, both by bisection of a multiplier."""
    pattern = vi.Pattern("RL")
    zone = vi.zone(TABLE, pattern, (0.98, 1.02), (20, 60), symmetric=False)
    assert zone.closed
    assert len(zone.loops) == 1

    def flip(second):
        return float(np.real(unequispaced(1.0, second).multipliers).min() + 1)

    def pitchfork(clearance):
        motion = next(m for m in vi.equispaced(TABLE, 1.0, clearance) if m.admissible)
        real = motion.multipliers[np.abs(motion.multipliers.imag) < 1e-9].real
        return float(real.max() - 1)

    second = brentq(flip, 1.38 * math.pi, 1.41 * math.pi, xtol=1e-13)
    low = unequispaced(1.0, second).clearance
    high = brentq(pitchfork, 35.5, 36.0, xtol=1e-12)
    assert 0.006 < high / low - 1 < 0.0065
    # with r = 1 as an edge of the window, the corners of the zone are these ends
    cut = vi.zone(TABLE, pattern, (1.0, 1.02), (20, 60), symmetric=False)
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
    """The width in r at D = 37 is the distance from the flip to the fold, where r is stationary on this line."""

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
    zone = vi.zone(TABLE, vi.Pattern("RL"), (0.98, 1.02), (20, 37), symmetric=False)
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
    """Zones close although near that point the equations hold to rounding over a wide range of positions."""
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    zone = vi.zone(osc, vi.Pattern("RL"), (0.7, 1.4), (1, 150), symmetric=False)
    assert zone.closed
    pieces = [(p.loop, p.type) for p in zone.boundary]
    assert any((loop, "pitchfork") in pieces for loop, kind in pieces if kind == "fold")


def impact_pair_limits(restitution, cycles):
    """D/A at the pitchfork and at the fold of the symmetric motion of the impact pair.

    For mu = 0 the primary mass follows X = A sin(theta), theta = r t + tau, independent of the impacts. The free
    mass flies with speed w from the right wall to the left one in k/2 cycles, and back.
    An impact at the right wall at theta = p and the next flight give, with V = A r cos(p),
        w = R w - (1 + R) V,   2 A sin(p) + D = k pi w/r,
    so cos(p) + 2 q sin(p) = -q D/A with q = (1 - R)/((1 + R) k pi). Two solutions merge where
        D/A = sqrt(1 + 4 q^2)/q                                                               (fold).
    The mirrored map of half a period takes (p, w) to (p', w') by
        A sin(p) + A sin(p') + D = w (p' + k pi - p)/r,   w' = R w - (1 + R) A r cos(p');
    its derivative at the motion has determinant R^2 and trace
        2 R - (1 + R)^2 (k pi)^2 A sin(p)/(2 (2 A sin(p) + D)).
    A determinant below 1 leaves the multipliers 1 (trace 1 + R^2: the fold again) and -1 (trace -(1 + R^2)):
    there A sin(p) ((k pi)^2 - 4) = 2 D, which with the equation of the motion gives
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


def test_impact_without_restitution_ends_where_rest_begins():
    """With R = 0 the relative acceleration after the impact is zero on the boundary."""
    osc = vi.Oscillator(xi=0.019, mu=0.0114, restitution=(0.0, 0.22))
    zone = vi.zone(osc, vi.Pattern("RL"), (1.15, 2.28), (0.64, 2.32))
    pieces = [p for p in zone.boundary if p.type == "rest_vanishes"]
    assert pieces
    for piece in pieces:
        motion = motion_at(zone, piece, len(piece) // 2)
        times = np.array([0.0, 1e-4, 2e-4])
        speed = motion.sample(times).X_dot
        assert abs(speed[1] - speed[0]) < 1e-6 * motion.clearance


def test_a_closed_curve_between_the_lattice_lines_is_gone_round_once():
    """The tracing of a closed curve between lattice lines ends, and more lines give the same zone."""
    osc = vi.Oscillator(xi=0.0202, mu=0.108, restitution=(0.79, 0.81))
    window = (0.4280966277871413, 2.7493171322070333), (2.0, 200.0)
    zones = [vi.zone(osc, vi.Pattern("RL"), *window, lines=n, guesses=4) for n in (5, 17)]
    assert zones[0].area == pytest.approx(zones[1].area, rel=1e-7)
