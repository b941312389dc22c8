"""Flights from Newton's law: a motion of `first_principles` at any time, off the walls, at its extremes."""

import numpy as np
from first_principles import fly, steady, velocities


def flight(motion, t):
    """X, X_dot, Z, Z_dot of a motion at times t within one period, right-continuous."""
    system, t = motion.system, np.asarray(t, float)
    i = np.searchsorted(motion.alpha / system.r, t, side="right") - 1
    time = t - (motion.alpha / system.r)[i]
    x, v = fly(
        system.xi,
        system.r,
        motion.c,
        motion.s,
        motion.alpha[i],
        motion.X[i],
        motion.X_dot_after[i],
        time,
    )
    return x, v, motion.Z[i] + motion.Z_dot_after[i] * time, motion.Z_dot_after[i] + 0.0 * t


def flights(motion, samples):
    """Every flight of a motion, sampled.

    Yields
    ------
    tuple
        Times (samples,) since the impact, X, X_dot, Y = Z - X there, and a bound on the
        acceleration of M: position^2 + velocity^2 of the free part never grows.
    """
    system = motion.system
    time, *_ = velocities(system, motion.alpha, motion.X, motion.clearance)
    for i, period in enumerate(time):
        t = np.linspace(0.0, period, samples)
        angle, X, V = motion.alpha[i], motion.X[i], motion.X_dot_after[i]
        x, v = fly(system.xi, system.r, motion.c, motion.s, angle, X, V, t)
        x0, v0 = steady(system.r, motion.c, motion.s, angle)
        bound = (1 + 2 * system.xi) * np.hypot(X - x0, V - v0) + system.amplitude * system.r**2
        yield t, x, v, motion.Z[i] + motion.Z_dot_after[i] * t - x, bound


def clear_of_walls(motion, samples=600):
    """Whether the ball approaches its wall at every impact and stays off the walls in between.

    In each flight the distance to a wall has a second derivative of at most B, so between two
    samples h apart it is at least the lesser one minus B h^2/8, and it stays positive for 2 v/B
    after leaving the wall with speed v.

    Returns
    -------
    bool or None
        None where the samples do not decide.
    """
    sides = motion.system.signs
    if not np.all(sides * (motion.Z_dot_before - motion.X_dot_before) > 0):
        return False
    verdict = True
    for i, (t, _, v, Y, bound) in enumerate(flights(motion, samples)):
        distance = (0.5 * motion.clearance - np.abs(Y[1:-1])).min()
        if distance < -1e-9 * motion.clearance:
            return False
        leave = sides[i] * (v[0] - motion.Z_dot_after[i])
        arrive = np.roll(sides, -1)[i] * (motion.Z_dot_after[i] - v[-1])
        if 2 * min(leave, arrive) < bound * t[1] or distance < bound * t[1] ** 2 / 8:
            verdict = None
    return verdict


def extremes(motion, samples=600):
    """Least and greatest X over a period, and by how much finer samples could still widen this range."""
    found = [
        (x.min(), x.max(), bound * t[1] ** 2 / 8) for t, x, _, _, bound in flights(motion, samples)
    ]
    low, high, doubt = zip(*found, strict=True)
    return min(low), max(high), max(doubt)
