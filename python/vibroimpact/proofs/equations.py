"""The equations of a periodic motion in ball arithmetic.

The unknowns are, at each impact, the load phase psi and, just after it, X, X' and Z'. Between impacts the
motion is known in closed form. A motion that is its own mirror image half a period later is described by the
impacts of that half.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from .balls import flint

#: Unknowns of an impact.
UNKNOWNS = ("phase", "X", "X_dot_after", "Z_dot_after")
State = Sequence[Any]


@dataclass
class System:
    """An oscillator at a point, or in a box, with the word of the motion.

    Attributes
    ----------
    xi, mu, r, clearance, load
        Balls.
    restitution : list
        For each impact.
    signs : list of int
        +1 for the right wall, -1 for the left one.
    cycles : int
    mirrored : bool
        Whether the impacts are those of half a period, which ends in the mirror image of its beginning: X, X', Z'
        with opposite sign, on the other wall.
    steady : (sine, cosine), optional
        The steady motion without impacts, if it is not computed from r and the load.
    """

    xi: Any
    mu: Any
    r: Any
    clearance: Any
    load: Any
    restitution: list[Any]
    signs: list[int]
    cycles: int
    mirrored: bool = False
    steady: tuple[Any, Any] | None = None

    def __post_init__(self) -> None:
        xi, r = self.xi, self.r
        self.eta = (1 - xi * xi).sqrt()
        self.square = square = r * r
        if self.steady is not None:
            self.sine, self.cosine = self.steady
        else:
            distance = 1 - square
            damping = 2 * xi * r
            scale = self.load / (distance * distance + damping * damping)
            self.sine, self.cosine = scale * distance, -scale * damping
        self.length = (1 if self.mirrored else 2) * flint().arb.pi() * self.cycles
        self.turn = -1 if self.mirrored else 1
        self.half = self.clearance / 2

    def forced(self, phase: Any) -> tuple[Any, Any, Any]:
        """Position, velocity and acceleration of the steady motion without impacts."""
        sine, cosine = phase.sin_cos()
        x = self.sine * sine + self.cosine * cosine
        v = self.r * (self.sine * cosine - self.cosine * sine)
        return x, v, -self.square * x


@dataclass
class Flight:
    """A flight: its duration, the free part of the motion at its beginning, and the state just before its end."""

    start: State
    before: int
    after: int
    tau: Any
    forced: tuple[Any, Any, Any]
    landing: tuple[Any, Any, Any]
    u: Any
    w: Any
    q: Any
    a: Any
    b: Any
    free: tuple[Any, Any, Any]
    x: Any
    v: Any


def flights(system: System, states: Sequence[State]) -> list[Flight]:
    """The flight after each impact."""
    found = []
    forced = [system.forced(state[0]) for state in states]
    for i, state in enumerate(states):
        last = i + 1 == len(states)
        phase = states[0][0] + system.length if last else states[i + 1][0]
        x, v, bend = forced[0 if last else i + 1]
        landing = (x, v, bend) if not (last and system.mirrored) else (-x, -v, -bend)
        sign = system.turn * system.signs[0] if last else system.signs[i + 1]
        tau = (phase - state[0]) / system.r
        decay = (-system.xi * tau).exp()
        sine, cosine = (system.eta * tau).sin_cos()
        w = decay * sine / system.eta
        turned = decay * cosine
        u, q = turned + system.xi * w, turned - system.xi * w
        a, b = state[1] - forced[i][0], state[2] - forced[i][1]
        x, v = u * a + w * b, q * b - w * a
        free = (x, v, -2 * system.xi * v - x)
        found.append(
            Flight(
                state, system.signs[i], sign, tau, forced[i], landing, u, w, q, a, b, free,
                x + landing[0], v + landing[1],
            )
        )  # fmt: skip
    return found


def after_impact(system: System, place: int, v: Any, speed: Any) -> tuple[Any, Any]:
    """X' and Z' just after an impact, equations (11), (12)."""
    R, mu = system.restitution[place], system.mu
    return (
        ((1 - mu * R) * v + mu * (1 + R) * speed) / (1 + mu),
        ((1 + R) * v + (mu - R) * speed) / (1 + mu),
    )


def residuals(system: System, states: Sequence[State], found: Sequence[Flight]) -> list[Any]:
    """The residuals of the four equations of each flight."""
    left: list[Any] = []
    for i, flight in enumerate(found):
        last = i + 1 == len(found)
        following = states[0] if last else states[i + 1]
        if last and system.mirrored:
            following = [-one for one in following]
        speed = flight.start[3]
        v, z = after_impact(system, 0 if last else i + 1, flight.v, speed)
        left += [
            flight.x - following[1],
            flight.start[1]
            + flight.before * system.half
            + speed * flight.tau
            - following[1]
            - flight.after * system.half,
            v - following[2],
            z - following[3],
        ]
    return left


def slopes(system: System, flight: Flight) -> tuple[list[Any], list[Any], Any, Any]:
    """Derivatives of x and x' before the impact with respect to psi, X, X' at the start and psi at the end."""
    x_end = flight.v / system.r
    v_end = (flight.free[2] + flight.landing[2]) / system.r
    _, speed, acceleration = flight.forced
    x = [
        -(flight.free[1] + flight.u * speed + flight.w * acceleration) / system.r,
        flight.u,
        flight.w,
    ]
    v = [
        -(flight.free[2] - flight.w * speed + flight.q * acceleration) / system.r,
        -flight.w,
        flight.q,
    ]
    return x, v, x_end, v_end


def jacobian(system: System, found: Sequence[Flight]) -> list[list[Any]]:
    """The derivative of `residuals` with respect to the unknowns."""
    n = len(found)
    matrix = [[0] * (4 * n) for _ in range(4 * n)]
    for i, flight in enumerate(found):
        last = i + 1 == n
        j, one = (0, system.turn) if last else (i + 1, 1)
        x, v, x_end, v_end = slopes(system, flight)
        R, mu = system.restitution[j], system.mu
        first = ((1 - mu * R) / (1 + mu), mu * (1 + R) / (1 + mu))
        second = ((1 + R) / (1 + mu), (mu - R) / (1 + mu))
        speed = flight.start[3] / system.r
        rows = matrix[4 * i : 4 * i + 4]
        here, there = 4 * i, 4 * j
        entries = [
            (0, here, [*x, 0]), (0, there, [x_end, -one, 0, 0]),
            (1, here, [-speed, 1, 0, flight.tau]), (1, there, [speed, -one, 0, 0]),
            (2, here, [*(first[0] * k for k in v), first[1]]), (2, there, [first[0] * v_end, 0, -one, 0]),
            (3, here, [*(second[0] * k for k in v), second[1]]), (3, there, [second[0] * v_end, 0, 0, -one]),
        ]  # fmt: skip
        for row, column, values in entries:
            for k, value in enumerate(values):
                rows[row][column + k] = rows[row][column + k] + value
    return matrix


def impact_map(system: System, place: int, flight: Flight) -> list[list[Any]]:
    """The derivative of (psi, X, X', Z') after the impact that ends a flight with respect to that at its start."""
    x, v, x_end, v_end = slopes(system, flight)
    speed = flight.start[3]
    # the free mass meets the wall: X + s d/2 + Z' tau = x + s' d/2
    closing = (speed - flight.v) / system.r
    phase = [
        (x[0] + speed / system.r) / closing,
        (x[1] - 1) / closing,
        x[2] / closing,
        -flight.tau / closing,
    ]
    R, mu = system.restitution[place], system.mu
    landing = [one + x_end * two for one, two in zip([*x, 0], phase, strict=True)]
    before = [one + v_end * two for one, two in zip([*v, 0], phase, strict=True)]
    own = (0, 0, 0, 1)
    rows = [
        phase,
        landing,
        [((1 - mu * R) * one + mu * (1 + R) * two) / (1 + mu) for one, two in zip(before, own, strict=True)],
        [((1 + R) * one + (mu - R) * two) / (1 + mu) for one, two in zip(before, own, strict=True)],
    ]  # fmt: skip
    return rows


def period_map(system: System, found: Sequence[Flight]) -> list[list[Any]]:
    """[P], the derivative over a period; for a mirrored motion [Q], that over half a period and the mirror."""
    product: Any = None
    for i, flight in enumerate(found):
        matrix = impact_map(system, (i + 1) % len(found), flight)
        if product is None:
            product = matrix
        else:
            product = [
                [sum(row[k] * product[k][j] for k in range(4)) for j in range(4)] for row in matrix
            ]
    rows: list[list[Any]] = product
    if system.mirrored:
        rows = [rows[0], *([-one for one in row] for row in rows[1:])]
    return rows


def determinant(system: System) -> Any:
    """det[P], or det[Q], by its law: exp(-2 xi T) times the product of all R^2 in the time T."""
    value = (-2 * system.xi * system.length / system.r).exp()
    for R in system.restitution:
        value = value * R * R
    return value


def characteristic(matrix: list[list[Any]], last: Any) -> list[Any]:
    """Coefficients c_0 ... c_4 of the characteristic polynomial of a 4 by 4 matrix with the determinant `last`.

    Principal minors are used because powers of the matrix contain terms of high degree in the phase that cancel.
    """
    m, second, third = matrix, 0, 0
    one = sum(m[i][i] for i in range(4))
    for i, j in combinations(range(4), 2):
        second = second + m[i][i] * m[j][j] - m[i][j] * m[j][i]
    for i, j, k in combinations(range(4), 3):
        third = third + m[i][i] * (m[j][j] * m[k][k] - m[j][k] * m[k][j])
        third = third - m[i][j] * (m[j][i] * m[k][k] - m[j][k] * m[k][i])
        third = third + m[i][k] * (m[j][i] * m[k][j] - m[j][j] * m[k][i])
    return [last, -third, second, -one, 1]
