"""Shares of units that meet a limit, and their intervals, compared with binomial laws, known shares and basins."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from scipy import stats
from shared_design import FEW, GOOD, OSC, QUICK
from vibroimpact.designs.design import asked_by
from vibroimpact.designs.problem import OscillatorHost, Problem
from vibroimpact.systems.distribution import interval, uncertain


@pytest.mark.slow
def test_probability_is_that_of_a_known_share():
    """One uncertain parameter with a known effect: without impacts max|X| is the load times A."""
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
    again = found.confirm(4000, rng=1)
    assert again.to_json() == found.to_json()
    assert found.confirm(4000, rng=2).probability != found.probability


@pytest.mark.parametrize(("good", "samples"), [(0, 10), (3, 10), (10, 10), (990, 1000)])
def test_interval_is_that_of_scipy(good, samples):
    """The interval of Clopper and Pearson, as in scipy.stats.binomtest."""
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
        searches=1,
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
        made = vi.design(
            OSC, **GOOD, **QUICK | {"evaluations": 8, "settling": 20},
            tolerance={"clearance": spread}, searches=1,
        )  # fmt: skip
        least, middle, greatest = made.spread["clearance"]
        assert least < middle < greatest
        assert middle == pytest.approx(made.values["clearance"], rel=1e-12)


def test_parts_of_a_band_without_samples_have_no_share():
    """With ten samples, parts of the band are empty; the answer is for a part that has samples."""
    found = vi.design(OSC, **GOOD, **QUICK | {"samples": 10}, limit=5.0, searches=1)
    empty = found.bands["samples"] == 0
    assert empty.any()
    assert np.isnan(found.bands["probability"][empty]).all()
    assert found.probability == 1
    assert "weakest part of the band: 100 % (" in found.verdict
    assert found.feasible is None


@pytest.mark.slow
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
        # the difference of two shares of independent samples, within 5 standard errors
        assert found.probability == pytest.approx(expected, abs=0.05)
    # the level of the search is a quantile of the states: that of either attractor near the share of the lower one
    kwargs |= {"samples": 0, "states": 64}
    quantiles = 0.5, 0.9
    lower, upper = (vi.design(osc, over="basins", quantile=q, **kwargs).level for q in quantiles)
    assert lower == pytest.approx(levels[levels <= limit].min(), rel=1e-4)
    assert upper == pytest.approx(levels[levels > limit].max(), rel=1e-4)


def test_a_later_confirmation_is_the_same():
    """Without samples the same few samples check the chosen values; a confirmation may follow later."""
    kwargs = QUICK | {"r": (1.0, 1.02), "free": {"clearance": (20, 45)}, "limit": 0.5, "rng": 3}
    kwargs["searches"] = 1
    at_once = vi.design(OSC, **kwargs | {"samples": 100})
    later = vi.design(OSC, **kwargs | {"samples": 0}).confirm(100, rng=4)
    assert repr(later) == repr(at_once)
