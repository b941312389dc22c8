"""`vibroimpact lyapunov`: all four Lyapunov exponents at a point or along a line."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError
from ..results.tables import keys_for
from ..systems.units import place_text
from .cases import run_kind
from .options import Option, options_of, shown
from .request import Request, request_of
from .study import add_study

DESCRIPTION = """Compute the four Lyapunov exponents per load cycle of the motion on which a simulation
settles, at a point or along a line of r or of d K/F0, through impacts, accumulations and
rests, for the &lyapunov cases of namelist files or for the case given by the options. They
are written to DIR/NAME.csv, one row for each point with their standard errors and the check
by volume, or in another format; --plot also writes a picture. NAME is "lyapunov" for the
case of the options."""
EXAMPLE = "vibroimpact lyapunov --xi .0114 --mu .028 --restitution .75 --r 1.04 --clearance 10 30 5 -o results"

#: The options of which one may be a line of points, and their help texts.
LINES = {
    "r": "frequency ratio: a number, or LOW HIGH N for N values",
    "clearance": "clearance d K/F0 (d is the whole travel of m): a number, or LOW HIGH N for N values",
}
#: The keys of such a line.
SPAN = ("low", "high", "values")


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a case whose line of points has the name of its parameter."""
    own = {name: {"nargs": "+", "help": text} for name, text in LINES.items()}
    add_study(parser, options_of("lyapunov"), **own)


def request(options: argparse.Namespace) -> Request:
    """The case that the options name."""
    known = options_of("lyapunov")
    line: dict[str, str] = {}
    for name in LINES:
        given = getattr(options, name) or [None]
        if len(given) == 1:
            setattr(options, name, given[0])
            continue
        if len(given) != 3:
            raise ParameterError(f"--{name} {shown(given)}: must be a number, or LOW HIGH N")
        if line:
            raise ParameterError("--r, --clearance: one of them must be a number")
        keys = keys_for("lyapunov")
        known[name] = Option(name, [("lyapunov", key) for key in keys if key["name"] in SPAN])
        line = {"parameter": name}
    return request_of(options, "lyapunov", known, lyapunov=line)


def run(options: argparse.Namespace) -> int:
    """Compute, print, write and draw the exponents."""
    status = run_kind(options, request(options), details)
    named = options.files or options.state
    if not named and any(": no exponents" in line for line in options.record.faults):
        options.record.fault(
            "vibroimpact lyapunov: another initial state may lead to impacts: --state X X_DOT Z Z_DOT"
        )
    return status


def details(result: Any) -> list[str]:
    """Lines with the exponents of each point, or of a structure."""
    if result.of_structure:
        values = zip(result.per_cycle, result.error_per_cycle, strict=True)
        unit = f"per {result.cycle}"
        return [
            f"{i}:  {value:10.6f} +- {error:.6f} {unit}"
            for i, (value, error) in enumerate(values, 1)
        ]
    points = zip(
        result.r.ravel(), result.clearance.ravel(), result.per_cycle.reshape(4, -1).T,
        result.error_per_cycle[0].ravel(), strict=True,
    )  # fmt: skip
    return [
        f"{place_text(result.osc, r, clearance)}:  {'  '.join(f'{value:10.6f}' for value in each)}"
        f"  per load cycle, the first +- {error:.6f}"
        for r, clearance, each, error in points
    ]
