"""Which tests reach which statements that have mutants, in the builds of switched.py.

The results are stored next to the builds, and updated for the tests that changed.
"""

import functools
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from package import variables
from statements import Statements
from switched import REACHED_BY_TESTS, ROOMS, ROOT, digest

#: Files that are left out: they call the core only as other tests do, or not at all.
LEFT_OUT = (
    "test_animation", "test_answers", "test_batch_command_line", "test_campaign", "test_completion", "test_drawn",
    "test_explorer", "test_faults", "test_imports", "test_in_turn", "test_jax", "test_jupyter",
    "test_malicious_files", "test_pictures", "test_plots", "test_public_names", "test_saving",
    "test_sensor_records", "test_threads",
)  # fmt: skip
#: Files whose tests take long and seldom detect what others miss; they are tried last.
LONG = (
    "test_audit", "test_commands", "test_docs", "test_examples", "test_identify", "test_published",
    "test_reproduce",
)  # fmt: skip
#: What pytest runs of a file.
SHORT_TESTS, LONG_TESTS, ALL_TESTS = (
    "not slow and not browser",
    "slow and not browser",
    "not browser",
)


def fortran(folder: Path) -> dict[str, set[int]]:
    """Return, for each program of Fortran tests, the statements that it reaches."""
    note = folder / "fortran.json"
    known = json.loads(note.read_text(encoding="utf-8")) if note.exists() else {}
    statements = Statements(folder)
    for room in ROOMS:
        program = folder / f"counted/tests/fortran/test_{room}"
        mark = digest(program)
        if known.get(room, [None])[0] == mark:
            continue
        with tempfile.TemporaryDirectory() as home:
            (reached := Path(home) / "reached").mkdir()
            subprocess.run([program], cwd=home, stdout=subprocess.DEVNULL, check=True,
                           env=os.environ | {"VIBROIMPACT_REACHED": str(reached)})  # fmt: skip
            places = {
                int(place) for path in reached.iterdir() for place in np.fromfile(path, np.uint32)
            }
        found = set(statements.of_places(program, sorted(places)).values()) - {0}
        known[room] = [mark, sorted(found)]
    note.write_text(json.dumps(known), encoding="utf-8")
    return {room: set(found) for room, (_, found) in known.items()}


def python(folder: Path, jobs: int) -> tuple[dict[int, list[tuple[float, str]]], set[str]]:
    """Return, for each statement, the Python tests that reach it (seconds, name), and which of all take long."""
    note = folder / REACHED_BY_TESTS
    known = json.loads(note.read_text(encoding="utf-8")) if note.exists() else {}
    asked = {
        f"{file}:{which}": digest(path)
        for room in ("python", "cli")
        for path in sorted((ROOT / "tests" / room).glob("test_*.py"))
        for file in [str(path.relative_to(ROOT))]
        for which in parts(path)
    }
    new = [part for part, mark in asked.items() if known.get(part, {}).get("of") != mark]
    if new:
        print(f"{len(new)} files of Python tests: what they reach", flush=True)
        for path in folder.glob("by_test.*"):
            path.unlink()
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(functools.partial(run, folder), new))
        known |= {part: {"of": asked[part], "tests": []} for part in new}
        for path in folder.glob("by_test.*"):
            part = path.name.partition(".")[2].rpartition(".")[0].replace("+", "/")
            for line in path.read_text(encoding="utf-8").splitlines():
                known[part]["tests"].append(json.loads(line))
            path.unlink()
        note.write_text(json.dumps(known), encoding="utf-8")
    found, long = defaultdict(list), set()
    for part in asked:
        for name, seconds, statements in known[part]["tests"]:
            if not part.endswith(SHORT_TESTS):
                long.add(name)
            for statement in statements:
                found[statement].append((seconds, name))
    return found, long


def parts(path: Path) -> list[str]:
    """Return which tests of a file are run, each part alone."""
    if path.stem.startswith(LEFT_OUT):
        return []
    if path.stem in LONG:
        return [ALL_TESTS]
    return [SHORT_TESTS, *[LONG_TESTS] * ("mark.slow" in path.read_text(encoding="utf-8"))]


def run(folder: Path, part: str) -> None:
    """Run a part of a file of tests with the package that counts: alone, because one of them may crash or hang."""
    file, _, which = part.partition(":")
    made = folder / "counted"
    paths = [str(made / "site"), str(ROOT / "tests/quality"), str(ROOT / "tests/python")]
    env = variables(made / "site", made / "src/vibroimpact-batch") | {
        "PYTHONPATH": os.pathsep.join(paths), "VIBROIMPACT_SWITCHED": str(folder),
        "VIBROIMPACT_REACHED_BY": str(folder / f"by_test.{part.replace('/', '+')}"),
    }  # fmt: skip
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "reached_by", "-m", which,
               file]  # fmt: skip
    quiet = {
        "stdin": subprocess.DEVNULL,
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
    }
    try:
        ended = subprocess.run(
            command, cwd=ROOT, env=os.environ | env, check=False, timeout=900, **quiet
        ).returncode
    except subprocess.TimeoutExpired:
        ended = "its time"
    # 1: some tests fail; 5: the part is empty
    if ended not in (0, 1, 5):
        print(f"{part} broke off ({ended}): what it reaches is known only in part", flush=True)
