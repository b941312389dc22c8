"""The oscillator, an oscillator at a point, and the pattern of impacts."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from functools import wraps
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.jupyter import facts_html
from .restitution import Restitution, checked
from .structure import Friction, Gap, Load, Stop, Structure
from .units import (
    POWERS,
    SI,
    Units,
    argument,
    checked_names,
    dimensionless,
    has_unit,
    number_of,
    own_number,
    place_text,
    plain_number,
    positive,
    refuse_hertz,
    shown_as_given,
    units_to_show,
    value_text,
)

__all__ = ["Oscillator", "Pattern"]

#: Stiffness divided by K and damping divided by sqrt(K M) of a compliant wall.
Wall: TypeAlias = tuple[float, float]
#: The right and the left wall; None for a rigid one.
Stops: TypeAlias = tuple[Wall | None, Wall | None]
#: Largest number of characters of a user's text that a message repeats.
MOST_SHOWN = 80
Names = ParamSpec("Names")
Found = TypeVar("Found")


def by_name(example: str) -> Callable[[Callable[Names, Found]], Callable[Names, Found]]:
    """Make a method refuse positional arguments, with an error that shows the call by keyword."""

    def decorate(method: Callable[Names, Found]) -> Callable[Names, Found]:
        @wraps(method)
        def checked(*positional: Any, **named: Any) -> Found:
            if len(positional) > 1:  # the first argument is the object or the class
                given = ", ".join(map(repr, positional[1:]))
                raise ParameterTypeError(
                    f"{example.partition('(')[0]}({given}): must have the names of its parameters, as {example}"
                )
            return method(*positional, **named)

        return checked

    return decorate


@dataclass(frozen=True)
class Oscillator:
    """A primary mass on a spring and dashpot, with a free mass between two walls.

    Between impacts ``x'' + 2 xi x' + x = sin(r t)`` and ``z'' = 0``, with time in 1/omega and
    length in F0/K (equations (1)-(4) of Popplewell, Bapat and McLachlan, 1983).

    All parameters are keyword-only, because three numbers between 0 and 1 are easily given in the wrong order.

    Parameters
    ----------
    xi : float or str
        Damping ratio C/(2 sqrt(K M)), ``0 <= xi < 1``, or a text such as "1.1 %".
    mu : float or str
        Mass ratio m/M, ``0 <= mu <= 1e6``, or, if M is given, the free mass, such as "0.11 kg". With 0, the
        impacts do not affect the primary mass (the impact pair).
    restitution : float, PowerLaw or TabulatedRestitution, or two of them
        Coefficients of restitution (R1 on the right wall, R2 on the left), each in [0, 1] or a law as a function
        of the approach speed in F0 omega/K; a single value applies to both walls. An oscillator with a law is
        treated as `Oscillator.structure`: `simulate`, `exact`, `find`, `lyapunov`, `basins`, `response` and
        `bifurcation_diagram` accept it and return the results of a `Structure`; all others require numbers.
    M, K, F0 : float, str or pint.Quantity, optional
        Primary mass, stiffness and load amplitude in physical units, for `units`; `from_dimensional` sets them.
        All results of the oscillator and their files keep them. They are not part of the dimensionless system, so
        they are neither compared nor shown.
    unit_names : str, optional
        The units of length, force and time of these values, such as ``"mm N s"``.

    Raises
    ------
    ParameterError, ParameterTypeError
        If a value is outside its range, is not a real number, or is not given by keyword.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))

    With a law of restitution, the other arguments and the results are those of a structure:

    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=vi.PowerLaw(0.75, speed=20, exponent=0.25))
    >>> vi.exact(osc, 0.94, 37.0, ([1.6, 6.0], [0, 1]))
    <Motion of 2 impacts in 1 cycle: admissible, stable (max|lambda| = 0.9179)>
    """

    xi: float
    mu: float
    restitution: tuple[Any, Any]
    #: Primary mass in physical units, if set by `from_dimensional`.
    M: float | None = field(default=None, repr=False, compare=False, kw_only=True)
    #: Stiffness in physical units, if set by `from_dimensional`.
    K: float | None = field(default=None, repr=False, compare=False, kw_only=True)
    #: Load amplitude in physical units, if set by `from_dimensional`.
    F0: float | None = field(default=None, repr=False, compare=False, kw_only=True)
    #: Units of length, force and time of these, if M is known.
    unit_names: str | None = field(default=None, repr=False, compare=False, kw_only=True)

    @by_name("Oscillator(xi=0.0114, mu=0.028, restitution=0.75)")
    def __init__(
        self,
        *,
        xi: float,
        mu: float,
        restitution: Restitution | tuple[Restitution, Restitution],
        M: float | None = None,
        K: float | None = None,
        F0: float | None = None,
        unit_names: str | None = None,
    ) -> None:
        if (M is None) != (K is None):
            raise ParameterError(f"M = {M!r}, K = {K!r}: must both be given, or neither")
        for name, value in {"F0": F0, "unit_names": unit_names}.items():
            if M is None and value is not None:
                raise ParameterError(f"{name} = {value!r}: must be given with M and K only")
        names = SI if unit_names is None else checked_names(unit_names, "unit_names")
        mass: Any = mu
        given = {"M": M, "K": K, "F0": F0}
        values: dict[str, Any] = {
            name: value
            if value is None
            else positive(own_number(value, name, names), name, given=value)
            for name, value in given.items()
        }
        if has_unit(mu):
            if str(mu).endswith("%"):
                mass = plain_number(mu, "mu", (0, 0, 0), names)
            elif values["M"] is None:
                raise ParameterError(f"mu = {mu!s}: must be m/M if M is not given")
            else:
                mass = plain_number(mu, "mu", POWERS["m"], names) / values["M"]
        values |= {
            "xi": checks.number(plain_number(xi, "xi", (0, 0, 0), names), "xi"),
            "mu": checks.number(mass, "mu"),
            "restitution": _walls(restitution),
            "unit_names": None if M is None else names,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _repr_html_(self) -> str:
        """The representation in Jupyter."""
        right, left = self.restitution
        facts = {"xi": self.xi, "mu": self.mu, "R1 (right wall)": right, "R2 (left wall)": left}
        units = (
            {}
            if self.M is None
            else {"M": self.M, "K": self.K, "F0": self.F0, "units": self.unit_names}
        )
        return facts_html(repr(self), {name: str(value) for name, value in (facts | units).items()})

    @classmethod
    @by_name("Oscillator.from_dimensional(M=0.73, K=11385.0, C=2.08, m=0.02, restitution=0.75)")
    def from_dimensional(
        cls,
        *,
        M: float | str,
        K: float | str,
        m: float | str,
        restitution: Restitution | tuple[Restitution, Restitution],
        C: float | str | None = None,
        xi: float | str | None = None,
        F0: float | str | None = None,
        units: str = SI,
    ) -> Oscillator:
        """The dimensionless system of a rig, with its physical units.

        All its results carry these units too: see `Units` and the method `physical` of results.

        All parameters are keyword-only.

        Parameters
        ----------
        M, K : float, str or pint.Quantity
            Primary mass (> 0) and stiffness (> 0), as numbers in `units` or with units: "2.7 kg", "42 kN/m".
        m : float, str or pint.Quantity
            Free mass (>= 0).
        restitution : float, PowerLaw or TabulatedRestitution, or two of them
            As for the class.
        C : float, str or pint.Quantity, optional
            Viscous damping (>= 0, below critical), such as "2.1 N s/m".
        xi : float or str, optional
            Damping ratio, instead of C: 0 <= xi < 1, or a text such as "1.1 %".
        F0 : float, str or pint.Quantity, optional
            Load amplitude (> 0).
        units : str
            Units of length, force and time of these values: one of m, mm, cm, um, km, in, ft; one of N,
            mN, kN, MN, lbf, kgf; one of s, ms, us, min, h. The unit of mass follows from them (kg for "m N s",
            tonne for "mm N s").

        Raises
        ------
        ParameterError, ParameterTypeError
            As for the class.

        Examples
        --------
        The 1983 rig: weights of 1.61 lbf and 0.044 lbf, and a stiffness of 65.01 lbf/in.

        >>> import math, vibroimpact as vi
        >>> g = 386.09                                   # in/s^2
        >>> M, K = 1.61 / g, 65.01
        >>> C = 2 * 0.0114 * math.sqrt(K * M)
        >>> rig = vi.Oscillator.from_dimensional(
        ...     M=M, K=K, C=C, m=0.044 / g, restitution=0.75, F0=0.5, units="in lbf s"
        ... )
        >>> round(rig.xi, 4), round(rig.mu, 4)
        (0.0114, 0.0273)
        >>> units = rig.units()
        >>> round(units.clearance(d=0.0105), 4)
        1.3652
        >>> round(units.frequency_ratio(f=19.87), 4)
        0.9999
        >>> round(units.to("m N s").M, 4), round(units.to("m N s").K, 1)
        (0.7303, 11385.0)
        """
        names = checked_names(units)
        given = {"M": M, "K": K, "m": m, "C": C, "xi": xi, "F0": F0}
        values: dict[str, Any] = {
            name: plain_number(value, name, POWERS[name], names) for name, value in given.items()
        }
        if (C is None) == (xi is None):
            raise ParameterError(f"C = {C!r}, xi = {xi!r}: exactly one must be given")
        mass, stiffness = positive(values["M"], "M", given=M), positive(values["K"], "K", given=K)
        ratio = values["xi"]
        if C is not None:
            damping = positive(values["C"], "C", zero=True, given=C)
            # with 50 digits, so that the result is the nearest float and xi = 0.05 is restored exactly
            with localcontext() as context:
                context.prec = 50
                critical = 2 * (Decimal(stiffness) * Decimal(mass)).sqrt()
                ratio = float(Decimal(damping) / critical)
            if not ratio < 1:
                raise ParameterError(
                    f"C = {C!r}: must be below critical damping 2 sqrt(K M) = {critical:.6g}"
                )
        return cls(
            xi=ratio,
            mu=positive(values["m"], "m", zero=True, given=m) / mass,
            restitution=restitution,
            M=mass,
            K=stiffness,
            F0=None if F0 is None else positive(values["F0"], "F0", given=F0),
            unit_names=names,
        )

    def structure(
        self, clearance: float | None = None,
        restitution: Restitution | tuple[Restitution, Restitution] | None = None, *, d: float | None = None,
    ) -> Structure:  # fmt: skip
        """The same two masses as a structure; its coefficients of restitution may depend on the approach speed.

        The coordinates are x and z; gap 0 is the right wall and gap 1 the left one. With `clearance` the structure
        is dimensionless, and the load sin(r t) is ``Load(r, sine=[1, 0])``. With `d` it is in the units of M and
        K, for loads of any kind: a shock, a swept sine or base motion, by `Record`, `base_record` or
        `base_motion`.

        Parameters
        ----------
        clearance : float, optional
            Clearance d K/F0 > 0; d is the whole travel of the free mass between the walls. A length, such as
            "4 mm", is converted to it, so that the structure stays dimensionless.
        restitution : float, PowerLaw or TabulatedRestitution, or two of them (right wall, left wall), optional
            By default those of the oscillator. The speeds of a law are in F0 omega/K or, with `d`, in the units of
            M and K.
        d : float, optional
            The whole travel in the unit of length of M and K; give either this or `clearance`.

        Returns
        -------
        Structure
            A structure of two coordinates with two gaps.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed, or mu is 0: every body of a structure must have mass.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> pair = osc.structure(37.0, vi.PowerLaw(0.75, speed=20, exponent=0.25))
        >>> vi.exact(pair, vi.Load(0.94, sine=[1, 0]), ([1.6, 6.0], [0, 1]))
        <Motion of 2 impacts in 1 cycle: admissible, stable (max|lambda| = 0.9179)>
        """
        if not self.mu > 0:
            raise ParameterError(f"mu = {self.mu!r}: must be > 0 for a structure")
        M, K = 1.0, 1.0
        if d is None:
            half = 0.5 * positive(argument(self, clearance, "clearance", "F0/K"), "clearance")
        elif clearance is not None:
            raise ParameterError(f"clearance = {clearance!r}, d = {d!r}: exactly one must be given")
        elif self.M is None or self.K is None:
            raise ParameterError(f"d = {d!r}: must be left out for an oscillator without M and K")
        else:
            own = own_number(d, "d", self.unit_names or SI)
            half, M, K = 0.5 * positive(own, "d", given=d), self.M, self.K
        if isinstance(restitution, (tuple, list)) and len(restitution) != 2:
            raise ParameterError(
                f"restitution = {restitution!r}: must be one coefficient or law, or two: right, left"
            )
        right, left = (
            restitution if isinstance(restitution, (tuple, list))
            else self.restitution if restitution is None else (restitution, restitution)
        )  # fmt: skip
        gaps = [Gap([-1, 1], half, right), Gap([1, -1], half, left)]
        found = Structure([M, self.mu * M], [2 * self.xi * math.sqrt(K * M), 0], [K, 0], gaps)
        if d is not None:
            return found._with_units(Units(1.0, 1.0, 1.0, self.unit_names or SI))
        return found._with_units(None if self.F0 is None else self.units())

    def base_load(
        self, f: float, *, displacement: float | None = None, velocity: float | None = None,
        acceleration: float | None = None,
    ) -> float:  # fmt: skip
        """The load amplitude F0 equivalent to a harmonic motion of the base.

        A base that moves by y = Y sin(Omega t) exerts K y + C y' through the spring and dashpot, a force of
        amplitude Y |K + i Omega C|. Positions remain absolute, and the free mass still slides in its slot without
        friction. The force on the base is then K (X - y) + C (X' - y').

        Parameters
        ----------
        f : float
            Frequency of the base in cycles per unit of time (Hz), or with a unit, such as "19.5 Hz".
        displacement, velocity, acceleration : float
            Amplitude of one of these quantities, in the units of M and K, or with a unit, such as "1 m/s^2".

        Returns
        -------
        float
            F0, for `units` and for `from_dimensional`.

        Raises
        ------
        ParameterError, ParameterTypeError
            If M and K of the oscillator are not known, a value is not a positive number, or not exactly one
            amplitude is given.

        Examples
        --------
        A shaking table with 1 m/s^2 at 19.5 Hz, under a rig of 2.7 kg on 42 kN/m:

        >>> import vibroimpact as vi
        >>> rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, C=7.7, m=0.11, restitution=0.75)
        >>> round(rig.base_load(19.5, acceleration=1.0), 4)
        2.7985
        """
        if self.M is None or self.K is None:
            raise ParameterError("M = None: must be the primary mass for a motion of the base")
        names = self.unit_names or SI
        omega = 2 * math.pi * positive(own_number(f, "f", names), "f", given=f)
        amplitudes = {
            "displacement": displacement,
            "velocity": velocity,
            "acceleration": acceleration,
        }
        given = [name for name, value in amplitudes.items() if value is not None]
        if len(given) != 1:
            raise ParameterError(
                f"displacement, velocity, acceleration: exactly one must be given; given: {given}"
            )
        value = own_number(amplitudes[given[0]], given[0], names)
        amplitude = positive(value, given[0]) / omega ** [*amplitudes].index(given[0])
        return amplitude * math.hypot(self.K, omega * 2 * self.xi * math.sqrt(self.K * self.M))

    def units(self, F0: float | None = None) -> Units:
        """Physical units of length, time, velocity, … for a load amplitude F0, by default that of the oscillator.

        M and K of the oscillator must be known (see `from_dimensional`).

        Parameters
        ----------
        F0 : float, optional
            Load amplitude in the unit of force of M and K.

        Returns
        -------
        Units
            The units, which also convert values.

        Raises
        ------
        ParameterError, ParameterTypeError
            If M and K are not known, or F0 is not a positive number.
        """
        if self.M is None or self.K is None:
            raise ParameterError(
                "M = None: must be the primary mass for units; make the oscillator with "
                "Oscillator.from_dimensional(M=..., K=..., C=..., m=..., restitution=..., F0=...)"
            )
        if F0 is None and self.F0 is None:
            raise ParameterError(
                "F0 = None: must be the load amplitude for units; give it here as units(F0=...), or to "
                "Oscillator.from_dimensional"
            )
        return Units(self.M, self.K, self.F0 if F0 is None else F0, self.unit_names or SI)  # type: ignore[arg-type]

    def at(
        self, r: float | str, clearance: float | str, load: float | str | Load = 1.0, friction: float | str = 0.0,
        stops: Stops | None = None,
    ) -> Point:  # fmt: skip
        """The oscillator at a point, which functions accept in place of the oscillator, r, clearance and load.

        Parameters
        ----------
        r : float, str or pint.Quantity
            Frequency ratio Omega/omega; or, if M and K are known, a load frequency with its unit (Hz, rpm or
            rad/s), such as "19.5 Hz".
        clearance : float, str or pint.Quantity
            Clearance d K/F0 > 0, or a length d, such as "4 mm".
        load : float, str, pint.Quantity or Load
            Amplitude of the load divided by F0, or a force, such as "6 N"; or a `Load` of frequency r on the
            primary and the free mass, divided by F0, with further harmonics or a constant force. The oscillator is
            then treated as a structure.
        friction : float, str or pint.Quantity
            Dry friction between the free mass and its slot, divided by F0, or a force. The oscillator is then
            treated as a structure; functions that accept structures with friction accept it here too.
        stops : ((float, float) or None, (float, float) or None), optional
            Compliant walls: stiffness divided by K and damping divided by sqrt(K M), for the right wall and for
            the left one; if M and K are known, values with units are also accepted, such as ("40 kN/m",
            "3 N s/m"). None stands for a rigid wall with its coefficient of restitution. The oscillator is then
            treated as a structure.

        Returns
        -------
        Point
            The system with its structure and its load.

        Raises
        ------
        ParameterError, ParameterTypeError
            If an argument is not allowed.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> point = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75).at(0.94, 37.0)
        >>> point
        <Oscillator(xi=0.005, mu=0.042, restitution=(0.75, 0.75)) at r = 0.94, d K/F0 = 37>
        >>> motion = vi.equispaced(point.osc, point.r, point.clearance)[0]
        >>> vi.exact(point, motion).pattern == motion.pattern
        True

        A rig at 19.5 Hz, with 4 mm of clearance:

        >>> rig = vi.Oscillator.from_dimensional(
        ...     M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
        ... )
        >>> print(repr(rig.at("19.5 Hz", "4 mm")).partition(" at ")[2])
        19.5 Hz, d = 4 mm (r = 0.982362, d K/F0 = 28)>

        Friction in the slot:

        >>> rough = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(1.04, 25, friction=0.05)
        >>> vi.exact(rough, vi.simulate(rough, cycles=400))
        <Motion of 4 events in 1 cycle: admissible, stable (max|lambda| = 0.9227)>

        A left wall covered with compliant tape, and a rigid right wall:

        >>> taped = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
        >>> taped = taped.at(1.04, 25, stops=(None, (20.0, 0.2)))
        >>> taped.structure.gaps
        (Gap([-1.0, 1.0], 12.5, restitution=0.75), Stop([1.0, -1.0], 12.5, stiffness=20, damping=0.2))
        """
        if has_unit([clearance, load, friction]):
            refuse_hertz(self, r)
        ratio, gap, force = (
            dimensionless(self, name, value)
            for name, value in (("r", r), ("clearance", clearance), ("load", load))
        )
        rubs = dimensionless(self, "friction", friction)
        with shown_as_given([(r, ratio), (clearance, gap), (load, force), (friction, rubs)]):
            ratio = checks.frequency_ratio(ratio, self.xi)
            gap = positive(gap, "clearance")
            wanted = "a force over F0 from 0 to 1e100"
            rubs = checks.to_float(rubs, "friction", wanted)
            if not 0 <= rubs <= 1e100:
                raise ParameterError(f"friction = {rubs!r}: must be {wanted}")
            walls = None if stops is None else _compliant_walls(self, stops)
            if not isinstance(force, Load):
                return Point(self, ratio, gap, checks.number(force, "load"), rubs, walls)
        if force.constant.size != 2 or not math.isclose(force.frequency, ratio, rel_tol=1e-12):
            raise ParameterError(
                f"load = {force!r}: must have the frequency r = {ratio!r} and 2 coordinates"
            )
        return Point(self, ratio, gap, force, rubs, walls)

    @property
    def _has_law(self) -> bool:
        """Whether a coefficient of restitution depends on the speed."""
        right, left = self.restitution
        return not (isinstance(right, float) and isinstance(left, float))

    def _keys(self, r: float | None = None) -> dict[str, Any]:
        """The keys of a &system; None where they are not known."""
        of_numbers(self)
        return {
            "xi": self.xi, "mu": self.mu, "restitution": list(self.restitution), "r": r, "mass": self.M,
            "stiffness": self.K, "force": self.F0, "unit_names": self.unit_names,
        }  # fmt: skip

    @classmethod
    def _of_keys(cls, keys: Mapping[str, Any]) -> Oscillator:
        """The oscillator of the keys of a &system."""
        return cls(
            xi=keys["xi"], mu=keys["mu"], restitution=tuple(np.atleast_1d(keys["restitution"]).tolist()),
            M=keys.get("mass"), K=keys.get("stiffness"), F0=keys.get("force"), unit_names=keys.get("unit_names"),
        )  # fmt: skip


@dataclass(frozen=True, repr=False)
class Point:
    """An oscillator at a point: the same system as a structure with its load, and the scales of both.

    It is made by `Oscillator.at`. Functions that take an oscillator, r and clearance accept a point in place of
    these; its structure and load can be used wherever a structure and its load can.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : float
        Frequency ratio, and d K/F0.
    amplitude : float or Load
        Amplitude of the load divided by F0, or the whole load.
    friction : float
        Friction in the slot, divided by F0.
    stops : tuple, or None
        Stiffness divided by K and damping divided by sqrt(K M) of the right and the left wall; None for a rigid
        wall.
    """

    osc: Oscillator
    r: float
    clearance: float
    amplitude: float | Load = 1.0
    friction: float = 0.0
    stops: Stops | None = None

    @property
    def structure(self) -> Structure:
        """The two masses and their walls, with F0/K as the unit of length and 1/omega as the unit of time."""
        pair = self.osc.structure(self.clearance)
        if not self._has_elements:
            return pair
        gaps = [
            Stop(gap.direction, gap.opening, *wall) if wall else gap
            for gap, wall in zip(pair.gaps, self.stops or (None, None), strict=True)
        ]
        friction = [Friction([-1, 1], self.friction)] if self.friction else []
        found = Structure(pair.mass, pair.damping, pair.stiffness, gaps, friction)
        return found._with_units(pair._units)

    @property
    def _has_elements(self) -> bool:
        """Whether there is friction or compliant walls."""
        return self.friction > 0 or self.stops is not None

    @property
    def load(self) -> Load:
        """The load on the structure."""
        if isinstance(self.amplitude, Load):
            return self.amplitude
        return Load(self.r, sine=[self.amplitude, 0])

    @property
    def scales(self) -> dict[str, float]:
        """Length F0/K, time 1/omega, force F0 and mass M in the units of the oscillator's M, K and F0.

        Raises
        ------
        ParameterError
            If M, K and F0 are not known.
        """
        if self.osc.M is None or self.osc.K is None or self.osc.F0 is None:
            raise ParameterError(f"{self.osc!r}: must have M, K and F0, which determine the scales")
        return {
            "length": self.osc.F0 / self.osc.K, "time": math.sqrt(self.osc.M / self.osc.K),
            "force": self.osc.F0, "mass": self.osc.M,
        }  # fmt: skip

    def _repr_html_(self) -> str:
        """The representation in Jupyter."""
        facts = {"r": self.r, "d K/F0": self.clearance, "load over F0": self.amplitude}
        shown = {
            name: repr(value) if isinstance(value, Load) else f"{value:.10g}"
            for name, value in facts.items()
        }
        if self.osc.F0 is not None:
            values = {"r": self.r, "clearance": self.clearance, "load": self.amplitude}
            shown = {
                {"r": "f", "clearance": "d"}.get(name, name): value_text(self.osc, name, value)
                for name, value in values.items() if not isinstance(value, Load)
            } | shown  # fmt: skip
        return facts_html(repr(self.osc), shown)

    def _stops_text(self) -> str:
        """Stiffness and damping of the walls as a text, in the units of the oscillator if it has them."""
        units = units_to_show(self.osc)
        if units is None:
            return str(self.stops)
        shown = [
            "rigid" if wall is None
            else f"({wall[0] * units.K:.6g} {units.name('K')}, {wall[1] * units.K * units.time:.6g} "
            f"{units.name('K/omega')})"
            for wall in self.stops or ()
        ]  # fmt: skip
        return ", ".join(
            f"{side} {text}" for side, text in zip(("right", "left"), shown, strict=True)
        )

    def __repr__(self) -> str:
        load = ""
        if isinstance(self.amplitude, Load):
            load = f", {self.amplitude!r}"
        elif self.amplitude != 1:
            load = f", load {value_text(self.osc, 'load', self.amplitude)}"
        if self.friction:
            load += f", friction {value_text(self.osc, 'friction', self.friction)}"
        load += f", stops {self._stops_text()}" if self.stops else ""
        return f"<{self.osc!r} at {place_text(self.osc, self.r, self.clearance)}{load}>"


def _compliant_walls(osc: Oscillator, stops: Any) -> Stops | None:
    """Dimensionless stiffness and damping of both walls, checked; None for a rigid wall, or for both."""

    def wall(name: str, given: Any) -> Wall | None:
        if given is None:
            return None
        numbers = [
            number_of(value, f"{kind} of the {name} wall", unit, lambda: osc.units(osc.F0 or 1.0))
            for value, kind, unit in zip(
                given, ("stiffness", "damping"), ("K", "K/omega"), strict=True
            )
        ]
        with shown_as_given(zip(given, numbers, strict=True)):
            try:
                stop = Stop([-1, 1], 1, *numbers)
            except (ParameterError, ParameterTypeError) as error:
                error.args = (re.sub(r"^\w+", rf"\g<0> of the {name} wall", str(error)),)
                raise
        return stop.stiffness, stop.damping

    try:
        right, left = stops
        walls = wall("right", right), wall("left", left)
    except (TypeError, ValueError) as error:
        if isinstance(error, (ParameterError, ParameterTypeError)):
            raise
        raise ParameterError(
            f"stops = {stops!r}: must be (stiffness, damping) or None for the right wall, and for the left one, "
            "such as ((100.0, 0.1), None)"
        ) from None
    return None if walls == (None, None) else walls


@dataclass(frozen=True)
class Pattern:
    """The walls that are hit, in order, and the number of load cycles.

    Wherever a pattern is expected, a string such as "RRL" or "RL/2" (sides/cycles) is accepted as well.

    Parameters
    ----------
    sides : str
        One letter per impact, R for the right wall and L for the left; 2 to 1000 letters, each wall at least once
        (a motion with impacts on one wall only is never periodic). A star after a letter denotes impacts that
        accumulate on that wall and end in rest there.
    cycles : int, optional
        Load cycles k in one period of the motion, 1 to 10000.

    Raises
    ------
    ParameterError, ParameterTypeError
        If no such pattern can exist.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> vi.Pattern("RRL")
    Pattern(sides='RRL', cycles=1)
    >>> vi.Pattern("RL*").rests
    (False, True)
    """

    sides: str
    cycles: int = 1
    #: +1 for R, -1 for L (N)
    signs: NDArray[np.int32] = field(init=False, repr=False, compare=False)
    #: Whether impacts accumulate and end in rest (N)
    rests: tuple[bool, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        wanted = (
            "letters R and L (a star after one for accumulation and rest), each wall at least once"
        )
        if not isinstance(self.sides, str):
            raise ParameterTypeError(f"sides = {self.sides!r}: must be a string of {wanted}")
        sides = self.sides.upper()
        symbols = re.findall(r"[RL]\*?", sides)
        if not sides or "".join(symbols) != sides:
            raise ParameterError(f"sides = {self.sides!r}: must be {wanted}")
        if len({symbol[0] for symbol in symbols}) < 2:
            raise ParameterError(
                f"sides = {self.sides!r}: must name both walls; with N = 1 or impacts on one wall only "
                "no motion is periodic"
            )
        if len(symbols) > checks.MAX_IMPACTS:
            raise ParameterError(
                f"sides of {len(symbols)} letters: must be at most {checks.MAX_IMPACTS}"
            )
        object.__setattr__(self, "sides", sides)
        object.__setattr__(
            self, "cycles", checks.integer(self.cycles, "cycles", 1, checks.MAX_CYCLES)
        )
        signs = np.array([1 if symbol[0] == "R" else -1 for symbol in symbols], dtype=np.int32)
        signs.flags.writeable = False
        object.__setattr__(self, "signs", signs)
        object.__setattr__(self, "rests", tuple(len(symbol) == 2 for symbol in symbols))

    def __len__(self) -> int:
        """Number of impacts N; an accumulation counts as one."""
        return len(self.signs)

    @property
    def has_rest(self) -> bool:
        """Whether impacts accumulate anywhere and end in rest."""
        return any(self.rests)

    @property
    def symbols(self) -> list[str]:
        """The symbols one by one, each with its star."""
        return re.findall(r"[RL]\*?", self.sides)

    def standard(self, alike: bool = False) -> Pattern:
        """The same pattern, rotated to its standard first symbol, with R before L.

        Parameters
        ----------
        alike : bool
            Whether both walls have the same restitution, so that the mirror image counts as the same pattern.

        Returns
        -------
        Pattern
            The pattern that represents all its rotations.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> vi.Pattern("LRL").standard(), vi.Pattern("LRL").standard(alike=True)
        (Pattern(sides='RLL', cycles=1), Pattern(sides='RRL', cycles=1))
        """
        orders = [self.symbols]
        if checks.truth(alike, "alike"):
            orders.append([item.translate(str.maketrans("RL", "LR")) for item in self.symbols])
        turned = ("".join(one[j:] + one[:j]) for one in orders for j in range(len(one)))
        return Pattern(max(turned), self.cycles)


def of_numbers(osc: Any, name: str = "osc") -> None:
    """Checks that a value is an oscillator whose coefficients of restitution are numbers."""
    checks.instance(osc, name, Oscillator)
    if osc._has_law:
        raise ParameterError(
            f"restitution = {osc.restitution!r} of {name}: must be numbers here; simulate, exact, find, lyapunov, "
            "basins, response and bifurcation_diagram accept laws, and so do all functions of a Structure "
            "(Oscillator.structure)"
        )


def pattern_of(value: Any, name: str = "pattern") -> Pattern:
    """A pattern, which may be given as a text: SIDES, or SIDES/CYCLES.

    Examples
    --------
    >>> from vibroimpact.systems.oscillator import pattern_of
    >>> pattern_of("RL/2")
    Pattern(sides='RL', cycles=2)
    """
    if isinstance(value, Pattern):
        return value
    wanted = "a vibroimpact.Pattern or a text SIDES/CYCLES, such as 'RL' or 'RRL/2'"
    if not isinstance(value, str):
        raise ParameterTypeError(
            f"{name} = {value!r}: must be {wanted}, not {type(value).__name__}"
        )
    sides, slash, cycles = value.strip().partition("/")
    whole = cycles.isascii() and cycles.isdigit() and len(cycles) < 10
    shown = repr(value if len(value) <= MOST_SHOWN else value[:MOST_SHOWN] + "…")
    if slash and not whole:
        raise ParameterError(f"{name} = {shown}: must be {wanted}")
    try:
        return Pattern(sides, int(cycles) if slash else 1)
    except ParameterError as error:
        raise ParameterError(f"{name} = {shown}: must be {wanted}; {error}") from None


def plain_pattern(value: Any) -> Pattern:
    """A pattern without rest, as the linear equations require; it may be given as a text."""
    pattern = pattern_of(value)
    if pattern.has_rest:
        raise ParameterError(
            f"pattern = {pattern.sides!r}: must have no star here; motions with rest come from exact and find"
        )
    return pattern


def _walls(restitution: Any) -> tuple[Any, Any]:
    if isinstance(restitution, (tuple, list, np.ndarray)) and np.ndim(restitution) == 1:
        if len(restitution) != 2:
            raise ParameterError(
                f"restitution = {restitution!r}: must be one number or two (R1 right wall, R2 left wall)"
            )
        first, second = restitution
        return checked(first, "restitution[0]"), checked(second, "restitution[1]")
    value = checked(restitution)
    return value, value
