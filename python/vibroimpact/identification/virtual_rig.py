"""Virtual rigs: simulated motions as the sensors of a rig would record them."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import checks
from ..base.checks import Rng
from ..base.errors import ParameterError, ParameterTypeError
from ..base.libraries import scipy
from ..motions.motion import Motion
from ..motions.trajectory import Trajectory, simulate_structure
from ..systems.oscillator import Oscillator
from ..systems.restitution import Law, Restitution
from ..systems.structure import LARGEST, Friction, Gap, Load, Structure
from ..systems.units import CYCLES, OTHERS, POWERS, dimensionless, own_number, positive
from .measured import LEAST, MOTIONS, SensorRecord, butterworth_poles, delay_of, sensor_response

__all__ = ["VirtualRig", "virtual_record"]

_Array = NDArray[np.float64]
#: Values of a rig that may be given with units.
OF_RIG = {*POWERS, *OTHERS, *CYCLES}
#: Number of time constants after which a response to an impact is neglected.
FADED = 16
#: Longest contact, load cycles.
MOST_CONTACT = 0.1
#: Default duration of a contact of a virtual rig, s, and its upper limit in load cycles.
CONTACT, CONTACT_CYCLES = 0.6e-3, 0.02
#: The reading of an accelerometer at rest, m/s^2.
GRAVITY = 9.80665


@dataclass(frozen=True, kw_only=True)
class VirtualRig:
    """A rig on a shaker, whose records are made from the simulated motion as sensors would record it.

    The primary mass M on spring K and dashpot C is driven by ``F0 sin(2 pi frequency t)`` with harmonics; the free
    mass m travels d between two walls. All values are in SI units, or in any consistent units whose unit of time
    is 1 s.

    Parameters
    ----------
    M, K, m : float
        Primary mass, stiffness, free mass, > 0.
    d : float
        Clearance, the whole travel of the free mass from wall to wall, > 0.
    xi : float
        Damping ratio C/(2 sqrt(K M)).
    restitution : float, PowerLaw or TabulatedRestitution, or two of them
        Coefficients of the right and of the left wall; speeds of laws are in m/s.
    F0, frequency : float
        Amplitude and frequency (Hz) of the load.
    harmonics : sequence of float
        Amplitudes of the 2nd, 3rd, … harmonic of the load, divided by F0.
    rate : float
        Sampling rate, Hz.
    snr : float or None
        Ratio of the rms values of signal and white noise in each channel, dB; None: no noise.
    bandwidth : float
        -3 dB frequency (Hz) of the sensors of load and motion, which are Butterworth low-passes of order 4.
    ring_frequency, ring_damping, ring_share : float
        A second mode that rings after each impact: frequency (Hz), damping ratio, and its velocity jump at the
        sensor relative to that of the primary mass. With a share of 0 there is no second mode.
    drift : float
        Relative decrease of the coefficients of restitution from the start to the end of a record.
    amplitude : float
        Largest relative deviation of the load amplitude from F0; the deviation is drawn once for each record.
    calibration : float
        Relative standard deviation of the gains of both sensors, drawn once for each record.
    contact : float, optional
        Duration of an impact, s: its force on the primary mass is a half sine that begins at the instant of the
        impact and whose area is the jump of momentum; 0 is an impulse. By default it is 0.6 ms, or a fiftieth of a
        load cycle if that is shorter.
    offset : float, optional
        Reading of the motion sensor at rest, in its unit; by default 9.80665 m/s^2 (gravity) for an accelerometer,
        and 0 otherwise.
    known_bandwidth : bool
        Whether records state the bandwidth of their sensors, and that these have no other delay. By default they
        do not, like most measured records, so that the delay between the channels is also unknown.
    friction : float or str
        Dry friction of the free mass in its slot, as a fraction of F0, or a force such as "0.3 N".

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> rig = vi.VirtualRig(M=2.7, K=42e3, m=0.11, d=0.006, xi=0.0114, restitution=0.7, F0=6.0, frequency=19.5)
    >>> rig.record(duration=2.0, rng=1)
    <SensorRecord of 20480 samples at 10240 Hz, 2 s: load, acceleration>
    """

    M: float
    K: float
    m: float
    d: float
    xi: float
    restitution: Restitution | tuple[Restitution, Restitution]
    F0: float
    frequency: float
    harmonics: tuple[float, ...] = ()
    rate: float = 10240.0
    snr: float | None = 40.0
    bandwidth: float = 2000.0
    ring_frequency: float = 430.0
    ring_damping: float = 0.02
    ring_share: float = 0.3
    drift: float = 0.0
    amplitude: float = 0.0
    calibration: float = 0.0
    contact: float | None = None
    offset: float | None = None
    known_bandwidth: bool = False
    friction: float = 0.0

    def __post_init__(self) -> None:
        if self.contact is None:
            frequency = positive(
                own_number(self.frequency, "frequency"), "frequency", given=self.frequency
            )
            object.__setattr__(self, "contact", min(CONTACT, CONTACT_CYCLES / frequency))
        above = ("M", "K", "m", "d", "F0", "frequency", "rate", "bandwidth", "ring_frequency")
        for name in (
            *above,
            "xi",
            "ring_damping",
            "ring_share",
            "drift",
            "amplitude",
            "calibration",
            "contact",
        ):
            given = getattr(self, name)
            value = own_number(given, name) if name in OF_RIG else given
            value = positive(value, name, zero=name not in above, given=given)
            if (
                name in ("xi", "drift", "amplitude", "calibration", "ring_damping")
                and not value < 1
            ):
                raise ParameterError(f"{name} = {value!r}: must be a number with 0 <= {name} < 1")
            object.__setattr__(self, name, value)
        for name in ("M", "K", "m"):
            if getattr(self, name) > LARGEST:
                raise ParameterError(
                    f"{name} = {getattr(self, name)!r}: must be a number with 0 < {name} <= {LARGEST:g}"
                )
        if self.C > LARGEST:
            raise ParameterError(
                f"xi = {self.xi!r}: must be smaller for this K and M, since the dashpot 2 xi sqrt(K M) = "
                f"{self.C!r} is limited to {LARGEST:g}"
            )
        for name in ("frequency", "ring_frequency", "bandwidth"):
            if not getattr(self, name) < self.rate / 2:
                raise ParameterError(
                    f"{name} = {getattr(self, name)!r}: must be below half the rate, {self.rate / 2:g} Hz"
                )
        assert self.contact is not None
        if not self.contact * self.frequency < MOST_CONTACT:
            raise ParameterError(
                f"contact = {self.contact!r}: must be below {MOST_CONTACT:g} load cycles, "
                f"{MOST_CONTACT / self.frequency:.4g} s"
            )
        if self.offset is not None:
            offset = self.offset
            for kind in MOTIONS:  # in the unit of the sensor of a record
                with contextlib.suppress(ParameterError):
                    offset = own_number(offset, kind, label="offset")
            offset = checks.to_float(offset, "offset", "a finite number or None")
            if not math.isfinite(offset):
                raise ParameterError(f"offset = {self.offset!r}: must be a finite number or None")
            object.__setattr__(self, "offset", offset)
        checks.instance(self.known_bandwidth, "known_bandwidth", bool)
        friction = dimensionless(self.oscillator, "friction", self.friction)
        number = positive(friction, "friction", zero=True, given=self.friction)
        object.__setattr__(self, "friction", number)
        harmonics = checks.real_array(self.harmonics, "harmonics", "a list of numbers")
        if harmonics.ndim != 1 or not np.isfinite(harmonics).all():
            raise ParameterError(
                f"harmonics = {self.harmonics!r}: must be a list of finite numbers"
            )
        object.__setattr__(self, "harmonics", tuple(harmonics.tolist()))
        if self.snr is not None and not math.isfinite(
            checks.to_float(self.snr, "snr", "a number or None")
        ):
            raise ParameterError(f"snr = {self.snr!r}: must be a finite number of dB, or None")
        self._structure(1.0)  # checks the restitution

    @property
    def oscillator(self) -> Oscillator:
        """The system, with its units."""
        walls = self.restitution
        right, left = walls if isinstance(walls, (tuple, list)) else (walls, walls)
        numbers = {"xi": self.xi, "mu": self.m / self.M, "M": self.M, "K": self.K, "F0": self.F0}
        return Oscillator(restitution=(right, left), **numbers)  # type: ignore[arg-type]

    @property
    def r(self) -> float:
        """Frequency ratio."""
        return 2 * math.pi * self.frequency / self.omega

    @property
    def clearance(self) -> float:
        """Clearance d K/F0, dimensionless."""
        return self.d * self.K / self.F0

    @property
    def omega(self) -> float:
        """Natural frequency sqrt(K/M), radians per second."""
        return math.sqrt(self.K / self.M)

    @property
    def C(self) -> float:
        """The dashpot."""
        return 2 * self.xi * math.sqrt(self.K * self.M)

    def _structure(self, factor: float) -> Structure:
        """The two masses as a structure, with restitution times a factor."""
        walls = self.restitution
        right, left = walls if isinstance(walls, (tuple, list)) else (walls, walls)
        gaps = [
            Gap(direction, self.d / 2, scaled(law, factor))
            for direction, law in (([-1, 1], right), ([1, -1], left))
        ]
        slides = [Friction([-1, 1], self.friction * self.F0)] if self.friction else []
        return Structure([self.M, self.m], [self.C, 0], [self.K, 0], gaps, slides)

    def _state(self, motion: Motion) -> tuple[float, tuple[_Array, _Array]]:
        """The time at which a motion has its first impact, and the state just after it."""
        checks.instance(motion, "motion", Motion)
        r, clearance = self.r, self.clearance
        if abs(motion.r / r - 1) > 1e-9 or abs(motion.clearance / clearance - 1) > 1e-9:
            raise ParameterError(
                f"motion at r = {motion.r!r}, d K/F0 = {motion.clearance!r}: must be a motion of this rig, "
                f"r = {r!r}, d K/F0 = {clearance!r}"
            )
        length = self.F0 / self.K
        q = np.array([motion.X[0], motion.Z[0]]) * length
        v = np.array([motion.X_dot_after[0], motion.Z_dot_after[0]]) * length * self.omega
        return motion.load_phase % (2 * math.pi) / (2 * math.pi * self.frequency), (q, v)

    def _runs(
        self, first: float, last: float, F0: float, settle: float, motion: Motion | None
    ) -> Iterator[Trajectory]:
        """The motion from one time to another after some load cycles; computed load cycle by load cycle if R
        drifts."""
        Omega = 2 * math.pi * self.frequency
        sine = np.outer(F0 * np.array([1.0, *self.harmonics]), [1.0, 0.0])
        load = Load(Omega, sine=sine)
        if motion is None:
            begin, state = 0.0, None
        else:
            begin, state = self._state(motion)
        run = simulate_structure(
            self._structure(1.0),
            load,
            duration=first + settle / self.frequency,
            start=begin,
            state=state,
        )
        now, state = run.end, run.final_state
        count = max(1, math.ceil((last - first) * self.frequency)) if self.drift else 1
        for i in range(count):
            system = self._structure(1 - self.drift * (i + 0.5) / count)
            run = simulate_structure(
                system, load, duration=(last - first) / count, state=state, start=now
            )
            if not run.complete:
                raise ParameterError(
                    f"d = {self.d!r}: must be larger; the record would have more than {len(run.events)} impacts"
                )
            now, state = run.end, run.final_state
            yield run

    def record(
        self, duration: float = 3.0, rng: Rng = 0, quantity: str = "acceleration", settle: float = 400,
        motion: Motion | None = None,
    ) -> SensorRecord:  # fmt: skip
        """A record of the load and of the motion of the primary mass.

        Parameters
        ----------
        duration : float or str
            Duration, s, or with a unit.
        rng : int, numpy.random.Generator or None
            Seed of the noise, the initial load phase and the load amplitude, or a generator from which a seed is
            drawn; None: another seed in each call.
        quantity : {"acceleration", "velocity", "displacement"}
            The quantity that the motion sensor measures.
        settle : float
            Load cycles before the record begins.
        motion : Motion, optional
            A motion of the rig from which the record begins; by default the simulation begins at rest.

        Returns
        -------
        SensorRecord
            The load and this quantity, with the noise and the filters of the sensors.
        """
        quantity = checks.choice(quantity, "quantity", tuple(MOTIONS))
        duration = positive(own_number(duration, "duration"), "duration", given=duration)
        settle = positive(settle, "settle", zero=True)
        n = round(duration * self.rate)
        if n < LEAST:
            raise ParameterError(
                f"duration = {duration!r}: must be at least {LEAST} samples, {LEAST / self.rate:g} s"
            )
        if not n <= checks.MOST_NUMBERS:
            raise ParameterError(
                f"duration = {duration!r}: must be at most {checks.MOST_NUMBERS / self.rate:g} s"
            )
        seed = checks.seed_of(rng, 2**63 - 1)
        random = np.random.default_rng(seed)
        F0 = self.F0 * (1 + self.amplitude * random.uniform(-1, 1))
        # the filters settle in the samples before the first one
        before = math.ceil(
            self.rate
            * 10
            * max(
                1 / self.bandwidth,
                1 / (2 * math.pi * self.ring_frequency * max(self.ring_damping, 0.01)),
            )
        )
        phase = random.uniform(0, 1) / self.frequency
        lead = before / self.rate
        moved, load = self._sensed(phase, lead + duration, before + n, F0, quantity, settle, motion)
        channels: dict[str, Any] = {}
        gains = 1 + self.calibration * np.random.default_rng([seed, 1]).standard_normal(2)
        for name, clean in (
            ("load", gains[0] * load[before:]),
            (quantity, gains[1] * moved[before:]),
        ):
            noise = 0.0
            if self.snr is not None:
                noise = math.sqrt(float(np.mean(clean**2))) * 10 ** (-self.snr / 20)
            channels[name] = clean + noise * random.standard_normal(n)
        offset = self.offset
        if offset is None:
            offset = GRAVITY if quantity == "acceleration" else 0.0
        channels[quantity] = channels[quantity] + offset
        bandwidth = dict.fromkeys(channels, self.bandwidth) if self.known_bandwidth else None
        delay = 0.0 if self.known_bandwidth else None
        return SensorRecord(
            self.rate, bandwidth=bandwidth, delay=delay, name="virtual rig", **channels
        )

    def _sensed(
        self,
        first: float,
        duration: float,
        n: int,
        F0: float,
        quantity: str,
        settle: float,
        of_motion: Motion | None,
    ) -> tuple[_Array, _Array]:
        """The outputs of both sensors without noise, at n samples."""
        runs = [*self._runs(first, first + duration, F0, settle, of_motion)]
        t = runs[0].start + np.arange(n) / self.rate
        ends = [run.end for run in runs[:-1]]
        place = np.searchsorted(ends, t, side="right")
        q, v, a = np.concatenate(
            [run._sampled(np.clip(t[place == i], run.start, run.end), 3)[:, 0] for i, run in enumerate(runs)],
            axis=1,
        )  # fmt: skip
        events = np.concatenate([run.events for run in runs])
        events = events[events["impulse"] > 0]
        jumps = np.where(events["gap"] == 0, 1.0, -1.0) * events["impulse"] / self.M
        Omega = 2 * math.pi * self.frequency
        force = sum(
            F0 * size * np.sin((j + 1) * Omega * t) for j, size in enumerate([1.0, *self.harmonics])
        )
        smooth = q
        if quantity == "velocity":
            # without the velocity jumps, which are part of the response to impacts
            smooth = (
                v
                - np.concatenate([[0.0], np.cumsum(jumps)])[
                    np.searchsorted(events["time"], t, side="right")
                ]
            )
        elif quantity == "acceleration":
            smooth = a
        motion = self._filtered(smooth) + self._impacts(t, events["time"], jumps, MOTIONS[quantity])
        return motion, self._filtered(np.asarray(force))

    def _filtered(self, values: _Array) -> _Array:
        """Samples through a sensor."""
        offset = np.linspace(values[0], values[-1], values.size)  # avoid a step where the ends meet
        frequency = np.fft.rfftfreq(values.size, 1 / self.rate)
        passed = np.fft.rfft(values - offset) * sensor_response(frequency, self.bandwidth)
        delay = delay_of(self.bandwidth)
        slope = (values[-1] - values[0]) / max(values.size - 1, 1) * self.rate
        output: _Array = np.fft.irfft(passed, values.size) + offset - delay * slope
        return output

    def _impacts(self, t: _Array, times: _Array, jumps: _Array, order: int) -> _Array:
        """The response of the sensor to jumps of velocity: spikes (or their integrals) and ringing."""
        signal = scipy("signal", "a virtual rig")
        w, zeta = 2 * math.pi * self.ring_frequency, self.ring_damping
        poles = 2 * math.pi * self.bandwidth * butterworth_poles()
        low = np.real(np.poly(poles))
        mode = np.array([1.0, 2 * zeta * w, w * w])
        # of the primary mass, unless it is in the smooth part, and of the second mode
        own = mode if order else np.zeros(1)
        top = low[-1] * np.polyadd(own, [self.ring_share, 0.0, 0.0])
        below = np.polymul(low, mode)
        integrations = 2 - order
        if integrations:
            zeros = 0
            while zeros < integrations and len(top) > 1 and top[-1] == 0:
                top, zeros = top[:-1], zeros + 1
            below = np.concatenate([below, np.zeros(integrations - zeros)])
        residues, found, _ = signal.residue(top, below)
        response = np.zeros(t.size)
        shape: Any
        for c, p in zip(residues, found, strict=True):
            if p.imag < 0:  # plus its complex conjugate
                continue
            fades = abs(p) > 1e-9
            length = math.ceil(FADED / -p.real * self.rate) if fades else t.size
            for time, jump in zip(times.tolist(), jumps.tolist(), strict=True):
                first = int(np.searchsorted(t, time))
                here = slice(first, min(t.size, first + length))
                since, shape = t[here] - time, 1.0
                if self.contact:
                    shape = after_half_sine(p if fades else 0j, since, self.contact)
                elif fades:
                    shape = np.exp(p * since)
                response[here] += jump * (1 + (p.imag > 0)) * np.real(c * shape)
        return response


def after_half_sine(pole: complex, t: _Array, duration: float) -> NDArray[np.complex128]:
    """The response to a half sine of unit area that begins at 0, where exp(pole t) is the response to a unit
    impulse."""
    turn = 1j * math.pi / duration
    acted = np.minimum(t, duration)
    found: NDArray[np.complex128] = np.zeros(t.shape, dtype=np.complex128)
    for rate, sign in ((turn, 1), (-turn, -1)):
        # the integral of exp(rate u + pole (t - u)) over the elapsed part of the pulse
        found += (
            sign * (np.exp(rate * acted + pole * (t - acted)) - np.exp(pole * t)) / (rate - pole)
        )
    return found * math.pi / (4j * duration)


def scaled(law: Restitution, factor: float) -> Restitution:
    """A law of restitution times a factor."""
    if factor == 1:
        return law
    return law._scaled(factor) if isinstance(law, Law) else float(law) * factor


def virtual_record(
    duration: float = 3.0, rng: Rng = 0, quantity: str = "acceleration", **rig: Any
) -> SensorRecord:
    """A record of a `VirtualRig` in one call.

    Parameters
    ----------
    duration : float
        Duration, s.
    rng : int, numpy.random.Generator or None
        Seed of the random numbers, as in `VirtualRig.record`.
    quantity : str
        As in `VirtualRig.record`.
    **rig
        The parameters of the `VirtualRig`.

    Returns
    -------
    SensorRecord
        The load and this quantity, as `VirtualRig.record` returns them.

    Raises
    ------
    ParameterError, ParameterTypeError
        If an argument is not allowed.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> vi.virtual_record(
    ...     duration=1.0, rng=3, M=2.7, K=42e3, m=0.11, d=0.006, xi=0.0114, restitution=0.7, F0=6.0,
    ...     frequency=19.5,
    ... )
    <SensorRecord of 10240 samples at 10240 Hz, 1 s: load, acceleration>
    """
    try:
        made = VirtualRig(**rig)
    except TypeError as error:
        if isinstance(error, ParameterTypeError):
            raise
        names = str(error).partition(") ")[2]
        raise ParameterTypeError(f"rig: must be the arguments of VirtualRig; {names}") from None
    return made.record(duration, rng, quantity)
