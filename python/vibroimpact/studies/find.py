"""Every periodic motion at a point that a systematic search finds, stable and unstable."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.jupyter import rows_html
from ..motions.motion import Motion, motions_of
from ..results import door
from ..results.noun import Noun, key
from ..results.states import state_by_coordinates
from ..systems.oscillator import Oscillator, of_numbers
from ..systems.verbs import every_system
from .structure_find import find_structure

__all__ = ["Findings", "FoundMotions", "Search", "find"]

#: Work (impacts squared times guesses, load cycles simulated) that takes only a moment.
LITTLE = 10_000
#: More patterns than the largest search has.
ROOM = 10_000
#: The share of the work that is assigned to the patterns.
PATTERNS = 0.9


@dataclass(frozen=True)
class Search:
    """The extent of a search, from which one can judge how complete its result is.

    Each simulated state is counted once: as settled, or under the reason why it did not settle.

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
        States that repeat near a motion which Newton's method shows to be unstable or inadmissible, or for which
        this cannot be decided: they only pass near it (the motion is listed if it is admissible).
    unconfirmed : int
        States that repeat where Newton's method finds no motion.
    wandering : int
        States that do not repeat within 16 load cycles (or 100 symbols), also when they are examined again after
        more cycles: chaotic, quasi-periodic, of longer period, or not settled yet.
    without_impacts : int
        States after which the free mass stands still where no wall reaches it.
    unfinished : int
        States whose simulation reached `max_events` or could not continue.
    lost : int
        Motions that were found but that a final run of Newton's method did not confirm; they are left out.
    text : str
        A sentence with all these numbers, which `str` returns.
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
    text: str = field(default="", repr=False, compare=False)

    def __str__(self) -> str:
        return self.text


class Findings(Noun, study="find"):
    """The motions that `find` found at a point, stable ones first, and how they were searched for.

    Attributes
    ----------
    osc : Oscillator
    r, clearance, load : float
    motions : list of Motion
    search : Search
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "motions.json"
    >>> motions.findings.save(path)
    >>> vi.load(path)
    <Findings at r = 0.94, d K/F0 = 37: 5 motions, 3 of them stable>
    """

    __slots__ = ("__dict__",)
    r: float = key("r")
    clearance: float = key("clearance")
    load: float = key("load")

    @classmethod
    def of(
        cls, osc: Oscillator, r: float, clearance: float, motions: FoundMotions, load: float = 1.0
    ) -> Findings:
        """What `find` gave for these arguments: `motions.findings`."""
        findings = motions.findings
        if findings is None or (findings.osc, findings.r, findings.clearance, findings.load) != (
            osc, r, clearance, load,
        ):  # fmt: skip
            raise ParameterError(f"motions = {motions!r}: must be what find gave at this point")
        return findings

    @cached_property
    def motions(self) -> list[Motion]:
        return motions_of(self._result, self.osc)

    @cached_property
    def search(self) -> Search:
        counts = {
            name: int(column.values)
            for name, column in self._result.tables["search"].columns.items()
        }
        (text,) = (line for line in self._result.remarks if line.startswith("searched: "))
        return Search(**counts, text=text.removeprefix("searched: "))

    def plot(self, ax: Any = None) -> Any:
        """Draw the history of each motion over a period, and the multipliers of all (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            With it the multipliers alone are drawn, into it.

        Returns
        -------
        Axes, or an array of Axes
        """
        return self._draw(ax)

    def __repr__(self) -> str:
        stable = sum(motion.stable is True for motion in self.motions)
        there = f"{len(self.motions)} motion{'' if len(self.motions) == 1 else 's'}"
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return (
            f"<Findings at r = {self.r:.6g}, d K/F0 = {self.clearance:.6g}: {there}, {stable} of them stable"
            f"{cut}>"
        )


class FoundMotions(list[Motion]):
    """A list of motions with the record of the search that found them.

    Attributes
    ----------
    search : Search
        The extent of the search.
    findings : Findings
        The complete result, which can be saved, drawn, or converted to tables.
    """

    search: Search
    findings: Findings | None

    def __init__(
        self, motions: Iterable[Motion], search: Search, findings: Findings | None = None
    ) -> None:
        super().__init__(motions)
        self.search = search
        self.findings = findings

    def __repr__(self) -> str:
        stable = sum(motion.stable is True for motion in self)
        there = f"{len(self)} motion{'' if len(self) == 1 else 's'}, {stable} of them stable"
        if not self or self.findings is None:
            return f"<FoundMotions: {there}>"
        return f"<FoundMotions at r = {self[0].r:.6g}, d K/F0 = {self[0].clearance:.6g}: {there}>"

    def _repr_html_(self) -> str:
        """The representation in Jupyter: a row for each motion."""
        words = {True: "yes", False: "no", None: "not known"}
        rows = (
            (
                str(i), f"{motion.pattern.sides}/{motion.pattern.cycles}", words[motion.stable],
                f"{abs(complex(motion.multipliers[0])):.4g}",
                f"{motion.attenuation:.6g}" if motion.A > 0 else "",
            )
            for i, motion in enumerate(self)
        )  # fmt: skip
        return rows_html(
            repr(self), ("", "pattern", "stable", "max|lambda|", "max|X|/A"), rows, str(self.search)
        )


@every_system(find_structure, of_law=state_by_coordinates)
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
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> FoundMotions:
    """Periodic motions at a point: from all side patterns, from releases, and from simulated attractors.

    For each pattern of sides (up to rotation) with N <= max_impacts and k <= max_cycles, Newton's method
    starts from guesses whose phases fill the period evenly and whose positions solve the linear equations of
    1983; motions found repel the later iterations, so none is found twice. Each is followed along the lines of
    constant r and of constant clearance through the point. Through folds these lines can return to the point on
    another branch. Newton's method on the return map of releases adds motions with rest, stable or not.
    Simulations from a spread of initial states add the attractors; a state counts as settled only where Newton's
    method confirms a stable motion.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`.
    max_impacts, max_cycles : int
        Limits of the patterns searched, 2 to 12 impacts and 1 to 8 cycles. Motions found by simulations and
        releases are listed whatever their number of impacts and cycles.
    guesses : int
        Guesses for each pattern. A smaller number also shortens the search along lines: each pattern gets at most
        the square of this number of steps (and 3000).
    states : int
        Initial states simulated, every second one in a box whose size follows from the resonance of both masses
        moving together.
    settling : int
        Load cycles simulated before the attractor is examined. A state that is then neither on a confirmed motion
        nor certainly chaotic is examined again up to three times, after 3, 9 and 27 times as many.
    releases : int
        Releases from rest, for each wall and number of cycles, from which Newton's method is started on the
        return map; this also finds unstable motions with rest.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is stopped, as one of `Search.unfinished`.
    progress : callable, optional
        Called with the share done and the present task; an exception that it raises ends the search.

    Returns
    -------
    FoundMotions
        A list of admissible motions, stable ones first; its attribute `search` gives the extent of the search, and
        `findings` the complete result, which can be saved.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    StudyInterrupted
        After Ctrl-C, if motions were found: its attribute `result` is the `Findings` so far.

    Examples
    --------
    Table 1's point: two unstable equispaced motions, the stable unequispaced one and its mirror image; and an
    attractor of twelve impacts on which simulations settle.

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> [(motion.pattern.sides, motion.stable) for motion in motions]
    [('RL', True), ('RL', True), ('RRLRLRLLRLRL', True), ('RL', False), ('RL', False)]
    """
    of_numbers(osc)
    r = checks.frequency_ratio(r, osc.xi)
    checks.progress(progress)
    keys = {
        "clearance": clearance, "max_impacts": max_impacts, "max_cycles": max_cycles, "load": load,
        "guesses": guesses, "states": states, "settling": settling, "releases": releases,
        "max_events": max_events,
    }  # fmt: skip
    if clearance is None:
        raise ParameterTypeError("clearance = None: must be a number")
    report = None if progress is None else _PatternProgress(osc, max_impacts, max_cycles, progress)
    findings = door.run(
        Findings, osc, keys, r, progress=report,
        little=progress is None and _is_little(max_impacts, max_cycles, guesses, states, settling, releases),
    )  # fmt: skip
    motions = motions_of(findings._result, osc)
    return FoundMotions(motions, findings.search, findings)


def _is_little(
    max_impacts: int, max_cycles: int, guesses: int, states: int, settling: int, releases: int
) -> bool:
    """Whether a search is short; the time for a pattern is proportional to the square of its number of impacts."""
    try:
        # there are about 2^n/n patterns of n impacts
        work = max_cycles * sum(n * 2**n for n in range(2, min(max_impacts, 12) + 1))
        return bool(guesses * work + 20 * max_cycles * releases + states * settling < LITTLE)
    except (TypeError, ValueError, OverflowError):  # which the door reports
        return False


class _PatternProgress:
    """Reports each pattern once, in order, with the share of the work done."""

    def __init__(
        self, osc: Oscillator, max_impacts: int, max_cycles: int, progress: Callable[[float, str], None]
    ) -> None:  # fmt: skip
        self.progress = progress
        self.ahead: list[tuple[float, str]] | None = None
        self.of = (max_impacts, max_cycles, osc.restitution[0] == osc.restitution[1])

    def __call__(self, share: float, note: str) -> None:
        if share <= 0:  # the core has not started, or has refused the case
            return
        if self.ahead is None:
            self.ahead = shares_of(*self.of)
        # the core rounds the work of each pattern down
        slack = len(self.ahead) * 1e-6
        while self.ahead and self.ahead[0][0] <= share + slack:
            self.progress(*self.ahead.pop(0))
        if not self.ahead:
            self.progress(max(PATTERNS, share), "simulations")


def shares_of(max_impacts: int, max_cycles: int, alike: bool) -> list[tuple[float, str]]:
    """The patterns that are searched, in order, with the share of the work that is done with each."""
    n, lengths, cycles, sides = _core.side_patterns(max_impacts, max_cycles, alike, ROOM)
    lengths, cycles = lengths[:n].astype(np.int64), cycles[:n]
    shares = np.cumsum(lengths**2) * (PATTERNS / np.sum(lengths**2))
    symbols = np.array(["", "R", "L"])[sides[:, :n].T]
    return [
        (share, f"{''.join(row)}/{k}")
        for share, row, k in zip(shares.tolist(), symbols.tolist(), cycles.tolist(), strict=True)
    ]
