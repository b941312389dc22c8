"""Branches: how an exact motion changes along a parameter, with its bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError, StudyInterrupted
from ..base.status import VERDICT
from ..motions.motion import Motion
from ..motions.periodic import frozen
from ..motions.structure_motion import StructureMotion
from ..results import door, namelist
from ..results.noun import Noun, column, key
from ..systems.oscillator import Pattern, plain_pattern
from ..systems.verbs import every_system
from .structure_branch import branch_structure
from .switching import KINDS, switched

__all__ = ["Branch", "Branches", "SpecialPoint", "branch"]

_Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class SpecialPoint:
    """A bifurcation, or an end, of a branch.

    Attributes
    ----------
    type : str
        fold, pitchfork, flip, neimark_sacker, grazing, zero_approach, or bound (of the parameter).
    index : int
        Its place among the points of the branch.
    r, clearance : float
    motion : Motion
    impact : int
        Of grazing: the flight after this impact (from 0) touches; of zero_approach: this impact.
    side : str
        Of grazing: the wall that is touched, "R" or "L"; otherwise "".
    parameter : str
        That of the branch.
    detail : str
        In words: which flight touches which wall, which impact, which bound.
    """

    study: ClassVar[str] = "branch"
    type: str
    index: int
    r: float
    clearance: float
    motion: Motion
    impact: int = -1
    side: str = ""
    parameter: str = "clearance"
    detail: str = ""

    def switch(self) -> list[Motion]:
        """Motions of the branches that begin here.

        At a pitchfork the unsymmetric pair, at a flip the motion of doubled period, at a grazing the motion
        whose pattern has the extra impact (of a symmetric motion also with that impact and its mirror image);
        each at a parameter value slightly off the point, on the side where the motion exists.

        Returns
        -------
        list of Motion
            Empty where no such motion was found near the point. Follow them with `branch`.
        """
        if self.type not in KINDS:
            return []
        return switched(self.motion, self.type, self.impact, self.side, self.parameter)

    def __repr__(self) -> str:
        place = f"r = {self.r:.10g}, d K/F0 = {self.clearance:.10g}"
        if self.parameter not in ("r", "clearance"):
            right, left = self.motion.osc.restitution
            values = {"xi": self.motion.osc.xi, "mu": self.motion.osc.mu, "R2": left}
            place += f", {self.parameter} = {values.get(self.parameter, right):.10g}"
        return f"<{self.type} at {place}>"


class Branch(Noun, study="branch", part=True):
    """A family of exact motions along one parameter, as columns; points on the last axis.

    An index gives the `Motion` of a point. The branch is in order along its curve: the parameter turns back
    at folds.

    Attributes
    ----------
    parameter : str
    pattern : Pattern
    symmetric : bool
        Whether the motions are their own mirror images half a period later (followed as such).
    r, clearance, xi, mu, R1, R2 : ndarray (M,)
    phases, X, Z, X_dot_before, X_dot_after, Z_dot_before, Z_dot_after : ndarray (N, M)
    A, tau, residual, x_min, x_max, attenuation : ndarray (M,)
    multipliers : ndarray (4, M) of complex
        NaN at a "zero_approach": [P] does not exist there.
    consistent, admissible, stable : ndarray (M,) of int
        1, 0, or -1 where not known.
    special_points : list of SpecialPoint
        In the order of the branch.
    ends : (str, str)
        Why the branch ends, at its first and last point: "bound of the parameter", "meets a motion that repeats
        itself", "two impacts at one instant" (on one wall: the special point there is the last motion that
        rounding leaves exact), "closed", "full", "stopped", or "cannot be followed".
    case : str
        What was asked for as a namelist.
    """

    __slots__ = ("__dict__",)
    r = column("points")
    clearance = column("points")
    xi = column("points")
    mu = column("points")
    R1 = column("points")
    R2 = column("points")
    phases = column("points", first=True)
    X = column("points", first=True)
    Z = column("points", first=True)
    X_dot_before = column("points", first=True)
    X_dot_after = column("points", first=True)
    Z_dot_before = column("points", first=True)
    Z_dot_after = column("points", first=True)
    A = column("points")
    tau = column("points")
    residual = column("points")
    x_min = column("points")
    x_max = column("points")
    attenuation = column("points")
    multipliers = column("points", first=True)
    consistent = column("points")
    admissible = column("points")
    stable = column("points")
    parameter: str = key("parameter")

    @property
    def pattern(self) -> Pattern:
        keys = self.keys
        return Pattern(keys.get("sides", "RL"), keys["cycles"])

    @property
    def symmetric(self) -> bool:
        return bool(self._one("symmetric"))

    @property
    def ends(self) -> tuple[str, str]:
        return str(self._one("first_end")), str(self._one("last_end"))

    def _one(self, name: str) -> Any:
        """A value that describes the whole branch."""
        return self._result.tables["branches"].columns[name].decoded()[0]

    @property
    def values(self) -> _Array:
        """The parameter along the branch."""
        name = "R1" if self.parameter == "restitution" else self.parameter
        values: _Array = getattr(self, name)
        return values

    @cached_property
    def special_points(self) -> list[SpecialPoint]:
        columns = self._result.tables["points"].columns
        types, details, impacts, sides = (
            columns[name].decoded()
            for name in ("special", "detail", "special_impact", "special_side")
        )
        found = []
        for i in np.flatnonzero(types != "").tolist():
            here = self[i]
            found.append(
                SpecialPoint(
                    str(types[i]), i, here.r, here.clearance, here, int(impacts[i]) - 1, str(sides[i]),
                    self.parameter, str(details[i]),
                )
            )  # fmt: skip
        return found

    def __len__(self) -> int:
        return int(self.r.size)

    @overload
    def __getitem__(self, index: int) -> Motion: ...
    @overload
    def __getitem__(self, index: slice) -> list[Motion]: ...
    def __getitem__(self, index: Any) -> Any:
        """The motion at a point; a list of them for a slice."""
        i = checks.place(index, len(self), "point")
        if isinstance(i, range):
            return [self[j] for j in i]
        right, left = float(self.R1[i]), float(self.R2[i])
        pattern = self.pattern

        def at(name: str) -> _Array:
            return frozen(getattr(self, name)[..., i].copy())

        def verdict(name: str) -> bool | None:
            return VERDICT[int(getattr(self, name)[i])]

        multipliers = self.multipliers[:, i].copy()
        multipliers.flags.writeable = False
        return Motion(
            replace(self.osc, xi=float(self.xi[i]), mu=float(self.mu[i]), restitution=(right, left)),
            float(self.r[i]), float(self.clearance[i]), pattern,
            frozen(np.where(pattern.signs > 0, right, left)), at("phases"), at("X"), at("Z"),
            at("X_dot_before"), at("X_dot_after"), at("Z_dot_before"), at("Z_dot_after"),
            float(self.A[i]), float(self.tau[i]), float(self.residual[i]), multipliers,
            verdict("consistent"), verdict("admissible"), verdict("stable"),
            float(self.x_min[i]), float(self.x_max[i]),
        )  # fmt: skip

    def plot(self, ax: Any = None, y: str = "attenuation") -> Any:
        """Draw a column against the parameter: solid stable, dashed unstable, dotted inadmissible.

        Parameters
        ----------
        ax : matplotlib Axes, optional
        y : str
            A column with one number a point, or "largest" for the largest modulus of the multipliers.

        Returns
        -------
        Axes
        """
        return self._draw(ax, y)

    def __repr__(self) -> str:
        types = self._result.tables["points"].columns["special"].decoded().tolist()
        kinds = dict.fromkeys(filter(None, types))
        found = ", ".join(f"{types.count(kind)} {kind}" for kind in kinds) or "no special points"
        return (
            f"<Branch {self.pattern.sides}/{self.pattern.cycles} along {self.parameter}, "
            f"{self.values.min():.6g} to {self.values.max():.6g}: {len(self)} points, {found}>"
        )


class Branches(Noun, study="branch"):
    """The branches of a case: one for each motion of its &motion that can be followed.

    An index gives a `Branch`; they all have the points of this result, not copied.
    """

    __slots__ = ()

    def __len__(self) -> int:
        table = self._result.tables.get("branches")
        return 0 if table is None else table.dims["branch"]

    @overload
    def __getitem__(self, index: int) -> Branch: ...
    @overload
    def __getitem__(self, index: slice) -> list[Branch]: ...
    def __getitem__(self, index: Any) -> Any:
        """A branch; a list of them for a slice."""
        i = checks.place(index, len(self), "branch")
        if isinstance(i, range):
            return [self[j] for j in i]
        if len(self) == 1:
            return Branch(self._result)
        return Branch(self._result.part("branches", i, "branch", self._case_of(i), ""))

    def __iter__(self) -> Iterator[Branch]:
        return (self[i] for i in range(len(self)))

    def parts(self) -> list[Branch]:
        """The branches."""
        return list(self)

    def _case_of(self, i: int) -> str:
        """The case of one branch: it starts from that motion alone."""
        first = {
            name: item.decoded()[i]
            for name, item in self._result.tables["branches"].columns.items()
        }
        keys = self.keys
        start = guess_of(
            Pattern(keys.get("sides", "RL"), keys["cycles"]), float(first["start_clearance"]),
            first["start_phases"], first["start_X"], float(first["start_tau"]),
        )  # fmt: skip
        own = ("parameter", "low", "high", "longest_step", "max_points")
        return namelist.case(
            self.osc, keys["r"], motion=start, branch={name: keys[name] for name in own}
        )

    def __repr__(self) -> str:
        return f"<Branches: {', '.join(map(repr, self)) or 'none'}>"


def guess_of(
    pattern: Pattern, clearance: float, phases: _Array, x: _Array, tau: float
) -> dict[str, Any]:
    """The group &motion that gives an exact motion from a guess of all its impacts."""
    return {
        "kind": "exact", "cycles": pattern.cycles, "sides": pattern.sides, "clearance": clearance,
        "phases": phases.tolist(), "positions": x.tolist(), "tau": tau,
    }  # fmt: skip


@every_system(branch_structure, StructureMotion)
def branch(
    motion: Motion,
    parameter: str = "clearance",
    bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05,
    max_points: int = 4000,
    progress: Callable[[float, str], None] | None = None,
) -> Branch:
    """Follow an exact motion along a parameter in both directions, through folds, to the bounds.

    Pseudo-arclength continuation with Newton's method and the analytic derivative of the equations. Special
    points are located by Newton's method on the equations with one further condition: det(P - I) = 0 at a fold,
    det(P + I) = 0 at a flip, the product of all 1 - lambda_i lambda_j at a Neimark-Sacker point, a touch of a
    wall, or an approach speed that is zero. A motion that is its own mirror image is followed as such, with
    the map of half a period, so that the branch continues through a pitchfork.

    Parameters
    ----------
    motion : Motion
        Without rest, with load 1.
    parameter : {"r", "clearance", "xi", "mu", "R1", "R2", "restitution"}
        "restitution" changes R1 = R2 together.
    bounds : (float, float)
        Lowest and highest value of the parameter; the motion's own value lies between.
    longest_step : float
        Longest step along the curve, the range of the parameter being 1.
    max_points : int
        Most points each way.
    progress : callable, optional
        Called a few times a second with the share done and what is being done: the share of the range that lies
        behind, or of the points if that is more.

    Returns
    -------
    Branch

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.
    StudyInterrupted
        After Ctrl-C, with the points so far as its attribute `result`.

    Examples
    --------
    The exact motion that corresponds to the third column of Table 1, along the clearance:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> path = vi.branch(motion, "clearance", bounds=(10, 60))
    >>> [(point.type, round(point.clearance, 6)) for point in path.special_points]
    [('bound', 10.0), ('grazing', 18.085596), ('flip', 34.964757), ('bound', 60.0)]
    """
    checks.instance(motion, "motion", Motion)
    plain_pattern(motion.pattern)
    if motion.load != 1.0:
        raise ParameterError(
            f"motion.load = {motion.load!r}: must be 1; scale the clearance instead"
        )
    right, left = motion.osc.restitution
    if not np.array_equal(motion.restitution, np.where(motion.pattern.signs > 0, right, left)):
        raise ParameterError(
            f"motion.restitution = {motion.restitution.tolist()!r}: must be that of the walls"
        )
    try:
        low, high = bounds  # type: ignore[misc]
    except (TypeError, ValueError):
        raise ParameterError(
            f"bounds = {bounds!r}: must be (lowest, highest) values of {parameter}"
        ) from None
    start = motion._keys()
    if start["kind"] == "equispaced" or motion.precision == "single":
        # in the form of &motion, where they come in pairs
        start = guess_of(motion.pattern, motion.clearance, motion.phases, motion.X, motion.tau)
    keys = {
        "parameter": parameter, "low": low, "high": high, "longest_step": longest_step,
        "max_points": max_points,
    }  # fmt: skip
    try:
        found = door.run(
            Branches, motion.osc, keys, motion.r, progress=progress, start=start,
            parameters={"low": "bounds[0]", "high": "bounds[1]"},
        )  # fmt: skip
    except StudyInterrupted as stop:
        raise StudyInterrupted(stop.result[0]) from None
    if not found:
        raise SingularError(found._result.notes[0][1])
    return found[0]
