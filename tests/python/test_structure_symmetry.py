"""Symmetries of structures: symmetric motions are followed as such, and lose the symmetry at pitchforks."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import SingularError

EXCHANGE = np.array([[0.0, 1.0], [1.0, 0.0]])
#: Number of half periods by which the image of a motion of two impacts starts earlier.
SHIFT = np.array([-1.0, 1.0])


def stops(restitution=(0.7, 0.7), opening=0.3):
    """Two equal masses on coupled springs, each with a stop on its right."""
    k = 0.3
    gaps = [vi.Gap([1, 0], opening, restitution[0]), vi.Gap([0, 1], opening, restitution[1])]
    return vi.Structure([1, 1], [0.1, 0.1], [[1 + k, -k], [-k, 1 + k]], gaps)


def opposite(structure=None):
    """Motion of these masses under opposite forces: the stops are hit alternately."""
    guess = ([0.63 * np.pi, 1.63 * np.pi], [0, 1])
    return vi.exact(structure or stops(), vi.Load(1.6, sine=[0.5, -0.5]), guess)


def dampers(at=None, opening=0.6):
    """Two equal dampers in one host, and a motion in which one does the opposite of the other later.

    The coordinates are the columns of `at`.
    """
    at = np.eye(3) if at is None else at
    directions = [[-1, 1, 0], [1, -1, 0], [-1, 0, 1], [1, 0, -1]]
    gaps = [vi.Gap(np.array(g) @ at, opening, 0.7) for g in directions]
    mass, damping, stiffness = (
        at.T @ np.diag(d) @ at for d in ([1, 0.05, 0.05], [0.04, 0, 0], [1, 0, 0])
    )
    structure = vi.Structure(mass, damping, stiffness, gaps)
    load = vi.Load(1.0, sine=at.T @ [0.1, 0, 0])
    phases = np.array([1.35817, 1.4974, 2.35817, 2.4974]) * np.pi
    return vi.exact(structure, load, (phases, [0, 2, 3, 1]))


def period_map(motion):
    """The derivative of the simulated period by central differences."""
    n = motion.structure.coordinates
    start = (motion.phases[0] - 0.2) / motion.load.frequency
    q, rate = motion.sample([start])
    state = np.concatenate([q[:, 0], rate[:, 0]])

    def end(state):
        run = vi.simulate(
            motion.structure,
            motion.load,
            cycles=motion.cycles,
            start=start,
            state=(state[:n], state[n:]),
        )
        return np.concatenate(run.final_state)

    h = 1e-5
    columns = [(end(state + h * e) - end(state - h * e)) / (2 * h) for e in np.eye(2 * n)]
    return np.array(columns).T


def of_type(branch, kind):
    return [point for point in branch.special_points if point.type == kind]


@pytest.mark.parametrize(
    ("name", "bounds"),
    [("opening", (0.1, 0.9)), ("load", (0.4, 3)), ("stiffness_0_1", (-0.7, -0.1)), ("frequency", (1.4, 1.9))],
)  # fmt: skip
def test_a_pitchfork_where_an_exchange_is_lost(name, bounds):
    """The simulated period has the multiplier 1 there, whose vector breaks the symmetry; images exist beyond."""
    branch = vi.branch(opposite(), name, bounds)
    (pitchfork,) = of_type(branch, "pitchfork")
    assert not of_type(branch, "fold") or name == "opening"
    for i in range(0, len(branch), 9):
        motion = branch[i]
        t = np.linspace(0, motion.period, 50)
        (here, _), (later, _) = motion.sample(t), motion.sample(t + motion.period / 2)
        assert later == pytest.approx(EXCHANGE @ here, abs=1e-12)
        assert branch.q_max[0, i] == pytest.approx(branch.q_max[1, i], rel=1e-9)
    there = branch[pitchfork.index]
    assert np.abs(np.linalg.eigvals(period_map(there)) - 1).min() < 1e-4
    # multipliers of nearby exact motions without the symmetry pass 1 at the same value
    shares = 1e-3 * np.array([-6, -4, -2, 2, 4, 6])
    values = [
        vi.exact(*branch.at(pitchfork.value * (1 + x)), there).multipliers for x in shares.tolist()
    ]
    nearest = [each[np.argmin(np.abs(each - 1))].real - 1 for each in values]
    assert nearest[0] * nearest[-1] < 0
    assert np.polynomial.Polynomial.fit(nearest, shares, 5)(0.0) == pytest.approx(0, abs=1e-7)


def test_motions_beyond_a_pitchfork_are_images_of_each_other():
    """A branch without the symmetry ends at the same pitchfork; the exchange gives another motion."""
    (pitchfork,) = of_type(vi.branch(opposite(), "opening", (0.1, 0.9)), "pitchfork")
    load = vi.Load(1.6, sine=[0.5, -0.5])
    motion = vi.exact(stops(), load, ([1.3427 * np.pi, 1.6072 * np.pi], [0, 1]))
    branch = vi.branch(motion, "opening", (0.29, 0.9))
    assert "meets a motion that repeats itself" in branch.ends
    (end,) = of_type(branch, "pitchfork")
    assert end.value == pytest.approx(pitchfork.value, rel=1e-8)
    near = branch[int(np.argmin(np.abs(branch.values - 0.598)))]
    image = vi.exact(near.structure, near.load, (near.phases[::-1] + np.pi * SHIFT, [0, 1]))
    t = np.linspace(0, near.period, 50)
    (here, _), (other, _) = near.sample(t), image.sample(t + near.period / 2)
    assert other == pytest.approx(EXCHANGE @ here, abs=1e-10)
    assert np.abs(np.diff(near.phases) - np.diff(image.phases)) > 1e-3
    assert np.sort(np.abs(image.multipliers)) == pytest.approx(
        np.sort(np.abs(near.multipliers)), rel=1e-8
    )


def test_two_dampers_in_one_host():
    """A symmetry with free masses, where one displacement remains unknown, in any coordinates."""
    motion = dampers()
    ours = vi.branch(motion, "opening", (0.3, 0.8))
    symmetry = -np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]])
    assert ours.residual.max() < 1e-12
    for i in range(0, len(ours), 11):
        here = ours[i]
        t = np.linspace(0, here.period, 50)
        (q, _), (later, _) = here.sample(t), here.sample(t + here.period / 2)
        assert later == pytest.approx(symmetry @ q, abs=1e-11)
    (pitchfork,), (fold,) = of_type(ours, "pitchfork"), of_type(ours, "fold")
    for point in (pitchfork, fold):
        assert np.abs(ours.multipliers[:, point.index] - 1).min() < 1e-7
    values = ours.values
    assert values[fold.index] == pytest.approx(values.max(), rel=1e-12)
    i = pitchfork.index
    assert (values[i] - values[i - 1]) * (values[i + 1] - values[i]) > 0
    at = np.eye(3) + 0.4 * np.random.default_rng(5).uniform(-1, 1, (3, 3))
    theirs = vi.branch(dampers(at), "opening", (0.3, 0.8))
    assert [p.type for p in theirs.special_points] == [p.type for p in ours.special_points]
    assert [p.value for p in theirs.special_points] == pytest.approx(
        [p.value for p in ours.special_points], rel=1e-7
    )


def test_units_that_take_turns():
    """Under equal forces each unit does in one load cycle what the other one does in the next."""
    load, guess = vi.Load(1.2, sine=[0.3, 0.3]), ([4.156, 10.439], [0, 1], 2)
    branch = vi.branch(vi.exact(stops(opening=1.0), load, guess), "opening", (0.1, 3.0))
    (fold,) = of_type(branch, "fold")
    assert np.abs(branch.multipliers[:, fold.index] - 1).min() < 1e-7
    for i in range(0, len(branch), 13):
        motion = branch[i]
        t = np.linspace(0, motion.period, 50)
        (here, _), (later, _) = motion.sample(t), motion.sample(t + motion.period / 2)
        assert later == pytest.approx(EXCHANGE @ here, abs=1e-10)


def test_without_the_symmetry_there_is_no_pitchfork():
    """Unequal stops, and a parameter of one of them, break the symmetry: the pitchfork unfolds."""
    unequal = opposite(stops(restitution=(0.7, 0.69)))
    for motion, name in ((unequal, "opening"), (opposite(), "restitution_0")):
        bounds = (0.1, 0.9) if name == "opening" else (0.6, 0.8)
        assert not of_type(vi.branch(motion, name, bounds), "pitchfork")


def test_zones_end_at_pitchforks():
    """Zones of symmetric and unsymmetric motions; multipliers at their boundaries."""
    zone = vi.zone(opposite(), x=("frequency", 1.4, 1.9), y=("opening", 0.1, 0.9))
    kinds = {piece.type for piece in zone.boundary}
    assert "pitchfork" in kinds
    assert all(piece.symmetric for piece in zone.boundary)
    for piece in zone.boundary:
        if piece.type != "pitchfork":
            continue
        for j in range(1, len(piece) - 1, 7):
            place = zone.at(float(piece.x[j]), float(piece.y[j]))
            motion = vi.periodic(*place, np.sort(piece.phases[:, j]), [0, 1])
            assert np.abs(motion.multipliers - 1).min() < 1e-6
    assert zone.contains(1.6, 0.55)
    assert not zone.contains(1.6, 0.63)


def cells(opening=0.6, weights=(1.0, 1.0), coupling=0.05, damper=0.0):
    """A chain of equal oscillators, each with a free mass in a slot; loads and masses can have weights."""
    n = len(weights)
    w = np.array(weights)
    link = np.zeros((n, n))
    for i in range(n - 1):
        link[i : i + 2, i : i + 2] += [[1, -1], [-1, 1]]
    matrices = np.zeros((2, 2 * n, 2 * n))
    matrices[0, :n, :n] = np.diag(0.02 * w) + damper * link
    matrices[1, :n, :n] = np.diag(w) + coupling * link
    gaps = []
    for i in range(n):
        direction = np.zeros(2 * n)
        direction[[i, n + i]] = -1, 1
        gaps += [vi.Gap(direction, opening, 0.7), vi.Gap(-direction, opening, 0.7)]
    structure = vi.Structure(np.r_[w, 0.05 * w], *matrices, gaps)
    return structure, vi.Load(1.1, sine=np.r_[0.1 * w, 0 * w])


def in_step(*args, **kwargs):
    """The motion in which all cells move alike: each free mass hits its left wall and then the right one."""
    structure, load = cells(*args, **kwargs)
    n = structure.coordinates // 2
    gaps = [*range(1, 2 * n, 2), *range(0, 2 * n, 2)]
    return vi.exact(structure, load, (np.repeat([0.5492 * np.pi, 1.5492 * np.pi], n), gaps))


def one_cell(opening, frequency=1.1):
    """The same motion of a single cell."""
    gaps = [vi.Gap([-1, 1], opening, 0.7), vi.Gap([1, -1], opening, 0.7)]
    cell = vi.Structure([1, 0.05], [0.02, 0], [1, 0], gaps)
    guess = ([0.5492 * np.pi, 1.5492 * np.pi], [1, 0])
    return vi.exact(cell, vi.Load(frequency, sine=[0.1, 0]), guess)


def parting(opening):
    """The multipliers of two cells in step that a single cell does not have, from the phases of a single cell."""
    small = one_cell(opening)
    structure, load = cells(opening)
    both = vi.periodic(structure, load, np.repeat(small.phases, 2), [1, 3, 0, 2])
    left = both.multipliers
    for multiplier in small.multipliers:
        i = np.abs(left - multiplier).argmin()
        assert abs(left[i] - multiplier) < 1e-12
        left = np.delete(left, i)
    assert both.determinant == pytest.approx(both.law, rel=1e-12)
    assert both.law == pytest.approx(small.law**2, rel=1e-12)
    assert np.prod(left) == pytest.approx(small.law, rel=1e-11)
    return left


def test_units_in_step_are_followed_and_part_at_a_pitchfork():
    """The pitchfork agrees with bisection on multipliers of the whole structure; beyond it simulation leaves."""
    branch = vi.branch(in_step(), "opening", (0.3, 0.8))
    places = [point.value for point in of_type(branch, "pitchfork")]
    low, high = 0.481, 0.484

    def product(opening):
        return np.prod(1 - parting(opening)).real

    assert product(low) < 0 < product(high)
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if product(middle) < 0 else (low, middle)
    assert np.abs(np.array(places) - low).min() < 1e-9
    # the other one is that of a single cell: its free mass loses the mirror symmetry
    alone = of_type(vi.branch(one_cell(0.6), "opening", (0.3, 0.8)), "pitchfork")
    assert np.abs(np.array(places) - alone[0].value).min() < 1e-9
    for place in places:
        motion = branch[int(np.abs(branch.values - place).argmin())]
        assert np.abs(motion.multipliers - 1).min() < 1e-6
    structure, load = cells(low - 2.5e-4)
    state = (1e-3 * np.array([1, -1, 0, 0]), np.zeros(4))
    motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=1500, state=state))
    assert motion.stable
    # the order of the impacts changes with the sign of a perturbation, so that its square counts with that
    # sign: the times separate in proportion to the distance of the parameter, not to its square root
    together = np.sort(np.repeat(one_cell(low).phases, 2))
    apart = []
    for beside in 2e-4 / 2.0 ** np.arange(8):
        order = np.argsort(motion.phases)
        structure, load = cells(low - beside)
        guess = 0.6 * motion.phases[order] + 0.4 * together
        motion = vi.exact(structure, load, (guess, motion.gaps[order]))
        assert motion.stable
        assert motion.admissible
        apart.append(np.ptp(np.sort(motion.phases)[:2]))
    assert apart[-2] / apart[-1] == pytest.approx(2, rel=0.02)


def test_units_in_step_have_the_multipliers_of_the_whole():
    """Along a branch through a Neimark-Sacker point, compared with the motions of the whole structure."""
    branch = vi.branch(in_step(), "frequency", (1.05, 1.35))
    assert branch.gaps.tolist() == [1, 3, 0, 2]
    assert {"pitchfork", "neimark_sacker"} <= {point.type for point in branch.special_points}
    structure, _ = cells()
    for i in range(0, len(branch), 9):
        load = vi.Load(float(branch.values[i]), sine=[0.1, 0.1, 0, 0])
        motion = vi.periodic(structure, load, branch.phases[:, i], branch.gaps)
        assert motion.consistent
        sizes = np.sort(np.abs(motion.multipliers))
        assert np.sort(np.abs(branch.multipliers[:, i])) == pytest.approx(sizes, abs=1e-9)
        assert motion.speeds == pytest.approx(branch.speeds[:, i], rel=1e-9)
        assert branch.q_max[0, i] == pytest.approx(branch.q_max[1, i], rel=1e-12)
    for point in of_type(branch, "neimark_sacker"):
        sizes = np.abs(branch.multipliers[:, point.index])
        assert np.abs(sizes - 1).min() < 1e-8


def test_zones_of_units_in_step():
    """Stops of two masses hit together: the zone ends where either the pair or its halves do."""
    motion = vi.exact(stops(), vi.Load(1.2, sine=[0.5, 0.5]), ([1.7721] * 2, [0, 1]))
    zone = vi.zone(motion, ("frequency", 0.6, 1.4), ("opening", 0.2, 0.5))
    assert zone.contains(1.2, 0.3)
    kinds = set()
    for piece in zone.boundary:
        if piece.type == "window":
            continue
        kinds.add(piece.type)
        for j in range(1, len(piece) - 1, 9):
            assert piece.phases[0, j] == piece.phases[1, j]
            place = zone.at(float(piece.x[j]), float(piece.y[j]))
            found = vi.periodic(*place, piece.phases[:, j], [0, 1])
            critical = {"flip": -1, "pitchfork": 1, "fold": 1}.get(piece.type)
            if critical:
                assert np.abs(found.multipliers - critical).min() < 1e-6
    assert kinds


def test_units_of_other_weights_part_at_a_branch_point():
    """No symmetry exchanges units of unequal mass, which do the same under loads in proportion."""
    branch = vi.branch(in_step(weights=(1, 2)), "opening", (0.3, 0.8))
    (point,) = of_type(branch, "branch_point")
    assert np.abs(branch[point.index].multipliers - 1).min() < 1e-6
    three = vi.branch(in_step(weights=(1, 1, 1)), "opening", (0.4, 0.8))
    assert len(of_type(three, "branch_point")) == 2


def test_impacts_that_would_part_are_refused_by_name():
    motion = in_step()
    for name in ("opening_0", "mass_1_1"):
        with pytest.raises(
            SingularError, match="close at the same instant, but would not for other"
        ):
            vi.branch(motion, name, (0.5, 1.1))
    with pytest.raises(SingularError, match="close at the same instant, but would not for other"):
        vi.zone(motion, ("frequency", 1.0, 1.2), ("restitution_0", 0.5, 0.9))
    ring, load = cells(weights=(1, 1, 1))
    stiffness = ring.stiffness + np.pad(
        0.05 * np.array([[1, 0, -1], [0, 0, 0], [-1, 0, 1]]), (0, 3)
    )
    ring = vi.Structure(ring.mass, ring.damping, stiffness, ring.gaps)
    motion = vi.exact(ring, load, in_step(weights=(1, 1, 1)))
    with pytest.raises(SingularError, match="are always equal, as for three equal units"):
        vi.branch(motion, "opening", (0.5, 0.7))


def test_impacts_at_one_instant_that_damping_couples_have_no_multipliers():
    """The simulated period is not linear: opposite perturbations do not give opposite changes."""
    motion = in_step(damper=0.01)
    assert motion.admissible
    assert motion.stable is None
    assert np.isnan(motion.multipliers).all()
    assert np.isnan(motion.matrix).all()
    with pytest.raises(SingularError, match="coupled by damping"):
        vi.branch(motion, "opening", (0.5, 0.7))
    for damper, odd in ((0.0, True), (0.01, False)):
        motion = in_step(damper=damper)
        start = (motion.phases[0] - 0.3) / motion.load.frequency
        q, rate = motion.sample([start])
        part = 1e-6 * np.array([1, -1, 0, 0])
        ends = []
        for sign in (-1, 0, 1):
            run = vi.simulate(
                motion.structure, motion.load, cycles=1, start=start,
                state=(q[:, 0] + sign * part, rate[:, 0]),
            )  # fmt: skip
            ends.append(np.concatenate(run.final_state))
        bend = np.abs(ends[0] + ends[2] - 2 * ends[1]).max() / np.abs(ends[2] - ends[0]).max()
        assert bool(bend < 1e-4) is odd, bend


@pytest.mark.parametrize("gaps", [[0, 1], [1, 0]])
def test_impacts_at_one_instant_have_any_order(gaps):
    load = vi.Load(1.6, sine=[0.5, 0.5])
    for apart in (0.0, 1e-3):
        motion = vi.exact(stops(), load, ([2.0, 2.0 + apart], gaps))
        assert motion.admissible
        assert motion.stable
        assert motion.phases[0] == motion.phases[1]


def test_simulations_beyond_a_pitchfork_settle_on_either_image():
    """Below 0.44 there are two stable motions without the symmetry; their zone also ends at the pitchfork."""
    load = vi.Load(0.418, sine=[0.5, -0.5])
    found = []
    for seed in (0, 1):
        rng = np.random.default_rng(seed)
        state = (rng.uniform(-0.5, 0.2, 2), rng.normal(size=2))
        found.append(vi.exact(stops(), load, vi.simulate(stops(), load, cycles=800, state=state)))
    one, other = found
    assert one.stable
    assert np.diff(one.phases) + np.diff(other.phases) == pytest.approx(2 * np.pi, abs=1e-9)
    branch = vi.branch(one, "frequency", (0.38, 0.47))
    ends = [point.value for point in of_type(branch, "pitchfork")]
    assert ends
    symmetric = vi.branch(opposite(), "frequency", (0.4, 1.9))
    places = np.array([point.value for point in of_type(symmetric, "pitchfork")])
    for value in ends:
        assert np.abs(places - value).min() < 1e-8
    zone = vi.zone(one, x=("frequency", 0.38, 0.47), y=("opening", 0.25, 0.35))
    assert zone.contains(0.418, 0.3)
    assert not any(piece.symmetric for piece in zone.boundary)
    lost = [piece for piece in zone.boundary if piece.type == "pitchfork"]
    assert lost
    for piece in lost:
        for j in range(0, len(piece), 9):
            assert np.diff(piece.phases[:, j]) == pytest.approx(np.pi, abs=1e-4)


def test_branches_of_two_dampers_meet():
    """The motion without the symmetry, whose free masses have both displacements, ends at the pitchfork."""
    motion = dampers()
    (pitchfork,) = of_type(vi.branch(motion, "opening", (0.3, 0.8)), "pitchfork")
    phases = np.array([1.3418, 1.6263, 2.25, 2.5022]) * np.pi
    unequal = vi.exact(
        vi.branch(motion, "opening", (0.3, 0.8)).at(0.66)[0], motion.load, (phases, [0, 2, 3, 1])
    )
    ends = of_type(vi.branch(unequal, "opening", (0.6, 0.8)), "pitchfork")
    assert min(abs(end.value - pitchfork.value) for end in ends) < 1e-8
