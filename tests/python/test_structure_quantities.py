"""Response quantities of structures: the oscillator, energy balance, Newton's law, and records."""

from itertools import pairwise

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError

OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
UNEVEN = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
CHAIN = vi.Structure(
    mass=[1.0, 0.8, 0.3], damping=[[0.05, -0.02, 0], [-0.02, 0.04, 0], [0, 0, 0]],
    stiffness=[[3.0, -1.0, 0], [-1.0, 2.0, 0], [0, 0, 0]],
    gaps=[vi.Gap([0, -1, 1], 0.4, 0.7), vi.Gap([0, 1, -1], 0.4, 0.5), vi.Gap([1, 0, 0], 0.9, 0.6)],
)  # fmt: skip


def runs():
    """Trajectories and motions of structures by name."""
    load = vi.Load(
        1.3, sine=[0.5, 0, 0], cosine=[[0, 0.2, 0], [0.1, 0, 0]], constant=[0.02, 0.05, 0.0]
    )
    step = 0.05
    shock = np.zeros((400, 3))
    shock[:60, 0] = 2 * np.sin(np.pi * np.arange(60) / 59)
    stick = vi.Structure(
        [1.0, 0.3], [0.05, 0], [1.0, 0], [vi.Gap([-1, 1], 0.2, 0.1), vi.Gap([1, -1], 0.2, 0.1)]
    )
    return {
        "harmonics": vi.simulate(CHAIN, load, cycles=12), "shock": vi.simulate(CHAIN, vi.Record(step, shock)),
        "free": vi.simulate(CHAIN, duration=20, state=([0.3, 0, 0], [0, 1, -1])),
        "rests": vi.simulate(stick, vi.Load(0.5, sine=[1.0, 0], constant=[0, -0.1]), cycles=6),
        "motion": vi.exact(OSC.structure(37.0), vi.Load(0.94, sine=[1, 0]), ([1.6, 6.0], [0, 1])),
    }  # fmt: skip


RUNS = runs()


@pytest.mark.parametrize("name", RUNS)
def test_energy_balance(name):
    """The energy that the load supplies is dissipated in dashpots and impacts, or stored at the end."""
    q = RUNS[name].quantities()
    scale = abs(q.work) + q.damping_loss + q.impact_loss
    assert scale > 0.01
    assert q.work - q.damping_loss - q.impact_loss - q.energy_change == pytest.approx(
        0, abs=1e-10 * scale
    )
    assert (q.impacts["loss"] >= -1e-12).all()


@pytest.mark.parametrize("name", RUNS)
def test_accelerations_solve_newtons_law(name):
    """M q'' differs from the forces by the contact forces of resting gaps, which do no work on these gaps."""
    run = RUNS[name]
    first, last = (0.0, run.period) if name == "motion" else (run.start, run.end)
    t = np.linspace(first, last, 4001)[1:-1]
    h = 1e-5
    times = np.asarray(run.events["time"]) if name != "motion" else run.phases / run.load.frequency
    clear = np.abs(t[:, None] - times).min(axis=1) > 2 * h if len(times) else np.ones(len(t), bool)
    t = t[clear]
    slope = (run.sample(t + h)[1] - run.sample(t - h)[1]) / (2 * h)
    found = run.acceleration(t)
    # the force of a record has kinks
    rough = 0.05 if name == "shock" else 1e-6
    np.testing.assert_allclose(found, slope, atol=rough * np.abs(found).max() * 3e-3 + 1e-7)


def test_those_of_the_oscillator():
    """A motion of the oscillator and the motion of its two masses as a structure have the same quantities."""
    motion = vi.exact(OSC, 0.94, 37.0, vi.exact(OSC, 0.94, 37.0, ([0, 1.38 * np.pi], "RL")))
    q, p = RUNS["motion"].quantities(), motion.quantities()
    if q.q.peak[0] != pytest.approx(p.x.peak, rel=1e-9):  # the mirror image
        p = vi.exact(OSC, 0.94, 37.0, ([0, 0.62 * np.pi], "RL")).quantities()
    for key, other in (
        ("q", "x"),
        ("q_dot", "x_dot"),
        ("q_ddot", "x_ddot"),
        ("transmitted", "transmitted"),
    ):
        mine, theirs = getattr(q, key), getattr(p, other)
        assert mine.rms[0] == pytest.approx(theirs.rms, rel=1e-9)
        assert mine.peak[0] == pytest.approx(theirs.peak, rel=1e-9)
        np.testing.assert_allclose(
            np.abs(mine.harmonics[0]), np.abs(theirs.harmonics), atol=1e-8 * theirs.peak
        )
    assert q.q.phase[0] == pytest.approx(p.x.phase, abs=1e-8)
    for key in ("work", "damping_loss", "impact_loss"):
        assert getattr(q, key) == pytest.approx(getattr(p, key), rel=1e-9)
    np.testing.assert_allclose(
        np.sort(q.impacts["impulse"]), np.sort(p.impacts["impulse"]), rtol=1e-9
    )
    np.testing.assert_allclose(np.sort(q.impacts["loss"]), np.sort(p.impacts["loss"]), rtol=1e-8)


@pytest.mark.parametrize("name", RUNS)
def test_extremes(name):
    """No dense sample is beyond the extremes, and one comes near each."""
    run = RUNS[name]
    q = run.quantities()
    first, last = (0.0, run.period) if name == "motion" else (run.start, run.end)
    t = np.linspace(first, last, 20_001)
    values = (*run.sample(t), run.acceleration(t))
    for key, value in zip(("q", "q_dot", "q_ddot"), values, strict=True):
        signal = getattr(q, key)
        size = signal.greatest - signal.least
        assert (value.max(axis=1) <= signal.greatest + 1e-9 * size + 1e-12).all()
        assert (value.min(axis=1) >= signal.least - 1e-9 * size - 1e-12).all()
        assert (value.max(axis=1) >= signal.greatest - 0.02 * size).all()


def test_windows_add_up():
    """Energies over two windows add up to those over both."""
    run = RUNS["harmonics"]
    middle = 0.4 * run.end
    parts = [run.quantities(window=window) for window in ((run.start, middle), (middle, run.end))]
    whole = run.quantities()
    for name in ("work", "damping_loss", "impact_loss", "energy_change"):
        total = sum(getattr(part, name) for part in parts)
        assert total == pytest.approx(getattr(whole, name), rel=1e-10, abs=1e-12)
    for window in ((0, 0), (1, 0), (-1, 2), (0, 1e9), (0, np.nan), 3):
        with pytest.raises(ParameterError, match=r"^window = "):
            run.quantities(window=window)


@pytest.mark.parametrize("name", RUNS)
def test_quadrature(name):
    """Means, rms, harmonics and energies are integrals of samples by Gauss's rule between the events."""
    run = RUNS[name]
    q, load = run.quantities(harmonics=4), run.load
    if name == "motion":
        run = run._run()
    edges = [run.start, *run.events["time"], run.end]
    if name == "shock":
        edges += [load.step * i for i in range(len(load.samples))]
    edges = np.unique(edges)
    edges = np.unique(
        np.concatenate([np.linspace(a, b, 2 + int(4 * (b - a))) for a, b in pairwise(edges)])
    )
    node, weight = np.polynomial.legendre.leggauss(12)
    half = 0.5 * np.diff(edges)
    t = ((edges[:-1] + half)[:, None] + half[:, None] * node).ravel()
    weight = (half[:, None] * weight).ravel()
    x, rate = run.sample(t)
    s = run.structure
    values = {"q": x, "q_dot": rate, "q_ddot": run.acceleration(t)}
    values["transmitted"] = s.stiffness @ x + s.damping @ rate
    for key, value in values.items():
        signal, size = getattr(q, key), np.abs(value).max(axis=1)
        np.testing.assert_allclose(
            signal.rms, np.sqrt(value**2 @ weight / q.duration), rtol=1e-10, atol=1e-12
        )
        if key == "q_ddot":
            change = run.final_state[1] - run.initial_state[1]
            assert (np.abs(signal.mean - change / q.duration) <= 1e-10 * size).all()
            continue
        assert (np.abs(signal.mean - value @ weight / q.duration) <= 1e-11 * size).all()
        for h in range(signal.harmonics.shape[1]):
            turned = np.exp(-1j * (h + 1) * load.frequency * t)
            part = 2 * value @ (weight * turned) / q.duration
            assert (np.abs(signal.harmonics[:, h] - part) <= 1e-10 * size).all()
    lost = np.einsum("im,ij,jm,m", rate, s.damping, rate, weight)
    assert q.damping_loss == pytest.approx(lost, rel=1e-10)


def test_names():
    """Quantities of an oscillator have separate names, in addition to those of its structure."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    point = osc.at(0.9, 6.0)
    own = vi.simulate(osc, 0.9, 6.0, cycles=7).quantities()
    found = vi.simulate(point.structure, point.load, cycles=7).quantities()
    assert own.impacts["gap"].tolist() == found.impacts["gap"].tolist()
    assert own.cycles == pytest.approx(found.cycles, rel=1e-12)
    for key in ("q", "q_dot", "q_ddot"):
        mine, theirs = getattr(own, key), getattr(found, key)
        for part in ("mean", "rms", "least", "greatest", "harmonics"):
            size = 1e-9 * np.max(theirs.peak)
            np.testing.assert_allclose(getattr(mine, part), getattr(theirs, part), atol=size)
    assert own.x.rms == own.q.rms[0]
    assert own.transmitted.peak == pytest.approx(found.transmitted.peak[0], rel=1e-9)
    with pytest.raises(
        AttributeError, match=r"^x_dot: .* of a Structure does not have it; it has q_dot"
    ):
        _ = found.x_dot
