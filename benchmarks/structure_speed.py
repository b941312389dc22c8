"""Simulation of structures: chains of cells with a free mass each, and two masses.

The time of a chain is that of a run less that of a run of no duration, so that it is the time of the flights
and impacts without the preparation. The cost of an impact should grow as channels x modes of the bodies it
touches. Two masses are simulated by the path for any structure, as a structure that is recognised as the
oscillator of 1983, and as that oscillator; all do the same work.

Run with `python benchmarks/structure_speed.py`.
"""

import time

import numpy as np
import vibroimpact as vi
from table import row, show

ROUNDS = 7
#: Targets (ms) on an idle processor: 86 impacts of 20 and of 100 cells; 100 cells to t = 200.
TARGETS = {20: 0.3, 100: 2.0}
LONG_TARGET = 150.0


def chain(cells):
    """A free-free chain of hosts, each with a free mass in a slot."""
    stiffness = np.zeros((2 * cells, 2 * cells))
    for i in range(cells - 1):
        stiffness[i : i + 2, i : i + 2] += [[1, -1], [-1, 1]]
    gaps = []
    for i in range(cells):
        direction = np.zeros(2 * cells)
        direction[[i, cells + i]] = -1, 1
        gaps += [vi.Gap(direction, 1.0), vi.Gap(-direction, 1.0)]
    return vi.Structure([1.0] * cells + [0.3] * cells, np.zeros(2 * cells), stiffness, gaps)


def spent(work, rounds=ROUNDS):
    """Least CPU time of a call (ms), and its result."""
    best = np.inf
    for _ in range(rounds):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
    return 1e3 * best, result


def of_chain(cells, duration, rounds=ROUNDS):
    """Time (ms) of the flights and impacts of a chain whose first host is hit, and their number."""
    structure = chain(cells)
    velocity = np.zeros(2 * cells)
    velocity[0] = -10.0
    state = (np.zeros(2 * cells), velocity)
    whole, run = spent(lambda: vi.simulate(structure, duration=duration, state=state), rounds)
    empty, _ = spent(lambda: vi.simulate(structure, duration=0, state=state), rounds)
    return whole - empty, len(run.events)


def two_masses(r, clearance):
    """Time (us) of an impact: path for any structure, recognised structure, oscillator; whether they agree."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    load = vi.Load(r, sine=[1, 0])

    def structure(other):
        gaps = [vi.Gap([-1, 1], clearance / 2, 0.75), vi.Gap([1, -1], other, 0.75)]
        return vi.Structure([1, 0.028], [2 * 0.0114, 0], [1, 0], gaps)

    # with openings that differ in the last bit a structure is not the oscillator
    general, recognised = structure(np.nextafter(clearance / 2, 0)), structure(clearance / 2)
    runs = (
        lambda cycles: vi.simulate(general, load, cycles=cycles),
        lambda cycles: vi.simulate(recognised, load, cycles=cycles),
        lambda cycles: vi.simulate(osc, r, clearance, cycles=cycles),
    )
    costs = []
    for simulate in runs:
        long, events = spent(lambda f=simulate: f(9000))
        short, few = spent(lambda f=simulate: f(1000))
        costs.append(1e3 * (long - short) / (len(events.events) - len(few.events)))
    first = [simulate(20).events["time"][:10] for simulate in runs]
    return *costs, bool(np.ptp(first, 0).max() < 1e-9)


def rows():
    """The rows of the table."""
    table = []
    for cells in (10, 20, 50, 100, 200):
        time_spent, impacts = of_chain(cells, 10)
        table += [
            row(f"chain of {cells} cells: {impacts} impacts", "ms", time_spent, TARGETS.get(cells)),
            row(
                f"chain of {cells} cells: an impact, over channels x modes", "ns",
                1e6 * time_spent / impacts / cells**2,
            ),
        ]  # fmt: skip
    time_spent, impacts = of_chain(100, 200, 2)
    table.append(row(f"chain of 100 cells: {impacts} impacts", "ms", time_spent, LONG_TARGET))
    for name, point in {"stable": (1.04, 25.0), "chaotic": (1.02, 11.25)}.items():
        general, recognised, kernel, same = two_masses(*point)
        for path, cost in {"any structure": general, "recognised": recognised}.items():
            work = f"two masses, {path}, {name}: an impact"
            table.append(row(work, "us", cost, None, kernel, "own oscillator", same))
    return table


if __name__ == "__main__":
    raise SystemExit(0 if show(rows()) else 1)
