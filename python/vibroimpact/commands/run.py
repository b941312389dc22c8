"""`vibroimpact run`: namelist files to tables."""

from __future__ import annotations

import argparse
import os
import sys

from ..progress import Progress
from ..run import RunLog, run_namelists
from . import add_files, add_folder

HELP = "run namelist files"
DESCRIPTION = """Run namelist files: each case is written to DIR/NAME.csv, with the same digits as
the stand-alone program vibroimpact-batch gives."""
EXAMPLE = "vibroimpact run inputs/table1.nml -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files and folder."""
    add_files(parser)
    add_folder(parser)


def run(options: argparse.Namespace) -> int:
    """Run all cases of all files."""
    with Progress("run") as bar:
        log = run_namelists(options.files, options.folder, progress=bar.show if bar.wanted else None)
    tell(log)
    return log.status


def tell(log: RunLog) -> None:
    """Print what was said while namelist files ran, faults to standard error."""
    for fault, line in log.lines:
        stream = sys.stderr if fault else sys.stdout
        # a path need not be text: its bytes are printed as they are
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()
