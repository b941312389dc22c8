"""Motions that are their own mirror images half a period later."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ParameterError
from ..likeness import same
from ..model import Oscillator, Pattern
from ..motion import Motion


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
