"""
The zone of Figure 6a
=====================

Where two equally spaced impacts a cycle are stable and admissible: one closed curve, every piece of
which has the name of what happens there.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
zone = vi.zone(osc, vi.Pattern("RL"), r=(0.8, 1.2), clearance=(2, 200), symmetric=True)
for piece in zone.boundary:
    print(piece)

# %%
# 2e stands for two impacts, equally spaced.

zone.plot(inverse=True)
