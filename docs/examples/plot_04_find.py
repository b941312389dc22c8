"""
All periodic motions at a point
===============================

``find`` searches from many guesses for every pattern of impacts, from releases and from simulations,
and gives stable and unstable motions alike.
"""

import matplotlib.pyplot as plt
import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motions = vi.find(osc, 0.94, 37.0, max_impacts=4, max_cycles=1)
for motion in motions:
    print(repr(motion))
print(motions.search)

# %%
# The first four, the free mass as seen from the primary mass:

figure, axes = plt.subplots(2, 2, figsize=(7.2, 5.4), layout="constrained")
for motion, ax in zip(motions, axes.flat, strict=False):
    motion.plot(ax=ax, kind="portrait")
    name = "stable" if motion.stable else "unstable"
    ax.set_title(f"{motion.pattern.sides}, {name}", fontsize=9)
