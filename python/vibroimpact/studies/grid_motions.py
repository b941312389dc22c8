"""Stable motions of a pattern on a grid, of an oscillator with friction in the slot or compliant walls."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, SingularError
from ..motions.exact import exact_structure, is_mirrored, is_repeated, settled
from ..motions.motion import Motion
from ..results import door
from ..systems.oscillator import Oscillator, Pattern, Point, Stops
from .chart import compute_chart

_Array = NDArray[np.float64]
Node = tuple[int, int]
#: Load cycles that are simulated before Newton's method, and number of simulations from rest along each axis.
SETTLING, LATTICE = 100, 4
#: Smallest step between two nodes, as a part of their distance, in which a motion is followed.
LEAST_STEP = 1 / 8
#: Largest difference of load phases (rad) and, relative to the largest one, of speeds of the same motion.
ALIKE = 1e-6
#: Relative change of the coordinates of an unstable motion from which a simulation leaves it.
NUDGE = 1e-3


class Guess(NamedTuple):
    """A node of the grid, and what to start from there: a motion, or None for rest at q = 0."""

    node: Node
    motion: Motion | None
    #: Value of r and of the clearance at the motion.
    r: float
    clearance: float
    #: The number of the sheet that is followed.
    sheet: int
    #: Whether to simulate until the motion has settled, instead of Newton's method from node to node.
    simulate: bool = False


class Grid:
    """The motions of a pattern at the nodes of a grid of r and clearance."""

    def __init__(
        self, osc: Oscillator, pattern: Pattern, axes: tuple[_Array, _Array], friction: float, stops: Stops | None,
        symmetric: bool | None,
    ) -> None:  # fmt: skip
        """
        Parameters
        ----------
        osc : Oscillator
        pattern : Pattern
            Without rest.
        axes : (ndarray (m,), ndarray (n,))
            Values of r and of the clearance.
        friction, stops : float, tuple or None
            As in `Oscillator.at`.
        symmetric : bool or None
            As in `chart`.
        """
        self.osc, self.pattern, self.axes, self.symmetric = osc, pattern, axes, symmetric
        self.friction, self.stops = friction, stops
        right, left = osc.restitution
        self.alike = stops[0] == stops[1] if stops else right == left
        self.motions: dict[Node, list[tuple[Motion, int]]] = {}
        #: Numbers of sheets beyond the slots of a chart.
        self.sheets = itertools.count(100)

    def point(self, r: float, clearance: float) -> Point:
        """The system at values of r and of the clearance."""
        return self.osc.at(r, clearance, friction=self.friction, stops=self.stops)

    def at(self, node: Node) -> tuple[float, float]:
        """Values of r and of the clearance at a node."""
        return self.axes[0][node[1]].item(), self.axes[1][node[0]].item()

    def belongs(self, motion: Motion) -> bool:
        """Whether a motion has the pattern, or its mirror image if the walls are equal, and the symmetry asked
        for."""
        if motion.cycles != self.pattern.cycles or motion.admissible is False or len(motion.rests):
            return False
        contacts = zip(motion.gaps.tolist(), motion.kinds, strict=True)
        sides = "".join("RL"[gap] for gap, kind in contacts if kind in ("impact", "touch"))
        own = self.pattern.sides
        wanted = {own, own.translate(str.maketrans("RL", "LR"))} if self.alike else {own}
        if len(sides) != len(own) or not any(sides in 2 * each for each in wanted):
            return False
        if is_repeated(motion):
            return False
        return self.symmetric is None or is_mirrored(motion) == self.symmetric

    def found(self, guess: Guess) -> Motion | None:
        """The motion at a node that a guess leads to; None if there is none, or if it does not belong to the
        grid."""
        r, clearance = self.at(guess.node)
        if guess.motion is None or guess.simulate:
            motion = self.reached(guess, r, clearance)
        else:
            motion = self.followed(guess, r, clearance)
        return motion if motion is not None and self.belongs(motion) else None

    def reached(self, guess: Guess, r: float, clearance: float) -> Motion | None:
        """The motion to which a simulation and then Newton's method lead."""
        point = self.point(r, clearance)
        if guess.motion is None:
            start, q, rate = 0.0, np.zeros(2), np.zeros(2)
        else:
            start, q, rate = moved(guess.motion, guess.clearance, r, clearance)
            q = q * (1 + NUDGE)
        try:
            return settled(
                point.structure, point.load, start, (q, rate), SETTLING, cycles=self.pattern.cycles
            )
        except (ParameterError, SingularError):
            return None

    def followed(self, guess: Guess, r: float, clearance: float) -> Motion | None:
        """The motion to which Newton's method leads along the line from the motion of a guess to a node, in steps
        that are halved where it fails."""
        motion, at = guess.motion, (guess.r, guess.clearance)
        done, step = 0.0, 1.0
        while done < 1 and motion is not None:
            part = min(1.0, done + step)
            here = (
                guess.r + part * (r - guess.r),
                guess.clearance * (clearance / guess.clearance) ** part,
            )
            if part == 1:
                here = r, clearance
            point = self.point(*here)
            start, q, rate = moved(motion, at[1], *here)
            try:
                found = settled(
                    point.structure, point.load, start, (q, rate), cycles=self.pattern.cycles
                )
            except (ParameterError, SingularError):
                found = None
            if found is None or not self.belongs(found):
                step /= 2
                if step < LEAST_STEP or here == at:
                    return None
                continue
            motion, at, done = found, here, part
        return motion

    def add(self, guess: Guess, motion: Motion) -> bool:
        """Add a motion unless it is known at the node; tells whether it was added."""
        known = self.motions.setdefault(guess.node, [])
        if any(same(motion, other) for other, _ in known):
            return False
        known.append((motion, guess.sheet))
        return True

    def neighbours(self, node: Node) -> list[Node]:
        """The up to four neighbours of a node."""
        i, j = node
        near = ((i, j - 1), (i, j + 1), (i - 1, j), (i + 1, j))
        return [
            (a, b) for a, b in near if 0 <= a < len(self.axes[1]) and 0 <= b < len(self.axes[0])
        ]

    def is_stable(self, node: Node) -> bool:
        """Whether a stable motion is known at a node."""
        return any(motion.stable for motion, _ in self.motions.get(node, []))

    def onwards(self, guess: Guess, motion: Motion) -> list[Guess]:
        """A motion as a guess at the neighbours of its node to which its sheet has not been followed."""
        return [
            Guess(near, motion, *self.at(guess.node), guess.sheet)
            for near in self.neighbours(guess.node)
            if all(sheet != guess.sheet for _, sheet in self.motions.get(near, []))
        ]

    def rescues(self, tried: set[tuple[Node, int]]) -> list[Guess]:
        """Simulations at nodes without a stable motion: from the unstable motions there, and from the stable ones
        of the neighbours."""
        found = []
        for node in np.ndindex(len(self.axes[1]), len(self.axes[0])):
            if self.is_stable(node):
                continue
            own = [(node, motion) for motion, _ in self.motions.get(node, [])]
            near = [
                (each, motion)
                for each in self.neighbours(node)
                for motion, _ in self.motions.get(each, [])
                if motion.stable
            ]
            for each, motion in own + near:
                if (node, id(motion)) not in tried:
                    tried.add((node, id(motion)))
                    found.append(
                        Guess(node, motion, *self.at(each), next(self.sheets), simulate=True)
                    )
        return found


def moved(motion: Motion, clearance: float, r: float, to: float) -> tuple[float, _Array, _Array]:
    """Time, coordinates and velocities between two events of a motion, for a guess at other values of r and of the
    clearance: the free mass keeps its relative place in the slot."""
    time, (q, rate) = motion._run()._between_events()
    x, z = q
    place = np.array([x, x + (z - x) * to / clearance])
    return time * motion.load.frequency / r, place, rate


def same(motion: Motion, other: Motion) -> bool:
    """Whether two motions of a point have the same events, whichever comes first."""
    many = len(motion.gaps)
    if many != len(other.gaps):
        return False
    whole = 2 * np.pi * motion.cycles
    size = max(np.abs(motion.states[:, 1]).max(), 1e-300)
    for shift in range(many):
        if not np.array_equal(np.roll(other.gaps, -shift), motion.gaps):
            continue
        off = np.roll(other.phases, -shift) - motion.phases
        off = np.mod(off + whole / 2, whole) - whole / 2
        rates = np.roll(other.states[:, 1], -shift, axis=0) - motion.states[:, 1]
        if np.abs(off).max() < ALIKE and np.abs(rates).max() < ALIKE * size:
            return True
    return False


def rigid_motions(grid: Grid, threads: int | None) -> list[Guess]:
    """The motions without friction between rigid walls, with the restitution of compliant ones, at all nodes."""
    osc, pattern, axes = grid.osc, grid.pattern, grid.axes
    walls = grid.stops or (None, None)
    right, left = (
        restitution_of(osc.mu, *wall) if wall else own
        for own, wall in zip(osc.restitution, walls, strict=True)
    )
    rigid = Oscillator(xi=osc.xi, mu=osc.mu, restitution=(right, left))
    symmetric = grid.symmetric if right == left else None
    chart = compute_chart(rigid, pattern, *axes, symmetric, True, threads, None).variables
    phases = np.moveaxis(chart["alpha"].values + chart["tau"].values, 0, -1)
    there = (chart["status"].values == 0) & (chart["admissible"].values != 0)
    gaps = np.where(pattern.signs > 0, 0, 1).tolist()
    found = []
    for slot, i, j in zip(*np.nonzero(there), strict=True):
        r, clearance = grid.at((i, j))
        point = rigid.at(r, clearance)
        try:
            motion = exact_structure(
                point.structure, point.load, (phases[slot, i, j], gaps, pattern.cycles)
            )
        except (ParameterError, SingularError):
            continue
        found.append(Guess((int(i), int(j)), motion, r, clearance, int(slot)))
    return found


def restitution_of(mu: float, stiffness: float, damping: float) -> float:
    """The coefficient of restitution that a compliant wall has in the limit of large stiffness."""
    ratio = damping / (2 * math.sqrt(stiffness * mu / (1 + mu))) if stiffness > 0 else 1.0
    return math.exp(-math.pi * ratio / math.sqrt(1 - ratio**2)) if ratio < 1 else 0.0


def grid_verdicts(
    osc: Oscillator, pattern: Pattern, axes: tuple[_Array, _Array], friction: float, stops: Stops | None,
    load: float, symmetric: bool | None, limits: Mapping[str, float], threads: int | None,
    progress: door.Progress | None,
) -> _Array:  # fmt: skip
    """Whether a stable motion of a pattern is found at each node of a grid, whether this is unknown, and whether
    all are within the limits; (3, n, m).

    Newton's method starts from the motions without friction between rigid walls at each node, and from simulations
    from rest at some nodes. Each motion found is followed from node to node, and where no stable motion is
    known, simulations start from the motions of the node and its neighbours. Every motion that counts is an exact
    motion of its node, whatever it was found from.

    Parameters
    ----------
    osc, pattern, axes, friction, stops, symmetric
        As in `Grid`.
    load : float
        A factor of the nominal load, for limits of lengths.
    limits : dict of float
        Largest allowed quantities, as in `uncertainty`.
    threads : int or None
        Default: one for each processor. The result is the same for any number.
    progress : callable or None
        Called with the fraction of the nodes that were visited.
    """
    grid = Grid(osc, pattern, axes, friction, stops, symmetric)
    shape = len(axes[1]), len(axes[0])
    queue = rigid_motions(grid, threads)
    lattice = [np.unique(np.linspace(0, n - 1, min(n, LATTICE)).round()).astype(int) for n in shape]
    for i in lattice[0].tolist():
        for j in lattice[1].tolist():
            queue.append(Guess((i, j), None, *grid.at((i, j)), next(grid.sheets)))
    tried: set[tuple[Node, int]] = set()
    visited: set[Node] = set()
    workers = checks.integer(
        os.cpu_count() or 1 if threads is None else threads, "threads", 1, 1024
    )
    with ThreadPoolExecutor(workers) as pool:
        while queue:
            later: list[Guess] = []
            for guess, motion in zip(queue, pool.map(grid.found, queue), strict=True):
                visited.add(guess.node)
                if motion is not None and grid.add(guess, motion):
                    later += grid.onwards(guess, motion)
            if progress is not None:
                progress(len(visited) / (shape[0] * shape[1]), "")
            queue = later or grid.rescues(tried)
    found = np.zeros((3, *shape))
    for node, known in grid.motions.items():
        motions = [motion for motion, _ in known]
        good = [
            motion
            for motion in motions
            if motion.stable and motion.admissible and motion.consistent
        ]
        found[0][node] = bool(good)
        found[1][node] = not good and any(motion.stable is not False for motion in motions)
        found[2][node] = bool(good) and all(
            figure(motion, grid.at(node)[0], osc.xi, load)[name] <= greatest
            for name, greatest in limits.items()
            for motion in good
        )
    return found


def figure(motion: Motion, r: float, xi: float, load: float) -> Mapping[str, float]:
    """The quantities of a motion that can be limited."""
    largest = float(motion.quantities().q.peak[0])
    return {
        "attenuation": largest * math.hypot((1 - r) * (1 + r), 2 * xi * r),
        "displacement": load * largest,
        "multiplier": float(np.abs(motion.multipliers[0])),
    }
