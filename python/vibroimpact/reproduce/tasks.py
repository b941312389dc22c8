"""The tasks of the recomputation, each with its dependencies, its outputs, and its fingerprint."""

from __future__ import annotations

import ast
import contextlib
import hashlib
import io
import json
import time
from collections.abc import Iterable
from functools import cache
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from ..base.files import write_text
from .paper import RATIOS
from .sweeps import RIGS

#: The names that a user can give.
NAMES = (
    "table1", "figure3", "figure4a", "figure4b", "figure6a", "figure6b", "figure7", "figure8a",
    "figure8b", "figures6to8", "figure9", "figure10a", "figure10b", "report",
)  # fmt: skip
#: The sweeps of each rig, on which bars and traced zones depend.
SWEEPS = {rig: tuple(f"sweep_{rig}_{r:.2f}" for r in RATIOS) for rig in RIGS}


class Task(NamedTuple):
    """A computation: module of this package, dependencies, outputs.

    `weight` is its approximate time in seconds, for the estimate of the remaining time.
    """

    module: str
    needs: tuple[str, ...]
    outputs: tuple[str, ...]
    weight: float


def _figure(name: str, weight: float, rig: str = "") -> Task:
    outputs = tuple(f"{name}.{kind}" for kind in ("png", "svg", "csv"))
    return Task(name, SWEEPS.get(rig, ()), outputs, weight)


#: Every task by name, each after its dependencies.
TASKS: dict[str, Task] = {
    name: Task("sweeps", (), (f"data/{name}.json",), 0.7 if rig == "equal" else 1.5)
    for rig, names in reversed(SWEEPS.items())
    for name in names
}
TASKS |= {
    "table1": Task("table1", (), ("table1.txt", "table1.csv"), 0.1),
    "figure3": _figure("figure3", 4.0),
    "figure4a": _figure("figure4a", 0.8),
    "figure4b": _figure("figure4b", 0.5),
    "figure6a": _figure("figure6a", 2.0, "equal"),
    "figure6b": _figure("figure6b", 2.0, "equal"),
    "figure7": _figure("figure7", 2.5, "equal"),
    "figure8a": _figure("figure8a", 3.5, "unequal"),
    "figure8b": _figure("figure8b", 25.0, "unequal"),
    "figures6to8": _figure("figures6to8", 7.0),
    "figure9": _figure("figure9", 1.0),
    "figure10a": _figure("figure10a", 0.7, "equal"),
    "figure10b": _figure("figure10b", 0.7, "unequal"),
    "phase_errors": Task("phase_errors", (), ("data/phase_errors.json",), 0.9),
    "appendix": Task("appendix", (), ("data/appendix.json",), 0.1),
}
TASKS["statements"] = Task("statements", tuple(TASKS), ("data/statements.json",), 3.0)
TASKS["report"] = Task("report", tuple(TASKS), ("report.html",), 0.1)


class Done(NamedTuple):
    """A finished task: whether it agrees with the paper, its messages, and its processor time in seconds."""

    name: str
    agrees: bool
    messages: str
    seconds: float


def with_needs(names: Iterable[str]) -> list[str]:
    """The named tasks and all their dependencies, in an order in which they can be performed."""
    wanted = set(names)
    for name in reversed(TASKS):
        if name in wanted:
            wanted |= set(TASKS[name].needs)
    return [name for name in TASKS if name in wanted]


def _digest(paths: Iterable[Path]) -> str:
    total = hashlib.sha256()
    for path in sorted(paths):
        total.update(path.name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()


def _imports(module: str, seen: set[str]) -> set[str]:
    """The modules of this folder that a module uses, including itself."""
    if module not in seen:
        seen.add(module)
        source = (Path(__file__).parent / f"{module}.py").read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                for name in [node.module] if node.module else [x.name for x in node.names]:
                    _imports(name, seen)
    return seen


def _core() -> Path:
    """The compiled core."""
    spec = find_spec("vibroimpact._core")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("vibroimpact._core")
    return Path(spec.origin)


@cache
def _sources(module: str) -> str:
    """Digest of everything on which a module's results depend: its sources, those of the package, the compiled
    core."""
    here = Path(__file__).parent
    package = {path for path in here.parent.rglob("*.py") if path.parent != here}
    package.discard(here.parent / "command.py")  # computes nothing
    used = _imports(module, set()) - {"tasks"}
    return _digest({_core(), *package, *(p for name in used for p in here.glob(f"{name}.*"))})


def fingerprint(name: str, resolution: float) -> str:
    """Digest of everything on which the outputs of a task depend: version, sources, resolution, and
    dependencies."""
    task = TASKS[name]
    parts = [name, version("vibroimpact"), _sources(task.module), repr(resolution)]
    parts += [fingerprint(need, resolution) for need in task.needs]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def _stamp(folder: Path, name: str) -> Path:
    return folder / "data" / f".{name}.done"


def seconds(folder: Path, name: str) -> float:
    """Processor time of a finished task in seconds."""
    return float(json.loads(_stamp(folder, name).read_text(encoding="utf-8"))["seconds"])


def recall(folder: Path, name: str, print_: str) -> Done | None:
    """The finished task, if its fingerprint and its outputs are still the same."""
    try:
        stamp: dict[str, Any] = json.loads(_stamp(folder, name).read_text(encoding="utf-8"))
        same = stamp["fingerprint"] == print_ and stamp["outputs"] == {
            output: _digest([folder / output]) for output in TASKS[name].outputs
        }
        return Done(name, stamp["agrees"], stamp["messages"], stamp["seconds"]) if same else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def perform(name: str, folder: Path, resolution: float, print_: str) -> Done:
    """Perform one task, write its outputs, and finally its stamp."""
    begin = time.process_time()
    task, messages = TASKS[name], io.StringIO()
    with contextlib.redirect_stdout(messages):
        if task.module == "sweeps":
            _, rig, r = name.split("_")
            import_module(f".{task.module}", __package__).run_sweep(
                folder, rig, float(r), resolution
            )
            agrees = True
        else:
            agrees = import_module(f".{task.module}", __package__).reproduce(folder, resolution)
    done = Done(name, bool(agrees), messages.getvalue(), time.process_time() - begin)
    outputs = {output: _digest([folder / output]) for output in task.outputs}
    stamp = {"fingerprint": print_, "outputs": outputs, **done._asdict()}
    write_text(_stamp(folder, name), json.dumps(stamp) + "\n")
    return done
