"""Drawing and saving of the figures of zones: zones as bands, simulated holds as bars, the numbers as a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Oscillator
from ..base.files import write_bytes, write_text
from ..plot import style
from .paper import KINDS
from .scan import Strip
from .sweeps import Bar

LOAD, GAP = style.LOAD_LABEL, style.CLEARANCE_LABEL
#: Largest distance between a drawn outline and the computed one, as a share of the window: 0.04 printed points.
THINNED = 1e-4


def panels(columns: int = 1, height: float = 3.6, rows: int = 1, **options: Any) -> tuple[Any, Any]:
    """A figure with axes side by side."""
    plt = style.pyplot()
    width = 5.0 if columns == 1 else style.TWO_COLUMNS
    with plt.rc_context(style.SETTINGS):
        figure, axes = plt.subplots(
            rows, columns, figsize=(width, height), layout="constrained", **options
        )
    return figure, axes


def identify(ax: Any, osc: Oscillator, more: str = "") -> None:
    """The parameters of the system, as the title of the figure."""
    ax.figure.suptitle(style.given(style.system(osc)) + more, fontsize=8)


def thinned(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """A subset of the points (M, 2) of a line over r and clearance that draws the same line (Douglas–Peucker)."""
    scaled = np.stack([line[:, 0], np.log(line[:, 1])], axis=1)
    scaled /= np.maximum(np.ptp(scaled, axis=0), 1e-300)
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    parts = [(0, len(line) - 1)]
    while parts:
        first, last = parts.pop()
        if last - first < 2:
            continue
        start, step = scaled[first], scaled[last] - scaled[first]
        offset = scaled[first + 1 : last] - start
        along = np.clip(offset @ step / max(float(step @ step), 1e-300), 0, 1)
        distance = np.linalg.norm(offset - along[:, None] * step, axis=1)
        if distance.max() > THINNED:
            middle = first + 1 + int(distance.argmax())
            keep[middle] = True
            parts += [(first, middle), (middle, last)]
    return line[keep]


def legend(ax: Any, **options: Any) -> None:
    """Draw the legend."""
    ax.legend(**{"frameon": False, "fontsize": 6.5, "handlelength": 1.4, **options})


def zone(
    ax: Any, strips: Sequence[Strip], kind: str, label: str = "", *, inverse: bool = True,
    traced: Any = None, **options: Any,
) -> None:  # fmt: skip
    """Draw a zone as a band between its boundaries, over r; `inverse` draws F0/(dK).

    If its complete boundary was also `traced`, the traced boundary is drawn.
    """
    colour, style_ = options.pop("color", KINDS[kind][0]), options.get("ls", "-")
    alpha = options.get("alpha", 0.22)
    lines = [strip.ring for strip in strips]
    if traced and traced.closed:
        pieces = [piece for piece in traced.boundary if piece.type != "window"]
        lines = [np.stack([piece.r, piece.clearance], axis=1) for piece in pieces]
        for ring in map(thinned, traced.loops):
            ax.fill(
                ring[:, 0],
                1 / ring[:, 1] if inverse else ring[:, 1],
                color=colour,
                alpha=alpha,
                lw=0,
            )
    for strip in () if traced and traced.closed else strips:
        edges = (1 / strip.high, 1 / strip.low) if inverse else (strip.low, strip.high)
        ax.fill_between(strip.r, *edges, color=colour, alpha=alpha, lw=0)
    for line in map(thinned, lines):
        y = 1 / line[:, 1] if inverse else line[:, 1]
        ax.plot(line[:, 0], y, color=colour, lw=0.8, ls=style_)
    if len(strips):
        name = label or KINDS[kind][1]
        if alpha == 0:
            ax.plot([], [], color=colour, lw=0.8, ls=style_, label=name)
        else:
            ax.fill_between([], [], color=colour, alpha=0.5, lw=0, label=name)


def bars(ax: Any, found: Sequence[Bar], kind: str, label: str = "") -> None:
    """Loads at which the simulated holds ended on a kind, as vertical bars."""
    if not found:
        return
    r, low, high = np.array(found).T
    colour = KINDS[kind][0]
    ax.vlines(r, low, high, color=colour, lw=1.6)
    name = f"{label or KINDS[kind][1]}, simulation"
    ax.plot(
        np.tile(r, 2), np.concatenate([low, high]), "_", color=colour, ms=4, mew=1.0, label=name
    )


def letters(ax: Any, places: Mapping[str, tuple[float, float]]) -> None:
    """Mark points (r, d K/F0) that another figure shows, with their letters in that figure."""
    for name, (r, clearance) in places.items():
        ax.plot(r, 1 / clearance, "k.", ms=4)
        ax.annotate(name, (r, 1 / clearance), textcoords="offset points", xytext=(3, 2), fontsize=8)


def axes_of_zones(ax: Any, *, inverse: bool = True) -> None:
    """Labels and a logarithmic ordinate: the zones span two decades."""
    style.log_scale(ax, "y")
    ax.set_xlabel(style.R_LABEL)
    ax.set_ylabel(LOAD if inverse else GAP)


def save(figure: Any, folder: Path, name: str) -> None:
    """Write a figure as PNG, for print, and as SVG."""
    plt = style.pyplot()
    # the file must be identical from run to run
    with plt.rc_context({**style.SETTINGS, "svg.hashsalt": name}):
        for kind, date in (("png", {}), ("svg", {"metadata": {"Date": None}})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=200, **date)
            write_bytes(folder / f"{name}.{kind}", buffer.getvalue())
    plt.close(figure)


def inside(sweeps: list[dict[str, Any]], kind: str, strips: Sequence[Strip]) -> str:
    """A text on the number of simulated holds that ended on a kind and lie in its zone."""
    holds = [(s["r"], 1 / x["load"]) for s in sweeps for x in s["seen"] if x["kind"] == kind]
    good = sum(any(strip.contains(*hold) for strip in strips) for hold in holds)
    return f"{good} of {len(holds)} simulated holds on {KINDS[kind][1]} lie in the zone"


def table(folder: Path, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write the numbers of a figure as CSV, in full precision."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([float(x) if isinstance(x, np.floating) else x for x in row] for row in rows)
    write_text(folder / f"{name}.csv", text.getvalue())


def strip_rows(zones: Mapping[str, Sequence[Strip]]) -> list[tuple[Any, ...]]:
    """Rows for `table`: zone, piece, r, low and high clearance."""
    return [
        (name, piece, float(r), float(low), float(high))
        for name, strips in zones.items()
        for piece, strip in enumerate(strips)
        for r, low, high in zip(*strip, strict=True)
    ]


STRIP_HEADER = ("zone", "piece", "r", "clearance_low", "clearance_high")


#: Colour, line style and mark of the curves of one figure, in order: neighbours differ in all of them.
LOOKS = (
    ("#000000", "-", "o"), ("#56B4E9", (0, (5, 1.5)), "s"), ("#D55E00", "-", "^"),
    ("#009E73", (0, (5, 1.5, 1, 1.5)), "D"), ("#CC79A7", "-", "v"), ("#0072B2", (0, (2, 1)), "P"),
    ("#E69F00", "-", "X"),
)  # fmt: skip
