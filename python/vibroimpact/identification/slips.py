"""The sign of the slip of the free mass in a record that is not periodic, and the response to friction."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_Array = NDArray[np.float64]


class Slips:
    """The sign of the slip of the free mass in a record that is not periodic, as steps at impacts and reversals,
    and the response of the primary mass to a force of this sign, in units of its static displacement.

    The sign is 0 in flights without a known slip.
    """

    def __init__(
        self, times: _Array, changes: _Array, turns: _Array, omega: float, xi: float
    ) -> None:
        self.times, self.changes = times, changes
        #: Times of the reversals in flights.
        self.turns = turns
        self.omega, self.xi = omega, xi
        self.pole = omega * complex(-xi, math.sqrt(1 - xi**2))
        # from each step on: the response without its end, which is the sign
        of_step, now = complex(-1, xi / math.sqrt(1 - xi**2)), 0j
        waves = [now]
        gaps = np.diff(times, prepend=times[:1])
        for fade, change in zip(np.exp(self.pole * gaps).tolist(), changes.tolist(), strict=True):
            now = now * fade + change * of_step
            waves.append(now)
        self.waves = np.array(waves)
        self.begins = np.append(times[:1], times)
        self.signs = np.append(0.0, np.cumsum(changes))
        # the integral of the sign until each step, and the integral of this
        once = np.cumsum(self.signs[:-1] * gaps)
        twice = np.cumsum(np.append(0.0, once[:-1]) * gaps + 0.5 * self.signs[:-1] * gaps**2)
        self.once, self.twice = (np.append(0.0, x) for x in (once, twice))

    def _places(self, t: _Array) -> tuple[NDArray[np.int64], _Array]:
        """The last steps before given times, and the times since then."""
        step = np.searchsorted(self.times, t, side="right")
        return step, np.maximum(t - self.begins[step], 0.0)

    def at(self, t: _Array, order: int) -> _Array:
        """A derivative of the response."""
        if not self.times.size:
            return np.zeros(np.shape(t))
        step, since = self._places(t)
        wave = self.waves[step] * self.pole**order * np.exp(self.pole * since)
        found: _Array = wave.real + (self.signs[step] if order == 0 else 0.0)
        return found

    def sign(self, t: _Array) -> _Array:
        """The sign of the slip."""
        if not self.times.size:
            return np.zeros(np.shape(t))
        found: _Array = self.signs[self._places(t)[0]]
        return found

    def sums(self, t: _Array) -> tuple[_Array, _Array]:
        """The integral of the sign from the first step on, and the integral of this integral."""
        if not self.times.size:
            return np.zeros(np.shape(t)), np.zeros(np.shape(t))
        step, since = self._places(t)
        sign, once = self.signs[step], self.once[step]
        return once + sign * since, self.twice[step] + once * since + 0.5 * sign * since**2

    def between(self, t: _Array) -> tuple[_Array, _Array]:
        """For the flights between given times: the integral of the sign, and that of it times the time left over
        the duration."""
        once, twice = self.sums(t)
        T = np.diff(t)
        T = np.where(T == 0, 1.0, T)
        return np.diff(once), (np.diff(twice) - once[:-1] * T) / T
