"""Branches: how an exact motion changes along a parameter, with its bifurcations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core, checks
from ..errors import ParameterError, SingularError, StudyInterrupted
from ..interchange import namelist
from ..interchange.result import Result
from ..interrupt import new_tally, stoppable
from ..model import Oscillator, Pattern
from ..motion import Motion
from ..solve import frozen
from ..status import VERDICT, raise_status
from .conditions import (
    EDGE,
    GRAZING,
    PARAMETERS,
    REPETITION,
    can_be_symmetric,
    detail_text,
    is_symmetric,
    type_name,
)
from .switching import doubled, extra_impact, perturbed

__all__ = ["Branch", "SpecialPoint", "branch"]

#: Parameters a branch can follow; "restitution" is R1 = R2 together.
CHOICES = (*PARAMETERS, "restitution")
REASONS = {
    1: "bound of the parameter",
    2: "meets a motion that repeats itself",
    3: "closed",
    4: "cannot be followed",
    5: "full",
    6: "stopped",
}
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
        each a little beside the point along the branch's parameter, on the side where it exists.

        Returns
        -------
        list of Motion
            Empty where no such motion was found near the point. Follow them with `branch`.
        """
        if self.type == "pitchfork":
            return perturbed(self.motion, 1.0, self.parameter)
        if self.type == "flip":
            return doubled(self.motion, self.parameter)
        if self.type == "grazing":
            return extra_impact(self.motion, self.impact, self.side, self.parameter)
        return []

    def __repr__(self) -> str:
        place = f"r = {self.r:.10g}, d K/F0 = {self.clearance:.10g}"
        if self.parameter not in ("r", "clearance"):
            right, left = self.motion.osc.restitution
            values = {"xi": self.motion.osc.xi, "mu": self.motion.osc.mu, "R2": left}
            place += f", {self.parameter} = {values.get(self.parameter, right):.10g}"
        return f"<{self.type} at {place}>"


@dataclass(frozen=True, eq=False, repr=False)
class Branch(Result):
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
    phases, X : ndarray (N, M)
    A, tau, residual, x_min, x_max, attenuation : ndarray (M,)
    multipliers : ndarray (4, M) of complex
    admissible, stable : ndarray (M,) of int8
        1, 0, or -1 where not known.
    special_points : list of SpecialPoint
        In the order of the branch.
    ends : (str, str)
        Why the branch ends, at its first and last point.
    case : str
        What was asked for as a namelist; empty if none can tell (see `to_namelist`).
    """

    parameter: str
    pattern: Pattern
    symmetric: bool
    parameters: _Array
    phases: _Array
    impacts: _Array
    scalars: _Array
    multipliers: NDArray[np.complex128]
    verdicts: NDArray[np.int32]
    special_points: list[SpecialPoint]
    ends: tuple[str, str]
    case: str = ""

    r = property(lambda self: self.parameters[0])
    clearance = property(lambda self: self.parameters[1])
    xi = property(lambda self: self.parameters[2])
    mu = property(lambda self: self.parameters[3])
    R1 = property(lambda self: self.parameters[4])
    R2 = property(lambda self: self.parameters[5])
    X = property(lambda self: self.impacts[:, 0])
    A = property(lambda self: self.scalars[1])
    tau = property(lambda self: self.scalars[2])
    residual = property(lambda self: self.scalars[3])
    x_min = property(lambda self: self.scalars[4])
    x_max = property(lambda self: self.scalars[5])
    attenuation = property(lambda self: np.maximum(-self.x_min, self.x_max) / self.A)
    admissible = property(lambda self: self.verdicts[1].astype(np.int8))
    stable = property(lambda self: self.verdicts[2].astype(np.int8))

    @property
    def complete(self) -> bool:
        """False if Ctrl-C cut it short."""
        return REASONS[6] not in self.ends

    @property
    def cut(self) -> str:
        """How far it came if it was cut short; else empty."""
        low, high = self.values.min(), self.values.max()
        return "" if self.complete else f"{self.parameter} from {low:.6g} to {high:.6g} was reached"

    @property
    def values(self) -> _Array:
        """The parameter along the branch."""
        name = "R1" if self.parameter == "restitution" else self.parameter
        result: _Array = self.parameters[PARAMETERS.index(name)]
        return result

    def __len__(self) -> int:
        return int(self.parameters.shape[1])

    def __getitem__(self, i: int) -> Motion:
        if not -len(self) <= i < len(self):
            raise IndexError(f"point {i} of a branch of {len(self)} points")
        return point_motion(
            self.pattern, self.parameters[:, i], self.phases[:, i], self.impacts[:, :, i],
            self.scalars[:, i], self.multipliers[:, i], self.verdicts[:, i],
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
        from ..plot.branch import draw_branch

        return draw_branch(self, ax, y)

    def __repr__(self) -> str:
        counts: dict[str, int] = {}
        for item in self.special_points:
            counts[item.type] = counts.get(item.type, 0) + 1
        found = ", ".join(f"{n} {name}" for name, n in counts.items()) or "no special points"
        return (
            f"<Branch {self.pattern.sides}/{self.pattern.cycles} along {self.parameter}, "
            f"{self.values.min():.6g} to {self.values.max():.6g}: {len(self)} points, {found}>"
        )


def point_motion(
    pattern: Pattern,
    parameters: _Array,
    phases: _Array,
    impacts: _Array,
    scalars: _Array,
    multipliers: NDArray[np.complex128],
    verdicts: NDArray[np.int32],
) -> Motion:
    """The motion of one point of the core's arrays."""
    r, clearance, xi, mu, right, left = parameters.tolist()
    _, amplitude, tau, residual, x_min, x_max = scalars.tolist()
    consistent, admissible, stable = verdicts.tolist()
    x, z, x_before, x_after, z_before, z_after = (frozen(column.copy()) for column in impacts.T)
    multipliers = multipliers.copy()
    multipliers.flags.writeable = False
    return Motion(
        Oscillator(xi=xi, mu=mu, restitution=(right, left)), r, clearance, pattern,
        frozen(np.where(pattern.signs > 0, right, left)), frozen(phases.copy()), x, z, x_before, x_after,
        z_before, z_after, amplitude, tau, residual, multipliers,
        VERDICT[consistent], VERDICT[admissible], VERDICT[stable], x_min, x_max,
    )  # fmt: skip


def branch(
    motion: Motion,
    parameter: str = "clearance",
    bounds: tuple[float, float] | None = None,
    longest_step: float = 0.05,
    max_points: int = 4000,
    progress: Callable[[float, str], None] | None = None,
) -> Branch:
    """Follow an exact motion along a parameter, both ways, through folds, to the bounds.

    Pseudo-arclength continuation with Newton's method and the analytic derivative of the equations. Special
    points are located by Newton's method on the equations with one more: det(P - I) = 0 at a fold,
    det(P + I) = 0 at a flip, the product of all 1 - lambda_i lambda_j at a Neimark-Sacker point, a touch of a
    wall, or an approach speed that is zero. A motion that is its own mirror image is followed as such, with
    the map of half a period, so that the pitchfork is a point on the way and not an end.

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
    The stable unequispaced motion beside the third column of Table 1, along the clearance:

    >>> import math, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    >>> path = vi.branch(motion, "clearance", bounds=(10, 60))
    >>> [(point.type, round(point.clearance, 6)) for point in path.special_points]
    [('bound', 10.0), ('grazing', 18.085596), ('flip', 34.964757), ('bound', 60.0)]
    """
    checks.instance(motion, "motion", Motion)
    checks.choice(parameter, "parameter", CHOICES)
    longest_step = checks.number(longest_step, "longest_step")
    max_points = checks.integer(max_points, "max_points", 10, 10**5)
    low, high = checked_bounds(motion, parameter, bounds)
    symmetric = is_symmetric(motion) and parameter not in ("R1", "R2")
    tied = parameter == "restitution"
    which = PARAMETERS.index("R1" if tied else parameter) + 1
    constants = np.array(
        [motion.r, motion.clearance, motion.osc.xi, motion.osc.mu, *motion.osc.restitution]
    )
    theta = motion.phases + motion.tau
    found, complete = stoppable(
        _core.branch, constants, which, tied, (low, high), motion.pattern.cycles, motion.pattern.signs, symmetric,
        motion.X, theta, longest_step, 2 * max_points,
        tally=new_tally(), progress=progress, note="branch",
    )  # fmt: skip
    parameters, phases, impacts, scalars, multipliers, verdicts, _, special, n, ends, status = found
    raise_status(int(status))
    if n == 0:
        raise SingularError(
            "the branch cannot be followed from this motion: it is at a singular point"
        )
    mirrored = can_be_symmetric(motion.osc, motion.pattern) and not symmetric
    keep = slice(0, int(n))
    result = Branch(
        parameter, motion.pattern, bool(symmetric), parameters[:, keep], phases[:, keep],
        impacts[:, :, keep], scalars[:, keep], multipliers[:, keep], verdicts[:, keep], [],
        (REASONS[int(ends[0])], REASONS[int(ends[1])]),
        namelist.case(motion.osc, motion.r, motion=namelist.of_motion(motion), branch={
            "parameter": parameter, "low": low, "high": high, "longest_step": longest_step,
            "max_points": max_points,
        }) if motion.precision == "double" else "",
    )  # fmt: skip
    result.special_points.extend(located(result, special[:, keep], mirrored))
    if not (complete and result.complete):
        raise StudyInterrupted(result)
    return result


def located(branch: Branch, special: NDArray[np.int32], mirrored: bool) -> Iterator[SpecialPoint]:
    """The special points of a branch, from kind, index and side at each of its points."""
    n_family = len(branch.pattern) // 2 if branch.symmetric else len(branch.pattern)
    for i in np.flatnonzero(special[0]).tolist():
        kind, index, side = special[:, i].tolist()
        try:
            here = branch[i]
        except SingularError:
            continue
        yield SpecialPoint(
            type_name(kind, index, branch.symmetric, mirrored), i, here.r, here.clearance, here,
            index - 1 if kind not in (EDGE, REPETITION) and index <= n_family else -1,
            ("R" if side > 0 else "L") if kind == GRAZING else "", branch.parameter,
            detail_text(kind, index, side),
        )  # fmt: skip


def checked_bounds(motion: Motion, parameter: str, bounds: Any) -> tuple[float, float]:
    """Bounds within which a motion can be followed along a parameter; an error if it cannot be at all."""
    checks.plain_pattern(motion.pattern)
    if motion.load != 1.0:
        raise ParameterError(
            f"motion.load = {motion.load!r}: must be 1; scale the clearance instead"
        )
    right, left = motion.osc.restitution
    if not np.array_equal(motion.restitution, np.where(motion.pattern.signs > 0, right, left)):
        raise ParameterError(
            f"motion.restitution = {motion.restitution.tolist()!r}: must be that of the walls"
        )
    if parameter == "restitution" and right != left:
        raise ParameterError(
            f"parameter = 'restitution': must go with R1 = R2, not with {right!r} and {left!r}"
        )
    start = {
        "r": motion.r, "clearance": motion.clearance, "xi": motion.osc.xi, "mu": motion.osc.mu,
        "R1": right, "R2": left, "restitution": right,
    }[parameter]  # fmt: skip
    low, high = ordered_bounds(bounds, parameter, start)
    if (parameter == "r" and motion.osc.xi == 0 and low <= 1 <= high) or (
        parameter == "xi" and low == 0 and motion.r == 1
    ):
        raise ParameterError(
            f"bounds = ({low!r}, {high!r}): must not contain r = 1 with xi = 0 (resonance without damping)"
        )
    return low, high


def ordered_bounds(bounds: Any, parameter: str, start: float) -> tuple[float, float]:
    """Checked bounds of a parameter around its value."""
    name = {"R1": "restitution", "R2": "restitution"}.get(parameter, parameter)
    wanted = f"(lowest, highest) values of {parameter} with the motion's {start:g} between them"
    if bounds is None:
        raise ParameterError(f"bounds = None: must be {wanted}")
    try:
        low, high = bounds
    except (TypeError, ValueError):
        raise ParameterError(f"bounds = {bounds!r}: must be {wanted}") from None
    low = checks.number(low, name, "bounds[0]")
    high = checks.number(high, name, "bounds[1]")
    if not low <= start <= high or not low < high:
        raise ParameterError(f"bounds = ({low!r}, {high!r}): must be {wanted}")
    return low, high
