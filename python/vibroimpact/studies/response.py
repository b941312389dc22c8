"""The response of the primary mass along the frequency, over all coexisting attractors."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..results import door
from ..results.noun import Noun, column, key
from ..systems.oscillator import Oscillator
from ..systems.verbs import every_system
from .structure_sweep import response_structure

__all__ = ["Response", "response"]


class Response(Noun, study="response"):
    """max |X|/A against r.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : ndarray (n,)
    load : float
    attenuation : ndarray (n, states)
        max|X|/A of the motion on which each initial state settles; NaN where it failed.
    lowest, highest : ndarray (n,)
        The least and the greatest of these over the attractors at each r; NaN where all failed.
    cycles, symbols : ndarray (n, states) of int
        Load cycles of the shortest period of the stable motion that Newton's method confirms (0: none; chaotic,
        quasi-periodic, or not settled yet), and symbols in it.
    impacts, rests : ndarray (n, states) of int
        Impacts and rests in a period, or in the cycles kept.
    status : ndarray (n, states) of int
        0 done; see `status_text`.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ()
    r = column("points")
    clearance = column("points")
    lowest = column("points")
    highest = column("points")
    attenuation = column("runs")
    cycles = column("runs")
    symbols = column("runs")
    impacts = column("runs")
    rests = column("runs")
    status = column("runs")
    load: float = key("load")

    def plot(self, ax: Any = None) -> Any:
        """Draw each attractor as a dot and the envelopes as lines (extra `plot`); returns the Axes."""
        return self._draw(ax)

    def __repr__(self) -> str:
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return (
            f"<Response at {self.r.size} r from {self.r[0]:.6g} to {self.r[-1]:.6g}: max|X|/A from "
            f"{np.fmin.reduce(self.lowest):.4g} to {np.fmax.reduce(self.highest):.4g}{cut}>"
        )


@every_system(response_structure)
def response(
    osc: Oscillator,
    r: ArrayLike,
    clearance: ArrayLike | None = None,
    inverse_clearance: ArrayLike | None = None,
    states: int = 24,
    load: float = 1.0,
    settling: int = 600,
    keep: int = 33,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Response:
    """max|X|/A along r for a load or a clearance, over all attractors that initial states reach.

    A is the amplitude without impacts: values below 1 mean that the impacts reduce the motion. The extreme
    positions are those of
    the closed form over the period, or over the cycles kept where there is none.

    Parameters
    ----------
    osc : Oscillator
    r : array_like (n,)
    clearance, inverse_clearance : float or array_like (n,)
        d K/F0, or F0/(d K); one of the two. d is the whole travel between the walls.
    states : int
        Initial states at each r, spread evenly.
    load : float
        Load amplitude f > 0; 1 where lengths are in F0/K.
    settling : int
        Load cycles of the transient.
    keep : int
        Load cycles examined.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is given up; its status says so.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    Response

    Raises
    ------
    ParameterError, ParameterTypeError
        The parameter, its value and what it must be.
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`:
        the frequency ratios at which all states were completed.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> vi.response(osc, np.linspace(1.0, 1.02, 6), inverse_clearance=0.03, states=6)
    <Response at 6 r from 1 to 1.02: max|X|/A from 0.3899 to 0.4468>
    """
    keys = {
        **door.line("r", r), "clearance": clearance, "inverse_clearance": inverse_clearance,
        "states": states, "load": load, "settling": settling, "keep": keep,
        "max_events": max_events,
    }  # fmt: skip
    names = {"r_min": "r", "r_max": "r"}
    return door.run(Response, osc, keys, threads=threads, progress=progress, parameters=names)
