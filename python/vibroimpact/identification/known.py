"""The known values of a rig, and the parameters to be fitted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..systems.units import OTHERS, POWERS, has_unit, own_number, plain_number, positive
from .laws import KNOWN_OF_LAW

#: The values that may be known, and their units.
KNOWN = {
    "M": "kg", "K": "N/m", "C": "N s/m", "m": "kg", "d": "m", "F0": "N", "omega": "rad/s", "xi": "", "mu": "",
    "R1": "", "R2": "", **{name: "" if name[0] == "e" else "m/s" for name in KNOWN_OF_LAW},
}  # fmt: skip
#: Possible causes if no fit succeeds.
HINT = (
    "known values, the bandwidth of the sensors, or units, signs or times of the channels may be wrong, or "
    "the motion is not quite periodic"
)
#: Factors by which a wrong unit changes a record, for messages.
FACTORS = {
    9.80665: "g for m/s^2",
    1000.0: "a milli- or kilo-unit",
    4.448: "lbf for N",
    25.4: "inches for mm",
    39.37: "inches for m",
}
#: The shared parameters of records that may be known, in this order.
SHARED = ("omega", "xi", "mu", "R1", "R2", *KNOWN_OF_LAW, "d")


#: A known value as the caller gives it: a number or a text with its unit, or this with its standard error.
Known: TypeAlias = float | str | tuple[float | str, float | str]
#: Step of the differences of derived known values, in standard errors.
STEP = 1e-3
#: Range of known values that have a dimension, as of the keys of a namelist.
SMALLEST, LARGEST = 1e-12, 1e12


def unit_hint(ratio: float) -> str:
    """The end of a message about values that should be equal: the unit that their ratio suggests."""
    near = [
        text for factor, text in FACTORS.items() if abs(abs(math.log(ratio)) - math.log(factor)) < 0.3
    ]  # fmt: skip
    return f"; is it {near[0]}?" if near else ""


class Doubted(NamedTuple):
    """A known value with a standard error.

    Attributes
    ----------
    name : str
    value, error : float
        In SI units.
    scale, shared : dict of str to float
        The derivatives of the values that `known_values` returns with respect to this value.
    """

    name: str
    value: float
    error: float
    scale: dict[str, float]
    shared: dict[str, float]


def with_errors(known: Mapping[str, Any]) -> tuple[Mapping[str, Any], list[Doubted]]:
    """The known values alone, and those that have a standard error, given as (value, error)."""
    if not isinstance(known, Mapping) or not any(
        isinstance(value, (tuple, list)) for value in known.values()
    ):
        return known, []
    values, errors = dict(known), dict[str, float]()
    for name, value in known.items():
        if not isinstance(value, (tuple, list)):
            continue
        if len(value) != 2:
            raise ParameterError(
                f"known {name} = {value!r}: must be a value, or a value and its standard error"
            )
        values[name], error = value
        checks.choice(name, "known: name", tuple(KNOWN))
        label, share, given = f"error of known {name}", 1.0, error
        if KNOWN[name] and isinstance(error, str) and error.rstrip().endswith("%"):
            # of a quantity with a dimension only a share can be meant
            share = own_number(values[name], name, label=f"known {name}")
            error = plain_number(error, label, (0, 0, 0), "m N s")
        elif has_unit(error):
            error = own_number(error, "xi" if not KNOWN[name] else name, label=label)
        errors[name] = positive(error, label, zero=True, given=given) * positive(
            share, f"known {name}", zero=True
        )
    if {"M", "K", "omega"} <= known.keys() and {"M", "K", "omega"} & errors.keys():
        raise ParameterError(
            "known mass M, stiffness K, natural frequency omega: must be only two of the three if one has a "
            "standard error"
        )
    scale, shared = known_values(values)
    numbers = scale | shared | {
        name: own_number(value, name) for name, value in values.items() if name in ("m", "C")
    }  # fmt: skip
    found = []
    for name, error in errors.items():
        if not error > 0:
            continue
        if not error < numbers[name] and not name.startswith("exponent"):
            # two further fits use the value one error higher and lower
            value = float(numbers[name])
            wanted = (
                f"must be smaller than the value, {value:g}"
                if value
                else "must be left out, since the value is 0"
            )
            raise ParameterError(f"error of known {name} = {known[name][1]!r}: {wanted}")
        step = STEP * error
        above, below = (
            known_values(values | {name: float(numbers[name]) + sign * step}) for sign in (1, -1)
        )
        slopes = [
            {key: (up[key] - down[key]) / (2 * step) for key in up}
            for up, down in zip(above, below, strict=True)
        ]
        found.append(Doubted(name, float(numbers[name]), error, *slopes))
    return values, found


def known_values(known: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    """The known values: M, K, F0, and the parameters of a fit."""
    if not isinstance(known, Mapping):
        raise ParameterTypeError(
            f"known = {known!r}: must be a mapping such as dict(M=2.7, K=42e3)"
        )
    values: dict[str, float] = {}
    for name, value in known.items():
        if name in ("f", "friction"):
            raise ParameterError(
                f"known {name} = {value!r}: must be left out; give it as friction = {value!r}"
            )
        checks.choice(name, "known: name", tuple(KNOWN))
        given = value
        if name == "omega" or name in POWERS or name in OTHERS:
            value = own_number(value, name, label=f"known {name}")
        if name in ("xi", "mu", "R1", "R2"):
            values[name] = checks.number(
                value, "restitution" if name[0] == "R" else name, f"known {name}"
            )
        elif name.startswith("exponent"):
            values[name] = checks.to_float(value, f"known {name}", "a finite number")
            if not math.isfinite(values[name]):
                raise ParameterError(f"known {name} = {value!r}: must be a finite number")
        else:
            values[name] = positive(value, f"known {name}", zero=name == "C", given=given)
            if values[name] and not SMALLEST <= values[name] <= LARGEST:
                raise ParameterError(
                    f"known {name} = {given!r}: must be from {SMALLEST:g} to {LARGEST:g} {KNOWN[name]}"
                )
    if values.get("mu") == 0:
        raise ParameterError(
            "known mu = 0.0: must be > 0, otherwise impacts do not affect the motion of M"
        )
    if {"M", "K", "omega"} <= values.keys():
        if abs(values["K"] / values["M"] / values["omega"] ** 2 - 1) > 1e-6:
            raise ParameterError(
                "known mass M, stiffness K, natural frequency omega: must satisfy omega^2 = K/M; give only two of "
                "the three"
            )
    elif {"M", "K"} <= values.keys():
        values["omega"] = math.sqrt(values["K"] / values["M"])
    elif {"M", "omega"} <= values.keys():
        values["K"] = values["M"] * values["omega"] ** 2
    elif {"K", "omega"} <= values.keys():
        values["M"] = values["K"] / values["omega"] ** 2
    for name, needs, ratio in (("m", "mass M", "mu"), ("C", "mass M and stiffness K", "xi")):
        if name not in values:
            continue
        if not ({"M"} if name == "m" else {"M", "K"}) <= values.keys():
            raise ParameterError(f"known {name} = {values[name]!r}: must be given with the {needs}")
        if ratio in values:
            raise ParameterError(
                f"known {name} and {ratio}: must not both be given, since one determines the other"
            )
        values[ratio] = (
            values["m"] / values["M"]
            if name == "m"
            else values["C"] / (2 * math.sqrt(values["K"] * values["M"]))
        )
        if ratio == "xi" and not values["xi"] < 1:
            raise ParameterError(f"known C = {values['C']!r}: must be below critical damping")
    scale: dict[str, float] = {name: values[name] for name in ("M", "K", "F0") if name in values}
    return scale, {name: values[name] for name in SHARED if name in values}
