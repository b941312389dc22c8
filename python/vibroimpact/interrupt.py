"""Long calls of the core that Ctrl-C interrupts."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

#: Seconds between two looks at whether the call is done; in between an interrupt is heard at once.
INTERVAL = 0.05


def interruptible(
    function: Callable[..., Any], *arguments: Any, watch: Callable[[], None] | None = None
) -> Any:
    """What a function of the core answers, while the main thread stays free to hear Ctrl-C.

    The core cannot be stopped within a call: after an interrupt it runs on in a thread that ends with the
    program, and its answer is dropped. Meanwhile `watch`, if there is one, is called a few times a second.
    """
    if watch is None and threading.current_thread() is not threading.main_thread():
        return function(*arguments)
    answer: list[Any] = []
    fault: list[BaseException] = []

    def run() -> None:
        try:
            answer.append(function(*arguments))
        except BaseException as error:
            fault.append(error)

    worker = threading.Thread(target=run, daemon=True)
    worker.start()
    while worker.is_alive():
        worker.join(INTERVAL)
        if watch is not None:
            watch()
    if fault:
        raise fault[0]
    return answer[0]
