"""Time histories, acceleration with impact spikes, and the phase portrait of the relative motion."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..results.events import Sample
from .style import (
    ABOVE,
    FREE,
    IMPACT,
    LOAD,
    ONE_COLUMN,
    PRIMARY,
    REST,
    SETTINGS,
    TWO_COLUMNS,
    Scales,
    add_legend,
    given,
    pyplot,
)

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory
    from ..systems.units import Units

__all__ = ["KINDS", "History", "draw", "history"]


#: Units of the fields of a sample.
SAMPLE_UNITS = (
    "F0/K", "omega F0/K", "F0/K", "omega F0/K", "F0/K", "F0", "omega^2 F0/K", "omega^2 F0/K",
)  # fmt: skip


class History(NamedTuple):
    """The data of the panels: times in load cycles, the samples, and the events in the window.

    In physical units all have these; times are then from the start of the window.
    """

    cycles: NDArray[np.float64]
    sample: Sample
    acceleration: NDArray[np.float64]
    events: NDArray[Any]
    event_cycles: NDArray[np.float64]
    half: float
    first: float  #: time at which the window begins
    last: float
    phase: float  #: of the load at `first`
    resting: int  #: side on which the free mass rests at `first`, or 0
    scales: Scales


def draw(
    thing: Motion | Trajectory, ax: Any = None, kind: str | None = None, cycles: float = 3.0,
    window: tuple[float, float] | None = None, units: Units | None = None,
) -> Any:  # fmt: skip
    """Draw one panel into `ax`, or all of them into a new figure.

    Parameters
    ----------
    thing : Motion or Trajectory
    ax : matplotlib Axes, optional
        Without it a figure with all panels is made (or with one, if `kind` is given).
    kind : {"history", "load", "acceleration", "portrait"}, optional
        Which panel; "history" if `ax` is given alone.
    cycles : float
        Load cycles shown: of a motion from its first impact on, of a trajectory its last ones.
    window : (float, float), optional
        Times of a trajectory between which it is drawn, in place of them.

    Returns
    -------
    Axes, or an array of Axes if all panels were drawn.
    """
    if kind is not None:
        checks.choice(kind, "kind", tuple(KINDS))
    cycles = checks.to_float(cycles, "cycles", "a number above 0")
    if not 0 < cycles < math.inf:
        raise ParameterError(f"cycles = {cycles!r}: must be a number above 0")
    shown = history(thing, cycles, window, units)
    plt = pyplot()
    with plt.rc_context(SETTINGS):
        if ax is not None or kind is not None:
            if ax is None:
                _, ax = plt.subplots(figsize=(ONE_COLUMN, 2.4), layout="constrained")
            KINDS[kind or "history"](ax, shown)
            return ax
        figure = plt.figure(figsize=(TWO_COLUMNS, 4.6), layout="constrained")
        grid = figure.add_gridspec(3, 3, height_ratios=(2.2, 0.8, 1.6))
        axes = [figure.add_subplot(grid[0, :2])]
        axes += [figure.add_subplot(grid[i, :2], sharex=axes[0]) for i in (1, 2)]
        axes.append(figure.add_subplot(grid[:, 2]))
        for panel, one in zip(KINDS.values(), axes, strict=True):
            panel(one, shown)
        for one in axes[:2]:
            one.tick_params(labelbottom=False)
            one.set_xlabel("")
        figure.suptitle(_title(thing, shown.scales), fontsize=8)
        return np.array(axes, dtype=object)


def _title(thing: Any, scales: Scales) -> str:
    osc = thing.osc
    values = scales.given({"r": thing.r, "clearance": thing.clearance, "load": thing.load})
    text = (
        rf"$\xi$ = {osc.xi:g}, $\mu$ = {osc.mu:g}, $R_1$ = {osc.restitution[0]:g}, "
        rf"$R_2$ = {osc.restitution[1]:g}, {given(values)}"
    )
    if hasattr(thing, "pattern"):
        text = (
            f"{thing.pattern.sides}/{thing.pattern.cycles}: {thing.verdicts()}\n{text}"
        ).replace("max|lambda|", r"$\max|\lambda|$")
    return text


def history(
    thing: Any, cycles: float, window: tuple[float, float] | None = None, units: Units | None = None
) -> History:  # fmt: skip
    """Samples of a motion or a trajectory, dense enough for a smooth curve, with both sides of each jump."""
    scales = Scales(units)
    cycle = 2 * math.pi / thing.r
    if hasattr(thing, "pattern"):
        first, last = 0.0, cycles * cycle
        repeats = math.ceil(last / thing.period)
        events = np.concatenate([thing.events] * repeats)
        n = len(thing.events)
        events["time"] += np.repeat(np.arange(repeats), n) * thing.period
        phase, resting = thing.load_phase, 0  # the first impact ends the rest, if any
    else:
        first, last = window or (max(thing.start, thing.end - cycles * cycle), thing.end)
        phase = thing.final_state["phase"] + thing.r * (first - thing.end)
        events = thing.events
        state, before = thing.initial_state, events[events["time"] < first]
        resting = int(state["side"]) if state["resting"] else 0
        if before.size:
            side = 1 if before[-1]["side"] == "R" else -1
            resting = side if before[-1]["kind"] == "stick" else 0
    events = events[(events["time"] >= first) & (events["time"] <= last)]
    # the end itself is the start of the next period
    even = np.linspace(first, np.nextafter(last, -np.inf), int(400 * (last - first) / cycle) + 2)
    before = np.nextafter(events["time"], -np.inf)
    times = np.unique(np.concatenate([even, events["time"], before]))
    times = np.clip(times, first, last)
    sample = Sample(
        *(scales(x, unit) for x, unit in zip(thing.sample(times), SAMPLE_UNITS, strict=True))
    )
    shown = events.copy()
    for name in ("x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after"):
        shown[name] = scales(events[name], "F0/K" if name == "x" else "omega F0/K")
    turn = cycle if units is None else 1 / units.time
    return History(
        (times - first) / turn, sample, sample.X_ddot, shown, (events["time"] - first) / turn,
        scales(0.5 * thing.clearance, "F0/K"), first, last, phase, resting, scales,
    )  # fmt: skip


def time_label(h: History) -> str:
    """The label of the axis of time."""
    return h.scales.label("time", "1/omega") if h.scales.units else "time (load cycles)"


def _draw_history(ax: Any, h: History) -> None:
    """x with the two walls that move with it, z between them, and the impacts."""
    ax.fill_between(
        h.cycles, h.sample.X - h.half, h.sample.X + h.half, color=PRIMARY, alpha=0.08, lw=0
    )
    for sign in (1, -1):
        ax.plot(h.cycles, h.sample.X + sign * h.half, color=PRIMARY, lw=0.7, ls=(0, (4, 2)))
    ax.plot(h.cycles, h.sample.X, color=PRIMARY, label=r"$X$ (walls dashed)")
    ax.plot(h.cycles, h.sample.Z, color=FREE, label="$Z$")
    side = np.where(h.events["side"] == "R", 1, -1)
    for kind, marker, colour in (
        ("impact", "o", IMPACT),
        ("stick", "v", REST),
        ("release", "^", REST),
    ):
        chosen = h.events["kind"] == kind
        if chosen.any():
            ax.plot(
                h.event_cycles[chosen], (h.events["x"] + side * h.half)[chosen], marker, color=colour, ms=3,
                label=kind, mew=0,
            )  # fmt: skip
    ax.set_ylabel(h.scales.label("$X$, $Z$", "F0/K"))
    ax.set_xlabel(time_label(h))
    ax.margins(x=0)
    add_legend(
        ax,
        loc="upper right",
        ncols=5,
        bbox_to_anchor=(1.0, 1.16),
        handlelength=1.4,
        columnspacing=1.0,
    )


def _draw_load(ax: Any, h: History) -> None:
    ax.plot(h.cycles, h.sample.load, color=LOAD)
    ax.set_ylabel(h.scales.label("load", "F0"))
    ax.set_xlabel(time_label(h))
    ax.margins(x=0)


def _draw_acceleration(ax: Any, h: History) -> None:
    """Acceleration of the primary mass; the length of the spike at an impact is proportional to its change of
    velocity."""
    ax.plot(h.cycles, h.acceleration, color=PRIMARY)
    impacts = h.events["kind"] == "impact"
    jump = (h.events["x_dot_after"] - h.events["x_dot_before"])[impacts]
    largest = np.abs(jump).max(initial=0.0)
    if largest > 0:
        height = 1.2 * max(np.abs(h.acceleration).max(), 1e-300)
        base = np.interp(h.event_cycles[impacts], h.cycles, h.acceleration)
        tips = base + height * jump / largest
        ax.vlines(
            h.event_cycles[impacts],
            base,
            tips,
            color=IMPACT,
            lw=0.9,
            label=rf"impact: $\Delta\dot X$ (longest: {largest:.3g} {h.scales.unit('omega F0/K')})",
        )
        # above the axes, where it does not cover any curve
        add_legend(
            ax, **ABOVE | {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "handlelength": 1.4}
        )
    ax.set_ylabel(h.scales.label(r"$\ddot X$", "omega^2 F0/K"))
    ax.set_xlabel(time_label(h))
    ax.margins(x=0)


def _draw_portrait(ax: Any, h: History) -> None:
    """Relative velocity over relative position; impacts are jumps along the walls."""
    y, y_dot = h.sample.Y, h.sample.Z_dot - h.sample.X_dot
    ax.axvspan(-h.half, h.half, color=PRIMARY, alpha=0.05, lw=0)
    for wall in (-h.half, h.half):
        ax.axvline(wall, color=PRIMARY, lw=0.7, ls=(0, (4, 2)))
    ax.plot(y, y_dot, color=FREE, lw=0.8)
    ax.set_xlabel(h.scales.label("$Y = Z - X$", "F0/K"))
    ax.set_ylabel(h.scales.label(r"$\dot Y$", "omega F0/K"))


#: The panels, in the order of the figure.
KINDS = {
    "history": _draw_history,
    "load": _draw_load,
    "acceleration": _draw_acceleration,
    "portrait": _draw_portrait,
}
