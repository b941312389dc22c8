"""Branch switching at a flip, a pitchfork and a grazing, compared with simulation."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import pair_motion
from shared_systems import FIGURE6


def settles_on(motion):
    """Whether a simulation from a perturbed motion returns to it."""
    i = 0
    state = {
        "t": motion.load_phase / motion.r,
        "x": motion.X[i] * (1 + 1e-7),
        "x_dot": motion.X_dot_after[i],
        "z": motion.Z[i] + motion.X[i] * 1e-7,
        "z_dot": motion.Z_dot_after[i],
    }
    n = len(motion.pattern)
    run = vi.simulate(motion.osc, motion.r, motion.clearance, 3000, state=state)
    events = run.events[run.events["kind"] == "impact"]
    last = events[-n:]["x"]
    return min(np.abs(np.roll(last, j) - motion.X).max() for j in range(n)) < (
        1e-4 * motion.clearance
    )


def test_switching_at_a_flip():
    """The doubled motion is exact, has twice the period, and is as stable as its simulation."""
    branch = vi.branch(pair_motion(), "clearance", (10, 60))
    flip = next(p for p in branch.special_points if p.type == "flip")
    (doubled,) = flip.switch()
    assert doubled.pattern == vi.Pattern("RLRL", 2)
    assert doubled.residual < 1e-12
    assert np.abs(doubled.X[:2] - doubled.X[2:]).max() > 1e-4 * doubled.clearance
    # supercritical: where the simple motion is unstable the doubled one is stable
    simple = vi.exact(doubled.osc, doubled.r, doubled.clearance, flip.motion)
    assert doubled.stable != simple.stable
    assert settles_on(doubled) == doubled.stable


def test_a_motion_is_lost_beyond_its_flip():
    """Where the doubled motion has ended, Newton's method finds the simple one twice: an error instead."""
    branch = vi.branch(pair_motion(), "clearance", (10, 60))
    flip = next(p for p in branch.special_points if p.type == "flip")
    (doubled,) = flip.switch()
    osc, r = doubled.osc, doubled.r
    nearer, beyond = (
        flip.clearance + share * (doubled.clearance - flip.clearance) for share in (0.9, -1.0)
    )
    assert vi.exact(osc, r, nearer, doubled).pattern == doubled.pattern
    with pytest.raises(vi.SingularError, match=r"shorter period: .* beyond the flip"):
        vi.exact(osc, r, beyond, doubled)
    # presumed phases are not a motion: the simple motion twice is a solution of this pattern
    phases = (doubled.alpha, doubled.pattern)
    twice = vi.exact(osc, r, beyond, phases)
    assert vi.standard_motion(twice).pattern == vi.Pattern("RL")
    assert vi.exact(osc, r, nearer, twice).pattern == doubled.pattern


def test_a_motion_is_lost_beyond_its_pitchfork():
    """Where a pair of mirror images has ended, Newton's method finds the symmetric motion: an error."""
    motion = pair_motion()
    branch = vi.branch(motion, "r", (0.9, motion.r + 0.001))
    fork = next(p for p in branch.special_points if p.type == "pitchfork")
    near, beyond = fork.r + 0.005, fork.r - 0.005
    assert not vi.is_symmetric(vi.exact(motion.osc, near, motion.clearance, motion))
    with pytest.raises(vi.SingularError, match=r"its own mirror image: .* beyond the pitchfork"):
        vi.exact(motion.osc, beyond, motion.clearance, motion)
    symmetric = vi.equispaced(motion.osc, fork.r, motion.clearance)[0]
    assert vi.is_symmetric(vi.exact(motion.osc, beyond, motion.clearance, symmetric))


def test_switching_where_a_doubled_branch_ends():
    """Switching at the end of a doubled branch gives motions of that branch."""
    (doubled,) = next(
        p
        for p in vi.branch(pair_motion(), "clearance", (10, 60)).special_points
        if p.type == "flip"
    ).switch()
    branch = vi.branch(doubled, "clearance", (10, 60))
    end = next(
        point for point in branch.special_points
        if point.type == "flip" and np.abs(point.motion.X[:2] - point.motion.X[2:]).max() < 1e-3
    )  # fmt: skip
    (again,) = end.switch()
    assert again.pattern == doubled.pattern
    assert again.residual < 1e-12
    # the branch has the same motion at the same clearance
    there = vi.branch(doubled, "clearance", (again.clearance, 60))
    gaps = [
        np.abs(np.roll(again.X, j) - there.X[:, i]).max()
        for i in (0, len(there) - 1)
        for j in (0, 2)
    ]
    assert min(gaps) < 1e-8 * again.clearance


def test_switching_at_a_pitchfork():
    """Two mirror images on one side of the point; they are stable where the symmetric one is not."""
    branch = vi.branch(vi.equispaced(FIGURE6, 1.04, 25.0)[0], "clearance", (3, 60))
    branches = [branch, vi.branch(vi.equispaced(FIGURE6, 1.04, 25.0)[1], "clearance", (3, 60))]
    points = [p for b in branches for p in b.special_points if p.type == "pitchfork"]
    assert points
    one, other = points[0].switch()
    assert one.residual < 1e-12
    assert other.residual < 1e-12
    np.testing.assert_allclose(np.sort(one.X), np.sort(-other.X), atol=1e-10 * one.clearance)
    x = points[0].motion.X[0] / points[0].clearance
    symmetric = min(
        vi.equispaced(FIGURE6, one.r, one.clearance), key=lambda m: abs(m.X[0] / m.clearance - x)
    )
    assert one.stable == other.stable
    assert one.stable != symmetric.stable
    # followed back, they end at the same point
    back = vi.branch(one, "clearance", (3, 60))
    ends = [p for p in back.special_points if p.type == "pitchfork"]
    assert min(abs(p.clearance / points[0].clearance - 1) for p in ends) < 1e-8


def test_switching_at_grazing_adds_an_impact():
    branch = vi.branch(pair_motion(), "clearance", (10, 60))
    point = next(p for p in branch.special_points if p.type == "grazing")
    for motion in point.switch():
        assert len(motion.pattern) == 3
        assert motion.residual < 1e-12
        assert motion.admissible


@pytest.mark.parametrize("parameter", ["clearance", "r", "mu"])
def test_switching_at_a_grazing_of_a_symmetric_motion(parameter):
    """Both walls are grazed at once: branches with one more impact, or a mirrored pair of them, start there."""
    osc = vi.Oscillator(xi=0.05, mu=0.3, restitution=0.6)
    start = next(m for m in vi.equispaced(osc, 0.36, 2.2) if m.admissible)
    bounds = {"clearance": (1.1, 4.4), "r": (0.342, 0.378), "mu": (0.21, 0.39)}[parameter]
    points = vi.branch(start, parameter, bounds).special_points
    point = next(p for p in points if p.type == "grazing")

    def values(motion):
        return {"clearance": motion.clearance, "r": motion.r, "mu": motion.osc.mu}

    for motion in point.switch():
        assert motion.admissible
        assert motion.residual < 1e-12
        same = {k: v for k, v in values(motion).items() if k != parameter}
        assert same == {k: v for k, v in values(point.motion).items() if k != parameter}
    pair = next(m for m in point.switch() if len(m.pattern) == 4)
    np.testing.assert_allclose(pair.X[2:], -pair.X[:2], atol=1e-10 * pair.clearance)
    np.testing.assert_allclose(pair.alpha[2:], pair.alpha[:2] + np.pi, atol=1e-10)
    # followed back, the new impacts lose their approach speed where the wall is first touched
    ends = [
        p for p in vi.branch(pair, parameter, bounds).special_points if p.type == "zero_approach"
    ]
    here = values(point.motion)[parameter]
    assert min(abs(values(p.motion)[parameter] / here - 1) for p in ends) < 1e-8
