"""The commands lyapunov, bifurcation, basins and response: the same digits as the functions give."""

import contextlib
import csv
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi
from programs import Runner, find_command

EQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
SYSTEM = ["--xi", "0.0114", "--mu", "0.028", "--restitution", "0.75"]


@pytest.fixture
def tool(tmp_path):
    """Runner of `vibroimpact` in a folder of its own."""
    return Runner([find_command()], tmp_path)


def table(tool, name):
    """Columns of a result."""
    with open(tool.cwd / "results" / f"{name}.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: [row[key] for row in rows] for key in rows[0]}


def test_lyapunov(tool):
    line = ["--r", "1.04", "--clearance", "14", "30", "2", "--cycles", "400", "--discard", "300"]
    done = tool("lyapunov", *SYSTEM, *line)
    # from rest in the middle nothing hits where A is less than half the clearance
    result = vi.lyapunov(EQUAL, 1.04, [14.0, 30.0], cycles=400, discard=300)
    assert done.status == int(np.isnan(result.exponents).any())
    written = table(tool, "lyapunov")
    for j in range(4):
        column = np.array(written[f"exponent_{j + 1}"], dtype=float)
        np.testing.assert_array_equal(column, result.per_cycle[j])


def test_bifurcation(tool):
    sweep = ["--r", "1.04", "--parameter", "clearance", "--values", "20", "40", "3"]
    done = tool("bifurcation", *SYSTEM, *sweep, "--plot", "svg")
    assert (done.status, done.err) == (0, b"")
    result = vi.bifurcation_diagram(EQUAL, "clearance", [20, 30, 40], r=1.04)
    written = table(tool, "bifurcation")
    assert [float(x) for x in written["x"]] == result.points["x"].tolist()
    assert written["side"] == result.points["side"].tolist()
    for window in result.windows:
        assert f"{window.run}: {window.label} from {window.low:g}" in done.out.decode()
    assert (tool.cwd / "results" / "bifurcation.svg").exists()


def test_basins(tool):
    point = ["--r", "1.04", "--clearance", "14"]
    plane = ["--plane", "x", "-9", "9", "6", "x_dot", "-9", "9", "5"]
    done = tool("basins", *SYSTEM, *point, *plane)
    assert (done.status, done.err) == (0, b"")
    result = vi.basins(EQUAL, 1.04, 14.0, (("x", -9, 9, 6), ("x_dot", -9, 9, 5)))
    written = table(tool, "basins")
    assert [int(x) for x in written["label"]] == result.labels.ravel().tolist()
    assert [float(x) for x in written["x"]] == result.states[1].ravel().tolist()
    for item in result.attractors:
        assert item.name in done.out.decode()


def test_response(tool):
    done = tool("response", *SYSTEM, "--r", "1", "1.04", "3", "--clearance", "25", "--states", "4")
    assert (done.status, done.err) == (0, b"")
    result = vi.response(EQUAL, [1, 1.02, 1.04], clearance=25.0, states=4)
    written = table(tool, "response")
    assert [float(x) for x in written["highest"]] == result.highest.tolist()
    assert [float(x) for x in written["lowest"]] == result.lowest.tolist()


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["basins", *SYSTEM, "--r", "1", "--clearance", "9"], "exactly one of them must be given"),
        (["basins", *SYSTEM, "--r", "1", "--clearance", "9", "--plane", *"abcdefgh"], "--plane"),
        (["bifurcation", *SYSTEM, "--parameter", "r", "--values", "1", "2", "5"], "--clearance"),
        (["lyapunov", *SYSTEM, "--r", "1", "2", "--clearance", "9"], "--r"),
        (["response", *SYSTEM, "--r", "1", "--clearance", "-9"], "clearance"),
    ],
)
def test_bad_input_is_named(tool, words, fault):
    done = tool(*words)
    assert (done.status, done.out) == (2, b"")
    assert fault in done.err.decode()


def test_lyapunov_without_impacts_says_so(tool):
    """Rest in a wide slot has none; the message names the option that helps, and it does."""
    point = ["--r", "1.04", "--clearance", "72", "--cycles", "400", "--discard", "50"]
    done = tool("lyapunov", *SYSTEM, *point)
    assert done.status == 1
    assert len(done.faults) == 1
    assert done.faults[0].startswith("lyapunov: no exponents at 1 of 1 points: no impacts")
    assert "--state X X_DOT Z Z_DOT" in done.faults[0]
    done = tool("lyapunov", *SYSTEM, *point, "--state", "0", "6", "0", "9")
    assert (done.status, done.err) == (0, b"")
    start = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
    result = vi.lyapunov(EQUAL, 1.04, 72.0, 400, start, discard=50)
    assert float(table(tool, "lyapunov")["exponent_1"][0]) == result.per_cycle[0]


#: Work for about a second each, on one line of the shell.
LONG = {
    "lyapunov": ["--r", "1.04", "--clearance", "10", "24", "150"],
    "bifurcation": ["--r", "1.04", "--parameter", "clearance", "--values", "50", "75", "900"],
    "response": ["--r", "1", "1.02", "300", "--inverse-clearance", "0.03"],
    "basins": ["--r", "0.94", "--clearance", "37", "--plane", "x", "-30", "30", "99", "x_dot", "-30", "30", "99"],
}  # fmt: skip


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize("name", LONG)
def test_bar_and_interrupt_on_a_terminal(name, tool):
    """A bar with the time left; Ctrl-C leaves a table of what is finished, and says so; status 1."""
    (tool.cwd / "sitecustomize.py").write_text(
        "import vibroimpact.progress as p, vibroimpact.interrupt as r\n"
        "p.PATIENCE = p.INTERVAL = 0.0; r.INTERVAL = 0.001\n"
    )
    ours, theirs = os.openpty()
    with subprocess.Popen(
        [find_command(), name, *SYSTEM, *LONG[name]],
        cwd=tool.cwd, stderr=theirs, stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(tool.cwd)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:  # fmt: skip
        os.close(theirs)
        said, stopped = b"", False
        with contextlib.suppress(OSError):  # the end of a terminal
            while part := os.read(ours, 4096):
                said += part
                # half way: something is finished then, whatever the order of the work
                if not stopped and b"[" + b"#" * 15 in said:
                    stopped = True
                    process.send_signal(signal.SIGINT)
    os.close(ours)
    assert f"\r{name} [".encode() in said
    assert b" s left " in said
    assert stopped
    assert process.returncode == 1
    assert (
        said.splitlines()[-1]
        .decode()
        .endswith(f"vibroimpact {name}: interrupted; what was finished is kept")
    )
    assert list((tool.cwd / "results").iterdir()) == [tool.cwd / "results" / f"{name}.csv"]
    assert len(table(tool, name)) > 1
