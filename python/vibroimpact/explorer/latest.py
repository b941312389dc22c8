"""Jobs in a thread, of which only the newest one matters."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from functools import partial

__all__ = ["Current", "Latest", "Stale", "ending"]

#: The argument of a job, which lets it end early: whether it is still the newest job and the interpreter is still
#: running.
Current = Callable[[], bool]


class Stale(Exception):  # noqa: N818 (not an error)
    """Raised by a job that ends early because a newer one waits."""


class Latest:
    """Runs the newest job; a job submitted while another one runs replaces the waiting job.

    Parameters
    ----------
    failed : callable
        Called with the exception of a job, if this job is still the newest.
    niceness : int
        Niceness of the jobs, on systems where a thread can have its own priority (Linux).

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
        """Run a job as soon as the running one is done."""
        with self.lock:
            self.number += 1
            self.waiting = job
            if self.running:
                return
            self.running = True
        # no daemon: if the interpreter, at its end, stops a daemon within C++ code, as in numpy, the process
        # aborts
        threading.Thread(target=self._run).start()

    def drop(self) -> None:
        """Discard the waiting job, if any, and tell the running one that its result is no longer needed."""
        with self.lock:
            self.number += 1
            self.waiting = None

    def _run(self) -> None:
        if sys.platform == "linux":  # on other systems this would change the whole process
            os.nice(self.niceness)
        while True:
            with self.lock:
                job, mine, self.waiting = self.waiting, self.number, None
                if job is None or ending():
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
        return self.number == number and not ending()


def ending() -> bool:
    """Whether the interpreter is ending and waits for its threads."""
    return not threading.main_thread().is_alive()
