"""Ctrl-C keeps what is finished, and the message names it correctly."""

import contextlib
import itertools
import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import pytest
import vibroimpact as vi
from programs import EAGER, find_command, write
from vibroimpact.base.progress import Progress
from vibroimpact.commands.command import main

EQUAL = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
SHORT = "&lyapunov clearance = 9, cycles = 50, x_dot = 6, z_dot = 9 /\n"
#: A simulation of discarded cycles, of which no part is kept.
LONG = (
    "&simulate clearance = 9, discard = 100000000, cycles = 1, x_dot = 6, z_dot = 9, "
    "max_events = 50000000 /\n"
)


def interrupted(cwd, words, until, later=0.0):
    """Status and errors of the program, interrupted when a file (a pattern) exists, or some seconds later."""
    with subprocess.Popen(
        [find_command(), *words],
        cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:  # fmt: skip
        for _ in range(600):
            if [*cwd.glob(until)] or process.poll() is not None:
                break
            time.sleep(0.05)
        time.sleep(later)
        process.send_signal(signal.SIGINT)
        _, output = process.communicate(timeout=60)
    return process.returncode, output.splitlines()


@pytest.mark.parametrize("form", ["csv", "json"])
def test_whole_cases_are_named(form, tmp_path):
    """After the first of two cases, the message names its file and no other."""
    write(tmp_path / "case.nml", EQUAL + SHORT + LONG)
    words = ["run", "case.nml", "-o", "out", "--format", form]
    # interrupt the second case: when the first file appears it may not be recorded yet
    status, faults = interrupted(tmp_path, words, f"out/case_1.{form}", later=1.0)
    kept = f"finished results are kept: out/case_1.{form}"
    assert (status, faults[-1]) == (1, f"vibroimpact run: interrupted; {kept}")
    assert all(line.startswith("case_2: interrupted") for line in faults[:-1])
    assert [path.name for path in (tmp_path / "out").iterdir()] == [f"case_1.{form}"]


@pytest.mark.parametrize("form", ["csv", "json"])
def test_folders_that_stay_empty_go_again(form, tmp_path):
    """Folders that stay empty are removed, including those made by the compiled program."""
    write(tmp_path / "case.nml", EQUAL + LONG)
    words = ["run", "case.nml", "-o", "out/sub", "--format", form]
    status, faults = interrupted(tmp_path, words, "out/sub")
    assert (status, faults[-1]) == (1, "vibroimpact run: interrupted; nothing was finished")
    assert all(line.startswith("case: interrupted") for line in faults[:-1])
    assert [path.name for path in tmp_path.iterdir()] == ["case.nml"]


def test_no_file_is_left_half_written(tmp_path):
    """Ctrl-C while the compiled program writes a table: the temporary file is removed before the command ends."""
    table = "&simulate clearance = 5, cycles = 300000, max_events = 50000000 /\n"
    write(tmp_path / "case.nml", EQUAL + table)
    status, faults = interrupted(tmp_path, ["run", "case.nml", "-o", "out"], "out/case.csv.*.part")
    gone = "case: interrupted; its file was not written"
    assert (status, faults) == (1, [gone, "vibroimpact run: interrupted; nothing was finished"])
    assert [path.name for path in tmp_path.iterdir()] == ["case.nml"]


@pytest.mark.parametrize("form", ["csv", "json"])
@pytest.mark.parametrize("name", ["run", "simulate"])
def test_nothing_is_called_nothing(name, form, tmp_path, monkeypatch, capsys):
    """If nothing is finished the message says so, even if an earlier run left a result of this name."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "case.nml", EQUAL + LONG)
    (tmp_path / "results").mkdir()
    write(tmp_path / "results/case.csv", "old")

    def stop(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("vibroimpact.commands.cases.run_namelists", stop)
    monkeypatch.setattr("vibroimpact.results.door.run_text", stop)
    assert main([name, "case.nml", "--format", form]) == 1
    assert capsys.readouterr().err == f"vibroimpact {name}: interrupted; nothing was finished\n"
    assert (tmp_path / "results/case.csv").read_text() == "old"


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no /proc")
def test_processes_that_just_start_are_not_interrupted(tmp_path):
    """Starting workers of `reproduce` ignore the Ctrl-C of a terminal; one line is printed."""
    pytest.importorskip("matplotlib")
    with subprocess.Popen(
        [find_command(), "reproduce", "figure4a", "figure4b", "-o", "out"],
        cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:  # fmt: skip
        while process.poll() is None and not (masks := masks_of_workers(process.pid)):
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGINT)
        _, output = process.communicate(timeout=60)
    assert all(mask & 1 << (signal.SIGINT - 1) for mask in masks)
    assert process.returncode == 1
    assert output.startswith("vibroimpact reproduce: interrupted; ")
    assert output.count("\n") == 1


def masks_of_workers(parent):
    """The signals that each process started by `spawn` blocks or ignores."""
    masks = []
    for number in pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split():
        with contextlib.suppress(OSError):
            child = pathlib.Path(f"/proc/{number}")
            if "spawn_main" in (child / "cmdline").read_text():
                output = (child / "status").read_text()
                blocked, ignored = re.findall(r"Sig(?:Blk|Ign):\s*(\w+)", output)
                masks.append(int(blocked, 16) | int(ignored, 16))
    return masks


@pytest.mark.parametrize(("words", "left"), [
    (["find", "--xi", ".1", "--mu", ".1", "--restitution", ".5", "--r", ".9", "--clearance", "9"],
     "; nothing was finished"),
    (["find", "case.nml", "--max-impacts", "2"], "; finished results were printed"),
])  # fmt: skip
def test_what_is_told_is_not_lost(words, left, tmp_path, monkeypatch, capsys):
    """The message of an interrupted command says whether results were printed."""
    monkeypatch.chdir(tmp_path)
    pair = "&motion kind = 'equispaced', clearance = {} /\n"
    write(tmp_path / "case.nml", EQUAL + pair.format(20) + pair.format(21))
    ours, calls = vi.find, []

    def find(*arguments, **options):
        if calls or words[1] != "case.nml":
            raise KeyboardInterrupt
        calls.append(1)
        return ours(*arguments, **options)

    monkeypatch.setattr("vibroimpact.commands.find.find", find)
    assert main(words) == 1
    assert capsys.readouterr().err == f"vibroimpact {words[0]}: interrupted{left}\n"


def test_reproduction_names_what_it_has_written(tmp_path, monkeypatch, capsys):
    """The message names only files written in this run."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()
    write(tmp_path / "results/figure3.svg", "old")

    def stop(names, folder):
        write(folder / "figure4a.svg", "new")
        raise KeyboardInterrupt

    monkeypatch.setattr("vibroimpact.commands.reproduce.reproduce", stop)
    assert main(["reproduce"]) == 1
    kept = "finished results are kept: results/figure4a.svg"
    assert capsys.readouterr().err == f"vibroimpact reproduce: interrupted; {kept}\n"


def test_bar_never_falls_back(monkeypatch, capsys):
    """If the work grows, the bar keeps its length and the time left is updated; at the end it is erased."""
    monkeypatch.setattr("vibroimpact.base.progress.PATIENCE", 0.0)
    monkeypatch.setattr("vibroimpact.base.progress.INTERVAL", 0.0)
    clock = iter([100.0, 110.0, 120.0, 140.0, 160.0])
    monkeypatch.setattr("vibroimpact.base.progress.time.monotonic", lambda: next(clock))
    with Progress("work", wanted=True) as bar:
        for share in (0.5, 0.2, 0.4, 0.75):
            bar.show(share)
    *drawn, wiped, end = capsys.readouterr().err.split("\r")[1:]
    assert [line.count("#") for line in drawn] == [15, 15, 15, 22]
    left = [line.partition("about ")[2].split()[0] for line in drawn]
    assert left == ["10", "80", "60", "20"]
    assert (wiped.strip(), end) == ("", "")


#: A study, one made of several studies, and one that reports its progress to a function of the caller.
CALLS = """
import vibroimpact as vi
osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
vi.zone(osc, "RL", (0.9, 1.1), (10, 40), lines=17)
vi.uncertainty(osc, "RL", (0.9, 1.0), (10, 12), {"xi": (0.01, 0.012)}, samples=3)
vi.zone(osc, "RL", (0.9, 1.1), (10, 40), lines=17, progress=lambda share, task: None)
"""


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no pseudo-terminals on this system")
def test_calls_from_python_show_one_bar(tmp_path):
    """On a terminal a call shows one bar with its name, without bars of inner calls or a progress function."""
    write(tmp_path / "eager.py", EAGER + CALLS)
    ours, theirs = os.openpty()
    with subprocess.Popen([sys.executable, "eager.py"], cwd=tmp_path, stderr=theirs) as process:
        os.close(theirs)
        shown = b""
        with contextlib.suppress(OSError):  # the end of a terminal
            while part := os.read(ours, 4096):
                shown += part
    assert process.returncode == 0
    labels = re.findall(r"\r(\w+) \[", shown.decode())
    assert [key for key, _ in itertools.groupby(labels)] == ["zone", "uncertainty"]
    assert shown.endswith(b" \r")
    done = subprocess.run([sys.executable, "eager.py"], cwd=tmp_path, capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")
