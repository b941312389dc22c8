"""Laws that every solution of the linear equations obeys, on random systems, compared with `first_principles`."""

from dataclasses import replace

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import assume, given
from hypothesis import strategies as st
from shared_laws import (
    assert_multipliers,
    cases,
    error_bound,
    event_condition,
    exact,
    spread,
    unit,
    unknowns_of,
)
from shared_systems import EPS, TURN, law

# --- the reference itself -------------------------------------------------------------------


@given(st.floats(0.0, 0.95), st.floats(0.2, 3.0), st.floats(0.0, 8.0), *[st.floats(-2, 2)] * 5)
@law(200)
def test_reference_flight_obeys_newtons_law(xi, r, t, x, v, c, s, angle):
    """x'' + 2 xi x' + x is the load, with the derivatives in t by complex step."""
    later = t + 1j * fp.STEP
    x1, v1 = fp.fly(xi, r, c, s, angle, x, v, later)
    assert x1.imag / fp.STEP == pytest.approx(v1.real, abs=1e-13)
    where, speed = fp.steady(r, c, s, angle + r * t)
    load = (1.0 - r * r) * where + 2.0 * xi * speed
    assert v1.imag / fp.STEP + 2 * xi * v1.real + x1.real == pytest.approx(load, abs=1e-12)
    assert fp.fly(xi, r, c, s, angle, x, v, 0.0) == pytest.approx((x, v), abs=1e-14)


@given(st.floats(0.0, 2.0), unit, st.floats(-3, 3), st.floats(-3, 3))
@law(100)
def test_reference_impact_in_both_directions(mu, restitution, v, w):
    """Momentum and restitution hold, and the velocities of M follow from those of the ball."""
    v1, w1 = fp.collide(mu, restitution, np.array([v]), np.array([w]))
    assert v1[0] + mu * w1[0] == pytest.approx(v + mu * w, abs=1e-14)
    assert v1[0] - w1[0] == pytest.approx(-restitution * (v - w), abs=1e-14)
    back = fp.carrier_velocities(mu, np.array([restitution]), np.array([w]), w1)
    assert np.ravel(back) == pytest.approx([v, v1[0]], abs=1e-13)


# --- the linear system ----------------------------------------------------------------------


@pytest.mark.slow
@given(cases())
@law(200)
def test_coefficients_of_26_and_30(case):
    """The rows are those of the reference, with the sign: state required by the impact minus end of the flight."""
    matrix, right = vi.linear_system(*case.arguments())
    expected, expected_right = fp.linear_system(case.system, case.phases)
    assert matrix.shape == expected.shape
    assert right.shape == expected_right.shape
    eta = np.sqrt(1.0 - case.system.xi**2)
    row = np.abs(expected).max(1) + np.abs(expected_right) + (1.0 + case.system.r) / eta
    tolerance = 4 * EPS * spread(case) * row
    assert np.all(np.abs(matrix - expected) <= tolerance[:, None])
    assert np.all(np.abs(right - expected_right) <= tolerance)


@pytest.mark.slow
@given(cases())
@law(200)
def test_solution_of_the_linear_problem(case):
    """The unknowns are the least squares solution, and all lengths follow from the amplitude A."""
    bound = error_bound(case)
    assume(bound < 1e-3)
    motion, expected = vi.periodic(*case.arguments()), fp.solve(case.system, case.phases)
    assert (
        pytest.approx(
            case.system.amplitude,
            rel=16 * EPS / abs(1 - case.system.r**2 + 2j * case.system.xi * case.system.r),
        )
        == motion.A
    )
    size = np.linalg.norm(unknowns_of(motion))
    wave = np.hypot(*unknowns_of(motion)[-2:])
    far = np.linalg.norm(unknowns_of(motion) - unknowns_of_reference(expected))
    assert far <= bound * size
    assert motion.clearance == pytest.approx(expected.clearance, rel=bound * size / wave + 1e-13)
    matrix, right = fp.linear_system(case.system, case.phases)
    residual = np.linalg.norm(matrix @ unknowns_of(motion) - right) / np.linalg.norm(right)
    assert motion.residual == pytest.approx(residual, abs=bound * (1 + residual), rel=1e-9)


def unknowns_of_reference(motion):
    """Return the unknowns of the linear system from a motion of the reference."""
    return np.concatenate([motion.X, [motion.c, motion.s]]) / motion.clearance


@given(cases())
@law(200)
def test_momentum_restitution_and_energy_at_every_impact(case):
    """The laws of impact hold whether or not the phases are those of a periodic motion."""
    assume(error_bound(case) < 1e-3)
    motion = vi.periodic(*case.arguments())
    mu, R = case.system.mu, np.array(case.system.restitution)
    v0, v1 = motion.X_dot_before, motion.X_dot_after
    w0, w1 = motion.Z_dot_before, motion.Z_dot_after
    size = 16 * EPS * (1 + mu) * (np.abs(v0) + np.abs(v1) + np.abs(w0) + np.abs(w1))
    assert np.all(np.abs(v0 + mu * w0 - v1 - mu * w1) <= size)
    assert np.all(np.abs(v1 - w1 + R * (v0 - w0)) <= size)
    loss = v0**2 + mu * w0**2 - v1**2 - mu * w1**2
    expected = mu / (1 + mu) * (1 - R**2) * (v0 - w0) ** 2
    assert np.all(
        np.abs(loss - expected) <= size * (np.abs(v0) + np.abs(v1) + np.abs(w0) + np.abs(w1))
    )
    assert np.array_equal(motion.restitution, R)


@given(cases())
@law(200)
def test_ball_flies_straight_from_wall_to_wall(case):
    """Z - X is half the clearance on the impact's side, and the ball's velocity is its slope."""
    assume(error_bound(case) < 1e-3)
    motion = vi.periodic(*case.arguments())
    size = np.abs(motion.X).max() + motion.clearance
    slack = np.abs(motion.Z - motion.X - 0.5 * motion.clearance * case.system.signs)
    assert np.all(slack <= 4 * EPS * size)
    time, *_ = fp.velocities(case.system, case.phases, motion.X, motion.clearance)
    slope = (np.roll(motion.Z, -1) - motion.Z) / time
    tolerance = 4 * EPS * spread(case) * size / time.min()
    assert np.all(np.abs(motion.Z_dot_after - slope) <= tolerance)
    assert np.array_equal(np.roll(motion.Z_dot_after, 1), motion.Z_dot_before)


# --- symmetry -------------------------------------------------------------------------------


def assert_same_motion(one, two, bound, sign=1.0, shift=0):
    """Assert that `two` is `one` with X multiplied by `sign` and its impacts shifted by `shift`."""
    size = bound * np.linalg.norm(unknowns_of(one)) * one.clearance
    wave = np.hypot(*unknowns_of(one)[-2:]) * one.clearance
    assert two.clearance == pytest.approx(one.clearance, rel=4 * size / wave + 1e-12)
    scale = 4 * size * (1 + np.abs(one.X).max() / wave)
    assert np.all(np.abs(two.X - sign * np.roll(one.X, -shift)) <= scale)
    assert two.residual == pytest.approx(one.residual, rel=1e-9, abs=4 * bound)


@given(cases())
@law(200)
def test_mirror(case):
    """With right and left exchanged X and Z change sign, and the load is half a cycle later."""
    bound = error_bound(case)
    assume(bound < 1e-6)
    system = replace(case.system, sides=case.system.sides.translate(str.maketrans("RL", "LR")))
    mirrored = replace(case, system=system, walls=case.walls and case.walls[::-1])
    one, two = vi.periodic(*case.arguments()), vi.periodic(*mirrored.arguments())
    assert_same_motion(one, two, bound, sign=-1.0)
    turn = np.exp(1j * (two.tau - one.tau))
    assert abs(turn + 1.0) <= 4 * bound * np.linalg.norm(unknowns_of(one)) * one.clearance / one.A
    condition = event_condition(one, case.system)
    assume(condition < 1e6)
    assert_multipliers(two.multipliers, one.impact_maps(), one, condition**2 * (1 + bound / EPS))


@given(cases(), st.integers(1, 7))
@law(200)
def test_any_impact_can_be_the_first(case, first):
    """The least squares problem is the same with its rows and unknowns permuted, (c, s) turned."""
    n = len(case.phases)
    first %= n
    bound = error_bound(case)
    assume(bound < 1e-6)
    turned = np.roll(case.phases, -first) - case.phases[first]
    turned[n - first :] += TURN * case.system.cycles
    sides, own = case.system.sides, case.system.restitution
    system = replace(
        case.system, sides=sides[first:] + sides[:first], restitution=own[first:] + own[:first]
    )
    other = replace(case, system=system, phases=turned)
    one, two = vi.periodic(*case.arguments()), vi.periodic(*other.arguments())
    assert_same_motion(one, two, bound, shift=first)
    turn = np.exp(1j * (two.tau - one.tau - case.phases[first]))
    assert abs(turn - 1.0) <= 4 * bound * np.linalg.norm(unknowns_of(one)) * one.clearance / one.A
    condition = event_condition(one, case.system)
    assume(condition < 1e6)
    maps = np.roll(one.impact_maps(), -first, axis=0)
    assert_multipliers(two.multipliers, maps, one, condition**2 * (1 + bound / EPS))


# --- no mass ratio: the impact pair ---------------------------------------------------------


def away_from_resonance(case):
    """Return how strongly a mismatch over a period excites a free motion of that period.

    Without damping and with r a multiple of k/n a free motion of any size is periodic too, and the
    oscillator need not keep to the steady one; such cases are left out.
    """
    period = TURN * case.system.cycles / case.system.r
    returned = np.reshape(fp.exponential(case.system.xi, period), (2, 2))
    least = np.linalg.svd(returned - np.eye(2))[1][-1]
    assume(least > 1e-3)
    return 1.0 / least


@given(cases(most=2, mu=0.0))
@law(200)
def test_impact_pair_in_closed_form(case):
    """With mu = 0 the oscillator keeps its steady motion, and two impacts have a closed form."""
    bound = error_bound(case)
    assume(bound < 1e-6)
    bound *= away_from_resonance(case)
    motion, system = vi.periodic(*case.arguments()), case.system
    c, s, X = fp.impact_pair(system.r, case.phases, system.signs, system.cycles, system.restitution)
    expected = np.append(X, [c, s])
    have = unknowns_of(motion)
    assert np.linalg.norm(have - expected) <= 4 * bound * np.linalg.norm(expected)


@given(cases(least=3, mu=0.0))
@law(150)
def test_impact_pair_follows_the_steady_motion(case):
    """With mu = 0 an exact motion with any number of impacts follows the steady motion."""
    case, _ = exact(case)
    bound = error_bound(case) * away_from_resonance(case)
    assume(bound < 1e-6)
    motion = vi.periodic(*case.arguments())
    c, s = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    x, v = fp.steady(case.system.r, c, s, case.phases)
    size = bound * np.linalg.norm(unknowns_of(motion)) * motion.clearance
    assert np.all(np.abs(motion.X - x) <= 4 * size)
    speed = 4 * size * spread(case)
    assert np.all(np.abs(motion.X_dot_before - v) <= speed)
    assert np.all(np.abs(motion.X_dot_after - v) <= speed)
