"""Random branches: the special points are exactly the crossings of the unit circle by multipliers.

The multipliers are those of first_principles.py, not the package's.
"""

import itertools
import math

import first_principles as fp
import mpmath
import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import system_of
from vibroimpact.base.errors import SingularError, VibroimpactError

PATTERNS = [
    ("RL", 1),
    ("RRL", 1),
    ("RL", 2),
    ("RRL", 2),
    ("RRLL", 1),
    ("RLL", 1),
    ("RRRL", 1),
    ("RRLRL", 2),
]
#: The number of multipliers that cross the unit circle at each type of special point.
CROSSING = {"fold": 1, "pitchfork": 1, "flip": 1, "neimark_sacker": 2}


def multipliers_of(motion):
    """Eigenvalues of the product of the derivatives of all impact maps, with extra digits if it is large."""
    maps = fp.impact_jacobians(
        system_of(motion), motion.alpha, motion.X, motion.X_dot_after, motion.Z_dot_after,
        motion.A * math.cos(motion.tau), motion.A * math.sin(motion.tau),
    )  # fmt: skip
    whole = np.linalg.multi_dot(maps[::-1]) if len(maps) > 1 else maps[0]
    if np.abs(whole).max() < 1e3:
        return np.linalg.eigvals(whole)
    with mpmath.workdps(40):
        whole = mpmath.eye(4)
        for one in maps:
            whole = mpmath.matrix(one.tolist()) * whole
        return np.array([complex(z) for z in mpmath.eig(whole, left=False, right=False)])


def approach(motion):
    """The least approach speed of a motion."""
    return (motion.pattern.signs * (motion.Z_dot_before - motion.X_dot_before)).min()


def start(rng, osc, r, clearance, pattern, tries=12):
    """An exact, admissible motion from random phases, or None."""
    for _ in range(tries):
        phases = np.sort(rng.uniform(0, 2 * math.pi * pattern.cycles, len(pattern)))
        try:
            motion = vi.exact(osc, r, clearance, (phases - phases[0], pattern))
        except VibroimpactError:
            continue
        if motion.admissible:
            return motion
    return None


def random_branch(seed):
    rng = np.random.default_rng(seed)
    motion = None
    while motion is None:
        walls = rng.uniform(0, 0.95, 2)
        osc = vi.Oscillator(
            xi=10 ** rng.uniform(-4, -1), mu=10 ** rng.uniform(-2.5, 0.08),
            restitution=float(walls[0]) if rng.random() < 0.5 else tuple(walls.tolist()),
        )  # fmt: skip
        pattern = vi.Pattern(*PATTERNS[rng.integers(len(PATTERNS))])
        r, clearance = rng.uniform(0.2, 2), 10 ** rng.uniform(-0.3, 2.2)
        motion = start(rng, osc, float(r), float(clearance), pattern)
    names = ["r", "clearance", "xi", "mu", "R1"]
    name = names[rng.integers(len(names))]
    value = {
        "r": motion.r, "clearance": motion.clearance, "xi": motion.osc.xi, "mu": motion.osc.mu,
        "R1": motion.osc.restitution[0],
    }[name]  # fmt: skip
    low, high = value * rng.uniform(0.6, 0.95), value * rng.uniform(1.05, 1.6)
    if name == "R1":
        high = min(high, 0.97)
    return vi.branch(motion, name, (float(low), float(high)), max_points=250)


def superharmonic_branch(seed):
    """Through a superharmonic resonance of a lightly damped system."""
    rng = np.random.default_rng(10**6 + seed)
    motion = None
    while motion is None:
        centre = (1 / 3, 1 / 2, 1 / 5)[rng.integers(3)]
        walls = tuple(rng.uniform(0, 0.95, 2).tolist())
        osc = vi.Oscillator(
            xi=10 ** rng.uniform(-4, -2), mu=10 ** rng.uniform(-2.5, 0.08), restitution=walls
        )
        pattern = vi.Pattern(*PATTERNS[rng.integers(5)])
        r, clearance = centre * rng.uniform(0.97, 1.4), 10 ** rng.uniform(-0.3, 1.3)
        motion = start(rng, osc, float(r), float(clearance), pattern, 6)
    bounds = (min(motion.r * 0.98, centre * 0.95), max(motion.r * 1.02, centre * 1.25))
    return motion, bounds


def outside(multipliers):
    return int((np.abs(multipliers) > 1).sum())


def critical_distance(kind, multipliers):
    """Distance of the crossing multiplier from its critical value."""
    if kind == "flip":
        return np.abs(multipliers + 1).min()
    if kind == "neimark_sacker":
        turning = multipliers[np.abs(multipliers.imag) > 0]
        return np.abs(np.abs(turning) - 1).min() if len(turning) else np.inf
    return np.abs(multipliers - 1).min()


def assert_crossings(path):
    """Every special point has its multiplier, and between special points the count outside does not change."""
    marks = {}
    for point in path.special_points:
        marks.setdefault(point.index, []).append(point.type)
    spectra = {}
    for i in range(len(path)):
        try:
            motion = path[i]
        except SingularError:
            continue
        # beyond a zero approach speed there is no motion
        if abs(approach(motion)) > 1e-7 * motion.clearance:
            spectra[i] = multipliers_of(motion), approach(motion) > 0
    step = np.ptp(path.values) * 1e-9
    for i, kinds in marks.items():
        for kind in set(kinds) & set(CROSSING):
            if i not in spectra:
                continue
            away = critical_distance(kind, spectra[i][0])
            # where multipliers change this fast, the last bits of the parameter decide
            j, k = max(0, i - 1), min(len(path) - 1, i + 1)
            steep = abs(path.values[k] - path.values[j]) < step
            assert away < (1e-2 if steep else 1e-6), (path, kind, i, spectra[i][0])
    plain = [i for i in range(len(path)) if i not in marks]
    for i, j in itertools.pairwise(plain):
        if not (i in spectra and j in spectra and spectra[i][1] and spectra[j][1]):
            continue
        one, other = spectra[i][0], spectra[j][0]
        if min(np.abs(np.abs(one) - 1).min(), np.abs(np.abs(other) - 1).min()) < 1e-6:
            continue
        possible = {outside(one)}
        for k in range(i + 1, j):
            for kind in set(marks[k]) & set(CROSSING):
                possible = {n + sign * CROSSING[kind] for n in possible for sign in (-1, 1)}
        assert outside(other) in possible, (path, i, path.values[[i, j]], one, other)


def assert_folds_turn(path):
    """The parameter turns back at folds, and nowhere else."""
    marks = {}
    for point in path.special_points:
        marks.setdefault(point.index, []).append(point.type)
    change = np.diff(path.values)
    change[np.abs(change) < 1e-9 * np.ptp(path.values)] = 0
    for i in np.flatnonzero(change[:-1] * change[1:] < 0) + 1:
        near = {kind for k in range(i - 1, i + 2) for kind in marks.get(k, [])}
        # (a closed branch begins and ends anywhere)
        if "closed" in path.ends and i in (1, len(path) - 2):
            continue
        assert near & {"fold", "pitchfork"}, (path, i, path.values[i - 1 : i + 2])


def assert_multipliers_follow(path):
    """The characteristic polynomial, normalised to length 1, changes little between points."""
    for i in range(len(path) - 1):
        both = [np.poly(path.multipliers[:, k]).real for k in (i, i + 1)]
        if not np.isfinite(both).all() or max(np.abs(p).max() for p in both) > 1e4:
            continue
        one, other = (p[:4] / np.linalg.norm(p[:4]) for p in both)
        short = np.ptp(path.values) * 1e-4
        if abs(path.values[i + 1] - path.values[i]) > short:
            assert min(np.linalg.norm(one - other), np.linalg.norm(one + other)) < 0.75


@pytest.mark.parametrize("seed", range(30))
def test_random_branch(seed):
    path = random_branch(seed)
    assert_crossings(path)
    assert_folds_turn(path)
    assert_multipliers_follow(path)


@pytest.mark.parametrize("seed", range(16))
def test_branch_through_a_superharmonic_resonance(seed):
    """The branch does not jump to another one, and steps five times shorter give the same special points."""
    motion, bounds = superharmonic_branch(seed)
    path = vi.branch(motion, "r", bounds, max_points=1500)
    fine = vi.branch(motion, "r", bounds, longest_step=0.01, max_points=6000)
    assert_folds_turn(path)
    assert_folds_turn(fine)
    if {"closed", "full"} & {*path.ends, *fine.ends} or path.ends != fine.ends:
        return
    listed = [
        [(p.type, p.r) for p in one.special_points if p.type in CROSSING] for one in (path, fine)
    ]
    assert [kind for kind, _ in listed[0]] == [kind for kind, _ in listed[1]]
    np.testing.assert_allclose(
        [r for _, r in listed[0]], [r for _, r in listed[1]], rtol=0, atol=1e-6
    )


#: Systems with very little damping, the pattern, the bounds of r, and the start: r and phases.
NARROW = [
    (
        vi.Oscillator(
            xi=0.00033369507132054735, mu=0.7197614491814485, restitution=(0.611211176200436, 0.8145345920170147)
        ),
        2.0391838473236046, ("RL", 1), (0.3297109302, 0.5151733284),
        [(0.47900870299582987, [0, 3.1637]), (0.3299334263950944, [0, 3.1117]), (0.3573519833264643, [0, 4.2235])],
    ),
    (
        vi.Oscillator(xi=0.00023337605601973872, mu=0.003526323439511666, restitution=(0.11868577723638818, 0.0)),
        3.0550753098689953, ("RRL", 2), (0.35, 0.6), [(0.46500599720640556, [0, 6.152, 9.2875])],
    ),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("system", range(len(NARROW)))
def test_branch_beside_another_sheet(system):
    """Branches that are closer to each other than the length of a step are followed without a jump."""
    osc, clearance, pattern, bounds, starts = NARROW[system]
    for r, phases in starts:
        motion = vi.exact(osc, r, clearance, (phases, vi.Pattern(*pattern)))
        path = vi.branch(motion, "r", bounds, max_points=600)
        assert_folds_turn(path)
        assert_crossings(path)


def test_neimark_sacker_with_another_multiplier_outside():
    """A Neimark-Sacker point is found while another multiplier of 1e4 is outside the unit circle."""
    osc = vi.Oscillator(
        xi=0.0003232406496780347, mu=0.04836445901228357, restitution=0.27631301409515274
    )
    motion = vi.exact(
        osc, 0.9804155544685564, 54.78666102683142, ([0, 3.1793], vi.Pattern("RL", 2))
    )
    path = vi.branch(motion, "xi", (5e-5, 3e-3))
    assert_crossings(path)
    (point,) = [p for p in path.special_points if p.type == "neimark_sacker"]
    assert np.sort(np.abs(multipliers_of(point.motion)))[-1] > 1e3
    inner, outer = (path[point.index + k] for k in (-1, 1))
    assert {outside(multipliers_of(inner)), outside(multipliers_of(outer))} == {1, 3}


def test_neimark_sacker_and_flip_in_one_step():
    """Both points are found within one step, although the interval of stable motions between them is short."""
    osc = vi.Oscillator(
        xi=0.0008446336304214421,
        mu=0.02449241486588316,
        restitution=(0.5734472061777176, 0.5969854144693492),
    )
    motion = vi.exact(osc, 0.46481946637593596, 1.955, ([0, 2.5192], vi.Pattern("RL")))
    for step in (0.05, 0.01):
        path = vi.branch(motion, "clearance", (1.0, 4.0), longest_step=step)
        assert_crossings(path)
        kinds = [p.type for p in path.special_points]
        i = kinds.index("neimark_sacker")
        assert kinds[i : i + 2] == ["neimark_sacker", "flip"]
        edge = [p.clearance for p in path.special_points[i : i + 2]]
        between = vi.exact(osc, motion.r, sum(edge) / 2, path.special_points[i].motion)
        assert between.stable
        assert np.abs(multipliers_of(between)).max() < 1


@pytest.mark.slow
def test_two_neimark_sacker_points_within_one_step():
    """Motions are stable between r = 2.2444 and 2.2463, less than a step apart, from either start."""
    osc = vi.Oscillator(
        xi=0.00036046255634376097, mu=1.0137313279623066, restitution=0.9044714271264069
    )
    r, clearance, bounds = (
        2.06783473909528,
        0.11013111558505648,
        (1.654267791276224, 2.5847934238691),
    )
    starts = [
        m for m in vi.find(osc, r, clearance, max_impacts=5, max_cycles=1) if len(m.alpha) == 5
    ]
    assert len(starts) == 4
    for motion in starts:
        path = vi.branch(motion, "r", bounds)
        assert_crossings(path)
        found = [p.r for p in path.special_points if p.type == "neimark_sacker" and p.r > 2.2]
        assert sorted(found) == pytest.approx([2.2444061, 2.2462613], abs=1e-6)
        inside = [p.index for p in path.special_points if p.r in found]
        between = vi.exact(osc, sum(found) / 2, clearance, path[inside[0]])
        assert between.stable
        assert np.abs(multipliers_of(between)).max() < 1


@pytest.mark.slow
def test_no_fold_where_approach_speeds_vanish_together():
    """Where two impacts merge, multipliers exceed 1e10, but no fold is reported, as none is near 1."""
    osc = vi.Oscillator(
        xi=0.019277312704164336,
        mu=0.12515000903233775,
        restitution=(0.19402547600704456, 0.3904589137977216),
    )
    motion = vi.exact(
        osc, 1.1889172818445064, 6.28930058156793, ([0, 6.1416, 9.3376], vi.Pattern("RRL", 2))
    )
    path = vi.branch(motion, "r", (0.8, 1.5))
    assert_crossings(path)
    assert_folds_turn(path)
    assert not [p for p in path.special_points if p.type == "fold" and 1.14 < p.r < 1.15]


def test_neutral_saddle_is_no_special_point():
    """Two real multipliers with product 1 are not reported, although they satisfy the equation of a pair."""
    saddles = 0
    for seed in range(20):
        path = random_branch(seed)
        for i in range(len(path) - 1):
            real = [np.sort(path.multipliers[:, k].real) for k in (i, i + 1)]
            if np.abs(path.multipliers[:, i : i + 2].imag).max() > 0:
                continue
            products = [np.outer(x, x)[np.triu_indices(4, 1)] - 1 for x in real]
            saddles += int(((products[0] * products[1]) < 0).any())
        for point in path.special_points:
            if point.type == "neimark_sacker":
                assert np.abs(point.motion.multipliers.imag).max() > 0
    assert saddles > 3
