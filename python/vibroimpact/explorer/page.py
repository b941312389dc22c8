"""The page: what the browser asks for goes to the explorer, what follows goes to the figures."""

from __future__ import annotations

import html
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from typing import Any

import panel as pn
from panel.custom import JSComponent

from ..errors import VibroimpactError
from ..motion import Motion
from ..plot.style import condition_name
from ..plot.zone import LINES
from ..trajectory import Trajectory
from .explorer import Explorer, diagram_of, settles_on, simulate_run
from .export import as_namelist, as_python
from .figures import Circle, Diagram, History, ZoneChart, dashes
from .latest import Current, Latest
from .motions import Shown, fuller
from .shapes import color, zone_shapes
from .state import NUMBERS, WINDOW, Run, State, joined, pattern_text
from .zones import COARSE, FINE, compute, families

__all__ = ["page"]

#: Sliders: name, what it is, symbol, greatest value, step.
SLIDERS = (
    ("xi", "damping ratio", "ξ", 0.1, 0.0001),
    ("mu", "mass ratio", "μ", 0.2, 0.001),
    ("R1", "restitution, right wall", "R₁", 1, 0.005),
    ("R2", "restitution, left wall", "R₂", 1, 0.005),
)
#: Fields of a simulation: name, symbol.
RUN_FIELDS = (
    ("x", "X", "F₀/K"), ("x_dot", "Ẋ", "ωF₀/K"), ("z", "Z", "F₀/K"), ("z_dot", "Ż", "ωF₀/K"),
    ("t", "t", "1/ω"), ("cycles", "shown", "load cycles"), ("discard", "before", "load cycles"),
)  # fmt: skip


def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


class Bridge(JSComponent):  # type: ignore[misc]
    """Messages to and from the page's script."""

    _esm = _text("page.js")

    def __init__(self, heard: Callable[[dict[str, Any]], None], **options: Any) -> None:
        super().__init__(**options)
        self.heard = heard

    def _handle_msg(self, message: dict[str, Any]) -> None:
        self.heard(message)

    def tell(self, **message: Any) -> None:
        """Send a message."""
        self._send_msg(message)


class Session:
    """One open page.

    Computing that takes longer than a frame is done in threads, of which only the newest piece counts: zones,
    the fuller search at the point, the diagram.
    """

    def __init__(self, query: str) -> None:
        state, self.faults = State.read(query)
        self.explorer = Explorer(state)
        self.faults += self.explorer.restore()
        self.zones, self.search, self.sweep = Latest(), Latest(), Latest()
        self.coarse = threading.Event()
        self.chart, self.history, self.circle, self.diagram = ZoneChart(), History(), Circle(), Diagram()
        self.bridge = Bridge(self.heard, width=0, height=0)
        self.document = pn.state.curdoc
        self.trajectory: Trajectory | None = None
        self.drawn: tuple[Any, ...] = ()
        self.searched = ""

    # -- messages of the page

    def heard(self, message: dict[str, Any]) -> None:
        """Answer a message, whatever comes of it."""
        kind, number = str(message.get("kind")), message.get("number")
        answer: dict[str, Any] = {}
        with pn.io.hold(self.document):
            try:
                answer = getattr(self, f"on_{kind}")(message) or {}
                answer.setdefault("fault", "")
            except VibroimpactError as error:
                answer = {"fault": str(error), **self.summary()}
            self.bridge.tell(number=number, **answer)

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
        self.draw_motion(shown[0].motion if shown else None)
        return {"table": rows(shown, 0), "place": self.place(r, clearance, shown), "peek": True}

    def on_unpeek(self, _: dict[str, Any]) -> dict[str, Any]:
        """The pointer has left."""
        self.drawn = ()
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
        self.trajectory = self.explorer.let_run(State().changed({"run": text}).run or Run())
        return self.summary()

    def on_launch(self, message: dict[str, Any]) -> dict[str, Any]:
        """Let it run from a place in the portrait."""
        self.trajectory = self.explorer.launch(message["y"], message["y_dot"])
        return self.summary()

    def on_stop(self, _: dict[str, Any]) -> dict[str, Any]:
        """No simulation any more."""
        self.explorer.set({"run": "", "show": "motion"})
        self.trajectory = None
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
        self.chart.point.data = {"x": [state.r], "y": [state.clearance]}
        line = state.line
        self.chart.line.data = (
            {"x": [], "y": []} if line is None else {"x": line[::2], "y": line[1::2]}
        )
        wanted = (state.osc, state.window, state.patterns)
        if getattr(self, "zones_of", None) != wanted:
            self.zones_of = wanted
            self.coarse.clear()
            self.zones.submit(self.compute_zones)
        point = (state.osc, state.r, state.clearance)
        if getattr(self, "searched_at", None) != point:
            self.searched_at, self.searched = point, "searching further …"
            self.search.submit(self.compute_motions)
            self.simulate()
        swept = (state.osc, line)
        if getattr(self, "swept_along", (None, None)) != swept:
            self.swept_along = swept
            if line is not None:
                self.sweep.submit(self.compute_diagram)
        if line is not None:
            along = state.clearance if line[0] == line[2] else state.r
            self.diagram.here.location = along
        return self.summary()

    def simulate(self) -> None:
        """The simulation at another point or of another system; an error shows beside its button."""
        self.trajectory, self.run_fault = None, ""
        if self.explorer.state.run is not None:
            try:
                self.trajectory = simulate_run(self.explorer.state)
            except VibroimpactError as error:
                self.run_fault = str(error)

    def later(self, work: Callable[[], dict[str, Any] | None]) -> None:
        """From a thread: do something with the page when it is its turn."""

        def tell() -> None:
            answer = work()
            if answer is not None:
                self.bridge.tell(**answer)

        if self.document.session_context is not None:
            self.document.add_next_tick_callback(tell)

    def compute_zones(self, current: Current) -> None:
        """All zones coarsely, which is told at once; then finely, unless something else is wanted by then."""
        state = self.explorer.state
        named = list(families(state.osc, state.patterns))
        with ThreadPoolExecutor(2) as pool:
            zones = list(
                pool.map(lambda item: compute(state.osc, item, state.window, COARSE), named)
            )
        self.show_zones(state, dict(zip(named, zones, strict=True)), "refining …")
        self.coarse.set()
        fine = {}
        for family in named:
            if not current():
                return
            fine[family] = compute(state.osc, family, state.window, FINE)
        if current():
            self.show_zones(state, fine, "")

    def show_zones(self, state: State, zones: Any, status: str) -> None:
        """Draw zones that a thread has computed."""
        shapes = zone_shapes(zones)

        def draw() -> dict[str, Any]:
            self.explorer.zones = zones
            self.chart.draw(shapes, state.window)
            before = len(self.explorer.shown)
            if (state.osc, state.patterns) == (self.explorer.state.osc, self.explorer.state.patterns):
                self.explorer.look()
            if len(self.explorer.shown) != before:
                self.drawn = ()
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
            chosen = self.explorer.chosen
            self.explorer.shown = merge(found, self.explorer.shown)
            self.searched = "all patterns of up to 6 impacts and 2 cycles searched"
            if chosen is not self.explorer.chosen:
                self.drawn = ()
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
        drawn = (running and self.trajectory, chosen and chosen.recipe, state.osc, state.r, state.clearance)
        if drawn != self.drawn:
            self.drawn = drawn
            self.draw_motion(chosen.motion if chosen else None, self.trajectory if running else None)
        run = explorer.start()
        return {
            "query": state.query,
            "fields": {name: number(getattr(state, name)) for name in (*NUMBERS, *WINDOW)}
            | {"patterns": " ".join(map(pattern_text, state.patterns))}
            | {f"run_{name}": number(getattr(run, name)) for name, *_ in RUN_FIELDS},
            "table": rows(explorer.shown, -1 if running else explorer.index),
            "place": self.place(state.r, state.clearance, explorer.shown),
            "searched": self.searched,
            "run": self.run_text(),
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

    def run_text(self) -> str:
        """What comes of the simulation."""
        if self.trajectory is None:
            return getattr(self, "run_fault", "")
        kinds = self.trajectory.events["kind"].tolist()
        counts = f"{kinds.count('impact')} impacts, {kinds.count('stick')} rests"
        return f"{counts}; {settles_on(self.trajectory)}"

    def place(self, r: float, clearance: float, shown: list[Shown]) -> str:
        """The point in words."""
        zones = self.explorer.zones
        inside = [item.name for item, zone in zones.items() if bool(zone.contains(r, clearance))]
        stable = sum(bool(item.motion.stable) for item in shown)
        within = f"in the zone{'s' * (len(inside) > 1)} of {', '.join(inside)}" if inside else "in no zone"
        count = f"{len(shown)} motion{'s' * (len(shown) != 1)}, {stable} stable"
        return f"r = {r:.5g}, dK/F₀ = {clearance:.5g}: {count}; {within}"


def number(value: float) -> str:
    """All its digits, whole numbers without a point."""
    return repr(float(value)).removesuffix(".0")


def merge(found: list[Shown], shown: list[Shown]) -> list[Shown]:
    """Those of a fuller search, and what was added meanwhile."""
    known = {item.recipe for item in found}
    return [*found, *(item for item in shown if item.recipe not in known)]


def rows(shown: list[Shown], chosen: int) -> list[dict[str, Any]]:
    """The table of motions."""
    table = []
    for i, item in enumerate(shown):
        motion = item.motion
        leading = complex(motion.multipliers[0])
        table.append(
            {
                "label": item.label, "stable": {True: "stable", False: "unstable", None: "on the edge"}[motion.stable],
                "attenuation": f"{motion.attenuation:.6g}" if motion.A > 0 else "–",
                "multiplier": f"{abs(leading):.6g}", "kind": motion.leading_kind or "", "chosen": i == chosen,
            }
        )  # fmt: skip
    return table


def zones_legend(zones: Any) -> list[dict[str, str]]:
    """Names and colours of the zones that are there."""
    return [
        {"name": family.name, "color": color(i)}
        for i, (family, zone) in enumerate(zones.items()) if zone
    ]  # fmt: skip


def boundary_legend() -> str:
    """The types of boundaries, each with a piece of its line."""
    items = []
    for kind in LINES:
        if kind == "window":
            continue
        dash, shade = dashes(kind)
        line = (
            f'<svg width="44" height="10" aria-hidden="true"><line x1="1" y1="5" x2="43" y2="5" '
            f'stroke="{shade}" stroke-width="2" stroke-dasharray="{" ".join(map(str, dash))}"/></svg>'
        )
        items.append(f"<li>{line} {html.escape(condition_name(kind))}</li>")
    return "".join(items)


def page() -> Any:
    """The page of a new session, in the state that its link holds."""
    arguments = pn.state.session_args
    words = [(name, values[-1].decode("utf-8", "replace")) for name, values in arguments.items()]
    from urllib.parse import urlencode

    session = Session(urlencode(words))
    template = pn.Template(_text("page.html"))
    for name, text in (
        ("style", _text("page.css")), ("sliders", SLIDERS), ("run_fields", RUN_FIELDS),
        ("window_fields", WINDOW), ("boundaries", boundary_legend()),
    ):  # fmt: skip
        template.add_variable(name, text)
    figures = {
        "zones": session.chart.plot, "history": session.history.time, "portrait": session.history.portrait,
        "circle": session.circle.plot, "diagram": session.diagram.plot,
    }  # fmt: skip
    for name, plot in figures.items():
        template.add_panel(name, pn.pane.Bokeh(plot, sizing_mode="stretch_both", margin=0))
    template.add_panel("bridge", session.bridge)
    return template
