"""Derivatives of motions and trajectories of structures with respect to parameters; the core carries them
along."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.interrupt import interruptible
from ..base.status import NO_DERIVATIVE, raise_status, status_text
from ..motions.trajectory import core_arrays
from ..results.gradient import Gradient, frozen
from ..results.parameters import (
    CONSTANT,
    COSINE,
    FREQUENCY,
    LAW,
    MATRICES,
    OPENING,
    RESTITUTION,
    SINE,
    WALLS,
    Wanted,
    entries_of,
    of_constant_load,
    series_of,
)
from ..systems.record import Record
from ..systems.restitution import to_columns
from ..systems.structure import Friction, Gap, Load, Stop, Structure, counted
from .gradient import FOLD, NOT_SMOOTH

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory

__all__: list[str] = []

_Array = NDArray[Any]
#: Condition number that counts as a fold; cosine between left and right eigenvectors that counts as a double
#: multiplier.
SINGULAR, DEFECT = 1e10, 1e-5
#: Approach speed, relative to the largest velocity, below which an impact is a graze, as in the core; distance
#: from a wall, relative to the largest coordinate, below which it is touched; number of instants of a flight
#: between which a touch is sought.
TOUCHING, TOUCH, NODES = 1e-9, 1e-12, 32
#: Codes of the core's vi_status.
NOT_EXACT, COINCIDENT = 27, 28
#: The kinds of entries by their names.
WORDS = {name: kind for kind, name in MATRICES.items()} | {
    "opening": OPENING, "restitution": RESTITUTION, "frequency": FREQUENCY, "constant": CONSTANT, "load": COSINE,
    "contact": LAW, "slip": LAW, "stick": LAW, "speed": LAW, "wall": min(WALLS),
}  # fmt: skip


def plain_load(structure: Structure, load: Load | Record | None) -> Load:
    """The part of a load whose entries can be parameters."""
    if isinstance(load, Load):
        return load
    zero = np.zeros(structure.coordinates)
    return Load(constant=zero if load is None else load.constant)


class Along:
    """A trajectory along which the core carries changes of the initial state and of parameters."""

    def __init__(
        self, run: Trajectory, parameters: Sequence[Wanted], first: int = -1, free: bool = False
    ) -> None:
        """`first`: the gap of the impact just before the period; the instant of this impact defines the load
        phase.

        `free`: whether the motion is self-excited; its frequency is then the last parameter.
        """
        plain = plain_load(run.structure, run.load)
        frequency = plain.frequency
        if free:
            plain = Load(constant=plain.constant)
        self.run, count = run, len(parameters) + 1 + free
        places = entries_of(run.structure, plain)[0]
        rates, of_record = np.zeros((len(places), count)), np.zeros(count)
        for i, parameter in enumerate(parameters, 1):
            of_record[i] = parameter == "load" and isinstance(run.load, Record)
            if not of_record[i]:
                rates[:, i] = rates_of(run.structure, plain, parameter)
        if free:
            rates[places[:, 0] == FREQUENCY, -1] = 1.0
        self.by_frequency = rates[places[:, 0] == FREQUENCY][0]
        touched, sizes = touch_of(run)
        self.sizes = np.repeat(sizes, run.structure.coordinates)
        self.before = [*core_arrays(run.structure, run.load, True), places.T, rates, of_record]
        if free:
            self.before[3] = frequency
        self.after = [
            *run._segments(), np.append(0, run.events["speed"]), run.end, first + 1, touched + 1, self.sizes
        ]  # fmt: skip

    def carried(self, changes: _Array) -> tuple[_Array, _Array, _Array, _Array, _Array]:
        """The core's arrays for derivatives with respect to the initial state (2n, 1 + parameters); the first
        column is 0."""
        count = len(self.run.events)
        found = interruptible(_core.structure_gradient, *self.before, changes, *self.after)
        values, finals, products, slopes, rates, self.opens, self.good, self.code, status = found
        raise_status(status)
        return values[:, :count], finals, products, slopes[..., :count], rates


def checked(structure: Structure, load: Load | Record | None, parameters: Any) -> list[Wanted]:
    """A list of parameters; by default the frequency, the load, and the parameters of all gaps, stops and
    friction."""
    if parameters is None:
        each = range(len(structure.gaps))
        driven = isinstance(load, Record) or len(plain_load(structure, load).sine) > 0
        parameters = ["frequency"] if isinstance(load, Load) and load.frequency else []
        parameters += ["load"] if driven else []
        parameters += [f"opening_{j}" for j in each]
        parameters += [
            f"wall_{j}"
            for j in each
            if structure.gaps[j].cosine.any() or structure.gaps[j].sine.any()
        ]
        for j, part in enumerate(structure._parts):
            if isinstance(part, Gap) and "restitution" in to_columns(part.restitution):
                parameters.append(f"restitution_{j}")
            elif isinstance(part, Stop) and part.stiffness:
                parameters.append(f"contact_{j}")
            elif isinstance(part, Friction) and part.slip:
                parameters.append(f"slip_{j}")
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


def motion_gradient(motion: Motion, parameters: Sequence[Wanted] | None) -> Gradient:
    """The derivatives of a motion of a structure, as a fixed point of the map over a period from just after the
    first impact."""
    structure, load, n, count = (
        motion.structure, motion.load, motion.structure.coordinates, len(motion.gaps),
    )  # fmt: skip
    free = motion.self_excited
    wanted = checked(structure, motion._given_load, parameters)
    if not wanted:
        raise ParameterError(f"parameters = {parameters!r}: must name at least one")
    if free and "frequency" in wanted:
        raise ParameterError(
            "parameters: 'frequency' must be left out, since it is a result of the motion"
        )
    motion._refuse_meetings()
    run, hits = period_of(motion)
    if free:
        wanted = [
            one if isinstance(one, str) or not callable(one[1])
            else (one[0], of_constant_load(one[1]), *one[2:])
            for one in wanted
        ]  # fmt: skip
    along = Along(run, wanted, int(motion.gaps[0]), free)
    names = names_of(wanted)
    still = np.zeros((2 * n, 1 + len(names) + free))
    _, finals, products, *_ = along.carried(still)
    raise_status(along.code)
    scale = along.sizes
    matrix = products[..., 0] * scale / scale[:, None]
    changes = np.zeros_like(still)
    pace = np.zeros(len(names))
    if free:
        changes[:, 1:-1], pace = free_changes(matrix, finals[:, 1:] / scale[:, None])
    else:
        inverse = inverse_of(structure, motion, matrix, scale)
        changes = inverse @ (finals / scale[:, None])
    values, _, products, *_ = along.carried(scale[:, None] * changes)
    if free:
        # the frequency changes, too, and phases are measured from the first event
        values, products = (
            np.append(part[..., :1], part[..., 1:-1] + part[..., -1:] * pace, axis=-1)
            for part in (values, products)
        )
        values[0] -= values[0, hits[0]].copy()
    by_matrix = (products * (scale / scale[:, None])[..., None])[..., 1:].transpose(2, 0, 1)
    tables = values[:, hits, 1:].transpose(1, 0, 2)
    found: dict[str, _Array] = {
        "phases": motion.phases, "speeds": motion.speeds, "impulses": motion.impulses,
        "q": motion.states[:, 0], "q_dot": motion.states[:, 1], "multipliers": motion.multipliers,
        "stability_margin": np.asarray(1 - np.abs(motion._nontrivial).max(initial=0.0)),
    }  # fmt: skip
    slopes = by_name(tables, n, ("phases", "speeds", "impulses", "q", "q_dot"))
    slopes["multipliers"], status = multiplier_slopes(matrix, by_matrix, motion.multipliers)
    others = np.arange(len(motion.multipliers)) != motion.trivial
    slopes["stability_margin"] = margin_slopes(
        motion.multipliers[others], slopes["multipliers"][others], status
    )
    if free:
        found["period"] = np.asarray(motion.period)
        slopes["period"] = -motion.period / load.frequency * pace
    dimensions: dict[str, tuple[str, ...]] = {
        "phases": ("impact",), "speeds": ("impact",), "impulses": ("impact",), "q": ("impact", "coordinate"),
        "q_dot": ("impact", "coordinate"), "multipliers": ("multiplier",), "stability_margin": (),
    } | ({"period": ()} if free else {})  # fmt: skip
    word = "impact" if structure._is_rigid else "event"
    of = f"a motion of a structure with {counted(count, word)} in {counted(motion.cycles, 'cycle')}"
    return Gradient(
        of, names, found, {name: frozen(table) for name, table in slopes.items()}, dimensions, status
    )  # fmt: skip


def period_of(motion: Motion) -> tuple[Trajectory, NDArray[np.int64]]:
    """A period of a motion, and the indices of its events in the period.

    It begins just after the first impact or, with stops or friction, in the middle of the longest flight, where no
    event condition is near its limit.
    """
    if motion.structure._is_rigid:
        run = motion._run()
        # the impact at the end of the period is the first one
        return run, np.roll(np.flatnonzero(run.events["kind"] == "impact"), 1)
    run = motion._from_flight()
    listed = np.flatnonzero(~np.isin(run.events["kind"], ["stick", "release"]))
    if len(listed) != len(motion.phases):
        raise_status(NOT_EXACT)
    since = np.mod(motion.phases - run.start * motion.load.frequency, 2 * np.pi * motion.cycles)
    hits = np.empty(len(since), np.int64)
    # simultaneous events of different elements may be in another order
    order = np.argsort(since, kind="stable")
    mine, theirs = (
        np.argsort(gaps, kind="stable") for gaps in (motion.gaps[order], run.events["gap"][listed])
    )
    hits[order[mine]] = listed[theirs]
    if (run.events["gap"][hits] != motion.gaps).any():
        raise_status(NOT_EXACT)
    return run, hits


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


def _refuse_meetings(run: Trajectory) -> None:
    """Raises SingularError if simultaneous impacts of coupled gaps leave a trajectory without derivatives."""
    hits = run.events[run.events["kind"] == "impact"]
    directions = np.array([part.direction for part in run.structure._parts])
    coupling = np.abs(directions @ np.linalg.solve(run.structure.mass, directions.T))
    scale = np.sqrt(np.outer(coupling.diagonal(), coupling.diagonal()))
    pairs = hits["gap"][:-1], hits["gap"][1:]
    if ((np.diff(hits["time"]) <= 0) & (coupling[pairs] > 1e-12 * scale[pairs])).any():
        raise_status(NO_DERIVATIVE)


def trajectory_gradient(run: Trajectory, parameters: Any) -> Gradient:
    """The derivatives of a trajectory of a structure."""
    if not run.complete:
        raise ParameterError(f"{run!r}: must be complete to have derivatives")
    if run.structure.simultaneous:
        _refuse_meetings(run)
    structure, load, n, count = run.structure, run.load, run.structure.coordinates, len(run.events)
    own = ("start", *(f"q_{i}" for i in range(n)), *(f"q_dot_{i}" for i in range(n)))
    initial = own
    if isinstance(parameters, Sequence) and not isinstance(parameters, str):
        initial = tuple(one for one in parameters if isinstance(one, str) and one in own)
        parameters = [one for one in parameters if one not in initial]
    wanted = checked(structure, load, parameters)
    if not wanted and not initial:
        raise ParameterError(f"parameters = {parameters!r}: must name at least one")
    names = names_of(wanted)
    along = Along(run, wanted)
    values_by, finals, products, by_start, rates = along.carried(np.zeros((2 * n, 1 + len(names))))
    # derivatives of the start with respect to the initial quantities; the end time is a number of cycles or a
    # duration
    changes = np.zeros((2 * n, len(initial)))
    for i, name in enumerate(initial):
        changes[:, i] = -rates[:, 0] if name == "start" else np.eye(2 * n)[own.index(name) - 1]
    times = np.array([float(name == "start") for name in initial] + [0.0] * len(names))
    if "cycles" in (run.request or {}):
        times[len(initial) :] -= (
            along.by_frequency[1:] * (run.end - run.start) / plain_load(structure, load).frequency
        )
    columns = np.concatenate(
        [np.einsum("ijk,jl->kil", by_start, changes), values_by[..., 1:].transpose(1, 0, 2)],
        axis=-1,
    )
    final = np.hstack([products[..., 0] @ changes, finals[:, 1:]]) + np.outer(rates[:, 1], times)
    status = {}
    if along.code:
        where = f"events[{along.good}:]" if along.good < count else "final_q"
        status[where] = status_text(along.code)
        columns[along.good :] = final[:] = np.nan
    opening = opening_at_start(along, initial)
    if opening.any():
        parting = ", ".join(np.array([*initial, *names])[opening])
        status[parting] = (
            "a gap that rests at the start would open or close further, or friction that sticks would slip"
        )
        columns[..., opening] = final[:, opening] = np.nan
    slopes = by_name(columns, n, ("time", "speed", "impulse", "q", "q_dot"))
    slopes |= {"final_time": times, "final_q": final[:n], "final_q_dot": final[n:]}
    values = {name: run.events[name].copy() for name in ("time", "speed", "impulse")}
    values |= {"q": run.states[:, 0].copy(), "q_dot": run.states[:, 1].copy()}
    values["final_time"] = np.asarray(run.end)
    values["final_q"], values["final_q_dot"] = (np.array(part) for part in run.final_state)
    dimensions: dict[str, tuple[str, ...]] = dict.fromkeys(("time", "speed", "impulse"), ("event",))
    dimensions |= dict.fromkeys(("q", "q_dot"), ("event", "coordinate")) | {"final_time": ()}
    dimensions |= dict.fromkeys(("final_q", "final_q_dot"), ("coordinate",))
    if along.code:
        slopes["final_time"][:] = np.nan
    of = f"a trajectory of a structure with {count} events"
    values, slopes = (
        {name: frozen(table) for name, table in one.items()} for one in (values, slopes)
    )
    return Gradient(of, (*initial, *names), values, slopes, dimensions, status)


def opening_at_start(along: Along, initial: Sequence[str]) -> _Array:
    """Whether a gap that rests at the start would not stay closed if the initial state or a parameter changed."""
    structure = along.run.structure
    rows = [structure.gaps[j].direction for j in along.run._resting()]
    used = np.any(np.reshape(rows, (-1, structure.coordinates)), axis=0)
    by_state = [name != "start" and used[int(name.split("_")[-1])] for name in initial]
    # friction that sticks keeps its speed
    for friction in structure.friction:
        speed = friction.direction @ along.run.initial_state[1]
        scale = np.abs(friction.direction) @ np.abs(along.run.initial_state[1])
        if abs(speed - friction.speed) > 1e-12 * (scale + abs(friction.speed)):
            continue
        for i, name in enumerate(initial):
            if name.startswith("q_dot"):
                by_state[i] |= friction.direction[int(name.split("_")[-1])] != 0
    return np.append(by_state, along.opens[1:]).astype(bool)


def touch_of(run: Trajectory) -> tuple[int, _Array]:
    """Number of the event after the first flight in which a gap is touched without an impact, or -1; and the
    largest coordinate and velocity at events and between them, since all coordinates may be 0 at impacts."""
    gaps, times = run.structure.gaps, run.events["time"]
    directions = np.reshape(
        [gap.direction for gap in gaps], (len(gaps), run.structure.coordinates)
    ).astype(float)
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
    # the gap changes from closing to opening, so close to zero that it may be touched in between
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


def inverse_of(structure: Structure, motion: Motion, matrix: _Array, scale: _Array) -> _Array:
    """The inverse of 1 - matrix, where matrix is the derivative of the map over a period, scaled by `scale`.

    A body that hits nothing may rest anywhere; shifts of such a body, which change no gap that closes, are
    excluded.
    """
    left, sizes, right = np.linalg.svd(np.eye(len(matrix)) - matrix)
    shifts = sizes < sizes[0] / SINGULAR
    changes = scale * right[shifts]
    gaps = [j for j in np.unique(motion.gaps).tolist() if j < len(structure.gaps)]
    used = np.reshape([structure.gaps[j].direction for j in gaps], (-1, structure.coordinates))
    largest = np.abs(used).max(initial=1e-300)
    closing = changes[:, : structure.coordinates] @ used.T / (scale[0] * largest)
    if (np.abs(closing) > 1e-6).any():
        raise_status(FOLD)
    kept = ~shifts
    inverse: _Array = (right[kept].T / sizes[kept]) @ left[:, kept].T
    return inverse


def free_changes(matrix: _Array, finals: _Array) -> tuple[_Array, _Array]:
    """The changes of the initial state (2n, parameters) and of the frequency (parameters) of a self-excited
    motion.

    In (1 - P) ds - dF/dOmega dOmega = dF/dp, ds is orthogonal to the flow direction, which is an eigenvector of P;
    the last derivative of the end state F at fixed phases is that with respect to Omega.
    """
    m = len(matrix)
    _, _, right = np.linalg.svd(np.eye(m) - matrix)
    bordered = np.zeros((m + 1, m + 1))
    bordered[:m, :m] = np.eye(m) - matrix
    pace = np.abs(finals[:, -1]).max() or 1.0
    bordered[:m, m] = -finals[:, -1] / pace
    bordered[m, :m] = right[-1]
    sizes = np.linalg.svd(bordered, compute_uv=False)
    if not sizes[-1] > sizes[0] / SINGULAR:
        raise_status(FOLD)
    found = np.linalg.solve(bordered, np.vstack([finals[:, :-1], np.zeros(finals.shape[1] - 1)]))
    return found[:m], found[m] / pace


def multiplier_slopes(
    matrix: _Array, by_matrix: _Array, multipliers: _Array
) -> tuple[_Array, dict[str, str]]:
    """The derivatives of the eigenvalues of a matrix closest to given ones; NaN for double eigenvalues."""
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
    """The derivatives of 1 - max|lambda|; NaN if two multipliers are the largest and change differently."""
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
    """The derivatives of all entries of a structure and its load with respect to a parameter."""
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
    """The derivatives of all entries with respect to a parameter named as in `branch`, or to the factor 'mass'."""
    parts = re.fullmatch(r"([a-z]+)((?:_\d+)*)", name)
    word = parts[1] if parts else ""
    numbers = [int(part) for part in parts[2].split("_")[1:]] if parts else []
    kind = WORDS.get(word)
    allowed = {
        OPENING: (0, 1),
        RESTITUTION: (0, 1),
        LAW: (0, 1),
        min(WALLS): (0, 1),
    } | dict.fromkeys(MATRICES, (0, 2))
    if kind is None or len(numbers) not in allowed.get(kind, (0,)):
        raise ParameterError(
            f"parameters: {name!r} must be 'frequency', 'load', 'constant', 'mass', 'damping', 'stiffness' "
            "(factors), 'opening', 'restitution' (of all gaps), 'contact' (stiffness of all stops), 'slip', "
            "'stick', 'speed' (of all friction), 'wall' (factor of the motions of walls), 'opening_J', "
            "'restitution_J', 'contact_J', 'slip_J', 'stick_J', 'speed_J', 'wall_J', 'mass_I_J', 'damping_I_J' or "
            "'stiffness_I_J', all from 0, or (name, function, value)"
        )
    here = places[:, 0] == kind
    if kind == COSINE:
        here |= places[:, 0] == SINE
    elif kind in WALLS:
        here |= np.isin(places[:, 0], list(WALLS))
    if numbers and kind in MATRICES:
        here &= (places[:, 1:] == sorted(numbers, reverse=True)).all(axis=1)
    elif numbers:
        here &= places[:, 1] == numbers[0]
    factor = kind in (CONSTANT, COSINE, *WALLS) or (kind in MATRICES and not numbers)
    rates = np.where(here, values if factor else 1.0, 0.0)
    if kind == LAW:
        rates = rates_of_law(structure, word, places, rates)
    if not rates.any():
        raise ParameterError(f"parameters: {name!r}: it changes nothing in this structure")
    if kind == RESTITUTION:
        for j in places[here, 1].tolist():
            if "restitution" not in to_columns(structure.gaps[j].restitution):
                raise ParameterError(
                    f"parameters: {name!r} has no derivative: the restitution of gap {j} is a table"
                )
    return rates


def rates_of_law(
    structure: Structure, word: str, places: NDArray[np.int64], rates: _Array
) -> _Array:
    """The derivatives of the numbers of stops with respect to a stiffness, or of friction with respect to a slip
    level (with its stick level in proportion), a stick level or the speed of a belt."""
    found = np.zeros(len(rates))
    for i, (_, j, number) in enumerate(places.tolist()):
        part = structure._parts[j] if rates[i] else None
        if isinstance(part, Stop if word == "contact" else Friction):
            stick = part.stick / part.slip if isinstance(part, Friction) and part.slip else 0.0
            numbers = {"stick": (0.0, 1.0, 0.0), "speed": (0.0, 0.0, 1.0)}
            found[i] = numbers.get(word, (1.0, stick, 0.0))[number]
    return found
