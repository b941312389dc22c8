"""
Basins of attraction
====================

The basins show which motion each initial state reaches. At the point of Table 1 the unequispaced motion
and its mirror image are both stable: RL/1 (1) and (2).
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
plane = (("x", (-30, 30)), ("x_dot", (-30, 30)))
result = vi.basins(osc, 0.94, 37.0, plane, points=80)
print(result)

# %%

result.plot()
