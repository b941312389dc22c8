"""Random systems, and the accuracy to which they can meet the laws.

Tolerances are rounding (EPS) times the condition of the compared quantity: of the linear system, of
the phases (a gap of impacts is a difference of two phases), of an event (a small approach speed
makes the time of an impact sensitive). Comments say which.
"""

from dataclasses import dataclass, replace

import first_principles as fp
import numpy as np
import vibroimpact as vi
from hypothesis import assume
from hypothesis import strategies as st
from shared_systems import EPS, TURN

EPS_SINGLE = float(np.finfo(np.float32).eps)


@dataclass(frozen=True)
class Case:
    """A random system with its phases; `walls` are (R1, R2), or None where each impact has its own."""

    system: fp.System
    phases: np.ndarray
    walls: tuple | None

    def arguments(self):
        """Return the arguments of the package's functions: oscillator, r, phases, pattern, restitution."""
        s = self.system
        osc = vi.Oscillator(xi=s.xi, mu=s.mu, restitution=self.walls or (0.5, 0.5))
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
    """Draw oscillator, load, sides and phases; r = 1 without damping is excluded."""
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
    condition = np.linalg.cond(fp.linear_system(case.system, motion.alpha)[0])
    assume(condition < 1e6)
    return replace(case, phases=motion.alpha), motion


def spread(case):
    """Condition of the gaps between the phases, and of the angle of a flight."""
    total = TURN * case.system.cycles
    gaps = np.diff(np.append(case.phases, total))
    return 8.0 + gaps.max() / case.system.r + 2.0 * total / gaps.min()


def error_bound(case, eps=EPS):
    """Bound the relative error of the least squares solution: cond + cond^2 tan(angle).

    The right side is a difference of what the free mass has before and after its impacts, which may be far
    larger: as with walls of restitution 1 and impacts half a period apart. Infinite where the solution needs
    almost no load: no clearance and load correspond to it.
    """
    matrix, right = fp.linear_system(case.system, case.phases)
    unknowns = np.linalg.lstsq(matrix, right, rcond=None)[0]
    if np.hypot(*unknowns[-2:]) <= 1e-4 * np.linalg.norm(unknowns):
        return np.inf
    condition = np.linalg.cond(matrix)
    terms = np.abs(fp.velocities(case.system, case.phases, np.zeros(len(case.phases)))[3:]).max()
    lost = condition * terms / (np.linalg.norm(matrix, 2) * np.linalg.norm(unknowns))
    off = np.linalg.norm(matrix @ unknowns - right)
    slope = off / max(np.linalg.norm(matrix, 2) * np.linalg.norm(unknowns), 1e-300)
    return 4.0 * eps * spread(case) * (condition + condition**2 * slope + lost)


def unknowns_of(motion):
    """Return the unknowns of the linear system, in the clearance, of a motion."""
    wave = motion.A * np.array([np.cos(motion.tau), np.sin(motion.tau)])
    return np.concatenate([motion.X, wave]) / motion.clearance


def rebuild(motion, system):
    """Return the reference's motion with the package's numbers in it."""
    return fp.Motion(
        system,
        motion.alpha,
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
    """Return maps of (X, X_dot, Z_dot, phase), with lengths in units of the size of the motion."""
    size = np.array([1.0, 1.0, 1.0, 1.0 / (motion.A + np.abs(motion.X).max())])
    return maps / size[:, None] * size


def event_condition(motion, system):
    """Return the largest ratio of the speeds to an approach speed, times the condition of the phases."""
    c, s = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    end = np.append(motion.alpha[1:], TURN * system.cycles)
    time = (end - motion.alpha) / system.r
    _, v = fp.fly(system.xi, system.r, c, s, motion.alpha, motion.X, motion.X_dot_after, time)
    speed = (
        np.abs(motion.Z_dot_after)
        + np.abs(v)
        + np.abs(motion.X_dot_after)
        + system.r * motion.A
        + np.abs(motion.X)
    )
    approach = np.maximum(np.abs(motion.Z_dot_after - v), 1e-300)
    return (speed / approach).max() * spread(Case(system, motion.alpha, ()))


def assert_multipliers(multipliers, maps, motion, condition):
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
