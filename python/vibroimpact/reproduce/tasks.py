"""The tasks of the recomputation, each with its dependencies and its outputs."""

from __future__ import annotations

import contextlib
import io
import json
import time
from collections.abc import Iterable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from ..base.files import write_text
from .paper import RATIOS
from .sweeps import RIGS

#: The names that a user can give.
NAMES = (
    "table1", "figure3", "figure4a", "figure4b", "figure6a", "figure6b", "figure7", "figure8a",
    "figure8b", "figures6to8", "figure9", "figure10a", "figure10b", "report", "proof6a",
)  # fmt: skip
#: Items that are computed only if they are named.
ON_REQUEST = ("proof6a",)
#: The sweeps of each rig, on which bars and traced zones depend.
SWEEPS = {rig: tuple(f"sweep_{rig}_{r:.2f}" for r in RATIOS) for rig in RIGS}


class Task(NamedTuple):
    """A computation: module of this package, dependencies, outputs.

    `weight` is the approximate computing time in seconds, for the estimate of the remaining time.
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
TASKS["proof6a"] = Task("proof6a", (), ("proof6a.png", "proof6a.svg", "proof6a.json"), 160.0)


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


def _stamp(folder: Path, name: str) -> Path:
    return folder / "data" / f".{name}.done"


def seconds(folder: Path, name: str) -> float:
    """Processor time of a finished task in seconds."""
    return float(json.loads(_stamp(folder, name).read_text(encoding="utf-8"))["seconds"])


def perform(name: str, folder: Path, resolution: float) -> Done:
    """Perform one task, write its outputs, and finally its outcome."""
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
    write_text(_stamp(folder, name), json.dumps(done._asdict()) + "\n")
    return done
