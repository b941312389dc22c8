"""Sketches of systems: masses, spring, dashpot, load, walls and clearance, or the bodies of a structure."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import NoneType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, ParameterTypeError
from ..systems.oscillator import Oscillator, Point
from ..systems.record import Record
from ..systems.structure import Friction, Gap, Load, Stop, Structure, moves, opening_at
from ..systems.units import MASS as MASS_UNIT
from ..systems.units import SI, units_to_show
from .style import FREE, IMPACT, LOAD, PRIMARY, SETTINGS, Scales, given, pyplot
from .style import system as parameters_of

__all__ = ["bodies_of", "draw_sketch", "draw_system"]

#: The note on units in a sketch of a structure with physical units.
SKETCH_UNITS = "numbers in the picture: in kg, N/m, N s/m, m, m/s and N"
#: Printed points per unit of length above which labels have their full size.
FULL_SIZE = 22.0
#: Left and right end of M, of its slot, and of m; then their bottom and top (arbitrary unit).
BODY, SLOT, MASS = ((2.6, 8.2, 0.0, 3.0), (3.4, 7.4, 0.8, 2.2), (4.8, 6.0, 0.85, 1.75))
#: Largest number of bodies that are drawn; of more bodies, the first ones and the last one.
MOST, FIRST = 10, 3
#: Width and height of a body, width of one with a slot, and the distance between bodies.
WIDTH, HEIGHT, SLOTTED, DISTANCE = 1.7, 1.8, 2.9, 1.9
#: Heights of springs, gaps and dashpots between bodies.
UPPER, MIDDLE, LOWER = 1.5, 0.92, 0.34
#: Width of a gap beside a body.
GAP = 1.4


def draw_system(
    system: Oscillator | Point | Structure | None = None, load: Load | Record | None = None, ax: Any = None
) -> Any:  # fmt: skip
    """Draw an oscillator, or a structure with its load.

    For an oscillator: the primary mass M on its spring K and dashpot C, the free mass m in the slot, and the
    clearance d, the whole travel of m between the walls, with d/2 on each side of its middle position.

    Parameters
    ----------
    system : Oscillator, Point or Structure, optional
        Without it, the picture shows an oscillator with symbols only. The values of an oscillator, or of an
        oscillator at a point, are listed above the picture, in its units if its M and K are known. A structure, or
        a point with friction or stops, is drawn with its bodies, springs, dashpots and gaps.
    load : Load or Record, optional
        The load on a structure.
    ax : matplotlib Axes, optional
        Without it a new figure is made.

    Returns
    -------
    Axes

    Raises
    ------
    ParameterError, ParameterTypeError
        If `system` is none of these, or a load is given with anything but a structure.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> from vibroimpact.plot import draw_system
    >>> rig = vi.Oscillator.from_dimensional(
    ...     M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=0.75, F0="6 N"
    ... )
    >>> draw_system(rig.at("19.5 Hz", "4 mm")).figure.savefig("system.svg")  # doctest: +SKIP
    """
    if not isinstance(system, (Oscillator, Point, Structure, NoneType)):
        raise ParameterTypeError(
            f"system = {system!r}: must be an Oscillator, an oscillator at a point (Oscillator.at) or a "
            f"Structure, not {type(system).__name__}; axes are given as ax=..."
        )
    if load is not None and not isinstance(system, Structure):
        raise ParameterError(f"load = {load!r}: must be left out unless system is a Structure")
    if load is not None and not isinstance(load, (Load, Record)):
        raise ParameterTypeError(
            f"load = {load!r}: must be a Load or a Record, not {type(load).__name__}"
        )
    plt, note = pyplot(), ""
    with plt.rc_context(SETTINGS):
        if ax is None:
            height = 2.5 if system is None else 2.8
            _, ax = plt.subplots(figsize=(6.2, height), layout="constrained")
        if isinstance(system, Structure):
            draw_sketch(ax, system, load)
            return ax
        if isinstance(system, Point) and (
            system._has_elements or isinstance(system.amplitude, Load)
        ):
            draw_sketch(ax, system.structure, system.load)
            known = units_to_show(system.osc) is not None
            note = f"\n{SKETCH_UNITS if known else 'numbers in the picture: in units of M, K, F0 and F0/K'}"
        else:
            _draw_support(ax)
            _draw_masses(ax)
            _draw_dimensions(ax)
            ax.set(xlim=(-0.6, 11.2), ylim=(-0.65, 4.05), aspect="equal")
            ax.set_axis_off()
        if system is not None:
            ax.set_title(values_of(system) + note, fontsize=7)
    return ax


def values_of(system: Oscillator | Point) -> str:
    """The values of an oscillator, or of one at a point, in two lines: in its units if M and K are known."""
    osc = system.osc if isinstance(system, Point) else system
    at = system if isinstance(system, Point) else None
    laws = {"R1": "$R_1$", "R2": "$R_2$"}
    first, second = given({
        name if isinstance(value, float) else laws[name]: value if isinstance(value, float) else "a law R(v)"
        for name, value in parameters_of(osc).items()
    }), ""  # fmt: skip
    if at is not None:
        amplitude = None if isinstance(at.amplitude, Load) else at.amplitude
        scales = Scales(units_to_show(osc))
        second = given(scales.given({"r": at.r, "clearance": at.clearance, "load": amplitude}))
    if osc.M is not None and osc.K is not None:
        units = osc.units(osc.F0 or 1.0)
        damping = 2 * osc.xi * math.sqrt(osc.M * osc.K)
        sizes = {
            "$M$": (osc.M, MASS_UNIT), "$m$": (osc.mu * osc.M, MASS_UNIT), "$K$": (osc.K, "K"),
            "$C$": (damping, "K/omega"),
        }  # fmt: skip
        own = [f"{name} = {size:.6g} {units.name(unit)}" for name, (size, unit) in sizes.items()]
        if at is None and osc.F0 is not None:
            own.append(f"$F_0$ = {osc.F0:.6g} {units.name('F0')}")
        first, second = ", ".join(own), ", ".join(filter(None, [first, second]))
    return "\n".join(filter(None, [first, second]))


def _box(ax: Any, edges: tuple[float, float, float, float], **options: Any) -> None:
    """A rectangle between two abscissas and two ordinates."""
    from matplotlib.patches import Rectangle

    left, right, bottom, top = edges
    ax.add_patch(Rectangle((left, bottom), right - left, top - bottom, lw=1.2, **options))


def _arrow(ax: Any, begin: tuple[float, float], end: tuple[float, float], **options: Any) -> None:
    look = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "lw": 0.9, "color": "k", **options}
    ax.annotate("", end, begin, arrowprops=look)


def _draw_support(ax: Any) -> None:
    """The fixed wall, the ground, the spring and the dashpot."""
    left = BODY[0]
    _box(ax, (-0.3, 0.0, -0.25, 3.2), facecolor="none", edgecolor="0.5", hatch="/////")
    _box(ax, (-0.3, 9.2, -0.55, -0.25), facecolor="none", edgecolor="0.5", hatch="/////")
    for x in (3.4, 7.4):
        ax.plot(x, -0.125, "o", ms=6, mfc="w", mec="0.3", mew=0.9)
    # spring: straight ends and a zigzag
    zigzag = np.linspace(0.5, left - 0.5, 12)
    height = np.r_[0, np.tile([0.22, -0.22], 5), 0]
    ax.plot([0, *zigzag, left], 2.3 + np.r_[0, height, 0], color="k", lw=1.1)
    ax.text(left / 2, 2.66, "$K$", ha="center", va="bottom", fontsize=10)
    # dashpot: a cylinder on the side of the wall, and a piston
    cup, piston = (0.9, 1.7), 1.35
    ax.plot([0, cup[0]], [0.8, 0.8], "k", lw=1.1)
    ax.plot([cup[1], cup[0], cup[0], cup[1]], [1.1, 1.1, 0.5, 0.5], "k", lw=1.1)
    ax.plot([piston, piston], [0.58, 1.02], "k", lw=2.2)
    ax.plot([piston, left], [0.8, 0.8], "k", lw=1.1)
    ax.text(left / 2, 1.22, "$C$", ha="center", va="bottom", fontsize=10)


def _draw_masses(ax: Any) -> None:
    """The primary mass with its slot and walls, the free mass, and the load."""
    _box(ax, BODY, facecolor=PRIMARY, edgecolor="k", alpha=0.3)
    _box(ax, BODY, facecolor="none", edgecolor="k")
    _box(ax, SLOT, facecolor="w", edgecolor="k")
    for x, name, side in ((SLOT[0], "L", "right"), (SLOT[1], "R", "left")):
        ax.plot([x, x], SLOT[2:], color=IMPACT, lw=3)
        number = "$R_2$" if name == "L" else "$R_1$"
        ax.text(
            x + (-0.12 if side == "right" else 0.12),
            1.5,
            f"{name}\n{number}",
            ha=side,
            va="center",
            fontsize=8,
        )
    _box(ax, MASS, facecolor=FREE, edgecolor="k")
    ax.text(5.4, 1.3, "$m$", ha="center", va="center", fontsize=10, color="w")
    ax.text(5.4, 0.38, "$M$", ha="center", va="center", fontsize=10)
    _arrow(ax, (8.2, 0.6), (9.4, 0.6), color=LOAD, lw=1.8)
    ax.text(9.5, 0.6, r"$F_0\,\sin\,\Omega t$", ha="left", va="center", fontsize=10)


def _draw_dimensions(ax: Any) -> None:
    """The clearance on both sides of the free mass, and the displacements X and Z."""
    for x in (SLOT[0], MASS[0], MASS[1], SLOT[1]):
        ax.plot([x, x], [1.75 if x in MASS else 2.0, 2.12], color="0.4", lw=0.6)
    for low, high in ((SLOT[0], MASS[0]), (MASS[1], SLOT[1])):
        _arrow(ax, (low, 1.95), (high, 1.95), arrowstyle="<|-|>", mutation_scale=7)
        ax.text((low + high) / 2, 1.86, "$d/2$", ha="center", va="top", fontsize=9)
    ax.text(
        5.4,
        2.62,
        "$d$: whole travel of $m$ from wall to wall",
        ha="center",
        va="center",
        fontsize=8,
    )
    for x, top, base, name, colour in (
        (8.2, 3.55, 3.0, "$X$", PRIMARY), (5.4, 3.55, 3.0, "$Z$", FREE)
    ):  # fmt: skip
        ax.plot([x, x], [base + 0.1, top + 0.15], color=colour, lw=0.9)
        _arrow(ax, (x, top), (x + 0.9, top), color=colour, lw=1.4)
        ax.text(x + 1.0, top, name, ha="left", va="center", fontsize=10)


def bodies_of(structure: Structure) -> list[list[int]]:
    """The connected parts of a structure: coordinates that M, C or K couple."""
    coupled = (structure.mass != 0) | (structure.damping != 0) | (structure.stiffness != 0)
    found: list[list[int]] = []
    left = list(range(structure.coordinates))
    while left:
        body, waiting = [], [left.pop(0)]
        while waiting:
            here = waiting.pop(0)
            body.append(here)
            waiting += [i for i in left if coupled[here, i]]
            left = [i for i in left if i not in waiting]
        found.append(body)
    return found


@dataclass
class Box:
    """A drawn body: its coordinate and position, and the free masses in its slot with their walls."""

    coordinate: int
    left: float = 0.0
    inner: list[tuple[int, set[int]]] = field(default_factory=list)

    @property
    def width(self) -> float:
        return max(WIDTH, 0.4 + SLOTTED * len(self.inner)) if self.inner else WIDTH

    @property
    def right(self) -> float:
        return self.left + self.width

    @property
    def middle(self) -> float:
        return self.left + 0.5 * self.width


def has_bodies(structure: Structure) -> bool:
    """Whether the coordinates are displacements of bodies, with gaps between two of them or beside one; modal
    amplitudes are not."""
    off = structure.mass - np.diag(np.diag(structure.mass))
    ends = (sorted(gap.direction[gap.direction != 0]) for gap in structure.gaps)
    return not off.any() and all(end in ([-1], [1], [-1, 1]) for end in ends)


def draw_sketch(ax: Any, structure: Structure, load: Load | Record | None = None) -> None:
    """Draw the bodies or, if coordinates are not displacements of bodies, a block with its gaps; with units of SI
    if the structure has physical units."""
    if structure._units is not None:
        in_si = structure._units.to(SI)
        structure, load = structure._in(in_si), None if load is None else load._in(in_si)
    if has_bodies(structure):
        _draw_row(ax, structure, load, [np.flatnonzero(gap.direction) for gap in structure.gaps])
    else:
        _draw_block(ax, structure)
    ax.set_aspect("equal")
    ax.set_axis_off()


def _hosts(structure: Structure, pairs: list[NDArray[Any]]) -> dict[int, tuple[int, set[int]]]:
    """For each free mass that touches only one other body: this body, and the sides of its walls."""
    found: dict[int, tuple[int, set[int]]] = {}
    alone = [body[0] for body in bodies_of(structure) if len(body) == 1]
    for i in alone:
        if structure.stiffness[i, i] or structure.damping[i, i]:
            continue
        own = [j for j, pair in enumerate(pairs) if i in pair]
        others = {int(k) for j in own for k in pairs[j]} - {i}
        if len(others) == 1 and all(len(pairs[j]) == 2 for j in own):
            (host,) = others
            if host not in found:
                sides = {1 if structure.gaps[j].direction[i] > 0 else -1 for j in own}
                found[i] = (host, sides)
    return found


def _draw_row(
    ax: Any, structure: Structure, load: Load | Record | None, pairs: list[NDArray[Any]]
) -> None:
    hosts = _hosts(structure, pairs)
    row = [i for body in bodies_of(structure) for i in sorted(body) if i not in hosts]
    cut = len(row) > MOST
    shown = [*row[:FIRST], row[-1]] if cut else row
    boxes = {i: Box(i) for i in shown}
    for i, (host, sides) in hosts.items():
        if host in boxes:
            boxes[host].inner.append((i, sides))
    place = 0.0
    for k, each in enumerate(boxes.values()):
        if cut and k == FIRST:
            ax.text(place + 0.3, 0.5 * HEIGHT, r"$\cdots$", ha="center", va="center", fontsize=14)
            place += 1.5
        each.left = place
        place = each.right + DISTANCE
    first, last = boxes[shown[0]], boxes[shown[-1]]
    walls, below = set(), set()
    # the extent of the picture to both sides and down, and the space that loads leave above the bodies
    reach, depth, lift = [first.left, last.right], -0.3, 0.0
    stopped = any(
        len(pair) == 1 and pair[0] == last.coordinate and gap.direction[pair[0]] > 0
        for pair, gap in zip(pairs, structure.gaps, strict=True)
    )
    for box in boxes.values():
        i = box.coordinate
        for matrix, draw, letter, y in (
            (structure.stiffness, _spring, "k", UPPER), (structure.damping, _dashpot, "c", LOWER),
        ):  # fmt: skip
            ground = float(matrix[i].sum())
            if abs(ground) > 1e-12 * np.abs(matrix[i]).max(initial=0.0):
                label = rf"${letter}$ = {ground:.3g}"
                if box is first:
                    draw(ax, box.left - DISTANCE, box.left, y, label)
                    walls.add(-1)
                elif box is last and not stopped:
                    draw(ax, box.right, box.right + DISTANCE, y, label)
                    walls.add(1)
                else:
                    _to_ground(ax, box, letter, label)
                    below.add(i)
                    depth = -1.7
            for j, other in boxes.items():
                if other.left > box.left and matrix[i, j]:
                    label = rf"${letter}$ = {-matrix[i, j]:.3g}"
                    if shown.index(j) == shown.index(i) + 1:
                        draw(ax, box.right, other.left, y, label)
                    else:
                        _over(ax, box, other, label)
                        lift = 0.6
    _draw_boxes(ax, structure, boxes)
    far, posts, grounded = [], 0, below.copy()
    for pair, gap in zip(pairs, structure.gaps, strict=True):
        if any(int(k) in hosts for k in pair) or any(int(k) not in boxes for k in pair):
            continue
        if len(pair) == 1:
            own, side = boxes[int(pair[0])], int(np.sign(gap.direction[pair[0]]))
            beside = (own is last and side > 0) or (own is first and side < 0 and -1 not in walls)
            label, lines = _lines_of(gap), _lines_of(gap).count("\n")
            # below the parts on the ground, alternately on two levels
            level = -1.33 - 0.4 * (own.coordinate in grounded) - 0.75 * (posts % 2)
            posts += not beside and lines > 0
            _stop(ax, own, side, label, beside, isinstance(gap, Stop), moves(gap), level)
            if lines:
                depth = min(depth, -0.3 * (1 + lines) if beside else level - 0.25 * (1 + lines))
            reach[0] = min(reach[0], own.left - GAP * beside * (side < 0))
            reach[1] = max(reach[1], own.right + GAP * beside * (side > 0))
            if not beside:
                below.add(own.coordinate)
                depth = min(depth, -1.3)
            reach[0] = min(reach[0], own.left - 0.7 * (side < 0))
            reach[1] = max(reach[1], own.right + 0.7 * (side > 0))
        else:
            low, high = sorted((boxes[int(k)] for k in pair), key=lambda box: box.left)
            facing = bool(gap.direction[low.coordinate] > 0)
            label = _label_of(gap)
            if shown.index(high.coordinate) == shown.index(low.coordinate) + 1:
                crowded = bool(structure.damping[low.coordinate, high.coordinate])
                _between(ax, low, high, facing, label, crowded, isinstance(gap, Stop), moves(gap))
                reach[1] = max(reach[1], high.right + (1.9 if moves(gap) else 0.8) * (not facing))
                if facing and moves(gap) and isinstance(gap, Stop):
                    depth = min(depth, -0.6)
                lift = max(lift, 0.3 * (not facing))
            else:
                far.append((low, high, label + ("" if facing else " (apart)")))
    for rubbing in structure.friction:
        touched = [int(k) for k in np.flatnonzero(rubbing.direction)]
        if len(touched) == 1 and touched[0] in boxes:
            _rub(ax, boxes[touched[0]], rubbing, touched[0] in below)
            depth = min(depth, -1.7 if touched[0] in below else -1.0)
        elif len(touched) == 2 and all(k in boxes for k in touched):
            low, high = sorted((boxes[k] for k in touched), key=lambda box: box.left)
            _rub_between(ax, low, high, rubbing)
            depth = min(depth, -0.9)
        elif len(touched) == 2 and any(k in hosts for k in touched):
            _rub_in_slot(ax, boxes, hosts, touched, rubbing)
    floor = depth + 0.2 if depth < -1 else 0.0
    for k, (low, high, label) in enumerate(far, 1):
        _far(ax, low, high, floor - 0.6 * k + 0.15, label)
        depth = min(depth, floor - 0.6 * k - 0.25)
    if load is not None:
        changing = _changing(load)
        acting = changing + np.abs(load.constant)
        for i, box in boxes.items():
            # a load on a free mass in a slot is drawn beside the load on its body, as for an earthquake
            names = []
            for j in (i, *(inner for inner, _ in box.inner)):
                steady = f" = {load.constant[j]:.3g}" if not changing[j] else "$(t)$"
                if acting[j]:
                    names.append(f"$f_{{{j}}}$" + steady)
            if names:
                name = ", ".join(names)
                half = -0.55 if "= -" in names[0] else 0.55
                ax.annotate(
                    "", (box.middle + half, HEIGHT + 0.25 + lift), (box.middle - half, HEIGHT + 0.25 + lift),
                    arrowprops={"arrowstyle": "-|>", "color": LOAD, "lw": 1.3, "shrinkA": 0, "shrinkB": 0},
                )  # fmt: skip
                ax.text(
                    box.middle, HEIGHT + 0.42 + lift, name, va="bottom", ha="center", fontsize=7
                )
    if -1 in walls:
        _wall(ax, first.left - DISTANCE, -1, HEIGHT)
        reach[0] = min(reach[0], first.left - DISTANCE)
    if 1 in walls:
        _wall(ax, last.right + DISTANCE, 1, HEIGHT)
        reach[1] = max(reach[1], last.right + DISTANCE)
    ax.set_xlim(reach[0] - 0.5, reach[1] + 0.5)
    ax.set_ylim(depth, HEIGHT + 1.0 + lift)
    if cut:
        ax.text(
            0.5 * (first.left + last.right), HEIGHT + 0.75,
            f"{len(row)} bodies" + (f", {len(hosts)} free masses in their slots" if hosts else ""),
            ha="center", va="center", fontsize=7,
        )  # fmt: skip
    _fit_labels(ax)


def _fit_labels(ax: Any) -> None:
    """Reduce labels if many bodies share the width, so that they fit into their bodies."""
    place, size = ax.get_position(), ax.figure.get_size_inches()
    spans = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
    # printed points per unit of length of the sketch
    unit = 72 * min(place.width * size[0] / spans[0], place.height * size[1] / spans[1])
    for text in ax.texts:
        text.set_fontsize(max(4.0, text.get_fontsize() * min(1.0, unit / FULL_SIZE)))


def _changing(load: Load | Record) -> NDArray[np.float64]:
    """The amplitude of the time-varying part of a load, by coordinate."""
    if isinstance(load, Record):
        total: NDArray[np.float64] = np.abs(load.force).sum(0)
        return total
    both: NDArray[np.float64] = np.abs(load.sine).sum(0) + np.abs(load.cosine).sum(0)
    return both


def _draw_boxes(ax: Any, structure: Structure, boxes: dict[int, Box]) -> None:
    """The bodies with their slots and free masses."""
    from matplotlib.patches import Rectangle

    small = len(boxes) > 6
    for i, box in boxes.items():
        ax.add_patch(Rectangle((box.left, 0), box.width, HEIGHT, fc=PRIMARY, ec="none", alpha=0.3))
        ax.add_patch(Rectangle((box.left, 0), box.width, HEIGHT, fc="none", ec="k", lw=0.9))
        name = f"$m_{{{i}}}$"
        if not small:
            name += f" = {structure.mass[i, i]:.3g}"
        ax.text(
            box.middle, 0.27 if box.inner else 0.5 * HEIGHT, name, ha="center", va="center",
            fontsize=6 if box.inner else 7,
        )  # fmt: skip
        for k, (j, sides) in enumerate(box.inner):
            left = box.left + 0.2 + k * SLOTTED + 0.15
            right = left + SLOTTED - 0.3
            springs = {
                int(np.sign(gap.direction[j])): gap.stiffness
                for gap in structure.gaps if isinstance(gap, Stop) and gap.direction[j]
            }  # fmt: skip
            # the stiffness of a stop is written above the slot
            fixed = any(
                isinstance(gap, Stop) and gap.direction[j] and not moves(gap)
                for gap in structure.gaps
            )
            top = 1.5 if fixed else 1.6
            ax.add_patch(Rectangle((left, 0.55), right - left, top - 0.55, fc="w", ec="k", lw=0.7))
            # the faces that the free mass meets: a wall, or the plate of an elastic stop
            faces = {
                side: x - side * 0.3 * (side in springs) for side, x in ((-1, left), (1, right))
            }
            for side in sides:
                face = faces[side]
                ax.plot([face, face], [0.55, top], color=IMPACT, lw=2.4, solid_capstyle="butt")
                if side in springs:
                    turns = 1.3 + 0.08 * np.r_[0, np.tile([1, -1], 3), 0]
                    ax.plot(np.linspace(face, face + side * 0.3, turns.size), turns, "k", lw=0.7)
            middle = 0.5 * (left + right)
            ax.add_patch(Rectangle((middle - 0.45, 0.58), 0.9, 0.76, fc=FREE, ec="k", lw=0.7))
            ax.text(middle, 0.96, f"$m_{{{j}}}$", ha="center", va="center", color="w", fontsize=7)
            if small:
                continue
            for gap in structure.gaps:
                if gap.direction[j]:
                    side = int(np.sign(gap.direction[j]))
                    at = 0.5 * (middle + side * 0.45 + faces[side])
                    words = _opening_of(gap).replace(" to ", "\nto ")
                    _stroke(ax, faces[side], 1.7, moves(gap))
                    if isinstance(gap, Stop) and moves(gap):
                        words = f"{words}\n$k$ = {gap.stiffness:.3g}"
                        words = words.replace("\nto ", "\nto\n").replace("= ", "=\n")
                    elif isinstance(gap, Stop):
                        ax.text(
                            right if side > 0 else left, 0.5 * (top + HEIGHT), rf"$k$ = {gap.stiffness:.3g}",
                            ha="right" if side > 0 else "left", va="center", fontsize=5.5,
                        )  # fmt: skip
                    # beside the spring of a stop there is less room
                    small_one = 4.5 if isinstance(gap, Stop) and moves(gap) else 6
                    ax.text(at, 0.96, words, ha="center", va="center", fontsize=small_one)


def _spring(ax: Any, x0: float, x1: float, y: float, label: str) -> None:
    turns = np.linspace(0, 1, 12)
    height = 0.14 * np.r_[0, np.tile([1, -1], 5), 0]
    x = np.r_[x0, x0 + (x1 - x0) * (0.15 + 0.7 * turns), x1]
    ax.plot(x, y + np.r_[0, height, 0], color="k", lw=0.9)
    ax.text(0.5 * (x0 + x1), y + 0.2, label, ha="center", va="bottom", fontsize=6.5)


def _dashpot(ax: Any, x0: float, x1: float, y: float, label: str) -> None:
    cup, end, piston = (x0 + t * (x1 - x0) for t in (0.3, 0.68, 0.5))
    ax.plot([x0, cup], [y, y], "k", lw=0.9)
    ax.plot([end, cup, cup, end], [y + 0.15, y + 0.15, y - 0.15, y - 0.15], "k", lw=0.9)
    ax.plot([piston, piston], [y - 0.1, y + 0.1], "k", lw=1.6)
    ax.plot([piston, x1], [y, y], "k", lw=0.9)
    ax.annotate(
        label, (0.5 * (x0 + x1), y - 0.15), (0, -2.5), textcoords="offset points", ha="center", va="top",
        fontsize=6.5,
    )  # fmt: skip


def _to_ground(ax: Any, box: Box, letter: str, label: str) -> None:
    """A spring or dashpot from a body down to the ground."""
    x = box.middle + (-0.3 if letter == "k" else 0.3)
    if letter == "k":
        turns = np.linspace(-0.15, -0.85, 9)
        ax.plot(
            [x, *(x + 0.12 * np.r_[0, np.tile([1, -1], 3), 1, 0]), x], [0, *turns, -1], "k", lw=0.9
        )
    else:
        ax.plot([x, x], [0, -0.45], "k", lw=0.9)
        ax.plot([x - 0.1, x + 0.1], [-0.45, -0.45], "k", lw=1.6)
        ax.plot([x - 0.14, x - 0.14, x + 0.14, x + 0.14], [-0.3, -0.65, -0.65, -0.3], "k", lw=0.9)
        ax.plot([x, x], [-0.65, -1], "k", lw=0.9)
    side = -0.45 if letter == "k" else 0.45
    ax.text(box.middle + side, -1.33, label, ha="center", va="top", fontsize=6)
    _floor(ax, box.left, box.right)


def _over(ax: Any, low: Box, high: Box, label: str) -> None:
    """A link between bodies that are not neighbours."""
    y = HEIGHT + 0.35
    ax.plot(
        [low.middle, low.middle, high.middle, high.middle], [HEIGHT, y, y, HEIGHT], "0.4", lw=0.8
    )
    ax.text(0.5 * (low.middle + high.middle), y + 0.05, label, ha="center", va="bottom", fontsize=6)


def _wall(ax: Any, x: float, side: int, height: float) -> None:
    """A fixed wall that faces the bodies."""
    from matplotlib.patches import Rectangle

    left = x if side > 0 else x - 0.3
    ax.add_patch(
        Rectangle((left, -0.2), 0.3, height + 0.4, fc="none", ec="0.5", lw=0.0, hatch="//////")
    )
    ax.plot([x, x], [-0.2, height + 0.2], color="k", lw=1.0)


def _opening_of(gap: Gap | Stop) -> str:
    """The opening as a text; for a moving wall, its least and greatest value."""
    if not moves(gap):
        return f"{gap.opening:.3g}"
    values = opening_at(gap, np.linspace(0, 2 * np.pi, 1441), 1.0)
    return f"{values.min():.3g} to {values.max():.3g}"


def _stroke(ax: Any, x: float, y: float, moving: bool) -> None:
    """A double arrow at the face of a wall, if it moves."""
    if moving:
        look = {"arrowstyle": "<|-|>", "mutation_scale": 6, "lw": 1.0, "color": IMPACT}
        _arrow(ax, (x - 0.28, y), (x + 0.28, y), **look)


def _label_of(gap: Gap | Stop) -> str:
    """The opening of a gap, and the stiffness of an elastic stop."""
    label = rf"$e$ = {_opening_of(gap)}"
    return label + rf", $k$ = {gap.stiffness:.3g}" if isinstance(gap, Stop) else label


def _lines_of(gap: Gap | Stop) -> str:
    """The same label in short lines if the two openings of a moving wall make it long."""
    return (
        _label_of(gap).replace(" to ", "\nto ").replace(", ", "\n")
        if moves(gap)
        else _label_of(gap)
    )


def _hatched(ax: Any, x0: float, x1: float, y0: float, y1: float) -> None:
    """Two surfaces that rub on each other."""
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fc="w", ec="k", lw=0.6, hatch="xxxxxxx"))


def _friction_of(rubbing: Friction) -> str:
    words = rf"$f$ = {rubbing.slip:.3g}"
    return words + (f" to {rubbing.stick:.3g}" if rubbing.stick > rubbing.slip else "")


def _rub(ax: Any, box: Box, rubbing: Friction, low: bool) -> None:
    """Friction of a body on the ground or on a moving belt, beside other parts below the body."""
    x0, x1 = (box.left + 0.08, box.left + 0.48) if low else (box.left + 0.3, box.right - 0.3)
    bottom = -1.0 if low else -0.2
    if low:
        ax.plot([0.5 * (x0 + x1)] * 2, [0, bottom + 0.2], color="k", lw=2.2)
    _hatched(ax, x0, x1, bottom, bottom + 0.2)
    if low:
        _floor(ax, box.left, box.right)
    else:
        ax.plot([box.left, box.right], [bottom, bottom], color="k", lw=1.0)
    words = _friction_of(rubbing)
    if rubbing.speed:
        words += rf", belt at {rubbing.speed:.3g}"
        way = float(np.copysign(0.5, rubbing.speed))
        _arrow(ax, (box.middle - way, bottom - 0.15), (box.middle + way, bottom - 0.15))
    ax.text(box.middle, bottom - 0.33, words, ha="center", va="top", fontsize=6)


def _rub_between(ax: Any, low: Box, high: Box, rubbing: Friction) -> None:
    """Friction between two bodies: a plate of the left one under the right one."""
    y = -0.2
    ax.plot([low.middle, low.middle, high.middle + 0.4], [0, y, y], color="k", lw=1.2)
    _hatched(ax, high.middle - 0.4, high.middle + 0.4, y, 0.0)
    ax.text(
        0.5 * (low.middle + high.middle), y - 0.1, _friction_of(rubbing), ha="center", va="top", fontsize=6
    )  # fmt: skip


def _rub_in_slot(
    ax: Any, boxes: dict[int, Box], hosts: dict[int, tuple[int, set[int]]], touched: list[int], rubbing: Friction
) -> None:  # fmt: skip
    """Friction of a free mass in its slot."""
    for inner, host in (touched, touched[::-1]):
        if inner in hosts and hosts[inner][0] == host and host in boxes:
            box = boxes[host]
            k = [j for j, _ in box.inner].index(inner)
            middle = box.left + 0.2 + (k + 0.5) * SLOTTED
            _hatched(ax, middle - 0.45, middle + 0.45, 0.5, 0.6)
            ax.text(
                box.right - 0.1, 0.06, _friction_of(rubbing), ha="right", va="bottom", fontsize=5
            )


def _floor(ax: Any, x0: float, x1: float) -> None:
    from matplotlib.patches import Rectangle

    ax.add_patch(Rectangle((x0, -1.25), x1 - x0, 0.25, fc="none", ec="0.5", lw=0.0, hatch="//////"))
    ax.plot([x0, x1], [-1, -1], color="k", lw=1.0)


def _opening(ax: Any, x0: float, x1: float, y: float, label: str, below: bool = True) -> None:
    """The dimension of a gap."""
    ax.annotate(
        "", (x1, y), (x0, y),
        arrowprops={"arrowstyle": "<|-|>", "mutation_scale": 5, "lw": 0.6, "color": "k", "shrinkA": 0,
                    "shrinkB": 0},
    )  # fmt: skip
    ax.text(
        0.5 * (x0 + x1), y + (-0.1 if below else 0.08), label, ha="center", va="top" if below else "bottom",
        fontsize=6.5,
    )  # fmt: skip


def _stop(
    ax: Any, box: Box, side: int, label: str, alone: bool, elastic: bool, moving: bool, level: float
) -> None:  # fmt: skip
    """A fixed stop: a wall beside the last body, or a post on the ground below a lug of the body; an elastic one
    is a plate on a spring."""
    if alone:
        face = box.right if side > 0 else box.left
        wall = face + side * GAP
        x = wall - side * 0.6 * elastic
        _wall(ax, wall, side, HEIGHT)
        _stroke(ax, wall, HEIGHT + 0.4, moving)
        ax.plot([x, x], [0.0, HEIGHT], color=IMPACT, lw=2.6, solid_capstyle="butt")
        if elastic:
            _spring(ax, min(x, wall), max(x, wall), UPPER, "")
        _opening(ax, min(face, x), max(face, x), MIDDLE, "" if elastic else label)
        if elastic:
            y = -0.25 if moving else -0.05
            ax.text(0.5 * (face + wall), y, label, ha="center", va="top", fontsize=6)
        return
    lug = box.right - 0.2 if side > 0 else box.left + 0.2
    x = lug + side * 0.7
    ax.plot([lug, lug], [0, -0.5], color="k", lw=2.2)
    _stroke(ax, x, -0.12 if elastic else -0.88, moving)
    ax.plot([x, x], [-0.5 if elastic else -1, -0.2], color=IMPACT, lw=2.6, solid_capstyle="butt")
    if elastic:
        turns = x + 0.1 * np.r_[0, np.tile([1, -1], 3), 0]
        ax.plot(turns, np.linspace(-0.5, -1, turns.size), color="k", lw=0.9)
    _floor(ax, min(box.left, x - 0.3), max(box.right, x + 0.3))
    _opening(ax, min(lug, x), max(lug, x), -0.35, "")
    if moving:
        # the stops of two neighbours have no room for such labels between them
        ax.text(x, level, label, ha="center", va="top", fontsize=5.5)
        return
    ax.text(
        x + side * 0.12, -0.6, label, ha="left" if side > 0 else "right", va="center", fontsize=6.5
    )


def _between(
    ax: Any, low: Box, high: Box, facing: bool, label: str, crowded: bool, elastic: bool, moving: bool
) -> None:  # fmt: skip
    """A gap between two bodies: facing stops, one of them on a spring if it is elastic, or an arm of the left one
    around the right one."""
    y = MIDDLE
    if facing:
        x0, x1 = low.right, high.left
        half = 0.5 * (x0 + x1)
        for face, end in ((x0, half - 0.3), (x1, half + 0.3)):
            if elastic and face == x0:
                _spring(ax, face, end, y, "")
            else:
                ax.plot([face, end], [y, y], color="k", lw=1.6)
            ax.plot([end, end], [y - 0.18, y + 0.18], color=IMPACT, lw=2.6, solid_capstyle="butt")
        _stroke(ax, half + 0.3, y - 0.3 if crowded else y + 0.32, moving)
        # above the gap where a dashpot is below it, and a long one below both
        shift, va = (0.2, "bottom") if crowded else (-0.24, "top")
        if elastic and moving:
            shift, va = -y - 0.2, "top"
        ax.text(half, y + shift, label, ha="center", va=va, fontsize=6)
        return
    x = high.right + 0.6
    top = HEIGHT + 0.25
    ax.plot([low.middle, low.middle, x, x], [HEIGHT, top, top, y], color="k", lw=1.2)
    ax.plot([x, x], [y, HEIGHT], color=IMPACT, lw=2.6, solid_capstyle="butt")
    _stroke(ax, x, y - 0.15, moving)
    _opening(ax, high.right, x, y + 0.3, "" if moving else label)
    if moving:
        words = label.replace(" to ", "\nto ").replace(", ", "\n")
        ax.text(x + 0.15, y + 0.5, words, ha="left", va="center", fontsize=6)


def _far(ax: Any, low: Box, high: Box, y: float, label: str) -> None:
    """A gap between bodies that are not neighbours: a line below those between them."""
    half = 0.5 * (low.middle + high.middle)
    for box, end in ((low, half - 0.3), (high, half + 0.3)):
        ax.plot([box.middle, box.middle, end], [0, y, y], color="k", lw=1.0)
        ax.plot([end, end], [y - 0.14, y + 0.14], color=IMPACT, lw=2.6, solid_capstyle="butt")
    ax.text(half + 0.45, y - 0.1, label, ha="left", va="top", fontsize=6.5)


def _draw_block(ax: Any, structure: Structure) -> None:
    """A structure whose coordinates are not displacements of bodies, such as one given by its modes."""
    from matplotlib.patches import Rectangle

    n, gaps = structure.coordinates, structure.gaps
    shown = gaps[:4]
    height = max(1.6, 0.8 * len(shown) + 0.3 * (len(gaps) > 4))
    ax.add_patch(Rectangle((0, 0), 6.2, height, fc=PRIMARY, ec="none", alpha=0.3))
    ax.add_patch(Rectangle((0, 0), 6.2, height, fc="none", ec="k", lw=0.9))
    inertia, stiffness = structure.mass, structure.stiffness
    factor = np.linalg.inv(np.linalg.cholesky(inertia))
    squares = np.linalg.eigvalsh(factor @ stiffness @ factor.T)
    omega = np.sqrt(np.clip(squares, 0, None))
    listed = ", ".join(f"{value:.3g}" for value in omega[:4]) + (", …" if n > 4 else "")
    ax.text(
        3.1, 0.5 * height, f"linear structure, $n$ = {n}\n" + rf"$\omega$ = {listed}",
        ha="center", va="center", fontsize=7.5,
    )  # fmt: skip
    for k, gap in enumerate(shown):
        y = height - 0.4 - 0.8 * k if len(gaps) > 1 else 0.5 * height
        ax.plot([6.2, 6.9], [y, y], color="k", lw=1.6)
        ax.plot([6.9, 6.9], [y - 0.22, y + 0.22], color=IMPACT, lw=2.6, solid_capstyle="butt")
        ax.plot([7.8, 7.8], [y - 0.22, y + 0.22], color=IMPACT, lw=2.6, solid_capstyle="butt")
        _opening(ax, 6.93, 7.77, y, "", below=False)
        _stroke(ax, 7.8, y + 0.32, moves(gap))
        ax.text(8.0, y, rf"gap {k}: $e$ = {_opening_of(gap)}", ha="left", va="center", fontsize=6.5)
    if len(gaps) > 4:
        ax.text(7.3, 0.0, f"and {len(gaps) - 4} more gaps", ha="center", va="center", fontsize=6.5)
    ax.set_xlim(-0.3, 10.2)
    ax.set_ylim(-0.4, height + 0.4)
