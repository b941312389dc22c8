"""The options of a study's command: the keys that the core declares, with their meaning, range and default."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from ..base import checks
from ..base.errors import ParameterError
from ..results.tables import keys_for, language
from ..systems.units import NAMED, QUANTITY, with_u

#: The placeholder of a value in the help, by the end of the name of its key.
ENDS = {"min": "LOW", "max": "HIGH", "points": "N", "axes": "NAME"}
#: The help text of an option, in place of the meanings of its keys.
TEXTS = {"state": "displacement and velocity of the primary mass, then of the free mass"}


class Option(NamedTuple):
    """An option with the keys that it sets, each with its group; with several keys, each takes one word."""

    name: str
    keys: list[tuple[str, Mapping[str, Any]]]

    @property
    def metavars(self) -> tuple[str, ...]:
        """The placeholder of each value in the help."""
        return tuple(metavar(key, len(self.keys) > 1) for _, key in self.keys)

    def typed(self, options: argparse.Namespace) -> Any:
        """The words as typed; None if the option was not given."""
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
        if isinstance(word, str) and is_quantity(word):
            return word
        try:
            value = checks.read_number(word) if isinstance(word, str) else float(word)
        except ValueError as error:
            if "precision" in str(error):
                raise ParameterError(f"--{self.name} {shown(words)}: {error}") from None
            wanted = " ".join(self.metavars * key["most"])
            raise ParameterError(
                f"--{self.name} {shown(words)}: must be {wanted}; {typed(word)} is not a number"
            ) from None
        return int(value) if key["kind"] == "whole" and value.is_integer() else value

    def in_words(self, text: str, which: str) -> str:
        """A text in which the keys are replaced by the placeholders of the help."""
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
        arguments: dict[str, Any] = {"help": explained(self), "metavar": self.metavars[0]}
        if len(self.keys) > 1:
            return arguments | {
                "nargs": len(self.keys) * key["most"],
                "type": str.strip,
                "metavar": self.metavars * key["most"],
            }
        many = {} if key["most"] == 1 else {"nargs": "+"}
        if key["words"]:
            return arguments | many | {"choices": key["words"].split(), "metavar": None}
        return arguments | many | {"type": TYPES[key["kind"]]}


def quantity(text: str) -> float | str:
    """The value of an option for a number, or for a text with a unit, which the namelist accepts unchanged."""
    return text.strip() if is_quantity(text) else number(text)


def is_quantity(text: str) -> bool:
    """Whether a text is a number with a unit: the unit follows a blank or is known; "1e400" is not such a text."""
    found = QUANTITY.fullmatch(with_u(text))
    if found is None or re.match("[eE][-+]?[0-9]", found[2]):
        return False
    first = re.match("(?:1/)?([A-Za-z%]+)", found[2])
    return first is not None and (first[1] in NAMED or found[1] + " " in text)


def number(text: str) -> float:
    """The value of an option for a number."""
    try:
        return checks.read_number(text)
    except ValueError as error:
        message = str(error) if "must be" in str(error) else f"{typed(text)}: must be a number"
        raise argparse.ArgumentTypeError(message) from None


#: The type of a value, by the kind of its key.
TYPES: Mapping[str, Callable[[str], Any]] = {"number": quantity, "whole": int, "word": str}


def metavar(key: Mapping[str, Any], with_others: bool) -> str:
    """The placeholder of the value of a key."""
    name: str = key["name"]
    if with_others:
        plain = "N" if key["kind"] == "whole" else name.upper()
        return ENDS.get(name.rpartition("_")[2], plain)
    return {"number": "V", "whole": "N", "word": name.upper()}[key["kind"]]


def explained(option: Option) -> str:
    """The help text: meaning, unit, range and default."""
    keys = [key for _, key in option.keys]
    about = unit_and_range(keys[0], option.metavars[0]) if len(keys) == 1 else []
    defaults = dict.fromkeys(key["default"].strip("'") for key in keys if key["default"])
    about += [f"default: {', '.join(defaults)}"] * bool(defaults)
    text = TEXTS.get(option.name) or ", ".join(key["meaning"] for key in keys)
    return (text + (f" ({'; '.join(about)})" if about else "")).replace("%", "%%")


def unit_and_range(key: Mapping[str, Any], word: str) -> list[str]:
    """Unit and range, as far as there are any; `word` is the placeholder of the value."""
    found = re.match(r"a (?:whole )?number with ([^,]*)", key["takes"])
    unit = [f"in {key['unit']}"] * (key["unit"] != "")
    return unit + ([re.sub(rf"\b{key['name']}\b", word, found[1])] if found else [])


def takes(key: Mapping[str, Any]) -> list[str]:
    """Unit and range, the allowed words, or the core's other description of the value."""
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
    # studies that find the frequency ratio themselves, or do not need it, have no --r
    takes_r = language()["results"][study]["takes_r"]
    keys = [("system", key) for key in keys_for("system") if takes_r or key["name"] != "r"]
    keys += [
        (group, key) for group in before for key in keys_for(group) if key["name"] in before[group]
    ]
    keys += [(study, key) for key in keys_for(study)]
    # a study's own keys replace keys of &system of the same name; those that need a replaced one are left out
    own = {name_of(key) for key in keys_for(study)}
    own |= {name_of(key) for key in keys_for("system") if key["only"].replace("_", "-") in own}
    found: dict[str, Option] = {}
    for group, key in keys:
        name = name_of(key)
        if name != "-" and not (group == "system" and name in own):
            found.setdefault(name, Option(name, [])).keys.append((group, key))
            if key["name"] == "axes":  # a list of values, in place of the option for its ends
                found["axes"] = Option("axes", [(group, key)])
    return found


def name_of(key: Mapping[str, Any]) -> str:
    """Name of the option that sets a key."""
    name: str = key["option"] or key["name"].replace("_", "-")
    return name


def shown(words: Sequence[Any]) -> str:
    """The words of an option, as they could be typed."""
    return " ".join(f"{word:g}" if isinstance(word, float) else typed(word) for word in words)


def typed(word: Any) -> str:
    """A word as it could be typed; an empty one in quotes."""
    return str(word).strip() or "''"
