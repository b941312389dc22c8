"""Numbers for proofs: balls of python-flint (a midpoint with an error bound), and exact numbers as text."""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from typing import Any

from ..base.errors import MissingExtraError, ParameterError

#: An exact dyadic number: a hexadecimal integer times a power of two.
HEX = re.compile(r"(-?)0x([0-9a-f]+)p(-?\d+)")


def flint() -> Any:
    """The module of python-flint, or an error that says how to install it."""
    try:
        import flint as module
    except ImportError:
        raise MissingExtraError(
            "proofs need python-flint: pip install 'vibroimpact[proof]'"
        ) from None
    return module


def decimal(value: float) -> str:
    """The shortest decimal text that converts to a double; proofs use this decimal number."""
    return repr(float(value))


def exact(text: str) -> Fraction:
    """The rational number of a decimal text, a fraction or a hexadecimal text."""
    found = HEX.fullmatch(text)
    if found is None:
        return Fraction(text)
    sign, digits, power = found.groups()
    number = int(digits, 16) * Fraction(2) ** int(power)
    return -number if sign else number


def ball(value: Fraction | str) -> Any:
    """The smallest ball of the working precision around a rational number."""
    module = flint()
    value = exact(value) if isinstance(value, str) else value
    return module.arb(module.fmpq(value.numerator, value.denominator))


def hexadecimal(number: Any) -> str:
    """The exact midpoint of a ball."""
    mantissa, power = (int(part) for part in number.mid().man_exp())
    return f"{'-' if mantissa < 0 else ''}{hex(abs(mantissa))}p{power}"


def rational(number: Any) -> Fraction:
    """The exact midpoint of a ball."""
    mantissa, power = (int(part) for part in number.mid().man_exp())
    return mantissa * Fraction(2) ** power


def upward(value: Any, digits: int = 6) -> Fraction:
    """A decimal number of few digits that is an upper bound of a ball."""
    bound = rational(value.upper())
    if bound <= 0:
        raise ParameterError(f"value = {value}: must be above 0")
    power = 0
    while bound * Fraction(10) ** power < 10 ** (digits - 1):
        power += 1
    while bound * Fraction(10) ** power >= 10**digits:
        power -= 1
    return -((-bound * Fraction(10) ** power) // 1) / Fraction(10) ** power


def decimal_text(value: Fraction) -> str:
    """A rational number whose denominator divides a power of ten, as a decimal."""
    digits = 0
    while (value * 10**digits).denominator != 1:
        digits += 1
    return f"{Decimal((value * 10**digits).numerator).scaleb(-digits):f}"
