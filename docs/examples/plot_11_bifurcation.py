"""
A bifurcation diagram
=====================

The simulation continues from value to value, first up and then down. Where the two sweeps differ there is
hysteresis: dots and crosses belong to the sweep up, open marks to the sweep down. The lines at the top name the
periodic windows: 2/1 is two impacts in one load cycle.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
diagram = vi.bifurcation_diagram(osc, "clearance", (10, 90), points=161, r=1.04)
print(diagram)
for window in diagram.windows[:4]:
    print(window)

# %%

diagram.plot()
