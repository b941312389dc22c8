"""The base class of all results: a read-only view of tables, with conversion to files, pictures and other
libraries.

This is the only file that uses formats and pictures; they do not depend on any study.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from .interchange.namelist import keys_of
from .model import Oscillator
from .tables import Result

Self = TypeVar("Self", bound="Noun")
#: The classes by their names, for results that are read from files.
NOUNS: dict[str, type[Noun]] = {}


def noun_of(study: str) -> type[Noun]:
    """The class of the results of a study."""
    return next(noun for noun in NOUNS.values() if noun.study == study)


class column:  # noqa: N801 (a descriptor, written as property is)
    """A column of a table as an attribute, read-only; its own dimension comes last, or `first`."""

    def __init__(self, table: str, name: str = "", first: bool = False) -> None:
        self.table = table
        self.name = name
        self.first = first

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self.name or name

    @overload
    def __get__(self, noun: None, owner: type) -> column: ...
    @overload
    def __get__(self, noun: Noun, owner: type) -> NDArray[Any]: ...
    def __get__(self, noun: Noun | None, owner: type) -> Any:
        if noun is None:
            return self
        values = noun._result.tables[self.table].columns[self.name].decoded()
        return np.moveaxis(values, -1, 0) if self.first else values


class Noun:
    """A result of a study.

    Attributes
    ----------
    case : str
        What was asked for, as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ("_result",)
    _result: Result
    study: ClassVar[str] = ""
    #: The options of a command that makes one, for studies whose command has no module of its own.
    example: ClassVar[str] = ""

    def __init_subclass__(cls, study: str = "", example: str = "") -> None:
        super().__init_subclass__()
        cls.study, cls.example = study, example
        NOUNS[cls.__name__] = cls

    def __init__(self, result: Result) -> None:
        object.__setattr__(self, "_result", result)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a {type(self).__name__} cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a {type(self).__name__} cannot be changed")

    def __reduce__(self) -> Any:
        return type(self), (self._result,)

    @property
    def case(self) -> str:
        return self._result.case

    @property
    def cut(self) -> str:
        return self._result.cut

    @property
    def complete(self) -> bool:
        return not self._result.cut

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of the case and their values."""
        return keys_of(self.case)

    @property
    def osc(self) -> Oscillator:
        """The system."""
        keys = self.keys
        return Oscillator(keys["xi"], keys["mu"], tuple(np.atleast_1d(keys["restitution"])))

    def to_namelist(self) -> str:
        """The case as a namelist; the program, the command and Python compute the same digits from it."""
        return self.case

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain Python values, ready for JSON: complex numbers are [re, im], NaN is None."""
        from .formats import record

        return record.to_dict(self)

    @classmethod
    def from_dict(cls: type[Self], data: dict[str, Any]) -> Self:
        """The inverse of `to_dict`; errors name the faulty item of the data."""
        from .formats import record

        noun: Self = record.from_dict(cls, data)
        return noun

    def to_json(self) -> str:
        """`to_dict` as JSON text; numbers have all their digits."""
        from .formats import record

        return record.to_json(self)

    @classmethod
    def from_json(cls: type[Self], text: str) -> Self:
        """The inverse of `to_json`; the result has the same bits."""
        from .formats import record

        noun: Self = record.from_json(cls, text)
        return noun

    def to_xarray(self) -> Any:
        """An xarray.Dataset with named dimensions, and with the unit and meaning of each variable (extra
        `data`)."""
        from .formats import dataset

        return dataset.to_xarray(self)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with the columns of the CSV (extra `data`)."""
        from .formats import rows

        return rows.to_pandas(self)

    def save(self, path: str | Path) -> None:
        """Write a file, completely or not at all; the extension sets the format.

        .json, .nc (netCDF, labelled as `to_xarray`; extra `data`) and .mat (a MATLAB struct; extra
        `matlab`) hold every bit, and `vibroimpact.load` reads them back. .csv holds the table that
        `vibroimpact run` writes, with the case in its header, from which the result can be computed again.
        """
        from .formats import save

        save.save(self, path)

    def _repr_html_(self) -> str:
        """The representation in Jupyter, with a small picture if matplotlib is installed."""
        from .formats import html

        return html.html(self)
