"""Proofs of single motions."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.progress import with_progress
from ..motions.motion import Motion
from ..motions.periodic import equispaced
from ..studies.branch import Branch
from ..studies.find import find
from ..systems.oscillator import Oscillator, Pattern, Point, pattern_of
from ..systems.verbs import physical_arguments
from .balls import decimal, decimal_text, flint, hexadecimal, upward
from .boxes import (
    NEAR_CIRCLE,
    NO_MOTION,
    NO_ORDER,
    NO_SPEED,
    WITHOUT_REST,
    Box,
    Family,
    cover,
    sizes_of,
)
from .certificate import Certificate
from .equations import System, characteristic, determinant, flights, period_map
from .families import StructureFamily
from .structures import check_structure, prove_structure
from .verdicts import between_walls, inside, krawczyk, multiplier_bound

__all__ = ["prove_box", "prove_branch", "prove_motion"]

#: (lowest, highest), or one value.
Interval = tuple[float, float] | float
#: The largest number of halvings of a box of `prove_box`.
HALVINGS = 24
#: Impacts and load cycles of the motions that `find` looks for.
MOST_IMPACTS, MOST_CYCLES = 12, 8

_Array = NDArray[np.float64]

#: Parameters along which branches are proven, and the largest number of boxes for a part of a branch.
BRANCHED = ("r", "clearance", "xi", "mu", "R1", "R2", "restitution")
MOST_BOXES = 2_000
#: Why a box of a branch is not decided although its neighbour is.
NOT_LINKED = "the motion is not proven to be the same as in the previous box"
#: Bits of the mantissa, and the sizes of the boxes relative to 1 or to the size of an unknown, in turn.
ATTEMPTS = ((64, 2.0**-34), (64, 2.0**-42), (128, 2.0**-56), (256, 2.0**-120))


@with_progress
def prove_motion(
    motion: Motion, *, progress: Callable[[float, str], None] | None = None
) -> Certificate:
    """As `Motion.prove`."""
    checks.progress(progress)
    if motion.of_structure:
        return prove_structure(motion, progress)
    begin = time.perf_counter()
    family = Family.of(motion)
    box, reason = best_attempt(family, family.states(motion), progress)
    return Certificate(
        "motion", family.sides, family.cycles, family.symmetric, family.record(), [{}],
        [box] if box else [], [{"reason": reason}] if reason else [], time.perf_counter() - begin,
    )  # fmt: skip


def best_attempt(
    family: Family, start: _Array, progress: Callable[[float, str], None] | None = None
) -> tuple[dict[str, Any], str]:
    """As `attempt`, with as many digits as necessary."""
    box: dict[str, Any] = {}
    reason = ""
    module = flint()
    for number, (bits, size) in enumerate(ATTEMPTS):
        if progress is not None:
            progress(number / len(ATTEMPTS), f"{bits} bits")
        with module.ctx.workprec(bits):
            found, why = attempt(family.system({}), start, size, bits > 64)
        if found or not box:
            box, reason = found, why
        if box and None not in (box["admissible"], box["stable"]):
            return box, ""
    return box, reason


def attempt(
    system: System, states: _Array, size: float, refined: bool
) -> tuple[dict[str, Any], str]:
    """A box of a certificate, empty if existence is not proven, and the reason for undecided items."""
    module = flint()
    centre = [[module.arb(value) for value in row] for row in states.tolist()]
    largest = sizes_of(states)[: states.shape[1]].tolist()
    sizes = [value * size for value in largest]
    if refined:
        # Newton's method with more digits: each step from the middle of the last enclosure
        for coarse in (2.0**-30, 2.0**-44, 2.0**-60, 2.0**-90):
            rough = krawczyk(system, centre, [[one * coarse for one in largest]] * len(centre))
            if rough is not None:
                centre = [[one.mid() for one in row] for row in rough]
    radii = [sizes] * len(centre)
    enclosed = krawczyk(system, centre, radii)
    if enclosed is None:
        return {}, NO_MOTION
    found = flights(system, enclosed)
    if not all(flight.tau > 0 for flight in found):
        return {}, NO_ORDER
    box: dict[str, Any] = {
        "sheet": 0, "parameters": {}, "centre": [[[hexadecimal(one)] for one in row] for row in centre],
        "radius": [[hexadecimal(module.arb(one)) for one in row] for row in radii],
        "exists": True, "admissible": None, "stable": None,
        "multipliers_below": None, "multipliers_above": None, "attenuation_below": None,
    }  # fmt: skip
    admissible, largest_x, reason = between_walls(system, found)
    box["admissible"] = admissible
    if admissible:
        steady = (system.sine * system.sine + system.cosine * system.cosine).sqrt()
        box["attenuation_below"] = decimal_text(upward(largest_x / steady, 4))
    if not all(abs(flight.start[3] - flight.v) > 0 for flight in found):
        return box, reason or NO_SPEED
    coefficients = characteristic(period_map(system, found), determinant(system))
    stable = inside(coefficients)
    box["stable"] = stable
    if stable is None:
        return box, "; ".join(filter(None, [reason, NEAR_CIRCLE]))
    bound = multiplier_bound(coefficients, stable, 2 if system.mirrored else 1)
    if bound is not None:
        box["multipliers_below" if stable else "multipliers_above"] = decimal_text(bound)
    return box, reason


def summary(boxes: Sequence[Box]) -> list[dict[str, Any]]:
    """The undecided items of boxes; adjacent boxes with the same reason are joined."""
    found: list[dict[str, Any]] = []
    for box in boxes:
        if box.decided:
            continue
        spans = {name: [str(low), str(high)] for name, (low, high) in box.span.items()}
        if found and len(spans) == 1 and found[-1]["reason"] == box.reason:
            ((name, (low, high)),) = spans.items()
            before = found[-1]["parameters"][name]
            if before[1] == low:
                before[1] = high
                continue
        found.append({"reason": box.reason, "parameters": spans})
    return found


def total(values: Sequence[float]) -> Any:
    """The sum of doubles in balls."""
    return sum(map(flint().arb, values), flint().arb(0))


def link(boxes: Sequence[Box]) -> None:
    """Mark neighbours along one parameter that may contain different motions at the value that they share."""
    for one, two in pairwise(boxes):
        if one.centre is None or two.centre is None:
            continue
        far = [
            abs(total(end) - total(start[::2]) + total(start[1::2])) + error
            for end, start, error in zip(
                one.centre.tolist(), two.centre.tolist(), one.error, strict=True
            )
        ]
        # twice that, if possible, so that another enclosure of the motion is also near enough
        held, clear = (
            [
                radius
                for radius in two.radii
                if all(k * own < size for own, size in zip(far, radius, strict=True))
            ]
            for k in (1, 2)
        )
        two.radius = next(iter(clear or held[-1:]), two.radius)
        if not held:
            two.exists, two.centre, two.reason = None, None, NOT_LINKED
            two.admissible = two.stable = None


def family_of(branch: Branch) -> tuple[Family | StructureFamily, _Array]:
    """The motions of a branch, and the unknowns at its points, (unknowns, points)."""
    if branch.of_structure:
        check_structure(branch, branch.structure, len(branch.resting))
        motions = branch[:]
        family = StructureFamily.of(motions[len(motions) // 2], branch.parameter, branch._start)
        return family, family.states(motions).reshape(-1, len(motions))
    if branch.parameter not in BRANCHED:
        names = ", ".join(BRANCHED)
        raise ParameterError(f"branch = {branch!r}: must be along one of {names}")
    of_pair = Family.of(branch[len(branch) // 2])
    if branch.parameter in ("R1", "R2"):
        # the walls differ everywhere but at one point
        of_pair = replace(of_pair, symmetric=False)
    phases = branch.phases + (np.unwrap(branch.phases[0]) - branch.phases[0])
    states = np.stack([phases, branch.X, branch.X_dot_after, branch.Z_dot_after], axis=1)
    return of_pair, states[: len(of_pair.word)].reshape(-1, len(branch))


@with_progress
def prove_branch(
    branch: Branch, tolerance: float = 1e-4, *, progress: Callable[[float, str], None] | None = None
) -> Certificate:
    """As `Branch.prove`."""
    begin = time.perf_counter()
    checks.progress(progress)
    tolerance = checks.to_float(tolerance, "tolerance", "from 1e-13 to 1")
    if not 1e-13 <= tolerance <= 1:
        raise ParameterError(f"tolerance = {tolerance!r}: must be from 1e-13 to 1")
    name, values = branch.parameter, branch.values
    family, states = family_of(branch)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
    sheets, records, undecided = [], [], []
    for first, last in pairwise([0, *turns.tolist(), len(values) - 1]):
        part = slice(first, last + 1)
        along, known = values[part], states[:, part]
        if along[0] > along[-1]:
            along, known = along[::-1], known[:, ::-1]
        if not along[0] < along[-1]:
            continue
        ends = Fraction(decimal(along[0])), Fraction(decimal(along[-1]))

        def start(box: Box, along: _Array = along, known: _Array = known) -> _Array:
            low, high = box.span[name]
            return np.array([np.interp(float(low + high) / 2, along, row) for row in known])

        def told(share: float, first: int = first, last: int = last) -> None:
            if progress is not None:
                progress((first + share * (last - first)) / (len(values) - 1), "")

        sizes = family.sizes(np.abs(known).max(axis=1).reshape(-1, family.width))
        halvings = math.ceil(math.log2(1 / tolerance))
        with flint().ctx.workprec(64):
            boxes = cover(family, Box({name: ends}), sizes, halvings, MOST_BOXES, start, told)
            link(boxes)
        sheets.append({name: [str(end) for end in ends]})
        records += [{"sheet": len(sheets) - 1, **box.record(family.width)} for box in boxes]
        undecided += summary(boxes)
    return Certificate(
        "branch", family.sides, family.cycles, family.symmetric, family.record(), sheets, records, undecided,
        time.perf_counter() - begin,
    )  # fmt: skip


@overload
def prove_box(
    osc: Oscillator, pattern: Pattern | str, r: Interval, clearance: Interval, *,
    xi: Interval | None = None, mu: Interval | None = None,
    R1: Interval | None = None, R2: Interval | None = None, restitution: Interval | None = None,
    most_boxes: int = 2000, progress: Callable[[float, str], None] | None = None,
) -> Certificate: ...  # fmt: skip
@overload
def prove_box(
    point: Point, /, pattern: Pattern | str, *, xi: Interval | None = None, mu: Interval | None = None,
    R1: Interval | None = None, R2: Interval | None = None, restitution: Interval | None = None,
    most_boxes: int = 2000, progress: Callable[[float, str], None] | None = None,
) -> Certificate: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
@with_progress
def prove_box(
    osc: Oscillator, pattern: Pattern | str, r: Interval, clearance: Interval, *, xi: Interval | None = None,
    mu: Interval | None = None, R1: Interval | None = None, R2: Interval | None = None,
    restitution: Interval | None = None, most_boxes: int = 2000,
    progress: Callable[[float, str], None] | None = None,
) -> Certificate:  # fmt: skip
    """Prove that a motion is stable and admissible for all parameters in a box of tolerances (extra `proof`).

    The box is halved until each part is proven or no proof is possible. The motion is the stable, admissible
    motion of the pattern that is found at the middle of the box.

    Parameters
    ----------
    osc : Oscillator
        Provides the values of the parameters that are not given here.
    pattern : Pattern or str
        The pattern of the motion, or a str such as "RL" or "RL/3" (sides/cycles).
    r, clearance : (lowest, highest) or float
        Frequency ratio r, and clearance d K/F0.
    xi, mu, R1, R2 : (lowest, highest) or float, optional
        Damping ratio, mass ratio, and restitution of the right and of the left wall.
    restitution : (lowest, highest) or float, optional
        R1 = R2, in place of both; symmetric motions then remain symmetric, for which proofs are much easier.
    most_boxes : int, optional
        Largest number of boxes to try, at least 1.
    progress : callable, optional
        Called with the fraction done and an empty text; by default a bar on a terminal or in a notebook.

    Returns
    -------
    Certificate
        `proven` says whether a stable, admissible motion exists for all parameters. `undecided` contains the parts
        of the box where this is false or unknown, with reasons.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an interval is invalid, or the pattern has rest.
    MissingExtraError
        If python-flint is not installed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> proof = vi.prove_box(osc, "RL", r=1.04, clearance=(24, 26), restitution=(0.74, 0.76))
    >>> proof.proven, proof.attenuation_bound < 0.57
    (True, True)
    """
    begin = time.perf_counter()
    checks.instance(osc, "osc", Oscillator)
    checks.progress(progress)
    pattern = pattern_of(pattern)
    if pattern.has_rest:
        raise ParameterError(f"pattern = {text_of(pattern)!r}: {WITHOUT_REST}")
    most_boxes = checks.integer(most_boxes, "most_boxes", 1, 10**9)
    if restitution is not None and (R1 is not None or R2 is not None):
        raise ParameterError(
            f"restitution = {restitution!r}: must be left out if R1 or R2 is given"
        )
    given = {
        "xi": xi,
        "mu": mu,
        "r": r,
        "clearance": clearance,
        "R1": R1,
        "R2": R2,
        "restitution": restitution,
    }
    required = ("r", "clearance")  # None stands for the oscillator's own value of the others
    spans = {
        name: ends_of(value, name)
        for name, value in given.items()
        if value is not None or name in required
    }
    middle = {name: float(low + high) / 2 for name, (low, high) in spans.items()}
    walls = middle.get("restitution")
    right, left = (
        middle.get(name, own if walls is None else walls)
        for name, own in zip(("R1", "R2"), osc.restitution, strict=True)
    )
    centre = replace(
        osc, xi=middle.get("xi", osc.xi), mu=middle.get("mu", osc.mu), restitution=(right, left)
    )
    varied = {name: ends for name, ends in spans.items() if ends[0] < ends[1]}
    motion = stable_motion(centre, pattern, middle["r"], middle["clearance"])
    sheet = {name: [str(low), str(high)] for name, (low, high) in varied.items()}
    if motion is None:
        reason = "no stable, admissible motion was found at the middle"
        system: dict[str, Any] = {name: decimal(getattr(centre, name)) for name in ("xi", "mu")}
        system |= {name: decimal(middle[name]) for name in ("r", "clearance")} | {"load": "1.0"}
        system["restitution"] = [decimal(right if side == "R" else left) for side in pattern.sides]
        return Certificate(
            "box", pattern.sides, pattern.cycles, False, system, [sheet], [],
            [{"reason": reason, "parameters": sheet}], time.perf_counter() - begin,
        )  # fmt: skip
    if not varied:
        return replace(prove_motion(motion), seconds=time.perf_counter() - begin)
    family = Family.of(motion)
    if {"R1", "R2"}.intersection(varied):
        family = replace(family, symmetric=False)
    states = family.states(motion)

    def told(share: float) -> None:
        if progress is not None:
            progress(share, "")

    with flint().ctx.workprec(64):
        box = Box(varied, start=states.ravel())
        boxes = cover(family, box, sizes_of(states), HALVINGS, most_boxes, told=told)
        if len(varied) == 1:
            link(boxes)
    return Certificate(
        "box", family.sides, family.cycles, family.symmetric, family.record(), [sheet],
        [{"sheet": 0, **box.record()} for box in boxes], summary(boxes), time.perf_counter() - begin,
    )  # fmt: skip


def ends_of(value: Any, name: str) -> tuple[Fraction, Fraction]:
    """The ends of an interval, or of a number."""
    both = value if isinstance(value, (tuple, list, np.ndarray)) else (value, value)
    if np.ndim(value) > 1 or len(both) != 2:
        raise ParameterError(f"{name} = {value!r}: must be a number or (lowest, highest)")
    kind = "restitution" if name in ("R1", "R2") else name
    low, high = (Fraction(decimal(checks.number(one, kind, name))) for one in both)
    return min(low, high), max(low, high)


def text_of(pattern: Pattern) -> str:
    """A pattern as a text."""
    return f"{pattern.sides}/{pattern.cycles}"


def stable_motion(osc: Oscillator, pattern: Pattern, r: float, clearance: float) -> Motion | None:
    """A stable, admissible motion of a pattern."""
    found: Iterable[Motion] = ()
    if pattern.sides == "RL" and pattern.cycles % 2 and osc.restitution[0] == osc.restitution[1]:
        found = equispaced(osc, r, clearance, pattern.cycles)
    best = next((one for one in found if one.stable and one.admissible), None)
    if best is None:
        if len(pattern) > MOST_IMPACTS or pattern.cycles > MOST_CYCLES:
            raise ParameterError(
                f"pattern = {text_of(pattern)!r}: must have at most {MOST_IMPACTS} impacts and {MOST_CYCLES} "
                "load cycles"
            )
        found = find(osc, r, clearance, max_impacts=len(pattern), max_cycles=pattern.cycles)
        same = (
            one
            for one in found
            if one.pattern.sides == pattern.sides and one.cycles == pattern.cycles
        )
        best = next((one for one in same if one.stable and one.admissible), None)
    return best
