"""Long calls of the core that Ctrl-C interrupts."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Seconds between two looks at whether the call is done; in between an interrupt is heard at once.
INTERVAL = 0.05


def interruptible(
    function: Callable[..., Any], *arguments: Any, watch: Callable[[], None] | None = None,
    tally: NDArray[np.int32] | None = None,
) -> Any:  # fmt: skip
    """What a function of the core answers, while the main thread stays free to hear Ctrl-C.

    Meanwhile `watch`, if there is one, is called a few times a second. After an interrupt, or what `watch` raises,
    the answer is dropped. The core is told to stop by the tally, if it has one among its arguments; otherwise it
    runs on in a thread that ends with the program.
    """
    if watch is None and threading.current_thread() is not threading.main_thread():
        return function(*arguments)
    call = _started(function, *arguments)
    try:
        return _finished(*call, watch)
    except BaseException:
        if tally is not None:
            tally[2] = 1
        raise


def stoppable(
    function: Callable[..., Any], *arguments: Any, tally: NDArray[np.int32],
    progress: Callable[[float, str], None] | None = None, note: str = "",
) -> tuple[Any, bool]:  # fmt: skip
    """What a function of the core answers, and whether it came to its end.

    Its last argument is a tally of three numbers: work done, work in sight, and whether to stop. Ctrl-C tells the
    core by it to stop, which it does within a few load cycles; its answer then is what was finished. A second
    Ctrl-C does not wait for that. `progress` is called a few times a second with the share done and the note;
    what it raises stops the core too, and is raised.
    """
    if progress is None and threading.current_thread() is not threading.main_thread():
        return function(*arguments, tally), True

    share = 0.0

    def watch() -> None:
        nonlocal share
        # more work can come in sight
        share = max(share, float(tally[0] / max(1, tally[1])))
        if progress is not None:
            progress(share, note)

    call = _started(function, *arguments, tally)
    try:
        return _finished(*call, watch), True
    except KeyboardInterrupt:
        tally[2] = 1
        return _finished(*call, None), False
    except BaseException:
        tally[2] = 1
        raise


def new_tally() -> NDArray[np.int32]:
    """A tally for the core: nothing done, nothing in sight, not to be stopped."""
    return np.zeros(3, dtype=np.int32)


def _started(
    function: Callable[..., Any], *arguments: Any
) -> tuple[threading.Event, list[Any], list[BaseException]]:
    """A call in a thread of its own, with the places of its answer and of its fault."""
    answer: list[Any] = []
    fault: list[BaseException] = []

    def run() -> None:
        try:
            answer.append(function(*arguments))
        except BaseException as error:
            fault.append(error)
        finally:
            done.set()

    # an event, since a thread whose `join` was interrupted counts as ended (Python before 3.13)
    done = threading.Event()
    threading.Thread(target=run, daemon=True).start()
    return done, answer, fault


def _finished(
    done: threading.Event, answer: list[Any], fault: list[BaseException],
    watch: Callable[[], None] | None,
) -> Any:  # fmt: skip
    """The answer of such a call, when it is there; meanwhile `watch` is called a few times a second."""
    while not done.wait(INTERVAL):
        if watch is not None:
            watch()
    if watch is not None:
        watch()  # the last word, which fell between two looks
    if fault:
        raise fault[0]
    return answer[0]
