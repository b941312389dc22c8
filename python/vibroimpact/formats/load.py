"""Reads the files that `save` wrote."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base import checks
from ..base.errors import MissingExtraError, ParameterError, ParameterTypeError
from ..base.sizes import check_file
from ..results.noun import class_of
from ..systems.units import Units
from .matlab import read_matlab
from .netcdf import read_netcdf
from .record import mapping


def read_text(path: Path) -> str:
    """The text of a file."""
    check_file(path)
    return path.read_text(encoding="utf-8")


READERS: dict[str, Callable[[Path], str]] = {
    ".json": read_text,
    ".nc": read_netcdf,
    ".mat": read_matlab,
}

#: Largest number of characters of the reason in a message.
LONGEST = 400


def load(path: str | Path) -> Any:
    """Read a result that its `save` wrote as .json, .nc or .mat, with the same bits.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Motion, Trajectory, Branch, Zone, Atlas or another result
        The result as it was saved; in physical units if it was saved in physical units.

    Raises
    ------
    ParameterError
        If there is no such file, or it is not a complete file that `save` wrote.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "motion.json"
    >>> vi.equispaced(osc, r=0.94, clearance=37.0)[0].save(path)
    >>> vi.load(path)
    <Motion RL/1 at r = 0.94, d K/F0 = 37: admissible, unstable (max|lambda| = 3.828)>
    """
    wanted = "must be a file written by `save` of a result"
    place = checks.path(path)
    if place.suffix.lower() == ".csv":
        raise ParameterError(
            f"path = {str(path)!r}: must end with .json, .nc or .mat; a CSV table whose header contains its case "
            "can be read by `vibroimpact run` and read_namelist"
        )
    try:
        read = READERS.get(place.suffix.lower(), READERS[".json"])
        data = json.loads(read(place))
        found = class_of(mapping(data, "record").get("type")).from_dict(data)
        if "physical" not in data:
            return found
        units: dict[str, Any] = mapping(data["physical"], "physical")
        return found.physical(
            Units(units.get("M"), units.get("K"), units.get("F0"), units.get("names"))  # type: ignore[arg-type]
        )
    except RecursionError:
        reason = "it is nested too deeply"
    except MemoryError:
        reason = "it needs more memory than is available"
    except MissingExtraError:
        raise
    except (OSError, ParameterTypeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
    if len(reason) > LONGEST:
        reason = f"{reason[: LONGEST // 2]} ... {reason[-LONGEST // 2 :]}"
    raise ParameterError(f"path = {str(path)!r}: {wanted}; {reason}")
