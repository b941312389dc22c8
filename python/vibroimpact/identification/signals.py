"""Steps from a sampled record to its impacts: the load, the harmonics, the detected impacts and their pattern."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..base.libraries import scipy

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Lower edge of the band in which impacts are spikes, relative to the bandwidth of the sensor.
EDGE = 0.4
#: A sample is a spike above this number of standard deviations of the noise, this share of the large spikes, and
#: this share of the largest neighbouring one; smallest distance of two spikes and range of neighbours, in periods
#: of the lower edge.
LIMIT, SHARE, OWN, APART, SPREAD_OF_SPIKES = 8.0, 0.03, 0.4, 0.8, 3.0
#: Seconds over which samples are averaged if the bandwidth is not known.
SHORT = 2e-4
#: Largest number of load cycles in a period, and largest difference of phases of one impact, in cycles.
MOST_CYCLES, SAME = 8, 0.02
#: Largest ratio of the intervals of impacts that accumulate, one after the other.
SHRINKING = 0.9
#: Smallest share of accumulations followed by a rest, in a record with rests.
RESTING = 0.3
#: Smallest share of repeating impacts in a periodic record.
REPEATED = 0.9
#: Number of parts of a load cycle over which noise is summed.
WIDE = 16
#: Load cycles at the start of a record during which its filters settle.
SETTLED = 2
#: Least number of periods in a record; in a record that all shorter periods describe clearly less well; and in one
#: in which means over periods are compared.
LEAST_PERIODS, FEWEST_PERIODS, COMPARED = 10, 5, 3
#: Parts of a load cycle whose means are compared; standard deviations by which the scatter of a part without
#: impacts may be larger; scatter beyond which a sample is left out; largest ratio of similar scatters; largest
#: scatter of a periodic record over its power; blocks of a record that are compared; and ratio of differences
#: between periods that repeat after some number of cycles to those after other numbers.
PARTS, QUIET, ODD, ALIKE, UNREPEATED, BLOCKS, CLEARLY = 64, 5.0, 4.0, 1.1, 0.05, 8, 2.0
#: Largest number of parts of a load cycle that change slowly.
SLOW_PARTS = 128
#: Least number of picked impacts in a load cycle of a record with impacts.
LEAST_PICKS = 0.1
#: Spectral lines on either side of a harmonic from which its error is estimated.
BESIDE = 5
#: Largest residual of harmonics for an acceleration without impacts, relative to its white noise; and relative to
#: the whole signal.
NOISY, SMOOTH = 1.2, 1e-3


class Tones(NamedTuple):
    """Harmonics of a signal: it is Re sum c_n exp(i n omega t), with time 0 in the middle of the record."""

    omega: float
    #: (count + 1) Coefficients from n = 0 on.
    values: _Complex
    #: (count + 1) Standard errors of their real and of their imaginary parts.
    errors: _Array
    #: The error of the frequency, from the same least-squares fit.
    off: float

    def at(self, t: _Array) -> _Array:
        """The signal at given times."""
        total = np.zeros(t.size)
        for n, value in enumerate(self.values):
            total += (value * np.exp(1j * n * self.omega * t)).real
        return total


def centred(n: int, rate: float) -> _Array:
    """Times of samples, 0 in the middle of the record."""
    return np.asarray((np.arange(n) - (n - 1) / 2) / rate, dtype=np.float64)


def whole_periods(n: int, rate: float, omega: float, most: int) -> NDArray[np.int64]:
    """The ends of at most a given number of blocks, each of a whole number of periods, in the middle of a
    record."""
    period = 2 * math.pi / omega * rate
    each = max(1, math.ceil(n / period / most))
    blocks = math.floor(n / period / each)
    edges = np.rint((n - blocks * each * period) / 2 + np.arange(blocks + 1) * each * period)
    whole: NDArray[np.int64] = np.clip(edges, 0, n).astype(np.int64)
    return whole


def tones(values: _Array, rate: float, omega: float, count: int) -> Tones:
    """The harmonics of a frequency by least squares, and their errors from the residual spectrum beside each of
    them."""
    edges = whole_periods(values.size, rate, omega, values.size)
    periods = edges.size - 1
    if periods < 3:
        raise ParameterError(
            f"record of {values.size / rate:.6g} s: must be longer, at least three periods of "
            f"{2 * math.pi / omega:.6g} s"
        )
    t = centred(values.size, rate)[edges[0] : edges[-1]]
    middle = 0.5 * (t[0] + t[-1])
    orders = np.arange(count + 1)
    # exp(i k omega t) as a product of the value at the first sample of a row of a table and that at the position
    # in the row
    length = math.ceil(math.sqrt(t.size))
    rows = np.zeros((math.ceil(t.size / length), length))
    rows.flat[: t.size] = values[edges[0] : edges[-1]]
    starts = np.exp(1j * omega * np.outer(t[::length] - middle, orders))
    within = np.exp(1j * omega / rate * np.outer(orders, np.arange(length)))
    sums = np.sum(starts.conj() * (rows @ within.conj().T), axis=0)
    column = kernel(np.arange(2 * count + 1), t.size, omega / rate)
    both = np.concatenate([sums[:0:-1].conj(), sums])
    found = 2 * scipy("linalg", "the fit of harmonics").solve_toeplitz(column, both)[count:]
    found[0] = found[0].real / 2
    rest = (rows - ((starts * found) @ within).real).ravel()[: t.size]
    by_omega = ((starts * (1j * orders * found)) @ within).real.ravel()[: t.size] * (t - middle)
    off = float(by_omega @ rest / max(float(by_omega @ by_omega), 1e-300))
    # the spectrum of the residual, in which harmonic n is at index n periods
    size = abs(np.fft.rfft(rest)) ** 2
    beside = np.arange(1, max(2, min(BESIDE, periods // 3)) + 1)
    places = np.clip(orders[:, None] * periods + np.append(-beside, beside), 1, size.size - 1)
    squares = size[places].mean(axis=1) * 2 / t.size**2
    # neighbours have about the same noise
    ones = np.ones(min(5, count + 1))
    mean = np.convolve(squares, ones, "same") / np.convolve(np.ones(count + 1), ones, "same")
    turn = np.exp(-1j * omega * middle * orders)
    return Tones(omega, found * turn, np.sqrt(mean), off)


def kernel(orders: Any, n: int, step: float) -> _Array:
    """The sum of exp(i k step j) over n values of j that are symmetric about 0."""
    half = 0.5 * step * np.asarray(orders)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(half == 0, float(n), np.sin(n * half) / np.sin(half))


def load_frequency(values: _Array, rate: float, near: float | None = None) -> float:
    """The frequency (radians per second) of the strongest sine of a signal, or of that near a given frequency."""
    n = values.size
    window = np.hanning(n)
    spectrum = abs(np.fft.rfft((values - values.mean()) * window))
    spectrum[0] = 0
    k = int(np.argmax(spectrum))
    if near is not None:
        here = near * n / rate / (2 * math.pi)
        low, high = (
            max(1, math.floor(0.98 * here) - 1),
            min(spectrum.size, math.ceil(1.02 * here) + 2),
        )
        if low >= high:
            return near
        k = low + int(np.argmax(spectrum[low:high]))
    if not 0 < k < spectrum.size - 1 or spectrum[k] == 0:
        raise ParameterError(
            "load without a frequency: must be a sine of several cycles within the record"
        )
    a, b, c = np.log(np.maximum(spectrum[k - 1 : k + 2], 1e-300))
    omega = 2 * math.pi * rate / n * (k + 0.5 * (a - c) / (a - 2 * b + c))
    t = centred(n, rate)
    # the slope of the phase from block to block is the error of the frequency
    for _ in range(3):
        edges = whole_periods(n, rate, omega, 16)
        if edges.size < 4:
            break
        turned = (values - values.mean()) * np.exp(-1j * omega * t)
        sums = np.add.reduceat(turned[: edges[-1]], edges[:-1])
        middles = 0.5 * (t[edges[:-1]] + t[edges[1:] - 1])
        omega += np.polyfit(middles, np.unwrap(np.angle(sums)), 1, w=abs(sums))[0]
    return float(omega)


def spikes(
    values: _Array, rate: float, omega: float, bandwidth: float | None
) -> tuple[_Array, _Array]:
    """Times (0 in the middle) and signs of the spikes of an acceleration, accurate to about one sample.

    A high-pass filter at a fraction of the bandwidth removes load, motion and most of the ringing. If the
    bandwidth is not known, contacts may last for many samples: spikes are then sought in means over several
    samples.
    """
    signal = scipy("signal", "the picking of impacts")
    each = 1 if bandwidth else max(1, round(rate * SHORT))
    if each > 1:
        late = 0.5 * (values.size % each) / rate
        means = values[: values.size // each * each].reshape(-1, each).mean(axis=1)
        times, signs = spikes(means, rate / each, omega, 0.4 * rate / each)
        return times - late, signs
    edge = max(EDGE * (bandwidth or 0.4 * rate), 20 * omega / (2 * math.pi))
    sections = signal.butter(4, min(edge, 0.4 * rate), "highpass", fs=rate, output="sos")
    left = signal.sosfiltfilt(sections, values - values.mean())
    size = abs(left)
    noise = float(np.median(size)) / 0.6745
    largest = float(np.median(np.sort(size)[-max(3, size.size // 2000) :]))
    apart = max(2, round(APART * rate / edge))
    peaks, _ = signal.find_peaks(size, height=max(LIMIT * noise, SHARE * largest), distance=apart)
    # the filter spreads a spike over a few of its periods
    wide = round(SPREAD_OF_SPIKES * rate / edge)
    kept = [i for i in peaks if size[i] >= OWN * size[max(0, i - wide) : i + wide + 1].max()]
    return centred(values.size, rate)[kept], np.sign(left[kept])


class Rhythm(NamedTuple):
    """The behaviour of the impacts of a record."""

    status: str
    #: Load cycles in a period, 0 if there is none.
    cycles: int
    #: (N) Phases of the impacts of a period in load cycles, from 0 to below `cycles`, and their signs.
    phases: _Array
    signs: _Array


def no_rhythm(status: str) -> Rhythm:
    """The behaviour of the impacts of a record without a pattern."""
    return Rhythm(status, 0, np.empty(0), np.empty(0))


class Repetition(NamedTuple):
    """The periodicity of a signal: the number of load cycles of a period (0: not periodic), the scatter of a
    sample about the periodic mean, the factor by which the noise is stronger at low frequencies, and the factor by
    which parts of the record differ beyond that, both as ratios of variances; and a number of load cycles after
    which differences between periods repeat, which suggests that the record is too short to show its period (0:
    none)."""

    cycles: int
    noise: float
    colour: float
    drift: float
    longer: int = 0


def period_of(values: _Array, rate: float, omega: float) -> Repetition:
    """The number of load cycles after which a signal repeats, and its scatter.

    It is the smallest k that no other number of cycles rejects, at a confidence of seven standard deviations: the
    residual of the mean over periods of k cycles has no mean over other periods that the scatter does not explain.
    If all k are rejected, for example because the noise is not white, it is the smallest k whose scatter is close
    to the smallest scatter. If the record contains fewer than LEAST_PERIODS periods, the period must also leave
    much less scatter, and this scatter must be nearly white, which is not so for chaos.
    """
    turns, part, cycle = places_of(values.size, rate, omega)
    most, longest, compared = (
        most_cycles(turns[-1] - turns[0], periods)
        for periods in (LEAST_PERIODS, FEWEST_PERIODS, COMPARED)
    )
    group = (cycle - cycle[0]) * WIDE + part * WIDE // PARTS
    scatters: dict[int, float] = {}

    def left(k: int, highest: int) -> tuple[_Array, NDArray[np.bool_], float, dict[int, float]]:
        """The residual of the mean over k cycles, the samples for its scatter, the colour of its noise, and the
        variances of its means over other numbers of cycles."""
        off, quiet = left_of(values, turns, part, cycle, k)
        colour = colour_of(off[quiet], group[quiet])
        scatters[k] = float(np.mean(off[quiet] ** 2))
        return off, quiet, colour, {
            other: excess(off[quiet], part[quiet], cycle[quiet] % other, other, colour)
            for other in range(2, highest + 1) if k % other
        }  # fmt: skip

    def repeats(k: int) -> bool:
        """Whether no other number of cycles rejects a period of k cycles."""
        return all(size == 1 for size in left(k, most)[-1].values())

    def better(k: int) -> bool:
        """Whether a period of k cycles leaves clearly less scatter, and that nearly white."""
        return left(k, 1)[2] < CLEARLY and ALIKE * scatters[k] < scatters[found]

    found = next((k for k in range(1, most + 1) if repeats(k)), 0)
    if not found:
        found = next(k for k, own in scatters.items() if own <= ALIKE * min(scatters.values()))
    for k in range(most + 1, longest + 1):
        if better(k) and repeats(k):
            found = k
    off, quiet, colour, others = left(found, compared)
    longer = repeating(others)
    longer = longer if longer and better(longer) else 0
    noise = math.sqrt(scatters[found])
    block = np.minimum((np.arange(values.size) * BLOCKS) // values.size, BLOCKS - 1)
    drift = excess(off[quiet], part[quiet], block[quiet], BLOCKS, colour)
    periodic = noise**2 <= UNREPEATED * float(np.var(values))
    return Repetition(found if periodic else 0, noise, colour, drift, longer)


def repeating(differing: dict[int, float]) -> int:
    """The number of load cycles after which differences between periods repeat, from the variances of means over
    several numbers; 0 if means over numbers without a common factor differ about as much, as by a drift."""
    most = max(differing, key=lambda m: differing[m], default=0)
    others = [size for m, size in differing.items() if math.gcd(m, most) == 1]
    clear = others and differing[most] > CLEARLY * max(1.0, *others)
    return most if clear else 0


def left_of(
    values: _Array, turns: _Array, part: NDArray[np.int64], cycle: NDArray[np.int64], k: int
) -> tuple[_Array, NDArray[np.bool_]]:
    """The residual of a signal about its mean over periods of k load cycles, and the samples for its scatter."""
    off = unrepeated(values, turns % k, k)
    # without the parts that contain impacts
    squares = np.bincount(part, off**2, PARTS) / np.maximum(np.bincount(part, minlength=PARTS), 1)
    quiet: NDArray[np.bool_] = (
        squares <= (1 + QUIET * math.sqrt(2 * PARTS / values.size)) * np.median(squares)
    )[part]
    # and without the samples at the start of a filter
    usual = float(np.median(abs(off[quiet]))) / 0.6745
    quiet &= (abs(off) <= ODD * usual) & (cycle >= cycle[0] + SETTLED)
    return off, quiet


def places_of(
    n: int, rate: float, omega: float
) -> tuple[_Array, NDArray[np.int64], NDArray[np.int64]]:
    """Load cycles of samples, the part of its cycle that each is in, and the number of the cycle."""
    turns = omega / (2 * math.pi) * centred(n, rate)
    part = np.minimum((turns % 1 * PARTS).astype(np.int64), PARTS - 1)
    return turns, part, np.floor(turns).astype(np.int64)


def settling(values: _Array, rate: float, Omega: float, k: int) -> float:
    """The variance of the difference between successive periods of k load cycles in the first third of a record,
    over that in its last third.

    It is about 1 for noise, and little more for a rig that changes steadily, but large while a motion settles.
    Near a period doubling this takes long, and successive periods differ little: periods further apart are
    compared, too.
    """
    found, t = 1.0, np.arange(values.size)
    for several in (1, 4):
        period = several * k * 2 * math.pi / Omega * rate
        third = int(values.size - period) // 3
        if third < period:
            break
        off = np.interp(t[: 3 * third] + period, t, values) - values[: 3 * third]
        found = max(found, float(np.var(off[:third]) / max(float(np.var(off[-third:])), 1e-300)))
    return found


def scatter_after(values: _Array, rate: float, omega: float, k: int) -> float:
    """The scatter of a sample of a signal that repeats after k load cycles."""
    off, quiet = left_of(values, *places_of(values.size, rate, omega), k)
    return math.sqrt(float(np.mean(off[quiet] ** 2)))


def white_noise(values: _Array) -> float:
    """Standard deviation of the noise of single samples, by sixth differences, in which motion is small."""
    return float(np.median(abs(np.diff(values, 6)))) / 0.6745 / math.sqrt(math.comb(12, 6))


def is_smooth(values: _Array, rate: float, omega: float, count: int) -> bool:
    """Whether a few harmonics of the load describe an acceleration to within its white noise, or to a thousandth.

    Impacts would add all harmonics."""
    left = values - tones(values, rate, omega, count).at(centred(values.size, rate))
    return float(np.std(left)) < max(NOISY * white_noise(values), SMOOTH * float(np.std(values)))


def most_cycles(span: float, periods: int = LEAST_PERIODS) -> int:
    """Largest number of load cycles in a period, for a record of a given number of cycles and of periods."""
    return max(1, min(MOST_CYCLES, int(span) // periods))


def unrepeated(values: _Array, phases: _Array, k: int) -> _Array:
    """The residual of a signal after fitting a cubic to the samples of each part of a period; phases in load
    cycles from 0 to k."""
    place, count, within = parts_of(phases, k, 512, 12)
    # powers of the position within a part
    powers = [np.ones(values.size)]
    for _ in range(6):
        powers.append(powers[-1] * within)
    sums = [np.bincount(place, power, count) for power in powers]
    matrix = np.stack(
        [np.stack([sums[i + j] for j in range(4)], axis=-1) for i in range(4)], axis=-2
    )
    found = by_part(values, place, matrix, powers[:4])
    off = values - sum(found[place, j] * powers[j] for j in range(4))
    used = np.minimum(4, np.maximum(sums[0], 1))
    share: _Array = np.sqrt(sums[0] / np.maximum(sums[0] - used, 1))[place]
    scaled: _Array = off * share
    return scaled


def parts_of(
    phases: _Array, k: int, most: int, least: int
) -> tuple[NDArray[np.int64], int, _Array]:
    """The part of a period that each sample is in, of at most so many parts in a load cycle with at least so many
    samples; their number; and the position of each sample within its part, from -1 to 1."""
    count = most * k
    while True:
        place = np.minimum((phases / k * count).astype(np.int64), count - 1)
        if np.bincount(place, minlength=count).min() >= least or count <= 64 * k:
            return place, count, 2 * (phases / k * count - place) - 1
        count //= 2


def by_part(
    values: _Array, place: NDArray[np.int64], matrix: NDArray[Any], columns: Sequence[_Array]
) -> _Array:
    """The coefficients of columns, the first of which is constant, fitted to the samples of each part, from the
    sums of the products of the columns in the parts."""
    count = matrix.shape[0]
    right = np.stack([np.bincount(place, own * values, count) for own in columns], axis=-1)
    # samples at a single position do not determine a slope
    least = np.diag([1e-9, *[1e-6] * (len(columns) - 1)])
    found: _Array = np.linalg.solve(matrix + least * (1 + matrix[:, :1, :1]), right[..., None])[
        ..., 0
    ]
    return found


def changed(values: _Array, rate: float, omega: float, k: int) -> tuple[_Array, float]:
    """The slow change of a signal that repeats after k load cycles, 0 in the middle of the record: at each phase
    of the period, a quadratic polynomial of time. Also the factor of the variance of what remains."""
    turns = places_of(values.size, rate, omega)[0]
    place, count, within = parts_of(turns % k, k, SLOW_PARTS, 32)
    since = 2 * turns / (turns[-1] - turns[0])
    columns = [within**0, within, within**2, within**3]
    columns += [since, since * within, since**2, since**2 * within]
    matrix = np.empty((count, 8, 8))
    for i, j in combinations_with_replacement(range(8), 2):
        matrix[:, i, j] = matrix[:, j, i] = np.bincount(place, columns[i] * columns[j], count)
    found = by_part(values, place, matrix, columns)
    slow: _Array = np.sum([found[place, j] * columns[j] for j in range(4, 8)], axis=0)
    return slow, values.size / max(1, values.size - 4 * count)


def colour_of(off: _Array, group: NDArray[np.int64]) -> float:
    """Variance of sums of neighbouring samples, relative to that of as many independent ones; 1 for white
    noise."""
    numbers = np.bincount(group)
    sums = np.bincount(group, off)
    used = numbers > 0
    return max(1.0, float(np.mean(sums[used] ** 2 / numbers[used]) / np.mean(off**2)))


def excess(
    off: _Array, part: NDArray[np.int64], turn: NDArray[np.int64], count: int, colour: float
) -> float:
    """Variance of the means of parts in a given number of groups of cycles, relative to that expected from their
    scatter.

    It is 1 if it does not exceed 1 at a confidence of seven standard deviations.
    """
    group = part + PARTS * turn
    numbers = np.bincount(group, minlength=PARTS * count)
    sums = np.bincount(group, off, PARTS * count)
    used = numbers > 1
    of_means = float(np.sum(sums[used] ** 2 / numbers[used]))
    groups = int(used.sum())
    freedom = max(PARTS / 2, groups * (count - 1) / count)
    rest = (float(off @ off) - of_means) / max(1, off.size - groups)
    ratio = of_means / max(freedom * rest * colour, 1e-300)
    return ratio if ratio > 1 + 7 * math.sqrt(2 / freedom) else 1.0


def rhythm(cycles: _Array, signs: _Array, span: float, k: int) -> Rhythm:
    """The pattern of impacts at given times, in load cycles, within a record of a given number of cycles that
    repeats after k."""
    if cycles.size < LEAST_PICKS * span:
        return no_rhythm("no impacts")
    run = accumulates(cycles, signs)
    if run:
        return no_rhythm(run)
    return (
        Rhythm("periodic", k, *folded(cycles, signs, k, span)) if k else no_rhythm("not periodic")
    )


def repeated(cycles: _Array, signs: _Array, span: float) -> int:
    """Number of load cycles after which impacts repeat; 0 if they do not."""
    for k in range(1, min(MOST_CYCLES, int(span / 3)) + 1):
        phases, their_signs = folded(cycles, signs, k, span)
        if phases.size < 2:
            continue
        gaps = abs((cycles[:, None] - phases + k / 2) % k - k / 2)
        near = np.min(np.where(signs[:, None] == their_signs, gaps, np.inf), axis=1) < SAME
        if near.mean() >= REPEATED and near.sum() >= REPEATED * phases.size * span / k:
            return k
    return 0


def folded(cycles: _Array, signs: _Array, k: int, span: float) -> tuple[_Array, _Array]:
    """Phases modulo k at which most periods have an impact of the same sign, in order."""
    phases, their_signs = [], []
    for sign in (1.0, -1.0):
        own = np.sort(cycles[signs == sign] % k)
        if not own.size:
            continue
        # begin after the largest gap, so that no group extends across 0
        gaps = np.diff(np.concatenate([own, own[:1] + k]))
        first = (int(np.argmax(gaps)) + 1) % own.size
        own = np.concatenate([own[first:], own[:first] + k])
        for group in np.split(own, np.flatnonzero(np.diff(own) > SAME) + 1):
            if group.size > 0.5 * span / k:
                phases.append(float(np.median(group)) % k)
                their_signs.append(sign)
    order = np.argsort(phases).astype(int)
    return np.array(phases)[order], np.array(their_signs)[order]


def accumulates(cycles: _Array, signs: _Array) -> str:
    """Whether impacts on one wall follow each other at intervals that shrink like a geometric series, and what
    follows: "rest" if the next impact comes long after the series would have ended, otherwise "accumulation"."""
    ends = [*np.flatnonzero(np.diff(signs) != 0) + 1, cycles.size]
    found = []
    first = 0
    for last in ends:
        gaps = np.diff(cycles[first:last])
        if gaps.size >= 3:
            ratios = gaps[1:] / gaps[:-1]
            tail = ratios[-2:]
            if (tail < SHRINKING).all() and gaps[-1] < 0.5 * gaps.max():
                ratio = float(np.median(tail))
                rest_of = gaps[-1] * ratio / (1 - ratio)
                after = cycles[last] - cycles[last - 1] if last < cycles.size else 0.0
                found.append(after > 3 * rest_of)
        first = last
    if len(found) < max(2, 0.2 * (cycles[-1] - cycles[0])):
        return ""
    return "rest" if np.mean(found) > RESTING else "accumulation"
