"""Limits of the stand-alone program: events, memory, stack and threads."""

import os
import resource
import subprocess
import sys

import pytest

SYSTEM = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
FAST = "&system xi = 0.0114, mu = 1e6, restitution = 1, r = 0.5 /\n"
BASINS = "&basins clearance = 37, states = 3, cycles = 4, probes = 1, max_cycles = 2, load = 0"
linux = pytest.mark.skipif(sys.platform != "linux", reason="the limits are those of Linux")


def run(binary, tmp_path, text, limits=(), environment=None):
    """Run the program on a file within limits of the system."""
    (tmp_path / "case.nml").write_text(text)

    def limit():
        for name, value in limits:
            resource.setrlimit(name, (value, value))

    return subprocess.run(
        [binary, "case.nml"], cwd=tmp_path, timeout=120, capture_output=True, text=True, check=False,
        env=os.environ | (environment or {}), preexec_fn=limit,
    )  # fmt: skip


def test_event_limit(binary, tmp_path):
    """States whose simulation has too many events are undecided, and the message gives the reason."""
    done = run(binary, tmp_path, f"{FAST}{BASINS}, max_events = 20000 /\n")
    assert done.returncode == 1
    assert "3 of 3 states not decided, 3 of them because max_events was reached" in done.stderr


@linux
def test_memory(binary, tmp_path):
    """A case that needs more memory than is available gives a message, and the next case runs."""
    text = (
        f"{SYSTEM}&response r_min = .8, r_max = 1.2, r_points = 900000, clearance = 25, states = 1, settling = 0, "
        "keep = 3 /\n&response r_min = .8, r_max = 1.2, r_points = 3, clearance = 25, states = 1, settling = 9, "
        "keep = 3 /\n"
    )
    done = run(binary, tmp_path, text, [(resource.RLIMIT_AS, 400 * 2**20)])
    assert done.returncode == 1
    assert "out of memory" in done.stderr
    assert len(list((tmp_path / "results").glob("*.csv"))) == 1


@linux
@pytest.mark.parametrize("length", [2_700_000, 3 * 10**7])
def test_memory_of_a_long_list(length, binary, tmp_path):
    """If reading, or the header of the result, exceeds the memory, the program gives a message and no file."""
    numbers = ", ".join(["1"] * (length // 3))
    text = f"{SYSTEM}&lyapunov r = {numbers}, clearance = 20, cycles = 4, batches = 2 /\n"
    done = run(binary, tmp_path, text, [(resource.RLIMIT_AS, 120 * 2**20)])
    assert "out of memory" in done.stderr
    assert "Error allocating" not in done.stderr
    assert done.returncode == (1 if length < 10**7 else 2)
    assert not list(tmp_path.glob("results/*"))


@linux
@pytest.mark.parametrize("given", [" = 12500000*0", "(12500000) = 0"])
@pytest.mark.parametrize("room", [100, 300, 330, 350, 380, 420, 460])
def test_memory_of_a_list_of_few_bytes(room, given, binary, tmp_path):
    """A few bytes that specify a list of millions of numbers are refused before the list is made or used."""
    text = (
        f"{SYSTEM.replace('/', ', r = 1.04 /')}&basins clearance = 37, probes = 1, list{given} /\n"
    )
    done = run(binary, tmp_path, text, [(resource.RLIMIT_AS, room * 2**20)])
    assert done.returncode in (1, 2)
    assert "Error allocating" not in done.stderr
    assert "out of memory" in done.stderr or (
        "must be numbers from -1e100" in done.stderr and room > 400
    )


@linux
@pytest.mark.parametrize("given", [" = 745000*0", "(745000) = 0", " = 400000*0"])
@pytest.mark.parametrize("room", [16, 20, 24, 28, 32, 36, 40])
def test_a_list_in_little_memory(room, given, binary, tmp_path):
    """With less than a few megabytes of memory left, the program still gives a message."""
    if (
        "no namelist group"
        not in run(binary, tmp_path, "", [(resource.RLIMIT_AS, room * 2**20)]).stderr
    ):
        pytest.skip(f"with its LAPACK library the program does not start in {room} MB")
    text = (
        f"{SYSTEM.replace('/', ', r = 1.04 /')}&basins clearance = 37, probes = 1, list{given} /\n"
    )
    done = run(binary, tmp_path, text, [(resource.RLIMIT_AS, room * 2**20)])
    assert done.returncode in (1, 2)
    assert "Error allocating" not in done.stderr
    assert "out of memory" in done.stderr or "must be numbers from -1e100" in done.stderr


@linux
def test_what_makes_no_list_long(binary, tmp_path):
    """Values listed one by one, and stars within words and comments, are not mistaken for long lists."""
    single = "\n".join(f"list({i}) = 0" for i in range(1, 8001))
    head = SYSTEM.replace("/", ", r = 1.04 /")
    text = (
        f"{head}! 100000000*0\n&basins clearance = 37, probes = 1, cycles = 1\n{single} /\n"
        "&output name = 'one' /\n"
    )
    limits = [(resource.RLIMIT_AS, 60 * 2**20)]
    done = run(binary, tmp_path, text, limits)
    # a free mass at rest, which the walls do not reach
    assert (done.returncode, done.stderr) == (0, "")
    assert "one: 1600 states, no impacts 100.00%" in done.stdout
    done = run(binary, tmp_path, text.replace("one", "100000000*1"), limits)
    assert done.returncode == 2
    assert "&output name = '100000000*1'" in done.stderr


@linux
@pytest.mark.parametrize("size", [96, 128, 256, 1024])
def test_stack(binary, tmp_path, size):
    """A stack that is too small gives a message, not a crash."""
    text = f"{SYSTEM.replace('/', ', r = 1.04 /')}{BASINS.replace(', load = 0', '')} /\n"
    done = run(binary, tmp_path, text, [(resource.RLIMIT_STACK, size * 1024)])
    assert done.returncode in ((2,) if size < 512 else (0, 1))
    assert ("stack is too small" in done.stderr) == (size < 512)


@pytest.mark.parametrize(
    "environment",
    [{"OMP_STACKSIZE": "16k"}, {"OMP_STACKSIZE": "64k"}, {"OMP_NUM_THREADS": "100000"}],
)
def test_threads(binary, tmp_path, environment):
    """Small stacks of threads, or very many threads, do not crash the program."""
    done = run(binary, tmp_path, f"{FAST}{BASINS}, max_events = 9 /\n", (), environment)
    assert done.returncode == 1, done.stderr
    assert "max_events" in done.stderr
