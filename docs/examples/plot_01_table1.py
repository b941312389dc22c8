"""
Given impact times: Table 1
===========================

In the theory of the 1983 paper the phases of the impacts are given, and the other unknowns follow from a
linear system. This example is the third column of the paper's Table 1, two unequally spaced impacts a cycle.
"""

import math

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motion = vi.periodic(osc, r=0.94, phases=[0, 1.37 * math.pi], pattern=vi.Pattern("RL"))
print(motion)
print("clearance d K/F0 =", round(motion.clearance, 3))
print("multipliers      ", abs(motion.multipliers).round(4))

# %%
# The clearance is a result of the equations: with these phases it is 38.22, not 37 as in the heading of
# the table. The product of the multipliers must be exp(−4πξk/r)·∏R². The difference is of
# the order of rounding errors:

product = math.prod(abs(motion.multipliers))
print(product - math.exp(-4 * math.pi * 0.005 / 0.94) * 0.75**4)

# %%
# Displacements, load, acceleration and phase portrait over two load cycles:

motion.plot()
