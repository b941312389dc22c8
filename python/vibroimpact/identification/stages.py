"""The stages of a fit: each record by itself, then all at once, then with a law of restitution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from .fit import Fit, fit
from .known import OF_LAW, SHARED
from .motions import approach_speeds
from .start import start_of, start_of_times, units_agree
from .steps import Step, refined


def fitted(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float],
    power: bool, law_speed: float | None,
) -> Fit:  # fmt: skip
    """The fit of exact motions to all records."""
    law = shared
    # constants first: what is known of a law does not hold for them
    shared = {name: value for name, value in shared.items() if not (power and name in OF_LAW)}
    shared |= {"exponent": 0.0}
    starts: list[dict[str, float]] = []
    lengths, phases, rings = [], [], []
    for step in steps:
        data = step.data
        assert data is not None
        if data.orders.size:
            first = step.data = refined(step, shared.get("omega", data.Omega * 1.0))
            values, static, phase = start_of(first, shared, guess)
            units_agree(step, first, values, static, scale)
        else:
            values, static, phase = start_of_times(data, scale, shared, guess)
        rings.append(step.ring)
        starts.append(values)
        lengths.append(static)
        phases.append(phase)
    M, K = scale.get("M"), scale.get("K")
    found = [step.data for step in steps if step.data is not None]
    # each record by itself, and then all from what these tell together
    single = [
        fit([data], shared, begin, [length], [phase], ring, M, K, rough=power)
        for data, begin, length, phase, ring in zip(
            found, starts, lengths, phases, rings, strict=True
        )
    ]
    if len(found) == 1 and not power:
        return single[0]
    middle = dict(shared)
    for name in (name for name in SHARED if name not in shared):
        sizes = [
            one.covariance[j, j] if name not in one.undetermined else math.inf
            for one in single for j in [one.names.index(name)]
        ]  # fmt: skip
        weights = np.array([1 / max(size, 1e-300) for size in sizes])
        weights = weights if weights.any() else np.ones(len(single))
        middle[name] = float(np.average([one.values[name] for one in single], weights=weights))
    ring = next((one.ring for one in single if one.ring is not None), None)
    lengths, phases = [one.lengths[0] for one in single], [one.phases[0] for one in single]
    if not power:
        return fit(found, shared, middle, lengths, phases, ring, M, K)
    speed, of_law = start_of_law(single, law, law_speed)
    near = [one.motions[0] for one in single]
    return fit(found, law, middle | of_law, lengths, phases, ring, M, K, speed, near)


def start_of_law(
    single: Sequence[Fit], known: Mapping[str, float], speed: float | None
) -> tuple[float, dict[str, float]]:
    """The reference speed, and a power law through the coefficients of records that were fitted by themselves."""
    units = [one.values["omega"] * one.lengths[0] for one in single]
    all_speeds = [
        unit * approach_speeds(one.motions[0]) for unit, one in zip(units, single, strict=True)
    ]
    if speed is None:
        speed = float(np.exp(np.mean(np.log(np.concatenate(all_speeds)))))
    x, y = np.empty((2, len(single))), np.empty((2, len(single)))
    for i, (one, speeds) in enumerate(zip(single, all_speeds, strict=True)):
        for j, (name, sign) in enumerate((("R1", 1), ("R2", -1))):
            own = one.motions[0].pattern.signs == sign
            x[j, i] = np.mean(np.log(speeds[own] / speed))
            y[j, i] = math.log(min(max(one.values[name], 0.05), 1.0))
    apart = x - x.mean(axis=1, keepdims=True)
    # none where the speeds are nearly alike
    steep = float(np.clip(-np.sum(apart * y) / (np.sum(apart**2) + 1e-2), -0.5, 0.5))
    values = {"exponent": known.get("exponent", steep)}
    for name, level in zip(("R1", "R2"), np.mean(y + values["exponent"] * x, axis=1), strict=True):
        values[name] = known.get(name, float(min(math.exp(level), 0.99)))
    return speed, values
