"""The flights of the primary mass between impacts, from a periodic record.

Between impacts the primary mass is a damped oscillator under the load, whatever the shape of the contact pulses.
The record is therefore folded over its period and compared with exact flights outside the pulses; the lengths of
the pulses are determined from the data. Modes that ring after the impacts, and an offset of the sensor, are fitted
and projected out.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import SingularError
from .contact import LONGEST_PULSE, duration, pulses_of
from .known import HINT
from .least_squares import levenberg
from .measured import MOTIONS
from .signals import centred
from .waves import Ages, Measured, Ringing, predicted, rung, since, turns_of

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Number of bins in a load cycle into which samples are sorted, and smallest number of samples in each.
PLACES, LEAST_SAMPLES = 1024, 6
#: Multiple of the scatter of a bin beyond which a sample is discarded.
ODD = 6.0
#: Bins in a load cycle for the prediction of the next value, and the number of past bins from which it is
#: predicted.
COARSE = ((512, 14), (256, 14), (128, 10), (64, 8))
#: Prediction errors, relative to their scatter and to the largest one, above which there is an impact.
UNPREDICTED, SHARE = 8.0, 0.02
#: Time from an impact within which a prediction error may belong to its pulse, s; prediction error elsewhere,
#: relative to that of the weakest impact, that indicates another impact.
PULSE, ABRUPT = 2e-3, 0.7
#: Seconds after an impact that are excluded at first; the share of a flight that must remain.
FIRST_PULSE, LEAST_FLIGHT = 4e-3, 0.3
#: Residual, relative to its error, at which a pulse has ended. The excluded part is extended beyond that by a
#: multiple of the time in which the pulse fades by a factor of ten, but at most by a share of its length.
ENDED, MARGIN, FADES = 3.0, 0.6, 1.0
#: Time (s) over which residuals are summed to find transients that are weaker than the noise of a bin, and such a
#: sum, relative to its error, above which a pulse is extended.
LASTS, LASTING = 0.4e-3, 4.0
#: Misfit of periodic flights above which they do not describe the record.
HOPELESS = 25.0
#: Misfit of free flights above which others are tried.
POOR = 2.0
#: Largest number of ringing modes; misfit above which another mode or impact, and other starts, are tried;
#: reduction of the sum of squares, absolute and relative, that another mode must achieve; initial rates of decay
#: of a mode (1/s); and largest number of steps of a fit, after which another fit follows.
STEPS = 15
MOST_MODES, GOOD = 3, 1.3
LEAST_GAIN, LEAST_SHARE = 40.0, 0.2
DECAYS = (30.0, 100.0, 300.0, 900.0)
#: Smallest and largest rate of decay of a ringing mode, relative to its frequency; its lowest frequency, relative
#: to that of the load, and its highest one, relative to that of the bins.
LEAST_DAMPED, MOST_DAMPED, LOWEST, HIGHEST = 0.002, 0.5, 4, 0.25
#: The largest rate of decay, relative to its frequency, of what an acceleration shows of a filter: the transient
#: of a steep filter is a sum of modes, and those that decay fast must not be left to the flights.
OF_FILTER = 2.0
#: Jumps of the velocity below this number of errors, or below this share of the largest one, do not count as
#: impacts, unless a good misfit increases by this factor without them.
CLEAR, WEAK, NEEDED = 5.0, 0.01, 10.0
#: Largest number of impacts that are added to a start without impacts, and of missing impacts that are added in
#: each load cycle to the predicted ones.
MOST_IMPACTS, MISSING = 8, 2


class Folded(NamedTuple):
    """Samples sorted into bins of a period: mean angles, values, their means and numbers."""

    angles: _Array
    values: _Array
    means: _Array
    counts: _Array
    #: (n) Bin of each sample, -1 if it is discarded, and the angles of the samples.
    place: NDArray[np.int64]
    each: _Array


def folded(values: _Array, rate: float, Omega: float, k: int, most: int) -> Folded:
    """Samples sorted into at most a given number of bins in each load cycle, without cycles that differ from the
    others."""
    each = (Omega * centred(values.size, rate)) % (2 * math.pi * k)
    count = most * k
    while True:
        place = np.minimum((each / (2 * math.pi * k) * count).astype(np.int64), count - 1)
        numbers = np.bincount(place, minlength=count)
        if numbers.min() >= LEAST_SAMPLES or count <= 64 * k:
            break
        count //= 2
    # discard samples that differ from the others of their bin, as at the start of a filter, and outlying periods
    middles = medians(values, place, numbers)
    spreads = medians(abs(values - middles[place]), place, numbers)
    spreads = np.maximum(spreads, np.nanmedian(spreads)) / 0.6745
    period = np.floor((np.arange(values.size)) / (2 * math.pi * k / Omega * rate)).astype(np.int64)
    off = (values - middles[place]) ** 2
    size = np.minimum(off, 100 * np.median(off))
    scatter = np.bincount(period, size) / np.bincount(period)
    usual = np.median(scatter)
    spread = 1.5 * np.median(abs(scatter - usual))
    odd = scatter > usual + max(8 * spread, 0.3 * usual)
    unlike = off > (ODD * spreads[place]) ** 2
    if odd.mean() < 0.2:
        unlike |= odd[period]
    place = np.where(unlike, -1, place)
    used = place >= 0
    numbers = np.bincount(place[used], minlength=count)
    good = np.flatnonzero(numbers > 0)
    sums = np.bincount(place[used], values[used], count)[good] / numbers[good]
    middle = np.bincount(place[used], each[used], count)[good] / numbers[good]
    renumber = np.full(count + 1, -1)
    renumber[good] = np.arange(good.size)
    return Folded(middle, sums, sums, numbers[good].astype(float), renumber[place], each)


def medians(values: _Array, place: NDArray[np.int64], numbers: NDArray[np.int64]) -> _Array:
    """Medians of the values in each bin, from the bins of all values and their numbers; NaN in empty bins."""
    sorted_values = values[np.lexsort((values, place))]
    used = numbers > 0
    begins, most = (np.cumsum(numbers) - numbers)[used], numbers[used]
    middles = np.full(numbers.size, math.nan)
    low, high = sorted_values[begins + (most - 1) // 2], sorted_values[begins + most // 2]
    middles[used] = (low + high) / 2
    return middles


def unpredicted(values: _Array, past: int) -> _Array:
    """The error in predicting a periodic sequence from its past, relative to the scatter.

    Flights and ringing are damped waves, in which each value is a linear combination of earlier values; only an
    impact cannot be predicted.
    """
    before = np.column_stack([np.roll(values, j) for j in range(1, past + 1)])
    weights = np.ones(values.size)
    rest, scatter = values, 1.0
    for _ in range(10):
        root = np.sqrt(weights)
        found = np.linalg.lstsq(before * root[:, None], values * root, rcond=1e-10)[0]
        rest = values - before @ found
        scatter = max(float(np.median(abs(rest))) / 0.6745, 1e-300)
        weights = 1 / (1 + (rest / (2 * scatter)) ** 2) ** 2
    return rest / scatter


def news_of(
    values: _Array, rate: float, Omega: float, k: int
) -> Iterator[tuple[_Array, _Array, int]]:
    """For finer and coarser bins of a folded record: their angles, the prediction errors relative to the scatter,
    and the number of past bins used."""
    for most, past in COARSE:
        coarse = folded(values, rate, Omega, k, most)
        grid = (np.arange(most * k) + 0.5) * 2 * math.pi / most
        even = np.interp(grid, coarse.angles, coarse.means, period=2 * math.pi * k)
        yield grid, abs(unpredicted(even - even.mean(), past)), past


def unexplained(
    sudden: Iterable[tuple[_Array, _Array, int]], Omega: float, k: int, angles: _Array
) -> float | None:
    """An angle, far from all impacts, at which a record changes as abruptly as at its weakest impact, by its
    `news_of`."""
    half, abrupt, place = math.pi * k, 0, 0.0
    for grid, news, past in sudden:
        apart = abs((grid[:, None] - angles + half) % (2 * half) - half)
        pulse = PULSE * Omega
        far = apart.min(axis=1) > max(pulse, (past + 2) * (grid[1] - grid[0]))
        if not far.any():
            continue
        weakest = min(news[near].max(initial=0.0) for near in (apart <= pulse).T)
        most = news[far].max()
        if most > max(ABRUPT * weakest, UNPREDICTED):
            abrupt, place = abrupt + 1, float(grid[far][news[far].argmax()])
    return place if abrupt >= len(COARSE) - 1 else None


def onsets(
    sudden: Iterable[tuple[_Array, _Array, int]], spikes: _Array, pulse: float, whole: float
) -> Iterator[_Array]:
    """Candidate sets of angles at which impacts seem to begin in a folded record, by its `news_of`; also the empty
    set.

    Of contacts shorter than a bin only spikes may be left: the last set but one adds those that are further than a
    pulse from the first set."""
    every: _Array | None = None
    for grid, news, past in sudden:
        strong = news > max(UNPREDICTED, SHARE * news.max())
        # an impact causes prediction errors as long as it is among the past values
        recent = np.convolve(np.concatenate([strong[-past:], strong]), np.ones(past), "valid")[:-1]
        begins = grid[strong & (recent == 0)]
        if begins.size:
            yield begins
            every = begins if every is None else every
    if every is not None:
        several = every.size
        for spike in spikes % whole:
            away = abs((every - spike + whole / 2) % whole - whole / 2)
            every = np.append(every, spike) if (away > pulse).all() else every
        if every.size > several:
            yield every
    yield np.empty(0)


class FreeFit(NamedTuple):
    """The primary mass under impulses of arbitrary times and sizes, fitted to a folded record."""

    data: Measured
    omega: float
    xi: float
    static: float
    phase: float
    offset: float
    modes: list[Ringing]
    #: The bins within a pulse, and the residuals at all bins relative to their errors.
    pulse: NDArray[np.bool_]
    left: _Array
    square: float
    freedom: int
    jump_errors: _Array

    @property
    def misfit(self) -> float:
        """Sum of squares over the degrees of freedom."""
        return self.square / max(1, self.freedom)


class Flights:
    """A folded record and the fit of flights to it."""

    def __init__(
        self,
        data: Measured,
        fold: Folded,
        omega: float | None,
        xi: float,
        noise: float,
        priors: dict[str, tuple[float, float]],
        force: tuple[float, float, float] | None = None,
    ) -> None:
        self.priors = priors
        #: A known mass, the load, and its error, if the natural frequency is to be found.
        self.force = force
        self.data, self.fold = data, fold
        self.known_omega = omega
        self.xi = xi
        self.whole = 2 * math.pi * data.k
        self.errors = noise / np.sqrt(fold.counts)
        #: The start that led to the best flights.
        self.begin: _Array = np.empty(0)

    def rings(self, pole: complex) -> bool:
        """Whether a mode decays, but not too fast, and is within the band of the folded record."""
        highest = HIGHEST * self.fold.angles.size / self.data.k
        within = LOWEST < pole.imag / self.data.Omega < highest
        most = OF_FILTER if self.data.order == MOTIONS["acceleration"] else MOST_DAMPED
        return within and LEAST_DAMPED * pole.imag < -pole.real < most * pole.imag

    def packed(self, point: tuple[list[float], _Array, _Array, float, list[Ringing]]) -> _Array:
        """The parameters packed into one array."""
        four, angles, jumps, offset, modes = point
        parts = [np.array(four), angles, jumps, np.array([offset])]
        for mode in modes:
            pole = np.array([mode.pole.real, mode.pole.imag])
            parts += [mode.size.real, mode.size.imag, pole]
        return np.concatenate(parts)

    def split(self, x: _Array, N: int) -> tuple[list[float], _Array, _Array, float, list[Ringing]]:
        """The parameters unpacked from an array."""
        four, angles, jumps, rest = (
            x[:4].tolist(),
            x[4 : 4 + N],
            x[4 + N : 4 + 2 * N],
            x[4 + 2 * N :],
        )
        modes = []
        for own in rest[1:].reshape(-1, 2 * N + 2):
            modes.append(Ringing(complex(own[-2], own[-1]), own[:N] + 1j * own[N : 2 * N]))
        return four, angles, jumps, float(rest[0]), modes

    def model(
        self, x: _Array, N: int, places: _Array, ages: Ages, turns: _Array | None = None
    ) -> tuple[_Array, Callable[[_Array], None]]:
        """The motion, and a function that puts its derivatives with respect to all parameters into an array;
        amplitudes of modes refer to the impacts of given ages, and `turns` are those of the places, if they are
        known."""
        (omega, xi, static, phase), angles, jumps, offset, modes = self.split(x, N)
        if not (0 <= xi < 0.9 and omega > 0 and all(self.rings(mode.pole) for mode in modes)):
            raise SingularError("no damped oscillator")
        one = predicted(
            self.data, places, self.data.order, omega, xi, static, phase, angles, jumps, turns
        )
        value = one.value + offset
        ringing = [rung(self.data, ages, mode) for mode in modes]
        for own, _ in ringing:
            value = value + own

        def derivatives(J: _Array) -> None:
            J[:, :4] = one.by_system
            one.by_impacts(J[:, 4 : 4 + 2 * N])
            J[:, 4 + 2 * N] = 1.0
            for j, (_, by_mode) in enumerate(ringing):
                first = 4 + 2 * N + 1 + j * (2 * N + 2)
                J[:, first : first + 2 * N + 2] = by_mode()

        return value, derivatives

    def fit(
        self,
        begin: tuple[list[float], _Array, _Array, float, list[Ringing]],
        pulse: NDArray[np.bool_],
        held: bool = False,
    ) -> FreeFit:
        """The free fit from given parameters, outside the pulses."""
        four, angles, jumps, offset, modes = begin
        N = angles.size
        own = ~pulse
        places, values, errors = self.fold.angles[own], self.fold.values[own], self.errors[own]
        if np.count_nonzero(own) < 4 * N + 40:
            raise SingularError(
                "the pulses of the impacts cover too much of the motion: the bandwidth or the sampling rate may "
                f"be too small; {HINT}"
            )
        x = self.packed(begin)
        # first all linear parameters
        fixed = np.ones(x.size, dtype=bool)
        fixed[4 + N : 4 + 2 * N + 1] = False
        for j in range(len(modes)):
            first = 4 + 2 * N + 1 + j * (2 * N + 2)
            fixed[first : first + 2 * N] = False
        fixed[2] = "static" in self.priors or self.force is not None
        turns, ages = turns_of(self.data, places), Ages(self.data, places, begin[1])
        value, by = self.model(x, N, places, ages, turns)
        J = np.empty((places.size, x.size))
        by(J)
        target = (values - value + J[:, ~fixed] @ x[~fixed]) / errors
        x[~fixed] = np.linalg.lstsq(J[:, ~fixed] / errors[:, None], target, rcond=1e-9)[0]
        if not abs(values).max() < 1e100:
            raise SingularError(f"the trial flights overflow; {HINT}")
        rms = max(float(np.std(values)), 1e-300)
        speed = max(float(abs(x[4 + N : 4 + 2 * N]).max(initial=0.0)), 1e-300)
        scales = [
            0.0 if self.known_omega is not None else 0.1 * x[0],
            0.0 if "xi" in self.priors else 0.01, max(abs(x[2]), 1e-300), 0.2,
            *[0.0 if held else 0.01] * N,
            *[speed] * N, rms,
        ]  # fmt: skip
        for mode in modes:
            scales += [rms] * (2 * N) + [0.2 * abs(mode.pole.real), 0.02 * mode.pole.imag]

        priors = [
            (place, *prior) for place, name in ((2, "static"), (3, "phase"))
            if (prior := self.priors.get(name)) is not None
        ]  # fmt: skip

        def force(x: _Array) -> tuple[float, _Array]:
            """The load implied by the motion of a known mass, compared with the load of its channel."""
            mass, load, error = self.force or (0.0, 0.0, 1.0)
            by = np.zeros(x.size)
            by[[0, 2]] = 2 * mass * x[0] * x[2] / error, mass * x[0] ** 2 / error
            return (mass * x[0] ** 2 * x[2] - load) / error, by

        weights = 1 / errors[:, None]

        def residuals(x: _Array) -> tuple[_Array, Callable[[_Array | None], _Array]]:
            value, by = self.model(x, N, places, ages, turns)
            off = [(x[place] - value) / error for place, value, error in priors]
            last, by_last = force(x)

            def derivatives(J: _Array | None) -> _Array:
                J = np.empty((places.size + len(priors) + 1, x.size)) if J is None else J
                by(J[: places.size])
                J[: places.size] *= weights
                J[places.size :] = 0.0
                for row, (place, _, error) in zip(J[places.size :], priors, strict=False):
                    row[place] = 1 / error
                J[-1] = by_last
                return J

            return np.concatenate([(value - values) / errors, off, [last]]), derivatives

        x, f, J, _ = levenberg(residuals, x, np.array(scales), most=STEPS)
        four, angles, jumps, offset, modes = self.split(x, N)
        square, freedom = float(f @ f), f.size - x.size
        free = np.array(scales) > 0
        spread = np.zeros(x.size)
        covariance = np.linalg.pinv(J[:, free].T @ J[:, free], rcond=1e-14)
        spread[free] = np.sqrt(
            np.maximum(np.diag(covariance), 0) * max(1.0, square / max(1, freedom))
        )
        every = Ages(self.data, self.fold.angles, begin[1])
        left = (self.fold.values - self.model(x, N, self.fold.angles, every)[0]) / self.errors
        for mode in modes:
            mode.size = mode.size * np.exp(mode.pole * (angles - begin[1]) / self.data.Omega)
        data = replace(
            self.data, angles=angles, jumps=jumps, angle_errors=spread[4 : 4 + N], places=places, values=values,
            errors=errors,
        )  # fmt: skip
        return FreeFit(
            data,
            four[0],
            four[1],
            four[2],
            four[3],
            offset,
            modes,
            pulse,
            left,
            square,
            freedom,
            spread[4 + N : 4 + 2 * N],
        )

    def pulses(self, angles: _Array, before: _Array, after: _Array) -> NDArray[np.bool_]:
        """The bins within given times before and after impacts (s)."""
        tau = since(self.fold.angles, angles, self.data)
        left_over = self.whole / self.data.Omega - tau
        inside: NDArray[np.bool_] = np.any((tau <= after) | (left_over <= before), axis=1)
        return inside

    def lengths(self, found: FreeFit) -> tuple[_Array, _Array]:
        """Times before and after the impacts (s) within which the flights do not describe the record."""
        angles = found.data.angles
        step = self.whole / self.data.Omega / self.fold.angles.size
        tau = since(self.fold.angles, angles, self.data)
        back = self.whole / self.data.Omega - tau
        limit = ENDED * max(1.0, math.sqrt(min(found.misfit, 25.0)))
        bad, large = abs(found.left) > limit, abs(found.left) > 10 * limit
        order = np.argsort(angles)
        gaps = self.gaps(angles)
        gaps_before = np.empty(angles.size)
        gaps_before[order] = np.roll(gaps[order], 1)
        before, after = np.empty(angles.size), np.empty(angles.size)
        for i in range(angles.size):
            room = min(LONGEST_PULSE, (1 - LEAST_FLIGHT) * gaps[i])
            own = np.sort(tau[bad & (tau[:, i] <= min(2 * FIRST_PULSE, room)), i])
            # the pulse ends before the first long interval without such residuals
            ends = np.flatnonzero(np.diff(own) > max(0.6e-3, 6 * step))
            last = own[ends[0]] if ends.size else own[-1] if own.size else 0.0
            # the transient of a filter fades by a factor of ten at a time; other residuals may not belong to the
            # pulse
            ten = 0.0
            if found.misfit < GOOD:
                ten = tau[large & (tau[:, i] <= last), i].max(initial=0.0)
            after[i] = min(room, last + min(MARGIN * last, FADES * (last - ten)) + 2 * step)
            ahead = np.sort(
                back[bad & (back[:, i] <= min(FIRST_PULSE / 2, 0.3 * gaps_before[i])), i]
            )
            ends = np.flatnonzero(np.diff(ahead) > max(0.3e-3, 4 * step))
            first = ahead[ends[0]] if ends.size else ahead[-1] if ahead.size else 0.0
            before[i] = first * (1 + MARGIN) + 2 * step
        return before, after

    def gaps(self, angles: _Array) -> _Array:
        """The times from impacts to the next ones (s)."""
        order = np.argsort(angles)
        gaps = np.empty(angles.size)
        gaps[order] = (
            np.diff(np.append(angles[order], angles[order[:1]] + self.whole)) / self.data.Omega
        )
        return gaps

    def faded(self, found: FreeFit) -> NDArray[np.bool_]:
        """The pulses of a fit, extended by what is left of their transients: residuals that last, each below the
        noise of its bin."""
        angles = found.data.angles
        if not angles.size:
            return found.pulse
        several = max(1, round(LASTS * self.data.Omega / self.whole * self.fold.angles.size))
        left = np.where(found.pulse, 0.0, found.left)
        sums = np.cumsum(np.concatenate([[0.0], left, left[: several - 1]]))
        limit = LASTING * math.sqrt(several * max(1.0, found.misfit))
        tau = since(self.fold.angles, angles, self.data)
        impact, tau = np.argmin(tau, axis=1), np.min(tau, axis=1)
        late = (abs(sums[several:] - sums[:-several]) > limit) & (tau < 2 * FIRST_PULSE)
        after = np.zeros(angles.size)
        np.maximum.at(after, impact[late], tau[late] + LASTS)
        after = np.minimum(after, (1 - LEAST_FLIGHT) * self.gaps(angles))
        return found.pulse | self.pulses(angles, np.zeros(angles.size), after)

    def contact(self, found: FreeFit) -> float:
        """The duration of the contacts (s), from the pulses."""
        data, fold, half = found.data, self.fold, self.whole / 2
        own = np.flatnonzero(found.pulse)
        places, N = fold.angles[own], data.angles.size
        off = (places[:, None] - data.angles + half) % self.whole - half
        impact = np.argmin(abs(off), axis=1)
        off = off[np.arange(own.size), impact] / data.Omega
        step = np.diff(fold.angles, append=fold.angles[0] + self.whole) / data.Omega
        width = 0.5 * (step + np.roll(step, 1))[own]
        here = self.packed(self.point(found))
        left = (
            fold.values[own] - self.model(here, N, places, Ages(self.data, places, data.angles))[0]
        )
        # impacts whose pulses do not touch others, if there are several, which show the error
        touching = (np.roll(own, -1) == (own + 1) % step.size) & (np.roll(impact, -1) != impact)
        alone = np.isin(
            np.arange(N), [impact[touching], np.roll(impact, -1)[touching]], invert=True
        )
        alone |= alone.sum() < 2
        forces, errors, modes = pulses_of(
            data, data.jumps, found.modes, impact, off, left, width, self.errors[own]
        )
        modes = [Ringing(mode.pole, mode.size[alone]) for mode in modes]
        lasts = duration(data, forces[alone], errors[alone], data.jumps[alone], modes)
        # no contact lasts longer than its pulse
        most = max((float(width[impact == i].sum()) for i in np.flatnonzero(alone)), default=0.0)
        return min(lasts, most)

    def point(self, found: FreeFit) -> tuple[list[float], _Array, _Array, float, list[Ringing]]:
        """The starting parameters of a fit that continues another one."""
        four = [found.omega, found.xi, found.static, found.phase]
        return four, found.data.angles, found.data.jumps, found.offset, found.modes

    def more_ringing(self, found: FreeFit, held: bool = False) -> FreeFit:
        """The fit with one more mode, if this reduces the residuals considerably."""
        left = np.where(found.pulse, 0.0, found.left * self.errors)
        spectrum = abs(np.fft.rfft(left))
        spectrum[: LOWEST * self.data.k + 1] = 0
        best, least = found, math.inf
        w = int(np.argmax(spectrum)) * self.data.Omega / self.data.k
        if w == 0:
            return found
        own = ~found.pulse
        weights = 1 / self.errors[own][:, None]
        ages = Ages(self.data, self.fold.angles[own], found.data.angles)
        for shift in (0.0, -0.4, 0.4):
            for decay in DECAYS:
                mode = Ringing(
                    complex(-decay, w + shift * self.data.Omega),
                    np.zeros(found.data.angles.size, dtype=np.complex128),
                )
                if not self.rings(mode.pole):
                    continue
                A = rung(self.data, ages, mode)[1]()[:, :-2] * weights
                rest = found.left[own] - A @ np.linalg.lstsq(A, found.left[own], rcond=1e-9)[0]
                square = float(rest @ rest)
                if square < least:
                    least, best = square, found._replace(modes=[*found.modes, mode])
        if least > found.square - max(LEAST_GAIN, 0.5 * LEAST_SHARE * found.square):
            return found
        try:
            more = self.fit(self.point(best), found.pulse, held)
        except SingularError:
            return found
        gain = found.square - more.square
        return more if gain > max(LEAST_GAIN, LEAST_SHARE * found.square) else found

    def settled(self, found: FreeFit, ringing: bool = True, rounds: int = 4) -> FreeFit:
        """The fit with pulse lengths determined from the data, and with the ringing modes."""
        good: FreeFit | None = None
        for _ in range(rounds):
            while ringing and len(found.modes) < MOST_MODES and found.misfit > GOOD:
                more = self.more_ringing(found)
                if more is found:
                    break
                found = more
            pulse = self.pulses(found.data.angles, *self.lengths(found))
            if (pulse == found.pulse).all():
                break
            good = found if found.misfit < GOOD else good
            found = self.fit(self.point(found), pulse)
        # pulses that have just become too short are replaced by those of the previous round
        found = good if good is not None and found.misfit > GOOD else found
        for _ in range(rounds):
            pulse = self.faded(found)
            if found.misfit > GOOD or (pulse == found.pulse).all():
                break
            found = self.fit(self.point(found), pulse)
        return found

    def begun(self, angles: _Array) -> FreeFit:
        """The first fit, with pulses that are certainly long enough."""
        angles = np.sort(angles)
        gaps = np.diff(np.append(angles, angles[:1] + self.whole)) / self.data.Omega
        after = np.minimum(FIRST_PULSE, 0.5 * gaps)
        pulse = self.pulses(angles, np.full(angles.size, 0.3e-3), after)
        four = self.linear(angles, pulse)
        for place, name in ((2, "static"), (3, "phase")):
            if name in self.priors:
                four[place] = self.priors[name][0]
        # impact times are fixed until the ringing is known, since one could imitate the other
        found = self.fit((four, angles, np.zeros(angles.size), 0.0, []), pulse, held=True)
        plain = self.fit(self.point(found), pulse)
        more = found
        if plain.misfit > POOR and angles.size:
            more = self.more_ringing(found, held=True)
        return plain if more is found else self.fit(self.point(more), pulse)

    def linear(self, angles: _Array, pulse: NDArray[np.bool_]) -> list[float]:
        """Natural frequency, damping ratio, static displacement and load phase, only by linear least squares."""
        own, N = ~pulse, angles.size
        places, target = self.fold.angles[own], self.fold.values[own] / self.errors[own]
        xi = self.xi
        best: tuple[float, list[float]] = math.inf, []
        known = (
            [self.known_omega] if self.known_omega else self.data.Omega / np.geomspace(0.5, 2, 41)
        )
        for omega in known:
            both = [
                predicted(self.data, places, self.data.order, omega, xi, 1.0, phase, angles, np.zeros(N))
                for phase in (0.0, math.pi / 2)
            ]  # fmt: skip
            A = np.column_stack([both[0].value, both[1].value, both[0].jumps, np.ones(places.size)])
            A /= self.errors[own][:, None]
            given = np.zeros(2)
            if self.force is not None and "phase" in self.priors:
                turn = self.priors["phase"][0]
                static = self.force[1] / self.force[0] / omega**2
                given = static * np.array([math.cos(turn), math.sin(turn)])
            free = slice(2, None) if given.any() else slice(0, None)
            x = np.zeros(A.shape[1])
            x[:2] = given
            x[free] = np.linalg.lstsq(A[:, free], target - A @ x, rcond=1e-9)[0]
            rest = target - A @ x
            square = float(rest @ rest)
            if square < best[0]:
                best = square, [float(omega), xi, math.hypot(x[0], x[1]), math.atan2(x[1], x[0])]
        return best[1]

    def pruned(self, found: FreeFit) -> FreeFit:
        """The fit without insignificant jumps. A jump whose pulse covers its flight is unclear; it is kept if the
        flights without it do not describe the record."""
        while found.data.angles.size > 1:
            sizes = abs(found.data.jumps)
            errors = np.maximum(found.jump_errors, 1e-300)
            score = np.minimum(sizes / errors / CLEAR, sizes / sizes.max() / WEAK)
            i = int(np.argmin(score))
            if score[i] >= 1:
                break
            fewer = self.without(found, i)
            if found.misfit < GOOD and fewer.misfit > NEEDED * found.misfit:
                break
            found = fewer
        return found

    def joined(self, found: FreeFit) -> FreeFit:
        """The fit with one impact instead of two between which no sample is outside a pulse.

        Only the sum of their jumps shows, and the mean time. Such a pair imitates one impact whose pulse is late,
        as behind a steep filter."""
        N, i = found.data.angles.size, 0
        while i < N > 2:
            angles, jumps = found.data.angles.copy(), found.data.jumps.copy()
            gaps = (angles - angles[i] - 1e-12) % self.whole
            j, first = int(np.argmin(gaps)), i
            between = (self.fold.angles - angles[i]) % self.whole < gaps[j]
            i += 1
            jumps[first] += jumps[j]
            late = gaps[j] * jumps[j] / (jumps[first] or math.inf)
            if not found.pulse[between].all() or abs(late) > PULSE * self.data.Omega:
                continue
            angles[first] += late
            angles, jumps = np.delete(angles, j), np.delete(jumps, j)
            four, _, _, offset, modes = self.point(found)
            modes = [Ringing(mode.pole, np.delete(mode.size, j)) for mode in modes]
            with contextlib.suppress(SingularError):
                one = self.settled(self.fit((four, angles, jumps, offset, modes), found.pulse))
                if one.misfit < max(GOOD, found.misfit):
                    found, N, i = one, one.data.angles.size, 0
        return found

    def without(self, found: FreeFit, i: int) -> FreeFit:
        """The fit without an impact."""
        four, angles, jumps, offset, modes = self.point(found)
        modes = [Ringing(mode.pole, np.delete(mode.size, i)) for mode in modes]
        before, after = self.lengths(found)
        angles = np.delete(angles, i)
        pulse = self.pulses(angles, np.delete(before, i), np.delete(after, i))
        return self.fit((four, angles, np.delete(jumps, i), offset, modes), pulse)

    def curved(self, found: FreeFit) -> FreeFit:
        """The fit to values at the mean angles of bins; the means over a bin differ from these if the motion is
        curved."""
        N = found.data.angles.size
        fold, used = self.fold, self.fold.place >= 0
        x = self.packed(self.point(found))
        values, middle = (
            self.model(x, N, places, Ages(self.data, places, found.data.angles))[0]
            for places in (fold.each[used], fold.angles)
        )
        each = np.bincount(fold.place[used], values)
        self.fold = fold._replace(values=fold.means + middle - each / fold.counts)
        return self.fit(self.point(found), found.pulse)

    def best(
        self,
        starts: Iterable[_Array],
        report: Callable[[float, str], None],
        other: Callable[[], bool],
        patient: bool = True,
    ) -> FreeFit:
        """The flights between impacts that begin at given angles, including missing impacts; from several starts
        the first good result, or the best. `report` receives the share of the starts that were tried. If the first
        one is poor, or the first two (`patient`), `other` says whether the record is known not to be periodic."""
        best: FreeFit | None = None
        failed: SingularError | None = None
        for i, angles in enumerate(starts):
            report(i / (len(COARSE) + 1), "flights of a period")
            try:
                found = self.completed(angles)
            except SingularError as error:
                failed = error
                continue
            # longer pulses leave fewer residuals
            if best is None or found.misfit < best.misfit:
                best, self.begin = found, angles
            if best.misfit < GOOD:
                break
            if i == patient and best.misfit > POOR and other():
                raise SingularError(
                    f"repeating flights leave residuals of {best.misfit:.3g} times the scatter from period to "
                    "period"
                )
        if best is None:
            assert failed is not None
            raise failed
        return self.curved(best)

    def completed(self, angles: _Array) -> FreeFit:
        """The flights between impacts that begin at given angles, including missing impacts."""
        # starting without impacts, these are added before the ringing, since a mode would imitate them
        ringing = angles.size > 0
        found = self.begun(angles)
        if ringing:
            found = self.pruned(self.settled(self.curved(found)))
        most = MOST_IMPACTS if not ringing else angles.size + MISSING * self.data.k
        while found.misfit > GOOD and found.data.angles.size < most:
            more = self.one_more(found, ringing)
            if more is None:
                break
            found = more
        if not ringing and found.data.angles.size:
            found = self.pruned(self.settled(self.curved(found)))
        return found

    def one_more(self, found: FreeFit, ringing: bool) -> FreeFit | None:
        """The fit with another impact where it reduces the residuals most, if the reduction is considerable."""
        own = ~found.pulse
        grid = self.fold.angles[own][:: max(1, np.count_nonzero(own) // 200)]
        responses = predicted(
            self.data, self.fold.angles[own], self.data.order, found.omega, found.xi, found.static, found.phase,
            grid,
            np.zeros(grid.size),
        ).jumps / self.errors[own][:, None]  # fmt: skip
        weight = (responses**2).sum(axis=0)
        gain = (responses.T @ found.left[own]) ** 2 / np.maximum(weight, 1e-300)
        angle = float(grid[int(np.argmax(gain))])
        four, angles, jumps, offset, modes = self.point(found)
        modes = [Ringing(mode.pole, np.append(mode.size, 0.0)) for mode in modes]
        before, after = self.lengths(found)
        angles = np.append(angles, angle)
        pulse = self.pulses(angles, np.append(before, 0.3e-3), np.append(after, 1e-3))
        try:
            more = self.settled(
                self.fit((four, angles, np.append(jumps, 0.0), offset, modes), pulse), ringing
            )
            more = self.pruned(more)
        except SingularError:
            return None
        if more.data.angles.size <= found.data.angles.size:
            return None
        gain = found.misfit - more.misfit
        if gain < LEAST_SHARE * (found.misfit - 1) or gain * more.freedom < LEAST_GAIN:
            return None
        return more


def beside(found: FreeFit) -> _Array:
    """Orthonormal directions of the components that are projected out: offset and ringing."""
    data = found.data
    columns = [np.ones((data.places.size, 1))]
    ages = Ages(data, data.places, data.angles)
    for mode in found.modes:
        columns.append(rung(data, ages, mode)[1]())
    together = np.hstack(columns) / data.errors[:, None]
    together /= np.maximum(np.linalg.norm(together, axis=0), 1e-300)
    U, s, _ = np.linalg.svd(together, full_matrices=False)
    basis: _Array = U[:, s > 1e-9 * s[0]]
    return basis
