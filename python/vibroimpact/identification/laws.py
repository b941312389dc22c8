"""Laws of restitution for fits: R of each wall over the approach speed, with parameters by name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..systems.restitution import PowerLaw, Restitution, TabulatedRestitution

_Array = NDArray[np.float64]
#: The parameters that each law adds to R of a wall. With the plural of its name, each wall has its own.
SHAPES: dict[str, tuple[str, ...]] = {
    "power": ("exponent",),
    "knee": ("exponent", "knee"),
    "table": (),
}
KINDS = ("constant", *(kind + end for kind in SHAPES for end in ("", "s")))
#: The parameters of a law that may be known, besides R1 and R2.
KNOWN_OF_LAW = tuple(name + wall for name in ("exponent", "knee") for wall in ("", "1", "2"))
#: The sharpness that makes a power law straight down to the speed where it is 1; the exponent of a constant.
SHARP, FLAT = 20.0, 1e-7
#: Margin of the knots of a table beyond the speeds of the impacts, relative to their range and to the speed.
BEYOND, LEAST_RANGE = 0.05, 0.02
#: Relative distance of the points about a knot between which the core rounds the corner.
CORNER = 1e-5


@dataclass(frozen=True)
class Law:
    """The law of the coefficients of restitution as a function of the approach speed v.

    constant: R1 and R2. power: R1 (v/v0)^-p and R2 (v/v0)^-p. knee: R1 ((v^2 + w^2)/(v0^2 + w^2))^(-p/2), a
    `PowerLaw` with the knee w. table: linear between knots, and constant beyond them. impacts: one number for each
    impact of a period, from which fits of the other laws start.
    """

    kind: str = "constant"
    count: int = 0
    v0: float = math.nan
    #: Of the right and of the left wall.
    knots: tuple[tuple[float, ...], ...] = ()
    #: Whether there is friction in the slot.
    friction: bool = False

    @property
    def shape(self) -> str:
        """The kind in the singular."""
        return self.kind.removesuffix("s") if self.kind in KINDS else self.kind

    def of_wall(self, wall: int) -> tuple[str, ...]:
        """Names of the parameters of the right wall (0) or the left one (1)."""
        own = str(wall + 1) if self.kind != self.shape else ""
        if self.count:
            return tuple(f"R{own}[{j + 1}]" for j in range(self.count))
        return (f"R{wall + 1}", *(name + own for name in SHAPES.get(self.shape, ())))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all its parameters."""
        both = tuple(dict.fromkeys(self.of_wall(0) + self.of_wall(1)))
        return tuple(sorted(both, key=lambda name: name[0] != "R"))

    @property
    def shared(self) -> tuple[str, ...]:
        """All parameters that records of one rig share."""
        return ("omega", "xi", "mu", *self.names, "d", *["friction"] * self.friction)

    @property
    def fixed(self) -> dict[str, float]:
        """The speeds to which its parameters refer (m/s)."""
        if self.kind == "constant":
            return {}
        ends = ("",) if self.kind == self.shape else ("1", "2")
        return {"v0": self.v0} | {
            f"v{end}[{j + 1}]": speed
            for end, knots in zip(ends, self.knots, strict=False)
            for j, speed in enumerate(knots)
        }

    def about(self, speeds: Sequence[_Array], v0: float | None) -> Law:
        """The law with its reference speed and knots for the impact speeds of the right and of the left wall."""
        every = np.concatenate(speeds)
        if v0 is None:
            v0 = float(np.exp(np.mean(np.log(every))))
        knots = []
        for own in (speeds if self.kind != self.shape else (every, every)) if self.count else ():
            # knots are quantiles: between two knots there are equal numbers of speeds
            found = np.quantile(own, np.linspace(0, 1, self.count))
            beyond = max(BEYOND * float(np.ptp(own)), LEAST_RANGE * float(own.max()))
            found[[0, -1]] = max(found[0] - beyond, 0.0), found[-1] + beyond
            even = np.linspace(found[0], found[-1], self.count)
            apart = np.diff(found).min() > 1e-3 * float(np.ptp(found))
            knots.append(tuple((found if apart else even).tolist()))
        return replace(self, v0=v0, knots=tuple(knots))

    def coefficient(self, wall: int, w: Sequence[Any], speed: Any) -> Any:
        """R of a wall at approach speeds, from its parameters; all arguments may be complex."""
        if self.shape == "power":
            return w[0] * (speed / self.v0) ** -w[1]
        if self.shape == "knee":
            return w[0] * ((speed**2 + w[2] ** 2) / (self.v0**2 + w[2] ** 2)) ** (-w[1] / 2)
        if self.shape == "impacts":
            return sum(value * (np.arange(np.shape(speed)[-1]) == j) for j, value in enumerate(w))
        if self.shape == "constant":
            return w[0]
        knots = np.array(self.knots[wall])
        i = np.clip(np.searchsorted(knots, np.real(speed)) - 1, 0, knots.size - 2)
        part = (speed - knots[i]) / (knots[i + 1] - knots[i])
        part = np.where(np.real(part) < 0, 0.0, np.where(np.real(part) > 1, 1.0, part))
        return sum(
            value * (np.where(i == j, 1 - part, 0.0) + np.where(i + 1 == j, part, 0.0))
            for j, value in enumerate(w)
        )

    def start(self, values: Mapping[str, float]) -> dict[str, float]:
        """The starting values of its fit, from the parameters of a power law at the same speed."""
        if self.shape == "knee":
            # at the middle of the speeds the slope is half of that far above the knee
            return {
                name: self.v0 if name.startswith("knee") else 2 * value if name[0] == "e" else value
                for name, value in (
                    (name, values.get(name.replace("knee", "exponent"), values.get(name, 0.0)))
                    for name in self.names
                )
            }
        if self.shape != "table":
            return dict(values)
        power = Law("powers" if self.kind != self.shape else "power", v0=self.v0)
        own = [[values[name] for name in power.of_wall(wall)] for wall in (0, 1)]
        return {
            name: float(np.clip(power.coefficient(wall, own[wall], speed), 0.05, 0.99))
            for wall in (1, 0)
            for name, speed in zip(self.of_wall(wall), self.knots[wall], strict=True)
        }

    def typical(self, name: str, start: float) -> float:
        """Typical uncertainty of a parameter before the fit."""
        return 0.5 if name[0] == "R" else 0.25 if name[0] == "e" else abs(start)

    def restitution(
        self, values: Mapping[str, float], unit: float = 1.0
    ) -> tuple[Restitution, Restitution]:
        """Restitution of the right and of the left wall, as a function of speeds in a given unit (m/s).

        A power law is returned as a `PowerLaw` whose knee is the speed at which the power law is 1 or, if it is
        nearly constant, a thousandth of v0. A law that is not a `PowerLaw` (R grows with the speed, or is above 1
        at low speeds) is returned as a table from v0/100 to 100 v0.
        """
        right, left = (
            self._wall(wall, [values[name] for name in self.of_wall(wall)], unit) for wall in (0, 1)
        )
        return right, left

    def _wall(self, wall: int, w: list[float], unit: float) -> Restitution:
        """Restitution of one wall."""
        if self.shape == "table":
            knots = np.array(self.knots[wall])
            speeds = np.unique(
                np.concatenate([knots, knots[1:] * (1 - CORNER), knots[:-1] * (1 + CORNER)])
            )
        else:
            R, p = w[0], w[1] if self.shape != "constant" else 0.0
            if abs(p) <= FLAT:
                return R
            if self.shape == "power" and p > 0:
                low = max(min(1.0, R) ** (1 / p), 1e-3)
                return PowerLaw(min(1.0, R * low**-p), low * self.v0 / unit, p, sharpness=SHARP)
            if self.shape == "knee" and p > 0 and w[2] != 0:
                R0 = R * (1 + (self.v0 / w[2]) ** 2) ** (p / 2)
                if R0 <= 1:
                    return PowerLaw(R0, abs(w[2]) / unit, p)
            speeds = self.v0 * np.geomspace(0.01, 100, 401)
        return TabulatedRestitution(
            speeds / unit, np.clip(self.coefficient(wall, w, speeds), 0.0, 1.0)
        )


def law_of(values: Mapping[str, float]) -> Law:
    """The law of identified values, by their names."""
    v0 = values.get("v0", math.nan)
    for shape in ("knee", "table", "power"):
        for kind in (shape, shape + "s"):
            ends = ("", "") if kind == shape else ("1", "2")
            if shape != "table":
                if SHAPES[shape][-1] + ends[0] in values:
                    return Law(kind, v0=v0)
                continue
            knots = tuple(
                tuple(value for name, value in values.items() if name.startswith(f"v{end}["))
                for end in ends
            )
            if knots[0]:
                return Law(kind, len(knots[0]), v0, knots)
    return Law()
