"""Derivatives of motions and trajectories of structures by their parameters, through impacts and rests."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.status import raise_status, status_text
from ..results.gradient import Gradient, frozen
from ..results.parameters import (
    CONSTANT,
    COSINE,
    FREQUENCY,
    MATRICES,
    OPENING,
    RESTITUTION,
    SINE,
    Wanted,
    entries_of,
    series_of,
)
from ..systems.record import Record
from ..systems.restitution import TabulatedRestitution
from ..systems.structure import Load, Structure
from .gradient import FOLD, NOT_SMOOTH
from .structure_variation import STEP, System, carried, plain_load

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory

__all__: list[str] = []

_Array = NDArray[Any]
#: Condition number at a fold; cosine between the eigenvectors of a double multiplier.
SINGULAR, DEFECT = 1e10, 1e-5
#: Codes of the core's vi_status.
COINCIDENT = 28
#: The kinds of entries by the words of names.
WORDS = {name: kind for kind, name in MATRICES.items()} | {
    "opening": OPENING, "restitution": RESTITUTION, "frequency": FREQUENCY, "constant": CONSTANT, "load": COSINE,
}  # fmt: skip


def systems_of(
    structure: Structure, load: Load | Record | None, parameters: Sequence[Wanted], by_phase: bool
) -> tuple[System, list[System], list[float]]:
    """The system, one with an imaginary step of each parameter, and the derivatives of the frequency."""
    plain = plain_load(structure, load)
    places, values = entries_of(structure, plain)
    moved, paces = [], []
    for parameter in parameters:
        of_record = parameter == "load" and isinstance(load, Record)
        rate = 0 * values if of_record else rates_of(structure, plain, parameter)
        moved.append(System(structure, load, values + 1j * STEP * rate, by_phase))
        moved[-1].scale = 1 + 1j * STEP * of_record
        paces.append(float(rate[places[:, 0] == FREQUENCY][0]))
    return System(structure, load, values + 0j, by_phase), moved, paces


def checked(structure: Structure, load: Load | Record | None, parameters: Any) -> list[Wanted]:
    """A list of parameters; by default frequency, load, and all openings and coefficients of restitution."""
    if parameters is None:
        each = range(len(structure.gaps))
        driven = isinstance(load, Record) or len(plain_load(structure, load).sine) > 0
        parameters = ["frequency"] if isinstance(load, Load) and load.frequency else []
        parameters += ["load"] if driven else []
        parameters += [f"opening_{j}" for j in each]
        parameters += [
            f"restitution_{j}" for j in each
            if not isinstance(structure.gaps[j].restitution, TabulatedRestitution)
        ]  # fmt: skip
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise ParameterTypeError(f"parameters = {parameters!r}: must be a list of parameters")
    for one in parameters:
        if not isinstance(one, (str, tuple)):
            raise ParameterTypeError(
                f"parameters with {one!r}: must be a name, or (name, function, value)"
            )
    return list(parameters)


def names_of(parameters: Sequence[Wanted]) -> tuple[str, ...]:
    """The names of parameters that `rates_of` has checked."""
    return tuple(one if isinstance(one, str) else str(one[0]) for one in parameters)


def structure_gradient(motion: Motion, parameters: Sequence[Wanted] | None) -> Gradient:
    """The derivatives of a motion of a structure: a fixed point of its period from just after the first impact."""
    structure, load, n, count = (
        motion.structure, motion.load, motion.structure.coordinates, len(motion.gaps),
    )  # fmt: skip
    wanted = checked(structure, load, parameters)
    if not wanted:
        raise ParameterError(f"parameters = {parameters!r}: must name at least one")
    system, changed, _ = systems_of(structure, load, wanted, by_phase=True)
    names = names_of(wanted)
    run = motion._run()
    start = np.concatenate(run.initial_state)
    base = carried(system, run, start, int(motion.gaps[0]))
    if base.code:
        raise_status(base.code)
    scale = base.sizes
    matrix = (base.matrix * scale / scale[:, None]).real
    inverse = inverse_of(system, motion, matrix, scale)
    # the impact at the end of the period is the first one
    hits = np.roll(np.flatnonzero(run.events["kind"] == "impact"), 1)
    tables, by_matrix = [], []
    for other in changed:
        last = carried(other, run, start).state.imag / STEP
        change = scale * (inverse @ (last / scale))
        moved = carried(other, run, start + 1j * STEP * change)
        by_matrix.append((moved.matrix * scale / scale[:, None]).imag / STEP)
        tables.append(moved.values[hits].imag / STEP)
    found: dict[str, _Array] = {
        "phases": motion.phases, "speeds": motion.speeds, "impulses": motion.impulses,
        "q": motion.states[:, 0], "q_dot": motion.states[:, 1], "multipliers": motion.multipliers,
        "stability_margin": np.asarray(1 - np.abs(motion.multipliers).max(initial=0.0)),
    }  # fmt: skip
    columns = np.reshape(np.stack(tables, axis=-1), (count, 2 * n + 3, len(names)))
    slopes = by_name(columns, n, ("phases", "speeds", "impulses", "q", "q_dot"))
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


def by_name(columns: _Array, n: int, names: Sequence[str]) -> dict[str, _Array]:
    """The derivatives (events, 2n + 3, parameters) by name of quantity."""
    parts = (
        columns[:, 0],
        columns[:, 1],
        columns[:, 2],
        columns[:, 3 : 3 + n],
        columns[:, 3 + n :],
    )
    return {name: np.array(part) for name, part in zip(names, parts, strict=True)}


def structure_trajectory_gradient(run: Trajectory, parameters: Any) -> Gradient:
    """The derivatives of a trajectory of a structure."""
    if not run.complete:
        raise ParameterError(f"{run!r}: must be complete to have derivatives")
    structure, load, n, count = run.structure, run.load, run.structure.coordinates, len(run.events)
    own = ("start", *(f"q_{i}" for i in range(n)), *(f"q_dot_{i}" for i in range(n)))
    initial = own
    if isinstance(parameters, Sequence) and not isinstance(parameters, str):
        initial = tuple(one for one in parameters if isinstance(one, str) and one in own)
        parameters = [one for one in parameters if one not in initial]
    wanted = checked(structure, load, parameters)
    if not wanted and not initial:
        raise ParameterError(f"parameters = {parameters!r}: must name at least one")
    system, changed, paces = systems_of(structure, load, wanted, by_phase=False)
    names = names_of(wanted)
    start = np.concatenate(run.initial_state)
    base = carried(system, run, start)
    assert base.first_rate is not None
    # of events, of the state at the end, and of the time there: a number of cycles of the load, or a duration
    tables, ends, times = [], [], []
    for name in initial:
        change = -base.first_rate.real if name == "start" else np.eye(2 * n)[own.index(name) - 1]
        tables.append(base.slopes.real @ change)
        ends.append(base.matrix.real @ change)
        times.append(float(name == "start"))
    by_cycles = "cycles" in (run.request or {})
    for other, pace in zip(changed, paces, strict=True):
        moved = carried(other, run, start)
        tables.append(moved.values.imag / STEP)
        ends.append(moved.state.imag / STEP)
        times.append(-pace * (run.end - run.start) / system.frequency.real if by_cycles else 0.0)
    columns = np.stack(tables, axis=-1)
    final = np.stack(ends, axis=-1) + np.outer(base.rate.real, times)
    status = {}
    if base.code:
        where = f"events[{base.good}:]" if base.good < count else "final_q"
        status[where] = status_text(base.code)
        columns[base.good :] = final[:] = np.nan
    opening = opening_at_start(run, system, changed, initial)
    if opening.any():
        parting = ", ".join(np.array([*initial, *names])[opening])
        status[parting] = "a gap rests at the start, and would open or be less than closed"
        columns[..., opening] = final[:, opening] = np.nan
    slopes = by_name(columns, n, ("time", "speed", "impulse", "q", "q_dot"))
    slopes |= {"final_time": np.array(times), "final_q": final[:n], "final_q_dot": final[n:]}
    values = {name: run.events[name].copy() for name in ("time", "speed", "impulse")}
    values |= {"q": run.states[:, 0].copy(), "q_dot": run.states[:, 1].copy()}
    values["final_time"] = np.asarray(run.end)
    values["final_q"], values["final_q_dot"] = (np.array(part) for part in run.final_state)
    dimensions: dict[str, tuple[str, ...]] = dict.fromkeys(("time", "speed", "impulse"), ("event",))
    dimensions |= dict.fromkeys(("q", "q_dot"), ("event", "coordinate")) | {"final_time": ()}
    dimensions |= dict.fromkeys(("final_q", "final_q_dot"), ("coordinate",))
    if base.code:
        slopes["final_time"][:] = np.nan
    of = f"a trajectory of a structure with {count} events"
    values, slopes = (
        {name: frozen(table) for name, table in one.items()} for one in (values, slopes)
    )
    return Gradient(of, (*initial, *names), values, slopes, dimensions, status)


def opening_at_start(
    run: Trajectory, system: System, changed: list[System], initial: Sequence[str]
) -> _Array:
    """Whether a gap that rests at the start would not stay closed if a quantity of it or a parameter changed."""
    rests = list(run._resting())
    rows = system.directions[rests].real
    moved = [
        [
            *(one.directions[rests] @ run.initial_state[0] - one.openings[rests]),
            *(one.directions[rests] @ run.initial_state[1]),
        ]
        for one in changed
    ]
    by_state = [
        name != "start" and bool(rows[:, int(name.split("_")[-1])].any()) for name in initial
    ]
    return np.array([*by_state, *(bool(np.imag(one).any()) for one in moved)], bool)


def inverse_of(system: System, motion: Motion, matrix: _Array, scale: _Array) -> _Array:
    """The inverse of 1 - matrix, of the derivative of a period in units `scale`.

    A body that hits nothing may rest anywhere: a shift of it, which changes no gap that closes, is left out.
    """
    left, sizes, right = np.linalg.svd(np.eye(len(matrix)) - matrix)
    shifts = sizes < sizes[0] / SINGULAR
    changes = scale * right[shifts]
    used = system.directions[np.unique(motion.gaps)].real
    closing = changes[:, : system.n] @ used.T / (scale[0] * np.abs(used).max())
    if (np.abs(closing) > 1e-6).any():
        raise_status(FOLD)
    kept = ~shifts
    inverse: _Array = (right[kept].T / sizes[kept]) @ left[:, kept].T
    return inverse


def multiplier_slopes(
    matrix: _Array, by_matrix: _Array, multipliers: _Array
) -> tuple[_Array, dict[str, str]]:
    """The derivatives of the eigenvalues of a matrix next to given ones; NaN for double ones."""
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
    sizes = np.maximum(np.abs(multipliers), 1e-300)
    leading = np.flatnonzero(sizes >= sizes.max() * (1 - 1e-10))
    by = (np.conj(multipliers[leading, None]) * slopes[leading]).real / sizes[leading, None]
    margin = -by[0]
    margin[~(np.ptp(by, axis=0) <= 1e-6 * np.abs(by).max(axis=0))] = np.nan
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
            f"parameters: {parameter!r} must be a name, or (name, function, value), where the function gives a "
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
            f"parameters: {name!r} must be 'frequency', 'load', 'constant', 'mass', 'damping', 'stiffness' "
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
        raise ParameterError(f"parameters: {name!r}: there is nothing that it could change")
    if kind == RESTITUTION:
        for j in places[here, 1].tolist():
            if isinstance(structure.gaps[j].restitution, TabulatedRestitution):
                raise ParameterError(
                    f"parameters: {name!r} has no derivative: the restitution of gap {j} is a table"
                )
    return rates
