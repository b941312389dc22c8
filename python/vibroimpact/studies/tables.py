"""Labelled tables: xarray, imported when it is needed (extra `data`)."""

from __future__ import annotations

from typing import Any

from ..errors import MissingExtraError


def xarray() -> Any:
    """The xarray module, or an error that says how to get it."""
    try:
        import xarray as module
    except ImportError:
        raise MissingExtraError("tables need xarray: pip install 'vibroimpact[data]'") from None
    return module
