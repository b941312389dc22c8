"""Panels of motions and trajectories.

For an oscillator: time histories, acceleration with impact spikes, and the phase portrait of the relative motion.
For a structure: its sketch, histories, impacts in space and time, and the energy of its modes.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..results.events import Sample
from ..systems.structure import Gap, Stop, opening_at
from ..systems.units import Units
from .sketch import SKETCH_UNITS, bodies_of, draw_sketch, has_bodies
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
    system,
)

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory

__all__ = ["KINDS", "History", "draw", "history"]

#: The colours of Okabe and Ito for lines, except those of impacts and rests.
COLOURS = (PRIMARY, FREE, "#56B4E9", "#E69F00", "0.15", "0.6")
#: Colours of the modes in the picture of energies; free masses have a colour of their own.
BANDS = (PRIMARY, "#56B4E9", "#E69F00", "#F0E442", "0.15", "0.55")
#: Colours of the times of contact and of stick.
SHADES = ("#E69F00", "0.5")
#: Largest number of coordinates in one diagram; more are drawn in separate lanes, one above the other.
OVERLAID = 6
#: Number of samples of a history, and of modes whose shares are shown.
SAMPLES, MODES = 1500, 6
TIME = "time $t$"


#: Units of the fields of a sample.
SAMPLE_UNITS = (
    "F0/K", "omega F0/K", "F0/K", "omega F0/K", "F0/K", "F0", "omega^2 F0/K", "omega^2 F0/K",
)  # fmt: skip


class History(NamedTuple):
    """The data of the panels: times in load cycles, the samples, and the events in the window.

    In physical units, all numbers are in these units, and times are measured from the start of the window.
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
        For a structure, a trajectory.
    ax : matplotlib Axes, optional
        Without it, a new figure is made with all panels, or with a single panel if `kind` is given.
    kind : str, optional
        Which panel: "history", "load", "acceleration" or "portrait"; for a structure "sketch", "history",
        "impacts" or "energy". "history" if only `ax` is given.
    cycles : float
        For an oscillator, the load cycles shown: for a motion, from its first impact on; for a trajectory, the
        last ones.
    window : (float, float), optional
        The time window of a trajectory to draw; by default, for a structure, the whole trajectory.

    Returns
    -------
    Axes, or an array of Axes if all panels were drawn.
    """
    kinds: dict[str, Any] = KINDS_OF_STRUCTURE if thing.of_structure else KINDS
    if kind is not None:
        checks.choice(kind, "kind", tuple(kinds))
    shown: tuple[Any, ...]
    if thing.of_structure:
        shown = of_structure(thing, window, units)
    else:
        cycles = checks.to_float(cycles, "cycles", "a number above 0")
        if not 0 < cycles < math.inf:
            raise ParameterError(f"cycles = {cycles!r}: must be a number above 0")
        shown = (history(thing, cycles, window, units),)
    plt = pyplot()
    with plt.rc_context(SETTINGS):
        if ax is not None or kind is not None:
            if ax is None:
                _, ax = plt.subplots(figsize=(ONE_COLUMN, 2.4), layout="constrained")
            kinds[kind or "history"](ax, *shown)
            return ax
        if thing.of_structure:
            tall = thing.structure.coordinates > OVERLAID
            figure = plt.figure(figsize=(TWO_COLUMNS, 6.6 if tall else 5.6), layout="constrained")
            grid = figure.add_gridspec(3, 2, height_ratios=(1.1, 2.4 if tall else 1.5, 1.5))
            places = (grid[0, :], grid[1, :], grid[2, 0], grid[2, 1])
            axes = [figure.add_subplot(place) for place in places]
        else:
            figure = plt.figure(figsize=(TWO_COLUMNS, 4.6), layout="constrained")
            grid = figure.add_gridspec(3, 3, height_ratios=(2.2, 0.8, 1.6))
            axes = [figure.add_subplot(grid[0, :2])]
            axes += [figure.add_subplot(grid[i, :2], sharex=axes[0]) for i in (1, 2)]
            axes.append(figure.add_subplot(grid[:, 2]))
        for panel, one in zip(kinds.values(), axes, strict=True):
            panel(one, *shown)
        if not thing.of_structure:
            for one in axes[:2]:
                one.tick_params(labelbottom=False)
                one.set_xlabel("")
            figure.suptitle(_title(thing, shown[0].scales), fontsize=8)
        return np.array(axes, dtype=object)


def of_structure(
    run: Any, window: tuple[float, float] | None, units: Units | None
) -> tuple[Any, float, float, Scales]:
    """A trajectory of a structure, in the units of the picture if there are any, the times between which it is
    drawn, and the units of the axes."""
    begin, end = window or (run.start, run.end)
    if units is None:
        return run, begin, end, Scales(None, bare=True)
    physical = run.physical(units)
    # the exact ends of the run, despite rounding
    begin = physical.start if begin == run.start else begin * units.time
    end = physical.end if end == run.end else end * units.time
    return physical, begin, end, Scales(Units(1.0, 1.0, 1.0, units.names))


def _title(thing: Any, scales: Scales) -> str:
    values = {"r": thing.r, "clearance": thing.clearance, "load": thing.load}
    text = given(scales.given(system(thing.osc) | values))
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
    # the end is the start of the next period, so it is left out
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
    """x with the two walls that move with it, z between the walls, and the impacts."""
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


def events_in(run: Trajectory, begin: float, end: float) -> NDArray[Any]:
    """The events of a window."""
    return run.events[(run.events["time"] >= begin) & (run.events["time"] <= end)]


def times_of(run: Trajectory, begin: float, end: float) -> NDArray[np.float64]:
    """Times dense enough for smooth curves, including the events, where curves have corners."""
    times = np.linspace(begin, end, SAMPLES)
    if len(run.events) <= 20 * SAMPLES:
        times = np.union1d(times, events_in(run, begin, end)["time"])
    return times


def spans_of(run: Trajectory) -> dict[str, NDArray[np.float64]]:
    """Beginnings and ends (M, 2) of contacts (with stops, and rests on gaps), and of sticking.

    Before its first event, the state of an element follows from the motion halfway to that event.
    """
    ends = {
        "contact": (("touch", "press", "stick"), ("leave", "let_go", "release")),
        "stick": (("halt",), ("slip_up", "slip_down")),
    }
    gaps = run.structure.gaps
    spans: dict[str, list[tuple[float, float]]] = {"contact": [], "stick": []}
    for j, element in enumerate((*gaps, *run.structure.friction)):
        kind = "contact" if j < len(gaps) else "stick"
        own = run.events[run.events["gap"] == j]
        own = own[np.isin(own["kind"], ends[kind][0] + ends[kind][1])]
        middle = 0.5 * (run.start + (own["time"][0] if len(own) else run.end))
        q, rate = (values[:, 0] for values in run.sample([middle]))
        held: bool
        if isinstance(element, Gap):
            held = j in run.permanent or (len(own) > 0 and own["kind"][0] == "release")
        elif isinstance(element, Stop):
            wall = opening_at(element, np.array([middle]), getattr(run.load, "frequency", 0.0))
            held = float(element.direction @ q - wall[0]) > 0
        else:
            terms = element.direction * rate
            slip = abs(terms.sum() - element.speed)
            held = slip <= 1e-9 * (np.abs(terms).sum() + abs(element.speed))
        begin = run.start
        for event in own:
            if held:
                spans[kind].append((begin, float(event["time"])))
            held, begin = event["kind"] in ends[kind][0], float(event["time"])
        if held:
            spans[kind].append((begin, run.end))
    return {kind: np.reshape(found, (-1, 2)) for kind, found in spans.items()}


def _shade(ax: Any, run: Trajectory, begin: float, end: float) -> None:
    """Shade contact and stick, of a structure with few elements."""
    if len(run.structure.gaps) + len(run.structure.friction) > OVERLAID:
        return
    for (kind, spans), colour in zip(spans_of(run).items(), SHADES, strict=True):
        shown = np.clip(spans, begin, end)
        shown = shown[shown[:, 1] > shown[:, 0]]
        if len(shown):
            ax.broken_barh(
                [(first, last - first) for first, last in shown], (0, 1), color=colour, alpha=0.25, lw=0,
                transform=ax.get_xaxis_transform(), label=kind, zorder=0,
            )  # fmt: skip


def _draw_sketch(ax: Any, run: Trajectory, begin: float, end: float, scales: Scales) -> None:
    draw_sketch(ax, run.structure, run.load)
    if scales.units:
        ax.set_title(SKETCH_UNITS, fontsize=7)


def _mark_events(ax: Any, run: Trajectory, begin: float, end: float, y: Any) -> None:
    """Marks at the coordinates that an event affects; `y` returns their ordinates."""
    events = events_in(run, begin, end)
    q = run.states[:, 0][(run.events["time"] >= begin) & (run.events["time"] <= end)]
    directions = np.array([gap.direction for gap in run.structure.gaps])
    dense = len(events) * len(directions.T) > 3000
    for kind, marker, colour in (
        ("impact", "o", IMPACT), ("stick", "v", REST), ("release", "^", REST),
    ):  # fmt: skip
        chosen = np.flatnonzero(events["kind"] == kind)
        rows = [
            (event, i) for event in chosen for i in np.flatnonzero(directions[events["gap"][event]])
        ]
        if rows:
            which, coordinate = np.array(rows).T
            ax.plot(
                events["time"][which], y(q[which, coordinate], coordinate), marker, color=colour, mew=0,
                ms=1.6 if dense else 2.6, label=kind, zorder=3, clip_on=False,
            )  # fmt: skip


def _draw_coordinates(ax: Any, run: Trajectory, begin: float, end: float, scales: Scales) -> None:
    """The outputs (or the coordinates if there are no outputs) in one diagram or, if there are many, in separate
    lanes; and the events."""
    times = times_of(run, begin, end)
    q = run.sample(times)[0]
    n = len(q)
    _shade(ax, run, begin, end)
    if run.structure.outputs:
        _draw_outputs(ax, run, times, q, scales)
    elif not has_bodies(run.structure):
        _draw_openings(ax, run, times, q, scales)
    elif n <= OVERLAID:
        for i, values in enumerate(q):
            ax.plot(times, values, color=COLOURS[i], label=f"$q_{{{i}}}$", lw=0.9)
        if run.structure.gaps and len(run.events):
            _mark_events(ax, run, begin, end, lambda values, _: values)
        ax.set_ylabel(scales.label("coordinates $q_i$", "F0/K"))
        add_legend(
            ax, loc="lower right", ncols=9, bbox_to_anchor=(1.0, 1.0), handlelength=1.4,
            columnspacing=1.0, borderaxespad=0.2,
        )  # fmt: skip
    else:
        middle = 0.5 * (q.max(1) + q.min(1))
        scale = max(float(np.ptp(q, axis=1).max()) / 3, 1e-300)
        alone = {body[0] for body in bodies_of(run.structure) if len(body) == 1}
        for i, values in enumerate(q):
            colour = FREE if i in alone else PRIMARY
            ax.plot(times, i + (values - middle[i]) / scale, color=colour, lw=0.6)
        if run.structure.gaps and len(run.events):
            _mark_events(ax, run, begin, end, lambda v, i: i + (v - middle[i]) / scale)
        ax.set_ylabel("number of the coordinate")
        low = min(i + float((values - middle[i]).min()) / scale for i, values in enumerate(q))
        high = max(i + float((values - middle[i]).max()) / scale for i, values in enumerate(q))
        ax.set_ylim(min(-0.8, low - 0.3), max(n - 0.2, high + 0.3))
        ax.plot([], [], color=PRIMARY, label="coupled")
        if alone:
            ax.plot([], [], color=FREE, label="free masses")
        ax.errorbar([], [], yerr=[], color="k", lw=0, label=f"one division: {scale:.3g}")
        add_legend(
            ax, loc="lower right", ncols=6, bbox_to_anchor=(1.0, 1.0), handlelength=1.4,
            columnspacing=1.0, borderaxespad=0.2,
        )  # fmt: skip
    ax.set_xlabel(scales.label(TIME, "1/omega"))
    ax.set_xlim(begin, end)


def _draw_outputs(
    ax: Any, run: Trajectory, times: NDArray[Any], q: NDArray[Any], scales: Scales
) -> None:
    """The outputs by name, with the impacts."""
    begin, end = float(times[0]), float(times[-1])
    chosen = (run.events["time"] >= begin) & (run.events["time"] <= end)
    chosen &= run.events["kind"] == "impact"
    hits = run.events["time"][chosen]
    for i, (name, row) in enumerate(run.structure.outputs.items()):
        ax.plot(times, row @ q, color=COLOURS[i % len(COLOURS)], lw=0.9, label=name)
        label = "" if i else "impact"
        if len(hits):
            ax.plot(
                hits, run.states[chosen, 0] @ row, "o", color=IMPACT, ms=2.6, mew=0, label=label
            )
    ax.set_ylabel(scales.label("outputs", "F0/K"))
    add_legend(
        ax, loc="lower right", ncols=9, bbox_to_anchor=(1.0, 1.0), handlelength=1.4, columnspacing=1.0,
        borderaxespad=0.2,
    )  # fmt: skip


def _draw_openings(
    ax: Any, run: Trajectory, times: NDArray[Any], q: NDArray[Any], scales: Scales
) -> None:
    """The openings of the gaps, if coordinates are not displacements of bodies."""
    begin, end = float(times[0]), float(times[-1])
    for j, gap in enumerate(run.structure.gaps[:OVERLAID]):
        opening = opening_at(gap, times, getattr(run.load, "frequency", 0.0))
        ax.plot(times, opening - gap.direction @ q, color=COLOURS[j], lw=0.9, label=f"gap {j}")
    events = events_in(run, begin, end)
    for kind, marker, colour in (
        ("impact", "o", IMPACT),
        ("stick", "v", REST),
        ("release", "^", REST),
    ):
        own = events[(events["kind"] == kind) & (events["gap"] < OVERLAID)]["time"]
        if len(own):
            ax.plot(
                own, np.zeros(len(own)), marker, color=colour, ms=2.6, mew=0, label=kind, zorder=3
            )
    ax.axhline(0, color="0.5", lw=0.6)
    ax.set_ylabel(scales.label("opening $e_j - G_j q$", "F0/K"))
    add_legend(
        ax, loc="lower right", ncols=9, bbox_to_anchor=(1.0, 1.0), handlelength=1.4, columnspacing=1.0,
        borderaxespad=0.2,
    )  # fmt: skip


def _draw_impacts(ax: Any, run: Trajectory, begin: float, end: float, scales: Scales) -> None:
    """Approach speeds over time for few gaps and stops; for many, a raster of gaps and times with the speed as
    colour; without any, the speeds of sliding."""
    events = events_in(run, begin, end)
    events = events[np.isin(events["kind"], ("impact", "touch"))]
    gaps = len(run.structure.gaps)
    if not gaps:
        _draw_sliding(ax, run, begin, end, scales)
        return
    if gaps <= 4:
        for j in range(gaps):
            own = events[events["gap"] == j]
            if len(own):
                ax.vlines(own["time"], 0, own["speed"], color=COLOURS[j], lw=0.6, clip_on=False)
                ax.plot(
                    own["time"],
                    own["speed"],
                    "os^D"[j],
                    color=COLOURS[j],
                    ms=2.6,
                    mew=0,
                    label=f"gap {j}",
                    clip_on=False,
                )
        ax.set_ylabel(scales.label("approach speed $v$", "omega F0/K"))
        ax.set_ylim(bottom=0)
        if len(events):
            add_legend(ax, loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), handlelength=1.0,
                       columnspacing=1.0, borderaxespad=0.2)  # fmt: skip
    else:
        size = min(14.0, max(1.5, 2.5e4 / max(1, len(events)) / 20))
        dots = ax.scatter(
            events["time"], events["gap"], c=events["speed"], s=size, cmap="viridis_r", linewidths=0,
        )  # fmt: skip
        ax.set_ylabel("number of the gap")
        ax.set_ylim(gaps - 0.5, -0.5)
        if len(events):
            bar = ax.figure.colorbar(dots, ax=ax, pad=0.02)
            bar.set_label(scales.label("approach speed $v$", "omega F0/K"))
            bar.outline.set_visible(False)
    ax.set_xlabel(scales.label(TIME, "1/omega"))
    ax.set_xlim(begin, end)


def _draw_sliding(ax: Any, run: Trajectory, begin: float, end: float, scales: Scales) -> None:
    """The speed of sliding along each friction element."""
    times = times_of(run, begin, end)
    rate = run.sample(times)[1]
    _shade(ax, run, begin, end)
    for j, element in enumerate(run.structure.friction[:OVERLAID]):
        speed = element.direction @ rate - element.speed
        ax.plot(times, speed, color=COLOURS[j], lw=0.9, label=f"friction {j}")
    ax.set_ylabel(scales.label("sliding speed $s$", "omega F0/K"))
    ax.set_xlabel(scales.label(TIME, "1/omega"))
    ax.set_xlim(begin, end)
    add_legend(ax, loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), handlelength=1.0,
               columnspacing=1.0, borderaxespad=0.2)  # fmt: skip


def modes_of(run: Trajectory) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Circular frequencies and mass-normalised shapes (n, modes), in order of frequency; they are computed body by
    body, so that modes of equal frequency are not mixed between bodies."""
    s = run.structure
    n = s.coordinates
    omega, shapes, at = np.zeros(n), np.zeros((n, n)), 0
    for body in bodies_of(s):
        place = np.ix_(body, body)
        inverse = np.linalg.inv(np.linalg.cholesky(s.mass[place]))
        squares, vectors = np.linalg.eigh(inverse @ s.stiffness[place] @ inverse.T)
        own = slice(at, at + len(body))
        omega[own] = np.sqrt(
            np.where(squares > 1e-13 * np.abs(squares).max(initial=0.0), squares, 0.0)
        )
        shapes[body, own] = inverse.T @ vectors
        at += len(body)
    order = np.argsort(omega, kind="stable")
    return omega[order], shapes[:, order]


def _draw_energy(ax: Any, run: Trajectory, begin: float, end: float, scales: Scales) -> None:
    """Shares of the modes in the energy; for modes of frequency 0 this is only the kinetic energy."""
    times = times_of(run, begin, end)
    omega, shapes = modes_of(run)
    projected = shapes.T @ run.structure.mass
    q, rate = (projected @ values for values in run.sample(times))
    energy = 0.5 * (rate**2 + (omega[:, None] * q) ** 2)
    if len(energy) == 1:
        ax.plot(times, energy[0], color=PRIMARY, lw=0.9)
        ax.set_ylabel(scales.label("kinetic + elastic energy", "F0^2/K"))
        ax.set_xlabel(scales.label(TIME, "1/omega"))
        ax.set_xlim(begin, end)
        ax.set_ylim(bottom=0)
        return
    total = energy.sum(0)
    shares = energy / np.where(total > 0, total, np.inf)
    # a body of one coordinate without stiffness, or without any coupling to others
    sizes = {i: len(body) for body in bodies_of(run.structure) for i in body}
    alone = np.array([
        omega[k] == 0 and sizes[int(np.argmax(np.abs(shapes[:, k])))] == 1 for k in range(len(omega))
    ])  # fmt: skip
    means = np.where(alone, -1.0, shares.mean(1))
    chosen = np.sort(np.argsort(-means, kind="stable")[: min(MODES, int((~alone).sum()))])
    rows = [shares[k] for k in chosen]
    labels = [scales.frequency(omega[k]) for k in chosen]
    colours = [*BANDS[: len(chosen)]]
    others = int((~alone).sum()) - len(chosen)
    if others:
        rest = ~alone
        rest[chosen] = False
        rows.append(shares[rest].sum(0))
        labels.append(f"{others} other{'s' if others > 1 else ''}")
        colours.append("0.85")
    if alone.any():
        rows.append(shares[alone].sum(0))
        labels.append("free masses" if alone.sum() > 1 else "free mass")
        colours.append(FREE)
    ax.stackplot(times, rows, labels=labels, colors=colours, lw=0)
    ax.set_ylabel("share of the energy")
    ax.set_xlabel(scales.label(TIME, "1/omega"))
    ax.set_xlim(begin, end)
    ax.set_ylim(0, 1)
    add_legend(ax, loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), handlelength=0.9,
               columnspacing=0.9, borderaxespad=0.2, fontsize=6)  # fmt: skip


#: The panels of a structure, in the order of the figure.
KINDS_OF_STRUCTURE = {
    "sketch": _draw_sketch, "history": _draw_coordinates, "impacts": _draw_impacts, "energy": _draw_energy,
}  # fmt: skip
