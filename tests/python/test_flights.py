"""Verdicts, extremes and samples between impacts, on random systems, compared with `first_principles`."""

import first_principles as fp
import first_principles_flights as flights
import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import assume, given
from hypothesis import strategies as st
from shared_laws import Case, cases, error_bound, exact, rebuild
from shared_systems import EPS, TURN, law

# --- verdicts and extremes ------------------------------------------------------------------

friendly = st.sampled_from(["RL", "RRL", "RLL", "RLRL", "RRLL", "RRRL"])


@st.composite
def likely_motions(draw):
    """Draw systems whose exact motions are often admissible: few impacts, moderate restitution."""
    sides = draw(friendly)
    n = len(sides)
    gaps = np.array(draw(st.lists(st.floats(0.3, 1.0), min_size=n, max_size=n)))
    phases = np.concatenate([[0.0], np.cumsum(gaps)[:-1]]) * TURN / gaps.sum()
    own = tuple(draw(st.lists(st.floats(0.1, 0.95), min_size=n, max_size=n)))
    xi, mu = draw(st.floats(0.0, 0.3)), draw(st.floats(0.0, 0.5))
    r = draw(st.floats(0.4, 2.5).filter(lambda r: abs(r - 1.0) > 1e-2))
    return Case(fp.System(xi, mu, r, sides, 1, own), phases, None)


@pytest.mark.slow
@given(likely_motions())
@law(200)
def test_verdicts(case):
    """`admissible` agrees with the flights of the reference, and `stable` with the multipliers."""
    case, _ = exact(case)
    motion = vi.periodic(*case.arguments())
    reference = rebuild(motion, case.system)
    for flag in (motion.consistent, motion.admissible):
        assert flag is True or flag is False
    # on the unit circle rounding decides: the verdict is None
    distance = abs(abs(motion.multipliers[0]) - 1)
    if case.system.xi == 0 and case.system.mu == 0:
        # nothing damps the primary mass: two multipliers are on the circle, equal ones where k/r is a whole number
        # of half periods, and rounding moves these by the root of its size
        assert motion.stable is not True
    elif distance < 2e-13:
        assert motion.stable is None
    elif distance > 1e-12:
        assert motion.stable in (True, False)
    assert motion.consistent is True
    clear = flights.clear_of_walls(reference)
    assert clear is None or motion.admissible is clear
    radius = np.abs(motion.multipliers).max()
    if abs(radius - 1.0) > 1e-9:
        assert motion.stable is bool(radius < 1.0)


@given(cases(least=3), st.floats(1e-3, 0.5))
@law(200)
def test_consistent_is_the_residual_against_the_acceptance(case, acceptance):
    """`consistent` means that the residual is below the caller's `acceptance`."""
    assume(error_bound(case) < 1e-3)
    motion = vi.periodic(*case.arguments(), acceptance=acceptance)
    assume(abs(motion.residual - acceptance) > 1e-9)
    assert motion.consistent is bool(motion.residual < acceptance)


@pytest.mark.slow
@given(likely_motions())
@law(200)
def test_extremes_of_the_primary_mass(case):
    """x_min and x_max enclose every sample and no more than the samples could have missed."""
    case, _ = exact(case)
    motion = vi.periodic(*case.arguments())
    low, high, doubt = flights.extremes(rebuild(motion, case.system))
    rounding = 1e-9 * (motion.A + np.abs(motion.X).max())
    assert low - doubt - rounding <= motion.x_min <= low + rounding
    assert high - rounding <= motion.x_max <= high + doubt + rounding
    expected = max(-motion.x_min, motion.x_max) / motion.A
    assert motion.attenuation == pytest.approx(expected, rel=1e-14)


# --- sampling -------------------------------------------------------------------------------


@pytest.mark.slow
@given(likely_motions(), st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
@law(200)
def test_samples_are_the_flight(case, parts):
    """Samples are positions, velocities, Y and load of the flight, at any time in any period."""
    case, _ = exact(case)
    assume(error_bound(case) < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    period = TURN * system.cycles / system.r
    t = np.array(parts) * period
    impacts = np.append(motion.alpha / system.r, period)
    assume(np.abs(t[:, None] - impacts).min() > 1e-6)
    size = 1e-9 * (motion.A + np.abs(motion.X).max() + motion.clearance)
    size *= 1 + np.abs(motion.Z_dot_after).max() / motion.clearance
    x, v, z, w = flights.flight(rebuild(motion, system), t)
    for shift in (0.0, period, -period, 5 * period):
        sample = motion.sample(t + shift)
        have = np.stack([sample.X, sample.X_dot, sample.Z, sample.Z_dot])
        assert np.all(np.abs(have - np.stack([x, v, z, w])) <= size)
        assert np.all(np.abs(sample.Y - (sample.Z - sample.X)) <= size)
        load = np.sin(system.r * t + motion.tau + system.lag)
        assert np.all(np.abs(sample.load - load) <= 1e-12 * (1 + system.cycles))
    grid = motion.sample(t.reshape(1, -1))
    assert all(
        np.shape(getattr(grid, name)) == (1, len(t))
        for name in ("X", "X_dot", "Z", "Z_dot", "Y", "load")
    )


@pytest.mark.slow
@given(likely_motions())
@law(200)
def test_samples_at_the_impacts(case):
    """Positions are continuous, Y is at the wall, velocities are those after the impact."""
    case, _ = exact(case)
    bound = error_bound(case)
    assume(bound < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    t = motion.alpha / system.r
    at = motion.sample(t)
    size = motion.A + np.abs(motion.X).max() + motion.clearance
    speed = size + np.abs(motion.Z_dot_after).max() + np.abs(motion.X_dot_after).max()
    assert np.all(np.abs(at.X - motion.X) <= 16 * EPS * size)
    assert np.all(np.abs(at.X_dot - motion.X_dot_after) <= 16 * EPS * speed)
    assert np.all(np.abs(at.Z_dot - motion.Z_dot_after) <= 16 * EPS * speed)
    assert np.all(np.abs(at.Y - 0.5 * motion.clearance * system.signs) <= 16 * EPS * size)
    instant = 1e-9
    before, after = motion.sample(t - instant), motion.sample(t + instant)
    jump = 2 * instant * speed * (2 + system.r**2) + 1e4 * bound * speed
    for name in ("X", "Z", "Y"):
        assert np.all(np.abs(getattr(after, name) - getattr(before, name)) <= jump)
    assert np.all(np.abs(before.X_dot - motion.X_dot_before) <= jump)
    assert np.all(np.abs(before.Z_dot - motion.Z_dot_before) <= jump)
    assert np.all(np.abs(after.X_dot - motion.X_dot_after) <= jump)
    assert np.shape(motion.sample(0.5).X) == ()


@given(likely_motions())
@law(150)
def test_work_of_the_load_is_what_damping_and_impacts_take(case):
    """Over a period the work of the load equals the energy lost in the dashpot and the impacts."""
    case, _ = exact(case)
    assume(error_bound(case) < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    edges = np.append(motion.alpha, TURN * system.cycles) / system.r
    node, weight = np.polynomial.legendre.leggauss(40)
    half = 0.5 * np.diff(edges)
    t = (edges[:-1] + half)[:, None] + half[:, None] * node
    sample = motion.sample(t)
    power = (sample.load - 2 * system.xi * sample.X_dot) * sample.X_dot
    work = np.sum(half[:, None] * weight * power)
    before = motion.X_dot_before**2 + system.mu * motion.Z_dot_before**2
    after = motion.X_dot_after**2 + system.mu * motion.Z_dot_after**2
    scale = np.sum(before + after) + np.sum(half[:, None] * weight * np.abs(power)) + 1.0
    assert work == pytest.approx(0.5 * np.sum(before - after), abs=1e-9 * scale)
