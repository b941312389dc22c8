"""Results of campaigns equal those of single calls, table by table; cases that failed are kept."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_campaign import OSC, equispaced_case, files_of, small_sweep
from vibroimpact.results import door
from vibroimpact.results.noun import result_class

pytest.importorskip("zarr")

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
        direct = door.run_text(result_class(found.study), text)
        assert found[i].to_dict() == direct.to_dict()


def test_values(tmp_path):
    """Reductions over the rows of each case equal those of single results; NaN if there is no motion."""
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
    """The namelist of a refused case, run by the program, gives the same message."""
    sweep = vi.Sweep(equispaced_case(), {"xi": [0.0, 0.01], "r": [0.9, 1.0]})
    found = vi.campaign(sweep, tmp_path / "store")
    call = [Path(sys.executable).parent / "vibroimpact-batch", found.failures / "case_1.nml"]
    done = subprocess.run(call, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert found.refused[1] in done.stderr


def test_a_case_that_failed_once(tmp_path, monkeypatch):
    """A chunk without enough memory leaves its cases; the next call computes them, and removes these files."""
    sweep = small_sweep()
    vi.campaign(sweep, tmp_path / "whole", chunk=4)

    def fail(*_):
        """Fail for lack of memory."""
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
    """An error that is not the package's own is stored for its case, and the others are computed."""
    from vibroimpact.campaigns import chunk

    right = chunk.result_of

    def fail(study, text, *rest):
        """Simulate a defect in one case."""
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


def test_xarray_reads_it_while_it_runs(tmp_path):
    """At each time another reader sees what is finished so far, and never half a chunk."""
    xarray = pytest.importorskip("xarray")
    store, looks = tmp_path / "store", []

    def look(share, note):
        if not share:
            return
        tree = xarray.open_datatree(store / "results.zarr", engine="zarr", consolidated=False)
        seen = [
            (int(name.split("-")[0]) + int(case), float(value))
            for name in tree.children
            for case, value in zip(
                tree[name]["motions"]["case"].values,
                tree[name]["motions"]["attenuation"].values,
                strict=True,
            )
            if not np.isnan(value)
        ]
        looks.append((int(vi.Campaign(store).finished.sum()), seen))

    found = vi.campaign(small_sweep(), store, chunk=1, threads=1, progress=look)
    known = {
        (i, motion.attenuation)
        for i in range(12)
        for motion in found[i].parts()
        if found[i] is not None
    }
    assert any(0 < len(seen) < len(known) for _, seen in looks)
    for finished, seen in looks:
        assert set(seen) <= known
        assert len({case for case, _ in seen}) <= finished


@pytest.mark.parametrize("study", ["motion", "find", "zone", "structure_wall"])
def test_all_rows_of_a_table(tmp_path, study):
    """The rows are those of the single results, one after the other, for any size of chunks."""
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
