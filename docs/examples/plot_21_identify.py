r"""
A rig identified from its record
================================

The record of a virtual rig: 2.7 kg on 42 kN/m, a particle of 0.11 kg with 6 mm of travel from
wall to wall, 6 N at 19.5 Hz. Noise is 40 dB below the signals, the sensors have 2 kHz of bandwidth, which the
record does not state, an impact lasts 0.6 ms, and a second mode rings at 430 Hz after it. M, K and
m are known; the record gives the rest.
"""

import vibroimpact as vi

known = {"M": 2.7, "K": 42e3, "m": 0.11}
rig = vi.VirtualRig(**known, d=0.006, xi=0.01143, restitution=(0.75, 0.65), F0=6, frequency=19.5)
found = vi.identify(rig.record(rng=17), known=known)
print(found)

# %%
# Every step, from top to bottom: the load and its fit; the record with the detected impacts; their load phases
# over the whole record, with those of the pattern; the exact motion that was fitted; and the residuals.

found.plot()

# %%
# The fitted motion over the record.

found.plot(kind="motion")

# %%
# A rig whose coefficients of restitution fall with the approach speed. Records at three loads determine the law:
# R1 and R2 at the speed v0, and one exponent.

walls = [vi.PowerLaw(R, speed=0.02, exponent=0.1, sharpness=20) for R in (1.0, 0.9)]
records = [
    vi.VirtualRig(**known, d=0.006, xi=0.01143, restitution=walls, F0=F0, frequency=19.5).record(
        rng=1
    )
    for F0 in (6.0, 6.4, 6.8)
]
law = vi.identify(records, known=known, law="power", calibration=0)
print(f"exponent {law.values['exponent']:.4f}, 95 % interval {law.interval('exponent')}")
print(law.restitution[0])
