"""Simulations of linear structures with gaps, compared with laws and independent calculations."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_structures import (
    chain,
    check_laws,
    energy,
    exponential,
    extended,
    first_order,
    random_structure,
)


@pytest.mark.parametrize(("speed", "impacts", "first"), [
    (-1, 7, [1.328742412, 2.586409675, 3.845947525, 4.663723623]),
    (-2, 26, [0.523231173, 1.430498994, 1.817944213]),
    (-10, 86, []),
])  # fmt: skip
def test_chain(speed, impacts, first):
    """All times to 1e-12 of a simulation in 40 digits; a published record by a neural network has 1.32868,
    2.58660 and 3.84609 for the first three."""
    reference = pytest.importorskip("reference_chain")
    s = chain(20)
    rate = np.zeros(40)
    rate[0] = speed
    run = vi.simulate(s, duration=10, state=(np.zeros(40), rate))
    known = reference.simulate(20, speed, 10)
    assert len(run.events) == len(known) == impacts
    assert run.events["gap"].tolist() == [2 * cell + (side < 0) for _, cell, side in known]
    off = [float(t - event) for (t, *_), event in zip(known, run.events["time"], strict=True)]
    assert np.abs(off).max() < 1e-12
    assert run.events["time"][: len(first)] == pytest.approx(first, abs=1e-9)
    check_laws(run)
    start = energy(s, run.initial_state)
    assert [energy(s, state) for state in run.states] == pytest.approx([start] * impacts, rel=1e-13)
    momentum = s.mass @ np.stack([state[1] for state in run.states], axis=1)
    assert momentum.sum(0) == pytest.approx(speed, rel=1e-13)


def test_one_wall():
    """COCO, example 15.2: x'' + .1 x' + x = cos t, a wall at 1, R = .8. The published motion has the phase
    .07595216493831 and the approach speed 1.69573294."""
    s = vi.Structure([1.0], [0.1], [1.0], [vi.Gap([1.0], 1.0, 0.8)])
    run = vi.simulate(s, vi.Load(1.0, cosine=[1.0]), cycles=200)
    last = run.events[run.events["time"] > 198 * 2 * np.pi]
    assert set(last["kind"]) == {"impact"}
    assert last["time"][-1] % (2 * np.pi) == pytest.approx(0.07595216493831, abs=1e-11)
    assert last["speed"][-1] == pytest.approx(1.69573294, abs=1e-8)
    check_laws(run)


@pytest.mark.parametrize("restitution", [(0.9, 0.8), (0.2, 0.4)])
@pytest.mark.parametrize("r", [0.5, 1.04])
def test_the_oscillator_as_a_structure(restitution, r):
    """Impacts, rests and releases equal those of the simulation of the oscillator."""
    osc = vi.Oscillator(xi=0.05, mu=0.1, restitution=restitution)
    known = vi.simulate(osc, r, 4.0, cycles=6)
    gaps = [
        vi.Gap([-1, 1], 2.0, restitution[0]),
        vi.Gap([1, -1], 2.0, restitution[1]),
    ]
    s = vi.Structure([1, 0.1], [0.1, 0], [1, 0], gaps)
    run = vi.simulate(s, vi.Load(r, sine=[1, 0]), cycles=6)
    check_laws(run)
    # an accumulation may be summed some impacts earlier: compare only faster impacts
    pick = [
        (e["time"], e["speed"]) for e in run.events if e["kind"] == "impact" and e["speed"] > 1e-3
    ]
    speeds = np.abs(known.events["x_dot_before"] - known.events["z_dot_before"])
    wanted = [
        (e["time"], v) for e, v in zip(known.events, speeds, strict=True)
        if e["kind"] == "impact" and v > 1e-3
    ]  # fmt: skip
    assert np.array(pick) == pytest.approx(np.array(wanted), abs=1e-8)
    for kind in ("stick", "release"):
        mine = run.events["time"][run.events["kind"] == kind]
        theirs = known.events["time"][known.events["kind"] == kind]
        assert mine == pytest.approx(theirs, abs=1e-8)
    final = known.final_state
    assert np.concatenate(run.final_state) == pytest.approx(
        [final["x"], final["z"], final["x_dot"], final["z_dot"]], abs=1e-7
    )


def test_ball():
    """The bounces of a ball and their limit in closed form."""
    g, height, restitution = 9.81, 1.0, 0.5
    s = vi.Structure([2.0], [0.0], [0.0], [vi.Gap([-1.0], 0.0, restitution)])
    run = vi.simulate(s, vi.Load(1.0, constant=[-2.0 * g]), duration=3.0, state=([height], [0.0]))
    fall = math.sqrt(2 * height / g)
    bounces = [fall * (1 + 2 * sum(restitution**j for j in range(1, i + 1))) for i in range(10)]
    assert run.events["time"][:10] == pytest.approx(bounces, rel=1e-14)
    assert run.events["kind"][-1] == "stick"
    assert run.events["time"][-1] == pytest.approx(
        fall * (1 + 2 * restitution / (1 - restitution)), rel=1e-14
    )
    assert np.concatenate(run.final_state).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("coupled", [False, True])
def test_the_response_is_reciprocal(coupled):
    """The response of coordinate i to a unit harmonic force on j equals that of j to the same force on i."""
    rng = np.random.default_rng(6)
    for _ in range(10):
        s = random_structure(rng, coupled)
        n, omega = s.coordinates, float(rng.uniform(0.3, 3))
        free = vi.Structure(s.mass, s.damping, s.stiffness, [])
        known = np.linalg.inv(s.stiffness - omega**2 * s.mass + 1j * omega * s.damping)
        response = np.zeros((n, n), complex)
        for j in range(n):
            load = vi.Load(omega, cosine=np.eye(n)[j])
            # a start on the steady motion leaves no transient
            start = (known[:, j].real, -omega * known[:, j].imag)
            run = vi.simulate(free, load, cycles=3, state=start)
            t = run.end
            q, rate = run.sample([t])
            response[:, j] = (q[:, 0] - 1j * rate[:, 0] / omega) * np.exp(-1j * omega * t)
        scale = np.abs(response).max()
        assert np.abs(response - response.T).max() < 1e-12 * scale
        assert np.abs(response - known).max() < 1e-12 * scale


@pytest.mark.parametrize("coupled", [False, True])
def test_random_structures(coupled):
    """Flights of any structure, with classical and coupled damping, two harmonics and a constant force."""
    rng = np.random.default_rng(5)
    refusals, impacts = [], 0
    for _ in range(20):
        s = random_structure(rng, coupled)
        load = vi.Load(
            float(rng.uniform(0.3, 3)), sine=3 * rng.normal(size=(2, s.coordinates)),
            cosine=3 * rng.normal(size=s.coordinates), constant=0.1 * rng.normal(size=s.coordinates),
        )  # fmt: skip
        try:
            run = vi.simulate(s, load, cycles=3, max_events=60)
        except vi.SingularError as error:
            refusals.append(str(error))
            continue
        impacts += len(run.events)
        check_laws(run, 1e-8)
        check_samples(run)
    # while one gap is at rest, another one closes
    assert len(refusals) <= 5
    assert all("coupled gaps" in text for text in refusals)
    assert impacts > 100


def check_samples(run):
    """Samples agree with the matrix exponential, up to the first rest."""
    s, t = run.structure, np.linspace(run.start, run.end, 30)
    q, rate = run.sample(t)
    for i, time in enumerate(t):
        k = int(np.searchsorted(run.events["time"], time, side="right"))
        if k and "stick" in run.events["kind"][:k]:
            break
        begin = run.events["time"][k - 1] if k else run.start
        state = run.states[k - 1] if k else np.array(run.initial_state)
        steps = exponential(first_order(s, run.load) * (time - begin) / 16)
        flight = np.linalg.matrix_power(steps, 16) @ extended(state, run.load, begin)
        assert np.concatenate([q[:, i], rate[:, i]]) == pytest.approx(
            flight[: 2 * s.coordinates], abs=1e-8
        )


def test_rest_from_the_start():
    """A ball on the floor stays there until a growing pull exceeds its weight; samples show it there."""
    ball = vi.Structure([1], [0], [0], [vi.Gap([-1], 0.0, 0.5)])
    load = vi.Load(1.0, sine=[15.0], constant=[-9.81])
    run = vi.simulate(ball, load, duration=8, state=([0], [0]))
    assert run.events["kind"][0] == "release"
    lifted = math.asin(9.81 / 15)
    assert run.events["time"][0] == pytest.approx(lifted, abs=1e-12)
    assert (run.sample(np.linspace(0, lifted - 1e-9, 50))[0] == 0).all()
    q = run.sample(np.linspace(0, run.end, 2000))[0]
    assert q.min() > -1e-12
    # after the release: the integral of 15 sin t - 9.81, twice
    t = lifted + 0.25
    wanted = (
        -15 * (math.sin(t) - math.sin(lifted)) + 15 * math.cos(lifted) * 0.25 - 9.81 * 0.25**2 / 2
    )
    assert run.sample([t])[0][0, 0] == pytest.approx(wanted, abs=1e-12)


def test_the_same_bits_again():
    s = chain(5)
    rate = np.zeros(10)
    rate[0] = -3
    runs = [vi.simulate(s, duration=30, state=(np.zeros(10), rate)) for _ in range(2)]
    assert runs[0].events.tobytes() == runs[1].events.tobytes()
    assert runs[0].states.tobytes() == runs[1].states.tobytes()


def test_more_events_than_there_is_room_for_at_first(monkeypatch):
    s = chain(5)
    state = (np.zeros(10), np.r_[-20.0, np.zeros(9)])
    run = vi.simulate(s, duration=40, state=state)
    monkeypatch.setattr("vibroimpact.motions.trajectory.ROOM", 16 * 8 * 23)
    again = vi.simulate(s, duration=40, state=state)
    assert len(run.events) > 8 * 16
    assert again.events.tobytes() == run.events.tobytes()


def test_more_events_than_at_first_expected():
    s = chain(5)
    rate = np.zeros(10)
    rate[0] = -20
    run = vi.simulate(s, duration=400, state=(np.zeros(10), rate))
    part = vi.simulate(s, duration=400, state=(np.zeros(10), rate), max_events=100)
    assert run.complete
    assert len(run.events) > 1024
    assert not part.complete
    assert part.end == part.events["time"][-1]
    assert part.events.tobytes() == run.events[:100].tobytes()


def test_uncoupled_impacts_at_one_instant_are_done():
    gaps = [vi.Gap([1, 0], 1.0, 0.5), vi.Gap([0, 1], 1.0, 0.25)]
    s = vi.Structure([1, 1], [0, 0], [0, 0], gaps)
    run = vi.simulate(s, duration=1.5, state=([0, 0], [1, 1]))
    assert run.events["time"].tolist() == [1.0, 1.0]
    assert run.final_state[1].tolist() == [-0.5, -0.25]


def test_damping_proportional_to_stiffness_of_a_free_chain():
    stiffness = np.array([[1, -1, 0], [-1, 2, -1], [0, -1, 1.0]])
    gaps = [vi.Gap([1, -1, 0], 0.2, 0.7), vi.Gap([-1, 1, 0], 0.25, 0.7)]
    structure = vi.Structure([1, 0.7, 0.6], 0.1 * stiffness, stiffness, gaps)
    run = vi.simulate(structure, vi.Load(1.2, cosine=[0.5, -0.5, 0]), cycles=20)
    assert run.complete
    # forces and impulses are internal: the centre of mass keeps its momentum
    mass = np.array([1, 0.7, 0.6])
    np.testing.assert_allclose(mass @ run.states[:, 1].T, 0, atol=1e-11)


def test_meta_impactor_cell():
    """Impact times of one cell of the lattices of impact dampers, without load, from an independent program."""
    gaps = [vi.Gap([-1, 1], 1), vi.Gap([1, -1], 1)]
    cell = vi.Structure([1, 0.3], [0, 0], [1, 0], gaps)
    run = vi.simulate(cell, duration=20, state=([0, 0], [0, -1]))
    times = [1, 5.561717592, 7.505486386, 10.603458248, 12.795727055, 19.690919712]
    assert run.events["time"] == pytest.approx(times, abs=6e-10)


def test_what_is_discarded_changes_nothing_else():
    """A run with `discard` keeps the later events of the complete run, in cycles, in time and for a record."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    structure, load = osc.structure(6.0), vi.Load(0.9, sine=[1, 0])
    period = 2 * math.pi / 0.9
    steps = vi.Record(period / 40, np.sin(2 * math.pi * np.arange(601) / 40)[:, None] * [1.0, 0.0])
    state = ([0, 0], [0, 1.0])
    for words, before, rest in (
        ({"load": load}, {"cycles": 15}, {"cycles": 4, "discard": 11}),
        ({"load": load, "start": 2.5}, {"duration": 15 * period},
         {"duration": 4 * period, "discard": 11 * period}),
        ({"load": steps}, {}, {"discard": 11 * period}),
    ):  # fmt: skip
        whole = vi.simulate(structure, state=state, **words, **before)
        part = vi.simulate(structure, state=state, **words, **rest)
        later = whole.events["time"] > part.start
        assert 0 < later.sum() < len(later)
        assert part.start == pytest.approx(words.get("start", 0.0) + 11 * period)
        assert part.end == pytest.approx(whole.end)
        assert part.events["kind"].tolist() == whole.events["kind"][later].tolist()
        assert part.events["time"] == pytest.approx(whole.events["time"][later], abs=1e-7)
        at = np.linspace(part.start, part.end, 50)
        assert np.abs(np.array(part.sample(at)) - whole.sample(at)).max() < 1e-5
