"""The design of a structure that a function of the caller builds: the arguments as a problem and an order."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import Any

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..motions.reached import FIGURES
from ..systems.distribution import Uncertain, uncertain
from .hosts import TARGETS, StructureHost
from .order import Order
from .problem import Problem

#: Arguments that a host always receives.
TAKEN = ("r", "load")


def asked_of(
    host: Any, r: Any, free: Mapping[str, Any], tolerance: dict[str, Uncertain], limits: Mapping[str, Any],
    load: Uncertain, coordinate: int | str, keys: Mapping[str, Any], threads: int | None,
) -> tuple[Problem, Order]:  # fmt: skip
    """The problem and the settings of the design, after all checks that need no structure.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; the message names the argument, its value and what is allowed.
    """
    if not callable(host):
        raise ParameterTypeError(
            f"host = {host!r}: must be an Oscillator, or a function that returns a Structure and its load"
        )
    for group, given in (("free", [*free]), ("tolerance", [*tolerance])):
        for name in given:
            if not isinstance(name, str) or not name.isidentifier() or name in TAKEN:
                raise ParameterError(
                    f"{group}: parameter {name!r}: must be the name of an argument of host, not r or load"
                )
    needed = {*TAKEN, *free, *tolerance}
    try:
        inspect.signature(host).bind(**dict.fromkeys(needed))
    except TypeError as error:
        raise ParameterTypeError(
            f"host = {host!r}: must take the arguments {', '.join(sorted(needed))}; {error}"
        ) from None
    except ValueError:  # a function without a signature
        pass
    target = checks.choice(keys["target"], "target", TARGETS)
    checks.choice(keys["over"], "over", ("worst", "basins"))
    for name in limits:
        checks.choice(name, "limits", FIGURES)
    for name, default in (("clearance", None), ("amplitude", None), ("cycles", 5)):
        if keys[name] != default:
            raise ParameterError(f"{name} = {keys[name]!r}: must be left out for a function")
    numbers = {"quantile": keys["quantile"], "limit": keys["limit"]}
    numbers |= {f"limits[{name!r}]": value for name, value in limits.items()}
    for name, value in numbers.items():
        wanted = (
            "a number with 0.5 <= quantile <= 1" if name == "quantile" else "a finite number > 0"
        )
        if value is None:
            continue
        item = checks.to_float(value, name, wanted)
        if not (0.5 <= item <= 1 if name == "quantile" else 0 < item < math.inf):
            raise ParameterError(f"{name} = {value!r}: must be {wanted}")
    low = {"evaluations": 8, "nodes": 2, "settling": 1, "samples": 0}
    for name in ("states", "searches", "specimens", "keep", *low):
        checks.integer(keys[name], name, low.get(name, 1), 10**9)
    band = uncertain(r, "r")
    ranges = {}
    for name, value in free.items():
        ends = uncertain(
            (value[0], value[-1]) if isinstance(value, range) and value else value,
            f"free[{name!r}]",
        )
        if not ends.low < ends.high:
            raise ParameterError(f"free[{name!r}] = {value!r}: must be a pair with low < high")
        ranges[name] = ends.low, ends.high
        if name in tolerance:
            tolerance[name].require_around(f"tolerance[{name!r}]")
    whole = tuple(name for name, value in free.items() if isinstance(value, range))
    if not isinstance(coordinate, str):
        coordinate = checks.integer(coordinate, "coordinate", 0, 499)
    system = StructureHost(
        host, coordinate, target, dict(limits), keys["settling"],
        keys["keep"], threads,
    )  # fmt: skip
    problem = Problem(
        system, ranges, tolerance, (band.low, band.high), load, float(keys["quantile"]), keys["over"] == "basins",
        bool(limits), whole,
    )  # fmt: skip
    names = ("evaluations", "searches", "specimens", "nodes", "states", "samples", "seed")
    return problem, Order(target, keys["limit"], *(keys[name] for name in names))
