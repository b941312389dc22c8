"""Results as Jupyter shows them: what it is, a few numbers, and a small picture if matplotlib is there."""

from __future__ import annotations

import base64
import io
from html import escape
from typing import Any

import numpy as np


def html(result: Any) -> str:
    """A short piece of HTML."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th><td style='text-align:left'>{escape(value)}</td></tr>"
        for name, value in facts(result).items()
    )
    title = f"<code>{escape(repr(result))}</code>"
    table = f"<table>{rows}</table>" if rows else ""
    return f"<div>{title}{table}{picture(result)}</div>"


def facts(result: Any) -> dict[str, str]:
    """Names and values for the table."""
    name = type(result).__name__
    if name == "Motion":
        sizes = ", ".join(f"{size:.4g}" for size in np.abs(result.multipliers))
        return {
            "x": f"{result.x_min:.6g} to {result.x_max:.6g}",
            "max|x|/A": f"{result.attenuation:.4g}" if result.A > 0 else "-",
            "phases/π": ", ".join(f"{phase:.4g}" for phase in result.phases[:12] / np.pi)
            + (", …" if len(result.phases) > 12 else ""),
            "|λ|": sizes, "residual": f"{result.residual:.1e}",
        }  # fmt: skip
    return {}


def picture(result: Any) -> str:
    """An image, or nothing where matplotlib is missing or there is nothing to see."""
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        from ..plot import style
    except ImportError:
        return ""
    if getattr(result, "axes", "some") is None:  # basins of states that lie in no plane
        return ""
    if type(result).__name__ in ("Zone", "Atlas") and not (
        getattr(result, "zones", None) or result
    ):
        return ""
    with style.pyplot().rc_context(style.SETTINGS):
        figure = Figure(figsize=(3.4, 2.1), layout="constrained")
        FigureCanvasAgg(figure)
        ax = figure.add_subplot()
        if type(result).__name__ in ("Zone", "Atlas"):
            style.log_scale(ax, "y")
        kind = {"kind": "history"} if type(result).__name__ in ("Motion", "Trajectory") else {}
        result.plot(ax=ax, **kind)
        legend = ax.get_legend()
        if type(result).__name__ == "Atlas" and legend:
            legend.remove()  # it would be larger than so small a picture
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=110)
    data = base64.b64encode(content.getvalue()).decode()
    return f"<img alt='{escape(repr(result), quote=True)}' src='data:image/png;base64,{data}'/>"
