"""Taylor models: polynomials in parameters on [-1, 1] whose coefficients are balls.

The remainder of the truncated polynomial is included in the ball of its constant coefficient.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import combinations_with_replacement, pairwise
from math import factorial
from typing import Any

from .balls import flint

Number = Any


class Space:
    """The monomials of some parameters up to a degree, sorted by degree, and the table of their products."""

    def __init__(self, parameters: int, degree: int) -> None:
        self.parameters, self.degree = parameters, degree
        self.monomials = [
            tuple(chosen.count(place) for place in range(parameters))
            for total in range(degree + 1)
            for chosen in combinations_with_replacement(range(parameters), total)
        ]
        self.degrees = [sum(one) for one in self.monomials]
        self.even = [all(power % 2 == 0 for power in one) for one in self.monomials]
        places = {one: k for k, one in enumerate(self.monomials)}
        self.pairs: list[list[tuple[int, int]]] = [[] for _ in self.monomials]
        for i, one in enumerate(self.monomials):
            for j, two in enumerate(self.monomials):
                k = places.get(tuple(a + b for a, b in zip(one, two, strict=True)))
                if k is not None:
                    self.pairs[k].append((i, j))
        self.begins = [self.degrees.index(k) for k in range(degree + 1)] + [len(self.monomials)]

    def constant(self, value: Any) -> Model:
        """A number that does not depend on the parameters."""
        return Model(self, [value] + [flint().arb(0)] * (len(self.monomials) - 1))

    def parameter(self, place: int, middle: Any, half: Any) -> Model:
        """The number middle + half s."""
        found = self.constant(middle)
        found.c[1 + place] = half
        return found


@cache
def space(parameters: int, degree: int) -> Space:
    """The monomials, kept."""
    return Space(parameters, degree)


class Model:
    """A function of the parameters, enclosed by a polynomial with balls as coefficients."""

    __slots__ = ("_sizes", "c", "space")

    def __init__(self, of: Space, coefficients: list[Any]) -> None:
        self.space, self.c = of, coefficients
        self._sizes: list[Any] | None = None

    def sizes(self) -> list[Any]:
        """Sums of the moduli of the coefficients of each degree from 1 on."""
        if self._sizes is None:
            moduli = [abs(one) for one in self.c]
            begins = self.space.begins
            self._sizes = [sum(moduli[i + 1 : j], moduli[i]) for i, j in pairwise(begins[1:])]
        return self._sizes

    def range(self) -> Any:
        """A ball that holds all values."""
        arb = flint().arb
        found, size = self.c[0], arb(0)
        for one, even in zip(self.c[1:], self.space.even[1:], strict=True):
            if even:
                # an even power lies in [0, 1]
                half = one / 2
                found, one = found + half, half
            size += abs(one)
        return found + arb(0, size.upper())

    def at(self, places: Sequence[Any]) -> Any:
        """The function with its parameters replaced by as many other models."""
        found: Any = self.c[0]
        powers: dict[tuple[int, ...], Any] = {}
        for power, one in zip(self.space.monomials[1:], self.c[1:], strict=True):
            place = next(k for k, count in enumerate(power) if count)
            rest = tuple(count - (k == place) for k, count in enumerate(power))
            powers[power] = powers[rest] * places[place] if any(rest) else places[place]
            found = found + powers[power] * one
        return found

    def widened(self, radius: Any) -> Model:
        """A model of all functions within a distance of this one."""
        return Model(self.space, [self.c[0] + flint().arb(0, radius), *self.c[1:]])

    def __add__(self, other: Number) -> Model:
        if isinstance(other, Model):
            return Model(self.space, [a + b for a, b in zip(self.c, other.c, strict=True)])
        return Model(self.space, [self.c[0] + other, *self.c[1:]])

    __radd__ = __add__

    def __neg__(self) -> Model:
        return Model(self.space, [-one for one in self.c])

    def __sub__(self, other: Number) -> Model:
        if isinstance(other, Model):
            return Model(self.space, [a - b for a, b in zip(self.c, other.c, strict=True)])
        return Model(self.space, [self.c[0] - other, *self.c[1:]])

    def __rsub__(self, other: Number) -> Model:
        return Model(self.space, [other - self.c[0], *(-one for one in self.c[1:])])

    def __mul__(self, other: Number) -> Model:
        if not isinstance(other, Model):
            return Model(self.space, [one * other for one in self.c])
        a, b, found = self.c, other.c, []
        for pairs in self.space.pairs:
            i, j = pairs[0]
            value = a[i] * b[j]
            for i, j in pairs[1:]:
                value += a[i] * b[j]
            found.append(value)
        left = self._left_out(other)
        if left is not None:
            found[0] += flint().arb(0, left.upper())
        return Model(self.space, found)

    __rmul__ = __mul__

    def _left_out(self, other: Model) -> Any:
        """A bound of the products whose degree is too high."""
        degree = self.space.degree
        mine, others = self.sizes(), other.sizes()
        total = tail = None
        for k in range(degree):
            high = others[degree - 1 - k]
            tail = high if tail is None else tail + high
            part = mine[k] * tail
            total = part if total is None else total + part
        return total

    def _composed(self, values: Sequence[Any], rest: Any) -> Model:
        """The sum of values[k] n^k, with n the difference from the middle, and of rest n^(degree + 1)."""
        middle = self.c[0].mid()
        n = Model(self.space, [self.c[0] - middle, *self.c[1:]])
        found = n * values[-1]
        for value in values[-2:0:-1]:
            found = (found + value) * n
        found.c[0] += values[0]
        size, bound = abs(n.range()), abs(rest)
        for _ in range(self.space.degree + 1):
            bound *= size
        found.c[0] += flint().arb(0, bound.upper())
        return Model(self.space, found.c)

    def sin_cos(self) -> tuple[Model, Model]:
        degree = self.space.degree
        s, c = self.c[0].mid().sin_cos()
        turns = [(s, c), (c, -s), (-s, -c), (-c, s)]
        waves = [[one / factorial(k) for one in turns[k % 4]] for k in range(degree + 1)]
        rest = flint().arb(1) / factorial(degree + 1)
        first, second = (self._composed([wave[i] for wave in waves], rest) for i in (0, 1))
        return first, second

    def exp(self) -> Model:
        degree = self.space.degree
        value = self.c[0].mid().exp()
        rest = self.range().exp() / factorial(degree + 1)
        return self._composed([value / factorial(k) for k in range(degree + 1)], rest)

    def sqrt(self) -> Model:
        degree = self.space.degree

        def slopes(x: Any) -> list[Any]:
            values = [x.sqrt()]
            for k in range(1, degree + 2):
                values.append(values[-1] / x * (3 - 2 * k) / (2 * k))
            return values

        return self._composed(slopes(self.c[0].mid())[:-1], slopes(self.range())[-1])

    def inverse(self) -> Model:
        """1/x; a ball without bounds where x may be zero."""
        degree = self.space.degree
        whole = self.range()
        if not abs(whole) > 0:
            raise ZeroDivisionError

        def slopes(x: Any) -> list[Any]:
            values = [1 / x]
            for _ in range(degree + 1):
                values.append(-values[-1] / x)
            return values

        return self._composed(slopes(self.c[0].mid())[:-1], slopes(whole)[-1])

    def __truediv__(self, other: Number) -> Model:
        if isinstance(other, Model):
            return self * other.inverse()
        return Model(self.space, [one / other for one in self.c])

    def __rtruediv__(self, other: Number) -> Model:
        found: Model = self.inverse() * other
        return found


def span(value: Any) -> Any:
    """The ball of all values of a model; of a ball itself."""
    return value.range() if isinstance(value, Model) else value


def at_middle(value: Any) -> Any:
    """The ball of the value where all parameters are zero."""
    return value.c[0] if isinstance(value, Model) else value


def coefficients(value: Any, of: Space) -> list[Any]:
    """The coefficients of a model, a ball or an integer."""
    if isinstance(value, Model):
        return value.c
    arb = flint().arb
    return [arb(value)] + [arb(0)] * (len(of.monomials) - 1)
