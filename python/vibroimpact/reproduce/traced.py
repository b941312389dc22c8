"""Boundaries traced as curves by `vibroimpact.zone`, for comparison with the zones of `scan.py`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

import vibroimpact

from .. import Oscillator, Pattern
from ..base.errors import ParameterError
from .scan import Strip


def outline(
    osc: Oscillator,
    sides: str,
    r: tuple[float, float],
    strips: Sequence[Strip],
    symmetric: bool | None = None,
    clearance: tuple[float, float] | None = None,
) -> Any:
    """The Zone of a pattern in a window around a scanned one; None if `zone` is not available or finds no such
    zone."""
    find_zone = getattr(vibroimpact, "zone", None)
    if find_zone is None or not strips:
        return None
    lowest = min(float(strip.low.min()) for strip in strips)
    highest = max(float(strip.high.max()) for strip in strips)
    clearance = clearance or (lowest / 1.3, 1.3 * highest)
    try:
        return find_zone(osc, Pattern(sides), r, clearance, symmetric=symmetric)
    except ParameterError:
        return None


def compared(found: Any, strips: Sequence[Strip]) -> str:
    """A text on the number of points near the edges of a scan for which the traced boundary gives the same
    verdict.

    The ends of the scan in r lie on the edge of the window and are omitted, as are points outside it.
    """
    if not found:
        return "no traced boundary"
    kinds = ", ".join(sorted({piece.type for piece in found.boundary} - {"window"}))
    if not found.closed:
        return f"some of the traced boundary is missing ({kinds})"
    r, gap, inside = [], [], []
    for strip in strips:
        for at, low, high in list(zip(*strip, strict=True))[1:-1]:
            if (
                high / low > 1.02
                and found.clearance[0] < low / 1.002 < high * 1.002 < found.clearance[1]
            ):
                r += [at] * 4
                gap += [low / 1.002, low * 1.002, high / 1.002, high * 1.002]
                inside += [False, True, True, False]
    if not r:
        return f"too thin to compare ({kinds})"
    # a point outside one strip may be inside another one
    other = [any(s.contains(x, y) for s in strips) for x, y in zip(r, gap, strict=True)]
    known = np.array(inside, dtype=bool) | np.array(other, dtype=bool)
    same = int((found.contains(np.array(r), np.array(gap)) == known).sum())
    return (
        f"{same} of {known.size} points 0.2 % off the scanned edges have the same verdict by the traced boundary "
        f"({kinds})"
    )
