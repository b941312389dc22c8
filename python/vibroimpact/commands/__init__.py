"""The subcommands of `vibroimpact`, one module each.

A module has HELP (one line), DESCRIPTION, EXAMPLE (works as pasted, in the folder of the project),
`arguments(parser)`, which adds its arguments, and `run(options)`, which gives the exit status.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

#: In the order of the help text.
NAMES = (
    "run", "simulate", "find", "branch", "zone", "atlas", "chart", "bifurcation", "basins", "lyapunov", "response",
    "plot", "reproduce", "init", "doctor", "completion",
)  # fmt: skip

#: Forms of results, with what their names end with; the first one if none is named.
FORMATS = {"csv": "csv", "netcdf": "nc", "json": "json", "matlab": "mat"}
#: Formats of pictures, the first one if none is named.
PICTURES = ("png", "svg", "pdf")


class Record:
    """What a command did, for scripts: `--json` prints it in place of what people read."""

    def __init__(self, command: str) -> None:
        self.command = command
        self.faults: list[str] = []
        self.files: list[str] = []
        self.results: dict[str, Any] = {}

    def fault(self, line: str) -> None:
        """Say what went wrong."""
        self.faults.append(line)
        print(line, file=sys.stderr)

    def add(self, name: str, result: Any) -> None:
        """A result, as plain values or as one of the package's own objects; of one name, the latest."""
        self.results[name] = result

    def text(self, status: int, said: str) -> str:
        """One JSON document."""
        results = {
            name: item.to_dict() if hasattr(item, "to_dict") else item
            for name, item in self.results.items()
        }
        document = {
            "command": self.command, "status": status, "faults": self.faults,
            "said": said.splitlines(), "files": self.files, "results": results,
        }  # fmt: skip
        return json.dumps(document, allow_nan=False)


def add_common(parser: argparse.ArgumentParser) -> None:
    """Options that every command has."""
    parser.add_argument("--quiet", action="store_true", help="say nothing but what went wrong")
    parser.add_argument(
        "--json", action="store_true", help="print one JSON document for scripts, and nothing else"
    )


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


def add_forms(parser: argparse.ArgumentParser) -> None:
    """The form of the results, and of pictures beside them."""
    parser.add_argument(
        "--format", choices=FORMATS, default="csv", help="form of the results (default: csv)"
    )
    parser.add_argument(
        "--plot", nargs="?", const=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"draw it, as {', '.join(PICTURES)} (default: {PICTURES[0]})",
    )  # fmt: skip


def picture_writer() -> Callable[[Any, Path], Path]:
    """What writes the figure of some axes to a file; an error where matplotlib is missing."""
    from ..plot import style

    style.pyplot().switch_backend("agg")  # no window
    return style.save
