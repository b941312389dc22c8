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
from .namelist import keys_of, parts_of, system_keys
from .systems import check_gap_numbers, system_of
from .tables import Found, Result, declared, keys_for

if TYPE_CHECKING:
    from ..systems.units import Units

Self = TypeVar("Self", bound="Savable")
#: The classes that are imported by name, and by the study whose whole result they are.
NOUNS: dict[str, type[Savable]] = {}
RESULTS: dict[str, type[Noun]] = {}
#: Former names of classes in files, and the present classes.
FORMER: dict[str, type[Savable]] = {}


def class_of(name: Any) -> type[Savable]:
    """The class of a result in a file, by its present or former name."""
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
    """A column of a table as a read-only attribute; with `first` the dimension of the column comes first,
    otherwise last.

    `of_structure` names the table, and the column if it differs, in results of structures: "table" or
    "table.column". If results of the system lack the column, an AttributeError is raised.
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


def key(*names: str, meaning: str) -> Any:
    """The value of a key of the case as a read-only attribute, or a tuple of the values of several keys. If cases
    of structures lack the key, an AttributeError is raised. `meaning` is the docstring of the attribute."""

    def value(noun: Noun) -> Any:
        if noun.of_structure:
            known = [item["name"] for item in keys_for(noun._result.study, True)]
            for name in names:
                if name not in known:
                    raise AttributeError(noun._lack(name, noun._columns()))
        keys = noun.keys
        return keys[names[0]] if len(names) == 1 else tuple(keys[name] for name in names)

    return property(value, doc=meaning)


class Savable:
    """Methods of all results: conversion to files and to objects of other libraries, and back.

    A subclass provides its tables as `_result`, and is created from tables by `of_result`.
    """

    __slots__ = ()
    #: The study that computes it.
    study: ClassVar[str] = ""
    #: Whether the result can be drawn.
    drawable: bool = True
    #: The message if the result cannot be drawn.
    undrawable: ClassVar[str] = ""
    #: Whether the vertical axis of its small picture is logarithmic.
    _log_clearance: ClassVar[bool] = False
    plot: Callable[..., Any]

    def __init_subclass__(cls, study: str = "", formerly: str = "") -> None:
        """`formerly` is the name of the class of its results of structures in older files."""
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
        """The object that contains the given tables.

        Parameters
        ----------
        result : Result
            The tables that the core or a file provides.

        Returns
        -------
        object of this class
            A view of the tables.
        """
        raise NotImplementedError

    @property
    def _system(self) -> Oscillator | Structure | None:
        """The oscillator or the structure; None without one."""
        return getattr(self, "structure" if self.of_structure else "osc", None)

    def _check_read(self) -> None:
        """Raises an error if tables read from a file are inconsistent, beyond the checks that all results
        share."""

    def _facts(self) -> dict[str, str]:
        """Names and values for Jupyter."""
        return {}

    def _lack(self, name: str, instead: str) -> str:
        """The message for an attribute that results of this system lack; it names the available ones."""
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
            Units of length, force and time, such as "mm N s" or "SI"; those of the oscillator by default.

        Returns
        -------
        Physical
            The same result; values with a dimension are in these units.

        Raises
        ------
        errors.ParameterError, errors.ParameterTypeError
            If M, K and F0 of the oscillator are not known, or a unit is not known.
        """
        return ACTIONS["physical"](self, units)

    def to_dict(self) -> dict[str, Any]:
        """The whole result as plain Python values, ready for JSON: complex numbers are [re, im], NaN is None.

        Returns
        -------
        dict
            Name of the class, the case, and the tables.
        """
        found: dict[str, Any] = ACTIONS["to_dict"](self)
        return found

    @classmethod
    def from_dict(cls: type[Self], data: dict[str, Any]) -> Self:
        """The inverse of `to_dict`; errors name the faulty item of the data.

        Parameters
        ----------
        data : dict
            What `to_dict` returned.

        Returns
        -------
        object of this class
            The result, with the same bits.
        """
        noun: Self = ACTIONS["from_dict"](cls, data)
        return noun

    def to_json(self) -> str:
        """The result of `to_dict` as JSON text; numbers have all their digits.

        Returns
        -------
        str
            One JSON object.
        """
        text: str = ACTIONS["to_json"](self)
        return text

    @classmethod
    def from_json(cls: type[Self], text: str) -> Self:
        """The inverse of `to_json`; all numbers are restored bit for bit.

        Parameters
        ----------
        text : str
            What `to_json` returned.

        Returns
        -------
        object of this class
            The result, with the same bits.
        """
        noun: Self = ACTIONS["from_json"](cls, text)
        return noun

    def to_xarray(self) -> Any:
        """The result as a dataset of xarray, with named dimensions (extra `data`).

        Like the attributes of the result, its numbers are dimensionless; `physical` converts either.

        Returns
        -------
        xarray.Dataset
            Each variable has its unit and its meaning as attributes.
        """
        return ACTIONS["to_xarray"](self)

    def to_pandas(self, units: str | None = None) -> Any:
        """The result as a data frame of pandas, with the columns and the units of the CSV (extra `data`).

        Parameters
        ----------
        units : str, optional
            Units of length, force and time, such as "mm N s" or "SI", or "dimensionless". By default those of the
            oscillator if it has M, K and F0, with mm for m.

        Returns
        -------
        pandas.DataFrame
            One row for each row of the CSV. For an oscillator in physical units, ``attrs["units"]`` has the names
            of the units by column.

        Raises
        ------
        errors.ParameterError, errors.ParameterTypeError
            If M, K and F0 of the oscillator or a unit are not known.
        """
        return ACTIONS["to_pandas"](self, units)

    def save(self, path: str | Path, units: str | None = None) -> None:
        """Write a file, completely or not at all; the extension sets the format.

        .json, .nc (netCDF, labelled as by `to_xarray`; extra `data`) and .mat (a MATLAB struct; extra `matlab`)
        keep every bit, and `vibroimpact.load` reads them back. .csv is the table that `vibroimpact run` writes;
        the case in its header reproduces the result.

        Parameters
        ----------
        path : str or Path
            The file.
        units : str, optional
            Units of length, force and time, such as "mm N s" or "SI", or "dimensionless". By default a .csv file
            is in the units of the oscillator if it has M, K and F0, with mm for m; the other formats are
            dimensionless and also contain the units.

        Raises
        ------
        errors.ParameterError, errors.ParameterTypeError
            If the path does not end with a known extension, or M, K and F0 of the oscillator or a unit are not
            known.
        """
        ACTIONS["save"](self, path, units)

    @classmethod
    def _load(cls: type[Self], path: str | Path) -> Self:
        """Load a result of this class from a file that `save` wrote."""
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
    """The values that a solver computes, read-only and by name; each kind of system has its own set."""

    __slots__ = ()
    #: Values of an oscillator that are computed from the other values, by name.
    _derived: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}
    #: For each name that only one kind of system has, the name of its counterpart for the other kind.
    _instead: ClassVar[tuple[Mapping[str, str], Mapping[str, str]]] = ({}, {})

    def __init__(self, **values: Any) -> None:
        put = object.__setattr__
        for name, value in values.items():
            put(self, name, value)

    def __getattr__(self, name: str) -> Any:
        """A value that the solver did not provide: computed from the others, or an error."""
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
        """The values that the solver provided."""
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
        """Whether its system is a `Structure` with its load, and not an `Oscillator`."""
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
        The input of the study as a namelist.
    complete : bool
        False if Ctrl-C stopped the study early; `cut` then says how far it got.
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
        """`part`: whether the result of a case contains several objects of this class instead of being one."""
        super().__init_subclass__(study, formerly)
        cls.example = example
        if cls.study and not part:
            RESULTS[cls.study] = cls

    def __init__(self, result: Result) -> None:
        object.__setattr__(self, "_result", result)

    @classmethod
    def of_result(cls: type[Self], result: Result) -> Self:
        """The object that contains the given tables.

        Parameters
        ----------
        result : Result
            The tables that the core or a file provides.

        Returns
        -------
        object of this class
            A view of the tables.
        """
        return cls(result)  # type: ignore[call-arg]

    @classmethod
    def computed(cls: type[Self], case: Any, progress: Callable[[float, str], None] | None) -> Self:
        """The result of a case, for studies that the Python package computes itself (`in_python`).

        Parameters
        ----------
        case : Case
            The checked case.
        progress : callable or None
            Called with the fraction done and the current task; None for a bar on a terminal or in a notebook.

        Returns
        -------
        object of this class
            The result of the case.
        """
        raise NotImplementedError

    def parts(self) -> list[Any]:
        """The objects of which the result of a case consists; each is saved and drawn separately.

        Returns
        -------
        list
            The result itself, unless it contains several objects.
        """
        return [self]

    def require(self) -> None:
        """Raise an error if the result is missing, for a case that requests a single result."""

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
        """The input of the study as a namelist."""
        return self._result.case

    @property
    def cut(self) -> str:
        """How far the study got, if it was stopped early; "" if it is complete."""
        return self._result.cut

    @property
    def complete(self) -> bool:
        """Whether the study ran to its end; `cut` otherwise says how far it got."""
        return not self._result.cut

    @property
    def of_structure(self) -> bool:
        """Whether its system is a `Structure` with its load, and not an `Oscillator`."""
        return self._result.of_structure

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of the study and of &system with their values.

        If the case of a file lacks a key, reading the key raises an error that names it.
        """
        if self.of_structure:
            groups = parts_of(self.case) or [("", {})]
            return Found(groups[-1][1], "case")
        return Found(keys_of(self.case), "case")

    @property
    def osc(self) -> Oscillator:
        """The oscillator."""
        if self.of_structure:
            raise AttributeError(self._lack("osc", "structure and load"))
        keys = system_keys(self.case)
        if "xi" not in keys:
            raise AttributeError(self._lack("osc", "a case without &system"))
        return Oscillator._of_keys(Found(keys, "case"))

    @property
    def structure(self) -> Structure:
        """The structure."""
        if not self.of_structure:
            raise AttributeError(self._lack("structure", "osc"))
        return system_of(self.case)[0]

    @property
    def load(self) -> Any:
        """The load of a structure, or the load amplitude of an oscillator."""
        if not self.of_structure:
            return self.keys["load"]
        load = system_of(self.case)[1]
        return load if isinstance(load, Load) else None  # no study but `simulate` accepts a record

    def _values(self, table: str, name: str, attribute: str = "") -> NDArray[Any]:
        """A decoded column of a table; AttributeError if results of this system lack it."""
        known = declared(self._result.study, self.of_structure)
        if (table, name) not in known:
            raise AttributeError(self._lack(attribute or name, self._columns()))
        return self._result.column(table, name).decoded()

    def _columns(self) -> str:
        """The columns that results of this system have, by their attribute names where they are attributes."""
        known = declared(self._result.study, self.of_structure)
        own = [
            name
            for kind in type(self).__mro__
            for name, item in vars(kind).items()
            if isinstance(item, column) and name[0] != "_" and item.place(self) in known
        ]
        return ", ".join(own or dict.fromkeys(name for _, name in known))

    def to_namelist(self) -> str:
        """The case as a namelist, from which the program, the command and Python compute identical digits.

        Returns
        -------
        str
            The groups of the case, with all defaults filled in.
        """
        return self.case
