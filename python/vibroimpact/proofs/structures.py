"""Proofs of single motions of structures.

The vector z of the coordinates and velocities, 1, and the cosines and sines of the load obeys z' = A z, so that a
flight is exp(A t) z for any damping, and no modes are needed. The unknowns are, at each impact, its time t and q,
q' just after it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import ParameterError
from ..motions.likeness import is_symmetric
from ..motions.motion import Motion
from ..systems.structure import Gap
from .balls import ball, decimal, decimal_text, flint, hexadecimal
from .boxes import NEAR_CIRCLE, NO_ORDER, NO_SPEED
from .certificate import Certificate
from .models import span
from .verdicts import above, approximate_inverse, inside, multiplier_bound

#: Bits of the mantissa, and the sizes of the boxes relative to the largest unknown of a kind, in turn.
LEAST_BITS = 64
ATTEMPTS = ((LEAST_BITS, 2.0**-34), (128, 2.0**-42), (256, 2.0**-44))
#: Why existence is not proven. The position of a free mass without impacts is arbitrary: no motion is unique.
NO_MOTION = (
    "Newton's method does not contract in a box around it (near a fold, pitchfork or graze, or with a free mass "
    "that meets no wall)"
)
#: Steps of Newton's method with more digits.
NEWTON = 8
#: The largest numbers of halvings of a piece of a flight, and of coordinates.
MOST_HALVINGS, MOST_COORDINATES = 40, 8


def texts(values: Any) -> Any:
    """The numbers of an array as decimal texts, nested in the same way."""
    return [texts(one) for one in values] if np.ndim(values) else decimal(values)


def check_structure(of: Any, structure: Any, rests: int) -> None:
    """Raise ParameterError if proofs do not support a motion or branch of a structure."""
    for name, refused in (
        ("stops", not all(isinstance(gap, Gap) for gap in structure.gaps)),
        ("friction", bool(structure.friction)),
        ("moving walls", bool(structure._moves)),
        ("rests", bool(rests)),
        (f"more than {MOST_COORDINATES} coordinates", structure.coordinates > MOST_COORDINATES),
        (
            "R(v)",
            any(not isinstance(getattr(gap, "restitution", 0), (int, float)) for gap in structure.gaps),
        ),
    ):  # fmt: skip
        if refused:
            what = type(of).__name__.lower()
            raise ParameterError(
                f"{what} = {of!r}: must not have {name}, which proofs do not support"
            )


def record_of(motion: Motion) -> dict[str, Any]:
    """The system of a certificate; ParameterError if proofs do not support the motion."""
    structure, load = motion.structure, motion.load
    check_structure(motion, structure, len(motion.rests))
    if motion.self_excited:
        raise ParameterError(
            f"motion = {motion!r}: must be without a free period, which proofs do not support"
        )
    gaps = []
    for gap in structure.gaps:
        values: dict[str, Any] = {
            name: getattr(gap, name) for name in ("direction", "opening", "restitution")
        }
        gaps.append({name: texts(value) for name, value in values.items()})
    return {
        "mass": texts(structure.mass), "damping": texts(structure.damping),
        "stiffness": texts(structure.stiffness),
        "gaps": gaps, "frequency": decimal(load.frequency), "sine": texts(load.sine), "cosine": texts(load.cosine),
        "constant": texts(load.constant), "impacts": [int(gap) for gap in motion.gaps],
    }  # fmt: skip


def mirror_of(motion: Motion, system: dict[str, Any]) -> list[int] | None:
    """For each gap the gap that -q closes when q closes it, if the motion is -q half a period later; else None."""
    even = [*system["sine"][1::2], *system["cosine"][1::2], system["constant"]]
    if motion.cycles % 2 == 0 or any(float(one) for row in even for one in row):
        return None
    gaps = [
        (tuple(map(float, gap["direction"])), float(gap["opening"]), float(gap["restitution"]))
        for gap in system["gaps"]
    ]
    turned = [(tuple(-one for one in direction), e, R) for direction, e, R in gaps]
    if len(set(gaps)) < len(gaps) or not all(gap in gaps for gap in turned):
        return None
    mirror = [gaps.index(gap) for gap in turned]
    impacts, half = system["impacts"], len(system["impacts"]) // 2
    same = [mirror[gap] for gap in impacts[:half]] == impacts[half:] and is_symmetric(motion)
    return mirror if same else None


class System:
    """The system of a certificate in balls; with `mirror`, the map of its gaps, over half a period."""

    def __init__(
        self, system: dict[str, Any], cycles: int, mirror: Sequence[int] | None = None
    ) -> None:
        module = flint()

        def matrix(rows: Any) -> Any:
            return module.arb_mat([[ball(one) for one in row] for row in rows])

        mass = matrix(system["mass"])
        self.n = n = mass.nrows()
        self.inverse = mass.inv()
        self.damping = self.inverse * matrix(system["damping"])
        self.rows = [[ball(one) for one in gap["direction"]] for gap in system["gaps"]]
        self.openings = [ball(gap["opening"]) for gap in system["gaps"]]
        self.restitution = [ball(gap["restitution"]) for gap in system["gaps"]]
        self.impacts, self.turn = system["impacts"], 1 if mirror is None else -1
        last = self.impacts[0] if mirror is None else mirror[self.impacts[0]]
        if mirror is not None:
            self.impacts = self.impacts[: len(self.impacts) // 2]
        # the gap at the end of each flight
        self.ends = [*self.impacts[1:], last]
        self.frequency = ball(system["frequency"])
        self.angle = module.arb.pi() * cycles * (2 if mirror is None else 1)
        self.period = self.angle / self.frequency
        self.harmonics = len(system["sine"])
        size = 2 * n + 1 + 2 * self.harmonics
        flow = module.arb_mat(size, size)
        parts = [
            (0, self.inverse * matrix(system["stiffness"]), -1), (n, self.damping, -1),
            (2 * n, self.inverse * matrix([[one] for one in system["constant"]]), 1),
        ]  # fmt: skip
        for h in range(self.harmonics):
            at = 2 * n + 1 + 2 * h
            for k, name in ((at, "cosine"), (at + 1, "sine")):
                parts.append((k, self.inverse * matrix([[one] for one in system[name][h]]), 1))
            turn = (h + 1) * self.frequency
            flow[at, at + 1], flow[at + 1, at] = -turn, turn
        for first, part, sign in parts:
            for i in range(n):
                for j in range(part.ncols()):
                    flow[n + i, first + j] = sign * part[i, j]
        for i in range(n):
            flow[i, n + i] = 1
        self.flow, self.square = flow, flow * flow
        # the velocity after an impact is a matrix times that before it
        self.jumps = []
        for row, R in zip(self.rows, self.restitution, strict=True):
            push = (self.inverse * module.arb_mat([[one] for one in row])).entries()
            factor = (1 + R) / self.dot(row, push)
            self.jumps.append(
                module.arb_mat(
                    [[(1 if i == j else 0) - factor * push[i] * row[j] for j in range(n)] for i in range(n)]
                )
            )  # fmt: skip

    @staticmethod
    def dot(one: Sequence[Any], two: Sequence[Any]) -> Any:
        """The sum of products."""
        return sum((a * b for a, b in zip(one, two, strict=True)), flint().arb(0))

    def extended(self, state: Sequence[Any]) -> Any:
        """(q, q', 1, cos, sin, ...) at the time state[0]."""
        module = flint()
        values = [*state[1:], module.arb(1)]
        for h in range(self.harmonics):
            sine, cosine = ((h + 1) * self.frequency * state[0]).sin_cos()
            values += [cosine, sine]
        return module.arb_mat([[one] for one in values])

    def flights(self, states: Sequence[Sequence[Any]]) -> list[Flight]:
        """The flight after each impact."""
        found = []
        for i, state in enumerate(states):
            j = (i + 1) % len(states)
            end = states[j][0] + (self.period if j == 0 else 0)
            start, duration = self.extended(state), end - state[0]
            matrix = (self.flow * duration).exp()
            landing = matrix * start
            gap = self.ends[i]
            speed = self.dot(self.rows[gap], landing.entries()[self.n : 2 * self.n])
            found.append(Flight(self.impacts[i], gap, duration, start, matrix, landing, speed))
        return found

    def residuals(self, states: Sequence[Sequence[Any]], found: Sequence[Flight]) -> list[Any]:
        """The residuals of the equations: q and q' after each impact, and the contact."""
        n, left = self.n, []
        for i, flight in enumerate(found):
            last = i + 1 == len(found)
            following, turn = (states[0], self.turn) if last else (states[i + 1], 1)
            z = flight.landing.entries()
            after = [*z[:n], *self.turned(flight.after, z[n : 2 * n])]
            left += [one - turn * two for one, two in zip(after, following[1:], strict=True)]
            left.append(self.dot(self.rows[flight.after], z[:n]) - self.openings[flight.after])
        return left

    def turned(self, gap: int, velocity: Sequence[Any]) -> list[Any]:
        """A velocity after an impact."""
        product: list[Any] = (
            self.jumps[gap] * flint().arb_mat([[one] for one in velocity])
        ).entries()
        return product

    def jacobian(self, found: Sequence[Flight]) -> Any:
        """The derivative of `residuals` with respect to the unknowns."""
        n = self.n
        size = 2 * n + 1
        matrix = flint().arb_mat(size * len(found), size * len(found))
        for i, flight in enumerate(found):
            j = (i + 1) % len(found)
            leaving = (self.flow * flight.start).entries()[: 2 * n]
            columns = [
                [-self.dot([flight.matrix[row, k] for k in range(2 * n)], leaving) for row in range(2 * n)]
            ]  # fmt: skip
            columns += [[flight.matrix[row, k] for row in range(2 * n)] for k in range(2 * n)]
            columns.append((self.flow * flight.landing).entries()[: 2 * n])
            places = [*range(size * i, size * i + size), size * j]
            for place, column in zip(places, columns, strict=True):
                values = [*column[:n], *self.turned(flight.after, column[n:])]
                values.append(self.dot(self.rows[flight.after], column[:n]))
                for row, value in enumerate(values):
                    matrix[size * i + row, place] += value
            for k in range(2 * n):
                matrix[size * i + k, size * j + 1 + k] -= self.turn if j == 0 else 1
        return matrix

    def period_map(self, found: Sequence[Flight]) -> Any:
        """[P] as a product of flights and saltation matrices, or the same over half a period with the mirror."""
        module, n = flint(), self.n
        product = module.arb_mat(
            2 * n, 2 * n, [int(i == j) for i in range(2 * n) for j in range(2 * n)]
        )
        for i, flight in enumerate(found):
            part = [[flight.matrix[row, k] for k in range(2 * n)] for row in range(2 * n)]
            before = (self.flow * flight.landing).entries()[n : 2 * n]
            last = i + 1 == len(found)
            after = (self.flow * found[0 if last else i + 1].start).entries()[n : 2 * n]
            after = [-one for one in after] if last and self.turn < 0 else after
            corner = [
                (one - two) / flight.speed
                for one, two in zip(after, self.turned(flight.after, before), strict=True)
            ]
            jump, row = self.jumps[flight.after], self.rows[flight.after]
            zero = [module.arb(0)] * n
            salt = [[jump[k, m] for m in range(n)] + zero for k in range(n)]
            salt += [
                [corner[k] * one for one in row] + [jump[k, m] for m in range(n)] for k in range(n)
            ]
            product = module.arb_mat(salt) * (module.arb_mat(part) * product)
        return product * self.turn

    def states_in(self, flight: Flight) -> Callable[[float, float, int], tuple[Any, Any, Any]]:
        """A function of pieces of a flight: q and q' at a time after the impact, and q'' within a width of it;
        `depth` is the number of halvings that led to the piece."""
        n = self.n
        powers: dict[int, Any] = {}

        def states(middle: float, width: float, depth: int) -> tuple[Any, Any, Any]:
            arb = flint().arb
            if depth not in powers or powers[depth][0] < width:
                powers[depth] = (width, (self.flow * arb(0, width)).exp())
            z = (self.flow * arb(middle)).exp() * flight.start
            bends = (self.square * (powers[depth][1] * z)).entries()[:n]
            entries = z.entries()
            return entries[:n], entries[n : 2 * n], bends

        return states

    def determinant(self) -> Any:
        """det[P] by its law: exp(-tr(M^-1 C) T) times the product of all R^2."""
        value = (-self.damping.trace() * self.period).exp()
        for gap in self.ends:
            value = value * self.restitution[gap] * self.restitution[gap]
        return value


@dataclass
class Flight:
    """A flight between impacts on the gaps `before` and `after`, with exp(A t) over it."""

    before: int
    after: int
    duration: Any
    start: Any
    matrix: Any
    landing: Any
    speed: Any


def krawczyk(system: System, centre: list[list[Any]], radii: list[Any]) -> list[list[Any]] | None:
    """The states of the one motion within `radii` of `centre`, as `verdicts.krawczyk`; None: not proven."""
    module, size = flint(), 2 * system.n + 1
    around = [[c + module.arb(0, r) for c, r in zip(row, radii, strict=True)] for row in centre]
    middle = module.arb_mat([[one] for one in system.residuals(centre, system.flights(centre))])
    derivative = system.jacobian(system.flights(around))
    try:
        inverse = approximate_inverse(derivative)
    except (np.linalg.LinAlgError, ValueError):
        return None
    n = size * len(centre)
    identity = module.arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
    spread = module.arb_mat([[module.arb(0, r)] for _ in centre for r in radii])
    shifts = ((identity - inverse * derivative) * spread - inverse * middle).entries()
    stated = [module.arb(r) for _ in centre for r in radii]
    if not all(abs(shift) < radius for shift, radius in zip(shifts, stated, strict=True)):
        return None
    return [[c + shifts[size * i + k] for k, c in enumerate(row)] for i, row in enumerate(centre)]


def newton(system: System, centre: list[list[Any]]) -> list[list[Any]]:
    """The states after a step of Newton's method, without bounds."""
    found, size = system.flights(centre), 2 * system.n + 1
    left = flint().arb_mat([[one] for one in system.residuals(centre, found)])
    try:
        step = system.jacobian(found).mid().solve(left).entries()
    except ZeroDivisionError:
        return centre
    return [
        [(c - step[size * i + k]).mid() for k, c in enumerate(row)] for i, row in enumerate(centre)
    ]


def is_inside(coefficients: Sequence[Any]) -> bool | None:
    """As `verdicts.inside`, also if the product of all zeros has the modulus 1, as without damping and losses."""
    found = inside(coefficients)
    if found is None:
        even, odd = sum(coefficients[::2]), sum(coefficients[1::2])
        # the degree is even, so a negative value at 1 or -1 means that a real zero lies beyond
        if even + odd < 0 or even - odd < 0:
            return False
    return found


def gaps_stay_open(system: Any, found: Sequence[Any]) -> tuple[bool | None, str]:
    """Whether each impact has an approach speed and all gaps stay open in flights, for all parameters where the
    numbers are models; and the reason if neither is proven."""
    for i, flight in enumerate(found):
        speed = span(flight.speed)
        if speed < 0:
            return False, ""
        if not speed > 0 or not span(system.restitution[flight.after]) > 0:
            return None, f"the speeds at the ends of flight {i} are not separated from zero"
    for i, flight in enumerate(found):
        clear = flight_is_open(system, flight)
        if clear is not True:
            return clear, "" if clear is False else f"flight {i} comes too close to a wall"
    return True, ""


def flight_is_open(system: Any, flight: Any) -> bool | None:
    """The same for one flight: on each piece a gap is open, or opens from or closes to the impact at its end."""
    arb, dot = flint().arb, System.dot
    duration, states = span(flight.duration), system.states_in(flight)
    whole, shortest = above(float(duration.upper())), -above(-float(duration.lower()))
    pieces = [(0.0, whole, 0, list(range(len(system.rows))))]
    while pieces:
        low, high, depth, gaps = pieces.pop()
        middle = (low + high) / 2
        width, left = above(max(high - middle, middle - low)), []
        q, v, bends = states(middle, width, depth)
        h, half = arb(0, width), arb(width) ** 2 / 2
        for gap in gaps:
            row = system.rows[gap]
            distance = span(system.openings[gap] - dot(row, q))
            rate, bend = -span(dot(row, v)), -dot(row, bends)
            if middle < shortest and distance < 0:
                return False
            speed = rate + h * bend
            opens = (
                distance + h * rate + (half * bend).union(arb(0)) > 0
                or (low == 0 and gap == flight.before and speed > 0)
                or (high >= shortest and gap == flight.after and speed < 0)
            )
            if not opens:
                left.append(gap)
        if left:
            if depth == MOST_HALVINGS:
                return None
            pieces += [(middle, high, depth + 1, left), (low, middle, depth + 1, left)]
    return True


def attempt(system: System, states: Any, size: float) -> tuple[dict[str, Any], str]:
    """A box of a certificate, empty if existence is not proven, and the reason for undecided items."""
    module, n = flint(), system.n
    largest = [1 / float(system.frequency), *([np.abs(states[:, 1 : n + 1]).max()] * n)]
    largest += [np.abs(states[:, n + 1 :]).max()] * n
    largest = [one or 1.0 for one in largest]
    centre = [[module.arb(float(value)) for value in row] for row in states]
    for _ in range(NEWTON if module.ctx.prec > LEAST_BITS else 0):
        centre = newton(system, centre)
    radii = [module.arb(float(one) * size) for one in largest]
    enclosed = krawczyk(system, centre, radii)
    if enclosed is None:
        return {}, NO_MOTION
    # a motion within a box is also within its image, which is narrower
    middle = [[one.mid() for one in row] for row in enclosed]
    size_now = [
        module.arb(max(float(row[k].rad()) for row in enclosed) * 4 + 1e-300) for k in range(2 * n + 1)
    ]  # fmt: skip
    enclosed = krawczyk(system, middle, size_now) or enclosed
    found = system.flights(enclosed)
    if not all(flight.duration > 0 for flight in found):
        return {}, NO_ORDER
    box: dict[str, Any] = {
        "sheet": 0, "parameters": {}, "centre": [[[hexadecimal(one)] for one in row] for row in centre],
        "radius": [[hexadecimal(one) for one in radii]] * len(centre),
        "exists": True, "admissible": None, "stable": None,
        "multipliers_below": None, "multipliers_above": None, "attenuation_below": None,
    }  # fmt: skip
    box["admissible"], reason = gaps_stay_open(system, found)
    if not all(abs(flight.speed) > 0 for flight in found):
        return box, reason or NO_SPEED
    coefficients = system.period_map(found).charpoly().coeffs()
    coefficients[0] = system.determinant()
    box["stable"] = stable = is_inside(coefficients)
    if stable is None:
        return box, "; ".join(filter(None, [reason, NEAR_CIRCLE]))
    bound = multiplier_bound(coefficients, stable, 2 if system.turn < 0 else 1)
    if bound is not None:
        box["multipliers_below" if stable else "multipliers_above"] = decimal_text(bound)
    return box, reason


def prove_structure(
    motion: Motion, progress: Callable[[float, str], None] | None = None
) -> Certificate:
    """As `Motion.prove`, for a structure."""
    begin = time.perf_counter()
    record = record_of(motion)
    mirror = mirror_of(motion, record)
    times = motion.phases / motion.load.frequency
    states = np.column_stack([times, motion.states.reshape(len(times), -1)])
    if mirror is not None:
        states = states[: len(states) // 2]
    box: dict[str, Any] = {}
    reason = NO_MOTION
    for number, (bits, size) in enumerate(ATTEMPTS):
        if progress is not None:
            progress(number / len(ATTEMPTS), f"{bits} bits")
        with flint().ctx.workprec(bits):
            found, why = attempt(System(record, motion.cycles, mirror), states, size)
        if found or not box:
            box, reason = found, why
        if box and None not in (box["admissible"], box["stable"]):
            break
    return Certificate(
        "motion", " ".join(map(str, record["impacts"])), motion.cycles, mirror is not None, record, [{}],
        [box] if box else [], [{"reason": reason}] if reason else [],
        time.perf_counter() - begin,
    )  # fmt: skip
