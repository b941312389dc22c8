"""
A branch with its special points
================================

A branch follows one motion as the clearance changes. It shows where the motion loses its stability (a
flip), and where it begins to pass through a wall (a grazing). A bound is an end of the range.
"""

import math

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motion = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
path = vi.branch(motion, "clearance", bounds=(10, 60))
for point in path.special_points:
    print(point)

# %%
# The largest displacement along the branch, relative to that without impacts:

path.plot()

# %%
# At the flip a motion of twice the period begins:

flip = next(point for point in path.special_points if point.type == "flip")
for other in flip.switch():
    print(repr(other))
