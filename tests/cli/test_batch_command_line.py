"""The command line: options, help, and that the program needs no Python."""

import os
import shlex
import shutil
import signal
import subprocess
import sys
import time

import pytest
from programs import PAIR, ROOT, Runner, chain, contents, find_command, write

#: Settings of a sanitizer build, which an emptied environment keeps.
SANITIZER = {key: value for key, value in os.environ.items() if key.endswith("SAN_OPTIONS")}
STATUSES = "exit status: 0 done; 1 ran"


@pytest.fixture
def good(batch):
    """A runner in a folder with one good file."""
    write(batch.cwd / "case.nml", PAIR)
    return batch


@pytest.mark.parametrize("arguments", [["--help"], ["-h"], ["case.nml", "--help"]])
def test_help(arguments, good):
    """--help prints usage, example and exit statuses to stdout, does nothing else, and has status 0."""
    done = good(*arguments)
    text = done.out.decode()
    assert (done.status, done.err) == (0, b"")
    assert text.startswith("usage: vibroimpact-batch FILE.nml... [-o DIR]")
    assert "example: " in text
    assert STATUSES in text
    assert max(map(len, text.splitlines())) <= 100
    assert list(contents(good.cwd)) == ["case.nml"]


def test_no_arguments(batch):
    """Without a file the usage goes to stderr, with status 2."""
    done = batch()
    assert (done.status, done.out) == (2, b"")
    assert done.faults[0].startswith("usage: ")
    assert batch("-o", "out").status == 2
    assert not (batch.cwd / "out").exists()


@pytest.mark.parametrize("arguments", [["case.nml", "-o"], ["-o"], ["case.nml", "-o", ""]])
def test_missing_folder(arguments, good):
    """-o without a folder gives one line and status 2, before anything runs."""
    done = good(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert done.faults == ["-o: must be followed by a folder"]
    assert list(contents(good.cwd)) == ["case.nml"]


@pytest.mark.parametrize("option", ["-x", "--output", "-O", "--Help", "-o=x", "--no-such", "-1"])
def test_unknown_option(option, good):
    """An unknown option is named, with the known ones, before anything runs."""
    done = good("case.nml", option)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(f"{option}: is not an option; must be ")
    assert list(contents(good.cwd)) == ["case.nml"]


@pytest.mark.parametrize("order", [
    ["-o", "out", "a.nml", "b.nml"], ["a.nml", "-o", "out", "b.nml"],
    ["a.nml", "b.nml", "-o", "out"]])  # fmt: skip
@pytest.mark.parametrize("program", ["program", "command"])
def test_order_of_arguments(order, program, batch, command):
    """-o may come before, between or after the files, in both programs."""
    run = batch if program == "program" else command
    for name in ("a.nml", "b.nml"):
        write(run.cwd / name, PAIR)
    done = run(*order)
    assert (done.status, done.err) == (0, b"")
    assert sorted(contents(run.cwd / "out")) == ["a.csv", "b.csv"]


def example(text, name):
    """The arguments of the example line of a help text."""
    (line,) = [line for line in text.splitlines() if line.startswith("example: ")]
    words = shlex.split(line.removeprefix("example: "))
    assert words[0] == name
    return words[1:]


def test_example_of_the_program(batch):
    """The example of the help works as written, from the top folder of the project."""
    words = example(batch("--help").out.decode(), "vibroimpact-batch")
    shutil.copytree(ROOT / "inputs", batch.cwd / "inputs")
    done = batch(*words)
    assert (done.status, done.err) == (0, b"")
    assert "table1_unequispaced.csv" in contents(batch.cwd / "results")


# test_help.py tests examples that write files; test_explorer.py tests explore, which runs until it is stopped
@pytest.mark.parametrize("sub", [[], ["doctor"], ["completion"]])
def test_example_of_the_command(sub, tmp_path):
    """The example in the help of each command works as written."""
    run = Runner([find_command()], tmp_path)
    help_text = run(*sub, "--help")
    assert (help_text.status, help_text.err) == (0, b"")
    assert STATUSES in help_text.out.decode()
    done = run(*example(help_text.out.decode(), "vibroimpact"))
    assert (done.status, done.err) == (0, b"")
    assert done.out


@pytest.mark.parametrize("arguments", [[], ["bogus"], ["run"], ["run", "-x"], ["run", ""],
                                       ["run", "case.nml", "-o", ""], ["run", "a\nb.nml"],
                                       ["run", "case.nml", "-o"], ["simulate", "case.nml"],
                                       ["plot", "case.nml", "-o", ""], ["plot", "no.nml"],
                                       ["simulate", "case.nml", "--plot", "gif"],
                                       ["find"], ["find", "--xi", "0.1"], ["find", "no.nml"],
                                       ["find", "case.nml", "--mu", "0.1"]])  # fmt: skip
def test_command_refuses(arguments, tmp_path):
    """Invalid arguments give status 2 and a message, without a traceback or a result."""
    write(tmp_path / "case.nml", PAIR)
    done = Runner([find_command()], tmp_path)(*arguments)
    assert (done.status, done.out) == (2, b"")
    assert done.faults
    assert list(contents(tmp_path)) == ["case.nml"]


def test_launcher_is_the_program(launcher, good, same_build):
    """The installed `vibroimpact-batch` gives the results of the compiled program."""
    done = good("case.nml", "nope.nml", "-o", "out")
    assert Runner([launcher], good.cwd)("case.nml", "nope.nml", "-o", "again") == done
    assert contents(good.cwd / "again") == contents(good.cwd / "out")


@pytest.mark.parametrize("which", ["launcher", "command"])
def test_interrupt_leaves_no_traceback(which, launcher, tmp_path):
    """Ctrl-C ends the installed programs without a Python traceback or a partial file."""
    write(tmp_path / "case.nml", chain(1000))
    call = [launcher] if which == "launcher" else [find_command(), "run"]
    process = subprocess.Popen(
        [*call, "case.nml"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True,
    )  # fmt: skip
    end = time.monotonic() + 30
    while not (tmp_path / "results").exists() and time.monotonic() < end:
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    output = process.communicate(timeout=30)[1].decode()
    assert "Traceback" not in output, output[-300:]


def test_no_python_needed(good):
    """In an empty environment, where no Python can be found, the digits are the same."""
    assert good("case.nml", "-o", "out").status == 0
    empty = {"PATH": "", "PYTHONPATH": "", "PYTHONHOME": "/nonexistent", **SANITIZER}
    done = good("case.nml", "-o", "again", env=empty)
    assert (done.status, done.err) == (0, b"")
    assert contents(good.cwd / "again") == contents(good.cwd / "out")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="ldd is a Linux tool")
def test_no_python_linked(binary):
    """The program is compiled, and links no Python library."""
    with open(binary, "rb") as file:
        assert file.read(4) == b"\x7fELF"
    linked = subprocess.run(["ldd", binary], capture_output=True, text=True, check=True).stdout
    assert "libgfortran" in linked or "libc" in linked
    assert "python" not in linked.lower()


def test_other_locale(good):
    """Digits and messages do not depend on the locale."""
    done = good("case.nml", "nope.nml", "-o", "out")
    for locale in ("C", "de_DE.UTF-8", "xx_YY"):
        env = {"LC_ALL": locale, "LANG": locale, "PATH": "", **SANITIZER}
        assert good("case.nml", "nope.nml", "-o", locale, env=env) == done
        assert contents(good.cwd / locale) == contents(good.cwd / "out")


def test_reader_that_stops_early(good):
    """A closed standard output does not keep results from being written."""
    done = subprocess.run(
        [*good.start, "case.nml"], cwd=good.cwd, stdout=subprocess.DEVNULL, close_fds=True
    )
    assert done.returncode == 0
    assert list(contents(good.cwd / "results")) == ["case.csv"]
