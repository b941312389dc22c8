"""`vibroimpact campaign`: all cases of a sweep, on threads or on a cluster, into a store."""

from __future__ import annotations

import argparse
import contextlib
import signal
from collections.abc import Iterator

from ..base.errors import ParameterError, StudyInterrupted
from ..base.progress import Progress
from ..campaigns.campaign import Campaign
from ..campaigns.run import campaign
from ..campaigns.sweep import Sweep
from ..cases.case import read_namelist

DESCRIPTION = """Compute all cases of the &sweep of a namelist file, and keep the results in a store (Zarr). The
same command resumes a campaign that was interrupted or killed; cases in the store are not
computed again. A case that is rejected or fails is written to STORE/failures as a namelist.
With --cluster the cases run on a dask cluster. It requires the extra `campaign`:
pip install 'vibroimpact[campaign]'."""
EXAMPLE = (
    "echo \"&system xi = .01, mu = .05, restitution = .75, r = 1 / &motion kind = 'equispaced', clearance = 20 / "
    "&sweep keys = 'r', values = .9, 1 /\" > sweep.nml && vibroimpact campaign sweep.nml --store store"
)


def arguments(parser: argparse.ArgumentParser) -> None:
    """The file, the store and the cluster."""
    parser.add_argument("file", metavar="FILE", help="a namelist file with one case and its &sweep")
    parser.add_argument(
        "--store", required=True, metavar="DIR",
        help="folder of the results: a new one, or the existing one of this campaign",
    )  # fmt: skip
    parser.add_argument(
        "--cluster", metavar="WHERE",
        help="local (one process for each processor), or the address of a dask scheduler, such as "
        "tcp://node1:8786",
    )  # fmt: skip
    parser.add_argument(
        "--chunk", type=int, metavar="N",
        help="cases computed and written together (default: chosen to give at most 100 chunks)",
    )  # fmt: skip
    parser.add_argument(
        "--threads",
        type=int,
        metavar="N",
        help="threads without a cluster (default: all processors)",
    )


def run(options: argparse.Namespace) -> int:
    """Compute the cases missing from the store."""
    cases = read_namelist(options.file)
    if len(cases) != 1:
        raise ParameterError(
            f"{options.file}: has {len(cases)} cases; must have one, with its &sweep"
        )
    sweep = Sweep.of_case(cases[0])
    with Progress(cases[0].name, resumed=True) as bar, terminable():
        try:
            found = campaign(
                sweep, options.store, options.cluster, chunk=options.chunk, threads=options.threads,
                progress=bar.show,
            )  # fmt: skip
        except StudyInterrupted as stop:
            describe(stop.result, cases[0].name)
            if stop.result._done():
                options.record.files.append(options.store)
            raise KeyboardInterrupt from None
    options.record.files.append(options.store)
    return describe(found, cases[0].name)


@contextlib.contextmanager
def terminable() -> Iterator[None]:
    """Give SIGTERM, which batch systems send before they kill a job, the effect of Ctrl-C."""
    try:
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    except ValueError:  # in another thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def describe(found: Campaign, name: str) -> int:
    """Print the progress of the campaign; returns the exit status."""
    done, refused = found._done(), found._store.failed()
    print(f"{name}: {done} of {found.size} cases of {found.study} finished")
    if refused:
        print(
            f"{name}: {refused} rejected or failed; see {found.failures} for these cases and the reasons"
        )
    return 1 if refused or done < found.size else 0
