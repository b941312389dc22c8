"""The store of a campaign: a folder with Zarr groups, which are written once and can be read while it runs."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
import shutil
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np

from ..errors import ParameterError
from ..libraries import zarr
from .chunk import Chunk

__all__ = ["Store"]

#: The campaign that a store holds.
PLAN = "campaign.json"
#: The array of a chunk with what is not in its tables, as JSON in UTF-8.
HEADS = "heads"


class Store:
    """A folder with the chunks of one campaign, each a Zarr group of results.zarr, whose checksums are in sums.

    A chunk is written into a temporary folder and renamed, after its checksums: it is there as a whole, or not at
    all. Its name has a hash of its cases and of the core.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self.chunks = self.folder / "results.zarr"
        self.sums = self.folder / "sums"
        self.failures = self.folder / "failures"

    def plan(self) -> dict[str, Any]:
        """The plan of the campaign: its cases, their study, and how many make a chunk."""
        path = self.folder / PLAN
        try:
            found = json.loads(path.read_text())
            if not isinstance(found, dict) or "study" not in found:
                raise ValueError
        except FileNotFoundError:
            raise ParameterError(
                f"store = {str(self.folder)!r}: must be the store of a campaign; it has no {PLAN}"
            ) from None
        except (ValueError, UnicodeDecodeError):
            raise ParameterError(f"{path}: is damaged; restore it, or use another store") from None
        return found

    @contextlib.contextmanager
    def writing(self, plan: dict[str, Any]) -> Iterator[None]:
        """Hold the store for one writer of this plan; parts of files from a writer that was killed are removed."""
        zarr()
        make_folder(self.folder)
        with locked(self.folder):
            path = self.folder / PLAN
            if path.exists():
                self._compare(plan)
            else:
                foreign = [item.name for item in self.folder.iterdir() if item.name != "lock"]
                if foreign:
                    raise ParameterError(
                        f"store = {str(self.folder)!r}: must be an empty folder, a new one, or the store of this "
                        f"campaign; it holds {foreign[0]!r}"
                    )
                write_whole(path, json.dumps(plan, indent=1))
            for part in self.folder.glob("*.part"):
                shutil.rmtree(part) if part.is_dir() else part.unlink()
            self.sums.mkdir(exist_ok=True)
            zarr().open_group(str(self.chunks), mode="a", zarr_format=3)
            yield

    def _compare(self, plan: dict[str, Any]) -> None:
        """An error if the store holds another campaign."""
        held = self.plan()
        for key, value in plan.items():
            if key in ("core", "vibroimpact") and held.get(key) != value:
                raise ParameterError(
                    f"store = {str(self.folder)!r}: was computed by another build of vibroimpact "
                    f"({held.get('vibroimpact')}); must be another folder, since results of two are not mixed"
                )
            if held.get(key) != value:
                raise ParameterError(
                    f"store = {str(self.folder)!r}: holds another campaign (its {key} differs); must be another "
                    "folder"
                )

    def names(self) -> list[str]:
        """The chunks that are there, in the order of their cases."""
        if not self.chunks.is_dir():
            return []
        return sorted(item.name for item in self.chunks.iterdir() if item.is_dir())

    def state(self, name: str) -> str:
        """Whether a chunk is 'done', 'missing', or 'damaged', by the checksums of its files."""
        place = self.chunks / name
        if not place.is_dir():
            return "missing"
        try:
            whole = json.loads(self._sums(name).read_text()) == checksums(place)
        except (OSError, ValueError):
            whole = False
        return "done" if whole else "damaged"

    def _sums(self, name: str) -> Path:
        return self.sums / f"{name}.json"

    def write(self, name: str, chunk: Chunk) -> None:
        """Write a chunk, completely or not at all."""
        part = self.folder / f"{secrets.token_hex(8)}.part"
        try:
            write_arrays(part, chunk)
            write_whole(self._sums(name), json.dumps(checksums(part), indent=1))
            place = self.chunks / name
            if place.exists():  # damaged
                shutil.rmtree(place)
            os.replace(part, place)
        except BaseException as error:
            shutil.rmtree(part, ignore_errors=True)
            if isinstance(error, OSError) and error.errno:
                raise OSError(error.errno, os.strerror(error.errno), str(self.folder)) from None
            raise

    def read(self, name: str) -> Chunk:
        """A chunk; an error if a file of it is damaged."""
        place = self.chunks / name
        if self.state(name) != "done":
            raise ParameterError(
                f"{place}: is {self.state(name)}; run the campaign again, which computes this part anew"
            )
        try:
            # in format 2 a file may name pickle as what decodes an array
            group = zarr().open_group(str(place), mode="r", zarr_format=3)
            held = json.loads(np.asarray(group[HEADS][...]).tobytes())
            arrays = {
                name: {key: np.asarray(array[...]) for key, array in table.arrays()}
                for name, table in group.groups()
            }
        except (OSError, LookupError, TypeError, ValueError) as error:
            raise ParameterError(f"{place}: is no chunk that a campaign wrote; {error}") from None
        words = {(table, key): tuple(words) for table, key, words in held["words"]}
        return Chunk(held["study"], held["heads"], arrays, words)

    def fail(self, number: int, text: str, message: str) -> None:
        """Keep a case that failed as a namelist that runs."""
        self.failures.mkdir(exist_ok=True)
        lines = "".join(f"! {line}\n" for line in message.splitlines())
        write_whole(self.failures / f"case_{number}.nml", lines + text)


def write_arrays(folder: Path, chunk: Chunk) -> None:
    """The arrays of a chunk as a Zarr group, in which each table is a group."""
    library = zarr()
    group = library.create_group(str(folder), zarr_format=3)
    codec = library.codecs.ZstdCodec(level=3, checksum=True)
    heads = json.dumps({
        "study": chunk.study, "heads": chunk.heads,
        "words": [[*place, list(words)] for place, words in sorted(chunk.words.items())],
    })  # fmt: skip
    group.create_array(
        HEADS,
        data=np.frombuffer(heads.encode(), "u1"),
        compressors=[codec],
        dimension_names=["byte"],
    )
    for name, columns in chunk.arrays.items():
        table = group.create_group(name)
        for key, values in columns.items():
            dims = [f"{name}_row", f"{name}_{key}_item"][: values.ndim]
            words = chunk.words.get((name, key))
            table.create_array(
                key, data=np.ascontiguousarray(values), chunks=tuple(max(1, n) for n in values.shape),
                compressors=[codec], dimension_names=dims,
                attributes={"words": ["", *words]} if words else {},
            )  # fmt: skip


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of all files of a chunk."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            found[path.relative_to(folder).as_posix()] = hashlib.sha256(
                path.read_bytes()
            ).hexdigest()
    return found


def write_whole(path: Path, text: str) -> None:
    """Write a text file, completely or not at all."""
    part = path.with_name(f"{secrets.token_hex(8)}.part")
    try:
        part.write_text(text)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def make_folder(folder: Path) -> None:
    """Make the folder of a store."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise ParameterError(f"store = {str(folder)!r}: must be a folder; it is a file") from None


def take(lock: IO[str]) -> None:
    """Lock an open file for this process; an error if another one holds it."""
    try:
        import fcntl
    except ImportError:  # Windows
        import msvcrt

        lock.seek(0)
        msvcrt.locking(lock.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        return
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the store; the system gives it free when this process ends, however it ends."""
    with open(folder / "lock", "a+", encoding="utf-8") as lock:
        try:
            take(lock)
        except (BlockingIOError, PermissionError):
            lock.seek(0)
            holder = lock.read().strip() or "another process"
            raise ParameterError(
                f"store = {str(folder)!r}: {holder} writes to it; wait for its end, or use another store"
            ) from None
        lock.truncate(0)
        lock.write(f"process {os.getpid()} on {socket.gethostname()}")
        lock.flush()
        try:
            yield
        finally:
            lock.truncate(0)
