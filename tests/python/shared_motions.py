"""Motions of the paper's systems and of a system with unequal walls."""

import contextlib
import math

import first_principles as fp
import numpy as np
import vibroimpact as vi
from shared_simulations import settled, state
from shared_systems import RIG, TABLE

COLUMN = ([0.0, 1.37 * math.pi], vi.Pattern("RL"))
UNEVEN = vi.Oscillator(xi=0.02, mu=0.1, restitution=(0.8, 0.5))
POINTS = [(TABLE, 0.94, 37.0), (RIG, 0.9, 6.0), (UNEVEN, 1.1, 2.0), (UNEVEN, 0.6, 1.0)]


def motions(osc, r, clearance, impacts=4, cycles=2):
    """Motions without rest that the search finds at a point."""
    found = vi.find(osc, r, clearance, max_impacts=impacts, max_cycles=cycles, states=0)
    return [motion for motion in found if not motion.pattern.has_rest]


def searched(osc, r, clearance, pattern, guesses, seed=0):
    """Exact motions of a pattern, from random guesses of the phases; some appear several times."""
    draw = np.random.default_rng(seed)
    for _ in range(guesses):
        phases = np.sort(draw.uniform(0, 2 * math.pi * pattern.cycles, len(pattern) - 1))
        with contextlib.suppress(vi.errors.SingularError):
            yield vi.exact(osc, r, clearance, (np.append(0.0, phases), pattern))


def system_of(motion):
    """Return the reference's system of a motion."""
    osc = motion.osc
    return fp.System(
        osc.xi,
        osc.mu,
        motion.r,
        motion.pattern.sides,
        motion.pattern.cycles,
        tuple(motion.restitution),
    )


def after_impact(motion, i=0):
    """State just after an impact of a motion, as `simulate` takes it."""
    return state(
        (motion.alpha[i] + motion.load_phase) / motion.r,
        motion.X[i],
        motion.X_dot_after[i],
        motion.Z[i],
        motion.Z_dot_after[i],
    )


def rest_motion(**changes):
    """Return the exact motion with rest of Figure 9c."""
    return vi.exact(RIG, 0.9, 6.0, settled(8), **changes)


def pair_motion(osc=TABLE, r=0.94, clearance=37.0):
    """The stable motion near the third column of Table 1."""
    return vi.exact(osc, r, clearance, COLUMN)


def triple_motion():
    """Two impacts on the right wall and one on the left, in the zone of Figure 8."""
    found = vi.find(RIG, 0.8195, 6.2, max_impacts=3, max_cycles=1, states=0)
    return next(motion for motion in found if motion.pattern.sides == "RRL")


def state_on(motion):
    """Return the state just after the first impact of a motion."""
    return {
        "t": motion.load_phase / motion.r, "x": motion.X[0], "x_dot": motion.X_dot_after[0],
        "z": motion.Z[0], "z_dot": motion.Z_dot_after[0],
    }  # fmt: skip
