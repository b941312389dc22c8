"""Seconds for a design: the warm search, and its confirmation by samples; compared with a grid of `response`.

A damper for r from 1 to 1.04 with uncertain restitution: the clearance and the mass for which max|X|/A stays
below 0.3 for 99 % of the units. The peer is what one would write by hand: `vi.response` for the nominal unit at
each point of a grid, whose best point is taken. The answers agree if some candidate is at least as good as the
best point of the grid, for the nominal unit.

Run with `python benchmarks/design_speed.py`.
"""

import sys
import time

import numpy as np
import vibroimpact as vi
from table import row, show

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
BAND, FREE = (1.0, 1.04), {"clearance": (10, 60), "mu": (0.01, 0.1)}
ASKED = {"r": BAND, "free": FREE, "tolerance": {"restitution": (0.65, 0.8)}, "limit": 0.3}
#: Points of the grid along each free parameter, frequencies of each, and samples of the confirmation.
SIDE, NODES, SAMPLES = 12, 9, 100_000


def seconds(work):
    """Seconds of the wall clock, and the result."""
    begin = time.perf_counter()
    found = work()
    return time.perf_counter() - begin, found


def level(clearance, mu):
    """The largest max|X|/A of the nominal unit over the band."""
    osc = vi.Oscillator(xi=OSC.xi, mu=mu, restitution=OSC.restitution)
    nodes = np.linspace(*BAND, NODES)
    return vi.response(osc, nodes, clearance=clearance, states=2, settling=200).highest.max()


def brute():
    """The best level on the grid."""
    clearances, masses = np.linspace(*FREE["clearance"], SIDE), np.linspace(*FREE["mu"], SIDE)
    return min(level(float(clearance), float(mu)) for clearance in clearances for mu in masses)


def rows():
    """The rows of the table."""
    vi.design(OSC, samples=0, **ASKED)  # warm
    search, found = seconds(lambda: vi.design(OSC, samples=0, **ASKED))
    sure, found = seconds(lambda: found.confirm(SAMPLES))
    grid, best = seconds(brute)
    same = bool(found.candidates["nominal"].min() <= 1.02 * best)
    return [
        row(
            "design: search for 2 parameters, 16 uncertain units, warm", "s", search, 1.0, grid,
            f"grid of {SIDE}x{SIDE} by response, nominal unit", same,
        ),
        row(f"design: confirmation by {SAMPLES} samples", "s", sure, 5.0),
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(not show(rows()))
