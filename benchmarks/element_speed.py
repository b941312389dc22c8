"""Simulation with elastic stops and dry friction: cost of an event, beside SciPy started again at each event.

The systems are a driven mass that meets a stop of 100 times its stiffness, and a driven mass with dry friction
strong enough to stick. Both sides must find the same events. A contact with the stop is two events.

Run with `python benchmarks/element_speed.py` (the rows of SciPy need SciPy).
"""

import math
import time

import numpy as np
import vibroimpact as vi
from table import row, show

ROUNDS = 5
#: Load cycles: ours, and the first of them by SciPy.
CYCLES, FEW = 2000, 40
STOP, SLIP = 100.0, 0.6


def spent(work, rounds):
    """Least CPU time of a call (s), and its result."""
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
    return best, result


def systems():
    """Structures and loads by name, with what SciPy integrates."""
    stop = vi.Structure([1], [0.1], [1], [vi.Stop([1], 1.0, STOP)])
    slider = vi.Structure([1], [0.02], [1], friction=[vi.Friction([1], SLIP)])
    return {
        "an elastic stop": (stop, 1.0, scipy_stop),
        "friction with stick": (slider, 0.4, scipy_friction),
    }


def scipy_stop(solve, end):
    """Times at which the stop is touched and left."""
    return integrated(
        solve, end, False,
        lambda t, y, presses: [
            y[1], math.cos(t) - 0.1 * y[1] - y[0] - (STOP * (y[0] - 1) if presses else 0.0)
        ],
        lambda t, y, presses: (1 - y[0]) * (-1 if presses else 1),
        lambda t, y, presses: not presses,
    )  # fmt: skip


def scipy_friction(solve, end):
    """Times at which the mass halts and slips."""

    def drive(t, y):
        return math.cos(0.4 * t) - y[0]

    def after(t, y, sense):
        if sense and abs(drive(t, y)) <= SLIP:
            y[1] = 0.0
            return 0
        return 1 if drive(t, y) > 0 else -1

    return integrated(
        solve, end, 0,
        lambda t, y, sense: [y[1], drive(t, y) - 0.02 * y[1] - SLIP * sense] if sense else [0.0, 0.0],
        lambda t, y, sense: sense * y[1] if sense else SLIP - abs(drive(t, y)),
        after, start=lambda t, y: after(t, y, 0) if abs(drive(t, y)) > SLIP else 0,
    )  # fmt: skip


def integrated(solve, end, regime, motion, limit, after, start=None):
    """Times of events, at each of which the integration is started again in another regime.

    Steps are bounded where nothing moves: they would grow beyond events.
    """
    t, y, times = 0.0, np.zeros(2), []
    if start:
        regime = start(t, y)

    def falls(t, y, regime):
        return limit(t, y, regime)

    falls.terminal, falls.direction = True, -1
    while t < end:
        still = start is not None and regime == 0
        found = solve(
            motion, (t, end), y, method="DOP853", rtol=1e-10, atol=1e-12, events=falls, args=(regime,),
            max_step=0.5 if still else np.inf,
        )  # fmt: skip
        t, y = found.t[-1], found.y[:, -1].copy()
        if found.status == 1:
            times.append(t)
            regime = after(t, y, regime)
    return np.array(times)


def rows():
    try:
        from scipy.integrate import solve_ivp
    except ImportError:
        solve_ivp = None
    table = []
    for name, (structure, frequency, peer) in systems().items():
        load = vi.Load(frequency, cosine=[1.0])
        ours, run = spent(
            lambda s=structure, w=load: vi.simulate(
                s, w, cycles=CYCLES, state=([0.0], [0.0]), max_events=10**6
            ),
            ROUNDS,
        )
        cost, there, same = 1e6 * ours / len(run.events), None, None
        if solve_ivp:
            end = FEW * 2 * math.pi / frequency
            slow, times = spent(lambda p=peer, e=end: p(solve_ivp, e), 1)
            known = run.events["time"]
            known = known[(known > 0) & (known < end - 1e-3)]
            same = len(times) >= len(known) and bool(
                np.abs(times[: len(known)] - known).max() < 1e-6
            )
            there = 1e6 * slow / len(times)
        table.append(
            row(f"{name}: an event", "us", cost, None, there, "SciPy" if there else "", same)
        )
    return table


if __name__ == "__main__":
    raise SystemExit(0 if show(rows()) else 1)
