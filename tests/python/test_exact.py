"""Exact motions: Newton's method, its derivative and its verdicts."""

import math

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN, POINTS, after_impact, motions, rest_motion, system_of
from shared_simulations import plain, signs, state
from shared_systems import TABLE, TURN


def equations(system, clearance, amplitude, u):
    """Return the mismatch of positions and velocities, the unknowns being X and theta = phase + tau."""
    n = len(system.sides)
    one = np.ones_like(u[0]) * amplitude / clearance
    return fp.mismatch(system, u[n:], u[:n] / clearance, one, 0 * one) * clearance


def newton_steps(system, clearance, amplitude, u, most=30):
    """Sizes of the steps of Newton's method with the derivative by complex step."""
    sizes, scale = [], np.repeat([clearance, 1.0], len(system.sides))
    for _ in range(most):
        u = np.asarray(u, float)
        probe = u[:, None] + 1j * fp.STEP * np.eye(u.size)
        jacobian = equations(system, clearance, amplitude, probe).imag / fp.STEP
        step = -np.linalg.solve(jacobian, equations(system, clearance, amplitude, u))
        u = u + step
        sizes.append(np.abs(step / scale).max())
        if sizes[-1] < 1e-13:
            break
    return u, sizes


def core_exact(motion, x, theta, most):
    """Call the compiled Newton's method itself; returns its status and number of iterations."""
    out = vi._core.exact(
        motion.osc.xi,
        motion.osc.mu,
        motion.osc.restitution,
        motion.r,
        motion.load,
        motion.clearance,
        motion.pattern.cycles,
        motion.pattern.signs,
        motion.restitution,
        x,
        theta,
        most,
    )
    return out[0], out[1], out[-2], out[-1]


@pytest.mark.parametrize("point", POINTS)
def test_converges_quadratically(point):
    """The number of iterations is that of Newton's method with the exact derivative.

    Steps with the derivative by complex step converge quadratically; the package stops one step after a step
    below 1e-7, and needs as many. A slightly wrong derivative would need more.
    """
    seen = 0
    for motion in motions(*point)[:6]:
        system, draw = system_of(motion), np.random.default_rng(7)
        exact = np.concatenate([motion.X, motion.alpha + motion.tau])
        for size in (1e-2, 1e-3, 1e-4):
            scale = np.repeat([motion.clearance, 1.0], motion.X.size)
            u = exact + size * scale * draw.uniform(-1, 1, exact.size) / motion.pattern.cycles
            end, steps = newton_steps(system, motion.clearance, motion.A, u)
            if not np.allclose(end, exact, atol=1e-9) or max(steps) > 20 * size:
                continue
            small = [s for s in steps if s > 1e-7]
            ratios = [b / a**2 for a, b in zip(small, steps[1:], strict=False)]
            assert max(ratios) < 1e5
            phases, impacts, status, count = core_exact(
                motion, u[: u.size // 2], u[u.size // 2 :], 50
            )
            assert status == 0
            assert abs(count - (len(small) + 2)) <= 1
            assert phases == pytest.approx(motion.alpha, abs=1e-11)
            assert impacts[:, 0] == pytest.approx(motion.X, abs=1e-11 * motion.clearance)
            assert core_exact(motion, u[: u.size // 2], u[u.size // 2 :], count - 1)[2] != 0
            seen += 1
    assert seen >= 6


@pytest.mark.parametrize("point", POINTS)
def test_both_halves_agree(point):
    """The phases of an exact motion solve the linear problem too, with the same multipliers."""
    found = motions(*point)
    assert found
    for motion in found:
        assert motion.residual <= 1e-12
        half = math.pi * motion.pattern.cycles
        if len(motion.pattern) == 2 and abs(motion.alpha[1] - half) < 1e-9:
            continue  # equispaced: the amplitude is free
        linear = vi.periodic(motion.osc, motion.r, motion.alpha, motion.pattern)
        assert linear.residual <= 1e-12
        assert linear.clearance == pytest.approx(motion.clearance, rel=1e-8)
        assert linear.X == pytest.approx(motion.X, abs=1e-8 * motion.clearance)
        worst = np.abs(motion.multipliers).max()
        assert linear.multipliers == pytest.approx(motion.multipliers, abs=1e-8 * worst)
        assert linear.admissible == motion.admissible


@pytest.mark.parametrize("point", POINTS)
def test_reference_agrees(point):
    """The independent mismatch vanishes, and the multipliers are those of its maps."""
    osc, r, _ = point
    for motion in motions(*point):
        system = system_of(motion)
        wave = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
        off = fp.mismatch(
            system, motion.alpha, motion.X / motion.clearance, *np.divide(wave, motion.clearance)
        )
        assert np.abs(off).max() <= 1e-12
        maps = fp.impact_jacobians(
            system, motion.alpha, motion.X, motion.X_dot_after, motion.Z_dot_after, *wave
        )
        product = np.linalg.multi_dot([np.eye(4), *maps[::-1]])
        determinant = math.exp(-4 * math.pi * osc.xi * motion.pattern.cycles / r)
        determinant *= np.prod(motion.restitution**2)
        size = np.abs(motion.multipliers).max()
        assert np.prod(motion.multipliers).real == pytest.approx(determinant, abs=1e-10 * size)
        assert np.sum(motion.multipliers).real == pytest.approx(np.trace(product), abs=1e-9 * size)
        assert motion.stable == (size < 1)
        assert motion.consistent
        assert motion.A == pytest.approx(system.amplitude, rel=1e-14)


def test_every_kind_of_guess_leads_to_the_same_motion():
    """Phases and pattern, a nearby motion, and a trajectory give the same exact motion, at d = 37 of Table 1."""
    first = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    near = vi.exact(TABLE, 0.94, 37.0, vi.exact(TABLE, 0.945, 36.0, COLUMN))
    paper = vi.exact(TABLE, 0.94, 37.0, vi.periodic(TABLE, 0.94, *COLUMN))
    run = vi.simulate(TABLE, 0.94, 37.0, 8, after_impact(first), discard=100.3)
    settled_run = vi.exact(TABLE, 0.94, 37.0, run)
    for other in (near, paper, settled_run):
        shift = int(other.pattern.symbols[0] != first.pattern.symbols[0])
        phases = np.append(other.alpha, other.alpha[0] + TURN)[shift : shift + 2]
        assert phases - phases[0] == pytest.approx(first.alpha, abs=1e-10)
        assert np.roll(other.X, -shift) == pytest.approx(first.X, abs=1e-9)
        assert other.residual <= 1e-12
        assert other.stable
        assert other.admissible
        assert other.multipliers == pytest.approx(first.multipliers, abs=1e-8)
    assert first.alpha[1] / math.pi == pytest.approx(1.382026, abs=1e-6)


@pytest.mark.parametrize("part", [0.0, 1e-13, -1e-13, 0.25, 0.5, 0.9])
@pytest.mark.parametrize("impact", [0, 1])
def test_a_trajectory_may_end_at_an_impact(impact, part):
    """The result does not depend on the part of the period at which a trajectory ends, even at an impact."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    run = vi.simulate(TABLE, 0.94, 37.0, 8 + part, after_impact(motion, impact))
    again = vi.exact(TABLE, 0.94, 37.0, run)
    assert again.pattern.cycles == 1
    assert sorted(again.pattern.symbols) == ["L", "R"]
    assert np.sort(again.X) == pytest.approx(np.sort(motion.X), abs=1e-9)


def test_a_rest_at_the_start_of_a_trajectory_is_none_of_its_end():
    """A release at the start of a trajectory does not prevent its motion without rest from being found."""
    start = state(0.0, 11.1, 0.0, 11.1 + 18.5, 0.0)
    run = vi.simulate(TABLE, 0.94, 37.0, 1500, start)
    kinds = run.events["kind"].tolist()
    assert kinds[0] == "release"
    assert "release" not in kinds[1:]
    known = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    motion = vi.exact(TABLE, 0.94, 37.0, run)
    assert np.sort(np.abs(motion.X)) == pytest.approx(np.sort(np.abs(known.X)), abs=1e-9)
    period = run.period()
    assert period.pattern == motion.pattern
    assert period.mismatch < 1e-8
    assert period.events["x"] == pytest.approx(motion.X, abs=1e-8)
    assert np.isin(period.events["time"], run.events["time"][-2 * len(motion.pattern) - 1 :]).all()


@pytest.mark.parametrize("most", [1, 2])
def test_the_period_of_a_doubled_motion(most):
    """Past the flip at 34.9648 a simulation repeats itself after two cycles, and not within one."""
    clearance = 34.955
    near = after_impact(vi.exact(TABLE, 0.94, 35.5, COLUMN))
    near["z"] = near["x"] + clearance / 2
    run = vi.simulate(TABLE, 0.94, clearance, 40, near, discard=8000)
    if most == 1:
        with pytest.raises(vi.errors.ParameterError, match="1 load cycles"):
            run.period(most, 1e-6)
        return
    assert run.period(most, 1e-6).pattern.cycles == 2
    # to within 0.05 it repeats itself after one cycle, which is not the period of the motion
    assert run.period().pattern.cycles == 1
    motion = vi.exact(TABLE, 0.94, clearance, run)
    assert motion.pattern.cycles == 2
    assert motion.stable
    found = vi.find(TABLE, 0.94, clearance, max_impacts=4, max_cycles=2)
    assert sum(item.stable and item.pattern.cycles == 2 for item in found) >= 1


@pytest.mark.parametrize("factor", [2.0, 10.0, 0.01])
def test_load_scales_the_motion(factor):
    """Scaling f and the clearance by a factor leaves phases and multipliers unchanged, and scales lengths."""
    one = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    other = vi.exact(TABLE, 0.94, 37.0 * factor, COLUMN, load=factor)
    assert other.load == factor
    assert other.alpha == pytest.approx(one.alpha, abs=1e-12)
    assert other.multipliers == pytest.approx(one.multipliers, abs=1e-9)
    assert other.X / factor == pytest.approx(one.X, abs=1e-10)
    assert other.A == pytest.approx(factor * one.A)
    assert other.x_max == pytest.approx(factor * one.x_max)
    times = np.linspace(0, one.period, 50)
    assert other.sample(times).load == pytest.approx(factor * one.sample(times).load, abs=1e-9)


def test_inadmissible_motions_are_returned_and_flagged():
    """A solution of the equations that passes a wall is returned with `admissible` False."""
    draw, flagged = np.random.default_rng(3), 0
    for i in range(120):
        sides = ["RRL", "RRLL", "RLRL", "RRRL"][i % 4]
        cycles = 1 + i % 2
        inner = np.sort(draw.uniform(0.3, TURN * cycles - 0.3, len(sides) - 1))
        phases = np.concatenate([[0.0], inner])
        try:
            motion = vi.exact(TABLE, 0.94, 37.0, (phases, vi.Pattern(sides, cycles)))
        except vi.errors.SingularError:
            continue
        assert motion.residual <= 1e-12
        history = motion.sample(np.linspace(0, motion.period, 5001))
        through = np.abs(history.Y).max() > 18.5 * (1 + 1e-9)
        side = motion.pattern.signs
        leaves = np.any(side * (motion.Z_dot_before - motion.X_dot_before) <= 0)
        assert motion.admissible == (not through and not leaves)
        flagged += not motion.admissible
    assert flagged > 0


def test_no_convergence_says_so():
    """Where there is no motion, an error reports that the iteration did not converge."""
    failed = 0
    for clearance in (1e6, 1e9):
        with pytest.raises(vi.errors.SingularError) as caught:
            vi.exact(TABLE, 0.94, clearance, COLUMN)
        assert isinstance(caught.value, ArithmeticError)
        failed += "converge" in str(caught.value) or "no" in str(caught.value)
    assert failed == 2
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    assert core_exact(motion, motion.X + 0.3, motion.alpha + motion.tau, 1)[2] != 0
    assert np.isnan(core_exact(motion, motion.X + 0.3, motion.alpha + motion.tau, 1)[1]).all()


@pytest.mark.parametrize("guess", [None, 3, "RL", [0.0, 4.0], ([0.0, 4.0], 7), (1, 2, 3), {}])
def test_guess_types(guess):
    """An argument that is not a guess is refused; the message lists the allowed ones."""
    with pytest.raises(vi.errors.ParameterTypeError, match="guess") as caught:
        vi.exact(TABLE, 0.94, 37.0, guess)
    assert repr(guess) in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [
    ("r", -1.0), ("r", math.nan), ("clearance", 0.0), ("clearance", math.inf), ("load", -1.0),
    ("load", math.nan),
])  # fmt: skip
def test_values(name, value):
    """Numbers outside their ranges are refused, with the name and the value."""
    good = {"osc": TABLE, "r": 0.94, "clearance": 37.0, "guess": COLUMN}
    with pytest.raises(vi.errors.ParameterError, match=name) as caught:
        vi.exact(**good | {name: value})
    assert str(value) in str(caught.value)


def test_phases_of_a_guess_are_checked():
    """Phases are checked as in `periodic`; with a pattern that has a star they are refused."""
    with pytest.raises(vi.errors.ParameterError, match="phases"):
        vi.exact(TABLE, 0.94, 37.0, ([0.0, 9.0], vi.Pattern("RL")))
    with pytest.raises(vi.errors.ParameterError, match="star"):
        vi.exact(TABLE, 0.94, 37.0, ([0.0, 3.0], vi.Pattern("RL*")))


def test_no_exact_motion_without_load():
    """With f = 0 there is no periodic motion; the result is an error or a motion at rest, not NaN."""
    with pytest.raises(vi.errors.VibroimpactError):
        vi.exact(TABLE, 0.94, 37.0, COLUMN, load=0.0)


@pytest.mark.parametrize("cycles", [1, 3, 20])
def test_trajectory_that_does_not_repeat(cycles):
    """A transient cannot be a guess; the message explains what to do."""
    run = vi.simulate(TABLE, 0.94, 37.0, cycles, state(x_dot=9.0, z_dot=-4.0))
    with pytest.raises(vi.errors.ParameterError, match=r"guess.*period"):
        vi.exact(TABLE, 0.94, 37.0, run)
    quiet = vi.simulate(TABLE, 0.94, 1e5, 40)
    with pytest.raises(vi.errors.ParameterError, match="guess"):
        vi.exact(TABLE, 0.94, 37.0, quiet)


@pytest.mark.parametrize("as_structure", [False, True])
def test_a_simulation_that_may_not_have_settled_is_named_as_the_reason(as_structure):
    rig = vi.Oscillator.from_dimensional(M=2.7, K=42e3, xi=0.011, m=0.11, restitution=0.75, F0=6.0)
    point = rig.at("19.5 Hz", "4 mm")
    system = (point.structure, point.load) if as_structure else (point,)
    run = vi.simulate(*system, cycles=200, discard=200)
    with pytest.raises(vi.SingularError, match="discard more load cycles, unless it is chaotic"):
        vi.exact(*system, run)


@pytest.mark.parametrize("make", [rest_motion, lambda: vi.exact(TABLE, 0.94, 37.0, COLUMN)])
def test_motions_are_read_only(make):
    """Arrays and attributes of a motion cannot be written; it has a repr and converts to a dict."""
    motion = make()
    for name in ("phases", "X", "Z", "X_dot_before", "Z_dot_after", "multipliers", "restitution"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(motion, name)[0] = 0.0
    with pytest.raises((AttributeError, TypeError)):
        motion.r = 2.0
    assert motion.pattern.sides in repr(motion)
    assert motion.pattern.sides[0] in str(motion)
    assert motion.to_dict()["tables"]["motions"]["columns"]["r"] == motion.r
    again = make()
    assert np.array_equal(again.X, motion.X)
    assert np.array_equal(again.multipliers, motion.multipliers)
    assert np.all(signs(motion.events)[:1] == motion.pattern.signs[:1])
    assert plain(after_impact(motion))
