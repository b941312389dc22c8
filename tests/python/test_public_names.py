"""The explorer and the reproduction of the paper use only public names of the package."""

import ast
from pathlib import Path

import pytest
import vibroimpact as vi

PACKAGE = Path(vi.__file__).parent
#: Modules that all parts of the package share: errors and checks of values, files written whole or not at all,
#: interruptible calls, figures of many systems, progress bars, the style of pictures, areas and winding numbers of
#: closed curves.
SERVICES = {"base", "results.performance", "plot", "proofs.balls", "studies.geometry"}


def imported(path):
    """Pairs (module of the package, name) that a file imports from outside its own folder."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == 2:
            for item in node.names:
                yield node.module or "", item.name
        names = [item.name for item in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            names.append(node.module)
        for name in names:
            assert name == "vibroimpact" or not name.startswith("vibroimpact."), (path.name, name)


@pytest.mark.parametrize("folder", ["explorer", "reproduce"])
def test_public_names_alone(folder):
    files = sorted((PACKAGE / folder).glob("*.py"))
    assert len(files) > 10
    taken = [(path.name, *pair) for path in files for pair in imported(path)]
    assert any(not module for _, module, _ in taken)
    for name, module, what in taken:
        public = not module and what in {*vi.__all__, *SERVICES}
        service = any(module == one or module.startswith(f"{one}.") for one in SERVICES)
        assert public or service, (
            f"{name} takes {what} of {module or 'the package'}, which is not public"
        )
