r"""
Free vibration of an impact damper
==================================

The first measure of an impact damper is how fast it reduces a free vibration. The primary mass is released
from the displacement 1 with the free mass in the middle of its slot; there is no load, so any length can be
the unit instead of :math:`F_0/K`, and only the ratio of clearance to amplitude matters.

A peak is the largest :math:`|X|` between two zeros of :math:`X`, exact to rounding. It is a stationary point
of the closed form, or an impact that reverses the velocity. The damping of a cycle is the logarithmic decrement
:math:`\delta = \ln(X_k/X_{k+2})` from a peak to the next one on the same side, given as the damping ratio of a
linear oscillator with this decrement, :math:`\zeta = \delta/\sqrt{4\pi^2 + \delta^2}`.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.005, mu=0.1, restitution=0.75)
free = vi.decay(osc, [0.3, 0.7, 1.5], cycles=20)
print(free)
for i, clearance in enumerate(free.clearance):
    x = free.x[free.run == i]
    print(f"d = {clearance}: after 10 cycles {abs(x[20]):.3f}, after 20 cycles {abs(x[40]):.3f}")

# %%
# The damping increases as the amplitude falls, until the free mass no longer impacts in every half cycle. Between
# two impacts only the dashpot then dissipates energy, and in a cycle with an impact the primary mass can even gain
# energy from the free mass. The dashed line is the damping ratio :math:`\xi` of the dashpot.

free.plot()
