"""`vibroimpact simulate`: the simulations of namelist files, with pictures."""

from __future__ import annotations

import argparse

from . import ANIMATIONS, add_files, add_forms
from .cases import run_kind
from .options import Request

HELP = "run the simulations of namelist files"
DESCRIPTION = """Run the &simulate cases of namelist files: the events of each are written to DIR/NAME.csv,
with the same digits as `vibroimpact run` gives, and with --plot a picture of its last load
cycles beside it, with --animate the masses in motion."""
EXAMPLE = "vibroimpact simulate inputs/figure9.nml --plot -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the forms of the results."""
    add_files(parser)
    add_forms(parser)
    parser.add_argument(
        "--animate",
        choices=ANIMATIONS,
        help="animate the last load cycles, as DIR/NAME.gif or .mp4",
    )


def run(options: argparse.Namespace) -> int:
    """Run the simulations, write and draw them."""
    return run_kind(options, Request("simulate"))
