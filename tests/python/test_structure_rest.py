"""Periodic motions of structures with accumulation and rest, and searches for periodic motions."""

from itertools import pairwise

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, SingularError


def unequal_walls():
    """An oscillator with a motion that rests on its left wall, as a structure."""
    gaps = [vi.Gap([-1, 1], 3, 0.75), vi.Gap([1, -1], 3, 0.61)]
    return vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps), vi.Load(0.9, sine=[1, 0])


def host_with_dashpot():
    """A host of two masses that carries a particle by a dashpot and a spring, between two walls."""
    mass = np.diag([1.0, 0.6, 0.2])
    stiffness = np.array([[3.0, -1.0, 0.0], [-1.0, 1.15, -0.15], [0.0, -0.15, 0.15]])
    damping = np.array([[0.06, -0.02, 0.0], [-0.02, 0.12, -0.1], [0.0, -0.1, 0.1]])
    gaps = [vi.Gap([0, -1, 1], 0.25, 0.4), vi.Gap([0, 1, -1], 0.6, 0.5)]
    return vi.Structure(mass, damping, stiffness, gaps), vi.Load(0.9, cosine=[0.7, 0, 0.1])


def settled_with_rest(structure, load, cycles=300):
    run = vi.simulate(structure, load, cycles=cycles)
    return vi.exact(structure, load, run)


def test_rest_of_the_oscillator_by_the_general_path():
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    reference = vi.exact(osc, 0.9, 6.0, vi.simulate(osc, 0.9, 6.0, cycles=8, discard=200))
    motion = settled_with_rest(*unequal_walls())
    assert motion.rests["gap"].tolist() == [1]
    assert motion.consistent
    assert motion.admissible
    assert motion.stable
    # the release, and the two multipliers that do not vanish
    largest = np.sort(np.abs(reference.multipliers))[-2:]
    np.testing.assert_allclose(np.sort(np.abs(motion.multipliers))[-2:], largest, rtol=1e-8)
    np.testing.assert_allclose(
        motion.multipliers[:2].sum().real, reference.multipliers.sum().real, rtol=1e-8
    )
    wall = motion.phases[motion.gaps == 0][0]
    side = reference.phases[0]
    release = reference.phases[1] - side
    assert (motion.rests["end"][0] - wall - release) % (2 * np.pi) == pytest.approx(
        0, abs=2 * np.pi
    )
    assert motion.speeds[motion.gaps == 0][0] == pytest.approx(
        abs(reference.X_dot_before[0] - reference.Z_dot_before[0]), rel=1e-10
    )


@pytest.mark.parametrize("system", [unequal_walls, host_with_dashpot])
def test_two_multipliers_vanish_for_each_rest(system):
    motion = settled_with_rest(*system())
    assert len(motion.rests) >= 1
    moduli = np.sort(np.abs(motion.multipliers))
    assert moduli[1] < 1e-9 * max(1, moduli[-1])
    assert np.linalg.matrix_rank(motion.matrix, tol=1e-8 * np.abs(motion.matrix).max()) <= (
        len(moduli) - 2
    )


@pytest.mark.parametrize("system", [unequal_walls, host_with_dashpot])
def test_multipliers_with_rest_against_differences(system):
    # the stroboscopic map by simulation, at a load phase without rest; its eigenvalues are the multipliers
    structure, load = system()
    motion = settled_with_rest(structure, load)
    n = structure.coordinates
    busy = [(p, p) for p in motion.phases] + [(r["begin"], r["end"]) for r in motion.rests]
    busy = sorted((np.mod(a, 2 * np.pi * motion.cycles), b - a) for a, b in busy)
    ends = [a + length for a, length in busy]
    begins = [a for a, _ in busy[1:]] + [busy[0][0] + 2 * np.pi * motion.cycles]
    free = np.array(begins) - np.array(ends)
    at = int(np.argmax(free))
    start = (ends[at] + 0.5 * free[at]) / load.frequency
    q, rate = motion.sample([start])
    state = np.concatenate([q[:, 0], rate[:, 0]])

    def image(s):
        run = vi.simulate(structure, load, cycles=motion.cycles, start=start, state=(s[:n], s[n:]))
        return np.concatenate(run.final_state)

    assert np.abs(image(state) - state).max() < 1e-9
    step = 1e-5
    jacobian = np.empty((2 * n, 2 * n))
    for i in range(2 * n):
        e = np.zeros(2 * n)
        e[i] = step
        jacobian[:, i] = (image(state + e) - image(state - e)) / (2 * step)
    expected = np.linalg.eigvals(jacobian)
    np.testing.assert_allclose(
        np.sort(np.abs(motion.multipliers))[-2:], np.sort(np.abs(expected))[-2:], atol=2e-5
    )


def test_exact_follows_a_motion_with_rest():
    structure, load = unequal_walls()
    motion = settled_with_rest(structure, load)
    near = vi.exact(structure, vi.Load(0.9005, sine=[1, 0]), motion)
    assert near.rests["gap"].tolist() == [1]
    again = settled_with_rest(structure, vi.Load(0.9005, sine=[1, 0]))
    assert vi.same_motion(near, again)
    assert not vi.same_motion(near, motion)


def test_sample_holds_the_gap_closed_during_rest():
    structure, load = unequal_walls()
    motion = settled_with_rest(structure, load)
    rest = motion.rests[0]
    t = np.linspace(rest["begin"], rest["end"], 7)[1:-1] / load.frequency
    q, q_dot = motion.sample(t)
    np.testing.assert_allclose(q[0] - q[1], 3, rtol=1e-12)
    np.testing.assert_allclose(q_dot[0], q_dot[1], atol=1e-11)


@pytest.mark.parametrize("system", [unequal_walls, host_with_dashpot])
def test_flights_of_a_motion_with_rest(system):
    """The flights and rests of a motion equal those of a simulation."""
    structure, load = system()
    motion = settled_with_rest(structure, load)
    run = motion._run()
    for kind, name in (("stick", "begin"), ("release", "end")):
        phases = run.events["time"][run.events["kind"] == kind] * load.frequency
        apart = np.remainder(phases - motion.rests[name] + 1, 2 * np.pi * motion.cycles) - 1
        np.testing.assert_allclose(apart, 0, atol=1e-9)
    whole = vi.simulate(
        structure, load, duration=motion.period, start=run.start, state=(motion.q, motion.q_dot)
    )
    t = np.linspace(run.start, run.end, 400, endpoint=False)
    for ours, theirs in zip(run.sample(t), whole.sample(t), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-9)


def inelastic_walls():
    """The oscillator with R = 0, whose mass rests after every impact."""
    return vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.0).structure(6.0), vi.Load(
        0.9, sine=[1, 0]
    )


def ball_on_a_table(opening, restitution, amplitude):
    """A ball under gravity on a table that shakes; the coordinate counts downwards."""
    table = vi.Gap([1], opening, restitution)
    ball = vi.Structure(mass=[1], damping=[0.02], stiffness=[0], gaps=[table])
    return ball, vi.Load(1.0, sine=[amplitude], constant=[1.0])


BALLS = [
    (opening, restitution, amplitude)
    for opening in (0.0, 1e-3)
    for restitution in (0.0, 0.3)
    for amplitude in (1.2, 1.5)
]


@pytest.mark.parametrize("ball", [None, *BALLS])
def test_a_motion_stays_between_its_walls(ball):
    """For any opening and R, samples stay behind the walls, energy balances, and the motion continues."""
    structure, load = inelastic_walls() if ball is None else ball_on_a_table(*ball)
    motion = settled_with_rest(structure, load)
    assert len(motion.rests)
    run = motion._run()
    kinds = run.events["kind"].tolist()
    assert [kinds.count(kind) for kind in ("impact", "stick", "release")] == [
        len(motion.gaps),
        len(motion.rests),
        len(motion.rests),
    ]
    assert (np.diff(run.events["time"]) >= 0).all()
    q, _ = motion.sample(np.linspace(run.start, run.end, 2001))
    size = np.abs(q).max()
    for gap in structure.gaps:
        assert (gap.direction @ q - gap.opening).max() < 1e-12 * size
    found = motion.quantities()
    taken = found.damping_loss + found.impact_loss
    assert found.work == pytest.approx(taken, rel=1e-10, abs=1e-12 * taken)
    # the state after an impact can start a simulation
    again = vi.simulate(
        structure, load, cycles=motion.cycles, start=run.start, state=(motion.q, motion.q_dot)
    )
    np.testing.assert_allclose(again.final_state[0], motion.q, atol=1e-8 * size)


def test_a_trajectory_without_repetition_is_refused():
    wall = vi.Structure([1], [0.02], [1], [vi.Gap([1], 0, 0.95)])
    load = vi.Load(2.76, cosine=[1.0])
    run = vi.simulate(wall, load, cycles=3.3, state=([-0.4], [1.0]))
    with pytest.raises(SingularError, match="does not repeat"):
        vi.exact(wall, load, run)


def test_find_gives_both_images_and_the_unstable_motions():
    gaps = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    damper = vi.Structure([1, 0.042], [0.01, 0], [1, 0], gaps)
    motions = vi.find(damper, vi.Load(0.94, sine=[1, 0]), max_cycles=1, states=12, guesses=96)
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    reference = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    wanted = sorted(abs(m.multipliers[0]) for m in reference if len(m.phases) == 2)
    found = sorted(abs(m.multipliers[0]) for m in motions if len(m.phases) == 2)
    np.testing.assert_allclose(found, wanted, rtol=1e-9)
    stable = [m for m in motions if m.stable]
    assert len(stable) == 2
    # mirror images: the gaps exchanged half a cycle later
    phases, gaps = stable[0].phases + np.pi, 1 - stable[0].gaps
    mirrored = vi.exact(damper, vi.Load(0.94, sine=[1, 0]), (phases, gaps))
    assert vi.same_motion(mirrored, stable[1])
    assert not vi.same_motion(stable[0], stable[1])


def test_find_depends_on_its_seed_alone():
    structure, load = unequal_walls()
    one = vi.find(structure, load, states=6, max_cycles=2, guesses=4, threads=1)
    two = vi.find(structure, load, states=6, max_cycles=2, guesses=4, threads=2)
    assert [m.phases.tolist() for m in one] == [m.phases.tolist() for m in two]
    assert one.settled == two.settled


def test_find_reduces_a_motion_to_its_shortest_period():
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motions = vi.find(wall, vi.Load(1.0, cosine=[1]), max_impacts=2, max_cycles=2, states=3)
    assert [(len(m.phases), m.cycles) for m in motions if m.stable] == [(1, 1)]


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"max_impacts": 9}, "max_impacts"),
        ({"max_cycles": 0}, "max_cycles"),
        ({"guesses": 0}, "guesses"),
        ({"states": -1}, "states"),
        ({"settling": -1}, "settling"),
        ({"rng": -1}, "rng"),
        ({"threads": 0}, "threads"),
        ({"max_impacts": 8, "guesses": 10000}, "max_impacts"),
    ],
)
def test_refused_arguments_of_find(change, name):
    with pytest.raises(ParameterError, match=name):
        vi.find(*unequal_walls(), **change)


def test_progress_of_find_may_end_it():
    shares = []

    def stop(share, _):
        shares.append(share)
        if share > 0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        vi.find(*unequal_walls(), progress=stop)
    assert shares == sorted(shares)
    assert 0 < shares[-1] <= 1


def falling(run):
    """The kinds of the events of a run, with their gaps and times."""
    return [
        (str(kind), int(gap), float(time))
        for kind, gap, time in run.events[["kind", "gap", "time"]].tolist()
    ]


@pytest.mark.parametrize("last", [1.0, 0.4])
def test_a_contact_that_the_end_of_a_record_makes_pull(last):
    """A mass that a record presses against a wall falls away where the record ends, by q = -t^2/4."""
    structure = vi.Structure([1], [0], [0], [vi.Gap([1], 0.0, 0.0)])
    record = vi.Record(1.0, [[1.0], [1.0]], constant=[-0.5])
    run = vi.simulate(structure, record, duration=3 + last, state=([0], [0]))
    assert falling(run) == [("release", 0, 1.0)]
    assert run.final_state[0] == pytest.approx([-0.25 * (2 + last) ** 2], rel=1e-14)
    assert run.final_state[1] == pytest.approx([-0.5 * (2 + last)], rel=1e-14)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("step", [0.6914710939708643, 1.0, 0.3])
def test_a_force_that_only_touches_zero_at_a_sample_ends_no_rest(restitution, step):
    """A record falls to 0 at a sample and rises again, or stays 0 after its end: the mass rests permanently."""
    structure = vi.Structure([1.7], [0.3], [2.0], [vi.Gap([1], 0.0, restitution)])
    for force in ([1.0, 0.0, 1.0], [2.0, 0.5, 0.0]):
        record = vi.Record(step, [[one - 0.5] for one in force], constant=[0.5])
        run = vi.simulate(structure, record, duration=1.9 * step, state=([0], [0]), max_events=1000)
        assert not run.events.size
        assert run.final_state[0] == pytest.approx([0], abs=1e-16)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("frequency", [0.9608379963332302, 1.3, 2.0])
def test_a_force_that_only_touches_zero_ends_no_rest(restitution, frequency):
    """A load 1 + cos that presses a mass against a wall is 0 once per period: the mass rests, in any units."""
    for mass, length, time in [(1, 1, 1), (3, 1, 1), (1, 2.0**-20, 1), (1, 1 / 3, 1), (1, 1, 3)]:
        force = mass * length / time**2
        structure = vi.Structure(
            [2.3 * mass], [0.08 * mass / time], [mass / time**2], [vi.Gap([1], 0.0, restitution)]
        )
        load = vi.Load(frequency / time, cosine=[[force]], constant=[force])
        run = vi.simulate(structure, load, duration=60 * time, state=([0], [0]), max_events=100)
        assert not run.events.size
        assert run.final_state[0] == pytest.approx([0], abs=1e-15 * length)


@pytest.mark.parametrize("dip", [1e-15, 1e-14, 1e-13, 1e-12])
def test_a_gap_that_comes_back_with_a_speed_of_rounding_rests(dip):
    """With R = 1 a gap that its load opens briefly does not bounce endlessly at 1e-18 of the speeds."""
    for scale in (1.0, 3.0, 2.0**-30):
        structure = vi.Structure([2.3], [0.08], [1.0], [vi.Gap([1], 0.0, 1.0)])
        load = vi.Load(1.0, cosine=[[scale]], constant=[scale * (1 - dip)])
        run = vi.simulate(structure, load, duration=20, state=([0], [0]), max_events=100)
        kinds = run.events["kind"].tolist()
        assert len(kinds) <= 12
        assert kinds.count("stick") == kinds.count("release")
        assert abs(run.final_state[0][0]) < 1e-12 * scale


def dashpot_between(restitution=1.0):
    """Two bodies with a dashpot between them; a wall touches the first, and another is 1 from the second."""
    gaps = [vi.Gap([1, 0], 0.0, 0.0), vi.Gap([0, 1], 1.0, restitution)]
    return vi.Structure([1, 1], [[0.5, -0.5], [-0.5, 0.5]], [0, 0], gaps)


def test_an_impact_elsewhere_makes_a_contact_pull():
    """The dashpot pushes the first body while the second one approaches its wall, and pulls after its impact."""
    run = vi.simulate(
        dashpot_between(), vi.Load(constant=[0.1, 0]), duration=3, state=([0, 0], [0, 1])
    )
    # 1 - exp(-t/2) = 1/2
    assert falling(run) == [
        ("impact", 1, pytest.approx(2 * np.log(2))),
        ("release", 0, pytest.approx(2 * np.log(2))),
    ]
    t = 3 - 2 * np.log(2)
    # the sum of the velocities grows by 0.1 t, their difference u obeys u' = 0.1 - u
    whole, difference = -0.5 + 0.1 * t, 0.1 + 0.4 * np.exp(-t)
    assert run.final_state[1] == pytest.approx(
        [0.5 * (whole + difference), 0.5 * (whole - difference)], abs=1e-14
    )


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_bodies_that_touch_part_by_the_first_derivative_that_is_not_zero(restitution):
    """Forces that vanish with one, two or three of their derivatives, for any R: one sign lets the bodies part."""
    for order, cosine, sine, constant in [
        (1, [0], [1], 0),
        (2, [1], [0], -1),
        (3, [0, 0], [1, -0.5], 0),
        (4, [1, -0.25], [0, 0], -0.75),
    ]:
        structure = vi.Structure([1], [0.1], [1], [vi.Gap([1], 0.0, restitution)])
        for sign in (1, -1):
            load = vi.Load(
                1.0,
                cosine=sign * np.array(cosine)[:, None],
                sine=sign * np.array(sine)[:, None],
                constant=[sign * float(constant)],
            )
            run = vi.simulate(structure, load, duration=6, state=([0], [0]))
            t = 1e-2
            force = (
                sum(
                    c * np.cos((h + 1) * t) + s * np.sin((h + 1) * t)
                    for h, (c, s) in enumerate(zip(cosine, sine, strict=True))
                )
                + constant
            )
            assert len(run.events) < 200
            away = run.sample(0.3)[0][0] < 0
            assert away == (sign * force < 0), (order, sign)
            if not away and run.events.size:
                assert run.events["kind"][0] == "release"


def test_bodies_that_move_on_together_rest():
    """Particles without forces stay together after an impact with R = 0, and at the start; no impact follows."""
    structure = vi.Structure(
        [1, 2, 3], [0] * 3, [0] * 3, [vi.Gap([1, -1, 0], 1.0, 0.0), vi.Gap([0, 1, -1], 90.0, 0.5)]
    )
    run = vi.simulate(
        structure, vi.Load(constant=[0, 0, 0]), duration=20, state=([0] * 3, [3, 0, 0])
    )
    assert falling(run)[:2] == [
        ("impact", 0, pytest.approx(1 / 3)),
        ("stick", 0, pytest.approx(1 / 3)),
    ]
    assert run.states[1, 1] == pytest.approx([1, 1, 0], abs=1e-15)


def test_rests_that_end_together():
    """Each contact that pulls is released, also several simultaneously, and each has its event."""
    gaps = [vi.Gap([1, 0, 0], 0.0, 0.0), vi.Gap([0, 1, 0], 0.0, 0.3), vi.Gap([0, 0, 1], 0.0, 1.0)]
    structure = vi.Structure([1, 2, 3], [0] * 3, [0] * 3, gaps)
    record = vi.Record(1.0, [[2.0, 2.0, 4.0]] * 3, constant=[-1.0, -1.0, 1.0])
    run = vi.simulate(structure, record, duration=4, state=([0] * 3, [0] * 3))
    assert falling(run) == [("release", 0, 2.0), ("release", 1, 2.0)]
    assert run.final_state[0] == pytest.approx([-2, -1, 0], abs=1e-14)
    load = vi.Load(1.0, sine=[1.0, 1.0, 1.0])
    run = vi.simulate(structure, load, duration=4, state=([0] * 3, [0] * 3))
    assert sorted(falling(run)) == [("release", gap, pytest.approx(np.pi)) for gap in range(3)]
    assert run.final_state[0] == pytest.approx(
        (np.pi - 4 - np.sin(4)) / np.array([1, 2, 3]), abs=1e-12
    )


def random_rests(seed):
    """Bodies on springs and dashpots, several of which touch walls, and a record or harmonics."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    damping, stiffness = np.zeros((n, n)), np.diag(rng.uniform(0, 2, n))
    for _ in range(n):
        ends = np.eye(n)[rng.integers(n)] - np.eye(n)[rng.integers(n)]
        damping += rng.uniform(0.2, 1.5) * np.outer(ends, ends)
    gaps = [
        vi.Gap(
            np.eye(n)[i] * rng.choice([-1, 1]), rng.choice([0, 0, 0.3]), rng.choice([0, 0, 0.5, 1])
        )
        for i in range(n)
    ]
    start = (
        np.zeros(n),
        np.array([-np.abs(rng.normal()) * gap.direction[i] for i, gap in enumerate(gaps)])
        * (rng.random(n) < 0.5),
    )
    structure = vi.Structure(rng.uniform(0.5, 2, n), damping, stiffness, gaps)
    if seed % 2:
        return (
            structure,
            vi.Record(
                0.7,
                rng.choice([0.0, 1.0, -1.0, 2.0], (5, n)),
                constant=rng.choice([0, 0.3, -0.5], n),
            ),
            start,
        )
    return (
        structure,
        vi.Load(
            1.3,
            sine=rng.choice([0.0, 1.0, -1.0], n),
            cosine=rng.choice([0.0, 1.0], n),
            constant=rng.choice([0, 0.3, -0.5], n),
        ),
        start,
    )


def test_no_contact_pulls():
    """Contact forces at rest at dense times, from the equations of motion: neither they nor gaps are negative."""
    rests = 0
    for seed in range(60):
        structure, load, start = random_rests(seed)
        run = vi.simulate(structure, load, duration=6, state=start)
        directions = np.array([gap.direction for gap in structure.gaps])
        openings = np.array([gap.opening for gap in structure.gaps])
        edges = np.concatenate([[0], run.events["time"], [6.0]])
        if isinstance(load, vi.Record):
            edges = np.unique(np.concatenate([edges, 0.7 * np.arange(5)]))
        for begin, end in pairwise(edges):
            if end - begin < 1e-6:
                continue
            times = begin + (end - begin) * np.linspace(1e-6, 1 - 1e-6, 12)
            q, rate = run.sample(times)
            gap = openings[:, None] - directions @ q
            assert gap.min() > -1e-12
            closed = np.flatnonzero(np.abs(gap).max(axis=1) < 1e-12)
            if not closed.size:
                continue
            rests += closed.size
            if isinstance(load, vi.Record):
                force = np.array(
                    [
                        np.interp(times, 0.7 * np.arange(5), column, right=0)
                        for column in load.force.T
                    ]
                )
                force += load.constant[:, None]
            else:
                force = (
                    load.sine.T @ [np.sin(1.3 * times)]
                    + load.cosine.T @ [np.cos(1.3 * times)]
                    + load.constant[:, None]
                )
            force = force - structure.damping @ rate - structure.stiffness @ q
            kicks = np.linalg.solve(structure.mass, directions[closed].T)
            assert np.linalg.solve(directions[closed] @ kicks, kicks.T @ force).min() > -1e-11, (
                seed,
                begin,
            )
    assert rests > 200


@pytest.mark.parametrize("discard", [0.0, 0.03])
def test_a_gap_that_rests_from_the_start_is_sampled_at_rest(discard):
    """The start has only rounding velocities, and no scale to compare them with: the gap still rests."""
    direction = np.array([-1.1, 0.7])
    structure = vi.Structure([2.0, 0.9], [0, 0], [1.3, 0.4], [vi.Gap(direction, 0.0, 0.3)])
    load = vi.Load(1.7, cosine=[-1.0, 0.0], sine=[0.5, 1.0])
    run = vi.simulate(
        structure, load, duration=2.0 - discard, state=([0, 0], [0, 0]), discard=discard
    )
    assert run._resting() == (0,)
    end = run.events["time"][0]
    assert run.events["kind"][0] == "release"
    q, rate = run.sample(np.linspace(run.start, end, 50))
    # the sum of forces along the directions that the contact leaves free, from rest at 0
    assert np.abs(direction @ q).max() < 1e-15
    assert np.abs(direction @ rate).max() < 1e-15
    assert np.abs(q[:, -1]).min() > 1e-3


@pytest.mark.parametrize("seed", range(12))
def test_a_run_that_begins_with_rests_is_sampled_as_it_was_simulated(seed):
    """Gaps may rest at the start and where a transient ends; no sample is beyond a wall."""
    structure, load, state = random_rests(seed)
    whole = vi.simulate(structure, load, duration=6, state=state)
    directions = np.array([gap.direction for gap in structure.gaps])
    openings = np.array([gap.opening for gap in structure.gaps])
    for discard in (0.0, 0.9, 2.3, 4.1):
        run = vi.simulate(structure, load, duration=6 - discard, state=state, discard=discard)
        t = np.linspace(run.start, 6, 300)
        q, _ = run.sample(t)
        size = 1 + np.abs(q).max()
        assert (openings[:, None] - directions @ q).min() > -1e-10 * size
        np.testing.assert_allclose(q, whole.sample(t)[0], atol=1e-9 * size)


@pytest.mark.parametrize("step", [0.5, 0.7213308177841445, 1.0])
def test_contacts_whose_forces_vanish_together_with_those_of_a_record(step):
    """A record cancels the constant load, and thus both forces of a stack: the two bodies part at once."""
    structure = vi.Structure(
        [0.4591464024330024, 2.348501480227643],
        [[0.3210681079705415, -0.10292307465894909], [-0.10292307465894909, 0.3061762046835734]],
        [[2.978234649437526, -1.0895678048854627], [-1.0895678048854627, 1.0895678048854627]],
        [vi.Gap([1, -1], 0.0, 0.6), vi.Gap([0, 1], 0.0, 0.0)],
    )
    record = vi.Record(step, [[1, 0.5], [0, 0.5], [-1, 0.5]], constant=[-0.5, -0.5])
    run = vi.simulate(structure, record, duration=step, state=([0, 0], [0, 0]))
    assert sorted(kind + str(gap) for kind, gap, _ in falling(run)) == ["release0", "release1"]
    assert run.events["time"] == pytest.approx([step / 2] * 2, abs=1e-12)
    q = run.sample(0.9 * step)[0]
    assert q[0] < q[1] < 0


@pytest.mark.parametrize("many", [None, 8, 12, 20])
def test_phases_of_an_accumulation(many):
    """All impacts before a rest, or the first of them, are no guess of a motion without rest: `exact` recognises
    the accumulation, and returns the motion of the simulation from which they were taken."""
    one_wall = (
        vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 0.2, 0.4)]),
        vi.Load(0.5, cosine=[1]),
    )
    for s, load in (one_wall, unequal_walls()):
        settled = vi.exact(s, load, vi.simulate(s, load, cycles=4, discard=200))
        assert len(settled.rests) == 1
        # the last impact on two walls is on the other wall
        kept = np.r_[: len(settled.gaps) if many is None else many]
        if many and settled.gaps[-1] != settled.gaps[0]:
            with pytest.raises(SingularError, match="accumulate"):
                vi.exact(s, load, (settled.phases[kept], settled.gaps[kept]))
            kept = np.append(kept, -1)
        found = vi.exact(s, load, (settled.phases[kept], settled.gaps[kept]))
        for name in ("gap", "begin", "end"):
            assert found.rests[name] == pytest.approx(settled.rests[name], abs=1e-9)
        assert found.phases[:6] == pytest.approx(settled.phases[:6], abs=1e-9)
        assert found.states[:6] == pytest.approx(settled.states[:6], abs=1e-9)
        with pytest.raises(
            SingularError, match=r"accumulate, so the motion rests there.* use a sim"
        ):
            vi.exact(s, load, (settled.phases[kept] + 0.5, settled.gaps[kept]))


def test_phases_of_an_accumulation_of_an_oscillator():
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    events = vi.simulate(osc, 0.9, 6.0, cycles=1, discard=200).events
    impacts = events[events["kind"] == "impact"][:24]
    guess = 0.9 * impacts["time"], vi.Pattern("".join(impacts["side"]))
    with pytest.raises(SingularError, match="the impacts 1 to 23 on wall L accumulate"):
        vi.exact(osc, 0.9, 6.0, guess)


def test_phases_that_do_not_accumulate():
    """A guess whose impacts do not accumulate, and that does not converge, is an error."""
    s, load = unequal_walls()
    with pytest.raises(SingularError, match="did not converge"):
        vi.exact(s, load, ([0.1, 0.5, 0.9, 1.3, 4.0], [0, 0, 0, 0, 1]))
