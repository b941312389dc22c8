"""Stated errors of `identify` over the Cramer-Rao bounds of the flights, of ten records of another program.

    python benchmarks/identify_bound.py

The records and their rigs are those of tests/python/test_identify_records.py, the bound that of
tests/python/reference_bound.py, which shares no code with the package.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests/python"))
from test_identify_records import RIGS, over_bound


def main():
    """The table."""
    names = ("xi", "mu", "R1", "R2", "d")
    print("| record | " + " | ".join(names) + " |")
    print("|---|" + "---|" * len(names))
    for record in RIGS:
        ratios, least = over_bound(record)
        cells = [
            f"{ratios[name] * least[name]:.2g} ({ratios[name]:.2f})" if name in ratios else "known"
            for name in names
        ]
        print(f"| {record} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
