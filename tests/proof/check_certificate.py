"""Checks certificates of vibroimpact without vibroimpact: python check_certificate.py FILE.json ...

It needs only python-flint, and is written from the laws of mechanics alone:

    between impacts   x'' + 2 xi x' + x = f sin(r t),  z'' = 0
    at an impact      z - x = s d/2, momentum x' + mu z' is kept, the relative velocity z' - x' is turned and
                      multiplied by R

An interval Newton step by interval elimination proves existence and uniqueness, dual numbers give all derivatives,
the Routh-Hurwitz conditions decide on the multipliers, and bisection of time intervals proves that the gaps stay
open. Where parameters vary, numbers are polynomials in the parameters with balls as coefficients (series.py). The
package proves the same statements by other methods: Krawczyk's operator, derivatives coded by hand, the recursion
of Schur and Cohn, the product of 1 - x_i x_j, and piecewise Taylor polynomials.
"""

import json
import sys
from itertools import combinations, pairwise
from pathlib import Path

from flint import arb, arb_mat, ctx

sys.path.insert(0, str(Path(__file__).parent))
from check_structure import check_structure  # noqa: I001
from flight import Flight, closes
from form import check_form, proves
from search import check_all
from series import (
    DEGREES, UNIT, RejectedError, Series, ball, check_link, cover, determinant, exact, flat, halves, hurwitz,
    monomials, need, number, product, solve,
)  # fmt: skip
from structure_box import Varied

#: Precision in bits in boxes and at points, and number of times a box, or one of a zone, may be halved.
BITS, MOST_BITS, MOST_HALVINGS, HALVINGS = 128, 960, 10, 14


class Pair:
    """The oscillator in a box of parameters, with the walls and the coefficients of restitution of the impacts."""

    def __init__(self, data, box):
        names, system = ("xi", "mu", "r", "clearance", "load"), data["system"]
        spans = {name: [exact(one) for one in ends] for name, ends in box["parameters"].items()}
        allowed = (
            {"r", "tangent"} if data["kind"] == "zone" else {*names, "R1", "R2", "restitution"}
        )
        need(set(spans) <= allowed, "parameters of the oscillator")
        self.powers, values = monomials(len(spans), 1), {}
        for k, (name, (low, high)) in enumerate(spans.items(), 1):
            need(low < high, f"{name}: low < high")
            ends = number((low + high) / 2), number((high - low) / 2)
            values[name] = Series(
                dict(zip([(self.powers[0], 0), (self.powers[k], 0)], ends, strict=True))
            )
        known = {**system, "r": "1", "clearance": "1"} if data["kind"] == "zone" else system
        self.xi, self.mu, self.r, self.d, self.f = (
            values[name] if name in values else number(known[name]) for name in names
        )
        self.data, sides, texts = data, data["sides"], system["restitution"]
        cycles, symmetric, half = data["cycles"], data["symmetric"], len(sides) // 2
        xi, mu, *others = (spans.get(name) or [exact(known[name])] for name in names)
        need(xi[0] >= 0 and xi[-1] < 1 and mu[0] >= 0, "0 <= xi < 1, mu >= 0")
        need(all(one[0] > 0 for one in others), "r, d, f > 0")
        walls = [
            *map(exact, texts),
            *flat(spans.get(name, []) for name in ("R1", "R2", "restitution")),
        ]
        need(all(0 <= one <= 1 for one in walls), "0 <= R <= 1")
        need(
            set(sides) == {"R", "L"} and len(texts) == len(sides),
            "both walls, and R of each impact",
        )
        need(len(set(zip(sides, map(exact, texts), strict=True))) == 2, "one R of each wall")
        if symmetric:
            # after half a period the state is the mirror image
            need(sides[:half].translate({82: "L", 76: "R"}) == sides[half:], "a symmetric word")
            need(texts[:half] == texts[half:] and cycles % 2 == 1, "symmetric walls, odd cycles")
            need(not {"R1", "R2"}.intersection(spans), "walls that are alike")
            sides, texts = sides[:half], texts[:half]
        self.turn, self.sides = -1 if symmetric else 1, [1 if side == "R" else -1 for side in sides]
        own = [
            values.get("restitution", values.get("R1" if side > 0 else "R2")) for side in self.sides
        ]
        self.R = [
            number(text) if one is None else one for one, text in zip(own, texts, strict=True)
        ]
        self.length = arb.pi() * cycles * (1 if symmetric else 2)
        # x = a sin(r t) + b cos(r t) put into the equation of motion
        real, imaginary = 1 - self.r * self.r, 2 * self.xi * self.r
        square = real * real + imaginary * imaginary
        self.a, self.b = self.f * real / square, self.f * imaginary / square * -1
        self.nu = (1 - self.xi * self.xi).sqrt()
        if data["kind"] == "zone":
            # lengths in units of A |cos theta|, phases from the impact
            facing = 1 - 2 * box["sheet"]
            self.a, self.b = arb(facing), values["tangent"] * facing
            tangent = ball(values["tangent"])
            self.A = 1 / (ball(square) * (1 + tangent * tangent)).sqrt()
        else:
            self.A = self.f / square.sqrt()

    def steady(self, phase):
        """Position and velocity of the steady motion."""
        sine, cosine = phase.sin(), phase.cos()
        return sine * self.a + cosine * self.b, (cosine * self.a - sine * self.b) * self.r

    def free(self, start):
        """p and q of x = exp(-xi t) (p cos nu t + q sin nu t) + the steady motion."""
        x, v = self.steady(start[0])
        p = start[1] - x
        return p, (start[2] - v + p * self.xi) / self.nu

    def damped(self, p, q, tau):
        """The free part of the motion and its velocity."""
        decay, sine, cosine = (
            (tau * self.xi * -1).exp(),
            (tau * self.nu).sin(),
            (tau * self.nu).cos(),
        )
        moved = decay * (p * cosine + q * sine)
        return moved, decay * (q * cosine - p * sine) * self.nu - moved * self.xi

    def landing(self, start, end):
        """The duration of a flight, and x and x' before the impact at its end."""
        tau = (end[0] - start[0]) / self.r
        (x, v), (x1, v1) = self.damped(*self.free(start), tau), self.steady(end[0])
        return tau, x + x1, v + v1

    def laws(self, i, start, end):
        """The residuals from impact i to the next one, whose phase is not reduced."""
        tau, x, v = self.landing(start, end)
        w, step = start[3], (self.sides[i] - self.side(i)) // 2
        return [
            x - end[1],
            start[1] + w * tau + self.d * step - end[1],
            v + w * self.mu - end[2] - end[3] * self.mu,
            end[3] - end[2] + (w - v) * self.R[(i + 1) % len(self.sides)],
        ]

    def side(self, i):
        """The wall at the end of flight i."""
        return self.sides[i + 1] if i + 1 < len(self.sides) else self.sides[0] * self.turn

    def flights(self, states):
        """The number of each flight and the states at its ends; the last one is the first or its mirror image."""
        last = [states[0][0] + self.length, *(one * self.turn for one in states[0][1:])]
        return list(zip(range(len(states)), states, [*states[1:], last], strict=True))

    def blocks(self, states):
        """Derivatives of the laws of each flight with respect to the states at its beginning and at its end."""
        found, zero = [], self.powers[0]
        for i, start, end in self.flights(states):
            unknowns = []
            for k, value in enumerate([*start, *end], 1):
                value = value if isinstance(value, Series) else Series({(zero, 0): value})
                turn = self.turn if i + 1 == len(states) and k > 5 else 1
                unknowns.append(value + Series({(zero, k): arb(turn)}))
            laws = self.laws(i, unknowns[:4], unknowns[4:])
            found.append(
                [[[law.part(first + k) for k in range(4)] for law in laws] for first in (1, 5)]
            )
        return found

    def newton(self, centre, around):
        """The interval Newton step F'(around)^-1 F(centre), both multiplied by an approximate inverse."""
        n = len(centre)
        derivative = [[arb(0)] * (4 * n) for _ in range(4 * n)]
        for i, (here, there) in enumerate(self.blocks(around)):
            for row, first, last in zip(derivative[4 * i : 4 * i + 4], here, there, strict=True):
                for k in range(4):
                    j = 4 * ((i + 1) % n) + k
                    row[4 * i + k] = row[4 * i + k] + first[k]
                    row[j] = row[j] + last[k]
        inverse = (
            arb_mat([[ball(one).mid() for one in row] for row in derivative]).inv().mid().tolist()
        )
        left = [[law] for flight in self.flights(centre) for law in self.laws(*flight)]
        matrix, left = (product(inverse, rows) for rows in (derivative, left))
        matrix, left = (
            arb_mat([[ball(one) for one in row] for row in rows]) for rows in (matrix, left)
        )
        return matrix.solve(left).entries()

    def enclosure(self, box):
        """The states of the only motion in a box of a certificate."""
        texts, radii = flat(box["centre"]), list(map(number, flat(box["radius"])))
        names, n = len(box["parameters"]), len(self.sides)
        need(len(texts) == len(radii) == 4 * n, "four numbers for each impact")
        need(all(len(row) == 4 for row in box["centre"] + box["radius"]), "four numbers each")
        degree = next((k for k in range(9) if len(monomials(names, k)) == len(texts[0])), None)
        need(
            degree is not None and degree <= max(DEGREES[names], 1),
            "the coefficients of a polynomial",
        )
        keys = [(power, 0) for power in monomials(names, degree)]
        centre = [Series(dict(zip(keys, map(number, row), strict=True))) for row in texts]
        rows = lambda values: [values[k : k + 4] for k in range(0, 4 * n, 4)]  # noqa: E731
        around = [one + UNIT * radius for one, radius in zip(centre, radii, strict=True)]
        step = self.newton(rows(centre), rows(around))
        inner = all(abs(one) < radius for one, radius in zip(step, radii, strict=True))
        need(inner, "Newton's step does not stay in the box")
        for _ in range(4):
            step = self.newton(
                rows(centre), rows([a - b for a, b in zip(centre, step, strict=True)])
            )
        states = rows([a - b for a, b in zip(centre, step, strict=True)])
        for _, start, end in self.flights(states):
            need(ball(end[0] - start[0]) > 0, "the impacts follow one another in time")
        return states

    def explicit(self):
        """The states of a motion of a zone, and its clearance, from linear equations."""
        need(len(self.sides) == 1, "one flight in half a period")
        unknowns = [Series({(self.powers[0], k): arb(1)}) for k in range(1, 5)]
        self.d, start = unknowns[0], [arb(0), *unknowns[1:]]
        laws = [law for flight in self.flights([start]) for law in self.laws(*flight)]
        found = flat(
            solve(
                [[law.part(k) for k in range(1, 5)] for law in laws],
                [[law.part(0) * -1] for law in laws],
            )
        )
        self.d = found[0]
        return [[Series({(self.powers[0], 0): arb(0)}), *found[1:]]]

    def approach(self, states):
        """The approach speed at the end of each flight, just before the impact."""
        return [
            ball(self.side(i) * (start[3] - self.landing(start, end)[2]))
            for i, start, end in self.flights(states)
        ]

    def check(self, states, box):
        """Check the verdicts of a box."""
        check_walls(self, states, box)
        check_stability(self, states, box)


def check_walls(pair, states, box):
    """Check the verdict on the gaps, and the bound of |x|."""
    flights = [Flight(pair, *one) for one in pair.flights(states)]
    bound, speeds = box.get("attenuation_below"), pair.approach(states)
    need(bound is None or box["admissible"], "a bound of max|x| for an admissible motion")
    if box["admissible"]:
        need(all(speed > 0 for speed in speeds), "an impact has no approach speed")
        apart = (
            ball(side * (one[3] - one[2])) < 0 for side, one in zip(pair.sides, states, strict=True)
        )
        need(all(apart), "an impact does not part the masses")
        for flight in flights:
            flight.check(None if bound is None else number(bound) * ball(pair.A))
    elif box["admissible"] is False and not any(speed < 0 for speed in speeds):
        closed = (closes(lambda t, one=one: one.at(t)[:2], one.tau) for one in flights)
        need(any(closed), "no gap is proven to close")


def check_stability(pair, states, box):
    """Check the verdict on stability and the bound of the multipliers."""
    stable, bounds = box["stable"], [box.get(f"multipliers_{key}") for key in ("below", "above")]
    need(stable is True or bounds[0] is None, "a bound from above for a stable motion")
    need(stable is False or bounds[1] is None, "a bound from below for an unstable motion")
    if stable is None:
        return
    need(all(abs(one) > 0 for one in pair.approach(states)), "an impact without speed")
    text = bounds[0 if stable else 1] or "1"
    bound = number(text) if pair.turn > 0 else number(text).sqrt()
    need(0 < bound <= 1 if stable else bound >= 1, "the bound does not imply the verdict")
    matrix = [[arb(int(i == j)) for j in range(4)] for i in range(4)]
    last = (pair.length * pair.xi * -2 / pair.r).exp()
    for R, (here, there) in zip(pair.R, pair.blocks(states), strict=True):
        matrix, last = (
            solve(there, [[one * -1 for one in row] for row in product(here, matrix)]),
            last * R * R,
        )
    # the sums of the principal minors; the last coefficient is det[P] by its law
    found = [arb(1)]
    for k in range(1, 4):
        parts = [[[matrix[i][j] for j in some] for i in some] for some in combinations(range(4), k)]
        found.append(sum(map(determinant, parts), arb(0)) * (-1) ** k)
    scaled = [one * bound**-k for k, one in enumerate([*found, last])]
    values = hurwitz(scaled)
    holds = all(one > 0 for one in values) if stable else any(one < 0 for one in values)
    need(holds, f"max|lambda| {'<' if stable else '>'} {text} is not proven")


def check(data):
    """Raise RejectedError unless all statements of a certificate are proven here, too."""
    try:
        check_form(data)
        # motions with many impacts lose many bits
        with ctx.workprec(MOST_BITS if data["kind"] in ("motion", "all") else BITS):
            check_statements(data)
    except (LookupError, TypeError, AttributeError, ValueError, ArithmeticError) as error:
        raise RejectedError(f"{type(error).__name__}: {error}") from None


def check_statements(data):
    """The same with the given precision."""
    kind, sheets = data["kind"], data["sheets"]
    if kind == "zone":
        # cos(theta) of both signs, and all tangents up to the largest
        whole = {"r": data["system"]["r"], "tangent": ["-4096", "4096"]}
        need(sheets == [whole, whole] and data["symmetric"] is True, "both halves of the plane")
    if kind in ("motion", "box") and not data["boxes"]:
        return
    if "mass" in data["system"] and kind == "motion" and data["symmetric"] is False:
        check_structure(data)
        return
    if kind == "all":
        check_all(data, Pair, check_box)
        return
    spans = lambda one: {name: [exact(end) for end in ends] for name, ends in one.items()}  # noqa: E731
    for k, sheet in enumerate(sheets):
        own = [box for box in data["boxes"] if box["sheet"] == k]
        cover(spans(sheet), [spans(box["parameters"]) for box in own])
    found = [(box, check_box(data, box)) for box in data["boxes"]]
    if len(sheets[0]) == 1:
        # neighbours along the parameter, whatever their order in the file
        found.sort(key=lambda one: (one[0]["sheet"], *map(exact, *one[0]["parameters"].values())))
        for (one, before), (two, after) in pairwise(found):
            if one["sheet"] == two["sheet"] and before and after:
                check_link(before, two)


def check_zone(data, box, depth=0):
    """Check the statements of a box of a zone, of parts of it where that fails: verdicts on each motion in the
    window."""
    try:
        pair = Pair(data, box)
        states = pair.explicit()
        if box["exists"] is False:
            low, high = map(number, data["system"]["clearance"])
            clearance = ball(pair.d) * pair.A
            need(clearance < low or clearance > high, "a clearance may lie in the window")
            return
        pair.check(states, box)
    except (RejectedError, ZeroDivisionError) as error:
        if depth == HALVINGS:
            raise RejectedError(str(error)) from None
        name = ("tangent", "tangent", "r")[depth % 3]
        low, high = map(exact, box["parameters"][name])
        for ends in ((low, (low + high) / 2), ((low + high) / 2, high)):
            part = box["parameters"] | {name: [str(end) for end in ends]}
            check_zone(data, {**box, "parameters": part}, depth + 1)


def check_box(data, box, depth=0):
    """Check the statements of a box, in parts of it if need be; the states of its motions, of the last part."""
    if data["kind"] == "zone" and box["exists"] is not None:
        check_zone(data, box)
        return None
    if box["exists"] is None:
        return None
    model = (Varied if "mass" in data["system"] else Pair)(data, box)
    try:
        states = model.enclosure(box)
        model.check(states, box)
    except (RejectedError, ZeroDivisionError):
        names = list(box["parameters"])
        if depth == MOST_HALVINGS or not names:
            raise
        for part in halves(box, names[depth % len(names)]):
            states = check_box(data, part, depth + 1)
    return states


def main(paths):
    """Print what is accepted and what is rejected; the exit status says whether all were accepted."""
    good = True
    for path in paths:
        try:
            data = json.loads(Path(path).read_text(encoding="utf-8"))
            check(data)
        except (OSError, ValueError, RecursionError, RejectedError) as error:
            what = "REJECTED" if isinstance(error, RejectedError) else "cannot be read"
            print(f"{path}: {what}: {error}")
            good = False
            continue
        boxes, words = data["boxes"], f"{len(data['boxes'])} boxes"
        if len(boxes) == 1:
            words = ", ".join(f"{name} = {boxes[0][name]}" for name in ("admissible", "stable"))
        which = f"one motion {data['sides']}/{data['cycles']}, {words}"
        if data["kind"] == "all":
            open_ = sum("times" in item for item in data["undecided"])
            which = f"all motions {data['sides']}: {len(boxes)}, {open_} boxes of times not decided"
        print(f"{path}: accepted: {which if proves(data) else 'it proves nothing'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
