"""Records of a rig that are not made by the package, for tests of identification.

Flights of both masses are exact, by matrix exponentials of SciPy. An impact is a pulse of finite duration whose
area is the jump of the velocity of the primary mass, and a second mode rings after it. The motion sensor may have
a low-pass, which the load sensor does not have, and an offset. Or both sensors have a known low-pass, through
which an impact is the response to an ideal impulse. Or the walls are springs with dampers: then both masses move
on while they touch, only the law of the force is given, and the sensors have analogue filters of many kinds and a
converter.
"""

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.signal import (
    bessel,
    butter,
    cheby1,
    cont2discrete,
    ellip,
    freqs,
    lfilter,
    sosfilt,
    sosfreqz,
    tf2ss,
)  # fmt: skip

#: Mass and spring of the rig, which are known, and steps in a load cycle for the search for impacts.
M, K, STEPS = 0.7303, 11383.00093642085, 256
#: Approach speed (m/s) at which the law of restitution gives the restitution of the rig.
SPEED = 0.3
#: Approach speed at which compliant walls have the restitution and the contact time of the rig, steps of a
#: contact time, and least rate (Hz) of the motion before the filters.
TOUCH_SPEED, TOUCH_STEPS, FINE = 0.6, 32, 2e5
#: Low-passes by name, for a -3 dB frequency and a sampling rate; of odd order if their gain has ripples, so that
#: it is 1 at frequency 0.
FILTERS = {
    **{f"butterworth {n}": functools.partial(butter, n, output="sos") for n in (2, 4, 8)},
    "bessel": functools.partial(bessel, 4, norm="mag", output="sos"),
    "chebyshev": functools.partial(cheby1, 5, 0.5, output="sos"),
    "elliptic": functools.partial(ellip, 5, 0.2, 60, output="sos"),
}


@dataclass(frozen=True)
class Rig:
    """A rig with all its parameters: numbers in SI units; `D` is d K/F0."""

    xi: float
    mu: float
    restitution: tuple
    r: float
    F0: float
    D: float
    rate: float = 5000.0
    duration: float = 6.0
    contact: float = 4e-4
    #: Fraction of the contact time before the instant of the impact; 0.5 puts it at the centroid of the pulse.
    before: float = 0.0
    #: 1 is a half sine; larger values rise faster than they fall.
    skew: float = 1.0
    ringing: float = 430.0
    ring_decay: float = 180.0
    ring_share: float = 0.15
    noise: float = 0.01
    lowpass: float | None = None
    offset: float = 0.0
    #: Standard deviation of the gains of both sensors.
    calibration: float = 0.01
    #: Amplitudes of the 2nd, 3rd, ... harmonic of the load over F0.
    harmonics: tuple = ()
    #: Frequencies over that of the load, amplitudes over F0, and phases of the sines of another load.
    lines: tuple = ()
    #: R at an approach speed v is that of `restitution` times (v/SPEED)^-exponent.
    exponent: float = 0.0
    #: -3 dB frequency of both sensors (Butterworth, order 4), through which impulses of no duration pass.
    known_lowpass: float | None = None
    #: Relative changes during the record: the load grows (as its channel shows), the coefficients of restitution
    #: fall, and the gain of the motion sensor grows; the other numbers apply at the middle of the record.
    load_growth: float = 0.0
    fading: float = 0.0
    gain_growth: float = 0.0
    #: Dry friction of the free mass in its slot over F0; motions that stick are not made.
    friction: float = 0.0
    #: Time and state after each impact are rounded to 1e-9, far below the noise. Otherwise chaos amplifies the
    #: last bits of the linear algebra, and each kind of processor makes a different record.
    rounded: bool = False
    #: The law of the force of compliant walls, "linear" or "hunt-crossley"; "" for impacts of no duration, whose
    #: pulse is then given.
    wall: str = ""
    #: Filter of both sensors of a rig with compliant walls, of `FILTERS`, with `known_lowpass` as its -3 dB
    #: frequency, stated or not; and bits of the converter over 1.25 times the largest sample.
    filter: str = ""
    bits: int = 16

    @property
    def d(self):
        """The whole travel."""
        return self.D * self.F0 / K

    @property
    def waves(self):
        """The sines of the load: frequencies over that of the load, amplitudes over F0, and phases."""
        return self.lines or [(n, size, 0.0) for n, size in enumerate([1.0, *self.harmonics], 1)]

    @property
    def frequency(self):
        """Frequency of the load, Hz."""
        return self.r * math.sqrt(K / M) / (2 * math.pi)


def flights(rig, first, last, phase=0.0, touches=None):
    """Impacts (times, walls, jumps of the velocity of the primary mass), and states just after them.

    Impacts on compliant walls begin at their times; the list `touches` receives what `touched` returns of them.
    """
    w, omega = 2 * math.pi * rig.frequency, math.sqrt(K / M)
    # x, x', each harmonic of the load and its quadrature, z, z'
    waves = rig.waves
    slides = int(rig.friction > 0)
    A = np.zeros((4 + 2 * len(waves) + slides,) * 2)
    A[0, 1] = A[-2, -1] = 1
    A[1, :2] = -(omega**2), -2 * rig.xi * omega
    for n, (order, _, _) in enumerate(waves):
        A[1, 2 + 2 * n] = 1 / M
        A[2 + 2 * n, 3 + 2 * n], A[3 + 2 * n, 2 + 2 * n] = order * w, -order * w
        A[2 + 2 * n, 2 + 2 * n] = A[3 + 2 * n, 3 + 2 * n] = rig.load_growth / rig.duration
    drag = rig.friction * rig.F0 / M
    walls = [force_of(rig, R) for R in rig.restitution] if rig.wall else []
    if slides:
        # then the sign of the slip, which is constant
        A[1, -3], A[-1, -3] = drag, -drag / rig.mu
    step = 2 * math.pi / w / STEPS
    powers = [expm(A * step * (i + 1)) for i in range(STEPS)]
    several = np.stack(powers)
    loads = [
        rig.F0 * size * of(order * phase + begin)
        for order, size, begin in waves for of in (math.sin, math.cos)
    ]  # fmt: skip
    middle = last - rig.duration / 2
    y = np.array([0, 0, *loads, *[1.0] * slides, 0, 0.3])
    y[2 : 2 + len(loads)] *= math.exp(-rig.load_growth * middle / rig.duration)
    t, impacts, states = 0.0, [], [(0.0, y)]

    def gap(y):
        """Distance to the nearer wall."""
        return rig.d / 2 - abs(y[..., -2] - y[..., 0])

    def slip(y):
        """Velocity of the free mass in its slot."""
        return y[..., -1] - y[..., 1]

    while t < last:
        path = several @ y
        gaps = gap(path)
        hit = np.flatnonzero(gaps < 0)
        turned = np.flatnonzero(y[-3] * slip(path) < 0) if slides else hit[:0]
        if turned.size and not (hit.size and hit[0] < turned[0]):
            i = int(turned[0])
            begin = path[i - 1] if i else y
            if y[-3] * slip(begin) <= 0 or y[-3] * slip(expm(A * step) @ begin) >= 0:
                return None  # it has just reversed
            tau = brentq(lambda s, begin=begin: slip(expm(A * s) @ begin), 0, step, xtol=1e-14)
            if gap(expm(A * tau) @ begin) <= 0:
                return None
            t += i * step + tau
            y = expm(A * tau) @ begin
            driven = -(A @ y)[1] + y[-3] * drag
            if abs(driven) <= drag * (1 + 1 / rig.mu):  # it sticks
                return None
            y[-3] *= -1
            y[-1] = y[1] + 1e-12 * y[-3]
            states.append((t, y))
            continue
        if not hit.size:
            t, y = t + step * STEPS, path[-1]
            continue
        i = int(hit[0])
        begin = path[i - 1] if i else y
        low = 0.0
        if gap(begin) <= 0:  # just after an impact
            low = 1e-9
        if gap(expm(A * low) @ begin) <= 0:
            return None
        if gap(expm(A * step) @ begin) >= 0:
            return None
        tau = brentq(lambda s, begin=begin: gap(expm(A * s) @ begin), low, step, xtol=1e-14)
        t += i * step + tau
        y = expm(A * tau) @ begin
        side = 1 if y[-2] > y[0] else -1
        closing = y[-1] - y[1]
        R = rig.restitution[0 if side > 0 else 1]
        if rig.exponent:
            R = min(R * (abs(closing) / SPEED) ** -rig.exponent, 1.0)
        R *= 1 - rig.fading * max((t - middle) / rig.duration, -0.5)
        jump = rig.mu * (1 + R) * closing / (1 + rig.mu)
        if abs(closing) < 1e-3:
            return None
        if walls:
            if rig.rounded:
                t, y = round(t, 9), np.round(y, 9)
            touch = touched(rig, force_of(rig, R) if rig.fading else walls[side < 0], y, side)
            if touch is None:
                return None
            if t >= first:
                impacts.append((t, side, touch[2][-1]))
            if touches is not None:
                touches.append((t + touch[0], *touch[1:]))
            t, y = t + touch[0][-1], touch[3]
            states.append((t, y))
            continue
        y = y.copy()
        y[1] += jump
        y[-1] -= jump / rig.mu
        if rig.rounded:
            t, y = round(t, 9), np.round(y, 9)
        y[-2] = y[0] + side * rig.d / 2 * (1 - 1e-12)
        if slides:
            y[-3] = -side
        if t >= first:
            impacts.append((t, side, jump))
        states.append((t, y))
    return A, np.array(impacts), states


def force_of(rig, R):
    """The force of a compliant wall over the depth and its rate: for a linear one its stiffness and damping, for
    the law of Hunt and Crossley k p^1.5 (1 + a p') the stiffness k and a."""
    mass = rig.mu / (1 + rig.mu) * M
    if rig.wall == "linear":
        # of a free contact, which ends when the force vanishes
        def turn(zeta):
            return math.atan2(2 * zeta * math.sqrt(1 - zeta**2), 2 * zeta**2 - 1) / math.sqrt(
                1 - zeta**2
            )

        zeta = brentq(lambda z: -z * turn(z) - math.log(R), 1e-9, 0.999)
        omega = turn(zeta) / rig.contact
        return mass * omega**2, 2 * zeta * mass * omega
    # R follows from the energy that is lost: dp'/dp = -F/(m p')
    u = brentq(lambda u: math.log1p(u) - math.log1p(-u * R) - u * (1 + R), 1e-9, (1 - 1e-12) / R)
    return mass / math.sqrt(TOUCH_SPEED) * (lasting(u) / rig.contact) ** 2.5, u / TOUCH_SPEED


def restitution_at(rig, R, speed):
    """Restitution of a compliant wall at an approach speed, of masses that are free but for the contact."""
    if rig.wall == "linear":
        return R
    u = force_of(rig, R)[1] * speed
    return brentq(
        lambda R: math.log1p(u) - math.log1p(-u * R) - u * (1 + R), 1e-9, min(1, 1 / u) - 1e-12
    )


def truth(rig, impacts, v0=None):
    """Of a rig with compliant walls: the coefficients of restitution of isolated impacts, at a speed or at the
    mean speed of the impacts on each wall, and the travel between the centres of impacts, where flights meet."""
    R, travel = [], rig.d
    for one, side in zip(rig.restitution, (1, -1), strict=True):
        jumps = abs(impacts[impacts[:, 1] == side, 2]) * (1 + rig.mu) / rig.mu
        v = jumps.mean() / (1 + one)
        for _ in range(20):
            v = jumps.mean() / (1 + restitution_at(rig, one, v))
        R.append(restitution_at(rig, one, v if v0 is None else v0))
        # without a load and a spring
        free = Rig(
            xi=0.0,
            mu=rig.mu,
            restitution=(one, one),
            r=1e-6,
            F0=1.0,
            D=rig.d * K,
            contact=rig.contact,
            wall=rig.wall,
        )
        times, _, jump, _ = touched(
            free, force_of(rig, one), np.array([0, 0, 0, 0, rig.d / 2, v]), 1
        )
        travel += v * (0.5 * (times[1:] + times[:-1]) @ np.diff(jump)) / jump[-1]
    return *R, travel


@functools.cache
def lasting(u):
    """Duration of the contact p'' = -p^1.5 (1 + u p'), p' = 1 at the start."""
    R = brentq(
        lambda R: math.log1p(u) - math.log1p(-u * R) - u * (1 + R), 1e-9, min(1, 1 / u) - 1e-12
    )
    # the depth at a rate w, by the lost energy, with w = sin of an angle on the way in and out
    w = np.cos(np.linspace(0, math.pi, 20001))
    w = np.where(w > 0, w, R * w)
    # p^1.5 dp = -w dw/(1 + u w)
    deep = lambda w: (np.log1p(u * w) - u * w) / u**2 if u > 1e-6 else -0.5 * w**2  # noqa: E731
    p = (2.5 * np.maximum(deep(w) - deep(1.0), 1e-300)) ** 0.4
    middle, force = 0.5 * (w[1:] + w[:-1]), 0.5 * (p[1:] + p[:-1])
    return float(np.sum(-np.diff(w) / (force**1.5 * (1 + u * middle))))


def touched(rig, wall, y, side):
    """A contact with a compliant wall by the method of Runge and Kutta, until the depth is 0 again: times since
    its beginning, velocities of the primary mass, its jump so far by the force of the wall; and the state at the
    end. None if it lasts too long."""
    k, c = wall
    square, damping, w = K / M, 2 * rig.xi * math.sqrt(K / M), 2 * math.pi * rig.frequency
    linear, mu, half = rig.wall == "linear", rig.mu, rig.d / 2
    orders = w * np.array([order for order, _, _ in rig.waves])
    sine, cosine = y[2:-2:2] / M, y[3:-2:2] / M

    def load(since):
        return np.cos(np.outer(since, orders)) @ sine + np.sin(np.outer(since, orders)) @ cosine

    def rates(x, v, z, u, push):
        p, rate = side * (z - x) - half, side * (u - v)
        force = k * p + c * rate if linear else k * max(p, 0.0) ** 1.5 * (1 + c * rate)
        force = max(force, 0.0) / M
        return push - square * x - damping * v + side * force, -side * force / mu, force

    def stepped(now, h, first, middle, last):
        x, v, z, u, jump = now
        a, b, f = rates(x, v, z, u, first)
        v2, u2 = v + h / 2 * a, u + h / 2 * b
        a2, b2, f2 = rates(x + h / 2 * v, v2, z + h / 2 * u, u2, middle)
        v3, u3 = v + h / 2 * a2, u + h / 2 * b2
        a3, b3, f3 = rates(x + h / 2 * v2, v3, z + h / 2 * u2, u3, middle)
        v4, u4 = v + h * a3, u + h * b3
        a4, b4, f4 = rates(x + h * v3, v4, z + h * u3, u4, last)
        return (
            x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a + 2 * a2 + 2 * a3 + a4),
            z + h / 6 * (u + 2 * u2 + 2 * u3 + u4), u + h / 6 * (b + 2 * b2 + 2 * b3 + b4),
            jump + h / 6 * (f + 2 * f2 + 2 * f3 + f4),
        )  # fmt: skip

    def depth(now):
        return side * (now[2] - now[0]) - half

    h = rig.contact / TOUCH_STEPS
    pushes = load(h / 2 * np.arange(16 * TOUCH_STEPS + 1)).tolist()
    now, path = (*y[:2].tolist(), *y[-2:].tolist(), 0.0), [(0.0, y[1], 0.0)]
    for i in range(8 * TOUCH_STEPS):
        after = stepped(now, h, *pushes[2 * i : 2 * i + 3])
        if depth(after) <= 0:
            break
        now = after
        path.append(((i + 1) * h, now[1], side * now[4]))
    else:
        return None
    if not i:
        return None

    def short(h):
        return stepped(now, h, *load(path[-1][0] + h * np.array([0, 0.5, 1])).tolist())

    h = brentq(lambda h: depth(short(h)), 0, h, xtol=1e-16)
    now, since = short(h), i * rig.contact / TOUCH_STEPS + h
    path.append((since, now[1], side * now[4]))
    end = y.copy()
    end[:2], end[-2:] = now[:2], now[2:4]
    end[-2] = end[0] + side * half * (1 - 1e-12)
    for n, order in enumerate(orders):
        turn = complex(y[3 + 2 * n], y[2 + 2 * n]) * np.exp(1j * order * since)
        end[2 + 2 * n], end[3 + 2 * n] = turn.imag, turn.real
    return (*np.array(path).T, end)


def sensed(rig, n, first, A, states, touches):
    """The acceleration of n samples of a rig with compliant walls, behind its filter."""
    several = math.ceil(FINE / rig.rate)
    fine = several * rig.rate
    before = math.ceil(0.05 * rig.rate) * several  # in which the filter settles
    edges = first + (np.arange(-before, (n - 1) * several + 2) - 0.5) / fine
    begins = np.array([begin for begin, _ in states])
    place = np.maximum(np.searchsorted(begins, edges, side="right") - 1, 0)
    values, vectors = np.linalg.eig(A[:-2, :-2])
    # velocities and impulses in flights, then in contacts
    v, jump = np.empty(edges.size), np.zeros(edges.size)
    for i in np.unique(place):
        own = slice(*np.searchsorted(place, [i, i + 1]))
        parts = np.linalg.solve(vectors, states[i][1][:-2].astype(complex))
        v[own] = (np.exp(np.outer(edges[own] - begins[i], values)) @ (vectors[1] * parts)).real
    for times, speeds, jumps, _ in touches:
        a, b = np.searchsorted(edges, times[[0, -1]])
        v[a:b] = np.interp(edges[a:b], times, speeds)
        jump[a:b] += np.interp(edges[a:b], times, jumps)
        jump[b:] += jumps[-1]
    # means over the short intervals
    a, pushed = np.diff(v) * fine, np.diff(jump) * fine
    if rig.ring_share:
        w, decay = 2 * math.pi * rig.ringing, rig.ring_decay
        mode = [rig.ring_share * w**2], [1, 2 * decay, decay**2 + w**2]
        top, below, _ = cont2discrete(mode, 1 / fine)
        a += lfilter(top[0], below, pushed)
    if rig.filter:
        a = sosfilt(FILTERS[rig.filter](rig.known_lowpass, fs=fine), a - a[0]) + a[0]
    return a[before::several]


def record(rig, seed=0, settle=400):
    """Times, load and acceleration as sampled, and the impacts in the record."""
    random = np.random.default_rng(seed)
    first = (settle + random.uniform()) / rig.frequency
    touches = []
    found = flights(rig, first - 0.1, first + rig.duration, touches=touches)
    if found is None:
        return None
    A, impacts, states = found
    if not impacts.size:
        return None
    t = np.arange(round(rig.duration * rig.rate)) / rig.rate
    begins = np.array([begin for begin, _ in states]) - first
    if rig.wall:
        a = sensed(rig, t.size, first, A, states, touches)
    elif rig.known_lowpass is None:
        a = pulsed(rig, t, begins, A, impacts - [first, 0, 0], states)
    else:
        a = impulsive(rig, t, begins, A, impacts - [first, 0, 0], states)
    if rig.lowpass is not None:
        a = sosfilt(butter(2, rig.lowpass, fs=rig.rate, output="sos"), a)
    turn, load = 2 * math.pi * rig.frequency * (t + first), 0.0
    for n, size, begin in rig.waves:
        passed = 1.0
        if rig.filter:
            fine = math.ceil(FINE / rig.rate) * rig.rate
            sections = FILTERS[rig.filter](rig.known_lowpass, fs=fine)
            passed = sosfreqz(sections, [n * rig.frequency], fs=fine)[1][0]
        elif rig.known_lowpass is not None:
            passed = freqs(*butter(4, 1, analog=True), [n * rig.frequency / rig.known_lowpass])[1][
                0
            ]
        load = load + rig.F0 * size * (passed * np.exp(1j * (n * turn + begin))).imag
    since = t / rig.duration - 0.5
    load = load * np.exp(rig.load_growth * since)
    a = (
        a * (1 + rig.gain_growth * since)
        + rig.offset
        + rig.noise * a.std() * random.standard_normal(t.size)
    )
    load = load + 0.01 * load.std() * 2**0.5 * random.standard_normal(t.size)
    gains = 1 + rig.calibration * np.random.default_rng(
        [seed, round(1e9 * rig.xi)]
    ).standard_normal(2)
    load, a = gains[0] * load, gains[1] * a
    if rig.wall:
        load, a = (
            np.round(x / step) * step
            for x in (load, a) for step in [2.5 * abs(x).max() / 2**rig.bits]
        )  # fmt: skip
    inside = (impacts[:, 0] >= first) & (impacts[:, 0] < first + rig.duration)
    shown = impacts[inside] - [first, 0, 0]
    return t, load, a, shown


def pulsed(rig, t, begins, A, impacts, states):
    """The acceleration with pulses of finite duration and ringing."""
    a = np.zeros(t.size)
    place = np.searchsorted(begins, t, side="right") - 1
    own_A = A[:-2, :-2]
    values, vectors = np.linalg.eig(own_A)
    for i in np.unique(place):
        own = place == i
        parts = np.linalg.solve(vectors, states[i][1][:-2].astype(complex))
        a[own] = (np.exp(np.outer(t[own] - begins[i], values)) @ (vectors[1] * values * parts)).real
    for time, _, jump in impacts:
        since = t - time
        part = (since + rig.before * rig.contact) / rig.contact
        inside = (part >= 0) & (part <= 1)
        # a half sine over a warped time
        shape = np.sin(math.pi * part[inside] ** (1 / rig.skew))
        grid = (np.arange(2000) + 0.5) / 2000
        a[inside] += jump * shape / (rig.contact * np.sin(math.pi * grid ** (1 / rig.skew)).mean())
        after = (since >= 0) & (since < 12 / rig.ring_decay)
        w = 2 * math.pi * rig.ringing
        own = since[after]
        a[after] += rig.ring_share * jump * w * np.exp(-rig.ring_decay * own) * np.sin(w * own)
    return a


def impulsive(rig, t, begins, A, impacts, states):
    """The acceleration with impulses of no duration and ringing, through the known low-pass: a larger linear
    system, whose last states are those of the ringing and of the filter."""
    n = A.shape[0] - 2
    F, B, C, _ = tf2ss(*butter(4, 1, analog=True))
    w0, w = 2 * math.pi * rig.known_lowpass, 2 * math.pi * rig.ringing
    big = np.zeros((n + 6, n + 6))
    big[:n, :n] = A[:-2, :-2]
    # the ringing: exp(-decay t) times cosine and sine of w t
    big[n : n + 2, n : n + 2] = [[-rig.ring_decay, -w], [w, -rig.ring_decay]]
    big[n + 2 :, n + 2 :] = w0 * F
    # input of the filter: the acceleration of the primary mass and the ringing
    big[n + 2 :, :n] = w0 * B @ A[1:2, :-2]
    big[n + 2 :, n + 1] = w0 * B[:, 0] * rig.ring_share * w
    values, vectors = np.linalg.eig(big)
    inverse = np.linalg.inv(vectors)
    jumps = {round(1e9 * time): jump for time, _, jump in impacts}
    a, u = np.zeros(t.size), np.zeros(6)
    place = np.searchsorted(begins, t, side="right") - 1
    first = max(0, int(place[0]) - 2)
    for i in range(first, len(states)):
        jump = jumps.get(round(1e9 * begins[i]), 0.0)
        u = u.copy()
        u[0] += jump
        u[2:] += w0 * B[:, 0] * jump
        y = inverse @ np.concatenate([states[i][1][:n], u]).astype(complex)
        own = place == i
        waves = np.exp(np.outer(t[own] - begins[i], values)) @ (vectors[n + 2 :] * y).T
        a[own] = (waves @ C[0]).real
        if i + 1 < len(states):
            u = (vectors[n:] @ (np.exp(values * (begins[i + 1] - begins[i])) * y)).real
    return a


def period_of(rig, impacts):
    """Load cycles after which impacts repeat, at most 4, and their walls in one period; 0 without repetition."""
    times, sides = impacts[:, 0] * rig.frequency, impacts[:, 1]
    for k in range(1, 5):
        count = np.searchsorted(times, times[0] + k - 1e-3)
        n = times.size - count
        if not 0 < count < 7 * k or n < count:
            continue
        if abs(times[count:] - times[:n] - k).max() < 2e-4 and (sides[count:] == sides[:n]).all():
            return k, "".join("R" if side > 0 else "L" for side in sides[:count])
    return 0, ""


def drawn(draw, kind, least=4, widest=40):
    """A rig of some kind, with a load of at least so many N, and at most some D."""
    rig = {
        "xi": draw.uniform(0.007, 0.016), "mu": draw.uniform(0.025, 0.05), "F0": draw.uniform(least, 8),
        "restitution": (draw.uniform(0.6, 0.8),) * 2, "r": draw.choice([0.9, 0.94, 1.04, 1.06, 1.1]),
        "D": draw.uniform(15, widest), "noise": draw.choice([0.004, 0.0075, 0.01]),
    }  # fmt: skip
    if kind != "abc":
        rig["rate"] = float(draw.choice([10000, 20000]))
        rig["duration"] = 2.0 if rig["rate"] > 15000 else 3.0
        rig["contact"] = float(draw.choice([2e-4, 4e-4, 6e-4, 1e-3]))
    if kind == "defg" and draw.uniform() < 0.25:
        rig["ring_share"] = 0.0
    if kind == "hi":
        rig["lowpass"] = float(draw.choice([600, 1000, 2000]))
    if kind == "other":
        rig["restitution"] = tuple(draw.uniform(0.55, 0.85, 2))
        rig["before"], rig["skew"] = (
            float(draw.choice([0.0, 0.4])),
            float(draw.choice([1, 1.5])),
        )
        rig["ringing"], rig["ring_decay"] = draw.uniform(250, 900), draw.uniform(60, 300)
        rig["offset"] = draw.uniform(-1, 1)
    return Rig(**rig)


@functools.cache
def chaotic_rig(seed, kind="abc"):
    """A rig with impacts on both walls that do not repeat, and its record, for the kinds of `random_rig`."""
    draw = np.random.default_rng([seed, 7, *kind.encode()])
    while True:
        rig = replace(drawn(draw, kind, 2, 60), rounded=True)
        found = flights(rig, 300 / rig.frequency, 300 / rig.frequency + rig.duration)
        if found is None or found[1].shape[0] < 20 or len(set(found[1][:, 1])) < 2:
            continue
        if period_of(rig, found[1])[0]:
            continue
        made = record(rig, seed)
        if made is not None and not period_of(rig, made[3])[0]:
            return rig, made


def random_rig(seed, kind="abc"):
    """A rig with a periodic motion, and a record of it: of kind "abc" at 5 kHz with contacts of 0.4 ms, of kind
    "defg"
    at other rates, with other contacts and perhaps without ringing, of kind "hi" with an unknown low-pass, of kind
    "other" with centred or skewed pulses, an offset and two walls."""
    draw = np.random.default_rng([seed, *kind.encode()])
    while True:
        rig = drawn(draw, kind)
        made = record(rig, seed)
        if made is None or made[3].shape[0] < 8:
            continue
        k, sides = period_of(rig, made[3])
        if k and len(set(sides)) == 2:
            jumps = abs(made[3][:, 2])
            if jumps.min() > 0.05 * jumps.max() and np.diff(made[3][:, 0]).min() > 4e-3:
                return rig, made, k, sides


def loaded_rig(seed, load, **changes):
    """A rig under a load that is not periodic, and its record: a "sweep" of constant amplitude up and down again,
    two sines ("beat") or band-limited "noise", with load sensors of various noise."""
    draw = np.random.default_rng([seed, *load.encode()])
    while True:
        rig = replace(drawn(draw, "defg", 3, 50), r=1.0, duration=5.0, rounded=True, **changes)
        if load == "beat":
            first, second = draw.uniform(0.93, 0.99), draw.uniform(1.02, 1.08)
            lines = [(first, 0.7, 0.0), (second, 0.7, draw.uniform(0, 6))]
        elif load == "noise":
            lines = [
                (f, 0.3, phase)
                for f, phase in zip(
                    draw.uniform(0.8, 1.3, 24), draw.uniform(0, 6.3, 24), strict=True
                )
            ]
        else:
            # the spectrum of a linear sweep that begins again after a while
            low, high = 0.95, draw.uniform(1.05, 1.15)
            cycles = 1.3 * rig.duration * rig.frequency
            orders = np.arange(math.ceil(low * cycles), math.floor(high * cycles) + 1) / cycles
            phases = -math.pi * cycles * (orders - low) ** 2 / (high - low)
            size = math.sqrt(2 / orders.size)
            lines = [(f, size, p) for f, p in zip(orders.tolist(), phases.tolist(), strict=True)]
        rig = replace(rig, lines=tuple(lines))
        made = record(rig, seed, settle=100)
        if made is None or made[3].shape[0] < 60 or len(set(made[3][:, 1])) < 2:
            continue
        return rig, made


@functools.cache
def wide_rig(seed, generator, chaos):
    """A rig with random sensors, noise, contacts and load, with its record, k and the walls of a period.

    The generator is "pulses", "spikes" or "contacts" (or "virtual", whose record is not made here). `chaos` asks
    for motions that do not repeat.
    """
    draw = np.random.default_rng([seed, int(chaos), *generator.encode()])
    while True:
        rate = float(draw.choice([2000, 5000, 10000, 20000, 50000]))
        numbers = {
            "xi": draw.uniform(0.007, 0.016), "mu": draw.uniform(0.025, 0.05),
            "F0": draw.uniform(2 if chaos else 4, 8), "restitution": tuple(draw.uniform(0.55, 0.85, 2)),
            "r": draw.choice([0.9, 0.94, 1.04, 1.06, 1.1]), "D": draw.uniform(15, 60 if chaos else 40),
            "rate": rate, "duration": {2000: 6.0, 5000: 6.0, 10000: 3.0}.get(rate, 2.0),
            "noise": 10 ** (-draw.uniform(20, 50) / 20), "ring_share": draw.choice([0, 0.15, 0.3]),
            "ringing": draw.uniform(250, min(900, 0.2 * rate)), "ring_decay": draw.uniform(60, 300),
            "calibration": draw.choice([0, 0.01]), "contact": draw.choice([5e-5, 2e-4, 4e-4, 8e-4, 1.5e-3]),
            "before": draw.choice([0, 0.4]), "skew": draw.choice([1, 1.5]), "offset": draw.uniform(-1, 1),
        }  # fmt: skip
        if draw.uniform() < 0.5:
            numbers["harmonics"] = tuple(draw.uniform(-0.1, 0.1, 2))
        if draw.uniform() < 0.33:
            numbers["exponent"] = draw.uniform(0.05, 0.2)
        if generator != "pulses":
            numbers["known_lowpass"] = min(float(draw.choice([600, 1000, 2000, 4000])), 0.25 * rate)
        elif draw.uniform() < 0.33:
            numbers["lowpass"] = min(float(draw.choice([600, 1000, 2000])), 0.4 * rate)
        if generator == "contacts":
            numbers["wall"] = str(draw.choice(["linear", "linear", "hunt-crossley"]))
            numbers["filter"] = str(draw.choice(["", *FILTERS]))
            numbers["bits"] = int(draw.choice([12, 14, 16, 24]))
            numbers.pop("exponent", None)
        rig = Rig(**numbers, rounded=chaos)
        found = flights(rig, 300 / rig.frequency, 300 / rig.frequency + 1.0 + chaos)
        if found is None or found[1].shape[0] < 20 or len(set(found[1][:, 1])) < 2:
            continue
        if bool(period_of(rig, found[1])[0]) == chaos:
            continue
        made = record(rig, seed)
        if made is None:
            continue
        k, sides = period_of(rig, made[3])
        if chaos and not k:
            return rig, made, 0, ""
        if not chaos and k and len(set(sides)) == 2:
            jumps = abs(made[3][:, 2])
            if jumps.min() > 0.05 * jumps.max() and np.diff(made[3][:, 0]).min() > 4e-3:
                return rig, made, k, sides
