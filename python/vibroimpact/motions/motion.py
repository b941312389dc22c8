"""The type that every solver returns: a periodic motion with impacts."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.actions import ACTIONS
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from ..base.sizes import memory_for
from ..base.status import GRAZE, NO_DERIVATIVE, NO_MOTION, VERDICT, raise_status, sentence
from ..results import namelist
from ..results.events import (
    EVENT_TYPE,
    Sample,
    event_columns,
    events_of,
    sample,
    segments,
    with_accelerations,
)
from ..results.gradient import Gradient
from ..results.noun import Noun, Solution
from ..results.parameters import Wanted
from ..results.systems import (
    check_gap_numbers,
    osc_of,
    structure_of,
    structure_tables,
    units_of,
    with_owners,
)
from ..results.tables import Result, Table, made, runs
from ..systems.oscillator import Oscillator, Pattern
from ..systems.structure import Gap, Load, Structure
from ..systems.units import argument, place_text, range_text, time_of, units_to_show
from .quantities import Quantities, oscillator_quantities
from .trajectory import (
    EVENTS_OF_STRUCTURE,
    Trajectory,
    core_arrays,
    refuse_output,
    request_in,
    request_of,
    segments_of_events,
    simulate_structure,
    states_in,
)

if TYPE_CHECKING:
    from ..systems.units import Units

__all__ = ["Motion", "Motions", "Sample"]

#: Columns of the core's tables of motions and impacts; those of impacts by their attribute names.
OF_MOTION = (
    "r", "clearance", "A", "tau", "residual", "x_min", "x_max", "load", "kind", "precision",
)  # fmt: skip
VERDICTS = ("consistent", "admissible", "stable")
OF_IMPACTS = {
    "restitution": "restitution", "alpha": "phase", "X": "X", "Z": "Z", "X_dot_before": "X_dot_before",
    "X_dot_after": "X_dot_after", "Z_dot_before": "Z_dot_before", "Z_dot_after": "Z_dot_after",
}  # fmt: skip
#: The same for a structure.
OF_STRUCTURE = ("cycles", "residual", "determinant", "law")
IMPACTS_OF_STRUCTURE = {"gaps": "gap", "phases": "phase", "speeds": "speed", "impulses": "impulse"}
RESTS = np.dtype([("gap", "i4"), ("begin", "f8"), ("end", "f8")])
#: The keys of a &motion of a &structure.
REQUEST = (
    "kind", "cycles", "gaps", "phases", "kinds", "settling", "max_cycles", "q", "q_dot", "start", "duration",
    "period",
)  # fmt: skip
#: The codes of the verdicts in tables.
CODES = {True: 1, False: 0, None: -1}
#: Largest residual of a consistent motion, unless &motion specifies another.
ACCEPTANCE = 0.03
#: Largest phase of an impact, in magnitude.
MOST_PHASE = 1e6
#: Largest phase difference (rad) of events at one instant (due to rounding), and between the last impact of an
#: accumulation and its end.
AT_ONCE, SHORT = 1e-9, 1e-5

#: The leading arguments of the core's procedures on a finished motion.
_Array = NDArray[np.float64]
_Flights = tuple[float, float, float, int, NDArray[np.int32], _Array, _Array, _Array, float, float]


def load_phase_of(tau: Any, xi: Any, r: Any) -> Any:
    """Phase of the load at the first impact."""
    return tau + np.arctan2(2 * xi * r, (1 - r) * (1 + r))


def _states(motion: Motion) -> _Array:
    """The states just after the impacts by coordinates and velocities."""
    columns = (motion.X, motion.Z, motion.X_dot_after, motion.Z_dot_after)
    return np.stack(columns, axis=1).reshape(-1, 2, 2)


def _phases(motion: Motion | Motions) -> _Array:
    """The load phases of the impacts."""
    found: _Array = motion.alpha + np.mod(motion.load_phase, 2 * math.pi)
    found.flags.writeable = False
    return found


def _impulses(motion: Motion) -> _Array:
    """(1 + R) m v, with the mass m = 1/(1 + 1/mu) that an impact sees."""
    mass = motion.osc.mu / (1 + motion.osc.mu)
    return (1 + motion.restitution) * mass * motion.speeds


class Motion(Solution, study="motion", formerly="StructureMotion"):
    """A periodic motion with impacts; its arrays are read-only.

    Motions come from `periodic`, `equispaced`, `exact` and `find`. For an oscillator, lengths are in F0/K,
    velocities in omega F0/K and times in 1/omega; for a structure, everything is in the user's units. Angles are
    in radians. An oscillator is the structure of its two masses and two gaps,
    `osc.at(r, clearance, load).structure`, whose coordinates are x and z: gap 0 is the right wall, gap 1 the left
    one.

    Attributes
    ----------
    gaps : ndarray (N,)
        The gap of each impact in a period, from 0.
    phases : ndarray (N,)
        Load phases Omega t of the impacts, in ascending order.
    speeds, impulses : ndarray (N,)
        Approach speeds, and impulses (1 + R) m v.
    states : ndarray (N, 2, n)
        Coordinates and velocities just after each impact; the velocities just before it are these plus the impulse
        times M^-1 G.
    cycles : int
        Load cycles in a period.
    load : float or Load
        For an oscillator, the load amplitude f, 1 unless another one was passed to `exact`; for a structure, the
        load.
    residual : float
        Relative 2-norm of the residual of equations (26), (30). With N = 2 they are a square system, and it is 0
        by definition. For a structure, the largest residual of the equations, each relative to the sum of the
        absolute terms in it.
    multipliers : ndarray (2n,) of complex
        Eigenvalues of [P], in order of decreasing modulus; NaN where `without_multipliers` gives a reason.
    consistent : bool or None
        Whether the residual is within the acceptance; for a structure, whether the residual is at the level of
        rounding.
    admissible : bool or None
        Whether the masses approach at each impact and every gap stays open between the impacts.
    stable : bool or None
        Whether all multipliers (except the trivial one of a self-excited motion) lie inside the unit circle. None
        where there are no multipliers, or where the leading one is on the circle within rounding (no damping, for
        example).
    osc : Oscillator
    r : float
        Frequency ratio Omega/omega. This and all attributes down to `rest_events` are for an oscillator.
    clearance : float
        D = d K/F0; d is the whole travel of the free mass between the walls.
    pattern : Pattern
    restitution : ndarray (N,)
        Coefficient of restitution of each impact.
    alpha : ndarray (N,)
        Phase of each impact measured from the first one, alpha_i; `load_phase` is the load phase of the first
        impact.
    X, Z : ndarray (N,)
        Positions of primary and free mass at each impact.
    X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N,)
        Velocities just before and just after each impact.
    A, tau : float
        Amplitude of the motion without impacts and phase of equation (4): the forced part of the
        motion is ``A sin(r t + tau)`` with t = 0 at the first impact.
    x_min, x_max : float
        Extreme positions of the primary mass over the period.
    precision : str
        "double", or "single" if the chain was computed in 32-bit arithmetic.
    kind : str
        The method: "periodic" or "equispaced" (the linear equations), or "exact".
    guess : ndarray (N,) or None
        For an exact motion: the phases alpha from which it was found, if it started with the linear equations.
    rest_events : structured ndarray or None
        For a pattern with a star: all impacts, sticks and releases of a period from the first impact on.
        The arrays above then have one entry per symbol; for a starred symbol it is the first impact of the
        accumulation.
    structure : Structure
        The structure. This and all following attributes are for a structure.
    self_excited : bool
    trivial : int or None
    matrix : ndarray (2n, 2n)
        [P], the derivative of the map of (q, q') over a period, from just after the first impact or, with rests,
        from the middle of the longest flight; NaN if it does not exist.
    determinant, law : float
        det[P], and exp(-tr(M^-1 C) T) times the product of R (R + R' v) over the impacts, which it must equal
        up to rounding errors of the size of eps times the product of the column lengths of [P]; 0 with rests.
    rests : structured array
        ``gap, begin, end``: gaps that rest, and the load phases at which each rest begins and ends. The
        impacts of the accumulation before it are listed down to those whose effect is below rounding.
    request : dict or None
        The case as the keys of a &motion; None with ``full=True``, or if the motion was read from a file without
        its case.
    """

    __slots__ = (
        "A", "X", "X_dot_after", "X_dot_before", "Z", "Z_dot_after", "Z_dot_before", "admissible", "alpha",
        "clearance", "consistent", "cycles", "determinant", "gaps", "guess", "impulses", "kind", "law", "load",
        "matrix", "multipliers", "osc", "pattern", "phases", "precision", "r", "request", "residual",
        "rest_events", "restitution", "rests", "speeds", "stable", "states", "structure", "tau", "x_max", "x_min",
    )  # fmt: skip
    _derived: ClassVar = {
        "gaps": lambda self: np.where(self.pattern.signs > 0, 0, 1).astype(np.int32),
        "cycles": lambda self: self.pattern.cycles, "phases": _phases, "states": _states, "impulses": _impulses,
        "speeds": lambda self: self.pattern.signs * (self.Z_dot_before - self.X_dot_before),
    }  # fmt: skip
    _instead = (
        {
            "structure": "osc", "matrix": "stability_matrix()", "determinant": "multipliers", "law": "multipliers",
            "rests": "rest_events", "request": "to_namelist()",
        },
        {
            "osc": "structure and load", "r": "load.frequency", "clearance": "structure.gaps",
            "pattern": "gaps and cycles", "restitution": "structure.gaps, and speeds", "alpha": "phases",
            "load_phase": "phases", "X": "states", "Z": "states", "X_dot_after": "states", "Z_dot_after": "states",
            "X_dot_before": "states and impulses", "Z_dot_before": "states and impulses", "A": "load",
            "tau": "phases", "x_min": "quantities()", "x_max": "quantities()", "attenuation": "quantities()",
            "precision": "residual", "kind": "request", "guess": "request", "rest_events": "rests",
            "events": "gaps, phases and rests",
        },
    )  # fmt: skip

    gaps: NDArray[np.int32]
    phases: _Array
    speeds: _Array
    impulses: _Array
    states: _Array
    cycles: int
    load: Any
    residual: float
    multipliers: NDArray[np.complex128]
    consistent: bool | None
    admissible: bool | None
    stable: bool | None
    osc: Oscillator
    r: float
    clearance: float
    pattern: Pattern
    restitution: _Array
    alpha: _Array
    X: _Array
    Z: _Array
    X_dot_before: _Array
    X_dot_after: _Array
    Z_dot_before: _Array
    Z_dot_after: _Array
    A: float
    tau: float
    x_min: float
    x_max: float
    precision: str
    kind: str
    guess: _Array | None
    rest_events: NDArray[Any] | None
    structure: Structure
    matrix: _Array
    determinant: float
    law: float
    rests: NDArray[Any]
    request: dict[str, Any] | None

    @property
    def events(self) -> NDArray[Any]:
        """For an oscillator: the events of one period from the first impact on, as in `Trajectory.events`."""
        if self.rest_events is not None:
            return self.rest_events
        events = np.empty(len(self.pattern), dtype=EVENT_TYPE)
        events["time"] = self.alpha / self.r
        events["kind"] = "impact"
        events["side"] = self.pattern.symbols
        events["phase"] = np.mod(self.alpha + self.load_phase, 2 * math.pi)
        for name, values in (
            ("x", self.X), ("x_dot_before", self.X_dot_before), ("x_dot_after", self.X_dot_after),
            ("z_dot_before", self.Z_dot_before), ("z_dot_after", self.Z_dot_after),
        ):  # fmt: skip
            events[name] = values
        return events

    @property
    def period(self) -> float:
        """Period of the motion in time, of an oscillator in units of 1/omega."""
        frequency = self.load.frequency if self.of_structure else self.r
        return 2 * math.pi * self.cycles / frequency

    @property
    def self_excited(self) -> bool:
        """Whether the motion has no periodic load, so that its phase is free.

        Its period is then 2 pi/load.frequency.
        """
        return self.of_structure and not len(self.load.sine) and not self.structure._moves

    @property
    def _given_load(self) -> Load:
        """For a structure: its load; for a self-excited motion, without the frequency, which is a result."""
        return Load(constant=self.load.constant) if self.self_excited else self.load

    def _in(self, units: Units) -> Motion:
        """The motion of a structure of an oscillator in physical units."""
        sizes = np.repeat([units.length, units.velocity], self.structure.coordinates)
        found: Motion = self.__replace__(
            structure=self.structure._in(units), load=self.load._in(units), states=states_in(self.states, units),
            speeds=self.speeds * units.velocity, impulses=self.impulses * units.impulse,
            matrix=self.matrix * np.divide.outer(sizes, sizes), request=request_in(self.request, units),
        )  # fmt: skip
        return found

    def _groups(self) -> list[tuple[str, dict[str, Any]]]:
        """For a structure: the namelist groups of the structure and its load."""
        load = self._given_load
        bare = self.self_excited and not load.constant.any()
        return [*self.structure._groups(), *([] if bare else load._groups())]

    @property
    def without_multipliers(self) -> str:
        """Why there are no multipliers; empty if there are."""
        if not np.isnan(self.multipliers).any():
            return ""
        return sentence(NO_DERIVATIVE if self._has_meetings or self._has_changes_at_once else GRAZE)

    def _refuse_meetings(self) -> None:
        """Raises SingularError if simultaneous impacts on coupled gaps leave the motion without derivatives."""
        if self._has_meetings and self.without_multipliers:
            raise SingularError(self.without_multipliers)

    @property
    def _has_meetings(self) -> bool:
        """For a structure: whether there are simultaneous impacts."""
        if not self.of_structure:
            return False
        # what happens to stops and friction is no impact
        rigid = np.array([isinstance(part, Gap) for part in self.structure._parts])
        return self._some_at_once(rigid[self.gaps])

    @property
    def _has_changes_at_once(self) -> bool:
        """For a structure with stops or friction: whether some of its events are simultaneous."""
        if not self.of_structure or self.structure._is_rigid:
            return False
        return self._some_at_once(np.full(len(self.gaps), True))

    def _some_at_once(self, chosen: NDArray[np.bool_]) -> bool:
        """Whether two of the chosen events, of different gaps, are simultaneous."""
        phases, gaps = self.phases[chosen], self.gaps[chosen]
        after = np.append(phases[1:], phases[:1] + 2 * np.pi * self.cycles)
        return bool(((after - phases < AT_ONCE) & (np.roll(gaps, -1) != gaps)).any())

    @property
    def _is_settled(self) -> bool:
        """For a structure: whether it has impacts on coupled gaps at one instant, by the law of the structure, so
        that it is found by simulation alone."""
        meets = self.of_structure and self.structure.simultaneous and self._has_meetings
        return bool(meets and self.without_multipliers)

    @property
    def trivial(self) -> int | None:
        """For a self-excited motion: the index in `multipliers` of the 1 of a shift in time; otherwise None."""
        if not self.self_excited or np.isnan(self.multipliers).any():
            return None
        return int(np.abs(self.multipliers - 1).argmin())

    @property
    def _nontrivial(self) -> NDArray[np.complex128]:
        """All multipliers except the trivial one."""
        return (
            self.multipliers if self.trivial is None else np.delete(self.multipliers, self.trivial)
        )

    @property
    def q(self) -> _Array:
        """(n,) Coordinates just after the first impact."""
        return np.asarray(self.states[0, 0])

    @property
    def q_dot(self) -> _Array:
        """(n,) Velocities just after the first impact."""
        return np.asarray(self.states[0, 1])

    @property
    def attenuation(self) -> float:
        """For an oscillator: max|x|/A; if it is below 1 the impacts reduce the motion of the primary mass."""
        return max(-self.x_min, self.x_max) / self.A

    @property
    def load_phase(self) -> float:
        """For an oscillator: phase of the load at the first impact; the load is ``sin(r t + load_phase)``."""
        return float(load_phase_of(self.tau, self.osc.xi, self.r))

    @property
    def leading_kind(self) -> str | None:
        """The kind of the leading multiplier: "positive", "negative" or "complex" (None: unknown).

        If it crosses the unit circle, the bifurcation is a fold or pitchfork, a flip, or a Neimark-Sacker
        bifurcation, respectively.
        """
        leading = complex(next(iter(self._nontrivial), math.nan))
        if leading != leading:
            return None
        if leading.imag != 0:
            return "complex"
        return "positive" if leading.real >= 0 else "negative"

    @memory_for("a sample at the times t")
    def sample(self, t: ArrayLike, output: str | None = None) -> Any:
        """The positions and velocities at any times, from the closed form; the motion is periodic.

        Parameters
        ----------
        t : array_like
            Any finite times; for an oscillator in 1/omega, 0 at the first impact. For a structure, one list of
            times (m,), the load phase being Omega t. At an impact velocities and accelerations are those just
            after it.
        output : str, optional
            For a structure: the output to sample, in place of all coordinates.

        Returns
        -------
        Sample, or (q, q_dot) of a structure
            For an oscillator, arrays ``X, X_dot, Z, Z_dot, Y, load, X_ddot, Z_ddot``; Y is Z - X. For a structure
            coordinates and velocities (n, m), or displacement and velocity of the output (m,).

        Examples
        --------
        >>> import numpy as np, vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=0.94, clearance=37.0)[0]
        >>> history = motion.sample(np.linspace(0, motion.period, 400))
        >>> bool(np.all(abs(history.Y) <= 37.0 / 2 + 1e-12))
        True
        """
        if self.of_structure:
            run, times = self._within(t)
            return run.sample(times, output)
        refuse_output(output)
        times = checks.real_array(argument(self.osc, t, "t", "1/omega"), "t", "real times")
        if not np.isfinite(times).all():
            raise ParameterError(f"t = {t!r}: must be finite")
        if self.rest_events is None:
            values = _core.sample(*self._flights(), times.ravel())
            values[5] *= self.load
            return with_accelerations(self.osc, values.reshape((6, *times.shape)))
        starts, resting = segments(self.rest_events, self.clearance)
        wrapped = np.mod(times, self.period)
        return sample(self.osc, self.r, self.load, self.clearance, starts, resting, wrapped)

    @memory_for("a sample at the times t")
    def acceleration(self, t: ArrayLike, output: str | None = None) -> _Array:
        """The accelerations (n, m) at any times, between the impacts, as in `Trajectory.acceleration`.

        Parameters
        ----------
        t : array_like (m,)
            Any finite times, as in `sample`.
        output : str, optional
            As in `sample`.

        Returns
        -------
        ndarray (n, m)
            Accelerations of the coordinates, for an oscillator of its two masses; (m,) for an output.
        """
        if self.of_structure:
            run, times = self._within(t)
            return run.acceleration(times, output)
        refuse_output(output)
        found = self.sample(t)
        return np.array([found.X_ddot, found.Z_ddot])

    def _within(self, t: ArrayLike) -> tuple[Trajectory, _Array]:
        """For a structure: the period, and times within it for any times."""
        times = np.atleast_1d(
            checks.real_array(time_of(self.structure, t, "t"), "t", "finite times")
        )
        if times.ndim != 1 or not np.isfinite(times).all():
            raise ParameterError(f"t = {t!r}: must be finite times")
        run = self._run()
        return run, run.start + np.mod(times - run.start, self.period)

    @memory_for("quantities, by their window and harmonics")
    def quantities(self, harmonics: int = 10) -> Quantities:
        """Response quantities over a period: rms, extremes and harmonics, impacts and energies.

        Parameters
        ----------
        harmonics : int
            Harmonics of the load, 1 to 10000.

        Returns
        -------
        Quantities
            Their values over a period.

        Raises
        ------
        ParameterError, ParameterTypeError
            If the number of harmonics is not allowed.

        Examples
        --------
        Dashpot and impacts dissipate the work of the load:

        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> found = vi.equispaced(osc, r=0.94, clearance=37.0)[0].quantities()
        >>> round(found.x.rms, 4), round(found.x_ddot.peak, 4)
        (11.8761, 15.7311)
        >>> abs(found.work - found.damping_loss - found.impact_loss) < 1e-12 * found.work
        True
        """
        if self.of_structure:
            # impacts at the first instant of the period would be split between its ends
            whole = self.structure._is_rigid and (len(self.rests) or not self._has_meetings)
            whole = whole and not self._is_settled
            run = self._run() if whole else self._from_flight()
            return run.quantities(harmonics=harmonics)
        events = self.events
        starts, resting = segments(events, self.clearance)
        window = (starts[0, 0], starts[0, 0] + self.period)
        again = np.append(window[1], starts[1:, 0])
        return oscillator_quantities(
            self.osc, self.r, self.load, self.clearance, np.column_stack([starts, again]),
            np.append(resting, resting[0]), window, events, harmonics,
        )  # fmt: skip

    def plot(
        self, ax: Any = None, kind: str | None = None, cycles: float | None = None,
        window: ArrayLike | None = None,
        units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Draw the motion, or one panel of its figure, as in `Trajectory.plot` (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes for one panel; without it, a figure with all panels is made.
        kind : str, optional
            As in `Trajectory.plot`.
        cycles : float, optional
            Load cycles shown: for an oscillator, from the first impact on; by default one period, but at least two
            cycles. For a structure, the last cycles of a period.
        window : (float, float), optional
            For a structure: start and end of the time window drawn; by default one period.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes, or an array of Axes
            The Axes of the panel, or of all panels.
        """
        if self.of_structure:
            return self._run().plot(ax, kind, cycles, window, units)
        self._no_window(window)
        return self._draw(ax, kind, max(2, self.cycles) if cycles is None else cycles, units=units)

    def animate(
        self,
        path: str | os.PathLike[str] | None = None,
        cycles: float | None = None,
        seconds: float | None = None,
        window: ArrayLike | None = None,
        units: Units | str | None = None,
    ) -> Any:
        """Animate the motion; the wall or gap that is hit flashes (extra `plot`).

        Parameters
        ----------
        path : str or path, optional
            The file to write; it ends with .gif (Pillow) or .mp4 (the program ffmpeg, or the extra `film`).
        cycles : float, optional
            As in `plot`; by default one period, so that the animation can loop.
        seconds : float, optional
            Duration on the screen, as in `Trajectory.animate`.
        window : (float, float), optional
            As in `plot`.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Path
            The path of the file; without `path`, matplotlib's FuncAnimation, which a notebook displays with
            `to_jshtml()`.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=0.94, clearance=37.0)[0]
        >>> motion.animate("pair.gif", seconds=0.3).name
        'pair.gif'
        """
        if self.of_structure:
            return self._run().animate(path, cycles, seconds, window, units)
        self._no_window(window)
        return self._animate(
            path,
            self.cycles if cycles is None else cycles,
            None,
            3.0 if seconds is None else seconds,
            units=units,
        )

    def _no_window(self, window: Any) -> None:
        if window is not None:
            raise ParameterError(
                f"window = {window!r}: must be left out for an oscillator; give cycles"
            )

    def impact_maps(self) -> NDArray[np.float64]:
        """For an oscillator: the matrices [P_i] of (A7), (N, 4, 4).

        P_i is the derivative of the state (x, x', z', alpha) just after impact i+1 with respect to the state just
        after impact i. It is all zero where the impact has no approach speed.

        Returns
        -------
        ndarray (N, 4, 4)
            The matrices in the order of the impacts.
        """
        if self.of_structure:
            raise AttributeError(self._lack("impact_maps", "matrix"))
        if self.pattern.has_rest:
            raise ParameterError(
                f"pattern = {self.pattern.sides!r}: must be without rest, which has no finite list of [P_i]"
            )
        maps, _ = _core.impact_maps(*self._flights())
        return np.moveaxis(maps, 2, 0)

    def stability_matrix(self) -> NDArray[np.float64]:
        """The matrix [P] = [P_N] ... [P_1] of equation (32); for a structure `matrix`.

        Its eigenvalues are the multipliers.

        Returns
        -------
        ndarray (4, 4) or (2n, 2n)
            The derivative of the state after a period with respect to the state before it; if the order of
            simultaneous events matters, but not to the multipliers, that of one order.
        """
        if self.of_structure:
            return self.matrix
        product = np.eye(4)
        for matrix in self.impact_maps():
            product = matrix @ product
        return product

    def gradient(self, parameters: Sequence[Wanted] | None = None) -> Gradient:
        """The derivatives of all quantities of the exact motion with respect to parameters.

        The phases are functions of the parameters; the derivatives follow from the implicit-function theorem and
        the derivatives of [P_i], without difference quotients.

        For an oscillator, the parameters are r, clearance, xi, mu, R1, R2, R and load. R1 and R2 change the
        restitution of all impacts on their wall, R that of all impacts. In addition to attributes of the motion,
        the quantities are `load_phase`, `attenuation`, the response `x_rms`, `fundamental_amplitude` and
        `fundamental_phase` (as in `quantities`), and the distances to the boundaries of its zone:
        `approach_speeds` at the impacts; `gaps_right` and `gaps_left`, the least distance to each wall at a
        stationary point of the relative position in the flight after each impact (NaN if there is none); and
        `stability_margin`, which is 1 - max|lambda|.

        For a structure, the quantities are phases, speeds, impulses, ``q`` and ``q_dot``, the states just after
        the impacts, multipliers and `stability_margin`. With rest, the accumulations are summed to their limit. A
        self-excited motion also has `period`, and its phases are measured from the first event.

        Parameters
        ----------
        parameters : sequence, optional
            For a structure: names as in `branch`: 'frequency'; 'load', 'constant', 'mass', 'damping', 'stiffness'
            (factors, 1 for the motion); 'opening', 'restitution' (of all gaps, which change by the same amount);
            'opening_J', 'restitution_J' (of gap J); 'mass_I_J', 'damping_I_J', 'stiffness_I_J' (an entry, with its
            mirror image). For a `PowerLaw` the restitution is R0. Or tuples (name, function, value) with a smooth
            function that returns (Structure, Load), and the value of its argument at the motion; the function is
            called within 5 % of this value (within 0.05 if the value is 0). 'contact' or 'contact_J' is the
            stiffness of stops, 'slip' or 'slip_J' the slip level of friction, with the stick level in proportion,
            'stick' or 'stick_J' the stick level alone, and 'speed' or 'speed_J' that of a belt; 'wall' or 'wall_J'
            is a factor of the motions of walls. By default frequency, load, and all openings, motions of walls,
            coefficients of restitution, stiffnesses of stops and slip levels.

        Returns
        -------
        Gradient
            Entries are NaN, with a `status`, if a single quantity has no derivatives: multipliers that coincide,
            or a maximum that is reached twice, as in symmetric motions if only R1 changes. For a motion of an
            oscillator with rest or with more than 24 impacts, gaps, rms and fundamental are missing.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a parameter does not exist, or the load of an oscillator is 0.
        SingularError
            If the motion is at a fold, a pitchfork or a graze, if the order of simultaneous events matters, or if
            its phases are not exact (`exact` finds the exact motion nearby).

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> gradient = vi.equispaced(osc, 0.94, 37.0)[0].gradient()
        >>> round(float(gradient["attenuation", "clearance"]), 6)
        0.015041
        >>> gradient["X", "mu"].shape
        (2,)

        >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
        >>> motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
        >>> gradient = motion.gradient(["frequency", "mass_0_0"])
        >>> gradient["speeds", "frequency"].shape, gradient["q"].shape
        ((1,), (1, 1, 2))
        """
        found: Gradient
        if self.of_structure:
            found = ACTIONS["structure_motion_gradient"](self, parameters)
            return found
        if parameters is not None:
            raise ParameterTypeError(
                f"parameters = {parameters!r}: must be left out for an oscillator, whose parameters are all taken"
            )
        if not self.load > 0:
            raise ParameterError(f"load = {self.load!r}: must be above 0 to have derivatives")
        found = ACTIONS["motion_gradient"](self)
        return found

    def prove(self, *, progress: Callable[[float, str], None] | None = None) -> Any:
        """Prove the existence, admissibility and stability of this motion in ball arithmetic (extra `proof`).

        Each of these is proven, refuted or left undecided: existence and uniqueness in a box around these numbers,
        by Krawczyk's operator; that the masses approach at each impact and both gaps stay open in between; and
        stability, by the recursion of Schur and Cohn with the law of det[P]. Bounds on max|lambda| and max|x|/A
        are included. For a structure, only the bound on max|lambda| is included, and all gaps must stay open.

        Parameters
        ----------
        progress : callable, optional
            Called with the fraction of attempts made and the next number of bits; by default a bar on a terminal
            or in a notebook.

        Returns
        -------
        Certificate
            It holds for the parameters as decimal numbers: 0.028 is 28/1000. Undecided properties are None, with
            the reason in `undecided`.

        Raises
        ------
        ParameterError
            If it is a motion with rest or without a load, or of a structure with stops, friction, walls that
            move, R(v) or more than eight coordinates.
        MissingExtraError
            If python-flint is not installed.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> vi.equispaced(osc, r=0.94, clearance=37.0)[0].prove()
        <Certificate of RL/1 at r = 0.94, d K/F0 = 37.0: exists, admissible, not stable>
        """
        return ACTIONS["prove_motion"](self, progress=progress)

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` recompute the motion.

        The digits are the same if the motion was computed from phases. Otherwise the motion itself is the guess
        for Newton's method, which then returns it to within rounding. The case of an equispaced motion computes
        both motions of the pair.

        Returns
        -------
        str
            The groups &system and &motion, or those of a structure.
        """
        if not self.of_structure:
            return namelist.case(self.osc, self.r, motion=self._keys())
        if self.request is None:
            raise ParameterError(
                f"{self!r}: has no namelist, since it was computed with full=True or read from a file without one"
            )
        return namelist.text([*self._groups(), ("motion", self.request)])

    def _keys(self) -> dict[str, Any]:
        """For an oscillator: the group &motion that reproduces the motion."""
        if self.pattern.has_rest or self.load != 1.0:
            what = "rest" if self.pattern.has_rest else f"load = {self.load!r}"
            raise ParameterError(
                f"motion with {what}: has no namelist; a &simulate case can reach it"
            )
        keys: dict[str, Any] = {"kind": self.kind, "cycles": self.pattern.cycles}
        if self.kind == "equispaced":
            return keys | {"clearance": self.clearance, "precision": self.precision}
        phases = self.alpha if self.guess is None else self.guess
        keys |= {"sides": self.pattern.sides, "phases": phases.tolist()}
        right, left = self.osc.restitution
        if not np.array_equal(self.restitution, np.where(self.pattern.signs > 0, right, left)):
            keys["impact_restitution"] = self.restitution.tolist()
        if self.kind == "exact":
            keys["clearance"] = self.clearance
            if self.guess is None:
                keys |= {"positions": self.X.tolist(), "tau": self.tau}
            return keys
        if self.consistent != (self.residual <= ACCEPTANCE):
            # the acceptance was different: set it just above the residual, or just below
            kind = np.float32 if self.precision == "single" else np.float64
            limit = kind(self.residual)
            limit = limit if self.consistent else np.nextafter(limit, kind(0))
            keys["acceptance"] = min(1.0, float(limit))
        return keys | {"precision": self.precision}

    @property
    def _result(self) -> Result:
        """The tables of the motion, with the columns that the core declares for &motion."""
        try:
            case = self.to_namelist()
        except ParameterError:
            case = ""
        if self.of_structure:
            tables = self._tables_of_structure()
            return with_owners(self.structure, made("motion", case, tables))
        n, (right, left) = len(self.pattern), self.osc.restitution
        own: dict[str, Any] = {name: getattr(self, name) for name in OF_MOTION}
        own |= {name: CODES[getattr(self, name)] for name in VERDICTS}
        own |= {
            "motion": 1, "sides": self.pattern.sides, "cycles": self.pattern.cycles, "status": 0,
            "attenuation": self.attenuation if self.A > 0 else math.nan,
            "multipliers": self.multipliers, "xi": self.osc.xi, "mu": self.osc.mu, "R1": right,
            "R2": left, **units_of(self.osc),
        }  # fmt: skip
        impacts = {key: getattr(self, name) for name, key in OF_IMPACTS.items()}
        impacts |= {
            "impact": np.arange(1, n + 1),
            "side": self.pattern.symbols,
            "guess": self.guess,
        }
        tables = {"motions": ((), own), "impacts": (("impact",), impacts)}
        if self.rest_events is not None:
            tables["events"] = (("event",), event_columns(self.rest_events))
        return made("motion", case, tables)

    def _tables_of_structure(self) -> dict[str, Any]:
        n = self.structure.coordinates
        return {
            "impacts": (("impact",), {
                "impact": np.arange(1, len(self.gaps) + 1), "gap": self.gaps, "phase": self.phases,
                "speed": self.speeds, "impulse": self.impulses,
                "q": self.states[:, 0], "q_dot": self.states[:, 1],
            }),
            "motion": ((), {
                "cycles": self.cycles, "residual": self.residual, "determinant": self.determinant,
                "law": self.law, "frequency": self.load.frequency,
                **{name: CODES[getattr(self, name)] for name in VERDICTS},
            }),
            "multipliers": (("multiplier",), {"multiplier": self.multipliers}),
            "derivative": (("state_row",), {"P": np.reshape(self.matrix, (2 * n, 2 * n))}),
            "rests": (("rest",), {name: self.rests[name] for name in RESTS.names or ()}),
            **structure_tables(self.structure, self.load),
        }  # fmt: skip

    @classmethod
    def of_result(cls, result: Result) -> Motion:
        """The motion of a result that contains one motion.

        Parameters
        ----------
        result : Result
            The tables that the core or a file provides.

        Returns
        -------
        Motion
            The motion; verdicts that are not known are None.
        """
        if not result.of_structure:
            found = motions_of(result)
            if len(found) != 1:
                raise ParameterError(f"result with {len(found)} motions: must have one")
            return found[0]
        frequency = result.column("motion", "frequency").decoded().item()
        structure, load = structure_of(result, frequency, True)
        assert load is not None
        request = request_of(result, "motion", REQUEST, {"gaps", "phases", "kinds", "q", "q_dot"})
        check_gap_numbers(result, structure)
        return of_tables(result, structure, load, "motion", None, None, request)

    @property
    def kinds(self) -> tuple[str, ...]:
        """What happens at each of `phases`, in words as in `Trajectory.events`.

        "impact"; with stops or friction also "touch", "leave", "let_go" and "press" of a stop, and "halt",
        "slip_up" and "slip_down" of friction, where a slip that follows the opposite one is a reversal.

        Raises
        ------
        SingularError
            If the motion has stops or friction and is not admissible, unless the kinds of its events were given.
        """
        if not self.of_structure or self.structure._is_rigid:
            return ("impact",) * len(self.phases)
        if self.request and self.request.get("kinds"):
            return tuple(k for k in self.request["kinds"] if k not in ("stick", "release"))
        events = self._from_flight().events
        whole = 2 * np.pi * self.cycles
        found = []
        for phase, gap in zip(self.phases, self.gaps, strict=True):
            own = events[(events["gap"] == gap) & ~np.isin(events["kind"], ["stick", "release"])]
            apart = np.mod(own["time"] * self.load.frequency - phase + whole / 2, whole) - whole / 2
            found.append(str(own["kind"][np.abs(apart).argmin()]))
        return tuple(found)

    def _run(self) -> Trajectory:
        """For a structure: the trajectory over a period from just after the first impact, built from the flights
        and rests.

        It is not simulated: a simulation would diverge from an unstable motion, would stop at the first gap that
        an inadmissible motion closes in between, and could not restart from a gap that is closed to within
        rounding.
        """
        if not self.structure._is_rigid or (len(self.rests) and self._is_settled):
            return self._simulated()
        n, count = self.structure.coordinates, len(self.phases)
        times = self.phases / self.load.frequency
        times = np.append(times, times[0] + self.period)
        numbers = np.arange(1, count + 1) % count
        kinds = ["impact"] * count
        gaps, clock = self.gaps[numbers].tolist(), times[1:].tolist()
        # a rest begins with the last impact of its accumulation, with no other event in between; among
        # simultaneous events, releases come last
        keys = [(times[i], i, False) for i in range(1, count + 1)]
        whole = 2 * np.pi * self.cycles
        for gap, begin, end in self.rests.tolist():
            since = np.mod(begin - self.phases + AT_ONCE, whole) - AT_ONCE
            since[self.gaps != gap] = whole
            last = count - 1 - int(since[::-1].argmin())
            if since[last] < SHORT:
                stick = float(times[last] + max(0.0, since[last]) / self.load.frequency)
                keys.append((times[last], last, True))
            else:
                stick = float(
                    times[0] + np.mod(begin - self.phases[0], whole) / self.load.frequency
                )
                keys.append((stick, count, True))
            kinds += ["stick", "release"]
            gaps += [gap, gap]
            clock += [stick, stick + (end - begin) / self.load.frequency]
            keys.append((clock[-1], count + 1, False))
        sequence = sorted(range(len(keys)), key=keys.__getitem__)
        events = np.zeros(len(sequence), EVENTS_OF_STRUCTURE)
        events["time"], events["kind"] = np.array(clock)[sequence], np.array(kinds)[sequence]
        events["gap"] = np.array(gaps)[sequence]
        hit = events["kind"] == "impact"
        events["speed"][hit], events["impulse"][hit] = self.speeds[numbers], self.impulses[numbers]
        starts, labels = segments_of_events(
            float(times[0]), self.states[0], events, np.zeros((len(events), 2, n))
        )
        starts[1:, 1:][:, hit] = self.states[numbers].reshape(count, 2 * n).T
        if len(self.rests):
            system = core_arrays(self.structure, self.load)[:6]
            raise_status(_core.complete_rests(*system, labels, starts))
        states = starts[1:, 1:].T.reshape(len(events), 2, n)
        first = (self.q, self.q_dot)
        return Trajectory(
            structure=self.structure, load=self.load, start=float(times[0]), end=float(times[-1]), events=events,
            states=states, initial_state=first, final_state=first, complete=True, request=None, cut="",
            permanent=(),
        )  # fmt: skip

    def _simulated(self) -> Trajectory:
        """For a structure with stops or friction, or with rests and coupled gaps that close at the same instant:
        the simulated trajectory over a period from just after the first event.

        The first event may occur again at the start, where its condition is met to within rounding.
        """
        if self.admissible is False:
            raise SingularError(
                f"{self!r}: it is not admissible, and with stops, friction or simultaneous impacts a motion is "
                "sampled by simulation"
            )
        start = float(self.phases[0] / self.load.frequency)
        return simulate_structure(
            self.structure, self.load, duration=self.period, state=(self.q, self.q_dot), start=start
        )

    def _from_flight(self) -> Trajectory:
        """For a structure: the simulated trajectory over a period from the middle of the longest flight; it
        contains each event once."""
        start, state = self._run()._between_events()
        return simulate_structure(
            self.structure, self.load, duration=self.period, state=state, start=start
        )

    def _facts(self) -> dict[str, str]:
        if self.of_structure:
            return {"coordinates": str(self.structure.coordinates), "impacts": str(len(self.gaps))}
        shown = ", ".join(f"{phase:.4g}" for phase in self.alpha[:12] / np.pi)
        return {
            "x": range_text(self.osc, "x", self.x_min, self.x_max),
            "max|x|/A": f"{self.attenuation:.4g}" if self.A > 0 else "-",
            "α/π": shown + (", …" if len(self.alpha) > 12 else ""),
            "|λ|": ", ".join(f"{size:.4g}" for size in np.abs(self.multipliers)),
            "residual": f"{self.residual:.1e}",
        }

    def verdicts(self) -> str:
        """The three verdicts as a text, with the numbers behind them.

        Returns
        -------
        str
            Such as "consistent, admissible, stable (max|lambda| = 0.9232, complex)".
        """
        words = [
            {True: name, False: f"not {name}", None: f"{name}?"}[value]
            for name, value in (("consistent", self.consistent), ("admissible", self.admissible))
        ]
        if self.consistent is False:
            words[0] += f" (residual {self.residual:.2g})"
        modulus = np.abs(self._nontrivial).max(initial=0.0)
        if self.trivial is not None and modulus < np.finfo(float).eps:
            modulus = 0.0  # friction that sticks removes a direction
        stability = {True: "stable", False: "unstable", None: "stable?"}[self.stable]
        apart = "" if self.trivial is None else " apart from 1"
        known = f"max|lambda| = {modulus:.4g}{apart}, {self.leading_kind}"
        words.append(f"{stability} ({'no derivative' if np.isnan(modulus) else known})")
        return ", ".join(words)

    def __repr__(self) -> str:
        # one line on a terminal: "consistent" and the kind of multiplier are only in `str`
        verdicts = (
            self.verdicts().removeprefix("consistent, ").replace(f", {self.leading_kind})", ")")
        )
        if self.of_structure:
            one = "impact" if self.structure._is_rigid else "event"
            counts = [(len(self.phases), one), (len(self.rests), "rest")]
            parts = [f"{n} {name}{'s' * (n != 1)}" for n, name in counts if n]
            cycles = f"{self.cycles} cycle{'s' * (self.cycles != 1)}"
            if self.self_excited:
                cycles = f"a period of {self.period:.6g}"
            return f"<Motion of {' and '.join(parts)} in {cycles}: {verdicts}>"
        single = ", single precision" if self.precision == "single" else ""
        return (
            f"<Motion {self.pattern.sides}/{self.pattern.cycles} at "
            f"{place_text(self.osc, self.r, self.clearance)}{single}: {verdicts}>"
        )

    def __str__(self) -> str:
        if self.of_structure:
            return repr(self)
        n = len(self.pattern)
        cycles = "cycle" if self.pattern.cycles == 1 else f"{self.pattern.cycles} cycles"
        units = units_to_show(self.osc)
        length, speed = (1.0, 1.0) if units is None else (units.length, units.velocity)
        names = (
            "" if units is None
            else f"   X, Z, A, x in {units.name('F0/K')}, X', Z' in {units.name('omega F0/K')}"
        )  # fmt: skip
        lines = [
            f"{n} impacts/{cycles}, sides {self.pattern.sides}{names}",
            f"  {place_text(self.osc, self.r, self.clearance, 10)}   A = {self.A * length:.6g}   "
            f"tau/pi = {self.tau / math.pi:.6g}",
            f"  {self.verdicts()}",
            f"  residual = {self.residual:.2e}   x from {self.x_min * length:.6g} to {self.x_max * length:.6g}   "
            f"max|x|/A = {self.attenuation:.6g}",
            "  side  alpha/pi          X          Z  X' before   X' after  Z' before   Z' after",
        ]
        columns = zip(
            self.pattern.symbols, self.alpha / math.pi, self.X * length, self.Z * length,
            self.X_dot_before * speed, self.X_dot_after * speed, self.Z_dot_before * speed,
            self.Z_dot_after * speed, strict=True,
        )  # fmt: skip
        for side, *numbers in columns:
            lines.append(
                f"  {side:>4}  {numbers[0]:8.5f}" + "".join(f" {x:10.4f}" for x in numbers[1:])
            )
        return "\n".join(lines)

    def _flights(self) -> _Flights:
        """The leading arguments of the core's procedures on a finished motion."""
        columns = (
            self.X, self.Z, self.X_dot_before, self.X_dot_after, self.Z_dot_before, self.Z_dot_after,
        )  # fmt: skip
        impacts = np.stack(columns, axis=1)
        return (
            self.osc.xi, self.osc.mu, self.r, self.pattern.cycles, self.pattern.signs,
            self.restitution, self.alpha, impacts, self.A, self.tau,
        )  # fmt: skip


class MotionSet(Noun, study="motion", formerly="StructureMotionResult"):
    """The motions of a &motion case: two for the equispaced kind, otherwise one; none if there is no such
    motion."""

    __slots__ = ()
    printable = True

    def parts(self) -> list[Motion]:
        """The motions."""
        if not self.of_structure:
            return motions_of(self._result)
        return [] if self._result.empty else [Motion.of_result(self._result)]

    def require(self) -> None:
        """SingularError if the motion cannot be computed."""
        if self.of_structure:
            if self._result.empty:
                raise SingularError(self._result.notes[0][1])
            return
        codes = self._result.column("motions", "status").values.tolist()
        if all(codes) and codes[0] != NO_MOTION:
            raise_status(codes[0])

    def __repr__(self) -> str:
        return f"<MotionSet: {', '.join(map(repr, self.parts())) or 'none'}>"


def motions_of(result: Result, osc: Oscillator | None = None) -> list[Motion]:
    """The motions in the core's tables, without those that failed.

    Parameters
    ----------
    osc : Oscillator, optional
        The system, if the caller has it.
    """
    names = (*OF_MOTION, *VERDICTS, "sides", "cycles", "status")
    fields = {name: result.column("motions", name).decoded().ravel().tolist() for name in names}
    multipliers = result.column("motions", "multipliers").values
    if multipliers.size and multipliers.shape[-1] != 4:
        raise ParameterError(
            f"motions.multipliers of shape {multipliers.shape}: must have 4 in a row"
        )
    multipliers = multipliers.reshape(-1, 4)
    columns = {name: result.column("impacts", key).values for name, key in OF_IMPACTS.items()}
    if "guess" in result.tables["impacts"].columns:
        columns["guess"] = result.column("impacts", "guess").values
    n = len(multipliers)
    own = runs(result.tables["impacts"], n)
    events = result.tables.get("events", Table({}))
    resting = runs(events, n) if events.columns else [slice(0, 0)] * n
    found = []
    for i in range(n):
        if fields["status"][i]:
            continue
        values: dict[str, Any] = {name: fields[name][i] for name in OF_MOTION}
        values |= {name: VERDICT[fields[name][i]] for name in VERDICTS}
        values |= {name: column[own[i]] for name, column in columns.items()}
        pattern = Pattern(fields["sides"][i], fields["cycles"][i])
        if len(values["X"]) != len(pattern):
            raise ParameterError(
                f"impacts.X of shape ({len(values['X'])},): must be one number for each of {pattern.sides}"
            )
        rest_events = events_of(result, resting[i]) if pattern.has_rest else None
        found.append(
            Motion(
                osc=osc or osc_of(result, "motions", i), pattern=pattern, multipliers=multipliers[i],
                rest_events=rest_events, **{"guess": None} | values,
            )
        )  # fmt: skip
    return found


def of_tables(
    result: Result, structure: Structure, load: Load, table: str, row: int | None,
    parts: Sequence[slice] | None, request: dict[str, Any] | None,
) -> Motion:  # fmt: skip
    """A motion of a structure from the core's tables: the rows `parts` of impacts, multipliers, derivative and
    rests, and a row of the table of motions."""
    whole = slice(None)
    impacts, multipliers, derivative, rests = parts or [whole] * 4

    def rows(name: str, part: slice, *columns: str) -> list[Any]:
        return [result.column(name, column).decoded()[part] for column in columns]

    own = {
        name: result.column(table, name).decoded()[() if row is None else row].item()
        for name in (*OF_STRUCTURE, *VERDICTS)
    }
    own |= {name: VERDICT[int(own[name])] for name in VERDICTS}
    columns = rows("impacts", impacts, *IMPACTS_OF_STRUCTURE.values())
    own |= dict(zip(IMPACTS_OF_STRUCTURE, columns, strict=True))
    states = np.stack(rows("impacts", impacts, "q", "q_dot"), axis=1)
    gap, begin, end = rows("rests", rests, *(RESTS.names or ()))
    (matrix,), (values,) = (
        rows("derivative", derivative, "P"), rows("multipliers", multipliers, "multiplier")
    )  # fmt: skip
    check_numbers(own["cycles"], own["phases"], states, values, matrix)
    table_of_rests = rests_of(gap, (begin, end))
    for array in (states, table_of_rests):
        array.flags.writeable = False
    return Motion(
        structure=structure, load=load, states=states, matrix=matrix, multipliers=values, rests=table_of_rests,
        request=request, **own,
    )  # fmt: skip


def motion_of_oscillator(
    osc: Oscillator, r: float, clearance: float, load: float, pattern: Pattern, restitution: _Array, alpha: _Array,
    impacts: _Array, scalars: _Array, multipliers: NDArray[np.complex128], verdicts: NDArray[np.int32],
    precision: str = "double", kind: str = "exact", guess: _Array | None = None,
    rest_events: NDArray[Any] | None = None,
) -> Motion:  # fmt: skip
    """A motion of an oscillator from the arrays of the core, read-only: impacts (N, 6), and scalars."""
    for array in (alpha, impacts, multipliers):
        array.flags.writeable = False
    _, amplitude, tau, residual, x_min, x_max = scalars.tolist()
    consistent, admissible, stable = verdicts.tolist()
    return Motion(
        osc=osc, r=r, clearance=clearance, load=load, pattern=pattern, restitution=restitution, alpha=alpha,
        X=impacts[:, 0], Z=impacts[:, 1], X_dot_before=impacts[:, 2], X_dot_after=impacts[:, 3],
        Z_dot_before=impacts[:, 4], Z_dot_after=impacts[:, 5], A=amplitude, tau=tau, residual=residual,
        multipliers=multipliers, consistent=VERDICT[consistent], admissible=VERDICT[admissible],
        stable=VERDICT[stable], x_min=x_min, x_max=x_max, precision=precision, kind=kind, guess=guess,
        rest_events=rest_events,
    )  # fmt: skip


def motion_of_structure(
    structure: Structure, load: Load, gaps: NDArray[np.int32], cycles: int, impacts: _Array,
    states: _Array, matrix: _Array, multipliers: NDArray[np.complex128], scalars: _Array,
    verdicts: NDArray[np.int32], rests: NDArray[Any], request: dict[str, Any] | None,
) -> Motion:  # fmt: skip
    """A motion of a structure from the arrays of the core, read-only."""
    phases, speeds, impulses = (np.ascontiguousarray(impacts[:, i]) for i in range(3))
    states = np.ascontiguousarray(states.T).reshape(len(gaps), 2, structure.coordinates)
    for array in (gaps, phases, speeds, impulses, states, matrix, multipliers, rests):
        array.flags.writeable = False
    residual, determinant, law = scalars.tolist()
    return Motion(
        structure=structure, load=load, gaps=gaps, cycles=cycles, phases=phases, speeds=speeds, impulses=impulses,
        states=states, residual=residual, matrix=matrix, multipliers=multipliers, determinant=determinant, law=law,
        rests=rests, request=request, **dict(zip(VERDICTS, (VERDICT[int(v)] for v in verdicts), strict=True)),
    )  # fmt: skip


def rests_of(gaps: Any = (), phases: Any = ((), ())) -> NDArray[Any]:
    """The table of rests."""
    table = np.zeros(len(gaps), RESTS)
    table["gap"], table["begin"], table["end"] = gaps, phases[0], phases[1]
    return table


def check_numbers(
    cycles: int, phases: _Array, states: _Array, multipliers: NDArray[Any], matrix: _Array
) -> None:
    """Raises an error unless the numbers of a motion from a file are possible for a motion."""
    checks.integer(cycles, "motion.cycles", 1, 10_000)
    n = 2 * states.shape[-1]
    if matrix.shape != (n, n) or multipliers.shape != (n,):
        raise ParameterError(
            f"derivative.P of shape {matrix.shape}, {multipliers.size} multipliers: must be for {n} numbers of a "
            "state"
        )
    good = phases.size and np.isfinite(phases).all() and np.abs(phases).max() <= MOST_PHASE
    if not good or (np.diff(phases) < 0).any() or np.ptp(phases) > 2 * np.pi * cycles:
        raise ParameterError(
            f"impacts.phase = {phases[:9].tolist()}: must be finite, ascending, and within {cycles} load cycles"
        )
    if not np.isfinite(states).all():
        raise ParameterError("impacts.q, impacts.q_dot: must be finite numbers")


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Motions:
    """Many motions of one pattern as arrays, with points on the last axis; indexing returns a `Motion`.

    Attributes
    ----------
    osc, pattern, restitution, precision
        As in `Motion`, common to all points.
    r : ndarray (M,)
    alpha : ndarray (N, M)
    X, Z, X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N, M)
    clearance, A, tau, residual, x_min, x_max : ndarray (M,)
    multipliers : ndarray (4, M) of complex
    consistent, admissible, stable : ndarray (M,) of int8
        1, 0, or -1 for "not computed".
    status : ndarray (M,) of int
        0 where the motion was computed; other codes are explained by `status_text`. The numbers of
        a failed point are NaN.
    """

    study: ClassVar[str] = "motion"
    osc: Oscillator
    r: NDArray[np.float64]
    clearance: NDArray[np.float64]
    pattern: Pattern
    restitution: NDArray[np.float64]
    alpha: NDArray[np.float64]
    X: NDArray[np.float64]
    Z: NDArray[np.float64]
    X_dot_before: NDArray[np.float64]
    X_dot_after: NDArray[np.float64]
    Z_dot_before: NDArray[np.float64]
    Z_dot_after: NDArray[np.float64]
    A: NDArray[np.float64]
    tau: NDArray[np.float64]
    residual: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    consistent: NDArray[np.int8]
    admissible: NDArray[np.int8]
    stable: NDArray[np.int8]
    x_min: NDArray[np.float64]
    x_max: NDArray[np.float64]
    status: NDArray[np.int32]
    precision: str

    @property
    def load_phase(self) -> NDArray[np.float64]:
        """Phase of the load at the first impact of each motion."""
        found: NDArray[np.float64] = load_phase_of(self.tau, self.osc.xi, self.r)
        return found

    @property
    def phases(self) -> NDArray[np.float64]:
        """(N, M) Load phases of the impacts, as in `Motion`."""
        return _phases(self)

    @property
    def attenuation(self) -> NDArray[np.float64]:
        """Attenuation max|x|/A of each motion (M,)."""
        return np.maximum(-self.x_min, self.x_max) / self.A

    def __len__(self) -> int:
        return len(self.status)

    @overload
    def __getitem__(self, index: int) -> Motion: ...
    @overload
    def __getitem__(self, index: slice) -> list[Motion]: ...
    def __getitem__(self, index: Any) -> Any:
        """One motion, or a list of them for a slice; raises SingularError if that point failed."""
        places = checks.place(index, len(self), "motion")
        if isinstance(places, range):
            return [self[j] for j in places]
        index = places
        raise_status(int(self.status[index]))
        values: dict[str, Any] = {}
        for item in fields(self):
            if item.name == "status":
                continue
            value = getattr(self, item.name)
            if item.name in ("consistent", "admissible", "stable"):
                value = VERDICT[int(value[index])]
            elif isinstance(value, np.ndarray) and item.name != "restitution":
                value = value[..., index]
                value = float(value) if value.ndim == 0 else value
            values[item.name] = value
        return Motion(**values, kind="periodic", load=1.0, guess=None, rest_events=None)

    def __repr__(self) -> str:
        good = self.status == 0
        all_three = good & (self.consistent == 1) & (self.admissible == 1) & (self.stable == 1)
        return (
            f"<Motions {self.pattern.sides}/{self.pattern.cycles}: {len(self)} points, {good.sum()} computed, "
            f"{all_three.sum()} consistent, admissible and stable>"
        )
