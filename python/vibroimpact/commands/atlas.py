"""`vibroimpact atlas`: all zones of a window, found without being told the patterns."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..progress import Progress
from ..studies.atlas import Atlas
from . import picture_writer
from .options import add_case, add_window, read_cases, run_cases, window_groups
from .run import tell

HELP = "find the zones of all patterns in a window"
DESCRIPTION = """Find all zones of the plane (r, d K/F0) in which motions of any pattern, up to a number of impacts
and cycles, are stable and admissible, for the &atlas cases of namelist files or for the one that
the options name. The boundaries are written to DIR/NAME.csv, one row a vertex with the pattern and
the type of its piece, or to DIR/NAME.json; with --plot a picture stands beside them. NAME is
"atlas" for the case of the options. Motions that simulations settle on and that lie in no zone
are listed, and give exit status 1."""
EXAMPLE = (
    "vibroimpact atlas --xi .0114 --mu .028 --restitution .75 --r 1.0 1.1 --clearance 20 60 "
    "--max-impacts 3 --survey 20 -o results"
)
#: Keys of its own, with their meaning and default.
OWN = {
    "max_impacts": "most impacts a period, 2 to 8; an accumulation counts as one (default: 5)",
    "max_cycles": "most load cycles a period, 1 to 4 (default: 1)",
    "survey": "points at which simulations are let settle (default: 400)",
    "settling": "load cycles simulated at each before its motion is looked at (default: 400)",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """Files, or a system, a window and limits; and the form of the results."""
    add_case(parser, with_pattern=False)
    for name, wanted in OWN.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=int, metavar="N", help=wanted)
    add_window(parser, guesses=24)


def run(options: argparse.Namespace) -> int:
    """Find the zones, write and draw them."""
    save = picture_writer() if options.plot else None
    groups = window_groups(options, "atlas", tuple(OWN))
    needed = ("xi", "mu", "restitution", "r", "clearance")
    folder = Path(options.folder)
    status = 0
    if options.format == "csv":
        with Progress("atlas") as bar:
            log, cases = run_cases(
                options, "atlas", groups, needed, folder, bar.show if bar.wanted else None
            )
        tell(log)
        status = log.status
    else:
        cases = read_cases(options, "atlas", groups, needed)
    for case in cases:
        if save is None and options.format == "csv":
            break
        with Progress(case.name) as bar:
            atlas = case.atlas(bar.show)
        if options.format == "json":
            status = max(status, tell_atlas(case.name, atlas))
            if not (atlas.zones or atlas.unexplained):
                continue
            folder.mkdir(parents=True, exist_ok=True)
            atlas.save(folder / f"{case.name}.json")
        if save is not None and atlas.zones:
            print(f"{case.name}: {save(atlas.plot(), folder / f'{case.name}.{options.plot}')}")
    return status


def tell_atlas(name: str, atlas: Atlas) -> int:
    """Print what was found in the words of the compiled program, and give the exit status."""
    faults = [
        f"{zone.pattern.sides}/{zone.pattern.cycles} not closed: a boundary could not be followed until it "
        "closes" for zone in atlas.zones if not zone.closed
    ]  # fmt: skip
    surveyed = counted(len(atlas.attractors), "attractor")
    if atlas.unexplained:
        lost = [f"{item.pattern.sides}/{item.pattern.cycles}" for item in atlas.unexplained]
        faults.append(
            f"{len(lost)} of {surveyed} in no zone of the pattern: {', '.join(dict.fromkeys(lost))}"
        )
    if atlas.zones or faults:
        loops = [len(zone.loops) for zone in atlas.zones if zone]
        print(
            f"{name}: {counted(len(loops), 'zone')}, {counted(sum(loops), 'loop')}, {surveyed} surveyed"
        )
    else:
        faults.append(
            "no zone: neither search nor survey found a stable, admissible motion within the limits in the window"
        )
    for fault in faults:
        print(f"{name}: {fault}", file=sys.stderr)
    return 1 if faults else 0


def counted(number: int, noun: str) -> str:
    """A number of things."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
