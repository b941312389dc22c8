"""The rig of a bench test, and records of it, shared by tests of identification."""

#: The rig of a bench test: 2.7 kg on 42 kN/m, a particle of 0.11 kg, 6 N at 19.5 Hz.
BENCH = {
    "M": 2.7, "K": 42e3, "m": 0.11, "d": 0.006, "xi": 0.01143, "restitution": (0.75, 0.65), "F0": 6.0,
    "frequency": 19.5,
}  # fmt: skip
KNOWN = {"M": 2.7, "K": 42e3, "m": 0.11}
#: Impacts of no duration, and fully known sensors: with little noise, small effects show.
IDEAL = {"contact": 0.0, "offset": 0.0, "known_bandwidth": True}
