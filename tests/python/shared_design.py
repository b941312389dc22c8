"""Small cases of a design that its tests share."""

import vibroimpact as vi

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
FEW = {"samples": 0, "evaluations": 16, "specimens": 4, "nodes": 3}
QUICK = FEW | {"settling": 120, "keep": 16}
GOOD = {"r": (1.0, 1.02), "free": {"clearance": (20, 45)}}
