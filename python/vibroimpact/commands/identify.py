"""`vibroimpact identify`: the parameters of a rig from its records."""

from __future__ import annotations

import argparse
import contextlib

from ..base.errors import ParameterError
from . import add_forms
from .options import options_of
from .request import Request, request_of

DESCRIPTION = """Identify the parameters of a rig from records of its load and of the acceleration, velocity or
displacement of its primary mass, or from impact times alone, for records (.csv, .txt, .wav, .mat,
.nc, .json by SEP005, .uff), for the &identify cases of namelist files, or for the case given by
the options. Known values are given in SI units. --xi, --mu and --restitution are initial guesses
of the fit; those named by --fixed are known. The parameters with their errors and 95 % intervals
are written to DIR/NAME.csv, or in another format; --plot also draws every step.
NAME is "identify" for records and for the case of the options."""
EXAMPLE = (
    "vibroimpact identify --impact-times 0 .01258873 .03434483 --impact-sides LLR --frequency 19.5 "
    "--mass 2.7 --stiffness 42000 --free-mass .11 --load-amplitude 6 --xi .01143 --restitution .75 .65 "
    "--fixed xi R1 R2 -o results"
)
#: The initial guesses of a fit, if the options do not give them.
START = {"xi": 0.01, "mu": 0.05, "restitution": [0.7]}


def arguments(parser: argparse.ArgumentParser) -> None:
    """The records, and the options of a case."""
    parser.add_argument(
        "files", nargs="*", metavar="RECORD",
        help="records, all of one rig, or namelist files or earlier results instead of options",
    )  # fmt: skip
    for name, option in options_of("identify").items():
        parser.add_argument(f"--{name}", **option.how())
    add_forms(parser)


def is_case(file: str) -> bool:
    """Whether a file is a namelist or an earlier result, and not a record."""
    if file.endswith(".nml"):
        return True
    if not file.endswith(".csv"):
        return False
    with contextlib.suppress(OSError), open(file, encoding="utf-8", errors="replace") as lines:
        return lines.readline().startswith("# ! vibroimpact")
    return False


def request(options: argparse.Namespace) -> Request:
    """The case of the options, with the records among the files."""
    known = options_of("identify")
    cases = [*filter(is_case, options.files)]
    records = [file for file in options.files if file not in cases]
    if cases and records:
        raise ParameterError(f"{records[0]}: must be left out if a case is given: {cases[0]}")
    if cases:
        return request_of(options, "identify", known)
    options.files = []
    for name, value in START.items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    if records:
        options.records = [*records, *(options.records or [])]
    return request_of(options, "identify", known)


def run(options: argparse.Namespace) -> int:
    """Identify."""
    from .cases import run_kind

    return run_kind(options, request(options))
