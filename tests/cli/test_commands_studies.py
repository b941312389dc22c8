"""The commands branch, zone and atlas: options for a namelist, forms of results, the bar."""

import importlib
import json
import sys

import pytest
import vibroimpact as vi
from programs import (
    PAIR,
    POINT,
    bars,
    column,
    contents,
    on_terminal,
    rows,
    write,
)

from studies import ATLAS, BRANCH, WALLS, ZONE, assert_atlas

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
    assert (done.status, done.err) == (0, b"")  # no bar without a terminal
    found = contents(tool.cwd / "results")
    assert sorted(found) == [f"{name}.csv", f"{name}.svg"]
    assert found[f"{name}.csv"] == contents(tool.cwd / "file")[f"{name}.csv"]
    assert tool("plot", f"{name}.nml", "--format", "svg", "-o", "plot").status == 0
    assert contents(tool.cwd / "plot")[f"{name}.svg"] == found[f"{name}.svg"]


def test_zone_as_json(tool):
    """The JSON holds the zone of the API."""
    done = tool("zone", *WINDOW, "--format", "json")
    assert (done.status, done.err) == (0, b"")
    assert list(contents(tool.cwd / "results")) == ["zone.json"]
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    zone = vi.zone(osc, vi.Pattern("RL"), (0.8, 1.2), (2, 200), symmetric=False)
    data = json.loads((tool.cwd / "results/zone.json").read_text())
    assert data == json.loads(json.dumps(zone.to_dict()))


def test_atlas_as_json(tool):
    """The JSON equals that of Atlas.save, and its zones are those of the table."""
    done = tool("atlas", *ATLAS_OPTIONS, "--format", "json")
    assert (done.status, done.err) == (0, b"")
    assert list(contents(tool.cwd / "results")) == ["atlas.json"]
    assert tool("atlas", *ATLAS_OPTIONS) == done
    assert_atlas(tool.cwd / "results/atlas.csv", vi.Atlas.load(tool.cwd / "results/atlas.json"))


def test_atlas_of_nothing_as_json(tool):
    """An empty atlas gives the same line as with a table, status 1, and no file."""
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
    """The progress of cases goes from 0 to 1, and does not change the results."""
    write(tmp_path / "case.nml", case)
    monkeypatch.setattr(importlib.import_module("vibroimpact.base.interrupt"), "INTERVAL", 0.001)
    shares = []
    message = vi.run_namelists([tmp_path / "case.nml"], tmp_path / "told", progress=shares.append)
    assert shares
    assert shares == sorted(shares)
    assert 0 <= shares[0] < shares[-1] <= 1
    plain = vi.run_namelists([tmp_path / "case.nml"], tmp_path / "plain")
    output = [(fault, line.replace("/plain/", "/told/")) for fault, line in plain.lines]
    assert (message.status, message.lines) == (plain.status, output)
    assert contents(tmp_path / "told") == contents(tmp_path / "plain")


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize("form", ["csv", "json"])
def test_bar_on_a_terminal(form, tool):
    """On a terminal the command shows its progress and the time left, and erases the bar at the end."""
    status, output = on_terminal(
        tool.cwd, "atlas", *ATLAS_OPTIONS, "--max-impacts", "3", "--format", form
    )
    assert status == 0
    assert "\ratlas [" in output
    assert " s left " in output
    assert "\n" not in output
    assert output.endswith(" \r")
    assert bars(output) == sorted(bars(output))


FINE = [*ALONG_OPTIONS, "--longest-step", "0.00005", "--max-points", "80000"]


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize(
    ("form", "stop"), [("csv", None), ("csv", r"\[#{3}"), ("json", r"\[#{10}")]
)
def test_bar_of_a_branch(form, stop, tool):
    """The bar never decreases and gives the time left; Ctrl-C keeps the points so far, with status 1."""
    status, output = on_terminal(tool.cwd, "branch", *FINE, "--format", form, stop=stop)
    assert len(bars(output)) > 5
    assert bars(output) == sorted(bars(output))
    assert "\rbranch [" in output
    assert " s left " in output
    name = f"results/branch.{form}"
    assert list(contents(tool.cwd / "results")) == [f"branch.{form}"]
    if stop is None:
        assert (status, output[-2:]) == (0, " \r")
        return
    assert status == 1
    kept = f"vibroimpact branch: interrupted; finished results are kept: {name}"
    assert output.splitlines()[-1].endswith(kept)
    if form == "csv":
        found = column(rows(tool.cwd / name), "clearance")
        cut = f"clearance from {min(found):.6g} to {max(found):.6g} was reached"
        assert f"\n# ! cut short: {cut}\n" in (tool.cwd / name).read_text()
        assert [case.kind for case in vi.read_namelist(tool.cwd / name)] == ["branch"]
    else:
        assert not vi.load(tool.cwd / name).complete


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
def test_bar_of_several_cases(tool):
    """The bar of several cases fills once, with the number of results so far."""
    case = ZONE.removeprefix(WALLS)
    write(tool.cwd / "case.nml", WALLS + 4 * case)
    status, output = on_terminal(tool.cwd, "run", "case.nml")
    assert (status, len(contents(tool.cwd / "results"))) == (0, 4)
    lengths = bars(output)
    assert lengths == sorted(lengths)
    # one of four cases: without the count of results the bar would be full
    assert 0 < sum(length < 24 for length in lengths) < len(lengths)
    assert lengths[-1] > 20


def test_equispaced_pair_by_options(tool):
    """Without phases both equispaced motions are followed."""
    options = [*POINT, "--parameter", "r", "--bounds", "0.93", "0.95"]
    assert tool("branch", *options).status == 0
    assert {row["branch"] for row in rows(tool.cwd / "results/branch.csv")} == {"1", "2"}


@pytest.mark.parametrize(("words", "output"), [
    (["zone", *WINDOW[:-2], "200", "2"],
     "vibroimpact zone: --clearance 200 2: must have 1e-12 <= HIGH <= 1e12, and LOW below HIGH"),
    (["zone", *WINDOW, "--lines", "4"], "vibroimpact zone: --lines 4: must be a whole number with 5 <= lines"),
    (["zone", *WINDOW[2:]], "vibroimpact zone: --xi: must be given, or a namelist file"),
    (["zone", "case.nml", "--xi", "0.1"], "vibroimpact zone: --xi: must be left out if a namelist file is given"),
    (["zone", "--xi", "0.1", "--r", "0.9", "1.1", "7"],
     "vibroimpact zone: 7 is one value too many for the option"),
    (["zone", "case.nml"], "case.nml: must contain a group &zone; there is none"),
    *[(["atlas", *ATLAS_OPTIONS, "--max-impacts", "9", "--format", form], output)
      for form, output in ((form, "vibroimpact atlas: --max-impacts 9: must be a whole number with 2 <=")
                         for form in ("csv", "json"))],
    (["atlas", *ATLAS_OPTIONS[2:]], "vibroimpact atlas: --xi: must be given, or a namelist file"),
    (["atlas", "case.nml"], "case.nml: must contain a group &atlas; there is none"),
    (["atlas", "case.nml", "--format", "json"],
     "case.nml: must contain a group &atlas; there is none"),
    (["branch", *ALONG_OPTIONS[:-1], "nan"], "vibroimpact branch: --bounds 10 nan: must be a number above low"),
    (["branch", *ALONG_OPTIONS[:-3]], "vibroimpact branch: --bounds: must be given"),
    (["branch", *POINT, "--sides", "R'L", "--phases-over-pi", "0", "1", "--parameter", "r", "--bounds", ".9", "1"],
     "vibroimpact branch: --sides 'R''L': must be letters R and L"),
])  # fmt: skip
def test_bad_options(words, output, tool):
    """Invalid options give one line that names them and status 2, and nothing is written."""
    write(tool.cwd / "case.nml", PAIR)
    done = tool(*words)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(output)
    assert list(contents(tool.cwd)) == ["case.nml"]
