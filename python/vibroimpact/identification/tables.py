"""The tables of an identification."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import VibroimpactError
from ..motions.motion import Motion
from ..results.tables import Result, made
from ..systems.oscillator import Pattern
from .fit import DOUBTFUL, EXPONENTS, TYPICAL_EXPONENT, TYPICAL_FRICTION, Fit
from .flights import LEAST_GAIN, unexplained
from .friction import slid
from .known import KNOWN, Doubted, unit_hint
from .laws import Law
from .measured import SensorRecord
from .motions import CONTACT, oscillator_of, verified
from .signals import centred, settling
from .stages import FAR, distances
from .steps import LOAD_TONES, SETTLES, Step
from .strains import Strain
from .waves import Ages, Measured, predicted, rung
from .windows import unfound_ringing

_Array = NDArray[np.float64]
#: What records that are not periodic determine and leave open.
LEFT_OPEN = {
    "no impacts": ", so that the record does not depend on mu, R1, R2 and d",
    "not periodic": "; the record determines only their times and walls, and the load",
    "accumulation": " at decreasing intervals; the last ones may be missing; the record determines only times, "
    "walls and the load",
    "rest": " at decreasing intervals, before the free mass rests on a wall; the last ones may be missing; the "
    "record determines only times, walls and the load",
}
#: The assumptions of the errors about a law.
ASSUMED = {
    "power": "R is a power of the speed, without a knee at the speeds of the impacts; R1 and R2 apply at v0",
    "knee": "R is a PowerLaw of sharpness 2; R1 and R2 apply at v0",
    "table": "R is linear between the knots",
}
#: Difference between a known value and the value that the records imply, in standard errors, above which the fit
#: is doubtful.
STRAINED = 4.0
#: The same limit where fitting the value would change a fitted parameter by more than `MOVED` standard errors.
LEANING, MOVED = 3.0, 2.0
#: Share of a variance due to R that may depend on the speed above which a note states this.
WIDENED = 0.75
#: Standard errors of a drift of coefficients of restitution from zero, above which the fit is doubtful.
DRIFTING = 4.5
#: Share by which a load may grow during a record without a doubt.
STEADY = 2e-3
#: What may change during a record, with the verb of its sentence.
DRIFTS = {
    "drift": "R1 and R2 seem", "drift1": "R1 seems", "drift2": "R2 seems", "omega": "omega seems",
    "xi": "xi seems", "static": "the load, or the gain of the motion sensor, seems",
    "phase": "the load, or the clock of its channel, seems",
}  # fmt: skip
#: Part of a standard error by which parameters are moved for the error of a multiplier.
TRIAL = 0.3
#: Largest multiplier of a fitted motion that a record can show; noise may raise it slightly above 1, and near a
#: period doubling or a Neimark-Sacker bifurcation by this number of its standard errors.
UNSTABLE, UNSURE = 1.05, 2.0
#: The most by which the error of a multiplier may raise it above 1: far from the unit circle the error is
#: meaningless, since it is valid for small deviations only.
MOST_UNSURE = 0.5
#: Difference (radians) between the impacts of two halves of a period that are the same; where they differ, the
#: largest multiplier differs from 1 by about the square of this difference.
SAME = 1e-6
#: Half the width of a 95 % interval in standard errors.
WIDTH = 1.959963984540054
#: Samples and load cycles of each record that a result keeps for its picture.
SHOWN_SAMPLES, SHOWN_CYCLES = 3000, 6


def tables_of(
    steps: list[Step],
    found: Fit | None,
    scale: Mapping[str, float],
    shared: Mapping[str, float],
    law: Law,
    case: str,
    doubted: Mapping[str, tuple[Doubted, Mapping[str, float]]] | None = None,
) -> Result:
    """All columns of a result; `doubted` are the known values that have a standard error, and the changes of all
    values over it."""
    parameters = parameters_of(steps, found, scale, shared, law)
    if doubted:
        found = widened(parameters, steps, found, scale, doubted)
    names = (
        "status", "quantity", "sides", "cycles", "frequency", "load", "load_phase", "r", "clearance",
        "static", "first", "misfit", "multipliers", "harmonics",
    )  # fmt: skip
    records: dict[str, list[Any]] = {name: [] for name in names}
    impacts: dict[str, list[Any]] = {
        name: []
        for name in ("number", "side", "picked", "picked_error", "fitted", "speed", "restitution")
    }
    picks: dict[str, list[Any]] = {name: [] for name in ("number", "time", "side")}
    samples: dict[str, list[Any]] = {
        name: [] for name in ("number", "time", "load", "load_fit", "motion", "motion_fit")
    }
    notes: list[tuple[bool, str]] = []
    for i, step in enumerate(steps):
        data, record = step.data, step.record
        multipliers = np.full(4, complex(math.nan, math.nan))
        harmonics = np.zeros(LOAD_TONES - 1, dtype=np.complex128)
        pattern = data.pattern if data is not None and found is not None else None
        middle = 0.0 if record is None else (len(record) - 1) / 2 / record.rate
        begin = 0.0 if record is None else record.start
        load = data.F0 if data is not None else step.F0
        load = math.nan if load is None else load
        phase = found.phases[i] if found is not None else math.nan
        if found is None and step.load is not None:
            phase = float(np.angle(1j * step.load.values[1]))
        # the phase is that in the channel, including its delay; times of impacts are without this delay
        late, forced = 0.0, step.apart is not None and step.apart.forced is not None
        if record is not None:
            late = record.lag(step.quantity if found is not None else "load")
        fit_of: dict[str, Any] = {
            "status": step.rhythm.status, "quantity": step.quantity,
            "sides": pattern.sides if pattern else "", "cycles": pattern.cycles if pattern else 0,
            "frequency": step.Omega / (2 * math.pi), "load": load,
            "load_phase": math.nan if forced else (phase + step.Omega * (late - middle)) % (2 * math.pi),
            "r": math.nan, "clearance": math.nan,
            "static": found.lengths[i] if found is not None else math.nan,
            "misfit": found.misfits[i] if found is not None else math.nan,
        }  # fmt: skip
        first, away, unsure = math.nan, np.zeros(1), 0.0
        if found is not None and step.windows is not None:
            fit_of |= {
                "r": step.Omega / found.values["omega"], "clearance": found.values["d"] / found.lengths[i],
            }  # fmt: skip
        if found is not None and data is not None and pattern is not None:
            motion, static = found.motions[i], found.lengths[i]
            r, clearance = step.Omega / found.values["omega"], found.values["d"] / static
            fit_of |= {"r": r, "clearance": clearance}
            for order, tone in zip(data.orders[1:].tolist(), data.shape[1:], strict=True):
                harmonics[int(order) - 2] = tone
            fitted_angles = motion.angles + phase
            exact = exact_of(step, found, i, law, harmonics)
            if exact.multipliers is not None:
                multipliers = exact.multipliers
                if abs(multipliers).max() > UNSTABLE and remains(
                    exact, pattern, partial(exact_of, step, found, i, law, harmonics, 2)
                ):
                    given = step, found, i, law, harmonics
                    unsure = math.hypot(multiplier_error(*given), multiplier_of_speed(*given))
            first = motion.angles[0] / step.Omega + middle + begin
            away = distances(data, motion)
            impacts["number"] += [i + 1] * motion.angles.size
            impacts["side"] += pattern.symbols
            for name, of_impacts in {
                "picked": data.angles + phase, "picked_error": data.angle_errors, "fitted": fitted_angles,
                "speed": motion.speeds, "restitution": motion.restitution,
            }.items():  # fmt: skip
                impacts[name] += of_impacts.tolist()
        for name, value in {
            **fit_of,
            "multipliers": multipliers,
            "first": first,
            "harmonics": harmonics,
        }.items():
            records[name].append(value)
        picks["number"] += [i + 1] * step.times.size
        picks["time"] += step.times.tolist()
        picks["side"] += ["R" if sign > 0 else "L" for sign in step.signs]
        if record is not None:
            add_samples(samples, i, step, record, found)
        said_of = f"record {i + 1}: " if len(steps) > 1 else ""
        if found is not None:
            notes += [
                (False, f"{said_of}doubtful: {text}")
                for text in doubts_of(i, step, found, away, scale, multipliers, unsure)
            ]
        notes += [(False, f"{said_of}{text}") for text in step.notes]
        if found is not None and growth_of_load(step) and borne(step):
            text = f"{growth_of_load(step)}, within the calibration error"
            notes.append((False, f"{said_of}{text}"))
        if pattern is not None:
            notes.append(
                (
                    False,
                    f"{said_of}{pattern.sides}/{pattern.cycles} at "
                    f"{place_in_hertz(records['r'][i], records['frequency'][i])}",
                )
            )
        else:
            notes.append(
                (
                    True,
                    f"{said_of}{step.rhythm.status}: {step.times.size} impacts "
                    + (
                        f"detected{LEFT_OPEN.get(step.rhythm.status, '')}; no motion is fitted"
                        if found is None
                        else f"at {place_in_hertz(records['r'][i], records['frequency'][i])}; "
                        "flights between them give the parameters, without a "
                        "motion"
                    ),
                )
            )
    if found is not None and found.undetermined:
        names_of = ", ".join(found.undetermined)
        more = "m, d" if "M" in scale else "M, d"
        notes.append(
            (
                False,
                f"undetermined: {names_of}; to determine them, give one of them as known ({more}), or add a "
                "record at another frequency or one that is not periodic",
            )
        )
    if found is not None and law.shape in ASSUMED:
        notes.append((False, f"v0 = {law.v0:.6g} m/s; all errors assume that {ASSUMED[law.shape]}"))
    if found is not None:
        if found.lasting:
            contacts = f"contacts of {found.contact * 1e3:.2g} ms are part of the fit"
            what = (
                "travel at the usual speed of the impacts"
                if found.motions
                else "distance between the walls"
            )
            notes.append((False, f"{contacts}; d is the {what}"))
        wide = [
            name for name in ("xi", "mu", "R1", "R2", "d")
            if found.of_speed.get(name, 0.0) > WIDENED and name not in found.undetermined
        ]  # fmt: skip
        if wide:
            notes.append((
                False,
                f"R may depend on the speed, about as v^-{TYPICAL_EXPONENT:g}, which more than doubles the errors "
                f"of {', '.join(wide)}; records at other load frequencies would show whether it does",
            ))  # fmt: skip
        if any("doubtful: " in text for _, text in notes):
            notes.append((False, "poor fit: the errors below are not valid"))
        notes += [(False, text) for text in unstated(found, steps[0].Omega)]
        columns = (parameters[key] for key in ("name", "value", "error", "unit", "state"))
        notes += [
            (False, said(name, value, error, unit))
            for name, value, error, unit, state in zip(*columns, strict=True)
            if state != "known" and math.isfinite(value)
        ]
    tables = {
        "parameters": (("parameter",), parameters),
        "records": (("recording",), records),
        "impacts": (("impact",), impacts),
        "picks": (("pick",), picks),
        "samples": (("sample",), samples),
    }
    return made("identify", case, tables, notes=notes)


def exact_of(step: Step, found: Fit, i: int, law: Law, harmonics: Any, parts: int = 1) -> Motion:
    """The exact motion of a record with the fitted parameters; if its period is divided into equal parts, that
    with the impacts of the first part."""
    assert step.data is not None
    values, static, motion = found.values | law.fixed, found.lengths[i], found.motions[i]
    r, clearance = step.Omega / values["omega"], values["d"] / static
    own, n = step.data.pattern, motion.angles.size // parts
    osc, pattern = oscillator_of(values), Pattern(own.sides[:n], own.cycles // parts)
    angles = motion.angles[:n] + found.phases[i]
    if law.friction:
        speeds = motion.speeds[:n] / (values["omega"] * static)
        return slid(osc, r, clearance, angles, pattern, values["friction"], speeds, harmonics)
    walls = law.restitution(values, values["omega"] * static)
    return verified(osc, r, clearance, angles, pattern, walls, harmonics)


def remains(exact: Motion, pattern: Pattern, half: Callable[[], Motion]) -> bool:
    """Whether a motion that becomes unstable still exists nearby, so that its parameters change smoothly: at a
    Neimark-Sacker bifurcation and at a period doubling.

    A motion followed for two periods has the square of the negative multiplier of a period doubling: both halves
    of its impacts are then the same, and `half`, which computes the motion of one period, has a negative
    multiplier. Any other positive multiplier above 1 is that of a fold, beyond which there is no motion, of a
    pitchfork, or of an unstable branch: another motion would fit.
    """
    worst = largest(exact)
    if worst.real < 0 or worst.imag != 0:
        return True
    sides, cycles, n = pattern.sides, pattern.cycles, len(pattern) // 2
    if cycles % 2 or sides[:n] != sides[n:] or exact.phases.size != 2 * n:
        return False
    if abs(exact.phases[n:] - exact.phases[:n] - math.pi * cycles).max() > SAME:
        return False
    try:
        return largest(half()).real < 0
    except VibroimpactError:
        return False


def largest(motion: Motion) -> complex:
    """The multiplier of largest modulus."""
    return complex(motion.multipliers[np.argmax(abs(motion.multipliers))])


def multiplier_error(step: Step, found: Fit, i: int, law: Law, harmonics: Any) -> float:
    """The standard error of the largest multiplier of a fitted motion, from motions with parameters that are moved
    along the axes of their covariance; 0 if one of these does not exist or has no multipliers."""
    size, axes = np.linalg.eigh(found.covariance)
    total = 0.0
    for axis in (axes * np.sqrt(np.maximum(size, 0.0))).T:
        ends = []
        for part in (TRIAL, -TRIAL):
            moved = dict(zip(found.names, (part * axis).tolist(), strict=True))
            values = {name: value + moved.get(name, 0.0) for name, value in found.values.items()}
            lengths = [one + moved.get(f"F0/K {j}", 0.0) for j, one in enumerate(found.lengths)]
            try:
                other = exact_of(
                    step, replace(found, values=values, lengths=lengths), i, law, harmonics
                )
            except VibroimpactError:
                return 0.0
            if np.isnan(other.multipliers).any():
                return 0.0
            ends.append(float(abs(other.multipliers).max()))
        total += ((ends[0] - ends[1]) / (2 * TRIAL)) ** 2
    return math.sqrt(total)


def multiplier_of_speed(step: Step, found: Fit, i: int, law: Law, harmonics: Any) -> float:
    """The change of the largest multiplier of a fitted motion if R falls with the speed, as the errors of constant
    coefficients assume, which hardly changes the motion but makes it more stable; 0 if there is no such motion."""
    if law.kind != "constant" or law.friction or step.data is None:
        return 0.0
    p, speeds, signs = TYPICAL_EXPONENT, found.motions[i].speeds, step.data.pattern.signs
    walls = {f"exponent{wall}": p for wall in "12"} | {
        name: found.values[name] * float(speeds[signs == sign].mean()) ** p
        for name, sign in (("R1", 1), ("R2", -1))
    }
    other = replace(found, values=found.values | walls)
    try:
        both = (
            exact_of(step, found, i, law, harmonics),
            exact_of(step, other, i, Law("powers", v0=1.0), harmonics),
        )
    except VibroimpactError:
        return 0.0
    change = float(np.diff([abs(largest(one)) for one in both])[0])
    return abs(change) if math.isfinite(change) else 0.0


def doubts_of(
    i: int, step: Step, found: Fit, away: _Array, scale: Mapping[str, float], multipliers: Any, unsure: float = 0.0
) -> list[str]:  # fmt: skip
    """The doubts about the fit of a record, the likeliest causes first; `away` are the distances of its impacts
    from those of the flights alone, in standard errors, `multipliers` those of its motion, and `unsure` is the
    error of the largest one."""
    data, texts = step.data, []
    strained = {
        name: strain for name, strain in found.strains.items()
        if name not in CONTACT and is_strained(found, name) and name.split()[-1] in (name, str(i))
    }  # fmt: skip
    for name, strain in sorted(strained.items(), key=lambda item: -abs(item[1].size)):
        apart = f"{abs(strain.size):.2g} standard errors apart"
        kind = name.split()[0]
        if kind == "phase":
            late = strain.change / step.Omega
            texts.append(
                f"the motion corresponds to a load {abs(late) * 1e3:.3g} ms "
                f"{'earlier' if late > 0 else 'later'} than its channel indicates "
                f"({apart}): a filter or delay of one channel (bandwidth, delay) may be "
                "missing or wrong, or the channels have different clocks"
            )
        elif kind == "friction" and name not in found.values:
            # the force of friction cannot drive the free mass
            if strain.change > 0:
                texts.append(
                    f"friction in the slot of about {strain.change:.2g} F0, which is not part of the fit, would "
                    f"describe the record better ({abs(strain.size):.2g} standard errors from zero)"
                )
        elif kind in EXPONENTS:
            # restitution that grows with the speed is an explanation only where there is no other
            if strain.change > 0 or strained.keys() <= set(EXPONENTS):
                wall = "right" if kind == EXPONENTS[0] else "left"
                texts.append(
                    f"restitution that depends on the speed, on the {wall} wall about as v^{-strain.change:.2g}, "
                    f"would describe the record better ({abs(strain.size):.2g} standard errors from constant): "
                    "try law = 'power'"
                )
        elif kind == "F0":
            load = (data or step.apart or Measured(step.Omega, 1)).F0
            assert load is not None
            other = load + strain.change
            hint = unit_hint(other / load) if other > 0 else ""
            texts.append(
                f"the motion corresponds to a load of {other:.4g} N, not {load:.4g} N ({apart}): the known mass M "
                f"or stiffness K, or the units or calibration of a channel, may be wrong{hint}"
            )
        else:
            value, given = found.values[name], name
            if name == "omega" and len({"M", "K"} & scale.keys()) == 2:
                given = "omega = sqrt(K/M)"
            elif name == "mu" and "M" in scale:
                given = "mu = m/M"
            texts.append(
                f"known {given} = {value:.6g}: the record gives {value + strain.change:.4g} ({apart}); it may be "
                f"wrong, or {'' if name in ('omega', 'xi') else 'the law of restitution, or '}an effect "
                "that resembles it"
            )
    texts += drifts_of(step, found)
    lasting = max(
        (abs(found.strains[name].size) for name in CONTACT if name in found.strains), default=0.0
    )
    if min(lasting, found.unallowed) > STRAINED and not texts:
        pulses = f"the pulses allow {found.contact * 1e3:.2g} ms, and " if found.contact else ""
        texts.append(
            f"contacts of finite duration would describe the record better ({lasting:.2g} standard errors from "
            f"zero): {pulses}the parameters are those of impacts of no duration"
        )
    texts += filter(None, [unfound_ringing(found.early)])
    if found.against:
        texts.append(
            f"impacts give no parameters: {found.against}; the rig may have changed during the record, or impacts "
            "are hidden in it, which may also affect damping and load from the flights alone"
        )
    largest = float(np.nanmax(np.append(abs(np.asarray(multipliers)), 0.0)))
    # undetermined parameters may also be those of an unstable motion
    if largest > max(UNSTABLE, 1 + min(UNSURE * unsure, MOST_UNSURE)) and not found.undetermined:
        texts.append(
            f"the motion is unstable (its largest multiplier is {largest:.3g}), and a real rig would leave it: "
            "the parameters are too uncertain for the stated errors, which are valid for small deviations only; a "
            "known free mass m, less noise or a longer record would help"
        )
    at_bounds = {"xi": (0.0,), "R1": (0.0, 1.0), "R2": (0.0, 1.0)}
    texts += [
        f"{name} = {found.values[name]:g}: the fit would go beyond this bound; a known value may be wrong, a "
        "filter or delay missing, or the clocks of the channels differ"
        for name, ends in at_bounds.items()
        if name in found.names and name not in found.undetermined and found.values[name] in ends
    ]
    if found.misfits[i] > found.most:
        cause = "the pattern or a known value may be wrong, or the rig changed during the record"
        if data is not None and step.record is not None:
            falls = settling(step.motion, step.record.rate, step.Omega, data.k)
            if falls > SETTLES:
                cause = (
                    "the motion had probably not settled: the variance of the difference between its periods "
                    f"falls by a factor of {falls:.3g} during the record, as near a period doubling, where this "
                    "takes many load cycles; identify its last part, or a record that begins later"
                )
        texts.append(
            f"misfit of {found.misfits[i]:.3g}: the motion does not describe the record to within its scatter; "
            f"{cause}; the errors are multiplied by the square root of the misfit"
        )
    if step.free is not None and step.free.misfit > DOUBTFUL:
        texts.append(
            f"misfit of {step.free.misfit:.3g} of flights alone, independent of the impacts: possibly a second "
            "mode of the rig, an unknown filter, or harmonics of the load that its channel does not show"
        )
    elif step.free is not None and data is not None and found.squares:
        more = (found.squares[i] - step.free.square) / found.spread
        if more > LEAST_GAIN:
            texts.append(
                f"flights alone describe the record, but the motion adds {more:.3g} to their sum of squares of "
                f"{step.free.square:.4g}: a known free mass, clearance or coefficient of restitution, or the law, "
                "may be wrong, or an impact is missing"
            )
    if data is not None and step.record is not None:
        place_of = unexplained(step.news(data.k), data.Omega, data.k, data.angles)
        if place_of is not None:
            late = (place_of - data.angles[0]) % (2 * math.pi * data.k) / data.Omega
            texts.append(
                f"{late * 1e3:.3g} ms after impact 1 of the motion ({data.pattern.symbols[0]}) the record changes "
                "as abruptly as at an impact, but the motion has no impact there: the pattern may lack an impact"
            )
    if data is not None and away.max() > FAR:
        place = int(away.argmax())
        texts.append(
            f"impact {place + 1} of the motion ({data.pattern.symbols[place]}) is {away[place]:.2g} standard "
            "errors from its time in the flights alone; with a weak impact there, another motion may fit as "
            "well, and the stated errors may be too small"
        )
    return texts


def growth_of_load(step: Step) -> str:
    """By how much the load grows during a record; empty if it does not."""
    size, share = abs(step.growth_size), abs(step.growth)
    if size < DRIFTING or share < STEADY:
        return ""
    return (
        f"the load {'grows' if step.growth > 0 else 'falls'} by {100 * share:.2g} % during the record "
        f"({size:.2g} standard errors from zero)"
    )


def borne(step: Step) -> bool:
    """Whether a periodic motion stays the same while the load in its channel grows by less than the uncertainty of
    the calibration."""
    if step.data is None or step.rhythm.status != "periodic" or step.restless:
        return False
    return abs(step.growth) < math.sqrt(12) * step.data.calibration


def drifts_of(step: Step, found: Fit) -> list[str]:
    """The quantities that seem to change during a record, the clearest change first."""
    texts: list[tuple[float, str]] = []
    grown = growth_of_load(step)
    if grown and not borne(step):
        texts.append((abs(step.growth_size), f"{grown}, but is assumed to be constant"))
    # a change of one wall looks like half that change of both
    walls = [name for name in found.drifts if name.startswith("drift")]
    worst = [max(walls, key=lambda name: abs(found.drifts[name].size))] if walls else []
    for name in [*worst, *(name for name in found.drifts if name not in walls)]:
        size, change = found.drifts[name]
        if abs(size) <= DRIFTING:
            continue
        if name == "phase":
            way = "earlier" if change > 0 else "later"
            by = f"become {way} by {abs(change) / step.Omega * 1e3:.2g} ms"
        else:
            level = {"static": found.lengths[0]}.get(name, found.values.get(name, 1.0))
            share = f"{100 * abs(change) / level:.2g} %" if level else f"{abs(change):.2g}"
            by = f"{'grow' if change > 0 else 'fall'} by {share}"
        texts.append((
            abs(size),
            f"{DRIFTS[name]} to {by} during the record ({abs(size):.2g} standard errors from zero), which the "
            "errors do not contain: identify parts of the record separately",
        ))  # fmt: skip
    return [text for _, text in sorted(texts, reverse=True)]


def is_strained(found: Fit, name: str) -> bool:
    """Whether the records contradict a value that was not fitted: clearly, or enough to make the errors wrong."""
    size, change = found.strains[name]
    if abs(size) > STRAINED or abs(size) <= LEANING:
        return abs(size) > STRAINED
    # without what contacts may change, which would hide friction
    errors = dict(zip(found.names, np.sqrt(np.diag(found.covariance)).tolist(), strict=True))
    return any(
        abs(found.leans.get(name, {}).get(own, 0.0) * change) > MOVED * errors[own]
        for own in ("xi", "mu", "R1", "R2", "d")
        if own in errors and own not in found.undetermined
    )


def unstated(found: Fit, Omega: float) -> list[str]:
    """The effects of errors of known values, which the stated errors do not contain."""
    errors = found.errors
    texts = []
    for name, by in found.leans.items():
        kind = name.split()[0]
        if kind == "F0":
            continue  # its error is part of all errors
        if kind == "phase":
            step, what = 1e-4 * Omega, "the load were 0.1 ms earlier in its channel"
        elif name == "friction" and name not in found.values:
            step = unexcluded(found)
            what = f"there were friction of {step:.2g} F0 in the slot, which the record does not exclude"
            if step >= TYPICAL_FRICTION:
                what += " (the effect grows in proportion to the friction)"
        elif kind == "omega":
            step, what = 0.005 * found.values[name], "K/M (or omega^2) as known were 1 % larger"
        else:
            step, what = 0.01 * found.values[name], f"{name} as known were 1 % larger"
        changes = [
            f"{own} would be {amount(abs(change), own)} {'larger' if change > 0 else 'smaller'}"
            for own in ("xi", "mu", "R1", "R2", "d")
            if own in errors and own not in found.undetermined
            for change in [by[own] * step] if abs(change) > 2 * errors[own]
        ]  # fmt: skip
        if changes:
            texts.append(f"not in the errors: if {what}, {', '.join(changes)}")
    # independent of the effect on R, d is not the distance between the walls
    error = errors.get("d", math.inf) * math.sqrt(1 - min(found.of_speed.get("d", 0.0), 1.0))
    if found.closer > 2 * error and "d" not in found.undetermined:
        texts.append(
            f"not in the errors: d is the travel between the centres of the impacts; if contacts last as long as "
            f"their pulses, {found.contact * 1e3:.2g} ms, the walls are {amount(found.closer, 'd')} closer"
        )
    return texts


def unexcluded(found: Fit) -> float:
    """Friction over F0 that is plausible and that the records do not exclude."""
    if "friction" not in found.strains:
        return TYPICAL_FRICTION
    size, change = found.strains["friction"]
    error = change / size if size else math.inf
    return min(TYPICAL_FRICTION, max(change, 0.0) + WIDTH * error)


def add_samples(
    samples: dict[str, list[Any]], i: int, step: Step, record: SensorRecord, found: Fit | None
) -> None:
    """Samples of the first load cycles of a record, with the fitted values."""
    cycles = SHOWN_CYCLES * max(1, step.rhythm.cycles)
    n = min(len(record), int(cycles * 2 * math.pi / step.Omega * record.rate), SHOWN_SAMPLES * 4)
    here = slice(0, n, max(1, n // SHOWN_SAMPLES))
    t = centred(len(record), record.rate)[here]
    none = np.full(t.size, math.nan)
    load = record.load[here] if record.load is not None else none
    load_fit = step.load.at(t) if step.load is not None else none
    if step.apart is not None and step.apart.forced is not None:
        load_fit = step.apart.forced.F0 * step.apart.forced.load[here]
    values = getattr(record, step.quantity)[here]
    motion_fit = none
    if found is not None and step.data is not None and step.free is not None:
        motion_fit = modelled(step.data, i, step, found, step.Omega * t)
    elif found is not None and step.windows is not None:
        motion_fit = step.windows.at(t)
    samples["number"] += [i + 1] * t.size
    samples["time"] += record.times[here].tolist()
    for name, column_values in (
        ("load", load),
        ("load_fit", load_fit),
        ("motion", values),
        ("motion_fit", motion_fit),
    ):
        samples[name] += column_values.tolist()


def modelled(data: Measured, i: int, step: Step, found: Fit, angles: Any) -> Any:
    """The fitted motion with the ringing and the offset of the free flights; within pulses, the folded record."""
    free, fold, motion = step.free, step.fold, found.motions[i]
    assert free is not None
    assert fold is not None

    def at(angles: Any) -> Any:
        value = predicted(
            data, angles, data.order, found.values["omega"], found.values["xi"], found.lengths[i],
            found.phases[i], motion.angles, motion.jumps,
        ).value  # fmt: skip
        value = free.offset + found.gain * (
            value if motion.at is None else value + motion.at(angles)
        )
        ages = Ages(data, angles, free.data.angles)
        return value + sum(rung(data, ages, mode)[0] for mode in free.modes)

    whole = 2 * math.pi * data.k
    pulse = np.where(free.pulse, fold.values - at(fold.angles), 0.0)
    return at(angles) + np.interp(angles % whole, fold.angles, pulse, period=whole)


def parameters_of(
    steps: list[Step], found: Fit | None, scale: Mapping[str, float], shared: Mapping[str, float],
    law: Law,
) -> dict[str, list[Any]]:  # fmt: skip
    """The table of parameters: known, fitted and derived values."""
    rows: list[tuple[str, float, float, str, str]] = []
    units = KNOWN | dict.fromkeys(law.fixed, "m/s") | {"friction": ""}
    units |= {name: KNOWN.get(name, "") for name in law.names}

    def add(name: str, value: float, error: float, state: str) -> None:
        rows.append(
            (name, value, error, units.get(name, "m" if name.startswith("F0/K") else "N"), state)
        )

    errors: dict[str, float] = {}
    states: dict[str, str] = {}
    values: dict[str, float] = dict(shared)
    covariance = np.zeros((0, 0))
    if found is not None:
        covariance = found.stated
        values = {
            **found.values,
            **{name: found.lengths[int(name.split()[1])] for name in found.names if " " in name},
        }
        for name, error in found.errors.items():
            vague = name in found.undetermined
            errors[name] = math.inf if vague else error
            states[name] = "undetermined" if vague else "fitted"
    data = steps[0].data
    F0, F0_error = steps[0].F0, steps[0].F0_error
    if data is not None:
        F0, F0_error = data.F0, data.F0_error
    elif "F0" in scale:
        F0, F0_error = scale["F0"], 0.0
    omega, static = values.get("omega", math.nan), values.get("F0/K 0", math.nan)

    def relative(*powers: tuple[str, float]) -> float:
        """Relative error of a product of powers of fitted parameters."""
        if found is None:
            return math.inf
        if any(states.get(name) == "undetermined" for name, _ in powers):
            return math.inf
        place = [
            (found.names.index(name), power / values[name])
            for name, power in powers
            if name in found.names
        ]
        return math.sqrt(
            max(0.0, sum(a * b * covariance[j, k] for j, a in place for k, b in place))
        )

    if found is not None or scale:
        M, K = scale.get("M"), scale.get("K")
        if M is not None:
            add("M", M, 0.0, "known")
        if K is not None:
            add("K", K, 0.0, "known")
        if M is None and found is not None:
            value, share = math.nan, math.inf
            if K is not None:
                value, share = K / omega**2, relative(("omega", -2.0))
            elif F0 is not None:
                value = F0 / (static * omega**2)
                share = math.hypot(relative(("omega", -2.0), ("F0/K 0", -1.0)), F0_error / F0)
            add(
                "M",
                value,
                value * share if math.isfinite(value) else math.inf,
                "fitted" if math.isfinite(share) else "undetermined",
            )
        if K is None and found is not None:
            value, share = math.nan, math.inf
            if M is not None:
                value, share = M * omega**2, relative(("omega", 2.0))
            elif F0 is not None:
                value, share = F0 / static, math.hypot(relative(("F0/K 0", -1.0)), F0_error / F0)
            add(
                "K",
                value,
                value * share if math.isfinite(value) else math.inf,
                "fitted" if math.isfinite(share) else "undetermined",
            )
    for name, value in law.fixed.items() if found is not None else ():
        add(name, value, 0.0, "known")
    for name in law.shared:
        if name in shared:
            add(name, shared[name], 0.0, "known")
        elif name in values:
            add(name, values[name], errors[name], states[name])
    if found is not None and F0 is None and "K" in scale:
        share = relative(("F0/K 0", 1.0))
        add(
            "F0",
            scale["K"] * static,
            scale["K"] * static * share,
            "fitted" if math.isfinite(share) else "undetermined",
        )
    elif F0 is not None:
        add("F0", F0, 0.0 if "F0" in scale else F0_error, "known" if "F0" in scale else "fitted")
    elif found is not None:
        add("F0", math.nan, math.inf, "undetermined")
    for j in range(len(steps) if found is not None else 0):
        name = f"F0/K {j}"
        given = {"F0", "K"} <= scale.keys()
        error, state = (0.0, "known") if given else (errors[name], states[name])
        add("F0/K" if j == 0 else f"F0/K {j + 1}", values[name], error, state)
    table: dict[str, list[Any]] = {
        key: [row[j] for row in rows]
        for j, key in enumerate(("name", "value", "error", "unit", "state"))
    }
    half = [WIDTH * error for error in table["error"]]
    table["low"] = [value - width for value, width in zip(table["value"], half, strict=True)]
    table["high"] = [value + width for value, width in zip(table["value"], half, strict=True)]
    return table


def widened(
    parameters: dict[str, list[Any]], steps: list[Step], found: Fit | None, scale: Mapping[str, float],
    doubted: Mapping[str, tuple[Doubted, Mapping[str, float]]],
) -> Fit | None:  # fmt: skip
    """Add the errors of known values to those of all parameters that depend on them: `doubted` contains the
    changes of all values when each known value changes by one standard error.

    Returns
    -------
    Fit or None
        The fit without those doubts and remarks that concern differences explained by these errors.
    """
    variances = np.square(parameters["error"])
    of_known: dict[str, float] = {}
    for known, changes in doubted.values():
        change = np.array([changes[name] for name in parameters["name"]])
        # parameters without a value remain undetermined
        variances += np.where(np.isfinite(change), change, 0.0) ** 2
        for name, slope in (known.shared | of_loads(steps, scale, known)).items():
            of_known[name] = math.hypot(of_known.get(name, 0.0), slope * known.error)
    parameters["error"] = np.sqrt(variances).tolist()
    half = WIDTH * np.sqrt(variances)
    parameters["low"] = (np.array(parameters["value"]) - half).tolist()
    parameters["high"] = (np.array(parameters["value"]) + half).tolist()
    if found is None:
        return None
    strains = dict(found.strains)
    for name, error in of_known.items():
        if name not in strains or not error > 0:
            continue
        size, change_of = strains.pop(name)
        size /= math.hypot(1.0, error * size / change_of) if change_of else 1.0
        if abs(size) > STRAINED:
            strains[name] = Strain(size, change_of)
    leans = {name: by for name, by in found.leans.items() if not of_known.get(name, 0.0) > 0}
    return replace(found, strains=strains, leans=leans)


def of_loads(steps: Sequence[Step], scale: Mapping[str, float], known: Doubted) -> dict[str, float]:
    """The changes of the loads ("F0 0" for the first record) that have the same effect on F0/K as a unit change of
    a known value."""
    stiff = "K" if "K" in scale else "M"
    slope = known.scale.get("F0", 0.0) / scale.get("F0", 1.0)
    slope -= known.scale.get(stiff, 0.0) / scale.get(stiff, 1.0)
    loads = [(step.data or step.apart or Measured(step.Omega, 1)).F0 for step in steps]
    return {f"F0 {i}": slope * load for i, load in enumerate(loads) if load is not None and slope}


def said(name: str, value: float, error: float | None, unit: str = "") -> str:
    """A parameter with its error and unit as a text; lengths below a decimetre are in mm.

    Examples
    --------
    >>> from vibroimpact.identification.tables import said
    >>> said("xi", 0.0114312, 0.000213), said("d", 0.005, 2.1e-5, "m")
    ('xi = 0.01143 +- 0.00021', 'd = 5.000 +- 0.021 mm')
    """
    if unit == "m" and abs(value) < 0.1:
        value, error, unit = 1e3 * value, None if error is None else 1e3 * error, "mm"
    unit = f" {unit}" if unit else ""
    if error is None or error == 0:
        return f"{name} = {value:.6g}{unit}"
    if not math.isfinite(error):
        return f"{name} undetermined"
    shown = f"{float(f'{error:.2g}'):g}"  # 210, not 2.1e+02
    digits = max(0, 1 - math.floor(math.log10(error)))
    if digits > 8:
        return f"{name} = {value:.6g} +- {shown}{unit}"
    return f"{name} = {value:.{digits}f} +- {shown}{unit}"


def amount(size: float, name: str) -> str:
    """The size of a change of a parameter, in mm if it is a length."""
    return f"{1e3 * size:.2g} mm" if name == "d" else f"{size:.2g}"


def place_in_hertz(r: float, frequency: float) -> str:
    """The load frequency and its ratio as a text."""
    return f"{frequency:.6g} Hz (r = {r:.6g})"
