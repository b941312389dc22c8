"""Names of the conditions that end a branch's or a zone's stable, admissible motions."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _core
from ..errors import ParameterError
from ..likeness import same
from ..model import Oscillator, Pattern
from ..motion import Motion

#: Codes of the core.
FOLD, FLIP, NEIMARK_SACKER, ZERO_APPROACH, GRAZING, REPETITION, EDGE, REST_VANISHES = range(1, 9)

#: Places of the parameters in the core.
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")


def can_be_symmetric(osc: Oscillator, pattern: Pattern) -> bool:
    """Whether a pattern has motions that are their own mirror image half a period later."""
    n = len(pattern)
    right, left = osc.restitution
    return (
        not pattern.has_rest
        and right == left
        and n % 2 == 0
        and pattern.cycles % 2 == 1
        and bool(np.all(np.roll(pattern.signs, n // 2) == -pattern.signs))
    )


def check_symmetric(symmetric: Any, osc: Oscillator, pattern: Pattern) -> None:
    """An error unless the value is a valid choice of motions, and the pattern has such motions."""
    if symmetric not in (None, True, False):
        raise ParameterError(f"symmetric = {symmetric!r}: must be None, True or False")
    if symmetric and not can_be_symmetric(osc, pattern):
        raise ParameterError(
            f"symmetric = True: must be None or False for {pattern.sides}/{pattern.cycles} with restitution "
            f"{osc.restitution!r}, which has no symmetric motion; that takes equal restitution, an odd number "
            "of cycles and a pattern whose second half is the mirror image of the first"
        )


def is_symmetric(motion: Motion) -> bool:
    """Whether a motion is its own mirror image half a period later."""
    return can_be_symmetric(motion.osc, motion.pattern) and same(motion, motion, mirrored=True)


def type_name(kind: int, index: int, symmetric: bool, mirrored: bool) -> str:
    """The field's name for a condition of the core that is zero.

    `symmetric`: the family consists of symmetric motions; `mirrored`: the first way in which a member can
    repeat itself is as its own mirror image.
    """
    name, _ = _core.condition_text(kind, index, 0, symmetric, mirrored)
    return name.tobytes().decode().strip()


def detail_text(kind: int, index: int, side: int) -> str:
    """Details of a condition: the flight and the wall of a touch, the impact without approach, or the bound;
    may be empty."""
    _, detail = _core.condition_text(kind, index, side, False, False)
    return detail.tobytes().decode().strip()
