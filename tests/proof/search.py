"""Check that a certificate lists all motions of a word (a part of check_certificate.py).

Given the times of the impacts, the laws are linear in the approach speeds e >= 0 of the impacts, the velocity of
the free mass in the first flight, and p = sin(theta), q = cos(theta) of the steady motion A sin(r t + theta), with
p^2 + q^2 = 1: an impact changes the velocity of the primary mass by mu (1 + R) e/(1 + mu), and x is the sum of the
steady motion and the periodic responses to these velocity jumps. Boxes of these times, as fractions of the period,
are halved until the laws contradict each other in them, or they contain at most one motion, which is known. Where
the linear equations are singular, theta is halved, too. Lengths are in units of A.
"""

from itertools import pairwise

from flint import arb, arb_mat, ctx
from series import UNIT, ball, exact, need, number

#: Precision in bits, largest number of boxes of a word, and width below which a box is given up.
BITS, MOST, NARROWEST = 96, 400_000, 2.0**-36
#: Parts of the period and times below which derivatives are used in place of quotients, or theta is halved.
SHORT, NEARLY = 0.25, 2.0**-8


class Word:
    """The equations of a word at a point, for boxes of times."""

    def __init__(self, pair, exempt):
        self.exempt = exempt
        self.n, self.sides, self.R = len(pair.sides), pair.sides, pair.R
        self.xi, self.mu, self.r, self.nu = pair.xi, pair.mu, pair.r, pair.nu
        self.T = pair.length / pair.r
        self.d = pair.d / pair.A
        # each impact dissipates mu (1 - R^2) e^2/(2 (1 + mu)); the load supplies at most f^2 T/(16 xi)
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
        self.speeds = arb(0).union(e.upper() / pair.A)
        # the periodic response to unit impulses: the state after one is that a period later plus the impulse
        u, w, y = self.free(self.T)
        below = (1 - u) * (1 - y) + w * w
        self.first = w / below, (1 - u) / below
        #: Change of the velocity of the free mass at an impact with the approach speed 1.
        self.turns = [
            side * (1 + R) / (1 + self.mu) for side, R in zip(self.sides, self.R, strict=True)
        ]

    def free(self, t):
        """u, w, y of a free vibration: x = u x_0 + w x'_0, x' = -w x_0 + y x'_0."""
        decay, sine, cosine = (-self.xi * t).exp(), (self.nu * t).sin(), (self.nu * t).cos()
        w, c = decay * sine / self.nu, decay * cosine
        return c + self.xi * w, w, c - self.xi * w

    def pushed(self, t):
        """x at a time after a unit impulse in each period, with two derivatives."""
        (u, w, y), (x, v) = self.free(t), self.first
        moved, speed = u * x + w * v, y * v - w * x
        return moved, speed, -2 * self.xi * speed - moved

    def by_p(self, t):
        """The factor of p in the steady motion at a time after the first impact, with two derivatives."""
        s, c, r = (self.r * t).sin(), (self.r * t).cos(), self.r
        return c, -r * s, -r * r * c

    def by_q(self, t):
        """The factor of q."""
        s, c, r = (self.r * t).sin(), (self.r * t).cos(), self.r
        return s, r * c, -r * r * s

    def since(self, j, flights, u):
        """The total time of some flights from impact j on, and its derivatives with respect to u."""
        m, passed = self.n - 1, [(j + k) % self.n for k in range(flights)]
        rest = [k for k in range(m) if k not in passed]
        if m in passed:
            part, signs = 1 - sum((u[k] for k in rest), arb(0)), [-int(k in rest) for k in range(m)]
        else:
            part, signs = (
                sum((u[k] for k in passed), arb(0)),
                [int(k in passed) for k in range(m)],
            )
        return self.T * part, [self.T * sign for sign in signs]

    def laws(self, u):
        """The matrix of the equations, the right side, and the derivatives of the matrix by each u."""
        n, size, thin = self.n, self.n + 3, all(one.rad() == 0 for one in u)
        rows = [[[arb(0)] * size for _ in range(2 * n + 1)] for _ in range(n)]
        right = [[arb(0)] for _ in range(2 * n + 1)]

        def put(row, place, value, slopes=()):
            rows[0][row][place] += value
            for layer, slope in zip(rows[1:], slopes, strict=False):
                layer[row][place] += slope

        def free_mass(row, i, value, slopes=()):
            """The velocity of the free mass in flight i."""
            put(row, n, value, slopes)
            for j in range(1, i + 1):
                put(row, j, -value * self.turns[j], [-one * self.turns[j] for one in slopes])

        for i in range(n):
            # flight i: W - x' = s e at its end, and the change of x is W tau - the change of s d/2
            after, (tau, lasting) = (i + 1) % n, self.since(i, 1, u)
            same, flight = self.sides[i] == self.sides[after], n + i
            short = same and not tau.lower() > (0 if thin else self.T * SHORT)
            right[flight][0] = self.d * ((self.sides[i] - self.sides[after]) // 2)
            put(i, after, -self.sides[after])
            free_mass(i, i, 1)
            free_mass(flight, i, *((-1,) if same else (-tau, [-one for one in lasting])))
            sources = [(j, j, self.mu * turn, self.pushed) for j, turn in enumerate(self.turns)]
            sources += [(n + 1, 0, 1, self.by_p), (n + 2, 0, 1, self.by_q)]
            for place, j, factor, motion in sources:
                passed = (i - j) % n
                (begin, before), (end, later) = (self.since(j, passed + k, u) for k in (0, 1))
                (x, v, _), (x1, v1, a1) = motion(begin), motion(end)
                put(i, place, -factor * v1, [-factor * a1 * one for one in later])
                value, by_end, by_begin = x1 - x, v1, v1 - v
                if same:
                    # divided by the duration
                    _, v2, a2 = motion(begin + arb(0).union(tau)) if short else (0, arb(0), arb(0))
                    value, by_end = self.divided(tau, short, value, v2, by_end, a2)
                    by_begin = self.divided(tau, short, by_begin, a2)[0]
                slopes = [by_end * a + by_begin * b for a, b in zip(lasting, before, strict=True)]
                put(flight, place, factor * value, [factor * one for one in slopes])
        for j, turn in enumerate(self.turns):
            put(2 * n, j, turn)
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
        """Whether a flight would be shorter than possible."""
        parts = [*times, 1 - sum(times, arb(0))]
        ends = zip(self.sides, [*self.sides[1:], self.sides[0]], strict=True)
        return any(
            part < (self.shortest if one != two else 0)
            for part, (one, two) in zip(parts, ends, strict=True)
        )

    def enclosed(self, box):
        """The unknowns of the linear equations in a box; None if there are none. ZeroDivisionError if singular."""
        n, times = self.n, box[: self.n - 1]
        middle = [one.mid() for one in times]
        matrix, right, _ = self.laws(middle)
        rows, given, size = matrix.tolist(), [], n + 3
        if len(box) == n:
            given, size = [box[-1].sin(), box[-1].cos()], n + 1
        # columns beside the matrix whose unknowns must vanish
        thin = arb_mat([[one.mid() for one in row[:size]] for row in rows])
        across = thin.transpose()
        left = (thin * (across * thin).inv() * across).mid().tolist()
        left = [
            [arb(int(i == j)) - one.mid() for j, one in enumerate(row)]
            for i, row in enumerate(left)
        ]
        columns = []
        for _ in range(2 * n + 1 - size):
            best = max(range(2 * n + 1), key=lambda k: float(left[k][k]))
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
        if not all(one.overlaps(self.speeds) for one in found[:n]):
            return None
        found[:n] = [one.intersection(self.speeds) for one in found[:n]]
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
        """The unknowns in a box, their centre, and the equations of Newton's step from there, multiplied by an
        approximate inverse: slopes from the centre, which leave out no solution, or with `single` slopes between
        any two places, and the right side."""
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
        unknowns, centre = [*times, *values], [*middle, *known]
        if len(box) == n:
            unknowns[-2:], centre[-2:] = [box[-1]], [box[-1].mid()]
            known[-2:] = [centre[-1].sin(), centre[-1].cos()]
            rows = [[*row[:-2], q * row[-2] - p * row[-1]] for row in rows]
        left = (right - thin * arb_mat([[one] for one in known])).entries()
        if len(box) < n:
            pairs = zip((p, q), known[-2:], strict=True)
            both = [one + (one if single else two) for one, two in pairs]
            rows.append([arb(0)] * (len(rows[0]) - 2) + both)
            left.append(1 - known[-2] * known[-2] - known[-1] * known[-1])
        rows = arb_mat(rows)
        inverse = arb_mat([[one.mid() for one in row] for row in rows.tolist()]).inv().mid()
        return unknowns, centre, inverse * rows, inverse * arb_mat([[one] for one in left])

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
                old, centre, matrix, right = self.step(box, values)
            except ZeroDivisionError:
                return box, False
            # each equation bounds the unknown of its row
            new, inner, rows, right = [*old], True, matrix.tolist(), right.entries()
            for i, row in enumerate(rows):
                if row[i].contains(0):
                    inner = False
                    continue
                rest = sum(
                    (one * (new[j] - centre[j]) for j, one in enumerate(row) if j != i), arb(0)
                )
                image = centre[i] + (right[i] - rest) / row[i]
                if not image.overlaps(new[i]):
                    return None, False
                inner = inner and old[i].contains_interior(image)
                new[i] = new[i].intersection(image)
            # it contains at most one solution
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
            before, box = box, new[: self.n - 1] + (new[-1:] if len(box) == self.n else [])
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
            # regular
            return values is None or self.step(box, values, single=True)[2].inv() is not None
        except ZeroDivisionError:
            return False

    def refuted(self, values):
        """Whether p^2 + q^2 is not 1."""
        p, q = values[-2:]
        return not (p * p + q * q).contains(1)

    def approaching(self, values):
        """Whether all impacts have an approach speed."""
        return all(one > 0 for one in values[: self.n])


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
        pair = pair_of(word, {"parameters": {}})
        # the search excludes motions without approach, so such a motion accounts for no box of times
        states = [one for one in states if all(speed > 0 for speed in pair.approach(one))]
        gaps = [item["times"] for item in data["undecided"] if item.get("sheet") == number_]
        with ctx.workprec(BITS):
            exempt = [[[number(exact(end)) for end in ends] for ends in gap] for gap in gaps]
            check_others(pair_of(word, {"parameters": {}}), states, exempt)
