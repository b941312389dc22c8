"""The masses in motion: walls that flash where they are hit, above the time history."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import MissingExtraError, ParameterError, ParameterTypeError
from ..base.files import replacing
from ..base.progress import Progress
from ..systems.structure import moves, opening_at
from .history import KINDS, KINDS_OF_STRUCTURE, History, history, of_structure, times_of
from .sketch import bodies_of
from .style import FREE, IMPACT, PRIMARY, REST, SETTINGS, Scales, pyplot

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory
    from ..systems.units import Units

__all__ = ["FORMATS", "animate"]

#: Extensions of files, and the writers for them.
FORMATS = {"gif": "pillow", "mp4": "ffmpeg"}
#: Frames per second, seconds for which a wall flashes, and the largest number of frames kept in memory.
RATE, FLASH, MOST = 20, 0.25, 2000


def animate(
    thing: Motion | Trajectory,
    path: str | os.PathLike[str] | None = None,
    cycles: float = 3.0,
    window: tuple[float, float] | None = None,
    seconds: float = 3.0,
    units: Units | None = None,
) -> Any:
    """Animate the masses, and write the animation to a file if a path is given.

    Parameters
    ----------
    thing : Motion or Trajectory
    path : str or path, optional
        Ends with .gif (written by Pillow) or .mp4 (written by ffmpeg, installed or from imageio-ffmpeg).
    cycles : float
        Load cycles shown: for a motion, from its first impact on; for a trajectory, the last ones.
    window : (float, float), optional
        The time window of a trajectory to show, in place of `cycles`.
    seconds : float
        Duration of a load cycle on the screen; for a structure, of the whole animation.
    units : Units, optional
        Physical units of the axes and numbers; dimensionless without them.

    Returns
    -------
    Path, or matplotlib's FuncAnimation if no path is given.
    """
    seconds = _positive(seconds, "seconds")
    target, writer = (None, "") if path is None else _writer(path)
    if thing.of_structure:
        thing, begin, end, scales = of_structure(thing, window, units)
        n = round(seconds * RATE)
        named = f"seconds = {seconds:g}: makes"
        times = np.linspace(begin, end, max(n, 0))
        height = 4.0
    else:
        h = history(thing, _positive(cycles, "cycles"), window, units)
        n = round((h.last - h.first) * thing.r / (2 * math.pi) * seconds * RATE)
        named = f"cycles = {cycles:g}, seconds = {seconds:g}: make"
        # the end is left out: after a whole number of periods it equals the beginning
        times = h.first + (h.last - h.first) * np.arange(n) / n if n else np.empty(0)
        height = 3.6
    if not 2 <= n <= MOST:
        raise ParameterError(f"{named} {n} pictures at {RATE} per second; must be 2 to {MOST}")

    def scene(axes: Any) -> Any:
        """The artists on two axes."""
        return (
            _Bodies(thing, begin, end, axes, scales)
            if thing.of_structure
            else _Scene(thing, h, axes)
        )

    return film(scene, times, height, target, writer)


def film(
    scene_on: Callable[[Any], Any],
    times: NDArray[Any],
    height: float,
    target: Path | None,
    writer: str,
) -> Any:
    """An animation of a scene on the two axes of a new figure: the matplotlib object, or the path of its file."""
    plt = pyplot()
    with plt.rc_context({**SETTINGS, "savefig.bbox": None}):
        figure, axes = plt.subplots(
            2, figsize=(6.0, height), height_ratios=(1, 1.3), dpi=100, layout="constrained"
        )
        try:
            scene = scene_on(axes)
            figure.draw_without_rendering()
            figure.set_layout_engine("none")  # one layout makes each frame faster
            if target is None:
                from matplotlib.animation import FuncAnimation

                return FuncAnimation(
                    figure, scene.show, times, interval=1000 / RATE, init_func=lambda: ()
                )
            _write(figure, scene, times, target, writer)
        finally:
            if target is not None:
                plt.close(figure)
    return target


def _write(figure: Any, scene: Any, times: NDArray[Any], target: Path, writer: str) -> None:
    """Write the frames, drawing each one once (FuncAnimation.save draws three times)."""
    from matplotlib.animation import writers

    with pyplot().rc_context(_program(writer)):
        film = writers[writer](fps=RATE)
        with (
            # the writer chooses the format by the extension
            replacing(target, target.suffix) as temporary,
            Progress(target.name) as bar,
            film.saving(figure, str(temporary), figure.dpi),
        ):
            for i, time in enumerate(times):
                scene.show(time)
                film.grab_frame()
                bar.show((i + 1) / len(times))


def check_format(ending: str, label: str) -> str:
    """The writer for an extension; an error if the extension is unknown or the writer is missing."""
    if ending not in FORMATS:
        raise ParameterError(f"{label}: must end with .{' or .'.join(FORMATS)}")
    pyplot()
    from matplotlib.animation import writers

    if ending == "gif":
        try:
            import PIL.Image  # noqa: F401
        except ImportError:
            raise MissingExtraError(
                f"{label}: a GIF needs Pillow: pip install 'vibroimpact[plot]'"
            ) from None
    else:
        with pyplot().rc_context(_program(FORMATS[ending])):
            if not writers.is_available(FORMATS[ending]):
                raise MissingExtraError(
                    f"{label}: an MP4 needs the program ffmpeg, which is not on the PATH, or pip install "
                    "'vibroimpact[film]'; a .gif needs none"
                )
    return FORMATS[ending]


def _program(writer: str) -> dict[str, str]:
    """matplotlib's setting for the ffmpeg of imageio-ffmpeg, if the configured program does not exist."""
    import matplotlib

    if writer == "ffmpeg" and not shutil.which(matplotlib.rcParams["animation.ffmpeg_path"]):
        with suppress(ImportError, RuntimeError):
            from imageio_ffmpeg import get_ffmpeg_exe

            return {"animation.ffmpeg_path": get_ffmpeg_exe()}
    return {}


def _writer(path: Any) -> tuple[Path, str]:
    """The path, and the writer for its extension."""
    if not isinstance(path, (str, os.PathLike)):
        raise ParameterTypeError(f"path = {path!r}: must be the name of a file")
    target = Path(path)
    return target, check_format(target.suffix[1:].lower(), f"path = {str(path)!r}")


def _positive(value: Any, name: str) -> float:
    number = checks.to_float(value, name, "a number above 0")
    if not 0 < number < math.inf:
        raise ParameterError(f"{name} = {value!r}: must be a number above 0")
    return number


class Glow(NamedTuple):
    """Brightness of the flash of each wall (left, right), 0 to 1, and the side of rest or 0."""

    left: float
    right: float
    rest: int


def glow(events: NDArray[Any], time: float, flash: float, resting: int = 0) -> Glow:
    """The brightness of the walls at a time: a flash fades from 1 at the impact to 0 after the time `flash`.

    `resting` is the wall on which the free mass rests before the first event.
    """
    past = events[events["time"] <= time]
    bright = []
    for side in "LR":
        hits = past["time"][(past["side"] == side) & (past["kind"] == "impact")]
        bright.append(max(0.0, 1 - (time - hits[-1]) / flash) if hits.size else 0.0)
    if past.size:
        last = past[-1]
        resting = (1 if last["side"] == "R" else -1) if last["kind"] == "stick" else 0
    return Glow(bright[0], bright[1], resting)


class _Scene:
    """The artists of a frame; `show` moves them to their positions at a time."""

    def __init__(self, thing: Motion | Trajectory, h: History, axes: Any) -> None:
        from matplotlib.patches import Rectangle

        self.thing, self.h = thing, h
        self.flash = FLASH * 2 * math.pi / thing.r
        ax, below = axes
        low, high = float(h.sample.X.min()), float(h.sample.X.max())
        span = high - low + 2 * h.half
        # The inner faces are half a width of the free mass beyond X +- d/2. The mass then touches them where |Y| =
        # d/2, and its free travel is the clearance on the scale of the axis.
        self.width = 0.08 * span
        self.thick = 0.5 * self.width
        self.reach = h.half + 0.5 * self.width + self.thick
        self.anchor = low - self.reach - 0.3 * span

        def box(width: float, height: float, bottom: float, colour: str) -> Any:
            return ax.add_patch(Rectangle((0, bottom), width, height, fc=colour, ec="none"))

        ax.axhline(0, color="0.6", lw=0.8)
        self.floor = box(2 * self.reach, 0.22, 0.02, PRIMARY)
        self.walls = [box(self.thick, 0.72, 0.24, PRIMARY) for _ in "LR"]
        self.free = box(self.width, 0.4, 0.24, FREE)
        self.ground = ax.axvline(self.anchor, 0, 0.6, color="0.4", lw=2)
        (self.spring,) = ax.plot([], [], color="0.4", lw=0.9)
        self.text = ax.text(0.99, 1.0, "", transform=ax.transAxes, ha="right", va="top")
        ax.set_xlim(self.anchor - 0.02 * span, high + self.reach + 0.08 * span)
        ax.set_ylim(-0.02, 1.2)
        ax.set_yticks([])
        ax.spines["left"].set_visible(False)
        label = h.scales.label("position", "F0/K")
        ax.set_xlabel(f"{label}; the clearance is to scale", labelpad=1)
        KINDS["history"](below, h)
        self.cursor = below.axvline(0, color="0.2", lw=0.8)

    def show(self, time: float) -> list[Any]:
        """Move all artists to their positions at a time."""
        thing, h = self.thing, self.h
        now = thing.sample(time)
        x, z = (float(h.scales(value, "F0/K")) for value in (now.X, now.Z))
        self.floor.set_x(x - self.reach)
        self.free.set_x(z - 0.5 * self.width)
        state = glow(h.events, time, self.flash, h.resting)
        for side, wall, bright in zip((-1, 1), self.walls, state[:2], strict=True):
            wall.set_x(x + side * (self.reach - 0.5 * self.thick) - 0.5 * self.thick)
            base = REST if state.rest == side else PRIMARY
            wall.set_facecolor(_mix(base, IMPACT, bright))
        turns = np.linspace(0, 1, 19)
        zigzag = 0.13 + 0.08 * np.where(np.arange(19) % 2, 1, -1) * (np.abs(turns - 0.5) < 0.4)
        self.spring.set_data(self.anchor + turns * (x - self.reach - self.anchor), zigzag)
        cycle = (time - h.first) * thing.r / (2 * math.pi)
        units = h.scales.units
        at = cycle if units is None else h.scales(time - h.first, "1/omega")
        self.cursor.set_xdata([at, at])
        phase = (h.phase + 2 * math.pi * cycle) % (2 * math.pi)
        shown = (
            rf"$\omega t$ = {time:.2f}   load {float(now.load):+.2f} $F_0$" if units is None
            else f"t = {h.scales(time, '1/omega'):.4g} {h.scales.unit('1/omega')}   "
            f"load {h.scales(float(now.load), 'F0'):+.3g} {h.scales.unit('F0')}"
        )  # fmt: skip
        self.text.set_text(rf"{shown}, phase {phase / math.pi:.2f} $\pi$")
        return [self.floor, *self.walls, self.free, self.spring, self.cursor, self.text]


def _mix(first: str, second: str, share: float) -> tuple[float, ...]:
    """A mixture of two colours."""
    from matplotlib.colors import to_rgb

    return tuple((1 - share) * np.array(to_rgb(first)) + share * np.array(to_rgb(second)))


class _Bodies:
    """The artists of a frame of a structure: a dot at each coordinate, coloured by its last event, and a bar at
    each wall of one coordinate, or between two of them."""

    def __init__(
        self, run: Any, begin: float, end: float, axes: Any, scales: Scales | None = None
    ) -> None:
        from matplotlib.ticker import MaxNLocator

        scales = self.scales = scales or Scales(None, bare=True)
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
        self.frequency = getattr(run.load, "frequency", 0.0)
        self.faced, self.places, reached = [], [], []
        for j, (gap, where) in enumerate(zip(run.structure.gaps, self.directions, strict=True)):
            if len(where) > 2:
                continue
            self.faced.append(gap)
            # between two masses, where a free one meets the other
            held = np.diag(run.structure.stiffness)[where] != 0
            self.places.append(int(where[int(held.argmin())]))
            reached.append(moves(gap) or (len(where) == 2 and bool((run.events["gap"] == j).any())))
        self.bars = ax.hlines(np.zeros(len(self.faced)), -0.3, 0.3, color=IMPACT, lw=2.4, zorder=2)
        when = np.linspace(begin, end, 400)
        states = run.sample(when)[0].T
        walls = np.array([
            self._faces(*pair) for pair in zip(when, states, strict=True)
        ])[:, np.array(reached, bool)]  # fmt: skip
        low = min(0.0, float(q.min()), float(walls.min(initial=0.0)))
        high = max(0.0, float(q.max()), float(walls.max(initial=0.0)))
        margin = 0.08 * (high - low or 1.0)
        ax.set(
            xlim=(-0.7, n - 0.3), ylim=(low - margin, high + margin), xlabel="number of the coordinate",
            ylabel=scales.label("$q_i$", "F0/K"),
        )  # fmt: skip
        ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        ax.axhline(0, color="0.7", lw=0.6)
        KINDS_OF_STRUCTURE["history"](below, run, begin, end, scales)
        self.cursor = below.axvline(begin, color="0.2", lw=0.8)

    def _faces(self, time: float, q: NDArray[Any]) -> list[float]:
        """Where the walls are at a time, as places of the coordinates at which they are drawn: those at which the
        gaps are closed while the other coordinates are as they are."""
        found = []
        for gap, i in zip(self.faced, self.places, strict=True):
            others = float(gap.direction @ q - gap.direction[i] * q[i])
            opening = float(opening_at(gap, time, self.frequency))
            found.append((opening - others) / float(gap.direction[i]))
        return found

    def show(self, time: float) -> list[Any]:
        """Move all artists to their positions at a time."""
        q = self.run.sample([time])[0][:, 0]
        self.bars.set_segments([
            [(i - 0.3, face), (i + 0.3, face)]
            for i, face in zip(self.places, self._faces(time, q), strict=True)
        ])  # fmt: skip
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
        unit = f" {self.scales.unit('1/omega')}" if self.scales.units else ""
        self.text.set_text(
            f"$t$ = {time:.4g}{unit}   impacts: {int((past['kind'] == 'impact').sum())}"
        )
        return [self.bars, self.dots, self.stems, self.cursor, self.text]
