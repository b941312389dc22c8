r"""
Attractors of a structure
=========================

A mass on a spring carries a free mass in a slot. This example computes its response over the load frequency,
the settled motions along the opening of the slot, the basins of coexisting motions, and the exponents of a
chaotic one.
"""

import vibroimpact as vi


def damper(opening):
    gaps = [vi.Gap([-1, 1], opening, 0.75), vi.Gap([1, -1], opening, 0.75)]
    return vi.Structure([1.0, 0.028], [0.0228, 0.0], [1.0, 0.0], gaps)


load = vi.Load(1.04, sine=[1.0, 0.0])

# %%
# `response` carries the state from frequency to frequency, up and then down. The dashed line is the steady motion
# without impacts.

vi.response(damper(5.0), load, (0.8, 1.2), points=41).plot()

# %%
# `bifurcation_diagram` does the same along any parameter; here along the opening of both gaps. Dots belong to the
# upward sweep, rings to the downward sweep.

start = ([0.0, 0.0], [6.0, 9.0])
diagram = vi.bifurcation_diagram(damper(5.0), load, "opening", (2.0, 12.0), points=81, state=start)
diagram.plot(quantity="speed")

# %%
# Two motions of three impacts, mirror images of each other, coexist at an opening of 7.

plane = (("q_0", (-6.8, 6.8)), ("q_dot_0", (-9.0, 9.0)))
basins = vi.basins(damper(7.0), load, plane, points=60)
print(basins)
basins.plot()

# %%
# At an opening of 2.5 the motion is chaotic. The sum of the exponents is known from damping and impacts.

exponents = vi.lyapunov(damper(2.5), load, state=start)
print(exponents)
print(f"dimension {exponents.dimension:.2f}, error of the sum {exponents.identity_error:.0e}")
