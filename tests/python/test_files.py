"""Results as netCDF, MATLAB and CSV files, labelled datasets and data frames."""

import sys
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_results import NAMES, STUDIES_NAMED, same, write
from vibroimpact.formats.rows import places_of

FILES = [name for name in NAMES if name != "still"]


@pytest.mark.parametrize("suffix", [".nc", ".mat"])
@pytest.mark.parametrize("name", FILES)
def test_files_give_every_bit(name, suffix, results, tmp_path):
    """netCDF and MATLAB files are read back bit for bit; no temporary file remains."""
    pytest.importorskip({".nc": "h5netcdf", ".mat": "scipy"}[suffix])
    path = tmp_path / f"result{suffix}"
    results[name].save(path)
    assert [item.name for item in tmp_path.iterdir()] == [path.name]
    assert same(vi.load(path), results[name])


@pytest.mark.parametrize("name", NAMES)
def test_datasets_are_labelled(name, results):
    """Every variable has a unit or flags and a description; case and version are attributes."""
    pytest.importorskip("xarray")
    result = results[name]
    data = result.to_xarray()
    for variable in data.variables.values():
        assert variable.attrs["long_name"]
        assert "units" in variable.attrs or variable.dtype.kind in "OU"
    assert data.attrs["source"] == f"vibroimpact {vi.__version__}"
    assert data.attrs["Conventions"].startswith("CF-")
    if name not in ("rest", "free"):
        assert data.attrs["case"] == result.to_namelist()
    if isinstance(result, vi.Motion):
        np.testing.assert_array_equal(data.X, result.X)
        np.testing.assert_array_equal(
            data.multipliers_real + 1j * data.multipliers_imag, result.multipliers
        )
        assert float(data.clearance) == result.clearance
    elif isinstance(result, vi.Trajectory):
        np.testing.assert_array_equal(data.time, result.events["time"])
        assert data.side.values.tolist() == result.events["side"].tolist()
    elif isinstance(result, vi.Branch):
        np.testing.assert_array_equal(data.Z_dot_after[3], result[3].Z_dot_after)
    elif isinstance(result, vi.Zone):
        for i, piece in enumerate(result.boundary):
            here = data.sel(vertex=data.vertices_pieces == i)
            np.testing.assert_array_equal(here.vertices_r, piece.r)
            np.testing.assert_array_equal(here.x[:, : len(piece.x_over_D)].T, piece.x_over_D)
            assert str(data.type.values[i]) == piece.type
        for i, ring in enumerate(result.loops):
            here = data.sel(ring_point=data.rings_loops == i)
            np.testing.assert_array_equal(np.c_[here.rings_r, here.rings_clearance], ring)
    else:
        sheets = np.unique(data.pieces_families)
        assert data.families_sides.values[sheets].tolist() == [
            zone.pattern.sides for zone in result.zones
        ]
        assert data.sizes["vertex"] == sum(len(p) for zone in result.zones for p in zone.boundary)


def test_listed_columns_belong_to_the_rows(results):
    """Each column of the CSV is in the table of its rows, or in a table with one row for each of its rows."""
    for name in NAMES:
        result = results[name]._result
        places = places_of(result, result.row)
        tables = {id(table): key for key, table in result.tables.items()}
        listed = {tables[id(table)] for table, column in result.columns() if column.listed}
        assert result.row in listed
        assert listed <= set(places), name


def test_netcdf_is_read_by_others(results, tmp_path):
    """h5py reads the numbers and the units."""
    h5py = pytest.importorskip("h5py")
    results["motion"].save(tmp_path / "motion.nc")
    with h5py.File(tmp_path / "motion.nc") as file:
        assert file["X"][:].tolist() == results["motion"].X.tolist()
        unit = file["X"].attrs["units"]
        assert (unit.decode() if isinstance(unit, bytes) else unit) == "F0/K"


def test_matlab_is_read_by_others(results, tmp_path):
    """The files hold what MATLAB expects: a struct, cells of structs, complex numbers, logicals."""
    scipy_io = pytest.importorskip("scipy.io")
    for name in ("motion", "zone", "trajectory"):
        results[name].save(tmp_path / f"{name}.mat")
    motion = scipy_io.loadmat(tmp_path / "motion.mat", simplify_cells=True)["motion"]
    np.testing.assert_array_equal(motion["multipliers"], results["motion"].multipliers)
    np.testing.assert_array_equal(motion["X_dot_before"], results["motion"].X_dot_before)
    assert motion["sides"] == "RL"
    assert (motion["R1"], motion["R2"]) == (0.75, 0.75)
    assert motion["stable"] == 1
    zone = scipy_io.loadmat(tmp_path / "zone.mat", simplify_cells=True)["zone"]
    for i, theirs in enumerate(results["zone"].boundary):
        here = zone["vertices_pieces"] == i + 1
        assert zone["type"][i] == theirs.type
        np.testing.assert_array_equal(zone["vertices_clearance"][here], theirs.clearance)
    run = scipy_io.loadmat(tmp_path / "trajectory.mat", simplify_cells=True)["trajectory"]
    np.testing.assert_array_equal(run["x"], results["trajectory"].events["x"])
    assert run["side"].tolist() == results["trajectory"].events["side"].tolist()


@pytest.mark.parametrize(
    "name", ["motion", "linear", "trajectory", "rests", "still", "branch", "zone", "atlas"]
)
def test_csv_is_what_run_writes(name, results, tmp_path):
    """A saved CSV has the bytes that `run` writes for the namelist, and as an input reproduces them."""
    results[name].save(tmp_path / "mine.csv")
    path = write(tmp_path / "case.nml", results[name].to_namelist() + "&output name = 'mine' /\n")
    log = vi.run_namelists([path], tmp_path / "run")
    assert (log.status, len(log.results)) == (0, 1)
    assert (tmp_path / "mine.csv").read_text() == log.results[0].read_text()
    log = vi.run_namelists([tmp_path / "mine.csv"], tmp_path / "again")
    assert log.results[0].read_bytes() == (tmp_path / "mine.csv").read_bytes()


def test_csv_without_a_namelist(results, tmp_path):
    """The CSV of a result without a namelist states this in its header, and cannot be loaded."""
    results["rest"].save(tmp_path / "rest.csv")
    lines = (tmp_path / "rest.csv").read_text().splitlines()
    assert lines[0].endswith("no namelist describes how it began")
    assert len(lines) == 2 + len(results["rest"].pattern)
    with pytest.raises(
        vi.errors.ParameterError, match=r"rest\.csv': must end with .json, .nc or .mat"
    ):
        vi.load(tmp_path / "rest.csv")


@pytest.mark.parametrize("name", NAMES)
def test_data_frames(name, results):
    """Data frames have the columns and numbers of the table."""
    pytest.importorskip("pandas")
    frame = results[name].to_pandas()
    result = results[name]
    if isinstance(result, vi.Trajectory):
        assert frame["x"].tolist() == result.events["x"].tolist()
    elif isinstance(result, vi.Motion):
        assert frame["phase"].tolist() == result.alpha.tolist()
        assert frame["r"].unique().tolist() == [result.r]
    elif isinstance(result, vi.Branch):
        assert frame["special"][frame["special"] != ""].tolist() == [
            p.type for p in result.special_points
        ]
    else:
        assert set(frame["type"]) <= {"fold", "pitchfork", "neimark_sacker", "flip", "grazing", "window",
                                      "zero_approach"}  # fmt: skip


def test_files_of_another_kind_by_suffix(results, tmp_path):
    """A file whose contents do not fit its suffix, or without a record, is refused by name."""
    pytest.importorskip("h5netcdf")
    pytest.importorskip("scipy.io").savemat(tmp_path / "other.mat", {"a": 1})
    results["motion"].to_xarray().to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    write(tmp_path / "text.nc", "no netCDF")
    write(tmp_path / "text.mat", "no matrix, however long the text may be " * 9)
    results["motion"].save(tmp_path / "whole.mat")
    write(tmp_path / "short.mat", "MATLAB")
    (tmp_path / "half.mat").write_bytes((tmp_path / "whole.mat").read_bytes()[:500])
    for name in (
        "short.mat",
        "half.mat",
        "other.mat",
        "other.nc",
        "text.nc",
        "text.mat",
        "none.nc",
        "none.mat",
    ):
        with pytest.raises(vi.errors.ParameterError, match=rf"{name}': must be a file written by"):
            vi.load(tmp_path / name)


@pytest.mark.parametrize("suffix", [".nc", ".mat", ".json"])
def test_broken_files_are_refused(suffix, results, tmp_path):
    """A file cut at any place, or with a changed byte, is refused by name or read; no other error occurs."""
    pytest.importorskip({".nc": "h5netcdf", ".mat": "scipy", ".json": "json"}[suffix])
    path = tmp_path / f"motion{suffix}"
    results["motion"].save(path)
    whole = path.read_bytes()
    refused = 0
    for i in range(0, len(whole), 1 + len(whole) // 30):
        for broken in (whole[:i], whole[:i] + bytes([whole[i] ^ 0x55]) + whole[i + 1 :]):
            path.write_bytes(broken)
            try:
                vi.load(path)
            except vi.errors.ParameterError as error:
                assert f"motion{suffix}" in str(error)  # noqa: PT017
                refused += 1
    assert refused >= 30


def test_missing_libraries_are_named(results, tmp_path, monkeypatch):
    """The error names the extra that installs the library, and no partial file remains."""
    for module in ("scipy", "scipy.io", "xarray", "pandas"):
        monkeypatch.setitem(sys.modules, module, None)
    for suffix, extra in ((".mat", "matlab"), (".nc", "data")):
        with pytest.raises(
            vi.errors.MissingExtraError, match=rf"pip install 'vibroimpact\[{extra}\]'"
        ):
            results["motion"].save(tmp_path / f"motion{suffix}")
    with pytest.raises(vi.errors.MissingExtraError, match=r"vibroimpact\[data\]"):
        results["motion"].to_pandas()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".json", ".nc", ".mat"])
@pytest.mark.parametrize("name", STUDIES_NAMED)
def test_studies_of_attractors_come_back(name, suffix, attractors, tmp_path):
    """Studies of attractors are read back bit for bit."""
    pytest.importorskip({".nc": "h5netcdf", ".mat": "scipy", ".json": "json"}[suffix])
    path = tmp_path / f"result{suffix}"
    attractors[name].save(path)
    assert same(vi.load(path), attractors[name])


@pytest.mark.parametrize("paths", ["case.nml", b"case.nml", Path("case.nml")])
def test_one_name_is_no_list_of_files(paths):
    """A string in place of a list of files is refused, not read letter by letter."""
    with pytest.raises(
        vi.errors.ParameterTypeError, match=r"paths = .*case.nml.*: must be a list of files"
    ):
        vi.run_namelists(paths)
