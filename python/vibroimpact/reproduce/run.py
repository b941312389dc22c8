"""Performs the requested tasks, several at a time, each after those that it needs."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

from ..base.errors import ParameterError, VibroimpactError
from ..base.progress import Progress
from .tasks import NAMES, ON_REQUEST, TASKS, Done, perform, with_needs


def reproduce(
    names: Iterable[str] = (),
    folder: str | Path = "results",
    resolution: float = 1.0,
    workers: int | None = None,
) -> int:
    """Recompute the named items and write them to a folder; without names, all items that take only seconds.

    Items run in separate processes (started by "spawn": a script that calls this needs
    ``if __name__ == "__main__":``).

    Parameters
    ----------
    names : iterable of str
        Some of `NAMES`; ``"proof6a"``, which takes minutes, is computed only if it is named.
    folder : path
        Created if it does not exist.
    resolution : float
        Below 1 for coarser grids, fewer load levels and shorter holds.
    workers : int, optional
        Number of processes; default: one for each processor. With 1, everything runs in this process.

    Returns
    -------
    int
        0 if everything agrees with the paper or the difference is explained, 1 if something differs or failed.
    """
    wanted = list(names) or [name for name in NAMES if name not in ON_REQUEST]
    for name in wanted:
        if name not in NAMES:
            raise ParameterError(f"NAME = {name!r}: must be one of {', '.join(NAMES)}")
    folder = Path(folder)
    (folder / "data").mkdir(parents=True, exist_ok=True)
    needed = with_needs(wanted)
    if workers is None:
        workers = min(len(needed), len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity")
                      else os.cpu_count() or 1)  # fmt: skip
    agree = []
    with Progress("reproduce") as bar:
        for name, done in _perform_all(needed, folder, resolution, workers, bar.show):
            if isinstance(done, Done):
                bar.clear()
                print(done.messages, end="")
                if name in wanted:
                    written = ", ".join(str(folder / output) for output in TASKS[name].outputs)
                    print(f"{name}: written: {written}", flush=True)
            else:
                bar.clear()
                print(f"{name}: {done}", file=sys.stderr)
            agree.append(isinstance(done, Done) and done.agrees)
    return 0 if all(agree) else 1


class _InThisProcess(Executor):
    """Performs each call immediately."""

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **_: Any) -> Future[Any]:
        """Perform the call."""
        future: Future[Any] = Future()
        try:
            future.set_result(call(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


def _perform_all(
    names: list[str], folder: Path, resolution: float, workers: int, show: Callable[[float], None]
) -> Iterator[tuple[str, Done | str]]:
    """Perform each task as soon as those that it needs are done; a failure affects only the tasks that need
    it."""
    order = TopologicalSorter({name: TASKS[name].needs for name in names})
    order.prepare()
    left = {name: TASKS[name].weight for name in names}
    whole = sum(left.values())
    failed: set[str] = set()
    running: dict[Future[Done], str] = {}
    # this process handles Ctrl-C: running tasks are finished, so that all written results are complete
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, context, _start_worker) if workers > 1 else _InThisProcess()
    with pool:
        try:
            while order.is_active():
                for name in order.get_ready():
                    if failed & set(TASKS[name].needs):
                        future: Future[Done] = Future()
                        future.set_exception(
                            VibroimpactError("left out: an item that it needs failed")
                        )
                    else:
                        with _interrupt_waits():
                            future = pool.submit(perform, name, folder, resolution)
                    running[future] = name
                finished, _ = wait(running, timeout=0.5, return_when=FIRST_COMPLETED)
                for future in finished:
                    name = running.pop(future)
                    order.done(name)
                    del left[name]
                    done = _outcome(future)
                    if not isinstance(done, Done):
                        failed.add(name)
                    yield name, done
                show(1 - sum(left.values()) / whole)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _outcome(future: Future[Done]) -> Done | str:
    """The outcome of a task, or the reason why it failed."""
    try:
        return future.result()
    except VibroimpactError as error:
        return str(error)
    except OSError as error:
        where = f"{error.filename}: {error.strerror}" if error.filename else str(error)
        return f"{where}; the folder and the disk must be writable"


@contextlib.contextmanager
def _interrupt_waits() -> Iterator[None]:
    """Block Ctrl-C while a process is started; the new process inherits this, since it cannot ignore Ctrl-C
    yet."""
    if threading.current_thread() is not threading.main_thread() or os.name != "posix":
        yield
        return
    came: list[int] = []
    # the mask is meant for the new process: in this process a thread of a library may still receive the signal
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
