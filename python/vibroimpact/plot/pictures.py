"""The functions that draw results, by class."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..base.errors import ParameterError
from ..systems.oscillator import Oscillator
from ..systems.units import Units, checked_names, units_of_system, units_to_show
from .animation import animate
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

#: The function that draws a result, by class, with separate entries for structures; its options are those of
#: `plot`, in order.
PICTURES: dict[str, Callable[..., Any]] = {
    "Atlas": draw_atlas, "Basins": draw_basins, "BifurcationDiagram": draw_bifurcation, "Branch": draw_branch,
    "Certificate": draw_certificate, "Chart": draw_chart, "Decay": draw_decay, "Design": draw_design,
    "FoundMotions": draw_found, "Identification": draw_identification, "Lyapunov": draw_lyapunov, "Motion": draw,
    "Response": draw_response, "BifurcationDiagram of structures": draw_structure_bifurcation,
    "Lyapunov of structures": draw_exponents, "Response of structures": draw_structure_response,
    "Trajectory": draw, "Uncertainty": draw_uncertainty, "Zone": draw_zone,
}  # fmt: skip


def draw_result(result: Any, *options: Any, units: Units | str | None = None) -> Any:
    """Draw a result, with the options of its function in order; `units` as in `units_of_picture`."""
    name = type(result).__name__
    own = f"{name} of structures" if getattr(result, "of_structure", False) else name
    function = PICTURES[own if own in PICTURES else name]
    shown = units_of_picture(result, units)
    return function(result, *options) if shown is None else function(result, *options, units=shown)


def animate_result(result: Any, *options: Any, units: Units | str | None = None) -> Any:
    """Animate a result, with the options of `animate` in order; `units` as in `units_of_picture`."""
    film: Any = animate
    return film(result, *options, units=units_of_picture(result, units))


def units_of_picture(result: Any, units: Units | str | None) -> Units | None:
    """The units in which a result is drawn; None for dimensionless pictures.

    Parameters
    ----------
    result
        What is drawn.
    units : Units or str, optional
        By default those of its oscillator, if M, K and F0 are known; "dimensionless" for none.

    Raises
    ------
    ParameterError, ParameterTypeError
        If a unit is not known, or units are given for a result that has no units.
    """
    system: Any = getattr(result, "_system", None)
    if units is None:
        return units_to_show(system) if drawn_in_units(result) else None
    if isinstance(units, Units):
        return units
    if isinstance(units, str) and units == "dimensionless":
        return None
    names = checked_names(units)
    known = units_of_system(system)
    if known is None and not isinstance(system, Oscillator):
        raise ParameterError(
            f"units = {units!r}: must be left out; a Structure uses the units that you choose"
        )
    return (known or system.units()).to(names)


def drawn_in_units(result: Any) -> bool:
    """Whether the picture of a result can be in chosen units; pictures of an Identification are always in SI
    units."""
    return type(result).__name__ not in ("Certificate", "Identification")
