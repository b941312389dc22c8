"""The store of a campaign: a folder with Zarr groups, each written once and readable while the campaign runs."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
import secrets
import shutil
import socket
from collections.abc import Container, Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..base.libraries import zarr
from ..base.sizes import NUMBERS, TEXT, check_file, check_size
from ..results.tables import present
from .chunk import Chunk

__all__ = ["Store"]

#: The file that describes the campaign of a store.
PLAN = "campaign.json"
#: The keys that every plan has.
PARTS = {"study", "size", "chunk", "core", "vibroimpact"}
#: All keys of a plan besides its sweep; in earlier versions the name of the study implied the model.
OWN = PARTS | {"of_structure"}
#: The name of a chunk: its first case, and a hash.
NAME = re.compile(r"\d{12,}-[0-9a-f]{40}")
#: The name of a folder that is being written.
PART = re.compile(r"[0-9a-f]{16}\.part")
#: The array of a chunk with all data that are not in its tables, as JSON in UTF-8.
HEADS = "heads"
#: The metadata of a Zarr group.
GROUP = {"attributes": {}, "zarr_format": 3, "node_type": "group"}
#: Names of types in Zarr, with their fill values (never used: all values are written).
TYPES: dict[str, tuple[str, Any]] = {
    "|u1": ("uint8", 0), "<i4": ("int32", 0), "<f8": ("float64", 0.0), "<c16": ("complex128", [0.0, 0.0]),
}  # fmt: skip


class Store:
    """A folder with the chunks of a campaign: each is a Zarr group in results.zarr, with its checksums in sums.

    A chunk is written into a temporary folder, which is renamed after the checksums are written, so that a chunk
    exists completely or not at all. Its name contains a hash of its cases and of the core.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        if not isinstance(folder, (str, os.PathLike)) or not str(folder):
            raise ParameterTypeError(f"store = {folder!r}: must be the path of a folder")
        self.folder = checks.path(folder, "store")
        self.chunks = self.folder / "results.zarr"
        self.sums = self.folder / "sums"
        self.failures = self.folder / "failures"

    def plan(self) -> dict[str, Any]:
        """The plan of the campaign: its cases, their study, and the number of cases in a chunk."""
        path = self.folder / PLAN
        try:
            found = read_json(path)
            if not found.keys() >= PARTS:
                raise ValueError
            if not all(type(found[key]) is int and found[key] > 0 for key in ("size", "chunk")):
                raise ValueError
        except FileNotFoundError:
            raise ParameterError(
                f"store = {str(self.folder)!r}: must be the store of a campaign; it has no {PLAN}"
            ) from None
        except NotADirectoryError:
            raise ParameterError(
                f"store = {str(self.folder)!r}: must be a folder; it is a file"
            ) from None
        except (IsADirectoryError, ValueError):
            raise ParameterError(f"{path}: is damaged; restore it, or use another store") from None
        return found

    @contextlib.contextmanager
    def writing(self, plan: dict[str, Any]) -> Iterator[None]:
        """Lock the store for one writer of this plan; incomplete files left by a killed writer are removed."""
        zarr()
        make_folder(self.folder)
        with locked(self.folder):
            path = self.folder / PLAN
            for place in (self.folder, self.sums, self.failures, self.chunks):
                if place.is_symlink() and place != self.folder:
                    raise ParameterError(f"{place}: must be a folder; it is a link")
                for part in place.glob("*.part"):
                    if PART.fullmatch(part.name):
                        remove(part)
            if path.exists():
                self._compare(plan)
            else:
                foreign = [item.name for item in self.folder.iterdir() if item.name != "lock"]
                if foreign:
                    raise ParameterError(
                        f"store = {str(self.folder)!r}: must be an empty folder, a new one, or the store of this "
                        f"campaign; it holds {foreign[0]!r}"
                    )
                write_whole(path, json.dumps(plan, indent=1), lasting=True)
            self.sums.mkdir(exist_ok=True)
            self.chunks.mkdir(exist_ok=True)
            write_whole(self.chunks / "zarr.json", json.dumps(GROUP))
            yield

    def _compare(self, plan: dict[str, Any]) -> None:
        """Raises an error if the store holds another campaign."""
        held = self.plan()
        for key, value in plan.items():
            if key in ("core", "vibroimpact") and held.get(key) != value:
                raise ParameterError(
                    f"store = {str(self.folder)!r}: was computed by a different build of vibroimpact "
                    f"({held.get('vibroimpact')}); must be another folder: results of two builds are not mixed"
                )
            if held.get(key) != value:
                raise ParameterError(
                    f"store = {str(self.folder)!r}: contains another campaign (its {key} differs); must be "
                    "another folder"
                )

    def names(self) -> list[str]:
        """The existing chunks, in the order of their cases."""
        if not self.chunks.is_dir():
            return []
        return sorted(filter(NAME.fullmatch, os.listdir(self.chunks)))

    def state(self, name: str) -> str:
        """The state of a chunk, 'done', 'missing' or 'damaged', according to the checksums of its files."""
        place = self.chunks / name
        if not place.is_dir():
            return "missing"
        try:
            whole = read_json(self._sums(name)) == checksums(place)
        except (OSError, ValueError):
            whole = False
        return "done" if whole else "damaged"

    def _sums(self, name: str) -> Path:
        return self.sums / f"{name}.json"

    def write(self, name: str, chunk: Chunk) -> None:
        """Write a chunk, completely or not at all."""
        part = self.folder / f"{secrets.token_hex(8)}.part"
        try:
            part.mkdir()
            sums = {}
            for path, content in files_of(chunk):
                (part / path).parent.mkdir(parents=True, exist_ok=True)
                (part / path).write_bytes(content)
                sums[path] = hashlib.sha256(content).hexdigest()
            if self._sums(name).is_dir():
                remove(self._sums(name))
            write_whole(self._sums(name), json.dumps(dict(sorted(sums.items())), indent=1))
            place = self.chunks / name
            remove(place)  # remove a damaged chunk
            os.replace(part, place)
        except BaseException as error:
            shutil.rmtree(part, ignore_errors=True)
            if isinstance(error, OSError) and error.errno:
                raise OSError(error.errno, os.strerror(error.errno), str(self.folder)) from None
            raise

    def _contents(self, name: str) -> Contents:
        """The files of a chunk."""
        try:
            sums = read_json(self._sums(name))
        except (OSError, ValueError):
            raise damaged(self.chunks / name) from None
        place = self.chunks / name
        return Contents(place, os.path.realpath(place), sums)

    def columns(self, name: str, table: str, keys: Iterable[str]) -> dict[str, NDArray[Any]]:
        """Some columns of a chunk; None if the chunk lacks one of them because none of its cases has it."""
        files = self._contents(name)
        wanted = tuple(dict.fromkeys(keys))
        if not all(f"{table}/{key}/zarr.json" in files.sums for key in wanted):
            return {}
        found = files.arrays(f"{table}/{key}" for key in wanted)
        return dict(zip(wanted, found, strict=True))

    def table(
        self, name: str, table: str, coded: Container[str]
    ) -> tuple[dict[str, NDArray[Any]], dict[str, tuple[str, ...]]]:
        """All columns of a table of a chunk, and the words of the columns that contain codes of words."""
        files = self._contents(name)
        keys = [
            path.split("/")[1] for path in files.sums
            if path.startswith(f"{table}/") and path.endswith("/zarr.json") and path.count("/") == 2
        ]  # fmt: skip
        arrays = files.arrays(f"{table}/{key}" for key in keys)
        words = {key: files.words(f"{table}/{key}") for key in keys if key in coded}
        return dict(zip(keys, arrays, strict=True)), words

    def heads(self, name: str) -> dict[str, Any]:
        """The data of a chunk that are not in its tables."""
        (text,) = self._contents(name).arrays([HEADS])
        check_size(text.size, TEXT, f"{self.chunks / name}: its {HEADS}")
        with foreign(self.chunks / name):
            held: dict[str, Any] = json.loads(text.tobytes())
            if not held.keys() >= {"study", "heads", "words"}:
                raise KeyError
        return held

    def read(self, name: str) -> Chunk:
        """Read a chunk; an error if one of its files is damaged."""
        held = self.heads(name)
        files = self._contents(name)
        arrays: dict[str, dict[str, NDArray[Any]]] = {}
        paths = [
            path.removesuffix("/zarr.json") for path in files.sums if path.endswith("/zarr.json")
        ]
        paths = [path for path in paths if "/" in path]
        for path, values in zip(paths, files.arrays(paths), strict=True):
            table, _, key = path.rpartition("/")
            arrays.setdefault(table, {})[key] = values
        with foreign(self.chunks / name):
            words = {(table, key): tuple(words) for table, key, words in held["words"]}
        return Chunk(present(held["study"]), held["heads"], arrays, words)

    def fail(self, number: int, text: str, message: str) -> None:
        """Save a case that failed as a namelist that can be run."""
        self.failures.mkdir(exist_ok=True)
        lines = "".join(f"! {line}\n" for line in message.splitlines())
        write_whole(self.failures / f"case_{number}.nml", lines + text)

    def failed(self) -> int:
        """The number of cases that were rejected or failed."""
        return sum(1 for _ in self.failures.glob("case_*.nml"))

    def clear(self, numbers: Iterable[int]) -> None:
        """Remove the namelists of cases that failed earlier, for instance on a worker short of memory, and now
        succeeded."""
        if self.failures.is_dir():
            for number in numbers:
                (self.failures / f"case_{number}.nml").unlink(missing_ok=True)
            with contextlib.suppress(OSError):  # it contains other files
                self.failures.rmdir()


class Contents(NamedTuple):
    """The files of a chunk, with their checksums."""

    place: Path
    real: str
    sums: dict[str, str]

    def bytes(self, path: str) -> bytes:
        """The content of a file; an error if it is damaged or outside the chunk, KeyError if the chunk has no such
        file."""
        if path not in self.sums:
            raise KeyError(path)
        file = Path(os.path.realpath(os.path.join(self.real, path)))
        if not str(file).startswith(self.real + os.sep):
            raise ParameterError(
                f"{self.place}: is not a chunk written by a campaign; {path!r} leads out of it"
            )
        try:
            check_file(file, NUMBERS, str(file))
            content = file.read_bytes()
        except OSError:
            raise damaged(self.place) from None
        if hashlib.sha256(content).hexdigest() != self.sums[path]:
            raise damaged(self.place)
        return content

    def arrays(self, paths: Iterable[str]) -> list[NDArray[Any]]:
        """Read arrays that `array_files` wrote; if they do not fit into memory, an error is raised before any is
        unpacked."""
        with foreign(self.place):
            about = {path: self.declared(path) for path in paths}
            together = sum(
                np.dtype(kind).itemsize * math.prod(shape) for kind, shape in about.values()
            )
            check_size(together, NUMBERS, f"{self.place}: the data to be read")
            return [self.unpacked(path, *item) for path, item in about.items()]

    def declared(self, path: str) -> tuple[str, list[int]]:
        """The kind and shape that an array declares."""
        about = json.loads(self.bytes(f"{path}/zarr.json"))
        (kind,) = (kind for kind, (name, _) in TYPES.items() if name == about["data_type"])
        if about["codecs"] != codecs(kind):
            raise ValueError("its arrays are compressed in another way")
        return kind, about["shape"]

    def words(self, path: str) -> tuple[str, ...]:
        """The words that the codes (from 1) in an array refer to."""
        with foreign(self.place):
            about = json.loads(self.bytes(f"{path}/zarr.json"))
            return tuple(map(str, about["attributes"].get("words", ())[1:]))

    def unpacked(self, path: str, kind: str, shape: list[int]) -> NDArray[Any]:
        """Unpack an array of this kind and shape."""
        if 0 in shape:
            return np.empty(shape, kind)
        packed = self.bytes(f"{path}/{'.'.join('0' * len(shape))}")
        size = np.dtype(kind).itemsize * math.prod(shape)
        if unpacked_size(packed) != size:
            raise ValueError(f"{path} does not unpack to the {size} bytes that it declares")
        found: NDArray[Any] = np.frombuffer(codec().decode(packed), kind).reshape(shape)
        return found


def unpacked_size(packed: bytes) -> int:
    """The size that a frame of Zstandard (RFC 8878, 3.1.1.1) declares; -1 if it declares none."""
    if len(packed) < 14:
        return -1
    whole = packed[4] >> 5 & 1  # a single segment
    width = (whole, 2, 4, 8)[packed[4] >> 6]
    at = 5 + (1 - whole) + (0, 1, 2, 4)[packed[4] & 3]
    declared = int.from_bytes(packed[at : at + width], "little")
    return declared + 256 * (width == 2) if width else -1


def damaged(place: Path) -> ParameterError:
    """The error for a chunk that has changed since it was written."""
    return ParameterError(
        f"{place}: is damaged; run the campaign again, which computes this part anew"
    )


@contextlib.contextmanager
def foreign(place: Path) -> Iterator[None]:
    """One error for any content that no campaign wrote, even if the checksums are right."""
    try:
        yield
    except ParameterError:
        raise
    except (AttributeError, LookupError, RuntimeError, TypeError, ValueError) as error:
        raise ParameterError(f"{place}: is not a chunk written by a campaign; {error}") from None


def codec() -> Any:
    """The compressor of the arrays."""
    zarr()
    return import_module("numcodecs.zstd").Zstd(level=3, checksum=True)  # zarr requires it


def codecs(kind: str) -> list[dict[str, Any]]:
    """The packing of values of this type, as Zarr describes it."""
    order = {} if np.dtype(kind).itemsize == 1 else {"configuration": {"endian": "little"}}
    return [
        {"name": "bytes", **order},
        {"name": "zstd", "configuration": {"level": 3, "checksum": True}},
    ]


def files_of(chunk: Chunk) -> Iterator[tuple[str, bytes]]:
    """The files of a chunk as a Zarr group, in which each table is a group.

    They are written here rather than by the zarr library, whose files depend on its release and which takes 0.2 s
    for these small arrays.
    """
    group = json.dumps(GROUP).encode()
    heads = json.dumps({
        "study": chunk.study, "heads": chunk.heads,
        "words": [[*place, list(words)] for place, words in sorted(chunk.words.items())],
    })  # fmt: skip
    yield "zarr.json", group
    yield from array_files(HEADS, np.frombuffer(heads.encode(), "|u1"), ["byte"])
    for name, columns in chunk.arrays.items():
        yield f"{name}/zarr.json", group
        for key, values in columns.items():
            dims = [f"{name}_row", f"{name}_{key}_item"][: values.ndim]
            yield from array_files(f"{name}/{key}", values, dims, chunk.words.get((name, key)))


def array_files(
    path: str, values: NDArray[Any], dims: list[str], words: tuple[str, ...] | None = None
) -> Iterator[tuple[str, bytes]]:
    """The files of a Zarr array in one piece: metadata and values."""
    name, fill = TYPES[values.dtype.str]
    shape = [max(1, size) for size in values.shape]
    about = {
        "zarr_format": 3, "node_type": "array", "shape": values.shape, "data_type": name, "fill_value": fill,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": shape}},
        "chunk_key_encoding": {"name": "v2", "configuration": {"separator": "."}},
        "codecs": codecs(values.dtype.str),
        "attributes": {"words": ["", *words]} if words else {}, "dimension_names": dims,
    }  # fmt: skip
    yield f"{path}/zarr.json", json.dumps(about).encode()
    if values.size:
        yield f"{path}/{'.'.join('0' * values.ndim)}", codec().encode(np.ascontiguousarray(values))


def read_json(path: Path) -> dict[str, Any]:
    """Read a JSON object from a file."""
    check_file(path, TEXT, str(path))
    found = json.loads(path.read_text())
    if not isinstance(found, dict):
        raise ValueError
    return found


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of all files of a chunk."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*") if path.is_file()
    }  # fmt: skip


def remove(path: Path) -> None:
    """Remove a file or a folder, if it exists."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_whole(path: Path, text: str, lasting: bool = False) -> None:
    """Write a text file completely or not at all; with `lasting`, also in case of a power failure."""
    part = path.with_name(f"{secrets.token_hex(8)}.part")
    try:
        with open(part, "w", encoding="utf-8") as file:
            file.write(text)
            if lasting:
                file.flush()
                os.fsync(file.fileno())
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


def take(lock: IO[bytes]) -> None:
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
    """Lock the store; the operating system releases the lock when this process ends, however it ends."""
    # links are not followed: in a folder of another user, a link could point to any file of this user
    flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    with open(os.open(folder / "lock", flags, 0o666), "r+b", buffering=0) as lock:
        try:
            take(lock)
        except (BlockingIOError, PermissionError):
            lock.seek(0)
            holder = lock.read().decode(errors="replace").strip() or "another process"
            raise ParameterError(
                f"store = {str(folder)!r}: {holder} is writing to it; wait for it to finish, or use another store"
            ) from None
        except OSError as error:  # some network file systems have no locks
            raise OSError(
                error.errno, f"{error.strerror}: its disk must have file locks (flock)", str(folder)
            ) from None
        lock.truncate(0)
        lock.seek(0)
        with contextlib.suppress(OSError):  # a full disk is reported by the next write of data
            lock.write(f"process {os.getpid()} on {socket.gethostname()}".encode())
        try:
            yield
        finally:
            lock.truncate(0)
