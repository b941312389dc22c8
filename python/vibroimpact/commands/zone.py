"""`vibroimpact zone`: where the motions of a pattern are stable and admissible."""

from __future__ import annotations

import argparse

from .cases import run_kind
from .options import Request, add_case, add_window, window_groups

HELP = "find where the motions of a pattern are stable"
DESCRIPTION = """Find the zones of the plane (r, d K/F0) in which a pattern has stable, admissible motions,
for the &zone cases of namelist files or for the one that the options name. The boundaries
are written to DIR/NAME.csv, one row a vertex with the type of its piece, or in another
form; with --plot a picture stands beside them. NAME is "zone" for the case of the options."""
EXAMPLE = (
    "vibroimpact zone --xi .0114 --mu .028 --restitution .75 --sides RL --r 0.8 1.2 --clearance 2 200 "
    "-o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a pattern and a window."""
    add_case(parser, with_pattern=True)
    parser.add_argument(
        "--symmetric", choices=("yes", "no", "both"),
        help="only motions that are their own mirror image, only others, or both (default)",
    )  # fmt: skip
    add_window(parser, guesses=12)


def run(options: argparse.Namespace) -> int:
    """Find the zones, write and draw them."""
    groups = window_groups(options, "zone", ("sides", "cycles", "symmetric"))
    needed = ("xi", "mu", "restitution", "sides", "r", "clearance")
    return run_kind(options, Request("zone", groups, needed))
