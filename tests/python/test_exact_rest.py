"""Exact motions with accumulation and rest."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import rest_motion
from shared_simulations import STATE, state
from shared_systems import RIG


def test_motion_with_completed_chatter():
    """The example is a motion RL*: one impact, one accumulation with rest, residual at rounding."""
    motion = rest_motion()
    assert motion.pattern.cycles == 1
    assert sorted(motion.pattern.letters) == ["L*", "R"]
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
    """Two come from the plane of releases, two are the zeros that the accumulation brings.

    The 4 x 4 derivative of the stroboscopic map of (x, x', z, z') by differences has the same.
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
    """Started at a state of the exact motion, impacts, sticks and releases repeat for 1000 cycles."""
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
    """A motion with rest is a guess too; lengths scale with the load."""
    motion = rest_motion()
    near = vi.exact(RIG, 0.901, 6.02, motion)
    back = vi.exact(RIG, 0.9, 6.0, near)
    assert near.pattern == motion.pattern
    assert back.phases == pytest.approx(motion.phases, abs=1e-9)
    assert back.multipliers == pytest.approx(motion.multipliers, abs=1e-7)
    double = vi.exact(
        RIG, 0.9, 12.0, vi.simulate(RIG, 0.9, 12.0, 8, load=2.0, discard=300), load=2.0
    )
    assert double.X == pytest.approx(2 * motion.X, abs=1e-8)
    assert double.multipliers == pytest.approx(motion.multipliers, abs=1e-7)


def test_rest_motion_has_no_impact_maps():
    """An accumulation has infinitely many impacts: no list of [P_i], and an error that says so."""
    with pytest.raises(vi.errors.ParameterError, match="rest"):
        rest_motion().impact_maps()
