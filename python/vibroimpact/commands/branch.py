"""`vibroimpact branch`: how motions change along a parameter."""

from __future__ import annotations

import argparse

from ..errors import ParameterError
from ..studies.branch import CHOICES
from .cases import run_kind
from .options import Request, add_case, add_numbers, pair, values

HELP = "follow motions along a parameter"
DESCRIPTION = """Follow exact motions along a parameter, through folds, for the &branch cases of namelist
files or for the one that the options name: its motion has the sides and, about, the phases
that are given; without them the equispaced motions are followed. The points are written to
DIR/NAME.csv, bifurcations among them; with --plot a picture stands beside them. NAME is
"branch" for the case of the options."""
EXAMPLE = (
    "vibroimpact branch --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --sides RL "
    "--phases-over-pi 0 1.37 --parameter clearance --bounds 10 60 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a motion, a parameter and its bounds."""
    add_case(parser, with_pattern=True)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio")
    parser.add_argument("--clearance", type=float, metavar="D", help="clearance d K/F0")
    parser.add_argument(
        "--phases-over-pi", type=float, nargs="+", metavar="PHASE",
        help="load phases of the impacts over pi, the first 0; near the motion's own is enough",
    )  # fmt: skip
    parser.add_argument("--parameter", choices=CHOICES, help="what changes along the branch")
    parser.add_argument(
        "--bounds",
        type=float,
        nargs=2,
        metavar=("LOW", "HIGH"),
        help="its lowest and highest value",
    )
    parser.add_argument(
        "--longest-step",
        type=float,
        metavar="S",
        help="longest step along the branch, in shares of the bounds (default: 0.05)",
    )
    add_numbers(parser, max_points="most points each way (default: 4000)")


def run(options: argparse.Namespace) -> int:
    """Follow the branches, write and draw them."""
    low, high = pair(options, "bounds")
    guessed = options.phases_over_pi is not None
    if options.sides is not None and not guessed:
        raise ParameterError(
            f"--sides {options.sides}: needs --phases-over-pi too, about the phases of its impacts; without both "
            "the equispaced motions RL are followed"
        )
    walls: list[float] = options.restitution or []
    if not (guessed or options.files) and len(walls) == 2 and walls[0] != walls[1]:
        raise ParameterError(
            f"--restitution {walls[0]:g} {walls[1]:g}: must be the same for both walls, or go with --sides and "
            "--phases-over-pi; without them the equispaced motions are followed"
        )
    groups = {
        "system": values(options, "xi", "mu", "restitution", "r"),
        "motion": {
            "kind": "exact" if guessed else "equispaced",
            **values(options, "clearance", "sides", "cycles", "phases_over_pi"),
        },
        "branch": {
            "low": low, "high": high, **values(options, "parameter", "longest_step", "max_points"),
        },
    }  # fmt: skip
    needed = ("xi", "mu", "restitution", "r", "clearance", "parameter", "bounds")
    spans = {"low": "bounds", "high": "bounds"}
    return run_kind(options, Request("branch", groups, needed, spans))
