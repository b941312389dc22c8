"""The explorer in a process of its own, for tests, benchmarks and pictures of it."""

from __future__ import annotations

import re
import subprocess
import sys

__all__ = ["SETTLED", "start"]

#: Of the page's script: whether every question is answered and every thread is done.
SETTLED = "window.vibroimpact?.settled()"
COMMAND = "import sys; from vibroimpact.command import main; sys.exit(main(sys.argv[1:]))"


def start(*words: str, prelude: str = "") -> tuple[subprocess.Popen[str], str]:
    """A server at a free port, and its address; SIGINT ends it.

    Parameters
    ----------
    words : str
        Further options of `vibroimpact explore`.
    prelude : str
        Python that runs first.

    Raises
    ------
    RuntimeError
        If it ends at once.

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
    found = re.search(r"http://\S+/", process.stdout.readline())
    if found is None:
        raise RuntimeError("".join(process.communicate(timeout=20)))
    return process, found.group()
