"""Exact motions of structures with elastic stops and friction, compared with closed forms and known numbers."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import one_stop, with_elements

TURN = 2 * math.pi


def settled(structure, load, cycles=150):
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=cycles))


@pytest.mark.parametrize(("k", "c", "phase", "duration", "multiplier"), [
    (100, 0, 6.22700821679763, .312511699213252, -.6922454190347 + .2329900661328j),
    (100, 1, 6.23899363049323, .312955115403664, -.5916663376937 + .2001538789779j),
    (1e8, None, .0758360073610025, 3.14950821512081e-4, -.5842934483009 + .0057887487234j),
])  # fmt: skip
def test_one_stop(k, c, phase, duration, multiplier):
    """Times and multipliers; a dashpot adds a factor exp(-c t) of the contact to the determinant."""
    if c is None:
        c = 2 * -math.log(0.8) / math.hypot(math.pi, math.log(0.8)) * math.sqrt(k)
    motion = settled(one_stop(1.0, stiffness=k, damping=c), vi.Load(1.0, cosine=[1.0]))
    assert motion.admissible
    assert motion.stable
    touch = int(np.argmax(motion.speeds))
    assert motion.phases.min() % TURN >= 0
    assert np.abs(np.exp(1j * motion.phases) - np.exp(1j * phase)).min() < 1e-11, touch
    assert motion.multipliers[0] == pytest.approx(multiplier, abs=1e-10 if k < 1e8 else 1e-8)
    law = math.exp(-0.1 * TURN - c * duration)
    assert motion.law == pytest.approx(law, rel=1e-11)
    assert motion.determinant == pytest.approx(law, rel=1e-9)


@pytest.mark.parametrize(("stop", "modulus"), [
    ({"damping": 2}, .3843810217164), ({"damping": 2, "release": "force"}, .4253978111505),
    ({"preload": .3}, .7853223776373),
])  # fmt: skip
def test_release_rules(stop, modulus):
    motion = settled(one_stop(0.5, stiffness=20, **stop), vi.Load(1.3, cosine=[1.0]))
    assert np.abs(motion.multipliers) == pytest.approx([modulus] * 2, rel=1e-10)
    assert motion.determinant == pytest.approx(motion.law, rel=1e-11)


@pytest.mark.parametrize(("b", "f", "modulus"), [(0.8, 0.3, 0.69707788), (0.6, 0.25, 0.37949352)])
def test_den_hartog(b, f, modulus):
    """Amplitude and load phase of Den Hartog's closed form without damping."""
    s = vi.Structure([1.0], [0.0], [1.0], friction=[vi.Friction([1.0], f)])
    motion = settled(s, vi.Load(b, cosine=[1.0]))
    amplified = 1 / (1 - b**2)
    phase = np.arcsin(f * abs(np.tan(np.pi / 2 / b)) / (amplified * b))
    x = amplified * np.cos(phase)
    assert np.abs(motion.states[:, 0, 0]) == pytest.approx([x, x], rel=1e-13)
    top = int(np.argmax(motion.states[:, 0, 0]))
    assert motion.phases[top] % TURN == pytest.approx(phase, abs=1e-12)
    assert np.abs(motion.multipliers) == pytest.approx([modulus] * 2, rel=3e-8)
    assert motion.determinant == pytest.approx(motion.law, rel=1e-12)
    assert motion.stable


def test_with_stick():
    """Sticking friction makes one multiplier 0."""
    s = vi.Structure([1.0], [0.02], [1.0], friction=[vi.Friction([1.0], 0.6)])
    motion = settled(s, vi.Load(0.4, cosine=[1.0]), 60)
    expected = [1.14911242025, 3.12341231585, 4.29070507384, 3.12341231585 + math.pi]
    assert np.sort(motion.phases % TURN) == pytest.approx(expected, abs=2e-11)
    assert abs(motion.multipliers[1]) < 1e-12
    assert motion.law == 0
    assert motion.stable


@pytest.mark.parametrize(("xi", "mu", "r", "d", "f", "moduli"), [
    (.0114, .028, 1.04, 25, .01, (.9231743626846, .5687579284743)),
    (.0114, .028, 1.04, 25, .05, (.9226700793623, .5690687818813)),
    (.005, .042, .94, 37, .01, (.9350403254704, .5389817208603)),
])  # fmt: skip
def test_damper(xi, mu, r, d, f, moduli):
    """The damper of 1983 with friction in its slot."""
    gaps = [vi.Gap([-1, 1], d / 2, 0.75), vi.Gap([1, -1], d / 2, 0.75)]
    s = vi.Structure([1, mu], [2 * xi, 0], [1, 0], gaps, [vi.Friction([-1, 1], f)])
    motion = settled(s, vi.Load(r, sine=[1.0, 0.0]), 400)
    assert motion.admissible
    assert np.sort(np.abs(motion.multipliers)) == pytest.approx(
        [moduli[1]] * 2 + [moduli[0]] * 2, rel=1e-10
    )
    assert motion.determinant == pytest.approx(motion.law, rel=1e-11)
    again = vi.exact(s, vi.Load(r, sine=[1.001, 0.0]), motion)
    assert again.speeds == pytest.approx(motion.speeds, rel=0.05)


@pytest.mark.parametrize("b", [0.5, 1 / 4])
def test_a_continuum_is_only_marginally_stable(b):
    """Without damping, at b = 1/(2n), one multiplier is 1, or the motion sticks."""
    s = vi.Structure([1.0], [0.0], [1.0], friction=[vi.Friction([1.0], 0.1)])
    motion = settled(s, vi.Load(b, cosine=[1.0]), 400)
    if abs(motion.multipliers[0] - 1) < 1e-6:
        assert motion.stable is None
    else:
        assert abs(motion.multipliers[1]) < 1e-12


def wall_of(direction, opening, restitution, mass, stiffness):
    """A rigid wall, or a wall with a spring and a dashpot with the same loss."""
    if stiffness is None:
        return vi.Gap(direction, opening, restitution)
    effective = 1 / (direction @ np.linalg.solve(mass, direction))
    loss = -math.log(restitution)
    damping = 2 * loss / math.hypot(math.pi, loss) * math.sqrt(stiffness * effective)
    return vi.Stop(direction, opening, stiffness, damping)


def damper(k):
    """The pair of 1983 with elastic walls."""
    mass = np.diag([1.0, 0.028])
    walls = [wall_of(np.array(g), 12.5, 0.75, mass, k) for g in ([-1.0, 1.0], [1.0, -1.0])]
    return vi.Structure(mass, [0.0228, 0], [1, 0], walls), vi.Load(1.04, sine=[1, 0])


def chain(k):
    """Four masses, the last of which hits a wall."""
    K = 2 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    wall = wall_of(np.array([0, 0, 0, 1.0]), 0.6, 0.7, np.eye(4), k)
    return vi.Structure(np.eye(4), 0.05 * K + 0.02 * np.eye(4), K, [wall]), vi.Load(
        0.6, cosine=[1, 0, 0, 0]
    )


def beam(k):
    """A cantilever of four modes whose tip hits a wall five times per cycle."""
    w = (np.array([1.8751, 4.6941, 7.8548, 10.9955]) / 1.8751) ** 2
    tip = np.array([2.0, -2, 2, -2])
    wall = wall_of(tip, 0.8, 0.6, np.eye(4), k)
    return vi.Structure(np.eye(4), np.diag(0.04 * w), np.diag(w**2), [wall]), vi.Load(
        0.9, cosine=0.1 * tip
    )


@pytest.mark.parametrize("system", [damper, chain, beam])
def test_stiff_stops_tend_to_rigid_walls(system):
    """Multipliers and times of touch converge to those of rigid walls as k^(-1/2), up to a ratio of 1e8."""
    rigid = settled(*system(None), 400)
    distances = []
    for k in (1e6, 1e7, 1e8):
        stiff = settled(*system(k), 400)
        assert stiff.admissible
        assert stiff.stable == rigid.stable
        assert len(stiff.gaps) == 2 * len(rigid.gaps)
        assert stiff.determinant == pytest.approx(stiff.law, rel=1e-8)
        # a stop is touched at the time of the impact, and left half a period of the contact later
        touch, wall = (np.sort(m.phases % (TURN * m.cycles)) for m in (stiff, rigid))
        distances.append([
            np.abs(np.sort(np.abs(stiff.multipliers)) - np.sort(np.abs(rigid.multipliers))).max(),
            np.abs(touch.reshape(-1, 2).mean(axis=1) - wall).max(),
        ])  # fmt: skip
    slopes = np.diff(np.log10(distances), axis=0)
    # the next term, of the order 1/k, is a tenth as large from 1e7 to 1e8
    assert slopes[0] == pytest.approx([-0.5, -0.5], abs=0.06)
    assert slopes[1] == pytest.approx([-0.5, -0.5], abs=0.02)


def test_grazing_has_no_verdict():
    """At an impact without speed, combined with friction, the period has no derivative."""
    s, load = of_chance(1)
    w = load.frequency
    branch = vi.branch(settled(s, load, 600), "frequency", bounds=(0.8 * w, 1.2 * w))
    points = [p.index for p in branch.special_points if p.type == "zero_approach"]
    assert points
    assert np.isnan(branch.multipliers[:, points]).all()
    assert (branch.stable[points] == -1).all()


def test_friction_in_the_slot_of_an_oscillator():
    """A point with friction equals the equivalent structure; it finds the motions on which simulations settle."""
    point = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(1.04, 25, friction=0.05)
    gaps = [vi.Gap([-1, 1], 12.5, 0.75), vi.Gap([1, -1], 12.5, 0.75)]
    s = vi.Structure([1, 0.028], [0.0228, 0], [1, 0], gaps, [vi.Friction([-1, 1], 0.05)])
    assert point.structure == s
    assert "friction 0.05" in repr(point)
    motion = vi.exact(point, vi.simulate(point, cycles=400))
    assert np.sort(np.abs(motion.multipliers)) == pytest.approx(
        [0.5690687818813] * 2 + [0.9226700793623] * 2, rel=1e-10
    )
    found = vi.find(point, states=6)
    assert found.settled == (6,)
    assert found.motions[0].multipliers == pytest.approx(motion.multipliers, abs=1e-9)
    moduli = np.sort(np.log(np.abs(motion.multipliers)))[::-1]
    assert vi.lyapunov(point).per_cycle == pytest.approx(moduli, abs=1e-9)


def test_walls_of_an_oscillator_that_give():
    """Stiff walls whose dashpots have the losses of R give the motion of the rigid walls."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    m, k, R = 0.028 / 1.028, 1e7, 0.75
    c = 2 * -math.log(R) / math.hypot(math.pi, math.log(R)) * math.sqrt(k * m)
    point = osc.at(1.04, 25, stops=((k, c), (k, c)))
    assert [type(part) for part in point.structure.gaps] == [vi.Stop, vi.Stop]
    motion = vi.exact(point, vi.simulate(point, cycles=400))
    rigid = vi.equispaced(osc, 1.04, 25)[0]
    assert np.sort(np.abs(motion.multipliers)) == pytest.approx(
        np.sort(np.abs(rigid.multipliers)), rel=2e-3
    )
    for stops in ((1.0, 2.0), ((1.0, 0.0),), ((-1.0, 0.0), (1.0, 0.0)), (((1.0, 2.0, 3.0), None))):
        with pytest.raises(vi.ParameterError, match=r"stops|stiffness"):
            osc.at(1.04, 25, stops=stops)


def test_one_wall_of_an_oscillator_gives():
    """A rigid wall and a compliant one whose numbers have units equal the structure of the rig."""
    rig = vi.Oscillator.from_dimensional(
        M="2.7 kg", K="42 kN/m", xi="1.1 %", m="0.11 kg", restitution=(0.75, 0.61), F0="6 N"
    )
    point = rig.at("19.5 Hz", "4 mm", stops=(None, ("840 kN/m", "20 N s/m")))
    steel, tape = point.structure.gaps
    assert isinstance(steel, vi.Gap)
    assert steel.restitution == 0.75
    assert isinstance(tape, vi.Stop)
    assert tape.stiffness == pytest.approx(840e3 / 42e3, rel=1e-14)
    assert tape.damping == pytest.approx(20 / math.sqrt(42e3 * 2.7), rel=1e-14)
    assert rig.at(1, 28, stops=(None, None)) == rig.at(1, 28)
    for stops, name in (
        ((("1 N", 0.1), None), "stiffness of the right wall = 1 N: must be a stiffness"),
        ((None, (1, "3 kg")), "damping of the left wall = 3 kg: must be a damping coefficient"),
    ):
        with pytest.raises(vi.ParameterError, match=name):
            rig.at(1, 28, stops=stops)
    with pytest.raises(vi.ParameterError, match="M = None"):
        vi.Oscillator(xi=0.01, mu=0.1, restitution=0.5).at(1, 20, stops=(("3 N/m", 1), None))


def test_find_settles_on_several_motions():
    """Two motions of a mass on a stop, each found from several states, equal those of simulations."""
    s, load = one_stop(1.0, stiffness=100, damping=1), vi.Load(1.5, cosine=[1.0])
    found = vi.find(s, load, states=16)
    assert sum(found.settled) == 16 - found.unsettled - found.without_impacts
    for motion in found.motions:
        assert motion.stable
        again = vi.exact(s, load, motion)
        assert again.speeds == pytest.approx(motion.speeds, rel=1e-9)


def test_saved_and_loaded(tmp_path):
    s = one_stop(0.5, stiffness=4)
    motion = settled(s, vi.Load(0.7, cosine=[1.0]))
    motion.save(tmp_path / "motion.json")
    loaded = vi.load(tmp_path / "motion.json")
    assert loaded.structure == s
    for name in ("gaps", "phases", "speeds", "impulses", "states", "multipliers"):
        assert np.array_equal(getattr(loaded, name), getattr(motion, name))


def test_namelist_of_a_motion(tmp_path):
    """The case of a motion reproduces it; other kinds of &motion need the kinds of the events."""
    s = one_stop(0.5, stiffness=4)
    motion = settled(s, vi.Load(0.7, cosine=[1.0]))
    case = tmp_path / "motion.nml"
    case.write_text(motion.to_namelist())
    vi.run_namelists([case], tmp_path)
    lines = (tmp_path / "motion.csv").read_text().splitlines()
    rows = [line for line in lines if not line.startswith("#")]
    table = np.genfromtxt(rows, delimiter=",", names=True)
    assert table["gap"].tolist() == motion.gaps.tolist()
    for name in ("phase", "speed", "impulse"):
        assert table[name] == pytest.approx(getattr(motion, f"{name}s"), abs=1e-12)
    case.write_text(case.read_text().split("&motion")[0] + "&motion gaps = 0, phases = 0.3 /\n")
    with pytest.raises(vi.ParameterError, match="it is required with a &stop or a &friction"):
        vi.read_namelist(case)


def test_guess_by_numbers_is_refused():
    wanted = (
        r"guess = .*: must be a Trajectory, as from simulate, or a Motion with stops or friction"
    )
    with pytest.raises(vi.ParameterError, match=wanted):
        vi.exact(one_stop(0.5, stiffness=4), vi.Load(0.7, cosine=[1.0]), ([0.3], [0]))
    # a motion between rigid walls has the impacts alone
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    with pytest.raises(vi.ParameterError, match=wanted):
        vi.exact(osc.at(1.04, 25, friction=0.01), vi.equispaced(osc, 1.04, 25)[0])


def of_chance(seed):
    """A chain of 1 to 3 masses with gaps, stops and friction, and its load."""
    rng = np.random.default_rng(seed)
    n = rng.integers(1, 4)
    springs = rng.uniform(0.3, 2, n + 1)
    stiffness = (
        np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    )

    def direction():
        row = np.zeros(n)
        places = rng.permutation(n)
        row[places[0]] = rng.choice([-1, 1])
        if n > 1 and rng.random() < 0.4:
            row[places[1]] = -row[places[0]]
        return row

    gaps = [
        vi.Stop(direction(), rng.uniform(0.1, 1), rng.uniform(1, 100), rng.uniform(0, 1))
        if rng.random() < 0.5
        else vi.Gap(direction(), rng.uniform(0.1, 1), rng.uniform(0.3, 0.9))
        for _ in range(rng.integers(1, 4))
    ]
    slip = rng.uniform(0.02, 0.3)
    friction = [vi.Friction(direction(), slip, stick=slip * rng.uniform(1, 1.3))]
    masses, load = rng.uniform(0.3, 2, n), rng.uniform(-1.5, 1.5, n)
    s = vi.Structure(masses, 0.1 * stiffness, stiffness, gaps, friction)
    return s, vi.Load(rng.uniform(0.5, 2), cosine=load)


def test_multipliers_are_those_of_differences():
    """Traces of [P] and of its square equal those of differences of simulations over a period."""
    judged = 0
    for seed in range(16):
        s, load = of_chance(seed)
        run = vi.simulate(s, load, cycles=600, discard=500)
        try:
            motion = vi.exact(s, load, run)
        except (vi.ParameterError, vi.SingularError):
            continue  # it has no impacts, rests permanently or is not periodic
        state = np.concatenate(run.final_state)
        duration = motion.cycles * TURN / load.frequency

        def after(state, s=s, load=load, run=run, duration=duration):
            parts = np.split(state, 2)
            end = vi.simulate(s, load, duration=duration, start=run.end, state=parts).final_state
            return np.concatenate(end)

        assert after(state) == pytest.approx(state, abs=1e-6)
        steps = 1e-6 * np.eye(len(state))
        columns = [(after(state + step) - after(state - step)) / 2e-6 for step in steps]
        P = np.transpose(columns)
        found = [np.sum(motion.multipliers**k).real for k in (1, 2)]
        assert found == pytest.approx([np.trace(P), np.trace(P @ P)], abs=1e-6)
        assert motion.determinant == pytest.approx(motion.law, abs=1e-9)
        judged += 1
    assert judged >= 8


@pytest.mark.parametrize("name", with_elements())
def test_kinds_of_events(name):
    """Each event of a motion is an event of a simulation from its start, with the same phase and gap."""
    s, load = with_elements()[name]
    motion = settled(s, load, 400)
    assert len(motion.kinds) == len(motion.phases)
    run = vi.simulate(
        s,
        load,
        duration=1.001 * motion.period,
        state=(motion.q, motion.q_dot),
        start=float(motion.phases[0] / load.frequency),
    )
    for kind, gap, phase in zip(motion.kinds, motion.gaps, motion.phases, strict=True):
        at = np.exp(1j * (run.events["time"] * load.frequency - phase) / motion.cycles)
        near = run.events[np.abs(at - 1) < 1e-6]
        assert (kind, gap) in [tuple(e) for e in near[["kind", "gap"]].tolist()]
    given = vi.periodic(s, load, motion.phases, motion.gaps, motion.cycles, kinds=motion.kinds)
    assert given.kinds == motion.kinds
    assert given.speeds == pytest.approx(motion.speeds, abs=1e-8)


def test_a_stop_lets_go_at_an_impact():
    """An impact makes a dashpot pull, so that its stop releases at once: [P] equals that of differences."""
    stop = vi.Stop([1.0], 0.25, stiffness=50.0, damping=1.9, release="force")
    s = vi.Structure([1.0], [0.1], [1.0], [stop, vi.Gap([1.0], 0.32, 0.7)])
    load = vi.Load(0.9, cosine=[1.5])
    motion = settled(s, load, 400)
    run = motion._from_flight()
    hit = int(np.flatnonzero(run.events["kind"] == "impact")[0])
    assert run.events["kind"][hit + 1] == "let_go"
    assert run.events["time"][hit + 1] == run.events["time"][hit]
    state = np.concatenate(run.initial_state)

    def after(state):
        parts = np.split(state, 2)
        end = vi.simulate(s, load, duration=motion.period, start=run.start, state=parts).final_state
        return np.concatenate(end)

    P = np.transpose([(after(state + e) - after(state - e)) / 2e-6 for e in 1e-6 * np.eye(2)])
    found = [np.sum(motion.multipliers**k).real for k in (1, 2)]
    assert found == pytest.approx([np.trace(P), np.trace(P @ P)], abs=1e-7)
    assert motion.determinant == pytest.approx(motion.law, rel=1e-10)
