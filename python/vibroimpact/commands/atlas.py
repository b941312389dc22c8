"""`vibroimpact atlas`: all zones of a window, found without being told the patterns."""

from __future__ import annotations

import argparse

from .cases import run_kind
from .options import Request, add_case, add_numbers, add_window, window_groups

HELP = "find the zones of all patterns in a window"
DESCRIPTION = """Find all zones of the plane (r, d K/F0) in which motions of any pattern, up to a number of
impacts and cycles, are stable and admissible, for the &atlas cases of namelist files or for
the one that the options name. The boundaries are written to DIR/NAME.csv, one row a vertex
with the pattern and the type of its piece, or in another form; with --plot a picture stands
beside them. NAME is "atlas" for the case of the options. What became of the points of the
survey is counted: periodic within the limits, beyond them, without impacts, chaotic, not
settled. Motions that simulations settle on and that lie in no zone are listed, and give exit
status 1."""
EXAMPLE = (
    "vibroimpact atlas --xi .0114 --mu .028 --restitution .75 --r 1.0 1.1 --clearance 20 60 "
    "--max-impacts 3 --survey 20 -o results"
)
#: Keys of its own, with their meaning and default.
OWN = {
    "max_impacts": "most impacts a period, 2 to 8; an accumulation counts as one (default: 5)",
    "max_cycles": "most load cycles a period, 1 to 4 (default: 1)",
    "survey": "points from which simulations are left to settle (default: 400)",
    "settling": "load cycles simulated at each before its motion is looked at (default: 400)",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a window and limits."""
    add_case(parser)
    add_numbers(parser, **OWN)
    add_window(parser, guesses=24)


def run(options: argparse.Namespace) -> int:
    """Find the zones, write and draw them."""
    groups = window_groups(options, "atlas", tuple(OWN))
    needed = ("xi", "mu", "restitution", "r", "clearance")
    return run_kind(options, Request("atlas", groups, needed))
