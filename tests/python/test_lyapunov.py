"""Lyapunov exponents compared with multipliers, volume and the divergence of neighbouring trajectories."""

import math

import numpy as np
import pytest
import vibroimpact as vi
from shared_motions import COLUMN, state_on
from shared_systems import FIGURE6, RIG, TABLE


@pytest.mark.parametrize(
    ("osc", "r", "clearance", "guess"),
    [
        (TABLE, 0.94, 37.0, COLUMN),
        (FIGURE6, 1.04, 14.0, None),
        (FIGURE6, 1.04, 6.0, None),
        (RIG, 1.04, 30.0, None),
    ],
)
def test_exponents_of_periodic_motions_are_those_of_the_multipliers(osc, r, clearance, guess):
    """Exponents of periodic motions equal those of the multipliers; their sum is that of det [P]."""
    run = guess or vi.simulate(osc, r, clearance, 12, discard=2000)
    motion = vi.exact(osc, r, clearance, run)
    assert motion.stable
    result = vi.lyapunov(osc, r, clearance, state=state_on(motion))
    k = motion.pattern.cycles
    np.testing.assert_allclose(result.per_cycle, np.log(np.abs(motion.multipliers)) / k, atol=1e-6)
    volume = -4 * np.pi * osc.xi / r + 2 * np.log(motion.restitution).sum() / k
    np.testing.assert_allclose(result.per_cycle.sum(), volume, rtol=1e-9)
    assert result.dimension == 0
    assert result.rests == 0


def test_exponents_of_a_motion_with_rest():
    """Two exponents are those of the return map at a release; the other two are -inf."""
    motion = vi.exact(RIG, 0.9, 6.0, vi.simulate(RIG, 0.9, 6.0, cycles=8, discard=200))
    result = vi.lyapunov(RIG, 0.9, 6.0)
    np.testing.assert_allclose(
        result.per_cycle[:2], np.log(np.abs(motion.multipliers[:2])), atol=1e-6
    )
    assert np.all(result.exponents[2:] == -math.inf)
    assert result.rests >= result.cycles
    assert 0 <= result.identity_error < 1e-6


def test_volume_is_checked_on_every_trajectory():
    """The sum of the logarithms equals that of the volume, also in chaos and for unequal walls."""
    for osc in (FIGURE6, RIG):
        result = vi.lyapunov(osc, 1.04, np.linspace(5, 60, 12), cycles=2000)
        assert np.all(result.identity_error[result.rests == 0] < 1e-12)
        # at the end of an accumulation speeds of 1e-8 are differences of velocities
        assert np.all(result.identity_error < 1e-6)
        assert np.any(result.largest > 3 * result.standard_error[0])


def test_largest_exponent_is_the_rate_at_which_neighbours_part():
    """The largest exponent agrees with the divergence of two simulations, which uses no derivatives."""
    r, clearance, cycles, small = 1.04, 7.5, 1500, 1e-7
    names = ("x", "x_dot", "z", "z_dot")
    here = vi.simulate(FIGURE6, r, clearance, 0, discard=500).final_state
    there = {name: here[name] for name in ("t", *names)}
    there["x_dot"] += small
    growth = []
    for _ in range(cycles):
        after = vi.simulate(FIGURE6, r, clearance, 1, state=here).final_state
        beside = vi.simulate(FIGURE6, r, clearance, 1, state=there).final_state
        apart = np.array([beside[name] - after[name] for name in names])
        growth.append(math.log(np.linalg.norm(apart) / small))
        there = {"t": after["t"]}
        for name, step in zip(names, apart * (small / np.linalg.norm(apart)), strict=True):
            there[name] = after[name] + step
        half = clearance / 2
        there["z"] = there["x"] + min(max(there["z"] - there["x"], -half), half)
        here = after
    growth = np.array(growth[50:])
    error = growth.reshape(50, -1).mean(axis=1).std() / math.sqrt(50)
    result = vi.lyapunov(FIGURE6, r, clearance, cycles=20_000)
    combined = math.hypot(error, float(result.standard_error[0]) * 2 * np.pi / r)
    assert result.per_cycle[0] > 0.5
    assert abs(growth.mean() - result.per_cycle[0]) < 4 * combined
    assert 1 < result.dimension < 4


def test_dead_walls_extinguish_directions():
    """With R = 0 on both walls the determinant is 0, so at most three exponents are finite."""
    osc = vi.Oscillator(xi=0.02, mu=0.05, restitution=0.0)
    result = vi.lyapunov(osc, 0.9, 4.0, cycles=500)
    assert result.impacts > 0
    assert result.exponents[3] == -math.inf
    assert np.isfinite(result.exponents[0])


def test_exponents_do_not_depend_on_threads():
    points = np.linspace(6, 60, 7)
    one, three = (vi.lyapunov(FIGURE6, 1.04, points, cycles=400, threads=n) for n in (1, 3))
    np.testing.assert_array_equal(one.exponents, three.exponents)
    alone = vi.lyapunov(FIGURE6, 1.04, points[2], cycles=400)
    np.testing.assert_array_equal(alone.exponents, one.exponents[:, 2])


def test_without_impacts_there_are_no_exponents():
    with pytest.raises(vi.errors.SingularError, match="no impacts"):
        vi.lyapunov(TABLE, 0.5, 100.0, cycles=100)
    both = vi.lyapunov(TABLE, 0.94, [100.0, 37.0], cycles=100)
    assert np.isnan(both.exponents[:, 0]).all()
    assert np.isnan(both.dimension[0])
    assert both.impacts[0] == 0


STATE = {"t": 0.3, "x": 1.0, "x_dot": -2.0, "z": 2.5, "z_dot": 4.0}


@pytest.mark.parametrize(
    ("r", "clearance"),
    [(1.04, 25.0), (vi.spaced(1.0, 1.05, 4), 25.0), (1.04, vi.spaced(20.0, 30.0, 3, "geometric"))],
)
@pytest.mark.parametrize("state", [None, STATE])
def test_the_namelist_of_exponents(r, clearance, state, tmp_path):
    """The namelist of exponents reproduces them to the last bit."""
    result = vi.lyapunov(FIGURE6, r, clearance, 61, state, load=1.1, discard=20, batches=3)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    for name in ("r", "clearance", "exponents", "standard_error", "impacts"):
        np.testing.assert_array_equal(
            np.ravel(getattr(again, name)), np.ravel(getattr(result, name))
        )
    assert again.cycles == result.cycles == 60
    assert again.case == result.case


GRID = np.meshgrid([1.0, 1.02, 1.05], [20.0, 30.0])


@pytest.mark.parametrize(
    ("r", "clearance"),
    [
        GRID,
        (np.stack([GRID[0]] * 2), 25.0),
        ([1.0, 1.02], [20.0, 30.0]),
        ([1.0, 1.01, 1.04], 20.0),
        (1.04, [20.0, 20.0]),
        ([1.04], 25.0),
    ],
)
def test_lists_and_arrays_have_a_namelist_too(r, clearance, tmp_path):
    """The namelist of a grid or a list of points reproduces them; points do not depend on each other."""
    result = vi.lyapunov(FIGURE6, r, clearance, 61, STATE, discard=20, batches=3)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    assert again.to_json() == result.to_json()
    points = np.broadcast_arrays(r, clearance)
    assert result.r.shape == result.dimension.shape == points[0].shape
    assert result.per_cycle.shape == (4, *points[0].shape)
    for place in np.ndindex(points[0].shape):
        one = (values[place] for values in points)
        alone = vi.lyapunov(FIGURE6, *one, 61, STATE, discard=20, batches=3)
        np.testing.assert_array_equal(alone.exponents, result.exponents[(slice(None), *place)])


def test_the_final_state_of_a_simulation_is_a_start_too(tmp_path):
    """A start from a final state is stored as its five numbers."""
    final = vi.simulate(FIGURE6, 1.04, 25.0, 3).final_state
    result = vi.lyapunov(FIGURE6, 1.04, 25.0, 40, final)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (again,) = vi.read_namelist(tmp_path / "case.nml")[0].run()
    assert again.to_json() == result.to_json()
    five = {name: final[name] for name in STATE}
    assert vi.lyapunov(FIGURE6, 1.04, 25.0, 40, five).to_json() == result.to_json()


@pytest.mark.parametrize("form", ["json", "nc", "mat"])
@pytest.mark.parametrize("r", [1.04, [1.0, 1.01, 1.04], GRID[0]])
def test_a_file_gives_the_exponents_again(r, form, tmp_path):
    """Saved exponents and the core's table are read back to the last bit."""
    result = vi.lyapunov(FIGURE6, r, 25.0, 61, STATE, discard=20, batches=3)
    result.save(tmp_path / f"one.{form}")
    again = vi.load(tmp_path / f"one.{form}")
    assert again.to_json() == result.to_json()
    tables = []
    for item in (result, again):
        item.save(tmp_path / "table.csv")
        tables.append((tmp_path / "table.csv").read_bytes())
    assert tables[0] == tables[1]


def test_values_and_errors_have_the_same_unit():
    """Exponents per unit of time 1/omega, and per load cycle, which is 2 pi/r of it."""
    moving = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
    result = vi.lyapunov(FIGURE6, [1.04, 1.05], 72.0, 2000, moving)
    cycle = 2 * np.pi / result.r
    np.testing.assert_allclose(result.per_cycle, result.exponents * cycle, rtol=1e-12)
    np.testing.assert_allclose(result.error_per_cycle, result.standard_error * cycle, rtol=1e-12)
    assert "per load cycle" in repr(vi.lyapunov(FIGURE6, 1.04, 72.0, 2000, moving))
    columns = result._result.tables["points"].columns
    assert columns["per_cycle"].unit == columns["error_per_cycle"].unit == "1/load cycle"
    assert columns["exponents"].unit == columns["standard_error"].unit == "omega"
