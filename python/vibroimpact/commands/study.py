"""The commands of the studies: the keys that the core declares are their options.

The options make a case, which is written as a namelist and read like any other.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from ..case import Case, read_namelist
from ..errors import ParameterError
from ..interchange import namelist
from ..interchange.namelist import Groups
from ..tables import language
from . import add_files, add_forms

#: What stands in the help for a value, by the end of the name of its key.
ENDS = {"min": "LOW", "max": "HIGH", "points": "N", "axes": "NAME"}
#: What the help says of an option in place of the meanings of its keys.
TEXTS = {"state": "displacement and velocity of the primary mass, then of the free mass"}
#: The type of a value, by the kind of its key.
TYPES: Mapping[str, Callable[[str], Any]] = {"number": float, "whole": int, "word": str}


class Option(NamedTuple):
    """An option with the keys that it gives, each with its group; of several keys each takes a word."""

    name: str
    keys: list[tuple[str, Mapping[str, Any]]]

    @property
    def metavars(self) -> tuple[str, ...]:
        """What stands for each value."""
        return tuple(metavar(key, len(self.keys) > 1) for _, key in self.keys)

    def typed(self, options: argparse.Namespace) -> Any:
        """What was typed; None if the option was not given."""
        return getattr(options, self.name.replace("-", "_"))

    def values(self, options: argparse.Namespace) -> Iterator[tuple[str, str, Any]]:
        """Group, key and value of each key, if the option was given."""
        words = self.typed(options)
        for i, (group, key) in enumerate(self.keys if words is not None else ()):
            if len(self.keys) == 1:
                yield group, key["name"], words
                return
            own = [self.value(words, word, key) for word in words[i :: len(self.keys)]]
            yield group, key["name"], own[0] if key["most"] == 1 else own

    def value(self, words: Sequence[Any], word: Any, key: Mapping[str, Any]) -> Any:
        """One of several words as the value of a key."""
        if key["kind"] == "word":
            return word
        try:
            value = float(word)
        except ValueError:
            wanted = " ".join(self.metavars * key["most"])
            raise ParameterError(
                f"--{self.name} {shown(words)}: must be {wanted}; {word} is not a number"
            ) from None
        return int(value) if key["kind"] == "whole" and value.is_integer() else value

    def in_words(self, text: str, which: str) -> str:
        """A text in which the values of several keys are called what the help calls them."""
        several = zip(self.keys, self.metavars, strict=True) if len(self.keys) > 1 else ()
        for (_, key), word in several:
            if "_" in key["name"] and word != key["name"].upper():
                text = re.sub(rf"\b{key['name']}\b", word + which, text)
            elif not which:
                text = re.sub(rf"(?<=<= ){key['name']}\b", word, text)
        return text

    def how(self) -> dict[str, Any]:
        """The arguments of `add_argument`."""
        key = self.keys[0][1]
        told: dict[str, Any] = {"help": explained(self), "metavar": self.metavars[0]}
        if len(self.keys) > 1:
            return told | {
                "nargs": len(self.keys) * key["most"],
                "type": str.strip,
                "metavar": self.metavars * key["most"],
            }
        if key["words"]:
            return told | {"choices": key["words"].split(), "metavar": None}
        many = {} if key["most"] == 1 else {"nargs": "+"}
        return told | many | {"type": TYPES[key["kind"]]}


def metavar(key: Mapping[str, Any], with_others: bool) -> str:
    """What stands for the value of a key."""
    name: str = key["name"]
    if with_others:
        plain = "N" if key["kind"] == "whole" else name.upper()
        return ENDS.get(name.rpartition("_")[2], plain)
    return {"number": "V", "whole": "N", "word": name.upper()}[key["kind"]]


def explained(option: Option) -> str:
    """Meaning, unit, range and default."""
    keys = [key for _, key in option.keys]
    about = unit_and_range(keys[0], option.metavars[0]) if len(keys) == 1 else []
    defaults = dict.fromkeys(key["default"].strip("'") for key in keys if key["default"])
    about += [f"default: {', '.join(defaults)}"] * bool(defaults)
    text = TEXTS.get(option.name) or ", ".join(key["meaning"] for key in keys)
    return (text + (f" ({'; '.join(about)})" if about else "")).replace("%", "%%")


def unit_and_range(key: Mapping[str, Any], word: str) -> list[str]:
    """What there is of them; `word` stands for the value."""
    found = re.match(r"a (?:whole )?number with ([^,]*)", key["takes"])
    unit = [f"in {key['unit']}"] * (key["unit"] != "")
    return unit + ([re.sub(rf"\b{key['name']}\b", word, found[1])] if found else [])


def takes(key: Mapping[str, Any]) -> list[str]:
    """Unit and range, the words that it takes, or what else the core says of it."""
    about = unit_and_range(key, key["name"])
    if key["words"]:
        about.append(", ".join(map(repr, key["words"].split())))
    elif not re.match("a (whole |finite )?number( with|$)", key["takes"]):
        about.append(re.sub(r", and \w+ below \w+$", "", key["takes"]))
    return about


def options_of(
    study: str, before: Mapping[str, Sequence[str]] = MappingProxyType({})
) -> dict[str, Option]:
    """The options of a study by name: of &system, of some keys of groups before its own, and of its own."""
    groups = language()["groups"]
    keys = [("system", key) for key in groups["system"]]
    keys += [
        (group, key) for group in before for key in groups[group] if key["name"] in before[group]
    ]
    keys += [(study, key) for key in groups[study]]
    own = {name_of(key) for key in groups[study]}
    found: dict[str, Option] = {}
    for group, key in keys:
        name = name_of(key)
        if name != "-" and not (group == "system" and name in own):
            found.setdefault(name, Option(name, [])).keys.append((group, key))
    return found


def name_of(key: Mapping[str, Any]) -> str:
    """Name of the option that gives a key."""
    name: str = key["option"] or key["name"].replace("_", "-")
    return name


def add_study(
    parser: argparse.ArgumentParser, known: Mapping[str, Option], **own: Mapping[str, Any]
) -> None:
    """Files, or options; the folder, and the forms of the results. `own` is what the command says of an option."""
    add_files(parser, "*")
    for name, option in known.items():
        parser.add_argument(f"--{name}", **(option.how() | dict(own.get(name, {}))))
    add_forms(parser)


class Request(NamedTuple):
    """What a command asks for if it is given options and no files.

    Attributes
    ----------
    kind : str or None
        The one kind of cases that the command runs, and the name of the result; None for all kinds.
    groups
        The namelist that the options make.
    known
        The options.
    """

    kind: str | None = None
    groups: Groups = MappingProxyType({})
    known: Sequence[Option] = ()


def request_of(
    options: argparse.Namespace, study: str, known: Mapping[str, Option], **more: Mapping[str, Any]
) -> Request:
    """The case that the options name, with more keys of its groups."""
    groups: dict[str, dict[str, Any]] = {"system": {}, **{group: {} for group in more}, study: {}}
    for option in known.values():
        if options.files and option.typed(options) is not None:
            raise ParameterError(f"--{option.name}: must be left out beside a namelist file")
        for group, name, value in option.values(options):
            groups[group][name] = value
    for group, keys in more.items():
        groups[group] |= keys
    return Request(study, groups, [*known.values()])


def command(
    study: str, details: Callable[[Any], list[str]] | None = None, **own: Mapping[str, Any]
) -> tuple[
    Callable[[argparse.ArgumentParser], None],
    Callable[[argparse.Namespace], Request],
    Callable[[argparse.Namespace], int],
]:
    """`arguments`, `request` and `run` of a command whose options are the keys of a study."""

    def arguments(parser: argparse.ArgumentParser) -> None:
        add_study(parser, options_of(study), **own)

    def request(options: argparse.Namespace) -> Request:
        return request_of(options, study, options_of(study))

    def run(options: argparse.Namespace) -> int:
        from .cases import run_kind

        return run_kind(options, request(options), details)

    return arguments, request, run


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


@contextmanager
def case_files(
    options: argparse.Namespace, request: Request
) -> Iterator[tuple[Sequence[str], str]]:
    """The files to run, and the one that is made of the options ("" if there are files)."""
    if options.files:
        yield options.files, ""
        return
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / f"{request.kind}.nml"
        made.write_text(namelist.text(request.groups), encoding="utf-8")
        yield [str(made)], str(made)


def in_options(line: str, made: str, request: Request, options: argparse.Namespace) -> str:
    """A message in terms of options, without the namelist that they were written to, which nobody knows."""
    line = re.sub(rf"^{re.escape(made)}(:\d+)?: ", "", line)
    match = re.match(r"&(\w+) (\w+)\S*(?: = (.*?))?: (.*)", line)
    owners = {
        (group, key["name"]): option for option in request.known for group, key in option.keys
    }
    option = owners.get((match[1], match[2])) if match else None
    if match is None or option is None:
        return line
    typed = option.typed(options)
    value = shown(typed) if isinstance(typed, list) else match[3]
    told = re.sub("^is missing; ", f"{MISSING}; it ", match[4])
    for other in request.known:
        told = other.in_words(told, "" if other == option else f" of --{other.name}")

    def flag(found: re.Match[str]) -> str:
        """Another key, with its word if it has one, as an option."""
        other = owners.get((match[1], found[2]))
        word = (found[3] or "").replace("'", "")
        return f"{found[1]} --{other.name}{word}" if other else found[0]

    told = re.sub(r"(beside|goes with|is for|or give) (\w+)(?: =( \S+))?", flag, told)
    return f"--{option.name}{f' {value}' if value else ''}: {told}"


#: What is said of an option that is missing.
MISSING = "must be given, or a namelist file instead of the options"


def shown(words: Sequence[Any]) -> str:
    """The words of an option as they may have been typed."""
    return " ".join(f"{word:g}" if isinstance(word, float) else str(word) for word in words)
