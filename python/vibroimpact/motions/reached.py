"""Figures of a structure on the motion that a simulation reaches, for designs and limits."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, SingularError
from ..results import door, performance
from ..results.performance import Performance, perform
from ..systems.distribution import element_of, require_free_mass
from ..systems.oscillator import Oscillator
from ..systems.record import Record
from ..systems.structure import Load, Structure
from .exact import exact_structure
from .trajectory import Trajectory, simulate_structure

_Array = NDArray[np.float64]
#: Number of samples in a load cycle from which extremes are refined, and smallest number of samples of a record.
SAMPLES, LEAST = 200, 5_000
#: Figures of a structure that can be limited or minimised.
FIGURES = ("displacement", "rms", "speed", "acceleration", "force", "multiplier", "least_speed")
#: Damping ratio times load cycles after which a transient is below 1e-4, and most load cycles until then, as in
#: the core.
DECAYED, LONGEST = 1.5, 100_000


def reached_figures(
    structure: Structure, force: Load | Record, state: tuple[_Array, _Array] | None, asked: Collection[str],
    coordinate: int | str = 0, settling: int = 400, keep: int = 64, max_events: int = 1_000_000,
) -> dict[str, float]:  # fmt: skip
    """The performance figures of a coordinate and of all contacts.

    Parameters
    ----------
    structure, force : Structure, Load or Record
        The load has a frequency.
    state : (ndarray (n,), ndarray (n,)) or None
        Initial positions and velocities.
    asked : collection of str
        The figures that are needed: acceleration, force and multiplier are computed only then. The force is that
        of springs and dashpots on the coordinate, and the multiplier is the largest modulus of a multiplier of the
        motion that is reached.
    coordinate : int or str
        The coordinate, or the output.
    settling, keep : int
        Load cycles simulated before the evaluation, and load cycles evaluated; a record is evaluated as a whole.
    max_events : int
        Events after which the simulation is abandoned; all figures are then inf.

    Raises
    ------
    SingularError
        If the simulation fails.
    """
    if isinstance(force, Record):
        run = simulate_structure(structure, force, state=state, max_events=max_events)
        begin, many = run.start, max(LEAST, 10 * len(force.force))
    else:
        run = simulate_structure(
            structure, force, cycles=settling + keep, state=state, max_events=max_events
        )
        begin, many = run.end - keep * 2 * math.pi / force.frequency, SAMPLES * keep
    if not run.complete:
        return dict.fromkeys(FIGURES, math.inf)
    least, greatest, rms = extent(run, begin, many, coordinate)
    late = run.events[run.events["time"] >= begin]
    hits = late[np.isin(late["kind"], ("impact", "touch"))]
    rests = np.isin(late["kind"], ("stick", "release")).any()
    figures = {
        "displacement": max(-least, greatest), "rms": rms, "speed": float(hits["speed"].max(initial=0.0)),
        "least_speed": 0.0 if rests else float(hits["speed"].min(initial=math.inf)), "contacts": len(hits),
    }  # fmt: skip
    if "acceleration" in asked and isinstance(coordinate, str):
        figures["acceleration"] = greatest_acceleration(run, begin, many, coordinate)
    elif {"acceleration", "force"} & {*asked}:
        found = run.quantities(window=(begin, run.end))
        for name, signal in {"acceleration": found.q_ddot, "force": found.transmitted}.items():
            figures[name] = float(np.atleast_1d(signal.peak)[coordinate])
    if "multiplier" in asked:
        figures["multiplier"] = largest_multiplier(run) if len(late) else 0.0
    return figures


def largest_multiplier(run: Trajectory) -> float:
    """The largest modulus of the multipliers of the motion that a simulation reached; inf if there is none, or
    if it has no multipliers."""
    if not isinstance(run.load, Load):
        raise ParameterError(
            "limits: multiplier: must be left out for a record, which has no period"
        )
    try:
        found = float(np.abs(exact_structure(run.structure, run.load, run).multipliers[0]))
    except (SingularError, ParameterError):
        return math.inf
    return math.inf if math.isnan(found) else found


def perform_points(
    parameters: _Array, elements: Mapping[str, _Array], places: _Array, settling: int = 400, keep: int = 64,
    max_events: int = 1_000_000, threads: int | None = None, progress: door.Progress | None = None,
    note: str = "", wanted: Iterable[str] = performance.FIGURES,
) -> Performance:  # fmt: skip
    """Like `perform`, for units with friction in the slot or compliant walls, which are simulated as structures.

    Parameters
    ----------
    parameters, places : ndarray (6, n), (4, n)
        As for `perform`, like the other arguments.
    elements : mapping
        Friction and compliant walls, as `elements_of` returns them; if it is empty, the core simulates the
        oscillators.
    """
    if not elements:
        return perform(
            parameters, places, settling, keep, max_events, threads, progress, note, wanted
        )
    require_free_mass(parameters[3])
    n, asked = places.shape[1], {*wanted} & {*FIGURES}
    amplitude = amplitudes(parameters)

    def one(i: int) -> list[float]:
        r, clearance, xi, mu, right, left = parameters[:, i].tolist()
        friction, stops = element_of(elements, i)
        point = Oscillator(xi=xi, mu=mu, restitution=(right, left)).at(
            r, clearance, friction=friction, stops=stops
        )
        long = max(settling, math.ceil(min(DECAYED / xi, LONGEST))) if xi > 0 else settling
        try:
            found = reached_figures(
                point.structure, point.load, placed_state(amplitude[i], clearance, places[:, i]), asked, 0, long,
                keep, max_events,
            )  # fmt: skip
        except SingularError:
            found = dict.fromkeys(FIGURES, math.inf)
        return [found.get(name, math.nan) for name in (*performance.FIGURES[:-1], "contacts")]

    table = np.empty((len(performance.FIGURES), n))
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        for i, row in enumerate(pool.map(one, range(n))):
            table[:, i] = row
            if progress is not None:
                progress((i + 1) / n, note)
    failed = ~np.isfinite(table[0])
    table[:, failed] = np.nan
    contacts = np.where(failed, 0, table[-1]).astype(np.int32)
    multiplier = table[performance.FIGURES.index("multiplier")]
    multiplier[~np.isfinite(multiplier) | (contacts == 0)] = np.nan
    figures = dict(zip(performance.FIGURES, (*table[:-1], amplitude), strict=True))
    return Performance(
        **figures, states=np.full((5, n), np.nan), cycles=np.zeros(n, np.int32), impacts=contacts,
        status=failed.astype(np.int32),
    )  # fmt: skip


def amplitudes(parameters: _Array) -> _Array:
    """Amplitudes A (n,) without impacts, of parameters (6, n) of `perform`."""
    r, _, xi, *_ = parameters
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.hypot(1 - r**2, 2 * xi * r))


def placed_state(amplitude: float, clearance: float, place: _Array) -> tuple[_Array, _Array]:
    """Positions and velocities of both masses at a place in the box of random states of `basins`."""
    scale = min(max(amplitude, 0.5 * clearance), 3 * clearance)
    x, x_dot, y, z_dot = place
    return np.array([scale * x, scale * x + 0.5 * clearance * y]), scale * np.array([x_dot, z_dot])


def steady(structure: Structure, load: Load) -> NDArray[np.complex128]:
    """Complex amplitudes (n,) of the fundamental without gaps; 0 at an undamped resonance of the structure."""
    omega = load.frequency
    matrix = structure.stiffness - omega**2 * structure.mass + 1j * omega * structure.damping
    try:
        found = np.linalg.solve(matrix, load.cosine[0] - 1j * load.sine[0])
    except np.linalg.LinAlgError:
        found = np.zeros(structure.coordinates, complex)
    return np.asarray(found)


def greatest_acceleration(run: Trajectory, begin: float, many: int, output: str) -> float:
    """The greatest acceleration of an output from a given time to the end, at samples and on both sides of each
    event."""
    times = run.events["time"][(run.events["time"] > begin) & (run.events["time"] < run.end)]
    times = np.union1d(np.linspace(begin, run.end, many + 1), [*times, *np.nextafter(times, begin)])
    return float(np.abs(run._sampled(times, 3, output)[2]).max())


def extent(
    run: Trajectory, begin: float, many: int, coordinate: int | str
) -> tuple[float, float, float]:
    """Least and greatest value, and root mean square, of a coordinate or output from a given time to the end.

    An extreme between two samples is computed from the cubic through their values and velocities, with an error
    proportional to the fourth power of the sampling interval.
    """
    times = np.linspace(begin, run.end, many + 1)
    inside = run.events["time"][(run.events["time"] > begin) & (run.events["time"] < run.end)]
    times = np.union1d(times, inside)
    if isinstance(coordinate, str):
        q, rate = run.sample(times, coordinate)
    else:
        q, rate = (each[coordinate] for each in run.sample(times))
    h = np.diff(times)
    at = np.flatnonzero(rate[:-1] * rate[1:] < 0)
    a, b, step = q[at], q[at + 1], h[at]
    u, v = rate[at] * step, rate[at + 1] * step
    # the derivative of the cubic is u + 2 c2 s + 3 c3 s^2
    c2, c3 = 3 * (b - a) - 2 * u - v, 2 * (a - b) + u + v
    root = np.sqrt(np.maximum(c2**2 - 3 * c3 * u, 0))
    s = -u / (c2 + np.where(c2 < 0, -root, root))
    s = np.clip(np.where(np.isfinite(s), s, 0.0), 0, 1)
    tips = a + s * (u + s * (c2 + s * c3))
    everything = np.append(q, tips)
    # Simpson's rule with the cubic's middle
    middle = 0.5 * (q[:-1] + q[1:]) + 0.125 * h * (rate[:-1] - rate[1:])
    square = np.sum(h * (q[:-1] ** 2 + 4 * middle**2 + q[1:] ** 2)) / 6
    return float(everything.min()), float(everything.max()), math.sqrt(square / (run.end - begin))
