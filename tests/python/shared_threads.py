"""Work of several threads that start at the same time."""

import threading
from concurrent.futures import ThreadPoolExecutor

THREADS = 8


def together(work):
    """The results of `work(i)` in threads that start at the same time."""
    start = threading.Barrier(THREADS)

    def begin(i):
        start.wait()
        return work(i)

    with ThreadPoolExecutor(THREADS) as pool:
        return list(pool.map(begin, range(THREADS)))
