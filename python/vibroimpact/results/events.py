"""Events in order of time, and the closed-form motion between them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..base.errors import ParameterError
from ..systems.oscillator import Oscillator
from .tables import Result

KINDS = np.array(["", "impact", "stick", "release"])
#: Columns with numbers, in the order of the core.
NUMBERS = ("time", "phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after")
#: Columns of `Trajectory.events`.
EVENT_TYPE = np.dtype(
    [
        ("time", "f8"), ("kind", "U7"), ("side", "U1"), ("phase", "f8"), ("x", "f8"),
        ("x_dot_before", "f8"), ("x_dot_after", "f8"), ("z_dot_before", "f8"), ("z_dot_after", "f8"),
    ]
)  # fmt: skip
#: Side and kind in a record as four numbers, which the core copies without using them.
_NAMES = np.zeros((3, 2), dtype=EVENT_TYPE)
_NAMES["kind"], _NAMES["side"] = KINDS[1:, None], ("R", "L")
WORDS = np.asfortranarray(_NAMES.view(np.float64).reshape(3, 2, 11)[..., 1:5].T)


class Sample(NamedTuple):
    """Time history of a motion; each array has the shape of the requested times.

    Velocities jump at an impact; the accelerations do not include these impulses. The acceleration of the primary
    mass itself jumps by ``-2 xi (X_dot_after - X_dot_before)`` at an impact.

    Attributes
    ----------
    X, X_dot, X_ddot : ndarray
        Position, velocity and acceleration of the primary mass.
    Z, Z_dot, Z_ddot : ndarray
        The same of the free mass.
    Y : ndarray
        Position of the free mass relative to the primary mass, Z - X.
    load : ndarray
        The load, in F0.
    """

    X: NDArray[np.float64]
    X_dot: NDArray[np.float64]
    Z: NDArray[np.float64]
    Z_dot: NDArray[np.float64]
    Y: NDArray[np.float64]
    load: NDArray[np.float64]
    X_ddot: NDArray[np.float64]
    Z_ddot: NDArray[np.float64]


def event_table(numbers: NDArray[np.float64], labels: NDArray[np.int32]) -> NDArray[Any]:
    """The events of the core as a structured array, read-only."""
    events = np.empty(numbers.shape[1], dtype=EVENT_TYPE)
    events["kind"] = KINDS[labels[0]]
    events["side"] = np.where(labels[1] > 0, "R", "L")
    for name, column in zip(NUMBERS, numbers, strict=True):
        events[name] = column
    events.flags.writeable = False
    return events


def event_arrays(events: NDArray[Any]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The inverse of `event_table`."""
    numbers = np.array([events[name] for name in NUMBERS], order="F")
    kinds = 1 + (events["kind"] == KINDS[2]) + 2 * (events["kind"] == KINDS[3])
    sides = np.where(events["side"] == "R", 1, -1)
    return numbers, np.array([kinds, sides], dtype=np.int32, order="F")


def event_columns(events: NDArray[Any]) -> dict[str, Any]:
    """The columns of events as the core declares them."""
    return {name: events[name] for name in EVENT_TYPE.names or ()}


def events_of(result: Result, here: slice = slice(None)) -> NDArray[Any]:
    """The rows of the core's table `events` as a structured array."""
    kinds, walls, *numbers = (
        result.column("events", name).values[here] for name in ("kind", "side", *NUMBERS)
    )
    for name, codes in (("kind", kinds), ("side", walls)):
        if not codes.all():
            raise ParameterError(f"events.{name} = '': must be a word")
    times = numbers[0]
    if not (np.isfinite(times).all() and (np.diff(times) >= 0).all()):
        raise ParameterError("events.time: must be finite, and in ascending order")
    labels = np.array([kinds, np.where(walls == 1, 1, -1)], dtype=np.int32)
    return event_table(np.array(numbers), labels)


def segments(
    events: NDArray[Any], clearance: float
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The state (6, n) at the start of the segment after each event, and the side of a rest in that segment, or
    0."""
    side = np.where(events["side"] == "R", 1, -1)
    z = events["x"] + 0.5 * side * clearance
    starts = [
        events["time"],
        events["phase"],
        events["x"],
        events["x_dot_after"],
        z,
        events["z_dot_after"],
    ]
    return np.array(starts), np.where(events["kind"] == "stick", side, 0).astype(np.int32)


def sample(
    osc: Oscillator, r: float, load: float, clearance: float, starts: NDArray[np.float64],
    resting: NDArray[np.int32], times: NDArray[np.float64],
) -> Sample:  # fmt: skip
    """Positions, velocities, load and accelerations at times of any shape, within some segments."""
    values = _core.sample_trajectory(
        osc.xi, osc.mu, r, load, clearance, starts, resting, times.ravel()
    )
    places = np.searchsorted(starts[0], times, side="right") - 1
    return with_accelerations(osc, values.reshape((6, *times.shape)), resting[places] != 0)


def with_accelerations(
    osc: Oscillator, values: NDArray[np.float64], resting: NDArray[np.bool_] | bool = False
) -> Sample:
    """A sample with the accelerations added; during a rest both masses move together."""
    x, x_dot, _, _, _, load = values
    acceleration = (load - 2 * osc.xi * x_dot - x) / np.where(resting, 1 + osc.mu, 1.0)
    return Sample(*(*values, acceleration, np.where(resting, acceleration, 0.0)))
