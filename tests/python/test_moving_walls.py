"""Walls of gaps and stops that move with the load, compared with closed forms and a change of coordinates."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi

GRAVITY, OMEGA = 9.81, 20.0


def ball_on_table(amplitude, restitution=0.7):
    """A ball on a table that moves by `amplitude` sin(OMEGA t), under gravity; upwards is positive."""
    table = vi.Gap([-1], 0.0, restitution, sine=-amplitude)
    ball = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=[table])
    return ball, vi.Load(OMEGA, constant=[-GRAVITY])


def differences(motion, step=1e-6):
    """The derivative of a period by differences of simulations."""
    structure, load = motion.structure, motion.load
    start, (q, q_dot) = motion._run()._between_events()
    first = np.append(q, q_dot)
    columns = []
    for i in range(len(first)):
        ends = []
        for sign in (1, -1):
            state = first.copy()
            state[i] += sign * step
            state = np.split(state, 2)
            run = vi.simulate(structure, load, duration=motion.period, state=state, start=start)
            ends.append(np.ravel(run.final_state))
        columns.append((ends[0] - ends[1]) / (2 * step))
    return np.transpose(columns)


def check_multipliers(motion, tolerance=1e-6):
    """Multipliers equal those of differences, and the determinant obeys its law."""
    found = np.sort_complex(np.linalg.eigvals(differences(motion)))
    own = np.sort_complex(motion.multipliers)
    assert np.abs(found - own).max() < tolerance * max(1, np.abs(own).max())
    assert motion.determinant == pytest.approx(motion.law, rel=1e-9, abs=1e-13)


@pytest.mark.parametrize("amplitude", [0.0145, 0.02, 0.1])
def test_a_ball_that_bounces_once_in_a_period(amplitude):
    """The ball takes off at g T/2, and R (u + w) = u - w with the speed w of the table at the impact."""
    ball, load = ball_on_table(amplitude)
    speed = GRAVITY * math.pi / OMEGA
    phase = math.acos(speed * (1 - 0.7) / (1 + 0.7) / (amplitude * OMEGA))
    motion = vi.exact(ball, load, ([phase + 0.01], [0], 1))
    assert motion.phases == pytest.approx([phase], abs=1e-13)
    assert motion.q == pytest.approx([amplitude * math.sin(phase)], abs=1e-13)
    assert motion.q_dot == pytest.approx([speed], rel=1e-13)
    assert motion.speeds == pytest.approx([speed + amplitude * OMEGA * math.cos(phase)], rel=1e-13)
    assert motion.admissible
    assert not motion.self_excited
    # P. J. Holmes, J. Sound Vib. 84 (1982): trace and determinant of the exact map
    trace = 1 + 0.49 - (1 + 0.7) ** 2 * amplitude * OMEGA**2 * math.sin(phase) / GRAVITY
    assert motion.multipliers.sum().real == pytest.approx(trace, rel=1e-9)
    assert motion.determinant == pytest.approx(0.49, rel=1e-11)
    assert motion.stable == bool(np.abs(np.roots([1, -trace, 0.49])).max() < 1)
    given = vi.periodic(ball, load, motion.phases, [0])
    assert given.residual < 1e-13
    assert given.speeds == pytest.approx(motion.speeds, rel=1e-12)


def test_a_stable_bounce_attracts():
    ball, load = ball_on_table(0.02)
    speed = GRAVITY * math.pi / OMEGA
    phase = math.acos(speed * (1 - 0.7) / (1 + 0.7) / (0.02 * OMEGA))
    motion = vi.exact(ball, load, ([phase], [0], 1))
    assert motion.stable
    check_multipliers(motion, 1e-5)
    state = ([0.02 * math.sin(phase) + 1e-4], [speed + 1e-3])
    run = vi.simulate(ball, load, cycles=400, state=state, start=phase / OMEGA)
    again = vi.exact(ball, load, run)
    assert again.speeds == pytest.approx(motion.speeds, rel=1e-9)
    assert again.multipliers == pytest.approx(motion.multipliers, abs=1e-9)


def test_rest_on_a_table_until_it_falls_faster():
    """Impacts accumulate, the ball is carried, and lifts off where the table accelerates downwards with g."""
    amplitude = 0.03
    ball, load = ball_on_table(amplitude, restitution=0.3)
    run = vi.simulate(ball, load, cycles=30, state=([0.3], [0.0]))
    kinds = run.events["kind"]
    assert {"impact", "stick", "release"} <= set(kinds)
    lifts = run.events["time"][kinds == "release"]
    expected = math.asin(GRAVITY / (amplitude * OMEGA**2))
    assert np.mod(OMEGA * lifts, 2 * math.pi) == pytest.approx(expected, abs=1e-11)
    stick = int(np.argmax(kinds == "stick"))
    begin, end = run.events["time"][stick], run.events["time"][stick + 1]
    t = np.linspace(begin, end, 9)
    q, q_dot = run.sample(t)
    assert q[0] == pytest.approx(amplitude * np.sin(OMEGA * t), abs=1e-14)
    assert q_dot[0] == pytest.approx(amplitude * OMEGA * np.cos(OMEGA * t), abs=1e-12)
    assert run.acceleration(t)[0][:-1] == pytest.approx(
        -amplitude * OMEGA**2 * np.sin(OMEGA * t[:-1]), abs=1e-10
    )
    # with an amplitude below g it rests permanently
    quiet, load = ball_on_table(0.02, restitution=0.3)
    run = vi.simulate(quiet, load, cycles=20, discard=60, state=([0.3], [0.0]))
    assert run.permanent == (0,)
    motion = vi.exact(ball, vi.Load(OMEGA, constant=[-GRAVITY]), vi.simulate(
        ball, vi.Load(OMEGA, constant=[-GRAVITY]), cycles=60, state=([0.3], [0.0])
    ))  # fmt: skip
    assert len(motion.rests) == 1
    assert motion.admissible
    assert motion.stable
    assert np.abs(motion.multipliers) == pytest.approx([0, 0], abs=1e-9)


#: Motions of the wall: cosines and sines of its harmonics.
WALL = {"cosine": [0.1, 0.02], "sine": [-0.05, 0.03]}
CONTACTS = {
    "gap": lambda **wall: vi.Gap([1, 0], 0.3, 0.6, **wall),
    "law": lambda **wall: vi.Gap([1, 0], 0.3, vi.PowerLaw(0.8, 0.5, 0.25), **wall),
    "no rebound": lambda **wall: vi.Gap([1, 0], 0.1, 0.0, **wall),
    "stop": lambda **wall: vi.Stop([1, 0], 0.3, stiffness=40, damping=1.5, **wall),
    "pushing": lambda **wall: vi.Stop([1, 0], 0.3, 40, damping=4, release="force", **wall),
    "preload": lambda **wall: vi.Stop([1, 0], 0.3, 30, damping=1, preload=0.2, **wall),
}
MASS, DAMPING = np.array([[1.0, 0.2], [0.2, 0.7]]), np.array([[0.2, -0.1], [-0.1, 0.3]])
STIFFNESS = np.array([[2.0, -1.0], [-1.0, 1.5]])


def moving_and_shifted(kind, omega=1.7):
    """A chain whose first mass meets a moving wall, with a second one at rest for the other mass; and the same in
    coordinates that move with the wall, in which it rests and the structure has a load in addition."""
    still = vi.Gap([0, -1], 0.5, 0.7)
    load = vi.Load(omega, cosine=[1.5, 0.3], sine=[0.2, 0.0], constant=[0.3, 0.0])
    moving = vi.Structure(MASS, DAMPING, STIFFNESS, [CONTACTS[kind](**WALL), still])
    further = vi.Load(omega, constant=[0.0, 0.0], cosine=np.zeros((2, 2)))
    for h in (1, 2):
        w = complex(WALL["cosine"][h - 1], -WALL["sine"][h - 1]) * np.array([1, 0])
        force = -(STIFFNESS - (h * omega) ** 2 * MASS + 1j * h * omega * DAMPING) @ w
        rows = np.zeros((2, 2, 2))
        rows[:, h - 1] = force.real, -force.imag
        further += vi.Load(omega, cosine=rows[0], sine=rows[1])
    shifted = vi.Structure(MASS, DAMPING, STIFFNESS, [CONTACTS[kind](), still])
    return moving, load, shifted, load + further


def wall_at(t, omega=1.7):
    """The motion of the wall and its rate."""
    h = omega * np.array([1, 2])
    angles = np.multiply.outer(h, t)
    c, s = np.array(WALL["cosine"]), np.array(WALL["sine"])
    return c @ np.cos(angles) + s @ np.sin(angles), (s * h) @ np.cos(angles) - (c * h) @ np.sin(
        angles
    )


@pytest.mark.parametrize("kind", CONTACTS)
def test_coordinates_that_move_with_the_wall(kind):
    """A moving wall is equivalent to a wall at rest in coordinates that move with it: impacts, rests, contacts."""
    moving, load, shifted, further = moving_and_shifted(kind)
    start = wall_at(0.0)
    run = vi.simulate(moving, load, cycles=6, state=([start[0], 0.1], [start[1] + 0.2, 0.0]))
    own = vi.simulate(shifted, further, cycles=6, state=([0.0, 0.1], [0.2, 0.0]))
    assert run.events["kind"].tolist() == own.events["kind"].tolist()
    assert {"no rebound": "stick", "stop": "touch", "pushing": "let_go"}.get(kind, "") in {
        "", *run.events["kind"]
    }  # fmt: skip
    for name in ("time", "speed", "impulse"):
        assert run.events[name] == pytest.approx(own.events[name], abs=2e-9), name
    w, w_dot = wall_at(run.events["time"])
    expected = own.states.copy()
    expected[:, 0, 0] += w
    expected[:, 1, 0] += w_dot
    assert np.abs(run.states - expected).max() < 1e-8


@pytest.mark.parametrize("kind", CONTACTS)
def test_multipliers_with_a_moving_wall(kind):
    """Multipliers equal those of the wall at rest in moving coordinates, and those of differences."""
    moving, load, shifted, further = moving_and_shifted(kind)
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=300))
    start, (q, q_dot) = motion._run()._between_events()
    w, w_dot = wall_at(start)
    state = (q - [w, 0], q_dot - [w_dot, 0])
    run = vi.simulate(shifted, further, cycles=motion.cycles, state=state, start=start)
    own = vi.exact(shifted, further, run)
    assert motion.admissible
    assert np.sort(np.abs(motion.multipliers)) == pytest.approx(
        np.sort(np.abs(own.multipliers)), abs=1e-7
    )
    check_multipliers(motion, 2e-5)


def test_two_walls_that_move_differently():
    """At each impact the gap is closed, the relative velocity obeys R, and momentum and energy balance."""
    omega, R = 1.3, 0.8
    right = vi.Gap([1], 0.4, R, sine=0.1)
    left = vi.Gap([-1], 0.5, R, cosine=[0.05, 0.1])
    mass = vi.Structure([2.0], [0.05], [1.0], [right, left])
    run = vi.simulate(mass, vi.Load(omega, cosine=[1.5]), cycles=30)
    assert set(run.events["gap"]) == {0, 1}

    def opening(gap, t):
        h = omega * np.arange(1, len(gap.cosine) + 1)
        c, s = np.cos(h * t), np.sin(h * t)
        return gap.opening + gap.cosine @ c + gap.sine @ s, h @ (gap.sine * c - gap.cosine * s)

    for event, (q, after) in zip(run.events, run.states, strict=True):
        gap = mass.gaps[event["gap"]]
        e, rate = opening(gap, event["time"])
        assert e - gap.direction @ q == pytest.approx(0, abs=1e-12)
        before = after + gap.direction * event["impulse"] / 2.0
        assert gap.direction @ before - rate == pytest.approx(event["speed"], rel=1e-10)
        assert gap.direction @ after - rate == pytest.approx(-R * event["speed"], rel=1e-9)
        # the work of the wall is its speed times the impulse, and the impact takes the loss of R
        gained = float(after @ after - before @ before)
        loss = 0.5 * 2.0 * (1 - R**2) * event["speed"] ** 2
        assert gained == pytest.approx(-event["impulse"] * rate - loss, rel=1e-9, abs=1e-12)
    t = np.linspace(0, run.end, 5000)
    q = run.sample(t)[0]
    for gap in mass.gaps:
        assert min(opening(gap, x)[0] - gap.direction @ q[:, i] for i, x in enumerate(t)) > -1e-12


def test_files(tmp_path):
    """Namelists and results keep the motion of walls."""
    moving, load, *_ = moving_and_shifted("stop")
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=200))
    assert vi.Structure(MASS, DAMPING, STIFFNESS, list(moving.gaps)) == moving
    assert vi.Structure(MASS, DAMPING, STIFFNESS, [CONTACTS["stop"](), moving.gaps[1]]) != moving
    case = tmp_path / "moving.nml"
    case.write_text(motion.to_namelist())
    again = vi.read_namelist(case)[0].run()[0]
    assert again.structure == moving
    assert again.states == pytest.approx(motion.states, abs=1e-12)
    run = vi.simulate(moving, load, cycles=3)
    for found, ending in ((again, "json"), (motion, "nc"), (run, "json"), (run, "mat")):
        path = tmp_path / f"kept.{ending}"
        found.save(path)
        assert vi.load(path).structure == moving
    assert "cosine=[0.1, 0.02], sine=[-0.05, 0.03]" in repr(moving.gaps[0])


def test_sweeps():
    """Verbs that simulate agree on the motion."""
    moving, load, *_ = moving_and_shifted("stop")
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=300))
    label = f"{len(motion.phases)}/{motion.cycles}"
    diagram = vi.bifurcation_diagram(moving, load, "frequency", [1.7, 1.701])
    assert label in diagram.labels[:, 0]
    found = vi.find(moving, load, states=4)
    assert any(
        len(one.phases) == len(motion.phases)
        and one.multipliers == pytest.approx(motion.multipliers, abs=1e-8)
        for one in found.motions
    )
    exponents = vi.lyapunov(moving, load).per_cycle
    expected = np.log(np.abs(motion.multipliers)) / motion.cycles
    assert np.sort(exponents) == pytest.approx(np.sort(expected), abs=1e-6)
    assert label in repr(vi.basins(moving, load, states=6))


def bounce_borders(omega, restitution=0.7):
    """Amplitudes of the table at the fold and at the flip of the bounce: Holmes (1982)."""
    least = GRAVITY * math.pi * (1 - restitution) / (1 + restitution) / omega**2
    # trace + det + 1 = 0
    steep = 2 * GRAVITY * (1 + restitution**2) / ((1 + restitution) * omega) ** 2
    return least, math.hypot(least, steep)


def stable_bounce():
    ball, load = ball_on_table(0.02)
    phase = math.acos(bounce_borders(OMEGA)[0] / 0.02)
    return vi.exact(ball, load, ([phase], [0], 1))


def test_fold_and_flip_of_the_bounce():
    """Branches along the amplitude of the table and along the frequency end where closed forms predict."""
    motion = stable_bounce()
    expected = np.array(bounce_borders(OMEGA))
    branch = vi.branch(motion, "wall", bounds=(0.3, 3))
    points = {point.type: point.value for point in branch.special_points}
    assert [points["fold"], points["flip"]] == pytest.approx(expected / 0.02, rel=1e-12)
    # a function of a parameter may move the wall, too
    branch = vi.branch(motion, lambda a: ball_on_table(a), bounds=(0.01, 0.04), at=0.02)
    points = {point.type: point for point in branch.special_points}
    found = [points["fold"].value, points["flip"].value]
    assert found == pytest.approx(expected, rel=1e-12)
    table = points["flip"].motion.structure.gaps[0]
    assert table.sine == pytest.approx([-expected[1]], rel=1e-12)
    # both boundaries fall as the square of the frequency
    branch = vi.branch(motion, "frequency", bounds=(15, 30))
    points = {point.type: point.value for point in branch.special_points}
    found = [points["fold"], points["flip"]]
    assert found == pytest.approx(OMEGA * np.sqrt(expected / 0.02), rel=1e-12)


def test_zone_of_the_bounce():
    motion = stable_bounce()
    zone = vi.zone(motion, ("frequency", 18, 23), ("wall", 0.2, 2.4), lines=9)
    rng = np.random.default_rng(45)
    omega, factor = rng.uniform(18, 23, 300), rng.uniform(0.2, 2.4, 300)
    borders = np.array([bounce_borders(w) for w in omega]) / 0.02
    expected = (borders[:, 0] < factor) & (factor < borders[:, 1])
    # a ball that barely bounces does not occur: there is no other boundary in this range
    assert expected.any()
    assert not expected.all()
    assert (zone.contains(omega, factor) == expected).all()
    # below and above the flip, a simulation from the motion settles on it or leaves it
    for share, stays in ((0.98, True), (1.02, False)):
        ball, load = ball_on_table(share * bounce_borders(20.0)[1])
        phase = math.acos(bounce_borders(20.0)[0] / ball.gaps[0].sine[0] * -1)
        state = ([-ball.gaps[0].sine[0] * math.sin(phase) + 1e-5], [GRAVITY * math.pi / 20])
        run = vi.simulate(ball, load, cycles=2000, state=state, start=phase / 20.0)
        speeds = run.events["speed"][-2:]
        assert (abs(speeds[0] - speeds[1]) < 1e-6) == stays


def test_atlas_of_the_bounce():
    """The survey finds the bounce, whose zone has the boundaries of the closed form."""
    atlas = vi.atlas(
        *ball_on_table(0.02), ("frequency", (18, 23)), ("wall", (0.2, 2.4)), survey=60, lines=9
    )
    (zone,) = (one for one in atlas.zones if one.cycles == 1 and one.gaps.tolist() == [0])
    rng = np.random.default_rng(46)
    omega, factor = rng.uniform(18, 23, 300), rng.uniform(0.2, 2.4, 300)
    borders = np.array([bounce_borders(w) for w in omega]) / 0.02
    expected = (borders[:, 0] < factor) & (factor < borders[:, 1])
    assert (zone.contains(omega, factor) == expected).all()


def test_work_of_the_table():
    """In each bounce the table does the work m (1 + R) v w with its speed w, and the impact dissipates it."""
    motion = stable_bounce()
    found = motion.quantities()
    speed, wall = motion.speeds[0], 0.02 * OMEGA * math.cos(motion.phases[0])
    assert found.impact_loss == pytest.approx(0.5 * (1 - 0.49) * speed**2, rel=1e-12)
    assert found.work == pytest.approx((1 + 0.7) * speed * wall, rel=1e-12)
    assert found.work == pytest.approx(found.impact_loss, rel=1e-12)
    assert found.energy_change == pytest.approx(0, abs=1e-12)
    # a carried ball: the table does the work m (g + w') w, and gravity, which is part of the load, takes m g w
    ball, load = ball_on_table(0.03, restitution=0.3)
    found = vi.simulate(ball, load, duration=0.04, state=([0.0], [0.6])).quantities()
    gain = 0.5 * (0.03 * OMEGA) ** 2 * (math.cos(OMEGA * 0.04) ** 2 - 1)
    assert found.work == pytest.approx(gain, abs=1e-14)
    assert found.energy_change == pytest.approx(gain, abs=1e-14)


@pytest.mark.parametrize("kind", CONTACTS)
def test_energy_with_a_moving_wall(kind):
    """Work of loads and walls = losses + change of energy, over the period of a motion and over any window."""
    moving, load, *_ = moving_and_shifted(kind)
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=300))
    run = vi.simulate(moving, load, cycles=7)
    for found in (
        motion.quantities(), run.quantities(), run.quantities(window=(1.234, 9.87)),
        run.quantities(window=tuple(run.events["time"][[2, 5]])),
    ):  # fmt: skip
        losses = found.damping_loss + found.impact_loss + found.friction_loss
        assert found.work - losses == pytest.approx(found.energy_change, abs=1e-12 * found.work)
        assert found.damping_loss > 0
    assert abs(motion.quantities().energy_change) < 1e-12


def test_work_of_a_stop_that_moves():
    """The share of the wall in the work is minus the integral of the contact force times its speed."""
    moving, load, *_ = moving_and_shifted("stop")
    run = vi.simulate(moving, load, cycles=2)
    edges = np.unique(np.r_[0.0, run.events["time"], run.end])
    nodes, weights = np.polynomial.legendre.leggauss(30)
    total = 0.0
    for a, b in itertools.pairwise(edges):
        t = 0.5 * (a + b) + 0.5 * (b - a) * nodes
        q, q_dot = run.sample(t)
        w, rate = wall_at(t)
        h = 1.7 * np.array([1, 2])[:, None]
        force = load.cosine.T @ np.cos(h[: len(load.cosine)] * t)
        force = force + load.sine.T @ np.sin(h[: len(load.sine)] * t) + load.constant[:, None]
        depth = q[0] - 0.3 - w
        pressed = 40 * depth + 1.5 * (q_dot[0] - rate)
        power = (force * q_dot).sum(axis=0) - np.where(depth.max() > 0, pressed, 0.0) * rate
        total += 0.5 * (b - a) * (weights @ power)
    # impacts on the other wall, which is at rest, do no work
    assert run.quantities().work == pytest.approx(total, rel=1e-10)


PARAMETERS = {
    "frequency": (1.68, 1.73), "wall": (0.9, 1.1), "wall_0": (0.9, 1.1), "load": (0.95, 1.05),
    "opening_0": (0.95, 1.05), "stiffness_0_1": (-1.03, -0.98),
}  # fmt: skip


@pytest.mark.parametrize("kind", CONTACTS)
def test_branches_with_a_moving_wall(kind):
    """Each point is the motion that `exact` finds there by simulation, with the same multipliers."""
    moving, load, *_ = moving_and_shifted(kind)
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=300))
    for parameter, bounds in PARAMETERS.items():
        if parameter == "opening_0":
            bounds = np.multiply(bounds, moving.gaps[0].opening)
        branch = vi.branch(motion, parameter, bounds=bounds)
        assert branch.residual.max() < 1e-9, parameter
        inner = np.flatnonzero(branch.admissible == 1)
        assert len(inner) > 5
        for i in inner[[1, len(inner) // 2, -2]].tolist():
            point = branch[i]
            assert point.admissible
            assert point.load.frequency == branch.at(branch.values[i])[1].frequency
            assert np.sort(np.abs(point.multipliers)) == pytest.approx(
                np.sort(np.abs(branch.multipliers[:, i])), abs=2e-7
            ), parameter


def test_branch_of_a_rest():
    """The ball lifts off where the table accelerates downwards with g, all along the branch."""
    ball, load = ball_on_table(0.03, restitution=0.3)
    motion = vi.exact(ball, load, vi.simulate(ball, load, cycles=60, state=([0.3], [0.0])))
    for parameter, bounds in (("wall", (0.9, 1.05)), ("frequency", (19, 20.5))):
        branch = vi.branch(motion, parameter, bounds=bounds)
        inner = np.flatnonzero(branch.admissible == 1)
        assert len(inner) > 5
        factor = branch.values if parameter == "wall" else (branch.values / OMEGA) ** 2
        lift = np.arcsin(GRAVITY / (0.03 * OMEGA**2 * factor))
        ends = np.mod(branch.rests[0, 1], 2 * np.pi)
        assert ends[inner] == pytest.approx(lift[inner], abs=1e-9)
        point = branch[int(inner[len(inner) // 2])]
        assert point.admissible
        assert len(point.rests) == 1


def changed(structure, load, name, by):
    """The structure and the load after a parameter has changed."""
    gaps = list(structure.gaps)
    if name == "frequency":
        load = vi.Load(
            load.frequency + by, cosine=load.cosine, sine=load.sine, constant=load.constant
        )
    elif name == "opening_0":
        gaps[0] = replace(gaps[0], opening=gaps[0].opening + by)
    else:
        factor = 1 + by
        gaps[0] = replace(gaps[0], cosine=factor * gaps[0].cosine, sine=factor * gaps[0].sine)
    return vi.Structure(structure.mass, structure.damping, structure.stiffness, gaps), load


@pytest.mark.parametrize("kind", [kind for kind in CONTACTS if kind != "no rebound"])
def test_gradients_with_a_moving_wall(kind):
    """Derivatives of motions and trajectories equal differences of exact motions and of simulations."""
    moving, load, *_ = moving_and_shifted(kind)
    motion = vi.exact(moving, load, vi.simulate(moving, load, cycles=300))
    names, h = ["frequency", "wall_0", "opening_0"], 1e-6
    gradient = motion.gradient(names)
    state = ([0.0, 0.1], [0.2, 0.0])
    run = vi.simulate(moving, load, duration=12.0, state=state)
    along = run.gradient(names)
    for name in names:
        near = [vi.exact(*changed(moving, load, name, sign * h), motion) for sign in (1, -1)]
        found = [
            {name: getattr(one, name) for name in ("phases", "speeds", "impulses")}
            | {"q": one.states[:, 0], "q_dot": one.states[:, 1]}
            for one in near
        ]
        assert gradient["multipliers", name].sum() == pytest.approx(
            (near[0].multipliers.sum() - near[1].multipliers.sum()) / (2 * h), rel=1e-4, abs=1e-4
        ), name
        for quantity in ("phases", "speeds", "impulses", "q", "q_dot"):
            slope = (found[0][quantity] - found[1][quantity]) / (2 * h)
            own = gradient[quantity, name]
            assert own == pytest.approx(slope, rel=2e-5, abs=2e-5), (name, quantity)
        runs = [
            vi.simulate(*changed(moving, load, name, sign * h), duration=12.0, state=state)
            for sign in (1, -1)
        ]
        for quantity in ("time", "speed"):
            slope = (runs[0].events[quantity] - runs[1].events[quantity]) / (2 * h)
            own = along[quantity, name]
            assert own == pytest.approx(slope, rel=1e-4, abs=1e-4), (name, quantity)


def test_gradient_of_a_rest():
    """A ball that a table carries and throws: impacts after the rest agree with differences of exact motions."""
    h, near = 1e-7, []
    for a in (0.03, 0.03 * (1 + h), 0.03 * (1 - h)):
        ball, load = ball_on_table(a, restitution=0.3)
        run = vi.simulate(ball, load, cycles=60, state=([0.3], [0.0]))
        near.append(vi.exact(ball, load, run))
    gradient = near[0].gradient(["wall", "frequency"])
    for quantity in ("phases", "speeds"):
        # events before the accumulation ends
        slope = (getattr(near[1], quantity) - getattr(near[2], quantity))[:3] / (2 * h)
        assert gradient[quantity, "wall"][:3] == pytest.approx(slope, rel=1e-5), quantity
    # times scale with 1/Omega, lengths with g/Omega^2: a higher frequency acts as a larger amplitude
    assert gradient["phases", "frequency"] == pytest.approx(
        2 * gradient["phases", "wall"] / OMEGA, rel=1e-6
    )


def test_symmetric_walls():
    """Opposite walls that move together keep the mirror: branches have the same pitchfork as in coordinates that
    move with the walls."""
    R, w, omega = 0.8, 0.05, 1.0
    pair = [vi.Gap([1], 0.5, R, sine=w), vi.Gap([-1], 0.5, R, sine=-w)]
    still = [vi.Gap([1], 0.5, R), vi.Gap([-1], 0.5, R)]
    found = []
    for gaps in (pair, still):
        mass = vi.Structure([1.0], [0.1], [0.3], gaps)
        load = vi.Load(omega, cosine=[0.4])
        if gaps is still:
            # w sin t moves the coordinates
            load += vi.Load(omega, sine=[(omega**2 - 0.3) * w], cosine=[-0.1 * omega * w])
        motion = vi.exact(mass, load, vi.simulate(mass, load, cycles=400))
        assert motion.gaps.tolist() == [0, 1]
        branch = vi.branch(motion, "restitution", bounds=(0.3, 1))
        found.append([(point.type, point.value) for point in branch.special_points])
    assert [kind for kind, _ in found[0]] == [kind for kind, _ in found[1]]
    assert "pitchfork" in dict(found[0])
    assert [at for _, at in found[0]] == pytest.approx([at for _, at in found[1]], rel=1e-9)


def test_what_is_refused():
    ball, load = ball_on_table(0.0145)
    motion = vi.exact(ball, load, ([1.0], [0], 1))
    with pytest.raises(vi.ParameterError, match="this factor must be above 0"):
        vi.branch(motion, "wall", bounds=(0, 2))
    for without in (None, vi.Load(constant=[-1.0]), vi.Record(0.1, [[0.0], [1.0]])):
        with pytest.raises(vi.ParameterError, match="must have a frequency, with which the walls"):
            vi.simulate(ball, without, duration=1.0)
    for wrong in ([[1.0]], ["a"], [np.nan], np.zeros(101)):
        with pytest.raises((vi.ParameterError, vi.ParameterTypeError), match="cosine"):
            vi.Gap([1], 0.0, cosine=wrong)


def test_loads_add():
    """Forces, gravity and a base motion under one structure."""
    s = vi.Structure(mass=[2, 1], damping=[0, 0], stiffness=[[3, -1], [-1, 1]])
    base = vi.base_motion(s, 1.5, sine=[0.1, 0.2])
    total = vi.Load(1.5, cosine=[1.0, 0.0], constant=[0, -1]) + base + vi.Load(constant=[0.5, 0])
    assert total.frequency == 1.5
    assert total.sine == pytest.approx(base.sine)
    assert total.cosine == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0]]))
    assert total.constant == pytest.approx([0.5, -1])
    assert (vi.Load.none() + base) == base
    with pytest.raises(vi.ParameterError, match=r"frequency = 2.0: must be 1.5"):
        base + vi.Load(2.0, sine=[1, 0])
    with pytest.raises(vi.ParameterError, match="must be for 2, like the load"):
        base + vi.Load(1.5, sine=[1])
    with pytest.raises(TypeError):
        base + 1


def test_a_sweep_continues_after_a_vibration_has_died_out():
    """Between moving walls that it does not touch, a mass without a load comes to rest."""
    walls = [vi.Stop([side], 0.004, stiffness=4e3, damping=2.0, sine=0.001) for side in (1.0, -1.0)]
    box = vi.Structure([0.2], [0.4], [50.0], walls)
    run = vi.response(
        box,
        vi.Load(20.0, constant=[0.0]),
        [20.0, 21.0, 22.0, 23.0],
        settling=1000,
        state=([0.001], [0.0]),
    )
    # within 1000 cycles the displacement falls to 1e-139
    assert (run.labels[1:] == "0/1").all()
    assert run.largest.max() < 1e-40
