"""What a record says: the harmonics of the acceleration, and the load."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..systems.oscillator import Pattern

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]


@dataclass
class Measured:
    """What one record says: the harmonics of the acceleration, and the load.

    Angles are Omega t with t = 0 in the middle of the record.
    """

    #: Load frequency, radians a second.
    Omega: float
    #: Load cycles in a period.
    k: int
    #: (N) Angles Omega t of the impacts from 0 to below 2 pi k, and their errors; changes of velocity.
    angles: _Array = field(default_factory=lambda: np.empty(0))
    angle_errors: _Array = field(default_factory=lambda: np.empty(0))
    jumps: _Array = field(default_factory=lambda: np.empty(0))
    #: (n) Orders (multiples of Omega/k), harmonics of the acceleration, and errors of their real and imaginary
    #: parts. Without a record of the motion there are none.
    orders: _Array = field(default_factory=lambda: np.empty(0))
    values: _Complex = field(default_factory=lambda: np.empty(0, dtype=np.complex128))
    errors: _Array = field(default_factory=lambda: np.empty(0))
    #: Load phase at t = 0 and its error (None: not known), and amplitude and its error (N).
    phase: float | None = None
    phase_error: float = 0.0
    F0: float | None = None
    F0_error: float = 0.0
    #: The load over F0 sin(Omega t + phase): its harmonics at the orders above.
    shape: _Complex = field(default_factory=lambda: np.empty(0, dtype=np.complex128))

    #: Walls of the impacts of a period, in the order of the angles.
    sides: str = ""

    @property
    def pattern(self) -> Pattern:
        """The pattern of the impacts."""
        return Pattern(self.sides, self.k)

    @property
    def frequencies(self) -> _Array:
        """Of the harmonics, radians a second."""
        return self.orders * self.Omega / self.k

    def up_to(self, most: int) -> Measured:
        """The same without the harmonics above one of the load."""
        if self.orders.size == 0 or self.orders[-1] <= most * self.k:
            return self
        low = self.orders <= most * self.k
        arrays = {
            name: getattr(self, name)[low] for name in ("orders", "values", "errors", "shape")
        }
        return replace(self, **arrays)

    def impulses(self, angles: _Array, jumps: _Array) -> tuple[_Complex, _Complex]:
        """The harmonics of impulses, each of 1 at its angle (n, N), and their sum with the given weights."""
        each = (
            self.Omega / (math.pi * self.k) * np.exp(-1j * np.outer(self.orders / self.k, angles))
        )
        return each, each @ jumps
