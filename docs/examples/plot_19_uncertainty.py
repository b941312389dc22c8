"""
A zone of an uncertain rig
==========================

The damping ratio, the gap and the coefficient of restitution are known within the tolerances of the 1983 rig.
The colour is the probability that the equispaced motion is stable. Solid lines bound the band in which 95 % of
the displaced boundaries lie, and dashed lines the band from first derivatives; crosses mark where the latter is
not valid.
"""

import numpy as np
import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
rig = {
    "xi": (0.0109, 0.0119),
    "clearance": (0.0095 / 0.0105, 0.0115 / 0.0105),
    "restitution": (0.91 * 0.75, 0.75),
}
found = vi.uncertainty(
    osc, "RL", np.linspace(0.8, 1.2, 101), np.geomspace(4, 200, 101), rig, symmetric=True
)
print(found)

# %%

found.plot(inverse=True)
