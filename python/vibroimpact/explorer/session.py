"""One open page: passes the browser's requests to the explorer, and sends texts and drawings back."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from .. import Motion, Trajectory
from ..base.errors import VibroimpactError
from . import pictures, sketches, words
from .attenuation import Judged
from .background import Background
from .explorer import Explorer, simulate_run
from .export import as_namelist, as_python
from .latest import Stale
from .limits import Limit
from .motions import Shown
from .state import Run, State, joined

__all__ = ["Session"]

SEARCHED = "All patterns of up to 6 impacts and 2 cycles were searched."
#: The error message for each kind of job, and the texts that then replace its progress message.
TASKS: dict[str, tuple[str, dict[str, Any]]] = {
    "zones": ("the zones could not be computed", {"status": "not computed"}),
    "motions": ("the fuller search failed", {"searched": "Not all patterns were searched."}),
    "rest": ("the fuller search failed", {"searched": "Not all patterns were searched.", "peek": True}),
    "diagram": ("the diagram could not be computed", {"diagram": "not computed"}),
    "map": ("the map could not be computed", {"mapped": "not computed"}),
    "box": ("the box could not be computed", {"boxed": "not computed"}),
}  # fmt: skip


class Session:
    """One open page.

    Parameters
    ----------
    query : str
        Query of the link.
    deliver : callable
        Sends a message, in the form returned by `packed`, to the script of the page.
    at_its_turn : callable
        Runs a function in the thread of the page; the job threads use it to return their results.
    """

    def __init__(
        self,
        query: str,
        deliver: Callable[..., None],
        at_its_turn: Callable[[Callable[[], None]], None],
    ) -> None:
        state, self.faults = State.read(query)
        self.limit = Limit()
        self.explorer = Explorer(state, self.limit)
        self.faults += self.explorer.restore()
        self.deliver = deliver
        self.background = Background(at_its_turn, self.failed)
        self.trajectory: Trajectory | None = None
        self.peeking, self.searched, self.ran = False, "", ""
        #: Messages of threads that have failed since the last change.
        self.broken: dict[str, str] = {}
        #: Changes of the figures to be sent with the next message.
        self.changes: pictures.Changes = {}
        self.spaces: dict[str, Any] = {}
        #: The inputs for which the zones, motions, diagram, point and figures of the motion were last computed.
        self.zones_of: Any = None
        self.motions_of: Any = None
        self.diagram_of: Any = None
        self.map_of: Any = None
        self.box_of: Any = None
        self.marked: Any = None
        #: The window of the chart, the same as that of the drawn zones.
        self.window = state.window
        self.axes: Any = None
        self.drawn: Any = None
        #: The outcome at points of the box, and the texts for the map and the box.
        self.found: Judged | None = None
        self.mapped, self.boxed = "", ""

    # -- messages from the page

    def heard(self, message: dict[str, Any]) -> None:
        """Answer a message, even if handling it fails."""
        kind = message["kind"]
        self.peeking = kind == "peek"
        if not self.peeking:
            self.background.rest.drop()
        steady = kind in ("peek", "unpeek")  # an error message stays until something changes
        if not steady:
            self.broken.clear()
        number = {"number": message["number"]}
        try:
            try:
                answer = ({} if steady else {"fault": ""}) | getattr(self, f"on_{kind}")(message)
            except VibroimpactError as error:
                answer = {"fault": str(error), **self.summary()}
            if self.explorer.faults:
                faults, self.explorer.faults = self.explorer.faults, []
                answer["fault"] = joined(
                    filter(None, (answer.get("fault"), *dict.fromkeys(faults)))
                )
            self.send(answer | number)
        except Stale:
            raise  # the page has been closed
        except Exception as error:
            self.send({"fault": own_fault(error)} | number)

    def close(self) -> None:
        """The page has been closed: stop all computations for it."""
        self.limit.close()
        self.background.drop()

    def send(self, answer: dict[str, Any]) -> None:
        """Send one message with all texts and drawings."""
        changes, self.changes = self.changes, {}
        self.deliver(*pictures.packed(answer | {"pictures": changes}))

    def failed(self, kind: str, error: Exception) -> None:
        """A thread has raised an exception: report it; the job is repeated with the next change."""
        fault, answer = TASKS[kind]
        if kind != "rest":
            setattr(self, f"{kind}_of", None)
            for name in answer.keys() & {"searched", "mapped", "boxed"}:
                setattr(self, name, answer[name])
        reason = str(error) if isinstance(error, VibroimpactError) else own_fault(error)
        self.broken[kind] = f"{fault}: {reason}"
        self.send({"fault": joined(self.broken.values()), **answer})

    def on_ready(self, _: dict[str, Any]) -> dict[str, Any]:
        """The page is ready."""
        fault = ""
        if self.faults:
            fault = f"The link contains invalid values; the rest of it is restored. {joined(self.faults)}"
        answer = {**self.update(), "fault": fault}
        if self.faults:
            del answer["query"]  # the address is kept as given until something changes
        return answer

    def on_set(self, message: dict[str, Any]) -> dict[str, Any]:
        """Fields changed."""
        self.explorer.set(message["words"])
        return self.update()

    def on_point(self, message: dict[str, Any]) -> dict[str, Any]:
        """Another point was chosen."""
        self.explorer.move(message["r"], message["clearance"])
        return self.update()

    def on_step(self, message: dict[str, Any]) -> dict[str, Any]:
        """The point was moved by keys."""
        self.explorer.step(message["right"], message["up"])
        return self.update()

    def on_peek(self, message: dict[str, Any]) -> dict[str, Any]:
        """The pointer has moved: show the motions at its place, without choosing the point."""
        there = replace(
            self.explorer.state, r=message["r"], clearance=message["clearance"], motion=None
        )
        shown, inside = self.explorer.peek(there)

        def peeked(shown: list[Shown], searched: str) -> dict[str, Any]:
            self.drawn = None
            self.draw_motion(shown[0].motion if shown else None)
            place = words.place(there, shown, inside)
            return {
                "table": words.rows(shown, 0),
                "place": place,
                "searched": searched,
                "peek": True,
            }

        self.background.pointer(there, shown, lambda found: self.send(peeked(found, SEARCHED)))
        return peeked(shown, "Searching further where the pointer rests …")

    def on_unpeek(self, _: dict[str, Any]) -> dict[str, Any]:
        """The pointer has left."""
        return self.summary()

    def on_choose(self, message: dict[str, Any]) -> dict[str, Any]:
        """Choose a motion of the table by its definition, or the simulation listed above the motions.

        The table may have changed since the browser received it: if the table no longer contains the motion, no
        motion is chosen.
        """
        definitions = [item.definition.text for item in self.explorer.shown]
        if message["motion"] is None:
            self.explorer.set({"show": "run"})
        elif message["motion"] in definitions:
            self.explorer.choose(definitions.index(message["motion"]))
        return self.summary()

    def on_run(self, message: dict[str, Any]) -> dict[str, Any]:
        """Simulate from the state in the fields."""
        return self.runs(self.explorer.let_run(Run.read(message["words"])))

    def on_launch(self, message: dict[str, Any]) -> dict[str, Any]:
        """Simulate from a place in the phase portrait."""
        return self.runs(self.explorer.launch(message["y"], message["y_dot"]))

    def runs(self, trajectory: Trajectory) -> dict[str, Any]:
        """A simulation has been made."""
        self.trajectory, self.ran = trajectory, words.run_text(trajectory, self.limit)
        return self.summary()

    def on_stop(self, _: dict[str, Any]) -> dict[str, Any]:
        """Remove the simulation."""
        self.explorer.set({"run": "", "show": "motion"})
        self.trajectory, self.ran = None, ""
        return self.summary()

    def on_line(self, message: dict[str, Any]) -> dict[str, Any]:
        """The line of the diagram was drawn."""
        a, b = message["from"], message["to"]
        self.explorer.draw_line((*a, *b))
        return self.update()

    def on_through(self, message: dict[str, Any]) -> dict[str, Any]:
        """Draw a line through the point, horizontally or vertically across the window."""
        state = self.explorer.state
        (r0, r1), (d0, d1) = state.window
        ends = (
            (r0, state.clearance, r1, state.clearance) if message["across"]
            else (state.r, d0, state.r, d1)
        )  # fmt: skip
        self.explorer.draw_line(ends)
        return self.update()

    def on_erase(self, _: dict[str, Any]) -> dict[str, Any]:
        """Remove the line."""
        self.explorer.set({"line": ""})
        return self.update()

    def on_drag(self, message: dict[str, Any]) -> dict[str, Any]:
        """The box was dragged, or is to be shown at the point."""
        self.explorer.drag_box(message["r"], message["clearance"])
        return self.update()

    def on_export(self, message: dict[str, Any]) -> dict[str, Any]:
        """Export the contents of the page as text."""
        write = {"namelist": as_namelist, "python": as_python}[message["form"]]
        return {"export": write(self.explorer), "form": message["form"]}

    # -- consequences

    def update(self) -> dict[str, Any]:
        """After a change of the state: start the computations in threads, and send at once what is already
        known."""
        state = self.explorer.state
        busy = {}
        wanted = (state.osc, state.window, state.patterns)
        if wanted != self.zones_of:
            self.zones_of, busy = wanted, {"status": "computing …"}
            self.background.zones(
                state, lambda *found: self.send(self.show_zones(state.window, *found))
            )
        point = (state.osc, state.r, state.clearance)
        if point != self.motions_of:
            self.motions_of, self.searched = point, "Searching further …"
            self.background.motions(state, self.explorer.shown, self.show_motions)
            self.simulate()
        if state.line is not None and (state.osc, state.line) != self.diagram_of:
            self.diagram_of = (state.osc, state.line)
            self.background.diagram(state, self.show_diagram)
        self.map_attenuation()
        self.judge_box()
        return busy | self.summary()

    def map_attenuation(self) -> None:
        """Compute the map if it is shown and another one is needed."""
        state = self.explorer.state
        wanted = (state.osc, state.window) if state.map == "on" else None
        if wanted == self.map_of:
            return
        self.map_of, self.mapped = wanted, ""
        self.changes |= pictures.map_picture(None, state.window)
        if wanted is None:
            self.background.map.drop()
        else:
            self.mapped = "computing 0 % …"
            self.background.attenuation(state, partial(self.show_map, state.window))

    def show_map(self, window: Any, picture: Any, share: float) -> None:
        """Show the part of the map that is known."""
        self.mapped = "" if share == 1 else f"computing {100 * share:.0f} % …"
        self.changes |= pictures.map_picture(picture, window)
        self.send({"mapped": self.mapped})

    def judge_box(self) -> None:
        """Simulate at the points of the box if it has changed; a changed limit needs no computation."""
        state = self.explorer.state
        wanted = None if state.box is None else (state.osc, state.box)
        if wanted != self.box_of:
            self.box_of, self.found = wanted, None
            if wanted is None:
                self.background.box.drop()
            else:
                self.background.tolerances(state, self.show_box)
        self.draw_box()

    def show_box(self, found: Judged) -> None:
        """Show the outcome of the simulations in the box."""
        self.found = found
        self.draw_box()
        self.send({"boxed": self.boxed})

    def draw_box(self) -> None:
        """Draw the box, and update its text."""
        state, good = self.explorer.state, None
        self.boxed = "" if state.box is None else "computing …"
        if self.found is not None:
            good = self.found.attenuation <= state.limit
            self.boxed = words.box_text(state, self.found, good)
        self.changes |= pictures.box(state.box, self.found, good)

    def simulate(self) -> None:
        """Repeat the simulation for another point or system; an error is shown beside its button."""
        self.trajectory, self.ran = None, ""
        if self.explorer.state.run is not None:
            try:
                self.trajectory = self.limit(simulate_run, self.explorer.state)
                self.ran = words.run_text(self.trajectory, self.limit)
            except VibroimpactError as error:
                self.ran = str(error)

    def show_zones(
        self, window: Any, zones: Any, shapes: Any, done: bool, given_up: str
    ) -> dict[str, Any]:
        """Draw zones that a thread has computed."""
        self.explorer.zones, self.spaces, self.marked = zones, shapes["spaces"], None
        self.window = window
        self.changes |= pictures.zones(shapes, window)
        self.explorer.look()  # the zones may contain motions that were not found
        unclosed = words.open_zones(zones)
        if not done:
            status = joined(filter(None, (given_up, unclosed, "refining …")))
        else:
            none = "" if any(zones.values()) else "no stable motion was found in this window"
            status = joined(filter(None, (given_up, unclosed))) or none
        return {"zones": words.zones_legend(zones), "status": status, **self.summary()}

    def show_motions(self, found: list[Shown]) -> None:
        """Show the result of the fuller search at the point."""
        self.explorer.learn(found)
        self.searched = SEARCHED
        self.send(self.summary())

    def show_diagram(self, diagram: Any) -> None:
        """The diagram along the line."""
        self.changes |= pictures.diagram(diagram)
        self.send({"diagram": words.diagram_text(diagram)})

    def summary(self) -> dict[str, Any]:
        """Send the state, its link, the table and the texts; draw the changes of the figures."""
        explorer, state = self.explorer, self.explorer.state
        chosen = explorer.chosen
        running = state.show == "run" and self.trajectory is not None
        drawn = (
            running and self.trajectory, chosen and chosen.definition,
            state.osc, state.r, state.clearance, state.units,
        )  # fmt: skip
        if drawn != self.drawn and not self.peeking:
            self.drawn = drawn
            self.draw_motion(
                chosen.motion if chosen else None, self.trajectory if running else None
            )
        axes = (state.units, self.window)
        if axes != self.axes:
            self.axes = axes
            self.changes |= pictures.physical(*axes)
        marked = (state.r, state.clearance, state.line)
        if marked != self.marked:
            self.marked = marked
            self.changes |= pictures.point(*marked, self.spaces, state.window)
        return {
            "query": state.query,
            "fields": words.fields(explorer),
            "table": words.rows(explorer.shown, -1 if running else explorer.index),
            "place": words.place(state, explorer.shown, explorer.inside),
            "physical": words.physical_text(chosen.motion if chosen else None, state.units),
            "map": state.map == "on",
            "mapped": self.mapped,
            "box": state.box is not None,
            "boxed": self.boxed,
            "searched": self.searched,
            "run": self.ran,
            "running": running,
            "line": state.line is not None,
            "peek": False,
        }

    def draw_motion(self, motion: Motion | None, run: Trajectory | None = None) -> None:
        """Draw history, portrait and multipliers."""
        if run is not None:
            cycles: float = (self.explorer.state.run or Run()).cycles
        else:
            cycles = max(2, motion.pattern.cycles) if motion else 2
        self.changes |= sketches.history(
            motion if run is None else run, cycles, self.explorer.state.units
        )
        self.changes |= sketches.circle(motion)


def own_fault(error: Exception) -> str:
    """The message for an unexpected error; the details are printed on the terminal."""
    logging.getLogger(__name__).error("internal error of the explorer", exc_info=error)
    return f"internal error of the explorer: {error!r}"
