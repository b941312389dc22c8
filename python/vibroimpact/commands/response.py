"""`vibroimpact response`: the greatest displacement along the frequency."""

from __future__ import annotations

import argparse

from .cases import run_kind
from .options import Request, add_case, add_numbers, grid, values

HELP = "follow max|X|/A along r over all attractors"
DESCRIPTION = """Find max|X|/A along r for a clearance or a load, from many initial states, for the &response
cases of namelist files or for the one that the options name. Its least and greatest value
over the attractors that coexist are written to DIR/NAME.csv, one row a frequency ratio, or
in another form, of which netCDF and JSON also hold what each state came to; with --plot a
picture stands beside them. NAME is "response" for the case of the options."""
EXAMPLE = (
    "vibroimpact response --xi .0114 --mu .028 --restitution .75 --r .95 1.05 21 "
    "--inverse-clearance .03 --states 6 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, the line, and the number of states."""
    add_case(parser)
    parser.add_argument(
        "--r", nargs=3, metavar=("LOW", "HIGH", "N"), help="the line: N frequency ratios"
    )
    one = parser.add_mutually_exclusive_group()
    one.add_argument("--clearance", type=float, metavar="D", help="clearance d K/F0")
    one.add_argument("--inverse-clearance", type=float, metavar="V", help="or the load F0/(d K)")
    add_numbers(parser, states="initial states at each r (default: 24)")


def run(options: argparse.Namespace) -> int:
    """Find, print, write and draw it."""
    groups = {
        "system": values(options, "xi", "mu", "restitution"),
        "response": {
            **grid(options, "r"), **values(options, "clearance", "inverse_clearance", "states"),
        },
    }  # fmt: skip
    return run_kind(options, Request("response", groups, ("xi", "mu", "restitution", "r")))
