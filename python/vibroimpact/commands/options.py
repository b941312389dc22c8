"""A case from options instead of a namelist file: it is written as one and read like any other."""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from ..case import Case, read_namelist
from ..errors import ParameterError
from ..interchange import namelist
from ..interchange.namelist import Groups
from . import add_files, add_forms

#: What every command has, or what is no part of a case.
APART = (
    "command", "files", "folder", "plot", "animate", "format", "quiet", "json", "record", "stem", "quantity",
)  # fmt: skip
#: Values of a line at most.
MOST = 1_000_000
#: What --state gives.
STATE = ("x", "x_dot", "z", "z_dot")
#: Options that give several keys each.
SPANS = {
    f"{name}_{end}": name for name in ("r", "clearance") for end in ("min", "max", "points")
}  # fmt: skip


class Request(NamedTuple):
    """What a command asks for if it is given options and no files.

    Attributes
    ----------
    kind : str or None
        The one kind of cases that the command runs, and the name of the result; None for all kinds.
    groups
        The namelist that the options make.
    needed
        Options without which they make none.
    spans
        The option that each key comes from, if it is not of the same name.
    """

    kind: str | None = None
    groups: Groups = MappingProxyType({})
    needed: Sequence[str] = ()
    spans: Mapping[str, str] = SPANS


def add_case(parser: argparse.ArgumentParser, with_pattern: bool = False) -> None:
    """Files, or the options that all cases have; the folder, and the forms of the results."""
    add_files(parser, "*")
    add_system(parser)
    if with_pattern:
        parser.add_argument(
            "--sides", metavar="SIDES", help="walls of the impacts in order, as RRL"
        )
        parser.add_argument(
            "--cycles", type=int, metavar="K", help="load cycles a period (default: 1)"
        )
    add_forms(parser)


def add_system(parser: argparse.ArgumentParser) -> None:
    """The oscillator."""
    parser.add_argument("--xi", type=float, metavar="XI", help="damping ratio")
    parser.add_argument("--mu", type=float, metavar="MU", help="mass ratio m/M")
    parser.add_argument(
        "--restitution", type=float, nargs="+", metavar="R",
        help="coefficient of restitution of both walls, or of the right one and the left one",
    )  # fmt: skip


def add_numbers(parser: argparse.ArgumentParser, **wanted: str) -> None:
    """Options that are whole numbers, with their meaning."""
    for name, meaning in wanted.items():
        parser.add_argument(f"--{_word(name)}", type=int, metavar="N", help=meaning)


def add_state(parser: argparse.ArgumentParser, what: str) -> None:
    """The initial state."""
    parser.add_argument(
        "--state", type=float, nargs=4, metavar=("X", "X_DOT", "Z", "Z_DOT"),
        help=f"{what}, at t = 0 (default: rest in the middle)",
    )  # fmt: skip


def add_spacing(parser: argparse.ArgumentParser, of: str) -> None:
    """How the values of a line are spaced."""
    parser.add_argument(
        "--spacing", choices=("linear", "geometric"), help=f"spacing of the {of} (default: linear)"
    )


def add_window(parser: argparse.ArgumentParser, guesses: int) -> None:
    """The window of a zone or an atlas, and how it is searched."""
    for name, wanted in (("r", "frequency ratios"), ("clearance", "clearances d K/F0")):
        parser.add_argument(
            f"--{name}", type=float, nargs=2, metavar=("LOW", "HIGH"), help=f"the window: {wanted}"
        )
    add_numbers(
        parser,
        lines="lines of the lattice of the search, each way (default: 17)",
        guesses=f"guesses for motions at every second node, a quarter of it at the others (default: {guesses})",
        max_points="most vertices of a loop (default: 20000)",
    )


def window_groups(options: argparse.Namespace, group: str, own: Sequence[str]) -> Groups:
    """The namelist of a zone or an atlas with some keys of its own."""
    r, clearance = pair(options, "r"), pair(options, "clearance")
    return {
        "system": values(options, "xi", "mu", "restitution"),
        group: {
            "r_min": r[0], "r_max": r[1], "clearance_min": clearance[0], "clearance_max": clearance[1],
            **values(options, *own, "lines", "guesses", "max_points"),
        },
    }  # fmt: skip


def values(options: argparse.Namespace, *names: str) -> dict[str, Any]:
    """Some options by name; None where one was not given."""
    return {name: getattr(options, name) for name in names}


def read_cases(options: argparse.Namespace, request: Request) -> tuple[list[Case], list[str]]:
    """The cases that are asked for, without running them, and what is wrong with files.

    A file with anything wrong is left out. Options with anything wrong are an error in their own words.
    """
    cases: dict[str, Case] = {}
    faults: list[str] = []
    with case_files(options, request) as (files, made):
        for file in files:
            try:
                found = _cases_of(file, request.kind, cases)
            except ParameterError as error:
                if made:
                    raise ParameterError(in_options(str(error), made, request, options)) from None
                faults.append(str(error))
                continue
            cases |= {case.name.lower(): case for case in found}
    return list(cases.values()), faults


def _cases_of(file: str, kind: str | None, others: Mapping[str, Case]) -> list[Case]:
    """The cases of one kind of a file (or all), whose names are those of no others."""
    found = [case for case in read_namelist(file) if kind in (None, case.kind)]
    if not found:
        raise ParameterError(f"{file}: must hold a group &{kind}; there is none")
    taken = set(others)
    for case in found:
        if case.name.lower() in taken:
            raise ParameterError(
                f"{file}: &output name = {case.name!r}: is already the name of another case; must be another"
            )
        taken.add(case.name.lower())
    return found


def in_options(line: str, made: str, request: Request, options: argparse.Namespace) -> str:
    """A message in terms of options, without the namelist that they were written to, which nobody knows."""

    def option(match: re.Match[str]) -> str:
        """The option as it was typed, for the key of a namelist."""
        name = request.spans.get(match[1], match[1])
        typed = shown(getattr(options, name, None) or []) if name != match[1] else match[3]
        return f"--{_word(name)}" + (f" {typed}" if typed else "")

    line = re.sub(rf"^{re.escape(made)}(:\d+)?: ", "", line)
    return re.sub(r"^&\w+ (\w+)\S*( = (.*?))?(?=: )", option, line)


@contextmanager
def case_files(
    options: argparse.Namespace, request: Request
) -> Iterator[tuple[Sequence[str], str]]:
    """The files to run, and the one that is made of the options ("" if there are files)."""
    given = [
        name for name, value in vars(options).items() if value is not None and name not in APART
    ]
    if options.files:
        if given:
            raise ParameterError(f"--{_word(given[0])}: must be left out beside a namelist file")
        yield options.files, ""
        return
    for name in request.needed:
        if name not in given:
            raise ParameterError(
                f"--{_word(name)}: must be given, or a namelist file instead of the options"
            )
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / f"{request.kind}.nml"
        made.write_text(namelist.text(request.groups), encoding="utf-8")
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


def grid(options: argparse.Namespace, name: str, *keys: str) -> dict[str, Any]:
    """The keys of one axis of a grid, from LOW HIGH N; the option must be given if keys are named."""
    words = getattr(options, name)
    if words is None:
        return {}
    return dict(
        zip(
            keys or (f"{name}_min", f"{name}_max", f"{name}_points"), span(words, name), strict=True
        )
    )


def span(words: Sequence[Any], name: str, wanted: str = "LOW HIGH N") -> tuple[float, float, int]:
    """LOW, HIGH and N."""
    try:
        low, high, n = float(words[0]), float(words[1]), float(words[2])
        if len(words) != 3 or not low < high or n % 1 or not 2 <= n <= MOST:
            raise ValueError
    except (ValueError, IndexError):
        raise ParameterError(
            f"--{name} {shown(words)}: must be {wanted} with LOW below HIGH, N from 2 to {MOST}"
        ) from None
    return low, high, int(n)


def shown(words: Sequence[Any]) -> str:
    """The words of an option as they may have been typed."""
    return " ".join(f"{word:g}" if isinstance(word, float) else str(word) for word in words)


def _word(name: str) -> str:
    return name.replace("_", "-")
