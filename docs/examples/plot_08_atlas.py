"""
A small atlas
=============

All zones of a window, without being told which patterns are there: the patterns are enumerated, and a
survey by simulation tells which zones are missing. Every point of the survey is counted by what became of
it; those that no zone explains are marked in the picture. The motion without impacts has its place, too:
where D > 2A the free mass can rest untouched.
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
