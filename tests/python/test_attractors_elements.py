"""Responses, bifurcation diagrams, exponents and basins of structures with elastic stops and friction."""

import numpy as np
import pytest
import vibroimpact as vi
from test_exact_elements import of_chance, one_stop

RUBBING = vi.Structure([1.0], [0.1], [1.0], friction=[vi.Friction([1.0], 0.3)])
COSINE = vi.Load(0.8, cosine=[1.0])
#: A mass with backlash on both sides: q -> -q half a load cycle later.
BACKLASH = vi.Structure(
    [1], [0.1], [0], [vi.Stop([side], 0.5, 50, damping=0.2) for side in (1, -1)]
)


def den_hartog(b, zeta, f):
    """The amplitude of x'' + 2 zeta x' + x + f sgn x' = cos(b t) without sticking, by Den Hartog."""
    w, half = np.sqrt(1 - zeta**2), np.pi / b
    both = np.cosh(zeta * half) + np.cos(w * half)
    g = (np.sinh(zeta * half) - zeta / w * np.sin(w * half)) / both
    h = np.sin(w * half) / (b * w * both)
    return -g * f + np.sqrt(1 / ((1 - b**2) ** 2 + (2 * zeta * b) ** 2) - (h * f) ** 2)


def logarithms(motion):
    """The Lyapunov exponents of a periodic motion per load cycle."""
    with np.errstate(divide="ignore"):
        return np.sort(np.log(np.abs(motion.multipliers)))[::-1] / motion.cycles


def test_response_with_friction_is_den_hartog():
    """The greatest displacement equals the closed form, with and without friction."""
    found = vi.response(RUBBING, COSINE, np.linspace(0.6, 1.6, 11))
    b = found.values
    assert found.largest[0].T == pytest.approx(np.tile(den_hartog(b, 0.05, 0.3), (2, 1)), rel=1e-12)
    assert found.steady_largest[0] == pytest.approx(1 / abs(1 - b**2 + 0.1j * b), rel=1e-9)
    assert set(found.labels.ravel()) == {"2/1"}


def test_sizes_are_those_of_a_sampled_period():
    """With gap, stop and friction: the greatest magnitude and mean square of each coordinate."""
    s, load = of_chance(7)
    w = load.frequency
    found = vi.response(s, load, [0.98 * w, w], settling=600)
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=900))
    assert len({*motion.gaps.tolist()}) > 1
    assert found.labels[1].tolist() == [f"{len(motion.gaps)}/{motion.cycles}"] * 2
    q, _ = motion.sample(motion.period * (np.arange(20_000) + 0.5) / 20_000)
    # the largest value of a coordinate may be at an impact
    largest = np.maximum(abs(q).max(axis=1), abs(motion.states[:, 0]).max(axis=0))
    for run in (0, 1):
        assert found.largest[:, 1, run] == pytest.approx(largest, rel=1e-6)
        assert found.rms[:, 1, run] == pytest.approx(np.sqrt((q**2).mean(axis=1)), rel=1e-6)


def test_jump_of_an_elastic_stop_is_at_the_fold():
    """In the sweep up contacts last to the fold, and in the sweep down they begin again far below it."""
    s = one_stop(1.0, stiffness=10, damping=0.05)
    found = vi.response(s, vi.Load(1.0, cosine=[0.3]), np.linspace(1.05, 1.5, 19))
    touched = {
        run: found.values[impacts > 0].max()
        for run, impacts in zip(found.runs, found.impacts.T, strict=True)
    }
    load = vi.Load(1.1, cosine=[0.3])
    motion = vi.exact(s, load, vi.simulate(s, load, cycles=200))
    branch = vi.branch(motion, "frequency", bounds=(1.0, 1.6))
    fold = max(point.value for point in branch.special_points if point.type == "fold")
    assert touched["up"] < fold < touched["up"] + 0.026
    assert touched["down"] < touched["up"] - 0.1


def test_diagram_follows_the_sequences_of_the_branch():
    """Reversals, halts up to the onset of sticking, and a mass that always sticks."""
    motion = vi.exact(RUBBING, COSINE, vi.simulate(RUBBING, COSINE, cycles=150))
    branch = vi.branch(motion, "slip", bounds=(0.0, 0.95))
    (begins,) = (p.value for p in branch.special_points if p.type == "stick_begins")
    values = np.array([0.1, 0.5, begins - 1e-3, begins + 1e-3, 0.9, 1.3])
    found = vi.bifurcation_diagram(RUBBING, COSINE, "slip", values)
    assert found.labels.tolist() == [["2/1"] * 3 + ["4/1"] * 2 + ["0/1"]] * 2
    for run, index in np.ndindex(found.labels.shape):
        states, hits = (
            table[(table["run"] == run) & (table["index"] == index)]
            for table in (found.strobes, found.points)
        )
        s = vi.Structure([1.0], [0.1], [1.0], friction=[vi.Friction([1.0], found.values[index])])
        alone = vi.simulate(s, COSINE, cycles=1, state=(states["q"][0], states["q_dot"][0]))
        for end, start in zip(alone.final_state, (states["q"][0], states["q_dot"][0]), strict=True):
            assert end == pytest.approx(start, abs=1e-9)
        last = hits[len(hits) - len(alone.events) :]
        assert last["kind"].tolist() == alone.events["kind"].tolist()
        phases = np.mod(0.8 * alone.events["time"], 2 * np.pi)
        assert last["phase"] == pytest.approx(phases, abs=1e-8)


def test_any_parameter_of_the_elements_may_change():
    """The speed of a belt is set by a function, and the stiffness of a stop by its name."""

    def on_belt(speed):
        belt = vi.Friction([1.0], 0.1, speed=speed)
        return vi.Structure([1.0], [0.1], [1.0], friction=[belt]), vi.Load(0.5, cosine=[0.3])

    found = vi.bifurcation_diagram(*on_belt(2.0), on_belt, [2.0, 3.0])
    assert set(found.labels.ravel()) == {"0/1"}  # the belt is always faster than the mass
    q = found.strobes["q"][0]
    s, load = on_belt(2.5)
    mean = vi.simulate(s, load, cycles=1, state=(q, found.strobes["q_dot"][0])).sample(
        np.linspace(0, 4 * np.pi, 1001)[:-1]
    )[0]
    assert mean.mean() == pytest.approx(0.1, abs=1e-4)
    softer = vi.bifurcation_diagram(
        one_stop(0.5, stiffness=20), vi.Load(1.3, cosine=[1.0]), "contact", [10, 20]
    )
    assert (softer.cycles > 0).all()


@pytest.mark.parametrize("seed", [0, 1, 7, 9, 20, 35])
def test_exponents_are_logarithms_of_the_multipliers(seed):
    """With stops, gaps and friction; sticking friction loses a direction. Volumes contract at the known rate."""
    s, load = of_chance(seed)
    run = vi.simulate(s, load, cycles=600, discard=500)
    motion = vi.exact(s, load, run)
    found = vi.lyapunov(s, load, cycles=1000, state=run.final_state, start=run.end)
    kept = np.isfinite(found.per_cycle)
    assert found.per_cycle[kept] == pytest.approx(logarithms(motion)[kept], abs=1e-6)
    assert found.per_cycle[kept].sum() == pytest.approx(logarithms(motion)[kept].sum(), abs=1e-9)
    assert (logarithms(motion)[~kept] < -30).all()
    if kept.all():
        assert motion.law > 0
        assert found.identity_error < 1e-12
    else:
        assert motion.law == 0
        assert np.isnan(found.identity_error)
    assert found.impacts == 1000 // motion.cycles * len(motion.gaps) or len(motion.rests)


@pytest.mark.slow
def test_chaos_on_a_spring():
    """Without a dashpot the sum of the exponents is that of the damping alone."""
    s = vi.Structure([1], [0.04], [1], [vi.Stop([1], 0.0, 100)])
    found = vi.lyapunov(s, vi.Load(2.4, cosine=[1.0]))
    assert found.per_cycle[0] > 8 * found.error_per_cycle[0] > 0
    assert found.per_cycle.sum() == pytest.approx(-0.04 * 2 * np.pi / 2.4, abs=1e-12)
    basins = vi.basins(s, vi.Load(2.4, cosine=[1.0]), states=2)
    assert [item.kind for item in basins.attractors] == ["chaotic"]


def test_exponents_of_stick_slip_and_of_rest():
    """On a belt without a load nothing grows along the motion. A mass that always sticks may be anywhere."""
    belt = vi.Friction([1], slip=0.6, stick=1.0, speed=0.2)
    bow = vi.Structure([1], [0], [1], friction=[belt])
    found = vi.lyapunov(bow)
    assert found.per_cycle[0] == pytest.approx(0, abs=1e-6)
    assert found.per_cycle[1] == -np.inf
    heavy = vi.Structure([1], [0.1], [1], friction=[vi.Friction([1], 1.2)])
    rest = vi.lyapunov(heavy, COSINE)
    assert rest.per_cycle.tolist() == pytest.approx([0, -np.inf], abs=1e-12)
    assert vi.basins(heavy, COSINE, states=8).attractors[0].kind == "permanent rest"


def test_exponents_beside_a_mass_that_sticks():
    """One mass sticks, another hits a wall: the exponents are those of the latter, 0, and a lost direction."""
    alone = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    wanted = vi.lyapunov(alone, vi.Load(1.0, cosine=[1])).per_cycle
    both = vi.Structure(
        [1, 1], [0.1, 0.1], [1, 1], [vi.Gap([1, 0], 1, 0.8)], [vi.Friction([0, 1], 2.0)]
    )
    load = vi.Load(1.0, cosine=[1, 1])
    found = vi.lyapunov(both, load, state=([0, 0.3], [0, 0]))
    assert found.per_cycle == pytest.approx([0, *wanted, -np.inf], abs=1e-5)
    assert found.per_cycle[:3].sum() == pytest.approx(wanted.sum(), abs=1e-9)
    basins = vi.basins(both, load, states=3, settling=100)
    assert (basins.labels == -1).all()  # each state lies on a different motion of a continuum
    with pytest.raises(vi.SingularError, match="friction sticks permanently wherever it stops"):
        vi.exact(both, load, vi.simulate(both, load, cycles=300))
    repeats = vi.response(both, load, [0.95, 1.0])
    assert repeats.labels.tolist() == [["1/1"] * 2] * 2


def mirrored(load):
    """Basins of a plane, and those half a load cycle later with both axes reversed."""
    plane = ("q_0", -0.45, 0.45, 7), ("q_dot_0", -1.0, 1.0, 7)
    here = vi.basins(BACKLASH, load, plane)
    there = vi.basins(BACKLASH, load, plane, start=np.pi / load.frequency)
    return here, there, there.labels[::-1, ::-1]


def test_basins_are_mirror_images():
    """The mirror image of a state half a load cycle later goes to the mirror image of its attractor."""
    here, there, labels = mirrored(vi.Load(1.6, cosine=[1.0]))
    assert [item.name for item in here.attractors] == ["12/3", "4/1"]
    assert [item.name for item in there.attractors] == ["12/3", "4/1"]
    assert (here.labels == labels).all()


def test_attractors_are_mirror_images():
    """Two motions without symmetry: one is -q(t + T/2) of the other."""
    load = vi.Load(1.3, cosine=[1.0])
    first, second = (item.motion for item in mirrored(load)[0].attractors[:2])
    assert first.stable
    assert logarithms(first) == pytest.approx(logarithms(second), abs=1e-9)
    late = np.mod(second.phases + np.pi, 2 * np.pi)
    order, other = np.argsort(np.mod(first.phases, 2 * np.pi)), np.argsort(late)
    assert np.mod(first.phases, 2 * np.pi)[order] == pytest.approx(late[other], abs=1e-9)
    assert (first.gaps[order] == 1 - second.gaps[other]).all()
    assert first.states[order] == pytest.approx(-second.states[other], abs=1e-9)


def test_each_state_settles_on_its_attractor():
    """Two motions with gap, stop and friction agree with a simulation and a separate Newton's method."""
    s, load = of_chance(28)
    found = vi.basins(s, load, states=12)
    assert len(found.attractors) == 2
    for i, label in enumerate(found.labels):
        run = vi.simulate(s, load, cycles=800, state=tuple(found.states[:, :, i]))
        motion, expected = vi.exact(s, load, run), found.attractors[label].motion
        assert motion.multipliers == pytest.approx(expected.multipliers, abs=1e-8)


def test_motions_without_speeds_are_told_apart_by_their_states():
    """Reversals of friction have no speed: equal motions are recognised, whichever event comes first."""
    for seed in (2, 23):
        s, load = of_chance(seed)
        assert len(vi.basins(s, load, states=8).attractors) == 1
        found = vi.find(s, load, states=8)
        assert found.settled == (8,)
        vi.exact(s, load, found.motions[0])
        assert "'settled'" in found.motions[0].to_namelist()


def test_any_number_of_threads_gives_the_same_bits():
    s, load = of_chance(28)
    one, three = (vi.basins(s, load, states=12, threads=n) for n in (1, 3))
    assert one.labels.tobytes() == three.labels.tobytes()
    for first, second in zip(one.attractors, three.attractors, strict=True):
        assert first.motion.states.tobytes() == second.motion.states.tobytes()
    values = load.frequency * np.linspace(0.9, 1.1, 5)
    one, three = (vi.response(s, load, values, settling=50, threads=n) for n in (1, 3))
    assert one.largest.tobytes() == three.largest.tobytes()
    assert one.steady_rms.tobytes() == three.steady_rms.tobytes()


@pytest.mark.parametrize("study", ["response", "bifurcation", "lyapunov", "basins"])
def test_namelists(tmp_path, study):
    """The case of each study reproduces it, and files keep it."""
    s, load = of_chance(7)
    w = load.frequency
    found = {
        "response": lambda: vi.response(s, load, [w, 1.1 * w], settling=20),
        "bifurcation": lambda: vi.bifurcation_diagram(s, load, "slip", [0.1, 0.2], settling=20),
        "lyapunov": lambda: vi.lyapunov(s, load, cycles=100, discard=20),
        "basins": lambda: vi.basins(s, load, states=3, settling=200),
    }[study]()
    case = tmp_path / "case.nml"
    case.write_text(found.to_namelist())
    vi.run_namelists([case], tmp_path)
    found.save(tmp_path / "found.csv")
    one, two = (
        [line for line in (tmp_path / name).read_text().splitlines() if not line.startswith("#")]
        for name in ("case.csv", "found.csv")
    )
    assert len(one) > 1
    assert one == two
    found.save(tmp_path / "found.json")
    assert vi.load(tmp_path / "found.json").case == found.case


@pytest.mark.parametrize(("name", "values"), [
    ("r", [1.02, 1.04]), ("clearance", [24.0, 25.0]), ("xi", [0.0114, 0.012]), ("R1", [0.74, 0.75]),
])  # fmt: skip
def test_points_keep_their_friction(name, values):
    """Friction in the slot of an oscillator is kept when any parameter changes."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    found = vi.bifurcation_diagram(
        osc.at(1.04, 25, friction=0.05), name, values, sweep="up", settling=400
    )
    at = {"r": 1.04, "clearance": 25.0} | {
        key: value for key, value in ((name, values[1]),) if key in ("r", "clearance")
    }
    changed = {"xi": {"xi": values[1]}, "R1": {"restitution": (values[1], 0.75)}}.get(name, {})
    changed = {"xi": 0.0114, "mu": 0.028, "restitution": 0.75} | changed
    point = vi.Oscillator(**changed).at(**at, friction=0.05)
    motion = vi.exact(point, vi.simulate(point, cycles=600))
    last = found.points[found.points["index"] == 1][-len(motion.gaps) :]
    assert set(last["kind"]) == {"impact", "slip_up", "slip_down"}
    assert np.sort(last["speed"]) == pytest.approx(np.sort(motion.speeds), rel=1e-6)


@pytest.mark.parametrize(("name", "kept", "low"), [
    ("slip", {"friction": 0.05}, 0.04), ("contact", {"stops": ((200.0, 0.5), (200.0, 0.5))}, 150.0),
])  # fmt: skip
def test_diagram_along_parameters_of_elements(name, kept, low):
    """A point with elements takes the parameter names of its structure, and gives the answer of the structure."""
    point = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(1.04, 25, **kept)
    high = 0.05 if name == "slip" else 200.0
    ours = vi.bifurcation_diagram(point, name, [low, high], settling=100)
    theirs = vi.bifurcation_diagram(point.structure, point.load, name, [low, high], settling=100)
    assert (ours.points == theirs.points).all()
    assert len(ours.points)
    with pytest.raises(vi.ParameterError, match="the structure has no such parameter"):
        vi.bifurcation_diagram(point, "nothing", [low, high])


def test_walls_that_give_have_no_restitution():
    point = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75).at(
        1.04, 25, stops=((10.0, 0.0), (10.0, 0.0))
    )
    with pytest.raises(
        vi.ParameterError, match="parameter = 'R1': must not be a parameter of compliant walls"
    ):
        vi.bifurcation_diagram(point, "R1", [0.7, 0.8])
    found = vi.response(point, r=[1.02, 1.04], settling=50, sweep="up")
    assert (found.impacts > 0).all()
