"""
All periodic motions at a point
===============================

``find`` searches for motions of every pattern, starting from many guesses, from releases off the walls and
from simulations. It returns both stable and unstable motions.
"""

import matplotlib.pyplot as plt
import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motions = vi.find(osc, 0.94, 37.0, max_impacts=4, max_cycles=1)
for motion in motions:
    print(repr(motion))
print(motions.search)

# %%
# Phase portraits of the first four: the motion of the free mass relative to the primary mass.

figure, axes = plt.subplots(2, 2, figsize=(7.2, 5.4), layout="constrained")
for motion, ax in zip(motions, axes.flat, strict=False):
    motion.plot(ax=ax, kind="portrait")
    name = "stable" if motion.stable else "unstable"
    ax.set_title(f"{motion.pattern.sides}, {name}", fontsize=9)
figure.suptitle("ξ = 0.005, μ = 0.042, R = 0.75, r = 0.94, dK/F0 = 37", fontsize=8)
