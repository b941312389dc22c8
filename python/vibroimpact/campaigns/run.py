"""A campaign: the cases that its store lacks are computed, on threads or on a cluster."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor
from concurrent.futures import wait as wait_for
from importlib.metadata import version
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import checks
from ..case import Case, study_of
from ..errors import MissingExtraError, ParameterError, ParameterTypeError, StudyInterrupted
from ..interrupt import new_counters
from .campaign import Campaign
from .chunk import Chunk, compute, core_digest, name_of
from .store import Store
from .sweep import CaseList, Sweep

__all__ = ["campaign"]

#: If their size is not given: most chunks of a campaign, cases of the smallest ones, and of the largest.
CHUNKS, SMALLEST, LARGEST = 100, 4, 100_000
#: Seconds between two looks at progress.
INTERVAL = 0.2
#: Chunks that wait for each worker.
AHEAD = 2

Progress = Callable[[float, str], None]


class Task(NamedTuple):
    """Some cases that are to be computed."""

    name: str
    first: int
    texts: list[str]


class Workers(Protocol):
    """Threads, or a cluster."""

    def capacity(self) -> int:
        """How many tasks they should have at a time."""

    def submit(self, study: str, task: Task) -> Any:
        """Start a task."""

    def wait(self, futures: list[Any]) -> list[Any]:
        """Those that have ended, after a short time."""

    def stop(self) -> None:
        """Give up all tasks."""


def campaign(
    cases: Sweep | Iterable[str | Case], store: str | os.PathLike[str], client: Any = None, *,
    chunk: int | None = None, threads: int | None = None, progress: Progress | None = None,
) -> Campaign:  # fmt: skip
    """Compute many cases of one study, and keep their results in a store.

    What the store has is not computed again: the same call continues a campaign that was interrupted or killed.
    The store is the same to the last bit, whatever computed it.

    Parameters
    ----------
    cases : Sweep or iterable of str or Case
        The cases, all of one study.
    store : path
        A folder: a new one, an empty one, or that of this campaign.
    client : distributed.Client or str, optional
        Where the cases are computed: a client of dask, the address of its scheduler, or "local" for as many
        processes as this machine has processors. By default threads of this process compute them.
    chunk : int, optional
        Cases that are computed and written together. By default there are at most 100 chunks, of 4 to
        100,000 cases. A chunk should take a second or longer.
    threads : int, optional
        Number of threads without a client; by default that of the processors.
    progress : callable, optional
        Called with the share done and a text.

    Returns
    -------
    Campaign
        The results, which are read from the store when they are asked for.

    Raises
    ------
    ParameterError, ParameterTypeError
        For a store that holds something else, or to which another process writes, or for bad cases.
    MissingExtraError
        If zarr, or with a client distributed, is not installed.
    StudyInterrupted
        After Ctrl-C, with the results so far.
    OSError
        If the store cannot be written; the chunks so far are kept.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> case = vi.equispaced(osc, r=1.0, clearance=20.0)[0].to_namelist()
    >>> sweep = vi.Sweep(case, {"r": [0.9, 1.0], "clearance": [10.0, 20.0, 30.0]})
    >>> store = pathlib.Path(tempfile.mkdtemp()) / "store"
    >>> vi.campaign(sweep, store)
    <Campaign of motion: 6 of 6 cases finished, 0 refused>
    """
    plan = cases if isinstance(cases, Sweep) else CaseList(_iterable(cases))
    study = study_of(plan.text(0))
    number = len(plan)
    if chunk is None:
        chunk = min(LARGEST, max(SMALLEST, -(-number // CHUNKS)))
    size = checks.integer(chunk, "chunk", 1, 10**7)
    if progress is not None and not callable(progress):
        raise ParameterTypeError(f"progress = {progress!r}: must be None or callable")
    place = Store(store)
    record = {
        "study": study, "size": number, "chunk": size, "core": core_digest(),
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
    """Compute what the store lacks; whether Ctrl-C stopped it."""
    number = len(plan)
    done = 0
    running: dict[Any, Task] = {}

    def missing() -> Iterator[Task | int]:
        """The tasks, and for each chunk that is there the number of its cases."""
        for first in range(0, number, size):
            texts = [plan.text(i) for i in range(first, min(first + size, number))]
            name = name_of(study, first, texts)
            yield len(texts) if store.state(name) == "done" else Task(name, first, texts)

    source = missing()
    exhausted = False
    try:
        while running or not exhausted:
            while not exhausted and len(running) < workers.capacity():
                item = next(source, None)
                if item is None:
                    exhausted = True
                elif isinstance(item, int):
                    done += item
                else:
                    running[workers.submit(study, item)] = item
            for future in workers.wait(list(running)) if running else ():
                task = running.pop(future)
                _keep(store, task, future)
                done += len(task.texts)
            if progress is not None:
                progress(done / number, f"{done} of {number} cases")
    except KeyboardInterrupt:
        workers.stop()
        return True
    except BaseException:
        workers.stop()
        raise
    return False


def _keep(store: Store, task: Task, future: Any) -> None:
    """Write what a task has given; its cases as namelists if it failed."""
    try:
        chunk: Chunk = future.result()
    except ParameterError:
        raise
    except Exception as error:
        if lost(error):
            raise ConnectionError(
                "the scheduler of the cluster is gone; the finished chunks are kept: run the campaign again"
            ) from error
        for i, text in enumerate(task.texts):
            store.fail(task.first + i, text, f"{type(error).__name__}: {error}")
        return
    store.write(task.name, chunk)
    for i, message in chunk.errors.items():
        store.fail(task.first + i, task.texts[i], message)


def lost(error: Exception) -> bool:
    """Whether a task was given up because the scheduler is gone."""
    return type(error).__name__ in ("CancelledError", "FutureCancelledError", "CommClosedError")


class Threads:
    """Threads of this process; each case uses one."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.pool = ThreadPoolExecutor(number)
        self.running: dict[Future[Chunk], NDArray[np.int32]] = {}

    def capacity(self) -> int:
        """How many tasks they should have at a time."""
        return self.number * AHEAD

    def submit(self, study: str, task: Task) -> Future[Chunk]:
        """Start a task."""
        counters = new_counters()
        future = self.pool.submit(compute, study, task.texts, core_digest(), 1, counters)
        self.running[future] = counters
        return future

    def wait(self, futures: list[Any]) -> list[Any]:
        """Those that have ended, after a short time."""
        done, _ = wait_for(futures, INTERVAL, FIRST_COMPLETED)
        for future in done:
            del self.running[future]
        return [future for future in futures if future in done]

    def stop(self) -> None:
        """Give up all tasks."""
        for counters in self.running.values():
            counters[2] = 1
        self.pool.shutdown(cancel_futures=True)


class Cluster:
    """A cluster of dask."""

    def __init__(self, client: Any) -> None:
        self.client = client
        self.running: set[Any] = set()

    def capacity(self) -> int:
        """How many tasks they should have at a time."""
        threads: int = sum(self.client.nthreads().values())
        return AHEAD * max(1, threads)

    def submit(self, study: str, task: Task) -> Any:
        """Start a task."""
        future = self.client.submit(compute, study, task.texts, core_digest(), pure=False)
        self.running.add(future)
        return future

    def wait(self, futures: list[Any]) -> list[Any]:
        """Those that have ended, after a short time."""
        from distributed import TimeoutError as Late
        from distributed import wait

        with contextlib.suppress(Late):
            wait(futures, timeout=INTERVAL, return_when="FIRST_COMPLETED")
        done = [future for future in futures if future.done()]
        self.running.difference_update(done)
        return done

    def stop(self) -> None:
        """Give up all tasks."""
        with contextlib.suppress(Exception):  # the scheduler may be gone
            self.client.cancel(list(self.running))


@contextlib.contextmanager
def _workers(client: Any, threads: int | None) -> Iterator[Workers]:
    """Threads, or the cluster of a client."""
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
        import distributed
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
            # other users of this machine reach its ports, and would have their code run: TLS keeps them out; its
            # files are in a folder of its own, since dask's is known and shared
            folder = stack.enter_context(tempfile.TemporaryDirectory(ignore_cleanup_errors=True))
            address: Any = stack.enter_context(
                distributed.LocalCluster(n_workers=os.cpu_count(), threads_per_worker=1, host="127.0.0.1",
                                         dashboard_address=None, security=True, local_directory=folder)
            )  # fmt: skip
        else:
            address = client
        try:
            here = stack.enter_context(distributed.Client(address, timeout=10))
        except (OSError, ValueError) as error:
            raise ParameterError(
                f"client = {client!r}: no scheduler answers there; {error}"
            ) from None
        yield Cluster(here)
