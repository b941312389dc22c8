"""An atlas: all zones of stable motions in a window, found without being told the patterns."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core, checks
from ..errors import ParameterError
from ..find import side_patterns
from ..interchange import namelist
from ..interchange.result import Result, load
from ..interrupt import interruptible
from ..model import Oscillator, Pattern
from .conditions import can_be_symmetric
from .settling import thread_count
from .zone import Window, Zone, checked_window
from .zone_search import ROOM, assemble

__all__ = ["Atlas", "Attractor", "atlas"]

_Array = NDArray[np.float64]
#: The core's letters.
LETTERS = {1: "R", -1: "L", 2: "R*", -2: "L*"}


class Attractor(NamedTuple):
    """A periodic motion that a simulation settled on."""

    r: float
    clearance: float
    pattern: Pattern


@dataclass(frozen=True, eq=False, repr=False)
class Atlas(Result):
    """All zones found in a window.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : (float, float)
        The window.
    zones : list of Zone
        One for each pattern that has one, in the order of the search (also where only a boundary was found
        that could not be closed); motions that are their own mirror image in a zone of their own.
        With R1 = R2 a pattern stands for its mirror image too, whose zone is the same.
    attractors : list of Attractor
        What the survey by simulation settled on, within the limits of impacts and cycles.
    unexplained : list of Attractor
        Those that lie in no zone of their pattern: gaps of the atlas, or motions that only look periodic.
    case : str
        What was asked for as a namelist (see `to_namelist`).
    """

    osc: Oscillator
    r: tuple[float, float]
    clearance: tuple[float, float]
    zones: list[Zone]
    attractors: list[Attractor]
    unexplained: list[Attractor]
    case: str = ""

    def at(self, r: float, clearance: float) -> list[Zone]:
        """The zones that contain a point: the stable motions there."""
        return [zone for zone in self.zones if bool(zone.contains(r, clearance))]

    def explains(self, attractor: Attractor) -> bool:
        """Whether an attractor lies in a zone of its pattern."""
        return not unexplained(self.osc, self.zones, [attractor])

    @classmethod
    def load(cls, path: str | Path) -> Atlas:
        """Read an atlas that `save` wrote; see `vibroimpact.load`."""
        atlas = load(path)
        if not isinstance(atlas, cls):
            raise ParameterError(
                f"path = {str(path)!r}: must be a file that Atlas.save wrote, not a {type(atlas).__name__}"
            )
        return atlas

    def plot(self, ax: Any = None, inverse: bool = False) -> Any:
        """Draw all zones, each with its name; returns the Axes."""
        from ..plot.zone import draw_atlas

        return draw_atlas(self, ax, inverse)

    def __repr__(self) -> str:
        gaps = f", {len(self.unexplained)} attractors unexplained" if self.unexplained else ""
        return (
            f"<Atlas of {len(self.zones)} zones, {len(self.attractors)} attractors surveyed{gaps}>"
        )


def turns(pattern: Pattern) -> list[str]:
    """The sides from each letter on."""
    letters = pattern.letters
    return ["".join(letters[j:] + letters[:j]) for j in range(len(letters))]


def names_of(pattern: Pattern, osc: Oscillator) -> set[str]:
    """All sides that stand for a pattern: from each letter on and, with R1 = R2, mirrored."""
    names = set(turns(pattern))
    if osc.restitution[0] == osc.restitution[1]:
        names |= {name.translate(str.maketrans("RL", "LR")) for name in names}
    return names


def standard(pattern: Pattern, osc: Oscillator) -> Pattern:
    """The same pattern from the letter on that all agree on."""
    return Pattern(max(names_of(pattern, osc)), pattern.cycles)


def unexplained(osc: Oscillator, zones: list[Zone], attractors: list[Attractor]) -> list[Attractor]:
    """Those attractors that lie in no zone of their pattern; a zone looks at all of its own at once."""
    left = list(attractors)
    wanted = {pattern: names_of(pattern, osc) for pattern in {item.pattern for item in left}}
    for zone in zones:
        pattern = zone.pattern
        own = [
            item for item in left
            if pattern.sides in wanted[item.pattern] and pattern.cycles == item.pattern.cycles
        ]  # fmt: skip
        inside = zone.contains([item.r for item in own], [item.clearance for item in own])
        explained = {
            id(item) for item, held in zip(own, np.atleast_1d(inside), strict=True) if held
        }
        left = [item for item in left if id(item) not in explained]
    return left


def atlas(
    osc: Oscillator,
    r: tuple[float, float],
    clearance: tuple[float, float],
    max_impacts: int = 5,
    max_cycles: int = 1,
    survey: int = 400,
    settling: int = 400,
    lines: int = 17,
    guesses: int = 24,
    max_points: int = 20_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Atlas:
    """All zones of stable motions in a window, for all patterns up to a number of impacts and cycles.

    Patterns come from enumeration (all sequences of sides up to rotation, and up to the mirror image when
    R1 = R2) and from a survey by simulation over the window, which also finds those with rest. Each pattern's
    `zone` is traced; the surveyed attractors are seeds of it. Attractors that lie in no zone of their pattern
    afterwards are sought once more on a finer lattice, and listed as `unexplained` if that does not help.

    Parameters
    ----------
    osc : Oscillator
    r, clearance : (float, float)
        The window.
    max_impacts, max_cycles : int
        Limits of the patterns, 2 to 8 letters and 1 to 4 cycles; an accumulation counts as one letter.
    survey : int
        Points of the window at which simulations are let settle.
    settling : int
        Load cycles simulated at each before its attractor is looked at.
    lines, guesses, max_points : int
        As in `zone`.
    threads : int, optional
        Default: one for each processor. The answer does not depend on it.
    progress : callable, optional
        Called with the share done and what is being done.

    Returns
    -------
    Atlas

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> small = vi.atlas(osc, (1.0, 1.1), (20, 60), max_impacts=3, survey=20)
    >>> sorted({zone.pattern.sides for zone in small.zones})
    ['RL', 'RRL']
    """
    checks.instance(osc, "osc", Oscillator)
    window = checked_window(osc, r, clearance)
    max_impacts = checks.integer(max_impacts, "max_impacts", 2, 8)
    max_cycles = checks.integer(max_cycles, "max_cycles", 1, 4)
    survey = checks.integer(survey, "survey", 0, 10**6)
    settling = checks.integer(settling, "settling", 1, 10**6)
    lines = checks.integer(lines, "lines", 5, 129)
    guesses = checks.integer(guesses, "guesses", 0, 10**5)
    max_points = checks.integer(max_points, "max_points", 100, ROOM)
    workers = thread_count(threads)
    asked = namelist.case(osc, atlas={
        **namelist.window(*window), "max_impacts": max_impacts, "max_cycles": max_cycles, "survey": survey,
        "settling": settling, "lines": lines, "guesses": guesses, "max_points": max_points,
    })  # fmt: skip
    tell = progress or (lambda share, what: None)
    tell(0.0, "survey by simulation")
    attractors, guesses_of = surveyed(
        osc, window, survey, settling, max_impacts, max_cycles, workers
    )
    families = families_of(osc, attractors, max_impacts, max_cycles)

    def trace(family: tuple[Pattern, bool], finer: int = 1) -> Zone:
        pattern, symmetric = family
        seeds = [
            seed
            for seed, item in zip(guesses_of, attractors, strict=True)
            if item.pattern == pattern
        ]
        table = np.array(seeds).reshape(len(seeds), 2 + 2 * len(pattern)).T
        lattice = min(129, finer * (lines - 1) + 1)
        return assemble(
            osc,
            pattern,
            window,
            symmetric,
            [symmetric],
            lattice,
            guesses,
            np.asfortranarray(table),
            max_points,
        )

    zones: dict[tuple[Pattern, bool], Zone] = {}
    with ThreadPoolExecutor(workers) as pool:
        for i, (family, zone) in enumerate(zip(families, pool.map(trace, families), strict=True)):
            zones[family] = zone
            tell((i + 1) / (len(families) + 1), f"zone of {family[0].sides}/{family[0].cycles}")

    def result() -> Atlas:
        found = [zone for zone in zones.values() if zone or not zone.closed]
        return Atlas(
            osc, *window, found, attractors, unexplained(osc, found, attractors), asked
        )  # fmt: skip

    found = result()
    again = [f for f in families if f[0] in {item.pattern for item in found.unexplained}]
    if again:
        with ThreadPoolExecutor(workers) as pool:
            for family, zone in zip(again, pool.map(lambda f: trace(f, 2), again), strict=True):
                zones[family] = zone
        found = result()
    tell(1.0, "done")
    return found


def families_of(
    osc: Oscillator, attractors: list[Attractor], max_impacts: int, max_cycles: int
) -> list[tuple[Pattern, bool]]:
    """Patterns without rest up to a size and those with rest that were seen, each with its symmetry.

    They come in the order of the core's find_atlas, which does the same for namelists.
    """
    mirrored = osc.restitution[0] == osc.restitution[1]
    patterns = list(side_patterns(max_impacts, max_cycles, mirrored=mirrored))
    patterns += [item.pattern for item in attractors if item.pattern.has_rest]
    return [
        (pattern, symmetric)
        for pattern in dict.fromkeys(patterns)
        for symmetric in ((True, False) if can_be_symmetric(osc, pattern) else (False,))
    ]


def surveyed(
    osc: Oscillator, window: Window, points: int, settling: int, max_impacts: int, max_cycles: int,
    threads: int,
) -> tuple[list[Attractor], list[_Array]]:  # fmt: skip
    """What simulations over the window settle on, each with its unknowns as a seed of its zone."""
    places, letters, cycles, unknowns = interruptible(
        _core.survey, points, max_impacts, osc.xi, osc.mu, osc.restitution, *window, settling, max_cycles,
        threads,
    )  # fmt: skip
    attractors, seeds = [], []
    for j in np.flatnonzero(cycles).tolist():
        codes = letters[:, j][letters[:, j] != 0].tolist()
        pattern = Pattern("".join(LETTERS[code] for code in codes), int(cycles[j]))
        attractors.append(Attractor(float(places[0, j]), float(places[1, j]), pattern))
        seeds.append(np.r_[places[:, j], unknowns[: 2 * len(codes), j]])
    return attractors, seeds
