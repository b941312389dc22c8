"""Files that are written completely or not at all."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Iterator
from pathlib import Path


def write_text(path: Path, text: str) -> None:
    """`write_bytes` for text in UTF-8."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under a temporary name and rename it; the old file is kept if that fails."""
    with replacing(path, path.with_name(f"{path.name}.{writer_name()}.part")) as temporary:
        temporary.write_bytes(content)


def writer_name() -> str:
    """Part of a temporary name that no other process or thread uses."""
    return f"{os.getpid()}-{threading.get_ident()}"


@contextlib.contextmanager
def replacing(path: Path, temporary: Path) -> Iterator[Path]:
    """Provide a temporary name to write to; the file replaces `path` if no error occurs.

    An error names `path`, which the user knows, and not the temporary one.
    """
    try:
        yield temporary
        os.replace(temporary, path)
    except BaseException as error:
        with contextlib.suppress(OSError):
            temporary.unlink()
        if isinstance(error, OSError) and error.errno:
            raise OSError(error.errno, os.strerror(error.errno), str(path)) from None
        raise
