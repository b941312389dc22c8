"""Start and end of the programs: Ctrl-C at the start, arguments, a full disk, folders."""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys

import pytest
from programs import PAIR, ROOT, SYSTEM, Runner, contents, find_command, write
from vibroimpact.commands import command

POINT = ["--xi", ".0114", "--mu", ".028", "--restitution", ".75", "--r", "1.04", "--clearance", "9"]
FULL = pytest.mark.skipif(
    not os.path.exists("/dev/full"), reason="needs a device that is always full"
)
#: Interrupts the program where it begins to import a module.
STOP = """
import os, signal, sys

class Stop:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Stop())
"""


@pytest.mark.parametrize("name", [
    "vibroimpact", "numpy", "numpy.linalg", "vibroimpact._core", "vibroimpact.results.tables",
    "vibroimpact.commands.command", "argparse", "vibroimpact.commands.lyapunov", "vibroimpact.commands.cases",
])  # fmt: skip
def test_interrupt_at_the_start(name, tool):
    """An interrupt while modules are imported or the command line is read gives one line and status 1."""
    (tool.cwd / "early").mkdir()
    write(tool.cwd / "early/sitecustomize.py", STOP.format(name=name))
    done = tool(
        "lyapunov", *POINT, "--cycles", "80",
        env={**os.environ, "PYTHONPATH": str(tool.cwd / "early")},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    assert done.faults == ["vibroimpact: interrupted; nothing was finished"]
    assert (done.status, done.out) == (1, b"")
    assert not (tool.cwd / "results").exists()


@pytest.mark.parametrize(("words", "status", "output"), [
    ("basins --plane y -1e0 1e0 3 x -1.E+0 +1 3", 0, ""),
    ("lyapunov --cycles 80 --state -1e-3 6 -.5e-1 9", 0, ""),
    ("lyapunov --cycles 80 --state -inf 0 0 0", 2,
     "--state -inf 0 0 0: must have -1e100 <= X <= 1e100"),
    ("lyapunov --cycles 80 --state 0 -NaN 0 0", 2,
     "--state 0 -NaN 0 0: must have -1e100 <= X_DOT <= 1e100"),
    ("lyapunov --cycles -1e3", 2, "--cycles -1e3: must be a whole number; see `vibroimpact lyapunov --help`"),
    ("lyapunov --cycles 2.5", 2, "--cycles 2.5: must be a whole number; see `vibroimpact lyapunov --help`"),
    ("lyapunov --mu 1,5", 2, "--mu 1,5: must be a number; see `vibroimpact lyapunov --help`"),
    ("lyapunov --cycles 80 -1e", 2, "unrecognized arguments: -1e; see `vibroimpact lyapunov --help`"),
])  # fmt: skip
def test_numbers(words, status, output, tool):
    """Negative numbers in any notation are values of options; an error names option, value and allowed values."""
    name, *others = words.split()
    done = tool(name, *POINT, *others)
    assert done.status == status
    assert done.faults[-1:] == [f"vibroimpact {name}: {output}"] * bool(output)


@pytest.mark.parametrize(("words", "name", "output"), [
    ("find --max-impacts 2.5", "find", "--max-impacts 2.5: must be a whole number"),
    ("zone --plot gif", "zone", "argument --plot: invalid choice: 'gif'"),
    ("zone --nothing", "zone", "unrecognized arguments: --nothing"),
    ("nothing", "", "argument COMMAND: invalid choice: 'nothing'"),
])  # fmt: skip
def test_faults_of_words_in_json(words, name, output, tool):
    """With --json an invalid argument gives one document, and one line on standard error."""
    done = tool(*words.split(), "--json")
    document = json.loads(done.out)
    assert (done.status, document["status"], document["command"]) == (2, 2, name)
    assert document["faults"] == done.faults
    assert len(done.faults) == 1
    assert output in done.faults[0]


def test_launcher_of_the_program_imports_no_package(binary, tmp_path):
    """The launcher, as in a wheel, starts the program even if the package cannot be imported."""
    (tmp_path / "vibroimpact/_bin").mkdir(parents=True)
    write(tmp_path / "vibroimpact/__init__.py", "raise ImportError")
    (tmp_path / "vibroimpact/_bin/vibroimpact-batch").symlink_to(binary)
    shutil.copy(ROOT / "python/vibroimpact_start.py", tmp_path)
    write(tmp_path / "launch.py", "from vibroimpact_start import batch; batch()")
    words = ("--version", "no.nml")
    found = [Runner([sys.executable, "launch.py"], tmp_path)(word) for word in words]
    assert found == [Runner([binary], tmp_path)(word) for word in words]
    assert [done.status for done in found] == [0, 2]


@FULL
@pytest.mark.parametrize("words", ["--help", "--version", "case.nml"])
def test_program_on_a_full_disk(words, batch):
    """If standard output is full there is one line and status 1; results are kept."""
    write(batch.cwd / "case.nml", PAIR)
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            [*batch.start, words], stdout=full, stderr=subprocess.PIPE, text=True, cwd=batch.cwd
        )
    assert (done.returncode, done.stderr) == (1, "standard output: No space left on device\n")
    assert (batch.cwd / "results/case.csv").exists() == (words == "case.nml")


@FULL
@pytest.mark.parametrize("buffered", ["", "1"])
@pytest.mark.parametrize("words", ["--help", "--version", "zone --help"])
def test_help_on_a_full_disk(words, buffered, tool):
    """The help of `vibroimpact` on a full disk gives one line and status 1, with or without buffering."""
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            [find_command(), *words.split()], stdout=full, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONUNBUFFERED": buffered},
        )  # fmt: skip
    name = " zone" * words.startswith("zone")
    assert done.stderr == f"vibroimpact{name}: standard output: No space left on device\n"
    assert done.returncode == 1


def test_misspelt_group(batch):
    """A misspelt group is reported, and not the error that it causes in other groups."""
    text = SYSTEM + "&motin kind = 'equispaced', clearance = 3 /\n"
    (fault,) = batch.case(text).faults
    assert fault.startswith("case.nml:2: &motin: is not a group; must be &system, &output, &motion")


@pytest.mark.parametrize(("name", "value"), [("r", "1.04"), ("clearance", "9")])
def test_a_parameter_that_is_swept_has_no_value(name, value, tool):
    """A value for the swept parameter is refused, in the words of the options."""
    done = tool("bifurcation", *POINT, "--parameter", name, "--values", "1", "2", "3")
    output = f"vibroimpact bifurcation: --{name} {value}: must be left out: it "
    assert (done.status, len(done.faults)) == (2, 1)
    assert done.faults[0].startswith(output)


@pytest.mark.parametrize("folder", ["q.txt", "a/b.JSONL", "-"])
def test_what_is_no_folder_is_refused_by_both(folder, batch, tool):
    """A folder is refused if its name looks like a file, or is the dash that elsewhere means standard output."""
    for run, words in ((batch, []), (tool, ["run"])):
        done = run.case(PAIR, "-o", folder) if not words else run(*words, "case.nml", "-o", folder)
        assert (done.status, len(done.faults)) == (2, 1)
        assert f"-o {folder}: must be a folder" in done.faults[0]
        assert done.faults[0].endswith(f"; for a folder of this name, write -o {folder}/")
    assert list(contents(batch.cwd)) == ["case.nml"]
    assert batch("case.nml", "-o", f"{folder}/").status == 0
    assert batch("case.nml", "-o", folder).status == 0  # now the folder exists


@pytest.mark.parametrize("folder", ["case.nml", "case.nml/below"])
def test_a_file_in_place_of_the_folder(folder, batch, tool):
    """A file in place of the folder is reported before the computation, which here would take minutes."""
    long = SYSTEM + "&simulate clearance = 9, cycles = 100000000, x_dot = 6, z_dot = 9 /\n"
    output = f"{folder}: case.nml is a file; must be a folder"
    assert batch.case(long, "-o", folder).faults == [output]
    for form in ("csv", "json"):
        done = tool("run", "case.nml", "--format", form, "-o", folder)
        assert (done.status, done.faults) == (2, [f"vibroimpact run: -o {output}"])


def test_control_characters_are_not_echoed(batch):
    """Messages contain no control characters from a file, neither ASCII nor Latin-1, as bytes or in UTF-8."""
    held = (
        "é\u0085µ\u009b€".encode()
        + bytes(range(1, 10))
        + bytes(range(127, 256))
        + b"\x1b[2J\xe2\x82"
    )
    done = batch.case(held)
    (fault,) = done.faults
    assert fault.startswith("case.nml:1: é??µ??€????????")
    assert "?[2J\udce2?: is outside a group" in fault
    assert all(letter.isprintable() or letter >= "\udca0" for letter in fault)


@pytest.mark.parametrize(("words", "output"), [
    (["find", *POINT, "--max-impacts", "99"],
     "find: --max-impacts 99: must be a whole number with 2 <= --max-impacts <= 12"),
    (["init", "zone", "-o", "no/zone.nml"],
     "init: -o no/zone.nml: there is no folder no; must be in an existing folder"),
    (["lyapunov", *POINT, "--cycles", "39"],
     "lyapunov: --cycles 39: must be a whole number, 2 batches <= cycles <= 1e9; batches is 20"),
])  # fmt: skip
def test_what_is_allowed(words, output, tool):
    """Errors give the allowed values in the words and numbers of the options."""
    assert tool(*words).faults == [f"vibroimpact {output}"]
    assert list(contents(tool.cwd)) == []


def test_ctrl_c_while_the_arguments_are_read(monkeypatch):
    """When argparse is interrupted it raises an error of its own; this still counts as an interrupt."""

    def interrupted(*_):
        try:
            raise KeyboardInterrupt
        finally:
            raise AttributeError("save_nargs")

    monkeypatch.setattr(argparse.ArgumentParser, "parse_intermixed_args", interrupted)
    with pytest.raises(KeyboardInterrupt):
        command.main(["find"])
