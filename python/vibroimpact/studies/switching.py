"""Guesses for the motions that begin at a bifurcation, made exact by Newton's method."""

from __future__ import annotations

import contextlib
import math

import numpy as np
from numpy.typing import NDArray

from ..errors import VibroimpactError
from ..model import Oscillator, Pattern
from ..motion import Motion
from ..newton import newton
from ..states import TWO_PI
from .conditions import is_symmetric

#: Relative distances from the point along the parameter of the branch at which a new motion is searched, and
#: the sizes of the initial change.
OFFSETS = (1e-4, 1e-3, 5e-3, 2e-2)
SIZES = (0.003, 0.01, 0.03, 0.1)


def critical_change(motion: Motion, multiplier: float) -> NDArray[np.float64]:
    """Change of (x_i, alpha_i) along the eigenvector of a multiplier, (2, N), its largest entry 1."""
    maps = motion.impact_maps()
    product = motion.stability_matrix()
    values, vectors = np.linalg.eig(product)
    state = np.real(vectors[:, int(np.argmin(abs(values - multiplier)))])
    changes = []
    for matrix in maps:
        changes.append(state[[0, 3]])
        state = matrix @ state
    change = np.array(changes).T
    change[0] /= motion.clearance
    result: NDArray[np.float64] = change / abs(change).max()
    return result


def beside(motion: Motion, parameter: str, offset: float) -> tuple[Oscillator, float, float]:
    """Oscillator, r and clearance with one parameter changed relatively (a small one: by 0.01 times the
    offset)."""
    right, left = motion.osc.restitution
    value = {
        "r": motion.r, "clearance": motion.clearance, "xi": motion.osc.xi, "mu": motion.osc.mu,
        "R1": right, "R2": left, "restitution": right,
    }  # fmt: skip
    value[parameter] += offset * max(value[parameter], 0.01)
    if parameter == "restitution":
        value["R1"] = value["R2"] = value["restitution"]
    osc = Oscillator(xi=value["xi"], mu=value["mu"], restitution=(value["R1"], value["R2"]))
    return osc, value["r"], value["clearance"]


def search(
    motion: Motion, pattern: Pattern, x: NDArray[np.float64], theta: NDArray[np.float64],
    change: NDArray[np.float64], parameter: str,
) -> list[Motion]:  # fmt: skip
    """The first motion of a pattern near the point that differs from the motion (x, theta)."""
    for offset in OFFSETS:
        for sign in (1, -1):
            for size in SIZES:
                with contextlib.suppress(VibroimpactError):
                    osc, r, clearance = beside(motion, parameter, sign * offset)
                    found = newton(
                        osc, r, clearance, 1.0, pattern,
                        x + size * change[0] * clearance, theta + size * change[1],
                    )  # fmt: skip
                    moved = found.phases + found.tau - theta
                    moved = np.mod(moved + math.pi, TWO_PI) - math.pi
                    along = np.r_[(found.X - x) / clearance, moved] @ change.ravel()
                    if abs(along) > 0.3 * size * np.sum(change**2):
                        return [found]
    return []


def perturbed(motion: Motion, multiplier: float, parameter: str) -> list[Motion]:
    """The pair of motions that branch off from a symmetric one at a pitchfork."""
    change = critical_change(motion, multiplier)
    theta = motion.phases + motion.tau
    found = search(motion, motion.pattern, motion.X, theta, change, parameter)
    return found + [mirrored(item) for item in found]


def mirrored(motion: Motion) -> Motion:
    """The mirror image of a motion of a pattern whose second half mirrors the first."""
    half = len(motion.pattern) // 2
    theta = motion.phases + motion.tau
    later = np.r_[theta[half:], theta[:half] + TWO_PI * motion.pattern.cycles]
    x = -np.r_[motion.X[half:], motion.X[:half]]
    return newton(
        motion.osc, motion.r, motion.clearance, 1.0, motion.pattern, x,
        later - math.pi * motion.pattern.cycles,
    )  # fmt: skip


def doubled(motion: Motion, parameter: str) -> list[Motion]:
    """The motion of twice the period that begins at a flip."""
    change = critical_change(motion, -1.0)
    cycles = motion.pattern.cycles
    pattern = Pattern(motion.pattern.sides * 2, 2 * cycles)
    theta = motion.phases + motion.tau
    twice = np.r_[theta, theta + TWO_PI * cycles]
    both = np.hstack([change, -change])
    return search(motion, pattern, np.r_[motion.X, motion.X], twice, both, parameter)


def extra_impact(motion: Motion, flight: int, side: str, parameter: str) -> list[Motion]:
    """The motions with an additional impact that begin where the flight after an impact touches a wall.

    A symmetric motion touches the other wall half a period later: a motion with both impacts begins too.
    """
    touches = [(flight, side)]
    found = with_impacts(motion, touches, parameter)
    if is_symmetric(motion):
        half = len(motion.pattern) // 2
        touches.append(((flight + half) % (2 * half), "L" if side == "R" else "R"))
        found += with_impacts(motion, touches, parameter)
    return found


def with_impacts(motion: Motion, touches: list[tuple[int, str]], parameter: str) -> list[Motion]:
    """The motion near the point with an additional impact in each of some flights that touch a wall."""
    sides, phases, x = list(motion.pattern.sides), motion.phases, motion.X
    for flight, side in sorted(touches, reverse=True):
        touch = moment_of_touch(motion, flight, side)
        if touch is None:
            return []
        sides.insert(flight + 1, side)
        phases = np.insert(phases, flight + 1, touch * motion.r)
        x = np.insert(x, flight + 1, float(motion.sample(touch).X))
    pattern = Pattern("".join(sides), motion.pattern.cycles)
    for offset in OFFSETS:
        for sign in (1, -1):
            with contextlib.suppress(VibroimpactError):
                osc, r, clearance = beside(motion, parameter, sign * offset)
                found = newton(
                    osc, r, clearance, 1.0, pattern, x * clearance / motion.clearance,
                    phases + motion.tau,
                )  # fmt: skip
                near = np.abs(found.phases - phases).max() < 0.2
                if near and found.admissible:
                    return [found]
    return []


def moment_of_touch(motion: Motion, flight: int, side: str) -> float | None:
    """The time at which the flight after an impact is nearest to a wall, if that is inside the flight."""
    ends = np.r_[motion.phases, TWO_PI * motion.pattern.cycles]
    times = np.linspace(ends[flight], ends[flight + 1], 4001)[1:-1] / motion.r
    y = (1 if side == "R" else -1) * motion.sample(times).Y
    inner = np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])) + 1
    return float(times[inner[int(np.argmax(y[inner]))]]) if inner.size else None
