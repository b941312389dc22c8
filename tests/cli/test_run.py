"""The one command of a clone: what it says before it installs or builds anything."""

import subprocess
from pathlib import Path

import pytest

RUN = Path(__file__).parents[2] / "run"


def say(*words):
    done = subprocess.run([RUN, *words], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.mark.parametrize("words", [[], ["-h"], ["help"], ["bench", "--help"], ["test", "-h"]])
def test_help(words):
    """Of every command, none of which is begun."""
    status, out, err = say(*words)
    assert (status, err) == (0, "")
    for command in ("reproduce", "test", "bench", "docs", "lint", "wheel"):
        assert f"\n  ./run {command} " in out


@pytest.mark.parametrize(("words", "said"), [
    (["bench", "all"], "run: bench takes no arguments, not 'all'; see ./run --help"),
    (["lint", "python"], "run: lint takes no arguments, not 'python'; see ./run --help"),
    (["tests"], "run: no command 'tests'"),
])  # fmt: skip
def test_bad_words(words, said):
    status, out, err = say(*words)
    assert (status, out, err.splitlines()[-1]) == (2, "", said)
