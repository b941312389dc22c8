"""Results as netCDF files: their dataset, and the record from which they are restored."""

from __future__ import annotations

from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import ParameterError
from ..base.files import write_bytes
from ..base.libraries import need, need_netcdf
from ..base.sizes import TEXT, check_size, unpacked

#: Largest number of bytes to which one byte of deflated data can expand.
DEFLATED = 1032


def write_netcdf(noun: Any, path: Path) -> None:
    """Write the dataset, and the record from which `load` restores the result, completely or not at all."""
    data = noun.to_xarray()
    record = np.frombuffer(noun.to_json().encode(), dtype=np.uint8)
    data["record"] = ("byte", record, {"long_name": "the result as JSON, for vibroimpact.load"})
    save_dataset(data, path)


def save_dataset(data: Any, path: Path) -> None:
    """Write a dataset under a temporary name and rename it."""
    need_netcdf()
    packed = {
        name: {"zlib": True} for name, item in data.variables.items()
        if item.dtype.kind in "fiu" and item.size > 100
    }  # fmt: skip
    # in memory first: if the disk is full, HDF5 later crashes the interpreter. The store is used because
    # to_netcdf can write to memory only since xarray 2025.9
    content = BytesIO()
    store = import_module("xarray.backends").H5NetCDFStore(
        import_module("h5netcdf").File(content, "w")
    )
    data.dump_to_store(store, encoding=packed)
    store.close()
    write_bytes(path, content.getvalue())


def read_netcdf(path: Path) -> str:
    """The record of a file that `write_netcdf` wrote, as text.

    Only the record is read, and only if it is not larger than a file of this size can contain.
    """
    size = path.stat().st_size
    path.open("rb").close()  # an OSError with the reason, rather than the exception of h5py
    h5py = need("h5py")
    try:
        with h5py.File(path, "r") as data:
            record = data.get("record")
            if not isinstance(record, h5py.Dataset):
                raise ParameterError("there is no variable 'record'")
            if record.ndim != 1 or record.dtype.kind not in "iu":
                raise ParameterError("its variable 'record' is not a list of bytes")
            if record.size * record.dtype.itemsize > DEFLATED * size:
                raise ParameterError(
                    f"its record of {record.size} bytes is larger than a file of {size} bytes can hold"
                )
            check_size(unpacked(record), TEXT, "its record")
            return bytes(record[:].astype(np.uint8)).decode()
    except ParameterError:
        raise
    except Exception:  # any exception that h5py raises on a broken file
        raise ParameterError("it is not a netCDF file") from None
