"""Laws that every answer obeys, on random systems, against `first_principles`.

Tolerances are rounding (EPS) times the condition of what is compared: of the linear system, of
the phases (a gap of impacts is a difference of two phases), of an event (a small approach speed
makes the time of an impact sensitive). Comments say which.
"""

from dataclasses import dataclass, replace

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

EPS = np.finfo(float).eps
EPS_SINGLE = float(np.finfo(np.float32).eps)
TURN = 2.0 * np.pi


def law(examples):
    """Return hypothesis settings: the same examples in every run, no limit of time on one."""
    health = [HealthCheck.filter_too_much, HealthCheck.too_slow, HealthCheck.data_too_large]
    return settings(
        max_examples=examples, deadline=None, derandomize=True, suppress_health_check=health
    )


@dataclass(frozen=True)
class Case:
    """A random system with its phases; `walls` are (R1, R2), or None where each impact has its own."""

    system: fp.System
    phases: np.ndarray
    walls: tuple | None

    def arguments(self):
        """Return what the package's functions take: oscillator, r, phases, pattern, restitution."""
        s = self.system
        osc = vi.Oscillator(s.xi, s.mu, self.walls or (0.5, 0.5))
        return (
            osc,
            s.r,
            self.phases,
            vi.Pattern(s.sides, s.cycles),
            None if self.walls else list(s.restitution),
        )


unit = st.floats(0.0, 1.0)
coefficients = st.one_of(st.sampled_from([0.0, 1.0, 0.5, 0.75]), st.floats(1e-3, 1.0))


@st.composite
def cases(draw, least=2, most=8, mu=None, restitution=coefficients, cycles=(1, 2, 3)):
    """Draw oscillator, load, sides and phases; r = 1 without damping is left out."""
    n = draw(st.integers(least, most))
    cycles = draw(st.sampled_from(cycles))
    xi = draw(st.one_of(st.sampled_from([0.0, 0.005, 0.9]), st.floats(0.0, 0.5)))
    if mu is None:
        mu = draw(st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.0, 2.0)))
    r = draw(st.floats(0.3, 3.0).filter(lambda r: abs(r - 1.0) + xi > 1e-3))
    sides = draw(st.lists(st.sampled_from("RL"), min_size=n, max_size=n))
    assume(len(set(sides)) == 2)
    gaps = np.array(draw(st.lists(st.floats(0.2, 1.0), min_size=n, max_size=n)))
    gaps *= TURN * cycles / gaps.sum()
    walls = draw(st.one_of(st.none(), st.tuples(restitution, restitution)))
    if walls is None:
        own = tuple(draw(st.lists(restitution, min_size=n, max_size=n)))
    else:
        own = tuple(walls["RL".index(side)] for side in sides)
    phases = np.concatenate([[0.0], np.cumsum(gaps)[:-1]])
    return Case(fp.System(xi, mu, r, "".join(sides), cycles, own), phases, walls)


def exact(case):
    """Move the phases of a case to an exact periodic motion; return the case and the motion."""
    assume(np.ptp(case.system.signs) > 0)
    motion = fp.newton(case.system, case.phases)
    assume(motion is not None)
    condition = np.linalg.cond(fp.linear_system(case.system, motion.phases)[0])
    assume(condition < 1e6)
    return replace(case, phases=motion.phases), motion


def spread(case):
    """Condition of the gaps between the phases, and of the angle of a flight."""
    total = TURN * case.system.cycles
    gaps = np.diff(np.append(case.phases, total))
    return 8.0 + gaps.max() / case.system.r + 2.0 * total / gaps.min()


def error_bound(case, eps=EPS):
    """Bound the relative error of the least squares solution: cond + cond^2 tan(angle).

    Infinite where the solution needs next to no load: no clearance and load belong to it.
    """
    matrix, right = fp.linear_system(case.system, case.phases)
    unknowns = np.linalg.lstsq(matrix, right, rcond=None)[0]
    if np.hypot(*unknowns[-2:]) <= 1e-4 * np.linalg.norm(unknowns):
        return np.inf
    condition = np.linalg.cond(matrix)
    off = np.linalg.norm(matrix @ unknowns - right)
    slope = off / max(np.linalg.norm(matrix, 2) * np.linalg.norm(unknowns), 1e-300)
    return 4.0 * eps * spread(case) * (condition + condition**2 * slope)


def unknowns_of(motion):
    """Return the unknowns of the linear system, in the clearance, of a motion."""
    wave = motion.A * np.array([np.cos(motion.tau), np.sin(motion.tau)])
    return np.concatenate([motion.X, wave]) / motion.clearance


def rebuild(motion, system):
    """Return the reference's motion with the package's numbers in it."""
    return fp.Motion(
        system,
        motion.phases,
        motion.clearance,
        motion.A * np.cos(motion.tau),
        motion.A * np.sin(motion.tau),
        motion.X,
        motion.Z,
        motion.X_dot_before,
        motion.X_dot_after,
        motion.Z_dot_before,
        motion.Z_dot_after,
        motion.residual,
    )


def scaled(maps, motion):
    """Return maps of (X, X_dot, Z_dot, phase) with lengths in the motion's own size."""
    size = np.array([1.0, 1.0, 1.0, 1.0 / (motion.A + np.abs(motion.X).max())])
    return maps / size[:, None] * size


def event_condition(motion, system):
    """Return the worst ratio of the speeds to the speed of approach, one over the flights."""
    c, s = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    end = np.append(motion.phases[1:], TURN * system.cycles)
    time = (end - motion.phases) / system.r
    _, v = fp.fly(system.xi, system.r, c, s, motion.phases, motion.X, motion.X_dot_after, time)
    speed = (
        np.abs(motion.Z_dot_after)
        + np.abs(v)
        + np.abs(motion.X_dot_after)
        + system.r * motion.A
        + np.abs(motion.X)
    )
    approach = np.maximum(np.abs(motion.Z_dot_after - v), 1e-300)
    return (speed / approach).max() * spread(Case(system, motion.phases, ()))


def check_multipliers(multipliers, maps, motion, condition):
    """Assert that the multipliers are those of the product of the maps.

    Every one must make P - lambda I singular to within the rounding of the product, which is
    bounded by the product of the norms, not by the norm of the product.
    """
    maps = scaled(maps, motion)
    product = np.linalg.multi_dot([np.eye(4), *maps[::-1]])
    bound = 4 * EPS * len(maps) * condition * np.prod(np.linalg.norm(maps, 2, axis=(1, 2)))
    for multiplier in multipliers:
        assert np.linalg.svd(product - multiplier * np.eye(4))[1][-1] <= bound
    assert abs(np.sum(multipliers) - np.trace(product)) <= 16 * bound
    square = np.trace(product @ product)
    assert abs(np.sum(multipliers**2) - square) <= 32 * bound * np.linalg.norm(product, 2)
    assert np.all(np.diff(np.abs(multipliers)) <= 1e-12 * np.abs(multipliers[0]))


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


@given(cases())
@law(900)
def test_coefficients_of_26_and_30(case):
    """The rows are the reference's, with their sign: what the impact asks minus the flight."""
    matrix, right = vi.linear_system(*case.arguments())
    expected, expected_right = fp.linear_system(case.system, case.phases)
    assert matrix.shape == expected.shape
    assert right.shape == expected_right.shape
    eta = np.sqrt(1.0 - case.system.xi**2)
    row = np.abs(expected).max(1) + np.abs(expected_right) + (1.0 + case.system.r) / eta
    tolerance = 4 * EPS * spread(case) * row
    assert np.all(np.abs(matrix - expected) <= tolerance[:, None])
    assert np.all(np.abs(right - expected_right) <= tolerance)


@given(cases())
@law(500)
def test_solution_of_the_linear_problem(case):
    """The unknowns are the least squares ones, all lengths follow from the amplitude A."""
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
@law(400)
def test_momentum_restitution_and_energy_at_every_impact(case):
    """Hold whether or not the phases are those of a periodic motion."""
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
@law(400)
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


# --- stability ------------------------------------------------------------------------------


def check_impact_maps(case, motion):
    """Assert P_i, [P] and the multipliers against the complex step; return the P_i, scaled."""
    condition = event_condition(motion, case.system)
    assume(condition < 1e8)
    c, s = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    expected = fp.impact_jacobians(
        case.system, motion.phases, motion.X, motion.X_dot_after, motion.Z_dot_after, c, s
    )
    maps = motion.impact_maps()
    wanted, have = scaled(expected, motion), scaled(maps, motion)
    assert have.shape == wanted.shape
    size = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    assert np.all(np.abs(have - wanted) <= 4 * EPS * condition * size)
    product = np.linalg.multi_dot([np.eye(4), *have[::-1]])
    norms = np.prod(np.linalg.norm(have, 2, axis=(1, 2)))
    error = np.abs(scaled(motion.stability_matrix(), motion) - product)
    assert np.all(error <= 8 * EPS * len(maps) * norms)
    check_multipliers(motion.multipliers, expected, motion, condition)
    return have


@given(cases(most=6))
@law(300)
def test_impact_maps_of_any_motion(case):
    """P_i is the derivative of the impact map of its flight, also between inconsistent phases."""
    assume(error_bound(case) < 1e-3)
    check_impact_maps(case, vi.periodic(*case.arguments()))


@given(cases())
@law(400)
def test_determinant_of_an_exact_motion(case):
    """det[P] = exp(-4 pi xi k/r) prod R_i^2, and P_i as the derivative of the impact map."""
    case, _ = exact(case)
    system = case.system
    motion = vi.periodic(*case.arguments())
    assert motion.residual <= 4 * error_bound(case) + 1e-13
    maps = check_impact_maps(case, motion)
    expected = np.exp(-4 * np.pi * system.xi * system.cycles / system.r) * np.prod(
        np.square(system.restitution)
    )
    found = np.prod(np.linalg.det(maps))
    if expected == 0.0:
        # The product of the determinants holds a zero: a zero pivot to rounding in each factor.
        assert abs(found) <= 1e-10 * np.prod(np.linalg.norm(maps, 2, axis=(1, 2)))
        return
    # A determinant is as good as its matrix is conditioned. The law also needs the approach speed
    # of the flight to be that of the impact: their difference is the residual.
    rounding = EPS * np.linalg.cond(maps, 2).sum()
    residual = 1e-14 * np.abs(fp.linear_system(system, case.phases)[0]).max()
    speeds = event_condition(motion, system) * residual * (1 + np.abs(motion.X).max())
    assert found == pytest.approx(expected, rel=16 * rounding + 16 * len(maps) * speeds)
    product = motion.stability_matrix()
    norms = np.prod(np.linalg.norm(maps, 2, axis=(1, 2)))
    smallest = np.linalg.svd(scaled(product, motion))[1][-1]
    loose = 64 * EPS * norms / max(smallest, EPS)
    if loose < 1e-2:
        bound = loose + 16 * rounding + 16 * len(maps) * speeds
        assert np.prod(motion.multipliers) == pytest.approx(expected, rel=bound)


@given(cases(most=5))
@law(200)
def test_exact_motion_is_a_fixed_point_of_the_impact_maps(case):
    """Newton on the flight time, from a guess that is off, arrives at the next impact's state."""
    case, _ = exact(case)
    system = case.system
    motion = vi.periodic(*case.arguments())
    condition = event_condition(motion, system)
    bound = condition * error_bound(case)
    assume(bound < 1e-6)
    wave = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    walls = 0.5 * motion.clearance * system.signs
    end = np.append(motion.phases[1:], TURN * system.cycles)
    states = np.stack([motion.X, motion.X_dot_after, motion.Z_dot_after, motion.phases])
    turn = np.array([0.0, 0.0, 0.0, TURN * system.cycles])
    size = motion.A + np.abs(states[:3]).max()
    for i, time in enumerate((end - motion.phases) / system.r):
        j = (i + 1) % len(walls)
        # Near enough for the root to be this one: the approach speed varies little over it.
        guess = time * (1 + 1e-3 / condition)
        after, found = fp.impact_map(
            system, wave, system.restitution[j], states[:, i : i + 1], guess, walls[j] - walls[i]
        )
        wanted = states[:, j] + (turn if j == 0 else 0.0)
        error = np.abs(after[:, 0] - wanted) / [size, size, size, 1.0]
        assert error.max() <= 16 * bound * len(walls)
        assert abs(found[0] - time) <= 16 * bound * len(walls)


@given(cases(most=4), st.integers(2, 3))
@law(150)
def test_repeated_motion(case, times):
    """A motion written several times over is itself; its multipliers are powers."""
    case, _ = exact(case)
    system = case.system
    more = replace(
        system,
        sides=system.sides * times,
        cycles=system.cycles * times,
        restitution=system.restitution * times,
    )
    phases = np.concatenate([case.phases + TURN * system.cycles * i for i in range(times)])
    longer = replace(case, system=more, phases=phases)
    bound = error_bound(longer)
    assume(bound < 1e-6)
    once, often = vi.periodic(*case.arguments()), vi.periodic(*longer.arguments())
    size = np.linalg.norm(unknowns_of(often)) * once.clearance
    assert np.all(np.abs(often.X - np.tile(once.X, times)) <= bound * size)
    # The bound of X moves the P_i by no more than the event's condition allows.
    maps = np.tile(once.impact_maps(), (times, 1, 1))
    condition = event_condition(once, system)
    assume(condition < 1e6)
    check_multipliers(often.multipliers, maps, once, condition**2 * (1 + bound / EPS))


# --- symmetry -------------------------------------------------------------------------------


def same_motion(one, two, bound, sign=1.0, shift=0):
    """Assert that two is one with X turned by sign and its first impact moved by shift."""
    size = bound * np.linalg.norm(unknowns_of(one)) * one.clearance
    wave = np.hypot(*unknowns_of(one)[-2:]) * one.clearance
    assert two.clearance == pytest.approx(one.clearance, rel=4 * size / wave + 1e-12)
    scale = 4 * size * (1 + np.abs(one.X).max() / wave)
    assert np.all(np.abs(two.X - sign * np.roll(one.X, -shift)) <= scale)
    assert two.residual == pytest.approx(one.residual, rel=1e-9, abs=4 * bound)


@given(cases())
@law(300)
def test_mirror(case):
    """Right and left exchanged: X and Z change sign, the load is half a turn later."""
    bound = error_bound(case)
    assume(bound < 1e-6)
    system = replace(case.system, sides=case.system.sides.translate(str.maketrans("RL", "LR")))
    mirrored = replace(case, system=system, walls=case.walls and case.walls[::-1])
    one, two = vi.periodic(*case.arguments()), vi.periodic(*mirrored.arguments())
    same_motion(one, two, bound, sign=-1.0)
    turn = np.exp(1j * (two.tau - one.tau))
    assert abs(turn + 1.0) <= 4 * bound * np.linalg.norm(unknowns_of(one)) * one.clearance / one.A
    condition = event_condition(one, case.system)
    assume(condition < 1e6)
    check_multipliers(two.multipliers, one.impact_maps(), one, condition**2 * (1 + bound / EPS))


@given(cases(), st.integers(1, 7))
@law(300)
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
    same_motion(one, two, bound, shift=first)
    turn = np.exp(1j * (two.tau - one.tau - case.phases[first]))
    assert abs(turn - 1.0) <= 4 * bound * np.linalg.norm(unknowns_of(one)) * one.clearance / one.A
    condition = event_condition(one, case.system)
    assume(condition < 1e6)
    maps = np.roll(one.impact_maps(), -first, axis=0)
    check_multipliers(two.multipliers, maps, one, condition**2 * (1 + bound / EPS))


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
@law(300)
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
    """The same for any number of impacts in an exact motion."""
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


# --- equispaced -----------------------------------------------------------------------------


def free_map_defect(xi, r, cycles):
    """1 + an eigenvalue of the map of free vibration over half a period; 0 at an undamped resonance."""
    return abs(1 + np.exp((-xi + 1j * np.sqrt(1 - xi**2)) * np.pi * cycles / r))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize(("cycles", "odd"), [(1, 3), (3, 5), (3, 7), (5, 3), (7, 1)])
def test_equispaced_at_an_undamped_resonance(cycles, odd, mu):
    """Where free vibration turns over in half a period it may be added: a family of motions, told as such.

    The positions of mu > 0 are those at which the free mass stands still in space, so that no impact changes
    the free vibration.
    """
    r, restitution = cycles / odd, 0.6
    system = fp.System(0.0, mu, r, "RL", cycles, (restitution, restitution))
    phases = np.array([0.0, np.pi * cycles])
    for tau in (-2.0, 0.3, 1.1):
        for x in (-0.5,) if mu else (-0.7, 0.0, 2.0):
            wave = system.amplitude / 30.0 * np.array([np.cos(tau), np.sin(tau)])
            value = fp.mismatch(system, phases, np.array([x, -x]), *wave)
            assert np.abs(value).max() <= 1e-13 * (1 + abs(x) + np.abs(wave).max()) * (1 + r) * odd
    osc = vi.Oscillator(0.0, mu, restitution)
    with pytest.raises(vi.errors.SingularError, match="no unique solution"):
        vi.equispaced(osc, r, 30.0, cycles=cycles)
    # a little damping, or a little beside it, and the motions are separate again
    check_equispaced(1e-3, mu, restitution, r, cycles, 0.5)
    check_equispaced(0.0, mu, restitution, r * 1.001, cycles, 0.5)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(("sides", "phases"), [
    ("RL", [0, 3.5]), ("RRL", [0, 1.5, 3.9]), ("equispaced", None)])  # fmt: skip
def test_few_digits_near_resonance_are_told(sides, phases, precision):
    """As r -> 1 without damping x/d has a limit, but A has none: digits go, and then the answer does.

    x/d changes by less than 10 |r - 1| here, so that the motion a little farther off is the true one. The
    condition of the equations, each unknown in its own unit, multiplies the rounding.
    """
    osc = vi.Oscillator(0.0, 0.3, 0.6 if phases is None else (0.6, 0.5))

    def positions(r):
        if phases is None:
            return vi.equispaced(osc, r, 100.0, precision=precision)[0].X / 100.0
        motion = vi.periodic(osc, r, phases, vi.Pattern(sides), precision=precision)
        return motion.X / motion.clearance

    condition = 1.0
    if phases is not None:
        matrix, _ = vi.linear_system(osc, 1 + 1e-6, phases, vi.Pattern(sides))
        condition = np.linalg.cond(matrix / np.linalg.norm(matrix, axis=0))
    first, allowed = (-7, 1e-6) if precision == "double" else (-3, 1e4 * EPS_SINGLE)
    true, told = positions(1 + 10.0**first), []
    for power in np.arange(first, -15 if precision == "double" else -7, -0.25):
        try:
            found = positions(1 + 10.0**power)
        except vi.errors.SingularError as error:
            told.append(str(error))
            continue
        assert not told, "digits came back"
        assert np.abs(found - true).max() <= condition * allowed + 10 * 10.0**first
    assert "too few digits" in told[0]


@given(
    st.one_of(st.just(0.0), st.floats(-18.0, -4.0).map(lambda x: 10**x)),
    st.one_of(st.just(0.0), st.floats(0.0, 1.0)),
    st.floats(0.05, 0.95),
    st.sampled_from([(1, 3), (3, 5), (3, 7), (5, 3)]),
    st.one_of(st.just(0.0), st.floats(-17.0, -3.0).map(lambda x: 10**x)),
    st.sampled_from([-1, 1]),
    st.floats(0.05, 3.0),
)
@law(500)
def test_equispaced_near_an_undamped_resonance(xi, mu, restitution, ratio_of_r, off, sign, ratio):
    """The law of the next test where it is hardest to keep."""
    cycles, odd = ratio_of_r
    check_equispaced(xi, mu, restitution, cycles / odd * (1 + sign * off), cycles, ratio)


@given(
    st.floats(0.0, 0.3),
    st.floats(0.0, 1.0),
    st.floats(0.05, 0.95),
    st.floats(0.4, 2.5),
    st.sampled_from([1, 3]),
    st.floats(0.05, 3.0),
)
@law(300)
def test_equispaced_is_a_line_cut_by_a_circle(xi, mu, restitution, r, cycles, ratio):
    """Both motions, or none, where the reference has them; symmetric and consistent."""
    assume(abs(r - 1.0) + xi > 1e-2)
    check_equispaced(xi, mu, restitution, r, cycles, ratio)


def check_equispaced(xi, mu, restitution, r, cycles, ratio):
    """The pair at a clearance in units of the largest that the impact pair has."""
    system = fp.System(xi, mu, r, "RL", cycles, (restitution, restitution))
    clearance = ratio * system.amplitude * fp.impact_pair_limit(restitution, cycles)
    expected = fp.equispaced(system, clearance)
    defect = free_map_defect(xi, r, cycles)
    try:
        found = vi.equispaced(vi.Oscillator(xi, mu, restitution), r, clearance, cycles=cycles)
    except vi.errors.SingularError:
        # at an undamped resonance of the half period the line loses its direction (a test of its own)
        assert defect < 50 * EPS / 1e-6 * (1 + r)
        return
    if bool(found) != bool(expected):
        # Only where the line all but touches the circle may the two disagree.
        near = (
            fp.equispaced(system, clearance * (1 - 1e-9)),
            fp.equispaced(system, clearance * (1 + 1e-9)),
        )
        assert len(near[0]) != len(near[1])
        return
    assert len(found) in (0, 1, 2)
    for motion in found:
        assert motion.clearance == pytest.approx(clearance, rel=1e-12)
        assert motion.pattern.sides == "RL"
        assert motion.X[1] == pytest.approx(-motion.X[0], abs=1e-11 * (1 + abs(motion.X[0])))
        value = fp.mismatch(
            system, motion.phases, motion.X / clearance, *(unknowns_of(motion)[-2:])
        )
        assert np.abs(value).max() <= 1e-12 * np.linalg.norm(unknowns_of(motion)) * (1 + r)
    if len(found) == len(expected) == 2:
        gap = abs(expected[0].tau - expected[1].tau) % TURN
        # the time of half a period is rounded; near a resonance it is the distance to it that counts
        lost = EPS * np.pi * cycles / r / defect
        near = max(1e-9, 100 * lost) / max(min(gap, TURN - gap, 1.0), 1e-9)
        for motion in found:
            taus = np.array([np.exp(1j * (motion.tau - other.tau)) for other in expected])
            assert np.abs(taus - 1.0).min() <= near


@given(
    st.floats(0.05, 0.95),
    st.floats(0.4, 2.5),
    st.sampled_from([1, 3, 5]),
    st.one_of(st.just(0.999999), st.floats(0.01, 0.999999)),
)
@law(150)
def test_equispaced_impact_pair_ends_where_it_should(restitution, r, cycles, part):
    """With mu = 0 there are two motions up to a clearance known in closed form, none beyond."""
    assume(abs(r - 1.0) > 1e-2)
    xi = 0.01
    osc = vi.Oscillator(xi, 0.0, restitution)
    A = abs(1.0 / (1.0 - r * r + 2j * xi * r))
    limit = A * fp.impact_pair_limit(restitution, cycles)
    assert len(vi.equispaced(osc, r, part * limit, cycles=cycles)) == 2
    assert vi.equispaced(osc, r, limit / part, cycles=cycles) == []
    at_limit = vi.equispaced(osc, r, limit, cycles=cycles)
    assert len(at_limit) in (0, 1, 2)
    for motion in at_limit:
        phase = (1 + restitution) * np.pi * cycles * np.cos(motion.tau)
        phase += 2 * (1 - restitution) * np.sin(motion.tau)
        assert phase == pytest.approx(-(1 - restitution) * motion.clearance / A, rel=1e-9)


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


@given(likely_motions())
@law(400)
def test_verdicts(case):
    """Flags against the reference: where the walls are, what the multipliers and residual say."""
    case, _ = exact(case)
    motion = vi.periodic(*case.arguments())
    reference = rebuild(motion, case.system)
    for flag in (motion.consistent, motion.admissible):
        assert flag is True or flag is False
    # on the unit circle, as without damping, rounding cannot tell: the verdict says so
    distance = abs(abs(motion.multipliers[0]) - 1)
    if distance < 2e-13:
        assert motion.stable is None
    elif distance > 1e-12:
        assert motion.stable in (True, False)
    assert motion.consistent is True
    clear = fp.clear_of_walls(reference)
    assert clear is None or motion.admissible is clear
    radius = np.abs(motion.multipliers).max()
    if abs(radius - 1.0) > 1e-9:
        assert motion.stable is bool(radius < 1.0)


@given(cases(least=3), st.floats(1e-3, 0.5))
@law(200)
def test_consistent_is_the_residual_against_the_acceptance(case, acceptance):
    """Consistent where the residual is below what the caller accepts."""
    assume(error_bound(case) < 1e-3)
    motion = vi.periodic(*case.arguments(), acceptance=acceptance)
    assume(abs(motion.residual - acceptance) > 1e-9)
    assert motion.consistent is bool(motion.residual < acceptance)


@given(likely_motions())
@law(300)
def test_extremes_of_the_primary_mass(case):
    """x_min and x_max enclose every sample and no more than the samples could have missed."""
    case, _ = exact(case)
    motion = vi.periodic(*case.arguments())
    low, high, doubt = fp.extremes(rebuild(motion, case.system))
    rounding = 1e-9 * (motion.A + np.abs(motion.X).max())
    assert low - doubt - rounding <= motion.x_min <= low + rounding
    assert high - rounding <= motion.x_max <= high + doubt + rounding
    expected = max(-motion.x_min, motion.x_max) / motion.A
    assert motion.attenuation == pytest.approx(expected, rel=1e-14)


# --- sampling -------------------------------------------------------------------------------


@given(likely_motions(), st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20))
@law(250)
def test_samples_are_the_flight(case, parts):
    """Positions, velocities, Y and load at any time, over any period."""
    case, _ = exact(case)
    assume(error_bound(case) < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    period = TURN * system.cycles / system.r
    t = np.array(parts) * period
    impacts = np.append(motion.phases / system.r, period)
    assume(np.abs(t[:, None] - impacts).min() > 1e-6)
    size = 1e-9 * (motion.A + np.abs(motion.X).max() + motion.clearance)
    size *= 1 + np.abs(motion.Z_dot_after).max() / motion.clearance
    x, v, z, w = fp.flight(rebuild(motion, system), t)
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


@given(likely_motions())
@law(250)
def test_samples_at_the_impacts(case):
    """Positions are continuous, Y is at the wall, velocities are those after the impact."""
    case, _ = exact(case)
    bound = error_bound(case)
    assume(bound < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    t = motion.phases / system.r
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
    """Over a period the load's work is the dashpot's loss and the loss of all impacts."""
    case, _ = exact(case)
    assume(error_bound(case) < 1e-9)
    motion, system = vi.periodic(*case.arguments()), case.system
    edges = np.append(motion.phases, TURN * system.cycles) / system.r
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


# --- single precision and batches -----------------------------------------------------------


@given(cases(most=5))
@law(300)
def test_single_precision_is_as_good_as_it_can_be(case):
    """Within rounding of real32 times the condition of the problem from double precision."""
    bound = error_bound(case, EPS_SINGLE)
    assume(bound < 0.05)
    double = vi.periodic(*case.arguments())
    single = vi.periodic(*case.arguments(), precision="single")
    assert (double.precision, single.precision) == ("double", "single")
    one, two = unknowns_of(double), unknowns_of(single)
    near = 8 * EPS_SINGLE / abs(1 - case.system.r**2 + 2j * case.system.xi * case.system.r)
    assert np.linalg.norm(one - two) <= (bound + near) * np.linalg.norm(one)


def test_single_precision_is_single():
    """The digits beyond the seventh are not there."""
    osc, pattern = vi.Oscillator(0.005, 0.042, 0.75), vi.Pattern("RL")
    arguments = osc, 0.94, [0.0, 1.37 * np.pi], pattern
    double, single = vi.periodic(*arguments), vi.periodic(*arguments, precision="single")
    relative = np.abs(single.X / double.X - 1.0)
    assert np.all(relative > 1e-10)
    assert np.all(relative < 1e-3)
    assert np.array_equal(single.X, np.float32(single.X))


@given(cases(most=5), st.lists(st.floats(0.97, 1.03), min_size=1, max_size=6))
@law(100)
def test_batch_is_the_single_calls(case, factors):
    """Every point of a batch has the digits of its own call."""
    osc, r, phases, pattern, restitution = case.arguments()
    r = np.array([r * f for f in factors])
    assume(np.abs(r - 1.0).min() > 1e-3)
    many = np.repeat(phases[:, None], len(r), axis=1)
    many[1] += 0.01 * np.arange(len(r))
    motions = vi.periodic_batch(osc, r, many, pattern, restitution)
    assert len(motions) == len(r)
    assert motions.X.shape == many.shape
    for i in np.flatnonzero(motions.status == 0):
        one = vi.periodic(osc, r[i], many[:, i], pattern, restitution)
        for name in (
            "X",
            "Z",
            "X_dot_before",
            "X_dot_after",
            "Z_dot_before",
            "Z_dot_after",
            "multipliers",
            "clearance",
            "A",
            "tau",
            "residual",
            "x_min",
            "x_max",
            "attenuation",
        ):
            mine = getattr(motions, name)[..., i]
            assert np.array_equal(mine, getattr(one, name)), name
            assert np.array_equal(getattr(motions[int(i)], name), getattr(one, name)), name


def test_a_failed_point_does_not_end_the_batch():
    """Equal halves and equal restitution leave a free amplitude: a code and NaN at that point."""
    osc, pattern = vi.Oscillator(0.01, 0.05, 0.75), vi.Pattern("RL")
    phases = np.array([[0.0, 0.0, 0.0], [3.0, np.pi, 3.3]])
    motions = vi.periodic_batch(osc, 0.9, phases, pattern)
    assert list(motions.status == 0) == [True, False, True]
    assert np.isnan(motions.X[:, 1]).all()
    assert np.isnan(motions.clearance[1])
    assert np.isfinite(motions.X[:, [0, 2]]).all()
    with pytest.raises(vi.errors.SingularError):
        vi.periodic(osc, 0.9, phases[:, 1], pattern)
