"""`vibroimpact plot`: pictures of the cases of namelist files."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, SingularError, VibroimpactError
from ..base.progress import Progress
from ..cases.case import Case, read_namelist
from ..systems.units import checked_names
from . import PICTURES, add_files, add_folder, add_units, picture_writer, ready

DESCRIPTION = """Draw the cases of namelist files to DIR/NAME.png or another format (NAME_1, NAME_2 if a case
has two motions or branches). Motions and simulations are drawn with time history, load,
acceleration and phase portrait, branches along their parameter, charts, zones and atlases in
their window; each study of attractors has its own picture."""
EXAMPLE = "vibroimpact init zone && vibroimpact plot zone.nml -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the format of pictures."""
    add_files(parser)
    add_folder(parser)
    parser.add_argument(
        "--format", default=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"format of the pictures: png, svg or pdf (default: {PICTURES[0]})",
    )  # fmt: skip
    add_units(parser)


def run(options: argparse.Namespace) -> int:
    """Draw all cases of all files; nothing is drawn if any file has an error."""
    save = picture_writer()
    cases = [(file, case) for file in options.files for case in read_namelist(file)]
    with ready(Path(options.folder)):
        return draw_all(options, cases, save)


def draw_all(
    options: argparse.Namespace,
    cases: Sequence[tuple[str, Case]],
    save: Callable[[Any, Path], Path],
) -> int:
    """Draw the cases, each with the name of its file; a case without a picture does not stop the others."""
    status = 0
    drawn: set[Path] = set()
    for file, case in cases:
        reason = "there is no such motion for these parameters"
        if case.kind in ("zone", "atlas"):
            reason = "there is no zone of stable, admissible motions in the window"
        drawings: Sequence[Callable[[], Any]] = ()
        faults: list[str] = []
        try:
            drawings, faults = pictured(case, options.units)
        except VibroimpactError as error:
            reason = str(error)
            status = max(status, 1 if isinstance(error, SingularError) else error.status)
        if not drawings:
            options.record.fault(f"{case.name}: {reason}")
            status = max(status, 1)
        for i, draw in enumerate(drawings, start=1):
            name = case.name if len(drawings) == 1 else f"{case.name}_{i}"
            path = Path(options.folder) / f"{name}.{options.format}"
            if path in drawn:
                options.record.fault(
                    f"{file}: &output name = {case.name!r}: {path} is already the picture of another "
                    "case; must be another"
                )
                status = 2
                continue
            drawn.add(path)
            try:
                options.record.wrote(case.name, save(draw(), path))
            except VibroimpactError as error:
                options.record.fault(f"{case.name}: {error}")
                status = max(status, error.status)
        # a picture does not show that something is missing from it
        for line in faults if drawings else []:
            options.record.fault(f"{case.name}: {line}")
            status = max(status, 1)
    return status


def pictured(case: Case, units: str | None) -> tuple[Sequence[Callable[..., Any]], list[str]]:
    """The functions that draw the pictures of a case, in physical units if they are given, and what failed."""
    if units == "dimensionless":
        drawings, faults = pictured(case, None)
        return [partial(draw, units=units) for draw in drawings], faults
    if units is not None:  # rejects a case without a picture before anything is computed
        checked_names(units, "--units")
        if case.missing_units:
            raise ParameterError(
                f"--units {units}: must be left out for {case.name}, whose {case.missing_units}"
            )
    with Progress(case.name) as bar:
        found = case.compute(bar.show if bar.wanted else None)
    found.require()
    results: Sequence[Any] = found.parts()
    shown = [item for item in results if item.drawable]
    if not shown and any(item.undrawable for item in results):
        raise SingularError(results[0].undrawable)
    faults = [text for fault, text in found._result.notes if fault]
    return [(item if units is None else item.physical(units)).plot for item in shown], faults
