"""Performs the requested tasks that are not yet done, several at a time, with a bar that shows the remaining
time."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path
from typing import TextIO

from ..base.errors import ParameterError, VibroimpactError
from .tasks import NAMES, TASKS, Done, fingerprint, perform, recall, with_needs


class Bar:
    """A line on a terminal with the share done and the estimated remaining time."""

    def __init__(self, names: Iterable[str], stream: TextIO) -> None:
        self.left = {name: TASKS[name].weight for name in names}
        self.whole = sum(self.left.values()) or 1.0
        self.stream, self.begin = stream, time.monotonic()
        self.shown = bool(self.left) and stream.isatty()

    def draw(self) -> None:
        """Redraw the line."""
        if not self.shown:
            return
        share = 1 - sum(self.left.values()) / self.whole
        passed = time.monotonic() - self.begin
        time_left = f"{passed * (1 / share - 1):.0f} s left" if share > 0.03 else "..."
        cells = round(30 * share)
        line = f"[{'#' * cells}{'.' * (30 - cells)}] {share:4.0%}  {time_left}"
        self.stream.write(f"\r{line}\x1b[K")
        self.stream.flush()

    def clear(self) -> None:
        """Remove the line."""
        if self.shown:
            self.stream.write("\r\x1b[K")
            self.stream.flush()


def reproduce(
    names: Iterable[str] = (),
    folder: str | Path = "results",
    resolution: float = 1.0,
    workers: int | None = None,
) -> int:
    """Recompute the named items (all, if none is named) and write them to a folder.

    Existing results of this version from the same sources are kept. Items run in processes of
    their own (started by "spawn": a script that calls this needs ``if __name__ == "__main__":``).

    Parameters
    ----------
    names : iterable of str
        Some of `NAMES`.
    folder : path
        Created if it does not exist.
    resolution : float
        Below 1 for coarser grids, fewer load levels and shorter holds.
    workers : int, optional
        Processes; default: one for each processor. With 1 all is done in this process.

    Returns
    -------
    int
        0 if everything agrees with the paper or is explained, 1 if something differs or failed.
    """
    wanted = list(names) or list(NAMES)
    for name in wanted:
        if name not in NAMES:
            raise ParameterError(f"NAME = {name!r}: must be one of {', '.join(NAMES)}")
    folder = Path(folder)
    (folder / "data").mkdir(parents=True, exist_ok=True)
    prints = {name: fingerprint(name, resolution) for name in with_needs(wanted)}
    finished: dict[str, Done] = {}
    for name, print_ in prints.items():
        known = recall(folder, name, print_)
        if known is not None and all(need in finished for need in TASKS[name].needs):
            finished[name] = known
            if name in wanted:
                print(known.messages, end="")
                print(f"{name}: up to date")
    missing = {name: print_ for name, print_ in prints.items() if name not in finished}
    bar = Bar(missing, sys.stderr)
    agree = [done.agrees for done in finished.values()]
    if workers is None:
        workers = min(len(missing), len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity")
                      else os.cpu_count() or 1)  # fmt: skip
    for name, done in _perform_all(missing, folder, resolution, max(1, workers), bar):
        bar.clear()
        if isinstance(done, Done):
            print(done.messages, end="")
            if name in wanted:
                written = ", ".join(str(folder / output) for output in TASKS[name].outputs)
                print(f"{name}: written: {written}", flush=True)
            agree.append(done.agrees)
        else:
            print(f"{name}: {done}", file=sys.stderr)
            agree.append(False)
        bar.draw()
    bar.clear()
    return 0 if all(agree) else 1


def _perform_all(
    missing: dict[str, str], folder: Path, resolution: float, workers: int, bar: Bar
) -> Iterator[tuple[str, Done | str]]:
    """Perform tasks as soon as their dependencies are done; a failure affects only the tasks that depend on
    it."""
    waiting = dict(missing)
    failed: set[str] = set()

    def settle(name: str, future: Future[Done] | None) -> tuple[str, Done | str]:
        bar.left.pop(name, None)
        try:
            return name, future.result() if future else perform(
                name, folder, resolution, missing[name]
            )
        except VibroimpactError as error:
            failed.add(name)
            return name, str(error)
        except OSError as error:
            failed.add(name)
            where = f"{error.filename}: {error.strerror}" if error.filename else str(error)
            return name, f"{where}; must be a folder and disk that can be written"

    def ready() -> Iterator[str]:
        for name in list(waiting):
            pending = [
                need for need in TASKS[name].needs if need in waiting or need in running_names
            ]
            if not pending:
                del waiting[name]
                yield name

    running_names: set[str] = set()
    if workers == 1:
        for name in list(missing):
            bar.draw()
            if failed & set(TASKS[name].needs):
                failed.add(name)
                yield name, "left out: something that it needs failed"
            else:
                yield settle(name, None)
        return
    context = multiprocessing.get_context("spawn")
    # Ctrl-C is handled by this process: running tasks are finished, so that all written results are complete
    with ProcessPoolExecutor(workers, context, _start_worker) as pool:
        running: dict[Future[Done], str] = {}
        try:
            while waiting or running:
                for name in ready():
                    if failed & set(TASKS[name].needs):
                        failed.add(name)
                        bar.left.pop(name, None)
                        yield name, "left out: something that it needs failed"
                        continue
                    with _interrupt_waits():
                        future = pool.submit(perform, name, folder, resolution, missing[name])
                    running[future] = name
                    running_names.add(name)
                done, _ = wait(running, timeout=0.5, return_when=FIRST_COMPLETED)
                for future in done:
                    name = running.pop(future)
                    running_names.discard(name)
                    yield settle(name, future)
                bar.draw()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


@contextlib.contextmanager
def _interrupt_waits() -> Iterator[None]:
    """Block Ctrl-C while a process is started; the new process inherits this, as it cannot ignore it yet."""
    if threading.current_thread() is not threading.main_thread() or os.name != "posix":
        yield
        return
    came: list[int] = []
    # the mask is for the new process: in this process a thread of a library may receive the signal
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    handler = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, handler)
    if came:
        raise KeyboardInterrupt


def _start_worker() -> None:
    """Ignore Ctrl-C, and end with the process that distributes the tasks, even if that is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
