"""
A small atlas
=============

All zones of a window, without being told which patterns are there: the patterns are enumerated, and a
survey by simulation tells which zones are missing.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
atlas = vi.atlas(osc, (1.0, 1.1), (20, 60), max_impacts=3, survey=40)
print(atlas)
for zone in atlas.zones:
    print(zone)
print("at r = 1.04, d K/F0 = 30:", [zone.pattern.sides for zone in atlas.at(1.04, 30.0)])

# %%

atlas.plot(inverse=True)
