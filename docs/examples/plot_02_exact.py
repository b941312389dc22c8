"""
An exact motion at a given clearance
====================================

If the clearance is given, the phases are unknowns too. Newton's method finds them from a
guess, here the rounded phase of Table 1.
"""

import math

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
pattern = vi.Pattern("RL")
printed = vi.periodic(osc, 0.94, [0, 1.37 * math.pi], pattern)
exact = vi.exact(osc, 0.94, 37.0, (printed.alpha, pattern))
print(repr(exact))
print(f"second phase: {exact.alpha[1] / math.pi:.6f} pi instead of 1.37 pi")

# %%
# With the exact phases, the linear equations of the 1983 paper give the same motion, so two independent
# parts of the program agree:

again = vi.periodic(osc, 0.94, exact.alpha, pattern)
print(f"clearance {again.clearance:.12f}, first position {again.X[0] - exact.X[0]:.1e} apart")

# %%

exact.plot()
