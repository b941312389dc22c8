r"""
The design of an impact damper
==============================

The clearance and the mass of a free mass are chosen so that max\|X\|/A stays below 0.3 from r = 1 to 1.02 for 99 %
of the units. The coefficients of restitution lie between 0.66 and 0.78, and the clearance deviates by up to one
F0/K to either side. The clearance is the whole travel of the free mass from wall to wall.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
found = vi.design(
    osc,
    r=(1.0, 1.02),
    free={"clearance": (10, 60), "mu": (0.01, 0.1)},
    tolerance={"restitution": (0.66, 0.78), "clearance": (-1, 1)},
    limit=0.3,
    samples=10_000,
)
print(found.values)
print(found.verdict)

# %%
# The candidates over the clearance; the level with tolerances over the nominal one, with the Pareto front; the
# share of the samples within the limit along the band, with confidence intervals; the change of max\|X\|/A of
# the worst unit if a parameter grows by 1 %; and the best level found so far by each independent search.

found.plot()
