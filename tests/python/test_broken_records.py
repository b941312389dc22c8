"""Files that `load` cannot read give one ParameterError that names the file, quickly and with little memory."""

import json
import random
import re
import resource
import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.formats import matlab, netcdf

OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
#: Values that no valid record has in these places.
ODD = [
    None,
    True,
    -1,
    0,
    2**31,
    2**70,
    float("inf"),
    float("nan"),
    "",
    "x",
    [],
    {},
    [[]],
    [1, [2]],
    4e9,
    -5,
]


@pytest.fixture(scope="module")
def results():
    motion = vi.equispaced(OSC, r=0.94, clearance=37.0)[0]
    state = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
    return [motion, vi.simulate(OSC, 0.94, 37.0, 3, state=state), vi.branch(motion, bounds=(36, 38)),
            vi.zone(OSC, vi.Pattern("RL"), (0.93, 0.95), (36, 38), lines=5, guesses=4),
            vi.response(OSC, [0.93, 0.94], clearance=37.0, states=1, settling=2, keep=3)]  # fmt: skip


def refused(path):
    """The reason why a file is refused."""
    with pytest.raises(vi.errors.ParameterError) as error:
        vi.load(path)
    assert str(error.value).startswith(
        f"path = {str(path)!r}: must be a file written by `save` of a result; "
    )
    assert len(str(error.value)) < 1000
    return str(error.value).partition("; ")[2]


@pytest.mark.parametrize(
    "text", ["[" * 200_000, '{"a":' * 200_000, "1" * 10_000, '{"type": "' + "x" * 10**6 + '"}']
)
def test_deep_and_long_texts(text, tmp_path):
    path = tmp_path / "deep.json"
    path.write_text(text)
    refused(path)
    with pytest.raises(vi.errors.ParameterError):
        vi.Motion.from_json(text)


def places(data, above=()):
    """All places in a record; of long lists only the first few."""
    inner = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data[:3])
        if isinstance(data, list)
        else ()
    )
    for key, item in inner:
        yield (*above, key)
        yield from places(item, (*above, key))


def used(result, folder):
    """Read all public attributes of a result, which exist or are said to be missing; write it in several forms."""
    for name in dir(result):
        if not name.startswith("_"):
            try:
                getattr(result, name)
            except AttributeError as error:
                if " does not have it; it has " not in str(error):
                    raise
    result.to_xarray()
    result.save(folder / "out.csv")
    result.save(folder / "out.json")


def test_records_with_other_values(results, tmp_path):
    """A record with a value replaced or removed is refused by name, or gives a result that works in every use.

    A list of another length, or a size or an owner that does not fit, would make the core read outside
    its arrays.
    """
    draw = random.Random(4)
    read = 0
    for _ in range(250):
        data = json.loads(draw.choice(results).to_json())
        place = draw.choice([*places(data)])
        inner = data
        for key in place[:-1]:
            inner = inner[key]
        item = inner[place[-1]]
        way = draw.random()
        if way < 0.3:
            del inner[place[-1]]
        elif way < 0.5 and isinstance(item, list) and item:
            inner[place[-1]] = draw.choice([item[:-1], [*item, item[0]], item[::-1]])
        elif way < 0.7 and type(item) is int:
            inner[place[-1]] = item + draw.choice([-1, 1, 1000])
        else:
            inner[place[-1]] = draw.choice(ODD)
        path = tmp_path / "record.json"
        path.write_text(json.dumps(data))
        try:
            used(vi.load(path), tmp_path)
            read += 1
        except vi.errors.VibroimpactError:
            pass
    assert read > 10


def change_owner(value):
    """Change the first owner of the pieces of a zone."""
    return lambda tables: tables["pieces"]["owners"].__setitem__(0, value)


@pytest.mark.parametrize(("change", "output"), [
    (change_owner(5), "pieces.owners: must be rows of families, in order, from 0"),
    (change_owner(-1), "pieces.owners: must be rows of families, in order, from 0"),
    (lambda tables: tables["pieces"].update(parent="pieces"), "must be another table, and not one that"),
    (lambda tables: tables["pieces"].update(parent="nowhere"), "must be another table, and not one that"),
    (lambda tables: tables["open_seeds"].update(columns={}), "open_seeds.columns: must have at least one"),
    (lambda tables: tables.pop("vertices"), "tables.vertices: must be present; it is missing"),
    (lambda tables: tables["vertices"]["dims"].update(vertex=1e9), "must be a whole number with 0 <="),
    (lambda tables: tables["vertices"]["columns"].pop("r"), "vertices.r: must be present; it is missing"),
])  # fmt: skip
def test_tables_that_do_not_fit(change, output, results, tmp_path):
    data = json.loads(results[3].to_json())
    change(data["tables"])
    path = tmp_path / "zone.json"
    path.write_text(json.dumps(data))
    assert output in refused(path)


@pytest.mark.parametrize(
    "record", [np.zeros((0, 0)), "", 5.0, np.array(["a", "b"]), {"a": 1}, "{}", "[" * 100_000]
)
def test_matlab_files_without_a_record(record, tmp_path):
    path = tmp_path / "motion.mat"
    pytest.importorskip("scipy.io").savemat(path, {"motion": {"record": record}})
    refused(path)


def netcdf_file(path, **options):
    """A netCDF file with a variable `record` with these options."""
    with pytest.importorskip("h5py").File(path, "w") as data:
        data.create_dataset("record", **options)


def test_netcdf_file_that_claims_too_much(tmp_path):
    """A file of a few kB with a record of 4e9 bytes is refused with little memory."""
    path = tmp_path / "motion.nc"
    netcdf_file(path, shape=(4_000_000_000,), dtype="u1", chunks=(2**20,), compression="gzip")
    assert path.stat().st_size < 10_000
    assert "is larger than a file of" in refused(path)
    code = "import sys, vibroimpact as vi\ntry: vi.load(sys.argv[1])\nexcept vi.errors.ParameterError: print('no')"
    done = subprocess.run(
        [sys.executable, "-c", code, path], capture_output=True, text=True, timeout=300,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (3 * 2**30, 3 * 2**30)),
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "no\n", "")


@pytest.mark.parametrize("options", [
    {"data": 5}, {"data": np.zeros((2, 2), "u1")}, {"data": np.ones(3)}, {"data": "text"},
    {"data": np.frombuffer(b"\xff\xfe", "u1")}, {"data": np.frombuffer(b"{}", "u1")},
    {"shape": (0,), "dtype": "u1"},
])  # fmt: skip
def test_netcdf_files_with_another_record(options, tmp_path):
    path = tmp_path / "motion.nc"
    netcdf_file(path, **options)
    refused(path)


@pytest.mark.parametrize("missing", ["h5py", "h5netcdf"])
def test_libraries_for_netcdf(missing, results, tmp_path, monkeypatch):
    """An error names each missing library and the extra that installs it."""
    pytest.importorskip("h5netcdf")
    results[0].save(tmp_path / "motion.nc")
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(
        vi.errors.MissingExtraError, match=rf"need {missing}: pip install 'vibroimpact\[data\]'"
    ):
        netcdf.need_netcdf()
    if missing == "h5py":
        with pytest.raises(vi.errors.MissingExtraError, match="need h5py: pip install"):
            vi.load(tmp_path / "motion.nc")


def test_a_plane_of_which_a_bound_is_missing(tmp_path):
    """A result whose case lacks a bound of its plane can be loaded and displayed, without axes."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    path = tmp_path / "basins.json"
    vi.basins(osc, 0.94, 37.0, (("x", -30, 30, 3), ("x_dot", -30, 30, 3))).save(path)
    text = path.read_text()
    path.write_text(re.sub(r"  high = [^\\]*\\n", "", text))
    assert path.read_text() != text
    found = vi.load(path)
    assert found.axes is None
    assert "Basins" in repr(found)


def test_matlab_file_with_a_damaged_part(results, tmp_path):
    """A changed byte of a compressed part is refused before scipy, which can crash on it, reads the file."""
    path = tmp_path / "motion.mat"
    pytest.importorskip("scipy.io")
    results[0].save(path)
    data = bytearray(path.read_bytes())
    for at in range(200, len(data), 97):
        damaged = data.copy()
        damaged[at] ^= 1
        path.write_bytes(damaged)
        assert "a compressed part is damaged" in refused(path)
    path.write_bytes(data[:-20])
    assert "damaged" in refused(path)


def repacked(data, change):
    """A MATLAB file with changed content of its compressed parts, and correct checksums."""
    found, at = bytearray(data[:128]), 128
    while at < len(data):
        kind, size = struct.unpack_from("<II", data, at)
        assert kind == 15
        held = zlib.compress(change(bytearray(zlib.decompress(data[at + 8 : at + 8 + size]))))
        found += struct.pack("<II", 15, len(held)) + held
        at += 8 + size
    return bytes(found)


@pytest.mark.slow
def test_matlab_files_with_other_bytes(results, tmp_path):
    """A byte that is changed in a part that is not compressed, or before it is, gives an error or a result: tags
    that scipy trusts can end the interpreter."""
    io = pytest.importorskip("scipy.io")
    path = tmp_path / "record.mat"
    io.savemat(path, {"load": np.arange(20.0), "fs": 100.0})
    data = path.read_bytes()
    counts = {"read": 0, "refused": 0}
    for at in range(120, len(data)):
        for value in {0, 255, data[at] ^ 1, data[at] ^ 16, (data[at] + 7) % 256}:
            path.write_bytes(data[:at] + bytes([value]) + data[at + 1 :])
            try:
                vi.read_record(path)
                counts["read"] += 1
            except vi.ParameterError as error:
                assert str(error).startswith(f"path = {str(path)!r}: ")  # noqa: PT017 (some are read)
                counts["refused"] += 1
    results[0].save(path)
    data, draw = path.read_bytes(), random.Random(7)

    def change(content):
        at = draw.randrange(min(len(content), draw.choice([64, 600, 10**6])))
        content[at] = draw.choice([0, 255, content[at] ^ 1 << draw.randrange(8)])
        return content

    for _ in range(300):
        path.write_bytes(repacked(data, change))
        try:
            vi.load(path)
            counts["read"] += 1
        except vi.errors.ParameterError:
            counts["refused"] += 1
    assert min(counts.values()) > 300, counts


@pytest.mark.parametrize("compressed", [True, False])
def test_matlab_variables_are_those_of_scipy(compressed, tmp_path):
    """Numbers, texts, structs and cells of all kinds are read as scipy reads them."""
    io = pytest.importorskip("scipy.io")
    path = tmp_path / "all.mat"
    content = {
        "x": np.arange(12.0).reshape(3, 4), "k": np.arange(6, dtype=">i2"), "z": np.array([1 + 2j, 3]),
        "one": 2.5, "none": np.zeros((0, 3)), "text": "acc \u03be", "rows": np.array(["ab", "cd"]),
        "s": {"record": "{}", "inner": {"a": [1, 2]}}, "true": np.array([True, False]),
        "c": np.array([np.arange(3), "word"], dtype=object),
        **{kind: np.arange(4, dtype=kind) for kind in ("i1", "u1", "u2", "i4", "u4", "i8", "u8", "f4")},
    }  # fmt: skip
    io.savemat(path, content, do_compression=compressed, oned_as="column")
    found = matlab.read_variables(path)
    expected = io.loadmat(path)
    for name, value in expected.items():
        if name.startswith("__") or name in ("s", "c", "text", "rows", "none"):
            continue
        assert np.array_equal(found[name], value), name
    assert found["none"].size == 0
    assert (found["text"], found["rows"], found["s"]["record"]) == (
        "acc \u03be",
        ["ab", "cd"],
        "{}",
    )
    assert found["s"]["inner"]["a"].tolist() == [[1], [2]]
    assert found["c"][0].ravel().tolist() == [0, 1, 2]
    assert found["c"][1] == "word"


def test_large_matlab_file(tmp_path):
    """Parts that inflate to more than one read step are read."""
    io = pytest.importorskip("scipy.io")
    path = tmp_path / "record.mat"
    load = np.zeros(400_000)
    load[::7] = np.arange(load[::7].size)
    io.savemat(path, {"load": load}, do_compression=True)
    assert (vi.read_record(path, rate=100.0).load == load).all()
