"""Lyapunov exponents in namelists: laws, and agreement of both programs with the API."""

import math

import numpy as np
import pytest
from attractors import EQUAL, FREE, LYAPUNOV, MOVING, WALLS, assert_both, case_of
from programs import assert_refused, column, contents, rows


def assert_lyapunov(table, result):
    """Every digit of the table is that of the API's exponents."""
    assert column(table, "r").tolist() == np.broadcast_to(result.r, len(table)).tolist()
    assert column(table, "clearance").tolist() == result.clearance.ravel().tolist()
    exponents = result.per_cycle.reshape(4, -1)
    errors = (result.standard_error * (2 * np.pi / result.r)).reshape(4, -1)
    for i in range(4):
        np.testing.assert_array_equal(column(table, f"exponent_{i + 1}"), exponents[i])
        np.testing.assert_array_equal(column(table, f"error_{i + 1}"), errors[i])
    for name in ("dimension", "identity_error", "impacts", "rests"):
        np.testing.assert_array_equal(column(table, name), getattr(result, name).ravel())


@pytest.mark.parametrize("text", [
    LYAPUNOV,
    LYAPUNOV.replace("EQUAL", "").replace(", r = 1.04", "")
    .replace("'clearance'", "'R', clearance = 20").replace("low = 5, high = 40", "low = 0.98, high = 1.06"),
    f"{WALLS}&lyapunov clearance = 6, cycles = 200, batches = 7, discard = 100, load = 1.1, {MOVING} /\n",
    f"{EQUAL}&lyapunov clearance = 20, cycles = 100, t = 1.5, x = -3, x_dot = 5, z = 2, z_dot = -4 /\n",
])  # fmt: skip
def test_exponents_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    assert_lyapunov(table, case_of(batch).run()[0])


def test_sum_of_exponents_is_that_of_volume(batch):
    """In periodic motion the sum is -4 pi xi/r + (impacts a cycle) 2 log R per load cycle."""
    assert batch.case(LYAPUNOV.replace("discard = 300", "discard = 1500")).status == 0
    table = rows(batch.cwd / "results/case.csv")
    sums = sum(column(table, f"exponent_{i}") for i in range(1, 5))
    volume = -4 * math.pi * 0.0114 / 1.04 + 2 * math.log(0.75) * column(table, "impacts") / 400
    periodic = column(table, "exponent_1") < -1e-2
    assert periodic.sum() > 3
    assert not periodic.all()
    np.testing.assert_allclose(sums[periodic], volume[periodic], rtol=1e-9)
    assert column(table, "identity_error").max() < 1e-12


def test_exponents_are_those_of_the_multipliers(batch):
    """The exponents are those of the multipliers of the stable motion, given by &motion in the same file."""
    motion = "&motion kind = 'equispaced', clearance = 30 /\n"
    study = f"&lyapunov clearance = 30, cycles = 400, discard = 2000, {MOVING} /\n"
    assert batch.case(EQUAL + motion + study).status == 0
    stable = [row for row in rows(batch.cwd / "results/case_1.csv") if row["stable"] == "true"]
    (row,) = rows(batch.cwd / "results/case_2.csv")
    moduli = [
        math.hypot(float(stable[0][f"multiplier_{i}_re"]), float(stable[0][f"multiplier_{i}_im"]))
        for i in range(1, 5)
    ]
    exponents = [float(row[f"exponent_{i}"]) for i in range(1, 5)]
    np.testing.assert_allclose(exponents, np.log(sorted(moduli, reverse=True)), atol=1e-6)


def test_rest_extinguishes_two_directions(batch):
    """With rest two exponents are -inf, written as Python reads it."""
    assert batch.case(f"{WALLS}&lyapunov clearance = 6, cycles = 100, {MOVING} /\n").status == 0
    (row,) = rows(batch.cwd / "results/case.csv")
    assert (row["exponent_3"], row["exponent_4"], row["error_4"]) == (
        "-inf", "-inf", "0.0000000000000000E+000",
    )  # fmt: skip
    assert int(row["rests"]) >= 100


def test_points_without_impacts(batch, command):
    """Points without impacts have rows of nan and status 1; without any impact there is a message and no file."""
    far = LYAPUNOV.replace("high = 40", "high = 4000")
    table = assert_both(far, batch, command, status=1)
    assert table[-1]["exponent_1"] == "nan"
    assert table[0]["exponent_1"] != "nan"
    done = batch.case(far.replace("low = 5", "low = 3900"), "-o", "none")
    assert (done.status, done.out) == (1, b"")
    assert done.faults == ["case: no exponents at 6 of 6 points: no impacts in a batch"]
    assert not (batch.cwd / "none").exists() or not contents(batch.cwd / "none")


BAD_LYAPUNOV = [
    *[("parameter = 'clearance'", f"parameter = {v}", "'r' or 'clearance'", 2)
      for v in ("'xi'", "'q'", "''", "r", "1")],
    ("parameter = 'clearance'\n  low = 5, high = 40, values = 6", "clearance = 9, 10",
     "one number, or 1, one for each r", 2),
    *[("low = 5", f"low = {v}", "1e-12 <= clearance <= 1e12", 3) for v in ("nan", "0", "-1", "5, 6")],
    *[("high = 40", f"high = {v}", "1e-12 <= clearance <= 1e12", 3) for v in ("5", "1", "nan", "1e13")],
    *[("values = 6", f"values = {v}", "2 <= values", 3) for v in ("1", "0", "6, 7", "2000000")],
    ("low = 5, high", "high", "&lyapunov low: is missing", 2),
    *[("cycles = 400", f"cycles = {v}", "2 batches <= cycles", 4) for v in ("39", "0", "-1", "2000000000")],
    ("cycles = 400", "cycles = 1e3", "2 batches <= cycles", 4),
    *[("cycles = 400", f"batches = {v}", "2 <= batches <= 1000", 4) for v in ("1", "1001")],
    ("discard = 300", "discard = -1", "0 <= discard", 4),
    ("discard = 300", "load = -1", "0 <= load", 4),
    ("discard = 300", "load = nan", "0 <= load", 4),
    *[("discard = 300", f"{v} = inf", f"a number with -1e100 <= {v} <= 1e100", 4) for v in ("t", "x", "z")],
    ("discard = 300", "z = 2.6", "z - x must be within half the clearance", 4),
    ("discard = 300", "clearance = 3", "must be left out: it is the parameter", 4),
    ("discard = 300", "states = 3", "is not a key of &lyapunov; must be one of clearance", 4),
    ("parameter = 'clearance'\n", "clearance = 9\n", "low = 5: must be left out: it requires parameter", 3),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_LYAPUNOV)
def test_bad_lyapunov(old, new, wanted, line, batch):
    assert old in LYAPUNOV
    assert_refused(LYAPUNOV.replace(old, new, 1), "lyapunov", wanted, line, batch)


def test_clearance_is_missing(batch):
    assert_refused(f"{EQUAL}&lyapunov {MOVING} /\n", "lyapunov", "clearance: is missing", 2, batch)


def test_r_is_where_it_belongs(batch):
    """r belongs to &system unless it is the parameter; r elsewhere, missing or given twice is refused."""
    along_r = "&lyapunov parameter = 'r', low = .9, high = 1, values = 3, clearance = 9 /\n"
    assert_refused(EQUAL + along_r, "system", "r = 1.04: must be left out", 1, batch)
    assert_refused(
        FREE + f"&lyapunov clearance = 9, {MOVING} /\n", "system", "r: is missing", 1, batch
    )
    both = along_r.replace(" /", ", r = .9, 1 /")
    assert_refused(
        FREE + both, "lyapunov", "r = .9, 1: must be left out if parameter is given", 2, batch
    )
    undamped = FREE.replace("0.0114", "0")
    assert_refused(undamped + along_r, "lyapunov", "r = 1 with xi = 0", 2, batch)
