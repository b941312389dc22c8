"""Changes of the chart and the diagram as plain data: attributes of their models, by name.

The page's script applies all of them together: one message, and one redraw of each figure.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import BifurcationDiagram
from .shapes import labels
from .zones import Window

__all__ = ["Changes", "diagram", "fit", "packed", "point", "zones"]

#: New values of attributes of models, by the models' names in `figures`; the figures of `sketches` are complete.
Changes = dict[str, dict[str, Any]]


def point(
    r: float,
    clearance: float,
    line: tuple[float, ...] | None,
    spaces: dict[str, Any],
    window: Window,
) -> Changes:
    """The chosen point, the line of the diagram or None, and the zones' names, which are placed away from the
    point."""
    ends = ([], []) if line is None else (line[::2], line[1::2])
    changes: Changes = {
        "zones.point": {"data": {"x": [r], "y": [clearance]}},
        "zones.line": {"data": {"x": list(ends[0]), "y": list(ends[1])}},
        "zones.labels": {"data": labels(spaces, window, (r, clearance))},
    }
    if line is not None:
        changes["diagram.here"] = {"location": clearance if line[0] == line[2] else r}
    return changes


def zones(shapes: dict[str, Any], window: Window) -> Changes:
    """Zones in a window."""
    (left, right), (low, high) = window
    return {
        # slightly more than the window: by rounding the last tick may exceed it
        "zones.x": {"start": left, "end": right + 1e-9 * (right - left)},
        "zones.y": {"start": low, "end": high},
        "zones.ticks": {"ticks": decades(low, high)},
        "zones.fills": {"data": shapes["fills"]},
        **{f"zones.{kind}": {"data": table} for kind, table in shapes["lines"].items()},
    }


def decades(low: float, high: float) -> list[float]:
    """Ticks 1, 2, 5, 10, … between two numbers; evenly spaced ones where these are too few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [float(f"{digit}e{power}") for power in powers for digit in (1, 2, 5)]
    inside = [tick for tick in ticks if low <= tick <= high]
    if len(inside) > 12:
        inside = [tick for tick in inside if f"{tick:e}"[0] == "1"]
    return inside if len(inside) > 2 else np.linspace(low, high, 5).tolist()


def diagram(found: BifurcationDiagram) -> Changes:
    """Positions at the impacts along the line, wall by wall."""
    named = {"r": "frequency ratio  r = Ω/ω", "clearance": "clearance  dK/F₀"}
    points = found.points
    along = found.values[points["index"]]
    changes: Changes = {
        "diagram.along": {"axis_label": named[found.parameter]},
        "diagram.x": ends(found.values, 0),
        "diagram.y": ends(points["x"]),
    }
    for side in "RL":
        mask = points["side"] == side
        changes[f"diagram.{side}"] = {"data": {"along": along[mask], "x": points["x"][mask]}}
    return changes


def ends(values: ArrayLike, margin: float = 0.06) -> dict[str, float]:
    """Of an axis that shows some values."""
    return dict(zip(("start", "end"), fit(values, margin), strict=True))


def fit(values: ArrayLike, margin: float = 0.06) -> tuple[float, float]:
    """The ends of an axis that shows some values, with some margin at both ends."""
    shown = np.asarray(values, dtype=float)
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 1.0)
    size = (high - low) or max(abs(high), 1.0)
    return low - margin * size, high + margin * size


def packed(message: dict[str, Any]) -> tuple[str, NDArray[np.float64]]:
    """A message as JSON, and all its arrays in one array; each is replaced by `{"from": i, "to": j}`.

    Examples
    --------
    >>> import numpy as np
    >>> from vibroimpact.explorer.pictures import packed
    >>> packed({"fault": "", "x": np.array([1.0, 2.0]), "y": np.array([3.0, 4.0])})
    ('{"fault": "", "x": {"from": 0, "to": 2}, "y": {"from": 2, "to": 4}}', array([1., 2., 3., 4.]))
    """
    arrays: list[NDArray[np.float64]] = [np.empty(0)]
    end = 0

    def part(array: NDArray[np.float64]) -> dict[str, int]:
        nonlocal end
        arrays.append(array)
        begin, end = end, end + len(array)
        return {"from": begin, "to": end}

    text = json.dumps(message, default=part, allow_nan=False)
    return text, np.concatenate(arrays)
