"""Charts: the motions of one pattern on a grid of frequency ratios and clearances."""

from __future__ import annotations

import os
import time
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, checks
from .chart_arrays import ChartArrays, Columns, labelled
from .errors import ChartInterrupted, ParameterError
from .interchange.dataset import xarray
from .model import Oscillator, Pattern
from .progress import Progress
from .status import NO_MOTION, NOT_COMPUTED
from .studies.conditions import can_be_symmetric, check_symmetric

__all__ = ["chart"]

#: Points of a chart.
MOST_POINTS = 1_000_000
MOST_IMPACTS = 12
#: Motions of the equispaced pair computed between two looks at the keyboard.
CHUNK = 60_000


#: xi, mu, restitution, r, clearance, cycles, sides
CoreArguments: TypeAlias = tuple[
    float,
    float,
    tuple[float, float],
    NDArray[np.float64],
    NDArray[np.float64],
    int,
    NDArray[np.int32],
]


class Task(NamedTuple):
    """What is given, checked."""

    osc: Oscillator
    pattern: Pattern
    r: NDArray[np.float64]
    clearance: NDArray[np.float64]
    threads: int
    progress: Progress

    def core(self) -> CoreArguments:
        """The leading arguments of the core's procedures."""
        osc = self.osc
        return (
            osc.xi, osc.mu, osc.restitution, self.r, self.clearance, self.pattern.cycles,
            self.pattern.signs,
        )  # fmt: skip


def chart(
    osc: Oscillator,
    pattern: Pattern,
    r: ArrayLike,
    clearance: ArrayLike,
    symmetric: bool | None = None,
    *,
    multipliers: bool = True,
    room: int = 4,
    guesses: int = 32,
    seeds: int = 12,
    threads: int | None = None,
    progress: bool | None = None,
) -> Any:
    """The motions of a pattern at every point of a grid, as a labelled dataset (extra `data`).

    Two equally spaced impacts with equal restitution (the pattern RL, k odd) have a closed form.
    All other motions are found by Newton's method: a search at some points of the grid, then from
    each solved point to its neighbours.

    Parameters
    ----------
    osc : Oscillator
    pattern : Pattern
        Without rest.
    r, clearance : array_like
        Increasing frequency ratios and clearances d K/F0, at most 1000000 points altogether.
    symmetric : bool, optional
        True: only motions that are their own mirror image half a period later (of RL these are the
        equispaced ones); False: only the others; None: both.
    multipliers : bool
        Whether the multipliers of the equispaced motions are wanted. Without them they are NaN, the
        verdict `stable` is the same, and the chart takes a fraction of the time.
    room : int
        Slots for motions that have no closed form, 1 to 32.
    guesses, seeds : int
        Guesses of the search at a point, and points along each axis where there is one. A zone
        that holds none of these points, and is connected to none that does, is missed.
    threads : int, optional
        Default: one for each processor. The answer is the same to the last bit for any number.
    progress : bool, optional
        Whether to show a bar on standard error after two seconds; default: if it is a terminal.

    Returns
    -------
    xarray.Dataset
        With the dimensions `motion` (slot), `clearance` and `r`:

        - `consistent`, `admissible`, `stable`: 1, 0, or -1 for unknown;
        - `multiplier_modulus`, `multiplier_angle` (first dimension `multiplier`), leading one first;
        - `x_min`, `x_max`, `attenuation` (max|x|/A), `tau`, and `X`, `phases` (first dimension
          `impact`);
        - `status`: 0 where there is a motion; other codes are explained by `status_text`;
        - `found`: motions at the point, with those for which there was no room.

        A slot is continuous over the grid. The equispaced pair has the slots 0 and 1, in the order
        of `equispaced`: tau above and below the middle of the two. The others follow: motions that
        continue each other from point to point share a slot, and the slots are given first to
        those with the most admissible and stable points, then to those with the most admissible
        ones. Where there are more motions than `room`, a slot may change from one to another; no
        admissible and stable motion is left out for one that is not.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    MissingExtraError
        If xarray is missing.
    ChartInterrupted
        At Ctrl-C; its attribute `chart` is the dataset so far, with a status of its own where
        nothing was computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> data = vi.chart(
    ...     osc, vi.Pattern("RL"), np.linspace(0.9, 1.1, 21), np.geomspace(5, 100, 16), symmetric=True
    ... )
    >>> dict(data.sizes)["motion"]
    2
    >>> int(((data.admissible == 1) & (data.stable == 1)).any("motion").sum())
    107
    """
    xarray("charts")
    try:
        arrays = chart_arrays(
            osc, pattern, r, clearance, symmetric, multipliers=multipliers, room=room, guesses=guesses,
            seeds=seeds, threads=threads, progress=progress,
        )  # fmt: skip
    except ChartInterrupted as stop:
        raise ChartInterrupted(str(stop), stop.chart.dataset()) from None
    return arrays.dataset()


def chart_arrays(
    osc: Oscillator, pattern: Pattern, r: ArrayLike, clearance: ArrayLike, symmetric: bool | None = None, *,
    multipliers: bool = True, room: int = 4, guesses: int = 32, seeds: int = 12, threads: int | None = None,
    progress: bool | None = None,
) -> ChartArrays:  # fmt: skip
    """The same as plain arrays."""
    checks.instance(osc, "osc", Oscillator)
    checks.plain_pattern(pattern)
    if len(pattern) > MOST_IMPACTS:
        raise ParameterError(
            f"pattern of {len(pattern)} impacts: must have at most {MOST_IMPACTS} in a chart"
        )
    axes = _axis(r, "r"), _axis(clearance, "clearance")
    points = axes[0].size * axes[1].size
    if points > MOST_POINTS:
        raise ParameterError(
            f"r and clearance: {axes[0].size} x {axes[1].size} = {points} points; must be at "
            f"most {MOST_POINTS}, make several charts"
        )
    check_symmetric(symmetric, osc, pattern)
    room = checks.integer(room, "room", 1, 32)
    guesses = checks.integer(guesses, "guesses", 1, 10**4)
    seeds = checks.integer(seeds, "seeds", 1, 10**4)
    processors = os.cpu_count() or 1
    threads = checks.integer(processors if threads is None else threads, "threads", 1, 1024)
    pair = len(pattern) == 2 and can_be_symmetric(osc, pattern)
    if max(room, 4) * len(pattern) * points > checks.MOST_NUMBERS and not (pair and symmetric):
        raise ParameterError(
            f"r and clearance: {points} points with room for {room} motions of {len(pattern)} impacts "
            f"each; points x room x impacts must be at most {checks.MOST_NUMBERS}, make several charts"
        )
    parts: list[Columns] = []
    found = np.zeros((axes[1].size, axes[0].size), dtype=np.int32)
    complete = True
    with Progress(f"chart {pattern.sides}/{pattern.cycles}", progress) as bar:
        task = Task(osc, pattern, *axes, threads, bar)
        if pair and symmetric is not False:
            part, complete = _equispaced(task, bool(multipliers))
            parts.append(part)
            found += (part.status == 0).sum(axis=0, dtype=np.int32)
        if complete and not (pair and symmetric):
            kind = -1 if pair else 0
            if symmetric is not None and can_be_symmetric(osc, pattern):
                kind = 1 if symmetric else -1
            part, counts, complete = _flood(task, kind, room, guesses, seeds)
            parts.append(part)
            found += counts
    columns = Columns(*(np.concatenate(items, axis=-3) for items in zip(*parts, strict=True)))
    data = labelled(osc, pattern, task.r, task.clearance, columns, found)
    words = {True: "symmetric", False: "not symmetric", None: "all"}
    data.attrs.update(
        motions=words[symmetric], room=room, guesses=guesses, seeds=seeds, complete=int(complete)
    )
    if not complete:
        raise ChartInterrupted(
            "the chart was stopped; what was computed is the attribute `chart` of this exception",
            data,
        )
    return data


def _equispaced(task: Task, multipliers: bool) -> tuple[Columns, bool]:
    """Both equispaced motions, some columns at a time; and whether all were computed."""
    n, m = task.r.size, task.clearance.size
    scalars = np.full((4, 2, m, n), np.nan, order="F")
    values = np.full((4, 2, m, n), complex(np.nan, np.nan), order="F")
    verdicts = np.full((3, 2, m, n), -1, dtype=np.int32, order="F")
    status = np.full((2, m, n), NOT_COMPUTED, dtype=np.int32, order="F")
    step = max(1, CHUNK // (2 * m))
    complete = True
    osc = task.osc
    try:
        for i in range(0, n, step):
            part = np.s_[..., i : i + step]
            results = _core.equispaced_chart(
                osc.xi, osc.mu, osc.restitution, task.r[part], task.clearance, task.pattern.cycles,
                multipliers, task.threads,
            )  # fmt: skip
            scalars[part], values[part], verdicts[part], status[part] = results
            task.progress.show((i + step) / n)
    except KeyboardInterrupt:
        complete = False
    x, tau, x_min, x_max = scalars
    if task.pattern.signs[0] < 0:  # counted from the left wall: half a period later
        x, tau = -x, np.where(tau > 0, tau - np.pi, tau + np.pi)
    phases = np.stack([np.zeros_like(x), np.full_like(x, task.pattern.cycles * np.pi)])
    phases[:, status != 0] = np.nan
    return Columns(phases, np.stack([x, -x]), tau, x_min, x_max, values, verdicts, status), complete


def _flood(
    task: Task, kind: int, room: int, guesses: int, seeds: int
) -> tuple[Columns, NDArray[np.int32], bool]:
    """Exact motions by a flood from the points of a search; and whether it came to its end."""
    n, m, keep = task.r.size, task.clearance.size, 4 * max(room, 4)
    unknowns = np.zeros((2 * len(task.pattern), keep, m, n), order="F")
    marks = np.zeros((2, keep, m, n), dtype=np.int32, order="F")
    counts = np.zeros((2, m, n), dtype=np.int32, order="F")
    points = np.array(
        [(j + 1, k + 1) for k in _spread(n, seeds) for j in _spread(m, seeds)], dtype=np.int32
    ).T
    core = task.core()
    complete = True
    try:
        for i in range(0, points.shape[1], 4 * task.threads):
            _core.seed_flood(
                *core, points[:, i : i + 4 * task.threads], guesses, kind, task.threads, unknowns,
                marks, counts,
            )  # fmt: skip
            task.progress.show(0.3 * i / points.shape[1], "searching")
        sweeps, done, gained = 1, 0, 1
        while gained:
            begin = time.monotonic()
            gained = _core.sweep_flood(*core, sweeps, kind, task.threads, unknowns, marks, counts)
            done += sweeps
            if time.monotonic() - begin < 0.1:
                sweeps *= 2
            note = f"{int(counts[1].sum())} motions"
            task.progress.show(0.3 + 0.6 * min(1.0, done / (m + n)), note)
    except KeyboardInterrupt:
        complete = False
    phases, impacts, scalars, multipliers, verdicts, status = _core.finish_chart(
        *core, room, task.threads, unknowns, marks[0], counts[1]
    )
    _, _, tau, _, x_min, x_max = scalars
    if not complete:
        status[status == NO_MOTION] = NOT_COMPUTED
    columns = Columns(phases, impacts[:, 0], tau, x_min, x_max, multipliers, verdicts, status)
    return columns, counts[1], complete


def _axis(values: ArrayLike, name: str) -> NDArray[np.float64]:
    """An axis of a chart: increasing numbers within the range of their name."""
    array = checks.real_array(values, name, "an array of increasing numbers")
    if array.ndim != 1 or array.size == 0:
        raise ParameterError(
            f"{name} of shape {array.shape}: must be an array (n,) of increasing numbers, n at least 1"
        )
    for value in (*array[~np.isfinite(array)][:1].tolist(), float(array.min()), float(array.max())):
        checks.number(value, name)
    fall = np.flatnonzero(~(np.diff(array) > 0))
    if fall.size:
        i = int(fall[0])
        raise ParameterError(
            f"{name}[{i}], {name}[{i + 1}] = {float(array[i])!r}, {float(array[i + 1])!r}: must increase"
        )
    return np.ascontiguousarray(array)


def _spread(n: int, most: int) -> list[int]:
    """At most `most` indices spread evenly over n, both ends included (one alone: the middle)."""
    steps = min(n, most) - 1
    if steps == 0:
        return [n // 2]
    return [(2 * i * (n - 1) + steps) // (2 * steps) for i in range(steps + 1)]
