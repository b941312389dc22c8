"""`vibroimpact bifurcation`: what simulations settle on along a parameter."""

from __future__ import annotations

import argparse
from typing import Any

from ..studies.bifurcation import COLUMNS
from .study import command

DESCRIPTION = """Simulate along a parameter, with the state carried on up and down or from many initial
states, for the &bifurcation cases of namelist files or for the one that the options name.
The impacts that are left are written to DIR/NAME.csv, one a row, or in another form, and
the stretches of periodic motion N/k (N impacts in k load cycles) are printed; with --plot a
picture stands beside them. NAME is "bifurcation" for the case of the options."""
EXAMPLE = (
    "vibroimpact bifurcation --xi .0114 --mu .028 --restitution .75 --r 1.04 --parameter clearance "
    "--values 50 75 26 -o results"
)


def details(result: Any) -> list[str]:
    """The windows."""
    return [
        f"{window.run}: {window.label} from {window.low:.6g} to {window.high:.6g}"
        for window in result.windows
    ]


add_keys, request, run = command("bifurcation", details)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The keys, and what is drawn."""
    add_keys(parser)
    parser.add_argument(
        "--quantity", default="x", choices=(*COLUMNS, "approach"),
        help="what --plot draws of each impact (default: x)",
    )  # fmt: skip
