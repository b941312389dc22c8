"""The five figures (Bokeh), in the look of the other pictures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import (
    BasicTickFormatter,
    ColumnDataSource,
    CustomJS,
    FixedTicker,
    Range1d,
    Span,
)
from bokeh.plotting import figure

from ..plot import style
from ..plot.zone import LINES
from ..studies.bifurcation import BifurcationDiagram
from .shapes import circle, history, impacts

__all__ = ["Circle", "Diagram", "History", "ZoneChart", "dashes"]

#: Colours darker than those of the plots where they are text or thin lines on white.
GREY = "#595959"
#: What tells the page's script of the pointer.
TELL = (
    "window.vibroimpact && window.vibroimpact.pointer(name, cb_obj.event_name, cb_obj.x, cb_obj.y)"
)


def dashes(kind: str) -> tuple[list[int], str]:
    """Dash and colour of a type of boundary, in pixels."""
    line: Any
    line, shade = LINES[kind]
    pattern = [] if line == "-" else [max(1, round(2 * length)) for length in line[1]]
    return pattern, {"0.4": GREY, "0.8": "#CCCCCC"}.get(str(shade), str(shade))


def blank(name: str, events: tuple[str, ...] = (), **options: Any) -> Any:
    """A figure without tools that fills its place on the page, and tells of the pointer."""
    plot = figure(
        name=name, tools="", toolbar_location=None, sizing_mode="stretch_both", min_border=4,
        min_border_right=16, outline_line_color=None, background_fill_color="#FFFFFF", **options,
    )  # fmt: skip
    plot.grid.grid_line_color = "#EBEBEB"
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = "#222222"
        axis.axis_label_text_font_size = "13px"
        axis.major_label_text_font_size = "12px"
        axis.axis_line_color = axis.major_tick_line_color = "#444444"
        axis.minor_tick_line_color = None
    for event in events:
        plot.js_on_event(event, CustomJS(args={"name": name}, code=TELL))
    return plot


def fit(limits: Any, values: Any, room: float = 0.06) -> None:
    """Let an axis show some values, with some room beside them."""
    low, high = (float(np.min(values)), float(np.max(values))) if len(values) else (0.0, 1.0)
    size = (high - low) or max(abs(high), 1.0)
    limits.start, limits.end = low - room * size, high + room * size


def source(*columns: str) -> Any:
    """An empty table."""
    return ColumnDataSource({name: [] for name in columns})


class ZoneChart:
    """Zones with their boundaries, the chosen point, and the line of the diagram."""

    def __init__(self) -> None:
        self.plot = plot = blank(
            "zones", ("mousemove", "mouseleave", "tap", "panstart", "pan", "panend"),
            x_axis_label="frequency ratio  r = Ω/ω", y_axis_label="clearance  dK/F₀", y_axis_type="log",
            x_range=Range1d(0, 1), y_range=Range1d(1, 2),
        )  # fmt: skip
        plot.yaxis.formatter = BasicTickFormatter(use_scientific=False)
        self.fills = source("xs", "ys", "color")
        plot.multi_polygons(
            "xs", "ys", source=self.fills, fill_color="color", fill_alpha=0.16, line_color=None
        )
        self.lines = {}
        for kind in LINES:
            if kind == "window":
                continue
            self.lines[kind] = source("xs", "ys")
            dash, shade = dashes(kind)
            plot.multi_line(
                "xs",
                "ys",
                source=self.lines[kind],
                line_color=shade,
                line_dash=value(dash),
                line_width=2,
            )
        self.labels = source("x", "y", "text")
        plot.text(
            "x", "y", "text", source=self.labels, text_align="center", text_baseline="middle",
            text_font_size="12px", text_color="#222222", padding=2,
            background_fill_color="#FFFFFF", background_fill_alpha=0.75,  # names stand on lines at times
        )  # fmt: skip
        self.line = source("x", "y")
        plot.line("x", "y", source=self.line, line_color="#222222", line_width=2, line_dash="2 3")
        plot.scatter("x", "y", source=self.line, marker="square", size=7, color="#222222")
        self.point = source("x", "y")
        plot.scatter(
            "x", "y", source=self.point, marker="circle_cross", size=15, line_color="#000000",
            line_width=2, fill_color="#FFFFFF", fill_alpha=0.8,
        )  # fmt: skip

    def mark(self, r: float, clearance: float, line: Any) -> None:
        """The chosen point, and the line or None."""
        self.point.data = {"x": [r], "y": [clearance]}
        self.line.data = {"x": [], "y": []} if line is None else {"x": line[::2], "y": line[1::2]}

    def draw(self, shapes: dict[str, Any], window: Any) -> None:
        """Zones in a window."""
        (left, right), (low, high) = window
        # a little more than the window: the last tick is a rounding error above it
        self.plot.x_range.start, self.plot.x_range.end = left, right + 1e-9 * (right - left)
        self.plot.y_range.start, self.plot.y_range.end = low, high
        self.plot.yaxis.ticker = self.plot.ygrid.ticker = FixedTicker(ticks=decades(low, high))
        self.fills.data = shapes["fills"]
        for kind, table in shapes["lines"].items():
            if table["xs"] or self.lines[kind].data["xs"]:
                self.lines[kind].data = table
        self.labels.data = shapes["labels"]


def decades(low: float, high: float) -> list[float]:
    """Ticks 1, 2, 5, 10, … between two numbers; even ones where that gives too few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [float(f"{digit}e{power}") for power in powers for digit in (1, 2, 5)]
    inside = [tick for tick in ticks if low <= tick <= high]
    if len(inside) > 12:
        inside = [tick for tick in inside if f"{tick:e}"[0] == "1"]
    return inside if len(inside) > 2 else np.linspace(low, high, 5).tolist()


class History:
    """Time history with walls and impacts, and the portrait of the relative motion."""

    def __init__(self) -> None:
        self.curves = source("t", "x", "z", "right", "left", "y", "y_dot")
        self.events = source("t", "x", "y", "y_dot", "marker")
        self.time = blank(
            "history", x_axis_label="time  (load cycles)", y_axis_label="X, Z  (F₀/K)",
            x_range=Range1d(0, 1), y_range=Range1d(0, 1),
        )  # fmt: skip
        blue = {"source": self.curves, "line_color": style.PRIMARY}
        self.time.varea(
            "t", "left", "right", source=self.curves, fill_color=style.PRIMARY, fill_alpha=0.07
        )
        for wall in ("left", "right"):
            self.time.line("t", wall, line_dash="5 3", line_width=1, **blue)
        self.time.line("t", "x", line_width=2, **blue)
        self.time.line("t", "z", source=self.curves, line_color=style.FREE, line_width=1.5)
        marks = {"source": self.events, "marker": "marker", "size": 7, "line_color": "#FFFFFF"}
        self.time.scatter("t", "x", fill_color=style.IMPACT, **marks)
        self.portrait = blank(
            "portrait", ("tap",), x_axis_label="Y = Z − X  (F₀/K)", y_axis_label="dY/dt  (ωF₀/K)",
            x_range=Range1d(0, 1), y_range=Range1d(0, 1),
        )  # fmt: skip
        self.portrait.xaxis.ticker.desired_num_ticks = 4
        self.walls = [
            Span(dimension="height", line_color=style.PRIMARY, line_dash=[5, 3]) for _ in range(2)
        ]
        for wall in self.walls:
            self.portrait.add_layout(wall)
        self.portrait.line("y", "y_dot", source=self.curves, line_color=style.FREE, line_width=1.5)
        self.portrait.scatter("y", "y_dot", fill_color=style.IMPACT, **marks)

    def draw(self, thing: Any, cycles: float) -> None:
        """A motion or a trajectory; None clears."""
        if thing is None:
            for table in (self.curves, self.events):
                table.data = {name: [] for name in table.data}
            return
        tables = history(thing, cycles)
        for sign, wall in zip((1, -1), self.walls, strict=True):
            wall.location = 0.5 * sign * thing.clearance
        curves = tables["curves"]
        fit(self.time.x_range, curves["t"], 0)
        fit(self.time.y_range, np.r_[curves["left"], curves["right"]])
        fit(self.portrait.x_range, (-0.5 * thing.clearance, 0.5 * thing.clearance))
        fit(self.portrait.y_range, curves["y_dot"])
        self.curves.data, self.events.data = tables["curves"], tables["events"]


class Circle:
    """The multipliers in the unit circle."""

    def __init__(self) -> None:
        self.plot = blank("circle", x_axis_label="Re λ", y_axis_label="Im λ")
        self.plot.match_aspect = True
        # what the axes follow, so that the circle stays round in any frame
        self.plot.scatter([-1.9, 1.9], [-1.9, 1.9], alpha=0)
        self.plot.circle(
            0, 0, radius=1, fill_color=style.PRIMARY, fill_alpha=0.06, line_color="#222222"
        )
        self.points = source("x", "y", "marker", "text", "align")
        self.plot.scatter(
            "x", "y", source=self.points, marker="marker", size=10, line_color=style.FREE,
            fill_color=style.FREE, line_width=2,
        )  # fmt: skip
        self.plot.text(
            "x",
            "y",
            "text",
            source=self.points,
            text_align="align",
            y_offset=-8,
            text_font_size="12px",
        )

    def draw(self, motion: Any) -> None:
        """A motion; None clears."""
        self.points.data = circle(motion)


class Diagram:
    """Positions at the impacts along a line."""

    def __init__(self) -> None:
        self.plot = blank(
            "diagram", y_axis_label="X at the impacts  (F₀/K)", x_axis_label="r = Ω/ω",
            x_range=Range1d(0, 1), y_range=Range1d(0, 1),
        )  # fmt: skip
        self.impacts = {side: source("along", "x") for side in "RL"}
        marks = {"R": ("circle", 2.5, style.PRIMARY), "L": ("x", 4, style.FREE)}
        for side, (marker, size, shade) in marks.items():
            self.plot.scatter(
                "along", "x", source=self.impacts[side], marker=marker, size=size, color=shade
            )
        self.here = Span(dimension="height", line_color="#222222", line_dash=[2, 3], line_width=1)
        self.plot.add_layout(self.here)

    def draw(self, diagram: BifurcationDiagram) -> None:
        """The impacts of both sweeps."""
        named = {"r": "frequency ratio  r = Ω/ω", "clearance": "clearance  dK/F₀"}
        self.plot.xaxis.axis_label = named[diagram.parameter]
        fit(self.plot.x_range, diagram.values, 0)
        fit(self.plot.y_range, diagram.points["x"])
        for side, table in impacts(diagram).items():
            self.impacts[side].data = table
