"""The parameters of a rig from the flights of its primary mass: exact motions fitted by weighted least squares."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .contact import HALF_SINE
from .flights import HOPELESS
from .friction import Rubbing, of_no_friction
from .known import HINT
from .laws import Law
from .least_squares import MOST_ITERATIONS, levenberg
from .motions import CONTACT, PARAMETERS, Impacting, System
from .strains import WEAK, Strain, of_known
from .waves import Measured, predicted, turns_of

_Array = NDArray[np.float64]
#: Largest difference, in load cycles, between the time of an impact and the time at which it was picked.
NEAR = 0.05
#: Largest relative standard error of a combination of parameters that counts as determined.
VAGUE = 0.5
#: Unexplained share of the effect of impacts on the record above which a fit is rejected.
BAD = 0.5
#: Misfit above which a fit is doubtful.
DOUBTFUL = 2.0
#: Friction over F0 that is typical of a slot.
TYPICAL_FRICTION = 0.01
#: The exponents p of R (v/v0)^-p on each wall, which are 0 if R is constant, and their standard deviation: 1/4 is
#: that of plastic contacts, and walls by the law of Hunt and Crossley have 0.15 (R = 0.85) to 0.47 (R = 0.55).
EXPONENTS, TYPICAL_EXPONENT = ("exponent1", "exponent2"), 0.25
#: Standard deviations of a prior of the effects `CONTACT` of contacts that last, over their duration: R/(1 + R)^2
#: <= 1/4 for the depth, and about half for the push; and the step of a fit over these.
OF_CONTACT, TRIED = (0.25, 0.5), 3.0
#: Standard errors above which effects of contacts are not 0, and largest effect of these over that which the
#: pulses suggest.
CLEAR, MORE = 3.0, 1.5
#: Standard errors from 0 above which effects of contacts become part of a fit of exact motions, and by which they
#: may then be less than 0 or more than the pulses suggest.
SHOWN, BESIDE = 4.0, 2.0
#: Relative difference of speeds that count as equal.
EQUAL = 1e-6
#: Largest deviation from independently measured values, in standard errors.
FAR_OFF = 5.0


@dataclass
class Fit:
    """Fitted parameters with their covariance."""

    values: dict[str, float]
    #: F0/K of each record.
    lengths: list[float]
    phases: list[float]
    motions: list[Impacting]
    #: Names of the columns of `covariance`: the fitted parameters without load phases.
    names: list[str]
    covariance: _Array
    undetermined: list[str]
    misfits: list[float]
    #: Variance of a weighted residual, including that of slow changes.
    spread: float = 1.0
    #: Gain of the motion sensor, within its calibration.
    gain: float = 1.0
    #: For known values that were not fitted, and for load phases and amplitudes ("phase 0" and "F0 0" for the
    #: first record): the distance of the records from the value in standard errors, and the change of the value if
    #: it were fitted.
    strains: dict[str, Strain] = field(default_factory=dict)
    #: Relative growth of the coefficients of restitution during the record if they could grow, of both walls
    #: ("drift") and of each ("drift1", "drift2"); and that of "omega", "xi", "static" (F0/K) and "phase".
    drifts: dict[str, Strain] = field(default_factory=dict)
    #: For the names of `strains`, the derivatives of each fitted parameter with respect to the value that was not
    #: fitted.
    leans: dict[str, dict[str, float]] = field(default_factory=dict)
    #: Sums of squares of the weighted residuals of each record.
    squares: list[float] = field(default_factory=list)
    #: Misfit above which the fit is doubtful.
    most: float = DOUBTFUL
    #: Variance that flights leave just after impacts over that which they leave later.
    early: float = 1.0
    #: The slip of the free mass, for a friction over F0 of its own, of single flights.
    slips: Any = None
    #: Why the impacts contradict momentum and restitution, where flights alone are fitted.
    against: str = ""
    #: The covariance that effects add which are not part of the fit: contacts that may last as long as their
    #: pulses, and R that may depend on the speed.
    allowance: _Array | float = 0.0
    #: The part of the stated variances that is due to R that may depend on the speed.
    of_speed: dict[str, float] = field(default_factory=dict)
    #: Duration of contacts by their pulses (s), and by how much the walls are closer than d then (m).
    contact: float = 0.0
    closer: float = 0.0
    #: Standard errors from the effects of contacts that the records show to those that the pulses allow.
    unallowed: float = math.inf
    #: The effects of `CONTACT` and `EXPONENTS` that were not fitted, the information on them, and minus half the
    #: gradient of the sum of squares, both over `spread`.
    of_effects: tuple[list[str], _Array, _Array] | None = None
    #: The effects of contacts that were fitted, with their errors.
    lasting: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def stated(self) -> _Array:
        """The covariance of the stated errors, including effects that are not part of the fit."""
        return self.covariance + self.allowance

    @property
    def errors(self) -> dict[str, float]:
        """The stated errors of the fitted parameters."""
        return dict(zip(self.names, np.sqrt(np.diag(self.stated)).tolist(), strict=True))


def fit(
    records: Sequence[Measured], known: Mapping[str, float], starts: Mapping[str, float],
    lengths: Sequence[float], phases: Sequence[float], M: float | None = None,
    K: float | None = None, law: Law | None = None, near: Sequence[Impacting] = (), rough: bool = False,
    lasts: bool = False,
) -> Fit:  # fmt: skip
    """Fit exact motions to the flights of one or more records.

    `known` are the shared parameters that are not fitted; `M` or `K`, together with the load of a record,
    determine its F0/K. `near` contains motions to start from; by default the fit starts from the detected impacts.
    A `rough` fit, which only provides a start for another fit, need not converge.

    Impacts have no duration, unless the records show that contacts last, by about as much as their pulses allow.
    Then both effects of `CONTACT` are fitted (`lasts`), with priors from the duration of the pulses. Only the
    differences of these effects between impacts show, so that d remains the travel at the usual speed.
    """
    law = law or Law()
    count = len(records)
    # contacts may last as long as the pulses, but their effects are not part of the fit at first
    lasting = () if law.friction or rough else CONTACT
    given, contact = known, max(data.contact for data in records)
    known = {**known, **({} if lasts else dict.fromkeys(lasting, 0.0))}
    priors = dict(zip(CONTACT, contact * np.array(OF_CONTACT), strict=True)) if lasts else {}
    starts = {**starts, **dict.fromkeys(priors, 0.0)}
    free = [name for name in (*law.shared, *priors) if name not in known]
    names = [*free, *(f"F0/K {i}" for i in range(count)), *(f"phase {i}" for i in range(count))]
    # the sensor of the motion has a gain, which is known to its calibration
    calibration = max(data.calibration if data.places.size else 0.0 for data in records)
    ones = ["gain"] * (calibration > 0)
    names += ones
    place = {name: i for i, name in enumerate(names)}
    x = np.array([*(starts[name] for name in free), *lengths, *phases, *[1.0 for _ in ones]])
    typical = {name: law.typical(name, starts[name]) for name in law.names if name in free}
    typical["xi"] = max(starts["xi"], 0.005)
    typical["friction"] = TYPICAL_FRICTION
    # so that the prior alone determines them
    typical |= {name: 1.25 / VAGUE * size for name, size in priors.items()}
    scales = np.array(
        [*(typical.get(name, abs(starts[name])) for name in free), *lengths, *[1.0] * (count + len(ones))]
    )  # fmt: skip
    # no step leaves the possible range of the parameters
    bounds = {"xi": (0.0, 0.9), **dict.fromkeys(("omega", "mu", "d"), (0.0, math.inf))}
    bounds |= {
        name: (0.0, 1.0)
        for name in law.names
        if name[0] == "R" and law.kind in ("constant", "impacts")
    }
    bounds["friction"] = (0.0, math.inf)
    bounds |= {f"F0/K {i}": (0.0, math.inf) for i in range(count)}
    low, high = np.array([bounds.get(name, (-math.inf, math.inf)) for name in names]).T
    systems = [(Rubbing if law.friction else System)(data, law) for data in records]
    turns = [turns_of(data, data.places) for data in records]
    walls = (*law.of_wall(0), *law.of_wall(1), *["friction"] * law.friction, *lasting)
    if "d" not in known:
        # it is the travel at the usual speed, which the records determine
        usual = float(np.mean(np.concatenate([abs(data.jumps) for data in records])))
        for system in systems:
            system.usual = usual
    # also derivatives with respect to known values, to test whether the records agree with them
    held = [name for name in (*law.shared, *lasting) if name in known]
    column = place | {name: len(names) + i for i, name in enumerate(held)}
    columns = [
        [column[name] for name in (*PARAMETERS[:-2], f"F0/K {i}", f"phase {i}", *walls)]
        for i in range(count)
    ]
    of_static, of_phase = PARAMETERS.index("F0/K"), PARAMETERS.index("phase")
    guesses: list[Impacting] = []
    latest: list[Impacting] = []
    beyond: list[_Array] = []
    measured: dict[str, tuple[int, float]] = {}
    sizes: list[int] = []

    def shared(x: _Array) -> dict[str, float]:
        return {
            name: float(x[place[name]]) if name in place else known[name]
            for name in (*law.shared, *lasting)
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
        if ones:
            by = np.zeros((1, len(column)))
            by[0, x.size - 1] = 1 / calibration
            both.append((np.array([(x[-1] - 1) / calibration]), by))
        for name, size in priors.items():
            by = np.zeros((1, len(column)))
            by[0, place[name]] = 1 / size
            both.append((np.array([x[place[name]] / size]), by))
        f, J = np.concatenate([f for f, _ in both]), np.vstack([J for _, J in both])
        beyond[:] = J[:, x.size :].T
        return f, J[:, : x.size]

    def accept() -> None:
        guesses[:] = latest

    def residuals_of(i: int, p: _Array, x: _Array) -> tuple[_Array, _Array]:
        motion, data = latest[i], records[i]
        omega, xi, static, phase = p[[0, 1, of_static, of_phase]]
        f: list[_Array] = []
        J: list[_Array] = []

        def row(value: Any, by: _Array, name: str = "", error: float = 1.0) -> None:
            """Residuals, and their derivatives with respect to the parameters of the motion; a residual against a
            measured value has its name and error."""
            if name:
                measured[f"{name} {i}"] = sum(one.size for one in f), error
            f.append(np.atleast_1d(value))
            block = np.zeros((np.size(value), len(column)))
            for own, derivative in zip(columns[i], np.atleast_2d(by).T, strict=True):
                block[:, own] += derivative
            J.append(block)

        if data.places.size:
            one = predicted(
                data, data.places, data.order, omega, xi, static, phase, motion.angles, motion.jumps,
                turns[i],
            )  # fmt: skip
            by = one.along(motion.by)
            by[:, [0, 1, of_static, of_phase]] += one.by_system
            value = one.value
            if motion.aside is not None:
                by, value = by + motion.aside_by, value + motion.aside
            gain = float(x[place["gain"]]) if ones else 1.0
            both = np.column_stack([gain * value - data.values, gain * by, value])
            both /= data.errors[:, None]
            both -= data.beside @ (data.beside.T @ both)
            row(both[:, 0], both[:, 1:-1])
            if ones:
                J[-1][:, x.size - 1] = both[:, -1]
        else:
            errors = data.angle_errors
            row((motion.angles - data.angles) / errors, motion.by[0] / errors[:, None])
        one_of = np.eye(p.size)
        if data.phase is not None:
            off = math.remainder(phase - data.phase, 2 * math.pi)
            row(
                off / data.phase_error,
                one_of[of_phase] / data.phase_error,
                "phase",
                data.phase_error,
            )
        if data.F0 is not None and (K is not None or M is not None):
            stiffness = K if K is not None else (M or 0.0) * omega**2
            change = one_of[of_static] * stiffness
            if K is None:
                change = change + one_of[0] * 2 * stiffness / omega * static
            row(
                (static * stiffness - data.F0) / data.F0_error,
                change / data.F0_error,
                "F0",
                data.F0_error,
            )
        return np.concatenate(f), np.vstack(J)

    for i, (data, p) in enumerate(zip(records, points(x), strict=True)):
        begin = near[i] if near else data
        nothing = f"no exact motion {data.pattern.sides}/{data.k} near the detected impacts"
        try:
            guesses.append(systems[i].motion(p, begin.angles, begin.jumps))
        except SingularError as error:
            raise SingularError(f"{nothing}: {error}; {HINT}") from None
        if abs(guesses[i].angles - data.angles).max() > 2 * math.pi * NEAR:
            raise SingularError(f"{nothing}: Newton's method converges to a different one; {HINT}")
    hopeless = math.inf if rough else HOPELESS
    x, f, J, converged = levenberg(residuals, x, scales, WEAK, accept, low, high, hopeless=hopeless)
    if not converged and not rough:
        raise SingularError(
            f"the fit does not converge within {MOST_ITERATIONS} steps: the squares of the {f.size} weighted "
            f"residuals add up to {float(f @ f):.3g}; {HINT}"
        )
    if ones and abs(x[-1] - 1) > FAR_OFF * calibration:
        raise SingularError(far_off_gain(float(x[-1]), calibration))
    # components that are projected out are also degrees of freedom
    freedoms = [size - data.beside.shape[1] for size, data in zip(sizes, records, strict=True)]
    found = finished(sizes, freedoms, records, x, f, J, names, place, shared(x), guesses, scales)
    for i, data in enumerate(records):
        rest = [explained(data, found, i, share) for share in (1.0, 0.0)]
        if rest[0] > BAD * rest[1]:
            raise SingularError(
                f"no exact motion {data.pattern.sides}/{data.k} near the detected impacts fits the record; {HINT}"
            )
    residuals(x)
    free_of = dict(zip(held, beyond, strict=True))
    starts_at = np.cumsum([0, *sizes])
    for name, (own, size) in measured.items():
        free_of[name] = np.zeros(f.size)
        free_of[name][starts_at[int(name.split()[-1])] + own] = -1 / size
    if not (law.friction or rough):
        with contextlib.suppress(SingularError):
            free_of["friction"] = by_friction(records, law, found, points(x), sizes, f.size)
    effects = [name for name in lasting if name in held]
    if lasting and law.kind == "constant" and all(data.places.size for data in records):
        with contextlib.suppress(SingularError):
            usual = systems[0].usual
            by_speed = by_exponents(records, found, points(x), sizes, f.size, usual)
            free_of |= dict(zip(EXPONENTS, by_speed.T, strict=True))
            effects += EXPONENTS
    found.strains, found.leans = of_known(f, J, scales, names, free_of, found.spread)
    if effects:
        along = np.column_stack([free_of[name] for name in effects])
        U, s, _ = np.linalg.svd(J * scales, full_matrices=False)
        along -= U[:, s > 1e-9 * s[0]] @ (U[:, s > 1e-9 * s[0]].T @ along)
        information, pull = along.T @ along / found.spread, -along.T @ f / found.spread
        allow_effects(found, contact, effects, information, pull)
        more = 1 / (found.values["mu"] or math.inf)
        found.closer = 2 * OF_CONTACT[0] * found.contact * (1 + more) * systems[0].usual
    if lasts:
        found.lasting = {name: (found.values[name], found.errors[name]) for name in priors}
        return found
    shown = max(
        (abs(found.strains[name].size) for name in CONTACT if name in found.strains), default=0.0
    )
    if contact and lasting and law.kind == "constant" and shown > SHOWN:
        with contextlib.suppress(SingularError):
            other = fit(
                records,
                given,
                found.values,
                found.lengths,
                found.phases,
                M,
                K,
                law,
                found.motions,
                lasts=True,
            )
            gain = sum(found.squares) - sum(other.squares)
            if agreeing(other, contact) and gain > CLEAR**2 * other.spread:
                return other
    return found


def agreeing(found: Fit, contact: float) -> bool:
    """Whether the fitted effects of contacts are those of contacts of up to a given duration."""
    # without what else may change, which would let a wrong known value pass
    errors = dict(zip(found.names, np.sqrt(np.diag(found.covariance)).tolist(), strict=True))
    return all(
        -BESIDE * errors[name] <= found.values[name] <= share * contact + BESIDE * errors[name]
        for name, share in zip(CONTACT, OF_CONTACT, strict=True)
    )


def allow_effects(
    found: Fit, contact: float, names: Sequence[str], information: _Array, pull: _Array
) -> None:  # fmt: skip
    """Add the effects of contacts of up to a given duration, and of R that depends on the speed, to the errors, as
    far as the records show or do not exclude them.

    `names` are those of `CONTACT` and `EXPONENTS` that are not part of the fit; this test uses the information of
    the residuals on them and minus half the gradient of the sum of squares, both over the variance of a residual.
    """
    leans = [found.leans.pop(name) for name in names]
    found.contact = contact
    size_of = dict(zip(CONTACT, contact * np.array(OF_CONTACT), strict=True))
    size = np.array([size_of.get(name, TYPICAL_EXPONENT) for name in names])
    if not size.any():
        return
    by = np.array([[lean.get(own, 0.0) for lean in leans] for own in found.names]) * size
    # by rounding, values may be negative: this is no information, and would give negative variances
    own, pull = information * np.outer(size, size), pull * size
    values, axes = np.linalg.eigh(own)
    values = np.maximum(values, 0.0)
    own = axes * values @ axes.T
    # the mean square of the effects: their covariance, and their mean, which the fit does not have
    spread = axes / (values + 1) @ axes.T
    mean = np.clip(spread @ pull, -1.0, 1.0)
    spread += np.outer(mean, mean)
    found.allowance = by @ spread @ by.T
    # a force that lasts makes the primary mass swing less than its impulse, as a lighter free mass would
    share = 0.5 * (HALF_SINE * contact * found.values["omega"]) ** 2
    of_mass = {"mu": 1.0} if "mu" in found.names else found.leans.get("mu", {})
    by_mass = share * found.values["mu"] * np.array([of_mass.get(own, 0.0) for own in found.names])
    found.allowance += np.outer(by_mass, by_mass)
    lasts = np.array([name in CONTACT for name in names])
    of_speed = by[:, ~lasts] @ spread[np.ix_(~lasts, ~lasts)] @ by[:, ~lasts].T
    shares = np.diag(of_speed) / np.maximum(np.diag(found.stated), 1e-300)
    found.of_speed = dict(zip(found.names, shares.tolist(), strict=True))
    inner = np.ix_(lasts, lasts)
    if contact and lasts.any():
        found.unallowed = unallowed(own[inner], pull[lasts])
    # contacts that last may resemble R that depends on the speed
    for i, name in enumerate(names):
        if lasts[i] or name not in found.strains:
            continue
        alike = np.linalg.solve(own[inner] + np.eye(int(lasts.sum())), own[lasts, i])
        left, slope = float(own[i, i] - alike @ own[lasts, i]), float(pull[i] - alike @ pull[lasts])
        found.strains[name] = Strain(
            slope / math.sqrt(max(left, 1e-300)), size[i] * slope / max(left, 1e-300)
        )


def unallowed(information: _Array, pull: _Array) -> float:
    """Standard errors from the effects of contacts to the nearest ones from 0 to `MORE`, by the information on
    them and minus half the gradient of the sum of squares at 0."""
    nearest = np.zeros(pull.size)
    for _ in range(200):
        for i in range(pull.size):
            step = (pull[i] - information[i] @ nearest) / max(information[i, i], 1e-300)
            nearest[i] = np.clip(nearest[i] + step, 0.0, MORE)
    most = pull @ np.linalg.pinv(information, rcond=1e-9, hermitian=True) @ pull
    return math.sqrt(max(0.0, float(most - (2 * pull - information @ nearest) @ nearest)))


def by_friction(
    records: Sequence[Measured], law: Law, found: Fit, points: Sequence[_Array], sizes: Sequence[int], count: int
) -> _Array:  # fmt: skip
    """The derivatives of the weighted residuals with respect to friction in the slot, over the F0 of the first
    record, of a rig that has none."""
    every = np.zeros(count)
    begins = np.cumsum([0, *sizes])
    for i, (data, p) in enumerate(zip(records, points, strict=True)):
        motion = of_no_friction(data, law, p[: 6 + 2 * len(law.of_wall(0))], found.motions[i])
        by_friction = motion.by[:, :, -1:] * found.lengths[0] / found.lengths[i]
        if data.places.size:
            omega, xi, static, phase = p[[0, 1, 4, 5]].tolist()
            one = predicted(
                data, data.places, data.order, omega, xi, static, phase, motion.angles, motion.jumps
            )
            own = motion.aside_by[:, -1] * found.lengths[0] / found.lengths[i]
            own = found.gain * (one.along(by_friction)[:, 0] + own) / data.errors
            own -= data.beside @ (data.beside.T @ own)
        else:
            own = by_friction[0, :, 0] / data.angle_errors
        every[begins[i] : begins[i] + own.size] = own
    return every


def by_exponents(
    records: Sequence[Measured], found: Fit, points: Sequence[_Array], sizes: Sequence[int], count: int,
    usual: float,
) -> _Array:  # fmt: skip
    """The derivatives of the weighted residuals with respect to `EXPONENTS` (count, 2) of a rig whose coefficients
    of restitution are constant; v0 is the mean speed of the impacts on each wall."""
    every = np.zeros((count, 2))
    signs = np.concatenate([data.pattern.signs for data in records])
    speeds = np.concatenate([motion.speeds for motion in found.motions])
    walls = [speeds[signs == sign] for sign in (1, -1)]
    # impacts of equal speed do not depend on the exponent
    differ = np.array([own.size > 1 and np.ptp(own) > EQUAL * own.max() for own in walls])
    v0 = np.array([own.mean() if own.size else 1.0 for own in walls])
    begins = np.cumsum([0, *sizes])
    for i, (data, p) in enumerate(zip(records, points, strict=True)):
        system = System(data, Law("powers", v0=1.0))
        system.usual = usual
        near = found.motions[i]
        motion = system.motion(np.insert(p, [7, 8], 0.0), near.angles, near.jumps)
        # the parameters of the walls are now R1, exponent1, R2 and exponent2
        by = differ * (motion.by[:, :, [7, 9]] + motion.by[:, :, [6, 8]] * np.log(v0) * p[6:8])
        omega, xi, static, phase = p[[0, 1, 4, 5]].tolist()
        one = predicted(
            data, data.places, data.order, omega, xi, static, phase, motion.angles, motion.jumps
        )
        own = found.gain * one.along(by) / data.errors[:, None]
        own -= data.beside @ (data.beside.T @ own)
        every[begins[i] : begins[i] + own.shape[0]] = own
    return every


def far_off_gain(gain: float, calibration: float) -> str:
    """The message about a sensor whose fitted gain is outside its calibration."""
    return (
        f"the motion is {gain:.4g} times as large as the known values imply, with a calibration error of "
        f"{calibration:.3g}: a known value or the calibration may be wrong; {HINT}"
    )


def explained(data: Measured, found: Fit, i: int, share: float) -> float:
    """Sum of squares of record i with a given share of the jumps of the fitted motion."""
    if not data.places.size:
        return 0.0
    values, motion = found.values, found.motions[i]
    here = predicted(
        data, data.places, data.order, values["omega"], values["xi"], found.lengths[i], found.phases[i],
        motion.angles, share * motion.jumps,
    )  # fmt: skip
    value = here.value if motion.aside is None else here.value + motion.aside
    off = (found.gain * value - data.values) / data.errors
    off -= data.beside @ (data.beside.T @ off)
    return float(off @ off)


def covariance_of(J: _Array, scales: _Array) -> tuple[_Array, set[int], int]:
    """Covariance of the parameters by the derivatives of weighted residuals, places of those that are not
    determined,
    and how many combinations are."""
    # many residuals need no complete basis of their own
    _, s, Vt = np.linalg.svd(J * scales, full_matrices=J.shape[0] < J.shape[1])
    s = np.concatenate([s, np.zeros(Vt.shape[0] - s.size)])
    determined = s > 1 / VAGUE
    # a parameter that is not determined may be wrong by as much as its value; one that depends on it slightly, by
    # less
    inverse = 1 / np.maximum(s, 1.0) ** 2
    covariance: _Array = (Vt.T * inverse) @ Vt * np.outer(scales, scales)
    vague = np.flatnonzero(np.sum(Vt[~determined] ** 2, axis=0) > 0.01)
    return covariance, set(vague.tolist()), int(determined.sum())


def finished(
    sizes: Sequence[int], freedoms: Sequence[int], records: Sequence[Measured], x: _Array, f: _Array,
    J: _Array, names: list[str], place: dict[str, int], values: dict[str, float], motions: list[Impacting],
    scales: _Array,
) -> Fit:  # fmt: skip
    """Covariance and undetermined parameters; for each record the numbers of residuals and degrees of freedom."""
    count = len(sizes)
    covariance, vague, determined = covariance_of(J, scales)
    freedom = max(1, sum(freedoms) - determined)
    misfit = float(f @ f) / freedom
    spread = max(1.0, misfit) * max(data.drift * data.colour for data in records)
    covariance *= spread
    kept = [name for name in names if not name.startswith(("phase", "gain"))]
    undetermined = [name for name in kept if place[name] in vague]
    columns = [place[name] for name in kept]
    each = np.split(f, np.cumsum(sizes))[:count]
    parts = [
        float(own @ own) / max(1, n - 4) * data.drift
        for own, n, data in zip(each, freedoms, records, strict=True)
    ]
    return Fit(
        values, [float(x[place[f"F0/K {i}"]]) for i in range(count)],
        [float(x[place[f"phase {i}"]]) for i in range(count)],
        list(motions), kept,
        covariance[np.ix_(columns, columns)], undetermined, parts, spread,
        float(x[place["gain"]]) if "gain" in place else 1.0, squares=[float(own @ own) for own in each],
    )  # fmt: skip
