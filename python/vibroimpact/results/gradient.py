"""Derivatives with respect to parameters, by name of quantity and parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..base.libraries import xarray

__all__ = ["Gradient"]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Gradient:
    """Exact derivatives of all quantities of a motion or a trajectory, by name of quantity and parameter.

    ``gradient["x_max"]`` is the array of derivatives with respect to all `parameters`; ``gradient["X", "mu"]`` is
    the derivative with respect to one parameter and has the shape of the quantity. Arrays are read-only. A
    derivative that does not exist is NaN, and `status` says why.

    Attributes
    ----------
    of : str
        The object to which the quantities belong.
    parameters : tuple of str
        Names of the parameters, in the order of the last axis of the derivatives.
    values : dict of str to ndarray
        The quantities themselves.
    derivatives : dict of str to ndarray
        The derivatives of each quantity; the last axis is that of the parameters.
    dimensions : dict of str to tuple of str
        Names of the dimensions of each quantity.
    status : dict of str to str
        Why a quantity, or one of its entries such as ``"multipliers[0]"``, has no derivatives.
    units : dict of str to str
        The units of quantities and parameters in physical units; empty for dimensionless derivatives.
    """

    of: str
    parameters: tuple[str, ...]
    values: Mapping[str, NDArray[Any]]
    derivatives: Mapping[str, NDArray[Any]]
    dimensions: Mapping[str, tuple[str, ...]]
    status: Mapping[str, str]
    units: Mapping[str, str] = field(default_factory=dict)

    def __getitem__(self, name: str | tuple[str, str]) -> NDArray[Any]:
        """Derivatives of one quantity with respect to all parameters or to one."""
        quantity, parameter = name if isinstance(name, tuple) and len(name) == 2 else (name, None)
        if quantity not in self.derivatives:
            raise ParameterError(f"quantity {quantity!r}: must be one of {', '.join(self.values)}")
        table = self.derivatives[str(quantity)]
        if parameter is None:
            return table
        if parameter not in self.parameters:
            raise ParameterError(
                f"parameter {parameter!r}: must be one of {', '.join(self.parameters)}"
            )
        column: NDArray[Any] = table[..., self.parameters.index(parameter)]
        return column

    def to_xarray(self) -> Any:
        """The derivatives as a dataset with the dimension `parameter` (extra `data`).

        Returns
        -------
        xarray.Dataset
            One variable for each quantity.

        Raises
        ------
        MissingExtraError
            If xarray is not installed.

        Examples
        --------
        >>> import vibroimpact as vi
        >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        >>> table = vi.equispaced(osc, 0.94, 37.0)[0].gradient().to_xarray()
        >>> table["X"].sel(parameter="clearance").dims
        ('impact',)
        """
        data = {
            name: (
                (*self.dimensions[name], "parameter"), table,
                {"units": self.units[name]} if self.units.get(name) else {},
            )
            for name, table in self.derivatives.items()
        }  # fmt: skip
        attributes = {"title": f"Derivatives of {self.of}"}
        if self.units:
            attributes["comment"] = (
                "units are those of the quantities; divide by the unit of the parameter"
            )
        parameters = list(self.parameters)
        units = [self.units.get(name, "") for name in parameters]
        coordinates = {"parameter": parameters} | (
            {"parameter_unit": ("parameter", units)} if self.units else {}
        )
        return xarray("derivatives").Dataset(data, coordinates, attributes)

    def __repr__(self) -> str:
        return f"<Gradient of {self.of}: {len(self.values)} quantities by {', '.join(self.parameters)}>"

    def __str__(self) -> str:
        titles = [self._labelled(name) for name in ("value", *self.parameters)]
        widths = [max(12, len(title) + 2) for title in titles]
        head = "".join(f"{title:>{width}}" for title, width in zip(titles, widths, strict=True))
        labels = [
            self._labelled(name, place) for name in self.derivatives for place in ("", "[00]")
        ]
        first = max(20, *(len(label) + 6 for label in labels)) if self.units else 20
        lines = [f"Derivatives of {self.of}", f"{'':{first}}{head}"]
        for name, table in self.derivatives.items():
            values = np.atleast_1d(self.values[name]).ravel()
            rows = table.reshape(len(values), table.shape[-1])
            for i, numbers in enumerate(np.column_stack([values, rows])):
                if np.isnan(numbers[0]):
                    continue
                place = np.unravel_index(i, np.shape(self.values[name]))
                entry = f"[{', '.join(map(str, place))}]" if place else ""
                label = f"{name}{entry}"
                parts = {"": numbers.real}
                if np.iscomplexobj(numbers):
                    parts = {" real": numbers.real, " imag": numbers.imag}
                for part, row in parts.items():
                    shown = (f"{x:>{width}.5g}" for x, width in zip(row, widths, strict=True))
                    lines.append(f"{self._labelled(name, entry + part):{first}}{''.join(shown)}")
                if label in self.status:
                    lines.append(f"{'':{first}}  {self.status[label]}")
        return "\n".join(lines)

    def _labelled(self, name: str, entry: str = "") -> str:
        """A quantity or a parameter with its unit, for a table."""
        unit = self.units.get(name, "")
        return f"{name}{entry} [{unit}]" if unit else f"{name}{entry}"


def frozen(array: NDArray[Any]) -> NDArray[Any]:
    """The array, read-only."""
    array.flags.writeable = False
    return array
