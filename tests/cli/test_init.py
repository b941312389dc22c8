"""The command init: its templates run unchanged, and have every key."""

import json
import re

import pytest
import vibroimpact as vi
from programs import IN_PYTHON, Runner, contents, find_batch, kinds, write
from vibroimpact.cases.case import read_namelist
from vibroimpact.designs import confirmation, search


@pytest.fixture
def templates(tool):
    """All templates, in the folder of the runner; the command itself writes one of them."""
    for name, text in kinds().items():
        write(tool.cwd / f"{name}.nml", text)
    (tool.cwd / "exact.nml").unlink()
    done = tool("init", "exact")
    assert (done.status, done.err) == (0, b"")
    assert (tool.cwd / "exact.nml").read_text() == kinds()["exact"]
    return tool.cwd


def test_every_kind_of_case_has_one(tool):
    """--list, and the message for an unknown name, list all kinds of cases."""
    done = tool("init", "--list")
    assert [line.split()[0] for line in done.out.decode().splitlines()] == list(kinds())
    assert list(json.loads(tool("init", "--list", "--json").out)["results"]) == list(kinds())
    for words in (["init"], ["init", "nothing"]):
        done = tool(*words)
        assert done.status == 2
        for name in kinds():
            assert name in done.err.decode()


def test_templates_run_through_all_doors(templates, tool, same_build, monkeypatch):
    """Each template runs by command, program and Python, with its kind, the same bytes and status 0.

    Those of studies that Python computes run by the command alone, and the program says so.
    """
    # a design by one search of few runs: how good it is does not matter here
    for name, number in (("STEPS", 1), ("TURNS", 0), ("VERIFIED", 400)):
        monkeypatch.setattr(search, name, number)
    monkeypatch.setattr(search.Archive, "agree", lambda *_: True)
    monkeypatch.setattr(confirmation, "FEW", 500)
    batch = Runner([find_batch()], templates)
    for name in IN_PYTHON:
        done = tool("run", f"{name}.nml", "-o", f"ours_{name}")
        assert (done.status, done.err, sorted(contents(templates / f"ours_{name}"))) == (
            0,
            b"",
            [f"{name}.csv"],
        )
        refused = batch(f"{name}.nml", "-o", "refused")
        assert refused.status == 1
        assert refused.faults == [
            f"{name}: &{name} is computed by the Python package: vibroimpact run FILE.nml"
        ]
    names = [f"{name}.nml" for name in kinds() if name not in IN_PYTHON]
    done = tool("run", *names, "-o", "command")
    assert (done.status, done.err) == (0, b"")
    assert batch(*names, "-o", "batch") == done
    assert vi.run_namelists([templates / name for name in names], templates / "python").status == 0
    found = contents(templates / "command")
    assert sorted(found) == sorted(name.replace(".nml", ".csv") for name in names)
    assert contents(templates / "batch") == contents(templates / "python") == found
    for name in kinds():
        (case,) = read_namelist(templates / f"{name}.nml")
        assert case.kind == ("simulate" if name in ("structure", "stops") else name)


@pytest.mark.parametrize("name", kinds())
def test_templates_explain_every_key(name, tool):
    """A template has all keys of its groups that the reader knows."""
    text = kinds()[name]
    for group in re.findall(r"^&(\w+)", text, re.MULTILINE):
        wrong = re.sub(rf"^&{group}\b.*$", f"&{group}\n  nonsense = 1", text, flags=re.MULTILINE)
        write(tool.cwd / "wrong.nml", wrong)
        (fault,) = tool("run", "wrong.nml").faults
        keys = re.search(r"must be one of (.*)$", fault)[1].split(", ")
        if group == "system":
            keys.remove("r")
        for key in keys:
            assert re.search(rf"^  (! )?{key}( =|:) ", text, re.MULTILINE), key


def test_defaults_are_those_that_are_shown(tmp_path):
    """A template with its commented defaults made active gives the same case."""
    for name, text in kinds().items():
        full = re.sub(r"^  ! (\w+ = )", r"  \1", text, flags=re.MULTILINE)
        (ours,) = read_namelist(write(tmp_path / f"{name}.nml", text))
        (theirs,) = read_namelist(write(tmp_path / f"{name}.nml", full))
        assert theirs == ours


def test_a_file_is_kept(tool):
    """An existing file is kept without --force; the file may have any name."""
    write(tool.cwd / "zone.nml", "mine")
    done = tool("init", "zone")
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert (tool.cwd / "zone.nml").read_text() == "mine"
    assert tool("init", "zone", "--force").status == 0
    assert (tool.cwd / "zone.nml").read_text().startswith("! ")
    done = tool("init", "zone", "-o", "other.nml")
    assert done.status == 0
    assert "run it by `vibroimpact run other.nml -o results`" in done.out.decode()
    assert "vibroimpact run other.nml" in (tool.cwd / "other.nml").read_text()
