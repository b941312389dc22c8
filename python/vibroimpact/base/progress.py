"""A progress bar, on a terminal or in a notebook, for computations longer than two seconds."""

from __future__ import annotations

import functools
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, ParamSpec, TypeVar

Given = ParamSpec("Given")
Found = TypeVar("Found")

#: Seconds before the bar appears, and between two updates.
PATIENCE, INTERVAL = 2.0, 0.2
WIDTH = 30


class Progress:
    """A progress bar on standard error, if that is a terminal or a notebook; with `with`, it is removed at the
    end."""

    #: The number of bars in use: calls within another call show no bar of their own.
    active: ClassVar[int] = 0

    def __init__(self, label: str, wanted: bool | None = None, resumed: bool = False) -> None:
        self.label = label
        self.wanted = attended() if wanted is None else wanted
        self.begin = self.last = time.monotonic()
        self.reached = 0.0
        #: The share that was done before the start; that of the first call if an earlier run is resumed.
        self.origin = None if resumed else 0.0
        self.shown = False

    def __enter__(self) -> Progress:
        Progress.active += 1
        return self

    def __exit__(self, *error: object) -> None:
        Progress.active -= 1
        self.clear()

    def clear(self) -> None:
        """Remove the bar until it is drawn again, so that a line can be printed in its place."""
        if self.shown:
            print("\r" + " " * (len(self.label) + WIDTH + 70) + "\r", end="", file=sys.stderr)
            self.shown = False

    def show(self, share: float, note: str = "") -> None:
        """Draw the bar for a share of the work between 0 and 1, with the estimated remaining time.

        If more work becomes known, the share decreases; the remaining time is then estimated again, but the bar
        does not move back.
        """
        now = time.monotonic()
        if self.origin is None:
            self.origin = share
        self.reached = max(self.reached, min(1.0, share))
        if not self.wanted or now - self.begin < PATIENCE or now - self.last < INTERVAL:
            return
        self.last = now
        self.shown = True
        bar = "#" * int(WIDTH * self.reached)
        spent = now - self.begin
        own = share - self.origin
        left = f", about {span(spent * (1 - share) / own)} left" if own > 0 and share < 1 else ""
        print(
            f"\r{self.label} [{bar:<{WIDTH}}] {span(spent)}{left} {note:<30}",
            end="",
            file=sys.stderr,
            flush=True,
        )


def attended() -> bool:
    """Whether the output is visible to a user: on a terminal, or in a notebook."""
    # a kernel has loaded IPython, whose shell then has an attribute `kernel`
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return hasattr(shell, "kernel") or (sys.stderr is not None and sys.stderr.isatty())


@contextmanager
def reported(
    progress: Callable[[float, str], None] | None, label: str
) -> Iterator[Callable[[float, str], None] | None]:
    """Provide the function that receives the progress of a call: the caller's own, or a bar.

    A call within another call, or in a thread other than the main thread, has no bar.
    """
    outer = not Progress.active and threading.current_thread() is threading.main_thread()
    own = progress is None and outer and attended()
    with Progress(label, wanted=own) as bar:
        yield bar.show if own else progress


def with_progress(function: Callable[Given, Found]) -> Callable[Given, Found]:
    """A decorator of a function with the keyword `progress`: without this argument a bar is shown."""

    @functools.wraps(function)
    def shown(*args: Given.args, **kwargs: Given.kwargs) -> Found:
        given: Any = kwargs.get("progress")
        with reported(given, function.__name__) as told:
            kwargs["progress"] = told
            return function(*args, **kwargs)

    return shown


def in_parts(
    size: int, largest: int, progress: Callable[[float, str], None] | None
) -> Iterator[slice]:
    """Parts of 0 to `size`, each of at most `largest`; `progress` is called after each part with the fraction
    done.

    Examples
    --------
    >>> from vibroimpact.base.progress import in_parts
    >>> [(part.start, part.stop) for part in in_parts(10, 4, None)]
    [(0, 4), (4, 8), (8, 10)]
    """
    for first in range(0, size, largest):
        last = min(first + largest, size)
        yield slice(first, last)
        if progress is not None:
            progress(last / size, "")


def span(seconds: float) -> str:
    """A time in seconds, or in hours and minutes."""
    if seconds < 600:
        return f"{seconds:.0f} s"
    hours, minutes = divmod(round(seconds / 60), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
