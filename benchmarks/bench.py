"""All measurements in one table: printed, and written as a page for the documentation.

    python benchmarks/bench.py [PAGE.md]

Exit status 1 if a peer's answer differs.
"""

import os
import platform
import subprocess
import sys
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from table import markdown, show

#: In the order of the table; each has `rows()`.
MODULES = (
    "simulate_speed", "missed_impacts", "flags_speed", "reference_chain", "chart_speed", "boundary_point",
    "basin_speed", "design_speed", "prove_speed", "campaign_speed", "python_call", "structure_speed",
    "element_speed", "threads_speed", "scaling", "instruction_counts",
)  # fmt: skip
PEERS = ("numpy", "scipy", "numba", "scikit-sundae", "heyoka")
ROOT = Path(__file__).resolve().parents[1]


def machine():
    """Processor and versions, as lines."""
    lines = [
        line for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line
    ]
    compiler = subprocess.run(["gfortran", "--version"], capture_output=True, text=True, check=True)
    found = [f"{name} {version(name)}" for name in ("vibroimpact", *PEERS) if has(name)]
    return [
        f"- {lines[0].split(': ', 1)[1] if lines else platform.machine()}, {os.cpu_count()} processors available",
        f"- {compiler.stdout.splitlines()[0]}; Python {platform.python_version()}; {platform.system()}",
        f"- {', '.join(found)}",
    ]


def has(name):
    """Whether a package is installed."""
    try:
        version(name)
    except PackageNotFoundError:
        return False
    return True


def main():
    """Measure all, print, write."""
    rows = []
    for name in MODULES:
        print(f"{name} ...", file=sys.stderr, flush=True)
        try:
            rows += import_module(name).rows()
        except ModuleNotFoundError as error:
            print(f"  left out: {error.name} is not installed", file=sys.stderr)
    good = show(rows)
    if len(sys.argv) > 1:
        page = [
            "# Benchmarks", "",
            "Written by `./run bench`. Times are CPU times on one core unless a line says otherwise, and medians "
            "of interleaved runs; the ratio is the factor by which this package is better. Compare the columns of "
            "one run, not runs on different machines. The targets are for a core of 3.4 GHz on which numba "
            "reaches 1.30 and 1.27 million impacts/s.",
            "",
            *machine(), "", markdown(rows), "",
        ]  # fmt: skip
        path = Path(sys.argv[1])
        part = path.with_name(path.name + ".part")
        part.write_text("\n".join(page), encoding="utf-8")
        part.replace(path)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
