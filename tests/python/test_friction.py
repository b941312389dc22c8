"""Dry friction in simulations, compared with laws, closed forms, published numbers and other methods."""

import itertools
import math

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import check_reference
from shared_structures import check_parts, cycle_map, energy, random_structure

TURN = 2 * math.pi


def den_hartog(b, zeta, f, h_stick=None):
    """The structure x'' + 2 zeta x' + x + f sgn x' = cos bt."""
    return vi.Structure(
        [1.0], [2 * zeta], [1.0], friction=[vi.Friction([1.0], f, h_stick)]
    ), vi.Load(b, cosine=[1.0])


def amplitude(b, zeta, f):
    """Den Hartog's closed form, for motions without sticking."""
    t, w = math.pi / b, math.sqrt(1 - zeta**2)
    square = (1 - b**2) ** 2 + (2 * zeta * b) ** 2
    delta = math.cosh(zeta * t) + math.cos(w * t)
    g = (math.sinh(zeta * t) - zeta / w * math.sin(w * t)) / delta
    h = math.sin(w * t) / (b * w * delta)
    return -g * f + math.sqrt(1 / square - h**2 * f**2)


def settled(structure, load, cycles=600):
    """The events of one load cycle after many, with load phases, and their coordinates."""
    run = vi.simulate(structure, load, cycles=1, discard=cycles)
    return run.events, run.events["time"] * load.frequency % TURN, run.states[:, 0]


@pytest.mark.parametrize(("b", "zeta", "f", "x", "phase"), [
    (0.8, 0.05, 0.3, 2.34687196742201, 0.539694656395657),
    (1.2, 0.05, 0.5, 1.27260049562604, 2.14986692978739),
])  # fmt: skip
def test_den_hartog(b, zeta, f, x, phase):
    """The motion has the amplitude and load phase of the maximum of the closed form."""
    assert amplitude(b, zeta, f) == pytest.approx(x, rel=1e-13)
    events, phases, q = settled(*den_hartog(b, zeta, f))
    assert sorted(events["kind"].tolist()) == ["slip_down", "slip_up"]
    top = int(np.argmax(q[:, 0]))
    assert events["kind"][top] == "slip_down"
    assert q[top, 0] == pytest.approx(x, rel=1e-12)
    assert q[1 - top, 0] == pytest.approx(-x, rel=1e-12)
    assert phases[top] == pytest.approx(phase, abs=1e-11)


@pytest.mark.parametrize(("b", "f", "x", "modulus"), [
    (0.8, 0.3, 2.62610487572348, 0.69707788), (0.6, 0.25, 1.54387042190387, 0.37949352),
])  # fmt: skip
def test_den_hartog_without_damping(b, f, x, modulus):
    """Friction alone limits the amplitude; differences from the motion decay as its multipliers predict."""
    assert amplitude(b, 0, f) == pytest.approx(x, rel=1e-13)
    _events, _, q = settled(*den_hartog(b, 0, f), cycles=200)
    assert np.abs(q[:, 0]) == pytest.approx([x, x], rel=1e-12)
    s, load = den_hartog(b, 0, f)
    t = TURN / b
    q, rate = vi.simulate(s, load, duration=0.1 * t, discard=200 * t).final_state
    first = np.concatenate([q, rate])
    _, p = cycle_map(s, load, 0.1 * t, first)
    assert np.abs(np.linalg.eigvals(p)) == pytest.approx([modulus] * 2, rel=1e-7)


#: Parameters for which the motion does not stick.
GRID = [
    (b, zeta, f)
    for b in (0.45, 0.7, 1.3, 1.9) for zeta in (0.02, 0.1, 0.3) for f in (0.05, 0.15, 0.3)
    if b > 0.5 or f < 0.1 or (zeta < 0.2 and f < 0.2)
]  # fmt: skip


@pytest.mark.parametrize(("b", "zeta", "f"), GRID)
def test_den_hartog_grid(b, zeta, f):
    """The amplitude of the closed form over a grid."""
    events, _, q = settled(*den_hartog(b, zeta, f), cycles=150)
    assert sorted(events["kind"].tolist()) == ["slip_down", "slip_up"]
    assert q[:, 0].max() == pytest.approx(amplitude(b, zeta, f), rel=1e-9)


def test_a_mass_that_slides_to_rest():
    """Extremes fall by twice the force over the stiffness; the mass rests where the spring is weaker."""
    s = vi.Structure([1.0], [0.0], [1e4], friction=[vi.Friction([1.0], 1.0)])
    run = vi.simulate(s, duration=1.0, state=([0.85e-3], [0.0]))
    assert run.events["kind"].tolist() == ["slip_up", "slip_down", "slip_up", "halt"]
    assert run.states[:, 0, 0] == pytest.approx([-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3], rel=1e-12)
    assert run.events["time"] == pytest.approx(np.arange(1, 5) * math.pi / 100, abs=1e-14)
    assert run.events["time"][-1] == pytest.approx(0.1256637, abs=1e-7)
    assert run.final_state[0] == pytest.approx([0.05e-3], rel=1e-12)
    assert run.final_state[1] == pytest.approx([0], abs=1e-15)


def test_a_mass_on_a_belt():
    """The mass sticks, is carried until the spring force reaches the stick level, and slips back, repeatedly."""
    s = vi.Structure([1.0], [0.0], [1.0], friction=[vi.Friction([1.0], 0.6, 1.0, speed=0.2)])
    run = vi.simulate(s, duration=60.0, state=([0.0], [0.2]))
    slips = run.events["time"][run.events["kind"] == "slip_down"]
    period = 2 * 0.4 / 0.2 + TURN - 2 * math.atan(0.4 / 0.2)
    assert period == pytest.approx(8.068887871591405, rel=1e-14)
    assert slips[0] == pytest.approx(5.0, rel=1e-13)
    assert np.diff(slips) == pytest.approx([period] * (len(slips) - 1), rel=1e-12)
    assert len(slips) == 7
    t = np.linspace(0, 5, 20)
    q, rate = run.sample(t)
    assert q[0] == pytest.approx(0.2 * t, abs=1e-14)
    assert rate[0] == pytest.approx([0.2] * 20, rel=1e-14)


def test_with_stick():
    """Two halts in a load cycle, half a cycle apart."""
    s = vi.Structure([1.0], [0.02], [1.0], friction=[vi.Friction([1.0], 0.6)])
    events, phases, _ = settled(s, vi.Load(0.4, cosine=[1.0]), 60)
    halts, slips = (np.sort(phases[(events["kind"] == "halt") == which]) for which in (True, False))
    assert sorted(events["kind"].tolist()) == ["halt", "halt", "slip_down", "slip_up"]
    assert halts == pytest.approx([3.12341231585, 3.12341231585 + math.pi], abs=2e-11)
    assert slips == pytest.approx([1.14911242025, 4.29070507384], abs=2e-11)


def test_two_masses():
    """A force on a mass, until .2, which a spring joins to one that friction holds, until it slips, and at the
    end."""
    stiffness = [[1e4, -1e4], [-1e4, 1e4]]
    s = vi.Structure(
        [5.0, 5.0], [0.0, 0.0], stiffness, friction=[vi.Friction([1.0, 0.0], 2e3, 3e3)]
    )
    record = vi.Record(0.1, [[0.0, 3e3]] * 3)
    run = vi.simulate(s, record, duration=0.34)
    assert run.events["kind"].tolist() == ["slip_up", "halt"]
    assert run.events["time"] == pytest.approx([0.03512407, 0.31492], abs=5e-6)
    assert run.events["time"][0] == pytest.approx(math.pi / 2 / math.sqrt(2000), rel=1e-12)
    q, _ = run.sample([0.02, 0.15, 0.34])
    assert q[1] == pytest.approx([0.11221, 1.80751, 3.96813], abs=3e-5)
    assert q[0, 1] == pytest.approx(1.35332, abs=3e-5)


def test_energy():
    """From event to event the work of the load is dissipated in dashpots and friction, or changes the energy."""
    s = vi.Structure([1.0, 0.5], [0.1, 0.0], [[2, -1], [-1, 1]],
                     friction=[vi.Friction([1, 0], 0.2, 0.3), vi.Friction([-1, 1], 0.1, 0.1, 0.05)])  # fmt: skip
    load = vi.Load(0.7, cosine=[0.8, 0.3])
    run = vi.simulate(s, load, duration=30)
    assert {"halt", "slip_up", "slip_down"} <= set(run.events["kind"])
    nodes, weights = np.polynomial.legendre.leggauss(24)
    ends = [*run.events["time"].tolist(), run.end]
    begin, state = run.start, run.initial_state
    for i, end in enumerate(ends):
        balance = -energy(s, state)
        pieces = np.linspace(begin, end, 6)
        middle = 0.5 * (begin + end)
        moving = []
        for part in s.friction:
            rate = run.sample([middle])[1][:, 0]
            speed = part.direction @ rate - part.speed
            moving.append(0.0 if abs(speed) < 1e-9 else math.copysign(part.slip, speed))
        for low, high in itertools.pairwise(pieces):
            t = 0.5 * (low + high) + 0.5 * (high - low) * nodes
            q, rate = run.sample(t)
            push = load.cosine.T @ np.cos(load.frequency * t)[None]
            power = (push * rate).sum(0) - (rate * (s.damping @ rate)).sum(0)
            acceleration = run.acceleration(t)
            inertia = s.mass @ acceleration + s.damping @ rate + s.stiffness @ q - push
            for part, force in zip(s.friction, moving, strict=True):
                power -= force * (part.direction @ rate)
                inertia += force * part.direction[:, None]
            # the remainder are the forces that hold
            held = [
                part.direction for part, force in zip(s.friction, moving, strict=True) if not force
            ]
            if held:
                forces, *_ = np.linalg.lstsq(np.array(held).T, -inertia, rcond=None)
                assert np.abs(inertia + np.array(held).T @ forces).max() < 1e-10
                at = [part for part, force in zip(s.friction, moving, strict=True) if not force]
                for part, force in zip(at, forces, strict=True):
                    assert np.abs(force).max() <= part.stick * (1 + 1e-9)
                    power -= force * (part.direction @ rate)
            else:
                assert np.abs(inertia).max() < 1e-10
            balance -= 0.5 * (high - low) * weights @ power
        after = run.states[i] if i < len(run.events) else run.final_state
        assert balance + energy(s, after) == pytest.approx(0, abs=1e-10)
        begin, state = end, after


def with_friction(rng, coupled, gaps, stops, many):
    """A random structure with some gaps, stops and friction, and a load."""
    plain = random_structure(rng, coupled)
    n = plain.coordinates
    elements = [
        vi.Gap(rng.normal(size=n), rng.uniform(0.1, 0.4), rng.uniform(0.8, 1.0))
        for _ in range(gaps)
    ]
    elements += [
        vi.Stop(rng.normal(size=n), rng.uniform(0.0, 0.3), rng.uniform(5, 60), rng.choice([0.0, 1.0]),
                release=str(rng.choice(["gap", "force"])))
        for _ in range(stops)
    ]  # fmt: skip
    friction = []
    for _ in range(many):
        slip = rng.uniform(0.05, 0.6)
        belt = rng.choice([0.0, 0.0, 1.0]) * rng.normal()
        stick = slip * rng.choice([1.0, rng.uniform(1.1, 2)])
        friction.append(vi.Friction(rng.normal(size=n), slip, stick, 0.3 * belt))
    s = vi.Structure(plain.mass, plain.damping, plain.stiffness, elements, friction)
    load = vi.Load(
        rng.uniform(0.5, 2), sine=rng.normal(size=(1, n)), cosine=rng.normal(size=(1, n)),
        constant=0.3 * rng.normal(size=n),
    )  # fmt: skip
    return s, load


#: Seed, coupling of modes by damping, gaps, stops and friction; contacts last several steps of the
#: reference.
RANDOM = [
    (5, False, 0, 0, 1), (4, True, 0, 0, 1), (11, False, 0, 0, 2), (14, True, 0, 0, 2), (22, False, 0, 0, 3),
    (25, True, 0, 0, 3), (34, False, 1, 0, 1), (35, True, 1, 0, 1), (43, False, 0, 2, 1), (40, True, 0, 2, 1),
    (51, False, 1, 1, 2), (55, True, 1, 1, 2), (61, False, 2, 2, 2), (64, True, 2, 2, 2),
]  # fmt: skip


@pytest.mark.parametrize(("seed", "coupled", "gaps", "stops", "many"), RANDOM)
def test_against_matrix_exponentials(tmp_path, seed, coupled, gaps, stops, many):
    """All events of random structures agree, in order, with a simulation without modes and bounds."""
    rng = np.random.default_rng(100 * seed + coupled)
    s, load = with_friction(rng, coupled, gaps, stops, many)
    start = (np.zeros(s.coordinates), 0.5 * rng.normal(size=s.coordinates))
    check_reference(tmp_path, s, load, 10.0, start, 6)


def test_the_damper_of_1983():
    """With friction in the slot, the state just after the impact on L of the settled motion, and its halts."""
    for f, phase, x, rate in (
        (0.01, 1.62376042171167, -5.93479785675481, [1.99012020310088, 12.7448169033382]),
        (0.05, 1.86248339047413, -5.10496849719382, [4.08250530547076, 14.3530869563120]),
    ):
        gaps = [vi.Gap([-1, 1], 12.5, 0.75), vi.Gap([1, -1], 12.5, 0.75)]
        friction = [vi.Friction([-1, 1], f)]
        s = vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps, friction)
        load = vi.Load(1.04, sine=[1.0, 0.0])
        run = vi.simulate(s, load, cycles=1, discard=600, state=([0, 0], [0, 5.0]))
        hits = run.events["kind"] == "impact"
        left = np.flatnonzero(hits & (run.events["gap"] == 1))
        assert hits.sum() == 2
        i = int(left[0])
        assert run.events["time"][i] * 1.04 % TURN == pytest.approx(phase, abs=1e-10)
        assert run.states[i, 0, 0] == pytest.approx(x, abs=1e-10)
        assert run.states[i, 1] == pytest.approx(rate, abs=1e-9)


def test_the_damper_with_halts():
    """Twice a cycle the particle sticks to its host, then slips to the other side at once."""
    constant = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    motion = vi.exact(constant, 0.94, 37.0, ([0, 4.34], "RL"))
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    s = vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps, [vi.Friction([-1, 1], 0.01)])
    # start from the mirror image of the motion without friction
    run = vi.simulate(
        s, vi.Load(0.94, sine=[1.0, 0.0]), cycles=1, discard=900, state=tuple(-motion.states[0]),
        start=(motion.phases[0] + math.pi) % TURN / 0.94,
    )  # fmt: skip
    phases = run.events["time"] * 0.94 % TURN
    hits = run.events["kind"] == "impact"
    alone = [
        hit or time not in run.events["time"][hits]
        for hit, time in zip(hits, run.events["time"], strict=True)
    ]
    order = np.argsort(phases[alone])
    expected = [0.86481930918, 2.84751821943, 4.81522558556, 6.233420361]
    assert phases[alone][order] == pytest.approx(expected, abs=1e-9)
    assert run.events["kind"][alone][order].tolist() == ["slip_up", "impact", "impact", "slip_down"]
    assert run.events["speed"][alone][order][1:3] == pytest.approx(
        [24.8139726574, 24.8921870663], rel=1e-11
    )


@pytest.mark.parametrize(("slip", "stick"), [(0.1, 0.1), (0.1, 0.25)])
def test_rest_along_friction(slip, stick):
    """A free mass pressed against a wall bounces ever lower, is slower on the way down than up, and rests.

    The contact then holds until the load pulls by more than the stick level.
    """
    restitution, force, omega = 0.5, 1.0, 1e-3
    s = vi.Structure(
        [1.0], [0.0], [0.0], [vi.Gap([1.0], 0.0, restitution)], [vi.Friction([1.0], slip, stick)]
    )
    run = vi.simulate(s, vi.Load(constant=[force]), duration=20, state=([-1.0], [0.0]))
    up, down = force + slip, force - slip
    first = math.sqrt(2 / down)
    speed = restitution * down * first
    hops = speed * (1 / up + 1 / math.sqrt(up * down)) / (1 - restitution * math.sqrt(down / up))
    stuck = run.events[run.events["kind"] == "stick"]
    assert stuck["time"] == pytest.approx([first + hops], abs=1e-9)
    assert run.events[-1] == stuck[0]
    # as the load reverses, the mass lets go at -stick, and then slides against slip
    load = vi.Load(omega, cosine=[force])
    start = 1000.0
    run = vi.simulate(s, load, duration=1500, state=([0.0], [0.0]), start=start)
    released = math.acos(-stick / force) / omega
    assert run.events["kind"].tolist()[:2] == ["release", "slip_down"]
    assert run.events["time"][:2] == pytest.approx([released] * 2, rel=1e-12)
    t = np.linspace(released, released + 200, 20)
    flown = (math.cos(omega * released) - np.cos(omega * t)) / omega**2 * force
    flown += slip * (t - released) ** 2 / 2 - force * math.sin(omega * released) / omega * (
        t - released
    )
    assert run.sample(t)[0][0] == pytest.approx(flown, rel=1e-8, abs=1e-6)


def test_forces_with_rests():
    """A damper whose particle rests on its walls, with friction along them: both forces keep their limits."""
    gaps = [vi.Gap([-1, 1], 3.0, 0.2), vi.Gap([1, -1], 3.0, 0.2)]
    s = vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps, [vi.Friction([-1, 1], 0.01, 0.015)])
    load = vi.Load(0.9, sine=[1.0, 0.0])
    run = vi.simulate(s, load, cycles=6, discard=100, state=([0, 0], [0, 5.0]))
    kinds = run.events["kind"].tolist()
    assert {"stick", "release", "impact"} <= set(kinds)
    t = np.linspace(run.start, run.end, 4001)
    q, rate = run.sample(t)
    apart = q[1] - q[0]
    assert np.abs(apart).max() < 3 + 1e-9
    acceleration = run.acceleration(t)
    push = acceleration[0] + 0.02 * rate[0] + q[0] - np.sin(0.9 * t)
    # the force on the host reacts on the particle
    assert push == pytest.approx(-0.1 * acceleration[1], abs=1e-9)
    free = np.abs(apart) < 3 - 1e-9
    assert np.abs(push[free]).max() < 0.015 + 1e-9
    resting = ~free & (np.abs(rate[1] - rate[0]) < 1e-9)
    assert resting.sum() > 200
    # the wall pushes, and friction pulls by at most its stick level
    assert (np.sign(apart[resting]) * push[resting]).min() > -0.015 - 1e-9
    # a part of the rest, from its middle on
    middle = 0.5 * (run.start + run.end)
    state = tuple(part[:, 0] for part in run.sample([middle]))
    rest = vi.simulate(s, load, duration=run.end - middle, start=middle, state=state)
    later = run.events[run.events["time"] > middle]
    for kind in ("stick", "release"):
        times = [events["time"][events["kind"] == kind] for events in (rest.events, later)]
        assert times[0] == pytest.approx(times[1], abs=1e-8)
        assert len(times[0]) > 2


def test_rests_with_friction():
    """Accumulating impacts that move friction in another direction, or a belt, are refused; uncoupled friction
    continues."""
    s = vi.Structure(
        [1.0, 1.0], [0, 0], [0, 0], [vi.Gap([1.0, 0.0], 0.0, 0.5)], [vi.Friction([1.0, 1.0], 0.1)]
    )
    with pytest.raises(vi.SingularError, match="move friction that acts across it"):
        vi.simulate(s, vi.Load(constant=[1.0, 0.1]), duration=20, state=([-1.0, 0.0], [0.0, 0.0]))
    belt = vi.Structure(
        [1.0], [0], [0], [vi.Gap([1.0], 0.0, 0.5)], [vi.Friction([1.0], 0.1, speed=0.05)]
    )
    with pytest.raises(vi.SingularError, match="on a belt or along a moving wall"):
        vi.simulate(belt, vi.Load(constant=[1.0]), duration=20, state=([-1.0], [0.0]))
    floor = vi.Structure(
        [1.0, 1.0], [0, 0], [1.0, 0.0], [vi.Gap([0, 1], 0.0, 0.0)], [vi.Friction([1, 0], 0.1)]
    )
    run = vi.simulate(
        floor, vi.Load(constant=[0.0, 1.0]), duration=20, state=([1.0, -1.0], [0.0, 0.0])
    )
    assert run.events["kind"].tolist().count("stick") == 1
    assert run.events["kind"][-1] == "halt"


@pytest.mark.parametrize(("arguments", "message"), [
    ({"slip": -1.0}, "slip = -1.0: must be a number from 0 to 1e100"),
    ({"slip": math.inf}, "slip = inf"),
    ({"slip": 1.0, "stick": 0.5}, "stick = 0.5: must be a number from slip = 1.0 to 1e100"),
    ({"slip": 1.0, "stick": math.nan}, "stick = nan"),
    ({"slip": 1.0, "speed": math.inf}, "speed = inf"),
    ({"slip": 1.0, "direction": [0.0]}, "direction"),
])  # fmt: skip
def test_bad_input(arguments, message):
    with pytest.raises(vi.ParameterError, match=message):
        vi.Friction(**({"direction": [1.0]} | arguments))


def test_values():
    """Equality, text, wrong lengths, and the modes of a structure with friction."""
    part = vi.Friction([1, 0], 0.5, 0.7, speed=0.1)
    assert repr(part) == "Friction([1.0, 0.0], 0.5, stick=0.7, speed=0.1)"
    assert repr(vi.Friction([1], 2)) == "Friction([1.0], 2)"
    assert part == vi.Friction([1, 0], 0.5, 0.7, 0.1) != vi.Friction([1, 0], 0.5)
    s = vi.Structure([1, 1], [0, 0], [1, 1], friction=[part])
    assert repr(s) == "<Structure of 2 coordinates with friction>"
    assert s != vi.Structure([1, 1], [0, 0], [1, 1])
    with pytest.raises(
        vi.ParameterError, match=r"friction\[0\].direction has 2 numbers: must have 1"
    ):
        vi.Structure([1.0], [0.1], [1.0], friction=[part])
    with pytest.raises(vi.ParameterTypeError, match=r"friction\[0\]"):
        vi.Structure([1.0], [0.1], [1.0], friction=[vi.Gap([1.0], 1.0)])
    with pytest.raises(vi.ParameterTypeError, match=r"gaps\[0\]"):
        vi.Structure([1.0], [0.1], [1.0], [vi.Friction([1.0], 1.0)])
    beam = vi.Structure.from_modes(
        [1.0, 6.27], [0.01, 0.01], [[2.0, -2.0]], friction=[vi.Friction([1.0], 0.1)]
    )
    assert beam.friction[0].direction.tolist() == [2.0, -2.0]


def test_pictures():
    """A trajectory with friction is drawn."""
    pytest.importorskip("matplotlib")
    s, load = den_hartog(0.4, 0.01, 0.6)
    assert len(np.ravel(vi.simulate(s, load, cycles=3).plot())) > 2
    gaps = [vi.Gap([-1, 1], 12.5, 0.75), vi.Gap([1, -1], 12.5, 0.75)]
    s = vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps, [vi.Friction([-1, 1], 0.05)])
    run = vi.simulate(s, vi.Load(1.04, sine=[1.0, 0.0]), cycles=20)
    assert len(np.ravel(run.plot())) > 2


def test_in_parts():
    """A run continued from its final state, sliding or sticking, equals the complete run."""
    s = vi.Structure([1.0, 0.5], [0.1, 0.0], [[2, -1], [-1, 1]],
                     friction=[vi.Friction([1, 0], 0.2, 0.3), vi.Friction([-1, 1], 0.1, 0.1, 0.05)])  # fmt: skip
    load = vi.Load(0.7, cosine=[0.8, 0.3])
    check_parts(s, load, lambda _: np.linspace(5.03, 14, 7).tolist(), 1e-10)


@pytest.mark.parametrize("coordinates", [1, 2, 4])
def test_friction_that_sticks_along_one_direction(coordinates):
    """Forces of elements along one direction are indeterminate, whether or not other coordinates are free."""
    direction = np.eye(coordinates)[-1]
    parts = [vi.Friction(direction, h) for h in (0.3, 0.2, 0.1)]
    s = vi.Structure(*(np.ones((3, coordinates))), friction=parts)
    with pytest.raises(vi.SingularError, match="friction elements with linearly dependent"):
        vi.simulate(s, vi.Load(1.0, cosine=0.1 * direction), cycles=1)
    one = vi.Structure(*(np.ones((3, coordinates))), friction=[vi.Friction(direction, 0.6)])
    assert vi.simulate(one, vi.Load(1.0, cosine=0.1 * direction), cycles=1).end > 6
