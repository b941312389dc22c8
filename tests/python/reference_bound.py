"""The Cramer-Rao bound of the parameters of a rig from a record of its flights, for tests of identification.

The data are the samples of the acceleration outside of pulses. Unknown are the state at the start, the parameters,
an offset, the pole of the ringing and its amplitude after each impact. Information on parameters and state (the R
of a QR factorisation) is carried from impact to impact by the derivatives of the map from each to the next, and
grows by the samples of each flight. So the bound covers chaos and periodic motions. Derivatives are by imaginary
steps through closed forms; no code of the package is used.
"""

import math
from itertools import pairwise

import numpy as np
from reference_rig import K, M, flights, period_of
from scipy.signal import butter, sosfreqz

STEP = 1e-30
#: Errors of the map from impact to impact over typical sizes: without such errors, the information on the state of
#: an attracting motion grows beyond what rounding permits.
LOOSE = 1e-8
#: Unknowns, in this order; then offset, real and imaginary part of the pole of the ringing. The exponents are
#: those of R (v/v0)^-p on each wall, with the mean speed v0 there; they are 0.
NAMES = ("xi", "mu", "R1", "R2", "d", "F0", "phase", "exponent1", "exponent2")


def motion(theta, state, t, Omega):
    """Displacement, velocity and acceleration of the primary mass at times after the last impact."""
    xi, F0, phase = theta[0], theta[5], theta[6]
    begin, x, v, _ = state
    omega = math.sqrt(K / M)
    a, b = omega**2 - Omega**2, 2 * xi * omega * Omega

    def steady(time, order):
        turn = Omega * time + phase + order * math.pi / 2
        return F0 / M * Omega**order * (a * np.sin(turn) - b * np.cos(turn)) / (a**2 + b**2)

    rate, decay, since = omega * np.sqrt(1 - xi**2), xi * omega, t - begin
    x, v = x - steady(begin, 0), v - steady(begin, 1)
    c, s, fade = np.cos(rate * since), np.sin(rate * since), np.exp(-decay * since)
    X = fade * (x * c + (v + decay * x) / rate * s)
    V = fade * (v * c - (decay * v + omega**2 * x) / rate * s)
    return X + steady(t, 0), V + steady(t, 1), -2 * decay * V - omega**2 * X + steady(t, 2)


def impact(theta, state, side, other, t, Omega, usual):
    """The state (time, x, x', z') just after the next impact, near time t; sides are 1 or -1, `usual` are the mean
    speeds on the walls."""
    _, mu, R1, R2, d, _, _, p1, p2 = theta
    for _ in range(6):
        X, V, _ = motion(theta, state, t, Omega)
        gap = state[1] + side * d / 2 + state[3] * (t - state[0]) - X - other * d / 2
        t = t - gap / (state[3] - V)
    X, V, _ = motion(theta, state, t, Omega)
    closing = state[3] - V
    R, p, v0 = (R1, p1, usual[0]) if other > 0 else (R2, p2, usual[1])
    R = R * (other * closing / v0) ** -p
    jump = mu * (1 + R) * closing / (1 + mu)
    return np.array([t, X, V + jump, state[3] - jump / mu])


def moving(rig, first, last, sides):
    """Impacts and states of a motion with given walls in each cycle, and the load phase at time 0."""
    for phase in np.linspace(0, 2 * math.pi, 24, endpoint=False):
        found = flights(rig, first, last, phase)
        if found is not None and (not sides or (period_of(rig, found[1])[1] * 2).find(sides) >= 0):
            return found[1], found[2], phase
    raise ValueError(f"no motion {sides}")


def moved_at(rig, times, sides, phase):
    """Impacts and states of the motion of a rig with impacts at some times on some walls (1 or -1).

    For given times, momentum and restitution at the impacts are linear in the jumps and in the state at the
    start. There are more equations than unknowns: their residual (m/s) shows whether a motion has these times.
    """
    theta = np.array([rig.xi, rig.mu, *rig.restitution, rig.d, rig.F0, phase])
    N, Omega = times.size, 2 * math.pi * rig.frequency
    # columns: displacement and velocity at the start, then the jumps; the last one is the motion under the load
    by = np.zeros((2, N, N + 3))
    for column, state in enumerate(((times[0], 1, 0, 0), (times[0], 0, 1, 0))):
        by[:, :, column] = motion(np.array([*theta[:5], 0, 0]), state, times, Omega)[:2]
    for i in range(N):
        later = motion(np.array([*theta[:5], 0, 0]), (times[i], 0, 1, 0), times[i + 1 :], Omega)
        by[:, i + 1 :, 2 + i] = later[:2]
    by[:, :, -1] = motion(theta, (times[0], 0, 0, 0), times, Omega)[:2]
    X, V = by
    walls = np.zeros(N + 3)
    walls[-1] = rig.d / 2
    rates = np.diff(X + np.outer(sides, walls), axis=0) / np.diff(times)[:, None]
    inner = np.arange(1, N - 1)
    jumps = np.eye(N + 3)[2 + inner]
    before, after = rates[:-1], rates[1:]
    R = np.where(sides[inner] > 0, *rig.restitution)[:, None]
    momentum = jumps + rig.mu * (after - before)
    restitution = after - V[inner] - jumps + R * (before - V[inner])
    equations = np.vstack([momentum, restitution])
    found = np.linalg.lstsq(equations[:, :-1], -equations[:, -1], rcond=None)[0]
    found = np.append(found, 1.0)
    jump = found[2:-1]
    states = [
        (t, np.array([x, v + own, 0, z]))
        for t, x, v, own, z in zip(
            times[:-1], X @ found, V @ found, jump, rates @ found, strict=False
        )
    ]
    impacts = list(zip(times[:-1], sides, jump, strict=False))
    return (impacts, states, phase), equations @ found


def usual_speeds(rig, impacts):
    """The mean speeds of impacts on the right and on the left wall."""
    each = [
        [abs(jump) * (1 + rig.mu) / (rig.mu * (1 + R)) for _, side, jump in impacts if side == wall]
        for wall, R in zip((1, -1), rig.restitution, strict=True)
    ]
    return [float(np.mean(own)) for own in each]


def bound(
    rig,
    samples,
    noise,
    sides,
    known=(),
    load_error=0.0,
    phase_error=math.inf,
    margin=1e-4,
    own=None,
    exponent=1e-9,
):
    """Least standard errors by name, for a number of samples with white noise of a motion with `sides` in a cycle.

    F0 and the load phase are measured with these errors, and `known` parameters are exact. `margin` (s) is left
    out on each side of a pulse. `own` holds impacts and states of another motion, from time 0, and its load phase.
    `exponent` is the standard deviation of the exponents with which R of each wall may depend on the speed.
    """
    Omega, duration = 2 * math.pi * rig.frequency, samples / rig.rate
    first = 0 if own else 400 / rig.frequency
    impacts, states, phase = own or moving(rig, first, first + duration, sides)
    after = {round(1e9 * t): y for t, y in states}
    theta = np.array([rig.xi, rig.mu, *rig.restitution, rig.d, rig.F0, phase, 0, 0])
    P, rings, usual = len(NAMES), rig.ring_share > 0, usual_speeds(rig, impacts)
    Q = P + 1 + 2 * rings
    # columns: theta, offset, pole, and the state (4) after the last impact
    sizes = np.array(
        [
            *(0.01, 0.03, 1, 1, rig.d, rig.F0, 1, exponent, exponent, 1),
            *([100.0] * (2 * rings)),
            1e-3,
            1e-3,
            0.1,
            0.1,
        ]
    )
    R = np.diag(1e-9 / sizes)
    for name, error in {
        "F0": load_error,
        "phase": phase_error,
        "exponent1": exponent,
        "exponent2": exponent,
        **dict.fromkeys(known, 1e-9),
    }.items():
        if 0 < error < math.inf:
            R = np.vstack([R, np.eye(Q + 4)[NAMES.index(name)] / error])
    for (t, side, jump), (later, other, _) in pairwise(impacts):
        y = after[round(1e9 * t)]
        state = np.array([t, y[0], y[1], y[-1]])
        every = np.concatenate([theta, state])
        moved = (every + 1j * STEP * np.eye(P + 4)).T
        # samples of this flight outside of the pulses
        inside = (t + rig.contact + margin, later - margin)
        at = (
            np.arange(math.ceil((inside[0] - first) * rig.rate), (inside[1] - first) * rig.rate)
            / rig.rate
            + first
        )
        if at.size > 4:
            of_motion = [motion(one[:P], one[P:], at, Omega)[2].imag / STEP for one in moved.T]
            columns = [*of_motion[:P], np.ones(at.size)]
            if rings:
                w, since = 2 * math.pi * rig.ringing, at - t
                wave = np.exp(complex(-rig.ring_decay, w) * since)
                ring = rig.ring_share * jump * w * wave * since
                columns += [ring.imag, ring.real]
            columns = np.column_stack([*columns, *of_motion[P:]]) / noise
            if rings:
                basis = np.linalg.qr(np.column_stack([wave.real, wave.imag]))[0]
                columns -= basis @ (basis.T @ columns)
            R = np.linalg.qr(np.vstack([R, columns]) * sizes, mode="r") / sizes
        # carry them to the state after the next impact
        by = np.column_stack(
            [
                impact(one[:P], one[P:], side, other, later, Omega, usual).imag / STEP
                for one in moved.T
            ]
        )
        R[:, Q:] = np.linalg.solve(by[:, P:].T, R[:, Q:].T).T
        R[:, :P] -= R[:, Q:] @ by[:, :P]
        loose = np.hstack([np.eye(4), np.zeros((4, Q + 4))])
        own = np.hstack([-R[:, Q:] * sizes[Q:] * LOOSE, R * sizes])
        R = np.linalg.qr(np.vstack([loose, own]), mode="r")[4:, 4:] / sizes
    errors = sizes * np.linalg.norm(np.linalg.pinv(R * sizes), axis=1)
    return dict(zip(NAMES, errors.tolist(), strict=False))


def noise_of(values, rate, frequency=None, lowpass=None):
    """Standard deviation of white noise with the density of the noise that a record has in its flights.

    It is by sixth differences, in which slower motion is small. Noise that has passed a low-pass with the signal
    is as dense below its -3 dB frequency as before it, but its samples are smaller: then it is by the scatter of
    the samples of a periodic record in parts of its period, of which the median has no impact, over what the
    low-pass lets pass. (The spectrum between harmonics also has what the sampling of short pulses scatters, which
    is in no flight.)
    """
    if lowpass is None:
        return float(np.median(abs(np.diff(values, 6)))) / 0.6745 / math.sqrt(math.comb(12, 6))
    turns = np.arange(values.size) / rate * frequency % 1
    part = (turns * 64).astype(int)
    scatter = []
    for one in range(64):
        own = part == one
        fitted = np.polynomial.Polynomial.fit(turns[own], values[own], 3, full=True)[1][0]
        scatter.append(float(fitted[0]) / (own.sum() - 4))
    passed = abs(sosfreqz(butter(2, lowpass, fs=rate, output="sos"), 4096)[1]) ** 2
    return math.sqrt(float(np.median(scatter)) / float(np.mean(passed)))
