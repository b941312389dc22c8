"""Shares of units that meet a limit, and their intervals, compared with binomial laws, known shares and basins."""

import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from scipy import stats
from shared_design import FEW, GOOD, OSC, QUICK
from vibroimpact.designs import confirmation
from vibroimpact.designs import search as designs_search
from vibroimpact.designs.confirmation import confirmed
from vibroimpact.designs.design import asked_by
from vibroimpact.designs.order import Order
from vibroimpact.designs.pool import Grid, Pool
from vibroimpact.designs.problem import OscillatorHost, Outcome, Problem
from vibroimpact.designs.search import Archive
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


@pytest.mark.slow
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


def test_a_tolerance_of_a_chosen_value_is_a_deviation_or_a_factor(monkeypatch, short):
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
    monkeypatch.setattr(confirmation, "refuted", lambda *_: "")
    for spread in ((-1, 1), (0.95, 1.05), stats.norm(0, 0.1), stats.norm(1, 0.01)):
        made = vi.design(
            OSC, **GOOD, **QUICK | {"evaluations": 8, "settling": 20, "keep": 4, "nodes": 2},
            tolerance={"clearance": spread}, searches=1,
        )  # fmt: skip
        least, middle, greatest = made.spread["clearance"]
        assert least < middle < greatest
        assert middle == pytest.approx(made.values["clearance"], rel=1e-12)


def test_parts_of_a_band_without_samples_have_no_share(short):
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
    kwargs |= {"specimens": 1, "evaluations": 8, "searches": 1, "samples": many}
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


def test_a_later_confirmation_is_the_same(short):
    """Without samples the same few samples check the chosen values; a confirmation may follow later."""
    kwargs = QUICK | {"r": (1.0, 1.02), "free": {"clearance": (20, 45)}, "limit": 0.5, "rng": 3}
    kwargs["searches"] = 1
    at_once = vi.design(OSC, **kwargs | {"samples": 100})
    later = vi.design(OSC, **kwargs | {"samples": 0}).confirm(100, rng=4)
    assert repr(later) == repr(at_once)


#: Near these clearances most units between the frequencies of a search are far above its level.
BETWEEN = {
    "r": (1.0, 1.03), "free": {"clearance": (39.28, 39.3)}, "searches": 1,
    **QUICK, "specimens": 1, "nodes": 7, "evaluations": 8,
}  # fmt: skip


@pytest.mark.slow
def test_searches_whose_level_samples_contradict_are_repeated(monkeypatch):
    """Samples of another seed confirm the level of the repeated searches; if none does, the verdict says so."""
    found = vi.design(OSC, **BETWEEN)
    assert found.contradicted is False
    assert found.converged is None  # a single search
    # within three standard errors of two shares
    assert found.confirm(5000, rng=7).probability > 0.99 - 3 * math.sqrt(2 * 0.01 / 5000)
    with monkeypatch.context() as patch:
        patch.setattr(confirmation, "refuted", lambda *_: "")
        first = vi.design(OSC, **BETWEEN)
        assert first.confirm(1000, rng=7).probability < 0.95
        assert first.level < found.level
        patch.setattr(confirmation, "refuted", lambda *_: "level")
        never = vi.design(OSC, **BETWEEN)
    assert never.contradicted
    assert never.converged is False
    verdict = "; not converged: samples contradict the search; more nodes or states would help"
    assert verdict in never.verdict


#: Searches of few load cycles.
BRIEF = BETWEEN | {"nodes": 2, "settling": 20, "keep": 4}


def test_repeated_searches_judge_candidates_by_the_previous_runs_and_others(monkeypatch, short):
    """No unit, frequency or initial state is dropped: with fewer states, more attractors would not count. All
    searches but the first of a repeated set start from points of their own."""
    grids = []

    def search_again(problem, order, progress, earlier):
        found = designs_search.search(problem, order, progress, earlier)
        grids.extend(each.grid for each in (earlier, found))
        return found

    def start(*args):
        starts.append(even_start(*args))
        return starts[-1]

    starts, even_start = [], designs_search._even_start
    monkeypatch.setattr(designs_search, "_even_start", start)
    monkeypatch.setattr(confirmation, "search", search_again)
    monkeypatch.setattr(confirmation, "refuted", lambda *_: "level")
    for units, options in (1, {}), (2, {"tolerance": {"xi": (0.011, 0.012)}, "specimens": 2}):
        grids.clear()
        starts.clear()
        vi.design(OSC, **{**BRIEF, "searches": 2, **options})
        assert len(grids) == 4
        for one, more in zip(grids[::2], grids[1::2], strict=True):
            assert set(one.nodes) < set(more.nodes)
            np.testing.assert_array_equal(more.shares[:, : one.shares.shape[1]], one.shares)
            np.testing.assert_array_equal(more.places, one.places)
        # two searches, and one in each repeated set, start from different points beside the centre
        assert len({float(each[1, 0]) for each in starts}) == len(starts) == 4
        assert grids[0].places.shape[1] > 2
        assert (units > 1) == (grids[-1].shares.shape[1] == 4 * units)


@pytest.mark.slow
def test_repeated_searches_that_do_not_agree_go_on(monkeypatch, short):
    """As many again, each from points of its own, but only once, and not if samples contradict the level."""

    def start(*args):
        shares = even_start(*args)
        starts.append(float(shares[1, 0]))
        return shares

    starts, even_start = [], designs_search._even_start
    monkeypatch.setattr(designs_search, "_even_start", start)
    monkeypatch.setattr(Archive, "agree", lambda *_: False)
    for worse, searches, begun in (1, 4, 5), (3, 2, 4), (0, 2, 2):
        starts.clear()
        answers = iter(["level"] * worse)
        monkeypatch.setattr(confirmation, "refuted", lambda *_, these=answers: next(these, ""))
        found = vi.design(OSC, **{**BRIEF, "searches": 2})
        assert len(found.searches["level"]) == searches
        assert found.converged is False
        # the first search of a repeated set starts from the best candidates
        assert len(set(starts)) == len(starts) == begun


class Chaotic:
    """A host whose targets depend on the initial state by chance: the share of those above t is t**-10."""

    def __init__(self, rough):
        self.rough = rough
        self.calls_left = math.inf

    def outcome(self, values, r, load, places, progress, note):
        self.calls_left -= 1
        if self.calls_left < 0:
            raise KeyboardInterrupt
        share = 1e5 * (places.sum(axis=0) + values["a"]) % 1
        target = np.maximum(share, 1e-12) ** -0.1
        return Outcome(target if self.rough else np.full(len(r), 1.7), np.zeros(len(r)))

    def slopes(self, values, r, load, place):
        return None


@pytest.mark.slow
@pytest.mark.parametrize("rough", [True, False])
def test_the_best_of_many_uncertain_levels_is_not_too_low(rough):
    """Of 30 equally good candidates, the level of the best one by chance becomes that of many runs."""
    problem = Problem(
        Chaotic(rough), {"a": (0.0, 1.0)}, {}, (1.0, 1.0), uncertain(1.0, "load"), 1.0, False
    )
    places = np.random.default_rng(3).uniform(-1, 1, (4, 200))
    pool = Pool(problem, Grid(np.full((1, 1), 0.5), np.ones(1), places))
    pool.race(pool.add(np.linspace(0, 1, 30)[:, None]), np.inf)
    archive = Archive()
    archive.add(pool)
    before = replace(archive, level=[*archive.level])
    # after Ctrl-C in the midst of it, levels are as they were
    problem.host.calls_left = 3 if rough else 0
    with pytest.raises(KeyboardInterrupt):
        archive.settle(problem)
    assert archive == before
    problem.host.calls_left = math.inf
    # of 200 runs the worst one does not count, nor 0.5 % of the others
    exact = 0.005**-0.1
    assert archive.settle(problem) is rough
    if not rough:
        assert archive == before
        return
    assert before.level[before.best] < 0.95 * exact
    assert archive.level[archive.best] == pytest.approx(exact, rel=0.025)
    assert archive.searches == [(30, archive.level[archive.best])]
    assert all(after >= level for level, after in zip(before.level, archive.level, strict=True))
    assert archive.worst[archive.best] > archive.level[archive.best]
    np.testing.assert_array_equal(archive.targets, pool.target[archive.best])


@pytest.mark.parametrize(("share", "good"), [(0.002, True), (0.02, False)])
def test_a_check_allows_the_share_of_a_quantile(share, good):
    """Of 10,000 samples 1 % may be more than 2 % above the level, wherever they are."""

    class Known:
        def outcome(self, values, r, load, places, progress, note):
            # the same share of the units in every part of the band
            return Outcome(np.where(values["xi"] > 1 - share, 1.03, 1.01), np.zeros(r.shape))

    problem = Problem(
        Known(), {"a": (0.0, 1.0)}, {"xi": uncertain((0.0, 1.0), "xi")}, (1.0, 1.2),
        uncertain(1.0, "load"), 0.99, False,
    )  # fmt: skip
    order = Order("attenuation", None, 8, 1, 1, 2, 1, confirmation.FEW, 0)
    found = "" if good else "level"
    assert confirmation.refuted(problem, order, {"a": 0.5}, 1.0, False) == found
    assert not confirmation.refuted(problem, order, {"a": 0.5}, 1.03, False)
    # rarer attractors than half a per cent do not count
    worst = replace(problem, quantile=1.0)
    assert confirmation.refuted(worst, order, {"a": 0.5}, 1.0, False) == found
    # the limits are those of the design, in each part of the band
    limited = replace(order, limit=1.02)
    found = "" if good else "limits"
    assert confirmation.refuted(problem, limited, {"a": 0.5}, 1.03, True) == found
    assert not confirmation.refuted(problem, limited, {"a": 0.5}, 1.03, False)


@pytest.mark.parametrize(("bad", "found"), [(1, ""), (2, "limits")])
def test_a_structure_is_checked_by_as_many_samples_as_confirm_it(bad, found):
    """Of the few in a part of the band one may be beyond the limits, although one is too large a share."""
    runs = []

    class Structure:
        def outcome(self, values, r, load, places, progress, note):
            runs.append(len(r))
            first = r < np.partition(r, bad)[bad]  # in the first part of the band
            return Outcome(np.where(first, 2.0, 1.0), np.zeros(r.shape))

    problem = Problem(
        Structure(), {"a": (0.0, 1.0)}, {}, (1.0, 1.2), uncertain(1.0, "load"), 0.9, False
    )
    order = Order("attenuation", 1.5, 8, 1, 1, 2, 1, 80, 0)
    assert confirmation.refuted(problem, order, {"a": 0.5}, math.inf, True) == found
    assert runs == [80]
    assert not confirmation.refuted(problem, replace(order, samples=0), {"a": 0.5}, math.inf, True)
    assert runs == [80]


@pytest.mark.slow
def test_samples_beyond_limits_do_not_contradict_a_level(monkeypatch, short):
    """Searches are repeated for them; the confirmation decides on limits. A level of structures is not checked."""

    def search_again(*args):
        sets.append(designs_search.search(*args))
        return sets[-1]

    sets = []
    monkeypatch.setattr(confirmation, "search", search_again)
    monkeypatch.setattr(
        confirmation, "refuted", lambda *arguments: "limits" if arguments[-1] else ""
    )
    for contradicted, options in (False, {}), (None, {"tolerance": {"friction": (0.0, 1e-3)}}):
        sets.clear()
        found = vi.design(OSC, **{**BRIEF, "states": 1, "limit": 20.0, **options})
        assert len(sets) == confirmation.ROUNDS
        assert found.contradicted is contradicted
        assert found.converged is None  # a single search


def test_a_level_with_a_penalty_is_not_checked(monkeypatch, short):
    """Where no candidate meets the limits, the level includes a penalty, and more searches would not help."""
    monkeypatch.setattr(confirmation, "refuted", None)
    found = vi.design(OSC, **{**BETWEEN, "limits": {"speed": 1e-3}})
    assert found.excess > 1
    assert found.contradicted is None
    assert "; no candidate meets all limits: " in found.verdict


def test_samples_show_whether_a_level_without_a_limit_holds(monkeypatch, short):
    """Here the searches are not repeated with more units, and the verdict shows how many samples are worse."""
    monkeypatch.setattr(confirmation, "refuted", lambda *_: "")
    found = vi.design(
        OSC, r=(1.0, 1.03), free={"clearance": (39.28, 39.3)}, searches=1,
        **{**QUICK, "specimens": 1, "nodes": 7, "evaluations": 8, "samples": 200},
    )  # fmt: skip
    assert found.feasible is None
    assert "of the search; " in found.verdict
    assert "are at most 2 % worse; weakest part of the band: " in found.verdict
    assert found.bands["probability"].min() < 0.5
    # a limit at this level is the same question
    problem, order = asked_by(OSC, found.keys | {"limit": 1.02 * found.level})
    same, bands = confirmed(problem, order, found.values, 200, order.seed + 1, None)
    assert same["probability"] == found.probability < 0.99
    np.testing.assert_array_equal(bands["good"], found.bands["good"])
    # with limits of other quantities, the samples refer to these
    limited = vi.design(
        OSC, r=(1.0, 1.03), free={"clearance": (39.28, 39.3)}, searches=1, limits={"displacement": 1e3},
        **{**QUICK, "specimens": 1, "nodes": 2, "evaluations": 8, "samples": 10},
    )  # fmt: skip
    assert "; 100 % of 10 samples " in limited.verdict
    assert " meet all limits; weakest part" in limited.verdict
