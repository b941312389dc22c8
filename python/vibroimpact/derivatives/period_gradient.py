"""Derivatives of periodic motions with rest or with many impacts, from those of a simulated period."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError, SingularError
from ..base.status import raise_status, status_text
from ..motions.exact import exact_structure, settled
from ..results.events import EVENT_TYPE, WORDS
from ..results.gradient import Gradient, frozen
from ..results.states import later, start_of, state_of
from ..systems.structure import Gap, Load, Structure
from .gradient import (
    FOLD,
    MOST_IMPACTS,
    NOT_EXACT,
    NOT_SMOOTH,
    PARAMETERS,
    SINGULAR,
    motion_gradient,
    trajectory_gradient,
)

if TYPE_CHECKING:
    from ..motions.motion import Motion

__all__: list[str] = []

_Array = NDArray[Any]
STATE = ("x", "x_dot", "z", "z_dot")
#: Relative distance at which a simulated period counts as closed; largest number of events of a period.
CLOSED, MOST_EVENTS = 1e-8, 20_000
#: Number of points per radian of the faster of load and free vibration, between which extremes are bracketed.
POINTS = 8
#: Relative differences below which extremes count as equal, and their derivatives with respect to a parameter.
ALIKE, SAME = 1e-9, 1e-6
#: Largest rounding error of a zero derivative, relative to the derivatives of the state with respect to the same
#: parameter, and relative to the position (used if R is 0, where all derivatives with respect to R vanish).
ROUNDING, NOTHING = 1e-10, 1e-12
#: The quantities by impact, and those of the events of a trajectory.
OF_IMPACTS = {
    "X": "x", "X_dot_before": "x_dot_before", "X_dot_after": "x_dot_after", "Z_dot_before": "z_dot_before",
    "Z_dot_after": "z_dot_after",
}  # fmt: skip


class Period:
    """A period from the middle of the longest flight, as a fixed point of the simulation."""

    def __init__(self, motion: Motion) -> None:
        """Simulate the period, and differentiate its initial state."""
        times, kinds = motion.events["time"], motion.events["kind"]
        lengths = np.diff(times, append=times[0] + motion.period)
        lengths[kinds == "stick"] = 0.0
        i = int(lengths.argmax())
        begin = float(times[i] + lengths[i] / 2)
        here = motion.sample(begin)
        self.motion, self.start = motion, {"t": begin + motion.load_phase / motion.r}
        self.start |= {
            name: float(value)
            for name, value in zip(STATE, (here.X, here.X_dot, here.Z, here.Z_dot), strict=True)
        }
        self.whole, final = self.simulated(float(motion.pattern.cycles))
        sizes = np.array([self.start[name] for name in STATE])
        if not np.abs(final - sizes).max() < CLOSED * np.abs(sizes).max():
            raise_status(NOT_EXACT)
        slopes = np.array([self.whole[f"final_{name}"] for name in STATE])
        left = np.eye(4) - slopes[:, 1:5]
        if not np.linalg.cond(left) < SINGULAR:
            raise_status(FOLD)
        self.state: _Array = np.linalg.solve(left, self.direct(slopes))

    def simulated(self, cycles: float) -> tuple[Gradient, _Array]:
        """The derivatives of a part of the period, and the state at its end."""
        motion = self.motion
        osc, r, clearance, load = motion.osc, motion.r, motion.clearance, motion.load
        system = (osc.xi, osc.mu, osc.restitution, r, load, clearance)
        now, begun = start_of(system, self.start)
        table = np.empty((MOST_EVENTS, 11))
        n, last, last_contact, final, contact, status = _core.simulate(
            *system, *begun, *later(now[0], cycles), WORDS, table.T
        )
        raise_status(status)
        run: Any = SimpleNamespace(
            osc=osc, r=r, clearance=clearance, load=load, events=table[:n].view(EVENT_TYPE)[:, 0],
            initial_state=state_of(system, now, begun),
            final_state=state_of(system, (final, contact), (last, last_contact)), complete=True,
        )  # fmt: skip
        gradient = trajectory_gradient(run)
        for text in gradient.status.values():
            raise SingularError(text)
        return gradient, np.array([run.final_state[name] for name in STATE])

    def direct(self, slopes: _Array) -> _Array:
        """Derivatives with respect to the parameters for a fixed initial state and load phase."""
        found: _Array = slopes[..., 5:].copy()
        found[..., 0] -= slopes[..., 0] * self.start["t"] / self.motion.r
        return found

    def total(self, slopes: _Array) -> _Array:
        """Derivatives with respect to the parameters along the family of motions."""
        found: _Array = self.direct(slopes) + slopes[..., 1:5] @ self.state
        return found

    def within(self, t: Any) -> Any:
        """A time of the motion, shifted by whole periods into the simulated period."""
        start = self.start["t"]
        return start + np.mod(
            t + self.motion.load_phase / self.motion.r - start, self.motion.period
        )

    def extremes(self, side: int) -> list[_Array]:
        """The derivatives of the greatest (side 1) or least (side -1) position of the primary mass, one for each
        instant at which it is reached: where the velocity passes through 0, or changes its sign at an impact."""
        motion, events = self.motion, self.motion.events
        starts = events["time"]
        lengths = np.diff(starts, append=starts[0] + motion.period)
        nodes = np.linspace(0, 1, 2 + math.ceil(POINTS * max(1.0, motion.r) * lengths.max()))
        grid = starts[:, None] + lengths[:, None] * nodes
        # velocities jump at the ends
        grid[:, -1] = np.nextafter(grid[:, -1], 0)
        rates = side * motion.sample(grid).X_dot
        turns = (lengths[:, None] > 0) & (rates[:, :-1] > 0) & (rates[:, 1:] <= 0)
        times, high = grid[:, :-1][turns], grid[:, 1:][turns]
        for _ in range(60):
            middle = 0.5 * (times + high)
            rising = side * motion.sample(middle).X_dot > 0
            times, high = np.where(rising, middle, times), np.where(rising, high, middle)
        values = motion.sample(times).X
        before, after = side * events["x_dot_before"], side * events["x_dot_after"]
        corners = np.flatnonzero((before > 0) & (after < 0))
        positions = side * np.concatenate([values, events["x"][corners]])
        best = positions.max()
        found = []
        for i in np.flatnonzero(best - positions <= ALIKE * abs(best)).tolist():
            if i < len(times):
                cycles = (self.within(times[i]) - self.start["t"]) * motion.r / (2 * math.pi)
                found.append(self.total(self.simulated(float(cycles))[0]["final_x"]))
            else:
                found.append(
                    self.total(self.whole["x"][self.place(events["time"][corners[i - len(times)]])])
                )
        return found

    def place(self, t: float) -> int:
        """Index of the event of the simulated period at a time of the motion."""
        return int(np.abs(self.whole.values["time"] - self.within(t)).argmin())

    def common(self, slopes: list[_Array]) -> _Array:
        """The derivatives of an extreme that is reached several times; NaN for parameters for which they differ.

        They are compared separately for each parameter: derivatives with respect to the restitution of a wall may
        be small compared with other derivatives, and still differ.
        """
        table = np.array(slopes)
        limit = SAME * np.abs(table).max(axis=0) + ROUNDING * np.abs(self.state).max(axis=0)
        limit += NOTHING * max(self.motion.x_max, -self.motion.x_min)
        return np.where(np.ptp(table, axis=0) > limit, np.nan, table[0])


def multiplier_gradient(period: Period) -> tuple[dict[str, _Array], dict[str, str]]:
    """The derivatives of multipliers, computed for the same motion of a structure of two masses."""
    motion = period.motion
    osc, walls = motion.osc, motion.osc.restitution
    gaps = [
        Gap([-side, side], motion.clearance / 2, walls[i]) for i, side in enumerate((1.0, -1.0))
    ]
    names = ("multipliers", "stability_margin")
    slopes: dict[str, _Array] = {
        "multipliers": np.full((4, len(PARAMETERS)), np.nan, complex),
        "stability_margin": np.full(len(PARAMETERS), np.nan),
    }
    try:
        structure = Structure([1, osc.mu], [2 * osc.xi, 0], [1, 0], gaps)
        load = Load(motion.r, sine=[motion.load, 0])
        if motion.pattern.has_rest:
            start = period.start["t"] % motion.period
            state = [[period.start[name] for name in pair] for pair in (STATE[::2], STATE[1::2])]
            twin = settled(
                structure, load, start, (state[0], state[1]), cycles=motion.pattern.cycles
            )
        else:
            order = (motion.pattern.signs < 0).astype(int).tolist()
            twin = exact_structure(structure, load, (motion.phases, order, motion.pattern.cycles))
        found = twin.gradient([
            "frequency", "opening", "damping_0_0", "mass_1_1", "restitution_0", "restitution_1",
            "restitution", "load",
        ])  # fmt: skip
    except (ParameterError, SingularError) as error:
        return slopes, dict.fromkeys(names, str(error))
    order = [int(np.abs(twin.multipliers - one).argmin()) for one in motion.multipliers]
    # opening d/2, damping 2 xi, and a factor of the load
    units = np.array([1, 0.5, 2, 1, 1, 1, 1, 1 / motion.load])
    slopes["multipliers"] = found["multipliers"][order] * units
    slopes["stability_margin"] = found["stability_margin"] * units
    status = {
        f"multipliers[{k}]": found.status.get(f"multipliers[{j}]", "") for k, j in enumerate(order)
    }
    status["stability_margin"] = found.status.get("stability_margin", "")
    return slopes, {name: text for name, text in status.items() if text}


def oscillator_gradient(motion: Motion) -> Gradient:
    """The derivatives of a motion, in closed form or from a simulated period."""
    simulated = motion.pattern.has_rest or len(motion.pattern) > MOST_IMPACTS
    return period_gradient(motion) if simulated else motion_gradient(motion)


def period_gradient(motion: Motion) -> Gradient:
    """The derivatives of a motion from those of a simulated period."""
    period = Period(motion)
    whole = period.whole
    r, xi = motion.r, motion.osc.xi
    by = {name: np.arange(len(PARAMETERS)) == i for i, name in enumerate(PARAMETERS)}
    places = [period.place(t) for t in motion.alpha / r]
    phases = r * period.total(whole["time"][places]) + np.outer(
        whole.values["time"][places], by["r"]
    )
    slopes: dict[str, _Array] = {"alpha": phases - phases[0], "phases": phases}
    for name, of in OF_IMPACTS.items():
        slopes[name] = period.total(whole[of][places])
    sides = motion.pattern.signs
    slopes["Z"] = slopes["X"] + 0.5 * np.outer(sides, by["clearance"])
    slopes["approach_speeds"] = sides[:, None] * (slopes["Z_dot_before"] - slopes["X_dot_before"])
    square = ((1 - r) * (1 + r)) ** 2 + (2 * xi * r) ** 2
    lag = (2 * xi * (1 + r * r) * by["r"] + 2 * r * (1 - r) * (1 + r) * by["xi"]) / square
    slopes["load_phase"] = phases[0]
    slopes["tau"] = phases[0] - lag
    growth = (2 * r * (1 - r) * (1 + r) - 4 * xi * xi * r) * by["r"] - 4 * xi * r * r * by["xi"]
    slopes["A"] = motion.A * (growth / square + by["load"] / motion.load)
    highest, lowest = period.extremes(1), period.extremes(-1)
    peaks = highest if motion.x_max > -motion.x_min else [-one for one in lowest]
    if abs(motion.x_max + motion.x_min) <= ALIKE * motion.x_max:
        peaks = highest + [-one for one in lowest]
    peak = period.common(peaks)
    slopes["x_max"], slopes["x_min"] = period.common(highest), period.common(lowest)
    by_multipliers, status = multiplier_gradient(period)
    slopes["attenuation"] = (peak - motion.attenuation * slopes["A"]) / motion.A
    for name in ("x_max", "x_min", "attenuation"):
        if np.isnan(slopes[name]).any():
            status[name] = status_text(NOT_SMOOTH)
    slopes |= by_multipliers
    own = {
        "approach_speeds": sides * (motion.Z_dot_before - motion.X_dot_before),
        "stability_margin": 1 - np.abs(motion.multipliers).max(),
    }
    values = {name: frozen(np.array(own.get(name, getattr(motion, name, None)))) for name in slopes}
    dimensions: dict[str, tuple[str, ...]] = {
        name: ("impact",) if values[name].ndim else () for name in slopes
    }
    dimensions["multipliers"] = ("multiplier",)
    of = (
        f"the motion {motion.pattern.sides}/{motion.pattern.cycles} at r = {motion.r:.6g}, "
        f"d K/F0 = {motion.clearance:.6g}"
    )
    tables = {name: frozen(np.array(table)) for name, table in slopes.items()}
    return Gradient(of, PARAMETERS, values, tables, dimensions, status)
