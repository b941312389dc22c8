"""Periodic motions of linear structures with gaps: a search by simulation and by the order of impacts."""

from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import checks
from .errors import ParameterError, SingularError
from .structure import Load, Structure
from .structure_motion import StructureMotion, check_pair, exact_structure, settled
from .structure_trajectory import simulate_structure

__all__ = ["StructureMotions", "find_structure", "same_structure_motion"]

_Array = NDArray[np.float64]
_State = tuple[ArrayLike, ArrayLike]


@dataclass(frozen=True, eq=False, repr=False)
class StructureMotions(Sequence[StructureMotion]):
    """The admissible motions that a search has found, those on which simulations settle first.

    Attributes
    ----------
    motions : tuple of StructureMotion
    settled : tuple of int
        How many of the simulated states settle on each.
    unsettled : int
        Simulated states that do not settle on an admissible periodic motion with impacts within the limits of the
        search; those of the motion without impacts count here.
    failures : dict
        Messages of simulations and iterations that failed, and how often each occurred.
    """

    motions: tuple[StructureMotion, ...]
    settled: tuple[int, ...]
    unsettled: int
    failures: dict[str, int]

    def __len__(self) -> int:
        return len(self.motions)

    def __getitem__(self, index: Any) -> Any:
        return self.motions[index]

    def __repr__(self) -> str:
        lines = [
            f"  {motion!r}: {count} states"
            for motion, count in zip(self.motions, self.settled, strict=True)
        ]
        return "\n".join(
            [f"<StructureMotions: {len(self)} found, {self.unsettled} states unsettled>", *lines]
        )


def same_structure_motion(one: StructureMotion, other: StructureMotion) -> bool:
    """Whether two motions are the same, whatever impact each is counted from.

    They have the same period, the same gaps in order, phases within 1e-6 rad and speeds within 1e-6 of the
    largest one. Impacts of accumulations count down to 1e-3 of the largest speed.

    Parameters
    ----------
    one, other : StructureMotion

    Returns
    -------
    bool

    Raises
    ------
    ParameterTypeError
        If an argument is no `StructureMotion`.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> load = vi.Load(1.0, cosine=[1])
    >>> motion = vi.exact(wall, load, ([0.1], [0]))
    >>> vi.same_structure_motion(motion, vi.exact(wall, load, motion))
    True
    """
    checks.instance(one, "one", StructureMotion)
    checks.instance(other, "other", StructureMotion)
    if one.cycles != other.cycles or len(one.rests) != len(other.rests):
        return False
    first, second = _impacts(one), _impacts(other)
    if first.shape != second.shape:
        return False
    whole = 2 * np.pi * one.cycles
    largest = max(first[2].max(initial=0.0), second[2].max(initial=0.0))
    for turn in range(one.cycles):
        phases = second[1] + 2 * np.pi * turn
        for i in range(second.shape[1]):
            order = np.roll(np.arange(second.shape[1]), -i)
            if (second[0, order] != first[0]).any():
                continue
            apart = np.abs(np.mod(phases[order] - first[1] + 0.5 * whole, whole) - 0.5 * whole)
            if apart.max() < 1e-6 and np.abs(second[2, order] - first[2]).max() < 1e-6 * largest:
                return True
    return False


def _impacts(motion: StructureMotion) -> _Array:
    """(3, N) Gap, phase and approach speed of the impacts that are compared."""
    table = np.array([motion.gaps, motion.phases, motion.speeds])
    if len(motion.rests):
        table = table[:, motion.speeds > 1e-3 * motion.speeds.max(initial=0.0)]
    return table


def _orders(gaps: int, most: int) -> Iterator[tuple[int, ...]]:
    """Orders of impacts up to rotation, without those that repeat a shorter one."""
    for n in range(1, most + 1):
        for order in itertools.product(range(gaps), repeat=n):
            turned = [order[i:] + order[:i] for i in range(n)]
            if min(turned) == order and turned.count(order) == 1:
                yield order


def find_structure(
    structure: Structure,
    load: Load,
    max_impacts: int = 2,
    max_cycles: int = 4,
    guesses: int = 48,
    states: int = 24,
    settling: int = 300,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> StructureMotions:
    """Periodic motions of a structure: from simulations, and from all orders of a few impacts.

    Simulations from random states add the attractors, with accumulation and rest as well. For each order of
    up to `max_impacts` impacts on the gaps, in up to `max_cycles` load cycles, Newton's method starts from random
    impact times; it also finds unstable motions. Only admissible motions are kept. `vibroimpact.find` calls
    this for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load
    max_impacts, max_cycles : int
        Limits of the orders of impacts, 0 to 8 and 1 to 16. A motion on which a simulation settles may have any
        number of impacts; its period is at most `max_cycles`.
    guesses : int
        Sets of impact times for each order and number of cycles, 1 to 10000.
    states : int
        Simulated initial states, 0 to 100000; the first one is rest at q = 0 if that is possible.
    settling : int
        Load cycles simulated before a motion is looked for, 0 to 10^6.
    seed : int
        Of the random numbers; the result depends on nothing else.
    threads : int, optional
        By default as many as there are processors.
    progress : callable, optional
        Called with the share done and the present task; an exception that it raises ends the search.

    Returns
    -------
    StructureMotions

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If no state with open gaps is found.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motions = vi.find(wall, vi.Load(1.0, cosine=[1]), max_cycles=1, states=4)
    >>> len(motions), motions[0].stable, motions.settled
    (1, True, (4,))
    """
    check_pair(structure, load)
    max_impacts = checks.integer(max_impacts, "max_impacts", 0, 8)
    max_cycles = checks.integer(max_cycles, "max_cycles", 1, 16)
    guesses = checks.integer(guesses, "guesses", 1, 10_000)
    states = checks.integer(states, "states", 0, 100_000)
    settling = checks.integer(settling, "settling", 0, 10**6)
    seed = checks.integer(seed, "seed", 0, 2**31 - 1)
    if threads is not None:
        threads = checks.integer(threads, "threads", 1, 1000)
    orders = list(_orders(len(structure.gaps), max_impacts)) if structure.gaps else []
    tries = len(orders) * max_cycles * guesses
    if tries > 10**6:
        raise ParameterError(
            f"max_impacts = {max_impacts}: {len(orders)} orders of impacts on {len(structure.gaps)} gaps with "
            f"max_cycles = {max_cycles} and guesses = {guesses} make {tries} iterations; must be at most 1000000"
        )
    rng = np.random.default_rng(seed)
    begins = _initial_states(structure, load, states, rng)
    times = []
    for order in orders:
        for cycles in range(1, max_cycles + 1):
            for _ in range(guesses):
                times.append(
                    (order, cycles, np.sort(rng.uniform(0, 2 * np.pi * cycles, len(order))))
                )

    def from_state(state: _State) -> StructureMotion | str:
        try:
            return settled(structure, load, 0.0, state, settling, max_cycles)
        except SingularError as error:
            return str(error)

    def from_order(guess: tuple[tuple[int, ...], int, _Array]) -> StructureMotion | str:
        order, cycles, phases = guess
        try:
            return exact_structure(structure, load, (phases, order, cycles))
        except SingularError as error:
            return str(error)

    motions: list[StructureMotion] = []
    counts: list[int] = []
    failures: dict[str, int] = {}
    unsettled = done = 0
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        found = itertools.chain(pool.map(from_state, begins), pool.map(from_order, times))
        try:
            for i, motion in enumerate(found):
                simulated = i < len(begins)
                done += 1
                if progress is not None:
                    task = "simulated states" if simulated else "orders of impacts"
                    progress(done / (len(begins) + len(times)), task)
                if isinstance(motion, str):
                    unsettled += simulated
                    failures[motion] = failures.get(motion, 0) + 1
                    continue
                if not motion.consistent or motion.admissible is not True:
                    unsettled += simulated
                    continue
                shorter = _shortest(motion)
                for j, known in enumerate(motions):
                    if same_structure_motion(known, shorter):
                        counts[j] += simulated
                        break
                else:
                    motions.append(shorter)
                    counts.append(int(simulated))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    ranks = sorted(
        range(len(motions)), key=lambda j: (-counts[j], motions[j].stable is not True, j)
    )
    return StructureMotions(
        tuple(motions[j] for j in ranks), tuple(counts[j] for j in ranks), unsettled, failures
    )


def _shortest(motion: StructureMotion) -> StructureMotion:
    """The motion over its shortest period, if its impacts repeat within the period given."""
    n, k = len(motion.phases), motion.cycles
    if len(motion.rests):
        return motion
    for parts in range(n, 1, -1):
        if n % parts or k % parts:
            continue
        m = n // parts
        gaps = motion.gaps.reshape(parts, m)
        shift = 2 * np.pi * k / parts * np.arange(parts)[:, None]
        phases = motion.phases.reshape(parts, m) - shift
        if (gaps != gaps[0]).any() or np.abs(phases - phases[0]).max() > 1e-7:
            continue
        return exact_structure(
            motion.structure, motion.load, (motion.phases[:m], motion.gaps[:m], k // parts)
        )
    return motion


def _initial_states(
    structure: Structure, load: Load, count: int, rng: np.random.Generator
) -> list[_State]:
    """Rest, and random states of the size of a simulated motion from rest, with all gaps open."""
    n = structure.coordinates
    nothing = np.zeros(n)
    directions = np.array([gap.direction for gap in structure.gaps]).reshape(-1, n)
    openings = np.array([gap.opening for gap in structure.gaps])
    if not count:
        return []
    if (openings < 0).any():
        raise SingularError(
            "a gap is closed at q = 0: simulate from a state with open gaps, and use exact"
        )
    try:
        run = simulate_structure(structure, load, cycles=40)
        reached = np.abs(run.states).max(axis=0) if len(run.events) else np.zeros((2, n))
        reached = np.maximum(reached, np.abs(np.array(run.final_state)))
    except SingularError:
        reached = np.zeros((2, n))
    sizes = reached + 1e-3 * reached.max(axis=1, keepdims=True)
    span = openings.max(initial=0.0)
    sizes[0] += span
    sizes[1] += span * load.frequency
    begins: list[_State] = [(nothing, nothing)]
    while len(begins) < count:
        q, rate = 0.7 * sizes * rng.normal(size=(2, n))
        # towards q = 0, where the gaps are open, as far as needed
        closing = directions @ q
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.min(
                np.where(closing > openings, 0.95 * openings / closing, 1.0), initial=1.0
            )
        begins.append((share * q, rate))
    return begins
