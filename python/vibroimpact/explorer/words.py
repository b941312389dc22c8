"""The texts of the page: the table of motions, the point, the simulation and the diagram in words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .. import BifurcationDiagram, Trajectory
from .explorer import Explorer, settles_on
from .limits import Limit, TooLong
from .motions import Shown
from .shapes import color, hatch
from .state import NUMBERS, WINDOW, number_text, pattern_text
from .zones import Family

__all__ = ["diagram_text", "fields", "open_zones", "place", "rows", "run_text", "zones_legend"]


def rows(shown: list[Shown], chosen: int) -> list[dict[str, Any]]:
    """The table of motions."""
    table = []
    words = {True: "stable", False: "unstable", None: "on the edge"}
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


def place(r: float, clearance: float, shown: list[Shown], inside: Iterable[Family]) -> str:
    """A point with its motions and the zones that contain it."""
    names = [family.name for family in inside]
    stable = sum(bool(item.motion.stable) for item in shown)
    within = f"in the zone{'s' * (len(names) > 1)} of {', '.join(names)}" if names else "in no zone"
    count = f"{len(shown)} motion{'s' * (len(shown) != 1)}, {stable} stable"
    return f"r = {r:.5g}, dK/F₀ = {clearance:.5g}: {count}; {within}"


def fields(explorer: Explorer) -> dict[str, str]:
    """The contents of the fields."""
    state = explorer.state
    return (
        {name: number_text(getattr(state, name)) for name in (*NUMBERS, *WINDOW)}
        | {"patterns": " ".join(map(pattern_text, state.patterns))}
        | {f"run_{name}": number_text(value) for name, value in vars(explorer.start()).items()}
    )


def run_text(trajectory: Trajectory, limit: Limit) -> str:
    """The outcome of a simulation."""
    kinds = trajectory.events["kind"].tolist()
    counts = [
        f"{n} {name}{'s' * (n != 1)}"
        for n, name in ((kinds.count("impact"), "impact"), (kinds.count("stick"), "rest"))
    ]
    try:
        end = limit(settles_on, trajectory)
    except TooLong as error:
        end = f"whether it settles was not found out ({error})"
    return f"{', '.join(counts)}; {end}"


def diagram_text(diagram: BifurcationDiagram) -> str:
    """The windows of periodic motion along the line."""
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
