"""Work in a thread of which only the newest piece matters."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from functools import partial

__all__ = ["Current", "Latest", "Stale"]

#: Told to a job, so that it can end early: whether it still is the newest, and the interpreter does not end.
Current = Callable[[], bool]


class Stale(Exception):  # noqa: N818 (no error)
    """Raised by a job that ends early since a newer one waits."""


class Latest:
    """Runs the newest job; one that is handed in while another runs takes the place of any that waits.

    Parameters
    ----------
    failed : callable
        Told what a job raises, as long as it is the newest.
    niceness : int
        How much the jobs give way to others, where a thread can have a priority of its own (Linux).

    Examples
    --------
    >>> import threading
    >>> from vibroimpact.explorer.latest import Latest
    >>> begun, go, done, ran = threading.Event(), threading.Event(), threading.Event(), []
    >>> worker = Latest(lambda error: (ran.append(repr(error)), done.set()))
    >>> worker.submit(lambda current: (begun.set(), go.wait(), ran.append(("first", current()))))
    >>> _ = begun.wait()
    >>> worker.submit(lambda current: ran.append("never"))
    >>> worker.submit(lambda current: (ran.append(("last", current())), 1 / 0))
    >>> go.set()
    >>> _ = done.wait()
    >>> ran
    [('first', False), ('last', True), "ZeroDivisionError('division by zero')"]
    """

    def __init__(self, failed: Callable[[Exception], object], niceness: int = 0) -> None:
        self.failed, self.niceness = failed, niceness
        self.lock = threading.Lock()
        self.number = 0
        self.waiting: Callable[[Current], object] | None = None
        self.running = False

    def submit(self, job: Callable[[Current], object]) -> None:
        """Run a job as soon as the one that runs is done."""
        with self.lock:
            self.number += 1
            self.waiting = job
            if self.running:
                return
            self.running = True
        # no daemon: one that an ending interpreter stops within C++, as numpy has, aborts the process
        threading.Thread(target=self._run).start()

    def drop(self) -> None:
        """The job that waits, if any, is not wanted any more, and the one that runs is told so."""
        with self.lock:
            self.number += 1
            self.waiting = None

    def _run(self) -> None:
        if sys.platform == "linux":  # elsewhere it would be the whole process
            os.nice(self.niceness)
        while True:
            with self.lock:
                job, mine, self.waiting = self.waiting, self.number, None
                if job is None or _ending():
                    self.running = False
                    return
            current = partial(self._newest, mine)
            try:
                job(current)
            except Stale:
                pass
            except Exception as error:
                if current():
                    self.failed(error)

    def _newest(self, number: int) -> bool:
        return self.number == number and not _ending()


def _ending() -> bool:
    """Whether the interpreter ends, and waits for its threads."""
    return not threading.main_thread().is_alive()
