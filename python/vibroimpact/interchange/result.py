"""What all results have in common: ways out to other programs, and back."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from ..errors import ParameterError
from ..files import write_text
from ..noun import NOUNS
from . import csv_file, dataset, matlab, netcdf, page, plain, table

Self = TypeVar("Self", bound="Result")


class Result:
    """The methods that results inherit."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain Python values, ready for JSON, by the names of the attributes.

        Complex numbers are [re, im] pairs, NaN is None.
        """
        head = {"type": type(self).__name__, "vibroimpact": version("vibroimpact")}
        own: dict[str, Any] = plain.encode(self)
        return {**head, **own}

    @classmethod
    def from_dict(cls: type[Self], data: dict[str, Any]) -> Self:
        """The inverse of `to_dict`; what is wrong with the data is said by name."""
        kind = plain.mapping(data, cls.__name__).get("type", cls.__name__)
        if kind != cls.__name__:
            raise ParameterError(f"type = {kind!r}: must be {cls.__name__!r}")
        result: Self = plain.record(cls, data, "")
        return result

    def to_json(self) -> str:
        """`to_dict` as JSON text; numbers have all their digits."""
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls: type[Self], text: str) -> Self:
        """The inverse of `to_json`: the same result to the last bit."""
        try:
            data = json.loads(text)
        except ValueError as error:
            raise ParameterError(f"text of {len(text)} characters: must be JSON; {error}") from None
        return cls.from_dict(data)

    def to_xarray(self) -> Any:
        """An xarray.Dataset with named dimensions; units and meaning of each variable (extra `data`)."""
        return dataset.to_xarray(self)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with the columns that `vibroimpact run` writes (extra `data`)."""
        return table.to_pandas(self)

    def _repr_html_(self) -> str:
        """What Jupyter shows, with a small picture if matplotlib is there."""
        return page.html(self)

    def save(self, path: str | Path) -> None:
        """Write a file, whole or not at all, of the form that its name ends with.

        .json, .nc (netCDF, labelled as `to_xarray`; extra `data`) and .mat (a MATLAB struct; extra
        `matlab`) hold every bit, and `vibroimpact.load` reads them back. .csv holds the table that
        `vibroimpact run` writes, with the case in its header, from which the result can be computed again.
        """
        place = Path(path)
        suffix = place.suffix.lower()
        if suffix not in WRITERS:
            wanted = ", ".join(WRITERS)
            raise ParameterError(f"path = {str(path)!r}: must end with one of {wanted}")
        if not place.parent.is_dir():
            raise ParameterError(f"path = {str(path)!r}: must be in a folder that is there")
        WRITERS[suffix](self, place)


def load(path: str | Path) -> Any:
    """Read a result that its `save` wrote as .json, .nc or .mat: the same to the last bit.

    Parameters
    ----------
    path : path

    Returns
    -------
    Motion, Trajectory, Branch, Zone, Atlas or another result, as it was saved.

    Raises
    ------
    ParameterError
        If there is no such file, or it is not one that `save` wrote whole.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "motion.json"
    >>> vi.equispaced(osc, r=0.94, clearance=37.0)[0].save(path)
    >>> vi.load(path)
    <Motion RL/1 at r = 0.94, d K/F0 = 37: consistent, admissible, unstable (max|lambda| = 3.828, positive)>
    """
    wanted = "must be a file that the save of a result wrote"
    if Path(path).suffix.lower() == ".csv":
        raise ParameterError(
            f"path = {str(path)!r}: must end with .json, .nc or .mat; a table whose header has its case is an "
            "input of `vibroimpact run` and read_namelist"
        )
    try:
        read = READERS.get(Path(path).suffix.lower(), READERS[".json"])
        data = json.loads(read(Path(path)))
        kind = plain.mapping(data, "").get("type")
        known = {item.__name__: item for item in Result.__subclasses__()} | NOUNS
        return known[plain.known(kind, known)].from_dict(data)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
    raise ParameterError(f"path = {str(path)!r}: {wanted}; {reason}")


WRITERS: dict[str, Callable[[Any, Path], None]] = {
    ".json": lambda result, path: write_text(path, result.to_json()),
    ".csv": csv_file.write_csv,
    ".nc": netcdf.write_netcdf,
    ".mat": matlab.write_matlab,
}
READERS: dict[str, Callable[[Path], str]] = {
    ".json": lambda path: path.read_text(encoding="utf-8"),
    ".nc": netcdf.read_netcdf,
    ".mat": matlab.read_matlab,
}
