"""The subcommands of `vibroimpact`, one module each.

A module has HELP (one line), DESCRIPTION, EXAMPLE (works as pasted, in the folder of the project),
`arguments(parser)`, which adds its arguments, and `run(options)`, which gives the exit status.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

#: In the order of the help text.
NAMES = (
    "run", "simulate", "find", "branch", "zone", "atlas", "bifurcation", "basins", "lyapunov", "response",
    "explore", "plot", "reproduce",
)  # fmt: skip

#: Formats of pictures, the first one if none is named.
PICTURES = ("png", "svg", "pdf")


def add_files(parser: argparse.ArgumentParser, count: str = "+") -> None:
    """The namelist files that a command reads."""
    parser.add_argument(
        "files", nargs=count, metavar="FILE.nml", help="namelist files, or earlier results"
    )


def add_folder(parser: argparse.ArgumentParser) -> None:
    """The folder that a command writes to."""
    parser.add_argument(
        "-o", dest="folder", default="results", metavar="DIR", help="folder for the results"
    )


def picture_writer() -> Callable[[Any, Path], Path]:
    """What writes the figure of some axes to a file; an error where matplotlib is missing."""
    from ..plot import style

    style.pyplot().switch_backend("agg")  # no window
    return style.save
