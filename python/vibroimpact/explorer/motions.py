"""The motions at a point: quickly while the pointer moves, then by a fuller search."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from .. import Motion, Oscillator, Zone, exact, find, is_symmetric, motion_images, same_motion
from ..base.errors import SingularError
from .definition import Definition, definition_of
from .limits import Progress

__all__ = ["Shown", "fuller", "quick"]


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
    kept: Iterable[Shown] = (), progress: Progress | None = None,
) -> list[Shown]:  # fmt: skip
    """Motions of up to five impacts per cycle, from a few guesses, from the zones at the point and from known
    motions nearby.

    `zones` contain the point; `kept` are the motions known at the point; `progress` is as in `find`.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.explorer.motions import quick
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> [(shown.label, shown.motion.stable) for shown in quick(osc, 0.94, 37.0)][:2]
    [('2/1 RL', True), ('2/1 RL', True)]
    """
    found = find(osc, r, clearance, 5, 1, guesses=12, states=0, releases=8, progress=progress)
    more = [*_from_zones(osc, r, clearance, zones), *_followed(osc, r, clearance, known)]
    return ordered([*found, *more], kept, progress)


def fuller(
    osc: Oscillator, r: float, clearance: float, kept: Iterable[Shown] = (),
    progress: Progress | None = None,
) -> list[Shown]:  # fmt: skip
    """All motions that `find` finds with its usual limits, and those known here; `progress` is as in `find`."""
    return ordered(find(osc, r, clearance, progress=progress), kept, progress)


def ordered(
    motions: Iterable[Motion], kept: Iterable[Shown] = (), progress: Progress | None = None
) -> list[Shown]:
    """The motions, each once (with its mirror image if both walls have the same restitution), stable ones
    first."""
    shown = list(kept)
    for motion in motions:
        for image in motion_images(motion):
            if any(same_motion(image, other.motion) for other in shown):
                continue
            made = definition_of(image, progress)
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
    """The motions that continue those of a nearby point."""
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
    """The motions of zones that contain a point."""
    for zone in zones:
        motion = None if zone.osc != osc else zone.motion(r, clearance)
        if motion is not None:
            yield motion
