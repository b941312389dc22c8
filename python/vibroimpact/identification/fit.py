"""The parameters of a rig from the harmonics of its motion: exact motions fitted by weighted least squares."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .harmonics import Measured
from .impacts import resonance
from .known import HINT
from .laws import Law
from .least_squares import MOST_ITERATIONS, levenberg
from .motions import PARAMETERS, Impacting, System

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: The mode that rings: frequency (rad/s), damping ratio, share.
RING = ("ring omega", "ring damping", "ring share")
#: Largest difference of an impact time, in load cycles, from that where it was picked.
NEAR = 0.05
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
    motions: list[Impacting]
    #: Names of the columns of `covariance`, which has what was fitted, without ringing and load phases.
    names: list[str]
    covariance: _Array
    undetermined: list[str]
    misfits: list[float]


def fit(
    records: Sequence[Measured], known: Mapping[str, float], starts: Mapping[str, float],
    lengths: Sequence[float], phases: Sequence[float], ring: _Array | None, M: float | None = None,
    K: float | None = None, law: Law | None = None, near: Sequence[Impacting] = (), rough: bool = False,
) -> Fit:  # fmt: skip
    """Fit exact motions to the harmonics of one or more records.

    `known` are the shared parameters that are not fitted; `M` or `K` with the load of a record give its F0/K.
    `near` has motions to start from; by default it starts from the picked impacts. A `rough` fit, from which
    another one starts, need not converge.
    """
    law = law or Law()
    count = len(records)
    ringing = ring is not None and any(data.orders.size for data in records)
    free = [name for name in law.shared if name not in known]
    names = [*free, *(f"F0/K {i}" for i in range(count)), *(f"phase {i}" for i in range(count))]
    names += RING if ringing else ()
    place = {name: i for i, name in enumerate(names)}
    of_ring = ring if ringing and ring is not None else np.empty(0)
    x = np.array([*(starts[name] for name in free), *lengths, *phases, *of_ring])
    typical = {name: law.typical(name, starts[name]) for name in law.names if name in free}
    typical["xi"] = max(starts["xi"], 0.005)
    scales = np.array(
        [*(typical.get(name, abs(starts[name])) for name in free), *lengths, *([1.0] * count),
         *([0.05 * of_ring[0], 0.02, 0.3] if ringing else ())]
    )  # fmt: skip
    systems = [System(data, law) for data in records]
    walls = law.of_wall(0) + law.of_wall(1)
    columns = [
        [place.get(name) for name in (*PARAMETERS[:-2], f"F0/K {i}", f"phase {i}", *walls)]
        for i in range(count)
    ]
    of_static, of_phase = PARAMETERS.index("F0/K"), PARAMETERS.index("phase")
    guesses: list[Impacting] = []
    latest: list[Impacting] = []
    sizes: list[int] = []

    def shared(x: _Array) -> dict[str, float]:
        return {
            name: float(x[place[name]]) if name in place else known[name] for name in law.shared
        }

    def points(x: _Array) -> list[_Array]:
        values = shared(x)
        before, after = ([values[name] for name in names] for names in (PARAMETERS[:-2], walls))
        return [
            np.array([*before, x[place[f"F0/K {i}"]], x[place[f"phase {i}"]], *after])
            for i in range(count)
        ]

    def residuals(x: _Array) -> tuple[_Array, _Array]:
        here = points(x)
        latest[:] = [
            system.motion(p, guess.angles, guess.jumps)
            for system, p, guess in zip(systems, here, guesses, strict=True)
        ]
        both = [residuals_of(i, p, x) for i, p in enumerate(here)]
        sizes[:] = [f.size for f, _ in both]
        return np.concatenate([f for f, _ in both]), np.vstack([J for _, J in both])

    def accept() -> None:
        guesses[:] = latest

    def residuals_of(i: int, p: _Array, x: _Array) -> tuple[_Array, _Array]:
        motion, data = latest[i], records[i]
        omega, xi, static, phase = p[[0, 1, of_static, of_phase]]
        f, J = [], []

        def row(value: Any, by: _Array, by_ring: _Array | None = None) -> None:
            """Residuals, and their derivatives by the parameters of the motion and by the ringing."""
            f.append(np.atleast_1d(value))
            block = np.zeros((np.size(value), x.size))
            for column, derivative in zip(columns[i], np.atleast_2d(by).T, strict=True):
                if column is not None:
                    block[:, column] += derivative
            if by_ring is not None:
                block[:, -len(RING) :] = by_ring
            J.append(block)

        if data.orders.size:
            data = data.up_to(stage)
            each, impulse = data.impulses(motion.angles, motion.jumps)
            w, orders = data.frequencies, data.orders / data.k
            below = omega**2 - w**2 + 2j * xi * omega * w
            turned = data.shape * np.exp(1j * phase * orders)
            force = impulse + omega**2 * static * turned
            direct = -(w**2) / below
            value, response = direct * force, direct
            by_ring = None
            if ringing:
                own = x[-len(RING) :]
                mode, by_w, by_zeta = resonance(w, own)
                response = direct + own[2] * mode
                value = value + own[2] * mode * impulse
                by_ring = (
                    np.column_stack([own[2] * by_w, own[2] * by_zeta, mode]) * impulse[:, None]
                )
            by_angle = -1j * orders[:, None] * each * motion.jumps
            by = (by_angle @ motion.by[0] + each @ motion.by[1]) * response[:, None]
            slope = direct * force / below
            by[:, 0] += direct * 2 * omega * static * turned - slope * (2 * omega + 2j * xi * w)
            by[:, 1] -= slope * 2j * omega * w
            by[:, of_static] += direct * omega**2 * turned
            by[:, of_phase] += direct * omega**2 * static * turned * 1j * orders
            off, weights = (value - data.values) / data.errors, data.errors[:, None]
            for part in (np.real, np.imag):
                row(
                    part(off), part(by) / weights,
                    None if by_ring is None else part(by_ring) / weights,
                )  # fmt: skip
        else:
            errors = data.angle_errors
            row((motion.angles - data.angles) / errors, motion.by[0] / errors[:, None])
        one = np.eye(p.size)
        if data.phase is not None:
            off = math.remainder(phase - data.phase, 2 * math.pi)
            row(off / data.phase_error, one[of_phase] / data.phase_error)
        if data.F0 is not None and (K is not None or M is not None):
            stiffness = K if K is not None else (M or 0.0) * omega**2
            change = one[of_static] * stiffness
            if K is None:
                change = change + one[0] * 2 * stiffness / omega * static
            row((static * stiffness - data.F0) / data.F0_error, change / data.F0_error)
        return np.concatenate(f), np.vstack(J)

    for i, (data, p) in enumerate(zip(records, points(x), strict=True)):
        begin = near[i] if near else data
        nothing = f"no exact motion {data.pattern.sides}/{data.k} near the picked impacts"
        try:
            guesses.append(systems[i].motion(p, begin.angles, begin.jumps))
        except SingularError as error:
            raise SingularError(f"{nothing}: {error}; {HINT}") from None
        if abs(guesses[i].angles - data.angles).max() > 2 * math.pi * NEAR:
            raise SingularError(f"{nothing}: Newton's method goes to another one")
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
            f"residuals add up to {float(f @ f):.3g}; {HINT}"
        )
    found = finished(sizes, x, f, J, names, place, shared(x), guesses, scales, ringing)
    for i, data in enumerate(records):
        left = np.sum(abs((predicted(data, found, i) - data.values) / data.errors) ** 2)
        if left > BAD * np.sum(abs(data.values / data.errors) ** 2):
            raise SingularError(
                f"no exact motion {data.pattern.sides}/{data.k} near the picked impacts fits the record"
            )
    return found


def predicted(data: Measured, found: Fit, i: int) -> _Complex:
    """The harmonics of the acceleration of the fitted motion of record i."""
    omega, xi = found.values["omega"], found.values["xi"]
    w, motion = data.frequencies, found.motions[i]
    _, impulse = data.impulses(motion.angles, motion.jumps)
    turned = data.shape * np.exp(1j * found.phases[i] * data.orders / data.k)
    force = impulse + omega**2 * found.lengths[i] * turned
    value: _Complex = -(w**2) / (omega**2 - w**2 + 2j * xi * omega * w) * force
    if found.ring is not None:
        value = value + found.ring[2] * resonance(w, found.ring)[0] * impulse
    return value


def finished(
    sizes: Sequence[int], x: _Array, f: _Array, J: _Array, names: list[str],
    place: dict[str, int], values: dict[str, float], motions: list[Impacting], scales: _Array, ringing: bool,
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
    kept = [name for name in names if name not in RING and not name.startswith("phase")]
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
