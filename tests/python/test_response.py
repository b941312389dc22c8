"""The response along r, compared with exact motions and scaling laws."""

import gc

import numpy as np
import pytest
import vibroimpact as vi
from shared_systems import FIGURE6, RIG


@pytest.mark.parametrize("wall", [{"clearance": 25.0}, {"inverse_clearance": 0.03}])
def test_the_namelist_of_a_response(wall, tmp_path):
    """The namelist of a response reproduces it to the last bit."""
    line = vi.spaced(1.0, 1.02, 3)
    result = vi.response(FIGURE6, line, **wall, states=4, load=1.1, settling=30, keep=9)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    for name in ("r", "clearance", "attenuation", "lowest", "highest", "cycles"):
        np.testing.assert_array_equal(getattr(again, name), getattr(result, name))
    assert again.case == result.case


@pytest.mark.parametrize("name", ["clearance", "inverse_clearance"])
def test_lists_have_a_namelist_too(name, tmp_path):
    """Uneven frequency ratios, with a clearance for each, have a namelist; points do not depend on each other."""
    line, walls = np.array([1.0, 1.003, 1.02]), {name: np.array([25.0, 0.03, 24.0])}
    result = vi.response(FIGURE6, line, **walls, states=4, settling=30, keep=9)
    (tmp_path / "case.nml").write_text(result.to_namelist())
    (case,) = vi.read_namelist(tmp_path / "case.nml")
    (again,) = case.run()
    assert again.to_json() == result.to_json()
    for i in range(3):
        one = {name: walls[name][i]}
        alone = vi.response(FIGURE6, line[i : i + 1], **one, states=4, settling=30, keep=9)
        np.testing.assert_array_equal(alone.attenuation[0], result.attenuation[i])


@pytest.mark.parametrize("form", ["json", "nc", "mat"])
def test_a_file_gives_the_response_again(form, tmp_path):
    """A saved response and the core's table are read back to the last bit."""
    result = vi.response(FIGURE6, [1.0, 1.01, 1.03], 25.0, states=3, settling=30, keep=9)
    result.save(tmp_path / f"one.{form}")
    again = vi.load(tmp_path / f"one.{form}")
    assert again.to_json() == result.to_json()
    tables = []
    for item in (result, again):
        item.save(tmp_path / "table.csv")
        tables.append((tmp_path / "table.csv").read_bytes())
    assert tables[0] == tables[1]


def test_arrays_outlive_the_result():
    """An array is a view of memory of the core, which is freed with the last such array."""
    lowest = vi.response(FIGURE6, [1.0, 1.01], 25.0, states=3, settling=30, keep=9).lowest
    copy = lowest.copy()
    gc.collect()
    [np.ones(1000) for _ in range(100)]
    np.testing.assert_array_equal(lowest, copy)
    assert not lowest.flags.writeable


def test_response_is_that_of_the_exact_motions():
    """max|X|/A of each attractor equals that of an exact motion."""
    r, inverse = np.array([1.04, 1.06]), 0.03
    result = vi.response(FIGURE6, r, inverse_clearance=inverse, states=8)
    for i, one in enumerate(r.tolist()):
        motions = vi.find(FIGURE6, one, 1 / inverse, max_impacts=3, max_cycles=1)
        own = np.array([m.attenuation for m in motions if m.stable])
        assert (result.cycles[i] > 0).all()
        for value in result.attenuation[i]:
            assert np.abs(own / value - 1).min() < 1e-5
    assert np.all(result.lowest <= result.highest)


def test_response_by_clearance_is_the_same():
    one = vi.response(FIGURE6, [1.0, 1.02], clearance=25.0, states=4, threads=1)
    two = vi.response(FIGURE6, [1.0, 1.02], inverse_clearance=0.04, states=4, threads=2)
    np.testing.assert_array_equal(one.attenuation, two.attenuation)


def test_load_scales_lengths():
    """With twice the load and clearance the motions are the same, twice as large."""
    plain = vi.response(FIGURE6, [1.04], clearance=30.0, states=4)
    twice = vi.response(FIGURE6, [1.04], clearance=60.0, states=4, load=2.0)
    np.testing.assert_allclose(plain.highest, twice.highest, rtol=1e-9)


def test_near_a_flip_the_shortest_period_counts():
    """A slowly settling run, as just above the flip of RL/1 at 11.08153, is not mistaken for one of two cycles."""
    result = vi.response(RIG, [1.1], clearance=11.0926, states=8)
    assert (result.cycles == 1).all()
    assert (result.symbols == 2).all()
