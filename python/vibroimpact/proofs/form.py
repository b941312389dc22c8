"""Checks of a certificate read from a file: the type of every item, and every text an exact number."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

from ..base.errors import ParameterError, ParameterTypeError
from .balls import HEX, exact

__all__ = ["check_form"]

#: The items of the JSON, with their types.
ITEMS = {
    "kind": str, "sides": str, "cycles": int, "symmetric": bool, "system": dict, "sheets": list,
    "boxes": list, "undecided": list, "seconds": float,
}  # fmt: skip
KINDS = ("motion", "branch", "box", "zone", "all")
VERDICTS = ("exists", "admissible", "stable")
#: Bounds, each with the verdict that it requires, and its range.
BOUNDS = {
    "multipliers_below": ("stable", True, (0, 1)),
    "multipliers_above": ("stable", False, (1, math.inf)),
    "attenuation_below": ("admissible", True, (0, math.inf)),
}
#: Texts of the parameters of an oscillator; a structure has matrices.
TEXTS = ("xi", "mu", "r", "clearance", "load", "restitution")
#: Decimal numbers and fractions, with exponents too small to exhaust memory.
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d{1,4})?|-?\d+/0*[1-9]\d*")
LONGEST_POWER = 6


def check_form(data: dict[str, Any]) -> None:
    """Raise ParameterError or ParameterTypeError for the first invalid item of a certificate.

    Parameters
    ----------
    data : dict
        As returned by `Certificate.to_dict`.
    """
    for name, kind in ITEMS.items():
        value = data.get(name)
        whole = kind is float and type(value) is int
        if not whole and (not isinstance(value, kind) or isinstance(value, bool) != (kind is bool)):
            raise ParameterTypeError(f"{name} = {value!r:.80}: must be of type {kind.__name__}")
    wanted("kind", data["kind"], f"one of {', '.join(KINDS)}", data["kind"] in KINDS)
    wanted("cycles", data["cycles"], "at least 1", data["cycles"] > 0)
    wanted("seconds", data["seconds"], "a time in seconds", 0 <= data["seconds"] < math.inf)
    system, sheets = data["system"], data["sheets"]
    if "mass" in system:
        wanted("system", system, "that of a structure, with a frequency", "frequency" in system)
        numbers("system['frequency']", [system["frequency"]])
    else:
        for name in TEXTS:
            values = system.get(name)
            many = name == "restitution" or (data["kind"] == "zone" and name in ("r", "clearance"))
            numbers(f"system[{name!r}]", values if many else [values])
    for k, sheet in enumerate(sheets):
        if data["kind"] == "all":
            good = isinstance(sheet, dict) and isinstance(sheet.get("sides"), str)
            wanted(
                f"sheets[{k}]", sheet, "a dict with sides and cycles", good and "cycles" in sheet
            )
        else:
            intervals(f"sheets[{k}]", sheet)
    for k, box in enumerate(data["boxes"]):
        check_box(f"boxes[{k}]", box, len(sheets))
        bounds = sorted(set(BOUNDS).intersection(box)) if data["kind"] == "zone" else []
        # lengths of zones are in other units
        wanted(f"boxes[{k}]", bounds, "without bounds in a zone", not bounds)
    for k, item in enumerate(data["undecided"]):
        good = isinstance(item, dict) and isinstance(item.get("reason"), str)
        wanted(f"undecided[{k}]", item, "a dict with a reason", good)
        intervals(f"undecided[{k}]['parameters']", item.get("parameters", {}))


def check_box(label: str, box: Any, sheets: int) -> None:
    """Check a box in the same way."""
    wanted(label, box, "a dict", isinstance(box, dict))
    place = box.get("sheet")
    good = type(place) is int and 0 <= place < sheets
    wanted(f"{label}['sheet']", place, "the number of a sheet", good)
    intervals(f"{label}['parameters']", box.get("parameters"))
    for name in VERDICTS:
        value = box.get(name)
        good = name in box and (value is None or isinstance(value, bool))
        wanted(f"{label}[{name!r}]", value, "True, False or None", good)
    for name, (verdict, value, allowed) in BOUNDS.items():
        if box.get(name) is not None:
            numbers(f"{label}[{name!r}]", [box[name]])
            good = box[verdict] is value and allowed[0] <= exact(box[name]) <= allowed[1]
            range_ = f"from {allowed[0]} to {allowed[1]}, with {verdict} = {value}"
            wanted(f"{label}[{name!r}]", box[name], range_, good)
    for name, depth in (("centre", 2), ("radius", 1)):
        if name in box:
            texts: Any = [box[name]]
            for _ in range(1 + depth):
                good = all(isinstance(one, list) for one in texts)
                wanted(f"{label}[{name!r}]", box[name], "lists of exact numbers", good)
                texts = [one for row in texts for one in row]
            numbers(f"{label}[{name!r}]", texts)


def intervals(label: str, spans: Any) -> None:
    """Check intervals of parameters."""
    good = isinstance(spans, dict) and all(
        isinstance(ends, list) and len(ends) == 2 for ends in spans.values()
    )
    wanted(label, spans, "a dict of (lowest, highest)", good)
    for name, ends in spans.items():
        numbers(f"{label}[{name!r}]", ends)


def numbers(label: str, texts: Any) -> None:
    """Check texts of exact numbers."""
    for text in texts if isinstance(texts, Iterable) else [texts]:
        good = False
        if isinstance(text, str):
            found = HEX.fullmatch(text)
            good = bool(NUMBER.fullmatch(text) if found is None else len(found[3]) <= LONGEST_POWER)
            good = good and is_double(text)
        wanted(label, text, "the text of an exact number", good)


def is_double(text: str) -> bool:
    """Whether a double can stand for an exact number, which has neither too many digits nor too large a value."""
    try:
        float(exact(text))
    except (ValueError, OverflowError):
        return False
    return True


def wanted(label: str, value: Any, allowed: str, good: bool) -> None:
    """Raise ParameterError unless a value is good."""
    if not good:
        raise ParameterError(f"{label} = {value!r:.80}: must be {allowed}")
