"""The stages of a fit: each record by itself, then all at once, then with a law of restitution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from .fit import Fit, fit
from .harmonics import Measured
from .known import EXPONENTS, LAWS, names_of
from .motions import exponents
from .start import start_of, start_of_times, units_agree
from .steps import Step, refined


def fitted(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float],
    law: str, law_speed: float | None,
) -> tuple[Fit, float | None]:  # fmt: skip
    """The fit of exact motions to all records, and the reference speed of the law of restitution (m/s)."""
    # constants first: what is known of a law does not hold for them
    constant = {
        name: value for name, value in shared.items()
        if law == "constant" or name not in ("R1", "R2", *EXPONENTS)
    }  # fmt: skip
    M, K = scale.get("M"), scale.get("K")
    found: list[Measured] = []
    single: list[Fit] = []
    for step in steps:
        data = step.data
        assert data is not None
        if data.orders.size:
            data = refined(step, constant.get("omega", data.Omega))
            values, static, phase = start_of(data, constant, guess)
            units_agree(step, data, values, static, scale)
        else:
            data, values, static, phase = start_of_times(data, scale, constant, guess)
        step.data = data
        found.append(data)
        # each record by itself, and then all from what these tell together
        single.append(
            fit(
                [data],
                constant,
                values,
                [static],
                [phase],
                step.ring,
                M,
                K,
                rough=law != "constant",
            )
        )
    if len(found) == 1 and law == "constant":
        return single[0], None
    middle = dict(constant)
    for name in (name for name in names_of("constant") if name not in constant):
        sizes = [
            one.covariance[j, j] if name not in one.undetermined else math.inf
            for one in single for j in [one.names.index(name)]
        ]  # fmt: skip
        weights = np.array([1 / max(size, 1e-300) for size in sizes])
        weights = weights if weights.any() else np.ones(len(single))
        middle[name] = float(np.average([one.values[name] for one in single], weights=weights))
    ring = next((one.ring for one in single if one.ring is not None), None)
    lengths, phases = [one.lengths[0] for one in single], [one.phases[0] for one in single]
    near = [one.motions[0] for one in single]
    speed = None
    if law != "constant":
        speed, of_law = start_of_law(single, found, law, shared, law_speed)
        middle |= of_law
    return fit(found, shared, middle, lengths, phases, ring, M, K, law, speed, near), speed


def start_of_law(
    single: Sequence[Fit], found: Sequence[Measured], law: str, known: Mapping[str, float],
    speed: float | None,
) -> tuple[float, dict[str, float]]:  # fmt: skip
    """The reference speed, and a power law through the coefficients of records that were fitted by themselves."""
    speeds = [one.motions[0].speeds for one in single]
    if speed is None:
        speed = float(np.exp(np.mean(np.log(np.concatenate(speeds)))))
    x, y = np.empty((2, len(single))), np.empty((2, len(single)))
    for i, (one, data) in enumerate(zip(single, found, strict=True)):
        for j, (name, sign) in enumerate((("R1", 1), ("R2", -1))):
            x[j, i] = np.mean(np.log(speeds[i][data.pattern.signs == sign] / speed))
            y[j, i] = math.log(min(max(one.values[name], 0.05), 1.0))
    apart = x - x.mean(axis=1, keepdims=True)
    values: dict[str, float] = {}
    each = LAWS[law]
    for name, own in zip(each, np.split(np.arange(2), len(each)), strict=True):
        # none where the speeds are nearly alike
        steep = -np.sum(apart[own] * y[own]) / (np.sum(apart[own] ** 2) + 1e-2)
        values[name] = known.get(name, float(np.clip(steep, -0.5, 0.5)))
    for name, p, level, at in zip(
        ("R1", "R2"), exponents(values), y.mean(axis=1), x.mean(axis=1), strict=True
    ):
        values[name] = known.get(name, float(min(math.exp(level + p * at), 0.99)))
    return speed, values
