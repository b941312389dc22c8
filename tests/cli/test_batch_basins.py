"""Spacings and random states in namelists: both programs give the digits of the API."""

import math
import re

import numpy as np
import pytest
from attractors import (
    DIAGRAM,
    EQUAL,
    MOVING,
    PLANE,
    TABLE,
    WALLS,
    assert_both,
    case_of,
    told,
)
from programs import assert_refused, column, contents, rows

RATIOS = DIAGRAM.replace("values = 4", "values = 4, spacing = 'geometric'")
EXPONENTS = f"""{EQUAL}&lyapunov parameter = 'clearance'
  low = 9, high = 40, values = 3, spacing = 'geometric'
  cycles = 100, {MOVING}
/
"""
RANDOM = f"""{TABLE}&basins clearance = 37
  states = 150, seed = 4
  probes = 50
/
"""


@pytest.mark.parametrize("text", [
    RATIOS,
    RATIOS.replace("20", "2").replace("'both'", "'states', states = 2").replace("'g", "'G"),
    RATIOS.replace("'clearance'", "'xi', clearance = 20").replace("low = 20, high = 26", "low = 1e-4, high = 0.1"),
])  # fmt: skip
def test_diagram_in_ratios_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    np.testing.assert_allclose(
        result.values[1:] / result.values[:-1], result.values[1] / result.values[0]
    )
    assert (
        column(table, result.parameter).tolist() == result.values[result.points["index"]].tolist()
    )
    for name in ("phase", "x", "x_dot_before", "z_dot_after"):
        assert column(table, name).tolist() == result.points[name].tolist()


def test_exponents_in_ratios_of_the_api(batch, command, same_build):
    table = assert_both(EXPONENTS, batch, command)
    result = case_of(batch).run()[0]
    assert column(table, "clearance").tolist() == result.clearance.tolist()
    assert column(table, "exponent_1").tolist() == result.per_cycle[0].tolist()
    assert result.clearance[1] == pytest.approx(np.sqrt(9 * 40))


def test_two_values_have_any_spacing(batch):
    """With two values both spacings give the same table."""
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
    ("low = 20, high = 26, values = 4", "low = 1, high = 1.0000000000000004, values = 9",
     "not that many distinct values", 3),
    ("values = 4", "spacing = 'linear'", "was given before, in line 3", 3),
])  # fmt: skip
def test_bad_spacing(old, new, wanted, line, batch):
    assert old in RATIOS
    assert_refused(RATIOS.replace(old, new, 1), "bifurcation", wanted, line, batch)


def test_spacing_without_a_parameter(batch):
    text = EXPONENTS.replace("parameter = 'clearance'", "clearance = 9")
    text = text.replace("low = 9, high = 40, values = 3, ", "")
    assert_refused(text, "lyapunov", "must be left out: it requires parameter", 3, batch)
    assert list(contents(batch.cwd)) == ["case.nml"]


def sure(path):
    """The header's entries: share and largest disc of each attractor, and the uncertainty exponent."""
    number = r"(\S+)"
    disc = rf", radius of the largest disc {number} about \w+, \w+ = {number}, {number}"
    text = path.read_text()
    shares = re.findall(
        rf"^# ! (\d+): standard error of the share {number}(?:{disc})?$", text, re.MULTILINE
    )
    exponents = re.findall(rf"^# ! uncertainty exponent {number}$", text, re.MULTILINE)
    return [[float(item) for item in found if item] for found in shares], [
        float(item) for item in exponents
    ]


@pytest.mark.parametrize("text", [
    RANDOM,
    RANDOM.replace(", seed = 4", ""),
    RANDOM.replace("= 4", "= 2147483647").replace("= 37", "= 25, load = 0.7"),
    RANDOM.replace(TABLE, WALLS).replace("= 4", "= 04").replace("= 37", "= 6, cycles = 300"),
])  # fmt: skip
def test_random_states_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    assert result.axes is None
    for name, values in zip(("t", "x", "x_dot", "z", "z_dot"), result.states, strict=True):
        assert column(table, name).tolist() == values.tolist()
    assert column(table, "label").tolist() == result.labels.tolist()
    shares, exponents = sure(batch.cwd / "results/case.csv")
    assert shares == [[i, error] for i, error in enumerate(result.standard_error.tolist())]
    assert exponents == []
    output = [float(item[3]) for item in told(batch.cwd / "results/case.csv")]
    assert output == result.fractions.tolist()


def test_safety_of_the_api(batch, command, same_build):
    """Discs and exponent of a plane are those of the API, and so are the standard errors printed."""
    text = PLANE.replace("8, 9", "40, 33")
    assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    shares, exponents = sure(batch.cwd / "results/case.csv")
    wanted = []
    for i, error in enumerate(result.standard_error.tolist()):
        radius, centre = result.integrity(i)
        wanted.append([i, error, radius, *centre])
    assert shares == wanted
    assert exponents == [result.uncertainty_exponent]
    output = batch.case(text).out.decode()
    for item, share, error in zip(
        result.attractors, result.fractions, result.standard_error, strict=True
    ):
        assert f"{item.name} {100 * share:.2f}% +- {100 * error:.2f}%" in output


def test_a_plane_without_a_boundary_has_no_exponent(batch):
    """A plane with one attractor has no exponent; its disc reaches from the middle to a cell beyond the edge."""
    text = PLANE.replace(TABLE, WALLS).replace("= 37", "= 6").replace("8, 9", "17, 19")
    assert batch.case(text).status == 0
    ((_, error, radius, x, x_dot),), exponents = sure(batch.cwd / "results/case.csv")
    assert (error, exponents) == (0, [])
    assert (x, x_dot) == (0, 0)
    assert radius == pytest.approx(30 + 60 / 18)


def test_another_seed_has_other_states(batch):
    """Another seed gives other states with the same shares; more states begin with the same ones."""
    tables = []
    for new in ("states = 600, seed = 4", "states = 150, seed = 5", "states = 150, seed = 4"):
        assert batch.case(RANDOM.replace("states = 150, seed = 4", new)).status == 0
        tables.append(rows(batch.cwd / "results/case.csv"))
    starts = [[tuple(row.values())[1:5] for row in table] for table in tables]
    assert starts[0][:150] == starts[2]
    assert set(starts[0]).isdisjoint(starts[1])
    pair = [np.mean([row["attractor"][:4] == "RL/1" for row in table]) for table in tables]
    assert abs(pair[0] - pair[1]) < 4 * math.sqrt(pair[0] * (1 - pair[0]) * (1 / 600 + 1 / 150))


BESIDE = "must be left out if states is given"


@pytest.mark.parametrize(("old", "new", "wanted", "line"), [
    *[("states = 150", f"states = {v}", "1 <= states <= 12500000", 3)
      for v in ("0", "-1", "1.5", "12500001", "x")],
    *[("seed = 4", f"seed = {v}", "0 <= seed <= 2147483647", 3) for v in ("-1", "2147483648", "1.5", "4, 5", "x")],
    ("states = 150, ", "", "seed = 4: must be left out: it requires states", 3),
    ("states = 150, seed = 4", "", "axes: is missing; must be two of 'x'", 2),
    *[("probes = 50", f"{key} = {v}", f"{key} = {v}: {BESIDE}", 4) for key, v in (
        ("axes", "'x', 'y'"), ("low", "0, 0"), ("high", "1, 1"), ("values", "9, 9"), ("t", "0"), ("x", "1"),
        ("x_dot", "1"), ("y", "0"), ("z_dot", "2"))],
])  # fmt: skip
def test_bad_random_states(old, new, wanted, line, batch):
    assert old in RANDOM
    assert_refused(RANDOM.replace(old, new, 1), "basins", wanted, line, batch)


@pytest.mark.parametrize("name", ["x", "low", "inverse_clearance", "probes", "2*x"])
def test_a_name_is_no_number(name, batch):
    """A name in place of a number is refused; the compiler's reader would take it for an omitted number."""
    assert_refused(RANDOM.replace("= 50", f"= {name}"), "basins", "1 <= probes", 4, batch)
    text = DIAGRAM.replace("low = 20", f"low = 20, {name}")
    assert_refused(text, "bifurcation", "a number in the range of the parameter", 3, batch)


def test_a_plane_has_no_seed(batch):
    assert_refused(
        PLANE.replace("probes", "seed = 1, probes"), "basins", "it requires states", 5, batch
    )
