"""Settled motions of structures along a parameter: bifurcation diagrams and responses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.spacing import spacing_of
from ..base.status import sentence
from ..motions.structure_noun import StructureNoun, run_structure, start_keys
from ..results.noun import column, key
from ..results.parameters import Parameter, keys_of_parameter
from ..results.tables import runs
from ..systems.structure import Load, Structure

__all__ = [
    "StructureBifurcation",
    "StructureResponse",
    "bifurcation_structure",
    "response_structure",
]

_Array = NDArray[np.float64]
#: What the core calls the ends of the values.
ENDS = {"low": "values[0]", "high": "values[-1]"}


class _Sweep(StructureNoun):
    """What was found at each value, in the order of the sweep.

    Attributes
    ----------
    values : ndarray (cells,)
    runs : ndarray (cells,) of str
        "up" or "down".
    cycles, impacts, rests : ndarray (cells,) of int
    status : ndarray (cells,) of int
    """

    __slots__ = ()
    values = column("cells", "value")
    runs = column("cells", "run")
    cycles = column("cells")
    impacts = column("cells")
    rests = column("cells")
    status = column("cells")

    @property
    def labels(self) -> list[str]:
        """Impacts/load cycles of the period at each value; empty where none is confirmed."""
        pairs = zip(self.impacts.tolist(), self.cycles.tolist(), strict=True)
        return [f"{n}/{k}" if k else "" for n, k in pairs]

    @property
    def failures(self) -> dict[str, int]:
        """Messages of simulations that failed, and how often each occurred."""
        codes, counts = np.unique(self.status[self.status != 0], return_counts=True)
        return {sentence(int(code)): int(n) for code, n in zip(codes, counts, strict=True)}

    def _shown(self, what: str) -> str:
        periodic = int((self.cycles > 0).sum())
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return f"<{type(self).__name__} {what}: {self.values.size} values, {periodic} with a period{cut}>"


class StructureBifurcation(_Sweep, study="bifurcation_structure"):
    """Settled motions of a structure along a parameter, on the way up and on the way down.

    Attributes
    ----------
    structure : Structure
    load : Load
    parameter : str
    values : ndarray (cells,)
        The parameter, in the order of the sweep.
    runs : ndarray (cells,) of str
        "up" or "down".
    cycles : ndarray (cells,) of int
        Load cycles of the shortest period of the stable motion that Newton's method confirms; 0 if there is none:
        chaotic, quasi-periodic, or not settled yet.
    impacts, rests : ndarray (cells,) of int
        Of a period, or without a period of all cycles that were examined.
    labels : list of str
        Impacts/load cycles; empty where no period is confirmed.
    status : ndarray (cells,) of int
        0 done; see `status_text`. After a failure the next value starts anew.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ()
    parameter: str = key("parameter")

    def strobes(self, cell: int) -> tuple[_Array, _Array]:
        """Coordinates and velocities (m, n) at the beginning of load cycles at one of `values`: those of a period,
        or all that were examined."""
        part = self._rows("strobes", cell)
        return self._table("strobes", "q")[part], self._table("strobes", "q_dot")[part]

    def impacts_of(self, cell: int) -> tuple[NDArray[np.int32], _Array, _Array]:
        """Gaps, load phases and approach speeds of the impacts that were kept at one of `values`."""
        part = self._rows("impacts", cell)
        gaps, phases, speeds = (
            self._table("impacts", name)[part] for name in ("gap", "phase", "speed")
        )
        return gaps, phases, speeds

    def _rows(self, table: str, cell: int) -> slice:
        cell = checks.integer(cell, "cell", 0, self.values.size - 1)
        return runs(self._result.tables[table], self.values.size)[cell]

    def plot(self, ax: Any = None, quantity: str = "q_0") -> Any:
        """Draw a quantity along the parameter (extra `plot`); returns the Axes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        quantity : str
            "q_0", "q_1", ... or "q_dot_0", ... at the beginning of load cycles; "phase" or "speed" of the impacts.
        """
        return self._draw(ax, quantity)

    def __repr__(self) -> str:
        return self._shown(f"along {self.parameter}")


class StructureResponse(_Sweep, study="response_structure"):
    """The size of settled motions of a structure over the load frequency, on the way up and on the way down.

    Attributes
    ----------
    structure : Structure
    load : Load
    values : ndarray (cells,)
        Circular frequencies of the load, in the order of the sweep.
    runs : ndarray (cells,) of str
        "up" or "down".
    largest, rms : ndarray (n, cells)
        Greatest magnitude of each coordinate over the cycles that were examined, and root of its mean square.
    q_min, q_max : ndarray (n, cells)
        Least and greatest value of each coordinate.
    steady_largest, steady_rms : ndarray (n, cells)
        The same of the steady motion without impacts; NaN if there is none.
    cycles, impacts, rests, labels, status
        As of `StructureBifurcation`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ()
    largest = column("cells", first=True)
    rms = column("cells", first=True)
    q_min = column("cells", first=True)
    q_max = column("cells", first=True)
    steady_largest = column("cells", first=True)
    steady_rms = column("cells", first=True)

    def plot(self, ax: Any = None, coordinate: int = 0) -> Any:
        """Draw the greatest magnitude of a coordinate over the frequency (extra `plot`); returns the Axes."""
        return self._draw(ax, coordinate)

    def __repr__(self) -> str:
        return self._shown("over frequency")


def _ends(values: ArrayLike) -> _Array:
    """Ascending, evenly spaced values."""
    wanted = "at least two evenly spaced numbers in ascending order"
    array = np.asarray(checks.real_array(values, "values", wanted), dtype=np.float64)
    if array.ndim != 1 or array.size < 2 or spacing_of(array) != "linear" or array[0] >= array[-1]:
        raise ParameterError(f"values of shape {array.shape}: must be {wanted}")
    return array


def bifurcation_structure(
    structure: Structure,
    load: Load,
    parameter: Parameter,
    values: ArrayLike,
    sweep: str = "both",
    state: tuple[ArrayLike, ArrayLike] | None = None,
    settling: int = 300,
    keep: int = 33,
    points: int = 100,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> StructureBifurcation:
    """The motions on which simulations of a structure settle, along a parameter.

    The state at the beginning of a load cycle is carried from value to value, so that a motion is followed to the
    end of its stability: where the ways up and down differ there is hysteresis. Coordinates that a changed gap
    does not admit are moved towards q = 0. `vibroimpact.bifurcation_diagram` calls this for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load
        With a frequency.
    parameter : str or function
        As in `vibroimpact.branch`: "frequency", "load", "opening_0", ...; or a smooth function that gives
        (structure, load) for a value. With a function `structure` and `load` are not used.
    values : array_like
        At least two, evenly spaced, ascending.
    sweep : {"up", "down", "both"}
        Both: up and then down.
    state : (array_like, array_like), optional
        Coordinates and velocities at the beginning, at load phase 0; zero by default.
    settling : int
        Load cycles of the transient at each value.
    keep : int
        Load cycles examined; periods of up to half of them are detected.
    points : int
        Impacts kept at each value.
    max_events : int
        Events (impacts, rests, releases) after which the simulation at one value is given up.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    StructureBifurcation

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    StudyInterrupted
        After Ctrl-C, with the values that were reached as its attribute `result`.

    Examples
    --------
    A motion of one impact in two load cycles, along the amplitude of the load:

    >>> import numpy as np, vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.04], stiffness=[1], gaps=[vi.Gap([1], 1, 0.9)])
    >>> load = vi.Load(0.81, cosine=[0.36])
    >>> diagram = vi.bifurcation_diagram(wall, load, "load", np.linspace(1.0, 1.1, 3), sweep="up")
    >>> diagram.labels
    ['1/2', '1/2', '1/2']
    """
    array = _ends(values)
    low, high = float(array[0]), float(array[-1])
    at = None
    if callable(parameter):
        at = low
        structure, load = parameter(low)
    checks.instance(structure, "structure", Structure)
    checks.instance(load, "load", Load)
    chosen = keys_of_parameter(structure, load, parameter, (low, high), at, "parameter")
    start = start_keys(structure, state, 0.0)
    keys = {
        **chosen, "values": array.size, "sweep": sweep, "q": start["q"], "q_dot": start["q_dot"],
        "settling": settling, "keep": keep, "points": points, "max_events": max_events,
    }  # fmt: skip
    return run_structure(StructureBifurcation, structure, load, keys, None, progress, ENDS)


def response_structure(
    structure: Structure,
    load: Load,
    values: ArrayLike,
    sweep: str = "both",
    state: tuple[ArrayLike, ArrayLike] | None = None,
    settling: int = 300,
    keep: int = 33,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> StructureResponse:
    """The size of settled motions of a structure over the load frequency, with and without impacts.

    The state is carried from frequency to frequency, up and then down. Extremes are those of the flights in closed
    form, mean squares are integrated over all flights and rests. `vibroimpact.response` calls this for a
    `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load
        Its frequency is replaced by those of `values`.
    values : array_like
        Circular frequencies, at least two, evenly spaced, ascending.
    sweep, state, settling, keep, max_events, progress
        As in `bifurcation_structure`.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.

    Returns
    -------
    StructureResponse

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    StudyInterrupted
        After Ctrl-C, with the values that were reached as its attribute `result`.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> result = vi.response(wall, vi.Load(1.0, cosine=[0.3]), np.linspace(0.6, 1.8, 13))
    >>> bool((result.q_max < 1 + 1e-12).all()), bool(result.steady_largest.max() > 2.9)
    (True, True)
    """
    array = _ends(values)
    start = start_keys(structure, state, 0.0)
    keys = {
        "low": array[0], "high": array[-1], "values": array.size, "sweep": sweep, "q": start["q"],
        "q_dot": start["q_dot"], "settling": settling, "keep": keep, "max_events": max_events,
    }  # fmt: skip
    return run_structure(StructureResponse, structure, load, keys, threads, progress, ENDS)
