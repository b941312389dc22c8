"""Sampled signals of tests on a rig: shocks and swept sines, as forces or as motions of a base."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.errors import ParameterError
from .units import own_number, positive

__all__ = ["half_sine", "swept_sine"]

_Array = NDArray[np.float64]
#: Largest number of samples.
MOST = 10**8


def half_sine(amplitude: float, duration: float, step: float, end: float | None = None) -> _Array:
    """The samples of a half-sine shock from time 0, for `Record` or `base_record`.

    Values with units, such as "50 m/s^2" and "11 ms", are converted to SI.

    Parameters
    ----------
    amplitude : float
        Peak value: a force, or an acceleration of the base; not 0.
    duration : float
        Duration of the pulse, at least two steps.
    step : float
        Time between samples.
    end : float, optional
        Time of the last sample, at least the duration; the signal is 0 after the pulse. By default the duration.

    Returns
    -------
    ndarray (samples,)
        Values at the times 0, step, 2 step and so on.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    A shock of 50 m/s^2 in 11 ms under a rig of 2.7 kg on 42 kN/m, with a particle of 0.11 kg and 4 mm of travel:

    >>> import vibroimpact as vi
    >>> rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, C=7.7, m=0.11, restitution=0.75)
    >>> structure = rig.structure(d=0.004)
    >>> shock = vi.half_sine(50.0, duration=0.011, step=1e-4, end=0.5)
    >>> run = vi.simulate(structure, vi.base_record(structure, 1e-4, acceleration=shock))
    >>> run
    <Trajectory t = 0 to 0.5 s: 20 impacts>
    """
    amplitude = _amplitude(amplitude)
    duration, step = _time(duration, "duration"), _time(step, "step")
    last = duration if end is None else _time(end, "end")
    if not 2 * step <= duration <= last * (1 + 1e-12):
        raise ParameterError(
            f"duration = {duration!r}: must be at least two steps of {step!r}, and at most the end, {last!r}"
        )
    t = _times(last, step)
    pulse = np.sin(np.pi * t / duration)
    return np.asarray(np.where(t < duration * (1 - 1e-12), amplitude * pulse, 0.0))


def swept_sine(
    amplitude: float,
    f: tuple[float, float],
    duration: float,
    step: float,
    spacing: str = "geometric",
) -> _Array:
    """The samples of a swept sine, for `Record` or `base_record`.

    Values with units, such as "6 N", ("15 Hz", "25 Hz") and "20 s", are converted to SI.

    The phase is the integral of the frequency, from 0. For a stepped sine, which stays at each frequency until the
    response has settled, `bifurcation_diagram` along r sweeps up and down.

    Parameters
    ----------
    amplitude : float
        A force, or an acceleration of the base; not 0.
    f : (float, float)
        Frequencies at the start and the end, cycles per unit of time (Hz), > 0; for a downward sweep, the first is
        the greater one.
    duration : float
        Time of the last sample.
    step : float
        Time between samples, at most an eighth of the shortest period. The force is linear between them.
    spacing : {"geometric", "linear"}
        A constant number of octaves, or of Hz, per unit of time.

    Returns
    -------
    ndarray (samples,)
        Values at the times 0, step, 2 step and so on.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    6 N from 15 to 25 Hz in 20 s on a rig of 2.7 kg on 42 kN/m, with a particle of 0.11 kg and 4 mm of travel:

    >>> import numpy as np, vibroimpact as vi
    >>> rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, C=7.7, m=0.11, restitution=0.75)
    >>> force = vi.swept_sine(6.0, (15.0, 25.0), duration=20.0, step=1e-3)
    >>> run = vi.simulate(rig.structure(d=0.004), vi.Record(1e-3, np.outer(force, [1, 0])))
    >>> bool(run.quantities().q.peak[0] < 0.004)
    True
    """
    amplitude = _amplitude(amplitude)
    wanted = "two finite numbers > 0"
    ends = checks.real_array(own_number(f, "f"), "f", wanted)
    if ends.shape != (2,) or not ((ends > 0) & np.isfinite(ends)).all():
        raise ParameterError(f"f = {f!r}: must be {wanted}")
    duration, step = _time(duration, "duration"), _time(step, "step")
    checks.choice(spacing, "spacing", ("geometric", "linear"))
    low, high = ends.tolist()
    most = 1 / (8 * max(low, high))
    if step > most * (1 + 1e-12):
        raise ParameterError(
            f"step = {step!r}: must be at most an eighth of the shortest period, {most:.6g}"
        )
    t = _times(duration, step)
    if spacing == "linear" or low == high:
        turns = low * t + 0.5 * (high - low) / duration * t**2
    else:
        rate = math.log(high / low) / duration
        turns = low * np.expm1(rate * t) / rate
    return np.asarray(amplitude * np.sin(2 * np.pi * turns))


def _time(value: Any, name: str) -> float:
    """A positive time; with a unit, in seconds."""
    return positive(own_number(value, "duration", label=name), name, given=value)


def _amplitude(value: Any) -> float:
    """A number that is not 0; a force or an acceleration with a unit, in SI."""
    given = value
    for kind in ("F0", "acceleration"):
        with contextlib.suppress(ParameterError):
            value = own_number(value, kind, label="amplitude")
    if isinstance(value, str):
        raise ParameterError(f"amplitude = {given!r}: must be a force or an acceleration")
    amplitude = checks.to_float(value, "amplitude", "a finite number other than 0")
    if not 0 < abs(amplitude) < math.inf:
        raise ParameterError(f"amplitude = {value!r}: must be a finite number other than 0")
    return amplitude


def _times(last: float, step: float) -> _Array:
    """The times of the samples."""
    number = round(last / step) + 1
    if not 2 <= number <= MOST:
        raise ParameterError(f"step = {step!r}: must give 2 to {MOST} samples in {last!r}")
    return np.asarray(step * np.arange(number))
