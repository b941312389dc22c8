"""Limits on the size of files that are read as a whole: a small file can declare, or unpack to, any size."""

from __future__ import annotations

import contextlib
import math
import os
from pathlib import Path
from types import TracebackType
from typing import Any

from .errors import OutOfMemoryError, ParameterError, VibroimpactError

#: Bytes of memory that may be needed for each byte of a text, and for each byte of packed numbers.
TEXT, NUMBERS = 16, 4
#: Bytes of memory that are assumed to be always free; asking the system would take longer than reading a small
#: file.
SMALL = 2**20


def free() -> int:
    """Bytes of memory available, as reported by the system."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            lines = dict(line.split(":") for line in file)
        return 1024 * int(lines["MemAvailable"].split()[0])
    except (OSError, LookupError, ValueError):
        pass
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):  # Windows
        return 2**33


def check_size(size: int, each: int, what: str) -> None:
    """Raise an error, before the content is read or unpacked, if it would not fit into memory.

    Parameters
    ----------
    size : int
        Bytes, as the file declares them.
    each : int
        Bytes of memory needed for each byte of the file.
    what : str
        Name of what has this size, for the message.

    Raises
    ------
    ParameterError
        If the size is above the limit; the message gives both.

    Examples
    --------
    >>> from vibroimpact.base.sizes import TEXT, check_size
    >>> check_size(1000, TEXT, "it")
    >>> check_size(10**18, TEXT, "its record")
    Traceback (most recent call last):
    vibroimpact.ParameterError: its record has 1000000000000000000 bytes; must have at most ...
    """
    if size * each <= SMALL:
        return
    limit = free() // each
    if size > limit:
        raise ParameterError(
            f"{what} has {size} bytes; must have at most {limit}, 1/{each} of the free memory"
        )


def check_file(path: Path, each: int = TEXT, what: str = "it") -> None:
    """Raise an error if a file does not fit into memory; `what` names it in the message.

    Raises
    ------
    OSError, ParameterError
        If there is no such file, or it is too large.
    """
    check_size(path.stat().st_size, each, what)


class memory_for(contextlib.ContextDecorator):  # noqa: N801
    """Turn a MemoryError into an error of the package; `what` says what the arrays are for, and which argument can
    make them smaller.

    Raises
    ------
    OutOfMemoryError

    Examples
    --------
    >>> from vibroimpact.base.sizes import memory_for
    >>> with memory_for("all of it"):
    ...     raise MemoryError("Unable to allocate 1 PiB")
    Traceback (most recent call last):
    vibroimpact.OutOfMemoryError: all of it: needs more memory than is available; Unable to allocate 1 PiB
    """

    def __init__(self, what: str) -> None:
        self.what = what

    def __enter__(self) -> None:
        pass

    def __exit__(
        self, kind: type | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if isinstance(error, MemoryError) and not isinstance(error, VibroimpactError):
            raise OutOfMemoryError(
                f"{self.what}: needs more memory than is available; {error}"
            ) from None


def unpacked(data: Any) -> int:
    """Bytes needed to read a dataset of h5py: the values, and one chunk, which can be larger."""
    chunk = math.prod(data.chunks or (0,))
    return int((data.size + chunk) * data.dtype.itemsize)
