"""`vibroimpact bifurcation`: what simulations settle on along a parameter."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import ParameterError
from ..studies.bifurcation import COLUMNS, NAMES, SWEEPS
from .cases import run_kind
from .options import Request, add_case, add_numbers, add_spacing, grid, values

HELP = "sweep a parameter up and down, or from many states"
DESCRIPTION = """Simulate along a parameter, with the state carried on up and down or from many initial
states, for the &bifurcation cases of namelist files or for the one that the options name.
The impacts that are left are written to DIR/NAME.csv, one a row, or in another form, and
the stretches of periodic motion N/k (N impacts in k load cycles) are printed; with --plot a
picture stands beside them. NAME is "bifurcation" for the case of the options."""
EXAMPLE = (
    "vibroimpact bifurcation --xi .0114 --mu .028 --restitution .75 --r 1.04 --parameter clearance "
    "--values 50 75 26 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, the parameter with its values, and the kind of sweep."""
    add_case(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio, if it is not swept")
    parser.add_argument(
        "--clearance", type=float, metavar="D", help="clearance d K/F0, if it is not swept"
    )
    parser.add_argument("--parameter", choices=NAMES, help="what is swept")
    parser.add_argument(
        "--values", nargs=3, metavar=("LOW", "HIGH", "N"), help="N values of it from LOW to HIGH"
    )
    add_spacing(parser, "values")
    parser.add_argument(
        "--sweep", choices=SWEEPS,
        help="the state carried up, down or both (default), or many states at each value",
    )  # fmt: skip
    add_numbers(parser, states="initial states at each value of --sweep states (default: 12)")
    parser.add_argument(
        "--quantity", default="x", choices=(*COLUMNS, "approach"),
        help="what --plot draws of each impact (default: x)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Sweep, print the windows, write and draw the impacts."""
    if options.parameter is not None and not options.files:
        for name in ("r", "clearance"):
            value = getattr(options, name)
            if name != options.parameter and value is None:
                raise ParameterError(f"--{name}: must be given, it is not the parameter")
            if name == options.parameter and value is not None:
                raise ParameterError(f"--{name} {value:g}: must be left out, it is the parameter")
    keys = ("low", "high", "values")
    groups = {
        "system": values(options, "xi", "mu", "restitution", "r"),
        "bifurcation": {
            **grid(options, "values", *keys),
            **values(options, "parameter", "clearance", "spacing", "sweep", "states"),
        },
    }  # fmt: skip
    needed = ("xi", "mu", "restitution", "parameter", "values")
    request = Request("bifurcation", groups, needed, dict.fromkeys(keys, "values"))
    return run_kind(options, request, details)


def details(result: Any) -> list[str]:
    """The windows."""
    return [
        f"{window.run}: {window.label} from {window.low:.6g} to {window.high:.6g}"
        for window in result.windows
    ]
