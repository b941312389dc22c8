"""Attractors: exponents, bifurcation diagrams, basins and responses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError
from . import style
from .structure_attractor import axes as structure_axes
from .structure_attractor import symbol

if TYPE_CHECKING:
    from ..studies.basins import Basins
    from ..studies.bifurcation import BifurcationDiagram
    from ..studies.lyapunov import Lyapunov
    from ..studies.response import Response
    from ..systems.units import Units

#: Colour of each wall, and the marks of its impacts. Those of a sweep down are larger and open, and are drawn
#: under those of the sweep up: a dot in a ring is an impact of both sweeps, a dot or ring alone is an impact of
#: one sweep only.
WALLS = {"R": style.PRIMARY, "L": style.FREE}
MARKS = {
    ("R", False): {"marker": ".", "ms": 1.5}, ("L", False): {"marker": "x", "ms": 1.5},
    ("R", True): {"marker": "o", "ms": 2.8, "mfc": "none"},
    ("L", True): {"marker": "D", "ms": 2.6, "mfc": "none"},
}  # fmt: skip

#: The label of a state in which a gap of a structure is closed.
CLOSED = -4
#: Symbols and units of what can be drawn of the impacts.
QUANTITIES = {
    "phase": ("load phase at the impacts", "rad"), "x": ("$X$ at the impacts", "F0/K"),
    "x_dot_before": (r"$\dot X_b$", "omega F0/K"), "x_dot_after": (r"$\dot X_a$", "omega F0/K"),
    "z_dot_before": (r"$\dot Z_b$", "omega F0/K"), "z_dot_after": (r"$\dot Z_a$", "omega F0/K"),
    "approach": (r"$|\dot Z_b - \dot X_b|$", "omega F0/K"),
}  # fmt: skip


def axes(
    ax: Any, result: Any, scales: style.Scales, width: float = style.ONE_COLUMN, height: float = 3.0
) -> Any:
    """The given Axes, or those of a new figure with a line that identifies the system."""
    if ax is not None:
        return ax
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        ax = plt.subplots(figsize=(width, height), layout="constrained")[1]
    swept = getattr(result, "parameter", "")
    names = ("r", "clearance", "load")
    values = style.system(result.osc) | {
        name: getattr(result, name) for name in names if name != swept
    }
    shown = {
        name: item for name, item in values.items() if swept != "restitution" or name[0] != "R"
    }
    style.identify(ax, scales.given(shown))
    return ax


def draw_lyapunov(result: Lyapunov, ax: Any = None, units: Units | None = None) -> Any:
    """The exponents per load cycle, with three standard errors."""
    scales = style.Scales(units)
    ax = axes(ax, result, scales)
    name = "clearance" if np.ptp(result.r) == 0 and np.ptp(result.clearance) > 0 else "r"
    along = scales.of(name, np.ravel(getattr(result, name)))
    order = np.argsort(along, kind="stable")
    values = result.per_cycle.reshape(4, -1)[:, order]
    errors = 3 * result.error_per_cycle.reshape(4, -1)[:, order]
    level = 0.02
    marks = (("o", style.PRIMARY), ("s", style.FREE), ("^", style.REST), ("v", style.IMPACT))
    for j, (marker, color) in enumerate(marks):
        good, none = np.isfinite(values[j]), np.isneginf(values[j])
        ax.errorbar(
            along[order][good], values[j][good], errors[j][good], fmt=marker, ms=2.5, lw=0.6,
            color=color, label=rf"$\lambda_{j + 1}$",
        )  # fmt: skip
        if none.any():
            ax.plot(
                along[order][none], np.full(none.sum(), level), marker, ms=3, mew=0.6, mfc="none",
                color=color, transform=ax.get_xaxis_transform(),
            )  # fmt: skip
            level += 0.04
    if np.isneginf(values).any():  # an exponent of -inf: an open mark at the lower edge
        ax.margins(y=0.15)
        ax.text(1.01, 0.0, r"$-\infty$", transform=ax.transAxes, va="bottom", fontsize=7)
    ax.axhline(0, color="0.6", lw=0.6)
    if style.is_geometric(along[order]):
        style.log_scale(ax, "x")
    ax.set_xlabel(scales.name(name))
    ax.set_ylabel("exponent per load cycle")
    style.add_legend(ax, **style.ABOVE | {"ncols": 4})
    return ax


def draw_bifurcation(
    diagram: BifurcationDiagram, ax: Any = None, quantity: str = "x", units: Units | None = None
) -> Any:
    """The impacts along the parameter, and the periodic windows above them."""
    from matplotlib.transforms import blended_transform_factory

    scales = style.Scales(units)
    ax = axes(ax, diagram, scales, style.TWO_COLUMNS)
    column = scales(diagram.column(quantity), QUANTITIES[quantity][1])
    along = scales.of(diagram.parameter, diagram.values)
    run = np.array(diagram.runs)[diagram.points["run"]]
    both = {"up", "down"} <= set(diagram.runs)
    for (side, down), mark in MARKS.items():
        mine = (diagram.points["side"] == side) & (both & (run == "down") == down)
        if down and not both:
            continue
        ax.plot(
            along[diagram.points["index"][mine]], column[mine], linestyle="", mew=0.4,
            color=WALLS[side], label=f"impacts on {side}" + both * (", down" if down else ", up"),
            zorder=1.9 if down else 2, rasterized=True, **mark,
        )  # fmt: skip
    if style.is_geometric(along):
        style.log_scale(ax, "x")
    above = blended_transform_factory(ax.transData, ax.transAxes)
    even = np.log if style.is_geometric(along) else np.asarray
    longest = np.ptp(even(along))
    for window in diagram.windows:
        level = 1.02 + 0.07 * diagram.runs.index(window.run)
        low, high = scales.of(diagram.parameter, np.array([window.low, window.high]))
        if window.run in ("up", "down") and even(high) - even(low) > 0.03 * longest:
            middle = np.sqrt(low * high) if even is np.log else low + (high - low) / 2
            ax.plot([low, high], [level] * 2, "k-", lw=0.8, transform=above, clip_on=False)
            ax.text(
                middle, level, f"{window.label} {window.run}", ha="center",
                va="bottom", fontsize=6, transform=above,
            )  # fmt: skip
    ax.set_xlabel(scales.name(diagram.parameter))
    ax.set_ylabel(scales.label(*QUANTITIES[quantity]))
    # impacts outside the windows, which are labelled above
    style.add_legend(
        ax,
        markerscale=2,
        **style.ABOVE | {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "ncols": 1},
    )
    return ax


def draw_basins(basins: Basins, ax: Any = None, units: Units | None = None) -> Any:
    """The plane of initial states, one colour for each attractor; undecided states are grey, and white is where a
    gap of a structure is closed."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    if basins.axes is None:
        raise ParameterError(
            "plane = None: must be one for a picture; these states are random or a list"
        )
    scales, size = style.Scales(units), (style.ONE_COLUMN + 1.2, 3.4)
    if basins.of_structure:
        ax = structure_axes(ax, basins, *size)
        shown = [(symbol(axis.name), axis.values) for axis in basins.axes]
    else:
        ax = axes(ax, basins, scales, *size)
        shown = [
            (scales.name(axis.name), scales.of(axis.name, axis.values)) for axis in basins.axes
        ]
    (first, along), (second, across) = shown
    n = len(basins.attractors)
    colors = ["1.0", "0.7", *(style.AREAS[i % len(style.AREAS)] for i in range(n))]
    labels = np.where(basins.labels == CLOSED, -2, np.maximum(basins.labels, -1))
    ax.pcolormesh(
        along, across, labels.T, cmap=ListedColormap(colors), norm=BoundaryNorm(np.arange(-2.5, n), n + 2),
        shading="nearest", rasterized=True,
    )  # fmt: skip
    ax.set_xlabel(first)
    ax.set_ylabel(second)
    named = zip(basins.attractors, basins.fractions, colors[2:], strict=True)
    patches = [Patch(color=c, label=f"{item.name}  {share:.1%}") for item, share, c in named]
    style.add_legend(
        ax, handles=patches, loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7, frameon=False
    )
    return ax


def draw_response(response: Response, ax: Any = None, units: Units | None = None) -> Any:
    """max|X|/A along r: each attractor a dot, and the envelopes over those that coexist."""
    scales = style.Scales(units)
    ax = axes(ax, response, scales)
    every, along = response.attenuation, scales.r(response.r)
    r = np.broadcast_to(along[:, None], every.shape)
    for mask, marker, color, name in (
        (response.cycles > 0, ".", style.PRIMARY, "periodic"),
        (response.cycles == 0, "x", style.FREE, "no period"),
    ):
        ax.plot(r[mask], every[mask], marker, ms=2, mew=0.4, color=color, label=name)
    ax.plot(along, response.highest, "-", color="k", lw=0.8, label="greatest")
    ax.plot(along, response.lowest, "--", color="k", lw=0.8, label="least")
    ax.set_xlabel(scales.name("r"))
    ax.set_ylabel(scales.name("attenuation"))
    style.add_legend(ax, **style.ABOVE)
    return ax
