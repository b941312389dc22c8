"""`vibroimpact reproduce`: the tables and figures of the 1983 paper."""

from __future__ import annotations

import argparse
import textwrap
from pathlib import Path

from ..reproduce import NAMES, reproduce
from ..reproduce.tasks import ON_REQUEST, TASKS
from . import Fresh, add_folder

DESCRIPTION = textwrap.fill(
    "Recompute the tables and figures of Popplewell, Bapat and McLachlan (1983) and compare them with the printed "
    f"values. Available: {', '.join(NAMES)}. {' and '.join(ON_REQUEST)} (the zone of Figure 6a, proven, "
    "three minutes) is computed only if it is named. Figures 1, 2 and 5 show the model, the notation and the rig; "
    "they contain nothing to compute.", 92,
)  # fmt: skip
EXAMPLE = "vibroimpact reproduce table1 -o results"


def arguments(parser: argparse.ArgumentParser) -> None:
    """Names and folder."""
    parser.add_argument("names", nargs="*", metavar="NAME", help="what to recompute (default: all)")
    add_folder(parser)


def run(options: argparse.Namespace) -> int:
    """Recompute the named tables and figures."""
    folder = Path(options.folder)
    written = Fresh(folder / output for task in TASKS.values() for output in task.outputs)
    try:
        return reproduce(options.names, folder)
    finally:
        options.record.files += map(str, written.paths())
