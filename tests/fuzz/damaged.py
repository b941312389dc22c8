"""Read damaged files of all formats: the outcome is an error of the package or a usable result."""

import contextlib
import copy
import functools
import inspect
import json
import random
import shutil
import struct
import tempfile
import zlib
from pathlib import Path

import numpy as np
from child import in_child, limited, where
from language import Language

#: Number of damaged files made from each sound file in a full run.
COUNT = 500
#: Values that replace others in a JSON record.
ODD = [
    None, True, -1, 0, 1, 2, 5, 1000, 2**31, 2**70, 1e300, 1e-300, -5, 0.5, float("nan"), "inf", "", " ", "x",
    "=1", "R", "a,b", 'a"b', "a\nb", "\ud800", "R*", [], {}, [[]], [1, [2]], [None], "constant", "power", "stick",
]  # fmt: skip
#: Methods of results that draw or take long.
LEFT_OUT = {"animate", "confirm", "plot", "report", "require", "nearest_boundary", "index"}


def fuzz(report, options):
    """Run all tests of this file, with one child process for each sound file."""
    count = max(2, round(COUNT * options.share))
    with tempfile.TemporaryDirectory() as name:
        for path, reader in sound_files(Path(name)):
            work = functools.partial(damaged, path, reader, count, options.seed)
            in_child(report, f"files {path.suffix or 'zarr'}", path.name, work)
        for path in sorted(Path(name).glob("*.json")):
            if path.name != "sep005.json":
                work = functools.partial(
                    damaged, path, use_all, count, options.seed, change=changed
                )
                in_child(report, "records", path.name, work)


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
        "structure": vi.simulate(wall, vi.Load(1.0, cosine=[1.0]), cycles=3),
    }  # fmt: skip
    found = []
    for name, result in others(vi, osc, motion).items():
        result.save(folder / f"{name}.json")
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


def others(vi, osc, motion):
    """Small results of all other studies."""
    law = vi.PowerLaw(0.9, speed=0.1, exponent=0.25)
    table = vi.TabulatedRestitution([0.0, 0.5, 2.0], [0.9, 0.8, 0.6])
    pair = vi.Structure(
        [1, 0.3], [0.1, 0], [1, 0], [vi.Gap([-1, 1], 0.5, law), vi.Gap([1, -1], 0.5, table)]
    )
    walls = vi.Structure(
        [1, 0.042], [0.01, 0], [1, 0], [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    )
    load = vi.Load(0.94, sine=[1.0, 0.0])
    moving = vi.exact(walls, load, ([1.6250583, 5.9668230], [0, 1]))
    table_top = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 0.2, 0.3)])
    shaken = vi.Load(1.0, cosine=[1.0])
    pulse = vi.Record(0.1, np.sin(np.arange(60) / 9)[:, None], constant=[0.1])
    rig = vi.virtual_record(
        duration=1.5,
        rng=3,
        M=2.7,
        K=42e3,
        m=0.11,
        d=0.006,
        xi=0.0114,
        restitution=0.7,
        F0=6.0,
        frequency=19.5,
    )
    return {
        "rest": vi.simulate(table_top, shaken, cycles=3), "record": vi.simulate(table_top, pulse),
        "laws": vi.simulate(pair, load, cycles=4, state=([0, 0], [0, -1])), "moving": moving,
        "rests": vi.exact(table_top, shaken, vi.simulate(table_top, shaken, cycles=60)),
        "path": vi.branch(moving, "frequency", (0.939, 0.941)),
        "region": vi.zone(moving, ("frequency", 0.93, 0.95), ("load", 0.95, 1.05), lines=5),
        "shares": vi.basins(walls, load, states=2, settling=20),
        "cells": vi.bifurcation_diagram(walls, load, "frequency", [0.93, 0.94], settling=2, keep=3, impacts=3),
        "rows": vi.response(walls, load, [0.93, 0.94], settling=2, keep=3),
        "exponents": vi.lyapunov(walls, load, cycles=4, discard=1, batches=2),
        "basins": vi.basins(osc, 0.94, 37.0, states=2, cycles=5, probes=1),
        "diagram": vi.bifurcation_diagram(osc, "clearance", [36.0, 38.0], r=0.94, settling=2, keep=3, impacts=3),
        "curve": vi.response(osc, [0.93, 0.94], 37.0, states=1, settling=2, keep=3),
        "lyapunov": vi.lyapunov(osc, 0.94, 20.0, cycles=40, discard=60, batches=2),
        "decay": vi.decay(osc, 1.0, cycles=3, amplitude=2.0), "full": vi.simulate(osc, 0.9, 6.0, 2, discard=30),
        "atlas": vi.atlas(osc, (0.93, 0.95), (36, 38), max_impacts=2, survey=1, lines=5, guesses=1, settling=10),
        "motions": vi.find(walls, load, guesses=2, states=2, settling=20),
        "design": vi.design(
            osc, r=(1.0, 1.02), free={"clearance": (20, 40)}, samples=20, evaluations=8, specimens=2, nodes=2,
            states=1,
            settling=20, keep=8,
        ),
        "fit": vi.identify(rig, known={"M": 2.7, "K": 42e3, "m": 0.11}),
    }  # fmt: skip


def use_result(path):
    """Read a result and use it."""
    import vibroimpact as vi

    found = vi.load(path)
    repr(found)
    found.to_json()


def use_record(path):
    """Read a record of signals."""
    import vibroimpact as vi

    repr(vi.read_record(path))


def use_sep005(path):
    """Read a record as another library would return it; reading JSON itself is not tested."""
    import vibroimpact as vi

    try:
        data = json.loads(path.read_text())
    except ValueError:
        return
    if isinstance(data, list):
        repr(vi.read_record(data))


def use_store(path):
    """Read the store of a campaign."""
    import vibroimpact as vi

    vi.Campaign(path).to_xarray("points", "lowest").load()


def ways_of(rng, path):
    """Return the function that damages files of a format."""
    return repacked if path.suffix == ".mat" and rng.random() < 0.5 else damage


def damage(rng, data):
    """Change, cut, repeat or exchange bytes."""
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


def repacked(rng, data):
    """Change bytes in one part of a MATLAB file, and correct its checksums."""
    parts, at = [], 128
    while at + 8 <= len(data):
        kind, size = struct.unpack_from("<II", data, at)
        body = data[at + 8 : at + 8 + size]
        parts.append(zlib.decompress(body) if kind == 15 else data[at : at + 8 + size])
        at += 8 + size
    i = rng.randrange(len(parts))
    # most of the damage is in the tags at the beginning
    n = rng.choice([64, 400, len(parts[i])])
    parts[i] = damage(rng, parts[i][:n]) + parts[i][n:]
    packed = [zlib.compress(part) for part in parts]
    return data[:128] + b"".join(struct.pack("<II", 15, len(part)) + part for part in packed)


def changed(rng, data):
    """Replace or remove some values of a JSON record, or change lengths of its lists."""
    data = json.loads(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        inner, key = data, None
        while isinstance(inner, (dict, list)) and inner and (key is None or rng.random() < 0.95):
            above, key = (
                inner,
                rng.choice([*inner] if isinstance(inner, dict) else range(len(inner))),
            )
            inner = inner[key]
        if key is None:
            continue
        way = rng.random()
        if way < 0.1:
            del above[key]
        elif way < 0.25 and isinstance(above, list):
            above[:] = rng.choice([above[:-1], [*above, above[0]], above[::-1], above + above])
        elif way < 0.45 and type(inner) in (int, float):
            above[key] = inner + rng.choice([-1, 1, 1000, 1e-9, -1e6])
        else:
            above[key] = copy.deepcopy(rng.choice(ODD))
    return json.dumps(data).encode()


def use_all(path):
    """Read a result and use all of it."""
    import vibroimpact as vi
    from vibroimpact.base.errors import VibroimpactError

    found = vi.load(path)
    repr(found)
    for name, _ in inspect.getmembers(type(found)):
        if name.startswith("_") or name in LEFT_OUT:
            continue
        try:
            use(found, name)
        except VibroimpactError:
            pass
        except AttributeError as error:
            if not any(
                text in str(error) for text in ("has no Oscillator", "does not have it; it has")
            ):
                raise
    for suffix in (".csv", ".json"):
        with contextlib.suppress(VibroimpactError):
            found.save(path.with_name(f"saved{suffix}"))
    left = [item.name for item in path.parent.iterdir() if ".part" in item.name]
    assert not left, left


def use(found, name):
    """Read an attribute; call a method with arguments of the kinds that it takes."""
    item = getattr(found, name)
    if not inspect.ismethod(item):
        return
    middle = {}
    for one in "start", "end":
        if isinstance(getattr(found, one, None), float):
            middle["t"] = [getattr(found, one)]
    if hasattr(found, "initial_state"):
        middle["t"] = [found.start, found.end]
    own = {
        "t": [0.0, 0.5], "x": 1.0, "y": 1.0, "r": 0.94, "clearance": 37.0, "cell": 0, "value": 0.94, "index": 0,
        "attractor": 0, "quantity": "x_max", "record": 0,
    } | middle  # fmt: skip
    arguments = [
        own[p.name] for p in inspect.signature(item).parameters.values()
        if p.default is p.empty and p.name in own
    ]  # fmt: skip
    needed = [p for p in inspect.signature(item).parameters.values() if p.default is p.empty]
    if len(needed) == len(arguments):
        item(*arguments)


def damaged(path, reader, count, seed, begin, change=None):
    """The `work` of `in_child`; `change` damages the data."""
    from vibroimpact.base.errors import VibroimpactError

    rng = random.Random(f"{seed} {path.name} {getattr(change, '__name__', '')}")
    counts, faults = [0, 0], {}
    files = [path] if path.is_file() else sorted(item for item in path.rglob("*") if item.is_file())
    for i in range(count):
        chosen = rng.choice(files)
        whole = chosen.read_bytes()
        data = (change or ways_of(rng, path))(rng, whole)
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
