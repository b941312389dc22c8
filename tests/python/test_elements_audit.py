"""[P] of random structures with all kinds of elements, compared with a simulation in complex arithmetic.

`--audit-structures` sets the number of structures; `--audit-seed` draws others.
"""

import collections

import numpy as np
import pytest
import vibroimpact as vi
from reference_regimes import ReferenceRegimes

KINDS = ("gap", "stop", "pushing", "preload", "friction", "belts", "moving gap", "moving stop")


def of_all_kinds(rng):
    """A chain of 1 to 4 masses with 1 to 6 elements, and its load of two harmonics."""
    n, many = rng.integers(1, 5), rng.integers(1, 7)
    springs = rng.uniform(0.3, 2, n + 1)
    stiffness = (
        np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    )
    gaps, friction = [], []
    while len(gaps) + len(friction) < many:
        kind = rng.choice(KINDS)
        direction = np.zeros(n)
        places = rng.permutation(n)
        direction[places[0]] = rng.choice([-1, 1])
        if n > 1 and rng.random() < 0.4:
            direction[places[1]] = -direction[places[0]]
        opening, wall = rng.uniform(0.1, 1), {}
        if "moving" in kind:
            wall = {"cosine": rng.uniform(-0.1, 0.1, 2), "sine": rng.uniform(-0.1, 0.1, 2)}
        if "gap" in kind:
            gaps.append(vi.Gap(direction, opening, rng.uniform(0.3, 0.9), **wall))
        elif kind == "friction":
            slip = rng.uniform(0.02, 0.3)
            friction.append(vi.Friction(direction, slip, stick=slip * rng.uniform(1, 1.3)))
        elif kind == "belts" and n > 1:
            for i in places[:2]:
                slip, speed = rng.uniform(0.02, 0.3), rng.uniform(0.1, 1) * rng.choice([-1, 1])
                friction.append(vi.Friction(np.eye(n)[i], slip, slip * rng.uniform(1, 1.3), speed))
        else:
            k, c = rng.uniform(1, 100), rng.uniform(0, 2)
            preload = rng.uniform(0.02, 0.3) if kind == "preload" else 0.0
            release = "force" if kind == "pushing" or rng.random() < 0.3 else "gap"
            gaps.append(vi.Stop(direction, opening, k, c, preload, release, **wall))
    s = vi.Structure(rng.uniform(0.3, 2, n), 0.1 * stiffness, stiffness, gaps, friction)
    load = rng.uniform(-1.5, 1.5, (2, n)) * [[1], [0.3]]
    return s, vi.Load(rng.uniform(0.5, 2), cosine=load, sine=load[::-1] * [[0], [1]])


def with_stops_that_impacts_change(number):
    """A structure, its load and motion, and whether a stop lets go or presses at the instant of each event."""
    structure, load = of_all_kinds(np.random.default_rng([1, number]))
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=600, discard=500))
    follows = np.isin(motion.kinds[1:], ["let_go", "press"]) & (np.diff(motion.phases) == 0)
    assert follows.any()
    return structure, load, motion, follows


def sticking(structure, rate):
    """The directions in which friction sticks at a state between events."""
    rows = [p.direction for p in structure.friction if abs(p.direction @ rate - p.speed) < 1e-9]
    return np.array(rows).reshape(-1, structure.coordinates)


def compare(structure, load, step=2e-3):
    """The outcome for a structure, and the relative difference of its [P]."""
    try:
        motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=600, discard=500))
    except vi.VibroimpactError as error:
        return f"no motion: {error}", 0.0
    if len(motion.rests):
        return "rests", 0.0
    if np.isnan(motion.multipliers).any():
        return "no multipliers", 0.0
    start, parts = motion._run()._between_events()
    # perturbations that keep sticking elements at rest
    n, held = structure.coordinates, sticking(structure, parts[1])
    _, size, rows = np.linalg.svd(held)
    free = rows[np.sum(size > 1e-9) :].T
    basis = np.zeros((2 * n, n + free.shape[1]))
    basis[:n, :n], basis[n:, n:] = np.eye(n), free
    reference = ReferenceRegimes(structure, load, step, still=1e-9)
    events = reference.simulate(motion.period, parts, start, basis)
    returned = np.abs(reference.final - np.concatenate(parts)).max()
    if returned > 1e-7 or len(events) != len(motion.phases):
        return f"another motion: {returned:.1e}, {len(events)} for {len(motion.phases)}", 0.0
    P = basis.T @ reference.derivative
    powers = [np.linalg.matrix_power(P, k) for k in range(1, len(P) + 1)]
    sums = [np.sum(motion.multipliers**k) for k in range(1, len(P) + 1)]
    # the size of a power shows how much rounding may change its trace
    differences = [
        abs(s - np.trace(p)) / max(1, np.abs(p).max()) for s, p in zip(sums, powers, strict=True)
    ]
    differences.append(abs(motion.determinant - motion.law) / max(1, np.abs(P).max()))
    return "compared", float(max(differences))


@pytest.mark.parametrize("number", [364, 424, 501])
def test_structures_in_which_impacts_change_stops(number):
    """Structures from the large run in which an impact makes a stop press or release at that instant."""
    what, difference = compare(*of_all_kinds(np.random.default_rng([1, number])))
    assert what == "compared"
    assert difference < 1e-10


@pytest.mark.slow
def test_multipliers_are_those_of_an_independent_program(request, share):
    """Traces of [P] and its powers equal those of the complex step through a period of matrix exponentials."""
    many, seed = (request.config.getoption(f"--audit-{name}") for name in ("structures", "seed"))
    counts, worst, found = collections.Counter(), 0.0, []
    for number in range(max(10, share(many))):
        what, difference = compare(*of_all_kinds(np.random.default_rng([seed, number])))
        counts[what] += 1
        worst = max(worst, difference)
        if difference > 1e-7 or what.startswith("another"):
            found.append((number, what, difference))
    print(counts, worst)
    assert found == []
    assert counts["compared"] > sum(counts.values()) / 4
