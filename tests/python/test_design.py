"""Designs: figures against exact motions, the search against brute force, shares against binomial laws."""

import math
import sys

import numpy as np
import pytest
import vibroimpact as vi
from scipy import stats
from vibroimpact.design_hosts import DecayHost, StructureHost, extent
from vibroimpact.design_problem import OscillatorHost, Problem
from vibroimpact.design_search import grid, judged
from vibroimpact.distribution import interval, uncertain
from vibroimpact.performance import perform
from vibroimpact.studies.design import asked_by

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
FEW = {"samples": 0, "evaluations": 16, "specimens": 4, "nodes": 3}
QUICK = FEW | {"settling": 120, "keep": 16}


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
    # the samples beside an impact
    near = 2 * amounts.impacts["speed"].max() * times[1]
    return gaps[gaps > near].min(initial=math.inf)


def test_figures_are_those_of_exact_motions():
    """Two routes: the closed form of the core over a period, and `quantities` of the exact motion."""
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
    """With accumulation and rest the second route is dense samples of a long simulation."""
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
    np.testing.assert_allclose(found.rms, found.amplitude / math.sqrt(2), rtol=2e-4)
    np.testing.assert_allclose(found.acceleration, parameters[0] ** 2 * found.amplitude, rtol=2e-4)
    assert np.isnan(found.multiplier).all()


def test_results_do_not_depend_on_the_number_of_threads():
    parameters, places = random_systems(40, 8, (0.1, 0.9))
    one, three = perform(parameters, places, threads=1), perform(parameters, places, threads=3)
    for name in ("displacement", "rms", "force", "states", "cycles", "status"):
        np.testing.assert_array_equal(getattr(one, name), getattr(three, name))
    kwargs = {
        "r": (1.0, 1.02),
        "free": {"clearance": (20, 45)},
        "limit": 0.5,
        **QUICK,
        "samples": 100,
    }
    assert repr(vi.design(OSC, threads=1, **kwargs)) == repr(vi.design(OSC, threads=3, **kwargs))


def test_the_search_is_as_good_as_brute_force():
    """A grid of clearances, judged by `response`, another study: no clearance is better by more than 1 %."""
    band = (1.0, 1.03)
    found = vi.design(
        OSC,
        r=band,
        free={"clearance": (12, 40)},
        **{**QUICK, "specimens": 1, "nodes": 7, "evaluations": 40},
    )
    nodes = np.linspace(*band, 7)

    def level(clearance):
        swept = vi.response(OSC, nodes, clearance=float(clearance), states=6, settling=200)
        return swept.highest.max()

    brute = min(level(clearance) for clearance in np.linspace(12, 40, 57))
    # few initial states may miss an attractor, so that its own level is only a lower bound
    assert found.level <= 1.01 * brute
    assert level(found.values["clearance"]) <= 1.05 * brute


def test_the_best_motion_at_resonance_is_equispaced():
    """Section 4 of the paper: at r = 1 with equal coefficients of restitution."""
    found = vi.design(
        OSC, r=1.0, free={"clearance": (5, 78)}, **{**QUICK, "specimens": 1, "evaluations": 60}
    )
    motions = [
        one for one in vi.find(OSC, r=1.0, clearance=found.values["clearance"]) if one.stable
    ]
    best = min(motions, key=lambda one: one.attenuation)
    assert best.attenuation == pytest.approx(found.level, rel=1e-6)
    assert best.pattern == vi.Pattern("RL", 1)
    gap = np.diff(best.phases)[0]
    assert gap == pytest.approx(math.pi, abs=1e-9)
    # no equispaced motion at another clearance is better
    others = [
        one.attenuation for clearance in np.linspace(5, 78, 300)
        for one in vi.equispaced(OSC, 1.0, clearance) if one.stable and one.admissible
    ]  # fmt: skip
    assert found.level <= min(others) * (1 + 1e-3)


def test_just_below_resonance_is_dangerous():
    """Section 5 of the paper: there the impacts increase the motion, so that no clearance keeps max|X| below A."""
    found = vi.design(
        OSC, r=(0.965, 0.975), free={"clearance": (10, 60)}, limit=1.0, **{**QUICK, "samples": 500}
    )
    assert found.level > 1
    assert found.feasible is False
    assert "was not reached by any candidate" in found.verdict


def test_without_scipy_the_extra_is_named(monkeypatch):
    """The error says how to install what is missing."""
    for name in ("scipy", "scipy.optimize", "scipy.stats"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(vi.MissingExtraError, match=r"pip install 'vibroimpact\[design\]'"):
        vi.design(OSC, r=(1.0, 1.02), free={"clearance": (20, 40)}, **QUICK)


def test_quantile_and_penalty_of_candidates():
    """Levels against a plain loop over units and frequencies."""
    host = OscillatorHost(OSC, None, "displacement", {"speed": 30.0}, 120, 16, None)
    spread = {"restitution": uncertain((0.6, 0.8), "R"), "clearance": uncertain((-1, 1), "d")}
    problem = Problem(
        host,
        {"clearance": (20, 40)},
        spread,
        (1.0, 1.02),
        uncertain((0.8, 1.2), "load"),
        0.75,
        False,
        True,
    )
    few = grid(problem, 5, 3, 2, 4)
    nominal, level, over, _ = judged(problem, few, np.array([[25.0], [35.0]]))
    for i, clearance in enumerate((25.0, 35.0)):
        table = np.empty((3, 5, 2, 2))
        for a, r in enumerate(few.nodes):
            for b in range(5):
                restitution, off, load = (
                    0.6 + 0.2 * few.shares[0, b],
                    2 * few.shares[1, b] - 1,
                    few.shares[2, b],
                )
                load = 0.8 + 0.4 * load
                row = [r, (clearance + off) / load, OSC.xi, OSC.mu, restitution, restitution]
                one = perform(np.tile(np.array(row)[:, None], 2), few.places, 120, 16)
                table[a, b] = np.stack([one.displacement * load, one.speed * load / 30], axis=1)
        worst = np.sort(table.max(axis=2), axis=1)
        # the 0.75 quantile of five is the fourth
        target, excess = worst[:, 3, 0].max(), worst[:, 3, 1].max()
        assert over[i] == pytest.approx(excess, rel=1e-12)
        assert level[i] == pytest.approx(target * (1 + 10 * max(0, excess - 1)), rel=1e-12)
        first = table[:, 0].max(axis=1).max(axis=0)
        assert nominal[i] == pytest.approx(first[0] * (1 + 10 * max(0, first[1] - 1)), rel=1e-12)


def test_limits_hold_for_the_design():
    kwargs = {
        "r": (1.0, 1.02),
        "free": {"clearance": (12, 45)},
        **{**QUICK, "evaluations": 32, "specimens": 2},
    }
    free = vi.design(OSC, target="displacement", **kwargs)
    assert free.excess == 0
    parameters = np.tile([[1.0], [free.values["clearance"]], [OSC.xi], [OSC.mu], [0.75], [0.75]], 4)
    speed = perform(parameters, np.random.default_rng(1).uniform(-1, 1, (4, 4))).speed.max()
    bound = vi.design(OSC, target="displacement", limits={"speed": 0.7 * speed}, **kwargs)
    assert bound.excess <= 1.0
    assert bound.level >= free.level
    none = vi.design(OSC, target="displacement", limits={"speed": 1e-3}, **kwargs)
    assert none.excess > 1
    assert "no candidate meets all limits" in none.verdict


@pytest.mark.parametrize("name", ["least_speed", "least_gap"])
def test_distances_to_boundaries_have_limits(name):
    """Least allowed figures: the excess is the limit over the least figure, that of the units over the load."""
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


def test_probability_is_that_of_a_known_share():
    """One uncertain parameter that matters in a known way: without impacts max|X| is the load times A."""
    osc = vi.Oscillator(xi=0.2, mu=1e-9, restitution=0.75)
    found = vi.design(
        osc, r=2.0, free={"clearance": (5, 6)}, load=(0.5, 1.5), target="displacement", quantile=0.5,
        limit=1.2 * 1 / math.hypot(1 - 4, 2 * 0.2 * 2), **{**QUICK, "samples": 4000, "states": 1},
    )  # fmt: skip
    # loads up to 1.2 of 0.5 to 1.5 meet the limit
    low, high = interval(round(0.7 * 4000), 4000, 0.9999)
    assert low < found.probability < high
    assert found.feasible is True
    assert found.interval[0] < found.probability < found.interval[1]
    assert found.bands["samples"].sum() == found.samples == 4000
    again = found.confirm(4000, seed=1)
    assert again.to_json() == found.to_json()
    assert found.confirm(4000, seed=2).probability != found.probability


@pytest.mark.parametrize(("good", "samples"), [(0, 10), (3, 10), (10, 10), (990, 1000)])
def test_interval_is_that_of_scipy(good, samples):
    """Clopper and Pearson, as in scipy.stats.binomtest."""
    expected = stats.binomtest(good, samples).proportion_ci(0.95, method="exact")
    assert interval(good, samples) == pytest.approx((expected.low, expected.high), abs=1e-12)


def test_distributions_of_scipy_and_deviations():
    tolerance = {"restitution": stats.norm(0.7, 0.02), "clearance": (-0.5, 0.5), "xi": 0.0114}
    found = vi.design(
        OSC,
        r=(1.0, 1.01),
        free={"clearance": (20, 40)},
        tolerance=tolerance,
        limit=0.9,
        **{**QUICK, "samples": 300},
    )
    problem, _ = asked_by(OSC, found.keys)
    values, load = problem.units(
        np.array([30.0]), np.array([[0.0, 1.0], [0.5, 0.5], [0.5, 0.9], [0.1, 0.2]])
    )
    np.testing.assert_allclose(values["clearance"], [29.5, 30.5])
    np.testing.assert_allclose(values["restitution"], stats.norm(0.7, 0.02).ppf([0.5, 0.9]))
    np.testing.assert_allclose(values["xi"], 0.0114)
    np.testing.assert_allclose(load, 1)
    assert found.samples == 300


def test_slopes_are_those_of_differences():
    """Derivatives of the exact motion, at a load that is not 1, against differences of the simulation's
    figures."""
    place = np.array([0.3, -0.2, 0.5, 0.1])
    for target, r, load in (("attenuation", 1.01, 1.3), ("displacement", 1.02, 0.7)):
        host = OscillatorHost(OSC, None, target, {}, 200, 32, None)
        values = {"clearance": 30.0, "restitution": 0.7, "mu": 0.03}
        slopes = host.slopes(values, r, load, place)

        def figure(host=host, r=r, load=load, **change):
            columns = {name: np.array([value]) for name, value in change.items()}
            return host.outcome(
                columns, np.array([r]), np.array([load]), place[:, None], None, ""
            ).target[0]

        for name, value in values.items():
            h = 1e-4 * value
            up, down = (figure(**{**values, name: value + step}) for step in (h, -h))
            assert slopes[name] == pytest.approx((up - down) / (2 * h), rel=1e-5)


def test_steps_down_the_gradient_lower_the_level():
    """A start near the best clearance: the steps reach the lower end of a range in which the level only rises."""
    kwargs = {**QUICK, "specimens": 1, "nodes": 2, "evaluations": 8}
    found = vi.design(OSC, r=1.0, free={"clearance": (50.0, 60.0)}, **kwargs)
    coarse = [row["level"] for row in found.front]
    assert min(coarse) == found.level
    assert found.values["clearance"] > 59.0
    assert found.sensitivity["clearance"] < 0
    assert found.sensitivity.keys() >= {"clearance", "mu", "xi", "r"}


def test_the_oscillator_as_a_structure_has_the_same_figures():
    """Two routes: the kernel of the oscillator, and samples of the structure with cubics between them."""
    osc = vi.Oscillator(xi=0.02, mu=0.05, restitution=0.7)

    def build(r, load, clearance):
        return osc.structure(clearance), vi.Load(r, sine=[load, 0])

    values = {"clearance": np.array([10.0, 20.0, 30.0])}
    r, load = np.array([1.0, 1.01, 1.02]), np.array([1.0, 0.8, 1.2])
    places = np.random.default_rng(0).uniform(-1, 1, (4, 3))
    for target in ("attenuation", "displacement", "rms"):
        one = StructureHost(build, 0, target, {"speed": 20.0}, 400, 6, None)
        other = OscillatorHost(osc, None, target, {"speed": 20.0}, 400, 6, None)
        found, expected = (host.outcome(values, r, load, places, None, "") for host in (one, other))
        np.testing.assert_allclose(found.target, expected.target, rtol=2e-3)
        np.testing.assert_allclose(found.excess, expected.excess, rtol=2e-3)


def test_extent_of_a_harmonic_motion():
    """Fourth order: with half the step the error falls sixteen times."""
    free = vi.Structure([1.0], [0.0], [1.0], gaps=[])
    run = vi.simulate(free, duration=20.0, state=([0.3], [1.0]))
    amplitude = math.hypot(0.3, 1.0)
    errors = [abs(extent(run, 2.0, many, 0)[1] / amplitude - 1) for many in (40, 80)]
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] > 8
    times = np.linspace(2, 20, 100_001)
    square = np.mean(run.sample(times)[0] ** 2)
    assert extent(run, 2.0, 400, 0)[2] == pytest.approx(math.sqrt(square), rel=1e-5)


def test_design_of_a_structure_chooses_the_number_of_units():
    """More free masses reduce the motion: the search chooses the largest number that is offered."""

    def build(r, load, units, clearance):
        n, mu = 1 + units, 0.02
        gaps = []
        for i in range(1, n):
            direction = np.zeros(n)
            direction[[0, i]] = -1, 1
            # unlike clearances, since equal units would end in step, with coupled impacts at one instant
            half = 0.5 * clearance * (1 + 0.2 * i)
            gaps += [vi.Gap(direction, half, 0.7), vi.Gap(-direction, half, 0.7)]
        host = np.zeros((n, n))
        host[0, 0] = 1
        damping = 0.04 * host
        sine = np.zeros(n)
        sine[0] = load
        return vi.Structure(np.diag([1.0, *[mu] * units]), damping, host, gaps), vi.Load(
            r, sine=sine
        )

    found = vi.design(
        build, r=(1.0, 1.01), free={"units": range(1, 4), "clearance": (5.0, 20.0)}, samples=40, evaluations=16,
        specimens=1, nodes=2, states=1, settling=60, keep=4, limit=0.9,
    )  # fmt: skip
    assert found.values["units"] == 3
    assert found.level < 0.6
    assert found.samples == 40
    assert found.probability > 0.9


def test_damping_of_free_decay_is_a_target():
    """The target against `decay` itself, on a grid of clearances."""
    osc = vi.Oscillator(xi=0.005, mu=0.1, restitution=0.75)
    host = DecayHost(osc, None, 5, None)
    clearances = np.array([0.3, 0.7, 1.5, 6.0])
    found = host.outcome(
        {"clearance": clearances}, np.ones(4), np.ones(4), np.zeros((4, 4)), None, ""
    )
    runs = vi.decay(osc, clearances, cycles=5)
    for i in range(4):
        peaks = runs.x[runs.run == i]
        decrement = math.log(peaks[0] / peaks[10]) / 5
        assert -found.target[i] == pytest.approx(
            decrement / math.hypot(2 * math.pi, decrement), rel=1e-12
        )
    assert -found.target[3] == pytest.approx(0.005, rel=1e-9)
    best = vi.design(
        osc,
        target="damping",
        amplitude=1.0,
        free={"clearance": (0.2, 2.0)},
        **{**FEW, "evaluations": 40, "specimens": 1},
    )
    grid_of = np.linspace(0.2, 2.0, 60)
    levels = host.outcome(
        {"clearance": grid_of}, np.ones(60), np.ones(60), np.zeros((4, 60)), None, ""
    )
    assert best.level > 0.9 * -levels.target.min() * 0.8


#: Arguments without a meaning for free vibration, at their defaults.
FREE = {"load": 1.0, "settling": 400, "keep": 32}
GOOD = {"r": (1.0, 1.02), "free": {"clearance": (20, 45)}}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"r": (1.02, 1.0)},
            "r = 1.02, 1.0: must be one frequency ratio, or the lowest and the highest one",
        ),
        ({"r": (0, 1)}, "r = 0"),
        ({"r": "1"}, "r = '1'"),
        ({"r": (1, math.nan)}, "r = "),
        ({"free": {}}, "free = {}"),
        ({"free": {"gap": (1, 2)}}, "unknown parameter 'gap'"),
        (
            {"free": {"clearance": 20}},
            r"free\['clearance'\] = 20.0: must be two numbers from 1e-12 to 1e12",
        ),
        ({"free": {"clearance": (-1, 2)}}, r"free\['clearance'\] = -1.0, 2.0: must be two numbers"),
        ({"free": 3}, "free = 3: must be a dict"),
        (
            {"free": {"restitution": (0.5, 0.6), "R1": (0.5, 0.6)}, "clearance": 20.0},
            "must be left out beside",
        ),
        (
            {"tolerance": {"clearance": (-30, 0)}},
            r"tolerance\['clearance'\] = -30.0, 0.0: .* in the range of clearance",
        ),
        (
            {"tolerance": {"restitution": (0.9, 1.2)}},
            r"tolerance\['restitution'\] = 0.9, 1.2: .* in the range",
        ),
        (
            {
                "free": {"R1": (0.3, 0.9)},
                "tolerance": {"restitution": (0.5, 0.7)},
                "clearance": 20.0,
            },
            r"free\['R1'\] = 0.3, 0.9: must be left out beside tolerance_restitution",
        ),
        (
            {
                "free": {"restitution": (0.3, 0.9)},
                "tolerance": {"R2": (0.5, 0.7)},
                "clearance": 20.0,
            },
            r"tolerance\['R2'\] = 0.5, 0.7: must be left out beside free_restitution",
        ),
        (
            {"target": "damping", "r": None, "amplitude": 1.0, "limits": {"speed": 1.0}, **FREE},
            r"limits\['speed'\] = 1.0: must be left out beside amplitude",
        ),
        *(
            (
                {"target": "damping", "r": None, "amplitude": 1.0, **FREE, name: value},
                rf"{name} = .*: must be left out beside amplitude",
            )
            for name, value in (("load", (0.5, 2.0)), ("settling", 300), ("keep", 5))
        ),
        ({"cycles": 6}, "cycles = 6: must be left out: it goes with amplitude"),
        *(
            (
                {"tolerance": {"clearance": values}},
                r"tolerance\['clearance'\] = .*deviations with 0 among",
            )
            for values in (
                (0.5, 0.9),
                (1.1, 1.2),
                (-2, -1),
                stats.norm(1.0, 0.2),
                stats.norm(0.5, 0.2),
            )
        ),
        ({"tolerance": {"xi": (0.0, 0.01)}}, "without damping r = 1 is resonance"),
        ({"progress": 3}, "progress = 3: must be None or callable"),
        ({"tolerance": {"xi": (0.02, 0.01)}}, "low <= high"),
        ({"tolerance": {"xi": stats.norm(0.01, 0.01)}}, "6 standard deviations"),
        ({"clearance": 20.0}, "clearance = 20.0: must be left out beside free"),
        ({"free": {"mu": (0.02, 0.1)}}, "clearance: is missing"),
        ({"amplitude": 1.0}, "must be left out beside"),
        ({"target": "damping"}, "needs an amplitude"),
        ({"load": 0}, "load = 0"),
        ({"target": "noise"}, "target = 'noise'"),
        ({"over": "all"}, "over = 'all'"),
        ({"quantile": 0.2}, "quantile = 0.2"),
        ({"quantile": math.nan}, "quantile = nan"),
        ({"limit": -1}, "limit = -1"),
        ({"limits": {"noise": 1}}, "noise"),
        ({"limits": {"speed": math.inf}}, r"limits\['speed'\] = inf"),
        ({"states": 0}, "states = 0"),
        ({"samples": 5}, "samples = 5"),
        ({"evaluations": 1.5}, "evaluations = 1.5"),
        ({"seed": -1}, "seed = -1"),
        ({"nodes": 1}, "nodes = 1"),
    ],
)
def test_bad_arguments_are_refused(change, message):
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.design(OSC, **{**GOOD, **QUICK, **change})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"amplitude": 1.0}, "amplitude = 1.0: must be left out for a function"),
        ({"cycles": 7}, "cycles = 7: must be left out for a function"),
        ({"tolerance": {"clearance": (1.5, 2.0)}}, "deviations with 0 among them"),
        ({"tolerance": {"clearance": stats.norm(1, 0.2)}}, "if normal, of mean 0 or 1"),
    ],
)
def test_bad_arguments_for_a_structure_are_refused(change, message):
    with pytest.raises(vi.ParameterError, match=message):
        vi.design(lambda r, load, clearance: None, **{**GOOD, **QUICK, **change})


def test_a_tolerance_of_a_chosen_value_is_a_deviation_or_a_factor():
    """Around a clearance of 20, -1 to 1 and 0.95 to 1.05 are the same units, with the same levels."""
    host = OscillatorHost(OSC, None, "attenuation", {}, 120, 16, None)
    shares = np.array([[0.0, 0.3, 1.0], [0.5, 0.5, 0.5]])
    found = []
    for spread in ((-1, 1), (0.95, 1.05)):
        tolerance = {"clearance": uncertain(spread, "clearance")}
        ends = {"clearance": (10.0, 40.0)}
        problem = Problem(host, ends, tolerance, (1.0, 1.0), uncertain(1.0, "load"), 1.0, False)
        found.append(problem.units(np.array([20.0]), shares)[0]["clearance"])
    np.testing.assert_allclose(found[0], [19, 19.6, 21], rtol=1e-14)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-14)
    for spread in ((-1, 1), (0.95, 1.05), stats.norm(0, 0.1), stats.norm(1, 0.01)):
        made = vi.design(OSC, **GOOD, **QUICK, tolerance={"clearance": spread})
        least, middle, greatest = made.spread["clearance"]
        assert least < middle < greatest
        assert middle == pytest.approx(made.values["clearance"], rel=1e-12)


def test_a_report_is_written_completely_or_not_at_all(tmp_path):
    pytest.importorskip("matplotlib")
    found = vi.design(OSC, **GOOD, **QUICK)
    for place, message in (
        (tmp_path / "there" / "r.pdf", "r.pdf': must be in a folder that is there"),
        (tmp_path / "r.docx", "r.docx': must end with one of .pdf, .png, .svg"),
    ):
        with pytest.raises(vi.ParameterError, match=message):
            found.report(place)
    (tmp_path / "r.pdf").mkdir()
    with pytest.raises(OSError, match=r"r\.pdf"):
        found.report(tmp_path / "r.pdf")
    found.report(tmp_path / "r.svg")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["r.pdf", "r.svg"]


def test_a_design_is_converted_to_physical_units(tmp_path):
    """Clearances and figures of the target have units, whatever else is chosen; derivatives have none."""
    rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, C=7.6, m=0.11, restitution=0.7, F0=6.0)
    length = rig.units().length
    found = vi.design(
        rig, r=(1.0, 1.02), free={"clearance": (20, 40), "mu": (0.03, 0.05)}, target="displacement",
        **QUICK, limit=9.0,
    )  # fmt: skip
    assert found.osc == rig
    shown = found.physical("mm N s")
    mm = 1000 * length
    assert shown.values == pytest.approx(
        {"clearance": mm * found.values["clearance"], "mu": found.values["mu"]}
    )
    assert shown.limit == pytest.approx(9 * mm)
    assert shown.level == pytest.approx(found.level * mm)
    np.testing.assert_allclose(shown.candidates["nominal"], found.candidates["nominal"] * mm)
    assert shown.bands.keys() == found.bands.keys()
    with pytest.raises(AttributeError, match="sensitivity"):
        _ = shown.sensitivity
    pytest.importorskip("xarray")
    np.testing.assert_allclose(shown.to_xarray()["value"], list(shown.values.values()))
    np.testing.assert_allclose(shown.to_pandas()["value"], list(shown.values.values()))
    pytest.importorskip("matplotlib")
    from vibroimpact.plot.design import _lines

    assert any(
        f"d = {length * found.values['clearance']:.5g} m from wall to wall" in line
        for line in _lines(found)
    )
    assert "(mm)" in shown.plot()[0].get_xlabel()


def test_errors_of_a_host_are_its_own():
    """SciPy replaces errors of values and types that a function raises; the caller sees the first one."""
    with pytest.raises(vi.ParameterTypeError, match="host returned 3"):
        vi.design(lambda r, load, clearance: 3, **GOOD, **QUICK)
    with pytest.raises(TypeError, match="unexpected keyword argument 'clearance'"):
        vi.design(lambda r, load: 3, **GOOD, **QUICK)


def test_parts_of_a_band_without_samples_have_no_share():
    """Ten samples leave parts of the band empty; the answer is said of one that has some."""
    found = vi.design(OSC, **GOOD, **QUICK | {"samples": 10}, limit=5.0)
    empty = found.bands["samples"] == 0
    assert empty.any()
    assert np.isnan(found.bands["probability"][empty]).all()
    assert found.probability == 1
    assert "weakest part of the band: 100 % (" in found.verdict
    assert found.feasible is None


def levels_of(clearance, right, left):
    """The greatest max|X|/A over the attractors that 12 states reach at r = 1, load cycles, impacts; (n,) each."""
    columns = np.broadcast_arrays([1.0], clearance, OSC.xi, OSC.mu, right, left)
    n = columns[0].size
    places = np.random.default_rng(0).uniform(-1, 1, (4, 12 * n))
    found = perform(np.repeat(np.array(columns), 12, axis=1), places, 300)
    assert (found.status == 0).all()
    level = (found.displacement / found.amplitude).reshape(n, 12).max(axis=1)
    return level, found.cycles.reshape(n, 12), found.impacts.reshape(n, 12)


@pytest.mark.parametrize("middle", [0.6, 0.68, 0.75])
@pytest.mark.parametrize("clearance", [50.0, 60.0, 70.0, 78.0])
def test_equal_restitution_is_best_where_the_motion_is_equispaced(middle, clearance):
    """Section 4 of the paper: at r = 1, among coefficients with one mean, or with one product."""
    off = np.array([0, 0.01, 0.03, 0.06, 0.1])
    factors = np.exp(off / middle)
    for right, left in ((middle - off, middle + off), (middle / factors, middle * factors)):
        level, cycles, impacts = levels_of(clearance, right, left)
        assert (np.diff(level) > 0).all()
        assert (cycles[0] == 1).all()
        assert (impacts[0] == 2).all()
    osc = vi.Oscillator(xi=OSC.xi, mu=OSC.mu, restitution=middle)
    equispaced = [one for one in vi.equispaced(osc, 1.0, clearance) if one.stable]
    assert min(one.attenuation for one in equispaced) == pytest.approx(level[0], rel=1e-9)


def test_equal_restitution_is_not_best_elsewhere():
    """Without a stable equispaced motion, and where the other wall has less restitution than both equal ones."""
    for right, left in ((0.575, 0.775), (0.675 * 0.86, 0.675 / 0.86)):
        unequal, cycles, impacts = levels_of(40.0, right, left)
        assert unequal[0] < 0.85 * levels_of(40.0, 0.675, 0.675)[0][0]
        assert (cycles == 1).all()
        assert (impacts == 3).all()
    osc = vi.Oscillator(xi=OSC.xi, mu=OSC.mu, restitution=0.675)
    assert not any(one.stable and one.admissible for one in vi.equispaced(osc, 1.0, 40.0))
    # the pairs of Figure 10: equal ones are better at most clearances, not at all of them
    clearances = np.array([50.0, 56.0, 62.0, 70.0, 78.0])
    equal, unequal = (levels_of(clearances, other, 0.75)[0] for other in (0.75, 0.61))
    assert (equal < unequal).tolist() == [True, True, False, True, True]


def test_the_search_chooses_equal_restitution():
    """With the clearance free too, the least max|X|/A belongs to the greatest and equal coefficients."""
    kwargs = {**QUICK, "specimens": 1, "evaluations": 72}
    free = {"clearance": (20, 78), "R1": (0.6, 0.75), "R2": (0.6, 0.75)}
    found = vi.design(OSC, r=1.0, free=free, **kwargs)
    assert found.values == pytest.approx({"clearance": 78, "R1": 0.75, "R2": 0.75}, rel=1e-6)


def test_over_basins_each_attractor_counts_by_its_share():
    """Two attractors with different max|X|/A, and a limit between them: the shares are those of `basins`."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    r, clearance, limit, many = 0.93725, 31.402, 1.78, 4000
    seen = vi.basins(osc, r, clearance, states=many)
    levels = np.array([one.motion.attenuation for one in seen.attractors])
    share = seen.fractions[levels <= limit].sum()
    assert 0.6 < share < 0.7
    assert seen.fractions.sum() == pytest.approx(1)
    kwargs = {
        "r": r,
        "free": {"clearance": (clearance - 1e-6, clearance + 1e-6)},
        "limit": limit,
    } | FEW
    kwargs |= {"specimens": 1, "evaluations": 8, "samples": many}
    for over, states, expected in (
        ("basins", 3, share),
        ("worst", 1, share),
        ("worst", 3, share**3),
    ):
        found = vi.design(osc, over=over, states=states, quantile=0.5, **kwargs)
        # the difference of two shares of independent samples, 5 times its standard error
        assert found.probability == pytest.approx(expected, abs=0.05)
    # the level of the search is a quantile of the states: of either attractor, beside the share of the lower
    kwargs |= {"samples": 0, "states": 64}
    quantiles = 0.5, 0.9
    lower, upper = (vi.design(osc, over="basins", quantile=q, **kwargs).level for q in quantiles)
    assert lower == pytest.approx(levels[levels <= limit].min(), rel=1e-4)
    assert upper == pytest.approx(levels[levels > limit].max(), rel=1e-4)
