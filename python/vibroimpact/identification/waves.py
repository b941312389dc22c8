"""The motion of the primary mass between periodic impacts, and modes that ring after these, as damped waves.

Angles are load phases Omega t. The data of a record that such a motion describes are in `Measured`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..systems.oscillator import Pattern
from .forced import Forced

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]


@dataclass
class Measured:
    """The data of one record: its motion outside the pulses, and the load.

    Angles are Omega t with t = 0 in the middle of the record.
    """

    #: Load frequency, radians per second.
    Omega: float
    #: Load cycles in a period.
    k: int
    #: (N) Angles Omega t of the impacts from 0 to below 2 pi k, and their errors; changes of velocity.
    angles: _Array = field(default_factory=lambda: np.empty(0))
    angle_errors: _Array = field(default_factory=lambda: np.empty(0))
    jumps: _Array = field(default_factory=lambda: np.empty(0))
    #: (N) Errors of the changes of velocity.
    jump_errors: _Array = field(default_factory=lambda: np.empty(0))
    #: (n) Angles outside the pulses, the motion there, and its errors; empty without a record.
    places: _Array = field(default_factory=lambda: np.empty(0))
    values: _Array = field(default_factory=lambda: np.empty(0))
    errors: _Array = field(default_factory=lambda: np.empty(0))
    #: The factor by which its noise is stronger at low frequencies, and the factor by which its parts differ
    #: beyond that, as ratios of variances.
    colour: float = 1.0
    drift: float = 1.0
    #: Relative standard error of the calibration of the motion; that of the load is part of its error.
    calibration: float = 0.0
    #: The order of the derivative of the displacement that was recorded.
    order: int = 2
    #: Duration of the contacts by the shape of their pulses (s), and the highest angular frequency (rad/s) at
    #: which the sensor does not change this shape.
    contact: float = 0.0
    passed: float = math.inf
    #: Poles of the low-pass of the sensor (rad/s), if it is known.
    lowpass: _Complex = field(default_factory=lambda: np.empty(0, dtype=np.complex128))
    #: (n, q) Orthonormal directions, relative to the errors, of the components that are projected out: offset and
    #: ringing.
    beside: _Array = field(default_factory=lambda: np.empty((0, 0)))
    #: Load phase at t = 0 and its error (None: not known), and amplitude and its error (N).
    phase: float | None = None
    phase_error: float = 0.0
    F0: float | None = None
    F0_error: float = 0.0
    #: (n) Harmonics of the load (multiples of Omega), and the load over F0 sin(Omega t + phase) there.
    orders: _Array = field(default_factory=lambda: np.ones(1))
    shape: _Complex = field(default_factory=lambda: np.array([-1j]))
    #: The load if it is not a sum of harmonics: then there are no `orders`, and Omega is its mean frequency.
    forced: Forced | None = None
    #: Walls of the impacts of a period, in the order of the angles.
    sides: str = ""

    @property
    def pattern(self) -> Pattern:
        """The pattern of the impacts."""
        return Pattern(self.sides, self.k)


class Ages:
    """The times since the latest impacts, for given angles of samples and of the impacts of a period."""

    def __init__(self, data: Measured, places: _Array, angles: _Array) -> None:
        whole, n = 2 * math.pi * data.k, places.size
        at = angles % whole
        begins = np.sort(at)
        #: Beginning and end of the samples after each impact in the order of the angles, the last one of the
        #: previous period first; None for samples in another order.
        self.edges: list[int] | None = None
        if n and places[0] >= 0 and places[-1] < whole and (places[1:] >= places[:-1]).all():
            self.edges = [0, *np.searchsorted(places, begins).tolist(), n]
            latest = np.repeat(np.arange(begins.size + 1), np.diff(self.edges))
        else:
            places = places % whole
            latest = np.searchsorted(begins, places, side="right")
        begins = np.concatenate([begins[-1:], begins]) if begins.size else np.zeros(1)
        #: (N + 1, N) Times from all impacts to each latest one (s).
        self.gaps = (begins[:, None] - at) % whole / data.Omega
        begins[0] -= whole
        #: (n) Number of the latest impact, and time since then.
        self.latest, self.times = latest, (places - begins[latest]) / data.Omega


class Waves:
    """Damped waves exp(pole t) that begin at the impacts of each period.

    Between impacts, all of them rotate and decay together. Each is therefore the wave that begins at the
    latest impact, times its own value there.
    """

    def __init__(self, ages: Ages, pole: complex) -> None:
        self.ages = ages
        #: (N + 1, N) The waves at each latest impact.
        self.turned = np.exp(pole * ages.gaps)
        fade, turn = np.exp(pole.real * ages.times), pole.imag * ages.times
        #: (n, 2) Real and negative imaginary part of the wave since the latest impact.
        self.wave = np.empty((fade.size, 2))
        np.multiply(fade, np.cos(turn), out=self.wave[:, 0])
        np.multiply(-fade, np.sin(turn), out=self.wave[:, 1])

    def sums(self, sizes: Any) -> tuple[_Complex, _Complex]:
        """Sums of all waves with given sizes (N) at each latest impact, and those of the waves times their
        ages."""
        each = self.turned * sizes
        return each.sum(axis=1), (each * self.ages.gaps).sum(axis=1)

    def real(self, sizes: Any, out: _Array | None = None) -> _Array:
        """The real part of the wave since the latest impact times sizes there (N + 1, m), at all samples
        (n, m)."""
        out = np.empty((self.wave.shape[0], sizes.shape[1])) if out is None else out
        parts = np.empty((sizes.shape[0], 2, sizes.shape[1]))
        parts[:, 0], parts[:, 1] = sizes.real, sizes.imag
        edges, latest = self.ages.edges, self.ages.latest
        if edges is None:
            out[:] = self.wave[:, :1] * parts[latest, 0]
            out += self.wave[:, 1:] * parts[latest, 1]
            return out
        for own, a, b in zip(parts, edges[:-1], edges[1:], strict=True):
            np.matmul(self.wave[a:b], own, out=out[a:b])
        return out


class Predicted:
    """A derivative of the displacement of a damped oscillator under the load and periodic impulses at given
    angles, and its derivatives, which are computed only where they are used."""

    def __init__(
        self, data: Measured, places: _Array, order: int, omega: float, xi: float, static: float, phase: float,
        angles: _Array, jumps: _Array, turns: _Array,
    ) -> None:  # fmt: skip
        self.data, self.jumps_of, self.turns = data, jumps, turns
        self.at = order, omega, xi
        # after unit impulses, one in each period
        rate = math.sqrt(1 - xi**2)
        self.pole = pole = omega * complex(-xi, rate)
        self.whole = 2 * math.pi * data.k / data.Omega
        self.waves = Waves(Ages(data, places, angles), pole)
        self.q = np.exp(pole * self.whole)
        self.size = pole**order / (1 - self.q) / (omega * rate)
        self.sums, self.moments = self.waves.sums(self.size * jumps)
        moved = self.waves.real(-1j * self.sums[:, None])[:, 0]
        self.load = of_load(data, order, omega, xi, static, phase)
        self.value: _Array = self.load[0] @ turns + moved

    @cached_property
    def by_system(self) -> _Array:
        """Derivatives with respect to omega, xi, static and phase (n, 4)."""
        order, omega, xi = self.at
        pole, q, sums, rate = self.pole, self.q, self.sums, math.sqrt(1 - xi**2)
        # of the sum of all waves, by their pole
        by_pole = (order / pole + self.whole * q / (1 - q)) * sums + self.moments
        by_omega, by_xi = pole / omega, omega * complex(-1, -xi / rate)
        parts = [
            by_pole * by_omega - sums / omega, by_pole * by_xi + sums * xi / rate**2,
            sums * by_omega, sums * by_xi,
        ]  # fmt: skip
        each = self.waves.real(-1j * np.stack(parts, axis=1))
        found: _Array = (self.load[1:] @ self.turns).T
        found[:, :2] += each[:, :2] + self.waves.ages.times[:, None] * each[:, 2:]
        return found

    @property
    def omega(self) -> _Array:
        """Derivatives with respect to omega."""
        return self.by_system[:, 0]

    @property
    def xi(self) -> _Array:
        """Derivatives with respect to xi."""
        return self.by_system[:, 1]

    @property
    def sizes(self) -> _Complex:
        """Sizes of the waves in the derivatives with respect to angles and jumps (N + 1, 2N)."""
        sizes = -1j * self.size * self.waves.turned
        return np.hstack([sizes * (-self.pole / self.data.Omega * self.jumps_of), sizes])

    def by_impacts(self, out: _Array) -> None:
        """Put the derivatives with respect to the angles of the impacts, then the jumps, into an array (n, 2N)."""
        self.waves.real(self.sizes, out)

    def along(self, by: _Array) -> _Array:
        """Derivatives with respect to parameters (n, P), from those of the angles and jumps (2, N, P)."""
        return self.waves.real(self.sizes @ by.reshape(-1, by.shape[-1]))

    @property
    def angles(self) -> _Array:
        """Derivatives with respect to the angles of the impacts (n, N)."""
        return self.waves.real(self.sizes[:, : self.jumps_of.size])

    @property
    def jumps(self) -> _Array:
        """Derivatives with respect to the jumps (n, N)."""
        return self.waves.real(self.sizes[:, self.jumps_of.size :])


def since(places: _Array, angles: _Array, data: Measured) -> _Array:
    """Times since the latest impacts, for given angles of impacts and of samples (n, N), s."""
    passed: _Array = ((places[:, None] - angles) % (2 * math.pi * data.k)) / data.Omega
    return passed


def turns_of(data: Measured, places: _Array) -> _Array:
    """Cosines, then sines, of the harmonics of the load at given angles (2 harmonics, n)."""
    turns = np.outer(data.orders, places)
    return np.vstack([np.cos(turns), np.sin(turns)])


def of_load(
    data: Measured, order: int, omega: float, xi: float, static: float, phase: float
) -> _Array:
    """A derivative of the displacement of a damped oscillator under the load alone, and its derivatives with
    respect to omega, xi, static and phase, as coefficients of the rows of `turns_of` (5, 2 harmonics)."""
    w = data.orders * data.Omega
    below = omega**2 - w**2 + 2j * xi * omega * w
    each = data.shape * np.exp(1j * data.orders * phase) * omega**2 * (1j * w) ** order / below
    sizes = np.array(
        [
            static * each, static * each * (2 / omega - (2 * omega + 2j * xi * w) / below),
            -static * each * 2j * omega * w / below, each, static * 1j * data.orders * each,
        ]
    )  # fmt: skip
    return np.hstack([sizes.real, -sizes.imag])


def predicted(
    data: Measured, places: _Array, order: int, omega: float, xi: float, static: float, phase: float, angles:
    _Array,
    jumps: _Array, turns: _Array | None = None,
) -> Predicted:  # fmt: skip
    """A derivative of the displacement of a damped oscillator under the load and periodic impulses; `turns` are
    those of the places, if they are known."""
    turns = turns_of(data, places) if turns is None else turns
    return Predicted(data, places, order, omega, xi, static, phase, angles, jumps, turns)


@dataclass
class Ringing:
    """A mode that rings after the impacts: its pole, and amplitudes at the impacts (N, complex)."""

    pole: complex
    size: _Complex


def rung(data: Measured, ages: Ages, mode: Ringing) -> tuple[_Array, Callable[[], _Array]]:
    """The ringing at given ages, and a function that returns its derivatives with respect to real and imaginary
    parts of the amplitudes and of the pole."""
    whole = 2 * math.pi * data.k / data.Omega
    waves = Waves(ages, mode.pole)
    q = np.exp(mode.pole * whole)
    sums, moments = waves.sums(mode.size / (1 - q))

    def derivatives() -> _Array:
        sizes = waves.turned / (1 - q)
        out = np.empty((ages.times.size, 2 * mode.size.size + 2))
        waves.real(np.hstack([sizes, 1j * sizes]), out[:, :-2])
        by_pole = moments + whole * q / (1 - q) * sums
        each = waves.real(np.stack([by_pole, 1j * by_pole, sums, 1j * sums], axis=1))
        out[:, -2:] = each[:, :2] + ages.times[:, None] * each[:, 2:]
        return out

    return waves.real(sums[:, None])[:, 0], derivatives
