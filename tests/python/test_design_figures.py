"""Figures of motions that a design compares: closed forms, exact motions, samples and linear theory."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_design import OSC, QUICK
from vibroimpact.designs.problem import OscillatorHost
from vibroimpact.results.performance import FIGURES, perform


def random_systems(n, seed, restitution):
    rng = np.random.default_rng(seed)
    columns = [rng.uniform(0.97, 1.05, n), rng.uniform(15, 45, n), rng.uniform(0.005, 0.03, n)]
    columns += [
        rng.uniform(0.02, 0.1, n),
        rng.uniform(*restitution, n),
        rng.uniform(*restitution, n),
    ]
    return np.array(columns), rng.uniform(-1, 1, (4, n))


def sampled_gap(motion, amounts):
    """The least distance from a wall at the turns of the relative position between impacts, from dense samples."""
    times = np.linspace(0, amounts.duration, 20_001)
    y = motion.sample(times).Y
    before, here, after = y[:-2], y[1:-1], y[2:]
    upper, lower = (
        (sign * here > sign * before) & (sign * here >= sign * after) for sign in (1, -1)
    )
    gaps = np.append(0.5 * motion.clearance - here[upper], 0.5 * motion.clearance + here[lower])
    # samples next to an impact
    near = 2 * amounts.impacts["speed"].max() * times[1]
    return gaps[gaps > near].min(initial=math.inf)


def test_figures_are_those_of_exact_motions():
    """Two calculations agree: the closed form of the core over a period, and `quantities` of the exact motion."""
    parameters, places = random_systems(60, 3, (0.5, 0.8))
    found = perform(parameters, places)
    assert (found.status == 0).all()
    tried = 0
    for j in np.flatnonzero((found.cycles > 0) & (found.impacts > 0)):
        r, clearance, xi, mu, *walls = map(float, parameters[:, j])
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=tuple(walls))
        state = dict(
            zip(("t", "x", "x_dot", "z", "z_dot"), map(float, found.states[:, j]), strict=True)
        )
        run = vi.simulate(osc, r, clearance, cycles=4 * int(found.cycles[j]), state=state)
        if (run.events["kind"] != "impact").any():
            continue
        motion = vi.exact(osc, r, clearance, run)
        amounts = motion.quantities()
        assert amounts.duration == pytest.approx(2 * math.pi * found.cycles[j] / r, rel=1e-12)
        assert found.displacement[j] == pytest.approx(motion.attenuation * motion.A, rel=1e-9)
        assert found.rms[j] == pytest.approx(amounts.x.rms, rel=1e-9)
        assert found.acceleration[j] == pytest.approx(amounts.x_ddot.peak, rel=1e-9)
        assert found.force[j] == pytest.approx(amounts.transmitted.peak, rel=1e-9)
        assert found.speed[j] == pytest.approx(amounts.impacts["speed"].max(), rel=1e-8)
        assert found.multiplier[j] == pytest.approx(abs(motion.multipliers).max(), rel=1e-6)
        assert found.least_speed[j] == pytest.approx(amounts.impacts["speed"].min(), rel=1e-8)
        assert found.least_gap[j] == pytest.approx(
            sampled_gap(motion, amounts), rel=1e-3, abs=1e-4 * clearance
        )
        assert found.amplitude[j] == pytest.approx(motion.A, rel=1e-12)
        tried += 1
    assert tried > 25


def test_figures_with_rest_are_those_of_samples():
    """With accumulation and rest, dense samples of a long simulation are the second calculation."""
    parameters, places = random_systems(30, 5, (0.05, 0.2))
    found = perform(parameters, places)
    rests = 0
    for j in np.flatnonzero(found.cycles > 0):
        r, clearance, xi, mu, *walls = map(float, parameters[:, j])
        osc = vi.Oscillator(xi=xi, mu=mu, restitution=tuple(walls))
        state = dict(
            zip(("t", "x", "x_dot", "z", "z_dot"), map(float, found.states[:, j]), strict=True)
        )
        run = vi.simulate(osc, r, clearance, cycles=int(found.cycles[j]) + 1, state=state)
        rests += bool((run.events["kind"] == "stick").any())
        begin = state["t"]
        times = np.linspace(begin, begin + 2 * math.pi / r * found.cycles[j], 20001)
        sample = run.sample(times)
        for name, values in (
            ("displacement", sample.X), ("acceleration", sample.X_ddot),
            ("force", sample.X + 2 * xi * sample.X_dot),
        ):  # fmt: skip
            # samples miss the tip of an extreme by the square of their distance, and a jump by that distance
            assert abs(values).max() == pytest.approx(getattr(found, name)[j], rel=2e-3)
        assert found.rms[j] == pytest.approx(math.sqrt(np.mean(sample.X[:-1] ** 2)), rel=1e-3)
    assert rests > 3


def test_motions_without_impacts_have_the_amplitude_of_linear_theory():
    parameters, places = random_systems(4, 1, (0.5, 0.8))
    parameters[1] = 1e6
    parameters[2, 0] = 1e-3
    found = perform(parameters, 0 * places)
    assert (found.impacts == 0).all()
    np.testing.assert_allclose(found.displacement, found.amplitude, rtol=2e-4)
    # for any settling time: without impacts a motion has settled when damping has ended the transient
    early = perform(parameters, 0 * places, settling=16)
    np.testing.assert_allclose(early.displacement, found.amplitude, rtol=2e-4)
    np.testing.assert_allclose(found.rms, found.amplitude / math.sqrt(2), rtol=2e-4)
    np.testing.assert_allclose(found.acceleration, parameters[0] ** 2 * found.amplitude, rtol=2e-4)
    assert np.isnan(found.multiplier).all()


def test_figures_do_not_depend_on_the_number_of_threads():
    parameters, places = random_systems(40, 8, (0.1, 0.9))
    one, three = perform(parameters, places, threads=1), perform(parameters, places, threads=3)
    for name in ("displacement", "rms", "force", "states", "cycles", "status"):
        np.testing.assert_array_equal(getattr(one, name), getattr(three, name))


def test_runs_are_as_each_of_them_alone():
    """Runs with the r and xi of the previous run reuse its tables; only D, mu and R differ."""
    parameters, places = random_systems(16, 4, (0.1, 0.9))
    parameters[[0, 2], 8:] = parameters[[0, 2], 7:8]
    whole = perform(parameters, places, 100, 8, threads=1)
    for j in range(16):
        alone = perform(parameters[:, j : j + 1], places[:, j : j + 1], 100, 8)
        for name in (*FIGURES, "cycles", "impacts", "status"):
            np.testing.assert_array_equal(getattr(whole, name)[j], getattr(alone, name)[0])
        np.testing.assert_array_equal(whole.states[:, j], alone.states[:, 0])


def test_runs_of_one_system_share_its_motions():
    """A run that approaches a motion of a previous run takes its figures, equal to its own but for rounding."""
    systems, places = random_systems(48, 6, (0.3, 0.9))
    whole = perform(np.repeat(systems, 4, axis=1)[:, :48], places, 200, 8)
    shared = 0
    for j in range(48):
        alone = perform(systems[:, j // 4, None], places[:, j : j + 1], 200, 8)
        assert whole.status[j] == alone.status[0]
        if alone.cycles[0] == 0:
            continue
        assert (whole.cycles[j], whole.impacts[j]) == (alone.cycles[0], alone.impacts[0])
        for name in FIGURES:
            one, other = getattr(whole, name)[j], getattr(alone, name)[0]
            assert one == pytest.approx(other, rel=1e-7 if name == "multiplier" else 1e-9)
        np.testing.assert_allclose(whole.states[:, j], alone.states[:, 0], rtol=1e-8)
        shared += j % 4 > 0 and any(
            np.array_equal(whole.states[:, j], whole.states[:, i]) for i in range(j - j % 4, j)
        )
    assert shared > 5


def test_some_figures_are_as_with_all_others():
    parameters, places = random_systems(30, 5, (0.0, 0.9))
    whole = perform(parameters, places, 100, 8)
    for wanted in (("displacement", "amplitude"), ("rms",), ("least_gap", "speed"), ()):
        some = perform(parameters, places, 100, 8, wanted=wanted)
        for name in FIGURES:
            same = getattr(whole, name) if name in wanted else np.full(30, math.nan)
            np.testing.assert_array_equal(getattr(some, name), same)
        for name in ("states", "cycles", "impacts", "status"):
            np.testing.assert_array_equal(getattr(some, name), getattr(whole, name))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["least_speed", "least_gap"])
def test_distances_to_boundaries_have_limits(name):
    """For lower limits the excess is the limit over the least figure, scaled by the load of each unit."""
    host = OscillatorHost(OSC, None, "displacement", {name: 2.0}, 200, 16, None)
    values = {"clearance": np.array([8.0, 20.0, 30.0, 1e6])}
    load, r = np.array([0.5, 1.0, 2.0, 1.0]), np.full(4, 1.01)
    places = np.random.default_rng(2).uniform(-1, 1, (4, 4))
    found = host.outcome(values, r, load, places, None, "")
    system = np.array(
        [r, values["clearance"] / load, *np.tile([[0.0114], [0.028], [0.75], [0.75]], 4)]
    )
    one = perform(system, places, 200, 16)
    assert (one.impacts[:3] > 0).all()
    np.testing.assert_allclose(found.excess, 2.0 / (getattr(one, name) * load))
    # without impacts no approach speed is too low
    assert one.least_speed[3] == math.inf
    rest = np.array([[1.0], [20.0], [0.0114], [0.028], [0.1], [0.1]])
    resting = perform(rest, places[:, :1])
    run = vi.simulate(
        vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.1), 1.0, 20.0, cycles=20, discard=600
    )
    assert (run.events["kind"] == "stick").any()
    assert getattr(resting, name)[0] == 0
    best = vi.design(OSC, r=1.0, free={"clearance": (20, 45)}, limits={name: 1.0}, **QUICK)
    chosen = np.array([1.0, best.values["clearance"], 0.0114, 0.028, 0.75, 0.75])[:, None]
    assert best.excess <= 1.0
    assert getattr(perform(np.tile(chosen, 4), places, 200, 16), name).min() >= 1.0
    kept = vi.limit_probability(OSC, 1.0, best.values["clearance"], {}, {name: 1.0}, samples=10)
    assert kept.probability == 1
    assert ">= 1" in repr(kept)
    never = vi.limit_probability(OSC, 1.0, best.values["clearance"], {}, {name: 1e3}, samples=10)
    assert never.probability == 0
