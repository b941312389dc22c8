"""
Simulation with impacts that accumulate
=======================================

On the taped left wall (R = 0.61) the impacts follow at ever shorter intervals until the free mass
rests on the wall. The simulation sums the accumulation to its limit, keeps the mass on the wall, and
releases it when the contact force vanishes. It uses no time step and no tolerance.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
run = vi.simulate(osc, r=0.9, clearance=6.0, cycles=8, discard=200)
print(run)
for event in run.events[:4]:
    print(f"t = {event['time']:.6f}  {event['kind']:8s} on {event['side']}")

# %%
# The pattern of this motion is written ``RL*``. The exact motion with its multipliers:

motion = vi.exact(osc, 0.9, 6.0, run)
print(repr(motion))

# %%

run.plot(cycles=2)
