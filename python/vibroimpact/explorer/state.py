"""The complete state of the explorer, and its form in a share link."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any
from urllib.parse import parse_qsl, urlencode

from .. import Oscillator, Pattern, Units
from ..base import checks
from ..base.errors import ParameterError, VibroimpactError
from .definition import NEEDED, Definition
from .limits import shown

__all__ = ["Box", "Run", "State"]

NUMBERS = ("xi", "mu", "R1", "R2", "r", "clearance")
WINDOW = ("r_min", "r_max", "clearance_min", "clearance_max")
#: Largest number of zones drawn, and of the symbols and load cycles of their patterns.
MOST_PATTERNS, MOST_SYMBOLS, MOST_CYCLES = 12, 8, 4
#: Largest number of digits of a whole number.
MOST_DIGITS = 9


@dataclass(frozen=True)
class Run:
    """A simulation: its initial state, the load cycles shown, and the load cycles simulated before them.

    Numbers out of range are rejected; whether the state lies between the walls is checked by the simulation.
    """

    t: float = 0.0
    x: float = 0.0
    x_dot: float = 0.0
    z: float = 0.0
    z_dot: float = 0.0
    cycles: float = 12.0
    discard: float = 0.0

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not math.isfinite(value):
                raise ParameterError(f"{item.name} = {value!r}: must be a finite number")
        for name, most in (("cycles", 200), ("discard", 20_000)):
            value = getattr(self, name)
            if not 0 <= value <= most or (name == "cycles" and value == 0):
                sign = "<" if name == "cycles" else "<="
                raise ParameterError(
                    f"{name} = {value!r}: must be a number with 0 {sign} {name} <= {most}"
                )

    @classmethod
    def read(cls, words: dict[str, str]) -> Run:
        """A run from the text of each field; ParameterError names a field that is missing or not a number."""
        missing = [item.name for item in fields(cls) if item.name not in words]
        if missing:
            raise ParameterError(f"{missing[0]}: is missing; must be a finite number")
        return cls(**{item.name: _finite(words[item.name], item.name) for item in fields(cls)})

    @property
    def state(self) -> dict[str, float]:
        """The initial state as an argument of `simulate`."""
        return {name: getattr(self, name) for name in NEEDED}


@dataclass(frozen=True)
class Box:
    """The tolerance box: r and d K/F0 at its centre, and its half widths."""

    r: float
    clearance: float
    r_half: float
    clearance_half: float

    def __post_init__(self) -> None:
        for name in ("r", "clearance"):
            middle, half = getattr(self, name), getattr(self, f"{name}_half")
            checks.number(middle, name, f"{name} of the box")
            if not 0 <= half < middle:
                raise ParameterError(
                    f"{name}_half of the box = {half!r}: must be a number with 0 <= {name}_half < {name}, "
                    f"which is {middle!r}"
                )

    @classmethod
    def read(cls, words: dict[str, str]) -> Box:
        """A box from the text of each field; ParameterError names a field that is not a number."""
        return cls(
            **{
                item.name: _finite(words[item.name], f"{item.name} of the box")
                for item in fields(cls)
            }
        )

    @property
    def ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Of r and clearance."""
        return (
            (self.r - self.r_half, self.r + self.r_half),
            (self.clearance - self.clearance_half, self.clearance + self.clearance_half),
        )


@dataclass(frozen=True)
class State:
    """The complete state of the page; everything on the page is computed from it.

    Parameters
    ----------
    xi, mu, R1, R2, r, clearance : float
        The system and the chosen point.
    r_min, r_max, clearance_min, clearance_max : float
        The window of the zone chart.
    patterns : tuple of Pattern
        Patterns whose zones are drawn.
    motion : Definition or None
        The chosen motion, or the first one in the table.
    run : Run or None
    show : {"motion", "run"}
        What the history and the portrait show.
    line : (r, clearance, r, clearance) or None
        The ends of the line of the bifurcation diagram.
    units : Units or None
        Physical units, which are shown next to the dimensionless ones.
    map : {"off", "on"}
        Whether the map of max|X|/A is shown.
    box : Box or None
    limit : float
        The max|X|/A that the points of the box should not exceed.

    Examples
    --------
    >>> from vibroimpact.explorer.state import State
    >>> State(xi=0.02, r=0.97).query
    'xi=0.02&r=0.97'
    >>> state, faults = State.read("xi=0.02&mu=lots&r=0.97")
    >>> state.xi, state.mu, state.r
    (0.02, 0.028, 0.97)
    >>> faults
    ["mu = 'lots': must be a number with 0 <= mu <= 1e+06"]
    """

    xi: float = 0.0114
    mu: float = 0.028
    R1: float = 0.75
    R2: float = 0.75
    r: float = 1.04
    clearance: float = 25.0
    r_min: float = 0.8
    r_max: float = 1.2
    clearance_min: float = 2.0
    clearance_max: float = 200.0
    patterns: tuple[Pattern, ...] = tuple(
        Pattern(sides) for sides in ("RL", "RRL", "RLL", "RRLL", "RRRL", "RLLL")
    )
    motion: Definition | None = None
    run: Run | None = None
    show: str = "motion"
    line: tuple[float, float, float, float] | None = None
    units: Units | None = None
    map: str = "off"
    box: Box | None = None
    limit: float = 0.5

    def __post_init__(self) -> None:
        for name in NUMBERS:
            kind = "restitution" if name in ("R1", "R2") else name
            checks.number(getattr(self, name), kind, name)
        for name in ("r", "clearance"):
            low = checks.number(getattr(self, f"{name}_min"), name, f"{name}[0]")
            high = checks.number(getattr(self, f"{name}_max"), name, f"{name}[1]")
            if not low < high:
                raise ParameterError(
                    f"{name} = {(low, high)!r}: must be (lowest, highest) with lowest < highest, each "
                    f"{checks.allowed(name)}"
                )
        r = (self.r_min, self.r_max)
        checks.frequency_ratio(self.r, self.xi)
        if checks.at_resonance(self.xi, 1.0) and r[0] <= 1 <= r[1]:
            raise ParameterError(
                f"xi = 0: must be above 0 while the window, r = {r[0]:g} to {r[1]:g}, contains 1"
            )
        if not 1 <= len(self.patterns) <= MOST_PATTERNS:
            raise ParameterError(
                f"patterns: must be 1 to {MOST_PATTERNS}, there are {len(self.patterns)}"
            )
        for pattern in self.patterns:
            if len(pattern) > MOST_SYMBOLS or pattern.cycles > MOST_CYCLES:
                raise ParameterError(
                    f"patterns = {pattern.sides}/{pattern.cycles}: must have at most {MOST_SYMBOLS} symbols "
                    f"and {MOST_CYCLES} cycles"
                )
        checks.choice(self.show, "show", ("motion", "run"))
        checks.choice(self.map, "map", ("off", "on"))
        if not 0 < self.limit < math.inf:
            raise ParameterError(f"limit = {self.limit!r}: must be a finite number with limit > 0")
        if self.box is not None and checks.at_resonance(self.xi, 1.0):
            low, high = self.box.ends[0]
            if low <= 1 <= high:
                raise ParameterError(
                    f"box, r = {low:g} to {high:g}: must not contain 1 when xi = 0"
                )
        if self.line is not None:
            for value, name in zip(self.line, ("r", "clearance") * 2, strict=True):
                checks.number(value, name, f"{name} of the line")
            if self.line[:2] == self.line[2:]:
                raise ParameterError(f"line = {self.line!r}: must have two different ends")
            if checks.at_resonance(self.xi, 1.0) and min(self.line[::2]) <= 1 <= max(
                self.line[::2]
            ):
                raise ParameterError(f"line = {self.line!r}: must not pass r = 1 when xi = 0")

    @property
    def osc(self) -> Oscillator:
        """The system."""
        units = self.units
        known: dict[str, Any] = {} if units is None else {
            "M": units.M, "K": units.K, "F0": units.F0, "unit_names": units.names
        }  # fmt: skip
        return Oscillator(xi=self.xi, mu=self.mu, restitution=(self.R1, self.R2), **known)

    @property
    def window(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Of r and clearance."""
        return (self.r_min, self.r_max), (self.clearance_min, self.clearance_max)

    @property
    def query(self) -> str:
        """The fields that differ from the initial state, as the query of a link."""
        start = State()
        words = {
            item.name: _text(getattr(self, item.name))
            for item in fields(self)
            if getattr(self, item.name) != getattr(start, item.name)
        }
        return urlencode(words, safe="/,*")

    def changed(self, words: dict[str, str]) -> State:
        """The state with some fields read from text; ParameterError if the result is not valid."""
        return replace(self, **{name: _value(name, text) for name, text in words.items()})

    @classmethod
    def read(cls, query: str) -> tuple[State, list[str]]:
        """The state of a link, and its faults; the valid fields are used."""
        state, faults = cls(), []
        words = dict(parse_qsl(query, keep_blank_values=True))
        good = {}
        for name, text in words.items():
            try:
                good[name] = _value(name, text)
            except VibroimpactError as error:
                faults.append(str(error))
        try:
            return replace(state, **good), faults
        except VibroimpactError:
            pass  # some fields contradict each other: set them one by one, except for the two ends of a window
        groups = [WINDOW[:2], WINDOW[2:], *((name,) for name in good if name not in WINDOW)]
        for group in groups:
            some = {name: good[name] for name in group if name in good}
            try:
                state = replace(state, **some)
            except VibroimpactError as error:
                faults.append(str(error))
        return state, faults


def _text(value: Any) -> str:
    """A field in its form in a link."""
    if isinstance(value, Definition):
        return value.text
    if isinstance(value, (Run, Box)):
        return ",".join(number_text(getattr(value, item.name)) for item in fields(value))
    if isinstance(value, Units):
        return units_text(value).replace(" ", ",")
    if isinstance(value, tuple):
        return ",".join(map(_text, value))
    if isinstance(value, Pattern):
        return pattern_text(value)
    return value if isinstance(value, str) else number_text(value)


def number_text(value: float) -> str:
    """A number with all its digits; whole numbers without a decimal point."""
    return repr(float(value)).removesuffix(".0")


def pattern_text(pattern: Pattern) -> str:
    """The sides, and the load cycles if there are several."""
    return pattern.sides if pattern.cycles == 1 else f"{pattern.sides}/{pattern.cycles}"


def units_text(units: Units | None) -> str:
    """Mass, stiffness and load amplitude with the names of the units; empty for no units."""
    if units is None:
        return ""
    return " ".join([*map(number_text, (units.M, units.K, units.F0)), units.names])


def _value(name: str, text: str) -> Any:
    """A field from its text."""
    if name in (*NUMBERS, *WINDOW):
        return _number(text, name)
    if name == "patterns":
        return tuple(dict.fromkeys(_pattern(word) for word in text.replace(",", " ").split()))
    if name in ("show", "map"):
        return text
    if name == "limit":
        return _finite(text, name)
    if name == "units":
        return _units(text)
    if name == "motion":
        return Definition.read(text) if text else None
    if name in ("run", "line", "box"):
        if not text:
            return None
        kind: Any = {"run": Run, "box": Box}.get(name)
        names = [item.name for item in fields(kind)] if kind else 4 * [name]
        words = text.split(",")
        if len(words) != len(names):
            raise ParameterError(
                f"{name} = {shown(text)}: must be {len(names)} numbers separated by commas"
            )
        if kind:
            return kind.read(dict(zip(names, words, strict=True)))
        return tuple(_finite(word, name) for word in words)
    known = ", ".join(item.name for item in fields(State))
    raise ParameterError(
        f"{name} = {shown(text)}: is not part of the explorer's state; must be {known}"
    )


def _units(text: str) -> Units | None:
    """Units from M, K, F0 and the names of their units; None from an empty text."""
    words = text.replace(",", " ").split()
    if not words:
        return None
    if len(words) not in (3, 4, 6):
        raise ParameterError(
            f"units = {shown(text)}: must be M, K and F0 and their units of length, force and time, "
            "such as 2.7 42000 6 m N s"
        )
    M, K, F0 = (_finite(word, name) for word, name in zip(words, ("M", "K", "F0"), strict=False))
    return Units(M, K, F0, " ".join(words[3:]) or "SI")


def _pattern(word: str) -> Pattern:
    sides, slash, cycles = word.partition("/")
    if slash and not (cycles.isdecimal() and len(cycles) <= MOST_DIGITS):
        raise ParameterError(
            f"patterns = {shown(word)}: must be SIDES or SIDES/CYCLES, such as RL/2"
        )
    if len(sides) > 2 * MOST_SYMBOLS:
        raise ParameterError(f"patterns = {shown(word)}: must have at most {MOST_SYMBOLS} symbols")
    return Pattern(sides, int(cycles) if slash else 1)


def _number(text: str, name: str) -> float:
    kind = {"R1": "restitution", "R2": "restitution"}.get(name, name.removesuffix("_min"))
    kind = kind.removesuffix("_max")
    try:
        value = checks.read_number(text)
    except ValueError:
        wanted = checks.allowed(kind, name)
        raise ParameterError(f"{name} = {shown(text)}: must be {wanted}") from None
    return checks.number(value, kind, name)


def _finite(text: str, name: str) -> float:
    try:
        value = checks.read_number(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ParameterError(f"{name} = {shown(text)}: must be a finite number")
    return value


def joined(faults: Iterable[str]) -> str:
    """Several messages joined to one."""
    return "; ".join(faults)
