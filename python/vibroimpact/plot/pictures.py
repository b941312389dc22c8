"""The pictures of results by their classes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .attractor import (
    draw_basins,
    draw_bifurcation,
    draw_exponents,
    draw_lyapunov,
    draw_response,
    draw_structure_bifurcation,
    draw_structure_response,
)
from .branch import draw_branch
from .certificate import draw_certificate
from .chart import draw_chart
from .decay import draw_decay
from .design import draw_design
from .found import draw_found
from .history import draw
from .identify import draw_identification
from .uncertainty import draw_uncertainty
from .zone import draw_atlas, draw_zone

#: The function that draws a result, by class, and of a structure; its options are those of `plot`, in order.
PICTURES: dict[str, Callable[..., Any]] = {
    "Atlas": draw_atlas, "Basins": draw_basins, "BifurcationDiagram": draw_bifurcation, "Branch": draw_branch,
    "Certificate": draw_certificate, "Chart": draw_chart, "Decay": draw_decay, "Design": draw_design,
    "FoundMotions": draw_found, "Identification": draw_identification, "Lyapunov": draw_lyapunov, "Motion": draw,
    "Response": draw_response, "BifurcationDiagram of structures": draw_structure_bifurcation,
    "Lyapunov of structures": draw_exponents, "Response of structures": draw_structure_response,
    "Trajectory": draw, "Uncertainty": draw_uncertainty, "Zone": draw_zone,
}  # fmt: skip


def draw_result(result: Any, *options: Any) -> Any:
    """Draw a result, with the options of its function in order."""
    name = type(result).__name__
    own = f"{name} of structures" if getattr(result, "of_structure", False) else name
    return PICTURES[own if own in PICTURES else name](result, *options)
