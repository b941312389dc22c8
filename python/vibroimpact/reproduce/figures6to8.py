"""Figures 6 to 8 with bands: where the boundaries lie if the rig is known only as well as the paper states."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import BoundaryBand, Oscillator, Zone, boundary_bands, zone
from ..plot.uncertainty import draw_bands
from . import canvas
from .paper import EQUAL, KINDS, UNEQUAL

#: Half the range of the damping ratio and of the gap (in), the gaps, and the relative decrease of R.
XI, GAP, GAPS, FALL = 0.0005, 0.001, {EQUAL: 0.0105, UNEQUAL: 0.0081}, 0.09
#: Frequency ratios of the figures.
R = (0.55, 1.5)


class Panel(NamedTuple):
    """A figure of the paper: title, system, range of d K/F0, and patterns with colour and symmetry."""

    title: str
    osc: Oscillator
    clearance: tuple[float, float]
    patterns: tuple[tuple[str, str, bool | None], ...]


PANELS = {
    "6a": Panel("6a: two equispaced impacts", EQUAL, (1.0, 200.0), (("RL", "2e", True),)),
    "6b": Panel("6b: two unequispaced impacts", EQUAL, (1.0, 200.0), (("RL", "2u", False),)),
    "7": Panel(
        "7: three, four and five impacts",
        EQUAL,
        (0.2, 100.0),
        (("RRL", "3", None), ("RRLL", "4", None), ("RRRLL", "5", None)),
    ),
    "8a": Panel(
        "8a: two and three impacts", UNEQUAL, (0.7, 170.0), (("RL", "2", None), ("RLL", "3", None))
    ),
    "8b": Panel(
        "8b: accumulation and rest",
        UNEQUAL,
        (0.4, 50.0),
        (("RL*", "rest", None), ("RRL*", "3", None)),
    ),
}


def uncertain(osc: Oscillator) -> dict[str, tuple[float, float]]:
    """The ranges of the paper's rig, as factors of the nominal clearance and as values."""
    gap = GAPS[osc]
    right, left = osc.restitution
    ranges = {
        "xi": (osc.xi - XI, osc.xi + XI),
        "clearance": ((gap - GAP) / gap, (gap + GAP) / gap),
    }
    if right == left:
        return ranges | {"restitution": ((1 - FALL) * right, right)}
    return ranges | {"R1": ((1 - FALL) * right, right), "R2": ((1 - FALL) * left, left)}


def bands_of(
    panel: Panel, resolution: float = 1.0
) -> Iterator[tuple[str, str, Zone, list[BoundaryBand]]]:
    """Pattern, kind, nominal zone and bands of each zone of a panel."""
    samples, vertices = max(8, round(32 * resolution)), max(6, round(40 * resolution))
    for sides, kind, symmetric in panel.patterns:
        traced = zone(panel.osc, sides, R, panel.clearance, symmetric=symmetric)
        # a motion with rest takes about a hundred times as long as one without
        some = vertices // 3 if "*" in sides else vertices
        bands = boundary_bands(
            traced, uncertain(panel.osc), samples=samples, vertices=some, threads=1
        )
        yield sides, kind, traced, bands


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figures6to8.png and .svg, write figures6to8.csv; True if every zone has bands."""
    figure, axes = canvas.panels(2, 6.6, rows=3)
    rows, good = [], True
    for ax, (name, panel) in zip(axes.flat, PANELS.items(), strict=False):
        for sides, kind, traced, bands in bands_of(panel, resolution):
            colour = KINDS[kind][0]
            for piece in traced.boundary:
                if piece.type != "window":
                    ax.plot(piece.r, 1 / piece.clearance, color=colour, lw=0.8)
            draw_bands(bands, ax, inverse=True, color=colour, lines=False)
            ax.fill_between([], [], color=colour, alpha=0.5, lw=0, label=sides)
            holds = np.concatenate([band.holds for band in bands]) if bands else np.zeros(0, bool)
            good = good and bool(bands)
            print(
                f"Figure {name} with bands: {sides}: first order holds at {holds.sum()} of {holds.size} vertices"
            )
            rows += [
                (name, sides, i, band.type, *numbers)
                for i, band in enumerate(bands)
                for numbers in zip(
                    band.r, band.clearance, *band.normal, *band.sampled, *band.first_order, band.found,
                    band.holds.astype(int).tolist(), strict=True,
                )
            ]  # fmt: skip
        canvas.axes_of_zones(ax)
        ax.set(xlim=R, ylim=(1 / panel.clearance[1], 1 / panel.clearance[0]))
        ax.set_title(panel.title, fontsize=8)
        canvas.legend(ax, loc="lower right")
    key = axes.flat[-1]
    key.set_axis_off()
    key.plot([], [], color="0.3", lw=0.8, label="nominal boundary")
    key.fill_between([], [], color="0.3", alpha=0.3, lw=0, label="95 % of the displaced boundaries")
    key.plot([], [], "x", color="0.3", ms=2.5, mew=0.6, label="first order does not hold")
    key.legend(loc="center left", frameon=False, fontsize=7.5)
    lines = [
        r"$\xi = 0.0114 \pm 0.0005$",
        r"gap $0.0105 \pm 0.001$ in (Figure 8: $0.0081 \pm 0.001$ in)",
        "restitution up to 9 % below its nominal value",
        "all values in these ranges equally probable",
    ]
    key.text(0.02, 0.05, "\n".join(lines), fontsize=7, transform=key.transAxes)
    canvas.save(figure, folder, "figures6to8")
    header = [
        "figure", "sides", "piece", "type", "r", "clearance", "normal_r", "normal_log_clearance", "sampled_low",
        "sampled_high", "first_order_low", "first_order_high", "found", "holds",
    ]  # fmt: skip
    canvas.table(folder, "figures6to8", header, rows)
    return good
