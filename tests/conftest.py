"""An option of all tests."""


def pytest_addoption(parser):
    """A short run."""
    parser.addoption(
        "--once", action="store_true", help="run each test with the first of its parameters alone"
    )


def pytest_collection_modifyitems(config, items):
    """Leave out all but the first of the tests that share a function."""
    if not config.getoption("--once"):
        return
    first = {}
    for item in items:
        first.setdefault((item.path, item.parent.name, getattr(item, "originalname", "")), item)
    kept = set(first.values())
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = [item for item in items if item in kept]
