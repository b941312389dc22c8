"""What went wrong in a computation: the core's status codes, in words and as exceptions."""

from __future__ import annotations

import functools

from . import _core
from .errors import SingularError

__all__ = ["status_text"]

#: What the core's verdicts mean: 1, 0, and -1 for "not computed".
VERDICT = {1: True, 0: False, -1: None}
#: Codes that more than words follow from; those of the core's vi_status.
NO_MOTION, MORE_EVENTS, NOT_COMPUTED = 7, 8, 12


@functools.cache
def status_text(code: int) -> str:
    """What a status code of the core means."""
    text, length = _core.status_text(code)
    return text[:length].tobytes().decode()


def raise_status(code: int) -> None:
    """Raise SingularError unless the code says that all went well."""
    if code:
        raise SingularError(status_text(code))
