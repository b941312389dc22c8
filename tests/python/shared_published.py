"""Published bifurcations of the one-wall impact oscillator x'' + 0.04 x' + x = F cos(omega t), and its motions."""

import csv
from pathlib import Path

import numpy as np

DATA = Path(__file__).parents[1] / "data" / "vivid.csv"
DRAG, RESTITUTION, CYCLES = 0.04, 0.9, 2


def published():
    """Kind, omega, F, approach speed and critical multiplier of each row."""
    lines = [line for line in DATA.read_text().splitlines() if not line.startswith("#")]
    return [(row.pop("kind"), *map(float, row.values())) for row in csv.DictReader(lines)]


def balance(phase, omega):
    """Load amplitude and approach speed of the motion with one impact at a load phase, in closed form.

    Both equations (the gap is closed, the speed after the impact is R times that before it) are linear in the
    amplitude and the impulse. Complex phases give derivatives.
    """
    period = CYCLES * 2 * np.pi / omega
    roots = np.roots([1, DRAG, 1])
    # periodic response to a unit impulse, and its derivative, at the end of the period
    ends = np.exp(roots * period) / (1 - np.exp(roots * period)) / (roots - roots[::-1])
    x, v = ends.sum().real, (roots * ends).sum().real
    gain = 1 / (1 - omega**2 + 1j * DRAG * omega)
    a = gain.real * np.cos(phase) - gain.imag * np.sin(phase)
    b = -omega * (gain.real * np.sin(phase) + gain.imag * np.cos(phase))
    # F a - (1 + R) w x = 1 and F b - (1 + R) w v = w
    load = (1 + (1 + RESTITUTION) * v) / (
        a * (1 + (1 + RESTITUTION) * v) - (1 + RESTITUTION) * x * b
    )
    return load, load * b / (1 + (1 + RESTITUTION) * v)


def zero(function, begin, step=1e-6):
    """A zero by the secant method."""
    old, new = begin, begin + step
    old_value, value = function(old), function(new)
    for _ in range(30):
        if value == old_value or abs(new - old) < 1e-14:
            break
        old, new = new, new - value * (new - old) / (value - old_value)
        old_value, value = value, function(new)
    return new


def phase_of_speed(omega, load, speed):
    """The phase of the motion with a given approach speed, near a given load amplitude."""
    grid = np.linspace(0, 2 * np.pi, 20001)
    loads, speeds = balance(grid, omega)
    begin = grid[np.argmin(np.abs(loads - load) / load + np.abs(speeds - speed))]
    return zero(lambda t: balance(t, omega)[1] - speed, begin)
