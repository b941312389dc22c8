"""`vibroimpact chart`: the motions of a pattern on a grid."""

from __future__ import annotations

import argparse

from .cases import run_kind
from .options import Request, add_case, add_numbers, add_spacing, grid, values

HELP = "compute all motions of a pattern on a grid of r and d K/F0"
DESCRIPTION = """Compute all motions of a pattern on a grid of the plane (r, d K/F0), with their stability,
for the &chart cases of namelist files or for the one that the options name. They are
written to DIR/NAME.csv, one row a motion, or in another form, which also holds the phases
and all multipliers and is read by vibroimpact.load; with --plot a picture stands beside
them. NAME is "chart" for the case of the options."""
EXAMPLE = (
    "vibroimpact chart --xi .0114 --mu .028 --restitution .75 --sides RL --r 0.9 1.1 21 "
    "--clearance 5 100 16 --spacing geometric --symmetric yes -o results"
)
#: Keys of its own, with their meaning and default.
OWN = {
    "room": "slots for motions that have no closed form (default: 4)",
    "guesses": "guesses of a search (default: 32)",
    "seeds": "searches along each axis (default: 12)",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a pattern and a grid."""
    add_case(parser, with_pattern=True)
    for name, wanted in (("r", "frequency ratios"), ("clearance", "clearances d K/F0")):
        parser.add_argument(
            f"--{name}", nargs=3, metavar=("LOW", "HIGH", "N"), help=f"the grid: N {wanted}"
        )
    add_spacing(parser, "clearances")
    parser.add_argument(
        "--symmetric", choices=("yes", "no", "both"),
        help="only motions that are their own mirror image, only others, or both (default)",
    )  # fmt: skip
    add_numbers(parser, **OWN)


def run(options: argparse.Namespace) -> int:
    """Compute the charts, write and draw them."""
    groups = {
        "system": values(options, "xi", "mu", "restitution"),
        "chart": {
            **grid(options, "r"), **grid(options, "clearance"),
            **values(options, "sides", "cycles", "spacing", "symmetric", *OWN),
        },
    }  # fmt: skip
    needed = ("xi", "mu", "restitution", "sides", "r", "clearance")
    return run_kind(options, Request("chart", groups, needed))
