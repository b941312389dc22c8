"""Cases as namelists, which `vibroimpact run` and `vibroimpact-batch` read, and their keys."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from itertools import groupby
from typing import Any

import numpy as np

from ..base.errors import ParameterError, ParameterTypeError
from ..base.sizes import check_size
from ..systems.oscillator import Oscillator

#: Namelist groups with their keys; those with the value None are left out.
Groups = Mapping[str, Mapping[str, Any]]
#: How namelists select symmetric motions, all others, or both.
SYMMETRIC = {True: "yes", False: "no", None: "both"}


def text(groups: Groups | Iterable[tuple[str, Mapping[str, Any]]]) -> str:
    """The groups as a namelist; numbers have all their digits. In a list of pairs a name may occur several
    times."""
    lines = []
    for group, keys in groups.items() if isinstance(groups, Mapping) else groups:
        lines += [
            f"&{group}",
            *(f"  {key} = {_value(x)}" for key, x in keys.items() if x is not None),
            "/",
        ]
    return "\n".join(lines) + "\n"


def symmetric_word(value: Any) -> str:
    """How namelists spell the argument `symmetric`."""
    if value is not None and not isinstance(value, (bool, np.bool_)):
        raise ParameterTypeError(f"symmetric = {value!r}: must be None, True or False")
    return SYMMETRIC[None if value is None else bool(value)]


def case(osc: Oscillator, r: float | None = None, **groups: Mapping[str, Any]) -> str:
    """A system and the study that is requested for it, as a namelist."""
    return text({"system": osc._keys(r), **groups})


def _value(value: Any) -> str:
    if isinstance(value, str):
        return "'" + value.replace("'", "''").replace("\n", " ") + "'"
    if not isinstance(value, (list, tuple)):
        return repr(value)
    runs = [(word, len(list(run))) for word, run in groupby(map(repr, value))]
    return ", ".join(
        f"{n}*{word}" if n > 2 and word[0] != "'" else ", ".join([word] * n) for word, n in runs
    )


def shown_in(text: str, units: str) -> str:
    """A case whose table is in other units, such as "mm N s", or "dimensionless"."""
    text = re.sub(r"(?ms)(^&output$.*?)^  units = [^\n]*\n", r"\1", text)
    if re.search(r"(?m)^&output$", text) is None:
        text += "&output\n/\n"
    return re.sub(r"(?m)^&output$", f"&output\n  units = '{units}'", text)


def digits(value: float) -> str:
    """A finite number as the core writes it, with three digits of the exponent."""
    text = f"{value:.16E}"
    return text if text[-4] != "E" else f"{text[:-2]}0{text[-2:]}"


def parts_of(text: str) -> list[tuple[str, dict[str, Any]]]:
    """The groups of a case with one `key = value` a line, in order."""
    groups = re.findall(r"(?ms)^&(\w+)$\n(.*?)^/$", text)
    return [(name, keys_of(body)) for name, body in groups]


def system_keys(text: str) -> dict[str, Any]:
    """The keys of the &system of a case, empty if there is none; a study may have keys of the same names."""
    return dict(parts_of(text)).get("system", {})


def has_structure(text: str) -> bool:
    """Whether a case is that of a structure, by its first group."""
    first = re.search(r"(?m)^&(\w+)$", text)
    return first is not None and first[1] == "structure"


def has_scales(text: str) -> bool:
    """Whether a case is that of a dimensionless structure with physical units."""
    return has_structure(text) and re.search(r"(?m)^  scales = ", text) is not None


def keys_of(text: str) -> dict[str, Any]:
    """The keys of a case with one `key = value` per line, and its kind.

    The kind is that of a &motion, otherwise the name of the group that requests the result; `motion_kind` is the
    kind of a &motion before this group.
    """
    keys: dict[str, Any] = {}
    of_sweep = False
    for line in text.split("\n"):
        name, equals, value = line.strip().partition(" = ")
        if line[:1] == "&":
            of_sweep = name == "&sweep"
        if of_sweep:
            continue
        if line[:1] == "&" and name not in ("&system", "&output"):
            if "kind" in keys:
                keys["motion_kind"] = keys["kind"]
            keys["kind"] = name[1:]
        elif equals:
            try:
                keys[name] = _read(value)
            except ValueError:
                raise ParameterError(
                    f"case: {name} = {value[:60]}: must be a text or numbers"
                ) from None
    return keys


def _read(text: str) -> Any:
    """A text, a number, or a list of texts or numbers."""
    if text.startswith("'"):
        words = text[1:-1].split("', '")
        return words if len(words) > 1 else words[0]
    numbers = [number for item in text.split(", ") for number in _numbers(item)]
    return numbers if len(numbers) > 1 else numbers[0]


def _numbers(text: str) -> list[int | float]:
    """A number, or a repeated one as 3*0.0."""
    times, star, number = text.rpartition("*")
    count = int(times) if star else 1
    check_size(8 * count, 4, f"a list of {count} numbers")
    return [_number(number)] * count


def _number(text: str) -> int | float:
    """A whole number as an int."""
    if "_" in text:  # only Python accepts underscores and the like in a number
        raise ValueError
    try:
        return int(text)
    except ValueError:
        return float(text)
