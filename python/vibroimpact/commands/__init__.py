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

from ..errors import ParameterError

#: In the order of the help text.
NAMES = (
    "run", "simulate", "find", "branch", "zone", "atlas", "chart", "bifurcation", "basins", "lyapunov", "response",
    "explore", "plot", "reproduce", "init", "doctor", "bench", "completion",
)  # fmt: skip

#: Forms of results, with what their names end with; the first one if none is named.
FORMATS = {"csv": "csv", "netcdf": "nc", "json": "json", "matlab": "mat"}
#: Formats of pictures, the first one if none is named.
PICTURES = ("png", "svg", "pdf")
#: Formats of animations.
ANIMATIONS = ("gif", "mp4")


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


def add_folder(parser: argparse.ArgumentParser, file: str = "") -> None:
    """The folder that a command writes to."""
    parser.add_argument(
        "-o", dest="folder", default="results", metavar="DIR", help=f"folder for the results{file}"
    )


def name_file(options: argparse.Namespace) -> None:
    """Take `-o DIR/NAME.json` as the folder, the form and the name of the one result."""
    options.stem = ""
    if getattr(options, "folder", "results") == "":
        raise ParameterError("-o '': must name a folder")
    if not hasattr(options, "plot"):
        return
    options.format, asked = options.format or "csv", options.format
    path = Path(options.folder)
    forms = {suffix: form for form, suffix in FORMATS.items()}
    form = forms.get(path.suffix[1:].lower())
    if form is None:
        return
    if asked not in (None, form):
        raise ParameterError(
            f"-o {path}: is the name of a {form} file; must go with --format {asked}"
        )
    options.folder, options.format, options.stem = str(path.parent), form, path.stem


def add_forms(parser: argparse.ArgumentParser) -> None:
    """The folder and the form of the results, and of pictures beside them."""
    add_folder(parser, ", or DIR/NAME.csv, .json, .nc or .mat for a single one")
    parser.add_argument(
        "--format",
        choices=FORMATS,
        help="form of the results (default: csv, or that of the file's name)",
    )
    parser.add_argument(
        "--plot", nargs="?", const=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"draw it, as {', '.join(PICTURES)} (default: {PICTURES[0]})",
    )  # fmt: skip


def need_extras(options: argparse.Namespace) -> None:
    """An error before anything is computed, if a library is missing by which the result is to be written."""
    form = getattr(options, "format", None)
    if form == "netcdf":
        from ..interchange.dataset import need_netcdf

        need_netcdf()
    if form == "matlab":
        from ..interchange.matlab import scipy_io

        scipy_io()
    if getattr(options, "plot", None):
        picture_writer()


def picture_writer() -> Callable[[Any, Path], Path]:
    """What writes the figure of some axes to a file; an error where matplotlib is missing."""
    from ..plot import style

    style.pyplot().switch_backend("agg")  # no window
    return style.save
