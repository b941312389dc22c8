"""Proofs for all values of one parameter of a structure: the equations of `structures` in Taylor models.

The difference between a motion and the steady vibration, together with a constant, obeys u' = A u with the same A
for all values, so that exp(A t) is a Taylor polynomial in the duration t alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..motions.motion import Motion
from .balls import ball, decimal, flint
from .boxes import DEGREES, NEAR_CIRCLE, NO_ORDER, Box, Problem, bound_in_box
from .equations import characteristic
from .models import Model, at_middle, space, span
from .structures import System, gaps_stay_open, mirror_of, record_of
from .verdicts import inside_all

_Array = NDArray[np.float64]
#: The parameters that may vary, in addition to the opening and the restitution of single gaps.
VARIED = ("frequency", "load", "constant", "opening", "restitution")


#: The sum of products of which one factor may be a model.
dot = System.dot


def product(one: Sequence[Sequence[Any]], two: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """The product of two matrices of models or balls."""
    columns = list(zip(*two, strict=True))
    return [[dot(row, column) for column in columns] for row in one]


def solved(matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any]:
    """The solution of linear equations by elimination; ZeroDivisionError where it may not exist."""
    rows = [[*row, one] for row, one in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        sizes = [abs(float(flint().arb(at_middle(row[k])).mid())) for row in rows[k:]]
        best = k + int(np.argmax(sizes))
        rows[k], rows[best] = rows[best], rows[k]
        inverse = 1 / rows[k][k]
        rows[k] = [one * inverse for one in rows[k]]
        for i in range(n):
            if i != k:
                factor = rows[i][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n] for row in rows]


@dataclass(frozen=True)
class StructureFamily:
    """The motions of a structure on a branch, like `boxes.Family`.

    Attributes
    ----------
    system : dict
        The system of a certificate, in which the factors of the load are 1.
    cycles : int
        As in a certificate.
    mirror : list of int, or None
        For symmetric motions, the gap that -q closes for each gap that q closes.
    """

    system: Mapping[str, Any]
    cycles: int
    mirror: list[int] | None

    @classmethod
    def of(cls, motion: Motion, parameter: str, start: tuple[Any, Any]) -> StructureFamily:
        """The family of a motion of a branch, given the structure and the load at the start of the branch."""
        record = record_of(motion)
        gaps = len(record["gaps"])
        single = [f"{name}_{gap}" for name in VARIED[3:] for gap in range(gaps)]
        if parameter not in (*VARIED, *single):
            names = ", ".join((*VARIED, *single))
            raise ParameterError(
                f"parameter = {parameter!r}: must be one of {names} for the proof of a branch of a structure"
            )
        structure, load = start
        for name in ("sine", "cosine"):
            record[name] = [list(map(decimal, row)) for row in getattr(load, name)]
        record["constant"] = list(map(decimal, load.constant))
        record["frequency"] = decimal(load.frequency)
        for gap, own in zip(record["gaps"], structure.gaps, strict=True):
            gap["opening"], gap["restitution"] = decimal(own.opening), decimal(own.restitution)
        mirror = None if parameter in single else mirror_of(motion, record)
        return cls(record, motion.cycles, mirror)

    @property
    def symmetric(self) -> bool:
        """As in a certificate."""
        return self.mirror is not None

    @property
    def sides(self) -> str:
        """As in a certificate."""
        return " ".join(map(str, self.system["impacts"]))

    @property
    def word(self) -> list[int]:
        """The gaps of the impacts whose states are unknown."""
        impacts: list[int] = self.system["impacts"]
        return impacts[: len(impacts) // 2] if self.symmetric else impacts

    @property
    def width(self) -> int:
        """The number of unknowns of an impact."""
        return 2 * len(self.system["mass"]) + 1

    def record(self) -> dict[str, Any]:
        """The system of a certificate."""
        return dict(self.system)

    def states(self, motions: Sequence[Motion]) -> _Array:
        """The unknowns t, q, q' of motions, (impacts, unknowns of an impact, motions)."""
        n, found = len(self.word), []
        phases = np.array([motion.phases for motion in motions])
        phases = phases + (np.unwrap(phases[:, 0]) - phases[:, 0])[:, None]
        for motion, own in zip(motions, phases, strict=True):
            times = own / motion.load.frequency
            found.append(np.column_stack([times, motion.states.reshape(len(times), -1)])[:n])
        return np.moveaxis(np.array(found), 0, -1)

    def sizes(self, states: _Array) -> _Array:
        """The size of each unknown."""
        n = self.width // 2
        largest = [1 / float(self.system["frequency"])]
        largest += [np.abs(states[:, 1 : n + 1]).max()] * n + [np.abs(states[:, n + 1 :]).max()] * n
        return np.tile([one or 1.0 for one in largest], len(states))

    def problem(self, box: Box, facing: int) -> StructureProblem:
        """Its equations in a box."""
        return StructureProblem(self, box)


class VariedSystem:
    """The equations of a structure at a value, or models of values, of the parameters."""

    def __init__(self, family: StructureFamily, values: Mapping[str, Any]) -> None:
        module, system = flint(), family.system
        base = System(dict(system), family.cycles, family.mirror)
        self.n = n = base.n
        self.rows, self.harmonics = base.rows, base.harmonics
        self.frequency = values.get("frequency", base.frequency)
        self.constant = values.get("constant", module.arb(1))
        every = [
            [values.get(name, values.get(f"{name}_{k}", own)) for k, own in enumerate(known)]
            for name, known in (("opening", base.openings), ("restitution", base.restitution))
        ]
        self.openings, self.restitution = every
        self.impacts, self.ends, self.turn = base.impacts, base.ends, base.turn
        self.length = base.angle / self.frequency
        self.loss = base.damping.trace()
        self.flow = module.arb_mat(
            [[base.flow[i, j] for j in range(2 * n + 1)] for i in range(2 * n + 1)]
        )
        self.square = self.flow * self.flow
        self.jumps = []
        for row, R in zip(self.rows, self.restitution, strict=True):
            push = (base.inverse * module.arb_mat([[one] for one in row])).entries()
            share = base.dot(row, push)
            self.jumps.append(
                [
                    [int(i == j) - (1 + R) * (push[i] * row[j] / share) for j in range(n)]
                    for i in range(n)
                ]
            )
        load = values.get("load", module.arb(1))
        self.steady_parts = [self._steady(system, h, load) for h in range(1, self.harmonics + 1)]

    def _steady(
        self, system: Mapping[str, Any], h: int, load: Any
    ) -> tuple[Any, list[Any], list[Any]]:
        """w, a and b of the steady vibration a cos(w t) + b sin(w t) under a harmonic."""
        n, w = self.n, self.frequency * h
        mass, damping, stiffness = (
            [[ball(one) for one in row] for row in system[name]] for name in ("mass", "damping", "stiffness")
        )  # fmt: skip
        own = [[stiffness[i][j] - w * w * mass[i][j] for j in range(n)] for i in range(n)]
        turned = [[w * damping[i][j] for j in range(n)] for i in range(n)]
        matrix = [[*own[i], *turned[i]] for i in range(n)]
        matrix += [[*(-one for one in turned[i]), *own[i]] for i in range(n)]
        right = [ball(one) * load for one in (*system["cosine"][h - 1], *system["sine"][h - 1])]
        found = solved(matrix, right)
        return w, found[:n], found[n:]

    def steady(self, t: Any) -> tuple[list[Any], list[Any], list[Any]]:
        """Position, velocity and acceleration of the steady vibration."""
        zero = flint().arb(0)
        found: tuple[list[Any], ...] = ([zero] * self.n, [zero] * self.n, [zero] * self.n)
        for w, a, b in self.steady_parts:
            sine, cosine = (w * t).sin_cos()
            for k in range(self.n):
                q, v = a[k] * cosine + b[k] * sine, (b[k] * cosine - a[k] * sine) * w
                for part, value in zip(found, (q, v, -(w * w) * q), strict=True):
                    part[k] = part[k] + value
        return found[0], found[1], found[2]

    def exponential(self, t: Any) -> list[list[Any]]:
        """exp(A t), without its last row."""
        module, flow, size = flint(), self.flow, 2 * self.n + 1
        if not isinstance(t, Model):
            return [list(row) for row in (flow * t).exp().tolist()[:-1]]
        of = t.space
        middle = t.c[0].mid()
        step = Model(of, [t.c[0] - middle, *t.c[1:]])
        reach = step.range().union(module.arb(0))
        matrix = (flow * middle).exp()
        layers = [matrix] + [module.arb_mat(size, size)] * (len(of.monomials) - 1)
        power: Any = None
        for k in range(1, of.degree + 1):
            power = step if power is None else power * step
            matrix = matrix * flow / k
            layers = [old + matrix * c for old, c in zip(layers, power.c, strict=True)]
        # Lagrange's form of the remainder, entry by entry
        tail = matrix * flow * (flow * reach).exp() / (of.degree + 1)
        for _ in range(of.degree + 1):
            tail = tail * reach
        layers[0] = layers[0] + tail
        return [
            [Model(of, [layer[i, j] for layer in layers]) for j in range(size)]
            for i in range(size - 1)
        ]

    def flights(self, states: Sequence[Sequence[Any]]) -> list[VariedFlight]:
        """The flight after each impact."""
        n, found = self.n, []
        for i, state in enumerate(states):
            last = i + 1 == len(states)
            end = states[0][0] + self.length if last else states[i + 1][0]
            q, v, bend = self.steady(state[0])
            free = [a - b for a, b in zip(state[1:], [*q, *v], strict=True)] + [self.constant]
            matrix = self.exponential(end - state[0])
            q_end, v_end, bend_end = self.steady(end)
            landed = [dot(row, free) for row in matrix]
            landing = [a + b for a, b in zip(landed, [*q_end, *v_end], strict=True)]
            leaving = [*state[n + 1 :], *self.bent(free, bend)]
            arriving = [*landing[n:], *self.bent([*landed, self.constant], bend_end)]
            gap = self.ends[i]
            found.append(
                VariedFlight(
                    self.impacts[i], gap, state[0], end - state[0], free, matrix, landing, leaving, arriving,
                    dot(self.rows[gap], landing[n:]),
                )
            )  # fmt: skip
        return found

    def bent(self, free: Sequence[Any], steady: Sequence[Any]) -> list[Any]:
        """The accelerations."""
        size = 2 * self.n + 1
        return [
            dot([self.flow[i, k] for k in range(size)], free) + one
            for i, one in enumerate(steady, self.n)
        ]

    def hit(self, gap: int, velocity: Sequence[Any]) -> list[Any]:
        """A velocity after an impact."""
        return [dot(row, velocity) for row in self.jumps[gap]]

    def residuals(
        self, states: Sequence[Sequence[Any]], found: Sequence[VariedFlight]
    ) -> list[Any]:
        """As `System.residuals`."""
        n, left = self.n, []
        for i, flight in enumerate(found):
            last = i + 1 == len(found)
            following, turn = (states[0], self.turn) if last else (states[i + 1], 1)
            after = [*flight.landing[:n], *self.hit(flight.after, flight.landing[n:])]
            left += [one - two * turn for one, two in zip(after, following[1:], strict=True)]
            left.append(
                dot(self.rows[flight.after], flight.landing[:n]) - self.openings[flight.after]
            )
        return left

    def jacobian(self, found: Sequence[VariedFlight]) -> list[list[Any]]:
        """The derivative of `residuals` with respect to the unknowns."""
        n = self.n
        size, count = 2 * n + 1, len(found)
        zero = flint().arb(0)
        matrix = [[zero] * (size * count) for _ in range(size * count)]
        for i, flight in enumerate(found):
            j, turn = (0, self.turn) if i + 1 == count else (i + 1, 1)
            columns = [[-dot(row[: 2 * n], flight.leaving) for row in flight.matrix]]
            columns += [[row[k] for row in flight.matrix] for k in range(2 * n)]
            columns.append(flight.arriving)
            places = [*range(size * i, size * i + size), size * j]
            for place, column in zip(places, columns, strict=True):
                values = [*column[:n], *self.hit(flight.after, column[n:])]
                values.append(dot(self.rows[flight.after], column[:n]))
                for k, value in enumerate(values):
                    matrix[size * i + k][place] = matrix[size * i + k][place] + value
            for k in range(2 * n):
                row = matrix[size * i + k]
                row[size * j + 1 + k] = row[size * j + 1 + k] - turn
        return matrix

    def period_map(self, found: Sequence[VariedFlight]) -> list[list[Any]]:
        """As `System.period_map`; for a symmetric motion, the map of half a period and the mirror."""
        n = self.n
        zero, total = flint().arb(0), None
        for i, flight in enumerate(found):
            last = i + 1 == len(found)
            following, turn = (found[0], self.turn) if last else (found[i + 1], 1)
            turned = self.hit(flight.after, flight.arriving[n:])
            after = [one * turn for one in following.leaving[n:]]
            corner = [(one - two) / flight.speed for one, two in zip(after, turned, strict=True)]
            jump, row = self.jumps[flight.after], self.rows[flight.after]
            salt = [[*own, *[zero] * n] for own in jump]
            salt += [
                [*(one * part for part in row), *own] for one, own in zip(corner, jump, strict=True)
            ]
            part = product(salt, [own[: 2 * n] for own in flight.matrix])
            total = part if total is None else product(part, total)
        assert total is not None
        return [[one * self.turn for one in row] for row in total]

    def states_in(
        self, flight: VariedFlight
    ) -> Callable[[float, float, int], tuple[Any, Any, Any]]:
        """As `System.states_in`, for all parameters."""
        n, begin = self.n, span(flight.begin)
        parts = [
            (span(w), [span(one) for one in a], [span(one) for one in b])
            for w, a, b in self.steady_parts
        ]

        def states(middle: float, width: float, depth: int) -> tuple[Any, Any, Any]:
            module = flint()
            t, h = module.arb(middle), module.arb(0, width)
            free = [dot(row, flight.free) for row in (self.flow * t).exp().tolist()]
            steady = self.steady(flight.begin + t)
            q = [one + two for one, two in zip(free[:n], steady[0], strict=True)]
            v = [one + two for one, two in zip(free[n : 2 * n], steady[1], strict=True)]
            wide = (self.flow * h).exp() * module.arb_mat([[span(one)] for one in free])
            bends = (self.square * wide).entries()[:n]
            for w, a, b in parts:
                sine, cosine = (w * (begin + t + h)).sin_cos()
                bends = [one - w * w * (a[k] * cosine + b[k] * sine) for k, one in enumerate(bends)]
            return q, v, bends

        return states

    def determinant(self) -> Any:
        """As `System.determinant`, over the time of the map."""
        value = (self.length * -self.loss).exp()
        for gap in self.ends:
            value = value * self.restitution[gap] * self.restitution[gap]
        return value


@dataclass
class VariedFlight:
    """A flight between impacts on the gaps `before` and `after`.

    Attributes
    ----------
    begin, duration
        Its beginning and length.
    free : list
        The difference from the steady vibration at the beginning, and the factor of the constant forces.
    matrix, landing
        exp(A t) over the flight, and q, q' at its end.
    leaving, arriving
        q', q'' at both ends.
    speed
        The approach speed at its end.
    """

    before: int
    after: int
    begin: Any
    duration: Any
    free: list[Any]
    matrix: list[list[Any]]
    landing: list[Any]
    leaving: list[Any]
    arriving: list[Any]
    speed: Any


class StructureProblem(Problem):
    """The equations of a structure in a box."""

    def __init__(self, family: StructureFamily, box: Box) -> None:
        self.space = space(len(box.span), DEGREES[len(box.span)])
        middles = {name: ball((low + high) / 2) for name, (low, high) in box.span.items()}
        models = {
            name: self.space.parameter(k, middles[name], ball((high - low) / 2))
            for k, (name, (low, high)) in enumerate(box.span.items())
        }
        self.width, self.symmetric = family.width, family.symmetric
        self.system: Any = VariedSystem(family, models)
        self.middle: Any = VariedSystem(family, middles)

    def rows(self, unknowns: Sequence[Any]) -> list[list[Any]]:
        """The unknowns by impacts."""
        return [list(unknowns[k : k + self.width]) for k in range(0, len(unknowns), self.width)]

    def left(self, system: Any, unknowns: Sequence[Any]) -> list[Any]:
        """The residuals of the equations."""
        states = self.rows(unknowns)
        found: list[Any] = system.residuals(states, system.flights(states))
        return found

    def slopes(self, system: Any, unknowns: Sequence[Any]) -> list[list[Any]]:
        """The derivatives of the residuals."""
        found: list[list[Any]] = system.jacobian(system.flights(self.rows(unknowns)))
        return found

    def judge(self, box: Box, bounds: bool) -> None:
        """The verdicts on the motions in a box."""
        assert box.centre is not None
        system = self.system
        found = system.flights(self.rows(self.models(box.centre, box.error)))
        if not all(span(flight.duration) > 0 for flight in found):
            box.exists, box.centre, box.reason = None, None, NO_ORDER
            return
        box.admissible, box.reason = gaps_stay_open(system, found)
        polynomial = polynomial_of(system.period_map(found), system.determinant())
        box.stable = inside_all(polynomial)
        if box.stable is None:
            box.reason = "; ".join(filter(None, [box.reason, NEAR_CIRCLE]))
        elif box.stable and bounds:
            box.multipliers_below = bound_in_box(polynomial, self.symmetric)


def polynomial_of(matrix: list[list[Any]], last: Any) -> list[Any]:
    """Coefficients c_0, c_1, ... of the characteristic polynomial of a matrix with the determinant `last`."""
    m = len(matrix)
    if m == 4:
        return characteristic(matrix, last)
    found, power = [flint().arb(1)], matrix
    for k in range(1, m):
        # Faddeev and Le Verrier: c is the trace of P (P M + c) divided by -k
        c = sum((power[i][i] for i in range(m)), flint().arb(0)) / -k
        found.append(c)
        if k + 1 < m:
            shifted = [
                [one + c * int(i == j) for j, one in enumerate(row)] for i, row in enumerate(power)
            ]
            power = product(matrix, shifted)
    return [last, *found[::-1]]
