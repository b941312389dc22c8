"""The page: its figures, its text and its script."""

from __future__ import annotations

import html
from collections.abc import Callable
from importlib.resources import files
from typing import Any
from urllib.parse import urlencode

import panel as pn
from bokeh.events import ConnectionLost
from bokeh.models import CustomJS
from panel.custom import JSComponent
from panel.io.state import set_curdoc

from ..base.errors import VibroimpactError
from ..plot.style import condition_name
from ..plot.zone import LINES
from .figures import dashes, figures
from .latest import Stale
from .limits import Places
from .messages import checked
from .pictures import packed
from .session import Session, own_fault
from .turns import Turns

__all__ = ["page"]

#: Sliders: name, meaning, symbol, largest value, step.
SLIDERS = (
    ("xi", "damping ratio", "ξ", 0.1, 0.0001),
    ("mu", "mass ratio", "μ", 0.2, 0.001),
    ("R1", "restitution, right wall", "R₁", 1, 0.005),
    ("R2", "restitution, left wall", "R₂", 1, 0.005),
)
#: Fields of a simulation: name, symbol.
RUN_FIELDS = (
    ("x", "X", "F₀/K"), ("x_dot", "Ẋ", "ωF₀/K"), ("z", "Z", "F₀/K"), ("z_dot", "Ż", "ωF₀/K"),
    ("t", "t", "1/ω"), ("cycles", "shown", "cycles"), ("discard", "discarded", "cycles"),
)  # fmt: skip


#: Fields of the tolerance box: name, text.
BOX_FIELDS = (
    ("r", "box: r"), ("r_half", "± r"), ("clearance", "box: dK/F₀"), ("clearance_half", "± dK/F₀")
)  # fmt: skip
#: The open pages. A page that was closed or reloaded counts for another half minute.
PLACES = Places(100)


def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


class Bridge(JSComponent):  # type: ignore[misc]
    """Messages to and from the page's script."""

    _esm = _text("sketch.js") + _text("page.js")
    heard: Callable[[dict[str, Any]], None]

    def _process_bokeh_event(self, document: Any, event: Any) -> None:
        # as in panel, but without the busy indicator, which takes a quarter of the time of a pointer move
        with set_curdoc(document):
            self._process_event(event)

    def _handle_msg(self, message: dict[str, Any]) -> None:
        self.heard(message)

    def deliver(self, text: str, numbers: Any) -> None:
        """Send a message: JSON, which Bokeh passes on unchanged, and an array."""
        self._send_msg({"text": text, "numbers": numbers})


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
    """The page of a new session, in the state of its link; a text if too many pages are open."""
    words = [
        (name, values[-1].decode("utf-8", "replace"))
        for name, values in pn.state.session_args.items() if not name.startswith("bokeh-")
    ]  # fmt: skip
    document = pn.state.curdoc
    if not PLACES.enter():
        return pn.pane.Str(
            f"{PLACES.most} pages of the explorer are open, and no more are allowed: close some, wait for half a "
            "minute, and load this one again"
        )
    bridge = Bridge(width=0, height=0)
    document.js_on_event(
        ConnectionLost, CustomJS(code="window.vibroimpact && window.vibroimpact.lost()")
    )

    turns = Turns()

    def deliver(text: str, numbers: Any) -> None:
        if document.session_context is not None:  # otherwise the page has been closed
            document.add_next_tick_callback(lambda: bridge.deliver(text, numbers))

    # the first messages wait until the session exists: a link may request long computations
    session: list[Session] = []

    def heard(message: Any) -> None:
        number = message.get("number") if isinstance(message, dict) else None
        try:
            message = checked(message)
            if not session:
                session.append(Session(urlencode(words), deliver, turns.submit))
            if turns.closed:
                raise Stale
            session[0].heard(message)
        except Stale:
            raise
        except Exception as error:
            fault = str(error) if isinstance(error, VibroimpactError) else own_fault(error)
            deliver(*packed({"fault": fault, "number": number, "pictures": {}}))

    def closed(_: Any) -> None:
        PLACES.leave()
        turns.close()
        for one in session:
            one.close()

    bridge.heard = lambda message: turns.offer(lambda: heard(message))
    pn.state.on_session_destroyed(closed)
    template = pn.Template(_text("page.html"))
    for name, text in (
        ("style", _text("page.css")), ("sliders", SLIDERS), ("run_fields", RUN_FIELDS),
        ("box_fields", BOX_FIELDS),
        ("boundaries", boundary_legend()),
    ):  # fmt: skip
        template.add_variable(name, text)
    for name, plot in figures().items():
        template.add_panel(name, pn.pane.Bokeh(plot, sizing_mode="stretch_both", margin=0))
    template.add_panel("bridge", bridge)
    return template
