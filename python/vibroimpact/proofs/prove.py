"""Proofs of single motions."""

from __future__ import annotations

import time
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from ..base.errors import ParameterError
from ..motions.motion import Motion
from .balls import ball, decimal, flint, hexadecimal, upward
from .certificate import Certificate
from .equations import System, characteristic, determinant, flights, period_map
from .verdicts import between_walls, inside, krawczyk, multiplier_bound

__all__ = ["prove_motion"]

#: Bits of the mantissa, and the sizes of the boxes relative to 1 or to the size of an unknown, in turn.
ATTEMPTS = ((64, 2.0**-34), (64, 2.0**-42), (128, 2.0**-56), (256, 2.0**-120))


def refuse(motion: Motion) -> None:
    """ParameterError for motions whose equations are others."""
    if motion.of_structure:
        raise ParameterError(
            f"motion = {motion!r}: must be one of an Oscillator; a Structure is not supported"
        )
    if motion.pattern.has_rest:
        raise ParameterError(
            f"pattern = {motion.pattern.sides!r}: must be without rest, which proofs do not support"
        )
    if not motion.load > 0:
        raise ParameterError(f"load = {motion.load!r}: must be above 0 for a proof")


def prove_motion(motion: Motion) -> Certificate:
    """As `Motion.prove`."""
    refuse(motion)
    begin = time.perf_counter()
    numbers = (motion.osc.xi, motion.osc.mu, motion.r, motion.clearance, motion.load)
    exact_texts = [decimal(value) for value in numbers]
    walls = [decimal(value) for value in motion.restitution]
    box: dict[str, Any] = {}
    reason = ""
    module = flint()
    for bits, size in ATTEMPTS:
        with module.ctx.workprec(bits):
            xi, mu, r, clearance, load = (ball(one) for one in exact_texts)
            signs, restitution = motion.pattern.signs.tolist(), [ball(one) for one in walls]
            system = System(xi, mu, r, clearance, load, restitution, signs, motion.cycles)
            found, why = attempt(system, motion, size, bits > 64)
        if found or not box:
            box, reason = found, why
        if box and not reason:
            break
    names = ("xi", "mu", "r", "clearance", "load")
    values: dict[str, Any] = dict(zip(names, exact_texts, strict=True)) | {"restitution": walls}
    return Certificate(
        "motion", motion.pattern.sides, motion.cycles, values, [box] if box else [],
        [{"reason": reason}] if reason else [], time.perf_counter() - begin,
    )  # fmt: skip


def attempt(
    system: System, motion: Motion, size: float, refined: bool
) -> tuple[dict[str, Any], str]:
    """A box of a certificate, and what is not decided in it; an empty one where existence is not proven."""
    module = flint()
    columns = (motion.phases, motion.X, motion.X_dot_after, motion.Z_dot_after)
    states = np.stack(columns, axis=1)
    centre = [[module.arb(value) for value in row] for row in states.tolist()]
    largest = np.abs(states).max(axis=0)
    largest[0] = 1.0
    sizes = [float(value) * size for value in largest]
    if refined:
        # Newton's method with more digits: each step from the middle of the last enclosure
        for coarse in (2.0**-30, 2.0**-44, 2.0**-60, 2.0**-90):
            rough = krawczyk(
                system, centre, [[float(one) * coarse for one in largest]] * len(centre)
            )
            if rough is not None:
                centre = [[one.mid() for one in row] for row in rough]
    radii = [sizes] * len(centre)
    enclosed = krawczyk(system, centre, radii)
    if enclosed is None:
        return (
            {},
            "Newton's method does not contract in a box around it (near a fold, pitchfork or graze)",
        )
    found = flights(system, enclosed)
    if not all(flight.tau > 0 for flight in found):
        return {}, "the order of the impacts in time"
    box: dict[str, Any] = {
        "centre": [[hexadecimal(one) for one in row] for row in centre],
        "radius": [[hexadecimal(module.arb(one)) for one in row] for row in radii],
        "exists": True, "admissible": None, "stable": None,
        "multipliers_below": None, "multipliers_above": None, "attenuation_below": None,
    }  # fmt: skip
    admissible, largest_x, reason = between_walls(system, found)
    box["admissible"] = admissible
    if admissible:
        steady = (system.sine * system.sine + system.cosine * system.cosine).sqrt()
        box["attenuation_below"] = decimal_text(upward(largest_x / steady, 4))
    if not all(abs(flight.start[3] - flight.v) > 0 for flight in found):
        return box, reason or "stability: an impact may have no approach speed"
    coefficients = characteristic(period_map(system, found), determinant(system))
    stable = inside(coefficients)
    box["stable"] = stable
    if stable is None:
        return box, "; ".join(
            filter(None, [reason, "stability: a multiplier is too near to the unit circle"])
        )
    bound = multiplier_bound(coefficients, stable)
    if bound is not None:
        box["multipliers_below" if stable else "multipliers_above"] = decimal_text(bound)
    return box, reason


def decimal_text(value: Fraction) -> str:
    """A rational number whose denominator divides a power of ten, as a decimal."""
    digits = 0
    while (value * 10**digits).denominator != 1:
        digits += 1
    return f"{Decimal((value * 10**digits).numerator).scaleb(-digits):f}"
