"""Periodic motions of linear structures with gaps: a search by simulation and by the order of impacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..base.status import VERDICT, sentence
from ..motions.structure_motion import StructureMotion, _rests, check_numbers
from ..motions.structure_noun import StructureNoun, run_structure
from ..results.noun import Noun
from ..results.tables import Result, runs
from ..systems.structure import Load, Structure

__all__ = ["StructureMotions", "find_structure", "same_structure_motion"]

_Array = NDArray[np.float64]


class StructureMotions(StructureNoun, Sequence[StructureMotion], study="find_structure"):
    """The admissible motions that a search has found, those on which simulations settle first.

    Attributes
    ----------
    structure : Structure
    load : Load
    motions : tuple of StructureMotion
    settled : tuple of int
        How many of the simulated states settle on each.
    without_impacts : int
        Simulated states after which no impacts are left: all gaps stay open, or some rest for good.
    chaotic, quasi_periodic : int
        Simulated states whose largest Lyapunov exponent is positive by its error, and those where it is zero by
        its error and no stable motion is near.
    unsettled : int
        Simulated states on which none of this is decided within the limits of the search, or whose motion is not
        stable.
    failures : dict
        Messages of simulations and iterations that failed, and how often each occurred.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ("_motions",)
    _motions: tuple[StructureMotion, ...]

    @property
    def motions(self) -> tuple[StructureMotion, ...]:
        if not hasattr(self, "_motions"):
            object.__setattr__(self, "_motions", tuple(motions_of(self)))
        return self._motions

    @property
    def settled(self) -> tuple[int, ...]:
        return tuple(self._table("motions", "settled").tolist())

    @property
    def without_impacts(self) -> int:
        return int(self._table("search", "without_impacts"))

    @property
    def chaotic(self) -> int:
        return int(self._table("search", "chaotic"))

    @property
    def quasi_periodic(self) -> int:
        return int(self._table("search", "quasi_periodic"))

    @property
    def unsettled(self) -> int:
        return int(self._table("search", "unsettled"))

    @property
    def failures(self) -> dict[str, int]:
        codes, counts = (self._table("failures", name).tolist() for name in ("status", "count"))
        return {sentence(code): count for code, count in zip(codes, counts, strict=True)}

    def __len__(self) -> int:
        return self._table("motions", "settled").size

    def __getitem__(self, index: Any) -> Any:
        return self.motions[index]

    def require(self) -> None:
        """SingularError if the search could not begin."""
        if self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None) -> Any:
        """Draw the multipliers of all motions in the complex plane (extra `plot`); returns the Axes."""
        return self._draw(ax)

    def __repr__(self) -> str:
        lines = [
            f"  {motion!r}: {count} states"
            for motion, count in zip(self.motions, self.settled, strict=True)
        ]
        cut = "" if self.complete else f"; cut short, {self.cut}"
        counts = [(self.unsettled, "unsettled"), (self.without_impacts, "without impacts")]
        counts += [(self.chaotic, "chaotic"), (self.quasi_periodic, "quasi-periodic")]
        # all of which are 0 where every state settles
        others = ", ".join(f"{n} states {what}" for n, what in counts if n or what == "unsettled")
        return "\n".join(
            [
                f"<StructureMotions: {len(self)} found, {others}{cut}>",
                *lines,
            ]
        )


def motions_of(noun: Noun) -> list[StructureMotion]:
    """The motions of the tables of a result."""
    result, structure, load = noun._result, noun.structure, noun.load
    if load is None or not load.frequency:
        raise ParameterError("case: must have a &load with a frequency")
    count = noun._table("motions", "motion").size
    return [
        _motion_of(result, i, structure, load, *(
            runs(result.tables[name], count)[i] for name in ("impacts", "multipliers", "derivative", "rests")
        ))
        for i in range(count)
    ]  # fmt: skip


def _motion_of(
    result: Result, i: int, structure: Structure, load: Load, impacts: slice, multipliers: slice,
    derivative: slice, rests: slice,
) -> StructureMotion:  # fmt: skip
    """A motion of the tables of a result, from its rows."""

    def rows(table: str, part: slice, *names: str) -> list[Any]:
        return [result.column(table, name).decoded()[part] for name in names]

    own = {
        name: result.column("motions", name).decoded()[i].item()
        for name in ("cycles", "residual", "determinant", "law", "consistent", "admissible", "stable")
    }  # fmt: skip
    gaps, phases, speeds, impulses = rows("impacts", impacts, "gap", "phase", "speed", "impulse")
    states = np.stack(rows("impacts", impacts, "q", "q_dot"), axis=1)
    gap, begin, end = rows("rests", rests, "gap", "begin", "end")
    table = _rests(gap, (begin, end))
    matrix, values = (
        rows("derivative", derivative, "P")[0],
        rows("multipliers", multipliers, "multiplier")[0],
    )
    check_numbers(own["cycles"], phases, states, values, matrix)
    for array in (states, table):
        array.flags.writeable = False
    request: dict[str, Any] = {"kind": "exact", "gaps": gaps.tolist(), "phases": phases.tolist()}
    if len(table):
        request = {
            "kind": "settled", "settling": 0, "q": states[0, 0].tolist(), "q_dot": states[0, 1].tolist(),
            "start": float(phases[0] / load.frequency),
        }  # fmt: skip
    return StructureMotion(
        structure, load, gaps, own["cycles"], phases, speeds, impulses, states, own["residual"],
        matrix, values, own["determinant"], own["law"], VERDICT[own["consistent"]], VERDICT[own["admissible"]],
        VERDICT[own["stable"]], table, request | {"cycles": own["cycles"]},
    )  # fmt: skip


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
    impacts = ((m.gaps, m.phases, m.speeds) for m in (one, other))
    return bool(
        _core.same_impacts(*next(impacts), *next(impacts), one.cycles, int(len(one.rests) > 0))
    )


def find_structure(
    structure: Structure,
    load: Load,
    max_impacts: int = 2,
    max_cycles: int = 4,
    guesses: int = 48,
    states: int = 24,
    settling: int = 300,
    seed: int = 0,
    max_events: int = 10_000_000,
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
    max_events : int
        Events after which the simulation of a state is given up.
    threads : int, optional
        By default as many as there are processors. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task; an exception that it raises ends
        the search.

    Returns
    -------
    StructureMotions

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a gap is closed at q = 0 and states are to be simulated.
    StudyInterrupted
        After Ctrl-C, with what was found as its attribute `result`.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motions = vi.find(wall, vi.Load(1.0, cosine=[1]), max_cycles=1, states=4)
    >>> len(motions), motions[0].stable, motions.settled
    (1, True, (4,))
    """
    keys = {
        "max_impacts": max_impacts, "max_cycles": max_cycles, "guesses": guesses, "states": states,
        "settling": settling, "seed": seed, "max_events": max_events,
    }  # fmt: skip
    found = run_structure(StructureMotions, structure, load, keys, threads, progress)
    found.require()
    return found
