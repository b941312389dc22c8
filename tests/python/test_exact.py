"""Exact motions: Newton's method, its derivative and its verdicts, and what simulation says to it."""

import math

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from test_simulate import RIG, STATE, TURN, plain, settled, signs, state

EPS = np.finfo(float).eps
TABLE = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
COLUMN = ([0.0, 1.37 * math.pi], vi.Pattern("RL"))
UNEVEN = vi.Oscillator(xi=0.02, mu=0.1, restitution=(0.8, 0.5))
POINTS = [(TABLE, 0.94, 37.0), (RIG, 0.9, 6.0), (UNEVEN, 1.1, 2.0), (UNEVEN, 0.6, 1.0)]


def motions(osc, r, clearance, impacts=4, cycles=2):
    """Motions without rest that the search finds at a point."""
    found = vi.find(osc, r, clearance, max_impacts=impacts, max_cycles=cycles, states=0)
    return [motion for motion in found if not motion.pattern.has_rest]


def system_of(motion):
    """Return the reference's system of a motion."""
    osc = motion.osc
    return fp.System(
        osc.xi,
        osc.mu,
        motion.r,
        motion.pattern.sides,
        motion.pattern.cycles,
        tuple(motion.restitution),
    )


def after_impact(motion, i=0):
    """State just after an impact of a motion, as `simulate` takes it."""
    return state(
        (motion.phases[i] + motion.load_phase) / motion.r,
        motion.X[i],
        motion.X_dot_after[i],
        motion.Z[i],
        motion.Z_dot_after[i],
    )


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

    Own steps, by complex step, square their size; the package stops after the step that follows one
    below 1e-7, and needs exactly as many. A slightly wrong derivative would need more.
    """
    seen = 0
    for motion in motions(*point)[:6]:
        system, draw = system_of(motion), np.random.default_rng(7)
        exact = np.concatenate([motion.X, motion.phases + motion.tau])
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
            assert phases == pytest.approx(motion.phases, abs=1e-11)
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
        if len(motion.pattern) == 2 and abs(motion.phases[1] - half) < 1e-9:
            continue  # equispaced: the amplitude is free there
        linear = vi.periodic(motion.osc, motion.r, motion.phases, motion.pattern)
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
            system, motion.phases, motion.X / motion.clearance, *np.divide(wave, motion.clearance)
        )
        assert np.abs(off).max() <= 1e-12
        maps = fp.impact_jacobians(
            system, motion.phases, motion.X, motion.X_dot_after, motion.Z_dot_after, *wave
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
    """Phases and pattern, a motion nearby, a trajectory: one answer, Table 1's neighbour at 37."""
    first = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    near = vi.exact(TABLE, 0.94, 37.0, vi.exact(TABLE, 0.945, 36.0, COLUMN))
    paper = vi.exact(TABLE, 0.94, 37.0, vi.periodic(TABLE, 0.94, *COLUMN))
    run = vi.simulate(TABLE, 0.94, 37.0, 8, after_impact(first), discard=100.3)
    settled_run = vi.exact(TABLE, 0.94, 37.0, run)
    for other in (near, paper, settled_run):
        shift = int(other.pattern.letters[0] != first.pattern.letters[0])
        phases = np.append(other.phases, other.phases[0] + TURN)[shift : shift + 2]
        assert phases - phases[0] == pytest.approx(first.phases, abs=1e-10)
        assert np.roll(other.X, -shift) == pytest.approx(first.X, abs=1e-9)
        assert other.residual <= 1e-12
        assert other.stable
        assert other.admissible
        assert other.multipliers == pytest.approx(first.multipliers, abs=1e-8)
    assert first.phases[1] / math.pi == pytest.approx(1.382026, abs=1e-6)


@pytest.mark.parametrize("part", [0.0, 1e-13, -1e-13, 0.25, 0.5, 0.9])
@pytest.mark.parametrize("impact", [0, 1])
def test_a_trajectory_may_end_at_an_impact(impact, part):
    """Where in the period a trajectory ends, at an impact too, does not matter."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    run = vi.simulate(TABLE, 0.94, 37.0, 8 + part, after_impact(motion, impact))
    again = vi.exact(TABLE, 0.94, 37.0, run)
    assert again.pattern.cycles == 1
    assert sorted(again.pattern.letters) == ["L", "R"]
    assert np.sort(again.X) == pytest.approx(np.sort(motion.X), abs=1e-9)


@pytest.mark.parametrize("factor", [2.0, 10.0, 0.01])
def test_load_scales_the_motion(factor):
    """f -> factor f with the clearance alike: phases and multipliers stay, lengths scale."""
    one = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    other = vi.exact(TABLE, 0.94, 37.0 * factor, COLUMN, load=factor)
    assert other.load == factor
    assert other.phases == pytest.approx(one.phases, abs=1e-12)
    assert other.multipliers == pytest.approx(one.multipliers, abs=1e-9)
    assert other.X / factor == pytest.approx(one.X, abs=1e-10)
    assert other.A == pytest.approx(factor * one.A)
    assert other.x_max == pytest.approx(factor * one.x_max)
    times = np.linspace(0, one.period, 50)
    assert other.sample(times).load == pytest.approx(factor * one.sample(times).load, abs=1e-9)


# --- what simulation says -------------------------------------------------------------------


def by_period(run, motion, cycles):
    """Impacts of a run in rows of one period of a motion."""
    events, n = run.events, len(motion.pattern)
    rows = events[: cycles * n].reshape(cycles, n)
    assert set(rows["kind"].ravel()) == {"impact"}
    return rows


def test_stays_on_a_stable_motion_for_ten_thousand_cycles():
    """Every impact of 10,000 cycles is at the phase and place of the exact motion."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    run = vi.simulate(TABLE, 0.94, 37.0, 10_000, after_impact(motion))
    assert run.events.size in (19_999, 20_000)
    rows = by_period(run, motion, 9_999)
    phases = np.mod(motion.phases[[1, 0]] + motion.load_phase, TURN)
    assert np.abs(np.mod(rows["phase"] - phases + 1, TURN) - 1).max() < 1e-11
    assert np.abs(rows["x"] - motion.X[[1, 0]]).max() < 1e-11
    assert np.abs(rows["z_dot_after"] - motion.Z_dot_after[[1, 0]]).max() < 1e-11


@pytest.mark.parametrize("which", [0, 1])
def test_leaves_an_unstable_motion_at_the_rate_of_its_multiplier(which):
    """A departure of 1e-9 grows period by period by the leading multiplier, to 1 %."""
    motion = vi.equispaced(TABLE, 0.94, 37.0)[which]
    motion = vi.exact(TABLE, 0.94, 37.0, motion)
    assert not motion.stable
    values, vectors = np.linalg.eig(motion.stability_matrix())
    lead = int(np.abs(values).argmax())
    nudge = 1e-9 * vectors[:, lead].real
    first = after_impact(motion)
    first["t"] += nudge[3] / motion.r
    first["x"] += nudge[0]
    first["z"] += nudge[0]
    first["x_dot"] += nudge[1]
    first["z_dot"] += nudge[2]
    run = vi.simulate(TABLE, 0.94, 37.0, 30, first)
    right = run.events[(run.events["side"] == "R") & (run.events["kind"] == "impact")]
    off = np.abs(right["x"][:15] - motion.X[0])
    use = (off > 1e-8) & (off < 1e-3)
    period = np.arange(off.size)[use]
    assert period.size >= 4
    assert np.all(np.diff(period) == 1)
    rate = math.exp(np.polyfit(period, np.log(off[use]), 1)[0])
    assert rate == pytest.approx(abs(motion.multipliers[0]), rel=0.01)


@pytest.mark.parametrize("point", POINTS)
def test_a_perturbation_follows_the_stability_matrix(point):
    """One simulated period maps a small change of (x, x', z', phase) as [P] does."""
    osc, r, clearance = point
    for motion in motions(*point, impacts=3, cycles=1):
        matrix, size = motion.stability_matrix(), 1e-6
        n, side = len(motion.pattern), motion.pattern.signs[0]
        for column in range(4):
            ends = []
            for sign in (1, -1):
                change = np.zeros(4)
                change[column] = sign * size
                first = after_impact(motion)
                first["x"] += change[0]
                first["z"] = first["x"] + 0.5 * side * clearance
                first["x_dot"] += change[1]
                first["z_dot"] += change[2]
                first["t"] += change[3] / r
                event = vi.simulate(osc, r, clearance, 1.5, first).events[n - 1]
                ends.append(
                    [event["x"], event["x_dot_after"], event["z_dot_after"], event["time"] * r]
                )
            got = np.subtract(*ends) / (2 * size)
            assert got == pytest.approx(matrix[:, column], abs=2e-6 * np.abs(matrix).max())


def test_a_small_perturbation_of_a_stable_motion_dies_out():
    """The rate at which it does is the modulus of the leading multiplier."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    first = after_impact(motion)
    first["x_dot"] += 1e-4
    run = vi.simulate(TABLE, 0.94, 37.0, 300, first)
    right = run.events[run.events["side"] == "R"]
    off = np.abs(right["x"] - motion.X[0])
    tops = [off[i : i + 20].max() for i in range(20, 200, 20)]
    rate = math.exp(np.polyfit(np.arange(len(tops)) * 20, np.log(tops), 1)[0])
    assert rate == pytest.approx(abs(motion.multipliers[0]), rel=0.01)
    assert off[-20:].max() < 1e-10


# --- motions with accumulation and rest -----------------------------------------------------


def rest_motion(**changes):
    """Return the exact motion with rest of Figure 9c."""
    return vi.exact(RIG, 0.9, 6.0, settled(8), **changes)


def test_motion_with_completed_chatter():
    """The example is a motion RL*: one impact, one accumulation with rest, residual at rounding."""
    motion = rest_motion()
    assert motion.pattern.cycles == 1
    assert sorted(motion.pattern.letters) == ["L*", "R"]
    assert motion.residual <= 1e-12
    assert motion.consistent
    assert motion.admissible
    assert motion.stable
    assert "stable" in repr(motion)
    kinds = motion.events["kind"].tolist()
    assert kinds.count("stick") == kinds.count("release") == 1
    run = vi.simulate(RIG, 0.9, 6.0, 1, discard=400)
    assert kinds.count("impact") == (run.events["kind"] == "impact").sum()
    h = motion.sample(np.linspace(0, motion.period, 4001))
    assert np.abs(h.Y).max() <= 3.0 + 1e-12
    assert h.X.max() <= motion.x_max + 1e-12
    assert h.X.min() >= motion.x_min - 1e-12
    assert motion.x_max == pytest.approx(h.X.max(), abs=1e-4)
    assert motion.x_min == pytest.approx(h.X.min(), abs=1e-4)


def strobe(osc, r, clearance, base, change):
    """State one load period after a changed state."""
    first = dict(
        zip(
            STATE,
            [base["t"], *[base[k] + d for k, d in zip(STATE[1:], change, strict=True)]],
            strict=True,
        )
    )
    end = vi.simulate(osc, r, clearance, 1, first).final_state
    return np.array([end[name] for name in STATE[1:]])


def strobe_matrix(osc, r, clearance, base, size):
    """Derivative of the stroboscopic map by differences with Richardson's step to order six."""
    columns = []
    for j in range(4):
        slopes = []
        for h in (size, size / 2, size / 4):
            change = np.eye(4)[j] * h
            up, down = (strobe(osc, r, clearance, base, s * change) for s in (1, -1))
            slopes.append((up - down) / (2 * h))
        fine, coarse = (4 * slopes[2] - slopes[1]) / 3, (4 * slopes[1] - slopes[0]) / 3
        columns.append((16 * fine - coarse) / 15)
    return np.array(columns).T


def test_multipliers_of_a_motion_with_rest():
    """Two come from the plane of releases, two are the zeros that the accumulation brings.

    The 4 x 4 derivative of the stroboscopic map of (x, x', z, z') by differences has the same.
    """
    motion = rest_motion()
    release = motion.events[motion.events["kind"] == "release"][0]
    start = float(np.mod(release["time"] + 0.4, motion.period))
    h = motion.sample(start)
    base = state(
        (release["phase"] + 0.4 * motion.r) / motion.r,
        float(h.X),
        float(h.X_dot),
        float(h.Z),
        float(h.Z_dot),
    )
    assert strobe(RIG, 0.9, 6.0, base, np.zeros(4)) == pytest.approx(
        [base[name] for name in STATE[1:]], abs=1e-10
    )
    values = np.linalg.eigvals(strobe_matrix(RIG, 0.9, 6.0, base, 2e-3))
    values = values[np.argsort(-np.abs(values))]
    assert np.array_equal(motion.multipliers[2:], [0, 0])
    assert np.sort_complex(values[:2]) == pytest.approx(
        np.sort_complex(motion.multipliers[:2]), abs=1e-6
    )
    assert np.abs(values[2:]).max() < 1e-3
    assert np.prod(np.abs(values[2:])) < 1e-6


def test_simulation_stays_on_the_motion_with_rest():
    """Started at a state of the exact motion, impacts, sticks and releases repeat for 1000 cycles."""
    motion = rest_motion()
    release = motion.events[motion.events["kind"] == "release"][0]
    h = motion.sample(float(np.mod(release["time"] + 0.4, motion.period)))
    first = state(release["phase"] / 0.9 + 0.4, *(float(h[i]) for i in range(4)))
    run = vi.simulate(RIG, 0.9, 6.0, 1000, first)
    for kind in ("stick", "release"):
        phases = run.events["phase"][run.events["kind"] == kind]
        want = motion.events["phase"][motion.events["kind"] == kind][0]
        assert phases.size in (999, 1000, 1001)
        assert phases == pytest.approx(want, abs=1e-9)


def test_rest_motion_from_a_motion_nearby_and_at_another_load():
    """A motion with rest is a guess too; lengths scale with the load."""
    motion = rest_motion()
    near = vi.exact(RIG, 0.901, 6.02, motion)
    back = vi.exact(RIG, 0.9, 6.0, near)
    assert near.pattern == motion.pattern
    assert back.phases == pytest.approx(motion.phases, abs=1e-9)
    assert back.multipliers == pytest.approx(motion.multipliers, abs=1e-7)
    double = vi.exact(
        RIG, 0.9, 12.0, vi.simulate(RIG, 0.9, 12.0, 8, load=2.0, discard=300), load=2.0
    )
    assert double.X == pytest.approx(2 * motion.X, abs=1e-8)
    assert double.multipliers == pytest.approx(motion.multipliers, abs=1e-7)


def test_rest_motion_has_no_impact_maps():
    """An accumulation has infinitely many impacts: no list of [P_i], and an error that says so."""
    with pytest.raises(vi.errors.ParameterError, match="rest"):
        rest_motion().impact_maps()


# --- failures -------------------------------------------------------------------------------


def test_inadmissible_motions_are_returned_and_flagged():
    """A solution of the equations that passes a wall comes back with `admissible` False."""
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
    """Where there is no motion the error names the iteration, and nothing hangs."""
    failed = 0
    for clearance in (1e6, 1e9):
        with pytest.raises(vi.errors.SingularError) as caught:
            vi.exact(TABLE, 0.94, clearance, COLUMN)
        assert isinstance(caught.value, ArithmeticError)
        failed += "converge" in str(caught.value) or "no" in str(caught.value)
    assert failed == 2
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    assert core_exact(motion, motion.X + 0.3, motion.phases + motion.tau, 1)[2] != 0
    assert np.isnan(core_exact(motion, motion.X + 0.3, motion.phases + motion.tau, 1)[1]).all()


@pytest.mark.parametrize("guess", [None, 3, "RL", [0.0, 4.0], ([0.0, 4.0], "RL"), (1, 2, 3), {}])
def test_guess_types(guess):
    """What is not a guess is refused with what would be one."""
    with pytest.raises(vi.errors.ParameterTypeError, match="guess") as caught:
        vi.exact(TABLE, 0.94, 37.0, guess)
    assert repr(guess) in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [
    ("r", -1.0), ("r", math.nan), ("clearance", 0.0), ("clearance", math.inf), ("load", -1.0),
    ("load", math.nan),
])  # fmt: skip
def test_values(name, value):
    """Numbers have their ranges."""
    good = {"osc": TABLE, "r": 0.94, "clearance": 37.0, "guess": COLUMN}
    with pytest.raises(vi.errors.ParameterError, match=name) as caught:
        vi.exact(**good | {name: value})
    assert str(value) in str(caught.value)


def test_phases_of_a_guess_are_checked():
    """As in `periodic`; a pattern with a star has no phases."""
    with pytest.raises(vi.errors.ParameterError, match="phases"):
        vi.exact(TABLE, 0.94, 37.0, ([0.0, 9.0], vi.Pattern("RL")))
    with pytest.raises(vi.errors.ParameterError, match="star"):
        vi.exact(TABLE, 0.94, 37.0, ([0.0, 3.0], vi.Pattern("RL*")))


def test_no_exact_motion_without_load():
    """With f = 0 nothing keeps a motion going; that is an error or a motion at rest, not NaN."""
    with pytest.raises(vi.errors.VibroimpactError):
        vi.exact(TABLE, 0.94, 37.0, COLUMN, load=0.0)


@pytest.mark.parametrize("cycles", [1, 3, 20])
def test_trajectory_that_does_not_repeat(cycles):
    """A transient is no guess; the message says what to do."""
    run = vi.simulate(TABLE, 0.94, 37.0, cycles, state(x_dot=9.0, z_dot=-4.0))
    with pytest.raises(vi.errors.ParameterError, match=r"guess.*period"):
        vi.exact(TABLE, 0.94, 37.0, run)
    quiet = vi.simulate(TABLE, 0.94, 1e5, 40)
    with pytest.raises(vi.errors.ParameterError, match="guess"):
        vi.exact(TABLE, 0.94, 37.0, quiet)


@pytest.mark.parametrize("make", [rest_motion, lambda: vi.exact(TABLE, 0.94, 37.0, COLUMN)])
def test_motions_are_read_only(make):
    """Arrays of a motion cannot be written, nor its attributes; it prints, and it goes to a dict."""
    motion = make()
    for name in ("phases", "X", "Z", "X_dot_before", "Z_dot_after", "multipliers", "restitution"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(motion, name)[0] = 0.0
    with pytest.raises((AttributeError, TypeError)):
        motion.r = 2.0
    assert motion.pattern.sides in repr(motion)
    assert motion.pattern.sides[0] in str(motion)
    assert motion.to_dict()["r"] == motion.r
    again = make()
    assert np.array_equal(again.X, motion.X)
    assert np.array_equal(again.multipliers, motion.multipliers)
    assert np.all(signs(motion.events)[:1] == motion.pattern.signs[:1])
    assert plain(after_impact(motion))
