"""Simulated trajectories with every impact, accumulation and rest."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, NoReturn, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.actions import ACTIONS
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from ..base.interrupt import with_stack
from ..base.progress import reported
from ..base.sizes import memory_for
from ..base.status import EVENT_LIMIT, GAP_CLOSED, MORE_EVENTS, NARROW_GAP, raise_status, sentence
from ..results import namelist
from ..results.events import (
    EVENT_TYPE,
    WORDS,
    event_arrays,
    event_columns,
    events_of,
    sample,
    segments,
)
from ..results.gradient import Gradient
from ..results.noun import Noun, Solution
from ..results.parameters import Wanted
from ..results.states import (
    NEEDED,
    Moment,
    State,
    System,
    as_numbers,
    coordinates_of,
    later,
    moments_of,
    start_of,
    state_by_coordinates,
    state_of,
)
from ..results.systems import (
    check_gap_numbers,
    osc_of,
    structure_of,
    structure_tables,
    units_of,
    with_owners,
)
from ..results.tables import Result, made
from ..systems.oscillator import Oscillator, Pattern, Point, of_numbers
from ..systems.record import Record
from ..systems.structure import Gap, Load, Structure, check_load, moves, opening_at, without_none
from ..systems.units import (
    argument,
    has_unit,
    place_text,
    range_text,
    shown_as_given,
    time_of,
    value_text,
)
from ..systems.verbs import every_system, physical_arguments
from .quantities import Quantities, oscillator_quantities, structure_quantities

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Period", "State", "Trajectory", "simulate"]

_Array = NDArray[np.float64]

#: The moments of a trajectory in the core's table, and the keys of a &simulate: for an oscillator, and for a
#: structure.
MOMENTS = ("initial", "initial flight", "final", "final flight")
REQUEST = ("clearance", "cycles", "discard", "load", *NEEDED, "max_events")
REQUEST_OF_STRUCTURE = ("duration", "cycles", "discard", "q", "q_dot", "start", "max_events")
#: The note on a trajectory that reached the limit on events.
FULL = "max_events was reached"
#: Largest numbers of events and of load cycles in a call of the core; Ctrl-C takes effect between calls.
CHUNK, SPAN = 65_536, 1_000_000
#: Bytes initially reserved for events of a structure; unused ones take no memory. If there are more events, the
#: simulation is repeated.
ROOM = 2**26
#: Names of the kinds of events 1 to 10, and the columns of the events of a structure.
KINDS = np.array([
    "impact", "stick", "release", "touch", "leave", "let_go", "press", "halt", "slip_up", "slip_down",
])  # fmt: skip
EVENTS_OF_STRUCTURE = np.dtype([
    ("time", "f8"), ("kind", "U9"), ("gap", "i4"), ("speed", "f8"), ("impulse", "f8"),
])  # fmt: skip
#: Load phase of a load cycle.
TURN = 2 * np.pi
#: Largest number of events of a trajectory, as in the core: 88 bytes each.
MOST_KEPT = 50_000_000
#: Number of load cycles above which a simulation shows a bar.
MANY_CYCLES = 10_000
#: Longest period in load cycles, and largest difference of its phases from those of the previous period.
MOST_CYCLES, TOLERANCE = 16, 0.05


class Period(NamedTuple):
    """The period of the motion at the end of a trajectory.

    Attributes
    ----------
    pattern : Pattern
    events : structured ndarray
        The event that begins each letter of the pattern, with the columns of `Trajectory.events`: an impact, or
        the first impact of an accumulation.
    mismatch : float
        Largest difference of their phases from those of the previous period (radians).
    """

    pattern: Pattern
    events: NDArray[Any]
    mismatch: float

    def __repr__(self) -> str:
        """A single line, without the table of events."""
        return f"<Period {self.pattern.sides}/{self.pattern.cycles}, phases repeat within {self.mismatch:.2g}>"


def refuse_output(output: Any) -> None:
    """Raises an error if an output of an oscillator is requested, which has none."""
    if output is not None:
        raise ParameterError(f"output = {output!r}: must be left out for an Oscillator")


def _states(run: Trajectory) -> _Array:
    """The coordinates and velocities of both masses just after each event."""
    events = run.events
    z = events["x"] + 0.5 * run.clearance * np.where(events["side"] == "R", 1, -1)
    return np.stack([events["x"], z, events["x_dot_after"], events["z_dot_after"]], 1).reshape(
        -1, 2, 2
    )


class Trajectory(Solution, study="simulate", formerly="StructureTrajectory"):
    """A simulated trajectory.

    For an oscillator, lengths are in F0/K (or any unit, if `load` is not 1) and times in 1/omega; for a structure,
    everything is in the user's units.

    Attributes
    ----------
    events : structured ndarray
        In order of time: ``time`` and ``kind``, which is "impact", "stick" where accumulating impacts end in rest,
        or "release" where the rest ends. For an oscillator also ``side`` ("R" or "L"), ``phase`` (of the load, in
        [0, 2 pi)), ``x``, ``x_dot_before``, ``x_dot_after``, ``z_dot_before``, ``z_dot_after``; for a structure
        ``gap`` (from 0), ``speed`` (approach speed) and ``impulse``. Kinds of a stop are "touch" and "leave" and,
        for a stop that cannot pull, "let_go" (its force vanishes at a depth) and "press" (it pushes again); their
        ``speed`` is that at which the gap closes or opens. Kinds of friction, whose numbers follow those of all
        gaps and stops, are "halt" (it sticks), "slip_up" and "slip_down" (it begins to slip with s > 0 or s < 0).
    states : ndarray (events, 2, n)
        Coordinates and velocities just after each event; for an oscillator those of its two masses.
    start, end : float
        Start and end times of the part that is kept.
    initial_state, final_state
        States at both ends: mappings for an oscillator, (coordinates, velocities) for a structure. A simulation
        from the final state of an oscillator continues the trajectory bit for bit.
    load : float, Load, Record or None
        The amplitude of the load of an oscillator; the load of a structure.
    complete : bool
        False if the simulation had more than `max_events` events, or if it was interrupted; `end` is then the time
        of the last event.
    request : dict or None
        The case as the keys of a &simulate; None if a namelist cannot express it (see `to_namelist`).
    cut : str
        How far the simulation got, if it was interrupted.
    osc : Oscillator
    r, clearance : float
        For an oscillator: frequency ratio and clearance.
    structure : Structure
    permanent : tuple of int
        For a structure: gaps that rest from `start` to `end`, and therefore have no events.
    """

    __slots__ = (
        "clearance", "complete", "cut", "end", "events", "final_state", "initial_state", "load", "osc",
        "permanent", "r", "request", "start", "states", "structure",
    )  # fmt: skip
    _derived: ClassVar = {
        "start": lambda self: self.initial_state["t"], "end": lambda self: self.final_state["t"],
        "states": _states,
    }  # fmt: skip
    _instead = (
        {"structure": "osc", "permanent": "initial_state"},
        {"osc": "structure and load", "r": "load.frequency", "clearance": "structure.gaps"},
    )

    events: NDArray[Any]
    states: _Array
    start: float
    end: float
    initial_state: Any
    final_state: Any
    load: Any
    complete: bool
    request: dict[str, Any] | None
    cut: str
    osc: Oscillator
    r: float
    clearance: float
    structure: Structure
    permanent: tuple[int, ...]

    @memory_for("a sample at the times t")
    def sample(self, t: ArrayLike, output: str | None = None) -> Any:
        """The positions and velocities at times within the trajectory, from the closed form.

        Parameters
        ----------
        t : array_like
            Times from `start` to `end`, in any order; for a structure, a one-dimensional array (m,). For an
            oscillator whose M and K are known, also at a point with friction or stops, times may have units, such
            as ["0.1 s", "0.2 s"]. At the time of an event velocities and accelerations are those just after it.
        output : str, optional
            For a structure: the output to sample, in place of all coordinates.

        Returns
        -------
        Sample, or (q, q_dot) of a structure
            For an oscillator as in `Motion.sample`; for a structure coordinates and velocities (n, m), or
            displacement and velocity of the output (m,).

        Raises
        ------
        ParameterError
            If a time is outside the trajectory, or there is no such output.

        Examples
        --------
        >>> import numpy as np, vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> run = vi.simulate(osc, r=1.04, clearance=25.0, cycles=50)
        >>> history = run.sample(np.linspace(0, run.end, 1000))
        >>> bool(np.all(abs(history.Y) <= 12.5 + 1e-12))
        True
        """
        if self.of_structure:
            q, rate = self._sampled(t, 2, output)
            return q, rate
        refuse_output(output)
        times = checks.real_array(argument(self.osc, t, "t", "1/omega"), "t", "real times")
        first, last = self.start, self.end
        if times.size and not (first <= times.min() and times.max() <= last):
            osc = self.osc if has_unit(t) else None  # as the times were given
            raise ParameterError(
                f"t from {range_text(osc, 't', times.min(), times.max())}: must be within the trajectory, "
                f"{range_text(osc, 't', first, last)}"
            )
        starts, resting = self._segments()
        return sample(self.osc, self.r, self.load, self.clearance, starts, resting, times)

    def _sampled(self, t: ArrayLike, parts: int, output: str | None = None) -> _Array:
        """For a structure: coordinates, velocities and, with three `parts`, accelerations (parts, n, m); for an
        output (parts, m)."""
        row = None if output is None else self.structure._row(output)
        wanted = f"times from {self.start!r} to {self.end!r}"
        times = np.atleast_1d(checks.real_array(time_of(self.structure, t, "t"), "t", wanted))
        inside = (times >= self.start) & (times <= self.end)
        if times.ndim != 1 or not inside.all():
            with shown_as_given([(t, times)]):
                raise ParameterError(f"t = {times[~inside][:3].tolist()!r}: must be {wanted}")
        order = np.argsort(times, kind="stable")
        values, status = _core.sample_structure(
            *core_arrays(self.structure, self.load, True), *self._segments(), times[order], parts
        )
        raise_status(status)
        found = np.empty(values.shape)
        found[:, order] = values
        shaped: _Array = found.reshape(parts, self.structure.coordinates, len(times))
        return shaped if row is None else np.einsum("i,pim->pm", row, shaped)

    def _resting(self) -> tuple[int, ...]:
        """The gaps of a structure that rest from the start."""
        rests, status = _core.resting_at_start(
            *core_arrays(self.structure, self.load, True), np.append(self.start, self.initial_state)
        )
        raise_status(status)
        return tuple(np.flatnonzero(rests).tolist())

    @memory_for("a sample at the times t")
    def acceleration(self, t: ArrayLike, output: str | None = None) -> _Array:
        """The accelerations at given times between the impacts, at which velocities jump.

        Parameters
        ----------
        t : array_like (m,)
            As in `sample`. At the time of an event the accelerations are those just after it.
        output : str, optional
            As in `sample`.

        Returns
        -------
        ndarray (n, m)
            Accelerations; for an oscillator, of its two masses; (m,) for an output.

        Raises
        ------
        ParameterError
            If a time is outside the trajectory.
        """
        if self.of_structure:
            return np.asarray(self._sampled(t, 3, output)[2])
        refuse_output(output)
        found = self.sample(t)
        return np.array([found.X_ddot, found.Z_ddot])

    @memory_for("quantities, by their window and harmonics")
    def quantities(
        self, cycles: float | None = None, harmonics: int = 10, window: ArrayLike | None = None
    ) -> Quantities:
        """Response quantities over a window of time: rms, extremes and harmonics, impacts and energies.

        Parameters
        ----------
        cycles : float, optional
            Load cycles of the window, which ends with the trajectory.
        harmonics : int
            Harmonics of the load, 1 to 10000; there are none if the load has no frequency. They are those of a
            periodic response only if the response is periodic and the window is a whole number of periods.
        window : (float, float), optional
            Start and end of the window, in place of `cycles`; without either, the whole trajectory.

        Returns
        -------
        Quantities
            Their values over the window.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed, or the window is too long for this structure.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
        >>> run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=4, discard=300)
        >>> found = run.quantities(cycles=2)
        >>> balance = found.work - found.damping_loss - found.impact_loss - found.energy_change
        >>> abs(balance) < 1e-10 * found.work
        True
        """
        first, end = self._times(cycles, window)
        if self.of_structure:
            return structure_quantities(
                self,
                core_arrays(self.structure, self.load, True),
                self._segments(),
                (first, end),
                harmonics,
            )
        starts, resting = self._segments()
        return oscillator_quantities(
            self.osc, self.r, self.load, self.clearance, starts, resting, (first, end),
            self.events[(self.events["time"] > first) & (self.events["time"] <= end)], harmonics,
        )  # fmt: skip

    def _between_events(self) -> tuple[float, tuple[_Array, _Array]]:
        """For a structure: a time in the middle of the longest flight, in which nothing rests if possible, and
        the state there."""
        times = np.concatenate([[self.start], self.events["time"], [self.end]])
        kinds = self.events["kind"]
        changes = np.select([kinds == "stick", kinds == "release"], [1, -1], 0)
        resting = np.cumsum(np.append(len(self._resting()), changes)) > 0
        longest = int((np.diff(times) * np.where(resting & ~resting.all(), 0.0, 1.0)).argmax())
        middle = float(times[longest : longest + 2].mean())
        q, rate = self.sample([middle])
        return middle, (q[:, 0], rate[:, 0])

    def _times(self, cycles: float | None, window: ArrayLike | None) -> tuple[float, float]:
        """The ends of a window of time: the last load cycles, or two times; all of it by default."""
        if window is not None:
            wanted = f"two increasing times from {self.start!r} to {self.end!r}"
            if cycles is not None:
                raise ParameterError(f"window = {window!r}: must be left out with cycles")
            given, window = window, time_of(self._system, window, "window")
            times = np.atleast_1d(checks.real_array(window, "window", wanted))
            if times.shape != (2,) or not self.start <= times[0] < times[1] <= self.end:
                with shown_as_given([(given, window)]):
                    raise ParameterError(f"window = {window!r}: must be {wanted}")
            return float(times[0]), float(times[1])
        if cycles is None:
            return self.start, self.end
        frequency = getattr(self.load, "frequency", None) if self.of_structure else self.r
        if not frequency:
            raise ParameterError(
                f"cycles = {cycles!r}: must be left out without a frequency; give window"
            )
        turn = TURN / frequency
        wanted = (
            f"load cycles of the trajectory, > 0 and at most {(self.end - self.start) / turn:.10g}"
        )
        cycles = checks.to_float(cycles, "cycles", wanted)
        begin = self.end - cycles * turn
        if not (cycles > 0 and begin >= self.start - 1e-9 * turn):
            raise ParameterError(f"cycles = {cycles!r}: must be {wanted}")
        return max(self.start, begin), self.end

    def period(self, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE) -> Period:
        """The shortest period of the motion at the end of the trajectory (oscillators only).

        The last load cycles repeat the pattern of the same number of cycles before them, at phases within the
        tolerance. This does not prove that the motion is periodic; `exact` computes the periodic motion.

        Parameters
        ----------
        most_cycles : int
            Load cycles of the longest period considered.
        tolerance : float
            Largest difference of the phases (radians).

        Returns
        -------
        Period
            The pattern, the events, and how accurately the motion repeats.

        Raises
        ------
        ParameterError
            If the last load cycles have no impacts, or do not repeat.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
        >>> run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=4, discard=300)
        >>> period = run.period()
        >>> period.pattern, period.mismatch < 1e-6
        (Pattern(sides='RL*', cycles=1), True)
        """
        if self.of_structure:
            raise AttributeError(self._lack("period", "exact(structure, load, trajectory)"))
        return last_period(self, most_cycles, tolerance)

    def gradient(self, parameters: Sequence[Wanted] | None = None) -> Gradient:
        """The derivatives of all events and the final state with respect to the initial state and parameters.

        The derivatives are carried through impacts, accumulations, rests and releases in closed form (saltation).
        For an oscillator the quantities are ``time``, ``x``, ``x_dot_before``, ``x_dot_after``, ``z_dot_before``
        and ``z_dot_after`` of the events, and ``final_t``, ``final_x``, ``final_x_dot``, ``final_z`` and
        ``final_z_dot``; for a structure ``time``, ``speed``, ``impulse``, ``q`` and ``q_dot`` (just after the
        event) of the events, and ``final_time``, ``final_q`` and ``final_q_dot``. The number of load cycles, or
        the duration, is fixed, and so is the initial state when another parameter changes. The final time
        therefore changes with the frequency.

        Parameters
        ----------
        parameters : sequence, optional
            For a structure: names or tuples as in `Motion.gradient`, and for the initial state: 'start' (its time,
            for a fixed state), 'q_I' and 'q_dot_I'. For a record, 'load' is a factor. By default all parameters of
            the initial state, frequency, load, and all openings and coefficients of restitution. For an
            oscillator, the parameters are always t, x, x_dot, z and z_dot of the initial state, and r, clearance,
            xi, mu, R1, R2, R (both walls) and load.

        Returns
        -------
        Gradient
            Entries are NaN from the first event without derivatives: an impact without approach speed, or a rest
            that ends without its contact force falling through 0; `status` names it. If a gap rests at the start,
            derivatives with respect to quantities that would open it or close it further are NaN; for an
            oscillator these are z and z_dot, and derivatives with respect to the other components move both
            masses.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a parameter does not exist, or the trajectory is not complete, or has more than a million events.
        SingularError
            If the events do not belong to the structure, or gaps that depend on each other rest.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> start = dict(t=0.0, x=0.0, x_dot=1.0, z=0.0, z_dot=3.0)
        >>> gradient = vi.simulate(osc, r=1.04, clearance=25.0, cycles=5, state=start).gradient()
        >>> gradient["final_x", "z_dot"].shape, gradient["time"].shape[1] == len(gradient.parameters)
        ((), True)

        A mass that starts towards a wall: its position after the impact decreases by R times the increase of its
        initial position.

        >>> wall = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=[vi.Gap([1], 1, 0.8)])
        >>> run = vi.simulate(wall, duration=3, state=([0], [1]))
        >>> run.gradient()["final_q", "q_0"].round(12).tolist()
        [-0.8]
        """
        found: Gradient
        if self.of_structure:
            found = ACTIONS["structure_trajectory_gradient"](self, parameters)
            return found
        if parameters is not None:
            raise ParameterTypeError(
                f"parameters = {parameters!r}: must be left out for an oscillator, whose parameters are all taken"
            )
        found = ACTIONS["trajectory_gradient"](self)
        return found

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` compute the same digits.

        Returns
        -------
        str
            The groups &system and &simulate, or those of a structure.
        """
        if self.request is None:
            reason = "it began with the final state of another trajectory"
            if self.of_structure:
                reason = "it was read from a file without one"
            raise ParameterError(f"{self!r}: has no namelist, since {reason}")
        if self.of_structure:
            load = [] if self.load is None else self.load._groups()
            return namelist.text([*self.structure._groups(), *load, ("simulate", self.request)])
        return namelist.case(self.osc, self.r, simulate=self.request)

    @property
    def _result(self) -> Result:
        """The tables of the trajectory, with the columns that the core declares for &simulate."""
        cut = "" if self.complete else self.cut or FULL
        writable = self.request is not None and not (
            self.of_structure and not self.structure._parts
        )
        case = self.to_namelist() if writable else ""
        if self.of_structure:
            remarks = (f"final time: {namelist.digits(self.end)}",)
            tables = self._tables_of_structure()
            return with_owners(self.structure, made("simulate", case, tables, remarks, cut))
        right, left = self.osc.restitution
        ends = (self.initial_state, self.final_state)
        moments = [moment for state in ends for moment in moments_of(state)]
        final = [float(self.final_state[name]) for name in NEEDED]
        tables = {
            "final": ((), {"state": final}),
            "run": ((), {
                "xi": self.osc.xi, "mu": self.osc.mu, "R1": right, "R2": left, **units_of(self.osc),
                "r": self.r, "clearance": self.clearance, "load": self.load, "finished": self.complete,
            }),
            "moments": (("moment",), {
                "moment": MOMENTS, "quantities": [numbers for numbers, _ in moments],
                "contact": [flags for _, flags in moments],
            }),
            "events": (("event",), event_columns(self.events)),
        }  # fmt: skip
        state = f"final state: t, x, x_dot, z, z_dot = {', '.join(map(namelist.digits, final))}"
        return made("simulate", case, tables, (state,), cut)

    def _tables_of_structure(self) -> dict[str, Any]:
        s, load = self.structure, self.load
        record = load if isinstance(load, Record) else None
        moments = (self.initial_state, self.final_state)
        columns = {name: self.events[name] for name in EVENTS_OF_STRUCTURE.names or ()}
        if s.outputs:
            rows = np.array([*s.outputs.values()]).T
            columns |= {
                "outputs": self.states[:, 0] @ rows, "output_rates": self.states[:, 1] @ rows
            }  # fmt: skip
        return {
            "events": (("event",), columns | {"q": self.states[:, 0], "q_dot": self.states[:, 1]}),
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

    @classmethod
    def of_result(cls, result: Result) -> Trajectory:
        """The trajectory from the tables of the core.

        Parameters
        ----------
        result : Result
            The tables that the core or a file provides.

        Returns
        -------
        Trajectory
            The trajectory with its events.
        """
        if result.of_structure:
            return cls._of_structure(result)
        one = {
            name: result.column("run", name).values.item()
            for name in ("r", "clearance", "load", "finished")
        }
        osc = osc_of(result, "run")
        system = (osc.xi, osc.mu, osc.restitution, one["r"], one["load"], one["clearance"])
        numbers, flags = (
            result.column("moments", name).values for name in ("quantities", "contact")
        )
        if (numbers.shape, flags.shape) != ((4, 7), (4, 3)):
            raise ParameterError(
                f"moments of shapes {numbers.shape}, {flags.shape}: must be (4, 7), (4, 3)"
            )
        if not np.isfinite(numbers[::2, :6]).all():
            raise ParameterError(
                f"moments.quantities = {numbers[::2, :6].tolist()}: must be finite at the start and at the end"
            )
        start, begun, end, last = zip(numbers, flags, strict=True)
        request = None
        if result.case:
            keys = namelist.keys_of(result.case)
            missing = [name for name in REQUEST if name not in keys]
            if missing:
                raise ParameterError(f"case: must have the keys of a &simulate; missing: {missing}")
            request = {name: keys[name] for name in REQUEST}
        return cls(
            osc=osc, r=one["r"], clearance=one["clearance"], load=one["load"], events=events_of(result),
            initial_state=state_of(system, start, begun), final_state=state_of(system, end, last),
            complete=bool(one["finished"]), request=request, cut="" if result.cut == FULL else result.cut,
        )  # fmt: skip

    @classmethod
    def _of_structure(cls, result: Result) -> Trajectory:
        """As `of_result`, for a structure."""

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
        events = np.zeros(len(columns[0]), EVENTS_OF_STRUCTURE)
        for name, column in zip(EVENTS_OF_STRUCTURE.names or (), columns, strict=True):
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
        request = request_of(result, "simulate", REQUEST_OF_STRUCTURE, {"q", "q_dot"})
        # files of earlier versions have no such table
        kept = result.column("rests", "gap").values.tolist() if "rests" in result.tables else []
        return cls(
            structure=structure, load=load, start=float(start), end=float(end), events=events, states=states,
            initial_state=(q[0], rate[0]), final_state=(q[1], rate[1]), complete=bool(finished),
            request=request, cut="" if result.cut == FULL else result.cut, permanent=tuple(map(int, kept)),
        )  # fmt: skip

    def plot(
        self, ax: Any = None, kind: str | None = None, cycles: float | None = None,
        window: ArrayLike | None = None,
        units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Draw the trajectory, or one panel of its figure (extra `plot`).

        The panels for an oscillator are time history, load, acceleration and phase portrait; for a structure, a
        sketch, the histories of its bodies, its impacts, and the energy of its modes.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for one panel; without it, a figure with all panels is made.
        kind : str, optional
            Which panel: "history", "load", "acceleration" or "portrait"; for a structure "sketch", "history",
            "impacts" or "energy". "history" if only `ax` is given.
        cycles : float, optional
            The number of last load cycles shown; 3 by default for an oscillator.
        window : (float, float), optional
            Start and end of the time window drawn, in place of `cycles`; for a structure, by default everything.
        units : Units or str, optional
            For an oscillator: units such as "mm N s", or "dimensionless"; by default those of the oscillator, if
            its M, K and F0 are known. In physical units, the time axis begins at 0.

        Returns
        -------
        Axes, or an array of Axes
            The Axes of the panel, or of all panels.
        """
        return self._draw(ax, kind, *self._shown(cycles, window), units=units)

    def animate(
        self, path: str | os.PathLike[str] | None = None, cycles: float | None = None,
        seconds: float | None = None, window: ArrayLike | None = None,
        units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Animate the trajectory; a wall or gap flashes when it is hit, and is green during a rest (extra `plot`).

        Parameters
        ----------
        path : str or path, optional
            As in `Motion.animate`.
        cycles : float, optional
            As in `plot`.
        seconds : float, optional
            For an oscillator: duration of a load cycle on the screen, 3 by default. For a structure: duration of
            the whole animation, 10 by default.
        window : (float, float), optional
            As in `plot`.
        units : Units or str, optional
            As in `plot`.

        Returns
        -------
        Path
            The path of the file; without `path`, matplotlib's FuncAnimation, as in `Motion.animate`.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
        >>> run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=4, discard=300)
        >>> run.animate("rest.gif", cycles=1, seconds=0.3).name
        'rest.gif'
        """
        if seconds is None:
            seconds = 10.0 if self.of_structure else 3.0
        return self._animate(path, *self._shown(cycles, window), seconds, units=units)

    def _in(self, units: Units) -> Trajectory:
        """The trajectory of a structure of an oscillator in physical units."""
        events = self.events.copy()
        for name, unit in {"time": "1/omega", "speed": "omega F0/K", "impulse": "F0/omega"}.items():
            events[name] *= units.scale(unit)
        ends = {
            name: (q * units.length, rate * units.velocity)
            for name in ("initial_state", "final_state") for q, rate in [getattr(self, name)]
        }  # fmt: skip
        return self.__replace__(
            structure=self.structure._in(units), load=None if self.load is None else self.load._in(units),
            start=self.start * units.time, end=self.end * units.time, events=events,
            states=states_in(self.states, units), request=request_in(self.request, units), **ends,
        )  # fmt: skip

    def _shown(
        self, cycles: float | None, window: ArrayLike | None
    ) -> tuple[float, tuple[float, float] | None]:
        """The shown part as arguments of pictures: load cycles of an oscillator, or a window."""
        if self.of_structure or window is not None:
            return 3.0, self._times(cycles, window)
        return 3.0 if cycles is None else cycles, None

    def _segments(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """State at the start of each segment (6, n), and the side on which the free mass rests in it; for a
        structure in the form of the core's arguments."""
        if self.of_structure:
            return segments_of_events(self.start, self.initial_state, self.events, self.states)
        state = self.initial_state
        first = np.array([[state[name] for name in ("t", "phase", "x", "x_dot", "z", "z_dot")]]).T
        starts, resting = segments(self.events, self.clearance)
        side = int(state["side"]) if state["resting"] else 0
        return np.hstack([first, starts]), np.concatenate(
            [np.array([side], dtype=np.int32), resting]
        )

    def _facts(self) -> dict[str, str]:
        if not self.of_structure:
            return {}
        n, gaps = self.structure.coordinates, len(self.structure.gaps)
        return {"coordinates": str(n), "gaps": str(gaps), "events": str(len(self.events))}

    def __repr__(self) -> str:
        n, m = (int((self.events["kind"] == kind).sum()) for kind in ("impact", "stick"))
        impacts = f"{n} impact{'s' * (n != 1)}"
        rests = f", {m} rest{'s' * (m != 1)}" if m else ""
        touches = int((self.events["kind"] == "touch").sum())
        rests += f", {touches} contact{'s' * (touches != 1)} with stops" if touches else ""
        halts = int((self.events["kind"] == "halt").sum())
        rests += f", {halts} halt{'s' * (halts != 1)}" if halts else ""
        place = ""
        if self.of_structure:
            rests += "".join(f", gap {gap} rests all the time" for gap in self.permanent)
        else:
            place = f"at {place_text(self.osc, self.r, self.clearance)}, "
            if self.initial_state["resting"] and not (self.events["kind"] == "release").any():
                # this rest began before the first event, so no event shows it
                wall = "R" if self.initial_state["side"] > 0 else "L"
                rests += f", m rests on {wall} all the time"
        cut = "" if self.complete else f"; cut short, {self.cut or FULL}"
        span = range_text(self._system, "t", self.start, self.end)
        return f"<Trajectory {place}t = {span}: {impacts}{rests}{cut}>"


def states_in(states: _Array, units: Units) -> _Array:
    """Dimensionless states (N, 2, n) in physical units."""
    scaled: _Array = states * np.array([units.length, units.velocity])[:, None]
    return scaled


def request_in(request: dict[str, Any] | None, units: Units) -> dict[str, Any] | None:
    """The keys of a &simulate or &motion of a dimensionless structure, for the structure in physical units."""
    if request is None:
        return None
    scales = {"q": units.length, "q_dot": units.velocity} | dict.fromkeys(
        ("start", "duration", "period"), units.time
    )
    if request.get("cycles") is None:
        scales["discard"] = units.time
    return {
        name: value if value is None or name not in scales else (np.array(value) * scales[name]).tolist()
        for name, value in request.items()
    }  # fmt: skip


def request_of(
    result: Result, group: str, names: Sequence[str], lists: set[str]
) -> dict[str, Any] | None:
    """The keys of the study in the case of a result, some of which are lists; None without a case."""
    if not result.case:
        return None
    *_, (last, keys) = [item for item in namelist.parts_of(result.case) if item[0] != "output"]
    if last != group:
        raise ParameterError(f"case: must end with a &{group}")
    request = {name: keys[name] for name in names if name in keys}
    return request | {name: np.atleast_1d(request[name]).tolist() for name in lists & set(request)}


class Simulation(Noun, study="simulate", formerly="StructureSimulation"):
    """The result of a &simulate case: its trajectory, unless the simulation failed."""

    __slots__ = ()

    def parts(self) -> list[Trajectory]:
        """The trajectory."""
        return [] if self._result.empty else [Trajectory.of_result(self._result)]

    def require(self) -> None:
        """SingularError if the simulation failed."""
        if self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def __repr__(self) -> str:
        return f"<Simulation: {', '.join(map(repr, self.parts())) or 'none'}>"


def check_times(times: _Array, start: float, end: float) -> None:
    """Raises an error unless the events of a trajectory are in order between its ends."""
    if not (np.isfinite([start, end]).all() and start <= end):
        raise ParameterError(f"moments.time = {start!r}, {end!r}: must be finite, and in order")
    apart = np.diff(np.concatenate([[start], times, [end]]))
    if not (apart >= 0).all():
        i = min(int(np.argmin(apart >= 0)), len(times) - 1)
        raise ParameterError(
            f"events.time[{i}] = {times[i]!r}: must be in ascending order from {start!r} to {end!r}"
        )


def segments_of_events(
    start: float, first: Sequence[_Array], events: NDArray[Any], states: _Array
) -> tuple[_Array, NDArray[np.int32]]:
    """The segments that begin at the start and just after each event, as arguments of the core.

    They contain time, coordinates and velocities (1 + 2n, segments), and kind and gap (2, segments).
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


def core_arrays(
    structure: Structure, load: Load | Record | None, stops: bool = False
) -> tuple[_Array, _Array, _Array, float, _Array, _Array, float, _Array]:
    """The arguments of the core for a structure and its load; stops are rejected unless they are allowed."""
    if not stops:
        structure._rigid()
    matrices, directions, values = structure._arrays()
    n = structure.coordinates
    step, record = 0.0, np.zeros((n, 1), order="F")
    if load is None:
        frequency, harmonics, constant = 0.0, np.zeros((n, 2, 0)), np.zeros(n)
    else:
        frequency, harmonics, constant = load._arrays()
        if structure._moves and isinstance(load, Load):
            frequency = load.frequency
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
) -> Trajectory:
    """As `simulate`, for a structure."""
    check_load(structure, load, kinds=(Load, Record, type(None)), stops=True)
    load = without_none(load)
    n = structure.coordinates
    if isinstance(load, Record) and cycles is None and duration is None:
        begin = [checks.to_float(value, name, "a number") for name, value in
                 (("start", start), ("discard", discard))]  # fmt: skip
        duration = max(0.0, load.duration - sum(begin))
    if (cycles is None) == (duration is None):
        raise ParameterError(
            f"cycles = {cycles!r}, duration = {duration!r}: exactly one must be given"
        )
    wanted = "a number >= 0"
    of_cycles = "a number of load cycles >= 0"
    discard = checks.to_float(discard, "discard", wanted if cycles is None else of_cycles)
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
    q, rate = coordinates_of(state, n)
    arguments = core_arrays(structure, load, True)
    first = np.append(q, rate)
    room = min(ROOM // (8 * (2 * n + 3)), max_events)
    while True:
        table = np.empty((2 * n + 3, room), order="F")
        labels = np.empty((2, room), dtype=np.int32, order="F")
        count, kept, final, end, resting, status = with_stack(
            _core.simulate_structure, *arguments, start, first, start + before, start + before + span,
            table, labels,
        )  # fmt: skip
        if status not in (MORE_EVENTS, EVENT_LIMIT) or room == max_events:
            break
        room = min(8 * room, max_events)
    failed = status not in (0, MORE_EVENTS)
    if status == EVENT_LIMIT:
        raise ParameterError(
            f"max_events = {max_events}: must be larger; it was reached within the discarded time"
        )
    if failed and count == 0:
        if status == NARROW_GAP:
            _refuse_opening(structure, arguments, q)
        if status == GAP_CLOSED:
            frequency = getattr(load, "frequency", 0.0)
            apart = [
                float(opening_at(gap, start, frequency) - gap.direction @ q)
                if isinstance(gap, Gap)
                else math.inf
                for gap in structure.gaps
            ]
            i = int(np.argmin(apart))
            opening = value_text(structure, "opening", apart[i])
            raise SingularError("; ".join(filter(None, [
                f"{sentence(status)}: gaps[{i}] is {opening}, must be >= 0", _overlap(structure, np.zeros(1)),
            ])))  # fmt: skip
        structure._raise_status(status)
    events = np.zeros(count, EVENTS_OF_STRUCTURE)
    events["time"], events["speed"], events["impulse"] = table[:3, :count]
    events["kind"] = KINDS[labels[0, :count] - 1]
    events["gap"] = labels[1, :count] - 1
    states = table[3:, :count].T
    if 2 * count < room:
        states = np.ascontiguousarray(states)  # otherwise most of the table stays in memory
    states = states.reshape(count, 2, n)
    for array in (events, states, kept, final):
        array.flags.writeable = False
    lasting = {"duration": duration} if cycles is None else {"cycles": float(cycles)}
    request = lasting | ({"discard": discard} if discard else {}) | {
        "q": q.tolist(), "q_dot": rate.tolist(), "start": start, "max_events": max_events,
    }  # fmt: skip
    run = Trajectory(
        structure=structure, load=load, start=start + before, end=end, events=events, states=states,
        initial_state=(kept[:n], kept[n:]), final_state=(final[:n], final[n:]), complete=status == 0,
        request=request, cut=sentence(status) if failed else "",
        permanent=tuple(np.flatnonzero(resting[: len(structure.gaps)]).tolist()),
    )  # fmt: skip
    if failed:
        # walls with too little space between them
        whole = np.linspace(0, 2 * np.pi, 361)
        why = (structure._moves and _overlap(structure, whole)) or sentence(status)
        error = SingularError(
            f"{why}; the motion up to t = {end:g} is the attribute `result` of this error"
        )
        error.result = run
        raise error
    return run


def _overlap(structure: Structure, angles: _Array) -> str:
    """Which two gaps face each other and leave no space between them at some load phases, in words."""
    rigid = [(i, gap) for i, gap in enumerate(structure.gaps) if isinstance(gap, Gap)]
    for i, gap in rigid:
        for j, other in rigid[i + 1 :]:
            both = opening_at(gap, angles, 1.0), opening_at(other, angles, 1.0)
            least = float(np.min(both[0] + both[1]))
            rounding = 1e-12 * float(np.abs(both).max())
            if (other.direction == -gap.direction).all() and least < -rounding:
                when = " at all times" if moves(gap) or moves(other) else ""
                return (
                    f"gaps[{i}] and gaps[{j}] face each other and overlap: the sum of their openings "
                    f"{'falls to' if when else 'is'} {least:.6g}, must be >= 0{when}"
                )
    return ""


def _refuse_opening(structure: Structure, arguments: tuple[Any, ...], q: _Array) -> NoReturn:
    """ParameterError for the gap that is too narrow for a simulation from a state."""
    matrices, directions, values, frequency, harmonics, constant = arguments[:6]
    number, least = _core.narrow_gap(
        matrices, directions, values, frequency, harmonics, constant, q
    )
    gap = structure.gaps[number - 1]
    wanted = f"at least {1.06 * least:.1e}, a million times the rounding error of the displacements"
    for i, other in enumerate(structure.gaps):
        if isinstance(other, Gap) and (other.direction == -gap.direction).all():
            total = gap.opening + other.opening
            raise ParameterError(
                f"gaps[{number - 1}].opening + gaps[{i}].opening = {total!r}: must be {wanted}"
            )
    raise ParameterError(f"gaps[{number - 1}].opening = {gap.opening!r}: must be 0 or {wanted}")


@overload
def simulate(
    osc: Oscillator, r: Value, clearance: Value, cycles: float, state: Mapping[str, Value] | None = None,
    load: Value | Load = 1.0, discard: float = 0, max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Trajectory: ...  # fmt: skip
@overload
def simulate(
    structure: Structure, load: Load | Record | None = None, *, cycles: float | None = None,
    duration: float | None = None, state: tuple[ArrayLike, ArrayLike] | None = None, start: float = 0.0,
    max_events: int = 1_000_000, discard: float = 0.0,
) -> Trajectory: ...  # fmt: skip
@overload
def simulate(point: Point, /, cycles: float, **options: Any) -> Trajectory: ...


@physical_arguments
@every_system(simulate_structure, of_law=state_by_coordinates)
@memory_for("events of a simulation, by max_events")
def simulate(
    osc: Oscillator,
    r: float,
    clearance: float,
    cycles: float,
    state: Mapping[str, float] | None = None,
    load: float | Load = 1.0,
    discard: float = 0,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Trajectory:
    """Simulate from an initial state. No impact is missed, and accumulating impacts are completed.

    Between impacts the motion has a closed form. The next contact is approached in steps that are proven to be
    free of contact by a bound on the derivatives. Accumulating impacts are summed to their limit (the error of the
    time of the limit is at most 1e-16); the free mass then rests on the wall until the contact force vanishes.

    The system is `osc, r, clearance`, or a point from `Oscillator.at`, or `structure, load`: a structure with gaps
    under a `Load`, a `Record` (after its last sample the force is 0) or none. At an impact on one of its gaps the
    velocities jump by the impulse (1 + R) m v along M^-1 G, with v the approach speed and 1/m = G.M^-1 G. For a
    structure, give `cycles` or `duration` (in time) by keyword, or neither for a whole record; `state` is
    (coordinates, velocities) at the time `start`, zero by default; `discard` is in load cycles if `cycles` is
    given, otherwise in time; `max_events` is a million by default; there is no `progress`. An oscillator whose
    restitution depends on the speed is also simulated as a structure: to continue from its `final_state`, give
    ``start=run.end``.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    structure, load : Structure, Load, Record or None
        In place of `osc`, `r` and `clearance`.
    r : float
        Frequency ratio Omega/omega, 1e-6 to 1e6; not 1 if xi = 0.
    clearance : float
        D = d K/F0 (or d in the unit of length in which `load` is the static deflection F0/K); d is the whole
        travel between the walls.
    cycles : float
        Load cycles to simulate, 0 to 1e9.
    duration : float, optional
        For a structure: the time to simulate, in place of `cycles`.
    state : mapping, optional
        Some of ``t, x, x_dot, z, z_dot``, with the load phase r t at time t; missing ones are 0 (by default all).
        Or the `final_state` of a trajectory, which is then continued bit for bit. If all are 0, the free mass
        stays at rest in the middle until |X| reaches D/2. Without impacts |X| settles to the amplitude A, so that
        with D > 2 A no wall reaches the free mass, except perhaps during the transient: for such D, give the free
        mass an initial velocity.
    start : float
        For a structure: time at the start.
    load : float
        Load amplitude f >= 0, relative to the load that defines the unit of length; 0 is free vibration.
    discard : float
        Load cycles simulated before those that are kept.
    max_events : int
        Largest number of events; if there are more, the trajectory ends there (`complete` is then False). At most
        50 million, which take 4 GB.
    progress : callable, optional
        Called at intervals with the fraction done and the current task; by default a progress bar on a terminal or
        in a notebook.

    Returns
    -------
    Trajectory
        The events and the states at both ends; `sample` gives the motion between them.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If an event cannot be found within millions of oscillations. For a structure: if a gap is penetrated at the
        start, a mode without damping resonates with the load, two modes coincide because of damping, or coupled
        gaps close at the same instant; if there were earlier events, the attribute `result` of the error is the
        motion up to this point.

    Examples
    --------
    One impact on the right wall, then impacts that accumulate on the left one and end in rest:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    >>> run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=4, discard=300)
    >>> run
    <Trajectory at r = 0.9, d K/F0 = 6, t = 2094.4 to 2122.32: 184 impacts, 4 rests>
    >>> run.events[-1]["kind"].item(), run.events[-1]["side"].item()
    ('stick', 'L')

    A mass on a spring that carries a free mass between two walls, which starts with velocity -1:

    >>> gaps = [vi.Gap([-1, 1], 1.0), vi.Gap([1, -1], 1.0)]
    >>> cell = vi.Structure(mass=[1, 0.3], damping=[0, 0], stiffness=[1, 0], gaps=gaps)
    >>> run = vi.simulate(cell, duration=20, state=([0, 0], [0, -1]))
    >>> run
    <Trajectory t = 0 to 20: 6 impacts>
    >>> run.events["time"][:3].round(6).tolist()
    [1.0, 5.561718, 7.505486]
    """
    of_numbers(osc)
    r = checks.frequency_ratio(r, osc.xi, near=True)
    clearance = checks.number(clearance, "clearance")
    load = checks.number(load, "load")
    cycles = checks.number(cycles, "cycles_simulated", "cycles")
    discard = checks.number(discard, "cycles_simulated", "discard")
    max_events = checks.integer(max_events, "max_events", 1, MOST_KEPT)
    system = (osc.xi, osc.mu, osc.restitution, r, load, clearance)
    now, begun = start_of(system, state)
    # the least clearance is 1e-10 of it, and most calls need not ask the core
    largest = max(steady_amplitude(osc, r, load), abs(now[0][2]))
    least = _core.least_clearance(osc.xi, r, load, now[0][2]) if clearance < 1e-9 * largest else 0
    if clearance < least:
        raise ParameterError(
            f"clearance = {clearance!r}: must be at least {1.06 * least:.1e}, a million times the rounding error "
            "of the displacements"
        )
    whole = discard + cycles or 1.0
    checks.progress(progress)
    # a bar takes as long as several impacts
    with reported(progress, "simulate") if whole > MANY_CYCLES else nullcontext(progress) as told:

        def report(done: float) -> None:
            """Reports the number of finished load cycles."""
            if told is not None:
                told(done / whole, "simulation")

        if discard:
            _, now, begun, complete = _run(
                system, now, begun, discard, max_events, report, keep=False
            )
            if not complete:
                raise ParameterError(
                    f"max_events = {max_events}: must be larger; it was reached within the discarded cycles"
                )
        first = state_of(system, now, begun)
        events, now, begun, complete = _run(
            system, now, begun, cycles, max_events, lambda done: report(discard + done), keep=True
        )
    events.flags.writeable = False
    start = as_numbers(state)
    request = start and {
        "clearance": clearance, "cycles": cycles, "discard": discard, "load": load, **start,
        "max_events": max_events,
    }  # fmt: skip
    last = state_of(system, now, begun)
    return Trajectory(
        osc=osc, r=r, clearance=clearance, load=load, events=events, initial_state=first, final_state=last,
        complete=complete, request=request, cut="",
    )  # fmt: skip


def _run(
    system: System, now: Moment, begun: Moment, cycles: float, max_events: int,
    report: Callable[[float], None], *, keep: bool,
) -> tuple[NDArray[Any], Moment, Moment, bool]:  # fmt: skip
    """Simulate some cycles in chunks.

    `now` is the moment at which the cycles begin, and `begun` the moment at which the current flight or rest
    began; `report` is called with the number of finished cycles.

    Returns
    -------
    events : ndarray
        The events, if they are to be kept.
    now, begun
        These moments at the end.
    complete : bool
        Whether the end was reached.
    """
    first, end = float(now[0][0]), later(now[0], cycles)
    span = max(1.0, SPAN * min(1.0, system[3]))
    tables, total = [], 0
    chunk = int(min(CHUNK, 64 + 4 * (cycles + 1)))
    while True:
        cycle = float(now[0][0])
        last_part = end[0] - cycle <= span
        stop = end if last_part else (cycle + span, 0.0)
        table = np.empty((min(chunk, max_events - total), 11))
        n, last, last_contact, final, contact, status = _core.simulate(
            *system, *begun, *stop, WORDS, table.T
        )
        begun, now = (last, last_contact), (final, contact)
        total += n
        if keep and n:
            tables.append(table[:n] if 4 * n > len(table) else table[:n].copy())
        if status not in (0, MORE_EVENTS):
            raise_status(status)
        report(min(cycles, float(now[0][0]) - first))
        if last_part if status == 0 else total == max_events:
            break
        chunk = CHUNK if status else chunk
    rows = tables[0] if len(tables) == 1 else np.concatenate([np.empty((0, 11)), *tables])
    return np.ndarray(len(rows), EVENT_TYPE, rows), now, begun, status == 0


def last_period(
    trajectory: Trajectory, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE
) -> Period:
    """The shortest period on which a trajectory has settled; see `Trajectory.period`."""
    osc, r = trajectory.osc, trajectory.r
    most_cycles = checks.integer(most_cycles, "most_cycles", 1, 1000)
    end = end_of(trajectory, most_cycles, tolerance)
    cycles, n, symbols, first, mismatch, *_ = _core.end_of_trajectory(
        osc.xi, osc.mu, osc.restitution, r, trajectory.load, trajectory.clearance, *end, 0, 1
    )
    if not cycles:
        raise not_periodic(trajectory, most_cycles)
    events = trajectory.events[len(trajectory.events) - len(first) + first[:n] - 1]
    return Period(Pattern(letters_of(symbols[:n]), cycles), events, mismatch)


def end_of(
    trajectory: Trajectory, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE
) -> tuple[_Array, _Array, NDArray[np.int32], int, float]:
    """The end of a trajectory as arguments of the core, with the criteria for a period."""
    events, r = trajectory.events, trajectory.r
    # two periods, and the same number of cycles after the last release
    begin = trajectory.final_state["t"] - (3 * most_cycles + 1) * 2 * math.pi / r
    begin = max(begin, trajectory.initial_state["t"])
    values, labels = event_arrays(events[np.searchsorted(events["time"], begin) :])
    if not labels.size:
        raise without_impacts(trajectory, begin)
    of_simulation = np.array([r, trajectory.load, trajectory.clearance, begin])
    return of_simulation, values, labels, most_cycles, tolerance


def letters_of(symbols: NDArray[np.int32]) -> str:
    """The letters of the core's symbols: 1 and -1 for an impact, 2 and -2 for accumulation and rest."""
    return "".join(f"{'RL'[one < 0]}{'*' * (abs(one) - 1)}" for one in symbols.tolist())


def steady_amplitude(osc: Oscillator, r: float, load: float) -> float:
    """The steady amplitude of the primary mass alone; infinite at resonance without damping."""
    squared = (1 - r * r) ** 2 + (2 * osc.xi * r) ** 2
    return load / math.sqrt(squared) if squared > 0 else math.inf


def without_impacts(trajectory: Trajectory, begin: float) -> ParameterError:
    """The error for a trajectory without impacts after some time."""
    osc, r, half = trajectory.osc, trajectory.r, 0.5 * trajectory.clearance
    when = f"since t = {value_text(osc, 't', begin)}" if len(trajectory.events) else "in it"
    amplitude = steady_amplitude(osc, r, trajectory.load)
    wall = f"{'D/2' if osc.F0 is None else 'd/2'} = {value_text(osc, 'x', half)}"
    reached = f"A = {value_text(osc, 'x', amplitude)}"
    if amplitude < half:
        reason = (
            f"Without impacts |X| settles to {reached}, below {wall}, and a free mass at rest in the middle "
            "is never reached. Start from another state, such as state=dict(t=0, x=0, x_dot=0, z=0, z_dot=v) with "
            "a velocity v"
        )
    else:
        reason = (
            f"|X| grows to {reached}, above {wall}: simulate longer (discard more), or start from another "
            "state"
        )
    return ParameterError(
        f"{trajectory!r}: must have impacts at its end; no impact happened {when}. {reason}"
    )


def not_periodic(trajectory: Trajectory, most_cycles: int = MOST_CYCLES) -> ParameterError:
    """The error for a trajectory that has not settled on a period."""
    return ParameterError(
        f"{trajectory!r}: has not settled on a period of at most {most_cycles} load cycles; it may be chaotic "
        "(see `lyapunov`); otherwise discard more load cycles"
    )
