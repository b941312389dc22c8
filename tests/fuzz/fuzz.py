"""Hostile input for all doors of the package: what may happen is an answer or a clear error.

usage: fuzz.py [--share 0.1] [--seed N] [--only PART...] [--sanitized FOLDER] [--checked FOLDER]

Prints a table: inputs tried, refused, accepted, findings. Each finding is written to tests/fuzz/findings, as
an input that is ready to be run again. The exit status is 1 if there are any.
"""

import argparse
import signal
import sys
from pathlib import Path

import damaged
import doors
import functions
import namelists
from report import Report

PARTS = {
    "namelists": namelists.fuzz,
    "files": damaged.fuzz,
    "functions": functions.fuzz,
    "doors": doors.fuzz,
}


def main():
    """Run the requested parts."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--share", type=float, default=1.0, help="share of all inputs (default: 1)")
    parser.add_argument("--seed", type=int, default=1, help="other inputs (default: 1)")
    parser.add_argument(
        "--only", choices=PARTS, nargs="+", default=[*PARTS], help="some parts alone"
    )
    parser.add_argument("--sanitized", type=Path, default="build/fuzz-sanitized")
    parser.add_argument("--checked", type=Path, default="build/fuzz-checked")
    options = parser.parse_args()
    options.sanitized, options.checked = options.sanitized.resolve(), options.checked.resolve()
    report = Report()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    # the programs are interrupted, so they must not inherit the ignored signal of a background process
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        for name, part in PARTS.items():
            if name in options.only:
                part(report, options)
    finally:  # also if the run is stopped
        status = report.finish()
    return status


if __name__ == "__main__":
    sys.exit(main())
