"""Derivatives of motions and trajectories with respect to parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError
from ..base.status import raise_status, status_text
from ..results.events import EVENT_TYPE, event_arrays
from ..results.gradient import Gradient, frozen
from ..results.states import NEEDED, moments_of

if TYPE_CHECKING:
    from ..motions.motion import Motion
    from ..motions.trajectory import Trajectory

#: The parameters of motions of the oscillator, and the core's groups of quantities, by impact and single.
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2", "R", "load")
OF_IMPACTS = (
    "alpha", "X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after", "approach_speeds",
    "gaps_right", "gaps_left",
)  # fmt: skip
OF_MOTION = (
    "A", "tau", "load_phase", "x_max", "x_min", "attenuation", "x_rms", "fundamental_amplitude",
    "fundamental_phase", "stability_margin",
)  # fmt: skip
#: Largest number of impacts in a period for which the core computes derivatives in closed form, and of events of a
#: trajectory.
MOST_IMPACTS, MOST_EVENTS = 24, 1_000_000
#: The quantities that are differentiated at each event of a trajectory.
OF_EVENTS = ("time", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")
#: Codes of the core's vi_status.
NOT_FINITE, FOLD, GRAZE, NOT_EXACT, NOT_SMOOTH = 6, 25, 26, 27, 29
#: Condition number above which a motion counts as being at a fold.
SINGULAR = 1e10


def motion_gradient(motion: Motion) -> Gradient:
    """The derivatives of a motion without rest of at most `MOST_IMPACTS` impacts."""
    n = len(motion.pattern)
    values, slopes, codes, status = _core.motion_gradient(
        10 * n + 18, motion.osc.xi, motion.osc.mu, motion.osc.restitution, motion.r, motion.load,
        motion.clearance, motion.pattern.cycles, motion.pattern.signs, motion.restitution, motion.X,
        motion.alpha + motion.tau, motion.multipliers,
    )  # fmt: skip
    raise_status(int(status))
    sizes = dict.fromkeys(OF_IMPACTS, n) | dict.fromkeys(OF_MOTION, 0)
    found = split(values, slopes.T, codes, sizes)
    dimensions: dict[str, tuple[str, ...]] = {
        name: ("impact",) if size else () for name, size in sizes.items()
    }
    # real parts, then imaginary parts
    rest = sum(max(1, size) for size in sizes.values())
    parts = split(values[rest:], slopes.T[rest:], codes[rest:], {"multipliers": 4, "imaginary": 4})
    for table, part in zip(found[:2], parts[:2], strict=True):
        table["multipliers"] = frozen(part["multipliers"] + 1j * part["imaginary"])
    status_of = found[2] | {name: text for name, text in parts[2].items() if name[0] == "m"}
    found[0]["phases"] = motion.phases
    found[1]["phases"] = frozen(found[1]["alpha"] + found[1]["load_phase"])
    dimensions |= {"phases": ("impact",), "multipliers": ("multiplier",)}
    of = (
        f"the motion {motion.pattern.sides}/{motion.pattern.cycles} at r = {motion.r:.6g}, "
        f"d K/F0 = {motion.clearance:.6g}"
    )
    return Gradient(of, PARAMETERS, found[0], found[1], dimensions, status_of)


def trajectory_gradient(run: Trajectory) -> Gradient:
    """The derivatives of a trajectory."""
    n = len(run.events)
    if not run.complete:
        raise ParameterError(f"{run!r}: must be complete to have derivatives")
    if n > MOST_EVENTS:
        raise ParameterError(f"{run!r}: must have at most {MOST_EVENTS} events to have derivatives")
    start, finish = (moments_of(state)[0] for state in (run.initial_state, run.final_state))
    # f2py does not accept an array without columns
    values, labels = event_arrays(run.events if n else np.zeros(1, EVENT_TYPE))
    by_events, by_final, good = _core.trajectory_gradient(
        n, run.osc.xi, run.osc.mu, run.osc.restitution, run.r, run.load, run.clearance,
        *start, *finish, values, labels,
    )  # fmt: skip
    by_events = by_events[:, :, :n]
    finite = np.isfinite(by_events).all(axis=(0, 1))
    status: dict[str, str] = {}
    if good < n:
        status[f"events[{good}:]"] = status_text(GRAZE)
    elif not finite.all():
        good = int(finite.argmin())
        status[f"events[{good}:]"] = status_text(NOT_FINITE)
    by_events[:, :, good:] = math.nan
    if status:
        by_final[:] = math.nan
    if run.initial_state["resting"]:
        status["z, z_dot"] = "the free mass rests on a wall at the start and moves with the wall"
        by_events[3:5] = by_final[3:5] = math.nan
    tables: tuple[dict[str, NDArray[Any]], dict[str, NDArray[Any]]] = ({}, {})
    for i, name in enumerate(OF_EVENTS):
        tables[0][name] = frozen(run.events[name].copy())
        tables[1][name] = with_both(by_events[:, i].T)
    for i, name in enumerate(NEEDED):
        tables[0][f"final_{name}"] = frozen(np.asarray(run.final_state[name]))
        tables[1][f"final_{name}"] = with_both(by_final[:, i])
    dimensions: dict[str, tuple[str, ...]] = dict.fromkeys(tables[0], ())
    dimensions |= dict.fromkeys(OF_EVENTS, ("event",))
    of = f"the trajectory at r = {run.r:.6g}, d K/F0 = {run.clearance:.6g} with {n} events"
    return Gradient(of, (*NEEDED, *PARAMETERS), *tables, dimensions, status)


def with_both(slopes: NDArray[Any]) -> NDArray[Any]:
    """The derivatives of a trajectory, with those with respect to a common R of both walls inserted before the
    last one."""
    both = slopes[..., 9:10] + slopes[..., 10:11]
    return frozen(np.concatenate([slopes[..., :11], both, slopes[..., 11:]], axis=-1))


def split(
    values: NDArray[Any], slopes: NDArray[Any], codes: NDArray[Any], sizes: Mapping[str, int]
) -> tuple[dict[str, NDArray[Any]], dict[str, NDArray[Any]], dict[str, str]]:
    """Values, derivatives and status by name, from the core's lists; size 0 means a single number."""
    tables: tuple[dict[str, NDArray[Any]], dict[str, NDArray[Any]]] = ({}, {})
    status: dict[str, str] = {}
    start = 0
    for name, size in sizes.items():
        places = slice(start, start + size) if size else start
        tables[0][name] = frozen(np.asarray(values[places]))
        tables[1][name] = frozen(np.asarray(slopes[places]))
        for i, code in enumerate(codes[start : start + max(1, size)].tolist()):
            if code:
                status[f"{name}[{i}]" if size else name] = status_text(code)
        start += max(1, size)
    return *tables, status
