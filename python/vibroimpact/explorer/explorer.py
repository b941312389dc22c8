"""The model of the explorer, without a page."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import Any

import numpy as np

from .. import (
    BifurcationDiagram,
    Motion,
    Trajectory,
    Zone,
    bifurcation_diagram,
    exact,
    same_motion,
    simulate,
)
from ..base.errors import OpenBoundaryWarning, ParameterError, SingularError
from .definition import Definition, definition_of, start_of
from .limits import Limit, Progress, TooLong
from .motions import Shown, ordered, quick
from .state import Box, Run, State
from .zones import Family

__all__ = ["Explorer", "settles_on"]

# the page names the zones with an open boundary; a warning on the terminal would not say which page it belongs to
warnings.filterwarnings("ignore", category=OpenBoundaryWarning, module=r"vibroimpact\.explorer\.")

#: Number of values along the line of a bifurcation diagram.
VALUES = 161
#: Largest number of events in a displayed simulation.
MOST_EVENTS = 200_000
#: A line that deviates from an axis by less than this share of the window is made parallel to it.
SNAP = 0.02
#: Fields of the state, grouped by the results that depend on them.
SYSTEM = ("xi", "mu", "R1", "R2")
POINT = ("r", "clearance")


class Explorer:
    """The state, and the motions, zones and simulation computed from it.

    Attributes
    ----------
    state : State
    shown : list of Shown
        The motions at the point that are known so far.
    zones : dict
        For each family, the zone computed last.
    inside : dict
        The zones that contain the point.
    faults : list of str
        The computations that were abandoned since the last report.

    Examples
    --------
    >>> from vibroimpact.explorer.explorer import Explorer
    >>> from vibroimpact.explorer.state import State
    >>> explorer = Explorer(State())
    >>> explorer.chosen.label, explorer.chosen.motion.stable
    ('2/1 RL, symmetric', True)
    >>> explorer.step(0.1, 0)
    >>> round(explorer.state.r, 10)
    1.08
    """

    def __init__(self, state: State, limit: Limit | None = None) -> None:
        self.state = state
        self.limit = Limit() if limit is None else limit
        self.faults: list[str] = []
        self.shown: list[Shown] = []
        #: The oscillator, r and clearance at which the motions were found.
        self.shown_at: Any = None
        self.zones: dict[Family, Zone] = {}
        self.inside: dict[Family, Zone] = {}
        self.look()

    def look(self) -> None:
        """Find the motions at the point and add them to the known ones."""
        state = self.state
        known = [item.motion for item in self.shown]
        place = (state.osc, state.r, state.clearance)
        here, self.shown_at = place == self.shown_at, place
        kept = self.shown if here else []
        self.inside = self.zones_at(state)
        self.shown = self.quickly(state, self.inside, [] if here else known, kept)

    def quickly(
        self, at: State, inside: dict[Family, Zone], known: list[Motion], kept: list[Shown]
    ) -> list[Shown]:
        """The motions of a quick search at the point of a state; `kept` alone if it takes too long."""
        try:
            return self.limit(quick, at.osc, at.r, at.clearance, inside.values(), known, kept)
        except TooLong as error:
            self.faults.append(f"the quick search for motions: {error}")
            return kept

    def learn(self, found: list[Shown]) -> None:
        """Take over the result of a fuller search at the point, and keep motions that were added in the
        meantime."""
        self.shown = ordered((item.motion for item in self.shown), found)

    def zones_at(self, state: State) -> dict[Family, Zone]:
        """The zones that contain the point of a state."""
        return {
            family: zone
            for family, zone in self.zones.items()
            if zone.contains(state.r, state.clearance)
        }

    def peek(self, there: State) -> tuple[list[Shown], dict[Family, Zone]]:
        """The motions at the point of another state, quickly, and the zones that contain it."""
        known = [item.motion for item in self.shown]
        inside = self.zones_at(there)
        return self.quickly(there, inside, known, []), inside

    @property
    def index(self) -> int:
        """Number of the chosen motion; -1 if there is none."""
        definition, state = self.state.motion, self.state
        if definition is None or not self.shown:
            return 0 if self.shown else -1
        for i, item in enumerate(self.shown):
            if item.definition == definition:
                return i
        try:
            wanted = self.limit(definition.solve, state.osc, state.r, state.clearance)
        except (ArithmeticError, ValueError, TooLong):
            return 0
        return next((i for i, item in enumerate(self.shown) if same_motion(item.motion, wanted)), 0)

    @property
    def chosen(self) -> Shown | None:
        """The chosen motion."""
        return self.shown[self.index] if self.shown else None

    def restore(self) -> list[str]:
        """Add the chosen motion of a link if no search has found it; returns a message if it cannot be shown."""
        state = self.state
        if state.motion is None:
            return []
        try:
            motion = self.limit(state.motion.solve, state.osc, state.r, state.clearance)
            if not motion.admissible:
                raise SingularError("the motion would pass through a wall")
        except (ArithmeticError, ValueError, TooLong) as error:
            what = (
                "was not computed" if isinstance(error, TooLong) else "does not exist at this point"
            )
            fault = f"motion = {state.motion.text!r}: {what} ({error})"
            self.state = replace(state, motion=None)
            return [fault]
        if not any(same_motion(motion, item.motion) for item in self.shown):
            self.shown.append(Shown(motion, state.motion))
        return []

    def change(self, state: State) -> None:
        """Change to another state; the chosen motion is continued to it."""
        before, chosen = self.state, self.chosen
        moved = any(getattr(state, name) != getattr(before, name) for name in (*SYSTEM, *POINT))
        self.state = state
        if not moved:
            return
        if state.motion is not None and state.motion == before.motion and chosen is not None:
            self.state = replace(state, motion=None)
            self.look()
            self._follow(chosen.motion)
        else:
            self.look()

    def _follow(self, motion: Motion) -> None:
        """Choose the motion at the point to which another one can be continued, if there is one."""
        state = self.state
        try:
            found = self.limit(_continued, motion, state)
        except (SingularError, TooLong):
            return
        if found is None:
            return
        match = [item for item in self.shown if same_motion(item.motion, found[1])]
        if not match:
            match = [Shown(found[1], found[0])]
            self.shown.append(match[0])
        self.state = replace(state, motion=match[0].definition)

    def set(self, words: dict[str, str]) -> None:
        """Change some fields from text; ParameterError leaves the state as it was."""
        self.change(self.state.changed(words))

    def move(self, r: float, clearance: float) -> None:
        """Choose another point."""
        self.change(replace(self.state, r=float(r), clearance=float(clearance)))

    def step(self, right: float, up: float) -> None:
        """Move the point by given shares of the window, within the window."""
        (r0, r1), (d0, d1) = self.state.window
        right, up = (min(max(share, -1), 1) for share in (right, up))
        r = min(max(self.state.r + right * (r1 - r0), r0), r1)
        clearance = min(max(self.state.clearance * (d1 / d0) ** up, d0), d1)
        self.move(r, clearance)

    def choose(self, index: int) -> None:
        """Show one of the motions."""
        self.state = replace(self.state, motion=self.shown[index].definition, show="motion")

    def let_run(self, run: Run) -> Trajectory:
        """Simulate; after an error the state is unchanged."""
        trajectory = self.limit(simulate_run, replace(self.state, run=run))
        self.state = replace(self.state, run=run, show="run")
        return trajectory

    def launch(self, y: float, y_dot: float) -> Trajectory:
        """Simulate from a place in the portrait: the primary mass as in the chosen motion's first impact."""
        half = 0.5 * self.state.clearance
        run = self.start()
        place = min(max(y, -half), half)
        return self.let_run(replace(run, z=run.x + place, z_dot=run.x_dot + y_dot))

    def start(self) -> Run:
        """The simulation of the state, or one that starts from the chosen motion."""
        run = self.state.run or Run()
        chosen = self.chosen
        if self.state.run is None and chosen is not None:
            run = replace(run, **start_of(chosen.motion))
        return run

    def box(self) -> Box:
        """The tolerance box; by default a tenth of the window around the point."""
        state = self.state
        if state.box is not None:
            return state.box
        return Box(
            state.r, state.clearance,
            float(f"{min(0.05 * (state.r_max - state.r_min), 0.5 * state.r):.2g}"),
            float(f"{0.1 * state.clearance:.2g}"),
        )  # fmt: skip

    def drag_box(self, r: float, clearance: float) -> None:
        """Move the centre of the box within the window, rounded to the resolution of a pixel."""
        (r0, r1), (d0, d1) = self.state.window
        r, clearance = (float(f"{value:.5g}") for value in (r, clearance))
        middle = {"r": min(max(r, r0), r1), "clearance": min(max(clearance, d0), d1)}
        self.change(replace(self.state, box=replace(self.box(), **middle)))

    def draw_line(self, ends: tuple[float, float, float, float]) -> None:
        """Set the line of the diagram; a line nearly parallel to an axis becomes parallel to it."""
        (r0, r1), (d0, d1) = self.state.window
        a, b, c, d = map(float, ends)
        b, d = min(max(b, d0), d1), min(max(d, d0), d1)
        a, c = min(max(a, r0), r1), min(max(c, r0), r1)
        across, up = abs(c - a) / (r1 - r0), abs(math.log(d / b)) / math.log(d1 / d0)
        if max(across, up) < 2 * SNAP:
            raise ParameterError("line: must be longer; drag from one end to the other")
        if across < SNAP:
            c = a
        elif up < SNAP:
            d = b
        self.state = replace(self.state, line=(a, b, c, d))


def _continued(
    motion: Motion, state: State, progress: Progress | None = None
) -> tuple[Definition, Motion] | None:
    """The motion at the point of a state to which another motion can be continued, with its definition."""
    near = exact(state.osc, state.r, state.clearance, motion)
    return definition_of(near, progress) if near.admissible and near.consistent else None


def simulate_run(state: State, progress: Progress | None = None) -> Trajectory:
    """The simulation of a state that has one; an exception of `progress` ends it."""
    run = state.run or Run()
    start: Any = run.state
    if run.discard:
        before = simulate(
            state.osc, state.r, state.clearance, 0, start, discard=run.discard, progress=progress
        )
        start = before.final_state  # continue bit for bit
    trajectory = simulate(
        state.osc, state.r, state.clearance, run.cycles, start, max_events=MOST_EVENTS,
        progress=progress,
    )  # fmt: skip
    if not trajectory.complete:
        raise ParameterError(
            f"cycles = {run.cycles:g}: must be fewer; these have more than {MOST_EVENTS} events"
        )
    return trajectory


def settles_on(trajectory: Trajectory, cycles: int = 1000, progress: Progress | None = None) -> str:
    """The motion on which a simulation settles, in words; an exception of `progress` ends the search."""
    osc, r, clearance = trajectory.osc, trajectory.r, trajectory.clearance
    try:
        later = simulate(
            osc, r, clearance, 40, trajectory.final_state, discard=cycles, progress=progress
        )
        if not len(later.events):
            return f"no impacts after {cycles} more cycles"
        period = later.period()
    except (ParameterError, SingularError):
        return f"no period of up to 16 cycles after {cycles} more cycles"
    symbols, n = period.pattern.symbols, len(period.pattern)
    sides = "".join(max(symbols[j:] + symbols[:j] for j in range(n)))  # as in the table
    return f"settles on {n}/{period.pattern.cycles} {sides}"


def diagram_of(state: State, progress: Progress | None = None) -> BifurcationDiagram:
    """The bifurcation diagram along the line of a state that has one; an exception of `progress` ends it."""
    parameter, values, other = along(state)
    fixed: dict[str, Any] = {"clearance" if parameter == "r" else "r": other}
    return bifurcation_diagram(state.osc, parameter, values, progress=progress, **fixed)


def along(state: State) -> tuple[str, Any, Any]:
    """The parameter that varies along the line, its values, and the other parameter: one number, or one per
    value."""
    assert state.line is not None
    a, b, c, d = state.line
    if a == c:
        # equally spaced, as on the diagram's axis and in a namelist
        return "clearance", np.linspace(min(b, d), max(b, d), VALUES), a
    if a > c:
        a, b, c, d = c, d, a, b
    return "r", np.linspace(a, c, VALUES), b if b == d else np.geomspace(b, d, VALUES)
