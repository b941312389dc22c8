"""Optional libraries of the extras, which may not be installed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from .errors import MissingExtraError


def xarray(what: str = "tables") -> Any:
    """The xarray module, or an error that says what needs it and how to install it."""
    try:
        import xarray as module
    except ImportError:
        raise MissingExtraError(f"{what} need xarray: pip install 'vibroimpact[data]'") from None
    return module


def scipy(module: str, what: str, extra: str = "identify") -> Any:
    """A module of scipy, or an error that says what needs it and how to install it."""
    try:
        return import_module(f"scipy.{module}")
    except ImportError:
        raise MissingExtraError(f"{what} needs scipy: pip install 'vibroimpact[{extra}]'") from None


def zarr() -> Any:
    """The zarr module, or an error that says what needs it and how to install it."""
    try:
        import zarr as module
    except ImportError:
        raise MissingExtraError(
            "a campaign's store needs zarr: pip install 'vibroimpact[campaign]' (Python 3.11 or newer)"
        ) from None
    return module


def need_netcdf() -> None:
    """Raises an error that says what to install, if netCDF files cannot be written."""
    xarray("netCDF files")
    for name in ("h5py", "h5netcdf"):
        need(name)


def need(name: str) -> Any:
    """A library of the extra for data, or an error that says how to get it."""
    try:
        return import_module(name)
    except ImportError:
        raise MissingExtraError(
            f"netCDF files need {name}: pip install 'vibroimpact[data]'"
        ) from None
