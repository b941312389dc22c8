"""Branches, zones and atlases in namelists: the real program against the API, and against closed forms."""

import contextlib
import importlib
import inspect
import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from programs import PAIR, ROOT, SYSTEM, Runner, contents, find_command, rows, write
from vibroimpact.run import read_namelist

WALLS = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
EXACT = "&motion kind = 'exact', sides = 'RL', clearance = 37, phases_over_pi = 0, 1.37 /\n"
ALONG = "&branch parameter = 'clearance', low = 10, high = 60 /\n"
BRANCH = SYSTEM + EXACT + ALONG
ZONE = f"""{WALLS}&zone sides = 'RL', symmetric = 'no'
  r_min = 0.8, r_max = 1.2
  clearance_min = 2, clearance_max = 200
/
"""
ATLAS = f"""{WALLS}&atlas max_impacts = 2, survey = 12
  r_min = 1.0, r_max = 1.1
  clearance_min = 20, clearance_max = 60
/
"""
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")
STUDIES = sorted(
    path for path in (ROOT / "inputs").glob("*.nml")
    if any(group in path.read_text() for group in ("&branch", "&zone", "&atlas"))
)  # fmt: skip


@pytest.fixture
def tool(tmp_path):
    """Runner of `vibroimpact` in a folder of its own."""
    return Runner([find_command()], tmp_path)


def column(table, name):
    """A column of rows as numbers."""
    return np.array([float(row[name]) for row in table])


def compare_branch(table, branch):
    """The rows of a branch have the digits of the API's."""
    assert [int(row["point"]) for row in table] == list(range(1, len(branch) + 1))
    for name in (*PARAMETERS, "A", "tau", "residual", "x_min", "x_max", "attenuation"):
        assert column(table, name).tolist() == getattr(branch, name).tolist(), name
    for i in range(len(branch.pattern)):
        assert column(table, f"phase_{i + 1}").tolist() == branch.phases[i].tolist()
        assert column(table, f"X_{i + 1}").tolist() == branch.X[i].tolist()
    for i in range(4):
        moduli = column(table, f"multiplier_{i + 1}_modulus")
        assert moduli == pytest.approx(abs(branch.multipliers[i]), rel=1e-15)
    for name in ("admissible", "stable"):
        words = [{1: "true", 0: "false", -1: "unknown"}[int(x)] for x in getattr(branch, name)]
        assert [row[name] for row in table] == words
    special = {point.index: point.type for point in branch.special_points}
    assert [row["special"] for row in table] == [special.get(i, "") for i in range(len(table))]
    for point in branch.special_points:
        if point.type == "grazing":
            wanted = f"flight {point.impact + 1} touches {point.side}"
            assert table[point.index]["detail"] == wanted


def compare_zone(table, zone):
    """The rows of a zone have the digits of the API's, piece by piece."""
    assert {row["piece"] for row in table} == {str(i + 1) for i in range(len(zone.boundary))}
    for i, piece in enumerate(zone.boundary, start=1):
        part = [row for row in table if row["piece"] == str(i)]
        assert {(row["type"], row["detail"], row["loop"]) for row in part} == {
            (piece.type, piece.detail, str(piece.loop + 1))
        }
        assert column(part, "r").tolist() == piece.r.tolist()
        assert column(part, "clearance").tolist() == piece.clearance.tolist()


def compare_atlas(path, atlas):
    """The zones of the table are those of the API's, in this order; lost attractors are in its header."""
    table = rows(path)
    words = {True: "true", False: "false"}
    wanted = {
        (zone.pattern.sides, str(zone.pattern.cycles), words[zone.symmetric]): zone
        for zone in atlas.zones if zone.boundary
    }  # fmt: skip
    assert list(
        dict.fromkeys((row["sides"], row["cycles"], row["symmetric"]) for row in table)
    ) == [*wanted]
    for name, zone in wanted.items():
        compare_zone(
            [row for row in table if (row["sides"], row["cycles"], row["symmetric"]) == name], zone
        )
    lost = [line for line in path.read_text().split("\n") if "in no zone" in line]
    assert len(lost) == len(atlas.unexplained)
    for line, item in zip(lost, atlas.unexplained, strict=True):
        place = re.search(r": (\S+)/(\d+) at r = (\S+), clearance = (\S+)$", line).groups()
        assert (place[0], int(place[1])) == (item.pattern.sides, item.pattern.cycles)
        assert (float(place[2]), float(place[3])) == (item.r, item.clearance)


def compare(path, case):
    """The result of a case has the digits of the API."""
    if case.kind == "atlas":
        compare_atlas(path, case.atlas())
        return
    table = rows(path)
    if case.kind == "zone":
        compare_zone(table, case.zone())
        return
    branches = case.branches()
    assert {row["branch"] for row in table} == {str(i + 1) for i in range(len(branches))}
    for i, branch in enumerate(branches, start=1):
        compare_branch([row for row in table if row["branch"] == str(i)], branch)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_results_are_those_of_the_api(path, batch, command, same_build):
    """The digits of the API, from the program and from the command, and again from the results."""
    done = batch(str(path), "-o", "out")
    assert (done.status, done.err) == (0, b"")
    assert command(str(path), "-o", "command") == done
    found = contents(batch.cwd / "out")
    assert contents(batch.cwd / "command") == found
    assert batch(*[f"out/{name}" for name in found], "-o", "again").status == 0
    assert contents(batch.cwd / "again") == found
    for case in read_namelist(path):
        result = batch.cwd / "out" / f"{case.name}.csv"
        assert read_namelist(result) == [case]
        compare(result, case)


@pytest.mark.parametrize("text", [
    *[SYSTEM + EXACT + f"&branch parameter = '{name}', low = {low}, high = {high} /\n"
      for name, low, high in (("r", 0.9, 1.0), ("xi", 0.001, 0.02), ("mu", 0.01, 0.1), ("R1", 0.5, 0.9),
                              ("r2", 0.5, 0.9), ("Restitution", 0.5, 0.9))],
    BRANCH.replace("kind = 'exact'", "kind = 'periodic'").replace("clearance = 37,", ""),
    BRANCH.replace("low = 10, high = 60", "low = 37, high = 60, longest_step = 0.01"),
    BRANCH.replace("high = 60", "high = 37"),
    ZONE.replace("'no'", "'both', lines = 9, guesses = 40"),
    WALLS.replace("0.75", "0.75, 0.61") + "&zone sides = 'RL*', lines = 5, r_min = 0.8, r_max = 1.1, "
    "clearance_min = 2, clearance_max = 50 /\n",
    WALLS.replace("0.75", "0.75, 0.61") + "&zone sides = 'RRL', r_min = 0.8, r_max = 1.1, "
    "clearance_min = 2, clearance_max = 50 /\n",
    ATLAS.replace("max_impacts = 2", "max_impacts = 4, max_cycles = 2, settling = 200, lines = 9, guesses = 6"),
    ATLAS.replace("0.75", "0.75, 0.61").replace("1.0,", "0.84,").replace("1.1", "0.94").replace("60", "8")
    .replace("20", "4")])  # fmt: skip
def test_other_cases_are_those_of_the_api(text, batch, same_build):
    """Every parameter; a motion whose clearance follows from its phases; both families; unequal walls."""
    done = batch.case(text)
    assert (done.status, done.err) == (0, b"")
    (case,) = read_namelist(batch.cwd / "case.nml")
    compare(batch.cwd / "results/case.csv", case)


def test_defaults_are_those_of_the_api(tmp_path):
    """What a namelist leaves out is what a call leaves out."""
    (branch,) = read_namelist(write(tmp_path / "branch.nml", BRANCH))
    (zone,) = read_namelist(write(tmp_path / "zone.nml", ZONE.replace("symmetric = 'no'", "")))
    given = {name: item.default for name, item in inspect.signature(vi.branch).parameters.items()}
    assert {
        name: branch.keys[name] for name in ("longest_step", "max_points")
    }.items() <= given.items()
    given = {name: item.default for name, item in inspect.signature(vi.zone).parameters.items()}
    names = ("lines", "guesses", "max_points")
    assert {name: zone.keys[name] for name in names}.items() <= given.items()
    assert (zone.keys["symmetric"], given["symmetric"]) == ("both", None)
    assert zone.keys["cycles"] == vi.Pattern("RL").cycles


def test_exact_motion(batch, same_build):
    """kind = 'exact' gives the motion of `vi.exact`, at the clearance that was asked for."""
    assert batch.case(SYSTEM + EXACT).status == 0
    table = rows(batch.cwd / "results/case.csv")
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    guess = ([0, 1.37 * np.pi], vi.Pattern("RL"))
    motion = vi.exact(osc, 0.94, 37.0, guess)
    assert column(table, "phase").tolist() == motion.phases.tolist()
    assert column(table, "X").tolist() == motion.X.tolist()
    assert column(table, "clearance").tolist() == [37.0, 37.0]
    assert column(table, "residual").max() < 1e-13
    again = batch("results/case.csv", "-o", "again")
    assert again.status == 0
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")


def test_equispaced_boundary_by_the_closed_form(batch):
    """On pieces of the equispaced zone the closed form has a multiplier of the type's own kind."""
    text = ZONE.replace("'no'", "'yes'")
    assert batch.case(text).status == 0
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    seen = set()
    for row in rows(batch.cwd / "results/case.csv")[::3]:
        kind = row["type"]
        if kind not in ("pitchfork", "neimark_sacker") or row["corner"] == "true":
            continue
        pair = vi.equispaced(osc, float(row["r"]), float(row["clearance"]))
        wanted = 1 if kind == "pitchfork" else 0
        distance = min(
            abs(item - 1) if wanted else abs(abs(item) - 1) + (abs(item.imag) < 1e-9)
            for motion in pair for item in motion.multipliers
        )  # fmt: skip
        assert distance < 1e-6, row
        seen.add(kind)
    assert seen == {"pitchfork", "neimark_sacker"}


def test_start_of_a_branch_is_no_case(batch):
    """A &motion right before &branch writes nothing itself; with &output between, it does."""
    assert batch.case(BRANCH).status == 0
    assert list(contents(batch.cwd / "results")) == ["case.csv"]
    between = "&output name = 'motion' /\n"
    text = SYSTEM + EXACT + between + ALONG + ALONG.replace("60", "50") + "&output name = 'b' /\n"
    assert batch.case(text, "-o", "three").status == 0
    found = contents(batch.cwd / "three")
    assert sorted(found) == ["b.csv", "case_2.csv", "motion.csv"]
    ends = rows(batch.cwd / "three/b.csv")
    assert sorted([float(ends[0]["clearance"]), float(ends[-1]["clearance"])]) == pytest.approx(
        [10, 50]
    )


def test_budget_of_a_branch(batch):
    """Too few points: what there is is kept and marked, status 1."""
    done = batch.case(BRANCH.replace("high = 60", "high = 60, max_points = 15"))
    assert done.status == 1
    assert done.faults == ["case: cut short, max_points was reached"]
    text = (batch.cwd / "results/case.csv").read_text()
    assert "# ! branch 1: first end: full; last end: full\n" in text
    assert 3 < len(rows(batch.cwd / "results/case.csv")) < 30


def test_budget_of_a_zone(batch):
    """Too few vertices: the open boundary is kept with loop 0 and marked, status 1."""
    done = batch.case(ZONE.replace("'no'", "'no', max_points = 100"))
    assert done.status == 1
    assert done.faults == ["case: not closed: a boundary could not be followed until it closes"]
    assert "# ! not closed" in (batch.cwd / "results/case.csv").read_text()
    assert "0" in {row["loop"] for row in rows(batch.cwd / "results/case.csv")}


def test_lost_attractor(batch, tool, same_build):
    """Too few vertices for a zone: the attractors in it are named, status 1, by every program alike."""
    done = batch.case(ATLAS.replace("survey = 12", "survey = 12, max_points = 100"))
    assert done.status == 1
    assert b"attractors surveyed" in done.out
    assert done.faults[-1].startswith("case: ")
    assert "in no zone of the pattern: RL/1" in done.faults[-1]
    (case,) = read_namelist(batch.cwd / "case.nml")
    atlas = case.atlas()
    assert atlas.unexplained
    assert tool("atlas", "case.nml", "--format", "json", "-o", "json") == done
    compare_atlas(batch.cwd / "results/case.csv", atlas)
    assert batch("results/case.csv", "-o", "again").status == 1
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")


@pytest.mark.parametrize(("text", "said"), [
    (ATLAS.replace("min = 20", "min = 1e6").replace("max = 60", "max = 2e6"),
     "case: no zone: neither search nor survey found a stable, admissible motion within the limits"),
    (ZONE.replace("clearance_min = 2, clearance_max = 200", "clearance_min = 1e6, clearance_max = 2e6"),
     "case: no motion RL/1 was found anywhere in the window"),
    (ZONE.replace("'no'", "'yes'").replace("0.8", "0.79").replace("1.2", "0.8")
     .replace("clearance_min = 2, clearance_max = 200", "clearance_min = 1e-3, clearance_max = 2e-3"),
     "case: no zone: motions RL/1 were found in the window, but none that is both stable and admissible"),
    (SYSTEM + "&motion kind = 'equispaced', clearance = 2000 /\n&branch parameter = 'r', low = 0.9, high = 1 /\n",
     "case: there is no such motion for these parameters"),
    (BRANCH.replace("1.37", "1"),
     "case: two equally spaced impacts with equal restitution leave the load amplitude free"),
])  # fmt: skip
def test_nothing_there(text, said, batch):
    """No motion, no zone: one clear statement, status 1, no result."""
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (1, b"", 1)
    assert done.faults[0].startswith(said)
    assert list(contents(batch.cwd)) == ["case.nml"]


BAD_BRANCH = [
    *[("parameter = 'clearance'", f"parameter = {v}", "'r', 'clearance', 'xi'")
      for v in ("'q'", "''", "r", "'restitutio'", "'clearance x'")],
    ("parameter = 'clearance', ", "", "&branch parameter: is missing"),
    *[("low = 10", f"low = {v}", "1e-12 <= clearance <= 1e12, and the motion has clearance = 37.0")
      for v in ("nan", "0", "-1", "1e-13", "38", "inf")],
    ("low = 10", "low = 1, 2", "a number, at most"),
    ("low = 10, ", "", "&branch low: is missing"),
    *[("high = 60", f"high = {v}", "above low") for v in ("nan", "36.9", "5", "inf", "1e13", "x")],
    (", high = 60", "", "&branch high: is missing"),
    ("low = 10, high = 60", "low = 37, high = 37", "above low"),
    *[("high = 60", f"high = 60, longest_step = {v}", "longest_step <= 1")
      for v in ("0", "-1", "nan", "2", "1e-7")],
    *[("high = 60", f"high = 60, max_points = {v}", "max_points <= 100000")
      for v in ("9", "100001", "1.5", "nan")],
    ("high = 60", "high = 60, steps = 3", "is not a key of &branch; must be one of parameter, low"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted"), BAD_BRANCH)
def test_bad_branch(old, new, wanted, batch):
    """One line with file, line, group, key, value and what is allowed; status 2; no result."""
    text = BRANCH.replace(old, new)
    assert text != BRANCH
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith("case.nml:3: &branch ")
    assert wanted in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


BAD_ZONE = [
    *[("sides = 'RL'", f"sides = {v}", "2 to 24", 2)
      for v in ("'R'", "'RR'", "''", "'RXL'", "'*RL'", "'RL**'", "'R*'", f"'{'RL' * 13}'", "RL")],
    *[("'no'", v, "'yes'", 2) for v in ("'maybe'", "''", ".true.", "1")],
    *[("symmetric = 'no'", f"cycles = {v}", "cycles <= 10000", 2) for v in ("0", "10001", "1.5")],
    ("sides = 'RL', symmetric = 'no'", "sides = 'RRL', symmetric = 'yes'", "mirrors the first", 2),
    *[("r_min = 0.8", f"r_min = {v}", "r_min <= 1e6", 3) for v in ("nan", "0", "-1", "inf", "1e7")],
    *[("r_max = 1.2", f"r_max = {v}", "r_min below r_max", 3) for v in ("0.8", "0.5", "nan", "inf")],
    *[("clearance_min = 2", f"clearance_min = {v}", "clearance_min <= 1e12", 4)
      for v in ("nan", "0", "-1", "1e13")],
    *[("clearance_max = 200", f"clearance_max = {v}", "clearance_min below clearance_max", 4)
      for v in ("2", "1", "nan", "inf")],
    *[("symmetric = 'no'", f"lines = {v}", "5 <= lines <= 129", 2) for v in ("4", "130", "nan")],
    *[("symmetric = 'no'", f"guesses = {v}", "guesses <= 100000", 2) for v in ("-1", "100001")],
    *[("symmetric = 'no'", f"max_points = {v}", "max_points <= 200000", 2) for v in ("99", "200001")],
    ("symmetric = 'no'", "parameter = 'r'", "is not a key of &zone; must be one of sides", 2),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_ZONE)
def test_bad_zone(old, new, wanted, line, batch):
    """As for &branch."""
    text = ZONE.replace(old, new)
    assert text != ZONE
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(f"case.nml:{line}: &zone ")
    assert wanted in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


BAD_ATLAS = [
    *[("max_impacts = 2", f"max_impacts = {v}", "2 <= max_impacts <= 8", 2)
      for v in ("1", "9", "2.5", "x")],
    *[("max_impacts = 2", f"max_cycles = {v}", "1 <= max_cycles <= 4", 2) for v in ("0", "5", "nan")],
    *[("survey = 12", f"survey = {v}", "0 <= survey <= 1000000", 2) for v in ("-1", "1000001", "1e3")],
    *[("survey = 12", f"settling = {v}", "1 <= settling <= 1000000", 2) for v in ("0", "1000001")],
    *[("r_min = 1.0", f"r_min = {v}", "r_min <= 1e6", 3) for v in ("nan", "0", "inf")],
    *[("r_max = 1.1", f"r_max = {v}", "r_min below r_max", 3) for v in ("1", "0.5", "nan")],
    *[("clearance_min = 20", f"clearance_min = {v}", "clearance_min <= 1e12", 4) for v in ("nan", "0")],
    *[("clearance_max = 60", f"clearance_max = {v}", "clearance_min below clearance_max", 4)
      for v in ("20", "inf")],
    *[("survey = 12", f"lines = {v}", "5 <= lines <= 129", 2) for v in ("4", "130")],
    *[("survey = 12", f"guesses = {v}", "guesses <= 100000", 2) for v in ("-1", "100001")],
    *[("survey = 12", f"max_points = {v}", "max_points <= 200000", 2) for v in ("99", "200001")],
    ("survey = 12", "survey = 12, survey = 3", "was given before", 2),
    ("survey = 12", "sides = 'RL'", "is not a key of &atlas; must be one of r_min", 2),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_ATLAS)
def test_bad_atlas(old, new, wanted, line, batch):
    """As for &branch."""
    text = ATLAS.replace(old, new)
    assert text != ATLAS
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(f"case.nml:{line}: &atlas ")
    assert wanted in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


@pytest.mark.parametrize(("text", "message"), [
    (WALLS + "&branch parameter = 'r' /\n", "&system r: is missing"),
    (SYSTEM + ALONG, "&branch: no &motion of this &system stands before it"),
    (PAIR + "&output name = 'm' /\n" + SYSTEM + ALONG, "&branch: no &motion of this &system"),
    (ALONG, "&branch: no &system stands before it"),
    (ZONE.replace(WALLS, ""), "&zone: no &system stands before it"),
    (SYSTEM + ZONE.replace(WALLS, ""),
     "&system r = 0.94: must be left out: it is not for a &chart, &zone, &atlas or &response"),
    (ATLAS.replace(WALLS, ""), "&atlas: no &system stands before it"),
    (SYSTEM + ATLAS.replace(WALLS, ""), "&system r = 0.94: must be left out: it is not for a &chart, &zone"),
    (ATLAS.replace("xi = 0.0114", "xi = 0"), "&atlas r_min = 1.0: must be a number with 1e-6"),
    (ZONE.replace("xi = 0.0114", "xi = 0"), "&zone r_min = 0.8: must be a number with 1e-6"),
    (BRANCH.replace("clearance = 37", "clearance = 37, impact_restitution = 2*0.5"),
     "&branch: the &motion before it has impact_restitution; must be without"),
    (BRANCH.replace("kind = 'exact'", "kind = 'periodic'").replace("clearance = 37", "precision = 'single'"),
     "&branch: the &motion before it has precision = 'single'"),
    (BRANCH.replace("clearance = 37", "clearance = 37, acceptance = 0.1"),
     "&motion acceptance = 0.1: must be left"),
    (BRANCH.replace("clearance = 37", "clearance = 37, precision = 'single'"), "&motion precision = 'single'"),
    (BRANCH.replace("clearance = 37,", ""), "&motion clearance: is missing; must be a number"),
    (BRANCH.replace("0.75", "0.75, 0.6").replace("'clearance'", "'restitution'"),
     "&branch parameter = 'restitution': must be 'r'"),
    (BRANCH.replace("xi = 0.005", "xi = 0").replace("'clearance', low = 10, high = 60", "'r', low = .9, high = 2"),
     "&branch low = .9: must be a number"),
])  # fmt: skip
def test_bad_company(text, message, batch):
    """Groups that do not go together."""
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert message in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


def test_bounds_without_the_motion_of_given_phases(batch):
    """The clearance follows from the phases (38.22), and is compared with the bounds before anything runs."""
    text = BRANCH.replace("kind = 'exact'", "kind = 'periodic'").replace("clearance = 37,", "")
    done = batch.case(PAIR + text.replace("low = 10", "low = 39"))
    assert (done.status, done.out) == (2, b"")
    assert "&branch low = 39: must be a number, at most" in done.faults[0]
    assert "the motion has clearance = 38.22" in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


def test_result_that_cannot_be_written(batch):
    """A file where the folder should be: status 2, and the file is as it was."""
    write(batch.cwd / "results", "mine")
    for text in (BRANCH, ZONE, ATLAS):
        done = batch.case(text)
        assert (done.status, len(done.faults)) == (2, 1)
        assert "must be a folder and disk that can be written" in done.faults[0]
        assert sorted(contents(batch.cwd)) == ["case.nml", "results"]
        assert (batch.cwd / "results").read_bytes() == b"mine"


POINT = [
    "--xi",
    "0.005",
    "--mu",
    "0.042",
    "--restitution",
    "0.75",
    "--r",
    "0.94",
    "--clearance",
    "37",
]
ALONG_OPTIONS = [*POINT, "--sides", "RL", "--phases-over-pi", "0", "1.37", "--parameter", "clearance", "--bounds",
                 "10", "60"]  # fmt: skip
WINDOW = ["--xi", ".0114", "--mu", ".028", "--restitution", ".75", "--sides", "RL", "--symmetric", "no",
          "--r", ".8", "1.2", "--clearance", "2", "200"]  # fmt: skip
ATLAS_OPTIONS = ["--xi", ".0114", "--mu", ".028", "--restitution", ".75", "--r", "1", "1.1",
                 "--clearance", "20", "60", "--max-impacts", "2", "--survey", "12"]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "options"), [
    ("branch", BRANCH, ALONG_OPTIONS), ("zone", ZONE, WINDOW), ("atlas", ATLAS, ATLAS_OPTIONS)])  # fmt: skip
def test_options_are_a_namelist(name, text, options, tool):
    """The options give the bytes of the same case in a file; --plot draws it."""
    write(tool.cwd / f"{name}.nml", text)
    assert tool(name, f"{name}.nml", "-o", "file").status == 0
    done = tool(name, *options, "--plot", "svg")
    assert (done.status, done.err) == (0, b"")  # and no bar, where there is no terminal
    found = contents(tool.cwd / "results")
    assert sorted(found) == [f"{name}.csv", f"{name}.svg"]
    assert found[f"{name}.csv"] == contents(tool.cwd / "file")[f"{name}.csv"]
    assert tool("plot", f"{name}.nml", "--format", "svg", "-o", "plot").status == 0
    assert contents(tool.cwd / "plot")[f"{name}.svg"] == found[f"{name}.svg"]


def test_zone_as_json(tool):
    """The JSON is the API's zone."""
    done = tool("zone", *WINDOW, "--format", "json")
    assert (done.status, done.err) == (0, b"")
    assert list(contents(tool.cwd / "results")) == ["zone.json"]
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    zone = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=False)
    data = json.loads((tool.cwd / "results/zone.json").read_text())
    assert data == json.loads(json.dumps(zone.to_dict()))


def test_atlas_as_json(tool):
    """The JSON is what Atlas.save writes, and its zones those of the table."""
    done = tool("atlas", *ATLAS_OPTIONS, "--format", "json")
    assert (done.status, done.err) == (0, b"")
    assert list(contents(tool.cwd / "results")) == ["atlas.json"]
    assert tool("atlas", *ATLAS_OPTIONS) == done
    compare_atlas(tool.cwd / "results/atlas.csv", vi.Atlas.load(tool.cwd / "results/atlas.json"))


def test_atlas_of_nothing_as_json(tool):
    """Said in one line, the same as of a table; status 1, nothing written."""
    nothing = ["atlas", *ATLAS_OPTIONS, "--clearance", "1e6", "2e6"]
    done = tool(*nothing, "--format", "json", "--plot")
    assert tool(*nothing) == done
    assert (done.status, done.out, len(done.faults)) == (1, b"", 1)
    assert done.faults[0].startswith("atlas: no zone: neither search nor survey found")
    assert list(contents(tool.cwd)) == []


CHART = (
    "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n&chart sides = 'RRL',\n"
    " r_min = 0.8, r_max = 1.2, clearance_min = 2, clearance_max = 100,\n"
    " r_points = 40, clearance_points = 40 /\n"
)
SIMULATE = (
    "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
    "&simulate clearance = 10, cycles = 20000, discard = 60000, x_dot = 6, z_dot = 9 /\n"
)


@pytest.mark.parametrize("case", [ATLAS, CHART, SIMULATE], ids=["atlas", "chart", "simulate"])
def test_progress_of_cases(case, tmp_path, monkeypatch):
    """What is told of the work while it runs goes from nothing to all, and changes no result."""
    write(tmp_path / "case.nml", case)
    monkeypatch.setattr(importlib.import_module("vibroimpact.interrupt"), "INTERVAL", 0.001)
    shares = []
    told = vi.run_namelists([tmp_path / "case.nml"], tmp_path / "told", progress=shares.append)
    assert shares
    assert shares == sorted(shares)
    assert 0 <= shares[0] < shares[-1] <= 1
    plain = vi.run_namelists([tmp_path / "case.nml"], tmp_path / "plain")
    assert (told.status, told.lines) == (plain.status, plain.lines)
    assert contents(tmp_path / "told") == contents(tmp_path / "plain")


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize("form", ["csv", "json"])
def test_bar_on_a_terminal(form, tool):
    """There the command shows how far it is and how much time is left, and wipes it off at the end."""
    write(
        tool.cwd / "sitecustomize.py",
        "import vibroimpact.progress as p, vibroimpact.interrupt as r\n"
        "p.PATIENCE = p.INTERVAL = 0.0; r.INTERVAL = 0.001\n",
    )
    ours, theirs = os.openpty()
    words = [find_command(), "atlas", *ATLAS_OPTIONS, "--max-impacts", "3", "--format", form]
    environment = {**os.environ, "PYTHONPATH": str(tool.cwd)}
    with subprocess.Popen(
        words, cwd=tool.cwd, stderr=theirs, stdout=subprocess.PIPE, env=environment
    ) as run:
        os.close(theirs)
        said = b""
        with contextlib.suppress(OSError):  # the end of a terminal
            while part := os.read(ours, 4096):
                said += part
    os.close(ours)
    assert run.returncode == 0
    assert b"\ratlas [" in said
    assert b" s left " in said
    assert b"\n" not in said
    assert said.endswith(b" \r")


def test_equispaced_pair_by_options(tool):
    """Without phases both equispaced motions are followed."""
    options = [*POINT, "--parameter", "r", "--bounds", "0.93", "0.95"]
    assert tool("branch", *options).status == 0
    assert {row["branch"] for row in rows(tool.cwd / "results/branch.csv")} == {"1", "2"}


@pytest.mark.parametrize(("words", "said"), [
    (["zone", *WINDOW[:-2], "200", "2"], "vibroimpact zone: --clearance 200 2: must be LOW HIGH with"),
    (["zone", *WINDOW, "--lines", "4"], "vibroimpact zone: --lines 4: must be a whole number with 5 <= lines"),
    (["zone", *WINDOW[2:]], "vibroimpact zone: --xi: must be given, or a namelist file"),
    (["zone", "case.nml", "--xi", "0.1"], "vibroimpact zone: --xi: must be left out beside a namelist file"),
    (["zone", "case.nml"], "case.nml: must hold a group &zone; there is none"),
    *[(["atlas", *ATLAS_OPTIONS, "--max-impacts", "9", "--format", form], said)
      for form, said in ((form, "vibroimpact atlas: --max-impacts 9: must be a whole number with 2 <=")
                         for form in ("csv", "json"))],
    (["atlas", *ATLAS_OPTIONS[2:]], "vibroimpact atlas: --xi: must be given, or a namelist file"),
    (["atlas", "case.nml"], "case.nml: must hold a group &atlas; there is none"),
    (["atlas", "case.nml", "--format", "json"],
     "vibroimpact atlas: case.nml: must hold a group &atlas; there is none"),
    (["branch", *ALONG_OPTIONS[:-1], "nan"], "vibroimpact branch: --bounds nan: must be a number above low"),
    (["branch", *ALONG_OPTIONS[:-3]], "vibroimpact branch: --bounds: must be given"),
    (["branch", *POINT, "--sides", "R'L", "--phases-over-pi", "0", "1", "--parameter", "r", "--bounds", ".9", "1"],
     "vibroimpact branch: --sides 'R''L': must be letters R and L"),
])  # fmt: skip
def test_bad_options(words, said, tool):
    """One line that says what is wrong, status 2, nothing written."""
    write(tool.cwd / "case.nml", PAIR)
    done = tool(*words)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(said)
    assert list(contents(tool.cwd)) == ["case.nml"]
