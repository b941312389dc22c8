"""Elastic stops in simulations, compared with laws, published numbers and independent calculations."""

import itertools
import math

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import check_reference
from shared_structures import check_parts, cycle_map, energy, one_stop, random_structure

TURN = 2 * math.pi


def settled(structure, load, cycles=600):
    """The events of one load cycle after many, from the first touch on, with load phases."""
    run = vi.simulate(structure, load, cycles=2, discard=cycles)
    kinds = run.events["kind"].tolist()
    begin = kinds.index("touch")
    end = kinds.index("touch", begin + 1)
    events = run.events[begin:end]
    return events, events["time"] * load.frequency % TURN


def test_a_mass_on_a_stop():
    """An undamped contact is half a period on both springs; half a period on the mass's own spring follows."""
    s = vi.Structure([100.0], [0.0], [1e4], [vi.Stop([1.0], 0.0, 1e6)])
    run = vi.simulate(s, duration=1.0, state=([0.0], [1.0]))
    assert run.events["kind"].tolist() == ["touch", "leave"] * 3
    times = run.events["time"]
    assert times[0] == 0
    assert times[1] == pytest.approx(0.0312600152681, rel=1e-12)
    assert times[1] == pytest.approx(math.pi / math.sqrt(1.01e4), rel=1e-14)
    assert times[2] == pytest.approx(0.345419280627, rel=1e-12)
    assert run.events["speed"] == pytest.approx([1.0] * 6, rel=1e-14)
    (depth,), _ = run.sample([times[1] / 2])
    assert depth[0] == pytest.approx(0.00995037190210, rel=1e-12)
    assert 1e6 * depth[0] == pytest.approx(9950.37190, rel=1e-9)
    assert repr(run) == "<Trajectory t = 0 to 1: 0 impacts, 3 contacts with stops>"


@pytest.mark.parametrize(("k", "c", "phase", "speed", "duration", "multiplier"), [
    (100, 0, 6.22700821679763, 1.58296562149347, 0.312511699213252, -0.6922454190347 + 0.2329900661328j),
    (100, 1, 6.23899363049323, 1.68455448864325, 0.312955115403664, -0.5916663376937 + 0.2001538789779j),
    (1e8, None, 0.0758360073610025, 1.69574427200306, 3.14950821512081e-4, -0.5842934483009 + 0.0057887487234j),
])  # fmt: skip
def test_settled_motion(k, c, phase, speed, duration, multiplier):
    """The settled motion of the oscillator with one stop, and its stability: det P = exp(-.1 T - c t_contact)."""
    if c is None:
        ratio = -math.log(0.8) / math.hypot(math.pi, math.log(0.8))
        c = 2 * ratio * math.sqrt(k)
    load = vi.Load(1.0, cosine=[1.0])
    events, phases = settled(one_stop(1.0, stiffness=k, damping=c), load)
    assert events["kind"].tolist() == ["touch", "leave"]
    assert phases[0] == pytest.approx(phase, abs=2e-12)
    assert events["speed"][0] == pytest.approx(speed, rel=1e-12)
    assert np.diff(events["time"])[0] == pytest.approx(duration, abs=2e-12)
    assert abs(multiplier) ** 2 == pytest.approx(math.exp(-0.1 * TURN - c * duration), rel=1e-10)
    # P by differences over a load cycle, starting from its middle
    structure, start = one_stop(1.0, stiffness=k, damping=c), TURN / 2
    q, rate = vi.simulate(structure, load, duration=start, discard=600 * TURN).final_state
    first = np.concatenate([q, rate])
    image, p = cycle_map(structure, load, start, first)
    assert image == pytest.approx(first, abs=1e-10)
    assert np.linalg.det(p) == pytest.approx(math.exp(-0.1 * TURN - c * duration), rel=1e-6)
    found = max(np.linalg.eigvals(p), key=lambda value: value.imag)
    assert complex(found) == pytest.approx(multiplier, rel=1e-4 if k == 1e8 else 1e-7)


@pytest.mark.parametrize(("stop", "kinds", "phases", "speeds"), [
    ({"damping": 2}, ["touch", "leave"], [0.29630052928, 1.2250985305], [2.68616590432]),
    ({"damping": 2, "release": "force"}, ["touch", "let_go", "leave"],
     [0.23675141945, 1.03374183219, 1.16384104299], [2.69053476176]),
    ({"preload": 0.3}, ["touch", "leave"], [6.06036959344, 0.67637725064], []),
    ({"preload": 0.3, "release": "force"}, ["touch", "leave"], [6.06036959344, 0.67637725064], []),
])  # fmt: skip
def test_release_rules(stop, kinds, phases, speeds):
    """Where contact ends, by the opening or by the force, and with a preload."""
    events, found = settled(one_stop(0.5, stiffness=20, **stop), vi.Load(1.3, cosine=[1.0]))
    assert events["kind"].tolist() == kinds
    assert found == pytest.approx(phases, abs=2e-11)
    assert events["speed"][: len(speeds)] == pytest.approx(speeds, rel=1e-11)


def test_stiff_stops_are_walls():
    """With R = exp(-pi zeta/sqrt(1 - zeta^2)) motions converge to those with a rigid wall as k^(-1/2)."""
    load = vi.Load(1.0, cosine=[1.0])
    wall = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 0.8)])
    rigid = vi.simulate(wall, load, cycles=1, discard=300).events
    zeta = -math.log(0.8) / math.hypot(math.pi, math.log(0.8))
    off = []
    for k in (1e4, 1e6, 1e8):
        stop = one_stop(1.0, stiffness=k, damping=2 * zeta * math.sqrt(k))
        events, phases = settled(stop, load, 300)
        off.append([phases[0] - rigid["time"][0] % TURN, events["speed"][0] - rigid["speed"][0]])
        assert events["speed"][1] == pytest.approx(0.8 * events["speed"][0], rel=20 / math.sqrt(k))
    ratios = np.array(off)[:-1] / np.array(off)[1:]
    assert ratios == pytest.approx(np.full((2, 2), 10.0), rel=0.15)
    assert np.abs(off[-1]).max() < 3e-4


def with_stops(rng, coupled, gaps, stops):
    """A random structure with some gaps and stops, and a load."""
    plain = random_structure(rng, coupled)
    n = plain.coordinates
    elements = [
        vi.Gap(rng.normal(size=n), rng.uniform(0.1, 0.4), rng.uniform(0.8, 1.0))
        for _ in range(gaps)
    ]
    for _ in range(stops):
        rest = {
            "damping": rng.choice([0.0, 1.0]) * rng.uniform(0.2, 3),
            "preload": rng.choice([0.0, 1.0]) * rng.uniform(0.05, 0.3),
            "release": str(rng.choice(["gap", "force"])),
        }
        opening = rng.uniform(-0.1, 0.3)
        elements.append(vi.Stop(rng.normal(size=n), opening, rng.uniform(5, 60), **rest))
    order = rng.permutation(len(elements))
    s = vi.Structure(plain.mass, plain.damping, plain.stiffness, [elements[i] for i in order])
    load = vi.Load(
        rng.uniform(0.5, 2), sine=rng.normal(size=(2, n)), cosine=rng.normal(size=(2, n)),
        constant=rng.normal(size=n),
    )  # fmt: skip
    return s, load


#: Seed, coupling of modes by damping, gaps and stops; contacts last several steps of the reference, and there are
#: no rests, which the reference does not have.
RANDOM = [
    (6, False, 0, 1), (0, True, 0, 1), (11, False, 0, 2), (14, True, 0, 2), (25, False, 1, 1), (26, True, 1, 1),
    (36, False, 1, 2), (35, True, 1, 2), (47, False, 0, 4), (45, True, 0, 4), (54, False, 2, 3), (56, True, 2, 3),
    (62, False, 0, 6), (65, True, 0, 6), (75, False, 3, 3), (74, True, 3, 3),
]  # fmt: skip


@pytest.mark.parametrize(("seed", "coupled", "gaps", "stops"), RANDOM)
def test_against_matrix_exponentials(tmp_path, seed, coupled, gaps, stops):
    """All events of random structures agree, in order, with a simulation without modes and bounds."""
    rng = np.random.default_rng(100 * seed + coupled)
    s, load = with_stops(rng, coupled, gaps, stops)
    start = (np.zeros(s.coordinates), 0.3 * rng.normal(size=s.coordinates))
    check_reference(tmp_path, s, load, 8.0, start, 8)


def force_of(stop, q, rate):
    depth = stop.direction @ q - stop.opening
    return stop.preload + stop.stiffness * depth + stop.damping * (stop.direction @ rate)


@pytest.mark.parametrize(("seed", "gaps", "stops"), [(1, 0, 2), (2, 1, 2), (3, 2, 4), (4, 0, 6)])
def test_energy(seed, gaps, stops):
    """Between events the work of the load equals losses in dashpots, impacts and stops plus change of energy."""
    rng = np.random.default_rng(seed)
    s, load = with_stops(rng, False, gaps, stops)
    run = vi.simulate(
        s, load, duration=8, state=(np.zeros(s.coordinates), rng.normal(size=s.coordinates))
    )
    assert len(run.events) > 8
    nodes, weights = np.polynomial.legendre.leggauss(24)
    depth = np.array([g.direction @ run.initial_state[0] - g.opening for g in s.gaps])
    closed = {
        i for i, g in enumerate(s.gaps)
        if isinstance(g, vi.Stop) and depth[i] > 0
        and (g.release == "gap" or force_of(g, *run.initial_state) > 0)
    }  # fmt: skip
    ends = [*run.events["time"].tolist(), run.end]
    begin, state = run.start, run.initial_state
    for i, end in enumerate(ends):
        pieces = np.linspace(begin, end, 5)
        balance = -energy(s, state)
        for low, high in itertools.pairwise(pieces):
            t = 0.5 * (low + high) + 0.5 * (high - low) * nodes
            q, rate = run.sample(t)
            turns = load.frequency * np.outer([1, 2], t)
            force = (
                load.sine.T @ np.sin(turns) + load.cosine.T @ np.cos(turns) + load.constant[:, None]
            )
            power = (force * rate).sum(0) - (rate * (s.damping @ rate)).sum(0)
            for j in closed:
                power -= [
                    force_of(s.gaps[j], *at) * (s.gaps[j].direction @ at[1])
                    for at in zip(q.T, rate.T, strict=True)
                ]  # fmt: skip
            balance -= 0.5 * (high - low) * weights @ power
        if i == len(run.events):
            assert balance + energy(s, run.final_state) == pytest.approx(0, abs=1e-11)
            break
        event, after = run.events[i], run.states[i]
        gap = s.gaps[event["gap"]]
        lost = 0.0
        if event["kind"] == "impact":
            effective = 1 / (gap.direction @ np.linalg.solve(s.mass, gap.direction))
            lost = 0.5 * effective * (1 - gap.restitution**2) * event["speed"] ** 2
        scale = 1 + energy(s, state)
        assert balance + energy(s, after) + lost == pytest.approx(0, abs=1e-11 * scale)
        if event["kind"] in ("touch", "press"):
            closed.add(int(event["gap"]))
        else:
            closed.discard(int(event["gap"]))
        begin, state = event["time"], after


def test_backlash():
    """Two opposite stops that are always in contact act as one spring."""
    free = vi.Structure([1.0], [0.02], [3.0])
    gaps = [vi.Stop([1.0], -2.0, 1.0), vi.Stop([-1.0], -2.0, 1.0)]
    both = vi.Structure([1.0], [0.02], [1.0], gaps)
    load = vi.Load(1.2, sine=[0.5])
    t = np.linspace(0, 20, 101)
    one, two = (vi.simulate(s, load, duration=20).sample(t)[0] for s in (both, free))
    assert np.abs(one - two).max() < 1e-13
    assert len(vi.simulate(both, load, duration=20).events) == 0


def test_a_stop_on_another_body():
    """A free mass between two stops of its host: momentum is conserved, and so is energy without dashpots."""
    gaps = [vi.Stop([-1.0, 1.0], 0.5, 40.0), vi.Stop([1.0, -1.0], 0.5, 40.0)]
    s = vi.Structure([1.0, 0.2], [0.0, 0.0], [0.0, 0.0], gaps)
    run = vi.simulate(s, duration=50, state=([0.0, 0.0], [0.3, -1.0]))
    apart = run.events["kind"] == "leave"
    momentum = run.states[:, 1] @ [1.0, 0.2]
    assert momentum == pytest.approx(np.full(len(momentum), 0.1), abs=1e-13)
    kinetic = run.states[:, 1] ** 2 @ [0.5, 0.1]
    assert kinetic == pytest.approx(np.full(len(kinetic), 0.145), rel=1e-12)
    assert apart.sum() > 20
    # a contact takes half a period of the two masses on the spring
    took = run.events["time"][1::2] - run.events["time"][::2][: apart.sum()]
    assert took == pytest.approx(np.full(len(took), math.pi * math.sqrt(0.2 / 1.2 / 40)), rel=1e-11)


def test_two_stops_at_one_instant():
    """Equal masses on equal stops: both events at each instant are found, and the masses move alike."""
    gaps = [vi.Stop([1.0, 0.0], 0.1, 50.0, 0.5), vi.Stop([0.0, 1.0], 0.1, 50.0, 0.5)]
    s = vi.Structure([1.0, 1.0], [0.1, 0.1], [1.0, 1.0], gaps)
    load = vi.Load(1.1, cosine=[1.0, 1.0])
    run = vi.simulate(s, load, duration=40)
    one = vi.simulate(vi.Structure([1.0], [0.1], [1.0], [vi.Stop([1.0], 0.1, 50.0, 0.5)]),
                      vi.Load(1.1, cosine=[1.0]), duration=40)  # fmt: skip
    assert len(run.events) == 2 * len(one.events) > 20
    for i in (0, 1):
        own = run.events[run.events["gap"] == i]
        assert own["time"] == pytest.approx(one.events["time"], abs=1e-10)
        assert own["kind"].tolist() == one.events["kind"].tolist()


@pytest.mark.parametrize("over", [1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9])
def test_grazing(over):
    """A steady motion that exceeds a stop by much, by little or not at all: no contact is missed or spurious."""
    amplitude = 1 / abs(1 - 0.8**2)
    s = vi.Structure([1.0], [0.0], [1.0], [vi.Stop([1.0], amplitude * (1 - over), 10.0)])
    run = vi.simulate(
        s,
        vi.Load(0.8, cosine=[1.0]),
        duration=3 * TURN / 0.8 - 1,
        state=([0.9999 * amplitude], [0.0]),
    )
    kinds = run.events["kind"].tolist()
    assert kinds == ["touch", "leave"] * (len(kinds) // 2)
    steady = vi.simulate(
        s,
        vi.Load(0.8, cosine=[1.0]),
        duration=3 * TURN / 0.8 - 1,
        state=([amplitude * (1 - 1e-15)], [0.0]),
    )
    assert len(steady.events) >= (2 if over > 1e-8 else 0)
    assert abs(steady.final_state[0][0]) < amplitude * (1 + 1e-6)


def test_at_the_limit():
    """A mass at a stop without speed moves as the force directs; a preload that would hold it is refused."""

    def started(force, **stop):
        s = vi.Structure([1.0], [0.0], [0.0], [vi.Stop([1.0], 0.0, 4.0, **stop)])
        return vi.simulate(s, vi.Load(constant=[force]), duration=3, state=([0.0], [0.0]))

    pressed = started(1.0)
    assert pressed.events["kind"].tolist() == ["leave", "touch"][: len(pressed.events)]
    assert pressed.sample([1.0])[0][0, 0] == pytest.approx(0.25 * (1 - math.cos(2.0)), rel=1e-13)
    assert started(-1.0).sample([1.0])[0][0, 0] == pytest.approx(-0.5, rel=1e-13)
    assert started(0.0).sample([1.0])[0][0, 0] == 0
    assert len(started(0.0).events) == 0
    with pytest.raises(vi.SingularError, match="touched at zero speed"):
        started(1.0, preload=2.0)
    deep = started(3.0, preload=2.0)
    assert deep.sample([1.0])[0][0, 0] == pytest.approx(0.25 * (1 - math.cos(2.0)), rel=1e-13)


def test_with_rest():
    """A rigid gap rests while a stop on its host closes and opens, so that the contact force jumps."""
    gaps = [vi.Gap([-1.0, 1.0], 0.0, 0.0), vi.Stop([1.0, 0.0], 0.3, 30.0, 1.0)]
    s = vi.Structure([1.0, 0.3], [0.1, 0.0], [1.0, 0.0], gaps)
    load = vi.Load(0.7, cosine=[1.4, 0.0], constant=[0.0, 0.4])
    run = vi.simulate(s, load, duration=40)
    kinds = run.events["kind"].tolist()
    assert {"stick", "release", "touch", "leave", "impact"} <= set(kinds)
    resting, during = False, 0
    for event, (q, rate) in zip(run.events, run.states, strict=True):
        if event["kind"] in ("stick", "release"):
            resting = event["kind"] == "stick"
        if event["kind"] in ("touch", "leave"):
            assert q[0] == pytest.approx(0.3, abs=1e-12)
            during += resting
        if resting:
            assert [q[1] - q[0], rate[1] - rate[0]] == pytest.approx([0, 0], abs=1e-12)
    assert during > 2
    t = np.linspace(0, run.end, 4001)
    q, _ = run.sample(t)
    apart = q[0] - q[1]
    assert apart.min() > -1e-12
    # both bodies have one acceleration at rest, and the force between them pushes
    together = apart < 1e-12
    assert together.sum() > 1000
    acceleration = run.acceleration(t)
    assert 0.4 - 0.3 * acceleration[1][together].min() > -1e-9


def test_under_a_record():
    """A record whose samples are on a line gives the motion under a force that grows linearly."""
    s = vi.Structure([1.0], [0.1], [1.0], [vi.Stop([1.0], 0.3, 25.0, 1.0, release="force")])
    fine = vi.Record(0.005, np.sin(1.1 * 0.005 * np.arange(8001))[:, None])
    run = vi.simulate(s, fine)
    exact = vi.simulate(s, vi.Load(1.1, sine=[1.0]), duration=40)
    assert run.events["kind"].tolist() == exact.events["kind"].tolist()
    assert len(run.events) > 10
    assert run.events["time"] == pytest.approx(exact.events["time"], abs=1e-4)
    coarse = vi.simulate(s, vi.Record(0.01, fine.samples[::2]))
    off = [np.abs(one.events["time"] - exact.events["time"]).max() for one in (coarse, run)]
    assert off[0] / off[1] == pytest.approx(4, rel=0.1)


def test_in_parts():
    """A run continued from its final state, in contact or not, equals the complete run."""
    s = one_stop(0.5, stiffness=20, damping=2, release="force")
    load = vi.Load(1.3, cosine=[1.0])
    check_parts(s, load, lambda whole: [10.0, *(whole.events["time"][10:14] + 0.05)], 1e-11)


def test_stops_that_never_touch():
    """A stop out of reach changes no digit of the events."""
    gaps = [vi.Gap([-1.0, 1.0], 0.5, 0.8), vi.Gap([1.0, -1.0], 0.5, 0.7)]
    far = [*gaps, vi.Stop([1.0, 0.0], 1e6, 10.0, 1.0, release="force")]
    load = vi.Load(1.04, sine=[0.1, 0.0])
    one, two = (
        vi.simulate(vi.Structure([1, 0.1], [0.02, 0], [1, 0], each), load, cycles=30)
        for each in (gaps, far)
    )
    assert two.events["time"] == pytest.approx(one.events["time"], abs=1e-9)
    assert len(one.events) == len(two.events)


@pytest.mark.parametrize(("arguments", "message"), [
    ({"stiffness": -1.0}, "stiffness = -1.0: must be a number from 0 to 1e100"),
    ({"stiffness": math.inf}, "stiffness = inf"),
    ({"stiffness": math.nan}, "stiffness = nan"),
    ({"stiffness": 1.0, "damping": -0.1}, "damping = -0.1"),
    ({"stiffness": 1.0, "preload": -0.1}, "preload = -0.1"),
    ({"stiffness": 0.0}, "stiffness = 0.0: must be above 0 unless damping or preload is"),
    ({"stiffness": 1.0, "release": "never"}, "release = 'never': must be 'gap' or 'force'"),
    ({"stiffness": 1.0, "direction": [0.0]}, "direction"),
    ({"stiffness": 1.0, "opening": math.nan}, "opening"),
])  # fmt: skip
def test_bad_input(arguments, message):
    given = {"direction": [1.0], "opening": 0.0} | arguments
    with pytest.raises(vi.ParameterError, match=message.replace("'", ".")):
        vi.Stop(**given)


def test_wrong_length():
    with pytest.raises(vi.ParameterError, match=r"gaps\[0\].direction has 2 numbers: must have 1"):
        vi.Structure([1.0], [0.1], [1.0], [vi.Stop([1.0, 0.0], 0.0, 1.0)])
    with pytest.raises(vi.ParameterTypeError, match=r"gaps\[0\]"):
        vi.Structure([1.0], [0.1], [1.0], [3])


@pytest.mark.parametrize(
    ("spring", "stiffness", "damping", "duration"),
    [(1.0, 100.0, 30.0, 50.0), (1.0, 1.0, 10.0, 300.0), (0.0, 1.0, 3.0, 400.0)],
)
def test_overdamped_stop_at_equilibrium(spring, stiffness, damping, duration):
    """A mass creeps back to the opening and never leaves: the search for the end of the contact, whose depth
    falls below any share of the first one, stays short."""
    s = vi.Structure([1.0], [0.0], [spring], [vi.Stop([1.0], 0.0, stiffness, damping)])
    run = vi.simulate(s, duration=duration, state=([0.0], [1.0]))
    assert run.events["kind"].tolist() == ["touch"]
    root = math.sqrt(damping**2 / 4 - spring - stiffness)
    slow = (spring + stiffness) / (damping / 2 + root)
    depth = math.exp(-slow * duration) / (2 * root)
    assert run.final_state[0][0] == pytest.approx(depth, rel=1e-9)


def test_values():
    """Equality, text and the modes of a structure with stops."""
    stop = vi.Stop([1, 0], 0.5, 20, damping=2, release="force")
    assert repr(stop) == "Stop([1.0, 0.0], 0.5, stiffness=20, damping=2, release='force')"
    assert stop == vi.Stop([1, 0], 0.5, 20, 2, 0, "force") != vi.Stop([1, 0], 0.5, 20, 2)
    assert hash(stop) == hash(vi.Stop([1, 0], 0.5, 20, 2, 0, "force"))
    s = vi.Structure([1, 1], [0, 0], [1, 1], [stop, vi.Gap([0, 1], 1)])
    assert repr(s) == "<Structure of 2 coordinates with 1 gap and 1 stop>"
    beam = vi.Structure.from_modes(
        [1.0, 6.27], [0.01, 0.01], [[2.0, -2.0]], [vi.Stop([1.0], 0.1, 50.0, 1.0)]
    )
    assert beam.gaps[0].direction.tolist() == [2.0, -2.0]
    assert beam.gaps[0].damping == 1.0


def test_pictures(tmp_path):
    """A trajectory with stops is drawn."""
    pytest.importorskip("matplotlib")
    s = vi.Structure(
        [1, 0.2], [0.1, 0], [1, 0], [vi.Stop([-1, 1], 0.5, 20, 1), vi.Gap([1, -1], 0.5, 0.8)]
    )
    run = vi.simulate(s, vi.Load(1.3, cosine=[1.0, 0]), cycles=5)
    axes = run.plot()
    assert len(np.ravel(axes)) > 2
