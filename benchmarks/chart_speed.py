"""Time of a chart of the equispaced motion, 200 x 200 points, and of exact motions followed over it.

The peers: a numba loop that intersects the same line and circle and computes the multipliers of [P], and checks no
flights between impacts; and the core's general procedures, one motion after the other.

Run with `python benchmarks/chart_speed.py` (needs numba).
"""

import math
import statistics
import sys
import time

import numba
import numpy as np
import vibroimpact as vi
from flags_speed import equations, largest_modulus, monodromy
from table import row, show
from vibroimpact import _core

ROUNDS = 7
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
R, D = np.linspace(0.8, 1.2, 200), np.geomspace(2, 200, 200)


def medians(*calls):
    """Median CPU time of each call in milliseconds, the calls taking turns."""
    times = [[] for _ in calls]
    for _ in range(ROUNDS):
        for call, spent in zip(calls, times, strict=True):
            begin = time.process_time()
            call()
            spent.append(1e3 * (time.process_time() - begin))
    return [statistics.median(spent) for spent in times]


def pair(multipliers):
    """The core's part of a chart of the equispaced motions, on one thread."""
    _core.equispaced_chart(OSC.xi, OSC.mu, OSC.restitution, R, D, 1, multipliers, 1)


def one_after_the_other():
    """The same answers by the general procedures, one motion after the other."""
    return _core.equispaced(
        OSC.xi, OSC.mu, OSC.restitution, np.repeat(R, D.size), np.tile(D, R.size), 1, 0.03, False, True
    )  # fmt: skip


@numba.njit(fastmath=True)
def numba_chart(xi, mu, restitution, r, clearance, radii):
    """Spectral radius of both equispaced motions (2, D, R), NaN where there is none; flights are not checked."""
    alpha, wall = np.array([0.0, math.pi]), np.full(2, restitution)
    a, x, y = np.empty((4, 5)), np.empty(4), np.empty(2)
    p, part, new = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4))
    radii[:] = np.nan
    for i in range(r.size):
        # with x_2 = -x_1 a line in (A cos(tau), A sin(tau)), here for clearance 1, and the circle of radius A
        equations(xi, mu, r[i], alpha, np.array([0.5, -0.5]), wall, a)
        w, v = a[0], a[2]
        w1, v1 = w[0] - w[1], v[0] - v[1]
        n0, n1 = v1 * w[2] - w1 * v[2], v1 * w[3] - w1 * v[3]
        length = math.hypot(n0, n1)
        n0, n1, far = n0 / length, n1 / length, (v1 * w[4] - w1 * v[4]) / length
        amplitude = 1 / math.hypot(1 - r[i] * r[i], 2 * xi * r[i])
        for j in range(clearance.size):
            d = far * clearance[j]
            if abs(d) > amplitude:
                continue
            chord = math.sqrt((amplitude - d) * (amplitude + d))
            y[0], y[1] = 0.5 * clearance[j], -0.5 * clearance[j]
            for k in range(2):
                along = chord if k == 0 else -chord
                x[2], x[3] = d * n0 - along * n1, d * n1 + along * n0
                if abs(w1) >= abs(v1):
                    x[0] = (w[4] * clearance[j] - w[2] * x[2] - w[3] * x[3]) / w1
                else:
                    x[0] = (v[4] * clearance[j] - v[2] * x[2] - v[3] * x[3]) / v1
                x[1] = -x[0]
                monodromy(xi, mu, r[i], alpha, y, wall, x, p, part, new)
                radii[k, j, i] = largest_modulus(p)


def same_verdicts(radii):
    """Whether numba and the core find the same motions with the same stability."""
    _, _, verdicts, status = _core.equispaced_chart(
        OSC.xi, OSC.mu, OSC.restitution, R, D, 1, False, 1
    )
    there = status == 0
    clear = there & (np.abs(radii - 1) > 1e-9)
    return bool(
        np.array_equal(there, ~np.isnan(radii))
        and np.array_equal(verdicts[2][clear] == 1, radii[clear] < 1)
    )


def same_answers():
    """Whether both ways of the core give the same verdicts and the same largest positions."""
    scalars, _, verdicts, status = _core.equispaced_chart(
        OSC.xi, OSC.mu, OSC.restitution, R, D, 1, False, 1
    )
    _, general, _, decided, code = one_after_the_other()
    # (rows, 2, D, R) against (rows, R * D * 2)
    general = general.reshape(6, R.size, D.size, 2).transpose(0, 3, 2, 1)
    decided = decided.reshape(3, R.size, D.size, 2).transpose(0, 3, 2, 1)
    code = code.reshape(R.size, D.size, 2).transpose(2, 1, 0)
    there = status == 0
    return bool(
        np.array_equal(status, code)
        and np.array_equal(verdicts[:, there], decided[:, there])
        and np.allclose(scalars[3][there], general[5][there], rtol=1e-10, atol=0)
    )


def rows():
    """Milliseconds of the chart, by this package and both peers."""
    radii = np.empty((2, D.size, R.size))

    def loop():
        numba_chart(OSC.xi, OSC.mu, OSC.restitution[0], R, D, radii)

    loop()
    ours, numba_time, general = medians(lambda: pair(False), loop, one_after_the_other)
    work = "chart of the equispaced motion, 200 x 200"
    return [
        row(work, "ms", ours, 12.0, numba_time, "numba, flights not checked", same_verdicts(radii)),
        row(work, "ms", ours, None, general, "one motion after the other", same_answers()),
    ]


def multipliers_row():
    """The chart with all multipliers."""
    (spent,) = medians(lambda: pair(True))
    return row("equispaced motion with multipliers, 200 x 200", "ms", spent)


def exact_row():
    """The same for an exact motion: search, continuation over the grid, verdicts, dataset."""
    (spent,) = medians(lambda: vi.chart(OSC, vi.Pattern("RRL"), R, D, threads=1))
    return row("chart of exact motions RRL, 200 x 200", "ms", spent)


if __name__ == "__main__":
    sys.exit(not show([*rows(), multipliers_row(), exact_row()]))
