"""A sketch of the system: masses, spring, dashpot, load, walls, and the clearance."""

from __future__ import annotations

from typing import Any

import numpy as np

from .style import FREE, IMPACT, LOAD, PRIMARY, SETTINGS, pyplot

__all__ = ["draw_system"]

#: Left and right end of M, of its slot, and of m; bottom and top of the same (arbitrary unit).
BODY, SLOT, MASS = ((2.6, 8.2, 0.0, 3.0), (3.4, 7.4, 0.8, 2.2), (4.8, 6.0, 0.85, 1.75))


def draw_system(ax: Any = None) -> Any:
    """Draw the primary mass M on its spring K and dashpot C, the free mass m in the slot, and the clearance d.

    The clearance d is the whole travel of m between the walls, d/2 on each side of its middle position.

    Parameters
    ----------
    ax : matplotlib Axes, optional
        Without it a new figure is made.

    Returns
    -------
    Axes

    Examples
    --------
    >>> from vibroimpact.plot import draw_system
    >>> draw_system().figure.savefig("system.svg")  # doctest: +SKIP
    """
    plt = pyplot()
    with plt.rc_context(SETTINGS):
        if ax is None:
            _, ax = plt.subplots(figsize=(6.2, 2.5), layout="constrained")
        _draw_support(ax)
        _draw_masses(ax)
        _draw_dimensions(ax)
        ax.set(xlim=(-0.6, 11.2), ylim=(-0.65, 4.05), aspect="equal")
        ax.set_axis_off()
    return ax


def _box(ax: Any, edges: tuple[float, float, float, float], **options: Any) -> None:
    """A rectangle between two abscissas and two ordinates."""
    from matplotlib.patches import Rectangle

    left, right, bottom, top = edges
    ax.add_patch(Rectangle((left, bottom), right - left, top - bottom, lw=1.2, **options))


def _arrow(ax: Any, begin: tuple[float, float], end: tuple[float, float], **options: Any) -> None:
    look = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "lw": 0.9, "color": "k", **options}
    ax.annotate("", end, begin, arrowprops=look)


def _draw_support(ax: Any) -> None:
    """The fixed wall, the ground, the spring and the dashpot."""
    left = BODY[0]
    _box(ax, (-0.3, 0.0, -0.25, 3.2), facecolor="none", edgecolor="0.5", hatch="/////")
    _box(ax, (-0.3, 9.2, -0.55, -0.25), facecolor="none", edgecolor="0.5", hatch="/////")
    for x in (3.4, 7.4):
        ax.plot(x, -0.125, "o", ms=6, mfc="w", mec="0.3", mew=0.9)
    # spring: straight ends and a zigzag
    zigzag = np.linspace(0.5, left - 0.5, 12)
    height = np.r_[0, np.tile([0.22, -0.22], 5), 0]
    ax.plot([0, *zigzag, left], 2.3 + np.r_[0, height, 0], color="k", lw=1.1)
    ax.text(left / 2, 2.66, "$K$", ha="center", va="bottom", fontsize=10)
    # dashpot: a cylinder on the side of the wall, and a piston
    cup, piston = (0.9, 1.7), 1.35
    ax.plot([0, cup[0]], [0.8, 0.8], "k", lw=1.1)
    ax.plot([cup[1], cup[0], cup[0], cup[1]], [1.1, 1.1, 0.5, 0.5], "k", lw=1.1)
    ax.plot([piston, piston], [0.58, 1.02], "k", lw=2.2)
    ax.plot([piston, left], [0.8, 0.8], "k", lw=1.1)
    ax.text(left / 2, 1.22, "$C$", ha="center", va="bottom", fontsize=10)


def _draw_masses(ax: Any) -> None:
    """The primary mass with its slot and walls, the free mass, and the load."""
    _box(ax, BODY, facecolor=PRIMARY, edgecolor="k", alpha=0.3)
    _box(ax, BODY, facecolor="none", edgecolor="k")
    _box(ax, SLOT, facecolor="w", edgecolor="k")
    for x, name, side in ((SLOT[0], "L", "right"), (SLOT[1], "R", "left")):
        ax.plot([x, x], SLOT[2:], color=IMPACT, lw=3)
        number = "$R_2$" if name == "L" else "$R_1$"
        ax.text(
            x + (-0.12 if side == "right" else 0.12),
            1.5,
            f"{name}\n{number}",
            ha=side,
            va="center",
            fontsize=8,
        )
    _box(ax, MASS, facecolor=FREE, edgecolor="k")
    ax.text(5.4, 1.3, "$m$", ha="center", va="center", fontsize=10, color="w")
    ax.text(5.4, 0.38, "$M$", ha="center", va="center", fontsize=10)
    _arrow(ax, (8.2, 0.6), (9.4, 0.6), color=LOAD, lw=1.8)
    ax.text(9.5, 0.6, r"$F_0\,\sin\,\Omega t$", ha="left", va="center", fontsize=10)


def _draw_dimensions(ax: Any) -> None:
    """The clearance on both sides of the free mass, and the displacements X and Z."""
    for x in (SLOT[0], MASS[0], MASS[1], SLOT[1]):
        ax.plot([x, x], [1.75 if x in MASS else 2.0, 2.12], color="0.4", lw=0.6)
    for low, high in ((SLOT[0], MASS[0]), (MASS[1], SLOT[1])):
        _arrow(ax, (low, 1.95), (high, 1.95), arrowstyle="<|-|>", mutation_scale=7)
        ax.text((low + high) / 2, 1.86, "$d/2$", ha="center", va="top", fontsize=9)
    ax.text(
        5.4,
        2.62,
        "$d$: whole travel of $m$ from wall to wall",
        ha="center",
        va="center",
        fontsize=8,
    )
    for x, top, base, name, colour in (
        (8.2, 3.55, 3.0, "$X$", PRIMARY), (5.4, 3.55, 3.0, "$Z$", FREE)
    ):  # fmt: skip
        ax.plot([x, x], [base + 0.1, top + 0.15], color=colour, lw=0.9)
        _arrow(ax, (x, top), (x + 0.9, top), color=colour, lw=1.4)
        ax.text(x + 1.0, top, name, ha="left", va="center", fontsize=10)
