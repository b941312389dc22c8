"""`vibroimpact response`: the greatest displacement along the frequency."""

from __future__ import annotations

import argparse

import numpy as np

from ..studies.response import response
from .point import add_range, add_system, draw, numbers, oscillator, status, with_bar, write_table

HELP = "follow max|X|/A along r over all attractors"
DESCRIPTION = """Find max|X|/A along r for a clearance or a load, from many initial states, and write its least and
greatest value over the attractors that coexist to DIR/response.csv."""
EXAMPLE = (
    "vibroimpact response --xi .0114 --mu .028 --restitution .75 --r .95 1.05 21 "
    "--inverse-clearance .03 --states 6 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """A system, the line, and the number of states."""
    add_system(parser)
    add_range(parser, "r", "frequency ratio", required=True)
    one = parser.add_mutually_exclusive_group(required=True)
    one.add_argument("--clearance", type=float, metavar="D", help="d K/F0")
    one.add_argument("--inverse-clearance", type=float, metavar="V", help="F0/(d K)")
    parser.add_argument(
        "--states", type=int, default=24, metavar="N", help="initial states at each r (default: 24)"
    )


def run(options: argparse.Namespace) -> int:
    """Find, print and write it."""
    result = with_bar(
        options, response, oscillator(options), np.atleast_1d(numbers(options.r, "r")), options.clearance,
        options.inverse_clearance, options.states,
    )  # fmt: skip
    columns = [
        item.tolist() for item in (result.r, result.clearance, result.lowest, result.highest)
    ]
    write_table(
        options,
        "response",
        ["r", "clearance", "lowest", "highest"],
        zip(*columns, strict=True),
        result,
    )
    print(result)
    draw(options, "response", result)
    return status(options, bool(np.isnan(result.attenuation).any()))
