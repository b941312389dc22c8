"""The texts of the page: the table of motions, the point, the simulation and the diagram."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import BifurcationDiagram, Motion, Trajectory, Units
from .attenuation import Judged
from .explorer import Explorer, settles_on
from .limits import Limit, TooLong
from .motions import Shown
from .shapes import color, hatch
from .state import NUMBERS, WINDOW, State, number_text, pattern_text, units_text
from .zones import Family

__all__ = [
    "box_text", "diagram_text", "fields", "open_zones", "physical_text", "place", "rows", "run_text",
    "zones_legend",
]  # fmt: skip


def rows(shown: list[Shown], chosen: int) -> list[dict[str, Any]]:
    """The table of motions."""
    table = []
    words = {True: "stable", False: "unstable", None: "undecided"}
    for i, item in enumerate(shown):
        motion = item.motion
        table.append(
            {
                "label": item.label, "stable": words[motion.stable], "chosen": i == chosen,
                "attenuation": f"{motion.attenuation:.6g}" if motion.A > 0 else "–",
                "multiplier": f"{abs(complex(motion.multipliers[0])):.6g}",
                "kind": motion.leading_kind or "", "definition": item.definition.text,
            }
        )  # fmt: skip
    return table


def place(state: State, shown: list[Shown], inside: Iterable[Family]) -> str:
    """The point of a state with its motions and the zones that contain it."""
    where = at(state.r, state.clearance, state.units)
    names = [family.name for family in inside]
    stable = sum(bool(item.motion.stable) for item in shown)
    within = f"in the zone{'s' * (len(names) > 1)} of {', '.join(names)}" if names else "in no zone"
    count = f"{len(shown)} motion{'s' * (len(shown) != 1)}, {stable} stable"
    return f"{where}: {count}; {within}"


def at(r: float, clearance: float, units: Units | None) -> str:
    """A point, with its frequency and clearance if there are units."""
    if units is None:
        return f"r = {r:.5g}, dK/F₀ = {clearance:.5g}"
    units = units.of_pictures
    frequency, d = r * units.frequency, clearance * units.length
    return (
        f"r = {r:.5g} ({frequency:.5g} {units.hertz}), "
        f"dK/F₀ = {clearance:.5g} (d = {d:.5g} {units.name('F0/K')})"
    )


def physical_text(motion: Motion | None, units: Units | None) -> str:
    """Response quantities of a motion in physical and in dimensionless units; empty without a motion or units."""
    if motion is None or units is None:
        return ""
    found, units = motion.quantities(), units.of_pictures
    values = (
        ("max|X|", found.x.peak, "F0/K", "F₀/K"),
        ("rms X", found.x.rms, "F0/K", "F₀/K"),
        ("max|Ẋ|", found.x_dot.peak, "omega F0/K", "ωF₀/K"),
        ("max|Ẍ|", found.x_ddot.peak, "omega^2 F0/K", "ω²F₀/K"),
        ("greatest impact speed", found.impacts["speed"].max(), "omega F0/K", "ωF₀/K"),
        ("period", motion.period, "1/omega", "1/ω"),
    )  # fmt: skip
    text = "; ".join(
        f"{name} = {value * units.scale(unit):.4g} {units.name(unit)} ({value:.4g} {symbol})"
        for name, value, unit, symbol in values
    )
    return text.replace("^2", "²")


def box_text(state: State, found: Judged, good: NDArray[np.bool_]) -> str:
    """The text on how many points in the box are good."""
    n, box = len(good), state.box
    known = np.flatnonzero(~np.isnan(found.attenuation))
    assert box is not None
    if not len(known):
        return f"none of {n} simulations was completed"
    worst = known[np.argmax(found.attenuation[known])]
    place = at(float(found.r[worst]), float(found.clearance[worst]), state.units)
    lost = (
        f" {n - len(known)} simulations were abandoned and count as exceeding the limit."
        if len(known) < n
        else ""
    )
    return (
        f"{100 * good.mean():.4g} % of {n} points have max|X|/A ≤ {state.limit:.6g} on every attractor reached, "
        f"{100 * found.stable.mean():.4g} % settle on periodic motions. "
        f"Greatest max|X|/A: {found.attenuation[worst]:.4g} at {place}.{lost}"
    )


def fields(explorer: Explorer) -> dict[str, str]:
    """The contents of the fields."""
    state = explorer.state
    return (
        {name: number_text(getattr(state, name)) for name in (*NUMBERS, *WINDOW)}
        | {
            "patterns": " ".join(map(pattern_text, state.patterns)),
            "units": units_text(state.units),
        }
        | {"limit": number_text(state.limit)}
        | {f"box_{name}": number_text(value) for name, value in vars(explorer.box()).items()}
        | {f"run_{name}": number_text(value) for name, value in vars(explorer.start()).items()}
    )


def run_text(trajectory: Trajectory, limit: Limit) -> str:
    """The text on the outcome of a simulation."""
    kinds = trajectory.events["kind"].tolist()
    counts = [
        f"{n} {name}{'s' * (n != 1)}"
        for n, name in ((kinds.count("impact"), "impact"), (kinds.count("stick"), "rest"))
    ]
    try:
        end = limit(settles_on, trajectory)
    except TooLong as error:
        end = f"not known whether it settles ({error})"
    return f"{', '.join(counts)}; {end}"


def diagram_text(diagram: BifurcationDiagram) -> str:
    """The text on the windows of periodic motion along the line."""
    windows = [
        f"{item.label} from {item.low:.4g} to {item.high:.4g} ({item.run})"
        for item in diagram.windows if item.low < item.high
    ]  # fmt: skip
    return f"{len(diagram.points)} impacts. " + "; ".join(windows)


def open_zones(zones: Any) -> str:
    """Names the zones of which a boundary could not be closed; empty if there are none."""
    names = ", ".join(family.name for family, zone in zones.items() if not zone.closed)
    return f"{names}: a boundary could not be closed" if names else ""


def zones_legend(zones: Any) -> list[dict[str, str]]:
    """Names, colours and hatch patterns of the zones that are drawn."""
    return [
        {"name": family.name, "color": color(i), "hatch": hatch(i)}
        for i, (family, zone) in enumerate(zones.items()) if zone
    ]  # fmt: skip
