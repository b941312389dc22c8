"""Attractors: exponents, bifurcation diagrams, basins and responses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError
from ..systems.units import unit_of_state
from . import style

if TYPE_CHECKING:
    from ..studies.basins import Basins
    from ..studies.bifurcation import BifurcationDiagram
    from ..studies.lyapunov import Lyapunov
    from ..studies.response import Response
    from ..systems.units import Units

#: Colour of each wall, and the marks of its impacts. Marks of a sweep down are larger and open, and are drawn
#: under those of the sweep up: a dot in a ring is an impact of both sweeps, a dot or ring alone is an impact of
#: one sweep only.
WALLS = {"R": style.PRIMARY, "L": style.FREE}
MARKS = {
    ("R", False): {"marker": ".", "ms": 1.5}, ("L", False): {"marker": "x", "ms": 1.5},
    ("R", True): {"marker": "o", "ms": 2.8, "mfc": "none"},
    ("L", True): {"marker": "D", "ms": 2.6, "mfc": "none"},
}  # fmt: skip

#: The marks of sweeps of structures.
SWEEPS: dict[str, dict[str, Any]] = {
    "up": {"marker": ".", "ms": 2.5, "color": style.PRIMARY},
    "down": {"marker": "o", "ms": 3.5, "mfc": "none", "mew": 0.5, "color": style.FREE},
}

#: The label of a state in which a gap of a structure is closed.
CLOSED = -4
#: Symbols and units of the quantities of impacts that can be drawn.
QUANTITIES = {
    "phase": ("load phase at the impacts", "rad"), "x": ("$X$ at the impacts", "F0/K"),
    "x_dot_before": (r"$\dot X_b$", "omega F0/K"), "x_dot_after": (r"$\dot X_a$", "omega F0/K"),
    "z_dot_before": (r"$\dot Z_b$", "omega F0/K"), "z_dot_after": (r"$\dot Z_a$", "omega F0/K"),
    "approach": (r"$|\dot Z_b - \dot X_b|$", "omega F0/K"),
}  # fmt: skip


def axes(
    ax: Any, result: Any, scales: style.Scales | None = None, width: float = style.ONE_COLUMN, height: float = 3.0,
    swept: str = "", pad: float = 6.0,
) -> Any:  # fmt: skip
    """The given Axes, or those of a new figure with a line that identifies the system; for a structure, this line
    is above a legend if `pad` leaves room for it."""
    if ax is not None:
        return ax
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        ax = plt.subplots(figsize=(width, height), layout="constrained")[1]
    swept = swept or getattr(result, "parameter", "")
    if result.of_structure:
        s, load = result.structure, result.load
        n, gaps = s.coordinates, len(s.gaps)
        text = f"{n} coordinate{'s' if n != 1 else ''}, {gaps} gap{'s' if gaps != 1 else ''}"
        if load is not None and load.frequency and swept != "frequency":
            units = None if scales is None else scales.units
            text += (
                rf", $\Omega$ = {load.frequency:.6g}" if units is None
                else f", {load.frequency * units.frequency:.6g} {units.hertz}"
            )  # fmt: skip
        ax.set_title(text, fontsize=7, pad=pad)
        return ax
    names = ("r", "clearance", "load")
    values = style.system(result.osc) | {
        name: getattr(result, name) for name in names if name != swept
    }
    shown = {
        name: item for name, item in values.items() if swept != "restitution" or name[0] != "R"
    }
    assert scales
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
    """The plane of initial states, one colour for each attractor; undecided states are grey, and states with a
    closed gap of a structure are white."""
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    if basins.axes is None:
        raise ParameterError(
            "plane = None: must be given for a picture; these states are random or a list"
        )
    scales, size = style.Scales(units), (style.ONE_COLUMN + 1.2, 3.4)
    if basins.of_structure:
        scales = style.Scales(units, bare=units is None)
        ax = axes(ax, basins, scales, *size)
        shown = [
            (scales.label(symbol(axis.name), unit), scales(axis.values, unit))
            for axis in basins.axes for unit in [unit_of_state(axis.name)]
        ]  # fmt: skip
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
    # like the fractions of attractors, a share of the states without a closed gap
    lost = np.sum(labels == -1) / max(1, np.sum(labels > -2))
    for share, name, color in (
        (lost, "undecided", colors[1]), (np.mean(labels == -2), "closed gap", colors[0])
    ):  # fmt: skip
        if share > 0:
            patches.append(Patch(fc=color, ec="0.5", lw=0.5, label=f"{name}  {share:.1%}"))
    style.add_legend(
        ax, handles=patches, loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7, frameon=False
    )
    return ax


def draw_response(response: Response, ax: Any = None, units: Units | None = None) -> Any:
    """max|X|/A along r: a dot for each attractor, and the envelopes over coexisting attractors."""
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


def draw_exponents(result: Lyapunov, ax: Any = None, units: Units | None = None) -> Any:
    """The exponents per load cycle, or per unit of time, by their number, with three standard errors."""
    ax = axes(ax, result, style.Scales(units))
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
    diagram: BifurcationDiagram, ax: Any = None, quantity: str = "q_0", units: Units | None = None
) -> Any:
    """A quantity along the parameter: dots on the way up, rings on the way down."""
    scales = style.Scales(units, bare=units is None)
    unit = {"phase": "", "speed": "omega F0/K"}.get(quantity, unit_of_state(quantity))
    values = scales(diagram.column(quantity), unit)
    table = diagram.points if quantity in ("phase", "speed") else diagram.strobes
    whole, label = scales.parameter(diagram.parameter, diagram.values)
    if diagram._shown == "load":  # of an oscillator; that of a structure is a factor
        whole, label = scales.of("load", diagram.values), scales.label("load amplitude", "F0")
    along, run = whole[table["index"]], np.array(diagram.runs)[table["run"]]
    ax = axes(ax, diagram, scales, style.TWO_COLUMNS, pad=16.0)
    for name, mark in SWEEPS.items():
        here = run == name
        if here.any():
            ax.plot(along[here], values[here], linestyle="", label=name, rasterized=True, **mark)
    ax.set_xlabel(label)
    labels = {"phase": "load phase at the impacts (rad)", "speed": "approach speed"}
    ax.set_ylabel(scales.label(labels.get(quantity, f"{symbol(quantity)} at load phase 0"), unit))
    style.add_legend(ax, markerscale=2, **style.ABOVE)
    return ax


def draw_structure_response(
    response: Response,
    ax: Any = None,
    coordinate: int | str | None = None,
    units: Units | None = None,
) -> Any:
    """The greatest magnitude of a coordinate or output over the frequency, with and without impacts."""
    if coordinate is None:
        coordinate = next(iter(response.structure.outputs), 0)
    size, scales = response.of(coordinate), style.Scales(units, bare=units is None)
    along, label = scales.parameter("frequency", response.values)
    ax = axes(ax, response, scales, swept="frequency", pad=16.0)
    for name, sizes in zip(response.runs, size.largest.T, strict=True):
        ax.plot(along, scales(sizes, "F0/K"), lw=0.6, label=name, **SWEEPS[name])
    steady = scales(size.steady_largest, "F0/K")
    ax.plot(along, steady, "--", color="0.4", lw=0.8, label="without impacts")
    top = scales(np.nanmax(size.largest), "F0/K")
    if np.isfinite(top):
        ax.set_ylim(0, 1.6 * top)
    ax.set_xlabel(label)
    shown = f"q_{{{coordinate}}}"
    if isinstance(coordinate, str):
        shown = rf"\mathrm{{{coordinate}}}".replace("_", r"\_")
    ax.set_ylabel(scales.label(rf"$\max|{shown}|$", "F0/K"))
    style.add_legend(ax, **style.ABOVE)
    return ax


def symbol(name: str) -> str:
    """A coordinate or velocity as the label of an axis."""
    kind, _, number = name.rpartition("_")
    if not number.isdigit() or kind not in ("q", "q_dot"):
        return name
    return rf"$\dot q_{{{number}}}$" if kind == "q_dot" else f"$q_{{{number}}}$"
