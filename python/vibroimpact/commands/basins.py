"""`vibroimpact basins`: to which attractor initial states go."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import ParameterError
from ..studies.basins import basins
from .point import add_system, draw, oscillator, status, with_bar, write_table

HELP = "find the attractors at a point and the basin of each"
DESCRIPTION = """Find to which attractor each initial state of a plane, or each of many random ones, goes.
The states with their labels are written to DIR/basins.csv, the attractors with their shares are
printed."""
EXAMPLE = (
    "vibroimpact basins --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 "
    "--plane x -30 30 40 x_dot -30 30 40 -o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """A system, a point, and the states."""
    add_system(parser)
    for name, wanted in (("r", "frequency ratio"), ("clearance", "d K/F0")):
        parser.add_argument(
            f"--{name}", type=float, required=True, metavar=name[0].upper(), help=wanted
        )
    parser.add_argument(
        "--plane", nargs=8, metavar=("NAME", "LOW", "HIGH", "N") * 2,
        help="two of x, x_dot, y, z_dot, t with their values; the others are 0",
    )  # fmt: skip
    parser.add_argument("--states", type=int, metavar="N", help="random states instead of a plane")
    parser.add_argument("--seed", type=int, default=0, help="of the random states (default: 0)")


def run(options: argparse.Namespace) -> int:
    """Find, print and write them."""
    if (options.plane is None) == (options.states is None):
        raise ParameterError("--plane, --states: exactly one of them must be given")
    if options.plot and options.plane is None:
        raise ParameterError(f"--plot {options.plot}: needs --plane; random states have no picture")
    result = with_bar(
        options, basins, oscillator(options), options.r, options.clearance, _plane(options.plane),
        options.states, seed=options.seed,
    )  # fmt: skip
    labels = result.labels.ravel().tolist()
    names = [*(item.name for item in result.attractors), ""]
    states = result.states.reshape(5, -1).T.tolist()
    rows = ([*state, label, names[label]] for state, label in zip(states, labels, strict=True))
    write_table(
        options, "basins", ["t", "x", "x_dot", "z", "z_dot", "label", "attractor"], rows, result
    )
    shares = zip(result.attractors, result.fractions, result.standard_error, strict=True)
    for item, share, error in shares:
        print(f"{share:8.2%} +- {error:.2%}  {item.name} ({item.kind})")
    if result.axes is not None:
        print(f"uncertainty exponent {result.uncertainty_exponent:.3f}")
    left = labels.count(-1)
    if left:
        print(f"{left} of {len(labels)} states not decided")
    draw(options, "basins", result)
    return status(options, left > 0)


def _plane(words: list[str] | None) -> tuple[Any, Any] | None:
    """The two axes that eight words name."""
    if words is None:
        return None
    try:
        axes = [(w[0], float(w[1]), float(w[2]), int(w[3])) for w in (words[:4], words[4:])]
    except ValueError:
        raise ParameterError(
            f"--plane {' '.join(words)}: must be NAME LOW HIGH N twice, as x -30 30 200 x_dot -30 30 200"
        ) from None
    return axes[0], axes[1]
