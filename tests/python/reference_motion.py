"""Periodic motions of the vibroimpact oscillator with 50 digits, from Newton's law.

A motion found by the package is solved again: every flight has to end at the next impact,
with the velocity required by momentum and restitution. Then the map from each impact to the next
is differentiated, with steps of 1e-20, and the multipliers are the eigenvalues of the product.
"""

import mpmath as mp
from mpmath import mpf

DIGITS = 50
STEP = mpf(10) ** -20


def flight(xi, r, amplitude, theta, x, v, t):
    """Position and velocity of M a time t after it was at x with velocity v; the forced motion is A sin(theta)."""
    eta = mp.sqrt(1 - xi**2)
    a, b = x - amplitude * mp.sin(theta), v - amplitude * r * mp.cos(theta)
    shrink, sine, cosine = mp.exp(-xi * t), mp.sin(eta * t) / eta, mp.cos(eta * t)
    end = theta + r * t
    return (
        shrink * (a * (cosine + xi * sine) + b * sine) + amplitude * mp.sin(end),
        shrink * (b * (cosine - xi * sine) - a * sine) + amplitude * r * mp.cos(end),
    )


class ReferenceMotion:
    """The exact motion near a motion of the package."""

    def __init__(self, motion, **changes):
        """Solve its equations, with changes of r, clearance, xi, mu, R1, R2 or load."""
        osc, self.sides = motion.osc, [int(side) for side in motion.pattern.signs]
        by = dict.fromkeys(("r", "clearance", "xi", "mu", "R1", "R2", "load"), mpf(0)) | changes
        self.xi, self.mu, self.r = osc.xi + by["xi"], osc.mu + by["mu"], motion.r + by["r"]
        self.rest = [
            float(value) + by["R1" if side > 0 else "R2"]
            for value, side in zip(motion.restitution, self.sides, strict=True)
        ]
        self.half = [side * (motion.clearance + by["clearance"]) / 2 for side in self.sides]
        self.turn = 2 * mp.pi * motion.pattern.cycles
        self.n = len(self.half)
        self.amplitude = (motion.load + by["load"]) / mp.sqrt(
            (1 - self.r**2) ** 2 + (2 * self.xi * self.r) ** 2
        )
        start = [*motion.X, *(motion.alpha + motion.tau)]
        self.u = self.solved([mpf(float(value)) for value in start])

    def speeds(self, u):
        """Durations, velocities of M before and after, and of the free mass after, at each impact."""
        n = self.n
        x, theta = u[:n], u[n:]
        z = [x[i] + self.half[i] for i in range(n)]
        time = [
            (theta[(i + 1) % n] - theta[i] + (self.turn if i == n - 1 else 0)) / self.r
            for i in range(n)
        ]
        w = [(z[(i + 1) % n] - z[i]) / time[i] for i in range(n)]
        before, after = [], []
        for i in range(n):
            # v' - v = mu (w_before - w_after),  v' - w_after = -R (v - w_before)
            change = self.mu * (w[i - 1] - w[i])
            v = (w[i] + self.rest[i] * w[i - 1] - change) / (1 + self.rest[i])
            before.append(v)
            after.append(v + change)
        return time, before, after, w

    def residual(self, u):
        """The state at the end of each flight minus the state that the next impact requires."""
        n = self.n
        time, before, after, _ = self.speeds(u)
        place, speed = [], []
        for i in range(n):
            x, v = flight(self.xi, self.r, self.amplitude, u[n + i], u[i], after[i], time[i])
            place.append(x - u[(i + 1) % n])
            speed.append(v - before[(i + 1) % n])
        return place + speed

    def solved(self, u):
        """Newton's method with difference quotients in 50 digits."""
        m = 2 * self.n
        for _ in range(200):
            f = self.residual(u)
            jacobian = mp.matrix(m, m)
            for j in range(m):
                moved = [value + (STEP if i == j else 0) for i, value in enumerate(u)]
                for i, value in enumerate(self.residual(moved)):
                    jacobian[i, j] = (value - f[i]) / STEP
            step = mp.lu_solve(jacobian, mp.matrix(f))
            u = [value - step[i] for i, value in enumerate(u)]
            if max(abs(value) for value in step) < mpf(10) ** -30:
                return u
        raise ArithmeticError("no motion here")

    def following(self, i, state, time):
        """State (x, v, w, theta) after impact i + 1 as a function of the one after impact i."""
        x, v, w, theta = state
        j = (i + 1) % self.n
        gap = self.half[j] - self.half[i]
        for _ in range(60):
            x1, v1 = flight(self.xi, self.r, self.amplitude, theta, x, v, time)
            step = (w * time - (x1 - x) - gap) / (w - v1)
            time -= step
            if abs(step) < mpf(10) ** -45:
                break
        x1, v1 = flight(self.xi, self.r, self.amplitude, theta, x, v, time)
        centre = (v1 + self.mu * w) / (1 + self.mu)
        apart = -self.rest[j] * (v1 - w)
        return [
            x1,
            centre + self.mu * apart / (1 + self.mu),
            centre - apart / (1 + self.mu),
            theta + self.r * time,
        ]

    def turns(self, i, speed):
        """Times after impact i at which M has a given velocity, before the next impact."""
        time, _, after, _ = self.speeds(self.u)

        def excess(t):
            x, theta = self.u[i], self.u[self.n + i]
            return flight(self.xi, self.r, self.amplitude, theta, x, after[i], t)[1] - speed

        grid = [time[i] * k / 200 for k in range(201)]
        sizes = [excess(t) for t in grid]
        for k in range(200):
            if sizes[k] * sizes[k + 1] < 0:
                yield mp.findroot(excess, (grid[k], grid[k + 1]), solver="anderson")

    def place(self, i, t):
        """Position of M a time t after impact i."""
        after, x, theta = self.speeds(self.u)[2], self.u[i], self.u[self.n + i]
        return flight(self.xi, self.r, self.amplitude, theta, x, after[i], t)[0]

    def quantities(self):
        """The quantities that `Motion.gradient` differentiates, by name; the multipliers in any order."""
        n, u = self.n, self.u
        _, before, after, w = self.speeds(u)
        arrivals = [w[i - 1] for i in range(n)]
        lag = mp.atan2(2 * self.xi * self.r, 1 - self.r**2)
        square, fundamental = self.means()
        fundamental *= 2
        places = [[u[i], *(self.place(i, t) for t in self.turns(i, mpf(0)))] for i in range(n)]
        places = [x for flight_places in places for x in flight_places]
        gaps = {1: [], -1: []}
        for i in range(n):
            slot = [self.half[i] + u[i] + w[i] * t - self.place(i, t) for t in self.turns(i, w[i])]
            for side in gaps:
                inside = [abs(self.half[0]) - side * y for y in slot]
                gaps[side].append(min(inside, default=mp.nan))
        whole = 2 * mp.pi * mp.floor((u[n] + lag) / (2 * mp.pi))
        return {
            "alpha": [u[n + i] - u[n] for i in range(n)],
            "phases": [u[n + i] + lag - whole for i in range(n)],
            "X": u[:n],
            "Z": [u[i] + self.half[i] for i in range(n)],
            "X_dot_before": before,
            "X_dot_after": after,
            "Z_dot_before": arrivals,
            "Z_dot_after": w,
            "approach_speeds": [self.sides[i] * (arrivals[i] - before[i]) for i in range(n)],
            "gaps_right": gaps[1],
            "gaps_left": gaps[-1],
            "A": self.amplitude,
            "tau": u[n],
            "load_phase": u[n] + lag,
            "x_max": max(places),
            "x_min": min(places),
            "attenuation": max(max(places), -min(places)) / self.amplitude,
            "x_rms": mp.sqrt(square),
            "fundamental_amplitude": abs(fundamental),
            "fundamental_phase": mp.arg(1j * fundamental) - lag,
            "multipliers": self.multipliers(),
        }

    def means(self):
        """Means of x^2 and of x exp(-i theta) over the period, x being a sum of exponentials."""
        time, _, after, _ = self.speeds(self.u)
        eta = mp.sqrt(1 - self.xi**2)
        rates = [
            mp.mpc(-self.xi, eta),
            mp.mpc(-self.xi, -eta),
            mp.mpc(0, self.r),
            mp.mpc(0, -self.r),
        ]
        square, fundamental = mpf(0), mpf(0)

        def integral(rate, t):
            return t if rate == 0 else mp.expm1(rate * t) / rate

        for x, theta, v, t in zip(self.u[: self.n], self.u[self.n :], after, time, strict=True):
            forced = self.amplitude * mp.expj(theta) / 2j
            x, v = x - 2 * forced.real, v + 2 * self.r * forced.imag
            free = (v - rates[1] * x) / (rates[0] - rates[1])
            sizes = [free, mp.conj(free), forced, mp.conj(forced)]
            terms = list(zip(sizes, rates, strict=True))
            square += sum(a * b * integral(p + q, t) for a, p in terms for b, q in terms)
            turn = mp.expj(-theta)
            fundamental += turn * sum(a * integral(p - rates[2], t) for a, p in terms)
        return mp.re(square) * self.r / self.turn, fundamental * self.r / self.turn

    def multipliers(self):
        """The eigenvalues of the product of the derivatives of the maps between impacts."""
        time, _, after, w = self.speeds(self.u)
        product = mp.eye(4)
        for i in range(self.n):
            state = [self.u[i], after[i], w[i], self.u[self.n + i]]
            base = self.following(i, state, time[i])
            part = mp.matrix(4, 4)
            for j in range(4):
                moved = [value + (STEP if k == j else 0) for k, value in enumerate(state)]
                for k, value in enumerate(self.following(i, moved, time[i])):
                    part[k, j] = (value - base[k]) / STEP
            product = part * product
        return mp.eig(product, left=False, right=False)


def excess(motion):
    """Largest modulus of a multiplier of the motion near a motion of the package, minus 1."""
    with mp.workdps(DIGITS):
        return float(max(abs(value) for value in ReferenceMotion(motion).multipliers()) - 1)
