"""Single precision and batches of motions, on random systems, compared with `first_principles`."""

import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import assume, given
from hypothesis import strategies as st
from shared_laws import EPS_SINGLE, cases, error_bound, unknowns_of
from shared_systems import law


@given(cases(most=5))
@law(200)
def test_single_precision_is_as_good_as_it_can_be(case):
    """The difference from double precision is at most 32-bit rounding times the condition."""
    bound = error_bound(case, EPS_SINGLE)
    assume(bound < 0.05)
    double = vi.periodic(*case.arguments())
    single = vi.periodic(*case.arguments(), precision="single")
    assert (double.precision, single.precision) == ("double", "single")
    one, two = unknowns_of(double), unknowns_of(single)
    near = 8 * EPS_SINGLE / abs(1 - case.system.r**2 + 2j * case.system.xi * case.system.r)
    assert np.linalg.norm(one - two) <= (bound + near) * np.linalg.norm(one)


def test_single_precision_is_single():
    """Results have no correct digits beyond the seventh."""
    osc, pattern = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), vi.Pattern("RL")
    arguments = osc, 0.94, [0.0, 1.37 * np.pi], pattern
    double, single = vi.periodic(*arguments), vi.periodic(*arguments, precision="single")
    relative = np.abs(single.X / double.X - 1.0)
    assert np.all(relative > 1e-10)
    assert np.all(relative < 1e-3)
    assert np.array_equal(single.X, np.float32(single.X))


@given(cases(most=5), st.lists(st.floats(0.97, 1.03), min_size=1, max_size=6))
@law(100)
def test_batch_is_the_single_calls(case, factors):
    """Every point of a batch has the same digits as a single call."""
    osc, r, phases, pattern, restitution = case.arguments()
    r = np.array([r * f for f in factors])
    assume(np.abs(r - 1.0).min() > 1e-3)
    many = np.repeat(phases[:, None], len(r), axis=1)
    many[1] += 0.01 * np.arange(len(r))
    motions = vi.periodic_batch(osc, r, many, pattern, restitution)
    assert len(motions) == len(r)
    assert motions.X.shape == many.shape
    for i in np.flatnonzero(motions.status == 0):
        one = vi.periodic(osc, r[i], many[:, i], pattern, restitution)
        for name in (
            "X",
            "Z",
            "X_dot_before",
            "X_dot_after",
            "Z_dot_before",
            "Z_dot_after",
            "multipliers",
            "clearance",
            "A",
            "tau",
            "residual",
            "x_min",
            "x_max",
            "attenuation",
        ):
            mine = getattr(motions, name)[..., i]
            assert np.array_equal(mine, getattr(one, name)), name
            assert np.array_equal(getattr(motions[int(i)], name), getattr(one, name)), name


def test_a_failed_point_does_not_end_the_batch():
    """Equal halves and equal restitution leave a free amplitude: that point has a code and NaN."""
    osc, pattern = vi.Oscillator(xi=0.01, mu=0.05, restitution=0.75), vi.Pattern("RL")
    phases = np.array([[0.0, 0.0, 0.0], [3.0, np.pi, 3.3]])
    motions = vi.periodic_batch(osc, 0.9, phases, pattern)
    assert list(motions.status == 0) == [True, False, True]
    assert np.isnan(motions.X[:, 1]).all()
    assert np.isnan(motions.clearance[1])
    assert np.isfinite(motions.X[:, [0, 2]]).all()
    with pytest.raises(vi.errors.SingularError):
        vi.periodic(osc, 0.9, phases[:, 1], pattern)
