"""`vibroimpact lyapunov`: all four Lyapunov exponents at a point or along a line."""

from __future__ import annotations

import argparse

import numpy as np

from ..errors import ParameterError
from ..studies.lyapunov import lyapunov
from .point import add_range, add_system, draw, numbers, oscillator, status, with_bar, write_table

HELP = "compute all Lyapunov exponents at a point or along a line"
DESCRIPTION = """Compute the four Lyapunov exponents per load cycle of what a simulation settles on, at a point or
along a line of r or of d K/F0, through impacts, accumulations and rests. They are written to
DIR/lyapunov.csv with their standard errors and the check by volume."""
EXAMPLE = "vibroimpact lyapunov --xi .0114 --mu .028 --restitution .75 --r 1.04 --clearance 10 30 5 -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """A system, points, and how long."""
    add_system(parser)
    add_range(parser, "r", "frequency ratio", required=True)
    add_range(parser, "clearance", "d K/F0", required=True)
    parser.add_argument(
        "--cycles",
        type=int,
        default=10_000,
        metavar="N",
        help="load cycles averaged over (default: 10000)",
    )
    parser.add_argument(
        "--discard",
        type=int,
        default=1000,
        metavar="N",
        help="load cycles before them (default: 1000)",
    )
    parser.add_argument(
        "--state", type=float, nargs=4, metavar=("X", "X_DOT", "Z", "Z_DOT"),
        help="where each point starts, at t = 0 (default: rest in the middle)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Compute, print and write them."""
    r = np.atleast_1d(numbers(options.r, "r"))
    clearance = np.atleast_1d(numbers(options.clearance, "clearance"))
    if 1 < r.size != clearance.size > 1:
        raise ParameterError(
            f"--r, --clearance: {r.size} and {clearance.size} values; must be as many, or one of them a number"
        )
    state = None
    if options.state is not None:
        state = dict(zip(("t", "x", "x_dot", "z", "z_dot"), (0.0, *options.state), strict=True))
    result = with_bar(
        options, lyapunov, oscillator(options), r, clearance, options.cycles, state, discard=options.discard,
    )  # fmt: skip
    each = result.per_cycle
    errors = result.standard_error * (2 * np.pi / result.r)
    names = [
        "r",
        "clearance",
        *(f"exponent_{j}" for j in range(1, 5)),
        *(f"error_{j}" for j in range(1, 5)),
    ]
    names += ["dimension", "identity_error", "impacts", "rests"]
    rows = zip(
        result.r.tolist(), result.clearance.tolist(), *each.tolist(), *errors.tolist(),
        result.dimension.tolist(), result.identity_error.tolist(), result.impacts.tolist(),
        result.rests.tolist(), strict=True,
    )  # fmt: skip
    write_table(options, "lyapunov", names, rows, result)
    for i in range(result.r.size):
        shown = "  ".join(f"{value:10.6f}" for value in each[:, i])
        print(f"r = {result.r[i]:.6g}  d K/F0 = {result.clearance[i]:.6g}:  {shown}")
    draw(options, "lyapunov", result)
    lost = int(np.isnan(each).any(axis=0).sum())
    if lost:
        options.record.fault(
            f"lyapunov: no exponents at {lost} of {result.r.size} points: no impacts, or none that could be "
            "found; another start may lead to some: --state X X_DOT Z Z_DOT"
        )
    return status(options, lost > 0)
