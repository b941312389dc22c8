"""The help of each command: its example works as pasted, and it is complete."""

import os
import re
import subprocess

import pytest
from programs import BIN, contents
from vibroimpact.commands import NAMES, STUDIES
from vibroimpact.commands.command import module_of, parsers

EXAMPLES = {name: module_of(name).EXAMPLE for name in NAMES}
#: What each example writes; those that write nothing have tests of their own.
WRITTEN = {
    **{name: [f"results/{name}.csv"] for name in STUDIES},
    "run": ["exact.nml", "results/exact.csv"],
    "simulate": ["results/simulate.csv", "results/simulate.png"],
    "find": ["results/find.csv", "results/find.png"],
    "plot": ["results/zone.png", "zone.nml"],
    "init": ["zone.nml"],
    "prove": ["exact.nml", "results/exact_proof.json"],
    "reproduce": ["results/data/.table1.done", "results/table1.csv", "results/table1.txt"],
}  # fmt: skip


def test_help_has_the_example_and_the_exit_status():
    """The help of each command, and of `vibroimpact`, has an example and the exit statuses."""
    whole, each = parsers()
    assert list(each) == list(NAMES)
    for name, parser in each.items():
        text = re.sub(r"\s+", " ", parser.format_help())
        assert re.sub(r"\s+", " ", f"example: {EXAMPLES[name]}") in text
        assert (
            "exit status: 0 done; 1 ran, but something failed or was not found; 2 the input is wrong"
            in text
        )
        assert ("Ctrl-C: finished results are kept, status 1" in text) == (
            name == "campaign" or (name in WRITTEN and name != "init")
        )
        assert "--quiet" in text
        assert "--json" in text
    assert "exit status: 0" in whole.format_help()


@pytest.mark.parametrize("name", NAMES)
def test_every_option_is_explained(name):
    """Every option has a text that ends without a full stop and names the default, if there is one."""
    _, each = parsers()
    for action in each[name]._actions:
        assert action.help, action.dest
        assert not action.help.endswith("."), action.help
        assert len(action.help) < 130, action.help
    assert all(len(line) < 100 for line in each[name].description.splitlines())


def test_no_figure_of_the_paper_is_absent_without_a_word():
    """The help of `reproduce` lists each of the ten figures, or says that there is nothing in it to compute."""
    text = re.sub(r"\s+", " ", module_of("reproduce").DESCRIPTION)
    nothing = re.search(r"Figures ([\d, and]+) show .*; they contain nothing to compute", text)
    named = {*map(int, re.findall(r"\d+", nothing[1])), *map(int, re.findall(r"figure(\d+)", text))}
    assert named == {*range(1, 11)}


@pytest.mark.parametrize("name", WRITTEN)
def test_example_as_pasted(name, tmp_path):
    """In an empty folder, each example run by a shell has status 0, an empty standard error, and its files."""
    done = subprocess.run(
        EXAMPLES[name], shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(contents(tmp_path)) == WRITTEN[name]
