"""Derivatives of trajectories of structures, compared with those of the oscillator, laws, and differences."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import RIG
from test_structure_motion import damper, random_structure
from test_trajectory_gradient import FLYING, RESTING, simulated

#: Parameters of the structure for those of the oscillator, with the derivative of one by the other.
NAMES = {
    "t": ("start", 1), "x": ("q_0", 1), "x_dot": ("q_dot_0", 1), "z": ("q_1", 1), "z_dot": ("q_dot_1", 1),
    "r": ("frequency", 1), "clearance": ("opening", 2), "xi": ("damping_0_0", 0.5), "mu": ("mass_1_1", 1),
    "R1": ("restitution_0", 1), "R2": ("restitution_1", 1), "load": ("load", 1),
}  # fmt: skip
WEIGHTS = {-2: 1, -1: -8, 1: 8, 2: -1}


def as_structure(values, cycles):
    """The trajectory of the oscillator as a trajectory of a structure."""
    structure = damper(
        values["xi"], values["mu"], restitution=values["R1"], clearance=values["clearance"]
    )
    gaps = [
        vi.Gap(gap.direction, gap.opening, values[f"R{j + 1}"])
        for j, gap in enumerate(structure.gaps)
    ]
    structure = vi.Structure(structure.mass, structure.damping, structure.stiffness, gaps)
    load = vi.Load(values["r"], sine=[values["load"], 0])
    start = ([values["x"], values["z"]], [values["x_dot"], values["z_dot"]])
    return vi.simulate(structure, load, cycles=cycles, state=start, start=values["t"])


@pytest.mark.parametrize(("values", "close"), [(FLYING, 1e-10), (RESTING, 2e-8)])
def test_agrees_with_the_oscillator(values, close):
    """Two methods without a common formula agree, through impacts, accumulations and rests."""
    ours, theirs = as_structure(values, 3), simulated(values, 3)
    mine = ours.gradient([name for name, _ in NAMES.values()])
    other = theirs.gradient()
    # the last of some dozen accumulating impacts may differ
    hits = np.flatnonzero((ours.events["kind"] == "impact") & (ours.events["speed"] > 1e-4))
    same = np.flatnonzero(
        (theirs.events["kind"] == "impact")
        & (np.abs(theirs.events["z_dot_before"] - theirs.events["x_dot_before"]) > 1e-4)
    )
    assert len(hits) == len(same) >= 9
    for name, (own, factor) in NAMES.items():
        factor = values["load"] if name == "load" else factor
        for found, wanted in [
            (mine["final_q", own][0], other["final_x", name]),
            (mine["final_q", own][1], other["final_z", name]),
            (mine["final_q_dot", own][0], other["final_x_dot", name]),
            (mine["final_q_dot", own][1], other["final_z_dot", name]),
            (mine["final_time", own], other["final_t", name]),
            (mine["time", own][hits], other["time", name][same]),
            (mine["q", own][hits][:, 0], other["x", name][same]),
            (mine["q_dot", own][hits][:, 1], other["z_dot_after", name][same]),
        ]:  # fmt: skip
            size = close * max(1.0, np.abs(wanted).max())
            assert found == pytest.approx(factor * wanted, abs=size), (
                name,
                found - factor * wanted,
            )


@pytest.mark.parametrize("seed", range(4))
def test_agrees_with_differences(seed):
    """Fourth-order differences of simulations of random structures."""
    structure, load = random_structure(np.random.default_rng(seed))
    n = structure.coordinates
    start = (np.zeros(n), np.random.default_rng(seed).normal(size=n))

    def at(p, name):
        stiffness, frequency = structure.stiffness.copy(), load.frequency
        if name == "stiffness_0_0":
            stiffness[0, 0] += p
        if name == "frequency":
            frequency += p
        rate = start[1] + p * (np.arange(n) == 0) * (name == "q_dot_0")
        changed = vi.Structure(structure.mass, structure.damping, stiffness, structure.gaps)
        other = vi.Load(frequency, sine=load.sine, cosine=load.cosine)
        return vi.simulate(changed, other, cycles=3, state=(start[0], rate), start=0.7)

    run = at(0.0, "")
    assert (run.events["kind"] == "impact").any()
    names = ["stiffness_0_0", "frequency", "q_dot_0"]
    gradient = run.gradient(names)
    h = 1e-5
    for name in names:
        near = {step: at(step * h, name) for step in WEIGHTS}
        for quantity, value in {
            "time": lambda one: one.events["time"], "speed": lambda one: one.events["speed"],
            "q_dot": lambda one: one.states[:, 1], "final_q": lambda one: one.final_state[0],
            "final_q_dot": lambda one: one.final_state[1], "final_time": lambda one: np.array(one.end),
        }.items():  # fmt: skip
            slope = sum(weight * value(near[step]) for step, weight in WEIGHTS.items()) / (12 * h)
            size = 1e-7 * max(1.0, np.abs(slope).max())
            assert gradient[quantity, name] == pytest.approx(slope, abs=size), (name, quantity)


def test_a_record():
    """Samples of a force: derivatives by its factor, the stiffness and the start equal differences."""
    times = 0.05 * np.arange(400)
    force = np.column_stack([0 * times, np.sin(0.9 * times) + 0.3 * np.sin(2.3 * times)])[:, ::-1]
    structure = damper(clearance=2.0, xi=0.02, mu=0.1)

    def at(p, name):
        stiffness = structure.stiffness + (p if name == "stiffness_0_0" else 0.0) * np.diag([1, 0])
        changed = vi.Structure(structure.mass, structure.damping, stiffness, structure.gaps)
        record = vi.Record(0.05, force * (1 + (p if name == "load" else 0.0)))
        start = 0.33 + (p if name == "start" else 0.0)
        rate = [0.1, 1.0 + (p if name == "q_dot_1" else 0.0)]
        return vi.simulate(changed, record, duration=25.0, state=([0, 0], rate), start=start)

    run = at(0.0, "")
    assert (run.events["kind"] == "impact").sum() > 5
    names = ["load", "stiffness_0_0", "start", "q_dot_1"]
    gradient = run.gradient(names)
    h = 1e-5
    for name in names:
        near = {step: at(step * h, name) for step in WEIGHTS}
        for quantity, value in {
            "time": lambda one: one.events["time"], "final_q": lambda one: one.final_state[0],
            "final_q_dot": lambda one: one.final_state[1],
        }.items():  # fmt: skip
            slope = sum(weight * value(near[step]) for step, weight in WEIGHTS.items()) / (12 * h)
            # the force has corners
            size = 1e-6 * max(1.0, np.abs(slope).max())
            assert gradient[quantity, name] == pytest.approx(slope, abs=size), (name, quantity)


def test_a_period_has_the_multipliers():
    """Over a period from the middle of a flight, also with rest, the derivative is that of the motion."""
    run = as_structure(
        {**RESTING, "r": 0.9, "clearance": 6.0, "mu": 0.028, "xi": 0.0114, "R1": 0.75, "R2": 0.61},
        200,
    )
    motion = vi.exact(run.structure, run.load, run)
    assert len(motion.rests)
    times = motion.phases / motion.load.frequency
    gaps = np.diff(times, append=times[0] + motion.period)
    at = times[gaps.argmax()] + 0.5 * gaps.max()
    state = [part[:, 0] for part in motion.sample([at])]
    gradient = vi.simulate(
        run.structure, run.load, cycles=motion.cycles, state=state, start=at
    ).gradient()
    start = [f"{word}_{i}" for word in ("q", "q_dot") for i in range(2)]
    matrix = np.vstack([
        np.column_stack([gradient[quantity, name] for name in start])
        for quantity in ("final_q", "final_q_dot")
    ])  # fmt: skip
    found = np.sort(np.abs(np.linalg.eigvals(matrix)))
    assert found == pytest.approx(np.sort(np.abs(motion.multipliers)), abs=1e-6)


def test_a_motion_with_rest():
    """Derivatives equal those of the oscillator, and multipliers those of differences."""
    own = vi.exact(RIG, 0.9, 6.0, vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200))
    theirs = own.gradient()

    def at(**changes):
        values = {
            **RESTING,
            "r": 0.9,
            "clearance": 6.0,
            "mu": 0.028,
            "xi": 0.0114,
            "R1": 0.75,
            "R2": 0.61,
        }
        values |= {name: values[name] + step for name, step in changes.items()}
        run = as_structure(values, 300)
        return vi.exact(run.structure, run.load, run)

    motion = at()
    assert len(motion.rests)
    assert motion.multipliers[0] == pytest.approx(own.multipliers[0], rel=1e-6)
    used = {name: NAMES[name] for name in ("r", "clearance", "xi", "mu", "R1", "R2", "load")}
    gradient = motion.gradient([name for name, _ in used.values()])
    first = [np.abs(np.abs(motion.states[:, 0, 0] - x)).argmin() for x in own.X[:1]]
    for name, (mine, factor) in used.items():
        assert gradient["q", mine][first, 0] == pytest.approx(
            factor * theirs["X", name][:1], rel=1e-6, abs=1e-6
        )
    h = 1e-5
    for name in ("r", "clearance", "mu", "R1", "R2"):
        mine, factor = used[name]
        ends = [at(**{name: step}).multipliers[0] for step in (h, -h)]
        assert factor * (ends[0] - ends[1]) / (2 * h) == pytest.approx(
            gradient["multipliers", mine][0], rel=1e-4, abs=1e-4
        ), name


@pytest.mark.parametrize("duration", [0.3, 6.0])
def test_a_start_at_rest(duration):
    """A gap that rests at the start joins the masses until it opens; changes that would open it have no slope."""
    gaps = [vi.Gap([1, -1], 0, 0.5), vi.Gap([1, 0], 3, 0.5)]
    structure = vi.Structure([1, 0.5], [0.1, 0.05], [1, 0.3], gaps)
    state = ([0.2, 0.2], [0.3, 0.3])

    def run(start=0.0, frequency=0.0, load=0.0):
        pushed = vi.Load(1 + frequency, sine=[2 + 2 * load, 0], constant=[0.5, -0.5])
        return vi.simulate(structure, pushed, duration=duration, start=0.1 + start, state=state)

    trajectory = run()
    assert set(trajectory.events["kind"]) <= {"release"}
    assert len(trajectory.events) == (duration > 1)
    # while it rests both masses have one acceleration, by Newton's law for their sum
    t = np.linspace(0.1, 0.4, 5)
    (q, _), (v, _) = trajectory.sample(t)
    found = trajectory.acceleration(t)
    assert found[0] == pytest.approx(found[1], rel=1e-12)
    assert 1.5 * found[0] == pytest.approx(2 * np.sin(t) - 1.3 * q - 0.15 * v, rel=1e-12)
    names = ["start", "frequency", "load", "q_0", "q_dot_1", "opening_0", "opening_1"]
    gradient = trajectory.gradient(names)
    h = 1e-5
    for name in names[:3]:
        ends = [run(**{name: step}).final_state for step in (h, -h)]
        for i, quantity in enumerate(("final_q", "final_q_dot")):
            slope = (ends[0][i] - ends[1][i]) / (2 * h)
            assert gradient[quantity, name] == pytest.approx(slope, rel=1e-6, abs=1e-8), name
    assert np.isnan(gradient["final_q"]).any(axis=0).tolist() == [
        name in names[3:6] for name in gradient.parameters
    ]
    (reason,) = gradient.status.items()
    assert reason[0] == "q_0, q_dot_1, opening_0"
    assert "rests at the start" in reason[1]


def test_a_graze():
    """Values are NaN, by name, after an impact with an approach speed of 0 relative to the largest velocity."""
    wall = vi.Structure([1, 1], [0, 0], [0, 0], [vi.Gap([1, 0], 1, 0.7)])
    push = vi.Load(constant=[-0.5, 0])
    slow, fast = (
        vi.simulate(wall, push, duration=5, state=([0, 0], [1 + 1e-15, other]))
        for other in (0, 1000)
    )
    assert 0 < slow.events["speed"][0] < 1e-7
    assert np.isfinite(slow.gradient()["final_q"]).all()
    gradient = fast.gradient()
    assert "no approach speed" in gradient.status["events[0:]"]
    for name in ("time", "q", "final_q", "final_time"):
        assert np.isnan(gradient[name]).all(), name


def test_a_touch():
    """A flight that touches a wall without an impact has no derivatives at its end; one that does not has."""
    wall = vi.Structure(mass=[1], damping=[0], stiffness=[0], gaps=[vi.Gap([1], 1, 0.7)])
    for speed, touches in ((1 - 1e-14, True), (1 - 1e-8, False)):
        run = vi.simulate(wall, vi.Load(constant=[-0.5]), duration=5, state=([0], [speed]))
        assert len(run.events) == 0
        gradient = run.gradient()
        assert np.isnan(gradient["final_q"]).all() == touches
        assert ("at such a graze" in gradient.status.get("final_q", "")) == touches


def test_a_bounce():
    """The position after a bounce, checked by hand, and the refused arguments."""
    wall = vi.Structure(mass=[2], damping=[0], stiffness=[0], gaps=[vi.Gap([1], 1, 0.7)])
    gradient = vi.simulate(wall, duration=3, state=([0.2], [1.3])).gradient()
    assert gradient["final_q", "q_0"] == pytest.approx(-0.7, rel=1e-14)
    assert gradient["final_q", "q_dot_0"] == pytest.approx(-0.7 * 3, rel=1e-14)
    assert gradient["final_q", "opening_0"] == pytest.approx(1.7, rel=1e-14)
    assert gradient["final_q", "restitution_0"] == pytest.approx(1 - 0.2 - 1.3 * 3, rel=1e-14)
    assert gradient["time", "q_dot_0"] == pytest.approx(-0.8 / 1.3**2, rel=1e-14)
    assert gradient.to_xarray()["q"].dims == ("event", "coordinate", "parameter")
    with pytest.raises(vi.ParameterError, match="parameters: 'q_1' must be"):
        vi.simulate(wall, duration=3, state=([0.2], [1.3])).gradient(["q_1"])
    short = vi.simulate(
        damper(clearance=1.0),
        vi.Load(0.9, sine=[1, 0]),
        cycles=20,
        max_events=2,
        state=([0, 0], [1, 3]),
    )
    with pytest.raises(vi.ParameterError, match="must be complete"):
        short.gradient()
    assert gradient["final_time", "start"] == 1
