"""Existence, admissibility and stability of a motion in balls, each proven, refuted or not decided."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from .balls import flint
from .equations import Flight, State, System, flights, jacobian, residuals
from .models import at_middle, span

#: The initial number of pieces of a flight, and the largest number of halvings of a piece.
PIECES, MOST_HALVINGS = 20, 24
#: The allowed excess of the proven bound of max|X| over the largest value found, and the halvings to reach it.
LOOSE, MOST_FOR_BOUND = 1.0001, 6


def approximate_inverse(matrix: Any) -> Any:
    """An approximate inverse of the midpoints, in doubles."""
    module = flint()
    values = np.array([[float(one.mid()) for one in row] for row in matrix.tolist()])
    return module.arb_mat(np.linalg.inv(values).tolist())


def krawczyk(
    system: System, centre: Sequence[State], radii: Sequence[Sequence[Any]]
) -> list[list[Any]] | None:
    """The states of the unique motion within `radii` of `centre`; None if nothing is proven.

    If K = c - C F(c) + (I - C F'(B)) (B - c) lies in the interior of B = c + radii, there is one and only one zero
    in B, and it lies in K.
    """
    module = flint()
    around = [
        [one + module.arb(0, radius) for one, radius in zip(state, row, strict=True)]
        for state, row in zip(centre, radii, strict=True)
    ]
    n = 4 * len(centre)
    middle = module.arb_mat([[one] for one in residuals(system, centre, flights(system, centre))])
    derivative = module.arb_mat(jacobian(system, flights(system, around)))
    try:
        inverse = approximate_inverse(derivative)
    except (np.linalg.LinAlgError, ValueError):
        return None
    identity = module.arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
    spread = [module.arb(0, radius) for row in radii for radius in row]
    moved = (identity - inverse * derivative) * module.arb_mat([[one] for one in spread])
    image = moved - inverse * middle
    shifts = [image[i, 0] for i in range(n)]
    # the radius of a ball is rounded up, whereas that of the statement is exact
    stated = [module.arb(radius) for row in radii for radius in row]
    if not all(abs(shift) < radius for shift, radius in zip(shifts, stated, strict=True)):
        return None
    return [[centre[i][k] + shifts[4 * i + k] for k in range(4)] for i in range(len(centre))]


def inside(coefficients: Sequence[Any], radius: Any = 1) -> bool | None:
    """Whether all zeros of a real polynomial c_0 + c_1 x + ... lie inside a circle; False if one lies outside.

    By the recursion of Schur and Cohn: p has all zeros inside the unit circle where |c_0| < |c_n| and the
    polynomial (c_n p(x) - c_0 x^n p(1/x))/x has all its zeros inside it, too.
    """
    power: Any = 1
    rest = []
    for one in coefficients:
        rest.append(one * power)
        power = power * radius
    while len(rest) > 1:
        n = len(rest) - 1
        first, last = rest[0], rest[n]
        if abs(first) < abs(last):
            rest = [last * rest[k + 1] - first * rest[n - 1 - k] for k in range(n)]
        elif abs(first) > abs(last):
            return False
        else:
            return None
    return True


def inside_all(coefficients: Sequence[Any]) -> bool | None:
    """Whether all zeros of a polynomial of even degree lie inside the unit circle for all of its parameters.

    False if one lies outside for each set of parameters. The number of zeros inside changes only where p(1), p(-1)
    or the product of 1 - x_i x_j over all pairs of zeros vanishes; where none of these vanishes, one set of
    parameters decides for all. If one of them is negative, not all zeros are inside. Above degree 4 this product
    has too many terms, and the recursion of `inside` is proven for all parameters instead.
    """
    if len(coefficients) > 5:
        return inside_recursively(coefficients)
    conditions = [span(value) for value in conditions_of(coefficients)]
    if all(value > 0 for value in conditions):
        return inside([at_middle(value) for value in coefficients])
    return False if any(value < 0 for value in conditions) else None


def inside_recursively(coefficients: Sequence[Any]) -> bool | None:
    """As `inside_all`, by the recursion of Schur and Cohn."""
    even, odd = (sum(coefficients[k + 2 :: 2], coefficients[k]) for k in (0, 1))
    if span(even + odd) < 0 or span(even - odd) < 0:
        return False
    rest = list(coefficients)
    while len(rest) > 1:
        n = len(rest) - 1
        first, last = rest[0], rest[n]
        # |first| < |last|, as last is 1 or the difference of squares before it
        bounds = [span(last - first), span(last + first)]
        if any(bound < 0 for bound in bounds):
            return False
        if not all(bound > 0 for bound in bounds):
            return None
        rest = [last * rest[k + 1] - first * rest[n - 1 - k] for k in range(n)]
    return True


def conditions_of(coefficients: Sequence[Any]) -> list[Any]:
    """p(1), p(-1) and the product of 1 - x_i x_j over all pairs of zeros of a polynomial of degree 2 or 4."""
    if len(coefficients) == 3:
        last, one, _ = coefficients
        return [1 + last + one, 1 + last - one, 1 - last]
    last, three, two, one, _ = coefficients
    even, odd = 1 + two + last, one + three
    pairs = (1 - two) * (1 - last) + three * (one - three)
    pairs = pairs - last * (one * (one - three) - (two - last) * (1 - last))
    return [even + odd, even - odd, pairs]


def multiplier_bound(coefficients: Sequence[Any], stable: bool, power: int = 1) -> Fraction | None:
    """A decimal bound of max|x|^power of the zeros: a strict upper bound if `stable`, otherwise a lower bound."""
    values = [float(one.mid()) if hasattr(one, "mid") else float(one) for one in coefficients]
    roots = np.roots(values[::-1])
    largest = Fraction(float(np.max(np.abs(roots))) ** power)
    module = flint()
    for digits in (13, 11, 9, 7, 5, 3):
        step = Fraction(1, 10**digits)
        bound = largest * (1 + step) if stable else largest * (1 - step)
        bound = Fraction(round(bound * 10**digits) + (1 if stable else -1), 10**digits)
        if bound > 1 if stable else bound < 1:
            continue
        radius = module.arb(module.fmpq(bound.numerator, bound.denominator)).root(power)
        if inside(coefficients, radius) is stable:
            return bound
    return None


class Path:
    """The relative position and X in a flight at exact times, with bounds of their third derivatives."""

    def __init__(self, system: System, flight: Flight) -> None:
        self.system, self.flight = system, flight
        self.offset = flight.start[1] + flight.before * system.half
        self.out = (flight.b + system.xi * flight.a) / system.eta
        x, v, _ = flight.forced
        self.x, self.v = x, v / system.r
        # bounds, as the square of a ball around zero is no number to take the root of
        a, out, x, v, r = (
            abs(span(one)).upper() for one in (flight.a, self.out, self.x, self.v, system.r)
        )
        self.third = (a * a + out * out).sqrt() + (x * x + v * v).sqrt() * r * r * r

    def at(self, t: Any) -> tuple[Any, Any, Any, Any, Any, Any]:
        """The distance of m from the nearer wall, Y', Y'', X, X', X''."""
        system = self.system
        decay = (-system.xi * t).exp()
        sine, cosine = (system.eta * t).sin_cos()
        free = decay * (self.flight.a * cosine + self.out * sine)
        turned = decay * (self.out * cosine - self.flight.a * sine) * system.eta
        speed = turned - system.xi * free
        # x'' = -2 xi x' - x of the free part
        bent = -2 * system.xi * speed - free
        s, c = (system.r * t).sin_cos()
        steady = self.x * c + self.v * s
        moving = (self.v * c - self.x * s) * system.r
        X, X_dot = free + steady, speed + moving
        X_bent = span(bent - system.square * steady)
        y = self.offset + self.flight.start[3] * t - X
        near = span(system.half - y).min(span(system.half + y))
        return near, span(self.flight.start[3] - X_dot), -X_bent, span(X), span(X_dot), X_bent


def between_walls(system: System, found: Sequence[Flight]) -> tuple[bool | None, Any, str]:
    """Whether each impact has an approach speed and each gap stays open in all flights; a bound of |X|; the reason
    where neither is proven."""
    largest = None
    for i, flight in enumerate(found):
        side = flight.after
        closing = span(side * (flight.start[3] - flight.v))
        if closing < 0:
            return False, None, ""
        leaving = span(flight.before * (flight.start[3] - flight.start[2]))
        if not closing > 0 or not leaving < 0:
            return None, None, f"the speeds at the ends of flight {i} are not separated from zero"
    for i, flight in enumerate(found):
        clear, bound = flight_between_walls(system, flight)
        if clear is not True:
            reason = "" if clear is False else f"flight {i} comes too close to a wall"
            return clear, None, reason
        largest = bound if largest is None else largest.max(bound)
    return True, largest, ""


def above(value: float) -> float:
    """A double that is an upper bound of the number that a twice rounded double represents."""
    return math.nextafter(math.nextafter(value, math.inf), math.inf)


def flight_between_walls(system: System, flight: Flight) -> tuple[bool | None, Any]:
    """As `between_walls`, for one flight.

    The flight is divided into pieces; within h of a midpoint, the error of the Taylor polynomial of degree 2 is at
    most third h^3/6. A piece is good if |Y| < d/2 on it, or if Y' has one sign on it and Y is within the walls at
    both ends. The first and the last piece end at a wall.
    """
    module = flint()
    path, duration = Path(system, flight), span(flight.tau)
    # doubles are exact, so pieces that share their ends cover all of the flight
    whole = above(float(duration.upper()))
    shortest = -above(-float(duration.lower()))
    if not 0 < shortest:
        return None, None
    ends = [whole * k / PIECES for k in range(PIECES)] + [whole]
    pieces = [(*pair, 0) for pair in pairwise(ends)][::-1]
    greatest, bound = module.arb(0), module.arb(0)
    previous: int | None = 0  # the sign of Y' on the piece before; None where |Y| < d/2 on it
    while pieces:
        low, high, depth = pieces.pop()
        middle = (low + high) / 2
        t, h = module.arb(middle), module.arb(above(max(high - middle, middle - low)))
        near, y_dot, y_bent, x, x_dot, x_bent = path.at(t)
        tail = path.third * h * h * h / 6
        if middle < shortest and near < 0:
            return False, None
        sign: int | None = None
        turn = abs(y_bent) * h + path.third * h * h / 2
        if abs(y_dot) > turn:
            sign = 1 if y_dot > 0 else -1
        good = abs(y_dot) * h + abs(y_bent) * h * h / 2 + tail < near
        if good:
            sign = None
        elif sign is not None:
            good = previous in (None, 0, sign)
            if not good:
                good = bool(path.at(module.arb(low))[0] > 0)
        if high > shortest and sign != flight.after:
            good = False
        size = abs(x) + abs(x_dot) * h + abs(x_bent) * h * h / 2 + tail
        if x_bent * x < 0:
            # on the side of x the parabola does not rise above its vertex
            vertex = abs(x) + x_dot * x_dot / (2 * abs(x_bent)) + tail
            vertex = vertex.max(size - 2 * abs(x))
            size = vertex if vertex < size else size
        if abs(x) > greatest:
            greatest = abs(x)
        wide = size > greatest * LOOSE and size > bound and depth < MOST_FOR_BOUND
        if not good or wide:
            if depth == MOST_HALVINGS:
                return None, None
            pieces += [(middle, high, depth + 1), (low, middle, depth + 1)]
            continue
        previous = sign
        bound = size if size > bound else bound.max(size)
    return True, bound
