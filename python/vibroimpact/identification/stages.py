"""The stages of a fit: each record separately, then all together, then with a law of restitution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, SingularError
from .aperiodic import LEAST_IMPACTS, TooFewError, by_flights, by_laws
from .attempts import Attempts
from .fit import DOUBTFUL, Fit, fit
from .flights import HOPELESS, LEAST_GAIN
from .known import HINT, unit_hint
from .laws import KNOWN_OF_LAW, Law
from .motions import Impacting
from .signals import LEAST_PICKS, no_rhythm, repeated, scatter_after
from .start import start_of, start_of_phases, start_of_times, start_together
from .steps import NotTriedError, Step, cycles_of, flown, flown_apart, ordered, silent
from .waves import Measured
from .windows import unfound_ringing

_Array = NDArray[np.float64]
#: Distance between an impact of the fitted motion and that of the flights, in standard errors, above which a fit
#: is doubtful.
FAR = 5.0
#: Damping ratios with which a fit that failed is repeated.
STARTS = (0.003, 0.01, 0.02, 0.04)
#: Jumps of the velocity below this number of errors may be on the other wall; largest number of such impacts that
#: are tried.
UNCLEAR, MOST_UNCLEAR = 4.0, 3
#: Coefficients of restitution with which the linear equations are tried.
TRIED = (0.7, 0.6, 0.85)
#: Smallest number of periods in a record for which twice the period is tried.
FEWEST_PERIODS = 6
#: Largest ratio of two load amplitudes that should be equal.
LARGEST_RATIO = 1.5
#: The beginning of the notes about the impacts that give the parameters, of those without parameters, and of a
#: motion that is not found; a fit with friction explains the impacts anew.
APART = (
    "momentum and restitution at",
    "impacts give no parameters",
    "doubtful: the impacts of single flights repeat",
)


def fitted(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float],
    law: Law, law_speed: float | None,
) -> tuple[Fit, Law]:  # fmt: skip
    """The fit of exact motions to all records, and the law of restitution with its reference speed and knots."""
    # constants first: known parameters of a law do not apply to them
    constant = {
        name: value for name, value in shared.items()
        if law.kind == "constant" or name not in ("R1", "R2", *KNOWN_OF_LAW)
    }  # fmt: skip
    M, K = scale.get("M"), scale.get("K")
    found: list[Measured] = []
    single: list[Fit] = []
    for step in steps:
        # first each record separately, with a coefficient for each impact if there is a law; then all records,
        # starting from the combined results
        rough = law.kind != "constant" or len(steps) > 1
        single.append(alone(step, scale, constant, guess, law, rough))
        assert step.data is not None
        found.append(step.data)
    if len(found) == 1 and law.kind == "constant":
        return single[0], law
    middle = dict(constant)
    same = ("omega", "xi", "mu", "d") if law.kind != "constant" else law.shared
    for name in (name for name in same if name not in constant):
        sizes = [
            one.covariance[j, j] if name not in one.undetermined else math.inf
            for one in single for j in [one.names.index(name)]
        ]  # fmt: skip
        weights = np.array([1 / max(size, 1e-300) for size in sizes])
        weights = weights if weights.any() else np.ones(len(single))
        middle[name] = float(np.average([one.values[name] for one in single], weights=weights))
    lengths, phases = [one.lengths[0] for one in single], [one.phases[0] for one in single]
    near = [one.motions[0] for one in single]
    if law.kind != "constant":
        law, of_law = start_of_law(single, found, law, shared, law_speed)
        middle |= of_law
    if law.kind == "knees":
        # first with one knee for both walls
        alike = replace(law, kind="knee")
        begin = middle | {name: middle[name + "1"] for name in ("exponent", "knee")}
        known = {name: value for name, value in shared.items() if name not in KNOWN_OF_LAW}
        one = fit(found, known, begin, lengths, phases, M, K, alike, near, rough=True)
        lengths, phases, near = one.lengths, one.phases, one.motions
        middle |= {
            name: shared.get(name, one.values[name.rstrip("12") if name[0] != "R" else name])
            for name in law.shared
        }
    # start from the combined results of all records, then from the results of single records
    starts = [middle]
    if law.kind == "constant":
        starts += [middle | {name: one.values[name] for name in law.shared} for one in single]
    failed: SingularError | None = None
    for begin in starts:
        try:
            both = fit(found, shared, begin, lengths, phases, M, K, law, near)
        except SingularError as error:
            failed = failed or error
            continue
        if begin is starts[-1] or max(both.misfits) < DOUBTFUL:
            return both, law
    assert failed is not None
    raise failed


def alone(
    step: Step, scale: Mapping[str, float], constant: dict[str, float], guess: dict[str, float], law: Law,
    rough: bool,
) -> Fit:  # fmt: skip
    """The fit to one record.

    Near a fold or a pitchfork, beyond which no exact motion exists, a fit may stop before it reaches the values
    obtained from the flights alone, and near a flip or a pitchfork it may stay on the motion from which the right
    one branches off. It is then repeated from a fit in which the impacts are free, and with other damping ratios,
    for which the linear equations give other starting parameters.
    """
    M, K = scale.get("M"), scale.get("K")
    best: Fit | None = None
    failed: SingularError | None = None
    tries: list[float | str] = [""]
    if step.free is not None:
        tries += ["together"] * (law.kind == "constant" and step.free.misfit < DOUBTFUL)
        tries += STARTS if "xi" not in constant else ()
    for one in tries:
        assert step.data is not None
        near: Sequence[Impacting] = ()
        own = law if law.kind == "constant" else Law("impacts", step.data.angles.size)
        try:
            if step.free is not None:
                start = constant if isinstance(one, str) else constant | {"xi": one}
                values, static, phase = start_of(step, start, guess)
                if one == "together":
                    stiffness = K if K is not None or M is None else M * values["omega"] ** 2
                    values, static, phase, *near = start_together(
                        step.data, constant, values, static, phase, stiffness
                    )
            else:
                step.data, values, static, phase = start_of_times(step.data, scale, constant, guess)
            found = fit([step.data], constant, values, [static], [phase], M, K, own, near, rough)
        except SingularError as error:
            failed = failed or error
            continue
        if best is None or max(found.misfits) < max(best.misfits):
            best = found
        # other damping ratios are of no use where the motion fits but for an effect that is not part of it
        most = DOUBTFUL * step.data.drift
        if not astray(step, best) or (one != "" and max(best.misfits) < most):
            return best
    if best is None and step.free is not None and step.free.misfit < DOUBTFUL:
        assert step.data is not None
        best = from_phases(step, step.data, scale, constant, guess, law, rough)
    if best is None:
        assert failed is not None
        raise failed
    return best


def astray(step: Step, found: Fit) -> bool:
    """Whether the motion of a fit leaves much more than the flights alone."""
    assert step.data is not None
    # a change of the rig during the record is not an error of the fit
    if max(found.misfits) >= DOUBTFUL * step.data.drift:
        return True
    free = step.free
    return free is not None and sum(found.squares) - free.square > LEAST_GAIN * found.spread


def from_phases(
    step: Step, data: Measured, scale: Mapping[str, float], constant: dict[str, float],
    guess: Mapping[str, float], law: Law, rough: bool,
) -> Fit | None:  # fmt: skip
    """The fit to a record for which Newton's method, started from the flights, fails or finds another motion.

    Each start uses the linear equations for the phases of the impacts, which need no guess, with several damping
    ratios and coefficients of restitution. The result is None if no start leads to a motion.
    """
    assert step.free is not None
    own = law if law.kind == "constant" else Law("impacts", data.angles.size)
    for xi, R in product((max(step.free.xi, STARTS[0]), *STARTS[1:3]), TRIED):
        walls = dict.fromkeys(("R1", "R2", *Law("impacts", data.angles.size).names), R)
        values = {**guess, "omega": step.free.omega, "xi": xi, **walls, **constant}
        try:
            start, static, phase, motion = start_of_phases(data, constant, values, step.free.static)
            return fit(
                [data], constant, start, [static], [phase], scale.get("M"), scale.get("K"), own, (motion,), rough
            )  # fmt: skip
        except SingularError:
            continue
    return None


def halved(
    steps: Sequence[Step], found: Fit, law: Law, scale: Mapping[str, float], shared: dict[str, float],
    guess: dict[str, float],
) -> tuple[list[Step], Fit] | None:  # fmt: skip
    """The fit of motions of half the period, started from a motion of the whole period; None if there is none.

    A fit with twice the period has more freedom and may succeed where the fit with the shorter period fails. If
    the shorter period describes the record equally well, it is the right one.
    """
    others = [copy(step) for step in steps]
    try:
        for step in others:
            assert step.data is not None
            if step.data.k % 2:
                return None
            step.data = replace(step.data, k=step.data.k // 2)
            flown(step, scale, shared, guess)
        data = [step.data for step in others if step.data is not None]
        if len(data) < len(others):
            return None
        # flights of half the period may have other impacts
        if any(
            2 * one.angles.size != motion.angles.size
            for one, motion in zip(data, found.motions, strict=True)
        ):
            return None
        ensure_possible(others)
        M, K = scale.get("M"), scale.get("K")
        near = [first_half(motion, one) for motion, one in zip(found.motions, data, strict=True)]
        # it does not converge if it ends at a fold, beyond which no motion exists
        half = fit(
            data, shared, found.values, found.lengths, found.phases, M, K, law, near, rough=True
        )
    except SingularError:
        return None
    return (others, half) if max(half.misfits) < DOUBTFUL else None


def twice_as_long(
    steps: Sequence[Step], single: tuple[list[Step], Fit | None, Law], scale: Mapping[str, float],
    shared: dict[str, float], guess: dict[str, float], law: Law, law_speed: float | None,
) -> tuple[list[Step], Fit, Law] | None:  # fmt: skip
    """The fit of motions of twice the period to a record whose impacts repeat according to its individual flights,
    although no motion of the period that was found describes it; None if there is none.

    Where the two halves of a period are nearly equal, only the flights of a short record distinguish them.
    """
    step = copy(steps[0])
    if len(steps) > 1 or step.data is None or step.record is None or not again(single[0][0]):
        return None
    k = 2 * step.data.k
    if cycles_of(step.record, step.Omega) < FEWEST_PERIODS * k:
        return None
    # the difference between the halves of a period is not scatter
    step.noise = max(
        scatter_after(step.motion, step.record.rate, step.Omega, k),
        step.record.noise.get(step.quantity, 0.0),
    )
    step.data = replace(step.data, k=k)
    try:
        flown(step, scale, shared, guess)
        if step.rhythm.status != "periodic":
            return None
        ensure_possible([step])
        found, own = fitted([step], scale, shared, guess, law, law_speed)
    except SingularError:
        return None
    if max(found.misfits) > DOUBTFUL or far_off([step], found):
        return None
    doubt_halves([step], found)
    return [step], found, own


def doubt_halves(steps: Sequence[Step], found: Fit) -> None:
    """Doubt twice the period that the scatter shows if impacts on the same walls follow in both of its halves."""
    for step, motion in zip(steps, found.motions, strict=True):
        right = motion.jumps > 0
        half = len(right) // 2
        if np.array_equal(right[:half], right[half:]):
            step.notes.append(
                "doubtful: both halves of the period have the same impacts, so the true period may be half of it"
            )


def doubt_period(steps: Sequence[Step], found: Fit) -> None:
    """Doubt the period of a motion that differs from period to period by more than its noise if the fit is too
    vague to show whether a motion of this period describes it."""
    for step in steps:
        if step.scattered and found.undetermined:
            step.notes.append(
                f"doubtful: the motion differs from period to period by more than the noise of its samples, and "
                f"the fit does not determine {', '.join(found.undetermined)}: the motion may not be periodic"
            )


def from_single(
    steps: list[Step], single: tuple[list[Step], Fit | None, Law], scale: Mapping[str, float],
    shared: Mapping[str, float],
) -> tuple[list[Step], Fit, Law] | None:  # fmt: skip
    """The fit of motions started from the parameters of the individual flights; None if it does not describe the
    record.

    Near a pitchfork or a flip, a fit may have reached the motion from which the correct motion branches off, and
    may stay on it.
    """
    data, (_, near, law) = steps[0].data, single
    assert data is not None
    assert near is not None
    try:
        ensure_possible(steps)
        found = fit(
            [data],
            shared,
            near.values,
            near.lengths,
            near.phases,
            scale.get("M"),
            scale.get("K"),
            law,
        )
    except SingularError:
        return None
    return None if max(found.misfits) > DOUBTFUL or far_off(steps, found) else (steps, found, law)


def first_half(motion: Impacting, data: Measured) -> Impacting:
    """The impacts of the first half of a motion, with load phases near those of flights."""
    N = data.angles.size
    turn = 2 * math.pi * round(float(np.mean(data.angles - motion.angles[:N])) / (2 * math.pi))
    return motion._replace(angles=motion.angles[:N] + turn, jumps=motion.jumps[:N])


def identified_by(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float],
    law: Law, law_speed: float | None, progress: Callable[[float, str], None] | None = None,
) -> tuple[list[Step], Fit | None, Law]:  # fmt: skip
    """The steps with their flights and the fit of exact motions or, for records without exact motions, of
    individual flights.

    If there is no exact motion, the weakest impact may be spurious, or the motion may not be quite periodic, or
    the period may be twice as long. `progress` receives the share of all possible attempts, most of which are
    seldom needed.
    """
    given = scale, shared, guess, law, law_speed
    told(steps, progress, 0, 7)
    failed: SingularError | None = None
    described = False
    tried = Attempts()
    if any(step.data is None for step in steps):
        return explained(apart(steps, *given), tried, shared)
    single: tuple[list[Step], Fit | None, Law] | None = None
    attempts = ["as it is", "joined", "other walls", "fewer", "exactly", "apart", "twice"]
    if len(steps) == 1 and steps[0].restless:
        # an almost periodic record is found sooner by single flights, so little else is tried
        single = apart(steps, *given)
        if clear(single[1]) and not again(single[0][0]):
            return because(single, "its scatter from period to period exceeds its noise")
        attempts = ["as it is", "apart"]

    def aperiodic() -> bool:
        """Whether single flights determine all parameters, and have impacts that do not repeat."""
        nonlocal single
        if single is None:
            report, steps[0].report = steps[0].report, silent
            single = apart(steps, *given)
            steps[0].report = report
        return clear(single[1]) and not again(single[0][0])

    for i, attempt in enumerate(attempts):
        told(steps, progress, i + (single is not None), len(attempts) + 1)
        others = [copy(step) for step in steps]
        measured = [step for step in others if step.record is not None]
        if len(measured) == len(steps) == 1:
            measured[0].aperiodic = aperiodic
        if failed is not None and not measured:
            break
        try:
            if attempt == "apart":
                single = single or apart(steps, *given)
                if clear(single[1]):
                    return because(single, str(failed))
                if single[1] is not None:
                    tried.misfitting(attempt, single[0], single[1])
                continue
            for step in measured:
                assert step.data is not None
                if attempt == "twice":
                    step.data = replace(step.data, k=2 * step.data.k)
                    if step.data.k > step.most_cycles:
                        raise NotTriedError("too few periods")
                    if hopeless(step):
                        raise NotTriedError("flights of half this period do not explain the record")
                if attempt == "exactly" and not (
                    step.data.calibration and step.data.F0 is not None
                ):
                    raise NotTriedError("the sensors are exact, or there is no load")
                flown(step, scale, shared, guess, attempt)
                described |= step.free is not None and step.free.misfit < DOUBTFUL
            if not all(step.rhythm.status == "periodic" for step in others):
                single = single or apart(steps, *given)
                if clear(single[1]):
                    return because(single, "no set of flights between impacts describes it")
                number = max((step.times.size for step in others if several(step)), default=0)
                if number:
                    why = f"the flights do not confirm {number} detected impacts"
                    return explained(because(single, why), tried, shared)
                return explained((others, None, law), tried, shared)
            # if a fit is possible only with another pattern, its misfit must be small
            if failed is not None:
                ensure_possible(measured)
            if attempt == "other walls":
                if len(steps) > 1 or law.kind != "constant":
                    raise NotTriedError("several records, or a law")
                found, own = on_other_walls(others[0], scale, shared, guess, law), law
            else:
                found, own = fitted(others, *given)
        except SingularError as error:
            failed = failed or error
            tried.refused(attempt, others, error)
            # a record that no motion describes, with impacts that do not repeat, is not periodic
            ask = single is not None or attempt == "as it is"
            if len(measured) == len(steps) == 1 and ask and aperiodic() and single is not None:
                return because(single, str(failed))
            continue
        # a fit that is possible only with another pattern must be good
        if failed is not None and max(found.misfits) > DOUBTFUL:
            tried.misfitting(attempt, others, found)
            continue
        if attempt == "twice":
            half = halved(others, found, own, scale, shared, guess)
            others, found = half or (others, found)
            if half is None:
                doubt_halves(others, found)
        if far_off(others, found) or max(found.misfits) > DOUBTFUL:
            single = single or apart(steps, *given)
            if clear(single[1]):
                other = from_single(others, single, scale, shared) or twice_as_long(
                    steps, single, *given
                )
                return other or because(single, "its exact motion does not describe it")
        doubt_period(others, found)
        return others, found, own
    if "twice" in attempts:
        with_other_loads(steps, scale, shared, guess)
    assert failed is not None
    if described or any(step.record is None for step in steps):
        raise SingularError(f"{failed}; {tried.said(steps, shared)}") from failed
    # no periodic flights describe it
    return explained(because(single or apart(steps, *given), str(failed)), tried, shared)


def explained(
    found: tuple[list[Step], Fit | None, Law], tried: Attempts, shared: Mapping[str, float]
) -> tuple[list[Step], Fit | None, Law]:
    """The result; without a fit, with a note of the attempts and of possible remedies."""
    steps, fit_of_all, _ = found
    if fit_of_all is None and any(several(step) for step in steps):
        steps[0].notes.append(f"nothing is fitted; {tried.said(steps, shared)}")
    return found


def told(
    steps: Sequence[Step], progress: Callable[[float, str], None] | None, begin: int, parts: int
) -> None:
    """Let the flights of the records report to `progress`, as one of several parts of the work."""
    if progress is None:
        return
    for i, step in enumerate(steps):
        step.report = partial(part_of, progress, begin + i / len(steps), 1 / len(steps), parts)


def part_of(
    progress: Callable[[float, str], None], begin: float, size: float, parts: int, share: float, note: str
) -> None:  # fmt: skip
    """Report the progress of a part of the work."""
    progress((begin + size * share) / parts, note)


def ensure_possible(steps: Sequence[Step]) -> None:
    """Raises an error if the misfit of exact motions would be too large even if these left no more residuals than
    the flights alone, which have more parameters."""
    for step in steps:
        free = step.free
        if free is not None and free.square > DOUBTFUL * free.data.places.size:
            raise SingularError(f"misfit of {free.misfit:.3g} of the flights alone")


def hopeless(step: Step) -> bool:
    """Whether no periodic flights were found that describe a record even roughly."""
    known = [
        found[1].misfit
        for found in step.known_flights.values() if not isinstance(found, SingularError)
    ]  # fmt: skip
    return bool(known) and min(known) > HOPELESS


def on_other_walls(
    step: Step, scale: Mapping[str, float], constant: dict[str, float], guess: Mapping[str, float], law: Law
) -> Fit:  # fmt: skip
    """The fit to a record in which some impacts are on the wall opposite to the one that the sign of an unclear
    jump suggests."""
    data, best = step.data, None
    assert data is not None
    clear_by = abs(data.jumps) / data.jump_errors
    weak = [int(i) for i in np.argsort(clear_by)[:MOST_UNCLEAR] if clear_by[i] < UNCLEAR]
    for turned in (some for n in range(len(weak)) for some in combinations(weak, n + 1)):
        signs = np.sign(data.jumps)
        signs[list(turned)] *= -1
        if abs(signs.sum()) == signs.size:
            continue
        other = ordered(data, signs)
        found = from_phases(step, other, scale, constant, guess, law, False)
        if found and (best is None or max(found.misfits) < max(best.misfits)):
            best, step.data = found, other
    if best is None or max(best.misfits) > DOUBTFUL:
        raise SingularError("no exact motion with impacts on other walls")
    return best


def several(step: Step) -> bool:
    """Whether more impacts are picked in a record than noise could produce."""
    return step.record is not None and (
        step.times.size >= LEAST_PICKS * cycles_of(step.record, step.Omega)
    )


def again(step: Step) -> bool:
    """Whether the impacts of single flights repeat, within the tolerance for a period."""
    assert step.record is not None
    turn = step.Omega / (2 * math.pi)
    own = step.resolved
    cycles = step.times[own] * turn
    # those that are not resolved are missing
    span = step.record.duration * turn * float(np.mean(own)) if own.size else 0.0
    return bool(repeated(cycles, step.signs[own], span))


def clear(found: Fit | None) -> bool:
    """Whether single flights determine all parameters."""
    return found is not None and max(found.misfits) < DOUBTFUL and not found.undetermined


def because(
    single: tuple[list[Step], Fit | None, Law], why: str
) -> tuple[list[Step], Fit | None, Law]:
    """The fit to single flights of a record that seemed to be periodic, with a note on why it is not."""
    for step in single[0]:
        step.notes.insert(
            0,
            f"nearly repeats after {step.rhythm.cycles or 1} load cycles, but no periodic motion fits: {why}",
        )
        if again(step):
            step.notes.append(
                f"{APART[2]}, so the motion is probably periodic, but no motion with them was found"
            )
        step.rhythm = no_rhythm("not periodic")
    return single


def far_off(steps: Sequence[Step], found: Fit) -> bool:
    """Whether an impact of a fitted motion is far from its time in the flights alone."""
    return any(
        step.data is not None and bool((distances(step.data, motion) > FAR).any())
        for step, motion in zip(steps, found.motions, strict=True)
    )


def distances(data: Measured, motion: Impacting) -> _Array:
    """Distances between impacts of a fitted motion and of the flights alone, in standard errors of the latter."""
    away: _Array = np.abs(motion.angles - data.angles) / data.angle_errors
    return away


def apart(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float], law: Law,
    law_speed: float | None,
) -> tuple[list[Step], Fit | None, Law]:  # fmt: skip
    """The parameters from the single flights of a record that is not periodic, if they determine them."""
    steps = [not_periodic(step) for step in steps]
    step = steps[0]
    if len(steps) > 1 or step.apart is None:
        return steps, None, law
    try:
        flights = flown_apart(step, scale, shared, guess)
        assert step.windows is not None
    except (SingularError, np.linalg.LinAlgError) as error:
        step.notes.append(f"flights between impacts give no parameters: {error}")
        return steps, None, law
    try:
        found, law, lawful = by_laws(step.windows, flights, shared, guess, law, law_speed)
    except (SingularError, np.linalg.LinAlgError) as error:
        step.notes.append(f"{APART[1]}: {error}")
        step.notes += filter(None, [unfound_ringing(flights.early)])
        # next to rests, in which the masses move together, short flights may be missing
        if flights.resolved.sum() < max(LEAST_IMPACTS, 0.5 * flights.times.size):
            return steps, None, law
        alone = by_flights(step.windows, flights, shared, law)
        if not isinstance(error, TooFewError):
            alone.against = str(error).removesuffix(HINT).rstrip("; ")
        return steps, alone, law
    step.notes.append(lawful_of(lawful))
    return steps, found, law


def lawful_of(lawful: NDArray[np.bool_], others: str = "is too short or hides an impact") -> str:
    """The note about the impacts that give the parameters, and about the flights next to the `others`."""
    return (
        f"{APART[0]} {int(lawful.sum())} of {lawful.size} impacts give the parameters; the others are next to a "
        f"flight that {others}"
    )


def not_periodic(step: Step) -> Step:
    """A step whose record does not count as periodic."""
    other = copy(step)
    other.data, other.notes = None, [*step.notes]
    return other


def with_other_loads(
    steps: list[Step], scale: Mapping[str, float], shared: dict[str, float], guess: dict[str, float]
) -> None:
    """Raises an error if records that could not be fitted could be fitted with a load of another sign or size."""
    for turned in (True, False):
        others = [copy(step) for step in steps]
        try:
            for step in others:
                if step.data is None or step.data.phase is None or step.data.F0 is None:
                    return
                if turned:
                    step.data = replace(step.data, phase=step.data.phase + math.pi)
                else:
                    step.data = replace(step.data, F0=None)
                step.known_flights = {}
                flown(step, scale, shared, guess, quick=True)
            if any(step.data is None for step in others):
                continue  # no impacts
            ensure_possible(others)
            found = fitted(others, scale, shared, guess, Law(), None)[0]
        except SingularError:
            continue
        if max(found.misfits) > DOUBTFUL:
            continue
        if turned:
            raise ParameterError(
                "load and motion: must have the same positive direction; the motion responds as if the sign "
                f"of the load were reversed: {HINT}"
            )
        stiffness = scale.get("K", scale.get("M", math.nan) * found.values["omega"] ** 2)
        units_agree(steps[0], stiffness * found.lengths[0])


def units_agree(step: Step, force: float) -> None:
    """Raises an error if the load of its channel differs much from the load implied by the motion."""
    assert step.data is not None
    assert step.data.F0 is not None
    ratio = step.data.F0 / force
    if 1 / LARGEST_RATIO < ratio < LARGEST_RATIO:
        return
    raise ParameterError(
        f"load of {step.data.F0:.4g} N and {step.quantity}, which implies {force:.4g} N: must agree; the units of "
        f"a channel, or the known mass or stiffness, are wrong by a factor of {max(ratio, 1 / ratio):.4g}"
        + unit_hint(ratio)
    )


def start_of_law(
    single: Sequence[Fit], found: Sequence[Measured], law: Law, known: Mapping[str, float],
    speed: float | None,
) -> tuple[Law, dict[str, float]]:  # fmt: skip
    """The law at the speeds of the impacts, and its initial parameters from a power law through their
    coefficients."""
    v = np.concatenate([one.motions[0].speeds for one in single])
    left = np.concatenate([data.pattern.signs for data in found]) < 0
    law = law.about([v[~left], v[left]], speed)
    # log R = level - exponent log(v/v0); impacts of nearly equal speeds do not determine the exponent
    x = np.log(v / law.v0)
    one_exponent = law.kind == law.shape
    columns = [~left, left, *([-x] if one_exponent else [-x * ~left, -x * left])]
    errors = np.concatenate([errors_of(one) for one in single])[:, None]
    matrix = np.vstack([np.column_stack(columns) / errors, np.eye(len(columns))[2:]])
    R = np.clip(np.concatenate([one.motions[0].restitution for one in single]), 0.05, 1.0)
    target = np.concatenate([np.log(R) / errors[:, 0], np.zeros(len(columns) - 2)])
    levels, powers = np.split(np.linalg.lstsq(matrix, target, rcond=None)[0], [2])
    powers = np.clip(powers, -0.5, 0.5)
    ends = ("",) if one_exponent else ("1", "2")
    values = {f"exponent{end}": float(p) for end, p in zip(ends, powers, strict=True)}
    values |= {f"R{j + 1}": float(min(math.exp(level), 0.99)) for j, level in enumerate(levels)}
    return law, law.start(values) | {name: known[name] for name in law.names if name in known}


def errors_of(one: Fit) -> _Array:
    """Standard errors of the logarithms of the coefficients of the impacts of a record, at least 0.02."""
    places = [one.names.index(name) for name in Law("impacts", one.motions[0].angles.size).names]
    errors = np.sqrt(np.diag(one.covariance)[places]) / one.motions[0].restitution
    vague = [one.names[place] in one.undetermined for place in places]
    size: _Array = np.where(vague, 1e3, np.hypot(errors, 0.02))
    return size
