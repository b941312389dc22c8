"""The response of the primary mass to a recorded load of any form, such as a swept sine or band-limited noise.

Between impacts the motion is this response and a free vibration. Each flight has its own free vibration, so that
any particular response to the load can be used, such as the one computed from the spectra of the record.
"""

from __future__ import annotations

import math
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .measured import SensorRecord
from .signals import centred, white_noise

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Highest frequency of a load, over its mean frequency and over the sampling rate, and the share by which the
#: spectrum fades beyond it.
HIGHEST, ALIASED, FADE = 12.0, 0.4, 0.25
#: Load cycles over which a record is continued at both ends until it vanishes.
ENDS = 8
#: Smallest gain of the load sensor at a frequency whose attenuation is undone.
PASSED = 0.1
#: Terms of the Taylor series from the nearest sample, of the response and of its derivatives with respect to
#: parameters.
TERMS, FEWER = 6, 3
#: Range of frequencies, over the natural frequency, in which noise of a load counts; frequencies of noise in the
#: inverse of the duration of a record, and the most of all.
RANGE, FINER, MOST_LINES = (0.05, 2.0), 1.2, 400
#: Size of steps along the imaginary axis, for derivatives.
STEP = 1e-30
#: Share of the largest line of a spectrum, and multiple of the median, above which a line is one of the load.
LINES, CLEAR = 1e-3, 30.0
#: Multiple of the highest frequency of a load above which its spectrum is noise; least number of lines of a band.
BEYOND, LEAST_LINES = 2.0, 16


class Forced:
    """The recorded load over its amplitude, and the response to it.

    Parameters
    ----------
    record : SensorRecord
        A record with a load.
    quantity : str
        The channel of the motion, with whose delay the load is used.
    Omega : float
        Mean frequency of the load (rad/s). A load earlier by a time t has the phase Omega t.
    """

    def __init__(self, record: SensorRecord, quantity: str, Omega: float) -> None:
        assert record.load is not None
        rate, n = record.rate, len(record)
        self.rate, self.Omega, self.times = rate, Omega, centred(n, rate)
        force = record.load - record.load.mean()
        # at both ends the record is continued: reflected at its last value, and faded out
        more = min(n - 1, math.ceil(ENDS * 2 * math.pi / Omega * rate))
        fade = 0.5 + 0.5 * np.cos(math.pi * np.arange(1, more + 1) / (more + 1))
        after = fade * (2 * force[-1] - force[-2 : -more - 2 : -1])
        before = fade * (2 * force[0] - force[1 : more + 1])
        size = 1 << (n + 2 * more - 1).bit_length()
        whole = np.zeros(size)
        whole[:n], whole[n : n + more], whole[size - more :] = force, after, before[::-1]
        self.size = size
        hertz = np.fft.rfftfreq(size, 1 / rate)
        highest = highest_of(Omega, rate)
        beyond = np.clip((hertz / highest - 1) / FADE, 0, 1)
        kept = 0.5 + 0.5 * np.cos(math.pi * beyond)
        sensor = record.response("load", hertz)
        kept[abs(sensor) < PASSED] = 0.0
        through = record.response(quantity, hertz)
        spectrum = np.fft.rfft(whole) * kept
        spectrum *= through / np.maximum(abs(through), 1e-300) / np.where(kept > 0, sensor, 1.0)
        self.used = np.flatnonzero(kept)
        self.w = 2 * math.pi * hertz[self.used]
        force = np.fft.irfft(self._filled(spectrum[self.used]), size)[:n]
        #: Standard deviation of the noise of a sample (N).
        self.noise = max(noise_of(record.load, rate), record.noise.get("load", 0.0))
        passed = kept[self.used] / abs(sensor[self.used])
        within = 2 * self.noise**2 * float(passed @ passed) / size
        #: Amplitude of a sine of the same power (N).
        self.F0 = math.sqrt(max(2 * (float(np.var(force)) - within), float(np.var(force))))
        self.spectrum, self.passed = spectrum[self.used] / self.F0, passed
        #: Angular frequencies and complex amplitudes of small further loads, of which `at` takes one for each row.
        self.further: tuple[_Array, _Complex] | None = None
        self._loads: list[_Array] = []
        self._known: tuple[tuple[float, float], list[list[_Array]]] | None = None

    @property
    def load(self) -> _Array:
        """The load over its amplitude, at the samples."""
        return self._signal(self.spectrum)

    def of_noise(self, omega: float) -> tuple[_Array, _Complex]:
        """Frequencies and complex amplitudes of independent loads (over F0) that together are the noise of the
        channel below twice the natural frequency, where it changes the response."""
        low, high = (share * omega for share in RANGE)
        step = max(2 * math.pi / (FINER * self.times.size / self.rate), (high - low) / MOST_LINES)
        w = np.arange(low, high, step)
        passed = np.interp(w, self.w, self.passed, left=0.0, right=0.0)
        size = self.noise / self.F0 * math.sqrt(step / (math.pi * self.rate)) * passed
        return np.repeat(w, 2), np.outer(size, [1.0, 1j]).ravel()

    def with_further(self, w: _Array, sizes: _Complex) -> Forced:
        """The same load with small further loads for derivatives with respect to their sizes."""
        other = copy(self)
        other.further = w[:, None], sizes[:, None]
        return other

    @staticmethod
    def responses(w: _Array, sizes: _Complex, order: int, omega: float, xi: float) -> _Complex:
        """Complex amplitudes of a derivative of the response, over the static displacement, to sines."""
        below = omega**2 - w**2 + 2j * xi * omega * w
        found: _Complex = sizes * omega**2 / below * (1j * w) ** order
        return found

    def _filled(self, some: _Complex) -> _Complex:
        """A spectrum with all of its lines."""
        lines = np.zeros(self.size // 2 + 1, dtype=np.complex128)
        lines[self.used] = some
        return lines

    def _signal(self, lines: _Complex) -> _Array:
        """The samples of a spectrum within the record."""
        return np.asarray(
            np.fft.irfft(self._filled(lines), self.size)[: self.times.size], dtype=np.float64
        )

    def _response(self, omega: float, xi: float) -> tuple[_Complex, _Complex, _Complex]:
        """Spectra of the displacement over the static one, and of its derivatives with respect to omega and xi."""
        below = omega**2 - self.w**2 + 2j * xi * omega * self.w
        # without damping, a line may be at the resonance
        below = np.where(abs(below) > 1e-9 * omega**2, below, 1e-9 * omega**2)
        X = self.spectrum * omega**2 / below
        return (
            X,
            X * (2 / omega - (2 * omega + 2j * xi * self.w) / below),
            -X * 2j * omega * self.w / below,
        )

    def rows(self, order: int, omega: float, xi: float, static: float, phase: float) -> _Array:
        """A derivative of the response at the samples, and its derivatives with respect to omega, xi, static and
        phase (5, n), as `of_load` gives it for a sine."""
        turn = (1j * self.w) ** order * np.exp(1j * self.w * phase / self.Omega)
        X, by_omega, by_xi = (turn * each for each in self._response(omega, xi))
        here = self._signal(X)
        return np.stack(
            [
                static * here, static * self._signal(by_omega), static * self._signal(by_xi), here,
                static * self._signal(X * 1j * self.w / self.Omega),
            ]
        )  # fmt: skip

    def _series(self, omega: float, xi: float, order: int) -> list[list[_Array]]:
        """Derivatives by time of the response, and of its derivatives with respect to omega and xi, at samples,
        for the series of a derivative of given order and the next one."""
        if self._known is None or self._known[0] != (omega, xi):
            self._known = (omega, xi), [[], [], []]
        counts = (TERMS + order + 1, FEWER + order + 1, FEWER + order + 1)
        if len(self._known[1][0]) < counts[0]:
            lines_of = self._response(omega, xi)
            for found, lines, count in zip(self._known[1], lines_of, counts, strict=True):
                for j in range(len(found), count):
                    found.append(self._signal(lines * (1j * self.w) ** j))
        return self._known[1]

    def _places(self, phase: Any, t: Any) -> tuple[NDArray[np.int64], Any]:
        """The nearest samples to times of the load, and the times from them."""
        when = np.asarray(t + phase / self.Omega)
        place = np.rint((np.nan_to_num(when.real) - self.times[0]) * self.rate)
        nearest = np.clip(place, 0, self.times.size - 1).astype(np.int64)
        return nearest, when - self.times[nearest]

    def at(
        self, omega: Any, xi: Any, static: Any, phase: Any, t: Any, order: int = 0
    ) -> tuple[Any, Any]:
        """A derivative of the response by time, and the next one, at any times within the record.

        All arguments may have a small imaginary part, for derivatives; omega and xi have one real part.
        """
        frequency, damping = (float(np.ravel(np.real(value))[0]) for value in (omega, xi))
        of_time, by_omega, by_xi = self._series(frequency, damping, order)
        place, off = self._places(phase, t)
        found = []
        for j in (order, order + 1):
            X = series(of_time, place, off, j, TERMS)
            for by, value in ((by_omega, omega), (by_xi, xi)):
                if np.iscomplexobj(value):
                    X = X + 1j * np.imag(value) * series(by, place, off.real, j, FEWER)
            if self.further is not None:
                w, sizes = self.further
                turns = np.exp(1j * w * np.real(t + phase / self.Omega))
                X = X + 1j * STEP * (self.responses(w, sizes, j, frequency, damping) * turns).real
            found.append(static * X)
        return found[0], found[1]

    def load_at(self, phase: Any, t: Any) -> Any:
        """The load over its amplitude at any times within the record."""
        if not self._loads:
            self._loads = [self._signal(self.spectrum * (1j * self.w) ** j) for j in range(TERMS)]
        return series(self._loads, *self._places(phase, t), 0, TERMS)


def series(derivatives: list[_Array], place: Any, off: Any, order: int, terms: int) -> Any:
    """The Taylor series of a derivative at times from samples."""
    total = derivatives[order + terms - 1][place]
    for j in range(terms - 1, 0, -1):
        total = derivatives[order + j - 1][place] + total * off / j
    return total


def spectrum_of(force: _Array, rate: float) -> tuple[_Array, _Array, NDArray[np.bool_]]:
    """Frequencies (Hz), the power of each line of a spectrum over that of white noise of variance 1, and the lines
    of the load, which exceed the noise."""
    window = np.hanning(force.size)
    power = abs(np.fft.rfft((force - force.mean()) * window)) ** 2 / float(window @ window)
    strong = power > max(LINES * float(power.max()), CLEAR * float(np.median(power)))
    hertz = np.asarray(np.fft.rfftfreq(force.size, 1 / rate), dtype=np.float64)
    return hertz, np.asarray(power, dtype=np.float64), strong


def mean_frequency(force: _Array, rate: float) -> float:
    """The mean angular frequency of the lines of a load, weighted by their power."""
    hertz, power, strong = spectrum_of(force, rate)
    return 2 * math.pi * float(hertz[strong] @ power[strong] / power[strong].sum())


def noise_of(force: _Array, rate: float) -> float:
    """Standard deviation of the noise of a sample, if it is white: the largest density of all octaves above the
    load, since a filter of the sensor may remove the noise at high frequencies; or from differences of samples if
    the load reaches the highest frequencies."""
    hertz, power, strong = spectrum_of(force, rate)
    found, low = [], BEYOND * float(hertz[strong].max())
    while low < hertz[-1]:
        own = power[(hertz >= low) & (hertz < 2 * low)]
        if own.size >= LEAST_LINES:
            found.append(math.sqrt(float(np.median(own)) / math.log(2)))
        low *= 2
    return max(found, default=white_noise(force))


def share_beyond(force: _Array, rate: float, Omega: float) -> float:
    """The share of a load, in amplitude, above its highest frequency, without white noise."""
    power = abs(np.fft.rfft(force - force.mean())) ** 2
    high = np.fft.rfftfreq(force.size, 1 / rate) > highest_of(Omega, rate)
    of_noise = 0.5 * force.size**2 * white_noise(force) ** 2 * float(high.mean())
    return math.sqrt(max(float(power[high].sum()) - of_noise, 0.0) / float(power.sum()))


def highest_of(Omega: float, rate: float) -> float:
    """Frequency (Hz) above which a load is cut off."""
    return min(HIGHEST * Omega / (2 * math.pi), ALIASED * rate)
