"""Zones of stable, admissible motions in the plane (r, d K/F0), with exact boundaries."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import checks
from ..errors import OpenBoundaryWarning, ParameterError
from ..interchange.result import Result
from ..model import Oscillator, Pattern
from .geometry import signed_area, winding

__all__ = ["Piece", "Zone", "ZoneSearch"]

_Array = NDArray[np.float64]
Window = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False, repr=False)
class Piece:
    """A piece of a boundary along which one condition is zero.

    Attributes
    ----------
    type : str
        fold, pitchfork, flip, neimark_sacker, grazing, zero_approach, rest_vanishes, or window (the edge of
        the window); or joint, a straight piece of at most 1e-4 of the window between two loose ends of the
        boundary, where it could not be followed.
    r, clearance : ndarray (M,)
        Vertices in order; the first and the last are corners, where the next piece begins, unless the
        whole boundary is one piece.
    x, theta : ndarray (N, M)
        x_i/D and theta_i = alpha_i + tau of the motion at each vertex; of a motion with rest (1, M) the
        velocity over D and the load phase at the last release.
    loop : int
        The loop of `Zone.loops` that the piece belongs to; -1 of an open boundary, which is no loop.
    detail : str
        Of grazing: which flight touches which wall; of window: which edge.
    symmetric : bool
        Whether it bounds motions that are their own mirror image.
    """

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
        Steps along the lattice lines on all sheets.
    untraced : int
        Places on a boundary from which it could not be followed.
    lines : (int, int)
        Lattice lines of constant r and of constant d K/F0: what lies between them, touching none, can
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


@dataclass(frozen=True, eq=False, repr=False)
class Zone(Result):
    """Where a pattern's motions are stable and admissible, in a window of the plane (r, d K/F0).

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
        Whether every boundary that was met could be followed until it closes, and closes around every seed.
        What is known of one that could not is in `open_boundary`. It says nothing of zones that were not met:
        see `search`.
    search : ZoneSearch
    case : str
        What was asked for as a namelist; empty if none can tell (see `to_namelist`).
    """

    osc: Oscillator
    pattern: Pattern
    r: tuple[float, float]
    clearance: tuple[float, float]
    symmetric: bool | None
    boundary: list[Piece]
    loops: list[_Array]
    closed: bool
    search: ZoneSearch
    case: str = ""

    def contains(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.bool_]:
        """Whether there is a stable, admissible motion of the pattern at points.

        Only closed loops count. Where an open boundary leaves the answer open (`undecided`), it is False, with
        an `OpenBoundaryWarning`.

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
        """How many stable, admissible motions of the pattern there are; mirror images count once.

        At least so many where an open boundary leaves it open, with an `OpenBoundaryWarning`.
        """
        return self._counted(r, clearance)

    def _counted(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """What `count` gives, and a warning to the caller of what calls this."""
        if not self.closed and (number := int(np.sum(self.undecided(r, clearance)))):
            warnings.warn(
                f"{self!r}: whether it contains {number} of the points is not decided, since a boundary could "
                "not be closed; see Zone.undecided",
                OpenBoundaryWarning,
                stacklevel=3,
            )
        return self._turns(r, clearance)

    def _turns(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """How often the closed loops go round points."""
        r, clearance = places(r, clearance)
        points = np.stack([r.ravel(), clearance.ravel()], axis=1)
        total = np.zeros(len(points), dtype=np.int64)
        for ring in self.loops:
            total += winding(ring, points)
        return total.reshape(r.shape)

    @property
    def open_boundary(self) -> list[Piece]:
        """The pieces of boundaries that could not be followed until they close."""
        return [piece for piece in self.boundary if piece.loop < 0]

    def undecided(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.bool_]:
        """Whether an open boundary leaves it undecided if there is a stable, admissible motion at points.

        So it is at points of the window in no closed loop whose line of constant r or of constant d K/F0 meets
        an open piece or a seed around which nothing closed; everywhere in no closed loop if no part of the
        open boundary is known.

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

    @property
    def area(self) -> float:
        """Area in the plane (r, log D), of all sheets."""
        return sum(signed_area(np.c_[ring[:, 0], np.log(ring[:, 1])]) for ring in self.loops)

    def __bool__(self) -> bool:
        return bool(self.loops)

    def plot(self, ax: Any = None, inverse: bool = False, label: str | None = None) -> Any:
        """Draw the zone with its boundary pieces told apart by line style and colour.

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
        from ..plot.zone import draw_zone

        return draw_zone(self, ax, inverse, label)

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
    r, clearance = np.broadcast_arrays(
        checks.real_array(r, "r", "real numbers"),
        checks.real_array(clearance, "clearance", "real numbers"),
    )
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


def checked_window(osc: Oscillator, r: Any, clearance: Any) -> Window:
    """A window in which an oscillator has motions everywhere."""
    window = (span(r, "r"), span(clearance, "clearance"))
    if osc.xi == 0 and window[0][0] <= 1 <= window[0][1]:
        raise ParameterError(
            f"r = {r!r}: must not contain 1 when xi = 0 (resonance without damping)"
        )
    return window


def span(values: Any, name: str) -> tuple[float, float]:
    """A checked pair (lowest, highest)."""
    wanted = f"(lowest, highest) with lowest < highest, each {checks.allowed(name)}"
    try:
        low, high = values
    except (TypeError, ValueError):
        raise ParameterError(f"{name} = {values!r}: must be {wanted}") from None
    low, high = checks.number(low, name, f"{name}[0]"), checks.number(high, name, f"{name}[1]")
    if not low < high:
        raise ParameterError(f"{name} = {values!r}: must be {wanted}")
    return low, high
