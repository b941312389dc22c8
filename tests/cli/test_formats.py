"""Forms of results of the command: each holds the results of the case, which is computed once."""

import importlib
import json
import math
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from programs import IN_PYTHON, WRITTEN, contents, find_command, kinds, write
from vibroimpact.commands import STUDIES
from vibroimpact.commands.command import main

SUFFIX = {"json": "json", "netcdf": "nc", "matlab": "mat"}
SYSTEM = ["--xi", "0.0114", "--mu", "0.028", "--restitution", "0.75"]


def heard(capture):
    """The output of both streams without the lines about written files, and these files."""
    out, err = capture.readouterr()
    files = sorted(map(os.fsdecode, WRITTEN.findall(out.encode())))
    return (WRITTEN.sub(b"", out.encode()).decode(), err), files


#: What makes a case short whose forms are those of a longer one.
SHORT = {
    "atlas": {"survey = 20": "survey = 9"},
    "design": {
        "samples = 1000 ": "samples = 200, searches = 1, nodes = 3, evaluations = 16 ",
        "quantile = 0.9 ": "quantile = 0.5 ",
    },
}


@pytest.mark.parametrize("kind", kinds())
def test_every_form_of_every_kind(kind, tool, monkeypatch, capfd):
    """Each form has the messages and status of the table alone, and holds the results bit for bit."""
    for library in ("h5netcdf", "scipy"):
        pytest.importorskip(library)
    monkeypatch.chdir(tool.cwd)
    text = kinds()[kind]
    for words, fewer in SHORT.get(kind, {}).items():
        assert words in text
        text = text.replace(words, fewer)
    path = write(tool.cwd / "case.nml", text)
    (case,) = vi.read_namelist(path)
    wanted = case.run()
    assert main(["run", "case.nml", "-o", "csv"]) == 0
    words, files = heard(capfd)
    assert files == ["csv/case.csv"]
    for form, suffix in SUFFIX.items():
        if kind == "atlas" and form != "json":  # its forms are those of its zones
            continue
        assert main(["run", "case.nml", "--format", form, "-o", form]) == 0
        names = ["case"] if len(wanted) == 1 else [f"case_{i + 1}" for i in range(len(wanted))]
        assert heard(capfd) == (words, [f"{form}/{name}.{suffix}" for name in names])
        assert sorted(contents(tool.cwd / form)) == [f"{name}.{suffix}" for name in names]
        for name, result in zip(names, wanted, strict=True):
            file = tool.cwd / form / f"{name}.{suffix}"
            assert vi.load(file).to_json() == result.to_json()
    assert main(["run", "case.nml", "--plot", "svg", "-o", "plot"]) == 0
    found = contents(tool.cwd / "plot")
    assert heard(capfd) == (words, sorted(f"plot/{name}" for name in found))
    assert found.pop("case.csv") == (tool.cwd / "csv/case.csv").read_bytes()
    assert all(picture.startswith(b"<?xml") for picture in found.values())
    assert len(found) == len(wanted)


@pytest.mark.parametrize("words", [["run"], ["chart"], ["chart", "--json"]])
def test_chart_without_xarray(words, tmp_path, monkeypatch, capsys):
    """Without xarray the table and the picture are written; for netCDF a message names xarray."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "case.nml", kinds()["chart"])
    assert main(["chart", "case.nml", "--plot", "svg", "-o", "with"]) == 0
    monkeypatch.setitem(sys.modules, "xarray", None)
    capsys.readouterr()
    assert main([*words, "case.nml", "--plot", "svg", "-o", "without"]) == 0
    assert contents(tmp_path / "without") == contents(tmp_path / "with")
    capsys.readouterr()
    assert main(["plot", "case.nml", "--format", "svg", "-o", "drawn"]) == 0
    assert main(["chart", "case.nml", "--format", "netcdf", "-o", "netcdf"]) == 1
    assert "netCDF files need xarray: pip install 'vibroimpact[data]'" in capsys.readouterr().err
    assert list(contents(tmp_path / "netcdf")) == []


@pytest.mark.parametrize("words", [[], ["--json"]])
def test_named_chart_without_xarray(words, tmp_path, monkeypatch, capsys):
    """A table under a given name and the JSON document do not need xarray."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "case.nml", kinds()["chart"])
    monkeypatch.setitem(sys.modules, "xarray", None)
    assert main(["chart", "case.nml", "-o", "out/mine.csv", *words]) == 0
    output = capsys.readouterr()
    assert output.err == ""
    assert list(contents(tmp_path / "out")) == ["mine.csv"]
    assert not words or list(json.loads(output.out)["results"]) == ["mine"]


def test_a_chart_as_netcdf(tool):
    """The dataset of `chart` with its case."""
    xarray = pytest.importorskip("xarray")
    write(tool.cwd / "case.nml", kinds()["chart"])
    assert tool("chart", "case.nml", "--format", "netcdf").status == 0
    (case,) = vi.read_namelist(tool.cwd / "case.nml")
    with xarray.open_dataset(tool.cwd / "results/case.nc", engine="h5netcdf") as data:
        wanted = case.run()[0].to_xarray()
        for name in wanted.variables:
            np.testing.assert_array_equal(data[name], wanted[name])
        assert data.attrs["case"] == case.text.split("&output")[0]
        assert data.attrs["source"] == f"vibroimpact {vi.__version__}"


def test_options_of_a_chart_are_a_namelist(tool):
    """Options give the bytes of the same case in a file."""
    options = ["--sides", "RL", "--r", "0.9", "1.1", "21", "--clearance", "5", "100", "16", "--spacing",
               "geometric", "--symmetric", "yes"]  # fmt: skip
    assert tool("chart", *SYSTEM, *options).status == 0
    write(tool.cwd / "chart.nml", kinds()["chart"])
    assert tool("run", "chart.nml", "-o", "run").status == 0
    assert contents(tool.cwd / "results") == contents(tool.cwd / "run")


#: The requirement on the number of frequency ratios.
MANY = "must be a whole number of at least 2, with N x N of --clearance <= 1000000"


@pytest.mark.parametrize(("words", "output"), [
    (["--r", "1.1", "0.9", "5"],
     "--r 1.1 0.9 5: must have 1e-6 <= HIGH <= 1e6, and LOW below HIGH"),
    (["--r", "0.9", "1.1", "1"], "--r 0.9 1.1 1: " + MANY),
    (["--r", "0.9", "1.1", "2.5"], "--r 0.9 1.1 2.5: " + MANY),
    (["--r", "0.9", "1.1", "5", "--slots", "99"], "--slots 99: must be a whole number with 1 <= slots <= 32"),
    (["--r", "0.9", "1.1", "2000000"], "--r 0.9 1.1 2000000: " + MANY),
    (["--r", "1e-9", "1.1", "5"], "--r 1e-9 1.1 5: must have 1e-6 <= LOW"),
])  # fmt: skip
def test_bad_grids(words, output, tool):
    """Invalid grids are refused in the words typed."""
    done = tool("chart", *SYSTEM, "--sides", "RL", "--clearance", "5", "9", "3", *words)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(f"vibroimpact chart: {output}")


@pytest.mark.parametrize("kind", [kind for kind in STUDIES if kind not in IN_PYTHON])
def test_computed_once(kind, tmp_path, monkeypatch):
    """Table, picture and document come from one computation; the table equals that of the compiled program."""
    path = write(tmp_path / "case.nml", kinds()[kind])
    assert vi.run_namelists([path], tmp_path / "core").status == 0
    module = importlib.import_module("vibroimpact.results.door")
    calls, ours = [], module.run_text
    monkeypatch.setattr(module, "run_text", lambda *a, **k: calls.append("python") or ours(*a, **k))
    monkeypatch.setattr(
        "vibroimpact.commands.cases.run_namelists", lambda *a, **k: calls.append("core")
    )
    assert main([kind, str(path), "--plot", "svg", "--json", "-o", str(tmp_path / "out")]) == 0
    assert calls == ["python"]
    found = contents(tmp_path / "out")
    assert sorted(found) == ["case.csv", "case.svg"]
    assert found["case.csv"] == (tmp_path / "core/case.csv").read_bytes()


PAIR_ALONG = (
    "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = {} /\n"
    "&motion kind = 'equispaced', clearance = {} /\n"
    "&branch parameter = 'clearance', low = 5, high = 400, max_points = {} /\n"
)
BRANCHES = {
    "none": PAIR_ALONG.format(0.9, 300, 4000), "full": PAIR_ALONG.format(0.9, 20, 20),
    "lost": PAIR_ALONG.format(0.9, 300, 4000)
    .replace("'equispaced'", "'exact', sides = 'RL', phases_over_pi = 0, 1.1"),
}  # fmt: skip


@pytest.mark.parametrize("name", ["short", "nothing", "missing", *BRANCHES])
def test_faults_are_the_same_in_every_form(name, tmp_path, monkeypatch, capfd):
    """Partial and missing results have the same messages and files in every form (atlases: other tests)."""
    text = {
        "short": kinds()["zone"].replace("! max_points = 20000", "max_points = 100"),
        "nothing": kinds()["zone"].replace("clearance_min = 2 ", "clearance_min = 150 "),
        "missing": kinds()["chart"]
        .replace("_min = 5 ", "_min = 1e6 ")
        .replace("_max = 100", "_max = 2e6"),
        **BRANCHES,
    }[name]
    assert text not in kinds().values()
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "case.nml", text)
    assert main(["run", "case.nml", "-o", "plain"]) == 1
    plain, _ = heard(capfd)
    assert main(["run", "case.nml", "--format", "json", "-o", "json"]) == 1
    assert heard(capfd)[0] == plain
    assert main(["run", "case.nml", "--plot", "-o", "plot", "--quiet"]) == 1
    assert capfd.readouterr() == ("", plain[1])
    tables = contents(tmp_path / "plain")
    drawn = {key: item for key, item in contents(tmp_path / "plot").items() if key.endswith("csv")}
    assert drawn == tables
    others = {re.sub(r"(_\d)?\.json$", ".csv", key) for key in contents(tmp_path / "json")}
    assert others == set(tables)


def test_the_document_holds_the_results(tool):
    """With --json standard output is one document; its results are those of Python."""
    write(tool.cwd / "case.nml", kinds()["equispaced"])
    done = tool("run", "case.nml", "--json")
    document = json.loads(done.out)
    assert (document["command"], document["status"], document["faults"]) == ("run", 0, [])
    assert document["files"] == ["results/case.csv"]
    assert len(document["output"]) == 3
    assert document["output"][-1] == "case: results/case.csv"
    (case,) = vi.read_namelist(tool.cwd / "case.nml")
    assert list(document["results"].values()) == [motion.to_dict() for motion in case.run()]
    again = vi.Motion.from_dict(document["results"]["case_2"])
    assert again.X.tolist() == case.run()[1].X.tolist()


def test_attractors_in_other_forms(tool):
    """A response in JSON is that of the function."""
    line = ["--r", "1", "1.04", "3", "--clearance", "25", "--states", "3", "--format", "json"]
    done = tool("response", *SYSTEM, *line)
    assert (done.status, done.err) == (0, b"")
    wanted = vi.response(
        vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75),
        [1, 1.02, 1.04],
        clearance=25.0,
        states=3,
    )
    assert vi.load(tool.cwd / "results/response.json").to_json() == wanted.to_json()


def test_interrupted_cases_keep_what_is_finished(tmp_path, monkeypatch, capsys):
    """Ctrl-C in the second case: the first one is written; status 1 and one line."""
    module = importlib.import_module("vibroimpact.results.door")
    ours, calls = module.run_text, []

    def run_text(*arguments, **options):
        if calls:
            raise KeyboardInterrupt
        calls.append(1)
        return ours(*arguments, **options)

    monkeypatch.setattr(module, "run_text", run_text)
    case = kinds()["zone"].partition("&output")[0]
    path = write(tmp_path / "case.nml", case + case)
    assert main(["zone", str(path), "--format", "json", "-o", str(tmp_path / "out")]) == 1
    assert list(contents(tmp_path / "out")) == ["case_1.json"]
    assert capsys.readouterr().err == (
        f"vibroimpact zone: interrupted; finished results are kept: {tmp_path / 'out/case_1.json'}\n"
    )
    assert math.isfinite(vi.load(tmp_path / "out/case_1.json").area)


@pytest.mark.parametrize(("kind", "suffix"), [("zone", "csv"), ("exact", "csv"), ("exact", "json")])
def test_a_file_for_the_one_result(kind, suffix, tool, monkeypatch, capfd):
    """-o DIR/NAME.SUFFIX gives folder, form and name of the result; the table is that of a case of this name."""
    monkeypatch.chdir(tool.cwd)
    write(tool.cwd / "case.nml", kinds()[kind])
    assert main(["run", "case.nml", "-o", f"new/mine.{suffix}", "--plot", "svg"]) == 0
    assert capfd.readouterr().err == ""
    assert sorted(contents(tool.cwd)) == sorted(["case.nml", "new/mine.svg", f"new/mine.{suffix}"])
    (case,) = vi.read_namelist(tool.cwd / "case.nml")
    if suffix == "json":
        assert vi.load(tool.cwd / "new/mine.json").to_json() == case.run()[0].to_json()
    else:
        write(tool.cwd / "mine.nml", kinds()[kind])
        assert main(["run", "mine.nml", "-o", "run"]) == 0
        assert contents(tool.cwd / "run")["mine.csv"] == contents(tool.cwd / "new")["mine.csv"]


def test_a_file_for_two_motions(tool):
    """Two motions get numbered files, named in the output; a folder that stays empty is removed."""
    write(tool.cwd / "case.nml", kinds()["equispaced"])
    done = tool("run", "case.nml", "-o", "mine.json")
    assert done.files == ("mine_1.json", "mine_2.json")
    assert sorted(contents(tool.cwd)) == ["case.nml", "mine_1.json", "mine_2.json"]
    write(
        tool.cwd / "case.nml", kinds()["zone"].replace("clearance_min = 2 ", "clearance_min = 150 ")
    )
    assert tool("zone", "case.nml", "-o", "new/mine.json").status == 1
    assert not (tool.cwd / "new").exists()


@pytest.mark.parametrize(("words", "output"), [
    (["-o", "a.json", "--format", "netcdf"], "-o a.json: is the name of a json file; must be used with --format "
     "json, or without --format"),
    (["-o", "a.csv"], "-o a.csv: names a file, and there are 2 cases; must be a folder"),
])  # fmt: skip
def test_a_file_for_several_results(words, output, tool):
    """One file name for several results is refused."""
    write(tool.cwd / "case.nml", kinds()["periodic"] + kinds()["exact"])
    done = tool("run", "case.nml", *words)
    assert (done.status, done.out, done.faults) == (2, b"", [f"vibroimpact run: {output}"])
    assert list(contents(tool.cwd)) == ["case.nml"]


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pipe of POSIX")
@pytest.mark.parametrize("words", [["doctor"], ["doctor", "--json"], ["completion", "bash"]])
def test_a_reader_who_leaves(words, tool):
    """A closed standard output ends the command with status 1 and no traceback."""
    theirs, ours = os.pipe()
    os.close(theirs)
    with subprocess.Popen([find_command(), *words], stdout=ours, stderr=subprocess.PIPE) as run:
        os.close(ours)
        output = run.stderr.read()
    assert (run.returncode, output) == (1, b"")


@pytest.mark.parametrize("form", ["json", "csv"])
def test_interrupted_chart_is_written_as_far_as_it_came(form, tmp_path, monkeypatch, capsys):
    """Ctrl-C in a chart writes the finished points; the others have a status that says so."""
    monkeypatch.setattr("vibroimpact.base.interrupt.INTERVAL", 0.0005)

    def impatient(bar, share, note=""):
        if share > 0:
            raise KeyboardInterrupt

    monkeypatch.setattr("vibroimpact.base.progress.Progress.show", impatient)
    case = kinds()["chart"].replace("r_points = 21", "r_points = 400")
    path = write(
        tmp_path / "case.nml", case.replace("clearance_points = 16", "clearance_points = 20")
    )
    words = ["--format", form, "-o", str(tmp_path / "out")]
    assert main(["chart", str(path), *words]) == 1
    output = capsys.readouterr().err
    (name,) = contents(tmp_path / "out")
    assert output == (
        "vibroimpact chart: interrupted; writing what is finished ...\n"
        f"vibroimpact chart: interrupted; finished results are kept: {tmp_path / 'out' / name}\n"
    )
    if form == "csv":
        table = (tmp_path / "out" / name).read_text()
        assert re.search(r"\n# ! cut short: \d+ of 8000 points were reached\n", table)
        names, *rows = (line for line in table.splitlines() if line[0] != "#")
        assert names.endswith(",status")
        assert all(row.endswith(",0") for row in rows)  # only motions, without empty slots
        return
    record = json.loads((tmp_path / "out" / name).read_text())
    status = np.array(record["tables"]["motions"]["columns"]["status"])
    assert (status == 0).any()
    assert (status == 12).any()
