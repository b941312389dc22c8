"""Response quantities of structures, by quadrature of the closed form between events."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..systems.record import Record
from ..systems.structure import Load, Structure
from .quantities import Signal

__all__ = ["StructureQuantities"]

_Array = NDArray[np.float64]
#: Gauss's rule on a panel of at most one radian of the fastest mode or load, and the largest number of panels.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)
MOST = 500_000
#: Numbers of the table of harmonics that is made at a time.
MOST_TURNED = 2 * 10**7
#: Columns of the impacts.
IMPACT_TYPE = np.dtype(
    [("time", "f8"), ("gap", "i4"), ("speed", "f8"), ("impulse", "f8"), ("loss", "f8")]
)


class Run(Protocol):
    """What is needed of a trajectory."""

    @property
    def structure(self) -> Structure: ...
    @property
    def load(self) -> Load | Record | None: ...
    @property
    def start(self) -> float: ...
    @property
    def end(self) -> float: ...
    @property
    def events(self) -> NDArray[Any]: ...
    @property
    def states(self) -> _Array: ...
    def sample(self, t: Any) -> tuple[_Array, _Array]: ...
    def _resting(self) -> tuple[int, ...]: ...


@dataclass(frozen=True, eq=False, repr=False)
class StructureQuantities:
    """Response quantities of a structure over a window of time, in the units of its user.

    Attributes
    ----------
    duration : float
        Length of the window; of a motion its period.
    q, q_dot, q_ddot : Signal
        Coordinates, velocities and accelerations: the numbers of each signal are arrays (n,), its harmonics
        (n, H), of the load phase Omega t. Extremes and rms of the accelerations are those between the
        impacts; their means and harmonics contain the impulses of the impacts.
    transmitted : Signal
        K q + C q', the forces of springs and dashpots on the coordinates.
    impacts : structured ndarray
        ``time``, ``gap``, ``speed`` (of approach), ``impulse`` and ``loss`` (of energy).
    work : float
        Energy that the load puts in, with its constant part.
    damping_loss, impact_loss : float
        Energy that the dashpots and the impacts take.
    energy_change : float
        Energy of masses and springs at the end less that at the start, which is
        ``work - damping_loss - impact_loss``.
    """

    duration: float
    q: Signal
    q_dot: Signal
    q_ddot: Signal
    transmitted: Signal
    impacts: NDArray[Any]
    work: float
    damping_loss: float
    impact_loss: float
    energy_change: float

    def __repr__(self) -> str:
        peaks = f"largest peak {np.max(self.q.peak):.6g}, of accelerations {np.max(self.q_ddot.peak):.6g}"
        return (
            f"<StructureQuantities over {self.duration:.6g}: {peaks}; {len(self.impacts)} impacts>"
        )


def force_at(load: Load | Record | None, t: _Array, n: int) -> _Array:
    """The load on all coordinates (n, m) at some times."""
    force = np.zeros((n, len(t)))
    if load is None:
        return force
    force += load.constant[:, None]
    if isinstance(load, Load):
        for h in range(1, len(load.sine) + 1):
            phase = h * load.frequency * t
            force += np.outer(load.sine[h - 1], np.sin(phase)) + np.outer(
                load.cosine[h - 1], np.cos(phase)
            )
        return force
    times = load.step * np.arange(len(load.samples))
    parts = np.stack([np.interp(t, times, part, left=0.0, right=0.0) for part in load.samples.T])
    return np.asarray(force + load.weights.T @ parts)


def accelerations(run: Run, t: _Array, q: _Array, rate: _Array) -> _Array:
    """Accelerations (n, m) between impacts; those of gaps that rest keep them closed."""
    s: Structure = run.structure
    force = force_at(run.load, t, s.coordinates) - s.damping @ rate - s.stiffness @ q
    found = np.linalg.solve(s.mass, force)
    changes = run.events[run.events["kind"] != "impact"]
    resting = set(run._resting())
    edges = [run.start, *changes["time"].tolist(), math.inf]
    for i, change in enumerate([None, *changes]):
        if change is not None:
            (resting.add if change["kind"] == "stick" else resting.discard)(int(change["gap"]))
        here = (t >= edges[i]) & (t < edges[i + 1])
        if resting and here.any():
            directions = np.array([s.gaps[j].direction for j in sorted(resting)])
            pushed = np.linalg.solve(s.mass, directions.T)
            # gaps that depend on each other share their forces in any way
            forces = np.linalg.lstsq(directions @ pushed, directions @ found[:, here], rcond=None)[
                0
            ]
            found[:, here] -= pushed @ forces
    return np.asarray(found)


def velocities_beside(run: Run, numbers: NDArray[np.int64]) -> tuple[_Array, _Array]:
    """The velocities (n, m) just before and just after some events, of which several may be at one instant."""
    s, events = run.structure, run.events[numbers]
    directions = np.reshape([gap.direction for gap in s.gaps], (-1, s.coordinates))
    kicks = np.linalg.solve(s.mass, directions.T)[:, events["gap"]]
    after = run.states[numbers, 1].T
    before = after + events["impulse"] * kicks
    # what an accumulation leaves of the approach ends without an impulse that is recorded
    for i in np.flatnonzero(events["kind"] == "stick").tolist():
        t, earlier = float(events["time"][i]), run.events["time"][: numbers[i]]
        if earlier.size and earlier[-1] == t:
            before[:, i] = run.states[numbers[i] - 1, 1]
        else:
            just_before = max(run.start, float(np.nextafter(t, -np.inf)))
            before[:, i] = run.sample(just_before)[1][:, 0]
    return before, after


def panels(run: Run, first: float, last: float) -> tuple[_Array, _Array]:
    """Times and weights (panels, 12) of the quadrature: panels end at events and at the samples of a record."""
    s, load = run.structure, run.load
    fastest = math.sqrt(
        max(0.0, float(np.linalg.eigvals(np.linalg.solve(s.mass, s.stiffness)).real.max()))
    )
    fastest = max(
        fastest, float(np.abs(np.linalg.eigvals(np.linalg.solve(s.mass, s.damping))).max())
    )
    if isinstance(load, Load):
        fastest = max(fastest, load.frequency * len(load.sine))
    inner = [run.events["time"]]
    if isinstance(load, Record):
        inner.append(load.step * np.arange(len(load.samples)))
    times = np.concatenate(inner)
    ends = np.unique([first, *times[(times > first) & (times < last)], last])
    parts = np.maximum(1, np.ceil(np.diff(ends) * fastest)).astype(np.int64)
    if parts.sum() > MOST:
        raise ParameterError(
            f"window of {last - first:.6g}: must be at most {(last - first) * MOST / parts.sum():.6g} here"
        )
    # the start and the length of each panel
    size = np.repeat(np.diff(ends) / parts, parts)
    order = np.arange(len(size)) - np.repeat(np.cumsum(parts) - parts, parts)
    start = np.repeat(ends[:-1], parts) + order * size
    return start[:, None] + 0.5 * size[:, None] * (1 + NODES), 0.5 * size[:, None] * WEIGHTS


def window_of(run: Run, window: Any) -> tuple[float, float]:
    """A window within a trajectory."""
    if window is None:
        return run.start, run.end
    wanted = f"two increasing times from {run.start!r} to {run.end!r}"
    ends = checks.real_array(window, "window", wanted)
    if ends.shape != (2,) or not run.start <= ends[0] < ends[1] <= run.end:
        raise ParameterError(f"window = {window!r}: must be {wanted}")
    return float(ends[0]), float(ends[1])


def structure_quantities(
    run: Run, window: Any, harmonics: Any, closed: bool = False
) -> StructureQuantities:
    """The quantities of a trajectory over a window; of a `closed` one, the period of a motion, with the impact
    at its end."""
    harmonics = checks.integer(harmonics, "harmonics", 1, 10_000)
    (first, last), s = window_of(run, window), run.structure
    n = s.coordinates
    t, weight = (values.ravel() for values in panels(run, first, last))

    def signals(times: _Array) -> _Array:
        """Coordinates, velocities, accelerations and forces (4, n, m)."""
        q, rate = run.sample(times)
        return np.stack(
            [q, rate, accelerations(run, times, q, rate), s.stiffness @ q + s.damping @ rate]
        )

    numbers = np.flatnonzero((run.events["time"] > first) & (run.events["time"] <= last))
    events = run.events[numbers]
    before, after = velocities_beside(run, numbers)
    change = after - before
    kinetic = [0.5 * np.einsum("im,ij,jm->m", rate, s.mass, rate) for rate in (before, after)]
    loss = kinetic[0] - kinetic[1]
    values = signals(t)
    whole = last - first
    mean = values @ weight / whole
    rms = np.sqrt(values**2 @ weight / whole)
    frequency = run.load.frequency if isinstance(run.load, Load) else 0.0
    orders = np.arange(1, harmonics + 1 if frequency else 1)
    blocks = max(1, math.ceil(t.size * orders.size / MOST_TURNED))
    weighted = 2 / whole * (values * weight)
    parts = np.concatenate(
        [
            weighted @ np.exp(-1j * frequency * np.outer(t, some))
            for some in np.array_split(orders, blocks)
        ],
        axis=-1,
    )
    # the accelerations with the impulses of the impacts
    mean[2] += change.sum(axis=1) / whole
    parts[2] += 2 / whole * change @ np.exp(-1j * frequency * np.outer(events["time"], orders))
    sides = [np.nextafter(events["time"], -np.inf), events["time"]]
    beside = np.clip(np.concatenate([[first, last], *sides]), first, last)
    least, greatest = extremes(signals, t, beside, values)
    q, q_dot, q_ddot, transmitted = [
        Signal(*(each[i] for each in (mean, rms, least, greatest, parts))) for i in range(4)
    ]
    hits = events["kind"] == "impact"
    impacts = np.empty(hits.sum(), dtype=IMPACT_TYPE)
    for name in ("time", "gap", "speed", "impulse"):
        impacts[name] = events[name][hits]
    impacts["loss"] = loss[hits]
    impacts.flags.writeable = False
    rate = values[1]
    energy = [
        0.5 * float(v @ s.mass @ v + x @ s.stiffness @ x)
        for x, v in (map(np.ravel, run.sample(np.array([end]))) for end in (first, last))
    ]
    return StructureQuantities(
        whole, q, q_dot, q_ddot, transmitted, impacts,
        float(np.sum(force_at(run.load, t, n) * rate * weight)),
        float(np.sum((s.damping @ rate) * rate * weight)), float(loss.sum()),
        0.0 if closed else energy[1] - energy[0],
    )  # fmt: skip


def extremes(signals: Any, t: _Array, beside: _Array, values: _Array) -> tuple[_Array, _Array]:
    """The least and the greatest values (4, n): at the nodes, at both sides of the events, and near the best nodes
    by golden sections."""
    at = signals(beside)
    found = []
    for sign in (-1, 1):
        best = np.argmax(sign * values, axis=-1)
        low, high = t[np.maximum(best - 1, 0)], t[np.minimum(best + 1, len(t) - 1)]
        ratio = (math.sqrt(5) - 1) / 2
        place = np.indices(best.shape)

        def value(times: _Array, place: Any = place, sign: int = sign) -> _Array:
            flat = signals(times.ravel())
            own = np.arange(times.size).reshape(times.shape)
            return np.asarray(sign * flat[place[0], place[1], own])

        for _ in range(40):
            left, right = high - ratio * (high - low), low + ratio * (high - low)
            rising = value(left) < value(right)
            low, high = np.where(rising, left, low), np.where(rising, high, right)
        top = np.maximum(value(0.5 * (low + high)), (sign * at).max(axis=-1))
        found.append(sign * np.maximum(top, (sign * values).max(axis=-1)))
    return found[0], found[1]
