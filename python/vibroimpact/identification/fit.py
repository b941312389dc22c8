"""The parameters of a rig from the harmonics of its motion: exact motions fitted by weighted least squares."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..errors import SingularError
from ..motion import Motion
from .harmonics import Measured
from .impacts import resonance
from .known import SHARED
from .least_squares import MOST_ITERATIONS, levenberg
from .motions import Point, described, lawful, motion_at, slopes
from .start import checked, first_motion

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: The mode that rings: frequency (rad/s), damping ratio, share.
RING = ("ring omega", "ring damping", "ring share")
#: Last harmonic of the load in the first stage of a fit.
FEW = 6
#: Largest relative standard error of a combination of parameters that a record determines.
VAGUE = 0.5
#: Share of the weighted squares of the harmonics that a fit leaves unexplained, above which it is none.
BAD = 0.5


@dataclass
class Fit:
    """Fitted parameters with their covariance."""

    values: dict[str, float]
    #: F0/K of each record.
    lengths: list[float]
    phases: list[float]
    ring: _Array | None
    motions: list[Motion]
    #: Names of the columns of `covariance`, which has what was fitted, without ringing and load phases.
    names: list[str]
    covariance: _Array
    undetermined: list[str]
    misfits: list[float]
    #: Reference speed of a power law of restitution (m/s); None: the coefficients are constants.
    speed: float | None = None


def fit(
    records: Sequence[Measured], known: dict[str, float], starts: dict[str, float], lengths: Sequence[float],
    phases: Sequence[float], ring: _Array | None, M: float | None = None, K: float | None = None,
    speed: float | None = None, near: Sequence[Motion] = (), rough: bool = False,
) -> Fit:  # fmt: skip
    """Fit exact motions to the harmonics of one or more records.

    `known` are the shared parameters that are not fitted; `M` or `K` with the load of a record give its F0/K.
    With a reference `speed` (m/s) the coefficients of restitution obey a power law, and `near` has motions whose
    speeds are about those of the records. A `rough` fit, from which another one starts, need not converge.
    """
    free = [name for name in SHARED if name not in known]
    count = len(records)
    ringing = ring is not None and any(data.orders.size for data in records)
    names = [*free, *(f"F0/K {i}" for i in range(count)), *(f"phase {i}" for i in range(count))]
    names += RING if ringing else ()
    place = {name: i for i, name in enumerate(names)}
    x = np.array(
        [
            *(starts[name] for name in free),
            *lengths,
            *phases,
            *(ring if ringing and ring is not None else ()),
        ]
    )
    typical = {"R1": 0.5, "R2": 0.5, "exponent": 0.25, "xi": max(starts["xi"], 0.005)}
    scales = np.array(
        [*(typical.get(name, abs(starts[name])) for name in free), *lengths, *([1.0] * count),
         *([0.05 * ring[0], 0.02, 0.3] if ringing and ring is not None else ())]
    )  # fmt: skip
    guesses: list[Motion] = []
    latest: list[Motion] = []
    turns: list[float] = []
    sizes: list[int] = []

    def shared(x: _Array) -> dict[str, float]:
        return {name: float(x[place[name]]) if name in place else known[name] for name in SHARED}

    def points(x: _Array) -> list[Point]:
        p = shared(x)
        found = []
        for i, data in enumerate(records):
            static = float(x[place[f"F0/K {i}"]])
            walls = (p["R1"], p["R2"], p["exponent"])
            unit = None if speed is None else speed / (p["omega"] * static)
            found.append(
                Point(data.Omega / p["omega"], p["d"] / static, p["xi"], p["mu"], *walls, unit)
            )
        return found

    for i, (data, point) in enumerate(zip(records, points(x), strict=True)):
        static, phase = float(x[place[f"F0/K {i}"]]), float(x[place[f"phase {i}"]])
        start = partial(first_motion, data=data, unit=shared(x)["omega"] * static, phase=phase)
        if point.speed is None:
            guesses.append(start(point))
            continue
        # with constants that the law gives at about the speeds
        each, right = lawful(point, near[i]), near[i].pattern.signs > 0
        means = {"R1": float(each[right].mean()), "R2": float(each[~right].mean())}
        first = start(point._replace(**means, exponent=0.0, speed=None))
        guesses.append(checked(motion_at(point, first), data))
    for i, data in enumerate(records):
        turns.append(turn_of(guesses[i], data, x[place[f"phase {i}"]]))

    def residuals(x: _Array) -> tuple[_Array, _Array]:
        p = shared(x)
        here = points(x)
        new = [motion_at(point, guess) for point, guess in zip(here, guesses, strict=True)]
        all_f, all_J = [], []
        for i, data in enumerate(records):
            f, J = residuals_of(data, i, new[i], here[i], p, x)
            all_f.append(f)
            all_J.append(J)
        latest[:] = new
        sizes[:] = [f.size for f in all_f]
        return np.concatenate(all_f), np.vstack(all_J)

    def accept() -> None:
        guesses[:] = latest

    def residuals_of(
        data: Measured, i: int, motion: Motion, point: Point, p: dict[str, float], x: _Array
    ) -> tuple[_Array, _Array]:
        omega, xi = p["omega"], p["xi"]
        static, phase = x[place[f"F0/K {i}"]], x[place[f"phase {i}"]]
        s = slopes(motion, point)
        angles = s.phases - phase + turns[i]
        # by those of SHARED and then F0/K, which change r = Omega/omega, D = d/(F0/K) and the unit of speeds
        r, D, u = motion.r, motion.clearance, point.speed or 0.0
        by = np.stack([
            -(s.by[0] * r + s.by[7] * u) / omega, *s.by[2:7], s.by[1] / static,
            -(s.by[1] * D + s.by[7] * u) / static,
        ])  # fmt: skip
        unit = omega * static
        jumps = s.jumps * unit
        d_angles, d_jumps = by[:, 0], by[:, 1] * unit
        d_jumps[0] += s.jumps * static
        d_jumps[-1] += s.jumps * omega
        f, J = [], []
        columns = [place.get(name) for name in SHARED] + [place[f"F0/K {i}"]]

        def row(value: _Array, by_shared: _Array, more: dict[int, _Array]) -> None:
            f.append(np.atleast_1d(value))
            block = np.zeros((np.size(value), x.size))
            for column, derivative in zip(columns, by_shared, strict=True):
                if column is not None:
                    block[:, column] = derivative
            for column, derivative in more.items():
                block[:, column] = derivative
            J.append(block)

        if data.orders.size:
            data = data.up_to(stage)
            each, impulse = data.impulses(angles, jumps)
            w = data.frequencies
            below = omega**2 - w**2 + 2j * xi * omega * w
            turned = data.shape * np.exp(1j * phase * data.orders / data.k)
            force = impulse + omega**2 * static * turned
            direct = -(w**2) / below
            value = direct * force
            response = direct
            ring_columns: dict[int, _Complex] = {}
            if ringing:
                own = x[[place[name] for name in RING]]
                mode, by_w, by_zeta = resonance(w, own)
                value = value + own[2] * mode * impulse
                response = direct + own[2] * mode
                for name, derivative in zip(
                    RING, (own[2] * by_w, own[2] * by_zeta, mode), strict=True
                ):
                    ring_columns[place[name]] = derivative * impulse
            by_angle = -1j * (data.orders / data.k)[:, None] * each * jumps
            by_values = (by_angle @ d_angles.T + each @ d_jumps.T).T * response
            by_values[0] += direct * 2 * omega * static * turned - direct * force / below * (
                2 * omega + 2j * xi * w
            )
            by_values[1] += -direct * force / below * 2j * omega * w
            by_values[-1] += direct * omega**2 * turned
            by_phase = -(by_angle.sum(axis=1)) * response
            by_phase = by_phase + direct * omega**2 * static * turned * 1j * data.orders / data.k
            ring_columns[place[f"phase {i}"]] = by_phase
            for part in (np.real, np.imag):
                row(
                    part(value - data.values) / data.errors, part(by_values) / data.errors,
                    {column: part(derivative) / data.errors for column, derivative in ring_columns.items()},
                )  # fmt: skip
        else:
            errors = data.angle_errors
            one = {place[f"phase {i}"]: -1 / errors}
            row((angles - data.angles) / errors, d_angles / errors, one)
        if data.phase is not None:
            off = math.remainder(phase - data.phase, 2 * math.pi)
            row(
                np.array([off / data.phase_error]),
                np.zeros((len(columns), 1)),
                {place[f"phase {i}"]: np.array([1 / data.phase_error])},
            )
        if data.F0 is not None and (K is not None or M is not None):
            stiffness = K if K is not None else (M or 0.0) * omega**2
            change = np.zeros((len(columns), 1))
            change[-1] = stiffness / data.F0_error
            if K is None:
                change[0] = 2 * stiffness / omega * static / data.F0_error
            row(np.array([(static * stiffness - data.F0) / data.F0_error]), change, {})
        return np.concatenate(f), np.vstack(J)

    # first by few harmonics, since the high ones turn fast with the times of impacts
    stage = FEW
    # which do not tell the ringing
    still = np.array([0.0 if name in RING else 1.0 for name in names])
    x, *_ = levenberg(residuals, x, scales * still, 1 / 3, accept)
    stage = 10**9
    x, f, J, converged = levenberg(residuals, x, scales, 1 / 3, accept)
    if not converged and not rough:
        raise SingularError(
            f"the fit did not converge: after {MOST_ITERATIONS} steps the squares of the {f.size} weighted "
            f"residuals add up to {float(f @ f):.3g}"
        )
    found = finished(sizes, x, f, J, names, place, shared(x), guesses, scales, ringing)
    for i, data in enumerate(records):
        left = np.sum(abs((predicted(data, found, i) - data.values) / data.errors) ** 2)
        if left > BAD * np.sum(abs(data.values / data.errors) ** 2):
            raise SingularError(
                f"no exact motion {data.pattern.sides}/{data.k} near the picked impacts fits the record"
            )
    return replace(found, speed=speed)


def turn_of(motion: Motion, data: Measured, phase: float) -> float:
    """The load cycles (radians) from the impacts of a motion to those that were picked."""
    off = data.angles - (described(motion)[0] - phase)
    return 2 * math.pi * round(float(np.median(off)) / (2 * math.pi))


def predicted(data: Measured, found: Fit, i: int) -> _Complex:
    """The harmonics of the acceleration of the fitted motion of record i."""
    phases, jumps = described(found.motions[i])
    omega, xi = found.values["omega"], found.values["xi"]
    static, w = found.lengths[i], data.frequencies
    turn = turn_of(found.motions[i], data, found.phases[i])
    _, impulse = data.impulses(phases - found.phases[i] + turn, jumps * omega * static)
    force = impulse + omega**2 * static * data.shape * np.exp(
        1j * found.phases[i] * data.orders / data.k
    )
    value: _Complex = -(w**2) / (omega**2 - w**2 + 2j * xi * omega * w) * force
    if found.ring is not None:
        value = value + found.ring[2] * resonance(w, found.ring)[0] * impulse
    return value


def finished(
    sizes: Sequence[int], x: _Array, f: _Array, J: _Array, names: list[str],
    place: dict[str, int], values: dict[str, float], motions: list[Motion], scales: _Array, ringing: bool,
) -> Fit:  # fmt: skip
    """Covariance, and what is not determined; `sizes` are the numbers of residuals of the records."""
    count = len(sizes)
    scaled = J * scales
    _, s, Vt = np.linalg.svd(scaled, full_matrices=True)
    s = np.concatenate([s, np.zeros(Vt.shape[0] - s.size)])
    determined = s > 1 / VAGUE
    freedom = max(1, f.size - int(determined.sum()))
    misfit = float(f @ f) / freedom
    # what the records do not determine may be wrong by as much as itself, and what depends on it a little by less
    inverse = 1 / np.maximum(s, 1.0) ** 2
    covariance = (Vt.T * inverse) @ Vt * np.outer(scales, scales) * max(1.0, misfit)
    vague = np.flatnonzero(np.sum(Vt[~determined] ** 2, axis=0) > 0.01)
    kept = [name for name in names if name in SHARED or name.startswith("F0/K")]
    undetermined = [name for name in kept if place[name] in vague]
    columns = [place[name] for name in kept]
    each = np.split(f, np.cumsum(sizes)[:-1])
    parts = [float(own @ own) / max(1, own.size - 4) for own in each]
    return Fit(
        values, [float(x[place[f"F0/K {i}"]]) for i in range(count)],
        [float(x[place[f"phase {i}"]]) for i in range(count)],
        x[[place[name] for name in RING]] if ringing else None, list(motions), kept,
        covariance[np.ix_(columns, columns)], undetermined, parts,
    )  # fmt: skip
