"""
A small atlas
=============

An atlas collects the zones of a window. You need not give the patterns: the program enumerates them, and a
survey by simulation reports zones that are missing. Each point of the survey is counted by its outcome, and points
that no zone explains are marked in the picture. Where D > 2A the free mass can also stay at rest without
impacts; this region is hatched.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
atlas = vi.atlas(osc, (1.0, 1.1), (20, 60), max_impacts=3, survey=40)
print(atlas)
for zone in atlas.zones:
    print(zone)
for outcome, points in atlas.counts.items():
    print(points, outcome)
print("without impacts at r = 1.04, d K/F0 = 30:", bool(atlas.without_impacts.contains(1.04, 30.0)))
print("at r = 1.04, d K/F0 = 30:", [zone.pattern.sides for zone in atlas.at(1.04, 30.0)])

# %%

atlas.plot(inverse=True)
