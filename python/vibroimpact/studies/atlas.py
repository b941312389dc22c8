"""An atlas: all zones of stable motions in a window, for all patterns up to a size."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import SingularError
from ..results import door, namelist
from ..results.namelist import SYMMETRIC
from ..results.parameters import Span
from ..systems.oscillator import Oscillator, Pattern
from ..systems.structure import Load, Structure, counted, without_none
from ..systems.verbs import every_system, physical_arguments
from .zone import NAMES, OnPlane, Zone, keys_of_plane, window

if TYPE_CHECKING:
    from ..systems.units import Units, Value

__all__ = ["Atlas", "Survey", "SurveyMotion", "SurveyPoint", "WithoutImpacts", "atlas"]

_Array = NDArray[np.float64]
#: The possible outcomes of a point of a survey, in the order of their codes, which start at 1.
OUTCOMES = (
    "periodic", "beyond the limits", "without impacts", "chaotic", "not settled", "not confirmed",
    "event limit reached",
)  # fmt: skip
#: The outcomes for a structure.
OUTCOMES_OF_STRUCTURE = (*OUTCOMES, "with rest")
PERIODIC, BEYOND, WITH_REST = 1, 2, 8
#: Keys of an atlas that its zones share.
SHARED = ("r_min", "r_max", "clearance_min", "clearance_max", "lines", "guesses", "max_points")
PART = "a part of an atlas, which also used seeds from its survey; this case searches for the pattern alone"

PART_OF_STRUCTURE = "a part of an atlas; only the case of the atlas finds it, by its survey"


class SurveyPoint(NamedTuple):
    """A point of the survey of an atlas with the pattern of the periodic motion on which a simulation settled.

    Attributes
    ----------
    r, clearance : float
        Frequency ratio and d K/F0.
    pattern : Pattern
        Sides of the impacts and load cycles of the motion.
    """

    r: float
    clearance: float
    pattern: Pattern


class SurveyMotion(NamedTuple):
    """A survey point of an atlas of a structure, with the impacts and load cycles of the motion found there.

    Attributes
    ----------
    x, y : float
        Values of the two parameters.
    impacts, cycles : int
        Impacts and load cycles in a period of the motion.
    """

    x: float
    y: float
    impacts: int
    cycles: int


@dataclass(frozen=True, eq=False, repr=False)
class Survey:
    """The outcome of each point at which a simulation was made until it settled.

    Attributes
    ----------
    x, y : ndarray (N,)
        The points: r and d K/F0 of an oscillator, which are also attributes `r` and `clearance`.
    outcome : ndarray of int (N,)
        Outcome of each point:

        1. periodic: a stable periodic motion within the limits of impacts and cycles, which Newton's method
           confirms;
        2. beyond the limits: a stable periodic motion with more impacts, or more load cycles (up to 16), which
           Newton's method confirms too;
        3. without impacts: the free mass is at rest, and M, whose free vibration still decays, can no longer
           reach it;
        4. chaotic: the largest Lyapunov exponent is positive by more than four standard errors and by more than
           0.002 per load cycle; a chaotic transient that lasts longer than the simulation counts as chaos;
        5. not settled: none of these after four times the `settling` of the atlas: quasi-periodic motions, very
           slow transients, a free mass that drifts for a long time between two impacts;
        6. not confirmed: the simulation repeats itself, but Newton's method confirms no stable motion;
        7. event limit reached: the simulation has too many events to be completed;
        8. with rest: for a structure, a stable periodic motion with rest, whose zone is not traced.
    """

    x: _Array = field(default_factory=lambda: np.empty(0))
    y: _Array = field(default_factory=lambda: np.empty(0))
    outcome: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))

    @property
    def r(self) -> _Array:
        return self.x

    @property
    def clearance(self) -> _Array:
        return self.y

    @property
    def counts(self) -> dict[str, int]:
        """Number of points of each outcome; their sum is the number of points."""
        names = OUTCOMES_OF_STRUCTURE if (self.outcome == WITH_REST).any() else OUTCOMES
        return {
            name: int(np.count_nonzero(self.outcome == code))
            for code, name in enumerate(names, start=1)
        }

    def __len__(self) -> int:
        return len(self.outcome)

    def __str__(self) -> str:
        each = ", ".join(f"{number} {name}" for name, number in self.counts.items() if number)
        points = f"survey of {len(self)} point{'' if len(self) == 1 else 's'}"
        return f"{points}: {each}" if each else points

    def __repr__(self) -> str:
        return f"<{str(self).capitalize()}>"


@dataclass(frozen=True)
class WithoutImpacts:
    """The part of a window where the free mass can stay at rest in the slot without contact: d K/F0 > 2A.

    Without impacts M moves as A sin(rt - lag), A = 1/sqrt((1 - r^2)^2 + (2 xi r)^2), and a free mass at rest stays
    where it is, at z = c. It is never touched if |c - x| < D/2 at all times, that is, if |c| + A < D/2. Such c
    exist if D > 2A, and then any |c| < D/2 - A is possible: the free mass is in neutral equilibrium. Two
    multipliers of this motion are those of M alone, exp((-xi +- i sqrt(1 - xi^2)) 2 pi/r); the other two are 1: a
    displaced free mass stays displaced, and with the slightest velocity it drifts until it meets a wall. The
    motion is therefore not asymptotically stable, no `Zone` contains it, and simulations reach it only if the free
    mass comes to rest.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : (float, float)
        The window.
    """

    osc: Oscillator
    r: tuple[float, float]
    clearance: tuple[float, float]

    def least_clearance(self, r: ArrayLike) -> _Array:
        """2A, the clearance above which the motion exists, by the closed form."""
        r = checks.real_array(r, "r", "real numbers")
        with np.errstate(divide="ignore"):
            return np.asarray(2 / np.hypot((1 - r) * (1 + r), 2 * self.osc.xi * r))

    def contains(self, r: ArrayLike, clearance: ArrayLike) -> NDArray[np.bool_]:
        """Whether the motion without impacts exists at points; False outside the window."""
        r, clearance = checks.one_shape(r=r, clearance=clearance)
        inside = (self.r[0] <= r) & (r <= self.r[1])
        inside &= (self.clearance[0] <= clearance) & (clearance <= self.clearance[1])
        return np.asarray(inside & (clearance > self.least_clearance(r)))

    def boundary(self, points: int = 401) -> tuple[_Array, _Array]:
        """The curve (r, 2A) over the window's r; parts of it may lie below or above the window."""
        r = np.linspace(*self.r, checks.integer(points, "points", 2, 10**6))
        return r, self.least_clearance(r)

    def __repr__(self) -> str:
        return "<WithoutImpacts: where d K/F0 > 2A>"


class Atlas(OnPlane, study="atlas"):
    """All zones found in a window.

    Attributes
    ----------
    osc : Oscillator
    r, clearance : (float, float)
        The window, of an oscillator.
    structure, load : Structure, Load
        For a structure.
    x, y : (float, float)
        The window: lowest and highest value of both parameters.
    x_parameter, y_parameter : str
        Their names; r and clearance for an oscillator.
    zones : list of Zone
        For a structure: one zone for each motion of the survey that lies in no other zone of its order of impacts.
        For an oscillator: one zone for each pattern that has one, in the order of the search (even if its boundary
        could not be closed); motions that are their own mirror image have a separate zone. With R1 = R2 a pattern
        also represents its mirror image, whose zone is the same.
    attractors : list of SurveyPoint, or of SurveyMotion for a structure
        The motions on which the survey by simulation settled, within the limits of impacts and cycles.
    unexplained : list of SurveyPoint
        Attractors that lie in no zone of their pattern: gaps of the atlas, or motions that only look periodic.
    beyond : list of SurveyPoint
        Stable periodic motions beyond the limits that the survey found.
    survey : Survey
        Every point of the survey and its outcome.
    case : str
        The case as a namelist (see `to_namelist`).
    """

    __slots__ = ("__dict__",)

    def require(self) -> None:
        """Raise a SingularError if nothing was simulated."""
        if "points" not in self._result.tables:
            raise SingularError(self._result.notes[0][1])

    @cached_property
    def zones(self) -> list[Zone]:
        if self.of_structure:
            counts = (self._values("motion", "gaps") >= 0).sum(axis=-1).tolist()
            parts = (
                self._result.part("families", j, "zone", self.case, PART_OF_STRUCTURE).narrowed(
                    "impact", n
                )
                for j, n in enumerate(counts)
            )
            return [one for one in map(Zone, parts) if one.loops or not one.closed]
        families = self._result.tables["families"].columns
        sides, cycles, closed, symmetric = (
            families[name].decoded().tolist() for name in ("sides", "cycles", "closed", "symmetric")
        )
        keys = self.keys
        shared = {name: keys[name] for name in SHARED}
        found = []
        for j, symbols in enumerate(sides):
            rest = "*" in symbols
            case = namelist.case(self.osc, zone={
                "sides": symbols, "cycles": cycles[j],
                "symmetric": SYMMETRIC[None if rest else bool(symmetric[j])], **shared,
            })  # fmt: skip
            one = Zone(self._result.part("families", j, "zone", case, PART))
            if one.loops or not closed[j]:
                found.append(one)
        return found

    @cached_property
    def survey(self) -> Survey:
        columns = self._result.tables["points"].columns
        names = ("x", "y", "outcome") if self.of_structure else ("r", "clearance", "outcome")
        return Survey(*(columns[name].values for name in names))

    @property
    def attractors(self) -> list[Any]:
        """The motions on which the survey settled, within the limits of impacts and cycles."""
        return self._attractors(self.survey.outcome == PERIODIC)

    @property
    def unexplained(self) -> list[Any]:
        """The attractors of the survey that lie in no zone of their pattern."""
        explained = self._result.tables["points"].columns["explained"].decoded()
        return self._attractors((self.survey.outcome == PERIODIC) & ~explained)

    @property
    def beyond(self) -> list[Any]:
        """Stable periodic motions that the survey found beyond the limits of impacts and cycles."""
        return self._attractors(self.survey.outcome == BEYOND)

    def _attractors(self, chosen: NDArray[np.bool_]) -> list[Any]:
        """The motions of some points of the survey."""
        columns = self._result.tables["points"].columns
        if self.of_structure:
            found = (columns[name].decoded()[chosen].tolist() for name in SurveyMotion._fields)
            return [SurveyMotion(*each) for each in zip(*found, strict=True)]
        values = (
            columns[name].decoded()[chosen].tolist()
            for name in ("r", "clearance", "sides", "cycles")
        )
        return [
            SurveyPoint(r, clearance, Pattern(sides, cycles))
            for r, clearance, sides, cycles in zip(*values, strict=True)
        ]

    @property
    def counts(self) -> dict[str, int]:
        """Number of points of the survey of each outcome (see `Survey`)."""
        return self.survey.counts

    @property
    def without_impacts(self) -> WithoutImpacts:
        """The region where the motion without impacts exists, with the free mass at rest (oscillators only)."""
        if self.of_structure:
            raise AttributeError(self._lack("without_impacts", "counts"))
        return WithoutImpacts(self.osc, self.r, self.clearance)

    def at(self, x: float, y: float) -> list[Zone]:
        """The zones that contain a point, that is, the zones of the stable motions with impacts there.

        `without_impacts.contains` says whether the motion without impacts also exists there.

        If an open boundary leaves it undecided whether a zone contains the point, `Zone.contains` warns, and the
        zone is not in the list; attractors that the survey found there are in `unexplained`.

        Parameters
        ----------
        x, y : float
            Values of the two parameters; for an oscillator r and d K/F0.

        Returns
        -------
        list of Zone
            In the order of `zones`; empty if there are none.
        """
        x = checks.to_float(x, self.x_parameter, "a number")
        y = checks.to_float(y, self.y_parameter, "a number")
        return [zone for zone in self.zones if bool(zone.contains(x, y))]

    def explains(self, attractor: SurveyPoint) -> bool:
        """For an oscillator: whether an attractor of the survey lies in a zone of its pattern.

        Parameters
        ----------
        attractor : SurveyPoint
            An item of `attractors`.

        Returns
        -------
        bool
            False for the items of `unexplained`.
        """
        if self.of_structure:
            raise AttributeError(self._lack("explains", "unexplained"))
        checks.instance(attractor, "attractor", SurveyPoint)
        names, cycles = names_of(attractor.pattern, self.osc), attractor.pattern.cycles
        return any(
            zone.pattern.sides in names
            and zone.pattern.cycles == cycles
            and zone._turns(attractor.r, attractor.clearance) > 0
            for zone in self.zones
        )

    @classmethod
    def load(cls, path: str | Path) -> Atlas:
        """Read an atlas that `save` wrote; see `vibroimpact.load`.

        Parameters
        ----------
        path : str or Path
            The file.

        Returns
        -------
        Atlas
            The atlas, with the same bits.
        """
        return cls._load(path)

    @property
    def _log_clearance(self) -> bool:  # type: ignore[override]
        return not self.of_structure

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether it has zones."""
        return bool(self.zones)

    def _draw_small(self, ax: Any) -> None:
        self.plot(ax=ax)
        legend = ax.get_legend()
        if legend:
            legend.remove()  # a legend would not fit into such a small picture

    def plot(self, ax: Any = None, inverse: bool = False, units: Units | str | None = None) -> Any:
        """Draw all zones, each with its name, and the points of the survey that no zone explains.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw on; by default those of a new figure.
        inverse : bool
            For an oscillator: draw F0/(d K) on the vertical axis instead of d K/F0.
        units : Units or str, optional
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The Axes with the picture.
        """
        return self._draw(ax, inverse, units=units)

    def __repr__(self) -> str:
        left = counted(len(self.unexplained), "attractor")
        gaps = f", {left} unexplained" if self.unexplained else ""
        seen = f"; {self.survey}" if len(self.survey) else ""
        zones, surveyed = (
            counted(len(self.zones), "zone"),
            counted(len(self.attractors), "attractor"),
        )
        return f"<Atlas of {zones}, {surveyed} surveyed{gaps}{seen}>"


def turns(pattern: Pattern) -> list[str]:
    """All rotations of a sequence of sides."""
    symbols = pattern.symbols
    return ["".join(symbols[j:] + symbols[:j]) for j in range(len(symbols))]


def names_of(pattern: Pattern, osc: Oscillator) -> set[str]:
    """All sequences of sides of a pattern: its rotations and, with R1 = R2, their mirror images."""
    names = set(turns(pattern))
    if osc.restitution[0] == osc.restitution[1]:
        names |= {name.translate(str.maketrans("RL", "LR")) for name in names}
    return names


def atlas_structure(
    structure: Structure,
    load: Load | None,
    x: Span,
    y: Span,
    max_impacts: int = 4,
    max_cycles: int = 1,
    survey: int = 100,
    settling: int = 400,
    lines: int = 17,
    max_points: int = 20_000,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
    x_at: float | None = None,
    y_at: float | None = None,
) -> Atlas:
    """As `atlas`, for a structure."""
    checks.instance(structure, "structure", Structure)
    load = without_none(load)
    if load is not None:
        checks.instance(load, "load", Load)
    given = load or Load(constant=np.zeros(structure.coordinates))
    keys, names = keys_of_plane(structure, given, (x, y), (x_at, y_at))
    keys |= {
        "max_impacts": max_impacts, "max_cycles": max_cycles, "survey": survey, "settling": settling,
        "lines": lines, "max_points": max_points, "max_events": max_events,
    }  # fmt: skip
    found = door.run_structure(
        Atlas, structure, load, keys, threads, progress, names, needs_frequency=False, stops=True
    )
    found.require()
    return found


@overload
def atlas(
    osc: Oscillator, r: ArrayLike | tuple[Value, Value], clearance: ArrayLike | tuple[Value, Value],
    max_impacts: int = 5, max_cycles: int = 1, survey: int = 400, settling: int = 400, lines: int = 17,
    guesses: int = 24, max_points: int = 20_000, max_events: int = 10_000_000, threads: int | None = None,
    progress: door.Progress | None = None,
) -> Atlas: ...  # fmt: skip
@overload
def atlas(
    structure: Structure, load: Load | None, x: Span, y: Span,
    max_impacts: int = 4, max_cycles: int = 1, survey: int = 100, settling: int = 400, lines: int = 17,
    max_points: int = 20_000, max_events: int = 10_000_000, threads: int | None = None,
    progress: door.Progress | None = None, x_at: float | None = None, y_at: float | None = None,
) -> Atlas: ...  # fmt: skip


@physical_arguments
@every_system(atlas_structure, no_point="give its osc, and ranges of r and clearance")
def atlas(
    osc: Oscillator,
    r: tuple[float, float],
    clearance: tuple[float, float],
    max_impacts: int = 5,
    max_cycles: int = 1,
    survey: int = 400,
    settling: int = 400,
    lines: int = 17,
    guesses: int = 24,
    max_points: int = 20_000,
    max_events: int = 10_000_000,
    threads: int | None = None,
    progress: door.Progress | None = None,
) -> Atlas:
    """All zones of stable motions in a window, for all patterns up to a given number of impacts and cycles.

    For an oscillator: patterns without rest are enumerated (all sequences of sides up to rotation, and up to the
    mirror image when R1 = R2). Patterns with rest come from a survey by simulation over the window and from
    simulations at the nodes of the zones' lattice. The `zone` of each pattern is traced, with the attractors of
    the survey as seeds. If attractors then lie in no zone of their pattern, that pattern is searched once more on
    a finer lattice; attractors that still lie in no zone are listed as `unexplained`. The points of the survey are
    counted by their outcomes (`Atlas.counts`, see `Survey`).

    For a structure: the survey simulates from a random state at points spread over the plane of any two
    parameters. For each motion without rest and within the limits, its own `zone` is traced unless the motion lies
    in a zone already found for its order of impacts or the mirror image of this order. Motions that no simulation
    reaches have no zone; motions with rest are only counted.

    Parameters
    ----------
    osc : Oscillator
        The oscillator, without its r and clearance.
    structure, load : Structure, Load
        In place of `osc`; `Load.none()`, None or a constant load for self-excited motions.
    x, y : (parameter, (float, float))
        For a structure, in place of r and clearance: each a parameter, as in `branch`, with its lowest and highest
        value, or with an array, of which only the ends are used; the value of the structure lies between them.
    r, clearance : (float, float)
        The window, as in `zone`: ranges (lo, hi) of the frequency ratio and of d K/F0, or arrays, of which only
        the ends are used.
    max_impacts, max_cycles : int
        Limits of the patterns, 2 to 8 symbols and 1 to 4 cycles; an accumulation counts as one symbol. For a
        structure, 1 to 24 impacts and contacts with stops (4 by default) and 1 to 16 cycles.
    survey : int
        Number of points of the window at which simulations run until they settle; for a structure 100 by default.
    settling : int
        Load cycles, or for self-excited motions natural periods, simulated at each point before its attractor is
        examined.
    lines, guesses, max_points : int
        As in `zone`.
    max_events : int
        Events after which a simulation of the survey is abandoned, with the outcome "event limit reached".
    threads : int, optional
        Default: one for each processor. The result does not depend on it.
    progress : callable, optional
        Called with the fraction done and the current task; by default a bar on a terminal or in a
        notebook.
    x_at, y_at : float, optional
        For a structure: the value of the parameter at the given system, if the parameter is a function.

    Returns
    -------
    Atlas
        All zones that were found, and the survey.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed; nothing was computed.
    SingularError
        If a structure without a periodic load has no natural period, in which `settling` is counted.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> small = vi.atlas(osc, (1.0, 1.1), (20, 60), max_impacts=3, survey=20)
    >>> sorted({zone.pattern.sides for zone in small.zones})
    ['RL', 'RRL']
    >>> sum(small.counts.values())
    20
    >>> small.without_impacts.contains(1.04, [20.0, 30.0]).tolist()
    [False, True]

    A mass that hits one wall, over the frequency and the amplitude of the load:

    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> vi.atlas(wall, vi.Load(1.0, cosine=[1]), ("frequency", (0.8, 1.2)), ("load", (0.5, 2)), survey=20)
    <Atlas of 2 zones, 20 attractors surveyed; survey of 20 points: 20 periodic>
    """
    keys = {
        **window(r, clearance), "max_impacts": max_impacts, "max_cycles": max_cycles, "survey": survey,
        "settling": settling, "lines": lines, "guesses": guesses, "max_points": max_points,
        "max_events": max_events,
    }  # fmt: skip
    return door.run(Atlas, osc, keys, threads=threads, progress=progress, parameters=NAMES)
