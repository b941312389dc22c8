"""Campaigns: stores are those of single calls, whatever computed them and however often they were stopped."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import door
from vibroimpact.campaigns.chunk import compute
from vibroimpact.campaigns.run import _workers
from vibroimpact.campaigns.store import Store
from vibroimpact.commands.campaign import EXAMPLE
from vibroimpact.noun import RESULTS

pytest.importorskip("zarr")

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
SWEEP = """&system
  xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1
/
&motion
  kind = 'equispaced', clearance = 20
/
&sweep
  keys = 'r', 'clearance', low = 0.9, 2, high = 1.1, 200, counts = 8, 12, spacing = 'linear', 'geometric'
/
"""


def equispaced_case():
    """A case with one or two motions."""
    return vi.equispaced(OSC, r=1.0, clearance=20.0)[0].to_namelist()


def small_sweep():
    """Cases of which some have no motion."""
    return vi.Sweep(
        equispaced_case(), {"r": [0.9, 1.0, 1.1], "clearance": [5.0, 20.0, 80.0, 500.0]}
    )


def files_of(folder):
    """All files of a store with their bytes."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*")) if path.is_file()
    }  # fmt: skip


def command(*words, **options):
    """The program in its own process."""
    return subprocess.Popen(
        [Path(sys.executable).parent / "vibroimpact", "campaign", *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **options,
    )  # fmt: skip


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


# -- the sweep


def test_cases_of_a_grid():
    """Each case is the template with its values, in the order of a C array."""
    sweep = small_sweep()
    assert sweep.shape == (3, 4)
    for i in range(len(sweep)):
        point = sweep.point(i)
        row, column = np.unravel_index(i, sweep.shape)
        assert point == {
            "system.r": [0.9, 1.0, 1.1][row], "motion.clearance": [5.0, 20.0, 80.0, 500.0][column],
        }  # fmt: skip
        (case,) = [vi.case.case_of(sweep.text(i))]
        assert (case.r, case.keys["clearance"]) == (point["system.r"], point["motion.clearance"])


def test_a_key_that_the_template_lacks_is_added():
    """An optional key of a group may be swept."""
    sweep = vi.Sweep(equispaced_case(), {"acceptance": [0.01, 0.02]})
    assert sweep.text(1).count("acceptance = 0.02\n/") == 1


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
def test_points_fill_the_box(method):
    """Each of 64 equal parts of each side has one point; the logarithm of a geometric key is spread evenly."""
    sweep = vi.Sweep(
        equispaced_case(), {"r": (0.9, 1.1), "clearance": (2, 200)}, samples=64, method=method, seed=3,
        geometric=["clearance"],
    )  # fmt: skip
    unit = np.stack(
        [(sweep.points[:, 0] - 0.9) / 0.2, np.log(sweep.points[:, 1] / 2) / np.log(100)]
    )
    for side in unit:
        assert sorted(np.floor(side * 64).astype(int)) == list(range(64))
    again = vi.Sweep.of_record(json.loads(json.dumps(sweep.record)))
    np.testing.assert_array_equal(again.points, sweep.points)


def test_points_are_made_in_blocks(monkeypatch):
    """Blocks of any size, asked for in any order, give the same points; a billion are not held."""
    box = {"r": (0.9, 1.1), "clearance": (2, 200)}
    whole = vi.Sweep(equispaced_case(), box, samples=1000, seed=3)
    points, texts = whole.points, [whole.text(i) for i in range(1000)]
    monkeypatch.setattr("vibroimpact.campaigns.sweep.BLOCK", 64)
    parts = vi.Sweep(equispaced_case(), box, samples=1000, seed=3)
    np.testing.assert_array_equal(parts.points, points)
    for i in (999, 0, 500, 63, 64, 128):
        assert parts.text(i) == texts[i]
    many = vi.Sweep(equispaced_case(), box, samples=10**9, seed=3)
    assert list(many.point(999).values()) == points[999].tolist()
    assert many.point(10**6) != many.point(10**6 + 1)
    with pytest.raises(vi.ParameterError, match="samples = 1073741824: must be"):
        vi.Sweep(equispaced_case(), box, samples=2**30, method="latin_hypercube")


def test_a_huge_grid(tmp_path):
    """Nothing holds all cases: a campaign of 10^12 starts, stops, and tells how far it is."""
    keys = {"xi": (0.001, 0.1), "mu": (0.01, 0.1), "r": (0.9, 1.1), "clearance": (2, 200)}
    sweep = vi.Sweep(
        equispaced_case(), {key: np.linspace(*ends, 1000) for key, ends in keys.items()}
    )
    assert len(sweep) == 10**12
    assert sweep.point(10**12 - 1) == {
        key: end for key, (_, end) in zip(sweep.keys, keys.values(), strict=True)
    }

    def stop(share, note):
        """Stop after the first chunk."""
        if share:
            raise RuntimeError(note)

    with pytest.raises(RuntimeError, match="of 1000000000000 cases"):
        vi.campaign(sweep, tmp_path / "store", chunk=4, threads=1, progress=stop)
    found = vi.Campaign(tmp_path / "store")
    assert 0 < found._done() <= 12
    assert f": {found._done()} of 1000000000000 cases finished" in repr(found)
    assert found[0].to_dict()
    with pytest.raises(vi.OutOfMemoryError, match=r"10{12} cases takes more memory"):
        found.values("motions", "attenuation")


@pytest.mark.parametrize(
    ("values", "options", "message"),
    [
        ({"xii": [1.0]}, {}, "'xii' is not a key of the case; must be one of system.xi, "),
        ({}, {}, "must be a mapping with at least one key"),
        ({"xi": []}, {}, "is empty; must hold at least one value"),
        ({"xi": [0.1, 0.1]}, {}, "must hold each value once"),
        ({"xi": [0.1], "system.xi": [0.2]}, {}, "system.xi is given twice"),
        ({"xi": (0.1, 0.2, 0.3)}, {"samples": 4}, "must be two numbers"),
        ({"xi": (0.2, 0.1)}, {"samples": 4}, "must be two numbers with low < high"),
        ({"xi": (0.0, 0.1)}, {"samples": 4, "geometric": ["xi"]}, "0 < low < high"),
        ({"xi": (0.1, 0.2)}, {"samples": 4, "method": "halton"}, "'sobol' or 'latin_hypercube'"),
        ({"xi": (0.1, 0.2)}, {"samples": 0}, "samples = 0"),
        ({"xi": [0.1]}, {"geometric": ["xi"]}, "geometric: needs samples"),
        ({"xi": [float("nan")]}, {}, "nan must be a finite number"),
        ({"xi": (0.1, float("inf"))}, {"samples": 3}, "inf must be a finite number"),
        ({"xi": (0.1, 0.2)}, {"samples": 10**12}, "1 <= samples <= 1073741824"),
        ({"XI": [0.1]}, {}, "'XI' is not a key of the case"),
        ({"response.states": [3]}, {}, "'response.states' is not a key of the case"),
    ],
)
def test_bad_sweeps(values, options, message):
    """One error names the key and what is allowed."""
    with pytest.raises(vi.ParameterError) as caught:
        vi.Sweep(equispaced_case(), values, **options)
    assert message in str(caught.value)


@pytest.mark.parametrize("value", [True, None, 1j, object()])
def test_values_of_a_wrong_type(value):
    """Only numbers and texts can stand in a namelist."""
    with pytest.raises(vi.ParameterTypeError, match="values"):
        vi.Sweep(equispaced_case(), {"xi": [value]})


@pytest.mark.parametrize("geometric", ["xi", None, 3])
def test_geometric_is_a_sequence(geometric):
    """A text is none."""
    with pytest.raises(vi.ParameterTypeError, match="must be a sequence of keys"):
        vi.Sweep(equispaced_case(), {"xi": (0.1, 0.2)}, samples=2, geometric=geometric)


@pytest.mark.parametrize(
    "case",
    [
        "", "&system\n/\n", "&system xi = 1 /", "nonsense", equispaced_case().upper(),
        equispaced_case().replace("mu = ", "mu = 0.02 ! "), equispaced_case().replace("\n  mu", "  mu"),
        equispaced_case().replace("'equispaced'", "'equispaced' ! kind"),
        equispaced_case().replace("&motion", "&nonsense"),
    ],
)  # fmt: skip
def test_a_template_that_is_no_case(case):
    """The template must be complete and canonical."""
    with pytest.raises(vi.ParameterError, match="must be a complete case"):
        vi.Sweep(case, {"xi": [0.1]})


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("keys = 'xi'", "values: must be given, or words, or low and high"),
        ("keys = 'xi', low = 0.1", "high: must be given with low"),
        ("keys = 'xi', low = 0.1, high = 0.2", "counts: must be given"),
        (
            "keys = 'xi', 'mu', values = 0.1, 0.2, counts = 1, 2",
            "counts = [1, 2]: must be the number",
        ),
        ("keys = 'xi', 'mu', low = 1, 2, 3, high = 4", "low: has 3 values"),
        ("keys = 'xi', high = 4", "high"),
        (
            "keys = 'xi', values = 1\n/\n&sweep\n  keys = 'mu', values = 1",
            "&sweep: stands after &sweep; must",
        ),
        ("keys = 'xi', values = nan", "nan"),
        ("keys = 'xi', 'system.xi', values = 1, 2, counts = 1, 1", "system.xi is given twice"),
        ("keys = 'xi', values = 1, samples = 3", "samples"),
    ],
)
def test_bad_groups(tmp_path, line, message):
    """Lists of a &sweep that do not fit together."""
    path = tmp_path / "bad.nml"
    path.write_text(SWEEP.split("&sweep")[0] + f"&sweep\n  {line}\n/\n")
    process = command(path, "--store", tmp_path / "store")
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 2
    assert message in errors
    assert not (tmp_path / "store").exists()


def test_a_sweep_after_the_output(tmp_path):
    """The place of the group is named."""
    path = tmp_path / "bad.nml"
    path.write_text(SWEEP.replace("&sweep", "&output name = 'a' /\n&sweep"))
    with pytest.raises(vi.ParameterError, match="stands after &output; must stand once"):
        vi.read_namelist(path)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("keys = 'xi', 'r', values = 0.1, 0.2, 0.9, 1, 1.1, counts = 2, 3",
         {"xi": [0.1, 0.2], "r": [0.9, 1.0, 1.1]}),
        ("keys = 'xi', values = 0.1, 0.2", {"xi": [0.1, 0.2]}),
        ("keys = 'precision', words = 'single', 'double'", {"precision": ["single", "double"]}),
        ("keys = 'r', low = 0.9, high = 1.1, counts = 3", {"r": vi.spaced(0.9, 1.1, 3)}),
        ("keys = 'xi', low = 0.001, high = 0.1, counts = 3, spacing = 'geometric'",
         {"xi": vi.spaced(0.001, 0.1, 3, "geometric")}),
    ],
)  # fmt: skip
def test_groups_are_sweeps(tmp_path, line, values):
    """A &sweep gives the cases of the same sweep in Python."""
    path = tmp_path / "sweep.nml"
    path.write_text(SWEEP.split("&sweep")[0] + f"&sweep\n  {line}\n/\n")
    (case,) = vi.read_namelist(path)
    found = vi.Sweep.of_case(case)
    expected = vi.Sweep(found.template, values)
    assert len(found) == len(expected)
    assert [found.text(i) for i in range(len(found))] == [
        expected.text(i) for i in range(len(found))
    ]


def test_a_box_of_a_group(tmp_path):
    """Points of a &sweep are those of the same box in Python."""
    path = tmp_path / "sweep.nml"
    path.write_text(
        SWEEP.split("&sweep")[0]
        + "&sweep\n  keys = 'xi', 'r', low = 0.001, 0.9, high = 0.1, 1.1, samples = 8, "
        "method = 'latin_hypercube', seed = 5, spacing = 'geometric', 'linear'\n/\n"
    )
    found = vi.Sweep.of_case(vi.read_namelist(path)[0])
    expected = vi.Sweep(
        found.template, {"xi": (0.001, 0.1), "r": (0.9, 1.1)}, samples=8, method="latin_hypercube", seed=5,
        geometric=["xi"],
    )  # fmt: skip
    np.testing.assert_array_equal(found.points, expected.points)


def test_a_sweep_is_left_to_the_command(sweep_file):
    """The compiled program says what runs it, and writes nothing."""
    folder = sweep_file.parent / "results"
    log = vi.run_namelists([sweep_file], folder)
    assert log.status == 1
    assert "vibroimpact campaign" in log.lines[0][1]
    assert not list(folder.glob("*.csv"))


def test_example_of_the_command(tmp_path):
    """The example in the help runs as printed."""
    path = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    subprocess.run(EXAMPLE, shell=True, check=True, cwd=tmp_path, env=os.environ | path)
    assert vi.Campaign(tmp_path / "store").finished.all()


# -- results


INPUTS = Path(__file__).resolve().parents[2] / "inputs"


def texts_of(study):
    """Cases of a study with one row, with many tables, and of a structure."""
    if study == "motion":
        return [small_sweep().text(i) for i in range(12)]
    if study == "zone":
        zone = vi.zone(OSC, "RL", (0.8, 1.2), (2.0, 200.0), symmetric=True)
        return [zone.to_namelist()]
    return [case.text for case in vi.read_namelist(INPUTS / f"{study}.nml")]


@pytest.mark.parametrize("study", ["motion", "find", "zone", "structure_wall", "decay", "lyapunov"])
def test_results_are_those_of_single_calls(tmp_path, study):
    """Every table, with its bits, remarks and notes."""
    texts = texts_of(study)
    vi.campaign(texts, tmp_path / "store", chunk=2)
    found = vi.Campaign(tmp_path / "store")
    assert found.finished.all()
    for i, text in enumerate(texts):
        direct = door.run_text(RESULTS[found.study], text)
        assert found[i].to_dict() == direct.to_dict()


def test_values(tmp_path):
    """Reductions over the rows of each case are those of the single results; NaN where there is no motion."""
    sweep = small_sweep()
    found = vi.campaign(sweep, tmp_path / "store", chunk=5)
    for reduce, function in (
        ("min", min),
        ("max", max),
        ("count", len),
        ("first", lambda rows: rows[0]),
    ):
        values = found.values("motions", "attenuation", reduce)
        assert values.shape == sweep.shape
        for i, value in enumerate(values.ravel()):
            rows = [motion.attenuation for motion in found[i].parts()]
            rows = [row for row in rows if row == row]
            assert value == function(rows) if rows else np.isnan(value)
    assert np.isnan(found.values("motions", "attenuation")).any()
    array = found.to_xarray("motions", "attenuation", "min")
    assert array.dims == ("system.r", "motion.clearance")
    assert (
        float(array.sel({"system.r": 1.0, "motion.clearance": 20.0}))
        == found.values("motions", "attenuation", "min")[1, 1]
    )
    with pytest.raises(vi.ParameterError, match="must be one of motions"):
        found.values("motions", "nothing")
    with pytest.raises(vi.ParameterError, match="single real numbers"):
        found.values("motions", "multipliers")
    with pytest.raises(vi.ParameterTypeError, match="'yes': must be a number, True or False"):
        found.values("motions", "attenuation", where={"stable": "yes"})
    with pytest.raises(vi.ParameterTypeError, match="must be a mapping"):
        found.values("motions", "attenuation", where=["stable"])


def test_refused_cases_are_kept(tmp_path):
    """A case that the study refuses becomes a namelist that gives the same message."""
    sweep = vi.Sweep(equispaced_case(), {"xi": [0.0, 0.01], "r": [0.9, 1.0]})
    found = vi.campaign(sweep, tmp_path / "store")
    assert list(found.refused) == [1]
    assert "resonance without damping" in found.refused[1]
    with pytest.raises(vi.ParameterError, match="resonance without damping"):
        found[1]
    (path,) = found.failures.iterdir()
    with pytest.raises(vi.ParameterError, match="resonance without damping"):
        vi.read_namelist(path)


def test_failed_cases_run_again(tmp_path):
    """What a campaign leaves of a refused case is run by the program, with the same message."""
    sweep = vi.Sweep(equispaced_case(), {"xi": [0.0, 0.01], "r": [0.9, 1.0]})
    found = vi.campaign(sweep, tmp_path / "store")
    call = [Path(sys.executable).parent / "vibroimpact-batch", found.failures / "case_1.nml"]
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert found.refused[1] in done.stderr


def test_a_case_that_failed_once(tmp_path, monkeypatch):
    """A chunk without memory leaves its cases; the next call computes it, and they are gone."""
    sweep = small_sweep()
    vi.campaign(sweep, tmp_path / "whole", chunk=4)

    def fail(*_):
        """No memory."""
        raise vi.OutOfMemoryError("no memory today")

    with monkeypatch.context() as patch:
        patch.setattr("vibroimpact.campaigns.chunk.result_of", fail)
        found = vi.campaign(sweep, tmp_path / "store", chunk=4)
    assert not found.finished.any()
    assert len(list(found.failures.iterdir())) == 12
    assert "no memory today" in (found.failures / "case_3.nml").read_text()
    vi.campaign(sweep, tmp_path / "store", chunk=4)
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")


def test_a_defect_costs_its_case_alone(tmp_path, monkeypatch):
    """An error that is none of the package's own is kept for its case, and the others are computed."""
    from vibroimpact.campaigns import chunk

    right = chunk.result_of

    def fail(study, text, *rest):
        """A defect in one case."""
        if "500.0" in text and "r = 1.1" in text:
            raise IndexError("a defect")
        return right(study, text, *rest)

    monkeypatch.setattr(chunk, "result_of", fail)
    found = vi.campaign(small_sweep(), tmp_path / "store", chunk=4)
    assert found.refused == {11: "IndexError: a defect"}
    assert found[10].to_dict()


def test_zarr_reads_it(tmp_path):
    """The store is a Zarr hierarchy, which xarray opens, with the same values."""
    xarray = pytest.importorskip("xarray")
    found = vi.campaign(small_sweep(), tmp_path / "store", chunk=12)
    tree = xarray.open_datatree(
        tmp_path / "store" / "results.zarr", engine="zarr", consolidated=False
    )
    (name,) = tree.children
    rows = tree[name]["motions"].to_dataset()
    expected = [motion.attenuation for i in range(12) for motion in found[i].parts()]
    values = rows["attenuation"].values
    np.testing.assert_array_equal(values[~np.isnan(values)], expected)
    assert sorted(set(rows["case"].values)) == list(range(12))


@pytest.mark.parametrize("study", ["motion", "find", "zone", "structure_wall"])
def test_all_rows_of_a_table(tmp_path, study):
    """They are the rows of the single results, one after the other, whatever the size of chunks."""
    pytest.importorskip("xarray")
    texts = texts_of(study)
    found = vi.campaign(texts, tmp_path / "store", chunk=1 if len(texts) < 5 else 5)
    results = [found[i]._result for i in range(len(texts))]
    for table in {name: None for result in results for name in result.tables}:
        rows = found.to_xarray(table)
        sizes = [
            int(np.prod(list(result.tables[table].dims.values()))) if table in result.tables else 0
            for result in results
        ]
        np.testing.assert_array_equal(rows["case"], np.repeat(np.arange(len(texts)), sizes))
        for i, result in enumerate(results):
            part = rows.isel({f"{table}_row": rows["case"].values == i})
            for key, column in result.tables[table].columns.items() if sizes[i] else ():
                values = column.decoded().reshape(sizes[i], -1)
                if column.kind == "complex":
                    there = part[f"{key}_real"].values + 1j * part[f"{key}_imag"].values
                else:
                    there = part[key].values
                there = there.reshape(sizes[i], -1)[:, : values.shape[1]]
                assert (there == values).all() or np.array_equal(there, values, equal_nan=True), key
    with pytest.raises(vi.ParameterError, match="table = 'nothing'"):
        found.to_xarray("nothing")


# -- whatever computes it


def test_stores_do_not_depend_on_threads(tmp_path, undisturbed):
    """The same files, byte by byte, and nothing is computed twice."""
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
def test_a_killed_worker(tmp_path):
    """A worker that is killed: its cases are computed by another one, and the store is the undisturbed one."""
    distributed = pytest.importorskip("distributed")
    sweep = vi.Sweep(
        equispaced_case(), {"r": np.linspace(0.9, 1.1, 12), "clearance": np.geomspace(2, 200, 25)}
    )
    vi.campaign(sweep, tmp_path / "whole", chunk=25)
    killed = []
    with (
        distributed.LocalCluster(
            2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
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


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_stopped_client(tmp_path, sweep_file, undisturbed, number):
    """Stopped at random instants, and started again: the same files in the end."""
    random = np.random.default_rng(int(number))
    store = tmp_path / "store"
    stopped = 0
    for wanted in (1, 5, 9, 15):
        process = command(sweep_file, "--store", store)
        while len(list(store.glob("sums/*.json"))) < wanted and process.poll() is None:
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
    """A byte that changed, or a file that is lost: the chunk is computed again, and reading it is an error."""
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
    """The second one is refused, and says who writes."""
    sweep = small_sweep()
    plan = Store(tmp_path / "store")
    vi.campaign(sweep, tmp_path / "store")
    record = plan.plan()
    with (
        plan.writing(record),
        pytest.raises(vi.ParameterError, match=f"process {os.getpid()} on .* writes to it"),
    ):
        vi.campaign(sweep, tmp_path / "store")
    vi.campaign(sweep, tmp_path / "store")


def test_another_campaign_is_refused(tmp_path):
    """A store holds one campaign of one build; a folder with other files is left alone."""
    vi.campaign(small_sweep(), tmp_path / "store")
    other = vi.Sweep(equispaced_case(), {"r": [0.9, 1.0]})
    with pytest.raises(vi.ParameterError, match="holds another campaign"):
        vi.campaign(other, tmp_path / "store")
    plan = tmp_path / "store" / "campaign.json"
    plan.write_text(json.dumps(json.loads(plan.read_text()) | {"core": "another"}))
    with pytest.raises(vi.ParameterError, match="another build of vibroimpact"):
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
    """Another Zarr store, paths that are none, plans of others, and folders among the chunks."""
    import zarr

    sweep = vi.Sweep(equispaced_case(), {"r": [0.9, 0.95]})
    zarr.create_group(str(tmp_path / "other"))
    with pytest.raises(vi.ParameterError, match=r"it holds 'zarr\.json'"):
        vi.campaign(sweep, tmp_path / "other")
    for path in (None, "", "a\0b", 3):
        with pytest.raises(vi.ParameterTypeError, match="must be the path of a folder"):
            vi.campaign(sweep, path)
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
    """Before anything is computed."""
    cases = small_sweep() if cases is None else cases
    with pytest.raises(error, match=message):
        vi.campaign(cases, tmp_path / "store", **options)


def test_time_left(capsys):
    """The time left counts what this call does, not what the store had."""
    from vibroimpact.progress import Progress, span

    with pytest.MonkeyPatch.context() as patch:
        now = iter([0.0, 1.0, 101.0])
        patch.setattr("vibroimpact.progress.time.monotonic", lambda: next(now))
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
    """The share grows to 1; what an exception interrupts is continued."""
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
        """Raise at half of the work."""
        if share > 0.4:
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        vi.campaign(small_sweep(), tmp_path / "store", chunk=2, threads=1, progress=fail)
    assert not vi.Campaign(tmp_path / "store").finished.all()
    vi.campaign(small_sweep(), tmp_path / "store", chunk=2)
    assert files_of(tmp_path / "store") == files_of(tmp_path / "whole")
