"""Atlases of structures agree with those of the oscillator, and with simulations at their points."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.results.tables import from_core

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
AXES = (("frequency", 1.0, 1.1), ("opening", 10.0, 30.0))
LIMITS = {"max_impacts": 3, "survey": 30, "settling": 300}


@pytest.fixture(scope="module")
def atlas():
    point = OSC.at(1.05, 40.0)
    return vi.atlas(point.structure, point.load, *AXES, **LIMITS)


def test_the_two_masses_of_1983_have_the_atlas_of_the_oscillator(atlas):
    """The points, away from the boundaries, at which a motion of two or three impacts is stable."""
    theirs = vi.atlas(OSC, (1.0, 1.1), (20.0, 60.0), max_impacts=3, survey=30)
    assert {(len(zone.gaps), zone.cycles) for zone in atlas.zones} == {
        (len(zone.pattern), zone.pattern.cycles) for zone in theirs.zones
    }
    rng = np.random.default_rng(2)
    x, y = rng.uniform(1.0, 1.1, 300), rng.uniform(10.0, 30.0, 300)

    def covered(zones, impacts, ordinate):
        found = [zone.contains(x, ordinate) for zone in zones]
        sizes = [len(zone.gaps) if zone.of_structure else len(zone.pattern) for zone in zones]
        return np.any([one for one, n in zip(found, sizes, strict=True) if n == impacts], axis=0)

    for impacts in (2, 3):
        ours, known = covered(atlas.zones, impacts, y), covered(theirs.zones, impacts, 2 * y)
        assert 0 < ours.sum() < ours.size
        assert not (ours & ~known).any()
        # no simulation reaches the small second loop of RRL
        assert (known & ~ours).sum() <= (0 if impacts == 2 else 4)


def test_motions_of_the_survey_lie_in_the_zones(atlas):
    assert atlas.counts["periodic"] == len(atlas.attractors) > 10
    assert sum(atlas.counts.values()) == len(atlas.survey) == 30
    assert not atlas.unexplained
    for x, y, impacts, cycles in atlas.attractors:
        assert any((len(zone.gaps), zone.cycles) == (impacts, cycles) for zone in atlas.at(x, y))


@pytest.mark.slow
def test_simulations_stay_on_the_motions_of_zones(atlas):
    rng = np.random.default_rng(4)
    for zone in atlas.zones:
        inside = [
            place for place in rng.uniform((1.0, 10.0), (1.1, 30.0), (400, 2)).tolist()
            if zone.contains(*place)
        ]  # fmt: skip
        motion = next(one for one in (zone.motion(*place) for place in inside) if one)
        assert motion.stable
        assert motion.admissible
        start = motion.phases[0] / motion.load.frequency
        run = vi.simulate(
            motion.structure, motion.load, cycles=300, state=(motion.q, motion.q_dot), start=start
        )
        last = run.events["speed"][-len(motion.gaps) :]
        np.testing.assert_allclose(np.sort(last), np.sort(motion.speeds), rtol=1e-9)


def test_any_number_of_threads_gives_the_same_bits():
    point = OSC.at(1.05, 40.0)
    one, two = (
        vi.atlas(point.structure, point.load, *AXES, **LIMITS | {"survey": 6}, threads=threads)
        for threads in (1, 2)
    )
    assert one.to_json() == two.to_json()


@pytest.mark.parametrize("suffix", ["json", "nc", "mat"])
def test_files_and_namelists_give_it_back(atlas, suffix, tmp_path):
    path = tmp_path / f"atlas.{suffix}"
    atlas.save(path)
    again = vi.load(path)
    assert repr(again) == repr(atlas)
    assert again.structure == atlas.structure
    for one, other in zip(atlas.zones, again.zones, strict=True):
        assert one.area == other.area
        assert repr(one) == repr(other)
    namelist = tmp_path / "case.nml"
    namelist.write_text(atlas.to_namelist())
    (case,) = vi.read_namelist(namelist)
    assert case.structure == atlas.structure


def test_zones_are_saved_alone(atlas, tmp_path):
    zone = atlas.zones[0]
    zone.save(tmp_path / "zone.json")
    again = vi.load(tmp_path / "zone.json")
    assert again.area == zone.area
    assert again.gaps.tolist() == zone.gaps.tolist()
    assert (again.x, again.y_parameter) == (zone.x, "opening")


def test_motions_with_rest_are_counted():
    structure = vi.Structure(
        [1, 0.028], [0.0228, 0], [1, 0], [vi.Gap([-1, 1], 3, 0.75), vi.Gap([1, -1], 3, 0.61)]
    )
    found = vi.atlas(
        structure, vi.Load(0.9, sine=[1, 0]), ("frequency", 0.88, 0.92), ("opening", 2.5, 3.5), survey=4
    )  # fmt: skip
    assert found.counts["with rest"] > 0
    assert not found.attractors


def test_a_picture_shows_zones_and_survey(atlas):
    pytest.importorskip("matplotlib")
    ax = atlas.plot()
    assert ax.get_xlim() == (1.0, 1.1)
    assert ax.get_ylim() == (10.0, 30.0)
    with pytest.raises(vi.ParameterError, match="of a structure"):
        atlas.plot(inverse=True)


def test_what_a_structure_lacks_is_named(atlas):
    for name, instead in {
        "r": "x and y",
        "clearance": "x and y",
        "without_impacts": "counts",
    }.items():
        with pytest.raises(AttributeError, match=instead):
            getattr(atlas, name)
    with pytest.raises(AttributeError, match="unexplained"):
        atlas.explains(None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": ("frequency", 1.2, 1.3)}, "the structure has frequency = 1.05"),
        ({"x": ("opening", 10.0, 30.0)}, "changes"),
        ({"survey": 0}, "survey"),
        ({"max_impacts": 25}, "max_impacts"),
        ({"load": 1.0}, "load"),
    ],
)
def test_errors_name_the_parameter(change, message):
    point = OSC.at(1.05, 40.0)
    keys = {
        "structure": point.structure,
        "load": point.load,
        "x": AXES[0],
        "y": AXES[1],
        "survey": 2,
    }
    with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match=message):
        vi.atlas(**keys | change)
    with pytest.raises(vi.ParameterTypeError, match="give its osc"):
        vi.atlas(point, *AXES)


@pytest.mark.parametrize("study", ["atlas", "chart"])
def test_it_stops_when_asked(study):
    """If a stop is requested before the start, the result has at most the starting motion, and is marked."""
    group = (
        "&motion kind = 'exact', gaps = 1, 0, phases = 1.84, 4.98, cycles = 1 /\n&chart"
        if study == "chart" else "&atlas survey = 3"
    )  # fmt: skip
    text = f"""
        &structure mass = 1, 0.028, damping = 0.0228, 0, stiffness = 1, 0 /
        &gap direction = -1, 1, opening = 25, restitution = 0.75 /
        &gap direction = 1, -1, opening = 25, restitution = 0.75 /
        &load frequency = 1.06, sine = 1, 0 /
        {group} x = 'frequency', x_low = 1, x_high = 1.1, y = 'opening', y_low = 10, y_high = 30 /
    """
    counters = new_counters()
    counters[2] = 1
    lines = "\n".join(line.strip() for line in text.splitlines() if line.strip())
    handle, _ = _core.run_case(np.frombuffer(lines.encode(), "S1"), 1, counters)
    found = from_core(study, handle)
    assert found.cut
    assert found.empty or found.tables["points"].columns["found"].values.sum() == 1
    assert not any(is_fault for is_fault, _ in found.notes)


def test_an_atlas_with_a_stop_and_friction_agrees_with_simulations(tmp_path):
    """`find` finds the motion inside its zone and not outside; also with friction, and from a file."""
    stop, load = vi.Stop([1], 1.0, 100.0), vi.Load(1.0, cosine=[1.0])
    for gaps, friction, axes in (
        ([stop], [], (("frequency", 0.8, 1.3), ("load", 0.5, 2.0))),
        ([vi.Gap([1], 1.0, 0.6)], [vi.Friction([1], 0.1)], (("frequency", 0.9, 1.2), ("slip_1", 0.02, 0.2))),
    ):  # fmt: skip
        s = vi.Structure([1], [0.1], [1], gaps, friction)
        found = vi.atlas(s, load, *axes, survey=10, settling=100, lines=9, threads=1)
        again = vi.atlas(s, load, *axes, survey=10, settling=100, lines=9, threads=2)
        assert str(found) == str(again)
        assert found.zones
        found.save(tmp_path / "atlas.json")
        zone = vi.load(tmp_path / "atlas.json").zones[0]
        assert zone.gaps.tolist() == found.zones[0].gaps.tolist()
        (_, *x), (_, *y) = axes
        places = np.random.default_rng(0).uniform((x[0], y[0]), (x[1], y[1]), (5, 2))
        for place in places.tolist():
            motions = vi.find(*zone.at(*place), max_impacts=6, max_cycles=1, states=6, threads=1)
            stable = [one for one in motions if one.stable and one.cycles == 1]
            assert any(one.contains(*place) for one in found.zones) == bool(stable)
