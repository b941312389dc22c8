"""Response quantities of motions and trajectories, by closed forms between the impacts.

Between two events x and all that is linear in it have the form ``Re(sum_j c_j exp(s_j t))`` with one exponent of
the load and one of the free vibration. Integrals of such signals and of their products are sums of
``(exp(s T) - 1)/s``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError

if TYPE_CHECKING:
    from ..systems.oscillator import Oscillator

__all__ = ["Quantities", "Signal"]

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Points in a radian of the faster of load and free vibration, between which extremes are enclosed.
POINTS = 8
#: Largest number of points at once.
MOST = 1_000_000
#: Columns of the impacts.
IMPACT_TYPE = np.dtype([
    ("time", "f8"), ("side", "U1"), ("speed", "f8"), ("impulse", "f8"), ("loss", "f8"), ("jump", "f8"),
])  # fmt: skip


def plain(values: Any) -> Any:
    """An array, or a number as a float."""
    return values if np.ndim(values) else float(values)


@dataclass(frozen=True, eq=False)
class Signal:
    """One quantity over the window of `Quantities`; arrays (n,) with the coordinates of a structure.

    Attributes
    ----------
    mean, rms : float
        Mean value, and root of the mean square (with the mean).
    least, greatest : float
        Extremes, with both sides of each jump.
    harmonics : ndarray (H,) of complex
        c_h, where the part of h times the load frequency is ``Re(c_h exp(i h phi))`` at the load phase phi.
    """

    mean: Any
    rms: Any
    least: Any
    greatest: Any
    harmonics: _Complex

    @property
    def peak(self) -> Any:
        """The greatest magnitude."""
        return plain(np.maximum(-self.least, self.greatest))

    @property
    def amplitude(self) -> Any:
        """Amplitude of the fundamental."""
        return plain(np.abs(self.harmonics[..., 0]))

    @property
    def phase(self) -> Any:
        """Phase by which the fundamental leads the load sin(phi), from -pi to pi: it is
        ``amplitude sin(phi + phase)``."""
        return plain(np.angle(1j * self.harmonics[..., 0]))


@dataclass(frozen=True, eq=False, repr=False)
class Quantities:
    """Response quantities over a window of time, exact but for rounding (relative to A). Lengths in F0/K,
    time in 1/omega, forces in F0.

    Attributes
    ----------
    duration : float
        Length of the window; of a motion its period.
    cycles : float
        Load cycles in the window.
    x, x_dot, x_ddot : Signal
        Displacement, velocity and acceleration of the primary mass. Extremes and rms of the acceleration are
        those between the impacts. Its mean and harmonics contain the impulses of the impacts: the acceleration of
        a rigid mass has a spike there, whose area is the change of velocity.
    transmitted : Signal
        Force on the base, K X + C X'.
    impacts : structured ndarray
        ``time``, ``side``, ``speed`` (of approach), ``impulse`` (between the masses, > 0), ``loss`` (of energy)
        and ``jump`` (of the acceleration of the primary mass). Of impacts that accumulate, the last and
        smallest are not listed; energies and harmonics contain them.
    work : float
        Energy that the load puts in.
    damping_loss, impact_loss : float
        Energy that the dashpot and the impacts take.
    energy_change : float
        Energy of both masses and of the spring at the end less that at the start; 0 for a motion, and in any case
        ``work - damping_loss - impact_loss``.
    """

    duration: float
    cycles: float
    x: Signal
    x_dot: Signal
    x_ddot: Signal
    transmitted: Signal
    impacts: NDArray[Any]
    work: float
    damping_loss: float
    impact_loss: float
    energy_change: float
    #: The unit of each, in the dimensionless ones.
    units: ClassVar[dict[str, str]] = {
        "duration": "1/omega", "x": "F0/K", "x_dot": "omega F0/K", "x_ddot": "omega^2 F0/K",
        "transmitted": "F0", "time": "1/omega", "speed": "omega F0/K", "impulse": "F0/omega",
        "loss": "F0^2/K", "jump": "omega^2 F0/K", "work": "F0^2/K", "damping_loss": "F0^2/K",
        "impact_loss": "F0^2/K", "energy_change": "F0^2/K",
    }  # fmt: skip

    def __repr__(self) -> str:
        return (
            f"<Quantities over {self.cycles:.6g} load cycles: x rms {self.x.rms:.6g}, peak {self.x.peak:.6g}; "
            f"acceleration rms {self.x_ddot.rms:.6g}, peak {self.x_ddot.peak:.6g}; {len(self.impacts)} impacts>"
        )


@dataclass(frozen=True, eq=False)
class Segments:
    """Segments between events: start times, durations, load phases, the exponents (2, n) in time of load and free
    vibration, and the coefficients (2, n) of x."""

    start: _Array
    duration: _Array
    phase: _Array
    rates: _Complex
    x: _Complex


def segments_of(
    osc: Oscillator, r: float, load: float, starts: _Array, resting: NDArray[np.int32], end: float
) -> Segments:
    """The closed form of the segments that begin at some states (6, n), the last of which ends at `end`."""
    start, phase, x, x_dot = starts[:4]
    mass = np.where(resting != 0, 1 + osc.mu, 1.0)
    decay = osc.xi / mass
    free = -decay + 1j * np.sqrt(1 / mass - decay**2)
    rates = np.stack([np.full(len(start), 1j * r), free])
    forced = -1j * load * np.exp(1j * phase) / (1 - mass * r**2 + 2j * osc.xi * r)
    # Re(forced + own) = x and Re(i r forced + free own) = x'
    real = x - forced.real
    own = real - 1j * (x_dot - (1j * r * forced).real - free.real * real) / free.imag
    return Segments(start, np.diff(start, append=end), phase, rates, np.stack([forced, own]))


def integral(rate: _Complex, duration: _Array) -> _Complex:
    """The integral of exp(rate t) from 0 to the duration."""
    zero = rate == 0
    return np.where(zero, duration, np.expm1(rate * duration) / np.where(zero, 1, rate))


def product(parts: Segments, u: _Complex, v: _Complex) -> float:
    """The integral of the product of two signals over all segments."""
    total = 0.0
    for a, rate in zip(u, parts.rates, strict=True):
        for b, other in zip(v, parts.rates, strict=True):
            both = a * b * integral(rate + other, parts.duration)
            both += a * b.conj() * integral(rate + other.conj(), parts.duration)
            total += 0.5 * math.fsum(both.real)
    return total


def extremes(parts: Segments, u: _Complex, r: float) -> tuple[float, float]:
    """The least and the greatest value of a signal, with both ends of each segment."""
    values = np.concatenate(turns(parts, u, r)[1:])
    return float(values.min()), float(values.max())


def turns(parts: Segments, u: _Complex, r: float) -> tuple[_Array, _Array, _Array]:
    """The times at which the derivative of a signal vanishes, the values there, and those at ends of segments."""
    # where rest begins at the instant of an impact, no flight lies in between
    real = parts.duration > 0 if parts.duration.any() else slice(None)
    u, rates, duration, start = (
        u[:, real],
        parts.rates[:, real],
        parts.duration[real],
        parts.start[real],
    )
    many = 2 + np.ceil(POINTS * max(1.0, r) * duration).astype(np.int64)
    if many.max(initial=0) > 10 * MOST:
        raise ParameterError(
            f"flight of {duration.max():.6g} without an event: must be at most "
            f"{10 * MOST / POINTS / max(1.0, r):.6g} for its extremes"
        )
    found = []
    blocks = np.searchsorted(np.cumsum(many), np.arange(0, many.sum(), MOST), side="right")
    for here in np.split(np.arange(len(many)), np.unique(blocks)):
        if here.size:
            place, *rest = stationary(u[:, here], rates[:, here], duration[here], many[here])
            found.append((start[here][place] + rest[0], *rest[1:]))
    times, values, ends = (np.concatenate(each) for each in zip(*found, strict=True))
    return times, values, ends


def stationary(
    u: _Complex, rates: _Complex, duration: _Array, many: NDArray[np.int64]
) -> tuple[NDArray[np.int64], _Array, _Array, _Array]:
    """Where the derivatives of signals vanish: numbers of the segments, times from their starts, and values there;
    and the values at both ends of all segments.

    The derivative has at most one zero between neighbouring points, or two about a zero of its own derivative.
    """
    place = np.repeat(np.arange(len(many)), many)
    first = np.cumsum(many) - many
    step = (duration / (many - 1))[place]
    t = (np.arange(len(place)) - first[place]) * step
    t = np.minimum(t, duration[place])

    def value(order: int, where: NDArray[np.int64], time: _Array) -> _Array:
        rate = rates[:, where]
        return np.asarray((u[:, where] * rate**order * np.exp(rate * time)).sum(axis=0).real)

    def zeros(order: int, where: NDArray[np.int64], left: _Array, right: _Array) -> _Array:
        begin = value(order, where, left)
        for _ in range(40):
            middle = 0.5 * (left + right)
            same = value(order, where, middle) * begin > 0
            left, right = np.where(same, middle, left), np.where(same, right, middle)
        return 0.5 * (left + right)

    inner = np.flatnonzero(place[1:] == place[:-1])
    slope, curve = value(1, place, t), value(2, place, t)
    bent = inner[(curve[inner] * curve[inner + 1] < 0) & (slope[inner] * slope[inner + 1] > 0)]
    turns = zeros(2, place[bent], t[bent], t[bent + 1])
    place, t = np.append(place, place[bent]), np.append(t, turns)
    order = np.lexsort((t, place))
    place, t = place[order], t[order]
    slope = value(1, place, t)
    inner = np.flatnonzero((place[1:] == place[:-1]) & (slope[1:] * slope[:-1] <= 0))
    found = zeros(1, place[inner], t[inner], t[inner + 1])
    each = np.arange(len(many))
    ends = np.concatenate([value(0, each, np.zeros(len(many))), value(0, each, duration)])
    return place[inner], found, value(0, place[inner], found), ends


def signal(parts: Segments, u: _Complex, r: float, harmonics: int) -> Signal:
    """A signal with the coefficients u (2, n)."""
    whole = math.fsum(parts.duration)
    low, high = extremes(parts, u, r)
    if whole == 0:
        value = float(u.sum(axis=0).real[-1])
        return Signal(value, abs(value), low, high, np.full(harmonics, np.nan + 0j))
    mean = sum(
        math.fsum((a * integral(rate, parts.duration)).real)
        for a, rate in zip(u, parts.rates, strict=True)
    )
    amplitudes = np.empty(harmonics, dtype=np.complex128)
    for h in range(1, harmonics + 1):
        back, total = -1j * h * r, 0j
        for a, rate in zip(u, parts.rates, strict=True):
            part = a * integral(rate + back, parts.duration)
            part += a.conj() * integral(rate.conj() + back, parts.duration)
            total += (part * np.exp(-1j * h * parts.phase)).sum()
        amplitudes[h - 1] = total / whole
    amplitudes.flags.writeable = False
    square = max(0.0, product(parts, u, u) / whole)
    return Signal(mean / whole, math.sqrt(square), low, high, amplitudes)


def quantities_of(
    osc: Oscillator, r: float, load: float, starts: _Array, resting: NDArray[np.int32], end: float,
    last: tuple[float, float, float] | None, events: NDArray[Any], harmonics: Any,
) -> Quantities:  # fmt: skip
    """The quantities of some segments.

    Parameters
    ----------
    starts, resting, end
        As of `segments_of`; z and z' are the last two rows of `starts`.
    last : (float, float, float) or None
        x, x' and z' at the end; None for a period of a motion, which ends as it begins.
    events : structured ndarray
        The events that begin the segments; without the first one, unless it is a period.
    """
    harmonics = checks.integer(harmonics, "harmonics", 1, 10_000)
    parts = segments_of(osc, r, load, starts, resting, end)
    rates, xi, mu = parts.rates, osc.xi, osc.mu
    velocity = rates * parts.x
    signals = [
        signal(parts, u, r, harmonics)
        for u in (parts.x, velocity, rates * velocity, (1 + 2 * xi * rates) * parts.x)
    ]
    x, x_dot, x_ddot, transmitted = signals
    # between two segments the velocity changes by all impacts there; the end of an accumulation, of which
    # not all impacts are events, too
    before, after = (velocity * np.exp(rates * parts.duration)).sum(axis=0).real, starts[3]
    z_before, z_after, phase = starts[5], starts[5], parts.phase
    if last is None:
        before, z_before = np.roll(before, 1), np.roll(z_before, 1)
    else:
        before, z_before = before[:-1], z_before[:-1]
        after, z_after, phase = after[1:], z_after[1:], phase[1:]
    whole, orders = math.fsum(parts.duration), np.arange(1, harmonics + 1)
    change = after - before
    if whole > 0:
        full = x_ddot.harmonics + 2 / whole * (np.exp(-1j * np.outer(orders, phase)) @ change)
        full.flags.writeable = False
        x_ddot = replace(x_ddot, mean=x_ddot.mean + float(change.sum()) / whole, harmonics=full)
    share = mu / (1 + mu)
    ended = events["kind"] == "stick"
    rest_loss = 0.5 * ((before**2 - after**2) + mu * (z_before**2 - z_after**2))[ended]
    hits = events[events["kind"] == "impact"]
    speed = np.abs(hits["z_dot_before"] - hits["x_dot_before"])
    parting = np.abs(hits["z_dot_after"] - hits["x_dot_after"])
    loss = 0.5 * share * (speed - parting) * (speed + parting)
    impacts = np.empty(len(hits), dtype=IMPACT_TYPE)
    for name, values in {
        "time": hits["time"], "side": hits["side"], "speed": speed, "impulse": share * (speed + parting),
        "loss": loss, "jump": 2 * xi * (hits["x_dot_before"] - hits["x_dot_after"]),
    }.items():  # fmt: skip
        impacts[name] = values
    impacts.flags.writeable = False
    forcing = np.stack([-1j * load * np.exp(1j * parts.phase), np.zeros(len(parts.phase))])
    energies = [
        0.5 * (a**2 + b**2 + mu * c**2)
        for a, b, c in ((starts[2, 0], starts[3, 0], starts[5, 0]), last or (0.0, 0.0, 0.0))
    ]
    return Quantities(
        whole, whole * r / (2 * math.pi), x, x_dot, x_ddot, transmitted, impacts,
        product(parts, forcing, velocity), 2 * xi * product(parts, velocity, velocity),
        math.fsum([*loss, *rest_loss]), 0.0 if last is None else float(energies[1] - energies[0]),
    )  # fmt: skip
