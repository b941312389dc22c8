"""Cases of namelist files, or the one that options name: run, written in any form, and drawn, once."""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ..case import Case, read_namelist
from ..errors import (
    ParameterError,
    SingularError,
    StudyInterrupted,
)
from ..files import write_text
from ..interchange.csv_file import cut_of, head_text, notes, rows_text
from ..interchange.table import columns
from ..interrupt import interruptible
from ..noun import Noun
from ..plot.animation import check_format
from ..progress import Progress
from ..run import run_namelists
from . import FORMATS, Fresh, not_left_empty, picture_writer, ready
from .request import Request, case_files, in_options, read_cases
from .words import PARTIAL, WORDS, tell

#: What writes the figure of some axes to a file, if that is wanted.
Save = Callable[[Any, Path], Path] | None
#: What a command tells of a result beside what the compiled program says.
Details = Callable[[Any], list[str]]


def run_kind(options: argparse.Namespace, request: Request, details: Details | None = None) -> int:
    """Run all cases of a kind (or of any), write and draw them; gives the exit status.

    Tables alone are left to the compiled program. Its words are those that are said in any case, and its tables
    have the bytes of those that are written here. Branches and studies of attractors by commands of their own are
    always computed here: Ctrl-C leaves the part of a case that is finished.
    """
    folder = Path(options.folder)
    animated = getattr(options, "animate", None)
    save = picture_writer() if options.plot or animated else None
    if animated:
        check_format(animated, f"--animate {animated}")
    more = save is not None or options.format != "csv" or options.json or options.stem
    if not more and request.kind not in PARTIAL:
        return tables(options, request, folder)
    cases, faults = read_cases(options, request)
    for line in faults:
        options.record.fault(line)
    status = 2 if faults else 0
    cases = renamed(options, cases)
    for case in cases:
        spare_inputs(options, case, folder)
    with ready(folder) if cases else contextlib.nullcontext():
        for case in cases:
            if case.kind in WORDS:
                status = max(status, finish(options, case, folder, save, details))
            else:
                status = max(status, shorter(options, case, folder, save))
    return status


def tables(options: argparse.Namespace, request: Request, folder: Path) -> int:
    """Leave all to the compiled program."""
    with (
        case_files(options, request) as (files, made),
        not_left_empty(folder),
        Progress(request.kind or "run") as bar,
    ):
        written = Fresh(results_of(files, request.kind, folder))

        def show(share: float) -> None:
            """As many results as there are, and a share of the next one."""
            done = len(written.paths())
            bar.show(min(share * (done + 1), done + 1) / max(1, len(written.before)))

        try:
            log = run_namelists(files, folder, request.kind, show if bar.wanted else None)
        except KeyboardInterrupt:
            options.record.files += map(str, written.paths())
            raise
    if made and log.status == 2 and not log.results:
        lines = [in_options(line, made, request, options) for _, line in log.lines]
        raise ParameterError("\n".join(lines))
    tell(log)
    return log.status


def results_of(files: Sequence[str], kind: str | None, folder: Path) -> list[Path]:
    """Where the compiled program writes, as far as it can be told: a pipe is read only once."""
    found = []
    for file in filter(os.path.isfile, files):
        with contextlib.suppress(ParameterError):
            for case in read_namelist(file):
                if kind in (None, case.kind):
                    suffix = "txt" if case.keys.get("format") == "table" else "csv"
                    found.append(folder / f"{case.name}.{suffix}")
    return found


def renamed(options: argparse.Namespace, cases: list[Case]) -> list[Case]:
    """The cases; the only one with the name of the file that -o names."""
    if not options.stem or not cases:  # of files with faults alone nothing more is said
        return cases
    if len(cases) != 1:
        raise ParameterError(
            f"-o {options.stem}.{FORMATS[options.format]}: names a file, and there are {len(cases)} cases; must "
            "be a folder"
        )
    text = re.sub(r"(?m)^(  name = ).*$", rf"\g<1>'{options.stem}'", cases[0].text)
    return [cases[0]._replace(name=options.stem, text=text)]


def spare_inputs(options: argparse.Namespace, case: Case, folder: Path) -> None:
    """An error if a table would take the place of an input that is none."""
    path = folder / f"{case.name}.csv"
    for file in options.files if path.is_file() and options.format == "csv" else ():
        if os.path.isfile(file) and path.samefile(file):
            with path.open(encoding="utf-8", errors="replace") as lines:
                if not lines.readline().startswith("# ! vibroimpact"):
                    raise ParameterError(
                        f"{file}: &output name = {case.name!r}: its result would overwrite this input; must be "
                        "another name or folder"
                    )


def shorter(options: argparse.Namespace, case: Case, folder: Path, save: Save) -> int:
    """Leave the table and the words of a case to the compiled program, and make the rest of it anew.

    For motions, which take no time, and of which only that program makes the printout.
    """
    with tempfile.TemporaryDirectory() as place:
        source = Path(place) / "case.nml"
        source.write_text(case.text, encoding="utf-8")
        with Progress(case.name) as bar:
            target = folder if options.format == "csv" else place
            log = run_namelists([source], target, progress=bar.show)
    said = [line for line in log.lines if place not in line[1]]  # a table there is for nobody
    tell(log._replace(lines=said), options.record)
    if options.format == "csv":
        options.record.files += map(str, log.results)
    results = []
    if log.results and (save is not None or options.json or options.format != "csv"):
        with Progress(case.name) as bar:
            results = interruptible(case.run, watch=partial(bar.show, 0.0))
    put(options, case, results, folder, save)
    return log.status


def finish(
    options: argparse.Namespace, case: Case, folder: Path, save: Save, details: Details | None
) -> int:
    """Compute a case that takes its time, say what came out, write and draw it."""
    stopped, record = False, options.record
    results: list[Any]
    with Progress(case.name) as bar:
        try:
            results = [case.branches(bar.show)] if case.kind == "branch" else case.run(bar.show)
        except StudyInterrupted as stop:
            results, stopped = [stop.result], True
        except SingularError as error:
            record.fault(f"{case.name}: {error}")
            return 1
        except ParameterError as error:
            if case.kind != "simulate":
                raise
            # no fault of the file: max_events was reached before there was anything to keep
            record.fault(f"{case.name}: {error}")
            return 1
    if stopped:  # a large table takes its time
        said = f"vibroimpact {record.command}: interrupted; writing what is finished ..."
        print(said, file=sys.stderr, flush=True)
    try:
        status = deliver(options, case, results, stopped, folder, save, details)
    except KeyboardInterrupt:
        record.halted = True
        raise
    if stopped:
        raise KeyboardInterrupt
    return status


def deliver(
    options: argparse.Namespace, case: Case, results: Sequence[Any], stopped: bool,
    folder: Path, save: Save, details: Details | None,
) -> int:  # fmt: skip
    """Say what came out of a case; write and draw it."""
    news, faults, there = WORDS[case.kind](*results)
    for line in [*news, *(line for result in results for line in cut_of(result))]:
        print(f"{case.name}: {line}")
    for line in [] if stopped else faults:
        options.record.fault(f"{case.name}: {line}")
    if there:
        put(options, case, results, folder, save)
        for line in details(*results) if details else []:
            print(line)
    return 1 if faults else 0


def put(
    options: argparse.Namespace, case: Case, results: Sequence[Any], folder: Path, save: Save
) -> None:
    """Write the results of a case in the form that is wanted, all in one table, and draw them."""
    folder.mkdir(parents=True, exist_ok=True)
    if options.format == "csv" and case.kind in WORDS:
        options.record.wrote(case.name, write(results, case, folder / f"{case.name}.csv"))
    if case.kind == "branch":
        (branches,) = results
        results = list(branches)
    for i, result in enumerate(results, start=1):
        name = case.name if len(results) == 1 else f"{case.name}_{i}"
        options.record.add(name, result)
        if options.format != "csv":
            path = folder / f"{name}.{FORMATS[options.format]}"
            options.record.wrote(case.name, write([result], case, path))
        if save is not None and getattr(options, "animate", None):
            film = folder / f"{name}.{options.animate}"
            options.record.wrote(case.name, result.animate(film))
        if save is not None and options.plot:
            if getattr(result, "axes", ()) is None:
                print(f"{case.name}: random states have no picture")
            elif getattr(result, "zones", True):  # an atlas may have none
                drawn = folder / f"{name}.{options.plot}"
                options.record.wrote(case.name, save(picture(result, options), drawn))


def picture(result: Any, options: argparse.Namespace) -> Any:
    """The axes of a picture."""
    if hasattr(result, "windows"):
        return result.plot(quantity=getattr(options, "quantity", "x"))
    return result.plot()


def write(results: Sequence[Any], case: Case, path: Path) -> Path:
    """Results in the form that the name ends with, there; a table has the case in its header."""
    if isinstance(results[0], Noun):
        results[0].save(path)
    elif path.suffix == ".csv":
        remarks = [note for i, one in enumerate(results, start=1) for note in notes(one, i)]
        table = columns(results[0])
        write_text(path, head_text(case.text.splitlines(), remarks) + rows_text(table))
    else:
        results[0].save(path)
    return path
