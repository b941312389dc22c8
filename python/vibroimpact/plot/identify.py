"""The steps of an identification: record, load, impacts, fitted motion, residuals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import checks
from . import style

if TYPE_CHECKING:
    from ..identification.identify import Identification

#: Axis labels of the recorded quantities.
LABELS = {
    "acceleration": r"$\ddot{x}$ (m/s$^2$)", "velocity": r"$\dot{x}$ (m/s)", "displacement": "$x$ (m)",
    "impact times": "",
}  # fmt: skip
#: Colours of impacts on the right and on the left wall.
WALLS = {"R": style.FREE, "L": style.REST}


def draw_identification(
    found: Identification, ax: Any = None, kind: str | None = None, record: int = 0
) -> Any:
    """Draw one panel into `ax` (the motion unless `kind` names another one), or all panels into a new figure."""
    if kind is not None:
        checks.choice(kind, "kind", tuple(PANELS))
    record = checks.integer(record, "record", 0, found.records - 1)
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        if ax is not None or kind is not None:
            if ax is None:
                _, ax = plt.subplots(figsize=(style.TWO_COLUMNS, 2.4), layout="constrained")
            PANELS[kind or "motion"](ax, found, record)
            return ax
        figure, axes = plt.subplots(
            len(PANELS), 1, figsize=(style.TWO_COLUMNS, 8.8), layout="constrained",
            height_ratios=(0.8, 1.2, 1.0, 1.2, 0.8),
        )  # fmt: skip
        for panel, one in zip(PANELS.values(), axes, strict=True):
            panel(one, found, record)
        for one in (axes[0], axes[1], axes[3], axes[4]):
            one.sharex(axes[1])
        figure.suptitle(title(found, record), fontsize=7)
        return axes


def title(found: Identification, record: int) -> str:
    """Pattern and parameters, several in a line."""
    from ..identification.tables import said

    pattern = found.pattern_of(record)
    head = f"{pattern.sides}/{pattern.cycles}" if pattern else found._one("status", record)
    errors = found.errors
    items = [
        said(name, value, errors.get(name))
        for name, value in found.values.items()
        if math.isfinite(value)
    ]
    lines = [", ".join(items[i : i + 4]) for i in range(0, len(items), 4)]
    return "\n".join([f"{head}, in SI units", *lines]).replace("+-", "\N{PLUS-MINUS SIGN}")


def samples(found: Identification, record: int, *names: str) -> list[Any]:
    """Columns of the samples of a record."""
    return [found._of(record, "samples", name) for name in names]


def walls(ax: Any, found: Identification, record: int, t: Any) -> None:
    """Lines at the detected impacts within some times, in the colour of their wall."""
    times, sides = found._of(record, "picks", "time"), found._of(record, "picks", "side")
    if not t.size:
        return
    for side, color in WALLS.items():
        own = times[(sides == side) & (times >= t[0]) & (times <= t[-1])]
        for i, time in enumerate(own):
            ax.axvline(
                time,
                color=color,
                lw=0.6,
                ls=":",
                zorder=0,
                label=f"impact {side}" if i == 0 else None,
            )


def of_any_form(found: Identification, record: int) -> bool:
    """Whether the load of a record is used as recorded, since it is not a sine: then it has no phase."""
    fit = samples(found, record, "load_fit")[0]
    return math.isnan(found._one("load_phase", record)) and bool(np.isfinite(fit).any())


def draw_load(ax: Any, found: Identification, record: int) -> None:
    """The load and its fit."""
    t, load, load_fit = samples(found, record, "time", "load", "load_fit")
    ax.plot(t, load, color="0.75", lw=2.5, label="load")
    ax.plot(
        t,
        load_fit,
        color=style.LOAD,
        lw=0.7,
        ls="--",
        label=f"{'used, mean' if of_any_form(found, record) else 'fit,'} {found._one('frequency', record):.6g} Hz",
    )
    ax.set_ylabel("load (N)")
    ax.set_xlabel("$t$ (s)")
    legend(ax)


def draw_record(ax: Any, found: Identification, record: int) -> None:
    """The motion as recorded, with the detected impacts."""
    t, motion = samples(found, record, "time", "motion")
    ax.plot(t, motion, color=style.PRIMARY, lw=0.7, label=found._one("quantity", record))
    walls(ax, found, record, t)
    ax.set_ylabel(LABELS[found._one("quantity", record)])
    ax.set_xlabel("$t$ (s)")
    legend(ax)


def draw_impacts(ax: Any, found: Identification, record: int) -> None:
    """Load phases of all detected impacts, and the phases of the pattern."""
    times, sides = found._of(record, "picks", "time"), found._of(record, "picks", "side")
    frequency, phase = found._one("frequency", record), found._one("load_phase", record)
    t = found._of(record, "samples", "time")
    begin = t[0] if t.size else 0.0
    for side, color in WALLS.items():
        own = times[sides == side]
        cycles = frequency * (own - begin) + (
            phase / (2 * math.pi) if math.isfinite(phase) else 0.0
        )
        ax.plot(own, cycles % 1, ls="", marker=".", ms=2.5, color=color, label=f"picked, {side}")
    if found.pattern_of(record) is not None:
        fitted, walls_of = (
            found._of(record, "impacts", "fitted"),
            found._of(record, "impacts", "side"),
        )
        for angle, side in zip(fitted, walls_of, strict=True):
            ax.axhline(angle / (2 * math.pi) % 1, color=WALLS[side], lw=0.7, zorder=0)
    ax.set_ylim(-0.05, 1.05)  # marks of phases at both ends are not clipped
    any_form = of_any_form(found, record)
    ax.set_ylabel("$ft$ mod 1" if any_form else "load phase/2$\\pi$")
    ax.set_xlabel("$t$ (s), whole record")
    legend(ax)


def draw_motion(ax: Any, found: Identification, record: int) -> None:
    """The fitted motion over the record."""
    t, motion, fitted = samples(found, record, "time", "motion", "motion_fit")
    ax.plot(t, motion, color="0.75", lw=2.5, label="record")
    if np.isfinite(fitted).any():
        what = "fitted exact motion" if found.pattern_of(record) else "fitted flights"
        ax.plot(t, fitted, color=style.PRIMARY, lw=0.6, label=what)
    ax.set_ylabel(LABELS[found._one("quantity", record)])
    ax.set_xlabel("$t$ (s)")
    legend(ax)


def draw_residuals(ax: Any, found: Identification, record: int) -> None:
    """The residual: the record minus the fitted motion."""
    t, motion, fitted = samples(found, record, "time", "motion", "motion_fit")
    ax.plot(
        t,
        motion - fitted,
        color=style.IMPACT,
        lw=0.6,
        label=f"residual, misfit {found._one('misfit', record):.3g}",
    )
    label = LABELS[found._one("quantity", record)]
    ax.set_ylabel(f"residual of {label}" if label else "residual")
    ax.set_xlabel("$t$ (s)")
    legend(ax)


def legend(ax: Any) -> None:
    """A legend above the axes, if there are any labels."""
    handles, labels = ax.get_legend_handles_labels()
    if handles:
        style.add_legend(ax, handles, labels, **style.ABOVE)


#: The panels by name.
PANELS = {
    "load": draw_load, "record": draw_record, "impacts": draw_impacts, "motion": draw_motion,
    "residuals": draw_residuals,
}  # fmt: skip
