"""Checks certificates of vibroimpact without vibroimpact: python check_certificate.py FILE.json ...

It needs python-flint alone, and is written from the laws of mechanics:

    between impacts   x'' + 2 xi x' + x = f sin(r t),  z'' = 0
    at an impact      z - x = s d/2, momentum x' + mu z' is kept, the relative velocity z' - x' is turned and
                      multiplied by R

An interval Newton step by interval elimination proves existence and uniqueness, dual numbers give all derivatives,
powers of [P] bound its spectral radius, and intervals of time that are halved prove that the gaps stay open. The
package proves the same in other ways: Krawczyk's operator, derivatives written by hand, the recursion of Schur and
Cohn, Taylor polynomials in pieces.
"""

import json
import re
import sys
from fractions import Fraction

from flint import arb, arb_mat, ctx, fmpq

#: Bits of the numbers at first and at last, halvings of a piece of time, and squarings of [P].
BITS, MOST_BITS, MOST_HALVINGS, SQUARINGS = 320, 960, 22, 64
HEXADECIMAL = re.compile(r"(-?0x[0-9a-f]+)p(-?[0-9]+)")
DECIMAL = re.compile(r"-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?")


class RejectedError(Exception):
    """A statement of a certificate is not proven here."""


def need(holds, what):
    """RejectedError if something does not hold, or is not certain."""
    if not holds:
        raise RejectedError(what)


def number(text):
    """The ball of the exact number that a text stands for."""
    need(isinstance(text, str), f"{text!r} is no text of a number")
    found = HEXADECIMAL.fullmatch(text)
    if found:
        value = int(found[1], 16) * Fraction(2) ** int(found[2])
    else:
        need(DECIMAL.fullmatch(text), f"{text!r} is no exact number")
        value = Fraction(text)
    return arb(fmpq(value.numerator, value.denominator))


class Dual:
    """A number with its derivatives by the 2 x 4 unknowns of an impact and the next one."""

    def __init__(self, value, slopes=None):
        self.value = value
        self.slopes = slopes or [arb(0)] * 8

    def of(self, value, slope):
        return Dual(value, [slope * one for one in self.slopes])

    def __add__(self, other):
        other = dual(other)
        return Dual(
            self.value + other.value,
            [a + b for a, b in zip(self.slopes, other.slopes, strict=True)],
        )

    def __mul__(self, other):
        other = dual(other)
        slopes = [
            self.value * b + other.value * a for a, b in zip(self.slopes, other.slopes, strict=True)
        ]
        return Dual(self.value * other.value, slopes)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + dual(other) * -1

    def __rsub__(self, other):
        return dual(other) + self * -1

    def sin(self):
        return self.of(self.value.sin(), self.value.cos())

    def cos(self):
        return self.of(self.value.cos(), -self.value.sin())

    def exp(self):
        return self.of(self.value.exp(), self.value.exp())


def dual(value):
    return value if isinstance(value, Dual) else Dual(arb(value))


class Pair:
    """The oscillator at a point, with the walls and the coefficients of restitution of the impacts."""

    def __init__(self, system, sides, cycles):
        names = ("xi", "mu", "r", "clearance", "load")
        self.xi, self.mu, self.r, self.d, self.f = (number(system[name]) for name in names)
        need(0 <= self.xi and self.xi < 1, "0 <= xi < 1")
        need(self.mu >= 0 and self.r > 0 and self.d > 0 and self.f > 0, "mu >= 0; r, d, f > 0")
        need(set(sides) == {"R", "L"}, "the walls are R and L, and both are hit")
        self.sides = [1 if side == "R" else -1 for side in sides]
        self.R = [number(one) for one in system["restitution"]]
        need(len(self.R) == len(self.sides), "a coefficient of restitution for each impact")
        need(all(0 <= one and one <= 1 for one in self.R), "0 <= R <= 1")
        need(type(cycles) is int and cycles > 0, "a whole number of cycles")
        self.turn = 2 * arb.pi() * cycles
        # x = a sin(r t) + b cos(r t) put into the equation of motion
        matrix = arb_mat(
            [[1 - self.r**2, -2 * self.xi * self.r], [2 * self.xi * self.r, 1 - self.r**2]]
        )
        steady = matrix.solve(arb_mat([[self.f], [arb(0)]]))
        self.a, self.b = steady[0, 0], steady[1, 0]
        self.A = (self.a**2 + self.b**2).sqrt()
        self.nu = (1 - self.xi**2).sqrt()

    def steady(self, phase):
        """Position and velocity of the steady motion."""
        sine, cosine = phase.sin(), phase.cos()
        return sine * self.a + cosine * self.b, (cosine * self.a - sine * self.b) * self.r

    def primary(self, start, tau, phase):
        """x and x' a time tau after an impact, at a load phase."""
        psi, x, v, _ = start
        x0, v0 = self.steady(psi)
        x, v = x - x0, v - v0
        # x = exp(-xi t) (x cos nu t + c sin nu t)
        c = (v + x * self.xi) * (1 / self.nu)
        sine, cosine, decay = (tau * self.nu).sin(), (tau * self.nu).cos(), (tau * -self.xi).exp()
        moved = decay * (x * cosine + c * sine)
        rate = decay * (c * cosine - x * sine) * self.nu - moved * self.xi
        x1, v1 = self.steady(phase)
        return moved + x1, rate + v1

    def laws(self, i, start, end):
        """What must vanish from impact i to the next one, whose phase is not reduced."""
        j = (i + 1) % len(self.sides)
        tau = (end[0] - start[0]) * (1 / self.r)
        x, v = self.primary(start, tau, end[0])
        z = start[1] + self.d * self.sides[i] / 2 + start[3] * tau
        w = start[3]
        return [
            x - end[1],
            z - end[1] - self.d * self.sides[j] / 2,
            v + w * self.mu - end[2] - end[3] * self.mu,
            end[3] - end[2] + (w - v) * self.R[j],
        ]

    def ends(self, states):
        """The states after the next impacts; the last one is the first, a period later."""
        first = [states[0][0] + self.turn, *states[0][1:]]
        return [*states[1:], first]

    def values(self, states):
        """All laws."""
        n = len(states)
        pairs = zip(range(n), states, self.ends(states), strict=True)
        return [one for i, start, end in pairs for one in self.laws(i, start, end)]

    def blocks(self, states):
        """Derivatives of the laws of each flight by the state at its beginning, and by that at its end."""
        found = []
        for i, (start, end) in enumerate(zip(states, self.ends(states), strict=True)):
            unknowns = [
                Dual(value, [arb(int(k == place)) for k in range(8)])
                for place, value in enumerate([*start, *end])
            ]
            laws = self.laws(i, unknowns[:4], unknowns[4:])
            found.append(
                (
                    arb_mat([law.slopes[:4] for law in laws]),
                    arb_mat([law.slopes[4:] for law in laws]),
                )
            )
        return found

    def newton(self, centre, around):
        """The interval Newton step: centre - F'(around)^-1 F(centre)."""
        n = len(centre)
        derivative = [[arb(0)] * (4 * n) for _ in range(4 * n)]
        for i, (here, there) in enumerate(self.blocks(around)):
            j = (i + 1) % n
            for row in range(4):
                for column in range(4):
                    derivative[4 * i + row][4 * i + column] += here[row, column]
                    derivative[4 * i + row][4 * j + column] += there[row, column]
        left = arb_mat([[one] for one in self.values(centre)])
        # elimination of the matrix times an approximate inverse loses less
        matrix = arb_mat(derivative)
        inverse = matrix.mid().inv().mid()
        step = (inverse * matrix).solve(inverse * left)
        return [[centre[i][k] - step[4 * i + k, 0] for k in range(4)] for i in range(n)]


def enclosure(pair, box):
    """The states of the one motion in the box of a certificate, narrow."""
    centre = [[number(one) for one in row] for row in box["centre"]]
    radii = [[number(one) for one in row] for row in box["radius"]]
    n = len(pair.sides)
    need(len(centre) == len(radii) == n, "a centre and a radius for each impact")
    need(all(len(row) == 4 for row in centre + radii), "four numbers for each impact")
    around = [
        [one + arb(0, 1) * radius for one, radius in zip(*rows, strict=True)]
        for rows in zip(centre, radii, strict=True)
    ]
    try:
        states = pair.newton(centre, around)
        for i in range(n):
            for k in range(4):
                inner = abs(states[i][k] - centre[i][k]) < radii[i][k]
                need(inner, "Newton's step does not stay in the box")
        for _ in range(4):
            states = pair.newton([[one.mid() for one in row] for row in states], states)
    except ZeroDivisionError:
        raise RejectedError("the derivative may be singular in the box") from None
    for start, end in zip(states, pair.ends(states), strict=True):
        need(end[0] > start[0], "the impacts follow one another in time")
    return states


def speeds_before(pair, states):
    """x' and the approach speed just before the impact that ends each flight, of which the latter has its sign."""
    found = []
    for i, (start, end) in enumerate(zip(states, pair.ends(states), strict=True)):
        tau = (end[0] - start[0]) / pair.r
        _, v = pair.primary(start, tau, end[0])
        found.append(pair.sides[(i + 1) % len(states)] * (start[3] - v))
    return found


def gap(pair, i, start, t):
    """Y, Y', Y'' and x, x', x'' a time t after impact i."""
    x, v = pair.primary(start, t, start[0] + pair.r * t)
    acceleration = pair.f * (start[0] + pair.r * t).sin() - 2 * pair.xi * v - x
    y = start[1] + pair.d * pair.sides[i] / 2 + start[3] * t - x
    return y, start[3] - v, -acceleration, x, v, acceleration


def ranges(pair, i, start, low, high):
    """Y, Y' and x from `low` to `high`, by the theorem of the mean."""
    middle = (low + high) / 2
    spread = arb(0, 1) * ((high - low) / 2)
    _, _, bend, _, _, x_bend = gap(pair, i, start, middle + spread)
    y, y_dot, _, x, x_dot, _ = gap(pair, i, start, middle)
    rate, x_rate = y_dot + bend * spread, x_dot + x_bend * spread
    return y + rate * spread, rate, x + x_rate * spread


def flight_stays_open(pair, i, start, tau, side, bound):
    """Check |Y| < d/2 in a flight, and |x| <= bound."""
    half = pair.d / 2
    low, last = arb(0), tau.upper()
    ends = [last * k / 32 for k in range(33)]
    pieces = [(ends[k], ends[k + 1], 0) for k in range(32)][::-1]
    before = None  # the sign of Y' on the piece before; None where |Y| < d/2 on it
    while pieces:
        low, high, depth = pieces.pop()
        y, rate, x = ranges(pair, i, start, low, high)
        open_ = abs(y) < half
        sign = 1 if rate > 0 else -1 if rate < 0 else 0
        good = open_ or sign != 0
        if not open_ and sign and before not in (None, sign):
            good = abs(gap(pair, i, start, low)[0]) < half
        if not high < tau:
            good = good and sign == side
        if bound is not None and not abs(x) <= bound:
            good = False
        if not good:
            need(depth < MOST_HALVINGS, f"flight {i}: not proven to stay between the walls")
            middle = (low + high) / 2
            middle = middle.mid()
            pieces += [(middle, high, depth + 1), (low, middle, depth + 1)]
            continue
        before = None if open_ else sign


def flights_stay_open(pair, states, bound):
    """Check that the masses approach at all impacts, and both gaps stay open in all flights."""
    for i, speed in enumerate(speeds_before(pair, states)):
        need(speed > 0, f"flight {i} has no approach speed at its end")
    for i, (start, end) in enumerate(zip(states, pair.ends(states), strict=True)):
        need(pair.sides[i] * (start[3] - start[2]) < 0, f"impact {i} does not part the masses")
        side = pair.sides[(i + 1) % len(states)]
        flight_stays_open(pair, i, start, (end[0] - start[0]) / pair.r, side, bound)


def gap_closes(pair, states):
    """Whether an impact is met from the wrong side, or a wall is passed, with certainty."""
    if any(speed < 0 for speed in speeds_before(pair, states)):
        return True
    for i, (start, end) in enumerate(zip(states, pair.ends(states), strict=True)):
        last = ((end[0] - start[0]) / pair.r).lower()
        for count in (64, 4096):
            for k in range(1, count):
                if abs(gap(pair, i, start, (last * k / count).mid())[0]) > pair.d / 2:
                    return True
    return False


def period_map(pair, states):
    """[P], from the derivatives of the laws."""
    product = arb_mat(4, 4, [int(k % 5 == 0) for k in range(16)])
    for here, there in pair.blocks(states):
        product = there.solve(here * product) * -1
    return product


def spectral_radius(matrix, bound, below):
    """Whether the spectral radius is below `bound`, by norms of powers, or above it, by traces of powers."""
    power = matrix * (1 / bound)
    for _ in range(SQUARINGS):
        entries = [abs(one) for one in power.entries()]
        if below and all(sum(entries[4 * i : 4 * i + 4], arb(0)) < 1 for i in range(4)):
            return True
        # four eigenvalues with moduli up to 1 have a trace of 4 at most
        if not below and abs(power.trace()) > 4:
            return True
        power = power * power
    return False


def check(data):
    """RejectedError unless all statements of a certificate are proven here too."""
    try:
        with ctx.workprec(BITS):
            check_statements(data)
    except RejectedError:
        with ctx.workprec(MOST_BITS):  # motions of many impacts lose many bits
            check_statements(data)


def check_statements(data):
    """The same with the digits that are set."""
    need(data.get("type") == "Certificate" and data.get("format") == 1, "a certificate, format 1")
    need(data.get("kind") == "motion", "a certificate of a motion")
    need(len(data["boxes"]) == 1, "a certificate of a motion has one box")
    box = data["boxes"][0]
    pair = Pair(data["system"], data["sides"], data["cycles"])
    need(box["exists"] is True, "a box holds a motion")
    for name in ("admissible", "stable"):
        need(box[name] in (True, False, None), f"{name}: true, false or null")
    reasons = [item["reason"] for item in data["undecided"]]
    need(
        reasons or None not in (box["admissible"], box["stable"]), "reasons of what is not decided"
    )
    states = enclosure(pair, box)
    bound = box["attenuation_below"]
    need(bound is None or box["admissible"], "a bound of max|x| for an admissible motion")
    if box["admissible"]:
        flights_stay_open(pair, states, None if bound is None else number(bound) * pair.A)
    elif box["admissible"] is False:
        need(gap_closes(pair, states), "no gap is proven to close")
    check_stability(pair, states, box)


def check_stability(pair, states, box):
    """The same for the verdict on stability and the bound of the multipliers."""
    stable = box["stable"]
    bounds = {key: box[f"multipliers_{key}"] for key in ("below", "above")}
    need(stable is True or bounds["below"] is None, "a bound from above for a stable motion")
    need(stable is False or bounds["above"] is None, "a bound from below for an unstable motion")
    if stable is None:
        return
    need(all(abs(one) > 0 for one in speeds_before(pair, states)), "an impact without speed")
    text = bounds["below" if stable else "above"]
    bound = arb(1) if text is None else number(text)
    need(bound <= 1 if stable else bound >= 1, "the bound does not imply the verdict")
    what = f"max|lambda| {'<' if stable else '>'} {text or 1}"
    need(spectral_radius(period_map(pair, states), bound, stable), f"{what} is not proven")


def main(paths):
    """Print what is accepted and what is rejected; the exit status says whether all were accepted."""
    good = True
    for path in paths:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        try:
            check(data)
        except (RejectedError, KeyError, TypeError, AttributeError, ValueError) as error:
            print(f"{path}: REJECTED: {error}")
            good = False
            continue
        box = data["boxes"][0]
        verdicts = ", ".join(f"{name} = {box[name]}" for name in ("admissible", "stable"))
        print(f"{path}: accepted: one motion {data['sides']}/{data['cycles']}, {verdicts}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
