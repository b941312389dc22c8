"""Changes to the chart and the diagram as plain data: attributes of their models, by name.

The script of the page applies all changes together, so that there is one message and one redraw of each figure.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import BifurcationDiagram, Units
from .attenuation import Judged
from .shapes import labels
from .state import Box
from .zones import Window

__all__ = [
    "ALPHAS",
    "Changes",
    "box",
    "diagram",
    "fit",
    "map_picture",
    "packed",
    "physical",
    "point",
    "zones",
]

#: Opacity of zones and of their hatching without a map.
ALPHAS = 0.16, 0.25
#: Opacity on a map; with no fill at all, Bokeh would not draw the hatching.
ON_MAP = 0.004, 0.4
#: New attribute values of models, by the models' names in `figures`; the figures of `sketches` are sent complete.
Changes = dict[str, dict[str, Any]]


def point(
    r: float,
    clearance: float,
    line: tuple[float, ...] | None,
    spaces: dict[str, Any],
    window: Window,
) -> Changes:
    """The chosen point, the line of the diagram or None, and the zones' names, which are placed away from the
    point."""
    ends = ([], []) if line is None else (line[::2], line[1::2])
    changes: Changes = {
        "zones.point": {"data": {"x": [r], "y": [clearance]}},
        "zones.line": {"data": {"x": list(ends[0]), "y": list(ends[1])}},
        "zones.labels": {"data": labels(spaces, window, (r, clearance))},
    }
    if line is not None:
        changes["diagram.here"] = {"location": clearance if line[0] == line[2] else r}
    return changes


def zones(shapes: dict[str, Any], window: Window) -> Changes:
    """Zones in a window."""
    (left, right), (low, high) = window
    return {
        # slightly more than the window: rounding may put the last tick beyond it
        "zones.x": {"start": left, "end": right + 1e-9 * (right - left)},
        "zones.y": {"start": low, "end": high},
        "zones.ticks": {"ticks": decades(low, high)},
        "zones.fills": {"data": shapes["fills"]},
        **{f"zones.{kind}": {"data": table} for kind, table in shapes["lines"].items()},
    }


def decades(low: float, high: float) -> list[float]:
    """Ticks 1, 2, 5, 10, … between two numbers; evenly spaced ticks if these are too few."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [float(f"{digit}e{power}") for power in powers for digit in (1, 2, 5)]
    inside = [tick for tick in ticks if low <= tick <= high]
    if len(inside) > 12:
        inside = [tick for tick in inside if f"{tick:e}"[0] == "1"]
    return inside if len(inside) > 2 else np.linspace(low, high, 5).tolist()


def physical(units: Units | None, window: Window) -> Changes:
    """The second axes of the chart, if there are units."""
    if units is None:
        return {"zones.above": {"visible": False}, "zones.beside": {"visible": False}}
    units = units.of_pictures
    f0, f1 = (r * units.frequency for r in window[0])
    d0, d1 = (clearance * units.length for clearance in window[1])
    return {
        "zones.f": {"start": f0, "end": f1},
        "zones.d": {"start": d0, "end": d1},
        "zones.d_ticks": {"ticks": decades(d0, d1)},
        "zones.above": {"visible": True, "axis_label": f"load frequency  ({units.hertz})"},
        "zones.beside": {"visible": True, "axis_label": f"clearance d  ({units.name('F0/K')})"},
    }


def map_picture(picture: NDArray[np.float64] | None, window: Window) -> Changes:
    """The map of max|X|/A, a picture with rows along the clearance; None for no map.

    Zones drawn over the map keep only their lines and hatching.
    """
    on = picture is not None
    changes: Changes = {name: {"visible": on} for name in ("zones.image", "zones.bar")}
    fill, hatch = ON_MAP if on else ALPHAS
    changes["zones.areas"] = {"fill_alpha": {"value": fill}, "hatch_alpha": {"value": hatch}}
    if picture is not None:
        (r0, r1), (d0, d1) = window
        image = {"image": picture.ravel(), "shape": list(picture.shape)}
        changes["zones.map"] = {
            "data": {"x": [r0], "y": [d0], "dw": [r1 - r0], "dh": [d1 - d0]},
            **image,
        }
    return changes


def box(place: Box | None, found: Judged | None, good: NDArray[np.bool_] | None) -> Changes:
    """The tolerance box, and its points that exceed the limit, if known."""
    ends = {"left": [], "right": [], "bottom": [], "top": []} if place is None else dict(
        zip(("left", "right", "bottom", "top"), ([end] for pair in place.ends for end in pair), strict=True)
    )  # fmt: skip
    bad: dict[str, Any] = {"x": [], "y": []}
    if found is not None and good is not None:
        bad = {"x": found.r[~good], "y": found.clearance[~good]}
    return {"zones.box": {"data": ends}, "zones.bad": {"data": bad}}


def diagram(found: BifurcationDiagram) -> Changes:
    """Positions at the impacts along the line, wall by wall."""
    named = {"r": "frequency ratio  r = Ω/ω", "clearance": "clearance  dK/F₀"}
    points = found.points
    along = found.values[points["index"]]
    changes: Changes = {
        "diagram.along": {"axis_label": named[found.parameter]},
        "diagram.x": ends(found.values, 0),
        "diagram.y": ends(points["x"]),
    }
    for side in "RL":
        mask = points["side"] == side
        changes[f"diagram.{side}"] = {"data": {"along": along[mask], "x": points["x"][mask]}}
    return changes


def ends(values: ArrayLike, margin: float = 0.06) -> dict[str, float]:
    """The attributes for the ends of an axis that shows the given values."""
    return dict(zip(("start", "end"), fit(values, margin), strict=True))


def fit(values: ArrayLike, margin: float = 0.06) -> tuple[float, float]:
    """The ends of an axis that shows the given values, with a margin at both ends."""
    shown = np.asarray(values, dtype=float)
    low, high = (float(shown.min()), float(shown.max())) if shown.size else (0.0, 1.0)
    size = (high - low) or max(abs(high), 1.0)
    return low - margin * size, high + margin * size


def packed(message: dict[str, Any]) -> tuple[str, NDArray[np.float64]]:
    """A message as JSON, and all its arrays in a single array; in the message, each array is replaced by
    `{"from": i, "to": j}`.

    Examples
    --------
    >>> import numpy as np
    >>> from vibroimpact.explorer.pictures import packed
    >>> packed({"fault": "", "x": np.array([1.0, 2.0]), "y": np.array([3.0, 4.0])})
    ('{"fault": "", "x": {"from": 0, "to": 2}, "y": {"from": 2, "to": 4}}', array([1., 2., 3., 4.]))
    """
    arrays: list[NDArray[np.float64]] = [np.empty(0)]
    end = 0

    def part(array: NDArray[np.float64]) -> dict[str, int]:
        nonlocal end
        arrays.append(array)
        begin, end = end, end + len(array)
        return {"from": begin, "to": end}

    text = json.dumps(message, default=part, allow_nan=False)
    return text, np.concatenate(arrays)
