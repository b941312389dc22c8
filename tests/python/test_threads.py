"""Namelist files read and run by eight threads give the results of one thread; numbers of threads."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import vibroimpact as vi
from shared_threads import THREADS, together

FILES = sorted((Path(__file__).parents[2] / "inputs").glob("*.nml"))
ROUNDS = 25
#: Kinds of cases that take seconds.
LONG = {"atlas", "basins", "chart", "zone", "design", "identify"}
WRONG = """
&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /
&motion sides = 'RL', phases_over_pi = 0, 1.37, clearance = 37 /
"""


def answer(path):
    """The cases of a file, or the message with which it is refused."""
    try:
        return vi.read_namelist(path)
    except vi.errors.ParameterError as error:
        return str(error)


def run(paths, folder):
    """The messages about the files, and the bytes of the results."""
    log = vi.run_namelists(paths, folder)
    output = [(fault, line.replace(str(folder), "FOLDER")) for fault, line in log.lines]
    return output, log.status, {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture
def files(tmp_path):
    """All inputs, a file that is refused, and a missing file."""
    wrong = tmp_path / "wrong.nml"
    wrong.write_text(WRONG)
    return [*FILES, wrong, tmp_path / "missing.nml"]


@pytest.mark.slow
def test_reading(files):
    """Each thread starts with a different file; several threads read every file at the same time."""
    alone = [answer(path) for path in files]
    assert "must be left out" in alone[-2]
    assert "No such file" in alone[-1]

    def read(i):
        order = [(i * len(files) // THREADS + j) % len(files) for j in range(ROUNDS * len(files))]
        return [(files[j].name, got) for j in order if (got := answer(files[j])) != alone[j]]

    different = [item for found in together(read) for item in found]
    assert not different, f"{len(different)} answers differ, such as {different[0]}"


def test_reading_one_file(files):
    """All threads can read one file at the same time."""
    alone = answer(files[0])
    found = together(lambda i: [answer(files[0]) for _ in range(5 * ROUNDS)])
    assert all(got == alone for each in found for got in each)


@pytest.mark.slow
def test_running(tmp_path):
    """Threads that write into separate folders get the messages and files of one thread."""
    short = [
        path for path in FILES
        if "&sweep" not in path.read_text() and not {case.kind for case in vi.read_namelist(path)} & LONG
    ]  # fmt: skip
    assert len(short) > len(FILES) / 2
    alone = run(short, tmp_path / "alone")
    assert alone[1] == 0

    for i, found in enumerate(together(lambda i: run(short, tmp_path / str(i)))):
        assert found == alone, i


def test_running_into_one_folder(tmp_path):
    """Threads that write the same result replace it completely, and none of them is refused."""
    paths = [Path(__file__).parents[2] / "inputs/table1.nml"]
    alone = run(paths, tmp_path / "alone")
    folder = tmp_path / "all"

    def several(_):
        return [vi.run_namelists(paths, folder) for _ in range(ROUNDS)]

    for log in (log for logs in together(several) for log in logs):
        assert (log.status, len(log.lines)) == (0, len(alone[0])), log.lines
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == alone[2]


@pytest.mark.parametrize("suffix", ["csv", "json"])
def test_saving_one_file(suffix, tmp_path):
    """Threads that save a motion under the same name replace it completely."""
    path = tmp_path / f"motion.{suffix}"
    motion = vi.equispaced(
        vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), r=0.94, clearance=37.0
    )[0]
    motion.save(path)
    alone = path.read_bytes()
    together(lambda _: [motion.save(path) for _ in range(ROUNDS)])
    assert [item.name for item in tmp_path.iterdir()] == [path.name]
    assert path.read_bytes() == alone


#: Counts the threads of the process after a case computed by one thread, and one computed by four.
COUNT = """
import os, sys
import vibroimpact as vi
osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
calls = {
    "chart": lambda n: vi.chart(osc, vi.Pattern("RL"), [1.0, 1.1], [20.0, 30.0], threads=n),
    "response": lambda n: vi.response(osc, [1.0, 1.1], clearance=25.0, states=4, settling=10, threads=n),
}
for n in (1, 4):
    calls[sys.argv[1]](n)
    print(len(os.listdir("/proc/self/task")))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="counts threads where Linux lists them")
@pytest.mark.parametrize("study", ["chart", "response"])
def test_as_many_threads_as_asked_for(study):
    """A computation starts one thread fewer than asked for, on any number of processors."""
    done = subprocess.run(
        [sys.executable, "-c", COUNT, study], capture_output=True, text=True, check=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "3"},
    )  # fmt: skip
    one, four = map(int, done.stdout.split())
    assert four == one + 3
