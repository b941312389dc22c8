"""`vibroimpact bifurcation`: what simulations settle on along a parameter."""

from __future__ import annotations

import argparse

import numpy as np

from ..errors import ParameterError
from ..studies.bifurcation import COLUMNS, NAMES, SWEEPS, bifurcation_diagram
from .point import add_system, draw, numbers, oscillator, status, with_bar, write_table

HELP = "sweep a parameter up and down, or from many states"
DESCRIPTION = """Simulate along a parameter, with the state carried on up and down or from many initial states, and
write the impacts that are left to DIR/bifurcation.csv; print the stretches of periodic motion N/k."""
EXAMPLE = (
    "vibroimpact bifurcation --xi .0114 --mu .028 --restitution .75 --r 1.04 --parameter clearance "
    "--values 50 75 26 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """A system, the parameter with its values, and the kind of sweep."""
    add_system(parser)
    parser.add_argument("--r", type=float, metavar="R", help="frequency ratio, if it is not swept")
    parser.add_argument("--clearance", type=float, metavar="D", help="d K/F0, if it is not swept")
    parser.add_argument("--parameter", choices=NAMES, required=True, help="what is swept")
    parser.add_argument(
        "--values",
        type=float,
        nargs=3,
        required=True,
        metavar=("LOW", "HIGH", "N"),
        help="its values",
    )
    parser.add_argument("--sweep", choices=SWEEPS, default="both", help="default: both")
    parser.add_argument(
        "--states",
        type=int,
        default=12,
        metavar="N",
        help="initial states of 'states' (default: 12)",
    )
    parser.add_argument(
        "--quantity", default="x", choices=(*COLUMNS, "approach"), help="what is drawn (default: x)"
    )


def run(options: argparse.Namespace) -> int:
    """Sweep, print the windows, write the impacts."""
    for name in ("r", "clearance"):
        if name != options.parameter and getattr(options, name) is None:
            raise ParameterError(f"--{name}: must be given, it is not the parameter")
    result = with_bar(
        options, bifurcation_diagram, oscillator(options), options.parameter,
        np.asarray(numbers(options.values, "values")), options.r, options.clearance, options.sweep, options.states,
    )  # fmt: skip
    points, labels = result.points, result.labels
    # whole columns: there may be millions of impacts
    rows = zip(
        np.array(result.runs)[points["run"]].tolist(), result.values[points["index"]].tolist(),
        labels[points["run"], points["index"]].tolist(), points["side"].tolist(),
        *(points[name].tolist() for name in COLUMNS), strict=True,
    )  # fmt: skip
    write_table(
        options, "bifurcation", ["run", options.parameter, "label", "side", *COLUMNS], rows, result
    )
    for window in result.windows:
        print(f"{window.run}: {window.label} from {window.low:.6g} to {window.high:.6g}")
    draw(options, "bifurcation", result, quantity=options.quantity)
    return status(options, bool(result.status.any()))
