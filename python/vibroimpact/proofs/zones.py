"""Proofs of zones of symmetric motions with two impacts: where a stable, admissible motion exists, and where none
does.

In the plane of r and tan(theta), d K/F0 is an explicit function, so that boxes that fill the plane cover all
motions.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from ..base.progress import with_progress
from ..studies.zone import Zone
from .balls import ball, decimal, exact, flint
from .boxes import NEAR_CIRCLE, NO_SPEED, Box, Family, Problem, enclose
from .certificate import Certificate
from .equations import characteristic, determinant, flights, period_map
from .models import Model, span
from .verdicts import between_walls, conditions_of, inside, inside_all

__all__ = ["prove_zone"]

_Array = NDArray[np.float64]
#: The largest |tan(theta)|: beyond it d is nearly 2 A, and the approach speeds are close to zero.
STEEPEST = 4096
#: The largest width in r of a box that is tried, and the tangents at which the plane is first divided.
WIDEST, CUTS = Fraction(1, 100), (1, 4, 16, 64, 256, 1024)
#: The least ratio of the variation of a condition to its remainder for the model to be used in parts of a box.
SHARP = 50
#: The largest uncertainty of a zero of a model, relative to the tolerance.
BLUR = 0.25
#: The distance of a cut from the range of a zero in a strip, relative to the width of that range; the largest
#: number of halvings of a part between cuts, and its smallest width.
BESIDE, MOST_HALVINGS, NARROWEST = 0.1, 12, 2.0**-14
#: The sign that the motions of each sheet have in common.
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
    """The family of the motions of a zone, whose clearance is explicit."""
    if (
        zone.of_structure or zone.pattern.sides != "RL" or zone.pattern.cycles % 2 == 0
        or zone.symmetric is not True or zone.osc.restitution[0] != zone.osc.restitution[1]
    ):  # fmt: skip
        raise ParameterError(
            f"zone = {zone!r}: must be a zone of an Oscillator with symmetric = True and the pattern RL with an "
            "odd number of cycles"
        )
    osc = zone.osc
    values = {"xi": osc.xi, "mu": osc.mu, "r": 1.0, "clearance": 1.0, "load": 1.0}
    texts = {name: decimal(value) for name, value in values.items()}
    return Family(texts, (decimal(osc.restitution[0]),) * 2, "RL", zone.pattern.cycles, True)


def record(box: Box) -> dict[str, Any]:
    """A box as an item of a certificate, with the reason if it is undecided."""
    spans = {name: [str(low), str(high)] for name, (low, high) in box.span.items()}
    verdicts = {name: getattr(box, name) for name in ("exists", "admissible", "stable")}
    if box.exists is False:
        # nothing is stated about motions outside the window
        verdicts |= {"admissible": None, "stable": None}
    reason = "" if decision(vars(box)) is not None else box.reason
    return {"parameters": spans} | verdicts | {"reason": reason}


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
    plane = Window(family, facing, box, window, tolerance)
    found, waiting, done = [], [box], 0.0
    while waiting:
        box = waiting.pop()
        left, right = box.span["r"]
        if right - left > WIDEST:
            waiting += halves(box, "r")[::-1]
            continue
        if box.depth == 0:
            waiting += plane.cut(box)[::-1]
            continue
        conditions = judge_in_zone(family, box, facing, plane)
        if decision(vars(box)) is None:
            parts = None
            if conditions and all(is_sharp(one) for one in conditions[:3]):
                parts = strips(box, conditions, plane)
                if parts is not None and not settle(family, parts, box, plane):
                    parts = None
            if parts is None and not plane.is_small(box):
                waiting += halves(box, plane.longest(box, conditions))[::-1]
                continue
            found += [box] if parts is None else parts
        else:
            found.append(box)
        done += share_of(box, plane.width)
        told(done)
    return found


class Window:
    """The window of a zone in one sheet, in double precision, which only determines where boxes are cut.

    Parameters
    ----------
    family : Family
    facing : int
        The sign of cos(theta).
    box : Box
        The whole sheet.
    window : (lowest, highest)
        Texts of d K/F0.
    tolerance : float
    """

    def __init__(
        self, family: Family, facing: int, box: Box, window: Sequence[str], tolerance: float
    ) -> None:
        self.facing, self.tolerance = facing, tolerance
        self.exact = [ball(text) for text in window]
        self.low, self.high = map(float, window)
        self.height = math.log(self.high / self.low)
        left, right = box.span["r"]
        self.width = float(right - left)
        xi, mu = (float(family.values[name]) for name in ("xi", "mu"))
        self.numbers = xi, mu, float(family.walls[0]), family.cycles

    def parts(self, box: Box) -> tuple[float, float]:
        """The approximate shares of the window in r and in log D that a box covers."""
        (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
        # d/A = |2 t + delta|/sqrt(1 + t^2) changes hardly more than t or 1/t
        far = max(0.5, min(abs(float(lower)), abs(float(upper)))) if lower * upper > 0 else 0.5
        return float(right - left) / self.width, 4 * float(upper - lower) / far**2 / self.height

    def is_small(self, box: Box) -> bool:
        """Whether a box is too small to be halved again, in r and log D or as a narrow strip."""
        along, across = self.parts(box)
        small = self.tolerance
        return (across < small and along < 4 * small) or along * across < small**2 / 64

    def longest(self, box: Box, conditions: Sequence[Any] | None) -> str:
        """The parameter along which to halve a box: that with the largest high-order terms in the conditions."""
        if not conditions:
            along, across = self.parts(box)
            return "r" if along > across else "tangent"
        sizes = [0.0, 0.0]
        for one in conditions[:3]:
            terms = list(zip(one.space.monomials, one.c, strict=True))
            whole = float(sum(abs(value).upper() for _, value in terms))
            for power, value in terms:
                if sum(power) > 2:
                    for k in (0, 1):
                        sizes[k] += power[k] * float(abs(value).upper()) / whole
        return "r" if sizes[0] > sizes[1] else "tangent"

    def cut(self, box: Box) -> list[Box]:
        """Parts of a box, cut where d K/F0 leaves the window."""
        (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
        cuts = {Fraction(sign * one) for one in CUTS for sign in (1, -1)}
        amplitudes, deltas = explicit(self.numbers, np.array([float(left), float(right)]))
        for limit, near in ((self.low, min), (self.high, max)):
            ends = []
            for amplitude, delta in zip(amplitudes, deltas, strict=True):
                # -facing A (2 t + delta) = limit sqrt(1 + t^2)
                size = (limit / amplitude) ** 2
                roots = np.roots([4 - size, 4 * delta, delta**2 - size])
                ends += [
                    float(t.real) for t in roots
                    if abs(t.imag) < 1e-12 and -self.facing * (2 * t.real + delta) > 0
                ]  # fmt: skip
            if len(ends) in (2, 4):
                # the side on which less of the window is lost
                ends.sort()
                for one in (ends[: len(ends) // 2], ends[len(ends) // 2 :]):
                    outer = near(one, key=lambda t: -self.facing * t)
                    cuts.add(Fraction(round(outer * 2**20), 2**20))
        inner = sorted(one for one in cuts if lower < one < upper)
        ends_ = [lower, *inner, upper]
        return [Box(box.span | {"tangent": part}, depth=1) for part in pairwise(ends_)]

    def logarithm(self, r: float, t: float) -> float:
        """log(d K/F0), cut at the ends of the window."""
        (amplitude,), (delta,) = explicit(self.numbers, np.array([r]))
        clearance = -self.facing * amplitude * (2 * t + delta) / math.hypot(1, t)
        return math.log(min(max(clearance, self.low), self.high))


def share_of(box: Box, width: float) -> float:
    """The share of a sheet, in r and theta, that a box covers."""
    (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
    turned = math.atan(float(upper)) - math.atan(float(lower))
    return float(right - left) / width * turned / (2 * math.atan(STEEPEST))


def is_sharp(condition: Any) -> bool:
    """Whether the remainder of a model is small relative to its variation, so that parts of its box can use it."""
    return bool(condition.c[0].rad() * SHARP < sum(abs(one).upper() for one in condition.c[1:]))


def strips(box: Box, conditions: Sequence[Any], plane: Window) -> list[Box] | None:
    """Parts of a box with verdicts on stability, by the models of its conditions: strips of r, each cut in the
    tangent close to the zeros of the conditions; None if the box must be halved."""
    (left, right), (lower, upper) = box.span["r"], box.span["tangent"]
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    fields = [Field(one) for one in conditions[:3]]
    if is_blurred(box, fields, plane):
        return None
    found, waiting = [], [(Fraction(-1), Fraction(1))]
    narrowest = plane.tolerance * plane.width / 8
    while waiting:
        low, high = waiting.pop()
        r = [left + (right - left) * (one + 1) / 2 for one in (low, high)]
        pieces = pieces_of(fields, float(low), float(high))
        open_, place = 0.0, float(sum(r) / 2)
        for a, b, verdict in pieces:
            if verdict is None:
                ends = [float(middle) + float(half) * one for one in (a, b)]
                logarithms = [plane.logarithm(place, t) for t in ends]
                open_ += abs(logarithms[1] - logarithms[0])
        if open_ > plane.tolerance * plane.height and r[1] - r[0] > narrowest:
            both = (low + high) / 2
            waiting += [(both, high), (low, both)]
            continue
        for a, b, verdict in pieces:
            ends_ = lower + (Fraction(a) + 1) * half, lower + (Fraction(b) + 1) * half
            part = Box({"r": (r[0], r[1]), "tangent": ends_}, exists=True, stable=verdict, depth=2)
            if verdict:
                # one point decides if no multiplier crosses the unit circle
                at = [ball((low + high) / 2), ball(Fraction(a + b) / 2)]
                part.stable = inside([value(one, at) for one in conditions[3:7]] + [1])
            part.reason = NEAR_CIRCLE if part.stable is None else ""
            found.append(part)
    return found


def is_blurred(box: Box, fields: Sequence[Field], plane: Window) -> bool:
    """Whether the remainders of models are too large to locate the ends of stability within the tolerance."""
    (left, right), (lower, upper) = (tuple(map(float, box.span[name])) for name in ("r", "tangent"))
    for one in fields:
        others = [other for other in fields if other is not one]
        for s in (-1.0, 0.0, 1.0):
            for t, by in one.zeros(s):
                if abs(t) > 1 or any(other.at(s, t) < -other.error for other in others):
                    continue
                r = left + (right - left) * (s + 1) / 2
                ends = [lower + (upper - lower) * (t + turn * by + 1) / 2 for turn in (1, -1)]
                apart = plane.logarithm(r, ends[0]) - plane.logarithm(r, ends[1])
                if abs(apart) > BLUR * plane.tolerance * plane.height:
                    return True
    return False


def value(model: Any, at: Sequence[Any]) -> Any:
    """The value of a model at a point."""
    found = flint().arb(0)
    for (i, j), one in zip(model.space.monomials, model.c, strict=True):
        found = found + one * at[0] ** i * at[1] ** j
    return found


class Field:
    """A model of r and the tangent, each in [-1, 1], as polynomials of the tangent."""

    def __init__(self, model: Any) -> None:
        self.degree = model.space.degree
        zero = flint().arb(0)
        self.c = [[zero] * (self.degree + 1) for _ in range(self.degree + 1)]
        for (i, j), one in zip(model.space.monomials, model.c, strict=True):
            self.c[j][i] = one
        self.doubles = np.array([[float(one.mid()) for one in row] for row in self.c])
        self.error = float(model.c[0].rad())

    def strip(self, low: float, high: float) -> tuple[Any, Any, Any]:
        """At the middle of an interval of r, with the derivative by the tangent, and the change on it."""
        module = flint()
        middle, half = (low + high) / 2, (high - low) / 2
        s, around = module.arb(middle), module.arb(middle, half)
        rows = [module.arb_poly(row) for row in self.c]
        thin = module.arb_poly([row(s) for row in rows])
        change = module.arb_poly([row.derivative()(around) * module.arb(0, half) for row in rows])
        return thin, thin.derivative(), change

    def at(self, s: float, t: float) -> float:
        """The approximate value at a point."""
        powers = np.arange(self.degree + 1)
        return float(t**powers @ self.doubles @ s**powers)

    def zeros(self, s: float) -> list[tuple[float, float]]:
        """Zeros in the tangent at a value of r, with the distance within which they are known."""
        row = self.doubles @ s ** np.arange(self.degree + 1)
        # negligible terms of high degree spoil the accuracy of the others
        kept = np.where(np.abs(row) > 1e-12 * np.abs(row).max(), row, 0.0)
        roots = np.roots(kept[::-1])
        value, slope = (np.polynomial.Polynomial(row).deriv(k) for k in (0, 1))
        found = []
        for t in roots[np.abs(roots.imag) < 1e-9].real.tolist():
            if abs(t) <= 1.1:
                steep = max(abs(float(slope(t))), 1e-300)
                by = min(1.0, (2 * self.error + abs(float(value(t)))) / steep)
                found.append((t, by + 1e-9))
        return sorted(found)


def pieces_of(
    fields: Sequence[Field], low: float, high: float
) -> list[tuple[float, float, bool | None]]:
    """Intervals of the tangent in a strip of r: True where all conditions are positive, False where one is
    negative."""
    clusters, hints = [], set()
    for one in fields:
        rows = [one.zeros(s) for s in (low, (low + high) / 2, high)]
        if len({len(row) for row in rows}) == 1:
            for group in zip(*rows, strict=True):
                near, far = min(t for t, _ in group), max(t for t, _ in group)
                beside = max(by for _, by in group) + BESIDE * (far - near)
                clusters.append((near - beside, far + beside))
        else:
            # zeros begin or end in the strip
            hints |= {t for row in rows for t, _ in row}
    ends = hints.union(*clusters)
    places = [-1.0, *sorted(one for one in ends if -1 < one < 1), 1.0]
    lines = [one.strip(low, high) for one in fields]
    arb = flint().arb
    found: list[tuple[float, float, bool | None]] = []
    waiting = [(*pair, 0) for pair in pairwise(places)][::-1]
    while waiting:
        a, b, depth = waiting.pop()
        middle = (a + b) / 2
        t = arb(middle)
        spread = arb(0, max(b - middle, middle - a) * (1 + 2.0**-50))
        signs = []
        for thin, slope, change in lines:
            whole = thin(t) + slope(t + spread) * spread + change(t + spread)
            signs.append(1 if whole > 0 else -1 if whole < 0 else 0)
        verdict = False if -1 in signs else True if signs == [1] * 3 else None
        crossed = any(near <= middle <= far for near, far in clusters)
        if verdict is None and not crossed and depth < MOST_HALVINGS and b - a > NARROWEST:
            waiting += [(middle, b, depth + 1), (a, middle, depth + 1)]
            continue
        if found and found[-1][2] is verdict:
            found[-1] = (found[-1][0], b, verdict)
        else:
            found.append((a, b, verdict))
    return found


def settle(family: Family, parts: Sequence[Box], box: Box, plane: Window) -> bool:
    """Whether admissibility is decided in the parts of a box that may be stable."""
    open_ = [part for part in parts if part.stable is not False]
    if not open_:
        return True
    ends = [part.span["tangent"] for part in open_]
    hull = min(low for low, _ in ends), max(high for _, high in ends)
    whole = Box(box.span | {"tangent": hull})
    judge_in_zone(family, whole, plane.facing, plane, walls=True)
    if whole.exists is not False and whole.admissible is None:
        return False
    for part in open_:
        part.exists, part.admissible = whole.exists, whole.admissible
    return True


def halves(box: Box, name: str) -> list[Box]:
    """Both halves along a parameter."""
    low, high = box.span[name]
    middle = (low + high) / 2
    return [Box(box.span | {name: part}) for part in ((low, middle), (middle, high))]


def judge_in_zone(
    family: Family, box: Box, facing: int, plane: Window, walls: bool = False
) -> list[Any] | None:
    """The verdicts on the motions of a box whose clearance lies in the window; with `walls`, on admissibility
    only.

    Where stability is undecided, return the conditions of stability and the polynomial.
    """
    tangent = max(abs(float(end)) for end in box.span["tangent"])
    box.start, sizes = np.zeros(4), np.full(4, 1 + tangent)
    try:
        problem = Problem(family, box, facing)
        if not enclose(problem, box, sizes):
            box.reason = "the linear equations may be singular in the box"
            return None
        assert box.centre is not None
        system, states = problem.states(problem.system, problem.models(box.centre, box.error))
        amplitude = scale(family, *(problem.box_values[name] for name in ("r", "tangent")))
        clearance = span(system.clearance) * amplitude
        if clearance < plane.exact[0] or clearance > plane.exact[1]:
            box.exists = False
            return None
        found = flights(system, states)
        speed = span(found[0].after * (found[0].start[3] - found[0].v))
        box.reason = NO_SPEED
        if speed < 0:
            box.admissible = False
        if not speed > 0:
            return None
        if walls:
            box.admissible, _, box.reason = between_walls(system, found)
            return None
        polynomial = characteristic(period_map(system, found), determinant(system))
        box.stable, box.reason = inside_all(polynomial), NEAR_CIRCLE
        if box.stable:
            box.admissible, _, box.reason = between_walls(system, found)
        if box.stable is None:
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


def explicit(numbers: tuple[float, float, float, int], r: _Array) -> tuple[_Array, _Array]:
    """A, and delta in d/A = -(2 t + delta) cos(theta), at values of r, of xi, mu, R and the load cycles."""
    xi, mu, R, cycles = numbers
    eta, tau = math.sqrt(1 - xi * xi), math.pi * cycles / r
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
    """The boxes of a certificate of a zone, as doubles."""

    def __init__(self, certificate: Certificate) -> None:
        self.certificate = certificate
        spans = [
            [float(exact(end)) for name in ("r", "tangent") for end in box["parameters"][name]]
            for box in certificate.boxes
        ]
        self.low, self.high, self.left, self.right = np.array(spans).T
        self.facing = np.array([FACINGS[box["sheet"]] for box in certificate.boxes])
        values = {True: 1, False: 0, None: -1}
        self.decisions = np.array([values[decision(box)] for box in certificate.boxes])
        self.window = [float(one) for one in certificate.system["clearance"]]
        xi, mu = (float(certificate.system[name]) for name in ("xi", "mu"))
        R = float(certificate.system["restitution"][0])
        self.numbers = xi, mu, R, certificate.cycles

    def images(self, r: float, value: int) -> _Array:
        """The intervals of d K/F0 in the window, at r, of the boxes with a decision."""
        here = (self.low <= r) & (r <= self.high) & (self.decisions == value)
        left, right, facing = self.left[here], self.right[here], self.facing[here]
        amplitude, delta = (one[0] for one in explicit(self.numbers, np.array([r])))

        def of(t: _Array) -> _Array:
            found: _Array = -facing * amplitude * (2 * t + delta) / np.hypot(1, t)
            return found

        turn = np.full_like(left, 2 / delta if delta else np.inf)
        ends = [of(left), of(right), of(np.clip(turn, left, right))]
        both = np.stack([np.minimum.reduce(ends), np.maximum.reduce(ends)], axis=1)
        if value < 0:
            # the part beyond the steepest tangent is not decided
            edge = [abs(2 * t + delta) / math.hypot(1, t) for t in (STEEPEST, -STEEPEST)] + [2.0]
            if abs(delta) * STEEPEST < 2:  # the extremum is there too
                edge.append(math.hypot(2, delta))
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
        """Proven and undecided intervals on lines of constant r."""
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


#: The least relative distance of a clearance from the edge of an image, far above rounding in `explicit`.
MARGIN = 1e-9


def union(intervals: _Array) -> _Array:
    """The union of intervals, as disjoint intervals in order."""
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
