"""The zones as drawn in a chart: thinned polygons, boundary lines by type, and the positions of their names."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Zone
from ..plot.zone import LINES
from ..studies.geometry import signed_area, winding
from .zones import Family, Window

__all__ = ["labels", "thinned", "zone_shapes"]

_Array = NDArray[np.float64]
#: Colours of the zones, those of an atlas.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442")
#: Hatch patterns, which distinguish the zones without colour.
HATCHES = ("/", "\\", "-", "|", ".", "x", "+", "o")
#: A vertex is kept if it is this share of the window away from the last one, or the direction has changed by this
#: angle (radians).
STRIDE, TURN = 0.01, 0.05
#: Width and height of a zone's name, as shares of the window.
LABEL = (0.2, 0.06)


def thinned(points: _Array, window: Window) -> _Array:
    """Only those vertices (M, 2) of a curve that a screen can resolve; they are dense where the curve turns.

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
    """Polygons with holes, boundary lines by type, and the space for its name, of some zones."""
    fills: dict[str, list[Any]] = {"xs": [], "ys": [], "color": [], "hatch": []}
    lines: dict[str, dict[str, list[_Array]]] = {
        name: {"xs": [], "ys": []} for name in LINES if name != "window"
    }
    spaces = {}
    for i, (family, zone) in enumerate(zones.items()):
        window = (zone.r, zone.clearance)
        loops = [thinned(ring, window) for ring in zone.loops]
        for polygon in _polygons(loops):
            fills["xs"].append([[ring[:, 0] for ring in polygon]])
            fills["ys"].append([[ring[:, 1] for ring in polygon]])
            fills["color"].append(color(i))
            fills["hatch"].append(hatch(i))
        for piece in zone.boundary:
            if piece.type != "window":
                points = thinned(np.c_[piece.r, piece.clearance], window)
                lines[piece.type]["xs"].append(points[:, 0])
                lines[piece.type]["ys"].append(points[:, 1])
        spaces[family.short] = label_space(loops, window)
    return {"fills": fills, "lines": lines, "spaces": spaces}


def label_space(loops: Sequence[_Array], window: Window) -> _Array:
    """The space around points of a zone with these loops, in units of the size of a name: 0 on the boundary."""
    r, clearance = np.broadcast_arrays(*lattice(window))
    points = np.stack([r.ravel(), clearance.ravel()], axis=1)
    turns = np.sum([winding(ring, points) for ring in loops], axis=0)
    inside = np.reshape(np.broadcast_to(turns > 0, len(points)), r.shape)
    across, up = (_reach(inside, axis) / (inside.shape[axis] * LABEL[axis]) for axis in (0, 1))
    return np.asarray(np.minimum(across, up))


def lattice(window: Window) -> tuple[_Array, _Array]:
    """Candidate positions of names: r by rows, clearance by columns."""
    return np.linspace(*window[0], 61)[:, None], np.geomspace(*window[1], 101)[None, :]


def labels(
    spaces: dict[str, _Array], window: Window, point: tuple[float, float]
) -> dict[str, list[Any]]:
    """The position of each zone's name: where there is most space within the window, away from the chosen point
    and other names."""
    r, clearance = lattice(window)
    edge = [
        round(0.65 * part * len(ends)) for part, ends in zip(LABEL, (r, clearance.T), strict=True)
    ]
    size = [ends[-1] - ends[0] for ends in (r[:, 0], np.log(clearance[0]))]
    table: dict[str, list[Any]] = {"x": [], "y": [], "text": []}
    taken = [(*point, 0.7)]
    for text, space in spaces.items():
        free = np.zeros_like(space)
        middle = tuple(slice(end, -end) for end in edge)
        free[middle] = space[middle]
        for x, y, part in taken:
            beside = np.abs(r - x) > part * LABEL[0] * size[0]
            free *= beside | (np.abs(np.log(clearance / y)) > (part + 0.3) * LABEL[1] * size[1])
        i, j = np.unravel_index(np.argmax(free), free.shape)
        if free[i, j] < 0.4:
            continue
        place = float(r[i, 0]), float(clearance[0, j])
        taken.append((*place, 1.0))
        for column, value in zip(table.values(), (*place, text), strict=True):
            column.append(value)
    return table


def _reach(inside: NDArray[np.bool_], axis: int) -> NDArray[np.int64]:
    """How far a zone extends in both directions along an axis, in lattice steps."""

    def behind(cells: NDArray[np.bool_]) -> NDArray[np.int64]:
        steps = np.arange(1, len(cells) + 1)[:, None]
        return steps - np.maximum.accumulate(np.where(cells, 0, steps), axis=0)

    cells = np.moveaxis(inside, axis, 0)
    both = np.minimum(behind(cells), behind(cells[::-1])[::-1])
    return np.moveaxis(2 * both, 0, axis)


def color(i: int) -> str:
    """Colour of the zone with that number."""
    return COLORS[i % len(COLORS)]


def hatch(i: int) -> str:
    """Hatch pattern of the zone with that number, as Bokeh's symbol."""
    return HATCHES[i % len(HATCHES)]


def _polygons(rings: list[_Array]) -> list[list[_Array]]:
    """Each outer ring of a zone with its holes."""
    logs = [np.c_[ring[:, 0], np.log(ring[:, 1])] for ring in rings]
    sizes = [signed_area(ring) for ring in logs]
    polygons = {i: [ring] for i, ring in enumerate(rings) if sizes[i] > 0}
    for hole, size in zip(rings, sizes, strict=True):
        around = [i for i in polygons if size <= 0 and winding(rings[i], hole[:1])[0]]
        if around:
            polygons[min(around, key=lambda i: sizes[i])].append(hole)
    return list(polygons.values())
