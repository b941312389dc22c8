"""Zones in the plane of two parameters, with boundaries distinguished by line style."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..studies.atlas import OUTCOMES_OF_STRUCTURE, Atlas
from ..studies.zone import Piece, Zone, default_label
from ..systems.units import Units
from . import style

#: Line style and colour of each type of boundary; no two types differ only by colour.
LINES = {
    "fold": ("-", "#000000"), "pitchfork": ((0, (6, 1.5)), style.PRIMARY),
    "flip": ((0, (3, 1.2)), style.FREE), "neimark_sacker": ((0, (5, 1, 1, 1)), style.REST),
    "grazing": ((0, (1, 1)), style.IMPACT), "zero_approach": ((0, (1, 2)), "0.4"),
    "simultaneous": ((0, (2, 1, 2, 3)), "#E69F00"), "branch_point": ((0, (3, 4)), "#000000"),
    "rest_vanishes": ((0, (4, 1, 1, 1, 1, 1)), "#56B4E9"), "rest_splits": ((0, (4, 1, 1, 1)), "#CC79A7"),
    "window": ("-", "0.8"),
    "joint": ((0, (1, 4)), "#000000"), "cut": ((0, (2, 4)), "#808080"),
}  # fmt: skip
#: The same for structures, also with stops and friction.
LINES_OF_STRUCTURE = LINES | {
    "stick_begins": ((0, (7, 1, 1, 1)), style.FREE), "stick_vanishes": ((0, (7, 1, 1, 1, 1, 1)), style.REST),
    "contact_vanishes": ((0, (7, 3)), style.IMPACT), "flight_vanishes": ((0, (7, 3, 1, 3)), style.IMPACT),
    "event_vanishes": ((0, (7, 2, 1, 2)), "#000000"),
}  # fmt: skip


#: Mark and colour of the points of a survey that lie in no zone, by outcome; no two differ only by colour.
MARKS = {
    "in no zone": ("*", "#000000"), "beyond the limits": ("^", style.PRIMARY), "chaotic": ("x", "0.45"),
    "not settled": ("+", style.FREE), "not confirmed": ("D", style.IMPACT),
    "event limit reached": ("s", style.REST), "with rest": ("v", style.REST),
}  # fmt: skip


#: Colours of the fills of zones in the same axes, in order, and the label of a fill, which is not shown in a
#: legend.
FILLS = (style.PRIMARY, style.FREE, style.REST, style.IMPACT, "#E69F00", "#56B4E9", "#F0E442")
FILL = "_zone"


class StructurePlane(style.Plane):
    """The plane of two parameters of a structure, over the window of a zone."""

    def __init__(self, zone: Zone | Atlas, units: Units | None) -> None:
        super().__init__(units, False)
        self.zone = zone

    def r(self, values: Any) -> Any:
        return self.parameter(self.zone.x_parameter, values)[0]

    def gap(self, clearance: Any) -> Any:
        return self.parameter(self.zone.y_parameter, clearance)[0]

    def label_axes(self, ax: Any) -> None:
        for axis, name, ends in (
            ("x", self.zone.x_parameter, self.zone.x), ("y", self.zone.y_parameter, self.zone.y),
        ):  # fmt: skip
            values, label = self.parameter(name, np.array(ends))
            ax.set(**{f"{axis}lim": values, f"{axis}label": label})


def draw_zone(
    zone: Zone, ax: Any = None, inverse: bool = False, label: str | None = None, color: str | None = None,
    legend: bool = True, drawn: dict[str, list[Any]] | None = None, units: Units | None = None,
) -> Any:  # fmt: skip
    """Draw one zone: a light fill, the pieces of its boundary, and its name inside.

    Each further zone in the same axes is filled with another colour.

    A boundary shared with another zone of the same figure, contained in `drawn`, is not drawn again: a second
    dashed line would fill the gaps of the first one.
    """
    if zone.of_structure and inverse:
        raise ParameterError("inverse = True: must be False for a zone of a structure")
    plane = StructurePlane(zone, units) if zone.of_structure else style.Plane(units, inverse)
    plt = style.pyplot()
    if ax is None:
        with plt.rc_context(style.SETTINGS):
            _, ax = plt.subplots(figsize=(style.ONE_COLUMN, 3.0), layout="constrained")
        if not zone.of_structure:
            style.log_scale(ax, "y")
            style.identify(ax, plane.given(style.system(zone.osc)))
    before = sum(patch.get_label() == FILL for patch in ax.patches)
    draw_fill(zone, ax, plane, color or FILLS[before % len(FILLS)])
    shown = set(ax.get_legend_handles_labels()[1])
    drawn = {} if drawn is None else drawn
    lines: dict[str, list[Any]] = {}
    for piece in zone.boundary:
        if piece.type == "window":
            continue
        line, shade = LINES_OF_STRUCTURE[piece.type]
        name = style.condition_name(piece.type)
        points = scaled(zone, piece)
        lines.setdefault(piece.type, []).append(points)
        new = ~covered(points, drawn.get(piece.type, []))
        if not new.any():
            continue
        ax.plot(
            plane.r(np.where(new, piece.x, np.nan)), plane.gap(piece.y), linestyle=line, color=shade,
            linewidth=1.0, label="" if name in shown else name,
        )  # fmt: skip
        shown.add(name)
    for kind, some in lines.items():
        drawn.setdefault(kind, []).extend(some)
    if label is None:
        label = "" if zone.of_structure else default_label(zone.pattern, zone.symmetric)
    place_label(zone, ax, plane, label)
    plane.label_axes(ax)
    if legend and shown:
        style.add_legend(ax, **style.ABOVE)
    return ax


def draw_atlas(
    atlas: Atlas, ax: Any = None, inverse: bool = False, units: Units | None = None
) -> Any:
    """Draw all zones of an atlas, each filled in a colour and named.

    The region where the motion without impacts exists is hatched; markers show the survey points that lie in no
    zone.
    """
    if atlas.of_structure and inverse:
        raise ParameterError("inverse = True: must be False for an atlas of a structure")
    plane = StructurePlane(atlas, units) if atlas.of_structure else style.Plane(units, inverse)
    plt = style.pyplot()
    if ax is None:
        with plt.rc_context(style.SETTINGS):
            _, ax = plt.subplots(figsize=(style.TWO_COLUMNS, 4.5), layout="constrained")
        if not atlas.of_structure:
            style.log_scale(ax, "y")
            style.identify(ax, plane.given(style.system(atlas.osc)))
    drawn: dict[str, list[Any]] = {}
    for i, zone in enumerate(sorted(atlas.zones, key=lambda item: -item.area)):
        label = f"{len(zone.gaps)}/{zone.cycles}" if atlas.of_structure else None
        draw_zone(
            zone, ax, inverse, label, FILLS[i % len(FILLS)], legend=False, drawn=drawn, units=units
        )
    if not atlas.of_structure:
        draw_without_impacts(atlas, ax, plane)
    draw_survey(atlas, ax, plane)
    ax.set_xlim(*plane.r(np.array(atlas.x)))
    ax.set_ylim(*np.sort(plane.gap(np.array(atlas.y))))
    style.add_legend(ax, **style.ABOVE | {"ncols": 4})
    return ax


def draw_without_impacts(atlas: Atlas, ax: Any, plane: style.Plane) -> None:
    """Hatch the region where the free mass can rest without contact, and draw its boundary d K/F0 = 2A."""
    low, high = atlas.clearance
    r, least = atlas.without_impacts.boundary()
    if not (least < high).any():
        return
    bounds = plane.gap(np.clip(least, low, high)), plane.gap(np.full(len(r), high))
    ax.fill_between(
        plane.r(r), *bounds, where=least < high, facecolor="none", edgecolor="0.75", hatch="....", linewidth=0,
        label=f"without impacts (${'d' if plane.units else 'dK/F_0'} > 2A$)", zorder=0,
    )  # fmt: skip
    inside = np.where((low <= least) & (least <= high), least, np.nan)
    curve = np.c_[plane.r(r), plane.gap(inside)]
    from matplotlib.collections import LineCollection

    ax.add_collection(
        LineCollection([curve], colors="0.4", linestyles=[(0, (8, 2, 2, 2))], linewidths=1.0)
    )


def draw_survey(atlas: Atlas, ax: Any, plane: style.Plane) -> None:
    """Mark the points of the survey that lie in no zone, with a different mark for each outcome."""
    survey = atlas.survey
    places = {
        name: np.c_[survey.x, survey.y][survey.outcome == code]
        for code, name in enumerate(OUTCOMES_OF_STRUCTURE, start=1)
    }
    places["in no zone"] = np.array([item[:2] for item in atlas.unexplained]).reshape(-1, 2)
    for name, (mark, color) in MARKS.items():
        r, clearance = places[name].T
        if r.size:
            ax.scatter(
                plane.r(r), plane.gap(clearance), s=12, marker=mark, color=color, linewidths=0.7,
                facecolors=None if mark in "x+" else "none", label=f"{name} ({r.size})", zorder=3,
            )  # fmt: skip


def scaled(zone: Zone, piece: Piece) -> NDArray[np.float64]:
    """The vertices (n, 2) of a piece, scaled so that the window is the unit square, with log clearance as
    ordinate."""
    y, (low, high) = piece.y, zone.y
    if not zone.of_structure:
        y, low, high = np.log(y), np.log(low), np.log(high)
    x = (piece.x - zone.x[0]) / (zone.x[1] - zone.x[0])
    return np.asarray(np.c_[x, (y - low) / (high - low)])


def covered(
    points: NDArray[np.float64], lines: list[NDArray[np.float64]], near: float = 2e-3
) -> NDArray[np.bool_]:
    """Which vertices lie, with both their neighbours, on one of some lines."""
    close = np.zeros(len(points), dtype=bool)
    for line in lines:
        start, step = line[:-1], np.diff(line, axis=0)
        length = np.maximum((step**2).sum(axis=1), 1e-300)
        gap = points[:, None] - start
        share = np.clip((gap * step).sum(axis=2) / length, 0, 1)
        away = np.linalg.norm(gap - share[..., None] * step, axis=2)
        close |= away.min(axis=1, initial=np.inf) < near
    padded = np.pad(close, 1, constant_values=True)
    return np.asarray(padded[:-2] & close & padded[2:])


def draw_fill(zone: Zone, ax: Any, plane: style.Plane, color: str) -> None:
    """Fill the zone; holes remain empty because their direction is opposite."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if not zone.loops:
        return
    paths = []
    for ring in zone.loops:
        points = np.c_[plane.r(ring[:, 0]), plane.gap(ring[:, 1])]
        paths.append(Path(np.r_[points, points[:1]], closed=True))
    patch = PathPatch(
        Path.make_compound_path(*paths), facecolor=color, alpha=0.15, linewidth=0, label=FILL
    )
    ax.add_patch(patch)
    ax.autoscale_view()


def place_label(zone: Zone, ax: Any, plane: style.Plane, label: str) -> None:
    """Write a name where the largest loop is widest."""
    if not zone.loops or not label:
        return
    along = np.linspace if zone.of_structure else np.geomspace
    points = interior_points(
        np.linspace(*zone.x, 42)[1:-1], along(*zone.y, 62)[1:-1], lambda x, y: zone._turns(x, y) > 0
    )
    if not len(points):
        return
    x, y = points
    ax.annotate(label, (plane.r(x), plane.gap(y)), ha="center", va="center", fontsize=7)


def interior_points(
    x: NDArray[np.float64], y: NDArray[np.float64], contains: Callable[..., NDArray[np.bool_]]
) -> Any:
    """A point of a zone far from its boundary, on a lattice of the window; none if no lattice point is inside."""
    inside = contains(x[:, None], y[None, :])
    if not inside.any():
        return ()
    depth = inside.astype(int)
    wide = inside
    while wide.any():
        padded = np.pad(wide, 1)
        wide = wide & padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
        depth += wide
    i, j = np.unravel_index(int(np.argmax(depth)), depth.shape)
    return x[i], y[j]
