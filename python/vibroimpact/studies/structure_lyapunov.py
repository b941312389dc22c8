"""Lyapunov exponents of structures with gaps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.errors import SingularError
from ..motions.structure_noun import StructureNoun, run_structure, start_keys
from ..results.noun import column
from ..systems.structure import Load, Structure

__all__ = ["StructureLyapunov", "lyapunov_structure"]

_Array = NDArray[np.float64]


class StructureLyapunov(StructureNoun, study="lyapunov_structure"):
    """The Lyapunov exponents of a simulated motion of a structure.

    They are those of the map of coordinates and velocities over a cycle of the load: how fast small changes of
    the state grow along the motion, in independent directions. Of a periodic motion they are the logarithms of
    the moduli of its multipliers over the period. A rest of a gap reduces two directions to zero: their exponents
    are -inf. A structure without a load of a frequency has an exponent 0 along its motion; its cycle is a unit of
    time.

    Attributes
    ----------
    structure : Structure
    load : Load or None
    exponents : ndarray (k,)
        Per unit of time, largest first.
    standard_error : ndarray (k,)
        Of `exponents`, per unit of time, from the scatter of the batches.
    per_cycle, error_per_cycle : ndarray (k,)
        The same per load cycle; per unit of time if the load has no frequency.
    cycle : str
        "load cycle", or "unit of time" if the load has no frequency.
    dimension : float
        Kaplan-Yorke dimension of the attractor of the map; NaN unless all 2n exponents were asked for.
    identity_error : float
        Difference of the sum of the exponents from -tr(M^-1 C) + sum log R (R + R' v) over the impacts, per unit
        of time: a check of the whole computation. NaN with rests, or unless all 2n exponents were asked for.
    impacts, rests : int
        Impacts and rests that were averaged over.
    case : str
        The case as a namelist.
    complete : bool
        Always True: nothing is left if Ctrl-C stops it.
    """

    __slots__ = ()
    exponents = column("exponents", "exponent")
    standard_error = column("exponents")
    per_cycle = column("exponents")
    error_per_cycle = column("exponents")

    @property
    def cycle(self) -> str:
        return "load cycle" if self.load is not None and self.load.frequency else "unit of time"

    @property
    def largest(self) -> float:
        """The largest exponent per unit of time: positive in chaos."""
        return float(self.exponents[0])

    @property
    def dimension(self) -> float:
        return float(self._table("run", "dimension"))

    @property
    def identity_error(self) -> float:
        return float(self._table("run", "identity_error"))

    @property
    def impacts(self) -> int:
        return int(self._table("run", "impacts"))

    @property
    def rests(self) -> int:
        return int(self._table("run", "rests"))

    def require(self) -> None:
        """SingularError if there are no exponents."""
        if self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None) -> Any:
        """Draw the exponents, per load cycle or unit of time, by their number (extra `plot`); returns the Axes."""
        return self._draw(ax)

    def __repr__(self) -> str:
        shown = ", ".join(f"{item:.4g}" for item in self.per_cycle[:6].tolist())
        more = ", ..." if self.per_cycle.size > 6 else ""
        return f"<StructureLyapunov: exponents per {self.cycle} {shown}{more}>"


def lyapunov_structure(
    structure: Structure,
    load: Load | None = None,
    cycles: int = 2000,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    discard: int = 300,
    batches: int = 20,
    directions: int | None = None,
    max_events: int = 10_000_000,
    progress: Callable[[float, str], None] | None = None,
) -> StructureLyapunov:
    """Lyapunov exponents of a structure, through impacts, accumulations and rests.

    Directions are carried from event to event by the exact derivatives of flights, impacts, accumulations and
    releases, and made orthonormal after each. The averages over load cycles have a weight that rises from 0 and
    falls to 0 smoothly, so that those over periodic and quasi-periodic motions converge faster than any power of
    the time. Batches of the load cycles, averaged in the same way, give the standard error. One more batch,
    before the others, lets the directions settle. `vibroimpact.lyapunov` calls this for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load, optional
        None: free motion. Without a frequency, cycles are units of time.
    cycles : int
        Load cycles averaged over, at least 2 a batch.
    state : (array_like, array_like), optional
        Coordinates and velocities at the start; zero by default.
    start : float
        Time at the start.
    discard : int
        Load cycles of the transient.
    batches : int
        2 to 1000.
    directions : int, optional
        Number of exponents, the greatest first; by default all, two a coordinate.
    max_events : int
        Events (impacts, rests, releases) after which the simulation is given up.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    StructureLyapunov

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If the simulation fails, as where coupled gaps close at one instant, or reaches `max_events`.

    Examples
    --------
    The exponents of a periodic motion are the logarithms of its multipliers:

    >>> import numpy as np, vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> load = vi.Load(1.0, cosine=[1])
    >>> motion = vi.exact(wall, load, ([0.1], [0]))
    >>> result = vi.lyapunov(wall, load)
    >>> bool(np.allclose(result.per_cycle, np.log(abs(motion.multipliers)), atol=1e-6))
    True
    >>> result
    <StructureLyapunov: exponents per load cycle -0.5373, -0.5373>
    """
    keys = {
        **start_keys(structure, state, start), "cycles": cycles, "discard": discard, "batches": batches,
        "directions": directions, "max_events": max_events,
    }  # fmt: skip
    found = run_structure(
        StructureLyapunov, structure, load, keys, None, progress, needs_frequency=False
    )
    found.require()
    return found
