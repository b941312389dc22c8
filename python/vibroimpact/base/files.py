"""Files that are written completely or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterable, Iterator
from pathlib import Path

from . import checks
from .errors import ParameterError


def place_for(path: str | Path, endings: Iterable[str]) -> Path:
    """The path of a file to be written.

    Raises
    ------
    ParameterError
        If the path has none of the allowed endings, or its folder does not exist.
    """
    place = checks.path(path)
    if place.suffix.lower() not in endings:
        raise ParameterError(f"path = {str(path)!r}: must end with one of {', '.join(endings)}")
    if not place.parent.is_dir():
        raise ParameterError(f"path = {str(path)!r}: must be in an existing folder")
    return place


def write_text(path: Path, text: str) -> None:
    """`write_bytes` for text in UTF-8."""
    write_bytes(path, text.encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under a temporary name and rename it; the old file is kept if that fails."""
    with replacing(path) as temporary:
        temporary.write_bytes(content)


@contextlib.contextmanager
def replacing(path: Path, ending: str = "") -> Iterator[Path]:
    """Provide a new, empty file in the folder of `path`, which replaces `path` if no error occurs; its name ends
    with `ending`.

    Errors name `path`, which the user knows, instead of the temporary file.
    """
    temporary = None
    try:
        temporary = new_file(path, ending)
        yield temporary
        os.replace(temporary, path)
    except BaseException as error:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink()
        if isinstance(error, OSError) and error.errno:
            raise OSError(error.errno, os.strerror(error.errno), str(path)) from None
        raise


def new_file(path: Path, ending: str = "") -> Path:
    """Make an empty file in the folder of another file, under a name that cannot be predicted.

    It is created only if nothing with this name exists, not even a link, and it has the permissions of an ordinary
    new file (with `tempfile` no other user could read it).
    """
    while True:
        place = path.with_name(f"{path.stem[:40]}.{secrets.token_hex(8)}.part{ending}")
        try:
            os.close(os.open(place, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
            return place
        except FileExistsError:
            continue
        except KeyboardInterrupt:  # nobody else knows the name yet
            place.unlink(missing_ok=True)
            raise
