"""The steps from one record, or from impact times alone, to the data of the fit."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import islice, tee
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from .flights import (
    HOPELESS,
    MOST_MODES,
    PLACES,
    POOR,
    PULSE,
    Flights,
    Folded,
    FreeFit,
    beside,
    folded,
    news_of,
    onsets,
)
from .forced import Forced, highest_of, mean_frequency, share_beyond
from .known import HINT
from .measured import MOTIONS, ORDER, SensorRecord, butterworth_poles
from .signals import (
    SLOW_PARTS,
    Repetition,
    Rhythm,
    Tones,
    centred,
    changed,
    is_smooth,
    load_frequency,
    most_cycles,
    no_rhythm,
    period_of,
    repeated,
    rhythm,
    settling,
    spikes,
    tones,
    white_noise,
    whole_periods,
)
from .slips import Slips
from .waves import Measured
from .windows import Flown, Windows, picked

_Array = NDArray[np.float64]
#: Least number of load cycles of a record.
LEAST_CYCLES = 8
#: Number of measured harmonics of the load in its own channel, and largest number in the motion channel.
LOAD_TONES, MOTION_TONES = 12, 90
#: Samples, and load cycles, for which a working channel may stay constant.
STUCK, STUCK_CYCLES = 16, 0.05
#: Error of the load phase of a part of a record, relative to its standard error and in samples, that noise does
#: not explain.
UNSTEADY, SHIFT = 8.0, 0.2
#: Time from an impact to its spike, times the bandwidth.
RISE = 0.2
#: Delay (s) that an unknown filter may have, and the relative range of delays of filters with one -3 dB frequency:
#: order 2 has half the delay of order 4, order 8 twice the delay.
UNKNOWN_DELAY, DELAY_OF_OTHERS = 2e-3, 0.5
#: Standard deviation, in sampling intervals, of the offset between channels that a converter reads in turn: from
#: minus half an interval to half of it with two channels, evenly distributed.
IN_TURN = 0.29
#: Variance of the parts of a record, relative to that of noise, above which the load frequency may be inaccurate.
SLIPPED = 1.2
#: Variance of the value in the middle of a quadratic polynomial of time, over that of the mean.
OF_MIDDLE = 2.25
#: Ratio by `settling` above which a motion had not settled when its record began: one that settles near a period
#: doubling has 3 or more, a rig whose R falls by 9 % during the record 1.4.
SETTLES = 2.0
#: Largest share of the misfit of poor flights that others may have.
LESS = 0.5
#: Scatter from period to period, relative to the noise of samples, or its variance at low frequencies, relative to
#: that of white noise, above which a motion may not quite repeat, if it exceeds a share of the motion: the first
#: share leaves a period in doubt, the second one makes individual flights come first. The noise behind an unknown
#: filter exceeds white noise, too.
RESTLESS, COLOURED, SOME, MUCH = 1.4, 3.0, 0.015, 0.03
#: Share of the bandwidth of a sensor to which its gain is constant, and of the sampling rate to which pulses are
#: sampled well.
FLAT, ALIASED = 0.5, 0.2
#: Share of a load, in amplitude, that its harmonics do not describe, or its first one, above which its form is
#: used as recorded; and share above its highest frequency beyond which it cannot be a load.
FORM, NO_SINE, BROAD = 0.3, 0.5, 0.2
#: The `Repetition` of a motion under a load that does not repeat.
NO_REPETITION = Repetition(0, 0.0, 1.0, 1.0)
#: Relative error of a load that is known exactly: a fit would not change what determines it much less than that.
EXACT = 1e-5


class NotTriedError(SingularError):
    """An attempt that does not apply to the records."""


def silent(share: float, note: str) -> None:
    """A progress function that does nothing."""


def unasked() -> bool:
    """A function that reports that it is not known whether a record is not periodic."""
    return False


class Step:
    """The data from one record, step by step."""

    def __init__(self, record: SensorRecord | None, quantity: str) -> None:
        self.record = record
        self.quantity = quantity
        self.Omega = math.nan
        self.load: Tones | None = None
        #: All picked impacts: times from the start, and signs.
        self.times: _Array = np.empty(0)
        self.signs: _Array = np.empty(0)
        self.rhythm = no_rhythm("no impacts")
        self.data: Measured | None = None
        #: The load and, if the record is not periodic, its single flights.
        self.apart: Measured | None = None
        self.windows: Windows | None = None
        #: Flights with impacts of any times and jumps, and the folded record that they describe; scatter of a
        #: sample.
        self.free: FreeFit | None = None
        self.fold: Folded | None = None
        #: Flights, or the error that there are none, by the number of load cycles of a period and whether the
        #: sensors count as exact; copies of a step share them.
        self.known_flights: dict[tuple[int, bool], tuple[Flights, FreeFit] | SingularError] = {}
        #: Prediction errors of the folded record by the number of load cycles of a period; copies share them.
        self.known_news: dict[int, Iterator[tuple[_Array, _Array, int]]] = {}
        self.noise = math.nan
        #: Whether the scatter from period to period exceeds the noise and is some share of the motion, and whether
        #: this share is large, as for an almost periodic motion.
        self.scattered = self.restless = False
        #: The picked impacts that the single flights resolve.
        self.resolved: NDArray[np.bool_] = np.empty(0, dtype=bool)
        #: Largest number of load cycles in a period.
        self.most_cycles = 0
        #: Amplitude of the load from its channel, and its error (N).
        self.F0: float | None = None
        self.F0_error = math.nan
        #: Its error without that of the calibration.
        self.F0_scatter = math.nan
        #: Relative growth of the load during the record, and its ratio to its standard error.
        self.growth, self.growth_size = 0.0, 0.0
        #: Doubts about the record.
        self.notes: list[str] = []
        #: Response of the primary mass to friction in the slot, at the samples, which is not part of the flights.
        self.aside: _Array | float = 0.0
        #: The recorded motion without its slow change, if there is a clear one.
        self.steady: _Array | None = None
        #: Receives the share of the flights that is fitted.
        self.report: Callable[[float, str], None] = silent
        #: Whether single flights show that the record is not periodic; called if repeating flights cannot
        #: describe it.
        self.aperiodic: Callable[[], bool] = unasked

    @property
    def motion(self) -> _Array:
        """The recorded motion without its slow change and the response to friction."""
        values: _Array = getattr(self.record, self.quantity) if self.steady is None else self.steady
        return values if isinstance(self.aside, float) else values - self.aside

    def news(self, k: int) -> Iterator[tuple[_Array, _Array, int]]:
        """The prediction errors of the record folded over k load cycles, each computed once and only if it is
        used."""
        assert self.record is not None
        known = self.known_news if isinstance(self.aside, float) else {}
        begun = known.get(k) or news_of(self.motion, self.record.rate, self.Omega, k)
        own, known[k] = tee(begun)
        return own


def of_record(
    record: SensorRecord, frequency: float | None, scale: Mapping[str, float], i: int, count: int,
    calibration: float = 0.0,
) -> Step:  # fmt: skip
    """The steps before the fit; errors state what is wrong with the record."""
    where = (record.name and f"{record.name}: ") or (f"record {i + 1}: " if count > 1 else "")
    quantity = next((name for name in MOTIONS if getattr(record, name) is not None), None)
    if quantity is None:
        raise ParameterError(
            f"{where}channels {', '.join(record.channels)}: must have one of {', '.join(MOTIONS)}"
        )
    step = Step(record, quantity)
    others = [name for name in MOTIONS if name in record.channels and name != quantity]
    if others:
        step.notes.append(f"{', '.join(others)}: not used; {quantity} is used for the motion")
    values: _Array = getattr(record, quantity)
    for name in ("load", quantity):
        channel = getattr(record, name)
        if channel is not None:
            usable(channel, f"{where}{name}", record.range.get(name))
    rate = record.rate
    near = None if frequency is None else 2 * math.pi * frequency
    force = record.load
    order = MOTIONS[quantity]
    # converted to a displacement, in which the load frequency is strongest
    source = force if force is not None else smooth(values, rate, order)
    Omega = load_frequency(source, rate, near)
    free_form = force is not None and near is None and no_sine(force, values, rate, Omega)
    if force is not None and free_form:
        Omega = mean_frequency(force, rate)
    repetition = None
    if cycles_of(record, Omega) >= LEAST_CYCLES:
        repetition = NO_REPETITION if free_form else period_of(values, rate, Omega)
    if repetition and repetition.cycles and repetition.drift > SLIPPED:
        # parts of the record may differ because the load frequency is slightly inaccurate due to noise; the high
        # harmonics of the motion determine it better
        k = repetition.cycles
        better = Omega + k * tones(values, rate, Omega / k, tones_of(rate, Omega, k)).off
        other = period_of(values, rate, better)
        if other.cycles == k and other.drift < SLIPPED:
            Omega, repetition = better, other
    step.Omega = Omega
    middle = 1.0
    if repetition and repetition.cycles and repetition.drift * repetition.colour > SLIPPED:
        # a rig that changes steadily during the record: the motion of its middle is that of a rig that does not
        k = repetition.cycles
        slow, fewer = changed(values, rate, Omega, k)
        other = period_of(values - slow, rate, Omega)
        gain = repetition.drift * repetition.colour / (OF_MIDDLE * other.colour)
        steadier = other.drift < SLIPPED < max(repetition.drift, gain)
        if other.cycles == k and steadier and settling(values, rate, Omega, k) < SETTLES:
            # the slow change is that of several bins together
            apart = 1 + (OF_MIDDLE - 1) * SLOW_PARTS / PLACES
            repetition = other._replace(noise=other.noise * math.sqrt(fewer * apart))
            step.steady, middle = values - slow, OF_MIDDLE / apart
            step.notes.append(
                f"the motion changes during the record, by {np.std(slow) / np.std(values):.2g} of its standard "
                "deviation; the parameters are those of its middle"
            )
    cycles = cycles_of(record, Omega)
    if cycles < LEAST_CYCLES:
        raise ParameterError(
            f"{where}{record.duration:.6g} s with {cycles:.1f} load cycles of {Omega / (2 * math.pi):.6g} Hz: "
            f"must be at least {LEAST_CYCLES} load cycles"
        )
    if Omega / (2 * math.pi) > rate / 20:
        raise ParameterError(
            f"{where}rate = {rate:g}: must be at least 20 samples per load cycle of {Omega / (2 * math.pi):.6g} Hz"
        )
    if force is not None and free_form:
        ensure_load(force, values, Omega, rate, quantity, where)
    elif force is not None:
        step.load = tones(force, rate, Omega, LOAD_TONES)
        order_of_channels(force, values, step.load, Omega, rate, quantity, where)
        step.notes += filter(None, [steadiness(force, rate, step.load)])
        step.growth, step.growth_size = growth_of(force, rate, step.load)
        passes = float(abs(record.response("load", Omega / (2 * math.pi))))
        # white noise causes this error of an amplitude
        least = record.noise.get("load", 0.0) * math.sqrt(2 / len(record))
        step.load = step.load._replace(errors=np.maximum(step.load.errors, least))
        step.F0, step.F0_error = (
            float(size) / passes for size in (abs(step.load.values[1]), step.load.errors[1])
        )
    for name in record.bandwidth.keys() & {"load", quantity}:
        own = record.bandwidth[name]
        if not own < rate / 2:
            raise ParameterError(
                f"{where}rate = {rate:g}: must be more than twice the bandwidth of {own:g} Hz of {name}; "
                "otherwise the signal is aliased onto the harmonics"
            )
        if own > rate / 4:
            step.notes.append(
                f"bandwidth of {own:g} Hz of {name} at a rate of {rate:g} Hz: the signal above half the "
                "rate is aliased, which the errors do not include"
            )
    for name in ("load", quantity):
        if (channel := getattr(record, name)) is not None:
            changing(channel, rate, Omega, f"{where}{name}")
    assert repetition is not None
    k, noise, colour, drift, longer = repetition
    noise = max(noise, record.noise.get(quantity, 0.0))
    bandwidth = record.bandwidth.get(quantity)
    smooth_record = order == 2 and not free_form and is_smooth(values, rate, Omega, LOAD_TONES)
    if order == 2 and not smooth_record:
        times, step.signs = spikes(values, rate, Omega, bandwidth)
        times -= 0.0 if bandwidth is None else RISE / bandwidth
        step.times = times + (len(record) - 1) / 2 / rate + record.start
        step.rhythm = rhythm(Omega * times / (2 * math.pi), step.signs, cycles, k)
    else:
        step.rhythm = no_rhythm("no impacts" if smooth_record else "not periodic")
    repeats = k and step.rhythm.status not in ("accumulation", "rest")
    if force is None and not repeats:
        return step
    if force is None:
        # the high harmonics determine the frequency better than the first one
        Omega += k * tones(values, rate, Omega / k, tones_of(rate, Omega, k)).off
        step.Omega = Omega
    data = Measured(
        Omega, max(k, 1), order=order, colour=colour * middle, drift=drift, calibration=calibration,
        passed=2 * math.pi * min(FLAT * (bandwidth or math.inf), ALIASED * rate),
        lowpass=2 * math.pi * (bandwidth or math.nan) * butterworth_poles()[: ORDER * bool(bandwidth)],
    )  # fmt: skip
    # a -3 dB frequency determines the delay of a low-pass only approximately; similar channels have equal delays
    late = UNKNOWN_DELAY
    if bandwidth is not None or quantity in record.delay:
        late = DELAY_OF_OTHERS * abs(record.lowpass_lag(quantity) - record.lowpass_lag("load"))
        if not record.delay:
            late = math.hypot(late, IN_TURN / rate)
    if free_form:
        smooth_record = step.rhythm.status == "no impacts"
        data.forced = Forced(record, quantity, Omega)
        data.orders, data.shape = np.empty(0), np.empty(0, dtype=np.complex128)
        data.phase, data.phase_error = 0.0, late * Omega
        step.F0 = data.forced.F0
        noise_of_F0 = data.forced.noise * math.sqrt(2 / len(record))
        step.F0_scatter = math.hypot(noise_of_F0, EXACT * step.F0)
        step.F0_error = math.hypot(step.F0_scatter, calibration * step.F0)
        data.F0, data.F0_error = step.F0, step.F0_error
        if not smooth_record:
            step.notes.append(
                "the load is not nearly a sine and is used as recorded; F0 is the amplitude of a sine of the same "
                f"power, and r refers to its mean frequency of {Omega / (2 * math.pi):.6g} Hz"
            )
    if step.load is not None:
        # the load with the same delay as the motion channel, but without its low-pass
        hertz = np.arange(LOAD_TONES + 1) * Omega / (2 * math.pi)
        through = record.response(quantity, hertz)
        load = step.load.values / record.response("load", hertz) * (through / abs(through))
        size = float(abs(load[1]))
        data.phase, data.phase_error = (
            float(np.angle(1j * load[1])), float(step.load.errors[1] / abs(step.load.values[1])),
        )  # fmt: skip
        data.phase_error = math.hypot(data.phase_error, late * Omega)
        assert step.F0 is not None
        step.F0_scatter = step.F0_error
        step.F0_error = math.hypot(step.F0_error, calibration * step.F0)
        data.F0, data.F0_error = step.F0, step.F0_error
        clear = [
            j
            for j in range(2, LOAD_TONES + 1)
            if abs(step.load.values[j]) > 4 * step.load.errors[j]
        ]
        tone = load[clear] / size
        data.orders = np.array([1.0, *clear])
        data.shape = np.append(-1j, tone * np.exp(-1j * np.array(clear) * data.phase))
    if "F0" in scale:
        data.F0, data.F0_error = scale["F0"], EXACT * scale["F0"]
    if smooth_record:
        return step
    step.apart = data
    if not repeats:
        return step
    step.data = data
    if longer:
        step.notes.append(
            f"doubtful: load cycles differ, and the differences repeat after {longer}: the period may be longer "
            f"than {max(k, 1)}, but the record is too short to show this ({cycles:.0f} load cycles); a longer "
            "record would help"
        )
    step.noise = noise
    differs = noise > RESTLESS * white_noise(values) or colour > COLOURED
    share = noise / float(np.std(values))
    step.scattered, step.restless = differs and share > SOME, differs and share > MUCH
    step.most_cycles = most_cycles(cycles)
    return step


def no_sine(force: _Array, values: _Array, rate: float, Omega: float) -> bool:
    """Whether the form of a load is used as recorded: it is not nearly a sine with harmonics, and what else it
    contains does not keep the motion from repeating, as mains hum of the channel does not."""
    if force.size / rate * Omega < LEAST_CYCLES * 2 * math.pi:
        return False
    fit = tones(force, rate, Omega, LOAD_TONES)
    if off_sine(force, fit, white_noise(force)) > NO_SINE:
        return True
    left = force - fit.at(centred(force.size, rate))
    if float(np.var(left)) - white_noise(force) ** 2 <= FORM**2 * float(np.var(force)):
        return False
    repetition = period_of(values, rate, Omega)
    return not repetition.cycles or repetition.drift > SLIPPED


def cycles_of(record: SensorRecord, Omega: float) -> float:
    """Load cycles in a record."""
    return record.duration * Omega / (2 * math.pi)


def tones_of(rate: float, Omega: float, k: int) -> int:
    """Number of harmonics of a motion of k load cycles from which its frequency is determined."""
    return int(min(0.4 * rate * 2 * math.pi / Omega, MOTION_TONES)) * k


def known_of(
    data: Measured, scale: Mapping[str, float], known: Mapping[str, float]
) -> tuple[float | None, dict[str, tuple[float, float]], tuple[float, float, float] | None]:
    """The natural frequency if it is known; other known parameters of flights with their errors; and, if only the
    mass is known, this mass, the load and its error."""
    omega = known.get("omega")
    priors: dict[str, tuple[float, float]] = {}
    stiffness = scale.get("K", scale.get("M", math.nan) * (omega or math.nan) ** 2)
    if data.F0 is not None and math.isfinite(stiffness):
        static = data.F0 / stiffness
        # as shown by the motion sensor
        error = math.hypot(data.F0_error / stiffness, data.calibration * static)
        priors["static"] = static, max(error, 1e-6 * static)
    if data.phase is not None:
        priors["phase"] = data.phase, max(data.phase_error, 1e-6)
    if "xi" in known:
        priors["xi"] = known["xi"], 0.0  # fixed, so that the flights show whether it is right
    force = None
    if omega is None and data.F0 is not None and "M" in scale:
        force = (
            scale["M"],
            data.F0,
            math.hypot(data.F0_error, max(data.calibration, 1e-6) * data.F0),
        )
    return omega, priors, force


def flown(
    step: Step, scale: Mapping[str, float], known: Mapping[str, float], guess: Mapping[str, float],
    attempt: str = "as it is", quick: bool = False,
) -> None:  # fmt: skip
    """The free flights of a record, which give its impact times to better than a sample: of an attempt with one
    impact in each pulse ("joined"), without the weakest impact ("fewer"), or with sensors taken as exact, as the
    start of a fit ("exactly"); or from one start only."""
    data, record = step.data, step.record
    assert data is not None
    assert record is not None
    exactly = attempt == "exactly"
    flights, free = best_of(step, scale, known, guess, exactly, quick)
    uncertain = data.calibration > 0 and data.F0 is not None
    if free.misfit > POOR and uncertain and not (exactly or quick):
        # a load known only to within its calibration may lead to other impacts
        begin = flights.begin if free.misfit > HOPELESS else None
        with contextlib.suppress(SingularError):
            other, exact = best_of(step, scale, known, guess, True, begin=begin)
            if exact.misfit < LESS * free.misfit:
                free, flights = exact, other
    data = free.data
    if attempt == "joined":
        joined = flights.joined(free)
        if joined is free:
            raise NotTriedError("no two impacts in one pulse")
        free = joined
    if attempt == "fewer" and free.data.angles.size > 2:
        free = flights.without(free, int(np.argmin(abs(free.data.jumps))))
    if free.misfit > HOPELESS:
        raise SingularError(
            f"flights between {free.data.angles.size} impacts in {data.k} load cycles, with up to {MOST_MODES} "
            f"ringing modes, leave residuals of {free.misfit:.3g} times the scatter from period to period: they "
            f"do not explain the record; the bandwidth or the sampling rate may be too small; {HINT}"
        )
    if not free.data.angles.size:
        step.rhythm, step.data = no_rhythm("no impacts"), None
        return
    step.free, step.fold = free, flights.fold
    data = free.data
    whole = 2 * math.pi * data.k
    order = np.argsort(data.angles % whole)
    sides = letters_of(np.sign(data.jumps[order]))
    if len(set(sides)) < 2:
        raise SingularError(
            f"impacts {sides} in {data.k} load cycles: must be on both walls; with impacts on one wall no "
            "motion is periodic"
        )
    # all impacts of the record, without the delay of its sensors
    turns = np.arange(math.ceil(record.duration * data.Omega / whole) + 2)[:, None]
    half = (len(record) - 1) / 2 / record.rate
    lag = record.lag(step.quantity)
    times = (
        (data.angles[order] % whole + whole * (turns - turns.size // 2 - 1)) / data.Omega
        + half
        - lag
    ).ravel()
    inside = (times >= 0) & (times <= 2 * half)
    step.times = times[inside] + record.start
    step.signs = np.tile(np.sign(data.jumps[order]), turns.size)[inside]
    step.data = ordered(
        replace(
            data, jump_errors=free.jump_errors, beside=beside(free), contact=flights.contact(free)
        ),
        np.sign(data.jumps),
    )
    step.rhythm = Rhythm("periodic", data.k, np.empty(0), np.empty(0))


def ordered(data: Measured, signs: _Array) -> Measured:
    """Impacts on the walls given by signs, rotated to the standard first impact as in `Pattern.standard`."""
    whole = 2 * math.pi * data.k
    order = np.argsort(data.angles % whole)
    sides = letters_of(signs[order])
    first = max(range(len(sides)), key=lambda i: sides[i:] + sides[:i])
    order = np.roll(order, -first)
    angles = np.unwrap(data.angles[order] % whole, period=whole)
    angles[1:] += whole * (angles[1:] < angles[0])
    return replace(
        data, sides=sides[first:] + sides[:first], angles=angles, angle_errors=data.angle_errors[order],
        jumps=data.jumps[order], jump_errors=data.jump_errors[order],
    )  # fmt: skip


def best_of(
    step: Step, scale: Mapping[str, float], known: Mapping[str, float], guess: Mapping[str, float],
    exactly: bool, quick: bool = False, begin: _Array | None = None,
) -> tuple[Flights, FreeFit]:  # fmt: skip
    """The folded record and the best flights that describe it; copies of the step share them, or the error if
    there are none.

    The search takes the sensors as exact or not, and begins with the onsets in the record, the first set of them
    alone (`quick`), or given angles.
    """
    data, record = step.data, step.record
    assert data is not None
    assert record is not None
    which = data.k, exactly
    if which not in step.known_flights:
        trusted = replace(data, F0_error=step.F0_scatter, calibration=0.0) if exactly else data
        omega, priors, force = known_of(trusted, scale, known)
        fold = folded(step.motion, record.rate, data.Omega, data.k, PLACES)
        xi = known.get("xi", guess["xi"])
        flights = Flights(data, fold, omega, xi, step.noise, priors, force)
        # spikes have no phases where the motion may not quite repeat
        repeating = step.rhythm.cycles == data.k and not step.scattered
        of_spikes = step.rhythm.phases if repeating else np.empty(0)
        begins = onsets(
            step.news(data.k), 2 * math.pi * of_spikes, PULSE * data.Omega, 2 * math.pi * data.k
        )
        starts = iter([begin]) if begin is not None else begins
        try:
            starts = islice(starts, 1) if quick else starts
            free = flights.best(starts, step.report, step.aperiodic, not step.scattered)
        except SingularError as error:
            step.known_flights[which] = error
        else:
            step.known_flights[which] = flights, free
    found = step.known_flights[which]
    if isinstance(found, SingularError):
        raise found
    return found


def flown_apart(
    step: Step, scale: Mapping[str, float], known: Mapping[str, float], guess: Mapping[str, float],
    rubbed: tuple[float, Slips, float] | None = None, complete: bool = True,
) -> Flown:  # fmt: skip
    """The single flights of a record, which give its impact times to better than a sample; with `rubbed`, the
    arguments of `Windows.rub`, of the record without the response to friction; `complete` as in `Windows`."""
    data, record = step.apart, step.record
    assert data is not None
    assert record is not None
    values: _Array = getattr(record, step.quantity)
    omega, priors, _ = known_of(data, scale, known)
    t = centred(len(record), record.rate)
    static = priors.get(
        "static", (2 * float(np.std(smooth(values, record.rate, data.order))), 0.0)
    )[0]
    step.windows = windows = Windows(
        t, values, data, picked(values, record.rate, data.Omega, data.order), omega,
        known.get("xi", guess["xi"]), priors, (static, data.phase or 0.0),
    )  # fmt: skip
    if rubbed is not None:
        windows.rub(*rubbed)
    windows.complete = complete
    found = windows.run(step.report)
    lag = record.lag(step.quantity)
    step.times = found.times - t[0] + record.start - lag
    step.signs = np.sign(found.jumps)
    step.resolved = found.resolved
    return found


def letters_of(signs: _Array) -> str:
    """The walls of impacts by the signs of the jumps of velocity of the primary mass."""
    return "".join("R" if sign > 0 else "L" for sign in signs)


def smooth(values: _Array, rate: float, order: int) -> _Array:
    """An approximate displacement, from the recorded derivative of a given order."""
    spectrum = np.fft.rfft(values - values.mean())
    w = 2 * math.pi * np.fft.rfftfreq(values.size, 1 / rate)
    w[0] = math.inf
    spectrum[:5] = 0
    shape: _Array = np.fft.irfft(spectrum / w**order, values.size)
    return shape


def usable(values: _Array, name: str, most: float | None = None) -> None:
    """Raises an error if a channel does not vary, or is clipped, for example because it reaches its range."""
    low, high = float(values.min()), float(values.max())
    if not high > low:
        raise ParameterError(f"{name} = {low:g} in all samples: must vary")
    if most is not None and max(-low, high) >= most:
        place = int(np.argmax(abs(values) >= most))
        raise ParameterError(
            f"{name}[{place}] = {values[place]:.6g}: must be within the range of its sensor, {most:g}; "
            f"{int((abs(values) >= most).sum())} samples are not"
        )
    for end in (low, high):
        at = np.flatnonzero(values == end)
        runs = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
        long = [run.size for run in runs if run.size >= 3]
        if len(long) >= 3 or (long and max(long) >= 8):
            raise ParameterError(
                f"{name} is clipped at {end:.6g} in {int(sum(long))} samples; must be within the range of its "
                "sensor"
            )


def changing(values: _Array, rate: float, Omega: float, name: str) -> None:
    """Raises an error if a channel stays constant for longer than samples of few bits do at the peak of a
    sine."""
    ends = np.append(np.flatnonzero(np.diff(values) != 0), values.size - 1)
    runs = np.diff(ends, prepend=-1)
    longest = int(np.argmax(runs))
    if runs[longest] > max(STUCK, STUCK_CYCLES * rate * 2 * math.pi / Omega):
        first = int(ends[longest] - runs[longest] + 1)
        raise ParameterError(
            f"{name}[{first}] = {values[first]:.6g} in {int(runs[longest])} samples: must vary; samples are "
            "missing, or the sensor is stuck"
        )


def steadiness(force: _Array, rate: float, load: Tones) -> str:
    """The message about a load whose frequency is not constant; empty if it is constant."""
    edges = whole_periods(force.size, rate, load.omega, 16)
    t = centred(force.size, rate)
    turned = (force - force.mean()) * np.exp(-1j * load.omega * t)
    sums = np.add.reduceat(turned[: edges[-1]], edges[:-1])
    phases = np.unwrap(np.angle(sums))
    middles = 0.5 * (t[edges[:-1]] + t[edges[1:] - 1])
    off = phases - np.polyval(np.polyfit(middles, phases, 1), middles)
    noise = UNSTEADY * float(np.median(load.errors[2:])) / abs(load.values[1]) * math.sqrt(off.size)
    worst = float(abs(off).max())
    if worst < max(noise, SHIFT * load.omega / rate):
        return ""
    return (
        f"the load phase deviates from that of a constant frequency by {worst:.2g} rad, "
        f"{worst / load.omega * rate:.2g} samples: samples are missing or the frequency changes, which the errors "
        "do not include"
    )


def growth_of(force: _Array, rate: float, load: Tones) -> tuple[float, float]:
    """By which share the amplitude of the load grows from the start of a record to its end, and this share over
    its standard error."""
    edges = whole_periods(force.size, rate, load.omega, 16)
    t = centred(force.size, rate)
    turned = (force - force.mean()) * np.exp(-1j * load.omega * t)
    numbers = np.diff(edges)
    sizes = 2 * abs(np.add.reduceat(turned[: edges[-1]], edges[:-1])) / numbers
    middles = 0.5 * (t[edges[:-1]] + t[edges[1:] - 1]) / (force.size / rate)
    off = middles - middles.mean()
    slope = float(off @ sizes) / float(off @ off)
    left = sizes - sizes.mean() - slope * off
    # from the noise beside the harmonics, or from the residual of a straight line
    error = max(
        float(np.median(load.errors[2:])) * math.sqrt(off.size),
        math.sqrt(float(left @ left) / max(1, off.size - 2)),
    ) / math.sqrt(float(off @ off))  # fmt: skip
    return slope / float(sizes.mean()), slope / max(error, 1e-300)


def order_of_channels(
    force: _Array, values: _Array, load: Tones, Omega: float, rate: float, quantity: str, where: str
) -> None:
    """Raises an error if the load looks like a motion with impacts, and the motion like a load."""

    of_load = off_sine(force, load)
    ensure_order(of_load, off_sine(values, tones(values, rate, Omega, 1)), quantity, where)
    if of_load > NO_SINE:
        raise ParameterError(
            f"{where}load deviates from a sine by {of_load:.0%}: must be nearly a sine, as from a shaker; without "
            "a given frequency, a load of any form is used as recorded"
        )


def off_sine(channel: _Array, fit: Tones, noise: float = 0.0) -> float:
    """By which share of its amplitude a channel without noise deviates from its first harmonic."""
    power = max(float(np.var(channel)) - noise**2, 1e-300)
    return math.sqrt(max(0.0, 1 - 0.5 * abs(fit.values[1]) ** 2 / power))


def ensure_order(of_load: float, of_motion: float, quantity: str, where: str) -> None:
    """Raises an error if the motion deviates from a sine much less than the load."""
    if of_load > 0.3 and of_motion < 0.15:
        raise ParameterError(
            f"{where}load deviates from a sine by {of_load:.0%} and {quantity} by {of_motion:.0%}: must be the "
            "load and the motion; they seem to be in the wrong order"
        )


def ensure_load(
    force: _Array, values: _Array, Omega: float, rate: float, quantity: str, where: str
) -> None:
    """Raises an error if a load that is not a sine has high frequencies or changes abruptly, as where samples are
    missing, or if it looks like a motion with impacts."""
    fits = [tones(x, rate, load_frequency(x, rate), 1) for x in (force, values)]
    ensure_order(off_sine(force, fits[0]), off_sine(values, fits[1]), quantity, where)
    beyond, times = share_beyond(force, rate, Omega), spikes(force, rate, Omega, None)[0]
    # the filter that finds spikes begins and ends with some
    half = 0.5 * force.size / rate
    times = times[abs(times) < half - 2 * math.pi / Omega]
    if beyond > BROAD or times.size:
        what = f"{beyond:.0%} of its amplitude above {highest_of(Omega, rate):.4g} Hz"
        if times.size:
            what = f"{times.size} abrupt changes, the first one at {times[0] + half:.4g} s"
        raise ParameterError(
            f"{where}load with {what}: must be the load of a shaker; samples may be missing, or channels be in "
            "the wrong order"
        )


def of_times(
    impact_times: Any, impact_sides: Any, frequency: float | None, load_phase: float | None,
    scale: Mapping[str, float], shared: Mapping[str, float],
) -> Step:  # fmt: skip
    """The steps before the fit, from impact times alone."""
    if frequency is None:
        raise ParameterError(
            "frequency: is missing; must be the load frequency in Hz if impact_times are given"
        )
    wanted = "increasing finite numbers, at least two"
    times = checks.real_array(impact_times, "impact_times", wanted)
    if (
        times.ndim != 1
        or times.size < 2
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0).any()
    ):
        raise ParameterError(f"impact_times of shape {times.shape}: must be {wanted}")
    if "omega" not in shared:
        raise ParameterError(
            "known natural frequency omega, or mass M and stiffness K: must be given with impact_times, which do "
            "not determine it"
        )
    letters = "".join(impact_sides).upper() if impact_sides is not None else "RL" * times.size
    letters = letters[: times.size] if impact_sides is None else letters
    if len(letters) != times.size or set(letters) - {"R", "L"}:
        raise ParameterError(
            f"impact_sides = {impact_sides!r}: must be one letter R or L for each of {times.size} impacts"
        )
    step = Step(None, "impact times")
    step.Omega = Omega = 2 * math.pi * frequency
    step.times, step.signs = times, np.array([1.0 if letter == "R" else -1.0 for letter in letters])
    cycles = Omega * times / (2 * math.pi)
    span = cycles[-1] - cycles[0] + float(np.median(np.diff(cycles)))
    if span < 3:  # about one period
        period = max(1, round(span))
        order = np.argsort(cycles % period)
        step.rhythm = Rhythm("periodic", period, (cycles % period)[order], step.signs[order])
    else:
        step.rhythm = rhythm(cycles, step.signs, span, repeated(cycles, step.signs, span))
    if step.rhythm.status == "periodic" and len(set(step.rhythm.signs)) < 2:
        step.rhythm = no_rhythm("not periodic")
    if step.rhythm.status != "periodic":
        return step
    k = step.rhythm.cycles
    angles, errors = [], []
    for phase, sign in zip(step.rhythm.phases, step.rhythm.signs, strict=True):
        off = (cycles - phase + k / 2) % k - k / 2
        own = off[(abs(off) < 0.05) & (step.signs == sign)]
        angles.append(2 * math.pi * (phase + own.mean()))
        errors.append(
            2 * math.pi * (own.std(ddof=1) / math.sqrt(own.size) if own.size > 1 else 1e-3)
        )
    data = Measured(
        Omega, k, np.array(angles), np.maximum(errors, 1e-9), np.zeros(len(angles)),
        sides=letters_of(step.rhythm.signs),
    )  # fmt: skip
    if "F0" in scale:
        data.F0, data.F0_error = scale["F0"], EXACT * scale["F0"]
    if load_phase is not None:
        data.phase, data.phase_error = (
            checks.to_float(load_phase, "load_phase", "a finite number"),
            1e-6,
        )
    step.data = data
    return step
