"""One open page: what the browser asks for goes to the explorer, what follows goes to the figures."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from ..errors import VibroimpactError
from ..motion import Motion
from ..trajectory import Trajectory
from .explorer import Explorer, diagram_of, settles_on, simulate_run
from .export import as_namelist, as_python
from .figures import Circle, Diagram, History, ZoneChart
from .latest import Current, Latest
from .motions import Shown, fuller
from .shapes import color, zone_shapes
from .state import NUMBERS, WINDOW, Run, State, joined, number_text, pattern_text
from .zones import COARSE, FINE, compute, families

__all__ = ["Session"]

#: Seconds that the pointer has to rest before there is a fuller search where it is.
REST = 0.3
SEARCHED = "All patterns of up to 6 impacts and 2 cycles were searched."


class Session:
    """One open page.

    Computing that takes longer than a frame is done in threads, of which only the newest piece counts: zones,
    the fuller search at the point, the same where the pointer rests, the diagram.

    Parameters
    ----------
    query : str
        Of the link.
    tell : callable
        Sends a message to the page's script.
    at_its_turn : callable
        Does some work on the page when it is the page's turn: how a thread comes back.
    """

    def __init__(
        self,
        query: str,
        tell: Callable[..., None],
        at_its_turn: Callable[[Callable[[], None]], None],
    ) -> None:
        state, self.faults = State.read(query)
        self.explorer = Explorer(state)
        self.faults += self.explorer.restore()
        self.tell, self.at_its_turn = tell, at_its_turn
        self.chart, self.history, self.circle, self.diagram = (
            ZoneChart(), History(), Circle(), Diagram(),
        )  # fmt: skip
        self.zones, self.search, self.rest, self.sweep = Latest(), Latest(), Latest(), Latest()
        self.fine, self.coarse = Latest(), threading.Event()
        self.trajectory: Trajectory | None = None
        self.peeking, self.searched, self.ran = False, "", ""
        #: What the zones, the motions, the diagram and the figures of the motion were made for.
        self.zones_of: Any = None
        self.motions_of: Any = None
        self.diagram_of: Any = None
        self.drawn: Any = None

    @property
    def plots(self) -> list[Any]:
        """The figures."""
        history = self.history
        return [
            self.chart.plot,
            history.time,
            history.portrait,
            self.circle.plot,
            self.diagram.plot,
        ]

    # -- messages of the page

    def heard(self, message: dict[str, Any]) -> None:
        """Answer a message, whatever comes of it."""
        kind = message["kind"]
        self.peeking = kind == "peek"
        try:
            answer = {"fault": "", **getattr(self, f"on_{kind}")(message)}
        except VibroimpactError as error:
            answer = {"fault": str(error), **self.summary()}
        except Exception as error:
            self.tell(number=message["number"], fault=f"a fault of the explorer's own: {error!r}")
            raise
        self.tell(number=message["number"], **answer)

    def on_ready(self, _: dict[str, Any]) -> dict[str, Any]:
        """The page is there."""
        fault = ""
        if self.faults:
            fault = f"The link holds what is not allowed; the rest of it is restored. {joined(self.faults)}"
        answer = {**self.update(), "fault": fault}
        if self.faults:
            del answer["query"]  # the address stays as it was given until something changes
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
        """The pointer is somewhere: show the motions there, without choosing the point."""
        r, clearance = message["r"], message["clearance"]
        shown = self.explorer.peek(r, clearance)
        osc = self.explorer.state.osc

        def further(current: Current) -> None:
            threading.Event().wait(REST)
            if not (current() and self.peeking):
                return
            found = fuller(osc, r, clearance, shown)
            self.later(
                lambda: (
                    self.peeked(r, clearance, found, SEARCHED)
                    if current() and self.peeking
                    else None
                )
            )

        self.rest.submit(further)
        return self.peeked(r, clearance, shown, "Searching further where the pointer rests …")

    def peeked(
        self, r: float, clearance: float, shown: list[Shown], searched: str
    ) -> dict[str, Any]:
        """The motions where the pointer is."""
        self.drawn = None
        self.draw_motion(shown[0].motion if shown else None)
        place = self.place(r, clearance, shown)
        return {"table": rows(shown, 0), "place": place, "searched": searched, "peek": True}

    def on_unpeek(self, _: dict[str, Any]) -> dict[str, Any]:
        """The pointer has left."""
        return self.summary()

    def on_choose(self, message: dict[str, Any]) -> dict[str, Any]:
        """A motion of the table, or the simulation below them."""
        index = int(message["index"])
        if index < 0:
            self.explorer.set({"show": "run"})
        else:
            self.explorer.choose(index)
        return self.summary()

    def on_run(self, message: dict[str, Any]) -> dict[str, Any]:
        """Let it run from the state in the fields."""
        words = message["words"]
        text = ",".join(words[name] for name in Run.__dataclass_fields__)
        run = State().changed({"run": text}).run
        return self.runs(self.explorer.let_run(run or Run()))

    def on_launch(self, message: dict[str, Any]) -> dict[str, Any]:
        """Let it run from a place in the portrait."""
        return self.runs(self.explorer.launch(message["y"], message["y_dot"]))

    def runs(self, trajectory: Trajectory) -> dict[str, Any]:
        """There is a simulation."""
        self.trajectory, self.ran = trajectory, run_text(trajectory)
        return self.summary()

    def on_stop(self, _: dict[str, Any]) -> dict[str, Any]:
        """No simulation any more."""
        self.explorer.set({"run": "", "show": "motion"})
        self.trajectory, self.ran = None, ""
        return self.summary()

    def on_line(self, message: dict[str, Any]) -> dict[str, Any]:
        """A line was drawn."""
        a, b = message["from"], message["to"]
        self.explorer.draw_line((*a, *b))
        return self.update()

    def on_erase(self, _: dict[str, Any]) -> dict[str, Any]:
        """No line any more."""
        self.explorer.set({"line": ""})
        return self.update()

    def on_export(self, message: dict[str, Any]) -> dict[str, Any]:
        """What is shown, as text."""
        write = {"namelist": as_namelist, "python": as_python}[message["form"]]
        return {"export": write(self.explorer), "form": message["form"]}

    # -- what follows

    def update(self) -> dict[str, Any]:
        """After a change of the state: compute what it takes, in threads, and tell what is known at once."""
        state = self.explorer.state
        line, busy = state.line, {}
        self.chart.mark(state.r, state.clearance, line)
        wanted = (state.osc, state.window, state.patterns)
        if wanted != self.zones_of:
            self.zones_of, busy = wanted, {"status": "computing …"}
            self.coarse.clear()
            self.zones.submit(self.compute_zones)
        point = (state.osc, state.r, state.clearance)
        if point != self.motions_of:
            self.motions_of, self.searched = point, "Searching further …"
            self.search.submit(self.compute_motions)
            self.simulate()
        if line is not None:
            self.diagram.here.location = state.clearance if line[0] == line[2] else state.r
            if (state.osc, line) != self.diagram_of:
                self.diagram_of = (state.osc, line)
                self.sweep.submit(self.compute_diagram)
        return busy | self.summary()

    def simulate(self) -> None:
        """The simulation at another point or of another system; an error shows beside its button."""
        self.trajectory, self.ran = None, ""
        if self.explorer.state.run is not None:
            try:
                self.trajectory = simulate_run(self.explorer.state)
                self.ran = run_text(self.trajectory)
            except VibroimpactError as error:
                self.ran = str(error)

    def later(self, work: Callable[[], dict[str, Any] | None]) -> None:
        """From a thread: do something with the page when it is its turn."""

        def tell() -> None:
            answer = work()
            if answer is not None:
                self.tell(**answer)

        self.at_its_turn(tell)

    def compute_zones(self, current: Current) -> None:
        """All zones coarsely, which is shown at once; finely afterwards."""
        state = self.explorer.state
        named = list(families(state.osc, state.patterns))
        with ThreadPoolExecutor(2) as pool:
            zones = list(
                pool.map(lambda item: compute(state.osc, item, state.window, COARSE), named)
            )
        self.show_zones(state, dict(zip(named, zones, strict=True)), "refining …")
        self.coarse.set()
        self.fine.submit(lambda _: self.refine_zones(state))

    def refine_zones(self, state: State) -> None:
        """The zones finely, unless something else is wanted by then: a call of the core cannot be stopped."""
        fine = {}
        for family in families(state.osc, state.patterns):
            if self.zones_of != (state.osc, state.window, state.patterns):
                return
            fine[family] = compute(state.osc, family, state.window, FINE)
        self.show_zones(state, fine, "")

    def show_zones(self, state: State, zones: Any, status: str) -> None:
        """Draw zones that a thread has computed."""
        shapes = zone_shapes(zones)

        def draw() -> dict[str, Any] | None:
            if status == "" and self.zones_of != (state.osc, state.window, state.patterns):
                return None
            self.explorer.zones = zones
            self.chart.draw(shapes, state.window)
            self.explorer.look()  # the zones may know of motions that were not found
            return {"zones": zones_legend(zones), "status": status, **self.summary()}

        self.later(draw)

    def compute_motions(self, current: Current) -> None:
        """The fuller search at the point."""
        self.coarse.wait(10)  # zones first: they are what a slider is watched for
        if not current():
            return
        state, kept = self.explorer.state, self.explorer.shown
        found = fuller(state.osc, state.r, state.clearance, kept)

        def show() -> dict[str, Any] | None:
            if not current():
                return None
            self.explorer.learn(found)
            self.searched = SEARCHED
            return self.summary()

        self.later(show)

    def compute_diagram(self, current: Current) -> None:
        """The diagram along the line."""
        diagram = diagram_of(self.explorer.state)

        def show() -> dict[str, Any] | None:
            if not current():
                return None
            self.diagram.draw(diagram)
            windows = [
                f"{item.label} from {item.low:.4g} to {item.high:.4g} ({item.run})"
                for item in diagram.windows if item.low < item.high
            ]  # fmt: skip
            return {"diagram": f"{len(diagram.points)} impacts. " + "; ".join(windows)}

        self.later(show)

    # -- what is told and drawn

    def summary(self) -> dict[str, Any]:
        """The state, its link, the table and the texts; the figures of the motion are drawn if they changed."""
        explorer, state = self.explorer, self.explorer.state
        chosen = explorer.chosen
        running = state.show == "run" and self.trajectory is not None
        drawn = (
            running and self.trajectory,
            chosen and chosen.recipe,
            state.osc,
            state.r,
            state.clearance,
        )
        if drawn != self.drawn and not self.peeking:
            self.drawn = drawn
            self.draw_motion(
                chosen.motion if chosen else None, self.trajectory if running else None
            )
        run = explorer.start()
        return {
            "query": state.query,
            "fields": {name: number_text(getattr(state, name)) for name in (*NUMBERS, *WINDOW)}
            | {"patterns": " ".join(map(pattern_text, state.patterns))}
            | {f"run_{name}": number_text(value) for name, value in vars(run).items()},
            "table": rows(explorer.shown, -1 if running else explorer.index),
            "place": self.place(state.r, state.clearance, explorer.shown),
            "searched": self.searched,
            "run": self.ran,
            "running": running,
            "line": state.line is not None,
            "peek": False,
        }

    def draw_motion(self, motion: Motion | None, run: Trajectory | None = None) -> None:
        """History, portrait and multipliers."""
        if run is not None:
            self.history.draw(run, (self.explorer.state.run or Run()).cycles)
        else:
            self.history.draw(motion, max(2, motion.pattern.cycles) if motion else 2)
        self.circle.draw(motion)

    def place(self, r: float, clearance: float, shown: list[Shown]) -> str:
        """The point in words."""
        zones = self.explorer.zones
        inside = [item.name for item, zone in zones.items() if bool(zone.contains(r, clearance))]
        stable = sum(bool(item.motion.stable) for item in shown)
        within = (
            f"in the zone{'s' * (len(inside) > 1)} of {', '.join(inside)}"
            if inside
            else "in no zone"
        )
        count = f"{len(shown)} motion{'s' * (len(shown) != 1)}, {stable} stable"
        return f"r = {r:.5g}, dK/F₀ = {clearance:.5g}: {count}; {within}"


def run_text(trajectory: Trajectory) -> str:
    """What comes of a simulation."""
    kinds = trajectory.events["kind"].tolist()
    counts = [
        f"{n} {name}{'s' * (n != 1)}"
        for n, name in ((kinds.count("impact"), "impact"), (kinds.count("stick"), "rest"))
    ]
    return f"{', '.join(counts)}; {settles_on(trajectory)}"


def rows(shown: list[Shown], chosen: int) -> list[dict[str, Any]]:
    """The table of motions."""
    table = []
    words = {True: "stable", False: "unstable", None: "on the edge"}
    for i, item in enumerate(shown):
        motion = item.motion
        table.append(
            {
                "label": item.label, "stable": words[motion.stable], "chosen": i == chosen,
                "attenuation": f"{motion.attenuation:.6g}" if motion.A > 0 else "–",
                "multiplier": f"{abs(complex(motion.multipliers[0])):.6g}",
                "kind": motion.leading_kind or "",
            }
        )  # fmt: skip
    return table


def zones_legend(zones: Any) -> list[dict[str, str]]:
    """Names and colours of the zones that are there."""
    return [
        {"name": family.name, "color": color(i)}
        for i, (family, zone) in enumerate(zones.items()) if zone
    ]  # fmt: skip
