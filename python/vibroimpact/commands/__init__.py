"""The subcommands of `vibroimpact`, one module each.

A module has DESCRIPTION, EXAMPLE (which works when pasted into a shell in the project folder),
`arguments(parser)`, which adds its arguments, and `run(options)`, which returns the exit status; `HELPS` describes
each command in one line. A study whose command needs no specific text or options needs no module; see `study.py`.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError
from ..results.tables import language

#: The studies that have a command, with the core's description of each; motions have none.
STUDIES: dict[str, str] = {
    name: study["meaning"]
    for name, study in language()["results"].items() if name != "motion"
}  # fmt: skip
#: A description of each command, in the order of the help text, so that the help does not import their modules.
HELPS = {
    "run": "run namelist files",
    **STUDIES,
    "prove": "prove the motions, branches and zones of namelist files",
    "campaign": "compute all cases of a sweep into a store",
    "explore": "explore zones and motions interactively in a browser",
    "plot": "draw the cases of namelist files",
    "reproduce": "recompute the tables and figures of the 1983 paper",
    "init": "write a commented namelist to start from",
    "doctor": "report what is installed, whether it computes correctly, and what is missing",
    "completion": "print a script that enables completion in the shell",
}
NAMES = tuple(HELPS)

#: Formats of results, with the extensions of their names; the first one is the default.
FORMATS = {"csv": "csv", "netcdf": "nc", "json": "json", "matlab": "mat"}
#: Formats of pictures; the first one is the default.
PICTURES = ("png", "svg", "pdf")
#: Formats of animations.
ANIMATIONS = ("gif", "mp4")
#: Characters with which the name of a folder may end.
SEPARATORS = tuple(filter(None, (os.sep, os.altsep)))


class Record:
    """What a command did, for scripts: `--json` prints this record in place of the normal output."""

    def __init__(self, command: str) -> None:
        self.command = command
        self.faults: list[str] = []
        self.files: list[str] = []
        self.results: dict[str, Any] = {}
        #: Whether Ctrl-C was pressed while a result was written.
        self.halted = False

    def fault(self, line: str) -> None:
        """Report an error."""
        self.faults.append(line)
        print(line, file=sys.stderr)

    def wrote(self, name: str, path: Path) -> None:
        """Report a written file."""
        self.files.append(str(path))
        print(f"{name}: {path}")

    def add(self, name: str, result: Any) -> None:
        """Add a result, as plain values or as an object of the package; a later result replaces one of the same
        name."""
        self.results[name] = result

    def interrupted(self, writes: bool) -> None:
        """Report what remains after Ctrl-C, for commands that write files and for others."""
        left = "; writing was stopped, no incomplete file is left" if self.halted else ""
        if self.files:
            some = ", ".join(self.files[:3]) + ", ..." * (len(self.files) > 3)
            left += f"; finished results are kept: {some}"
        elif self.halted:
            pass
        elif self.results:
            left = "; finished results were printed"
        elif writes:
            left = "; nothing was finished"
        self.fault(f"vibroimpact {self.command}: interrupted{left}")

    def text(self, status: int, printed: str) -> str:
        """One JSON document."""
        results = {
            name: item.to_dict() if hasattr(item, "to_dict") else item
            for name, item in self.results.items()
        }
        document = {
            "command": self.command, "status": status, "faults": self.faults,
            "output": printed.splitlines(), "files": self.files, "results": results,
        }  # fmt: skip
        return json.dumps(document, allow_nan=False)


def add_common(parser: argparse.ArgumentParser) -> None:
    """Options that every command has."""
    parser.add_argument("--quiet", action="store_true", help="print only errors")
    parser.add_argument(
        "--json", action="store_true", help="print only one JSON document, for scripts"
    )


def add_files(parser: argparse.ArgumentParser, count: str = "+") -> None:
    """The namelist files that a command reads."""
    instead = "" if count == "+" else "; instead of the options that name a case"
    parser.add_argument(
        "files", nargs=count, metavar="FILE.nml",
        help=f"namelist files, or earlier results as CSV{instead}",
    )  # fmt: skip


def add_folder(parser: argparse.ArgumentParser, file: str = "", on_request: bool = False) -> None:
    """The folder that a command writes to, always or only if requested."""
    without = (
        "without -o, --format and --plot nothing is written" if on_request else "default: results"
    )
    parser.add_argument(
        "-o", dest="folder", default=None if on_request else "results", metavar="DIR",
        help=f"folder for the results{file} ({without})",
    )  # fmt: skip


class Fresh:
    """Finds which of some files have been created or replaced since this object was made."""

    def __init__(self, paths: Iterable[Path]) -> None:
        self.before = {path: self.stamp(path) for path in paths}

    @staticmethod
    def stamp(path: Path) -> tuple[int, int] | None:
        """Properties that differ for a new file of this name; None if there is no such file."""
        with contextlib.suppress(OSError):
            state = path.stat()
            return state.st_ino, state.st_mtime_ns
        return None

    def paths(self) -> list[Path]:
        """The files that were created or replaced."""
        stamps = ((path, self.stamp(path)) for path in self.before)
        return [path for path, now in stamps if now not in (None, self.before[path])]


@contextlib.contextmanager
def not_left_empty(folder: Path) -> Iterator[None]:
    """Remove a new folder, and new folders above it, at the end if it is still empty."""
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        yield
    finally:
        for path in new:
            with contextlib.suppress(OSError):
                path.rmdir()


@contextlib.contextmanager
def ready(folder: Path) -> Iterator[None]:
    """Make sure, before anything is computed, that a folder can be written to; a new one is removed if it stays
    empty."""
    with not_left_empty(folder):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(folder)) from None
        yield


def name_file(options: argparse.Namespace) -> None:
    """Split `-o DIR/NAME.json` into the folder, the format and the name of the single result.

    Any other name that looks like a file name is rejected, unless a folder of this name exists, or the name ends
    with a slash.
    """
    options.stem = ""
    folder = getattr(options, "folder", None)
    if folder == "":
        raise ParameterError("-o '': must name a folder")
    takes_file = hasattr(options, "plot")
    asked = options.format if takes_file else None
    if takes_file and (folder or asked or options.plot):
        options.folder, options.format = folder or "results", asked or "csv"
    if folder is None:
        return
    path = Path(folder)
    suffix = path.suffix[1:].lower() if takes_file and not folder.endswith(SEPARATORS) else ""
    need_folder(folder, path.parent if suffix in FORMATS.values() else path)
    if folder.endswith(SEPARATORS) or path.is_dir():
        return
    forms = {suffix: form for form, suffix in FORMATS.items()}
    form = forms.get(suffix)
    if form is not None:
        if asked not in (None, form):
            raise ParameterError(
                f"-o {path}: is the name of a {form} file; must be used with --format {form}, or without --format"
            )
        options.folder, options.format, options.stem = str(path.parent), form, path.stem
    elif folder == "-" or re.fullmatch(r"\.[A-Za-z][A-Za-z0-9]{0,4}", path.suffix):
        wanted = ", ".join(f".{suffix}" for suffix in forms) if takes_file else ""
        raise ParameterError(
            f"-o {folder}: must be a folder{wanted and ', or a file whose name ends with one of '}{wanted}; for a "
            f"folder of this name, write -o {folder}/"
        )


def need_folder(folder: str, path: Path) -> None:
    """Raises an error, before anything is computed, if a file is in place of the folder or of one above it."""
    for place in (path, *path.parents):
        if place.exists() and not place.is_dir():
            raise ParameterError(f"-o {folder}: {place} is a file; must be a folder")


def add_forms(parser: argparse.ArgumentParser, on_request: bool = False) -> None:
    """Options for the folder and the format of the results, and of pictures beside them."""
    add_folder(parser, ", or DIR/NAME.csv, .json, .nc or .mat for a single one", on_request)
    parser.add_argument(
        "--format",
        choices=FORMATS,
        help="format of the results (default: csv, or that of the file's name)",
    )
    parser.add_argument(
        "--plot", nargs="?", const=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"also draw the results, as png, svg or pdf (default: {PICTURES[0]})",
    )  # fmt: skip


def add_units(parser: argparse.ArgumentParser) -> None:
    """The option for the units of results."""
    parser.add_argument(
        "--units", metavar="UNITS",
        help="units of the results, such as 'mm N s' or SI, or dimensionless "
        "(default: those of the &system, mm for m)",
    )  # fmt: skip


def need_extras(options: argparse.Namespace) -> None:
    """Raises an error, before anything is computed, if a library needed to write the result is missing."""
    form = getattr(options, "format", None)
    if form == "netcdf":
        from ..base.libraries import need_netcdf

        need_netcdf()
    if form == "matlab":
        from ..base.matlab import scipy_io

        scipy_io()
    if getattr(options, "plot", None):
        picture_writer()


def picture_writer() -> Callable[[Any, Path], Path]:
    """The function that writes the figure of some axes to a file; an error if matplotlib is missing."""
    from ..plot import style

    style.pyplot().switch_backend("agg")  # no window
    return style.save
