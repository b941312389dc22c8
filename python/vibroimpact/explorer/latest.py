"""Work in a thread of which only the newest piece matters."""

from __future__ import annotations

import threading
from collections.abc import Callable

__all__ = ["Latest"]

#: Told to a job, so that it can end early: whether it still is the newest.
Current = Callable[[], bool]


class Latest:
    """Runs the newest job; one that is handed in while another runs takes the place of any that waits.

    Examples
    --------
    >>> import threading
    >>> from vibroimpact.explorer.latest import Latest
    >>> worker, begun, go, done = Latest(), threading.Event(), threading.Event(), threading.Event()
    >>> ran = []
    >>> worker.submit(lambda current: (begun.set(), go.wait(), ran.append(("first", current()))))
    >>> _ = begun.wait()
    >>> worker.submit(lambda current: ran.append("never"))
    >>> worker.submit(lambda current: (ran.append(("last", current())), done.set()))
    >>> go.set()
    >>> _ = done.wait()
    >>> ran
    [('first', False), ('last', True)]
    """

    def __init__(self) -> None:
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
        # a daemon: Ctrl-C does not wait for it
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        while True:
            with self.lock:
                job, mine, self.waiting = self.waiting, self.number, None
                if job is None:
                    self.running = False
                    return
            try:
                job(lambda number=mine: self.number == number)  # type: ignore[misc]
            except BaseException:
                with self.lock:
                    self.running = False
                raise
