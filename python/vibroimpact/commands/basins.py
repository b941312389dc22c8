"""`vibroimpact basins`: the attractors that initial states reach."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError
from .study import command

DESCRIPTION = """Find the attractor that each initial state of a plane, or each of many random states, reaches,
for the &basins cases of namelist files or for the case given by the options. The states and
their attractors are written to DIR/NAME.csv, one row for each state, or in another format,
and the shares of the attractors are printed; --plot also writes a picture of the plane.
NAME is "basins" for the case of the options."""
EXAMPLE = (
    "vibroimpact basins --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 "
    "--plane x -30 30 40 x_dot -30 30 40 -o results"
)


def details(result: Any) -> list[str]:
    """Lines on how fractal the boundaries are."""
    if result.of_structure or result.axes is None or not result.complete:
        return []
    # the exponent compares pairs at equal distances, so it needs even steps
    if any(axis.listed for axis in result.axes):
        return []
    return [f"uncertainty exponent {result.uncertainty_exponent:.3f}"]


NAMES = "two of x, x_dot, y (that is z - x), z_dot, t"
PLANE = f"{NAMES} with their first and last value and how many"
AXES = f"{NAMES}, in place of --plane, for values of --first-values and --second-values"
arguments, request, run_cases = command(
    "basins", details, plane={"help": PLANE}, axes={"help": AXES, "nargs": 2, "metavar": "NAME"}
)


def run(options: argparse.Namespace) -> int:
    """Find, print, write and draw them."""
    if options.axes is not None and options.plane is not None:
        raise ParameterError(
            f"--axes {' '.join(options.axes)}: must be left out if --plane is given, which names the axes"
        )
    if options.first_values is not None and options.plane is not None:
        raise ParameterError(
            f"--plane {' '.join(options.plane)}: must be left out if --first-values is given; use --axes NAME NAME"
        )
    if options.plot and options.states is not None:
        raise ParameterError(
            f"--plot {options.plot}: must be used with --plane; random states have no picture"
        )
    return run_cases(options)
