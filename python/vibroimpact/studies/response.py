"""Responses along the frequency of every system; for an oscillator, over all coexisting attractors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.spacing import range_values
from ..results import door
from ..results.noun import column
from ..systems.oscillator import Oscillator, Point
from ..systems.structure import Load, Structure
from ..systems.units import positive, range_text, units_to_show
from ..systems.verbs import every_system, physical_arguments
from .bifurcation import ENDS, SettledMotions, cell, distinct, first_point, keys_of_values

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Response", "response"]

_Array = NDArray[np.float64]


class steady(cell):  # noqa: N801 (a descriptor, written as property is)
    """A column of a structure with one entry per value, independent of the run."""

    def shaped(self, noun: Any, values: NDArray[Any]) -> NDArray[Any]:
        found: NDArray[Any] = np.fmax.reduce(super().shaped(noun, values), axis=-1)
        return found


class Size(NamedTuple):
    """The size of a coordinate or output along the frequency: arrays (n, runs), those of the steady motion
    (n,)."""

    largest: _Array
    rms: _Array
    least: _Array
    greatest: _Array
    steady_largest: _Array
    steady_rms: _Array


class Response(SettledMotions, study="response", formerly="StructureResponse"):
    """The size of settled motions as a function of the load frequency.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : ndarray (n,)
        For an oscillator.
    structure : Structure
        For a structure.
    load : float or Load
    values : ndarray (n,)
        r of an oscillator; for a structure, the circular frequencies of the load that were reached, ascending.
    runs : list of str
        "state 1", ... for an oscillator, "up" or "down" for a structure: the last index of the arrays below.
    attenuation : ndarray (n, runs)
        For an oscillator: max|X|/A of the motion on which each initial state settles; NaN where the simulation
        failed.
    lowest, highest : ndarray (n,)
        For an oscillator: the smallest and the largest attenuation over the attractors at each r; NaN where all
        simulations failed.
    largest, rms : ndarray (k, n, runs)
        For a structure: greatest magnitude and root mean square of each of the k coordinates over the examined
        cycles.
    q_min, q_max : ndarray (k, n, runs)
        For a structure: least and greatest value of each coordinate.
    steady_largest, steady_rms : ndarray (k, n)
        For a structure: size of the steady motion without impacts, contact with stops, or friction; NaN if there
        is none.
    cycles : ndarray (n, runs) of int
        Load cycles of the shortest period of the stable motion that Newton's method confirms (0: none; chaotic,
        quasi-periodic, or not settled yet).
    symbols : ndarray (n, runs) of int
        For an oscillator: number of symbols in a period.
    impacts, rests : ndarray (n, runs) of int
        Impacts and rests in a period, or in the cycles kept.
    labels : ndarray (n, runs) of str
        As in `BifurcationDiagram`.
    status : ndarray (n, runs) of int
        0 done; see `status_text`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
    """

    __slots__ = ()
    r = column("points")
    clearance = column("points")
    lowest = column("points")
    highest = column("points")
    attenuation = column("runs")
    cycles = cell("runs", of_structure="cells")
    symbols = cell("runs")
    impacts = cell("runs", of_structure="cells")
    rests = cell("runs", of_structure="cells")
    status = cell("runs", of_structure="cells")
    largest = cell("cells", first=True)
    rms = cell("cells", first=True)
    q_min = cell("cells", first=True)
    q_max = cell("cells", first=True)
    steady_largest = steady("cells", first=True)
    steady_rms = steady("cells", first=True)
    _output_largest = cell("cells", "output_largest", first=True)
    _output_rms = cell("cells", "output_rms", first=True)
    _output_min = cell("cells", "output_min", first=True)
    _output_max = cell("cells", "output_max", first=True)
    _steady_output_largest = steady("cells", "steady_output_largest", first=True)
    _steady_output_rms = steady("cells", "steady_output_rms", first=True)

    @property
    def values(self) -> _Array:
        """Frequency ratios of an oscillator, or circular frequencies of the load of a structure (n,)."""
        return self._cells[0] if self.of_structure else self.r

    @property
    def runs(self) -> list[str]:
        """Names of the runs, in the order of the last index of the arrays."""
        if self.of_structure:
            return self._cells[1]
        return [f"state {i + 1}" for i in range(self.status.shape[1])]

    def _arranged(self, rows: NDArray[Any], missing: int) -> NDArray[Any]:
        return np.moveaxis(super()._arranged(rows, missing), -1, -2)

    def of(self, coordinate: int | str) -> Size:
        """The size of a coordinate of a structure, by its number, or of an output, by its name.

        Parameters
        ----------
        coordinate : int or str
            Number of the coordinate, from 0, or name of the output.

        Returns
        -------
        Size
            Arrays ``largest``, ``rms``, ``least`` and ``greatest`` (n, runs); for the motion without impacts
            ``steady_largest`` and ``steady_rms`` (n,).

        Raises
        ------
        ParameterError, ParameterTypeError
            If there is no such coordinate or output.
        """
        structure = self.structure
        if isinstance(coordinate, str):
            structure._row(coordinate)
            i = [*structure.outputs].index(coordinate)
            parts: tuple[_Array, ...] = (
                self._output_largest, self._output_rms, self._output_min, self._output_max,
                self._steady_output_largest, self._steady_output_rms,
            )  # fmt: skip
        else:
            i = checks.integer(coordinate, "coordinate", 0, structure.coordinates - 1)
            parts = (
                self.largest, self.rms, self.q_min, self.q_max, self.steady_largest, self.steady_rms,
            )  # fmt: skip
        return Size(*(part[i] for part in parts))

    def plot(
        self, ax: Any = None, coordinate: int | str | None = None, units: Units | str | None = None
    ) -> Any:
        """Draw the response (extra `plot`).

        For an oscillator, each attractor is a dot, and the envelopes are lines. For a structure, the greatest
        magnitude of an output, by its name, or of a coordinate, by its number, is drawn: by default of the first
        output, or of the first coordinate without outputs.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        coordinate : int or str, optional
            For a structure: the number of a coordinate, from 0, or the name of an output.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        if self.of_structure:
            return self._draw(ax, coordinate, units=units)
        if coordinate is not None:
            raise ParameterError(
                f"coordinate = {coordinate!r}: must be left out for a response of an Oscillator"
            )
        return self._draw(ax, units=units)

    def __repr__(self) -> str:
        values = self.values
        cut = "" if self.complete else f"; cut short, {self.cut}"
        points = f"{values.size} point{'s' * (values.size != 1)}"
        if self.of_structure:
            span = f"frequency {range_text(self._system, 'frequency', values[0], values[-1])}"
            return f"<Response at {points}, {span}: {self._periodic()}{cut}>"
        symbol = "" if units_to_show(self.osc) else "r = "
        span = range_text(self.osc, "r", values[0], values[-1])
        return (
            f"<Response at {points}, {symbol}{span}: max|X|/A from "
            f"{np.fmin.reduce(self.lowest):.4g} to {np.fmax.reduce(self.highest):.4g}{cut}>"
        )


def response_structure(
    structure: Structure,
    load: Load,
    values: ArrayLike,
    sweep: str = "both",
    state: tuple[ArrayLike, ArrayLike] | None = None,
    settling: int = 300,
    keep: int = 33,
    points: int | None = None,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Response:
    """As `response`, for a structure."""
    array = distinct(values, points=points)
    start = door.start_keys(structure, state, 0.0)
    keys = {
        **keys_of_values(array), "sweep": sweep, "q": start["q"], "q_dot": start["q_dot"],
        "settling": settling, "keep": keep, "max_events": max_events,
    }  # fmt: skip
    return door.run_structure(Response, structure, load, keys, threads, progress, ENDS, stops=True)


def _along_frequency(given: dict[str, Any]) -> None:
    """Converts the arguments for an oscillator to its first point and the arguments for the response of a
    structure."""
    values = given["values"] = distinct(given.get("r", ()), "r", given.pop("points", None))
    first_point(given, float(values[0]))
    inverse = given.pop("inverse_clearance", None)
    if inverse is not None:
        if given.get("clearance") is not None:
            raise ParameterError(
                f"clearance = {given['clearance']!r}, inverse_clearance = {inverse!r}: must not both be given"
            )
        given["clearance"] = 1 / positive(inverse, "inverse_clearance")


@overload
def response(
    osc: Oscillator, r: ArrayLike, clearance: ArrayLike | None = None,
    inverse_clearance: ArrayLike | None = None, states: int = 24, load: Value | Load = 1.0, settling: int = 600,
    keep: int = 33, points: int | None = None, max_events: int = 10_000_000, threads: int | None = None,
    progress: door.Progress | None = None,
) -> Response: ...  # fmt: skip
@overload
def response(
    structure: Structure, load: Load, values: ArrayLike,
    sweep: str = "both", state: tuple[ArrayLike, ArrayLike] | None = None, settling: int = 300, keep: int = 33,
    points: int | None = None, max_events: int = 10_000_000, threads: int | None = None,
    progress: door.Progress | None = None,
) -> Response: ...  # fmt: skip
@overload
def response(
    point: Point, /, r: ArrayLike, points: int | None = None, **options: Any
) -> Response: ...


@physical_arguments
@every_system(response_structure, of_law=_along_frequency, along=("r", "inverse_clearance"))
def response(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike | None = None,
    inverse_clearance: ArrayLike | None = None,
    states: int = 24,
    load: float | Load = 1.0,
    settling: int = 600,
    keep: int = 33,
    points: int | None = None,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Response:
    """The size of settled motions as a function of the load frequency.

    For an oscillator, it is max|X|/A over all attractors that initial states reach, for a given load or clearance.
    A is the amplitude without impacts: values below 1 mean that the impacts reduce the motion. The extreme
    positions are those of the closed form over the period, or over the cycles kept if there is no period.

    For a structure, it is the size of each coordinate and output, with and without impacts. The state is carried
    from frequency to frequency, up and then down. Extremes are those of the flights in closed form; mean squares
    are integrated over all flights and rests.

    The system is `osc`, with a clearance, or `structure, load`, or a point from `Oscillator.at`, whose clearance
    and load are used. An oscillator whose restitution depends on the speed, or whose load is a `Load`, is treated
    as a structure: the clearance is then a single number.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    structure, load : Structure, Load
        In place of `osc` and the clearance; `values` replace the frequency of the load.
    r : array_like (n,), or (float, float)
        Frequency ratios of an oscillator; with `points` a range (lo, hi).
    values : array_like, or (float, float)
        Circular frequencies of a structure's load, at least two different ones, in any order; with `points` a
        range (lo, hi).
    clearance, inverse_clearance : float or array_like (n,)
        Clearance d K/F0, or its inverse F0/(d K); give one of the two. d is the whole travel between the walls.
    states : int
        For an oscillator: number of initial states at each r, spread evenly.
    sweep : {"up", "down", "both"}
        For a structure; "both": up and then down.
    state : (array_like, array_like), optional
        For a structure: coordinates and velocities at the beginning, at load phase 0; zero by default.
    load : float
        Load amplitude f > 0 of an oscillator; 1 if lengths are in F0/K.
    settling : int
        Load cycles of the transient at each frequency; for a structure 300 by default.
    keep : int
        Load cycles examined.
    points : int, optional
        Number of evenly spaced values of a range.
    max_events : int
        Events (impacts, rests, releases; for a structure also events of stops and friction) after which one
        simulation is abandoned; its status says so.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    Response
        The size of the motions at each frequency.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; the message names the parameter, its value and what is allowed.
    StudyInterrupted
        After Ctrl-C; its attribute `result` contains the frequency ratios at which all states were completed, or
        the frequencies that the sweeps reached.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> vi.response(osc, (1.0, 1.02), points=6, inverse_clearance=0.03, states=6)
    <Response at 6 points, r = 1 to 1.02: max|X|/A from 0.3899 to 0.4468>

    A mass that hits one wall:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> result = vi.response(wall, vi.Load(1.0, cosine=[0.3]), (0.6, 1.8), points=13)
    >>> result.largest.shape, bool((result.q_max < 1 + 1e-12).all()), bool(result.steady_largest.max() > 2.9)
    ((1, 13, 2), True, True)

    Outputs are read by name:

    >>> plate = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=wall.gaps, outputs={"tip": [2]})
    >>> size = vi.response(plate, vi.Load(1.0, cosine=[0.3]), (0.6, 1.8), points=13).of("tip")
    >>> bool((size.largest == 2 * result.largest[0]).all())
    True
    """
    r = range_values(r, "r", points)
    keys = {
        **door.line("r", r), "clearance": clearance, "inverse_clearance": inverse_clearance,
        "states": states, "load": load, "settling": settling, "keep": keep,
        "max_events": max_events,
    }  # fmt: skip
    names = {"r_min": "r", "r_max": "r"}
    return door.run(Response, osc, keys, threads=threads, progress=progress, parameters=names)
