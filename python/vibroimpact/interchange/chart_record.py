"""Charts on their way into files and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ParameterError
from .dataset import xarray
from .plain import encode

if TYPE_CHECKING:
    from ..chart_arrays import ChartArrays


def chart_as_made(data: Any) -> Any:
    """A chart from a file as `vibroimpact.chart` gives it: without what files add, lists as lists."""
    for name in ("case", "Conventions"):
        data.attrs.pop(name, None)
    data.attrs = {name: plain_attribute(value) for name, value in data.attrs.items()}
    for item in data.variables.values():
        item.attrs = {key: plain_attribute(value) for key, value in item.attrs.items()}
        if "flag_values" in item.attrs:  # one alone comes as a number
            item.attrs["flag_values"] = np.ravel(item.attrs["flag_values"]).tolist()
        item.encoding = {}
    return data.assign_coords(side=("impact", data["side"].values.astype("U1"), data["side"].attrs))


def plain_attribute(value: Any) -> Any:
    """A value without numpy's types."""
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def chart_to_dict(data: ChartArrays) -> dict[str, Any]:
    """A chart as plain values, ready for JSON, with what the numbers are and mean."""
    variables = data.variables
    return {
        "type": "Chart",
        "attributes": {name: encode(value) for name, value in data.attrs.items()},
        "dimensions": {name: list(item.dims) for name, item in variables.items()},
        "labels": {name: encode(item.attrs) for name, item in variables.items()},
        "types": {name: item.values.dtype.str for name, item in variables.items()},
        "coordinates": data.coords,
        **{name: encode(item.values) for name, item in variables.items()},
    }


def chart_from_dict(record: Mapping[str, Any]) -> Any:
    """The inverse of `chart_to_dict`: the same to the last bit."""
    keys = ("dimensions", "labels", "types", "coordinates", "attributes")
    try:
        dims, labels, types, coordinates, attributes = (record[name] for name in keys)
        variables = {
            name: (dims[name], np.array(record[name], dtype=np.dtype(types[name])), labels[name])
            for name in dims
        }
        own = {name: variables.pop(name) for name in coordinates}
        return xarray("charts").Dataset(variables, own, attributes)
    except KeyError as error:
        raise ParameterError(f"a chart must have {error}; it is missing") from None
    except (ValueError, TypeError, AttributeError) as error:
        raise ParameterError(f"it is no whole chart: {error}") from None
