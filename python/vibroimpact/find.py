"""Every periodic motion at a point that a systematic search finds, stable and unstable."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from . import _core, checks
from .errors import SingularError
from .interrupt import interruptible, new_tally
from .model import Oscillator, Pattern
from .motion import Motion
from .newton import impact_motion, release_motion
from .solve import impact_restitution

__all__ = ["FoundMotions", "Search", "find"]

#: Motions, and impacts of all of them, that there is room for at first.
ROOM, IMPACTS = 1000, 10_000
#: Work (impacts squared times guesses, load cycles simulated) that is done in a moment.
LITTLE = 10_000
#: The share of the work that the patterns count.
PATTERNS = 0.9


class Point(NamedTuple):
    """Where to search."""

    osc: Oscillator
    r: float
    clearance: float
    load: float


@dataclass(frozen=True)
class Search:
    """How a search was done: what its answer can be trusted for, and what not.

    Each simulated state is counted once: as settled, or under the reason why it is not.

    Attributes
    ----------
    patterns : int
        Side patterns (each with its number of cycles) that were searched.
    guesses : int
        Newton iterations started, over all patterns.
    inadmissible : int
        Solutions of the equations that would pass through a wall; they are left out.
    states : int
        Initial states that were simulated.
    settled : int
        States that settled on a periodic motion which Newton's method confirms there as admissible and stable.
    releases : int
        Releases from rest from which Newton's method was started, for motions with rest.
    not_stable : int
        States that repeat themselves about a motion which Newton's method shows to be unstable or inadmissible,
        or of which that cannot be decided: they only pass by it (an admissible one is listed).
    unconfirmed : int
        States that repeat themselves where Newton's method leads to no motion.
    wandering : int
        States that do not repeat themselves within 16 load cycles (or 100 letters): chaotic, quasi-periodic, of
        longer period, or not settled yet.
    without_impacts : int
        States after which no impacts are left.
    unfinished : int
        States whose simulation could not go on.
    lost : int
        Motions found that Newton's method could not confirm once more as they are listed; they are left out.
    """

    patterns: int
    guesses: int
    inadmissible: int
    states: int
    settled: int
    releases: int
    not_stable: int = 0
    unconfirmed: int = 0
    wandering: int = 0
    without_impacts: int = 0
    unfinished: int = 0
    lost: int = 0

    def __str__(self) -> str:
        s = "" if self.patterns == 1 else "s"
        others = ", ".join(
            f"{count} {reason}"
            for count, reason in (
                (self.not_stable, "passed by a motion that is not stable"),
                (self.unconfirmed, "repeated themselves where Newton's method finds no motion"),
                (self.wandering, "did not repeat themselves within 16 load cycles"),
                (self.without_impacts, "came to have no impacts"),
                (self.unfinished, "could not be simulated to the end"),
            )
            if count
        )
        lost = f"; {self.lost} motions could not be confirmed and are left out" if self.lost else ""
        return (
            f"{self.patterns} pattern{s} with {self.guesses} guesses (phases spread evenly, the rest from the "
            f"linear problem; {self.inadmissible} inadmissible solutions left out), followed along the lines of "
            f"constant r and constant clearance, {self.releases} releases from rest, and {self.states} simulated "
            f"states, of which {self.settled} settled on a stable periodic motion"
            f"{f' ({others})' if others else ''}{lost}. A motion with a very small neighbourhood of convergence "
            "can have been missed, one with rest most easily."
        )


class FoundMotions(list[Motion]):
    """A list of motions that remembers in `search` how it was found."""

    search: Search

    def __init__(self, motions: Iterable[Motion], search: Search) -> None:
        super().__init__(motions)
        self.search = search


def find(
    osc: Oscillator,
    r: float,
    clearance: float,
    max_impacts: int = 6,
    max_cycles: int = 2,
    load: float = 1.0,
    guesses: int = 96,
    states: int = 24,
    settling: int = 600,
    releases: int = 32,
    progress: Callable[[float, str], None] | None = None,
) -> FoundMotions:
    """Periodic motions at a point: from all side patterns, from releases, and from simulated attractors.

    For each pattern of sides (up to rotation) with N <= max_impacts and k <= max_cycles, Newton's method
    starts from guesses whose phases fill the period evenly and whose positions solve the linear equations of
    1983; motions found repel the later iterations, so none is found twice. Each is followed along the lines of
    constant r and of constant clearance through the point, round their folds, which come back to the point on
    other sheets. Newton's method on the return map of releases adds motions with rest, stable or not. Simulations
    from a spread of initial states add the attractors; a state counts as settled only where Newton's method
    confirms a stable motion.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`.
    max_impacts, max_cycles : int
        Limits of the patterns searched, 2 to 12 impacts and 1 to 8 cycles. What simulations and releases lead to
        is listed whatever its number of impacts and cycles.
    guesses : int
        Guesses for each pattern. Few make a short search: the lines of a pattern get at most as many steps as the
        square of this number (and 3000).
    states : int
        Initial states simulated, every second one in a box so large as the resonance of both masses together asks
        for.
    settling : int
        Load cycles simulated before an attractor is looked for.
    releases : int
        Releases from rest, for each wall and number of cycles, from which Newton's method is started on the
        return map: it finds motions with rest that are unstable too.
    progress : callable, optional
        Called with the share done and what is being done; what it raises ends the search.

    Returns
    -------
    FoundMotions
        A list of admissible motions, stable ones first; its attribute `search` says how it was found.

    Examples
    --------
    Table 1's point: two unstable equispaced motions, the stable unequispaced one and its mirror image; and an
    attractor of twelve impacts that simulations settle on.

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> [(motion.pattern.sides, motion.stable) for motion in motions]
    [('RL', True), ('RL', True), ('RRLRLRLLRLRL', True), ('RL', False), ('RL', False)]
    """
    checks.instance(osc, "osc", Oscillator)
    r = checks.frequency_ratio(r, osc.xi)
    clearance = checks.number(clearance, "clearance")
    load = checks.number(load, "load")
    max_impacts = checks.integer(max_impacts, "max_impacts", 2, 12)
    max_cycles = checks.integer(max_cycles, "max_cycles", 1, 8)
    guesses = checks.integer(guesses, "guesses", 0, 10**6)
    states = checks.integer(states, "states", 0, 10**6)
    settling = checks.integer(settling, "settling", 0, 10**7)
    releases = checks.integer(releases, "releases", 0, 10**6)
    point = Point(osc, r, clearance, load)
    patterns = list(
        side_patterns(max_impacts, max_cycles, mirrored=osc.restitution[0] == osc.restitution[1])
    )
    effort = guesses * _work(patterns) + 20 * max_cycles * releases + states * settling
    watch = _Watch(patterns, progress)
    found: list[Motion] = []
    limits = (max_impacts, max_cycles, guesses, states, settling, releases, os.cpu_count() or 1)
    room, impacts = ROOM, IMPACTS
    while True:
        call = (
            _core.find, room, impacts, osc.xi, osc.mu, osc.restitution, r, load, clearance, *limits,
            watch.tally,
        )  # fmt: skip
        if effort < LITTLE:
            answer = call[0](*call[1:])
        else:
            answer = interruptible(
                *call, watch=watch if progress is not None else None, tally=watch.tally
            )
        n, m, counts, *tables = answer
        if n <= room and m <= impacts:
            break
        room, impacts = max(n, room), max(m, impacts)
        watch.tally[:] = 0
    watch()
    motions = list(_motions(point, n, tables))
    found = sorted((motion for motion in motions if motion is not None), key=_order)
    tried, started, inadmissible, released, settled, *others = counts.tolist()
    not_stable, unconfirmed, wandering, without_impacts, unfinished = others
    search = Search(
        tried, started, inadmissible, states, settled, released, not_stable, unconfirmed, wandering,
        without_impacts, unfinished, len(motions) - len(found),
    )  # fmt: skip
    return FoundMotions(found, search)


class _Watch:
    """Tells progress by the core's tally: each pattern once, in order, with the share done."""

    def __init__(
        self, patterns: list[Pattern], progress: Callable[[float, str], None] | None
    ) -> None:
        self.tally = new_tally()
        self.progress = progress
        shares = np.cumsum([len(pattern) ** 2 for pattern in patterns]) * (
            PATTERNS / _work(patterns)
        )
        self.ahead = [
            (share, f"{pattern.sides}/{pattern.cycles}")
            for share, pattern in zip(shares.tolist(), patterns, strict=True)
        ]

    def __call__(self) -> None:
        if self.progress is None:
            return
        share = float(self.tally[0] / max(1, self.tally[1]))
        # the core rounds the work of each pattern down
        slack = len(self.ahead) / max(1, self.tally[1])
        while self.ahead and self.ahead[0][0] <= share + slack:
            self.progress(*self.ahead.pop(0))
        if not self.ahead:
            self.progress(max(PATTERNS, share), "simulations")


def _motions(point: Point, n: int, tables: list[Any]) -> Iterator[Motion | None]:
    """The motions of the core's tables; None where Newton's method does not confirm one."""
    kinds, releases, sides, phases, impacts, scalars, multipliers, verdicts, status = tables
    osc, r, clearance, load = point
    last = 0
    for i in range(n):
        size, cycles, side = kinds[:, i].tolist()
        if size == 0:
            try:
                yield release_motion(osc, r, clearance, load, cycles, side, releases[:, i].copy())
            except SingularError:
                yield None
            continue
        own = slice(last, last + size)
        last += size
        if status[i]:
            yield None
            continue
        pattern = Pattern("".join("RL"[one < 0] for one in sides[own].tolist()), cycles)
        yield impact_motion(
            osc, r, clearance, load, pattern, impact_restitution(osc, pattern, None), phases[own].copy(),
            impacts[:, own].T.copy(), scalars[:, i], multipliers[:, i].copy(), verdicts[:, i],
        )  # fmt: skip


def _work(patterns: Iterable[Pattern]) -> int:
    """How long patterns take: each about as long as the square of its impacts."""
    return sum(len(pattern) ** 2 for pattern in patterns)


def _order(motion: Motion) -> tuple[Any, ...]:
    """Stable first, then few cycles, few impacts, pattern, and position."""
    return (
        not motion.stable, motion.pattern.cycles, len(motion.pattern), motion.pattern.sides,
        -round(float(motion.X[0]), 6),
    )  # fmt: skip


def side_patterns(max_impacts: int, max_cycles: int, *, mirrored: bool) -> Iterator[Pattern]:
    """All side patterns up to rotation (and up to mirror image), with each number of cycles.

    A pattern that repeats a shorter one is searched too where its cycles do: motions of twice the period look
    like that.
    """
    for n in range(2, max_impacts + 1):
        seen: set[str] = set()
        for letters in itertools.product("RL", repeat=n):
            sides = "".join(letters)
            if sides in seen or len(set(sides)) < 2:
                continue
            turned = {sides[j:] + sides[:j] for j in range(n)}
            if mirrored:
                turned |= {item.translate(str.maketrans("RL", "LR")) for item in turned}
            seen |= turned
            for cycles in range(1, max_cycles + 1):
                yield Pattern(max(turned), cycles)
