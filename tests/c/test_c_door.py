"""The library for C: the digits of the program, the laws of its tables, threads, and misuse."""

import csv
import json
import re
import subprocess

import pytest
import vibroimpact as vi
from installed_library import ROOT, call
from vibroimpact.commands import STUDIES
from vibroimpact.commands.init import template

SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
FREE = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
TABLE1 = "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
CASES = {
    "motion": TABLE1 + "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n",
    "several": TABLE1 + "&motion kind = 'exact', sides = 'RL', clearance = 37,\n"
    "  phases_over_pi = 0, 1.37 /\n",
    "simulate": SYSTEM + "&simulate clearance = 25, z_dot = 8, cycles = 8, discard = 20 /\n",
    "response": FREE + "&response r_min = 1, r_max = 1.04, r_points = 3, clearance = 25,\n"
    "  states = 4 /\n",
    "find": TABLE1 + "&find clearance = 37, max_impacts = 2, max_cycles = 1 /\n",
    "zone": FREE + "&zone sides = 'RL', symmetric = 'yes', r_min = 0.8, r_max = 1.2,\n"
    "  clearance_min = 2, clearance_max = 200 /\n",
    "lyapunov": SYSTEM + "&lyapunov parameter = 'clearance', low = 5, high = 75, values = 5,\n"
    "  cycles = 200, x_dot = 6, z_dot = 9 /\n",
    "basins": TABLE1 + "&basins clearance = 37, axes = 'x', 'x_dot', low = -30, -30,\n"
    "  high = 30, 30, values = 5, 5 /\n",
    "branch": TABLE1 + "&motion kind = 'equispaced', clearance = 37 /\n"
    "&branch parameter = 'r', low = 0.93, high = 0.95 /\n",
    "bifurcation": SYSTEM + "&bifurcation parameter = 'clearance', low = 60, high = 70,\n"
    "  values = 3, points = 5 /\n",
}
CASES["structure"] = (
    "&structure mass = 1, 0.3, stiffness = 1.5, -.5, -.5, 0.5 /\n"
    "&gap direction = -1, 1, opening = .4, law = 'table', law_speeds = 0, 1, 3, law_values = .9, .8, .5 /\n"
    "&gap direction = 1, -1, opening = .4, restitution = .9, law = 'power', law_speed = .5, law_exponent = .25 /\n"
    "&load frequency = 0.8, cosine = 1, 0, 0, 0.2 /\n&simulate cycles = 5, q_dot = 0, -1 /\n"
)
CASES["record"] = CASES["structure"].partition("&load")[0] + (
    "&load record = 1, -1, .5, 2, -2, 1, step = 2, base = 'acceleration' /\n&simulate duration = 40 /\n"
)
# for other studies of the core, except two slow ones, the case that `vibroimpact init` writes
CASES |= {
    name: template(name, "case.nml") for name in STUDIES
    if name not in (*CASES, "chart", "atlas", "design", "identify")
}  # fmt: skip
#: A case without a solution.
NOWHERE = FREE + (
    "&zone sides = 'RL', symmetric = 'yes', r_min = 3, r_max = 3.1,\n"
    "  clearance_min = 5000, clearance_max = 6000 /\n"
)
WRONG = {
    "key": TABLE1 + "&motion\n  sids = 'RL' /\n",
    "value": TABLE1.replace("0.75", "7") + "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n",
    "two_cases": CASES["motion"] + "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n",
    "group": TABLE1 + "\n\n&animal legs = 4 /\n",
    "system": "&motion sides = 'RL' /\n",
    "none": "! nothing\n",
    "open": TABLE1 + "&motion sides = 'RL\n",
}


class Door:
    """The C program, and vibroimpact-batch, in a separate folder."""

    def __init__(self, program, installed, folder):
        self.program, self.installed, self.folder = program, installed, folder

    def __call__(self, thing, text, status=0):
        (self.folder / "case.nml").write_bytes(text.encode())
        done = subprocess.run(
            [self.program, thing, "case.nml"], cwd=self.folder, capture_output=True, text=True,
            timeout=600,
        )  # fmt: skip
        assert done.returncode == status, f"{done.returncode}: {done.stderr[:1000]}"
        return done.stdout

    def batch(self, text):
        """Files and messages of the program for the same text."""
        (self.folder / "case.nml").write_text(text, encoding="utf-8")
        return subprocess.run(
            [self.installed.program, "case.nml", "-o", "results"], cwd=self.folder,
            capture_output=True, text=True, timeout=600,
        )  # fmt: skip


@pytest.fixture
def run(door, installed, tmp_path):
    return Door(door, installed, tmp_path)


@pytest.mark.parametrize("name", CASES)
def test_digits_of_the_program(run, name):
    """A result as CSV has the bytes of the file that the program writes, and its status."""
    output = run.batch(CASES[name])
    assert output.returncode == 0, output.stderr
    wanted = (run.folder / "results/case.csv").read_text(encoding="utf-8")
    assert run("show", CASES[name]) == wanted


def test_digits_of_python(run):
    """A simulation of a structure by C has the digits of the call from Python."""
    rows = [line for line in run("show", CASES["structure"]).splitlines() if line[0] != "#"]
    table = list(csv.DictReader(rows))
    gaps = [
        vi.Gap([-1, 1], 0.4, vi.TabulatedRestitution([0, 1, 3], [0.9, 0.8, 0.5])),
        vi.Gap([1, -1], 0.4, vi.PowerLaw(0.9, speed=0.5, exponent=0.25)),
    ]
    pair = vi.Structure([1, 0.3], [0, 0], [[1.5, -0.5], [-0.5, 0.5]], gaps)
    load = vi.Load(0.8, cosine=[[1, 0], [0, 0.2]])
    events = vi.simulate(pair, load, cycles=5, state=([0, 0], [0, -1])).events
    assert len(events) > 5
    for name in ("time", "speed", "impulse"):
        assert [float(row[name]) for row in table] == events[name].tolist()
    assert [int(row["gap"]) for row in table] == events["gap"].tolist()


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_ends_of_lines(run, end):
    """A text may come from a file of another system, with a byte order mark."""
    text = "\ufeff" + CASES["response"].replace("\n", end)
    assert run("show", text) == run("show", CASES["response"])


@pytest.mark.parametrize("name", CASES)
def test_laws_of_tables(run, name):
    """The C program checks the laws; the sums that it prints are those of the values in the JSON."""
    report = run("walk", CASES[name]).splitlines()
    tables = {line.split()[1]: int(line.split()[2]) for line in report if line[:5] == "table"}
    assert tables
    assert any(line.startswith("column") for line in report)


@pytest.mark.parametrize("name", ["response", "zone", "several", "basins", "branch", "structure"])
def test_filled_from_outside(run, name):
    """A result that is filled with the values of another gives the same CSV."""
    assert run("refill", CASES[name]) == run("show", CASES[name])


@pytest.mark.parametrize("name", WRONG)
def test_wrong_text(run, name):
    """Status 2 and the words of the program, with the line of the text."""
    report = run("refuse", WRONG[name])
    status, line, message = report.split(" ", 2)
    assert status == "2"
    if name == "two_cases":  # which the program accepts
        assert message == "the text contains 2 cases; must contain one"
        return
    output = run.batch(WRONG[name])
    assert output.returncode == 2
    place = "case.nml" + ("" if line == "0" else f":{line}")
    assert output.stderr == f"{place}: {message}\n"


def test_nothing_found(run):
    """A case without a solution has status 1 and the program's message, and no table."""
    output = run.batch(NOWHERE)
    assert output.returncode == 1
    (run.folder / "case.nml").write_text(NOWHERE)
    done = subprocess.run(
        [run.program, "show", "case.nml"], cwd=run.folder, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert output.stderr == f"case: {done.stderr}"


def test_each_case_of_a_text(run):
    """The cases are listed with names and studies, and each is run by its own text."""
    names = ("motion", "zone", "response", "branch")
    text = "".join(CASES[name] + f"&output name = 'the_{name}' /\n" for name in names)
    run.batch(text)
    listed = [line.split() for line in run("write", text).splitlines()]
    assert [item[:2] for item in listed] == [[f"the_{name}", name] for name in names]
    places = [number for number, line in enumerate(text.splitlines(), 1) if "&output" in line]
    assert [int(item[2]) for item in listed] == places
    for name in names:
        wanted = (run.folder / f"results/the_{name}.csv").read_bytes()
        assert (run.folder / f"the_{name}.csv").read_bytes() == wanted


@pytest.mark.parametrize("name", ["response", "lyapunov", "basins"])
def test_stop_from_another_thread(run, name):
    """Another thread ends a case before its work is done, by writing to its counters."""
    longer = {
        "response": ("r_points = 3", "r_points = 400"),
        "lyapunov": ("values = 5", "values = 500"),
        "basins": ("values = 5, 5", "values = 300, 300"),
    }
    cut = run("stop", CASES[name].replace(*longer[name]))
    if name == "basins":
        return
    reached, total = re.fullmatch(r"(\d+) of (\d+) points were reached", cut).groups()
    assert int(reached) < int(total) == {"response": 400, "lyapunov": 500}[name]


def test_eight_threads(run):
    """Eight threads with the least stack that the header asks for get the digits of one."""
    assert run("at-once", CASES["response"]) == run("show", CASES["response"])
    assert run("at-once", CASES["motion"]) == run("show", CASES["motion"])


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["zone", "lyapunov", "simulate", "basins", "branch", "bifurcation"]
)
def test_eight_threads_of_each_study(run, name):
    assert run("at-once", CASES[name]) == run("show", CASES[name])


@pytest.mark.parametrize("name", ["motion", "zone", "basins"])
def test_small_stacks(run, name):
    """With less stack a thread computes the same, or says that its stack is too small; it does not crash."""
    wanted = run("show", CASES[name])
    answers = re.split(r"^(\d+)\n", run("small", CASES[name]), flags=re.MULTILINE)[1:]
    sizes, answers = [int(size) for size in answers[::2]], answers[1::2]
    assert sizes == [64, 128, 256, 512, 1024]
    assert answers[-1] == wanted
    for answer in answers:
        assert answer == wanted or "the stack of this thread is too small" in answer


def test_misuse(run):
    """Null pointers, invalid handles and wrong values give a status, and no crash."""
    run("misuse", CASES["zone"])


@pytest.mark.parametrize("name", ["motion", "response"])
def test_memory_is_given_back(run, name):
    """300 results, lists of cases and refusals leave less behind than one page each."""
    assert int(run("keep", CASES[name])) < 300 * 4096


def test_descriptions_are_json(run):
    """Descriptions are valid JSON, also with line feeds in a text, and those of `vibroimpact-batch --describe`."""
    report = json.loads(run("describe", CASES["zone"]))
    (text,) = next(item["words"] for item in report["columns"] if item["name"] == "text")
    assert text.startswith("&system\n")
    language = json.loads(run("describe", ""))
    assert set(language["results"]) <= set(language["groups"])
    for study in ("zone", "response", "motion"):
        assert language["results"][study]["columns"]


def test_symbols_are_its_own(installed):
    """The library exports the symbols of the header, and no others, such as those of LAPACK."""
    shared = installed.libdir / "libvibroimpact.so"
    shown = {line.split()[-1] for line in call("nm", "-D", "--defined-only", shared).splitlines()}
    header = (ROOT / "src/c/vibroimpact.h").read_text()
    declared = {name for name in shown if f" {name}(" in header}
    assert shown == declared
    assert shown == {
        line.strip().rstrip(";")
        for line in (ROOT / "src/c/vibroimpact.map").read_text().splitlines()
        if line.strip().startswith("vibroimpact_")
    }
