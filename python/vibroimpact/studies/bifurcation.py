"""Bifurcation diagrams by simulation: sweeps up and down, and many initial states."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.status import NOT_COMPUTED
from ..results import door
from ..results.noun import Noun, column, key
from ..results.states import NEEDED, checked_state
from ..systems.oscillator import Oscillator
from ..systems.verbs import every_system
from .structure_sweep import bifurcation_structure

__all__ = ["BifurcationDiagram", "PeriodicWindow", "bifurcation_diagram"]

_Array = NDArray[np.float64]
NAMES = ("r", "clearance", "xi", "mu", "R1", "R2", "restitution")
SWEEPS = ("up", "down", "both", "states")
#: Columns of an impact.
COLUMNS = ("phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")


class PeriodicWindow(NamedTuple):
    """A range of successive values of a run over which the motion keeps its label N/k.

    N impacts (an accumulation counts as one) in k load cycles.
    """

    run: str
    low: float
    high: float
    label: str


class BifurcationDiagram(Noun, study="bifurcation"):
    """The motions on which simulations settle along a parameter.

    Attributes
    ----------
    osc : Oscillator
    parameter : str
    values : ndarray (n,)
        Values of the parameter, rising.
    r, clearance : float or ndarray (n,)
        The one that is not swept.
    load : float
    runs : list of str
        "up", "down", or "state 1", ...: the first index of the arrays below.
    cycles, symbols, impacts, rests : ndarray (runs, n) of int
        Load cycles k of the shortest period of the stable motion that Newton's method confirms at the end of the
        simulation; 0 if there is none up to the longest one considered: chaotic, quasi-periodic, or not settled
        yet. Symbols N, impacts and rests in it, or without a period in all cycles examined.
    x_min, x_max : ndarray (runs, n)
        Extreme positions of the primary mass.
    labels : ndarray (runs, n) of str
        N/k of each run and value; "" where no period is confirmed, "0/1" without impacts.
    status : ndarray (runs, n) of int
        0 done; see `status_text`.
    points : structured ndarray
        The impacts kept: ``run`` and ``index`` (of the value), ``side`` ("R", "L"), ``phase``, ``x``,
        ``x_dot_before``, ``x_dot_after``, ``z_dot_before``, ``z_dot_after``.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ("_points",)
    _points: NDArray[Any]
    values = column("values", "value")
    cycles = column("cells")
    symbols = column("cells")
    impacts = column("cells")
    rests = column("cells")
    x_min = column("cells")
    x_max = column("cells")
    status = column("cells")
    labels = column("cells", "label")
    parameter: str = key("parameter")
    load: float = key("load")

    @property
    def r(self) -> float | _Array:
        return self._beside("r")

    @property
    def clearance(self) -> float | _Array:
        return self._beside("clearance")

    def _beside(self, name: str) -> float | _Array:
        """A number, or one for each value; for the parameter itself the first value."""
        keys = self.keys
        value = self.values[0] if keys["parameter"] == name else keys[name]
        return np.array(value) if isinstance(value, list) else float(value)

    @property
    def runs(self) -> list[str]:
        runs: list[str] = self._result.tables["runs"].columns["run"].decoded().tolist()
        return runs

    @property
    def points(self) -> NDArray[Any]:
        if not hasattr(self, "_points"):
            object.__setattr__(self, "_points", self._list_points())
        return self._points

    def _list_points(self) -> NDArray[Any]:
        """The impacts as one list, by run and value."""
        table = self._result.tables["impacts"]
        names = ("side", *COLUMNS)
        kinds = [
            ("run", "i4"),
            ("index", "i4"),
            ("side", "U1"),
            *((name, "f8") for name in COLUMNS),
        ]
        points = np.empty(table.dims["impact"], dtype=kinds)
        points["run"], points["index"] = np.divmod(np.asarray(table.owners), self.values.size)
        for name in names:
            points[name] = table.columns[name].decoded()
        return points

    @property
    def windows(self) -> list[PeriodicWindow]:
        """The windows with one label, run by run.

        In a diagram that was stopped early, those next to values that were not reached are left out, because
        their ends are not known.
        """
        return self._stretches(cut=False)

    @property
    def cut_windows(self) -> list[PeriodicWindow]:
        """The windows next to values that were not reached, where they may continue."""
        return self._stretches(cut=True)

    def _stretches(self, cut: bool) -> list[PeriodicWindow]:
        """The windows with one label that have a neighbour that was not reached, or the other windows."""
        columns = self._result.tables["windows"].columns
        keep = columns["cut"].decoded() == cut
        fields = (columns[name].decoded()[keep].tolist() for name in PeriodicWindow._fields)
        return [PeriodicWindow(*each) for each in zip(*fields, strict=True)]

    @property
    def coexisting(self) -> NDArray[np.bool_]:
        """Whether the runs ended on different motions at each value (n): hysteresis, or several attractors.

        Labels and max |x| are compared, so that a motion and its mirror image count as one; False where a run
        was stopped early.
        """
        reach = np.maximum(-self.x_min, self.x_max)
        different: NDArray[np.bool_] = np.ptp(reach, axis=0) > 1e-3 * reach.max(axis=0)
        labels = (self.labels != self.labels[0]).any(axis=0)
        reached = (self.status != NOT_COMPUTED).all(axis=0)
        return np.asarray((different & (self.cycles > 0).any(axis=0) | labels) & reached)

    def column(self, quantity: str) -> _Array:
        """A column of the points; "approach" is the speed of approach, "y_dot" that of the free mass."""
        if isinstance(quantity, str) and quantity == "approach":
            return np.asarray(np.abs(self.points["z_dot_before"] - self.points["x_dot_before"]))
        if not isinstance(quantity, str) or quantity not in COLUMNS:
            raise ParameterError(
                f"quantity = {quantity!r}: must be one of {', '.join((*COLUMNS, 'approach'))}"
            )
        return np.asarray(self.points[quantity])

    def plot(self, ax: Any = None, quantity: str = "x") -> Any:
        """Draw the impacts, with colour and marker by wall, and the windows N/k as a line on top.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        quantity : str
            "phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after" or "approach".

        Returns
        -------
        Axes
        """
        return self._draw(ax, quantity)

    def __repr__(self) -> str:
        low, high = self.values[0], self.values[-1]
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return (
            f"<BifurcationDiagram over {self.parameter} = {low:.6g} to {high:.6g}: {len(self.runs)} runs, "
            f"{len(self.points)} impacts, {len(self.windows)} periodic windows{cut}>"
        )


@every_system(bifurcation_structure)
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
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> BifurcationDiagram:
    """The impacts of the motions on which simulations settle, along a parameter.

    Sweeps carry the state from value to value, so that a motion is followed to the end of its stability:
    where the sweeps up and down differ there is hysteresis. With "states" each value starts anew from many
    initial states, which shows attractors that no sweep reaches.

    Parameters
    ----------
    osc : Oscillator
    parameter : {"r", "clearance", "xi", "mu", "R1", "R2", "restitution"}
        "restitution" changes both walls.
    values : array_like
        At least two.
    r, clearance : float or array_like
        The ones that are not `parameter`: a number, or one for each of `values` (which rise then), for a
        line across the plane.
    sweep : {"up", "down", "both", "states"}
    states : int
        Initial states of "states", spread evenly.
    state : mapping, optional
        State at the start of sweeps, as in `simulate`; by default a state with large velocities.
    load : float
    settling : int
        Load cycles of the transient at each value.
    keep : int
        Load cycles examined; periods of up to half of them are detected.
    points : int
        Impacts kept of each run and value.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is given up, one at each value of a
        run; the status says so.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    BifurcationDiagram

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`:
        values that a run did not reach have no impacts.

    Examples
    --------
    The sweep up stays on the two-impact motion up to a much larger clearance than that at which the sweep down
    reaches it:

    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> diagram = vi.bifurcation_diagram(osc, "clearance", np.arange(50.0, 76.0), r=1.04)
    >>> [window for window in diagram.windows if window.label == "2/1"]
    [PeriodicWindow(run='up', low=50.0, high=70.0, label='2/1'), ...]
    """
    checks.choice(parameter, "parameter", NAMES)
    along = np.unique(checks.real_array(values, "values", "numbers"))
    if along.size < 2:
        raise ParameterError(f"values = {values!r}: must be at least two different numbers")
    fixed: dict[str, Any] = {
        name: value if name == parameter else _beside(value, name, along, values)
        for name, value in (("r", r), ("clearance", clearance))
    }
    for name, value in fixed.items():
        if name == parameter and value is not None:
            raise ParameterError(f"{name} = {value!r}: must be left out, it is the parameter")
    keys = {
        "parameter": parameter, **(door.swept(along, parameter) or {"list": along}),
        "clearance": fixed["clearance"], "r": fixed["r"] if np.ndim(fixed["r"]) else None, "sweep": sweep,
        "settling": settling, "keep": keep,
        "points": points, "load": load, "max_events": max_events,
        **({"states": states} if sweep == "states" else {}),
    }  # fmt: skip
    if state is not None:
        walls = along if parameter == "clearance" else np.atleast_1d(fixed["clearance"])
        ends = {"up": walls[:1], "down": walls[-1:]}.get(sweep, walls[[0, -1]])
        start = checked_state(state, float(ends.min()))
        keys |= {name: start[name] for name in NEEDED}
    one_r = None if np.ndim(fixed["r"]) else fixed["r"]
    names = dict.fromkeys(("low", "high", "list"), parameter)
    names |= {name: f"state[{name!r}]" for name in NEEDED}
    return door.run(BifurcationDiagram, osc, keys, one_r, threads, progress, names)


def _beside(value: Any, name: str, along: _Array, values: ArrayLike) -> Any:
    """The parameter that is not swept: a number, or one for each value."""
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:
        return checks.number(value, name)
    array = checks.real_array(value, name, "numbers")
    if array.shape != along.shape or not np.array_equal(along, values):
        raise ParameterError(
            f"{name} of shape {array.shape}: must be a number, or one for each of values, which have to rise then"
        )
    return array
