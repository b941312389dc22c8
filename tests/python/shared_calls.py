"""Calls of the package's functions with valid arguments; a test may replace some of them."""

import math

import vibroimpact as vi

NAN, INF = math.nan, math.inf
OSC = vi.Oscillator(xi=0.01, mu=0.05, restitution=(0.75, 0.61))
EVEN = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75)
PAIR = vi.Pattern("RL")
PHASES = [0.0, 3.3]


def oscillator(**changes):
    """Make the oscillator with some parameters replaced."""
    return vi.Oscillator(**{"xi": 0.01, "mu": 0.05, "restitution": 0.75} | changes)


def periodic(**changes):
    """Solve the periodic problem with some arguments replaced."""
    return vi.periodic(**{"osc": OSC, "r": 0.9, "phases": PHASES, "pattern": PAIR} | changes)


def linear_system(**changes):
    """Assemble the linear system with some arguments replaced."""
    return vi.linear_system(**{"osc": OSC, "r": 0.9, "phases": PHASES, "pattern": PAIR} | changes)


def batch(**changes):
    """Solve a batch of two with some arguments replaced."""
    good = {"osc": OSC, "r": 0.9, "phases": [[0.0, 0.0], [3.3, 3.4]], "pattern": PAIR}
    return vi.periodic_batch(**good | changes)


def equispaced(**changes):
    """Solve the equispaced problem with some arguments replaced."""
    return vi.equispaced(**{"osc": EVEN, "r": 0.9, "clearance": 20.0} | changes)
