"""Section 4 of the paper: where equal coefficients of restitution are the best ones."""

import numpy as np
import pytest
import vibroimpact as vi
from shared_design import OSC, QUICK
from vibroimpact.results.performance import perform


def levels_of(clearance, right, left):
    """Greatest max|X|/A over the attractors that 12 states reach at r = 1; load cycles and impacts; each (n,)."""
    columns = np.broadcast_arrays([1.0], clearance, OSC.xi, OSC.mu, right, left)
    n = columns[0].size
    places = np.random.default_rng(0).uniform(-1, 1, (4, 12 * n))
    found = perform(np.repeat(np.array(columns), 12, axis=1), places, 300)
    assert (found.status == 0).all()
    level = (found.displacement / found.amplitude).reshape(n, 12).max(axis=1)
    return level, found.cycles.reshape(n, 12), found.impacts.reshape(n, 12)


@pytest.mark.parametrize("middle", [0.6, 0.68, 0.75])
@pytest.mark.parametrize("clearance", [50.0, 60.0, 70.0, 78.0])
def test_equal_restitution_is_best_where_the_motion_is_equispaced(middle, clearance):
    """Section 4 of the paper: equal coefficients are best at r = 1 among those with the same mean or product."""
    off = np.array([0, 0.01, 0.03, 0.06, 0.1])
    factors = np.exp(off / middle)
    for right, left in ((middle - off, middle + off), (middle / factors, middle * factors)):
        level, cycles, impacts = levels_of(clearance, right, left)
        assert (np.diff(level) > 0).all()
        assert (cycles[0] == 1).all()
        assert (impacts[0] == 2).all()
    osc = vi.Oscillator(xi=OSC.xi, mu=OSC.mu, restitution=middle)
    equispaced = [one for one in vi.equispaced(osc, 1.0, clearance) if one.stable]
    assert min(one.attenuation for one in equispaced) == pytest.approx(level[0], rel=1e-9)


def test_equal_restitution_is_not_best_elsewhere():
    """Exceptions: no stable equispaced motion, or the other wall has less restitution than both equal ones."""
    for right, left in ((0.575, 0.775), (0.675 * 0.86, 0.675 / 0.86)):
        unequal, cycles, impacts = levels_of(40.0, right, left)
        assert unequal[0] < 0.85 * levels_of(40.0, 0.675, 0.675)[0][0]
        assert (cycles == 1).all()
        assert (impacts == 3).all()
    osc = vi.Oscillator(xi=OSC.xi, mu=OSC.mu, restitution=0.675)
    assert not any(one.stable and one.admissible for one in vi.equispaced(osc, 1.0, 40.0))
    # the pairs of Figure 10: equal ones are better at most clearances, not at all of them
    clearances = np.array([50.0, 56.0, 62.0, 70.0, 78.0])
    equal, unequal = (levels_of(clearances, other, 0.75)[0] for other in (0.75, 0.61))
    assert (equal < unequal).tolist() == [True, True, False, True, True]


@pytest.mark.slow
def test_the_search_chooses_equal_restitution():
    """With the clearance free too, the least max|X|/A belongs to the greatest and equal coefficients."""
    kwargs = {**QUICK, "specimens": 1, "evaluations": 72}
    free = {"clearance": (20, 78), "R1": (0.6, 0.75), "R2": (0.6, 0.75)}
    found = vi.design(OSC, r=1.0, free=free, **kwargs)
    assert found.values == pytest.approx({"clearance": 78, "R1": 0.75, "R2": 0.75}, rel=1e-6)
