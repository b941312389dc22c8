r"""
A zone, proven
==============

The picture shows where symmetric motions with one impact on each wall are proven, in ball arithmetic, to be
stable and admissible. Each point of the blue parts has such a motion, no point of the light parts has one, and for
the black parts neither is proven. Boxes fill the plane of r and the load phase of the impact, so that no motion is
left out. A program that does not use this package checks the certificate.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
zone = vi.zone(osc, "RL", r=(1.1, 1.3), clearance=(1, 200), symmetric=True)
proof = zone.prove(tolerance=2e-3)
print(proof)
ax = proof.plot()

# %%
# The verdict at a point, and the statements proven for one motion there: it exists and is unique near its numbers,
# it hits no wall between its impacts, and its multipliers and max\|X\|/A are bounded.

print(proof.decide(1.2, 12.0), proof.decide(1.2, 30.0))
motion = vi.equispaced(osc, r=1.2, clearance=12.0)[0]
print(motion.prove())

# %%
# It is the only stable one at this point with two impacts in a load cycle.

print(vi.prove_all(osc, r=1.2, clearance=12.0, max_impacts=2))
