"""Check certificates of motions of structures (a part of check_certificate.py), from the laws of mechanics:

between impacts   M q'' + C q' + K q = f(t)
at an impact      G q = e, G q' is turned and multiplied by R, M q' changes along G alone
"""

from flight import closes
from flint import arb, arb_mat, arb_poly, ctx
from series import flat, need, number

#: Precision in bits, and number of times an interval of time may be halved.
BITS, MOST_HALVINGS = 320, 60


class System:
    """The equations of a certificate."""

    def __init__(self, data):
        system, self.cycles = data["system"], data["cycles"]
        directions = [gap["direction"] for gap in system["gaps"]]
        names = ("mass", "damping", "stiffness", "sine", "cosine")
        lists = [system["constant"], *directions, *(system[name] for name in names)]
        lists += [row for name in names for row in system[name]]
        need(all(isinstance(one, list) for one in lists), "lists of numbers")
        rows = lambda name: [[number(one) for one in row] for row in system[name]]  # noqa: E731
        self.M, self.C, self.K = (arb_mat(rows(name)) for name in ("mass", "damping", "stiffness"))
        self.n = n = self.M.nrows()
        need(all(one.nrows() == one.ncols() == n for one in (self.M, self.C, self.K)), "n by n")
        self.sine, self.cosine = rows("sine"), rows("cosine")
        need(len(self.sine) == len(self.cosine), "harmonics")
        self.constant = [number(one) for one in system["constant"]]
        loads = [*self.sine, *self.cosine, self.constant]
        need(all(len(row) == n for row in loads), "n loads")
        self.W = number(system["frequency"])
        need(self.W > 0, "a frequency")
        self.gaps = []
        for gap in system["gaps"]:
            G, R = [number(one) for one in gap["direction"]], number(gap["restitution"])
            need(len(G) == n and R > 0 and R <= 1, "n directions and 0 < R <= 1")
            self.gaps.append((arb_mat([G]), number(gap["opening"]), R))
        self.impacts = system["impacts"]
        need(self.impacts and all(type(one) is int for one in self.impacts), "impacts")
        need(all(0 <= one < len(self.gaps) for one in self.impacts), "impacts on gaps")
        need(data["sides"] == " ".join(map(str, self.impacts)), "the gaps of the impacts")
        self.period = 2 * arb.pi() * self.cycles / self.W
        self.size = 2 * n + 1
        harmonics = len(self.sine)
        self.A = arb_mat(2 * n + 1 + 2 * harmonics, 2 * n + 1 + 2 * harmonics)
        # columns of z = (q, q', 1, cos W t, sin W t, ...)
        for k in range(2 * n + 1 + 2 * harmonics):
            z = [arb(int(k == j)) for j in range(2 * n + 1 + 2 * harmonics)]
            q, v, force = column(z[:n]), column(z[n : 2 * n]), column(self.force(z[2 * n :]))
            a = self.M.solve(force - self.C * v - self.K * q).entries()
            turned = [arb(0)]
            for h in range(harmonics):
                c, s = z[2 * n + 1 + 2 * h : 2 * n + 3 + 2 * h]
                turned += [-s * self.W * (h + 1), c * self.W * (h + 1)]
            for j, value in enumerate([*z[n : 2 * n], *a, *turned]):
                self.A[j, k] = value

    def force(self, turns):
        """The load from (1, cos, sin, ...)."""
        total = [one * turns[0] for one in self.constant]
        for h, (sine, cosine) in enumerate(zip(self.sine, self.cosine, strict=True)):
            c, s = turns[1 + 2 * h : 3 + 2 * h]
            total = [t + s * a + c * b for t, a, b in zip(total, sine, cosine, strict=True)]
        return total

    def start(self, state):
        """z at an impact."""
        turns = [arb(1)]
        for h in range(1, len(self.sine) + 1):
            turns += [(state[0] * self.W * h).cos(), (state[0] * self.W * h).sin()]
        return column([*state[1:], *turns])

    def hit(self, gap, v):
        """Velocities after an impact with the velocities v before it."""
        G, _, R = self.gaps[gap]
        push = self.M.solve(G.transpose())
        return v - push * ((G * v)[0, 0] * (1 + R) / (G * push)[0, 0])

    def flights(self, states):
        """For each flight: the states at its ends, its duration and the number of the next flight."""
        for i, state in enumerate(states):
            j = (i + 1) % len(states)
            tau = states[j][0] + (self.period if j == 0 else arb(0)) - state[0]
            z = self.start(state)
            flow = (self.A * tau).exp()
            yield i, j, z, flow, flow * z, tau

    def laws(self, states):
        """The residuals of the equations."""
        left, n = [], self.n
        for _, j, _, _, end, _ in self.flights(states):
            q, v = column(end.entries()[:n]), column(end.entries()[n : 2 * n])
            gap = self.impacts[j]
            after = [*q.entries(), *self.hit(gap, v).entries()]
            left += [one - two for one, two in zip(after, states[j][1:], strict=True)]
            left.append((self.gaps[gap][0] * q)[0, 0] - self.gaps[gap][1])
        return left

    def blocks(self, states):
        """Derivatives of the laws of each flight with respect to the unknowns at its beginning and at its end."""
        n, found = self.n, []
        for _, j, z, flow, end, _ in self.flights(states):
            gap = self.impacts[j]
            moved = (self.A * z).entries()[: 2 * n]
            rest = [arb(0)] * (self.A.nrows() - 2 * n)
            # a later start at the same state; the load advances independently
            columns = [(flow * column([-one for one in moved] + rest)).entries()]
            columns += [[flow[k, m] for k in range(2 * n)] for m in range(2 * n)]
            columns.append((self.A * end).entries())
            values = []
            for one in columns:
                q, v = column(one[:n]), column(one[n : 2 * n])
                values.append(
                    [*q.entries(), *self.hit(gap, v).entries(), (self.gaps[gap][0] * q)[0, 0]]
                )
            there = [values.pop()]
            there += [[arb(-1 if k == m else 0) for k in range(self.size)] for m in range(2 * n)]
            found.append((arb_mat(values).transpose(), arb_mat(there).transpose()))
        return found

    def newton(self, centre, around):
        """The interval Newton step."""
        size, n = self.size, len(centre)
        matrix = arb_mat(size * n, size * n)
        for i, (here, there) in enumerate(self.blocks(around)):
            for k in range(size):
                for m in range(size):
                    matrix[size * i + k, size * i + m] += here[k, m]
                    matrix[size * i + k, size * ((i + 1) % n) + m] += there[k, m]
        inverse = matrix.mid().inv().mid()
        return (inverse * matrix).solve(inverse * column(self.laws(centre))).entries()

    def enclosure(self, box):
        """The states of the only motion in a box."""
        texts, radii = flat(box["centre"]), [number(one) for one in flat(box["radius"])]
        count, size = len(self.impacts), self.size
        need(len(box["centre"]) == len(box["radius"]) == count, "all impacts")
        need(all(len(row) == size for row in box["centre"] + box["radius"]), "all unknowns")
        need(all(len(one) == 1 for one in texts), "numbers")
        centre = [number(one[0]) for one in texts]
        rows = lambda values: [values[k : k + size] for k in range(0, size * count, size)]  # noqa: E731
        around = [one + arb(0, 1) * radius for one, radius in zip(centre, radii, strict=True)]
        step = self.newton(rows(centre), rows(around))
        need(
            all(abs(one) < radius for one, radius in zip(step, radii, strict=True)), "Newton's step"
        )
        for _ in range(4):
            around = [a - b for a, b in zip(centre, step, strict=True)]
            step = self.newton(rows(centre), rows(around))
        return rows([a - b for a, b in zip(centre, step, strict=True)])


def column(values):
    """A column of numbers."""
    return arb_mat([[one] for one in values])


def check_gaps(system, states, verdict):
    """Check the verdict on the gaps."""
    n, closed, flights = system.n, False, list(system.flights(states))
    speeds = []
    for _, j, _, _, end, _ in flights:
        G = system.gaps[system.impacts[j]][0]
        speeds.append((G * column(end.entries()[n : 2 * n]))[0, 0])
    if verdict is None:
        return
    need(verdict is False or all(one > 0 for one in speeds), "an impact has no approach speed")
    if verdict is False and any(one < 0 for one in speeds):
        return
    for i, j, z, _, _, tau in flights:
        for number_, (G, e, _) in enumerate(system.gaps):
            first, last = number_ == system.impacts[i], number_ == system.impacts[j]
            if verdict is False:

                def at(t, G=G, e=e, z=z):
                    moved = ((system.A * t).exp() * z).entries()
                    q, v = column(moved[:n]), column(moved[n : 2 * n])
                    return e - (G * q)[0, 0], (G * v)[0, 0]

                closed = closed or closes(at, tau)
                continue
            pieces = [(arb(0), arb(tau.upper()), 0)]
            while pieces:
                low, high, depth = pieces.pop()
                t = low.union(high)
                z_mid = (system.A * t.mid()).exp() * z
                wide = ((system.A * (t - t.mid())).exp() * z_mid).entries()
                rate = -(G * column(wide[n : 2 * n]))[0, 0]
                # the mean value theorem
                distance = e - (G * column(z_mid.entries()[:n]))[0, 0] + rate * (t - t.mid())
                if distance > 0 or (first and low == 0 and rate > 0):
                    continue
                if last and not high < tau and rate < 0:
                    continue
                need(depth < MOST_HALVINGS, "a gap may close")
                middle = ((low + high) / 2).mid()
                pieces += [(low, middle, depth + 1), (middle, high, depth + 1)]
    need(verdict or closed, "no gap is proven to close")


def hurwitz(polynomial):
    """The first coefficient and Hurwitz's determinants: positive where all zeros lie inside the unit circle.

    Where one is negative, a zero lies outside, because none is negative for polynomials with all zeros inside or
    on the unit circle.
    """
    m = len(polynomial) - 1
    plus, minus = arb_poly([1, 1]), arb_poly([1, -1])
    turned = sum(
        (plus ** (m - k) * minus**k * one for k, one in enumerate(polynomial)), arb_poly([0])
    )
    a = [turned[m - k] for k in range(m + 1)]
    entry = lambda i, j: a[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= m else arb(0)  # noqa: E731
    minors = [
        arb_mat([[entry(i, j) for j in range(k)] for i in range(k)]).det() for k in range(1, m + 1)
    ]
    return [a[0], *minors]


def check_multipliers(system, states, box):
    """Check the verdict on stability and the bound of the multipliers."""
    stable, bounds = box["stable"], [box[f"multipliers_{key}"] for key in ("below", "above")]
    need(stable is True or bounds[0] is None, "a bound from above for a stable motion")
    need(stable is False or bounds[1] is None, "a bound from below for an unstable motion")
    if stable is None:
        return
    bound = number(bounds[0 if stable else 1] or "1")
    need(0 < bound <= 1 if stable else bound >= 1, "the bound does not imply the verdict")
    size = system.size
    matrix = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
    for here, there in system.blocks(states):
        # the last law, the contact, gives the time; the others the state after it
        matrix = there.solve(here * matrix) * -1
    last = (-system.M.solve(system.C).trace() * system.period).exp()
    for gap in system.impacts:
        last = last * system.gaps[gap][2] ** 2
    # positions after an impact are on the gap, so one eigenvalue is 0; the product of the others is known
    coefficients = matrix.charpoly().coeffs()[:0:-1]
    coefficients[-1] = last
    values = hurwitz([one * bound**-k for k, one in enumerate(coefficients)])
    holds = all(one > 0 for one in values) if stable else any(one < 0 for one in values)
    need(holds, "the bound of the multipliers is not proven")


def check_structure(data):
    """Raise RejectedError unless all statements of a certificate of a structure are proven here, too."""
    with ctx.workprec(BITS):
        check_statements(data)


def check_statements(data):
    """The same with the given precision."""
    system = System(data)
    need(len(data["boxes"]) == 1, "one box")
    for box in data["boxes"]:
        need(box["exists"] is True and box["parameters"] == {}, "a motion")
        need(box["attenuation_below"] is None, "no bound of the amplitude")
        states = system.enclosure(box)
        need(all(one[5] > 0 for one in system.flights(states)), "impacts in time")
        check_gaps(system, states, box["admissible"])
        check_multipliers(system, states, box)
