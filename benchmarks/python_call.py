#!/usr/bin/env python3
"""Microseconds of one `vibroimpact.periodic` call at N = 3, its validation and result included."""

import math
import statistics
import time

import vibroimpact as vi
from table import row, show

TARGET = 60.0
ROUNDS = 25
CALLS = 400


def rows():
    """The one row."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    pattern = vi.Pattern("RLR", cycles=1)
    phases = [0.0, 0.9 * math.pi, 1.7 * math.pi]
    vi.periodic(osc, 0.97, phases, pattern)
    times = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        for _ in range(CALLS):
            vi.periodic(osc, 0.97, phases, pattern)
        times.append((time.process_time() - begin) / CALLS * 1e6)
    return [row("one call of periodic, N = 3", "µs", statistics.median(times), TARGET)]


if __name__ == "__main__":
    show(rows())
