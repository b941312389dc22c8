"""The base classes of all results: conversion to files and other libraries, and read-only views of tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from ..base.actions import ACTIONS
from ..base.errors import ParameterError
from ..systems.oscillator import Oscillator
from ..systems.structure import Load, Structure
from .namelist import keys_of, parts_of
from .systems import check_gap_numbers, system_of
from .tables import Found, Result, declared, keys_for

if TYPE_CHECKING:
    from ..systems.units import Units

Self = TypeVar("Self", bound="Savable")
#: The classes that are imported by name, and by the study whose whole result they are.
NOUNS: dict[str, type[Savable]] = {}
RESULTS: dict[str, type[Noun]] = {}
#: The classes of results in files by the names that they had before.
FORMER: dict[str, type[Savable]] = {}


def class_of(name: Any) -> type[Savable]:
    """The class of results in files by its name, or the name that it had before."""
    ACTIONS["import_all"]()
    found = (NOUNS | FORMER).get(name) if isinstance(name, str) else None
    if found is None:
        raise ParameterError(f"type = {name!r}: must be one of {', '.join(sorted(NOUNS))}")
    return found


def result_class(study: str) -> type[Noun]:
    """The class of the whole result of a study."""
    if study not in RESULTS:
        ACTIONS["import_all"]()
    return RESULTS[study]


class column:  # noqa: N801 (a descriptor, written as property is)
    """A column of a table as an attribute, read-only; its own dimension comes last, or `first`.

    of_structure: the table in results of structures, and the column, where they differ: "table" or "table.column".
    A column that results of a system do not have is an AttributeError.
    """

    def __init__(
        self, table: str, name: str = "", first: bool = False, of_structure: str = ""
    ) -> None:
        self.table = table
        self.name = name
        self.first = first
        self.of_structure = of_structure
        self.attribute = name

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self.name or name
        self.attribute = name

    @overload
    def __get__(self, noun: None, owner: type) -> column: ...
    @overload
    def __get__(self, noun: Noun, owner: type) -> NDArray[Any]: ...
    def __get__(self, noun: Noun | None, owner: type) -> Any:
        if noun is None:
            return self
        return self.shaped(noun, noun._values(*self.place(noun), self.attribute))

    def place(self, noun: Noun) -> tuple[str, str]:
        """The table and the column."""
        if not (noun.of_structure and self.of_structure):
            return self.table, self.name
        table, _, name = self.of_structure.partition(".")
        return table, name or self.name

    def shaped(self, noun: Noun, values: NDArray[Any]) -> NDArray[Any]:
        """The values of the table in the order of the attribute."""
        return np.moveaxis(values, -1, 0) if self.first else values


def key(*names: str) -> Any:
    """The value of a key of the case as an attribute, read-only; a tuple of the values of several keys. A key that
    cases of structures lack is an AttributeError."""

    def value(noun: Noun) -> Any:
        if noun.of_structure:
            known = [item["name"] for item in keys_for(noun._result.study, True)]
            for name in names:
                if name not in known:
                    raise AttributeError(noun._lack(name, noun._columns()))
        keys = noun.keys
        return keys[names[0]] if len(names) == 1 else tuple(keys[name] for name in names)

    return property(value)


class Savable:
    """What all results can do: conversion to files and to objects of other libraries, and back.

    A class gives its tables as `_result`, and is made of such tables by `of_result`.
    """

    __slots__ = ()
    #: The study that computes it.
    study: ClassVar[str] = ""
    #: Whether there is something to draw.
    drawable: bool = True
    #: The message if there is nothing to draw.
    undrawable: ClassVar[str] = ""
    #: Whether the vertical axis of its small picture is logarithmic.
    _log_clearance: ClassVar[bool] = False
    plot: Callable[..., Any]

    def __init_subclass__(cls, study: str = "", formerly: str = "") -> None:
        """`formerly`: the class of its results of structures in older files."""
        super().__init_subclass__()
        if study:  # a dataclass with slots is created a second time, without these arguments
            cls.study = study
        if cls.study:
            NOUNS[cls.__name__] = cls
        if formerly:
            FORMER[formerly] = cls

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a {type(self).__name__} cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"{name}: a {type(self).__name__} cannot be changed")

    @property
    def of_structure(self) -> bool:
        """Whether its system is a `Structure` with its load, and not an `Oscillator`."""
        return False

    @property
    def _result(self) -> Result:
        """The tables."""
        raise NotImplementedError

    @classmethod
    def of_result(cls: type[Self], result: Result) -> Self:
        """The object that has these tables."""
        raise NotImplementedError

    def _check_read(self) -> None:
        """An error if tables that were read from a file do not fit together, beyond what all results share."""

    def _facts(self) -> dict[str, str]:
        """Names and values for Jupyter."""
        return {}

    def _lack(self, name: str, instead: str) -> str:
        """The message for an attribute that results of its system do not have, with what they have instead."""
        system = "a Structure" if self.of_structure else "an Oscillator"
        return f"{name}: a {type(self).__name__} of {system} does not have it; it has {instead}"

    def _draw_small(self, ax: Any) -> None:
        """The small picture for Jupyter."""
        self.plot(ax=ax)

    def _draw(self, *options: Any, units: Units | str | None = None) -> Any:
        """The picture of this class, with the options of its function in `plot`."""
        return ACTIONS["draw"](self, *options, units=units)

    def _animate(self, *options: Any, units: Units | str | None = None) -> Any:
        """The animation, with the options of `plot.animate`."""
        return ACTIONS["animate_result"](self, *options, units=units)

    def physical(self, units: Units | str | None = None) -> Any:
        """The result in physical units, a `Physical`: see `vibroimpact.physical`.

        Parameters
        ----------
        units : Units or str, optional
            Units of length, force and time, as "mm N s" or "SI"; those of the oscillator by default.

        Raises
        ------
        errors.ParameterError, errors.ParameterTypeError
            If the oscillator does not know M, K and F0, or a unit is not known.
        """
        return ACTIONS["physical"](self, units)

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain Python values, ready for JSON: complex numbers are [re, im], NaN is None."""
        found: dict[str, Any] = ACTIONS["to_dict"](self)
        return found

    @classmethod
    def from_dict(cls: type[Self], data: dict[str, Any]) -> Self:
        """The inverse of `to_dict`; errors name the faulty item of the data."""
        noun: Self = ACTIONS["from_dict"](cls, data)
        return noun

    def to_json(self) -> str:
        """`to_dict` as JSON text; numbers have all their digits."""
        text: str = ACTIONS["to_json"](self)
        return text

    @classmethod
    def from_json(cls: type[Self], text: str) -> Self:
        """The inverse of `to_json`; the result has the same bits."""
        noun: Self = ACTIONS["from_json"](cls, text)
        return noun

    def to_xarray(self) -> Any:
        """An xarray.Dataset with named dimensions, and with the unit and meaning of each variable (extra
        `data`)."""
        return ACTIONS["to_xarray"](self)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame with the columns of the CSV (extra `data`)."""
        return ACTIONS["to_pandas"](self)

    def save(self, path: str | Path, units: str | None = None) -> None:
        """Write a file, completely or not at all; the extension sets the format.

        .json, .nc (netCDF, labelled as `to_xarray`; extra `data`) and .mat (a MATLAB struct; extra
        `matlab`) hold every bit, and `vibroimpact.load` reads them back. .csv holds the table that
        `vibroimpact run` writes, with the case in its header, from which the result can be computed again.

        Parameters
        ----------
        path : str or Path
            The file.
        units : str, optional
            Units of length, force and time, as "mm N s" or "SI", or "dimensionless". By default a .csv is in those
            of the oscillator, if it has M, K and F0, with mm for m; the other formats are dimensionless, and
            contain the units.

        Raises
        ------
        errors.ParameterError, errors.ParameterTypeError
            If the path does not end with a known extension, or the oscillator or a unit is not known.
        """
        ACTIONS["save"](self, path, units)

    @classmethod
    def _load(cls: type[Self], path: str | Path) -> Self:
        """A result of this class that `save` wrote."""
        result = ACTIONS["load"](path)
        if not isinstance(result, cls):
            raise ParameterError(
                f"path = {str(path)!r}: must be a file that {cls.__name__}.save wrote, not a "
                f"{type(result).__name__}"
            )
        return result

    def _repr_html_(self) -> str:
        """The representation in Jupyter, with a small picture if matplotlib is installed."""
        page: str = ACTIONS["html"](self, ACTIONS["thumbnail"](self))
        return page


class Solution(Savable):
    """What a solver computes of a system: values by name, read-only, of which each system has its own."""

    __slots__ = ()
    #: Values of an oscillator that follow from the others, by name.
    _derived: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}
    #: What an oscillator, and a structure, have instead of what the other one has.
    _instead: ClassVar[tuple[Mapping[str, str], Mapping[str, str]]] = ({}, {})

    def __init__(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __getattr__(self, name: str) -> Any:
        """A value that the solver has not given: one that follows from the others, or an error."""
        if name.startswith("__"):
            raise AttributeError(name)
        of_structure = self.of_structure
        if name in self._derived and not of_structure:
            found = self._derived[name](self)
            if isinstance(found, np.ndarray):
                found.flags.writeable = False
            return found
        if name in self._instead[of_structure]:
            raise AttributeError(self._lack(name, self._instead[of_structure][name]))
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __reduce__(self) -> Any:
        return solution, (type(self), self._values())

    def _values(self) -> dict[str, Any]:
        """The values that the solver gave."""
        here, found = object.__getattribute__, dict[str, Any]()
        names: tuple[str, ...] = type(self).__slots__
        for name in names:
            with suppress(AttributeError):
                found[name] = here(self, name)
        return found

    def __replace__(self: Self, **values: Any) -> Self:
        return type(self)(**self._values() | values)  # type: ignore[attr-defined]

    @property
    def of_structure(self) -> bool:
        try:
            object.__getattribute__(self, "osc")
        except AttributeError:
            return True
        return False

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax, kind="history")


def solution(kind: type[Solution], values: dict[str, Any]) -> Solution:
    """A solution from its values, for pickle."""
    return kind(**values)


class Noun(Savable):
    """A result of a study as a view of its tables.

    Attributes
    ----------
    case : str
        What was asked for, as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ("_result",)
    #: The options of an example command, for studies whose command has no module of its own.
    example: ClassVar[str] = ""
    #: Whether the core provides a printout of it.
    printable: ClassVar[bool] = False
    _result: Result

    def __init_subclass__(
        cls, study: str = "", part: bool = False, example: str = "", formerly: str = ""
    ) -> None:
        """`part`: whether the result of a case contains several objects of this class, rather than being one."""
        super().__init_subclass__(study, formerly)
        cls.example = example
        if cls.study and not part:
            RESULTS[cls.study] = cls

    def __init__(self, result: Result) -> None:
        object.__setattr__(self, "_result", result)

    @classmethod
    def of_result(cls: type[Self], result: Result) -> Self:
        return cls(result)  # type: ignore[call-arg]

    @classmethod
    def computed(cls: type[Self], case: Any, progress: Callable[[float, str], None] | None) -> Self:
        """The result of a case that the Python package computes, for such studies (`in_python`)."""
        raise NotImplementedError

    def parts(self) -> list[Any]:
        """What the result of a case consists of: the objects that are saved and drawn each by itself."""
        return [self]

    def require(self) -> None:
        """An error if the result is not there, of a case that asks for one thing."""

    def __reduce__(self) -> Any:
        return type(self), (self._result,)

    def _facts(self) -> dict[str, str]:
        if not self.of_structure:
            return {}
        structure = self.structure
        return {"coordinates": str(structure.coordinates), "gaps": str(len(structure.gaps))}

    def _check_read(self) -> None:
        if self.of_structure and not self._result.empty:
            check_gap_numbers(self._result, self.structure)

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
    def of_structure(self) -> bool:
        return self._result.of_structure

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of the study and their values, with those of &system; one that the case of a file lacks is an
        error that names it."""
        if self.of_structure:
            groups = parts_of(self.case) or [("", {})]
            return Found(groups[-1][1], "case")
        return Found(keys_of(self.case), "case")

    @property
    def osc(self) -> Oscillator:
        """The oscillator."""
        if self.of_structure:
            raise AttributeError(self._lack("osc", "structure and load"))
        keys = self.keys
        if "xi" not in keys:
            raise AttributeError(self._lack("osc", "a case without &system"))
        return Oscillator._of_keys(keys)

    @property
    def structure(self) -> Structure:
        """The structure."""
        if not self.of_structure:
            raise AttributeError(self._lack("structure", "osc"))
        return system_of(self.case)[0]

    @property
    def load(self) -> Any:
        """The load of a structure, or the amplitude of that of an oscillator."""
        if not self.of_structure:
            return self.keys["load"]
        load = system_of(self.case)[1]
        return load if isinstance(load, Load) else None  # no study takes a record

    def _values(self, table: str, name: str, attribute: str = "") -> NDArray[Any]:
        """A column of a table, decoded; an AttributeError if results of its system do not have it."""
        known = declared(self._result.study, self.of_structure)
        if (table, name) not in known:
            raise AttributeError(self._lack(attribute or name, self._columns()))
        return self._result.column(table, name).decoded()

    def _columns(self) -> str:
        """The columns that results of its system have, by the names of their attributes if they are such."""
        known = declared(self._result.study, self.of_structure)
        own = [
            name
            for kind in type(self).__mro__
            for name, item in vars(kind).items()
            if isinstance(item, column) and name[0] != "_" and item.place(self) in known
        ]
        return ", ".join(own or dict.fromkeys(name for _, name in known))

    def to_namelist(self) -> str:
        """The case as a namelist; the program, the command and Python compute the same digits from it."""
        return self.case
