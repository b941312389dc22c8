"""The response of the primary mass along the frequency, over all attractors that coexist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core, checks
from ..errors import ParameterError, StudyInterrupted
from ..interchange import namelist
from ..interchange.dataset import xarray
from ..interchange.result import Result
from ..interrupt import new_tally, stoppable
from ..model import Oscillator
from ..status import NOT_COMPUTED
from .settling import thread_count
from .spacing import spacing_of

__all__ = ["Response", "response"]

_Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Response(Result):
    """max |X|/A against r.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : ndarray (n,)
    load : float
    attenuation : ndarray (n, states)
        max|X|/A of what each initial state settles on; NaN where it failed.
    lowest, highest : ndarray (n,)
        The least and the greatest of these over the attractors at each r.
    cycles, letters : ndarray (n, states) of int
        Load cycles of the period (0: none was seen), and letters in it.
    status : ndarray (n, states) of int
        0 done; see `status_text`.
    case : str
        What was asked for as a namelist; empty if none can tell (see `to_namelist`).
    complete : bool
        False if Ctrl-C cut it short.
    asked : int
        Frequency ratios that were asked for, if it was cut short; else 0.
    """

    osc: Oscillator
    r: _Array
    clearance: _Array
    load: float
    attenuation: _Array
    lowest: _Array
    highest: _Array
    cycles: NDArray[np.int32]
    letters: NDArray[np.int32]
    status: NDArray[np.int32]
    case: str = ""
    complete: bool = True
    asked: int = 0

    @property
    def cut(self) -> str:
        """How far it came if it was cut short; else empty."""
        return "" if self.complete else f"{self.r.size} of {self.asked} points were reached"

    def to_xarray(self) -> Any:
        """Columns over r and state, and the envelopes over r (extra `data`)."""
        data: dict[str, Any] = {
            name: (("r", "state"), getattr(self, name))
            for name in ("attenuation", "cycles", "letters")
        }
        data |= {name: ("r", getattr(self, name)) for name in ("clearance", "lowest", "highest")}
        own = {"load": self.load, "complete": int(self.complete)}
        return xarray().Dataset(data, {"r": self.r}, own)

    def plot(self, ax: Any = None) -> Any:
        """Draw each attractor as a dot and the envelopes as lines (extra `plot`); returns the Axes."""
        from ..plot.attractor import draw_response

        return draw_response(self, ax)

    def __repr__(self) -> str:
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return (
            f"<Response at {self.r.size} r from {self.r[0]:.6g} to {self.r[-1]:.6g}: max|X|/A from "
            f"{self.lowest.min():.4g} to {self.highest.max():.4g}{cut}>"
        )


def response(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike | None = None,
    inverse_clearance: ArrayLike | None = None,
    states: int = 24,
    load: float = 1.0,
    settling: int = 600,
    keep: int = 33,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Response:
    """max|X|/A along r for a load or a clearance, over all attractors that initial states come to.

    A is the amplitude without impacts, so that below 1 the impacts help. The extreme positions are those of
    the closed form over the period, or over the cycles kept where there is none.

    Parameters
    ----------
    osc : Oscillator
    r : array_like (n,)
    clearance, inverse_clearance : float or array_like (n,)
        d K/F0, or F0/(d K); one of the two.
    states : int
        Initial states at each r, spread evenly.
    load : float
        Load amplitude f > 0; 1 where lengths are in F0/K.
    settling : int
        Load cycles simulated before.
    keep : int
        Load cycles looked at.
    threads : int, optional
        Default: one for each processor. The answer does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and what is being done.

    Returns
    -------
    Response

    Raises
    ------
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`:
        the frequency ratios at which all states came to their end.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> vi.response(osc, np.linspace(1.0, 1.02, 6), inverse_clearance=0.03, states=6)
    <Response at 6 r from 1 to 1.02: max|X|/A from 0.3899 to 0.4468>
    """
    checks.instance(osc, "osc", Oscillator)
    load = checks.number(load, "load")
    if load == 0:
        raise ParameterError("load = 0.0: must be positive, max|X|/A needs a load")
    if (clearance is None) == (inverse_clearance is None):
        raise ParameterError(
            f"clearance = {clearance!r}, inverse_clearance = {inverse_clearance!r}: must be one of "
            "them, the other left out"
        )
    along = np.atleast_1d(checks.real_array(r, "r", "numbers"))
    name = "clearance" if inverse_clearance is None else "inverse_clearance"
    given = checks.real_array(
        clearance if inverse_clearance is None else inverse_clearance,  # type: ignore[arg-type]
        name, "numbers",
    )  # fmt: skip
    if along.ndim != 1 or along.size == 0 or given.shape not in ((), along.shape):
        raise ParameterError(
            f"r {along.shape}, {name} {given.shape}: must be (n,) and a number or (n,)"
        )
    if along.size > 1:
        checks.integer(along.size, "r_points", 2, checks.MOST_VALUES)
    for one_r in along.tolist():
        checks.frequency_ratio(one_r, osc.xi)
    for one in given.ravel().tolist():
        checks.number(one, "clearance", name)
    distance = np.broadcast_to(given if inverse_clearance is None else 1 / given, along.shape)
    states = checks.integer(states, "states", 1, 10**6)
    settling = checks.integer(settling, "settling", 0, 10**7)
    keep = checks.integer(keep, "keep", 3, 10**4)
    checks.together(
        along.size * states, f"states = {states}", "r_points x states must be at most {}"
    )
    workers = thread_count(threads)
    asked = ""
    if given.ndim == 0 and spacing_of(along) == "linear":
        line = {"r_min": float(along[0]), "r_max": float(along[-1]), "r_points": along.size}
        limits = {"states": states, "load": load, "settling": settling, "keep": keep}
        asked = namelist.case(osc, response={**line, name: float(given), **limits})
    (attenuation, envelope, periods, status), complete = stoppable(
        _core.response, states, osc.xi, osc.mu, osc.restitution, along, distance, load, settling, keep,
        workers, tally=new_tally(), progress=progress, note="response",
    )  # fmt: skip
    done = (status != NOT_COMPUTED).all(axis=0)
    if not done.any():
        raise KeyboardInterrupt
    result = Response(
        osc, along[done], np.array(distance)[done], load, attenuation.T[done], envelope[0, done],
        envelope[1, done], periods[0].T[done], periods[1].T[done], status.T[done], asked,
        bool(done.all()), 0 if done.all() else along.size,
    )  # fmt: skip
    if not complete:
        raise StudyInterrupted(result)
    return result
