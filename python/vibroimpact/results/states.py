"""States from which simulations start and in which they end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError

TWO_PI = 2 * math.pi
NEEDED = ("t", "x", "x_dot", "z", "z_dot")
#: The largest value in a state: squares and products of any two values are finite.
MOST = 1e100
SPAN = "from -1e100 to 1e100"
RANGE = f"a number {SPAN}"
EXTRA = ("cycle", "phase", "side", "speed", "resting", "released")

#: Keys of a state: t, x, x_dot, z, z_dot, and those that a `final_state` adds for an exact (bitwise) continuation.
State = dict[str, Any]

#: A state of the core: (cycle, phase, x, x', z, z', departure speed) and (side, resting, released).
Moment = tuple[NDArray[np.float64], NDArray[np.int32]]
#: xi, mu, R1 and R2, r, load, clearance.
System = tuple[float, float, tuple[float, float], float, float, float]


class Since(tuple[float, ...]):
    """The numbers of `since` in a final state, with a short representation."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<{len(self)} numbers: where the flight or rest began>"


def later(values: NDArray[np.float64], cycles: float) -> tuple[float, float]:
    """Cycle and phase of the time that is a given number of load cycles after a moment."""
    whole = math.floor(cycles)
    phase = values[1] + TWO_PI * (cycles - whole)
    over = 1 if phase >= TWO_PI else 0
    return float(values[0] + whole + over), float(max(0.0, phase - TWO_PI * over))


def state_of(system: System, now: Moment, begun: Moment) -> State:
    """The state at a moment as a dictionary.

    `since` identifies the system and the state to which it belongs, and contains the start of the flight or rest.
    A simulation of the same system that starts from the unchanged state therefore continues bit for bit.
    """
    cycle, phase, x, x_dot, z, z_dot, speed = now[0].tolist()
    side, resting, released = now[1].tolist()
    t = (TWO_PI * cycle + phase) / system[3]
    xi, mu, walls, *rest = system
    since = Since((
        xi, mu, *walls, *rest, t, x, x_dot, z, z_dot, cycle, phase, side, speed, resting, released,
        *begun[0].tolist(), *begun[1].tolist(),
    ))  # fmt: skip
    return {
        "t": t, "x": x, "x_dot": x_dot, "z": z, "z_dot": z_dot, "cycle": cycle, "phase": phase,
        "side": side, "speed": speed, "resting": resting, "released": released, "since": since,
    }  # fmt: skip


def moments_of(state: State) -> tuple[tuple[list[Any], list[int]], tuple[list[Any], list[int]]]:
    """The numbers of a `final_state`, and those of the moment at which its flight or rest began, in the order of
    the core."""
    numbers = [state[name] for name in ("cycle", "phase", "x", "x_dot", "z", "z_dot", "speed")]
    flags = [int(state[name]) for name in ("side", "resting", "released")]
    begun = state["since"][-10:]
    return (numbers, flags), ([*begun[:7]], [*map(int, begun[7:])])


def _belongs(system: System, state: Mapping[str, Any]) -> tuple[float, ...]:
    """The numbers that identify a state: those of its system, then those of the state."""
    xi, mu, walls, *rest = system
    return (xi, mu, *walls, *rest, *(state[name] for name in NEEDED + EXTRA))


def start_of(system: System, state: Mapping[str, Any] | None) -> tuple[Moment, Moment]:
    """The moment of a state given by the caller, and the moment at which its flight or rest began."""
    clearance = system[5]
    if state is None:
        moment = (np.zeros(7), np.zeros(3, dtype=np.int32))
        return moment, moment
    given = checked_state(state, clearance)
    if all(name in given for name in EXTRA):
        resumed = _resume(given, state, system)
        if resumed is not None:
            return resumed
    start = np.array([given[name] for name in NEEDED])
    moment = _core.start_state(system[0], system[3], system[4], clearance, start)
    return moment, moment


def as_numbers(state: Mapping[str, Any] | None) -> dict[str, float] | None:
    """The namelist keys of the initial state; None if a namelist cannot express it, as after another
    simulation."""
    if state is None:
        return dict.fromkeys(NEEDED, 0.0)
    if any(name in state for name in (*EXTRA, "since")):
        return None
    return {name: float(value) for name, value in completed_state(state).items()}


def completed_state(state: Mapping[str, Any]) -> dict[str, Any]:
    """A state of five numbers; missing ones are 0.

    The keys that a `final_state` adds are valid only together with all other keys: if they are present, no key may
    be missing.
    """
    missing = [name for name in NEEDED if name not in state]
    unknown = [name for name in state if name not in (*NEEDED, *EXTRA, "since")]
    extra = [name for name in state if name in (*EXTRA, "since")]
    if unknown or (missing and extra) or not state:
        fault = f"unknown: {unknown}" if unknown else f"missing: {missing}"
        raise ParameterError(
            f"state with the keys {', '.join(map(repr, state)) or '(none)'}: must have some of "
            f"{', '.join(NEEDED)} (the others are 0), or be a final_state; {fault}"
        )
    return dict.fromkeys(NEEDED, 0.0) | dict(state)


def state_by_coordinates(given: dict[str, Any]) -> None:
    """Converts the argument `state` of a study of an oscillator to that for a structure, if it is a mapping."""
    state = given.get("state")
    if isinstance(state, Mapping):
        if "start" in given:
            raise ParameterError(f"start = {given['start']!r}: must be left out; the state gives t")
        numbers = completed_state(state)
        given["start"] = numbers["t"]
        given["state"] = ([numbers["x"], numbers["z"]], [numbers["x_dot"], numbers["z_dot"]])


def checked_state(state: Any, clearance: float) -> dict[str, float]:
    """The numbers of a state given by the caller; of the first five, missing ones are 0."""
    if not isinstance(state, Mapping):
        raise ParameterTypeError(
            f"state = {state!r}: must be a mapping with some of t, x, x_dot, z, z_dot, or a final_state"
        )
    state = completed_state(state)
    given = {}
    for name in state:
        if name == "since":
            continue
        given[name] = checks.to_float(state[name], f"state[{name!r}]", RANGE)
        if not abs(given[name]) <= MOST:
            raise ParameterError(f"state[{name!r}] = {state[name]!r}: must be {RANGE}")
    y, half = given["z"] - given["x"], 0.5 * clearance
    if abs(y) > half * (1 + 1e-9):
        raise ParameterError(
            f"state['z'] - state['x'] = {given['z']!r} - {given['x']!r}: must be between the walls, "
            f"-{half:.6g} to {half:.6g}"
        )
    return given


def _resume(
    given: Mapping[str, float], state: Mapping[str, Any], system: System
) -> tuple[Moment, Moment] | None:
    """The moments of a `final_state`; None if its t does not agree with its other values."""
    r, clearance = system[3], system[5]
    ranges = {
        "cycle": (-(2.0**53), 2.0**53, True),
        "phase": (0.0, TWO_PI, False),
        "side": (-1, 1, True),
        "speed": (0.0, math.inf, False),
        "resting": (0, 1, True),
        "released": (0, 1, True),
    }
    for name, (low, high, closed) in ranges.items():
        value = given[name]
        whole = name in ("phase", "speed") or value == math.floor(value)
        if not (whole and (low <= value < high or (closed and value == high))):
            raise ParameterError(
                f"state[{name!r}] = {value!r}: must be as in a final_state, {low:g} to {high:g}"
            )
    belongs = _belongs(system, given)
    n = len(belongs)
    since: Any = state.get("since")
    known = isinstance(since, (tuple, list)) and len(since) == n + 10
    own = len(NEEDED + EXTRA)
    untouched = known and tuple(since[n - own : n]) == belongs[-own:]
    t = (TWO_PI * given["cycle"] + given["phase"]) / r
    if not untouched and abs(t - given["t"]) > 1e-12 * max(1.0, abs(t)):
        return None
    numbers = [given[name] for name in ("cycle", "phase", "x", "x_dot", "z", "z_dot", "speed")]
    labels = [int(given[name]) for name in ("side", "resting", "released")]
    y = given["z"] - given["x"]
    if labels[0] and abs(y - 0.5 * labels[0] * clearance) > 1e-9 * clearance:
        labels, numbers[6] = [0, 0, 0], 0.0  # the position of the wall has changed
    moment = (np.array(numbers), np.array(labels, dtype=np.int32))
    if known and tuple(since[:n]) == belongs:
        return moment, (np.array(since[n : n + 7]), np.array(since[n + 7 :], dtype=np.int32))
    return moment, moment


def coordinates_of(state: Any, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Coordinates and velocities of an initial state of a structure."""
    wanted = f"two lists of {n} finite numbers {SPAN}, coordinates and velocities"
    if state is None:
        return np.zeros(n), np.zeros(n)
    try:
        q, rate = state
    except (TypeError, ValueError):
        raise ParameterError(f"state = {state!r}: must be {wanted}") from None
    parts = []
    for values in (q, rate):
        array = np.array(checks.real_array(values, "state", wanted), dtype=np.float64)
        if array.shape != (n,) or not (np.abs(array) <= MOST).all():
            raise ParameterError(f"state = {state!r}: must be {wanted}")
        array.flags.writeable = False
        parts.append(array)
    return parts[0], parts[1]
