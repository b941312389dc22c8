"""`vibroimpact plot`: pictures of the cases of namelist files."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..errors import ParameterError, SingularError
from ..motion import Motion
from ..run import Case, read_namelist
from ..studies.branch import Branch
from ..studies.zone import Zone
from ..trajectory import Trajectory
from . import PICTURES, add_files, add_folder, picture_writer

HELP = "draw the cases of namelist files"
DESCRIPTION = """Draw each motion and each simulation that namelist files ask for: time history, load,
acceleration and phase portrait; each branch along its parameter; each zone in its window; in
DIR/NAME.png (NAME_1, NAME_2 if a case has two motions or branches)."""
EXAMPLE = "vibroimpact plot inputs/table1.nml -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the format of pictures."""
    add_files(parser)
    add_folder(parser)
    parser.add_argument(
        "--format", default=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"{', '.join(PICTURES)} (default: {PICTURES[0]})",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Draw all cases of all files; nothing is drawn unless every file is right."""
    save = picture_writer()
    if not options.folder:
        raise ParameterError("DIR = '': must name a folder")
    cases = [(file, case) for file in options.files for case in read_namelist(file)]
    Path(options.folder).mkdir(parents=True, exist_ok=True)
    status = 0
    drawn: set[Path] = set()
    for file, case in cases:
        reason = "there is no such motion for these parameters"
        if case.kind == "zone":
            reason = "there is no zone of stable, admissible motions in the window"
        things: Sequence[Motion | Trajectory | Branch | Zone] = ()
        try:
            things = pictured(case)
        except SingularError as error:
            reason = str(error)
        if not things:
            print(f"{case.name}: {reason}", file=sys.stderr)
            status = max(status, 1)
        for i, thing in enumerate(things, start=1):
            name = case.name if len(things) == 1 else f"{case.name}_{i}"
            path = Path(options.folder) / f"{name}.{options.format}"
            if path in drawn:
                print(
                    f"{file}: &output name = {case.name!r}: {path} is already the picture of another "
                    "case; must be another",
                    file=sys.stderr,
                )
                status = 2
                continue
            drawn.add(path)
            print(f"{case.name}: {save(thing.plot(), path)}")
    return status


def pictured(case: Case) -> Sequence[Motion | Trajectory | Branch | Zone]:
    """What is drawn of a case, each in a picture of its own."""
    if case.kind == "zone":
        zone = case.zone()
        return [zone] if zone else []
    if case.kind == "simulate":
        return [case.trajectory()]
    return case.branches() if case.kind == "branch" else case.motions()
