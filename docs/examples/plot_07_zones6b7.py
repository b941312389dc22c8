"""
Zones of Figures 6b and 7
=========================

This picture shows the zones of unequally spaced pairs of impacts, and of three and four impacts a cycle.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
window = {"r": (0.8, 1.2), "clearance": (2, 100)}
zones = []
for sides, symmetric in (("RL", False), ("RRL", None), ("RRLL", None)):
    zone = vi.zone(osc, vi.Pattern(sides), **window, symmetric=symmetric)
    print(zone)
    zones.append(zone)

# %%
# 2u stands for two impacts, unequally spaced. Flips, folds, pitchforks and Neimark–Sacker curves bound
# the zones:

ax = None
for zone in zones:
    ax = zone.plot(ax, inverse=True)
