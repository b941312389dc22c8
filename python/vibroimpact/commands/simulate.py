"""`vibroimpact simulate`: the simulations of namelist files, with pictures."""

from __future__ import annotations

import argparse

from ..run import read_namelist, run_namelists
from . import PICTURES, add_files, add_folder, picture_writer
from .run import tell

HELP = "run the simulations of namelist files"
DESCRIPTION = """Run the &simulate cases of namelist files: the events of each are written to
DIR/NAME.csv, with the same digits as `vibroimpact run` gives, and with --plot a picture of its last
load cycles beside it."""
EXAMPLE = "vibroimpact simulate inputs/figure9.nml --plot -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, folder and the format of pictures."""
    add_files(parser)
    add_folder(parser)
    parser.add_argument(
        "--plot", nargs="?", const=PICTURES[0], choices=PICTURES, metavar="FORMAT",
        help=f"draw each trajectory, as {', '.join(PICTURES)} (default: {PICTURES[0]})",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Run the simulations and draw them from their results, which are inputs too."""
    save = picture_writer() if options.plot else None
    log = run_namelists(options.files, options.folder, only="simulate")
    tell(log)
    if save is None:
        return log.status
    for path in log.results:
        (case,) = read_namelist(path)
        picture = path.with_name(f"{case.name}.{options.plot}")
        print(f"{case.name}: {save(case.trajectory().plot(), picture)}")
    return log.status
