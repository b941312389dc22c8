"""The attractors of a point as they become known, and the states that go to each."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import SingularError
from ..model import Oscillator
from ..motion import Motion
from ..trajectory import TWO_PI, simulate
from .lyapunov import Lyapunov, lyapunov
from .settling import as_state, column, motion_at, settle_chains

_Array = NDArray[np.float64]
_Labels = NDArray[np.int32]
#: Rounds in which motions that were not known are added; they go on while they decide a share at least,
#: as when transients are long.
ROUNDS, LIVELY = 16, 0.02
#: Load cycles after which a largest Lyapunov exponent is told from 0, and those before it.
EXPONENT_CYCLES, EXPONENT_DISCARD = 4000, 500
#: States that are described at a time, and impacts that are kept of each.
BLOCK, IMPACTS = 2000, 200
#: Attractors that are not periodic, at most: without damping every state has its own.
GROUPS = 30
#: Least largest exponent of chaos per load cycle.
CHAOTIC = 2e-3


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class BasinAttractor:
    """An attractor.

    Attributes
    ----------
    kind : str
        "periodic", "rest" (periodic, with accumulation and rest), "quasi-periodic", "chaotic", "no impacts",
        or "periodic?" where a simulation repeats itself but no stable exact motion was found.
    name : str
        Sides and load cycles, as "RL/1", or the kind; a number tells those of one name apart.
    motion : Motion or None
        The exact motion.
    state : dict
        A state on it.
    lyapunov : Lyapunov or None
        Exponents of what is not periodic.
    radius, contraction : float
        Of the largest neighbourhood that decides, in its own norm, and by what the derivative over a period
        contracts in that norm; 0 and 1 if there is none.
    """

    kind: str
    name: str
    motion: Motion | None
    state: dict[str, float]
    lyapunov: Lyapunov | None = None
    radius: float = 0.0
    contraction: float = 1.0

    def __repr__(self) -> str:
        return f"<{self.kind} attractor {self.name}>"


class Catalogue:
    """Attractors of one point, found one after the other."""

    def __init__(
        self,
        osc: Oscillator,
        r: float,
        clearance: float,
        load: float,
        max_cycles: int,
        threads: int,
    ) -> None:
        self.osc, self.r, self.clearance, self.load = osc, r, clearance, load
        self.max_cycles, self.threads = max_cycles, threads
        self.attractors: list[BasinAttractor] = []
        #: Of attractors that are not periodic: their numbers, and coarse cells of their impacts.
        self.places: list[tuple[int, set[tuple[int, ...]]]] = []

    def label(self, starts: _Array, cycles: int, probes: int) -> tuple[_Labels, int]:
        """The attractor of each state (5, m), and how many events were simulated to tell."""
        m = starts.shape[1]
        labels = np.full(m, -1, dtype=np.int32)
        few = np.unique(np.linspace(0, m - 1, min(probes, m)).astype(int))
        self.discover(starts[:, few], cycles // 2)
        open_ones, impacts = np.arange(m), 0
        ends = starts
        for _ in range(ROUNDS):
            found, counts, ends = self.decide(ends, cycles)
            impacts += counts
            labels[open_ones] = found
            still = found < 0
            open_ones, ends = open_ones[still], ends[:, still]
            known = len(self.attractors)
            if not open_ones.size:
                break
            lively = (~still).sum() > LIVELY * still.size
            some = np.unique(
                np.linspace(0, open_ones.size - 1, min(2 * probes, open_ones.size)).astype(int)
            )
            self.discover(ends[:, some], 0)
            if len(self.attractors) == known and not lively:
                break
        if open_ones.size:
            labels[open_ones] = self.describe(ends)
        return labels, impacts

    def settle(self, starts: _Array, settling: int) -> Any:
        """What some states settle on."""
        parameters = np.repeat(
            column(self.osc, self.r, self.clearance)[:, None, None], starts.shape[1], axis=2
        )
        return settle_chains(
            parameters, self.load, starts, settling, 2 * self.max_cycles + 1, IMPACTS, self.threads
        )

    def discover(self, starts: _Array, settling: int) -> None:
        """Adds the periodic motions that some states settle on."""
        settled = self.settle(starts, settling)
        seen = set()
        for j in np.flatnonzero((settled.cycles[0] > 0) & (settled.impacts[0] > 0)).tolist():
            k = int(settled.cycles[0, j])
            numbers = (settled.x_min[0, j], settled.x_max[0, j])
            key = (k, int(settled.letters[0, j]), *(round(x / self.clearance, 3) for x in numbers))
            if key in seen:
                continue
            seen.add(key)
            motion = motion_at(
                self.osc, self.r, self.clearance, self.load, settled.ends[:, 0, j], k
            )
            if motion is None or any(
                same(motion, item.motion) for item in self.attractors if item.motion is not None
            ):
                continue
            kind = "rest" if motion.pattern.has_rest else "periodic"
            letters = motion.pattern.letters
            sides = max("".join(letters[i:] + letters[:i]) for i in range(len(letters)))
            name = f"{sides}/{motion.pattern.cycles}"
            state = as_state(settled.ends[:, 0, j], self.clearance)
            self.attractors.append(BasinAttractor(kind, name, motion, state))

    def decide(self, starts: _Array, cycles: int) -> tuple[_Labels, int, _Array]:
        """The known motion that each state comes near to (-1: none), events simulated, and the ends."""
        kinds, middles, owners = [], [], []
        for i, item in enumerate(self.attractors):
            if item.motion is None:
                continue
            release = item.motion.pattern.has_rest
            for event in item.motion.events:
                if event["kind"] != ("release" if release else "impact"):
                    continue
                state = [event[name] for name in ("x", "x_dot_after", "z_dot_after", "phase")]
                middles.append([state[1], state[3], 0, 0] if release else state)
                kinds.append(
                    [1 if event["side"] == "R" else -1, int(release), item.motion.pattern.cycles]
                )
                owners.append(i)
        if not owners:
            kinds, middles, owners = [[0, 0, 1]], [[0.0] * 4], [-1]
        labels, impacts, ends, radii, contractions = _core.basins(
            self.osc.xi, self.osc.mu, self.osc.restitution, self.r, self.load, self.clearance,
            np.array(kinds, dtype=np.int32).T, np.array(middles).T, starts, cycles, self.threads,
        )  # fmt: skip
        for owner, radius, contraction in zip(owners, radii, contractions, strict=True):
            if owner >= 0 and radius > self.attractors[owner].radius:
                self.attractors[owner] = replace(
                    self.attractors[owner], radius=float(radius), contraction=float(contraction)
                )
        return np.array([-1, *owners], dtype=np.int32)[labels], int(impacts.sum()), ends

    def describe(self, ends: _Array) -> _Labels:
        """The attractors of states that come to no known motion: what they are."""
        known: dict[Any, int] = {}
        blocks = np.array_split(np.arange(ends.shape[1]), -(-ends.shape[1] // BLOCK))
        return np.concatenate([self.describe_block(ends[:, block], known) for block in blocks])

    def describe_block(self, ends: _Array, known: dict[Any, int]) -> _Labels:
        """The same of some states; `known` are the numbers of what was met before."""
        settled = self.settle(ends, 0)
        labels = np.full(ends.shape[1], -1, dtype=np.int32)
        for j in range(labels.size):
            if settled.status[0, j] != 0:
                continue
            state = as_state(settled.ends[:, 0, j], self.clearance)
            if settled.impacts[0, j] == 0 and settled.cycles[0, j]:
                key: Any = "no impacts"
            elif settled.cycles[0, j]:
                key = (int(settled.cycles[0, j]), int(settled.letters[0, j]))
            else:
                key = "aperiodic"
            if key == "aperiodic":
                continue
            if key not in known:
                known[key] = len(self.attractors)
                kind = "no impacts" if key == "no impacts" else "periodic?"
                name = kind if key == "no impacts" else f"{key[1]}/{key[0]}?"
                self.attractors.append(BasinAttractor(kind, name, None, state))
            labels[j] = known[key]
        wandering = (labels < 0) & (settled.status[0] == 0)
        if wandering.any():
            self.tell_apart(settled, np.flatnonzero(wandering), labels)
        return labels

    def tell_apart(self, settled: Any, members: NDArray[np.intp], labels: _Labels) -> None:
        """Groups trajectories that are not periodic by the places of their impacts."""
        for j in members.tolist():
            n = int(settled.found[0, j])
            values, right = settled.values[:, :n, 0, j], settled.sides[:n, 0, j] > 0
            cells = cells_of(values[1], values[2], right, self.clearance)
            shares = [len(cells & group) / max(1, len(cells)) for _, group in self.places]
            best = int(np.argmax(shares)) if shares else -1
            if best >= 0 and shares[best] > 0.5:
                labels[j] = self.places[best][0]
                continue
            if len(self.places) >= GROUPS:
                continue
            state = as_state(settled.ends[:, 0, j], self.clearance)
            run = simulate(
                self.osc, self.r, self.clearance, EXPONENT_CYCLES, state=state, load=self.load
            )
            hits = run.events[run.events["kind"] == "impact"]
            cells = cells_of(hits["phase"], hits["x"], hits["side"] == "R", self.clearance)
            try:
                result = lyapunov(
                    self.osc,
                    self.r,
                    self.clearance,
                    EXPONENT_CYCLES,
                    state,
                    self.load,
                    EXPONENT_DISCARD,
                    threads=self.threads,
                )
            except SingularError:
                continue  # impacts die out
            largest = float(result.per_cycle[0])
            if not largest > -CHAOTIC:
                continue  # a transient that has ended meanwhile
            kind = "chaotic" if largest > CHAOTIC else "quasi-periodic"
            labels[j] = len(self.attractors)
            self.places.append((len(self.attractors), cells))
            self.attractors.append(BasinAttractor(kind, kind, None, state, result))

    def by_share(self, labels: _Labels) -> tuple[NDArray[np.intp], list[BasinAttractor]]:
        """New labels, by falling share of the states, and the attractors in that order, names made one."""
        counts = np.bincount(labels[labels >= 0], minlength=len(self.attractors))
        order = np.argsort(-counts, kind="stable")
        order = order[counts[order] > 0]
        place = np.zeros(len(self.attractors) + 1, dtype=np.intp)
        place[order] = np.arange(order.size)
        attractors = [self.attractors[i] for i in order]
        names = [item.name for item in attractors]
        numbered = [
            replace(item, name=f"{item.name} ({names[: i + 1].count(item.name)})")
            if names.count(item.name) > 1 else item
            for i, item in enumerate(attractors)
        ]  # fmt: skip
        return place, numbered


def cells_of(
    phase: _Array, x: _Array, right: NDArray[np.bool_], clearance: float
) -> set[tuple[int, ...]]:
    """Coarse cells (side, phase, x) of some impacts."""
    columns = (right, np.floor(phase * (24 / TWO_PI)), np.floor(x * (24 / clearance)))
    return set(zip(*(column.astype(int).tolist() for column in columns), strict=True))


def same(a: Motion, b: Motion) -> bool:
    """Whether two motions are one: an event of the other is the first of the one."""
    if a.pattern.cycles != b.pattern.cycles or len(a.pattern) != len(b.pattern):
        return False
    first, others = a.events[0], b.events
    others = others[(others["kind"] == first["kind"]) & (others["side"] == first["side"])]
    phase = np.abs(np.mod(others["phase"] - first["phase"] + math.pi, TWO_PI) - math.pi)
    near = np.maximum(phase, np.abs(others["x"] - first["x"]) / a.clearance)
    return bool(near.min(initial=1.0) < 1e-6)
