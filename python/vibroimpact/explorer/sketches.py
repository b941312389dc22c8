"""The small figures, complete: axes and parts with their colours, in the form that the page's script
(sketch.js) draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import Motion, Trajectory, Units
from ..plot import style
from ..plot.history import history as history_of
from .pictures import Changes, fit

__all__ = ["circle", "history"]

LABELS = {
    "history": ("time  (load cycles)", "X, Z  (F₀/K)"),
    "portrait": ("Y = Z − X  (F₀/K)", "dY/dt  (ωF₀/K)"),
    "circle": ("Re λ", "Im λ"),
}
#: Radius of a mark, in pixels.
SIZE = 3.5


def history(
    thing: Motion | Trajectory | None, cycles: float, units: Units | None = None
) -> Changes:
    """Time history with walls and events, and the phase portrait of the relative motion; empty for None.

    With units, both figures have secondary axes in physical units.
    """
    if thing is None:
        blank: dict[str, Any] = {"x": [0, 1], "y": [0, 1], "parts": []}
        return {name: blank | {"labels": LABELS[name]} for name in ("history", "portrait")}
    h = history_of(thing, cycles)
    t, x, half = h.cycles, h.sample.X, h.half
    y_dot = h.sample.Z_dot - h.sample.X_dot
    side = np.where(h.events["side"] == "R", 1.0, -1.0)
    kind = h.events["kind"]
    marker = np.select(
        [kind == "stick", kind == "release"], ["inverted_triangle", "triangle"], "circle"
    )
    marks = {"color": style.IMPACT, "border": "#FFFFFF", "size": SIZE}
    wall = {"color": style.PRIMARY, "dash": [5, 3]}
    free = {"color": style.FREE, "width": 1.25}
    return {
        "history": {
            "labels": LABELS["history"], "x": fit(t, 0), "y": fit((x.min() - half, x.max() + half)),
            **second(units, ("time", 2 * np.pi / thing.r, "1/omega"), ("X, Z", 1, "F0/K")),
            "parts": [
                {"band": [t, x - half, x + half], "color": style.PRIMARY, "alpha": 0.07},
                *({"line": [t, x + offset], **wall} for offset in (half, -half)),
                # thick and thin: distinguishable without colour
                {"name": "x", "line": [t, x], "color": style.PRIMARY, "width": 3},
                {"name": "z", "line": [t, h.sample.Z], **free},
                {"marks": [h.event_cycles, h.events["x"] + side * half, marker.tolist()], **marks},
            ],
        },
        "portrait": {
            "labels": LABELS["portrait"], "x": fit((-half, half)), "y": fit(y_dot),
            **second(units, ("Y", 1, "F0/K"), ("dY/dt", 1, "omega F0/K")),
            "parts": [
                *({"upright": place, **wall} for place in (half, -half)),
                {"name": "y", "line": [h.sample.Y, y_dot], **free},
                {"marks": [side * half, h.events["z_dot_after"] - h.events["x_dot_after"], marker.tolist()],
                 **marks},
            ],
        },
    }  # fmt: skip


def second(units: Units | None, *axes: tuple[str, float, str]) -> dict[str, Any]:
    """The second axes x and y: for each its label, and the length on it of one unit of the first axis."""
    if units is None:
        return {}
    units = units.of_pictures
    return {
        "second": [
            [f"{name}  ({units.name(unit)})", scale * units.scale(unit)]
            for name, scale, unit in axes
        ]
    }  # fmt: skip


def circle(motion: Motion | None) -> Changes:
    """The multipliers and the unit circle; multipliers far outside are drawn at the edge with their modulus."""
    x, y, marker, text = [], [], [], []
    for value in [] if motion is None else motion.multipliers.tolist():
        if value != value:
            continue
        outside, far = abs(value) >= 1, abs(value) > 1.9
        place = value / abs(value) * 1.75 if far else value
        x.append(place.real)
        y.append(place.imag)
        marker.append("triangle" if far else "x" if outside else "circle")
        text.append(f"{abs(value):.4g}" if far else "")
    return {
        "circle": {
            "labels": LABELS["circle"], "x": [-2, 2], "y": [-2, 2], "square": True,
            "parts": [
                {"disc": 1, "color": style.PRIMARY, "alpha": 0.06},
                {"name": "multipliers", "marks": [x, y, marker], "color": style.FREE, "width": 2, "size": 4.5},
                {"texts": [x, y, text], "color": "#222222"},
            ],
        }
    }  # fmt: skip
