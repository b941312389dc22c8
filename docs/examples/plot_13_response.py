"""
Response of an impact damper
============================

The response is the largest displacement relative to that without impacts, max|X|/A, against the frequency
ratio. Where it is below 1 the impacts reduce the vibration. Each dot is an attractor that one of the initial
states reaches.
"""

import vibroimpact as vi

osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
curve = vi.response(osc, (0.95, 1.05), points=101, inverse_clearance=0.03, states=8, settling=300)
print(curve)
best = curve.lowest.argmin()
print(f"least at r = {curve.r[best]:.3f}: {curve.lowest[best]:.3f}")

# %%

curve.plot()
