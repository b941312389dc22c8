"""Seconds for basins over a plane of initial states, on one thread: this package and a numba event loop.

Table 1's set at D = 37. The numba loop simulates every state until its state at the start of a load cycle has
repeated to 1e-6 for some cycles; the sign of its position there gives which of the two mirror images it is. About
5 % of the states wander for so long that rounding decides, so fractions are compared.

Run with `python benchmarks/basin_speed.py` (needs numba).
"""

import math
import statistics
import sys
import time

import numba
import numpy as np
import vibroimpact as vi
from simulate_speed import MOST, fly
from table import row, show

OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
R, D = 0.94, 37.0
#: States along each axis: for both programs, and for this package alone.
SIDE, LARGE, ROUNDS = 60, 200, 5
AXIS = (-30.0, 30.0)


@numba.njit(fastmath=False)
def settle(xi, mu, restitution, r, clearance, x, v, most):
    """Position at the start of a load cycle once it repeats itself; NaN after so many cycles."""
    state = np.array([0.0, x, v, x, 0.0])
    calm = 0
    before_x = before_v = math.inf
    for cycle in range(1, most + 1):
        fly(
            xi,
            mu,
            restitution,
            r,
            clearance,
            2 * math.pi * cycle / r,
            state,
            state[:0],
            MOST - 1000,
        )
        if not abs(state[1]) < 1e6:
            return math.nan
        still = abs(state[1] - before_x) < 1e-6 and abs(state[2] - before_v) < 1e-6
        calm = calm + 1 if still else 0
        if calm == 5:
            return state[1]
        before_x, before_v = state[1], state[2]
    return math.nan


@numba.njit(fastmath=False)
def plane(xi, mu, restitution, r, clearance, axis, most, out):
    """`settle` from every point of the plane (x, x') with the free mass in the middle, at rest."""
    for i in range(axis.size):
        for j in range(axis.size):
            out[i, j] = settle(xi, mu, restitution, r, clearance, axis[j], axis[i], most)


def ours(side):
    """CPU seconds, and fractions of the two largest basins, the smaller one first."""
    begin = time.process_time()
    found = vi.basins(OSC, R, D, (("x", *AXIS, side), ("x_dot", *AXIS, side)), threads=1)
    return time.process_time() - begin, np.sort(np.sort(found.fractions)[-2:])


def peer(side):
    """The same by numba."""
    out = np.empty((side, side))
    begin = time.process_time()
    plane(OSC.xi, OSC.mu, 0.75, R, D, np.linspace(*AXIS, side), 5000, out)
    spent = time.process_time() - begin
    positions = np.round(out[np.isfinite(out)], 3)
    shares = np.unique(positions, return_counts=True)[1] / out.size
    return spent, np.sort(np.sort(shares)[-2:])


def rows():
    """The rows of the table."""
    peer(2)
    mine, theirs = [], []
    for _ in range(ROUNDS):
        mine.append(ours(SIDE))
        theirs.append(peer(SIDE))
    large = statistics.median(ours(LARGE)[0] for _ in range(ROUNDS))
    apart = np.abs(mine[0][1] - theirs[0][1]).max()
    # two standard errors of a fraction of 5 % that rounding decides
    same = bool(apart < 2 * math.sqrt(0.05) / SIDE)
    here, there = (statistics.median(spent for spent, _ in some) for some in (mine, theirs))
    return [
        row(
            f"basins, {SIDE} x {SIDE} states, Table 1's set", "s", here, None, there, "numba", same
        ),
        row(f"basins, {LARGE} x {LARGE} states", "s", large, 2.5),
    ]


if __name__ == "__main__":
    sys.exit(not show(rows()))
