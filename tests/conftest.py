"""Options of all tests, and the order of tests that shortens a full run."""

import os
import random

import pytest

# Several processes share the processors: a thread that waits for others must not occupy one meanwhile.
# OpenMP reads this when it is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import vibroimpact  # noqa: F401

# Importing the editable package has just built all changes: processes started by tests skip the build.
os.environ["VIBROIMPACT_BUILT"] = "1"

#: Test files by decreasing duration: started first where several files run in parallel,
#: none of them runs last while other processors are idle.
LONGEST = (
    "test_audit.py", "test_campaign.py", "test_faults.py", "test_identify.py", "test_identify_laws.py",
    "test_structure_branch.py", "test_structure_motion.py", "test_reproduce.py", "test_commands.py",
    "test_explorer_trouble.py", "test_explorer_looks.py", "test_explorer_page.py", "test_batch_studies.py",
    "test_batch_command_line.py", "test_branch_crossings.py", "test_commands_attractors.py", "test_laws.py",
    "test_batch_attractors.py", "test_zone_rest.py",
)  # fmt: skip


def pytest_addoption(parser):
    """Add the options for a short run."""
    parser.addoption(
        "--once",
        action="store_true",
        help="run each test with the first of its parameters alone, and with few random examples",
    )
    parser.addoption(
        "--share", type=float, default=1.0, metavar="X",
        help="share of the random systems that slow tests try, from 0.1 to 1 (1)",
    )  # fmt: skip
    group = parser.getgroup("faults", "programs that are stopped at random instants")
    group.addoption("--instants", type=int, default=8, help="instants for each program (8)")
    group.addoption("--seed", type=int, default=random.randrange(10**6), help="their seed (random)")


@pytest.fixture(scope="session")
def share(request):
    """How many random systems to try, of so many."""
    asked = request.config.getoption("--share")
    return lambda systems: round(asked * systems)


def pytest_configure(config):
    """Limit the number of random examples, before test files read it."""
    if not 0.1 <= config.getoption("--share") <= 1:
        raise pytest.UsageError(
            f"--share {config.getoption('--share')}: must be a number from 0.1 to 1"
        )
    if config.getoption("--once"):
        os.environ["VIBROIMPACT_EXAMPLES"] = "10"


def pytest_collection_modifyitems(config, items):
    """Order the files, and with --once keep only the first case of each test function."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        order = {name: place for place, name in enumerate(LONGEST)}
        items.sort(key=lambda item: order.get(item.path.name, len(order)))
    if not config.getoption("--once"):
        return
    first = {}
    for item in items:
        first.setdefault((item.path, item.parent.name, getattr(item, "originalname", "")), item)
    kept = set(first.values())
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = [item for item in items if item in kept]
