"""`vibroimpact bench`: the speed of the installed package on this machine, in a few seconds."""

from __future__ import annotations

import argparse
import math
import platform
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import numpy as np

from .. import _core
from ..motions.flags import stability_flags
from ..motions.trajectory import simulate
from ..studies.zone import zone
from ..systems.oscillator import Oscillator, Pattern
from .doctor import built, threads

HELP = "measure the speed of the installed package on this machine"
DESCRIPTION = """Measure the speed of the installed package, within about five seconds: simulated impacts,
verdicts on motions with given phases, a chart and the boundary of a zone. Each number is
processor time on one thread, the best of repeated runs; charts and verdicts divide their
work among all threads. For comparisons with other programs see the benchmarks of the
project."""
EXAMPLE = "vibroimpact bench"

#: Processor time in seconds spent on each line.
BUDGET = 1.0
OSC = Oscillator(xi=0.0114, mu=0.028, restitution=0.75)


def arguments(parser: argparse.ArgumentParser) -> None:
    """None of its own."""


def run(options: argparse.Namespace) -> int:
    """Measure, and print each number as it comes."""
    facts = {
        "vibroimpact": metadata.version("vibroimpact"),
        "machine": machine(),
        "compiler": built()["compiler"],
        "lapack": built()["lapack"],
        "threads": f"measured on 1; {threads()}",
    }
    for name, value in facts.items():
        print(f"{name + ':':<13} {value}")
    measured: dict[str, float] = {}
    for name, (label, unit, measure) in MEASURES.items():
        measured[name] = measure()
        print(f"{label:<62} {measured[name]:>12,.4g} {unit}", flush=True)
    options.record.add("bench", {**facts, **measured})
    return 0


def machine() -> str:
    """The processor, by its own name where the system tells it."""
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        name = next(line.partition(":")[2].strip() for line in lines if line.startswith("model n"))
    except (OSError, StopIteration):  # not Linux, or an unnamed processor
        pass
    return f"{name}, {platform.system()} {platform.machine()}"


def best(work: Callable[[], int]) -> float:
    """Seconds for one of the things of which `work` does as many as it says, in its fastest run."""
    work()  # memory pages are allocated from now on
    fastest, end = math.inf, time.process_time() + BUDGET
    while fastest == math.inf or time.process_time() < end:
        begin = time.process_time()
        done = work()
        fastest = min(fastest, (time.process_time() - begin) / done)
    return fastest


def impacts() -> int:
    """Simulate two impacts a cycle and more."""
    return int(simulate(OSC, r=1.04, clearance=25.0, cycles=5000).events.size)


def verdicts() -> int:
    """Three impacts a cycle, their phases given: consistent or not, stable or not."""
    n = 1 << 16
    random = np.random.default_rng(1983)
    phases = np.sort(random.uniform(0, 2 * math.pi, (3, n)), axis=0)
    phases[0] = 0
    return len(stability_flags(OSC, random.uniform(0.8, 1.2, n), phases, Pattern("RLR"), threads=1))


def chart() -> int:
    """Both equispaced motions at 200 x 200 points, with their multipliers."""
    r, clearance = np.linspace(0.8, 1.2, 200), np.geomspace(2, 200, 200)
    _core.equispaced_chart(OSC.xi, OSC.mu, OSC.restitution, r, clearance, 1, True, 1)
    return 1


def vertices() -> int:
    """The whole zone of two impacts a cycle, searched and followed."""
    return sum(map(len, zone(OSC, Pattern("RL"), r=(0.8, 1.2), clearance=(2, 200)).loops))


#: By their names in `--json`: what is measured, its unit, and how.
MEASURES: dict[str, tuple[str, str, Callable[[], float]]] = {
    "impacts_per_second": ("simulated impacts, one trajectory", "a second", lambda: 1 / best(impacts)),
    "verdicts_per_second": ("verdicts, three impacts with given phases", "a second", lambda: 1 / best(verdicts)),
    "chart_ms": ("chart of 200 x 200 points, equispaced, with multipliers", "ms", lambda: 1e3 * best(chart)),
    "vertex_us": ("vertex of the zone RL/1, the search for it included", "us", lambda: 1e6 * best(vertices)),
}  # fmt: skip
