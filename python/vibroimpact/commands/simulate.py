"""`vibroimpact simulate`: a simulation, its events and its picture."""

from __future__ import annotations

import argparse

from . import ANIMATIONS
from .study import command

DESCRIPTION = """Simulate from an initial state, for the &simulate cases of namelist files or for the one
given by the options. The events are written to DIR/NAME.csv, one row for each, or in another
format; --plot also writes a picture of the last load cycles, and --animate an animation of
the masses. NAME is "simulate" for the case of the options."""
EXAMPLE = (
    "vibroimpact simulate --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --cycles 40 "
    "--state 3.5 0 0 -2 --plot -o results"
)

add_keys, request, run = command("simulate")


def arguments(parser: argparse.ArgumentParser) -> None:
    """The keys, and an animation."""
    add_keys(parser)
    parser.add_argument(
        "--animate", choices=ANIMATIONS,
        help="animate the masses in the last load cycles, as DIR/NAME.gif or .mp4",
    )  # fmt: skip
