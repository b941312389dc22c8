"""The arrays of a chart with their names, units and meanings, as xarray has them and without it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .interchange.dataset import xarray
from .model import Oscillator, Pattern
from .status import status_text


class Variable(NamedTuple):
    """An array with names of its axes, what it is and its unit."""

    dims: tuple[str, ...]
    values: NDArray[Any]
    attrs: dict[str, Any]


@dataclass(frozen=True, eq=False)
class ChartArrays:
    """A chart without xarray: what of its dataset writing and drawing it need, by the same names.

    Attributes
    ----------
    variables : dict
        All variables, the coordinates last.
    coords : list of str
        Which of them are coordinates.
    attrs : dict
    """

    variables: dict[str, Variable]
    coords: list[str]
    attrs: dict[str, Any]

    def __getitem__(self, name: str) -> Variable:
        return self.variables[name]

    def dataset(self) -> Any:
        """The same as an xarray.Dataset."""
        own = {name: tuple(item) for name, item in self.variables.items()}
        coords = {name: own.pop(name) for name in self.coords}
        return xarray("charts").Dataset(own, coords, self.attrs)


class Columns(NamedTuple):
    """Results with the axes (..., motion, clearance, r)."""

    phases: NDArray[np.float64]
    X: NDArray[np.float64]
    tau: NDArray[np.float64]
    x_min: NDArray[np.float64]
    x_max: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    verdicts: NDArray[np.int32]
    status: NDArray[np.int32]


def labelled(
    osc: Oscillator, pattern: Pattern, r: NDArray[np.float64], clearance: NDArray[np.float64],
    columns: Columns, found: NDArray[np.int32],
) -> ChartArrays:  # fmt: skip
    """The results with names, units and all parameters."""
    grid = ("motion", "clearance", "r")
    with np.errstate(divide="ignore"):
        a = 1 / np.hypot((1 - r) * (1 + r), 2 * osc.xi * r)
    verdict = {"flag_values": [1, 0, -1], "flag_meanings": "yes no unknown"}
    codes = [int(code) for code in np.unique(columns.status)]
    variables: dict[str, tuple[Any, Any, str, str, dict[str, Any]]] = {
        "multiplier_modulus": (
            ("multiplier", *grid), np.hypot(columns.multipliers.real, columns.multipliers.imag), "1",
            "modulus of the multipliers (eigenvalues of [P]), leading one first", {},
        ),
        "multiplier_angle": (
            ("multiplier", *grid), np.angle(columns.multipliers), "rad", "angle of the multipliers", {},
        ),
        "x_min": (grid, columns.x_min, "F0/K", "least position of the primary mass", {}),
        "x_max": (grid, columns.x_max, "F0/K", "greatest position of the primary mass", {}),
        "attenuation": (
            grid, np.maximum(-columns.x_min, columns.x_max) / a, "1",
            "greatest |x| over the amplitude without impacts", {},
        ),
        "tau": (grid, columns.tau, "rad", "phase of the forced motion at the first impact", {}),
        "phases": (
            ("impact", *grid), columns.phases, "rad", "load phase from the first impact to each", {},
        ),
        "X": (("impact", *grid), columns.X, "F0/K", "position of the primary mass at each impact", {}),
        "A": (("r",), a, "F0/K", "amplitude without impacts", {}),
        "status": (
            grid, columns.status, "1", "status of the slot",
            {"flag_values": codes, "flag_meanings": "; ".join(map(status_text, codes))},
        ),
        "found": (("clearance", "r"), found, "1", "motions found at the point", {}),
    }  # fmt: skip
    for i, name in enumerate(("consistent", "admissible", "stable")):
        values = columns.verdicts[i].astype(np.int8)
        variables[name] = (grid, values, "1", f"whether the motion is {name}", verdict)
    letters = np.array(pattern.letters)
    coords = {
        "r": Variable(("r",), r, {"long_name": "frequency ratio Omega/omega", "units": "1"}),
        "clearance": Variable(("clearance",), clearance, {"long_name": "d K/F0", "units": "1"}),
        "side": Variable(("impact",), letters, {"long_name": "wall of the impact, right or left"}),
    }  # fmt: skip
    named = {
        name: Variable(
            dims, np.ascontiguousarray(values), {"long_name": text, "units": unit, **more}
        )
        for name, (dims, values, unit, text, more) in variables.items()
    }
    from . import __version__

    attributes = {
        "title": f"motions {pattern.sides}/{pattern.cycles} of a vibrating system with impacts",
        "xi": osc.xi, "mu": osc.mu, "R1": osc.restitution[0], "R2": osc.restitution[1],
        "sides": pattern.sides, "cycles": pattern.cycles, "load": 1.0,
        "units": "length in F0/K, time in 1/omega, angles in radians",
        "source": f"vibroimpact {__version__}", "result": "Chart",
    }  # fmt: skip
    return ChartArrays(named | coords, list(coords), attributes)
