"""Results as Jupyter shows them: kind of result, some numbers, and a small picture if matplotlib is installed."""

from __future__ import annotations

import base64
import io
from html import escape
from typing import Any

LEFT = "style='text-align:left'"


def html(noun: Any) -> str:
    """A short piece of HTML."""
    rows = "".join(
        f"<tr><th {LEFT}>{escape(name)}</th><td {LEFT}>{escape(value)}</td></tr>"
        for name, value in noun._facts().items()
    )
    notes = "".join(f"<li>{escape(text)}</li>" for _, text in noun._result.notes)
    return (
        f"<div><code>{escape(repr(noun))}</code>{f'<table>{rows}</table>' if rows else ''}"
        f"{f'<ul>{notes}</ul>' if notes else ''}{picture(noun)}</div>"
    )


def picture(noun: Any) -> str:
    """An image; nothing if matplotlib is missing or there is nothing to draw."""
    if not noun.drawable:
        return ""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        from ..plot import style
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
    data = base64.b64encode(content.getvalue()).decode()
    return f"<img alt='{escape(repr(noun), quote=True)}' src='data:image/png;base64,{data}'/>"
