"""Zones of stable, admissible motions of structures in the plane of two parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..motions.structure_motion import StructureMotion, exact_structure
from ..results import door
from ..results.parameters import Parameter, Path, keys_of_parameter
from ..results.tables import runs
from ..systems.structure import Load, Structure
from .geometry import signed_area, winding
from .structure_branch import Followed, run_from

__all__ = ["StructurePiece", "StructureZone", "zone_structure"]

_Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class StructurePiece:
    """A piece of a boundary along which one condition is zero.

    Attributes
    ----------
    type : str
        fold, pitchfork, branch_point (a pitchfork or transcritical point where impacts at one instant part), flip,
        neimark_sacker, grazing, zero_approach, simultaneous (impacts on two gaps at one instant), window (an edge
        of the window), or joint, a straight piece between two loose ends.
    x, y : ndarray (M,)
        Vertices in order; the first and the last are corners, unless the whole boundary is one piece.
    speeds, phases : ndarray (N, M)
        Approach speeds and load phases (rad) of the impacts of the motion at each vertex.
    loop : int
        The loop of `StructureZone.loops` to which it belongs; -1 for an open boundary.
    detail : str
        Which flight touches which gap, which impact, which edge.
    symmetric : bool
        Whether it bounds motions that are their own image half a period later.
    """

    type: str
    x: _Array
    y: _Array
    speeds: _Array
    phases: _Array
    loop: int
    detail: str = ""
    symmetric: bool = False

    def __len__(self) -> int:
        return len(self.x)

    def __repr__(self) -> str:
        detail = f" ({self.detail})" if self.detail else ""
        return (
            f"<{self.type}{detail}: {len(self)} points, x {self.x.min():.6g} to {self.x.max():.6g}, "
            f"y {self.y.min():.6g} to {self.y.max():.6g}>"
        )


class StructureZone(Followed, study="zone_structure"):
    """The region of the plane of two parameters where motions of a structure are stable and admissible.

    Attributes
    ----------
    x_parameter, y_parameter : str
        Their names; "function" for a function.
    x, y : (float, float)
        The window.
    structure : Structure
    load : Load
        Those of the motion from which the search started.
    gaps : ndarray (N,)
        The gap of each impact, from 0.
    cycles : int
        Load cycles in a period.
    boundary : list of StructurePiece
    loops : list of ndarray (M, 2)
        Closed rings of (x, y), counter-clockwise around a zone and clockwise around a hole.
    closed : bool
        Whether every boundary that was found could be closed.
    case : str
        What was asked for as a namelist.
    """

    __slots__ = ()
    _of_start = "motion"

    @property
    def x_parameter(self) -> str:
        return str(self.keys["x"])

    @property
    def y_parameter(self) -> str:
        return str(self.keys["y"])

    @property
    def x(self) -> tuple[float, float]:
        return self.keys["x_low"], self.keys["x_high"]

    @property
    def y(self) -> tuple[float, float]:
        return self.keys["y_low"], self.keys["y_high"]

    @property
    def closed(self) -> bool:
        return bool(self._one("closed", "families"))

    @cached_property
    def boundary(self) -> list[StructurePiece]:
        pieces, vertices = (self._result.tables[name] for name in ("pieces", "vertices"))
        labels = {name: item.decoded() for name, item in pieces.columns.items()}
        values = [vertices.columns[name].values for name in ("x", "y", "speeds", "phases")]
        found = []
        for i, here in enumerate(runs(vertices)):
            x, y, speeds, phases = (item[here] for item in values)
            found.append(
                StructurePiece(
                    str(labels["type"][i]), x, y, speeds.T, phases.T, int(labels["loop"][i]) - 1,
                    str(labels["detail"][i]), bool(labels["symmetric"][i]),
                )
            )  # fmt: skip
        return found

    @cached_property
    def loops(self) -> list[_Array]:
        rings = self._result.tables["rings"]
        points = np.stack([rings.columns[name].values for name in ("x", "y")], axis=1)
        return [points[here] for here in runs(rings, self._result.tables["loops"].dims["ring"])]

    def contains(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.bool_]:
        """Whether there is a stable, admissible motion of this family at points; only closed loops count.

        Parameters
        ----------
        x, y : array_like
            Broadcast against each other.

        Returns
        -------
        ndarray of bool
            False outside the window.
        """
        xs, ys = checks.one_shape(x=x, y=y)
        points = self._square(np.stack([xs.ravel(), ys.ravel()], axis=1))
        total = np.zeros(len(points), dtype=np.int64)
        for ring in self.loops:
            total += winding(self._square(ring), points)
        return np.asarray(total.reshape(xs.shape) > 0)

    def _square(self, points: _Array) -> _Array:
        """Points (M, 2) in the unit square, with the exponential of the second coordinate."""
        # a point may be as far outside the window as numbers go
        with np.errstate(over="ignore", invalid="ignore"):
            scaled = (points - (self.x[0], self.y[0])) / (np.ptp(self.x), np.ptp(self.y))
            return np.stack([scaled[:, 0], np.exp(scaled[:, 1])], axis=1)

    def at(self, x: float, y: float) -> tuple[Structure, Load]:
        """The structure and the load at values of both parameters."""
        place = [checks.to_float(value, "x, y", "finite numbers") for value in (x, y)]
        return Path(self._result, *self._start, [self.x, self.y]).at(*place)

    def motion(self, x: float, y: float) -> StructureMotion | None:
        """The motion at a point, followed from the nearest vertex of each piece of the boundary, then from others.

        The first one that is stable and admissible; otherwise the first admissible one. None if none can be
        followed so far.
        """
        target = np.array([checks.to_float(value, "x, y", "finite numbers") for value in (x, y)])
        size = np.array([np.ptp(self.x), np.ptp(self.y)])
        vertices = []
        for piece in self.boundary:
            apart = np.linalg.norm((np.c_[piece.x, piece.y] - target) / size, axis=1)
            nearest = int(np.argmin(apart))
            # later others: Newton's method can fail from where two impacts come together
            for j in {nearest, *np.linspace(0, len(piece) - 1, 5).astype(int).tolist()}:
                vertices.append((j != nearest, float(apart[j]), piece, j))
        other = None
        for _, _, piece, j in sorted(vertices, key=lambda vertex: vertex[:2]):
            found = self._followed(np.array([piece.x[j], piece.y[j]]), piece.phases[:, j], target)
            if found is not None and found.stable:
                return found
            other = other or found
        return other

    def _followed(self, start: _Array, phases: _Array, target: _Array) -> StructureMotion | None:
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
        """Area in the plane of both parameters; zones of motions that coexist are added."""
        return sum(signed_area(ring) for ring in self.loops)

    def require(self) -> None:
        """SingularError if there is no zone."""
        if "pieces" not in self._result.tables:
            raise SingularError(self._result.notes[0][1])

    def parts(self) -> list[Any]:
        """The zone, unless the search failed."""
        return [] if self._result.empty else [self]

    def __bool__(self) -> bool:
        return not self._result.empty and bool(self.loops)

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether it has a loop."""
        return bool(self)

    def plot(self, ax: Any = None, label: str = "") -> Any:
        """Draw the zone with its boundary pieces distinguished by line style and colour.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        label : str
            Written into the zone.

        Returns
        -------
        Axes
        """
        return self._draw(ax, label)

    def __repr__(self) -> str:
        if self._result.empty:
            return "<StructureZone: none>"
        kinds = list(dict.fromkeys(piece.type for piece in self.boundary if piece.type != "window"))
        loops = f"{len(self.loops)} loop{'s' if len(self.loops) != 1 else ''}"
        return (
            f"<StructureZone over {self.x_parameter} and {self.y_parameter}: {loops}, "
            f"bounded by {', '.join(kinds) or 'nothing'}{'' if self.closed else ', NOT closed'}>"
        )


def zone_structure(
    motion: StructureMotion,
    x: tuple[Parameter, float, float],
    y: tuple[Parameter, float, float],
    lines: int = 17,
    max_points: int = 20_000,
    progress: door.Progress | None = None,
    x_at: float | None = None,
    y_at: float | None = None,
) -> StructureZone:
    """The zone of stable, admissible motions around a motion of a structure, as closed curves of named pieces.

    The lines of a lattice over the window are followed through the motion and through each motion where two lines
    cross, on every sheet that they reach. Where a line enters or leaves a zone, the boundary is traced as by
    `vibroimpact.zone`, which calls this for a `StructureMotion`. Motions with other impacts, and sheets that are
    not connected to the motion, have zones of their own.

    Parameters
    ----------
    motion : StructureMotion
        Consistent and without rest, with at most 24 impacts (23 if a mode has frequency 0). It need be neither
        stable nor admissible.
    x, y : (parameter, float, float)
        Each a parameter, as in `vibroimpact.branch`, with its lowest and highest value.
    lines : int
        Lattice lines in each direction, 5 to 129. A part of the zone that touches no line can be missed.
    max_points : int
        Most vertices of a loop.
    progress : callable, optional
        As in `vibroimpact.zone`.
    x_at, y_at : float, optional
        The value of a parameter at the motion, if it is a function.

    Returns
    -------
    StructureZone

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    SingularError
        If the motion rests, or repeats itself.

    Examples
    --------
    The motion of the third column of Table 1 of the 1983 paper, by the matrices of its two masses:

    >>> import math, vibroimpact as vi
    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> phases = [0.517272128279 * math.pi, 1.899298624085 * math.pi]
    >>> motion = vi.exact(damper, vi.Load(0.94, sine=[1, 0]), (phases, [0, 1]))
    >>> zone = vi.zone(motion, x=("frequency", 0.8, 1.2), y=("opening", 2.0, 40.0))
    >>> zone, zone.contains(0.94, [10.0, 18.5])
    (<StructureZone over frequency and opening: 1 loop, bounded by flip, pitchfork>, array([False,  True]))
    """
    checks.instance(motion, "motion", StructureMotion)
    keys: dict[str, Any] = {}
    names: dict[str, str] = {}
    for name, axis, start in (("x", x, x_at), ("y", y, y_at)):
        wanted = "(parameter, lowest, highest)"
        if not isinstance(axis, tuple) or len(axis) != 3:
            raise ParameterError(f"{name} = {axis!r}: must be {wanted}")
        keys |= keys_of_parameter(
            motion.structure, motion.load, axis[0], axis[1:], start, name, f"{name}_"
        )
        names |= {name: f"{name}[0]", f"{name}_low": f"{name}[1]", f"{name}_high": f"{name}[2]"}
    keys |= {"lines": lines, "max_points": max_points}
    return run_from(motion, StructureZone, keys, names, progress)
