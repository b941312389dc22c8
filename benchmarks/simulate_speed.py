"""Impacts a second: this package, a hand-written numba event loop, and integrators with events.

All do the same work: 1000 load cycles from rest with the parameters of Figure 6, at a stable and at a
chaotic point. The numba loop flies in closed form, looks at the gap 40 times a load cycle and finishes by
Newton: fast, but it can miss a contact that is shorter than its step. A second one, with the same step, takes no
sines: it turns both parts of x from point to point, and finishes by Newton on a Taylor polynomial. The others
(50 cycles only) integrate and look for sign changes (SciPy, SUNDIALS, Siconos) or isolate the zeros of Taylor
polynomials (heyoka, in `taylor_peer.py`). All must find the same impacts: every one at the stable point, the first
12 at the chaotic one, where rounding grows by a factor in each.

Run with `python benchmarks/simulate_speed.py` (needs numba, SciPy and scikit-sundae; heyoka if it is installed,
Siconos where the system's Python has it).
"""

import math
import os
import statistics
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numba
import numpy as np
import taylor_peer
import vibroimpact as vi
from scipy.integrate import solve_ivp
from sksundae.cvode import CVODE
from table import row, show

XI, MU, RESTITUTION = 0.0114, 0.028, 0.75
OSC = vi.Oscillator(xi=XI, mu=MU, restitution=RESTITUTION)
POINTS = {"stable": (1.04, 25.0), "chaotic": (1.02, 11.25)}
MOST = 10**6
TARGETS = {"stable": 7.0, "chaotic": 5.0}
CYCLES, ROUNDS, CALLS = 1000, 7, 20


@numba.njit(fastmath=False)
def drift(xi, eta, amplitude, r, h, a, b, angle, z, w, end, state):
    """The state at the end of the time, after a flight of h."""
    shrink = math.exp(-xi * h)
    sine, cosine = shrink * math.sin(eta * h), shrink * math.cos(eta * h)
    free = a * sine + b * cosine
    phase = angle + r * h
    state[0], state[3], state[4] = end, z + w * h, w
    state[1] = free + amplitude * math.sin(phase)
    state[2] = eta * (a * cosine - b * sine) - xi * free + amplitude * r * math.cos(phase)


@numba.njit(fastmath=False, error_model="numpy")
def fly(xi, mu, restitution, r, clearance, end, state, times, n):
    """An event loop with closed-form flights, a scan and Newton, up to a time; the number of impacts.

    `state` is t, x, x', z, z', in and out; `times` receives the impact times if it has room.
    """
    eta = math.sqrt(1 - xi * xi)
    amplitude = 1 / math.hypot(1 - r * r, 2 * xi * r)
    lag = math.atan2(2 * xi * r, 1 - r * r)
    half, step = 0.5 * clearance, 2 * math.pi / r / 40
    t, x, v, z, w = state[0], state[1], state[2], state[3], state[4]
    while True:
        angle = r * t - lag
        b = x - amplitude * math.sin(angle)
        a = (v - amplitude * r * math.cos(angle) + xi * b) / eta
        if n == MOST:  # it cannot pass an accumulation of impacts
            return n
        h, found = 0.0, 0
        while found == 0:
            h += step
            if t + h >= end:
                drift(xi, eta, amplitude, r, end - t, a, b, angle, z, w, end, state)
                return n
            e = math.exp(-xi * h)
            s, c = e * math.sin(eta * h), e * math.cos(eta * h)
            y = z + w * h - (a * s + b * c + amplitude * math.sin(r * h + angle))
            if y > half:
                found = 1
            elif y < -half:
                found = -1
        for _ in range(50):
            e = math.exp(-xi * h)
            s, c = e * math.sin(eta * h), e * math.cos(eta * h)
            free = a * s + b * c
            x = free + amplitude * math.sin(r * h + angle)
            v = eta * (a * c - b * s) - xi * free + amplitude * r * math.cos(r * h + angle)
            gap = half - found * (z + w * h - x)
            change = gap / (found * (w - v))
            h += change
            if abs(change) < 1e-13:
                break
        t += h
        momentum, approach = v + mu * w, w - v
        v = (momentum + mu * restitution * approach) / (1 + mu)
        w = v - restitution * approach
        z = x + found * half
        if n < times.size:
            times[n] = t
        n += 1


@numba.njit(fastmath=False)
def numba_loop(xi, mu, restitution, r, clearance, cycles, times):
    """Impacts of so many cycles from rest."""
    return fly(xi, mu, restitution, r, clearance, 2 * math.pi * cycles / r, np.zeros(5), times, 0)


@numba.njit(fastmath={"contract"}, error_model="numpy")
def turning_loop(xi, mu, restitution, r, clearance, cycles, times):
    """The same impacts without sines: both parts of x are turned by the angles of a step, and the contact is
    the zero of a Taylor polynomial. The load phase is computed anew every 64 impacts."""
    eta = math.sqrt(1 - xi * xi)
    size = (1 - r * r) ** 2 + (2 * xi * r) ** 2
    in_phase, behind = (1 - r * r) / size, 2 * xi * r / size
    half, end, h = 0.5 * clearance, 2 * math.pi * cycles / r, 2 * math.pi / r / 40
    shrink = math.exp(-xi * h)
    free_cosine, free_sine = shrink * math.cos(eta * h), shrink * math.sin(eta * h)
    cosine, sine = math.cos(r * h), math.sin(r * h)
    inverse, two_xi, r2 = 1 / (1 + mu), 2 * xi, r * r
    t = x = v = z = w = 0.0
    p, q = -behind, in_phase  # the forced part, A times sine and cosine of its argument
    n = 0
    while True:
        f = x - p
        g = (v - r * q + xi * f) / eta
        y = far = z
        steps = side = 0
        most = int((end - t) / h) + 1
        while steps < most:
            steps += 1
            f, g = free_cosine * f + free_sine * g, free_cosine * g - free_sine * f
            p, q = cosine * p + sine * q, cosine * q - sine * p
            far += w * h
            y = far - f - p
            if abs(y) > half:
                side = 1 if y > 0 else -1
                break
        if side == 0:
            return n
        f1 = eta * g - xi * f
        f2 = -two_xi * f1 - f
        f3 = -two_xi * f2 - f1
        f4 = -two_xi * f3 - f2
        f5 = -two_xi * f4 - f3
        f6 = -two_xi * f5 - f4
        f7 = -two_xi * f6 - f5
        f8 = -two_xi * f7 - f6
        f9 = -two_xi * f8 - f7
        f10 = -two_xi * f9 - f8
        f11 = -two_xi * f10 - f9
        q1, p2 = r * q, -r2 * p
        q3, p4 = -r2 * q1, -r2 * p2
        q5, p6 = -r2 * q3, -r2 * p4
        q7, p8 = -r2 * q5, -r2 * p6
        q9, p10 = -r2 * q7, -r2 * p8
        c0, c1 = y - side * half, w - f1 - q1
        c2, c3 = -(f2 + p2) / 2, -(f3 + q3) / 6
        c4, c5 = -(f4 + p4) / 24, -(f5 + q5) / 120
        c6, c7 = -(f6 + p6) / 720, -(f7 + q7) / 5040
        c8, c9 = -(f8 + p8) / 40320, -(f9 + q9) / 362880
        c10, c11 = -(f10 + p10) / 3628800, -(f11 - r2 * q9) / 39916800
        s, low, high = -c0 / c1, -h, 0.0
        if not low <= s <= high:
            s = -0.5 * h
        for _ in range(50):
            s2 = s * s
            value = (c0 + c1 * s) + s2 * (
                (c2 + c3 * s)
                + s2
                * (
                    (c4 + c5 * s)
                    + s2 * ((c6 + c7 * s) + s2 * ((c8 + c9 * s) + s2 * (c10 + c11 * s)))
                )
            )
            slope = (c1 + 2 * c2 * s) + s2 * (
                (3 * c3 + 4 * c4 * s)
                + s2
                * (
                    (5 * c5 + 6 * c6 * s)
                    + s2 * ((7 * c7 + 8 * c8 * s) + s2 * ((9 * c9 + 10 * c10 * s) + s2 * 11 * c11))
                )
            )
            if side * value > 0:
                high = s
            else:
                low = s
            change = value / slope
            s -= change
            if abs(change) < 1e-8 * h:  # what the next step would change is rounding
                break
            if not low <= s <= high:
                s = 0.5 * (low + high)
        a = r * s
        a2 = a * a
        turned = a * (1 - a2 / 6 * (1 - a2 / 20 * (1 - a2 / 42 * (1 - a2 / 72 * (1 - a2 / 110)))))
        kept = 1 - a2 / 2 * (1 - a2 / 12 * (1 - a2 / 30 * (1 - a2 / 56 * (1 - a2 / 90))))
        p, q = kept * p + turned * q, kept * q - turned * p
        s2 = s * s
        approach = (c1 + 2 * c2 * s) + s2 * (
            (3 * c3 + 4 * c4 * s)
            + s2
            * (
                (5 * c5 + 6 * c6 * s)
                + s2 * ((7 * c7 + 8 * c8 * s) + s2 * ((9 * c9 + 10 * c10 * s) + s2 * 11 * c11))
            )
        )
        t += steps * h + s
        z += w * (steps * h + s)
        x = z - side * half
        v = (w - approach + mu * w + mu * restitution * approach) * inverse
        w = v - restitution * approach
        if n < times.size:
            times[n] = t
        n += 1
        if n % 64 == 0:
            p = in_phase * math.sin(r * t) - behind * math.cos(r * t)
            q = in_phase * math.cos(r * t) + behind * math.sin(r * t)


def bounced(y):
    """The state x, x', z, z' after an impact."""
    momentum, approach = y[1] + MU * y[3], y[3] - y[1]
    y[1] = (momentum + MU * RESTITUTION * approach) / (1 + MU)
    y[3] = y[1] - RESTITUTION * approach
    return y


def scipy_impacts(r, clearance, cycles):
    """Number of impacts by solve_ivp with events, restarted at each."""
    half = 0.5 * clearance

    def motion(t, y):
        return [y[1], math.sin(r * t) - 2 * XI * y[1] - y[0], y[3], 0.0]

    def right(_, y):
        return half - (y[2] - y[0])

    def left(_, y):
        return half + (y[2] - y[0])

    for event in (right, left):
        event.terminal, event.direction = True, -1
    t, end, y, n = 0.0, 2 * math.pi * cycles / r, np.zeros(4), 0
    while t < end:
        answer = solve_ivp(motion, (t, end), y, method="DOP853", rtol=1e-10, atol=1e-10,
                           events=(right, left))  # fmt: skip
        t, y = answer.t[-1], answer.y[:, -1].copy()
        if answer.status == 1:
            n, y = n + 1, bounced(y)
    return n


def sundials_impacts(r, clearance, cycles):
    """The same by CVODE's Adams methods with its root finding."""
    half = 0.5 * clearance

    def motion(t, y, slope):
        slope[:] = y[1], math.sin(r * t) - 2 * XI * y[1] - y[0], y[3], 0.0

    def gaps(_, y, events):
        events[:] = half - (y[2] - y[0]), half + (y[2] - y[0])

    gaps.terminal, gaps.direction = [True, True], [-1, -1]
    solver = CVODE(motion, method="Adams", rtol=1e-10, atol=1e-10, eventsfn=gaps, num_events=2,
                   max_num_steps=10**6)  # fmt: skip
    t, end, y, n = 0.0, 2 * math.pi * cycles / r, np.zeros(4), 0
    while t < end:
        answer = solver.solve([t, end], y)
        t, y = answer.t[-1], answer.y[-1].copy()
        if answer.t_events is not None and t < end:
            n, y = n + 1, bounced(y)
    return n


def seconds(work, calls):
    """CPU time of one call, as the mean of some, and its result."""
    begin = time.process_time()
    for _ in range(calls):
        result = work()
    return (time.process_time() - begin) / calls, result


def integrators(r, clearance, cycles):
    """CPU time and number of impacts by common integrators with events."""
    yield "SciPy DOP853", *seconds(lambda: scipy_impacts(r, clearance, cycles), 1)
    yield "SUNDIALS CVODE", *seconds(lambda: sundials_impacts(r, clearance, cycles), 1)
    if taylor_peer.here():
        run = taylor_peer.simulate(XI, MU, RESTITUTION, r, clearance, cycles)
        run()
        yield taylor_peer.NAME, *seconds(lambda: len(run()), CALLS)
    system = ["env", "-i", f"PATH={os.defpath}", "python3"]
    if (
        subprocess.run(
            [*system, "-c", "import siconos.kernel"], stderr=subprocess.DEVNULL
        ).returncode
        == 0
    ):
        numbers = (XI, MU, r, RESTITUTION, clearance, cycles)
        call = [*system, Path(__file__).with_name("siconos_damper.py"), *map(str, numbers)]
        found, spent = subprocess.run(
            call, check=True, capture_output=True, text=True
        ).stdout.split()[-2:]
        yield "Siconos", float(spent), int(found)


def rows():
    """Impacts a second at both points, compared with numba and SciPy."""
    loops = {"numba": numba_loop, "numba without sines": turning_loop}
    answer = []
    for name, (r, clearance) in POINTS.items():
        room = {peer: np.empty(100_000) for peer in loops}
        system = (XI, MU, RESTITUTION, r, clearance, CYCLES)
        work = {peer: partial(loop, *system, room[peer]) for peer, loop in loops.items()}
        speeds = {peer: [] for peer in ("", *loops)}
        counts = {peer: call() for peer, call in work.items()}
        for _ in range(ROUNDS):
            spent, run = seconds(lambda: vi.simulate(OSC, r, clearance, CYCLES), CALLS)  # noqa: B023
            speeds[""].append(len(run.events) / spent / 1e6)
            for peer, call in work.items():
                spent, n = seconds(call, CALLS)
                speeds[peer].append(n / spent / 1e6)
        compared = len(run.events) if name == "stable" else 12
        ours = statistics.median(speeds[""])
        task = f"simulate 1000 cycles, {name} point"
        for peer, times in room.items():
            apart = np.abs(run.events["time"][:compared] - times[:compared]).max()
            answer.append(
                row(task, "million impacts/s", ours, TARGETS[name], statistics.median(speeds[peer]), peer,
                    bool(compared <= counts[peer] and apart < 1e-9))
            )  # fmt: skip
        short = len(vi.simulate(OSC, r, clearance, 50).events)
        for peer, spent, found in integrators(r, clearance, 50):
            answer.append(
                row(task, "million impacts/s", ours, None, found / spent / 1e6, peer,
                    bool(found == short or name == "chaotic"))
            )  # fmt: skip
    return answer


if __name__ == "__main__":
    sys.exit(not show(rows()))
