"""A design: its candidates, the share of good samples along the band, its sensitivities, and the history of its
searches."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.files import place_for
from ..results.tables import UNIT_OF
from ..systems.units import SI, range_text, shown_unit, units_to_show, value_text
from . import style

if TYPE_CHECKING:
    from ..designs.design import Design
    from ..systems.units import Units

#: Symbols of targets.
TARGETS = {
    "attenuation": style.ATTENUATION_LABEL, "displacement": r"$\max|X|$", "rms": r"rms $X$",
    "acceleration": r"$\max|\ddot X|$", "force": r"$\max|X + 2\xi\dot X|$", "damping": "damping ratio",
}  # fmt: skip
SYMBOLS = style.SYMBOLS | {"restitution": "$R$"}
#: Formats of reports.
FORMATS = (".pdf", ".png", ".svg")
#: Margins of a page, and the lowest end of its text, as fractions of the page.
LEFT, RIGHT, LOWEST = 0.1, 0.95, 0.5


def draw_design(design: Design, ax: Any = None, units: Units | None = None) -> Any:
    """Draw five panels into a new figure, or the share of good samples into `ax`."""
    plt, scales = style.pyplot(), style.Scales(units)
    with plt.rc_context(style.SETTINGS):
        if ax is not None:
            _draw_shares(ax, design, scales)
            return ax
        figure = plt.figure(figsize=(style.TWO_COLUMNS, 6.6), layout="constrained")
        panels = _panels(figure.add_gridspec(3, 2, height_ratios=(1, 1, 0.7)))
        _draw_panels(panels, design, scales)
        texts = [
            *(f"{_symbol(design, name)} = {value:.6g}" for name, value in design.values.items()),
            *_dimensions(design, units),
        ]
        figure.suptitle("design: " + ", ".join(texts), fontsize=7)
        return panels


def _panels(grid: Any) -> Any:
    """Two panels in each of the first two rows of a grid, and one in the last."""
    figure, places = grid.figure, [grid[row, column] for row in (0, 1) for column in (0, 1)]
    return np.array([figure.add_subplot(place) for place in (*places, grid[2, :])])


def report(design: Design, path: Any) -> None:
    """One page with the answer, the task, the chosen values, and the five panels."""
    place = place_for(path, FORMATS)
    with style.pyplot().rc_context(style.SETTINGS):
        style.save(_page(design), place)


def _page(design: Design) -> Any:
    """The panels of the page, below its text; the font size of the text is reduced until the page is large
    enough."""
    figure = style.pyplot().figure(figsize=(8.27, 11.69))
    figure.text(LEFT, 0.955, "Design of an impact damper", fontsize=14, weight="bold", va="top")
    text = figure.text(
        LEFT, 0.925, "\n".join(_lines(design)), va="top", linespacing=1.5, fontsize=8.5
    )
    while True:
        (left, low), (right, _) = (
            text.get_window_extent().transformed(figure.transFigure.inverted()).get_points()
        )
        if (right - left <= RIGHT - LEFT and low > LOWEST) or text.get_fontsize() < 3:
            break
        text.set_fontsize(0.95 * text.get_fontsize())
    grid = figure.add_gridspec(
        3, 2, left=LEFT, right=RIGHT, top=low - 0.05, bottom=0.06, hspace=0.6, wspace=0.35,
        height_ratios=(1, 1, 0.7),
    )  # fmt: skip
    panels = _panels(grid)
    _draw_panels(panels, design, style.Scales(_units(design)))
    return panels


def _units(design: Design) -> Units | None:
    """The units of a report."""
    return units_to_show(design.osc) if design.case else None


def _lines(design: Design) -> list[str]:
    """The text of a report."""
    lines = [*_wrapped(f"{design.verdict[0].upper()}{design.verdict[1:]}."), ""]
    units = _units(design)
    osc = design.osc if design.case else None
    chosen = (
        f"{'$d$' if units and name == 'clearance' else _symbol(design, name)} = {value_text(osc, name, value)} "
        f"({'wall to wall, ' * bool(units and name == 'clearance')}from {range_text(osc, name, low, high)})"
        for (name, value), (low, high) in zip(
            design.values.items(), design.ranges.values(), strict=True
        )
    )
    lines += _wrapped("Chosen: " + ", ".join(chosen) + ".")
    dimensions = _dimensions(design, units)
    if dimensions:
        lines += _wrapped("That is " + ", ".join(dimensions) + ".")
    for text in design.asked:
        lines += _wrapped(text)
    levels = ", ".join(
        value_text(osc, design.target, level, 4) for level in sorted(design.searches["level"])
    )
    lines += _wrapped(f"Best levels of the independent searches: {levels}.")
    tried = design.tried["runs"]
    lines += _wrapped(
        f"Candidates: {len(tried)}, of which {len(design.candidates)} were judged by all {tried.max()} runs of "
        "units, and the others only until their levels were certainly worse."
    )
    if design.samples:
        worst = value_text(osc, design.target, design.worst, 4)
        lines.append(
            f"Worst of all samples: {worst}; abandoned simulations, which count as bad: {design.failed}."
        )
    if design.sensitivity:
        slopes = [
            f"{'$d$' if units and name == 'clearance' else _symbol(design, name)} "
            f"{_slope_text(osc, design.target, name, slope)}"
            for name, slope in design.sensitivity.items()
        ]
        lines += _wrapped(
            "Derivatives of the target of the worst unit with respect to " + ", ".join(slopes) + "."
        )
    return lines


def _symbol(design: Design, name: str) -> str:
    """The symbol of a parameter; parameters of a host that is a function have only names."""
    return SYMBOLS.get(name, name) if design.case else name


def _slope_text(osc: Any, target: str, name: str, slope: float) -> str:
    """A derivative of the target with respect to a parameter, in their units."""
    (scale, unit), (own, below) = shown_unit(osc, target), shown_unit(osc, name)
    above = unit.strip() or ("1" if below else "")
    per = f"/({below.strip()})" if "/" in below else f"/{below.strip()}" if below else ""
    return f"{slope * scale / own:+.4g}{' ' * bool(above)}{above}{per}"


def _wrapped(text: str) -> list[str]:
    """Lines of a page; names and numbers are not broken."""
    return textwrap.wrap(text, 105, break_long_words=False, break_on_hyphens=False)


def _dimensions(design: Design, units: Units | None) -> list[str]:
    """The free mass that corresponds to a chosen mass ratio."""
    if units is None or "mu" not in design.values:
        return []
    mass = units.to(SI).M
    return [f"m = {design.values['mu'] * mass:.5g} kg, with M = {mass:.5g} kg"]


def _draw_panels(panels: Any, design: Design, scales: style.Scales) -> None:
    """The five panels."""
    drawings = (_draw_levels, _draw_front, _draw_shares, _draw_slopes, _draw_history)
    for panel, draw in zip(panels, drawings, strict=True):
        draw(panel, design, scales)


def _of_target(design: Design, scales: style.Scales) -> tuple[str, str]:
    """The unit of the target, and its label."""
    if not design.case:
        # a function has units of its own
        of = f" of {design._output}" if design._output else ""
        return "", f"{design.target}{of}"
    unit = UNIT_OF[design.target]
    return unit, scales.label(TARGETS[design.target], unit)


def _axis(design: Design, scales: style.Scales, name: str) -> str:
    """The label of an axis of a parameter."""
    if design.case and name in style.NAMES:
        return scales.name(name)
    return "\n".join(textwrap.wrap(name, 36))


def _draw_levels(ax: Any, design: Design, scales: style.Scales) -> None:
    """The levels of the candidates against the first parameter."""
    name = next(iter(design.values))
    unit, label = _of_target(design, scales)
    rows = _within(design, design.candidates)
    places, levels = scales.of(name, rows[name]), scales(rows["level"], unit)
    ax.plot(places, levels, "o", ms=3, mfc="none", color=style.PRIMARY, label="candidates")
    chosen = scales.of(name, design.values[name]), scales(design.level, unit)
    ax.plot(*chosen, "*", ms=9, color=style.FREE, label="chosen")
    if design.limit is not None:
        ax.axhline(scales(design.limit, unit), color=style.LOAD, lw=0.8, ls="--", label="limit")
    ax.set_xlabel(_axis(design, scales, name))
    ax.set_ylabel(f"{100 * design.quantile:g} % quantile of {label}")
    style.add_legend(ax, **style.ABOVE)


def _draw_front(ax: Any, design: Design, scales: style.Scales) -> None:
    """Attenuation against robustness: the unit without deviations, and all units."""
    unit, label = _of_target(design, scales)
    for rows, label_of_rows, style_of_rows in (
        (
            _within(design, design.candidates),
            "candidates",
            {"marker": "o", "ls": "", "ms": 3, "mfc": "none"},
        ),
        (design.front, "Pareto front", {"marker": "s", "ms": 4, "lw": 0.8}),
    ):
        color = style.PRIMARY if label_of_rows == "candidates" else style.REST
        levels = [scales(rows[name], unit) for name in ("nominal", "level")]
        ax.plot(*levels, color=color, label=label_of_rows, **style_of_rows)
    ax.set_xlabel(f"{label} without deviations")
    ax.set_ylabel(f"{100 * design.quantile:g} % quantile of {label}")
    style.add_legend(ax, **style.ABOVE)


def _within(design: Design, rows: Any) -> Any:
    """Candidates whose levels fit in one picture with the level of the chosen one."""
    near = abs(rows["level"]) <= 4 * abs(design.level)
    return rows[near & np.isfinite(rows["nominal"])]


def _draw_shares(ax: Any, design: Design, scales: style.Scales) -> None:
    """The share of good samples along the band, with its intervals."""
    bands = design.bands
    if not bands["samples"].size:
        ax.text(0.5, 0.5, "no samples", ha="center", va="center", transform=ax.transAxes)
        ax.set_axis_off()
        return
    along = "x" if design.target == "damping" else "r"
    first, last = (scales.of(along, bands[name]) for name in ("from", "to"))
    share = bands["probability"]
    errors = np.maximum(0, [share - bands["low"], bands["high"] - share])
    ax.errorbar(
        0.5 * (first + last), share, errors, 0.5 * (last - first), fmt="o", ms=3, lw=0.8, capsize=2,
        color=style.PRIMARY, label="samples, 95 % interval",
    )  # fmt: skip
    ax.axhline(design.quantile, color=style.LOAD, lw=0.8, ls="--", label="wanted")
    ax.set_xlabel(
        scales.label("initial displacement", "F0/K") if along == "x" else _axis(design, scales, "r")
    )
    ax.set_ylabel("share of good samples")
    ax.locator_params(axis="x", nbins=5)
    style.add_legend(ax, **style.ABOVE)


def _draw_slopes(ax: Any, design: Design, scales: style.Scales) -> None:
    """The change of the target of the worst unit for 1 % of each parameter."""
    values = style.system(design.osc) if design.case else {}
    if values and values["R1"] == values["R2"]:
        values["restitution"] = values["R1"]
    values |= design.values | {"r": float(np.mean(design.ends))}
    if "restitution" in design.values:
        values |= {"R1": design.values["restitution"], "R2": design.values["restitution"]}
    values.setdefault(
        "clearance", float(design.keys.get("clearance", np.nan)) if design.case else np.nan
    )
    names = [name for name in design.sensitivity if np.isfinite(values.get(name, np.nan))]
    if not names:
        text = "no sensitivities: the worst unit\nhas no motion with derivatives"
        ax.text(0.5, 0.5, text, ha="center", va="center", transform=ax.transAxes)
        ax.set_axis_off()
        return
    unit, label = _of_target(design, scales)
    changes = [scales(0.01 * values[name] * design.sensitivity[name], unit) for name in names]
    ax.barh(
        range(len(names)), changes, color=[style.PRIMARY if c < 0 else style.FREE for c in changes]
    )
    ax.set_yticks(range(len(names)), [_symbol(design, name) for name in names])
    ax.axvline(0, color="0.4", lw=0.6)
    ax.set_xlabel(f"change of {label} for 1 % more")


def _draw_history(ax: Any, design: Design, scales: style.Scales) -> None:
    """The candidates in their order, and the best level of each search so far; a candidate that was not judged
    by all runs shows a bound of its level."""
    unit, label = _of_target(design, scales)
    tried, chosen = design.tried, scales(design.level, unit)
    levels, runs = scales(tried["level"], unit), tried["runs"]
    whole = runs == runs.max()
    worst, best = (-math.inf, np.maximum) if design.target == "damping" else (math.inf, np.minimum)
    count, first = np.arange(len(tried)) + 1, 0
    shown = np.isfinite(levels) & (abs(levels) <= 4 * abs(chosen))
    for these, style_of_these, meaning in (
        (shown & ~whole, {"ms": 1.5, "color": "0.6"}, f"judged by fewer: a bound (at least {runs.min()})"),
        (shown & whole, {"ms": 3, "mfc": "none", "color": style.PRIMARY}, f"judged by all {runs.max()} runs"),
    ):  # fmt: skip
        ax.plot(count[these], levels[these], "o", **style_of_these, label=meaning)
    for number, many in enumerate(design.searches["candidates"]):
        part = slice(first, first + many)
        so_far = best.accumulate(np.where(whole, levels, worst)[part])
        ax.plot(
            count[part], np.where(np.isfinite(so_far), so_far, math.nan), lw=1, drawstyle="steps-post",
            color=style.PRIMARY, label=None if number else "best of a search so far",
        )  # fmt: skip
        if number:
            ax.axvline(first + 0.5, color="0.7", lw=0.6)
        first += many
    ax.axhline(chosen, color=style.FREE, lw=0.8, label="chosen")
    seen = levels[shown & whole]
    limit = math.nan if design.limit is None else scales(design.limit, unit)
    if abs(limit) <= 4 * abs(chosen):
        ax.axhline(limit, color=style.LOAD, lw=0.8, ls="--", label="limit")
        seen = np.append(seen, limit)
    if seen.size and np.ptp(seen) > 0:
        ax.set_ylim(seen.min() - 0.05 * np.ptp(seen), seen.max() + 0.05 * np.ptp(seen))
    ax.set_xlabel("candidates; vertical lines separate independent searches")
    ax.xaxis.get_major_locator().set_params(integer=True)
    ax.set_ylabel(f"quantile of\n{label}")
    style.add_legend(ax, **style.ABOVE)
