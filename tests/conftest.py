"""An option of all tests, and what makes a run of all of them shorter."""

import os

import vibroimpact  # noqa: F401

# Importing the editable package has just built what changed: the processes that tests start skip that.
os.environ["VIBROIMPACT_BUILT"] = "1"

#: Files of tests that take longest, in that order: started first where several files run at a time,
#: none of them is left for the end, when other processors have nothing to do.
LONGEST = (
    "test_audit.py", "test_reproduce.py", "test_commands.py", "test_explorer_trouble.py", "test_explorer_looks.py",
    "test_explorer_page.py", "test_batch_studies.py", "test_batch_command_line.py", "test_branch_crossings.py",
    "test_commands_attractors.py", "test_laws.py", "test_batch_attractors.py", "test_zone_rest.py",
)  # fmt: skip


def pytest_addoption(parser):
    """A short run."""
    parser.addoption(
        "--once",
        action="store_true",
        help="run each test with the first of its parameters alone, and with few random examples",
    )


def pytest_configure(config):
    """Limit the random examples before files of tests ask for theirs."""
    if config.getoption("--once"):
        os.environ["VIBROIMPACT_EXAMPLES"] = "25"


def pytest_collection_modifyitems(config, items):
    """Order the files, and leave out all but the first of the tests that share a function."""
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
