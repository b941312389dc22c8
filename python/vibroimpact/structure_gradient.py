"""Derivatives of periodic motions of structures by their parameters.

Between impacts the state, with the load as further coordinates, moves by a matrix exponential. From each impact to
the next, the state just after it and its phase change by a closed form, which is analytic in all parameters. A
step of 1e-30 i of a parameter therefore gives derivatives without rounding errors of differences: of the state at
the next impact, and of the matrix that carries small changes there, from which those of multipliers follow.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from . import checks
from .errors import ParameterError, ParameterTypeError
from .gradient import GRAZE, Gradient, frozen
from .restitution import PowerLaw, TabulatedRestitution
from .status import raise_status, status_text
from .structure import Load, Structure
from .structure_path import (
    CONSTANT,
    COSINE,
    DIRECTION,
    FREQUENCY,
    MATRICES,
    OPENING,
    RESTITUTION,
    SINE,
    entries_of,
    series_of,
)

if TYPE_CHECKING:
    from .structure_motion import StructureMotion

__all__: list[str] = []

_Array = NDArray[Any]
#: A parameter: its name, or a name with a function of it that gives the structure and the load, and its value.
Wanted = str | tuple[str, Callable[[float], tuple[Structure, Load]], float]
#: The imaginary step.
STEP = 1e-30
#: Relative error of a motion that counts as exact; condition number at a fold; approach speed, over the largest
#: velocity, at a graze; cosine between the eigenvectors of a double multiplier.
EXACT, SINGULAR, TOUCHING, DEFECT = 1e-8, 1e10, 1e-9, 1e-5
#: Codes of the core's vi_status.
FOLD, NOT_EXACT, COINCIDENT, NOT_SMOOTH = 25, 27, 28, 29
#: The kinds of entries by the words of names.
WORDS = {name: kind for kind, name in MATRICES.items()} | {
    "opening": OPENING, "restitution": RESTITUTION, "frequency": FREQUENCY, "constant": CONSTANT, "load": COSINE,
}  # fmt: skip
QUANTITIES = ("phases", "speeds", "impulses", "q", "q_dot")


class System:
    """A structure under a load with complex entries, by the load phase in place of time."""

    def __init__(self, structure: Structure, load: Load, values: _Array) -> None:
        """From the values of `entries_of`."""
        places = entries_of(structure, load)[0] - (0, 1, 1)
        self.structure, self.n = structure, structure.coordinates
        n, gaps, harmonics = self.n, len(structure.gaps), len(load.sine)

        def table(kind: int, *shape: int) -> _Array:
            here = places[:, 0] == kind
            found = np.zeros(shape, values.dtype)
            found[tuple(places[here, 1 : 1 + len(shape)].T)] = values[here]
            return found

        mass, damping, stiffness = (
            np.tril(lower := table(kind, n, n)) + np.tril(lower, -1).T for kind in MATRICES
        )
        self.frequency = values[places[:, 0] == FREQUENCY][0]
        self.directions = table(DIRECTION, n, gaps).T
        self.openings, self.first = table(OPENING, gaps), table(RESTITUTION, gaps)
        forces = np.column_stack(
            [table(CONSTANT, n), table(COSINE, n, harmonics), table(SINE, n, harmonics)]
        )
        size = 2 * n + forces.shape[1]
        self.rate = np.zeros((size, size), values.dtype)
        self.rate[:n, n : 2 * n] = np.eye(n)
        self.rate[n : 2 * n] = np.linalg.solve(mass, np.hstack([-stiffness, -damping, forces]))
        self.rate /= self.frequency
        for h in range(1, harmonics + 1):
            cosine, sine = 2 * n + h, 2 * n + harmonics + h
            self.rate[cosine, sine], self.rate[sine, cosine] = -h, h
        self.mobility = np.linalg.solve(mass, self.directions.T).T
        self.effective = 1 / (self.directions * self.mobility).sum(axis=1)

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

    def strike(self, gap: int, state: _Array) -> tuple[_Array, Any, Any, Any]:
        """State after an impact, approach speed, impulse, and derivative of the impulse by the speed."""
        speed = self.directions[gap] @ state[self.n : 2 * self.n]
        value, slope = self.restitution(gap, speed)
        impulse = (1 + value) * self.effective[gap] * speed
        after = state.copy()
        after[self.n : 2 * self.n] -= impulse * self.mobility[gap]
        return after, speed, impulse, (1 + value + slope * speed) * self.effective[gap]

    def turned(self, state: _Array) -> _Array:
        """The rate of the load's coordinates alone."""
        found = self.rate @ state
        found[: 2 * self.n] = 0
        return found


@dataclass
class Flown:
    """A period from just after the first impact: what is there at each impact, the first one at last."""

    phases: list[Any]
    states: list[_Array]
    speeds: list[Any]
    impulses: list[Any]
    matrix: _Array


def exponential(matrix: _Array) -> _Array:
    """exp(matrix), by a Taylor polynomial of the matrix over a power of 2, squared again."""
    squarings = max(0, int(np.ceil(np.log2(max(1e-300, np.abs(matrix).sum(axis=1).max())))) + 1)
    scaled = matrix / 2.0**squarings
    total = term = np.eye(len(matrix), dtype=matrix.dtype)
    for i in range(1, 22):
        term = term @ scaled / i
        total = total + term
    for _ in range(squarings):
        total = total @ total
    return total


def flown(
    system: System, motion: StructureMotion, flights: list[_Array], durations: _Array, start: _Array, phase: Any
) -> Flown:  # fmt: skip
    """The period from a start, complex in its small changes; the durations follow from the contacts."""
    n, count = system.n, len(motion.gaps)
    found = Flown([], [], [], [], np.eye(2 * n + 1))
    state = start
    for i in range(count):
        gap = int(motion.gaps[(i + 1) % count])
        direction = system.directions[gap]
        before = flights[i] @ state
        rate = system.rate @ before
        # to the instant of contact, by the linear part: nothing else is left of an imaginary step
        shift = -1j * (direction @ before[:n] - system.openings[gap]).imag / (direction @ rate[:n])
        matrix = flights[i] + shift * system.rate @ flights[i]
        before = before + shift * rate
        rate = system.rate @ before
        by = np.empty((2 * n, 2 * n + 1), matrix.dtype)
        by[:, :-1] = matrix[: 2 * n, : 2 * n]
        by[:, -1] = (matrix @ system.turned(state) - rate)[: 2 * n]
        later = -(direction @ by[:n]) / (direction @ rate[:n])
        by += np.outer(rate[: 2 * n], later)
        state, speed, impulse, slope = system.strike(gap, before)
        by[n:] -= slope * np.outer(system.mobility[gap], direction @ by[n:])
        found.matrix = np.vstack([by, later]) @ found.matrix
        phase = phase + durations[i] + shift
        found.phases.append(phase)
        found.states.append(state)
        found.speeds.append(speed)
        found.impulses.append(impulse)
    return found


def structure_gradient(motion: StructureMotion, parameters: Sequence[Wanted] | None) -> Gradient:
    """The derivatives of a motion of a structure without rest."""
    structure, load, n, count = (
        motion.structure,
        motion.load,
        motion.structure.coordinates,
        len(motion.gaps),
    )
    if len(motion.rests):
        raise ParameterError(f"{motion!r}: must be without rest to have derivatives by parameters")
    if parameters is None:
        each = range(len(structure.gaps))
        parameters = ["frequency"]
        parameters += ["load"] if np.any(load.sine) or np.any(load.cosine) else []
        parameters += [f"opening_{j}" for j in each]
        parameters += [
            f"restitution_{j}" for j in each
            if not isinstance(structure.gaps[j].restitution, TabulatedRestitution)
        ]  # fmt: skip
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise ParameterTypeError(f"parameters = {parameters!r}: must be a list of parameters")
    rates = [rates_of(structure, load, parameter) for parameter in parameters]
    names = tuple(
        parameter if isinstance(parameter, str) else parameter[0] for parameter in parameters
    )
    values = entries_of(structure, load)[1]
    system = System(structure, load, values)
    durations = np.diff(motion.phases, append=motion.phases[0] + 2 * np.pi * motion.cycles)
    harmonics = np.arange(1, len(load.sine) + 1) * motion.phases[0]
    start = np.concatenate(
        [motion.q, motion.q_dot, [1.0], np.cos(harmonics), np.sin(harmonics)]
    ).astype(complex)
    flights = [exponential(system.rate * duration) for duration in durations]
    base = flown(system, motion, flights, durations, start, motion.phases[0])
    scale = np.repeat(
        [np.abs(part).max() + 1e-300 for part in (motion.q, motion.states[:, 1], [1.0])], [n, n, 1]
    )
    closed = np.abs(base.states[-1] - start)[: 2 * n] / scale[:-1]
    if not closed.max() < EXACT:
        raise_status(NOT_EXACT)
    speeds = np.array(base.speeds).real
    if not speeds.min() > TOUCHING * np.abs(motion.states[:, 1]).max():
        raise_status(GRAZE)
    matrix = (base.matrix * scale / scale[:, None]).real
    inverse = inverse_of(system, motion, matrix, scale)
    by_quantity: dict[str, list[_Array]] = {name: [] for name in QUANTITIES}
    by_matrix = []
    for rate in rates:
        system = System(structure, load, values + 1j * STEP * rate)
        flights = [exponential(system.rate * duration) for duration in durations]
        moved = flown(system, motion, flights, durations, start, motion.phases[0])
        last = np.append(moved.states[-1][: 2 * n], moved.phases[-1]).imag / STEP
        change = scale * (inverse @ (last / scale))
        begin = start.copy()
        begin[: 2 * n] += 1j * STEP * change[:-1]
        begin += 1j * STEP * change[-1] * system.turned(start)
        moved = flown(
            system, motion, flights, durations, begin, motion.phases[0] + 1j * STEP * change[-1]
        )
        by_matrix.append((moved.matrix * scale / scale[:, None]).imag / STEP)
        states = np.array(moved.states).imag / STEP
        for name, table in {
            "phases": moved.phases, "speeds": moved.speeds, "impulses": moved.impulses, "q": states[:, :n],
            "q_dot": states[:, n : 2 * n],
        }.items():  # fmt: skip
            values_of = np.array(table)
            if np.iscomplexobj(values_of):
                values_of = values_of.imag / STEP
            by_quantity[name].append(np.roll(values_of, 1, axis=0))
    found: dict[str, _Array] = {
        "phases": motion.phases, "speeds": motion.speeds, "impulses": motion.impulses,
        "q": motion.states[:, 0], "q_dot": motion.states[:, 1], "multipliers": motion.multipliers,
        "stability_margin": np.asarray(1 - np.abs(motion.multipliers).max(initial=0.0)),
    }  # fmt: skip
    slopes: dict[str, _Array] = {
        name: np.stack(tables, axis=-1) for name, tables in by_quantity.items()
    }
    slopes["multipliers"], status = multiplier_slopes(
        matrix, np.array(by_matrix), motion.multipliers
    )
    slopes["stability_margin"] = margin_slopes(motion.multipliers, slopes["multipliers"], status)
    dimensions: dict[str, tuple[str, ...]] = {
        "phases": ("impact",), "speeds": ("impact",), "impulses": ("impact",), "q": ("impact", "coordinate"),
        "q_dot": ("impact", "coordinate"), "multipliers": ("multiplier",), "stability_margin": (),
    }  # fmt: skip
    of = f"a motion of a structure with {count} impact{'s' if count != 1 else ''} in {motion.cycles} cycles"
    return Gradient(
        of, names, found, {name: frozen(table) for name, table in slopes.items()}, dimensions, status
    )  # fmt: skip


def inverse_of(system: System, motion: StructureMotion, matrix: _Array, scale: _Array) -> _Array:
    """The inverse of 1 - matrix, of the derivative of a period in units `scale`.

    A body that hits nothing may rest anywhere: a shift of it, which changes no gap that closes, is left out.
    """
    left, sizes, right = np.linalg.svd(np.eye(len(matrix)) - matrix)
    shifts = sizes < sizes[0] / SINGULAR
    changes = scale * right[shifts]
    used = system.directions[np.unique(motion.gaps)].real
    closing = changes[:, : system.n] @ used.T / (scale[0] * np.abs(used).max())
    if (np.abs(closing) > 1e-6).any() or (np.abs(changes[:, -1]) > 1e-6).any():
        raise_status(FOLD)
    kept = ~shifts
    inverse: _Array = (right[kept].T / sizes[kept]) @ left[:, kept].T
    return inverse


def multiplier_slopes(
    matrix: _Array, by_matrix: _Array, multipliers: _Array
) -> tuple[_Array, dict[str, str]]:
    """The derivatives of the eigenvalues of a matrix next to given ones; NaN for double ones.

    The matrix has one eigenvalue 0 more: states just after an impact lie on the closed gap.
    """
    values, vectors = np.linalg.eig(matrix)
    found = np.full((len(multipliers), len(by_matrix)), np.nan, complex)
    status: dict[str, str] = {}
    left_values, left_vectors = np.linalg.eig(matrix.T)
    free = np.ones(len(values), bool)
    size = np.abs(values).max()
    for k, multiplier in enumerate(multipliers):
        j = int(np.where(free, np.abs(values - multiplier), np.inf).argmin())
        free[j] = False
        right, left = vectors[:, j], left_vectors[:, int(np.abs(left_values - values[j]).argmin())]
        overlap = left @ right
        apart = np.delete(np.abs(values - values[j]), j).min(initial=np.inf)
        if np.abs(overlap) < DEFECT or apart < 1e-9 * size + 1e-7 * np.abs(values[j]):
            status[f"multipliers[{k}]"] = status_text(COINCIDENT)
        else:
            found[k] = np.einsum("i,pij,j", left, by_matrix, right) / overlap
    return found, status


def margin_slopes(multipliers: _Array, slopes: _Array, status: dict[str, str]) -> _Array:
    """The derivatives of 1 - max|lambda|; NaN where two multipliers are the largest and change differently."""
    sizes = np.abs(multipliers)
    leading = np.flatnonzero(sizes >= sizes.max() * (1 - 1e-10))
    by = (np.conj(multipliers[leading, None]) * slopes[leading]).real / sizes[leading, None]
    margin = -by[0]
    margin[np.ptp(by, axis=0) > 1e-6 * np.abs(by).max(axis=0)] = np.nan
    if np.isnan(margin).any():
        code = COINCIDENT if np.isnan(slopes[leading]).any() else NOT_SMOOTH
        status["stability_margin"] = status_text(code)
    return np.asarray(margin)


def rates_of(structure: Structure, load: Load, parameter: Wanted) -> _Array:
    """The derivatives of all entries of a structure and its load by a parameter."""
    places, values = entries_of(structure, load)
    if isinstance(parameter, str):
        return named_rates(structure, parameter, places - (0, 1, 1), values)
    if not (isinstance(parameter, tuple) and len(parameter) == 3 and callable(parameter[1])):
        raise ParameterTypeError(
            f"parameter {parameter!r}: must be a name, or (name, function, value), where the function gives a "
            "structure and a load"
        )
    name, function, value = parameter
    at = checks.to_float(value, f"value of {name}", "a finite number")
    half = 0.05 * abs(at) or 0.05
    changed, series = series_of(structure, load, function, at - half, at + half, at)
    rates = np.zeros(len(values))
    slopes = np.asarray(chebyshev.chebval(0.0, chebyshev.chebder(series.T)) / half)
    for place, slope in zip(changed.tolist(), slopes, strict=True):
        rates[(places == place).all(axis=1)] = slope
    return rates


def named_rates(structure: Structure, name: str, places: _Array, values: _Array) -> _Array:
    """The derivatives of all entries by a parameter of a name as in `branch`, or the factor 'mass'."""
    parts = re.fullmatch(r"([a-z]+)((?:_\d+)*)", name)
    word = parts[1] if parts else ""
    numbers = [int(part) for part in parts[2].split("_")[1:]] if parts else []
    kind = WORDS.get(word)
    allowed = {OPENING: (0, 1), RESTITUTION: (0, 1)} | dict.fromkeys(MATRICES, (0, 2))
    if kind is None or len(numbers) not in allowed.get(kind, (0,)):
        raise ParameterError(
            f"parameter {name!r}: must be 'frequency', 'load', 'constant', 'mass', 'damping', 'stiffness' "
            "(factors), 'opening', 'restitution' (of all gaps), 'opening_J', 'restitution_J', 'mass_I_J', "
            "'damping_I_J' or 'stiffness_I_J', all from 0, or (name, function, value)"
        )
    here = places[:, 0] == kind
    if kind == COSINE:
        here |= places[:, 0] == SINE
    if numbers and kind in MATRICES:
        here &= (places[:, 1:] == sorted(numbers, reverse=True)).all(axis=1)
    elif numbers:
        here &= places[:, 1] == numbers[0]
    factor = kind in (CONSTANT, COSINE) or (kind in MATRICES and not numbers)
    rates = np.where(here, values if factor else 1.0, 0.0)
    if not rates.any():
        raise ParameterError(f"parameter {name!r}: there is nothing that it could change")
    if kind == RESTITUTION:
        for j in places[here, 1].tolist():
            if isinstance(structure.gaps[j].restitution, TabulatedRestitution):
                raise ParameterError(f"parameter {name!r}: the restitution of gap {j} is a table")
    return rates
