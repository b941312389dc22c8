"""The pictures and animations of results by their classes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .animation import animate
from .attractor import draw_basins, draw_bifurcation, draw_lyapunov, draw_response
from .branch import draw_branch
from .chart import draw_chart
from .decay import draw_decay
from .design import draw_design
from .found import draw_found
from .history import draw
from .identify import draw_identification
from .structure import animate as animate_structure
from .structure import draw_structure
from .structure_attractor import (
    draw_exponents,
    draw_structure_bifurcation,
    draw_structure_response,
)
from .uncertainty import draw_uncertainty
from .zone import draw_atlas, draw_zone

#: The function that draws a result, by class, and of a structure; its options are those of `plot`, in order.
PICTURES: dict[str, Callable[..., Any]] = {
    "Atlas": draw_atlas, "Basins": draw_basins, "BifurcationDiagram": draw_bifurcation, "Branch": draw_branch,
    "Chart": draw_chart, "Decay": draw_decay, "Design": draw_design, "FoundMotions": draw_found,
    "Identification": draw_identification, "Lyapunov": draw_lyapunov, "Motion": draw,
    "Response": draw_response, "BifurcationDiagram of structures": draw_structure_bifurcation,
    "Lyapunov of structures": draw_exponents, "Response of structures": draw_structure_response,
    "Trajectory": draw, "Trajectory of structures": draw_structure, "Uncertainty": draw_uncertainty,
    "Zone": draw_zone,
}  # fmt: skip
#: The function that animates a result, by class, in the same way.
ANIMATIONS: dict[str, Callable[..., Any]] = {
    "Motion": animate, "Trajectory": animate, "Trajectory of structures": animate_structure,
}  # fmt: skip


def draw_result(result: Any, *options: Any) -> Any:
    """Draw a result, with the options of its function in order."""
    return own(PICTURES, result)(result, *options)


def animate_result(result: Any, *options: Any) -> Any:
    """Animate a result, with the options of its function in order."""
    return own(ANIMATIONS, result)(result, *options)


def own(functions: dict[str, Callable[..., Any]], result: Any) -> Callable[..., Any]:
    """The function for the class of a result, and for its system where that has another one."""
    name = type(result).__name__
    of_structure = f"{name} of structures"
    return functions[of_structure if result.of_structure and of_structure in functions else name]
