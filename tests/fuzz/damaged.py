"""Damaged files of all formats: an error of the package, or a result that can be used."""

import functools
import json
import random
import shutil
import tempfile
from pathlib import Path

import numpy as np
from child import in_child, limited, where
from language import Language

#: Damaged files of a whole run for each sound one.
COUNT = 500


def fuzz(report, options):
    """All of this file, one child process for each sound file."""
    count = max(2, round(COUNT * options.share))
    with tempfile.TemporaryDirectory() as name:
        for path, reader in sound_files(Path(name)):
            work = functools.partial(damaged, path, reader, count, options.seed)
            in_child(report, f"files {path.suffix or 'zarr'}", path.name, work)


def sound_files(folder):
    """(path, function that reads it) of a file or folder of each format."""
    import h5netcdf.legacyapi as netcdf
    import pyuff
    import scipy.io
    import vibroimpact as vi

    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    motion = vi.equispaced(osc, 0.94, 37.0)[0]
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 0.8)])
    results = {
        "motion": motion, "run": vi.simulate(osc, 0.94, 37.0, 3), "branch": vi.branch(motion, bounds=(36.5,
        37.5)),
        "zone": vi.zone(osc, "RL", (0.93, 0.95), (36.0, 38.0), lines=5, guesses=1),
        "physical": motion.physical(vi.Units(2.0, 3.0, 4.0)),
        "structure": vi.simulate_structure(wall, vi.Load(1.0, cosine=[1.0]), cycles=3),
    }  # fmt: skip
    found = []
    for name, result in results.items():
        for suffix in ".json", ".nc", ".mat":
            result.save(folder / f"{name}{suffix}")
            found.append((folder / f"{name}{suffix}", use_result))
    time = np.arange(200) / 1000
    load, acceleration = np.sin(60 * time), np.cos(60 * time)
    rows = "\n".join(f"{t},{a},{b}" for t, a, b in zip(time, load, acceleration, strict=True))
    (folder / "record.csv").write_text(f"time (s),force (N),acc (g)\n{rows}\n")
    scipy.io.savemat(
        folder / "record.mat", {"time": time, "load": load, "acceleration": acceleration}
    )
    scipy.io.wavfile.write(folder / "record.wav", 1000, np.stack([load, acceleration], 1))
    with netcdf.Dataset(folder / "record.nc", "w") as file:
        file.createDimension("time", len(time))
        for name, values in {"time": time, "load": load, "acceleration": acceleration}.items():
            file.createVariable(name, float, ("time",))[:] = values
    one = pyuff.prepare_58(
        binary=0, func_type=1, rsp_node=1, rsp_dir=1, ref_dir=1, ref_node=1, data=load, x=time, id1="force",
        ordinate_spec_data_type=9, ordinate_axis_units_lab="N", orddenom_spec_data_type=0, abscissa_inc=1e-3,
        abscissa_spacing=1, abscissa_min=0.0, num_pts=load.size, ord_data_type=4,
    )  # fmt: skip
    pyuff.UFF(str(folder / "record.uff")).write_sets(one, "add")
    found += [
        (folder / f"record.{ending}", use_record) for ending in ("csv", "mat", "wav", "nc", "uff")
    ]
    sep005 = [{"name": "load", "unit_str": "N", "fs": 100, "data": [0.0, 1.0, 2.0] * 20}]
    (folder / "sep005.json").write_text(json.dumps(sep005))
    found.append((folder / "sep005.json", use_sep005))
    case = vi.response(osc, [0.94], clearance=37.0, states=1, settling=2, keep=3).to_namelist()
    vi.campaign(vi.Sweep(case, {"mu": [0.02, 0.03]}), folder / "store", threads=1)
    found.append((folder / "store", use_store))
    return found


def use_result(path):
    """Reads a result, and uses it."""
    import vibroimpact as vi

    found = vi.load(path)
    repr(found)
    found.to_json()


def use_record(path):
    """Reads a record of signals."""
    import vibroimpact as vi

    repr(vi.read_record(path))


def use_sep005(path):
    """Reads a record that another library would give; JSON itself is not what is tried."""
    import vibroimpact as vi

    try:
        data = json.loads(path.read_text())
    except ValueError:
        return
    if isinstance(data, list):
        repr(vi.read_record(data))


def use_store(path):
    """Reads the store of a campaign."""
    import vibroimpact as vi

    vi.Campaign(path).to_xarray("points", "lowest").load()


def damage(rng, data):
    """Bytes that are changed, cut, repeated or exchanged."""
    kind = rng.random()
    if kind < 0.5 or not data:
        return Language.damage(rng, data)
    data = bytearray(data)
    at, n = rng.randrange(len(data)), rng.choice((1, 1, 4, 8, 64))
    if kind < 0.6:
        return bytes(data[:at])
    if kind < 0.8:
        data[at : at + n] = bytes(rng.choice((0, 255, rng.randrange(256))) for _ in range(n))
    else:
        data[at] ^= 1 << rng.randrange(8)
    return bytes(data)


def damaged(path, reader, count, seed, begin):
    """As `work` of `in_child`."""
    from vibroimpact.errors import VibroimpactError

    rng = random.Random(f"{seed} {path.name}")
    counts, faults = [0, 0], {}
    files = [path] if path.is_file() else sorted(item for item in path.rglob("*") if item.is_file())
    for i in range(count):
        chosen = rng.choice(files)
        data = damage(rng, chosen.read_bytes())
        place = Path(f"{path.stem}{path.suffix}")
        if path.is_file():
            place.write_bytes(data)
        else:
            shutil.rmtree(place, ignore_errors=True)
            shutil.copytree(path, place)
            (place / chosen.relative_to(path)).write_bytes(data)
        begin(f"{path.name}, {chosen.name}, number {i}")
        error = limited(functools.partial(reader, place), 10)
        if error is None:
            counts[1] += 1
        elif isinstance(error, (VibroimpactError, OSError)):
            counts[0] += 1
        elif isinstance(error, KeyboardInterrupt):
            faults.setdefault("does not end", (data, chosen.suffix))
        else:
            faults.setdefault(where(error), (data, chosen.suffix))
    return *counts, faults
