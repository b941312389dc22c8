"""Random structures with gaps, stops and friction of all kinds: what one function returns is checked by others.

Multipliers are compared with differences of simulations, `periodic` with `exact`, and `gradient` with differences
of `exact`. Events may be of any kind: some R are 0 or 1, walls move, belts and preloads act.
"""

from dataclasses import replace

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.systems.structure import opening_at

#: Largest deviations: of sums of powers of multipliers, of these from differences, and of gradients from these.
EXACT, CLOSE = 1e-7, 1e-5


def drawn(seed):
    """A structure of 1 to 4 masses with 1 to 6 elements, and its load."""
    rng = np.random.default_rng([77, seed])
    n, many = int(rng.integers(1, 5)), int(rng.integers(1, 7))
    B = rng.normal(size=(n, n))
    M = (
        np.diag(rng.uniform(0.3, 2, n))
        if rng.random() < 0.7
        else B @ B.T * 0.2 + np.diag(rng.uniform(0.3, 2, n))
    )
    springs = rng.uniform(0.3, 2, n + 1)
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    held = rng.random() >= 0.15
    K = K * held
    C = rng.choice([0, 0.05, 0.2]) * (K if held else np.eye(n))
    if rng.random() < 0.3:
        A = rng.normal(size=(n, n))
        C = C + 0.03 * A @ A.T
    frequency = rng.uniform(0.5, 3)
    gaps, friction = [], []
    while len(gaps) + len(friction) < many:
        add_element(rng, n, gaps, friction)
    cosine, sine = (rng.uniform(-1.5, 1.5, (2, n)) * [[1], [0.3]] for _ in range(2))
    constant = rng.uniform(-1, 1, n) * (rng.random() < 0.4)
    if rng.random() < 0.1:
        cosine, sine = cosine * 0, sine * 0
    return (
        rng,
        vi.Structure(M, C, K, gaps, friction),
        vi.Load(frequency, cosine=cosine, sine=sine, constant=constant),
    )


def add_element(rng, n, gaps, friction):
    """Draw an element and add it, unless there is friction along its direction."""
    kind = rng.choice(
        ["gap", "stop", "push", "preload", "friction", "belt", "moving gap", "moving stop", "slot"]
    )
    along, places = np.zeros(n), rng.permutation(n)
    along[places[0]] = rng.choice([-1, 1])
    if n > 1 and rng.random() < 0.4:
        along[places[1]] = -along[places[0]]
    elif rng.random() < 0.2:
        along *= rng.uniform(0.5, 2)
    opening = rng.uniform(0.05, 1)
    wall = {}
    if kind.startswith("moving"):
        wall = {name: rng.uniform(-0.02, 0.02, 2) for name in ("cosine", "sine")}

    def taken(speed=None):
        return any(
            abs(
                abs(one.direction @ along)
                / np.sqrt(one.direction @ one.direction * (along @ along))
                - 1
            )
            < 1e-9
            and speed in (None, one.speed)
            for one in friction
        )

    if kind in ("gap", "moving gap"):
        R = float(rng.choice([0, 1, *rng.uniform(0.2, 0.9, 3)]))
        gaps.append(vi.Gap(along, opening, R, **wall))
    elif kind == "slot":
        if not taken():
            gaps.append(vi.Gap(along, opening, float(rng.choice([0, rng.uniform(0.2, 0.9)]))))
            slip = rng.uniform(0.02, 0.3)
            friction.append(vi.Friction(along, slip, slip * float(rng.choice([1, 1.2]))))
    elif kind in ("friction", "belt"):
        slip = rng.uniform(0.02, 0.4)
        speed = 0.0 if kind == "friction" else rng.uniform(0.1, 1) * rng.choice([-1, 1])
        if not taken(speed):
            friction.append(vi.Friction(along, slip, slip * float(rng.choice([1, 1, 1.3])), speed))
    else:
        stiffness, damping = 10 ** rng.uniform(0, 3), float(rng.choice([0, rng.uniform(0, 3)]))
        preload = float(rng.uniform(0.02, 0.3)) if kind == "preload" else 0.0
        release = "force" if kind == "push" or rng.random() < 0.4 else "gap"
        gaps.append(vi.Stop(along, opening, stiffness, damping, preload, release, **wall))


def motion_of(structure, load):
    """The exact motion on which a simulation settles, with its multipliers; None if there is none."""
    try:
        run = vi.simulate(structure, load, cycles=300, discard=200, max_events=30_000)
        motion = vi.exact(structure, load, run)
    except vi.VibroimpactError:
        return None
    return None if not motion.admissible or np.isnan(motion.multipliers).any() else motion


def sums(multipliers):
    """Sums of powers, which are smooth where multipliers meet."""
    return np.array([np.sum(multipliers**j) for j in (1, 2, 3)])


def motions(seeds):
    """Random number generator, structure, load and motion, for seeds with a motion."""
    for seed in seeds:
        try:
            rng, structure, load = drawn(seed)
        except vi.VibroimpactError:
            continue
        motion = motion_of(structure, load)
        if motion is not None:
            yield seed, rng, structure, load, motion


def presumed(structure, load, motion):
    """The motion from the instants of its own events; None where `periodic` does not accept its events."""
    if structure._is_rigid and not len(motion.rests):
        return None
    try:
        run = motion._from_flight()
        events = run.events
        for i, gap in enumerate(structure.gaps):
            # a stop without an event is taken as open
            if isinstance(gap, vi.Stop) and i not in events["gap"]:
                t, q = events["time"][0], run.states[0, 0]
                if gap.direction @ q > opening_at(gap, t, load.frequency):
                    return None
        return vi.periodic(
            structure,
            load,
            events["time"] * load.frequency,
            events["gap"],
            motion.cycles,
            kinds=events["kind"].tolist(),
        )
    except vi.VibroimpactError:
        return None


def of_simulations(structure, load, motion):
    """Matrices of derivatives of the state over a period, by differences with several steps."""
    n = structure.coordinates
    try:
        start, state = motion._run()._between_events()
    except vi.VibroimpactError:
        return []
    if any(abs(one.direction @ state[1] - one.speed) < 1e-9 for one in structure.friction):
        return []

    def end(state):
        run = vi.simulate(
            structure,
            load,
            duration=motion.period,
            start=start,
            state=(state[:n], state[n:]),
            max_events=30_000,
        )
        return np.concatenate(run.final_state)

    found, middle = [], np.concatenate(state)
    for step in (1e-6, 1e-7, 1e-5):
        try:
            both = [
                (end(middle + step * u) - end(middle - step * u)) / (2 * step)
                for u in np.eye(2 * n)
            ]
        except vi.VibroimpactError:
            continue
        found.append(np.array(both).T)
    return found


def changed(structure, load, name, by):
    """The structure and its load with one parameter changed."""
    kind, _, place = name.rpartition("_")
    if not kind:
        return structure, vi.Load(
            load.frequency + by, cosine=load.cosine, sine=load.sine, constant=load.constant
        )
    gaps, friction, i = list(structure.gaps), list(structure.friction), int(place)
    if kind == "slip":
        one = friction[i - len(gaps)]
        stick = one.stick * (one.slip + by) / one.slip
        friction[i - len(gaps)] = vi.Friction(one.direction, one.slip + by, stick, one.speed)
    else:
        attribute = {"contact": "stiffness"}.get(kind, kind)
        gaps[i] = replace(gaps[i], **{attribute: getattr(gaps[i], attribute) + by})
    return vi.Structure(
        structure.mass, structure.damping, structure.stiffness, gaps, friction
    ), load


def parameters_of(structure):
    """Names of parameters of which the derivatives of both sides exist."""
    names = ["frequency"]
    for i, gap in enumerate(structure.gaps):
        names.append(f"opening_{i}")
        if isinstance(gap, vi.Stop):
            names.append(f"contact_{i}")
        elif 0 < gap.restitution < 1:
            names.append(f"restitution_{i}")
    return names + [f"slip_{len(structure.gaps) + i}" for i in range(len(structure.friction))]


def differences(structure, load, motion, name):
    """Derivatives of phases and speeds by differences of exact motions, with several steps."""
    found = []
    for step in (1e-6, 1e-5, 1e-7, 1e-8):
        sides = []
        for by in (step, -step):
            try:
                other = vi.exact(*changed(structure, load, name, by), motion)
            except vi.VibroimpactError:
                break
            if other.gaps.tolist() != motion.gaps.tolist() or len(other.rests) != len(motion.rests):
                break
            sides.append(np.r_[other.phases, other.speeds])
        if len(sides) == 2:
            found.append((sides[0] - sides[1]) / (2 * step))
    return found


def check_presumed(structure, load, motion):
    """Whether `periodic` could be compared, and the multipliers and verdicts are those of the motion."""
    other = presumed(structure, load, motion)
    if other is None:
        return False
    assert other.residual < 1e-11
    assert (other.admissible, other.stable, len(other.rests)) == (
        True,
        motion.stable,
        len(motion.rests),
    )
    if not np.isnan(other.multipliers).any():
        assert np.abs(sums(other.multipliers) - sums(motion.multipliers)).max() < EXACT
    return True


def check_matrix(structure, load, motion):
    """Whether there were differences of simulations, whose traces are those of the multipliers."""
    matrices = of_simulations(structure, load, motion)
    if not matrices:
        return False
    errors = []
    for P in matrices:
        size = max(1, np.abs(P).max())
        one, two, _ = sums(motion.multipliers)
        errors.append(max(abs(np.trace(P) - one) / size, abs(np.trace(P @ P) - two) / size**2))
    assert min(errors) < CLOSE, errors
    return True


def check_gradient(rng, structure, load, motion):
    """Number of parameters for which derivatives were compared with differences."""
    if not motion.stable or np.abs(motion.multipliers).max() > 0.95:
        return 0
    count = 0
    for name in rng.permutation(parameters_of(structure))[:3].tolist():
        try:
            gradient = motion.gradient([name])
        except vi.SingularError:
            continue
        exact = np.r_[gradient["phases", name], gradient["speeds", name]]
        found = differences(structure, load, motion, name)
        if found:
            errors = [np.abs(one - exact).max() / (1 + np.abs(exact).max()) for one in found]
            assert min(errors) < CLOSE, (name, errors)
            count += 1
    return count


def resting(seed):
    """A structure of 2 or 3 masses with a gap with R = 0 and friction, and perhaps a stop; and its load."""
    rng = np.random.default_rng([7, seed])
    n = int(rng.integers(2, 4))
    K = 2 * np.eye(n) - np.diag(np.ones(n - 1), 1) - np.diag(np.ones(n - 1), -1)
    C = rng.uniform(0.05, 0.4) * K
    along = np.zeros(n)
    along[rng.integers(n)] = rng.choice([-1, 1])
    gaps, friction = [vi.Gap(along, rng.uniform(0, 0.4), 0.0)], []
    for _ in range(int(rng.integers(1, 3))):
        along = np.zeros(n)
        along[rng.integers(n)] = 1
        if rng.random() < 0.4:
            along = rng.normal(size=n)
        friction.append(vi.Friction(along, rng.uniform(0.1, 0.6), speed=rng.choice([0, 0.2, -0.3])))
    if rng.random() < 0.4:
        numbers = rng.normal(size=n), rng.uniform(0.1, 0.5), rng.uniform(5, 30), rng.uniform(0, 1)
        gaps.append(vi.Stop(*numbers, release="force"))
    frequency = rng.uniform(0.2, 1)
    load = vi.Load(frequency, cosine=rng.normal(size=n), sine=rng.normal(size=n))
    return vi.Structure(np.eye(n), C, K, gaps, friction), load


def settled_resting(seed):
    structure, load = resting(seed)
    return structure, load, vi.exact(structure, load, vi.simulate(structure, load, cycles=150))


# an impact makes a stop let go; a motion with a rest; a motion of three load cycles
@pytest.mark.parametrize("seed", [364, 463, 10])
def test_functions_agree(seed):
    """Three structures of the test of many."""
    ((_, rng, structure, load, motion),) = motions([seed])
    assert check_presumed(structure, load, motion)
    assert check_matrix(structure, load, motion)
    assert check_gradient(rng, structure, load, motion) == 3


# a stop is touched, and its force ends a rest
@pytest.mark.parametrize("seed", [318, 626, 5384])
def test_a_touch_that_releases_a_gap(seed):
    """A gap that a force releases at once moves with the touch, also with friction along it."""
    structure, load, motion = settled_resting(seed)
    kinds = list(motion._from_flight().events["kind"])
    assert kinds[kinds.index("release") - 1] == "touch"
    assert check_presumed(structure, load, motion)
    assert check_matrix(structure, load, motion)


@pytest.mark.parametrize("seed", [532, 638])
def test_simultaneous_events_in_any_order(seed):
    """Motions in which two elements with friction change at one instant are admissible."""
    structure, load, motion = settled_resting(seed)
    assert motion.admissible
    assert check_presumed(structure, load, motion)
    assert check_matrix(structure, load, motion)


@pytest.mark.slow
def test_functions_agree_for_random_structures(share):
    """Each comparison is possible for many structures, with rests, too, and none fails."""
    count, rests, wrong = np.zeros(3, int), 0, []
    for seed, rng, structure, load, motion in motions(range(share(800))):
        rests += len(motion.rests) > 0
        try:
            count += [
                check_presumed(structure, load, motion),
                check_matrix(structure, load, motion),
                check_gradient(rng, structure, load, motion),
            ]
        except AssertionError as error:
            wrong.append((seed, error))
    assert not wrong, wrong
    assert count.min() > share(250)
    assert rests > share(30)


# a release at the instant at which friction begins to slip
@pytest.mark.parametrize("seed", [5019, 5047, 5184])
def test_friction_that_slips_as_a_gap_is_released(seed):
    """Only impacts make velocities jump; multipliers are those of differences."""
    structure, load, motion = settled_resting(seed)
    start, state = motion._run()._between_events()
    run = vi.simulate(structure, load, duration=motion.period, start=start, state=state)
    events, near = run.events, 1e-7
    hits = events["time"][events["kind"] == "impact"]
    assert {"release", "slip_up", "slip_down"} & set(events["kind"].tolist())
    for time in events["time"]:
        if np.abs(hits - time).min() < near:
            continue
        before, after = run.sample(np.array([time - near, time + near]))[1].T
        assert after == pytest.approx(before, abs=1e-5)
    check_matrix(structure, load, motion)


def doubled(structure, load):
    """Two copies of a structure that do not act on each other, and their load."""
    twice, both = np.eye(2), (1, 1)
    matrices = [
        np.kron(twice, part) for part in (structure.mass, structure.damping, structure.stiffness)
    ]
    gaps, friction = (
        [replace(part, direction=np.kron(side, part.direction)) for part in parts for side in twice]
        for parts in (structure.gaps, structure.friction)
    )
    forces = {name: np.kron(both, getattr(load, name)) for name in ("cosine", "sine", "constant")}
    return vi.Structure(*matrices, gaps, friction), vi.Load(load.frequency, **forces)


def settled_from_rest(structure, load, cycles=150):
    return vi.exact(structure, load, vi.simulate(structure, load, cycles=cycles))


def check_doubled(structure, load, names):
    """Copies move like one structure: twice its events and multipliers, and a parameter moves its own copy."""
    one = settled_from_rest(structure, load)
    both = settled_from_rest(*doubled(structure, load))
    assert both.admissible
    assert both.gaps[np.argsort(both.gaps % 2, kind="stable")] // 2 == pytest.approx(
        np.tile(one.gaps, 2)
    )
    assert sums(both.multipliers) == pytest.approx(2 * sums(one.multipliers), abs=1e-9)
    for name in names:
        word, _, number = name.rpartition("_")
        expected = one.gradient([name])["phases", name]
        for copy in (0, 1):
            own = f"{word}_{2 * int(number) + copy}"
            found = both.gradient([own])["phases", own]
            assert found[both.gaps % 2 == copy] == pytest.approx(expected, abs=1e-8)
            assert found[both.gaps % 2 != copy] == pytest.approx(0, abs=1e-8)


@pytest.mark.parametrize("stick", [0.3, 0.45])
def test_friction_of_two_copies(stick):
    """Friction that begins to slip at two instants apart by rounding does not halt at once."""
    structure = vi.Structure([1], [0.1], [1], friction=[vi.Friction([1], 0.3, stick)])
    load = vi.Load(0.4, cosine=[1])
    check_doubled(structure, load, ["slip_0"])
    both = doubled(structure, load)
    assert check_presumed(*both, settled_from_rest(*both))


def test_impacts_without_rebound_of_two_copies():
    """A gap that parts after an impact with R = 0 does not close by rounding when another one is hit."""
    K = np.array([[4, -2], [-2, 2.5]])
    wall = {"cosine": [0.05], "sine": [0.05]}
    parts = [
        vi.Gap([-1, 1], 0.125, 0, **wall), vi.Gap([0, -1], 0.25, 1),
        vi.Stop([-1, 1], 0.125, 24.2166, release="force"),
    ]  # fmt: skip
    structure = vi.Structure([1, 1], 0.05 * K, K, parts)
    check_doubled(structure, vi.Load(1, cosine=[0.5, 0]), ["opening_1", "opening_0"])


def test_rests_of_two_copies():
    """Rests that end at instants apart by rounding are admissible."""
    check_doubled(*resting(20), ["opening_0"])


def test_friction_along_released_gaps_of_two_copies():
    """Friction along a gap slips with the release of its own gap, also where another one is released."""
    parts = [vi.Gap([-1], 0.125, 0), vi.Stop([-1], 0, stiffness=3.73152, damping=0.5)]
    structure = vi.Structure([1], [0.42], [2], parts, [vi.Friction([1], 0.5)])
    check_doubled(
        structure, vi.Load(1, cosine=[-1], sine=[0.5]), ["opening_0", "slip_2", "contact_1"]
    )


@pytest.mark.parametrize("seed", [14, 107])
def test_gradient_where_friction_slips_as_a_rest_begins(seed):
    """An impact with R = 0 makes friction that sticks slip, and its gap rests before that is reported."""
    structure, load, motion = settled_resting(seed)
    kinds = list(motion._from_flight().events["kind"])
    assert kinds[kinds.index("stick") + 1] in ("slip_up", "slip_down")
    for name in ("frequency", "opening_0", f"slip_{len(structure.gaps)}"):
        gradient = motion.gradient([name])
        exact = np.r_[gradient["phases", name], gradient["speeds", name]]
        found = differences(structure, load, motion, name)
        assert min(np.abs(one - exact).max() for one in found) < CLOSE * (1 + np.abs(exact).max())


def test_reason_without_simultaneous_impacts():
    """Friction that changes at the instant of other friction is not called a graze."""
    _, _, motion = settled_resting(5299)
    assert np.isnan(motion.multipliers).all()
    assert "friction elements change" in motion.without_multipliers


def halves(share, stick, frequency, by="mass"):
    """Two equal masses on springs with friction, coupled by their masses or dashpots; and half of them."""
    parts = {"mass": np.eye(2), "damping": 0.1 * np.eye(2), "stiffness": np.eye(2)}
    parts[by] = parts[by] @ [[1, share], [share, 1]]
    both = vi.Structure(
        **parts, friction=[vi.Friction(side, 0.3, stick=stick) for side in np.eye(2)]
    )
    # in a symmetric motion both are as one that is coupled to itself
    half = {name: part[:1].sum(axis=1, keepdims=True) for name, part in parts.items()}
    one = vi.Structure(**half, friction=[vi.Friction([1], 0.3, stick=stick)])
    return both, vi.Load(frequency, cosine=[1, 1]), one, vi.Load(frequency, cosine=[1])


def settled_halves(*numbers):
    """As `halves`, and the motions of both: in that of the two each event comes twice."""
    structure, load, one, single = halves(*numbers)
    motion, half = settled_from_rest(structure, load), settled_from_rest(one, single)
    assert motion.admissible
    assert len(motion.phases) == 2 * len(half.phases)
    events = half._from_flight().events
    given = vi.periodic(
        structure,
        load,
        np.repeat(events["time"], 2) * load.frequency,
        np.tile([0, 1], len(events)),
        kinds=np.repeat(events["kind"], 2).tolist(),
    )
    assert given.admissible
    assert given.residual < 1e-11
    return structure, load, motion, half, given


def of_nearby(structure, load, motion, by):
    """The derivative of a period where one of the halves is ahead, by differences."""
    start, state = motion._run()._between_events()
    middle, step = np.concatenate(state) + by, 1e-7

    def end(state):
        run = vi.simulate(
            structure, load, duration=motion.period, start=start, state=(state[:2], state[2:])
        )
        return np.concatenate(run.final_state)

    both = [end(middle + step * u) - end(middle - step * u) for u in np.eye(4)]
    return np.array(both).T / (2 * step)


def contains(multipliers, some):
    return all(np.abs(multipliers - one).min() < 1e-9 for one in some)


@pytest.mark.parametrize("stick", [0.3, 0.4])
def test_derivatives_that_depend_on_the_order_of_events(stick):
    """Friction of two halves reverses at one instant: P differs with which is first, multipliers do not."""
    structure, load, motion, half, given = settled_halves(-0.3, stick, 0.8)
    first, second = (
        of_nearby(structure, load, motion, by * np.array([1, -1, 0, 0])) for by in (1e-5, -1e-5)
    )
    assert np.abs(first - second).max() > 0.01
    for P in first, second:
        assert sums(np.linalg.eigvals(P)) == pytest.approx(sums(motion.multipliers), abs=1e-5)
    assert contains(motion.multipliers, half.multipliers)
    assert motion.stable
    for name in ("slip_0", "frequency"):
        with pytest.raises(vi.SingularError, match="depends on their order"):
            motion.gradient([name])
    assert np.isnan(given.multipliers).all()
    assert given.stable is None


@pytest.mark.parametrize("frequency", [0.8, 1.5])
def test_no_multipliers_where_the_order_of_events_decides(frequency):
    """What one half does pushes the other one back across its limit: no order is that of nearby motions."""
    motion = settled_halves(0.3 if frequency < 1 else -0.3, 0.3, frequency)[2]
    assert np.isnan(motion.multipliers).all()
    assert motion.stable is None
    assert "depends on their order" in motion.without_multipliers


def test_halves_that_break_away_together():
    """Dashpots make the rate of the force on one half jump where friction of the other one breaks away."""
    _, _, motion, half, given = settled_halves(0.3, 0.4, 0.4, "damping")
    assert contains(motion.multipliers, half.multipliers)
    assert np.isnan(given.multipliers).all()
    with pytest.raises(vi.SingularError, match="depends on their order"):
        motion.gradient(["slip_0"])


def test_halves_that_slip_without_a_jump():
    """Friction that slips at the force at which it stuck has one derivative, in whatever order."""
    structure, load, motion, half, given = settled_halves(0.3, 0.3, 0.4, "damping")
    assert contains(motion.multipliers, half.multipliers)
    assert sums(given.multipliers) == pytest.approx(sums(motion.multipliers), abs=EXACT)
    assert check_matrix(structure, load, motion)
    slopes = [motion.gradient([name])["phases", name] for name in ("slip_0", "slip_1")]
    own = half.gradient(["slip_0"])["phases", "slip_0"]
    for i in (0, 1):
        # both halves change like one; and one by the other as in a mirror
        assert sum(slopes)[motion.gaps == i] == pytest.approx(own, abs=1e-9)
        mine, others = slopes[0][motion.gaps == i], slopes[1][motion.gaps == 1 - i]
        assert mine == pytest.approx(others, abs=1e-9)
        moved = [vi.exact(*changed(structure, load, "slip_0", by), motion) for by in (1e-6, -1e-6)]
        first, second = (one.phases[one.gaps == i] for one in moved)
        # by one event more or less the phases begin with another halt, which comes every half period
        assert np.mod((first - second + 1) / 2e-6, np.pi / 2e-6) - 1 / 2e-6 == pytest.approx(
            mine, abs=1e-4
        )
