"""The commands lyapunov, bifurcation, basins and response: the same digits as the functions give."""

import csv

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
        (["basins", *SYSTEM, "--r", "1", "--clearance", "9"], "give one of them"),
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
