"""The LAPACK path from phases to a motion with its multipliers, relative to the LAPACK calls that it needs.

Reads what the program reference_chain prints (build it first: ninja -C build/fortran benchmarks/reference_chain).
"""

import subprocess
from pathlib import Path

from table import row, show

PROGRAM = Path(__file__).resolve().parents[1] / "build/fortran/benchmarks/reference_chain"


def rows():
    """Microseconds a point of the chain without flights; the target is 1.15 times the LAPACK calls alone."""
    lines = subprocess.run(
        [PROGRAM], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    answer = []
    for n, bare, chain in (line.split()[:3] for line in lines[2:]):
        work = f"periodic motion by LAPACK, N = {n}"
        answer.append(
            row(
                work,
                "µs a point",
                float(chain),
                1.15 * float(bare),
                float(bare),
                "bare LAPACK calls",
            )
        )
    return answer


if __name__ == "__main__":
    show(rows())
