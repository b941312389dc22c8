"""Files that run code when they are unpickled: no reader of the package does it."""

import io
import json
import pickle
import re
import shutil
import subprocess
import sys
import tokenize
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
    """A place where nothing may be made; that unpickling would make it is tried first."""
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
    """Whatever its name, a file that is no saved result is refused."""
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
    """Nor does an array of objects get its way as a signal."""
    with pytest.raises((vi.ParameterError, TypeError)):
        vi.SensorRecord(1000.0, load=npy(mark), acceleration=npy(mark))


def foreign(folder, mark, form):
    """Make the one chunk of a store one that a stranger wrote, with right checksums."""
    zarr, numcodecs = pytest.importorskip("zarr"), pytest.importorskip("numcodecs")
    store = Store(folder)
    (name,) = store.names()
    place = store.chunks / name
    if form == 2:
        shutil.rmtree(place)
        group = zarr.create_group(str(place), zarr_format=2)
        # declared as one of texts, which are packed by pickle
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
    """A chunk whose tables have names that lead out of its folder, also by a link, is refused."""
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
    """A chunk that a stranger wrote, with pickle as what decodes its arrays, is refused."""
    store, name = foreign(written, mark, form)
    assert store.state(name) == "done"
    with pytest.raises(vi.ParameterError, match="is no chunk that a campaign wrote"):
        store.read(name)


def test_no_module_unpickles():
    """No reader of the package imports what runs code in files; ruff's rule S301 says the same of calls."""
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
