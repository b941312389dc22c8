r"""
A rig in physical units
=======================

A mass of 2.7 kg on a spring of 42 kN/m carries a particle of 0.11 kg, and is driven by 6 N. Every result keeps
the units of the rig, and its pictures show them. The clearance d is the whole travel from wall to wall.
"""

import numpy as np
import vibroimpact as vi

M, K = 2.7, 42e3
rig = vi.Oscillator.from_dimensional(
    M=M, K=K, C=2 * 0.0114 * np.sqrt(K * M), m=0.11, restitution=0.75, F0=6.0
)
units = rig.units()
r, clearance = units.frequency_ratio(f=19.5), units.clearance(d=0.0035)

# %%
# The stable motion at 19.5 Hz with 3.5 mm of travel. The spikes of the acceleration are the impacts.

motion = next(m for m in vi.find(rig, r, clearance, max_impacts=4, max_cycles=1) if m.stable)
motion.plot()

# %%
# Its displacement and acceleration in numbers, the energy that the load puts in during a cycle, and where it goes.

found = motion.physical().quantities()
print(f"x: rms {1e3 * found.x.rms:.3f} mm, peak {1e3 * found.x.peak:.3f} mm")
print(f"acceleration: rms {found.x_ddot.rms:.1f} m/s^2, peak {found.x_ddot.peak:.1f} m/s^2")
print(f"{1e3 * found.work:.2f} mJ = {1e3 * found.damping_loss:.2f} mJ in the dashpot")
print(f"       + {1e3 * found.impact_loss:.2f} mJ in the impacts")

# %%
# The zone in which two impacts per load cycle are stable, over the frequency and the clearance for 6 N.

zone = vi.zone(rig, "RL", r=(0.94, 1.1), clearance=(10, 100))
zone.plot()

# %%
# A stepped sine at this clearance, up and down.

diagram = vi.bifurcation_diagram(rig, "r", ("18.5 Hz", "21.5 Hz"), points=121, clearance=clearance)
diagram.plot()
