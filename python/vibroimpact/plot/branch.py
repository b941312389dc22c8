"""Branches: solid where stable, dashed where unstable, dotted where inadmissible."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError
from . import style

if TYPE_CHECKING:
    from ..studies.branch import Branch
    from ..studies.structure_branch import StructureBranch
    from ..systems.units import Units

#: What can be drawn.
COLUMNS = (
    "r", "clearance", "xi", "mu", "R1", "R2", "attenuation", "x_max", "x_min", "tau", "largest", "A",
)  # fmt: skip
MARKERS = {
    "fold": ("o", "k"), "pitchfork": ("P", style.PRIMARY), "flip": ("s", style.FREE),
    "neimark_sacker": ("^", style.REST), "grazing": ("D", style.IMPACT), "zero_approach": ("v", "k"),
    "simultaneous": ("X", "#E69F00"), "branch_point": ("*", "k"),
}  # fmt: skip
STYLES = {"stable": "-", "unstable": "--", "inadmissible": ":"}


def draw_branch(
    branch: Branch, ax: Any = None, y: str = "attenuation", units: Units | None = None
) -> Any:
    """Draw one column of a branch against its parameter."""
    scales = style.Scales(units)
    if y == "largest":
        column = np.abs(branch.multipliers).max(axis=0)
    elif y in COLUMNS:
        column = getattr(branch, y)
    else:
        names = [name for name in COLUMNS if name != "largest"]
        raise ParameterError(f"y = {y!r}: must be 'largest' or one of {', '.join(names)}")
    if ax is None:
        with style.pyplot().rc_context(style.SETTINGS):
            _, ax = style.pyplot().subplots(figsize=(style.ONE_COLUMN, 2.8), layout="constrained")
        labelled = ("xi", "mu", "R1", "R2", "r", "clearance")
        style.identify(
            ax, scales.given({name: getattr(branch, name) for name in labelled}),
            f"{branch.pattern.sides}/{branch.pattern.cycles}",
        )  # fmt: skip
    draw_curve(branch, ax, scales.of(y, column), scales.of(branch.parameter, branch.values))
    ax.set_xlabel(scales.name(branch.parameter))
    ax.set_ylabel(scales.name(y))
    add_legend_once(ax)
    return ax


def add_legend_once(ax: Any) -> None:
    """A legend with each kind once, even for several branches in the same axes."""
    once = dict(zip(*reversed(ax.get_legend_handles_labels()), strict=True))
    style.add_legend(ax, once.values(), once.keys(), **style.ABOVE)


def draw_curve(branch: Branch | StructureBranch, ax: Any, column: Any, along: Any = None) -> None:
    """Draw a column of any branch, by its verdicts, and mark the special points."""
    along = branch.values if along is None else along
    good, stable = branch.admissible == 1, branch.stable == 1
    kinds = {"stable": good & stable, "unstable": good & ~stable, "inadmissible": ~good}
    for name, mask in kinds.items():
        # a segment between two points is of a kind if one of them is, so that curves have no gaps at changes
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
