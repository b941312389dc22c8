"""Branches of motions of structures: how a motion changes along a parameter, with its bifurcations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeVar, overload

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..motions.structure_motion import StructureMotion, motion_from_phases
from ..motions.structure_trajectory import structure_of
from ..results import door, namelist
from ..results.noun import Noun, column
from ..results.parameters import Parameter, Path, keys_of_parameter
from ..results.structure_groups import check_gap_numbers
from ..systems.structure import Load, Structure

__all__ = ["StructureBranch", "StructureSpecialPoint", "branch_structure"]

_Array = NDArray[np.float64]
_Found = TypeVar("_Found", bound="Followed")


@dataclass(frozen=True, eq=False, repr=False)
class StructureSpecialPoint:
    """A bifurcation, or an end, of a branch of a structure.

    Attributes
    ----------
    type : str
        fold, pitchfork, branch_point (a pitchfork or transcritical point where impacts at one instant part), flip,
        neimark_sacker, grazing, zero_approach, simultaneous (impacts on two gaps at one instant, beyond which
        their order is another), or bound (of the parameter).
    index : int
        Its place among the points of the branch.
    value : float
        The parameter there.
    detail : str
        Which flight touches which gap, which impact, which bound.
    parameter : str
    """

    type: str
    index: int
    value: float
    detail: str
    parameter: str

    def __repr__(self) -> str:
        return f"<{self.type} at {self.parameter} = {self.value:.10g}>"


class Followed(Noun, part=True):
    """What branches and zones of structures have in common: the motion from which they start."""

    __slots__ = ("__dict__",)
    #: The table of that motion.
    _of_start: ClassVar[str]

    def _one(self, name: str, table: str = "") -> Any:
        """A value that describes the whole result."""
        return self._result.column(table or self._of_start, name).decoded()[0]

    @property
    def gaps(self) -> NDArray[np.int32]:
        return np.asarray(self._one("gaps")).astype(np.int32)

    @property
    def cycles(self) -> int:
        return int(self._one("cycles"))

    @cached_property
    def _start(self) -> tuple[Structure, Load]:
        structure, load = structure_of(self._result, float(self._one("frequency")), True)
        assert load is not None
        return structure, load

    def _check_read(self) -> None:
        if not self._result.empty:
            check_gap_numbers(self._result, self.structure)
            checks.integer(self.cycles, f"{self._of_start}.cycles", 1, 10_000)

    @property
    def structure(self) -> Structure:
        return self._start[0]

    @property
    def load(self) -> Load:
        return self._start[1]


class StructureBranch(Followed, study="branch_structure"):
    """A family of exact motions of a structure along one parameter, as columns; points on the last axis.

    An index gives the `StructureMotion` of a point. The branch is in order along its curve: the parameter turns
    back at folds.

    Attributes
    ----------
    parameter : str
        Its name; "function" for a function.
    structure : Structure
    load : Load
        At the start.
    gaps : ndarray (N,)
        The gap of each impact, from 0.
    cycles : int
        Load cycles in a period.
    values : ndarray (M,)
        The parameter.
    phases, speeds, impulses : ndarray (N, M)
        Load phases of the impacts (rad), approach speeds, impulses.
    q_min, q_max : ndarray (n, M)
        Least and greatest value of each coordinate over the period.
    multipliers : ndarray (2n, M) of complex
        NaN at a "zero_approach": the period has no derivative there.
    residual : ndarray (M,)
    consistent, admissible, stable : ndarray (M,) of int
        1, 0, or -1 where not known.
    special_points : list of StructureSpecialPoint
        In the order of the branch.
    ends : (str, str)
        Why the branch ends, at its first and last point.
    case : str
        What was asked for as a namelist.
    """

    __slots__ = ()
    _of_start = "branch"
    values = column("points", "value")
    phases = column("points", first=True)
    speeds = column("points", first=True)
    impulses = column("points", first=True)
    q_min = column("points", first=True)
    q_max = column("points", first=True)
    multipliers = column("points", first=True)
    residual = column("points")
    consistent = column("points")
    admissible = column("points")
    stable = column("points")

    @property
    def parameter(self) -> str:
        return str(self.keys["parameter"])

    @property
    def ends(self) -> tuple[str, str]:
        return str(self._one("first_end")), str(self._one("last_end"))

    @cached_property
    def special_points(self) -> list[StructureSpecialPoint]:
        types, details = (
            self._result.column("points", name).decoded() for name in ("special", "detail")
        )
        return [
            StructureSpecialPoint(
                str(types[i]), i, float(self.values[i]), str(details[i]), self.parameter
            )
            for i in np.flatnonzero(types != "").tolist()
        ]

    def at(self, value: float) -> tuple[Structure, Load]:
        """The structure and the load at a value of the parameter."""
        value = checks.to_float(value, "value", "a finite number")
        bounds = [(self.keys["low"], self.keys["high"])]
        return Path(self._result, *self._start, bounds).at(value)

    def __len__(self) -> int:
        return int(self.values.size)

    @overload
    def __getitem__(self, index: int) -> StructureMotion: ...
    @overload
    def __getitem__(self, index: slice) -> list[StructureMotion]: ...
    def __getitem__(self, index: Any) -> Any:
        """The motion at a point; a list of them for a slice."""
        i = checks.place(index, len(self), "point")
        if isinstance(i, range):
            return [self[j] for j in i]
        structure, load = self.at(float(self.values[i]))
        # of two impacts at one instant rounding may put the second one first
        phases = np.maximum.accumulate(self.phases[:, i])
        # at a fold Newton's method has no unique step, while for known phases all else is linear
        return motion_from_phases(structure, load, self.gaps, phases, self.cycles)

    def require(self) -> None:
        """SingularError if there is no branch."""
        if self._result.empty:
            raise SingularError(self._result.notes[0][1])

    def parts(self) -> list[Any]:
        """The branch, unless it could not be followed."""
        return [] if self._result.empty else [self]

    @property
    def drawable(self) -> bool:  # type: ignore[override]
        """Whether there is a branch."""
        return not self._result.empty

    def plot(self, ax: Any = None, y: str = "q_max_0") -> Any:
        """Draw a column against the parameter: solid stable, dashed unstable, dotted inadmissible.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        y : str
            "q_max_0", ... or "q_min_0", ... (of a coordinate, from 0), "speed_1", ..., "impulse_1", ... or
            "phase_1", ... (of an impact, from 1), or "largest" for the largest modulus of the multipliers.

        Returns
        -------
        Axes
        """
        return self._draw(ax, y)

    def __repr__(self) -> str:
        if self._result.empty:
            return "<StructureBranch: none>"
        types = self._result.column("points", "special").decoded().tolist()
        kinds = dict.fromkeys(filter(None, types))
        found = ", ".join(f"{types.count(kind)} {kind}" for kind in kinds) or "no special points"
        return (
            f"<StructureBranch along {self.parameter}, {self.values.min():.6g} to "
            f"{self.values.max():.6g}: {len(self)} points, {found}>"
        )


def branch_structure(
    motion: StructureMotion,
    parameter: Parameter,
    bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05,
    max_points: int = 4000,
    progress: door.Progress | None = None,
    at: float | None = None,
) -> StructureBranch:
    """Follow a motion of a structure along a parameter in both directions, through folds, to the bounds.

    The tracer of `vibroimpact.branch`, whose unknowns are here the approach speeds and load phases of the impacts
    and the mean positions of modes of frequency 0. A motion that is its own image half a period later, by the
    mirror or another symmetry of the structure such as an exchange of equal units, is followed as such, with the
    map of half a period, so that the branch continues through a pitchfork, where two motions without it begin.
    `vibroimpact.branch` calls this for a `StructureMotion`.

    Parameters
    ----------
    motion : StructureMotion
        Consistent and without rest, with at most 24 impacts (23 if a mode has frequency 0). It need be neither
        stable nor admissible.
    parameter : str or function
        "frequency"; "load", "constant", "damping" or "stiffness", factors of the harmonics, of the constant
        forces and of the matrices; "opening" or "restitution" of all gaps, which are the same; "opening_J" or
        "restitution_J" of gap J; "mass_I_J", "damping_I_J" or "stiffness_I_J", an entry and its mirror image; all
        numbers count from 0. Or a smooth function that gives (structure, load) for a value of the parameter.
    bounds : (float, float)
        Lowest and highest value of the parameter; that of the motion lies between.
    longest_step : float
        Longest step along the curve, the range of the parameter being 1.
    max_points : int
        Most points each way.
    progress : callable, optional
        As in `vibroimpact.branch`.
    at : float, optional
        The value of the parameter at the motion, if it is a function.

    Returns
    -------
    StructureBranch

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    SingularError
        If the motion rests or repeats itself, if gaps close at one instant that would not for other values of
        the parameter or that damping couples, or if it cannot be followed.
    StudyInterrupted
        After Ctrl-C, with the points so far as its attribute `result`.

    Examples
    --------
    A mass on a spring that hits one wall, along the frequency of its load:

    >>> import vibroimpact as vi
    >>> wall = vi.Structure(mass=[1], damping=[0.1], stiffness=[1], gaps=[vi.Gap([1], 1, 0.8)])
    >>> motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    >>> path = vi.branch(motion, "frequency", bounds=(0.6, 3.0))
    >>> [(point.type, round(point.value, 6)) for point in path.special_points[1:4]]
    [('grazing', 0.704494), ('fold', 1.750143), ('zero_approach', 1.410674)]
    """
    checks.instance(motion, "motion", StructureMotion)
    keys = keys_of_parameter(
        motion.structure, motion.load, parameter, bounds, at, "parameter"
    ) | {"longest_step": longest_step, "max_points": max_points}  # fmt: skip
    names = {"low": "bounds[0]", "high": "bounds[1]"}
    return run_from(motion, StructureBranch, keys, names, progress)


def run_from(
    motion: StructureMotion, noun: type[_Found], keys: dict[str, Any], names: dict[str, str],
    progress: door.Progress | None,
) -> _Found:  # fmt: skip
    """The result of a study that starts from a motion; `names` are the caller's names of its keys."""
    study = noun.study
    group = study.removesuffix("_structure")
    try:
        found = door.run_text(noun, case_from(motion, group, keys), progress=progress)
    except ParameterError as error:
        message = str(error).removeprefix(f"&{group} ")
        raise ParameterError(door.translated(message, names)) from None
    found.require()
    return found


def case_from(motion: StructureMotion, group: str, keys: dict[str, Any]) -> str:
    """The case of a study that starts from a motion."""
    if len(motion.rests):
        raise ParameterError(f"motion = {motion!r}: must be one without rest")
    if motion.consistent is False:
        raise ParameterError(
            f"motion = {motion!r}: must be consistent, with a residual of rounding; "
            "exact(structure, load, motion) gives the exact motion near it"
        )
    study = f"{group}_structure"
    values = {name: door.plain(study, name, value, name) for name, value in keys.items()}
    start = {
        "kind": "exact", "cycles": motion.cycles, "gaps": motion.gaps.tolist(),
        "phases": motion.phases.tolist(),
    }  # fmt: skip
    groups = [*motion.structure._groups(), *motion.load._groups(), ("motion", start)]
    return namelist.text([*groups, (group, values)])
