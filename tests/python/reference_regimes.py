"""Simulation of structures with gaps, elastic stops and friction by matrix exponentials and bracketed events.

A regime is the set of the states of all elements. In each one the motion is the exponential of the matrix of
(q, q', 1, cos, sin), and functionals of this vector are monitored: where one falls below 0, between two steps
far shorter than any contact, Newton's method between brackets finds the zero. No modes, no bounds.
Derivatives are by complex step: perturbations of 1e-30 i go through the same simulation.
"""

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import exponential, extended, first_order, written

#: States of a stop, and of friction.
OPEN, PRESSING, INSIDE = "open", "pressing", "inside"
UP, DOWN, STICK = "slip_up", "slip_down", "halt"
#: Events that cannot happen right after an event.
BACK = {
    "impact": "impact",
    "touch": "leave",
    "leave": "touch",
    "let_go": "press",
    "press": "let_go",
}
#: The imaginary part of a perturbation.
TINY = 1e-30


class ReferenceRegimes:
    """A structure under a load, not given by a record, with a time step that is shorter than any contact.

    The walls move with at most as many harmonics as the load has. Friction sticks initially where its speed is
    below `still`.
    """

    def __init__(self, structure, load=None, step=1e-3, still=1e-13):
        self.structure, self.load, self.step, self.still = structure, load, step, still
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

    def opening(self, wall):
        """The distance of a gap or a stop, whose wall may move, and its derivative."""
        place, pace = self.row(-wall.direction, constant=wall.opening), self.row(0, -wall.direction)
        for i, (cosine, sine) in enumerate(zip(wall.cosine, wall.sine, strict=True)):
            at, omega = 2 * self.n + 1 + 2 * i, (i + 1) * self.load.frequency
            place[at : at + 2] = cosine, sine
            pace[at : at + 2] = omega * sine, -omega * cosine
        return place, pace

    def force(self, stop):
        """The force of a stop in contact."""
        place, pace = self.opening(stop)
        return self.row(0, constant=stop.preload) - stop.stiffness * place - stop.damping * pace

    def slip(self, part):
        """The sliding speed s of friction."""
        return self.row(np.zeros(self.n), part.direction, -part.speed)

    def regime(self, states):
        """The matrix, the matrix of a step, and the functionals with the events at which they fall to 0."""
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
            opening = self.opening(part)[0]
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
        forces = {}
        if held:
            d = np.array([part.direction for _, part in held]).T
            push = np.linalg.solve(d.T @ self.inverse @ d, d.T @ matrix[n : 2 * n])
            matrix[n : 2 * n] -= self.inverse @ d @ push
            for (j, part), phi in zip(held, push, strict=True):
                forces[j] = phi
                limit = self.row(np.zeros(n), constant=part.stick)
                watched += [(limit - phi, j, UP, UP), (limit + phi, j, DOWN, DOWN)]
        rows = np.array([row for row, *_ in watched]).reshape(-1, len(matrix))
        self.known[states] = matrix, exponential(matrix * self.step), watched, forces, rows
        return self.known[states]

    def start(self, y):
        """The states of all elements at a state at which only friction may be at its limit."""
        states = []
        for part in self.parts:
            state = OPEN
            if isinstance(part, vi.Friction):
                s = self.slip(part) @ y
                state = STICK if abs(s) < self.still else UP if s > 0 else DOWN
            elif isinstance(part, vi.Stop) and self.opening(part)[0] @ y < 0:
                pulls = part.release == "force" and self.force(part) @ y < 0
                state = INSIDE if pulls else PRESSING
            states.append(state)
        return self.settle(tuple(states), y)

    def settle(self, states, y):
        """States in which each sticking friction force is at most its stick level.

        One element changes at a time, starting with the one that exceeds its level by the largest factor.
        """
        while True:
            forces = {j: phi @ y for j, phi in self.regime(states)[3].items()}
            loads = {j: abs(force) / self.parts[j].stick for j, force in forces.items()}
            j = max(loads, key=loads.get, default=0)
            if loads.get(j, 0) <= 1 + 1e-12:
                return states
            states = (*states[:j], UP if forces[j] > 0 else DOWN, *states[j + 1 :])

    def first_zero(self, matrix, y, row):
        """The time in (0, step) at which a functional is 0; before, it is positive."""
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

    def together(self, j, y):
        """The gaps that are closed at an impact on gap j, if a law tells what follows."""
        gaps = [i for i, part in enumerate(self.parts) if isinstance(part, vi.Gap)]
        near = [i for i in gaps if abs(self.opening(self.parts[i])[0] @ y[:, 0].real) < 1e-11]
        return near if self.structure.simultaneous and j in near else [j]

    def strike(self, closed, y):
        """The velocities after impacts at one instant: one after the other, or Newton's law at all."""
        g = np.array([self.parts[i].direction for i in closed])
        kicks = self.inverse @ g.T
        r = np.array([self.parts[i].restitution for i in closed])
        closing = -np.array([self.opening(self.parts[i])[1] for i in closed]) @ y
        a, left = g @ kicks, closing[:, 0].real.copy()
        while left.max() > 1e-12:
            impulses = np.zeros(len(closed))
            if len(closed) == 1:
                impulses = (1 + r)[:, None] * closing / a
            elif self.structure.simultaneous == "sequence":
                i = left.argmax()
                impulses[i] = (1 + r[i]) * left[i] / a[i, i]
            else:
                impulses = self.all_at_once(a, (1 + r) * left)
            y[self.n : 2 * self.n] -= kicks @ impulses.reshape(len(closed), -1)
            left -= a @ impulses.reshape(len(closed), -1)[:, 0].real
        return kicks

    @staticmethod
    def all_at_once(a, wanted):
        """The impulses p >= 0 with a p >= wanted, equal where p > 0, by trying all sets of gaps."""
        for number in range(1, 2 ** len(wanted)):
            some = np.flatnonzero([number >> i & 1 for i in range(len(wanted))])
            impulses = np.zeros(len(wanted))
            impulses[some] = np.linalg.solve(a[np.ix_(some, some)], wanted[some])
            if impulses.min() >= 0 and (wanted - a @ impulses).max() < 1e-12:
                return impulses
        raise ValueError("no impulses")

    def impact(self, j, states, y):
        """The velocities after an impact, and the states, in which friction opposes its speed."""
        kicks = self.strike(self.together(j, y), y)
        after = list(states)
        for i, part in enumerate(self.parts):
            if isinstance(part, vi.Friction) and np.abs(part.direction @ kicks).max() > 1e-12:
                after[i] = UP if self.slip(part) @ y[:, 0].real > 0 else DOWN
            if after[i] in (PRESSING, INSIDE) and part.release == "force" and part.damping:
                after[i] = PRESSING if self.force(part) @ y[:, 0].real > 0 else INSIDE
        return tuple(after)

    def simulate(self, duration, state, start=0.0, disturbances=None):
        """The events: time, kind, number, coordinates and velocities after it.

        `final` is the state at the end, and `derivative` holds the columns of `disturbances` of the first state
        carried to the end.
        """
        n, t, events = self.n, 0.0, []
        y0 = extended(state, self.load, start)
        extra = np.zeros((2 * n, 0)) if disturbances is None else disturbances
        y = np.repeat(y0[:, None].astype(complex), 1 + extra.shape[1], axis=1)
        y[: 2 * n, 1:] += TINY * 1j * extra
        late = np.zeros(y.shape[1], complex)  # by how much each column is later than the time t
        states, fresh = self.start(y0), set()
        for j, part in enumerate(self.parts):
            if (
                isinstance(part, vi.Friction)
                and abs(self.slip(part) @ y0) < self.still
                and states[j] != STICK
            ):
                fresh.add((j, STICK))
        while t < duration:
            matrix, step, watched, _, rows = self.regime(states)
            after = (step @ y.view(float)).view(complex)
            values = rows @ after[:, 0].real
            # a functional that has just crossed is at 0, and must have moved away from it within a step
            assert not fresh or all(
                v > 0 for item, v in zip(watched, values, strict=True) if item[1:3] in fresh
            )
            if values.min(initial=0.0) >= 0:
                y, t, fresh = after, t + self.step, set()
                continue
            fallen = [item for item, v in zip(watched, values, strict=True) if v < 0]
            zeros = [self.first_zero(matrix, y[:, 0].real, item[0]) for item in fallen]
            first = int(np.argmin(zeros))
            row, j, kind, new = fallen[first]
            if t + zeros[first] > duration:
                break
            t += zeros[first]
            for i in range(y.shape[1]):
                now = exponential(matrix * zeros[first]) @ y[:, i]
                further = -1j * ((row @ now) / (row @ matrix @ now)).imag if i else 0.0
                y[:, i] = exponential(matrix * further) @ now
                late[i] += further
            before = states
            states = (*states[:j], new, *states[j + 1 :])
            fresh = {(j, BACK.get(kind))}
            if kind == "impact":
                states = self.impact(j, states, y)
            if kind == STICK:
                part = self.parts[j]
                kick = self.inverse @ part.direction
                y[n : 2 * n] -= np.outer(kick, (self.slip(part) @ y) / (part.direction @ kick))
            states = self.settle(states, y[:, 0].real)
            now = y[: 2 * n, 0].real.copy()
            if not isinstance(self.parts[j], vi.Friction):
                events.append((start + t, kind, j, now))
            for i, part in enumerate(self.parts):
                if i != j and isinstance(part, vi.Stop) and states[i] != before[i]:
                    changed = "press" if states[i] == PRESSING else "let_go"
                    events.append((start + t, changed, i, now))
                    fresh.add((i, BACK[changed]))
                if isinstance(part, vi.Friction) and states[i] != before[i]:
                    events.append((start + t, states[i], i, now))
                    if kind != "impact" and states[i] != STICK:
                        fresh.add((i, STICK))
        # the last step may have gone beyond the end
        matrix = self.regime(states)[0]
        ends = [exponential(matrix * (duration - t - late[i])) @ y[:, i] for i in range(len(late))]
        self.final = ends[0][: 2 * n].real
        self.derivative = np.array(ends[1:]).T[: 2 * n].imag / TINY if len(ends) > 1 else None
        return events


def check_reference(folder, s, load, duration, start, least):
    """All events agree with a simulation without modes and bounds; a namelist gives the same digits."""
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
