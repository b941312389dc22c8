"""Event-by-event simulation of linear structures with gaps."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..base.sizes import memory_for
from ..base.status import EVENT_LIMIT, GAP_CLOSED, MORE_EVENTS, NARROW_GAP, raise_status, sentence
from ..results import namelist
from ..results.gradient import Gradient
from ..results.noun import ACTIONS, Noun, Savable
from ..results.parameters import Wanted
from ..results.states import MOST, SPAN
from ..results.structure_groups import check_gap_numbers, system_of
from ..results.tables import Result, made
from ..systems.record import Record
from ..systems.restitution import PowerLaw, Restitution, TabulatedRestitution
from ..systems.structure import Gap, Load, Structure
from .structure_quantities import StructureQuantities, accelerations, structure_quantities

__all__ = ["StructureTrajectory", "simulate_structure"]

_Array = NDArray[np.float64]
#: Names of the kinds of events 1, 2, 3.
KINDS = np.array(["impact", "stick", "release"])
#: Bytes reserved for events at first; what is not written to takes no memory. With more events the simulation is
#: run again.
ROOM = 2**26
#: The note on a trajectory that reached the limit on events.
FULL = "max_events was reached"
#: The keys of a &simulate of a &structure.
REQUEST = ("duration", "cycles", "discard", "q", "q_dot", "start", "max_events")


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class StructureTrajectory(Savable, study="simulate_structure"):
    """A simulated motion of a structure.

    Attributes
    ----------
    structure : Structure
    load : Load, Record or None
    start, end : float
        Times between which it is kept.
    events : structured array
        ``time, kind`` (impact; stick, the end of an accumulation of impacts; release), ``gap`` (from 0),
        ``speed`` (approach speed) and ``impulse``.
    states : ndarray (events, 2, n)
        Coordinates and velocities just after each event.
    first_state, final_state : (ndarray, ndarray)
        Coordinates and velocities at `start` and `end`.
    complete : bool
        False if the greatest number of events was reached, or if it was stopped; `end` is then the time of the
        last one.
    request : dict or None
        The case by the keys of a &simulate; None if it was read from a file without its case.
    cut : str
        How far it got, if it was stopped.
    permanent : tuple of int
        Gaps that are at rest from `start` to `end`, so that no event tells of them.
    """

    structure: Structure
    load: Load | Record | None
    start: float
    end: float
    events: NDArray[Any]
    states: _Array
    first_state: tuple[_Array, _Array]
    final_state: tuple[_Array, _Array]
    complete: bool
    request: dict[str, Any] | None = None
    cut: str = ""
    permanent: tuple[int, ...] = ()

    @memory_for("a sample at the times t")
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
        n = self.structure.coordinates
        starts, labels = segments_of_events(self.start, self.first_state, self.events, self.states)
        values, status = _core.sample_structure(
            *core_arrays(self.structure, self.load), starts, labels, times[order]
        )
        raise_status(status)
        found = np.empty((2 * n, len(times)))
        found[:, order] = values
        return found[:n], found[n:]

    def _resting(self) -> tuple[int, ...]:
        """The gaps that rest from the start."""
        rests, status = _core.resting_at_start(
            *core_arrays(self.structure, self.load), np.append(self.start, self.first_state)
        )
        raise_status(status)
        return tuple(np.flatnonzero(rests).tolist())

    @memory_for("a sample at the times t")
    def acceleration(self, t: ArrayLike) -> _Array:
        """Accelerations at given times, between the impacts, which change the velocities at once.

        Parameters
        ----------
        t : array_like (m,)
            As of `sample`. At the time of an event the accelerations are those just after it.

        Returns
        -------
        q_ddot : ndarray (n, m)

        Raises
        ------
        ParameterError
            If a time is outside.
        """
        q, rate = self.sample(t)
        return accelerations(self, np.atleast_1d(np.asarray(t, dtype=np.float64)), q, rate)

    @memory_for("quantities, by their window and harmonics")
    def quantities(
        self, window: ArrayLike | None = None, harmonics: int = 10
    ) -> StructureQuantities:
        """Response quantities: rms, extremes and harmonics of all coordinates, impacts and energies.

        Parameters
        ----------
        window : (float, float), optional
            Times between which they are taken; all of it by default. Harmonics are those of a periodic response
            only if the window is a whole number of its periods.
        harmonics : int
            Harmonics of the load, 1 to 10000; there are none without a frequency.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed, or the window is too long for this structure.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
        >>> found = vi.simulate(wall, vi.Load(1.0, cosine=[1]), cycles=5).quantities()
        >>> balance = found.work - found.damping_loss - found.impact_loss - found.energy_change
        >>> abs(balance) < 1e-12 * found.work
        True
        """
        return structure_quantities(self, window, harmonics)

    def gradient(self, parameters: Sequence[Wanted] | None = None) -> Gradient:
        """The derivatives of all events and of the final state by the initial state and by parameters.

        They go through impacts, accumulations, rests and releases (saltation). The quantities are ``time``,
        ``speed``, ``impulse``, ``q`` and ``q_dot`` (just after it) of the events, and ``final_time``, ``final_q``
        and ``final_q_dot``. The end is the given number of load cycles or the given duration after the start.

        Parameters
        ----------
        parameters : sequence, optional
            Names or tuples as in `StructureMotion.gradient`, and of the start: 'start' (its time, the state being
            fixed), 'q_I' and 'q_dot_I'. Of a record 'load' is a factor. By default those of the start, frequency,
            load, and all openings and coefficients of restitution.

        Returns
        -------
        Gradient
            NaN from the first event on that has no derivatives: an impact without approach speed, or a rest that
            ends without its contact force falling through 0; `status` names it. NaN too by what would open, or
            close further, a gap that rests at the start.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a parameter does not exist, or the trajectory is not complete.
        SingularError
            If the events are not those of the structure, or gaps that depend on each other rest.

        Examples
        --------
        A mass that starts towards a wall: where it is after the impact falls by R times what it starts ahead.

        >>> import vibroimpact as vi
        >>> wall = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=[vi.Gap([1], 1, 0.8)])
        >>> run = vi.simulate(wall, duration=3, state=([0], [1]))
        >>> run.gradient()["final_q", "q_0"].round(12).tolist()
        [-0.8]
        """
        found: Gradient = ACTIONS["structure_trajectory_gradient"](self, parameters)
        return found

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` compute the same digits."""
        if self.request is None:
            raise ParameterError(
                f"{self!r}: has no namelist, since the file has none from which it was read"
            )
        load = [] if self.load is None else self.load._groups()
        return namelist.text([*self.structure._groups(), *load, ("simulate", self.request)])

    @property
    def _result(self) -> Result:
        """Its tables, with the columns that the core declares."""
        s, load = self.structure, self.load
        record = load if isinstance(load, Record) else None
        moments = (self.first_state, self.final_state)
        names = ("time", "kind", "gap", "speed", "impulse")
        tables: dict[str, Any] = {
            "events": (("event",), {name: self.events[name] for name in names} | {
                "q": self.states[:, 0], "q_dot": self.states[:, 1],
            }),
            "moments": (("moment",), {
                "moment": ("initial", "final"), "time": (self.start, self.end),
                "q": [q for q, _ in moments], "q_dot": [rate for _, rate in moments],
            }),
            **structure_tables(s, load),
            "rests": (("rest",), {"gap": list(self.permanent)}),
            "run": ((), {
                "frequency": load.frequency if isinstance(load, Load) else 0.0,
                "loaded": load is not None, "finished": self.complete,
                "step": record.step if record else 0.0,
            }),
            "record": (("sample",), {"value": record.samples if record else np.zeros((0, 0))}),
            "channels": (("channel",), {
                "weight": record.weights if record else np.zeros((0, s.coordinates)),
            }),
        }  # fmt: skip
        cut = "" if self.complete else self.cut or FULL
        case = self.to_namelist() if self.request is not None and s.gaps else ""
        return with_owners(s, made(
            "simulate_structure", case, tables, (f"final time: {namelist.digits(self.end)}",), cut
        ))  # fmt: skip

    @classmethod
    def of_result(cls, result: Result) -> StructureTrajectory:
        """The trajectory of the core's tables."""

        def values(table: str, *names: str) -> list[Any]:
            return [result.column(table, name).decoded() for name in names]

        frequency, loaded, finished = (
            item.item() for item in values("run", "frequency", "loaded", "finished")
        )
        structure, periodic = structure_of(result, frequency, loaded)
        (samples,), (weights,), (step,) = (
            values("record", "value"), values("channels", "weight"), values("run", "step"),
        )  # fmt: skip
        load: Load | Record | None = periodic
        if periodic is not None and len(samples):
            load = Record(step.item(), samples, periodic.constant, weights)
        columns = values("events", "time", "kind", "gap", "speed", "impulse")
        events = new_events(len(columns[0]))
        for name, column in zip(events.dtype.names or (), columns, strict=True):
            events[name] = column
        states = np.stack(values("events", "q", "q_dot"), axis=1)
        (start, end), q, rate = values("moments", "time", "q", "q_dot")
        check_gap_numbers(result, structure)
        check_times(events["time"], float(start), float(end))
        if not (events["kind"] != "").all():
            raise ParameterError("events.kind = '': must be a word")
        for name, array in {"states": states, "moments.q": q, "moments.q_dot": rate}.items():
            if not np.isfinite(array).all():
                raise ParameterError(f"{name}: must be finite numbers")
        for array in (events, states):
            array.flags.writeable = False
        request = request_of(result, "simulate", REQUEST, {"q", "q_dot"})
        # files of earlier versions have no such table
        kept = result.column("rests", "gap").values.tolist() if "rests" in result.tables else []
        permanent = tuple(map(int, kept))
        return cls(
            structure, load, float(start), float(end), events, states, (q[0], rate[0]), (q[1], rate[1]),
            bool(finished), request, "" if result.cut == FULL else result.cut, permanent,
        )  # fmt: skip

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax, kind="history")

    def plot(self, ax: Any = None, kind: str | None = None, window: ArrayLike | None = None) -> Any:
        """Draw the structure, the histories of its bodies, its impacts, and the energy of its modes.

        Parameters
        ----------
        ax : matplotlib Axes (extra `plot`), optional
            Without it a new figure is made, with all panels unless `kind` is given.
        kind : {"sketch", "history", "impacts", "energy"}, optional
            Which panel; "history" if `ax` is given alone.
        window : (float, float), optional
            Times between which it is drawn; all of it by default.

        Returns
        -------
        Axes, or an array of Axes if all panels were drawn.
        """
        return self._draw(ax, kind, window)

    def animate(
        self, path: str | os.PathLike[str] | None = None, window: ArrayLike | None = None,
        seconds: float = 10.0,
    ) -> Any:  # fmt: skip
        """Animate the bodies; a gap flashes where it closes, and is green while it rests (extra `plot`).

        Parameters
        ----------
        path
            As in `Motion.animate`.
        window : (float, float), optional
            Times between which it is shown; all of it by default.
        seconds : float
            How long that lasts on the screen.

        Returns
        -------
        Path
            Without `path` matplotlib's FuncAnimation, as in `Motion.animate`.
        """
        return self._animate(path, window, seconds)

    def _facts(self) -> dict[str, str]:
        n, gaps = self.structure.coordinates, len(self.structure.gaps)
        return {"coordinates": str(n), "gaps": str(gaps), "events": str(len(self.events))}

    def __repr__(self) -> str:
        impacts = int((self.events["kind"] == "impact").sum())
        rests = int((self.events["kind"] == "stick").sum())
        return (
            f"<StructureTrajectory t = {self.start:g} to {self.end:g}: {impacts} impacts, {rests} rests"
            f"{''.join(f', gap {gap} rests all the time' for gap in self.permanent)}"
            f"{'' if self.complete else ', NOT complete'}>"
        )


def request_of(
    result: Result, group: str, names: Sequence[str], lists: set[str]
) -> dict[str, Any] | None:
    """The keys of the study of a result's case, of which some are lists; None without a case."""
    if not result.case:
        return None
    *_, (last, keys) = [item for item in namelist.parts_of(result.case) if item[0] != "output"]
    if last != group:
        raise ParameterError(f"case: must end with a &{group}")
    request = {name: keys[name] for name in names if name in keys}
    return request | {name: np.atleast_1d(request[name]).tolist() for name in lists & set(request)}


class OfStructure(Noun):
    """The result of a case of a &structure with one part, unless it failed."""

    __slots__ = ()
    part: ClassVar[type[Savable]]

    def parts(self) -> list[Any]:
        """The part."""
        return [] if self._result.empty else [self.part.of_result(self._result)]

    def require(self) -> None:
        """SingularError if the case failed."""
        if self._result.empty:
            raise SingularError(self._result.notes[0][1])

    @property
    def structure(self) -> Structure:
        """The structure."""
        return system_of(self.case)[0]

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {', '.join(map(repr, self.parts())) or 'none'}>"


class StructureSimulation(OfStructure, study="simulate_structure"):
    """The result of a &simulate case of a &structure: its trajectory, unless the simulation failed."""

    __slots__ = ()
    part = StructureTrajectory


def structure_tables(s: Structure, load: Load | Record | None) -> dict[str, Any]:
    """The tables of a structure, its gaps and its load in a result."""
    n = s.coordinates
    nothing = np.zeros((0, n))
    periodic = load if isinstance(load, Load) else None
    tabulated = [
        gap.restitution for gap in s.gaps if isinstance(gap.restitution, TabulatedRestitution)
    ]
    return {
        "gaps": (("number",), {
            "opening": [gap.opening for gap in s.gaps], **_laws(s.gaps),
            "direction": np.reshape([gap.direction for gap in s.gaps], (-1, n)),
        }),
        "law_points": (("law_point",), {
            "speed": [v for gap in tabulated for v in gap.speeds],
            "restitution": [value for gap in tabulated for value in gap.values],
        }),
        "matrices": (("row",), {
            "mass": s.mass, "damping": s.damping, "stiffness": s.stiffness,
            "constant": np.zeros(n) if load is None else load.constant,
        }),
        "harmonics": (("harmonic",), {
            "cosine": periodic.cosine if periodic else nothing,
            "sine": periodic.sine if periodic else nothing,
        }),
    }  # fmt: skip


def with_owners(s: Structure, result: Result) -> Result:
    """A result in which the points of tables of restitution know their gaps."""
    owners = [i for i, gap in enumerate(s.gaps) for _ in getattr(gap.restitution, "speeds", ())]
    points = result.tables["law_points"]
    owned = replace(points, parent="gaps", owners=np.array(owners, np.int32))
    return replace(result, tables=result.tables | {"law_points": owned})


def structure_of(result: Result, frequency: float, loaded: bool) -> tuple[Structure, Load | None]:
    """The structure and the load of a result."""

    def values(table: str, *names: str) -> list[Any]:
        return [result.column(table, name).decoded() for name in names]

    gaps = [
        Gap(direction, opening, law)
        for direction, opening, law in zip(
            *values("gaps", "direction", "opening"), _laws_of(result), strict=True
        )
    ]
    mass, damping, stiffness, constant = values(
        "matrices", "mass", "damping", "stiffness", "constant"
    )
    structure = Structure(mass, damping, stiffness, gaps)
    if not loaded:
        return structure, None
    sine, cosine = values("harmonics", "sine", "cosine")
    own = {"sine": sine, "cosine": cosine} if len(sine) else {}
    return structure, Load(frequency or None, **own, constant=constant)


def check_times(times: _Array, start: float, end: float) -> None:
    """An error unless the events of a trajectory are in order between its ends."""
    if not (np.isfinite([start, end]).all() and start <= end):
        raise ParameterError(f"moments.time = {start!r}, {end!r}: must be finite, and in order")
    apart = np.diff(np.concatenate([[start], times, [end]]))
    if not (apart >= 0).all():
        i = min(int(np.argmin(apart >= 0)), len(times) - 1)
        raise ParameterError(
            f"events.time[{i}] = {times[i]!r}: must be in ascending order from {start!r} to {end!r}"
        )


def _laws(gaps: Sequence[Gap]) -> dict[str, Any]:
    """The columns of the laws of restitution of some gaps."""
    columns: dict[str, Any] = {
        "restitution": [],
        "law": [],
        "law_numbers": np.zeros((len(gaps), 3)),
    }
    for i, gap in enumerate(gaps):
        law = gap.restitution
        if isinstance(law, PowerLaw):
            columns["law_numbers"][i] = law.speed, law.exponent, law.sharpness
            columns["restitution"].append(law.R0)
        else:
            first = law.values[0] if isinstance(law, TabulatedRestitution) else law
            columns["restitution"].append(first)
        names: dict[type, str] = {PowerLaw: "power", TabulatedRestitution: "table"}
        columns["law"].append(names.get(type(law), "constant"))
    return columns


def _laws_of(result: Result) -> list[Restitution]:
    """The laws of restitution of the gaps of a result."""
    kinds, lowest, numbers = (
        result.column("gaps", name).decoded() for name in ("law", "restitution", "law_numbers")
    )
    speeds, values = (result.column("law_points", name).values for name in ("speed", "restitution"))
    owners = result.tables["law_points"].owners
    if owners is None:
        raise ParameterError("law_points.owners: must be there; they are missing")
    laws: list[Restitution] = []
    for i, kind in enumerate(kinds.tolist()):
        if kind == "power":
            laws.append(PowerLaw(float(lowest[i]), *map(float, numbers[i])))
        elif kind == "table":
            laws.append(TabulatedRestitution(speeds[owners == i], values[owners == i]))
        else:
            laws.append(float(lowest[i]))
    return laws


def segments_of_events(
    start: float, first: Sequence[_Array], events: NDArray[Any], states: _Array
) -> tuple[_Array, NDArray[np.int32]]:
    """The segments that begin at the start and just after each event, as the core takes them.

    They are time, coordinates and velocities (1 + 2n, segments), and kind and gap (2, segments).
    """
    n, m = len(first[0]), len(events) + 1
    starts = np.empty((2 * n + 1, m), order="F")
    starts[0] = np.append(start, events["time"])
    starts[1:, 0] = np.concatenate(first)
    starts[1:, 1:] = states.reshape(m - 1, 2 * n).T
    labels = np.zeros((2, m), dtype=np.int32, order="F")
    for i, kind in enumerate(KINDS.tolist(), 1):
        labels[0, 1:][events["kind"] == kind] = i
    labels[1, 1:] = events["gap"] + 1
    return starts, labels


def new_events(count: int) -> NDArray[Any]:
    """An empty table of events."""
    return np.zeros(count, dtype=[
        ("time", "f8"), ("kind", "U7"), ("gap", "i4"), ("speed", "f8"), ("impulse", "f8"),
    ])  # fmt: skip


def core_arrays(
    structure: Structure, load: Load | Record | None
) -> tuple[_Array, _Array, _Array, float, _Array, _Array, float, _Array]:
    """The arguments of the core for a structure and its load."""
    matrices, directions, values = structure._arrays()
    n = structure.coordinates
    step, record = 0.0, np.zeros((n, 1), order="F")
    if load is None:
        frequency, harmonics, constant = 0.0, np.zeros((n, 2, 0)), np.zeros(n)
    else:
        frequency, harmonics, constant = load._arrays()
    if isinstance(load, Record):
        step, record = load.step, load.force.T
    return matrices, directions, values, frequency, harmonics, constant, step, record


@memory_for("events of a simulation, by max_events")
def simulate_structure(
    structure: Structure,
    load: Load | Record | None = None,
    *,
    cycles: float | None = None,
    duration: float | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    max_events: int = 1_000_000,
    discard: float = 0.0,
) -> StructureTrajectory:
    """Simulate a structure with gaps; no impact is missed, and accumulating impacts are completed.

    Between impacts everything is closed form, mode by mode. The first gap that closes is found by steps that
    bounds on the derivatives prove free of contact. At an impact on gap j the velocities jump by the impulse
    (1 + R) m v along M^-1 G, with v the approach speed and 1/m = G.M^-1 G. `vibroimpact.simulate` calls this
    for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load or Record, optional
        None: free motion. After the last sample of a record the force is 0.
    cycles, duration : float
        How long, in cycles of the load or in time; give one of them. With a record only `duration`, by default to
        the last sample.
    state : (array_like, array_like), optional
        Coordinates and velocities at the start; zero by default.
    start : float
        Time at the start.
    max_events : int
        Events after which the trajectory ends, if there are more (`complete` is then False).
    discard : float
        How long to simulate before what is kept: load cycles if `cycles` is given, else time. The trajectory
        starts that much after `start`; of a record, `duration` is by default what then remains.

    Returns
    -------
    StructureTrajectory

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed. Also if an opening is below a million times the
        rounding error of the displacements, or `max_events` is reached in what is discarded.
    SingularError
        If a gap is less than closed at the start, a mode without damping resonates with the load, two modes
        coincide by damping, or coupled gaps close at one instant. If events came before, the motion up to
        there is the attribute `result` of the error.

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
        if not isinstance(load, Record):
            checks.instance(load, "load", Load)
        if load.coordinates != n:
            raise ParameterError(
                f"load for {load.coordinates} coordinates: must be for {n} as the structure is"
            )
    if isinstance(load, Record) and cycles is None and duration is None:
        begin = [checks.to_float(value, name, "a number") for name, value in
                 (("start", start), ("discard", discard))]  # fmt: skip
        duration = max(0.0, load.duration - sum(begin))
    if (cycles is None) == (duration is None):
        raise ParameterError(
            f"cycles = {cycles!r}, duration = {duration!r}: must be one of them, not both"
        )
    wanted = "a number >= 0"
    discard = checks.to_float(discard, "discard", wanted)
    before = discard
    if duration is None:
        if not isinstance(load, Load) or not load.frequency:
            raise ParameterError(
                f"cycles = {cycles!r}: must be given with a load that has a frequency; give duration without"
            )
        span = checks.number(cycles, "cycles_simulated", "cycles") * 2 * np.pi / load.frequency
        before = discard * 2 * np.pi / load.frequency
    else:
        span = duration = checks.to_float(duration, "duration", wanted)
    if not 0 <= span <= 1e12:
        raise ParameterError(f"duration = {span!r}: must be a number with 0 <= duration <= 1e+12")
    if not 0 <= before <= 1e12:
        raise ParameterError(
            f"discard = {discard!r}: must be a number >= 0, and take at most 1e+12 units of time"
        )
    start = checks.to_float(start, "start", "a number")
    if not 0 <= start <= 1e12:
        raise ParameterError(f"start = {start!r}: must be a number with 0 <= start <= 1e+12")
    max_events = checks.integer(max_events, "max_events", 1, 10**8)
    q, rate = _state(state, n)
    arguments = core_arrays(structure, load)
    first = np.append(q, rate)
    room = min(ROOM // (8 * (2 * n + 3)), max_events)
    while True:
        table = np.empty((2 * n + 3, room), order="F")
        labels = np.empty((2, room), dtype=np.int32, order="F")
        count, kept, final, end, resting, status = _core.simulate_structure(
            *arguments, start, first, start + before, start + before + span, table, labels
        )
        if status not in (MORE_EVENTS, EVENT_LIMIT) or room == max_events:
            break
        room = min(8 * room, max_events)
    failed = status not in (0, MORE_EVENTS)
    if status == EVENT_LIMIT:
        raise ParameterError(
            f"max_events = {max_events}: must be more; it was reached within the discarded time"
        )
    if failed and count == 0:
        if status == NARROW_GAP:
            _refuse_opening(structure, arguments, q)
        if status == GAP_CLOSED:
            apart = [gap.opening - gap.direction @ q for gap in structure.gaps]
            i = int(np.argmin(apart))
            raise SingularError(f"{sentence(status)}: gaps[{i}] is {apart[i]:.6g}, must be >= 0")
        structure._raise_status(status)
    events = new_events(count)
    events["time"], events["speed"], events["impulse"] = table[:3, :count]
    events["kind"] = KINDS[labels[0, :count] - 1]
    events["gap"] = labels[1, :count] - 1
    states = table[3:, :count].T
    if 2 * count < room:
        states = np.ascontiguousarray(states)  # else most of the table stays in memory
    states = states.reshape(count, 2, n)
    for array in (events, states, kept, final):
        array.flags.writeable = False
    lasting = {"duration": duration} if cycles is None else {"cycles": float(cycles)}
    request = lasting | ({"discard": discard} if discard else {}) | {
        "q": q.tolist(), "q_dot": rate.tolist(), "start": start, "max_events": max_events,
    }  # fmt: skip
    run = StructureTrajectory(
        structure,
        load,
        start + before,
        end,
        events,
        states,
        (kept[:n], kept[n:]),
        (final[:n], final[n:]),
        status == 0,
        request,
        sentence(status) if failed else "",
        tuple(np.flatnonzero(resting[: len(structure.gaps)]).tolist()),
    )
    if failed:
        error = SingularError(
            f"{sentence(status)}; the motion up to t = {end:g} is the attribute `result` of this error"
        )
        error.result = run
        raise error
    return run


def _refuse_opening(structure: Structure, arguments: tuple[Any, ...], q: _Array) -> NoReturn:
    """ParameterError for the gap that is too narrow for a simulation from a state."""
    matrices, directions, values, frequency, harmonics, constant = arguments[:6]
    number, least = _core.narrow_gap(
        matrices, directions, values, frequency, harmonics, constant, q
    )
    gap = structure.gaps[number - 1]
    wanted = f"at least {1.06 * least:.1e}, a million times the rounding error of the displacements"
    for i, other in enumerate(structure.gaps):
        if (other.direction == -gap.direction).all():
            total = gap.opening + other.opening
            raise ParameterError(
                f"gaps[{number - 1}].opening + gaps[{i}].opening = {total!r}: must be {wanted}"
            )
    raise ParameterError(f"gaps[{number - 1}].opening = {gap.opening!r}: must be 0 or {wanted}")


def _state(state: Any, n: int) -> tuple[_Array, _Array]:
    """Coordinates and velocities of an initial state."""
    wanted = f"two lists of {n} finite numbers {SPAN}, coordinates and velocities"
    if state is None:
        return np.zeros(n), np.zeros(n)
    try:
        q, rate = state
    except (TypeError, ValueError):
        raise ParameterError(f"state = {state!r}: must be {wanted}") from None
    parts = []
    for values in (q, rate):
        array = np.array(checks.real_array(values, "state", wanted), dtype=np.float64)
        if array.shape != (n,) or not (np.abs(array) <= MOST).all():
            raise ParameterError(f"state = {state!r}: must be {wanted}")
        array.flags.writeable = False
        parts.append(array)
    return parts[0], parts[1]
