"""Branches and zones of motions of structures with rests, compared with simulations and oscillator zones."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, SingularError
from vibroimpact.motions.exact import settled

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))


def period(branch):
    return 2 * np.pi * branch.cycles


def middle(motion):
    """The load phase in the middle of the longest flight or rest, and the state there."""
    ends = [phase for _, *both in motion.rests for phase in both]
    whole = 2 * np.pi * motion.cycles
    events = np.sort(np.mod([*motion.phases, *ends], whole))
    lengths = np.diff([*events, events[0] + whole])
    i = int(lengths.argmax())
    phase = events[i] + lengths[i] / 2
    q, rate = motion.sample([phase / motion.load.frequency])
    return phase, q[:, 0], rate[:, 0]


def from_motion(motion, system):
    """The motion of a changed system, simulated from the middle of a flight of this one."""
    phase, q, rate = middle(motion)
    return settled(*system, phase / system[1].frequency, (q, rate), cycles=motion.cycles)


def agrees(branch, i):
    """Whether a point of a branch is the motion that a simulation from it gives."""
    motion = branch[i]
    assert motion.admissible
    assert sorted(gap for gap, _, _ in motion.rests) == sorted(branch.resting)
    ours, theirs = np.sort(abs(branch.multipliers[:, i])), np.sort(abs(motion.multipliers))
    assert ours == pytest.approx(theirs, abs=1e-7 * max(1, theirs.max()))
    half = period(branch) / 2
    for rest in branch.rests[:, :, i]:
        apart = [
            np.abs(np.mod(rest - np.array(both) + half, 2 * half) - half).max()
            for _, *both in motion.rests
        ]
        assert min(apart) < 1e-8
    return motion


def inner(branch):
    return [int(i) for i in np.flatnonzero(branch.admissible == 1)]


@pytest.fixture(scope="module")
def start():
    structure, load = OSC.at(0.9, 6.0).structure, OSC.at(0.9, 6.0).load
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=200))
    assert len(motion.rests) == 1
    return motion


@pytest.fixture(scope="module")
def path(start):
    return vi.branch(start, "frequency", bounds=(0.7, 1.3))


def test_points_are_those_of_simulations(start, path):
    assert path.ends == ("a rest vanishes", "a rest vanishes")
    assert path.residual.max() < 1e-13
    assert sorted(path.gaps) == [0, 1, 1, 1, 1]
    for i in inner(path)[:: len(inner(path)) // 5]:
        agrees(path, i)
    # the start is the motion itself
    i = int(abs(path.values - start.load.frequency).argmin())
    assert np.sort(abs(path.multipliers[:, i])) == pytest.approx(
        np.sort(abs(start.multipliers)), abs=1e-9
    )


def test_multipliers_are_those_of_the_simulated_period(path):
    """Two multipliers are 0; the others equal those of differences of simulated periods."""
    i = inner(path)[3]
    motion = path[i]
    structure, load = path.at(path.values[i])
    phase, q, rate = middle(motion)
    t, state = phase / load.frequency, np.concatenate([q, rate])

    def image(s):
        run = vi.simulate(structure, load, cycles=path.cycles, state=(s[:2], s[2:]), start=t)
        return np.concatenate(run.final_state)

    h = 1e-6 * np.array([abs(q).max()] * 2 + [abs(rate).max()] * 2)
    p = np.array([(image(state + d) - image(state - d)) / (2 * d.max()) for d in np.diag(h)]).T
    found = np.sort(abs(np.linalg.eigvals(p)))
    assert found == pytest.approx(np.sort(abs(path.multipliers[:, i])), abs=1e-6)
    assert np.sort(abs(path.multipliers[:, i]))[:2] == pytest.approx(0, abs=1e-9)


def test_ends_are_the_boundary_of_the_zone_of_the_oscillator(path):
    zone = vi.zone(OSC, "RL*", r=(0.89, 0.92), clearance=(5.9, 6.1))
    crossings = []
    for piece in zone.boundary:
        r, d = np.asarray(piece.r), np.asarray(piece.clearance)
        for j in np.flatnonzero((d[:-1] - 6) * (d[1:] - 6) < 0):
            assert piece.type == "rest_vanishes"
            crossings.append(r[j] + (6 - d[j]) / (d[j + 1] - d[j]) * (r[j + 1] - r[j]))
    ends = [point.value for point in path.special_points if point.type == "rest_vanishes"]
    assert sorted(ends) == pytest.approx(sorted(crossings), abs=1e-6)


def test_a_rest_vanishes_where_simulations_have_none(path):
    """Just inside each end the simulated motion rests, just outside it does not."""
    for end, inward in ((0, 1), (-1, -1)):
        near = path[inner(path)[0 if end == 0 else -1]]
        at = path.values[end]
        for share, rests in ((1e-5, 1), (-1e-5, 0)):
            run = vi.simulate(*path.at(at + inward * share * at), cycles=300)
            try:
                found = len(vi.exact(*path.at(at + inward * share * at), run).rests)
            except SingularError:
                found = 0
            assert found == rests
        assert len(near.rests) == 1


def test_that_of_an_oscillator_is_followed_as_a_structure():
    motion = vi.exact(OSC, 0.9, 6.0, vi.simulate(OSC, 0.9, 6.0, cycles=200))
    with pytest.raises(ParameterError, match=r"without rest; .*osc\.at\(r, clearance\)"):
        vi.branch(motion, "r", bounds=(0.8, 1.0))


def test_without_restitution():
    """An impact without restitution begins its rest, and makes two multipliers 0."""
    stops = [vi.Gap([-1, 1], 1.2, 0.0), vi.Gap([1, -1], 1.2, 0.0)]
    structure = vi.Structure([1, 0.2], [0.05, 0], [1, 0], stops)
    load = vi.Load(0.85, sine=[1, 0])
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=300))
    assert len(motion.rests) == len(motion.gaps) == 2
    branch = vi.branch(motion, "opening", bounds=(0.6, 6.0))
    assert branch.residual.max() < 1e-12
    for i in inner(branch)[:: max(1, len(inner(branch)) // 5)]:
        agrees(branch, i)
        assert np.sort(abs(branch.multipliers[:, i]))[:2] == pytest.approx(0, abs=1e-10)


def random_structure(seed):
    """A chain with one or two free masses between walls, and its load."""
    g = np.random.default_rng(seed)
    hosts = int(g.integers(1, 4))
    parts = int(g.integers(1, 3)) if hosts > 1 else 1
    n = hosts + parts
    mass = np.diag(np.r_[g.uniform(0.5, 1.5, hosts), g.uniform(0.03, 0.4, parts)])
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    for i in range(hosts):
        k, c = g.uniform(0.5, 2), g.uniform(0.02, 0.1)
        for matrix, value in ((stiffness, k), (damping, c * k)):
            matrix[i, i] += value
            if i:
                matrix[i - 1, i - 1] += value
                matrix[i, i - 1] -= value
                matrix[i - 1, i] -= value
    gaps = []
    for p, host in enumerate(g.permutation(hosts)[:parts]):
        direction = np.zeros(n)
        direction[hosts + p], direction[host] = 1, -1
        opening = g.uniform(0.1, 1.2)
        gaps += [vi.Gap(s * direction, opening, float(g.uniform(0, 0.6))) for s in (1, -1)]
    force = np.zeros(n)
    force[g.integers(0, hosts)] = 1
    return vi.Structure(mass, damping, stiffness, gaps), vi.Load(
        float(g.uniform(0.5, 1.6)), sine=force
    )


@pytest.mark.parametrize("seed", range(12))
def test_random_structures(seed):
    """Points are reproduced by simulation; beyond an end the simulated motion is different."""
    structure, load = random_structure(seed)
    try:
        motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=300))
    except SingularError:
        return
    if not len(motion.rests) or len(motion.rests) > 4:
        return
    try:
        branch = vi.branch(
            motion, "frequency", bounds=(0.95 * load.frequency, 1.05 * load.frequency)
        )
    except SingularError as error:
        assert "can be followed" in str(error) or "cannot be followed" in str(error)  # noqa: PT017
        return
    assert branch.residual.max() < 1e-10
    for i in inner(branch)[:: max(1, len(inner(branch)) // 4)]:
        agrees(branch, i)
    for point in branch.special_points:
        if point.type != "rest_vanishes":
            continue
        near = [j for j in (point.index - 1, point.index + 1) if 0 <= j < len(branch)]
        near = [j for j in near if branch.admissible[j] == 1]
        if len(near) != 1:
            continue
        inside = branch[near[0]]
        step = 1e-3 * (branch.values[near[0]] - point.value)
        assert len(from_motion(inside, branch.at(point.value + step)).rests) == len(branch.resting)
        try:
            beyond = from_motion(inside, branch.at(point.value - step))
        except SingularError:
            continue
        assert len(beyond.rests) < len(branch.resting)


def test_zone(start):
    """The zone over frequency and opening equals that of the oscillator."""
    ours = vi.zone(start, ("frequency", 0.85, 0.95), ("opening", 2.25, 3.75), lines=9)
    theirs = vi.zone(OSC, "RL*", r=(0.85, 0.95), clearance=(4.5, 7.5))
    assert ours.closed
    assert {piece.type for piece in ours.boundary} == {"rest_vanishes", "window"}
    g = np.random.default_rng(0)
    r, d = g.uniform(0.85, 0.95, 400), g.uniform(4.5, 7.5, 400)
    inside = [theirs.contains(*place) for place in zip(r, d, strict=True)]
    assert sum(inside) > 20
    same = [ours.contains(a, b / 2) == c for a, b, c in zip(r, d, inside, strict=True)]
    # a point may be between the two polygons
    assert sum(same) >= 399


@pytest.mark.slow
def test_zone_without_restitution():
    """With R = 0 on one wall the zone of the structure equals that of the oscillator, and has the same bounds."""
    osc = vi.Oscillator(xi=0.0114, mu=0.1, restitution=(0.0, 0.4))
    point = osc.at(1.1, 2.0)
    system = point.structure, point.load
    motion = vi.exact(*system, vi.simulate(*system, cycles=300))
    ours = vi.zone(motion, ("frequency", 1.045, 1.155), ("opening", 0.8, 1.25), lines=9)
    theirs = vi.zone(osc, "LLR*", r=(1.045, 1.155), clearance=(1.6, 2.5))
    assert ours.closed
    assert theirs.closed
    kinds = {"grazing", "neimark_sacker", "window"}
    assert (
        {piece.type for piece in ours.boundary}
        == {piece.type for piece in theirs.boundary}
        == kinds
    )
    assert ours.motion(1.1, 1.0).phases == pytest.approx(motion.phases, abs=1e-9)
    for place in ((1.07, 0.9), (1.13, 1.15), (1.06, 1.2)):
        here = ours.motion(*place)
        assert (here is not None and bool(here.stable)) == ours.contains(*place)
        if here is not None:
            assert here.load.frequency == pytest.approx(place[0], rel=1e-15)
            assert here.structure.gaps[0].opening == pytest.approx(place[1], rel=1e-15)
            assert len(here.rests) == 1
    g = np.random.default_rng(1)
    places = np.c_[g.uniform(1.045, 1.155, 400), g.uniform(1.6, 2.5, 400)]
    inside = [theirs.contains(*place) for place in places]
    assert 20 < sum(inside) < 380
    same = [ours.contains(r, d / 2) == c for (r, d), c in zip(places, inside, strict=True)]
    assert sum(same) >= 399


def test_a_doubled_period_ends_at_its_flip():
    """The branch of two cycles ends where that of one cycle has a flip."""
    mass = np.diag([0.9686158, 0.6142644, 0.6139588, 0.2093925])
    damping = np.zeros((4, 4))
    damping[:3, :3] = np.diag([0.1443962, 0.0591162, 0.0241265])
    damping[[0, 1, 1, 2], [1, 0, 2, 1]] = [-0.0349897, -0.0349897, -0.0241265, -0.0241265]
    stiffness = np.zeros((4, 4))
    stiffness[:3, :3] = np.diag([2.1430467, 1.6838206, 0.7821298])
    stiffness[[0, 1, 1, 2], [1, 0, 2, 1]] = [-0.9016908, -0.9016908, -0.7821298, -0.7821298]
    gaps = [vi.Gap([0, -1, 0, 1], 0.925725, 0.092461), vi.Gap([0, 1, 0, -1], 0.925725, 0.362896)]
    structure = vi.Structure(mass, damping, stiffness, gaps)
    ends = []
    for frequency, cycles in ((0.636, 1), (0.6376, 2)):
        load = vi.Load(frequency, sine=[1, 0, 0, 0], constant=[0, 0, 0, -0.071005])
        motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=400))
        assert motion.cycles == cycles
        ends.append(vi.branch(motion, "frequency", bounds=(0.62, 0.66)))
    one, two = ends
    assert two.ends[0] == "meets a motion that repeats itself"
    (end,) = [point for point in two.special_points if point.index == 0]
    assert end.type == "flip"
    flips = [point.value for point in one.special_points if point.type == "flip"]
    assert min(abs(value - end.value) for value in flips) < 1e-6


@pytest.mark.slow
def test_zone_ends_where_events_exchange():
    """Lines are not followed beyond two simultaneous events; the zone has a bound there."""
    structure, load = random_structure(28)
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=300))
    low, high = 0.97 * load.frequency, 1.03 * load.frequency
    path = vi.branch(motion, "frequency", bounds=(low, high))
    assert path.ends == ("two impacts at one instant",) * 2
    first, last = (point.value for point in path.special_points)
    zone = vi.zone(motion, ("frequency", low, high), ("load", 0.98, 1.02), lines=5)
    step = 0.1 * (last - first)
    assert zone.contains([first + step, last - step, first - step, last + step], 1.0).tolist() == [
        True, True, False, False,
    ]  # fmt: skip
