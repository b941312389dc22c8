"""The namelists of the project, and branches, zones and atlases: the program against the API and closed forms."""

import inspect

import numpy as np
import pytest
import vibroimpact as vi
from programs import IN_PYTHON, INPUTS, ROOT, SYSTEM, Runner, column, contents, rows, write
from vibroimpact import commands
from vibroimpact.cases.case import read_namelist

from studies import ALONG, ATLAS, BRANCH, EXACT, WALLS, ZONE, assert_atlas, assert_result

STUDIES = sorted(
    path for path in (ROOT / "inputs").glob("*.nml")
    if any(group in path.read_text() for group in ("&branch", "&zone", "&atlas"))
)  # fmt: skip
#: Inputs whose results are cases again; the others take longer or are run by other tests.
AGAIN = [name for name in commands.STUDIES
         if name not in ("simulate", "find", "chart", "zone", "atlas", *IN_PYTHON)]  # fmt: skip
#: Of these other studies, or of other systems, there are shorter inputs.
LONGEST = ("basins", "structure_atlas", "structure_basins", "zone_figures")


@pytest.fixture(scope="module")
def inputs(pytestconfig):
    """The namelists that come with the project; with --once without those that take two thirds of the time."""
    left_out = LONGEST if pytestconfig.getoption("--once") else ()
    return [path for path in INPUTS if path.stem not in left_out]


@pytest.fixture(scope="module")
def results(binary, inputs, tmp_path_factory):
    """A folder with the program's results for these namelists, and its output."""
    folder = tmp_path_factory.mktemp("inputs")
    return folder / "results", Runner([binary], folder)(*map(str, inputs))


def test_inputs_of_the_project_run(inputs, results, command):
    """Every namelist that comes with the project (with --once, the shorter ones) runs, with the same bytes from
    both programs for all cases."""
    folder, done = results
    assert inputs
    assert (done.status, done.err) == (0, b"")
    assert command(*map(str, inputs)) == done
    found = contents(folder)
    assert contents(command.cwd / "results") == found
    names = [case.name for path in inputs for case in read_namelist(path) if not case.in_python]
    assert sorted({name.rpartition(".")[0] for name in found}) == sorted(names)


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_results_are_those_of_the_api(path, results, same_build):
    """The program gives the digits of the API."""
    for case in read_namelist(path):
        result = results[0] / f"{case.name}.csv"
        assert read_namelist(result) == [case]
        assert_result(result, case)


@pytest.mark.parametrize("name", AGAIN)
def test_results_are_cases(name, results, batch):
    """The program writes the same results again when it is run on its results."""
    cases = read_namelist(ROOT / "inputs" / f"{name}.nml")
    files = [results[0] / f"{case.name}.csv" for case in cases]
    assert batch(*map(str, files)).status == 0
    for file in files:
        assert (batch.cwd / "results" / file.name).read_bytes() == file.read_bytes()


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
    """The API's digits also for every parameter, a clearance from phases, both families, and unequal walls."""
    done = batch.case(text)
    assert (done.status, done.err) == (0, b"")
    (case,) = read_namelist(batch.cwd / "case.nml")
    assert_result(batch.cwd / "results/case.csv", case)


def test_defaults_are_those_of_the_api(tmp_path):
    """Keys omitted in a namelist have the defaults of the API."""
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
    """kind = 'exact' gives the motion of `vi.exact` at the given clearance."""
    assert batch.case(SYSTEM + EXACT).status == 0
    table = rows(batch.cwd / "results/case.csv")
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    guess = ([0, 1.37 * np.pi], vi.Pattern("RL"))
    motion = vi.exact(osc, 0.94, 37.0, guess)
    assert column(table, "phase").tolist() == motion.alpha.tolist()
    assert column(table, "x").tolist() == motion.X.tolist()
    assert column(table, "clearance").tolist() == [37.0, 37.0]
    assert column(table, "residual").max() < 1e-13
    again = batch("results/case.csv", "-o", "again")
    assert again.status == 0
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")


def test_equispaced_boundary_by_the_closed_form(batch):
    """On pieces of the equispaced zone the closed form has the multiplier of the piece's type."""
    text = ZONE.replace("'no'", "'yes'")
    done = batch.case(text)
    assert done.status == 0
    table = rows(batch.cwd / "results/case.csv")
    types = ", ".join(dict.fromkeys(row["type"] for row in table))
    assert done.out.decode().split("\n")[0].endswith(f"pieces: {types}")
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    seen = set()
    for row in table[::3]:
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
    """A &motion right before &branch writes no result of its own; with &output between, it does."""
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
    """With too few points the partial branch is kept and marked, with status 1."""
    done = batch.case(BRANCH.replace("high = 60", "high = 60, max_points = 15"))
    assert done.status == 1
    assert done.faults == ["case: cut short, max_points was reached"]
    text = (batch.cwd / "results/case.csv").read_text()
    assert "# ! branch 1: first end: full; last end: full\n" in text
    assert 3 < len(rows(batch.cwd / "results/case.csv")) < 30


def test_budget_of_a_zone(batch):
    """With too few vertices the open boundary is kept with loop 0 and marked, with status 1."""
    done = batch.case(ZONE.replace("'no'", "'no', max_points = 100"))
    assert done.status == 1
    assert done.faults == ["case: not closed: a boundary could not be followed until it closes"]
    assert "# ! not closed" in (batch.cwd / "results/case.csv").read_text()
    assert "0" in {row["loop"] for row in rows(batch.cwd / "results/case.csv")}


@pytest.mark.slow
def test_lost_attractor(batch, tool, same_build):
    """If a zone is missing for want of vertices, every program names its attractors, with status 1."""
    done = batch.case(ATLAS.replace("survey = 12", "survey = 12, max_points = 100"))
    assert done.status == 1
    assert b"attractors surveyed" in done.out
    assert done.faults[-1].startswith("case: ")
    assert "in no zone of the pattern: RL/1" in done.faults[-1]
    (case,) = read_namelist(batch.cwd / "case.nml")
    atlas = case.run()[0]
    assert atlas.unexplained
    assert tool("atlas", "case.nml", "--format", "json", "-o", "json") == done
    assert_atlas(batch.cwd / "results/case.csv", atlas)
    assert batch("results/case.csv", "-o", "again").status == 1
    assert contents(batch.cwd / "again") == contents(batch.cwd / "results")


@pytest.mark.parametrize(("text", "output"), [
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
     "case: two equally spaced impacts with equal restitution do not determine the load amplitude"),
])  # fmt: skip
def test_nothing_there(text, output, batch):
    """If there is no motion or zone there is one message, status 1 and no result."""
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (1, b"", 1)
    assert done.faults[0].startswith(output)
    assert list(contents(batch.cwd)) == ["case.nml"]


def test_result_that_cannot_be_written(batch):
    """A file in place of the result folder gives status 2, and does not change."""
    write(batch.cwd / "results", "mine")
    for text in (BRANCH, ZONE, ATLAS):
        done = batch.case(text)
        output = "results: results is a file; must be a folder"
        assert (done.status, done.faults) == (2, [output])
        assert sorted(contents(batch.cwd)) == ["case.nml", "results"]
        assert (batch.cwd / "results").read_bytes() == b"mine"
