"""Cost grows linearly in points and impacts, and memory stays flat: nanoseconds each, from 10^3 to 10^8.

Points are verdicts on given phases (`stability_flags`), 10^6 at a time; impacts are those of one simulation,
continued from its final state 10^5 at a time. Ten times as many must cost ten times as much.

Run with `python benchmarks/scaling.py [LARGEST]` (10^8 takes a minute).
"""

import resource
import sys
import time

import numpy as np
import vibroimpact as vi
from table import row, show

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
PATTERN = vi.Pattern("RRL")
CHUNK = 10**6
LARGEST = 10**8
#: Load cycles of a chunk of a simulation: about 10^5 impacts.
CYCLES = 31_000


def verdicts(count):
    """CPU seconds for so many points; the phases of a chunk are made once."""
    size = min(count, CHUNK)
    phases = np.sort(np.random.default_rng(2).uniform(0, 2 * np.pi, (3, size)), axis=0)
    phases[0] = 0
    begin = time.process_time()
    for _ in range(count // size):
        vi.stability_flags(OSC, 0.97, phases, PATTERN, threads=1)
    return (time.process_time() - begin) / count


def impacts(count):
    """CPU seconds for about so many impacts of a chaotic motion."""
    state, done, spent = None, 0, 0.0
    while done < count:
        cycles = min(CYCLES, max(1, round((count - done) / 3.2)))
        begin = time.process_time()
        run = vi.simulate(OSC, 1.02, 11.25, cycles, **({} if state is None else {"state": state}))
        spent += time.process_time() - begin
        state = run.final_state
        done += max(1, len(run.events))
    return spent / done


def peak():
    """Greatest memory so far, in MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def rows(largest=LARGEST):
    """Nanoseconds each by number, and the memory."""
    answer = []
    for name, work in (("verdicts", verdicts), ("impacts", impacts)):
        work(10**3)
        count = 10**3
        while count <= largest:
            spent = min(work(count) for _ in range(3 if count < CHUNK else 1))
            power = "⁰¹²³⁴⁵⁶⁷⁸⁹"[len(str(count)) - 1]
            answer.append(row(f"10{power} {name}", "ns each", 1e9 * spent))
            count *= 10
        answer.append(row(f"memory after {name}", "MiB", peak()))
    return answer


if __name__ == "__main__":
    show(rows(*map(int, sys.argv[1:2])))
