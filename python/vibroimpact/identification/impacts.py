"""The impacts of a period from the harmonics of the motion, refined below the sample."""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, SingularError
from .harmonics import Measured
from .known import HINT
from .least_squares import levenberg

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: A fit of impulses is good below this misfit; jumps below this share of the largest one are none; an impact
#: more has to take so much from the sum of squares, and this share of it; and the largest number of impacts in
#: a load cycle.
GOOD, WEAK = 4.0, 0.02
LEAST_GAIN, LEAST_SHARE = 40.0, 0.15
#: Misfit above which impulses explain nothing.
HOPELESS = 200.0
#: Relative error of the acceleration of a free mass for that of one on a spring, times w/omega.
BOUND = 0.05
MOST_IMPACTS = 12
#: Modes from which a fit starts where the harmonics do not tell one.
LIKELY = 4


class Refined(NamedTuple):
    """Impacts refined below the sample, and the mode that rings (None: none does)."""

    angles: _Array
    errors: _Array
    jumps: _Array
    ring: _Array | None
    #: Sum of squares of the weighted residuals, and the degrees of freedom.
    square: float
    freedom: int
    #: What is left of the harmonics, over their errors, in the order of `Impulses`.
    left: _Complex

    @property
    def misfit(self) -> float:
        """Sum of squares over the degrees of freedom."""
        return self.square / max(1, self.freedom)


def resonance(frequencies: _Array, ring: _Array) -> tuple[_Complex, _Complex, _Complex]:
    """Acceleration of a mode for an impulse that changes its velocity by 1, and its derivatives by frequency and
    damping of the mode."""
    w, zeta = ring[0], ring[1]
    below = frequencies**2 - w * w - 2j * zeta * w * frequencies
    value = frequencies**2 / below
    by_w = value / below * (2 * w + 2j * zeta * frequencies)
    by_zeta = value / below * 2j * w * frequencies
    return value, by_w, by_zeta


class Impulses:
    """The harmonics above the third of the load, as those of impulses on a mass that is nearly free there."""

    def __init__(self, data: Measured, omega: float) -> None:
        above = data.orders >= 3 * data.k
        self.frequencies = data.frequencies[above]
        self.values = data.values[above]
        # the mass is not quite free: damping, and a natural frequency that is known roughly
        self.errors = np.hypot(
            data.errors[above], BOUND * omega / self.frequencies * abs(self.values)
        )
        self.orders = data.orders[above] / data.k
        self.free = (self.frequencies**2 / (self.frequencies**2 - omega**2)).astype(np.complex128)
        self.scale = data.Omega / (math.pi * data.k)
        self.Omega, self.k = data.Omega, data.k

    @property
    def most(self) -> int:
        """Largest number of impacts that so many harmonics determine."""
        return (2 * self.orders.size - 8) // 2

    def each(self, angles: _Array) -> _Complex:
        """The harmonics of impulses of 1 (n, N)."""
        shape: _Complex = self.scale * np.exp(-1j * np.outer(self.orders, angles))
        return shape

    def residuals(self, x: _Array, N: int, used: slice) -> tuple[_Array, _Array]:
        """Residuals over errors, and their derivatives by angles, jumps and ringing."""
        angles, jumps = x[:N], x[N : 2 * N]
        orders, each = self.orders[used], self.each(angles)[used]
        response = self.free[used]
        total = each @ jumps
        more = []
        if x.size > 2 * N:
            if not (0 < x[2 * N] < 2 * self.frequencies[-1] and 0 < x[2 * N + 1] < 0.5):
                raise SingularError("no mode rings so")
            value, by_w, by_zeta = resonance(self.frequencies[used], x[2 * N :])
            share = x[2 * N + 2]
            response = response + share * value
            more = [share * by_w * total, share * by_zeta * total, value * total]
        blocks = [-1j * orders[:, None] * each * jumps, each]
        J = np.column_stack([*(block * response[:, None] for block in blocks), *more])
        f = response * total - self.values[used]
        w = 1 / self.errors[used]
        return np.concatenate([f.real * w, f.imag * w]), np.vstack(
            [J.real * w[:, None], J.imag * w[:, None]]
        )

    def jumps_at(self, angles: _Array, used: slice) -> _Array:
        """Jumps by linear least squares."""
        each = self.each(angles)[used] * self.free[used, None] / self.errors[used, None]
        right = self.values[used] / self.errors[used]
        stacked = np.vstack([each.real, each.imag])
        found: _Array = np.linalg.lstsq(
            stacked, np.concatenate([right.real, right.imag]), rcond=None
        )[0]
        return found

    def peak(self) -> float:
        """The frequency at which harmonics stand out most from their neighbours."""
        size = abs(self.values)
        smooth = np.convolve(size, np.ones(2 * self.k + 1), "same")
        wide = 12 * self.k
        background = [np.median(smooth[max(0, i - wide) : i + wide + 1]) for i in range(size.size)]
        return float(self.frequencies[np.argmax(smooth / np.maximum(background, 1e-300))])

    def refined(self, angles: _Array, ring: _Array | None, near: bool = False) -> Refined:
        """Angles, jumps and ringing by least squares from approximate angles; of several starts the best one.

        By few harmonics first, unless both are `near`, since these do not hold the mode.
        """
        N, n = angles.size, self.orders.size
        few = slice(0, min(n, max(2 * N + 4, n // 4)))
        peak = self.peak()
        starts = [np.empty(0)]
        if ring is not None:
            starts.append(ring)
        else:
            spacing = self.Omega / self.k
            starts += [np.array([peak + shift * spacing, 0.02, 0.2]) for shift in (-0.4, 0.0, 0.4)]
        best: Refined | None = None
        for begin in starts:
            x = np.concatenate([angles, self.jumps_at(angles, few), begin])
            size = max(float(abs(x[N : 2 * N]).max()), 1e-300)
            scales = np.concatenate(
                [np.full(N, 0.01), np.full(N, 0.1 * size), [0.005 * peak, 0.005, 0.1][: begin.size]]
            )
            for used in (slice(0, n),) if near else (few, slice(0, n)):
                x, f, J, _ = levenberg(partial(self.residuals, N=N, used=used), x, scales)
            square, freedom = float(f @ f), f.size - x.size
            if best is not None and square > 0.9 * best.square:
                continue
            covariance = np.linalg.pinv(J.T @ J) * max(1.0, square / max(1, freedom))
            own = x[2 * N :] if begin.size else None
            best = Refined(
                x[:N],
                np.sqrt(np.diag(covariance)[:N]),
                x[N : 2 * N],
                own,
                square,
                freedom,
                -(f[:n] + 1j * f[n:]),
            )
        assert best is not None
        return best

    def next_angle(self, left: _Complex) -> float:
        """Where one more impulse takes most of what is left."""
        return self.strongest(left * self.free.real / self.errors)

    def strongest(self, matched: _Complex) -> float:
        """The angle at which harmonics add up to most."""
        size = 16 * int(self.orders[-1] * self.k)
        spectrum = np.zeros(size, dtype=np.complex128)
        spectrum[np.rint(self.orders * self.k).astype(int)] = matched
        gain = np.fft.ifft(spectrum).real
        return float(2 * math.pi * self.k * np.argmax(abs(gain)) / size)

    def pursued(self, ring: _Array, count: int) -> tuple[float, _Array]:
        """Angles of impulses after which a given mode rings, taken one by one, and the sum of squares left."""
        response = (self.free + ring[2] * resonance(self.frequencies, ring)[0]) / self.errors
        target = self.values / self.errors
        left, angles = target, np.empty(0)
        for _ in range(count):
            angles = np.append(angles, self.strongest(left * response.conj()))
            each = self.each(angles) * response[:, None]
            stacked = np.vstack([each.real, each.imag])
            flat = np.concatenate([target.real, target.imag])
            left = target - each @ np.linalg.lstsq(stacked, flat, rcond=None)[0]
        return float(np.sum(abs(left) ** 2)), angles

    def rung(self) -> list[tuple[_Array, _Array]]:
        """The most likely impulses and modes, of modes all over the band."""
        found = []
        for w in np.arange(self.frequencies[0], self.frequencies[-1], 0.25 * self.Omega):
            for share in (0.1, 0.3, 1.0):
                ring = np.array([w, 0.02, share])
                square, angles = self.pursued(ring, min(self.most, 5 * self.k))
                found.append((square, angles, ring))
        return [
            (angles, ring) for _, angles, ring in sorted(found, key=lambda one: one[0])[:LIKELY]
        ]


def refine(data: Measured, omega: float) -> Refined:
    """The impacts of a period from their approximate angles, which may lack some or have too many.

    One impact after another is added while it explains much of what is left, and those that explain little are
    taken away. Where the approximate angles lead to no good fit, none is used, and then modes all over the band.
    """
    system = Impulses(data, omega)
    if system.most < max(2, data.angles.size):
        raise ParameterError(
            f"record with {data.orders.size} harmonics for {data.angles.size} impacts in {data.k} load cycles: "
            "must have a larger sampling rate or bandwidth"
        )

    best: Refined | None = None

    def better(angles: _Array, ring: _Array | None = None) -> None:
        nonlocal best
        found = completed(system, angles, ring)
        if found is not None and (best is None or found.square < best.square):
            best = found

    for angles in (data.angles, np.empty(0)):
        if best is None or best.misfit > GOOD:
            better(angles)
    for angles, ring in system.rung() if best is None or best.misfit > HOPELESS else ():
        if best is None or best.misfit > GOOD:
            better(angles, ring)
    if best is None:
        raise SingularError("no impacts stand out from the noise of the harmonics")
    if best.misfit > HOPELESS:
        raise SingularError(
            "impacts after which one mode rings do not explain the harmonics up to "
            f"{data.frequencies[-1] / (2 * math.pi):.4g} Hz: the bandwidth or the sampling rate may be too "
            f"small; {HINT}"
        )
    return best


def completed(system: Impulses, angles: _Array, ring: _Array | None = None) -> Refined | None:
    """Impacts refined, with those that are missing and without those that are not there."""
    weights = 1 / system.errors
    found: Refined | None = None
    if angles.size:
        near = ring is not None
        found = pruned(system, system.refined(angles, ring, near), near)
    while found is None or (
        found.misfit > 1.5 and found.angles.size < min(system.most, MOST_IMPACTS * system.k)
    ):
        left = system.values * weights if found is None else found.left
        known = np.empty(0) if found is None else found.angles
        before = float(np.sum(abs(left) ** 2))
        ring = None if found is None else found.ring
        more = system.refined(np.append(known, system.next_angle(left)), ring)
        if more.angles.size > 1:
            more = pruned(system, more)
        if more.angles.size <= known.size or before - more.square < max(
            LEAST_GAIN, LEAST_SHARE * before
        ):
            break
        found = more
    return found


def pruned(system: Impulses, found: Refined, near: bool = False) -> Refined:
    """Without impacts of nearly no jump, and with one where two are nearer than harmonics can tell."""
    whole = 2 * math.pi * system.k
    apart = math.pi / system.orders[-1]
    kept = np.ones(found.angles.size, dtype=bool)
    order = np.argsort(-abs(found.jumps)).tolist()
    for place, i in enumerate(order):
        off = [
            abs(math.remainder(found.angles[i] - found.angles[j], whole))
            for j in order[:place]
            if kept[j]
        ]
        kept[i] = all(gap > apart for gap in off)
    sizes = np.median(abs(found.jumps[kept]))
    kept &= abs(found.jumps) > WEAK * sizes
    return found if kept.all() else system.refined(found.angles[kept], found.ring, near)
