"""The motions at a point: quickly while the pointer moves, then by a fuller search."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..errors import SingularError
from ..likeness import images, is_symmetric, same
from ..model import Oscillator
from ..motion import Motion
from ..newton import exact, newton
from ..studies.find import find
from ..studies.zone import Zone
from .definition import Definition, definition_of

__all__ = ["Shown", "fuller", "quick"]

#: Steps from a zone's boundary to a point in it.
STEPS = 6


class Shown(NamedTuple):
    """A motion, and how to recompute it."""

    motion: Motion
    definition: Definition

    @property
    def label(self) -> str:
        """The label N/k, the sides, and whether it is its own mirror image."""
        pattern = self.motion.pattern
        kind = ", symmetric" if is_symmetric(self.motion) else ""
        return f"{len(pattern)}/{pattern.cycles} {pattern.sides}{kind}"


def quick(
    osc: Oscillator, r: float, clearance: float, zones: Iterable[Zone] = (), known: Iterable[Motion] = (),
    kept: Iterable[Shown] = (),
) -> list[Shown]:  # fmt: skip
    """Motions of up to five impacts a cycle from few guesses, from the zones here and from those known nearby.

    `zones` contain the point; `kept` are those known here.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.explorer.motions import quick
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> [(shown.label, shown.motion.stable) for shown in quick(osc, 0.94, 37.0)][:2]
    [('2/1 RL', True), ('2/1 RL', True)]
    """
    found = find(osc, r, clearance, 5, 1, guesses=12, states=0, releases=8)
    more = [*_from_zones(osc, r, clearance, zones), *_followed(osc, r, clearance, known)]
    return ordered([*found, *more], kept)


def fuller(
    osc: Oscillator, r: float, clearance: float, kept: Iterable[Shown] = (),
    progress: Callable[[float, str], None] | None = None,
) -> list[Shown]:  # fmt: skip
    """All motions that `find` finds with its usual limits, and those known here; `progress` as there."""
    return ordered(find(osc, r, clearance, progress=progress), kept)


def ordered(motions: Iterable[Motion], kept: Iterable[Shown] = ()) -> list[Shown]:
    """Each once, with its mirror image where the walls are alike; the stable ones first."""
    shown = list(kept)
    for motion in motions:
        for image in images(motion):
            if any(same(image, other.motion) for other in shown):
                continue
            made = definition_of(image)
            if made is not None:
                shown.append(Shown(made[1], made[0]))
    return sorted(shown, key=_order)


def _order(shown: Shown) -> tuple[bool, int, int, str, float]:
    motion, pattern = shown.motion, shown.motion.pattern
    place = -round(float(motion.X[0]) / motion.clearance, 6)
    return not motion.stable, pattern.cycles, len(pattern), pattern.sides, place


def _followed(
    osc: Oscillator, r: float, clearance: float, known: Iterable[Motion]
) -> Iterator[Motion]:
    """The motions to which those of a nearby point can be continued."""
    for motion in known:
        try:
            near = exact(osc, r, clearance, motion)
        except SingularError:
            continue
        if near.admissible and near.consistent:
            yield near


def _from_zones(
    osc: Oscillator, r: float, clearance: float, zones: Iterable[Zone]
) -> Iterator[Motion]:
    """The motions of zones that contain a point, followed from the nearest vertex of the boundary."""
    for zone in zones:
        if zone.pattern.has_rest or zone.osc != osc:
            continue
        r_size, d_size = np.ptp(zone.r), np.ptp(np.log(zone.clearance))
        distances = [
            np.hypot((piece.r - r) / r_size, np.log(piece.clearance / clearance) / d_size)
            for piece in zone.boundary
        ]
        best = min(range(len(distances)), key=lambda i: float(distances[i].min()))
        piece, j = zone.boundary[best], int(np.argmin(distances[best]))
        x, theta = piece.x[:, j], piece.theta[:, j]
        begin, last = float(piece.clearance[j]), None
        try:
            for part in np.linspace(0, 1, STEPS + 1)[1:].tolist():
                there = begin * (clearance / begin) ** part if part < 1 else clearance
                ratio = piece.r[j] + (r - piece.r[j]) * part if part < 1 else r
                last = newton(osc, float(ratio), there, 1.0, zone.pattern, x * there, theta)
                x, theta = last.X / there, last.phases + last.tau
        except SingularError:
            continue
        if last is not None and last.admissible and last.consistent:
            yield last
