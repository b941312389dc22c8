"""The motions at a point side by side: their histories, and their multipliers with the unit circle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import history, style
from .attractor import axes

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..studies.find import FoundMotions
    from ..systems.units import Units

#: Number of panels in a row; largest number of motions drawn.
COLUMNS, MOST = 3, 8
#: Distance below which the labels of two multipliers are placed together.
NEAR = 0.1
#: Name, colour and mark of the multipliers of a motion that is not stable, and of one that is.
STABILITY = (
    ("multipliers, not stable", style.FREE, "s"), ("multipliers, stable", style.REST, "o"),
)  # fmt: skip


def draw_found(found: FoundMotions, ax: Any = None, units: Units | None = None) -> Any:
    """A panel for each motion over its period, and a final panel with the multipliers of all motions.

    The motions are numbered as in the table; only the first eight are drawn. With `ax`, and for a structure, only
    the multipliers are drawn.
    """
    motions = found[:MOST]
    if found.of_structure:
        ax = axes(ax, found, style.Scales(units), pad=16.0)
    if ax is not None:
        draw_multipliers(motions, ax)
        if found.of_structure:
            style.add_legend(ax, **style.ABOVE)
        return ax
    # the multipliers take the rest of the last row if that is wide enough for a circle
    last, column = divmod(len(motions), COLUMNS)
    if COLUMNS - column < 2:
        last, column = last + 1, 0
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        figure = plt.figure(layout="constrained", figsize=(style.TWO_COLUMNS, 2.7 + 2.1 * last))
        grid = figure.add_gridspec(last + 1, COLUMNS)
        places = [*(divmod(i, COLUMNS) for i in range(len(motions))), (last, slice(column, None))]
        panels = np.array([figure.add_subplot(grid[place]) for place in places])
        for number, (motion, ax) in enumerate(zip(motions, panels, strict=False), start=1):
            history.draw(motion, ax, cycles=motion.pattern.cycles, units=units)
            ax.get_legend().remove()
            ax.set_title(f"{number}: {name(motion)}", fontsize=8)
        draw_multipliers(motions, panels[-1])
        add_legend(figure, panels)
        shown = f"; the first {MOST} of {len(found)}" if len(found) > MOST else ""
        values = style.system(found.osc) | {
            name: getattr(found, name) for name in ("r", "clearance", "load")
        }
        figure.suptitle(style.given(style.Scales(units).given(values)) + shown, fontsize=8)
        return panels


def name(motion: Motion) -> str:
    """Pattern and stability."""
    verdict = {True: "stable", False: "unstable", None: "stable?"}[motion.stable]
    return f"{motion.pattern.sides}/{motion.pattern.cycles} {verdict}"


def add_legend(figure: Any, panels: Any) -> None:
    """One legend for all panels, below them."""
    entries: dict[str, Any] = {}
    for ax in panels:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(
        entries.values(), entries.keys(), loc="outside lower center", ncols=6, fontsize=7, frameon=False,
    )  # fmt: skip


def draw_multipliers(motions: Sequence[Any], ax: Any) -> None:
    """All multipliers with the unit circle; the leading one of each motion has the number of the motion.

    The distance from the origin is |lambda| up to 1, and 1 + log10 |lambda| beyond. The numbers of motions whose
    leading multipliers coincide are written together; of a complex pair, the multiplier in the upper half-plane is
    numbered.
    """
    turn = np.linspace(0, 2 * np.pi, 201)
    ax.plot(np.cos(turn), np.sin(turn), color=style.LOAD, lw=0.7)
    leading: list[tuple[complex, list[int]]] = []
    for number in range(
        len(motions), 0, -1
    ):  # the stable motions, which come first in the list, on top
        motion = motions[number - 1]
        points = drawn_at(motion.multipliers[np.isfinite(motion.multipliers)])
        label, colour, marker = STABILITY[motion.stable is True]
        shown = ax.get_legend_handles_labels()[1]
        ax.plot(
            points.real, points.imag, marker, color=colour, ms=3.5, mew=0.8, mfc="none",
            label="" if label in shown else label,
        )  # fmt: skip
        if points.size:
            first = complex(points[0].real, abs(points[0].imag))
            near = [numbers for other, numbers in leading if abs(other - first) < NEAR]
            if near:
                near[0].append(number)
            else:
                leading.append((first, [number]))
    # above the circle, each label in the lowest row with enough room, with a line to its point
    ends: list[float] = []
    for point, numbers in sorted(leading, key=lambda item: item[0].real):
        text = ", ".join(map(str, sorted(numbers)))
        half = 0.08 * (len(text) + 1)
        row = next((i for i, end in enumerate(ends) if end < point.real - half), len(ends))
        ends[row : row + 1] = [point.real + half]
        ax.annotate(
            text, (point.real, point.imag), xytext=(point.real, 1.2 + 0.4 * row), fontsize=6, ha="center",
            va="bottom", arrowprops={"arrowstyle": "-", "lw": 0.3, "color": "0.5", "shrinkB": 1.5},
        )  # fmt: skip
        ax.update_datalim([(point.real - half, 0), (point.real + half, 0)])
    ax.update_datalim([(-1.1, -1.1), (1.1, 1.1 + 0.4 * len(ends))])
    ax.margins(0.02)
    ax.autoscale_view()
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title(r"multipliers (beyond 1: $1 + \log_{10}|\lambda|$)", fontsize=8)
    ax.set_xlabel(r"Re $\lambda$")
    ax.set_ylabel(r"Im $\lambda$")


def drawn_at(values: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """The positions at which multipliers are drawn: those outside the unit circle are moved closer to it."""
    modulus = np.abs(values)
    distance = np.where(modulus > 1, 1 + np.log10(np.maximum(modulus, 1)), modulus)
    return np.asarray(distance * np.exp(1j * np.angle(values)))
