"""Impacts a second: this package, a hand-written numba event loop, and integrators with events.

All do the same work: 1000 load cycles from rest with the parameters of Figure 6, at a stable and at a
chaotic point. The numba loop flies in closed form, looks at the gap 40 times a load cycle and finishes by
Newton: fast, but it can miss a contact that is shorter than its step. The others (50 cycles only) integrate and
look for sign changes (SciPy, SUNDIALS, Siconos) or isolate the zeros of Taylor polynomials (heyoka, in
`taylor_peer.py`). All must find the same impacts: every one at the stable point, the first 15 at the chaotic one,
where rounding grows by a factor in each.

Run with `python benchmarks/simulate_speed.py` (needs numba, SciPy and scikit-sundae; heyoka if it is installed,
Siconos where the system's Python has it).
"""

import math
import os
import statistics
import subprocess
import sys
import time
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
    """Impacts a second at both points, beside numba and SciPy."""
    room = np.empty(100_000)
    answer = []
    for name, (r, clearance) in POINTS.items():
        arguments = (XI, MU, RESTITUTION, r, clearance, CYCLES, room)
        numba_loop(*arguments)
        here, there = [], []
        for _ in range(ROUNDS):
            spent, run = seconds(lambda: vi.simulate(OSC, r, clearance, CYCLES), CALLS)  # noqa: B023
            here.append(len(run.events) / spent / 1e6)
            spent, n = seconds(lambda: numba_loop(*arguments), CALLS)  # noqa: B023
            there.append(n / spent / 1e6)
        compared = len(run.events) if name == "stable" else 15
        apart = np.abs(run.events["time"][:compared] - room[:compared]).max()
        short = len(vi.simulate(OSC, r, clearance, 50).events)
        ours = statistics.median(here)
        work = f"simulate 1000 cycles, {name} point"
        answer.append(
            row(work, "million impacts/s", ours, TARGETS[name], statistics.median(there), "numba",
                bool(compared <= n and apart < 1e-9))
        )  # fmt: skip
        for peer, spent, found in integrators(r, clearance, 50):
            answer.append(
                row(work, "million impacts/s", ours, None, found / spent / 1e6, peer,
                    bool(found == short or name == "chaotic"))
            )  # fmt: skip
    return answer


if __name__ == "__main__":
    sys.exit(not show(rows()))
