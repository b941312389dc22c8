"""Libraries of the extras, which may not be installed."""

from __future__ import annotations

from typing import Any

from .errors import MissingExtraError


def xarray(what: str = "tables") -> Any:
    """The xarray module, or an error that says what needs it and how to install it."""
    try:
        import xarray as module
    except ImportError:
        raise MissingExtraError(f"{what} need xarray: pip install 'vibroimpact[data]'") from None
    return module


def scipy_signal(what: str) -> Any:
    """The module scipy.signal, or an error that says what needs it and how to install it."""
    try:
        import scipy.signal as module
    except ImportError:
        raise MissingExtraError(
            f"{what} needs scipy: pip install 'vibroimpact[identify]'"
        ) from None
    return module


def scipy_linalg(what: str) -> Any:
    """The module scipy.linalg, or an error that says what needs it and how to install it."""
    try:
        import scipy.linalg as module
    except ImportError:
        raise MissingExtraError(
            f"{what} needs scipy: pip install 'vibroimpact[identify]'"
        ) from None
    return module
