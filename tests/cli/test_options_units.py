"""Options whose values have units: they give the case that bare numbers give."""

import pytest
from vibroimpact.cases.case import read_namelist

RIG = ["--mass", "2.7 kg", "--stiffness", "42 kN/m", "--force", "6 N", "--restitution", "0.7"]
SHARES = ["--xi", "0.011", "--mu", "0.04"]


def keys_of(tool, cwd, *words):
    """The keys of &system and of the study of the case that a command ran."""
    done = tool(*words)
    assert done.status == 0, done
    (case,) = read_namelist(cwd / f"results/{words[0]}.csv")
    return case.osc, case.keys


def test_values_with_units(tool, tmp_path):
    """Frequency, clearance, damping and free mass with units are r, d K/F0, xi and mu."""
    osc, keys = keys_of(
        tool, tmp_path, "simulate", *RIG, "--damping", "7.4 N s/m", "--free-mass", "0.11 kg",
        "--r", "19.5 Hz", "--clearance", "4 mm", "--cycles", "3", "--state", "-1 mm", "2 mm/s", "0", "0",
    )  # fmt: skip
    units = osc.units()
    assert (osc.xi, osc.mu) == pytest.approx((7.4 / (2 * (42e3 * 2.7) ** 0.5), 0.11 / 2.7))
    assert keys["clearance"] == pytest.approx(units.clearance("4 mm"), rel=1e-14)
    assert [keys[name] for name in ("x", "x_dot", "z", "z_dot")] == pytest.approx(
        [-1e-3 / units.length, 2e-3 / units.velocity, 0, 0]
    )


def test_bare_numbers_in_units(tool, tmp_path):
    """With --units bare numbers have the unit of their kind; a frequency without one is r."""
    words = ["zone", *RIG, *SHARES, "--sides", "RL", "--lines", "5", "--guesses", "1"]
    _, ours = keys_of(
        tool, tmp_path, *words, "--r", "18 Hz", "21 Hz", "--clearance", "2 mm", "6 mm"
    )
    osc, theirs = keys_of(
        tool, tmp_path, *words, "--units", "mm N s",
        "--r", "18 Hz", "21 Hz", "--clearance", "2", "6",
    )  # fmt: skip
    assert theirs == ours
    assert ours["r_max"] == pytest.approx(21 / osc.units().frequency, rel=1e-14)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--r", "19.5 mm"], "1e-6 <= r <= 1e6; its unit is not that of a frequency"),
        (["--r", "19.5 Hx"], "--r '19.5 Hx': must be a number with 1e-6 <= r <= 1e6; unknown unit Hx"),
        (["--r", "19.5x"], "--r 19.5x: must be a number"),
        (["--clearance", "4"], "1e-12 <= clearance <= 1e12; a number without a unit can be read in two ways"),
    ],
)  # fmt: skip
def test_wrong_units(words, message, tool):
    """A unit of another kind, an unknown one, and a number in either of two units are refused by the option."""
    given = {"--r": "19.5 Hz", "--clearance": "4 mm"} | dict([words])
    done = tool(
        "simulate",
        *RIG,
        *SHARES,
        "--cycles",
        "3",
        *[word for pair in given.items() for word in pair],
    )
    assert done.status == 2
    assert message in str(done)


def test_units_need_a_mass(tool):
    done = tool(
        "simulate", *RIG[-2:], *SHARES, "--cycles", "3", "--r", "19.5 Hz", "--clearance", "9"
    )
    assert (done.status, "&system must have mass and stiffness" in str(done)) == (2, True)
