"""A simulated motion of a structure and small changes of it, carried from event to event.

Between events the state, with the load as further coordinates, moves by a matrix exponential. At the events small
changes follow the closed forms of impacts, of the ends of accumulations and of releases (saltation). All of it is
analytic in all parameters. A step of 1e-30 i of a parameter therefore gives derivatives without rounding errors of
differences: of the state at each event, and of the matrix that carries small changes there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base.status import raise_status
from ..results.parameters import (
    CONSTANT,
    COSINE,
    DIRECTION,
    FREQUENCY,
    MATRICES,
    OPENING,
    RESTITUTION,
    SINE,
    entries_of,
)
from ..systems.record import Record
from ..systems.restitution import PowerLaw, TabulatedRestitution
from ..systems.structure import Load, Structure
from .gradient import GRAZE, NOT_EXACT

if TYPE_CHECKING:
    from ..motions.trajectory import Trajectory

__all__: list[str] = []

_Array = NDArray[Any]
#: The imaginary step.
STEP = 1e-30
#: Relative error of a motion that counts as exact; approach speed, over the largest velocity, at a graze.
EXACT, TOUCHING = 1e-8, 1e-9
#: Flights whose exponentials are computed at once.
CHUNK = 256
#: Codes of the core's vi_status.
UNSOLVABLE, COUPLED = 1, 19
#: Distance from a wall, over the largest coordinate, at a touch; instants of a flight between which it is sought.
TOUCH, NODES = 1e-12, 32


class System:
    """A structure under a load with complex entries. Its clock shows time, or the load phase."""

    def __init__(
        self, structure: Structure, load: Load | Record | None, values: _Array, by_phase: bool
    ) -> None:
        """From the values of `entries_of`, of a Record with those of its constant force."""
        self.structure, self.n = structure, structure.coordinates
        n, gaps = self.n, len(structure.gaps)
        self.record = load if isinstance(load, Record) else None
        #: A factor of the record.
        self.scale: complex = 1.0
        plain = plain_load(structure, load)
        places = entries_of(structure, plain)[0] - (0, 1, 1)
        self.harmonics = len(plain.sine)

        def table(kind: int, *shape: int) -> _Array:
            here = places[:, 0] == kind
            found = np.zeros(shape, values.dtype)
            found[tuple(places[here, 1 : 1 + len(shape)].T)] = values[here]
            return found

        self.mass, self.damping, self.stiffness = (
            np.tril(lower := table(kind, n, n)) + np.tril(lower, -1).T for kind in MATRICES
        )
        self.frequency = values[places[:, 0] == FREQUENCY][0]
        self.pace = self.frequency if by_phase else 1.0
        self.directions = table(DIRECTION, n, gaps).T
        self.openings, self.first = table(OPENING, gaps), table(RESTITUTION, gaps)
        self.forces = np.column_stack(
            [table(CONSTANT, n), table(COSINE, n, self.harmonics), table(SINE, n, self.harmonics)]
        )
        self.mobility = np.linalg.solve(self.mass, self.directions.T).T
        self.effective = 1 / (self.directions * self.mobility).sum(axis=1)

    def load_at(self, clock: Any, interval: int) -> _Array:
        """The coordinates of the load: 1, cosines and sines, or the time in an interval of the record."""
        if self.record:
            return np.array([1.0, clock - interval * self.record.step])
        angles = np.arange(1, self.harmonics + 1) * (clock * self.frequency / self.pace)
        return np.concatenate([[1.0], np.cos(angles), np.sin(angles)])

    def forces_in(self, interval: int) -> _Array:
        """The forces by the coordinates of the load."""
        if not self.record:
            return self.forces
        force, step = self.scale * self.record.force, self.record.step
        if not 0 <= interval < len(force) - 1:
            return np.column_stack([self.forces[:, 0], 0 * self.forces[:, 0]])
        change = (force[interval + 1] - force[interval]) / step
        return np.column_stack([self.forces[:, 0] + force[interval], change])

    def pushes(self, resting: tuple[int, ...], interval: int) -> tuple[_Array, _Array]:
        """Accelerations, and contact forces of gaps that rest, by the state and the load."""
        free = np.linalg.solve(
            self.mass, np.hstack([-self.stiffness, -self.damping, self.forces_in(interval)])
        )
        if not resting:
            return free, free[:0]
        directions, kicks = self.directions[list(resting)], self.mobility[list(resting)]
        try:
            contact = np.linalg.solve(directions @ kicks.T, directions @ free)
        except np.linalg.LinAlgError:
            raise_status(UNSOLVABLE)
        return free - kicks.T @ contact, contact

    def rate(self, resting: tuple[int, ...], interval: int) -> _Array:
        """The matrix of the rate of the state and the load."""
        n, harmonics = self.n, self.harmonics
        pushes = self.pushes(resting, interval)[0]
        size = pushes.shape[1]
        rate = np.zeros((size, size), pushes.dtype)
        rate[:n, n : 2 * n] = np.eye(n)
        rate[n : 2 * n] = pushes
        if self.record:
            rate[2 * n + 1, 2 * n] = 1
        for h in range(1, harmonics + 1):
            cosine, sine = 2 * n + h, 2 * n + harmonics + h
            rate[cosine, sine], rate[sine, cosine] = -h * self.frequency, h * self.frequency
        return np.asarray(rate / self.pace)

    def restitution(self, gap: int, speed: Any) -> tuple[Any, Any]:
        """R and dR/dv at a complex approach speed."""
        law = self.structure.gaps[gap].restitution
        first = self.first[gap]
        if isinstance(law, PowerLaw):
            ratio, power = speed / law.speed, law.sharpness
            base = 1 + ratio**power
            value = first * base ** (-law.exponent / power)
            return value, -law.exponent * value / base * ratio ** (power - 1) / law.speed
        if isinstance(law, TabulatedRestitution):
            at, step = speed.real, 1e-4 * law.speeds[-1]
            low = max(0.0, at - step)
            # R is a cubic between the points of the table, and its slope a parabola
            bend = (law.slope(at + step) - law.slope(low)) / (at + step - low)
            value, slope = law(at), law.slope(at)
            return value + slope * (speed - at), slope + bend * (speed - at)
        return first, 0.0

    def strike(self, gap: int, speed: Any) -> tuple[Any, Any]:
        """The impulse of an impact, and its derivative by the approach speed."""
        value, slope = self.restitution(gap, speed)
        impulse = (1 + value) * self.effective[gap] * speed
        return impulse, (1 + value + slope * speed) * self.effective[gap]

    def stop(self, resting: tuple[int, ...], gap: int, state: _Array, matrix: _Array) -> None:
        """Changes a state and its changes to those of gaps that rest, at the end of an accumulation on one.

        What is left of its gap closes by impulses in no time, and dashpots take their share of that motion.
        """
        n, rows = self.n, list(resting)
        direction, effective = self.directions[gap], self.effective[gap]
        carried = np.linalg.solve(self.mass, self.damping @ self.mobility[gap]) * effective
        state[n:] += carried * (direction @ state[:n] - self.openings[gap])
        matrix[n:] += np.outer(carried, direction @ matrix[:n])
        directions, kicks = self.directions[rows], self.mobility[rows]
        try:
            impulses = np.linalg.solve(directions @ kicks.T, directions)
        except np.linalg.LinAlgError:
            raise_status(UNSOLVABLE)
        closed = np.linalg.solve(directions @ kicks.T, self.openings[rows])
        state[:n] -= kicks.T @ (impulses @ state[:n] - closed)
        state[n:] -= kicks.T @ (impulses @ state[n:])
        for part in (matrix[:n], matrix[n:]):
            part -= kicks.T @ (impulses @ part)


def plain_load(structure: Structure, load: Load | Record | None) -> Load:
    """The part of a load that has entries."""
    if isinstance(load, Load):
        return load
    zero = np.zeros(structure.coordinates)
    return Load(constant=zero if load is None else load.constant)


@dataclass
class Carried:
    """A motion at its events: time (or phase), approach speed, impulse, coordinates and velocities just after.

    All are complex. Those of the end are at a fixed time.
    """

    #: (events, 2n + 3), and their derivatives by the state at the start (events, 2n + 3, 2n).
    values: _Array
    slopes: _Array
    #: (2n), (2n, 2n), (2n): state, its derivatives and its rate at the end; (2n) the rate at the start.
    state: _Array
    matrix: _Array
    rate: _Array
    first_rate: _Array | None
    #: (2n) The largest coordinate n times, and the largest velocity.
    sizes: _Array
    #: Events that have derivatives, and why the next one has none: a graze, or a coupled impact.
    good: int
    code: int = 0


def exponentials(matrices: _Array) -> _Array:
    """exp(matrix) - 1 of each, by a Taylor polynomial of the matrix over a power of 2, squared again."""
    size = np.abs(matrices).sum(axis=-1).max(initial=1e-300)
    squarings = max(0, int(np.ceil(np.log2(size))) + 1)
    scaled = matrices / 2.0**squarings
    total = term = scaled
    for i in range(2, 22):
        term = term @ scaled / i
        total = total + term
    for _ in range(squarings):
        total = 2 * total + total @ total
    return np.asarray(total)


def flights(system: System, run: Trajectory) -> Iterator[tuple[int, Any, int, Any, _Array]]:
    """The parts of all flights in order: number of the event at the end, gaps that rest, interval of the record,
    clock at the start, and exp - 1 of the matrix of the rate."""
    parts: list[tuple[int, tuple[int, ...], int, float, float]] = []
    resting = run._resting()
    begin, record = run.start, system.record
    names = [
        *zip(run.events["kind"].tolist(), run.events["gap"].tolist(), strict=True),
        ("end", -1),
    ]
    for i, (kind, gap) in enumerate(names):
        end = float(run.events["time"][i]) if kind != "end" else run.end
        if kind == "stick":
            # small changes rest from the last impact on
            resting = tuple(sorted({*resting, gap}))
        cuts = [begin, end]
        if record:
            # after its last sample a record may be followed by any time
            stop = min(np.ceil(end / record.step) + 1, len(record.force))
            numbers = np.arange(np.floor(begin / record.step), stop)
            cuts[1:1] = [t for t in (numbers * record.step).tolist() if begin < t < end]
        for low, high in pairwise(cuts):
            interval = int(0.5 * (low + high) // record.step) if record else -1
            parts.append((i, resting, interval, low, high - low))
        resting = tuple(one for one in resting if kind != "release" or one != gap)
        begin = end
    for first in range(0, len(parts), CHUNK):
        some = parts[first : first + CHUNK]
        pace = system.pace.real
        rates = [system.rate(part[1], part[2]) * (part[4] * pace) for part in some]
        for part, growth in zip(some, exponentials(np.array(rates)), strict=True):
            yield part[0], part[1], part[2], part[3] * pace, growth


def coupled(system: System, run: Trajectory, i: int, sizes: _Array, first: int | None) -> bool:
    """Whether an impact and one on another gap are at one instant and act on each other.

    They do by the masses, or by dashpots, so that the order of both matters to first order. `first` is the gap of
    an impact at the start.
    """
    earlier = run.events[["kind", "gap", "time"]][max(0, i - len(system.openings)) : i][
        ::-1
    ].tolist()
    if first is not None and i < len(system.openings):
        earlier.append(("impact", first, run.start))
    gap, speed, time = run.events[["gap", "speed", "time"]][i].tolist()
    kick = system.mobility[gap].real
    reach = TOUCHING * float(np.abs(system.directions[gap]) @ sizes)
    for kind, other, before in earlier:
        if abs(speed) * (time - before) > reach:
            return False
        if kind != "impact" or other == gap:
            continue
        size = np.abs(system.directions[other]) @ np.abs(system.mobility[other])
        damped = system.damping.real @ kick
        by_dashpots = system.mobility[other].real @ damped
        most = np.abs(system.mobility[other]) @ np.abs(damped)
        by_masses = abs(system.directions[other].real @ kick)
        if by_masses > TOUCHING * size or abs(by_dashpots) > TOUCHING * most > 0:
            return True
    return False


def touch_of(run: Trajectory) -> tuple[int, _Array]:
    """Number of the event after the first flight in which a gap closes without an impact, -1 if none does; and the
    largest coordinate and velocity at the events and between them: at impacts all coordinates may be 0."""
    gaps, times = run.structure.gaps, run.events["time"]
    directions = np.array([gap.direction for gap in gaps]).reshape(len(gaps), -1)
    openings = np.array([gap.opening for gap in gaps])[:, None]
    edges = np.concatenate([[run.start], times, [run.end]])
    shares = np.concatenate([[1e-6], (np.arange(NODES) + 0.5) / NODES, [1 - 1e-6]])
    nodes = np.clip(edges[:-1, None] + np.diff(edges)[:, None] * shares, run.start, run.end)
    q, q_dot = run.sample(nodes.ravel())
    pairs = zip((q, q_dot), run.states.transpose(1, 0, 2), strict=True)
    sizes = np.array([
        max(np.abs(part).max(initial=1e-300), np.abs(own).max(initial=0.0)) for part, own in pairs
    ])  # fmt: skip
    closing = (directions @ q_dot).reshape(len(gaps), *nodes.shape)
    distance = (openings - directions @ q).reshape(closing.shape)
    # from approach to departure, so near that the gap may close between
    reach = np.diff(nodes) * np.maximum(closing[..., :-1], -closing[..., 1:])
    # impacts at one instant have flights of the size of rounding between them
    long = (np.diff(edges) > TOUCHING * np.abs(edges).max())[:, None]
    turns = long & (closing[..., :-1] > 0) & (closing[..., 1:] <= 0) & (distance[..., :-1] < reach)
    gap, flight, node = np.nonzero(turns)
    low, high = nodes[flight, node], nodes[flight, node + 1]
    for _ in range(60 if gap.size else 0):
        middle = 0.5 * (low + high)
        nearing = np.einsum("ij,ji->i", directions[gap], run.sample(middle)[1]) > 0
        low, high = np.where(nearing, middle, low), np.where(nearing, high, middle)
    if not gap.size:
        return -1, sizes
    left = openings[gap, 0] - np.einsum("ij,ji->i", directions[gap], run.sample(low)[0])
    size = np.abs(directions[gap]) @ np.abs(q).max(axis=1)
    rests = resting_in(run)
    found = [
        i
        for i, j, close in zip(flight, gap, np.abs(left) < TOUCH * size, strict=True)
        if close and j not in rests[i]
    ]
    return int(min(found, default=-1)), sizes


def resting_in(run: Trajectory) -> list[set[int]]:
    """The gaps that rest in each flight, or come to rest at its end, or were released at its beginning."""
    resting = set(run._resting())
    found = [resting]
    for kind, gap in run.events[["kind", "gap"]].tolist():
        if kind == "stick":
            resting = resting | {gap}
            found[-1] = found[-1] | {gap}
        found.append(resting)
        resting = resting - {gap} if kind == "release" else resting
    return found


def carried(system: System, run: Trajectory, start: _Array, first: int | None = None) -> Carried:
    """The motion from a start, complex in its small changes; its real part is that of a trajectory.

    `first` is the gap of an impact just before it.
    """
    n, events, pace = system.n, run.events, system.pace
    clocks = np.append(events["time"], run.end) * pace.real
    whole_flights, sizes = touch_of(run)
    sizes = np.repeat(sizes, n)
    found = Carried(
        np.zeros((len(events), 2 * n + 3), complex),
        np.zeros((len(events), 2 * n + 3, 2 * n), complex),
        start.astype(complex), np.eye(2 * n, dtype=complex), start, None, sizes, len(events),
    )  # fmt: skip
    state, matrix = found.state, found.matrix
    #: Of the last impact the gap; how far it is from closed at its fixed time, and by the state at the start; its
    #: departure speed.
    left: tuple[int, float, _Array, float] | None = None
    touched: dict[int, tuple[float, _Array]] = {}
    #: Clock of the last impact, and its change; contacts that pull from then on are released there.
    struck: tuple[float, float, _Array] = (np.nan, 0.0, np.zeros(2 * n, complex))
    for i, group in groupby(flights(system, run), key=itemgetter(0)):
        kind, gap = ("end", -1) if i == len(events) else events[["kind", "gap"]][i].tolist()
        if kind == "impact" and coupled(system, run, i, sizes[:n], first):
            found.good, found.code = i, COUPLED
            return found
        moved, turned = np.zeros(2 * n, complex), np.zeros_like(matrix)
        stopped = False
        for _, resting, interval, clock, growth in group:
            if kind == "stick" and not stopped:
                system.stop(resting, gap, state, matrix)
                stopped = True
            whole = np.append(state, system.load_at(clock, interval))
            rate = system.rate(resting, interval)
            if found.first_rate is None:
                found.first_rate = (rate @ whole)[: 2 * n]
            step, change = (growth @ whole)[: 2 * n], growth[: 2 * n, : 2 * n] @ matrix
            state, matrix, moved, turned = (
                state + step,
                matrix + change,
                moved + step,
                turned + change,
            )
        whole = np.append(state, system.load_at(clocks[i], interval))
        found.state, found.matrix, found.rate = state, matrix, (rate @ whole)[: 2 * n]
        if i == whole_flights:
            found.good, found.code = i, GRAZE
        if kind == "end" or found.code:
            return found
        # the change of the clock at the event, in imaginary steps and by the state at the start
        later, row = touched.get(gap, (0.0, np.zeros(2 * n, complex)))
        forced = False
        if kind == "impact":
            condition = np.append(system.directions[gap], np.zeros(len(whole) - n))
            residual = (condition @ whole - system.openings[gap]).imag
            by_start = condition[: 2 * n] @ matrix
            if left and left[0] == gap:
                # without the digits that cancel in the short hops of an accumulation
                residual = left[1] + (condition[: 2 * n] @ moved).imag
                by_start = left[2] + condition[: 2 * n] @ turned
        elif kind == "release":
            condition = system.pushes(resting, interval)[1][resting.index(gap)]
            residual, by_start = (condition @ whole).imag, condition[: 2 * n] @ matrix
            forced = abs((condition @ whole).real) > EXACT * np.abs(condition) @ np.abs(whole)
            if forced:
                # its force jumped, at an impact or at the end of a record
                later, row = struck[1:] if struck[0] == clocks[i] else (0.0, 0 * row)
        if kind != "stick" and not forced:
            closing = (condition @ rate @ whole).real
            size = TOUCHING * np.abs(condition) @ np.abs(rate @ whole)
            if kind == "impact":
                size = TOUCHING * np.abs(condition[:n]) @ sizes[n:] / pace.real
            accumulates = left and left[0] == gap and abs(left[3]) < 10 * size
            if not accumulates and not abs(closing) > size:
                found.good, found.code = i, GRAZE
                return found
            later = -residual / closing
        whole = whole + 1j * later * (rate @ whole)
        matrix = matrix + 1j * later * (rate[: 2 * n, : 2 * n] @ matrix)
        if kind != "stick" and not forced:
            by_start = by_start + 1j * later * (condition @ rate)[: 2 * n] @ found.matrix
            row = -by_start / (condition @ rate @ whole)
        state = whole[: 2 * n]
        matrix = matrix + np.outer((rate @ whole)[: 2 * n], row)
        values, slopes = found.values[i], found.slopes[i]
        values[0], slopes[0] = clocks[i] + 1j * later, row
        if kind == "impact":
            touched[gap] = later, row
            struck = clocks[i], later, row
            speed, by_speed = (
                system.directions[gap] @ state[n:],
                system.directions[gap] @ matrix[n:],
            )
            impulse, slope = system.strike(gap, speed)
            state[n:] -= impulse * system.mobility[gap]
            matrix[n:] -= slope * np.outer(system.mobility[gap], by_speed)
            values[1:3], slopes[1], slopes[2] = (speed, impulse), by_speed, slope * by_speed
        values[3:], slopes[3:] = state, matrix
        recorded = run.states[i].ravel()
        if not (np.abs(state.real - recorded) < EXACT * sizes).all():
            raise_status(NOT_EXACT)
        # back to the fixed time of the event, with the rate after it
        resting = tuple(one for one in resting if kind != "release" or one != gap)
        rate = system.rate(resting, interval)
        whole[: 2 * n] = recorded + 1j * state.imag
        after = (rate @ whole)[: 2 * n]
        there = matrix - np.outer(after, row)
        matrix = there - 1j * later * (rate[: 2 * n, : 2 * n] @ there)
        state = whole[: 2 * n] - 1j * later * after
        left = None
        if kind == "impact":
            parting = system.directions[gap] @ after[:n]
            turning = 1j * later * (condition @ rate)[: 2 * n] @ there
            left = gap, -later * parting.real, -parting * row - turning, parting.real
    return found
