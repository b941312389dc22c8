"""Simulated sweeps in place of the measured bars of the paper: the load is raised slowly, then lowered.

As on the rig, the frequency is fixed, the load is held for two minutes at each level (2385 r load cycles), each
hold starts from the state at the end of the previous hold, and the motion at the end of each hold is recorded.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import Motion, Oscillator, Trajectory, exact, simulate, standard_motion
from ..base.errors import ParameterError, VibroimpactError
from ..base.files import write_text
from .paper import EQUAL, HOLD, LOADS, NATURAL_FREQUENCY, RATIOS, UNEQUAL, kind_of, scale

#: Rigs by name.
RIGS = {"equal": EQUAL, "unequal": UNEQUAL}
#: Load levels, in units of `scale`.
LEVELS = 52
#: Load cycles within which a motion must repeat, and the tolerance of its phases (radians).
MOST_CYCLES, TOLERANCE = 4, 1e-3


class Bar(NamedTuple):
    """A range of load over which a kind of motion was seen, at a frequency ratio."""

    r: float
    low: float
    high: float


def sweep(
    osc: Oscillator, r: float, count: int = LEVELS, hold: float = HOLD
) -> list[dict[str, Any]]:
    """The motion at the end of each hold, with the load rising and then falling.

    With the clearance as the unit of length, the load amplitude is F0/(dK). If the free mass does not touch the
    walls, it is given a velocity and the hold is repeated.

    Parameters
    ----------
    count : int
        Load levels.
    hold : float
        Seconds at each level.
    """
    levels = (np.geomspace(*LOADS, count) * scale(r)).tolist()
    cycles = 2 * MOST_CYCLES + 2
    discard = max(0, round(hold * NATURAL_FREQUENCY * r) - cycles)
    state: dict[str, Any] = dict.fromkeys(("t", "x", "x_dot", "z", "z_dot"), 0.0)
    seen = []
    for direction, order in (("up", levels), ("down", levels[::-1])):
        for load in order:
            run = simulate(osc, r, 1.0, cycles, state=state, load=load, discard=discard)
            if not run.events.size:
                pushed = {name: run.final_state[name] for name in ("t", "x", "x_dot", "z", "z_dot")}
                # a velocity that crosses the gap in half a cycle
                pushed |= {"z": pushed["x"], "z_dot": pushed["x_dot"] + r / math.pi}
                run = simulate(osc, r, 1.0, cycles, state=pushed, load=load, discard=discard)
            state = run.final_state
            end = {name: state[name] for name in ("t", "x", "x_dot", "z", "z_dot")}
            motion = {**_name(run), "attenuation": _attenuation(run), "state": end}
            seen.append({"direction": direction, "load": load, **motion})
    return seen


def _name(run: Trajectory) -> dict[str, Any]:
    """Kind, sides and cycles of the motion at the end of a trajectory."""
    try:
        period = run.period(MOST_CYCLES, TOLERANCE)
    except ParameterError:
        kind = "irregular" if run.events.size else "no impacts"
        return {"kind": kind, "sides": "", "cycles": 0}
    sides, cycles = period.pattern.sides, period.pattern.cycles
    alike = run.osc.restitution[0] == run.osc.restitution[1]
    kind = kind_of(sides, cycles, period.events["time"] * run.r, alike=alike)
    return {"kind": kind, "sides": sides, "cycles": cycles}


def _attenuation(run: Trajectory) -> float:
    """max|X|/A over the end of a hold."""
    first, last = run.initial_state["t"], run.final_state["t"]
    history = run.sample(np.linspace(first, last, 200 * (2 * MOST_CYCLES + 2)))
    amplitude = run.load / math.hypot((1 - run.r) * (1 + run.r), 2 * run.osc.xi * run.r)
    return float(np.abs(history.X).max() / amplitude)


def bars(sweeps: list[dict[str, Any]], kind: str) -> list[Bar]:
    """Ranges of load over which successive holds ended on one kind, separately for rising and falling load."""
    found: list[Bar] = []
    for one in sweeps:
        before = None
        for item in one["seen"]:
            here = (item["direction"], item["kind"])
            if item["kind"] == kind:
                if here != before:
                    found.append(Bar(one["r"], item["load"], item["load"]))
                low, high = found[-1].low, found[-1].high
                found[-1] = Bar(one["r"], min(low, item["load"]), max(high, item["load"]))
            before = here
    return found


def seeds(sweeps: list[dict[str, Any]], osc: Oscillator) -> dict[str, list[Motion]]:
    """The exact motions of one cycle at the ends of holds, by pattern; only one of two mirror images is kept."""
    found: dict[str, list[Motion]] = {}
    for one in sweeps:
        for item in one["seen"]:
            if item["cycles"] != 1 or item["kind"] in ("2e", "2u", "2") or len(item["sides"]) > 6:
                continue
            clearance = 1 / item["load"]
            state = {k: v * (1 if k == "t" else clearance) for k, v in item["state"].items()}
            try:
                run = simulate(osc, one["r"], clearance, 2 * MOST_CYCLES, state=state)
                motion = standard_motion(exact(osc, one["r"], clearance, run))
                if osc.restitution[0] == osc.restitution[1]:
                    motion = max(
                        motion,
                        standard_motion(motion, mirrored=True),
                        key=lambda m: m.pattern.sides,
                    )
            except VibroimpactError:
                continue  # at the limit to another kind
            found.setdefault(motion.pattern.sides, []).append(motion)
    return found


def path_of(folder: Path, rig: str, r: float) -> Path:
    """The path of the saved sweep of a rig at one frequency ratio."""
    return folder / "data" / f"sweep_{rig}_{r:.2f}.json"


def run_sweep(folder: Path, rig: str, r: float, resolution: float = 1.0) -> list[Path]:
    """Compute one sweep and write it; a lower `resolution` takes fewer levels and shorter holds."""
    hold = HOLD * min(1.0, resolution)
    seen = sweep(RIGS[rig], r, max(6, round(LEVELS * resolution)), hold)
    path = path_of(folder, rig, r)
    path.parent.mkdir(exist_ok=True)
    write_text(path, json.dumps({"rig": rig, "r": r, "hold": hold, "seen": seen}) + "\n")
    return [path]


def read_sweeps(folder: Path, rig: str) -> list[dict[str, Any]]:
    """All sweeps of a rig."""
    return [json.loads(path_of(folder, rig, r).read_text(encoding="utf-8")) for r in RATIOS]
