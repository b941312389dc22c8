"""Builds of the editable package run one at a time: a second `vibroimpact` waits, and does not fail."""

import subprocess
import sys

from programs import ROOT

IN_TURN = [sys.executable, "-I", str(ROOT / "packaging/in_turn.py"), "lock"]
#: Fails if it runs twice at the same time.
ALONE = """
import os
for _ in range(2000):
    os.close(os.open("here", os.O_CREAT | os.O_EXCL))
    os.unlink("here")
"""


def test_commands_take_turns(tmp_path):
    """Eight commands that must not overlap run one by one; a nested command does not wait."""
    call = [*IN_TURN, *IN_TURN, sys.executable, "-I", "-c", ALONE]
    runs = [subprocess.Popen(call, cwd=tmp_path, stderr=subprocess.PIPE) for _ in range(8)]
    assert [(run.communicate()[1], run.returncode) for run in runs] == [(b"", 0)] * 8


def test_the_turn_ends_with_the_command(tmp_path):
    """The lock is released when the command ends, in whatever way, and its status is returned."""
    for words in (["sh", "-c", "kill -9 $$"], ["sh", "-c", "exit 3"], ["true"]):
        alone = subprocess.run(words, check=False).returncode
        assert subprocess.run([*IN_TURN, *words], cwd=tmp_path, check=False).returncode == alone
