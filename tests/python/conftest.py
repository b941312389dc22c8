"""Results that several test files use."""

import signal
from typing import ClassVar

import pytest

# a failed assert in these modules shows the compared values, as in a test
pytest.register_assert_rewrite(
    "reference_regimes", "shared_laws", "shared_simulations", "shared_structures"
)

import vibroimpact as vi  # noqa: E402
from shared_answers import few_of_each, load  # noqa: E402
from shared_design import short_searches  # noqa: E402
from shared_explorer import browser, page, server  # noqa: E402, F401
from shared_motions import COLUMN, rest_motion  # noqa: E402
from shared_results import example  # noqa: E402
from shared_systems import FIGURE6, TABLE  # noqa: E402

START = {"t": 0, "x": 3.5, "x_dot": 0, "z": 0, "z_dot": -2}


def pytest_addoption(parser):
    """Add the options for the size of the audit."""
    group = parser.getgroup("audit", "random systems against an independent simulation")
    group.addoption("--audit-systems", type=int, default=3, help="systems (3)")
    group.addoption("--audit-points", type=int, default=12, help="points of each system (12)")
    group.addoption(
        "--audit-structures", type=int, default=60, help="structures with elements (60)"
    )
    group.addoption("--audit-seed", type=int, default=1, help="seed of the systems and points (1)")


def pytest_configure():
    """Let programs that tests start be interrupted, even when these run in the background of a script."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items):
    """Mark the tests that need a browser."""
    for item in items:
        if "browser" in item.fixturenames:
            item.add_marker("browser")


@pytest.fixture(scope="session")
def kept_cases(pytestconfig):
    """The kept cases with their answers; with --share 0.1 every sixth, otherwise with --once few of each kind."""
    asked = pytestconfig.getoption("--share")
    if asked < 0.6:
        return load()[:: round(0.6 / asked)]
    return few_of_each(load()) if pytestconfig.getoption("--once") else load()


@pytest.fixture(scope="session")
def results():
    """One result of each kind, including the kinds that other results contain."""
    motion = vi.exact(TABLE, 0.94, 37.0, COLUMN)
    uneven = vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.75, 0.61))
    return {
        "motion": motion,
        "rest": rest_motion(),
        "free": vi.exact(TABLE, 0.94, 74.0, motion, load=2.0),
        "pair": vi.equispaced(TABLE, 0.94, 37.0)[0],
        "linear": vi.periodic(
            TABLE, 0.94, [0, 2.0, 4.1], vi.Pattern("RRL"), [0.7, 0.8, 0.75], "single"
        ),
        "trajectory": vi.simulate(TABLE, 0.94, 37.0, 20, START),
        "rests": vi.simulate(uneven, 0.9, 6.0, 4, discard=50),
        "still": vi.simulate(TABLE, 0.94, 37.0, 0),
        "branch": vi.branch(motion, "clearance", (15, 45)),
        "zone": vi.zone(FIGURE6, vi.Pattern("RL"), (0.8, 1.2), (2, 200)),
        "atlas": vi.atlas(FIGURE6, (1.0, 1.1), (20, 60), max_impacts=2, survey=12),
    }


class Attractors(dict):
    """Results of the studies of attractors, each computed when it is first asked for."""

    made: ClassVar = {
        "lyapunov": lambda: vi.lyapunov(FIGURE6, 1.04, [25.0, 30.0], cycles=100, discard=50),
        "one": lambda: vi.lyapunov(FIGURE6, 1.04, 25.0, cycles=100, discard=50),
        "basins": lambda: vi.basins(TABLE, 0.94, 37.0, (("x", -30, 30, 6), ("x_dot", -30, 30, 5))),
        "states": lambda: vi.basins(TABLE, 0.94, 37.0, states=9),
        "bifurcation": lambda: vi.bifurcation_diagram(FIGURE6, "clearance", [20, 30, 40], r=1.04),
        "response": lambda: vi.response(FIGURE6, [1.0, 1.02], clearance=25.0, states=3),
    }

    def __missing__(self, name):
        """The result of this name of `STUDIES_NAMED`."""
        self[name] = self.made[name]() if name in self.made else example(name)
        return self[name]


@pytest.fixture(scope="session")
def attractors():
    """Results of the studies of attractors, which contain motions, exponents and states."""
    return Attractors()


@pytest.fixture
def short():
    """Designs by few steps and few runs."""
    with short_searches():
        yield
