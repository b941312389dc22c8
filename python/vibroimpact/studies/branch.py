"""Branches: how an exact motion changes along a parameter, with its bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.actions import ACTIONS
from ..base.errors import ParameterError, SingularError, StudyInterrupted
from ..base.spacing import in_order
from ..base.status import VERDICT
from ..motions.exact import self_excited_from, settled
from ..motions.motion import VERDICTS, Motion, load_phase_of, motion_of_oscillator
from ..motions.periodic import impact_restitution, motion_from_phases, motion_with_events
from ..motions.trajectory import simulate_structure
from ..results import door, namelist
from ..results.noun import Noun, column
from ..results.parameters import Parameter, Path, keys_of_parameter, of_constant_load
from ..results.systems import structure_of
from ..results.tables import Result
from ..systems.oscillator import Pattern
from ..systems.structure import Load, Structure
from ..systems.units import OF_STRUCTURE, of_parameter, place_text, range_text, value_text
from ..systems.verbs import every_system, physical_arguments
from .switching import KINDS, switched

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Branch", "Branches", "SpecialPoint", "branch"]

_Array = NDArray[np.float64]
_Found = TypeVar("_Found", bound=Noun)
#: The columns of impacts and of the motion, in the order of the core's arrays of motions.
FLIGHTS = ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after")
#: Phases of events (rad) that differ by less are those of events that meet.
MEETING = 1e-6
SCALARS = ("clearance", "A", "tau", "residual", "x_min", "x_max")


@dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint:
    """A bifurcation, or an end, of a branch.

    Attributes
    ----------
    type : str
        fold, pitchfork, flip, neimark_sacker, grazing, zero_approach, or bound (of the parameter). For a structure
        also branch_point (a pitchfork or transcritical point where simultaneous impacts separate), simultaneous
        (two events at the same instant, beyond which their order changes), rest_vanishes (the impacts before a
        rest just fail to accumulate), rest_splits (the contact force touches zero within a rest), stick_begins
        (friction that changes its direction begins to stick), stick_vanishes, contact_vanishes and flight_vanishes
        (the duration of a stick, of a contact with a stop, or of the flight between two contacts with one stop
        falls to zero), and event_vanishes (the speed or the force that makes friction halt or slip only just
        reaches its limit).
    index : int
        Index of the point in the branch.
    detail : str
        A text: which flight touches which wall or gap, which impact, or which bound.
    branch : Branch
    parameter : str
        The parameter of the branch.
    value : float
        The value of the parameter at the point.
    motion : Motion
    r, clearance : float
        For an oscillator.
    impact : int
        For an oscillator: at a grazing, the flight after this impact (from 0) touches a wall; at a zero_approach,
        the index of the impact.
    side : str
        For an oscillator: at a grazing, the wall that is touched, "R" or "L"; otherwise "".
    """

    study: ClassVar[str] = "branch"
    type: str
    index: int
    detail: str
    branch: Branch

    @property
    def _result(self) -> Result:
        """The tables of the branch."""
        return self.branch._result

    @property
    def parameter(self) -> str:
        """The parameter of the branch."""
        return self.branch.parameter

    @property
    def value(self) -> float:
        """The value of the parameter at the point."""
        return float(self.branch.values[self.index])

    @cached_property
    def motion(self) -> Any:
        """The exact motion at the point."""
        return self.branch[self.index]

    @property
    def r(self) -> float:
        """For an oscillator: the frequency ratio Omega/omega."""
        return float(self.branch.r[self.index])

    @property
    def clearance(self) -> float:
        """For an oscillator: the clearance d K/F0."""
        return float(self.branch.clearance[self.index])

    @property
    def impact(self) -> int:
        """For an oscillator: the impact, from 0, that begins the grazing flight or has no approach speed."""
        return int(self.branch._values("points", "special_impact", "impact")[self.index]) - 1

    @property
    def side(self) -> str:
        """For an oscillator: the wall that a grazing flight touches, "R" or "L"; otherwise ""."""
        return str(self.branch._values("points", "special_side", "side")[self.index])

    def switch(self) -> list[Motion]:
        """For an oscillator: motions of the branches that begin at this point.

        At a pitchfork these are the unsymmetric pair, at a flip the motion of doubled period, at a grazing the
        motion whose pattern has the extra impact (for a symmetric motion, also the motion with this impact and its
        mirror image). Each is computed at a parameter value slightly off the point, on the side where the motion
        exists.

        Returns
        -------
        list of Motion
            Empty if no such motion was found near the point. Follow the motions with `branch`.

        Raises
        ------
        AttributeError
            If it is a point of a structure.
        """
        if self.branch.of_structure:
            raise AttributeError(self.branch._lack("switch", "motion"))
        if self.type not in KINDS:
            return []
        return switched(self.motion, self.type, self.impact, self.side, self.parameter)

    def __repr__(self) -> str:
        place = f"{self.parameter} = {value_text(self.branch._system, self.branch._shown, self.value, 10)}"
        if not self.branch.of_structure:
            own = "" if self.parameter in ("r", "clearance") else f", {place}"
            place = place_text(self.branch.osc, self.r, self.clearance, 10) + own
        return f"<{self.type} at {place}>"


class Followed(Noun, part=True):
    """The common base of branches and zones: for a structure they contain the motion from which they start."""

    __slots__ = ("__dict__",)
    #: The table of the motion from which the branch or zone starts.
    _of_start: ClassVar[str]

    @property
    def gaps(self) -> NDArray[np.int32]:
        """For a structure: the gap of each impact (N,), from 0."""
        return np.asarray(self._values(self._of_start, "gaps")[0]).astype(np.int32)

    @property
    def resting(self) -> NDArray[np.int32]:
        """For a structure: the gap of each rest (R,), from 0, in the order in which they end."""
        if not self.of_structure:
            raise AttributeError(self._lack("resting", "pattern, whose rests are marked by *"))
        if "resting" not in self._result.tables[self._of_start].columns:
            return np.zeros(0, np.int32)
        return np.asarray(self._values(self._of_start, "resting")[0]).astype(np.int32)

    @property
    def cycles(self) -> int:
        """Load cycles in a period."""
        if self.of_structure:
            return int(self._values(self._of_start, "cycles")[0])
        return int(self.keys["cycles"])

    @property
    def self_excited(self) -> bool:
        """Whether the motions are self-excited, so that their period is a result."""
        tables = self._result.tables
        return self.of_structure and any(
            "period" in tables[name].columns
            for name in ("points", "vertices", "motions")
            if name in tables
        )

    @cached_property
    def _start(self) -> tuple[Structure, Load]:
        frequency = float(self._values(self._of_start, "frequency", "structure")[0])
        structure, load = structure_of(self._result, frequency, True)
        assert load is not None
        return structure, load

    def _check_read(self) -> None:
        super()._check_read()
        if self.of_structure and not self._result.empty:
            checks.integer(self.cycles, f"{self._of_start}.cycles", 1, 10_000)

    @property
    def structure(self) -> Structure:
        """For a structure: the structure of the motion at the start."""
        return self._start[0]

    @property
    def load(self) -> Any:
        """The load of the motion at the start, for a structure; 1 for an oscillator."""
        return self._start[1] if self.of_structure else 1.0


class Branch(Followed, study="branch", part=True, formerly="StructureBranch"):
    """A family of exact motions along one parameter, as columns; the last axis runs over the points.

    Indexing returns the motion at a point, computed from the instants of its events: given these, everything else
    follows from linear equations. A motion with rests, or a self-excited motion, is instead simulated from the
    point and must be admissible. The points are in order along the curve: the parameter turns back at folds.

    Attributes
    ----------
    parameter : str
        Name of the parameter; "function" for a function.
    values : ndarray (M,)
        The parameter.
    cycles : int
        Load cycles in a period.
    phases : ndarray (N, M)
        Load phases of the impacts (rad), as in `Motion`; for self-excited motions, 2 pi times the fraction of the
        period since the event just before the longest flight.
    multipliers : ndarray (4, M) or (2n, M) of complex
        Multipliers; NaN at a "zero_approach", where the derivative of the map over the period does not exist.
    period : ndarray (M,)
        The period as a time, for an oscillator in units of 1/omega. For self-excited motions it is a result.
    residual : ndarray (M,)
    consistent, admissible, stable : ndarray (M,) of int
        1, 0, or -1 where not known.
    special_points : list of SpecialPoint
        In the order of the branch.
    ends : (str, str)
        Why the branch ends, at its first and last point: "bound of the parameter", "meets a motion that repeats
        itself", "two impacts at one instant" (on one wall: the special point there is the last motion that is
        accurate to rounding), "a rest vanishes", "two events at one instant" (a rest ends at another event),
        "friction begins to stick", "a stick vanishes", "a contact vanishes", "a flight vanishes",
        "a halt or a slip vanishes", "closed", "full", "stopped", or "cannot be followed".
    osc, pattern : Oscillator, Pattern
        For an oscillator.
    symmetric : bool
        For an oscillator: whether the motions are their own mirror images half a period later (followed as such).
    r, clearance, xi, mu, R1, R2, A, tau, x_min, x_max, attenuation : ndarray (M,)
        For an oscillator.
    alpha, X, Z, X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N, M)
        For an oscillator, at the impacts; alpha are their phases from the first one on.
    structure : Structure
        For a structure: at the start.
    load : float, or Load
        1 for an oscillator; the load at the start for a structure.
    gaps : ndarray (N,)
        For a structure: the gap of each impact, from 0. With rests, only the first impacts of each accumulation
        are listed.
    resting : ndarray (R,)
        For a structure: the gap of each rest, from 0, in the order in which they end.
    rests : ndarray (R, 2, M)
        For a structure: the load phases at which each rest begins and ends.
    speeds, impulses : ndarray (N, M)
        For a structure: approach speeds and impulses.
    q_min, q_max : ndarray (n, M)
        For a structure: least and greatest value of each coordinate over the period.
    case : str
        The case as a namelist.
    complete : bool
        False if an end is "full" or "stopped"; `cut` then says how far it got.
    """

    __slots__ = ()
    _of_start = "branch"
    r = column("points")
    clearance = column("points")
    xi = column("points")
    mu = column("points")
    R1 = column("points")
    R2 = column("points")
    X = column("points", first=True)
    Z = column("points", first=True)
    X_dot_before = column("points", first=True)
    X_dot_after = column("points", first=True)
    Z_dot_before = column("points", first=True)
    Z_dot_after = column("points", first=True)
    A = column("points")
    tau = column("points")
    residual = column("points")
    x_min = column("points")
    x_max = column("points")
    attenuation = column("points")
    speeds = column("points", first=True)
    impulses = column("points", first=True)
    q_min = column("points", first=True)
    q_max = column("points", first=True)
    multipliers = column("points", first=True)
    consistent = column("points")
    admissible = column("points")
    stable = column("points")

    @property
    def alpha(self) -> _Array:
        """For an oscillator: phase of each impact (N, M) from the first one on, in radians."""
        if self.of_structure:
            raise AttributeError(self._lack("alpha", "phases"))
        return np.moveaxis(self._values("points", "phases"), -1, 0)

    @property
    def phases(self) -> _Array:
        """Load phase of each impact (N, M), in radians."""
        if self.of_structure:
            return np.moveaxis(self._values("points", "phases"), -1, 0)
        first: _Array = np.mod(load_phase_of(self.tau, self.xi, self.r), 2 * np.pi)
        return self.alpha + first

    @property
    def period(self) -> _Array:
        """Period at each point (M,) as a time; for an oscillator in 1/omega."""
        if self.self_excited:
            return self._values("points", "period")
        if not self.of_structure:
            return 2 * np.pi * self.cycles / self.r
        frequency = [self.at(value)[1].frequency for value in self.values.tolist()]
        return 2 * np.pi * self.cycles / np.array(frequency)

    @property
    def parameter(self) -> str:
        """Name of the parameter; "function" for a function."""
        return str(self.keys["parameter"])

    @property
    def pattern(self) -> Pattern:
        """For an oscillator: the pattern of all motions."""
        if self.of_structure:
            raise AttributeError(self._lack("pattern", "gaps and cycles"))
        return Pattern(self.keys.get("sides", "RL"), self.cycles)

    @property
    def symmetric(self) -> bool:
        """Whether the motions are their own mirror images half a period later."""
        return bool(self._values("branches", "symmetric")[0])

    @property
    def cut(self) -> str:
        """How far the branch got, if it was stopped or reached `max_points`; "" if it is complete."""
        full = f"max_points = {self.keys['max_points']} was reached"
        return super().cut or (full if "full" in self.ends else "")

    @property
    def complete(self) -> bool:
        """Whether neither end is "full" or "stopped"; `cut` otherwise says how far it got."""
        return not self.cut

    @property
    def ends(self) -> tuple[str, str]:
        """Why the branch ends, at its first and at its last point."""
        table = "branch" if self.of_structure else "branches"
        first, last = (self._values(table, name)[0] for name in ("first_end", "last_end"))
        return str(first), str(last)

    @property
    def values(self) -> _Array:
        """The parameter along the branch."""
        if self.of_structure:
            return self._values("points", "value")
        name = "R1" if self.parameter == "restitution" else self.parameter
        values: _Array = getattr(self, name)
        return values

    @property
    def special_points(self) -> list[SpecialPoint]:
        """Bifurcations and ends, in the order of the branch."""
        types, details = (self._values("points", name) for name in ("special", "detail"))
        return [
            SpecialPoint(str(types[i]), i, str(details[i]), self)
            for i in np.flatnonzero(types != "").tolist()
        ]

    @property
    def rests(self) -> _Array:
        """For a structure: load phases (R, 2, M), in radians, at which each rest begins and ends."""
        if not len(self.resting):
            return np.zeros((0, 2, len(self)))
        both = [self._values("points", name) for name in ("rest_begin", "rest_end")]
        return np.moveaxis(np.stack(both, axis=1), 0, -1).swapaxes(0, 1)

    @property
    def _shown(self) -> str:
        """The parameter that sets the unit of values; "" without one, as for the load factor of a structure."""
        known = not self.of_structure or self.parameter.split("_")[0] in OF_STRUCTURE
        return self.parameter if known else ""

    def at(self, value: float | str) -> tuple[Structure, Load]:
        """The structure and the load at a value of the parameter, for a branch of a structure.

        Parameters
        ----------
        value : float or str
            Value of the parameter; for a point of an oscillator whose M, K and F0 are known, also with its unit.

        Returns
        -------
        (Structure, Load)
            The system with this value.
        """
        if self.of_structure:
            value = of_parameter(self.structure, self.parameter, value, "value")
        value = checks.finite(value, "value")
        bounds = [(self.keys["low"], self.keys["high"])]
        return Path(self._result, *self._start, bounds).at(value)

    def __len__(self) -> int:
        return int(self.values.size)

    def __getitem__(self, index: Any) -> Any:
        """The motion at a point; a list of them for a slice."""
        i = checks.place(index, len(self), "point")
        if isinstance(i, range):
            return [self[j] for j in i]
        if self.of_structure:
            structure, load = self.at(float(self.values[i]))
            if self._sequence is not None and not self.self_excited:
                return self._presumed(structure, load, i)
            if len(self.resting) or not structure._is_rigid:
                return self._simulated(structure, load, i)
            # rounding may swap two impacts at one instant
            phases = np.maximum.accumulate(self.phases[:, i])
            # at a fold Newton's method has no unique step; for known phases the remaining equations are linear
            return motion_from_phases(structure, load, self.gaps, phases, self.cycles)
        right, left = float(self.R1[i]), float(self.R2[i])
        osc = replace(
            self.osc, xi=float(self.xi[i]), mu=float(self.mu[i]), restitution=(right, left)
        )
        impacts, scalars, verdicts = (
            np.stack([getattr(self, name)[..., i] for name in names], axis=-1)
            for names in (FLIGHTS, SCALARS, VERDICTS)
        )
        return motion_of_oscillator(
            osc, float(self.r[i]), float(self.clearance[i]), 1.0, self.pattern,
            impact_restitution(osc, self.pattern, None), self.alpha[:, i].copy(), impacts, scalars,
            self.multipliers[:, i].copy(), verdicts,
        )  # fmt: skip

    @cached_property
    def _sequence(self) -> tuple[NDArray[np.int64], NDArray[np.int32], list[str]] | None:
        """With stops or friction: the place among `gaps` at whose instant each event comes, what changes in it,
        and its kind; None in files of before they were kept."""
        if "events" not in self._result.tables:
            return None
        place, gap, kind = (self._values("events", name) for name in ("impact", "gap", "kind"))
        return place.astype(np.int64) - 1, gap.astype(np.int32), [str(word) for word in kind]

    def _presumed(self, structure: Structure, load: Load, i: int) -> Motion:
        """The motion with stops or friction at a point, from its events: for known instants all else is linear,
        so that it need be neither stable nor admissible."""
        assert self._sequence is not None
        place, gaps, kinds = self._sequence
        phases = self.phases[:, i].copy()
        for j in range(1, len(phases)):
            if phases[j] < phases[j - 1] - MEETING:
                raise SingularError(
                    f"point {i}: this motion is not admissible: event {j + 1} would precede event {j}; "
                    "its data are in the columns"
                )
            # where two events meet, each keeps an instant of its own
            phases[j] = max(phases[j], np.nextafter(phases[j - 1], np.inf))
        try:
            found = motion_with_events(
                structure, load, gaps.tolist(), phases[place].tolist(), self.cycles, kinds
            )
        except (ParameterError, SingularError):
            # the linear equations lack a restitution that depends on the speed, and where events meet they
            # may be singular
            return self._simulated(structure, load, i)
        found = self._same(i, found)
        known = VERDICT[int(self.admissible[i])]
        if found.admissible != known:
            # where a condition is at its limit rounding decides what a simulation does, and what [P] is
            found = found.__replace__(admissible=None)
        if not np.isfinite(self.multipliers[:, i]).all():
            nothing = np.full(found.multipliers.shape, np.nan + 0j)
            found = found.__replace__(multipliers=nothing, stable=None)
        return found

    def _simulated(self, structure: Structure, load: Load, i: int) -> Motion:
        """The motion at a point, by simulation; it must be admissible. For motions with rests, self-excited ones,
        and those with stops or friction whose events are unknown or do not determine the motion."""
        q, rate = (self._values("points", name)[i] for name in ("q", "q_dot"))
        if not self.admissible[i]:
            raise SingularError(
                f"point {i}: this motion is not admissible and cannot be simulated; its data are in the columns"
            )
        start, state = float(self.phases[0, i]) / load.frequency, (q, rate)
        try:
            if self.self_excited:
                period = float(self.period[i])
                load = Load(constant=load.constant)
                run = simulate_structure(structure, load, duration=period, state=state)
                state = run._between_events()[1]
                found = self_excited_from(structure, load, state, period=period)
                return self._same(i, found)
            if not structure._is_rigid:
                # just after an event its limit may be reached again by rounding
                period = 2 * np.pi * self.cycles / load.frequency
                run = simulate_structure(structure, load, duration=period, state=state, start=start)
                start, state = run._between_events()
            found = settled(structure, load, start, state, cycles=self.cycles)
        except SingularError as error:
            raise SingularError(f"point {i}: simulating from it gives no motion: {error}") from None
        if len(found.rests) != len(self.resting):
            raise SingularError(f"point {i}: the motion simulated from it has different rests")
        return self._same(i, found)

    def _same(self, i: int, found: Motion) -> Motion:
        """The motion found from a point; raises an error if it is not the motion of the branch.

        The events are not compared: an event without effect, such as a halt at the instant of a contact, may occur
        in only one of the two.
        """
        if self.self_excited:
            same = abs(found.period / float(self.period[i]) - 1) < 1e-6
        else:
            sizes = [np.abs(one).max() for one in (found.multipliers, self.multipliers[:, i])]
            same = not np.isfinite(sizes).all() or abs(sizes[0] - sizes[1]) < 1e-3 * (1 + sizes[1])
        if not same:
            raise SingularError(
                f"point {i}: simulating from it gives a different motion; the data of this one are in the columns"
            )
        return found

    def prove(self, tolerance: float = 1e-4, progress: door.Progress | None = None) -> Any:
        """Prove properties of all motions along this branch in ball arithmetic (extra `proof`).

        The proof holds for all values of the parameter, not only at the points of the branch.

        Between folds, the range of the parameter is covered by boxes. For each value in a box, exactly one motion
        exists near a polynomial in the parameter; whether it is admissible and stable is proven for all of these
        motions. Adjacent boxes contain the same motion at their common value. Close to special points some
        properties, or all, remain undecided.

        Parameters
        ----------
        tolerance : float, optional
            The smallest box, relative to the part of the branch between two folds.
        progress : callable, optional
            Called with the fraction done and a note; by default a bar on a terminal or in a notebook.

        Returns
        -------
        Certificate
            `undecided` lists the gaps, with reasons.

        Raises
        ------
        ParameterError
            If the branch has rests, or its parameter is not one of an oscillator. For a structure: if
            `Motion.prove` rejects its motions, or the parameter is not "frequency", "load", "constant", "opening",
            "restitution", "opening_J" or "restitution_J".
        MissingExtraError
            If python-flint is not installed.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=1.04, clearance=25.0)[0]
        >>> vi.branch(motion, "clearance", bounds=(22, 28)).prove()
        <Certificate of RL/1 for clearance 22 to 28 in ... box...: exists, admissible, stable ...>
        """
        return ACTIONS["prove_branch"](self, tolerance, progress=progress)

    def plot(self, ax: Any = None, y: str | None = None, units: Units | str | None = None) -> Any:
        """Draw a column against the parameter (extra `plot`).

        Stable motions are solid, unstable ones dashed, inadmissible ones dotted.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        y : str, optional
            "largest" for the largest modulus of the multipliers; for an oscillator a column with one number per
            point, "attenuation" by default; for a structure "q_max_0" (the default), ... or "q_min_0", ... (of a
            coordinate, from 0), "speed_1", ..., "impulse_1", ... or "phase_1", ... (of an impact, from 1).
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return self._draw(ax, y, units=units)

    def __repr__(self) -> str:
        types = self._values("points", "special").tolist()
        kinds = dict.fromkeys(filter(None, types))
        found = ", ".join(f"{types.count(kind)} {kind}" for kind in kinds) or "no special points"
        pattern = "" if self.of_structure else f" {self.pattern.sides}/{self.pattern.cycles}"
        span = range_text(self._system, self._shown, self.values.min(), self.values.max())
        return f"<Branch{pattern} along {self.parameter}, {span}: {len(self)} points, {found}>"


class Branches(Noun, study="branch"):
    """The branches of a case: one for each motion of its &motion that can be followed.

    Indexing returns a `Branch`; the branches share the points of this result without copying.

    Attributes
    ----------
    complete : bool
        Whether all branches are complete; if not, `cut` gives the reason.
    """

    __slots__ = ()

    @property
    def cut(self) -> str:
        return super().cut or next((branch.cut for branch in self if branch.cut), "")

    @property
    def complete(self) -> bool:
        return not self.cut

    def __len__(self) -> int:
        table = self._result.tables.get("branch" if self.of_structure else "branches")
        return 0 if table is None or self._result.empty else next(iter(table.dims.values()))

    @overload
    def __getitem__(self, index: int) -> Branch: ...
    @overload
    def __getitem__(self, index: slice) -> list[Branch]: ...
    def __getitem__(self, index: Any) -> Any:
        """A branch; a list of them for a slice."""
        i = checks.place(index, len(self), "branch")
        if isinstance(i, range):
            return [self[j] for j in i]
        if len(self) == 1:
            return Branch(self._result)
        return Branch(self._result.part("branches", i, "branch", self._case_of(i), ""))

    def __iter__(self) -> Iterator[Branch]:
        return (self[i] for i in range(len(self)))

    def parts(self) -> list[Branch]:
        """The branches."""
        return list(self)

    def require(self) -> None:
        """SingularError if the motion of a structure could not be followed."""
        if self.of_structure:
            self._any()

    def _any(self) -> None:
        """SingularError if there is none."""
        if not len(self):
            raise SingularError(self._result.notes[0][1])

    def _case_of(self, i: int) -> str:
        """The case of one branch, which starts only from its own motion."""
        first = {
            name: item.decoded()[i]
            for name, item in self._result.tables["branches"].columns.items()
        }
        keys = self.keys
        start = guess_of(
            Pattern(keys.get("sides", "RL"), keys["cycles"]), float(first["start_clearance"]),
            first["start_phases"], first["start_X"], float(first["start_tau"]),
        )  # fmt: skip
        own = ("parameter", "low", "high", "longest_step", "max_points")
        return namelist.case(
            self.osc, keys["r"], motion=start, branch={name: keys[name] for name in own}
        )

    def __repr__(self) -> str:
        return f"<Branches: {', '.join(map(repr, self)) or 'none'}>"


def guess_of(
    pattern: Pattern, clearance: float, phases: _Array, x: _Array, tau: float
) -> dict[str, Any]:
    """The group &motion that computes an exact motion from a guess of all its impacts."""
    return {
        "kind": "exact", "cycles": pattern.cycles, "sides": pattern.sides, "clearance": clearance,
        "phases": phases.tolist(), "positions": x.tolist(), "tau": tau,
    }  # fmt: skip


def only_branch(compute: Callable[[], Branches]) -> Branch:
    """The branch of a case with one motion, even if it was stopped; SingularError if there is none."""
    try:
        found = compute()
    except StudyInterrupted as stop:
        raise StudyInterrupted(stop.result[0]) from None
    found._any()
    return found[0]


def branch_structure(
    motion: Motion,
    parameter: Parameter,
    bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05,
    max_points: int = 4000,
    progress: door.Progress | None = None,
    at: float | None = None,
) -> Branch:
    """As `branch`, for a motion of a structure."""
    if motion.self_excited and callable(parameter):
        parameter = of_constant_load(parameter)
    keys = keys_of_parameter(
        motion.structure, motion._given_load, parameter, bounds, at, "parameter"
    ) | {"longest_step": longest_step, "max_points": max_points}  # fmt: skip
    names = {"low": "bounds[0]", "high": "bounds[1]"}
    return only_branch(lambda: run_from(motion, Branches, keys, names, progress))


def run_from(
    motion: Motion, noun: type[_Found], keys: dict[str, Any], names: dict[str, str],
    progress: door.Progress | None, threads: int | None = None,
) -> _Found:  # fmt: skip
    """The result of a study that starts from a motion; `names` are the caller's names of the keys."""
    if motion.consistent is False:
        raise ParameterError(
            f"motion = {motion!r}: must be consistent, with a residual of rounding; "
            "exact(structure, load, motion) gives the exact motion near it"
        )
    if motion._is_settled:
        raise ParameterError(
            f"motion = {motion!r}: cannot be followed; {motion.without_multipliers}"
        )
    start: dict[str, Any] = {"kind": "exact", "cycles": motion.cycles}
    if len(motion.rests) or not motion.structure._is_rigid:
        time, state = float(motion.phases[0] / motion.load.frequency), (motion.q, motion.q_dot)
        if not motion.structure._is_rigid:
            time, state = motion._run()._between_events()
        start |= {
            "kind": "settled", "start": time, "settling": 0, "q": state[0].tolist(), "q_dot": state[1].tolist(),
        }  # fmt: skip
        if motion.self_excited:
            start |= {"start": None, "cycles": None, "period": motion.period}
    else:
        start |= {"gaps": motion.gaps.tolist(), "phases": motion.phases.tolist()}
    groups = [*motion._groups(), ("motion", start)]
    return door.run_groups(noun, groups, keys, True, threads, progress, names)


@overload
def branch(
    motion: Motion, parameter: str = "clearance", bounds: tuple[Value, Value] | None = None,
    longest_step: float = 0.05, max_points: int = 4000,
    progress: Callable[[float, str], None] | None = None,
) -> Branch: ...  # fmt: skip
@overload
def branch(
    motion: Motion, parameter: Parameter, bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05, max_points: int = 4000,
    progress: Callable[[float, str], None] | None = None, at: float | None = None,
) -> Branch: ...  # fmt: skip


@physical_arguments
@every_system(branch_structure, Motion, no_point="give a motion there, as exact(point, guess)")
def branch(
    motion: Motion,
    parameter: str = "clearance",
    bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05,
    max_points: int = 4000,
    progress: Callable[[float, str], None] | None = None,
) -> Branch:
    """Follow an exact motion along a parameter in both directions, through folds, to the bounds.

    Pseudo-arclength continuation with Newton's method and the analytic derivative of the equations. Special points
    are located by Newton's method on the equations with one further condition: det(P - I) = 0 at a fold, det(P +
    I) = 0 at a flip, the product of all 1 - lambda_i lambda_j at a Neimark-Sacker point, a touch of a wall, or an
    approach speed that is zero. A motion that is its own image half a period later (under reflection or, for a
    structure, under another symmetry such as an exchange of equal units) is followed as such, with the map over
    half a period, so that the branch continues through a pitchfork. The unknowns for a structure are the approach
    speeds and load phases of the impacts and the mean positions of modes of frequency 0; with rests, stops or
    friction, a state and the load phases of all events. Self-excited motions, which have no load, have the period
    as a further unknown, and their trivial multiplier 1 is excluded.

    Parameters
    ----------
    motion : Motion
        For an oscillator: without rest, with load 1. For a structure: consistent, with at most 24 impacts (23 if a
        mode has frequency 0); with rests, stops or friction, at most 24 events, among them releases, but not the
        last impacts of each accumulation. It need not be stable; with rests, stops or friction it must be
        admissible.
    parameter : str, or function
        "r", "clearance", "xi", "mu", "R1", "R2" or "restitution", which changes R1 = R2 together. For a structure
        "frequency"; "load", "constant", "damping" or "stiffness", factors of the harmonics, of the constant forces
        and of the matrices; "opening" or "restitution" of all gaps, which must be equal; "opening_J" or
        "restitution_J" of gap J; "mass_I_J", "damping_I_J" or "stiffness_I_J", an entry and its mirror image;
        "slip" or "slip_J" of friction, with the stick level in the same ratio; "stick" or "stick_J"; "speed" or
        "speed_J" of belts; "contact" or "contact_J", the stiffness of stops; "wall" or "wall_J", a factor above 0
        of the motions of walls; all indices start at 0. Or a smooth function that returns (structure, load) for a
        value of the parameter.
    bounds : (float, float)
        Lowest and highest value of the parameter; its value at the motion lies in between.
    longest_step : float
        Longest step along the curve, relative to the range of the parameter.
    max_points : int
        Largest number of points in each direction.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task: the fraction of the range covered,
        or of the points if that is more.
    at : float, optional
        For a structure: the value of the parameter at the motion, if it is a function.

    Returns
    -------
    Branch
        The motions along the parameter, with the special points and the reasons why it ends.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    SingularError
        If the motion cannot be followed. For a structure: if the motion repeats itself; if gaps close at the same
        instant and would separate for other values of the parameter, or are coupled by damping; or if, with rests,
        stops or friction, two events occur at the same instant, or an event of another gap, of a stop or of
        friction that is not along the gap occurs within an accumulation.
    StudyInterrupted
        After Ctrl-C; its attribute `result` contains the points so far.

    Examples
    --------
    The exact motion that corresponds to the third column of Table 1, along the clearance:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> path = vi.branch(motion, "clearance", bounds=(10, 60))
    >>> [(point.type, round(point.clearance, 6)) for point in path.special_points]
    [('bound', 10.0), ('grazing', 18.085596), ('flip', 34.964757), ('bound', 60.0)]

    A mass on a spring that hits one wall, along the frequency of its load:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    >>> path = vi.branch(motion, "frequency", bounds=(0.6, 3.0))
    >>> [(point.type, round(point.value, 6)) for point in path.special_points[1:4]]
    [('grazing', 0.704494), ('fold', 1.750143), ('zero_approach', 1.410674)]
    """
    checks.instance(motion, "motion", Motion)
    if motion.pattern.has_rest:
        raise ParameterError(
            f"motion = {motion!r}: must be without rest; it can be followed as a motion of a structure: "
            "exact(point.structure, point.load, simulation) with point = osc.at(r, clearance)"
        )
    if motion.load != 1.0:
        raise ParameterError(
            f"motion.load = {motion.load!r}: must be 1; scale the clearance instead"
        )
    right, left = motion.osc.restitution
    if not np.array_equal(motion.restitution, np.where(motion.pattern.signs > 0, right, left)):
        raise ParameterError(
            f"motion.restitution = {motion.restitution.tolist()!r}: must equal the restitution of the walls"
        )
    try:
        low, high = in_order(*bounds)  # type: ignore[misc]
    except (TypeError, ValueError):
        raise ParameterError(
            f"bounds = {bounds!r}: must be (lowest, highest) values of {parameter}"
        ) from None
    start = motion._keys()
    if start["kind"] == "equispaced" or motion.precision == "single":
        # in the form of &motion, where complex numbers are pairs
        start = guess_of(motion.pattern, motion.clearance, motion.alpha, motion.X, motion.tau)
    keys = {
        "parameter": parameter, "low": low, "high": high, "longest_step": longest_step,
        "max_points": max_points,
    }  # fmt: skip
    return only_branch(lambda: door.run(
        Branches, motion.osc, keys, motion.r, progress=progress, start=start,
        parameters={"low": "bounds[0]", "high": "bounds[1]"},
    ))  # fmt: skip
