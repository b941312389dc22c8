"""Simulations near exact motions stay, leave and return as the multipliers predict."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN, POINTS, after_impact, motions
from shared_systems import TABLE, TURN


def by_period(run, motion, cycles):
    """Impacts of a run, one row for each period of a motion."""
    events, n = run.events, len(motion.pattern)
    rows = events[: cycles * n].reshape(cycles, n)
    assert set(rows["kind"].ravel()) == {"impact"}
    return rows


def test_stays_on_a_stable_motion_for_ten_thousand_cycles():
    """Every impact of 10,000 cycles has the phase and position of the exact motion."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    run = vi.simulate(TABLE, 0.94, 37.0, 10_000, after_impact(motion))
    assert run.events.size in (19_999, 20_000)
    rows = by_period(run, motion, 9_999)
    phases = np.mod(motion.alpha[[1, 0]] + motion.load_phase, TURN)
    assert np.abs(np.mod(rows["phase"] - phases + 1, TURN) - 1).max() < 1e-11
    assert np.abs(rows["x"] - motion.X[[1, 0]]).max() < 1e-11
    assert np.abs(rows["z_dot_after"] - motion.Z_dot_after[[1, 0]]).max() < 1e-11


@pytest.mark.parametrize("which", [0, 1])
def test_leaves_an_unstable_motion_at_the_rate_of_its_multiplier(which):
    """A perturbation of 1e-9 grows from period to period by the leading multiplier, to 1 %."""
    motion = vi.equispaced(TABLE, 0.94, 37.0)[which]
    motion = vi.exact(TABLE, 0.94, 37.0, motion)
    assert not motion.stable
    values, vectors = np.linalg.eig(motion.stability_matrix())
    lead = int(np.abs(values).argmax())
    nudge = 1e-9 * vectors[:, lead].real
    first = after_impact(motion)
    first["t"] += nudge[3] / motion.r
    first["x"] += nudge[0]
    first["z"] += nudge[0]
    first["x_dot"] += nudge[1]
    first["z_dot"] += nudge[2]
    run = vi.simulate(TABLE, 0.94, 37.0, 30, first)
    right = run.events[(run.events["side"] == "R") & (run.events["kind"] == "impact")]
    off = np.abs(right["x"][:15] - motion.X[0])
    use = (off > 1e-8) & (off < 1e-3)
    period = np.arange(off.size)[use]
    assert period.size >= 4
    assert np.all(np.diff(period) == 1)
    rate = math.exp(np.polyfit(period, np.log(off[use]), 1)[0])
    assert rate == pytest.approx(abs(motion.multipliers[0]), rel=0.01)


@pytest.mark.parametrize("point", POINTS)
def test_a_perturbation_follows_the_stability_matrix(point):
    """One simulated period maps a small change of (x, x', z', phase) as [P] does."""
    osc, r, clearance = point
    for motion in motions(*point, impacts=3, cycles=1):
        matrix, size = motion.stability_matrix(), 1e-6
        n, side = len(motion.pattern), motion.pattern.signs[0]
        for column in range(4):
            ends = []
            for sign in (1, -1):
                change = np.zeros(4)
                change[column] = sign * size
                first = after_impact(motion)
                first["x"] += change[0]
                first["z"] = first["x"] + 0.5 * side * clearance
                first["x_dot"] += change[1]
                first["z_dot"] += change[2]
                first["t"] += change[3] / r
                event = vi.simulate(osc, r, clearance, 1.5, first).events[n - 1]
                ends.append(
                    [event["x"], event["x_dot_after"], event["z_dot_after"], event["time"] * r]
                )
            got = np.subtract(*ends) / (2 * size)
            assert got == pytest.approx(matrix[:, column], abs=2e-6 * np.abs(matrix).max())


def test_a_small_perturbation_of_a_stable_motion_dies_out():
    """The perturbation decays in each period by the modulus of the leading multiplier."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    first = after_impact(motion)
    first["x_dot"] += 1e-4
    run = vi.simulate(TABLE, 0.94, 37.0, 300, first)
    right = run.events[run.events["side"] == "R"]
    off = np.abs(right["x"] - motion.X[0])
    tops = [off[i : i + 20].max() for i in range(20, 200, 20)]
    rate = math.exp(np.polyfit(np.arange(len(tops)) * 20, np.log(tops), 1)[0])
    assert rate == pytest.approx(abs(motion.multipliers[0]), rel=0.01)
    assert off[-20:].max() < 1e-10


def test_period_that_has_just_doubled():
    """Newton's method finds the motion of the trajectory, not the nearby unstable motion of half the period.

    The system was drawn at random by an audit; past the flip of RRRLLLL/1 the two halves of the period differ by
    less than 0.05 in phase.
    """
    osc, r, clearance = vi.Oscillator(xi=0.05365, mu=0.25679, restitution=0.82717), 0.9134, 2.1487
    run = vi.simulate(osc, r, clearance, 24, discard=2000)
    motion = vi.exact(osc, r, clearance, run)
    assert (motion.pattern.cycles, motion.stable) == (2, True)
    last = run.events[-len(motion.pattern) :]
    for name, column in (("x", motion.X), ("z_dot_after", motion.Z_dot_after)):
        off = [np.abs(np.roll(column, k) - last[name]).max() for k in range(len(column))]
        assert min(off) < 1e-9
    # the nearby motion of half the period exists too, and is unstable
    n = len(motion.pattern) // 2
    half = (motion.alpha[:n], vi.Pattern(motion.pattern.sides[:n], 1))
    short = vi.exact(osc, r, clearance, half)
    assert short.stable is False
    # a trajectory that approaches a one-cycle motion with alternating sign is not mistaken for a two-cycle one
    low = vi.simulate(osc, r, 1.9, 24, discard=20)
    assert vi.exact(osc, r, 1.9, low).pattern.cycles == 1


def test_a_period_that_is_counted_twice_while_a_run_settles():
    """Near a flip a run that settles slowly repeats itself only after two periods of its motion."""
    osc, r, clearance = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61)), 1.1, 11.0926
    start = {"z_dot": 3.0}
    doubled = 0
    for discard in range(36, 60):
        for cycles in (5, 6):
            run = vi.simulate(osc, r, clearance, cycles, start, discard=discard)
            try:
                doubled += run.period().pattern.cycles == 2
            except vi.ParameterError:
                continue
            motion = vi.exact(osc, r, clearance, run)
            assert (len(motion.pattern), motion.pattern.cycles, motion.stable) == (2, 1, True)
            assert abs(motion.multipliers[0]) == pytest.approx(0.99540546, abs=1e-8)
    assert doubled > 5
