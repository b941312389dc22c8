"""Proofs for all parameters in a box: unknowns as Taylor models, Krawczyk's operator around them, verdicts.

Given the phase theta of the steady motion A sin(theta) at an impact of a motion with one flight in half a period,
everything else, including the clearance, follows from linear equations. In units of A cos(theta), all lengths,
speeds and [Q] are polynomials in tan(theta). Therefore `tangent` may be a parameter, with the clearance in these
units as an unknown.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..motions.likeness import is_symmetric
from ..motions.motion import Motion
from .balls import ball, decimal, decimal_text, flint, hexadecimal, upward
from .equations import System, characteristic, determinant, flights, jacobian, period_map, residuals
from .models import Model, Space, at_middle, coefficients, space, span
from .verdicts import approximate_inverse, between_walls, inside_all

_Array = NDArray[np.float64]
#: Parameters of a system other than the coefficients of restitution.
PARAMETERS = ("xi", "mu", "r", "clearance", "load")
#: The degree of the polynomials, by the number of parameters that vary; 1 for other numbers.
DEGREES = {1: 5, 2: 3, 3: 2, 4: 2}
#: The degree in r and `tangent`.
EXPLICIT_DEGREE = 5
#: The initial radius of the box of uniqueness, relative to the unknowns.
UNIQUE = (2.0**-7, 2.0**-11, 2.0**-16)
#: The least size of an unknown, relative to the largest one.
LEAST = 2.0**-10
#: Fractions of that radius that are stated if they are enough for the proof: other methods than this one give
#: wider enclosures of the derivatives in a box.
STATED = (2.0**-6, 2.0**-4, 2.0**-2)
#: Steps of Newton's method, and the relative step after which it has converged.
NEWTON, CLOSE = 8, 1e-13
#: Why motions with rest are rejected.
WITHOUT_REST = "must be without rest, which proofs do not support"
#: Reasons why a box is not decided.
NO_MOTION = "Newton's method does not contract in a box around it (near a fold, pitchfork or graze)"
NEAR_CIRCLE = "stability: a multiplier is too close to the unit circle"
NO_ORDER = "the order of the impacts in time is not proven"
NO_SPEED = "stability: an impact may have no approach speed"
NO_REBOUND = "R = 0: the masses do not separate after an impact"


def sizes_of(states: _Array) -> _Array:
    """The size of each unknown of an impact: 1 for the phases, the largest magnitude for the other unknowns.

    An unknown that vanishes in the motion, such as X' without losses, still needs a nonzero size.
    """
    largest = np.abs(states).max(axis=0)
    largest[1:] = np.maximum(largest[1:], LEAST * largest[1:].max())
    largest[0] = 1.0
    return np.tile(largest, len(states))


class Motions(Protocol):
    """The motions of a system for some parameters."""

    def problem(self, box: Box, facing: int) -> Problem:
        """Their equations in a box."""


@dataclass(frozen=True)
class Family:
    """The motions of a word for some parameters.

    Attributes
    ----------
    values : dict of str
        The texts of xi, mu, r, clearance, load; for parameters that vary, the initial value.
    walls : tuple of str
        The texts of the coefficients of restitution of all impacts.
    sides, cycles, symmetric
        As in a certificate. The impacts of symmetric motions are those of half a period.
    """

    values: Mapping[str, str]
    walls: tuple[str, ...]
    sides: str
    cycles: int
    symmetric: bool

    @classmethod
    def of(cls, motion: Motion) -> Family:
        """The family of a motion.

        Raises
        ------
        ParameterError
            If the equations do not apply because the motion belongs to a structure, has rest, or has no load.
        """
        if motion.of_structure:
            raise ParameterError(
                f"motion = {motion!r}: must be a motion of an Oscillator; a Structure is not supported"
            )
        sides = motion.pattern.sides
        if motion.pattern.has_rest:
            raise ParameterError(f"motion = {motion!r}: {WITHOUT_REST}")
        if not motion.load > 0:
            raise ParameterError(f"motion = {motion!r}: must have a load above 0 for a proof")
        numbers = (motion.osc.xi, motion.osc.mu, motion.r, motion.clearance, motion.load)
        values = dict(zip(PARAMETERS, map(decimal, numbers), strict=True))
        walls = tuple(map(decimal, motion.restitution.tolist()))
        half = len(sides) // 2
        symmetric = walls[:half] == walls[half:] and is_symmetric(motion)
        return cls(values, walls, sides, motion.cycles, symmetric)

    @property
    def word(self) -> str:
        """The walls of the impacts whose states are unknown."""
        return self.sides[: len(self.sides) // 2] if self.symmetric else self.sides

    def system(self, values: Mapping[str, Any], steady: Any = None) -> System:
        """The system at values, or models, of the parameters that vary."""
        known = {name: ball(text) for name, text in self.values.items()} | dict(values)
        walls = []
        for side, text in zip(self.word, self.walls, strict=False):
            own = values.get("restitution", values.get("R1" if side == "R" else "R2"))
            walls.append(ball(text) if own is None else own)
        signs = [1 if side == "R" else -1 for side in self.word]
        xi, mu, r, clearance, load = (known[name] for name in PARAMETERS)
        return System(xi, mu, r, clearance, load, walls, signs, self.cycles, self.symmetric, steady)

    @property
    def width(self) -> int:
        """The number of unknowns of an impact."""
        return 4

    def problem(self, box: Box, facing: int) -> Problem:
        """Its equations in a box."""
        return Problem(self, box, facing)

    def sizes(self, states: _Array) -> _Array:
        """The size of each unknown."""
        return sizes_of(states)

    def record(self) -> dict[str, Any]:
        """The system of a certificate."""
        return {**self.values, "restitution": list(self.walls)}

    def states(self, motion: Motion) -> _Array:
        """The unknowns of a motion, (impacts, 4)."""
        columns = (motion.phases, motion.X, motion.X_dot_after, motion.Z_dot_after)
        return np.stack(columns, axis=1)[: len(self.word)]


@dataclass
class Box:
    """Intervals of some parameters, and the statements proven for all values in them.

    Attributes
    ----------
    span : dict of str
        (lowest, highest) of each parameter.
    centre : ndarray (4 impacts, monomials)
        The polynomials around which the unknowns lie.
    radius : list of float
        The distance within which there is exactly one motion.
    radii : list of list of float
        All such distances that are proven, in ascending order.
    error : list
        Balls that bound the distance within which this motion lies.
    middle : ndarray (4 impacts, 1 + parameters)
        The unknowns at the middle and their change to the upper end of each parameter.
    effects : ndarray
        The largest change by each parameter, relative to the sizes of the unknowns.
    depth : int
        The number of halvings that led to this box.
    start : ndarray
        Unknowns near those at the middle.
    """

    span: dict[str, tuple[Fraction, Fraction]]
    centre: _Array | None = None
    radius: list[float] = field(default_factory=list)
    radii: list[list[float]] = field(default_factory=list)
    error: list[Any] = field(default_factory=list)
    middle: _Array | None = None
    effects: _Array = field(default_factory=lambda: np.zeros(0))
    exists: bool | None = None
    admissible: bool | None = None
    stable: bool | None = None
    multipliers_below: str | None = None
    attenuation_below: str | None = None
    reason: str = ""
    depth: int = 0
    start: _Array | None = None

    @property
    def decided(self) -> bool:
        """Whether all verdicts are decided."""
        return self.exists is False or None not in (self.exists, self.admissible, self.stable)

    def halves(self) -> tuple[Box, Box]:
        """Both halves along the parameter that has the largest effect."""
        names = list(self.span)
        place = int(np.argmax(self.effects)) if len(self.effects) else self.depth % len(names)
        low, high = self.span[names[place]]
        middle = (low + high) / 2
        one, two = (
            Box(self.span | {names[place]: part}, depth=self.depth + 1, start=self.start)
            for part in ((low, middle), (middle, high))
        )
        if self.middle is not None:
            slope = self.middle[:, 1 + place] / 2
            one.start, two.start = self.middle[:, 0] - slope, self.middle[:, 0] + slope
        return one, two

    def record(self, width: int = 4) -> dict[str, Any]:
        """The box as an item of a certificate; `width` is the number of unknowns of an impact."""
        spans = {name: [str(low), str(high)] for name, (low, high) in self.span.items()}
        found: dict[str, Any] = {"parameters": spans}
        if self.centre is not None:
            arb = flint().arb
            rows = [[hexadecimal(arb(one)) for one in row] for row in self.centre.tolist()]
            radii = [hexadecimal(arb(one)) for one in self.radius]
            found["centre"] = [rows[k : k + width] for k in range(0, len(rows), width)]
            found["radius"] = [radii[k : k + width] for k in range(0, len(rows), width)]
        names = ("exists", "admissible", "stable", "multipliers_below", "attenuation_below")
        return found | {name: getattr(self, name) for name in names}


class Problem:
    """The equations of a family in a box."""

    def __init__(self, family: Family, box: Box, facing: int = 1) -> None:
        names = list(box.span)
        degree = EXPLICIT_DEGREE if "tangent" in names else DEGREES.get(len(names), 1)
        self.space: Space = space(len(names), degree)
        middles = {name: ball((low + high) / 2) for name, (low, high) in box.span.items()}
        models = {
            name: self.space.parameter(k, middles[name], ball((high - low) / 2))
            for k, (name, (low, high)) in enumerate(box.span.items())
        }
        self.explicit = "tangent" in models
        self.box_values = {name: model.range() for name, model in models.items()}
        self.system: Any = self._system(family, models, facing)
        self.middle: Any = self._system(family, middles, facing)

    @staticmethod
    def _system(family: Family, values: dict[str, Any], facing: int) -> System:
        """The system at values of the parameters."""
        tangent = values.pop("tangent", None)
        # the phases are measured from the impact
        steady = None if tangent is None else (facing, tangent * facing)
        return family.system(values, steady)

    def states(self, system: System, unknowns: Sequence[Any]) -> tuple[System, list[list[Any]]]:
        """The system and the states."""
        values = list(unknowns)
        if self.explicit:
            system = copy.copy(system)
            system.clearance, system.half = values[0], values[0] / 2
            values[0] = flint().arb(0)
        return system, [values[k : k + 4] for k in range(0, len(values), 4)]

    def left(self, system: System, unknowns: Sequence[Any]) -> list[Any]:
        """The residuals of the equations."""
        system, states = self.states(system, unknowns)
        return residuals(system, states, flights(system, states))

    def slopes(self, system: System, unknowns: Sequence[Any]) -> list[list[Any]]:
        """Their derivatives."""
        system, states = self.states(system, unknowns)
        found = flights(system, states)
        matrix = jacobian(system, found)
        if self.explicit:
            for i, row in enumerate(matrix):
                flight = found[i // 4]
                row[0] = (flight.before - flight.after) / 2 if i % 4 == 1 else 0
        return matrix

    def newton(self, start: _Array) -> tuple[_Array, Any] | None:
        """The unknowns at the middle, from a nearby guess, and the inverse of the derivative there."""
        module = flint()
        values = start
        for _ in range(NEWTON):
            unknowns = [module.arb(one) for one in values.tolist()]
            slopes = self.slopes(self.middle, unknowns)
            try:
                inverse = approximate_inverse(
                    module.arb_mat([[module.arb(one) for one in row] for row in slopes])
                )
            except (np.linalg.LinAlgError, ValueError):
                return None
            step = inverse * module.arb_mat([[one] for one in self.left(self.middle, unknowns)])
            shift = np.array([float(one.mid()) for one in step.entries()])
            values = values - shift
            if not np.all(np.isfinite(values)):
                return None
            if np.all(np.abs(shift) <= CLOSE * (np.abs(values) + np.abs(values).max())):
                return values, inverse
        return None

    def models(self, centre: _Array, radius: Sequence[Any] | None = None) -> list[Any]:
        """Polynomials, widened by a radius."""
        arb = flint().arb
        found = [Model(self.space, [arb(one) for one in row]) for row in centre.tolist()]
        if radius is None:
            return found
        return [one.widened(size) for one, size in zip(found, radius, strict=True)]

    def layers(self, matrix: Sequence[Sequence[Any]]) -> list[Any]:
        """A matrix of models as one matrix of balls for each monomial."""
        rows = [[coefficients(one, self.space) for one in row] for row in matrix]
        return [
            flint().arb_mat([[one[k] for one in row] for row in rows])
            for k in range(len(self.space.monomials))
        ]

    def judge(self, box: Box, bounds: bool) -> None:
        """The verdicts on the motions in a box."""
        assert box.centre is not None
        system, states = self.states(self.system, self.models(box.centre, box.error))
        found = flights(system, states)
        if not all(span(flight.tau) > 0 for flight in found):
            box.exists, box.centre, box.reason = None, None, NO_ORDER
            return
        box.admissible, largest, box.reason = between_walls(system, found)
        if box.admissible and bounds:
            steady = span(system.sine * system.sine + system.cosine * system.cosine).sqrt()
            box.attenuation_below = decimal_text(upward(largest / steady, 4))
        polynomial = characteristic(period_map(system, found), determinant(system))
        box.stable = inside_all(polynomial)
        if box.stable is None:
            box.reason = "; ".join(filter(None, [box.reason, NEAR_CIRCLE]))
        elif box.stable and bounds:
            box.multipliers_below = bound_in_box(polynomial, system.mirrored)


def bound_of(layers: Sequence[Any]) -> Any:
    """A matrix of bounds of the moduli of models."""
    module = flint()
    rows, columns = layers[0].nrows(), layers[0].ncols()
    entries = [[abs(one) for one in layer.entries()] for layer in layers]
    return module.arb_mat(
        rows, columns, [sum(values[1:], values[0]).upper() for values in zip(*entries, strict=True)]
    )


def enclose(problem: Problem, box: Box, sizes: _Array) -> bool:
    """Prove that there is exactly one motion near the start of a box, for all of its parameters."""
    module = flint()
    assert box.start is not None
    found = problem.newton(box.start)
    if found is None:
        return False
    middle, inverse = found
    n, terms = len(middle), len(problem.space.monomials)
    centre = np.zeros((n, terms))
    centre[:, 0] = middle
    matrix = np.array([[float(one) for one in row] for row in inverse.tolist()])
    for _ in range(problem.space.degree):
        left = problem.left(problem.system, problem.models(centre))
        rest = np.array(
            [[float(one.mid()) for one in coefficients(row, problem.space)] for row in left]
        )
        centre = centre - matrix @ rest
        if not np.all(np.isfinite(centre)):
            return False
        if not len(box.effects):
            box.middle = centre[:, : 1 + len(box.span)].copy()
            box.effects = np.max(np.abs(box.middle[:, 1:]) / sizes[:, None], axis=0)
    left = [[one] for one in problem.left(problem.system, problem.models(centre))]
    shift = bound_of([inverse * layer for layer in problem.layers(left)])
    identity = module.arb_mat(n, n, [int(k % (n + 1) == 0) for k in range(n * n)])

    def contracts(radius: Sequence[float], strictly: bool = True) -> bool:
        """Whether Krawczyk's operator maps a distance from the polynomials to a smaller one."""
        stated = module.arb_mat([[module.arb(one)] for one in radius])
        image = shift + moved * stated
        pairs = [(image[k, 0], stated[k, 0]) for k in range(n)]
        return all(one < two if strictly else one <= two for one, two in pairs)

    for unique in UNIQUE:
        around = [module.arb(one * unique) for one in sizes.tolist()]
        layers = [
            inverse * one
            for one in problem.layers(
                problem.slopes(problem.system, problem.models(centre, around))
            )
        ]
        layers[0] = identity - layers[0]
        moved = bound_of(layers)
        try:
            # v - moved v = ones, in doubles: then moved v < v
            doubles = np.array([[float(one) for one in row] for row in moved.tolist()])
            weights = np.linalg.solve(np.eye(n) - doubles, sizes)
        except (np.linalg.LinAlgError, ValueError):
            continue
        if not np.all(weights > 0):
            continue
        radius = (weights * (unique * np.min(sizes / weights) * (1 - 2.0**-40))).tolist()
        if contracts(radius):
            break
    else:
        return False
    # its distance d from the polynomials has d <= shift + moved d, so any solution of this with >= is above it
    error = np.linalg.solve(np.eye(n) - doubles, [float(one) for one in shift.entries()])
    error = np.minimum(np.abs(error) * (1 + 2.0**-30) + np.finfo(float).tiny, radius)
    if not contracts(error.tolist(), strictly=False):
        error = np.array(radius)
    # the image is linear in the radius, so it lies inside boxes between these two as well
    between = [(error + (np.array(radius) - error) * share).tolist() for share in STATED]
    box.radii = [one for one in between if contracts(one)] + [radius]
    box.centre, box.radius, box.exists = centre, box.radii[0], True
    box.error = [module.arb(one) for one in error.tolist()]
    return True


def cover(
    family: Motions,
    box: Box,
    sizes: _Array,
    halvings: int,
    most: int,
    start: Callable[[Box], _Array] | None = None,
    told: Callable[[float], None] | None = None,
) -> list[Box]:
    """Proven boxes in order, and boxes not proven after the given numbers of halvings and boxes.

    `told` is called with the fraction of the box that is done.
    """
    found, waiting = [], [box]
    tried, done = 0, 0.0
    while waiting:
        box = waiting.pop()
        if start is not None:
            box.start = start(box)
        if tried < most:
            tried += 1
            prove_over(family, box, sizes)
        else:
            box.reason = f"more than {most} boxes"
        if not box.decided and box.depth < halvings and tried < most:
            waiting += box.halves()[::-1]
        else:
            found.append(box)
            done += 0.5**box.depth
            if told is not None:
                told(done)
    return found


def prove_over(
    family: Motions, box: Box, sizes: _Array, bounds: bool = True, facing: int = 1
) -> None:
    """Prove as much as possible about a box, and store the verdicts in it."""
    if any(low <= 0 for name, (low, _) in box.span.items() if is_restitution(name)):
        box.reason = NO_REBOUND
        return
    try:
        # near resonance the amplitude over a wide box may have no bound
        problem = family.problem(box, facing)
        if not enclose(problem, box, sizes):
            box.reason = NO_MOTION
            return
        problem.judge(box, bounds)
    except ZeroDivisionError:
        box.reason = box.reason or (NO_SPEED if box.exists else NO_MOTION)


def is_restitution(name: str) -> bool:
    """Whether a parameter is a coefficient of restitution."""
    return name in ("R1", "R2") or name.partition("_")[0] == "restitution"


def bound_in_box(polynomial: Sequence[Any], mirrored: bool) -> str | None:
    """A strict upper bound of max|lambda| in a box."""
    middle = [float(flint().arb(at_middle(one)).mid()) for one in polynomial]
    largest = float(np.max(np.abs(np.roots(middle[::-1])))) ** (2 if mirrored else 1)
    for share in (0.02, 0.1, 0.3, 0.6):
        text = f"{largest + share * (1 - largest):.4f}"
        radius = ball(text).sqrt() if mirrored else ball(text)
        power, scaled = radius**0, []
        for one in polynomial[::-1]:
            scaled.append(one * power)
            power = power / radius
        if inside_all(scaled[::-1]):
            return text
    return None
