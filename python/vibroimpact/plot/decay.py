"""Free vibration: the peaks against time, and the damping of each cycle against its amplitude."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import checks
from . import style

if TYPE_CHECKING:
    from ..studies.decay import Decay
    from ..systems.units import Units

#: Colours and marks of a few runs. If there are more runs, their colour depends on the clearance.
COLORS = (style.PRIMARY, style.FREE, style.REST, style.IMPACT, style.LOAD, style.AREAS[4])
MARKS = "osD^vP"
#: Damping ratios up to this are on a linear scale.
SMALL = 0.01


def draw_decay(
    decay: Decay, ax: Any = None, kind: str | None = None, units: Units | None = None
) -> Any:
    """Draw one panel into `ax` (the peaks unless `kind` is "damping"), or both panels, or one, into a new
    figure."""
    if kind is not None:
        checks.choice(kind, "kind", tuple(PANELS))
    scales = style.Scales(units)
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        if ax is not None:
            PANELS[kind or "peaks"](ax, decay, scales)
            _name_runs(ax, decay, scales)
            return ax
        n = 1 if kind else 2
        width = style.ONE_COLUMN if kind else style.TWO_COLUMNS
        _, panels = plt.subplots(1, n, figsize=(width, 2.8), layout="constrained", squeeze=False)
        for name, panel in zip([kind] if kind else PANELS, panels[0], strict=True):
            PANELS[name](panel, decay, scales)
            if decay.status.size <= len(COLORS) or panel is panels[0, -1]:
                _name_runs(panel, decay, scales)
        values = {} if decay.of_structure else style.system(decay.osc)
        if not decay.of_structure and decay.clearance.size == 1:
            values["clearance"] = float(decay.clearance[0])
        style.identify(panels[0, 0], scales.given(values), "free vibration")
        return panels[0, 0] if kind else panels[0]


def _runs(decay: Decay, scales: style.Scales) -> Iterator[tuple[float, Any, dict[str, Any]]]:
    """Clearance (0 of a structure), position of the peaks and style of each run."""
    given = np.zeros(1) if decay.of_structure else decay.clearance
    few, clearances = given.size <= len(COLORS), scales.of("clearance", given)
    for i, clearance in enumerate(clearances.tolist()):
        color = COLORS[i] if few else colors_of(clearances).to_rgba(clearance)
        yield clearance, decay.run == i, {
            "color": color, "marker": MARKS[i] if few else ".", "ms": 2.8, "mew": 0.6,
            "mfc": "none" if few and i % 2 else color,
        }  # fmt: skip


def _name_runs(ax: Any, decay: Decay, scales: style.Scales) -> None:
    """A legend of the clearances, or the scale of their colours."""
    if decay.of_structure:
        return
    if decay.clearance.size > len(COLORS):
        clearances = scales.of("clearance", decay.clearance)
        ax.figure.colorbar(colors_of(clearances), ax=ax, label=scales.name("clearance"))
    elif decay.clearance.size > 1:
        legend = {
            "title": scales.name("clearance"),
            "ncols": 6,
            "title_fontsize": 7,
            "alignment": "left",
        }
        style.add_legend(ax, **style.ABOVE | legend | {"handlelength": 1.6})


def _draw_peaks(ax: Any, decay: Decay, scales: style.Scales) -> None:
    """The peaks of each run against time on a logarithmic axis."""
    for clearance, own, look in _runs(decay, scales):
        t, x = scales.of("t", decay.time[own]), scales.of("x", np.abs(decay.x[own]))
        ax.plot(t, x, lw=0.6, label=f"{clearance:.6g}", **look)
    style.log_scale(ax, "y")
    ax.set_xlabel("$t$" if decay.of_structure else scales.name("t"))
    ax.set_ylabel(of_peaks("peaks $|X|$", decay, scales))


def _draw_damping(ax: Any, decay: Decay, scales: style.Scales) -> None:
    """The damping of each cycle against the peak at which it begins."""
    for clearance, own, look in _runs(decay, scales):
        x = scales.of("x", np.abs(decay.x[own]))
        ax.plot(x, decay.damping[own], ls="", label=f"{clearance:.6g}", **look)
    style.log_scale(ax, "x")
    # logarithmic for losses and for gains, and linear for small values between them
    ax.set_yscale("symlog", linthresh=SMALL, linscale=0.5)
    ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}".replace("-", "\N{MINUS SIGN}"))
    ax.margins(y=0.08)
    ax.axhline(0, color="0.8", lw=0.6, zorder=0)
    if not decay.of_structure:
        ax.axhline(decay.osc.xi, color="0.4", lw=0.8, ls="--", zorder=0)
        ax.annotate(
            r"$\xi$", (1, decay.osc.xi), xycoords=ax.get_yaxis_transform(), xytext=(3, 0),
            textcoords="offset points", va="center", color="0.4", fontsize=8, annotation_clip=False,
        )  # fmt: skip
    ax.set_xlabel(of_peaks("$|X|$ at the start of the cycle", decay, scales))
    ax.set_ylabel(r"damping ratio $\zeta$ of the cycle")


def of_peaks(label: str, decay: Decay, scales: style.Scales) -> str:
    """The label of an axis of displacements."""
    return label if decay.of_structure else scales.label(label, "F0/K")


def colors_of(clearances: Any) -> Any:
    """From a clearance to its colour."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    norm = LogNorm if style.is_geometric(clearances) else Normalize
    return ScalarMappable(norm(clearances.min(), clearances.max()), "cividis")


#: The panels by name.
PANELS = {"peaks": _draw_peaks, "damping": _draw_damping}
