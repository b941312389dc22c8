"""The zones of the chart: families of motions and their zones, first coarse, then fine."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .. import Oscillator, Pattern, Zone, zone
from .state import pattern_text

__all__ = ["COARSE", "FINE", "Family", "compute", "families"]

#: Lowest and highest r, lowest and highest clearance.
Window = tuple[tuple[float, float], tuple[float, float]]
#: Numbers of lattice lines, and the guesses at a node for each, as in `zone`: the coarse ones find nearly all
#: motions in a sixth of the time.
COARSE, FINE = 5, 17
GUESSES = {COARSE: 4, FINE: 12}


class Family(NamedTuple):
    """A family of motions that share one zone."""

    pattern: Pattern
    symmetric: bool | None

    @property
    def name(self) -> str:
        """The name in the legend."""
        kind = {True: " symmetric", False: " unsymmetric", None: ""}[self.symmetric]
        return pattern_text(self.pattern) + kind

    @property
    def short(self) -> str:
        """The name in the chart."""
        return self.name.replace("metric", ".")


def families(osc: Oscillator, patterns: Iterable[Pattern]) -> Iterator[Family]:
    """The families of some patterns: symmetric motions have a separate zone, and mirror images share a zone.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.explorer.zones import families
    >>> patterns = [vi.Pattern("RL"), vi.Pattern("RRL"), vi.Pattern("RLL")]
    >>> [family.name for family in families(vi.Oscillator(xi=0.01, mu=0.03, restitution=0.75), patterns)]
    ['RL symmetric', 'RL unsymmetric', 'RRL']
    """
    alike = osc.restitution[0] == osc.restitution[1]
    for pattern in dict.fromkeys(pattern.standard(alike) for pattern in patterns):
        kinds = (True, False) if _can_be_symmetric(osc, pattern) else (None,)
        yield from (Family(pattern, kind) for kind in kinds)


def _can_be_symmetric(osc: Oscillator, pattern: Pattern) -> bool:
    """Whether a pattern has motions that are their own mirror image half a period later."""
    half, odd = divmod(len(pattern), 2)
    right, left = osc.restitution
    if pattern.has_rest or right != left or odd or pattern.cycles % 2 == 0:
        return False
    return bool(np.all(pattern.signs[:half] == -pattern.signs[half:]))


@lru_cache(maxsize=500)
def lines_of(zone: Zone) -> int:
    """The number of lattice lines with which a zone was requested; a large window gets more."""
    return int(re.findall(r"\blines = (\d+)", zone.case)[0])


def compute(
    osc: Oscillator, family: Family, window: Window, lines: int,
    progress: Callable[[float, str], None] | None = None,
) -> Zone:  # fmt: skip
    """The zone of a family; an exception of `progress` ends the search."""
    guesses = GUESSES[lines]
    return zone(osc, family.pattern, *window, family.symmetric, lines, guesses, progress=progress)
