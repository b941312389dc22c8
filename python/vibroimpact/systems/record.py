"""Sampled forces, and loads due to a motion of the base."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError
from .restitution import ByValue
from .structure import Load, Structure, _numbers, counted
from .units import Units, own_number

__all__ = ["Record", "base_motion", "base_record"]

_Array = NDArray[np.float64]
#: Largest number of numbers of a record.
MOST = 10**8


@dataclass(frozen=True, eq=False, repr=False)
class Record(ByValue):
    """A sampled force, from time 0: linear between samples, and 0 after the last one.

    Motions under a record are exact for the force that is linear between the samples. For samples of a sine, the
    error of the motion decreases with the square of `step`.

    Parameters
    ----------
    step : float
        Time between samples, > 0, or with a unit, such as "1 ms", which is converted to s.
    force : array_like (samples, n)
        At least two samples of the force at each coordinate; sample i is at time i * step. With
        `weights` (samples, columns).
    constant : array_like (n,), optional
        A constant force to add, such as gravity. It continues after the end of the record.
    weights : array_like (columns, n), optional
        The forces on the coordinates per unit of each column, for example for one signal that acts on many
        coordinates.

    Attributes
    ----------
    force : ndarray (samples, n)
        The force at each coordinate.
    samples : ndarray (samples, columns)
        The columns as given; without weights, the columns that are not all zero.
    weights : ndarray (columns, n)
        The forces on the coordinates per unit of each column.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    A half-sine shock of 1 time unit on the first of two coordinates:

    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> pulse = np.zeros((101, 2))
    >>> pulse[:, 0] = np.sin(np.pi * np.linspace(0, 1, 101))
    >>> vi.Record(0.01, pulse)
    <Record of 101 samples to t = 1 on 2 coordinates>
    """

    step: float
    force: _Array
    constant: _Array
    samples: _Array = field(compare=False)
    weights: _Array = field(compare=False)

    def __init__(
        self, step: float, force: ArrayLike, constant: ArrayLike | None = None,
        weights: ArrayLike | None = None,
    ) -> None:  # fmt: skip
        wanted = "a finite number > 0"
        step = checks.to_float(own_number(step, "step"), "step", wanted)
        if not 0 < step < np.inf:
            raise ParameterError(f"step = {step!r}: must be {wanted}")
        force = _numbers(force, "force", "samples (samples, n), at least two", (-1, -1))
        if len(force) < 2 or not force.size:
            raise ParameterError(
                f"force of shape {force.shape}: must be samples (samples, n), at least two"
            )
        if force.size > MOST:
            raise ParameterError(f"force of shape {force.shape}: must be at most {MOST} numbers")
        if weights is None:
            acting = np.flatnonzero(force.any(axis=0)) if force.any() else np.array([0])
            samples, matrix = force[:, acting], np.eye(force.shape[1])[acting]
        else:
            columns = force.shape[1]
            matrix = _numbers(weights, "weights", f"an array ({columns}, n)", (columns, -1))
            samples, force = force, np.zeros((len(force), matrix.shape[1]))
            # column by column, as the core does, so that the digits do not depend on a library
            for k, j in zip(*np.nonzero(matrix), strict=True):
                force[:, j] += matrix[k, j] * samples[:, k]
        for array in (samples, matrix, force):
            array.flags.writeable = False
        n = force.shape[1]
        if constant is None:
            constant = np.zeros(n)
        constant = _numbers(
            constant, "constant", "one force per coordinate, as many as force has", (n,)
        )
        object.__setattr__(self, "step", step)
        object.__setattr__(self, "samples", samples)
        object.__setattr__(self, "weights", matrix)
        object.__setattr__(self, "force", force)
        object.__setattr__(self, "constant", constant)

    def _in(self, units: Units) -> Record:
        """The force on a structure of an oscillator in physical units."""
        return Record(
            self.step * units.time, self.samples * units.F0, self.constant * units.F0, self.weights
        )

    @property
    def coordinates(self) -> int:
        """Number of coordinates."""
        return self.constant.size

    @property
    def duration(self) -> float:
        """Time of the last sample."""
        return self.step * (len(self.force) - 1)

    def _arrays(self) -> tuple[float, _Array, _Array]:
        """As for a load without harmonics."""
        return 0.0, np.zeros((self.coordinates, 2, 0)), self.constant

    def _groups(self) -> list[tuple[str, dict[str, Any]]]:
        """The group of a namelist that describes it."""
        keys: dict[str, Any] = {"record": self.samples.ravel().tolist(), "step": self.step}
        on = np.argmax(self.weights, axis=1)
        if len(set(on)) == len(on) and np.array_equal(self.weights, np.eye(self.coordinates)[on]):
            keys["acts_on"] = on.tolist()
        else:
            keys["weights"] = self.weights.ravel().tolist()
        return [("load", keys | {"constant": self.constant.tolist()})]

    def __repr__(self) -> str:
        places = counted(self.coordinates, "coordinate")
        return f"<Record of {len(self.force)} samples to t = {self.duration:g} on {places}>"


def _influence(structure: Structure, direction: Any) -> _Array:
    """The displacements of all coordinates when the base moves by 1 and nothing deforms."""
    checks.instance(structure, "structure", Structure)
    n = structure.coordinates
    if direction is None and structure._base is not None:
        return structure._base
    if direction is None and structure._is_modal:
        raise ParameterError(
            "direction = None: must be the participation factors of a structure by its modes, or `base` of "
            "Structure.from_modes must give them"
        )
    if direction is None:
        return np.ones(n)
    return _numbers(direction, "direction", f"{n} numbers, one per coordinate", (n,))


def base_motion(
    structure: Structure,
    frequency: float,
    sine: ArrayLike | None = None,
    cosine: ArrayLike | None = None,
    *,
    direction: ArrayLike | None = None,
    relative: bool = False,
) -> Load:
    """The load due to a periodic motion y(t) of the base.

    y is the sum of cosine_h cos(h Omega t) + sine_h sin(h Omega t). The springs and dashpots between structure and
    base are those that deform when all bodies are at rest and the base moves. In absolute coordinates they exert K
    d y + C d y', with d the `direction`. In coordinates relative to the base (``relative=True``) the load is -M d
    y''.

    Both give the same gaps if ``gap.direction`` has no component along a motion of all bodies with the base, as
    for a gap between two bodies. A stop that is fixed to the base needs relative coordinates.

    Parameters
    ----------
    structure : Structure
        The structure on the base.
    frequency : float
        Omega, > 0.
    sine, cosine : float or array_like (H,), optional
        Amplitudes of the harmonics 1 to H of y.
    direction : array_like (n,), optional
        Displacements of the coordinates when the base moves by 1 and nothing deforms; by default the `base` of
        the structure, or all 1. For a structure given by its modes, they are the participation factors.
    relative : bool
        Whether the coordinates are relative to the base.

    Returns
    -------
    Load
        The load on all coordinates.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> s = vi.Structure(mass=[2, 1], damping=[0, 0], stiffness=[[3, -1], [-1, 1]])
    >>> vi.base_motion(s, 1.5, sine=0.1).sine.tolist()
    [[0.2, 0.0]]
    >>> vi.base_motion(s, 1.5, sine=0.1, relative=True).sine.round(3).tolist()
    [[0.45, 0.225]]
    """
    d = _influence(structure, direction)
    checks.truth(relative, "relative")
    parts = {}
    for name, values in {"sine": sine, "cosine": cosine}.items():
        wanted = "amplitudes of y from -1e40 to 1e40, a number or (harmonics,)"
        given = np.atleast_1d(checks.real_array(0.0 if values is None else values, name, wanted))
        parts[name] = _numbers(given, name, wanted, (-1,))
        if (np.abs(parts[name]) > 1e40).any():
            raise ParameterError(f"{name} = {checks.shown(given.tolist())}: must be {wanted}")
    harmonics = max(map(len, parts.values()))
    s, c = (np.pad(part, (0, harmonics - len(part))) for part in (parts["sine"], parts["cosine"]))
    # checks the frequency
    omega = Load(frequency, sine=d).frequency * np.arange(1, harmonics + 1)
    if relative:
        inertia = structure.mass @ d
        return Load(
            frequency, sine=np.outer(omega**2 * s, inertia), cosine=np.outer(omega**2 * c, inertia)
        )
    spring, damper = structure.stiffness @ d, structure.damping @ d
    return Load(
        frequency,
        sine=np.outer(s, spring) - np.outer(omega * c, damper),
        cosine=np.outer(c, spring) + np.outer(omega * s, damper),
    )


def base_record(
    structure: Structure,
    step: float,
    acceleration: ArrayLike | None = None,
    *,
    displacement: ArrayLike | None = None,
    velocity: ArrayLike | None = None,
    direction: ArrayLike | None = None,
) -> Record:
    """The record of forces due to a sampled motion of the base, such as an earthquake or a shaking table.

    Given the acceleration y'', the force is -M d y'', for coordinates relative to the base. Given the displacement
    y and the velocity y', it is K d y + C d y', for absolute coordinates; see `base_motion`.

    Parameters
    ----------
    structure : Structure
        The structure on the base.
    step : float
        Time between samples, > 0.
    acceleration : array_like (samples,), optional
        Acceleration y'' of the base. Give either this, or `displacement` and `velocity`.
    displacement, velocity : array_like (samples,), optional
        Displacement y and velocity y' of the base.
    direction : array_like (n,), optional
        As in `base_motion`.

    Returns
    -------
    Record
        The forces on all coordinates, linear between the samples.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> s = vi.Structure(mass=[2, 1], damping=[0, 0], stiffness=[[3, -1], [-1, 1]])
    >>> vi.base_record(s, 0.02, acceleration=[1, 0.5]).force.tolist()
    [[-2.0, -1.0], [-1.0, -0.5]]
    """
    d = _influence(structure, direction)
    given = {"acceleration": acceleration, "displacement": displacement, "velocity": velocity}
    names = [name for name, values in given.items() if values is not None]
    if names not in (["acceleration"], ["displacement", "velocity"]):
        raise ParameterError(
            "acceleration, displacement, velocity: must be acceleration alone, or displacement and velocity; "
            f"given: {names}"
        )
    arrays = [_numbers(given[name], name, "samples (samples,)", (-1,)) for name in names]
    if len(arrays[0]) < 2:
        raise ParameterError(f"{names[0]} of {len(arrays[0])} samples: must have at least two")
    if len({len(array) for array in arrays}) != 1:
        raise ParameterError(
            f"displacement of {len(arrays[0])} and velocity of {len(arrays[1])} samples: must have the same number"
        )
    matrices = (
        [-structure.mass] if names == ["acceleration"] else [structure.stiffness, structure.damping]
    )
    weights = np.zeros((len(matrices), structure.coordinates))
    for k, matrix in enumerate(matrices):
        for factor, column in zip(d, matrix.T, strict=True):
            weights[k] += factor * column
    return Record(step, np.stack(arrays, axis=1), weights=weights)
