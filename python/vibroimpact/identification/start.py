"""Where a fit starts: parameters by linear equations, and a motion near the picked impacts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..base.errors import ParameterError
from ..motions.periodic import periodic
from ..systems.oscillator import Oscillator
from .harmonics import Measured
from .known import HINT
from .laws import Law
from .steps import Step

#: Harmonics of the load by which a motion is summed.
MANY = 1000
#: Largest ratio of two load amplitudes that should be the same.
LARGEST_RATIO = 1.5
#: What a wrong unit changes a record by, for the message.
FACTORS = {
    9.80665: "g for m/s^2",
    1000.0: "a milli- or kilo-unit",
    4.448: "lbf for N",
    25.4: "inches for mm",
    39.37: "inches for m",
}


def start_of(
    data: Measured, known: dict[str, float], guess: dict[str, float]
) -> tuple[dict[str, float], float, float]:
    """Parameters to start from, by linear equations: the shared ones, F0/K, and the load phase."""
    values = dict(known)
    k, Omega = data.k, data.Omega
    _, impulse = data.impulses(data.angles, data.jumps)
    w = data.frequencies
    low = data.orders <= 6 * k
    # acceleration times (omega^2 - w^2 + 2 i xi omega w) = -w^2 (impulse + load), for omega^2, 2 xi omega and load
    a, s = data.values[low], w[low]
    turn = np.exp(1j * data.phase) if data.phase is not None else 1.0
    load = np.where(data.orders[low] == k, s * s, 0.0)
    weights = 1 / (s * s * data.errors[low])
    matrix = np.column_stack([a, 1j * a * s, load * -1j * turn, load]) * weights[:, None]
    target = (a * s * s - s * s * impulse[low]) * weights
    fixed = np.zeros(4)
    free = [True, True, True, data.phase is None]
    if "omega" in known:
        fixed[0], free[0] = known["omega"] ** 2, False
        if "xi" in known:
            fixed[1], free[1] = 2 * known["xi"] * known["omega"], False
    target = target - matrix @ fixed
    used = matrix[:, free]
    stacked, flat = np.vstack([used.real, used.imag]), np.concatenate([target.real, target.imag])
    size = np.maximum(np.linalg.norm(stacked, axis=0), 1e-300)
    fixed[free] += np.linalg.lstsq(stacked / size, flat, rcond=1e-10)[0] / size
    omega = math.sqrt(fixed[0]) if fixed[0] > 0 else guess.get("omega", Omega)
    if not 0.2 < Omega / omega < 5:
        omega = guess.get("omega", Omega * 1.02)
    xi = known.get("xi", fixed[1] / (2 * omega))
    if not 1e-4 < xi < 0.5:
        xi = known.get("xi", guess.get("xi", 0.01))
    if data.phase is not None and fixed[2] < 0:
        raise ParameterError(
            "load and motion: must have the same positive direction; the motion answers to the load as if "
            f"its sign were changed: {HINT}"
        )
    force = -1j * turn * fixed[2] + fixed[3]
    phase = float(np.angle(1j * force))
    static = abs(force) / omega**2
    values |= {"omega": omega, "xi": xi}
    # position and velocities of the primary mass at the impacts, by many harmonics of this oscillator
    many = np.arange(1, MANY * k + 1)
    at = many * Omega / k
    x = 2 * Omega / (2 * math.pi * k) * np.exp(-1j * np.outer(many / k, data.angles)) @ data.jumps
    x[k - 1] += force
    x = x / (omega**2 - at**2 + 2j * xi * omega * at)
    turn = np.exp(1j * np.outer(data.angles / k, many))
    X = (turn @ x).real
    mean = (turn @ (1j * at * x)).real
    before, after = mean - data.jumps / 2, mean + data.jumps / 2
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


def start_of_times(
    data: Measured,
    scale: Mapping[str, float],
    shared: Mapping[str, float],
    guess: Mapping[str, float],
) -> tuple[Measured, dict[str, float], float, float]:
    """Jumps and parameters to start from, where there are impact times alone: the linear equations tell D."""
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


def units_agree(
    step: Step,
    data: Measured,
    values: Mapping[str, float],
    static: float,
    scale: Mapping[str, float],
) -> None:
    """An error if the load by its channel is not about the load by the motion."""
    stiffness = scale.get("K", scale.get("M", math.nan) * values["omega"] ** 2)
    if data.F0 is None or not math.isfinite(stiffness):
        return
    ratio = data.F0 / (stiffness * static)
    if 1 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        return
    near = [
        text
        for factor, text in FACTORS.items()
        if abs(abs(math.log(ratio)) - math.log(factor)) < 0.3
    ]
    hint = f"; is it {near[0]}?" if near else ""
    raise ParameterError(
        f"load of {data.F0:.4g} N and {step.quantity}, which tells {stiffness * static:.4g} N: must agree; the "
        "units of a "
        f"channel, or known M and K, are wrong by a factor of {max(ratio, 1 / ratio):.4g}{hint}"
    )
