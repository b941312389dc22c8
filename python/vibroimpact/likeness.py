"""Which motions are one: written once or several times over, from any impact on, or as a mirror image."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from .errors import SingularError
from .model import Pattern
from .motion import Motion
from .newton import newton, rest_motion
from .states import TWO_PI

#: Two motions are one if positions (over the clearance) and phases differ by less.
SAME = 1e-7


def images(motion: Motion) -> Iterator[Motion]:
    """A motion, written once, and its mirror image where the walls are alike."""
    once = reduced(motion)
    yield once
    if motion.osc.restitution[0] == motion.osc.restitution[1]:
        try:
            image = mirror(turned(once))
        except SingularError:  # on the edge of convergence, as the motion itself
            return
        yield image


def reduced(motion: Motion) -> Motion:
    """The motion written once, if it is written several times over."""
    n, k = len(motion.pattern), motion.pattern.cycles
    for parts in range(math.gcd(n, k), 1, -1):
        if n % parts or k % parts or n // parts < 2:
            continue
        m = n // parts
        letters = motion.pattern.letters
        if letters != letters[:m] * parts:
            continue
        shift = np.append(motion.phases[m:], motion.phases[:m] + TWO_PI * k) - motion.phases
        if np.abs(shift - TWO_PI * k / parts).max() > SAME:
            continue
        if np.abs(np.roll(motion.X, -m) - motion.X).max() > SAME * motion.clearance:
            continue
        pattern = Pattern("".join(letters[:m]), k // parts)
        if motion.rest_events is not None:
            return rest_motion(
                motion.osc, motion.r, motion.clearance, motion.load, pattern.cycles, motion.events
            )
        theta = motion.phases[:m] + motion.tau
        return newton(
            motion.osc, motion.r, motion.clearance, motion.load, pattern, motion.X[:m], theta
        )
    return motion


def turned(motion: Motion) -> Motion:
    """The motion with its impacts counted from the one that puts R before L."""
    letters, n = motion.pattern.letters, len(motion.pattern)
    first = max(range(n), key=lambda j: letters[j:] + letters[:j])
    if first == 0 or motion.rest_events is not None:
        return motion
    pattern = Pattern("".join(letters[first:] + letters[:first]), motion.pattern.cycles)
    theta = (
        np.append(motion.phases[first:], motion.phases[:first] + TWO_PI * pattern.cycles)
        + motion.tau
    )
    x = np.roll(motion.X, -first)
    return newton(motion.osc, motion.r, motion.clearance, motion.load, pattern, x, theta)


def mirror(motion: Motion) -> Motion:
    """The mirror image of a motion of a symmetric system: x -> -x, R <-> L, half a cycle later."""
    pattern = Pattern(
        motion.pattern.sides.translate(str.maketrans("RL", "LR")), motion.pattern.cycles
    )
    if motion.rest_events is not None:
        events = motion.rest_events.copy()
        for name in ("x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after"):
            events[name] *= -1
        events["side"] = np.where(events["side"] == "R", "L", "R")
        events["phase"] = np.mod(events["phase"] + math.pi, TWO_PI)
        return rest_motion(
            motion.osc, motion.r, motion.clearance, motion.load, pattern.cycles, events
        )
    theta = motion.phases + motion.tau + math.pi
    return newton(motion.osc, motion.r, motion.clearance, motion.load, pattern, -motion.X, theta)


def same(one: Motion, other: Motion) -> bool:
    """Whether two motions are one, whichever impact comes first."""
    if len(one.pattern) != len(other.pattern) or one.pattern.cycles != other.pattern.cycles:
        return False
    near = 1e3 * SAME * one.clearance
    if abs(one.X.sum() - other.X.sum()) > len(one.pattern) * near:
        return False
    letters, others = one.pattern.letters, other.pattern.letters
    start = one.phases + one.load_phase
    for j in range(len(others)):
        if letters != others[j:] + others[:j]:
            continue
        later = np.append(other.phases[j:], other.phases[:j] + TWO_PI * other.pattern.cycles)
        gap = later + other.load_phase - start
        gap -= TWO_PI * round(gap[0] / TWO_PI)
        if np.abs(gap).max() < 1e3 * SAME and np.abs(np.roll(other.X, -j) - one.X).max() < near:
            return True
    return False
