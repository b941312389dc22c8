"""
An energy harvester with soft stops
===================================

A coil converts the motion of a magnet on a spring. Soft stops limit its travel and widen the band of the
harvester: as the frequency rises, the motion remains large far above the resonance. All quantities are
divided by those of the magnet and the spring, lengths by the distance to the stops.
"""

import matplotlib.pyplot as plt
import vibroimpact as vi

stops = [vi.Stop([side], 1.0, stiffness=5.0, damping=0.05, release="force") for side in (1, -1)]
harvester = vi.Structure(mass=[1], damping=[0.03], stiffness=[1], gaps=stops)
load = vi.Load(1.2, sine=[0.1])  # an acceleration of the base, of constant amplitude

# %%
# Without stops, the displacement at resonance would be 3.3. With stops it exceeds 1 only a little, over a band
# that depends on the direction in which the frequency changes:

response = vi.response(harvester, load, (0.7, 1.8), points=111)
response.plot()

# %%
# A motion with contacts, above the resonance. The times of contact are shaded:

run = vi.simulate(harvester, load, cycles=300, state=([1.2], [0.5]))
run.plot(window=(run.end - 20, run.end))
motion = vi.exact(harvester, load, run)
print(motion)

# %%
# Its branch along the frequency. The power in the coil is C times the mean square of the velocity, which
# `quantities` gives for each stable motion:

branch = vi.branch(motion, "frequency", bounds=(0.7, 1.8))
print(*branch.special_points, sep="\n")
power = []
for i in range(0, len(branch), 4):
    stable = branch.stable[i] == 1 and branch.admissible[i] == 1
    power.append(0.03 * branch[i].quantities().q_dot.rms[0] ** 2 if stable else float("nan"))
fig, ax = plt.subplots(figsize=(5, 3.4), layout="constrained")
ax.plot(branch.values[::4], power, ".-")
ax.set(
    xlabel=r"load frequency $\Omega$", ylabel=r"mean power in the coil, $C\,\overline{\dot q^2}$"
)
