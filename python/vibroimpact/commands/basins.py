"""`vibroimpact basins`: to which attractor initial states go."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import ParameterError
from .cases import run_kind
from .options import Request, add_case, span, values

HELP = "find the attractors at a point and the basin of each"
DESCRIPTION = """Find to which attractor each initial state of a plane, or each of many random ones, goes,
for the &basins cases of namelist files or for the one that the options name. The states
with their attractors are written to DIR/NAME.csv, one a row, or in another form, and the
shares of the attractors are printed; with --plot a picture of the plane stands beside them.
NAME is "basins" for the case of the options."""
EXAMPLE = (
    "vibroimpact basins --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 "
    "--plane x -30 30 40 x_dot -30 30 40 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a point, and the states."""
    add_case(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio")
    parser.add_argument("--clearance", type=float, metavar="D", help="clearance d K/F0")
    parser.add_argument(
        "--plane", nargs=8, metavar=("NAME", "LOW", "HIGH", "N") * 2,
        help="two of x, x_dot, y (that is z - x), z_dot, t with their values; the others are 0",
    )  # fmt: skip
    parser.add_argument(
        "--states", type=int, metavar="N", help="N random states instead of a plane"
    )
    parser.add_argument(
        "--seed", type=int, metavar="S", help="seed of the random states (default: 0)"
    )


def run(options: argparse.Namespace) -> int:
    """Find, print, write and draw them."""
    if not options.files and (options.plane is None) == (options.states is None):
        raise ParameterError("--plane, --states: exactly one of them must be given")
    if options.plot and options.states is not None:
        raise ParameterError(
            f"--plot {options.plot}: must go with --plane; random states have no picture"
        )
    groups = {
        "system": values(options, "xi", "mu", "restitution", "r"),
        "basins": {**values(options, "clearance", "states", "seed"), **plane(options.plane)},
    }
    needed = ("xi", "mu", "restitution", "r", "clearance")
    spans = dict.fromkeys(("axes", "low", "high", "values", "y"), "plane")
    return run_kind(options, Request("basins", groups, needed, spans), details)


def plane(words: list[str] | None) -> dict[str, list[Any]]:
    """The keys of the two axes that eight words name."""
    if words is None:
        return {}
    wanted = "NAME LOW HIGH N twice, as x -30 30 200 x_dot -30 30 200,"
    try:
        axes = [(w[0], *span(w[1:], "plane")) for w in (words[:4], words[4:])]
    except ParameterError:
        raise ParameterError(
            f"--plane {' '.join(words)}: must be {wanted} each LOW below HIGH"
        ) from None
    return dict(
        zip(("axes", "low", "high", "values"), map(list, zip(*axes, strict=True)), strict=True)
    )


def details(result: Any) -> list[str]:
    """How fractal the boundaries are."""
    if result.axes is None or not result.complete:
        return []
    return [f"uncertainty exponent {result.uncertainty_exponent:.3f}"]
