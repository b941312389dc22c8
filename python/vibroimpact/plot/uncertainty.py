"""Maps of probabilities, and bands on the boundaries of zones."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import checks
from ..base.errors import ParameterError
from .chart import _edges
from .style import (
    ABOVE,
    FREE,
    ONE_COLUMN,
    SETTINGS,
    Plane,
    add_legend,
    identify,
    is_geometric,
    log_scale,
    pyplot,
    system,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..studies.boundary_band import BoundaryBand
    from ..systems.units import Units

__all__ = ["draw_bands", "draw_uncertainty"]

LABELS = {
    "probability": "probability of a stable motion",
    "within": "probability within the limits",
}


def draw_uncertainty(
    found: Any,
    ax: Any = None,
    inverse: bool = False,
    what: str = "probability",
    units: Units | None = None,
) -> Any:
    """Draw a map of an Uncertainty with the nominal boundary and the bands; see `Uncertainty.plot`."""
    checks.choice(what, "what", tuple(LABELS))
    values = getattr(found, what)
    if values is None:
        raise ParameterError(f"what = {what!r}: must be 'probability', since no limits were given")
    plt = pyplot()
    plane = Plane(units, inverse)
    r, y = plane.r(found.r), plane.gap(found.clearance)
    with plt.rc_context(SETTINGS):
        if ax is None:
            _, ax = plt.subplots(figsize=(ONE_COLUMN + 1.5, 3.4), layout="constrained")
            identify(
                ax, plane.given(system(found.osc)), f"{found.pattern.sides}/{found.pattern.cycles}"
            )
        image = ax.pcolormesh(
            _edges(r), _edges(y), values, cmap="cividis", vmin=0, vmax=1, rasterized=True
        )
        ax.figure.colorbar(image, ax=ax, label=LABELS[what])
        if is_geometric(y):
            log_scale(ax, "y")
        limits = ax.get_xlim(), ax.get_ylim()
        if found.zone is not None:
            first = True
            for piece in found.zone.boundary:
                if piece.type == "window":
                    continue
                line = plane.r(piece.r), plane.gap(piece.clearance)
                ax.plot(*line, color="white", lw=1.6)
                ax.plot(*line, color="black", lw=0.8, label="nominal boundary" if first else "")
                first = False
            draw_bands(
                found.bands,
                ax,
                inverse,
                color=FREE,
                label=band_label(found.quantiles),
                fill=False,
                units=units,
            )
        ax.set(xlim=limits[0], ylim=limits[1])
        plane.label_axes(ax)
        if found.zone is not None:
            add_legend(ax, **ABOVE | {"ncols": 2})
    return ax


def band_label(quantiles: tuple[float, float]) -> str:
    """The name of a band between two quantiles in a legend."""
    return f"band of {100 * (quantiles[1] - quantiles[0]):g} %"


def draw_bands(
    bands: Sequence[BoundaryBand], ax: Any, inverse: bool = False, *, color: str = FREE, label: str = "",
    fill: bool = True, lines: bool = True, units: Units | None = None,
) -> None:  # fmt: skip
    """Draw bands: sampled bands filled or solid, first-order bands dashed, with crosses where first order does
    not hold."""
    plane = Plane(units, inverse)
    names = {"sampled": label, "first": "to first order", "off": "first order does not hold"}
    if not label:
        names = dict.fromkeys(names, "")
    for band in bands:
        for kind, line in (("sampled", "-"), ("first_order", (0, (3, 2)))):
            r, clearance = band.edges(kind)
            r, y = plane.r(r), plane.gap(clearance)
            if fill and kind == "sampled":
                good = np.isfinite(r).all(axis=0).reshape(-1)
                for part in np.split(np.arange(len(band)), np.flatnonzero(np.diff(good)) + 1):
                    if good[part].all() and len(part) > 1:
                        around = np.r_[part, part[::-1]], np.repeat([0, 1], len(part))
                        ax.fill(r[around[::-1]], y[around[::-1]], color=color, alpha=0.3, lw=0)
            if not lines:
                continue
            name = names.pop("sampled" if kind == "sampled" else "first", "")
            for i in (0, 1):
                ax.plot(
                    r[i], y[i], color=color, lw=0.8, ls=line, label=name if i == 0 else "",
                    alpha=1.0 if kind == "sampled" else 0.7,
                )  # fmt: skip
        off = ~band.holds
        if off.any():
            r, y = plane.r(band.r), plane.gap(band.clearance)
            # crosses at every point would cover the boundary: one per 4 % of the diagonal of the axes
            ax.plot(
                r[off], y[off], "x", color=color, ms=3.5, mew=0.8, markevery=0.04, label=names.pop("off", "")
            )  # fmt: skip
