"""`vibroimpact zone`: where the motions of a pattern are stable and admissible."""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

from ..files import write_bytes
from ..progress import Progress
from . import picture_writer
from .options import add_case, add_window, run_cases, window_groups
from .run import tell

HELP = "find where the motions of a pattern are stable"
DESCRIPTION = """Find the zones of the plane (r, d K/F0) in which a pattern has stable, admissible motions, for the
&zone cases of namelist files or for the one that the options name. The boundaries are written to
DIR/NAME.csv, one row a vertex with the type of its piece, or to DIR/NAME.json; with --plot a
picture stands beside them. NAME is "zone" for the case of the options."""
EXAMPLE = (
    "vibroimpact zone --xi .0114 --mu .028 --restitution .75 --sides RL --r 0.8 1.2 --clearance 2 200 "
    "-o results"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a pattern and a window; and the form of the results."""
    add_case(parser)
    parser.add_argument(
        "--symmetric", choices=("yes", "no", "both"),
        help="only motions that are their own mirror image, only others, or both (default)",
    )  # fmt: skip
    add_window(parser, guesses=12)


def run(options: argparse.Namespace) -> int:
    """Find the zones, write and draw them."""
    save = picture_writer() if options.plot else None
    groups = window_groups(options, "zone", ("sides", "cycles", "symmetric"))
    needed = ("xi", "mu", "restitution", "sides", "r", "clearance")
    folder = Path(options.folder)
    with tempfile.TemporaryDirectory() as place, Progress("zone") as bar:
        tables = place if options.format == "json" else options.folder
        log, cases = run_cases(
            options, "zone", groups, needed, tables, bar.show if bar.wanted else None
        )
    tell(log)
    for case in cases:
        if save is None and options.format == "csv":
            break
        with Progress(case.name) as bar:
            found = case.zone(bar.show)
        if options.format == "json":
            folder.mkdir(parents=True, exist_ok=True)
            write_bytes(folder / f"{case.name}.json", json.dumps(found.to_dict()).encode())
        if save is not None:
            print(f"{case.name}: {save(found.plot(), folder / f'{case.name}.{options.plot}')}")
    return log.status
