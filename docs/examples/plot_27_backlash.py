"""
A gear pair with backlash
=========================

Two gears with a mesh stiffness and backlash are described by one coordinate, the dynamic transmission error.
Teeth touch on either side of the backlash; a mean torque presses them together, and an error of the teeth
excites them. The mesh stiffness, the effective mass and half the backlash are 1.
"""

import vibroimpact as vi

teeth = [vi.Stop([side], 1.0, stiffness=1.0, damping=0.1) for side in (1, -1)]
gears = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=teeth)
load = vi.Load(0.8, constant=[0.1], cosine=[0.03])

# %%
# The teeth are in contact at the start. As the frequency rises, the response jumps where they begin to
# separate, and jumps back where they remain in contact again. As the frequency falls, the separation persists
# down to a lower frequency:

response = vi.response(gears, load, (0.4, 1.4), points=101, state=([1.1], [0.0]))
response.plot()

# %%
# At a frequency between the jumps, both motions are possible. The teeth separate if the motion begins with a
# sufficient separation:

run = vi.simulate(gears, load, cycles=400, state=([1.35], [0.0]))
run.plot(window=(run.end - 40, run.end))
motion = vi.exact(gears, load, run)
print(motion)

# %%
# The branch through this motion leads to the frequencies at which it ends:

branch = vi.branch(motion, "frequency", bounds=(0.4, 1.4))
print(*branch.special_points, sep="\n")
branch.plot(y="q_max_0")
