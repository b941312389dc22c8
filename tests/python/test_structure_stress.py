"""Structures under stress compared with 50-digit arithmetic: each result is accurate, refused, or unknown.

The table of docs/limits.md is the promised accuracy; each test reads its row.
"""

import re
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
import vibroimpact as vi
from reference_structure import DIGITS, ReferenceStructure

PAGE = Path(__file__).resolve().parents[2] / "docs/limits.md"
DRAWS = 4
"""The systems of a corner that are drawn, unless it has a number of its own."""
#: Name in the table: differences from a grounded chain of 3 masses with damping that couples its modes.
CORNERS = {
    "stiffness ratio 1e6": {"stiffness": 6},
    "stiffness ratio 1e12": {"stiffness": 12, "draws": 12},
    "stiffness ratio 1e12, classical damping": {
        "stiffness": 12,
        "damping": "classical",
        "draws": 2,
    },
    "stiffness ratio 1e12, no damping": {"stiffness": 12, "damping": "none"},
    "stiffness ratio 1e6, 10 masses": {"stiffness": 6, "masses": 10, "draws": 1},
    "stiffness ratio 1e6, free": {"stiffness": 6, "free": True},
    "mass ratio 1e6": {"mass": 6},
    "mass ratio 1e12, 2 masses": {"mass": 12, "masses": 2},
    "restitution 0 and 1": {"restitution": (0.0, 1.0)},
    "impacts 1e-12 apart": {"near": 1e-12},
    "48 impacts in 8 cycles, 2 masses": {"impacts": 48, "cycles": 8, "masses": 2, "draws": 1},
    "3 impacts in 32 cycles": {"impacts": 3, "cycles": 32},
}


def exact_in_binary(values, bits):
    """Round so that sums have no rounding errors: a free structure must be exactly free."""
    return np.ceil(np.asarray(values) * 2.0**bits) / 2.0**bits


def chain(corner, rng):
    """Mass, damping and stiffness of a chain of springs between neighbours, with the first one to the ground."""
    n, free = corner.get("masses", 3), corner.get("free", False)
    ratio, spread = corner.get("stiffness", 0), corner.get("mass", 0)
    springs = 10 ** rng.permutation(np.linspace(0, ratio, n)) if ratio else rng.uniform(0.5, 2, n)
    springs = exact_in_binary(springs, 10)
    masses = 10 ** rng.permutation(np.linspace(-spread, 0, n)) if spread else rng.uniform(0.5, 2, n)
    damping, stiffness = np.zeros((2, n, n))
    for i in range(int(free), n):
        between = np.zeros(n)
        between[i] = 1
        between[max(i - 1, 0)] = -1 if i else 1
        stiffness += springs[i] * np.outer(between, between)
        dashpot = rng.uniform(0.01, 0.1) * np.sqrt(springs[i] * masses[i])
        damping += exact_in_binary(dashpot, 20) * np.outer(between, between)
    kind = corner.get("damping")
    if kind == "classical":
        damping = 0.03 * np.diag(masses) + 1e-9 * stiffness
    return np.diag(masses), damping * (kind != "none"), stiffness


def cases(name):
    """Structures with a load, phases, and the motion with 50 digits; each impact has a separate gap."""
    corner, rng = CORNERS[name], np.random.default_rng(list(CORNERS).index(name))
    many, cycles = corner.get("impacts", 2), corner.get("cycles", 1)
    for _ in range(corner.get("draws", DRAWS)):
        matrices = chain(corner, rng)
        n = len(matrices[0])
        try:
            vi.simulate(vi.Structure(*matrices, gaps=[]), vi.Load(1, sine=np.zeros(n)), duration=1)
        except vi.errors.SingularError:
            continue
        directions = np.zeros((many, n))
        for g in directions:
            i, j = rng.choice(n, 2, replace=False)
            g[i] = 1
            if corner.get("free") or rng.random() < 0.6:
                g[j] = -1
        walls = rng.choice(corner["restitution"], many) if "restitution" in corner else None
        walls = rng.uniform(0.3, 0.9, many) if walls is None else walls
        frequency, cosine = rng.uniform(0.3, 2), rng.normal(size=n)
        phases = np.sort(rng.uniform(0, 6.28 * cycles, many))
        if "near" in corner:
            phases[1] = phases[0] + corner["near"]
        known = ReferenceStructure(
            [part.tolist() for part in matrices],
            (float(frequency), [0.0] * n, cosine.tolist()),
            [(g.tolist(), float(r)) for g, r in zip(directions, walls, strict=True)],
            phases, cycles, corner.get("free", False),
        )  # fmt: skip
        gaps = [
            vi.Gap([float(value) for value in g], float(place), float(r))
            for g, place, r in zip(known.directions, known.places, walls, strict=True)
        ]
        yield matrices, gaps, vi.Load(frequency, sine=np.zeros(n), cosine=cosine), phases, known


def off(values, known):
    """The largest error, relative to the largest value."""
    pairs = list(zip(values, known, strict=True))
    return float(max(abs(mp.mpf(float(a)) - b) for a, b in pairs) / max(abs(b) for _, b in pairs))


@pytest.mark.parametrize("name", CORNERS)
def test_structure_under_stress(name):
    """States, speeds and multipliers of `periodic`, in two ways, and of `exact`; a flight of `simulate`."""
    row = re.search(rf"^\| {re.escape(name)} \|(.*)\|$", PAGE.read_text(encoding="utf-8"), re.M)
    place, leading, exact = (float(cell) for cell in row[1].split("|"))
    corner, compared = CORNERS[name], 0
    with mp.workdps(DIGITS):
        for matrices, gaps, load, phases, known in cases(name):
            order, cycles, n = list(range(len(phases))), corner.get("cycles", 1), len(matrices[0])
            structure = vi.Structure(*matrices, gaps=gaps)
            try:
                found = [
                    (place, vi.periodic(structure, load, phases, order, cycles)),
                    (place, vi.periodic(structure, load, phases, order, cycles, full=True)),
                    (exact, vi.exact(structure, load, (phases, order, cycles))),
                ]
            except vi.errors.SingularError:
                continue
            compared += 1
            radius = max(abs(value) for value in known.multipliers())
            for bound, motion in found:
                # the position of a free structure is arbitrary
                q = motion.q - (motion.q[0] if corner.get("free") else 0)
                assert off(q, known.start[:n]) <= bound
                assert off(motion.q_dot, known.start[n:]) <= bound
                assert off(motion.speeds, known.speeds) <= bound
                assert np.abs(motion.phases - phases).max() <= bound * phases.max()
                if "near" in corner:
                    assert motion.stable is None
                    continue
                assert abs(mp.mpf(float(abs(motion.multipliers[0]))) / radius - 1) <= leading
                assert motion.stable in (None, radius < 1)
            assert_flight(matrices, load, phases, known, place)
    assert compared


def assert_flight(matrices, load, phases, known, place):
    """The flight after the first impact, simulated without gaps."""
    n = len(matrices[0])
    state = np.array([float(value) for value in known.start])
    later = vi.simulate(
        vi.Structure(*matrices, gaps=[]), load, duration=(phases[1] - phases[0]) / load.frequency,
        state=(state[:n], state[n:]), start=phases[0] / load.frequency,
    ).final_state  # fmt: skip
    for part, expected in zip(
        later, (known.before[1][:n], known.before[1][n : 2 * n]), strict=True
    ):
        # a flight is a sum of motions that may cancel
        assert off(part, expected) <= 100 * place
