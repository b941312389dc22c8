"""How to recompute a motion with the same bits: in a share link, in a namelist and in Python."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from .. import Motion, Oscillator, Pattern, equispaced, exact, is_symmetric, same_motion, simulate
from ..base import checks
from ..base.errors import ParameterError, SingularError
from .limits import Progress, shown

__all__ = ["Definition", "definition_of", "start_of"]

#: The names of the numbers of a state.
NEEDED = ("t", "x", "x_dot", "z", "z_dot")
#: The ways to compute a motion, and how many numbers each needs (None: one per impact).
KINDS = {"equispaced": 1, "phases": None, "state": len(NEEDED)}
#: Largest numbers of symbols and load cycles of a motion, and of events of the simulation that finds one.
MOST_SYMBOLS, MOST_CYCLES, MOST_EVENTS = 24, 16, 100_000


@dataclass(frozen=True)
class Definition:
    """One motion of a point (oscillator, r, clearance).

    Parameters
    ----------
    pattern : Pattern
    kind : {"equispaced", "phases", "state"}
        One of the equispaced motions, or the motion that Newton's method finds from impact phases or from the
        motion that starts at a state.
    numbers : tuple of float
        The number of the equispaced motion; the phases; or t, x, x', z, z'.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.explorer.definition import Definition
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> definition = Definition.read("RL/1/phases/0.0,4.3")
    >>> definition.solve(osc, 0.94, 37.0)
    <Motion RL/1 at r = 0.94, d K/F0 = 37: admissible, stable (max|lambda| = 0.9348)>
    """

    pattern: Pattern
    kind: str
    numbers: tuple[float, ...]

    def solve(
        self, osc: Oscillator, r: float, clearance: float, progress: Progress | None = None
    ) -> Motion:
        """The motion; SingularError if there is none. An exception of `progress` ends a simulation."""
        cycles = self.pattern.cycles
        if self.kind == "phases":
            return exact(osc, r, clearance, (list(self.numbers), self.pattern))
        if self.kind == "state":
            state = dict(zip(NEEDED, self.numbers, strict=True))
            run = simulate(
                osc, r, clearance, 3 * cycles, state, max_events=MOST_EVENTS, progress=progress
            )
            if not run.complete:
                raise SingularError(f"more than {MOST_EVENTS} events in {3 * cycles} load cycles")
            return exact(osc, r, clearance, run)
        pair = equispaced(osc, r, clearance, cycles)
        if not self.numbers[0] < len(pair):
            raise SingularError(f"there are {len(pair)} equispaced motions here")
        return pair[int(self.numbers[0])]

    @property
    def text(self) -> str:
        """The form in a share link."""
        numbers = ",".join(map(repr, self.numbers))
        return f"{self.pattern.sides}/{self.pattern.cycles}/{self.kind}/{numbers}"

    @classmethod
    def read(cls, text: str) -> Definition:
        """The inverse of `text`."""
        wanted = "SIDES/CYCLES/KIND/NUMBERS as a share link of the explorer has it"
        try:
            sides, cycles, kind, words = text.split("/")
            if not (cycles.isascii() and cycles.isdecimal()):
                raise ValueError
            pattern = Pattern(sides, int(cycles))
            numbers = tuple(checks.read_number(word) for word in words.split(","))
        except ValueError:
            raise ParameterError(f"motion = {shown(text)}: must be {wanted}") from None
        if len(pattern) > MOST_SYMBOLS or pattern.cycles > MOST_CYCLES:
            raise ParameterError(
                f"motion = {shown(text)}: must have at most {MOST_SYMBOLS} symbols and {MOST_CYCLES} load cycles"
            )
        if kind not in KINDS or len(numbers) != (KINDS[kind] or len(pattern)):
            raise ParameterError(f"motion = {shown(text)}: must be {wanted}")
        if not all(math.isfinite(number) for number in numbers):
            raise ParameterError(f"motion = {shown(text)}: must contain finite numbers")
        if kind == "equispaced" and (
            numbers[0] not in (0, 1) or pattern.sides != "RL" or pattern.cycles % 2 == 0
        ):
            raise ParameterError(
                f"motion = {shown(text)}: must be number 0 or 1 of RL in odd cycles"
            )
        if kind == "phases":
            if pattern.has_rest:
                raise ParameterError(f"motion = {shown(text)}: must be without rest")
            checks.phases(list(numbers), len(pattern), pattern.cycles)
        return cls(pattern, kind, tuple(map(int, numbers)) if kind == "equispaced" else numbers)


def definition_of(
    motion: Motion, progress: Progress | None = None
) -> tuple[Definition, Motion] | None:
    """A definition of a motion, and the motion that it produces; None if no definition reproduces the motion.

    The page shows the motion that the definition produces, so that anyone who uses the definition gets identical
    numbers.
    """
    for definition in _definitions(motion):
        try:
            made = definition.solve(motion.osc, motion.r, motion.clearance, progress)
        except (ArithmeticError, ValueError):
            continue
        if same_motion(made, motion):
            return definition, made
    return None


def start_of(motion: Motion) -> dict[str, float]:
    """The state just after the first impact of a motion, as an argument of `simulate`."""
    first = motion.events[0]
    half = 0.5 * motion.clearance * (1 if first["side"] == "R" else -1)
    x = float(first["x"])
    values = (first["phase"] / motion.r, x, first["x_dot_after"], x + half, first["z_dot_after"])
    return dict(zip(NEEDED, map(float, values), strict=True))


def _definitions(motion: Motion) -> Iterator[Definition]:
    """Definitions to try, the simplest first."""
    pattern = motion.pattern
    if len(pattern) == 2 and is_symmetric(motion):
        yield Definition(Pattern("RL", pattern.cycles), "equispaced", (0,))
        yield Definition(Pattern("RL", pattern.cycles), "equispaced", (1,))
    if not pattern.has_rest:
        yield Definition(pattern, "phases", tuple(motion.alpha.tolist()))
    yield Definition(pattern, "state", tuple(start_of(motion).values()))
