"""Many simulations in one call, on several threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError
from ..base.interrupt import new_counters, stoppable
from ..base.progress import reported
from ..results.states import TWO_PI
from ..systems.oscillator import Oscillator, Point, of_numbers
from ..systems.verbs import physical_arguments

__all__ = ["Bundle", "simulate_bundle"]

#: Total number of load cycles that take only a moment, unless there are very many impacts; up to this number,
#: Ctrl-C is not checked.
LITTLE = 2000


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Bundle:
    """The final states of many simulations.

    Attributes
    ----------
    t, x, x_dot, z, z_dot : ndarray (M,)
        Final states.
    impacts, rests : ndarray (M,) of int
        Numbers of impacts and of rests during the simulation.
    status : ndarray (M,) of int
        0 done; other codes are explained by `status_text`.
    """

    t: NDArray[np.float64]
    x: NDArray[np.float64]
    x_dot: NDArray[np.float64]
    z: NDArray[np.float64]
    z_dot: NDArray[np.float64]
    impacts: NDArray[np.int32]
    rests: NDArray[np.int32]
    status: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        good = int((self.status == 0).sum())
        return (
            f"<Bundle of {len(self)} simulations, {good} done, {int(self.impacts.sum())} impacts>"
        )


@overload
def simulate_bundle(
    osc: Oscillator, r: ArrayLike, clearance: ArrayLike, cycles: float, states: ArrayLike | None = None,
    load: ArrayLike = 1.0, max_events: int = 10_000_000, threads: int | None = None, *,
    progress: Callable[[float, str], None] | None = None,
) -> Bundle: ...  # fmt: skip
@overload
def simulate_bundle(
    point: Point, /, cycles: float, states: ArrayLike | None = None, max_events: int = 10_000_000,
    threads: int | None = None, *, progress: Callable[[float, str], None] | None = None,
) -> Bundle: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
def simulate_bundle(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike,
    cycles: float,
    states: ArrayLike | None = None,
    load: ArrayLike = 1.0,
    max_events: int = 10_000_000,
    threads: int | None = None,
    *,
    progress: Callable[[float, str], None] | None = None,
) -> Bundle:
    """Simulate many initial states or parameters in one call, on several threads.

    The results are identical for any number of threads. A forked child process uses one thread.

    Parameters
    ----------
    osc : Oscillator
        The system: xi, mu and the coefficients of restitution of both walls.
    r, clearance : float or array_like (M,)
        As in `simulate`; an array has one value for each simulation; two numbers are two values, not a range.
    cycles : float
        Load cycles to simulate.
    states : array_like (5,) or (5, M), optional
        Values of t, x, x_dot, z, z_dot at the start; by default all 0.
    load : float or array_like (M,)
        As in `simulate`.
    max_events : int
        Events after which a simulation ends early, with a `status` other than 0.
    threads : int, optional
        Default: one for each processor.
    progress : callable, optional
        Called with the fraction done and an empty text; by default a bar on a terminal or in a notebook.

    Returns
    -------
    Bundle
        The final states, one for each point.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> vi.simulate_bundle(osc, r=np.linspace(1.03, 1.05, 5), clearance=25.0, cycles=1000)
    <Bundle of 5 simulations, 5 done, 9981 impacts>
    """
    of_numbers(osc)
    given = {"r": r, "clearance": clearance, "load": load}
    columns = {name: checks.real_array(value, name, "numbers") for name, value in given.items()}
    start = np.zeros(5) if states is None else checks.real_array(states, "states", "numbers (5, M)")
    if start.ndim not in (1, 2) or start.shape[0] != 5:
        raise ParameterError(
            f"states of shape {start.shape}: must be (5,) or (5, M): t, x, x_dot, z, z_dot"
        )
    try:
        (m,) = np.broadcast_shapes(*(a.shape for a in columns.values()), start.shape[1:], (1,))
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in columns.items())
        raise ParameterError(
            f"{shapes}, states {start.shape}: must have the same length M"
        ) from None
    if not m:
        raise ParameterError("r, clearance, load, states: must have at least one of each, not 0")
    for name, array in columns.items():
        for value in (array.min(), array.max()):
            checks.number(float(value), name)
        columns[name] = np.ascontiguousarray(np.broadcast_to(array, m))
    nearest = float(columns["r"][np.argmin(abs(columns["r"] - 1))])
    checks.frequency_ratio(nearest, osc.xi, near=True)
    start = np.broadcast_to(start.reshape(5, -1), (5, m))
    finite = np.isfinite(start).all(axis=0)
    if not finite.all():
        j = int(np.argmin(finite))
        raise ParameterError(f"states[:, {j}] = {start[:, j].tolist()!r}: must be finite numbers")
    half = 0.5 * columns["clearance"] * (1 + 1e-9)
    outside = np.abs(start[3] - start[1]) > half
    if outside.any():
        j = int(np.argmax(outside))
        raise ParameterError(
            f"states[:, {j}] = {start[:, j].tolist()!r}: must have z - x between the walls, "
            f"-{half[j]:.6g} to {half[j]:.6g}"
        )
    checks.progress(progress)
    cycles = checks.number(cycles, "cycles_simulated", "cycles")
    max_events = checks.integer(max_events, "max_events", 1, 10**9)
    threads = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    arguments = (
        osc.xi, osc.mu, osc.restitution, columns["r"], columns["load"], columns["clearance"], cycles,
        max_events, threads, np.asfortranarray(start),
    )  # fmt: skip
    if m * cycles < LITTLE:
        ends, counts, status = _core.simulate_bundle(*arguments, new_counters())
    else:
        with reported(progress, "simulate_bundle") as told:
            (ends, counts, status), complete = stoppable(
                _core.simulate_bundle, *arguments, counters=new_counters(), progress=told
            )
        if not complete:
            raise KeyboardInterrupt
    t = (TWO_PI * ends[0] + ends[1]) / columns["r"]
    return Bundle(t, ends[2], ends[3], ends[4], ends[5], counts[0], counts[1], status)
