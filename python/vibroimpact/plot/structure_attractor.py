"""Attractors of structures: exponents, basins, sweeps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import checks
from . import style

#: The marks of sweeps up and down.
MARKS: dict[str, dict[str, Any]] = {
    "up": {"marker": ".", "ms": 2.5, "color": style.PRIMARY},
    "down": {"marker": "o", "ms": 3.5, "mfc": "none", "mew": 0.5, "color": style.FREE},
}
if TYPE_CHECKING:
    from ..studies.bifurcation import BifurcationDiagram
    from ..studies.lyapunov import Lyapunov
    from ..studies.response import Response


def axes(
    ax: Any, result: Any, width: float = style.ONE_COLUMN, height: float = 3.0, swept: str = "",
    pad: float = 6.0,
) -> Any:  # fmt: skip
    """The given Axes, or those of a new figure with a line that identifies the structure, above a legend if `pad`
    leaves room for it."""
    if ax is not None:
        return ax
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        ax = plt.subplots(figsize=(width, height), layout="constrained")[1]
    s, load = result.structure, result.load
    n, gaps = s.coordinates, len(s.gaps)
    text = f"{n} coordinate{'s' if n != 1 else ''}, {gaps} gap{'s' if gaps != 1 else ''}"
    if load is not None and load.frequency and swept != "frequency":
        text += rf", $\Omega$ = {load.frequency:.6g}"
    ax.set_title(text, fontsize=7, pad=pad)
    return ax


def draw_exponents(result: Lyapunov, ax: Any = None) -> Any:
    """The exponents per load cycle, or per unit of time, by their number, with three standard errors."""
    ax = axes(ax, result)
    numbers = np.arange(1, result.per_cycle.size + 1)
    good = np.isfinite(result.per_cycle)
    ax.axhline(0, color="0.6", lw=0.6)
    ax.errorbar(
        numbers[good], result.per_cycle[good], 3 * result.error_per_cycle[good], fmt="o", ms=3, lw=0.8,
        color=style.PRIMARY,
    )  # fmt: skip
    if not good.all():  # an exponent of -inf: an open mark at the lower edge
        ax.plot(
            numbers[~good], np.full((~good).sum(), 0.02), "v", ms=4, mfc="none", color=style.PRIMARY,
            transform=ax.get_xaxis_transform(),
        )  # fmt: skip
        ax.text(1.01, 0.0, r"$-\infty$", transform=ax.transAxes, va="bottom", fontsize=7)
    ax.set_xlim(0.5, numbers[-1] + 0.5)
    ax.set_xlabel("number of the exponent")
    ax.set_ylabel(f"exponent per {result.cycle}")
    return ax


def draw_structure_bifurcation(
    diagram: BifurcationDiagram, ax: Any = None, quantity: str = "q_0"
) -> Any:
    """A quantity along the parameter: dots on the way up, rings on the way down."""
    values = diagram.column(quantity)
    table = diagram.points if quantity in ("phase", "speed") else diagram.strobes
    along, run = diagram.values[table["index"]], np.array(diagram.runs)[table["run"]]
    ax = axes(ax, diagram, style.TWO_COLUMNS, swept=diagram.parameter, pad=16.0)
    for name, mark in MARKS.items():
        here = run == name
        if here.any():
            ax.plot(along[here], values[here], linestyle="", label=name, rasterized=True, **mark)
    ax.set_xlabel(diagram.parameter)
    labels = {"phase": "load phase at the impacts (rad)", "speed": "approach speed"}
    ax.set_ylabel(labels.get(quantity, f"{symbol(quantity)} at load phase 0"))
    style.add_legend(ax, markerscale=2, **style.ABOVE)
    return ax


def draw_structure_response(response: Response, ax: Any = None, coordinate: int = 0) -> Any:
    """The greatest magnitude of a coordinate over the frequency, with and without impacts."""
    n = response.structure.coordinates
    coordinate = checks.integer(coordinate, "coordinate", 0, n - 1)
    ax = axes(ax, response, swept="frequency", pad=16.0)
    largest = response.largest[coordinate]
    for name, sizes in zip(response.runs, largest.T, strict=True):
        ax.plot(response.values, sizes, lw=0.6, label=name, **MARKS[name])
    ax.plot(
        response.values, response.steady_largest[coordinate], "--", color="0.4", lw=0.8,
        label="without impacts",
    )  # fmt: skip
    top = np.nanmax(largest)
    if np.isfinite(top):
        ax.set_ylim(0, 1.6 * top)
    ax.set_xlabel(r"$\Omega$")
    ax.set_ylabel(rf"$\max|q_{{{coordinate}}}|$")
    style.add_legend(ax, **style.ABOVE)
    return ax


def symbol(name: str) -> str:
    """A coordinate or velocity as the label of an axis."""
    kind, _, number = name.rpartition("_")
    return rf"$\dot q_{{{number}}}$" if kind == "q_dot" else f"$q_{{{number}}}$"
