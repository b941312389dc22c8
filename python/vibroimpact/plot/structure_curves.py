"""Branches of structures, and zones in the plane of two parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError
from . import style
from .branch import add_legend_once, draw_curve
from .zone import FILL, FILLS, LINES, interior_points

if TYPE_CHECKING:
    from ..studies.structure_branch import StructureBranch
    from ..studies.structure_zone import StructureZone

#: Symbols of parameters, and of columns of a branch with a number.
PARAMETERS = {
    "frequency": r"$\Omega$", "load": "load factor", "constant": "factor of the constant forces",
    "damping": "factor of $C$", "stiffness": "factor of $K$", "opening": "$e$", "restitution": "$R$",
    "mass": "$M$", "function": "parameter",
}  # fmt: skip
COLUMNS = {
    "q_max": r"$\max q_{%s}$", "q_min": r"$\min q_{%s}$", "speed": "$v_{%s}$", "impulse": r"$\lambda_{%s}$",
    "phase": r"$\Omega t_{%s}$ (rad)",
}  # fmt: skip


def parameter_label(name: str) -> str:
    """The label of an axis along a parameter."""
    word, *numbers = name.split("_")
    if not numbers:
        return PARAMETERS.get(word, name)
    symbol = {"damping": "C", "stiffness": "K", "mass": "M", "opening": "e", "restitution": "R"}
    return f"${symbol.get(word, word)}_{{{','.join(numbers)}}}$"


def draw_structure_branch(branch: StructureBranch, ax: Any = None, y: str = "q_max_0") -> Any:
    """Draw one column of a branch against its parameter."""
    columns = {
        "largest": (np.abs(branch.multipliers).max(axis=0), r"$\max|\lambda|$"),
        **{f"{name}_{i}": (values, COLUMNS[name] % i) for name in ("q_max", "q_min")
           for i, values in enumerate(getattr(branch, name))},
        **{f"{name}_{i}": (values, COLUMNS[name] % i) for name in ("speed", "impulse", "phase")
           for i, values in enumerate(getattr(branch, f"{name}s"), start=1)},
    }  # fmt: skip
    if not isinstance(y, str) or y not in columns:
        raise ParameterError(f"y = {y!r}: must be {', '.join(map(repr, columns))}")
    column, label = columns[y]
    if ax is None:
        with style.pyplot().rc_context(style.SETTINGS):
            _, ax = style.pyplot().subplots(figsize=(style.ONE_COLUMN, 2.8), layout="constrained")
    draw_curve(branch, ax, column)
    ax.set_xlabel(parameter_label(branch.parameter))
    ax.set_ylabel(label)
    add_legend_once(ax)
    return ax


def draw_structure_zone(zone: StructureZone, ax: Any = None, label: str = "") -> Any:
    """Draw one zone: a light fill, and the pieces of its boundary."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if ax is None:
        with style.pyplot().rc_context(style.SETTINGS):
            _, ax = style.pyplot().subplots(figsize=(style.ONE_COLUMN, 3.0), layout="constrained")
    before = sum(patch.get_label() == FILL for patch in ax.patches)
    rings = [Path(np.r_[ring, ring[:1]], closed=True) for ring in zone.loops]
    ax.add_patch(
        PathPatch(
            Path.make_compound_path(*rings), facecolor=FILLS[before % len(FILLS)], alpha=0.15,
            linewidth=0, label=FILL,
        )
    )  # fmt: skip
    shown = set(ax.get_legend_handles_labels()[1])
    for piece in zone.boundary:
        if piece.type == "window":
            continue
        line, shade = LINES[piece.type]
        name = style.condition_name(piece.type)
        ax.plot(
            piece.x, piece.y, linestyle=line, color=shade, linewidth=1.0,
            label="" if name in shown else name,
        )  # fmt: skip
        shown.add(name)
    place = interior_points(
        np.linspace(*zone.x, 62)[1:-1], np.linspace(*zone.y, 62)[1:-1], zone.contains
    )
    if label and len(place):
        ax.annotate(label, place, ha="center", va="center", fontsize=7)
    ax.set_xlim(*zone.x)
    ax.set_ylim(*zone.y)
    ax.set_xlabel(parameter_label(zone.x_parameter))
    ax.set_ylabel(parameter_label(zone.y_parameter))
    if shown:
        style.add_legend(ax, **style.ABOVE)
    return ax
