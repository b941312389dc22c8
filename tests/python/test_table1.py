"""Table 1 of the paper, from the package, the reference and the printed digits."""

import csv
from pathlib import Path

import first_principles as fp
import numpy as np
import pytest
import vibroimpact as vi

DATA = Path(__file__).parent.parent / "data" / "table1.csv"
COLUMNS = ("equispaced_1", "equispaced_2", "unequispaced")
SYSTEM = fp.System(0.005, 0.042, 0.94, "RL", 1, (0.75, 0.75))
D = 37.0

# the recomputed digits, as text: half a unit of the last one is the tolerance
DIGITS = {
    "load_phase/pi": "0.6807 -0.5323 0.5256",
    "tau/pi": "0.6550 -0.5579 0.4999",
    "X_1": "16.171 -5.095 13.653",
    "X_2": "-16.171 5.095 -9.316",
    "X_dot_after_1": "-2.217 -0.857 5.471",
    "X_dot_after_2": "2.217 0.857 9.914",
    "X_dot_before_1": "-3.960 -1.531 3.724",
    "X_dot_before_2": "3.960 1.531 11.660",
    "Z_dot_after_1": "-20.748 -8.022 -13.098",
    "Z_dot_after_2": "20.748 8.022 28.482",
    "modulus_1": "3.8284 12.0742 0.9347",
    "modulus_2": "0.9485 0.9910 0.9347",
    "modulus_3": "0.9485 0.9910 0.5820",
    "modulus_4": "0.0859 0.02496 0.5820",
}

with DATA.open(encoding="utf-8") as file:
    ROWS = list(csv.DictReader(line for line in file if not line.startswith("#")))


def last_digit(text):
    """One unit of the last digit of a printed number."""
    return 10.0 ** -len(text.partition(".")[2])


@pytest.fixture(scope="module")
def motions():
    """The three motions from the package."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    pair = vi.equispaced(osc, r=0.94, clearance=D)
    assert len(pair) == 2
    pair.sort(key=lambda motion: -motion.X[0])
    other = vi.periodic(osc, 0.94, [0.0, 1.37 * np.pi], vi.Pattern("RL", cycles=1))
    return dict(zip(COLUMNS, [*pair, other], strict=True))


def quantities(motion):
    """Every row of the table by name, in the unit of length d/37 of the paper."""
    unit = D / motion.clearance
    lag = np.arctan2(2 * motion.osc.xi * motion.r, 1 - motion.r**2)
    rows = {
        "alpha_2/pi": motion.alpha[1] / np.pi,
        "tau/pi": motion.tau / np.pi,
        "load_phase/pi": (motion.tau + lag) / np.pi,
        "x_min": unit * motion.x_min,
        "x_max": unit * motion.x_max,
    }
    for name in ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_after"):
        for i in range(2):
            rows[f"{name}_{i + 1}"] = unit * getattr(motion, name)[i]
    for i in range(4):
        rows[f"modulus_{i + 1}"] = abs(motion.multipliers[i])
    return rows


@pytest.mark.parametrize("column", COLUMNS)
def test_recomputed_digits(motions, column):
    """The package agrees with the recomputed table to half a unit of the last digit."""
    found = quantities(motions[column])
    for name, row in DIGITS.items():
        text = row.split()[COLUMNS.index(column)]
        assert abs(found[name] - float(text)) <= 0.5001 * last_digit(text), name


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['quantity']}-{row['column']}")
def test_every_row(motions, row):
    """Each entry agrees with six recomputed decimals, and with the printed digits unless these are misprints."""
    found = quantities(motions[row["column"]])[row["quantity"]]
    assert found == pytest.approx(float(row["recomputed"]), abs=6e-7)
    printed = abs(found - float(row["printed"])) <= last_digit(row["printed"])
    assert printed is not row["note"].startswith("misprint")


def test_the_file_is_complete():
    """The file has nineteen quantities in three columns, with two misprints."""
    pairs = {(row["quantity"], row["column"]) for row in ROWS}
    assert len(ROWS) == len(pairs) == 19 * 3
    assert sum(row["note"].startswith("misprint") for row in ROWS) == 2
    assert list(ROWS[0]) == ["quantity", "column", "printed", "recomputed", "note"]


def test_the_misprints_break_laws_by_their_own_neighbours():
    """Momentum requires 9.91 and the determinant requires 0.025, from the printed numbers alone."""
    printed = {(row["quantity"], row["column"]): float(row["printed"]) for row in ROWS}

    def entry(name):
        return printed[name, "unequispaced"]

    momentum = SYSTEM.mu * (entry("Z_dot_after_1") - entry("Z_dot_after_2"))
    assert entry("X_dot_before_2") + momentum == pytest.approx(9.91, abs=0.01)
    determinant = np.exp(-4 * np.pi * SYSTEM.xi / SYSTEM.r) * 0.75**4
    others = [printed[f"modulus_{i}", "equispaced_2"] for i in (1, 2, 3)]
    assert determinant / np.prod(others) == pytest.approx(0.025, abs=0.0005)


def test_verdicts(motions):
    """The first two columns are unstable, the third is stable; all are physical."""
    assert [motions[column].stable for column in COLUMNS] == [False, False, True]
    assert all(motions[column].consistent is True for column in COLUMNS)
    assert all(motions[column].admissible is True for column in COLUMNS)
    for motion in motions.values():
        assert np.prod(motion.multipliers) == pytest.approx(0.295948, abs=5e-7)


def test_the_reference_agrees(motions):
    """The package and the independent reference agree to rounding."""
    pair = sorted(fp.equispaced(SYSTEM, D), key=lambda motion: -motion.X[0])
    other = fp.solve(SYSTEM, np.array([0.0, 1.37 * np.pi]))
    for motion, expected in zip(motions.values(), [*pair, other], strict=True):
        assert motion.clearance == pytest.approx(expected.clearance, rel=1e-12)
        for name in ("X", "Z", "X_dot_before", "X_dot_after", "Z_dot_before", "Z_dot_after"):
            have, wanted = getattr(motion, name), getattr(expected, name)
            assert np.abs(have - wanted).max() <= 1e-11 * np.abs(wanted).max(), name


def test_third_column_is_not_the_exact_motion_at_37(motions):
    """With 1.37 pi the clearance is 38.22; at 37 the exact motion has other numbers."""
    column = motions["unequispaced"]
    assert column.clearance == pytest.approx(38.22, abs=0.005)
    exact = fp.newton(SYSTEM, np.array([0.0, 1.37 * np.pi]), clearance=D)
    assert exact.clearance == pytest.approx(D, rel=1e-12)
    found = quantities(column)
    assert exact.X[0] / found["X_1"] - 1 == pytest.approx(0.012, abs=5e-4)
    assert exact.X_dot_after[0] / found["X_dot_after_1"] - 1 == pytest.approx(0.06, abs=5e-3)
    again = vi.periodic(column.osc, 0.94, exact.alpha, column.pattern)
    assert again.clearance == pytest.approx(D, rel=1e-11)
    assert again.stable is True
