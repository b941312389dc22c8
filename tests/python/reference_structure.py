"""Periodic motions of structures with 50 digits, by matrix exponentials of the first-order form.

No modes: a flight is the exponential of the matrix of (q, q', 1, cos, sin), an impact is a linear map, and the
derivative of the period is the product of both with the saltation at each impact.
"""

import mpmath as mp
from mpmath import mpf

DIGITS = 50


def exponential(matrix):
    """The exponential by scaling and squaring, with as many extra digits as the squarings lose."""
    size = max(mp.mnorm(matrix, 1), 1)
    squarings = int(mp.log(size, 2)) + 8
    with mp.workdps(mp.mp.dps + squarings // 3 + 5):
        small = matrix / mpf(2) ** squarings
        term = total = mp.eye(matrix.rows)
        k = 0
        while mp.mnorm(term, 1) > mp.eps:
            k += 1
            term = term * small / k
            total = total + term
        for _ in range(squarings):
            total = total * total
    return total


class ReferenceStructure:
    """The motion of a structure under one harmonic, with impacts at given phases, each on a different gap.

    `start` is the state just after the first impact, `speeds` are the approach speeds, `before` the states (q, q',
    cos, sin) just before the impacts, and `places` the openings G.q of the gaps.
    """

    def __init__(self, matrices, load, walls, phases, cycles=1, free=False):
        """Matrices M, C, K; frequency, sine and cosine; directions and restitution of the gaps.

        Directions are reversed where the approach speed would be negative. A structure that is `free` begins with
        its first coordinate at 0, and its gaps are between its masses.
        """
        self.free, self.cycles = free, cycles
        mass, damping, stiffness = (mp.matrix(m) for m in matrices)
        frequency, sine, cosine = load
        self.n, n = mass.rows, mass.rows
        self.frequency = mpf(frequency)
        inverse = mass**-1
        self.flow = mp.zeros(2 * n + 2)
        for i in range(n):
            self.flow[i, n + i] = 1
        self.flow[n : 2 * n, :n] = -inverse * stiffness
        self.flow[n : 2 * n, n : 2 * n] = -inverse * damping
        self.flow[n : 2 * n, 2 * n] = inverse * mp.matrix(cosine)
        self.flow[n : 2 * n, 2 * n + 1] = inverse * mp.matrix(sine)
        self.flow[2 * n, 2 * n + 1], self.flow[2 * n + 1, 2 * n] = -self.frequency, self.frequency
        self.directions = [mp.matrix(g) for g, _ in walls]
        self.masses = [1 / (g.T * inverse * g)[0] for g in self.directions]
        self.kicks = [inverse * g for g in self.directions]
        self.restitution = [mpf(float(r)) for _, r in walls]
        self.places = self.given_phases(phases)
        for i, speed in enumerate(self.speeds):
            if speed < 0:
                self.directions[i], self.kicks[i] = -self.directions[i], -self.kicks[i]
                self.speeds[i], self.places[i] = -speed, -self.places[i]

    def jump(self, i):
        """The matrix of an impact, for (q, q', cos, sin)."""
        n, total = self.n, mp.eye(2 * self.n + 2)
        share = (1 + self.restitution[i]) * self.masses[i]
        total[n : 2 * n, n : 2 * n] -= share * self.kicks[i] * self.directions[i].T
        return total

    def given_phases(self, phases):
        """Solve for the motion; return the openings.

        With the impulses (1 + R) m v, the periodicity conditions are linear in the state and the speeds.
        """
        n, many = self.n, len(phases)
        phases = [mpf(float(p)) for p in phases]
        ends = [*phases[1:], phases[0] + 2 * mp.pi * self.cycles]
        times = [(end - begin) / self.frequency for begin, end in zip(phases, ends, strict=True)]
        self.flights = [exponential(self.flow * t) for t in times]
        # the state as a function of (q, q', speeds, 1)
        size = 2 * n + many
        state = mp.zeros(2 * n + 2, size + 1)
        for i in range(2 * n):
            state[i, i] = 1
        state[2 * n, size], state[2 * n + 1, size] = mp.cos(phases[0]), mp.sin(phases[0])
        rows, places, arrivals = [], [None] * many, [None] * many
        for i in range(many):
            j = (i + 1) % many
            state = self.flights[i] * state
            place = self.directions[j].T * state[:n, :]
            speed = self.directions[j].T * state[n : 2 * n, :]
            places[j], arrivals[j] = place, state.copy()
            speed[0, 2 * n + j] -= 1
            rows.append(speed)
            share = (1 + self.restitution[j]) * self.masses[j]
            for k in range(n):
                state[n + k, 2 * n + j] -= share * self.kicks[j][k]
        matrix, right = mp.zeros(size), mp.zeros(size, 1)
        for i in range(2 * n):
            matrix[i, :] = state[i, :size]
            matrix[i, i] -= 1
            right[i] = -state[i, size]
        if self.free:
            # the same motion elsewhere: the first coordinate starts at 0, and the momentum is conserved anyway
            matrix[n, :] = mp.zeros(1, size)
            matrix[n, 0], right[n] = 1, 0
        for i, row in enumerate(rows):
            matrix[2 * n + i, :] = row[0, :size]
            right[2 * n + i] = -row[0, size]
        found = mp.lu_solve(matrix, right)
        full = mp.matrix([*found, mpf(1)])
        self.start, self.speeds = list(found[: 2 * n]), list(found[2 * n :])
        self.before = [arrival * full for arrival in arrivals]
        return [(place * full)[0] for place in places]

    def monodromy(self):
        """The derivative of the period of (q, q'), starting just after the first impact."""
        n, many, total = self.n, len(self.speeds), mp.eye(2 * self.n)
        for i in range(many):
            j = (i + 1) % many
            total = self.flights[i][: 2 * n, : 2 * n] * total
            jump, before = self.jump(j), self.before[j]
            corner = self.flow * (jump * before) - jump * (self.flow * before)
            saltation = jump[: 2 * n, : 2 * n]
            for k in range(n):
                for row in range(2 * n):
                    saltation[row, k] += corner[row] * self.directions[j][k] / self.speeds[j]
            total = saltation * total
        return total

    def multipliers(self):
        """The eigenvalues of the derivative of the period."""
        return mp.eig(self.monodromy(), left=False, right=False)
