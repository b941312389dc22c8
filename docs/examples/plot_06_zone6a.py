"""
The zone of Figure 6a
=====================

The zone in which two equally spaced impacts per cycle are stable and admissible. Its boundary is one closed
curve; each piece of it is named after the condition that ends the zone there.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
zone = vi.zone(osc, vi.Pattern("RL"), r=(0.8, 1.2), clearance=(2, 200), symmetric=True)
for piece in zone.boundary:
    print(piece)

# %%
# 2e stands for two impacts, equally spaced.

zone.plot(inverse=True)
