"""Bifurcation diagrams by simulation: sweeps up and down, and many initial states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core, checks
from ..errors import ParameterError, StudyInterrupted
from ..interchange import namelist
from ..interchange.dataset import xarray
from ..interchange.result import Result
from ..interrupt import new_tally, stoppable
from ..model import Oscillator
from ..states import NEEDED
from ..status import NOT_COMPUTED
from .settling import PARAMETERS, one_state, thread_count
from .spacing import spacing_of

__all__ = ["BifurcationDiagram", "PeriodicWindow", "bifurcation_diagram"]

_Array = NDArray[np.float64]
NAMES = (*PARAMETERS, "restitution")
SWEEPS = ("up", "down", "both", "states")
#: Columns of an impact as the core gives them.
COLUMNS = ("phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")
#: Of the sweeps, as the core has them; other runs start anew at each value.
DIRECTIONS = {"up": 1, "down": -1}


class PeriodicWindow(NamedTuple):
    """A stretch of a run over which the motion keeps its label N/k.

    N impacts (an accumulation counts as one) in k load cycles.
    """

    run: str
    low: float
    high: float
    label: str


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class BifurcationDiagram(Result):
    """What simulations settle on along a parameter.

    Attributes
    ----------
    osc : Oscillator
    parameter : str
    values : ndarray (n,)
        Of the parameter, rising.
    r, clearance : float or ndarray (n,)
        The one that is not swept.
    load : float
    runs : list of str
        "up", "down", or "state 1", ...: the first index of the arrays below.
    cycles, letters, impacts, rests : ndarray (runs, n) of int
        Load cycles k of the period, 0 if there is none up to the longest one looked for; letters N,
        impacts and rests in it.
    x_min, x_max : ndarray (runs, n)
        Extreme positions of the primary mass.
    status : ndarray (runs, n) of int
        0 done; see `status_text`.
    points : structured ndarray
        The impacts kept: ``run`` and ``index`` (of the value), ``side`` ("R", "L"), ``phase``, ``x``,
        ``x_dot_before``, ``x_dot_after``, ``z_dot_before``, ``z_dot_after``.
    case : str
        What was asked for as a namelist; empty if none can tell (see `to_namelist`).
    complete : bool
        False if Ctrl-C cut it short.
    """

    osc: Oscillator
    parameter: str
    values: _Array
    r: float | _Array
    clearance: float | _Array
    load: float
    runs: list[str]
    cycles: NDArray[np.int32]
    letters: NDArray[np.int32]
    impacts: NDArray[np.int32]
    rests: NDArray[np.int32]
    x_min: _Array
    x_max: _Array
    status: NDArray[np.int32]
    points: NDArray[Any]
    case: str = ""
    complete: bool = True

    @property
    def cut(self) -> str:
        """How far it came if it was cut short; else empty."""
        if self.complete:
            return ""
        done = int((self.status != NOT_COMPUTED).sum())
        return f"{done} of {self.status.size} simulations were reached"

    @property
    def labels(self) -> NDArray[Any]:
        """N/k of each run and value (runs, n); "" where no period was seen, "0/k" without impacts."""
        table = np.full(self.cycles.shape, "", dtype="U16")
        for i, j in zip(*np.nonzero(self.cycles), strict=True):
            table[i, j] = f"{self.letters[i, j]}/{self.cycles[i, j]}"
        return table

    @property
    def windows(self) -> list[PeriodicWindow]:
        """The stretches with one label, run by run.

        Of a diagram that was cut short, those beside values that were not reached are left out: where they end
        is not known.
        """
        return self._stretches(cut=False)

    @property
    def cut_windows(self) -> list[PeriodicWindow]:
        """The stretches beside values that were not reached: they may go on there."""
        return self._stretches(cut=True)

    def _stretches(self, cut: bool) -> list[PeriodicWindow]:
        """The stretches with one label that have a neighbour that was not reached, or the others."""
        result = []
        beyond = np.pad(self.status == NOT_COMPUTED, ((0, 0), (1, 1)))
        for i, (run, labels) in enumerate(zip(self.runs, self.labels, strict=True)):
            first, last, n = _core.periodic_windows(np.array([self.cycles[i], self.letters[i]]))
            for low, high in zip(first[:n] - 1, last[:n] - 1, strict=True):
                if (beyond[i, low] or beyond[i, high + 2]) == cut:
                    ends = float(self.values[low]), float(self.values[high])
                    result.append(PeriodicWindow(run, *ends, str(labels[low])))
        return result

    @property
    def coexisting(self) -> NDArray[np.bool_]:
        """Where the runs ended on different motions (n): hysteresis, or several attractors.

        Labels and max |x| are compared, so that a motion and its mirror image count as one; nothing is where a
        run was cut short.
        """
        reach = np.maximum(-self.x_min, self.x_max)
        different: NDArray[np.bool_] = np.ptp(reach, axis=0) > 1e-3 * reach.max(axis=0)
        labels = (self.labels != self.labels[0]).any(axis=0)
        reached = (self.status != NOT_COMPUTED).all(axis=0)
        return np.asarray((different & (self.cycles > 0).any(axis=0) | labels) & reached)

    def column(self, quantity: str) -> _Array:
        """A column of the points; "approach" is the speed of approach, "y_dot" that of the free mass."""
        if quantity == "approach":
            return np.asarray(np.abs(self.points["z_dot_before"] - self.points["x_dot_before"]))
        if quantity not in COLUMNS:
            raise ParameterError(
                f"quantity = {quantity!r}: must be one of {', '.join((*COLUMNS, 'approach'))}"
            )
        return np.asarray(self.points[quantity])

    def to_xarray(self) -> Any:
        """Columns over run and value, and the impacts as a list (extra `data`)."""
        over = ("run", self.parameter)
        data: dict[str, Any] = {
            name: (over, getattr(self, name))
            for name in (
                "cycles",
                "letters",
                "impacts",
                "rests",
                "x_min",
                "x_max",
                "status",
                "labels",
            )
        }
        for name in ("index", "side", *COLUMNS):
            data[f"impact_{name}"] = ("impact", self.points[name])
        data["impact_run"] = ("impact", self.points["run"])
        coordinates: dict[str, Any] = {"run": self.runs, self.parameter: self.values}
        fixed = {name: getattr(self, name) for name in ("r", "clearance") if name != self.parameter}
        for name in [name for name, value in fixed.items() if np.ndim(value)]:
            coordinates[name] = (self.parameter, fixed.pop(name))
        own = {"load": self.load, "complete": int(self.complete)}
        return xarray().Dataset(data, coordinates, fixed | own)

    def plot(self, ax: Any = None, quantity: str = "x") -> Any:
        """Draw the impacts: colour and marker tell the wall, a line on top the windows N/k.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        quantity : str
            "phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after" or "approach".

        Returns
        -------
        Axes
        """
        from ..plot.attractor import draw_bifurcation

        return draw_bifurcation(self, ax, quantity)

    def __repr__(self) -> str:
        low, high = self.values[0], self.values[-1]
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return (
            f"<BifurcationDiagram over {self.parameter} = {low:.6g} to {high:.6g}: {len(self.runs)} runs, "
            f"{len(self.points)} impacts, {len(self.windows)} periodic windows{cut}>"
        )


def bifurcation_diagram(
    osc: Oscillator,
    parameter: str,
    values: ArrayLike,
    r: ArrayLike | None = None,
    clearance: ArrayLike | None = None,
    sweep: str = "both",
    states: int = 12,
    state: Mapping[str, float] | None = None,
    load: float = 1.0,
    settling: int = 300,
    keep: int = 33,
    points: int = 100,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram:
    """The impacts that simulations settle on, along a parameter.

    Sweeps carry the state from value to value, so that a motion is followed to the end of its stability:
    where the sweeps up and down differ there is hysteresis. With "states" each value starts anew from many
    initial states, which shows attractors that no sweep comes to.

    Parameters
    ----------
    osc : Oscillator
    parameter : {"r", "clearance", "xi", "mu", "R1", "R2", "restitution"}
        "restitution" changes both walls.
    values : array_like
        At least two. A namelist can tell those of `spaced`.
    r, clearance : float or array_like
        The ones that are not `parameter`: a number, or one for each of `values` (which rise then), for a
        line across the plane.
    sweep : {"up", "down", "both", "states"}
    states : int
        Initial states of "states", spread evenly.
    state : mapping, optional
        Where sweeps start, as in `simulate`; by default a state with plenty of motion.
    load : float
    settling : int
        Load cycles simulated at each value before.
    keep : int
        Load cycles looked at; periods of up to half of them are seen.
    points : int
        Impacts kept of each run and value.
    threads : int, optional
        Default: one for each processor. The answer does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and what is being done.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`:
        values that a run did not come to have no impacts there.

    Examples
    --------
    The sweep up keeps to the two-impact motion far longer than the sweep down takes to find it:

    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> diagram = vi.bifurcation_diagram(osc, "clearance", np.arange(50.0, 76.0), r=1.04)
    >>> [window for window in diagram.windows if window.label == "2/1"]
    [PeriodicWindow(run='up', low=50.0, high=70.0, label='2/1'), ...]
    """
    checks.instance(osc, "osc", Oscillator)
    checks.choice(parameter, "parameter", NAMES)
    checks.choice(sweep, "sweep", SWEEPS)
    load = checks.number(load, "load")
    states = checks.integer(states, "states", 1, 10**6)
    settling = checks.integer(settling, "settling", 0, 10**7)
    keep = checks.integer(keep, "keep", 3, 10**4)
    points = checks.integer(points, "points", 1, 4096)
    along = np.unique(checks.real_array(values, "values", "numbers"))
    if along.size < 2:
        raise ParameterError(f"values = {values!r}: must be at least two different numbers")
    checks.integer(along.size, "values", 2, checks.MOST_VALUES)
    runs = {"both": ["up", "down"], "states": [f"state {j + 1}" for j in range(states)]}.get(
        sweep, [sweep]
    )
    checks.together(
        along.size * len(runs) * points,
        f"points = {points}",
        "values x runs x points must be at most {}",
    )
    fixed: dict[str, float | _Array] = {}
    for name, value in (("r", r), ("clearance", clearance)):
        if name != parameter:
            fixed[name] = _beside(value, name, along, values)
        elif value is not None:
            raise ParameterError(f"{name} = {value!r}: must be left out, it is the parameter")
        else:
            fixed[name] = float(along[0])
    kind = "restitution" if parameter in ("R1", "R2") else parameter
    for value in (along[0], along[-1]):
        checks.number(float(value), kind, parameter)
    if np.any((along if parameter == "r" else fixed["r"]) == 1):
        xi = float(along[0]) if parameter == "xi" else osc.xi
        checks.frequency_ratio(1.0, xi)
    workers = thread_count(threads)
    start = np.zeros(5)
    if state is not None:
        ends = (
            along if parameter == "clearance" else np.broadcast_to(fixed["clearance"], along.shape)
        )
        for run, end in zip(("up", "down"), (ends[0], ends[-1]), strict=True):
            if run in runs:
                start = one_state(state, float(end))
    own = (
        {"states": states} if sweep == "states" else dict(zip(NEEDED, start.tolist(), strict=True))
    )
    limits = {"settling": settling, "keep": keep, "points": points, "load": load}
    asked = _case(osc, parameter, along, fixed, {
        "sweep": sweep, **(own if sweep == "states" or state is not None else {}), **limits,
    })  # fmt: skip
    r_there, clearance_there = (np.broadcast_to(value, along.shape) for value in fixed.values())
    arrays, complete = stoppable(
        _core.bifurcation, osc.xi, osc.mu, osc.restitution, r_there, clearance_there, load,
        5 if parameter == "restitution" else PARAMETERS.index(parameter) + 1,
        parameter == "restitution", along, [DIRECTIONS.get(run, 0) for run in runs],
        state is not None, start, settling, keep, points, workers, tally=new_tally(), progress=progress,
        note="bifurcation diagram",
    )  # fmt: skip
    impacts, labels, found, periods, extremes, status = arrays
    if (status == NOT_COMPUTED).all():
        raise KeyboardInterrupt
    cycles, letters, counts, rests = periods.transpose(0, 2, 1)
    x_min, x_max = extremes.transpose(0, 2, 1)
    result = BifurcationDiagram(
        osc, parameter, along, fixed["r"], fixed["clearance"], load, runs, cycles, letters, counts,
        rests, x_min, x_max, status.T, _impacts(impacts, labels[1], found), asked,
        bool((status != NOT_COMPUTED).all()),
    )  # fmt: skip
    if not complete:
        raise StudyInterrupted(result)
    return result


def _case(
    osc: Oscillator,
    parameter: str,
    along: _Array,
    fixed: Mapping[str, Any],
    keys: Mapping[str, Any],
) -> str:
    """What was asked for as a namelist, empty if it cannot tell the values."""
    spacing = spacing_of(along)
    others = {name: value for name, value in fixed.items() if name != parameter}
    if spacing is None or any(np.ndim(value) for value in others.values()):
        return ""
    line = {"low": float(along[0]), "high": float(along[-1]), "values": along.size}
    return namelist.case(osc, others.pop("r", None), bifurcation={
        "parameter": parameter, **line, "spacing": spacing, **others, **keys,
    })  # fmt: skip


def _beside(value: Any, name: str, along: _Array, values: ArrayLike) -> float | _Array:
    """The parameter that is not swept: a number, or one for each value."""
    if np.ndim(value) == 0:
        return checks.number(value, name)
    array = checks.real_array(value, name, "numbers")
    if array.shape != along.shape or not np.array_equal(along, values):
        raise ParameterError(
            f"{name} of shape {array.shape}: must be a number, or one for each of values, which have to rise then"
        )
    for item in (array.min(), array.max()):
        checks.number(float(item), name)
    return array


def _impacts(values: _Array, sides: NDArray[np.int32], found: NDArray[np.int32]) -> NDArray[Any]:
    """The kept impacts (.., points, values, runs) as one list, by run and value."""
    kept = np.arange(sides.shape[0]) < found.T[..., None]
    run, index, row = np.nonzero(kept)
    dtype = [("run", "i4"), ("index", "i4"), ("side", "U1"), *((name, "f8") for name in COLUMNS)]
    points = np.empty(row.size, dtype=dtype)
    points["run"], points["index"] = run, index
    points["side"] = np.where(sides[row, index, run] > 0, "R", "L")
    for i, name in enumerate(COLUMNS):
        points[name] = values[i + 1, row, index, run]
    return points
