"""Basins of structures agree with those of the oscillator, single simulations, and symmetry."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.results.tables import from_core

INPUT = Path(__file__).parents[2] / "inputs" / "structure_basins.nml"
PLANE = (("q_0", -6.8, 6.8, 9), ("q_dot_0", -9, 9, 10))


def pair(xi, mu, restitution, clearance):
    """The oscillator of the 1983 paper as the matrices of its two masses."""
    gaps = [
        vi.Gap([-1, 1], clearance / 2, restitution),
        vi.Gap([1, -1], clearance / 2, restitution),
    ]
    return vi.Structure([1, mu], [2 * xi, 0], [1, 0], gaps)


# two motions of three impacts, mirror images of each other
DAMPER, LOAD = pair(0.0114, 0.028, 0.75, 14.0), vi.Load(1.04, sine=[1, 0])


@pytest.fixture(scope="module")
def found():
    return vi.basins(DAMPER, LOAD, PLANE)


@pytest.mark.parametrize(
    ("system", "r", "count"),
    [((0.0114, 0.028, 0.75, 14.0), 1.04, 2), ((0.02, 0.1, 0.3, 20.0), 0.94, 2)],
)
def test_the_two_masses_of_1983_have_the_basins_of_the_oscillator(system, r, count):
    """Two independent algorithms agree on each state, except those with long transients."""
    xi, mu, restitution, clearance = system
    plane = (
        ("q_0", -clearance / 2.1, clearance / 2.1, 9), ("q_dot_0", -clearance / 1.5, clearance / 1.5, 10),
    )  # fmt: skip
    found = vi.basins(pair(*system), vi.Load(r, sine=[1, 0]), plane)
    (q, q_2), (rate, rate_2) = found.states.reshape(2, 2, -1)
    osc = vi.Oscillator(xi=xi, mu=mu, restitution=restitution)
    own = vi.basins(osc, r, clearance, states=[0 * q, q, rate, q_2, rate_2])
    pairs = Counter(zip(found.labels.ravel().tolist(), own.labels.tolist(), strict=True))
    pairs = pairs.most_common(count)
    assert len({pair[0] for pair, _ in pairs}) == len({pair[1] for pair, _ in pairs}) == count
    assert sum(number for _, number in pairs) >= 88
    for (mine, other), _ in pairs:
        one, two = found.attractors[mine], own.attractors[other]
        assert (one.motion is None) == (two.motion is None)
        if one.motion is None:
            assert one.name == two.name == "no impacts"
        else:
            np.testing.assert_allclose(one.motion.multipliers, two.motion.multipliers, rtol=1e-8)


def test_a_label_is_the_motion_of_the_simulation_alone(found):
    for place in ((0, 0), (4, 5), (8, 3)):
        attractor = found.attractors[found.labels[place]]
        state = found.states[(slice(None), slice(None), *place)]
        run = vi.simulate(DAMPER, LOAD, cycles=1500, state=(state[0], state[1]))
        assert vi.same_motion(vi.exact(DAMPER, LOAD, run), attractor.motion)


def numbered(run, motions):
    """The labels of a run as indices of its attractors in a list of motions."""
    places = [
        next(i for i, motion in enumerate(motions) if vi.same_motion(item.motion, motion))
        for item in run.attractors
    ]
    return np.array(places)[run.labels]


def test_the_mirror_image_of_a_state_has_that_of_its_attractor(found):
    """The state with all signs changed, half a cycle later, goes to the mirror image of the attractor.

    States whose long chaotic transients are decided by rounding do not count.
    """
    motions = [item.motion for item in found.attractors]
    images = [
        vi.exact(DAMPER, LOAD, (motion.phases + np.pi, 1 - motion.gaps)) for motion in motions
    ]
    certain = np.ones(found.labels.shape, bool)
    for change in np.linspace(-1e-13, 1e-13, 8):
        plane = [(name, low * (1 + change), high * (1 + change), n) for name, low, high, n in PLANE]
        certain &= numbered(vi.basins(DAMPER, LOAD, plane), motions) == found.labels
    assert certain.mean() > 0.9
    turned = vi.basins(DAMPER, LOAD, PLANE, start=np.pi / LOAD.frequency)
    mirrored = numbered(turned, images)[::-1, ::-1]
    np.testing.assert_array_equal(mirrored[certain], found.labels[certain])


def test_shares(found):
    shares = [(found.labels == i).mean() for i in range(len(found.attractors))]
    np.testing.assert_allclose(found.fractions, shares, rtol=1e-15)
    assert (np.diff(found.fractions) <= 0).all()
    np.testing.assert_allclose(
        found.standard_error, np.sqrt(found.fractions * (1 - found.fractions) / 90), rtol=1e-12
    )


def test_any_number_of_threads_gives_the_same_bits():
    plane = (("q_0", -5, 5, 5), ("q_dot_1", -9, 9, 5))
    one, two = (vi.basins(DAMPER, LOAD, plane, threads=n) for n in (1, 3))
    assert one.to_dict() == two.to_dict()


def test_states_with_closed_gaps_have_no_attractor():
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    found = vi.basins(
        wall, vi.Load(1.0, cosine=[1]), (("q_0", -2, 2, 9), ("q_dot_0", -1, 1, 3)), settling=100
    )
    (first, _) = found.axes
    assert (found.labels[first.values > 1] == -4).all()
    assert (found.labels[first.values < 1] == 0).all()
    assert found.attractors[0].motion.stable
    share = (found.labels == 0).sum() / (found.labels != -4).sum()
    np.testing.assert_allclose(found.fractions[0], share, rtol=1e-15)


def test_random_states_begin_alike():
    """The first random states do not depend on the number of states, and are those that `find` simulates."""
    few, many = (vi.basins(DAMPER, LOAD, states=n, rng=3) for n in (5, 12))
    np.testing.assert_array_equal(few.states, many.states[:, :, :5])
    assert few.axes is None
    assert not few.drawable
    motions = vi.find(DAMPER, LOAD, states=12, rng=3, max_impacts=0, max_cycles=16, settling=1000)
    counts = [
        int((many.labels == i).sum()) for i, item in enumerate(many.attractors) if item.motion
    ]
    # `find` follows lines through the point to further motions, on which no state settled
    assert [n for n in motions.settled if n] == counts


@pytest.mark.parametrize("extension", ["json", "nc", "mat"])
def test_files_and_namelists_give_it_back(extension, tmp_path):
    plane = (("q_0", -5, 5, 3), ("q_dot_0", -9, 9, 4))
    found = vi.basins(DAMPER, LOAD, plane, state=([0, 1], [0, 2]))
    assert (found.states[0, 1] == 1).all()
    path = tmp_path / f"found.{extension}"
    found.save(path)
    namelist = tmp_path / "case.nml"
    namelist.write_text(found.to_namelist())
    (case,) = vi.read_namelist(namelist)
    for again in (vi.load(path), case.run()[0]):
        assert repr(again) == repr(found)
        np.testing.assert_array_equal(again.labels, found.labels)
        for a, b in zip(again.attractors, found.attractors, strict=True):
            assert a.name == b.name
            assert (a.motion is None) == (b.motion is None)
            if a.motion is not None:
                np.testing.assert_array_equal(a.motion.phases, b.motion.phases)


def test_inputs_run(tmp_path):
    log = vi.run_namelists([INPUT], tmp_path)
    assert log.status == 0, log
    table = (tmp_path / "structure_basins_wall.csv").read_text()
    assert "q_0,q_dot_0,label,attractor" in table


def test_picture(found):
    pytest.importorskip("matplotlib")
    ax = found.plot()
    assert ax.get_xlabel() == "$q_{0}$"
    assert ax.get_ylabel() == r"$\dot q_{0}$"
    assert len(ax.get_legend().get_texts()) == len(found.attractors)
    with pytest.raises(vi.ParameterError, match="random"):
        vi.basins(DAMPER, LOAD, states=2, settling=10).plot()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"plane": None}, "plane = None, states = None: exactly one must be given"),
        ({"states": 3}, "plane = "),
        ({"plane": (("q_2", 0, 1, 3), ("q_0", 0, 1, 3))}, "plane: name = 'q_2', 'q_0': must be two of"),
        ({"plane": (("q_0", 0, 1, 3), ("q_0", 0, 1, 3))}, "plane: name = "),
        ({"plane": (("x", 0, 1, 3), ("q_0", 0, 1, 3))}, "plane: name = "),
        ({"plane": (("q_1", 1, 0, 3), ("q_0", 0, 1, 3))}, "plane: high = 0.0, 1.0: must be"),
        ({"plane": (("q_1", -1e101, 0, 3), ("q_0", 0, 1, 3))}, "plane: low = -1e+101, 0.0: must be two numbers"),
        ({"plane": (("q_1", 0, 1, 3), ("q_0", 0, 1e200, 3))}, "plane: high = 1.0, 1e+200: must be two numbers"),
        ({"state": ([0, 1e101], [0, 0])}, "state = "),
        ({"plane": (("q_1", 0, 1, 1), ("q_0", 0, 1, 3))}, "plane: n"),
        ({"plane": (("q_1", 0, 1, 3),)}, "plane = "),
        ({"settling": -1}, "settling = -1: must be a whole number with 0 <="),
        ({"load": vi.Load(constant=[1])}, "load for 1 coordinate: must be for 2"),
    ],
)  # fmt: skip
def test_errors_name_the_parameter(options, message):
    with pytest.raises(vi.ParameterError) as caught:
        vi.basins(DAMPER, **{"load": LOAD, "plane": PLANE, **options})
    assert str(caught.value).startswith(message)


def test_it_stops_when_asked(found):
    counters = new_counters()
    counters[2] = 1
    handle, _ = _core.run_case(np.frombuffer(found.to_namelist().encode(), "S1"), 1, counters)
    result = from_core("basins", handle)
    assert result.cut == "0 of 90 states were reached"


def test_an_event_limit_is_a_label():
    found = vi.basins(DAMPER, LOAD, PLANE, max_events=20)
    assert (found.labels == -3).all()
    assert "90 not decided" in repr(found)


def test_a_record_of_the_former_class_is_read(found):
    """Earlier records had a separate class for structures, and did not name the study."""
    data = found.to_dict() | {"type": "StructureBasins"}
    del data["study"]
    again = vi.Basins.from_dict(data)
    assert type(again) is vi.Basins
    assert again.of_structure
    assert again.to_dict() == found.to_dict()


def test_what_there_is_instead_are_attributes(found):
    with pytest.raises(AttributeError, match=r"it has labels, fractions, standard_error$"):
        found.r  # noqa: B018


def test_what_a_system_lacks_is_named(found):
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    own = vi.basins(osc, 1.04, 14.0, states=2, cycles=20, probes=2)
    for noun, name in (
        (found, "r"), (found, "clearance"), (found, "osc"), (found, "impacts"), (found, "uncertain"),
        (found, "uncertainty_exponent"), (own, "structure"),
    ):  # fmt: skip
        with pytest.raises(
            AttributeError, match=rf"^{name}: a Basins of .* does not have it; it has "
        ):
            getattr(noun, name)
    with pytest.raises(AttributeError, match=r"^integrity: a Basins of a Structure"):
        found.integrity(0)
    again = vi.basins(osc.at(1.04, 14.0), states=2, cycles=20, probes=2)
    assert again.to_dict() == own.to_dict()


def test_kinds_follow_from_motions(found):
    """An attractor is periodic if it has an exact motion, and has a rest if that motion has one."""
    table = vi.Structure([1], [0.3], [1], [vi.Gap([-1], 0.0, 0.2)])
    still = vi.basins(table, vi.Load(0.3, sine=[0.5], constant=[-0.2]), states=6, settling=200)
    kinds = {item.kind for item in (*found.attractors, *still.attractors)}
    assert {"periodic", "rest"} <= kinds
    for item in (*found.attractors, *still.attractors):
        if item.motion is None:
            assert item.name.startswith(item.kind)
        else:
            assert item.kind == ("rest" if len(item.motion.rests) else "periodic")
        assert repr(item) in {f"<{item.kind} attractor {item.name}>", f"<attractor {item.name}>"}


@pytest.mark.parametrize("suffix", ["json", "nc", "mat"])
def test_random_states_are_read_back(tmp_path, suffix):
    """Basins of random states are read back although states and derivatives of motions have different sizes."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    found = vi.basins(wall, vi.Load(1.0, cosine=[1]), states=20)
    found.save(tmp_path / f"a.{suffix}")
    assert vi.load(tmp_path / f"a.{suffix}").to_json() == found.to_json()


def test_what_settles_slowly_is_not_chaotic():
    """States that have not settled when they are first examined continue until they have."""
    soon = vi.basins(DAMPER, LOAD, states=6, settling=5, max_cycles=2)
    late = vi.basins(DAMPER, LOAD, states=6, settling=4000, max_cycles=2)
    names = [[[*b.attractors][i].name for i in b.labels] for b in (soon, late)]
    assert names[0] == names[1]


def test_vibration_that_decays_for_a_million_cycles_is_no_attractor():
    """With a heavy free mass both masses oscillate together long after volumes have contracted."""
    walls = (0.6974883085198703, 0.701778734695422)
    gaps = [vi.Gap([s, -s], 7.889638987386798, R) for s, R in zip((-1, 1), walls, strict=True)]
    load = vi.Load(0.9286407087615169, sine=[1, 0])
    heavy = vi.Structure([1, 1e6], [0.0404886335211972, 0], [1, 0], gaps)
    assert (vi.basins(heavy, load, states=2).labels == -1).all()


@pytest.mark.slow
def test_a_chaotic_attractor_has_a_positive_exponent():
    structure, load = pair(0.0114, 0.028, 0.75, 72.0), vi.Load(1.04, sine=[1, 0])
    found = vi.basins(structure, load, states=6)
    names = [found.attractors[i].name for i in found.labels]
    assert "chaotic" in names
    for i, name in enumerate(names):
        start = tuple(part[:, i] for part in found.states)
        exponents = vi.lyapunov(structure, load, 8000, state=start, discard=4000, directions=1)
        positive = exponents.per_cycle[0] > 6 * exponents.error_per_cycle[0]
        assert (exponents.impacts > 0 and positive) == (name == "chaotic")
        assert (exponents.impacts == 0) == (name == "no impacts")


@pytest.mark.slow
def test_a_chaotic_transient_is_no_attractor():
    """States settle after 10^4 to 10^6 load cycles; two algorithms and two orders of rounding agree."""
    wall, r, clearance = 0.7189674455988654, 1.4616163504310702, 33.7456669137705
    point = vi.Oscillator(xi=0.01154927445245723, mu=0.01757787366661444, restitution=wall).at(
        r, clearance
    )
    plane = (("q_1", -15.0, 15.0, 4), ("q_dot_1", -17.0, 17.0, 4))
    found = vi.basins(point.structure, point.load, plane)
    assert {item.name for item in found.attractors} <= {"2/3", "no impacts"}
    own = vi.basins(point, (("y", -15.0, 15.0, 4), ("z_dot", -17.0, 17.0, 4)))
    decided = found.labels >= 0
    assert decided.sum() >= 13
    names = [[[*b.attractors][i].kind for i in b.labels[decided]] for b in (found, own)]
    assert names[0] == names[1]


def test_chaotic_attractors_that_are_mirror_images_are_two():
    """The mirror image of a state on one, half a load period later, is on the other."""
    r, clearance = 0.92, 14.674134539926223
    point = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75).at(r, clearance)
    found = vi.basins(point.structure, point.load, states=12)
    assert [item.name for item in found.attractors] == ["chaotic (1)", "chaotic (2)"]
