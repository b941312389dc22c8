"""`vibroimpact init`: a commented namelist to start from."""

from __future__ import annotations

import argparse
import shlex
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError
from ..base.files import write_text
from ..cases import case
from ..results.namelist import Groups
from ..results.tables import keys_for
from . import STUDIES
from .options import takes

DESCRIPTION = """Write NAME.nml, a namelist of one kind of case in which every key is explained and which can
be run unchanged. An existing file is not overwritten."""
EXAMPLE = "vibroimpact init zone"

#: For each kind of &motion, a description and the keys of the example; the commands have both for studies.
SYSTEM = {"xi": 0.005, "mu": 0.042, "restitution": 0.75, "r": 0.94}
PHASES = {"sides": "RL", "phases_over_pi": [0, 1.37]}
MOTIONS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "periodic": ("compute the motion whose impacts have given load phases", PHASES),
    "equispaced": (
        "compute the symmetric motions of two impacts half a period apart",
        {"clearance": 37},
    ),
    "exact": (
        "compute an exact motion from approximate phases",
        {"clearance": 37, **PHASES},
    ),
}
#: For each template of a structure, a description and the groups of the example.
STRUCTURES: Mapping[str, tuple[str, Sequence[tuple[str, Mapping[str, Any]]]]] = {
    "structure": (
        "simulate a structure with gaps from an initial state",
        (
            ("structure", {"mass": [1, 0.1], "damping": [0.02, 0], "stiffness": [1, 0]}),
            ("gap", {"direction": [-1, 1], "opening": 0.5, "restitution": 0.8}),
            ("gap", {"direction": [1, -1], "opening": 0.5, "restitution": 0.8}),
            ("load", {"frequency": 1.04, "sine": [0.1, 0]}),
            ("simulate", {"cycles": 50}),
        ),
    ),
    "stops": (
        "simulate a structure with an elastic stop and dry friction from an initial state",
        (
            ("structure", {"mass": [1], "damping": [0.1], "stiffness": [1]}),
            ("stop", {"direction": [1], "opening": 0.5, "stiffness": 20, "damping": 2}),
            ("friction", {"direction": [1], "slip": 0.1}),
            ("load", {"frequency": 1.3, "cosine": [1]}),
            ("simulate", {"cycles": 50}),
        ),
    ),
}
#: The beginning and the end of a file.
HEAD = """! {title}.
! Run it:   vibroimpact run {file} -o results     (or, without Python, vibroimpact-batch)
! Draw it:  vibroimpact plot {file} -o results
! {units}. A line that is commented out shows a default after =; after a colon it
! describes a key that has no default or cannot be combined with the keys above.
"""
UNITS = "Lengths are in F0/K, time in 1/omega, angles in radians"
OWN_UNITS = "Units are your own, consistent ones"


def kinds() -> tuple[str, ...]:
    """The kinds of cases of an oscillator, and the templates of structures."""
    return (*case.kinds(structures=False), *STRUCTURES)


def example(kind: str) -> tuple[str, Groups]:
    """The description of a kind of case, and the groups of the example of its command."""
    if kind in MOTIONS:
        title, keys = MOTIONS[kind]
        return title, {"system": SYSTEM, "motion": {"kind": kind, **keys}}
    from .command import module_of, parser_of

    module = module_of(kind)
    options = parser_of(kind).parse_args(shlex.split(module.EXAMPLE)[2:])
    return STUDIES[kind], module.request(options).groups


def template(kind: str, file: str) -> str:
    """The template of a namelist."""
    title, units = title_of(kind), OWN_UNITS if kind in STRUCTURES else UNITS
    groups = STRUCTURES[kind][1] if kind in STRUCTURES else [*example(kind)[1].items()]
    lines = [HEAD.format(title=title[0].upper() + title[1:], file=file, units=units)]
    explained: set[str] = set()
    for group, values in [*groups, ("output", {})]:
        given = {name: value for name, value in values.items() if value is not None}
        keys = [f"  {name} = {shown(value)}" for name, value in given.items()]
        known = keys_for(group, kind in STRUCTURES)
        lines += [f"&{group}", *(keys if group in explained else key_lines(known, given)), "/\n"]
        explained.add(group)
    return "\n".join(lines).rstrip("\n") + "\n"


def title_of(kind: str) -> str:
    """The title of a template."""
    return STRUCTURES[kind][0] if kind in STRUCTURES else example(kind)[0]


def key_lines(keys: Sequence[Mapping[str, Any]], given: Mapping[str, Any]) -> Iterator[str]:
    """Each key of a group with its meaning, and with its value or commented out with its default.

    The name of a key is followed by a colon if it has no default or cannot be combined with the given keys.
    """
    known = {key["name"]: key["default"] for key in keys} | {
        name: shown(x) for name, x in given.items()
    }

    def holds(condition: str) -> bool:
        name, equals, word = condition.partition("=")
        return known[name].strip("'") == word if equals else name in given

    for key in keys:
        name = key["name"]
        about = takes(key)
        wrong = (
            (key["only"] and not holds(key["only"])) or any(map(holds, key["never"].split()))
            or key["or"] in given or any(name in x for x in given.values() if isinstance(x, list))
        )  # fmt: skip
        if name in given:
            line = f"  {name} = {known[name]}"
            about += [f"default: {key['default']}"] * bool(key["default"])
        elif name == "r" and "xi" in known:  # keys of &system that the case does not need
            continue
        else:
            plain = key["default"] and not wrong
            line = f"  ! {name} = {key['default']}" if plain else f"  ! {name}:"
        text = key["meaning"] + (f" ({'; '.join(about)})" if about else "")
        yield textwrap.fill(
            text, 110, initial_indent=f"{line:<34} ! ", subsequent_indent=f"{'':<34} !   ",
            break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip


def shown(value: Any) -> str:
    """A value as a user would write it."""
    if isinstance(value, list):
        return ", ".join(map(shown, value))
    return repr(value) if isinstance(value, str) else f"{value:g}"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The kind and the file, or --list."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        choices=kinds(),
        help="a kind of case (see --list)",
    )
    parser.add_argument("-o", dest="file", metavar="FILE.nml", help="the file (default: NAME.nml)")
    parser.add_argument("--list", action="store_true", help="describe the kinds of cases")
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")


def run(options: argparse.Namespace) -> int:
    """Write the template, or list the kinds."""
    if options.list:
        for name in kinds():
            title = title_of(name)
            print(f"{name:<12} {title}")
            options.record.add(name, title)
        return 0
    if options.name is None:
        raise ParameterError(f"NAME: must be given, one of {', '.join(kinds())}; or --list")
    path = Path(options.file or f"{options.name}.nml")
    if path.exists() and not options.force:
        raise ParameterError(f"{path}: already exists; must be another file, or --force")
    if not path.parent.is_dir():
        raise ParameterError(
            f"-o {path}: there is no folder {path.parent}; must be in an existing folder"
        )
    write_text(path, template(options.name, str(path)))
    options.record.files.append(str(path))
    print(f"{path}: run it by `vibroimpact run {path} -o results`")
    return 0
