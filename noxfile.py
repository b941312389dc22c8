#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Sessions of nox, for those who look for them here: `./run` does the work, in the environment that it makes."""

import os

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "none"


@nox.session
def lint(session: nox.Session) -> None:
    """All linters and the type checker."""
    session.run("./run", "lint", external=True)


@nox.session
def test(session: nox.Session) -> None:
    """The tests; words after -- are arguments of `./run test`."""
    session.run("./run", "test", *session.posargs, external=True)


@nox.session(default=False)
def docs(session: nox.Session) -> None:
    """The documentation as HTML."""
    session.run("./run", "docs", external=True)


@nox.session(default=False, venv_backend="venv")
def nightly(session: nox.Session) -> None:
    """The tests with nightly wheels of NumPy and SciPy, from the index that the variable NIGHTLY_INDEX names."""
    index = os.environ.get("NIGHTLY_INDEX", "")
    if not index:
        session.error(
            "NIGHTLY_INDEX: must be the address of an index with nightly wheels of NumPy and SciPy"
        )
    session.install("pip>=25.1", "meson-python>=0.18", "meson>=1.4", "ninja", "scipy-openblas32")
    session.install("--group", "test")
    # the last: no other package may replace them by releases
    session.install("--pre", "--upgrade", "--no-deps", "--index-url", index, "numpy", "scipy")
    session.install("--no-build-isolation", "--no-deps", ".")
    words = session.posargs or ["--once", "-m", "not slow and not browser and not faults"]
    session.run("python", "-W", "default", "-m", "pytest", *words)


if __name__ == "__main__":
    nox.main()
