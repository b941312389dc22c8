"""Branches of structures with elastic stops and friction, compared with exact motions and simulations."""

import json

import numpy as np
import pytest
import vibroimpact as vi
from test_exact_elements import of_chance, one_stop, settled

DAMPING = 0.05


def den_hartog(slip, stick=None):
    return vi.Structure(
        [1.0], [2 * DAMPING], [1.0], friction=[vi.Friction([1.0], slip, stick=stick)]
    )


def apart(branch, i):
    """Difference between the moduli of the multipliers at a point and those of the exact motion there."""
    motion = branch[i]
    # simultaneous changes are separate events in a motion, as are the impacts of an accumulation
    phases = np.sort(np.mod(motion.phases, 2 * np.pi * motion.cycles))
    assert len(motion.rests) == len(branch.resting)
    if not len(motion.rests):
        assert 1 + np.count_nonzero(np.diff(phases) > 1e-9) == len(branch.gaps)
    assert motion.admissible
    return np.abs(
        np.sort(np.abs(motion.multipliers)) - np.sort(np.abs(branch.multipliers[:, i]))
    ).max()


def inner(branch, most):
    """Admissible points, at most a given number."""
    found = np.flatnonzero(branch.admissible == 1)
    return found[:: max(1, -(-len(found) // most))].tolist()


@pytest.mark.slow
@pytest.mark.parametrize(("first", "last"), [
    (0, 8), pytest.param(8, 60, marks=pytest.mark.slow),
])  # fmt: skip
def test_points_are_exact_motions(first, last, share):
    """Each point is the motion that `exact` finds there by simulation, with the same multipliers."""
    last = first + max(8, share(last - first))
    judged = 0
    for seed in range(first, last):
        s, load = of_chance(seed)
        try:
            motion = vi.exact(s, load, vi.simulate(s, load, cycles=600, discard=500))
            w = load.frequency
            branch = vi.branch(motion, "frequency", bounds=(0.8 * w, 1.2 * w))
        except (vi.ParameterError, vi.SingularError):
            continue  # it has no impacts, is not periodic or has too many events
        assert branch.residual.max() < 1e-9
        near_fold = np.abs(branch.multipliers - 1).min(axis=0) < 1e-3
        for i in inner(branch, 7):
            if not near_fold[i]:
                assert apart(branch, i) < 2e-7
                judged += 1
    assert judged >= 5 * (last - first)


def between_stops():
    """A mass with friction between two stops, under a load with other attractors nearby."""
    stops = [
        vi.Stop(
            [side], 0.6972788425859135, stiffness=19.178452850140584, damping=0.09041032149400266
        )
        for side in (1, -1)
    ]
    s = vi.Structure([1], [0.04065131975330451], [1], stops, friction=[vi.Friction([1], 0.1)])
    load = vi.Load(1.9586661830366296, cosine=[0.6397892985427163])
    return vi.exact(s, load, vi.simulate(s, load, cycles=400))


def largest(multipliers):
    return np.abs(multipliers).max()


def test_each_point_gives_its_own_motion():
    """Given the events of a point all else is linear: its motion solves them to rounding and has the multipliers
    of the columns, also where it is not admissible, and near other attractors."""
    branch = vi.branch(between_stops(), "frequency", bounds=(1.2, 3.0))
    assert (branch.admissible == 0).sum() > 20
    for i in range(0, len(branch), 4):
        found = branch[i]
        assert found.residual < 1e-14
        assert largest(found.multipliers) == pytest.approx(
            largest(branch.multipliers[:, i]), rel=1e-9
        )
        assert found.admissible == {1: True, 0: False, -1: None}[branch.admissible[i]]
        # at a reversal the speed is 0, and half a period later the state is the opposite one
        assert np.abs(found.states[:, 1]).max() < 1e-13
        assert found.states[0] == pytest.approx(-found.states[1], abs=1e-12)
    refused = branch[0]
    with pytest.raises(vi.SingularError, match="it is not admissible"):
        refused.sample([0.0])


def test_points_without_their_events(tmp_path):
    """A file that does not hold the events: the points are simulated, from states that start the same motion."""
    branch = vi.branch(between_stops(), "frequency", bounds=(1.2, 3.0))
    branch.save(tmp_path / "branch.json")
    text = json.loads((tmp_path / "branch.json").read_text())
    del text["tables"]["events"]
    (tmp_path / "old.json").write_text(json.dumps(text))
    old = vi.load(tmp_path / "old.json")
    for i in np.flatnonzero(branch.admissible == 1)[::12].tolist():
        q, wanted = (np.sort(motion.states[:, 0], axis=0) for motion in (old[i], branch[i]))
        assert q == pytest.approx(wanted, abs=1e-9)
    with pytest.raises(vi.SingularError, match="not admissible and cannot be simulated"):
        old[0]


def test_an_unstable_point():
    """Beyond a flip the motions of a branch are unstable, and simulations leave them; the points keep them."""
    s, load = of_chance(1)
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=600, discard=500))
    branch = vi.branch(motion, "frequency", bounds=(0.8 * load.frequency, 1.2 * load.frequency))
    unstable = np.flatnonzero((branch.stable == 0) & (branch.admissible == 1))
    regular = np.isfinite(branch.multipliers).all(axis=0)
    behind = np.flatnonzero((branch.speeds < 0).any(axis=0) & (branch.admissible == 0) & regular)
    assert len(unstable) > 5
    assert len(behind) > 5  # an impact that meets its wall from behind
    for i in np.r_[unstable[::4], behind[::8]].tolist():
        found = branch[i]
        assert found.admissible == (branch.admissible[i] == 1)
        assert largest(found.multipliers) == pytest.approx(
            largest(branch.multipliers[:, i]), rel=1e-8
        )
        assert found.determinant == pytest.approx(found.law, rel=1e-8, abs=1e-13)


def test_a_branch_that_is_full_is_not_complete():
    branch = vi.branch(between_stops(), "frequency", bounds=(1.2, 3.0), max_points=20)
    assert "full" in branch.ends
    assert branch.complete is False
    assert branch.cut == "max_points = 20 was reached"
    assert vi.branch(between_stops(), "frequency", bounds=(1.9, 2.0)).complete


def test_closed_form_of_den_hartog():
    """Amplitudes along the frequency are those of the closed form."""
    f = 0.3
    motion = settled(den_hartog(f), vi.Load(0.8, cosine=[1.0]))
    branch = vi.branch(motion, "frequency", bounds=(0.6, 1.4))
    b, zeta = branch.values, DAMPING
    T, w = np.pi / b, np.sqrt(1 - zeta**2)
    square = (1 - b**2) ** 2 + (2 * zeta * b) ** 2
    below = np.cosh(zeta * T) + np.cos(w * T)
    G = (np.sinh(zeta * T) - zeta / w * np.sin(w * T)) / below
    H = np.sin(w * T) / (b * w * below)
    assert branch.q_max[0] == pytest.approx(-G * f + np.sqrt(1 / square - (H * f) ** 2), rel=1e-12)
    assert (branch.stable == 1).all()


def test_damping_and_stiffness_from_and_to_zero():
    """Bounds of 0, below which there is no damping and no stiffness, are reached and left."""
    load = vi.Load(0.6, cosine=[1.0])
    for damping in (0.0, 0.05):
        s = vi.Structure([1.0], [damping], [1.0], friction=[vi.Friction([1.0], 0.25)])
        motion = vi.exact(s, load, vi.simulate(s, load, cycles=300))
        branch = vi.branch(motion, "damping_0_0", bounds=(0.0, 0.1))
        assert [point.type for point in branch.special_points] == ["bound", "bound"]
        assert branch.values[0] == 0
        assert branch.values[-1] == pytest.approx(0.1, rel=1e-12)
        # the closed form without damping
        assert branch.q_max[0, 0] == pytest.approx(1.54387042190387, rel=1e-11)
        assert np.abs(branch.multipliers[:, 0]) == pytest.approx([0.37949352] * 2, abs=1e-7)
    teeth = [vi.Stop([side], 0.05, stiffness=2e4, damping=0.3) for side in (1.0, -1.0)]
    gears = vi.Structure([5e-4], [0.0], [0.0], teeth)
    load = vi.Load(5000.0, constant=[100.0], cosine=[30.0])
    motion = vi.exact(gears, load, vi.simulate(gears, load, cycles=300, state=([0.0675], [0.0])))
    branch = vi.branch(motion, "stiffness_0_0", bounds=(0.0, 1000.0))
    assert [point.type for point in branch.special_points] == ["bound", "bound"]
    assert apart(branch, 0) < 1e-8
    assert apart(branch, -1) < 1e-8


def test_friction_begins_to_stick():
    """On one side of the end a simulation reverses, on the other side it sticks."""
    motion = settled(den_hartog(0.3, 0.36), vi.Load(0.8, cosine=[1.0]))
    branch = vi.branch(motion, "slip", bounds=(0.1, 1.0))
    (end,) = (p for p in branch.special_points if p.type == "stick_begins")
    assert branch.ends == ("bound of the parameter", "friction begins to stick")
    assert end.detail == "friction 0"
    for value, halts in ((end.value - 1e-5, False), (end.value + 1e-5, True)):
        run = vi.simulate(*branch.at(value), cycles=10, discard=300)
        assert ("halt" in run.events["kind"]) == halts
    assert branch.at(0.2)[0].friction[0].stick == pytest.approx(0.24)


def test_a_stick_ends():
    """Where a stick would begin above the stick level, the motion is no longer admissible."""
    motion = settled(
        vi.Structure([1.0], [0.02], [1.0], friction=[vi.Friction([1.0], 0.6)]),
        vi.Load(0.4, cosine=[1.0]), 60,
    )  # fmt: skip
    branch = vi.branch(motion, "slip", bounds=(0.1, 0.99))
    points = [p for p in branch.special_points if p.type == "grazing"]
    # the second half of its events is the image of the first one
    assert [p.detail.split(" in ")[0] for p in points] == ["friction 0 does not stick"]
    value = points[0].value
    assert (branch.admissible[branch.values > value + 1e-9] == 1).all()
    assert (branch.admissible[branch.values < value - 1e-9] == 0).all()
    # on one side friction halts, on the other it reverses and halts later
    for shift, count in ((1e-4, 4), (-1e-4, 6)):
        run = vi.simulate(*branch.at(value + shift), cycles=2, discard=200)
        assert len(run.events) == 2 * count


def test_a_pitchfork():
    """A symmetric motion is followed over half a period, and its points describe the whole period."""
    point = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(1.04, 25.0, friction=0.05)
    motion = vi.exact(point, vi.simulate(point, cycles=300))
    branch = vi.branch(motion, "frequency", bounds=(1.02, 1.05))
    (fork,) = (p for p in branch.special_points if p.type == "pitchfork")
    near = np.abs(branch.values - fork.value).argmin()
    assert np.abs(branch.multipliers[:, near] - 1).min() < 1e-6
    assert not any(p.type == "fold" for p in branch.special_points)
    # it is stable on one side only
    apart = np.abs(branch.values - fork.value) > 1e-6
    assert (np.diff(branch.stable[apart]) != 0).sum() == 1
    i = np.abs(branch.values - 1.04).argmin()
    other = vi.exact(*branch.at(branch.values[i]), motion)
    for gap in (0, 1):
        own = branch.phases[branch.gaps == gap, i] - other.phases[other.gaps == gap]
        assert np.abs(np.exp(1j * own) - 1).max() < 1e-9
    assert branch.speeds[:, i] == pytest.approx(other.speeds[other.gaps < 2], rel=1e-9)
    found, wanted = (
        np.sort_complex(values) for values in (branch.multipliers[:, i], other.multipliers)
    )
    assert found == pytest.approx(wanted, abs=1e-8)
    times = (other.phases[0] + np.linspace(0, 2 * np.pi, 20001)) / other.load.frequency
    q = other.sample(times)[0]
    assert branch.q_max[:, i] == pytest.approx(q.max(axis=1), abs=1e-5)
    assert branch.q_min[:, i] == pytest.approx(q.min(axis=1), abs=1e-5)


def test_a_contact_vanishes():
    """A stop that is moved away is merely touched at the end, where the motion is the linear one."""
    load = vi.Load(0.7, cosine=[1.0])
    motion = settled(one_stop(0.5, stiffness=4), load)
    branch = vi.branch(motion, "opening", bounds=(0.1, 3.0))
    assert "a contact vanishes" in branch.ends
    (end,) = (p for p in branch.special_points if p.type == "contact_vanishes")
    amplitude = 1 / np.hypot(1 - 0.7**2, 0.1 * 0.7)
    assert end.value == pytest.approx(amplitude, abs=1e-9)
    assert end.detail == "stop 0"


def pressed(frequency, force, stop):
    """A mass that a constant force presses onto a stop, and that a load lifts off."""
    s = vi.Structure([1.0], [0.6], [1.0], [vi.Stop([1.0], **stop)])
    return s, vi.Load(frequency, cosine=[force], constant=[1.0])


def ends_of(frequency, force, stop, parameter=None, bounds=(0.01, 30.0)):
    """The branch, the fraction of time in contact at its start, and points where a contact or flight vanishes."""
    s, load = pressed(frequency, force, stop)
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=300))
    if parameter is None:
        branch = vi.branch(motion, lambda f: pressed(frequency, f, stop), bounds=bounds, at=force)
    else:
        branch = vi.branch(motion, parameter, bounds=bounds)
    touched = motion.sample(np.linspace(0, 2 * np.pi * motion.cycles / frequency, 999))[0][0]
    kinds = ("contact_vanishes", "flight_vanishes")
    return (
        branch, np.mean(touched > s.gaps[0].opening),
        [p for p in branch.special_points if p.type in kinds],
    )  # fmt: skip


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_a_flight_vanishes(damping):
    """Both where the period begins with the flight that vanishes and where it begins with the contact, a stop is
    left until the amplitude of the motion in contact is its static displacement."""
    stop = {"opening": 0.0, "stiffness": 10.0, "damping": damping}
    for frequency, forces in ((3.0, (0.8, 2.5)), (6.0, (2.5, 12.0))):
        wanted = abs(11 - frequency**2 + 1j * frequency * (0.6 + damping)) / 11
        values, shares = [], []
        for force in forces:
            branch, share, points = ends_of(frequency, force, stop)
            assert branch.ends[0] == "a flight vanishes"
            assert points[0].type == "flight_vanishes"
            assert points[0].detail == "stop 0"
            values.append(points[0].value)
            shares.append(share)
            # the derivative of the period is that of the motion in contact, whatever the flight
            last = branch.multipliers[:, points[0].index]
            trace = (0.6 + damping) * 2 * np.pi / frequency
            assert np.prod(last) == pytest.approx(np.exp(-trace), rel=1e-7)
        assert values == pytest.approx([wanted] * 2, abs=1e-9)
        if frequency == 3.0:
            assert min(shares) < 0.5 < max(shares)


@pytest.mark.parametrize("opening", [-0.6, 0.6])
def test_a_contact_vanishes_wherever_the_period_begins(opening):
    """The stop is merely touched where its opening is the largest displacement without it."""
    stop = {"opening": opening, "stiffness": 10.0}
    branch, share, points = ends_of(3.0, 1.2, stop, "opening", (-1.0, 3.0))
    assert (share > 0.5) == (opening < 0)
    assert branch.ends[1] == "a contact vanishes"
    assert points[-1].value == pytest.approx(1 + 1.2 / abs(1 - 9 + 1.8j), abs=1e-9)


def test_a_preloaded_stop_is_only_just_touched():
    """The force jumps: a multiplier grows without bound, and the motion at the end has no multipliers."""
    stop = {"opening": 0.3, "stiffness": 10.0, "preload": 0.3}
    branch, _, points = ends_of(3.0, 1.2, stop, "opening", (-1.0, 3.0))
    assert points[-1].value == pytest.approx(1 + 1.2 / abs(1 - 9 + 1.8j), abs=1e-9)
    moduli = np.abs(branch.multipliers).max(axis=0)
    assert np.isnan(moduli[-1])
    assert branch.stable[-1] == -1
    distance = points[-1].value - branch.values
    near = (distance < 1e-4) & (distance > 0)
    assert near.sum() >= 5
    # the speed of the touch, the inverse of that multiplier, falls in proportion to the distance
    assert moduli[near] * distance[near] == pytest.approx(moduli[-2] * distance[-2], rel=0.02)


def test_a_stop_is_touched_in_between():
    """Where a second stop is reached, the motion is no longer admissible; simulations touch the stop."""
    stops = [vi.Stop([1.0], 0.5, 5.0), vi.Stop([-1.0], 2.0, 50.0)]
    s, load = vi.Structure([1.0], [0.3], [1.0], stops), vi.Load(0.7, cosine=[1.0])
    branch = vi.branch(settled(s, load), "load", bounds=(0.9, 6.0))
    (point,) = (p for p in branch.special_points if p.detail.startswith("stop 1 is touched"))
    assert point.type == "grazing"
    inside = vi.exact(
        *branch.at(point.value - 1e-6), branch[np.flatnonzero(branch.admissible == 1)[-1]]
    )
    assert 1 not in inside.gaps
    beyond = vi.exact(*branch.at(point.value + 1e-6), inside)
    assert 1 in beyond.gaps
    # stops that are touched change neither the motion nor its derivative abruptly
    assert beyond.multipliers == pytest.approx(inside.multipliers, abs=0.1)


def test_stiff_stops():
    """As the stiffness grows, the multipliers tend to those of the rigid wall, as k^(-1/2)."""
    s, load = one_stop(1.0, stiffness=1e3), vi.Load(1.0, cosine=[1.0])
    branch = vi.branch(settled(s, load), lambda logarithm: (
        one_stop(1.0, stiffness=10**logarithm), load), bounds=(3, 9), at=3.0)  # fmt: skip
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 1.0)])
    guess = vi.exact(wall, load, ([branch.phases[0, -1]], [0]))
    distance = np.abs(
        np.sort_complex(branch.multipliers.T) - np.sort_complex(guess.multipliers)
    ).max(axis=1)
    stiff = branch.values > 6
    slope = np.polyfit(branch.values[stiff], np.log10(distance[stiff]), 1)[0]
    assert slope == pytest.approx(-0.5, abs=0.01)


def test_of_a_file(tmp_path):
    """A branch is unchanged by saving it, and by running its namelist."""
    motion = settled(den_hartog(0.3), vi.Load(0.8, cosine=[1.0]))
    branch = vi.branch(motion, "slip", bounds=(0.2, 0.4))
    branch.save(tmp_path / "branch.json")
    loaded = vi.load(tmp_path / "branch.json")
    assert np.array_equal(loaded.multipliers, branch.multipliers)
    assert apart(loaded, len(loaded) - 2) < 1e-12
    case = tmp_path / "branch.nml"
    case.write_text(branch.to_namelist())
    vi.run_namelists([case], tmp_path)
    lines = (tmp_path / "branch.csv").read_text().splitlines()
    assert sum(not line.startswith("#") for line in lines) == len(branch) + 1


@pytest.mark.parametrize(("parameter", "message"), [
    ("contact", "it changes nothing in this structure"), ("restitution", "it changes nothing"),
    ("slip_4", "the structure has 1 gap, stop or friction element"),
])  # fmt: skip
def test_parameters_that_it_has_not(parameter, message):
    motion = settled(den_hartog(0.3), vi.Load(0.8, cosine=[1.0]))
    with pytest.raises(vi.ParameterError, match=message):
        vi.branch(motion, parameter, bounds=(0.2, 3.0))
