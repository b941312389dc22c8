"""`vibroimpact run`: namelist files to tables."""

from __future__ import annotations

import argparse
import os
import sys

from ..run import RunLog
from . import Record, add_files, add_forms

HELP = "run namelist files"
DESCRIPTION = """Run the cases of namelist files, of any kind. Each is written to DIR/NAME.csv, with the same
digits as the stand-alone program vibroimpact-batch gives, or in another form, which holds
every bit and is read by vibroimpact.load (NAME_1, NAME_2 if a case has several motions or
branches); with --plot a picture stands beside it."""
EXAMPLE = "vibroimpact init exact && vibroimpact run exact.nml -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the forms of the results."""
    add_files(parser)
    add_forms(parser)


def run(options: argparse.Namespace) -> int:
    """Run all cases of all files."""
    from .cases import run_kind
    from .study import Request

    return run_kind(options, Request())


def tell(log: RunLog, record: Record | None = None) -> None:
    """Print what was said while namelist files ran, faults to standard error."""
    for fault, line in log.lines:
        if fault and record is not None:
            record.faults.append(line)
        stream = sys.stderr if fault else sys.stdout
        # a path need not be text: its bytes are printed as they are
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()
