"""Records of sensors from files: CSV, WAV, MATLAB, netCDF, SEP005 and universal files (UFF)."""

from __future__ import annotations

import json
import math
import os
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base import checks, libraries
from ..base.errors import MissingExtraError, ParameterError, ParameterTypeError
from ..base.libraries import need, need_netcdf
from ..base.matlab import read_variables
from ..base.sizes import NUMBERS, check_file, check_size, unpacked
from ..systems.units import NAMED, own_number, positive
from .measured import (
    MOTIONS,
    OF_SENSORS,
    SI,
    SPELLED,
    UNITS,
    PerChannel,
    SensorRecord,
    unit_named,
)

_Array = NDArray[np.float64]
#: The names that a channel may have, in lower case; the first one is its name in the package.
NAMES = {
    "load": ("load", "force", "excitation", "f", "input"),
    "acceleration": ("acceleration", "accel", "acc", "a"),
    "velocity": ("velocity", "vel", "v"),
    "displacement": ("displacement", "disp", "position", "x"),
    "time": ("time", "t"),
}
#: Seconds in the units of time, by name.
SECONDS = {
    name: one
    for names, one in (
        (("s", "sec", "second", "seconds"), 1.0), (("ms", "msec", "millisecond", "milliseconds"), 1e-3),
        (("us", "microsecond", "microseconds"), 1e-6), (("ns", "nanosecond", "nanoseconds"), 1e-9),
        (("min", "minute", "minutes"), 60.0),
    )
    for name in names
}  # fmt: skip
RATES = ("rate", "fs", "sampling_rate", "sample_rate", "samplerate")
#: Units that the name of a channel may end with, in lower case; those that its quantity cannot have are rejected.
STRANGE = {
    name.lower()
    for name in [*SECONDS, *SPELLED, *NAMED, *(name for known in UNITS.values() for name in known)]
} | {
    "v", "mv", "uv", "kv", "volt", "volts", "a", "ma", "pc", "pa", "kpa", "mpa", "psi", "bar", "db", "dbv", "gal",
    "count", "counts", "lsb", "ips2", "kip", "ozf", "dyn", "j", "w", "c", "degc", "strain",
}  # fmt: skip
#: The quantity of a data set of a universal file, by its code of specific data.
UFF_CODES = {8: "displacement", 9: "load", 11: "velocity", 12: "acceleration", 13: "load"}
#: Largest relative difference of the time steps of regular samples, and of a rate from that of the times.
REGULAR = 1e-3
#: Largest shift of samples that count as simultaneous, in sampling steps.
SHIFT = 0.02


class Channel(NamedTuple):
    """A channel of a file: its name and unit as in the file, its samples, and their times (s) and rate (Hz) if the
    file gives them for this channel."""

    name: str
    unit: str
    values: _Array
    times: _Array | None = None
    rate: float | None = None


class Content(NamedTuple):
    """The contents of a file: channels, the common rate if there is one, and names of data that are not
    channels."""

    channels: list[Channel]
    rate: float | None = None
    bandwidth: float | None = None
    left: Sequence[str] = ()


class Clock(NamedTuple):
    """The sampling times of a channel: the time of the first sample (s) and the rate (Hz); None if unknown."""

    start: float | None
    rate: float | None


def read_record(
    path: str | os.PathLike[str] | Mapping[str, Any] | list[Mapping[str, Any]],
    rate: float | None = None,
    channels: str | Sequence[str] | None = None,
    units: str | Sequence[str] | None = None,
    bandwidth: PerChannel | Sequence[float] = None,
    scale: Sequence[float] | None = None,
    *,
    delay: PerChannel | Sequence[float] = None,
    range: PerChannel | Sequence[float] = None,  # noqa: A002, the word of a sensor's data sheet
    noise: PerChannel | Sequence[float] = None,
) -> SensorRecord:
    """Read a record of the load and the motion of a rig.

    Channels are recognised by their names (load or force, acceleration, velocity, displacement and common short
    forms), or by their units. A name may end with its unit: ``acc (g)``, ``acc_g``, ``time_ms``, ``shaker_N``. A
    warning names the channels that are not read, and endings that are not known units.

    Parameters
    ----------
    path : path, dict or list of dict
        A file: .csv or .txt (columns, with a header such as ``time (s), load (N), acceleration (g)``), .wav and
        .mat (extra `identify`), .nc (extra `data`), .json (SEP005), .uff, .unv, .uf (universal files, sets 58;
        extra `uff`). Or signals in memory in the form of SDyPy's SEP005: dicts with name, data, unit_str, and fs
        or time.
    rate : float, optional
        Sampling rate (Hz) of a file that has neither times nor a rate; a value that differs from the rate of the
        file is rejected.
    channels : str or sequence of str, optional
        The channels in order: load, acceleration, velocity, displacement, time, or none.
    units : str or sequence of str, optional
        The units of the channels, in the same order; by default those of the file, otherwise SI.
    bandwidth : float, mapping or sequence of float, optional
        As in `SensorRecord`: a number for the motion channels, values by channel, or one value for each channel of
        the file, in order (0: not known).
    scale : sequence of float, optional
        For each channel, the value in its unit that corresponds to the number 1, such as the full scale of a .wav
        file.
    delay, range, noise : float, mapping or sequence of float, optional
        As in `SensorRecord`, in the same forms as the bandwidth.

    Returns
    -------
    SensorRecord
        The channels in SI units, with the rate and the start time.

    Raises
    ------
    ParameterError, ParameterTypeError
        If there is no such file, its content does not match its format, samples are missing or irregular, a
        channel is not known, or channels have different rates or are not sampled at the same times.
    MissingExtraError
        If the library that reads the format is not installed.

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "bench.csv"
    >>> rows = "\\n".join(f"{i / 1000},{i % 7},{i % 5}" for i in range(100))
    >>> _ = path.write_text("time (s),force (lbf),acc (g)\\n" + rows)
    >>> vi.read_record(path)
    <SensorRecord of 100 samples at 1000 Hz, 0.1 s: load, acceleration>
    """
    sensors = dict(zip(OF_SENSORS, (bandwidth, delay, range, noise), strict=True))
    if isinstance(path, (Mapping, list)):
        return assembled(of_sep005(path), "", rate, channels, units, scale, sensors)
    place = checks.path(path)
    suffix = place.suffix.lower()
    shown = f"path = {str(path)!r}"
    if suffix not in READERS:
        raise ParameterError(f"{shown}: must end with one of {', '.join(READERS)}")
    if not place.is_file():
        raise ParameterError(f"{shown}: must be a file; there is none")
    try:
        check_file(place)
        content = READERS[suffix](place)
        return assembled(content, place.name, rate, channels, units, scale, sensors)
    except MissingExtraError:
        raise
    except (ParameterError, ParameterTypeError) as error:
        raise ParameterError(f"{shown}: {error}") from None
    except Exception as error:  # any exception that a library raises for a damaged file
        reason = str(error).strip().split("\n")[0] or type(error).__name__
        raise ParameterError(
            f"{shown}: must be a record in the format of {suffix}; {reason}"
        ) from None


def assembled(
    content: Content, name: str, rate: float | None, channels: str | Sequence[str] | None,
    units: str | Sequence[str] | None, scale: Sequence[float] | None, sensors: Mapping[str, Any],
) -> SensorRecord:  # fmt: skip
    """The record made of channels, with the known properties of their sensors."""
    found = content.channels
    labels = as_list(channels, "channels", len(found))
    given_units = as_list(units, "units", len(found))
    factors = (
        None if scale is None else checks.real_array(scale, "scale", "numbers, one per channel")
    )
    if factors is not None and factors.shape != (len(found),):
        raise ParameterError(
            f"scale = {scale!r}: must be {len(found)} numbers, one for each channel"
        )
    times: _Array | None = None
    arrays: dict[str, Channel] = {}
    places: dict[str, int] = {}
    of_units: dict[str, str] = {}
    left = [*content.left]
    for i, channel in enumerate(found):
        unit = given_units[i] if given_units else channel.unit
        if labels is None:
            label = label_of(channel.name, unit)
        else:
            label = checks.choice(labels[i], f"channels[{i}]", (*SI, "time", "none"))
        if label in (*SI, "time"):
            unit = unit or unit_in(channel.name, label)
        if label == "time":
            own = seconds(channel.values, unit)
            if times is not None and not np.array_equal(own, times):
                raise ParameterError(
                    f"channel {channel.name!r}: is a second time channel; must be the only one, or give `channels`"
                )
            times = own
        if label is None:
            left.append(channel.name)
        if label in (None, "none", "time"):
            continue
        if label in arrays:
            raise ParameterError(
                f"channel {channel.name!r}: is a second {label} channel; must be the only one, or give `channels`"
            )
        assert label is not None
        factor = 1.0 if factors is None else factors[i]
        places[label] = i
        arrays[label] = channel._replace(values=channel.values * factor)
        if unit:
            of_units[label] = unit
    if not arrays:
        names = ", ".join(repr(channel.name) for channel in found) or "none"
        raise ParameterError(
            f"channels {names}: one must be named {', '.join(SI)}; or give `channels`"
        )
    if left:
        warnings.warn(
            f"{name and name + ': '}not read: {', '.join(map(repr, left))}; neither the name nor the unit "
            "indicates a load or a motion: give `channels`, with 'none' for channels to be ignored",
            stacklevel=3,
        )
    rate = own_number(rate, "rate")
    clocks = [clock_of(channel, times, content.rate) for channel in arrays.values()]
    samples, start, own_rate = joined([*arrays.values()], clocks)
    if rate is None:
        rate = own_rate
    elif own_rate is not None and not abs(positive(rate, "rate") - own_rate) <= REGULAR * own_rate:
        raise ParameterError(
            f"rate = {rate!r}: must be left out, or equal the rate of the record, {own_rate:g} Hz"
        )
    else:
        rate = rate if own_rate is None else own_rate
    if rate is None:
        raise ParameterError(
            "rate: is missing; must be the sampling rate in Hz, since the record has neither times nor a rate"
        )
    known: dict[str, Any] = {
        key: of_channels(value, key, [channel.name for channel in found], places)
        for key, value in sensors.items()
    }
    if known["bandwidth"] is None:
        known["bandwidth"] = content.bandwidth
    record = SensorRecord(
        rate, units=of_units, start=start, name=name, **known,
        **dict[str, Any](zip(arrays, samples, strict=True)),
    )  # fmt: skip
    missing = [
        what
        for what, kinds in (("load", ("load",)), ("motion", tuple(MOTIONS)))
        if not arrays.keys() & {*kinds}
    ]
    if missing and left and channels is None:
        names = ", ".join(repr(channel.name) for channel in found)
        raise ParameterError(
            f"channels {names}: must contain a load and a motion, but no {' and no '.join(missing)} is recognised "
            "by a name such as 'load' or 'acceleration', or by a unit, as in 'shaker_N' or 'top (g)'; rename the "
            "columns, or give `channels` and `units` (`channel_units` in a namelist)"
        )
    return record


def of_channels(value: Any, name: str, channels: list[str], places: Mapping[str, int]) -> Any:
    """Known properties of sensors by channel, if they were given in the order of the channels of a file."""
    if value is None or isinstance(value, Mapping) or np.ndim(value) == 0:
        return value
    each = checks.real_array(value, name, "a number, or one for each channel")
    if each.shape == (1,):
        return float(each[0])
    if each.shape != (len(channels),):
        raise ParameterError(
            f"{name} = {value!r}: must be one number, or {len(channels)}, one per channel: "
            f"{', '.join(channels)}"
        )
    return {label: float(each[i]) for label, i in places.items() if each[i] != 0}


def clock_of(channel: Channel, times: _Array | None, rate: float | None) -> Clock:
    """The sampling times of a channel: from its own times, or from the times and the rate of the file."""
    times = times if channel.times is None else channel.times
    rate = rate if channel.rate is None else channel.rate
    if times is None:
        return Clock(None, rate)
    if times.size != channel.values.size:
        raise ParameterError(
            f"channel {channel.name!r} of {channel.values.size} samples: must have as many samples as "
            f"times, {times.size}"
        )
    own, start = rate_of(times)
    if rate is not None and not abs(rate - own) <= REGULAR * own:
        raise ParameterError(
            f"channel {channel.name!r}: its rate is {rate:g} Hz and that of its times {own:g} Hz; must be the same"
        )
    return Clock(start, own)


def joined(
    channels: list[Channel], clocks: list[Clock]
) -> tuple[list[_Array], float, float | None]:
    """The samples of the channels at their common times, the first of these times, and the rate.

    Raises
    ------
    ParameterError
        If rates differ, or samples are not simultaneous. Samples are not interpolated, since that would change
        spikes.
    """
    first, clock = channels[0], clocks[0]
    longest = max(channel.values.size for channel in channels)
    places = []
    for channel, other in zip(channels, clocks, strict=True):
        pair = f"channels {first.name!r} and {channel.name!r}"
        if (other.rate is None) != (clock.rate is None) or (other.start is None) != (
            clock.start is None
        ):
            raise ParameterError(f"{pair}: must both have times, both have a rate, or have neither")
        if clock.rate is None or other.rate is None:
            continue
        if not abs(other.rate / clock.rate - 1) * longest <= SHIFT:
            raise ParameterError(
                f"{pair}: rates are {clock.rate:.9g} and {other.rate:.9g} Hz; must be the same of all channels"
            )
        if clock.start is None or other.start is None:
            continue
        shift = (other.start - clock.start) * clock.rate
        if abs(shift - round(shift)) > SHIFT:
            raise ParameterError(
                f"{pair}: start at {clock.start:.9g} and {other.start:.9g} s, {abs(shift):.6g} samples apart; "
                "must be sampled at the same times"
            )
        places.append(round(shift))
    if not places:
        return [channel.values for channel in channels], 0.0, clock.rate
    begin = max(places)
    end = min(place + channel.values.size for place, channel in zip(places, channels, strict=True))
    if end <= begin:
        raise ParameterError(
            f"channels {', '.join(repr(channel.name) for channel in channels)}: must have times in common"
        )
    assert clock.start is not None
    assert clock.rate is not None
    return (
        [
            channel.values[begin - place : end - place]
            for place, channel in zip(places, channels, strict=True)
        ],
        clock.start + begin / clock.rate,
        clock.rate,
    )


def as_list(value: Any, name: str, count: int) -> list[str] | None:
    """A list with one word for each channel, or from one word for a single channel."""
    if value is None:
        return None
    words = [value] if isinstance(value, str) else list(value)
    if len(words) != count:
        raise ParameterError(f"{name} = {value!r}: must be {count} words, one for each channel")
    for word in words:
        if not isinstance(word, str):
            raise ParameterTypeError(f"{name} = {value!r}: must be words")
    return words


def label_of(name: str, unit: str) -> str | None:
    """The quantity of a channel, according to its name, or to its unit if only one quantity has this unit."""
    plain = re.split(r"[\s(\[_:,.-]", name.strip().lower())[0]
    for label, names in NAMES.items():
        if plain in names:
            return label
    # "in" is also an English word
    ends = [unit] if unit else [end for end in endings(name) if end != "in"]
    for end in ends:
        fitting = [label for label, known in UNITS.items() if unit_named(end, known)]
        if fitting:
            return fitting[0] if len(fitting) == 1 else None
    return None


def endings(name: str) -> list[str]:
    """The texts after the separators in the name of a channel, the longest first: a unit may contain one."""
    words = re.split(r"([\s_.:]+)", name.strip())
    return ["".join(words[i:]).strip("_.:") for i in np.arange(2, len(words), 2)]


def unit_in(name: str, label: str) -> str:
    """The unit with which the name of a channel ends, as in acc_g; "" if it ends with none.

    Raises
    ------
    ParameterError
        If the name ends with a unit of another quantity.
    """
    known = SECONDS if label == "time" else UNITS[label]
    ends = endings(name)
    for end in ends:
        found = unit_named(end, known)
        if found and not (end == "in" and label != "displacement"):
            return found
    last = ends[-1] if ends else ""
    if label == "time" and any(last.lower() in names for names in NAMES.values()):
        return ""  # of which channel it is
    if last.lower() in STRANGE:
        raise ParameterError(
            f"channel {name!r}: unit {last!r}: must be a unit of {label}, one of {', '.join(known)}; or give "
            "`units` (`channel_units` in a namelist) and, in Python, `scale` for the value of 1 V, for example"
        )
    if last and not re.fullmatch(r"[\d+-]*[xyzXYZ]?\d*", last):
        warnings.warn(
            f"channel {name!r}: {last!r} is not a known unit; the channel is read in {SI.get(label, 's')}. If "
            "this is not its unit, give `units` (`channel_units` in a namelist)",
            stacklevel=4,
        )
    return ""


def seconds(times: _Array, unit: str) -> _Array:
    """Times in seconds; a unit in netCDF may be followed by a date, as in "ms since 2026-01-01"."""
    plain = unit.strip().strip("[]()").split(" since ")[0].replace("\N{MICRO SIGN}", "u")
    if plain and plain.lower() not in SECONDS:
        raise ParameterError(f"unit of time = {unit!r}: must be one of {', '.join(SECONDS)}")
    return times * SECONDS[plain.lower() or "s"]


def rate_of(times: _Array) -> tuple[float, float]:
    """Sampling rate and first time of evenly spaced samples."""
    if times.ndim != 1 or times.size < 2:
        raise ParameterError(f"time of shape {times.shape}: must be one list of at least 2 numbers")
    if not np.isfinite(times).all():
        missing = int(np.argmax(~np.isfinite(times)))
        raise ParameterError(f"time[{missing}] = {times[missing]}: must be a finite number")
    steps = np.diff(times)
    step = float(np.median(steps))
    if not step > 0:
        raise ParameterError(f"time from {times[0]:g} to {times[-1]:g}: must increase")
    off = abs(steps - step) > max(REGULAR * step, 4 * np.spacing(abs(times).max()))
    # times in a text are rounded
    if (
        off.any()
        and np.max(
            abs(
                times - times[0] - np.arange(times.size) * (times[-1] - times[0]) / (times.size - 1)
            )
        )
        > 0.1 * step
    ):
        i = int(np.argmax(off))
        count = round(float(steps[i]) / step) - 1
        what = f"{count} samples are missing" if count > 0 else "samples are irregular"
        raise ParameterError(
            f"time[{i + 1}] = {times[i + 1]:.9g} after {times[i]:.9g}: must be {step:.6g} later; {what}"
        )
    return (times.size - 1) / float(times[-1] - times[0]), float(times[0])


def read_csv(path: Path) -> Content:
    """Columns of numbers, with or without a header; lines that begin with # are comments."""
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    lines = [
        line
        for line in text.splitlines()
        if line.strip() and not line.lstrip().startswith(("#", "!"))
    ]
    if not lines:
        raise ParameterError("no rows: must have samples")
    # the width follows from the last line, since names in a header may contain blanks
    separator = next((mark for mark in (";", "\t", ",") if mark in lines[-1]), None)
    one = separator is None and len(lines[-1].split()) == 1

    def cells(line: str) -> list[str]:
        """The cells of a row."""
        return [cell.strip().strip('"') for cell in ([line] if one else line.split(separator))]

    first = cells(lines[0])
    width = len(first)
    header = None if all(number(cell) is not None for cell in first) else first
    del lines[: header is not None]
    check_size(len(lines) * width, NUMBERS * 8, "its table")
    table = np.full((len(lines), width), math.nan)
    for i, row in enumerate(map(cells, lines)):
        if len(row) != width:
            raise ParameterError(f"row {i + 1} with {len(row)} values: must have {width}")
        for j, cell in enumerate(row):
            value = number(cell.replace(",", ".") if separator in (";", "\t") else cell)
            if value is None:
                raise ParameterError(f"row {i + 1}: {cell!r} must be a number")
            table[i, j] = value
    names = header or [f"column {j + 1}" for j in range(width)]
    found = [re.match(r"^(.*?)\s*[(\[](.*?)[)\]]\s*$", name) for name in names]
    parts = [
        (match[1], match[2]) if match else (name, "")
        for name, match in zip(names, found, strict=True)
    ]
    return Content(
        [Channel(name, unit, table[:, j].copy()) for j, (name, unit) in enumerate(parts)]
    )


def number(text: str) -> float | None:
    """The number in a cell, NaN in an empty one; None for other text."""
    if text == "":
        return math.nan
    if "_" in text or not text.isascii():  # only Python accepts underscores in numbers
        return None
    try:
        return float(text)
    except ValueError:
        return None


def read_wav(path: Path) -> Content:
    """Read a sound file; integers become fractions of their full scale."""
    rate, data = libraries.scipy("io.wavfile", "sound").read(path)
    values = np.atleast_2d(data.T).astype(np.float64)
    if data.dtype.kind == "u":
        values = (values - 128) / 128
    elif data.dtype.kind == "i":
        values = values / -float(np.iinfo(data.dtype).min)
    labels = (
        ("load", "acceleration")
        if len(values) == 2
        else tuple(f"channel {j + 1}" for j in range(len(values)))
    )
    return Content(
        [Channel(label, "", row) for label, row in zip(labels, values, strict=True)],
        rate=float(rate),
    )


def read_mat(path: Path) -> Content:
    """Read variables of a MATLAB file, or the fields of its only struct."""
    found = read_variables(path)
    if len(found) == 1:
        (only,) = found.values()
        found = only if isinstance(only, dict) else found
    return of_variables(found)


def of_variables(found: Mapping[str, Any]) -> Content:
    """Channels among variables by their names; `units` may be a struct of texts, `rate` a number."""
    rate, bandwidth = None, None
    channels, left = [], []
    for name, array in found.items():
        if not isinstance(array, np.ndarray):  # a text, or a struct
            continue
        if name.lower() in RATES and array.size == 1:
            rate = positive(float(array.ravel()[0]), name)
        elif name.lower() in ("dt", "step") and array.size == 1:
            rate = 1 / positive(float(array.ravel()[0]), name)
        elif name.lower() == "bandwidth" and array.size == 1:
            bandwidth = float(array.ravel()[0])
        elif array.dtype.kind in "iuf" and array.squeeze().ndim == 1 and array.size > 1:
            unit = str(found.get(f"{name}_unit", ""))
            channels.append(Channel(name, unit, array.squeeze().astype(np.float64)))
        elif array.dtype.kind in "iufc" and array.size > 1:
            left.append(name)
    return Content(channels, rate, bandwidth, left)


def read_netcdf(path: Path) -> Content:
    """Variables along one dimension, with the attribute `units`."""
    need_netcdf()
    h5py = need("h5py")
    if h5py.is_hdf5(path):  # the older format is not compressed
        with h5py.File(path, "r") as data:
            lists = [
                item for item in data.values() if isinstance(item, h5py.Dataset) and item.ndim == 1
            ]
            check_size(sum(map(unpacked, lists)), NUMBERS, "its lists of numbers together")
    with libraries.xarray("netCDF files").open_dataset(path, decode_times=False) as data:
        channels: list[tuple[Any, Channel]] = []
        times: dict[Any, _Array] = {}
        since = {}
        left = []
        for name, variable in data.variables.items():
            if variable.ndim != 1 or variable.dtype.kind not in "iuf":
                if variable.dtype.kind in "iufc" and variable.size > 1:
                    left.append(str(name))
                continue
            (dim,) = variable.dims
            values = np.asarray(variable.values, dtype=np.float64)
            unit = str(variable.attrs.get("units", variable.attrs.get("unit", "")))
            if label_of(str(name), "") == "time":
                times[dim] = seconds(values, unit or unit_in(str(name), "time"))
                since[unit.partition(" since ")[2]] = name
            else:
                channels.append((dim, Channel(str(name), unit, values)))
        if len(since) > 1:
            raise ParameterError(
                f"times {', '.join(map(repr, since.values()))}: must start at the same moment"
            )
        rates = [data.attrs[name] for name in RATES if name in data.attrs]
        return Content(
            [channel._replace(times=times.get(dim)) for dim, channel in channels],
            positive(rates[0], "rate") if rates else None,
            left=left,
        )


def read_json(path: Path) -> Content:
    """SEP005 signals as JSON."""
    return of_sep005(json.loads(path.read_text(encoding="utf-8")))


def of_sep005(signals: Any) -> Content:
    """Signals of SDyPy's SEP005: dicts with name, data, unit_str, and fs or time; several have one rate."""
    several = [signals] if isinstance(signals, Mapping) else list(signals)
    channels: list[Channel] = []
    begin: Any = None
    for i, signal in enumerate(several):
        if not isinstance(signal, Mapping) or not {"name", "data"} <= signal.keys():
            raise ParameterError(
                f"path: signal {i} must be a SEP005 dict with name, data, unit_str, and fs or time"
            )
        data = checks.real_array(signal["data"], f"data of signal {signal['name']!r}", "numbers")
        unit = str(signal.get("unit_str") or "")
        rate, times = None, None
        if signal.get("fs") is not None:
            rate = positive(signal["fs"], f"fs of signal {signal['name']!r}")
        if signal.get("time") is not None:
            times = checks.real_array(
                signal["time"], f"time of signal {signal['name']!r}", "numbers"
            )
        if signal.get("start_timestamp") is not None and (times is not None or rate is not None):
            moment = moment_of(signal["start_timestamp"], f"start_timestamp of {signal['name']!r}")
            begin = moment if begin is None else begin
            try:
                since = (moment - begin).total_seconds()
            except TypeError:
                raise ParameterError(
                    f"start_timestamp of {signal['name']!r} = {str(moment)!r}: must have a time zone if the "
                    "others have one, and none otherwise"
                ) from None
            if times is None:
                times = np.arange(data.shape[-1] if data.ndim else 0) / positive(rate, "fs")
            times = times + since
        names: Sequence[Any] = [signal["name"]]
        if data.ndim == 2:  # several channels in one signal
            listed = isinstance(signal["name"], (list, tuple))
            names = signal["name"] if listed else [signal["name"]] * len(data)
        rows = data if data.ndim == 2 else [data]
        if len(names) != len(rows):
            raise ParameterError(
                f"name = {signal['name']!r}: must be {len(rows)} names, one for each channel of data"
            )
        channels += [
            Channel(str(name), unit, row, times, rate)
            for name, row in zip(names, rows, strict=True)
        ]
    return Content(channels)


def moment_of(value: Any, label: str) -> datetime:
    """A date and time."""
    if isinstance(value, datetime):
        return value
    try:
        return datetime.fromisoformat(str(value))
    except ValueError:
        raise ParameterError(
            f"{label} = {value!r}: must be a date and time such as '2026-01-31T12:00:00'"
        ) from None


def read_uff(path: Path) -> Content:
    """The time histories (data sets 58) of a universal file."""
    try:
        import pyuff
    except ImportError:
        raise MissingExtraError(
            "universal files (UFF) need pyuff: pip install 'vibroimpact[uff]'"
        ) from None
    file = pyuff.UFF(str(path))
    sets = file.read_sets(np.flatnonzero(np.asarray(file.get_set_types()) == 58).tolist())
    channels, left = [], []
    for item in [sets] if isinstance(sets, dict) else sets:
        name = str(item.get("id1") or "").strip()
        if item.get("func_type", 1) not in (0, 1):
            left.append(name)
            continue
        label = UFF_CODES.get(int(item.get("ordinate_spec_data_type", 0)))
        unit = str(item.get("ordinate_axis_units_lab") or "").strip()
        unit = "" if unit.upper() == "NONE" else unit
        channels.append(
            Channel(
                label or name, unit, np.asarray(item["data"]).real.astype(np.float64),
                np.asarray(item["x"], dtype=np.float64),
            )
        )  # fmt: skip
    return Content(channels, left=left)


READERS: dict[str, Callable[[Path], Content]] = {
    ".csv": read_csv, ".txt": read_csv, ".wav": read_wav, ".mat": read_mat, ".nc": read_netcdf, ".json": read_json,
    ".uff": read_uff, ".unv": read_uff, ".uf": read_uff,
}  # fmt: skip
