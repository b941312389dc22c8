r"""
Branches and zones of a structure
=================================

The second of two coupled masses carries a free mass in a slot. The motion with two impacts in a load cycle
is followed along the load frequency, and its zone of stability is found in the plane of frequency and load.
"""

import numpy as np
import vibroimpact as vi

springs = np.array([[2.0, -1, 0], [-1, 1, 0], [0, 0, 0]])
gaps = [vi.Gap([0, -1, 1], 6.0, 0.7), vi.Gap([0, 1, -1], 6.0, 0.7)]
structure = vi.Structure([1, 1, 0.1], 0.05 * springs, springs, gaps)
load = vi.Load(0.65, sine=[0, 0.5, 0])
motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
print(motion)

# %%
# The motion is its own mirror image half a period later; this symmetry breaks at a pitchfork. Neimark–Sacker
# points separate stable from unstable parts.

branch = vi.branch(motion, "frequency", bounds=(0.5, 0.8))
print(*branch.special_points, sep="\n")
branch.plot(y="q_max_1")

# %%
# At a load factor of 1 the boundary of the zone passes through these points. The zone consists of several parts of
# one sheet of motions.

zone = vi.zone(motion, x=("frequency", (0.5, 0.8)), y=("load", (0.5, 2.0)))
print(zone)
zone.plot(label="2")
