"""The rig of a bench test, and records of rigs, shared by tests of identification."""

import dataclasses
import math

import vibroimpact as vi

#: The rig of a bench test: 2.7 kg on 42 kN/m, a particle of 0.11 kg, 6 N at 19.5 Hz.
BENCH = {
    "M": 2.7, "K": 42e3, "m": 0.11, "d": 0.006, "xi": 0.01143, "restitution": (0.75, 0.65), "F0": 6.0,
    "frequency": 19.5,
}  # fmt: skip
KNOWN = {"M": 2.7, "K": 42e3, "m": 0.11}
#: Impacts of no duration, and fully known sensors: with little noise, small effects show.
IDEAL = {"contact": 0.0, "offset": 0.0, "known_bandwidth": True}


def of_no_duration(monkeypatch):
    """Take impacts as what they are in rigs whose pulses last although the impacts do not: errors then do not
    contain what the contacts of a real rig might change."""
    from vibroimpact.identification.flights import Flights
    from vibroimpact.identification.windows import Windows

    for owner in (Flights, Windows):
        monkeypatch.setattr(owner, "contact", lambda *_: 0.0)


def recorded(seed, generator, chaos, drift=0.0):
    """A rig of `wide_rig` with its record, k and the walls of a period; "virtual" is the package's own rig, whose
    coefficients of restitution may drift."""
    from reference_rig import wide_rig

    rig, made, k, sides = wide_rig(seed, generator, chaos)
    if generator == "virtual":
        return rig, virtual(rig, seed, drift), k, sides
    passed = rig.known_lowpass
    if rig.wall and (rig.filter != "butterworth 4" or seed % 2):
        passed = None  # which the record does not state
    bandwidth = None if passed is None else {"load": passed, "acceleration": passed}
    record = vi.SensorRecord(rig.rate, load=made[1], acceleration=made[2], bandwidth=bandwidth)
    return rig, record, k, sides


def virtual(rig, seed, drift=0.0):
    """A record of the package's own rig with the parameters of one of `reference_rig`, in the middle of the record
    if they drift."""
    from reference_rig import SPEED, K, M

    rig = dataclasses.replace(rig, restitution=tuple(R / (1 - drift / 2) for R in rig.restitution))
    walls = rig.restitution
    if rig.exponent:
        walls = [
            vi.PowerLaw(1.0, speed=SPEED * R ** (1 / rig.exponent), exponent=rig.exponent, sharpness=20)
            for R in rig.restitution
        ]  # fmt: skip
    made = vi.VirtualRig(
        M=M, K=K, m=M * rig.mu, d=rig.d, xi=rig.xi, restitution=tuple(walls), F0=rig.F0, frequency=rig.frequency,
        harmonics=rig.harmonics, rate=rig.rate, snr=-20 * math.log10(rig.noise), ring_frequency=rig.ringing,
        ring_damping=rig.ring_decay / (2 * math.pi * rig.ringing), ring_share=rig.ring_share,
        calibration=rig.calibration, bandwidth=rig.known_lowpass, contact=rig.contact,
        known_bandwidth=seed % 2 == 0, drift=drift,
    )  # fmt: skip
    # begun with a free mass that moves, as of a motion with equal walls
    alike = vi.Oscillator(xi=rig.xi, mu=rig.mu, restitution=sum(rig.restitution) / 2)
    begin = vi.equispaced(alike, made.r, made.clearance)
    return made.record(rig.duration, seed, motion=begin[0] if begin else None)
