"""Run namelist files through the compiled reader and writer, the same that the batch program uses."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import _core
from .errors import ParameterError

__all__ = ["RunLog", "run_namelists"]


class RunLog(NamedTuple):
    """What was said while namelist files ran.

    Attributes
    ----------
    lines : list of (bool, str)
        Whether the line is a fault, and the line.
    status : int
        0 done; 1 ran, but a motion failed or does not exist; 2 an input is wrong.
    """

    lines: list[tuple[bool, str]]
    status: int


def run_namelists(
    paths: Iterable[str | os.PathLike[str]], folder: str | os.PathLike[str] = "results"
) -> RunLog:
    """Run namelist files and write one result a case into a folder.

    Parameters
    ----------
    paths : iterable of path
        Files with the groups &system, &motion, &output (see inputs/README.md), or earlier results.
    folder : path
        Made if it is not there.

    Returns
    -------
    RunLog

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> namelist = folder / "pair.nml"
    >>> _ = namelist.write_text(
    ...     "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\\n"
    ...     "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\\n"
    ... )
    >>> log = vi.run_namelists([namelist], folder)
    >>> log.status, log.lines
    (0, [(False, 'pair: consistent, admissible, stable (max|lambda| = 0.9347, complex)')])
    >>> (folder / "pair.csv").exists()
    True
    """
    files = [os.fsencode(path) for path in paths]
    target = os.fsencode(folder)
    if not files:
        raise ParameterError("paths = []: must name at least one file")
    for item in [*files, target]:
        if not item or b"\n" in item or b"\0" in item:
            raise ParameterError(
                f"path = {os.fsdecode(item)!r}: must not be empty or hold a line feed"
            )
    # a case takes at least 20 characters of namelist and says at most a few hundred
    size = sum(Path(os.fsdecode(item)).stat().st_size for item in files if os.path.isfile(item))
    room = 4096 + (len(files) + size // 20) * (600 + len(target) + max(map(len, files)))
    joined = b"\n".join(files)
    text, length, status = _core.run_namelists(
        np.frombuffer(joined, "S1"), np.frombuffer(target, "S1"), room
    )
    said = os.fsdecode(text[:length].tobytes())
    lines = [(line.startswith("!"), line[1:]) for line in said.split("\n") if line]
    return RunLog(lines, int(status))
