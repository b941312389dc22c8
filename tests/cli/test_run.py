"""The script `run` of a clone: its output before it installs or builds anything."""

import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

RUN = Path(__file__).parents[2] / "run"
ALL = "run: the Fortran tests, then all Python tests"
ONCE = "run: the Fortran tests, then each Python test once; ./run test --all runs the long ones and all parameters"
SELECTED = "run: the selected Python tests alone; without a selection the Fortran tests, too"


def say(*words):
    done = subprocess.run([RUN, *words], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def clone(tmp_path):
    """A clone whose compilers, build tools and Python only record their calls."""
    root, tools = tmp_path / "clone", tmp_path / "tools"
    for folder in (root / "src", root / "src/deep", root / "python", root / "tests", tools):
        folder.mkdir(parents=True, exist_ok=True)
    for name in (
        "pyproject.toml", "meson.build", "src/meson.build", "src/deep/meson.build",
        "python/vibroimpact_start.py", "tests/test_one.py",
    ):  # fmt: skip
        (root / name).touch()
    shutil.copy(RUN, root / "run")
    calls = tmp_path / "calls"
    note = f'#!/bin/sh\necho "${{0##*/}} $*" >>"{calls}"\n[ "$1 $2" != "-m pytest" ] || exit 5\n'
    places = [tools / name for name in ("gfortran", "cc", "python3", "meson")]
    venv = root / ".venv"
    (venv / "bin").mkdir(parents=True)
    (venv / "made-in").write_text(f"{root}\n")
    for place in (*places, venv / "bin/python"):
        place.write_text(note)
        place.chmod(0o755)

    def test(*words):
        environ = os.environ | {"PATH": f"{tools}:{os.environ['PATH']}"}
        done = subprocess.run(
            [root / "run", "test", *words], env=environ, capture_output=True, text=True, check=False
        )
        made = calls.read_text().splitlines()
        return (
            done.returncode,
            done.stderr.splitlines()[0],
            [line for line in made if line.startswith("meson test") or "-m pytest" in line],
        )

    return test


@pytest.mark.parametrize("words", [[], ["-h"], ["help"], ["bench", "--help"], ["test", "-h"]])
def test_help(words):
    """The help lists every command, and runs none."""
    status, out, err = say(*words)
    assert (status, err) == (0, "")
    for command in ("reproduce", "test", "bench", "mutate", "coverage", "docs", "lint", "wheel"):
        assert f"\n  ./run {command} " in out


@pytest.mark.parametrize(("words", "output"), [
    (["bench", "all"], "run: bench takes no arguments, not 'all'; see ./run --help"),
    (["lint", "python"], "run: lint takes no arguments, not 'python'; see ./run --help"),
    (["wheel", "all"], "run: wheel takes no arguments, not 'all'; see ./run --help"),
    (["tests"], "run: no command 'tests'"),
])  # fmt: skip
def test_bad_words(words, output):
    status, out, err = say(*words)
    assert (status, out, err.splitlines()[-1]) == (2, "", output)


@pytest.mark.parametrize("words", [
    ["-k", "zone"], ["-kzone"], ["-m", "not slow"], ["--lf"], ["tests/test_one.py"],
    ["-q", "tests/test_one.py::test_a[b]", "-x"], ["-m", "faults", "--instants", "200"],
])  # fmt: skip
def test_a_selection_is_run_alone(clone, words):
    """The selection is printed before anything is built, and the status is that of pytest."""
    assert clone(*words) == (5, SELECTED, [f"python -m pytest {' '.join(words)}"])


@pytest.mark.parametrize("words", [["--all"], ["-n", "2", "--all"], ["--all", "-x", "-q"]])
def test_all_tests(clone, words):
    """The Fortran tests run first; their failure does not stop the Python tests."""
    status, output, calls = clone(*words)
    assert (status, output) == (1, ALL)
    kept = [word for word in words if word != "--all"]
    assert [call.split(" -C")[0] for call in calls] == [
        "meson test", " ".join(["python -m pytest", *kept])
    ]  # fmt: skip


@pytest.mark.parametrize("words", [[], ["-x", "-q"]])
def test_each_test_once(clone, words):
    """Without --all and a selection, long tests and further parameters are left out."""
    status, output, (fortran, python) = clone(*words)
    assert (status, output) == (1, ONCE)
    assert fortran.startswith("meson test")
    assert python.startswith("python -m pytest -n auto --dist loadfile")
    assert " ".join(["--once -m not slow and not browser and not faults", *words]) in python


@pytest.mark.parametrize("fault", [None, "meson", "pytest"])
def test_the_fast_lane(fault, tmp_path):
    """`fast` continues after a failure, names the tests it skips, and has status 0 only if nothing failed."""
    for folder in (".ci", "build/fortran", ".venv/bin"):
        (tmp_path / folder).mkdir(parents=True)
    shutil.copy(RUN.parent / ".ci/run", tmp_path / ".ci/run")
    (tmp_path / "build/fortran/build.ninja").touch()
    for name in ("run", ".venv/bin/python", ".venv/bin/meson", ".venv/bin/git"):
        script = tmp_path / name
        # git finds no changes
        script.write_text(
            f'#!/bin/sh\necho "${{0##*/}} $*"\n[ "${{0##*/}}" != git ] || exit 1\n'
            f'case "${{0##*/}} $*" in *{fault}*) exit 1 ;; esac\n'
        )
        script.chmod(0o755)
    done = subprocess.run(
        [tmp_path / ".ci/run", "fast"], capture_output=True, text=True, check=False
    )
    ends = [line[6:].split(":") for line in done.stdout.splitlines() if ": " in line[:60]]
    steps = [name for name, _ in ends if not name.startswith("out")]
    failing = {
        "meson": "Fortran tests",
        "pytest": "Python tests that are neither slow nor in a browser",
    }
    assert steps[:4] == [
        "lint",
        "traces of a machine",
        "types of _core, tables of keys",
        "Fortran tests",
    ]
    assert done.returncode == (fault is not None)
    assert "\nLeft out: " in done.stdout
    assert "not slow and not browser" in done.stdout
    assert "run lint" in done.stdout
    if fault:
        assert f"===== {failing[fault]}: FAILED" in done.stdout
        assert done.stdout.splitlines()[-1].endswith(f"{failing[fault]}.")


def test_the_pythons_of_a_wheel(tmp_path):
    """The Python of .venv first, then one of each other supported version; broken links are left out."""
    own = ".".join(map(str, sys.version_info[:2]))
    pyproject = (RUN.parent / "pyproject.toml").read_text(encoding="utf-8")
    versions = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', pyproject)
    assert own in versions
    (found,) = re.findall(
        r"^pythons\(\) \{.*?^\}", RUN.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    others = [version for version in versions if version != own]
    answers = {others[0]: "exit 0", others[-1]: "exit 1"}
    for version, answer in answers.items():
        script = tmp_path / f"python{version}"
        script.write_text(f"#!/bin/sh\n{answer}\n")
        script.chmod(0o755)
    names = {}
    for words in ("", "--one"):
        script = f"root={RUN.parent} venv={sys.prefix}\n{found}\npythons {words}"
        environ = {
            "PATH": f"{tmp_path}:/usr/bin:/bin",
            "PYENV_ROOT": str(tmp_path),
            "HOME": str(tmp_path),
        }
        names[words] = subprocess.check_output(
            ["sh", "-c", script], env=environ, text=True
        ).splitlines()
    assert names["--one"] == [f"{sys.prefix}/bin/python"]
    assert names[""][:2] == [*names["--one"], f"python{others[0]}"]
    assert f"python{others[-1]}" not in names[""]


class Session:
    """The commands that a session of nox would run."""

    def __init__(self, posargs=()):
        self.posargs, self.calls = list(posargs), []

    def install(self, *words):
        self.calls.append(("install", *words))

    def run(self, *words, **_options):
        self.calls.append(("run", *words))

    def error(self, message):
        raise ValueError(message)


def test_the_nightly_session(monkeypatch):
    """Nightly wheels are installed last, from their index alone; without an index the session ends at once."""
    nox = SimpleNamespace(
        session=lambda function=None, **_options: function or (lambda given: given),
        options=SimpleNamespace(), needs_version="", Session=Session, main=None,
    )  # fmt: skip
    monkeypatch.setitem(sys.modules, "nox", nox)
    nightly = runpy.run_path(str(RUN.with_name("noxfile.py")))["nightly"]
    monkeypatch.delenv("NIGHTLY_INDEX", raising=False)
    with pytest.raises(ValueError, match="NIGHTLY_INDEX: must be the address"):
        nightly(Session())
    monkeypatch.setenv("NIGHTLY_INDEX", "file:///wheels")
    session = Session(["tests/python/test_table1.py"])
    nightly(session)
    *_, wheels, package, test = session.calls
    assert wheels[-3:] == ("file:///wheels", "numpy", "scipy")
    assert {"--pre", "--index-url"} < {*wheels}
    assert "--no-deps" in package
    assert test[-1] == "tests/python/test_table1.py"
