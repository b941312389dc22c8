"""Results in physical units: columns, attributes, samples, files and pictures, by the declared unit of each."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, Generic, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from .base import checks
from .base.errors import ParameterTypeError
from .motions.quantities import SHOWN, Quantities, Signal
from .results import namelist
from .results.events import Sample
from .results.gradient import Gradient, frozen
from .results.noun import Savable
from .results.systems import system_of
from .results.tables import Column, Found, Result, declared, settled
from .systems.oscillator import Oscillator, Pattern, Point
from .systems.structure import Load, Structure
from .systems.units import (
    GAP,
    MIXED,
    PHYSICAL_GAP,
    RATIO,
    Units,
    chosen_units,
    has_unit,
    powers_of,
)

__all__ = ["Physical", "physical"]

From = TypeVar("From")
One = TypeVar("One", bound=Savable)

#: The dimensionless units of attributes that are not columns of a result.
UNITS = {
    "t": "1/omega", "time": "1/omega", "period": "1/omega", "duration": "1/omega",
    "x": "F0/K", "z": "F0/K", "X": "F0/K", "Z": "F0/K", "Y": "F0/K", "clearance": "F0/K",
    "x_dot": "omega F0/K", "z_dot": "omega F0/K", "X_dot": "omega F0/K", "Z_dot": "omega F0/K",
    "X_ddot": "omega^2 F0/K", "Z_ddot": "omega^2 F0/K", "load": "F0", "phase": "rad", "phases": "rad",
    "alpha": "rad", "start": "1/omega", "end": "1/omega", "speeds": "omega F0/K", "impulses": "F0/omega",
    "q": "F0/K", "q_dot": "omega F0/K", "load_phase": "rad", "attenuation": "", "cycles": "", "cycle": "", "r": "",
    "xi": "", "mu": "", "R1": "", "R2": "", "restitution": "", "x_over_D": "",
} | Quantities.units  # fmt: skip


#: Those of quantities that only derivatives have, and of the parameters by which they are taken.
OF_GRADIENT = {
    "approach_speeds": "omega F0/K", "gaps_right": "F0/K", "gaps_left": "F0/K", "x_rms": "F0/K",
    "fundamental_amplitude": "F0/K", "fundamental_phase": "rad", "stability_margin": "", "z": "F0/K",
    "z_dot": "omega F0/K", "R": "",
}  # fmt: skip
#: The dimensionless units of the numbers of a point.
POINT = {"r": "", "clearance": "F0/K", "amplitude": "F0", "friction": "F0"}
#: Methods of a zone at points.
OF_POINTS = ("contains", "count", "motion", "undecided")


@cache
def units_by_name(study: str) -> dict[str, str]:
    """The dimensionless unit of each name of a result of a study; MIXED where tables differ."""
    found = dict(UNITS)
    own: dict[str, str] = {}
    for (_, name), about in declared(study).items():
        unit = about["unit"]
        own[name] = unit if own.setdefault(name, unit) == unit else MIXED
    return found | own


@overload
def physical(result: Physical[From], units: Units | str | None = None) -> Physical[From]: ...
@overload
def physical(result: One, units: Units | str | None = None) -> Physical[One]: ...
@overload
def physical(result: Any, units: Units | str | None = None) -> Any: ...
def physical(result: Any, units: Units | str | None = None) -> Any:
    """A result, or its dataset, in physical units.

    Parameters
    ----------
    result : Motion, Trajectory, Zone or another result of an Oscillator, or xarray.Dataset
        The result, dimensionless.
    units : Units or str, optional
        Units of length, force and time, such as "mm N s" or "SI"; those of the oscillator by default.
        `Oscillator.units` returns Units for another load amplitude F0.

    Returns
    -------
    Physical, or xarray.Dataset
        The same result; values with a dimension are in these units.

    Raises
    ------
    ParameterError, ParameterTypeError
        If M, K and F0 of the oscillator are not known, or a unit is not known.

    Examples
    --------
    A rig of 2.7 kg on 42 kN/m with a particle of 0.11 kg and 2 mm of travel, driven by 6 N at 19.5 Hz:

    >>> import vibroimpact as vi
    >>> rig = vi.Oscillator.from_dimensional(
    ...     M=2.7, K=42e3, C=7.7, m=0.11, restitution=0.75, F0=6.0, units="m N s"
    ... )
    >>> units = rig.units()
    >>> run = vi.simulate(
    ...     rig, units.frequency_ratio(f=19.5), units.clearance(d=0.002), cycles=10, discard=300
    ... )
    >>> in_mm = vi.physical(run, "mm N s")
    >>> round(in_mm.clearance, 9), round(in_mm.frequency, 9)
    (2.0, 19.5)
    """
    if hasattr(result, "data_vars"):
        case = result.attrs.get("case")
        if not isinstance(case, str):
            raise ParameterTypeError(
                "result: must be a dataset of a result; its attribute 'case' is missing"
            )
        system: Any = (
            system_of(case)[0] if namelist.has_scales(case)
            else Oscillator._of_keys(namelist.system_keys(case))
        )  # fmt: skip
        return dataset(result, chosen_units(result, system, units))
    if isinstance(result, Physical):
        return Physical(
            result.result,
            result.units.to(units) if isinstance(units, str) else units or result.units,
        )
    known = chosen_units(result, getattr(result, "_system", getattr(result, "osc", None)), units)
    return in_units(result, known)


def in_units(result: Any, units: Units) -> Any:
    """A result in units; a trajectory or a motion of a structure is that of the structure in these units."""
    if getattr(result, "of_structure", False) and hasattr(result, "_in"):
        return result._in(units)
    return Physical(result, units)


class Physical(Generic[From]):
    """A result in physical units. It has the attributes of the result; values with a dimension are in `units`.

    `clearance` is d, the whole travel of the free mass between the walls; `frequency` is that of the load in
    cycles per unit of time. `r` and all other dimensionless numbers are those of the result. `save` and
    `vibroimpact.load` keep the units.

    Attributes
    ----------
    result : Motion, Trajectory, Zone, …
        The result, dimensionless.
    units : Units
    """

    __slots__ = ("result", "units")
    result: From
    units: Units

    def __init__(self, result: From, units: Units) -> None:
        checks.instance(units, "units", Units)
        object.__setattr__(self, "result", result)
        object.__setattr__(self, "units", units)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{name}: a result cannot be changed")

    def __reduce__(self) -> Any:
        return Physical, (self.result, self.units)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = getattr(self.result, name)
        if name.startswith("_"):
            return value
        if callable(value) and name in OF_POINTS and self._of.study == "zone":
            return partial(self._at_points, name)
        if callable(value):
            raise AttributeError(f"{name}: has no form in physical units; use that of `result`")
        return self._converted(name, value)

    def _converted(self, name: str, value: Any) -> Any:
        """An attribute value in physical units; an error if its unit is not known."""
        if isinstance(value, (bool, str, int, Pattern, Oscillator, np.bool_)) or value is None:
            return value
        if name == "sensitivity":  # derivatives have quotients of units
            raise AttributeError(f"{name}: has no form in physical units; use that of `result`")
        if isinstance(value, np.ndarray) and value.dtype.kind in "biUOS":
            return value
        if isinstance(value, np.ndarray) and value.dtype.names:
            table = value.copy()
            for field in value.dtype.names:
                table[field] = self._converted(field, value[field])
            table.flags.writeable = False
            return table
        if isinstance(value, Mapping):
            # of a state, without the extra keys for a bitwise continuation
            study = getattr(self._of, "study", "")  # a point has none
            names = units_by_name("design") if study == "design" else UNITS
            return {key: self._converted(key, item) for key, item in value.items() if key in names}
        if hasattr(value, "study"):
            return in_units(value, self.units)
        if isinstance(value, (Structure, Load)):
            return value._in(self.units)
        if isinstance(value, Sample):
            return Sample(
                *(self._converted(field, item) for field, item in value._asdict().items())
            )
        if isinstance(value, Quantities):
            fields = {item.name: getattr(value, item.name) for item in dataclasses.fields(value)}
            converted = {key: self._converted(key, item) for key, item in fields.items()}
            shown = {"_unit_names": tuple(map(self.units.name, SHOWN))}
            return replace(value, **converted | shown)
        if isinstance(value, (list, tuple)) and not hasattr(value, "_fields"):
            return [self._converted(name, item) for item in value]
        of_point = isinstance(self._of, Point)
        unit = (POINT if of_point else units_by_name(self._of.study)).get(name, MIXED)
        if unit == MIXED and not of_point:
            columns = settled(self._of._result).columns()
            known = [item.unit for _, item in columns if item.name == name and item.unit != MIXED]
            unit = known[0] if known else MIXED
        if unit == MIXED or not isinstance(value, (float, complex, np.ndarray, np.number, Signal)):
            raise AttributeError(f"{name}: has no form in physical units; use that of `result`")
        scale = self.units.scale(unit)
        if isinstance(value, Signal):
            return Signal(
                value.mean * scale, value.rms * scale, value.least * scale, value.greatest * scale,
                value.harmonics * scale,
            )  # fmt: skip
        return value * scale if powers_of(unit) else value

    def _at_points(self, name: str, x: Any, y: Any) -> Any:
        """A method of a zone at frequencies, in cycles per unit of time, and clearances d; values may have
        units."""
        r = (
            x
            if has_unit(x)
            else checks.real_array(x, "frequency", "numbers") / self.units.frequency
        )
        clearance = (
            y if has_unit(y) else checks.real_array(y, "clearance", "numbers") / self.units.length
        )
        if name != "motion":
            return getattr(self.result, name)(r, clearance)
        places = (one if has_unit(one) else np.asarray(one).item() for one in (r, clearance))
        found = self._of.motion(*places)
        return None if found is None else Physical(found, self.units)

    @property
    def frequency(self) -> Any:
        """Cycles of the load per unit of time."""
        return self._of.r * self.units.frequency

    @property
    def _of(self) -> Any:
        """The result (typed loosely, since its attributes depend on its class)."""
        return self.result

    @property
    def _result(self) -> Result:
        """Its tables in physical units."""
        return tables(self._of._result, self.units)

    def sample(self, t: ArrayLike) -> Sample:
        """Positions, velocities, accelerations and load at physical times, as from `sample` of the result.

        Parameters
        ----------
        t : array_like
            Times in the unit of time.

        Returns
        -------
        Sample
            Arrays in the shape of the times, in these units.
        """
        times = checks.real_array(t, "t", "real times") / self.units.time
        # the conversion rounds the ends of a trajectory; they still count as within it
        for name in ("start", "end"):
            end = getattr(self.result, name, math.nan)
            times = np.where(np.isclose(times, end, rtol=1e-14, atol=0), end, times)
        sample: Sample = self._converted("sample", self._of.sample(times))
        return sample

    def _with_window(self, options: dict[str, Any]) -> dict[str, Any]:
        """The options of a method, with `window` converted from physical times."""
        if options.get("window") is None:
            return options
        window = checks.real_array(options["window"], "window", "two times")
        return options | {"window": window / self.units.time}

    def quantities(self, *args: Any, **options: Any) -> Quantities:
        """Response quantities in physical units, as from `quantities`; `window` is in physical times.

        Parameters
        ----------
        *args
            Arguments of the same method of the result.
        **options
            Its arguments by name; `window` is in physical times.

        Returns
        -------
        Quantities
            Their values in these units.
        """
        amounts = self._of.quantities(*args, **self._with_window(options))
        found: Quantities = self._converted("quantities", amounts)
        return found

    def gradient(self) -> Gradient:
        """The derivatives in physical units, as from `gradient` of a motion or a trajectory of an oscillator.

        Returns
        -------
        Gradient
            Its parameter `frequency`, in place of r, is the frequency of the load in cycles per unit of time.
            M, K and F0 stay the same; `load` is the amplitude of the load.

        Raises
        ------
        ParameterError, SingularError
            As `gradient` of the result.

        Examples
        --------
        The change of the largest displacement per millimetre of clearance, which has no unit, and per hertz:

        >>> import vibroimpact as vi
        >>> rig = vi.Oscillator.from_dimensional(
        ...     M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75, F0=6.0, units="m N s"
        ... )
        >>> motion = vi.find(rig, "19.5 Hz", "4 mm")[0]
        >>> gradient = motion.physical("mm N s").gradient()
        >>> gradient.units["x_max"], gradient.units["clearance"], gradient.units["frequency"]
        ('mm', 'mm', 'Hz')
        """
        found: Gradient = self._of.gradient()
        units, known = self.units, units_by_name(self._of.study) | OF_GRADIENT
        of = {name: known[name.removeprefix("final_")] for name in found.values}
        names = ["frequency" if name == "r" else name for name in found.parameters]
        scales = np.array(
            [units.frequency if name == "frequency" else units.scale(known[name]) for name in names]
        )
        unit_names = {name: units.name(known.get(name, "")) for name in names}
        unit_names |= {"frequency": units.hertz}
        place = (
            f"{self._of.r * units.frequency:.6g} {units.hertz}, "
            f"d = {self._of.clearance * units.length:.6g} {units.names.split()[0]}"
        )
        dimensionless = f"r = {self._of.r:.6g}, d K/F0 = {self._of.clearance:.6g}"
        return Gradient(
            found.of.replace(dimensionless, place),
            tuple(names),
            {
                name: frozen(np.asarray(value * units.scale(of[name])))
                for name, value in found.values.items()
            },
            {
                name: frozen(table * (units.scale(of[name]) / scales))
                for name, table in found.derivatives.items()
            },
            found.dimensions,
            found.status,
            unit_names | {name: units.name(unit) for name, unit in of.items()},
        )

    def plot(self, *args: Any, **options: Any) -> Any:
        """Draw the result with physical axes; the arguments are those of its `plot`, with physical times.

        Parameters
        ----------
        *args
            Arguments of the same method of the result.
        **options
            Its arguments by name; `window` is in physical times.

        Returns
        -------
        Axes, or an array of Axes
            As the method of the result returns them.
        """
        return type(self._of).plot(self, *args, **self._with_window(options))

    def animate(self, *args: Any, **options: Any) -> Any:
        """Animate the result in physical units; the arguments are those of its `animate`, with physical times.

        Parameters
        ----------
        *args
            Arguments of the same method of the result.
        **options
            Its arguments by name; `window` is in physical times.

        Returns
        -------
        the animation
            As the method of the result returns it.
        """
        return type(self._of).animate(self, *args, **self._with_window(options))

    def _animate(self, *options: Any, units: Units | str | None = None) -> Any:
        """The animation, for `animate` of the class of the result."""
        from .plot.pictures import animate_result

        return animate_result(self.result, *options, units=self.units if units is None else units)

    def __bool__(self) -> bool:
        return True  # most results have no __len__

    def __len__(self) -> int:
        return len(self._of)

    def __getitem__(self, index: Any) -> Any:
        """A part of the result, or a list of them for a slice."""
        return self._converted("parts", self._of[index])

    def _draw(self, *options: Any, units: Units | str | None = None) -> Any:
        """The picture, for `plot` of the class of the result."""
        from .plot.pictures import draw_result

        return draw_result(self.result, *options, units=self.units if units is None else units)

    def to_dict(self) -> dict[str, Any]:
        """The `to_dict` of the result, with its units.

        Returns
        -------
        dict
            Its item `physical` contains the tables in physical units.
        """
        from .formats.record import encoded

        columns = {
            name: {column.name: encoded(column) for column in table.columns.values()}
            for name, table in self._result.tables.items()
        }
        named = {
            column.name: column.unit
            for table in self._result.tables.values() for column in table.columns.values()
        }  # fmt: skip
        own = {field.name: getattr(self.units, field.name) for field in dataclasses.fields(Units)}
        content: dict[str, Any] = self._of.to_dict()
        return content | {"physical": {**own, "columns": named, "tables": columns}}

    def to_json(self) -> str:
        """`to_dict` as JSON text.

        Returns
        -------
        str
            One JSON object.
        """
        return json.dumps(self.to_dict(), allow_nan=False)

    def to_xarray(self) -> Any:
        """The result in physical units as a dataset, as from `to_xarray` of the result.

        Returns
        -------
        xarray.Dataset
            Each variable has its unit as an attribute.
        """
        return dataset(self._of.to_xarray(), self.units)

    def to_pandas(self) -> Any:
        """The result in physical units as a data frame, as from `to_pandas` of the result.

        Returns
        -------
        pandas.DataFrame
            Its ``attrs["units"]`` has the names of the units by column.
        """
        from .formats.rows import frame

        found = frame(self)
        found.attrs["units"] = listed_units(self._result)
        return found

    def save(self, path: str | Path) -> None:
        """Write a file like `save` of the result, in physical units.

        `vibroimpact.load` reads .json, .nc and .mat files back with the same units.

        Parameters
        ----------
        path : str or Path
            The file; its extension sets the format.
        """
        from .formats import save

        save.save(self, path)

    def _csv(self) -> str:
        """The rows with the units and the case in the header."""
        from .formats.rows import rows

        own = self._result
        table = rows(own)
        units = ", ".join(f"{name} {unit}" for name, unit in listed_units(own).items())
        head = [
            f"! vibroimpact {version('vibroimpact')}{units and '; '}{units}",
            *own.case.splitlines(),
        ]
        body = zip(*(map(cell, values.tolist()) for values in table.values()), strict=True)
        lines = [*(f"# {line}" for line in head), ",".join(table), *map(",".join, body)]
        return "\n".join(lines) + "\n"

    def _repr_html_(self) -> str:
        """The representation in Jupyter."""
        from .base.jupyter import facts_html

        return facts_html(repr(self), {"units": self.units.names, "F0": f"{self.units.F0:.6g}"})

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *dir(self.result)})

    def __repr__(self) -> str:
        return f"<Physical, in {self.units.names}: {self.result!r}>"


def cell(value: Any) -> str:
    """A value in a CSV, as the core writes it."""
    if value is None or isinstance(value, bool):
        return {None: "unknown", True: "true", False: "false"}[value]
    exact = isinstance(value, float) and math.isfinite(value)
    return namelist.digits(value) if exact else str(value)


def tables(result: Result, units: Units) -> Result:
    """The tables of a result in physical units, without columns of mixed units."""
    found = {}
    for name, table in settled(result).tables.items():
        columns = {
            key: column_in(column, units)
            for key, column in table.columns.items() if column.unit != MIXED
        }  # fmt: skip
        if "chosen" in result.tables and "choice" in table.dims:
            scale = scale_by_row(result.column("chosen", "name").decoded(), units)
            columns |= {
                key: replace(column, values=column.values * scale)
                for key, column in table.columns.items()
                if column.unit == MIXED
            }
        dims = {"frequency" if dim == "r" else dim: size for dim, size in table.dims.items()}
        found[name] = replace(table, dims=dims, columns=Found(columns, name))
    return replace(result, tables=Found(found, "tables"), handle=None)


def scale_by_row(names: Any, units: Units) -> Any:
    """Factors for the values of design parameters: a clearance becomes d, other parameters have no dimension."""
    return np.where(names == "clearance", units.scale("F0/K"), 1.0)


def frequency_name(name: str) -> str:
    """The name of a column of frequencies, from that of frequency ratios."""
    return f"frequency{name[1:]}" if name == "r" or name.startswith("r_") else name


def column_in(column: Column, units: Units) -> Column:
    """A column in physical units; a frequency ratio becomes a frequency."""
    if column.meaning.startswith(RATIO):
        values, unit = column.values * units.frequency, units.hertz
        name = frequency_name(column.name)
        meaning = column.meaning.replace(RATIO, "load frequency").removesuffix(" Omega/omega")
        return replace(column, name=name, values=values, unit=unit, meaning=meaning)
    if not powers_of(column.unit):
        return column
    meaning = column.meaning.replace(GAP, PHYSICAL_GAP)
    values = column.values * units.scale(column.unit)
    return replace(column, values=values, unit=units.name(column.unit), meaning=meaning)


def listed_units(result: Result) -> dict[str, str]:
    """The units of the columns of the CSV of a result that have one."""
    from .formats.rows import listed_columns

    return {name: column.unit for name, column, _ in listed_columns(result) if column.unit}


def dataset(data: Any, units: Units) -> Any:
    """A dataset in physical units, without variables of mixed units."""
    unit = {name: item.attrs.get("units", "") for name, item in data.variables.items()}
    if "chosen_name" in data:
        scale = scale_by_row(data["chosen_name"].values, units)
        mixed = [
            name for name, text in unit.items() if text == MIXED and "choice" in data[name].dims
        ]
        data = data.assign(
            {name: (data[name] * scale).assign_attrs(data[name].attrs) for name in mixed}
        )
        unit |= dict.fromkeys(mixed, "")
    data = data.drop_vars([name for name, text in unit.items() if text == MIXED])
    renamed = {}
    for name in list(data.variables):
        item = data[name]
        about = dict(item.attrs)
        if str(about.get("long_name", "")).startswith(RATIO):
            values, about["units"] = item * units.frequency, units.hertz
            about["long_name"] = "load frequency"
            renamed[name] = frequency_name(name)
        elif unit[name] == "omega" and about.get("long_name") == "frequency":
            values, about["units"] = item * units.frequency, units.hertz
        elif powers_of(unit[name]):
            values, about["units"] = item * units.scale(unit[name]), units.name(unit[name])
            about["long_name"] = str(about["long_name"]).replace(GAP, PHYSICAL_GAP)
        else:
            continue
        data = data.assign({name: values.assign_attrs(about)})
    known = {"M": units.M, "K": units.K, "F0": units.F0, "physical_units": units.names}
    comment = f"in units of {units.names} for the load amplitude F0; attributes named like keys are dimensionless"
    return data.rename(renamed).assign_attrs(known | {"comment": comment, "units": units.names})
