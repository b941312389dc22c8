"""Response quantities of motions and trajectories of every system; the core integrates in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.interrupt import interruptible
from ..base.status import raise_status
from ..systems.structure import Load, opening_speed_at

if TYPE_CHECKING:
    from ..systems.oscillator import Oscillator

__all__ = ["Quantities", "Signal"]

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Columns of the impacts of a structure, and further columns for an oscillator.
IMPACT_TYPE = [("time", "f8"), ("gap", "i4"), ("speed", "f8"), ("impulse", "f8"), ("loss", "f8")]
OF_OSCILLATOR = [("side", "U1"), ("jump", "f8")]
#: The dimensionless units of the numbers that the representation shows.
SHOWN = ("1/omega", "F0/K", "omega^2 F0/K")
#: Mass used for a free mass of zero mass: so small that it does not affect the primary mass.
MASSLESS = 1e-30


def plain(values: Any) -> Any:
    """An array, or a number as a float."""
    return values if np.ndim(values) else float(values)


@dataclass(frozen=True, eq=False)
class Signal:
    """One quantity over the window of `Quantities`; arrays (n,) with the coordinates of a structure.

    Attributes
    ----------
    mean, rms : float
        Mean value, and root mean square (including the mean).
    least, greatest : float
        Extremes, including both sides of each jump.
    harmonics : ndarray (H,) of complex
        c_h, where the part of h times the load frequency is ``Re(c_h exp(i h phi))`` at the load phase phi.
    """

    mean: Any
    rms: Any
    least: Any
    greatest: Any
    harmonics: _Complex

    def of(self, i: int) -> Signal:
        """The signal of one coordinate."""
        return Signal(*(plain(part[i]) for part in vars(self).values()))

    @property
    def peak(self) -> Any:
        """The greatest magnitude."""
        return plain(np.maximum(-self.least, self.greatest))

    @property
    def amplitude(self) -> Any:
        """Amplitude of the fundamental."""
        return plain(np.abs(self.harmonics[..., 0]))

    @property
    def phase(self) -> Any:
        """Phase by which the fundamental leads the load sin(phi), from -pi to pi: it is
        ``amplitude sin(phi + phase)``."""
        return plain(np.angle(1j * self.harmonics[..., 0]))


@dataclass(frozen=True, eq=False, repr=False)
class Quantities:
    """Response quantities over a window of time, exact except for rounding.

    Values are in the units of the structure or, for an oscillator, with lengths in F0/K, time in 1/omega and
    forces in F0.

    Attributes
    ----------
    duration : float
        Length of the window; for a motion its period.
    cycles : float
        Load cycles in the window; NaN without a load frequency.
    q, q_dot, q_ddot : Signal
        Coordinates, velocities and accelerations: the numbers of each signal are arrays (n,), its harmonics
        (n, H), of the load phase Omega t. Extremes and rms of the accelerations are those between the
        impacts. Their means and harmonics contain the impulses of the impacts: the acceleration of a rigid mass
        has a spike there, whose area is the change of velocity. Coordinates of an oscillator are those of the
        primary and the free mass.
    transmitted : Signal
        K q + C q', the forces of springs and dashpots on the coordinates; for an oscillator, the force on the
        base.
    x, x_dot, x_ddot : Signal
        Displacement, velocity and acceleration of the primary mass, for an oscillator only.
    impacts : structured ndarray
        ``time``, ``gap``, ``speed`` (of approach), ``impulse`` (> 0) and ``loss`` (of energy); for an oscillator
        also ``side`` and ``jump`` (of the acceleration of the primary mass). The last and smallest impacts of an
        accumulation are not listed; energies and harmonics contain them.
    work : float
        Energy supplied by the load (with its constant part), by the belts, and by moving walls: the contact force,
        or the impulse of an impact, times the speed of the wall.
    damping_loss, impact_loss, friction_loss : float
        Energy dissipated by the dashpots (including those of stops), the impacts and dry friction.
    energy_change : float
        Energy of masses and springs (including those of stops) at the end minus that at the start; 0 for a motion,
        and always ``work - damping_loss - impact_loss - friction_loss``.
    of_structure : bool
        Whether the system is a `Structure` with its load rather than an `Oscillator`.
    """

    duration: float
    cycles: float
    q: Signal
    q_dot: Signal
    q_ddot: Signal
    transmitted: Signal
    impacts: NDArray[Any]
    work: float
    damping_loss: float
    impact_loss: float
    friction_loss: float
    energy_change: float
    of_structure: bool
    #: The units of time, length and acceleration, for the representation; "" for those of a structure's user.
    _unit_names: tuple[str, str, str] = ("", "", "")
    #: The dimensionless unit of each for an oscillator.
    units: ClassVar[dict[str, str]] = {
        "duration": "1/omega", "q": "F0/K", "q_dot": "omega F0/K", "q_ddot": "omega^2 F0/K",
        "x": "F0/K", "x_dot": "omega F0/K", "x_ddot": "omega^2 F0/K",
        "transmitted": "F0", "time": "1/omega", "speed": "omega F0/K", "impulse": "F0/omega",
        "loss": "F0^2/K", "jump": "omega^2 F0/K", "work": "F0^2/K", "damping_loss": "F0^2/K",
        "impact_loss": "F0^2/K", "friction_loss": "F0^2/K", "energy_change": "F0^2/K",
    }  # fmt: skip

    @property
    def x(self) -> Signal:
        """Displacement of the primary mass in F0/K, for an oscillator only."""
        return self._of_primary("x", self.q)

    @property
    def x_dot(self) -> Signal:
        """Velocity of the primary mass in omega F0/K, for an oscillator only."""
        return self._of_primary("x_dot", self.q_dot)

    @property
    def x_ddot(self) -> Signal:
        """Acceleration of the primary mass in omega^2 F0/K, for an oscillator only."""
        return self._of_primary("x_ddot", self.q_ddot)

    def _of_primary(self, name: str, signal: Signal) -> Signal:
        """The signal of the primary mass of an oscillator."""
        if self.of_structure:
            raise AttributeError(
                f"{name}: a Quantities of a Structure does not have it; it has {name.replace('x', 'q')}"
            )
        return signal.of(0)

    def __repr__(self) -> str:
        signals = (self.q, self.q_ddot) if self.of_structure else (self.x, self.x_ddot)
        peak, highest = (np.max(signal.peak) for signal in signals)
        whole, length, acceleration = (
            f"{value:.6g}{f' {unit}' * bool(unit)}".replace(" 1/", "/")
            for value, unit in zip((self.duration, peak, highest), self._unit_names, strict=True)
        )
        return (
            f"<Quantities over {whole}: largest peak {length}, of accelerations {acceleration}; "
            f"{len(self.impacts)} impacts>"
        )


def integrated(
    arguments: tuple[Any, ...], segments: tuple[_Array, NDArray[np.int32]], window: tuple[float, float],
    harmonics: Any, impacts: NDArray[Any], of_structure: bool,
) -> Quantities:  # fmt: skip
    """The quantities over a window of a structure given as arguments of the core."""
    harmonics = checks.integer(harmonics, "harmonics", 1, 10_000)
    frequency, whole = arguments[3], window[1] - window[0]
    orders = harmonics if frequency else 0
    numbers, parts, energies, share, status = interruptible(
        _core.structure_quantities, *arguments, *segments, window, max(1, orders)
    )
    raise_status(status)
    if share < 1:
        raise ParameterError(f"window of {whole:.6g}: must be at most {share * whole:.6g} here")
    for array in (numbers, parts, impacts):
        array.flags.writeable = False
    n = len(numbers) // 4
    q, q_dot, q_ddot, transmitted = (
        Signal(*[*numbers[i : i + n].T, parts[i : i + n, :orders]]) for i in range(0, 4 * n, n)
    )
    work, damping, resting, change, friction = energies.tolist()
    return Quantities(
        whole, whole * frequency / (2 * math.pi) if frequency else math.nan, q, q_dot, q_ddot,
        transmitted if of_structure else transmitted.of(0), impacts, work, damping,
        math.fsum([*impacts["loss"], resting]), friction, change, of_structure,
    )  # fmt: skip


def structure_quantities(
    run: Any, arguments: tuple[Any, ...], segments: tuple[_Array, NDArray[np.int32]],
    window: tuple[float, float], harmonics: Any,
) -> Quantities:  # fmt: skip
    """The quantities of a trajectory of a structure, which is also given as arguments of the core."""
    time = run.events["time"]
    hits = (time > window[0]) & (time <= window[1]) & (run.events["kind"] == "impact")
    impacts = np.empty(hits.sum(), dtype=IMPACT_TYPE)
    for name in ("time", "gap", "speed", "impulse"):
        impacts[name] = run.events[name][hits]
    gaps = run.structure.gaps
    directions = np.reshape([gap.direction for gap in gaps], (-1, run.structure.coordinates))
    wall = np.zeros(len(impacts))
    if run.structure._moves:
        for i, gap in enumerate(gaps):
            here = impacts["gap"] == i
            wall[here] = opening_speed_at(gap, impacts["time"][here], run.load.frequency)
    # the closing speed of the gaps just after the impacts is negative
    closing = (directions[impacts["gap"]] * run.states[hits, 1]).sum(axis=1) - wall
    speed = impacts["speed"]
    if run.structure.simultaneous == "newton":
        # impulses that act at once have the approach speeds before all of them
        own = np.sum(directions * np.linalg.solve(run.structure.mass, directions.T).T, axis=1)
        speed = closing + own[impacts["gap"]] * impacts["impulse"]
    impacts["loss"] = 0.5 * impacts["impulse"] * (speed + closing)
    found = integrated(arguments, segments, window, harmonics, impacts, True)
    # the work of a moving wall contains its speed
    work = math.fsum([found.work, *(-impacts["impulse"] * wall)])
    units = run.structure._units
    if units is None:
        return replace(found, work=work)
    names = tuple(map(units.name, SHOWN)) if units.M == units.K == units.F0 == 1 else SHOWN
    return replace(found, work=work, _unit_names=names)


def oscillator_quantities(
    osc: Oscillator, r: float, load: float, clearance: float, starts: _Array, resting: NDArray[np.int32],
    window: tuple[float, float], events: NDArray[Any], harmonics: Any,
) -> Quantities:  # fmt: skip
    """The quantities of an oscillator, as the structure of its two masses, from the state (6, n) at the start of
    each segment and the side of a rest in it, or 0."""
    walls = np.array([[-1.0, 1.0], [1.0, -1.0]])
    matrices = [np.diag([1, max(osc.mu, MASSLESS)]), np.diag([2 * osc.xi, 0]), np.diag([1.0, 0])]
    force = Load(r, sine=[load, 0])._arrays()
    arguments = (
        np.stack(matrices, axis=-1), walls, np.array([[0.5 * clearance] * 2, [0.0] * 2]), *force, 0.0,
        np.zeros((2, 1)),
    )  # fmt: skip
    # impact, stick and release; for a release, the gap that rested
    before = np.append(0, resting[:-1])
    kinds = np.where(resting != 0, 2, np.where(before != 0, 3, 1))
    labels = np.array([kinds, np.where(resting + (resting == 0) * before < 0, 2, 1)], np.int32)
    later = np.mod(starts[1, 0], 2 * math.pi) / r - starts[0, 0]
    own = np.vstack([starts[0] + later, starts[[2, 4, 3, 5]]])
    hits = events[events["kind"] == "impact"]
    share = osc.mu / (1 + osc.mu)
    speed = np.abs(hits["z_dot_before"] - hits["x_dot_before"])
    parting = np.abs(hits["z_dot_after"] - hits["x_dot_after"])
    impacts = np.empty(len(hits), dtype=IMPACT_TYPE + OF_OSCILLATOR)
    for name, values in {
        "time": hits["time"], "gap": hits["side"] == "L", "side": hits["side"], "speed": speed,
        "impulse": share * (speed + parting), "loss": 0.5 * share * (speed - parting) * (speed + parting),
        "jump": 2 * osc.xi * (hits["x_dot_before"] - hits["x_dot_after"]),
    }.items():  # fmt: skip
        impacts[name] = values
    ends = (window[0] + later, window[1] + later)
    found = integrated(arguments, (own, labels), ends, harmonics, impacts, False)
    return replace(found, _unit_names=SHOWN)
