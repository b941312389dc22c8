"""The contents of a case of a design: its keys as a problem and an order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.errors import ParameterError
from ..results.performance import LIMITED
from ..systems.distribution import ELEMENTS, Uncertain
from ..systems.oscillator import Oscillator
from .hosts import DecayHost
from .problem import Host, OscillatorHost, Problem

#: Parameters of an oscillator that can be free or uncertain.
NAMES = ("clearance", "mu", "xi", "restitution", "R1", "R2", *ELEMENTS)


@dataclass(frozen=True)
class Order:
    """The settings of a design other than the problem.

    Attributes
    ----------
    target : str
    limit : float or None
    evaluations, searches, specimens, nodes, states, samples, seed : int
    """

    target: str
    limit: float | None
    evaluations: int
    searches: int
    specimens: int
    nodes: int
    states: int
    samples: int
    seed: int

    @property
    def sign(self) -> int:
        """The sign of the target in the search: the damping is maximised by minimising its negative."""
        return -1 if self.target == "damping" else 1


def asked_by(
    osc: Oscillator, keys: Mapping[str, Any], threads: int | None = None
) -> tuple[Problem, Order]:
    """The problem and the order of a checked case."""
    normal = keys.get("normal", ())
    normal = (normal,) if isinstance(normal, str) else normal

    def spread(name: str, key: str) -> Uncertain:
        return uncertain_by(keys[key], name in normal)

    free = {
        name: tuple(keys[f"free_{name.lower()}"])
        for name in NAMES
        if f"free_{name.lower()}" in keys
    }
    tolerance = {
        name: spread(name, f"tolerance_{name.lower()}")
        for name in NAMES
        if f"tolerance_{name.lower()}" in keys
    }
    if keys.get("clearance") is None and "clearance" not in {*free, *tolerance}:
        raise ParameterError("clearance: must be given, or be free")
    limits = {name: keys[f"limit_{name}"] for name in LIMITED if f"limit_{name}" in keys}
    target = keys["target"]
    host: Host
    if target == "damping":
        host, load = (
            DecayHost(osc, keys.get("clearance"), keys["cycles"], threads),
            Uncertain((1.0, 1.0)),
        )
    else:
        load = spread("load", "load")
        host = OscillatorHost(
            osc, keys.get("clearance"), target, limits, keys["settling"], keys["keep"], threads
        )
    band = np.atleast_1d(keys["amplitude" if target == "damping" else "band"])
    problem = Problem(
        host, free, tolerance, (float(band[0]), float(band[-1])), load, keys["quantile"],
        keys["over"] == "basins", bool(limits),
    )  # fmt: skip
    names = ("evaluations", "searches", "specimens", "nodes", "states", "samples", "seed")
    return problem, Order(target, keys.get("limit"), *(keys[name] for name in names))


def numbers_of(item: Uncertain) -> list[float]:
    """The numbers of a key that describe an uncertain parameter."""
    return list(item.numbers[:1] if item.low == item.high else item.numbers)


def uncertain_by(numbers: Any, normal: bool) -> Uncertain:
    """An uncertain parameter, from the numbers of a key."""
    values = tuple(float(value) for value in np.atleast_1d(numbers))
    return Uncertain(values if len(values) > 1 else 2 * values, normal)
