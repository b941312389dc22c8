"""Branches: solid where stable, dashed where unstable, dotted where inadmissible."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError
from . import style

if TYPE_CHECKING:
    from ..studies.branch import Branch
    from ..systems.units import Units

#: The columns of an oscillator that can be drawn, besides the multipliers.
COLUMNS = (
    "r", "clearance", "xi", "mu", "R1", "R2", "attenuation", "x_max", "x_min", "tau", "A",
)  # fmt: skip
SYMBOLS = {
    "q_max": r"$\max q_{%s}$", "q_min": r"$\min q_{%s}$", "speed": "$v_{%s}$", "impulse": r"$\lambda_{%s}$",
    "phase": r"$\Omega t_{%s}$ (rad)",
}  # fmt: skip
#: The units of these columns, and the number of the first one.
UNITS_OF_STRUCTURE = {
    "q_max": ("F0/K", 0), "q_min": ("F0/K", 0), "speed": ("omega F0/K", 1), "impulse": ("F0/omega", 1),
    "phase": ("", 1),
}  # fmt: skip
MARKERS = {
    "fold": ("o", "k"), "pitchfork": ("P", style.PRIMARY), "flip": ("s", style.FREE),
    "neimark_sacker": ("^", style.REST), "grazing": ("D", style.IMPACT), "zero_approach": ("v", "k"),
    "simultaneous": ("X", "#E69F00"), "branch_point": ("*", "k"),
}  # fmt: skip
STYLES = {"stable": "-", "unstable": "--", "inadmissible": ":"}


def draw_branch(
    branch: Branch, ax: Any = None, y: str | None = None, units: Units | None = None
) -> Any:
    """Draw one column of a branch against its parameter."""
    scales = style.Scales(units, bare=branch.of_structure and units is None)
    columns = columns_of(branch, scales)
    if y is None:
        y = "q_max_0" if branch.of_structure else "attenuation"
    if not isinstance(y, str) or y not in columns:
        raise ParameterError(f"y = {y!r}: must be {', '.join(map(repr, columns))}")
    column, label = columns[y]
    if branch.of_structure:
        along, name = scales.parameter(branch.parameter, branch.values)
    else:
        along, name = scales.of(branch.parameter, branch.values), scales.name(branch.parameter)
    if ax is None:
        with style.pyplot().rc_context(style.SETTINGS):
            _, ax = style.pyplot().subplots(figsize=(style.ONE_COLUMN, 2.8), layout="constrained")
        if not branch.of_structure:
            labelled = ("xi", "mu", "R1", "R2", "r", "clearance")
            style.identify(
                ax, scales.given({name: getattr(branch, name) for name in labelled}),
                f"{branch.pattern.sides}/{branch.pattern.cycles}",
            )  # fmt: skip
    draw_curve(branch, ax, column, along)
    ax.set_xlabel(name)
    ax.set_ylabel(label)
    add_legend_once(ax)
    return ax


def columns_of(branch: Branch, scales: style.Scales) -> dict[str, tuple[Any, str]]:
    """The columns of a branch that can be drawn, with the labels of their axes."""
    largest = np.abs(branch.multipliers).max(axis=0)
    if not branch.of_structure:
        columns = {name: getattr(branch, name) for name in COLUMNS} | {"largest": largest}
        return {
            name: (scales.of(name, values), scales.name(name)) for name, values in columns.items()
        }
    found = {"largest": (largest, r"$\max|\lambda|$")}
    for name, (unit, first) in UNITS_OF_STRUCTURE.items():
        every = getattr(branch, name if first == 0 else f"{name}s")
        found |= {
            f"{name}_{i}": (scales(values, unit), scales.label(SYMBOLS[name] % i, unit))
            for i, values in enumerate(every, start=first)
        }
    return found


def add_legend_once(ax: Any) -> None:
    """A legend with each kind once, even for several branches in the same axes."""
    once = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    style.add_legend(ax, once.values(), once.keys(), **style.ABOVE)


def draw_curve(branch: Branch, ax: Any, column: Any, along: Any) -> None:
    """Draw a column of a branch, styled by its verdicts, and mark the special points."""
    good, stable = branch.admissible == 1, branch.stable == 1
    kinds = {"stable": good & stable, "unstable": good & ~stable, "inadmissible": ~good}
    for name, mask in kinds.items():
        # a segment has the style of either of its end points, so that curves have no gaps where the verdict
        # changes
        pairs = mask[:-1] & (mask[1:] | np.roll(mask, -1)[:-1])
        edges = pairs | (mask[1:] & ~good[:-1] & good[1:])
        shown = np.zeros(len(mask), dtype=bool)
        shown[:-1] |= edges | mask[:-1]
        shown[1:] |= edges | mask[:-1]
        if mask.any():
            ax.plot(
                along, np.where(shown | mask, column, np.nan), STYLES[name],
                color=style.PRIMARY if name != "inadmissible" else "0.6", label=name,
            )  # fmt: skip
    seen: set[str] = set()
    for point in branch.special_points:
        # no marker, and no entry in the legend, where the column has no value
        if point.type not in MARKERS or not np.isfinite(column[point.index]):
            continue
        marker, color = MARKERS[point.type]
        ax.plot(
            along[point.index], column[point.index], marker, color=color, markersize=4,
            label="" if point.type in seen else style.condition_name(point.type),
        )  # fmt: skip
        seen.add(point.type)
