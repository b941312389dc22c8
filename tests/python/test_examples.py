"""Every example in a docstring and in README.md runs and prints what it says."""

import contextlib
import doctest
import importlib
import io
import pkgutil
import re
from pathlib import Path

import pytest
import vibroimpact

MODULES = ["vibroimpact"] + [
    module.name
    for module in pkgutil.walk_packages(vibroimpact.__path__, "vibroimpact.")
    if not module.name.endswith("_core")
]
ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", MODULES)
def test_docstring_examples(name, tmp_path, monkeypatch):
    """The examples of each module give the printed results, in any folder."""
    monkeypatch.chdir(tmp_path)
    failures, _ = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert failures == 0


def test_public_functions_have_examples():
    """Every public class and function has a docstring, every function an example."""
    for name in vibroimpact.__all__:
        thing = getattr(vibroimpact, name)
        if name != "errors":
            assert thing.__doc__, name
        if callable(thing) and not isinstance(thing, type) and name != "status_text":
            assert ">>>" in thing.__doc__, name


def test_readme_python_blocks(tmp_path, monkeypatch):
    """The Python of README.md prints the text that follows it, in any folder."""
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == text.count("```python")
    for code, printed in blocks:
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(code, "README.md", "exec"), {})
        assert output.getvalue() == printed


def test_readme_namelist_block(tmp_path):
    """The namelist of README.md runs."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (tmp_path / "readme.nml").write_text(
        re.search(r"```fortran\n(.*?)```", text, re.DOTALL).group(1)
    )
    log = vibroimpact.run_namelists([tmp_path / "readme.nml"], tmp_path)
    assert log.status == 0
    assert (tmp_path / "pair.csv").exists()
    assert (tmp_path / "pair.txt").exists()


@pytest.mark.parametrize(
    "path", sorted((ROOT / "inputs").glob("*.nml")), ids=lambda path: path.stem
)
def test_ready_cases(path, tmp_path):
    """Every namelist of inputs/ runs, and is listed in its README."""
    assert vibroimpact.run_namelists([path], tmp_path).status == 0
    assert f"`{path.name}`" in (ROOT / "inputs" / "README.md").read_text(encoding="utf-8")
