"""Proofs of zones of symmetric motions with two impacts: where a stable, admissible one exists, where none does.

The plane is that of r and tan(theta), in which d K/F0 is explicit, so that boxes which fill it leave no motion
out.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.progress import with_progress
from ..studies.zone import Zone
from .balls import ball, decimal, flint
from .boxes import NEAR_CIRCLE, NO_SPEED, Box, Family, Problem, enclose
from .certificate import Certificate
from .equations import characteristic, determinant, flights, period_map
from .models import Model, at_middle, span
from .verdicts import between_walls, conditions_of, inside, inside_all

__all__ = ["prove_zone"]

_Array = NDArray[np.float64]
#: The largest |tan(theta)|: beyond it d is 2 A, nearly, and the impacts have hardly any approach speed.
STEEPEST = 4096
#: Largest part in r of a box that is tried.
WIDEST = Fraction(1, 200)
#: How many times less a condition must leave out than it varies, before parts of a box use it.
SHARP = 20
#: What the boxes of the sheets have in common.
FACINGS = (1, -1)


@with_progress
def prove_zone(
    zone: Zone, tolerance: float = 4e-3, *, progress: Callable[[float, str], None] | None = None
) -> Certificate:
    """As `Zone.prove`."""
    begin = time.perf_counter()
    checks.progress(progress)
    family = family_of(zone)
    tolerance = checks.to_float(tolerance, "tolerance", "from 1e-5 to 0.1")
    if not 1e-5 <= tolerance <= 0.1:
        raise ParameterError(f"tolerance = {tolerance!r}: must be from 1e-5 to 0.1")
    window, r = ([decimal(one) for one in ends] for ends in (zone.clearance, zone.r))
    sheet = {"r": r, "tangent": [str(-STEEPEST), str(STEEPEST)]}
    whole = {name: (Fraction(low), Fraction(high)) for name, (low, high) in sheet.items()}
    records = []
    with flint().ctx.workprec(64):
        for number, facing in enumerate(FACINGS):

            def told(share: float, number: int = number) -> None:
                if progress is not None:
                    progress((number + share) / len(FACINGS), "")

            boxes = cover_zone(family, Box(whole), facing, window, tolerance, told)
            records += [{"sheet": number, **record(box)} for box in boxes]
    undecided = [box for box in records if decision(box) is None]
    reasons = dict.fromkeys(box.pop("reason") for box in records)
    return Certificate(
        "zone", family.sides, family.cycles, True, family.record() | {"r": r, "clearance": window},
        [sheet, sheet], records,
        [{"reason": reason} for reason in reasons if reason] if undecided else [],
        time.perf_counter() - begin,
    )  # fmt: skip


def family_of(zone: Zone) -> Family:
    """The motions of a zone whose clearance is explicit."""
    if (
        zone.of_structure or zone.pattern.sides != "RL" or zone.pattern.cycles % 2 == 0
        or zone.symmetric is not True or zone.osc.restitution[0] != zone.osc.restitution[1]
    ):  # fmt: skip
        raise ParameterError(
            f"zone = {zone!r}: must be one of an Oscillator with symmetric = True and the pattern RL with an odd "
            "number of cycles"
        )
    osc = zone.osc
    values = {"xi": osc.xi, "mu": osc.mu, "r": 1.0, "clearance": 1.0, "load": 1.0}
    texts = {name: decimal(value) for name, value in values.items()}
    return Family(texts, (decimal(osc.restitution[0]),) * 2, "RL", zone.pattern.cycles, True)


def record(box: Box) -> dict[str, Any]:
    """The box of a certificate, with its reason."""
    spans = {name: [str(low), str(high)] for name, (low, high) in box.span.items()}
    names = ("exists", "admissible", "stable")
    reason = "" if decision(vars(box)) is not None else box.reason
    return {"parameters": spans} | {name: getattr(box, name) for name in names} | {"reason": reason}


def decision(box: dict[str, Any]) -> bool | None:
    """Whether all motions of a box are stable and admissible; False: none is, in the window."""
    if box["exists"] is False or box["stable"] is False or box["admissible"] is False:
        return False
    return True if box["stable"] and box["admissible"] else None


def cover_zone(
    family: Family, box: Box, facing: int, window: Sequence[str], tolerance: float,
    told: Callable[[float], None],
) -> list[Box]:  # fmt: skip
    """Boxes that fill a sheet, in order; `told` is called with the share that is done."""
    low, high = (ball(text) for text in window)
    width = float(box.span["r"][1] - box.span["r"][0])
    height = math.log(float(window[1]) / float(window[0]))
    found, waiting, done = [], [box], 0.0

    def parts(box: Box) -> tuple[float, float]:
        """The parts of the window in r and in log D that a box takes, nearly."""
        (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
        # d/A = |2 t + delta|/sqrt(1 + t^2) changes by hardly more than t does, or 1/t
        far = max(0.5, min(abs(float(lower)), abs(float(upper)))) if lower * upper > 0 else 0.5
        return float(right - left) / width, 4 * float(upper - lower) / far**2 / height

    while waiting:
        box = waiting.pop()
        (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
        along, across = parts(box)
        if right - left > WIDEST or upper - lower > STEEPEST:
            waiting += halves(box, "r" if right - left > WIDEST else "tangent")[::-1]
            continue
        conditions = judge_in_zone(family, box, facing, low, high)
        if decision(vars(box)) is None and not is_small(along, across, tolerance):
            if conditions and all(is_sharp(one) for one in conditions[:3]):
                found += refined(box, conditions, parts, tolerance)
                done += share_of(box, width)
                told(done)
            else:
                # all is nearly linear in the tangent, so that r leaves out more
                by_r = along * (16 if conditions else 2) > across
                waiting += halves(box, "r" if by_r else "tangent")[::-1]
            continue
        found.append(box)
        done += share_of(box, width)
        told(done)
    return found


def share_of(box: Box, width: float) -> float:
    """The part of a sheet, in r and theta, that a box takes."""
    (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
    turned = math.atan(float(upper)) - math.atan(float(lower))
    return float(right - left) / width * turned / (2 * math.atan(STEEPEST))


def is_small(along: float, across: float, tolerance: float) -> bool:
    """Whether a box is not halved any more: in r and log D, or as a narrow strip."""
    return (across < tolerance and along < 4 * tolerance) or along * across < tolerance**2 / 64


def is_sharp(condition: Any) -> bool:
    """Whether what a model leaves out is little beside how it varies, so that parts of its box can use it."""
    return bool(condition.c[0].rad() * SHARP < sum(abs(one).upper() for one in condition.c[1:]))


def refined(
    box: Box,
    conditions: Sequence[Any],
    parts: Callable[[Box], tuple[float, float]],
    tolerance: float,
) -> list[Box]:
    """Parts of a box in which all motions are admissible, by the models of the conditions of stability in it."""
    found, waiting = [], [box]
    names = ("r", "tangent")
    middle, half = (
        [(box.span[name][1] + sign * box.span[name][0]) / 2 for name in names] for sign in (1, -1)
    )
    while waiting:
        part = waiting.pop()
        of, places = conditions[0].space, []
        for k, name in enumerate(names):
            low, high = ((end - middle[k]) / half[k] for end in part.span[name])
            places.append(of.parameter(k, ball((low + high) / 2), ball((high - low) / 2)))
        here = [one.at(places) for one in conditions[:3]]
        values = [one.range() for one in here]
        part.exists, part.admissible, part.stable = True, box.admissible, None
        if any(value < 0 for value in values):
            part.stable = False
        elif all(value > 0 for value in values):
            part.stable = inside([at_middle(one.at(places)) for one in conditions[3:7]] + [1])
        along, across = parts(part)
        if part.stable is not None or is_small(along, across, tolerance):
            part.reason = NEAR_CIRCLE if part.stable is None else ""
            found.append(part)
        else:
            waiting += halves(part, "r" if along > across else "tangent")[::-1]
    return found


def halves(box: Box, name: str) -> list[Box]:
    """Both halves along a parameter."""
    low, high = box.span[name]
    middle = (low + high) / 2
    return [Box(box.span | {name: part}) for part in ((low, middle), (middle, high))]


def judge_in_zone(family: Family, box: Box, facing: int, low: Any, high: Any) -> list[Any] | None:
    """The verdicts on the motions of a box whose clearance lies in the window.

    Where they are admissible and only stability is open, the conditions of stability and the polynomial.
    """
    tangent = max(abs(float(end)) for end in box.span["tangent"])
    box.start, sizes = np.zeros(4), np.full(4, 1 + tangent)
    try:
        problem = Problem(family, box, facing)
        if not enclose(problem, box, sizes):
            box.reason = "the linear equations may be singular in a box"
            return None
        assert box.centre is not None
        system, states = problem.states(problem.system, problem.models(box.centre, box.error))
        amplitude = scale(family, *(problem.box_values[name] for name in ("r", "tangent")))
        clearance = span(system.clearance) * amplitude
        if clearance < low or clearance > high:
            box.exists = False
            return None
        found = flights(system, states)
        speed = span(found[0].after * (found[0].start[3] - found[0].v))
        box.reason = NO_SPEED
        if speed < 0:
            box.admissible = False
        if not speed > 0:
            return None
        polynomial = characteristic(period_map(system, found), determinant(system))
        box.stable, box.reason = inside_all(polynomial), NEAR_CIRCLE
        if box.stable is not False:
            box.admissible, _, reason = between_walls(system, found)
            box.reason = reason or box.reason
        if box.admissible and box.stable is None:
            return [
                one if isinstance(one, Model) else problem.space.constant(one)
                for one in [*conditions_of(polynomial), *polynomial[:4]]
            ]
    except ZeroDivisionError:
        box.reason = box.reason or "a denominator may be zero"
    return None


def scale(family: Family, r: Any, tangent: Any) -> Any:
    """A cos(theta) in balls."""
    xi = ball(family.values["xi"])
    distance, damping = 1 - r * r, 2 * xi * r
    return 1 / ((distance * distance + damping * damping) * (1 + tangent * tangent)).sqrt()


def explicit(certificate: Certificate, r: _Array) -> tuple[_Array, _Array]:
    """A, and delta in d/A = -(2 t + delta) cos(theta), at values of r."""
    xi, mu = (float(certificate.system[name]) for name in ("xi", "mu"))
    R, eta = float(certificate.system["restitution"][0]), math.sqrt(1 - xi * xi)
    tau = math.pi * certificate.cycles / r
    w = np.exp(-xi * tau) * np.sin(eta * tau) / eta
    turned = np.exp(-xi * tau) * np.cos(eta * tau)
    u, q = turned + xi * w, turned - xi * w
    kappa = 1 + q + w * w / (1 + u)
    shared = (1 + R) * r / (2 * mu * (R * (kappa - 1) - 1) - (1 - R) * kappa)
    speed = -kappa * shared
    place = -w * 2 * mu * shared / (1 + u)
    amplitude = 1 / np.hypot(1 - r * r, 2 * xi * r)
    return amplitude, 2 * place + speed * tau


class Plane:
    """The boxes of a certificate of a zone as numbers."""

    def __init__(self, certificate: Certificate) -> None:
        self.certificate = certificate
        spans = [
            [float(Fraction(end)) for name in ("r", "tangent") for end in box["parameters"][name]]
            for box in certificate.boxes
        ]
        self.low, self.high, self.left, self.right = np.array(spans).T
        self.facing = np.array([FACINGS[box["sheet"]] for box in certificate.boxes])
        values = {True: 1, False: 0, None: -1}
        self.decisions = np.array([values[decision(box)] for box in certificate.boxes])
        self.window = [float(one) for one in certificate.system["clearance"]]

    def images(self, r: float, value: int) -> _Array:
        """The intervals of d K/F0 in the window, at r, of the boxes with a decision."""
        here = (self.low <= r) & (r <= self.high) & (self.decisions == value)
        left, right, facing = self.left[here], self.right[here], self.facing[here]
        amplitude, delta = (one[0] for one in explicit(self.certificate, np.array([r])))

        def of(t: _Array) -> _Array:
            found: _Array = -facing * amplitude * (2 * t + delta) / np.hypot(1, t)
            return found

        turn = np.full_like(left, 2 / delta if delta else np.inf)
        ends = [of(left), of(right), of(np.clip(turn, left, right))]
        both = np.stack([np.minimum.reduce(ends), np.maximum.reduce(ends)], axis=1)
        if value < 0:
            # what lies beyond the steepest tangent
            edge = [abs(2 * t + delta) / math.hypot(1, t) for t in (STEEPEST, -STEEPEST)] + [2.0]
            both = np.vstack([both, [amplitude * min(edge), amplitude * max(edge)]])
        both = np.clip(both, self.window[0], self.window[1])
        return union(both[both[:, 1] > both[:, 0]])

    def decide(self, r: float, clearance: float) -> bool | None:
        """As `Certificate.decide`."""
        if not (
            self.low.min() <= r <= self.high.max() and self.window[0] <= clearance <= self.window[1]
        ):
            return None
        near = np.array([[clearance * (1 - MARGIN), clearance * (1 + MARGIN)]])
        inside, open_ = (self.images(r, value) for value in (1, -1))
        if any(low <= near[0, 0] and near[0, 1] <= high for low, high in inside):
            return True
        outside = all(high < near[0, 0] or near[0, 1] < low for low, high in [*inside, *open_])
        return False if outside else None

    def lines(self, number: int) -> Iterator[tuple[float, _Array, _Array]]:
        """Proven and not decided intervals on lines of constant r."""
        ends = self.low.min(), self.high.max()
        for k in range(number):
            r = ends[0] + (ends[1] - ends[0]) * (k + 0.5) / number
            yield r, self.images(r, 1), self.images(r, -1)

    def shares(self, number: int = 400) -> dict[str, float]:
        """As `Certificate.shares`."""
        inside = open_ = 0.0
        for _, proven, possible in self.lines(number):
            own = lengths(proven)
            inside += own
            open_ += lengths(union(np.vstack([proven, possible]))) - own
        total = number * math.log(self.window[1] / self.window[0])
        return {
            "inside": inside / total,
            "outside": 1 - (inside + open_) / total,
            "undecided": open_ / total,
        }


#: How far from the edge of an image a clearance must be, relative to it: far above rounding of `explicit`.
MARGIN = 1e-9


def union(intervals: _Array) -> _Array:
    """Disjoint intervals in order."""
    found: list[list[float]] = []
    for low, high in sorted(intervals.tolist()):
        if found and low <= found[-1][1] * (1 + 1e-12):
            found[-1][1] = max(found[-1][1], high)
        else:
            found.append([low, high])
    return np.array(found).reshape(-1, 2)


def lengths(intervals: _Array) -> float:
    """The lengths of intervals on a logarithmic scale."""
    return float(np.log(intervals[:, 1] / intervals[:, 0]).sum())
