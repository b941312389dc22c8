"""Physical units: conversion of dimensionless numbers to any units of length, force and time, and back."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Protocol, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.jupyter import facts_html

__all__ = ["Units"]

#: The units of length, force and time, each with its size in SI.
KNOWN: tuple[dict[str, float], ...] = (
    {
        "m": 1.0,
        "mm": 1e-3,
        "cm": 1e-2,
        "um": 1e-6,
        "km": 1e3,
        "in": 0.0254,
        "ft": 0.3048,
        "mil": 2.54e-5,
    },
    {
        "N": 1.0,
        "mN": 1e-3,
        "uN": 1e-6,
        "kN": 1e3,
        "MN": 1e6,
        "lbf": 4.4482216152605,
        "kgf": 9.80665,
    },
    {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
)
#: Metre, newton and second.
SI = "m N s"
#: The unit of mass of some units of length, force and time.
OF_MASS = {"m N s": "kg", "mm N s": "t", "m kN s": "t", "mm N ms": "g", "mm kN ms": "kg"}
#: The unit of columns whose numbers have several units, or a unit that depends on the case.
MIXED = "mixed"
#: The beginning of the description of a frequency ratio.
RATIO = "frequency ratio"
#: The descriptions of a dimensionless and of a physical clearance.
GAP = "clearance d K/F0; d is the whole travel of m between the walls"
PHYSICAL_GAP = "clearance d, the whole travel of m between the walls"
#: Powers of length, force and time in F0, K and omega, of which dimensionless units consist.
DIMENSIONS = {"F0": (0, 1, 0), "K": (-1, 1, 0), "omega": (0, 0, -1)}
#: Powers of length, force and time.
Powers: TypeAlias = tuple[int, int, int]


class Quantity(Protocol):
    """A quantity of pint."""

    @property
    def magnitude(self) -> Any: ...
    @property
    def units(self) -> Any: ...


#: An argument that may have a unit: a number, a text such as "4 mm", or a quantity of pint.
Value: TypeAlias = float | str | Quantity


#: Powers for the quantities of a rig.
POWERS: dict[str, Powers] = {
    "M": (-1, 1, 2), "m": (-1, 1, 2), "K": (-1, 1, 0), "C": (-1, 1, 1), "xi": (0, 0, 0), "F0": (0, 1, 0),
}  # fmt: skip
#: Further quantities, and those among them that are frequencies in cycles.
OTHERS: dict[str, Powers] = {
    "mu": (0, 0, 0), "d": (1, 0, 0), "displacement": (1, 0, 0), "velocity": (1, 0, -1),
    "acceleration": (1, 0, -2), "contact": (0, 0, 1), "duration": (0, 0, 1), "delay": (0, 0, 1),
    "start": (0, 0, 1), "load": (0, 1, 0), "step": (0, 0, 1),
}  # fmt: skip
CYCLES = ("f", "frequency", "ring_frequency", "rate", "bandwidth")
#: Units by name: their size in SI, their powers of length, force and time, and whether they count an angle.
NAMED: dict[str, tuple[float, Powers, bool]] = {
    **{name: (size, (1, 0, 0), False) for name, size in KNOWN[0].items()},
    **{name: (size, (0, 1, 0), False) for name, size in KNOWN[1].items()},
    **{name: (size, (0, 0, 1), False) for name, size in KNOWN[2].items()},
    "kg": (1.0, (-1, 1, 2), False), "g": (1e-3, (-1, 1, 2), False), "mg": (1e-6, (-1, 1, 2), False),
    "t": (1000.0, (-1, 1, 2), False), "lb": (0.45359237, (-1, 1, 2), False),
    "slug": (4.4482216152605 / 0.3048, (-1, 1, 2), False), "rad": (1.0, (0, 0, 0), True),
    "deg": (math.pi / 180, (0, 0, 0), True), "rev": (2 * math.pi, (0, 0, 0), True),
    "Hz": (2 * math.pi, (0, 0, -1), True), "kHz": (2e3 * math.pi, (0, 0, -1), True),
    "mHz": (2e-3 * math.pi, (0, 0, -1), True), "rpm": (2 * math.pi / 60, (0, 0, -1), True),
    "%": (0.01, (0, 0, 0), False),
}  # fmt: skip
#: Patterns of a number followed by text, of a number in a message, and of one unit with its power.
QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?:1/)?[^\d\s.].*?)\s*")
NUMBER = re.compile(r"-?\b\d+(?:\.\d+)?(?:e[-+]?\d+)?\b")
#: The value of the parameter in a message about the start of a study.
STARTING = re.compile(
    r"(the (?:motion|structure) has (\w+) = )(-?[\d.]+(?:e[-+]?\d+)?)(?: \(.*\))?$"
)
FACTOR = re.compile(r"([A-Za-z%]+)(?:\^?(-?\d))?")
#: The dimensionless units of arguments of functions, by name; a state has a mapping of its own.
ARGUMENTS = {
    "r": "omega", "clearance": "F0/K", "load": "F0", "friction": "F0", "wall_stiffness": "K",
    "wall_damping": "K/omega",
}  # fmt: skip
#: The unit of a mass ratio, which may also be given as the free mass; a bare number is m/M.
MASS = "K/omega^2"
#: Dimensionless parameters, which may be given in %, and the mass ratio.
PARAMETERS = ARGUMENTS | {"xi": "", "mu": MASS, "restitution": "", "R1": "", "R2": ""}
STATE = {
    "t": "1/omega", "x": "F0/K", "y": "F0/K", "z": "F0/K", "x_dot": "omega F0/K", "z_dot": "omega F0/K"
}  # fmt: skip
#: The units of parameters of a dimensionless structure by the first words of their names; the frequency is a
#: frequency ratio.
OF_STRUCTURE = {
    "frequency": "omega", "clearance": "F0/K", "opening": "F0/K", "slip": "F0", "stick": "F0",
    "speed": "omega F0/K", "contact": "K",
}  # fmt: skip
#: The units of the initial state of a free vibration.
START = {"amplitude": "F0/K", "y": "F0/K", "x_dot": "omega F0/K", "z_dot": "omega F0/K"}
#: Arguments that contain values of a state by name.
OF_STATES = ("state", "fixed")
#: The axes of a plane of parameters of a structure, and the times of a simulation of a structure.
AXES = ("x", "y")
TIMES = {"duration": "1/omega", "start": "1/omega", "discard": "1/omega"}
#: The units of the quantities that limits and targets refer to.
OF_FIGURES = {
    "displacement": "F0/K", "rms": "F0/K", "acceleration": "omega^2 F0/K", "force": "F0",
    "speed": "omega F0/K", "least_speed": "omega F0/K", "least_gap": "F0/K",
}  # fmt: skip
#: Texts with these units, for messages.
EXAMPLES = {"F0/K": "2 mm", "omega^2 F0/K": "9.81 m/s^2", "F0": "6 N", "omega F0/K": "0.1 m/s"}
#: Arguments that contain values by name, and the units of these values.
BY_NAME = {
    "uncertain": PARAMETERS, "free": PARAMETERS, "tolerance": PARAMETERS, "limit": OF_FIGURES,
    "limits": OF_FIGURES,
}  # fmt: skip
#: Arguments that contain values of the parameter that another argument names.
OF_PARAMETER = ("bounds", "values", "at")
#: Types that never have a unit; most arguments are of these types.
PLAIN = (float, int, np.float64, type(None))


@dataclass(frozen=True)
class Units:
    """Physical units of the dimensionless quantities for a primary mass M, stiffness K and load F0.

    A dimensionless number times its unit is the physical number.

    Parameters
    ----------
    M, K, F0 : float
        Primary mass, stiffness, load amplitude: numbers in these units, or values with a unit, such as "42 kN/m".
    names : str
        Units of length, force and time of these values, as in `Oscillator.from_dimensional`.

    Raises
    ------
    ParameterError, ParameterTypeError
        If a number is not positive, or a unit is not known.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> rig = vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=0.4, m=0.08, restitution=0.75)
    >>> units = rig.units(F0=4.0)
    >>> units.omega, units.length, units.clearance(d=[0.1, 0.2]).tolist()
    (20.0, 0.005, [20.0, 40.0])
    >>> units.to("mm N s").length, units.name("omega F0/K")
    (5.0, 'm/s')
    """

    M: float
    K: float
    F0: float
    names: str = SI

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", checked_names(self.names, "names"))
        for name in ("M", "K", "F0"):
            value = own_number(getattr(self, name), name, self.names)
            object.__setattr__(self, name, positive(value, name))

    def _repr_html_(self) -> str:
        """The representation in Jupyter."""
        names = ("omega", "length", "time", "velocity", "acceleration", "force")
        return facts_html(repr(self), {name: f"{getattr(self, name):.6g}" for name in names})

    @property
    def omega(self) -> float:
        """Natural frequency sqrt(K/M), radians per unit of time."""
        return math.sqrt(self.K / self.M)

    @property
    def length(self) -> float:
        """F0/K."""
        return self.F0 / self.K

    @property
    def time(self) -> float:
        """1/omega."""
        return 1 / self.omega

    @property
    def velocity(self) -> float:
        """Unit of velocity, omega F0/K."""
        return self.omega * self.length

    @property
    def acceleration(self) -> float:
        """Unit of acceleration, omega^2 F0/K = F0/M."""
        return self.F0 / self.M

    @property
    def force(self) -> float:
        """F0."""
        return self.F0

    @property
    def energy(self) -> float:
        """F0^2/K."""
        return self.F0 * self.length

    @property
    def impulse(self) -> float:
        """F0/omega."""
        return self.F0 / self.omega

    @property
    def frequency(self) -> float:
        """Natural frequency omega/(2 pi), cycles per unit of time: the load frequency at r = 1."""
        return self.omega / (2 * math.pi)

    def to(self, names: str) -> Units:
        """The same system in other units of length, force and time, such as "mm N s"; "SI" is "m N s".

        Parameters
        ----------
        names : str
            Names of the units of length, force and time.

        Returns
        -------
        Units
            The same M, K and F0 in these units.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a unit is not known.
        """
        new = checked_names(names, "names")
        length, force, time = (
            known[own] / known[other]
            for known, own, other in zip(KNOWN, self.names.split(), new.split(), strict=True)
        )
        return Units(
            self.M * force * time**2 / length, self.K * force / length, self.F0 * force, new
        )

    def scale(self, unit: str) -> float:
        """The factor that converts a dimensionless quantity to physical units.

        Parameters
        ----------
        unit : str
            The unit in the form that columns of results declare: "F0/K", "omega F0/K", "1/omega" and so on.

        Returns
        -------
        float
            The factor; 1 for dimensionless quantities.

        Raises
        ------
        ParameterError
            If `unit` is not a product of powers of F0, K and omega.
        """
        factors = {"F0": self.F0, "K": self.K, "omega": self.omega}
        return math.prod(factors[name] ** power for name, power in powers_of(unit).items())

    def name(self, unit: str) -> str:
        """The name of the physical unit, such as "m/s^2", that corresponds to a dimensionless unit.

        Parameters
        ----------
        unit : str
            The unit in the form that columns of results declare, as in `scale`.

        Returns
        -------
        str
            The name; a dimensionless unit is returned unchanged.
        """
        powers = powers_of(unit)
        if not powers:
            return unit
        sums = np.array(
            [np.multiply(DIMENSIONS[name], power) for name, power in powers.items()]
        ).sum(axis=0)
        if sums.tolist() == [-1, 1, 2] and self.names in OF_MASS:
            return OF_MASS[self.names]
        length, force, time = zip(self.names.split(), sums.tolist(), strict=True)
        parts = [(name, power) for name, power in (force, length, time) if power]
        above = [_power(name, power) for name, power in parts if power > 0]
        below = [_power(name, -power) for name, power in parts if power < 0]
        return "/".join([" ".join(above) or "1", *below]) if parts else ""

    @property
    def of_pictures(self) -> Units:
        """The units for axes: with mm instead of m if F0/K is below a decimetre."""
        length, force, time = self.names.split()
        return self.to(f"mm {force} {time}") if length == "m" and self.length < 0.1 else self

    @property
    def hertz(self) -> str:
        """The name of the unit of frequency, cycles per unit of time."""
        time = self.names.split()[2]
        return {"s": "Hz", "ms": "kHz", "us": "MHz"}.get(time, f"1/{time}")

    @overload
    def clearance(self, d: float | str) -> float: ...
    @overload
    def clearance(self, d: ArrayLike) -> Any: ...
    def clearance(self, d: Any) -> Any:
        """The dimensionless clearance D = d K/F0 of a clearance d.

        d is the whole travel of the free mass from wall to wall: in the middle of the slot it has d/2 on either
        side, so that |Z - X| <= D/2. If "4 mm of play" means 4 mm on each side, d is 8 mm.

        Parameters
        ----------
        d : float or array_like, or str or pint.Quantity
            A number in the unit of length, or a value with its unit, such as "4 mm".

        Returns
        -------
        float or ndarray
            The dimensionless clearance; an ndarray for an array.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a value is not a positive number.
        """
        return positive_each(plain_number(d, "d", (1, 0, 0), self.names), "d", d) / self.length

    def frequency_ratio(self, frequency: Any = None, *, Omega: Any = None, f: Any = None) -> Any:
        """Frequency ratio r = Omega/omega of a load frequency.

        Parameters
        ----------
        frequency : str or pint.Quantity, optional
            A value with its unit (Hz, rpm or rad/s), such as "19.5 Hz"; give either this, `Omega` or `f`.
        Omega : float, str, pint.Quantity or array_like, optional
            Radians per unit of time.
        f : float, str, pint.Quantity or array_like, optional
            Cycles per unit of time (Hz).

        Returns
        -------
        float or ndarray
            The frequency ratio; an ndarray for an array.

        Raises
        ------
        ParameterError, ParameterTypeError
            If a value is not a positive number, several are given, or a frequency has no unit.
        """
        given = {"frequency": frequency, "Omega": Omega, "f": f}
        given = {name: value for name, value in given.items() if value is not None}
        if len(given) != 1:
            shown = ", ".join(f"{name} = {value!r}" for name, value in given.items()) or "f = None"
            raise ParameterError(f"{shown}: must be one of frequency, Omega and f")
        if Omega is not None:
            own = own_number(Omega, "omega", self.names, "Omega")
            return positive_each(own, "Omega", Omega) / self.omega
        if f is not None:
            return positive_each(own_number(f, "f", self.names), "f", f) / self.frequency
        if not has_unit(frequency):
            raise ParameterError(
                f"frequency = {frequency!r}: must have a unit, such as '19.5 Hz'; or give f=... in cycles or "
                "Omega=... in radians per unit of time"
            )
        return positive_each(
            number_of(frequency, "frequency", "omega", lambda: self), "frequency", frequency
        )

    def motion(self, motion: Any) -> dict[str, Any]:
        """The values of a motion in physical units.

        Parameters
        ----------
        motion : Motion
            A motion of an oscillator.

        Returns
        -------
        dict
            ``d``, ``Omega``, ``period``, ``t`` (times of the impacts), ``X``, ``Z``, the four
            velocities, ``A``, ``x_min``, ``x_max``; names as in `Motion`.

        Raises
        ------
        ParameterTypeError
            If `motion` is not a Motion.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator.from_dimensional(M=2.0, K=800.0, C=0.4, m=0.08, restitution=0.75)
        >>> motion = vi.equispaced(osc, r=1.04, clearance=25.0)[0]
        >>> physical = osc.units(F0=4.0).motion(motion)
        >>> round(physical["d"], 6), round(physical["Omega"], 6)
        (0.125, 20.8)
        """
        if not hasattr(motion, "load_phase"):
            raise ParameterTypeError(
                f"motion = {motion!r}: must be a vibroimpact.Motion, not {type(motion).__name__}"
            )
        physical: dict[str, Any] = {
            "d": motion.clearance * self.length,
            "Omega": motion.r * self.omega,
            "period": motion.period * self.time,
            "t": motion.alpha / motion.r * self.time,
        }
        for name in ("X", "Z", "A", "x_min", "x_max"):
            physical[name] = getattr(motion, name) * self.length
        for name in ("X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after"):
            physical[name] = getattr(motion, name) * self.velocity
        return physical


def powers_of(unit: str) -> dict[str, int]:
    """The powers of F0, K and omega in a unit; empty for a unit that contains none of them.

    Examples
    --------
    >>> from vibroimpact.systems.units import powers_of
    >>> powers_of("omega^2 F0/K"), powers_of("1/omega"), powers_of("rad")
    ({'omega': 2, 'F0': 1, 'K': -1}, {'omega': -1}, {})
    """
    if not isinstance(unit, str):
        raise ParameterTypeError(
            f"unit = {unit!r}: must be a text such as 'omega F0/K', not {type(unit).__name__}"
        )
    above, _, below = unit.partition("/")
    powers: dict[str, int] = {}
    for text, sign in ((above, 1), (below, -1)):
        for factor in text.split():
            name, _, power = factor.partition("^")
            if name in DIMENSIONS:
                powers[name] = sign * (2 if power == "2" else 1)  # other names are rejected below
    if unit == MIXED or (
        powers and set(unit.replace("/", " ").replace("^2", "").split()) - {"1", *DIMENSIONS}
    ):
        raise ParameterError(
            f"unit = {unit!r}: must be a product of powers of F0, K and omega, or contain none of them"
        )
    return powers


def _power(name: str, power: int) -> str:
    return name if power == 1 else f"{name}^{power}"


def checked_names(value: Any, name: str = "units") -> str:
    """The names of a unit of length, one of force and one of time."""
    wanted = (
        "units of length, force and time, such as 'mm N s', of "
        + "; ".join(", ".join(known) for known in KNOWN) + "; or 'SI'"
    )  # fmt: skip
    if not isinstance(value, str):
        raise ParameterTypeError(
            f"{name} = {value!r}: must be {wanted}, not {type(value).__name__}"
        )
    names = (SI if value == "SI" else with_u(value)).split()
    if len(names) != 3 or any(one not in known for one, known in zip(names, KNOWN, strict=True)):
        given = f"{name} {value[:80]!r}" if name.startswith("--") else f"{name} = {value[:80]!r}"
        raise ParameterError(f"{given}: must be {wanted}")
    return " ".join(names)


def with_u(unit: str) -> str:
    """The name of a unit with u for micro, in place of the micro sign or the Greek letter."""
    return re.sub("[\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}]", "u", unit)


def positive_each(value: Any, name: str, given: Any = None) -> Any:
    """One positive number, or an array of them; messages show what was given, if it had units."""
    shown = has_unit(given)
    if not isinstance(value, (list, tuple)) and np.ndim(value) == 0:
        return positive(value, name, given=given)
    wanted = f"finite numbers with {name} > 0"
    array = checks.real_array(value, name, wanted)
    good = (array > 0) & np.isfinite(array)
    if not good.all():
        bad = f"with {array[~good].ravel()[0].item()!r}"
        raise ParameterError(f"{name} {f'= {given!s}' if shown else bad}: must be {wanted}")
    return array


def positive(value: Any, name: str, *, zero: bool = False, given: Any = None) -> float:
    """One positive number, or 0 if that is allowed; messages show what was given, if it had a unit."""
    wanted = f"a finite number with {name} {'>=' if zero else '>'} 0"
    item = checks.to_float(value, name, wanted)
    if not (0 < item < math.inf or (zero and item == 0)):
        shown = str(given) if has_unit(given) else repr(value)
        raise ParameterError(f"{name} = {shown}: must be {wanted}")
    return item


class Scaled(Protocol):
    """An oscillator, which may know its units."""

    @property
    def F0(self) -> float | None: ...

    def units(self, F0: float | None = None) -> Units: ...


@dataclass(frozen=True)
class OfStructure:
    """The units of the structure of an oscillator, in place of the oscillator."""

    known: Units

    @property
    def F0(self) -> float:
        """The load amplitude."""
        return self.known.F0

    def units(self, F0: float | None = None) -> Units:
        """The units; `F0` is that of the structure."""
        return self.known


def in_si(text: str, name: str) -> tuple[Decimal, Powers, bool]:
    """A text with a unit: its value in SI, its powers of length, force and time, and whether it is an angle."""
    found = QUANTITY.fullmatch(with_u(text))
    assert found is not None
    # Decimal, so that 1.1 % is the float 0.011
    value, powers, angular = Decimal(found[1]), np.zeros(3, int), False
    # one unit after each slash, any number of units before the first one
    above, *below = found[2].replace("\N{SUPERSCRIPT TWO}", "^2").split("/")
    parts = [(part, 1) for part in re.split(r"[\s*\N{MIDDLE DOT}]+", above.strip())]
    for part, sign in [*parts, *((part.strip(), -1) for part in below)]:
        factor = FACTOR.fullmatch(part)
        if part == "1":
            continue
        if factor is None or factor[1] not in NAMED:
            hint = "; a decimal point is needed, not a comma" if re.match(r",\d", part) else ""
            raise ParameterError(
                f"{name} = {text!r}: unknown unit {part!r}{hint}; must be made of {', '.join(NAMED)}, such as "
                "'N s/m'"
            )
        power = sign * int(factor[2] or 1)
        size, dimensions, angle = NAMED[factor[1]]
        value *= Decimal(repr(size)) ** power
        powers += np.multiply(dimensions, power)
        angular = angular or angle
    length, force, time = powers.tolist()
    return value, (length, force, time), angular


def of_pint(quantity: Any, name: str) -> tuple[Any, Powers, bool]:
    """A quantity of pint, as in `in_si`; pint itself treats 1 Hz as 1 rad/s."""
    try:
        units = str(quantity.units)
        base = quantity.to_base_units()
        by_name = {str(key): int(power) for key, power in base.dimensionality.items()}
    except (AttributeError, TypeError, ValueError) as error:
        raise ParameterTypeError(
            f"{name} = {quantity!r}: must be a number, a text with a unit, such as '4 mm', or a quantity of pint, "
            f"with to_base_units and dimensionality, not {type(quantity).__name__} ({error})"
        ) from None
    mass = by_name.pop("[mass]", 0)
    length, time = by_name.pop("[length]", 0), by_name.pop("[time]", 0)
    if by_name:
        raise ParameterError(f"{name} = {quantity}: must have a mechanical unit")
    cycles = "hertz" in units
    words = ("radian", "revolution", "turn", "rpm", "degree", "arcminute", "arcsecond")
    angular = cycles or any(word in units for word in words)
    value = base.to(f"kilogram**{mass} * meter**{length} * second**{time}").magnitude
    # kg = N s^2/m
    return value * (2 * math.pi if cycles else 1), (length - mass, mass, time + 2 * mass), angular


def has_unit(value: Any) -> bool:
    """Whether a value is a text such as "4 mm", a quantity of pint, or a list, tuple, array or mapping that
    contains one."""
    if isinstance(value, PLAIN):
        return False
    if isinstance(value, np.ndarray):
        return value.dtype.kind in "OU" and any(map(has_unit, value.ravel().tolist()))
    if isinstance(value, Mapping):
        return any(map(has_unit, value.values()))
    if isinstance(value, (list, tuple)):
        return any(map(has_unit, value))
    if isinstance(value, str):
        return QUANTITY.fullmatch(with_u(value)) is not None
    return hasattr(value, "magnitude") and hasattr(value, "units")


def converted_each(value: Any, name: str, convert: Callable[[Any], Any]) -> Any:
    """A list, tuple or array whose items are converted one by one.

    Raises
    ------
    ParameterError
        If some items have a unit and others do not. 0 needs no unit.
    """
    items = value.tolist() if isinstance(value, np.ndarray) else value
    nested = any(isinstance(item, (list, tuple)) for item in items)
    bare = [item for item in items if not has_unit(item) and not is_zero(item)]
    if bare and not nested:
        other = next(item for item in items if has_unit(item))
        raise ParameterError(
            f"{name} = {value!s}: must have a unit for each number, or for none; {other!s} has one and "
            f"{bare[0]!r} has none"
        )
    found = [convert(item) for item in items]
    return np.array(found) if isinstance(value, np.ndarray) else type(value)(found)


def is_zero(value: Any) -> bool:
    """Whether a value is the number 0, which is the same in all units."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value == 0


def number_of(value: Any, name: str, unit: str, units: Callable[[], Units]) -> Any:
    """The dimensionless number of an argument; a value without a unit is returned unchanged.

    Parameters
    ----------
    value
        A number, a text, a quantity of pint, or a list, tuple or array of them.
    name : str
        The argument, for messages.
    unit : str
        Its dimensionless unit, such as "F0/K"; a frequency is a ratio to "omega".
    units : callable
        Returns the units of the system, or raises an error that names what is missing.

    Raises
    ------
    ParameterError
        If the unit is unknown or of another kind, or a frequency is in 1/s, which does not say whether cycles or
        radians are meant.
    """
    if not has_unit(value):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return converted_each(value, name, lambda item: number_of(item, name, unit, units))
    size, powers, angular = in_si(value, name) if isinstance(value, str) else of_pint(value, name)
    wanted = np.zeros(3, int)
    size = float(size) if isinstance(size, Decimal) else size
    if powers == (0, 0, 0) and not angular and (unit == MASS or not isinstance(value, str)):
        return size  # a share of M in %, or a ratio that pint computed
    for part, power in powers_of(unit).items():
        wanted += np.multiply(DIMENSIONS[part], power)
    if unit == "omega" and powers == (0, 0, -1) and not angular:
        raise ParameterError(f"{name} = {value!s}: must be in Hz, rpm or rad/s")
    if powers != tuple(wanted.tolist()) or angular != (unit == "omega"):
        kind = {"omega": "a frequency", "F0/K": "a length", "F0": "a force", "1/omega": "a time"}
        kind |= {
            "omega^2 F0/K": "an acceleration",
            "K": "a stiffness",
            "K/omega": "a damping coefficient",
        }
        kind |= {MASS: "a mass, or a ratio of masses", "": "a number without a dimension"}
        raise ParameterError(f"{name} = {value!s}: must be {kind.get(unit, 'a velocity')}")
    if unit == "":
        return size
    try:
        known = units()
    except ParameterError as error:
        raise ParameterError(
            f"{name} = {value!s}: must be without a unit unless the units of the system are known; {error}"
        ) from None
    return size / known.to("SI").scale(unit)


def argument(osc: Any, value: Any, name: str, unit: str) -> Any:
    """The dimensionless value of an argument of a method of a result; a value without a unit is unchanged.

    Parameters
    ----------
    osc : Oscillator
        The system of the result; a structure is in the units of the user, so its values have no units here.
    """
    if isinstance(value, PLAIN) or osc is None or not has_unit(value):
        return value
    return number_of(value, name, unit, lambda: osc.units(_force(osc, unit)))


def refuse_hertz(osc: Any, r: Any) -> None:
    """Raise an error for frequency ratios without a unit that were almost certainly meant in Hz.

    They are large, and about the natural frequency of a rig; the core refuses the same ones in namelists.
    """
    if getattr(osc, "M", None) is None or osc.K is None:
        return
    natural = osc.units(_force(osc, "omega")).to("SI").frequency
    for one in r if isinstance(r, (list, tuple, np.ndarray)) else (r,):
        if isinstance(one, (int, float)) and one > 5 and natural / 2 < one < 2 * natural:
            raise ParameterError(
                f"r = {r!s}: must be a ratio if it has no unit, but {one:.6g} is about the natural frequency "
                f"in Hz ({natural:.4g}); write a frequency with its unit, such as '20 Hz'"
            )


def time_of(system: Any, value: Any, name: str) -> Any:
    """The dimensionless time of an argument of a method of a result, also of a structure with units."""
    units = getattr(system, "_units", None)
    if units is None and not hasattr(system, "F0"):
        return value  # of a structure of the user, whose units have no names
    return argument(system if units is None else OfStructure(units), value, name, "1/omega")


def of_parameter(structure: Any, parameter: str, value: Any, name: str) -> Any:
    """The dimensionless value of a parameter of a structure with units; a value without a unit is unchanged."""
    units = getattr(structure, "_units", None)
    if units is None or not has_unit(value):
        return value
    unit = unit_of_parameter(parameter, value, name, OF_STRUCTURE)
    return number_of(value, name, unit, lambda: units)


def unit_of_parameter(parameter: str, value: Any, name: str, known: Mapping[str, str]) -> str:
    """The dimensionless unit of a parameter of which a value with a unit was given."""
    unit = known.get(parameter)
    unit = OF_STRUCTURE.get(parameter.split("_")[0]) if unit is None else unit
    if unit is None:
        raise ParameterError(
            f"{name} = {value!s}: must have no units for the parameter {parameter!r}; those of "
            f"{', '.join(known)} may have them"
        )
    return unit


def _force(osc: Scaled, unit: str) -> float | None:
    """A load amplitude for units of quantities that do not depend on it: frequencies, times and masses."""
    return 1.0 if osc.F0 is None and unit in ("omega", "1/omega", MASS, "") else None


def plain_number(value: Any, name: str, powers: Powers, names: str) -> Any:
    """A value with a unit, converted to the named units of length, force and time; a value without a unit is
    unchanged."""
    if not has_unit(value):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return converted_each(value, name, lambda item: plain_number(item, name, powers, names))
    size, found, angular = in_si(value, name) if isinstance(value, str) else of_pint(value, name)
    if found != powers or angular:
        own = {
            (1, 0, 0): "length", (0, 1, 0): "force", (-1, 1, 2): "mass", (-1, 1, 0): "stiffness",
            (-1, 1, 1): "damping coefficient", (1, 0, -1): "velocity", (1, 0, -2): "n acceleration",
            (0, 0, 1): "time", (0, 0, 0): "number",
        }  # fmt: skip
        kind = own[powers]
        raise ParameterError(
            f"{name} = {value!s}: must be a{kind if kind[:2] == 'n ' else f' {kind}'}"
        )
    sizes = [Decimal(repr(known[own])) for known, own in zip(KNOWN, names.split(), strict=True)]
    own_size = math.prod(one**power for one, power in zip(sizes, powers, strict=True))
    return float(size / own_size) if isinstance(size, Decimal) else size / float(own_size)


def given_and_used(given: Any, used: Any) -> Iterator[tuple[str, float]]:
    """The values with units of an argument as texts, and the dimensionless numbers that replaced them."""
    if isinstance(given, Mapping):
        for key, value in given.items() if isinstance(used, Mapping) else ():
            yield from given_and_used(value, used.get(key))
    elif isinstance(given, (list, tuple, np.ndarray)) and isinstance(
        used, (list, tuple, np.ndarray)
    ):
        for one, other in zip(given, used, strict=False):
            yield from given_and_used(one, other)
    elif has_unit(given) and not isinstance(used, str) and np.size(used) == 1:
        number = float(np.asarray(used).item())
        if number:  # 0 may be that of another value
            yield str(given), number


@contextmanager
def shown_as_given(values: Iterable[tuple[Any, Any]], osc: Any = None) -> Iterator[None]:
    """Make errors raised within this context name the values of arguments as given, then as dimensionless numbers.

    The rest of a message, with what is allowed, refers to dimensionless numbers.

    Parameters
    ----------
    values : iterable of (given, used)
        Arguments with units, and the values that replaced them.
    osc : Oscillator, optional
        The system, for the value of a starting motion.
    """
    try:
        yield
    except (ParameterError, ParameterTypeError) as error:
        name, equals, rest = str(error).partition(" = ")
        value, must, allowed = rest.partition(": must ")
        if not must:  # of several arguments
            value, must, allowed = rest.partition(": exactly one must ")
        known = {
            f"{number:.9g}": (text, number)
            for given, used in values for text, number in given_and_used(given, used)
        }  # fmt: skip
        named: dict[str, float] = {}

        def as_given(found: re.Match[str]) -> str:
            text, number = known.get(f"{float(found[0]):.9g}", ("", 0.0))
            if text:
                named[text] = number
            return text or found[0]

        if not value.startswith("<"):  # a result shows its values in units already
            value = NUMBER.sub(as_given, value)
        if equals and must and named:
            plain = ", ".join(f"{text} is {number:.6g}" for text, number in named.items())
            allowed = STARTING.sub(
                lambda start: start[1] + value_text(osc, start[2], float(start[3])), allowed
            )
            note = f"; without units {plain}" if re.search(r"\d", allowed) else ""
            error.args = (f"{name} = {value}{must}{allowed}{note}",)
        raise


def units_to_show(osc: Any) -> Units | None:
    """The units in which results of a system are shown; None if they are dimensionless."""
    units = units_of_system(osc)
    return None if units is None else units.of_pictures


def units_of_system(system: Any) -> Units | None:
    """The units of an oscillator with known M, K and F0, or of its structure; else None."""
    units: Units | None = getattr(system, "_units", None)
    return system.units() if getattr(system, "F0", None) is not None else units


def chosen_units(result: Any, system: Any, units: Units | str | None) -> Units:
    """The units in which a result is given: the requested ones, or those of the system.

    Raises
    ------
    ParameterError, ParameterTypeError
        If M, K and F0 of the system are not known, or a unit is not known.
    """
    known = units_of_system(system)
    if known is None and not hasattr(system, "F0"):
        raise ParameterTypeError(
            f"result = {result!r}: must be a result of an Oscillator; a Structure uses the units that you choose"
        )
    if isinstance(units, Units):
        return units
    own: Units = system.units() if known is None else known
    return own if units is None else own.to(units)


def place_text(osc: Any, r: float, clearance: float, digits: int = 6) -> str:
    """A point (r, clearance) as a text: in the units of the system, if it has any, then dimensionless.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.systems.units import place_text
    >>> rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75, F0=6.0)
    >>> place_text(rig, 0.982362366, 28.0)
    '19.5 Hz, d = 4 mm (r = 0.982362, d K/F0 = 28)'
    """
    plain = f"r = {r:.{digits}g}, d K/F0 = {clearance:.{digits}g}"
    units = units_to_show(osc)
    if units is None:
        return plain
    length = units.names.split()[0]
    return (
        f"{r * units.frequency:.{digits}g} {units.hertz}, d = {clearance * units.length:.{digits}g} {length} "
        f"({plain})"
    )


def shown_unit(osc: Any, name: str) -> tuple[float, str]:
    """The factor and the unit with which values of an argument, or of a limited quantity, are shown."""
    known = STATE | ARGUMENTS | START | OF_FIGURES
    units, unit = units_to_show(osc), known.get(name, OF_STRUCTURE.get(name.split("_")[0], ""))
    if units is None or not unit:
        return 1.0, ""
    if unit == "omega":
        return units.frequency, f" {units.hertz}"
    return units.scale(unit), f" {units.name(unit)}"


def range_text(osc: Any, name: str, low: float, high: float, digits: int = 6) -> str:
    """A range of values as a text, such as "18 to 21 Hz" or "0.9 to 1.1"."""
    scale, unit = shown_unit(osc, name)
    return f"{low * scale:.{digits}g} to {high * scale:.{digits}g}{unit}"


def value_text(osc: Any, name: str, value: float, digits: int = 6) -> str:
    """A value as a text, such as "4 mm" or "28"."""
    scale, unit = shown_unit(osc, name)
    return f"{value * scale:.{digits}g}{unit}"


def wanted_figure(name: str) -> str:
    """What a limit of a quantity must be, for messages."""
    unit = OF_FIGURES.get(name, "")
    if not unit:
        return f"a positive number ({name} is dimensionless)"
    return f"a positive number in {unit}, or a text with a unit, such as {EXAMPLES[unit]!r}"


def own_number(value: Any, name: str, names: str = SI, label: str = "") -> Any:
    """A value of a rig with a unit, converted to the named units of length, force and time; a value without a unit
    is unchanged.

    Frequencies are in cycles, except `omega`, which is in radians; `label` is the name for messages.
    """
    if not has_unit(value):
        return value
    label = label or name
    if isinstance(value, (list, tuple, np.ndarray)):
        return converted_each(value, label, lambda item: own_number(item, name, names, label))
    if name not in CYCLES and name != "omega":
        return plain_number(value, label, (POWERS | OTHERS)[name], names)
    size, powers, angular = in_si(value, label) if isinstance(value, str) else of_pint(value, label)
    if powers != (0, 0, -1) or not angular:
        raise ParameterError(f"{label} = {value!s}: must be a frequency in Hz, rpm or rad/s")
    scale = KNOWN[2][names.split()[2]] / (1.0 if name == "omega" else 2 * math.pi)
    found = (float(size) if isinstance(size, Decimal) else size) * scale
    if name == "omega" or np.ndim(found):  # in rad/s as `number_of` converts it
        return found
    return float(f"{found:.15g}")  # 2 kHz are 2000 Hz


def unit_of_state(name: Any) -> str:
    """The dimensionless unit of a coordinate or velocity by its name; of an output, that of a displacement."""
    rate = isinstance(name, str) and name.startswith("q_dot")
    return "omega F0/K" if rate else STATE.get(name, "F0/K")


def dimensionless(osc: Scaled, name: str, value: Any, parameter: str = "") -> Any:
    """The dimensionless value of an argument of a function; a value without a unit is unchanged."""
    if name in OF_STATES and not isinstance(value, Mapping):  # of a structure
        lists = isinstance(value, (list, tuple)) and [
            part for part in value if isinstance(part, (list, tuple, np.ndarray))
        ]
        if not lists or not len(lists) == len(value) == 2:
            return value
        parts = zip(value, ("F0/K", "omega F0/K"), strict=True)
        return tuple(number_of(part, name, unit, osc.units) for part, unit in parts)
    if name in OF_STATES:
        return {
            key: number_of(part, f"{name}[{key!r}]", STATE[key], osc.units)
            if key in STATE
            else part
            for key, part in value.items()
        }
    if name in AXES:
        # (parameter, low, high) or (parameter, values)
        if not isinstance(value, tuple) or not isinstance(value[0], str):
            return value  # not an axis, or one along a function of a parameter
        of_axis = OF_STRUCTURE.get(value[0].split("_")[0], "")
        return (value[0], *number_of(value[1:], name, of_axis, osc.units))
    if name == "plane":
        # (name, low, high, n) or (name, values); the study refuses anything else
        if not isinstance(value, (list, tuple)) or not all(
            isinstance(axis, (list, tuple)) and len(axis) > 1 for axis in value
        ):
            return value
        return tuple(
            (
                axis[0],
                *number_of(tuple(axis[1:3]), f"plane[{i}]", unit_of_state(axis[0]), osc.units),
                *axis[3:],
            )
            for i, axis in enumerate(value)
        )
    if name in BY_NAME and isinstance(value, Mapping):
        return {
            key: argument(osc, part, f"{name}[{key!r}]", BY_NAME[name][key])
            if key in BY_NAME[name]
            else part
            for key, part in value.items()
        }
    if name == "limit":  # of the target
        unit = OF_FIGURES.get(parameter)
        return value if unit is None else number_of(value, name, unit, osc.units)
    unit = (PARAMETERS | START | TIMES).get(name)
    if name in OF_PARAMETER:
        # a load is a factor among the parameters of a structure
        of_structure = isinstance(osc, OfStructure)
        known = OF_STRUCTURE if of_structure else PARAMETERS | START | OF_STRUCTURE
        unit = unit_of_parameter(parameter, value, name, known)
    if unit is None:
        return value
    return argument(osc, value, name, unit)
