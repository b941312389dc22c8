"""Every periodic motion at a point that a systematic search finds, stable and unstable."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _core, checks
from .errors import SingularError
from .likeness import SAME, images, same, turned
from .model import Oscillator, Pattern
from .motion import Motion
from .newton import Period, lag, newton, release_motion, rest_motion, settle
from .states import TWO_PI

__all__ = ["FoundMotions", "Search", "find"]

#: Motions of one pattern that a search keeps, admissible or not.
ROOM = 128
#: Events that a period of a motion with rest may have while it is searched for.
FEW_EVENTS = 200
#: Work (impacts squared times guesses, load cycles simulated) that takes less time than starting threads.
LITTLE = 10_000
#: A release from rest: load cycles of the motion, side, and (phase, v).
Release = tuple[int, int, NDArray[np.float64]]


class Point(NamedTuple):
    """Where to search."""

    osc: Oscillator
    r: float
    clearance: float
    load: float


@dataclass(frozen=True)
class Search:
    """How a search was done: what its answer can be trusted for, and what not.

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
        States that settled on a periodic motion within the limits.
    releases : int
        Releases from rest from which Newton's method was started, for motions with rest.
    """

    patterns: int
    guesses: int
    inadmissible: int
    states: int
    settled: int
    releases: int

    def __str__(self) -> str:
        s = "" if self.patterns == 1 else "s"
        return (
            f"{self.patterns} pattern{s} with {self.guesses} guesses (phases spread evenly, the rest from the "
            f"linear problem; {self.inadmissible} inadmissible solutions left out), {self.releases} releases "
            f"from rest, and {self.states} simulated states, of which {self.settled} settled on a periodic "
            "motion. A motion with a very small neighbourhood of convergence can have been missed, one with "
            "rest most easily."
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
    1983; motions found repel the later iterations, so none is found twice. Newton's method on the return map of
    releases adds motions with rest, stable or not. Simulations from a spread of initial states add the attractors.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`.
    max_impacts, max_cycles : int
        Limits of the patterns searched, 2 to 12 impacts and 1 to 8 cycles. A motion with accumulation that
        simulation finds has no limit on its number of impacts.
    guesses : int
        Guesses for each pattern.
    states : int
        Initial states simulated.
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
    Table 1's point: two unstable equispaced motions, the stable unequispaced one and its mirror image among
    others.

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> [(motion.pattern.sides, motion.stable) for motion in motions]
    [('RL', True), ('RL', True), ('RL', False), ('RL', False)]
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
    tell = progress or (lambda share, what: None)
    patterns = list(
        side_patterns(max_impacts, max_cycles, mirrored=osc.restitution[0] == osc.restitution[1])
    )
    starts = list(_spread_releases(osc, r, clearance, load, max_cycles, releases))
    point = Point(osc, r, clearance, load)
    found: list[Motion] = []
    effort = guesses * _work(patterns) + 10 * len(starts) + states * settling
    with ThreadPoolExecutor() as pool:
        each: Any = map if effort < LITTLE else pool.map
        tried, inadmissible = _search_patterns(point, patterns, guesses, each, found, tell)

        def each_start(solve: Callable[[Release], Any], starts: list[Release]) -> Any:
            return _told(each(solve, starts), tell, (0.9, 0.95), len(starts), "motions with rest")

        for motion in _rest_motions(*point, starts, each_start):
            if len(motion.pattern) <= max_impacts:
                _add(found, motion)
        ends = each(
            lambda state: settle(*point, state, settling, max_cycles),
            _spread_states(*point, states),
        )
        ends = list(_told(ends, tell, (0.95, 1.0), states, "simulations"))
        settled = [end for end in ends if end is not None and len(end.pattern) <= max_impacts]
    for period in settled:
        with contextlib.suppress(SingularError):
            motion = _period_motion(point, period)
            if motion.admissible:
                _add(found, motion)
    found.sort(key=_order)
    return FoundMotions(
        found, Search(len(patterns), tried, inadmissible, states, len(settled), len(starts))
    )


def _told(
    items: Iterable[Any], tell: Callable[[float, str], None], shares: tuple[float, float], count: int,
    what: str,
) -> Iterable[Any]:  # fmt: skip
    """Items one by one, each told as its part of the way from one share of the work to another."""
    low, high = shares
    for i, item in enumerate(items):
        tell(low + (high - low) * i / count, what)
        yield item


def _work(patterns: Iterable[Pattern]) -> int:
    """How long patterns take: each about as long as the square of its impacts."""
    return sum(len(pattern) ** 2 for pattern in patterns)


def _search_patterns(
    point: Point, patterns: list[Pattern], guesses: int, each: Any, found: list[Motion],
    tell: Callable[[float, str], None],
) -> tuple[int, int]:  # fmt: skip
    """Add the motions of some patterns; gives the number of guesses and of inadmissible solutions."""
    osc, r, clearance, load = point

    def search(pattern: Pattern) -> tuple[Pattern, NDArray[np.float64], int, int]:
        return pattern, *_core.search_pattern(
            osc.xi, osc.mu, osc.restitution, r, load, clearance, pattern.cycles, pattern.signs, guesses,
            ROOM,
        )  # fmt: skip

    tried = inadmissible = done = 0
    for pattern, columns, n, started in each(search, patterns):
        tried += started
        done += _work([pattern])
        tell(0.9 * (done / _work(patterns)), f"{pattern.sides}/{pattern.cycles}")
        for column in columns[:, :n].T:
            x, theta = column[: len(pattern)], column[len(pattern) :]
            try:
                motion = newton(*point, pattern, x, theta)
            except SingularError:  # on the edge of convergence (mu = 0): no motion to vouch for
                continue
            if motion.admissible and motion.consistent:
                _add(found, motion)
            else:
                inadmissible += 1
    return tried, inadmissible


def _period_motion(point: Point, period: Period) -> Motion:
    """The exact motion that a simulation has settled on."""
    if period.pattern.has_rest:
        return rest_motion(*point, period.pattern.cycles, period.events)
    letters = period.letters
    phases = np.cumsum(np.diff(letters["time"], prepend=letters["time"][0])) * point.r
    theta = phases + letters["phase"][0] - lag(point.osc, point.r)
    return newton(*point, period.pattern, letters["x"], theta)


def _add(found: list[Motion], motion: Motion) -> None:
    """Add a motion, and its mirror image where the walls are alike, unless they are there."""
    for image in images(motion):
        if not any(same(image, other) for other in found):
            found.append(turned(image))


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


def _rest_motions(
    osc: Oscillator, r: float, clearance: float, load: float, starts: list[Release],
    each: Any,
) -> Iterator[Motion]:  # fmt: skip
    """The distinct motions with rest to which Newton's method on the return map leads."""

    def solve(start: Release) -> Release | None:
        cycles, side, guess = start
        point, *_, status = _core.rest_motion(
            osc.xi, osc.mu, osc.restitution, r, load, clearance, side, cycles, guess, FEW_EVENTS
        )
        return (cycles, side, point) if status == 0 else None

    seen: list[Release] = []
    for cycles, side, point in filter(None, each(solve, starts)):
        if any(
            (cycles, side) == (k, s)
            and abs(math.remainder(point[0] - at[0], TWO_PI)) < SAME
            and abs(point[1] - at[1]) < SAME * clearance
            for k, s, at in seen
        ):
            continue
        seen.append((cycles, side, point))
        yield release_motion(osc, r, clearance, load, cycles, side, point)


def _spread_releases(
    osc: Oscillator, r: float, clearance: float, load: float, max_cycles: int, count: int
) -> Iterator[Release]:
    """Releases spread evenly (an additive recurrence) over the phase and the possible velocities.

    At a release x'' = 0, and the contact force ends if the jerk f r cos(phase) - v has the sign of the wall.
    """
    golden = 1.324717957244746
    scale = _size(osc, r, clearance, load) * max(1.0, r)
    for cycles, side, i in itertools.product(range(1, max_cycles + 1), (1, -1), range(count)):
        phase = TWO_PI * ((0.5 + i / golden) % 1.0)
        part = (0.5 + i / golden**2) % 1.0
        v = load * r * math.cos(phase) - 2 * side * scale * part
        yield cycles, side, np.array([phase, v])


def _size(osc: Oscillator, r: float, clearance: float, load: float) -> float:
    """About the greatest position that a motion with impacts has."""
    amplitude = load / math.hypot((1 - r) * (1 + r), 2 * osc.xi * r)
    return 1.5 * max(min(amplitude, 3 * clearance), 0.1 * clearance)


def _spread_states(
    osc: Oscillator, r: float, clearance: float, load: float, count: int
) -> Iterator[dict[str, float]]:
    """Initial states spread evenly (an additive recurrence) over a box about the motion without impacts."""
    golden = 1.0
    for _ in range(40):
        golden = (1 + golden) ** (1 / 6)
    size = _size(osc, r, clearance, load)
    for i in range(count):
        u = [(0.5 + (i + 1) / golden ** (j + 1)) % 1.0 for j in range(5)]
        x = size * (2 * u[0] - 1)
        yield {
            "t": TWO_PI * u[4] / r,
            "x": x,
            "x_dot": size * max(1.0, r) * (2 * u[1] - 1),
            "z": x + 0.499 * clearance * (2 * u[2] - 1),
            "z_dot": 2 * size * max(1.0, r) * (2 * u[3] - 1),
        }
