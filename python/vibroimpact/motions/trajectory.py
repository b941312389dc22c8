"""Simulated trajectories with every impact, accumulation and rest."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..base.sizes import memory_for
from ..base.status import MORE_EVENTS, raise_status
from ..results import namelist
from ..results.events import (
    EVENT_TYPE,
    WORDS,
    Sample,
    event_arrays,
    event_columns,
    events_of,
    sample,
    segments,
)
from ..results.gradient import Gradient
from ..results.noun import ACTIONS, Noun, Savable
from ..results.states import (
    NEEDED,
    Moment,
    State,
    System,
    as_numbers,
    later,
    moments_of,
    start_of,
    state_by_coordinates,
    state_of,
)
from ..results.tables import Result, made
from ..systems.oscillator import Oscillator, Pattern, Point, of_numbers
from ..systems.record import Record
from ..systems.structure import Load, Structure
from ..systems.verbs import every_system
from .motion import osc_of, units_of
from .quantities import Quantities, quantities_of
from .structure_trajectory import StructureTrajectory, simulate_structure

__all__ = ["Period", "State", "Trajectory", "simulate"]

_Array = NDArray[np.float64]

#: The moments of a trajectory in the core's table, and the keys of a &simulate.
MOMENTS = ("initial", "initial flight", "final", "final flight")
REQUEST = ("clearance", "cycles", "discard", "load", *NEEDED, "max_events")
#: The note on a trajectory that reached the limit on events.
FULL = "max_events was reached"
#: Largest numbers of events and of load cycles in a call of the core; Ctrl-C takes effect between calls.
CHUNK, SPAN = 65_536, 1_000_000
#: Load phase of a load cycle.
TURN = 2 * np.pi
#: Largest number of events of a trajectory, as in the core: 88 bytes each.
MOST_KEPT = 50_000_000

#: Longest period in load cycles, and largest difference of its phases from the period before.
MOST_CYCLES, TOLERANCE = 16, 0.05


class Period(NamedTuple):
    """The period with which a trajectory ends.

    Attributes
    ----------
    pattern : Pattern
    events : structured ndarray
        The event that begins each letter of the pattern, with the columns of `Trajectory.events`: an impact, the
        first one of an accumulation.
    mismatch : float
        Largest difference of their phases from those of the period before (radians).
    """

    pattern: Pattern
    events: NDArray[Any]
    mismatch: float


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Trajectory(Savable, study="simulate"):
    """A simulated trajectory. Lengths in F0/K (or any unit, if `load` is not 1), time in 1/omega.

    Attributes
    ----------
    osc : Oscillator
    r, clearance, load : float
        Frequency ratio, clearance and load amplitude.
    events : structured ndarray
        In order of time: ``time``, ``kind`` ("impact", "stick" where accumulating impacts end in rest,
        "release" where the rest ends), ``side`` ("R" or "L"), ``phase`` (of the load, in [0, 2 pi)),
        ``x``, ``x_dot_before``, ``x_dot_after``, ``z_dot_before``, ``z_dot_after``.
    initial_state, final_state : dict
        States at both ends; a final state continues bit for bit when given to `simulate`.
    request : dict or None
        The case by the keys of a &simulate; None if a namelist cannot express it (see `to_namelist`).
    complete : bool
        False if there are more than `max_events` events before the end of time, or if it was stopped.
    cut : str
        How far it got, if it was stopped.
    """

    osc: Oscillator
    r: float
    clearance: float
    load: float
    events: NDArray[Any]
    initial_state: State
    final_state: State
    complete: bool
    request: dict[str, Any] | None = None
    cut: str = ""

    @memory_for("a sample at the times t")
    def sample(self, t: ArrayLike) -> Sample:
        """Positions, velocities, accelerations and load at times within the trajectory, from the closed form.

        Parameters
        ----------
        t : array_like
            Times between those of `initial_state` and `final_state`, in any order. At an event velocities and
            accelerations are those just after it.

        Returns
        -------
        Sample
            As of `Motion.sample`.

        Examples
        --------
        >>> import numpy as np, vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> run = vi.simulate(osc, r=1.04, clearance=25.0, cycles=50)
        >>> history = run.sample(np.linspace(0, run.final_state["t"], 1000))
        >>> bool(np.all(abs(history.Y) <= 12.5 + 1e-12))
        True
        """
        times = checks.real_array(t, "t", "real times")
        first, last = self.initial_state["t"], self.final_state["t"]
        if times.size and not (first <= times.min() and times.max() <= last):
            raise ParameterError(
                f"t from {times.min():.6g} to {times.max():.6g}: must be within the trajectory, "
                f"{first:.6g} to {last:.6g}"
            )
        starts, resting = self._segments()
        return sample(self.osc, self.r, self.load, self.clearance, starts, resting, times)

    @memory_for("quantities, by their window and harmonics")
    def quantities(self, cycles: float | None = None, harmonics: int = 10) -> Quantities:
        """Response quantities over the last load cycles, as of `Motion.quantities`.

        Parameters
        ----------
        cycles : float, optional
            Load cycles of the window, which ends with the trajectory; all of it by default. Harmonics are those of
            a periodic response only if the response is periodic and the window a whole number of periods.
        harmonics : int
            Harmonics of the load, 1 to 10000.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed.

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
        first, end = self.initial_state["t"], self.final_state["t"]
        if cycles is not None:
            wanted = f"load cycles of the trajectory, > 0 and at most {(end - first) * self.r / TURN:.10g}"
            cycles = checks.to_float(cycles, "cycles", wanted)
            begin = end - cycles * TURN / self.r
            if not (cycles > 0 and begin >= first - 1e-9 * TURN / self.r):
                raise ParameterError(f"cycles = {cycles!r}: must be {wanted}")
            first = max(first, begin)
        starts, resting = self._segments()
        here = int(np.searchsorted(starts[0], first, side="right")) - 1
        starts, resting = starts[:, here:], resting[here:]
        at, last = self.sample(first), self.sample(end)
        starts[:, 0] = [
            first, starts[1, 0] + self.r * (first - starts[0, 0]), at.X, at.X_dot, at.Z, at.Z_dot,
        ]  # fmt: skip
        return quantities_of(
            self.osc, self.r, self.load, starts, resting, end,
            (float(last.X), float(last.X_dot), float(last.Z_dot)),
            self.events[self.events["time"] > first], harmonics,
        )  # fmt: skip

    def period(self, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE) -> Period:
        """The shortest period with which the trajectory ends.

        The last load cycles repeat the pattern of as many before, at phases within the tolerance. That is no proof
        of a periodic motion; `exact` computes the motion.

        Parameters
        ----------
        most_cycles : int
            Load cycles of the longest period considered.
        tolerance : float
            Largest difference of the phases (radians).

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
        return last_period(self, most_cycles, tolerance)

    def gradient(self) -> Gradient:
        """The derivatives of all events and of the final state by the initial state and by all parameters.

        They go through impacts, accumulations and rests in closed form (saltation). The quantities are ``time``,
        ``x``, ``x_dot_before``, ``x_dot_after``, ``z_dot_before`` and ``z_dot_after`` of the events, and
        ``final_t``, ``final_x``, ``final_x_dot``, ``final_z`` and ``final_z_dot``. The parameters are t, x, x_dot,
        z and z_dot of the initial state, and r, clearance, xi, mu, R1, R2, R (both alike) and load. The number of
        load cycles is fixed, and so is the initial state while another parameter changes: the end of time
        changes with r.

        Returns
        -------
        Gradient
            NaN from the first event on that has no derivatives: an impact without approach speed, or a rest that
            ends without its contact force falling through 0; `status` names it. If the free mass rests on a wall
            at the start, those by z and z_dot are NaN, and the other ones move both masses.

        Raises
        ------
        ParameterError
            If the trajectory is not complete, or has more than a million events.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> start = dict(t=0.0, x=0.0, x_dot=1.0, z=0.0, z_dot=3.0)
        >>> gradient = vi.simulate(osc, r=1.04, clearance=25.0, cycles=5, state=start).gradient()
        >>> gradient["final_x", "z_dot"].shape, gradient["time"].shape[1] == len(gradient.parameters)
        ((), True)
        """
        found: Gradient = ACTIONS["trajectory_gradient"](self)
        return found

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` compute the same digits."""
        if self.request is None:
            raise ParameterError(
                f"{self!r}: has no namelist, since it began with the final state of another trajectory"
            )
        return namelist.case(self.osc, self.r, simulate=self.request)

    @property
    def _result(self) -> Result:
        """Its tables, with the columns that the core declares for &simulate."""
        right, left = self.osc.restitution
        ends = (self.initial_state, self.final_state)
        moments = [moment for state in ends for moment in moments_of(state)]
        final = [float(self.final_state[name]) for name in NEEDED]
        tables: dict[str, Any] = {
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
        cut = "" if self.complete else self.cut or FULL
        state = f"final state: t, x, x_dot, z, z_dot = {', '.join(map(namelist.digits, final))}"
        case = "" if self.request is None else self.to_namelist()
        return made("simulate", case, tables, (state,), cut)

    @classmethod
    def of_result(cls, result: Result) -> Trajectory:
        """The trajectory of the core's tables."""
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
            osc, one["r"], one["clearance"], one["load"], events_of(result), state_of(system, start, begun),
            state_of(system, end, last), bool(one["finished"]), request,
            "" if result.cut == FULL else result.cut,
        )  # fmt: skip

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax, kind="history")

    def plot(self, ax: Any = None, kind: str | None = None, cycles: float = 3.0) -> Any:
        """Draw time history, load, acceleration and phase portrait of the last load cycles (extra `plot`).

        Parameters
        ----------
        ax, kind
            As in `Motion.plot`.
        cycles : float
            Load cycles shown, the last ones.

        Returns
        -------
        Axes, or an array of Axes if all panels were drawn.
        """
        return self._draw(ax, kind, cycles)

    def animate(
        self, path: str | os.PathLike[str] | None = None, cycles: float = 3.0, seconds: float = 3.0
    ) -> Any:
        """Animate the last load cycles; the wall that is hit flashes, that of a rest is green (extra `plot`).

        Parameters
        ----------
        path, seconds
            As in `Motion.animate`.
        cycles : float
            Load cycles shown, the last ones.

        Returns
        -------
        Path
            Without `path` matplotlib's FuncAnimation, as in `Motion.animate`.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
        >>> run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=4, discard=300)
        >>> run.animate("rest.gif", cycles=1, seconds=0.3).name
        'rest.gif'
        """
        return self._animate(path, cycles, seconds)

    def _segments(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """Start of each segment (6, n), and the side on which the free mass rests in it."""
        state = self.initial_state
        first = np.array([[state[name] for name in ("t", "phase", "x", "x_dot", "z", "z_dot")]]).T
        starts, resting = segments(self.events, self.clearance)
        side = int(state["side"]) if state["resting"] else 0
        return np.hstack([first, starts]), np.concatenate(
            [np.array([side], dtype=np.int32), resting]
        )

    def __repr__(self) -> str:
        n, m = (int((self.events["kind"] == kind).sum()) for kind in ("impact", "stick"))
        impacts = f"{n} impact{'s' * (n != 1)}"
        rests = f", {m} rest{'s' * (m != 1)}" if m else ""
        if self.initial_state["resting"] and not (self.events["kind"] == "release").any():
            # this rest began before the first event, which therefore does not tell of it
            wall = "R" if self.initial_state["side"] > 0 else "L"
            rests += f", m rests on {wall} all the time"
        cut = "" if self.complete else f"; cut short, {self.cut or FULL}"
        return (
            f"<Trajectory at r = {self.r:.6g}, d K/F0 = {self.clearance:.6g}, t = {self.initial_state['t']:.6g} "
            f"to {self.final_state['t']:.6g}: {impacts}{rests}{cut}>"
        )


class Simulation(Noun, study="simulate"):
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


@overload
def simulate(
    osc: Oscillator, r: float, clearance: float, cycles: float, state: Mapping[str, float] | None = None,
    load: float = 1.0, discard: float = 0, max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Trajectory: ...  # fmt: skip
@overload
def simulate(
    structure: Structure, load: Load | Record | None = None, *, cycles: float | None = None,
    duration: float | None = None, state: tuple[ArrayLike, ArrayLike] | None = None, start: float = 0.0,
    max_events: int = 1_000_000, discard: float = 0.0,
) -> StructureTrajectory: ...  # fmt: skip
@overload
def simulate(point: Point, /, cycles: float, **options: Any) -> Trajectory: ...


@every_system(simulate_structure, of_law=state_by_coordinates)
@memory_for("events of a simulation, by max_events")
def simulate(
    osc: Oscillator,
    r: float,
    clearance: float,
    cycles: float,
    state: Mapping[str, float] | None = None,
    load: float = 1.0,
    discard: float = 0,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> Trajectory:
    """Simulate from an initial state; no impact is missed, and accumulating impacts are completed.

    Between impacts the motion has a closed form. The next contact is approached in steps that a bound on the
    derivatives proves to be free of contact. Accumulating impacts are summed to their limit (the error of
    the time of the limit is at most 1e-16); the free mass then rests on the wall until the contact force
    vanishes.

    The system is `osc, r, clearance`, or a point from `Oscillator.at`, or `structure, load`: a structure with gaps
    under a `Load`, a `Record` (after its last sample the force is 0) or none. At an impact on one of its gaps the
    velocities jump by the impulse (1 + R) m v along M^-1 G, with v the approach speed and 1/m = G.M^-1 G. Of a
    structure `cycles` or `duration`, in time, is given by name, and neither for a whole record; `state` is
    (coordinates, velocities) at the time `start`; `max_events` is a million by default, without `progress`. Where
    the restitution of an oscillator depends on the speed it is simulated as a structure, too: its `final_state`
    continues from ``start=run.end``.

    Parameters
    ----------
    osc : Oscillator
    r : float
        Frequency ratio Omega/omega, 1e-6 to 1e6; not 1 if xi = 0.
    clearance : float
        D = d K/F0 (or d in the unit of length in which `load` is the static deflection F0/K); d is the whole
        travel between the walls.
    cycles : float
        Load cycles to simulate, 0 to 1e9.
    state : mapping, optional
        Some of ``t, x, x_dot, z, z_dot``, with the load phase r t at time t; the others are 0, and by default all
        are. Or the `final_state` of a trajectory, which continues it bit for bit. From all 0 the free mass stays
        at rest in the middle until |X| reaches D/2. |X| settles to the amplitude A without impacts, so that with D
        > 2 A no wall reaches it, unless the transient does: start it with a velocity there.
    load : float
        Load amplitude f >= 0 in units of the load that defines the unit of length; 0 is free
        vibration.
    discard : float
        Load cycles simulated before those that are kept.
    max_events : int
        Events after which the trajectory ends, if there are more (`complete` is then False); 50 million at most,
        which take 4 GB.
    progress : callable, optional
        Called at intervals with the share done and the present task.

    Returns
    -------
    Trajectory, or StructureTrajectory of a structure

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If an event cannot be found within millions of oscillations.

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
    least = _core.least_clearance(osc.xi, r, load, now[0][2])
    if clearance < least:
        raise ParameterError(
            f"clearance = {clearance!r}: must be at least {1.06 * least:.1e}, a million times the rounding error "
            "of the displacements"
        )
    whole = discard + cycles or 1.0
    checks.progress(progress)

    def report(done: float) -> None:
        """Reports the number of load cycles that are done."""
        if progress is not None:
            progress(done / whole, "simulation")

    if discard:
        _, now, begun, complete = _run(system, now, begun, discard, max_events, report, keep=False)
        if not complete:
            raise ParameterError(
                f"max_events = {max_events}: must be more; it was reached within the discarded cycles"
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
    return Trajectory(osc, r, clearance, load, events, first, last, complete, request)


def _run(
    system: System, now: Moment, begun: Moment, cycles: float, max_events: int,
    report: Callable[[float], None], *, keep: bool,
) -> tuple[NDArray[Any], Moment, Moment, bool]:  # fmt: skip
    """Simulate some cycles in chunks.

    `now` is the moment from which the cycles count, and `begun` the one at which its flight or rest began;
    `report` is called with the number of cycles done.

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
    return rows.view(EVENT_TYPE)[:, 0], now, begun, status == 0


def last_period(
    trajectory: Trajectory, most_cycles: int = MOST_CYCLES, tolerance: float = TOLERANCE
) -> Period:
    """The shortest period with which a trajectory ends; see `Trajectory.period`."""
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
    """The end of a trajectory as the core takes it, with what a period is."""
    events, r = trajectory.events, trajectory.r
    # two periods, and as many cycles after the last release
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


def without_impacts(trajectory: Trajectory, begin: float) -> ParameterError:
    """The error for a trajectory that has no impacts from some time on."""
    osc, r, half = trajectory.osc, trajectory.r, 0.5 * trajectory.clearance
    when = f"since t = {begin:.6g}" if len(trajectory.events) else "in it"
    # the steady amplitude of the primary mass alone; at resonance without damping it is unbounded
    squared = (1 - r * r) ** 2 + (2 * osc.xi * r) ** 2
    amplitude = trajectory.load / math.sqrt(squared) if squared > 0 else math.inf
    if amplitude < half:
        reason = (
            f"Without impacts |X| settles to A = {amplitude:.6g}, below D/2 = {half:.6g}, and a free mass at rest "
            "in the middle is never reached. Start from another state, as state=dict(t=0, x=0, x_dot=0, z=0, "
            "z_dot=v) with a velocity v"
        )
    else:
        reason = (
            f"|X| grows to A = {amplitude:.6g}, above D/2 = {half:.6g}: simulate longer (discard more), or start "
            "from another state"
        )
    return ParameterError(
        f"{trajectory!r}: must have impacts at its end; no impact happened {when}. {reason}"
    )


def not_periodic(trajectory: Trajectory, most_cycles: int = MOST_CYCLES) -> ParameterError:
    """The error for a trajectory that does not end about periodic."""
    return ParameterError(
        f"{trajectory!r}: must end about periodic; its last cycles do not repeat within {most_cycles} load "
        f"cycles. Simulate longer (discard more)"
    )
