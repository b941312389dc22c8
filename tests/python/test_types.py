"""Annotations: calls of all forms, with points and units, pass a type checker, and return the right class."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

CALLS = Path(__file__).with_name("typed_calls.py")
ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_calls_of_all_forms_pass_mypy(tmp_path):
    """`typed_calls.py` passes without an error, and fails after a wrong type is inserted."""
    pytest.importorskip("mypy")
    wrong = tmp_path / "wrong_calls.py"
    wrong.write_text(CALLS.read_text() + "\nvi.equispaced(point, cycles=[1])\n")
    command = [sys.executable, "-m", "mypy", "--config-file", ROOT / "pyproject.toml"]
    for path, status in ((CALLS, 0), (wrong, 1)):
        found = subprocess.run([*command, path], cwd=ROOT, capture_output=True, text=True)
        assert found.returncode == status, found.stdout
