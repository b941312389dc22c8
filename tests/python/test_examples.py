"""Every example in a docstring runs and prints the output shown, and every namelist in `inputs` runs."""

import doctest
import importlib
import pkgutil
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
    """The examples of each module print the output shown, in any current folder."""
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


@pytest.mark.parametrize(
    "path", sorted((ROOT / "inputs").glob("*.nml")), ids=lambda path: path.stem
)
def test_ready_cases(path, tmp_path):
    """Every namelist of inputs/ is listed in its README, and what Python computes runs.

    The others run in tests/cli/test_batch_studies.py.
    """
    cases = vibroimpact.read_namelist(path)
    if "&sweep\n" in path.read_text(encoding="utf-8"):
        pytest.importorskip("zarr")
        found = vibroimpact.campaign(vibroimpact.Sweep.of_case(cases[0]), tmp_path / "store")
        assert found.finished.all()
        assert not found.refused
    elif any(case.in_python for case in cases):
        assert all(case.run() for case in cases)
    assert f"`{path.name}`" in (ROOT / "inputs" / "README.md").read_text(encoding="utf-8")
