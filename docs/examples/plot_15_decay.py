r"""
Free vibration of an impact damper
==================================

An impact damper is judged first by how it brings a free vibration to rest. The primary mass is released from the
displacement 1 with the free mass in the middle of its slot; there is no load, so :math:`F_0/K` is any unit of
length, and only the ratio of clearance and amplitude matters.

A peak is the greatest :math:`|X|` between two zeros of :math:`X`, exact to rounding: a stationary point of the
closed form or an impact that turns the mass back. The damping of a cycle is the logarithmic decrement
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
# The damping grows as the amplitude falls, until the free mass no longer keeps in step. Then the dashpot is left
# alone between two impacts, and a cycle with an impact may even gain energy from the free mass. The dashed line is
# the dashpot's :math:`\xi`.

free.plot()
