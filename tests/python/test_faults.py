"""Real faults: nothing is lost, no number is wrong, and a resumed store equals the undisturbed one.

Programs are stopped at random instants: at a few with each run of the tests, at 200 with `--instants 200`.
A failure shows the seed, with which `--seed` repeats it.
"""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_campaign import equispaced_case, files_of, small_sweep

pytest.importorskip("zarr")
pytestmark = [
    pytest.mark.faults,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system"),
]

BIN = Path(sys.executable).parent
SWEEP = """&system
  xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1
/
&motion
  kind = 'equispaced', clearance = 20
/
&sweep
  keys = 'xi', 'r', 'clearance'
  low = 0, 0.9, 2, high = 0.02, 1.1, 200, counts = 2, 5, 8, spacing = 'linear', 'linear', 'geometric'
/
"""
#: Forks child processes with all modules loaded, one for each line; gives their numbers and statuses.
NURSERY = """
import json, os, sys, signal
import vibroimpact_start, vibroimpact.commands.command, vibroimpact.campaigns.run, zarr, numcodecs.zstd
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
for line in sys.stdin:
    out, *words = json.loads(line)
    number = os.fork()
    if not number:
        os.setsid()
        handle = os.open(out, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(handle, 1), os.dup2(handle, 2), os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        sys.argv[1:] = words
        try:  # Ctrl-C is heard from here on
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        except KeyboardInterrupt:
            print("interrupted before the start", flush=True), os._exit(1)
        status = vibroimpact_start.main()
        sys.stdout.flush(), os._exit(status)
    print(number, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]), flush=True)
"""


class Nursery:
    """Runs of `vibroimpact campaign` that start within milliseconds."""

    def __init__(self, folder):
        self.output = folder / "output"
        self.file = folder / "sweep.nml"
        self.file.write_text(SWEEP)
        self.process = subprocess.Popen(
            [sys.executable, "-c", NURSERY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )  # fmt: skip

    def start(self, store, *words, file=None):
        """Start a campaign; return its process number."""
        call = ["campaign", file or self.file, "--store", store, "--chunk", "8", *words]
        print(json.dumps([*map(str, (self.output, *call))]), file=self.process.stdin, flush=True)
        return int(self.process.stdout.readline())

    def end(self):
        """Wait for its end; return the exit status and the output."""
        return int(self.process.stdout.readline()), self.output.read_text()

    def run(self, store, *words, **options):
        """Run a campaign to its end."""
        self.start(store, *words, **options)
        return self.end()


@pytest.fixture(scope="module")
def nursery(tmp_path_factory):
    """A process that starts campaigns."""
    found = Nursery(tmp_path_factory.mktemp("nursery"))
    yield found
    found.process.stdin.close()
    found.process.wait()


@pytest.fixture(scope="module")
def undisturbed(nursery, tmp_path_factory):
    """The files of a campaign that ran without interruption, and its duration in seconds."""
    store = tmp_path_factory.mktemp("undisturbed") / "store"
    nursery.run(store)
    shutil.rmtree(store)
    begin = time.monotonic()
    status, output = nursery.run(store)
    seconds = time.monotonic() - begin
    assert (status, output.splitlines()[0]) == (1, "sweep: 80 of 80 cases of motion finished")
    assert "sweep: 8 rejected or failed; see " in output
    return files_of(store), seconds


@pytest.fixture
def random(request):
    """Random numbers from the seed of this run, which a failure reports."""
    seed = request.config.getoption("--seed")
    print(f"--seed {seed}")
    return np.random.default_rng(seed)


@pytest.fixture
def instants(request):
    """The number of instants at which programs are stopped."""
    return request.config.getoption("--instants")


def whole(store, expected):
    """Check that each finished file of a store equals that of the undisturbed one."""
    for name, content in files_of(store).items():
        if ".part" not in name and name != "lock":
            assert content == expected[name], name


# -- random instants


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_campaigns_stopped_at_random_instants(
    nursery, undisturbed, random, instants, tmp_path, number
):
    """After each stop all existing files are right, and the message is clear; at the end nothing is lost."""
    expected, seconds = undisturbed
    store = tmp_path / "store"
    stopped = 0
    for i in range(instants if number == signal.SIGKILL else min(instants, 20)):
        process = nursery.start(store)
        time.sleep(random.uniform(0, seconds))
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, number)
        status, output = nursery.end()
        finished = "80 of 80" in output
        stopped += not finished
        assert "Traceback" not in output
        if (
            number != signal.SIGKILL and status != -number
        ):  # before and after the work it ends at once
            assert status == 1
            assert finished or "interrupted" in output
        if store.exists():
            whole(store, expected)
        # in a complete store there is nothing to stop; the machine may have been slower when it was timed
        if i % 4 == 3 or finished:
            nursery.run(store)
            assert files_of(store) == expected
            shutil.rmtree(store)
        seconds *= 0.8 if finished else 1
    assert stopped
    nursery.run(store)
    assert files_of(store) == expected


def test_killed_before_the_plan_was_written(nursery, undisturbed, tmp_path):
    """A leftover temporary plan is removed; a file of another program, in a folder without a store, is kept."""
    store = tmp_path / "store"
    store.mkdir()
    (store / "lock").touch()
    (store / "0123456789abcdef.part").write_text("{")
    nursery.run(store)
    assert files_of(store) == undisturbed[0]
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "film.part").touch()
    status, output = nursery.run(tmp_path / "mine")
    assert (status, "it holds 'film.part'" in output) == (2, True)
    assert (tmp_path / "mine" / "film.part").exists()


def test_the_program_killed_at_random_instants(random, instants, tmp_path):
    """Every result of vibroimpact-batch is complete or absent, and the next run gives all."""
    point = (
        "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = {r} /\n"
        "&simulate clearance = 5, cycles = 300 /\n"
    )
    (tmp_path / "many.nml").write_text("".join(point.format(r=0.9 + 0.01 * i) for i in range(20)))
    call = [BIN / "vibroimpact-batch", tmp_path / "many.nml", "-o"]
    begin = time.monotonic()
    subprocess.run([*call, tmp_path / "whole"], check=True, capture_output=True)
    seconds = time.monotonic() - begin
    expected = files_of(tmp_path / "whole")
    out = tmp_path / "out"
    for _ in range(instants):
        shutil.rmtree(out, ignore_errors=True)
        process = subprocess.Popen([*call, out], stdout=subprocess.DEVNULL)
        time.sleep(random.uniform(0, seconds))
        process.kill()
        process.wait()
        whole(out, expected)
    subprocess.run([*call, out], check=True, capture_output=True)
    found = files_of(out)
    assert {name: found[name] for name in expected} == expected


def test_links_in_a_store(nursery, tmp_path):
    """In a folder that another user has made, no link leads a campaign to other files."""
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("x")
    for name in ("lock", "0123456789abcdef.part", "results.zarr", "sums", "failures"):
        store = tmp_path / name.partition(".")[0]
        store.mkdir()
        (store / name).symlink_to(mine / "thesis.txt" if name == "lock" else mine)
        status, output = nursery.run(store)
        assert "Traceback" not in output
        assert status == (1 if ".part" in name else 2)
        assert ".part" in name or str(store) in output
        assert files_of(mine) == {"thesis.txt": b"x"}


# -- disks


@pytest.fixture
def small_disk(tmp_path):
    """A folder on a file system of 400 KiB, if the system permits mounting one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    call = ["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", str(disk)]
    if shutil.which("mount") is None or subprocess.run(call, capture_output=True).returncode != 0:
        pytest.skip("no small file system can be mounted here")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


def test_full_disk(nursery, undisturbed, small_disk):
    """One line reports the full disk; finished work is kept; with more room the same call completes the store."""
    store = small_disk / "store"
    for _ in range(2):
        status, output = nursery.run(store)
        assert status == 2
        assert output == (
            f"vibroimpact campaign: {store}: No space left on device; "
            "the folder and the disk must be writable\n"
        )
        whole(store, undisturbed[0])
        assert 0 < vi.Campaign(store).finished.sum() < 80
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    nursery.run(store)
    assert files_of(store) == undisturbed[0]


def test_read_only_disk(nursery, undisturbed, small_disk):
    """A finished or half-finished store can be read on a read-only file system, and is not changed."""
    store = small_disk / "store"
    nursery.run(store)
    before = files_of(store)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    status, output = nursery.run(store)
    assert (status, output.count("\n"), "Read-only file system; the folder" in output) == (
        2,
        1,
        True,
    )
    found = vi.Campaign(store)
    refused = found.refused
    assert found[next(i for i in np.flatnonzero(found.finished) if i not in refused)].to_dict()
    assert files_of(store) == before
    status, output = nursery.run(small_disk / "another")
    assert (status, output.count("\n"), "Read-only file system; the folder" in output) == (
        2,
        1,
        True,
    )


def test_a_folder_that_vanishes(tmp_path):
    """If a store is removed while a campaign writes to it, there is one error, and the store is not made again."""
    store = tmp_path / "store"

    def remove(share, note):
        """Remove the store half way through the work."""
        if share > 0.4:
            shutil.rmtree(store, ignore_errors=True)

    with pytest.raises(OSError, match="No such file or directory"):
        vi.campaign(small_sweep(), store, chunk=1, threads=1, progress=remove)
    assert not store.exists()


# -- the clock


def test_clock_jumps(tmp_path, monkeypatch):
    """Neither a clock that jumps by decades nor file dates in the future or past change anything."""
    sweep = small_sweep()
    vi.campaign(sweep, tmp_path / "whole", chunk=2)
    random = np.random.default_rng(1)
    with monkeypatch.context() as patch:
        patch.setattr(time, "time", lambda: float(random.uniform(-1e9, 4e9)))
        shares = []
        vi.campaign(
            sweep, tmp_path / "store", chunk=2, progress=lambda share, note: shares.append(share)
        )
    assert shares == sorted(shares)
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")
    for decades in (-4, 4):
        for path in (tmp_path / "store").rglob("*"):
            at = time.time() + decades * 3e8
            os.utime(path, (at, at))
        before = {path: path.stat().st_mtime_ns for path in (tmp_path / "store").rglob("0")}
        vi.campaign(sweep, tmp_path / "store", chunk=2)
        assert before == {path: path.stat().st_mtime_ns for path in before}


# -- two clients


def test_two_clients(nursery, tmp_path):
    """The second client is refused, names the first one, and changes nothing; a killed client leaves no lock."""
    store = tmp_path / "store"
    long = tmp_path / "long.nml"
    long.write_text(SWEEP.replace("counts = 2, 5, 8", "counts = 2, 50, 80"))
    first = Nursery(tmp_path)
    process = first.start(store, file=long)
    wait_for(lambda: list(store.glob("sums/*.json")))
    os.kill(process, signal.SIGSTOP)
    try:
        before = files_of(store)
        status, output = nursery.run(store, file=long)
        assert status == 2
        assert f"process {process} on {os.uname().nodename} is writing to it; wait" in output
        assert files_of(store) == before
    finally:
        os.kill(process, signal.SIGKILL)
        first.end()
        first.process.stdin.close()
        first.process.wait()
    process = nursery.start(store, file=long)
    done = len(list(store.glob("sums/*.json")))
    wait_for(lambda: len(list(store.glob("sums/*.json"))) > done)
    os.kill(process, signal.SIGTERM)
    status, output = nursery.end()
    assert (status, f"interrupted; finished results are kept: {store}" in output) == (1, True)


# -- a cluster


def dask(kind, *words):
    """A scheduler or a worker of dask in its own process group."""
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{kind}", *map(str, words)],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip


def kill(process):
    """Kill a process and its children at once."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def wait_for(condition, process=None, seconds=60):
    """Wait until a condition holds, or the process has ended."""
    end = time.monotonic() + seconds
    while not condition() and (process is None or process.poll() is None):
        assert time.monotonic() < end, "too late"
        time.sleep(0.01)


@pytest.fixture
def scheduler(tmp_path):
    """A scheduler on loopback, and its address."""
    pytest.importorskip("distributed")
    file = tmp_path / "scheduler.json"
    process = dask(
        "scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--dashboard-address",
        "127.0.0.1:0",
        "--scheduler-file",
        file,
    )
    wait_for(lambda: file.exists() and file.read_text().endswith("}"), process)
    yield process, json.loads(file.read_text())["address"]
    kill(process)


#: A client of a cluster in a separate process: the store and the address are its arguments.
CLIENT = """
import sys
sys.path.insert(0, sys.argv[3])
import test_faults, vibroimpact as vi
vi.campaign(test_faults.grid(), sys.argv[1], sys.argv[2], chunk=8)
"""


def grid():
    """The campaign that runs on the cluster."""
    axes = {"r": np.linspace(0.9, 1.1, 20), "clearance": np.geomspace(2, 200, 20)}
    return vi.Sweep(equispaced_case(), axes)


def kill_client(store, address):
    """Kill a client of a cluster as soon as its first chunk is finished."""
    client = subprocess.Popen(
        [sys.executable, "-c", CLIENT, store, address, Path(__file__).parent],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip
    try:
        wait_for(lambda: list(store.glob("sums/*.json")), client)
    finally:
        kill(client)
    assert vi.Campaign(store).finished.any()


def test_a_cluster_that_is_killed(scheduler, tmp_path):
    """Workers with another core are refused; killing a client, and then a scheduler, loses nothing."""
    process, address = scheduler
    sweep = grid()
    vi.campaign(sweep, tmp_path / "whole", chunk=8)
    (tmp_path / "another.py").write_text(
        "import vibroimpact.campaigns.chunk as chunk\nchunk.core_digest = lambda: 'another'\n"
    )
    words = [address, "--no-dashboard", "--nthreads", 1, "--local-directory", tmp_path]
    worker = dask("worker", *words, "--no-nanny", "--preload", tmp_path / "another.py")
    try:
        with pytest.raises(vi.ParameterError, match="install the same vibroimpact on both"):
            vi.campaign(sweep, tmp_path / "store", address, chunk=8)
    finally:
        kill(worker)
    assert not vi.Campaign(tmp_path / "store").finished.any()
    worker = dask("worker", *words, "--no-nanny")
    kill_client(tmp_path / "killed", address)
    vi.campaign(sweep, tmp_path / "killed", address, chunk=8)
    assert files_of(tmp_path / "killed") == files_of(tmp_path / "whole")

    def interrupt(share, note):
        """Kill the scheduler after a third of the work."""
        if share > 0.3:
            kill(process)

    try:
        begin = time.monotonic()
        with pytest.raises(
            vi.ClusterError, match="the connection to the scheduler of the cluster was lost"
        ):
            vi.campaign(sweep, tmp_path / "store", address, chunk=8, progress=interrupt)
        assert time.monotonic() - begin < 90
    finally:
        kill(worker)
    kept = vi.Campaign(tmp_path / "store").finished
    assert kept.any()
    assert not kept.all()
    whole(tmp_path / "store", files_of(tmp_path / "whole"))
    with pytest.raises(vi.ParameterError, match="no scheduler answers there"):
        vi.campaign(sweep, tmp_path / "store", address, chunk=8)
    vi.campaign(sweep, tmp_path / "store", chunk=8)
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


@pytest.mark.parametrize("place", ["sums/{}.json", "results.zarr/{}"])
@pytest.mark.parametrize("kind", ["folder", "file"])
def test_something_else_in_place_of_a_file(place, kind, undisturbed, tmp_path):
    """A folder in place of a checksum, or a file in place of a chunk, is damage: what it belongs to is computed
    again."""
    vi.campaign(small_sweep(), tmp_path / "store", chunk=20)
    expected = files_of(tmp_path / "store")
    name = next(iter((tmp_path / "store" / "sums").iterdir())).stem
    path = tmp_path / "store" / place.format(name)
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink()
    if kind == "folder":
        (path / "inner").mkdir(parents=True)
    else:
        path.write_text("x")
    campaign = vi.Campaign(tmp_path / "store")
    with pytest.raises(vi.ParameterError):
        campaign.values("motions", "attenuation")
    vi.campaign(small_sweep(), tmp_path / "store", chunk=20)
    assert files_of(tmp_path / "store") == expected
    (tmp_path / "store" / "campaign.json").unlink()
    (tmp_path / "store" / "campaign.json").mkdir()
    with pytest.raises(vi.ParameterError, match=r"campaign\.json: is damaged"):
        vi.Campaign(tmp_path / "store")


def test_a_cluster_that_does_not_start(tmp_path, monkeypatch):
    """A worker that is killed when it starts gives one error of the package."""
    distributed = pytest.importorskip("distributed")

    def killed(**_):
        raise RuntimeError("Nanny failed to start.")

    monkeypatch.setattr(distributed, "LocalCluster", killed)
    with pytest.raises(
        vi.ClusterError,
        match=r"client = 'local': its processes did not start \(RuntimeError: Nanny",
    ):
        vi.campaign(small_sweep(), tmp_path / "store", "local", chunk=20)
