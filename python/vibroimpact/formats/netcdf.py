"""Results as netCDF files: their dataset, and the record from which they are made again."""

from __future__ import annotations

from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingExtraError, ParameterError
from ..files import write_bytes
from ..libraries import xarray


def write_netcdf(noun: Any, path: Path) -> None:
    """Write the dataset, and the record from which `load` makes the result again, whole or not at all."""
    data = noun.to_xarray()
    record = np.frombuffer(noun.to_json().encode(), dtype=np.uint8)
    data["record"] = ("byte", record, {"long_name": "the result as JSON, for vibroimpact.load"})
    save_dataset(data, path)


def need_netcdf() -> None:
    """An error that says how to get them, if netCDF files cannot be written."""
    xarray("netCDF files")
    try:
        import_module("h5netcdf")
    except ImportError:
        raise MissingExtraError(
            "netCDF files need h5netcdf: pip install 'vibroimpact[data]'"
        ) from None


def save_dataset(data: Any, path: Path) -> None:
    """Write a dataset under a temporary name and rename it."""
    need_netcdf()
    packed = {
        name: {"zlib": True} for name, item in data.variables.items()
        if item.dtype.kind in "fiu" and item.size > 100
    }  # fmt: skip
    # in memory first: HDF5 ends the interpreter some time after a disk was full; by the store, as
    # to_netcdf does so only from xarray 2025.9 on, which Python 3.10 does not get
    content = BytesIO()
    store = import_module("xarray.backends").H5NetCDFStore(
        import_module("h5netcdf").File(content, "w")
    )
    data.dump_to_store(store, encoding=packed)
    store.close()
    write_bytes(path, content.getvalue())


def read_netcdf(path: Path) -> str:
    """The record of a file that `write_netcdf` wrote, as text."""
    path.open("rb").close()  # an OSError that says why, rather than what h5py makes of it
    need_netcdf()
    try:
        with xarray().open_dataset(path, engine="h5netcdf", decode_times=False) as data:
            if "record" not in data:
                raise ParameterError("there is no variable 'record'")
            return bytes(data["record"].values.astype(np.uint8)).decode()
    except ParameterError:
        raise
    except Exception:  # whatever h5py stumbles on in a file that is broken
        raise ParameterError("it is no netCDF file") from None
