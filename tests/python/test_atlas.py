"""Atlases and zones with rest, compared with simulation, which is independent of the tracing of boundaries."""

import json
import threading

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.results.tables import language
from vibroimpact.studies.atlas import OUTCOMES, OUTCOMES_OF_STRUCTURE

EQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
UNEQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))


@pytest.fixture(scope="module")
def atlas():
    return vi.atlas(EQUAL, (0.9, 1.1), (10, 90), max_impacts=4, survey=60)


def attractor(osc, r, clearance, cycles=1):
    """The pattern to which a simulation from rest settles, or None."""
    run = vi.simulate(osc, r, clearance, 2 * cycles + 2, discard=400)
    try:
        period = run.period(cycles)
    except vi.errors.ParameterError:
        return None
    return period.pattern if period.mismatch < 1e-6 else None


def test_simulated_attractors_lie_in_a_zone_of_their_pattern(atlas):
    random = np.random.default_rng(20)
    checked = 0
    for _ in range(150):
        r, clearance = random.uniform(0.9, 1.1), np.exp(random.uniform(*np.log([10, 90])))
        pattern = attractor(EQUAL, r, clearance)
        if pattern is None or len(pattern) > 4:
            continue
        checked += 1
        assert atlas.explains(vi.SurveyPoint(r, clearance, pattern)), (r, clearance, pattern)
    assert checked > 30


@pytest.mark.slow
def test_patterns_with_rest_do_not_depend_on_the_survey():
    """Even without a survey, every attractor of simulations within the limits lies in a zone of its pattern.

    At the first point random states settle on L*R* by an independent simulation (`lane_simulation.py`); its
    zone is 0.016 wide in r there, and a survey of 400 points over r .6 to 1.4, D .5 to 150 misses it.
    """
    osc = vi.Oscillator(
        xi=0.010326622929671273,
        mu=0.05175260355209453,
        restitution=(0.8960383163200756, 0.5438430355223167),
    )
    window = (0.9, 1.1), (0.5, 6.0)
    atlas = vi.atlas(osc, *window, max_impacts=3, survey=0, guesses=1)
    random = np.random.default_rng(7)
    points = [(0.9736908418296962, 0.5947529884967194)]
    for _ in range(100):
        points.append((random.uniform(*window[0]), np.exp(random.uniform(*np.log(window[1])))))
    seen = []
    for r, clearance in points:
        pattern = attractor(osc, r, clearance)
        if pattern is None or len(pattern) > 3:
            continue
        seen.append(pattern.sides)
        assert atlas.explains(vi.SurveyPoint(r, clearance, pattern)), (r, clearance, pattern)
    assert vi.Pattern(seen[0]) in (vi.Pattern("L*R*"), vi.Pattern("R*L*"))
    assert len([sides for sides in seen if "*" in sides]) > 5


def test_survey_is_explained(atlas):
    assert len(atlas.attractors) > 20
    assert atlas.unexplained == []
    columns = atlas._result.tables["points"].columns
    periodic = columns["sides"].decoded() != ""
    assert not columns["explained"].decoded()[~periodic].any()
    for item in atlas.attractors:
        assert item.pattern == item.pattern.standard(alike=True)


def test_every_point_of_the_survey_is_counted(atlas):
    """The counts add up to the number of points, and agree with the lists of motions and with the repr."""
    counts, survey = atlas.counts, atlas.survey
    assert list(counts) == list(OUTCOMES)
    assert sum(counts.values()) == len(survey) == 60
    assert counts["periodic"] == len(atlas.attractors)
    assert counts["beyond the limits"] == len(atlas.beyond) > 0
    assert all(len(item.pattern) > 4 or item.pattern.cycles > 1 for item in atlas.beyond)
    places = set(zip(survey.r.tolist(), survey.clearance.tolist(), strict=True))
    assert len(places) == 60
    assert {item[:2] for item in atlas.attractors + atlas.beyond} <= places
    assert ((atlas.r[0] <= survey.r) & (survey.r <= atlas.r[1])).all()
    for name, number in counts.items():
        assert (f"{number} {name}" in repr(atlas)) == (number > 0)
    assert "survey of 60 points" in repr(atlas)


def test_motions_beyond_the_limits_are_stable(atlas):
    """An independent simulation settles on each attractor of the survey, and `exact` finds it stable."""
    confirmed = 0
    for item in atlas.beyond:
        random = np.random.default_rng(2)
        for _ in range(30):
            x, v, y = random.uniform(-1, 1, 3) * item.clearance / 2
            state = {"t": 0, "x": x, "x_dot": v, "z": x + y, "z_dot": 0}
            cycles = item.pattern.cycles
            run = vi.simulate(
                EQUAL, item.r, item.clearance, 2 * cycles + 2, state=state, discard=1500
            )
            try:
                period = run.period(cycles)
            except vi.errors.ParameterError:
                continue
            if period.mismatch < 1e-6 and period.pattern.standard(alike=True) == item.pattern:
                motion = vi.exact(EQUAL, item.r, item.clearance, run)
                assert (motion.stable, motion.admissible) == (True, True)
                assert motion.pattern.standard(alike=True) == item.pattern
                confirmed += 1
                break
    assert confirmed == len(atlas.beyond) > 0


def test_motion_without_impacts():
    """A free mass at rest is always hit where D < 2A, and never where D > 2A and |c| + A < D/2."""
    window = ((0.8, 1.2), (2.0, 200.0))
    where = vi.atlas(EQUAL, *window, max_impacts=2, survey=0, guesses=0).without_impacts
    random = np.random.default_rng(9)
    seen = set()
    for _ in range(60):
        r, factor, c = random.uniform(0.8, 1.2), random.uniform(0.7, 1.4), random.uniform(-1, 1)
        # the steady motion by hand: x = A sin(rt - lag)
        amplitude = 1 / abs(1 - r**2 + 2j * EQUAL.xi * r)
        lag = np.angle(1 - r**2 + 2j * EQUAL.xi * r)
        clearance = 2 * amplitude * factor
        free = max(0.0, clearance / 2 - amplitude)
        state = {
            "t": 0, "x": -amplitude * np.sin(lag), "x_dot": r * amplitude * np.cos(lag),
            "z": 0.999 * c * free, "z_dot": 0,
        }  # fmt: skip
        run = vi.simulate(EQUAL, r, clearance, 3, state=state)
        inside = where.r[0] <= r <= where.r[1] and 2 <= clearance <= 200
        assert bool(where.contains(r, clearance)) == (inside and factor > 1)
        assert (len(run.events) == 0) == (factor > 1)
        seen.add(factor > 1)
    assert seen == {True, False}
    r, least = where.boundary(41)
    np.testing.assert_allclose(least, 2 / abs(1 - r**2 + 2j * EQUAL.xi * r), rtol=1e-14)
    assert not where.contains(r, least * (1 - 1e-12)).any()
    fits = (least > 2) & (least * (1 + 1e-12) < 200)
    assert where.contains(r, least * (1 + 1e-12))[fits].all()
    assert not where.contains([0.79, 1.0], [50.0, 201.0]).any()


def test_points_without_impacts_are_where_that_motion_is():
    """The survey counts points as without impacts only where D > 2A, and there are such points."""
    atlas = vi.atlas(EQUAL, (0.8, 1.2), (2, 200), max_impacts=2, survey=100, guesses=0)
    survey = atlas.survey
    free = survey.outcome == 1 + OUTCOMES.index("without impacts")
    assert free.sum() == atlas.counts["without impacts"] > 10
    assert atlas.without_impacts.contains(survey.r[free], survey.clearance[free]).all()


def test_chaos_of_the_survey_has_a_positive_exponent():
    """The largest exponent at a chaotic point is positive, unless the chaos was transient and has ended."""
    window = (0.8, 1.2), (2.0, 8.0)
    atlas = vi.atlas(EQUAL, *window, max_impacts=2, survey=60, guesses=0)
    places = np.flatnonzero(atlas.survey.outcome == 1 + OUTCOMES.index("chaotic"))
    assert len(places) > 10
    positive = 0
    for j in places:
        r, clearance = atlas.survey.r[j], atlas.survey.clearance[j]
        exponents = vi.lyapunov(EQUAL, r, clearance, cycles=2000, discard=400)
        positive += bool(exponents.largest > 3 * exponents.standard_error[0])
    assert positive > 0.8 * len(places)


def test_patterns_of_the_paper_are_found(atlas):
    found = {(zone.pattern.sides, zone.symmetric) for zone in atlas.zones}
    assert {("RL", True), ("RL", False), ("RRL", False)} <= found
    for zone in atlas.zones:
        assert zone.area > 0


def test_file_gives_back_the_same_atlas(atlas, tmp_path):
    path = tmp_path / "atlas.json"
    atlas.save(path)
    loaded = vi.Atlas.load(path)
    assert loaded.attractors == atlas.attractors
    assert (loaded.beyond, loaded.counts) == (atlas.beyond, atlas.counts)
    for name in ("r", "clearance", "outcome"):
        np.testing.assert_array_equal(getattr(loaded.survey, name), getattr(atlas.survey, name))
    for ours, theirs in zip(atlas.zones, loaded.zones, strict=True):
        assert ours.to_dict() == theirs.to_dict()
        for ring, other in zip(ours.loops, theirs.loops, strict=True):
            np.testing.assert_array_equal(ring, other)
    assert json.loads(path.read_text())["type"] == "Atlas"


def test_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "other.json"
    path.write_text("[1, 2]")
    with pytest.raises(
        vi.errors.ParameterError, match="must be a file written by `save` of a result"
    ):
        vi.Atlas.load(path)


def test_threads_do_not_change_the_answer():
    window = ((1.0, 1.1), (20, 60))
    one = vi.atlas(EQUAL, *window, max_impacts=3, survey=20, threads=1)
    two = vi.atlas(EQUAL, *window, max_impacts=3, survey=20, threads=2)
    assert [zone.to_dict() for zone in one.zones] == [zone.to_dict() for zone in two.zones]
    np.testing.assert_array_equal(one.survey.outcome, two.survey.outcome)


def test_progress_is_told():
    """The shares of progress rise to 1, and the atlas is the same as without `progress`."""
    window = ((1.0, 1.1), (20, 60))
    shares = []
    message = vi.atlas(
        EQUAL,
        *window,
        max_impacts=3,
        survey=20,
        progress=lambda share, what: shares.append(share),
    )
    assert shares == sorted(shares)
    assert 0 <= shares[0] <= shares[-1] == 1
    assert message.to_dict() == vi.atlas(EQUAL, *window, max_impacts=3, survey=20).to_dict()


def test_survey_hears_a_stop(monkeypatch):
    """An exception of `progress` ends a survey that would take hours, and its threads."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.001)
    before = set(threading.enumerate())

    def progress(share, what):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vi.atlas(EQUAL, (0.9, 1.1), (5, 8), survey=10**6, settling=10**6, progress=progress)
    for thread in set(threading.enumerate()) - before:
        thread.join(60)
        assert not thread.is_alive()


def test_labelled_data_hold_the_survey(atlas):
    """The labelled data contain the outcome and the motions at each point, by name."""
    pytest.importorskip("xarray")
    data = atlas.to_xarray()
    assert data.sizes["point"] == 60
    for name in OUTCOMES:
        assert int((data["outcome"] == name).sum()) == atlas.counts[name]
    beyond = data.isel(point=data["outcome"] == "beyond the limits")
    patterns = zip(beyond["points_sides"].values, beyond["points_cycles"].values, strict=True)
    assert [vi.Pattern(sides, int(k)) for sides, k in patterns] == [
        item.pattern for item in atlas.beyond
    ]


def test_outcomes_are_those_of_the_core():
    columns = language()["results"]["atlas"]["columns"]
    words = [tuple(item["words"].split(",")) for item in columns if item["name"] == "outcome"]
    assert words == [OUTCOMES, OUTCOMES_OF_STRUCTURE]


def test_zones_of_an_atlas_are_results(atlas, tmp_path):
    """Each zone of an atlas can be saved and read alone; its rows are those of the atlas."""
    for i, zone in enumerate(atlas.zones):
        zone.save(tmp_path / f"zone_{i}.json")
        again = vi.load(tmp_path / f"zone_{i}.json")
        assert again.to_json() == zone.to_json()
        assert again.area == zone.area
    assert sum(len(zone.to_pandas()) for zone in atlas.zones) == len(atlas.to_pandas())


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"r": (0.9, 0.9)}, r"r\[1\] = 0.9"),
        ({"clearance": (10, 10)}, r"clearance\[1\] = 10"),
        ({"clearance": (float("nan"), 10)}, "clearance"),
        ({"max_impacts": 1}, "max_impacts"),
        ({"max_cycles": 99}, "max_cycles"),
        ({"survey": -1}, "survey"),
        ({"max_points": 99}, "max_points"),
    ],
)
def test_bad_input_is_named(arguments, name):
    given = {"r": (0.9, 1.1), "clearance": (10, 90), **arguments}
    with pytest.raises(vi.errors.ParameterError, match=rf"^{name}"):
        vi.atlas(EQUAL, **given)


def test_questions_that_an_atlas_refuses(atlas):
    """A point is two numbers, and an attractor is one of the survey."""
    with pytest.raises(vi.errors.ParameterTypeError, match=r"^attractor = None"):
        atlas.explains(None)
    for point, name in ((([0.9, 1.0], 20.0), "r"), ((0.9, []), "clearance")):
        with pytest.raises(
            (vi.errors.ParameterError, vi.errors.ParameterTypeError), match=rf"^{name} = "
        ):
            atlas.at(*point)


def test_zone_with_rest_agrees_with_simulation():
    """Simulations from rest reach stable motions of the pattern inside the zone, and none outside."""
    zone = vi.zone(UNEQUAL, vi.Pattern("RL*"), (0.84, 0.94), (4, 8))
    assert zone.closed
    assert {piece.type for piece in zone.boundary} <= {"rest_vanishes", "window"}
    random = np.random.default_rng(7)
    inside = 0
    for _ in range(60):
        r, clearance = random.uniform(0.84, 0.94), random.uniform(4, 8)
        pattern = attractor(UNEQUAL, r, clearance)
        there = pattern is not None and pattern.standard().sides == "RL*"
        # another attractor may coexist, but a motion of the pattern lies in the zone
        assert not there or zone.contains(r, clearance)
        inside += there
    assert inside > 5


def test_rest_vanishes_at_the_boundary():
    """Just inside the boundary the motion exists and rests briefly; just outside it does not exist."""
    zone = vi.zone(UNEQUAL, vi.Pattern("RL*"), (0.84, 0.94), (4, 8))
    start = vi.exact(UNEQUAL, 0.9, 5.74, vi.simulate(UNEQUAL, 0.9, 5.74, 8, discard=150))
    column = np.concatenate(
        [piece.clearance for piece in zone.boundary if piece.type == "rest_vanishes"]
    )
    r = np.concatenate([piece.r for piece in zone.boundary if piece.type == "rest_vanishes"])
    upper = np.flatnonzero(column > 5.74)
    edge = float(np.interp(0.9, *(np.array(sorted(zip(r[upper], column[upper], strict=True))).T)))
    motion = start
    for clearance in np.linspace(5.74, edge * (1 - 2e-3), 20):
        motion = vi.exact(UNEQUAL, 0.9, float(clearance), motion)
    events = motion.events
    rest = events["time"][events["kind"] == "release"] - events["time"][events["kind"] == "stick"]
    assert 0 < rest[0] < 0.1
    with pytest.raises(vi.errors.VibroimpactError):
        vi.exact(UNEQUAL, 0.9, edge * (1 + 1e-3), motion)


@pytest.mark.parametrize(
    ("sides", "symmetric", "window"),
    [("RL", True, (4, 150)), ("RL", False, (4, 90)), ("RRL", False, (4, 60))],
)
def test_zones_fit_over_the_chart(sides, symmetric, window):
    """The flags of a chart, computed point by point, agree with the zones, whose boundaries are traced."""
    pytest.importorskip("xarray")
    r, clearance = np.linspace(0.9, 1.1, 9), np.geomspace(*window, 11)
    pattern = vi.Pattern(sides)
    chart = vi.chart(EQUAL, pattern, r=r, clearance=clearance, symmetric=symmetric)
    zone = vi.zone(EQUAL, pattern, (0.85, 1.15), (2, 200), symmetric=symmetric)
    stable = ((chart.stable == 1) & (chart.admissible == 1)).any("motion")
    np.testing.assert_array_equal(stable, zone.contains(*np.meshgrid(r, clearance)))
    assert 5 < int(stable.sum()) < stable.size


def test_vertices_of_a_zone_with_rest_by_simulation():
    """A simulation from the release at a vertex returns to it after one period, at corners too.

    Where the rest vanishes, at corners too, its duration is zero: a simulation may also just fail to complete
    the accumulation, with masses that part at a speed below rounding. Elsewhere the rest is longer.
    """
    zone = vi.zone(UNEQUAL, vi.Pattern("RL*"), (0.84, 0.94), (4, 8))
    kinds = set()
    for piece in zone.boundary:
        kinds.add(piece.type)
        for j in (0, len(piece) // 3, len(piece) - 1):
            r, clearance, phase = piece.r[j], piece.clearance[j], piece.theta[0, j]
            v = piece.x_over_D[0, j] * clearance
            # no force between the masses: M alone determines where they part
            x = np.sin(phase) - 2 * UNEQUAL.xi * v
            state = {"t": phase / r, "x": x, "x_dot": v, "z": x - clearance / 2, "z_dot": v}
            run = vi.simulate(UNEQUAL, r, clearance, 1, state)
            change = [run.final_state[name] - state[name] for name in ("x", "x_dot", "z", "z_dot")]
            assert np.abs(change).max() < 1e-11
            events = run.events[run.events["time"] > phase / r + 1e-6]
            if piece.type == "rest_vanishes" or j in (0, len(piece) - 1):
                rests = np.diff(events["time"][np.isin(events["kind"], ("stick", "release"))])
                assert np.all(rests < 1e-6)
                assert np.diff(events["time"]).min() < 1e-6
            else:
                stick = events[events["kind"] == "stick"][-1]
                assert phase / r + 2 * np.pi / r - stick["time"] > 0.01
            if piece.detail:
                bound = (zone.r if piece.detail.endswith(" r") else zone.clearance)[
                    "highest" in piece.detail
                ]
                value = r if piece.detail.endswith(" r") else clearance
                assert abs(value / bound - 1) < 1e-12
    assert kinds == {"rest_vanishes", "window"}


@pytest.mark.slow
def test_a_stopped_atlas_keeps_the_zones_that_were_finished():
    """Each zone kept equals that of the complete atlas, and the result says how many are missing."""
    window = {"r": (0.8, 1.2), "clearance": (2, 200), "max_impacts": 3, "survey": 20}
    whole = vi.atlas(UNEQUAL, **window)

    def stop(share, what):
        if share > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(vi.errors.StudyInterrupted) as caught:
        vi.atlas(UNEQUAL, **window, progress=stop, threads=1)
    part = caught.value.result
    assert not part.complete
    kept, wanted = (int(n) for n in part.cut.split(" families")[0].split(" of "))
    assert 0 < kept < wanted
    zones = {zone.pattern: zone for zone in whole.zones}
    assert set() < {zone.pattern for zone in part.zones} < set(zones)
    for zone in part.zones:
        assert zone.closed
        assert zone.area == zones[zone.pattern].area
