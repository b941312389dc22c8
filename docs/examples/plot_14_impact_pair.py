"""
The impact pair, mu = 0
=======================

With mu = 0 the free mass does not affect the primary mass. It moves like a ball between two walls that
oscillate harmonically. The same functions compute them.
"""

import vibroimpact as vi

pair = vi.Oscillator(xi=0.05, mu=0.0, restitution=0.6)
for motion in vi.equispaced(pair, r=1.2, clearance=12.0):
    print(repr(motion))
    print(f"primary mass: {motion.x_max:.12f}, without impacts {motion.A:.12f}")

# %%
# Its zone of two equally spaced impacts a cycle:

zone = vi.zone(pair, vi.Pattern("RL"), r=(0.9, 1.5), clearance=(0.5, 40), symmetric=True)
print(zone)
zone.plot()
