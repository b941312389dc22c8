"""One look for all pictures: colours that colour-blind readers tell apart, symbols and units on axes."""

from __future__ import annotations

from typing import Any

from ..errors import VibroimpactError

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


class MissingExtraError(VibroimpactError, ImportError):
    """A library that is not required to compute is needed here."""


def pyplot() -> Any:
    """matplotlib's pyplot, or an error that says how to get it."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise MissingExtraError(
            "pictures need matplotlib: pip install 'vibroimpact[plot]'"
        ) from None
    return plt


def condition_name(kind: str) -> str:
    """The name of a bifurcation as it is printed."""
    return kind.replace("neimark_sacker", "Neimark-Sacker").replace("_", " ")
