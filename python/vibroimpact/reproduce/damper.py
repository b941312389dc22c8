"""The reduction of the motion of the primary mass by the impacts at constant r, as in Figure 10."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import Oscillator, Pattern, equispaced_batch, periodic_batch
from ..plot import style
from . import canvas
from .paper import KINDS
from .scan import equispaced_zone, is_good
from .sweeps import read_sweeps

#: Frequency ratios of the curves; there is a simulated sweep at each of them.
CURVES = (0.94, 0.96, 0.98, 1.00, 1.02, 1.04, 1.06)


class Curve(NamedTuple):
    """Stable motions with two impacts a cycle at one r: F0/(dK) and max|X|/A."""

    r: float
    load: NDArray[np.float64]
    attenuation: NDArray[np.float64]


def curve(osc: Oscillator, r: float, resolution: float = 1.0) -> Curve:
    """Equispaced and unequispaced motions, in the order of the load."""
    second = np.linspace(0, 2 * np.pi, max(200, round(4000 * resolution)))[1:-1]
    pair = periodic_batch(osc, r, [np.zeros_like(second), second], Pattern("RL"))
    good = (pair.stable == 1) & (pair.admissible == 1)
    load, attenuation = 1 / pair.clearance[good], pair.attenuation[good]
    if osc.restitution[0] == osc.restitution[1]:
        count = max(60, round(400 * resolution))
        zone = equispaced_zone(osc, np.array([r]), count)
        # from edge to edge of the zone, because the attenuation changes fast there
        gap = np.concatenate(
            [np.empty(0), *(np.geomspace(s.low[0], s.high[0], count) for s in zone)]
        )
        for motions in equispaced_batch(osc, r, gap) if gap.size else ():
            good = is_good(motions)
            load = np.concatenate([load, 1 / motions.clearance[good]])
            attenuation = np.concatenate([attenuation, motions.attenuation[good]])
    order = np.argsort(load)
    return Curve(r, load[order], attenuation[order])


def draw(osc: Oscillator, folder: Path, name: str, rig: str, resolution: float) -> list[Curve]:
    """Draw and write one part of Figure 10."""
    found = [curve(osc, r, resolution) for r in CURVES]
    holds = {sweep["r"]: sweep["seen"] for sweep in read_sweeps(folder, rig)}
    figure, ax = canvas.panels(height=4.2)
    figure.set_size_inches(6.4, 4.2)  # the legend is beside the axes
    for one, (colour, line, mark) in zip(found, canvas.LOOKS, strict=True):
        # a gap in the zone is drawn as a gap in the curve
        far = np.diff(np.log(one.load), prepend=np.log(one.load[:1])) > 0.1
        ax.plot(
            np.where(far, np.nan, one.attenuation), one.load, color=colour, ls=line, marker=mark,
            markevery=[], ms=3.5, mew=0, label=f"$r$ = {one.r:g}",
        )  # fmt: skip
        seen = [x for x in holds[one.r] if x["kind"] in KINDS]
        two = [x for x in seen if x["kind"] in ("2", "2e", "2u")]
        others = [x for x in seen if x not in two]
        for chosen, look in (
            (others, {"mfc": "none", "mew": 0.5, "ms": 3}),
            (two, {"mew": 0, "ms": 3.5}),
        ):
            values = [(x["attenuation"], x["load"]) for x in chosen]
            ax.plot(*np.array(values).reshape(-1, 2).T, mark, color=colour, **look)
    ax.axvline(1, color="0.5", lw=0.7, ls=(0, (5, 3)))
    style.log_scale(ax, "x")
    style.log_scale(ax, "y")
    ax.set(xlabel=style.ATTENUATION_LABEL, ylabel=canvas.LOAD)
    ax.plot([], [], "o", color="0.4", ms=3.5, mew=0, label="simulation, 2 impacts/cycle")
    ax.plot([], [], "o", color="0.4", ms=3, mew=0.5, mfc="none", label="simulation, others")
    canvas.legend(ax, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.6)
    canvas.identify(ax, osc)
    canvas.save(figure, folder, name)
    rows = [(one.r, *row) for one in found for row in zip(one.load, one.attenuation, strict=True)]
    canvas.table(folder, name, ("r", "load", "attenuation"), rows)
    for one in found:
        if one.load.size:
            least = int(np.argmin(one.attenuation))
            print(
                f"{name}: r = {one.r:g}: least X_max/A = {one.attenuation[least]:.4f} at F0/(dK) = "
                f"{one.load[least]:.4g}, largest {one.attenuation.max():.4f}"
            )
    return found
