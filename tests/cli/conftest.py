"""Fixtures: the stand-alone program, the command, and a runner for each."""

import pytest
from programs import OTHER_BUILD, Runner, find_batch, find_command, find_launcher, find_twin


@pytest.fixture(scope="session")
def binary():
    """Path of the compiled program."""
    return find_batch()


@pytest.fixture
def same_build():
    """Skip where last bits may differ from those of the Python package."""
    if OTHER_BUILD:
        pytest.skip("VIBROIMPACT_BATCH names another build")


@pytest.fixture(scope="session")
def launcher():
    """Path of `vibroimpact-batch` as an installed package puts it on the PATH."""
    path = find_launcher()
    if path is None:
        pytest.skip("vibroimpact-batch is not in the interpreter's folder")
    return path


@pytest.fixture
def batch(tmp_path, binary):
    """Runner of the stand-alone program in a separate folder."""
    return Runner([binary], tmp_path)


@pytest.fixture
def tool(tmp_path):
    """Runner of `vibroimpact` in the same folder."""
    return Runner([find_command()], tmp_path)


@pytest.fixture
def command(tmp_path):
    """Runner of `vibroimpact run` in the same folder."""
    return Runner(find_twin(), tmp_path)
