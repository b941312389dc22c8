"""Periodic motions of structures with gaps: laws, published numbers, and independent calculations."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError, ParameterTypeError, SingularError
from vibroimpact.motions.exact import repeats

scipy_linalg = pytest.importorskip("scipy.linalg")
solve_ivp = pytest.importorskip("scipy.integrate").solve_ivp


def damper(xi=0.005, mu=0.042, restitution=0.75, clearance=37.0):
    """The oscillator of the 1983 paper as a structure of two masses."""
    gaps = [
        vi.Gap([-1, 1], clearance / 2, restitution),
        vi.Gap([1, -1], clearance / 2, restitution),
    ]
    return vi.Structure([1, mu], [2 * xi, 0], [1, 0], gaps)


def random_structure(rng, restitution=None):
    """A host of a few modes with free masses between walls, or on springs, and one grounded stop."""
    hosts, masses = int(rng.integers(1, 5)), int(rng.integers(1, 3))
    n = hosts + masses
    a = rng.normal(size=(hosts, hosts))
    mass, damping, stiffness = np.zeros((3, n, n))
    mass[:hosts, :hosts] = np.eye(hosts) + 0.2 * a @ a.T / hosts
    b = rng.normal(size=(hosts, hosts))
    stiffness[:hosts, :hosts] = 0.5 * np.eye(hosts) + b @ b.T
    c = rng.normal(size=(hosts, hosts))
    damping[:hosts, :hosts] = 0.05 * (np.eye(hosts) + c @ c.T)
    gaps = []
    for i in range(hosts, n):
        mass[i, i] = rng.uniform(0.05, 0.4)
        at = int(rng.integers(hosts))
        direction = np.zeros(n)
        direction[i], direction[at] = 1, -1
        kind = rng.integers(3)
        if kind == 1:
            damping[i, i] = rng.uniform(0.001, 0.2)
        if kind == 2:
            k, c = rng.uniform(0.05, 0.5), rng.uniform(0, 0.1)
            part = np.array([[1, -1], [-1, 1]])
            stiffness[np.ix_([i, at], [i, at])] += k * part
            damping[np.ix_([i, at], [i, at])] += c * part
        for side in (1, -1):
            r = rng.uniform(0.3, 0.9) if restitution is None else restitution(rng)
            gaps.append(vi.Gap(side * direction, rng.uniform(0.2, 1.0), r))
    sine, cosine = np.zeros((2, 2, n))
    sine[0, :hosts] = rng.normal(size=hosts)
    cosine[1, :hosts] = 0.3 * rng.normal(size=hosts)
    return vi.Structure(mass, damping, stiffness, gaps), vi.Load(
        rng.uniform(0.4, 2.0), sine=sine, cosine=cosine
    )


def settled(structure, load, cycles=300, most=6):
    """Phases, gaps and cycles of the period at the end of a simulation; None if it is not periodic."""
    run = vi.simulate(structure, load, cycles=cycles)
    period = 2 * np.pi / load.frequency
    if not len(run.events) or (run.events["kind"] != "impact").any() or not run.complete:
        return None
    times, gaps = run.events["time"], run.events["gap"]
    for k in range(1, most + 1):
        last = times > (cycles - k) * period
        before = (times > (cycles - 2 * k) * period) & ~last
        n = int(last.sum())
        if not 0 < n < 25 or n != before.sum() or (gaps[last] != gaps[before]).any():
            continue
        if np.abs(times[last] - times[before] - k * period).max() > 1e-5 * period:
            continue
        start = times[last][0] * load.frequency
        shift = 2 * np.pi * np.floor(start / (2 * np.pi))
        return times[last] * load.frequency - shift, gaps[last].tolist(), k
    return None


def samples(count, seed=0, **options):
    """Exact motions of random structures."""
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(40 * count):
        structure, load = random_structure(rng, **options)
        try:
            guess = settled(structure, load)
        except SingularError:
            continue
        if guess is None:
            continue
        found += 1
        yield vi.exact(structure, load, guess), guess
        if found == count:
            return
    pytest.fail(f"only {found} of {count} random structures have a periodic motion")


def period_map(motion):
    """The derivative of the period, by matrix exponentials and saltation matrices."""
    s = motion.structure
    n = s.coordinates
    inverse = np.linalg.inv(s.mass)
    flow = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ s.stiffness, -inverse @ s.damping]])
    times = np.append(motion.phases, motion.phases[0] + 2 * np.pi * motion.cycles) / (
        motion.load.frequency
    )
    total = np.eye(2 * n)
    for i in range(len(motion.phases)):
        j = (i + 1) % len(motion.phases)
        total = scipy_linalg.expm(flow * (times[i + 1] - times[i])) @ total
        gap = s.gaps[motion.gaps[j]]
        g, r = gap.direction, gap.restitution
        m = 1 / (g @ inverse @ g)
        jump = np.eye(n) - (1 + r) * m * np.outer(inverse @ g, g)
        after = motion.states[j]
        before = after + np.array([np.zeros(n), inverse @ g * motion.impulses[j]])
        phase = times[i + 1] * motion.load.frequency

        def acceleration(state, phase=phase):
            load = motion.load
            force = np.array(load.constant)
            for h in range(len(load.sine)):
                force = force + load.sine[h] * np.sin((h + 1) * phase)
                force = force + load.cosine[h] * np.cos((h + 1) * phase)
            return inverse @ (force - s.damping @ state[1] - s.stiffness @ state[0])

        corner = acceleration(after) - jump @ acceleration(before)
        saltation = np.block(
            [
                [jump, np.zeros((n, n))],
                [np.outer(corner, g) / motion.speeds[j], jump],
            ]
        )
        total = saltation @ total
    return total


def test_table_1_by_the_general_path():
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    reference = vi.exact(osc, 0.94, 37.0, ([0, 1.382 * math.pi], vi.Pattern("RL")))
    # 12 digits of the phases by an independent program
    phases = [0.517272128279 * math.pi, (0.517272128279 + 1.382026495805) * math.pi]
    structure, load = damper(), vi.Load(0.94, sine=[1, 0])
    linear = vi.periodic(structure, load, phases, [0, 1])
    assert linear.residual < 1e-11
    motion = vi.exact(structure, load, linear)
    assert motion.consistent
    assert motion.admissible
    assert motion.stable
    np.testing.assert_allclose(motion.phases, reference.phases, atol=1e-12)
    np.testing.assert_allclose(motion.phases, phases, atol=5e-12)
    np.testing.assert_allclose(motion.q[0], reference.X[0], rtol=1e-12)
    np.testing.assert_allclose(
        motion.speeds, np.abs(reference.X_dot_before - reference.Z_dot_before), rtol=1e-12
    )
    np.testing.assert_allclose(
        np.poly(motion.multipliers), np.poly(reference.multipliers), atol=1e-12
    )


@pytest.mark.parametrize(("pattern", "r", "clearance"), [("RL", 1.04, 25.0), ("RL", 0.95, 40.0)])
def test_oscillator_and_structure_have_the_same_motions(pattern, r, clearance):
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    for reference in vi.equispaced(osc, r, clearance):
        lag = math.atan2(2 * osc.xi * r, 1 - r**2)
        guess = (
            np.mod(reference.tau + lag, 2 * np.pi) + reference.alpha,
            [0, 1],
        )
        motion = vi.exact(damper(0.0114, 0.028, 0.75, clearance), vi.Load(r, sine=[1, 0]), guess)
        # rounding counts relative to the largest entries of [P], and an error of the phases counts 1/v times: one
        # motion has a multiplier of 2e4 and an approach speed of 0.4
        sums = np.poly(reference.multipliers)
        np.testing.assert_allclose(
            np.poly(motion.multipliers), sums, rtol=0, atol=1e-11 * np.abs(sums).max()
        )
        np.testing.assert_allclose(motion.q[0], reference.X[0], rtol=1e-10)
        assert motion.stable == reference.stable
        assert motion.admissible == reference.admissible


def test_published_one_wall_motions():
    # H. Dankowicz and F. Schilder, Recipes for Continuation (SIAM, 2013), example 15.2; the digits by an
    # independent program
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    np.testing.assert_allclose(motion.phases, [0.07595216493831], atol=1e-13)
    np.testing.assert_allclose(motion.speeds, [1.69573294], atol=5e-9)
    np.testing.assert_allclose(motion.multipliers[0].real, -0.58429531, atol=5e-9)
    np.testing.assert_allclose(abs(motion.multipliers[0].imag), 0.00560035, atol=5e-9)
    np.testing.assert_allclose(np.linalg.det(motion.matrix), 0.34143237829831, rtol=1e-12)


@pytest.mark.parametrize(
    ("frequency", "load", "phase", "multiplier", "published"),
    [
        (0.81, 0.3475333974123, 0.078, -1, 0.3475333989),
        (0.799, 0.3628362019809, 0.05, 1, 0.3628362019763),
    ],
)
def test_published_bifurcations_of_the_one_wall_stop(frequency, load, phase, multiplier, published):
    # the last digits by an independent program; published by I. Ghosh and D. J. W. Simpson with VIVID
    wall = vi.Structure([1], [0.04], [1], [vi.Gap([1], 1, 0.9)])
    assert load == pytest.approx(published, abs=2e-9)
    motion = vi.exact(wall, vi.Load(frequency, cosine=[load]), ([phase], [0], 2))
    # near a fold the multiplier moves with the square root of the load
    assert abs(motion.multipliers[0] - multiplier) < (1e-9 if multiplier < 0 else 1e-5)


def test_bouncing_ball_on_a_shaken_plate():
    # relative to the plate, whose acceleration acts as a force: a period T lasts as long as the flight, so the
    # approach speed is g T/(1 + R), and the impulse m g T
    restitution, gravity, frequency, mass = 0.5, 9.81, 12.0, 0.3
    ball = vi.Structure([mass], [0], [0], [vi.Gap([-1], 0, restitution)])
    period = 2 * np.pi / frequency
    load = vi.Load(frequency, sine=[1.5 * mass * gravity], constant=[-mass * gravity])
    motion = vi.exact(ball, load, ([1.0], [0]))
    np.testing.assert_allclose(motion.speeds, gravity * period / (1 + restitution), rtol=1e-13)
    np.testing.assert_allclose(motion.impulses, mass * gravity * period, rtol=1e-13)
    np.testing.assert_allclose(np.prod(motion.multipliers).real, restitution**2, rtol=1e-13)
    assert motion.admissible
    assert motion.stable


@pytest.mark.slow
def test_laws_of_many_random_structures():
    check_laws(150, 5)


def test_laws_of_random_structures():
    check_laws(12, 1)


def check_laws(count, seed):
    for motion, _ in samples(count, seed):
        structure, load = motion.structure, motion.load
        assert motion.consistent
        assert motion.residual < 1e-13
        assert motion.admissible
        # det[P] in closed form
        trace = np.trace(np.linalg.solve(structure.mass, structure.damping))
        restitution = np.array([structure.gaps[i].restitution for i in motion.gaps])
        law = np.exp(-trace * motion.period) * np.prod(restitution**2)
        assert motion.law == pytest.approx(law, rel=1e-10)
        scale = np.prod(np.linalg.norm(motion.matrix, axis=0))
        assert abs(motion.determinant - law) < 1e-11 * law + 1e-14 * scale
        # the derivative by matrix exponentials
        reference = period_map(motion)
        np.testing.assert_allclose(
            motion.matrix, reference, rtol=0, atol=1e-8 * np.abs(reference).max()
        )
        # the simulation returns after a period; an error grows by [P]
        start = motion.phases[0] / load.frequency
        run = vi.simulate(
            structure,
            load,
            duration=0.999999 * motion.period,
            start=start,
            state=(motion.q, motion.q_dot),
        )
        growth = max(1.0, np.abs(motion.matrix).max())
        others = run.events[run.events["speed"] > 0]
        assert others["gap"].tolist() == motion.gaps[1:].tolist()
        np.testing.assert_allclose(
            others["time"] * load.frequency, motion.phases[1:], atol=1e-11 * growth, rtol=1e-13
        )
        # both linear problems give the motion itself
        for full in (False, True):
            linear = vi.periodic(
                structure, load, motion.phases, motion.gaps, motion.cycles, full=full
            )
            largest = max(np.abs(motion.states).max(), motion.speeds.max())
            assert linear.residual < 1e-9
            np.testing.assert_allclose(linear.states, motion.states, rtol=0, atol=1e-8 * largest)


@pytest.mark.slow
def test_the_determinant_of_thousands_of_random_structures(share):
    """det[P] is exp(-tr(M^-1 C) T) times R (R + R'v) of every impact, and 0 with a rest.

    Structures have up to 8 coordinates and six gaps, some with R(v). An error of P counts with the product
    of the lengths of its columns, so the law is known to 1e-11 where that product times 1e-14 is less.
    """
    rng = np.random.default_rng(3)
    precise = rests = 0
    for _ in range(share(3000)):
        structure, load = structure_of_six_gaps(rng)
        try:
            motion = vi.exact(structure, load, vi.simulate(structure, load, cycles=100))
        except SingularError:
            continue
        scale = np.prod(np.linalg.norm(motion.matrix, axis=0))
        if len(motion.rests):
            rests += 1
            assert motion.law == 0
            assert abs(motion.determinant) <= 1e-14 * scale
            continue
        law = np.exp(-np.trace(np.linalg.solve(structure.mass, structure.damping)) * motion.period)
        for i, v in zip(motion.gaps, motion.speeds, strict=True):
            law *= squared(structure.gaps[i].restitution, v)
        assert motion.law == pytest.approx(law, rel=1e-11)
        assert abs(motion.determinant - law) <= 1e-11 * law + 1e-14 * scale
        precise += abs(motion.determinant / law - 1) < 1e-11
    assert precise > share(230)
    assert precise + rests > share(660)


def squared(restitution, v):
    """R (R + R'v), which is R^2 for constant R."""
    if not isinstance(restitution, vi.PowerLaw):
        return restitution**2
    # R = R0 (1 + w)^(-p/k) with w = (v/v0)^k: R'v = -p R w/(1 + w)
    w = (v / restitution.speed) ** restitution.sharpness
    r = restitution.R0 * (1 + w) ** (-restitution.exponent / restitution.sharpness)
    return r * r * (1 - restitution.exponent * w / (1 + w))


def structure_of_six_gaps(rng):
    """A host of up to five modes with up to three free masses, each between two walls with separate R or R(v)."""
    hosts, masses = int(rng.integers(1, 6)), int(rng.integers(1, 4))
    n = hosts + masses
    mass, damping, stiffness = np.zeros((3, n, n))
    a, b, c = rng.normal(size=(3, hosts, hosts))
    mass[:hosts, :hosts] = np.eye(hosts) + 0.2 * a @ a.T / hosts
    stiffness[:hosts, :hosts] = 0.5 * np.eye(hosts) + b @ b.T
    damping[:hosts, :hosts] = 0.05 * (np.eye(hosts) + c @ c.T)
    gaps = []
    for i in range(hosts, n):
        mass[i, i] = rng.uniform(0.05, 0.4)
        damping[i, i] = rng.choice([0, rng.uniform(0.001, 0.2)])
        direction = np.zeros(n)
        direction[i], direction[rng.integers(hosts)] = 1, -1
        for side in (1, -1):
            r = rng.uniform(0.2, 0.8)
            if rng.random() < 0.4:
                r = vi.PowerLaw(r, rng.uniform(0.2, 1), rng.uniform(0.1, 0.4))
            gaps.append(vi.Gap(side * direction, rng.uniform(0.1, 0.6), r))
    sine, cosine = np.zeros((2, 2, n))
    sine[0, :hosts] = rng.normal(size=hosts)
    cosine[1, :hosts] = 0.3 * rng.normal(size=hosts)
    load = vi.Load(rng.uniform(0.4, 2.0), sine=sine, cosine=cosine)
    return vi.Structure(mass, damping, stiffness, gaps), load


def between_forms(motion):
    """The difference of both forms of the linear equations, relative to the largest unknown."""
    arguments = (motion.structure, motion.load, motion.phases, motion.gaps, motion.cycles)
    eliminated, full = (vi.periodic(*arguments, full=full) for full in (False, True))
    largest = max(np.abs(full.states).max(), full.speeds.max())
    return np.abs(eliminated.states - full.states).max() / largest


def test_eliminated_and_full_problem_agree_to_rounding():
    assert max(between_forms(motion) for motion, _ in samples(10, 3)) < 1e-12


def test_both_forms_agree_under_constant_forces():
    """A mass bounces under its weight, which balances the impulses of a period."""
    structure = vi.Structure([[1.0]], [[0.0]], [[0.0]], [vi.Gap([-1], 0.0, 0.9)])
    motion = vi.exact(structure, vi.Load(1.0, sine=[0.3], constant=[-1]), ([0.98], [0]))
    assert between_forms(motion) < 1e-12
    np.testing.assert_allclose(motion.impulses.sum(), motion.period, rtol=1e-12)


@pytest.mark.parametrize("detuning", [1e-1, 1e-3, 1e-5, 1e-7])
def test_both_forms_agree_near_a_resonance_of_the_period(detuning):
    """Accurate to rounding over the least |1 - lambda|, where lambda is the factor of a mode over a period."""
    tested = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        k = rng.uniform(0.05, 0.3)
        gaps = [vi.Gap([-1, 1, 0], 0.5, 0.7), vi.Gap([1, -1, 0], 0.5, 0.7)]
        stiffness = np.array([[1 + k, 0, -k], [0, 0, 0], [-k, 0, 1.7 + k]])
        structure = vi.Structure([1, 0.1, 1], [1e-9, 0, 1e-9], stiffness, gaps)
        modes = np.sqrt(np.linalg.eigvalsh(stiffness[::2, ::2]))
        frequency = modes[0] / 2 * (1 + detuning * rng.uniform(0.5, 1))
        load = vi.Load(frequency, sine=[0.4, 0, 0])
        try:
            guess = (np.sort(rng.uniform(0, 2 * np.pi, 2)), [1, 0])
            motion = vi.exact(structure, load, guess)
        except SingularError:
            continue
        if np.ptp(motion.phases) >= 2 * np.pi:
            continue
        left = np.abs(2 * np.sin(np.pi * modes / frequency)).min()
        assert between_forms(motion) < 20 * np.finfo(float).eps / min(left, 1)
        tested += 1
    assert tested > 0


def test_newton_converges_from_displaced_times():
    rng = np.random.default_rng(2)
    for motion, _ in samples(8, 4):
        spread = 0.01 * 2 * np.pi * motion.cycles / len(motion.phases)
        phases = np.sort(motion.phases + spread * rng.uniform(-1, 1, len(motion.phases)))
        again = vi.exact(motion.structure, motion.load, (phases, motion.gaps, motion.cycles))
        np.testing.assert_allclose(again.phases, motion.phases, atol=1e-9)


@pytest.mark.parametrize(
    ("damping", "openings", "frequency", "guess"),
    [
        (0.10724610869304878, (1.905881023019277, 0.37390326416730413), 1.933244281278417,
         ([2.833960902558731, 5.995109660626247, 6.014857902973205], [1, 0, 1], 1)),
        (0.08799886545860716, (1.087069839694326, 0.815399085691861), 1.3291233384355157,
         ([1.2954381360635243, 1.8861687909808849], [1, 0], 2)),
    ],
)  # fmt: skip
def test_impacts_that_newton_exchanges_are_no_motion(damping, openings, frequency, guess):
    """Poor guesses from which steps lead to descending phases, or to phases more than a period apart."""
    gaps = [vi.Gap([1, -1], openings[0], 0.7), vi.Gap([-1, 1], openings[1], 0.7)]
    host = vi.Structure([1, 0.1], np.diag([damping, 0]), np.diag([1, 0]), gaps)
    with pytest.raises(vi.SingularError, match="did not converge"):
        vi.exact(host, vi.Load(frequency, sine=[1, 0]), guess)


def test_restitution_that_depends_on_the_speed():
    def law(rng):
        return vi.PowerLaw(rng.uniform(0.6, 0.95), rng.uniform(0.2, 1.0), rng.uniform(0.1, 0.5))

    for motion, guess in samples(6, 7, restitution=law):
        step = 1e-6
        values = []
        for i, speed in zip(motion.gaps, motion.speeds, strict=True):
            r = motion.structure.gaps[i].restitution
            slope = (r(speed * (1 + step)) - r(speed * (1 - step))) / (2 * speed * step)
            values.append(r(speed) * (r(speed) + slope * speed))
        trace = np.trace(np.linalg.solve(motion.structure.mass, motion.structure.damping))
        law_value = np.prod(values) * np.exp(-trace * motion.period)
        assert motion.law == pytest.approx(law_value, rel=1e-8)
        scale = np.prod(np.linalg.norm(motion.matrix, axis=0))
        assert abs(motion.determinant - motion.law) < 1e-11 * abs(motion.law) + 1e-14 * scale
        with pytest.raises(ParameterError, match="restitution"):
            vi.periodic(motion.structure, motion.load, *guess)


def test_sample_is_periodic_and_meets_the_walls():
    structure, load = damper(), vi.Load(0.94, sine=[1, 0])
    motion = vi.exact(structure, load, ([1.62, 5.97], [0, 1]))
    t = np.linspace(-7, 20, 23)
    q, q_dot = motion.sample(t)
    again, again_dot = motion.sample(t + 3 * motion.period)
    np.testing.assert_allclose(q, again, atol=1e-11)
    np.testing.assert_allclose(q_dot, again_dot, atol=1e-11)
    q, q_dot = motion.sample(motion.phases / load.frequency)
    np.testing.assert_allclose(q[1] - q[0], [18.5, -18.5], rtol=1e-13)
    np.testing.assert_allclose(q_dot.T, motion.states[:, 1], rtol=1e-12)


def test_a_motion_through_a_wall_is_not_admissible():
    # one impact in six cycles solves the equations, but the mass would be far behind the wall in between
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 0.1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0], 6))
    assert motion.consistent
    assert motion.admissible is False


def test_the_oscillator_as_a_structure():
    """With constant R the motion equals that of the oscillator; with laws det[P] and the impact energies agree."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=(0.75, 0.7))
    load = vi.Load(0.94, sine=[1, 0])
    plain = vi.exact(osc, 0.94, 37.0, ([0, 4.4], "RL"))
    same = vi.exact(osc.structure(37.0), load, ([1.6, 6.0], [0, 1]))
    assert np.ptp(same.phases) == pytest.approx(np.ptp(plain.phases), rel=1e-11)
    np.testing.assert_allclose(
        np.sort(np.abs(same.multipliers)), np.sort(np.abs(plain.multipliers)), rtol=1e-9
    )
    flat = vi.exact(osc.structure(37.0, vi.PowerLaw(0.75, 20, 0)), load, same)
    even = vi.exact(osc.structure(37.0, 0.75), load, same)
    np.testing.assert_allclose(flat.phases, even.phases, rtol=1e-14)
    law = vi.PowerLaw(0.75, speed=20, exponent=0.25)
    table = vi.TabulatedRestitution([0, 10, 40, 100], [0.8, 0.78, 0.7, 0.5])
    motion = vi.exact(osc.structure(37.0, (law, table)), load, same)
    assert motion.consistent
    effective = 0.042 / 1.042
    product = 1.0
    for gap, speed, impulse, state in zip(
        motion.gaps, motion.speeds, motion.impulses, motion.states, strict=True
    ):
        of = (law, table)[gap]
        r, slope = float(of(speed)), float(of.slope(speed))
        product *= r * (r + slope * speed)
        assert impulse == pytest.approx((1 + r) * effective * speed, rel=1e-14)
        after = state[1]
        before = after + impulse * motion.structure.gaps[gap].direction / [1, 0.042]
        lost = 0.5 * ([1, 0.042] @ (before**2 - after**2))
        assert lost == pytest.approx(0.5 * effective * (1 - r**2) * speed**2, rel=1e-11)
    assert motion.determinant == pytest.approx(
        product * math.exp(-2 * 0.005 * motion.period), rel=1e-10
    )


@pytest.mark.parametrize(("words", "wanted"), [
    ({"clearance": 0}, "clearance = 0"), ({"clearance": 1.0, "restitution": 2}, "restitution"),
])  # fmt: skip
def test_bad_oscillators_as_structures(words, wanted):
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    with pytest.raises(ParameterError, match=wanted):
        osc.structure(**words)
    with pytest.raises(ParameterError, match="mu = 0"):
        vi.Oscillator(xi=0.005, mu=0, restitution=0.75).structure(1.0)


@pytest.mark.parametrize("drag", [0.0, 1e-4, 1e-3])
def test_fifty_periods_of_a_motion(drag):
    """Its multipliers are powers; the response to damping is a series for one period and not for fifty."""
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    host = vi.Structure([1.0, 0.1], [0.02, drag], [1.0, 0.0], gaps)
    load = vi.Load(1.1, sine=[0.1, 0.0])
    once = vi.exact(host, load, ([1.64, 4.78], [1, 0]))
    phases = once.phases + 2 * np.pi * np.arange(50)[:, None]
    many = vi.exact(host, load, (phases.ravel(), np.tile(once.gaps, 50), 50))
    np.testing.assert_allclose(many.phases, phases.ravel(), atol=1e-10)
    np.testing.assert_allclose(
        many.matrix, np.linalg.matrix_power(once.matrix, 50), atol=1e-9 * np.abs(once.matrix).max()
    )


def test_a_motion_is_drawn_by_its_own_flights():
    """The picture has the motion's own flights, as a simulation would leave an unstable or inadmissible motion."""
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 0.1, 0.8)])
    load = vi.Load(1.0, cosine=[1])
    through = vi.exact(wall, load, ([0.1], [0], 6))
    presumed = vi.periodic(damper(), vi.Load(0.94, sine=[1, 0]), [1.9, 5.9], [0, 1])
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    host = vi.Structure([1.0, 0.1], [0.02, 0.0], [1.0, 0.0], gaps)
    found = vi.find(host, vi.Load(1.1, sine=[0.1, 0.0]), max_cycles=1, states=0, guesses=64)
    unstable = max(found, key=lambda motion: abs(motion.multipliers[0]))
    assert abs(unstable.multipliers[0]) > 1000
    for motion in (through, presumed, unstable):
        run = motion._run()
        n = len(motion.phases)
        assert run.events["gap"].tolist() == [*motion.gaps[1:], motion.gaps[0]]
        np.testing.assert_array_equal(run.states[: n - 1], motion.states[1:])
        begin, end = run.start, run.events["time"][0]
        t = np.linspace(begin, end, 9)[1:-1]
        state = motion.states[0].ravel()
        s, force = motion.structure, motion.load

        def rate(time, y, s=s, force=force):
            q, q_dot = np.split(y, 2)
            angle = force.frequency * time
            f = force.sine[0] * np.sin(angle) + force.cosine[0] * np.cos(angle)
            return np.append(
                q_dot, np.linalg.solve(s.mass, f - s.damping @ q_dot - s.stiffness @ q)
            )

        free = solve_ivp(rate, (begin, end), state, t_eval=t, rtol=1e-11, atol=1e-12).y
        sampled = np.concatenate(motion.sample(t + 4 * motion.period))
        np.testing.assert_allclose(sampled, free, atol=1e-8 * np.abs(free).max())
        times, line = motion.plot(kind="history").lines[0].get_data()
        np.testing.assert_array_equal(line, run.sample(times)[0][0])


REFUSED = [
    ({"phases": [0.5]}, "phases"),
    ({"phases": [4.0, 0.5]}, "phases"),
    ({"phases": [0.5, 7.0]}, "phases"),
    ({"phases": [0.5, math.nan]}, "phases"),
    ({"phases": [1e9, 1e9 + 1]}, "phases"),
    ({"phases": [], "gaps": []}, "gaps"),
    ({"gaps": [0, 2]}, "gaps"),
    ({"gaps": [0, -1]}, "gaps"),
    ({"gaps": [0, 0.5]}, "gaps"),
    ({"cycles": 0}, "cycles"),
    ({"cycles": 1.5}, "cycles"),
]


@pytest.mark.parametrize(("change", "name"), REFUSED)
def test_refused_arguments(change, name):
    values = {"phases": [1.6, 5.9], "gaps": [0, 1], "cycles": 1} | change
    with pytest.raises((ParameterError, ParameterTypeError), match=name):
        vi.periodic(damper(), vi.Load(0.94, sine=[1, 0]), **values)
    with pytest.raises((ParameterError, ParameterTypeError), match=name):
        vi.exact(damper(), vi.Load(0.94, sine=[1, 0]), tuple(values.values()))


def test_refused_loads_and_guesses():
    with pytest.raises(ParameterTypeError, match="load"):
        vi.exact(damper(), None, ([1.6, 5.9], [0, 1]))
    with pytest.raises(ParameterError, match="load for 3 coordinates"):
        vi.exact(damper(), vi.Load(1.0, sine=[1, 0, 0]), ([1.6, 5.9], [0, 1]))
    with pytest.raises(ParameterError, match="guess"):
        vi.exact(damper(), vi.Load(1.0, sine=[1, 0]), 3)


@pytest.mark.parametrize("full", [False, True])
def test_a_mean_force_that_nothing_balances(full):
    """The free mass is pushed to the right wall, but only the left one is hit; a free body hits no wall."""
    load = vi.Load(0.94, sine=[1, 0], constant=[0, 0.1])
    with pytest.raises(SingularError, match="frequency 0"):
        vi.periodic(damper(), load, [1.6], [1], full=full)
    with pytest.raises(SingularError, match="frequency 0"):
        vi.exact(damper(), load, ([1.6], [1]))
    assert vi.periodic(damper(), load, [1.6], [0], full=full).speeds[0] > 0
    between = [vi.Gap([1, -1], 0.3, 0.7), vi.Gap([-1, 1], 0.3, 0.7)]
    free = vi.Structure([1, 1], [0, 0], [0, 0], between)
    load = vi.Load(1.0, sine=[1, 0], constant=[0.1, 0.2])
    with pytest.raises(SingularError, match="frequency 0"):
        vi.periodic(free, load, [0.5, 3.6], [0, 1], full=full)
    found = vi.find(free, load, states=2, max_impacts=2, max_cycles=1, guesses=2)
    assert not len(found)
    assert any("frequency 0" in reason for reason in found.failures)


def test_impacts_at_once_on_one_gap_are_refused():
    with pytest.raises(ParameterError, match=r"phases.*0 and 1 are simultaneous on gap 1"):
        vi.periodic(damper(), vi.Load(0.94, sine=[1, 0]), [1.6, 1.6], [1, 1])


def test_a_branch_without_bounds_is_refused():
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, 0.8)])
    motion = vi.exact(wall, vi.Load(1.0, cosine=[1]), ([0.1], [0]))
    with pytest.raises(ParameterError, match="bounds = None"):
        vi.branch(motion, "frequency")


def test_resonance_with_the_period_is_refused():
    structure = damper(xi=0.0)
    with pytest.raises(SingularError, match="resonates"):
        vi.periodic(structure, vi.Load(1.0, sine=[0, 0.1]), [1.6, 5.9], [0, 1])


@pytest.mark.parametrize("seed", range(12))
def test_a_mode_that_no_gap_meets_has_no_part_in_the_equations(seed):
    """A mode of frequency 0 that no gap moves, except by rounding, does not enter the equations."""
    spread = 0.1 * np.random.default_rng(seed).normal(size=(3, 3))
    gaps = [vi.Gap([1, 0, 0], 0.3, 0.7), vi.Gap([0, -1, 0], 0.3, 0.7)]
    structure = vi.Structure(np.eye(3) + spread @ spread.T, [0.1, 0.1, 0.1], [1, 1.5, 0], gaps)
    load = vi.Load(1.1, cosine=[0.5, 0.3, 0.2])
    run = vi.simulate(structure, load, cycles=400)
    motion = vi.exact(structure, load, run)
    assert motion.consistent
    assert np.abs(motion.states).max() < 1e3
    last = run.events["speed"][-len(motion.speeds) :]
    np.testing.assert_allclose(np.sort(motion.speeds), np.sort(last), rtol=1e-6)
    # the position of that body is free, so one multiplier is 1
    assert np.abs(motion.multipliers - 1).min() < 1e-9
    assert motion.stable is None


def test_exact_from_a_simulation_with_a_steep_law():
    law = vi.TabulatedRestitution([0, 0.3, 1, 3], [0.9, 0.7, 0.6, 0.3])
    wall = vi.Structure([1], [0.1], [1], [vi.Gap([1], 1, law)])
    load = vi.Load(0.5847457627118644, cosine=[3.0])
    run = vi.simulate(wall, load, cycles=300)
    motion = vi.exact(wall, load, run)
    assert motion.admissible
    assert motion.stable
    n = len(motion.speeds)
    np.testing.assert_allclose(np.sort(motion.speeds), np.sort(run.events["speed"][-n:]), rtol=1e-8)


def test_a_load_without_frequency_has_no_period():
    with pytest.raises(ParameterError, match="must have a frequency"):
        vi.exact(damper(), vi.Load(None, constant=[1, 0]), ([1.6, 5.9], [0, 1]))


@pytest.mark.parametrize(
    ("frequency", "beyond", "of"), [(0.94, 0.915, "mirror image"), (None, None, "shorter period")]
)
def test_a_motion_is_lost_beyond_its_bifurcation(frequency, beyond, of):
    """Newton's method would find the motion that remains beyond a pitchfork or a flip: an error instead."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    uneven = vi.exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], vi.Pattern("RL")))
    if frequency:
        own, near, gone = uneven, damper(), damper()
        loads = [vi.Load(f, sine=[1, 0]) for f in (frequency, beyond)]
    else:
        points = vi.branch(uneven, "clearance", (34, 37)).special_points
        flip = next(point for point in points if point.type == "flip")
        (own,) = flip.switch()
        near = damper(clearance=own.clearance)
        gone = damper(clearance=2 * flip.clearance - own.clearance)
        loads = [vi.Load(0.94, sine=[1, 0])] * 2
    gaps = [0 if side == "R" else 1 for side in own.pattern.sides]
    guess = (own.phases, gaps, own.pattern.cycles)
    motion = vi.exact(near, loads[0], guess)
    assert motion.consistent
    assert np.abs(motion.q - [own.X[0], own.Z[0]]).max() < 1e-9
    with pytest.raises(SingularError, match=of):
        vi.exact(gone, loads[1], motion)


@pytest.mark.parametrize("phase", [2.63, 3.65])
def test_a_ball_whose_wall_is_at_0(phase):
    """Where all coordinates are 0 at the impacts, the period is known, and derivatives are those of one impact."""
    ball = vi.Structure([1], [0.02], [0], [vi.Gap([1], 0.0, 0.6)])
    load = vi.Load(1.0, sine=[0.9], constant=[1.0])
    one = vi.exact(ball, load, ([phase], [0]))
    two = vi.exact(ball, load, ([phase, phase + 2 * np.pi], [0, 0], 2))
    assert np.abs(two.states[:, 0]).max() < 1e-13
    assert repeats(two, 1)
    assert not repeats(one, 1)
    for name in ("phases", "speeds", "q_dot"):
        twice = np.concatenate([one.gradient()[name]] * 2)
        size = np.abs(twice).max()
        assert two.gradient()[name] == pytest.approx(twice, rel=1e-9, abs=1e-9 * size), name
