#!/usr/bin/env python3
"""Counts the instructions of nineteen kinds of computation, and compares them with kept numbers.

usage: check_instructions.py PROGRAM [--renew]

PROGRAM is vibroimpact-batch of a release build. Counts, unlike times, do not depend on what else the machine does,
but on the compiler, the C library and the kind of processor: those of another combination are not compared. A
change that is meant, or needed for correctness, is kept by --renew.
"""

import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

KEPT = Path(__file__).with_name("instructions.json")
#: Largest growth that passes; where a motion is chaotic, the last bits change the number of impacts.
GROWTH = 0.03
SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75{} /\n"
STRUCTURE = """&structure mass = 1, 0.042, damping = 0.01, 0, stiffness = 1, 0 /
&gap direction = -1, 1, opening = 18.5, restitution = 0.75 /
&gap direction = 1, -1, opening = 18.5, restitution = 0.75 /
&load frequency = 0.94, sine = 1, 0 /
"""
DRAG = (
    STRUCTURE.replace("0.01, 0", "0.01, 0.001")
    + "&simulate q_dot = 0, 20, discard = 2000, cycles = 1 /"
)
TABLE1 = "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
BELT = """&structure mass = 1, damping = 0.05, stiffness = 1 /
&friction direction = 1, slip = 0.6, stick = 1, speed = 0.2 /
&load frequency = 0.7, cosine = 0.4 /
"""
ROUGH = """&structure mass = 1, damping = 0.1, stiffness = 1 /
&friction direction = 1, slip = 0.3 /
"""


def lattice(cells):
    """A chain of hosts, each with a free mass in a slot, of which an end is hit."""
    springs = [[0] * 2 * cells for _ in range(2 * cells)]
    gaps = ""
    for i in range(cells):
        for j in range(max(i - 1, 0), min(i + 2, cells)):
            springs[i][j] = -1 if i != j else 2 - (i in (0, cells - 1))
        row = [0] * 2 * cells
        row[i], row[cells + i] = -1, 1
        for sense in (1, -1):
            direction = ", ".join(str(sense * number) for number in row)
            gaps += f"&gap direction = {direction}, opening = 1 /\n"
    stiffness = ",\n".join(", ".join(map(str, row)) for row in springs)
    return (
        f"&structure mass = {cells}*1, {cells}*0.3, stiffness = {stiffness} /\n{gaps}"
        f"&simulate duration = 1, q_dot = -10, {2 * cells - 1}*0, discard = 60 /"
    )


CASES = {
    "simulation, stable": SYSTEM.format(", r = 1.04")
    + "&simulate clearance = 25, discard = 20000, cycles = 1 /",
    "simulation, chaotic": SYSTEM.format(", r = 1.02")
    + "&simulate clearance = 11.25, discard = 12000, cycles = 1 /",
    "basins": SYSTEM.format(", r = 0.94")
    + "&basins clearance = 37, axes = 'x', 'x_dot', low = -30, -30, "
    "high = 30, 30, values = 4, 4 /",
    "response": SYSTEM.format("")
    + "&response r_min = 0.98, r_max = 1.02, r_points = 3, clearance = 25, states = 3 /",
    "Lyapunov exponents": SYSTEM.format(", r = 1.04")
    + "&lyapunov clearance = 12, x_dot = 6, z_dot = 9, cycles = 500 /",
    "chart": SYSTEM.format("")
    + "&chart sides = 'RL', symmetric = 'yes', r_min = 0.8, r_max = 1.2, r_points = 20, "
    "clearance_min = 2, clearance_max = 200, clearance_points = 20 /",
    "zone": SYSTEM.format("")
    + "&zone sides = 'RRL', r_min = 0.95, r_max = 1.1, clearance_min = 10, "
    "clearance_max = 60, lines = 5 /",
    # most of these motions are found by simulation, or begin at pitchforks of symmetric ones
    "zone by simulation": SYSTEM.format("")
    + "&zone sides = 'RRLL', r_min = 0.95, r_max = 1.1, clearance_min = 3, clearance_max = 50, "
    "lines = 5 /",
    "exact motion": TABLE1
    + "&motion kind = 'exact', sides = 'RL', clearance = 37, phases_over_pi = 0, 1.37 /",
    "find": TABLE1 + "&find clearance = 37, max_impacts = 2, max_cycles = 1 /",
    "atlas": SYSTEM.format("") + "&atlas r_min = 1.02, r_max = 1.05, clearance_min = 30, "
    "clearance_max = 40, max_impacts = 2, lines = 5, survey = 2 /",
    "lattice": lattice(30),
    "friction": BELT + "&simulate cycles = 2, discard = 200 /",
    "simulation of a structure": DRAG,
    "simulation with stops": DRAG.replace("&gap", "&stop").replace(
        "restitution = 0.75", "stiffness = 10, damping = 0.11"
    ),
    "exact motion of a structure": STRUCTURE + "&motion gaps = 0, 1, phases_over_pi = 0.52, 1.9 /",
    "zone of a structure": STRUCTURE + "&motion gaps = 0, 1, phases_over_pi = 0.52, 1.9 /\n"
    "&zone x = 'frequency', x_low = 0.9, x_high = 0.98, y = 'opening', y_low = 15, y_high = 22, "
    "lines = 5 /",
    "zone with friction": ROUGH
    + "&load frequency = 0.8, cosine = 1 /\n&motion kind = 'settled' /\n"
    "&zone x = 'frequency', x_low = 0.75, x_high = 0.85, y = 'slip', y_low = 0.28, y_high = 0.36, "
    "lines = 5 /",
    "branch with a stop and friction": ROUGH
    + "&stop direction = 1, opening = 0.8, stiffness = 20, damping = 0.1 /\n"
    "&load frequency = 0.6, cosine = 1 /\n&motion kind = 'settled' /\n"
    "&branch parameter = 'slip', low = 0.2, high = 0.4 /",
}


def count(program, text):
    """Instructions of a case, with those of the program's start and of writing its few lines."""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder, "case.nml")
        case.write_text(text + "\n&output name = 'case' /\n", encoding="utf-8")
        counter = [
            "valgrind",
            "--tool=cachegrind",
            "--cache-sim=no",
            "--cachegrind-out-file=/dev/null",
        ]
        alone = {
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "OPENBLAS_CORETYPE": "Haswell",
        }
        run = subprocess.run(
            [*counter, program, str(case), "-o", folder],
            capture_output=True,
            text=True,
            env=os.environ | alone,
        )
    found = re.search(r"I\s+refs:\s+([\d,]+)", run.stderr)
    if run.returncode or not found:
        sys.exit(f"{text}\n{run.stdout[-500:]}\n{run.stderr[-1500:]}")
    return int(found[1].replace(",", ""))


def combination():
    """Compiler, C library and kind of processor."""
    compiler = subprocess.run(
        ["gfortran", "-dumpfullversion"], capture_output=True, text=True
    ).stdout.strip()
    flags = (
        Path("/proc/cpuinfo").read_text(encoding="utf-8") if Path("/proc/cpuinfo").exists() else ""
    )
    # valgrind shows no wider registers than these to a program
    wide = "avx2" if "avx2" in flags else "plain"
    return f"gfortran {compiler}, {' '.join(platform.libc_ver())}, {platform.machine()} {wide}"


def main():
    """Count, and compare or keep; the exit status is 1 if a count has grown."""
    program, renew = sys.argv[1], "--renew" in sys.argv
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}
    here = combination()
    found = {name: count(program, text) for name, text in CASES.items()}
    if renew:
        KEPT.write_text(json.dumps(kept | {here: found}, indent=2) + "\n", encoding="utf-8")
        return 0
    if here not in kept:
        print(f"no counts are kept for {here}; --renew keeps them")
        return 0
    grown = False
    for name, n in found.items():
        if name not in kept[here]:
            print(f"{name}: {n / 1e6:.1f} million, not kept yet: --renew")
            grown = True
            continue
        change = n / kept[here][name] - 1
        grown |= change > GROWTH
        print(f"{name}: {n / 1e6:.1f} million, {change:+.1%}{' GROWN' if change > GROWTH else ''}")
    if grown:
        print(
            "if this is meant: .ci/check_instructions.py build/fortran/src/vibroimpact-batch --renew"
        )
    return int(grown)


if __name__ == "__main__":
    sys.exit(main())
