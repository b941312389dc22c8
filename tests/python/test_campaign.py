"""Campaigns: stores depend neither on the machine that computed them nor on interruptions."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
import vibroimpact as vi
from shared_campaign import SWEEP, command, equispaced_case, files_of, small_sweep
from vibroimpact.campaigns.chunk import compute
from vibroimpact.campaigns.run import _workers
from vibroimpact.campaigns.store import Store
from vibroimpact.commands.campaign import EXAMPLE

pytest.importorskip("zarr")


@pytest.fixture
def sweep_file(tmp_path):
    """A namelist with a sweep of 96 cases."""
    path = tmp_path / "sweep.nml"
    path.write_text(SWEEP)
    return path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """The store of that file, computed in one go."""
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "sweep.nml").write_text(SWEEP)
    process = command(folder / "sweep.nml", "--store", folder / "store")
    assert process.communicate(timeout=300)[0] == "sweep: 96 of 96 cases of motion finished\n"
    assert process.returncode == 0
    return folder / "store"


def test_example_of_the_command(tmp_path):
    """The example in the help runs as printed."""
    path = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(EXAMPLE, shell=True, check=True, cwd=tmp_path, env=os.environ | path)
    assert vi.Campaign(tmp_path / "store").finished.all()


@pytest.mark.slow
def test_stores_do_not_depend_on_threads(tmp_path, undisturbed):
    """A continued campaign has the same files byte for byte, and computes nothing twice."""
    (case,) = vi.read_namelist(undisturbed.parent / "sweep.nml")
    sweep = vi.Sweep.of_case(case)
    for threads in (1, 3):
        vi.campaign(sweep, tmp_path / str(threads), threads=threads)
        assert files_of(tmp_path / str(threads)) == files_of(undisturbed)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "1").rglob("0")}
    vi.campaign(sweep, tmp_path / "1")
    assert before == {path: path.stat().st_mtime_ns for path in (tmp_path / "1").rglob("0")}


@pytest.mark.slow
def test_stores_do_not_depend_on_the_cluster(tmp_path, sweep_file, undisturbed):
    """Processes on a cluster give the same files."""
    pytest.importorskip("distributed")
    process = command(sweep_file, "--store", tmp_path / "store", "--cluster", "local")
    process.communicate(timeout=300)
    assert process.returncode == 0
    assert files_of(tmp_path / "store") == files_of(undisturbed)


@pytest.mark.slow
def test_a_local_cluster_is_for_its_user(monkeypatch):
    """Other users of the machine lack its certificate and cannot connect; its files are in a private folder."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(os, "cpu_count", lambda: 1)
    with _workers("local", None) as workers:
        client = workers.client
        address = client.scheduler.address
        assert address.startswith("tls://127.0.0.1:")
        (folder,) = client.run(lambda dask_worker: dask_worker.local_directory).values()
        assert Path(folder).parent.parent.stat().st_mode & 0o077 == 0
        for text in (address, address.replace("tls", "tcp")):
            with pytest.raises((OSError, RuntimeError, TypeError, ValueError)):
                distributed.Client(text, timeout=2, set_as_default=False)
    assert not Path(folder).exists()


@pytest.mark.slow
def test_the_dashboard_answers_its_own_page(monkeypatch, capfd):
    """The dashboard listens on loopback only; foreign host names, other sites and other ports get no page."""
    pytest.importorskip("distributed")
    pytest.importorskip("bokeh")
    monkeypatch.setattr(os, "cpu_count", lambda: 1)

    def status(url, **headers):
        try:
            with urllib.request.urlopen(
                urllib.request.Request(url, headers=headers), timeout=20
            ) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code

    with _workers("local", None) as workers:
        link = re.search("dashboard: (.*)", capfd.readouterr().err)[1]
        port = urlsplit(link).port
        assert link == f"http://127.0.0.1:{port}/status"
        assert status(link) == 200
        assert status(link.replace("127.0.0.1", "localhost")) == 200
        for page in (
            link,
            f"http://127.0.0.1:{port}/",
            f"http://127.0.0.1:{port}/json/counts.json",
        ):
            assert status(page, Host="evil.example") == 403
            assert status(page, Host=f"evil.example:{port}") == 403
            assert status(page, Origin="http://evil.example") == 403
            assert status(page, **{"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "cors"}) == 403
        ports = workers.client.run(lambda dask_worker: dask_worker.http_server.port)
        for number in ports.values():
            for page in ("", "health", "metrics", "status", "info/main/workers.html"):
                assert status(f"http://127.0.0.1:{number}/{page}") == 404


@pytest.mark.slow
@pytest.mark.faults
def test_a_killed_worker(tmp_path):
    """If a worker is killed, another one computes its cases, and the store equals the undisturbed one."""
    distributed = pytest.importorskip("distributed")
    sweep = vi.Sweep(
        equispaced_case(), {"r": np.linspace(0.9, 1.1, 12), "clearance": np.geomspace(2, 200, 25)}
    )
    vi.campaign(sweep, tmp_path / "whole", chunk=25)
    killed = []
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):

        def kill(share, note):
            """Kill one worker at a third of the work."""
            if share > 0.3 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        vi.campaign(sweep, tmp_path / "store", client, chunk=25, progress=kill)
    assert killed
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


#: A case that takes some seconds.
LONG = """&system
  xi = 0.0114
  mu = 0.028
  restitution = 0.75, 0.75
  r = 1
/
&lyapunov
  clearance = 20
  cycles = 1200000
/
"""


@pytest.mark.slow
@pytest.mark.faults
def test_a_case_whose_workers_are_killed(tmp_path):
    """A case whose workers are killed is left as a namelist with the reason; a later run computes it."""
    distributed = pytest.importorskip("distributed")
    dask = pytest.importorskip("dask")
    vi.campaign([LONG], tmp_path / "whole")
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        (worker,) = client.run(os.getpid).values()
        threading.Timer(0.5, os.kill, (worker, signal.SIGKILL)).start()
        found = vi.campaign([LONG], tmp_path / "store", client)
    assert not found.finished.any()
    (failure,) = found.failures.glob("*.nml")
    assert "each worker that computed it was killed" in failure.read_text()
    assert vi.read_namelist(failure)[0].study == "lyapunov"
    found = vi.campaign([LONG], tmp_path / "store")
    assert found.finished.all()
    assert not list(found.failures.glob("*.nml"))
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_stopped_client(tmp_path, sweep_file, undisturbed, number):
    """A campaign stopped at random times, and restarted, ends with the same files."""
    random = np.random.default_rng(int(number))
    store = tmp_path / "store"
    stopped = 0

    def done():
        return len(list(store.glob("sums/*.json")))

    for wanted in (1, 5, 9, 15):
        # not while Python starts, before it runs any line of the package
        least = max(wanted, done() + 1)
        process = command(sweep_file, "--store", store)
        while done() < least and process.poll() is None:
            time.sleep(0.005)
        time.sleep(float(random.uniform(0, 0.05)))
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        stopped += process.returncode != 0
        assert "Traceback" not in errors
    assert stopped >= 2
    process = command(sweep_file, "--store", store)
    process.communicate(timeout=300)
    assert process.returncode == 0
    assert files_of(store) == files_of(undisturbed)


def test_damage_is_seen(tmp_path):
    """After a changed byte or a lost file the chunk is computed again; reading it is an error."""
    sweep = small_sweep()
    vi.campaign(sweep, tmp_path / "whole", chunk=3)
    for damage in ("byte", "file", "sums"):
        vi.campaign(sweep, tmp_path / "store", chunk=3)
        (array,) = sorted((tmp_path / "store" / "results.zarr").glob("*6-*/motions/attenuation/0"))
        if damage == "byte":
            content = bytearray(array.read_bytes())
            content[len(content) // 2] ^= 1
            array.write_bytes(content)
        elif damage == "file":
            array.unlink()
        else:
            (path,) = (tmp_path / "store" / "sums").glob("*6-*")
            path.write_text("{")
        with pytest.raises(vi.ParameterError, match="is damaged; run the campaign again"):
            vi.Campaign(tmp_path / "store")[6]
        vi.campaign(sweep, tmp_path / "store", chunk=3)
        assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


def test_two_writers(tmp_path):
    """A second writer is refused, with a message that identifies the first one."""
    sweep = small_sweep()
    plan = Store(tmp_path / "store")
    vi.campaign(sweep, tmp_path / "store")
    record = plan.plan()
    with (
        plan.writing(record),
        pytest.raises(vi.ParameterError, match=f"process {os.getpid()} on .* is writing to it"),
    ):
        vi.campaign(sweep, tmp_path / "store")
    vi.campaign(sweep, tmp_path / "store")


def test_another_campaign_is_refused(tmp_path):
    """A store holds one campaign of one build; a folder with other files is not touched."""
    vi.campaign(small_sweep(), tmp_path / "store")
    other = vi.Sweep(equispaced_case(), {"r": [0.9, 1.0]})
    with pytest.raises(vi.ParameterError, match="contains another campaign"):
        vi.campaign(other, tmp_path / "store")
    plan = tmp_path / "store" / "campaign.json"
    plan.write_text(json.dumps(json.loads(plan.read_text()) | {"core": "another"}))
    with pytest.raises(vi.ParameterError, match="a different build of vibroimpact"):
        vi.campaign(small_sweep(), tmp_path / "store")
    plan.write_text("{")
    with pytest.raises(vi.ParameterError, match="is damaged"):
        vi.Campaign(tmp_path / "store")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("x")
    with pytest.raises(vi.ParameterError, match=r"it holds 'thesis\.txt'"):
        vi.campaign(small_sweep(), tmp_path / "mine")
    with pytest.raises(vi.ParameterError, match="must be the store of a campaign"):
        vi.Campaign(tmp_path / "mine")
    with pytest.raises(vi.ParameterError, match="it is a file"):
        vi.campaign(small_sweep(), tmp_path / "mine" / "thesis.txt")


def test_what_is_no_store(tmp_path):
    """Other Zarr stores, invalid paths and damaged plans are refused; a folder among the chunks is ignored."""
    import zarr

    sweep = vi.Sweep(equispaced_case(), {"r": [0.9, 0.95]})
    zarr.create_group(str(tmp_path / "other"))
    with pytest.raises(vi.ParameterError, match=r"it holds 'zarr\.json'"):
        vi.campaign(sweep, tmp_path / "other")
    for path in (None, "", 3):
        with pytest.raises(vi.ParameterTypeError, match="must be the path of a folder"):
            vi.campaign(sweep, path)
    with pytest.raises(vi.ParameterError, match="must not contain a null byte"):
        vi.campaign(sweep, "a\0b")
    store = tmp_path / "größe, 日本 \" '"
    found = vi.campaign(sweep, store)
    (store / "results.zarr" / "mine").mkdir()
    assert len(vi.Campaign(store).refused) == 0
    assert found[1].to_dict() == vi.Campaign(store)[1].to_dict()
    plan = json.loads((store / "campaign.json").read_text())
    for part, message in (
        ({"size": "x"}, "is damaged"), ({"size": -3}, "is damaged"), ({"chunk": 0}, "is damaged"),
        ({"study": "nonsense", "vibroimpact": "9.9"}, "must be read with vibroimpact 9.9"),
        ({"values": {"r": [1]}}, "is damaged"),
    ):  # fmt: skip
        (store / "campaign.json").write_text(json.dumps(plan | part))
        with pytest.raises(vi.ParameterError, match=message):
            vi.Campaign(store)


def test_another_core_is_refused():
    """A worker with another build of the core computes nothing."""
    with pytest.raises(vi.ParameterError, match="install the same vibroimpact on both"):
        compute("motion", [equispaced_case()], digest="another")


@pytest.mark.parametrize(
    ("cases", "options", "error", "message"),
    [
        ([], {}, vi.ParameterError, "cases: is empty"),
        ("&system", {}, vi.ParameterTypeError, "must be a Sweep, or an iterable"),
        ([3], {}, vi.ParameterTypeError, r"cases\[0\] = 3"),
        (["x"], {}, vi.ParameterError, r"cases\[0\] = 'x': must be a complete case"),
        (None, {"chunk": 0}, vi.ParameterError, "chunk = 0"),
        (None, {"threads": 0}, vi.ParameterError, "threads = 0"),
        (None, {"client": "local", "threads": 2}, vi.ParameterError, "threads: must be left out"),
        (None, {"client": 3}, vi.ParameterTypeError, "client = 3"),
        (
            None,
            {"client": "foo://x:1"},
            vi.ParameterError,
            "client = 'foo://x:1': no scheduler answers",
        ),
        (
            None,
            {"client": "nonsense"},
            vi.ParameterError,
            "must be an address such as tcp://node1:8786",
        ),
        (None, {"progress": 3}, vi.ParameterTypeError, "progress = 3"),
    ],
)
def test_bad_campaigns(tmp_path, cases, options, error, message):
    """Invalid arguments are refused before anything is computed."""
    cases = small_sweep() if cases is None else cases
    with pytest.raises(error, match=message):
        vi.campaign(cases, tmp_path / "store", **options)


def test_time_left(capsys):
    """The time left counts the work of this call, not what the store already had."""
    from vibroimpact.base.progress import Progress, span

    with pytest.MonkeyPatch.context() as patch:
        now = iter([0.0, 1.0, 101.0])
        patch.setattr("vibroimpact.base.progress.time.monotonic", lambda: next(now))
        bar = Progress("work", wanted=True, resumed=True)
        bar.show(0.8)
        bar.show(0.85, "85 of 100 cases")
    assert "101 s, about 303 s left 85 of 100 cases" in capsys.readouterr().err
    assert [span(x) for x in (599.4, 600, 3599, 90000)] == [
        "599 s",
        "10 min",
        "1 h 0 min",
        "25 h 0 min",
    ]


def test_progress_and_an_exception_of_it(tmp_path):
    """The share grows to 1; a campaign interrupted by an exception is continued."""
    shares = []
    vi.campaign(
        small_sweep(),
        tmp_path / "whole",
        chunk=2,
        progress=lambda share, note: shares.append(share),
    )
    assert shares == sorted(shares)
    assert shares[-1] == 1

    def fail(share, note):
        """Raise after half of the work."""
        if share > 0.4:
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        vi.campaign(small_sweep(), tmp_path / "store", chunk=2, threads=1, progress=fail)
    assert not vi.Campaign(tmp_path / "store").finished.all()
    vi.campaign(small_sweep(), tmp_path / "store", chunk=2)
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


def test_cases_of_a_structure(tmp_path):
    """A store of an earlier version, which identified the model by the study name, is read; models never mix."""
    wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    text = vi.lyapunov(wall, vi.Load(1.0, cosine=[1]), cycles=40, batches=4).to_namelist()
    found = vi.campaign([text, text], tmp_path / "store")
    leading = found.values("exponents", "per_cycle", "first")
    assert leading[0] == leading[1] == found[0].per_cycle[0]
    plan = tmp_path / "store" / "campaign.json"
    record = json.loads(plan.read_text(encoding="utf-8"))
    assert (record["study"], record.pop("of_structure")) == ("lyapunov", True)
    plan.write_text(json.dumps(record | {"study": "lyapunov_structure"}), encoding="utf-8")
    again = vi.Campaign(tmp_path / "store")
    assert again.study == "lyapunov"
    assert (again.values("exponents", "per_cycle", "first") == leading).all()
    other = vi.equispaced(vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), 0.94, 37)[0]
    with pytest.raises(vi.ParameterError, match=r"^cases\[1\]: must be of the same model"):
        vi.campaign([text, other.to_namelist()], tmp_path / "mixed")
