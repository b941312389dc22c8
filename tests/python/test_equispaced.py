"""The equispaced pair: intersection of line and circle, resonances, and limits of existence."""

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import assume, given
from hypothesis import strategies as st
from shared_laws import EPS_SINGLE, unknowns_of
from shared_systems import EPS, TURN, law


def free_map_defect(xi, r, cycles):
    """1 + an eigenvalue of the map of free vibration over half a period; 0 at an undamped resonance."""
    return abs(1 + np.exp((-xi + 1j * np.sqrt(1 - xi**2)) * np.pi * cycles / r))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize(("cycles", "odd"), [(1, 3), (3, 5), (3, 7), (5, 3), (7, 1)])
def test_equispaced_at_an_undamped_resonance(cycles, odd, mu):
    """If free vibration changes sign in half a period it can be added: the family of motions is reported.

    With mu > 0 the positions are those at which the free mass is at rest in space, so that no impact changes
    the free vibration.
    """
    r, restitution = cycles / odd, 0.6
    system = fp.System(0.0, mu, r, "RL", cycles, (restitution, restitution))
    phases = np.array([0.0, np.pi * cycles])
    for tau in (-2.0, 0.3, 1.1):
        for x in (-0.5,) if mu else (-0.7, 0.0, 2.0):
            wave = system.amplitude / 30.0 * np.array([np.cos(tau), np.sin(tau)])
            value = fp.mismatch(system, phases, np.array([x, -x]), *wave)
            assert np.abs(value).max() <= 1e-13 * (1 + abs(x) + np.abs(wave).max()) * (1 + r) * odd
    osc = vi.Oscillator(xi=0.0, mu=mu, restitution=restitution)
    with pytest.raises(vi.errors.SingularError, match="no unique solution"):
        vi.equispaced(osc, r, 30.0, cycles=cycles)
    # with a little damping, or slightly off the resonance, the motions are separate again
    assert_equispaced(1e-3, mu, restitution, r, cycles, 0.5)
    assert_equispaced(0.0, mu, restitution, r * 1.001, cycles, 0.5)


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize(("sides", "phases"), [
    ("RL", [0, 3.5]), ("RRL", [0, 1.5, 3.9]), ("equispaced", None)])  # fmt: skip
def test_few_digits_near_resonance_are_reported(sides, phases, precision):
    """As r -> 1 without damping x/d has a limit, but A has none: digits are lost until the result is refused.

    x/d changes by less than 10 |r - 1| here, so that the motion slightly farther off is a reference. The
    rounding is multiplied by the condition of the equations, each unknown in its own unit.
    """
    osc = vi.Oscillator(xi=0.0, mu=0.3, restitution=0.6 if phases is None else (0.6, 0.5))

    def positions(r):
        if phases is None:
            return vi.equispaced(osc, r, 100.0, precision=precision)[0].X / 100.0
        motion = vi.periodic(osc, r, phases, vi.Pattern(sides), precision=precision)
        return motion.X / motion.clearance

    condition = 1.0
    if phases is not None:
        matrix, _ = vi.linear_system(osc, 1 + 1e-6, phases, vi.Pattern(sides))
        condition = np.linalg.cond(matrix / np.linalg.norm(matrix, axis=0))
    first, allowed = (-7, 1e-6) if precision == "double" else (-3, 1e4 * EPS_SINGLE)
    true, message = positions(1 + 10.0**first), []
    for power in np.arange(first, -15 if precision == "double" else -7, -0.25):
        try:
            found = positions(1 + 10.0**power)
        except vi.errors.SingularError as error:
            message.append(str(error))
            continue
        assert not message, "digits came back"
        assert np.abs(found - true).max() <= condition * allowed + 10 * 10.0**first
    assert "too few digits" in message[0]


@given(
    st.one_of(st.just(0.0), st.floats(-18.0, -4.0).map(lambda x: 10**x)),
    st.one_of(st.just(0.0), st.floats(0.0, 1.0)),
    st.floats(0.05, 0.95),
    st.sampled_from([(1, 3), (3, 5), (3, 7), (5, 3)]),
    st.one_of(st.just(0.0), st.floats(-17.0, -3.0).map(lambda x: 10**x)),
    st.sampled_from([-1, 1]),
    st.floats(0.05, 3.0),
)
@law(200)
def test_equispaced_near_an_undamped_resonance(xi, mu, restitution, ratio_of_r, off, sign, ratio):
    """Near a resonance without damping the law of the next test holds."""
    cycles, odd = ratio_of_r
    assert_equispaced(xi, mu, restitution, cycles / odd * (1 + sign * off), cycles, ratio)


@given(
    st.floats(0.0, 0.3),
    st.floats(0.0, 1.0),
    st.floats(0.05, 0.95),
    st.floats(0.4, 2.5),
    st.sampled_from([1, 3]),
    st.floats(0.05, 3.0),
)
@law(200)
def test_equispaced_is_a_line_cut_by_a_circle(xi, mu, restitution, r, cycles, ratio):
    """Both motions exist where those of the reference do, and are symmetric and consistent."""
    assume(abs(r - 1.0) + xi > 1e-2)
    assert_equispaced(xi, mu, restitution, r, cycles, ratio)


def assert_equispaced(xi, mu, restitution, r, cycles, ratio):
    """Check the pair at a clearance given in units of the largest one of the impact pair."""
    system = fp.System(xi, mu, r, "RL", cycles, (restitution, restitution))
    clearance = ratio * system.amplitude * fp.impact_pair_limit(restitution, cycles)
    expected = fp.equispaced(system, clearance)
    defect = free_map_defect(xi, r, cycles)
    try:
        found = vi.equispaced(
            vi.Oscillator(xi=xi, mu=mu, restitution=restitution), r, clearance, cycles=cycles
        )
    except vi.errors.SingularError:
        # at an undamped resonance of the half period the line loses its direction (tested separately)
        assert defect < 50 * EPS / 1e-6 * (1 + r)
        return
    if bool(found) != bool(expected):
        # the two may disagree only where the line nearly touches the circle
        near = (
            fp.equispaced(system, clearance * (1 - 1e-9)),
            fp.equispaced(system, clearance * (1 + 1e-9)),
        )
        assert len(near[0]) != len(near[1])
        return
    assert len(found) in (0, 1, 2)
    for motion in found:
        assert motion.clearance == pytest.approx(clearance, rel=1e-12)
        assert motion.pattern.sides == "RL"
        assert motion.X[1] == pytest.approx(-motion.X[0], abs=1e-11 * (1 + abs(motion.X[0])))
        value = fp.mismatch(system, motion.alpha, motion.X / clearance, *(unknowns_of(motion)[-2:]))
        assert np.abs(value).max() <= 1e-12 * np.linalg.norm(unknowns_of(motion)) * (1 + r)
    if len(found) == len(expected) == 2:
        gap = abs(expected[0].tau - expected[1].tau) % TURN
        # half a period is rounded; near a resonance this counts relative to the distance from it
        lost = EPS * np.pi * cycles / r / defect
        near = max(1e-9, 100 * lost) / max(min(gap, TURN - gap, 1.0), 1e-9)
        for motion in found:
            taus = np.array([np.exp(1j * (motion.tau - other.tau)) for other in expected])
            assert np.abs(taus - 1.0).min() <= near


@given(
    st.floats(0.05, 0.95),
    st.floats(0.4, 2.5),
    st.sampled_from([1, 3, 5]),
    st.one_of(st.just(0.999999), st.floats(0.01, 0.999999)),
)
@law(150)
def test_equispaced_impact_pair_ends_where_it_should(restitution, r, cycles, part):
    """With mu = 0 there are two motions up to a clearance known in closed form, and none beyond."""
    assume(abs(r - 1.0) > 1e-2)
    xi = 0.01
    osc = vi.Oscillator(xi=xi, mu=0.0, restitution=restitution)
    A = abs(1.0 / (1.0 - r * r + 2j * xi * r))
    limit = A * fp.impact_pair_limit(restitution, cycles)
    assert len(vi.equispaced(osc, r, part * limit, cycles=cycles)) == 2
    assert vi.equispaced(osc, r, limit / part, cycles=cycles) == []
    at_limit = vi.equispaced(osc, r, limit, cycles=cycles)
    assert len(at_limit) in (0, 1, 2)
    for motion in at_limit:
        phase = (1 + restitution) * np.pi * cycles * np.cos(motion.tau)
        phase += 2 * (1 - restitution) * np.sin(motion.tau)
        assert phase == pytest.approx(-(1 - restitution) * motion.clearance / A, rel=1e-9)


def test_many_points_in_one_call_have_the_bits_of_each():
    """A batch has the bits of single calls, for both solutions, and a status where they do not exist."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    r, clearance = np.array([0.94, 0.9, 1.1, 0.94]), np.array([37.0, 12.0, 40.0, 200.0])
    pairs = vi.equispaced_batch(osc, r, clearance)
    for j in range(r.size):
        alone = vi.equispaced(osc, float(r[j]), float(clearance[j]))
        together = [motions[j] for motions in pairs if motions.status[j] == 0]
        assert len(alone) == len(together)
        for one, other in zip(alone, together, strict=True):
            assert (one.X == other.X).all()
            assert (one.multipliers == other.multipliers).all()
            assert (one.stable, one.admissible) == (other.stable, other.admissible)
    with pytest.raises(vi.errors.ParameterError, match="clearance of 0 values"):
        vi.equispaced_batch(osc, r, [])
    with pytest.raises(vi.errors.ParameterError, match="r of shape"):
        vi.equispaced_batch(osc, r, clearance[:2])
    with pytest.raises(vi.errors.ParameterError, match="clearance = -1"):
        vi.equispaced_batch(osc, r, [1.0, -1.0, 2.0, 3.0])
