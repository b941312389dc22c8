"""`vibroimpact run`: namelist files to tables."""

from __future__ import annotations

import argparse

from . import add_files, add_forms, add_units

DESCRIPTION = """Run the cases of namelist files, of any kind. Each result is written to DIR/NAME.csv, with
the same digits as from the stand-alone program vibroimpact-batch, or in another format,
which preserves every bit and can be read by vibroimpact.load (NAME_1, NAME_2 if a case has
several motions or branches); --plot also writes a picture."""
EXAMPLE = "vibroimpact init exact && vibroimpact run exact.nml -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the formats of the results."""
    add_files(parser)
    add_forms(parser)
    add_units(parser)


def run(options: argparse.Namespace) -> int:
    """Run all cases of all files."""
    from .cases import run_kind
    from .request import Request

    return run_kind(options, Request())
