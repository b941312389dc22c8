"""Simulation of structures with gaps and elastic stops by matrix exponentials and bracketed events.

A regime is the set of the states of all elements. In each one the motion is the exponential of the matrix of
(q, q', 1, cos, sin), and functionals of this vector are watched: where one falls below 0, between two steps that
are far shorter than any contact, Newton's method between brackets finds the zero. It needs no modes and no bounds.
"""

import numpy as np
import vibroimpact as vi
from shared_structures import exponential, extended, first_order

#: States of a stop.
OPEN, PRESSING, INSIDE = "open", "pressing", "inside"


class ReferenceRegimes:
    """A structure under a load without a record, at a step in time that is shorter than any contact."""

    def __init__(self, structure, load=None, step=1e-3):
        self.structure, self.load, self.step = structure, load, step
        self.free = first_order(structure, load)
        self.inverse = np.linalg.inv(structure.mass)
        self.known = {}

    def row(self, of_q, of_rate=0.0, constant=0.0):
        """A functional of (q, q', 1, cos, sin)."""
        n = self.structure.coordinates
        row = np.zeros(len(self.free))
        row[:n], row[n : 2 * n], row[2 * n] = of_q, of_rate, constant
        return row

    def force(self, stop):
        """The force of a stop while it presses."""
        g = stop.direction
        constant = stop.preload - stop.stiffness * stop.opening
        return self.row(stop.stiffness * g, stop.damping * g, constant)

    def regime(self, states):
        """The matrix, that of a step, and the functionals with the events where they fall to 0."""
        if states in self.known:
            return self.known[states]
        n, matrix, watched = self.structure.coordinates, self.free.copy(), []
        for j, (element, state) in enumerate(zip(self.structure.gaps, states, strict=True)):
            opening = self.row(-element.direction, constant=element.opening)
            if isinstance(element, vi.Gap):
                watched.append((opening, j, "impact", OPEN))
                continue
            force = self.force(element)
            if state == PRESSING:
                matrix[n : 2 * n] -= np.outer(self.inverse @ element.direction, force)
            if state == OPEN:
                watched.append((opening, j, "touch", PRESSING))
            else:
                watched.append((-opening, j, "leave", OPEN))
            if element.release == "force" and state == PRESSING and element.damping:
                watched.append((force, j, "let_go", INSIDE))
            if element.release == "force" and state == INSIDE:
                watched.append((-force, j, "press", PRESSING))
        self.known[states] = matrix, exponential(matrix * self.step), watched
        return self.known[states]

    def start(self, y):
        """The states of all elements at a state that is on no limit."""
        states = []
        for element in self.structure.gaps:
            inside = element.direction @ y[: self.structure.coordinates] > element.opening
            state = OPEN
            if isinstance(element, vi.Stop) and inside:
                pulls = element.release == "force" and self.force(element) @ y < 0
                state = INSIDE if pulls else PRESSING
            states.append(state)
        return tuple(states)

    def first_zero(self, matrix, y, row):
        """The time in (0, step) at which a functional is 0, which is > 0 before."""
        low, high, t = 0.0, self.step, 0.5 * self.step
        for _ in range(60):
            now = exponential(matrix * t) @ y
            value, slope = row @ now, row @ matrix @ now
            low, high = (t, high) if value > 0 else (low, t)
            new = t - value / slope if slope else low
            new = new if low < new < high else 0.5 * (low + high)
            if abs(new - t) < 1e-15 * (1 + t):
                break
            t = new
        return t

    def simulate(self, duration, state):
        """The events: time, kind, number, coordinates and velocities after it."""
        n, t, events = self.structure.coordinates, 0.0, []
        y = extended(state, self.load, 0.0)
        states, fresh = self.start(y), None
        while t < duration:
            matrix, step, watched = self.regime(states)
            after = step @ y
            fallen = [item for item in watched if item[0] @ after < 0]
            # what was passed just now is at 0, and must have moved off it within a step
            assert all((item[1], item[2]) != fresh or item[0] @ after > 0 for item in watched)
            if not fallen:
                y, t, fresh = after, t + self.step, None
                continue
            zeros = [self.first_zero(matrix, y, item[0]) for item in fallen]
            first = int(np.argmin(zeros))
            _, j, kind, new = fallen[first]
            if t + zeros[first] > duration:
                break
            y, t = exponential(matrix * zeros[first]) @ y, t + zeros[first]
            if kind == "impact":
                gap = self.structure.gaps[j]
                kick = self.inverse @ gap.direction
                speed = gap.direction @ y[n : 2 * n]
                y[n : 2 * n] -= (1 + gap.restitution) * speed / (gap.direction @ kick) * kick
            states = (*states[:j], new, *states[j + 1 :])
            back = {
                "impact": "impact",
                "touch": "leave",
                "leave": "touch",
                "let_go": "press",
                "press": "let_go",
            }
            fresh = j, back[kind]
            events.append((t, kind, j, y[: 2 * n].copy()))
        return events
