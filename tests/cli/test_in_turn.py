"""Builds of the editable package take turns: `vibroimpact` waits for another one, and does not break."""

import subprocess
import sys

from programs import ROOT

IN_TURN = [sys.executable, "-I", str(ROOT / "packaging/in_turn.py"), "lock"]
#: Fails if another one is at it.
ALONE = """
import os
for _ in range(2000):
    os.close(os.open("here", os.O_CREAT | os.O_EXCL))
    os.unlink("here")
"""


def test_commands_take_turns(tmp_path):
    """Eight that would break each other, each by way of two that start it; what is inside does not wait."""
    call = [*IN_TURN, *IN_TURN, sys.executable, "-I", "-c", ALONE]
    runs = [subprocess.Popen(call, cwd=tmp_path, stderr=subprocess.PIPE) for _ in range(8)]
    assert [(run.communicate()[1], run.returncode) for run in runs] == [(b"", 0)] * 8


def test_the_turn_ends_with_the_command(tmp_path):
    """However it ends; its status is told."""
    for words in (["sh", "-c", "kill -9 $$"], ["sh", "-c", "exit 3"], ["true"]):
        alone = subprocess.run(words, check=False).returncode
        assert subprocess.run([*IN_TURN, *words], cwd=tmp_path, check=False).returncode == alone
