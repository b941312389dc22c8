"""Lyapunov exponents through impacts, accumulations and rests."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core, checks
from ..errors import ParameterError, SingularError, StudyInterrupted
from ..interchange import namelist
from ..interchange.dataset import xarray
from ..interchange.result import Result
from ..interrupt import new_tally, stoppable
from ..model import Oscillator
from ..states import TWO_PI, start_of, told
from ..status import NO_MOTION, NOT_COMPUTED, status_text
from .spacing import spacing_of

__all__ = ["Lyapunov", "lyapunov"]

_Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Lyapunov(Result):
    """The four Lyapunov exponents of a trajectory, or of many on a grid of points.

    They are those of the map from impact to impact in (x, x', z', alpha), over the time: how fast small
    changes of the state grow along the trajectory, in four independent directions. That section has no
    direction along the flow, so the exponent 0 that a flow has besides is not among them; they are also
    the four exponents of the map over one load cycle. Of a periodic motion they are the logarithms of
    the moduli of its multipliers over the period. Impacts that accumulate and end in rest extinguish two
    directions: their exponents are -inf.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : ndarray (...)
        The points; 0-d for one.
    load : float
    exponents : ndarray (4, ...)
        Per unit of time 1/omega, largest first; NaN where there were no impacts.
    standard_error : ndarray (4, ...)
        Of the exponents, from the scatter of the batches.
    dimension : ndarray (...)
        Kaplan and Yorke's dimension of the attractor in the section, 0 to 4.
    identity_error : ndarray (...)
        Difference of the sum of all logarithms from -2 xi t + 2 sum log R + log(u_first/u_last), per unit
        of time, over all flights from impact to impact: a check of the whole computation. u is the speed
        at which the masses part.
    impacts, rests : ndarray (...) of int
        Impacts and rests that were averaged over.
    cycles : int
        Load cycles that were averaged over.
    status : ndarray (...) of int
        0 done; see `status_text`.
    case : str
        What was asked for as a namelist; empty if none can tell (see `to_namelist`).
    complete : bool
        False if Ctrl-C cut it short.
    asked : int
        Points that were asked for, if it was cut short; else 0.
    """

    osc: Oscillator
    r: _Array
    clearance: _Array
    load: float
    exponents: _Array
    standard_error: _Array
    dimension: _Array
    identity_error: _Array
    impacts: NDArray[np.int32]
    rests: NDArray[np.int32]
    cycles: int
    status: NDArray[np.int32]
    case: str = ""
    complete: bool = True
    asked: int = 0

    @property
    def cut(self) -> str:
        """How far it came if it was cut short; else empty."""
        return "" if self.complete else f"{self.r.size} of {self.asked} points were reached"

    @property
    def per_cycle(self) -> _Array:
        """The exponents per load cycle, (4, ...): logarithms of the mean factors over a cycle."""
        return np.asarray(self.exponents * (TWO_PI / self.r))

    @property
    def largest(self) -> _Array:
        """The largest exponent per unit of time (...): positive in chaos."""
        return np.asarray(self.exponents[0])

    def to_xarray(self) -> Any:
        """The numbers as an xarray.Dataset over the points (extra `data`)."""
        points = [f"point_{i}" for i in range(self.r.ndim)] if self.r.ndim > 1 else ["point"]
        points = points[: self.r.ndim]
        data: dict[str, Any] = {
            name: (points, getattr(self, name))
            for name in ("r", "clearance", "identity_error", "impacts", "rests", "dimension")
        }
        for name in ("exponents", "per_cycle", "standard_error"):
            data[name] = (["direction", *points], getattr(self, name))
        attributes = {
            "load": self.load,
            "cycles": self.cycles,
            "xi": self.osc.xi,
            "mu": self.osc.mu,
            "complete": int(self.complete),
        }
        return xarray().Dataset(data, attrs=attributes | {"restitution": self.osc.restitution})

    def plot(self, ax: Any = None) -> Any:
        """Draw the exponents against r or clearance, whichever varies (extra `plot`); returns the Axes."""
        from ..plot.attractor import draw_lyapunov

        return draw_lyapunov(self, ax)

    def __repr__(self) -> str:
        if self.r.ndim:
            chaotic = int((self.largest > 3 * self.standard_error[0]).sum())
            cut = "" if self.complete else f"; cut short, {self.cut}"
            return (
                f"<Lyapunov exponents at {self.r.size} points, {chaotic} with a positive one{cut}>"
            )
        shown = ", ".join(f"{item:.4g}" for item in self.per_cycle.tolist())
        return (
            f"<Lyapunov exponents per load cycle at r = {float(self.r):.6g}, d K/F0 = "
            f"{float(self.clearance):.6g}: {shown}>"
        )


def lyapunov(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    cycles: int = 10_000,
    state: Mapping[str, float] | None = None,
    load: float = 1.0,
    discard: int = 1000,
    batches: int = 20,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov:
    """All four Lyapunov exponents, through impacts, accumulations and rests.

    Four directions are carried from event to event by the exact derivatives ([P_i] from impact to impact)
    and made orthonormal after each. The averages have a weight that rises from 0 and falls to 0 smoothly, so
    that what is periodic or quasi-periodic converges faster than any power of the time. Batches of the load
    cycles, averaged in the same way, give the standard error. One more batch, before the others, lets the
    directions settle.

    Parameters
    ----------
    osc : Oscillator
    r, clearance : float or array_like
        One point, or arrays of one shape.
    cycles : int
        Load cycles averaged over, at least 2 a batch.
    state : mapping, optional
        As in `simulate`; the default is rest in the middle.
    load : float
    discard : int
        Load cycles simulated before.
    batches : int
        2 to 1000.
    threads : int, optional
        Default: one for each processor. The answer does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and what is being done.

    Returns
    -------
    Lyapunov

    Raises
    ------
    SingularError
        If a single point has no impacts.
    StudyInterrupted
        After Ctrl-C, if points were finished: its attribute `result` holds them, as a list.

    Examples
    --------
    The stable motion beside the third column of Table 1, which has two pairs of complex multipliers.

    >>> import math, numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> near = dict(t=motion.load_phase / 0.94, x=motion.X[0], x_dot=motion.X_dot_after[0],
    ...             z=motion.Z[0], z_dot=motion.Z_dot_after[0])
    >>> result = vi.lyapunov(osc, 0.94, 37.0, state=near)
    >>> bool(np.allclose(result.per_cycle, np.log(abs(motion.multipliers)), atol=1e-6))
    True
    >>> result
    <Lyapunov exponents per load cycle at r = 0.94, d K/F0 = 37: -0.0674, -0.0674, -0.5414, -0.5414>
    """
    checks.instance(osc, "osc", Oscillator)
    batches = checks.integer(batches, "batches", 2, 1000)
    cycles = checks.integer(cycles, "cycles", 2 * batches, 10**9)
    discard = checks.integer(discard, "discard", 0, 10**9)
    load = checks.number(load, "load")
    threads = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    rs, clearances = (
        checks.real_array(value, name, "numbers")
        for value, name in ((r, "r"), (clearance, "clearance"))
    )
    try:
        rs, clearances = (np.array(item) for item in np.broadcast_arrays(rs, clearances))
    except ValueError:
        raise ParameterError(
            f"r {rs.shape}, clearance {clearances.shape}: must have one shape"
        ) from None
    if not rs.size:
        raise ParameterError(f"r, clearance of shape {rs.shape}: must have at least one point")
    if rs.size > 1:
        checks.integer(rs.size, "values", 2, checks.MOST_VALUES)
    states, contacts = (
        np.empty((7, rs.size), order="F"),
        np.empty((3, rs.size), np.int32, order="F"),
    )
    for j, (one_r, one_clearance) in enumerate(zip(rs.ravel(), clearances.ravel(), strict=True)):
        each_r = checks.frequency_ratio(float(one_r), osc.xi)
        each_clearance = checks.number(float(one_clearance), "clearance")
        system = (osc.xi, osc.mu, osc.restitution, each_r, load, each_clearance)
        states[:, j], contacts[:, j] = start_of(system, state)[1]
    keys = {"cycles": cycles, "discard": discard, "batches": batches, "load": load}
    asked = _case(osc, rs, clearances, told(state), keys)
    found, complete = stoppable(
        _core.lyapunov, osc.xi, osc.mu, osc.restitution, rs.ravel(), np.full(rs.size, load),
        clearances.ravel(), states, contacts, discard, cycles // batches, batches, threads,
        tally=new_tally(), progress=progress, note="Lyapunov exponents",
    )  # fmt: skip
    status, wanted = found[-1], rs.size
    if not complete:
        done = status != NOT_COMPUTED
        if rs.ndim == 0 or not done.any():
            raise KeyboardInterrupt
        rs, clearances = rs.ravel()[done], clearances.ravel()[done]
        found = [item[..., done] for item in found]
    exponents, deviations, dimensions, counts, errors, status = found
    if rs.ndim == 0 and status[0] != 0:
        why = "no impacts in a batch" if status[0] == NO_MOTION else status_text(int(status[0]))
        raise SingularError(f"Lyapunov exponents: {why}")
    shape = rs.shape
    result = Lyapunov(
        osc, rs, clearances, load, exponents.reshape(4, *shape), deviations.reshape(4, *shape),
        dimensions.reshape(shape), errors.reshape(shape), counts[0].reshape(shape),
        counts[1].reshape(shape), cycles // batches * batches, status.reshape(shape), asked,
        rs.size == wanted, 0 if rs.size == wanted else wanted,
    )  # fmt: skip
    if not complete:
        raise StudyInterrupted(result)
    return result


def _case(
    osc: Oscillator, r: _Array, clearance: _Array, start: dict[str, float] | None, keys: dict[str, Any]
) -> str:  # fmt: skip
    """What was asked for as a namelist, empty if it cannot tell the start or the points."""
    if start is None or r.ndim > 1:
        return ""
    if r.ndim == 0:
        group = {"clearance": float(clearance), **keys, **start}
        return namelist.case(osc, float(r), lyapunov=group)
    name, along, other = (
        ("r", r, clearance) if np.ptp(clearance) == 0 else ("clearance", clearance, r)
    )
    spacing = spacing_of(along)
    if spacing is None or np.ptp(other):
        return ""
    line = {
        "parameter": name,
        "low": float(along[0]),
        "high": float(along[-1]),
        "values": along.size,
    }
    fixed = {"clearance": float(other[0])} if name == "r" else {}
    return namelist.case(
        osc, None if name == "r" else float(other[0]),
        lyapunov={**fixed, **line, "spacing": spacing, **keys, **start},
    )  # fmt: skip
