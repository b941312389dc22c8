"""Long calls of the core that can be interrupted by Ctrl-C."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Seconds between two checks of whether the call is done; an interrupt in between takes effect at once.
INTERVAL = 0.05
#: Bytes of the stack of a thread that runs the core, whatever `ulimit -s` and `threading.stack_size` are.
STACK = 8 * 2**20
#: The value of the stop flag that also makes the core abandon the file it is writing, `give_up_file` in vi_batch.
GIVE_UP = 4
#: In a thread that runs a call: `event` is set when its caller no longer waits for it.
_HERE = threading.local()


class _Call(NamedTuple):
    """A call in its own thread."""

    #: Set when the call has ended, with a result or an exception in these lists.
    done: threading.Event
    answer: list[Any]
    fault: list[BaseException]
    #: Set when no caller waits for it any longer.
    abandoned: threading.Event


class AbandonedError(BaseException):
    """Raised in a call whose result is no longer awaited."""


def interruptible(
    function: Callable[..., Any], *arguments: Any, watch: Callable[[], None] | None = None
) -> Any:
    """The result of a function of the core, during whose execution the main thread can react to Ctrl-C.

    Meanwhile `watch`, if given, is called a few times per second. After an interrupt or an exception of `watch`
    the result is discarded. If the function calls `stoppable` with `progress`, this stops the core; otherwise the
    core continues in a thread that ends with the program.
    """
    if watch is None and threading.current_thread() is not threading.main_thread():
        return function(*arguments)
    call = _started(function, *arguments)
    try:
        return _finished(call, watch)
    except BaseException:
        call.abandoned.set()
        raise


def stoppable(
    function: Callable[..., Any], *arguments: Any, counters: NDArray[np.int32],
    progress: Callable[[float, str], None] | None = None, note: str = "", writes: bool = False,
) -> tuple[Any, bool]:  # fmt: skip
    """The result of a function of the core, and whether it ran to its end.

    The last argument of the function contains three progress counters: work done, work known so far, and a stop
    flag. Ctrl-C sets the flag; the core then stops within a few load cycles and returns the part that was
    finished. A second Ctrl-C ends the wait at once; a function that `writes` files gives up its file first, as it
    does at the first Ctrl-C if it is writing by then. `progress` is called a few times per second with the
    fraction done and the note; an exception of `progress` also stops the core, and is raised again.
    """
    if progress is None and threading.current_thread() is not threading.main_thread():
        return function(*arguments, counters), True

    share = 0.0
    above = getattr(_HERE, "abandoned", None)

    def watch() -> None:
        nonlocal share
        if above is not None and above.is_set():
            raise AbandonedError
        # the known work can grow
        share = max(share, float(counters[0] / max(1, counters[1])))
        if progress is not None:
            progress(share, note)

    call = _started(function, *arguments, counters)
    try:
        try:
            return _finished(call, watch), True
        except KeyboardInterrupt:
            if counters[2] < 0:  # the core reads, maybe from a pipe whose end never comes
                writes = False
                raise
            counters[2] = GIVE_UP if counters[2] else 1
            return _finished(call, None), False
    except BaseException:
        counters[2] = GIVE_UP
        while writes and not call.done.wait(INTERVAL):
            pass
        raise


def with_stack(function: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a function of the core that needs more stack than the caller's thread may have.

    Some functions need 100 kB, and a thread may have only 64 kB; the stack of the main thread is large enough.
    """
    if threading.current_thread() is threading.main_thread() or hasattr(_HERE, "abandoned"):
        return function(*arguments)
    return _finished(_started(function, *arguments), None)


def new_counters() -> NDArray[np.int32]:
    """Progress counters for the core: no work done, no work known, no request to stop."""
    return np.zeros(3, dtype=np.int32)


class _Worker:
    """A thread that runs calls one after another; in a new thread for each, OpenMP would start all its threads
    again."""

    idle: ClassVar[list[_Worker]] = []
    #: Held while a thread starts: the stack size is one setting for all threads of the process.
    starting: ClassVar[threading.Lock] = threading.Lock()

    def __init__(self) -> None:
        self.calls: SimpleQueue[Callable[[], None]] = SimpleQueue()
        with _Worker.starting:
            before = threading.stack_size(STACK)
            try:
                threading.Thread(target=self._work, daemon=True).start()
            finally:
                threading.stack_size(before)

    def _work(self) -> None:
        while True:
            self.calls.get()()


def _forget_threads() -> None:
    """In a child process: drop the threads and locks of the parent, which do not exist or are never released
    there."""
    _Worker.idle.clear()
    _Worker.starting = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_threads)


def _started(function: Callable[..., Any], *arguments: Any) -> _Call:
    """Starts a call in its own thread."""
    answer: list[Any] = []
    fault: list[BaseException] = []
    try:
        worker = _Worker.idle.pop()
    except IndexError:
        worker = _Worker()

    def run() -> None:
        _HERE.abandoned = abandoned
        try:
            answer.append(function(*arguments))
        except BaseException as error:
            fault.append(error)
        finally:
            _Worker.idle.append(worker)
            done.set()

    # an event, since a thread whose `join` was interrupted counts as ended (Python before 3.13)
    done, abandoned = threading.Event(), threading.Event()
    worker.calls.put(run)
    return _Call(done, answer, fault, abandoned)


def _finished(call: _Call, watch: Callable[[], None] | None) -> Any:
    """Waits for the result of such a call; meanwhile `watch` is called a few times a second."""
    while not call.done.wait(INTERVAL):
        if watch is not None:
            watch()
    if watch is not None:
        watch()  # the final state of the counters may have been reached after the last check
    if call.fault:
        raise call.fault[0]
    return call.answer[0]
