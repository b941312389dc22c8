"""Runs the cases of namelist files, or the one that the options define, and writes and draws the results."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, StudyInterrupted, VibroimpactError
from ..base.progress import Progress
from ..cases.case import Case, read_namelist
from ..cases.run import RunLog, run_namelists
from ..formats.save import write_printout
from ..plot.animation import check_format
from ..results.noun import Noun
from ..results.tables import language
from ..systems.units import units_to_show
from . import FORMATS, Fresh, not_left_empty, picture_writer, ready
from .request import Request, read_cases

#: Writes the figure of some axes to a file; None if no picture is requested.
Save = Callable[[Any, Path], Path] | None
#: The lines that a command prints about a result in addition to those of the compiled program.
Details = Callable[[Any], list[str]]


def run_kind(options: argparse.Namespace, request: Request, details: Details | None = None) -> int:
    """Run all cases of a kind (or of any kind), write and draw the results; return the exit status.

    If only tables of cases of any kind are requested, the compiled program does everything; its messages and
    tables are the same.
    """
    folder = Path(options.folder)
    animated = getattr(options, "animate", None)
    save = picture_writer() if options.plot or animated else None
    if animated:
        check_format(animated, f"--animate {animated}")
    more = save is not None or options.format != "csv" or options.json or options.stem
    more = (
        more or getattr(options, "units", None) is not None or any(map(needs_python, options.files))
    )
    if not more and request.kind is None:
        return tables(options, folder)
    cases, faults = read_cases(options, request)
    for line in faults:
        options.record.fault(line)
    status = 2 if faults else 0
    cases = renamed(options, cases)
    for case in cases:
        spare_inputs(options, case, folder)
    with ready(folder) if cases else contextlib.nullcontext():
        for case in cases:
            status = max(status, finish(options, case, folder, save, details))
    return status


def needs_python(file: str) -> bool:
    """Whether a file has a case that only the Python package computes; for a pipe, which can be read only once,
    False."""
    groups = [name for name, about in language()["results"].items() if about["in_python"]]
    if not os.path.isfile(file):
        return False
    with open(file, encoding="utf-8", errors="replace") as lines:
        return any(re.match(rf"(?i)[#\s]*&({'|'.join(groups)})\b", line) for line in lines)


def tables(options: argparse.Namespace, folder: Path) -> int:
    """Run everything in the compiled program."""
    with not_left_empty(folder), Progress("run") as bar:
        written = Fresh(results_of(options.files, folder))

        def show(share: float) -> None:
            """Progress: the number of finished results, and the share of the next one."""
            done = len(written.paths())
            bar.show(min(share * (done + 1), done + 1) / max(1, len(written.before)))

        try:
            log = run_namelists(options.files, folder, progress=show if bar.wanted else None)
        except KeyboardInterrupt as stop:
            options.record.files += map(str, written.paths())
            if isinstance(stop, StudyInterrupted):
                bar.clear()
                print_log(stop.result)
            raise
    print_log(log)
    return log.status


def print_log(log: RunLog) -> None:
    """Print the messages of a run of namelist files, errors to standard error."""
    for fault, line in log.lines:
        stream = sys.stderr if fault else sys.stdout
        # a path need not be valid text; its bytes are printed unchanged
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()


def results_of(files: Sequence[str], folder: Path) -> list[Path]:
    """The paths that the compiled program will write, as far as they are known: a pipe can be read only once."""
    found = []
    for file in filter(os.path.isfile, files):
        with contextlib.suppress(ParameterError):
            for case in read_namelist(file):
                suffix = "txt" if case.keys.get("format") == "table" else "csv"
                found.append(folder / f"{case.name}.{suffix}")
    return found


def renamed(options: argparse.Namespace, cases: list[Case]) -> list[Case]:
    """The cases; a single case gets the name of the file that -o names."""
    if not options.stem or not cases:  # nothing more is printed for files that have only errors
        return cases
    if len(cases) != 1:
        raise ParameterError(
            f"-o {options.stem}.{FORMATS[options.format]}: names a file, and there are {len(cases)} cases; must "
            "be a folder"
        )
    text = re.sub(r"(?m)^(  name = ).*$", rf"\g<1>'{options.stem}'", cases[0].text)
    return [cases[0]._replace(name=options.stem, text=text)]


def spare_inputs(options: argparse.Namespace, case: Case, folder: Path) -> None:
    """Raises an error if a table would overwrite an input that is not an earlier result."""
    path = folder / f"{case.name}.csv"
    for file in options.files if path.is_file() and options.format == "csv" else ():
        if os.path.isfile(file) and path.samefile(file):
            with path.open(encoding="utf-8", errors="replace") as lines:
                if not lines.readline().startswith("# ! vibroimpact"):
                    raise ParameterError(
                        f"{file}: &output name = {case.name!r}: its result would overwrite this input; must be "
                        "another name or folder"
                    )


def finish(
    options: argparse.Namespace, case: Case, folder: Path, save: Save, details: Details | None
) -> int:
    """Compute a case, report the outcome, write and draw the result."""
    stopped, record = False, options.record
    with Progress(case.name) as bar:
        try:
            found = case.compute(bar.show)
        except StudyInterrupted as stop:
            found, stopped = stop.result, True
        except VibroimpactError as error:
            if not case.in_python:  # the core has checked its own cases
                raise
            record.fault(f"{case.name}: {error}")
            return error.status
    if stopped:  # writing a large table takes time
        message = f"vibroimpact {record.command}: interrupted; writing what is finished ..."
        print(message, file=sys.stderr, flush=True)
    try:
        status = deliver(options, case, found, stopped, folder, save, details)
    except KeyboardInterrupt:
        record.halted = True
        raise
    if stopped:
        raise KeyboardInterrupt
    return status


def deliver(
    options: argparse.Namespace, case: Case, found: Noun, stopped: bool, folder: Path, save: Save,
    details: Details | None,
) -> int:  # fmt: skip
    """Report the outcome of a case; write and draw the result."""
    result = found._result
    cut = [f"cut short: {result.cut}"] if result.cut else []
    for line in [*(text for fault, text in result.notes if not fault), *cut]:
        print(f"{case.name}: {line}")
    faults = [text for fault, text in result.notes if fault]
    for line in [] if stopped else faults:
        options.record.fault(f"{case.name}: {line}")
    if not result.empty:
        put(options, case, found, folder, save)
        for line in details(found) if details else []:
            print(line)
    return 1 if faults else 0


def put(options: argparse.Namespace, case: Case, found: Noun, folder: Path, save: Save) -> None:
    """Write the result of a case, in one table or each part separately in the requested format, and draw the
    parts."""
    folder.mkdir(parents=True, exist_ok=True)
    record = options.record
    if options.format == "csv":
        form = case.keys.get("format", "csv") if found.printable else "csv"
        if form != "csv":
            printout = folder / f"{case.name}.txt"
            write_printout(found, printout)
            record.wrote(case.name, printout)
        if form != "table":
            record.wrote(case.name, written(found, folder / f"{case.name}.csv"))
    parts = found.parts()
    for i, part in enumerate(parts, start=1):
        name = case.name if len(parts) == 1 else f"{case.name}_{i}"
        record.add(name, shown(part, case))
        if options.format != "csv":
            path = folder / f"{name}.{FORMATS[options.format]}"
            record.wrote(case.name, written(shown(part, case), path))
        if save is not None and getattr(options, "animate", None):
            film = folder / f"{name}.{options.animate}"
            record.wrote(case.name, part.animate(film, **units_of(case)))
        if save is not None and options.plot and part.drawable:
            drawn = folder / f"{name}.{options.plot}"
            record.wrote(case.name, save(picture(part, options, case), drawn))
        elif save is not None and options.plot and part.undrawable:
            print(f"{case.name}: {part.undrawable}")


def written(result: Any, path: Path) -> Path:
    """Write a result in the format given by the extension."""
    result.save(path)
    return path


def picture(result: Any, options: argparse.Namespace, case: Case) -> Any:
    """The axes of a picture."""
    quantity = getattr(options, "quantity", None)
    given = {} if quantity is None else {"quantity": quantity}
    return result.plot(**given, **units_of(case))


def units_of(case: Case) -> dict[str, str]:
    """The units that a case requests, as an argument of pictures."""
    return {"units": case.keys["units"]} if case.keys.get("units") else {}


def shown(result: Any, case: Case) -> Any:
    """A result in the units in which it is shown, if its system has units."""
    own, wanted = units_to_show(getattr(result, "_system", None)), case.keys.get("units")
    # identified parameters are in the units of the sensors
    if own is None or wanted == "dimensionless" or case.study == "identify":
        return result
    return result.physical(wanted or own)
