"""The proven regions of a certificate of a zone, in the plane of r and d K/F0."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import style

#: Colours of proven and undecided intervals; they also differ in lightness.
FILLS = {"proven inside": "#0072B2", "not decided": "#000000", "proven outside": "#F2E6C0"}
#: Number of lines of constant r that are drawn.
LINES = 600


def draw_certificate(certificate: Any, ax: Any = None) -> Any:
    """Draw the intervals of d K/F0 on lines of constant r, as narrow strips."""
    plt = style.pyplot()
    if ax is None:
        with plt.rc_context(style.SETTINGS):
            _, ax = plt.subplots(figsize=(style.ONE_COLUMN, 3.0), layout="constrained")
        style.log_scale(ax, "y")
    plane = certificate._plane
    low, high = (float(one) for one in certificate.system["r"])
    half = (high - low) / LINES / 2
    bars: dict[str, list[tuple[float, float, float]]] = {name: [] for name in FILLS}
    for r, inside, open_ in plane.lines(LINES):
        bars["proven outside"].append((r, *plane.window))
        bars["not decided"] += [(r, *ends) for ends in open_.tolist()]
        bars["proven inside"] += [(r, *ends) for ends in inside.tolist()]
    for name in ("proven outside", "not decided", "proven inside"):
        places, bottoms, tops = np.array(bars[name]).reshape(-1, 3).T
        ax.bar(places, tops - bottoms, 2.2 * half, bottoms, color=FILLS[name], linewidth=0)
    ax.set_xlim(low, high)
    ax.set_ylim(*plane.window)
    ax.set_xlabel(style.parameter_label("r"))
    ax.set_ylabel(style.parameter_label("clearance"))
    for name, color in FILLS.items():
        # in the legend a bar without area represents the strips, with an edge if its colour is that of the axes
        ax.bar(low, 0, 0, color=color, edgecolor="0.3", linewidth=0.5, label=name)
    # matplotlib's search for the best place takes long with so many strips
    style.add_legend(ax, loc="lower center")
    return ax
