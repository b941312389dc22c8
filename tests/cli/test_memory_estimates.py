"""The memory that a case may take, estimated before it is computed.

That these estimates are enough is tested where a case is refused or fits (test_limits.py). Here they grow with the
size of the case as its tables do, and have the values that they had when that was tested.
"""

import re
import resource
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the limits are those of Linux")

SYSTEM = "&system xi = 0.05, mu = 0.1, restitution = 0.6"
WINDOW = "r_min = 0.9, r_max = 1.1, clearance_min = 5, clearance_max = 9"
#: In MB: the estimate. The formulas: bytes of a point, a state or a motion times their number.
OSCILLATOR = {
    f"&atlas {WINDOW}, survey = 1000000": 2000,  # 2000 B for each point
    f"&chart sides = 'RLL', {WINDOW}, r_points = 1000, clearance_points = 500": 1782,  # 3 (4 + 2) (16 x 3 + 150)
    f"&chart sides = 'RLL', {WINDOW}, r_points = 500, clearance_points = 1000, slots = 1": 891,
    f"&zone sides = 'RLL', {WINDOW}, max_points = 200000": 500,  # 1600 + 300 x 3
    "&decay clearance = 1, amplitude = 9, cycles = 1000000": 320,  # 160 (2 cycles + 1)
    "&decay clearance = 1, 2, 3, amplitude = 9, cycles = 100000": 96,
    "&lyapunov parameter = 'r', low = 0.9, high = 1.1, values = 1000000, clearance = 5": 800,
    "&response r_min = 0.9, r_max = 1.1, r_points = 1000, clearance = 5, states = 700": 700,
}
POINT = {
    "&basins clearance = 10, states = 2000000, probes = 500000": 2000,  # 500 for a state, 1000 for a probe
    "&basins clearance = 10, states = 200000, probes = 500000": 300,
    "&basins clearance = 10, axes = 'x', 'y', values = 4000, 500, low = -1, -1, high = 1, 1, probes = 1000": 1002,
    "&basins clearance = 10, probes = 1, list = 500000*0": 210,  # and 320 for each number of the list
    "&bifurcation parameter = 'clearance', low = 5, high = 9, values = 100000, points = 60, sweep = 'both'": 2540,
    "&bifurcation parameter = 'clearance', low = 5, high = 9, values = 100000, points = 40, sweep = 'up'": 870,
    "&motion kind = 'exact', sides = 'RLL', cycles = 1, phases = 0, 1, 2, clearance = 5 /\n"
    "&branch parameter = 'clearance', low = 4, high = 9, max_points = 100000": 500,  # 2 (1600 + 300 x 3)
    "&motion kind = 'equispaced', clearance = 5 /\n"
    "&branch parameter = 'clearance', low = 4, high = 9, max_points = 100000": 880,  # 4 (1600 + 300 x 2)
}
GIVEN = "&motion gaps = 3*0, phases = 1, 2, 3 /\n"
SETTLED = "&motion kind = 'settled' /\n"
BRANCH = "&branch parameter = 'load', low = 0.5, high = 2, max_points = 20000"
LOAD = "x = 'load', x_low = 0.5, x_high = 2"
#: For 30 and for 120 coordinates.
STRUCTURE = {
    "&basins states = 200000": (
        353,
        1892,
    ),  # (48 n + 100) for a state, 50 kB n^2 for the motions of a block
    "&basins axes = 'q_0', 'q_dot_1', low = 0, 0, high = 1, 1, values = 400, 300": (229, 1423),
    "&bifurcation parameter = 'load', low = 0.5, high = 2, values = 2000, points = 200, keep = 9": (
        101,
        257,
    ),
    f"{GIVEN}{BRANCH}": (238, 778),  # 2000 + 300 (3 + n)
    f"{SETTLED}{BRANCH}": (364, 904),  # 2000 + 300 (24 + n)
    "&find states = 100000": (141, 1104),  # 32 n for a state, and as for basins
    SETTLED.strip(" /\n"): (412, 458),  # 600 n^2 + 100 (2000 + n)^2
    "&response low = 0.5, high = 2, values = 2000, keep = 9": (53, 209),  # 2 (48 keep n + 500)
    f"{GIVEN}&zone {LOAD}, y = 'frequency', y_low = 1, y_high = 1.4, max_points = 200000": (
        3320,
        3320,
    ),
}


def need(binary, folder, text):
    """The megabytes that the program says a case takes, when it refuses the case for lack of memory."""
    (folder / "case.nml").write_text(text)

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (36 * 2**20, 36 * 2**20))

    if subprocess.run([binary, "--version"], capture_output=True, preexec_fn=limit).returncode:
        pytest.skip("with its LAPACK library the program does not start in 36 MB")
    done = subprocess.run(
        [binary, "case.nml"],
        cwd=folder,
        timeout=60,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=limit,
    )
    found = re.search(r"out of memory: the case needs up to (\d+) MB", done.stderr)
    assert found, done.stderr[-300:]
    assert not list(folder.glob("results/*"))
    return int(found[1])


@pytest.mark.parametrize("text", OSCILLATOR)
def test_over_a_window(text, binary, tmp_path):
    assert need(binary, tmp_path, f"{SYSTEM} /\n{text} /\n") == OSCILLATOR[text]


@pytest.mark.parametrize("text", POINT)
def test_at_a_point(text, binary, tmp_path):
    assert need(binary, tmp_path, f"{SYSTEM}, r = 1.1 /\n{text} /\n") == POINT[text]


def test_of_a_search(binary, tmp_path):
    """A search stores a motion for each cycle of each release, twice, and for each of 16 cycles of a state."""
    head = f"{SYSTEM}, r = 1.1 /\n&find clearance = 5"
    states = need(binary, tmp_path, f"{head}, states = 200000, releases = 0 /\n")
    for cycles in (5, 7):
        text = f"{head}, states = 0, releases = 200000, max_cycles = {cycles} /\n"
        assert need(binary, tmp_path, text) == pytest.approx(states * 2 * cycles / 16, abs=1)
        text = f"{head}, states = 100000, releases = 300000, max_cycles = {cycles} /\n"
        assert need(binary, tmp_path, text) == pytest.approx(states * (8 + 3 * cycles) / 16, abs=1)
    assert 200000 * 16 * 200 < states * 1e6 < 200000 * 16 * 2000


@pytest.mark.parametrize("text", STRUCTURE)
def test_of_a_structure(text, binary, tmp_path):
    found = []
    for n in (30, 120):
        first = ", ".join(["1"] + ["0"] * (n - 1))
        shapes = ", ".join("1" if i == j else "0" for i in range(n) for j in range(n))
        head = (
            f"&structure frequencies = {', '.join(str(i + 1) for i in range(n))}, damping_ratios = {n}*0.01, "
            f"shapes = {shapes} /\n&gap direction = {first}, opening = 1, restitution = 0.5 /\n"
            f"&load sine = {first}, frequency = 1.2 /\n"
        )
        found.append(need(binary, tmp_path, f"{head}{text} /\n"))
    assert found == [*STRUCTURE[text]]
