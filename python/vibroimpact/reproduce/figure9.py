"""Figure 9: load and acceleration of the primary mass for four kinds of motion, at points chosen here."""

from __future__ import annotations

from pathlib import Path

from .. import Motion, exact, simulate
from ..plot import draw
from . import canvas
from .paper import UNEQUAL

#: Panel: text of the caption, the corresponding pattern, r and d K/F0 of the point chosen here.
PANELS = {
    "a": ("two impacts a cycle, one on steel and one on tape", "RL", 1.06, 20.0),
    "b": ("three impacts a cycle, one on steel and two on tape", "RLL", 0.90, 12.0),
    "c": ("one impact on steel and many on tape", "RL*", 0.90, 6.0),
    "d": ("two impacts on steel and many on tape", "RRL*", 0.76, 1.0),
}


def motions() -> dict[str, Motion]:
    """The exact motion of each panel, from a settled simulation."""
    return {
        panel: exact(UNEQUAL, r, clearance, simulate(UNEQUAL, r, clearance, 8, discard=500))
        for panel, (_, _, r, clearance) in PANELS.items()
    }


def there(motion: Motion, sides: str) -> bool:
    """Whether a motion is stable and has a pattern, beginning with any symbol."""
    symbols = motion.pattern.symbols
    turned = {"".join(symbols[j:] + symbols[:j]) for j in range(len(symbols))}
    return sides in turned and motion.pattern.cycles == 1 and motion.stable is True


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure9.png and .svg, write figure9.csv; True if all four kinds are there and stable."""
    figure, axes = canvas.panels(2, 6.2, rows=4, sharex="col", height_ratios=(0.7, 1.0, 0.7, 1.0))
    rows, good = [], True
    for i, (panel, motion) in enumerate(motions().items()):
        caption, sides, r, clearance = PANELS[panel]
        load, acceleration = axes[2 * (i // 2), i % 2], axes[2 * (i // 2) + 1, i % 2]
        draw(motion, load, "load", cycles=2)
        draw(motion, acceleration, "acceleration", cycles=2)
        load.set_xlabel("")
        acceleration.tick_params(labelbottom=True)
        load.set_title(f"({panel}) {caption}\n$r$ = {r:g}, $dK/F_0$ = {clearance:g}", fontsize=7.5)
        numbers = (len(motion.events), abs(motion.multipliers[0]), motion.x_min, motion.x_max)
        rows.append((panel, motion.pattern.sides, r, clearance, *numbers))
        outcome = "stable" if there(motion, sides) else "NOT FOUND"
        print(
            f"Figure 9{panel}: {caption}: {sides} at r = {r:g}, d K/F0 = {clearance:g}: {outcome}"
        )
        good = good and there(motion, sides)
    canvas.identify(axes[0, 0], UNEQUAL)
    canvas.save(figure, folder, "figure9")
    header = ["panel", "sides", "r", "clearance", "events a cycle", "max|lambda|", "x_min", "x_max"]
    canvas.table(folder, "figure9", header, rows)
    return good
