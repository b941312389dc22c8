"""Comparison of motions, which may extend over several periods, start at any impact, or be mirror images.

The core makes the comparison, with the same tolerance for all studies.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError, SingularError
from .exact import described_motion, found_motion, is_mirrored, parts_of
from .motion import Motion

__all__ = ["is_symmetric", "motion_images", "same_motion", "standard_motion"]


def standard_motion(motion: Motion, *, mirrored: bool = False) -> Motion:
    """A motion, or its mirror image, over its shortest period and with a standard first impact.

    The first impact is chosen such that R comes before L.

    The mirror image is x -> -x, R <-> L, half a cycle later; it is a motion if both walls have the same
    restitution.

    Parameters
    ----------
    motion : Motion
        A motion of an oscillator.
    mirrored : bool
        Whether to return the mirror image.

    Returns
    -------
    Motion
        The same motion, or its mirror image.

    Raises
    ------
    ParameterTypeError
        If `motion` is not a Motion.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 4.3], vi.Pattern("LR")))
    >>> vi.standard_motion(motion).pattern.sides
    'RL'
    """
    _check(motion)
    checks.truth(mirrored, "mirrored")
    system = (motion.osc, motion.r, motion.clearance, motion.load)
    changed, *answer = found_motion(
        *system, motion.pattern.cycles, *parts_of(motion), 2 if mirrored else 1
    )
    return described_motion(*system, answer) if changed else motion


def motion_images(motion: Motion) -> Iterator[Motion]:
    """A motion in standard form, and its mirror image if both walls have the same restitution.

    Parameters
    ----------
    motion : Motion
        A motion of an oscillator.

    Returns
    -------
    iterator of Motion
        One or two motions.

    Raises
    ------
    ParameterTypeError
        If `motion` is not a Motion.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 4.3], vi.Pattern("RL")))
    >>> [round(float(image.alpha[1]), 3) for image in vi.motion_images(motion)]
    [4.342, 1.941]
    """
    _check(motion)
    return _images(motion)


def _check(motion: Any) -> None:
    """Checks that a value is a motion of an oscillator."""
    checks.instance(motion, "motion", Motion)
    if motion.of_structure:
        raise ParameterTypeError(f"motion = {motion!r}: must be a motion of an oscillator")


def _images(motion: Motion) -> Iterator[Motion]:
    yield standard_motion(motion)
    if motion.osc.restitution[0] == motion.osc.restitution[1]:
        try:
            image = standard_motion(motion, mirrored=True)
        except SingularError:  # accurate to the limit of convergence, like the motion itself
            return
        yield image


def same_motion(one: Motion, other: Motion, *, mirrored: bool = False) -> bool:
    """Whether two motions of a system are the same or, with `mirrored`, mirror images of each other.

    The first impact of each does not matter. Motions of a structure are the same if they have the same period, the
    same gaps in order, phases within 1e-6 rad and speeds within 1e-6 of the largest one; of an accumulation, only
    impacts above 1e-3 of the largest speed are compared.

    Parameters
    ----------
    one, other : Motion
        Two motions of the same system.
    mirrored : bool
        For an oscillator: compare with the mirror image of the other.

    Returns
    -------
    bool
        Whether they are the same.

    Raises
    ------
    ParameterTypeError
        If one is not a motion, or they belong to different systems.
    ParameterError
        If `mirrored` is True for motions of a structure.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> one, other = vi.equispaced(osc, 0.94, 37.0)
    >>> vi.same_motion(one, other), vi.same_motion(one, one, mirrored=True)
    (False, True)

    A mass that hits one wall:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> load = vi.Load(1.0, cosine=[1])
    >>> motion = vi.exact(wall, load, ([0.1], [0]))
    >>> vi.same_motion(motion, vi.exact(wall, load, motion))
    True
    """
    checks.instance(one, "one", Motion)
    checks.instance(other, "other", Motion)
    checks.truth(mirrored, "mirrored")
    if one.of_structure != other.of_structure:
        raise ParameterTypeError(
            f"other = {other!r}: must be a motion of the same system as one, {one!r}"
        )
    if mirrored and one.of_structure:
        raise ParameterError("mirrored = True: must be False for motions of a structure")
    if one.cycles != other.cycles:
        return False
    if one.of_structure:
        if len(one.rests) != len(other.rests):
            return False
        impacts = ((m.gaps, m.phases, m.speeds) for m in (one, other))
        return bool(
            _core.same_impacts(*next(impacts), *next(impacts), one.cycles, int(len(one.rests) > 0))
        )
    first, second = parts_of(one), parts_of(other)
    if (
        (one.rest_events is None) != (other.rest_events is None)
        or len(one.pattern) != len(other.pattern)
        or first.releases.shape != second.releases.shape
    ):
        return False
    system = (one.osc.xi, one.r, one.load, one.clearance, one.cycles)
    return bool(_core.same_motion(*system, *first, *second, mirrored))


def is_symmetric(motion: Motion) -> bool:
    """Whether a motion without rest is its own mirror image half a period later (for a structure, -q).

    Parameters
    ----------
    motion : Motion
        A motion of an oscillator or of a structure.

    Returns
    -------
    bool
        False for a motion with rest.

    Raises
    ------
    ParameterTypeError
        If `motion` is not a Motion.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> vi.is_symmetric(vi.equispaced(osc, 0.94, 37.0)[0])
    True
    """
    checks.instance(motion, "motion", Motion)
    has_rest = len(motion.rests) > 0 if motion.of_structure else motion.pattern.has_rest
    return not has_rest and is_mirrored(motion)
