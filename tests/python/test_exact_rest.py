"""Exact motions with accumulation and rest."""

import contextlib

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import rest_motion
from shared_simulations import STATE, state
from shared_systems import RIG
from vibroimpact.motions.exact import release_motion


def test_motion_with_completed_chatter():
    """The example is a motion RL*: one impact, one accumulation with rest, residual at rounding."""
    motion = rest_motion()
    assert motion.pattern.cycles == 1
    assert sorted(motion.pattern.symbols) == ["L*", "R"]
    assert motion.residual <= 1e-12
    assert motion.consistent
    assert motion.admissible
    assert motion.stable
    assert "stable" in repr(motion)
    kinds = motion.events["kind"].tolist()
    assert kinds.count("stick") == kinds.count("release") == 1
    run = vi.simulate(RIG, 0.9, 6.0, 1, discard=400)
    assert kinds.count("impact") == (run.events["kind"] == "impact").sum()
    h = motion.sample(np.linspace(0, motion.period, 4001))
    assert np.abs(h.Y).max() <= 3.0 + 1e-12
    assert h.X.max() <= motion.x_max + 1e-12
    assert h.X.min() >= motion.x_min - 1e-12
    assert motion.x_max == pytest.approx(h.X.max(), abs=1e-4)
    assert motion.x_min == pytest.approx(h.X.min(), abs=1e-4)


def strobe(osc, r, clearance, base, change):
    """State one load period after a changed state."""
    first = dict(
        zip(
            STATE,
            [base["t"], *[base[k] + d for k, d in zip(STATE[1:], change, strict=True)]],
            strict=True,
        )
    )
    end = vi.simulate(osc, r, clearance, 1, first).final_state
    return np.array([end[name] for name in STATE[1:]])


def strobe_matrix(osc, r, clearance, base, size):
    """Derivative of the stroboscopic map by differences with Richardson's step to order six."""
    columns = []
    for j in range(4):
        slopes = []
        for h in (size, size / 2, size / 4):
            change = np.eye(4)[j] * h
            up, down = (strobe(osc, r, clearance, base, s * change) for s in (1, -1))
            slopes.append((up - down) / (2 * h))
        fine, coarse = (4 * slopes[2] - slopes[1]) / 3, (4 * slopes[1] - slopes[0]) / 3
        columns.append((16 * fine - coarse) / 15)
    return np.array(columns).T


def test_multipliers_of_a_motion_with_rest():
    """Two multipliers are those of the map of releases; the accumulation makes the other two zero.

    The 4 x 4 derivative of the stroboscopic map of (x, x', z, z'), by differences, has the same eigenvalues.
    """
    motion = rest_motion()
    release = motion.events[motion.events["kind"] == "release"][0]
    start = float(np.mod(release["time"] + 0.4, motion.period))
    h = motion.sample(start)
    base = state(
        (release["phase"] + 0.4 * motion.r) / motion.r,
        float(h.X),
        float(h.X_dot),
        float(h.Z),
        float(h.Z_dot),
    )
    assert strobe(RIG, 0.9, 6.0, base, np.zeros(4)) == pytest.approx(
        [base[name] for name in STATE[1:]], abs=1e-10
    )
    values = np.linalg.eigvals(strobe_matrix(RIG, 0.9, 6.0, base, 2e-3))
    values = values[np.argsort(-np.abs(values))]
    assert np.array_equal(motion.multipliers[2:], [0, 0])
    assert np.sort_complex(values[:2]) == pytest.approx(
        np.sort_complex(motion.multipliers[:2]), abs=1e-6
    )
    assert np.abs(values[2:]).max() < 1e-3
    assert np.prod(np.abs(values[2:])) < 1e-6


def test_simulation_stays_on_the_motion_with_rest():
    """From a state of the exact motion, a simulation repeats impacts, sticks and releases for 1000 cycles."""
    motion = rest_motion()
    release = motion.events[motion.events["kind"] == "release"][0]
    h = motion.sample(float(np.mod(release["time"] + 0.4, motion.period)))
    first = state(release["phase"] / 0.9 + 0.4, *(float(h[i]) for i in range(4)))
    run = vi.simulate(RIG, 0.9, 6.0, 1000, first)
    for kind in ("stick", "release"):
        phases = run.events["phase"][run.events["kind"] == kind]
        want = motion.events["phase"][motion.events["kind"] == kind][0]
        assert phases.size in (999, 1000, 1001)
        assert phases == pytest.approx(want, abs=1e-9)


def test_rest_motion_from_a_motion_nearby_and_at_another_load():
    """A motion with rest can be the guess; lengths scale with the load."""
    motion = rest_motion()
    near = vi.exact(RIG, 0.901, 6.02, motion)
    back = vi.exact(RIG, 0.9, 6.0, near)
    assert near.pattern == motion.pattern
    assert back.alpha == pytest.approx(motion.alpha, abs=1e-9)
    assert back.multipliers == pytest.approx(motion.multipliers, abs=1e-7)
    double = vi.exact(
        RIG, 0.9, 12.0, vi.simulate(RIG, 0.9, 12.0, 8, load=2.0, discard=300), load=2.0
    )
    assert double.X == pytest.approx(2 * motion.X, abs=1e-8)
    assert double.multipliers == pytest.approx(motion.multipliers, abs=1e-7)


@pytest.mark.parametrize("factor", [10.0, 1000.0, 1e-3])
def test_guesses_with_rest_scale_with_the_load(factor):
    """With load and clearance times a factor lengths scale; a guess (motion or trajectory) is scaled too."""
    motion = rest_motion()
    for guess in (motion, vi.simulate(RIG, 0.9, 6.0, 8, discard=300)):
        other = vi.exact(RIG, 0.9, 6.0 * factor, guess, load=factor)
        assert other.pattern == motion.pattern
        assert other.alpha == pytest.approx(motion.alpha, abs=1e-9)
        assert other.X / factor == pytest.approx(motion.X, abs=1e-8)
        assert other.multipliers == pytest.approx(motion.multipliers, abs=1e-7)


def test_a_guess_with_rest_serves_at_other_clearances():
    """One motion is a sufficient guess at every clearance of its zone, which ends at D = 1.345."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    (guess,) = [m for m in vi.find(osc, 0.55, 1.45, 3, 1) if m.pattern.sides == "RL*"]
    for clearance in (1.42, 1.4, 1.37, 1.35, 1.347):
        motion = vi.exact(osc, 0.55, clearance, guess)
        assert motion.pattern.sides == "RL*"
        assert motion.stable
    zone = vi.zone(osc, guess.pattern, (0.5, 0.6), (1.0, 2.0))
    assert zone.contains(0.55, [1.344, 1.347, 1.45]).tolist() == [False, True, True]


def test_rest_motion_has_no_impact_maps():
    """A list of [P_i] is refused, because an accumulation has infinitely many impacts."""
    with pytest.raises(vi.errors.ParameterError, match="rest"):
        rest_motion().impact_maps()


def starts_near(zone, kind, offset):
    """Motions from many guesses near a vertex of a piece; the clearance differs from the vertex by a fraction."""
    piece = max((p for p in zone.boundary if p.type == kind), key=len)
    i = len(piece) // 2
    r, edge = float(piece.r[i]), float(piece.clearance[i])
    release = np.array([piece.theta[0, i], piece.x_over_D[0, i] * edge])
    draw, found = np.random.default_rng(4), []
    for _ in range(30):
        guess = release * (1 + 1e-5 * draw.normal(size=2))
        with contextlib.suppress(vi.errors.SingularError):
            start = np.array([-1, *guess])[:, None]
            found.append(release_motion(zone.osc, r, edge * (1 + offset), 1.0, 1, start))
    return found


@pytest.fixture(scope="module")
def zone_with_folds():
    """Motions RRRL*, with a fold and a Neimark-Sacker bifurcation."""
    osc = vi.Oscillator(xi=0.00359, mu=0.05224, restitution=(0.6257, 0.371))
    return vi.zone(osc, vi.Pattern("RRRL*"), (0.9, 1.1), (2, 20))


@pytest.mark.parametrize("offset", [-1e-7, -1e-9, -1e-10, -1e-11, 1e-15, 1e-12, 1e-11, 1e-10, 1e-9])
def test_no_verdict_beside_a_fold_where_starts_disagree(offset, zone_with_folds):
    """Near a fold, where multipliers from different starts scatter about the unit circle, `stable` is None.

    Beyond the fold there is no motion, but Newton's method stops where the equations are solved to rounding.
    """
    found = starts_near(zone_with_folds, "fold", offset)
    assert offset > 0 or len(found) > 10
    for side in (-1, 1):
        distance = [abs(m.multipliers[0]) - 1 for m in found]
        group = [m for m, d in zip(found, distance, strict=True) if side * d > 0]
        distance = [d for d in distance if side * d > 0]
        if len(group) < 3:
            continue
        scatter = np.ptp(distance) / abs(np.median(distance))
        verdicts = {m.stable for m in group}
        if scatter > 0.5 and offset > 0:
            assert verdicts == {None}
        if scatter < 1e-3:
            assert verdicts == {side < 0}
        assert (side > 0) not in verdicts


@pytest.mark.parametrize("kind", ["fold", "neimark_sacker"])
def test_on_the_unit_circle_nothing_is_decided(kind, zone_with_folds):
    """With a leading multiplier on the unit circle to rounding, `stable` is None."""
    near = [
        motion
        for offset in np.linspace(-2e-14, 2e-14, 5)
        for motion in starts_near(zone_with_folds, kind, offset)
    ]
    assert near
    assert {m.stable for m in near if abs(abs(m.multipliers[0]) - 1) < 2e-13} <= {None}
    if kind == "neimark_sacker":
        assert min(abs(abs(m.multipliers[0]) - 1) for m in near) < 2e-13


def test_a_period_that_does_not_close_is_not_admissible(zone_with_folds):
    """A solution with a residual above 1e-9, as from some starts beyond the fold, is not called admissible."""
    found = [
        motion
        for offset in np.geomspace(1e-10, 1e-7, 10)
        for motion in starts_near(zone_with_folds, "fold", offset)
    ]
    open_ends = [motion for motion in found if motion.residual > 1e-9]
    assert open_ends
    for motion in found:
        assert motion.consistent == (motion.residual <= 1e-9)
        assert motion.admissible == (True if motion.consistent else None)
