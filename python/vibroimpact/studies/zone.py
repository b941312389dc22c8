"""Zones of stable, admissible motions in the plane (r, d K/F0), with exact boundaries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import checks
from ..errors import ParameterError
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
        the window).
    r, clearance : ndarray (M,)
        Vertices in order; the first and the last are corners, where the next piece begins, unless the
        whole boundary is one piece.
    x, theta : ndarray (N, M)
        x_i/D and theta_i = alpha_i + tau of the motion at each vertex; of a motion with rest (1, M) the
        velocity over D and the load phase at the last release.
    loop : int
        The loop of `Zone.loops` that the piece belongs to.
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
    """

    motions: int
    steps: int
    untraced: int
    lines: tuple[int, int]


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
        Whether every boundary that was met could be followed until it closes. It says nothing of zones that
        were not met: see `search`.
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

        Parameters
        ----------
        r, clearance : array_like
            Broadcast against each other.

        Returns
        -------
        ndarray of bool
            False outside the window.
        """
        return self.count(r, clearance) > 0

    def count(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.int64]:
        """How many stable, admissible motions of the pattern there are; mirror images count once."""
        r, clearance = np.broadcast_arrays(
            checks.real_array(r, "r", "real numbers"),
            checks.real_array(clearance, "clearance", "real numbers"),
        )
        points = np.stack([r.ravel(), clearance.ravel()], axis=1)
        total = np.zeros(len(points), dtype=np.int64)
        for ring in self.loops:
            total += winding(ring, points)
        return total.reshape(r.shape)

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
