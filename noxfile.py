#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox>=2025.2.9"]
# ///
"""Sessions of nox, for those who look for them here: `./run` does the work, in the environment that it makes."""

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


if __name__ == "__main__":
    nox.main()
