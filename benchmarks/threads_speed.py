"""How much faster two threads are than one, by the clock, with the same answers to the last bit.

Run with `python benchmarks/threads_speed.py` on an otherwise idle machine. Other programs can only lengthen a
round, so that the ratio is that of the least times.
"""

import sys
import time

import numpy as np
import vibroimpact as vi
from table import row, show

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
PAIR, THREE = vi.Pattern("RL"), vi.Pattern("RRL")
ROUNDS, TARGET = 9, 1.8
R, D = np.linspace(0.8, 1.2, 120), np.geomspace(2, 200, 120)
RANDOM = np.random.default_rng(1)
PHASES = np.sort(RANDOM.uniform(0, 2 * np.pi, (3, 2_000_000)), axis=0)
PHASES[0] = 0
PLANE = (("x", -30, 30, 120), ("x_dot", -30, 30, 120))


def states(count):
    """Initial states within the walls."""
    x = RANDOM.uniform(-20, 20, (5, count))
    x[0], x[3] = 0, x[1]
    return x


STATES = states(400)


def bundle(threads):
    """Simulations of many states."""
    found = vi.simulate_bundle(OSC, 1.02, 11.25, 400, STATES, threads=threads)
    return np.stack([found.t, found.x, found.x_dot, found.z, found.z_dot])


def atlas(threads):
    """All zones of a window."""
    found = vi.atlas(OSC, (0.9, 1.1), (10, 90), max_impacts=5, survey=100, threads=threads)
    return np.concatenate([ring.ravel() for zone in found.zones for ring in zone.loops])


WORK = {
    "chart, exact motions": lambda n: vi.chart(OSC, THREE, R, D, threads=n).x_max.values,
    "atlas of zones": atlas,
    "basins": lambda n: vi.basins(OSC, 1.04, 30.0, PLANE, threads=n).labels,
    "simulations of many states": bundle,
    "verdicts on given phases": lambda n: (
        vi.stability_flags(OSC, 0.97, PHASES, THREE, threads=n).stable
    ),
}


def rows():
    """The speedup by two threads."""
    answer = []
    for name, work in WORK.items():
        times = {1: [], 2: []}
        for _ in range(ROUNDS):
            found = {}
            for threads in times:
                begin = time.perf_counter()
                found[threads] = work(threads)
                times[threads].append(time.perf_counter() - begin)
        ratio = min(times[1]) / min(times[2])
        same = bool(np.array_equal(found[1], found[2], equal_nan=found[1].dtype.kind == "f"))
        answer.append(row(f"two threads, {name}", "times", ratio, TARGET, 1.0, "one thread", same))
    return answer


if __name__ == "__main__":
    sys.exit(not show(rows()))
