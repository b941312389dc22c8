"""Zones of stable, admissible motions in the plane (r, d K/F0), with exact boundaries."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import OpenBoundaryWarning, ParameterError, ParameterTypeError, SingularError
from ..motions.exact import newton
from ..motions.likeness import is_symmetric, standard_motion
from ..motions.motion import Motion
from ..motions.structure_motion import StructureMotion
from ..results import door
from ..results.namelist import symmetric_word
from ..results.noun import Noun, key
from ..results.tables import runs
from ..systems.oscillator import Oscillator, Pattern, pattern_of
from ..systems.verbs import every_system
from .geometry import signed_area, winding
from .structure_zone import zone_structure

__all__ = ["Piece", "Zone", "ZoneSearch", "zone"]

_Array = NDArray[np.float64]
#: (lowest, highest) of r and of the clearance.
Window = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False, repr=False)
class Piece:
    """A piece of a boundary along which one condition is zero.

    Attributes
    ----------
    type : str
        fold, pitchfork, flip, neimark_sacker, grazing, zero_approach, rest_vanishes, rest_splits (beyond it
        the rest is two), or window (the edge of the window); or joint, a straight piece of at most 1e-4 of the
        window between two loose ends of the boundary, where it could not be followed; or cut, the straight edge
        of a strip of the window that is set apart, since the boundary could not be closed in it.
    r, clearance : ndarray (M,)
        Vertices in order; the first and the last are corners, where the next piece begins, unless the
        whole boundary is one piece.
    x, theta : ndarray (N, M)
        x_i/D and theta_i = alpha_i + tau of the motion at each vertex; of a motion with rest (1, M) the
        velocity over D and the load phase at the last release.
    loop : int
        The loop of `Zone.loops` to which the piece belongs; -1 for an open boundary.
    detail : str
        Of grazing: which flight touches which wall; of window: which edge; of cut: which parameter is constant.
    symmetric : bool
        Whether it bounds motions that are their own mirror image.
    """

    study: ClassVar[str] = "zone"
    type: str
    r: _Array
    clearance: _Array
    x: _Array
    theta: _Array
    loop: int
    detail: str = ""
    symmetric: bool = False

    def __len__(self) -> int:
        return len(self.r)

    def __repr__(self) -> str:
        detail = f" ({self.detail})" if self.detail else ""
        return (
            f"<{self.type}{detail}: {len(self)} points, r {self.r.min():.6g} to {self.r.max():.6g}, "
            f"d K/F0 {self.clearance.min():.6g} to {self.clearance.max():.6g}>"
        )


@dataclass(frozen=True)
class ZoneSearch:
    """How a zone was searched.

    Attributes
    ----------
    motions : int
        Motions at nodes of the lattice.
    steps : int
        Steps along the lattice lines on all parts of the surface of motions.
    untraced : int
        Number of places on a boundary from which it could not be followed.
    lines : (int, int)
        Lattice lines of constant r and of constant d K/F0: parts of a zone between them that touch no line may
        have been missed.
    open_seeds : list of (float, float)
        r and d K/F0 of the seeds that are stable, admissible and inside the window, but around which no
        boundary could be closed.
    """

    motions: int
    steps: int
    untraced: int
    lines: tuple[int, int]
    open_seeds: list[tuple[float, float]] = field(default_factory=list)


class Zone(Noun, study="zone"):
    """The region of a window of the plane (r, d K/F0) where a pattern's motions are stable and admissible.

    Attributes
    ----------
    osc, pattern
    r, clearance : (float, float)
        The window.
    symmetric : bool or None
        Only motions that are their own mirror images (True), only others (False), or both (None).
    boundary : list of Piece
    loops : list of ndarray (M, 2)
        Closed rings of (r, clearance), counter-clockwise around a zone and clockwise around a hole, so
        fine that the polygon is within 1e-7 of the curve (the window being the unit square, log D).
    closed : bool
        Whether every boundary that was found could be closed, and every seed is enclosed. The known parts of a
        boundary that could not be closed are in `open_boundary`; with rest they lie in narrow strips, and the
        zone is closed along their edges. Nothing is said about zones that were not
        found: see `search`.
    search : ZoneSearch
    case : str
        The case as a namelist; of a zone of an atlas, the search for its pattern alone.
    """

    __slots__ = ("__dict__",)
    r: tuple[float, float] = key("r_min", "r_max")
    clearance: tuple[float, float] = key("clearance_min", "clearance_max")

    @property
    def pattern(self) -> Pattern:
        return Pattern(self.keys["sides"], self.keys["cycles"])

    @property
    def symmetric(self) -> bool | None:
        return {"yes": True, "no": False, "both": None}[self.keys["symmetric"]]

    @cached_property
    def boundary(self) -> list[Piece]:
        pieces, vertices = (self._result.tables[name] for name in ("pieces", "vertices"))
        labels = {name: item.decoded() for name, item in pieces.columns.items()}
        values = [vertices.columns[name].values for name in ("r", "clearance", "x", "theta")]
        n = 1 if self.pattern.has_rest else len(self.pattern)
        found = []
        for i, here in enumerate(runs(vertices)):
            r, clearance, x, theta = (item[here] for item in values)
            loop, symmetric = int(labels["loop"][i]) - 1, bool(labels["symmetric"][i])
            x, theta = x[:, :n].T, theta[:, :n].T
            kind, detail = str(labels["type"][i]), str(labels["detail"][i])
            found.append(Piece(kind, r, clearance, x, theta, loop, detail, symmetric))
        return found

    @cached_property
    def loops(self) -> list[_Array]:
        rings = self._result.tables["rings"]
        points = np.stack([rings.columns[name].values for name in ("r", "clearance")], axis=1)
        if not np.all(points[:, 1] > 0):  # in a file that is broken
            raise ParameterError(f"rings.clearance = {points[:, 1].min()}: must be above 0")
        return [points[here] for here in runs(rings, self._result.tables["loops"].dims["ring"])]

    @property
    def closed(self) -> bool:
        return bool(self._one("closed"))

    @property
    def search(self) -> ZoneSearch:
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

    def contains(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.bool_]:
        """Whether there is a stable, admissible motion of the pattern at points.

        Only closed loops count. Where an open boundary leaves it undecided (`undecided`), the result is False,
        with an `OpenBoundaryWarning`.

        Parameters
        ----------
        r, clearance : array_like
            Broadcast against each other.

        Returns
        -------
        ndarray of bool
            False outside the window.
        """
        return self._counted(r, clearance) > 0

    def count(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """Number of stable, admissible motions of the pattern at points; mirror images count once.

        A lower bound where an open boundary leaves it undecided, with an `OpenBoundaryWarning`.
        """
        return self._counted(r, clearance)

    def _counted(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """The result of `count`; a warning refers to the caller of the calling method."""
        if not self.closed and (number := int(np.sum(self.undecided(r, clearance)))):
            warnings.warn(
                f"{self!r}: whether it contains {number} of the points is not decided, since a boundary could "
                "not be closed; see Zone.undecided",
                OpenBoundaryWarning,
                stacklevel=3,
            )
        return self._turns(r, clearance)

    def _turns(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """Winding numbers of the closed loops around points."""
        r, clearance = places(r, clearance)
        points = np.stack([r.ravel(), clearance.ravel()], axis=1)
        total = np.zeros(len(points), dtype=np.int64)
        for ring in self.loops:
            total += winding(ring, points)
        return total.reshape(r.shape)

    @property
    def open_boundary(self) -> list[Piece]:
        """The pieces of boundaries that could not be closed."""
        return [piece for piece in self.boundary if piece.loop < 0]

    def undecided(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.bool_]:
        """Whether an open boundary leaves it undecided whether there is a stable, admissible motion at points.

        This is so at points of the window in no closed loop whose line of constant r or of constant d K/F0
        meets an open piece or a seed that is not enclosed. If no part of the open boundary is known, it is so
        everywhere outside closed loops.

        Parameters
        ----------
        r, clearance : array_like
            Broadcast against each other.

        Returns
        -------
        ndarray of bool
            False everywhere if the zone is closed.
        """
        turns = self._turns(r, clearance)
        r, clearance = places(r, clearance)
        if self.closed:
            return np.zeros(r.shape, dtype=bool)
        low, high = zip(self.r, self.clearance, strict=True)
        window = (low[0] <= r) & (r <= high[0]) & (low[1] <= clearance) & (clearance <= high[1])
        known = [(piece.r, piece.clearance) for piece in self.open_boundary]
        known += [(np.array(a), np.array(b)) for a, b in self.search.open_seeds]
        met = np.full(r.shape, not known or self.search.untraced > 0)
        for a, b in known:
            met |= (a.min() <= r) & (r <= a.max())
            met |= (b.min() <= clearance) & (clearance <= b.max())
        return np.asarray(window & met & (turns <= 0))

    def motion(self, r: float, clearance: float) -> Motion | None:
        """The motion at a point, followed from the nearest vertex of each piece of the boundary, then from others.

        The first one that is stable and admissible; otherwise, or where no closed loop encloses the point, the
        first admissible one of the nearest pieces. None if none can be followed so far, and for patterns with
        rest.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> zone = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=True)
        >>> zone.motion(1.1, 25.0)
        <Motion RL/1 at r = 1.1, d K/F0 = 25: admissible, stable (max|lambda| = 0.9262)>
        """
        r, clearance = checks.number(r, "r"), checks.number(clearance, "clearance")
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

        Next to a pitchfork or a flip Newton's method can leave for motions that repeat themselves.
        """
        return bool(
            motion.admissible and motion.consistent and is_symmetric(motion) == piece.symmetric
            and len(standard_motion(motion).pattern) == len(self.pattern)
        )  # fmt: skip

    def _followed(self, piece: Piece, j: int, r: float, clearance: float) -> Motion | None:
        """The motion at a point, followed from a vertex; None if it cannot be followed so far."""
        x, theta = piece.x[:, j], piece.theta[:, j]
        begin, last = float(piece.clearance[j]), None
        for part in np.linspace(0, 1, 7)[1:].tolist():
            there = begin * (clearance / begin) ** part if part < 1 else clearance
            ratio = piece.r[j] + (r - piece.r[j]) * part if part < 1 else r
            try:
                last = newton(self.osc, float(ratio), there, 1.0, self.pattern, x * there, theta)
            except SingularError:
                return None
            x, theta = last.X / there, last.phases + last.tau
        return last

    @property
    def area(self) -> float:
        """Area in the plane (r, log D); zones of motions that coexist are added."""
        return sum(signed_area(np.c_[ring[:, 0], np.log(ring[:, 1])]) for ring in self.loops)

    def __bool__(self) -> bool:
        return bool(self.loops)

    _log_clearance = True

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether it has a loop."""
        return bool(self.loops)

    def plot(self, ax: Any = None, inverse: bool = False, label: str | None = None) -> Any:
        """Draw the zone with its boundary pieces distinguished by line style and colour.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        inverse : bool
            F0/(d K) upwards, as in Figures 6 to 8 of the 1983 paper, instead of d K/F0.
        label : str, optional
            Written into the zone; by default the pattern.

        Returns
        -------
        Axes
        """
        return self._draw(ax, inverse, label)

    def __repr__(self) -> str:
        kinds = list(dict.fromkeys(piece.type for piece in self.boundary if piece.type != "window"))
        kind = {True: ", symmetric", False: ", unsymmetric", None: ""}[self.symmetric]
        loops = f"{len(self.loops)} loop{'s' if len(self.loops) != 1 else ''}"
        return (
            f"<Zone {self.pattern.sides}/{self.pattern.cycles}{kind}: {loops}, "
            f"bounded by {', '.join(kinds) or 'nothing'}{'' if self.closed else ', NOT closed'}>"
        )


def places(r: ArrayLike, clearance: ArrayLike) -> tuple[_Array, _Array]:
    """Points as two arrays of one shape."""
    r, clearance = checks.one_shape(r=r, clearance=clearance)
    return r, clearance


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
    try:
        low, high = values
    except (TypeError, ValueError):
        raise ParameterError(f"{name} = {values!r}: must be {wanted}") from None
    return {f"{name}_min": low, f"{name}_max": high}


#: The caller's names of the keys of a window.
NAMES = {
    "r_min": "r[0]", "r_max": "r[1]", "clearance_min": "clearance[0]", "clearance_max": "clearance[1]",
}  # fmt: skip
#: The caller's names of the choices of motions.
WORDS = {"sides": "pattern", "'yes'": "True", "'no'": "False", "'both'": "None"}


@every_system(zone_structure, StructureMotion)
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
    """The zones of stable, admissible motions of a pattern, as closed curves of named pieces.

    Motions of a pattern with rest are continued in the same way. Where a rest vanishes, the accumulation of
    impacts just fails to complete before the acceleration that closes the gap changes its sign; that boundary
    is accurate to about 1e-10.

    Motions are searched by Newton's method at the nodes of a lattice over the window and, for patterns without
    rest, by simulation at points between them; the more impacts and the fewer motions found, the longer. The
    lattice lines are followed on every sheet of motions found, and on those that begin at the pitchforks and flips
    that the lines of the symmetric motions and of half the pattern meet. Where a line enters or leaves a zone, the
    boundary is traced by pseudo-arclength continuation of the motion together with the one condition that is zero
    there (fold, flip, pitchfork, Neimark-Sacker, grazing, zero approach, or an edge of the window); where another
    condition becomes zero there is a corner, and the boundary is followed along that one.

    Parameters
    ----------
    osc : Oscillator
    pattern : Pattern or str
        At most 24 impacts.
    r, clearance : (float, float)
        The window: lowest and highest frequency ratio and d K/F0; d is the whole travel of m between the walls.
    symmetric : bool, optional
        Only motions that are their own mirror image half a period later (True: the equispaced ones, of two
        impacts), only others (False), or both (None).
    lines : int
        Lattice lines in each direction over a window like that of the 1983 charts (r 0.8 to 1.2, and a factor
        100 in
        d K/F0), 5 to 129; a larger window gets more of them, in proportion to the logarithm of d K/F0 and to
        asinh(10 (r - 1)), and one more at each resonance r = 1/n; at least 33 are taken for a pattern with rest.
        Parts of a zone that touch no line can be missed: more lines find more.
    guesses : int
        Guesses for motions at every second node in each direction; a quarter of this number at the others. Both
        are searched again with further guesses as long as these find new sheets of motions of many impacts.
        With 0, only the seeds are used.
    seeds : sequence of Motion
        Known motions of the pattern that the search could miss. From each that is stable and admissible a line is
        followed to the boundary of its zone. If that was not known, or the seed is no such motion, the lines of
        constant r and of constant d K/F0 through it are followed through the window, and every boundary that they
        meet is traced: each seed that is stable, admissible and inside the window is in the zone or in
        `search.open_seeds`.
    max_points : int
        Most vertices of a loop.
    progress : callable, optional
        Called a few times a second with the share done and the present task; an exception of it ends the search.

    Returns
    -------
    Zone
        Without loops if no stable, admissible motion was found.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, or the pattern can have no such motions.

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
    """
    pattern = pattern_of(pattern)
    keys = {
        "sides": pattern.sides, "cycles": pattern.cycles, "symmetric": symmetric_word(symmetric),
        **window(r, clearance), "lines": lines, "guesses": guesses, "max_points": max_points,
        "seeds": seed_list(pattern, seeds) or None,
    }  # fmt: skip
    return door.run(Zone, osc, keys, progress=progress, parameters={**NAMES, **WORDS})


def seed_list(pattern: Pattern, seeds: Sequence[Motion]) -> list[float]:
    """Seeds in the form of the key: r, D, x_i/D, theta_i of each."""
    if not isinstance(seeds, Iterable):
        raise ParameterTypeError(f"seeds = {seeds!r}: must be a list of motions")
    numbers: list[float] = []
    for i, motion in enumerate(seeds):
        checks.instance(motion, f"seeds[{i}]", Motion)
        if motion.pattern != pattern:
            raise ParameterError(
                f"seeds[{i}].pattern = {motion.pattern!r}: must be {pattern!r}, with the same first impact"
            )
        own = np.r_[motion.X / motion.clearance, motion.phases + motion.tau]
        if pattern.has_rest:
            # the release at the end of the last starred symbol
            side = [symbol for symbol in pattern.symbols if symbol.endswith("*")][-1][0]
            events = motion.events
            release = events[(events["kind"] == "release") & (events["side"] == side)][-1]
            own = np.zeros(2 * len(pattern))
            own[:2] = release["phase"], release["x_dot_after"] / motion.clearance
        numbers += [motion.r, motion.clearance, *own.tolist()]
    return numbers
