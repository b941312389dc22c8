"""Event-by-event simulation of linear structures with gaps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, checks
from .errors import ParameterError
from .status import MORE_EVENTS, raise_status
from .structure import Load, Structure

__all__ = ["StructureTrajectory", "simulate_structure"]

_Array = NDArray[np.float64]
#: Names of the kinds of events 1, 2, 3.
KINDS = np.array(["impact", "stick", "release"])
#: Number of events for which space is allocated at first.
ROOM = 1024


@dataclass(frozen=True, eq=False, repr=False)
class StructureTrajectory:
    """A simulated motion of a structure.

    Attributes
    ----------
    structure : Structure
    load : Load or None
    start, end : float
        Times between which it was simulated.
    events : structured array
        ``time, kind`` (impact; stick, the end of an accumulation of impacts; release), ``gap`` (from 0),
        ``speed`` (approach speed) and ``impulse``.
    states : ndarray (events, 2, n)
        Coordinates and velocities just after each event.
    first_state, final_state : (ndarray, ndarray)
        Coordinates and velocities at `start` and `end`.
    complete : bool
        False if the greatest number of events was reached; `end` is then the time of the last one.
    """

    structure: Structure
    load: Load | None
    start: float
    end: float
    events: NDArray[Any]
    states: _Array
    first_state: tuple[_Array, _Array]
    final_state: tuple[_Array, _Array]
    complete: bool

    def sample(self, t: ArrayLike) -> tuple[_Array, _Array]:
        """Coordinates and velocities at given times, exactly.

        Parameters
        ----------
        t : array_like (m,)
            Times from `start` to `end`. At the time of an event the velocities are those just after it.

        Returns
        -------
        q, q_dot : ndarray (n, m)

        Raises
        ------
        ParameterError
            If a time is outside.
        """
        wanted = f"times from {self.start!r} to {self.end!r}"
        times = np.atleast_1d(checks.real_array(t, "t", wanted))
        inside = (times >= self.start) & (times <= self.end)
        if times.ndim != 1 or not inside.all():
            raise ParameterError(f"t = {times[~inside][:3].tolist()!r}: must be {wanted}")
        order = np.argsort(times, kind="stable")
        n, m = self.structure.coordinates, len(self.events) + 1
        starts = np.empty((2 * n + 1, m), order="F")
        starts[0] = np.append(self.start, self.events["time"])
        starts[1:, 0] = np.concatenate(self.first_state)
        starts[1:, 1:] = self.states.reshape(m - 1, 2 * n).T
        labels = np.zeros((2, m), dtype=np.int32, order="F")
        for i, kind in enumerate(KINDS.tolist(), 1):
            labels[0, 1:][self.events["kind"] == kind] = i
        labels[1, 1:] = self.events["gap"] + 1
        values, status = _core.sample_structure(
            *_arrays(self.structure, self.load), starts, labels, times[order]
        )
        raise_status(status)
        found = np.empty((2 * n, len(times)))
        found[:, order] = values
        return found[:n], found[n:]

    def __repr__(self) -> str:
        impacts = int((self.events["kind"] == "impact").sum())
        rests = int((self.events["kind"] == "stick").sum())
        return (
            f"<StructureTrajectory t = {self.start:g} to {self.end:g}: {impacts} impacts, {rests} rests"
            f"{'' if self.complete else ', NOT complete'}>"
        )


def _arrays(
    structure: Structure, load: Load | None
) -> tuple[_Array, _Array, _Array, float, _Array, _Array]:
    """The arguments of the core for a structure and its load."""
    matrices, directions, values = structure._arrays()
    if load is None:
        nothing = np.zeros((structure.coordinates, 2, 0))
        return matrices, directions, values, 0.0, nothing, np.zeros(structure.coordinates)
    frequency, harmonics, constant = load._arrays()
    return matrices, directions, values, frequency, harmonics, constant


def simulate_structure(
    structure: Structure,
    load: Load | None = None,
    *,
    cycles: float | None = None,
    duration: float | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    max_events: int = 1_000_000,
) -> StructureTrajectory:
    """Simulate a structure with gaps; no impact is missed, and accumulating impacts are completed.

    Between impacts everything is closed form, mode by mode. The first gap that closes is found by steps that
    bounds on the derivatives prove free of contact. At an impact on gap j the velocities jump by the impulse
    (1 + R) m v along M^-1 G, with v the approach speed and 1/m = G.M^-1 G. `vibroimpact.simulate` calls this
    for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load, optional
        None: free motion.
    cycles, duration : float
        How long, in cycles of the load or in time; give one of them.
    state : (array_like, array_like), optional
        Coordinates and velocities at the start; zero by default.
    start : float
        Time at the start.
    max_events : int
        Events after which the trajectory ends, if there are more (`complete` is then False).

    Returns
    -------
    StructureTrajectory

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a gap is less than closed at the start, a mode without damping resonates with the load, two modes
        coincide by damping, or coupled gaps close at one instant.

    Examples
    --------
    A mass on a spring that carries a free mass between two walls, which starts with velocity -1:

    >>> import vibroimpact as vi
    >>> gaps = [vi.Gap([-1, 1], 1.0), vi.Gap([1, -1], 1.0)]
    >>> cell = vi.Structure(mass=[1, 0.3], damping=[0, 0], stiffness=[1, 0], gaps=gaps)
    >>> run = vi.simulate(cell, duration=20, state=([0, 0], [0, -1]))
    >>> run
    <StructureTrajectory t = 0 to 20: 6 impacts, 0 rests>
    >>> run.events["time"][:3].round(6).tolist()
    [1.0, 5.561718, 7.505486]
    """
    checks.instance(structure, "structure", Structure)
    n = structure.coordinates
    if load is not None:
        checks.instance(load, "load", Load)
        if load.coordinates != n:
            raise ParameterError(
                f"load for {load.coordinates} coordinates: must be for {n} as the structure is"
            )
    if (cycles is None) == (duration is None):
        raise ParameterError(
            f"cycles = {cycles!r}, duration = {duration!r}: must be one of them, not both"
        )
    wanted = "a number >= 0"
    if duration is None:
        if load is None:
            raise ParameterError(
                f"cycles = {cycles!r}: must be given with a load; give duration without"
            )
        span = checks.number(cycles, "cycles_simulated", "cycles") * 2 * np.pi / load.frequency
    else:
        span = checks.to_float(duration, "duration", wanted)
    if not 0 <= span <= 1e12:
        raise ParameterError(f"duration = {span!r}: must be a number with 0 <= duration <= 1e+12")
    start = checks.to_float(start, "start", "a number")
    if not 0 <= start <= 1e12:
        raise ParameterError(f"start = {start!r}: must be a number with 0 <= start <= 1e+12")
    max_events = checks.integer(max_events, "max_events", 1, 10**8)
    q, rate = _state(state, n)
    arguments = _arrays(structure, load)
    first = np.append(q, rate)
    room = min(ROOM, max_events)
    while True:
        table = np.empty((2 * n + 3, room), order="F")
        labels = np.empty((2, room), dtype=np.int32, order="F")
        count, final, end, status = _core.simulate_structure(
            *arguments, start, first, start + span, table, labels
        )
        if status != MORE_EVENTS or room == max_events:
            break
        room = min(8 * room, max_events)
    if status not in (0, MORE_EVENTS):
        raise_status(status)
    events = np.zeros(count, dtype=[
        ("time", "f8"), ("kind", "U7"), ("gap", "i4"), ("speed", "f8"), ("impulse", "f8"),
    ])  # fmt: skip
    events["time"], events["speed"], events["impulse"] = table[:3, :count]
    events["kind"] = KINDS[labels[0, :count] - 1]
    events["gap"] = labels[1, :count] - 1
    states = np.ascontiguousarray(table[3:, :count].T).reshape(count, 2, n)
    for array in (events, states, final):
        array.flags.writeable = False
    return StructureTrajectory(
        structure, load, start, end, events, states, (q, rate), (final[:n], final[n:]), status == 0
    )


def _state(state: Any, n: int) -> tuple[_Array, _Array]:
    """Coordinates and velocities of an initial state."""
    wanted = f"two lists of {n} finite numbers, coordinates and velocities"
    if state is None:
        return np.zeros(n), np.zeros(n)
    try:
        q, rate = state
    except (TypeError, ValueError):
        raise ParameterError(f"state = {state!r}: must be {wanted}") from None
    parts = []
    for values in (q, rate):
        array = np.array(checks.real_array(values, "state", wanted), dtype=np.float64)
        if array.shape != (n,) or not np.isfinite(array).all():
            raise ParameterError(f"state = {state!r}: must be {wanted}")
        array.flags.writeable = False
        parts.append(array)
    return parts[0], parts[1]
