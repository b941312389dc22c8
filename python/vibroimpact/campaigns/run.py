"""Runs a campaign: computes the cases that are missing from its store, on threads or on a cluster."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from importlib.metadata import version
from importlib.util import find_spec
from queue import Empty, SimpleQueue
from typing import Any, NamedTuple, Protocol
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import (
    ClusterError,
    MissingExtraError,
    ParameterError,
    ParameterTypeError,
    StudyInterrupted,
    VibroimpactError,
)
from ..base.interrupt import new_counters
from ..cases.case import Case, study_of
from ..results.namelist import has_structure
from .campaign import Campaign
from .chunk import Chunk, compute, core_digest, name_of
from .store import Store
from .sweep import CaseList, Sweep

__all__ = ["campaign"]

#: Without a given chunk size: the largest number of chunks, and the smallest and largest number of cases in a
#: chunk.
CHUNKS, SMALLEST, LARGEST = 100, 4, 10_000
#: Seconds between two checks of the progress.
INTERVAL = 0.2
#: Number of chunks queued for each worker.
AHEAD = 2

Progress = Callable[[float, str], None]


class Task(NamedTuple):
    """A group of cases to be computed."""

    name: str
    first: int
    texts: list[str]


class Workers(Protocol):
    """Threads or a cluster, on which tasks run."""

    def capacity(self) -> int:
        """The number of tasks to give to the workers at a time."""

    def submit(self, study: str, task: Task) -> Any:
        """Start a task."""

    def wait(self, futures: list[Any]) -> list[Any]:
        """The tasks that have ended, after a short wait."""

    def result(self, future: Any) -> Chunk:
        """The result of a task, or its error: MemoryError if the task itself, not the workers, is the cause."""

    def stop(self) -> None:
        """Cancel all tasks."""


def campaign(
    cases: Sweep | Iterable[str | Case], store: str | os.PathLike[str], client: Any = None, *,
    chunk: int | None = None, threads: int | None = None, progress: Progress | None = None,
) -> Campaign:  # fmt: skip
    """Compute many cases of one study, and keep their results in a store.

    Cases that are already in the store are not computed again: the same call resumes a campaign that was
    interrupted or killed. The store is the same to the last bit on any machine.

    Parameters
    ----------
    cases : Sweep or iterable of str or Case
        The cases, all of the same study.
    store : path
        A folder: a new one, an empty one, or that of this campaign.
    client : distributed.Client or str, optional
        Where the cases are computed: a dask client, the address of a dask scheduler, or "local" for as many
        processes as this machine has processors. By default threads of this process compute them.
    chunk : int, optional
        Number of cases that are computed and written together. By default there are at most 100 chunks, of 4 to
        10,000 cases. A chunk should take a second or longer.
    threads : int, optional
        Number of threads without a client; by default one for each processor.
    progress : callable, optional
        Called with the fraction done and a text; by default a bar on a terminal or in a notebook.

    Returns
    -------
    Campaign
        The results, which are read from the store on demand.

    Raises
    ------
    ParameterError, ParameterTypeError
        If the store contains something else, or another process is writing to it, or a case is invalid.
    MissingExtraError
        If zarr or, with a client, distributed is not installed.
    StudyInterrupted
        After Ctrl-C, with the results so far.
    ClusterError
        If the connection to the scheduler is lost, or the workers cannot compute; finished chunks are kept.
    OSError
        If the store cannot be written; finished chunks are kept.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> case = vi.equispaced(osc, r=1.0, clearance=20.0)[0].to_namelist()
    >>> sweep = vi.Sweep(case, {"r": [0.9, 1.0], "clearance": [10.0, 20.0, 30.0]})
    >>> store = pathlib.Path(tempfile.mkdtemp()) / "store"
    >>> vi.campaign(sweep, store)
    <Campaign of motion: 6 of 6 cases finished, 0 rejected>
    """
    plan = cases if isinstance(cases, Sweep) else CaseList(_iterable(cases))
    study = study_of(plan.text(0))
    number = len(plan)
    if chunk is None:
        chunk = min(LARGEST, max(SMALLEST, -(-number // CHUNKS)))
    size = checks.integer(chunk, "chunk", 1, 10**7)
    checks.progress(progress)
    place = Store(store)
    record = {
        "study": study, "of_structure": has_structure(plan.text(0)), "size": number, "chunk": size,
        "core": core_digest(),
        "vibroimpact": version("vibroimpact"),
        **plan.record,
    }  # fmt: skip
    with place.writing(record), _workers(client, threads) as workers:
        stopped = _run(workers, place, study, plan, size, progress)
    found = Campaign(store)
    if stopped:
        raise StudyInterrupted(found)
    return found


def _iterable(cases: Any) -> Any:
    if isinstance(cases, (str, bytes)) or not isinstance(cases, Iterable):
        raise ParameterTypeError(f"cases = {cases!r}: must be a Sweep, or an iterable of namelists")
    return cases


def _run(
    workers: Workers, store: Store, study: str, plan: Sweep | CaseList, size: int,
    progress: Progress | None,
) -> bool:  # fmt: skip
    """Compute the cases missing from the store; returns whether Ctrl-C stopped it."""
    number = len(plan)
    done = sum(min(size, number - int(name.partition("-")[0])) for name in store.names())
    running: dict[Any, Task] = {}

    def missing() -> Iterator[Task]:
        """Yields the tasks in order; only a few that are not yet computed exist at a time."""
        nonlocal done
        for first in range(0, number, size):
            texts = [plan.text(i) for i in range(first, min(first + size, number))]
            name = name_of(study, first, texts)
            state = store.state(name)
            if state == "damaged":
                done -= len(texts)
            if state == "done":
                tell()
            else:
                yield Task(name, first, texts)

    def tell() -> None:
        if progress is not None:
            progress(done / number, f"{done} of {number} cases")

    source = missing()
    exhausted = False
    try:
        tell()
        while running or not exhausted:
            for _ in range(workers.capacity() - len(running)):
                task = next(source, None)
                if task is None:
                    exhausted = True
                    break
                running[workers.submit(study, task)] = task
            for future in workers.wait(list(running)) if running else ():
                task = running.pop(future)
                done += _kept(store, task, workers, future)
            tell()
    except KeyboardInterrupt:
        workers.stop()
        return True
    except BaseException:
        workers.stop()
        raise
    return False


def _kept(store: Store, task: Task, workers: Workers, future: Any) -> int:
    """Write the result of a task, or its cases as namelists if it failed; returns how many cases are finished."""
    try:
        chunk = workers.result(future)
    except MemoryError as error:
        for i, text in enumerate(task.texts):
            store.fail(task.first + i, text, f"{type(error).__name__}: {error}")
        return 0
    for i, message in chunk.errors.items():
        store.fail(task.first + i, task.texts[i], message)
    store.write(task.name, chunk)  # written first: a chunk that exists is not computed again
    store.clear(task.first + i for i in range(len(task.texts)) if i not in chunk.errors)
    return len(task.texts)


class Threads:
    """Threads of this process; each case uses one."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.pool = ThreadPoolExecutor(number)
        self.running: dict[Future[Chunk], NDArray[np.int32]] = {}
        #: Finished tasks. A queue stays consistent if Ctrl-C interrupts it at any instant; the locks of
        #: `concurrent.futures.wait`, written in Python, do not.
        self.ended: SimpleQueue[Future[Chunk]] = SimpleQueue()

    def capacity(self) -> int:
        """The number of tasks to give to the workers at a time."""
        return self.number * AHEAD

    def submit(self, study: str, task: Task) -> Future[Chunk]:
        """Start a task."""
        counters = new_counters()
        future = self.pool.submit(compute, study, task.texts, core_digest(), 1, counters)
        self.running[future] = counters
        future.add_done_callback(self.ended.put)
        return future

    def wait(self, futures: list[Any]) -> list[Any]:
        """The tasks that have ended, after a short wait."""
        ended = set()
        with contextlib.suppress(Empty):
            ended.add(self.ended.get(timeout=INTERVAL))
            while True:
                ended.add(self.ended.get_nowait())
        for future in ended:
            del self.running[future]
        return [future for future in futures if future in ended]

    def result(self, future: Future[Chunk]) -> Chunk:
        """The result of a task."""
        return future.result()

    def stop(self) -> None:
        """Cancel all tasks."""
        for counters in self.running.values():
            counters[2] = 1
        self.pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _trouble() -> Iterator[None]:
    """One error for all exceptions that a lost scheduler causes."""
    from distributed import CancelledError
    from distributed.comm import CommClosedError

    try:
        yield
    except (CancelledError, CommClosedError, OSError, RuntimeError) as error:
        raise ClusterError(
            f"the connection to the scheduler of the cluster was lost ({type(error).__name__}); "
            "the finished chunks are kept: run the campaign again"
        ) from error


class Cluster:
    """A dask cluster."""

    def __init__(self, client: Any) -> None:
        self.client = client
        self.running: set[Any] = set()
        link = None
        with contextlib.suppress(Exception):  # a scheduler that does not report it
            link = client.dashboard_link
        if link:
            print(f"dashboard: {link}", file=sys.stderr)

    def capacity(self) -> int:
        """The number of tasks to give to the workers at a time."""
        with _trouble():
            threads: int = sum(self.client.nthreads().values())
        return AHEAD * max(1, threads)

    def submit(self, study: str, task: Task) -> Any:
        """Start a task."""
        with _trouble():
            future = self.client.submit(compute, study, task.texts, core_digest(), pure=False)
        self.running.add(future)
        return future

    def wait(self, futures: list[Any]) -> list[Any]:
        """The tasks that have ended, after a short wait."""
        from distributed import TimeoutError as Late
        from distributed import wait

        with _trouble(), contextlib.suppress(Late), self.client.as_current():
            wait(futures, timeout=INTERVAL, return_when="FIRST_COMPLETED")
        done = [future for future in futures if future.done()]
        self.running.difference_update(done)
        return done

    def result(self, future: Any) -> Chunk:
        """The result of a task."""
        from distributed import CancelledError, KilledWorker
        from distributed.comm import CommClosedError

        try:
            chunk: Chunk = future.result()
        except (VibroimpactError, MemoryError):
            raise
        except (
            KilledWorker
        ) as error:  # workers died several times, so probably because of this task
            raise MemoryError(f"each worker that computed it was killed: {error}") from error
        except (CancelledError, CommClosedError) as error:
            with _trouble():
                raise error
        except Exception as error:
            raise ClusterError(
                f"a worker failed: {type(error).__name__}: {error}; it must have the same build of "
                "vibroimpact as this process"
            ) from error
        return chunk

    def stop(self) -> None:
        """Cancel all tasks."""
        with contextlib.suppress(Exception):  # the scheduler may be gone
            self.client.cancel(list(self.running))


@contextlib.contextmanager
def _workers(client: Any, threads: int | None) -> Iterator[Workers]:
    """Threads of this process, or the cluster of a client."""
    if client is None:
        number = checks.integer(
            os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
        )
        pool = Threads(number)
        with pool.pool:
            yield pool
        return
    if threads is not None:
        raise ParameterError(
            "threads: must be left out with a client, whose workers have their own"
        )
    try:
        import cryptography  # noqa: F401 (for the TLS of a local cluster)
        import dask
        import distributed

        from ..base.local_pages import protect
    except ImportError:
        raise MissingExtraError(
            "a cluster needs dask and cryptography: pip install 'vibroimpact[campaign]'"
        ) from None
    if isinstance(client, distributed.Client):
        yield Cluster(client)
        return
    if not isinstance(client, str):
        raise ParameterTypeError(
            f"client = {client!r}: must be a distributed.Client, an address or 'local'"
        )
    with contextlib.ExitStack() as stack:
        if client == "local":
            # other users of this machine can reach its ports and could run code there, so TLS keeps them out; its
            # files are in a separate folder, since the folder of dask is known and shared
            folder = stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
            dashboard = "127.0.0.1:0" if find_spec("bokeh") else None
            # workers serve no dashboard pages
            stack.enter_context(dask.config.set({"distributed.worker.http.routes": []}))
            try:
                address: Any = stack.enter_context(
                    distributed.LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, host="127.0.0.1",
                                             dashboard_address=dashboard, security=True, local_directory=folder)
                )  # fmt: skip
            except Exception as error:  # a worker that was killed, ports or memory that are used up
                raise ClusterError(
                    f"client = 'local': its processes did not start ({type(error).__name__}: {error}); nothing "
                    "was computed: run the campaign again"
                ) from error
            if dashboard:
                port = urlsplit(address.dashboard_link).port
                protect(address.scheduler.http_application, ("127.0.0.1", "localhost"), port)
        else:
            address = client
        try:
            here = stack.enter_context(
                distributed.Client(address, timeout=10, set_as_default=False)
            )
        except Exception as error:  # dask raises an AssertionError for an address of unknown form
            raise ParameterError(
                f"client = {client!r}: no scheduler answers there; must be an address such as tcp://node1:8786"
                + (f" ({error})" if str(error) else "")
            ) from None
        yield Cluster(here)
