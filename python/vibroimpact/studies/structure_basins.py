"""Basins of attraction of structures with gaps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base.errors import ParameterError, SingularError
from ..base.spacing import Axis
from ..motions.structure_motion import StructureMotion
from ..motions.structure_noun import StructureNoun, run_structure, start_keys
from ..results.noun import column
from ..systems.structure import Load, Structure
from .structure_find import motions_of

__all__ = ["StructureAttractor", "StructureBasins", "basins_structure"]

_Array = NDArray[np.float64]
#: The label of a state that was not simulated because the study was stopped.
NOT_REACHED = -2


class StructureAttractor(NamedTuple):
    """An attractor of a structure.

    Attributes
    ----------
    name : str
        Impacts and load cycles of a period, as "2/1"; "rest/1" with rests; "no impacts"; "permanent rest", where
        gaps stay at rest; "chaotic", all states whose largest Lyapunov exponent is positive by its error; or
        "quasi-periodic", all states where it is zero by its error and no stable motion is near. Equal names get a
        number.
    motion : StructureMotion or None
        The exact motion; None without impacts, and if it is not periodic.
    """

    name: str
    motion: StructureMotion | None

    def __repr__(self) -> str:
        return f"<attractor {self.name}>"


class StructureBasins(StructureNoun, study="basins_structure"):
    """On which attractor each of many initial states of a structure settles.

    Attributes
    ----------
    structure : Structure
    load : Load
    attractors : list of StructureAttractor
        By decreasing share; the label of an attractor is its place in this list.
    labels : ndarray (n, m) of int, or (M,)
        For each state of the plane (first axis, second axis) or of the list; -1 not decided, -2 not reached
        before it was cut short, -3 not decided before `max_events`, -4 a gap is closed in the initial state.
    axes : (Axis, Axis) or None
    states : ndarray (2, n, ...)
        Coordinates and velocities of each.
    fractions : ndarray
        Share of the states without a closed gap that settle on each attractor; of those that were reached, if it
        was cut short.
    standard_error : ndarray
        Standard error of the fractions for independent states; an upper bound for states of a lattice.
    case : str
        The case as a namelist.
    complete : bool
        False if Ctrl-C stopped it early; `cut` then says how far it got.
    """

    __slots__ = ("_attractors",)
    _attractors: list[StructureAttractor]
    labels = column("states", "label")
    fractions = column("attractors", "fraction")
    standard_error = column("attractors")

    @property
    def attractors(self) -> list[StructureAttractor]:
        if not hasattr(self, "_attractors"):
            motions = motions_of(self)
            names, numbers = (self._table("attractors", name) for name in ("name", "number"))
            if numbers.size and numbers.max() >= len(motions):
                raise ParameterError(
                    f"attractors.number = {numbers.max()}: must be below {len(motions)}, the number of motions"
                )
            found = [
                StructureAttractor(str(name), motions[i] if i >= 0 else None)
                for name, i in zip(names, numbers.tolist(), strict=True)
            ]
            object.__setattr__(self, "_attractors", found)
        return self._attractors

    @property
    def states(self) -> _Array:
        parts = [np.moveaxis(self._table("states", name), -1, 0) for name in ("q", "q_dot")]
        return np.stack(parts)

    @property
    def axes(self) -> tuple[Axis, Axis] | None:
        keys = self.keys
        names = ("axes", "low", "high", "values")
        if any(name not in keys for name in names):
            return None
        columns = (keys[name] for name in names)
        first, second = (Axis(*each) for each in zip(*columns, strict=True))
        return first, second

    undrawable = "random states have no picture"

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether its states are those of a plane."""
        return self.axes is not None

    def require(self) -> None:
        """SingularError if nothing was simulated."""
        if "states" not in self._result.tables:
            raise SingularError(self._result.notes[0][1])

    def plot(self, ax: Any = None) -> Any:
        """Draw the plane, one colour for each attractor (extra `plot`); returns the Axes."""
        return self._draw(ax)

    def __repr__(self) -> str:
        names = self._table("attractors", "name")
        parts = [f"{name} {share:.1%}" for name, share in zip(names, self.fractions, strict=True)]
        left = int(np.isin(self.labels, (-1, -3)).sum())
        parts += [f"{left} not decided"] if left and self.complete else []
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return f"<StructureBasins of {self.labels.size} states: {', '.join(parts)}{cut}>"


def basins_structure(
    structure: Structure,
    load: Load,
    plane: tuple[Any, Any] | None = None,
    states: int | None = None,
    state: tuple[ArrayLike, ArrayLike] | None = None,
    start: float = 0.0,
    settling: int = 1000,
    max_cycles: int = 16,
    seed: int = 0,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> StructureBasins:
    """On which attractor each of many initial states of a structure settles.

    Each state is simulated until it repeats to rounding near a motion that Newton's method confirms as admissible
    and stable, or for `settling` load cycles. If nothing is decided then, it is followed for longer: its largest
    Lyapunov exponent tells whether it is chaotic, quasi-periodic, or still settling. Equal motions are one
    attractor, whatever impact they are counted from. `vibroimpact.basins` calls this for a `Structure`.

    Parameters
    ----------
    structure : Structure
    load : Load
        With a frequency.
    plane : ((name, low, high, n), (name, low, high, n)), optional
        Names are "q_0", "q_1", ... (coordinates, from 0) and "q_dot_0", ... (velocities).
    states : int, optional
        Instead of a plane: this many random states, as those of `find`. The first one is rest at q = 0.
    state : (array_like, array_like), optional
        Coordinates and velocities off the axes of the plane; zero by default.
    start : float
        Time at the start.
    settling : int
        Load cycles after which a state that does not repeat is followed for longer.
    max_cycles : int
        Longest period that is considered, in load cycles.
    seed : int
        Of random states. A state depends only on the seed and its number.
    max_events : int
        Events (impacts, rests, releases) after which one simulation is given up: its state has the label -3.
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and the present task.

    Returns
    -------
    StructureBasins

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If random states are asked for where a gap is closed at q = 0.
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    >>> damper = vi.Structure(mass=[1, 0.042], damping=[0.01, 0], stiffness=[1, 0], gaps=gaps)
    >>> plane = (("q_0", -10, 10, 8), ("q_dot_0", -20, 20, 8))
    >>> result = vi.basins(damper, vi.Load(0.94, sine=[1, 0]), plane)
    >>> result.attractors[:2]
    [<attractor no impacts>, <attractor 2/1 (1)>]
    >>> result.labels.shape
    (8, 8)
    """
    if (plane is None) == (states is None):
        raise ParameterError(
            f"plane = {plane!r}, states = {states!r}: must be one of them, the other left out"
        )
    keys: dict[str, Any] = {
        **start_keys(structure, state, start), "settling": settling, "max_cycles": max_cycles,
        "max_events": max_events,
    }  # fmt: skip
    names = {
        "axes": "plane: name",
        "low": "plane: low",
        "high": "plane: high",
        "values": "plane: n",
    }
    keys |= {"states": states, "seed": seed} if plane is None else _plane_keys(plane)
    found = run_structure(StructureBasins, structure, load, keys, threads, progress, names)
    found.require()
    return found


def _plane_keys(plane: Any) -> dict[str, Any]:
    """The keys of the two axes of a plane."""
    try:
        axes = [Axis(*item) for item in plane]
    except TypeError:
        axes = []
    if len(axes) != 2:
        raise ParameterError(
            f"plane = {plane!r}: must be two of (name, low, high, n), names q_0, q_1, ... or q_dot_0, ..."
        )
    lists = map(list, zip(*axes, strict=True))
    return dict(zip(("axes", "low", "high", "values"), lists, strict=True))
