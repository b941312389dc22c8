"""What the figures show, as plain lists and arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..motion import Motion
from ..plot.history import history as history_of
from ..plot.zone import LINES
from ..studies.bifurcation import BifurcationDiagram
from ..studies.geometry import signed_area, winding
from ..studies.zone import Window, Zone
from ..trajectory import Trajectory
from .zones import Family

__all__ = ["circle", "history", "impacts", "thinned", "zone_shapes"]

_Array = NDArray[np.float64]
#: Colours of the zones, those of an atlas.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
#: A vertex is kept after so much of the window or of a turn (radians).
STRIDE, TURN = 0.01, 0.05
#: Width and height of a zone's name, in parts of the window.
LABEL = (0.15, 0.06)


def thinned(points: _Array, window: Window) -> _Array:
    """The vertices (M, 2) of a curve that a screen can show: dense where it turns.

    Examples
    --------
    >>> import numpy as np
    >>> from vibroimpact.explorer.shapes import thinned
    >>> angle = np.linspace(0, 2 * np.pi, 5000)
    >>> ring = np.c_[1 + 0.1 * np.cos(angle), 10 * 2 ** np.sin(angle)]
    >>> len(thinned(ring, ((0.8, 1.2), (2, 200)))) < 500
    True
    """
    (r0, r1), (d0, d1) = window
    if len(points) < 3:
        return points
    unit = np.c_[points[:, 0] / (r1 - r0), np.log(points[:, 1]) / math.log(d1 / d0)]
    steps = np.diff(unit, axis=0)
    heading = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs(np.remainder(np.diff(heading) + math.pi, 2 * math.pi) - math.pi)
    measure = np.cumsum(np.hypot(*steps.T) / STRIDE)
    measure[1:] += np.cumsum(turns / TURN)
    keep = np.flatnonzero(np.diff(np.floor(measure), prepend=0.0))
    return np.asarray(points[np.union1d([0, len(points) - 1], keep)])


def zone_shapes(zones: dict[Family, Zone]) -> dict[str, Any]:
    """Polygons with holes, boundary lines by type, and labels, of some zones."""
    fills: dict[str, list[Any]] = {"xs": [], "ys": [], "color": []}
    lines: dict[str, dict[str, list[_Array]]] = {
        name: {"xs": [], "ys": []} for name in LINES if name != "window"
    }
    labels: dict[str, list[Any]] = {"x": [], "y": [], "text": []}
    for i, (family, zone) in enumerate(zones.items()):
        window = (zone.r, zone.clearance)
        light = replace(zone, loops=[thinned(ring, window) for ring in zone.loops])
        for polygon in _polygons(light.loops):
            fills["xs"].append([[ring[:, 0] for ring in polygon]])
            fills["ys"].append([[ring[:, 1] for ring in polygon]])
            fills["color"].append(color(i))
        for piece in zone.boundary:
            if piece.type != "window":
                points = thinned(np.c_[piece.r, piece.clearance], window)
                lines[piece.type]["xs"].append(points[:, 0])
                lines[piece.type]["ys"].append(points[:, 1])
        place = label_place(light)
        if place is not None:
            for name, value in zip(("x", "y", "text"), (*place, family.short), strict=True):
                labels[name].append(value)
    return {"fills": fills, "lines": lines, "labels": labels}


def label_place(zone: Zone) -> tuple[float, float] | None:
    """Where a name fits into a zone: where it is thick and wide, as parts of the window; None if it is thin."""
    r = np.linspace(*zone.r, 61)
    clearance = np.geomspace(*zone.clearance, 101)
    inside = zone.contains(r[:, None], clearance[None, :])
    best, most = None, 0.5
    for i in range(8, 53):
        for low, high in _runs(inside[i]):
            j = (low + high - 1) // 2
            wide = next(b - a for a, b in _runs(inside[:, j]) if a <= i < b)
            room = min((high - low) / (100 * LABEL[1]), wide / (60 * LABEL[0]))
            if room > most:
                best, most = (float(r[i]), float(clearance[j])), room
    return best


def _runs(row: NDArray[np.bool_]) -> list[list[int]]:
    """First and past the last of each run of True."""
    edges = np.flatnonzero(np.diff(np.r_[False, row, False].astype(int))).reshape(-1, 2)
    runs: list[list[int]] = edges.tolist()
    return runs


def color(i: int) -> str:
    """Of the zone of that number."""
    return COLORS[i % len(COLORS)]


def _polygons(rings: list[_Array]) -> list[list[_Array]]:
    """Each ring that goes round a zone with its holes."""
    logs = [np.c_[ring[:, 0], np.log(ring[:, 1])] for ring in rings]
    sizes = [signed_area(ring) for ring in logs]
    polygons = {i: [ring] for i, ring in enumerate(rings) if sizes[i] > 0}
    for hole, size in zip(rings, sizes, strict=True):
        around = [i for i in polygons if size <= 0 and winding(rings[i], hole[:1])[0]]
        if around:
            polygons[min(around, key=lambda i: sizes[i])].append(hole)
    return list(polygons.values())


def history(thing: Motion | Trajectory, cycles: float) -> dict[str, dict[str, Any]]:
    """Time history with the walls, the events, and the portrait of the relative motion."""
    h = history_of(thing, cycles)
    half = h.half
    side = np.where(h.events["side"] == "R", 1.0, -1.0)
    kind = h.events["kind"]
    return {
        "curves": {
            "t": h.cycles, "x": h.sample.X, "z": h.sample.Z,
            "right": h.sample.X + half, "left": h.sample.X - half,
            "y": h.sample.Y, "y_dot": h.sample.Z_dot - h.sample.X_dot,
        },
        "events": {
            "t": h.event_cycles, "x": h.events["x"] + side * half, "y": side * half,
            "y_dot": h.events["z_dot_after"] - h.events["x_dot_after"],
            "marker": np.select([kind == "stick", kind == "release"], ["inverted_triangle", "triangle"], "circle"),
        },
    }  # fmt: skip


def circle(motion: Motion | None) -> dict[str, list[Any]]:
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
    return table


def impacts(diagram: BifurcationDiagram) -> dict[str, dict[str, Any]]:
    """Positions at the impacts along the line, wall by wall."""
    points = diagram.points
    along = diagram.values[points["index"]]
    chosen: Iterable[tuple[str, Any]] = ((side, points["side"] == side) for side in "RL")
    return {side: {"along": along[mask], "x": points["x"][mask]} for side, mask in chosen}
