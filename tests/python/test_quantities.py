"""Response quantities: energy balance, quadrature of samples, and harmonics of the equation of motion."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, ParameterTypeError
from vibroimpact.results.performance import perform

DAMPER = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
UNEVEN = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
SIGNALS = ("x", "x_dot", "x_ddot", "transmitted")
ORDERS = np.arange(1, 11)


def settled():
    """A motion with accumulation and rest, and the trajectory from which it was found."""
    run = vi.simulate(UNEVEN, r=0.9, clearance=6.0, cycles=6, discard=300)
    return vi.exact(UNEVEN, 0.9, 6.0, run), run


def cases():
    """Motions and trajectories of all kinds by name."""
    motion, run = settled()
    pair = vi.Oscillator(xi=0.02, mu=0.0, restitution=0.8)
    free = vi.Oscillator(xi=0.0, mu=0.3, restitution=(0.4, 0.9))
    start = {"t": 0.3, "x": 1.0, "x_dot": -0.2, "z": 0.9, "z_dot": 0.4}
    return {
        "motion": vi.equispaced(DAMPER, r=0.94, clearance=37.0)[0],
        "motion with rest": motion,
        "unequispaced motion": vi.exact(DAMPER, 0.94, 37.0, ([0, 1.38 * math.pi], "RL")),
        "many impacts": max(
            (m for m in vi.find(UNEVEN, 1.0, 20.0, max_impacts=5, max_cycles=2) if not m.pattern.has_rest),
            key=lambda motion: len(motion.pattern),
        ),
        "trajectory with rests": run,
        "transient": vi.simulate(UNEVEN, r=2.7, clearance=0.3, cycles=20),
        "massless": vi.simulate(pair, r=0.3, clearance=1.0, cycles=9, state=start),
        "free, without damping": vi.simulate(free, 0.7, 0.5, 4, start, load=0),
        "twice the load": vi.simulate(DAMPER, r=1.3, clearance=3.0, cycles=10, load=2.0),
    }  # fmt: skip


CASES = cases()


def quadrature(thing):
    """Gauss's rule over the segments between events, at most one radian each: times and weights."""
    if isinstance(thing, vi.Motion):
        first, last = 0.0, thing.period
    else:
        first, last = thing.initial_state["t"], thing.final_state["t"]
    inside = thing.events["time"]
    ends = np.unique([first, *inside[(inside > first) & (inside < last)], last])
    parts = np.ceil(np.diff(ends) * max(1, thing.r)).astype(int)
    steps = zip(ends[:-1], ends[1:], parts, strict=True)
    ends = np.concatenate([*(np.linspace(a, b, n, endpoint=False) for a, b, n in steps), [last]])
    node, weight = np.polynomial.legendre.leggauss(20)
    half = 0.5 * np.diff(ends)
    return (ends[:-1] + half)[:, None] + half[:, None] * node, half[:, None] * weight


def sampled(thing, t):
    """The four signals at some times."""
    s = thing.sample(t)
    return dict(
        zip(SIGNALS, (s.X, s.X_dot, s.X_ddot, s.X + 2 * thing.osc.xi * s.X_dot), strict=True)
    )


def load_phase(thing, t):
    """The load phase at some times."""
    if isinstance(thing, vi.Motion):
        return thing.r * t + thing.load_phase
    start = thing.initial_state
    return start["phase"] + thing.r * (t - start["t"])


@pytest.mark.parametrize("name", CASES)
def test_energy_balance(name):
    """The energy that the load supplies is dissipated in dashpot and impacts, or stored at the end."""
    q = CASES[name].quantities()
    scale = abs(q.work) + q.damping_loss + q.impact_loss + abs(q.energy_change)
    assert q.work - q.damping_loss - q.impact_loss - q.energy_change == pytest.approx(
        0, abs=1e-11 * scale
    )
    assert q.impact_loss == pytest.approx(q.impacts["loss"].sum(), rel=1e-9)
    assert (q.impacts["loss"] >= 0).all()
    if isinstance(CASES[name], vi.Motion):
        assert q.energy_change == 0
        assert q.work > 0


@pytest.mark.parametrize("name", CASES)
def test_quadrature(name):
    """Means, rms, work, dissipation and harmonics are integrals of the samples."""
    thing = CASES[name]
    q, (t, weight) = thing.quantities(), quadrature(thing)
    assert q.duration == pytest.approx(weight.sum(), rel=1e-13)
    values, phase = sampled(thing, t), load_phase(thing, t)
    for key in SIGNALS:
        signal, value = getattr(q, key), values[key]
        size = np.abs(value).max()
        assert signal.rms == pytest.approx(
            np.sqrt((weight * value**2).sum() / q.duration), rel=1e-11
        )
        mean = (weight * value).sum() / q.duration
        parts = np.array(
            [2 * (weight * value * np.exp(-1j * h * phase)).sum() / q.duration for h in ORDERS]
        )
        if key == "x_ddot":
            # with the impulses, the integral of the acceleration is the change of velocity
            ends = [] if isinstance(thing, vi.Motion) else [thing.initial_state, thing.final_state]
            change = ends[1]["x_dot"] - ends[0]["x_dot"] if ends else 0.0
            assert signal.mean == pytest.approx(change / q.duration, abs=1e-10 * size)
        else:
            assert signal.mean == pytest.approx(mean, abs=1e-12 * size)
            np.testing.assert_allclose(signal.harmonics, parts, atol=1e-11 * size)
    load = thing.sample(t).load
    assert q.work == pytest.approx((weight * load * values["x_dot"]).sum(), rel=1e-10, abs=1e-12)
    assert q.damping_loss == pytest.approx(
        2 * thing.osc.xi * (weight * values["x_dot"] ** 2).sum(), rel=1e-11
    )


@pytest.mark.parametrize("name", CASES)
def test_extremes(name):
    """No sample is beyond the extremes, and dense samples come near them."""
    thing = CASES[name]
    q, (t, _) = thing.quantities(), quadrature(thing)
    inside = thing.events["time"]
    inside = inside[(inside > t.min()) & (inside < t.max())]
    t = np.concatenate([t.ravel(), inside, np.nextafter(inside, -np.inf)])
    for key, value in sampled(thing, t).items():
        signal = getattr(q, key)
        size = signal.greatest - signal.least
        assert signal.least - 1e-11 * size <= value.min() <= signal.least + 0.01 * size
        assert signal.greatest - 0.01 * size <= value.max() <= signal.greatest + 1e-11 * size
        assert signal.peak == max(-signal.least, signal.greatest)
    if isinstance(thing, vi.Motion):
        assert (q.x.least, q.x.greatest) == pytest.approx(
            (thing.x_min, thing.x_max), abs=1e-12 * thing.A
        )


@pytest.mark.parametrize("name", [name for name in CASES if "motion" in name or "impacts" in name])
def test_harmonics_of_a_motion(name):
    """Derivatives multiply harmonics by i h r, and the force of the impacts closes the equation of motion."""
    motion = CASES[name]
    q = motion.quantities()
    rate, size = 1j * ORDERS * motion.r, motion.A * (1 + motion.r**2) * 100
    np.testing.assert_allclose(q.x_dot.harmonics, rate * q.x.harmonics, atol=1e-11 * motion.A)
    np.testing.assert_allclose(q.x_ddot.harmonics, rate**2 * q.x.harmonics, atol=1e-12 * size)
    np.testing.assert_allclose(
        q.transmitted.harmonics, (1 + 2 * motion.osc.xi * rate) * q.x.harmonics, atol=1e-11 * size
    )
    # the momentum of the primary mass is periodic: the mean force on it, -x with the impulses and the load, is 0
    assert q.x_ddot.mean == pytest.approx(0, abs=1e-10)
    assert q.transmitted.mean == pytest.approx(q.x.mean, abs=1e-11)
    fundamental = q.x.amplitude * np.sin(load_phase(motion, 0.3) + q.x.phase)
    assert fundamental == pytest.approx(
        (q.x.harmonics[0] * np.exp(1j * load_phase(motion, 0.3))).real
    )


def test_motion_without_work_of_impacts():
    """For a massless free mass the fundamental is the motion without impacts, with the lag of equation (4)."""
    pair = vi.Oscillator(xi=0.02, mu=0.0, restitution=0.8)
    motion = vi.equispaced(pair, r=0.8, clearance=3.0)[0]
    q = motion.quantities()
    assert q.x.amplitude == pytest.approx(motion.A, rel=1e-12)
    assert q.x.rms == pytest.approx(motion.A / math.sqrt(2), rel=1e-12)
    assert q.x.phase == pytest.approx(motion.tau - motion.load_phase, rel=1e-12)
    assert q.x_ddot.peak == pytest.approx(motion.r**2 * motion.A, rel=1e-12)
    assert np.abs(q.x.harmonics[1:]).max() < 1e-12 * motion.A
    assert not q.impacts["impulse"].any()
    assert not q.impacts["loss"].any()


def test_impacts():
    """Momentum, restitution and the jump of the acceleration, from samples on both sides of the impacts."""
    motion = CASES["many impacts"]
    q, mu = motion.quantities(), UNEVEN.mu
    hits = q.impacts
    assert hits["side"].tolist() == [side[0] for side in motion.pattern.symbols]
    assert hits["impulse"] == pytest.approx(
        mu * np.abs(motion.Z_dot_after - motion.Z_dot_before), rel=1e-11
    )
    reduced = mu / (1 + mu)
    assert hits["loss"] == pytest.approx(
        0.5 * reduced * (1 - motion.restitution**2) * hits["speed"] ** 2, rel=1e-10
    )
    times = motion.events["time"]
    before = np.nextafter(times + motion.period, -np.inf)
    jump = motion.sample(times).X_ddot - motion.sample(before).X_ddot
    assert hits["jump"] == pytest.approx(jump, abs=1e-11)


def test_sample_has_accelerations():
    """Accelerations solve the equation of motion; those of both masses agree in a rest."""
    motion, run = settled()
    for thing in (motion, run):
        s = thing.sample(quadrature(thing)[0])
        resting = s.Z_ddot != 0
        assert resting.any()
        assert not resting.all()
        np.testing.assert_array_equal(s.X_ddot[resting], s.Z_ddot[resting])
        force = s.load - 2 * UNEVEN.xi * s.X_dot - s.X
        np.testing.assert_allclose(s.X_ddot + UNEVEN.mu * s.Z_ddot, force, atol=1e-13)


def test_window_of_a_trajectory():
    """Windows add up, and the last period of a settled trajectory equals the motion."""
    motion, run = settled()
    one, two, whole = (run.quantities(cycles) for cycles in (1, 2, None))
    of_motion = motion.quantities()
    assert whole.cycles == pytest.approx(6, rel=1e-12)
    assert two.work == pytest.approx(2 * of_motion.work, rel=1e-9)
    for key in SIGNALS:
        mine, wanted = getattr(one, key), getattr(of_motion, key)
        assert mine.rms == pytest.approx(wanted.rms, rel=1e-9)
        assert mine.peak == pytest.approx(wanted.peak, rel=1e-7)
    np.testing.assert_allclose(one.x.harmonics, of_motion.x.harmonics, atol=1e-8)
    first = vi.simulate(UNEVEN, r=1.1, clearance=4.0, cycles=7.3)
    rest = vi.simulate(UNEVEN, r=1.1, clearance=4.0, cycles=2.2, state=first.final_state)
    together = vi.simulate(UNEVEN, r=1.1, clearance=4.0, cycles=9.5).quantities()
    assert together.work == pytest.approx(
        first.quantities().work + rest.quantities().work, rel=1e-10
    )
    assert together.cycles == pytest.approx(9.5)


@pytest.mark.parametrize("cycles", [0, -1, math.nan, math.inf, 1000])
def test_windows_that_are_refused(cycles):
    with pytest.raises(ParameterError, match=r"^cycles = "):
        CASES["transient"].quantities(cycles)


@pytest.mark.parametrize("harmonics", [0, -1, 10_001, 1.5, "2", None])
def test_harmonics_that_are_refused(harmonics):
    with pytest.raises((ParameterError, ParameterTypeError), match=r"^harmonics = "):
        CASES["motion"].quantities(harmonics=harmonics)


def test_rest_at_the_instant_of_an_impact():
    """With R = 0 there is no flight between an impact and the rest: its acceleration enters no quantity."""
    osc = vi.Oscillator(xi=0.02, mu=1.0, restitution=0.0)
    run = vi.simulate(osc, r=0.8, clearance=1.5, cycles=6, discard=60)
    times = np.linspace(run.initial_state["t"], run.final_state["t"], 40_001)
    sampled = abs(run.sample(times).X_ddot).max()
    assert run.quantities().x_ddot.peak == pytest.approx(sampled, rel=1e-4)
    found = perform(np.array([[0.8], [1.5], [0.02], [1.0], [0.0], [0.0]]), np.full((4, 1), 0.1))
    assert found.acceleration[0] == pytest.approx(sampled, rel=1e-3)
