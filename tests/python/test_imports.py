"""The imports of the package: no cycles, also not among those that run in functions."""

import ast
import graphlib
from pathlib import Path

import pytest
import vibroimpact as vi

PACKAGE = Path(vi.__file__).parent


def target(path, node, name):
    """The file of the package that `from ... import name` names; None for other packages."""
    if not node.level:
        return None
    folder = path.parent
    for _ in range(node.level - 1):
        folder = folder.parent
    for part in (node.module or "").split("."):
        folder = folder / part if part else folder
    for found in (
        folder / f"{name}.py",
        folder / name / "__init__.py",
        folder.with_suffix(".py"),
        folder / "__init__.py",
    ):
        if found.is_file():
            return found
    return None


def imports(path, inside):
    """The files that a file imports when it is imported, or (`inside`) when its functions run too."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in statements(tree, inside):
        if isinstance(node, ast.ImportFrom):
            for item in node.names:
                found = target(path, node, item.name)
                # the package itself imports all results and studies for its users
                if found not in (None, path, PACKAGE / "__init__.py"):
                    yield str(found.relative_to(PACKAGE))


def statements(tree, inside):
    """Statements that run, with or without those in functions, except those for type checkers."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not inside:
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        yield from statements(node, inside)


@pytest.mark.parametrize("inside", [False, True])
def test_no_circle(inside):
    """Neither among imports at the top of files nor with those inside functions."""
    paths = {str(path.relative_to(PACKAGE)): path for path in PACKAGE.rglob("*.py")}
    assert len(paths) > 100
    graph = {name: set(imports(path, inside)) for name, path in paths.items()}
    graphlib.TopologicalSorter(graph).prepare()
