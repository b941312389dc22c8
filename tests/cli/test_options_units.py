"""Options whose values have units give the same case as bare numbers."""

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
    """With --units bare numbers have the unit of their kind; a bare frequency is r."""
    words = ["zone", *RIG, *SHARES, "--sides", "RL", "--lines", "5", "--guesses", "1"]
    _, ours = keys_of(
        tool, tmp_path, *words, "--r", "18 Hz", "21 Hz", "--clearance", "2 mm", "6 mm"
    )
    osc, theirs = keys_of(
        tool, tmp_path, *words, "--units", "mm N s",
        "--r", "18 Hz", "21 Hz", "--clearance", "2", "6",
    )  # fmt: skip
    assert theirs.pop("units") == "mm N s"  # also those of the result
    assert theirs == ours
    assert ours["r_max"] == pytest.approx(21 / osc.units().frequency, rel=1e-14)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--r", "19.5 mm"], "1e-6 <= r <= 1e6; its unit is not that of a frequency"),
        (["--r", "19.5 Hx"], "--r '19.5 Hx': must be a number with 1e-6 <= r <= 1e6; unknown unit Hx"),
        (["--r", "19.5x"], "--r 19.5x: must be a number"),
        (["--clearance", "4"], "1e-12 <= clearance <= 1e12; a number without a unit can be read in two ways"),
        (["--clearance", "-4 mm"], "1e-12 <= clearance <= 1e12; -4 mm is -28 F0/K"),
        (["--r", "0 Hz"], "1e-6 <= r <= 1e6; 0 Hz is 0 omega"),
        (["--clearance", ""], "--clearance '': must be a number"),
    ],
)  # fmt: skip
def test_wrong_units(words, message, tool):
    """The option refuses a unit of another kind, an unknown unit, and a number whose unit is ambiguous."""
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


def test_a_reversed_range_is_named_as_given(tool):
    """The lower end in the message is what was typed."""
    words = ["zone", *RIG, *SHARES, "--sides", "RL"]
    done = tool(*words, "--r", "22 Hz", "19 Hz", "--clearance", "3 mm", "5 mm")
    assert done.status == 2
    assert (
        "--r 22 Hz 19 Hz: must have 1e-6 <= HIGH <= 1e6, and LOW below HIGH; LOW is '22 Hz'"
        in str(done)
    )


@pytest.mark.parametrize(("given", "mu"), [("0.108 kg", 0.04), ("108 g", 0.04), ("4 %", 0.04)])
def test_a_mass_ratio_takes_a_mass_or_a_percentage(given, mu, tool, tmp_path):
    """--mu takes the free mass or its share of M, as in Python."""
    words = [*RIG, *SHARES, "--r", "19.5 Hz", "--clearance", "4 mm", "--cycles", "3"]
    at = words.index("--free-mass") if "--free-mass" in words else words.index("--mu")
    words[at : at + 2] = ["--mu", given]
    osc, _ = keys_of(tool, tmp_path, "simulate", *words)
    assert osc.mu == pytest.approx(mu, rel=1e-14)


def test_results_in_units(tool, tmp_path):
    """A table is in the units of the rig, with mm for m, in requested units, or dimensionless."""
    words = [
        "zone",
        *RIG,
        *SHARES,
        "--sides",
        "RL",
        "--lines",
        "5",
        "--guesses",
        "1",
        "--r",
        "19 Hz",
        "21 Hz",
    ]
    found = {}
    for units, window in {
        "": "2 mm",
        "SI": "0.002",
        "in lbf s": "0.1",
        "dimensionless": "14",
    }.items():
        more = ["--units", units] if units else []
        done = tool(
            *words,
            *more,
            "--clearance",
            window,
            # both ends are dimensionless, or both are lengths
            "53.34" if units == "dimensionless" else "0.3 in",
            "-o",
            f"results/{units[:3].strip() or 'own'}.csv",
        )
        assert done.status == 0, done
        lines = (tmp_path / f"results/{units[:3].strip() or 'own'}.csv").read_text().splitlines()
        names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
        column = names.index("clearance")
        found[units] = lines[0], max(float(row[column]) for row in rows)
        assert ("r" in names, "frequency" in names) == (
            units == "dimensionless",
            units != "dimensionless",
        )
        assert read_namelist(tmp_path / f"results/{units[:3].strip() or 'own'}.csv")  # an input too
    assert "frequency Hz, clearance mm" in found[""][0]
    assert "clearance m" in found["SI"][0]
    assert "clearance in" in found["in lbf s"][0]
    length = 6 / 42
    wanted = [7.62, 7.62e-3, 0.3, 7.62 / length]
    assert [most for _, most in found.values()] == pytest.approx(wanted, rel=1e-12)


def test_units_of_files(tool, tmp_path):
    """`run --units` converts to other units; a system without units is refused by name."""
    text = "&system units = 'SI', mass = '2700 g', stiffness = 42e3, force = 6, xi = .01, mu = .04"
    (tmp_path / "rig.nml").write_text(
        text + ", restitution = 1, r = 1.1 / &simulate clearance = 0.004, cycles = 2, z = 0.001 /\n"
    )
    (tmp_path / "bare.nml").write_text(
        "&system xi = .01, mu = .04, restitution = 1, r = 1.1 / &simulate clearance = 28, cycles = 2 /\n"
    )
    for units, unit in (
        ("", "x mm"),
        ("mm N s", "x mm"),
        ("SI", "x m"),
        ("dimensionless", "lengths in F0/K"),
    ):
        assert tool("run", "rig.nml", *(["--units", units] if units else [])).status == 0
        with open(tmp_path / "results/rig.csv") as file:
            assert unit in file.readline()
    done = tool("run", "bare.nml", "--units", "SI")
    assert (done.status, "must be left out for bare, whose &system has no mass" in str(done)) == (
        2,
        True,
    )
    (tmp_path / "bare.nml").write_text(
        (tmp_path / "bare.nml").read_text() + "&output units = 'mm N s' /\n"
    )
    done = tool("run", "bare.nml")
    assert (
        done.status,
        "without mass, stiffness and force in &system it must be left out" in str(done),
    ) == (2, True)


def test_units_need_a_mass(tool):
    done = tool(
        "simulate", *RIG[-2:], *SHARES, "--cycles", "3", "--r", "19.5 Hz", "--clearance", "9"
    )
    assert (done.status, "&system must have mass and stiffness" in str(done)) == (2, True)


def test_units_of_a_structure_with_scales(tool, tmp_path):
    """`run` and `plot` convert the results of a dimensionless structure with scales; without them they refuse."""
    text = (
        "&structure mass = 1, 0.04, damping = 0.02, 0, stiffness = 1, 0{} /\n"
        "&gap direction = -1, 1, opening = 14, restitution = 0.75 /\n"
        "&gap direction = 1, -1, opening = 14, restitution = 0.75 /\n"
        "&friction direction = -1, 1, slip = 0.01 /\n"
        "&load frequency = 1.03, sine = 1, 0 /\n&simulate cycles = 3 /\n"
    )
    (tmp_path / "scaled.nml").write_text(text.format(", scales = 2.7, 42e3, 6"))
    (tmp_path / "bare.nml").write_text(text.format(""))
    found = {}
    for units in ("mm N s", "in lbf s", "dimensionless"):
        assert tool("run", "scaled.nml", "--units", units).status == 0
        rows = (tmp_path / "results/scaled.csv").read_text().splitlines()
        names, *rows = [row.split(",") for row in rows if not row.startswith("#")]
        found[units] = float(rows[-1][names.index("q_1")])
    length = 6 / 42e3
    assert found["mm N s"] == pytest.approx(1e3 * length * found["dimensionless"], rel=1e-13)
    assert found["in lbf s"] == pytest.approx(found["mm N s"] / 25.4, rel=1e-13)
    assert tool("plot", "scaled.nml", "--units", "mm N s").status == 0
    for command in ("run", "plot"):
        done = tool(command, "bare.nml", "--units", "SI")
        wanted = "must be left out for bare, whose &structure has no scales"
        assert (done.status, wanted in str(done)) == (2, True)
