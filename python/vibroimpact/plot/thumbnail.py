"""The small picture of a result that Jupyter shows."""

from __future__ import annotations

import base64
import io
from typing import Any

from . import style


def thumbnail(noun: Any) -> str:
    """The image as a data URL; empty if matplotlib is missing or the result cannot be drawn."""
    if not noun.drawable:
        return ""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        return ""
    with style.pyplot().rc_context(style.SETTINGS):
        figure = Figure(figsize=(3.4, 2.1), layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.add_subplot()
        if noun._log_clearance:
            style.log_scale(ax, "y")
        noun._draw_small(ax)
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=110)
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode()}"
