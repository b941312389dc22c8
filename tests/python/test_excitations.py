"""Shocks, swept sines and base motions in physical units, compared with the oscillator and first principles."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, ParameterTypeError

M, K, C, m, F0, D = 2.7, 42e3, 7.7, 0.11, 6.0, 0.004
RIG = vi.Oscillator.from_dimensional(M=M, K=K, C=C, m=m, restitution=0.75, F0=F0)


def test_structure_of_a_rig():
    """The two masses in the units of the rig move as the dimensionless oscillator does."""
    structure, units = RIG.structure(d=D), RIG.units()
    np.testing.assert_allclose(structure.mass, np.diag([M, m]), rtol=1e-14)
    np.testing.assert_allclose(structure.damping, np.diag([C, 0]), rtol=1e-14)
    np.testing.assert_allclose(structure.stiffness, np.diag([K, 0]), rtol=1e-14)
    assert [gap.opening for gap in structure.gaps] == [D / 2, D / 2]
    state = {"t": 0, "x": 0.0, "x_dot": 0.0, "z": 0.0, "z_dot": 1.0}
    run = vi.simulate(RIG, units.frequency_ratio(f=19.5), units.clearance(d=D), 6, state).physical()
    start = ([0, 0], [0, units.velocity])
    same = vi.simulate(structure, vi.Load(2 * np.pi * 19.5, sine=[F0, 0]), cycles=6, state=start)
    hits = run.events["time"]
    np.testing.assert_allclose(same.events["time"], hits, rtol=1e-9)
    t = np.linspace(0, 0.99 * same.end, 200)
    q, rate = same.sample(t)
    np.testing.assert_allclose(run.sample(t).X, q[0], atol=1e-9 * np.abs(q).max())
    np.testing.assert_allclose(run.sample(t).Z_dot, rate[1], atol=1e-8 * np.abs(rate).max())
    np.testing.assert_allclose(run.sample(t).X_ddot, same.acceleration(t)[0], atol=1e-8 * F0)
    mine, theirs = run.quantities(), same.quantities()
    assert mine.work == pytest.approx(theirs.work, rel=1e-8)
    assert mine.x_ddot.peak == pytest.approx(theirs.q_ddot.peak[0], rel=1e-7)


@pytest.mark.parametrize("kind", ["displacement", "velocity", "acceleration"])
def test_motion_of_the_base(kind):
    """The load of a moving base acts through the spring and the dashpot."""
    f, amplitude = 19.5, 0.3
    omega = 2 * np.pi * f
    y = amplitude / omega ** ["displacement", "velocity", "acceleration"].index(kind)
    load = vi.base_motion(RIG.structure(d=D), omega, sine=y)
    wanted = math.hypot(load.sine[0, 0], load.cosine[0, 0])
    assert RIG.base_load(f, **{kind: amplitude}) == pytest.approx(wanted, rel=1e-13)


def test_half_sine():
    """The pulse has its peak and area, and the response after it is a free vibration with the impulse."""
    step, duration = 1e-5, 0.002
    shock = vi.half_sine(50.0, duration, step, end=0.05)
    assert shock.max() == pytest.approx(50.0, rel=1e-6)
    assert shock.sum() * step == pytest.approx(50 * 2 / np.pi * duration, rel=1e-4)
    assert not shock[201:].any()
    assert len(shock) == 5001
    wide = RIG.structure(d=1.0)
    run = vi.simulate(wide, vi.base_record(wide, step, acceleration=shock))
    # much shorter than the period of 50 ms: the velocity of M relative to the base is -area
    assert run.sample([duration])[1][0, 0] == pytest.approx(-50 * 2 / np.pi * duration, rel=0.02)
    assert len(vi.half_sine(1.0, 0.01, 0.001)) == 11


SWEEPS = [
    ("linear", (10, 30)),
    ("geometric", (10, 30)),
    ("geometric", (30, 10)),
    ("linear", (20, 20)),
]


@pytest.mark.parametrize(("spacing", "f"), SWEEPS)
def test_swept_sine(spacing, f):
    """The number of cycles between two times is the integral of the frequency."""
    step, duration = 1e-4, 8.0
    signal = vi.swept_sine(-2.0, f, duration, step, spacing)
    assert len(signal) == 80_001
    assert signal[0] == 0
    assert np.abs(signal).max() == pytest.approx(2.0, rel=1e-4)
    t = step * np.arange(len(signal))
    share = t / duration
    frequency = (
        f[0] + (f[1] - f[0]) * share if spacing == "linear" else f[0] * (f[1] / f[0]) ** share
    )
    turns = np.concatenate([[0], np.cumsum(0.5 * step * (frequency[1:] + frequency[:-1]))])
    np.testing.assert_allclose(signal, -2 * np.sin(2 * np.pi * turns), atol=1e-4)


REFUSED = [
    (lambda: vi.half_sine(0, 0.01, 0.001), "amplitude"), (lambda: vi.half_sine(np.nan, 0.01, 0.001), "amplitude"),
    (lambda: vi.half_sine(1, 0.001, 0.001), "duration"), (lambda: vi.half_sine(1, 0.01, 0.001, 0.005), "duration"),
    (lambda: vi.half_sine(1, 0.01, 0), "step"), (lambda: vi.half_sine(1, 0.01, 1e-12, 100.0), "step"),
    (lambda: vi.swept_sine(1, (10, 20), 1, 0.01), "step"), (lambda: vi.swept_sine(1, 10, 1, 0.001), "f"),
    (lambda: vi.swept_sine(1, (0, 20), 1, 0.001), "f"), (lambda: vi.swept_sine(1, (1, np.inf), 1, 0.001), "f"),
    (lambda: vi.swept_sine(1, (10, 20), -1, 0.001), "duration"),
    (lambda: vi.swept_sine(1, (10, 20), 1, 0.001, "cubic"), "spacing"),
    (lambda: RIG.base_load(19.5), "displacement"), (lambda: RIG.base_load(0.0, velocity=1), "f"),
    (lambda: RIG.base_load(1.0, velocity=1, displacement=1), "displacement"),
    (lambda: RIG.base_load(1.0, velocity=-1), "velocity"), (lambda: RIG.structure(3.0, d=0.1), "clearance"),
    (lambda: RIG.structure(), "clearance"), (lambda: RIG.structure(d=0.0), "d"),
    (lambda: vi.Oscillator(xi=0.1, mu=0.1, restitution=1).structure(d=1.0), "d"),
    (lambda: vi.Oscillator(xi=0.1, mu=0.1, restitution=1).base_load(1.0, velocity=1.0), "M"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "name"), REFUSED)
def test_refused(call, name):
    """Error messages start with the name of the parameter."""
    with pytest.raises((ParameterError, ParameterTypeError), match=rf"^{name}\b"):
        call()
