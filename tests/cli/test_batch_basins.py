"""Spacing of a line of values, and random states, in namelists: the digits of the API from both programs."""

import numpy as np
import pytest
from programs import contents, rows
from test_batch_attractors import DIAGRAM, EQUAL, MOVING, both, case_of, column, refused

RATIOS = DIAGRAM.replace("values = 4", "values = 4, spacing = 'geometric'")
EXPONENTS = f"""{EQUAL}&lyapunov parameter = 'clearance'
  low = 9, high = 40, values = 3, spacing = 'geometric'
  cycles = 100, {MOVING}
/
"""


@pytest.mark.parametrize("text", [
    RATIOS,
    RATIOS.replace("20", "2").replace("'both'", "'states', states = 2").replace("'g", "'G"),
    RATIOS.replace("'clearance'", "'xi', clearance = 20").replace("low = 20, high = 26", "low = 1e-4, high = 0.1"),
])  # fmt: skip
def test_diagram_in_ratios_of_the_api(text, batch, command, same_build):
    table = both(text, batch, command)
    result = case_of(batch).bifurcation()
    np.testing.assert_allclose(
        result.values[1:] / result.values[:-1], result.values[1] / result.values[0]
    )
    assert (
        column(table, result.parameter).tolist() == result.values[result.points["index"]].tolist()
    )
    for name in ("phase", "x", "x_dot_before", "z_dot_after"):
        assert column(table, name).tolist() == result.points[name].tolist()


def test_exponents_in_ratios_of_the_api(batch, command, same_build):
    table = both(EXPONENTS, batch, command)
    result = case_of(batch).lyapunov()
    assert column(table, "clearance").tolist() == result.clearance.tolist()
    assert column(table, "exponent_1").tolist() == result.per_cycle[0].tolist()
    assert result.clearance[1] == pytest.approx(np.sqrt(9 * 40))


def test_two_values_have_any_spacing(batch):
    """Between two ends there is nothing to space: the same table."""
    tables = []
    for text in (DIAGRAM, RATIOS):
        assert batch.case(text.replace("values = 4", "values = 2")).status == 0
        tables.append(rows(batch.cwd / "results/case.csv"))
    assert tables[0] == tables[1]
    assert len(tables[0]) > 10


@pytest.mark.parametrize(("old", "new", "wanted", "line"), [
    *[("'geometric'", v, "spacing = " + v + ": must be 'linear' or 'geometric'", 3)
      for v in ("'equal'", "''", "linear")],
    ("'clearance'\n  low = 20, high = 26", "'xi', clearance = 9\n  low = 0, high = 0.1",
     "above 0 with spacing = 'geometric'", 3),
    ("low = 20, high = 26, values = 4", "low = 1, high = 1.0000000000000004, values = 9", "do not differ", 3),
    ("values = 4", "spacing = 'linear'", "was given before, in line 3", 3),
])  # fmt: skip
def test_bad_spacing(old, new, wanted, line, batch):
    assert old in RATIOS
    refused(RATIOS.replace(old, new, 1), "bifurcation", wanted, line, batch)


def test_spacing_without_a_parameter(batch):
    text = EXPONENTS.replace("parameter = 'clearance'", "clearance = 9")
    text = text.replace("low = 9, high = 40, values = 3, ", "")
    refused(text, "lyapunov", "must be left out: it goes with parameter", 3, batch)
    assert list(contents(batch.cwd)) == ["case.nml"]
