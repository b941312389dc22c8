"""The duration of contacts, from the pulses that impacts leave in a record.

The flights before and after an impact meet at the centroid of its force. What they do not describe about this
instant is the pulse: the difference between the force and an impulse, as the sensor sees it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .waves import Measured, Ringing

_Array = NDArray[np.float64]
_Complex = NDArray[np.complex128]
#: Frequencies at which pulses show the duration of contacts, over that of the load; standard deviation of a half
#: sine over its duration.
OF_PULSES, HALF_SINE = (10.0, 15.0, 20.0), math.sqrt(0.25 - 2 / math.pi**2)
#: Mean square duration of a contact times the square of an angular frequency above which its force counts as that
#: of a shorter one, and largest number of rounds for the duration.
FADED, MOST_ROUNDS = 8.0, 60
#: Gains of a filter at the pole of a mode between which the mode responds to the contacts: at a larger one it is
#: part of the transient of the filter, at a smaller one the record does not show its response; and the share of a
#: mode that must be left after a pulse.
BLOCKED, OWN_POLE, LEFT = 0.1, 2.0, 0.1
#: Standard errors, and share, by which a spectrum that rises with the frequency is no pulse of a short contact.
CLEARLY, RISEN = 3.0, 0.01
#: Seconds after an impact that are excluded at most.
LONGEST_PULSE = 12e-3


def pulse_frequencies(data: Measured) -> _Array:
    """The angular frequencies at which pulses show how long contacts last."""
    return np.array(OF_PULSES) * min(data.Omega, data.passed / OF_PULSES[-1])


def pulses_of(
    data: Measured, jumps: _Array, modes: Sequence[Ringing], impact: NDArray[np.int64], off: _Array,
    left: _Array, width: _Array, noise: _Array | float,
) -> tuple[_Complex, _Array, list[Ringing]]:  # fmt: skip
    """The spectra of the forces of contacts, whose jumps of the velocity are given (N, frequencies), at
    frequency 0 and at those of `pulse_frequencies`, their errors, and the modes that respond to the contacts.

    They are those of the residuals of flights about the impacts. The arguments give, for each sample (n), the
    number of its impact, the time since then, the residual, the interval that it stands for, and its noise.
    Ringing begins abruptly in the flights, so that its samples do not show its spectrum; it is replaced by the
    exact spectrum. A mode that does not respond to the contacts, such as the transient of a filter, is part of the
    pulse.
    """
    s = 1j * np.append(0.0, pulse_frequencies(data))
    end = np.zeros(jumps.size)
    np.maximum.at(end, impact, off + 0.5 * width)
    least = math.log(LEFT) / float(np.median(end[end > 0])) if end.any() else -math.inf
    own = [
        mode for mode in modes
        if BLOCKED < abs(filtered(data, mode.pole)) < OWN_POLE and mode.pole.real > least
    ]  # fmt: skip
    later = np.zeros((jumps.size, s.size), dtype=np.complex128)
    for mode in modes:
        left = left + np.where(off > 0, (mode.size[impact] * np.exp(mode.pole * off)).real, 0.0)
        for size, pole in both(mode):
            # the flights have this wave from the impact on; the pulse has all of it, or what follows the samples
            rest = np.expm1 if mode in own else np.exp
            later += size[:, None] * rest(np.outer(end, pole - s)) / (s - pole)
    waves = np.exp(-np.outer(s, off)) * (left * width)
    real, imaginary = (
        np.stack([np.bincount(impact, wave, jumps.size) for wave in part], axis=-1)
        for part in (waves.real, waves.imag)
    )
    spread = np.sqrt(np.bincount(impact, (noise * width) ** 2, jumps.size))
    spectra = of_forces(data, real + 1j * imaginary + later, jumps[:, None])
    return spectra, np.outer(spread, abs(s) ** (2 - data.order)), own


def both(mode: Ringing) -> Iterator[tuple[_Complex, complex]]:
    """Sizes and poles of the two waves of which a mode is the sum."""
    return zip(
        (0.5 * mode.size, 0.5 * mode.size.conj()), (mode.pole, mode.pole.conjugate()), strict=True
    )


def of_forces(data: Measured, spectra: Any, jumps: Any) -> _Complex:
    """The spectra of the forces of contacts, whose integrals are jumps of the velocity, from those of the
    residuals of flights about them (..., frequencies), at frequency 0 and at those of `pulse_frequencies`."""
    w = np.append(0.0, pulse_frequencies(data))
    forces: _Complex = spectra * (1j * w) ** (2 - data.order) + jumps * (data.order < 2)
    return forces


def filtered(data: Measured, s: Any) -> Any:
    """Gain of the low-pass of the sensor at complex frequencies, if it is known, and 1 otherwise."""
    return np.prod(data.lowpass / (data.lowpass - np.asarray(s)[..., None]), axis=-1)


def expected(data: Measured, whole: _Array, modes: Sequence[Ringing], square: float) -> _Complex:
    """The spectra of contacts of given mean square duration, as by `pulses_of`, from their values at frequency 0.

    If the low-pass of the sensor is known, it filters them. A mode that responds begins to ring during the
    contact, through the same filter, but in the flights at one instant; the difference is part of the pulse.
    """

    def passed(s: Any) -> Any:
        late = -float(np.sum(1 / data.lowpass).real)
        own = np.minimum(square, FADED / np.maximum(abs(s) ** 2, 1e-300))
        return filtered(data, s) * np.exp(0.5 * own * s**2 + late * s)

    s = 1j * np.append(0.0, pulse_frequencies(data))
    rung = np.zeros((whole.size, s.size), dtype=np.complex128)
    for mode in modes:
        for size, pole in both(mode):
            seen = passed(s) / passed(pole)
            rung += np.outer(size, s ** (2 - data.order) * (seen - 1) / (s - pole))
    found: _Complex = np.outer(whole - rung[:, 0].real, passed(s)) + rung
    return found


def duration(
    data: Measured, forces: _Complex, errors: _Array, jumps: _Array, modes: Sequence[Ringing] = ()
) -> float:
    """The duration of contacts (s), plus one standard error, from the spectra of their forces by `pulses_of`.

    A pulse with a standard deviation s in time has the spectrum 1 - (w s)^2/2 at low frequencies, whatever its
    shape. Only the magnitude of the spectrum of each impact is compared, since the errors of the times of impacts
    would make the mean of several pulses longer. A sensor whose gain is constant at these frequencies does not
    change the result.
    """
    sizes, weights = abs(forces), abs(jumps)
    # noise across a spectrum makes it larger; at frequency 0 there is none
    across = 0.5 * errors**2
    across[:, 0] = 0.0
    sizes = np.sqrt(np.maximum(sizes**2 - across, 0.0))
    whole = max(float(weights @ sizes[:, 0]), 1e-300)
    ratio = weights @ sizes[:, 1:] / whole
    unlike = abs(sizes[:, 1:] - np.outer(sizes[:, 0], ratio)) * math.sqrt(
        jumps.size / max(1, jumps.size - 1)
    )
    off = np.sqrt(weights**2 @ np.maximum(unlike, errors[:, 1:]) ** 2) / whole
    least = np.clip(ratio - off, 0.1, None)
    squares = np.zeros(least.size)
    for i, w in enumerate(pulse_frequencies(data).tolist()):
        seen = weights @ abs(expected(data, forces[:, 0].real, modes, 0.0))
        # modes that a filter hides raise the spectrum; contacts may then lower it by as much
        rise = (ratio - CLEARLY * off)[i] * seen[0] / max(seen[i + 1], 1e-300)
        hidden = 2 * math.log(rise) / w**2 if rise > 1 + RISEN else 0.0
        for _ in range(MOST_ROUNDS):
            seen = weights @ abs(expected(data, forces[:, 0].real, modes, squares[i]))
            more = 2 * math.log(max(seen[i + 1] / max(seen[0], 1e-300), 1e-300) / least[i]) / w**2
            new = min(max(squares[i] + 0.5 * more, 0.0), (LONGEST_PULSE * HALF_SINE) ** 2)
            done, squares[i] = abs(new - squares[i]) < 1e-3 * new, new
            if done:
                break
        squares[i] = max(squares[i], hidden)
    return math.sqrt(float(squares.max())) / HALF_SINE
