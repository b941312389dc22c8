"""A systematic search for the periodic motions of a system, stable and unstable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from .. import _core
from ..base import checks
from ..base.checks import Rng
from ..base.errors import ParameterTypeError, SingularError
from ..base.jupyter import rows_html
from ..base.status import sentence
from ..motions.motion import Motion, motions_of, of_tables
from ..motions.trajectory import steady_amplitude
from ..results import door
from ..results.noun import FORMER, Noun, key
from ..results.states import state_by_coordinates
from ..results.tables import runs
from ..systems.oscillator import Oscillator, Point, of_numbers
from ..systems.structure import Load, Structure, without_none
from ..systems.units import place_text
from ..systems.verbs import every_system, physical_arguments

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["FoundMotions", "Search", "find"]

#: The motion that has no phases and is not among the found ones.
WITHOUT_IMPACTS = "the motion without impacts, since D > 2A"
#: Amount of work (impacts squared times guesses, load cycles simulated) that takes only a moment.
LITTLE = 10_000
#: A number larger than that of the patterns in the largest search.
ROOM = 10_000
#: The share of the work that is assigned to the patterns.
PATTERNS = 0.9


@dataclass(frozen=True)
class Search:
    """The extent of a search at a point of an oscillator, as an indication of how complete the result is.

    Each simulated state is counted once: as settled, or under the reason why it did not settle.

    Attributes
    ----------
    patterns : int
        Side patterns (each with its number of cycles) that were searched.
    guesses : int
        Newton iterations started, over all patterns.
    inadmissible : int
        Solutions of the equations that would pass through a wall; they are discarded.
    states : int
        Initial states that were simulated.
    settled : int
        States that settled on a periodic motion that Newton's method confirms as admissible and stable.
    releases : int
        Releases from rest at which Newton's method was started, for motions with rest.
    not_stable : int
        States that repeat near a motion that Newton's method shows to be unstable or inadmissible, or for which
        this cannot be decided: they only pass near this motion (it is listed if it is admissible).
    unconfirmed : int
        States that repeat, but Newton's method finds no motion there.
    wandering : int
        States that do not repeat within 16 load cycles (or 100 symbols), even when they are examined again after
        more cycles: chaotic, quasi-periodic, of longer period, or not settled yet.
    without_impacts : int
        States from which the free mass comes to rest at a place that no wall reaches.
    unfinished : int
        States whose simulation reached `max_events` or could not continue.
    lost : int
        Motions that were found but not confirmed by a final run of Newton's method; they are discarded.
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


class FoundMotions(Noun, Sequence[Any], study="find", formerly="StructureMotions"):
    """The admissible motions found by `find`, in order, and the extent of the search.

    For an oscillator stable motions come first; for a structure, the motions on which simulations settle. Indexing
    returns a motion.

    Attributes
    ----------
    osc, r, clearance : Oscillator, float, float
        For an oscillator.
    structure : Structure
        For a structure.
    load : float, or Load
        Amplitude of the load of an oscillator, or the load of a structure.
    motions : tuple of Motion
    without_impacts : int
        Number of simulated states that end without further impacts; for a structure, this includes states that
        stay in contact. Without a periodic load: number of states that end in an equilibrium, at rest or in steady
        sliding.
    search : Search
        For an oscillator: the extent of the search.
    settled : tuple of int
        For a structure: number of simulated states that settle on each motion.
    chaotic, quasi_periodic : int
        For a structure: number of simulated states whose largest Lyapunov exponent is positive by more than its
        error, and number of those for which it is zero within its error and no stable motion is near.
    unsettled : int
        For a structure: number of simulated states for which none of this is decided within the limits of the
        search, or whose motion is not stable.
    failures : dict
        For a structure: messages of simulations and iterations that failed, and how often each occurred.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "motions.json"
    >>> motions.save(path)
    >>> vi.load(path)
    <FoundMotions at r = 0.94, d K/F0 = 37: 5 motions, 3 of them stable; and the motion without impacts, ...>
    """

    __slots__ = ("__dict__",)
    r: float = key("r", meaning="For an oscillator: the frequency ratio Omega/omega.")
    clearance: float = key("clearance", meaning="For an oscillator: the clearance d K/F0.")

    @cached_property
    def motions(self) -> tuple[Any, ...]:
        """The motions, in order."""
        if self.of_structure:
            return tuple(structure_motions_of(self))
        return tuple(motions_of(self._result, self.osc))

    @cached_property
    def search(self) -> Search:
        """For an oscillator: the extent of the search."""
        if self.of_structure:
            raise AttributeError(self._lack("search", "settled, unsettled and failures"))
        counts = {
            name: int(column.values)
            for name, column in self._result.tables["search"].columns.items()
        }
        (text,) = (line for line in self._result.remarks if line.startswith("searched: "))
        return Search(**counts, text=text.removeprefix("searched: "))

    @property
    def settled(self) -> tuple[int, ...]:
        """For a structure: number of simulated states that settle on each motion."""
        return tuple(self._values("motions", "settled").tolist())

    @property
    def without_impacts(self) -> int:
        """Number of simulated states that end without further impacts."""
        return int(self._values("search", "without_impacts"))

    @property
    def chaotic(self) -> int:
        """For a structure: number of states with a positive largest Lyapunov exponent."""
        return int(self._values("search", "chaotic"))

    @property
    def quasi_periodic(self) -> int:
        """For a structure: number of states whose largest exponent is zero, with no stable motion near."""
        return int(self._values("search", "quasi_periodic"))

    @property
    def unsettled(self) -> int:
        """For a structure: number of states that are undecided, or whose motion is not stable."""
        return int(self._values("search", "unsettled"))

    @property
    def failures(self) -> dict[str, int]:
        """For a structure: messages of simulations and iterations that failed, with their number."""
        codes = self._values("failures", "status", "failures").tolist()
        counts = self._values("failures", "count").tolist()
        return {sentence(code): count for code, count in zip(codes, counts, strict=True)}

    def _columns(self) -> str:
        if self.of_structure:
            return "motions, without_impacts, settled, chaotic, quasi_periodic, unsettled, failures"
        return "motions, without_impacts, search"

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, index: Any) -> Any:
        return self.motions[index]

    def require(self) -> None:
        """Raise a SingularError if the search of a structure could not begin."""
        if self.of_structure and self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None, units: Units | str | None = None) -> Any:
        """Draw the multipliers of all motions, and for an oscillator the history of each motion over a period.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            If given, only the multipliers are drawn, on these axes.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes, or an array of Axes
            `ax` if it is given; otherwise all Axes of a new figure.
        """
        return self._draw(ax, units=units)

    @property
    def _is_free(self) -> bool:
        """Whether an oscillator also has a motion without impacts; it has no phases and is not among the items."""
        return 2 * steady_amplitude(self.osc, self.r, self.load) < self.clearance

    def __repr__(self) -> str:
        stable = sum(motion.stable is True for motion in self)
        there = f"{len(self)} motion{'' if len(self) == 1 else 's'}, {stable} of them stable"
        cut = "" if self.complete else f"; cut short, {self.cut}"
        if not self.of_structure:
            point = place_text(self.osc, self.r, self.clearance)
            others = f"; and {WITHOUT_IMPACTS}" if self._is_free else ""
            return f"<FoundMotions at {point}: {there}{others}{cut}>"
        free = self.load is None or not self.load.frequency
        ends = "in an equilibrium" if free else "without further impacts"
        counts = [(self.unsettled, "unsettled"), (self.without_impacts, ends)]
        counts += [(self.chaotic, "chaotic"), (self.quasi_periodic, "quasi-periodic")]
        # all counts are 0 if every state settles
        others = ", ".join(f"{n} states {what}" for n, what in counts if n or what == "unsettled")
        lines = (
            f"\n  {motion!r}: {count} states"
            for motion, count in zip(self, self.settled, strict=True)
        )
        return "".join([f"<FoundMotions: {there}, {others}{cut}>", *lines])

    def _repr_html_(self) -> str:
        """The representation in Jupyter: a row for each motion."""
        if self.of_structure:
            return super()._repr_html_()
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


#: The class and the study of searches in files that earlier versions wrote.
FORMER["Findings"] = FoundMotions


def structure_motions_of(noun: Noun) -> list[Motion]:
    """The motions of a structure in the tables of a result."""
    result, structure, load = noun._result, noun.structure, noun.load
    free = load is None or not load.frequency
    if load is None:
        load = Load(constant=np.zeros(structure.coordinates))
    count = len(result.column("motions", "motion").values)
    frequencies = result.column("motions", "frequency").decoded().tolist() if free else []
    rows = [
        runs(result.tables[name], count)
        for name in ("impacts", "multipliers", "derivative", "rests")
    ]
    found: list[Motion] = []
    for i in range(count):
        if free:
            load = Load(frequencies[i], constant=load.constant)
        motion = of_tables(result, structure, load, "motions", i, [part[i] for part in rows], None)
        if free:
            _, (q, rate) = motion._run()._between_events()
            known = {"q": q.tolist(), "q_dot": rate.tolist(), "period": motion.period}
            found.append(motion.__replace__(request={"kind": "settled", "settling": 0} | known))
            continue
        request: dict[str, Any] = {
            "kind": "exact", "gaps": motion.gaps.tolist(), "phases": motion.phases.tolist()
        }  # fmt: skip
        if len(motion.rests) or not structure._is_rigid:
            start, (q, rate) = float(motion.phases[0] / load.frequency), (motion.q, motion.q_dot)
            if not structure._is_rigid:
                start, (q, rate) = motion._run()._between_events()
            request = {
                "kind": "settled", "settling": 0, "q": q.tolist(), "q_dot": rate.tolist(), "start": start,
            }  # fmt: skip
        found.append(motion.__replace__(request=request | {"cycles": motion.cycles}))
    return found


def find_structure(
    structure: Structure,
    load: Load | None,
    max_impacts: int = 2,
    max_cycles: int = 4,
    guesses: int = 48,
    states: int = 24,
    settling: int = 300,
    rng: Rng = 0,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> FoundMotions:
    """As `find`, for a structure."""
    keys = {
        "max_impacts": max_impacts, "max_cycles": max_cycles, "guesses": guesses, "states": states,
        "settling": settling, "seed": checks.seed_of(rng), "max_events": max_events,
    }  # fmt: skip
    load = without_none(load)
    found = door.run_structure(
        FoundMotions, structure, load, keys, threads, progress,
        needs_frequency=False, stops=True,
    )  # fmt: skip
    found.require()
    return found


@overload
def find(
    osc: Oscillator, r: Value, clearance: Value, max_impacts: int = 6, max_cycles: int = 2,
    load: Value | Load = 1.0, guesses: int = 96, states: int = 24, settling: int = 600, releases: int = 32,
    max_events: int = 10_000_000, progress: Callable[[float, str], None] | None = None,
) -> FoundMotions: ...  # fmt: skip
@overload
def find(
    structure: Structure, load: Load | None, max_impacts: int = 2, max_cycles: int = 4, guesses: int = 48,
    states: int = 24, settling: int = 300, rng: Rng = 0, max_events: int = 10_000_000,
    threads: int | None = None, progress: Callable[[float, str], None] | None = None,
) -> FoundMotions: ...  # fmt: skip
@overload
def find(
    point: Point, /, max_impacts: int = 6, max_cycles: int = 2, **options: Any
) -> FoundMotions: ...


@physical_arguments
@every_system(find_structure, of_law=state_by_coordinates)
def find(
    osc: Oscillator,
    r: float,
    clearance: float,
    max_impacts: int = 6,
    max_cycles: int = 2,
    load: float | Load = 1.0,
    guesses: int = 96,
    states: int = 24,
    settling: int = 600,
    releases: int = 32,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> FoundMotions:
    """Search for the periodic motions of a system: from orders of impacts, from releases, and by simulation.

    The system is `osc, r, clearance`, or `structure, load`, or a point from `Oscillator.at`. Only admissible
    motions are kept. Simulations from many different initial states add the attractors.

    For an oscillator: for each pattern of sides (up to rotation) with N <= max_impacts and k <= max_cycles,
    Newton's method starts from guesses whose phases fill the period evenly and whose positions solve the linear
    equations of the paper; later iterations are repelled by motions already found, so none is found twice. Each
    motion is followed along the lines of constant r and of constant clearance through the point. Through folds
    these lines can return to the point on another branch. Newton's method on the return map of releases adds
    motions with rest, stable or not. A simulated state counts as settled only if Newton's method confirms a stable
    motion.

    For a structure: for each order of up to max_impacts impacts on the gaps, in up to max_cycles load cycles,
    Newton's method starts from random impact times; it also finds unstable motions. Each motion without rest is
    followed along the lines of constant amplitude and of constant frequency of the load through the point, and
    mirror images are added where the structure has them. Motions with accumulation and rest, and all motions of a
    structure with stops or friction, come from the simulations.

    Without a load, or with a constant load, self-excited motions on which simulations from random states settle
    are found, such as that of a mass on a belt; states that end in an equilibrium are counted. Each motion is
    confirmed as in `exact`, with its period, and listed once, whatever its first event. A motion whose events do
    not repeat is not found: `failures` says so, and its states are `unsettled`.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r, clearance : float
        As in `simulate`.
    structure, load : Structure, Load
        In place of `osc`, `r` and `clearance`; `Load.none()`, None or a constant load for self-excited motions.
    max_impacts, max_cycles : int
        Limits of the patterns searched, 2 to 12 impacts and 1 to 8 cycles; for the orders of impacts of a
        structure, 0 to 8 impacts (2 by default; with 0 only simulations are made) and 1 to 16 cycles (4 by
        default). Motions found by simulations and releases are listed with any number of impacts and cycles; for a
        structure their period is at most `max_cycles`. Neither limit applies without a periodic load.
    load : float
        Amplitude of the load of an oscillator.
    guesses : int
        Number of guesses for each pattern. A smaller number also shortens the search along lines: the steps for
        each pattern, or for each motion of a structure, are limited to the square of this number (and to 3000).
        For a structure: number of sets of impact times for each order and number of cycles, 1 to 10000, 48 by
        default.
    states : int
        Number of simulated initial states; for an oscillator every second one lies in a box whose size follows
        from the resonance of both masses moving together; for a structure 0 to 100000, the first one at rest at q
        = 0 if that is possible.
    settling : int
        Load cycles simulated before the attractor is examined; for a structure 0 to 10^6, by default 300, and
        without a periodic load natural periods of the lowest mode (with all gaps open and all friction slipping):
        as long as neither a stable motion nor an equilibrium is confirmed, up to four further simulations follow,
        each twice as long as the previous one. A state of an oscillator that is then neither on a confirmed motion
        nor certainly chaotic is examined again up to three times, after 3, 9 and 27 times as many load cycles.
    releases : int
        For an oscillator: number of releases from rest, for each wall and number of cycles, at which Newton's
        method is started on the return map; this also finds unstable motions with rest.
    rng : int, numpy.random.Generator or None
        For a structure: seed of the random initial states, or a generator from which a seed is drawn; None:
        another seed in each call. The seed that was used is in the case of the result.
    max_events : int
        Events (impacts, rests, releases; for a structure also events of stops and friction) after which the
        simulation of a state is abandoned; for an oscillator it then counts as one of `Search.unfinished`.
    threads : int, optional
        For a structure: one for each processor by default. The result does not depend on it.
    progress : callable, optional
        Called with the fraction done and the current task; an exception that it raises ends the search.

    Returns
    -------
    FoundMotions
        A sequence of the motions, with the extent of the search.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a gap of a structure is closed at q = 0 and states are to be simulated, or if there is no periodic load
        and the structure has no natural period.
    StudyInterrupted
        After Ctrl-C, if motions were found: its attribute `result` contains them.

    Examples
    --------
    At the point of Table 1 there are two unstable equispaced motions, the stable unequispaced motion and its
    mirror image, and an attractor of twelve impacts on which simulations settle:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> [(motion.pattern.sides, motion.stable) for motion in motions]
    [('RL', True), ('RL', True), ('RRLRLRLLRLRL', True), ('RL', False), ('RL', False)]

    A mass that hits one wall:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motions = vi.find(wall, vi.Load(1.0, cosine=[1]), max_cycles=1, states=4)
    >>> len(motions), motions[0].stable, motions.settled
    (1, True, (4,))

    A mass on a belt sticks and slips without a load:

    >>> bow = vi.Structure([1], [0], [1], friction=[vi.Friction([1], 0.6, stick=1.0, speed=0.2)])
    >>> motions = vi.find(bow, vi.Load.none(), states=4)
    >>> round(motions[0].period, 9), motions.settled, motions.unsettled
    (8.068887872, (4,), 0)
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
    return door.run(
        FoundMotions, osc, keys, r, progress=report,
        little=progress is None and _is_little(max_impacts, max_cycles, guesses, states, settling, releases),
    )  # fmt: skip


def _is_little(
    max_impacts: int, max_cycles: int, guesses: int, states: int, settling: int, releases: int
) -> bool:
    """Whether a search is short; the time for a pattern is proportional to the square of its number of impacts."""
    try:
        # there are about 2^n/n patterns of n impacts
        work = max_cycles * sum(n * 2**n for n in range(2, min(max_impacts, 12) + 1))
        return bool(guesses * work + 20 * max_cycles * releases + states * settling < LITTLE)
    except (TypeError, ValueError, OverflowError):  # an invalid value, which `door.run` reports
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
        if share <= 0:  # the core has not started, or has rejected the case
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
    """The patterns that are searched, in order, with the share of the work that is done after each."""
    n, lengths, cycles, sides = _core.side_patterns(max_impacts, max_cycles, alike, ROOM)
    lengths, cycles = lengths[:n].astype(np.int64), cycles[:n]
    shares = np.cumsum(lengths**2) * (PATTERNS / np.sum(lengths**2))
    symbols = np.array(["", "R", "L"])[sides[:, :n].T]
    return [
        (share, f"{''.join(row)}/{k}")
        for share, row, k in zip(shares.tolist(), symbols.tolist(), cycles.tolist(), strict=True)
    ]
