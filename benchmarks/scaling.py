"""Time and memory from 10³ to 10⁸ of what a study computes: ten times as many must cost ten times as much.

Each number is measured in a process of its own: CPU time, and the greatest memory beyond that of a small piece of
the same work. What is not kept is computed in chunks, so its memory stays the same: verdicts on given phases
(`stability_flags`), 10⁶ at a time; impacts of one simulation, continued from its final state 10⁵ at a time; points
of charts in a campaign, 10⁴ a case and 10 cases a chunk, whose results are on disk. What is kept grows: events of
a trajectory, states of basins (Table 1's set), and impacts of a chain of 100 cells with the coordinates of all
bodies.

Run with `python benchmarks/scaling.py [LARGEST]`; the largest numbers, up to 10⁸, take four minutes.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import vibroimpact as vi
from table import row, show

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
PATTERN = vi.Pattern("RRL")
CHUNK = 10**6
#: A chart of equispaced motions.
CHART = """&system
  xi = 0.01
  mu = 0.028
  restitution = 0.75
/
&chart
  sides = 'RL'
  symmetric = 'yes'
  r_min = 0.8
  r_max = 1.2
  r_points = {0}
  clearance_min = 2
  clearance_max = 200
  clearance_points = {0}
/
"""
#: Load cycles of a chunk of a simulation, about 10⁵ impacts, and impacts of a load cycle.
CYCLES, IMPACTS = 31_000, 3.2
#: Impacts of a unit of time of the chain, once all of it moves.
RATE = 42


def verdicts(count):
    """Verdicts; the phases of a chunk are made once."""
    size = min(count, CHUNK)
    phases = np.sort(np.random.default_rng(2).uniform(0, 2 * np.pi, (3, size)), axis=0)
    phases[0] = 0
    begin = time.process_time()
    for _ in range(count // size):
        vi.stability_flags(OSC, 0.97, phases, PATTERN, threads=1)
    return time.process_time() - begin, count


def impacts(count):
    """About so many impacts of a chaotic motion."""
    state, done = None, 0
    begin = time.process_time()
    while done < count:
        cycles = min(CYCLES, max(1, round((count - done) / IMPACTS)))
        run = vi.simulate(OSC, 1.02, 11.25, cycles, **({} if state is None else {"state": state}))
        state = run.final_state
        done += max(1, len(run.events))
    return time.process_time() - begin, done


def events(count):
    """Events of one trajectory."""
    begin = time.process_time()
    run = vi.simulate(OSC, 1.02, 11.25, count / IMPACTS, max_events=5 * 10**7)
    return time.process_time() - begin, len(run.events)


def states(count):
    """States of a plane."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    side = round(count**0.5)
    axis = (-30.0, 30.0)
    begin = time.process_time()
    vi.basins(osc, 0.94, 37.0, (("x", *axis, side), ("x_dot", *axis, count // side)), threads=1)
    return time.process_time() - begin, side * (count // side)


def points(count):
    """Points of charts of at most 100 x 100."""
    side = min(100, round(count**0.5))
    sweep = vi.Sweep(CHART.format(side), {"xi": np.linspace(0.005, 0.02, max(1, count // side**2))})
    with tempfile.TemporaryDirectory() as folder:
        begin = time.process_time()
        vi.campaign(sweep, Path(folder) / "store", chunk=10, threads=1)
        return time.process_time() - begin, len(sweep) * side**2


def lattice(count):
    """Impacts of a chain of 100 cells."""
    from structure_speed import chain

    structure, velocity = chain(100), np.zeros(200)
    velocity[0] = -10.0
    begin = time.process_time()
    run = vi.simulate(structure, duration=count / RATE, state=(np.zeros(200), velocity))
    return time.process_time() - begin, len(run.events)


#: What is computed, its least and largest numbers, and the number of the small piece that is measured first.
WORKS = {
    "verdicts": (verdicts, 10**3, 10**8, 10**3),
    "impacts, not kept": (impacts, 10**3, 10**8, 10**3),
    "points of a campaign": (points, 10**4, 10**7, 10**4),
    "events of a trajectory": (events, 10**3, 10**7, 100),
    "states of basins": (states, 10**3, 10**6, 25),
    "impacts of a chain of 100 cells": (lattice, 10**3, 10**5, 10),
}


def alone(name, count):
    """Seconds and bytes for one of a number, measured in this process."""
    work, _, _, small = WORKS[name]
    work(small)
    before = memory("VmRSS")
    spent, done = work(count)
    return spent / done, max(memory("VmHWM") - before, 0) / done


def memory(kind):
    """Bytes of this process, now (VmRSS) or at most (VmHWM); `getrusage` would count the calling process too."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith(f"{kind}:"))


def measured(name, count):
    """The same in a process of its own."""
    call = [sys.executable, __file__, name, str(count)]
    answer = subprocess.run(call, check=True, capture_output=True, text=True).stdout.split()
    return tuple(map(float, answer))


def rows(largest=10**8):
    """Nanoseconds and bytes of each, by number."""
    answer = []
    for name, (_, least, most, _) in WORKS.items():
        count = least
        while count <= min(most, largest):
            spent, room = measured(name, count)
            power = "⁰¹²³⁴⁵⁶⁷⁸⁹"[len(str(count)) - 1]
            answer.append(row(f"10{power} {name}", "ns each", 1e9 * spent))
            answer.append(row(f"10{power} {name}: memory", "MB", 1e-6 * room * count))
            count *= 10
    return answer


if __name__ == "__main__":
    if len(sys.argv) > 2:
        print(*alone(sys.argv[1], int(sys.argv[2])))
    else:
        show(rows(*map(int, sys.argv[1:2])))
