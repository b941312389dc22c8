"""All motions of a word at a point, from the times between their impacts.

Given these times, everything is linear: the primary mass moves as the sum of the steady motion A sin(r t + theta)
and the periodic responses to the impulses J of the impacts, the free mass moves with the velocity W in each
flight, and J = mu (W before - W after). With p = sin(theta), q = cos(theta), the flights and the impact law of N
impacts are 2 N linear equations for W_1 ... W_N, p and q, and p^2 + q^2 = 1 is one more equation. Therefore N - 1
times, as fractions u of the period, have to be searched, and the interval [0, 1] of each contains all motions.
Lengths are in units of A.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .balls import flint

#: Terms of the series of (exp(z) - 1)/z, and |z| up to which it is used.
TERMS, SMALL = 24, 1.5


@dataclass(frozen=True)
class Equations:
    """The matrix M of the linear equations M (W, p, q) = right, and its derivatives with respect to each u."""

    matrix: Any
    right: Any
    slopes: list[Any]


def divided(rate: Any, time: Any) -> tuple[Any, Any]:
    """(exp(rate t) - 1)/t and its derivative with respect to t, also at t = 0."""
    module = flint()
    z = rate * time
    if not abs(z) < SMALL:
        grown = z.exp()
        value = (grown - 1) / time
        return value, (rate * grown - value) / time
    # sum of z^n/(n+1)!, and of (n+1) z^n/(n+2)!, by Horner's scheme; the tail is a geometric series
    value, slope = module.acb(0), module.acb(0)
    factor = module.arb(1)
    factors = []
    for n in range(TERMS + 2):
        factor = factor / (n + 1)
        factors.append(factor)
    for n in range(TERMS - 1, -1, -1):
        value = value * z + factors[n]
        slope = slope * z + factors[n + 1] * (n + 1)
    size = abs(z) ** TERMS * factors[TERMS] * 4
    tail = module.acb(module.arb(0, size.upper()), module.arb(0, size.upper()))
    return rate * (value + tail), rate * rate * (slope + tail)


class Word:
    """The walls of N impacts in some load cycles, for an oscillator at a point.

    Parameters
    ----------
    signs : sequence of int
        +1 for the right wall, -1 for the left one.
    cycles : int
    xi, mu, r, clearance, load
        Balls.
    restitution : sequence
        For each impact.
    """

    def __init__(
        self, signs: Sequence[int], cycles: int, xi: Any, mu: Any, r: Any, clearance: Any, load: Any,
        restitution: Sequence[Any],
    ) -> None:  # fmt: skip
        module = flint()
        self.signs, self.n = signs, len(signs)
        self.mu, self.r, self.R = mu, r, restitution
        self.period = 2 * module.arb.pi() * cycles / r
        eta = (1 - xi * xi).sqrt()
        self.rate = module.acb(-xi, eta)
        self.whole = (self.rate * self.period).exp()
        #: of the response Im(g exp(rate t)) to an impulse, repeated in each period
        self.g = 1 / (eta * (1 - self.whole))
        self.turn = module.acb(0, r)
        distance, damping = 1 - r * r, 2 * xi * r
        self.amplitude = load / (distance * distance + damping * damping).sqrt()
        #: The phase by which the steady motion lags the load.
        self.lag = module.arb.atan2(damping, distance)
        self.d = clearance / self.amplitude
        self.shortest = self._shortest(xi, load, eta)

    def _shortest(self, xi: Any, load: Any, eta: Any) -> Any:
        """A lower bound of the duration of a flight from wall to wall, as a fraction of the period.

        The work of the load in a period exceeds the energy dissipated by damping by at most f^2 T/(16 xi), and
        each impact dissipates mu (1 - R^2) e^2/(2 (1 + mu)), where e is its approach speed. This bounds e, W
        (which has mean 0) and x'.
        """
        mu, module = self.mu, flint()
        largest = self.R[0]
        for one in self.R[1:]:
            largest = largest.max(one)
        least = 1 - largest * largest
        approach = (load * load * self.period * (1 + mu) / (8 * xi * mu * least)).sqrt()
        jump = 2 * approach / (1 + mu)
        free = jump * self.n / 2
        primary = self.amplitude * self.r + self.n * mu * jump / (eta * abs(1 - self.whole))
        found = self.d * self.amplitude / ((free + primary) * self.period)
        return module.arb(found.lower())

    def passed(self, i: int, j: int) -> tuple[list[int], bool]:
        """The flights from impact j to impact i, and whether the last flight of the period is among them."""
        places = [k % self.n for k in range(j, j + (i - j) % self.n)]
        return places, self.n - 1 in places

    def time(self, i: int, j: int, u: Sequence[Any]) -> tuple[Any, list[int]]:
        """The time from impact j to impact i as a part of the period, and its derivatives."""
        places, around = self.passed(i, j)
        inner = [int(k in places) - int(around) for k in range(self.n - 1)]
        value: Any = flint().arb(int(around))
        for part, slope in zip(u, inner, strict=True):
            if slope:
                value = value + part * slope
        return value, inner

    def equations(self, u: Sequence[Any]) -> Equations:
        """The linear equations for parts u of the period between impacts, thin or wide."""
        module = flint()
        n, mu, period, rate, g = self.n, self.mu, self.period, self.rate, self.g
        one_more = range(n)  # the value and the derivatives by u
        rows = [[[module.arb(0) for _ in range(n + 2)] for _ in range(2 * n)] for _ in one_more]
        right = [module.arb(0) for _ in range(2 * n)]
        # exp(rate t) from impact j to impact i, 1 from an impact to itself
        grown, steps = {}, {}
        for i in range(n):
            for j in range(n):
                part, steps[i, j] = self.time(i, j, u)
                grown[i, j] = module.acb(1) if i == j else (rate * (period * part)).exp()
        spun = [(self.turn * (period * self.time(i, 0, u)[0])).exp() for i in range(n)]

        def put(row: int, place: int, values: Sequence[Any]) -> None:
            for layer, value in zip(rows, values, strict=True):
                layer[row][place] = layer[row][place] + value

        def pushed(row: int, j: int, values: Sequence[Any]) -> None:
            """Coefficients of J_j = mu (W_{j-1} - W_j)."""
            put(row, (j - 1) % n, [mu * value for value in values])
            put(row, j, [-mu * value for value in values])

        for i in range(n):
            after, R = (i + 1) % n, self.R[i]
            # the impact law: W_i - x'_i+ + R (W_{i-1} - x'_i-) = 0
            put(i, i, [1] + [0] * (n - 1))
            put(i, (i - 1) % n, [R] + [0] * (n - 1))
            slope = steps[i, 0]
            forced = self.turn * spun[i] * (1 + R)
            bent = self.turn * forced * period
            put(i, n, [-forced.real, *(-bent.real * k for k in slope)])
            put(i, n + 1, [-forced.imag, *(-bent.imag * k for k in slope)])
            for j in range(n):
                speed = g * rate * grown[i, j]
                if j == i:
                    speed = speed + R * g * rate * self.whole
                    pushed(i, j, [-speed.imag] + [0] * (n - 1))
                    continue
                bend = speed * rate * period * (1 + R)
                pushed(i, j, [-speed.imag * (1 + R), *(-bend.imag * k for k in steps[i, j])])
            # the flight: x_{i+1} - x_i + (s_{i+1} - s_i) d/2 = W_i tau, divided by tau if it ends where it began
            row = n + i
            tau, along = self.time(after, i, u)
            right[row] = self.d * ((self.signs[i] - self.signs[after]) // 2)
            same = self.signs[i] == self.signs[after]
            if same:
                lasting = period * tau
                put(row, i, [-1] + [0] * (n - 1))
                step, bend = divided(self.turn, lasting)
                moved = spun[i] * step
                turned = [
                    period * (self.turn * moved * slope[k] + spun[i] * bend * along[k])
                    for k in range(n - 1)
                ]
                put(row, n, [moved.real, *(one.real for one in turned)])
                put(row, n + 1, [moved.imag, *(one.imag for one in turned)])
                step, bend = divided(rate, lasting)
                for j in range(n):
                    here = g * grown[i, j]
                    moved = here * step
                    turned = [
                        period * (rate * moved * steps[i, j][k] + here * bend * along[k])
                        for k in range(n - 1)
                    ]
                    pushed(row, j, [moved.imag, *(one.imag for one in turned)])
                continue
            put(row, i, [-period * tau, *(-period * k for k in along)])
            ends = [(spun[after], steps[after, 0], 1), (spun[i], steps[i, 0], -1)]
            for value, slopes, sign in ends:
                turned = self.turn * value * period * sign
                put(row, n, [value.real * sign, *(turned.real * k for k in slopes)])
                put(row, n + 1, [value.imag * sign, *(turned.imag * k for k in slopes)])
            for j in range(n):
                for end, sign in ((after, 1), (i, -1)):
                    value = g * grown[end, j] * sign
                    bend = value * rate * period
                    pushed(row, j, [value.imag, *(bend.imag * k for k in steps[end, j])])
        layers = [module.arb_mat(layer) for layer in rows]
        return Equations(layers[0], module.arb_mat([[one] for one in right]), layers[1:])

    def states(self, u: Sequence[Any], values: Sequence[Any]) -> list[list[Any]]:
        """psi, X, X', Z' just after each impact, of parts u of the period and W, p, q."""
        module = flint()
        n, (p, q) = self.n, values[-2:]
        start, found = module.arb.atan2(p, q) + self.lag, []
        pushes = [self.mu * (values[(j - 1) % n] - values[j]) for j in range(n)]
        for i in range(n):
            turned = self.r * self.period * self.time(i, 0, u)[0]
            spun = module.acb(0, turned).exp() * module.acb(q, p)
            x, v = spun.imag, self.r * spun.real
            for j, push in enumerate(pushes):
                here = self.g * (self.rate * (self.period * self.time(i, j, u)[0])).exp()
                x, v = x + push * here.imag, v + push * (here * self.rate).imag
            found.append([start + turned, *(self.amplitude * one for one in (x, v, values[i]))])
        return found
