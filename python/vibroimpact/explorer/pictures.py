"""What changes in the figures, as plain data: attributes of their models, by name.

The page's script puts all of it into the figures at once: one message, and one picture of each figure.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..motion import Motion
from ..plot.history import history as history_of
from ..studies.bifurcation import BifurcationDiagram
from ..studies.zone import Window
from ..trajectory import Trajectory
from .shapes import labels

__all__ = ["Changes", "diagram", "history", "multipliers", "packed", "point", "zones"]

#: New values of attributes of models, by the models' names in `figures`.
Changes = dict[str, dict[str, Any]]


def point(
    r: float, clearance: float, line: tuple[float, ...] | None, rooms: dict[str, Any], window: Window
) -> Changes:
    """The chosen point, the line of the diagram or None, and the zones' names, which keep away from the point."""
    ends = ([], []) if line is None else (line[::2], line[1::2])
    changes: Changes = {
        "zones.point": {"data": {"x": [r], "y": [clearance]}},
        "zones.line": {"data": {"x": list(ends[0]), "y": list(ends[1])}},
        "zones.labels": {"data": labels(rooms, window, (r, clearance))},
    }
    if line is not None:
        changes["diagram.here"] = {"location": clearance if line[0] == line[2] else r}
    return changes


def zones(shapes: dict[str, Any], window: Window) -> Changes:
    """Zones in a window."""
    (left, right), (low, high) = window
    return {
        # a little more than the window: the last tick is a rounding error above it
        "zones.x": {"start": left, "end": right + 1e-9 * (right - left)},
        "zones.y": {"start": low, "end": high},
        "zones.ticks": {"ticks": decades(low, high)},
        "zones.fills": {"data": shapes["fills"]},
        **{f"zones.{kind}": {"data": table} for kind, table in shapes["lines"].items()},
    }


def decades(low: float, high: float) -> list[float]:
    """Ticks 1, 2, 5, 10, … between two numbers; even ones where that gives too few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [float(f"{digit}e{power}") for power in powers for digit in (1, 2, 5)]
    inside = [tick for tick in ticks if low <= tick <= high]
    if len(inside) > 12:
        inside = [tick for tick in inside if f"{tick:e}"[0] == "1"]
    return inside if len(inside) > 2 else np.linspace(low, high, 5).tolist()


def history(thing: Motion | Trajectory | None, cycles: float) -> Changes:
    """Time history with the walls, the events, and the portrait of the relative motion; None clears."""
    if thing is None:
        curves = dict.fromkeys(("t", "x", "z", "right", "left", "y", "y_dot"), ())
        events = dict.fromkeys(("t", "x", "y", "y_dot", "marker"), ())
        return {"history.curves": {"data": curves}, "history.events": {"data": events}}
    h = history_of(thing, cycles)
    half = h.half
    side = np.where(h.events["side"] == "R", 1.0, -1.0)
    kind = h.events["kind"]
    right, left, y_dot = h.sample.X + half, h.sample.X - half, h.sample.Z_dot - h.sample.X_dot
    marker = np.select(
        [kind == "stick", kind == "release"], ["inverted_triangle", "triangle"], "circle"
    )
    return {
        "history.curves": {"data": {
            "t": h.cycles, "x": h.sample.X, "z": h.sample.Z, "right": right, "left": left,
            "y": h.sample.Y, "y_dot": y_dot,
        }},
        "history.events": {"data": {
            "t": h.event_cycles, "x": h.events["x"] + side * half, "y": side * half,
            "y_dot": h.events["z_dot_after"] - h.events["x_dot_after"], "marker": marker.tolist(),
        }},
        "history.x": fit(h.cycles, 0),
        "history.y": fit(np.r_[left.min(), right.max()]),
        "portrait.x": fit((-half, half)),
        "portrait.y": fit(y_dot),
        "portrait.right": {"location": half},
        "portrait.left": {"location": -half},
    }  # fmt: skip


def multipliers(motion: Motion | None) -> Changes:
    """The multipliers, those far outside at the edge with their modulus beside them."""
    table: dict[str, list[Any]] = {"x": [], "y": [], "marker": [], "text": [], "align": []}
    for value in [] if motion is None else motion.multipliers.tolist():
        if value != value:
            continue
        outside, far = abs(value) >= 1, abs(value) > 1.9
        place = value / abs(value) * 1.75 if far else value
        table["x"].append(place.real)
        table["y"].append(place.imag)
        table["marker"].append("triangle" if far else "x" if outside else "circle")
        table["text"].append(f"{abs(value):.4g}" if far else "")
        table["align"].append("right" if place.real > 0 else "left")
    return {"circle.points": {"data": table}}


def diagram(found: BifurcationDiagram) -> Changes:
    """Positions at the impacts along the line, wall by wall."""
    named = {"r": "frequency ratio  r = Ω/ω", "clearance": "clearance  dK/F₀"}
    points = found.points
    along = found.values[points["index"]]
    changes: Changes = {
        "diagram.along": {"axis_label": named[found.parameter]},
        "diagram.x": fit(found.values, 0),
        "diagram.y": fit(points["x"]),
    }
    for side in "RL":
        mask = points["side"] == side
        changes[f"diagram.{side}"] = {"data": {"along": along[mask], "x": points["x"][mask]}}
    return changes


def fit(values: ArrayLike, room: float = 0.06) -> dict[str, float]:
    """The ends of an axis that shows some values, with some room beside them."""
    low, high = (float(np.min(values)), float(np.max(values))) if np.size(values) else (0.0, 1.0)
    size = (high - low) or max(abs(high), 1.0)
    return {"start": low - room * size, "end": high + room * size}


def packed(changes: Changes) -> dict[str, Any]:
    """As a message: all arrays in one, and in the place of each `{"from": i, "to": j}`.

    Examples
    --------
    >>> import numpy as np
    >>> from vibroimpact.explorer.pictures import packed
    >>> packed({"curve": {"data": {"x": np.array([1.0, 2.0]), "y": np.array([3.0, 4.0])}}})
    {'pictures': {'curve': {'data': {'x': {'from': 0, 'to': 2}, 'y': {'from': 2, 'to': 4}}}}, \
'numbers': array([1., 2., 3., 4.])}
    """
    arrays: list[NDArray[np.float64]] = []
    end = 0

    def pack(value: Any) -> Any:
        nonlocal end
        if isinstance(value, dict):
            return {name: pack(item) for name, item in value.items()}
        if isinstance(value, list | tuple):
            return [pack(item) for item in value]
        if not isinstance(value, np.ndarray):
            return value
        arrays.append(value)
        begin, end = end, end + len(value)
        return {"from": begin, "to": end}

    tree = pack(changes)
    return {"pictures": tree, "numbers": np.concatenate([np.empty(0), *arrays])}
