"""`vibroimpact simulate`: a simulation, its events and its picture."""

from __future__ import annotations

import argparse

from . import ANIMATIONS
from .cases import run_kind
from .options import STATE, Request, add_case, add_numbers, add_state, values

HELP = "simulate from an initial state"
DESCRIPTION = """Simulate from an initial state, for the &simulate cases of namelist files or for the one
that the options name. The events are written to DIR/NAME.csv, one a row, or in another
form; with --plot a picture of the last load cycles stands beside them, with --animate a
film of the masses. NAME is "simulate" for the case of the options."""
EXAMPLE = (
    "vibroimpact simulate --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --cycles 40 "
    "--state 3.5 0 0 -2 --plot -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a point, an initial state and how long."""
    add_case(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio")
    parser.add_argument("--clearance", type=float, metavar="D", help="clearance d K/F0")
    parser.add_argument("--cycles", type=float, metavar="N", help="load cycles simulated")
    parser.add_argument(
        "--discard", type=float, metavar="N",
        help="load cycles simulated before those and not kept (default: 0)",
    )  # fmt: skip
    add_numbers(parser, max_events="events after which it is cut short (default: 10000000)")
    add_state(parser, "where it starts")
    parser.add_argument(
        "--animate", choices=ANIMATIONS,
        help="film the masses in the last load cycles, as DIR/NAME.gif or .mp4",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Run the simulations, write and draw them."""
    groups = {
        "system": values(options, "xi", "mu", "restitution", "r"),
        "simulate": {
            **values(options, "clearance", "cycles", "discard", "max_events"),
            **dict(zip(STATE, options.state or (), strict=False)),
        },
    }  # fmt: skip
    needed = ("xi", "mu", "restitution", "r", "clearance", "cycles")
    return run_kind(options, Request("simulate", groups, needed, dict.fromkeys(STATE, "state")))
