r"""
A zone, proven
==============

Where symmetric motions with one impact on each wall are stable and admissible, proven in ball arithmetic: each
point of the blue parts has such a motion, no point of the light ones has, and of the black ones neither is proven.
Boxes fill the plane of r and the load phase of the impact, so that no motion is left out. A program that does not
use this package checks the certificate.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
zone = vi.zone(osc, "RL", r=(1.04, 1.044), clearance=(15, 100), symmetric=True, lines=9)
proof = zone.prove(tolerance=0.02)
print(proof)
ax = proof.plot()

# %%
# What is proven of a point, and of one motion there: that it exists and is the only one near its numbers, that it
# meets no other wall, and bounds of its multipliers and of max\|X\|/A.

print(proof.decide(1.042, 40.0), proof.decide(1.042, 90.0))
motion = vi.equispaced(osc, r=1.042, clearance=40.0)[0]
print(motion.prove())

# %%
# It is the only stable one at this point with two impacts in a load cycle.

print(vi.prove_all(osc, r=1.042, clearance=40.0, max_impacts=2))
