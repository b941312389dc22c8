"""Zones of stable, admissible motions in the plane of two parameters, with exact boundaries."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.actions import ACTIONS
from ..base.errors import OpenBoundaryWarning, ParameterError, ParameterTypeError, SingularError
from ..base.spacing import ends_of
from ..motions.exact import exact_structure, newton
from ..motions.likeness import is_symmetric, standard_motion
from ..motions.motion import Motion, MotionSet
from ..results import door
from ..results.namelist import symmetric_word
from ..results.noun import Noun
from ..results.parameters import Path, Span, keys_of_parameter
from ..results.tables import runs
from ..systems.oscillator import Oscillator, Pattern, pattern_of
from ..systems.structure import Load, Structure
from ..systems.units import argument, of_parameter
from ..systems.verbs import every_system, physical_arguments
from .branch import Followed, branch_structure, run_from
from .geometry import signed_area, winding

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Piece", "Zone", "ZoneSearch", "zone"]

_Array = NDArray[np.float64]
#: (lowest, highest) of r and of the clearance.
Window = tuple[tuple[float, float], tuple[float, float]]
#: The columns of vertices: coordinates, and the motions there.
VERTICES = {True: ("x", "y", "speeds", "phases"), False: ("r", "clearance", "x", "theta")}


@dataclass(frozen=True, eq=False, repr=False)
class Piece:
    """A piece of a boundary along which one condition is zero.

    Attributes
    ----------
    type : str
        fold, pitchfork, flip, neimark_sacker, grazing, zero_approach, or window (the edge of the window); with
        rests also rest_vanishes and rest_splits (beyond it there are two rests); for a structure also branch_point
        (a pitchfork or transcritical point where simultaneous impacts separate), simultaneous (two events at the
        same instant), and stick_begins, stick_vanishes, contact_vanishes, flight_vanishes and, of self-excited
        motions, event_vanishes, as for `branch`; or joint, a straight piece of at most 1e-4 of the window between
        two loose ends of the boundary, where it could not be followed; or cut, the straight edge of a strip of the
        window that is cut out, with rests, stops or friction, because the boundary could not be closed in it.
    x, y : ndarray (M,)
        Vertices in order, in the plane of the zone; the first and the last are corners, where the next piece
        begins, unless the whole boundary is one piece.
    loop : int
        The loop of `Zone.loops` to which the piece belongs; -1 for an open boundary.
    detail : str
        For grazing: which flight touches which wall or gap; for window: which edge; for cut: which parameter is
        constant; for a structure also which impact.
    symmetric : bool
        Whether the piece bounds motions that are their own image half a period later.
    r, clearance : ndarray (M,)
        For an oscillator: x and y.
    x_over_D, theta : ndarray (N, M)
        For an oscillator: x_i/D and theta_i = alpha_i + tau of the motion at each vertex; for a motion with rest,
        (1, M): the velocity over D and the load phase at the last release.
    speeds, phases : ndarray (N, M)
        For a structure: approach speeds and load phases (rad) of the impacts of the motion at each vertex; with
        rests, stops or friction the speeds are NaN, and only the first impacts of each accumulation are listed.
        For self-excited motions phases are 2 pi times the fraction of the period, as along a `Branch`.
    period : ndarray (M,)
        For self-excited motions: the period at each vertex.
    """

    study: ClassVar[str] = "zone"
    type: str
    x: _Array
    y: _Array
    loop: int
    detail: str
    symmetric: bool
    _motions: tuple[_Array, _Array]
    _of_structure: bool
    _period: _Array | None = None

    @property
    def r(self) -> _Array:
        """For an oscillator: frequency ratio Omega/omega at the vertices (M,)."""
        return self._own("r", self.x)

    @property
    def clearance(self) -> _Array:
        """For an oscillator: clearance d K/F0 at the vertices (M,)."""
        return self._own("clearance", self.y)

    @property
    def x_over_D(self) -> _Array:
        """For an oscillator: position of the primary mass at each impact, over D, at the vertices (N, M)."""
        return self._own("x_over_D", self._motions[0])

    @property
    def theta(self) -> _Array:
        """For an oscillator: phase alpha_i + tau of each impact at the vertices (N, M), in radians."""
        return self._own("theta", self._motions[1])

    @property
    def speeds(self) -> _Array:
        """For a structure: approach speed of each impact at the vertices (N, M)."""
        return self._own("speeds", self._motions[0], True)

    @property
    def phases(self) -> _Array:
        """For a structure: load phase of each impact at the vertices (N, M), in radians."""
        return self._own("phases", self._motions[1], True)

    @property
    def period(self) -> _Array:
        """For self-excited motions: the period at the vertices (M,)."""
        if self._period is None:
            raise AttributeError("period: only a Piece of self-excited motions has it")
        return self._period

    def _own(self, name: str, values: _Array, of_structure: bool = False) -> _Array:
        """The values of an attribute that only pieces of one kind of system have."""
        if of_structure == self._of_structure:
            return values
        system, instead = (
            ("a Structure", "speeds and phases") if self._of_structure
            else ("an Oscillator", "x_over_D and theta")
        )  # fmt: skip
        raise AttributeError(
            f"{name}: a Piece of {system} does not have it; it has x, y, {instead}"
        )

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        detail = f" ({self.detail})" if self.detail else ""
        x, y = ("x", "y") if self._of_structure else ("r", "d K/F0")
        return (
            f"<{self.type}{detail}: {len(self)} points, {x} {self.x.min():.6g} to {self.x.max():.6g}, "
            f"{y} {self.y.min():.6g} to {self.y.max():.6g}>"
        )


@dataclass(frozen=True)
class ZoneSearch:
    """The extent of the search for a zone.

    Attributes
    ----------
    motions : int
        Number of motions at nodes of the lattice.
    steps : int
        Number of steps along the lattice lines on all sheets of motions.
    untraced : int
        Number of points on boundaries from which the boundary could not be followed.
    lines : (int, int)
        Lattice lines of constant x and of constant y: parts of a zone between them that touch no line may
        have been missed.
    open_seeds : list of (float, float)
        For an oscillator: r and d K/F0 of the seeds that are stable, admissible and inside the window, but around
        which no boundary could be closed.
    """

    motions: int
    steps: int
    untraced: int
    lines: tuple[int, int]
    open_seeds: list[tuple[float, float]] = field(default_factory=list)


class OnPlane(Noun):
    """The common base of zones and atlases: the window of a plane."""

    __slots__ = ()

    @property
    def r(self) -> tuple[float, float]:
        """For an oscillator: lowest and highest frequency ratio of the window."""
        return self._window("r")

    @property
    def clearance(self) -> tuple[float, float]:
        """For an oscillator: lowest and highest clearance d K/F0 of the window."""
        return self._window("clearance")

    def _window(self, name: str) -> tuple[float, float]:
        """The bounds of an axis of an oscillator."""
        if self.of_structure:
            raise AttributeError(self._lack(name, "x and y"))
        return self.keys[f"{name}_min"], self.keys[f"{name}_max"]

    @property
    def x(self) -> tuple[float, float]:
        """Lowest and highest value of the first parameter of the window."""
        return (self.keys["x_low"], self.keys["x_high"]) if self.of_structure else self.r

    @property
    def y(self) -> tuple[float, float]:
        """Lowest and highest value of the second parameter of the window."""
        return (self.keys["y_low"], self.keys["y_high"]) if self.of_structure else self.clearance

    @property
    def x_parameter(self) -> str:
        """Name of the first parameter: "r" for an oscillator, "function" for a function."""
        return str(self.keys["x"]) if self.of_structure else "r"

    @property
    def y_parameter(self) -> str:
        """Name of the second parameter: "clearance" for an oscillator, "function" for a function."""
        return str(self.keys["y"]) if self.of_structure else "clearance"


class Zone(OnPlane, Followed, study="zone", formerly="StructureZone"):
    """The region, within a window of the plane of two parameters, where motions are stable and admissible.

    For an oscillator, the plane is (r, d K/F0), and the zone covers all motions of a pattern. For a structure, the
    plane is that of any two parameters, and the motions are those connected with the motion from which the search
    started.

    Attributes
    ----------
    x_parameter, y_parameter : str
        "r" and "clearance" for an oscillator; "function" for a function.
    x, y : (float, float)
        The window.
    boundary : list of Piece
    loops : list of ndarray (M, 2)
        Closed rings of (x, y), counter-clockwise around a zone and clockwise around a hole; for an oscillator fine
        enough that the polygon is within 1e-7 of the curve (in the window scaled to the unit square of r and log
        D).
    closed : bool
        Whether every boundary that was found could be closed, and every seed is enclosed. The known parts of a
        boundary that could not be closed are in `open_boundary`; with rest they lie in narrow strips, and the zone
        is closed along the edges of the strips. True does not mean that all zones were found: see `search`.
    search : ZoneSearch
    cycles : int
        Load cycles in a period.
    self_excited : bool
        Whether the motions are self-excited; each `Piece` then has their `period`.
    osc, pattern : Oscillator, Pattern
        For an oscillator.
    r, clearance : (float, float)
        For an oscillator: x and y.
    symmetric : bool or None
        For an oscillator: only motions that are their own mirror images (True), only other motions (False), or
        both (None).
    structure : Structure
        For a structure: the structure of the motion from which the search started.
    load : float, or Load
        1 for an oscillator; for a structure the load of the motion from which the search started.
    gaps : ndarray (N,)
        For a structure: the gap of each impact, from 0.
    case : str
        The case as a namelist; for a zone of an atlas, the case that searches only for its pattern.
    """

    __slots__ = ()
    _of_start = "motion"

    @property
    def pattern(self) -> Pattern:
        """For an oscillator: the pattern of the motions."""
        return Pattern(self._key("pattern", "sides"), self.keys["cycles"])

    @property
    def symmetric(self) -> bool | None:
        """For an oscillator: whether motions are their own mirror images; None for both kinds."""
        return {"yes": True, "no": False, "both": None}[self._key("symmetric", "symmetric")]

    def _key(self, attribute: str, name: str) -> Any:
        """The value of a key of a zone of an oscillator."""
        if self.of_structure:
            raise AttributeError(self._lack(attribute, "gaps and cycles"))
        return self.keys[name]

    @cached_property
    def boundary(self) -> list[Piece]:
        """The pieces of the boundary."""
        pieces, vertices = (self._result.tables[name] for name in ("pieces", "vertices"))
        labels = {name: item.decoded() for name, item in pieces.columns.items()}
        values = [vertices.columns[name].values for name in VERTICES[self.of_structure]]
        periods = vertices.columns["period"].values if self.self_excited else None
        n = None
        if not self.of_structure:
            n = 1 if self.pattern.has_rest else len(self.pattern)
        found = []
        for i, here in enumerate(runs(vertices)):
            x, y, *motions = (item[here] for item in values)
            first, second = (item[:, :n].T for item in motions)
            loop, symmetric = int(labels["loop"][i]) - 1, bool(labels["symmetric"][i])
            kind, detail = str(labels["type"][i]), str(labels["detail"][i])
            own = (first, second), self.of_structure, None if periods is None else periods[here]
            found.append(Piece(kind, x, y, loop, detail, symmetric, *own))
        return found

    @cached_property
    def loops(self) -> list[_Array]:
        """Closed rings of vertices (x, y), each (M, 2)."""
        rings = self._result.tables["rings"]
        points = np.stack(
            [rings.columns[name].values for name in VERTICES[self.of_structure][:2]], axis=1
        )
        if not self.of_structure and not np.all(points[:, 1] > 0):  # in a damaged file
            raise ParameterError(f"rings.clearance = {points[:, 1].min()}: must be above 0")
        return [points[here] for here in runs(rings, self._result.tables["loops"].dims["ring"])]

    @property
    def closed(self) -> bool:
        """Whether every boundary that was found could be closed, and every seed is enclosed."""
        return bool(self._one("closed"))

    @property
    def search(self) -> ZoneSearch:
        """The extent of the search."""
        table = self._result.tables.get("open_seeds")
        r, clearance = (
            ([], []) if table is None
            else (table.columns[name].values.tolist() for name in ("r", "clearance"))
        )  # fmt: skip
        motions, steps, untraced = (
            int(self._one(name)) for name in ("motions", "steps", "untraced")
        )
        along_r, along_clearance = self._one("lines").tolist()
        seeds = list(zip(r, clearance, strict=True))
        return ZoneSearch(motions, steps, untraced, (along_r, along_clearance), seeds)

    def _one(self, name: str) -> Any:
        """A value of the table of the search."""
        return self._result.tables["families"].columns[name].values[0]

    def contains(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Whether there is a stable, admissible motion of the pattern, or of the family of a structure, at points.

        Only closed loops count. At points that an open boundary leaves undecided (`undecided`), the result is
        False, with an `OpenBoundaryWarning`.

        Parameters
        ----------
        x, y : array_like
            Values of the two parameters, r and d K/F0 of an oscillator, or with units, such as "19.5 Hz" and
            "4 mm"; broadcast against each other.

        Returns
        -------
        ndarray of bool
            False outside the window.
        """
        return self._counted(x, y) > 0

    def count(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.int64]:
        """Number of stable, admissible motions of the pattern or family at points; mirror images count once.

        At points that an open boundary leaves undecided it is a lower bound, with an `OpenBoundaryWarning`.

        Parameters
        ----------
        x, y : array_like
            As in `contains`.

        Returns
        -------
        ndarray of int
            In the shape of the points; 0 outside the window.
        """
        return self._counted(x, y)

    def _counted(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.int64]:
        """The result of `count`; a warning refers to the caller of the calling method."""
        if not self.closed and (number := int(np.sum(self.undecided(x, y)))):
            warnings.warn(
                f"{self!r}: whether it contains {number} of the points is not decided, since a boundary could "
                "not be closed; see Zone.undecided",
                OpenBoundaryWarning,
                stacklevel=3,
            )
        return self._turns(x, y)

    def _turns(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.int64]:
        """Winding numbers of the closed loops around points."""
        x, y = self._places(x, y)
        points = self._square(np.stack([x.ravel(), y.ravel()], axis=1))
        total = np.zeros(len(points), dtype=np.int64)
        for ring in self.loops:
            total += winding(self._square(ring), points)
        return total.reshape(x.shape)

    def _places(self, x: ArrayLike, y: ArrayLike) -> tuple[_Array, _Array]:
        """Points as two arrays of one shape."""
        names = ("x", "y") if self.of_structure else ("r", "clearance")
        x, y = self._plain(x, y)
        x, y = checks.one_shape(**dict(zip(names, (x, y), strict=True)))
        return x, y

    def _plain(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Points without units; those of an oscillator, also at a point with friction or stops, may have units if
        M, K and F0 are known."""
        if self.of_structure:
            names = self.x_parameter, self.y_parameter
            return tuple(
                of_parameter(self.structure, parameter, value, name)
                for parameter, value, name in zip(names, (x, y), ("x", "y"), strict=True)
            )
        return argument(self.osc, x, "r", "omega"), argument(self.osc, y, "clearance", "F0/K")

    def _square(self, points: _Array) -> _Array:
        """Points (M, 2) in the form that `winding` takes; for a structure they are scaled to the unit square, and
        the second coordinate is replaced by its exponential."""
        if not self.of_structure:
            return points
        # points may be arbitrarily far outside the window
        with np.errstate(over="ignore", invalid="ignore"):
            scaled = (points - (self.x[0], self.y[0])) / (np.ptp(self.x), np.ptp(self.y))
            return np.stack([scaled[:, 0], np.exp(scaled[:, 1])], axis=1)

    @property
    def open_boundary(self) -> list[Piece]:
        """The pieces of boundaries that could not be closed."""
        return [piece for piece in self.boundary if piece.loop < 0]

    def undecided(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Whether an open boundary leaves the existence of a stable, admissible motion at points undecided.

        A point of the window is undecided if it lies outside all closed loops and its line of constant x or of
        constant y meets an open piece or a seed that is not enclosed. If no part of the open boundary is known,
        all points outside closed loops are undecided.

        Parameters
        ----------
        x, y : array_like
            Values of the two parameters, r and d K/F0 of an oscillator; broadcast against each other.

        Returns
        -------
        ndarray of bool
            False everywhere if the zone is closed.
        """
        turns = self._turns(x, y)
        x, y = self._places(x, y)
        if self.closed:
            return np.zeros(x.shape, dtype=bool)
        low, high = zip(self.x, self.y, strict=True)
        window = (low[0] <= x) & (x <= high[0]) & (low[1] <= y) & (y <= high[1])
        known = [(piece.x, piece.y) for piece in self.open_boundary]
        known += [(np.array(a), np.array(b)) for a, b in self.search.open_seeds]
        met = np.full(x.shape, not known or self.search.untraced > 0)
        for a, b in known:
            met |= (a.min() <= x) & (x <= a.max())
            met |= (b.min() <= y) & (y <= b.max())
        return np.asarray(window & met & (turns <= 0))

    def at(self, x: float, y: float) -> tuple[Structure, Load]:
        """The structure and the load at values of both parameters, for a zone of a structure.

        Parameters
        ----------
        x, y : float
            Values of the two parameters.

        Returns
        -------
        (Structure, Load)
            The system with these values. The load of self-excited motions has no frequency.
        """
        structure, load = Path(self._result, *self._start, [self.x, self.y]).at(*self._place(x, y))
        return structure, Load(constant=load.constant) if self.self_excited else load

    def _place(self, x: float, y: float) -> list[float]:
        """A point of the plane of a structure."""
        return [
            checks.finite(value, name)
            for name, value in zip(("x", "y"), self._plain(x, y), strict=True)
        ]

    def motion(self, x: Any, y: Any) -> Any:
        """The motion at a point, followed from the boundary; for an oscillator, also at "19.5 Hz" and "4 mm".

        The motion is followed from the nearest vertex of each piece, then from other vertices, until a stable and
        admissible motion is found. If there is none, or no closed loop of an oscillator encloses the point, the
        first admissible motion from the nearest pieces is returned. Motions of structures with rests, stops or
        friction are followed from the motion where the search started, along branches on the straight line or
        along one parameter after the other. The result is None if no motion can be followed to the point, for
        motions of an oscillator with rest, and for motions with rests, stops or friction in a zone of an atlas.

        Parameters
        ----------
        x, y : float
            Values of the two parameters, r and d K/F0 of an oscillator.

        Returns
        -------
        Motion or None
            The motion at the point.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> zone = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=True)
        >>> zone.motion(1.1, 25.0)
        <Motion RL/1 at r = 1.1, d K/F0 = 25: admissible, stable (max|lambda| = 0.9262)>
        """
        if self.of_structure:
            return self._motion_of_structure(x, y)
        x, y = self._plain(x, y)
        return self._motion_of_oscillator(checks.number(x, "r"), checks.number(y, "clearance"))

    def _motion_of_oscillator(self, r: float, clearance: float) -> Motion | None:
        """As `motion`, for an oscillator."""
        if self.pattern.has_rest:
            return None
        r_size, d_size = np.ptp(self.r), np.ptp(np.log(self.clearance))
        vertices = []
        for piece in self.boundary:
            apart = np.hypot((piece.r - r) / r_size, np.log(piece.clearance / clearance) / d_size)
            nearest = int(np.argmin(apart))
            for j in {nearest, *np.linspace(0, len(piece) - 1, 20).astype(int).tolist()}:
                vertices.append((j != nearest, float(apart[j]), piece, j))
        vertices.sort(key=lambda vertex: vertex[:2])
        other = None
        for _, _, piece, j in vertices if self._turns(r, clearance) > 0 else vertices[:4]:
            found = self._followed(piece, j, r, clearance)
            if found is None or not self._has(found, piece):
                continue
            if found.stable:
                return found
            other = other or found
        return other

    def _has(self, motion: Motion, piece: Piece) -> bool:
        """Whether a motion followed from a piece is admissible and of the family of the piece.

        Near a pitchfork or a flip, Newton's method can converge to a motion that repeats itself.
        """
        return bool(
            motion.admissible and motion.consistent and is_symmetric(motion) == piece.symmetric
            and len(standard_motion(motion).pattern) == len(self.pattern)
        )  # fmt: skip

    def _followed(self, piece: Piece, j: int, r: float, clearance: float) -> Motion | None:
        """The motion at a point, followed from a vertex; None if it cannot be followed to the point."""
        x, theta = piece.x_over_D[:, j], piece.theta[:, j]
        begin, last = float(piece.clearance[j]), None
        for part in np.linspace(0, 1, 7)[1:].tolist():
            there = begin * (clearance / begin) ** part if part < 1 else clearance
            ratio = piece.r[j] + (r - piece.r[j]) * part if part < 1 else r
            try:
                last = newton(self.osc, float(ratio), there, 1.0, self.pattern, x * there, theta)
            except SingularError:
                return None
            x, theta = last.X / there, last.alpha + last.tau
        return last

    def _motion_of_structure(self, x: float, y: float) -> Motion | None:
        """As `motion`, for a structure."""
        target = np.array(self._place(x, y))
        if len(self.resting) or not self.structure._is_rigid:
            return self._followed_from_start(target)
        size = np.array([np.ptp(self.x), np.ptp(self.y)])
        vertices = []
        for piece in self.boundary:
            apart = np.linalg.norm((np.c_[piece.x, piece.y] - target) / size, axis=1)
            nearest = int(np.argmin(apart))
            # then other vertices: Newton's method can fail where two impacts are nearly simultaneous
            for j in {nearest, *np.linspace(0, len(piece) - 1, 5).astype(int).tolist()}:
                vertices.append((j != nearest, float(apart[j]), piece, j))
        other = None
        for _, _, piece, j in sorted(vertices, key=lambda vertex: vertex[:2]):
            found = self._followed_structure(
                np.array([piece.x[j], piece.y[j]]), piece.phases[:, j], target
            )
            if found is not None and found.stable:
                return found
            other = other or found
        return other

    def _followed_from_start(self, target: _Array) -> Motion | None:
        """The motion with rests, stops or friction at a point, followed from the motion where the search started:
        along the straight line, or along one parameter after the other."""
        begin, motions = self._origin
        found: Motion | None = None
        for corner in (target, np.array([target[0], begin[1]]), np.array([begin[0], target[1]])):
            reached = motions
            for start, end in ((begin, corner), (corner, target)):
                reached = [there for one in reached for there in self._along(one, start, end)]
            for motion in reached:
                if motion.stable:
                    return motion
                found = found or motion
        return found

    def _along(self, motion: Motion, start: _Array, end: _Array) -> list[Motion]:
        """The admissible motions at the end of a straight line, on the branch of the motion at its start."""
        if (start == end).all():
            return [motion]
        try:
            line = branch_structure(
                motion,
                lambda share: self.at(*(start + share * (end - start)).tolist()),
                (0.0, 1.0),
                at=0.0,
            )
            places = np.flatnonzero((line.values >= 1) & (line.admissible == 1))
            return [line[i] for i in places.tolist()]
        except (ParameterError, SingularError):
            return []

    @cached_property
    def _origin(self) -> tuple[_Array, list[Motion]]:
        """The point where the search of a structure started, and the motion there, if the case contains it."""
        path = Path(self._result, *self._start, [self.x, self.y])
        begin = np.array(path.start([self.keys.get("x_at"), self.keys.get("y_at")]))
        before, group, _ = self.case.rpartition("\n&zone\n")
        if not group or "\n&motion\n" not in before:
            return begin, []
        found = door.run_text(MotionSet, before + "\n", little=True)
        return begin, found.parts()

    def _followed_structure(self, start: _Array, phases: _Array, target: _Array) -> Motion | None:
        """The admissible motion at a point, followed from another point."""
        found, gaps = None, self.gaps
        for share in np.linspace(0, 1, 7)[1:]:
            place = start + share * (target - start) if share < 1 else target
            # impacts on two gaps may change their order, also across the end of the period
            phases = phases % (2 * np.pi * self.cycles)
            order = np.argsort(phases, kind="stable")
            gaps = gaps[order]
            guess = phases[order], gaps.tolist(), self.cycles
            try:
                found = exact_structure(*self.at(*place.tolist()), guess)
            except (ParameterError, SingularError):
                # two impacts on one gap at the same instant, or no motion near the guess
                return None
            phases = found.phases
        return found if found is not None and found.consistent and found.admissible else None

    @property
    def area(self) -> float:
        """Area in the plane (r, log D), or for a structure in the plane of both parameters.

        Areas of coexisting motions are added.
        """
        rings = self.loops
        if not self.of_structure:
            rings = [np.c_[ring[:, 0], np.log(ring[:, 1])] for ring in rings]
        return sum(map(signed_area, rings))

    def require(self) -> None:
        """SingularError if the search of a structure failed."""
        if self.of_structure and "pieces" not in self._result.tables:
            raise SingularError(self._result.notes[0][1])

    def parts(self) -> list[Any]:
        """The zone, unless the search of a structure failed.

        Returns
        -------
        list of Zone
            This zone alone, or nothing.
        """
        return [] if self._none else [self]

    @property
    def _none(self) -> bool:
        """Whether the search of a structure failed."""
        return self.of_structure and self._result.empty

    def __bool__(self) -> bool:
        return not self._none and bool(self.loops)

    @property
    def _log_clearance(self) -> bool:  # type: ignore[override]
        return not self.of_structure

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether it has a loop."""
        return bool(self)

    def prove(self, tolerance: float = 0.004, progress: door.Progress | None = None) -> Any:
        """Prove in ball arithmetic where in the window stable, admissible motions exist, and where none do.

        It needs the extra `proof`, and a zone of symmetric motions RL/k of an oscillator (symmetric=True, R1 = R2,
        k odd). The boundary of the zone is not used: boxes fill the plane of r and the phase of the load at the
        impact, in which d K/F0 is explicit, so that no motion is left out.

        Parameters
        ----------
        tolerance : float, optional
            The width in log D of the undecided strip along the boundary, relative to the window.
        progress : callable, optional
            Called with the fraction done and a note; by default a bar on a terminal or in a notebook.

        Returns
        -------
        Certificate
            With `decide`, `shares` and `plot` for the plane of r and d K/F0.

        Raises
        ------
        ParameterError
            If the zone is of another kind.
        MissingExtraError
            If python-flint is not installed.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> zone = vi.zone(osc, "RL", r=(1.04, 1.041), clearance=(20, 80), symmetric=True, lines=5)
        >>> proof = zone.prove(tolerance=0.05)
        >>> proof.decide(1.0405, 40.0), proof.decide(1.0405, 79.0)
        (True, False)
        """
        return ACTIONS["prove_zone"](self, tolerance, progress=progress)

    def plot(
        self, ax: Any = None, inverse: bool = False, label: str | None = None, units: Units | str | None = None,
    ) -> Any:  # fmt: skip
        """Draw the zone; the types of its boundary pieces differ by line style and colour.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        inverse : bool
            For an oscillator: draw F0/(d K) on the vertical axis, as in Figures 6 to 8 of the 1983 paper, instead
            of d K/F0.
        label : str, optional
            Text inside the zone; for an oscillator the pattern by default.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return self._draw(ax, inverse, label, units=units)

    def __repr__(self) -> str:
        if self._none:
            return "<Zone: none>"
        kinds = list(dict.fromkeys(piece.type for piece in self.boundary if piece.type != "window"))
        loops = f"{len(self.loops)} loop{'s' if len(self.loops) != 1 else ''}"
        if self.of_structure:
            what = f"over {self.x_parameter} and {self.y_parameter}"
        else:
            kind = {True: ", symmetric", False: ", unsymmetric", None: ""}[self.symmetric]
            what = f"{self.pattern.sides}/{self.pattern.cycles}{kind}"
        return (
            f"<Zone {what}: {loops}, bounded by {', '.join(kinds) or 'nothing'}"
            f"{'' if self.closed else ', NOT closed'}>"
        )


def default_label(pattern: Pattern, symmetric: bool | None) -> str:
    """Short name of a zone: 2e, 2u, 3, 4/2, RL*."""
    if pattern.has_rest:
        return pattern.sides if pattern.cycles == 1 else f"{pattern.sides}/{pattern.cycles}"
    kind = {True: "e" if len(pattern) == 2 else "s", False: "u", None: ""}[symmetric]
    if symmetric is False and len(pattern) != 2:
        kind = ""
    cycles = "" if pattern.cycles == 1 else f"/{pattern.cycles}"
    return f"{len(pattern)}{cycles}{kind}"


def window(r: Any, clearance: Any) -> dict[str, float]:
    """The keys of a window."""
    return span(r, "r") | span(clearance, "clearance")


def span(values: Any, name: str) -> dict[str, float]:
    """The keys of a pair (lowest, highest), whose values the core checks."""
    wanted = f"(lowest, highest) with lowest < highest, each {checks.allowed(name)}"
    low, high = ends_of(values, name, wanted)
    return {f"{name}_min": low, f"{name}_max": high}


#: The caller's names of the keys of a window.
NAMES = {
    "r_min": "r[0]", "r_max": "r[1]", "clearance_min": "clearance[0]", "clearance_max": "clearance[1]",
}  # fmt: skip
#: The caller's names of the choices of motions.
WORDS = {"sides": "pattern", "'yes'": "True", "'no'": "False", "'both'": "None"}


def zone_structure(
    motion: Motion,
    x: Span,
    y: Span,
    lines: int = 17,
    max_points: int = 20_000,
    progress: door.Progress | None = None,
    x_at: float | None = None,
    y_at: float | None = None,
) -> Zone:
    """As `zone`, for a motion of a structure."""
    keys, names = keys_of_plane(motion.structure, motion._given_load, (x, y), (x_at, y_at))
    keys |= {"lines": lines, "max_points": max_points}
    found = run_from(motion, Zone, keys, names, progress)
    found.require()
    return found


def keys_of_plane(
    structure: Structure, load: Load, axes: tuple[Any, Any], at: tuple[float | None, float | None]
) -> tuple[dict[str, Any], dict[str, str]]:
    """The keys of the plane of two parameters, and the caller's names of them."""
    keys: dict[str, Any] = {}
    names: dict[str, str] = {}
    for name, axis, start in zip("xy", axes, at, strict=True):
        wanted = "(parameter, (lo, hi)) or (parameter, lo, hi)"
        if not isinstance(axis, tuple) or len(axis) not in (2, 3):
            raise ParameterError(f"{name} = {axis!r}: must be {wanted}")
        pair = len(axis) == 2
        ends = ends_of(axis[1], f"{name}[1]", wanted) if pair else axis[1:]
        keys |= keys_of_parameter(structure, load, axis[0], ends, start, name, f"{name}_")
        low, high = (f"{name}[1][0]", f"{name}[1][1]") if pair else (f"{name}[1]", f"{name}[2]")
        names |= {name: f"{name}[0]", f"{name}_low": low, f"{name}_high": high}
    return keys, names


@overload
def zone(
    osc: Oscillator, pattern: Pattern | str, r: ArrayLike | tuple[Value, Value],
    clearance: ArrayLike | tuple[Value, Value],
    symmetric: bool | None = None, lines: int = 17, guesses: int = 12, seeds: Sequence[Motion] = (),
    max_points: int = 20_000, progress: door.Progress | None = None,
) -> Zone: ...  # fmt: skip
@overload
def zone(
    motion: Motion, x: Span, y: Span,
    lines: int = 17, max_points: int = 20_000, progress: door.Progress | None = None,
    x_at: float | None = None, y_at: float | None = None,
) -> Zone: ...  # fmt: skip


@physical_arguments
@every_system(
    zone_structure,
    Motion,
    no_point="give its osc, a pattern, and ranges of r and clearance",
)
def zone(
    osc: Oscillator,
    pattern: Pattern | str,
    r: tuple[float, float],
    clearance: tuple[float, float],
    symmetric: bool | None = None,
    lines: int = 17,
    guesses: int = 12,
    seeds: Sequence[Motion] = (),
    max_points: int = 20_000,
    progress: door.Progress | None = None,
) -> Zone:
    """The zones of stable, admissible motions in a window of two parameters, as closed curves of named pieces.

    For an oscillator: the zones of all motions of a pattern, in the plane (r, d K/F0). Motions of a pattern with
    rest are continued in the same way. Where a rest vanishes, the accumulation of impacts just fails to complete
    before the acceleration that closes the gap changes its sign; this boundary is accurate to about 1e-10.

    Motions are searched for by Newton's method at the nodes of a lattice over the window and, for patterns without
    rest, by simulation at points between the nodes; the search is longer for more impacts and if few motions are
    found. The motions are followed along the lattice lines on every sheet that was found, and on the sheets that
    begin at pitchforks and flips of symmetric motions and of motions of half the pattern on these lines. Where a
    line enters or leaves a zone, the boundary is traced by pseudo-arclength continuation of the motion together
    with the condition that is zero there (fold, flip, pitchfork, Neimark-Sacker, grazing, zero approach, or an
    edge of the window); where another condition becomes zero there is a corner, and the boundary continues along
    that condition.

    For a motion of a structure: the zone around it, in the plane of any two parameters. The motion is followed
    along the lines of a lattice over the window, and from each crossing of two lines further motions are followed,
    on every sheet that is reached; boundaries are traced in the same way. Motions with other impacts, and sheets
    that are not connected to the motion, have separate zones. With stops or friction a zone also ends where the
    sequence of events changes, as along a branch.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    pattern : Pattern or str
        At most 24 impacts.
    r, clearance : (float, float)
        The window: ranges (lo, hi) of the frequency ratio and of d K/F0, or arrays, of which only the ends are
        used; d is the whole travel of m between the walls.
    motion : Motion
        In place of the oscillator and the pattern: a motion of a structure, as accepted by `branch`.
    x, y : (parameter, (float, float))
        For a structure, in place of r and clearance: each a parameter, as in `branch`, with its lowest and highest
        value, or with an array, of which only the ends are used.
    symmetric : bool, optional
        Only motions that are their own mirror image half a period later (True; for two impacts these are the
        equispaced motions), only other motions (False), or both (None).
    lines : int
        Number of lattice lines in each direction over a window like that of the 1983 charts (r 0.8 to 1.2, and a
        factor 100 in d K/F0), 5 to 129. A larger window gets more lines, in proportion to the logarithm of d K/F0
        and to asinh(10 (r - 1)), and one more at each resonance r = 1/n; a pattern with rest gets at least 33.
        Parts of a zone that touch no line can be missed: more lines find more. For a structure, the number of
        lines in each direction for any window.
    guesses : int
        Number of guesses for motions at every second node in each direction, and a quarter of this number at the
        other nodes. For motions of many impacts the search is repeated with further guesses as long as these find
        new sheets. With 0, only the seeds are used.
    seeds : sequence of Motion
        Known motions of the pattern that the search could miss. From each stable and admissible seed a line is
        followed to the boundary of its zone. If this boundary was not known, or the seed is not stable and
        admissible, motions are followed through the window along the lines of constant r and of constant d K/F0
        through the seed, and every boundary that they meet is traced. Each seed that is stable, admissible and
        inside the window is then in the zone or in `search.open_seeds`.
    max_points : int
        Largest number of vertices of a loop.
    progress : callable, optional
        Called a few times a second with the fraction done and the current task; an exception that it raises ends
        the search.
    x_at, y_at : float, optional
        For a structure: the value of the parameter at the motion, if the parameter is a function.

    Returns
    -------
    Zone
        The zone; it has no loops if no stable, admissible motion was found.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the pattern can have no such motions.
    SingularError
        If the motion of a structure cannot be followed, as in `branch`.

    Examples
    --------
    The equispaced motion of Figure 6:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> equispaced = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=True)
    >>> equispaced
    <Zone RL/1, symmetric: 1 loop, bounded by pitchfork, neimark_sacker, fold>
    >>> equispaced.contains(1.04, [25.0, 3.0]).tolist()
    [True, False]

    The motion of the third column of Table 1 of the 1983 paper, with the system given by the matrices of its two
    masses:

    >>> import math
    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> phases = [0.517272128279 * math.pi, 1.899298624085 * math.pi]
    >>> motion = vi.exact(damper, vi.Load(0.94, sine=[1, 0]), (phases, [0, 1]))
    >>> zone = vi.zone(motion, x=("frequency", (0.8, 1.2)), y=("opening", (2.0, 40.0)))
    >>> zone, zone.contains(0.94, [10.0, 18.5])
    (<Zone over frequency and opening: 1 loop, bounded by flip, pitchfork>, array([False,  True]))
    """
    pattern = pattern_of(pattern)
    keys = {
        "sides": pattern.sides, "cycles": pattern.cycles, "symmetric": symmetric_word(symmetric),
        **window(r, clearance), "lines": lines, "guesses": guesses, "max_points": max_points,
        "seeds": seed_list(pattern, seeds) or None,
    }  # fmt: skip
    return door.run(Zone, osc, keys, progress=progress, parameters={**NAMES, **WORDS})


def seed_list(pattern: Pattern, seeds: Sequence[Motion]) -> list[float]:
    """Seeds in the form of the key: r, D, x_i/D and theta_i for each."""
    if not isinstance(seeds, Iterable):
        raise ParameterTypeError(f"seeds = {seeds!r}: must be a list of motions")
    numbers: list[float] = []
    for i, motion in enumerate(seeds):
        checks.instance(motion, f"seeds[{i}]", Motion)
        if motion.pattern != pattern:
            raise ParameterError(
                f"seeds[{i}].pattern = {motion.pattern!r}: must be {pattern!r}, with the same first impact"
            )
        own = np.r_[motion.X / motion.clearance, motion.alpha + motion.tau]
        if pattern.has_rest:
            # the release at the end of the last starred symbol
            side = [symbol for symbol in pattern.symbols if symbol.endswith("*")][-1][0]
            events = motion.events
            release = events[(events["kind"] == "release") & (events["side"] == side)][-1]
            own = np.zeros(2 * len(pattern))
            own[:2] = release["phase"], release["x_dot_after"] / motion.clearance
        numbers += [motion.r, motion.clearance, *own.tolist()]
    return numbers
