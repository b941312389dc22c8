"""CPU time of a campaign compared with a plain threaded call: cases of about a second, and many of a millisecond.

The peer runs the same cases by a pool of threads of Python, keeps the results in a list, and writes nothing. The
campaign packs, writes and hashes them too. The answers agree if all results are the same.

Run with `python benchmarks/campaign_speed.py`.
"""

import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import vibroimpact as vi
from table import row, show
from vibroimpact.results import door
from vibroimpact.results.noun import result_class

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
THREADS = 2
#: Load cycles that take about a second, and the numbers of long and of short cases.
CYCLES, LONG, SHORT = 700_000, 6, 2000


def seconds(work):
    """CPU seconds of this process, and the result."""
    begin = time.process_time()
    found = work()
    return time.process_time() - begin, found


def plain(study, sweep):
    """The results of all cases."""
    with ThreadPoolExecutor(THREADS) as pool:
        texts = (sweep.text(i) for i in range(len(sweep)))
        return list(pool.map(lambda text: door.run_text(result_class(study), text), texts))


def compared(what, study, sweep, target, chunk=None):
    """The row of one campaign."""
    with tempfile.TemporaryDirectory() as folder:
        store = Path(folder) / "store"
        ours, found = seconds(lambda: vi.campaign(sweep, store, chunk=chunk, threads=THREADS))
        theirs, results = seconds(lambda: plain(study, sweep))
        places = np.linspace(0, len(sweep) - 1, 6).astype(int).tolist()
        same = all(found[i].to_dict() == results[i].to_dict() for i in places)
    each = f"{1e3 * theirs / len(sweep):.2g} ms"
    return row(
        f"campaign: {len(sweep)} {what} of {each}, CPU time over the plain call", "times the CPU",
        ours / theirs, target, 1.0, "pool of threads, results kept in memory", same,
    )  # fmt: skip


def rows():
    """The rows of the table."""
    long = vi.lyapunov(OSC, 1.04, 25.0, cycles=CYCLES).to_namelist()
    short = vi.equispaced(OSC, r=1.0, clearance=20.0)[0].to_namelist()
    grid = {"r": np.linspace(0.9, 1.1, 50), "clearance": np.geomspace(2, 200, SHORT // 50)}
    compared("", "motion", vi.Sweep(short, {"r": [0.9, 1.0]}), None)  # warm: loads zarr
    return [
        compared("cases", "lyapunov", vi.Sweep(long, {"clearance": np.linspace(20, 30, LONG)}), 1.1, chunk=1),
        compared("cases in 100 chunks", "motion", vi.Sweep(short, grid), None),
        compared("cases in 2 chunks", "motion", vi.Sweep(short, grid), None, chunk=SHORT // 2),
    ]  # fmt: skip


if __name__ == "__main__":
    sys.exit(not show(rows()))
