"""The motions at a point side by side: histories, and the multipliers beside the unit circle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from . import history, style

if TYPE_CHECKING:
    from ..found import Findings
    from ..motion import Motion

#: Panels in a row; motions drawn at most.
COLUMNS, MOST = 3, 23


def draw_found(found: Findings, ax: Any = None) -> Any:
    """A panel for each motion over its period, and a last one with the multipliers of all.

    The motions are numbered as they are in a table; of very many the first ones are drawn. With `ax` the
    multipliers alone are drawn.
    """
    motions = found.motions[:MOST]
    if ax is not None:
        draw_multipliers(motions, ax)
        return ax
    rows = math.ceil((len(motions) + 1) / COLUMNS)
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        figure, axes = plt.subplots(
            rows, COLUMNS, squeeze=False, layout="constrained", figsize=(style.TWO_COLUMNS, 0.4 + 2.1 * rows),
        )  # fmt: skip
        panels = axes.ravel()
        for number, (motion, ax) in enumerate(zip(motions, panels, strict=False), start=1):
            history.draw(motion, ax, cycles=motion.pattern.cycles)
            ax.get_legend().remove()
            ax.set_title(f"{number}: {name(motion)}", fontsize=8)
        draw_multipliers(motions, panels[len(motions)])
        for ax in panels[len(motions) + 1 :]:
            ax.remove()
        walls = ", ".join(f"{value:g}" for value in found.osc.restitution)
        shown = f"; the first {MOST} of {len(found.motions)}" if len(found.motions) > MOST else ""
        figure.suptitle(
            rf"$\xi$ = {found.osc.xi:g}, $\mu$ = {found.osc.mu:g}, $R$ = {walls}, $r$ = {found.r:.6g}, "
            rf"$dK/F_0$ = {found.clearance:.6g}" + shown, fontsize=8,
        )  # fmt: skip
        return panels[: len(motions) + 1]


def name(motion: Motion) -> str:
    """Pattern and stability."""
    verdict = {True: "stable", False: "unstable", None: "stable?"}[motion.stable]
    return f"{motion.pattern.sides}/{motion.pattern.cycles} {verdict}"


def draw_multipliers(motions: list[Motion], ax: Any) -> None:
    """All multipliers in the complex plane, those outside of the unit circle on a scale that brings them near.

    The distance from the origin is |lambda| up to 1, and 1 + log10 |lambda| beyond.
    """
    turn = np.linspace(0, 2 * np.pi, 201)
    ax.plot(np.cos(turn), np.sin(turn), color=style.LOAD, lw=0.7)
    for number in range(len(motions), 0, -1):  # the stable ones, which are the first, on top
        motion = motions[number - 1]
        colour = style.REST if motion.stable else style.FREE
        values = motion.multipliers[np.isfinite(motion.multipliers)]
        modulus = np.abs(values)
        distance = np.where(modulus > 1, 1 + np.log10(np.maximum(modulus, 1)), modulus)
        points = distance * np.exp(1j * np.angle(values))
        ax.plot(points.real, points.imag, ".", color=colour, ms=4)
        for point in points[:1]:
            ax.annotate(str(number), (point.real, point.imag), xytext=(2, 2), textcoords="offset points",
                        fontsize=6, color=colour)  # fmt: skip
    ax.set_aspect("equal")
    ax.margins(0.12)
    ax.set_title(r"multipliers (beyond 1: $1 + \log_{10}|\lambda|$)", fontsize=8)
    ax.set_xlabel(r"Re $\lambda$")
    ax.set_ylabel(r"Im $\lambda$")
