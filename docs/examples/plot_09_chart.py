"""
A chart coloured by attenuation
===============================

A chart gives the verdicts at each point of a grid. The stable zone is coloured by max|x|/A, the largest
displacement relative to that without impacts; dark colours mean a strong reduction.
"""

import numpy as np
import vibroimpact as vi
from vibroimpact.plot import draw_chart

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
data = vi.chart(
    osc, vi.Pattern("RL"), np.linspace(0.9, 1.1, 201), np.geomspace(5, 200, 161), symmetric=True
)
print(f"{data.sizes['r']} frequency ratios, {data.sizes['clearance']} clearances")

# %%

draw_chart(data, color="attenuation", inverse=True)
