"""`vibroimpact lyapunov`: all four Lyapunov exponents at a point or along a line."""

from __future__ import annotations

import argparse
from typing import Any

from ..errors import ParameterError
from .cases import run_kind
from .options import (
    STATE,
    Request,
    add_case,
    add_numbers,
    add_spacing,
    add_state,
    span,
    values,
)

HELP = "compute all Lyapunov exponents at a point or along a line"
DESCRIPTION = """Compute the four Lyapunov exponents per load cycle of what a simulation settles on, at a
point or along a line of r or of d K/F0, through impacts, accumulations and rests, for the
&lyapunov cases of namelist files or for the one that the options name. They are written to
DIR/NAME.csv, one row a point with their standard errors and the check by volume, or in
another form; with --plot a picture stands beside them. NAME is "lyapunov" for the case of
the options."""
EXAMPLE = "vibroimpact lyapunov --xi .0114 --mu .028 --restitution .75 --r 1.04 --clearance 10 30 5 -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, points, and how long."""
    add_case(parser)
    for name, wanted in (("r", "frequency ratio"), ("clearance", "clearance d K/F0")):
        parser.add_argument(
            f"--{name}", type=float, nargs="+", metavar="V",
            help=f"{wanted}: a number, or LOW HIGH N for N of them",
        )  # fmt: skip
    add_spacing(parser, "N values")
    add_numbers(
        parser,
        cycles="load cycles averaged over (default: 10000)",
        discard="load cycles before them (default: 1000)",
    )
    add_state(parser, "where each point starts")


def run(options: argparse.Namespace) -> int:
    """Compute, print, write and draw them."""
    point, line = points(options)
    groups = {
        "system": {**values(options, "xi", "mu", "restitution"), "r": point["r"]},
        "lyapunov": {
            "clearance": point["clearance"], **line, **values(options, "spacing", "cycles", "discard"),
            **dict(zip(STATE, options.state or (), strict=False)),
        },
    }  # fmt: skip
    spans = dict.fromkeys(STATE, "state")
    spans |= dict.fromkeys(("low", "high", "values"), str(line.get("parameter")))
    needed = ("xi", "mu", "restitution", "r", "clearance")
    status = run_kind(options, Request("lyapunov", groups, needed, spans), details)
    named = options.files or options.state
    if not named and any(": no exponents" in line for line in options.record.faults):
        options.record.fault(
            "vibroimpact lyapunov: another start may lead to impacts: --state X X_DOT Z Z_DOT"
        )
    return status


def points(options: argparse.Namespace) -> tuple[dict[str, float | None], dict[str, Any]]:
    """The two numbers, None for one that changes or is not given, and the keys of the one that changes."""
    point: dict[str, float | None] = {}
    line: dict[str, Any] = {}
    for name in ("r", "clearance"):
        given = getattr(options, name) or [None]
        point[name] = given[0] if len(given) == 1 else None
        if len(given) > 1:
            low, high, n = span(given, name, "a number, or LOW HIGH N")
            if line:
                raise ParameterError("--r, --clearance: one of them must be a number")
            line = {"parameter": name, "low": low, "high": high, "values": n}
    return point, line


def details(result: Any) -> list[str]:
    """The exponents of each point."""
    points = zip(
        result.r.ravel(), result.clearance.ravel(), result.per_cycle.reshape(4, -1).T, strict=True
    )
    return [
        f"r = {r:.6g}  d K/F0 = {clearance:.6g}:  {'  '.join(f'{value:10.6f}' for value in each)}"
        for r, clearance, each in points
    ]
