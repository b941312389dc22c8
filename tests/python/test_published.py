"""Published bifurcations of the one-wall impact oscillator, all rows."""

import csv
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi

DATA = Path(__file__).parents[1] / "data" / "vivid.csv"
DRAG, RESTITUTION, CYCLES = 0.04, 0.9, 2


def published():
    """kind, omega, F, approach speed and critical multiplier of each row."""
    lines = [line for line in DATA.read_text().splitlines() if not line.startswith("#")]
    return [(row.pop("kind"), *map(float, row.values())) for row in csv.DictReader(lines)]


def balance(phase, omega):
    """Load amplitude and approach speed of the motion with one impact at a load phase, in closed form.

    Both equations (the gap is closed, the speed after the impact is R times that before it) are linear in the
    amplitude and the impulse. Complex phases give derivatives.
    """
    period = CYCLES * 2 * np.pi / omega
    roots = np.roots([1, DRAG, 1])
    # periodic response to a unit impulse, and its rate, at the end of the period
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


def check(rows):
    """At each published point: the exact motion, with the published approach speed and multiplier.

    The authors accept a point as soon as the multiplier is within 1e-5 of 1 or -1. Near a fold a motion moves with
    the square root of the load, so there the linear problem is solved at the phase with the published speed.
    """
    wall = vi.Structure([1], [DRAG], [1], [vi.Gap([1], 1, RESTITUTION)])
    grid = np.linspace(0, 2 * np.pi, 20001)
    for kind, omega, load, speed, multiplier in rows:
        loads, speeds = balance(grid, omega)
        begin = grid[np.argmin(np.abs(loads - load) / load + np.abs(speeds - speed))]
        phase = zero(lambda t, w=omega, v=speed: balance(t, w)[1] - v, begin)
        assert balance(phase, omega)[0] == pytest.approx(load, abs=1e-9)
        if kind == "flip":
            motion = vi.exact(wall, vi.Load(omega, cosine=[load]), ([phase], [0], CYCLES))
            assert motion.consistent
            assert motion.speeds[0] == pytest.approx(speed, abs=2e-10)
            # one row ends the list past the grazing of its impact
            assert motion.admissible is (speed > 0)
            if speed < 0:
                continue
        else:
            motion = vi.periodic(
                wall, vi.Load(omega, cosine=[balance(phase, omega)[0]]), [phase], [0], CYCLES
            )
            assert motion.residual < 1e-12
            # the fold itself, where the load is extreme, lies within 1e-7 in F
            top = zero(lambda t, w=omega: balance(t + 1e-30j, w)[0].imag / 1e-30, phase)
            assert balance(top, omega)[0] == pytest.approx(load, abs=1e-7)
        side = -1 if kind == "flip" else 1
        assert abs(multiplier - side) < 1e-5
        assert np.abs(motion.multipliers - multiplier).min() < 1e-7


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


def test_published_bifurcations_in_part():
    check(published()[::40])


@pytest.mark.slow
def test_all_published_bifurcations():
    rows = published()
    assert len(rows) == 2616
    check(rows)
