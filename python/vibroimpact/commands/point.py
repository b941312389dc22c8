"""Options and files that the studies of attractors have in common."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ParameterError, StudyInterrupted
from ..files import write_text
from ..model import Oscillator
from ..progress import Progress
from . import FORMATS, add_forms, picture_writer

#: Values of a line at most.
MOST = 1_000_000


def add_system(parser: argparse.ArgumentParser) -> None:
    """The oscillator, the folder and the forms of the results."""
    for name, wanted in (("xi", "damping ratio"), ("mu", "mass ratio")):
        parser.add_argument(
            f"--{name}", type=float, required=True, metavar=name.upper(), help=wanted
        )
    parser.add_argument(
        "--restitution", type=float, nargs="+", required=True, metavar="R",
        help="coefficient of restitution of both walls, or of the right one and the left one",
    )  # fmt: skip
    add_forms(parser)


def add_range(
    parser: argparse.ArgumentParser, name: str, wanted: str, required: bool = False
) -> None:
    """A number, or LOW HIGH N."""
    parser.add_argument(
        f"--{name}", type=float, nargs="+", required=required, metavar="V",
        help=f"{wanted}: a number, or LOW HIGH N for N of them",
    )  # fmt: skip


def numbers(values: Sequence[float], name: str) -> float | NDArray[np.float64]:
    """What such an option says."""
    if len(values) == 1:
        return values[0]
    if len(values) != 3 or not values[0] < values[1] or values[2] % 1 or not 2 <= values[2] <= MOST:
        raise ParameterError(
            f"--{name} {' '.join(f'{v:g}' for v in values)}: must be a number, or LOW HIGH N with LOW below HIGH, "
            f"N from 2 to {MOST}"
        )
    return np.linspace(values[0], values[1], int(values[2]))


def oscillator(options: argparse.Namespace) -> Oscillator:
    """The system that the options name."""
    walls = options.restitution
    return Oscillator(options.xi, options.mu, walls[0] if len(walls) == 1 else tuple(walls))


def with_bar(
    options: argparse.Namespace, study: Callable[..., Any], *arguments: Any, **more: Any
) -> Any:
    """What a study finds, with a bar if that takes long; after Ctrl-C what it has finished."""
    options.complete = True
    with Progress(options.record.command) as bar:
        try:
            return study(*arguments, **more, progress=bar.show if bar.wanted else None)
        except StudyInterrupted as stop:
            options.complete = False
            return stop.result


def status(options: argparse.Namespace, lost: bool) -> int:
    """The exit status: 1 if something is missing, and then it is said if that is so by Ctrl-C."""
    if not options.complete:
        options.record.fault(
            f"vibroimpact {options.record.command}: interrupted; what was finished is kept"
        )
    return 1 if lost or not options.complete else 0


def write_table(
    options: argparse.Namespace, name: str, columns: Sequence[str], rows: Iterable[Sequence[Any]], result: Any,
) -> None:  # fmt: skip
    """DIR/NAME.csv, numbers with all their digits; or the result in another form."""
    path = Path(options.folder) / f"{options.stem or name}.{FORMATS[options.format]}"
    path.parent.mkdir(parents=True, exist_ok=True)
    if options.format == "csv":
        lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
        write_text(path, "\n".join(lines) + "\n")
    else:
        result.save(path)
    options.record.add(name, result)
    options.record.files.append(str(path))
    print(f"{name}: {path}")


def draw(options: argparse.Namespace, name: str, result: Any, **how: Any) -> None:
    """The picture beside it, if it is wanted."""
    if options.plot:
        save = picture_writer()
        path = save(
            result.plot(**how), Path(options.folder) / f"{options.stem or name}.{options.plot}"
        )
        options.record.files.append(str(path))
        print(f"{name}: {path}")
