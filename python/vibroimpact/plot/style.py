"""One look for all pictures: colours that colour-blind readers tell apart, symbols and units on axes."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MissingExtraError
from ..files import write_bytes

#: Okabe and Ito's colours.
PRIMARY, FREE, LOAD, IMPACT, REST = "#0072B2", "#D55E00", "#000000", "#CC79A7", "#009E73"
#: Widths of one and two columns of print, in inches.
ONE_COLUMN, TWO_COLUMNS = 3.5, 7.2

SETTINGS = {
    "font.size": 8,
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": 7,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
#: A legend above the axes, where it covers nothing, in the size of SETTINGS.
ABOVE = {
    "loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3, "fontsize": 7, "frameon": False,
    "borderaxespad": 0.2, "columnspacing": 1.2, "handlelength": 2.6,
}  # fmt: skip


def pyplot() -> Any:
    """matplotlib's pyplot, or an error that says how to get it."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise MissingExtraError(
            "pictures need matplotlib: pip install 'vibroimpact[plot]'"
        ) from None
    return plt


def save(axes: Any, path: Path) -> Path:
    """Write the figure of some axes, in the format of the path's suffix, and close it."""
    figure = np.ravel(axes)[0].figure
    kind, content = path.suffix[1:], io.BytesIO()
    # without dates and random names: the same bytes every time
    dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with pyplot().rc_context({"svg.hashsalt": "vibroimpact"}):
        figure.savefig(content, format=kind, dpi=200, metadata=dates.get(kind))
    pyplot().close(figure)
    write_bytes(path, content.getvalue())
    return path


def condition_name(kind: str) -> str:
    """The name of a bifurcation as it is printed."""
    return kind.replace("neimark_sacker", "Neimark–Sacker").replace("_", " ")
