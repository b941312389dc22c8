"""The motions that begin at a bifurcation, computed by the core."""

from __future__ import annotations

from dataclasses import replace

from .. import _core
from ..base.interrupt import with_stack
from ..motions.motion import Motion, motion_of_oscillator
from ..motions.periodic import impact_restitution
from ..systems.oscillator import Pattern

#: Bifurcations at which other motions begin, and the parameters, with their codes in the core.
KINDS = {"pitchfork": 1, "flip": 2, "grazing": 3}
PARAMETERS = {"r": 1, "clearance": 2, "xi": 3, "mu": 4, "R1": 5, "R2": 6, "restitution": 5}


def switched(motion: Motion, kind: str, flight: int, side: str, parameter: str) -> list[Motion]:
    """The motions that begin at a bifurcation of a motion, each at a slightly different value of a parameter."""
    n, lengths, cycles, sides, systems, phases, impacts, scalars, multipliers, verdicts = with_stack(
        _core.switch_branch,
        *motion._flights(), motion.osc.restitution, motion.clearance, KINDS[kind], flight + 1,
        1 if side == "R" else -1, PARAMETERS[parameter], parameter == "restitution",
    )  # fmt: skip
    found = []
    for i in range(n):
        m = lengths[i]
        letters = "".join("RL"[one < 0] for one in sides[:m, i].tolist())
        pattern = Pattern(letters, int(cycles[i]))
        r, clearance, xi, mu, *walls = systems[:, i].tolist()
        osc = replace(motion.osc, xi=xi, mu=mu, restitution=(walls[0], walls[1]))
        found.append(motion_of_oscillator(
            osc, r, clearance, 1.0, pattern, impact_restitution(osc, pattern, None),
            phases[:m, i].copy(), impacts[:m, :, i].copy(order="F"),
            scalars[:, i], multipliers[:, i].copy(), verdicts[:, i],
        ))  # fmt: skip
    return found
