"""Sampled records of a rig, with their rate, units and sensors."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import checks
from ..base.errors import ParameterError, ParameterTypeError
from ..systems.units import has_unit, own_number, positive, with_u

__all__ = ["SensorRecord"]

_Array = NDArray[np.float64]
#: A number for the motion sensors, or numbers by channel name.
PerChannel = float | Mapping[str, float] | None
#: The properties of the sensor of each channel that may be known.
OF_SENSORS = ("bandwidth", "delay", "range", "noise")
#: The unit of each channel in the package.
SI = {"load": "N", "acceleration": "m/s^2", "velocity": "m/s", "displacement": "m"}
#: Quantities that can represent the motion of the primary mass; for each, the power of i Omega that converts the
#: displacement to it.
MOTIONS = {"acceleration": 2, "velocity": 1, "displacement": 0}
_LENGTHS = {
    "m": 1.0, "cm": 0.01, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "mil": 2.54e-5, "ft": 0.3048,
}  # fmt: skip
#: The factor that converts each unit to that of the package.
UNITS: dict[str, dict[str, float]] = {
    "load": {
        "N": 1.0,
        "mN": 1e-3,
        "uN": 1e-6,
        "kN": 1e3,
        "MN": 1e6,
        "lbf": 4.4482216152605,
        "kgf": 9.80665,
    },
    "acceleration": {f"{name}/s^2": one for name, one in _LENGTHS.items()}
    | {"g": 9.80665, "mg": 9.80665e-3},
    "velocity": {f"{name}/s": one for name, one in _LENGTHS.items()},
    "displacement": _LENGTHS,
}
#: Other spellings of units, after those of powers.
SPELLED = {
    "ips": "in/s", "ips^2": "in/s^2", "m/s/s": "m/s^2", "mm/s/s": "mm/s^2", "ms^2": "m/s^2", "ms^-2": "m/s^2",
    "ms-2": "m/s^2", "ms^-1": "m/s", "ms-1": "m/s", "lbs": "lbf",
}  # fmt: skip
#: Order of the low-pass filter that models a sensor and its signal conditioner.
ORDER = 4
#: Least number of samples of a record.
LEAST = 16


def factor_of(channel: str, unit: str) -> float:
    """The factor that converts a unit to that of the package.

    Examples
    --------
    >>> from vibroimpact.identification.measured import factor_of
    >>> factor_of("acceleration", "g"), factor_of("displacement", "mm")
    (9.80665, 0.001)
    """
    known = UNITS[channel]
    found = unit_named(unit, known)
    if found is None:
        raise ParameterError(f"unit of {channel} = {unit!r}: must be one of {', '.join(known)}")
    return known[found]


def unit_named(unit: object, known: Iterable[str]) -> str | None:
    """The known unit that a text names, in any spelling; None if there is none.

    Case matters only where it distinguishes two of the units, such as mN and MN.

    Examples
    --------
    >>> from vibroimpact.identification.measured import UNITS, unit_named
    >>> unit_named("MM_S2", UNITS["acceleration"]), unit_named("KN", UNITS["load"]), unit_named("mV", ["mN"])
    ('mm/s^2', 'kN', None)
    """
    plain = with_u(str(unit)).strip().strip("[]()").replace("**", "^").replace(" ", "")
    plain = plain.replace("\N{SUPERSCRIPT TWO}", "^2").replace("_", "/")
    plain = re.sub(r"(?i)(?<=s)2$|(?<=ips)2$", "^2", plain)
    alike = [name for name in known if name.lower() == plain.lower()]
    if plain in alike:
        return plain
    if len(alike) == 1:
        return alike[0]
    other = SPELLED.get(plain.lower(), "")
    return other if other in [*known] else None


@dataclass(frozen=True, eq=False, repr=False)
class SensorRecord:
    """A record of sensors on a rig: the load, and the motion of the primary mass.

    Parameters
    ----------
    rate : float or str
        Sampling rate, samples per second; or with a unit, such as "10 kHz".
    load : array_like (n,), optional
        The load on the primary mass.
    acceleration, velocity, displacement : array_like (n,), optional
        The motion of the primary mass: one or several of these three quantities.
    units : mapping, optional
        Units of the channels by name, such as ``{"load": "lbf", "acceleration": "g"}``; N, m/s^2, m/s and m by
        default. The arrays are converted to these.
    bandwidth : float or mapping, optional
        -3 dB frequency (Hz) of a sensor, modelled as a Butterworth low-pass of order 4, by channel, such as
        ``{"load": 2000, "acceleration": 600}``. A single number, here and below, applies to the motion channels
        only. A channel that is not named is not filtered. Here and below, values may have units, such as
        "600 Hz", "2 ms" or "50 m/s^2".
    delay : float or mapping, optional
        Delay of a channel (s) in addition to that of its low-pass, for example due to a separate clock, by
        channel. A given delay is exact, including 0. Without one, `identify` allows for half a sampling interval
        between the channels (a converter that reads them in turn) if their bandwidth is stated, else for 2 ms.
    range : float or mapping, optional
        Largest magnitude that a channel can show, in its unit, by channel. `identify` rejects a record with a
        sample at or beyond it.
    noise : float or mapping, optional
        Root mean square of the noise of a channel, in its unit, by channel. In fits of periodic motions, the
        errors of samples are at least this large.
    start : float
        Time of the first sample, s.
    name : str
        The source of the record, for messages and pictures.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed, for example because samples are missing (NaN), lengths differ, or a unit is
        unknown.

    Examples
    --------
    >>> import numpy as np, vibroimpact as vi
    >>> t = np.arange(2000) / 1000
    >>> vi.SensorRecord(1000, load=np.sin(60 * t), acceleration=0.1 * np.cos(60 * t), units={"acceleration": "g"})
    <SensorRecord of 2000 samples at 1000 Hz, 2 s: load, acceleration>
    """

    rate: float
    load: _Array | None = None
    acceleration: _Array | None = None
    velocity: _Array | None = None
    displacement: _Array | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    bandwidth: Mapping[str, float] = field(default_factory=dict)
    delay: Mapping[str, float] = field(default_factory=dict)
    range: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    start: float = 0.0
    name: str = ""

    def __init__(
        self, rate: float, load: ArrayLike | None = None, acceleration: ArrayLike | None = None,
        velocity: ArrayLike | None = None, displacement: ArrayLike | None = None,
        units: Mapping[str, str] | None = None, bandwidth: PerChannel = None, delay: PerChannel = None,
        range: PerChannel = None,  # noqa: A002, the word of a sensor's data sheet
        noise: PerChannel = None, start: float = 0.0, name: str = "",
    ) -> None:  # fmt: skip
        object.__setattr__(self, "rate", positive(own_number(rate, "rate"), "rate", given=rate))
        given = {
            "load": load, "acceleration": acceleration, "velocity": velocity, "displacement": displacement,
        }  # fmt: skip
        units = {} if units is None else units
        if not isinstance(units, Mapping):
            raise ParameterTypeError(f"units = {units!r}: must be a unit for each of some channels")
        for channel in units:
            checks.choice(channel, "units: channel", tuple(given))
        sizes, factors = {}, {}
        for channel, values in given.items():
            array = None
            if values is not None:
                factors[channel] = factor_of(channel, units.get(channel, SI[channel]))
                array = samples_of(values, channel) * factors[channel]
                array.flags.writeable = False
                sizes[channel] = array.size
            object.__setattr__(self, channel, array)
        if not sizes:
            raise ParameterError(f"record without samples: must have one of {', '.join(given)}")
        if len(set(sizes.values())) > 1:
            shown = ", ".join(f"{channel} {n}" for channel, n in sizes.items())
            raise ParameterError(f"numbers of samples: {shown}: must be the same of all channels")
        object.__setattr__(self, "units", {name: SI[name] for name in sizes})
        for name_of, each in zip(OF_SENSORS, (bandwidth, delay, range, noise), strict=True):
            own = per_channel(each, name_of, sizes)
            if name_of in ("range", "noise"):
                physical = {
                    channel: has_unit(each[channel] if isinstance(each, Mapping) else each)
                    for channel in own
                }
                own = {
                    channel: value if physical[channel] else value * factors[channel]
                    for channel, value in own.items()
                }
            object.__setattr__(self, name_of, own)
        begin = own_number(start, "start")
        object.__setattr__(self, "start", checks.to_float(begin, "start", "a finite number"))
        object.__setattr__(self, "name", str(name))

    @property
    def channels(self) -> dict[str, _Array]:
        """The recorded channels by name, in SI units."""
        found = {name: getattr(self, name) for name in SI}
        return {name: values for name, values in found.items() if values is not None}

    def __len__(self) -> int:
        """Number of samples."""
        return next(iter(self.channels.values())).size

    @property
    def duration(self) -> float:
        """Number of samples over their rate, s."""
        return len(self) / self.rate

    @property
    def times(self) -> _Array:
        """Times of the samples, s."""
        return self.start + np.arange(len(self)) / self.rate

    def response(self, channel: str, frequency: ArrayLike) -> NDArray[np.complex128]:
        """The complex frequency response of a channel at given frequencies (Hz): low-pass and delay.

        Parameters
        ----------
        channel : str
            Name of the channel, such as "acceleration".
        frequency : array_like
            Frequencies, Hz.

        Returns
        -------
        ndarray of complex
            Ratio of measured to true value, in the shape of the frequencies.
        """
        late = np.exp(-2j * math.pi * self.delay.get(channel, 0.0) * np.asarray(frequency))
        response: NDArray[np.complex128] = (
            sensor_response(frequency, self.bandwidth.get(channel)) * late
        )
        return response

    def lowpass_lag(self, channel: str) -> float:
        """Delay of a channel due to its low-pass (s), far below its -3 dB frequency.

        Parameters
        ----------
        channel : str
            Name of the channel, such as "acceleration".

        Returns
        -------
        float
            The delay, s; 0 if the bandwidth is not known.
        """
        bandwidth = self.bandwidth.get(channel)
        return 0.0 if bandwidth is None else delay_of(bandwidth)

    def lag(self, channel: str) -> float:
        """Total delay of a channel (s), as far as its low-pass and its additional delay are known.

        Parameters
        ----------
        channel : str
            Name of the channel, such as "acceleration".

        Returns
        -------
        float
            The delay, s.
        """
        return self.delay.get(channel, 0.0) + self.lowpass_lag(channel)

    def __repr__(self) -> str:
        return (
            f"<SensorRecord of {len(self)} samples at {self.rate:g} Hz, {self.duration:g} s: "
            f"{', '.join(self._text_of(channel) for channel in self.channels)}>"
        )

    def _text_of(self, channel: str) -> str:
        """A channel with what is known of its sensor."""
        of_unit = dict(
            zip(OF_SENSORS, ("Hz", "s", self.units[channel], self.units[channel]), strict=True)
        )
        known = {name: getattr(self, name).get(channel) for name in OF_SENSORS}
        shown = [
            f"{name} {known[name]:g} {of_unit[name]}"
            for name in OF_SENSORS
            if known[name] is not None
        ]
        return f"{channel} ({', '.join(shown)})" if shown else channel


def per_channel(given: PerChannel, name: str, channels: Iterable[str]) -> dict[str, float]:
    """Values of a property of sensors by channel; a single number applies to the motion channels.

    Examples
    --------
    >>> from vibroimpact.identification.measured import per_channel
    >>> per_channel(600, "bandwidth", ["load", "acceleration"])
    {'acceleration': 600.0}
    """
    if given is None:
        return {}
    signed = name == "delay"
    if not isinstance(given, Mapping):
        given = {channel: given for channel in channels if channel != "load"}
        labels = dict.fromkeys(given, name)
    else:
        for channel in given:
            checks.choice(channel, f"{name}: channel", tuple(channels))
        labels = {channel: f"{name} of {channel}" for channel in given}
    found = {}
    for channel, value in given.items():
        unit = channel if name in ("range", "noise") else name
        value = own_number(value, unit, label=labels[channel])
        if signed:
            found[channel] = checks.to_float(value, labels[channel], "a finite number of seconds")
            if not math.isfinite(found[channel]):
                raise ParameterError(
                    f"{labels[channel]} = {value!r}: must be a finite number of seconds"
                )
        else:
            found[channel] = positive(value, labels[channel])
    return found


def samples_of(values: ArrayLike, name: str) -> _Array:
    """One checked channel; an error names the first missing sample."""
    array = checks.real_array(values, name, "a list of numbers")
    if array.ndim != 1 or array.size < LEAST:
        raise ParameterError(
            f"{name} of shape {array.shape}: must be one list of at least {LEAST} samples"
        )
    missing = ~np.isfinite(array)
    if missing.any():
        first, count = int(np.argmax(missing)), int(missing.sum())
        raise ParameterError(
            f"{name}[{first}] = {array[first]}: must be a finite number; {count} of {array.size} samples are "
            "missing"
        )
    return array


def sensor_response(frequency: ArrayLike, bandwidth: float | None) -> NDArray[np.complex128]:
    """Frequency response of a sensor at given frequencies (Hz), 1 at frequency 0.

    Examples
    --------
    >>> from vibroimpact.identification.measured import sensor_response
    >>> abs(sensor_response([0.0, 500.0], 500.0)).round(4)
    array([1.    , 0.7071])
    """
    s = 1j * np.asarray(frequency, dtype=np.float64)
    if bandwidth is None:
        return np.ones(s.shape, dtype=np.complex128)
    poles = bandwidth * butterworth_poles()
    response: NDArray[np.complex128] = np.prod(poles / (poles - s[..., None]), axis=-1)
    return response


def butterworth_poles() -> NDArray[np.complex128]:
    """The poles of the low-pass filter of a sensor for a -3 dB frequency of 1."""
    angles = math.pi * (2 * np.arange(ORDER) + ORDER + 1) / (2 * ORDER)
    poles: NDArray[np.complex128] = np.exp(1j * angles)
    return poles


def delay_of(bandwidth: float) -> float:
    """Delay of a sensor (s), far below its bandwidth."""
    return float(np.sum(1 / -butterworth_poles()).real / (2 * math.pi * bandwidth))
