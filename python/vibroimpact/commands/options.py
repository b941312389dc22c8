"""A case from options instead of a namelist file: it is written as one and read like any other."""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import ParameterError
from ..interchange import namelist
from ..interchange.namelist import Groups
from ..run import Case, RunLog, read_namelist, run_namelists
from . import add_files, add_forms

#: Options that give two keys each.
SPANS = {
    "r_min": "r", "r_max": "r", "clearance_min": "clearance", "clearance_max": "clearance",
    "low": "bounds", "high": "bounds",
    "r_points": "r", "clearance_points": "clearance",
}  # fmt: skip


def add_case(parser: argparse.ArgumentParser, with_pattern: bool = True) -> None:
    """Files, or the options that all cases have; the folder, and the forms of the results."""
    add_files(parser, "*")
    parser.add_argument("--xi", type=float, metavar="XI", help="damping ratio")
    parser.add_argument("--mu", type=float, metavar="MU", help="mass ratio")
    parser.add_argument(
        "--restitution", type=float, nargs="+", metavar="R",
        help="coefficient of restitution of both walls, or of the right one and the left one",
    )  # fmt: skip
    if with_pattern:
        parser.add_argument(
            "--sides", metavar="SIDES", help="walls of the impacts in order, as RRL"
        )
        parser.add_argument(
            "--cycles", type=int, metavar="K", help="load cycles a period (default: 1)"
        )
    add_forms(parser)


def add_window(parser: argparse.ArgumentParser, guesses: int) -> None:
    """The window of a zone or an atlas, and how it is searched."""
    for name, wanted in (("r", "frequency ratios"), ("clearance", "d K/F0")):
        parser.add_argument(
            f"--{name}", type=float, nargs=2, metavar=("LOW", "HIGH"), help=f"the window: {wanted}"
        )
    for name, wanted in (
        ("lines", "lattice lines each way (default: 17)"),
        (
            "guesses",
            f"guesses for motions at a node, a quarter at every other one (default: {guesses})",
        ),
        ("max-points", "most vertices of a loop (default: 20000)"),
    ):
        parser.add_argument(f"--{name}", type=int, metavar="N", help=wanted)


def window_groups(options: argparse.Namespace, group: str, own: Sequence[str]) -> Groups:
    """The namelist of a zone or an atlas with some keys of its own."""
    r, clearance = pair(options, "r"), pair(options, "clearance")
    return {
        "system": {name: getattr(options, name) for name in ("xi", "mu", "restitution")},
        group: {
            "r_min": r[0], "r_max": r[1], "clearance_min": clearance[0], "clearance_max": clearance[1],
            **{name: getattr(options, name) for name in (*own, "lines", "guesses", "max_points")},
        },
    }  # fmt: skip


def run_cases(
    options: argparse.Namespace,
    kind: str | None,
    groups: Groups,
    needed: Sequence[str],
    folder: str | Path,
    progress: Callable[[float], None] | None = None,
) -> RunLog:
    """Run the cases of one kind of the files (or of all), or the one that the options name.

    Parameters
    ----------
    options
        As `add_case` and the command have them.
    kind : str
        The kind of cases, and the name of the result where options name the case.
    groups
        The namelist that the options make.
    needed
        Options without which they make none.
    folder
        For the results.
    progress
        As of `run_namelists`.

    Returns
    -------
    RunLog
    """
    with _files(options, kind, groups, needed) as (files, made):
        log = run_namelists(files, folder, only=kind, progress=progress)
    if made and log.status == 2 and not log.results:
        raise ParameterError("\n".join(_anonymous(line, made) for _, line in log.lines))
    return log


def read_cases(
    options: argparse.Namespace, kind: str | None, groups: Groups, needed: Sequence[str]
) -> list[Case]:
    """The cases of one kind of the files (or all), or the one that the options name, without running them."""
    cases: dict[str, Case] = {}
    with _files(options, kind, groups, needed) as (files, made):
        for file in files:
            try:
                found = [case for case in read_namelist(file) if kind in (None, case.kind)]
            except ParameterError as error:
                raise ParameterError(_anonymous(str(error), made)) from None
            if not found:
                raise ParameterError(f"{file}: must hold a group &{kind}; there is none")
            for case in found:
                if case.name.lower() in cases:
                    raise ParameterError(
                        f"{file}: &output name = {case.name!r}: is already the name of another case; must be "
                        "another"
                    )
                cases[case.name.lower()] = case
    return list(cases.values())


def _anonymous(line: str, made: str) -> str:
    """A message in terms of options, without the namelist that they were written to, which nobody knows."""
    if not made:
        return line
    line = re.sub(rf"^{re.escape(made)}(:\d+)?: ", "", line)
    return re.sub(r"^&\w+ (\w+)\S*( = (.*?))?(?=: )", lambda m: _option(m[1], m[3]), line)


def _option(key: str, value: str | None) -> str:
    """An option as it may have been typed, for the key of a namelist."""
    return f"--{_word(SPANS.get(key, key))}" + ("" if value is None else f" {value}")


@contextmanager
def _files(
    options: argparse.Namespace, kind: str | None, groups: Groups, needed: Sequence[str]
) -> Iterator[tuple[list[str], str]]:
    """The files to run, and the one that is made of the options."""
    apart = (
        "command", "files", "folder", "plot", "animate", "format", "quiet", "json", "record", "stem",
    )  # fmt: skip
    given = [
        name for name, value in vars(options).items() if value is not None and name not in apart
    ]
    if options.files:
        if given:
            raise ParameterError(f"--{_word(given[0])}: must be left out beside a namelist file")
        yield options.files, ""
        return
    for name in needed:
        if name not in given:
            raise ParameterError(
                f"--{_word(name)}: must be given, or a namelist file instead of the options"
            )
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / f"{kind}.nml"
        made.write_text(namelist.text(groups), encoding="utf-8")
        yield [str(made)], str(made)


def pair(options: argparse.Namespace, name: str) -> tuple[float | None, float | None]:
    """The lower and the upper end that an option gives, in this order; without it two times None."""
    ends = getattr(options, name)
    if ends is None:
        return None, None
    low, high = ends
    if low >= high:
        raise ParameterError(f"--{name} {low:g} {high:g}: must be LOW HIGH with LOW below HIGH")
    return low, high


def grid(options: argparse.Namespace, name: str) -> dict[str, Any]:
    """The keys of one axis of a grid, from LOW HIGH N."""
    words = getattr(options, name)
    if words is None:
        return {}
    try:
        low, high, n = float(words[0]), float(words[1]), int(words[2])
        if low >= high or n < 2:
            raise ValueError
    except ValueError:
        raise ParameterError(
            f"--{name} {' '.join(words)}: must be LOW HIGH N with LOW below HIGH, N at least 2"
        ) from None
    return {f"{name}_min": low, f"{name}_max": high, f"{name}_points": n}


def _word(name: str) -> str:
    return name.replace("_", "-")
