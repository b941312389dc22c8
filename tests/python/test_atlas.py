"""Atlas and zones with rest: against simulation, which knows nothing of sheets and boundaries."""

import json

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.newton import last_period
from vibroimpact.studies.atlas import standard

EQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
UNEQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))


@pytest.fixture(scope="module")
def atlas():
    return vi.atlas(EQUAL, (0.9, 1.1), (10, 90), max_impacts=4, survey=60)


def attractor(osc, r, clearance, cycles=1):
    """The pattern that a simulation from rest settles on, or None."""
    run = vi.simulate(osc, r, clearance, 2 * cycles + 2, discard=400)
    try:
        period = last_period(run, cycles)
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
        assert atlas.explains(vi.Attractor(r, clearance, pattern)), (r, clearance, pattern)
    assert checked > 30


def test_survey_is_explained(atlas):
    assert len(atlas.attractors) > 20
    assert atlas.unexplained == []
    for item in atlas.attractors:
        assert item.pattern == standard(item.pattern, EQUAL)


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
    for ours, theirs in zip(atlas.zones, loaded.zones, strict=True):
        assert ours.to_dict() == theirs.to_dict()
        for ring, other in zip(ours.loops, theirs.loops, strict=True):
            np.testing.assert_array_equal(ring, other)
    assert json.loads(path.read_text())["type"] == "Atlas"


def test_file_of_another_kind_is_refused(tmp_path):
    path = tmp_path / "other.json"
    path.write_text("[1, 2]")
    with pytest.raises(
        vi.errors.ParameterError, match="must be a file that the save of a result wrote"
    ):
        vi.Atlas.load(path)


def test_threads_do_not_change_the_answer():
    window = ((1.0, 1.1), (20, 60))
    one = vi.atlas(EQUAL, *window, max_impacts=3, survey=20, threads=1)
    two = vi.atlas(EQUAL, *window, max_impacts=3, survey=20, threads=2)
    assert [zone.to_dict() for zone in one.zones] == [zone.to_dict() for zone in two.zones]


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ({"r": (1.1, 0.9)}, "r"),
        ({"clearance": (10, 10)}, "clearance"),
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


def test_zone_with_rest_agrees_with_simulation():
    """Stable motions with rest are reached from rest here; outside none of the pattern is."""
    zone = vi.zone(UNEQUAL, vi.Pattern("RL*"), (0.84, 0.94), (4, 8))
    assert zone.closed
    assert {piece.type for piece in zone.boundary} <= {"rest_vanishes", "window"}
    random = np.random.default_rng(7)
    inside = 0
    for _ in range(60):
        r, clearance = random.uniform(0.84, 0.94), random.uniform(4, 8)
        pattern = attractor(UNEQUAL, r, clearance)
        there = pattern is not None and standard(pattern, UNEQUAL).sides == "RL*"
        # another attractor may exist beside it, but what simulation reaches is in the zone
        assert not there or zone.contains(r, clearance)
        inside += there
    assert inside > 5


def test_rest_vanishes_at_the_boundary():
    """Just inside the motion with rest exists and rests briefly; just outside it is gone."""
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
    """A chart computes point by point, a zone follows its boundary: both tell the same story."""
    pytest.importorskip("xarray")
    r, clearance = np.linspace(0.9, 1.1, 9), np.geomspace(*window, 11)
    pattern = vi.Pattern(sides)
    chart = vi.chart(EQUAL, pattern, r=r, clearance=clearance, symmetric=symmetric)
    zone = vi.zone(EQUAL, pattern, (0.85, 1.15), (2, 200), symmetric=symmetric)
    stable = ((chart.stable == 1) & (chart.admissible == 1)).any("motion")
    np.testing.assert_array_equal(stable, zone.contains(*np.meshgrid(r, clearance)))
    assert 5 < int(stable.sum()) < stable.size


def test_vertices_of_a_zone_with_rest_by_simulation():
    """From the release that a vertex gives, simulation comes back to it after a period, corners included.

    The last rest lasts as long as the documentation says where rest vanishes, and longer elsewhere; at a
    corner with an edge of the window it does both.
    """
    zone = vi.zone(UNEQUAL, vi.Pattern("RL*"), (0.84, 0.94), (4, 8))
    kinds = set()
    for piece in zone.boundary:
        kinds.add(piece.type)
        for j in (0, len(piece) // 3, len(piece) - 1):
            r, clearance, phase = piece.r[j], piece.clearance[j], piece.theta[0, j]
            v = piece.x[0, j] * clearance
            # no force between the masses: M alone decides where they part
            x = np.sin(phase) - 2 * UNEQUAL.xi * v
            state = {"t": phase / r, "x": x, "x_dot": v, "z": x - clearance / 2, "z_dot": v}
            events = vi.simulate(UNEQUAL, r, clearance, 2, state).events
            release = events[(events["kind"] == "release") & (events["time"] > phase / r + 1e-6)][0]
            stick = events[(events["kind"] == "stick") & (events["time"] < release["time"])][-1]
            assert abs(release["time"] - phase / r - 2 * np.pi / r) < 1e-12
            assert abs(release["x_dot_after"] - v) < 1e-12
            rest = release["time"] - stick["time"]
            if piece.type == "rest_vanishes" or j in (0, len(piece) - 1):
                assert abs(rest - 0.002) < 1e-9
            else:
                assert rest > 0.01
            if piece.detail:
                bound = (zone.r if piece.detail.endswith(" r") else zone.clearance)[
                    "highest" in piece.detail
                ]
                value = r if piece.detail.endswith(" r") else clearance
                assert abs(value / bound - 1) < 1e-12
    assert kinds == {"rest_vanishes", "window"}
