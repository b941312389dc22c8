"""Figure 9: load and acceleration of the primary mass for four kinds of motion, unequal restitution.

The paper shows oscilloscope traces at points whose parameters it does not give; here each kind is found at a
point inside its zone by simulation, then as an exact motion.
"""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

from ..files import write_bytes, write_text
from ..model import Oscillator
from ..motion import Motion
from ..newton import exact
from ..trajectory import simulate

#: R1 = 0.75 on steel (right wall), R2 = 0.61 on tape (left wall), as in Figure 8.
OSCILLATOR = Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))

#: Panel: what the caption says, the pattern that this is, r and d K/F0 of the point chosen here.
PANELS = {
    "a": ("two impacts a cycle, one on steel and one on tape", "RL", 1.06, 20.0),
    "b": ("three impacts a cycle, one on steel and two on tape", "RLL", 0.90, 12.0),
    "c": ("one impact on steel and many on tape", "RL*", 0.90, 6.0),
    "d": ("two impacts on steel and many on tape", "RRL*", 0.76, 1.0),
}


def motions() -> dict[str, Motion]:
    """The exact motion of each panel, from where a simulation from rest settles."""
    return {
        panel: exact(OSCILLATOR, r, clearance, simulate(OSCILLATOR, r, clearance, 8, discard=500))
        for panel, (_, _, r, clearance) in PANELS.items()
    }


def same_kind(motion: Motion, sides: str) -> bool:
    """Whether a motion has a pattern, whichever letter comes first."""
    letters = motion.pattern.letters
    turned = {"".join(letters[j:] + letters[:j]) for j in range(len(letters))}
    return sides in turned and motion.pattern.cycles == 1


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Draw figure9.png and figure9.svg, write figure9.csv; True if all four kinds are there and stable."""
    from ..plot import draw, style

    found = motions()
    table = [
        ["panel", "sides", "r", "clearance", "events a cycle", "max|lambda|", "x_min", "x_max"]
    ]
    good = True
    plt = style.pyplot()
    with plt.rc_context(style.SETTINGS):
        figure, axes = plt.subplots(
            4, 2, figsize=(style.TWO_COLUMNS, 5.6), layout="constrained", sharex="col",
            gridspec_kw={"height_ratios": (0.7, 1.0, 0.7, 1.0)},
        )  # fmt: skip
        for i, (panel, (caption, sides, r, clearance)) in enumerate(PANELS.items()):
            motion = found[panel]
            load, acceleration = axes[2 * (i // 2), i % 2], axes[2 * (i // 2) + 1, i % 2]
            draw(motion, load, "load", cycles=2)
            draw(motion, acceleration, "acceleration", cycles=2)
            load.set_xlabel("")
            acceleration.tick_params(labelbottom=True)
            load.set_title(
                f"({panel}) {caption}\n$r$ = {r:g}, $dK/F_0$ = {clearance:g}", fontsize=7
            )
            there = same_kind(motion, sides) and motion.stable is True
            good = good and there
            largest = abs(complex(motion.multipliers[0]))
            table.append(
                [panel, motion.pattern.sides, repr(r), repr(clearance), str(len(motion.events)),
                 repr(largest), repr(motion.x_min), repr(motion.x_max)]
            )  # fmt: skip
            verdict = "found, stable" if there else "NOT FOUND"
            print(
                f"Figure 9{panel}: {caption}: {motion.pattern.sides} at r = {r:g}, d K/F0 = {clearance:g}, "
                f"period/pi = {motion.period / math.pi:.4f}, max|lambda| = {largest:.4f}: {verdict}"
            )
        for kind in ("png", "svg"):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=kind, dpi=200)
            write_bytes(folder / f"figure9.{kind}", buffer.getvalue())
        plt.close(figure)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(table)
    write_text(folder / "figure9.csv", text.getvalue())
    print(f"written: {folder / 'figure9.png'}, .svg, .csv")
    return good
