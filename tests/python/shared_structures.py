"""Structures, and the laws of their flights and impacts by the matrix exponential."""

import math

import numpy as np
import pytest
import vibroimpact as vi


def exponential(matrix):
    """exp(matrix) by scaling, squaring and the Taylor series."""
    halvings = max(0, math.ceil(math.log2(max(1e-300, np.abs(matrix).sum(1).max()))) + 4)
    small = matrix / 2**halvings
    total, term = np.eye(len(matrix)), np.eye(len(matrix))
    for i in range(1, 20):
        term = term @ small / i
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def first_order(structure, load):
    """The matrix of (q, q', 1, cos and sin of each harmonic), which obeys linear equations."""
    n, h = structure.coordinates, 0 if load is None else len(load.sine)
    inverse = np.linalg.inv(structure.mass)
    a = np.zeros((2 * n + 1 + 2 * h, 2 * n + 1 + 2 * h))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -inverse @ structure.stiffness
    a[n : 2 * n, n : 2 * n] = -inverse @ structure.damping
    if load is not None:
        a[n : 2 * n, 2 * n] = inverse @ load.constant
        for i in range(h):
            at, omega = 2 * n + 1 + 2 * i, (i + 1) * load.frequency
            a[n : 2 * n, at] = inverse @ load.cosine[i]
            a[n : 2 * n, at + 1] = inverse @ load.sine[i]
            a[at, at + 1], a[at + 1, at] = -omega, omega
    return a


def extended(state, load, t):
    h = 0 if load is None else len(load.sine)
    turns = [f(i * load.frequency * t) for i in range(1, h + 1) for f in (math.cos, math.sin)]
    return np.concatenate([*state, [1.0], turns])


def check_laws(run, tolerance=1e-10):
    """Check each flight by the matrix exponential, each impact by its law, and that gaps are open in flight."""
    s, n = run.structure, run.structure.coordinates
    a = first_order(s, run.load)
    directions = np.array([gap.direction for gap in s.gaps])
    openings = np.array([gap.opening for gap in s.gaps])
    inverse = np.linalg.inv(s.mass)
    t, state, resting = run.start, np.array(run.initial_state), set()
    for event, after in zip(run.events, run.states, strict=True):
        if event["kind"] == "impact" and not resting:
            duration = event["time"] - t
            steps = exponential(a * duration / 50)
            flight = extended(state, run.load, t)
            for _ in range(50):
                flight = steps @ flight
                assert (openings - directions @ flight[:n] > -tolerance).all()
            q, before = flight[:n], flight[n : 2 * n]
            scale = 1 + np.abs(flight).max()
            gap = s.gaps[event["gap"]]
            effective = 1 / (gap.direction @ inverse @ gap.direction)
            speed = gap.direction @ before
            assert abs(gap.opening - gap.direction @ q) < tolerance * scale
            assert abs(speed - event["speed"]) < tolerance * scale
            impulse = (1 + gap.restitution) * effective * speed
            assert abs(impulse - event["impulse"]) < tolerance * scale
            assert np.abs(after[0] - q).max() < tolerance * scale
            kick = inverse @ gap.direction * impulse
            assert np.abs(after[1] - before + kick).max() < tolerance * scale
        if event["kind"] == "stick":
            resting.add(int(event["gap"]))
        if event["kind"] == "release":
            resting.discard(int(event["gap"]))
        if event["kind"] != "impact":
            gap = s.gaps[event["gap"]]
            assert abs(gap.opening - gap.direction @ after[0]) < 1e-9
            assert abs(gap.direction @ after[1]) < 1e-9
        t, state = event["time"], after


def energy(structure, state):
    q, rate = state
    return 0.5 * (rate @ structure.mass @ rate + q @ structure.stiffness @ q)


def chain(cells):
    """A free-free chain of hosts, each with a free mass; all coefficients of restitution are 1."""
    stiffness = np.zeros((2 * cells, 2 * cells))
    for i in range(cells - 1):
        stiffness[i : i + 2, i : i + 2] += [[1, -1], [-1, 1]]
    gaps = []
    for i in range(cells):
        direction = np.zeros(2 * cells)
        direction[[i, cells + i]] = -1, 1
        gaps += [vi.Gap(direction, 1.0), vi.Gap(-direction, 1.0)]
    mass = [1.0] * cells + [0.3] * cells
    return vi.Structure(mass, np.zeros(2 * cells), stiffness, gaps)


def random_structure(rng, coupled):
    n = int(rng.integers(2, 6))

    def definite(scale):
        a = rng.normal(size=(n, n))
        return scale * (a @ a.T + 0.1 * np.eye(n))

    mass, stiffness = definite(1.0), definite(4.0)
    damping = definite(0.02) if coupled else 0.01 * stiffness
    gaps = [
        vi.Gap(rng.normal(size=n), float(rng.uniform(0.1, 0.5)), float(rng.uniform(0.6, 1)))
        for _ in range(int(rng.integers(1, 4)))
    ]
    return vi.Structure(mass, damping, stiffness, gaps)


def written(folder, text):
    """The cases of a namelist."""
    path = folder / "case.nml"
    path.write_text(text, encoding="utf-8")
    return vi.read_namelist(path)


def one_stop(opening, **stop):
    """x'' + .1 x' + x with a stop."""
    return vi.Structure([1.0], [0.1], [1.0], [vi.Stop([1.0], opening, **stop)])


def cycle_map(structure, load, start, first, step=1e-5):
    """A state of a single-coordinate structure one load cycle later, and its derivative by differences."""

    def later(state):
        run = vi.simulate(structure, load, cycles=1, start=start, state=(state[:1], state[1:]))
        return np.concatenate(run.final_state)

    sides = [later(first + e) - later(first - e) for e in step * np.eye(2)]
    return later(first), np.array(sides).T / (2 * step)


def check_parts(s, load, middles, tolerance):
    """A run continued from its final state equals the complete run, and so does a run that omits its beginning."""
    whole = vi.simulate(s, load, duration=40)
    for middle in middles(whole):
        first = vi.simulate(s, load, duration=middle)
        second = vi.simulate(s, load, duration=40 - middle, start=middle, state=first.final_state)
        times = np.concatenate([first.events["time"], second.events["time"]])
        assert times == pytest.approx(whole.events["time"], abs=tolerance)
        kept = vi.simulate(s, load, duration=40 - middle, discard=middle)
        assert kept.events["time"] == pytest.approx(second.events["time"], abs=tolerance)
        t = np.linspace(middle, 40, 50)
        assert kept.sample(t)[0] == pytest.approx(whole.sample(t)[0], abs=tolerance)


def with_elements():
    """Structures with stops and friction, each under a load that leads to a motion with all kinds of events."""
    ring = vi.Structure(
        [1.0, 0.5], [[0.1, 0.0], [0.0, 0.05]], [[2.0, -1.0], [-1.0, 1.5]],
        [vi.Gap([1, 0], 0.6, 0.7), vi.Stop([0, -1], 0.8, stiffness=30, damping=0.4)],
        [vi.Friction([1, -1], 0.05)],
    )  # fmt: skip
    slot = [vi.Gap([-1, 1], 18.5, 0.75), vi.Gap([1, -1], 18.5, 0.75)]
    damper = vi.Structure([1, 0.042], [0.01, 0], [1, 0], slot, [vi.Friction([-1, 1], 0.01)])
    return {
        "stop": (one_stop(1.0, stiffness=100, damping=1), vi.Load(1.0, cosine=[1.0])),
        "force": (
            one_stop(0.5, stiffness=20, damping=2, release="force"),
            vi.Load(1.3, cosine=[1.0]),
        ),
        "reversals": (
            vi.Structure([1.0], [0.0], [1.0], friction=[vi.Friction([1.0], 0.3)]),
            vi.Load(0.8, cosine=[1.0]),
        ),
        "stick": (
            vi.Structure([1.0], [0.02], [1.0], friction=[vi.Friction([1.0], 0.6)]),
            vi.Load(0.4, cosine=[1.0]),
        ),
        "damper": (damper, vi.Load(0.94, sine=[1.0, 0.0])),
        "all": (ring, vi.Load(1.1, cosine=[1.0, 0.2], sine=[0.0, 0.3])),
    }
