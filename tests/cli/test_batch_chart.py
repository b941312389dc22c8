"""Charts of the program: the digits of Python, the header, empty windows, invalid input."""

import numpy as np
import pytest
import vibroimpact as vi
from programs import contents, rows

SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
CHART = """&chart
  sides = 'RL'
  cycles = 1
  r_min = 0.85
  r_max = 1.1
  r_points = 12
  clearance_min = 3
  clearance_max = 60
  clearance_points = 11
  spacing = 'geometric'
  symmetric = 'both'
/
"""
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
WORDS = {"true": 1, "false": 0, "unknown": -1}
CHOICES = {"both": None, "yes": True, "no": False}


@pytest.mark.usefixtures("same_build")
@pytest.mark.parametrize(
    ("sides", "symmetric"),
    [("RL", "both"), ("RL", "yes"), ("RL", "no"), ("RRL", "both"), ("RRLL", "yes")],
)
def test_digits_of_python(batch, sides, symmetric):
    """Each row has the digits of the dataset of `chart`."""
    pytest.importorskip("xarray")
    text = SYSTEM + CHART.replace("'RL'", f"'{sides}'").replace("both", symmetric)
    assert batch.case(text).status == 0
    table = rows(batch.cwd / "results/case.csv")
    r, clearance = (sorted({float(row[name]) for row in table}) for name in ("r", "clearance"))
    assert len(r) <= 12
    full_r = np.linspace(0.85, 1.1, 12)
    assert set(r) <= set(full_r.tolist())
    full = np.array(clearance)
    if full.size < 11:  # clearances without any motion have no row
        missing = np.geomspace(3, 60, 11)
        full = np.array([*clearance, *missing[full.size :]])
    data = vi.chart(OSC, vi.Pattern(sides), full_r, full, symmetric=CHOICES[symmetric])
    seen = 0
    for row in table:
        item = data.sel(r=float(row["r"]), clearance=float(row["clearance"]))
        item = item.isel(motion=int(row["slot"]) - 1)
        seen += 1
        assert int(item.status) == int(row["status"])
        assert float(item.x_max) == float(row["x_max"])
        assert float(item.multiplier_modulus[0]) == float(row["multiplier_1_modulus"])
        for name in ("consistent", "admissible", "stable"):
            assert int(item[name]) == WORDS[row[name]]
    assert seen == int((data.status == 0).sum())


def test_result_is_an_input(batch):
    """Running the result writes the same bytes again."""
    assert batch.case(SYSTEM + CHART).status == 0
    before = contents(batch.cwd / "results")
    assert batch("results/case.csv", "-o", "again").status == 0
    assert contents(batch.cwd / "again") == before


def test_empty_window(batch):
    """A window without motions gives a message, status 1, and no file."""
    text = SYSTEM + CHART.replace("= 3", "= 3000").replace("= 60", "= 9000")
    outcome = batch.case(text)
    assert outcome.status == 1
    assert outcome.faults == ["case: no motion RL/1 was found anywhere in the window"]
    assert not (batch.cwd / "results").exists() or not contents(batch.cwd / "results")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("r_min = 0.85", "r_min = nan", "1e-6 <= r_min"),
        ("r_min = 0.85", "r_min = 0", "1e-6 <= r_min"),
        ("  r_min = 0.85\n", "", "r_min: is missing"),
        ("r_max = 1.1", "r_max = 0.85", "r_min below r_max"),
        ("r_max = 1.1", "r_max = 0.5", "r_min below r_max"),
        ("r_max = 1.1", "r_max = inf", "r_max <= 1e6"),
        ("clearance_min = 3", "clearance_min = -1", "1e-12 <= clearance_min"),
        ("clearance_max = 60", "clearance_max = 2", "clearance_min below clearance_max"),
        ("clearance_max = 60", "clearance_max = nan", "clearance_max <= 1e12"),
        ("r_points = 12", "r_points = 1", "at least 2"),
        ("  r_points = 12\n", "", "r_points: is missing"),
        ("r_points = 12", "r_points = 2000000", "<= 1000000"),
        ("clearance_points = 11", "clearance_points = 100000", "<= 1000000"),
        ("clearance_points = 11", "clearance_points = 1.5", "whole number"),
        ("'geometric'", "'cubic'", "'linear' or 'geometric'"),
        ("'both'", "'some'", "'yes' (only"),
        ("'both'", "''", "'yes' (only"),
        ("cycles = 1", "cycles = 2, symmetric = 'yes'", "given before"),
        ("cycles = 1", "cycles = 0", "1 <= cycles"),
        ("'RL'", "'RR'", "each wall at least once"),
        ("'RL'", "'RLRLRLRLRLRLRL'", "2 to 12"),
        ("cycles = 1", "slots = 33", "slots <= 32"),
        ("cycles = 1", "seeds = 0", "1 <= seeds"),
        ("cycles = 1", "guesses = 0", "1 <= guesses"),
        ("cycles = 1", "load = 1", "is not a key of &chart"),
    ],
)
def test_bad_input(batch, old, new, words):
    """One line with file, line, group and key; status 2; nothing written."""
    assert old in CHART
    outcome = batch.case(SYSTEM + CHART.replace(old, new, 1))
    assert outcome.status == 2
    (fault,) = outcome.faults
    assert fault.startswith("case.nml:")
    assert "&chart" in fault
    assert words in fault
    assert not (batch.cwd / "results").exists()


def test_symmetry_that_cannot_be(batch):
    """symmetric = 'yes' is refused for a pattern that allows no symmetric motion."""
    outcome = batch.case(SYSTEM + CHART.replace("'both'", "'yes'").replace("'RL'", "'RRL'"))
    assert outcome.status == 2
    assert "second half mirrors the first" in outcome.faults[0]


def test_r_of_the_system(batch):
    """A chart alone must not have r in &system; a chart followed by a motion must."""
    given = SYSTEM.replace(" /", ", r = 0.9 /")
    outcome = batch.case(given + CHART)
    assert outcome.status == 2
    assert "&system r = 0.9: must be left out" in outcome.faults[0]
    motion = "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n"
    assert batch.case(given + CHART + motion).status == 0
    outcome = batch.case(SYSTEM + CHART + motion)
    assert outcome.status == 2
    assert "&system r: is missing" in outcome.faults[0]
