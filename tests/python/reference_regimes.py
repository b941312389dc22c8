"""Simulation of structures with gaps, elastic stops and friction by matrix exponentials and bracketed events.

A regime is the set of the states of all elements. In each one the motion is the exponential of the matrix of
(q, q', 1, cos, sin), and functionals of this vector are watched: where one falls below 0, between two steps that
are far shorter than any contact, Newton's method between brackets finds the zero. No modes, no bounds.
"""

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import exponential, extended, first_order, written

#: States of a stop, and of friction.
OPEN, PRESSING, INSIDE = "open", "pressing", "inside"
UP, DOWN, STICK = "slip_up", "slip_down", "halt"
#: What cannot happen right after an event.
BACK = {
    "impact": "impact",
    "touch": "leave",
    "leave": "touch",
    "let_go": "press",
    "press": "let_go",
}


class ReferenceRegimes:
    """A structure under a load without a record, at a step in time that is shorter than any contact."""

    def __init__(self, structure, load=None, step=1e-3):
        self.structure, self.load, self.step = structure, load, step
        self.parts = [*structure.gaps, *structure.friction]
        self.n = structure.coordinates
        self.free = first_order(structure, load)
        self.inverse = np.linalg.inv(structure.mass)
        self.known = {}

    def row(self, of_q, of_rate=0.0, constant=0.0):
        """A functional of (q, q', 1, cos, sin)."""
        n = self.n
        row = np.zeros(len(self.free))
        row[:n], row[n : 2 * n], row[2 * n] = of_q, of_rate, constant
        return row

    def force(self, stop):
        """The force of a stop while it presses."""
        g = stop.direction
        constant = stop.preload - stop.stiffness * stop.opening
        return self.row(stop.stiffness * g, stop.damping * g, constant)

    def slip(self, part):
        """The speed s of friction."""
        return self.row(np.zeros(self.n), part.direction, -part.speed)

    def regime(self, states):
        """The matrix, that of a step, and the functionals with the events where they fall to 0."""
        if states in self.known:
            return self.known[states]
        n, matrix, watched, held = self.n, self.free.copy(), [], []
        for j, (part, state) in enumerate(zip(self.parts, states, strict=True)):
            if isinstance(part, vi.Friction):
                if state == STICK:
                    held.append((j, part))
                    continue
                sign = 1 if state == UP else -1
                matrix[n : 2 * n, 2 * n] -= sign * part.slip * self.inverse @ part.direction
                watched.append((sign * self.slip(part), j, STICK, STICK))
                continue
            opening = self.row(-part.direction, constant=part.opening)
            if isinstance(part, vi.Gap):
                watched.append((opening, j, "impact", OPEN))
                continue
            force = self.force(part)
            if state == PRESSING:
                matrix[n : 2 * n] -= np.outer(self.inverse @ part.direction, force)
            watched.append(
                (opening, j, "touch", PRESSING) if state == OPEN else (-opening, j, "leave", OPEN)
            )
            if part.release == "force" and state == PRESSING and part.damping:
                watched.append((force, j, "let_go", INSIDE))
            if part.release == "force" and state == INSIDE:
                watched.append((-force, j, "press", PRESSING))
        self.holding = {}
        forces = {}
        if held:
            d = np.array([part.direction for _, part in held]).T
            push = np.linalg.solve(d.T @ self.inverse @ d, d.T @ matrix[n : 2 * n])
            matrix[n : 2 * n] -= self.inverse @ d @ push
            for (j, part), phi in zip(held, push, strict=True):
                forces[j] = phi
                limit = self.row(np.zeros(n), constant=part.stick)
                watched += [(limit - phi, j, UP, UP), (limit + phi, j, DOWN, DOWN)]
        self.known[states] = matrix, exponential(matrix * self.step), watched, forces
        return self.known[states]

    def start(self, y):
        """The states of all elements at a state at which only friction may be at its limit."""
        states = []
        for part in self.parts:
            state = OPEN
            if isinstance(part, vi.Friction):
                s = self.slip(part) @ y
                state = STICK if abs(s) < 1e-13 else UP if s > 0 else DOWN
            elif isinstance(part, vi.Stop) and part.direction @ y[: self.n] > part.opening:
                pulls = part.release == "force" and self.force(part) @ y < 0
                state = INSIDE if pulls else PRESSING
            states.append(state)
        return self.settle(tuple(states), y)

    def settle(self, states, y):
        """States in which what sticks is held by no more than its stick level.

        One changes at a time, first the one that exceeds its level by the largest factor.
        """
        while True:
            forces = {j: phi @ y for j, phi in self.regime(states)[3].items()}
            loads = {j: abs(force) / self.parts[j].stick for j, force in forces.items()}
            j = max(loads, key=loads.get, default=0)
            if loads.get(j, 0) <= 1 + 1e-12:
                return states
            states = (*states[:j], UP if forces[j] > 0 else DOWN, *states[j + 1 :])

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

    def impact(self, j, states, y):
        """The velocities after an impact, and the states, in which friction has the sign of its speed."""
        gap = self.parts[j]
        kick = self.inverse @ gap.direction
        speed = gap.direction @ y[self.n : 2 * self.n]
        y[self.n : 2 * self.n] -= (1 + gap.restitution) * speed / (gap.direction @ kick) * kick
        after = list(states)
        for i, part in enumerate(self.parts):
            if isinstance(part, vi.Friction) and abs(part.direction @ kick) > 1e-12:
                after[i] = UP if self.slip(part) @ y > 0 else DOWN
        return tuple(after)

    def simulate(self, duration, state):
        """The events: time, kind, number, coordinates and velocities after it."""
        n, t, events = self.n, 0.0, []
        y = extended(state, self.load, 0.0)
        states, fresh = self.start(y), set()
        for j, part in enumerate(self.parts):
            if (
                isinstance(part, vi.Friction)
                and abs(self.slip(part) @ y) < 1e-13
                and states[j] != STICK
            ):
                fresh.add((j, STICK))
        while t < duration:
            matrix, step, watched, _ = self.regime(states)
            after = step @ y
            fallen = [item for item in watched if item[0] @ after < 0]
            # what was passed just now is at 0, and must have moved off it within a step
            assert all(item[1:3] not in fresh or item[0] @ after > 0 for item in watched)
            if not fallen:
                y, t, fresh = after, t + self.step, set()
                continue
            zeros = [self.first_zero(matrix, y, item[0]) for item in fallen]
            first = int(np.argmin(zeros))
            _, j, kind, new = fallen[first]
            if t + zeros[first] > duration:
                break
            y, t = exponential(matrix * zeros[first]) @ y, t + zeros[first]
            before = states
            states = (*states[:j], new, *states[j + 1 :])
            fresh = {(j, BACK.get(kind))}
            if kind == "impact":
                states = self.impact(j, states, y)
            if kind == STICK:
                part = self.parts[j]
                kick = self.inverse @ part.direction
                y[n : 2 * n] -= (self.slip(part) @ y) / (part.direction @ kick) * kick
            states = self.settle(states, y)
            if not isinstance(self.parts[j], vi.Friction):
                events.append((t, kind, j, y[: 2 * n].copy()))
            for i, part in enumerate(self.parts):
                if isinstance(part, vi.Friction) and states[i] != before[i]:
                    events.append((t, states[i], i, y[: 2 * n].copy()))
                    if kind != "impact" and states[i] != STICK:
                        fresh.add((i, STICK))
        # the last step may have gone beyond the end
        self.final = (exponential(self.regime(states)[0] * (duration - t)) @ y)[: 2 * n]
        return events


def check_reference(folder, s, load, duration, start, least):
    """All events are those of a simulation without modes and bounds; a namelist gives the same digits."""
    known = ReferenceRegimes(s, load, 5e-4).simulate(duration, start)
    run = vi.simulate(s, load, duration=duration, state=start)
    assert len(known) >= least
    assert [tuple(e) for e in run.events[["kind", "gap"]].tolist()] == [
        (kind, j) for _, kind, j, _ in known
    ]
    assert run.events["time"] == pytest.approx([t for t, *_ in known], abs=1e-9)
    found = run.states.reshape(len(known), -1)
    assert np.abs(found - [y for *_, y in known]).max() < 1e-8
    (case,) = written(folder, run.to_namelist())
    (again,) = case.run()
    assert np.array_equal(again.events, run.events)
