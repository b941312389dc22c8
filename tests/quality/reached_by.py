"""A pytest plugin that records which statements with mutants each test reaches, in a package that counts
statements.

Statements that a shared fixture reaches count for each of its tests. Each line of the file that
VIBROIMPACT_REACHED_BY names (followed by the process id) contains a test, its seconds and its statements.
Parameter sets of a parametrised test that reach no further statements are omitted.
"""

import ctypes
import json
import os
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from statements import Statements
from vibroimpact import _core

from door import BLOCKS

FOLDER = Path(os.environ["VIBROIMPACT_SWITCHED"])


class Counters:
    """The statements that this process and its children have reached."""

    def __init__(self):
        self.c = ctypes.CDLL(str(FOLDER / "libreached.so"))
        self.counts = np.ctypeslib.as_array((ctypes.c_uint32 * BLOCKS).in_dll(self.c, "reached"))
        self.statements = Statements(FOLDER)
        #: By program and place: the statement.
        self.known: dict[tuple[str, int], int] = {}
        self.children = tempfile.mkdtemp()
        os.environ["VIBROIMPACT_REACHED"] = self.children

    def take(self) -> set[int]:
        """Return what was reached since the last call."""
        found = {Path(_core.__file__).resolve(): np.flatnonzero(self.counts.copy()).tolist()}
        self.counts[:] = 0
        for path in Path(self.children).iterdir():
            name = path.name.partition(".")[2]
            program = next(iter((FOLDER / "counted").glob(f"*/{name}")), None)
            if program:
                found.setdefault(program, []).extend(np.fromfile(path, np.uint32).tolist())
            path.unlink()
        reached = set()
        for program, places in found.items():
            new = [place for place in set(places) if (program, place) not in self.known]
            if new:
                said = self.statements.of_places(program, new)
                self.known |= {(program, place): number for place, number in said.items()}
            reached |= {self.known[program, place] for place in places}
        return reached - {0}


counters = Counters()
of_fixtures: dict[str, set[int]] = {}
of_functions: dict[str, set[int]] = {}
here: set[int] = set()


@pytest.hookimpl(hookwrapper=True)
def pytest_fixture_setup(fixturedef):
    """Store what a shared fixture reaches."""
    if fixturedef.scope == "function":
        yield
        return
    here.update(counters.take())
    yield
    of_fixtures.setdefault(fixturedef.argname, set()).update(counters.take())


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """Write what a test reaches."""
    here.clear()
    counters.take()
    begin = time.monotonic()
    yield
    seconds = time.monotonic() - begin
    here.update(counters.take())
    for name in item.fixturenames:
        here.update(of_fixtures.get(name, ()))
    before = of_functions.setdefault(item.nodeid.partition("[")[0], set())
    if before and here <= before:
        return
    before.update(here)
    with Path(f"{os.environ['VIBROIMPACT_REACHED_BY']}.{os.getpid()}").open(
        "a", encoding="utf-8"
    ) as out:
        print(json.dumps([item.nodeid, round(seconds, 3), sorted(here)]), file=out)


def pytest_unconfigure():
    """Remove the folder of the child processes."""
    shutil.rmtree(counters.children, ignore_errors=True)
