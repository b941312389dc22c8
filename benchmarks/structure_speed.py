"""Simulation of structures: chains of cells with a free mass each, a frame under a record, and two masses.

The time of a chain is that of a run less that of a run of no duration, so that it is the time of the flights
and impacts without the preparation. The cost of an impact should grow as channels x modes of the bodies it
touches. Two masses are simulated by the procedures for any structure, as a structure that is recognised as the
oscillator of 1983, and as that oscillator; all do the same work. Another peer, if it is installed, is heyoka.

Run with `python benchmarks/structure_speed.py`.
"""

import time

import numpy as np
import taylor_peer
import vibroimpact as vi
from table import row, show

ROUNDS = 7
#: Targets (ms) on an idle processor: 86 impacts of 20 and of 100 cells; 100 cells to t = 200.
TARGETS = {20: 0.3, 100: 2.0}
LONG_TARGET = 150.0
#: Times to which chains are simulated to compare the cost of an impact, which should grow less than the cells.
GROWTH = {20: 200, 100: 200, 200: 150}
#: Target (ms) of 10^5 samples of a record.
RECORD_TARGET = 30.0


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


def of_record(samples):
    """Time (ms) of a frame of five storeys under a record, with a free mass in a slot on its roof; its impacts.

    The record is noise through a filter of 15 rad/s, sampled at 100 Hz; the fundamental frequency of the frame is
    7 rad/s. The time of a run of no duration is subtracted, as for chains.
    """
    stiffness = np.zeros((6, 6))
    stiffness[:5, :5] = 600 * (2 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1))
    stiffness[4, 4] = 600
    direction = np.array([0, 0, 0, 0, -1, 1])
    gaps = [vi.Gap(direction, 0.1, 0.6), vi.Gap(-direction, 0.1, 0.6)]
    frame = vi.Structure([1.0] * 5 + [0.1], 0.002 * stiffness, stiffness, gaps)
    step, noise = 0.01, np.random.default_rng(1).normal(size=samples)
    force, y, rate = np.zeros((samples, 6)), 0.0, 0.0
    for i in range(samples):
        y, rate = y + step * rate, rate + step * (-15 * rate - 225 * y + 90 * noise[i])
        force[i, :5] = -rate
    record = vi.Record(step, force)
    whole, run = spent(lambda: vi.simulate(frame, record))
    empty, _ = spent(lambda: vi.simulate(frame, record, duration=0))
    return whole - empty, int(np.sum(run.events["kind"] == "impact"))


def chain_by_heyoka(cells, duration):
    """Time (ms) of the same by heyoka, whose compilation does not count, and the times of its impacts."""
    import heyoka as hy

    stiffness = chain(cells).stiffness[:cells, :cells]
    forces = [hy.expression(0.0)] * cells
    integrator, times = taylor_peer.hosts_and_particles(stiffness, forces, 0.3, 1.0, 1.0)
    start = np.zeros(4 * cells)
    start[cells] = -10.0

    def run():
        times.clear()
        taylor_peer.restart(integrator, 0.0, start)
        integrator.propagate_until(duration)
        return list(times)

    return spent(run)


def two_masses(r, clearance):
    """Times (us) of an impact: any structure, recognised, the oscillator; the ten first impacts of each."""
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
    return costs, np.array(first)


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
    if taylor_peer.here():
        cells, duration = 20, 10
        time_spent, impacts = of_chain(cells, duration)
        there, times = chain_by_heyoka(cells, duration)
        work = f"chain of {cells} cells: {impacts} impacts"
        same = len(times) == impacts
        table.append(row(work, "ms", time_spent, None, there, taylor_peer.NAME, same))
    costs = {}
    for cells, duration in GROWTH.items():
        time_spent, impacts = of_chain(cells, duration, 3)
        costs[cells] = time_spent / impacts
    smallest = min(costs)
    table += [
        row(
            f"chain: an impact of {cells} cells over one of {smallest}", "-",
            costs[cells] / costs[smallest], cells / smallest,
        )
        for cells in costs if cells > smallest
    ]  # fmt: skip
    time_spent, impacts = of_chain(100, 200, 2)
    table.append(row(f"chain of 100 cells: {impacts} impacts", "ms", time_spent, LONG_TARGET))
    time_spent, impacts = of_record(100_000)
    table.append(
        row(
            f"frame under a record of 10⁵ samples: {impacts} impacts",
            "ms",
            time_spent,
            RECORD_TARGET,
        )
    )
    for name, point in {"stable": (1.04, 25.0), "chaotic": (1.02, 11.25)}.items():
        (*costs, kernel), first = two_masses(*point)
        peers = {"as an Oscillator": (kernel, first[-1])}
        if taylor_peer.here():
            there, times = spent(taylor_peer.simulate(0.0114, 0.028, 0.75, *point, 1000))
            peers[taylor_peer.NAME] = 1e3 * there / len(times), times[:10]
        for path, cost, found in zip(("any structure", "recognised"), costs, first, strict=False):
            for peer, (there, times) in peers.items():
                same = bool(np.abs(found - times).max() < 1e-9)
                work = f"two masses, {path}, {name}: an impact"
                table.append(row(work, "µs", cost, None, there, peer, same))
    return table


if __name__ == "__main__":
    raise SystemExit(0 if show(rows()) else 1)
