"""Stable periodic motions of a vibrating system in which a free mass collides with its walls."""

from . import errors
from .model import Oscillator, Pattern, Units
from .motion import Motion, Motions, Sample
from .solve import equispaced, linear_system, periodic, periodic_batch, status_text

__version__ = "0.1.0"

__all__ = [
    "Motion",
    "Motions",
    "Oscillator",
    "Pattern",
    "Sample",
    "Units",
    "equispaced",
    "errors",
    "linear_system",
    "periodic",
    "periodic_batch",
    "status_text",
]
