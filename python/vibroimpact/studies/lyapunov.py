"""Lyapunov exponents through impacts, accumulations and rests."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..results import door
from ..results.noun import Noun, column, key
from ..results.states import NEEDED, checked_state, state_by_coordinates
from ..systems.oscillator import Oscillator
from ..systems.structure import or_structure
from .structure_lyapunov import lyapunov_structure

__all__ = ["Lyapunov", "lyapunov"]

_Array = NDArray[np.float64]


class Lyapunov(Noun, study="lyapunov"):
    """The four Lyapunov exponents of a trajectory, or of many on a grid of points.

    They are those of the map from impact to impact in (x, x', z', alpha), over the time: how fast small
    changes of the state grow along the trajectory, in four independent directions. That section has no
    direction along the flow, so the additional exponent 0 of a flow is not among them. They are also
    the four exponents of the map over one load cycle. Of a periodic motion they are the logarithms of
    the moduli of its multipliers over the period. Impacts that accumulate and end in rest reduce two directions
    to zero: their exponents are -inf.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : ndarray (...)
        The points; 0-d for one.
    load : float
    exponents : ndarray (4, ...)
        Per unit of time 1/omega, largest first; NaN where there were no impacts.
    standard_error : ndarray (4, ...)
        Of `exponents`, per unit of time 1/omega, from the scatter of the batches.
    per_cycle : ndarray (4, ...)
        The exponents per load cycle: logarithms of the mean factors over a cycle.
    error_per_cycle : ndarray (4, ...)
        Standard errors of `per_cycle`, per load cycle.
    dimension : ndarray (...)
        Kaplan-Yorke dimension of the attractor in the section, 0 to 4.
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
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ()
    r = column("points")
    clearance = column("points")
    exponents = column("points", first=True)
    standard_error = column("points", first=True)
    per_cycle = column("points", first=True)
    error_per_cycle = column("points", first=True)
    dimension = column("points")
    identity_error = column("points")
    impacts = column("points")
    rests = column("points")
    status = column("points")
    load: float = key("load")

    @property
    def cycles(self) -> int:
        keys = self.keys
        cycles: int = keys["cycles"] // keys["batches"] * keys["batches"]
        return cycles

    @property
    def largest(self) -> _Array:
        """The largest exponent per unit of time (...): positive in chaos."""
        return np.asarray(self.exponents[0])

    def require(self) -> None:
        """SingularError if it is a single point without exponents."""
        if not self.r.ndim and self.status:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None) -> Any:
        """Draw the exponents against r or clearance, whichever varies (extra `plot`); returns the Axes."""
        return self._draw(ax)

    def __repr__(self) -> str:
        if self.r.ndim:
            chaotic = int((self.per_cycle[0] > 3 * self.error_per_cycle[0]).sum())
            cut = "" if self.complete else f"; cut short, {self.cut}"
            return (
                f"<Lyapunov exponents at {self.r.size} points, {chaotic} with a positive one{cut}>"
            )
        shown = ", ".join(f"{item:.4g}" for item in self.per_cycle.tolist())
        return (
            f"<Lyapunov exponents per load cycle at r = {float(self.r):.6g}, d K/F0 = "
            f"{float(self.clearance):.6g}: {shown}>"
        )


@or_structure(lyapunov_structure, of_law=state_by_coordinates)
def lyapunov(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    cycles: int = 10_000,
    state: Mapping[str, float] | None = None,
    load: float = 1.0,
    discard: int = 1000,
    batches: int = 20,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Lyapunov:
    """All four Lyapunov exponents, through impacts, accumulations and rests.

    Four directions are carried from event to event by the exact derivatives ([P_i] from impact to impact)
    and made orthonormal after each. The averages have a weight that rises from 0 and falls to 0 smoothly, so
    that averages over periodic and quasi-periodic motions converge faster than any power of the time. Batches
    of the load
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
        Load cycles of the transient.
    batches : int
        2 to 1000.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is given up, one at each point; its status
        says so. Long averages need more than the default.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    Lyapunov

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a single point has no impacts.
    StudyInterrupted
        After Ctrl-C, if points were finished: its attribute `result` holds them, as a list.

    Examples
    --------
    The stable motion that corresponds to the third column of Table 1, which has two pairs of complex multipliers.

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
    rs, clearances = (
        checks.real_array(value, name, "numbers")
        for value, name in ((r, "r"), (clearance, "clearance"))
    )
    try:
        rs, clearances = np.broadcast_arrays(rs, clearances)
    except ValueError:
        raise ParameterError(
            f"r {rs.shape}, clearance {clearances.shape}: must have one shape"
        ) from None
    if not rs.size or rs.ndim > 3:
        raise ParameterError(
            f"r, clearance of shape {rs.shape}: must have at least one point, and at most 3 dimensions"
        )
    points, one_r = points_of(rs, clearances)
    if state is not None:
        start = checked_state(state, float(clearances.min()))
        points |= {name: start[name] for name in NEEDED}
    keys = {
        **points, "load": load, "cycles": cycles, "discard": discard, "batches": batches,
        "max_events": max_events,
    }  # fmt: skip
    found = door.run(Lyapunov, osc, keys, one_r, threads, progress)
    found.require()
    return found


def points_of(r: _Array, clearance: _Array) -> tuple[dict[str, Any], float | None]:
    """The keys of the points, and r of the system: one point, a line along r or clearance, or a list."""
    if r.ndim == 0:
        return {"clearance": float(clearance)}, float(r)
    if np.ptp(clearance) == 0 and (line := door.swept(r, "r")):
        return {"parameter": "r", **line, "clearance": clearance[0]}, None
    if np.ptp(r) == 0 and (line := door.swept(clearance, "clearance")):
        return {"parameter": "clearance", **line}, float(r[0])
    lists = {
        name: item.ravel()[: None if np.ptp(item) else 1]
        for name, item in (("r", r), ("clearance", clearance))
    }
    if r.size > 1 and lists["r"].size == lists["clearance"].size == 1:
        lists["r"] = r.ravel()
    return {**lists, "shape": r.shape if r.ndim > 1 else None}, None
