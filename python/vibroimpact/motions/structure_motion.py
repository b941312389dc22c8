"""Periodic motions of linear structures with gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.interrupt import with_stack
from ..base.sizes import memory_for
from ..base.status import MORE_EVENTS, SHORTER_PERIOD, SYMMETRIC, VERDICT, raise_status
from ..results import namelist
from ..results.gradient import Gradient
from ..results.noun import ACTIONS, Savable
from ..results.parameters import Wanted
from ..results.structure_groups import check_gap_numbers
from ..results.tables import Result, made
from ..systems.restitution import PowerLaw, TabulatedRestitution
from ..systems.structure import Load, Structure
from .structure_quantities import StructureQuantities, structure_quantities
from .structure_trajectory import (
    OfStructure,
    StructureTrajectory,
    core_arrays,
    new_events,
    request_of,
    segments_of_events,
    structure_of,
    structure_tables,
    with_owners,
)

__all__ = ["StructureMotion", "exact_structure", "periodic_structure"]

_Array = NDArray[np.float64]
#: The keys of a &motion of a &structure.
REQUEST = ("kind", "cycles", "gaps", "phases", "settling", "max_cycles", "q", "q_dot", "start")
#: What the core is asked for.
ELIMINATED, FULL, EXACT = 0, 1, 2
#: Relative distance at which motions count as the same, as in the core.
ALIKE = 1e-6
#: Largest phase of an impact, in magnitude.
MOST_PHASE = 1e6
#: Phases (rad) between events that are at one instant but for rounding, and between the last impact of an
#: accumulation and its end.
AT_ONCE, SHORT = 1e-9, 1e-5


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class StructureMotion(Savable, study="motion_structure"):
    """A periodic motion of a structure.

    Attributes
    ----------
    structure : Structure
    load : Load
    gaps : ndarray (N,)
        The gap of each impact in a period, from 0.
    cycles : int
        Load cycles in a period.
    phases : ndarray (N,)
        Load phases Omega t of the impacts (rad), in ascending order.
    speeds, impulses : ndarray (N,)
        Approach speeds, and impulses (1 + R) m v.
    states : ndarray (N, 2, n)
        Coordinates and velocities just after each impact.
    residual : float
        The largest residual of the equations, each relative to the sum of the absolute terms in it.
    matrix : ndarray (2n, 2n)
        [P], the derivative of the period of (q, q') from just after the first impact, or, with rests, from the
        middle of the longest flight; NaN if there is none.
    multipliers : ndarray (2n,)
        Its eigenvalues, in order of decreasing modulus.
    determinant, law : float
        det[P], and exp(-tr(M^-1 C) T) times the product of R (R + R' v) over the impacts, which it must equal
        up to rounding errors of the size of eps times the product of the column lengths of [P]; 0 with rests.
    consistent, admissible, stable : bool or None
        Whether the residual is one of rounding; whether every gap stays open between the impacts; whether all
        multipliers lie inside the unit circle. None: not decided.
    rests : structured array
        ``gap, begin, end``: gaps that rest, and the load phases (rad) at which each rest begins and ends. The
        impacts of the accumulation before it are listed down to those whose effect is below rounding.
    request : dict or None
        The case by the keys of a &motion; None with ``full=True``, or if it was read from a file without its case.
    """

    structure: Structure
    load: Load
    gaps: NDArray[np.int32]
    cycles: int
    phases: _Array
    speeds: _Array
    impulses: _Array
    states: _Array
    residual: float
    matrix: _Array
    multipliers: NDArray[np.complex128]
    determinant: float
    law: float
    consistent: bool | None
    admissible: bool | None
    stable: bool | None
    rests: NDArray[Any]
    request: dict[str, Any] | None = None

    @property
    def q(self) -> _Array:
        """(n,) Coordinates just after the first impact."""
        return np.asarray(self.states[0, 0])

    @property
    def q_dot(self) -> _Array:
        """(n,) Velocities just after the first impact."""
        return np.asarray(self.states[0, 1])

    @property
    def period(self) -> float:
        """Its period, in time."""
        return 2 * np.pi * self.cycles / self.load.frequency

    @memory_for("a sample at the times t")
    def sample(self, t: ArrayLike) -> tuple[_Array, _Array]:
        """Coordinates and velocities at given times.

        Parameters
        ----------
        t : array_like (m,)
            Any times; the load phase is Omega t.

        Returns
        -------
        q, q_dot : ndarray (n, m)
        """
        times = np.atleast_1d(checks.real_array(t, "t", "finite times"))
        if times.ndim != 1 or not np.isfinite(times).all():
            raise ParameterError(f"t = {t!r}: must be finite times")
        run = self._run()
        return run.sample(run.start + np.mod(times - run.start, self.period))

    @memory_for("a sample at the times t")
    def acceleration(self, t: ArrayLike) -> _Array:
        """Accelerations (n, m) at any times, between the impacts, as of `StructureTrajectory.acceleration`."""
        run = self._run()
        times = np.atleast_1d(checks.real_array(t, "t", "finite times"))
        self.sample(times)  # checks them
        return run.acceleration(run.start + np.mod(times - run.start, self.period))

    @memory_for("quantities, by their window and harmonics")
    def quantities(self, harmonics: int = 10) -> StructureQuantities:
        """Response quantities over a period, as of `StructureTrajectory.quantities`."""
        return structure_quantities(self._run(), None, harmonics, closed=True)

    def _run(self) -> StructureTrajectory:
        """The period from just after the first impact, by the flights and rests of the motion.

        Nothing is simulated: a simulation would leave an unstable motion, would stop at the first gap that a
        motion closes in between, and could not start again from a gap that is closed to rounding.
        """
        n, count = self.structure.coordinates, len(self.phases)
        times = self.phases / self.load.frequency
        times = np.append(times, times[0] + self.period)
        numbers = np.arange(1, count + 1) % count
        kinds = ["impact"] * count
        gaps, clock = self.gaps[numbers].tolist(), times[1:].tolist()
        # a rest begins with the last impact of its accumulation, which no other event parts from it; of events at
        # one instant the releases are the last
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
        events = new_events(len(sequence))
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
        first = self.states[0]
        return StructureTrajectory(
            self.structure, self.load, float(times[0]), float(times[-1]), events, states,
            (first[0], first[1]), (first[0], first[1]), True,
        )  # fmt: skip

    def gradient(self, parameters: Sequence[Wanted] | None = None) -> Gradient:
        """The derivatives of phases, speeds, impulses, states and multipliers by parameters.

        They are those of the exact motion, with the phases as functions of the parameters. ``q`` and ``q_dot`` are
        the states just after the impacts; `stability_margin` is 1 - max|lambda|. With rest, the accumulations are
        summed to their limit.

        Parameters
        ----------
        parameters : sequence, optional
            Names as in `branch`: 'frequency'; 'load', 'constant', 'mass', 'damping', 'stiffness' (factors, 1 for
            the motion); 'opening', 'restitution' (of all gaps, which all change by the same); 'opening_J',
            'restitution_J' (of gap J); 'mass_I_J', 'damping_I_J', 'stiffness_I_J' (an entry, with its mirror
            image). Of a `PowerLaw` the restitution is R0. Or tuples (name, function, value) of a smooth function
            that gives (Structure, Load), and the value of its argument at the motion; the function is called
            within 5 % of it (within 0.05 of 0). By default frequency, load, and all openings and coefficients of
            restitution.

        Returns
        -------
        Gradient
            NaN with a `status` for multipliers that coincide.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a parameter does not exist.
        SingularError
            If the motion is at a fold, a pitchfork or a graze, or its phases are not exact.

        Examples
        --------
        >>> import math, vibroimpact as vi
        >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
        >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
        >>> phases = [0.517272128279 * math.pi, 1.899298624085 * math.pi]
        >>> motion = vi.exact(damper, vi.Load(0.94, sine=[1, 0]), (phases, [0, 1]))
        >>> gradient = motion.gradient(["frequency", "mass_1_1"])
        >>> gradient["speeds", "frequency"].shape, gradient["q"].shape
        ((2,), (2, 2, 2))
        """
        found: Gradient = ACTIONS["structure_motion_gradient"](self, parameters)
        return found

    def to_namelist(self) -> str:
        """The case as a namelist, from which `vibroimpact run` and `vibroimpact-batch` compute the same digits."""
        if self.request is None:
            raise ParameterError(
                f"{self!r}: has no namelist, since it was computed with full=True or read from a file without one"
            )
        groups = [*self.structure._groups(), *self.load._groups(), ("motion", self.request)]
        return namelist.text(groups)

    @property
    def _result(self) -> Result:
        """Its tables, with the columns that the core declares."""
        n = self.structure.coordinates
        verdicts = {name: getattr(self, name) for name in ("consistent", "admissible", "stable")}
        tables: dict[str, Any] = {
            "impacts": (("impact",), {
                "impact": np.arange(1, len(self.gaps) + 1), "gap": self.gaps, "phase": self.phases,
                "speed": self.speeds, "impulse": self.impulses,
                "q": self.states[:, 0], "q_dot": self.states[:, 1],
            }),
            "motion": ((), {
                "cycles": self.cycles, "residual": self.residual, "determinant": self.determinant,
                "law": self.law, "frequency": self.load.frequency,
                **{name: -1 if value is None else int(value) for name, value in verdicts.items()},
            }),
            "multipliers": (("multiplier",), {"multiplier": self.multipliers}),
            "derivative": (("state_row",), {"P": np.reshape(self.matrix, (2 * n, 2 * n))}),
            "rests": (("rest",), {name: self.rests[name] for name in ("gap", "begin", "end")}),
            **structure_tables(self.structure, self.load),
        }  # fmt: skip
        case = self.to_namelist() if self.request is not None else ""
        return with_owners(self.structure, made("motion_structure", case, tables, (), ""))

    @classmethod
    def of_result(cls, result: Result) -> StructureMotion:
        """The motion of the core's tables."""

        def values(table: str, *names: str) -> list[Any]:
            return [result.column(table, name).decoded() for name in names]

        names = (
            "cycles", "residual", "determinant", "law", "consistent", "admissible", "stable",
            "frequency",
        )  # fmt: skip
        own = {
            name: value.item() for name, value in zip(names, values("motion", *names), strict=True)
        }
        structure, load = structure_of(result, own["frequency"], True)
        assert load is not None
        gaps, phases, speeds, impulses = values("impacts", "gap", "phase", "speed", "impulse")
        states = np.stack(values("impacts", "q", "q_dot"), axis=1)
        rests = _rests(
            *(lambda gap, *phases: (gap, phases))(*values("rests", "gap", "begin", "end"))
        )
        (multipliers,), (matrix,) = values("multipliers", "multiplier"), values("derivative", "P")
        check_gap_numbers(result, structure)
        check_numbers(own["cycles"], phases, states, multipliers, matrix)
        for array in (states, rests):
            array.flags.writeable = False
        request = request_of(result, "motion", REQUEST, {"gaps", "phases", "q", "q_dot"})
        return cls(
            structure, load, gaps, own["cycles"], phases, speeds, impulses, states, own["residual"],
            matrix, multipliers, own["determinant"], own["law"],
            VERDICT[int(own["consistent"])], VERDICT[int(own["admissible"])],
            VERDICT[int(own["stable"])], rests, request,
        )  # fmt: skip

    def plot(self, ax: Any = None, kind: str | None = None, window: ArrayLike | None = None) -> Any:
        """Draw the structure and a period of the motion, as `StructureTrajectory.plot` does."""
        return self._run().plot(ax, kind, window)

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax, kind="history")

    def _facts(self) -> dict[str, str]:
        return {"coordinates": str(self.structure.coordinates), "impacts": str(len(self.gaps))}

    def __repr__(self) -> str:
        verdicts = [] if self.consistent else [f"residual {self.residual:.2g}"]
        for value, name in ((self.admissible, "admissible"), (self.stable, "stable")):
            if value is not None:
                verdicts.append(name if value else f"not {name}")
        largest = np.abs(self.multipliers).max(initial=0.0)
        n, rests = len(self.phases), len(self.rests)
        resting = f" and {rests} rest{'s' if rests != 1 else ''}" if rests else ""
        return (
            f"<StructureMotion of {n} impact{'s' if n != 1 else ''}{resting} in {self.cycles} "
            f"cycle{'s' if self.cycles != 1 else ''}: {', '.join(verdicts)} (max|lambda| = {largest:.4g})>"
        )


def periodic_structure(
    structure: Structure,
    load: Load,
    phases: ArrayLike,
    gaps: Sequence[int],
    cycles: int = 1,
    full: bool = False,
) -> StructureMotion:
    """The periodic motion of a structure whose impact phases are presumed.

    Given the impact times, all else is linear: an overdetermined system (LAPACK DGELS) for the approach speeds
    and the mean positions of modes of frequency 0. The motion is consistent only if its `residual` is one of
    rounding. `vibroimpact.periodic` calls this for a `Structure`.

    Parameters
    ----------
    structure : Structure
        With constant coefficients of restitution.
    load : Load
    phases : array_like (N,)
        Load phases Omega t of the impacts (rad), increasing, within less than a period of each other.
    gaps : sequence of int (N,)
        The gap of each impact, from 0.
    cycles : int
        Load cycles in a period, 1 to 10000.
    full : bool
        Solve for the state after the first impact as well, with periodicity among the equations, instead of
        eliminating it by the periodic response of each mode. For a motion both give the same; for other phases
        they minimise different residuals.

    Returns
    -------
    StructureMotion

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a mode without damping resonates with the load or the period, or there is no unique solution, as where
        no impact balances a constant force on a mode of frequency 0.

    Examples
    --------
    The third column of Table 1 of the 1983 paper, by the matrices of its two masses:

    >>> import math, vibroimpact as vi
    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> phases = [0.517272128279 * math.pi, 1.899298624085 * math.pi]
    >>> motion = vi.periodic(damper, vi.Load(0.94, sine=[1, 0]), phases, gaps=[0, 1])
    >>> motion.residual < 1e-11, motion.stable
    (True, True)
    """
    checks.instance(structure, "structure", Structure)
    checks.instance(load, "load", Load)
    checks.truth(full, "full")
    laws = [
        i for i, gap in enumerate(structure.gaps)
        if isinstance(gap.restitution, PowerLaw | TabulatedRestitution)
    ]  # fmt: skip
    numbers, phases, cycles = _pattern(structure, load, phases, gaps, cycles)
    for i in laws:
        if i in numbers:
            raise ParameterError(
                f"gaps[{i}].restitution = {structure.gaps[i].restitution!r}: must be a number, "
                "since the problem is linear only then; use exact"
            )
    return _motion(structure, load, numbers, phases, cycles, FULL if full else ELIMINATED)


def exact_structure(
    structure: Structure,
    load: Load,
    guess: StructureMotion | StructureTrajectory | tuple[Any, ...],
) -> StructureMotion:
    """The exact periodic motion of a structure near a guess, by Newton's method.

    Unknown are the impact times, the approach speeds and the mean positions of modes of frequency 0; with
    accumulation and rest, the state in the middle of the longest flight, a fixed point of the simulated period.
    All derivatives are in closed form. `vibroimpact.exact` calls this for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load
    guess : StructureMotion, StructureTrajectory, (phases, gaps) or (phases, gaps, cycles)
        A motion at other parameters; a simulation that ends near the motion; or impacts as in
        `periodic_structure`. From a simulation, the period of up to 16 load cycles that repeats best is taken.

    Returns
    -------
    StructureMotion
        `admissible` is False if a gap would be negative between the impacts.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If the iteration does not converge, or leads to a motion of a shorter period or its own mirror image as
        in `exact` of an oscillator, and as in `periodic_structure`.

    Examples
    --------
    A mass on a spring that hits one wall, example 15.2 of H. Dankowicz and F. Schilder, Recipes for Continuation
    (SIAM, 2013):

    >>> import vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    >>> round(float(motion.phases[0]), 8), round(float(motion.speeds[0]), 8), motion.stable
    (0.07595216, 1.69573294, True)
    """
    if isinstance(guess, StructureTrajectory):
        check_pair(structure, load)
        return settled(structure, load, guess.end, guess.final_state)
    if isinstance(guess, StructureMotion) and len(guess.rests):
        check_pair(structure, load)
        start = guess.phases[0] / guess.load.frequency * (guess.load.frequency / load.frequency)
        found = settled(structure, load, start, (guess.q, guess.q_dot), cycles=guess.cycles)
        return of_same_kind(found, guess)
    if isinstance(guess, StructureMotion):
        phases, gaps, cycles = guess.phases, guess.gaps.tolist(), guess.cycles
    elif isinstance(guess, tuple) and len(guess) in (2, 3):
        phases, gaps, cycles = guess if len(guess) == 3 else (*guess, 1)
    else:
        raise ParameterError(
            f"guess = {guess!r}: must be a StructureMotion, a StructureTrajectory, (phases, gaps) or "
            "(phases, gaps, cycles)"
        )
    numbers, phases, cycles = _pattern(structure, load, phases, gaps, cycles)
    found = _motion(structure, load, numbers, phases, cycles, EXACT)
    return of_same_kind(found, guess) if isinstance(guess, StructureMotion) else found


def of_same_kind(found: StructureMotion, guess: StructureMotion) -> StructureMotion:
    """A motion found from an exact one; an error as of `newton.of_same_kind`."""
    for sign, status in ((1, SHORTER_PERIOD), (-1, SYMMETRIC)):
        if guess.consistent and repeats(found, sign) and not repeats(guess, sign):
            raise_status(status)
    return found


def repeats(motion: StructureMotion, sign: int) -> bool:
    """Whether a motion repeats itself (sign 1), or its mirror image -q does (-1), after a part of its period."""
    many, cycles = len(motion.gaps), motion.cycles
    # where all gaps are closed at 0, the coordinates at the impacts are
    fastest = np.abs(motion.states[:, 1]).max()
    sizes = max(np.abs(motion.states[:, 0]).max(), fastest / motion.load.frequency), fastest
    for m in range(2, cycles + 1) if sign > 0 else range(2, 2 + cycles % 2):
        shift = many // m
        if many % m or (sign > 0 and cycles % m):
            continue
        later = np.roll(motion.phases, -shift)
        later[many - shift :] += 2 * np.pi * cycles
        off = [later - motion.phases - 2 * np.pi * cycles / m]
        for each, size in zip(motion.states.transpose(1, 0, 2), sizes, strict=True):
            off.append((np.roll(each, -shift, axis=0) - sign * each) / (size or 1.0))
        if all(np.abs(part).max() < ALIKE for part in off):
            return True
    return False


def check_pair(structure: Any, load: Any) -> None:
    """Checks that a load is one for a structure."""
    checks.instance(structure, "structure", Structure)
    checks.instance(load, "load", Load)
    n = structure.coordinates
    if load.coordinates != n:
        raise ParameterError(
            f"load for {load.coordinates} coordinates: must be for {n} as the structure is"
        )
    if not load.frequency:
        raise ParameterError(f"load = {load!r}: must have a frequency, which gives the period")


def _pattern(
    structure: Any, load: Any, phases: Any, gaps: Any, cycles: Any
) -> tuple[NDArray[np.int32], _Array, int]:
    """Checks the arguments that describe a motion."""
    check_pair(structure, load)
    cycles = checks.integer(cycles, "cycles", 1, 10_000)
    wanted = "gap numbers from 0, one an impact, 1 to 1000 of them"
    array = np.array(checks.real_array(gaps, "gaps", wanted))
    many = len(structure.gaps)
    if array.ndim != 1 or not 1 <= array.size <= 1000 or (array != np.round(array)).any():
        raise ParameterError(f"gaps = {gaps!r}: must be {wanted}")
    if not ((array >= 0) & (array < many)).all():
        raise ParameterError(
            f"gaps = {gaps!r}: must be {wanted}, each below {many} as the structure has {many} gaps"
        )
    numbers = array.astype(np.int32)
    wanted = (
        "finite load phases, one an impact, increasing, within less than a period of each other"
    )
    phases = np.array(checks.real_array(phases, "phases", wanted), dtype=np.float64)
    if phases.shape != numbers.shape or not np.isfinite(phases).all():
        raise ParameterError(f"phases = {phases.tolist()!r}: must be {wanted}")
    order = np.argsort(phases, kind="stable")
    if (order != np.arange(len(phases))).any() or phases[-1] - phases[0] >= 2 * np.pi * cycles:
        raise ParameterError(f"phases = {phases.tolist()!r}: must be {wanted}")
    same = np.flatnonzero((np.diff(phases) == 0) & (np.diff(numbers) == 0))
    if same.size:
        raise ParameterError(
            f"phases = {phases.tolist()!r}: must differ for impacts on the same gap, but {same[0]} and "
            f"{same[0] + 1} are at once on gap {numbers[same[0]]}"
        )
    if np.abs(phases).max() > MOST_PHASE:
        raise ParameterError(f"phases = {phases.tolist()!r}: must be at most 1e6 in magnitude")
    return numbers, phases, cycles


def _motion(
    structure: Structure,
    load: Load,
    gaps: NDArray[np.int32],
    phases: _Array,
    cycles: int,
    wanted: int,
) -> StructureMotion:
    """The motion from the core."""
    matrices, directions, values, _, harmonics, constant = core_arrays(structure, load)[:6]
    impacts, states, matrix, multipliers, scalars, verdicts, status = with_stack(
        _core.periodic_structure,
        matrices, directions, values, load.frequency, harmonics, constant,
        gaps + 1, phases, cycles, wanted,
    )  # fmt: skip
    structure._raise_status(status)
    request = {
        "kind": "exact" if wanted == EXACT else "periodic", "cycles": cycles, "gaps": gaps.tolist(),
        "phases": phases.tolist(),
    }  # fmt: skip
    return _assembled(
        structure, load, gaps, cycles, impacts, states, matrix, multipliers, scalars, verdicts,
        _rests(), None if wanted == FULL else request,
    )  # fmt: skip


def motion_from_phases(
    structure: Structure, load: Load, gaps: NDArray[np.int32], phases: _Array, cycles: int
) -> StructureMotion:
    """The exact motion whose phases are known."""
    return _motion(structure, load, gaps, phases, cycles, ELIMINATED)


def _rests(gaps: Any = (), phases: Any = ((), ())) -> NDArray[Any]:
    """The table of rests."""
    table = np.zeros(len(gaps), dtype=[("gap", "i4"), ("begin", "f8"), ("end", "f8")])
    table["gap"], table["begin"], table["end"] = gaps, phases[0], phases[1]
    return table


def check_numbers(
    cycles: int, phases: _Array, states: _Array, multipliers: NDArray[Any], matrix: _Array
) -> None:
    """An error unless the numbers of a motion from a file are those that a motion can have."""
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


def _assembled(
    structure: Structure, load: Load, gaps: NDArray[np.int32], cycles: int, impacts: _Array,
    states: _Array, matrix: _Array, multipliers: NDArray[np.complex128], scalars: _Array,
    verdicts: NDArray[np.int32], rests: NDArray[Any], request: dict[str, Any] | None,
) -> StructureMotion:  # fmt: skip
    """A motion from the arrays of the core, read-only."""
    phases, speeds, impulses = (np.ascontiguousarray(impacts[:, i]) for i in range(3))
    states = np.ascontiguousarray(states.T).reshape(len(gaps), 2, structure.coordinates)
    for array in (gaps, phases, speeds, impulses, states, matrix, multipliers, rests):
        array.flags.writeable = False
    consistent, admissible, stable = (VERDICT[int(v)] for v in verdicts)
    residual, determinant, law = scalars.tolist()
    return StructureMotion(
        structure, load, gaps, cycles, phases, speeds, impulses, states, residual, matrix, multipliers,
        determinant, law, consistent, admissible, stable, rests, request,
    )  # fmt: skip


def settled(
    structure: Structure,
    load: Load,
    start: float,
    state: tuple[ArrayLike, ArrayLike],
    settling: int = 0,
    most_cycles: int = 16,
    cycles: int = 0,
) -> StructureMotion:
    """The motion on which a simulation from a state settles."""
    matrices, directions, values, _, harmonics, constant = core_arrays(structure, load)[:6]
    capacity = 500
    while True:
        counts, labels, impacts, states, rests, matrix, multipliers, scalars, verdicts, status = (
            with_stack(
                _core.settle_structure, matrices, directions, values, load.frequency, harmonics, constant, start,
                np.concatenate(state), settling, most_cycles, cycles, capacity,
            )
        )  # fmt: skip
        if status != MORE_EVENTS:
            break
        capacity = int(max(counts[0], counts[2]))
    structure._raise_status(status)
    known = {"cycles": cycles} if cycles else {}
    request: dict[str, Any] = {
        "kind": "settled", **known, "settling": settling, "max_cycles": most_cycles,
        "q": np.asarray(state[0]).tolist(), "q_dot": np.asarray(state[1]).tolist(), "start": float(start),
    }  # fmt: skip
    n, k, m = counts.tolist()
    return _assembled(
        structure, load, labels[0, :n] - 1, k, impacts[:n], states[:, :n], matrix, multipliers,
        scalars, verdicts, _rests(labels[1, :m] - 1, rests[:, :m]), request,
    )  # fmt: skip


class StructureMotionResult(OfStructure, study="motion_structure"):
    """The result of a &motion case of a &structure: the motion, unless it was not found."""

    __slots__ = ()
    part = StructureMotion
