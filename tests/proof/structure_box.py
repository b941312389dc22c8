"""Check certificates of structures along one parameter, or of a symmetric motion (a part of check_certificate.py).

Numbers are polynomials in the parameter (series.py). q is the sum of a steady vibration and a part u that obeys
u' = A u, with the same A for all values of the parameter. Routh's array decides on the multipliers.
"""

from check_structure import System
from flight import closes
from flint import arb, arb_mat, arb_poly
from series import (
    UNIT,
    Series,
    ball,
    determinant,
    exact,
    flat,
    monomials,
    need,
    number,
    product,
    solve,
)

#: Number of times an interval of time may be halved.
MOST_HALVINGS = 40
#: Degree of the polynomials whose determinants are expanded.
MOST_FOR_MINORS = 6


def series(values, names):
    """A polynomial of one parameter, or a number."""
    keys = [((k,) * names, 0) for k in range(len(values))]
    return Series(dict(zip(keys, map(number, values), strict=True)))


class Varied:
    """The equations of a certificate in a box of parameters."""

    def __init__(self, data, box):
        fixed = System(data)
        self.n, self.size, self.gaps = fixed.n, fixed.size, fixed.gaps
        names, gaps = [*box["parameters"]], range(len(fixed.gaps))
        allowed = {"frequency", "load", "constant", "opening", "restitution"}
        allowed |= {f"{name}_{k}" for name in ("opening", "restitution") for k in gaps}
        need(len(names) <= 1 and set(names) <= allowed, "one parameter of the structure")
        self.zero, n, known = monomials(len(names), 0)[0], self.n, {}
        for name, ends in box["parameters"].items():
            low, high = map(exact, ends)
            need(
                low < high and (0 < low < high <= 1 or name[:3] != "res"),
                "low < high, and 0 < R <= 1",
            )
            known[name] = series([(low + high) / 2, (high - low) / 2], 1)
        self.W, self.unit = known.get("frequency", fixed.W), known.get("constant", arb(1))
        self.e, self.R = (
            [known.get(name, known.get(f"{name}_{k}", fixed.gaps[k][place])) for k in gaps]
            for name, place in (("opening", 1), ("restitution", 2))
        )
        need(ball(self.W) > 0, "a frequency above 0")
        self.A = arb_mat([[fixed.A[i, j] for j in range(2 * n + 1)] for i in range(2 * n + 1)])
        self.impacts, self.turn, half = fixed.impacts, 1, len(fixed.impacts) // 2
        self.last, cycles = self.impacts[0], 2 * fixed.cycles
        if data["symmetric"]:
            self.last, cycles = self.mirrored(data, names, half), fixed.cycles
            self.impacts, self.turn = self.impacts[:half], -1
        self.length = arb.pi() * cycles / self.W
        self.decay = (self.length * -fixed.M.solve(fixed.C).trace()).exp()
        self.pushes = [fixed.M.solve(G.transpose()) for G, _, _ in fixed.gaps]
        # (K - w^2 M) a + w C b = cosine, (K - w^2 M) b - w C a = sine
        self.waves, load = [], known.get("load", arb(1))
        for h in range(len(fixed.sine)):
            w = self.W * (h + 1)
            D = [[fixed.K[i, j] - w * w * fixed.M[i, j] for j in range(n)] for i in range(n)]
            C = [[w * fixed.C[i, j] for j in range(n)] for i in range(n)]
            rows = [[*one, *two] for one, two in zip(D, C, strict=True)]
            rows += [[*(-1 * k for k in two), *one] for one, two in zip(D, C, strict=True)]
            forces = [[one * load] for one in (*fixed.cosine[h], *fixed.sine[h])]
            found = flat(solve(rows, forces))
            self.waves.append((w, found[:n], found[n:]))

    def mirrored(self, data, names, half):
        """The gap at the end of half a period that leads to -q."""
        system = data["system"]
        turned = lambda i, j: all(  # noqa: E731
            [exact(one) for one in system["gaps"][i][name]] == [-exact(two) for two in system["gaps"][j][name]]
            if name == "direction" else exact(system["gaps"][i][name]) == exact(system["gaps"][j][name])
            for name in ("direction", "opening", "restitution")
        )  # fmt: skip
        gaps = range(len(self.gaps))
        need(all(any(turned(i, j) for j in gaps) for i in gaps), "gaps on both sides")
        need(not any("_" in name for name in names), "gaps that stay alike")
        even = [*system["sine"][1::2], *system["cosine"][1::2], system["constant"]]
        need(not any(exact(one) for one in flat(even)), "a load whose half periods are opposite")
        need(data["cycles"] % 2 == 1, "an odd number of cycles")
        pairs = zip(self.impacts[:half], self.impacts[half:], strict=True)
        need(all(turned(i, j) for i, j in pairs), "a symmetric word")
        return self.impacts[half]

    def steady(self, t):
        """q, q' and q'' of the steady vibration."""
        q, v, a = ([arb(0)] * self.n for _ in range(3))
        for w, first, second in self.waves:
            sine, cosine = (w * t).sin(), (w * t).cos()
            for k in range(self.n):
                here = first[k] * cosine + second[k] * sine
                rate = (second[k] * cosine - first[k] * sine) * w
                q[k], v[k], a[k] = q[k] + here, v[k] + rate, a[k] - here * w * w
        return q, v, a

    def flow(self, t):
        """exp(A t), and its derivatives."""
        known = {}

        def slopes(x):
            key = str(x.mid().man_exp()), str(x.rad().man_exp())
            if key not in known:
                known[key] = [(self.A * x).exp()]
                for _ in range(8):
                    known[key].append(self.A * known[key][-1])
            return known[key]

        entry = lambda i, j: t.function(lambda x: [one[i, j] for one in slopes(x)])  # noqa: E731
        return [[entry(i, j) for j in range(2 * self.n + 1)] for i in range(2 * self.n)]

    def part(self, state):
        """u at an impact."""
        q, v, _ = self.steady(state[0])
        return [*(a - b for a, b in zip(state[1:], [*q, *v], strict=True)), self.unit]

    def flights(self, states):
        """The states at both ends of each flight, the gap at its end, and the sign of the last state."""
        for i, start in enumerate(states):
            if i + 1 < len(states):
                yield start, states[i + 1], self.impacts[i + 1], 1
            else:
                end = [states[0][0] + self.length, *(one * self.turn for one in states[0][1:])]
                yield start, end, self.last, self.turn

    def landing(self, start, end):
        """q and q' at the end of a flight."""
        moved = flat(product(self.flow(end[0] - start[0]), [[one] for one in self.part(start)]))
        q, v, _ = self.steady(end[0])
        return [one + two for one, two in zip(moved, [*q, *v], strict=True)]

    def along(self, gap, values):
        """G q or G q'."""
        G = self.gaps[gap][0].entries()
        return sum((one * two for one, two in zip(values, G, strict=True)), arb(0))

    def laws(self, start, end, gap):
        """The residuals of the equations."""
        z, n = self.landing(start, end), self.n
        push = self.pushes[gap].entries()
        kick = (1 + self.R[gap]) * self.along(gap, z[n:]) / self.along(gap, push)
        after = [*z[:n], *(one - kick * two for one, two in zip(z[n:], push, strict=True))]
        left = [one - two for one, two in zip(after, end[1:], strict=True)]
        return [*left, self.along(gap, z[:n]) - self.e[gap]]

    def blocks(self, states):
        """Derivatives of the laws of each flight with respect to the unknowns at its beginning and at its end."""
        zero, found, size = self.zero, [], self.size
        for start, end, gap, sign in self.flights(states):
            unknowns = []
            for k, value in enumerate([*start, *end], 1):
                value = value if isinstance(value, Series) else Series({(zero, 0): value})
                turn = sign if k > size + 1 else 1
                unknowns.append(value + Series({(zero, k): arb(turn)}))
            laws = self.laws(unknowns[:size], unknowns[size:], gap)
            found.append(
                [[[law.part(k + j) for k in range(1, size + 1)] for law in laws] for j in (0, size)]
            )
        return found

    def newton(self, centre, around):
        """The interval Newton step."""
        size, n = self.size, len(centre)
        matrix = [[arb(0)] * (size * n) for _ in range(size * n)]
        for i, (here, there) in enumerate(self.blocks(around)):
            for row, first, last in zip(
                matrix[size * i : size * (i + 1)], here, there, strict=True
            ):
                for k in range(size):
                    j = size * ((i + 1) % n) + k
                    row[size * i + k] = row[size * i + k] + first[k]
                    row[j] = row[j] + last[k]
        inverse = arb_mat([[ball(one).mid() for one in row] for row in matrix]).inv().mid().tolist()
        left = [
            [law]
            for start, end, gap, _ in self.flights(centre)
            for law in self.laws(start, end, gap)
        ]
        matrix, left = (
            arb_mat([[ball(one) for one in row] for row in product(inverse, rows)])
            for rows in (matrix, left)
        )
        return matrix.solve(left).entries()

    def enclosure(self, box):
        """The states of the only motion in a box."""
        texts, radii = flat(box["centre"]), [number(one) for one in flat(box["radius"])]
        names, count, size = len(box["parameters"]), len(self.impacts), self.size
        need(len(box["centre"]) == len(box["radius"]) == count, "all impacts")
        need(all(len(row) == size for row in box["centre"] + box["radius"]), "all unknowns")
        need(all(len(one) == 1 + 5 * names for one in texts), "the coefficients of a polynomial")
        rows = lambda values: [values[k : k + size] for k in range(0, size * count, size)]  # noqa: E731
        centre = [series(one, names) for one in texts]
        around = [one + UNIT * radius for one, radius in zip(centre, radii, strict=True)]
        step = self.newton(rows(centre), rows(around))
        inner = all(abs(one) < radius for one, radius in zip(step, radii, strict=True))
        need(inner, "Newton's step does not stay in the box")
        for _ in range(4):
            around = [one - two for one, two in zip(centre, step, strict=True)]
            step = self.newton(rows(centre), rows(around))
        states = rows([one - two for one, two in zip(centre, step, strict=True)])
        for start, end, _, _ in self.flights(states):
            need(ball(end[0] - start[0]) > 0, "the impacts follow one another in time")
        return states

    def check(self, states, box):
        """Check the verdicts of a box."""
        need(box.get("attenuation_below") is None, "no bound of the amplitude")
        speeds = [
            ball(self.along(gap, self.landing(start, end)[self.n :]))
            for start, end, gap, _ in self.flights(states)
        ]
        self.check_gaps(states, speeds, box["admissible"])
        self.check_multipliers(states, speeds, box)

    def check_gaps(self, states, speeds, verdict):
        """Check the verdict on the gaps."""
        if verdict is None or (verdict is False and any(one < 0 for one in speeds)):
            return
        need(verdict is False or all(one > 0 for one in speeds), "an impact has no approach speed")
        closed, before = False, self.impacts
        for i, (start, end, last, _) in enumerate(self.flights(states)):
            tau, part = ball(end[0] - start[0]), self.part(start)
            if verdict is False:
                for gap, e in enumerate(self.e):

                    def at(t, gap=gap, e=e, begin=start[0], part=part):
                        q, v = self.at(begin, part, t, arb(0))
                        return ball(e - self.along(gap, q)), self.along(gap, v)

                    closed = closed or closes(at, tau)
                continue
            pieces = [(arb(0), arb(tau.upper()), 0, [*range(len(self.gaps))])]
            while pieces:
                low, high, depth, gaps = pieces.pop()
                t, left = low.union(high), []
                q, wide = self.at(start[0], part, t.mid(), t - t.mid())
                for gap in gaps:
                    # the mean value theorem
                    rate = -self.along(gap, wide)
                    distance = ball(self.e[gap] - self.along(gap, q)) + rate * (t - t.mid())
                    leaves = gap == before[i] and low == 0 and rate > 0
                    lands = gap == last and not high < tau and rate < 0
                    if not (distance > 0 or leaves or lands):
                        left.append(gap)
                need(depth < MOST_HALVINGS or not left, "a gap may close")
                if left:
                    middle = ((low + high) / 2).mid()
                    pieces += [(low, middle, depth + 1, left), (middle, high, depth + 1, left)]
        need(verdict or closed, "no gap is proven to close")

    def at(self, begin, part, t, width):
        """q at a time after an impact, and q' within a distance of that time."""
        n = self.n
        moved = flat(product((self.A * t).exp().tolist(), [[one] for one in part]))
        q = [one + two for one, two in zip(moved[:n], self.steady(begin + t)[0], strict=True)]
        wide = ((self.A * width).exp() * arb_mat([[ball(one)] for one in moved])).entries()
        when = ball(begin) + t + width
        v = wide[n : 2 * n]
        for w, first, second in self.waves:
            sine, cosine = (ball(w) * when).sin(), (ball(w) * when).cos()
            for k in range(n):
                v[k] = v[k] + (ball(second[k]) * cosine - ball(first[k]) * sine) * ball(w)
        return q, v

    def check_multipliers(self, states, speeds, box):
        """Check the verdict on stability and the bound of the multipliers."""
        stable, bounds = (
            box["stable"],
            [box.get(f"multipliers_{key}") for key in ("below", "above")],
        )
        need(stable is True or bounds[0] is None, "a bound from above for a stable motion")
        need(stable is False or bounds[1] is None, "a bound from below for an unstable motion")
        if stable is None:
            return
        need(all(abs(one) > 0 for one in speeds), "an impact without speed")
        bound = number(bounds[0 if stable else 1] or "1")
        need(0 < bound <= 1 if stable else bound >= 1, "the bound does not imply the verdict")
        bound = bound if self.turn > 0 else bound.sqrt()
        size = self.size
        matrix = [[arb(int(i == j)) for j in range(size)] for i in range(size)]
        for here, there in self.blocks(states):
            moved = product(here, matrix)
            matrix = solve(there, [[one * -1 for one in row] for row in moved])
        # positions after an impact are on the gap, so one eigenvalue is 0; the product of the others is known
        found, power, last = [arb(1)], matrix, self.decay
        for k in range(1, size - 1):
            found.append(sum((power[i][i] for i in range(size)), arb(0)) * (arb(-1) / k))
            power = [
                [one + found[-1] * int(i == j) for j, one in enumerate(row)]
                for i, row in enumerate(power)
            ]
            power = product(matrix, power)
        for gap in [*self.impacts[1:], self.last]:
            last = last * self.R[gap] * self.R[gap]
        values = routh([one * bound**-k for k, one in enumerate([*found, last])])
        holds = all(one > 0 for one in values) if stable else any(one < 0 for one in values)
        need(holds, "the bound of the multipliers is not proven")


def routh(polynomial):
    """The first column of Routh's array: positive where all zeros lie inside the unit circle.

    A zero lies outside where a number in the column is negative and all numbers before it are positive, or where a
    coefficient of the transformed polynomial is negative.
    """
    m = len(polynomial) - 1
    plus, minus = arb_poly([1, 1]), arb_poly([1, -1])
    parts = [plus ** (m - k) * minus**k for k in range(m + 1)]
    turned = [
        sum((one * part[m - j] for one, part in zip(polynomial, parts, strict=True)), arb(0))
        for j in range(m + 1)
    ]
    if any(ball(one) < 0 for one in turned):
        return [arb(-1)]
    first, second, found = turned[::2], turned[1::2], [ball(turned[0])]
    while second:
        found.append(ball(second[0]))
        if found[-1] < 0:
            return found
        if not found[-1] > 0:
            # a number may change sign while a zero stays outside
            return minors(turned) if m <= MOST_FOR_MINORS else [arb(0)]
        ratio = first[0] / second[0]
        rest = [*second[1:], arb(0)][: len(first) - 1]
        first, second = (
            second,
            [one - ratio * two for one, two in zip(first[1:], rest, strict=True)],
        )
    return found


def minors(turned):
    """Hurwitz's determinants: one is negative only where a zero lies outside the unit circle."""
    m = len(turned) - 1
    entry = lambda i, j: turned[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= m else arb(0)  # noqa: E731
    found = [
        ball(determinant([[entry(i, j) for j in range(k)] for i in range(k)])) for k in range(2, m)
    ]
    return [arb(0), *found]
