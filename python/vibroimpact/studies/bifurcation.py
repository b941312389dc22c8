"""Bifurcation diagrams of every system by simulation: sweeps up and down, and many initial states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.spacing import range_values, spacing_of
from ..base.status import NOT_COMPUTED, sentence
from ..results import door
from ..results.noun import Noun, column
from ..results.parameters import Parameter, checked_pair, keys_of_parameter
from ..results.states import NEEDED, checked_state, state_by_coordinates
from ..systems.oscillator import Oscillator, Point
from ..systems.structure import Load, Structure
from ..systems.units import range_text
from ..systems.verbs import every_system, physical_arguments

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["BifurcationDiagram", "PeriodicWindow", "bifurcation_diagram"]

_Array = NDArray[np.float64]
NAMES = ("r", "clearance", "xi", "mu", "R1", "R2", "restitution")
SWEEPS = ("up", "down", "both", "states")
#: Columns of an impact.
COLUMNS = ("phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")
#: The core's names for the ends of the values of a structure. They are sorted here, so messages need not mention
#: their order.
ENDS = {
    ", and low below high": "", "low": "min(values)", "high": "max(values)", "list": "values",
}  # fmt: skip


class PeriodicWindow(NamedTuple):
    """A range of successive values of a run over which the motion keeps its label N/k.

    N impacts (an accumulation counts as one) in k load cycles.
    """

    run: str
    low: float
    high: float
    label: str


class cell(column):  # noqa: N801 (a descriptor, written as property is)
    """A column with one entry for each run and value.

    The table of a structure is a list in the order of the sweep, and incomplete if the sweep was stopped; it is
    rearranged as by `SettledMotions._arranged`.
    """

    def shaped(self, noun: Any, values: NDArray[Any]) -> NDArray[Any]:
        values = super().shaped(noun, values)
        if not noun.of_structure:
            return values
        arranged: NDArray[Any] = noun._arranged(values, NOT_COMPUTED * (self.name == "status"))
        return arranged


class SettledMotions(Noun):
    """The motions on which simulations settle, in each run and at each value of a parameter."""

    __slots__ = ("__dict__",)
    cycles = cell("cells")
    symbols = cell("cells")
    impacts = cell("cells")
    rests = cell("cells")
    status = cell("cells")

    @cached_property
    def _cells(self) -> tuple[_Array, list[str], NDArray[Any], NDArray[Any]]:
        """For a structure: the values that were reached, rising, the runs, and the place of each row in both."""
        value, run = (self._values("cells", name) for name in ("value", "run"))
        values, index = np.unique(value, return_inverse=True)
        runs = list(dict.fromkeys(run.tolist()))
        return values, runs, np.array([runs.index(name) for name in run.tolist()], "i4"), index

    def _arranged(self, rows: NDArray[Any], missing: int) -> NDArray[Any]:
        """Rows of a structure, along the last axis, arranged as (runs, values); missing entries are `missing` or
        NaN."""
        values, runs, run, index = self._cells
        gap = np.nan if rows.dtype.kind == "f" else missing
        found = np.full((*rows.shape[:-1], len(runs), values.size), gap, rows.dtype)
        found[..., run, index] = rows
        found.flags.writeable = False
        return found

    @property
    def labels(self) -> NDArray[np.str_]:
        """N/k for each run and value: N symbols or impacts in k load cycles; "" if not periodic."""
        counts = self.impacts if self.of_structure else self.symbols
        pairs = zip(counts.ravel().tolist(), self.cycles.ravel().tolist(), strict=True)
        labels = np.array([f"{n}/{k}" if k else "" for n, k in pairs], np.str_)
        return labels.reshape(self.cycles.shape)

    @property
    def failures(self) -> dict[str, int]:
        """Messages of simulations that failed, and how often each occurred."""
        failed = self.status[(self.status != 0) & (self.status != NOT_COMPUTED)]
        codes, counts = np.unique(failed, return_counts=True)
        return {sentence(int(code)): int(n) for code, n in zip(codes, counts, strict=True)}

    def _periodic(self) -> str:
        """A text on how many of the values of a structure have a period."""
        reached = self.status != NOT_COMPUTED
        return f"{', '.join(self._cells[1])}, {(self.cycles > 0).sum()} of {reached.sum()} with a period"


class BifurcationDiagram(
    SettledMotions, study="bifurcation", formerly="StructureBifurcation"
):  # fmt: skip
    """The motions on which simulations settle along a parameter.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : float or ndarray (n,)
        For an oscillator: the values of the parameters that are not swept.
    structure : Structure
        For a structure.
    load : float or Load
    parameter : str
    values : ndarray (n,)
        Values of the parameter, ascending; for a structure those that were reached.
    runs : list of str
        "up", "down", or, for an oscillator, "state 1", ...: the first index of the arrays below.
    cycles, impacts, rests : ndarray (runs, n) of int
        Load cycles k of the shortest period of the stable motion that Newton's method confirms at the end of the
        simulation; 0 if there is none up to the longest period considered: chaotic, quasi-periodic, or not settled
        yet. Impacts and rests in this period, or in all cycles examined if there is no period.
    symbols : ndarray (runs, n) of int
        For an oscillator: symbols, in which an accumulation counts as one impact.
    x_min, x_max : ndarray (runs, n)
        For an oscillator: extreme positions of the primary mass.
    labels : ndarray (runs, n) of str
        N/k for each run and value, where N is the number of symbols of an oscillator or of impacts of a structure;
        "" if no period is confirmed, "0/1" without impacts. With stops or friction N counts all events except the
        beginning and the end of rests.
    status : ndarray (runs, n) of int
        0 if done; see `status_text`. After a failure, the sweep of a structure starts anew at the next value.
    failures : dict
        Messages of simulations that failed, and how often each occurred.
    windows : list of PeriodicWindow
        For an oscillator: ranges of values with one label, run by run.
    coexisting : ndarray (n,) of bool
        For an oscillator: whether the runs ended on different motions, as with hysteresis.
    points : structured ndarray
        The impacts kept: ``run`` and ``index`` (of the value) and, for an oscillator, ``side`` ("R", "L"),
        ``phase``, ``x``, ``x_dot_before``, ``x_dot_after``, ``z_dot_before``, ``z_dot_after``; for a structure
        ``gap``, ``phase`` and ``speed`` of approach; with stops or friction all events except the beginning and
        the end of rests, and their ``kind`` as in `Trajectory`.
    strobes : structured ndarray
        For a structure: ``run``, ``index``, and coordinates ``q`` and velocities ``q_dot`` at the beginning of the
        load cycles of a period, or of all load cycles examined.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
    """

    __slots__ = ()
    x_min = cell("cells")
    x_max = cell("cells")

    @property
    def parameter(self) -> str:
        """Name of the parameter; "function" for a function."""
        return str(self.keys.get("label", self.keys["parameter"]))

    @property
    def values(self) -> _Array:
        """The values of the parameter (n,), ascending; for a structure those that were reached."""
        if self.of_structure:
            return self._cells[0]
        return self._values("values", "value")

    @property
    def r(self) -> float | _Array:
        """For an oscillator: the frequency ratio, or one for each value (n,)."""
        return self._beside("r")

    @property
    def clearance(self) -> float | _Array:
        """For an oscillator: the clearance d K/F0, or one for each value (n,)."""
        return self._beside("clearance")

    def _beside(self, name: str) -> float | _Array:
        """A number, or one for each value; for the parameter itself the first value."""
        if self.of_structure:
            raise AttributeError(self._lack(name, "parameter, values"))
        keys = self.keys
        value = self.values[0] if keys["parameter"] == name else keys[name]
        return np.array(value) if isinstance(value, list) else float(value)

    @property
    def runs(self) -> list[str]:
        """Names of the runs, in the order of the first index of the arrays."""
        if self.of_structure:
            return self._cells[1]
        runs: list[str] = self._values("runs", "run").tolist()
        return runs

    @cached_property
    def points(self) -> NDArray[Any]:
        if not self.of_structure:
            return self._listed("impacts", ("side", *COLUMNS))
        kind = ("kind",) if "kind" in self._result.tables["impacts"].columns else ()
        return self._listed("impacts", ("gap", "phase", "speed", *kind))

    @cached_property
    def strobes(self) -> NDArray[Any]:
        if not self.of_structure:
            raise AttributeError(self._lack("strobes", "points"))
        return self._listed("strobes", ("q", "q_dot"))

    def _listed(self, name: str, names: tuple[str, ...]) -> NDArray[Any]:
        """The rows of a table as one list, by run and value."""
        owners = np.asarray(self._result.tables[name].owners)
        if self.of_structure:
            run, index = (place[owners] for place in self._cells[2:])
        else:
            run, index = np.divmod(owners, self.values.size)
        columns = [self._values(name, each) for each in names]
        kinds = [
            (each, item.dtype, item.shape[1:]) for each, item in zip(names, columns, strict=True)
        ]
        listed = np.empty(owners.size, dtype=[("run", "i4"), ("index", "i4"), *kinds])
        for each, item in zip(("run", "index", *names), (run, index, *columns), strict=True):
            listed[each] = item
        return listed

    @property
    def windows(self) -> list[PeriodicWindow]:
        """For an oscillator: the windows with one label, run by run.

        In a diagram that was stopped early, windows next to values that were not reached are omitted, because
        their ends are not known.
        """
        return self._stretches(cut=False)

    @property
    def cut_windows(self) -> list[PeriodicWindow]:
        """For an oscillator: the windows next to values that were not reached, where they may continue."""
        return self._stretches(cut=True)

    def _stretches(self, cut: bool) -> list[PeriodicWindow]:
        """The windows with one label that have a neighbour that was not reached, or the other windows."""
        if self.of_structure:
            raise AttributeError(self._lack("windows", "labels"))
        columns = self._result.tables["windows"].columns
        keep = columns["cut"].decoded() == cut
        fields = (columns[name].decoded()[keep].tolist() for name in PeriodicWindow._fields)
        return [PeriodicWindow(*each) for each in zip(*fields, strict=True)]

    @property
    def coexisting(self) -> NDArray[np.bool_]:
        """For an oscillator: whether the runs ended on different motions at each value (n).

        This happens if there is hysteresis, or several attractors.

        Labels and max |x| are compared, so that a motion and its mirror image count as equal. The result is False
        where a run was stopped early.
        """
        reach = np.maximum(-self.x_min, self.x_max)
        different: NDArray[np.bool_] = np.ptp(reach, axis=0) > 1e-3 * reach.max(axis=0)
        labels = (self.labels != self.labels[0]).any(axis=0)
        reached = (self.status != NOT_COMPUTED).all(axis=0)
        return np.asarray((different & (self.cycles > 0).any(axis=0) | labels) & reached)

    def column(self, quantity: str) -> _Array:
        """A quantity at each point; "approach" is the approach speed.

        For a structure: a quantity of `points` or, for coordinates, velocities and outputs, of `strobes`.

        Parameters
        ----------
        quantity : str
            For an oscillator "phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after" or
            "approach". For a structure "phase" or "speed" of the impacts, or "q_0", "q_1", ..., "q_dot_0", ... or
            the name of an output.

        Returns
        -------
        ndarray
            One number for each row of `points`, or of `strobes`.
        """
        names: tuple[str, ...] = (*COLUMNS, "approach")
        if self.of_structure:
            n, outputs = self.structure.coordinates, self.structure.outputs
            names = (
                *(f"{kind}_{i}" for kind in ("q", "q_dot") for i in range(n)),
                "phase", "speed", *outputs,
            )  # fmt: skip
        if not isinstance(quantity, str) or quantity not in names:
            raise ParameterError(f"quantity = {quantity!r}: must be one of {', '.join(names)}")
        if quantity == "approach":
            return np.asarray(np.abs(self.points["z_dot_before"] - self.points["x_dot_before"]))
        if self.of_structure and quantity in outputs:
            i = [*outputs].index(quantity)
            return np.asarray(self._listed("strobes", ("outputs",))["outputs"][:, i])
        kind, _, number = quantity.rpartition("_")
        if self.of_structure and kind:
            return np.asarray(self.strobes[kind][:, int(number)])
        return np.asarray(self.points[quantity])

    def plot(
        self, ax: Any = None, quantity: str | None = None, units: Units | str | None = None
    ) -> Any:
        """Draw a quantity along the parameter (extra `plot`).

        For an oscillator, the impacts, with colour and marker by wall, and the windows N/k as a line on top.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        quantity : str, optional
            For an oscillator "x" (default), "phase", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after"
            or "approach". For a structure, an output by its name, "q_0", "q_1", ... or "q_dot_0", ... at the
            beginning of load cycles; "phase" or "speed" of the impacts. By default the first output, or "q_0"
            without outputs.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        first = next(iter(self.structure.outputs), "q_0") if self.of_structure else "x"
        return self._draw(ax, quantity or first, units=units)

    @property
    def _shown(self) -> str:
        """The parameter that sets the unit of values; "" for the load of a structure, which is a factor."""
        is_factor = self.of_structure and self.parameter == "load" and "label" not in self.keys
        return "" if is_factor else self.parameter

    def __repr__(self) -> str:
        cut = "" if self.complete else f"; cut short, {self.cut}"
        if self.of_structure:
            found = self._periodic()
        else:
            counts = {
                "run": len(self.runs),
                "impact": len(self.points),
                "periodic window": len(self.windows),
            }
            found = ", ".join(f"{n} {what}{'s' * (n != 1)}" for what, n in counts.items())
        span = range_text(self._system, self._shown, self.values[0], self.values[-1])
        return f"<BifurcationDiagram over {self.parameter} = {span}: {found}{cut}>"


def distinct(values: ArrayLike, name: str = "values", points: int | None = None) -> _Array:
    """The distinct values of an array or, with `points`, of a range, in ascending order."""
    values = range_values(values, name, points)
    wanted = "at least two different numbers"
    array = np.unique(np.asarray(checks.real_array(values, name, wanted), dtype=np.float64))
    if np.ndim(values) != 1 or array.size < 2 or not np.isfinite(array).all():
        raise ParameterError(f"{name} of shape {np.shape(values)}: must be {wanted}")
    return array


def keys_of_values(array: _Array) -> dict[str, Any]:
    """The keys of rising values of a structure: their ends and number, if these reproduce the values."""
    if spacing_of(array) == "linear":
        return {"low": array[0], "high": array[-1], "values": array.size}
    return {"list": array}


def bifurcation_structure(
    structure: Structure,
    load: Load,
    parameter: Parameter,
    values: ArrayLike,
    sweep: str = "both",
    state: tuple[ArrayLike, ArrayLike] | None = None,
    settling: int = 300,
    keep: int = 33,
    points: int | None = None,
    impacts: int = 100,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram:
    """As `bifurcation_diagram`, for a structure."""
    array = distinct(values, points=points)
    low, high = float(array[0]), float(array[-1])
    at = None
    if callable(parameter):
        at = low
        structure, load = checked_pair(parameter(low), low)
    checks.instance(structure, "structure", Structure)
    checks.instance(load, "load", Load)
    chosen = keys_of_parameter(structure, load, parameter, (low, high), at, "parameter")
    start = door.start_keys(structure, state, 0.0)
    chosen = {key: value for key, value in chosen.items() if key not in ("low", "high")}
    keys = {
        **chosen, **keys_of_values(array), "sweep": sweep, "q": start["q"], "q_dot": start["q_dot"],
        "settling": settling, "keep": keep, "points": impacts, "max_events": max_events,
        "label": getattr(parameter, "label", None),
    }  # fmt: skip
    names = ENDS | {"points": "impacts"}
    return door.run_structure(
        BifurcationDiagram, structure, load, keys, None, progress, names, stops=True
    )


def first_point(given: dict[str, Any], r: float) -> None:
    """Sets the frequency of the load to the first frequency ratio."""
    given["r"], load = r, given.get("load")
    if isinstance(load, Load):
        given["load"] = Load(r, load.sine, load.cosine, load.constant)


def _along_parameter(given: dict[str, Any]) -> None:
    """Converts the arguments for an oscillator to its first point and the arguments for the diagram of a
    structure."""
    osc: Oscillator = given["osc"]
    name: Any = given.get("parameter")
    is_amplitude = (
        name == "load" and "point" in given and not isinstance(given["point"].amplitude, Load)
    )
    if "point" in given and name not in NAMES and not is_amplitude:
        # a parameter of the structure that the point represents, such as the slip level of its friction
        state_by_coordinates(given)
        if not given.get("start", 1):
            del given["start"]
        return
    if not is_amplitude:
        checks.choice(name, "parameter", NAMES)
    values = given["values"] = distinct(given.get("values", ()), points=given.pop("points", None))
    if name in ("r", "clearance"):
        if given.get(name) is not None:
            raise ParameterError(
                f"{name} = {given[name]!r}: must be left out, since it is the parameter"
            )
        given[name] = float(values[0])
    if name == "r":
        first_point(given, given["r"])
    point = {
        each: given[each] for each in ("r", "clearance", "load") if given.get(each) is not None
    }
    for fixed, value in point.items():
        if np.ndim(value):
            raise ParameterError(
                f"{fixed} = {value!r}: must be a number if the oscillator is treated as a structure"
            )
    walls = {"R1": (0,), "R2": (1,), "restitution": (0, 1)}.get(name, ())
    beside = given.get("point")
    elements = {} if beside is None else {"friction": beside.friction, "stops": beside.stops}
    if walls and elements.get("stops"):
        raise ParameterError(f"parameter = {name!r}: must not be a parameter of compliant walls")
    for wall in walls:
        if not isinstance(osc.restitution[wall], float):
            raise ParameterError(
                f"parameter = {name!r}: must not be a coefficient that depends on the speed"
            )

    def at(value: float) -> tuple[Structure, Load]:
        there, changes = dict(point), dict[str, Any]({name: value})
        if walls:
            restitution = [value if i in walls else each for i, each in enumerate(osc.restitution)]
            changes = {"restitution": tuple(restitution)}
        if name in ("clearance", "load"):
            there |= changes
            changes = {}
        found = replace(osc, **changes).at(**there, **elements)
        return found.structure, found.load

    at.label = name  # type: ignore[attr-defined]
    given["parameter"] = "frequency" if name == "r" else at
    state_by_coordinates(given)
    if not given.get("start", 1):
        del given["start"]


@overload
def bifurcation_diagram(
    osc: Oscillator, parameter: str, values: ArrayLike, r: ArrayLike | None = None,
    clearance: ArrayLike | None = None, sweep: str = "both", states: int = 12,
    state: Mapping[str, Value] | None = None, load: Value | Load = 1.0, settling: int = 300, keep: int = 33,
    points: int | None = None, impacts: int = 100, max_events: int = 10_000_000, threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram: ...  # fmt: skip
@overload
def bifurcation_diagram(
    structure: Structure, load: Load, parameter: Parameter, values: ArrayLike,
    sweep: str = "both", state: tuple[ArrayLike, ArrayLike] | None = None, settling: int = 300, keep: int = 33,
    impacts: int = 100, max_events: int = 10_000_000, progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram: ...  # fmt: skip
@overload
def bifurcation_diagram(
    point: Point, /, parameter: str, values: ArrayLike, points: int | None = None, **options: Any
) -> BifurcationDiagram: ...


@physical_arguments
@every_system(bifurcation_structure, of_law=_along_parameter)
def bifurcation_diagram(
    osc: Oscillator,
    parameter: str,
    values: ArrayLike,
    r: ArrayLike | None = None,
    clearance: ArrayLike | None = None,
    sweep: str = "both",
    states: int = 12,
    state: Mapping[str, float] | None = None,
    load: float | Load = 1.0,
    settling: int = 300,
    keep: int = 33,
    points: int | None = None,
    impacts: int = 100,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram:
    """The impacts of the motions on which simulations settle, along a parameter.

    Sweeps carry the state from value to value, so that a motion is followed to the end of its stability; where the
    upward and downward sweeps differ, there is hysteresis. With "states", many initial states are simulated at
    each value of an oscillator, which shows attractors that no sweep reaches. If the coordinates of a structure
    are not admissible for a changed gap, they are moved towards q = 0.

    The system is `osc`, with `r` and `clearance`, or `structure, load`, or a point from `Oscillator.at`. An
    oscillator whose restitution depends on the speed, or whose load is a `Load`, is treated as a structure: `r`
    and `clearance` are single numbers.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    structure, load : Structure, Load
        In place of `osc`, `r` and `clearance`; the load has a frequency.
    parameter : {"r", "clearance", "xi", "mu", "R1", "R2", "restitution"}, or str or function
        "restitution" changes both walls. For a structure as in `branch`: "frequency", "load", "opening_0", ...,
        and likewise for a point with friction or stops, such as "slip" or "contact", where "load" is the
        amplitude divided by F0 as in `Oscillator.at`; or a smooth function that returns (structure, load) for a
        value; `structure` and `load` are then not used.
    values : array_like, or (float, float)
        At least two different numbers, in any order and with any spacing; sweeps go through them in sorted order.
        With `points` a range (lo, hi).
    r, clearance : float or array_like
        The parameters other than `parameter`: a number, or one for each of `values` (which must then rise), for a
        line across the plane.
    sweep : {"up", "down", "both", "states"}
        "both": up and then down. "states" is for an oscillator only.
    states : int
        Number of initial states for "states", spread evenly.
    state : mapping, or (array_like, array_like), optional
        State at the start of sweeps, as in `simulate`; by default a state with large velocities. For a structure,
        coordinates and velocities at load phase 0, zero by default.
    load : float
        Amplitude of the load of an oscillator.
    settling : int
        Load cycles of the transient at each value.
    keep : int
        Load cycles examined; periods of up to half of them are detected.
    points : int, optional
        Number of evenly spaced values of a range.
    impacts : int
        Largest number of impacts kept for each run and value.
    max_events : int
        Events (impacts, rests, releases; for a structure also events of stops and friction) after which the
        simulation at a value of a run is abandoned; the status says so.
    threads : int, optional
        For an oscillator; one for each processor by default. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    BifurcationDiagram
        The motions at each value of the parameter, run by run.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    StudyInterrupted
        After Ctrl-C; its attribute `result` is the part that was finished: values that a run did not reach have no
        impacts, and values that no run of a structure reached are omitted.

    Examples
    --------
    The upward sweep stays on the two-impact motion up to a much larger clearance than that at which the downward
    sweep reaches this motion:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> diagram = vi.bifurcation_diagram(osc, "clearance", (50.0, 75.0), points=26, r=1.04)
    >>> [window for window in diagram.windows if window.label == "2/1"]
    [PeriodicWindow(run='up', low=50.0, high=70.0, label='2/1'), ...]

    A mass at one wall, whose motion has one impact in two load cycles, along the amplitude of the load:

    >>> wall = vi.Structure(mass=[1], damping=[0.04], stiffness=[1], gaps=[vi.Gap([1], 1, 0.9)])
    >>> load = vi.Load(0.81, cosine=[0.36])
    >>> vi.bifurcation_diagram(wall, load, "load", [1.0, 1.05, 1.1], sweep="up").labels
    array([['1/2', '1/2', '1/2']], dtype='<U3')
    """
    checks.choice(parameter, "parameter", NAMES)
    values = range_values(values, "values", points)
    along = np.unique(checks.real_array(values, "values", "numbers"))
    if along.size < 2:
        raise ParameterError(f"values = {values!r}: must be at least two different numbers")
    fixed: dict[str, Any] = {
        name: value if name == parameter else _beside(value, name, along, values)
        for name, value in (("r", r), ("clearance", clearance))
    }
    for name, value in fixed.items():
        if name == parameter and value is not None:
            raise ParameterError(f"{name} = {value!r}: must be left out, since it is the parameter")
    keys = {
        "parameter": parameter, **(door.swept(along, parameter) or {"list": along}),
        "clearance": fixed["clearance"], "r": fixed["r"] if np.ndim(fixed["r"]) else None, "sweep": sweep,
        "settling": settling, "keep": keep,
        "points": impacts, "load": load, "max_events": max_events,
        **({"states": states} if sweep == "states" else {}),
    }  # fmt: skip
    if state is not None:
        walls = along if parameter == "clearance" else np.atleast_1d(fixed["clearance"])
        ends = {"up": walls[:1], "down": walls[-1:]}.get(sweep, walls[[0, -1]])
        start = checked_state(state, float(ends.min()))
        keys |= {name: start[name] for name in NEEDED}
    one_r = None if np.ndim(fixed["r"]) else fixed["r"]
    names = {**dict.fromkeys(("low", "high", "list"), parameter), "points": "impacts"}
    names |= {name: f"state[{name!r}]" for name in NEEDED}
    return door.run(BifurcationDiagram, osc, keys, one_r, threads, progress, names)


def _beside(value: Any, name: str, along: _Array, values: ArrayLike) -> Any:
    """The parameter that is not swept: one number, or one for each value."""
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:
        return checks.number(value, name)
    array = checks.real_array(value, name, "numbers")
    if array.shape != along.shape or not np.array_equal(along, values):
        raise ParameterError(
            f"{name} of shape {array.shape}: must be a number, or one for each of values, then in ascending order"
        )
    return array
