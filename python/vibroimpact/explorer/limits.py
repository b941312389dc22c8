"""Limits on the requests of a page: computations in threads are abandoned after some seconds."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

from ..base.errors import VibroimpactError
from ..base.interrupt import interruptible
from .latest import Stale, ending

__all__ = ["Limit", "Places", "Progress", "TooLong", "shown", "watched"]

Found = TypeVar("Found")
Progress = Callable[..., None]

#: Seconds after which a computation that a page waits for is abandoned.
SECONDS = 5.0
#: Largest number of characters of a link's text that a message repeats.
MOST_SHOWN = 80


class TooLong(VibroimpactError):  # noqa: N818 (a limit, not an error)
    """A computation for a page was abandoned after some seconds."""


class Limit:
    """Runs the computations that a page waits for, with a time limit for each.

    Examples
    --------
    >>> import time
    >>> from vibroimpact.explorer.limits import Limit
    >>> limit = Limit(0.2)
    >>> limit(lambda progress: "done")
    'done'
    >>> limit(lambda progress: time.sleep(1))
    Traceback (most recent call last):
    vibroimpact.explorer.limits.TooLong: given up after 0.2 s
    """

    def __init__(self, seconds: float | None = None) -> None:
        self.seconds = SECONDS if seconds is None else seconds
        self.closed = threading.Event()

    def close(self) -> None:
        """The page has been closed: stop the computations for it."""
        self.closed.set()

    def __call__(self, function: Callable[..., Found], *arguments: Any) -> Found:
        """The result of a function, which also receives the keyword `progress`, a callback whose exception ends
        the function.

        The caller does not wait beyond the limit, even if the function does not call `progress`.
        """
        deadline = time.monotonic() + self.seconds

        def progress(*_: object) -> None:
            if self.closed.is_set() or ending():
                raise Stale
            if time.monotonic() > deadline:
                raise TooLong(f"given up after {self.seconds:g} s")

        return watched(progress, function, *arguments)


class Places:
    """Counts open pages, up to a maximum number.

    Examples
    --------
    >>> from vibroimpact.explorer.limits import Places
    >>> places = Places(1)
    >>> places.enter(), places.enter()
    (True, False)
    >>> places.leave()
    >>> places.enter()
    True
    """

    def __init__(self, most: int) -> None:
        self.most, self.taken = most, 0
        self.lock = threading.Lock()

    def enter(self) -> bool:
        """Take a place; returns False if there is none."""
        with self.lock:
            free = self.taken < self.most
            self.taken += free
            return free

    def leave(self) -> None:
        """Free a place."""
        with self.lock:
            self.taken -= 1


def watched(progress: Progress, function: Callable[..., Found], *arguments: Any) -> Found:
    """The result of a function that takes `progress`; an exception of `progress` ends the wait for it at once."""
    found: Found = interruptible(partial(function, *arguments, progress=progress), watch=progress)
    return found


def shown(text: str) -> str:
    """A text from a link, quoted for a message; only the beginning of a long text.

    Examples
    --------
    >>> from vibroimpact.explorer.limits import shown
    >>> shown("RL/2"), shown("1" * 5000)[-22:]
    ("'RL/2'", "11…' (5000 characters)")
    """
    if len(text) <= MOST_SHOWN:
        return repr(text)
    return f"{text[:MOST_SHOWN] + '…'!r} ({len(text)} characters)"
