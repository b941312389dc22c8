"""Lyapunov exponents through impacts, accumulations and rests, of every system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..base.spacing import range_axes
from ..results import door
from ..results.noun import Noun, column
from ..results.states import NEEDED, checked_state, state_by_coordinates
from ..systems.oscillator import Oscillator, Point
from ..systems.structure import Load, Structure, without_none
from ..systems.units import place_text
from ..systems.verbs import every_system, physical_arguments

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Lyapunov", "lyapunov"]

_Array = NDArray[np.float64]


class Lyapunov(Noun, study="lyapunov", formerly="StructureLyapunov"):
    """The Lyapunov exponents of a trajectory, or of many trajectories of an oscillator on a grid of points.

    They are the exponents of the map of the state over a load cycle: the growth rates of small changes of the
    state in independent directions. An oscillator has four (those of the map from impact to impact in (x, x', z',
    alpha), divided by the time), a structure with n coordinates has 2n. For a periodic motion they are the
    logarithms of the moduli of its multipliers divided by the period. A rest reduces two directions to zero: their
    exponents are -inf. A structure whose load has no frequency has an exponent 0 along its motion, and its `cycle`
    is a unit of time.

    Attributes
    ----------
    osc, r, clearance : Oscillator, ndarray (...), ndarray (...)
        For an oscillator; 0-d for one point.
    structure : Structure
        For a structure.
    load : float, or Load or None
        Amplitude of the load of an oscillator, or the load of a structure.
    exponents : ndarray (k, ...)
        Per unit of time (1/omega for an oscillator), largest first; NaN where there were no impacts.
    largest : ndarray (...)
        The first exponent; positive for chaos.
    standard_error : ndarray (k, ...)
        Standard errors of `exponents`, from the scatter of the batches.
    per_cycle, error_per_cycle : ndarray (k, ...)
        Exponents and errors per `cycle`: logarithms of the mean factors over a cycle.
    cycle : str
        "load cycle", or "unit of time" if the load has no frequency.
    dimension : ndarray (...)
        Kaplan-Yorke dimension of the attractor of the map; NaN unless all exponents were computed.
    identity_error : ndarray (...)
        Difference, per unit of time, between the sum of the exponents and its value from damping and impacts: a
        check of the whole computation. For an oscillator, this value is -2 xi t + 2 sum log R +
        log(u_first/u_last) over the flights, where u is the speed at which the masses separate. For a structure it
        is -tr(M^-1 C) + sum log R (R + R' v); NaN with rests or unless all exponents were computed.
    impacts, rests : ndarray (...) of int
        Number of impacts and rests in the average; with stops or friction all other events count as impacts.
    cycles : int
        Number of load cycles in the average.
    status : ndarray (...) of int
        For an oscillator: 0 done; see `status_text`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
    """

    __slots__ = ()
    r = column("points")
    clearance = column("points")
    exponents = column("points", first=True, of_structure="exponents.exponent")
    standard_error = column("points", first=True, of_structure="exponents")
    per_cycle = column("points", first=True, of_structure="exponents")
    error_per_cycle = column("points", first=True, of_structure="exponents")
    dimension = column("points", of_structure="run")
    identity_error = column("points", of_structure="run")
    impacts = column("points", of_structure="run")
    rests = column("points", of_structure="run")
    status = column("points")

    @property
    def cycles(self) -> int:
        """Number of load cycles in the average."""
        keys = self.keys
        cycles: int = keys["cycles"] // keys["batches"] * keys["batches"]
        return cycles

    @property
    def cycle(self) -> str:
        """The unit of `per_cycle`: "load cycle", or "unit of time" if the load has no frequency."""
        free = self.of_structure and (self.load is None or not self.load.frequency)
        return "unit of time" if free else "load cycle"

    @property
    def largest(self) -> _Array:
        """The largest exponent per unit of time (...); positive for chaos."""
        return np.asarray(self.exponents[0])

    def require(self) -> None:
        """Raise a SingularError if it is a single point without exponents."""
        single = self._result.empty if self.of_structure else not self.r.ndim and self.status
        if single:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None, units: Units | str | None = None) -> Any:
        """Draw the exponents (extra `plot`).

        For an oscillator they are drawn against r or clearance, whichever varies; for a structure, against their
        index.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return self._draw(ax, units=units)

    def __repr__(self) -> str:
        if self.per_cycle.ndim > 1:
            chaotic = int((self.per_cycle[0] > 3 * self.error_per_cycle[0]).sum())
            cut = "" if self.complete else f"; cut short, {self.cut}"
            return (
                f"<Lyapunov exponents at {self.r.size} points, {chaotic} with a positive one{cut}>"
            )
        where = ""
        if not self.of_structure:
            where = f" at {place_text(self.osc, float(self.r), float(self.clearance))}"
        shown = ", ".join(f"{item:.4g}" for item in self.per_cycle[:6].tolist())
        more = ", ..." if self.per_cycle.size > 6 else ""
        return f"<Lyapunov exponents per {self.cycle}{where}: {shown}{more}>"


def lyapunov_structure(
    structure: Structure,
    load: Load | None = None,
    cycles: int = 2000,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    discard: int = 300,
    batches: int = 20,
    directions: int | None = None,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov:
    """As `lyapunov`, for a structure."""
    keys = {
        **door.start_keys(structure, state, start), "cycles": cycles, "discard": discard, "batches": batches,
        "directions": directions, "max_events": max_events,
    }  # fmt: skip
    found = door.run_structure(
        Lyapunov,
        structure,
        without_none(load),
        keys,
        None,
        progress,
        needs_frequency=False,
        stops=True,
    )
    found.require()
    return found


@overload
def lyapunov(
    osc: Oscillator, r: ArrayLike, clearance: ArrayLike, cycles: int = 10_000,
    state: Mapping[str, Value] | None = None, load: Value | Load = 1.0, discard: int = 1000, batches: int = 20,
    max_events: int = 10_000_000, points: int | None = None, threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov: ...  # fmt: skip
@overload
def lyapunov(
    structure: Structure, load: Load | None = None, cycles: int = 2000,
    state: tuple[ArrayLike, ArrayLike] | None = None, start: float = 0.0, discard: int = 300, batches: int = 20,
    directions: int | None = None, max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov: ...  # fmt: skip
@overload
def lyapunov(point: Point, /, cycles: int = 10_000, **options: Any) -> Lyapunov: ...


@physical_arguments
@every_system(lyapunov_structure, of_law=state_by_coordinates)
def lyapunov(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    cycles: int = 10_000,
    state: Mapping[str, float] | None = None,
    load: float | Load = 1.0,
    discard: int = 1000,
    batches: int = 20,
    max_events: int = 10_000_000,
    points: int | None = None,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov:
    """Lyapunov exponents of a simulated motion, through impacts, accumulations and rests.

    Directions are carried from event to event by the exact derivatives of flights, impacts, accumulations and
    releases ([P_i] from impact to impact of an oscillator), and orthonormalised after each event. The averages are
    weighted by a function that rises smoothly from 0 and falls smoothly to 0, so that averages over periodic and
    quasi-periodic motions converge faster than any power of the time. The standard error follows from batches of
    load cycles, averaged in the same way. A further batch precedes the others, during which the directions settle.

    The system is `osc, r, clearance`, or `structure, load`, or a point from `Oscillator.at`.

    Parameters
    ----------
    osc, r, clearance : Oscillator, float or array_like, float or array_like
        One point, or arrays of the same shape. With `points`, r or clearance or both are ranges (lo, hi), along a
        line.
    structure, load : Structure, Load or None
        In place of `osc`, `r` and `clearance`; a load of None means free motion. Without a frequency, cycles are
        units of time.
    cycles : int
        Load cycles over which the exponents are averaged, at least 2 per batch; for a structure 2000 by default.
    state : mapping, or (array_like, array_like), optional
        As in `simulate`; at rest by default, the free mass in the middle.
    load : float
        Amplitude of the load of an oscillator.
    start : float
        For a structure: time at the start.
    discard : int
        Load cycles of the transient; for a structure 300 by default.
    batches : int
        2 to 1000.
    directions : int, optional
        For a structure: number of exponents, the largest ones; by default all, two per coordinate.
    max_events : int
        Events (impacts, rests, releases; for a structure also events of stops and friction) after which the
        simulation of a point is abandoned; its status says so. Long averages need more than the default.
    points : int, optional
        For an oscillator: number of evenly spaced values of a range.
    threads : int, optional
        For an oscillator; one for each processor by default. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    Lyapunov
        The exponents and their standard errors.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a single point has no impacts, or the simulation of a structure fails or reaches `max_events`.
    StudyInterrupted
        After Ctrl-C, if points were finished: its attribute `result` contains them, as a list.

    Examples
    --------
    The stable motion that corresponds to the third column of Table 1, which has two pairs of complex multipliers.

    >>> import math, numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> near = dict(t=motion.load_phase / 0.94, x=motion.X[0], x_dot=motion.X_dot_after[0],
    ...             z=motion.Z[0], z_dot=motion.Z_dot_after[0])
    >>> result = vi.lyapunov(osc, 0.94, 37.0, state=near)
    >>> bool(np.allclose(result.per_cycle, np.log(abs(motion.multipliers)), atol=1e-6))
    True
    >>> result
    <Lyapunov exponents per load cycle at r = 0.94, d K/F0 = 37: -0.0674, -0.0674, -0.5414, -0.5414>

    A mass that hits one wall:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> vi.lyapunov(wall, vi.Load(1.0, cosine=[1]))
    <Lyapunov exponents per load cycle: -0.5373, -0.5373>
    """
    r, clearance = range_axes(r, clearance, points)
    rs, clearances = (
        checks.real_array(value, name, "numbers")
        for value, name in ((r, "r"), (clearance, "clearance"))
    )
    try:
        rs, clearances = np.broadcast_arrays(rs, clearances)
    except ValueError:
        raise ParameterError(
            f"r {rs.shape}, clearance {clearances.shape}: must have the same shape"
        ) from None
    if not rs.size or rs.ndim > 3:
        raise ParameterError(
            f"r, clearance of shape {rs.shape}: must have at least one point, and at most 3 dimensions"
        )
    places, one_r = points_of(rs, clearances)
    if state is not None:
        start = checked_state(state, float(clearances.min()))
        places |= {name: start[name] for name in NEEDED}
    keys = {
        **places, "load": load, "cycles": cycles, "discard": discard, "batches": batches,
        "max_events": max_events,
    }  # fmt: skip
    found = door.run(Lyapunov, osc, keys, one_r, threads, progress)
    found.require()
    return found


def points_of(r: _Array, clearance: _Array) -> tuple[dict[str, Any], float | None]:
    """The keys of the points, and r of the system: one point, a line along r or clearance, or a list."""
    if r.ndim == 0:
        return {"clearance": float(clearance)}, float(r)
    if np.ptp(clearance) == 0 and (line := door.swept(r, "r")):
        return {"parameter": "r", **line, "clearance": clearance[0]}, None
    if np.ptp(r) == 0 and (line := door.swept(clearance, "clearance")):
        return {"parameter": "clearance", **line}, float(r[0])
    lists = {
        name: item.ravel()[: None if np.ptp(item) else 1]
        for name, item in (("r", r), ("clearance", clearance))
    }
    if r.size > 1 and lists["r"].size == lists["clearance"].size == 1:
        lists["r"] = r.ravel()
    return {**lists, "shape": r.shape if r.ndim > 1 else None}, None
