"""Labelled tables: xarray, imported when it is needed (extra `data`)."""

from ..interchange.dataset import xarray

__all__ = ["xarray"]
