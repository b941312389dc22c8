"""`vibroimpact prove`: certificates of the motions, branches and zones of namelist files."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, SingularError, VibroimpactError
from ..base.progress import Progress
from ..cases.case import Case
from ..proofs.balls import exact, flint
from ..proofs.form import VERDICTS
from . import PICTURES, add_files, add_folder, picture_writer, ready
from .request import Request, read_cases

DESCRIPTION = """Prove properties of the motions, branches and zones of namelist files in ball arithmetic:
that each motion exists, touches no wall in between, and is stable or not. Each certificate is
written to DIR/NAME_proof.json (NAME_1_proof, NAME_2_proof if a case has several motions or
branches), which vibroimpact.load reads and tests/proof/check_certificate.py checks without
vibroimpact.
Undecided properties are printed with the reason; if nothing is decided, the exit status is 1.
It needs the extra `proof`: pip install 'vibroimpact[proof]'."""
EXAMPLE = "vibroimpact init exact && vibroimpact prove exact.nml -o results"

#: The studies whose results can be proven.
STUDIES = ("motion", "branch", "zone")
#: The studies whose proofs have a smallest box, with the limits of its size.
IN_BOXES = {"branch": ("1e-13", "1"), "zone": ("1e-5", "0.1")}
#: Number of reasons that are printed for a certificate, which may have hundreds.
SHOWN = 5


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder, and the smallest box."""
    add_files(parser)
    add_folder(parser)
    parser.add_argument(
        "--tolerance", type=float, metavar="V",
        help="smallest box, relative to the branch (1e-13 to 1; default: 1e-4) or to the window of the zone "
        "(1e-5 to 0.1; default: 0.004)",
    )  # fmt: skip
    # `name_file` reads an option `plot` as that of a command that writes tables
    parser.add_argument(
        "--plot", dest="picture", nargs="?", const=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"also draw what is proven of zones, as png, svg or pdf (default: {PICTURES[0]})",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Prove all cases of all files; nothing is computed if any case cannot have a proof."""
    flint()
    save = picture_writer() if options.picture else None
    cases, faults = read_cases(options, Request())
    for line in faults:
        options.record.fault(line)
    for case in cases:
        check(case, options.tolerance)
    status = 2 if faults else 0
    with ready(Path(options.folder)) if cases else contextlib.nullcontext():
        for case in cases:
            status = max(status, finish(options, case, save))
    return status


def check(case: Case, tolerance: float | None) -> None:
    """Raises an error, before anything is computed, if a case cannot have a proof."""
    if case.study not in STUDIES:
        allowed = ", ".join(f"&{study}" for study in STUDIES)
        raise ParameterError(f"{case.name}: &{case.study}: must be one of {allowed} for a proof")
    if case.structure is not None and case.study not in ("motion", "branch"):
        raise ParameterError(
            f"{case.name}: &structure: must be a &system for the proof of a &{case.study}"
        )
    if tolerance is None:
        return
    if case.study not in IN_BOXES:
        raise ParameterError(
            f"--tolerance {tolerance:g}: must be left out for {case.name}, a &motion, whose proof has one box"
        )
    least, most = IN_BOXES[case.study]
    if not float(least) <= tolerance <= float(most):
        raise ParameterError(
            f"--tolerance {tolerance:g}: must be from {least} to {most} for {case.name}, a &{case.study}"
        )


def finish(options: argparse.Namespace, case: Case, save: Any) -> int:
    """Compute a case, prove its results, report what is proven and write the certificates."""
    status, record = 0, options.record
    with Progress(case.name) as bar:
        try:
            results = case.run(bar.show)
        except VibroimpactError as error:
            record.fault(f"{case.name}: {error}")
            return max(1 if isinstance(error, SingularError) else error.status, status)
    if not results:
        record.fault(f"{case.name}: there is no motion, branch or zone to prove")
        return 1
    for i, result in enumerate(results, start=1):
        name = case.name if len(results) == 1 else f"{case.name}_{i}"
        with Progress(name) as bar:
            given: dict[str, Any] = {"progress": bar.show} if case.study in IN_BOXES else {}
            if options.tolerance is not None:
                given["tolerance"] = options.tolerance
            try:
                proof = result.prove(**given)
            except VibroimpactError as error:
                record.fault(f"{name}: {error}")
                status = max(status, error.status)
                continue
        status = max(status, deliver(options, name, proof, save))
    return status


def deliver(options: argparse.Namespace, name: str, proof: Any, save: Any) -> int:
    """Report what is proven; write and draw it."""
    print(f"{name}: {proof!r}")
    for gap in proof.undecided[:SHOWN]:
        print(f"{name}: not decided: {told(gap)}")
    if len(proof.undecided) > SHOWN:
        print(f"{name}: {len(proof.undecided) - SHOWN} more gaps are in the certificate")
    folder = Path(options.folder)
    path = folder / f"{name}_proof.json"
    proof.save(path)
    options.record.wrote(name, path)
    options.record.add(name, proof)
    if save is not None and proof.kind == "zone":
        drawn = folder / f"{name}_proof.{options.picture}"
        options.record.wrote(name, save(proof.plot(), drawn))
    decided = any(box[verdict] is not None for box in proof.boxes for verdict in VERDICTS)
    return 0 if decided else 1


def told(gap: dict[str, Any]) -> str:
    """A reason, with the parameters for which it holds."""
    spans = [
        f"{name} {float(exact(low)):.10g} to {float(exact(high)):.10g}"
        for name, (low, high) in gap.get("parameters", {}).items()
    ]
    reason: str = gap["reason"]
    return ": ".join([*filter(None, [", ".join(spans)]), reason])
