"""The core's status codes, in words and as exceptions."""

from __future__ import annotations

import functools

from .. import _core
from . import checks
from .errors import SingularError

__all__ = ["status_text"]

#: The core's verdicts: 1, 0, and -1 for "not computed".
VERDICT = {1: True, 0: False, -1: None}
#: Codes of the core's vi_status that are handled specially.
NO_MOTION, MORE_EVENTS, NOT_COMPUTED, DEFECTIVE, GAP_CLOSED = 7, 8, 12, 17, 20
SHORTER_PERIOD, SYMMETRIC = 31, 32
EVENT_LIMIT, NARROW_GAP = 13, 37
GRAZE, NO_DERIVATIVE = 26, 42


def status_text(code: int) -> str:
    """The meaning of a status code of the core.

    Parameters
    ----------
    code : int
        A number from the `status` of a result.

    Returns
    -------
    str
        A sentence; 0 means success.

    Raises
    ------
    ParameterError, ParameterTypeError
        If the code is not a whole number of 32 bits.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> vi.status_text(10)
    'the iteration did not converge; a closer guess may help'
    """
    return sentence(checks.integer(code, "code", -(2**31), 2**31 - 1))


@functools.cache
def sentence(code: int) -> str:
    """The meaning of a status code."""
    text, length = _core.status_text(code)
    return text[:length].tobytes().decode()


def raise_status(code: int) -> None:
    """Raise SingularError unless the code means success."""
    if code:
        raise SingularError(status_text(code))
