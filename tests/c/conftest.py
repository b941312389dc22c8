"""The library for C, installed by `meson install`, and a program that calls it."""

import shutil

import pytest
from installed_library import BUILD, ROOT, Installed, call, tool


@pytest.fixture(scope="session")
def installed(tmp_path_factory):
    """The library, built in the folder of the Fortran tests."""
    if not (BUILD / "build.ninja").exists():
        call(tool("meson"), "setup", BUILD, ROOT, "-Dpython=disabled")
    # several workers may run this at once
    turn = [tool("in-turn")] if shutil.which(tool("in-turn")) else []
    call(*turn, tool("ninja"), "-C", BUILD)
    away = tmp_path_factory.mktemp("installed")
    call(tool("meson"), "install", "-C", BUILD, "--no-rebuild", "--quiet", "--destdir", away)
    (settings,) = away.rglob("vibroimpact.pc")
    (program,) = away.rglob("vibroimpact-batch")
    (header,) = away.rglob("vibroimpact.h")
    prefix = header.parents[1]
    flags = call("pkg-config", f"--define-variable=prefix={prefix}", "--cflags", "--libs", settings)
    return Installed(program, prefix, settings.parents[1], tuple(flags.split()))


@pytest.fixture(scope="session")
def door(installed, tmp_path_factory):
    """The program built from door.c."""
    target = tmp_path_factory.mktemp("door") / "door"
    strict = ["-std=c99", "-D_DEFAULT_SOURCE", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]
    return installed.compile(ROOT / "tests/c/door.c", target, *strict)
