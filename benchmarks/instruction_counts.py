"""Instructions of the cases that CI counts, compared with the kept numbers, where valgrind is installed.

Unlike times they do not depend on what else the machine does. A row has no kept number on another kind of machine.

Run with `python benchmarks/instruction_counts.py`; it needs the program of a release build in build/fortran.
"""

import importlib.util
import json
import shutil
from pathlib import Path

from table import row, show

ROOT = Path(__file__).resolve().parents[1]
PROGRAM = ROOT / "build" / "fortran" / "src" / "vibroimpact-batch"


def counter():
    """The module that CI counts with."""
    place = ROOT / ".ci" / "check_instructions.py"
    spec = importlib.util.spec_from_file_location("check_instructions", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rows():
    """Millions of instructions of each case."""
    if not (shutil.which("valgrind") and PROGRAM.exists()):
        return []
    module = counter()
    kept = json.loads(module.KEPT.read_text(encoding="utf-8")).get(module.combination(), {})
    return [
        row(
            f"instructions: {name}", "millions", module.count(str(PROGRAM), text) / 1e6, None,
            kept[name] / 1e6 if name in kept else None, "kept count",
        )
        for name, text in module.CASES.items()
    ]  # fmt: skip


if __name__ == "__main__":
    show(rows())
