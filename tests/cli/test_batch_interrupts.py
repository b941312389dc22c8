"""Ctrl-C and SIGTERM in the stand-alone program: finished work is kept, and messages name what is missing."""

import contextlib
import os
import re
import signal
import subprocess
import time

import pytest
from programs import find_command, wait_for, write

SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, 0.61, r = 0.9 /\n"
SHORT = "&simulate clearance = 6, cycles = 10 /\n"
LONG = "&simulate clearance = 5, cycles = 2000000, max_events = 50000000 /\n"

#: A damper in the second of two coupled masses, and the motion on which it settles.
DAMPER = """&structure mass = 1, 1, 0.1, damping = 0.1, -0.05, 0,  -0.05, 0.05, 0,  0, 0, 0
  stiffness = 2, -1, 0,  -1, 1, 0,  0, 0, 0 /
&gap direction = 0, -1, 1, opening = 6, restitution = 0.7 /
&gap direction = 0, 1, -1, opening = 6, restitution = 0.7 /
&load frequency = 0.65, sine = 0, 0.5, 0 /
&simulate cycles = 10 /
&motion kind = 'settled' /
"""


@contextlib.contextmanager
def started(binary, folder, interrupt=signal.SIG_DFL, command=()):
    """The running program, ended on exit. Background processes of shells inherit that SIGINT is ignored."""
    with subprocess.Popen(
        [binary, *command, "case.nml", "-o", "out"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, interrupt),
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_case_is_written_and_marked(number, binary, tmp_path):
    """The case before the interrupted one is complete, the next one is not run, and no partial file is left."""
    write(tmp_path / "case.nml", SYSTEM + SHORT + LONG + SHORT)
    with started(binary, tmp_path) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        process.send_signal(number)
        message, faults = process.communicate(timeout=120)
    assert process.returncode == 1
    assert faults.splitlines()[-1] == "case_3: not run, since the program was interrupted"
    assert "case_2: interrupted: the simulation was stopped after" in faults
    assert "case_1: out/case_1.csv" in message
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names in (["case_1.csv", "case_2.csv"], ["case_1.csv"])  # it may stop before an impact
    if len(names) == 2:
        head = (tmp_path / "out/case_2.csv").read_text().split("\ntime", 1)[0]
        assert "# ! cut short: the simulation was stopped after" in head
        whole = (tmp_path / "out/case_1.csv").read_text()
        assert "cut short" not in whole


@pytest.mark.parametrize(
    ("study", "fault", "kept"),
    [
        ("zone x = 'frequency', x_low = 0.3, x_high = 3.2, y = 'load', y_low = 0.1, y_high = 9, lines = 129",
         "the computation was stopped before all boundaries were followed", 1),
        ("branch parameter = 'frequency', low = 0.3, high = 3.2, longest_step = 1e-5, max_points = 100000",
         r"frequency from [\d.]+ to [\d.]+ was reached", 2),
    ],
)  # fmt: skip
def test_studies_of_structures_are_interrupted(study, fault, kept, binary, tmp_path):
    """A branch keeps its points so far; a partial zone is not kept."""
    write(tmp_path / "case.nml", f"{DAMPER}&{study} /\n")
    with started(binary, tmp_path) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        time.sleep(0.2)
        begin = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, faults = process.communicate(timeout=60)
    assert time.monotonic() - begin < 20
    assert process.returncode == 1
    assert re.search(f"case_2: interrupted: {fault}", faults)
    assert len([*(tmp_path / "out").iterdir()]) == kept


def test_the_command_keeps_what_the_program_keeps(tmp_path):
    """`vibroimpact run` writes and marks the case that Ctrl-C stops, and says so like the compiled program."""
    states = "&basins clearance = 5, states = 100000 /\n"
    write(tmp_path / "case.nml", SYSTEM + SHORT + states + SHORT)
    with started(find_command(), tmp_path, command=["run"]) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        message, faults = process.communicate(timeout=120)
    assert process.returncode == 1
    assert re.search(r"(?m)^case_2: interrupted: \d+ of 100000 states were reached", faults)
    assert "case_3: not run, since the program was interrupted" in faults
    kept = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert faults.splitlines()[-1] == (
        "vibroimpact run: interrupted; finished results are kept: "
        + ", ".join(f"out/{name}" for name in kept)
    )
    # on a slow machine it may stop before a state is reached
    none = "case_2: interrupted: 0 of 100000 states were reached" in faults
    assert kept == ["case_1.csv", "case_2.csv"][: 1 if none else 2]
    if not none:
        assert "case_2: out/case_2.csv" in message
        with open(tmp_path / "out/case_2.csv", encoding="utf-8") as lines:
            assert any(line.startswith("# ! cut short: ") for line in lines)


def test_a_second_interrupt_ends_the_program_at_once(binary, tmp_path):
    write(tmp_path / "case.nml", SYSTEM + SHORT + LONG)
    with started(binary, tmp_path) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        process.send_signal(signal.SIGTERM)
        process.send_signal(signal.SIGINT)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode in (-signal.SIGINT, -signal.SIGTERM, 1)
    assert {path.suffix for path in (tmp_path / "out").iterdir()} == {".csv"}


@pytest.mark.parametrize(
    "numbers", [(signal.SIGINT,), (signal.SIGTERM,), (signal.SIGTERM, signal.SIGINT) * 3]
)
def test_an_interrupt_removes_the_file_that_is_written(numbers, binary, tmp_path):
    """Signals while a table is written end the program at once; the temporary file is removed."""
    write(tmp_path / "case.nml", SYSTEM + LONG.replace("2000000,", "300000,") + SHORT)
    names = []
    for _ in range(2):
        with started(binary, tmp_path) as process:
            wait_for(lambda: [*tmp_path.glob("out/case_1*.part")])
            names += [path.name for path in tmp_path.glob("out/case_1*.part")]
            for number in numbers:
                process.send_signal(number)
            begin = time.monotonic()
            output, faults = process.communicate(timeout=60)
        assert time.monotonic() - begin < 5
        assert [*(tmp_path / "out").iterdir()] == []
        # the last of several signals can arrive after the file has been removed, and then ends the program
        if len(numbers) == 1 or process.returncode == 1:
            assert (process.returncode, output) == (1, "")
            assert faults.splitlines() == [
                "case_1: interrupted; its file was not written",
                "case_2: not run, since the program was interrupted",
            ]
    assert len({*names}) == 2
    assert all(re.fullmatch(r"case_1\.csv\.[0-9A-F]{16}\.part", name) for name in names)


@pytest.mark.parametrize("command", [(), ("run",)])
def test_a_second_interrupt_gives_up_the_finished_part(command, binary, tmp_path):
    """The first signal stops the simulation and writes the events so far; the second one stops the writing."""
    write(tmp_path / "case.nml", SYSTEM + SHORT + LONG.replace("2000000,", "10000000,"))
    program = find_command() if command else binary
    first = signal.SIGINT if command else signal.SIGTERM
    with started(program, tmp_path, command=command) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        time.sleep(0.3)
        process.send_signal(first)
        wait_for(lambda: [*tmp_path.glob("out/case_2*.part")])
        process.send_signal(signal.SIGINT)
        _, faults = process.communicate(timeout=60)
    kept = "vibroimpact run: interrupted; finished results are kept: out/case_1.csv\n"
    wanted = kept if command else "case_2: interrupted; its file was not written\n"
    assert (process.returncode, faults) == (1, wanted)
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["case_1.csv"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_the_reading_of_a_pipe(number, binary, tmp_path):
    """While a pipe is read nothing has been computed yet, and the signal ends the program at once by default."""
    os.mkfifo(tmp_path / "case.nml")
    # the open succeeds as soon as the program opens the pipe too
    with started(binary, tmp_path) as process, open(tmp_path / "case.nml", "wb") as pipe:
        pipe.write(b"&system")
        pipe.flush()
        process.send_signal(number)
        _, faults = process.communicate(timeout=20)
    assert (process.returncode, faults) == (-number, "")


def test_an_interrupt_of_the_command_ends_the_reading_of_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "case.nml")
    with (
        started(find_command(), tmp_path, command=("run",)) as process,
        open(tmp_path / "case.nml", "wb") as pipe,
    ):
        pipe.write(b"&system")
        pipe.flush()
        time.sleep(0.3)  # until the pipe is read
        process.send_signal(signal.SIGINT)
        _, faults = process.communicate(timeout=20)
    assert (process.returncode, faults) == (
        1,
        "vibroimpact run: interrupted; nothing was finished\n",
    )


def test_a_signal_that_the_caller_ignores_stays_ignored(binary, tmp_path):
    """A signal that the caller ignores, as with nohup or in the background of a script, stays ignored."""
    write(tmp_path / "case.nml", SYSTEM + SHORT + LONG.replace("2000000,", "30000,"))
    with started(binary, tmp_path, signal.SIG_IGN) as process:
        wait_for(lambda: (tmp_path / "out/case_1.csv").exists())
        process.send_signal(signal.SIGINT)
        _, faults = process.communicate(timeout=60)
    assert (process.returncode, faults) == (0, "")
    assert "cut short" not in (tmp_path / "out/case_2.csv").read_text()
