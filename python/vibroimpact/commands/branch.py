"""`vibroimpact branch`: how motions change along a parameter."""

from __future__ import annotations

import argparse

from ..errors import ParameterError
from ..studies.branch import CHOICES
from .cases import run_kind
from .options import add_case, pair

HELP = "follow motions along a parameter"
DESCRIPTION = """Follow exact motions along a parameter, through folds, for the &branch cases of namelist
files or for the one that the options name: its motion has the sides and, about, the phases that are
given; without them the equispaced motions are followed. The points are written to DIR/NAME.csv, bifurcations among
them; with --plot a picture stands beside them. NAME is "branch" for the case of the options."""
EXAMPLE = (
    "vibroimpact branch --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --sides RL "
    "--phases-over-pi 0 1.37 --parameter clearance --bounds 10 60 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a motion, a parameter and its bounds."""
    add_case(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio")
    parser.add_argument("--clearance", type=float, metavar="D", help="d K/F0")
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
        "--longest-step", type=float, metavar="S", help="in shares of the bounds (default: 0.05)"
    )
    parser.add_argument(
        "--max-points", type=int, metavar="N", help="most points each way (default: 4000)"
    )


def run(options: argparse.Namespace) -> int:
    """Follow the branches, write and draw them."""
    low, high = pair(options, "bounds")
    guessed = options.phases_over_pi is not None
    if options.sides is not None and not guessed:
        raise ParameterError(
            f"--sides {options.sides}: needs --phases-over-pi too, about the phases of its impacts; without both "
            "the equispaced motions RL are followed"
        )
    groups = {
        "system": {name: getattr(options, name) for name in ("xi", "mu", "restitution", "r")},
        "motion": {
            "kind": "exact" if guessed else "equispaced",
            **{name: getattr(options, name)
               for name in ("clearance", "sides", "cycles", "phases_over_pi")},
        },
        "branch": {
            "parameter": options.parameter, "low": low, "high": high,
            "longest_step": options.longest_step, "max_points": options.max_points,
        },
    }  # fmt: skip
    needed = ("xi", "mu", "restitution", "r", "clearance", "parameter", "bounds")
    return run_kind(options, "branch", groups, needed)
