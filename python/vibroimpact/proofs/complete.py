"""Proofs that a list of motions is complete for some words at a point, by a search of times between impacts."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..base import checks
from ..base.errors import ParameterError
from ..base.progress import with_progress
from ..systems.oscillator import Oscillator, Point
from ..systems.verbs import physical_arguments
from .balls import ball, decimal, flint
from .boxes import PARAMETERS, Family
from .certificate import Certificate
from .gaps import Word
from .prove import attempt, best_attempt
from .verdicts import approximate_inverse

if TYPE_CHECKING:
    from ..systems.units import Value

__all__ = ["prove_all"]

#: The largest numbers of impacts and load cycles that `prove_all` accepts.
MOST_IMPACTS, MOST_CYCLES = 3, 4
#: Sizes of boxes around a solution in which it is the only one, as in the attempts of a proof.
SIZES = (2.0**-34, 2.0**-42)
#: The margin by which the stated undecided times exceed the boxes left undecided by the search.
MARGIN = 2.0**-20
#: Why a box of times is not decided.
NOT_EXCLUDED = "other motions are not excluded (near a fold, pitchfork or graze)"
#: The most boxes of a word, and the width, as a part of the period, below which a box is abandoned.
MOST_BOXES, NARROWEST = 20_000, 2.0**-34
#: A box that Newton's operator shrinks to less than this share is tried again before it is halved.
WORTH = 0.6
#: The factor by which the box in which a motion is sought is wider than the remainder of the searched box.
WIDER = 0.25
#: The width, as a part of the period, below which the angle theta is also searched, and the weight of 1 rad.
NEARLY, OF_ANGLE = 2.0**-7, 2.0**-8
#: The number of times that bounds of the unknowns are improved.
PASSES = 3
#: Steps of Newton's method to narrow a solution.
REFINED = 12
#: A bound of the rounding errors of linear equations solved in doubles.
SLACK, TINY = 1 + 2.0**-40, 1e-30


@overload
def prove_all(
    osc: Oscillator, r: Value, clearance: Value, max_impacts: int = 3, max_cycles: int = 1, *,
    progress: Callable[[float, str], None] | None = None,
) -> Certificate: ...  # fmt: skip
@overload
def prove_all(
    point: Point, /, max_impacts: int = 3, max_cycles: int = 1, *,
    progress: Callable[[float, str], None] | None = None,
) -> Certificate: ...  # fmt: skip


@physical_arguments  # type: ignore[misc]  # the other form
@with_progress
def prove_all(
    osc: Oscillator, r: float, clearance: float, max_impacts: int = 3, max_cycles: int = 1, *,
    progress: Callable[[float, str], None] | None = None,
) -> Certificate:  # fmt: skip
    """Find all motions of a few impacts at a point, and prove that there are no others (extra `proof`).

    Given the times between the impacts, everything else follows from linear equations. Boxes of these times are
    halved until each is proven to contain no motion, or exactly one motion, which is proven to exist.

    Parameters
    ----------
    osc : Oscillator
        With damping, and with coefficients of restitution above 0 and below 1.
    r, clearance : float
        Frequency ratio r, and clearance d K/F0.
    max_impacts : int, optional
        Impacts in a period, 2 or 3.
    max_cycles : int, optional
        Load cycles in a period, 1 to 4.
    progress : callable, optional
        Called with the fraction done and the word; by default a bar on a terminal or in a notebook.

    Returns
    -------
    Certificate
        `boxes` contains the motions. `complete` is True if no other motion of these words with an approach at each
        impact exists; if it is False, `undecided` says where there may be others.

    Raises
    ------
    ParameterError, ParameterTypeError
        If a value is not allowed.
    MissingExtraError
        If python-flint is not installed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> proof = vi.prove_all(osc, r=1.04, clearance=25.0, max_impacts=2)
    >>> proof
    <Certificate of all motions RL/1 at r = 1.04, d K/F0 = 25.0: 2, of them 1 stable and admissible; complete>
    """
    begin = time.perf_counter()
    checks.instance(osc, "osc", Oscillator)
    checks.progress(progress)
    r, clearance = checks.number(r, "r"), checks.number(clearance, "clearance")
    max_impacts = checks.integer(max_impacts, "max_impacts", 2, MOST_IMPACTS)
    max_cycles = checks.integer(max_cycles, "max_cycles", 1, MOST_CYCLES)
    if not (osc.xi > 0 and osc.mu > 0 and all(0 < R < 1 for R in osc.restitution)):
        raise ParameterError(
            f"osc = {osc!r}: must have xi, mu and R1, R2 above 0, and R1, R2 below 1, for a proof of all motions"
        )
    numbers = (osc.xi, osc.mu, r, clearance, 1.0)
    values = dict(zip(PARAMETERS, map(decimal, numbers), strict=True))
    walls = dict(zip("RL", map(decimal, osc.restitution), strict=True))
    words = words_of(max_impacts, max_cycles)
    sheets: list[dict[str, Any]] = []
    boxes: list[dict[str, Any]] = []
    undecided: list[dict[str, Any]] = []
    for number, (sides, cycles) in enumerate(words):
        name = f"{sides}/{cycles}"

        def told(share: float, number: int = number, name: str = name) -> None:
            if progress is not None:
                progress((number + share) / len(words), name)

        family = Family(values, tuple(walls[side] for side in sides), sides, cycles, False)
        with flint().ctx.workprec(64):
            found, gaps = motions_of(family, told)
        sheets.append({"sides": sides, "cycles": cycles})
        boxes += [{**box, "sheet": number} for box, _ in found]
        undecided += [{"reason": f"{name}: {reason}"} for _, reason in found if reason]
        undecided += [
            {"reason": f"{name}: {NOT_EXCLUDED}", "sheet": number, "times": gap} for gap in gaps
        ]
    return Certificate(
        "all", ", ".join(sides for sides, _ in words), max_cycles, False,
        {**values, "restitution": list(walls.values())}, sheets, boxes, undecided, time.perf_counter() - begin,
    )  # fmt: skip


def words_of(impacts: int, cycles: int) -> list[tuple[str, int]]:
    """Words of impacts on both walls, each with the impacts on the right first, and their load cycles."""
    words = ["".join(word) for n in range(2, impacts + 1) for word in product("RL", repeat=n)]
    first = [word for word in words if len(set(word)) == 2 and word == max(rotations(word))]
    return [(word, k) for k in range(1, cycles + 1) for word in first]


def rotations(word: str) -> list[str]:
    """The rotations of a word, which start at each of its impacts."""
    return [word[k:] + word[:k] for k in range(len(word))]


def motions_of(
    family: Family, told: Callable[[float], None]
) -> tuple[list[tuple[dict[str, Any], str]], list[list[list[str]]]]:
    """The boxes of a certificate of all motions of a word, with reasons, and times that may have others."""
    signs = [1 if side == "R" else -1 for side in family.sides]
    xi, mu, r, clearance, load = (ball(family.values[name]) for name in PARAMETERS)
    walls = [ball(text) for text in family.walls]
    word = Word(signs, family.cycles, xi, mu, r, clearance, load, walls)
    result = search(word, told)
    motions: list[tuple[dict[str, Any], str]] = []
    known: list[dict[str, Any]] = []
    gaps = [texts_of(box[: word.n - 1]) for box in result.open]
    for one in result.found:
        states = word.states(one.times, one.values)
        if any(within(states, rough) for rough in known):
            continue
        middles = np.array([[float(value.mid()) for value in row] for row in states])
        box, reason = best_attempt(family, middles)
        rough = next(filter(None, (around(family, middles, size) for size in SIZES)), box)
        if (
            box
            and within(states, rough)
            and (box["radius"] == rough["radius"] or within(box_states(box), rough))
        ):
            motions.append((box, reason))
            known.append(rough)
        else:
            gaps.append(texts_of(one.times))
    return motions, gaps


def around(family: Family, states: Any, size: float) -> dict[str, Any]:
    """A box of a certificate of a given size around some states; empty if nothing is proven."""
    box, _ = attempt(family.system({}), states, size, False)
    return box


def box_states(box: dict[str, Any]) -> list[list[Any]]:
    """The balls in which a certificate states that there is only one motion."""
    arb = flint().arb
    return [
        [ball(middle) + arb(0, 1) * ball(size) for (middle,), size in zip(*row, strict=True)]
        for row in zip(box["centre"], box["radius"], strict=True)
    ]


def within(states: Sequence[Sequence[Any]], box: dict[str, Any]) -> bool:
    """Whether states lie where a certificate states that there is only one motion."""
    turn = 2 * flint().arb.pi()
    for k, (row, centre, radius) in enumerate(
        zip(states, box["centre"], box["radius"], strict=True)
    ):
        for i, (value, (middle,), size) in enumerate(zip(row, centre, radius, strict=True)):
            apart = value - ball(middle)
            if k == i == 0:
                turns = turn * round(float(apart.mid() / turn))
            if not abs(apart - (turns if i == 0 else 0)) <= ball(size):
                return False
    return True


def texts_of(times: Sequence[Any]) -> list[list[str]]:
    """Intervals around balls as exact texts, wide enough to contain those of another search."""
    margin = Fraction(MARGIN)
    ends = (map(Fraction, ends_of(one)) for one in times)
    return [[str(low - margin), str(high + margin)] for low, high in ends]


@dataclass
class Found:
    """A solution: the parts of the period between its impacts, and W, p, q."""

    times: list[Any]
    values: list[Any]


@dataclass
class Search:
    """The results of a search over all times of a word.

    Attributes
    ----------
    found : list of Found
    open : list
        Boxes of times that are undecided.
    boxes : int
    """

    found: list[Found] = field(default_factory=list)
    open: list[list[Any]] = field(default_factory=list)
    boxes: int = 0


def search(word: Word, told: Callable[[float], None] | None = None) -> Search:
    """All motions of a word that approach the wall at each impact."""
    result, done = Search(), 0.0
    module = flint()
    waiting = [([module.arb(0).union(module.arb(1))] * (word.n - 1), 1.0)]
    while waiting:
        box, share = waiting.pop()
        result.boxes += 1
        left, singular = reduced(word, box, result.found)
        if left is not None:
            widths = [float(2 * one.rad()) for one in left]
            if len(left) == word.n:
                widths[-1] *= OF_ANGLE
            elif singular and max(widths) < NEARLY:
                # the angle is also searched
                left.append(module.arb(0, 1) * module.arb.pi())
                widths.append(1.0)
            if result.boxes < MOST_BOXES and max(widths) > NARROWEST:
                waiting += [(half, share / 2) for half in halves(left, int(np.argmax(widths)))]
                continue
            result.open.append(left)
        done += share
        if told is not None:
            told(done)
    return result


def halves(box: Sequence[Any], place: int) -> list[list[Any]]:
    """Both halves of a box."""
    arb = flint().arb
    low, high = (arb(one) for one in ends_of(box[place]))
    middle = arb(float(box[place].mid()))
    return [
        [part if k == place else one for k, one in enumerate(box)]
        for part in (middle.union(high), low.union(middle))
    ]


def ends_of(ball: Any) -> tuple[float, float]:
    """Doubles outside the ends of a ball."""
    low, high = float(ball.lower()), float(ball.upper())
    return float(np.nextafter(low, -np.inf)), float(np.nextafter(high, np.inf))


def reduced(word: Word, box: list[Any], found: list[Found]) -> tuple[list[Any] | None, bool]:
    """The part of a box that contains all of its motions not found so far, and whether the linear equations may be
    singular in this part; None if there are no such motions.

    Motions that are found are added to the search.
    """
    while True:
        if not possible(word, box):
            return None, False
        values = linear(word, box)
        if values is NONE:
            return None, False
        if values is None:
            return box, True
        shrunk = newton(word, box, values)
        if shrunk is NONE:
            return None, False
        if shrunk is None:
            return box, False
        before, box = box, shrunk.left
        if shrunk.regular and settle(word, box, found):
            return None, False
        pairs = zip(box, before, strict=True)
        if max(float(new.rad()) / float(old.rad()) for new, old in pairs) > WORTH:
            return box, False


def settle(word: Word, box: list[Any], found: list[Found]) -> bool:
    """Whether the only motion in a box has been found, or none exists; a motion that is found is added."""
    arb = flint().arb
    wide = [one + arb(0, 1) * (one.rad() * WIDER) for one in box]
    values = linear(word, wide)
    if values is None or values is NONE:
        return values is NONE
    shrunk = newton(word, wide, values)
    if shrunk is None or shrunk is NONE:
        return shrunk is NONE
    if not shrunk.regular:
        return False
    # the box contains at most one solution
    if any(holds(wide, one) for one in found):
        return True
    if not shrunk.inner:
        return False
    one = narrowed(word, shrunk.left, values)
    if one is not None:
        found.append(one)
    return True


def narrowed(word: Word, times: list[Any], values: list[Any]) -> Found | None:
    """A solution in a box, as narrow as the precision allows; None if an impact occurs from the wrong side."""
    for _ in range(REFINED):
        inside = linear(word, times)
        if inside is NONE:
            return None
        if inside is None:
            break
        values = inside
        shrunk = newton(word, times, values)
        if shrunk is NONE:
            return None
        if shrunk is None:
            break
        times, values = shrunk.left, shrunk.values
    return Found(times[: word.n - 1], values)


def holds(box: Sequence[Any], one: Found) -> bool:
    """Whether a solution lies in a box."""
    parts = zip(box, one.times, strict=False)
    if not all(wide.contains(part) for wide, part in parts):
        return False
    if len(box) == len(one.times):
        return True
    angle = flint().arb.atan2(*one.values[-2:])
    turns = (angle + 2 * flint().arb.pi() * k for k in (-1, 0, 1))
    return any(box[-1].contains(turn) for turn in turns)


#: The result where a box contains no motion.
NONE: Any = object()


def possible(word: Word, box: Sequence[Any]) -> bool:
    """Whether flights may have these times: positive, and long enough for those from wall to wall."""
    times = box[: word.n - 1]
    last = 1 - sum(times[1:], times[0])
    for k, part in enumerate([*times, last]):
        other = word.signs[k] != word.signs[(k + 1) % word.n]
        if part < (word.shortest if other else 0):
            return False
    return True


def linear(word: Word, box: Sequence[Any]) -> Any:
    """Enclosures of W, p, q for all times of a box; None if the equations may be singular, NONE if they
    contradict each other."""
    module = flint()
    times = box[: word.n - 1]
    middle = [module.arb(one.mid()) for one in times]
    spread = [one - place for one, place in zip(times, middle, strict=True)]
    thin, wide = word.equations(middle), word.equations(times)
    size = word.n + 2
    given: list[Any] = []
    if len(box) == word.n:
        # p and q are known and are moved to the right-hand side
        size, given = word.n, [*box[-1].sin_cos()]
    matrix = np.array([[float(one.mid()) for one in row[:size]] for row in thin.matrix.tolist()])
    if not np.all(np.isfinite(matrix)):
        return None
    q, r = np.linalg.qr(matrix, mode="complete")
    inverse = q.T
    try:
        inverse[:size] = np.linalg.solve(r[:size], inverse[:size])
    except np.linalg.LinAlgError:
        return None
    inverse = module.arb_mat(inverse.tolist())
    moved = inverse * thin.matrix
    for slope, part in zip(wide.slopes, spread, strict=True):
        moved = moved + inverse * slope * part
    rows = moved.tolist()
    right = (inverse * thin.right).entries()
    if given:
        right = [
            one - row[size] * given[0] - row[size + 1] * given[1]
            for one, row in zip(right, rows, strict=True)
        ]
    beyond = [
        [one - int(i == j) for j, one in enumerate(row[:size])] for i, row in enumerate(rows[:size])
    ]
    bound = fixed_bound(beyond, right[:size])
    if bound is None:
        return None
    values = [module.arb(0, 1) * one for one in bound]
    if not given:
        for place in (-2, -1):
            values[place] = cut(values[place], module.arb(0, 1))
    for _ in range(PASSES):
        for i, row in enumerate(beyond):
            values[i] = cut(values[i], right[i] - dot(row, values))
            if values[i] is None:
                return NONE
    rest = zip(rows[size:], right[size:], strict=True)
    if not all((dot(row[:size], values) - own).contains(0) for row, own in rest):
        return NONE
    values += given
    p, q = values[-2:]
    if not (p * p + q * q).contains(1):
        return NONE
    for i, side in enumerate(word.signs):
        if side * (values[(i - 1) % word.n] - values[i]) < 0:
            return NONE
    return values


def dot(one: Sequence[Any], two: Sequence[Any]) -> Any:
    """The product of vectors."""
    return sum((a * b for a, b in zip(one, two, strict=True)), flint().arb(0))


def fixed_bound(matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any] | None:
    """A bound of |y| for all y = right - matrix y; None if there may be no bound.

    Since |y| <= |right| + |matrix| |y|, a bound that exceeds |right| + |matrix| bound suffices: the spectral
    radius of |matrix| is then below 1, and |y| <= bound.
    """
    module = flint()
    sizes = [[abs(one).upper() for one in row] for row in matrix]
    doubles = np.array([[float(one) for one in row] for row in sizes])
    top = np.array([float(abs(one).upper()) for one in right])
    if not np.all(np.isfinite(doubles)):
        return None
    try:
        bound = np.linalg.solve(np.eye(len(top)) - doubles * SLACK, top * SLACK + TINY)
    except np.linalg.LinAlgError:
        return None
    if not np.all(bound > 0):
        return None
    stated = [module.arb(one) for one in bound.tolist()]
    rows = zip(sizes, right, stated, strict=True)
    if not all(abs(own).upper() + dot(row, stated) < limit for row, own, limit in rows):
        return None
    return stated


def cut(one: Any, two: Any) -> Any:
    """A ball around the intersection of two balls; None if it is empty."""
    return one.intersection(two) if one.overlaps(two) else None


@dataclass
class Step:
    """The result of Newton's operator on a box: the part that is left, whether it lies inside the box, and whether
    the derivative is regular in the box."""

    left: list[Any]
    values: list[Any]
    inner: bool
    regular: bool


def newton(word: Word, box: Sequence[Any], values: Sequence[Any]) -> Any:
    """Krawczyk's operator for the variables of a box and the other unknowns; None where the derivative may be
    singular, NONE if there is no solution."""
    module = flint()
    n, times = word.n, word.n - 1
    wide = word.equations(box[:times])
    column = module.arb_mat([[one] for one in values])
    along = [(slope * column).entries() for slope in wide.slopes]
    p, q = values[-2:]
    rows = []
    for i, row in enumerate(wide.matrix.tolist()):
        turned = [q * row[n] - p * row[n + 1]] if len(box) == n else row[n:]
        rows.append([*(part[i] for part in along), *row[:n], *turned])
    centre = [module.arb(one.mid()) for one in box[:times]]
    known = [module.arb(one.mid()) for one in values]
    unknowns, last = [*box[:times], *values], [*centre, *known]
    if len(box) == n:
        unknowns[-2:], last[-2:] = [box[-1]], [module.arb(box[-1].mid())]
        known[-2:] = last[-1].sin_cos()
    else:
        rows.append([module.arb(0)] * (times + n) + [2 * p, 2 * q])
    thin = word.equations(centre)
    left = (thin.matrix * module.arb_mat([[one] for one in known]) - thin.right).entries()
    if len(box) < n:
        left.append(known[-2] * known[-2] + known[-1] * known[-1] - 1)
    derivative = module.arb_mat(rows)
    try:
        inverse = approximate_inverse(derivative)
    except (np.linalg.LinAlgError, ValueError):
        return None
    size = len(rows)
    identity = module.arb_mat(size, size, [int(k % (size + 1) == 0) for k in range(size * size)])
    rest = identity - inverse * derivative
    spread = [[one - two] for one, two in zip(unknowns, last, strict=True)]
    shift = rest * module.arb_mat(spread) - inverse * module.arb_mat([[one] for one in left])
    image = [one + two for one, two in zip(last, shift.entries(), strict=True)]
    new = [cut(one, two) for one, two in zip(unknowns, image, strict=True)]
    if None in new:
        return NONE
    inner = all(one.contains_interior(two) for one, two in zip(unknowns, image, strict=True))
    regular = inner or fixed_bound(rest.tolist(), [module.arb(1)] * size) is not None
    kept = new[:times] + (new[-1:] if len(box) == n else [])
    own = new[times:] if len(box) < n else [*new[times:-1], *new[-1].sin_cos()]
    return Step(kept, own, inner, regular)
