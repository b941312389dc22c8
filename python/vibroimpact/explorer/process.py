"""The explorer in its own process, for tests, benchmarks and pictures of it."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["SETTLED", "start", "visited"]

#: A condition in the page's script: all requests are answered and all threads have finished.
SETTLED = "window.vibroimpact?.settled()"
COMMAND = "import sys; from vibroimpact.commands.command import main; sys.exit(main(sys.argv[1:]))"


def start(*words: str, prelude: str = "") -> tuple[subprocess.Popen[str], str]:
    """Start a server at a free port; return the process and its address. SIGINT ends the server.

    Parameters
    ----------
    words : str
        Further options of `vibroimpact explore`.
    prelude : str
        Python code that runs first.

    Raises
    ------
    RuntimeError
        If the server ends immediately.

    Examples
    --------
    >>> import signal
    >>> from vibroimpact.explorer.process import start
    >>> process, url = start()
    >>> url.startswith("http://127.0.0.1:")
    True
    >>> process.send_signal(signal.SIGINT)
    >>> process.communicate(timeout=20)
    ('ended\\n', '')
    """
    options = ["explore", "--no-browser", "--port", "0", *words]
    process = subprocess.Popen(
        [sys.executable, "-c", f"{prelude}\n{COMMAND}", *options], stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    found = re.search(r"http://\S+", process.stdout.readline())
    if found is None:
        raise RuntimeError("".join(process.communicate(timeout=20)))
    return process, found.group()


@contextmanager
def visited(width: int, height: int, query: str = "") -> Iterator[tuple[int, Any]]:
    """The process id of a server, and its page in a headless Chromium (playwright) once all computations have
    finished."""
    from playwright.sync_api import sync_playwright

    process, url = start()
    try:
        with sync_playwright() as driver:
            flags = ["--no-sandbox", "--disable-gpu"]
            browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
            tab = browser.new_page(viewport={"width": width, "height": height})
            tab.goto(f"{url}?{query}" if query else url)
            tab.wait_for_function(SETTLED)
            yield process.pid, tab
            browser.close()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=20)
