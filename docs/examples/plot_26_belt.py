"""
Stick-slip on a belt
====================

A mass on a spring and a dashpot is dragged by a belt through dry friction: it sticks until the spring force
exceeds the stick level, slips back, and sticks again. No load drives this motion, so its period is an unknown.
"""

import matplotlib.pyplot as plt
import numpy as np
import vibroimpact as vi

belt = vi.Friction([1], slip=0.6, stick=1.0, speed=0.2)
bow = vi.Structure(mass=[1], damping=[0.05], stiffness=[1], friction=[belt])
run = vi.simulate(bow, duration=60)
cycle = vi.exact(bow, vi.Load.none(), run)
print(cycle, f"period {cycle.period:.9f}")
run.plot()

# %%
# All states outside the limit cycle and near it reach it within one slip: a multiplier is 0. In the phase plane
# stick is a straight line at the speed of the belt.

fig, ax = plt.subplots(figsize=(5, 4.2), layout="constrained")
for start in ([0.0], [0.6]), ([2.0], [-1.0]):
    other = vi.simulate(bow, duration=30, state=start)
    q, q_dot = other.sample(np.linspace(0, 30, 3000))
    ax.plot(q[0], q_dot[0])
ax.set(xlabel="displacement $q$", ylabel=r"velocity $\dot q$")

# %%
# Damping shortens the slip until it no longer reaches the speed of the belt. There the limit cycle ends: with
# more damping, the mass slides steadily.

branch = vi.branch(cycle, "damping_0_0", bounds=(0.01, 1.0))
for point in branch.special_points:
    print(point)
fig, ax = plt.subplots(figsize=(5, 3.4), layout="constrained")
ax.plot(branch.values, branch.period)
ax.set(xlabel="damping $C$", ylabel="period $T$")
