"""Every block of the documentation and of README.md runs, in order, and prints the output shown.

Python blocks of a page share their names; the text block after one is its output. A Fortran block
with a caption, or with its name as the first comment, is a file, and a line of a console block that
starts with $ is a command, in the folder of these files. Blocks of type sh are not run: they install, or
take minutes. A MATLAB block is run by GNU Octave where that is installed.
"""

import contextlib
import io
import os
import re
import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md")), *sorted(DOCS.glob("howto/*.md"))]
BLOCK = re.compile(r"^```(\S+)(?: \w+\n:caption: (\S+)\n)?\n(.*?)^```", re.DOTALL | re.MULTILINE)


def run_python(code, names):
    """The output of a block."""
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(code, "page", "exec"), names)
    return output.getvalue()


def run_console(block):
    """The block with the current output of its commands."""
    scripts = sysconfig.get_path("scripts")
    environment = os.environ | {"PATH": f"{scripts}{os.pathsep}{os.environ['PATH']}"}
    lines = []
    for command in re.findall(r"^\$ (.*)$", block, re.MULTILINE):
        done = subprocess.run(
            command, shell=True, text=True, capture_output=True, env=environment, check=False
        )
        assert done.returncode == 0, f"{command}\n{done.stderr}"
        lines.append(f"$ {command}\n{done.stdout}")
    return "".join(lines)


def run_octave(code):
    """The output of GNU Octave; None if it is not installed."""
    if not shutil.which("octave"):
        return None
    command = ["octave", "--no-gui", "--quiet", "--no-init-file", "--eval", code]
    return subprocess.run(command, text=True, capture_output=True, check=True).stdout


@pytest.mark.parametrize(
    "page",
    [page for page in PAGES if BLOCK.search(page.read_text(encoding="utf-8"))],
    ids=lambda page: page.stem,
)
def test_blocks(page, tmp_path, monkeypatch):
    """The blocks of a page, from the first to the last."""
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    names, printed = {}, None
    for language, caption, block in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "text" and printed is not None:
            assert printed == block
        elif name := caption or (language == "fortran" and re.match(r"! (\S+\.nml)\n", block)):
            Path(name if caption else name[1]).write_text(block, encoding="utf-8")
        elif language == "console":
            assert run_console(block) == block
        run = {"python": lambda code: run_python(code, names), "matlab": run_octave}.get(language)
        printed = run(block) if run else None


def test_readme_shows_what_it_says():
    """README.md has two blocks of Python and one namelist, which print the output shown."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    languages = [language for language, _, _ in BLOCK.findall(text)]
    assert languages == ["python", "text", "python", "text", "fortran", "console"]
    for path in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (ROOT / path).exists(), path
