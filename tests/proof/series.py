"""Numbers of the program that checks certificates: exact texts, polynomials of parameters with balls as
coefficients, linear equations of them, and boxes of parameters that meet. It needs python-flint alone."""

import re
from fractions import Fraction
from itertools import accumulate, combinations_with_replacement
from math import comb, factorial
from operator import add

from flint import arb, fmpq

#: The degree of polynomials by the number of parameters.
DEGREES = (0, 5, 5, 3, 2, 2, 1, 1, 1)
#: Exact numbers as texts; numbers of higher powers would exhaust the memory.
HEXADECIMAL = re.compile(r"(-?0x[0-9a-f]+)p(-?[0-9]{1,5})")
DECIMAL = re.compile(r"-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]{1,4})?|-?[0-9]+/[0-9]+")
UNIT = arb(0, 1)


class RejectedError(Exception):
    """Raised if a statement of a certificate is not proven here."""


def need(holds, what):
    """Raise RejectedError if a statement does not hold or is not certain."""
    if not holds:
        raise RejectedError(what)


def exact(text):
    """The exact number in a text."""
    need(isinstance(text, str), f"{text!r} is no text of a number")
    found = HEXADECIMAL.fullmatch(text)
    need(found or DECIMAL.fullmatch(text), f"{text!r} is no exact number")
    return int(found[1], 16) * Fraction(2) ** int(found[2]) if found else Fraction(text)


def number(text):
    """That number as a ball."""
    value = text if isinstance(text, Fraction) else exact(text)
    return arb(fmpq(value.numerator, value.denominator))


def monomials(names, degree):
    """Exponents of all monomials up to a degree, in order of their degrees."""
    places = range(names)
    chosen = (one for k in range(degree + 1) for one in combinations_with_replacement(places, k))
    return [tuple(one.count(place) for place in places) for one in chosen]


class Kept(dict):
    """Values of a function, each computed once."""

    def __init__(self, function):
        self.function = function

    def __missing__(self, argument):
        self[argument] = found = self.function(argument)
        return found


#: Exponents of products of two monomials, and the values of a monomial.
SUMS = Kept(lambda powers: tuple(map(add, *powers)))
SPANS = Kept(
    lambda power: UNIT if any(k % 2 for k in power) else (UNIT + 1) / 2 if any(power) else arb(1)
)


class Series:
    """A polynomial of parameters in [-1, 1], what its degree leaves out in the constant, and its derivatives by
    unknowns, polynomials too: the keys are the exponents and the unknown from 1 on, 0 of the number itself."""

    def __init__(self, terms):
        self.terms, self.parts = terms, None
        names = len(next(iter(terms))[0])
        self.zero, self.degree = ((0,) * names, 0), DEGREES[names]

    def like(self, other):
        return other if isinstance(other, Series) else Series({self.zero: arb(other)})

    def part(self, unknown):
        terms = {(power, 0): one for (power, u), one in self.terms.items() if u == unknown}
        return Series(terms or {self.zero: arb(0)})

    def range(self):
        terms = [(power, one) for (power, u), one in self.terms.items() if not u]
        return sum((one * SPANS[power] for power, one in terms), arb(0))

    def __add__(self, other):
        terms = dict(self.terms)
        for key, one in self.like(other).terms.items():
            terms[key] = terms[key] + one if key in terms else one
        return Series(terms)

    def split(self):
        """The terms of the number and of each derivative, with the sums of the moduli of each degree, and of those
        from each degree on."""
        if self.parts is None:
            self.parts = {}
            for (power, u), one in self.terms.items():
                terms, sizes = self.parts.setdefault(u, ([], [arb(0)] * (self.degree + 1)))
                terms.append((power, sum(power), one))
                sizes[sum(power)] += abs(one)
            for u, (terms, sizes) in self.parts.items():
                self.parts[u] = terms, sizes, [*accumulate(sizes[::-1])][::-1]
        return self.parts

    def __mul__(self, other):
        if not isinstance(other, Series):
            return Series({key: one * other for key, one in self.terms.items()})
        found, degree = {self.zero: arb(0)}, self.degree
        for u, (first, sizes, _) in self.split().items():
            for v, (second, _, rest) in other.split().items():
                if u and v:
                    continue
                for power, k, one in first:
                    for more, m, two in second:
                        if k + m <= degree:
                            key = (SUMS[power, more], u or v)
                            found[key] = found[key] + one * two if key in found else one * two
                # the terms of higher degree
                left = (sizes[k] * rest[degree + 1 - k] for k in range(1, degree + 1))
                key = (self.zero[0], u or v)
                found[key] = found.get(key, arb(0)) + UNIT * sum(left, arb(0))
        return Series(found)

    __radd__, __rmul__ = __add__, __mul__

    def __sub__(self, other):
        return self + other * -1

    def __rsub__(self, other):
        return self * -1 + other

    def __truediv__(self, other):
        return self * (1 / other)

    def __rtruediv__(self, other):
        need(abs(self.range()) > 0, "a denominator may be zero")
        # a high power of a wide ball may contain zero; a power of its inverse does not divide by it
        orders = range(self.degree + 2)
        found = lambda x: [(-1) ** k * factorial(k) * (1 / x) ** (k + 1) for k in orders]  # noqa: E731
        return self.function(found) * other

    def function(self, slopes):
        """A function whose derivatives at x are slopes(x), by Taylor's theorem, and its derivative."""
        middle = self.terms.get(self.zero, arb(0)).mid()
        values, last = slopes(middle)[: self.degree + 1], slopes(self.range())[self.degree + 1]
        rest, found = self + -middle, self.like(0)
        for k, value in list(enumerate(values))[::-1]:
            found = found * rest + value / factorial(k)
        tail = last / factorial(self.degree)
        for _ in range(self.degree):
            tail = tail * rest.range()
        for u in {u for _, u in self.terms}:
            left = self.part(u) * tail if u else rest.range() * tail / (self.degree + 1)
            left = left.range() if u else left
            key = (self.zero[0], u)
            found.terms[key] = found.terms.get(key, arb(0)) + left
        return found

    def sin(self):
        return self.function(lambda x: [x.sin(), x.cos(), -x.sin(), -x.cos()] * 2)

    def cos(self):
        return self.function(lambda x: [x.cos(), -x.sin(), -x.cos(), x.sin()] * 2)

    def exp(self):
        return self.function(lambda x: [x.exp()] * (self.degree + 2))

    def sqrt(self):
        factors = list(
            accumulate(range(self.degree + 1), lambda f, k: f * (1 - 2 * k) / 2, initial=1.0)
        )
        return self.function(lambda x: [f * x.sqrt() * (1 / x) ** k for k, f in enumerate(factors)])


def ball(value):
    """All values."""
    return value.range() if isinstance(value, Series) else arb(value)


def flat(rows):
    """All entries of some rows."""
    return [one for row in rows for one in row]


def solve(matrix, right):
    """The solution of linear equations, by elimination."""
    rows = [[*a, *b] for a, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        # the largest of those that vary little
        sizes = [abs(ball(row[k])) for row in rows]
        keys = [(bool(one.lower() * 1.5 > one.upper()), float(one.lower())) for one in sizes]
        best = max(range(k, n), key=keys.__getitem__)
        rows[k], rows[best] = rows[best], rows[k]
        need(abs(ball(rows[k][k])) > 0, "a derivative may be singular")
        inverse = 1 / rows[k][k]
        rows[k] = [one * inverse for one in rows[k]]
        for i in range(n):
            if i != k:
                factor = rows[i][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def product(first, second):
    """The product of two matrices."""
    columns = list(zip(*second, strict=True))
    return [
        [sum((a * b for a, b in zip(row, column, strict=True)), arb(0)) for column in columns]
        for row in first
    ]


def determinant(rows):
    """The determinant of a small matrix, by its first row."""
    if len(rows) == 1:
        return rows[0][0]
    rest = [[row[:k] + row[k + 1 :] for row in rows[1:]] for k in range(len(rows))]
    signed = (one * (-1) ** k for k, one in enumerate(rows[0]))
    return sum((one * determinant(part) for one, part in zip(signed, rest, strict=True)), arb(0))


def cover(region, boxes):
    """Check that boxes, intervals by name, fill a region without a gap."""
    need(boxes, "a part of a region has no box")
    if len(boxes) == 1:
        need(boxes[0] == region, "a box is not where it should be")
        return
    for name, (low, high) in region.items():
        middles = sorted({box[name][0] for box in boxes})
        for cut in ((low + high) / 2, middles[len(middles) // 2], *middles):
            parts = (
                [box for box in boxes if box[name][1] <= cut],
                [box for box in boxes if box[name][0] >= cut],
            )
            if low < cut < high and len(parts[0]) + len(parts[1]) == len(boxes):
                cover(region | {name: [low, cut]}, parts[0])
                cover(region | {name: [cut, high]}, parts[1])
                return
    raise RejectedError("the boxes do not fill a region")


def check_link(before, box):
    """Check that the motion at the end of one interval is the one at the beginning of the next."""
    rows = zip(flat(before), flat(box["centre"]), flat(box["radius"]), strict=True)
    for state, texts, radius in rows:
        end = sum(state.terms.values(), arb(0))
        middle = sum((number(text) * (-1) ** k for k, text in enumerate(texts)), arb(0))
        need(abs(end - middle) < number(radius), "neighbours may hold different motions")


def halves(box, name):
    """Both halves of a box along a parameter, with the polynomials of its centre on them."""
    names = list(box["parameters"])
    place, (low, high) = names.index(name), map(exact, box["parameters"][name])
    middle = (low + high) / 2
    for ends, sign in (((low, middle), -1), ((middle, high), 1)):

        def on_half(texts, sign=sign):
            counts = (len(monomials(len(names), k)) for k in range(9))
            degree = next((k for k, count in enumerate(counts) if count >= len(texts)), None)
            need(degree is not None, "the coefficients of a polynomial")
            found = dict.fromkeys(monomials(len(names), degree), Fraction(0))
            for power, text in zip([*found], texts, strict=True):
                value, e = text if isinstance(text, Fraction) else exact(text), power[place]
                for m in range(e + 1):
                    lower = (*power[:place], m, *power[place + 1 :])
                    found[lower] += value * comb(e, m) * Fraction(sign) ** (e - m) / 2**e
            return [*found.values()]

        yield box | {
            "parameters": box["parameters"] | {name: [str(end) for end in ends]},
            "centre": [[on_half(texts) for texts in row] for row in box["centre"]],
        }


def hurwitz(polynomial):
    """The conditions of Routh and Hurwitz: positive where all zeros of a polynomial lie inside the unit circle."""
    one, a, b, c, d = polynomial
    first = [one + a + b + c + d, 4 * one + 2 * a - 2 * c - 4 * d, 6 * one - 2 * b + 6 * d]
    first += [4 * one - 2 * a + 2 * c - 4 * d, one - a + b - c + d]
    p, q, r, s, t = first
    return [ball(value) for value in (*first, q * r * s - t * q * q - s * s * p)]
