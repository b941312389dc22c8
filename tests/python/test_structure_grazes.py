"""Grazes of structures: every crest beyond a stop is an impact, however low."""

import math

import numpy as np
import pytest
import vibroimpact as vi

OVERSHOOTS = 10.0 ** np.linspace(-2, -12, 51)


@pytest.mark.parametrize("overshoot", OVERSHOOTS[::5])
def test_grazes_are_found(overshoot):
    """A stop slightly below the amplitude is hit; a stop slightly above it is not."""
    for side in (1, -1):
        s = vi.Structure([1.0], [0.0], [1.0], [vi.Gap([1.0], 1 - side * overshoot, 0.5)])
        run = vi.simulate(s, duration=2 * np.pi, state=([0.0], [1.0]))
        assert (len(run.events) > 0) == (side > 0)
    s = vi.Structure([1.0], [0.0], [1.0], [vi.Gap([1.0], 1 - overshoot, 0.5)])
    run = vi.simulate(s, duration=2 * np.pi, state=([0.0], [1.0]))
    assert math.sin(run.events["time"][0]) == pytest.approx(1 - overshoot, abs=1e-15)


def crests(terms, end):
    """Times and heights of the maxima of the real part of a sum of c exp(lambda t), for t up to `end`."""
    c, powers = terms

    def derivative(t, order):
        return (np.exp(np.multiply.outer(t, powers)) @ (c * powers**order)).real

    t = np.linspace(0, end, int(40 * end * np.abs(powers).max()))
    rate = derivative(t, 1)
    tops = t[:-1][(rate[:-1] > 0) & (rate[1:] <= 0)]
    for _ in range(8):
        tops = tops - derivative(tops, 1) / derivative(tops, 2)
    return tops, derivative(tops, 0)


def check_graze(s, load, state, terms, overshoot):
    """The first crest beyond a stop is found, however low; no crest exceeds a slightly more distant stop."""
    (gap,), end = s.gaps, 40.0
    tops, heights = crests(terms, end)
    highest = heights.max()
    for side in (1, -1):
        opening = highest - side * overshoot * abs(highest)
        stop = vi.Gap(gap.direction, opening, gap.restitution)
        own = vi.Structure(s.mass, s.damping, s.stiffness, [stop])
        run = vi.simulate(own, load, duration=end, state=state, max_events=1)
        if side < 0:
            assert len(run.events) == 0
            continue
        first = int(np.argmax(heights > opening))
        t = run.events["time"][0]
        assert (tops[first - 1] if first else 0) < t < tops[first]
        c, powers = terms
        rounding = np.finfo(float).eps * (np.abs(c) * (4 + np.abs(powers) * t)).sum()
        assert abs((c * np.exp(powers * t)).sum().real - opening) < rounding
        assert run.events["speed"][0] > 0


def test_every_graze_of_a_host_of_20_modes():
    """51 of 51 at overshoots down to 1e-12, from different states: the host oscillates freely in all modes."""
    rng = np.random.default_rng(8)
    frequencies = np.sort(rng.uniform(0.5, 8, 20))
    ratios = rng.uniform(0.0005, 0.002, 20)
    direction = rng.choice([-1, 1], 20) * rng.uniform(0.5, 1, 20)
    powers = frequencies * (-ratios + 1j * np.sqrt(1 - ratios**2))
    stop = vi.Gap(direction, 1.0, 0.5)
    s = vi.Structure(np.ones(20), 2 * ratios * frequencies, frequencies**2, [stop])
    for overshoot in OVERSHOOTS:
        c = rng.uniform(0.1, 1, 20) * np.exp(1j * rng.uniform(0, 2 * np.pi, 20)) / frequencies
        c *= -np.sign(direction @ c.real)  # the gap is open at the start
        state = (c.real, (c * powers).real)
        check_graze(s, None, state, (direction * c, powers), overshoot)


def test_every_graze_of_a_one_wall_stop():
    """51 of 51 at overshoots down to 1e-12, from different states: a load, and a decaying transient."""
    rng = np.random.default_rng(9)
    ratio, frequency = 0.01, 0.3
    s = vi.Structure([1.0], [2 * ratio], [1.0], [vi.Gap([1.0], 1.0, 0.5)])
    load = vi.Load(frequency, cosine=[1.0])
    powers = np.array([-ratio + 1j * math.sqrt(1 - ratio**2), 1j * frequency])
    steady = 1 / (1 - frequency**2 + 2j * ratio * frequency)
    for overshoot in OVERSHOOTS:
        q, rate = rng.uniform(-1, 0), rng.uniform(-1, 1)
        x, v = q - steady.real, rate - (steady * powers[1]).real
        c = np.array([x + 1j * (powers[0].real * x - v) / powers[0].imag, steady])
        check_graze(s, load, ([q], [rate]), (c, powers), overshoot)
