"""`vibroimpact bifurcation`: the motions on which simulations settle along a parameter."""

from __future__ import annotations

import argparse
from typing import Any

from ..studies.bifurcation import COLUMNS
from ..systems.units import range_text
from .study import command

DESCRIPTION = """Simulate along a parameter, in sweeps up and down that continue from value to value or from
many initial states, for the &bifurcation cases of namelist files or for the case given by
the options. The impacts after the transient are written to DIR/NAME.csv, one row for each,
or in another format, and the intervals of periodic motion N/k (N impacts in k load cycles)
are printed; --plot also writes a picture. NAME is "bifurcation" for the case of the options."""
EXAMPLE = (
    "vibroimpact bifurcation --xi .0114 --mu .028 --restitution .75 --r 1.04 --parameter clearance "
    "--values 50 75 26 -o results"
)


def details(result: Any) -> list[str]:
    """Lines on the windows."""
    if result.of_structure:
        return []
    return [
        f"{window.run}: {window.label} from {range_text(result.osc, result.parameter, window.low, window.high)}"
        for window in result.windows
    ]


add_keys, request, run = command("bifurcation", details)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The keys, and what is drawn."""
    add_keys(parser)
    parser.add_argument(
        "--quantity", choices=(*COLUMNS, "approach"),
        help="quantity of each impact that --plot draws (default: x)",
    )  # fmt: skip
