"""Results as xarray datasets: named dimensions; units, symbol and meaning of each variable."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import MissingExtraError, ParameterError

if TYPE_CHECKING:
    from ..motion import Motion
    from ..trajectory import Trajectory

#: Unit, symbol and meaning of each variable.
VARIABLES = {
    "r": ("1", "r", "frequency ratio Omega/omega"),
    "clearance": ("1", "D", "clearance d K/F0"),
    "xi": ("1", "xi", "damping ratio"),
    "mu": ("1", "mu", "mass ratio"),
    "R1": ("1", "R1", "coefficient of restitution of the right wall"),
    "R2": ("1", "R2", "coefficient of restitution of the left wall"),
    "load": ("F0", "f", "load amplitude"),
    "time": ("1/omega", "t", "time"),
    "phase": ("rad", "", "phase of the load, in [0, 2 pi)"),
    "phases": ("rad", "alpha", "load phase of each impact after the first"),
    "restitution": ("1", "R", "coefficient of restitution of each impact"),
    "X": ("F0/K", "X", "position of the primary mass"),
    "Z": ("F0/K", "Z", "position of the free mass"),
    "x": ("F0/K", "x", "position of the primary mass"),
    "z": ("F0/K", "z", "position of the free mass"),
    "A": ("F0/K", "A", "amplitude of the motion without impacts"),
    "tau": ("rad", "tau", "phase of the forced motion at the first impact"),
    "residual": ("1", "epsilon", "relative residual of the equations"),
    "x_min": ("F0/K", "x_min", "least position of the primary mass"),
    "x_max": ("F0/K", "x_max", "greatest position of the primary mass"),
    "attenuation": ("1", "max|x|/A", "greatest |x| over the amplitude without impacts"),
    "multipliers_real": ("1", "Re lambda", "real part of the multipliers (eigenvalues of [P])"),
    "multipliers_imag": ("1", "Im lambda", "imaginary part of the multipliers"),
    "kind": ("", "", "impact; stick, where accumulating impacts end in rest; release, where it ends"),
    "side": ("", "", "wall, right or left; * for accumulation and rest"),
    "special": ("", "", "bifurcation, or end, at the point"),
    "sides": ("", "", "walls of the impacts in order"),
    "cycles": ("1", "k", "load cycles in a period"),
    **{
        f"{letter}_dot{when}": (
            "omega F0/K", f"d{letter}/dt",
            f"velocity of the {mass} mass" + (f" just {when[1:]} the impact" if when else ""),
        )
        for letter, mass in (("X", "primary"), ("x", "primary"), ("Z", "free"), ("z", "free"))
        for when in ("", "_before", "_after")
    },
}  # fmt: skip
VERDICTS = ("consistent", "admissible", "stable")
CODES = {True: 1, False: 0, None: -1}


def xarray(what: str = "tables") -> Any:
    """The xarray module, or an error that says how to get it, for the sake of what."""
    try:
        import xarray as module
    except ImportError:
        raise MissingExtraError(f"{what} need xarray: pip install 'vibroimpact[data]'") from None
    return module


def to_xarray(result: Any) -> Any:
    """A result as a Dataset, with its complete case among the attributes."""
    makers: dict[str, Any] = {
        "Motion": of_motion, "Trajectory": of_trajectory,
    }  # fmt: skip
    name = type(result).__name__
    data, attributes = makers[name](result)
    variables = {
        key: (dims, np.asarray(values), described(key)) for key, (dims, values) in data.items()
    }
    return xarray().Dataset(variables, attrs={**attributes, **common(result)})


def described(name: str) -> dict[str, Any]:
    """The attributes of a variable."""
    if name in VERDICTS:
        flags = {"flag_values": np.array([1, 0, -1], np.int8), "flag_meanings": "yes no unknown"}
        return {"long_name": f"whether the motion is {name}", "units": "1", **flags}
    unit, symbol, meaning = VARIABLES[name]
    named = {"long_name": meaning, "units": unit, "symbol": symbol}
    return {key: text for key, text in named.items() if text}


def common(result: Any) -> dict[str, Any]:
    """Attributes of every dataset."""
    from .. import __version__

    try:
        case = result.to_namelist()
    except ParameterError:
        case = ""
    return {
        "Conventions": "CF-1.11", "title": repr(result), "case": case,
        "source": f"vibroimpact {__version__}", "result": type(result).__name__,
        "comment": "lengths in F0/K, time in 1/omega, angles in radians",
    }  # fmt: skip


def system(osc: Any, pattern: Any = None) -> dict[str, Any]:
    """Attributes that tell of the system, and of the pattern."""
    right, left = osc.restitution
    own = {"xi": osc.xi, "mu": osc.mu, "R1": right, "R2": left}
    return own if pattern is None else own | {"sides": pattern.sides, "cycles": pattern.cycles}


def event_variables(events: Any) -> dict[str, Any]:
    """Events, one dimension."""
    return {name: ("event", events[name]) for name in events.dtype.names}


def of_motion(motion: Motion) -> tuple[dict[str, Any], dict[str, Any]]:
    """Impacts, multipliers, and what there is one of."""
    names = (
        "restitution",
        "phases",
        "X",
        "Z",
        "X_dot_before",
        "X_dot_after",
        "Z_dot_before",
        "Z_dot_after",
    )
    data: dict[str, Any] = {name: ("impact", getattr(motion, name)) for name in names}
    data["side"] = ("impact", motion.pattern.symbols)
    data["multipliers_real"] = ("multiplier", motion.multipliers.real)
    data["multipliers_imag"] = ("multiplier", motion.multipliers.imag)
    for name in ("r", "clearance", "load", "A", "tau", "residual", "x_min", "x_max"):
        data[name] = ((), getattr(motion, name))
    data["attenuation"] = ((), motion.attenuation if motion.A > 0 else np.nan)
    for name in VERDICTS:
        data[name] = ((), np.int8(CODES[getattr(motion, name)]))
    if motion.rest_events is not None:
        events = event_variables(motion.rest_events)
        data |= {name: item for name, item in events.items() if name not in data}
    kinds = {"kind_of_motion": motion.kind, "precision": motion.precision}
    return data, {**system(motion.osc, motion.pattern), **kinds}


def of_trajectory(run: Trajectory) -> tuple[dict[str, Any], dict[str, Any]]:
    """Events, and both ends as attributes."""
    data = event_variables(run.events)
    data |= {name: ((), getattr(run, name)) for name in ("r", "clearance", "load")}
    names = ("t", "x", "x_dot", "z", "z_dot")
    ends = {
        f"{end}_{name}": getattr(run, f"{end}_state")[name]
        for end in ("initial", "final")
        for name in names
    }
    return data, {**system(run.osc), **ends, "complete": int(run.complete)}
