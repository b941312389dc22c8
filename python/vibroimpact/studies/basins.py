"""Basins of attraction of every system: the attractors that initial states reach, and the basins' integrity."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError, SingularError, VibroimpactError
from ..base.spacing import Axis, axis_of
from ..motions.exact import attractor_at_end
from ..motions.motion import Motion
from ..motions.trajectory import simulate
from ..results import door
from ..results.noun import Noun, column, key
from ..results.states import state_by_coordinates
from ..systems.oscillator import Oscillator, Point, of_numbers
from ..systems.structure import Load, Structure, without_none
from ..systems.verbs import every_system, physical_arguments
from .find import structure_motions_of
from .lyapunov import Lyapunov, lyapunov

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Attractor", "Basins", "basins"]

_Array = NDArray[np.float64]
#: Coordinates of a state; y = z - x.
COORDINATES = ("t", "x", "x_dot", "y", "z_dot")
#: The names of the coordinates and velocities of both masses in the structure of an oscillator.
OF_STRUCTURE = {"x": "q_0", "z": "q_1", "x_dot": "q_dot_0", "z_dot": "q_dot_1"}
#: The core's names for the parts of an axis of a plane.
AXIS_NAMES = {
    "axes": "plane: name",
    "low": "plane: low",
    "high": "plane: high",
    "values": "plane: n",
    "first_values": "plane[0][1]",
    "second_values": "plane[1][1]",
}
#: Keys of the values along each axis, if they are not evenly spaced.
LISTED = ("first_values", "second_values")
#: The labels of states that were not simulated because the study was stopped, and of states with too many events.
NOT_REACHED, EVENT_LIMITED = -2, -3
#: Numbers of load cycles over which exponents are computed, tried in turn since impacts may be rare; the load
#: cycles before them.
EXPONENT_CYCLES, EXPONENT_DISCARD = (4000, 40_000, 400_000), 500


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Attractor:
    """An attractor.

    Attributes
    ----------
    kind : str
        "periodic" or "rest" (periodic, with accumulation and rest): Newton's method confirms a stable motion that
        states reach; "chaotic": the largest exponent is positive by more than its error; "quasi-periodic": it is
        zero within its error, and no stable motion is found nearby; "no impacts"; "equilibrium", without a load or
        under a constant one; "permanent rest", where gaps of a structure stay closed or friction sticks
        permanently, wherever the structure came to rest; or "periodic?" where a simulation of an oscillator
        repeats itself to within rounding for a long time but no stable exact motion was found.
    name : str
        Sides and load cycles, such as "RL/1"; for a structure, impacts and load cycles, such as "2/1", or "rest/1"
        with rests; otherwise the kind. With stops or friction all events count as impacts. Equal names are
        numbered.
    motion : Motion or None
        The exact motion.
    state : dict or None
        For an oscillator: a state on the attractor.
    lyapunov : Lyapunov or None
        For an oscillator: exponents of an attractor that is not periodic.
    radius, contraction : float
        For an oscillator: radius of the largest neighbourhood used to decide states, in a norm adapted to the
        motion, and the contraction of the derivative over a period in that norm; 0 and 1 if there is no
        neighbourhood.
    growth : float
        For an oscillator: the largest modulus of the multipliers of a periodic attractor, from the simulation, or
        the largest exponent per load cycle of another attractor; NaN if neither exists.
    """

    kind: str
    name: str
    motion: Motion | None
    state: dict[str, float] | None = None
    lyapunov: Lyapunov | None = None
    radius: float = 0.0
    contraction: float = 1.0
    growth: float = math.nan

    def __repr__(self) -> str:
        kind = "" if self.name.startswith(self.kind) else f"{self.kind} "
        return f"<{kind}attractor {self.name}>"


class Basins(Noun, study="basins", formerly="StructureBasins"):
    """The attractor that each of many initial states reaches.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : float
        For an oscillator.
    structure : Structure
        For a structure.
    load : float or Load
    attractors : list of Attractor
        The label of an attractor is its index in this list; for a structure they are in order of decreasing share.
    labels : ndarray (n, m) of int, or (M,)
        For each state of the plane (first axis, second axis) or of the list; -1 not decided, -2 not reached before
        the study was cut short, -3 not decided within `max_events` events, -4 a gap of a structure is closed in
        the initial state.
    axes : (Axis, Axis) or None
    states : ndarray (5, ...), or (2, k, ...)
        t, x, x_dot, z, z_dot of each state, or coordinates and velocities of a structure with k coordinates.
    impacts : int
        For an oscillator: number of events simulated to decide the states.
    fractions : ndarray
        Share of the states that reach each attractor, among the states without a closed gap; if the study was cut
        short, among the simulated states.
    standard_error : ndarray
        Standard error of the fractions for independent states; an upper bound for states on a lattice.
    reached : int
        States that were simulated: all, unless the study was stopped.
    uncertain : (ndarray, ndarray)
        For an evenly spaced plane of an oscillator: share of pairs of states that end on different attractors,
        along the first and the second axis, against their distance in cells.
    uncertainty_exponent : float
        For an evenly spaced plane of an oscillator: the exponent of `uncertain`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
    """

    __slots__ = ("_attractors",)
    _attractors: list[Attractor]
    labels = column("states", "label")
    fractions = column("attractors", "fraction")
    standard_error = column("attractors")
    r: float = key("r", meaning="For an oscillator: the frequency ratio Omega/omega.")
    clearance: float = key("clearance", meaning="For an oscillator: the clearance d K/F0.")

    @property
    def attractors(self) -> list[Attractor]:
        """The attractors; the label of a state is an index in this list."""
        if not hasattr(self, "_attractors"):
            found = attractors_of_structure(self) if self.of_structure else attractors_of(self)
            object.__setattr__(self, "_attractors", found)
        return self._attractors

    @property
    def states(self) -> _Array:
        """Initial states: t, x, x_dot, z, z_dot (5, ...), or coordinates and velocities (2, k, ...)."""
        if self.of_structure:
            parts = [self._values("states", name) for name in ("q", "q_dot")]
            return np.stack([np.moveaxis(part, -1, 0) for part in parts])
        return np.stack(
            [self._values("states", name) for name in ("t", "x", "x_dot", "z", "z_dot")]
        )

    @property
    def axes(self) -> tuple[Axis, Axis] | None:
        """Both axes of the plane of states; None for random states and lists."""
        keys = self.keys
        if all(name in keys for name in ("axes", *LISTED)):
            lists = [tuple(np.ravel(keys[name]).tolist()) for name in LISTED]
            first, second = (
                axis_of((name, values), None, label)
                for name, values, label in zip(keys["axes"], lists, LISTED, strict=True)
            )
            return first, second
        names = ("axes", "low", "high", "values")
        if any(name not in keys for name in names):
            return None
        columns = (keys[name] for name in names)
        first, second = (Axis(*each) for each in zip(*columns, strict=True))
        return first, second

    undrawable = "random states have no picture"

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether its states are those of a plane."""
        return self.axes is not None

    def require(self) -> None:
        """Raise a SingularError if nothing was simulated."""
        if "states" not in self._result.tables:
            raise SingularError(self._result.notes[0][1])

    def _check_read(self) -> None:
        super()._check_read()
        if "run" in self._result.tables and not np.isfinite(self._run("events")).all():
            raise ParameterError(f"run.events = {self._run('events')}: must be a finite number")

    @property
    def impacts(self) -> int:
        """For an oscillator: number of events that were simulated to decide the states."""
        if self.of_structure:
            raise AttributeError(self._lack("impacts", "labels"))
        return round(float(self._run("events")))

    @property
    def reached(self) -> int:
        """Number of states that were simulated: all, unless the study was stopped."""
        return int((self.labels != NOT_REACHED).sum())

    @property
    def uncertain(self) -> tuple[_Array, _Array]:
        """For an oscillator: share of pairs of states that end on different attractors, by distance.

        Pairs lie along the first or the second axis; their distance is in cells.
        """
        self._need_plane("uncertain")
        pairs = self._result.tables["pairs"].columns
        return pairs["distance"].values, pairs["uncertain"].values

    @property
    def uncertainty_exponent(self) -> float:
        """For an oscillator: the exponent with which the share of uncertain states falls.

        If states are known to within eps, the share of states whose attractor is uncertain is ~ eps**a, where a is
        the exponent.

        It is 1 for smooth boundaries and near 0 for fractal ones, for which a more accurate state hardly reduces
        the uncertainty. The boundary in the plane has dimension 2 - a. NaN if there is no boundary.
        """
        self._need_plane("uncertainty_exponent")
        return float(self._run("uncertainty_exponent"))

    def integrity(self, attractor: int) -> tuple[float, tuple[float, float]]:
        """For an oscillator: radius and centre of the largest disc of the plane inside a basin.

        Both axes have equal scales. The radius is the distance to the nearest state that ends on another
        attractor, or to the edge of the plane; the true radius is at least this minus one cell. For a damper it is
        the largest disturbance of the state from which the motion still recovers.

        Parameters
        ----------
        attractor : int
            Index of the attractor in `attractors`.

        Returns
        -------
        (float, (float, float))
            Radius of the disc, and its centre on both axes, in the units of the plane.
        """
        self._need_plane("integrity")
        columns = self._result.tables["attractors"].columns
        checks.integer(attractor, "attractor", 0, self.fractions.size - 1)
        first, second = columns["disc_centre"].values[attractor].tolist()
        return float(columns["disc_radius"].values[attractor]), (first, second)

    def _run(self, name: str) -> NDArray[Any]:
        """A value of the table of the run."""
        return self._result.tables["run"].columns[name].values

    def _need_plane(self, name: str) -> None:
        """Raise an error if there is no complete plane: states that were not simulated would count as ending
        elsewhere."""
        if self.of_structure:
            raise AttributeError(self._lack(name, "fractions"))
        if self.axes is not None and any(axis.listed for axis in self.axes):
            raise ParameterError(
                f"plane: must have evenly spaced values along both axes for {name}, which compares "
                "states at equal distances"
            )
        if "first" not in self._result.tables:
            raise ParameterError(
                f"plane = None: must be given for {name}; these states are random or a list"
            )
        if not self.complete:
            raise ParameterError(
                f"complete = False: must be the whole plane for {name}; cut short, {self.cut}"
            )

    def plot(self, ax: Any = None, units: Units | str | None = None) -> Any:
        """Draw the plane, one colour for each attractor (extra `plot`).

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
        names = self._result.tables["attractors"].columns["name"].decoded()
        parts = [f"{name} {share:.1%}" for name, share in zip(names, self.fractions, strict=True)]
        left = int(np.isin(self.labels, (-1, EVENT_LIMITED)).sum())
        parts += [f"{left} not decided"] if left and self.complete else []
        cut = "" if self.complete else f"; cut short, {self.cut}"
        shares = ", ".join(parts) or "none decided"
        return f"<Basins of {self.labels.size} states: {shares}{cut}>"


def basins_structure(
    structure: Structure,
    load: Load | None,
    plane: tuple[Any, Any] | None = None,
    states: int | None = None,
    points: int | tuple[int, int] | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    settling: int = 1000,
    max_cycles: int = 16,
    rng: Rng = 0,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Basins:
    """As `basins`, for a structure."""
    check_choice(plane, states)
    load = without_none(load)
    keys: dict[str, Any] = {
        **door.start_keys(structure, state, start), "settling": settling, "max_cycles": max_cycles,
        "max_events": max_events,
    }  # fmt: skip
    keys |= (
        {"states": states, "seed": checks.seed_of(rng)}
        if plane is None
        else _plane_keys(plane, "q_0, q_1, ... or q_dot_0, ...", points)
    )
    found = door.run_structure(
        Basins,
        structure,
        load,
        keys,
        threads,
        progress,
        AXIS_NAMES,
        needs_frequency=False,
        stops=True,
    )
    found.require()
    return found


def _by_coordinates(given: dict[str, Any]) -> None:
    """Converts the names of a plane of an oscillator, and the argument `state`, to those for a structure."""
    state_by_coordinates(given)
    plane = given.get("plane")
    if isinstance(plane, (list, tuple)):
        given["plane"] = tuple(
            (OF_STRUCTURE.get(axis[0], axis[0]), *axis[1:])
            if isinstance(axis, (list, tuple)) and axis and isinstance(axis[0], str)
            else axis
            for axis in plane
        )


@overload
def basins(
    osc: Oscillator, r: Value, clearance: Value, plane: tuple[Any, Any] | None = None,
    states: int | ArrayLike | None = None, points: int | tuple[int, int] | None = None,
    fixed: Mapping[str, Value] | None = None, load: Value | Load = 1.0,
    cycles: int = 1000, probes: int = 200, max_cycles: int = 16, rng: Rng = 0, max_events: int = 10_000_000,
    threads: int | None = None, progress: Callable[[float, str], None] | None = None,
) -> Basins: ...  # fmt: skip
@overload
def basins(
    structure: Structure, load: Load | None, plane: tuple[Any, Any] | None = None, states: int | None = None,
    points: int | tuple[int, int] | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None, start: float = 0.0, settling: int = 1000,
    max_cycles: int = 16, rng: Rng = 0, max_events: int = 10_000_000, threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Basins: ...  # fmt: skip
@overload
def basins(
    point: Point, /, plane: tuple[Any, Any] | None = None, states: int | ArrayLike | None = None,
    **options: Any,
) -> Basins: ...  # fmt: skip


@physical_arguments
@every_system(basins_structure, of_law=_by_coordinates)
def basins(
    osc: Oscillator,
    r: float,
    clearance: float,
    plane: tuple[Any, Any] | None = None,
    states: int | ArrayLike | None = None,
    points: int | tuple[int, int] | None = None,
    fixed: Mapping[str, float] | None = None,
    load: float | Load = 1.0,
    cycles: int = 1000,
    probes: int = 200,
    max_cycles: int = 16,
    rng: Rng = 0,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Basins:
    """The attractor that each of many initial states reaches.

    For an oscillator, first a few of the states are simulated until they settle, and Newton's method computes the
    exact periodic motions. Around the events of each motion a ball is determined, in a norm in which the
    derivative over a period is a contraction: the largest ball on which the map is a contraction too, tested with
    1024 states spread over it. Half its radius is used. A state is decided as soon as its trajectory has an event
    in such a neighbourhood. A state that is not decided after `cycles` load cycles is examined again: it may be on
    an unknown periodic motion, which is then added. Otherwise it is followed for longer, within `max_events`,
    until it reaches a periodic motion that Newton's method finds near it, or its largest Lyapunov exponent shows
    that it is chaotic (positive by more than its error) or quasi-periodic (zero within its error, without a stable
    motion near it). Before this verdict, the simulation must have lasted many times as long as volumes need to
    contract and free vibrations to decay. It is then continued for another two million events, and other states
    with impacts in the same regions for as many again, so that no transient is mistaken for an attractor. All
    other states remain undecided.

    Each state of a structure is simulated until it repeats to rounding near a motion that Newton's method confirms
    as admissible and stable, or for `settling` load cycles. If nothing is decided then, it is followed for longer:
    its largest Lyapunov exponent shows whether it is chaotic, quasi-periodic, or still settling. States with
    events in the same regions are then watched for two million events: if one of them settles, all are on a
    transient, and those that do not settle remain undecided. Equal motions count as one attractor, whichever
    impact comes first. Without a load, or with a constant load, states settle on self-excited motions or in an
    equilibrium; those that do neither within 31 `settling` remain undecided.

    The system is `osc, r, clearance`, or `structure, load`, or a point from `Oscillator.at`.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r, clearance : float
        As in `simulate`, like the number `load`.
    structure, load : Structure, Load
        In place of `osc`, `r` and `clearance`; `Load.none()`, None or a constant load for self-excited motions.
    plane : ((name, (lo, hi)), (name, (lo, hi))), optional
        Two coordinates, each with a range, in which `points` values are taken, or with an array that rises or
        falls throughout; or (name, lo, hi, n). Names are "x", "x_dot", "y" (that is z - x), "z_dot" and "t"; for a
        structure "q_0", "q_1", ... (coordinates, from 0) and "q_dot_0", ... (velocities), which at a point with
        friction or stops are also "x", "z", "x_dot" and "z_dot".
    states : int or array_like (5, M), optional
        Instead of a plane: a number of random states, or for an oscillator an array with t, x, x', z, z' of each.
        Random states are at t = 0, uniform in a box: x, x' and z' from -s to s and y from wall to wall, where s is
        the amplitude of the motion without impacts, but at least half the clearance and at most three times the
        clearance. Random states of a structure are those of `find`; the first one is rest at q = 0.
    points : int or (int, int), optional
        Numbers of values in the ranges of the plane.
    fixed : mapping, optional
        For an oscillator: the coordinates that are not axes of the plane; 0 by default.
    state : (array_like, array_like), optional
        For a structure: coordinates and velocities off the axes of the plane; zero by default.
    start : float
        For a structure: time at the start.
    cycles : int
        For an oscillator: load cycles after which a state without a decision is examined again.
    settling : int
        For a structure: load cycles, or for self-excited motions natural periods, after which a state that does
        not repeat is followed for longer.
    probes : int
        For an oscillator: number of states simulated first.
    max_cycles : int
        Longest period that is considered, in load cycles.
    rng : int, numpy.random.Generator or None
        Seed of random states, from 0 to 2**31 - 1, or a generator from which a seed is drawn; None: another seed
        in each call. A state depends only on the seed and its number, so a larger set of states begins with the
        smaller one. The seed that was used is in the case of the result.
    max_events : int
        Events (impacts, rests, releases; for a structure also events of stops and friction) after which one
        simulation is abandoned: its state has the label -3.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; by default a bar on a terminal
        or in a notebook.

    Returns
    -------
    Basins
        The attractors, and the label of each state.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If random states of a structure are requested but a gap is closed at q = 0, or if a structure without a
        periodic load has no natural period, in which `settling` is counted.
    StudyInterrupted
        After Ctrl-C; its attribute `result` is the part that was finished: states that were not reached have the
        label -2, and the shares refer to the others.

    Examples
    --------
    The basins of the unequispaced motion at the point of Table 1 and of its mirror image cover most of this plane:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> result = vi.basins(osc, 0.94, 37.0, (("x", (-30, 30)), ("x_dot", (-30, 30))), points=20)
    >>> result.attractors
    [<periodic attractor RL/1 (1)>, <periodic attractor RL/1 (2)>, ...]
    >>> bool(abs(result.fractions[0] - 0.43) < 0.1)
    True

    A damper as a structure:

    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> plane = (("q_0", (-10, 10)), ("q_dot_0", (-20, 20)))
    >>> result = vi.basins(damper, vi.Load(0.94, sine=[1, 0]), plane, points=8)
    >>> result.attractors[:2]
    [<attractor no impacts>, <periodic attractor 2/1 (1)>]
    >>> result.labels.shape
    (8, 8)
    """
    of_numbers(osc)
    r = checks.frequency_ratio(r, osc.xi)
    check_choice(plane, states)
    if plane is None and fixed is not None:
        raise ParameterError(
            f"fixed = {fixed!r}: must be left out, since it is used only with plane"
        )
    keys: dict[str, Any] = {
        "clearance": clearance, "cycles": cycles, "probes": probes, "max_cycles": max_cycles, "load": load,
        "max_events": max_events,
    }  # fmt: skip
    names = {**AXIS_NAMES, "list": "states"}
    if plane is not None:
        names |= {name: f"fixed[{name!r}]" for name in COORDINATES}
        keys |= _plane_keys(plane, "x, x_dot, y, z_dot or t", points) | _fixed_keys(fixed)
    elif not isinstance(states, (list, tuple)) and np.ndim(states) == 0:  # type: ignore[arg-type]
        keys |= {"states": states, "seed": checks.seed_of(rng)}
    else:
        starts = checks.real_array(states, "states", "a number or an array (5, M)")  # type: ignore[arg-type]
        if starts.ndim != 2 or starts.shape[0] != 5 or starts.shape[1] == 0:
            raise ParameterError(
                f"states of shape {starts.shape}: must be (5, M): t, x, x_dot, z, z_dot"
            )
        keys["list"] = starts.T.ravel()
    return door.run(Basins, osc, keys, r, threads, progress, names)


def check_choice(plane: Any, states: Any) -> None:
    """Check that there is a plane or a number or list of states, not both."""
    if (plane is None) == (states is None):
        raise ParameterError(f"plane = {plane!r}, states = {states!r}: exactly one must be given")


def _plane_keys(plane: Any, names: str, points: Any) -> dict[str, Any]:
    """The keys of the two axes of a plane."""
    both = isinstance(points, (list, tuple)) and len(points) == 2
    numbers = points if both else (points, points)
    try:
        axes = [
            axis_of(item, n, f"plane[{i}][1]")
            for i, (item, n) in enumerate(zip(plane, numbers, strict=True))
        ]
        if any(axis.listed for axis in axes) and len(axes) == 2:
            listed = {name: axis.values for name, axis in zip(LISTED, axes, strict=True)}
            return {"axes": [axis.name for axis in axes], **listed}
        lists = map(list, zip(*(axis[:4] for axis in axes), strict=True))
        columns = dict(zip(("axes", "low", "high", "values"), lists, strict=True))
    except (ParameterError, ParameterTypeError):
        raise
    except (TypeError, ValueError):
        axes = []
    if len(axes) != 2:
        raise ParameterError(
            f"plane = {plane!r}: must be two of (name, (lo, hi)) with points, or of (name, lo, hi, n); "
            f"names {names}"
        )
    return columns


def _fixed_keys(fixed: Mapping[str, float] | None) -> dict[str, Any]:
    """The keys of the coordinates that are not axes."""
    for name in fixed or {}:
        checks.choice(name, "fixed", COORDINATES)
    return dict(fixed or {})


def attractors_of(basins: Basins) -> list[Attractor]:
    """The attractors that the core found, with the exact motion or the exponents of each."""
    osc, r, clearance, load = basins.osc, basins.r, basins.clearance, basins.load
    columns = basins._result.tables["attractors"].columns
    names = ("name", "kind", "cycles", "state", "radius", "contraction", "growth")
    found = []
    for name, kind, cycles, end, *balls in zip(
        *(columns[name].decoded().tolist() for name in names), strict=True
    ):
        motion, exponents, state = None, None, as_state(np.array(end), clearance)
        if kind in ("periodic", "rest"):
            motion = motion_at(osc, r, clearance, load, np.array(end), cycles)
        if kind in ("quasi-periodic", "chaotic"):
            exponents = exponents_at(osc, r, clearance, load, state)
        found.append(Attractor(kind, name, motion, state, exponents, *balls))
    return found


def attractors_of_structure(basins: Basins) -> list[Attractor]:
    """The attractors of a structure that the core found, with the exact motion of each."""
    motions = structure_motions_of(basins)
    names, numbers = (basins._values("attractors", name) for name in ("name", "number"))
    if numbers.size and numbers.max() >= len(motions):
        raise ParameterError(
            f"attractors.number = {numbers.max()}: must be below {len(motions)}, the number of motions"
        )
    found = []
    for name, i in zip(names.tolist(), numbers.tolist(), strict=True):
        kind, ratio, _ = name.partition(" (")[0].partition("/")
        kind = kind if kind == "rest" or not ratio else "periodic"
        found.append(Attractor(kind, name, motions[i] if i >= 0 else None))
    return found


def exponents_at(
    osc: Oscillator, r: float, clearance: float, load: float, state: dict[str, float]
) -> Lyapunov | None:
    """The exponents of a motion that is not periodic, or None."""
    for cycles in EXPONENT_CYCLES:
        with contextlib.suppress(SingularError):
            return lyapunov(osc, r, clearance, cycles, state, load, EXPONENT_DISCARD)
    return None


def as_state(values: _Array, clearance: float) -> dict[str, float]:
    """A state of the core as a mapping, with the free mass between the walls within the allowed rounding."""
    t, x, x_dot, z, z_dot = values.tolist()
    half = 0.5 * clearance
    if abs(z - x) > half * (1 + 1e-9):
        z = x + math.copysign(half, z - x)
    return {"t": t, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot}


def motion_at(
    osc: Oscillator, r: float, clearance: float, load: float, end: _Array, cycles: int
) -> Motion | None:
    """The exact stable motion, with a period of the given number of load cycles, on which a final state lies; or
    None."""
    # the state may still approach the motion
    for length in (2 * cycles + 3, 20 * cycles):
        run = simulate(osc, r, clearance, length, state=as_state(end, clearance), load=load)
        with contextlib.suppress(VibroimpactError):
            found = attractor_at_end(run, cycles)
            if found is not None:
                return found
    return None
