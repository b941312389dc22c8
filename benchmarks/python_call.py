#!/usr/bin/env python3
"""Microseconds of one `vibroimpact.periodic` call at N = 3, its validation and result included."""

import math
import statistics
import time

import vibroimpact as vi

TARGET = 60.0
ROUNDS = 25
CALLS = 400


def main():
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    pattern = vi.Pattern("RLR", cycles=1)
    phases = [0.0, 0.9 * math.pi, 1.7 * math.pi]
    vi.periodic(osc, 0.97, phases, pattern)
    rounds = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(CALLS):
            vi.periodic(osc, 0.97, phases, pattern)
        rounds.append((time.perf_counter() - start) / CALLS * 1e6)
    median = statistics.median(rounds)
    print(
        f"one periodic call, N = 3: median {median:.1f} us, best {min(rounds):.1f} us, target {TARGET:.0f} us"
    )


if __name__ == "__main__":
    main()
