"""`vibroimpact branch`: how motions change along a parameter."""

from __future__ import annotations

import argparse

from ..base.errors import ParameterError
from .cases import run_kind
from .options import Option, options_of
from .request import Request, request_of
from .study import add_study

DESCRIPTION = """Follow exact motions along a parameter, through folds, for the &branch cases of namelist
files or for the case given by the options. The motion has the given sides and approximately
the given phases; without them the equispaced motions are followed. The points, including
bifurcations, are written to DIR/NAME.csv; --plot also writes a picture. NAME is "branch" for
the case of the options."""
EXAMPLE = (
    "vibroimpact branch --xi .005 --mu .042 --restitution .75 --r .94 --clearance 37 --sides RL "
    "--phases-over-pi 0 1.37 --parameter clearance --bounds 10 60 -o results"
)

#: Keys of the &motion that a branch starts from.
START = ("clearance", "sides", "cycles", "phases", "phases_over_pi")


def known() -> dict[str, Option]:
    """The options."""
    return options_of("branch", {"motion": START})


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a motion, a parameter and its bounds."""
    add_study(parser, known())


def request(options: argparse.Namespace) -> Request:
    """The case that the options name."""
    guessed = options.phases_over_pi is not None or options.phases is not None
    if options.sides is not None and not guessed:
        raise ParameterError(
            f"--sides {options.sides}: must be used with --phases-over-pi, the approximate phases of its "
            "impacts; without both, the equispaced motions RL are followed"
        )
    walls: list[float] = options.restitution or []
    if not (guessed or options.files) and len(walls) == 2 and walls[0] != walls[1]:
        raise ParameterError(
            f"--restitution {walls[0]:g} {walls[1]:g}: must be the same for both walls, or be used with "
            "--sides and --phases-over-pi; without them, the equispaced motions are followed"
        )
    start = {"kind": "exact" if guessed else "equispaced"}
    return request_of(options, "branch", known(), motion=start)


def run(options: argparse.Namespace) -> int:
    """Follow the branches, write and draw them."""
    return run_kind(options, request(options))
