"""Laws of restitution that are fitted: R of each wall over the approach speed, with its parameters by name."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..systems.restitution import PowerLaw, Restitution, TabulatedRestitution

_Array = NDArray[np.float64]
#: What each law adds to R of a wall. The plural of its name has these for each wall, as the plural of a table has.
SHAPES: dict[str, tuple[str, ...]] = {
    "power": ("exponent",),
    "knee": ("exponent", "knee"),
    "table": (),
}
KINDS = ("constant", *(kind + end for kind in SHAPES for end in ("", "s")))
#: What may be known of a law, beside R1 and R2.
KNOWN_OF_LAW = tuple(name + wall for name in ("exponent", "knee") for wall in ("", "1", "2"))
#: The sharpness of a power law without a knee, down to where it is 1; exponent of a constant.
SHARP, FLAT = 20.0, 1e-7
#: How far the knots of a table reach beyond the speeds of the impacts, over their range, and over the speed.
BEYOND, LEAST_RANGE = 0.05, 0.02
#: Distance of the points about a knot between which the core rounds the corner there, over the speed.
CORNER = 1e-5


@dataclass(frozen=True)
class Law:
    """How the coefficients of restitution depend on the approach speed v.

    constant: R1 and R2. power: R1 (v/v0)^-p and R2 (v/v0)^-p. knee: R1 ((v^2 + w^2)/(v0^2 + w^2))^(-p/2), which is
    a `PowerLaw` with its knee w. table: linear between knots, and constant beyond them. impacts: one number for
    each impact of a period, from which the others start.
    """

    kind: str = "constant"
    count: int = 0
    v0: float = math.nan
    #: Of the right and of the left wall.
    knots: tuple[tuple[float, ...], ...] = ()

    @property
    def shape(self) -> str:
        """The kind without its plural."""
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
        return ("omega", "xi", "mu", *self.names, "d")

    @property
    def fixed(self) -> dict[str, float]:
        """The speeds to which its parameters belong (m/s)."""
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
            # between knots at the ends as many speeds as there are
            found = np.quantile(own, np.linspace(0, 1, self.count))
            beyond = max(BEYOND * float(np.ptp(own)), LEAST_RANGE * float(own.max()))
            found[[0, -1]] = max(found[0] - beyond, 0.0), found[-1] + beyond
            even = np.linspace(found[0], found[-1], self.count)
            apart = np.diff(found).min() > 1e-3 * float(np.ptp(found))
            knots.append(tuple((found if apart else even).tolist()))
        return replace(self, v0=v0, knots=tuple(knots))

    def coefficient(self, wall: int, w: Sequence[Any], speed: Any) -> Any:
        """R of a wall at approach speeds, from its parameters; all may be complex."""
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
        """Where its fit starts, from the parameters of a power law about the same speed."""
        if self.shape == "knee":
            # in the middle of the speeds the slope is half of that far above the knee
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
        """By how much a parameter may be unknown."""
        return 0.5 if name[0] == "R" else 0.25 if name[0] == "e" else abs(start)

    def restitution(
        self, values: Mapping[str, float], unit: float = 1.0
    ) -> tuple[Restitution, Restitution]:
        """Of the right and of the left wall, over speeds in some unit (m/s).

        A power law is a `PowerLaw` far above the speed where it is 1, or, if it is nearly constant, far above a
        thousandth of v0. What is no `PowerLaw` (R grows with the speed, or is above 1 at low speeds) is a table
        from v0/100 to 100 v0.
        """
        right, left = (
            self._wall(wall, [values[name] for name in self.of_wall(wall)], unit) for wall in (0, 1)
        )
        return right, left

    def _wall(self, wall: int, w: list[float], unit: float) -> Restitution:
        """Of one wall."""
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
