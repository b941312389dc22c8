"""Exact motions whose coefficients of restitution obey a law, and their derivatives."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import SingularError
from ..model import Oscillator, Pattern
from ..motion import Motion
from ..newton import exact, newton
from ..restitution import PowerLaw, Restitution, TabulatedRestitution
from ..structure import Load
from ..structure_motion import StructureMotion, exact_structure

_Array = NDArray[np.float64]
#: Approach speed, over the largest velocity, that counts as none.
TOUCHING = 1e-6
#: Step of a coefficient of restitution for central differences; error of one that obeys its law, and the most
#: steps to there.
STEP, LAWFUL, MOST_STEPS = 1e-5, 1e-12, 20
#: The sharpness of a power law, with which it is one down to where it is 1; exponent of a constant.
SHARP, FLAT = 20.0, 1e-7


class Slopes(NamedTuple):
    """Load phases of the impacts and changes of velocity there, and their derivatives by all of a `Point`."""

    phases: _Array
    jumps: _Array
    by: _Array


class Point(NamedTuple):
    """Where a motion is wanted: the coefficient of an impact is R1 or R2 times (v/speed)^-exponent."""

    r: float
    clearance: float
    xi: float
    mu: float
    R1: float
    R2: float
    exponent: float = 0.0
    #: Of reference, in F0 omega/K; None: the coefficients are constants.
    speed: float | None = None


def described(motion: Motion) -> tuple[_Array, _Array]:
    """Load phases of the impacts, and changes of velocity of the primary mass."""
    return motion.phases + motion.load_phase, motion.X_dot_after - motion.X_dot_before


def approach_speeds(motion: Motion) -> _Array:
    """Approach speeds of the impacts."""
    return np.asarray(motion.pattern.signs * (motion.Z_dot_before - motion.X_dot_before))


def slopes(motion: Motion, point: Point) -> Slopes:
    """The derivatives of a motion."""
    gradient = motion.gradient()
    columns = [
        gradient.parameters.index(name) for name in ("r", "clearance", "xi", "mu", "R1", "R2")
    ]
    phases = (gradient["phases"] + gradient["load_phase"])[:, columns]
    jumps = (gradient["X_dot_after"] - gradient["X_dot_before"])[:, columns]
    by = np.zeros((len(Point._fields), 2, phases.shape[0]))
    by[:6] = np.stack([phases.T, jumps.T], axis=1)
    if point.speed is not None:
        v, R, p = approach_speeds(motion), motion.restitution, point.exponent
        right = motion.pattern.signs > 0
        # of the coefficients at fixed speeds
        rates = np.zeros((len(Point._fields), R.size))
        rates[4], rates[5] = R / point.R1 * right, R / point.R2 * ~right
        rates[6], rates[7] = -R * np.log(v / point.speed), p * R / point.speed
        # and with the speeds, which change by the other parameters and by the coefficients
        rates[:4] -= p * R / v * gradient["approach_speeds"][:, columns[:4]].T
        of_phases, of_jumps, of_speeds = by_restitution(motion)
        changes = np.linalg.solve(np.eye(R.size) + (p * R / v)[:, None] * of_speeds, rates.T)
        by[4:6] = 0.0
        by += np.stack([of_phases @ changes, of_jumps @ changes]).transpose(2, 0, 1)
    if not np.isfinite(by).all():
        raise SingularError(
            f"{motion!r}: has no derivatives: {', '.join(gradient.status.values())}"
        )
    return Slopes(*described(motion), by)


def by_restitution(motion: Motion) -> _Array:
    """Derivatives of load phases, changes of velocity and approach speeds by the coefficient of each impact.

    `Motion.gradient` has those by both walls alone, so these are central differences.
    """
    columns = []
    for change in STEP * np.eye(motion.restitution.size):
        ends = []
        for each in (motion.restitution + change, motion.restitution - change):
            near = with_restitution(motion, each)
            ends.append(np.array([*described(near), approach_speeds(near)]))
        off = ends[0] - ends[1]
        off[0] -= 2 * math.pi * np.round(off[0] / (2 * math.pi))
        columns.append(off / (2 * STEP))
    return np.stack(columns, axis=-1)


def with_restitution(motion: Motion, each: _Array) -> Motion:
    """The motion near another one with a coefficient of restitution for each impact."""
    if not ((each >= 0) & (each <= 1)).all():
        raise SingularError(f"coefficients of restitution {each}: must be from 0 to 1")
    return newton(
        motion.osc, motion.r, motion.clearance, 1.0, motion.pattern, motion.X, motion.phases + motion.tau, each
    )  # fmt: skip


def lawful(point: Point, motion: Motion) -> _Array:
    """The coefficients of restitution by the law at the speeds of a motion."""
    walls = np.where(motion.pattern.signs > 0, point.R1, point.R2)
    if point.speed is None:
        return walls
    return np.asarray(walls * (approach_speeds(motion) / point.speed) ** -point.exponent)


def motion_at(point: Point, guess: Motion | tuple[_Array, Pattern]) -> Motion:
    """The exact motion at a point near another one, whose coefficients obey the law at its own speeds."""
    osc = Oscillator(xi=point.xi, mu=point.mu, restitution=(point.R1, point.R2))
    if point.speed is None:
        return approaching(exact(osc, point.r, point.clearance, guess))
    assert isinstance(guess, Motion)
    motion = newton(
        osc, point.r, point.clearance, 1.0, guess.pattern, guess.X * (point.clearance / guess.clearance),
        guess.phases + guess.tau, guess.restitution,
    )  # fmt: skip
    # Newton's method on the coefficients, with the derivatives of the first motion
    slope = -point.exponent * lawful(point, motion) / approach_speeds(motion)
    matrix = np.eye(slope.size) - slope[:, None] * by_restitution(motion)[2]
    for _ in range(MOST_STEPS):
        off = lawful(point, approaching(motion)) - motion.restitution
        if np.max(abs(off)) < LAWFUL:
            return motion
        motion = with_restitution(motion, motion.restitution + np.linalg.solve(matrix, off))
    raise SingularError(f"{motion!r}: no motion near it obeys the law of restitution")


def approaching(motion: Motion) -> Motion:
    """The motion, if each impact has an approach speed, which is more than a rounding error."""
    speeds = approach_speeds(motion)
    if not speeds.min() > TOUCHING * max(1.0, float(np.max(abs(motion.Z_dot_before)))):
        raise SingularError(f"{motion!r}: the walls are not approached at its impacts")
    return motion


def walls_of(values: Mapping[str, float], unit: float) -> tuple[Restitution, Restitution]:
    """The coefficients of restitution of the right and of the left wall, over speeds in some unit.

    R (v/v0)^-p is `PowerLaw` far above the speed where it is 1, or, if it is nearly constant, far above a
    thousandth of v0. Where it grows with the speed, it is a table from v0/100 to 100 v0.
    """
    walls = []
    for R in (values["R1"], values["R2"]):
        p, v0 = values.get("exponent", 0.0), values.get("v0", unit) / unit
        law: Restitution = R
        if p > FLAT:
            low = max(min(1.0, R) ** (1 / p), 1e-3)
            law = PowerLaw(min(1.0, R * low**-p), low * v0, p, sharpness=SHARP)
        elif p < -FLAT:
            ratios = np.geomspace(0.01, 100, 41)
            law = TabulatedRestitution(v0 * ratios, np.minimum(1.0, R * ratios**-p))
        walls.append(law)
    return walls[0], walls[1]


def motion_of_law(
    osc: Oscillator, r: float, clearance: float, phases: _Array, pattern: Pattern,
    walls: tuple[Restitution, Restitution],
) -> StructureMotion:  # fmt: skip
    """The exact motion with laws of restitution, speeds in F0 omega/K, from load phases of its impacts."""
    pair = osc.structure(clearance, walls)
    gaps = np.where(pattern.signs > 0, 0, 1)
    return exact_structure(pair, Load(r, sine=[1, 0]), (phases, gaps, pattern.cycles))
