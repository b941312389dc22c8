"""Untrusted files: no reader runs their contents, and none exhausts the memory."""

import io
import json
import pickle
import re
import shutil
import struct
import subprocess
import sys
import time
import tokenize
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.campaigns.store import HEADS, Store, checksums

PACKAGE = Path(vi.__file__).parent


class Touch:
    """Makes a file when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.fixture
def mark(tmp_path):
    """A path where no file may appear; the fixture first shows that unpickling would make it."""
    place = tmp_path / "marked"
    pickle.loads(pickle.dumps(Touch(place)))
    assert place.exists()
    place.unlink()
    yield place
    assert not place.exists()


def objects(mark):
    """An array with an object that marks."""
    found = np.empty(3, dtype=object)
    found[:] = [Touch(mark)] * 3
    return found


def npy(mark):
    """Such an array as NumPy saves it: as a pickle."""
    held = io.BytesIO()
    np.save(held, objects(mark), allow_pickle=True)
    return held.getvalue()


def npz(mark):
    held = io.BytesIO()
    np.savez(held, load=objects(mark), acceleration=objects(mark))
    return held.getvalue()


def hdf5(mark):
    """A netCDF file whose record is an opaque pickle."""
    h5py = pytest.importorskip("h5py")
    held = io.BytesIO()
    with h5py.File(held, "w") as file:
        file["record"] = np.void(pickle.dumps(Touch(mark)))
        file["load"] = np.void(pickle.dumps(Touch(mark)))
    return held.getvalue()


def mat(mark):
    """A MATLAB file whose record is a pickle in bytes."""
    from scipy.io import savemat

    held = io.BytesIO()
    data = np.frombuffer(pickle.dumps(Touch(mark)), np.uint8)
    savemat(held, {"found": {"record": data}})
    return held.getvalue()


CONTENTS = [lambda mark: pickle.dumps(Touch(mark)), npy, npz, hdf5, mat]


@pytest.mark.parametrize("ending", ["json", "nc", "mat", "csv"])
@pytest.mark.parametrize("content", CONTENTS)
def test_saved_results_are_not_unpickled(mark, tmp_path, content, ending):
    """A file that is not a saved result is refused under any name."""
    path = tmp_path / f"found.{ending}"
    path.write_bytes(content(mark))
    with pytest.raises(vi.ParameterError):
        vi.load(path)


@pytest.mark.parametrize("ending", ["csv", "json", "mat", "nc", "uff", "unv", "wav", "npy"])
@pytest.mark.parametrize("content", CONTENTS)
def test_sensor_records_are_not_unpickled(mark, tmp_path, content, ending):
    """The same for records of sensors."""
    path = tmp_path / f"bench.{ending}"
    path.write_bytes(content(mark))
    with pytest.raises(vi.ParameterError):
        vi.read_record(path)


@pytest.mark.parametrize("content", CONTENTS)
def test_matrices_are_not_unpickled(mark, tmp_path, content):
    """A matrix of a structure in a file of NumPy: one of objects is refused."""
    for ending in ("npy", "txt", "mtx"):
        (tmp_path / f"mass.{ending}").write_bytes(content(mark))
        case = tmp_path / f"{ending}.nml"
        case.write_text(
            f"&structure\n mass_file = 'mass.{ending}', stiffness = 1, damping = 0.1\n/\n"
            "&motion_structure\n r = 1\n/\n"
        )
        program = [Path(sys.executable).parent / "vibroimpact", "run"]
        done = subprocess.run(
            [*program, case, "-o", tmp_path / "out"], capture_output=True, text=True
        )
        assert done.returncode == 2, done.stderr


def test_arrays_of_objects_are_not_unpickled_in_memory(mark):
    """An array of objects is refused as a signal."""
    with pytest.raises((vi.ParameterError, TypeError)):
        vi.SensorRecord(1000.0, load=npy(mark), acceleration=npy(mark))


def foreign(folder, mark, form):
    """Replace the single chunk of a store by a hostile one, with correct checksums."""
    zarr, numcodecs = pytest.importorskip("zarr"), pytest.importorskip("numcodecs")
    store = Store(folder)
    (name,) = store.names()
    place = store.chunks / name
    if form == 2:
        shutil.rmtree(place)
        group = zarr.create_group(str(place), zarr_format=2)
        # declared as an array of texts, which are packed by pickle
        array = group.create_array(
            HEADS, shape=(3,), chunks=(3,), dtype="u1", filters=None, compressors=None
        )
        array[...] = 1
        declared = json.loads((place / HEADS / ".zarray").read_text())
        declared |= {"dtype": "|O", "fill_value": "", "filters": [{"id": "vlen-utf8"}]}
        declared["compressor"] = {"id": "pickle", "protocol": 5}
        (place / HEADS / ".zarray").write_text(json.dumps(declared))
        (place / HEADS / "0").write_bytes(bytes(numcodecs.Pickle().encode(objects(mark))))
    else:
        for path in place.rglob("zarr.json"):
            declared = json.loads(path.read_text())
            if declared["node_type"] == "array":
                declared["codecs"] = [{"name": form, "configuration": {}}]
                path.write_text(json.dumps(declared))
    (store.sums / f"{name}.json").write_text(json.dumps(checksums(place)))
    return store, name


@pytest.fixture
def written(tmp_path):
    """The folder of a store with one chunk."""
    pytest.importorskip("zarr")
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    case = vi.equispaced(osc, r=1.0, clearance=20.0)[0].to_namelist()
    vi.campaign(vi.Sweep(case, {"r": [0.99, 1.0]}), tmp_path / "store")
    return tmp_path / "store"


@pytest.mark.parametrize("way", ["../../../outside/motion", "{}/outside/motion", "link/motion"])
def test_no_file_outside_of_a_store_is_read(written, tmp_path, way):
    """A chunk whose table names lead out of its folder, also by a link, is refused."""
    store = Store(written)
    (name,) = store.names()
    place = store.chunks / name
    shutil.copytree(place, tmp_path / "outside")
    (place / "link").symlink_to(tmp_path / "outside")
    listed = store.sums / f"{name}.json"
    sums = json.loads(listed.read_text())
    more = {
        f"{way.format(tmp_path)}{path.removeprefix('motions')}": number
        for path, number in sums.items() if path.startswith("motions/")
    }  # fmt: skip
    assert more
    listed.write_text(json.dumps(sums | more))
    with pytest.raises(vi.ParameterError, match="leads out of it"):
        store.read(name)


@pytest.mark.parametrize("form", [2, "pickle", "numcodecs.pickle"])
def test_stores_are_not_unpickled(mark, written, form):
    """A hostile chunk that uses pickle to decode its arrays is refused."""
    store, name = foreign(written, mark, form)
    assert store.state(name) == "done"
    with pytest.raises(vi.ParameterError, match="is not a chunk written by a campaign"):
        store.read(name)


def test_no_module_unpickles():
    """No reader of the package imports a module that runs code in files; ruff's rule S301 covers calls."""
    found = []
    for path in PACKAGE.rglob("*.py"):
        with tokenize.open(path) as file:
            text = file.read()
        if re.search(
            r"^\s*(import|from) (pickle|marshal|shelve|joblib|dill|cloudpickle)\b", text, re.M
        ):
            found.append(path.name)
        if re.search(r"\bnp\.load\(|allow_pickle", text):
            found.append(path.name)
    assert found == []


# -- small files that claim, or unpack to, more than memory holds


def element(kind, data):
    """An element of a MATLAB file."""
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def matrix(of_class, dims, content=b""):
    """A matrix of a MATLAB file: class 1 is a cell array, 2 a struct, 5 a sparse one, 6 one of numbers; 0x800 says
    that there are imaginary parts, too."""
    flags, size = struct.pack("<II", of_class, 0), struct.pack(f"<{len(dims)}i", *dims)
    return element(14, element(6, flags) + element(5, size) + element(1, b"load") + content)


def packed(data):
    """A compressed element."""
    held = zlib.compress(data)
    return struct.pack("<II", 15, len(held)) + held


def nested(depth):
    """Cell arrays nested in cell arrays."""
    found = matrix(6, (1, 1), element(9, bytes(8)))
    for _ in range(depth):
        found = matrix(1, (1, 1), found)
    return found


HUGE = (10**5, 10**4)
MATLAB_BOMBS = {
    "cells": (matrix(1, HUGE), "declares 1000000000 entries"),
    "structs": (matrix(2, HUGE, element(5, struct.pack("<i", 32)) + element(1, b"")), "declares 1000000000"),
    "inner": (matrix(1, (1, 1), matrix(1, HUGE)), "declares 1000000000 entries"),
    "packed": (packed(matrix(1, HUGE)), "declares 1000000000 entries"),
    "deep": (packed(nested(5000)), "nested too deeply"),
    "inflated": (packed(element(14, bytes(2**25))), r"has 33554440 bytes; must have at most 4194304"),
    "twice": (2 * packed(matrix(6, (3 * 2**17, 1), element(9, bytes(3 * 2**20)))), r"has 6291\d+ bytes; must"),
    "lie": (packed(struct.pack("<II", 14, 8) + bytes(2**25)), "declares 16 bytes and has more"),
    "real": (matrix(0x806, (1, 1), element(9, bytes(8))), "a matrix has no imaginary part"),
    "sparse": (matrix(5, (1, 1), element(5, bytes(8))), "there is no struct|channels none: one must"),
    "cut": (packed(struct.pack("<II", 14, 2**20) + bytes(8)), "declares 1048576 bytes and has 8"),
}  # fmt: skip


@pytest.fixture
def little_memory(monkeypatch):
    """Limits the free memory to 64 MB; what Python takes in a test is far less, in much less time."""
    monkeypatch.setattr("vibroimpact.base.sizes.free", lambda: 2**26)
    tracemalloc.start()
    begin = time.process_time()
    yield
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 2**26
    assert time.process_time() - begin < 20


@pytest.mark.parametrize("name", MATLAB_BOMBS)
def test_matlab_files_that_grow(tmp_path, little_memory, name):
    """Sizes are checked before anything is decompressed or memory is allocated."""
    content, message = MATLAB_BOMBS[name]
    path = tmp_path / "bomb.mat"
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    path.write_bytes(head + content)
    for read in (vi.load, vi.read_record):
        with pytest.raises(vi.ParameterError, match=message) as caught:
            read(path)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize("ending", ["json", "nc", "mat", "csv", "txt", "uff", "wav"])
def test_files_larger_than_memory(tmp_path, little_memory, ending):
    """A file with a hole of a terabyte takes no room on disk, and none in memory."""
    path = tmp_path / f"hole.{ending}"
    with open(path, "wb") as file:
        file.write(b"\x89HDF\r\n\x1a\n" if ending == "nc" else b"1,2\n")
        file.truncate(2**40)
    with pytest.raises(
        vi.ParameterError, match=r"hole.*has 1099511627776 bytes; must have at most"
    ):
        vi.read_record(path)
    if ending in ("json", "mat"):
        with pytest.raises(vi.ParameterError, match="has 1099511627776 bytes; must have at most"):
            vi.load(path)


@pytest.mark.parametrize("chunks", [None, (2**24,)])
def test_netcdf_files_that_grow(tmp_path, little_memory, chunks):
    """Variables that declare more than the file has, or chunks that are larger than their variable."""
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "bomb.nc"
    size = 2**25 if chunks is None else 10
    with h5py.File(path, "w") as file:
        file.create_dataset("filling", data=np.ones(2**16))  # a file may contain it
        for name in ("time", "load", "acceleration", "record"):
            kind = "u1" if name == "record" else "f8"
            file.create_dataset(
                name, (size,), kind, chunks=chunks, maxshape=(None,) if chunks else None
            )
    with pytest.raises(vi.ParameterError, match=r"has \d+ bytes; must have at most 16777216"):
        vi.read_record(path)
    with pytest.raises(
        vi.ParameterError, match=r"record.* has \d+ bytes; must have at most 4194304"
    ):
        vi.load(path)


def test_a_sound_file_that_lies(tmp_path):
    """A sound file that declares 2^60 bytes of samples."""
    pytest.importorskip("scipy")
    path = tmp_path / "bomb.wav"
    form = b"fmt " + struct.pack("<IHHIIHH", 16, 1, 1, 1000, 2000, 2, 16)
    sizes = b"ds64" + struct.pack("<IQQQI", 28, 2**60, 2**60, 2**59, 0)
    path.write_bytes(
        b"RF64\xff\xff\xff\xffWAVE" + sizes + form + b"data\xff\xff\xff\xff" + bytes(100)
    )
    with pytest.raises(vi.ParameterError):
        vi.read_record(path)


@pytest.mark.parametrize("lie", ["shape", "content", "both"])
def test_chunks_that_grow(written, little_memory, lie):
    """The declared size of a chunk is checked before it is decompressed, and must match the decompressed one."""
    store = Store(written)
    (name,) = store.names()
    place = store.chunks / name / "motions" / "attenuation"
    about = json.loads((place / "zarr.json").read_text())
    if lie != "content":
        about["shape"] = [2**24]
        (place / "zarr.json").write_text(json.dumps(about))
    if lie != "shape":
        from numcodecs.zstd import Zstd

        (place / "0").write_bytes(Zstd(level=3, checksum=True).encode(bytes(2**24 * 8)))
        assert (place / "0").stat().st_size < 10_000
        tracemalloc.reset_peak()
    sums = checksums(store.chunks / name)
    (store.sums / f"{name}.json").write_text(json.dumps(sums))
    message = (
        "motions/attenuation does not unpack to the" if lie == "content"
        else r"has 13\d+ bytes; must have at most 16777216"
    )  # fmt: skip
    with pytest.raises(vi.ParameterError, match=message):
        store.read(name)
    with pytest.raises(vi.ParameterError, match=message):
        vi.Campaign(written).values("motions", "attenuation")
