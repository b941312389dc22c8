"""The start of a fit: parameters from linear equations, and a motion near the detected impacts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from ..motions.periodic import periodic
from ..systems.oscillator import Oscillator
from .laws import Law
from .least_squares import levenberg
from .motions import PARAMETERS, Impacting, System
from .steps import Step
from .waves import Measured, predicted, turns_of

_Array = NDArray[np.float64]
#: Error of the equations of the impacts, over the largest jump, with which they are part of a fit.
TOGETHER = 1e-5


def start_of(
    step: Step, known: dict[str, float], guess: dict[str, float]
) -> tuple[dict[str, float], float, float]:
    """Initial parameters from linear equations: the shared ones, F0/K, and the load phase."""
    free, data = step.free, step.data
    assert free is not None
    assert data is not None
    values = dict(known)
    k, Omega, static, phase = data.k, data.Omega, free.static, free.phase
    omega, xi = known.get("omega", free.omega), known.get("xi", min(max(free.xi, 1e-3), 0.5))
    values |= {"omega": omega, "xi": xi}
    # position and velocities of the primary mass at the impacts
    X, after = (
        predicted(data, data.angles, order, omega, xi, static, phase, data.angles, data.jumps).value
        for order in (0, 1)
    )
    before = after - data.jumps
    sides = data.pattern.signs.astype(float)
    duration = np.diff(np.append(data.angles, data.angles[0] + 2 * math.pi * k)) / Omega
    of_x = (np.roll(X, -1) - X) / duration
    of_d = 0.5 * (np.roll(sides, -1) - sides) / duration
    # jump = mu (change of z'): mu times (known + d known)
    first, second = np.roll(of_x, 1) - of_x, np.roll(of_d, 1) - of_d
    if "mu" in known and "d" in known:
        mu, d = known["mu"], known["d"]
    elif "mu" in known:
        mu = known["mu"]
        d = float(second @ (data.jumps / mu - first) / (second @ second))
    elif "d" in known:
        d = known["d"]
        sum_of = first + d * second
        mu = float(sum_of @ data.jumps / (sum_of @ sum_of))
    else:
        matrix2 = np.column_stack([first, second])
        scale = np.linalg.norm(matrix2, axis=0)
        U, s, Vt = np.linalg.svd(matrix2 / scale, full_matrices=False)
        good = s > 0.02 * s[0]
        both = Vt.T @ np.where(good, (U.T @ data.jumps) / np.maximum(s, 1e-300), 0) / scale
        mu, d = float(both[0]), float(both[1] / both[0]) if both[0] else -1.0
        if not (good.all() and 0 < mu < 10 and d > 0):
            mu = guess.get("mu", 0.05)
            d = float(second @ (data.jumps / mu - first) / (second @ second))
    if not 0 < mu < 1e6:
        mu = known.get("mu", guess.get("mu", 0.05))
    if not d > 0:
        d = known.get("d", guess.get("d", 2 * float(abs(X).max())))
    values |= {"mu": mu, "d": d}
    z_after = of_x + d * of_d
    z_before = np.roll(z_after, 1)
    for name, sign in (("R1", 1.0), ("R2", -1.0)):
        own = sides == sign
        ratio = -np.sum((after - z_after)[own] * (before - z_before)[own]) / np.sum(
            (before - z_before)[own] ** 2
        )
        values[name] = known.get(name, float(np.clip(ratio, 0.05, 0.99)))
    each = np.clip((z_after - after) / (before - z_before), 0.05, 0.99)
    values |= dict(zip(Law("impacts", each.size).names, each.tolist(), strict=True))
    return values, static, phase


def start_of_phases(
    data: Measured, known: Mapping[str, float], values: Mapping[str, float], static: float
) -> tuple[dict[str, float], float, float, Impacting]:
    """d, F0/K and load phase from the linear equations (26) and (30) for the phases of the impacts, and the
    motion.

    For given phases the equations need no guess. Newton's method then starts from their solution, although its
    load differs from the measured one.
    """
    osc = Oscillator(xi=values["xi"], mu=values["mu"], restitution=(values["R1"], values["R2"]))
    linear = periodic(osc, data.Omega / values["omega"], data.angles - data.angles[0], data.pattern)
    if not linear.clearance > 0:
        raise SingularError(
            f"the linear equations give a clearance of {linear.clearance:.4g}: must be above 0"
        )
    found = {**values, "d": known.get("d", linear.clearance * static)}
    static = found["d"] / linear.clearance
    jumps = (linear.X_dot_after - linear.X_dot_before) * static * values["omega"]
    none = np.empty(0)
    motion = Impacting(data.angles, jumps, none, none, none)
    return found, static, linear.load_phase - float(data.angles[0]), motion


def start_together(
    data: Measured, known: Mapping[str, float], values: Mapping[str, float], static: float, phase: float,
    stiffness: float | None,
) -> tuple[dict[str, float], float, float, Impacting]:  # fmt: skip
    """Parameters and the motion by a fit in which the impacts are free, and their equations are part of the
    residuals.

    Each motion that Newton's method finds on the way may be the one from which the right one branches off at a
    flip or a pitchfork; here the impacts stay near those of the flights.
    """
    system, N = System(data, Law()), data.angles.size
    names = (*PARAMETERS[:4], "F0/K", "phase", "R1", "R2")
    begin = {**values, "F0/K": static, "phase": phase}
    P, size = len(names), float(abs(data.jumps).max())
    typical = {"xi": 0.01, "phase": 0.1, **dict.fromkeys(known, 0.0)}
    scales = [typical.get(name, abs(begin[name])) for name in names]
    turns = turns_of(data, data.places)

    def residuals(x: _Array) -> tuple[_Array, _Array]:
        p, angles, jumps = np.split(x, [P, P + N])
        if (np.diff(angles) <= 0).any():
            raise SingularError("impacts in another order")
        one = predicted(data, data.places, data.order, p[0], p[1], p[4], p[5], angles, jumps, turns)
        J = np.zeros((data.places.size, x.size))
        J[:, [0, 1, 4, 5]] = one.by_system
        one.by_impacts(J[:, P:])
        both = np.column_stack([one.value - data.values, J]) / data.errors[:, None]
        both -= data.beside @ (data.beside.T @ both)
        off, by, _, _ = system.rates(p, angles, jumps)
        by = np.hstack([by[:, 2 * N :], by[:, : 2 * N]])
        rows = [both, np.column_stack([off, by]) / (TOGETHER * size)]
        if data.phase is not None:
            row = np.zeros((1, x.size + 1))
            row[0, [0, 6]] = math.remainder(p[5] - data.phase, 2 * math.pi), 1.0
            rows.append(row / data.phase_error)
        if data.F0 is not None and stiffness is not None:
            row = np.zeros((1, x.size + 1))
            row[0, [0, 5]] = p[4] * stiffness - data.F0, stiffness
            rows.append(row / math.hypot(data.F0_error, data.calibration * data.F0))
        every = np.vstack(rows)
        return every[:, 0], every[:, 1:]

    low = np.array([*[0.0] * 5, -math.inf, 0.0, 0.0, *[-math.inf] * (2 * N)])
    high = np.array([math.inf, 0.9, *[math.inf] * 4, 1.0, 1.0, *[math.inf] * (2 * N)])
    x = np.array([*(begin[name] for name in names), *data.angles, *data.jumps])
    x = levenberg(residuals, x, np.array([*scales, *[0.1] * N, *[size] * N]), low=low, high=high)[0]
    found = {**values, **dict(zip(names, x.tolist(), strict=False))}
    none = np.empty(0)
    motion = Impacting(x[P : P + N], x[P + N :], none, none, none)
    return found, found.pop("F0/K"), found.pop("phase"), motion


def start_of_times(
    data: Measured,
    scale: Mapping[str, float],
    shared: Mapping[str, float],
    guess: Mapping[str, float],
) -> tuple[Measured, dict[str, float], float, float]:
    """Initial jumps and parameters if there are only impact times: the linear equations determine D."""
    values = {**guess, **shared}
    osc = Oscillator(xi=values["xi"], mu=values["mu"], restitution=(values["R1"], values["R2"]))
    linear = periodic(osc, data.Omega / values["omega"], data.angles - data.angles[0], data.pattern)
    static = scale["F0"] / scale["K"] if {"F0", "K"} <= scale.keys() else 1 / linear.clearance
    values.setdefault("d", linear.clearance * static)
    static = values["d"] / linear.clearance
    phase = data.phase if data.phase is not None else linear.load_phase - float(data.angles[0])
    jumps = (linear.X_dot_after - linear.X_dot_before) * static * values["omega"]
    walls = [values["R1" if sign > 0 else "R2"] for sign in data.pattern.signs]
    values |= dict(zip(Law("impacts", len(walls)).names, walls, strict=True))
    return replace(data, jumps=jumps), values, static, phase
