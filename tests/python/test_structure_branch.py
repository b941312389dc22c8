"""Branches and zones of structures: those of the oscillator by another method, and laws on random structures."""

import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from test_structure_motion import damper, random_structure
from vibroimpact.base.errors import ParameterError, ParameterTypeError, SingularError

XI, MU, RESTITUTION = 0.005, 0.042, 0.75
#: Phases of the third column of Table 1 of the 1983 paper.
PHASES = [0.517272128279 * math.pi, 1.899298624085 * math.pi]


@pytest.fixture(scope="module")
def pair():
    """The motion of the third column of Table 1, of a structure and of the oscillator."""
    structure = vi.exact(damper(), vi.Load(0.94, sine=[1, 0]), (PHASES, [0, 1]))
    osc = vi.Oscillator(xi=XI, mu=MU, restitution=RESTITUTION)
    return structure, vi.exact(osc, 0.94, 37.0, ([0, PHASES[1] - PHASES[0]], vi.Pattern("RL")))


@pytest.mark.parametrize(
    ("name", "bounds", "parameter", "factor"),
    [
        ("opening", (5, 30), "clearance", 2), ("frequency", (0.85, 1.1), "r", 1),
        ("restitution", (0.4, 0.95), "restitution", 1), ("damping", (0.2, 10), "xi", XI),
        ("mass_1_1", (0.01, 0.2), "mu", 1), ("damping_0_0", (0.002, 0.1), "xi", 0.5),
    ],
)  # fmt: skip
def test_branches_of_the_oscillator(pair, name, bounds, parameter, factor):
    """Both tracers find the same special points in the same order, and the same multipliers there."""
    structure, motion = pair
    ours = vi.branch(structure, name, bounds)
    theirs = vi.branch(motion, parameter, tuple(factor * x for x in bounds))
    assert [p.type for p in ours.special_points] == [p.type for p in theirs.special_points]
    for here, there in zip(ours.special_points, theirs.special_points, strict=True):
        assert here.value * factor == pytest.approx(theirs.values[there.index], rel=1e-9)
        assert np.poly(ours.multipliers[:, here.index]) == pytest.approx(
            np.poly(there.motion.multipliers), abs=1e-7
        )
    assert len(ours.special_points) > 1


def test_a_load_factor_is_an_inverse_opening(pair):
    """Motions under twice the load equal those with half the openings."""
    loads = vi.branch(pair[0], "load", (18.5 / 30, 18.5 / 5)).special_points
    openings = vi.branch(pair[0], "opening", (5, 30)).special_points
    found = [(p.type, 18.5 / p.value) for p in reversed(loads)]
    assert [p.type for p in openings] == [kind for kind, _ in found]
    assert [p.value for p in openings] == pytest.approx([value for _, value in found], rel=1e-9)


def test_symmetric_motions_are_followed_through_pitchforks():
    """Special points from the map of half a period equal those of the oscillator's branch."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    motion = vi.exact(osc, 1.04, 25.0, vi.simulate(osc, 1.04, 25.0, cycles=100, discard=500))
    structure = damper(0.0114, 0.028, 0.75, 25.0)
    load = vi.Load(1.04, sine=[1, 0])
    same = vi.exact(structure, load, vi.simulate(structure, load, cycles=600))
    ours = vi.branch(same, "opening", (5, 50)).special_points
    theirs = vi.branch(motion, "clearance", (10, 100)).special_points
    assert [p.type for p in ours] == ["bound", "pitchfork", "neimark_sacker", "bound"]
    assert [2 * p.value for p in ours] == pytest.approx([p.clearance for p in theirs], rel=1e-9)


def followed(seeds, names=None):
    """Branches of random structures with dampers, springs and free hosts, along some parameters or all."""
    for seed in seeds:
        rng = np.random.default_rng(seed)
        structure, load = random_structure(rng)
        motions = [m for m in vi.find(structure, load) if not len(m.rests) and len(m.phases) <= 8]
        if not motions:
            continue
        last = structure.coordinates - 1
        bounds = {
            "frequency": (0.9 * load.frequency, 1.1 * load.frequency), "load": (0.7, 1.4),
            "opening_0": (0.8 * structure.gaps[0].opening, 1.2 * structure.gaps[0].opening),
            "restitution_1": (0.25, 0.95), "damping": (0.6, 1.8), "stiffness": (0.9, 1.1),
            f"mass_{last}_{last}": (0.8 * structure.mass[-1, -1], 1.3 * structure.mass[-1, -1]),
        }  # fmt: skip
        for name, ends in bounds.items():
            if names is None or name in names:
                yield name, vi.branch(motions[0], name, ends)


def law_of(kind, branch, i):
    """The error of a special point in its defining equation."""
    multipliers = branch.multipliers[:, i]
    if kind not in ("zero_approach", "simultaneous") and (branch.speeds[:, i] <= 0).any():
        return 0.0  # beyond a zero of an approach speed there are no motions, and no multipliers
    if kind in ("fold", "pitchfork"):
        return np.abs(multipliers - 1).min()
    if kind == "flip":  # of the motion, or of the motion of half the period that it meets
        return min(np.abs(multipliers + 1).min(), np.abs(multipliers - 1).min())
    if kind == "neimark_sacker":
        pairs = multipliers[np.abs(multipliers.imag) > 1e-9]
        return np.abs(np.abs(pairs) - 1).min()
    if kind == "zero_approach":  # the period has no derivative there
        assert np.isnan(multipliers).all()
        assert (branch.admissible[i], branch.stable[i]) == (0, -1)
        return np.abs(branch.speeds[:, i]).min()
    if kind == "simultaneous":
        ends = np.append(branch.phases[:, i], branch.phases[0, i] + 2 * np.pi * branch.cycles)
        return np.abs(np.diff(ends)).min()
    return 0.0


@pytest.mark.slow
def test_steps_stay_long_where_a_flight_almost_turns():
    """A branch reaches both bounds: touches between which a gap hardly reverses do not shorten its steps."""
    structure = vi.Structure(
        [0.15160234932171657], [0.004418069137949157], [2.6794677613851765],
        [vi.Gap([-1.0], 0.1580136296304347, 0.49250317537882704)],
    )  # fmt: skip
    load = vi.Load(2.4770522889533924, sine=[1.5840719629109627])
    phases = [3.454877987621631, 4.742010051746551, 5.55253254785381]
    motion = vi.exact(structure, load, (phases, [0, 0, 0], 1))
    bounds = (1.2572758538098363, 2.8818200105702045)
    branch = vi.branch(motion, "frequency", bounds, max_points=1000)
    assert branch.ends == ("bound of the parameter",) * 2
    assert sorted(branch.values[[0, -1]]) == pytest.approx(bounds, rel=1e-12)
    assert len(branch) < 700


def midway(motion):
    """The midpoint of the phases of a two-impact motion on opposite walls and its image with swapped walls."""
    assert motion.gaps.tolist() == [0, 1]
    assert motion.cycles == 1
    return (motion.phases + motion.phases[::-1] + [-math.pi, math.pi]) / 2


@pytest.mark.slow
def test_motions_of_branches_are_starts(pair):
    """The motion at any point, including a fold, can start simulations, exact motions and branches."""
    shifted = ([phase - 2 * math.pi for phase in PHASES], [0, 1])
    motion = vi.exact(damper(), vi.Load(0.94, sine=[1, 0]), shifted)
    assert motion.phases == pytest.approx(pair[0].phases, abs=1e-12)
    branches = [vi.branch(motion, "frequency", (0.8, 1.2))]
    branches += [branch for _, branch in followed([0, 1], ("frequency", "restitution_1"))]
    kinds = set()
    for branch in branches:
        assert branch.phases.min() >= 0
        special = {point.index: point.type for point in branch.special_points}
        for i in sorted({*range(0, len(branch), 20), *special}):
            here = branch[i]
            kinds.add(special.get(i, ""))
            start, omega = here.phases[0] / here.load.frequency, here.load.frequency
            same = vi.exact(here.structure, here.load, here)
            if special.get(i) == "pitchfork":
                # the motion meets its image there: rounding changes their distance up to its cube
                # root, but the midpoint motion is regular
                assert midway(same) == pytest.approx(midway(here), abs=1e-9)
                for each in (same, here):
                    assert each.phases == pytest.approx(midway(each), abs=3e-5)
            else:
                assert same.phases == pytest.approx(here.phases, abs=1e-5)
            assert len(vi.branch(here, "frequency", (0.995 * omega, 1.005 * omega))) > 1
            if special.get(i) != "simultaneous":
                state = (here.q, here.q_dot)
                run = vi.simulate(
                    here.structure, here.load, duration=1e-3, start=start, state=state
                )
                assert run.start == start
    assert {"", "fold", "flip", "pitchfork", "grazing"} <= kinds


@pytest.mark.slow
def test_special_points_of_random_structures():
    """Each special point obeys its law; verdicts change only at special points; grazes touch."""
    kinds = set()
    # other cases have no motion; 7, a large structure, takes as long as all of these
    for name, branch in followed([0, 1, 3, 8, 9, 11]):
        special = {point.index: point for point in branch.special_points}
        assert branch.residual.max() < 1e-9, name
        for i, point in special.items():
            kinds.add(point.type)
            assert law_of(point.type, branch, i) < 1e-6, (name, point)
            if point.type == "grazing" and branch.admissible[i - 1] + branch.admissible[i + 1] == 1:
                motion = branch[i]
                t = np.linspace(0, motion.period, 40_001)
                q, _ = motion.sample(t + motion.phases[0] / motion.load.frequency)
                gap = int(point.detail.split()[-1])
                apart = (
                    motion.structure.gaps[gap].opening - motion.structure.gaps[gap].direction @ q
                )
                assert abs(apart.min()) < 1e-5 * np.ptp(q), (name, point)
        largest = np.abs(branch.multipliers).max(axis=0)
        for verdict in (branch.admissible, branch.stable):
            for i in np.flatnonzero(verdict[:-1] + verdict[1:] == 1).tolist():
                # rounding decides where a motion repeats itself, and where multipliers are huge
                if np.abs(largest[i : i + 2] - 1).min() < 1e-7 or largest[i] > 1e6:
                    continue
                if {verdict[i], verdict[i + 1]} == {0, 1}:
                    assert i in special or i + 1 in special, (name, branch.values[i])
    assert {"fold", "flip", "neimark_sacker", "grazing", "zero_approach", "simultaneous"} <= kinds


def test_points_are_exact_motions(pair):
    """Phases, speeds and extremes of a point equal those of its motion, which has the parameter's value."""
    branch = vi.branch(pair[0], "opening", (15, 30))
    for i in range(0, len(branch), 9):
        motion = branch[i]
        assert motion.consistent
        assert motion.structure.gaps[1].opening == branch.values[i]
        assert motion.speeds == pytest.approx(branch.speeds[:, i], rel=1e-11)
        assert motion.impulses == pytest.approx(branch.impulses[:, i], rel=1e-11)
        assert abs(motion.determinant - motion.law) < 1e-12
        # a coordinate can be largest at an impact, where its velocity jumps
        t = np.append(np.linspace(0, motion.period, 20_001), motion.phases / motion.load.frequency)
        q, _ = motion.sample(t)
        scale = np.ptp(q, axis=1)
        assert (np.abs(q.max(axis=1) - branch.q_max[:, i]) < 1e-6 * scale).all()
        assert (np.abs(q.min(axis=1) - branch.q_min[:, i]) < 1e-6 * scale).all()


def rotor(p):
    """A damper whose host has a mass and a stiffness that depend on one parameter."""
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    structure = vi.Structure([1 + 0.1 * p**2, 0.042], [0.01, 0], [math.exp(0.1 * p), 0], gaps)
    return structure, vi.Load(0.94 + 0.02 * math.sin(p), sine=[1, 0])


def test_any_function_of_a_parameter(pair):
    """Each point has the structure given by the function; special points are those of the named parameter."""
    branch = vi.branch(pair[0], rotor, (-0.5, 0.5), at=0.0)
    for i in range(0, len(branch), 7):
        structure, load = rotor(float(branch.values[i]))
        motion = branch[i]
        assert motion.structure.mass == pytest.approx(structure.mass, abs=1e-14)
        assert motion.structure.stiffness == pytest.approx(structure.stiffness, abs=1e-14)
        exact = vi.exact(structure, load, motion)
        assert exact.phases == pytest.approx(branch.phases[:, i], abs=1e-9)

    def opening(p):
        gaps = [vi.Gap([-1, 1], p, 0.75), vi.Gap([1, -1], p, 0.75)]
        return vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps), vi.Load(0.94, sine=[1, 0])

    one = vi.branch(pair[0], opening, (5, 30), at=18.5).special_points
    other = vi.branch(pair[0], "opening", (5, 30)).special_points
    assert [p.value for p in one] == pytest.approx([p.value for p in other], rel=1e-11)


def test_restitution_that_depends_on_the_speed():
    """Where the points are stable, simulations settle on them; [P] obeys its law with R'(v)."""
    law = vi.PowerLaw(0.9, speed=1.0, exponent=0.25)
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, law)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    branch = vi.branch(motion, "restitution", (0.7, 1.0))
    settled = 0
    for i in range(0, len(branch), 8):
        here = branch[i]
        assert here.structure.gaps[0].restitution.R0 == branch.values[i]
        assert abs(here.determinant - here.law) < 1e-12
        if not here.stable:
            continue
        state = (here.q - 1e-3, here.q_dot)
        start = here.phases[0] / here.load.frequency
        run = vi.simulate(here.structure, here.load, cycles=400, start=start, state=state)
        assert run.events["speed"][-1] == pytest.approx(here.speeds[0], rel=1e-9)
        settled += 1
    assert settled > 2


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"parameter": "width"}, ["parameter", "width", "no such parameter"]),
        ({"parameter": "opening_7"}, ["opening_7", "2 gaps"]),
        ({"parameter": "mass_0"}, ["mass_0", "row and column"]),
        ({"parameter": "frequency_1"}, ["frequency_1", "no numbers"]),
        ({"parameter": "constant"}, ["constant", "it changes nothing"]),
        ({"parameter": "restitution", "bounds": (0.5, 1.2)}, ["bounds[1] = 1.2", "from 0 to 1"]),
        ({"parameter": "restitution", "bounds": (-0.1, 1)}, ["bounds[0] = -0.1", "from 0 to 1"]),
        ({"parameter": "frequency", "bounds": (-1, 2)}, ["bounds[0] = -1.0", "above 0"]),
        ({"parameter": "damping", "bounds": (-1, 2)}, ["bounds[0] = -1.0", "at least 0"]),
        ({"bounds": (20, 30)}, ["bounds[0] = 20", "18.5"]),
        ({"bounds": (30, 20)}, ["bounds[1] = 20", "above bounds[0]"]),
        ({"bounds": (math.nan, 30)}, ["bounds[0]", "nan"]), ({"bounds": 3}, ["bounds", "3"]),
        ({"parameter": ""}, ["parameter", "no such parameter"]),
        ({"at": 1.0}, ["at", "function"]), ({"parameter": rotor}, ["at"]),
        ({"parameter": rotor, "bounds": (-1, 1), "at": 0.5}, ["at", "0.5", "differ from those of the motion"]),
        ({"longest_step": 0.0}, ["longest_step", "0"]), ({"max_points": 3}, ["max_points", "3"]),
    ],
)  # fmt: skip
def test_bad_options_are_named(pair, options, words):
    with pytest.raises((ParameterError, ParameterTypeError)) as error:
        vi.branch(pair[0], **{"parameter": "opening", "bounds": (5, 30), **options})
    for word in words:
        assert word in str(error.value)


def test_series_that_do_not_meet_the_motion_are_named(tmp_path):
    """A namelist whose series give a different structure at the motion is refused."""
    text = """&structure mass = 1, damping = 0.1, stiffness = 1 /
    &gap direction = 1, opening = 1, restitution = 0.8 /
    &load frequency = 1, cosine = 1 /
    &motion gaps = 0, phases = 0.1 /
    &branch parameter = 'function', low = 0.6, high = 3, at = 2.5, entries = 7, 0, 0, series = 1.8, 1.2 /
    """
    with pytest.raises(ParameterError, match="series of entry 1 is"):
        vi.read_namelist(_written(tmp_path, text))


def test_a_function_keeps_the_laws_of_restitution(pair):
    """A function of a parameter may change R and R0, but no other numbers of a law of restitution."""

    def slower(p):
        gaps = [
            vi.Gap(sign * np.array([-1, 1]), 18.5, vi.PowerLaw(0.75, p, 0.2)) for sign in (1, -1)
        ]
        return vi.Structure([1, p * MU], [2 * XI, 0], [1, 0], gaps), vi.Load(0.94, sine=[1, 0])

    with pytest.raises(ParameterError, match="a different law of restitution"):
        vi.branch(pair[0], slower, (0.5, 1.5), at=1.0)


def test_units_do_not_matter():
    """In another unit of mass, a structure with a free mass has the same branch with about as many points."""
    found = []
    for unit in (1.0, 1e-9, 1e9):
        gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
        mass, damping, stiffness = np.array([[1, MU], [2 * XI, 0], [1, 0]]) * unit
        structure = vi.Structure(mass, damping, stiffness, gaps)
        motion = vi.exact(structure, vi.Load(0.94, sine=[unit, 0]), (PHASES, [0, 1]))
        found.append(vi.branch(motion, "opening", (15, 30)))
    for other in found[1:]:
        assert len(other) == pytest.approx(len(found[0]), rel=0.05)
        assert [p.type for p in other.special_points] == [p.type for p in found[0].special_points]
        assert [p.value for p in other.special_points] == pytest.approx(
            [p.value for p in found[0].special_points], rel=1e-9
        )


def one_wall(load):
    """A motion with one impact on one wall in each load cycle."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    return vi.branch(motion, "load", (load, 2.0))[0]


def test_a_zone_down_to_impacts_without_restitution():
    """At R = 0 an impact leaves its wall with speed 0; this is not reported as a grazing."""
    zone = vi.zone(one_wall(0.6), x=("frequency", 0.8, 1.2), y=("restitution", 0.0, 1.0), lines=9)
    assert zone.closed
    assert len(zone.loops) == 1
    assert {piece.type for piece in zone.boundary} == {"window", "flip"}


@pytest.mark.slow
def test_a_motion_in_a_zone_is_the_stable_one():
    """Near a fold the nearest vertex of the boundary may lead to the unstable motion."""
    undamped = vi.Structure([1], [0], [1], [vi.Gap([1], 1, 0.8)])
    load = vi.Load(1.3, cosine=[1])
    motion = vi.exact(undamped, load, vi.simulate(undamped, load, cycles=500))
    zone = vi.zone(motion, x=("frequency", 1.05, 3.0), y=("load", 0.3, 2.0))
    inside = 0
    for x in np.linspace(1.1, 1.9, 7).tolist():
        for y in np.linspace(0.4, 1.9, 6).tolist():
            if not zone.contains(x, y):
                continue
            here = zone.motion(x, y)
            assert here is not None
            assert here.stable
            inside += 1
    assert inside > 10


def test_a_motion_in_a_zone_is_followed_from_any_order_of_impacts(pair, monkeypatch):
    """Phases that start with another impact keep their gaps; a vertex with two simultaneous impacts is skipped."""
    zone = vi.zone(pair[0], x=("frequency", 0.8, 1.2), y=("opening", 2.0, 40.0), lines=9)
    wanted = zone.motion(0.94, 18.5)
    assert wanted.stable
    turned = []
    for piece in zone.boundary:
        phases = piece.phases.copy()
        phases[0] += 2 * np.pi * zone.cycles
        turned.append(replace(piece, _motions=(piece.speeds, phases)))
    zone.__dict__["boundary"] = turned
    found = zone.motion(0.94, 18.5)
    assert sorted(found.phases % (2 * np.pi)) == pytest.approx(
        sorted(wanted.phases % (2 * np.pi)), abs=1e-9
    )
    # a vertex at which two impacts on one gap coincide is no start, and no error
    at = np.array([0.94, 18.5])
    monkeypatch.setattr(type(zone), "gaps", np.array([0, 0]))
    assert zone._followed_structure(at, np.array([1.0, 1.0]), at) is None


def test_a_zone_up_to_a_resonance():
    """At a resonance of an undamped mode motions are continuous, but not their equations: a zone ends there."""
    undamped = vi.Structure([1], [0], [1], [vi.Gap([1], 1, 0.8)])
    load = vi.Load(1.3, cosine=[1])
    motion = vi.exact(undamped, load, vi.simulate(undamped, load, cycles=500))
    until, beyond = (
        vi.zone(motion, x=("frequency", low, 3.0), y=("load", 0.3, 2.0)) for low in (1.0, 0.9)
    )
    assert until.closed
    assert until.loops[0][:, 0].min() == 1.0
    x, y = np.random.default_rng(4).uniform((1.0, 0.3), (3.0, 2.0), (2000, 2)).T
    assert (until.contains(x, y) == beyond.contains(x, y)).all()
    branch = vi.branch(motion, "frequency", (1.0, 3.0))
    assert branch.ends == ("bound of the parameter",) * 2
    assert branch.values.min() == pytest.approx(1.0, abs=1e-5)


def test_a_zone_ends_exactly_at_its_window():
    """A zone that all sides of its window cut has points exactly there, for any bounds."""
    wall = vi.Structure([1], [0.05], [1], [vi.Gap([1], 1, 0.8)])
    load = vi.Load(1.4, cosine=[1])
    motion = vi.exact(wall, load, vi.simulate(wall, load, cycles=500))
    random = np.random.default_rng(3)
    for _ in range(8):
        low, high = random.uniform((1.3, 0.7), (1.35, 0.9)), random.uniform((1.5, 1.6), (1.6, 2.0))
        zone = vi.zone(motion, x=("frequency", low[0], high[0]), y=("load", low[1], high[1]))
        (loop,) = zone.loops
        assert loop.min(0).tolist() == low.tolist()
        assert loop.max(0).tolist() == high.tolist()


def test_words_of_arguments(pair):
    """A motion of a structure can be given by its keyword; a column to draw must be a name."""
    path = vi.branch(motion=pair[0], parameter="opening", bounds=(18, 19))
    with pytest.raises(ParameterError, match="y = 3"):
        path.plot(y=3)
    with pytest.raises(SingularError, match="bounds are too far apart"):
        vi.branch(pair[0], "frequency", (0.5, 1e14))


def test_motions_that_cannot_be_followed_are_named():
    twice = (PHASES + [phase + 2 * math.pi for phase in PHASES], [0, 1, 0, 1], 2)
    repeats = vi.exact(damper(), vi.Load(0.94, sine=[1, 0]), twice)
    with pytest.raises(SingularError, match="repeats itself"):
        vi.branch(repeats, "opening", (5, 30))
    presumed = vi.periodic(damper(), vi.Load(0.94, sine=[1, 0]), [1.6, 6.0], [0, 1])
    for study in (vi.branch, lambda *x: vi.zone(x[0], ("frequency", 0.8, 1.2), ("opening", 5, 30))):
        with pytest.raises(ParameterError, match=r"residual 0\..*must be consistent"):
            study(presumed, "opening", (5, 30))
        with pytest.raises(ParameterTypeError, match="Motion"):
            study(damper(), "opening", (5, 30))


@pytest.fixture(scope="module")
def zones(pair):
    """The zone of the motion of Table 1 over frequency and opening, of the structure and the oscillator."""
    ours = vi.zone(pair[0], x=("frequency", 0.8, 1.2), y=("opening", 2.0, 40.0))
    theirs = vi.zone(pair[1].osc, "RL", (0.8, 1.2), (4.0, 80.0), symmetric=False)
    return ours, theirs


def test_zones_of_the_oscillator(zones):
    """The loop around the motion is that of the oscillator's zone, and its vertices meet the same conditions."""
    ours, theirs = zones
    assert ours.closed
    assert ours.contains(0.94, 18.5)
    ring = min(theirs.loops, key=lambda loop: loop[:, 0].max())
    # the rings are fine polygons of their curves, each over a different plane
    assert ours.loops[0].min(axis=0) * (1, 2) == pytest.approx(ring.min(axis=0), rel=1e-6)
    assert ours.loops[0].max(axis=0) * (1, 2) == pytest.approx(ring.max(axis=0), rel=1e-6)
    osc, checked = theirs.osc, 0
    for piece in ours.boundary:
        for j in range(0, len(piece), 5):
            if piece.type not in ("flip", "pitchfork"):
                continue
            r, clearance = float(piece.x[j]), 2 * float(piece.y[j])
            if piece.type == "flip":
                guess = (piece.phases[:, j] - piece.phases[0, j], vi.Pattern("RL"))
                motion = vi.exact(osc, r, clearance, guess)
                assert np.abs(motion.multipliers + 1).min() < 1e-6
            else:
                motions = vi.equispaced(osc, r, clearance)
                assert min(np.abs(m.multipliers - 1).min() for m in motions) < 1e-6
            checked += 1
    assert checked > 20


@pytest.mark.slow
def test_the_symmetric_zone_of_figure_6():
    """For the rig of the 1983 paper both zones contain the same points, and have a pitchfork and a fold."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    theirs = vi.zone(osc, "RL", (0.8, 1.2), (2.0, 60.0), symmetric=True)
    load = vi.Load(1.04, sine=[1, 0])
    pair = osc.structure(25.0)
    motion = vi.exact(pair, load, vi.simulate(pair, load, cycles=600))
    ours = vi.zone(motion, x=("frequency", 0.8, 1.2), y=("opening", 1.0, 30.0))
    assert all(piece.symmetric for piece in ours.boundary)
    rng = np.random.default_rng(3)
    r, clearance = rng.uniform(0.8, 1.2, 3000), np.exp(rng.uniform(*np.log([2, 60]), 3000))
    inside = theirs.contains(r, clearance)
    assert 500 < inside.sum() < 2500
    assert (ours.contains(r, clearance / 2) == inside).all()


@pytest.mark.slow
def test_a_corner_where_two_multipliers_are_1():
    """A fold ends on a Neimark-Sacker curve where two multipliers are 1; the loop is that of the oscillator."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    load = vi.Load(1.05, sine=[1, 0])
    motion = vi.exact(osc.structure(12.0), load, ([5.04, 6.94, 8.45], [0, 1, 1]))
    ours = vi.zone(motion, x=("frequency", 0.8, 1.2), y=("opening", 1.0, 40.0))
    theirs = vi.zone(osc, "RLL", (0.8, 1.2), (2.0, 80.0))
    assert ours.closed
    assert {piece.type for piece in ours.boundary} == {"fold", "neimark_sacker", "flip", "window"}
    highest = ours.loops[0].max(axis=0) * (1, 2)
    ring = min(theirs.loops, key=lambda loop: float(np.abs(loop.max(axis=0) - highest).max()))
    assert highest == pytest.approx(ring.max(axis=0), rel=1e-6)
    assert ours.loops[0].min(axis=0) * (1, 2) == pytest.approx(ring.min(axis=0), rel=1e-6)
    (fold,) = [piece for piece in ours.boundary if piece.type == "fold"]
    ends = [ours.at(fold.x[j], fold.y[j]) for j in (0, -1)]
    multipliers = [
        vi.periodic(*place, np.sort(fold.phases[:, j]), [0, 1, 1]).multipliers
        for place, j in zip(ends, (0, -1), strict=True)
    ]
    assert min(np.sort(np.abs(m - 1))[1] for m in multipliers) < 1e-3


@pytest.mark.slow
def test_zones_hold_what_simulation_finds():
    """In a zone of a structure simulations stay on its stable motion; outside there is no such motion."""
    gaps = [vi.Gap([0, -1, 1], 6.0, 0.7), vi.Gap([0, 1, -1], 6.0, 0.7)]
    k = np.array([[2, -1, 0], [-1, 1, 0], [0, 0, 0]])
    structure = vi.Structure([1, 1, 0.1], 0.05 * k, k, gaps)
    load = vi.Load(0.65, sine=[0, 0.5, 0])
    motions = [m for m in vi.find(structure, load) if not len(m.rests) and m.stable]
    motion = motions[0]
    zone = vi.zone(motion, x=("frequency", 0.5, 0.8), y=("load", 0.5, 2.0))
    assert zone.closed
    assert zone.contains(0.65, 1.0)
    assert zone.area > 0
    rng = np.random.default_rng(1)
    kinds = set()
    for x, y in zip(rng.uniform(0.5, 0.8, 40), rng.uniform(0.5, 2.0, 40), strict=True):
        here = zone.motion(x, y)
        inside = bool(zone.contains(x, y))
        kinds.add(inside)
        if here is None or here.stable is None:
            assert not inside
        else:
            assert inside == (here.stable and here.admissible)
        if inside:
            assert here is not None
            run = vi.simulate(
                here.structure, here.load, cycles=30, start=here.phases[0] / here.load.frequency,
                state=(here.q + 1e-9, here.q_dot),
            )  # fmt: skip
            end, _ = here.sample([run.end])
            assert np.abs(run.final_state[0] - end[:, 0]).max() < 1e-4
    assert kinds == {False, True}


def test_bad_axes_are_named(pair):
    for options, word in (
        ({"x": ("frequency", 0.8, 1.2), "y": ("frequency", 0.8, 1.2)}, "y.*same parameter as x"),
        ({"x": ("opening_0", 10, 20), "y": ("opening", 10, 20)}, "y.*same parameter as x"),
        ({"x": ("frequency", 0.8), "y": ("opening", 10, 20)}, "x"),
        ({"x": ("frequency", 1.0, 1.2), "y": ("opening", 10, 20)}, r"x\[1\] = 1.0"),
        ({"x": ("frequency", 0.8, 1.2), "y": ("opening", 10, 15)}, r"y\[2\] = 15"),
        ({"x": ("frequency", 0, 1.2), "y": ("opening", 10, 20)}, r"x\[1\] = 0.*above 0"),
        ({"x": ("width", 0, 1.2), "y": ("opening", 10, 20)}, r"x\[0\] = 'width'"),
        ({"x": ("frequency", 0.8, 1.2), "y": ("opening", 10, 20), "lines": 2}, "lines"),
    ):
        with pytest.raises(ParameterError, match=word):
            vi.zone(pair[0], **options)


def test_results_are_read_back(pair, zones, tmp_path):
    """Files, and the case as a namelist, give the same bits."""
    branch = vi.branch(pair[0], "opening", (15, 20))
    for found in (branch, zones[0]):
        for name in ("a.json", "a.nc", "a.mat"):
            path = tmp_path / name
            found.save(path)
            again = vi.load(path)
            assert type(again) is type(found)
            assert again.to_json() == found.to_json()
    (case,) = vi.read_namelist(_written(tmp_path, branch.to_namelist()))
    (again,) = case.run()
    assert again.values.tobytes() == branch.values.tobytes()
    assert vi.load(tmp_path / "a.mat").motion(0.94, 18.5).stable


def test_branches_of_both_systems_have_one_class(pair):
    """Records of earlier versions, which had two classes, are read; attributes that a system lacks are named."""
    ours, theirs = (
        vi.branch(pair[0], "opening", (15, 20)), vi.branch(pair[1], "clearance", (30, 40))
    )  # fmt: skip
    for found, name in ((ours, "StructureBranch"), (theirs, "Branch")):
        record = found.to_dict() | {"type": name}
        del record["study"]
        read = vi.Branch.from_dict(record)
        assert read.to_json() == found.to_json()
        assert [point.value for point in read.special_points] == [
            point.value for point in found.special_points
        ]
    for here, there in zip(ours.special_points, theirs.special_points, strict=True):
        assert 2 * here.value == pytest.approx(there.value, rel=1e-9)
        assert there.value == there.clearance == there.motion.clearance
        assert 2 * here.motion.structure.gaps[0].opening == pytest.approx(there.value, rel=1e-9)
        for name in ("r", "impact", "side", "switch"):
            with pytest.raises(AttributeError, match=f"^{name}: a Branch of a Structure does not"):
                getattr(here, name)() if name == "switch" else getattr(here, name)
    for found, names in (
        (ours, ("osc", "pattern", "symmetric", "X")),
        (theirs, ("structure", "gaps", "speeds")),
    ):
        for name in names:
            with pytest.raises(AttributeError, match=f"^{name}: a Branch of an? .* it has "):
                getattr(found, name)


def test_zones_of_both_systems_have_one_class(zones):
    """Records of earlier versions, which had two classes, are read; attributes that a system lacks are named."""
    ours, theirs = zones
    for found, name in ((ours, "StructureZone"), (theirs, "Zone")):
        record = found.to_dict() | {"type": name}
        del record["study"]
        read = vi.Zone.from_dict(record)
        assert read.to_json() == found.to_json()
        assert [len(piece) for piece in read.boundary] == [len(piece) for piece in found.boundary]
        assert read.search == found.search
    assert (theirs.x_parameter, theirs.y_parameter) == ("r", "clearance")
    assert (theirs.x, theirs.y) == (theirs.r, theirs.clearance)
    piece = theirs.boundary[0]
    assert piece.x is piece.r
    assert piece.y is piece.clearance
    # the other loop of the oscillator is not connected with the motion
    other = max(theirs.loops, key=lambda loop: loop[:, 0].max())[:, 0].min()
    x, y = np.linspace(ours.x[0], other, 30), np.linspace(*ours.y, 20)[:, None]
    assert ours.count(x, y).tolist() == theirs.count(x, 2 * y).tolist()
    assert ours.count(x, y).any()
    assert not ours.undecided(x, y).any()
    for found, names in (
        (ours, ("osc", "pattern", "symmetric", "r", "clearance")), (theirs, ("structure", "gaps")),
        (ours.boundary[0], ("r", "clearance", "x_over_D", "theta")), (piece, ("speeds", "phases")),
    ):  # fmt: skip
        for name in names:
            with pytest.raises(AttributeError, match=f"^{name}: a (Zone|Piece) of an? .* it has "):
                getattr(found, name)
    with pytest.raises(ParameterTypeError, match=r"^zone = <Zone over .*must be a zone of an Osc"):
        vi.boundary_bands(ours, {"xi": (0.004, 0.006)})


def test_an_open_zone_of_a_structure_is_not_decided(zones):
    """If a boundary could not be closed, a zone of a structure warns as a zone of an oscillator does."""
    record = zones[0].to_dict()
    record["tables"]["families"]["columns"]["closed"] = [False]
    zone = vi.Zone.from_dict(record)
    assert "NOT closed" in repr(zone)
    whole = zones[0].contains(0.94, [10.0, 18.5])
    assert whole.tolist() == [False, True]
    with pytest.warns(vi.OpenBoundaryWarning, match="it contains 1 of the points is not decided"):
        assert zone.contains(0.94, [10.0, 18.5]).tolist() == [False, True]
    outside = 2 * zone.y[1]
    assert zone.undecided(0.94, [10.0, 18.5, outside]).tolist() == [True, False, False]


def _written(folder, text):
    path = folder / "case.nml"
    path.write_text(text)
    return path


def test_a_closed_branch():
    """An isola has the special points of the oscillator's in the same order, until the branch meets its start."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    motion = vi.exact(osc, 0.85, 20.0, ([0.0, 2.01848, 6.07922], vi.Pattern("RRL", 2)))
    guess = (motion.phases, [0, 0, 1], 2)
    same = vi.exact(osc.structure(20.0), vi.Load(0.85, sine=[1, 0]), guess)
    theirs = vi.branch(motion, "r", (0.7, 1.4))
    ours = vi.branch(same, "frequency", (0.7, 1.4))
    assert ours.ends == theirs.ends == ("closed", "closed")
    assert [p.type for p in ours.special_points] == [p.type for p in theirs.special_points]
    assert [p.value for p in ours.special_points] == pytest.approx(
        [p.r for p in theirs.special_points], rel=1e-12
    )
    assert len(ours.special_points) == 32


def integrated(flight, gap, start, time):
    """Time and state at the next zero of a closing gap, by integration; the flight starts on a wall."""
    solve_ivp = pytest.importorskip("scipy.integrate").solve_ivp
    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}

    def closes(t, y):
        return gap(y)

    closes.terminal, closes.direction = True, -1
    away = solve_ivp(flight, (time, time + 0.2), start, **options)
    end = solve_ivp(flight, (away.t[-1], time + 30), away.y[:, -1], events=closes, **options)
    return end.t_events[0][0], end.y_events[0][0]


def bifurcation(period, guess, multiplier):
    """The fixed point of a map, at the parameter (last argument) where it has a given multiplier, by fsolve."""
    fsolve = pytest.importorskip("scipy.optimize").fsolve
    n = len(guess) - 1

    def equations(place):
        moves = 1e-5 * np.eye(n + 1)[:n]
        columns = [(period(place + move) - period(place - move)) / 2e-5 for move in moves]
        singular = np.linalg.det(np.array(columns) - multiplier * np.eye(n))
        return [*(period(place) - place[:n]), singular]

    found, _, status, _ = fsolve(equations, guess, xtol=1e-10, full_output=True)
    assert status == 1
    return found


def test_a_fold_by_integration():
    """The map of phase and approach speed, by an integrator, has the multiplier 1 at the same frequency."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    branch = vi.branch(motion, "frequency", (0.6, 3.0))
    (fold,) = [point for point in branch.special_points if point.type == "fold"]

    def period(place):
        phase, speed, omega = place
        time, (_, after) = integrated(
            lambda t, y: (y[1], np.cos(omega * t) - 0.1 * y[1] - y[0]), lambda y: 1 - y[0],
            [1, -0.8 * speed], phase / omega,
        )  # fmt: skip
        return np.array([omega * time - 2 * math.pi, after])

    here = np.array([branch.phases[0, fold.index], branch.speeds[0, fold.index], fold.value])
    found = bifurcation(period, here + 1e-3, 1)
    assert found[2] == pytest.approx(fold.value, abs=1e-10)
    assert found[:2] == pytest.approx(here[:2], abs=1e-6)


@pytest.mark.slow
def test_a_flip_by_integration(pair):
    """The map from impact to impact on the right wall has the multiplier -1 at the same opening."""
    branch = vi.branch(pair[0], "opening", (5, 30))
    (flip,) = [point for point in branch.special_points if point.type == "flip"]

    def flight(t, y):
        return (y[1], math.sin(0.94 * t) - 2 * XI * y[1] - y[0], y[3], 0.0)

    def period(place):
        phase, x, x_dot, z_dot, opening = place
        time, y = phase / 0.94, np.array([x, x_dot, x + opening, z_dot])
        for side in (-1, 1):
            time, y = integrated(flight, lambda y, s=side: opening - s * (y[2] - y[0]), y, time)
            approach = (1 + RESTITUTION) / (1 + MU) * (y[3] - y[1])
            y[1::2] += (MU * approach, -approach)
        return np.array([0.94 * time - 2 * math.pi, y[0], y[1], y[3]])

    motion = branch[flip.index]
    here = np.array([motion.phases[0], motion.q[0], *motion.q_dot, flip.value])
    found = bifurcation(period, here * (1 + 1e-4), -1)
    assert found == pytest.approx(here, rel=1e-7)


@pytest.mark.slow
def test_motions_whose_speeds_vanish_are_consistent():
    """At a zero of all approach speeds the equations hold, relative to displacements over the time of a radian."""
    structure, load = random_structure(np.random.default_rng(12))
    motions = [m for m in vi.find(structure, load) if not len(m.rests)]
    branches = (vi.branch(motion, "load", (0.6, 1.6)) for motion in motions)
    branch, vanish = next(
        (branch, vanish) for branch in branches
        if (vanish := [p.index for p in branch.special_points if p.type == "zero_approach"])
    )  # fmt: skip
    assert branch.residual.max() < 1e-12
    assert (branch.consistent[vanish] == 1).all()
