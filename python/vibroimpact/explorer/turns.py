"""The thread of a page: all changes of its state run there, one after the other."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable

from .latest import Stale, ending

__all__ = ["Turns"]

#: Most functions that may wait when another one is offered: a page sends its next message when the last one is
#: answered.
MOST_WAITING = 100


class Turns:
    """Runs functions one after another in a thread that exists as long as functions are waiting.

    The event loop, which serves all pages, never waits for this thread.

    Examples
    --------
    >>> import threading
    >>> from vibroimpact.explorer.turns import Turns
    >>> turns, done, ran = Turns(), threading.Event(), []
    >>> for i in range(3):
    ...     turns.submit(lambda i=i: ran.append(i))
    >>> turns.submit(done.set)
    >>> done.wait(10), ran
    (True, [0, 1, 2])
    """

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.waiting: deque[Callable[[], object]] = deque()
        self.running = self.closed = False

    def submit(self, work: Callable[[], object]) -> None:
        """Run a function after the waiting ones; a closed page runs none."""
        with self.lock:
            if self.closed:
                return
            self.waiting.append(work)
            if self.running:
                return
            self.running = True
        # no daemon, as in `Latest`
        threading.Thread(target=self._run).start()

    def offer(self, work: Callable[[], object]) -> None:
        """Run a function after the waiting ones, or discard it if too many wait."""
        if len(self.waiting) < MOST_WAITING:
            self.submit(work)

    def close(self) -> None:
        """Discard the waiting functions."""
        with self.lock:
            self.closed = True
            self.waiting.clear()

    def _run(self) -> None:
        while True:
            with self.lock:
                if not self.waiting or ending():
                    self.running = False
                    return
                work = self.waiting.popleft()
            try:
                work()
            except Stale:
                pass  # the page has been closed in the meantime
            except Exception as error:
                logging.getLogger(__name__).error("internal error of the explorer", exc_info=error)
