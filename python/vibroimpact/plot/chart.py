"""Charts of zones in the plane of frequency ratio and clearance, in the manner of Figures 3 and 6 to 8."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..results.systems import system_of
from ..studies.chart import Chart
from ..systems.units import Units, checked_names
from .style import (
    ONE_COLUMN,
    PRIMARY,
    SETTINGS,
    Plane,
    add_legend,
    identify,
    is_geometric,
    log_scale,
    pyplot,
)

__all__ = ["draw_chart"]

#: Class of a point, colour, hatching and name. The colours also differ in lightness.
CLASSES = (
    (3, PRIMARY, None, "admissible and stable"),
    (2, "#E8A33D", "////", "admissible, none stable"),
    (1, "#E6E6E6", "....", "none admissible"),
    (0, "#FFFFFF", None, "no motion found"),
)
COLORS = {
    "multiplier": ("multiplier_modulus", r"$|\lambda|_{max}$"),
    "attenuation": ("attenuation", r"$\max|X|/A$"),
}


def draw_chart(
    data: Any,
    ax: Any = None,
    color: str | None = None,
    inverse: bool = False,
    units: Units | str | None = None,
) -> Any:
    """Draw where the motions of a chart are stable, unstable, inadmissible, or absent.

    Parameters
    ----------
    data : xarray.Dataset
        From `vibroimpact.chart`.
    ax : matplotlib Axes, optional
    color : {"multiplier", "attenuation"}, optional
        Colour the stable zone by the modulus of the leading multiplier, or by max|x|/A, of the most stable motion.
    inverse : bool
        Whether the axis is F0/(d K), as in Figures 6 to 8, instead of d K/F0.
    units : Units or str, optional
        Physical units of the axes. By default those of the oscillator, if its M, K and F0 are known;
        "dimensionless" for none.

    Returns
    -------
    Axes

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> from vibroimpact.plot import draw_chart
    >>> osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    >>> data = vi.chart(osc, vi.Pattern("RL"), np.linspace(0.9, 1.1, 40), np.geomspace(2, 100, 40))
    >>> ax = draw_chart(data, inverse=True)
    >>> ax.get_ylabel()
    '$F_0/(dK)$'
    """
    if not {"admissible", "stable"} <= set(getattr(data, "variables", ())):
        raise ParameterTypeError(
            f"data = {type(data).__name__}: must be a dataset from vibroimpact.chart"
        )
    of_structure = "x" in data.variables
    if not of_structure and "r" not in data.variables:
        raise ParameterError(
            "data in physical units: must be the dataset from vibroimpact.chart, which is drawn in the units of "
            "its oscillator; for others give the units as `units`"
        )
    if of_structure and inverse:
        raise ParameterError("inverse = True: must be False for a chart of a structure")
    if of_structure and color == "attenuation":
        raise ParameterError(
            "color = 'attenuation': must be 'multiplier' or None for a chart of a structure"
        )
    if color is not None:
        checks.choice(color, "color", tuple(COLORS))
    plt = pyplot()
    plane = Plane(_units_of_chart(data, units), inverse)
    if of_structure:
        (x, x_label), (y, y_label) = (
            plane.parameter(data[name].attrs["long_name"], data[name].values) for name in "xy"
        )
    else:
        x, y = plane.r(data["r"].values), plane.gap(data["clearance"].values)
    kind = classes(data)
    with plt.rc_context({**SETTINGS, "hatch.linewidth": 0.4}):
        if ax is None:
            _, ax = plt.subplots(figsize=(ONE_COLUMN, 3.4), layout="constrained")
            if not of_structure:
                names = ("xi", "mu", "R1", "R2")
                head = f"{data.attrs['sides']}/{data.attrs['cycles']}"
                identify(ax, plane.given({name: data.attrs[name] for name in names}), head)
        mesh = _edges(x), _edges(y)
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch

        shades = ListedColormap([item[1] for item in reversed(CLASSES)])
        ax.pcolormesh(*mesh, kind, cmap=shades, vmin=-0.5, vmax=3.5, rasterized=True)
        for number, _, hatch, _ in CLASSES:
            if hatch and (kind == number).any():
                # both sides of each edge, so that the hatching ends where the coloured cells end
                sides = (np.repeat(edges, 2)[1:-1] for edges in mesh)
                there = (kind == number).repeat(2, axis=0).repeat(2, axis=1)
                ax.contourf(*sides, there, levels=[0.5, 1.5], colors="none", hatches=[hatch])
        if color is not None:
            shown = np.where(kind == 3, _best(data, COLORS[color][0]), np.nan)
            if np.isnan(shown[kind == 3]).any():
                raise ParameterError(
                    f"color = {color!r}: must be a quantity that the chart contains; it was computed without "
                    "them (multipliers=False)"
                )
            image = ax.pcolormesh(*mesh, shown, cmap="cividis", rasterized=True)
            ax.figure.colorbar(image, ax=ax, label=COLORS[color][1])
        if is_geometric(y):
            log_scale(ax, "y")
        if of_structure:
            ax.set_xlabel(x_label)
            ax.set_ylabel(y_label)
        else:
            plane.label_axes(ax)
        none = CLASSES[-1][3] if data.attrs.get("complete", 1) else "not reached, or no motion"
        patches = [
            Patch(
                facecolor=shade,
                hatch=hatch,
                edgecolor="black",
                lw=0.4,
                label=name if number else none,
            )
            for number, shade, hatch, name in CLASSES
            if (kind == number).any() and not (color and number == 3)
        ]
        add_legend(
            ax,
            handles=patches,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
            ncols=2,
            handlelength=1.6,
        )
        return ax


def _units_of_chart(data: Any, units: Units | str | None) -> Units | None:
    """The units of the axes; for a dataset by default those of its oscillator."""
    if isinstance(units, Units):
        return units
    if isinstance(data, Chart):
        return None  # `Chart.plot` has chosen
    names = ("M", "K", "F0", "unit_names")
    known = all(name in data.attrs for name in names)
    own = Units(*(data.attrs[name] for name in names)) if known else None
    if "x" in data.variables and "case" in data.attrs:
        own = system_of(data.attrs["case"])[0]._units
    if units is None:
        return own and own.of_pictures
    if units == "dimensionless":
        return None
    if own is None:
        raise ParameterError(
            f"units = {units!r}: must be a vibroimpact.Units or left out; the oscillator of the chart has no M, K "
            "and F0"
        )
    return own.to(checked_names(units))


def classes(data: Any) -> NDArray[np.int64]:
    """3, 2, 1 or 0 for each point (clearance, r), as in `CLASSES`."""
    exists = data["status"].values == 0
    admissible = exists & (data["admissible"].values == 1)
    stable = admissible & (data["stable"].values == 1)
    counted = np.stack([part.any(axis=0) for part in (exists, admissible, stable)])
    return np.asarray(counted.sum(axis=0))


def _best(data: Any, name: str) -> NDArray[np.float64]:
    """A variable of the admissible and stable motion with the smallest leading multiplier."""
    leading = data["multiplier_modulus"].values[0]
    values = data[name].values
    values = values[0] if name == "multiplier_modulus" else values
    good = (data["admissible"].values == 1) & (data["stable"].values == 1)
    good &= data["status"].values == 0
    best = np.argmin(np.where(good & ~np.isnan(leading), leading, np.inf), axis=0)
    chosen = np.take_along_axis(values, best[np.newaxis], axis=0)
    return np.asarray(chosen[0], dtype=np.float64)


def _edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Borders of the cells about the points of an axis."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * float(centres[0])
    geometric = is_geometric(centres)
    items = np.log(centres) if geometric else centres
    middle = 0.5 * (items[1:] + items[:-1])
    edges = np.concatenate([[2 * items[0] - middle[0]], middle, [2 * items[-1] - middle[-1]]])
    return np.exp(edges) if geometric else edges
