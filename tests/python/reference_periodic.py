"""The periodic problem for given impact phases with 50 digits, from Newton's law, and its multipliers.

The unknowns are the positions x_i and the forced motion a sin(theta) + b cos(theta), for the clearance 1: each
flight has to end at the next impact, with the velocity required by momentum and restitution. Each map from an
impact to the next is differentiated by the implicit function theorem.
"""

import mpmath as mp
from mpmath import mpf

DIGITS = 50


class GivenPhases:
    """The solution of the linear equations; by least squares if they outnumber the unknowns."""

    def __init__(self, osc, r, phases, pattern):
        """Solve them for clearance 1, and convert to units of F0/K."""
        n = len(phases)
        self.n, self.xi, self.mu, self.r = n, mpf(osc.xi), mpf(osc.mu), mpf(r)
        self.theta = [mpf(float(phase)) for phase in phases]
        sides = [int(side) for side in pattern.signs]
        self.half = [mpf(side) / 2 for side in sides]
        self.restitution = [mpf(osc.restitution[0 if side > 0 else 1]) for side in sides]
        turn = 2 * mp.pi * pattern.cycles
        ends = [*self.theta[1:], self.theta[0] + turn]
        self.time = [(end - begin) / self.r for begin, end in zip(self.theta, ends, strict=True)]
        eta = mp.sqrt(1 - self.xi**2)
        self.transfer = []
        for t in self.time:
            shrink, c, s = mp.exp(-self.xi * t), mp.cos(eta * t), mp.sin(eta * t) / eta
            self.transfer.append(
                [shrink * part for part in (c + self.xi * s, s, -s, c - self.xi * s)]
            )
        units = [[mpf(i == j) for i in range(n + 2)] for j in range(n + 2)]
        matrix = mp.matrix([self.mismatch(unit, 0) for unit in units]).T
        right = -mp.matrix(self.mismatch([mpf(0)] * (n + 2), 1))
        if n == 2:
            found, self.residual = mp.lu_solve(matrix, right), mpf(0)
        else:
            found, left = mp.qr_solve(matrix, right)
            self.residual = left / mp.norm(right)
        amplitude = 1 / mp.sqrt((1 - self.r**2) ** 2 + (2 * self.xi * self.r) ** 2)
        self.clearance = amplitude / mp.hypot(found[n], found[n + 1])
        self.unknowns = [value * self.clearance for value in found]
        self.x, self.tau = self.unknowns[:n], mp.atan2(found[n + 1], found[n])

    def speeds(self, unknowns, clearance):
        """Velocities of the free mass in each flight, and of M before and after each impact."""
        n, x = self.n, unknowns
        z = [x[i] + self.half[i] * clearance for i in range(n)]
        w = [(z[(i + 1) % n] - z[i]) / self.time[i] for i in range(n)]
        before = [
            (w[i] + self.restitution[i] * w[i - 1] - self.mu * (w[i - 1] - w[i]))
            / (1 + self.restitution[i])
            for i in range(n)
        ]
        return w, before, [before[i] + self.mu * (w[i - 1] - w[i]) for i in range(n)]

    def forced(self, unknowns, theta):
        """Position and velocity of the forced motion."""
        a, b = unknowns[self.n :]
        s, c = mp.sin(theta), mp.cos(theta)
        return a * s + b * c, self.r * (a * c - b * s)

    def arrival(self, i, unknowns, velocity):
        """Position and velocity of M at the end of flight i, and those of its free motion."""
        begin = self.forced(unknowns, self.theta[i])
        end = self.forced(unknowns, self.theta[i] + self.r * self.time[i])
        a, b = unknowns[i] - begin[0], velocity - begin[1]
        s = self.transfer[i]
        free = s[0] * a + s[1] * b, s[2] * a + s[3] * b
        return free[0] + end[0], free[1] + end[1], free, end

    def mismatch(self, unknowns, clearance):
        """The state at the end of each flight minus the one that the next impact requires."""
        _, before, after = self.speeds(unknowns, clearance)
        places, speeds = [], []
        for i in range(self.n):
            x, v, _, _ = self.arrival(i, unknowns, after[i])
            places.append(x - unknowns[(i + 1) % self.n])
            speeds.append(v - before[(i + 1) % self.n])
        return places + speeds

    def multipliers(self):
        """The eigenvalues of the product of the derivatives of the maps between impacts."""
        w, _, after = self.speeds(self.unknowns, self.clearance)
        product = mp.eye(4)
        for i in range(self.n):
            s = self.transfer[i]
            _, v, free, end = self.arrival(i, self.unknowns, after[i])
            f, g = self.forced(self.unknowns, self.theta[i])
            pull = -2 * self.xi * free[1] - free[0] - self.r**2 * end[0]
            # derivatives of position and velocity at the end by x, x', z' and phase at the beginning
            by_phase = [g / self.r, -self.r * f]
            ends = [end[1] / self.r, -self.r * end[0]]
            place = [
                s[0],
                s[1],
                mpf(0),
                ends[0] - s[0] * by_phase[0] - s[1] * by_phase[1],
            ]
            speed = [s[2], s[3], mpf(0), ends[1] - s[2] * by_phase[0] - s[3] * by_phase[1]]
            later = [
                (place[0] - 1) / (w[i] - v),
                place[1] / (w[i] - v),
                -self.time[i] / (w[i] - v),
                place[3] / (w[i] - v),
            ]
            restitution = self.restitution[(i + 1) % self.n]
            part = mp.matrix(4, 4)
            for k in range(4):
                change, own = speed[k] + pull * later[k], mpf(k == 2)
                centre = (change + self.mu * own) / (1 + self.mu)
                apart = -restitution * (change - own) / (1 + self.mu)
                part[0, k] = place[k] + v * later[k]
                part[1, k], part[2, k] = centre + self.mu * apart, centre - apart
                part[3, k] = (k == 3) + self.r * later[k]
            product = part * product
        return mp.eig(product, left=False, right=False)
