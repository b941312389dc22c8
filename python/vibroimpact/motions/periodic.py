"""The solvers of the 1983 theory: given impact phases, and the equispaced pair."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.interrupt import with_stack
from ..base.progress import in_parts, reported
from ..base.status import NO_MOTION, raise_status
from ..results import door
from ..systems.oscillator import Oscillator, Pattern, Point, of_numbers, plain_pattern
from ..systems.structure import Load, Structure, check_load
from ..systems.verbs import every_system, physical_arguments
from .motion import (
    MOST_PHASE,
    Motion,
    Motions,
    MotionSet,
    motion_of_oscillator,
    motion_of_structure,
    rests_of,
)
from .trajectory import core_arrays

if TYPE_CHECKING:
    from ..systems.units import Value

__all__ = ["equispaced", "equispaced_batch", "linear_system", "periodic", "periodic_batch"]

PRECISIONS = ("double", "single")
#: Largest number of points in a call of the core; Ctrl-C and progress take effect between calls.
CHUNK = 1 << 14
#: The computations that the core can do for a structure.
ELIMINATED, FULL, EXACT = 0, 1, 2
_Array = NDArray[np.float64]


def periodic_structure(
    structure: Structure,
    load: Load,
    phases: ArrayLike,
    gaps: Sequence[int],
    cycles: int = 1,
    full: bool = False,
    kinds: Sequence[str] | None = None,
) -> Motion:
    """As `periodic`, for a structure."""
    checks.truth(full, "full")
    checks.instance(structure, "structure", Structure)
    if not structure._is_rigid or kinds is not None:
        return motion_from_events(structure, load, phases, gaps, cycles, full, kinds)
    numbers, phases, cycles = gap_pattern(structure, load, phases, gaps, cycles)
    for i in np.unique(numbers).tolist():
        if not isinstance(structure.gaps[i].restitution, float):
            raise ParameterError(
                f"gaps[{i}].restitution = {structure.gaps[i].restitution!r}: must be a number, "
                "since the problem is linear only then; use exact"
            )
    return motion_from_phases(
        structure, load, numbers, phases, cycles, FULL if full else ELIMINATED
    )


def motion_from_events(
    structure: Structure, load: Load, phases: Any, gaps: Any, cycles: int, full: bool, kinds: Any
) -> Motion:
    """The motion of a structure with stops, friction or rests from the instants of its events."""
    wanted = (
        "one of impact, stick, release, touch, leave, let_go, press, halt, slip_up and slip_down for "
        "each event"
    )
    if structure._is_rigid:
        wanted += ", or left out if all are impacts"
    try:
        words = [str(kind) for kind in kinds]
    except TypeError:
        raise ParameterError(f"kinds = {checks.shown(kinds)}: must be {wanted}") from None
    numbers, phases, cycles = gap_pattern(structure, load, phases, gaps, cycles, words)
    if full:
        raise ParameterError(
            f"full = {full!r}: must be left out with kinds, where the state is always unknown"
        )
    if isinstance(kinds, str) or len(words) != len(numbers):
        raise ParameterError(f"kinds = {checks.shown(kinds)}: must be {wanted}")
    return motion_with_events(structure, load, numbers.tolist(), phases.tolist(), cycles, words)


def motion_with_events(
    structure: Structure, load: Load, gaps: list[int], phases: list[float], cycles: int, kinds: list[str],
    kind: str = "periodic",
) -> Motion:  # fmt: skip
    """The motion from the core, for known kinds, places and instants of events, or near them."""
    keys = {"kind": kind, "cycles": cycles, "gaps": gaps, "phases": phases, "kinds": kinds}
    found = door.run_groups(
        MotionSet, [*structure._groups(), *load._groups()], keys, True, little=True
    )
    found.require()
    return found.parts()[0]


def gap_pattern(
    structure: Any,
    load: Any,
    phases: Any,
    gaps: Any,
    cycles: Any,
    kinds: Sequence[str] | None = None,
) -> tuple[NDArray[np.int32], _Array, int]:
    """Checks the arguments that describe a motion of a structure, which may have stops if the kinds of its events
    are given."""
    check_load(structure, load, frequency=True, stops=kinds is not None)
    cycles = checks.integer(cycles, "cycles", 1, 10_000)
    wanted = "numbers of gaps, stops or friction from 0, one for each event, 1 to 1000 of them"
    array = np.array(checks.real_array(gaps, "gaps", wanted))
    many = len(structure._parts)
    if array.ndim != 1 or not 1 <= array.size <= 1000 or (array != np.round(array)).any():
        raise ParameterError(f"gaps = {checks.shown(gaps)}: must be {wanted}")
    if not ((array >= 0) & (array < many)).all():
        raise ParameterError(
            f"gaps = {checks.shown(gaps)}: must be {wanted}, each below {many} as the structure has {many} gaps"
        )
    numbers = array.astype(np.int32)
    wanted = "finite load phases, one for each event, not decreasing, within less than a period of each other"
    phases = np.array(checks.real_array(phases, "phases", wanted), dtype=np.float64)
    if phases.shape != numbers.shape or not np.isfinite(phases).all():
        raise ParameterError(f"phases = {checks.shown(phases.tolist())}: must be {wanted}")
    order = np.argsort(phases, kind="stable")
    if (order != np.arange(len(phases))).any() or phases[-1] - phases[0] >= 2 * np.pi * cycles:
        raise ParameterError(f"phases = {checks.shown(phases.tolist())}: must be {wanted}")
    same: list[int] = np.flatnonzero((np.diff(phases) == 0) & (np.diff(numbers) == 0)).tolist()
    # a rest begins with the impact on its gap
    same = [i for i in same if kinds is None or "stick" not in kinds[i + 1 : i + 2]]
    if same:
        raise ParameterError(
            f"phases = {checks.shown(phases.tolist())}: must differ for impacts on the same gap, but "
            f"{same[0]} and {same[0] + 1} are simultaneous on gap {numbers[same[0]]}"
        )
    if np.abs(phases).max() > MOST_PHASE:
        raise ParameterError(
            f"phases = {checks.shown(phases.tolist())}: must be at most 1e6 in magnitude"
        )
    return numbers, phases, cycles


def motion_from_phases(
    structure: Structure,
    load: Load,
    gaps: NDArray[np.int32],
    phases: _Array,
    cycles: int,
    wanted: int = ELIMINATED,
) -> Motion:
    """The motion of a structure from the core, for known phases or near them."""
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
    return motion_of_structure(
        structure, load, gaps, cycles, impacts, states, matrix, multipliers, scalars, verdicts,
        rests_of(), None if wanted == FULL else request,
    )  # fmt: skip


@overload
def periodic(
    osc: Oscillator, r: float, phases: ArrayLike, pattern: Pattern | str, restitution: ArrayLike | None = None,
    precision: str = "double", acceptance: float = 0.03,
) -> Motion: ...  # fmt: skip
@overload
def periodic(
    structure: Structure,
    load: Load,
    phases: ArrayLike,
    gaps: Sequence[int],
    cycles: int = 1,
    full: bool = False,
    kinds: Sequence[str] | None = None,
) -> Motion: ...


@physical_arguments
@every_system(periodic_structure, no_point="the clearance is a result here: give its osc and r")
def periodic(
    osc: Oscillator,
    r: float,
    phases: ArrayLike,
    pattern: Pattern | str,
    restitution: ArrayLike | None = None,
    precision: str = "double",
    acceptance: float = 0.03,
) -> Motion:
    """The periodic motion whose impact phases are given (equations (26), (30) of the 1983 paper).

    For N = 2 impacts the equations are a square linear system (LAPACK DGESV). For N > 2 they are overdetermined
    (DGELS), and the motion is consistent only if its `residual` is small.

    For a structure the arguments are `structure, load, phases, gaps` (load phases and gaps of the impacts),
    `cycles`, and `full`. With `full` the state after the first impact is a further unknown and periodicity a
    further equation; otherwise the state is eliminated by the periodic response of each mode. For the phases of a
    motion both give the same result; for other phases they minimise different residuals. The system is
    overdetermined (DGELS), and the motion is consistent only if its `residual` is at the level of rounding.

    With stops, friction or rests, phases and gaps are those of all events, and `kinds` has a word for each event:
    'impact', 'stick' and 'release' for a gap; 'touch', 'leave', 'let_go' and 'press' for a stop; 'halt',
    'slip_up' and 'slip_down' for friction, whose numbers follow those of gaps and stops. A rest begins ('stick')
    at the instant of an impact on its gap, whose R is 0: before a rest on a gap with R above 0 there are
    infinitely many impacts. Multipliers are NaN unless the motion is consistent; it is admissible if a simulation
    has the same events.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    structure, load : Structure, Load
        In place of `osc` and `r`.
    r : float
        Frequency ratio Omega/omega, 1e-6 to 1e6; not 1 if xi = 0.
    phases : array_like (N,)
        Phase of each impact (radians): increasing, within less than 2 pi k of each other. Only their differences
        matter: the load phase of the first impact is part of the result.
    pattern : Pattern or str
        Sides of the N impacts and the number k of load cycles.
    gaps : array_like (N,) of int
        For a structure, in place of the pattern: the gap of each impact, from 0.
    cycles : int
        For a structure: load cycles in a period.
    full : bool
        For a structure: whether the state after the first impact is a further unknown.
    kinds : sequence of str, optional
        For a structure with stops, friction or rests: the kind of each event.
    restitution : array_like (N,), optional
        Coefficient of restitution of each impact; by default that of the wall.
    precision : {"double", "single"}
        "single" computes the whole chain in 32-bit arithmetic.
    acceptance : float
        Largest relative residual that counts as consistent, 0 to 1. The paper used 0.03.

    Returns
    -------
    Motion
        The motion. For an oscillator the clearance d K/F0 is part of the result; d is the whole travel between
        the walls.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If there is no unique motion with these phases, or a motion without load. For a structure: if a mode
        without damping resonates with the load or the period, or no impact balances a constant force on a mode of
        frequency 0.

    Examples
    --------
    The third column of Table 1:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.periodic(osc, r=0.94, phases=[0, 1.37 * math.pi], pattern=vi.Pattern("RL"))
    >>> motion
    <Motion RL/1 at r = 0.94, d K/F0 = 38.221: admissible, stable (max|lambda| = 0.9347)>

    The same motion from the matrices of its two masses, at d K/F0 = 37:

    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> phases = [0.517272128279 * math.pi, 1.899298624085 * math.pi]
    >>> motion = vi.periodic(damper, vi.Load(0.94, sine=[1, 0]), phases, gaps=[0, 1])
    >>> motion.residual < 1e-11, motion.stable
    (True, True)
    """
    of_numbers(osc)
    pattern = plain_pattern(pattern)
    r = checks.frequency_ratio(r, osc.xi)
    table = checks.phases(phases, len(pattern), pattern.cycles)
    each = impact_restitution(osc, pattern, restitution)
    single = checks.choice(precision, "precision", PRECISIONS) == "single"
    acceptance = checks.number(acceptance, "acceptance")
    results = _core.periodic(
        osc.xi, osc.mu, osc.restitution, r, pattern.cycles, pattern.signs, each,
        table[:, np.newaxis], acceptance, single, True,
    )  # fmt: skip
    raise_status(int(results[4][0]))
    return column_of(osc, r, pattern, each, table, results, 0, precision, "periodic")


@physical_arguments
def periodic_batch(
    osc: Oscillator,
    r: ArrayLike,
    phases: ArrayLike,
    pattern: Pattern | str,
    restitution: ArrayLike | None = None,
    precision: str = "double",
    acceptance: float = 0.03,
    flights: bool = True,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> Motions:
    """Compute `periodic` for many sets of phases in one call.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r : array_like, scalar or (M,)
        Frequency ratio Omega/omega, one for all sets of phases or one for each.
    phases : array_like (N, M)
        One set of impact phases per column.
    pattern : Pattern or str
        Sides of the N impacts and the number of load cycles.
    restitution : array_like, optional
        Coefficient of restitution of each impact (N,); by default that of the wall.
    precision : str
        Kind of arithmetic, "double" or "single".
    acceptance : float
        As in `periodic`.
    flights : bool
        Whether to examine every flight as well, for `admissible`, `x_min` and `x_max`. Without it these are -1 and
        NaN, and the call is faster.
    progress : callable, optional
        Called with the fraction done and an empty text; by default a bar on a terminal or in a notebook.

    Returns
    -------
    Motions
        A point that fails has a status code and NaN; the other points are computed.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> second = np.linspace(1.2, 1.5, 7) * np.pi
    >>> vi.periodic_batch(osc, 0.94, [np.zeros(7), second], vi.Pattern("RL"))
    <Motions RL/1: 7 points, 7 computed, 5 consistent, admissible and stable>
    """
    of_numbers(osc)
    pattern = plain_pattern(pattern)
    table = checks.phase_table(phases, len(pattern), pattern.cycles)
    m = table.shape[1]
    ratios = frequency_ratios(r, m, osc.xi)
    each = impact_restitution(osc, pattern, restitution)
    single = checks.choice(precision, "precision", PRECISIONS) == "single"
    acceptance = checks.number(acceptance, "acceptance")
    checks.progress(progress)
    with reported(progress, "periodic_batch") as told:
        parts = [
            _core.periodic(
                osc.xi, osc.mu, osc.restitution, ratios[part], pattern.cycles, pattern.signs, each,
                table[:, part], acceptance, single, bool(flights),
            )
            for part in in_parts(m, CHUNK, told)
        ]  # fmt: skip
    results = [
        one[0] if len(one) == 1 else np.concatenate(one, axis=-1)
        for one in zip(*parts, strict=True)
    ]
    return _motions(osc, frozen(ratios), pattern, each, frozen(table), results, precision)


@overload
def equispaced(
    osc: Oscillator, r: Value, clearance: Value, cycles: int = 1, precision: str = "double",
) -> list[Motion]: ...  # fmt: skip
@overload
def equispaced(
    point: Point, /, cycles: int = 1, precision: str = "double",
) -> list[Motion]: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
def equispaced(
    osc: Oscillator,
    r: float,
    clearance: float,
    cycles: int = 1,
    precision: str = "double",
) -> list[Motion]:
    """The motions with two equally spaced impacts; there are at most two.

    With equal restitution the phases 0, k pi leave the amplitude free; at a given clearance the phase
    tau lies on the intersection of a line with a circle.

    Parameters
    ----------
    osc : Oscillator
        With R1 = R2.
    r : float
        Frequency ratio, as in `periodic`.
    clearance : float
        D = d K/F0, 1e-12 to 1e12; d is the whole travel between the walls.
    cycles : int
        Load cycles k in a period, odd.
    precision : {"double", "single"}

    Returns
    -------
    list of Motion
        0, 1 or 2 motions, stable or not.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the walls differ in restitution; nothing was computed.

    Examples
    --------
    The first two columns of Table 1:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> [round(float(motion.X[0]), 2) for motion in vi.equispaced(osc, r=0.94, clearance=37.0)]
    [16.17, -5.1]
    >>> vi.equispaced(osc, r=0.94, clearance=200.0)
    []
    """
    pattern = equispaced_pattern(osc, cycles)
    r = checks.frequency_ratio(r, osc.xi)
    clearance = checks.number(clearance, "clearance")
    single = checks.choice(precision, "precision", PRECISIONS) == "single"
    each = impact_restitution(osc, pattern, None)
    phases = frozen(np.array([0.0, pattern.cycles * np.pi]))
    results = _core.equispaced(
        osc.xi, osc.mu, osc.restitution, [r], [clearance], pattern.cycles, 0.03, single, True
    )
    motions = []
    for j, code in enumerate(results[4].tolist()):
        if code == NO_MOTION:
            continue
        raise_status(code)
        motions.append(
            column_of(osc, r, pattern, each, phases, results, j, precision, "equispaced")
        )
    return motions


@overload
def equispaced_batch(
    osc: Oscillator, r: ArrayLike, clearance: ArrayLike, cycles: int = 1, precision: str = "double",
) -> tuple[Motions, Motions]: ...  # fmt: skip
@overload
def equispaced_batch(
    point: Point, /, cycles: int = 1, precision: str = "double",
) -> tuple[Motions, Motions]: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
def equispaced_batch(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    cycles: int = 1,
    precision: str = "double",
) -> tuple[Motions, Motions]:
    """Compute `equispaced` at many points (r, clearance) in one call.

    Parameters
    ----------
    osc : Oscillator
        As in `equispaced`: with R1 = R2.
    r, clearance : array_like, scalar or (M,)
        Frequency ratios Omega/omega, and clearances D = d K/F0, of each point; two numbers are two points, not a
        range.
    cycles : int
        Load cycles k in a period, odd.
    precision : str
        As in `equispaced`.

    Returns
    -------
    tuple of two Motions
        The two solutions at each point; `status` is nonzero where they do not exist.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the walls differ in restitution; nothing was computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> vi.equispaced_batch(osc, 0.94, np.linspace(20, 60, 5))[0]
    <Motions RL/1: 5 points, 5 computed, 0 consistent, admissible and stable>
    """
    pattern = equispaced_pattern(osc, cycles)
    single = checks.choice(precision, "precision", PRECISIONS) == "single"
    values = checks.real_array(clearance, "clearance", "one number or a list of numbers").ravel()
    if not values.size:
        raise ParameterError("clearance of 0 values: must be one number or a list of numbers")
    m = np.size(r) if values.size == 1 else values.size
    ratios = frequency_ratios(r, m, osc.xi)
    for value in (values.min(), values.max()):
        checks.number(float(value), "clearance")
    values = np.broadcast_to(values, m)
    each = impact_restitution(osc, pattern, None)
    phases = np.repeat([[0.0], [pattern.cycles * np.pi]], m, axis=1)
    results = _core.equispaced(
        osc.xi, osc.mu, osc.restitution, ratios, values, pattern.cycles, 0.03, single, True
    )
    first, second = (
        _motions(
            osc,
            frozen(ratios),
            pattern,
            each,
            frozen(phases),
            [x[..., i::2] for x in results],
            precision,
        )
        for i in (0, 1)
    )
    return first, second


def equispaced_pattern(osc: Oscillator, cycles: int) -> Pattern:
    """The pattern RL over an odd number of load cycles; an error if the walls differ."""
    of_numbers(osc)
    if osc.restitution[0] != osc.restitution[1]:
        raise ParameterError(
            f"restitution = {osc.restitution!r}: must be equal on both walls for equispaced impacts; use "
            "periodic(osc, r, phases, pattern)"
        )
    cycles = checks.integer(cycles, "cycles", 1, checks.MAX_CYCLES)
    if cycles % 2 == 0:
        raise ParameterError(f"cycles = {cycles}: must be odd for equispaced impacts")
    return Pattern("RL", cycles)


@physical_arguments
def linear_system(
    osc: Oscillator,
    r: float,
    phases: ArrayLike,
    pattern: Pattern | str,
    restitution: ArrayLike | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The linear equations of the 1983 paper, for inspection: (26), i = 1..N, then (30), i = 1..N.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r : float
        Frequency ratio Omega/omega.
    phases : array_like (N,)
        Phase of each impact (radians), as in `periodic`.
    pattern : Pattern or str
        Sides of the N impacts and the number of load cycles.
    restitution : array_like (N,), optional
        Coefficient of restitution of each impact; by default that of the wall.

    Returns
    -------
    matrix : ndarray (2N, N + 2)
        Coefficients of x_1 .. x_N, A cos(tau), A sin(tau), for omega = 1.
    rhs : ndarray (2N,)
        Right sides for clearance 1.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> matrix, rhs = vi.linear_system(osc, 0.94, [0, 2, 4], vi.Pattern("RRL"))
    >>> matrix.shape, rhs.shape
    ((6, 5), (6,))
    """
    of_numbers(osc)
    pattern = plain_pattern(pattern)
    r = checks.frequency_ratio(r, osc.xi)
    table = checks.phases(phases, len(pattern), pattern.cycles)
    each = impact_restitution(osc, pattern, restitution)
    matrix, rhs = _core.linear_system(osc.xi, osc.mu, r, pattern.cycles, pattern.signs, each, table)
    return matrix, rhs


def impact_restitution(osc: Oscillator, pattern: Pattern, restitution: Any) -> NDArray[np.float64]:
    """Coefficient of restitution of each impact, read-only."""
    if restitution is None:
        right, left = osc.restitution
        return frozen(np.where(pattern.signs > 0, right, left))
    return frozen(checks.restitution_list(restitution, len(pattern)))


def frequency_ratios(values: Any, m: int, xi: float) -> NDArray[np.float64]:
    """One frequency ratio for each of m points, given as one number or m."""
    wanted = f"one number or {m}, one per column of phases"
    ratios = checks.real_array(values, "r", wanted)
    if ratios.ndim > 1 or ratios.size not in (1, m):
        raise ParameterError(f"r of shape {ratios.shape}: must be {wanted}")
    for value in ratios.ravel() if ratios.size == 1 else (ratios.min(), ratios.max()):
        checks.number(float(value), "r")
    if (ratios == 1).any():
        checks.frequency_ratio(1.0, xi)
    return np.broadcast_to(ratios.ravel(), m) if ratios.size == 1 else ratios


def frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """A read-only copy of an array, which a caller cannot change."""
    if array.flags.writeable:
        array = array.copy()
        array.flags.writeable = False
    return array


def column_of(
    osc: Oscillator, r: float, pattern: Pattern, restitution: _Array, alpha: _Array, results: Any, j: int,
    precision: str, kind: str,
) -> Motion:  # fmt: skip
    """One column of the core's results as a Motion."""
    impacts, scalars, multipliers, verdicts, _ = results
    return motion_of_oscillator(
        osc, r, float(scalars[0, j]), 1.0, pattern, restitution, frozen(alpha), impacts[..., j],
        scalars[:, j], multipliers[:, j], verdicts[:, j], precision=precision, kind=kind,
    )  # fmt: skip


def _motions(
    osc: Oscillator,
    r: NDArray[np.float64],
    pattern: Pattern,
    restitution: NDArray[np.float64],
    phases: NDArray[np.float64],
    results: Any,
    precision: str,
) -> Motions:
    """All columns of the core's results."""
    impacts, scalars, multipliers, verdicts, status = results
    consistent, admissible, stable = verdicts.astype(np.int8)
    for array in (impacts, scalars, multipliers, status, consistent, admissible, stable):
        array.flags.writeable = False
    clearance, amplitude, tau, residual, x_min, x_max = scalars
    return Motions(
        osc, r, clearance, pattern, restitution, phases,
        impacts[:, 0], impacts[:, 1], impacts[:, 2], impacts[:, 3], impacts[:, 4], impacts[:, 5],
        amplitude, tau, residual, multipliers, consistent, admissible, stable, x_min, x_max, status,
        precision,
    )  # fmt: skip
