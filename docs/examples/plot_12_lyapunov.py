"""
Lyapunov exponents
==================

This example computes all four exponents along a line of the plane. The largest exponent is negative for a
periodic motion, 0 for a quasi-periodic motion and positive for a chaotic motion. The periodic motion here has
two pairs of equal exponents, because its multipliers are complex. Where the free mass comes to rest, two
exponents are −∞; these are drawn as open marks at the lower edge.
"""

import numpy as np
import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
start = {"t": 0, "x": 0, "x_dot": 0, "z": 0, "z_dot": 8}
result = vi.lyapunov(osc, 1.04, np.linspace(30, 90, 121), cycles=2000, discard=500, state=start)
print(result)

# %%

result.plot()

# %%
# The damping and the impacts determine the sum of the exponents. For a stable periodic motion the exponents
# are the logarithms of the multipliers.

point = vi.lyapunov(osc, 1.04, 30.0, cycles=2000)
motion = vi.equispaced(osc, 1.04, 30.0)[0]
print(point.per_cycle.round(6))
print(np.log(abs(motion.multipliers)).round(6))
