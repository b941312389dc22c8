"""The imports of the package: no cycles, and each subpackage imports only from earlier ones."""

import ast
import functools
import graphlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
import vibroimpact as vi

PACKAGE = Path(vi.__file__).parent
#: The subpackages, and the top-level modules: each may import from earlier ones, also for type checkers.
ROOMS = (
    "base", "systems", "results", "motions", "derivatives", "studies", "cases", "designs", "identification",
    "proofs", "campaigns", "formats", "plot", "physical_results", "jax", "__init__", "reproduce", "explorer",
    "commands",
)  # fmt: skip


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


@functools.cache
def parsed(path):
    """The syntax tree of a file, which several tests walk through."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(path, inside, typed=False):
    """The files that a file imports when it is imported, and (`inside`) when its functions run.

    typed: also those that only type checkers import.
    """
    tree = parsed(path)
    for node in ast.walk(tree) if typed else statements(tree, inside):
        if isinstance(node, ast.ImportFrom):
            for item in node.names:
                found = target(path, node, item.name)
                # the package itself imports all results and studies for its users
                if found not in (None, path, PACKAGE / "__init__.py"):
                    yield str(found.relative_to(PACKAGE))


def statements(tree, inside):
    """Statements that run, with or without those in functions, except those for type checkers only."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)) and not inside:
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        yield from statements(node, inside)


@pytest.mark.parametrize("kind", ["top", "functions", "types"])
def test_no_circle(kind):
    """There are no cycles at the top, with imports inside functions, or with those of annotations."""
    paths = {str(path.relative_to(PACKAGE)): path for path in PACKAGE.rglob("*.py")}
    assert len(paths) > 100
    graph = {
        name: set(imports(path, kind != "top", kind == "types")) for name, path in paths.items()
    }
    graphlib.TopologicalSorter(graph).prepare()


def test_rooms_import_one_way():
    """A file imports only from its own subpackage and earlier ones; few modules are outside the subpackages."""
    paths = [path for path in PACKAGE.rglob("*.py") if path.name != "_build.py"]
    names = {path: str(path.relative_to(PACKAGE)) for path in paths}
    assert sum("/" not in name for name in names.values()) <= 10
    place = {name: ROOMS.index(name.removesuffix(".py").split("/")[0]) for name in names.values()}
    wrong = [
        f"{name} imports {found}"
        for path, name in names.items()
        for found in imports(path, inside=True, typed=True)
        if place[found] > place[name]
    ]
    assert wrong == []


def modules_after(statement):
    """The modules that a new interpreter has loaded after a statement."""
    text = f"import sys\n{statement}\nprint(*sys.modules)"
    process = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, check=True
    )
    return set(process.stdout.split())


def test_the_package_imports_what_is_used():
    """A name loads its module when it is used; before, neither NumPy nor the core is loaded."""
    names = modules_after("import vibroimpact")
    # Python itself, and an editable install, may have loaded some
    names -= modules_after("pass")
    own = {name for name in names if name.startswith("vibroimpact.")}
    assert own == {"vibroimpact.base", "vibroimpact.base.errors", "vibroimpact.base.actions"}
    assert "numpy" not in names
    assert "vibroimpact.studies.zone" not in modules_after(
        "import vibroimpact; vibroimpact.Oscillator"
    )


@pytest.mark.parametrize("name", vi.__all__)
def test_public_names(name):
    """Each public name exists, and no module takes its place."""
    assert getattr(vi, name) is vi.__getattr__(name)
    assert not isinstance(getattr(vi, name), type(ast)) or name == "errors"


def test_an_unknown_name_is_an_attribute_error():
    """A missing attribute gives the same error as in any module."""
    with pytest.raises(AttributeError, match=r"module 'vibroimpact' has no attribute 'Zones'"):
        vi.Zones  # noqa: B018


#: The text of `vibroimpact --help`, without ending the process.
HELP = """import sys
sys.argv = ["vibroimpact", "--help"]
from vibroimpact_start import main
try:
    main()
except SystemExit:
    pass"""
#: Limits on the modules of the package and all modules after a start, and the other packages in use.
STARTS = {"import vibroimpact": (4, 135, set()), HELP: (20, 315, {"numpy"})}


@pytest.mark.parametrize("start", STARTS, ids=["import", "help"])
def test_a_start_imports_little(start):
    """Modules are counted, not seconds; neither a start nor the help needs an optional library."""
    own, most, packages = STARTS[start]
    environ = {**os.environ, "VIBROIMPACT_BUILT": "1"}
    line = [sys.executable, "-c", f"{start}\nimport sys; print(*sys.modules)"]
    done = subprocess.run(line, capture_output=True, text=True, check=True, env=environ)
    modules = set(done.stdout.splitlines()[-1].split())
    ours = {name for name in modules if name.split(".")[0] == "vibroimpact"}
    assert len(ours) <= own, sorted(ours)
    assert len(modules) <= most, sorted(modules)
    folders = {
        name.split(".")[0]
        for name in modules - ours
        if not name.startswith(("_", "vibroimpact_start"))
    }
    assert folders - set(sys.stdlib_module_names) - {"cython_runtime"} <= packages
    assert not {"numpy.testing", "numpy.f2py", "matplotlib", "scipy", "xarray", "flint"} & modules
