"""Motions that are their own mirror images half a period later."""

from __future__ import annotations

import numpy as np

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


def is_symmetric(motion: Motion) -> bool:
    """Whether a motion is its own mirror image half a period later."""
    return can_be_symmetric(motion.osc, motion.pattern) and same(motion, motion, mirrored=True)
