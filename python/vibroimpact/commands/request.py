"""The cases that a command has to run: the cases of files, or the case that its options define.

The case that the options define is written as a namelist and read like any other case.
"""

from __future__ import annotations

import argparse
import contextlib
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from ..base.errors import ParameterError
from ..cases.case import Case, read_namelist
from ..results import namelist
from ..results.namelist import Groups
from ..systems.units import checked_names
from .options import Option, shown

#: The message on a missing option.
MISSING = "must be given, or a namelist file instead of the options"


class Request(NamedTuple):
    """The case that a command runs if it is given options and no files.

    Attributes
    ----------
    kind : str or None
        The kind of cases that the command runs, and the name of the result; None for all kinds.
    groups
        The namelist made from the options.
    known
        The options.
    """

    kind: str | None = None
    groups: Groups = MappingProxyType({})
    known: Sequence[Option] = ()


def request_of(
    options: argparse.Namespace, study: str, known: Mapping[str, Option], **more: Mapping[str, Any]
) -> Request:
    """The case that the options define, with further keys of its groups."""
    groups: dict[str, dict[str, Any]] = {"system": {}, **{group: {} for group in more}, study: {}}
    wanted = getattr(options, "units", None)
    for option in known.values():
        if option.name == "units" and (options.files or wanted == "dimensionless"):
            continue  # the units of the results, see `in_units`
        if options.files and option.typed(options) is not None:
            raise ParameterError(beside_files(option.name, options.files))
        for group, name, value in option.values(options):
            groups[group][name] = value
    for group, keys in more.items():
        groups[group] |= keys
    if wanted == "dimensionless" and "mass" in groups["system"]:
        groups["system"]["units"] = wanted  # of numbers without a unit
    return Request(study, groups, [*known.values()])


def beside_files(name: str, files: Sequence[str]) -> str:
    """The message about an option that is given together with namelist files."""
    for file in files:
        with contextlib.suppress(ValueError):
            float(file)
            if not Path(file).exists():
                return (
                    f"{file} is one value too many for the option before it: options take the number of "
                    "values that --help shows, and anything else is the name of a namelist file"
                )
    return f"--{name}: must be left out if a namelist file is given"


def read_cases(options: argparse.Namespace, request: Request) -> tuple[list[Case], list[str]]:
    """The requested cases, not yet run, and the errors in files.

    A file with an error is skipped. An error in the options is raised, in terms of the options.
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
    units = getattr(options, "units", None)
    return [in_units(case, units) for case in cases.values()], faults


def in_units(case: Case, units: str | None) -> Case:
    """A case whose results are in the units that --units names."""
    if units is None:
        return case
    if units != "dimensionless":
        units = checked_names(units, "--units")
        if case.missing_units:
            raise ParameterError(
                f"--units {units!r}: must be left out for {case.name}, whose {case.missing_units}"
            )
    text = namelist.shown_in(case.text, units)
    return case._replace(keys=case.keys | {"units": units}, text=text)


def _cases_of(file: str, kind: str | None, others: Mapping[str, Case]) -> list[Case]:
    """The cases of one kind (or all) of a file; their names must differ from those of all other cases."""
    found = [case for case in read_namelist(file) if kind in (None, case.kind)]
    if not found:
        raise ParameterError(f"{file}: must contain a group &{kind}; there is none")
    taken = set(others)
    for case in found:
        if case.name.lower() in taken:
            raise ParameterError(
                f"{file}: &output name = {case.name!r}: is already the name of another case; must be another"
            )
        taken.add(case.name.lower())
    return found


@contextmanager
def case_files(
    options: argparse.Namespace, request: Request
) -> Iterator[tuple[Sequence[str], str]]:
    """The files to run, and the file made from the options ("" if there are files)."""
    if options.files:
        yield options.files, ""
        return
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / f"{request.kind}.nml"
        made.write_text(namelist.text(request.groups), encoding="utf-8")
        yield [str(made)], str(made)


def in_options(line: str, made: str, request: Request, options: argparse.Namespace) -> str:
    """A message in terms of options, without the name of the temporary namelist, which the user does not know."""
    line = re.sub(rf"^{re.escape(made)}(:\d+)?: ", "", line)
    match = re.match(r"&(\w+) (\w+)\S*(?: = (.*?))?: (.*)", line)
    owners: dict[tuple[str, str], Option] = {}
    # of two options for a key, the one that was typed, otherwise the first
    for option in sorted(request.known, key=lambda option: option.typed(options) is None):
        for group, key in option.keys:
            owners.setdefault((group, key["name"]), option)
    owner = owners.get((match[1], match[2])) if match else None
    if match is None or owner is None:
        return line
    typed = owner.typed(options)
    value = shown(typed) if isinstance(typed, list) else match[3]
    text = re.sub("^is missing; ", f"{MISSING}; it ", match[4])
    if len(owner.keys) > 1:  # the range is that of one of its values
        text = re.sub("^must be a number with ", "must have ", text)
    for other in request.known:
        text = other.in_words(text, "" if other == owner else f" of --{other.name}")

    def flag(found: re.Match[str]) -> str:
        """Another key, with its value if it has one, as an option."""
        other = owners.get((match[1], found[2]))
        word = (found[3] or "").replace("'", "")
        return f"{found[1]} --{other.name}{word}" if other else found[0]

    text = re.sub(r"(left out if|requires|or give) (\w+)(?: =( \S+))?", flag, text)
    return f"--{owner.name}{f' {value}' if value else ''}: {text}"
