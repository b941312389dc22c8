"""Motions by namelists: the header, the equispaced pair, printouts, and the status of several files."""

import math

import pytest
import vibroimpact as vi
from programs import (
    COMPLETE,
    PAIR,
    ROOT,
    SYSTEM,
    assert_same,
    chain,
    contents,
    floats,
    motions,
    rows,
    write,
)

OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)


def test_header_echoes_the_complete_case(batch):
    """The header holds every key, including defaults, as a namelist in comment lines."""
    batch.case(COMPLETE)
    text = (batch.cwd / "results/case.csv").read_text()
    header = [line for line in text.splitlines() if line.startswith("#")]
    for key in ("xi", "mu", "restitution", "r", "kind", "cycles", "sides", "phases", "precision",
                "acceptance", "name", "format"):  # fmt: skip
        assert sum(line.startswith(f"#   {key} = ") for line in header) == 1, key
    assert vi.__version__ in header[0]
    assert header == text.splitlines()[: len(header)]


def test_numbers_are_es24_16(batch):
    """Every number of the table has 17 digits, one before the point, and an exponent."""
    import re

    batch.case(PAIR)
    words = {"motion", "impact", "side", "consistent", "admissible", "stable"}
    for row in rows(batch.cwd / "results/case.csv"):
        for key in row.keys() - words:
            assert re.fullmatch(r"-?\d\.\d{16}E[+-]\d{2,3}", row[key]), (key, row[key])


@pytest.mark.parametrize("precision", ["double", "single"])
@pytest.mark.parametrize("cycles", [1, 3])
def test_equispaced_pair(precision, cycles, batch, same_build):
    """The two equispaced motions are their own mirror images, and equal those of the API."""
    done = batch.case(
        f"{SYSTEM}&motion kind = 'equispaced', clearance = 37, cycles = {cycles}\n"
        f"precision = '{precision}' /"
    )
    assert (done.status, len(done.out.splitlines())) == (0, 2)
    found = motions(batch.cwd / "results/case.csv")
    expected = vi.equispaced(OSC, 0.94, 37.0, cycles, precision)
    assert len(found) == len(expected) == 2
    for motion, other in zip(found, expected, strict=True):
        assert_same(motion, other)
        assert floats(motion, "x")[0] == -floats(motion, "x")[1]
        assert floats(motion, "z_dot_after")[0] == -floats(motion, "z_dot_after")[1]


def test_no_equispaced_motion(batch, command):
    """If there is no equispaced motion the status is 1, one line says so, and the result has no rows."""
    done = batch.case(SYSTEM + "&motion kind = 'equispaced', clearance = 200 /")
    assert (done.status, done.out, done.faults) == (
        1, b"", ["case: there is no such motion for these parameters"])  # fmt: skip
    assert rows(batch.cwd / "results/case.csv") == []
    text = (batch.cwd / "results/case.csv").read_text()
    assert text.count("there is no such motion") == 1
    assert command("case.nml", "-o", "again") == done
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")
    assert batch("results/case.csv", "-o", "third").status == 1
    assert contents(batch.cwd / "third") == contents(batch.cwd / "results")


def largest_clearance(r):
    """The largest clearance with an equispaced motion, bisected down to adjacent numbers."""
    low, high = 1.0, 1e4
    while low < (middle := 0.5 * (low + high)) < high:
        if vi.equispaced(OSC, r, middle):
            low = middle
        else:
            high = middle
    return low


def test_one_equispaced_motion(batch, same_build):
    """Where line and circle touch there is one motion, with status 0."""
    touching = ((r, largest_clearance(r)) for r in (0.9, 0.91, 0.93, 0.94, 0.95, 0.97, 0.98))
    r, clearance = next(
        pair for pair in touching if len(vi.equispaced(OSC, *pair)) == 1
    )  # fmt: skip
    done = batch.case(
        SYSTEM.replace("r = 0.94", f"r = {r!r}")
        + f"&motion kind = 'equispaced', clearance = {clearance!r} /"
    )
    assert (done.status, done.err) == (0, b"")
    (motion,) = motions(batch.cwd / "results/case.csv")
    assert_same(motion, vi.equispaced(OSC, r, clearance)[0])


def test_free_amplitude_is_status_1(batch):
    """Equal durations with equal R do not determine A: status 1, since there is no single motion."""
    done = batch.case(PAIR.replace("1.37", "1"))
    assert done.status == 1
    assert "equispaced" in done.faults[0]


def test_worst_status_wins(batch):
    """Statuses 0, 1 and 2 in one call give 2, and 0 and 1 give 1; every valid case runs."""
    write(batch.cwd / "none.nml", SYSTEM + "&motion kind = 'equispaced', clearance = 200 /")
    write(batch.cwd / "good.nml", PAIR)
    assert batch("none.nml", "good.nml").status == 1
    assert batch("none.nml", "good.nml", "nope.nml").status == 2
    assert sorted(contents(batch.cwd / "results")) == ["good.csv", "none.csv"]


def test_legacy_printout(batch):
    """The printout of the third column of Table 1 has the printed numbers, in units of F0/K."""
    write(batch.cwd / "table1.nml", (ROOT / "inputs/table1.nml").read_bytes())
    assert batch("table1.nml").status == 0
    names = [f"table1_{kind}spaced.{end}" for kind in ("equi", "unequi") for end in ("csv", "txt")]
    assert sorted(contents(batch.cwd / "results")) == names
    text = (batch.cwd / "results/table1_unequispaced.txt").read_text()
    table = {line[:16].strip(): line[16:].split() for line in text.splitlines()}
    assert table["alpha_i/pi"] == ["0.0000", "1.3700"]
    assert table["tau/pi"] == ["0.4999"]
    # the phase of the load at the first impact, from the column that was recomputed from first principles
    given = (ROOT / "tests/data/table1.csv").read_text().splitlines()
    (phase,) = (line.split(",") for line in given if line.startswith("load_phase/pi,unequispaced"))
    assert table["Omega t_1/pi"] == [f"{float(phase[3]):.4f}"]
    assert table["|eigenvalues|"] == ["0.9347", "0.9347", "0.5820", "0.5820"]
    assert "stable" in text.splitlines()[-1]


@pytest.mark.parametrize(("word", "ends"), [("csv", {"csv"}), ("table", {"txt"}),
                                            ("both", {"csv", "txt"})])  # fmt: skip
def test_format_chooses_the_files(word, ends, batch):
    """'csv', 'table' and 'both' write these files and no others."""
    assert batch.case(COMPLETE.replace("'csv'", f"'{word}'")).status == 0
    assert contents(batch.cwd / "results").keys() == {f"case.{end}" for end in ends}


def test_a_thousand_impacts(batch, command):
    """The largest number of impacts, N = 1000, runs, and the result is a valid input."""
    done = batch.case(chain(1000))
    assert done.status == 0
    (motion,) = motions(batch.cwd / "results/case.csv")
    assert motion["impact"] == [str(i + 1) for i in range(1000)]
    assert floats(motion, "phase") == [math.pi * (i + 0.001 * (i % 7)) for i in range(1000)]
    assert command("results/case.csv", "-o", "again") == done
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")


def test_no_mass_no_force(batch):
    """With mu = 0 impacts do not affect the primary mass: its velocity does not jump."""
    batch.case(PAIR.replace("mu = 0.042", "mu = 0"))
    (motion,) = motions(batch.cwd / "results/case.csv")
    assert floats(motion, "x_dot_before") == pytest.approx(floats(motion, "x_dot_after"), rel=1e-12)
    assert floats(motion, "attenuation")[0] == pytest.approx(1, rel=1e-9)
