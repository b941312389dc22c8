"""The empty chart and diagram (Bokeh), in the style of the other pictures.

In the browser, the data from `pictures` go directly into the models with these names, not into their Python
copies.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.core.properties import value
from bokeh.models import (
    BasicTickFormatter,
    ColorBar,
    ColumnDataSource,
    CustomJS,
    FixedTicker,
    LinearAxis,
    LinearColorMapper,
    LinearScale,
    LogAxis,
    LogScale,
    NoOverlap,
    Range1d,
    Span,
)
from bokeh.palettes import Cividis256
from bokeh.plotting import figure

from ..plot import style
from ..plot.zone import LINES
from .attenuation import SIZE
from .pictures import ALPHAS

__all__ = ["dashes", "figures"]

#: Darker colours than in the plots, for text and thin lines on white.
GREY = "#595959"
#: The upper end of the colour scale of the map.
MOST = 2
#: JavaScript that reports the pointer to the page's script.
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
    """A figure without tools that fills its place on the page and reports the pointer."""
    plot = figure(
        name=f"{name}.plot", tools="", toolbar_location=None, sizing_mode="stretch_both", min_border=4,
        min_border_right=16, outline_line_color=None, background_fill_color="#FFFFFF", **options,
    )  # fmt: skip
    plot.grid.grid_line_color = "#EBEBEB"
    for axis in plot.axis:
        drawn(axis)
    for event in events:
        plot.js_on_event(event, CustomJS(args={"name": name}, code=TELL))
    return plot


def drawn(axis: Any) -> Any:
    """An axis in the style of the others."""
    axis.axis_label_text_font_style = "normal"
    axis.axis_label_text_color = axis.major_label_text_color = "#222222"
    axis.axis_label_text_font_size = "13px"
    axis.major_label_text_font_size = "12px"
    axis.axis_line_color = axis.major_tick_line_color = "#444444"
    axis.minor_tick_line_color = None
    axis.major_label_policy = NoOverlap(min_distance=6)  # in a narrow window
    return axis


def source(name: str, *columns: str) -> Any:
    """An empty table."""
    return ColumnDataSource({column: [] for column in columns}, name=name)


def ranges(name: str, high: float = 1, low: float = 0) -> dict[str, Any]:
    """Both axes of a figure, with names."""
    return {
        "x_range": Range1d(0, 1, name=f"{name}.x"),
        "y_range": Range1d(low, high, name=f"{name}.y"),
    }


def figures() -> dict[str, Any]:
    """Both figures by name."""
    return {"zones": zone_chart(), "diagram": diagram()}


def zone_chart() -> Any:
    """Zones with their boundaries, the chosen point, and the line of the diagram."""
    plot = blank(
        "zones", ("mousemove", "mouseleave", "tap", "doubletap", "panstart", "pan", "panend"),
        x_axis_label="frequency ratio  r = Ω/ω", y_axis_label="clearance  dK/F₀", y_axis_type="log",
        **ranges("zones", 2, 1),
    )  # fmt: skip
    plot.yaxis.formatter = BasicTickFormatter(use_scientific=False)
    plot.yaxis.ticker = plot.ygrid.ticker = FixedTicker(ticks=[1, 2], name="zones.ticks")
    physical_axes(plot)
    attenuation_map(plot)
    areas = plot.multi_polygons(
        "xs", "ys", source=source("zones.fills", "xs", "ys", "color", "hatch"), fill_color="color",
        fill_alpha=ALPHAS[0], line_color=None, hatch_pattern="hatch", hatch_color="color", hatch_alpha=ALPHAS[1],
        hatch_scale=14, hatch_weight=1,
    )  # fmt: skip
    areas.glyph.name = "zones.areas"
    for kind in LINES:
        if kind != "window":
            dash, shade = dashes(kind)
            plot.multi_line(
                "xs", "ys", source=source(f"zones.{kind}", "xs", "ys"), line_color=shade,
                line_dash=value(dash), line_width=2,
            )  # fmt: skip
    plot.text(
        "x", "y", "text", source=source("zones.labels", "x", "y", "text"), text_align="center",
        text_baseline="middle", text_font_size="12px", text_color="#222222", padding=2,
        background_fill_color="#FFFFFF", background_fill_alpha=0.75,  # names may overlap lines
    )  # fmt: skip
    line = source("zones.line", "x", "y")
    plot.line("x", "y", source=line, line_color="#222222", line_width=2, line_dash="2 3")
    plot.scatter("x", "y", source=line, marker="square", size=7, color="#222222")
    tolerance_box(plot)
    plot.scatter(
        "x", "y", source=source("zones.point", "x", "y"), marker="circle_cross", size=15,
        line_color="#000000", line_width=2, fill_color="#FFFFFF", fill_alpha=0.8,
    )  # fmt: skip
    return plot


def physical_axes(plot: Any) -> None:
    """Second axes of frequency and clearance, for a system with units."""
    plot.extra_x_scales = {"f": LinearScale()}
    plot.extra_y_scales = {"d": LogScale()}
    plot.extra_x_ranges = {"f": Range1d(0, 1, name="zones.f")}
    plot.extra_y_ranges = {"d": Range1d(1, 2, name="zones.d")}
    above = LinearAxis(x_range_name="f", visible=False, name="zones.above")
    beside = LogAxis(
        y_range_name="d", visible=False, name="zones.beside",
        ticker=FixedTicker(ticks=[1, 2], name="zones.d_ticks"),
        formatter=BasicTickFormatter(use_scientific=False),
    )  # fmt: skip
    plot.add_layout(drawn(above), "above")
    plot.add_layout(drawn(beside), "right")


def attenuation_map(plot: Any) -> None:
    """The map of max|X|/A, with its colour bar."""
    # mixed with white, so that lines and hatching remain visible
    light = [
        "#" + "".join(f"{(int(color[i : i + 2], 16) + 255) // 2:02x}" for i in (1, 3, 5))
        for color in Cividis256
    ]
    colors = LinearColorMapper(
        palette=light, low=0, high=MOST, nan_color="rgba(0, 0, 0, 0)", name="zones.colors"
    )
    wide, high = SIZE
    table = ColumnDataSource(
        {"image": [np.full((high, wide), np.nan)], "x": [0], "y": [1], "dw": [1], "dh": [1]}, name="zones.map"
    )  # fmt: skip
    plot.image(
        "image", "x", "y", "dw", "dh", source=table, color_mapper=colors, level="image",
        visible=False, name="zones.image",
    )  # fmt: skip
    bar = ColorBar(
        color_mapper=colors, title="max|X|/A of the worst attractor", visible=False, name="zones.bar",
        orientation="horizontal", height=10, padding=4, title_text_font_style="normal",
        title_text_font_size="13px", title_text_color="#222222", major_label_text_font_size="12px",
        ticker=FixedTicker(ticks=[0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 1.75, MOST]),
        major_label_overrides={MOST: f"≥ {MOST}"}, margin=0,
    )  # fmt: skip
    plot.add_layout(bar, "below")


def tolerance_box(plot: Any) -> None:
    """The tolerance box, and its points above the limit."""
    plot.quad(
        "left", "right", "bottom", "top", source=source("zones.box", "left", "right", "bottom", "top"),
        fill_color="#FFFFFF", fill_alpha=0.35, line_color="#000000", line_width=2.5,
    )  # fmt: skip
    plot.scatter(
        "x", "y", source=source("zones.bad", "x", "y"), marker="x", size=5, color=style.FREE, line_width=1.5
    )  # fmt: skip


def diagram() -> Any:
    """Positions at the impacts along a line."""
    plot = blank(
        "diagram",
        y_axis_label="X at the impacts  (F₀/K)",
        x_axis_label="r = Ω/ω",
        **ranges("diagram"),
    )
    plot.xaxis.name = "diagram.along"
    marks = {"R": ("circle", 2.5, style.PRIMARY), "L": ("x", 4, style.FREE)}
    for side, (marker, size, shade) in marks.items():
        plot.scatter(
            "along", "x", source=source(f"diagram.{side}", "along", "x"), marker=marker, size=size,
            color=shade,
        )  # fmt: skip
    plot.add_layout(
        Span(dimension="height", line_color="#222222", line_dash=[2, 3], line_width=1, name="diagram.here")
    )  # fmt: skip
    return plot
