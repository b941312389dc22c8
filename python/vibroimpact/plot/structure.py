"""Pictures of trajectories of structures: sketch, histories, impacts in space and time, and energy of modes."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from .animation import MOST, RATE, _mix, _positive, _writer, film
from .structure_sketch import bodies_of, draw_sketch, has_bodies
from .style import (
    FREE,
    IMPACT,
    ONE_COLUMN,
    PRIMARY,
    REST,
    SETTINGS,
    TWO_COLUMNS,
    add_legend,
    pyplot,
)

if TYPE_CHECKING:
    from ..motions.trajectory import Trajectory

__all__ = ["KINDS", "animate", "draw_structure"]

#: Okabe and Ito's colours of lines, without those of impacts and rests.
COLOURS = (PRIMARY, FREE, "#56B4E9", "#E69F00", "0.15", "0.6")
#: Colours of the modes in the picture of energies; that of free masses is their own.
BANDS = (PRIMARY, "#56B4E9", "#E69F00", "#F0E442", "0.15", "0.55")
#: Most coordinates that are drawn over each other; more are drawn one above the other.
OVERLAID = 6
#: Samples of a history, and the number of modes of which shares are shown.
SAMPLES, MODES = 1500, 6
TIME = "time $t$"


def draw_structure(
    run: Trajectory, ax: Any = None, kind: str | None = None, window: ArrayLike | None = None
) -> Any:  # fmt: skip
    """Draw one panel into `ax`, or all of them into a new figure.

    Parameters
    ----------
    run : Trajectory
    ax : matplotlib Axes, optional
        Without it a figure with all panels is made (or with one, if `kind` is given).
    kind : {"sketch", "history", "impacts", "energy"}, optional
        Which panel; "history" if `ax` is given alone.
    window : (float, float), optional
        Times between which it is drawn; all of it by default.

    Returns
    -------
    Axes, or an array of Axes if all panels were drawn.
    """
    if kind is not None:
        checks.choice(kind, "kind", tuple(KINDS))
    begin, end = window_of(run, window)
    plt = pyplot()
    with plt.rc_context(SETTINGS):
        if ax is not None or kind is not None:
            if ax is None:
                _, ax = plt.subplots(figsize=(ONE_COLUMN, 2.4), layout="constrained")
            KINDS[kind or "history"](ax, run, begin, end)
            return ax
        tall = run.structure.coordinates > OVERLAID
        figure = plt.figure(figsize=(TWO_COLUMNS, 6.6 if tall else 5.6), layout="constrained")
        grid = figure.add_gridspec(3, 2, height_ratios=(1.1, 2.4 if tall else 1.5, 1.5))
        places = (grid[0, :], grid[1, :], grid[2, 0], grid[2, 1])
        axes = [figure.add_subplot(place) for place in places]
        for panel, one in zip(KINDS.values(), axes, strict=True):
            panel(one, run, begin, end)
        return np.array(axes, dtype=object)


def window_of(run: Trajectory, window: ArrayLike | None) -> tuple[float, float]:
    """The times between which to draw."""
    if window is None:
        return run.start, run.end
    wanted = f"two increasing times from {run.start!r} to {run.end!r}"
    times = np.atleast_1d(checks.real_array(window, "window", wanted))
    if times.shape != (2,) or not run.start <= times[0] < times[1] <= run.end:
        raise ParameterError(f"window = {window!r}: must be {wanted}")
    return float(times[0]), float(times[1])


def events_in(run: Trajectory, begin: float, end: float) -> NDArray[Any]:
    """The events of a window."""
    return run.events[(run.events["time"] >= begin) & (run.events["time"] <= end)]


def times_of(run: Trajectory, begin: float, end: float) -> NDArray[np.float64]:
    """Times dense enough for smooth curves, with the events, at which they have corners."""
    times = np.linspace(begin, end, SAMPLES)
    if len(run.events) <= 20 * SAMPLES:
        times = np.union1d(times, events_in(run, begin, end)["time"])
    return times


def _draw_sketch(ax: Any, run: Trajectory, begin: float, end: float) -> None:
    draw_sketch(ax, run.structure, run.load)


def _mark_events(ax: Any, run: Trajectory, begin: float, end: float, y: Any) -> None:
    """Marks at the coordinates that an event concerns; `y` gives their ordinates."""
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


def _draw_history(ax: Any, run: Trajectory, begin: float, end: float) -> None:
    """The coordinates, over each other or, if there are many, one above the other; and the events."""
    times = times_of(run, begin, end)
    q = run.sample(times)[0]
    n = len(q)
    if not has_bodies(run.structure):
        _draw_openings(ax, run, times, q)
    elif n <= OVERLAID:
        for i, values in enumerate(q):
            ax.plot(times, values, color=COLOURS[i], label=f"$q_{{{i}}}$", lw=0.9)
        if run.structure.gaps and len(run.events):
            _mark_events(ax, run, begin, end, lambda values, _: values)
        ax.set_ylabel("coordinates $q_i$")
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
    ax.set_xlabel(TIME)
    ax.set_xlim(begin, end)


def _draw_openings(ax: Any, run: Trajectory, times: NDArray[Any], q: NDArray[Any]) -> None:
    """The openings of the gaps, where coordinates are no displacements of bodies."""
    begin, end = float(times[0]), float(times[-1])
    for j, gap in enumerate(run.structure.gaps[:OVERLAID]):
        ax.plot(times, gap.opening - gap.direction @ q, color=COLOURS[j], lw=0.9, label=f"gap {j}")
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
    ax.set_ylabel("opening $e_j - G_j q$")
    add_legend(
        ax, loc="lower right", ncols=9, bbox_to_anchor=(1.0, 1.0), handlelength=1.4, columnspacing=1.0,
        borderaxespad=0.2,
    )  # fmt: skip


def _draw_impacts(ax: Any, run: Trajectory, begin: float, end: float) -> None:
    """Approach speeds over time for few gaps; for many, a raster of gaps and times with the speed as colour."""
    events = events_in(run, begin, end)
    events = events[events["kind"] == "impact"]
    gaps = len(run.structure.gaps)
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
        ax.set_ylabel("approach speed $v$")
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
            bar.set_label("approach speed $v$")
            bar.outline.set_visible(False)
    ax.set_xlabel(TIME)
    ax.set_xlim(begin, end)


def modes_of(run: Trajectory) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Circular frequencies and mass-normalised shapes (n, modes), body by body, so that modes of equal frequency
    stay with their body; in the order of frequency."""
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


def _draw_energy(ax: Any, run: Trajectory, begin: float, end: float) -> None:
    """Shares of the modes in the energy, which is kinetic energy alone where the frequency is 0."""
    times = times_of(run, begin, end)
    omega, shapes = modes_of(run)
    projected = shapes.T @ run.structure.mass
    q, rate = (projected @ values for values in run.sample(times))
    energy = 0.5 * (rate**2 + (omega[:, None] * q) ** 2)
    if len(energy) == 1:
        ax.plot(times, energy[0], color=PRIMARY, lw=0.9)
        ax.set_ylabel("kinetic + elastic energy")
        ax.set_xlabel(TIME)
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
    labels = [rf"$\omega$ = {omega[k]:.3g}" for k in chosen]
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
    ax.set_xlabel(TIME)
    ax.set_xlim(begin, end)
    ax.set_ylim(0, 1)
    add_legend(ax, loc="lower right", ncols=4, bbox_to_anchor=(1.0, 1.0), handlelength=0.9,
               columnspacing=0.9, borderaxespad=0.2, fontsize=6)  # fmt: skip


#: The panels, in the order of the figure.
KINDS = {
    "sketch": _draw_sketch, "history": _draw_history, "impacts": _draw_impacts, "energy": _draw_energy,
}  # fmt: skip


def animate(
    run: Trajectory,
    path: str | os.PathLike[str] | None = None,
    window: ArrayLike | None = None,
    seconds: float = 10.0,
) -> Any:
    """Animate the coordinates, and write the animation to a file; see `Trajectory.animate`."""
    begin, end = window_of(run, window)
    seconds = _positive(seconds, "seconds")
    target, writer = (None, "") if path is None else _writer(path)
    n = round(seconds * RATE)
    if not 2 <= n <= MOST:
        raise ParameterError(
            f"seconds = {seconds:g}: makes {n} pictures at {RATE} a second; must be 2 to {MOST}"
        )
    times = np.linspace(begin, end, n)
    return film(lambda axes: _Scene(run, begin, end, axes), times, 4.0, target, writer)


class _Scene:
    """The artists of a frame: a dot at each coordinate, coloured by its last event."""

    def __init__(self, run: Trajectory, begin: float, end: float, axes: Any) -> None:
        from matplotlib.ticker import MaxNLocator

        self.run, self.flash = run, 0.02 * (end - begin)
        ax, below = axes
        n = run.structure.coordinates
        q = run.sample(times_of(run, begin, end))[0]
        alone = {body[0] for body in bodies_of(run.structure) if len(body) == 1}
        self.base = [FREE if i in alone else PRIMARY for i in range(n)]
        self.directions = [np.flatnonzero(gap.direction) for gap in run.structure.gaps]
        x = np.arange(n)
        size = 60.0 if n <= 12 else max(4.0, 700.0 / n)
        self.stems = ax.vlines(x, 0, np.zeros(n), color="0.8", lw=0.8)
        self.dots = ax.scatter(x, np.zeros(n), s=size, c=self.base, zorder=3)
        # not empty, so that the layout leaves room for it
        self.text = ax.text(1.0, 1.0, "$t$", transform=ax.transAxes, ha="right", va="bottom")
        low, high = min(0.0, float(q.min())), max(0.0, float(q.max()))
        margin = 0.08 * (high - low or 1.0)
        ax.set(
            xlim=(-0.7, n - 0.3), ylim=(low - margin, high + margin), xlabel="number of the coordinate",
            ylabel="$q_i$",
        )  # fmt: skip
        ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        ax.axhline(0, color="0.7", lw=0.6)
        _draw_history(below, run, begin, end)
        self.cursor = below.axvline(begin, color="0.2", lw=0.8)

    def show(self, time: float) -> list[Any]:
        """Move all artists to their positions at a time."""
        q = self.run.sample([time])[0][:, 0]
        x = np.arange(len(q))
        self.dots.set_offsets(np.column_stack([x, q]))
        self.stems.set_segments([[(i, 0), (i, value)] for i, value in zip(x, q, strict=True)])
        colours: list[Any] = [*self.base]
        past = self.run.events[self.run.events["time"] <= time]
        resting = set(self.run._resting())
        for event in past[past["kind"] != "impact"]:
            (resting.add if event["kind"] == "stick" else resting.discard)(int(event["gap"]))
        for gap in resting:
            for i in self.directions[gap]:
                colours[i] = REST
        for event in past[past["time"] > time - self.flash]:
            if event["kind"] == "impact":
                bright = max(0.0, 1 - (time - float(event["time"])) / self.flash)
                for i in self.directions[int(event["gap"])]:
                    colours[i] = _mix(self.base[i], IMPACT, math.sqrt(bright))
        self.dots.set_color(colours)
        self.cursor.set_xdata([time, time])
        self.text.set_text(f"$t$ = {time:.4g}   impacts: {int((past['kind'] == 'impact').sum())}")
        return [self.dots, self.stems, self.cursor, self.text]
