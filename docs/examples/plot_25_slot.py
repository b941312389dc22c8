"""
Friction in the slot, tape on a wall
====================================

The damper of Figure 8 has one wall of steel and one with tape. The theory of the paper takes both as rigid and
the slot as free of friction. This example compares it with two further models: dry friction between the free mass
and its slot, and tape as an elastic stop with a stiffness and a dashpot.
"""

import matplotlib.pyplot as plt
import numpy as np
import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))

# %%
# The dashpot of the tape is chosen such that an impact on it, with no other forces, has the coefficient of
# restitution R₂ = 0.61. With a stiffness of 20 K, contact lasts a fiftieth of a load cycle.

k = 20.0
effective = osc.mu / (1 + osc.mu)
ratio = -np.log(0.61) / np.hypot(np.pi, np.log(0.61))
tape = (k, 2 * ratio * np.sqrt(k * effective))
contact = np.pi / np.sqrt(k / effective * (1 - ratio**2))
print(f"contact time over period of the load: {contact * 1.05 / (2 * np.pi):.3f}")

# %%
# For each model, a simulation finds the motion with one impact on each wall in a load cycle, and its zone of
# stability is traced over the frequency ratio and half the clearance.

drive = vi.Load(1.05, sine=[1, 0])
models = {
    "rigid walls": osc.at(1.05, 20.0).structure,
    "friction 0.05 F₀": osc.at(1.05, 20.0, friction=0.05).structure,
    "tape of stiffness 20 K": osc.at(1.05, 20.0, stops=(None, tape)).structure,
}
fig, ax = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
for color, (name, structure) in zip(("#0072B2", "#D55E00", "#009E73"), models.items(), strict=True):
    motion = vi.exact(structure, drive, vi.simulate(structure, drive, cycles=400))
    zone = vi.zone(motion, ("frequency", (0.8, 1.3)), ("opening", (2.5, 40)), lines=5)
    print(name, zone)
    for loop in zone.loops:
        ax.plot(*loop.T, color, label=name)
        name = None
ax.set(
    xlabel=r"frequency ratio $r = \Omega/\omega$",
    ylabel=r"half the clearance, $dK/(2 F_0)$",
    yscale="log",
)
ax.set_yticks([3, 5, 10, 20, 40], ["3", "5", "10", "20", "40"])
ax.minorticks_off()
ax.legend()

# %%
# Tape moves the boundaries of the zone a little. A friction force of a twentieth of the load amplitude removes
# most of the zone away from resonance, where the primary mass moves less and friction carries the free mass along.
