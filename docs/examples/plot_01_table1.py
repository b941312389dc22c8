"""
Impact times given: Table 1
===========================

The theory of 1983 takes the phases of the impacts as given; what is left is a linear system. This is
the third column of the paper's Table 1, two unequally spaced impacts a cycle.
"""

import math

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
motion = vi.periodic(osc, r=0.94, phases=[0, 1.37 * math.pi], pattern=vi.Pattern("RL"))
print(motion)
print("clearance d K/F0 =", round(motion.clearance, 3))
print("multipliers      ", abs(motion.multipliers).round(4))

# %%
# The clearance comes out of the equations: with these phases it is 38.22, not the 37 that the table
# is headed with. The product of the multipliers is known beforehand, exp(−4πξk/r)·∏R²:

product = math.prod(abs(motion.multipliers))
print(product - math.exp(-4 * math.pi * 0.005 / 0.94) * 0.75**4)

# %%
# Displacements, load, acceleration and phase portrait over two cycles:

motion.plot()
