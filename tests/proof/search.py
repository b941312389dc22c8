"""All motions of a word, for the program that checks certificates: that there are no others than those it lists.

Given the times of the impacts, the laws are linear in x, x', z' just after each impact and in p = sin(theta),
q = cos(theta) of the steady motion A sin(r t + theta), whose p^2 + q^2 = 1. Boxes of these times, as parts of the
period, are halved until the laws contradict each other in them, or hold at most one motion, which is known. Where
the linear equations are singular theta is halved, too. Lengths are in units of A.
"""

from itertools import pairwise

from flint import arb, arb_mat, ctx
from series import UNIT, ball, exact, need, number

#: Bits, the most boxes of a word, and the width of a box that is given up.
BITS, MOST, NARROWEST = 96, 400_000, 2.0**-36
#: Parts of the period and times below which derivatives are used in place of quotients, or theta is halved.
SHORT, NEARLY = 0.25, 2.0**-8


class Word:
    """The laws of a word at a point, for boxes of times."""

    def __init__(self, pair, exempt):
        self.exempt = exempt
        self.n, self.sides, self.R = len(pair.sides), pair.sides, pair.R
        self.xi, self.mu, self.r, self.nu = pair.xi, pair.mu, pair.r, pair.nu
        self.T = pair.length / pair.r
        self.d = pair.d / pair.A
        # each impact takes mu (1 - R^2) e^2/(2 (1 + mu)) from what the load gives, at most f^2 T/(16 xi)
        need(self.xi > 0 and all(R > 0 and R < 1 for R in self.R), "xi > 0 and 0 < R < 1")
        largest = max(self.R, key=lambda one: float(one.upper())).upper()
        e = (
            pair.f * pair.f * self.T * (1 + self.mu) / (8 * self.xi * self.mu * (1 - largest**2))
        ).sqrt()
        jump = 2 * e / (1 + self.mu)
        # the response to the impulses: each one decays from mu jump, and so do those of the periods before
        once = self.mu * jump / self.nu / (1 - (-self.xi * self.T).exp())
        speed = pair.A * pair.r + self.n * once + self.n * jump / 2
        self.shortest = (pair.d / speed / self.T).lower()

    def free(self, t):
        """u, w, y of a free vibration: x = u x_0 + w x'_0, x' = -w x_0 + y x'_0."""
        decay, sine, cosine = (-self.xi * t).exp(), (self.nu * t).sin(), (self.nu * t).cos()
        w, c = decay * sine / self.nu, decay * cosine
        return c + self.xi * w, w, c - self.xi * w

    def wave(self, t):
        """The steady motion by p and q, with two derivatives."""
        s, c, r = (self.r * t).sin(), (self.r * t).cos(), self.r
        return (c, -r * s, -r * r * c), (s, r * c, -r * r * s)

    def forced(self, free, here, there):
        """What the steady motion adds to x and x' at the end of a flight, each with derivatives by its duration
        and its beginning."""
        u, w, y = free
        F = there[0] - u * here[0] - w * here[1]
        F_t = there[1] - u * here[1] - w * here[2]
        G = there[1] + w * here[0] - y * here[1]
        G_tau = there[2] + y * here[0] + (2 * self.xi * y + w) * here[1]
        return (F, G, F_t), (G, G_tau, there[2] + w * here[1] - y * here[2])

    def laws(self, u):
        """The matrix of the laws, the right side, and the derivatives of the matrix by each part u."""
        n, T, m = self.n, self.T, self.n - 1
        starts = [sum(u[:i], arb(0)) for i in range(n)] + [arb(1)]
        size, thin = 3 * n + 2, all(one.rad() == 0 for one in u)
        rows = [[[arb(0)] * size for _ in range(4 * n)] for _ in range(n)]
        right = [[arb(0)] for _ in range(4 * n)]
        for i in range(n):
            after, step = (i + 1) % n, (self.sides[(i + 1) % n] - self.sides[i]) // 2
            part = u[i] if i < m else 1 - sum(u, arb(0))
            tau = T * part
            # derivatives of the duration and of the beginning by u
            d_tau = [T * (int(k == i) - int(i == m)) for k in range(m)]
            d_t = [T * int(k < i) for k in range(m)]

            def put(row, place, value, by_tau=0, by_t=0, i=i, d_tau=d_tau, d_t=d_t):
                rows[0][4 * i + row][place] += value
                for k in range(m):
                    rows[1 + k][4 * i + row][place] += by_tau * d_tau[k] + by_t * d_t[k]

            free = self.free(tau)
            a, b, w, y = 3 * i, 3 * after, free[1], free[2]
            y_slope = -2 * self.xi * y - w
            waves = list(zip(self.wave(T * starts[i]), self.wave(T * starts[i + 1]), strict=True))
            forced = [self.forced(free, *one) for one in waves]
            put(0, a, free[0], -w), put(0, a + 1, w, y), put(0, b, -1)
            for k, (x, _) in enumerate(forced):
                put(0, 3 * n + k, *x)
            R = self.R[after]
            for row, factor in ((2, 1), (3, -R)):
                put(row, a, -factor * w, -factor * y), put(row, a + 1, factor * y, factor * y_slope)
                for k, (_, v) in enumerate(forced):
                    put(row, 3 * n + k, *(factor * one for one in v))
            put(2, a + 2, self.mu), put(2, b + 1, -1), put(2, b + 2, -self.mu)
            put(3, a + 2, R), put(3, b + 1, -1), put(3, b + 2, 1)
            if step:
                put(1, a, 1), put(1, b, -1), put(1, a + 2, tau, 1)
                right[4 * i + 1][0] = self.d * step
                continue
            # the same wall: the change of z - x, divided by the duration
            put(1, a + 2, 1)
            short = not part.lower() > (0 if thin else SHORT)
            span = (arb(0)).union(tau) if short else tau
            over = self.free(span)
            bends = [
                self.forced(over, here, self.wave(T * starts[i] + span)[k])
                for k, (here, _) in enumerate(waves)
            ]
            places = [
                (a, free[0] - 1, -w, -over[1], -over[2]),
                (a + 1, w, y, over[2], -2 * self.xi * over[2] - over[1]),
            ]
            for place, value, slope, first, second in places:
                put(
                    1,
                    place,
                    *(-one for one in self.divided(tau, short, value, first, slope, second)),
                )
            for k, ((x, _), (_, v)) in enumerate(zip(forced, bends, strict=True)):
                H, H_tau = self.divided(tau, short, x[0], v[0], x[1], v[1])
                H_t = self.divided(tau, short, x[2], v[2])[0]
                put(1, 3 * n + k, -H, -H_tau, -H_t)
        layers = [arb_mat(layer) for layer in rows]
        return layers[0], arb_mat(right), layers[1:]

    @staticmethod
    def divided(tau, short, value, first, slope=None, second=None):
        """value/tau and its derivative, from the range of the first and second derivative where tau is short."""
        found = [first, None if second is None else second / 2]
        if tau > 0:
            quotients = [value / tau, None if slope is None else (slope - value / tau) / tau]
            pairs = zip(quotients, found, strict=True)
            found = [
                one if not short or one is None else one.intersection(two) for one, two in pairs
            ]
        return found

    def impossible(self, times):
        """Whether a flight would be shorter than it can be."""
        parts = [*times, 1 - sum(times, arb(0))]
        ends = zip(self.sides, [*self.sides[1:], self.sides[0]], strict=True)
        return any(
            part < (self.shortest if one != two else 0)
            for part, (one, two) in zip(parts, ends, strict=True)
        )

    def enclosed(self, box):
        """The unknowns of the linear laws in a box; None if there are none. ZeroDivisionError if singular."""
        n, times = self.n, box[: self.n - 1]
        middle = [one.mid() for one in times]
        matrix, right, _ = self.laws(middle)
        rows, given, size = matrix.tolist(), [], 3 * n + 2
        if len(box) == n:
            given, size = [box[-1].sin(), box[-1].cos()], 3 * n
        # columns beside the matrix whose unknowns must vanish
        thin = arb_mat([[one.mid() for one in row[:size]] for row in rows])
        across = thin.transpose()
        left = (thin * (across * thin).inv() * across).mid().tolist()
        left = [
            [arb(int(i == j)) - one.mid() for j, one in enumerate(row)]
            for i, row in enumerate(left)
        ]
        columns = []
        for _ in range(4 * n - size):
            best = max(range(4 * n), key=lambda k: float(left[k][k]))
            column = [row[best] for row in left]
            columns.append([one.mid() for one in column])
            left = [
                [(one - column[i] * column[j] / column[best]).mid() for j, one in enumerate(row)]
                for i, row in enumerate(left)
            ]
        square = arb_mat(
            [[*row[:size], *(one[i] for one in columns)] for i, row in enumerate(rows)]
        )
        inverse = arb_mat([[one.mid() for one in row] for row in square.tolist()]).inv().mid()
        # the times are the same in all entries of a product with the derivatives
        whole = inverse * matrix
        for slope, one, place in zip(self.laws(times)[2], times, middle, strict=True):
            whole = whole + inverse * slope * (one - place)
        rows, rest, right = whole.tolist(), (inverse * square).tolist(), inverse * right
        if given:
            right = right - arb_mat([row[size:] for row in rows]) * arb_mat(
                [[one] for one in given]
            )
        rows = [[*row[:size], *other[size:]] for row, other in zip(rows, rest, strict=True)]
        found = arb_mat(rows).solve(right, algorithm="lu").entries()
        found, known = found[:size] + [arb(0)] * len(columns), right.entries()
        if not given:
            if not all(one.overlaps(UNIT) for one in found[size - 2 : size]):
                return None
            found[size - 2 : size] = [one.intersection(UNIT) for one in found[size - 2 : size]]
        for _ in range(3):
            for i, row in enumerate(rows):
                image = known[i] - sum(
                    ((one - int(j == i)) * found[j] for j, one in enumerate(row)), arb(0)
                )
                if not image.overlaps(found[i]):
                    return None
                found[i] = found[i].intersection(image)
        return [*found[:size], *given]

    def step(self, box, values, single=False):
        """The interval Newton step for a box and the unknowns of its linear laws, by slopes from its centre, which
        leave out no solution; with `single` by derivatives, so that there is at most one."""
        n, times = self.n, box[: self.n - 1]
        matrix, _, slopes = self.laws(times)
        column = arb_mat([[one] for one in values])
        along = [(slope * column).entries() for slope in slopes]
        middle = [one.mid() for one in times]
        known, (p, q) = [one.mid() for one in values], values[-2:]
        thin, right, _ = self.laws(middle)
        # M(u) y - M(m) z = (M(u) - M(m)) y + M(m) (y - z)
        last = (matrix if single else thin).tolist()
        rows = [[*(one[i] for one in along), *row] for i, row in enumerate(last)]
        if len(box) == n:
            known[-2:] = [box[-1].mid().sin(), box[-1].mid().cos()]
            rows = [[*row[:-2], q * row[-2] - p * row[-1]] for row in rows]
        left = (thin * arb_mat([[one] for one in known]) - right).entries()
        if len(box) < n:
            rows.append([arb(0)] * (len(rows[0]) - 2) + [2 * p, 2 * q])
            left.append(known[-2] * known[-2] + known[-1] * known[-1] - 1)
        found = arb_mat(rows).solve(arb_mat([[one] for one in left]), algorithm="precond").entries()
        unknowns = [*times, *values] if len(box) < n else [*times, *values[:-2], box[-1]]
        return unknowns, [one.mid() - move for one, move in zip(unknowns, found, strict=True)]

    def left(self, box, known):
        """A part of a box with all of its motions that are not known, and whether the linear laws may be singular;
        None if there are none."""
        for _ in range(8):
            if self.impossible(box[: self.n - 1]):
                return None, False
            try:
                values = self.enclosed(box)
            except ZeroDivisionError:
                return box, True
            if values is None or self.refuted(values):
                return None, False
            try:
                old, new = self.step(box, values)
            except ZeroDivisionError:
                return box, False
            if not all(one.overlaps(two) for one, two in zip(old, new, strict=True)):
                return None, False
            inner = all(one.contains_interior(two) for one, two in zip(old, new, strict=True))
            # at most one solution is in it
            wide = [one + UNIT * one.rad() / 4 for one in box]
            if any(lies(one, wide, self.n) for one in known) and self.single(wide):
                return None, False
            others = [one[0] for one in known]
            others += [[low.union(high) for low, high in gap] for gap in self.exempt]
            near = any(all(a.overlaps(b) for a, b in zip(box, one, strict=False)) for one in others)
            need(
                near or not inner or not self.approaching(values),
                "a motion is not in the certificate",
            )
            both = [one.intersection(two) for one, two in zip(old, new, strict=True)]
            before, box = box, both[: self.n - 1] + (both[-1:] if len(box) == self.n else [])
            if (
                max(float(one.rad() / two.rad()) for one, two in zip(box, before, strict=True))
                > 0.6
            ):
                break
        return box, False

    def single(self, box):
        """Whether there is at most one solution in a box."""
        try:
            values = self.enclosed(box)
            return values is None or bool(self.step(box, values, single=True))
        except ZeroDivisionError:
            return False

    def speeds(self, values):
        """The push that each impact gives to the walled mass, on its side."""
        flights = values[2 : 3 * self.n : 3]
        return [side * (flights[i - 1] - flights[i]) for i, side in enumerate(self.sides)]

    def refuted(self, values):
        """Whether p^2 + q^2 is not 1, or an impact is met from the wrong side."""
        p, q = values[-2:]
        return not (p * p + q * q).contains(1) or any(one < 0 for one in self.speeds(values))

    def approaching(self, values):
        """Whether all impacts are met from the right side."""
        return all(one > 0 for one in self.speeds(values))


def lies(one, box, n):
    """Whether the motion with some times and theta lies in a box."""
    times, theta = one
    if not all(wide.contains(part) for wide, part in zip(box, times, strict=False)):
        return False
    return len(box) < n or any(box[-1].contains(theta + 2 * arb.pi() * k) for k in range(-3, 4))


def check_others(pair, motions, exempt):
    """Check that a word has no other motions than these, given by their states, with times outside of the boxes
    that are exempt."""
    known = []
    for states in motions:
        phases = [ball(one[0]) for one in states]
        times = [(two - one) / pair.length for one, two in pairwise(phases)]
        known.append((times, phases[0] + arb.atan2(pair.b, pair.a)))
    for k, (times, theta) in enumerate(known):
        for before, other in known[:k]:
            apart = not all(one.overlaps(two) for one, two in zip(times, before, strict=True))
            turns = (theta + 2 * arb.pi() * j for j in range(-3, 4))
            need(apart or not any(one.overlaps(other) for one in turns), "a motion is there twice")
    word, count = Word(pair, exempt), 0
    boxes = [[(UNIT + 1) / 2] * (word.n - 1)]
    while boxes:
        count += 1
        need(count < MOST, "too many boxes of times")
        box, singular = word.left(boxes.pop(), known)
        if box is None or any(
            all(one >= low and one <= high for one, (low, high) in zip(box, gap, strict=False))
            for gap in exempt
        ):
            continue
        widths = [float(one.rad()) for one in box]
        if len(box) == word.n:
            widths[-1] /= 128
        elif singular and max(widths) < NEARLY:
            box, widths = [*box, UNIT * arb.pi()], [*widths, 1.0]
        need(max(widths) > NARROWEST, f"other motions are not excluded near times {box}")
        place = widths.index(max(widths))
        middle = box[place].mid()
        for end in (box[place].lower(), box[place].upper()):
            boxes.append([middle.union(end) if k == place else one for k, one in enumerate(box)])


def check_all(data, pair_of, check_box):
    """Check a certificate of all motions at a point, word by word."""
    sheets, walls = data["sheets"], dict(zip("RL", data["system"]["restitution"], strict=True))
    need(data["sides"] == ", ".join(one["sides"] for one in sheets), "the words of all sheets")
    need(
        sheets and data["cycles"] == max(one["cycles"] for one in sheets),
        "the cycles of all sheets",
    )
    need(
        all(box["sheet"] in range(len(sheets)) for box in data["boxes"]), "the word of each motion"
    )
    for number_, sheet in enumerate(sheets):
        system = data["system"] | {"restitution": [walls[side] for side in sheet["sides"]]}
        word = {**data, **sheet, "kind": "motion", "symmetric": False, "system": system}
        own = [box for box in data["boxes"] if box["sheet"] == number_]
        need(all(box["parameters"] == {} for box in own), "motions at one point")
        states = [check_box(word, box) for box in own]
        need(None not in states, "motions that exist")
        gaps = [item["times"] for item in data["undecided"] if item.get("sheet") == number_]
        with ctx.workprec(BITS):
            exempt = [[[number(exact(end)) for end in ends] for ends in gap] for gap in gaps]
            check_others(pair_of(word, {"parameters": {}}), states, exempt)
