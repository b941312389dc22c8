"""Basins of attraction: to which attractor initial states go, and how safely."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core, checks
from ..errors import ParameterError, StudyInterrupted
from ..interchange import namelist
from ..interchange.dataset import xarray
from ..interchange.result import Result
from ..model import Oscillator
from .catalogue import BasinAttractor, find_attractors
from .settling import thread_count
from .spacing import spaced

__all__ = ["Axis", "BasinAttractor", "Basins", "basins"]

_Array = NDArray[np.float64]
#: Coordinates of a state, and the row of each in what the core takes; y = z - x.
COORDINATES = ("t", "x", "x_dot", "y", "z_dot")
#: The label of a state that was not looked at before the study was cut short.
NOT_REACHED = -2


class Axis(NamedTuple):
    """One direction of a plane of initial states: n of them from low to high."""

    name: str
    low: float
    high: float
    n: int

    @property
    def values(self) -> _Array:
        """The places."""
        return spaced(self.low, self.high, self.n)


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Basins(Result):
    """To which attractor each of many initial states goes.

    Attributes
    ----------
    osc : Oscillator
    r, clearance, load : float
    attractors : list of BasinAttractor
        The label of an attractor is its place in this list.
    labels : ndarray (n, m) of int, or (M,)
        For each state of the plane (first axis, second axis) or of the list; -1 not decided, -2 not reached
        before it was cut short.
    axes : (Axis, Axis) or None
    states : ndarray (5, ...)
        t, x, x_dot, z, z_dot of each.
    impacts : int
        Events simulated to decide.
    case : str
        What was asked for as a namelist; empty for a list of states (see `to_namelist`).
    complete : bool
        False if Ctrl-C cut it short.
    """

    osc: Oscillator
    r: float
    clearance: float
    load: float
    attractors: list[BasinAttractor]
    labels: NDArray[np.int32]
    axes: tuple[Axis, Axis] | None
    states: _Array
    impacts: int
    case: str = ""
    complete: bool = True

    @property
    def reached(self) -> int:
        """Number of states that were looked at: all, unless it was cut short."""
        return int((self.labels != NOT_REACHED).sum())

    @property
    def cut(self) -> str:
        """How far it came if it was cut short; else empty."""
        if self.complete:
            return ""
        left = int((self.labels == -1).sum())
        waiting = f", {left} of them not decided yet" if left else ""
        return f"{self.reached} of {self.labels.size} states were reached{waiting}"

    @property
    def fractions(self) -> _Array:
        """Share of the states that go to each attractor; of those that were reached, if it was cut short."""
        return (
            np.bincount(self.labels[self.labels >= 0], minlength=len(self.attractors))
            / self.reached
        )

    @property
    def standard_error(self) -> _Array:
        """Of the fractions, as of as many independent states: an upper bound for those of a lattice."""
        share = self.fractions
        return np.sqrt(share * (1 - share) / self.reached)

    @property
    def uncertain(self) -> tuple[_Array, _Array]:
        """Share of pairs of states with different ends, against their distance in cells of the plane.

        Pairs lie along the first or the second axis.
        """
        self._need_plane("uncertain")
        pairs, n, _ = _core.uncertain_pairs(self.labels.T)
        return pairs[0, :n], pairs[1, :n]

    @property
    def uncertainty_exponent(self) -> float:
        """a in: a share ~ eps**a of states is uncertain if the state is known to eps.

        1 for smooth boundaries; near 0 for fractal ones, where knowing the state better hardly helps. The
        boundary in the plane has dimension 2 - a. NaN if there is no boundary.
        """
        self._need_plane("uncertainty_exponent")
        return _core.uncertain_pairs(self.labels.T)[2]

    def integrity(self, attractor: int) -> tuple[float, tuple[float, float]]:
        """Radius and centre of the largest disc of the plane inside a basin, the axes being equal measures.

        The radius is to the nearest state with another end, or to the edge of the plane: at least what is
        told but for one cell. For a damper: how far a state may be off and still come to that motion.
        """
        first, second = self._need_plane("integrity")
        checks.integer(attractor, "attractor", 0, len(self.attractors) - 1)
        cells = [(axis.high - axis.low) / (axis.n - 1) for axis in (second, first)]
        radius, (j, i) = _core.largest_disc(self.labels.T, attractor, cells)
        return radius, (float(first.values[i - 1]), float(second.values[j - 1]))

    def _need_plane(self, name: str) -> tuple[Axis, Axis]:
        """The axes, or an error; what was not reached would count as going elsewhere."""
        if self.axes is None:
            raise ParameterError(
                f"plane = None: must be one for {name}; these states are random or a list"
            )
        if not self.complete:
            raise ParameterError(
                f"complete = False: must be the whole plane for {name}; cut short, {self.cut}"
            )
        return self.axes

    def to_xarray(self) -> Any:
        """Labels over the plane or the list, fractions over the attractors (extra `data`)."""
        names = [item.name for item in self.attractors]
        data: dict[str, Any] = {
            "fraction": ("attractor", self.fractions),
            "standard_error": ("attractor", self.standard_error),
            "kind": ("attractor", [item.kind for item in self.attractors]),
        }
        coordinates: dict[str, Any] = {"attractor": names}
        if self.axes is None:
            data["label"] = ("state", self.labels)
            data["states"] = (("coordinate", "state"), self.states)
            coordinates["coordinate"] = ["t", "x", "x_dot", "z", "z_dot"]
        else:
            data["label"] = (tuple(axis.name for axis in self.axes), self.labels)
            coordinates |= {axis.name: axis.values for axis in self.axes}
        attributes: dict[str, Any] = {
            "r": self.r, "clearance": self.clearance, "load": self.load, "complete": int(self.complete),
        }  # fmt: skip
        return xarray().Dataset(data, coordinates, attributes)

    def plot(self, ax: Any = None) -> Any:
        """Draw the plane, a colour an attractor, and the impacts of the attractors (extra `plot`)."""
        from ..plot.attractor import draw_basins

        return draw_basins(self, ax)

    def __repr__(self) -> str:
        shares = zip(self.attractors, self.fractions, strict=True)
        parts = [f"{item.name} {share:.1%}" for item, share in shares]
        left = int((self.labels == -1).sum())
        parts += [f"{left} not decided"] if left and self.complete else []
        cut = "" if self.complete else f"; cut short, {self.cut}"
        return f"<Basins of {self.labels.size} states: {', '.join(parts)}{cut}>"


def basins(
    osc: Oscillator,
    r: float,
    clearance: float,
    plane: tuple[Any, Any] | None = None,
    states: int | ArrayLike | None = None,
    fixed: Mapping[str, float] | None = None,
    load: float = 1.0,
    cycles: int = 1000,
    probes: int = 200,
    max_cycles: int = 16,
    seed: int = 0,
    threads: int | None = None,
    progress: Callable[[float, str], None] | None = None,
) -> Basins:
    """To which attractor each of many initial states goes.

    First a few of the states are simulated until they settle, and Newton's method makes the periodic motions
    exact. Around events of each the largest ball, in a norm in which the derivative over a period
    contracts, is found that the map itself contracts too, tried on 1024 states spread over it; half its
    radius is taken. A state is decided as soon as its trajectory has an event in such a neighbourhood. What
    is not decided after `cycles` load cycles is looked at again: it may be on a motion that was not known,
    which then counts as known, or on an attractor that is not periodic, which its largest Lyapunov exponent
    tells apart.

    Parameters
    ----------
    osc, r, clearance, load
        As in `simulate`.
    plane : ((name, low, high, n), (name, low, high, n)), optional
        Names are "x", "x_dot", "y" (that is z - x), "z_dot" and "t".
    states : int or array_like (5, M), optional
        Instead of a plane: this many random states, or t, x, x', z, z' of each. Random ones are at t = 0,
        uniform in a box: x, x' and z' from -s to s and y from wall to wall, where s is the amplitude of the
        motion without impacts, but at least half the clearance and at most three times the clearance.
    fixed : mapping, optional
        The coordinates that are no axes of the plane; 0 by default.
    cycles : int
        Load cycles in which a state should be decided.
    probes : int
        States simulated first.
    max_cycles : int
        Longest period that is looked for, in load cycles.
    seed : int
        Of random states, from 0 to 2**31 - 1. A state depends on the seed and its place alone: more states
        begin with those of fewer.
    threads : int, optional
        Default: one for each processor. The answer does not depend on it.
    progress : callable, optional
        Called a few times a second with the share done and what is being done.

    Returns
    -------
    Basins

    Raises
    ------
    StudyInterrupted
        After Ctrl-C, with what was finished as its attribute `result`:
        states that were not reached have the label -2, and the shares are those of the others.

    Examples
    --------
    The unequispaced motion of Table 1's point and its mirror image take most of this plane:

    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> result = vi.basins(osc, 0.94, 37.0, (("x", -30, 30, 20), ("x_dot", -30, 30, 20)))
    >>> result.attractors
    [<periodic attractor RL/1 (1)>, <periodic attractor RL/1 (2)>, ...]
    >>> bool(abs(result.fractions[0] - 0.43) < 0.1)
    True
    """
    checks.instance(osc, "osc", Oscillator)
    r = checks.frequency_ratio(r, osc.xi)
    clearance = checks.number(clearance, "clearance")
    load = checks.number(load, "load")
    cycles = checks.integer(cycles, "cycles", 1, 10**7)
    probes = checks.integer(probes, "probes", 1, 10**6)
    max_cycles = checks.integer(max_cycles, "max_cycles", 1, 100)
    seed = checks.integer(seed, "seed", 0, 2**31 - 1)
    workers = thread_count(threads)
    if (plane is None) == (states is None):
        raise ParameterError(
            f"plane = {plane!r}, states = {states!r}: must be one of them, the other left out"
        )
    axes = None if plane is None else _axes(plane)
    which: dict[str, Any] = {}
    if axes is not None:
        others = _others(fixed, axes)
        starts = _plane_states(axes, others)
        columns = zip(*axes, strict=True)
        which = (
            dict(zip(("axes", "low", "high", "values"), map(list, columns), strict=True)) | others
        )
    elif fixed is not None:
        raise ParameterError(f"fixed = {fixed!r}: must be left out: it goes with plane")
    elif isinstance(states, (int, np.integer)):
        number = checks.integer(states, "states", 1, checks.MOST_NUMBERS)
        starts = _core.random_states(number, seed, osc.xi, r, load, clearance)
        which = {"states": number, "seed": seed}
    else:
        starts = checks.real_array(states, "states", "a number or an array (5, M)")  # type: ignore[arg-type]
    _check_states(starts, clearance, on_plane=axes is not None)
    attractors, labels, impacts, complete = find_attractors(
        osc, r, clearance, load, starts, cycles, probes, max_cycles, workers, progress
    )
    shape = labels.shape if axes is None else (axes[0].n, axes[1].n)
    limits = {"cycles": cycles, "probes": probes, "max_cycles": max_cycles, "load": load}
    asked = (
        namelist.case(osc, r, basins={"clearance": clearance, **which, **limits}) if which else ""
    )
    result = Basins(
        osc, r, clearance, load, attractors, labels.reshape(shape), axes,
        starts.reshape(5, *shape), impacts, asked,
        complete or bool((labels >= 0).all()),
    )  # fmt: skip
    if not complete:
        raise StudyInterrupted(result)
    return result


def _axes(plane: Any) -> tuple[Axis, Axis]:
    """The two axes of a plane."""
    wanted = "two of (name, low, high, n), names x, x_dot, y, z_dot or t"
    try:
        first, second = (Axis(*item) for item in plane)
    except (TypeError, ValueError):
        raise ParameterError(f"plane = {plane!r}: must be {wanted}") from None
    axes = []
    for axis in (first, second):
        checks.choice(axis.name, "plane: name", COORDINATES)
        low, high = (checks.to_float(item, "plane", wanted) for item in axis[1:3])
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise ParameterError(
                f"plane: {axis.name} = {low!r} to {high!r}: must be finite, low below high"
            )
        axes.append(Axis(axis.name, low, high, checks.integer(axis.n, "plane: n", 2, 100_000)))
    if first.name == second.name:
        raise ParameterError(f"plane = {plane!r}: must name two coordinates")
    numbers = [axis.n for axis in axes]
    checks.together(math.prod(numbers), f"plane: n = {numbers}", "together at most {} states")
    return axes[0], axes[1]


def _others(fixed: Mapping[str, float] | None, axes: tuple[Axis, Axis]) -> dict[str, float]:
    """The coordinates that are no axes."""
    values = {name: 0.0 for name in COORDINATES if name not in [axis.name for axis in axes]}
    for name, value in (fixed or {}).items():
        if checks.choice(name, "fixed", COORDINATES) not in values:
            raise ParameterError(f"fixed[{name!r}] = {value!r}: must be left out: it is an axis")
        values[name] = checks.to_float(value, f"fixed[{name!r}]", "a finite number")
    return values


def _plane_states(axes: tuple[Axis, Axis], others: Mapping[str, float]) -> _Array:
    """The states (5, n m) of a plane."""
    grid = np.meshgrid(*(axis.values for axis in axes), indexing="ij")
    table = np.array([np.full(grid[0].size, others.get(name, 0.0)) for name in COORDINATES])
    for axis, column in zip(axes, grid, strict=True):
        table[COORDINATES.index(axis.name)] = column.ravel()
    table[3] += table[1]
    return table


def _check_states(starts: _Array, clearance: float, on_plane: bool) -> None:
    """States must be finite and between the walls."""
    if starts.ndim != 2 or starts.shape[0] != 5 or starts.shape[1] == 0:
        raise ParameterError(
            f"states of shape {starts.shape}: must be (5, M): t, x, x_dot, z, z_dot"
        )
    finite = np.isfinite(starts).all(axis=0)
    if not finite.all():
        j = int(np.argmin(finite))
        raise ParameterError(f"states[:, {j}] = {starts[:, j].tolist()!r}: must be finite numbers")
    y, half = starts[3] - starts[1], 0.5 * clearance
    outside = np.abs(y) > half * (1 + 1e-9)
    if outside.any():
        j = int(np.argmax(outside))
        if on_plane:
            raise ParameterError(
                f"plane: y = {y.min():.6g} to {y.max():.6g}: must be within half the clearance, "
                f"-{half:.6g} to {half:.6g}"
            )
        raise ParameterError(
            f"states[:, {j}] = {starts[:, j].tolist()!r}: must have z - x within half the clearance"
        )
