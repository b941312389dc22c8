"""The allowed contents of messages from the page; anything else is rejected before it is acted on."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ..base.errors import ParameterError
from .limits import shown

__all__ = ["checked"]

#: Largest number of characters of a text in a message, and of fields that one message sets.
MOST_TEXT, MOST_FIELDS = 2000, 40


def _number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _text(value: Any) -> bool:
    return isinstance(value, str) and len(value) <= MOST_TEXT


def _place(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) == 2 and all(map(_number, value))


def _fields(value: Any) -> bool:
    if not isinstance(value, dict) or len(value) > MOST_FIELDS:
        return False
    return all(_text(name) and _text(word) for name, word in value.items())


#: A kind of value: the function that recognises it, and its name in messages.
Kind = tuple[Callable[[Any], bool], str]
NUMBER: Kind = _number, "a finite number"
PLACE: Kind = _place, "two finite numbers"
FIELDS: Kind = (
    _fields, f"texts of at most {MOST_FIELDS} fields, each of at most {MOST_TEXT} characters"
)  # fmt: skip
CHOICE: Kind = (lambda value: value is None or _text(value)), "null or a text"
SIGN: Kind = (lambda value: isinstance(value, bool)), "true or false"
FORM: Kind = (lambda value: _text(value) and value in ("namelist", "python")), "namelist or python"
_POINT = {"r": NUMBER, "clearance": NUMBER}
#: For each kind of message, its parts besides the kind and the number.
PARTS: dict[str, dict[str, Kind]] = {
    "ready": {},
    "set": {"words": FIELDS},
    "point": _POINT,
    "step": {"right": NUMBER, "up": NUMBER},
    "peek": _POINT,
    "unpeek": {},
    "choose": {"motion": CHOICE},
    "run": {"words": FIELDS},
    "launch": {"y": NUMBER, "y_dot": NUMBER},
    "stop": {},
    "line": {"from": PLACE, "to": PLACE},
    "through": {"across": SIGN},
    "erase": {},
    "drag": _POINT,
    "export": {"form": FORM},
}


def checked(message: Any) -> dict[str, Any]:
    """A checked message from the page; a ParameterError names the part that is not allowed.

    Examples
    --------
    >>> from vibroimpact.explorer.messages import checked
    >>> checked({"kind": "point", "number": 1, "r": 1.04, "clearance": 25})["r"]
    1.04
    >>> checked({"kind": "point", "number": 1, "r": float("inf"), "clearance": 25})
    Traceback (most recent call last):
    vibroimpact.ParameterError: message 'point', r = 'inf': must be a finite number
    """
    kind = message.get("kind") if isinstance(message, dict) else None
    parts = PARTS.get(kind) if isinstance(kind, str) else None
    if parts is None:
        raise ParameterError(f"message {shown(str(kind))}: must be one of {', '.join(PARTS)}")
    for name, (allowed, words) in {"number": NUMBER, **parts}.items():
        if name not in message:
            raise ParameterError(f"message {kind!r}, {name}: is missing; must be {words}")
        if not allowed(message[name]):
            raise ParameterError(
                f"message {kind!r}, {name} = {shown(str(message[name]))}: must be {words}"
            )
    found: dict[str, Any] = message
    return found
