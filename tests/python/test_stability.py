"""Laws of [P_i], [P] and the multipliers, on random systems, compared with `first_principles`."""

from dataclasses import replace

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi
from hypothesis import assume, given
from hypothesis import strategies as st
from shared_laws import (
    assert_multipliers,
    cases,
    error_bound,
    event_condition,
    exact,
    scaled,
    unknowns_of,
)
from shared_systems import EPS, TURN, law


def assert_impact_maps(case, motion):
    """Compare P_i, [P] and the multipliers with the complex step; return the P_i, scaled."""
    condition = event_condition(motion, case.system)
    assume(condition < 1e8)
    c, s = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    expected = fp.impact_jacobians(
        case.system, motion.alpha, motion.X, motion.X_dot_after, motion.Z_dot_after, c, s
    )
    maps = motion.impact_maps()
    wanted, have = scaled(expected, motion), scaled(maps, motion)
    assert have.shape == wanted.shape
    size = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    assert np.all(np.abs(have - wanted) <= 4 * EPS * condition * size)
    product = np.linalg.multi_dot([np.eye(4), *have[::-1]])
    norms = np.prod(np.linalg.norm(have, 2, axis=(1, 2)))
    error = np.abs(scaled(motion.stability_matrix(), motion) - product)
    assert np.all(error <= 8 * EPS * len(maps) * norms)
    assert_multipliers(motion.multipliers, expected, motion, condition)
    return have


@given(cases(most=6))
@law(200)
def test_impact_maps_of_any_motion(case):
    """P_i is the derivative of the impact map of its flight, also between inconsistent phases."""
    assume(error_bound(case) < 1e-3)
    assert_impact_maps(case, vi.periodic(*case.arguments()))


@given(cases())
@law(200)
def test_determinant_of_an_exact_motion(case):
    """det[P] = exp(-4 pi xi k/r) prod R_i^2, and P_i as the derivative of the impact map."""
    case, _ = exact(case)
    system = case.system
    motion = vi.periodic(*case.arguments())
    assert motion.residual <= 4 * error_bound(case) + 1e-13
    maps = assert_impact_maps(case, motion)
    expected = np.exp(-4 * np.pi * system.xi * system.cycles / system.r) * np.prod(
        np.square(system.restitution)
    )
    found = np.prod(np.linalg.det(maps))
    if expected == 0.0:
        # a product of determinants contains a zero: a zero pivot to rounding in each factor
        assert abs(found) <= 1e-10 * np.prod(np.linalg.norm(maps, 2, axis=(1, 2)))
        return
    # the error of a determinant is that of the condition of its matrix; the law also needs the approach speed
    # of the flight to be that of the impact: their difference is the residual
    rounding = EPS * np.linalg.cond(maps, 2).sum()
    residual = 1e-14 * np.abs(fp.linear_system(system, case.phases)[0]).max()
    speeds = event_condition(motion, system) * residual * (1 + np.abs(motion.X).max())
    assert found == pytest.approx(expected, rel=16 * rounding + 16 * len(maps) * speeds)
    product = motion.stability_matrix()
    norms = np.prod(np.linalg.norm(maps, 2, axis=(1, 2)))
    smallest = np.linalg.svd(scaled(product, motion))[1][-1]
    loose = 64 * EPS * norms / max(smallest, EPS)
    if loose < 1e-2:
        bound = loose + 16 * rounding + 16 * len(maps) * speeds
        assert np.prod(motion.multipliers) == pytest.approx(expected, rel=bound)


@given(cases(most=5))
@law(200)
def test_exact_motion_is_a_fixed_point_of_the_impact_maps(case):
    """From an inaccurate guess of the flight time Newton's method reaches the state of the next impact."""
    case, _ = exact(case)
    system = case.system
    motion = vi.periodic(*case.arguments())
    condition = event_condition(motion, system)
    bound = condition * error_bound(case)
    assume(bound < 1e-6)
    wave = motion.A * np.cos(motion.tau), motion.A * np.sin(motion.tau)
    walls = 0.5 * motion.clearance * system.signs
    end = np.append(motion.alpha[1:], TURN * system.cycles)
    states = np.stack([motion.X, motion.X_dot_after, motion.Z_dot_after, motion.alpha])
    turn = np.array([0.0, 0.0, 0.0, TURN * system.cycles])
    size = motion.A + np.abs(states[:3]).max()
    for i, time in enumerate((end - motion.alpha) / system.r):
        j = (i + 1) % len(walls)
        # close enough for the root to be this one: the approach speed varies little over it
        guess = time * (1 + 1e-3 / condition)
        after, found = fp.impact_map(
            system, wave, system.restitution[j], states[:, i : i + 1], guess, walls[j] - walls[i]
        )
        wanted = states[:, j] + (turn if j == 0 else 0.0)
        error = np.abs(after[:, 0] - wanted) / [size, size, size, 1.0]
        assert error.max() <= 16 * bound * len(walls)
        assert abs(found[0] - time) <= 16 * bound * len(walls)


@given(cases(most=4), st.integers(2, 3))
@law(150)
def test_repeated_motion(case, times):
    """A motion written as several of its periods is the same motion; its multipliers are powers."""
    case, _ = exact(case)
    system = case.system
    more = replace(
        system,
        sides=system.sides * times,
        cycles=system.cycles * times,
        restitution=system.restitution * times,
    )
    phases = np.concatenate([case.phases + TURN * system.cycles * i for i in range(times)])
    longer = replace(case, system=more, phases=phases)
    bound = error_bound(longer)
    assume(bound < 1e-6)
    once, often = vi.periodic(*case.arguments()), vi.periodic(*longer.arguments())
    size = np.linalg.norm(unknowns_of(often)) * once.clearance
    assert np.all(np.abs(often.X - np.tile(once.X, times)) <= bound * size)
    # the bound of X moves the P_i by no more than the condition of the event allows
    maps = np.tile(once.impact_maps(), (times, 1, 1))
    condition = event_condition(once, system)
    assume(condition < 1e6)
    assert_multipliers(often.multipliers, maps, once, condition**2 * (1 + bound / EPS))
