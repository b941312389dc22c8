"""Bifurcation diagrams, responses and basins in namelists: laws, and agreement of both programs with the API."""

import inspect
import math
import re
import signal
import subprocess
import time

import pytest
import vibroimpact as vi
from attractors import (
    DIAGRAM,
    EQUAL,
    FREE,
    MOVING,
    PLANE,
    RESPONSE,
    TABLE,
    WALLS,
    assert_both,
    case_of,
    told,
)
from programs import assert_refused, column, contents, rows, write
from vibroimpact.cases.case import read_namelist


def assert_diagram(table, result):
    """Every digit of the table equals that of the diagram of the API."""
    points = result.points
    assert [row["run"] for row in table] == [result.runs[i] for i in points["run"]]
    assert column(table, result.parameter).tolist() == result.values[points["index"]].tolist()
    labels = result.labels[points["run"], points["index"]]
    assert [row["label"] for row in table] == labels.tolist()
    assert [row["side"] for row in table] == points["side"].tolist()
    for name in ("phase", "x", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after"):
        assert column(table, name).tolist() == points[name].tolist()


@pytest.mark.parametrize("text", [
    DIAGRAM,
    DIAGRAM.replace("'both'", "'up', t = 1, x = 2, x_dot = 3, z = 4"),
    *[FREE.replace("/", ", r = 1.04 /") + f"&bifurcation clearance = 9, sweep = 'down', settling = 30, {line} /\n"
      for line in ("parameter = 'xi', low = 0, high = 0.05, values = 3, load = 2",
                   "parameter = 'Mu', low = 0, high = 0.1, values = 2, points = 5",
                   "parameter = 'R1', low = 0.5, high = 1, values = 4, keep = 9",
                   "parameter = 'r2', low = 0.5, high = 1, values = 4",
                   "parameter = 'restitution', low = 0, high = 1, values = 4")],
    f"{FREE}&bifurcation parameter = 'r', low = 0.9, high = 1.1, values = 4, clearance = 20, settling = 50 /\n",
    f"{WALLS}&bifurcation parameter = 'clearance', low = 5, high = 8, values = 3, sweep = 'states', states = 5"
    " /\n",
])  # fmt: skip
def test_diagrams_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    assert_diagram(table, result)
    header = (batch.cwd / "results/case.csv").read_text().split("\n")
    output = [re.fullmatch(r"# ! (.+): (.+) from (.+) to (.+)", line) for line in header]
    assert [(line[1], float(line[3]), float(line[4]), line[2]) for line in output if line] == [
        tuple(window) for window in result.windows
    ]


def test_sweeps_agree_outside_the_hysteresis(batch):
    """Sweeps up and down give one motion or its mirror image, except within the hysteresis."""
    text = DIAGRAM.replace("low = 20, high = 26, values = 4", "low = 50, high = 75, values = 26")
    assert batch.case(text.replace("settling = 60", "settling = 300")).status == 0
    reach = {}
    for row in rows(batch.cwd / "results/case.csv"):
        place = row["run"], float(row["clearance"])
        assert place not in reach or reach[place][0] == row["label"]
        x = abs(float(row["x"]))
        reach[place] = row["label"], max(x, reach.get(place, ("", 0))[1])
    values = sorted({value for _, value in reach})
    labels = [(reach["up", value][0], reach["down", value][0]) for value in values]
    both_ways = [pair == ("2/1", "2/1") for pair in labels]
    only_up = [pair[0] == "2/1" != pair[1] for pair in labels]
    neither = ["2/1" not in pair for pair in labels]
    # the two-impact motion is found in both sweeps, then only in the sweep up, then in neither, without gaps
    assert [*both_ways] == sorted(both_ways, reverse=True)
    assert [*neither] == sorted(neither)
    assert sum(both_ways) > 3 < sum(only_up)
    assert any(neither)
    # the sweep down comes to the largest of these values from chaos, and may have settled only just before
    for value in values[: sum(both_ways) - 1]:
        assert reach["up", value][1] == pytest.approx(reach["down", value][1], rel=1e-6)


BAD_DIAGRAM = [
    ("sweep", "list = 20, 21, sweep", "low = 20: must be left out if list is given", 3),
    *[("low = 20, high = 26, values = 4", f"list = {v}", "must be two or more increasing or decreasing numbers", 3)
      for v in ("20", "20, 20", "21, 20, 22", "-1, 20", "nan, 20")],
    ("low = 20", "clearance = 3, low = 20", "must be left out: it is the parameter", 3),
    *[("'clearance'", v, "'restitution' (both walls)", 2) for v in ("'q'", "''", "r", "1")],
    *[("low = 20", f"low = {v}", "1e-12 <= clearance <= 1e12", 3) for v in ("nan", "0", "26, 27", "x")],
    *[("high = 26", f"high = {v}", "1e-12 <= clearance <= 1e12", 3) for v in ("20", "inf", "1e13")],
    *[("values = 4", f"values = {v}", "2 <= values", 3) for v in ("1", "4, 5", "1.5", "2000000")],
    *[("'both'", v, "'up', 'down', 'both' or 'states'", 4) for v in ("'left'", "''", "up")],
    *[("settling = 60", f"settling = {v}", "0 <= settling", 4) for v in ("-1", "20000000", "1e2")],
    *[("settling = 60", f"keep = {v}", "3 <= keep", 4) for v in ("2", "10001")],
    *[("settling = 60", f"points = {v}", "1 <= points", 4) for v in ("0", "4097")],
    ("settling = 60", "load = -1", "0 <= load", 4),
    ("settling = 60", "states = 4", "must be left out: it requires sweep = 'states'", 4),
    ("'both'", "'states', x = 1", "must be left out: sweep = 'states' uses other initial states", 4),
    ("'both'", "'states', states = 0", "1 <= states", 4),
    ("'both'", "'states', states = 1000000", "values x runs x points must be at most", 2),
    ("settling = 60", "z = 10.1", "z - x must be within half the clearance", 4),
    ("settling = 60", "t = nan", "a number with -1e100 <= t <= 1e100", 4),
    ("settling = 60", "clearance = 3", "must be left out: it is the parameter", 4),
    ("settling = 60", "cycles = 3", "is not a key of &bifurcation; must be one of clearance, r, parameter", 4),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_DIAGRAM)
def test_bad_diagram(old, new, wanted, line, batch):
    assert old in DIAGRAM
    assert_refused(DIAGRAM.replace(old, new, 1), "bifurcation", wanted, line, batch)


@pytest.mark.parametrize("text", [
    RESPONSE,
    RESPONSE.replace("inverse_clearance = 0.03", "clearance = 25, load = 1.3, settling = 50, keep = 7"),
    RESPONSE.replace("0.75", "0.75, 0.61"),
])  # fmt: skip
def test_response_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    for name in ("r", "clearance", "lowest", "highest"):
        assert column(table, name).tolist() == getattr(result, name).tolist()
    assert (column(table, "lowest") <= column(table, "highest")).all()


def test_response_is_that_of_the_motions(batch):
    """The response is that of the stable two-impact motion by its closed form."""
    assert batch.case(RESPONSE.replace("inverse_clearance = 0.03", "clearance = 40")).status == 0
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    table = rows(batch.cwd / "results/case.csv")[-2:]
    for row in table:
        pair = vi.equispaced(osc, float(row["r"]), 40.0)
        (attenuation,) = (motion.attenuation for motion in pair if motion.stable)
        assert float(row["highest"]) == pytest.approx(attenuation, rel=1e-5)


BAD_RESPONSE = [
    *[("r_min = 1.0", f"r_min = {v}", "r_min <= 1e6", 3) for v in ("nan", "0", "x")],
    *[("r_max = 1.04", f"r_max = {v}", "r_min below r_max", 3) for v in ("1", "0.5", "nan", "inf")],
    *[("r_points = 5", f"r_points = {v}", "2 <= r_points", 3) for v in ("1", "2.5", "2000000")],
    *[("inverse_clearance = 0.03", f"{name} = {v}", f"1e-12 <= {name} <= 1e12", 2)
      for name in ("clearance", "inverse_clearance") for v in ("0", "-1", "nan", "1e13")],
    ("inverse_clearance = 0.03", "inverse_clearance = 0.03, clearance = 9", "if inverse_clearance is given", 2),
    ("inverse_clearance = 0.03,", "", "clearance: is missing", 2),
    *[("states = 3", f"load = {v}", "0 < load <= 1e12", 2) for v in ("0", "-1", "nan")],
    *[("states = 3", f"states = {v}", "1 <= states", 2) for v in ("0", "1.5")],
    ("states = 3", "states = 3, settling = -1", "0 <= settling", 2),
    ("states = 3", "states = 3, keep = 2", "3 <= keep", 2),
    ("states = 3", "sweep = 'up'", "is not a key of &response; must be one of r, r_min", 2),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_RESPONSE)
def test_bad_response(old, new, wanted, line, batch):
    assert old in RESPONSE
    assert_refused(RESPONSE.replace(old, new, 1), "response", wanted, line, batch)


@pytest.mark.parametrize("text", [
    PLANE,
    PLANE.replace("'x', 'x_dot'", "'y', 'Z_dot'").replace("probes", "t = 1, x = 3, x_dot = -2, probes")
    .replace("30", "3"),
    PLANE.replace("= 37", "= 25, load = 0.7").replace("'x_dot'", "'t'"),
    PLANE.replace(TABLE, WALLS).replace("= 37", "= 6"),
    PLANE.replace(TABLE, EQUAL).replace("= 37", "= 72, cycles = 300").replace("8, 9", "4, 3"),
])  # fmt: skip
def test_basins_of_the_api(text, batch, command, same_build):
    table = assert_both(text, batch, command)
    result = case_of(batch).run()[0]
    for name, values in zip(("t", "x", "x_dot", "z", "z_dot"), result.states, strict=True):
        assert column(table, name).tolist() == values.ravel().tolist()
    assert column(table, "label").tolist() == result.labels.ravel().tolist()
    names = [*(item.name for item in result.attractors), ""]
    assert [row["attractor"] for row in table] == [names[i] for i in result.labels.ravel()]
    output = told(batch.cwd / "results/case.csv")
    assert [(item[1], item[2]) for item in output] == [
        (item.name, item.kind) for item in result.attractors
    ]
    assert [float(item[3]) for item in output] == result.fractions.tolist()
    for item, attractor in zip(output, result.attractors, strict=True):
        if attractor.motion is not None:
            # the derivative of the simulation, and [P] of the exact motion
            largest = abs(attractor.motion.multipliers).max()
            assert float(item[4]) == pytest.approx(largest, rel=1e-6)
        elif attractor.lyapunov is not None:
            # two averages over parts of one motion
            error = attractor.lyapunov.error_per_cycle[0]
            assert 0 < error < 0.2 * attractor.lyapunov.per_cycle[0]
            assert float(item[4]) == pytest.approx(attractor.lyapunov.per_cycle[0], abs=5 * error)


def test_shares_sum_to_one(batch):
    """Shares sum to one, are those of the labels, and decrease from attractor to attractor."""
    assert batch.case(PLANE).status == 0
    shares = [float(item[3]) for item in told(batch.cwd / "results/case.csv")]
    labels = [int(row["label"]) for row in rows(batch.cwd / "results/case.csv")]
    assert sum(shares) == pytest.approx(1, abs=1e-15)
    assert shares == sorted(shares, reverse=True)
    assert shares == [labels.count(i) / len(labels) for i in range(len(shares))]


def test_attractors_are_motions(batch):
    """The greatest multiplier of an attractor is that of the motion found by &motion."""
    motion = "&motion kind = 'exact', sides = 'RL', clearance = 37, phases_over_pi = 0, 1.37 /\n"
    assert batch.case(TABLE + motion + PLANE.replace(TABLE, "")).status == 0
    row = rows(batch.cwd / "results/case_1.csv")[0]
    moduli = [
        math.hypot(float(row[f"multiplier_{i}_re"]), float(row[f"multiplier_{i}_im"]))
        for i in range(1, 5)
    ]
    output = {item[1]: float(item[4]) for item in told(batch.cwd / "results/case_2.csv") if item[4]}
    for name in ("RL/1 (1)", "RL/1 (2)"):
        assert output[name] == pytest.approx(max(moduli), rel=1e-7)


def test_mirror_images_go_to_mirror_images(batch):
    """States near an attractor go to it; their mirror images, half a load cycle later, go to its mirror image."""
    plane = PLANE.replace(TABLE, EQUAL).replace("= 37", "= 14").replace("8, 9", "3, 3")
    assert batch.case(plane).status == 0
    header = (batch.cwd / "results/case.csv").read_text()
    output = re.search(r"# ! 0: (\S+) .*; t, x, x_dot, z, z_dot = (.*)", header)
    t, x, x_dot, z, z_dot = (float(item) for item in output[2].split(", "))
    text = EQUAL
    for s, later in ((1, 0.0), (-1, math.pi / 1.04)):
        text += (
            "&basins clearance = 14, axes = 'x', 'x_dot', values = 3, 3\n"
            f"low = {s * x - 0.02!r}, {s * x_dot - 0.02!r}, high = {s * x + 0.02!r}, {s * x_dot + 0.02!r}\n"
            f"t = {t + later!r}, y = {s * (z - x)!r}, z_dot = {s * z_dot!r} /\n"
        )
    assert batch.case(text).status == 0
    here, there = (
        {row["attractor"] for row in rows(batch.cwd / f"results/case_{i}.csv")} for i in (1, 2)
    )
    assert here == {output[1]}
    assert here | there == {"RRL/1", "RLL/1"}
    assert len(there) == 1


@pytest.mark.slow
def test_what_never_settles_is_not_decided(batch, command):
    """Free vibration decays without end: only a free mass that the walls do not reach has settled."""
    done = batch.case(PLANE.replace("probes", "load = 0, cycles = 50, probes"))
    assert (done.status, done.faults) == (1, ["case: 66 of 72 states not decided"])
    assert done.out.startswith(b"case: 72 states, no impacts 8.33%")
    # the free mass stays at rest if the decaying motion of the primary mass never brings a wall to it
    for row in rows(batch.cwd / "results/case.csv"):
        x, x_dot = float(row["x"]), float(row["x_dot"])
        assert (row["attractor"] != "") == (abs(x) + math.hypot(x, x_dot) < 37 / 2)
    assert command("case.nml", "-o", "command").out == done.out


BAD_PLANE = [
    *[("axes = 'x', 'x_dot'", f"axes = {v}", "two of 'x', 'x_dot', 'y'", 3)
      for v in ("'x'", "'x', 'x'", "'x', 'q'", "'', 'x'", "x, y", "'x', 'y', 't'", "'z', 'x'")],
    *[("low = -30, -30", f"low = {v}", "two numbers from -1e100 to 1e100", 4)
      for v in ("-30", "nan, 1", "1, 2, 3", "-inf, -30", "30, -30", "-30, 31")],
    *[("high = 30, 30", f"high = {v}", "two numbers from -1e100 to 1e100", 4)
      for v in ("30", "30, -30", "30, inf")],
    *[("values = 8, 9", f"values = {v}", "two whole numbers", 4)
      for v in ("8", "8, 1", "1, 9", "8, 9, 9", "8.5, 9", "100001, 2")],
    ("values = 8, 9", "values = 100000, 100000", "together at most 12500000 states", 4),
    *[("clearance = 37", f"clearance = {v}", "1e-12 <= clearance", 2) for v in ("0", "nan", "1e13", "-1")],
    ("clearance = 37", "", "clearance: is missing", 2),
    ("'x', 'x_dot'", "'y', 'x_dot'", "y must be within half the clearance", 4),
    *[("'x', 'x_dot'\n  low = -30, -30, high = 30, 30", f"{axes}\n  low = {low}, high = {high}",
       f"{bad} = {low if bad == 'low' else high}: must be two numbers from -1e100 to 1e100, one for each axis, "
       "and low below high; y must be within half the clearance", 4)
      for axes, low, high, bad in (
          ("'y', 'x'", "-18.6, -30", "18.4, 30", "low"), ("'y', 'x'", "-18.4, -30", "18.6, 30", "high"),
          ("'x', 'y'", "-30, -18.6", "30, 18.4", "low"), ("'x', 'y'", "-30, -18.4", "30, 18.6", "high"))],
    *[("probes = 50", f"probes = {v}", "1 <= probes", 5) for v in ("0", "1e2", "2000000")],
    *[("probes = 50", f"cycles = {v}", "1 <= cycles <= 10000000", 5) for v in ("0", "20000000")],
    *[("probes = 50", f"max_cycles = {v}", "1 <= max_cycles <= 100", 5) for v in ("0", "101")],
    ("probes = 50", "load = -1", "0 <= load", 5),
    ("probes = 50", "t = nan", "a number with -1e100 <= t <= 1e100", 5),
    *[("probes = 50", f"y = {y}", "y must be within half the clearance", 5) for y in ("18.6", "-18.6")],
    ("probes = 50", "x = 3", "x = 3: must be left out: it is an axis", 5),
    ("probes = 50", "z = 3", "is not a key of &basins; must be one of clearance, states", 5),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_PLANE)
def test_bad_plane(old, new, wanted, line, batch):
    assert old in PLANE
    assert_refused(PLANE.replace(old, new, 1), "basins", wanted, line, batch)


def test_resonance_without_damping(batch):
    undamped = FREE.replace("0.0114", "0")
    assert_refused(undamped + RESPONSE.replace(FREE, ""), "response", "r = 1 with xi = 0", 3, batch)
    text = DIAGRAM.replace("1.04", "1").replace("'clearance'", "'xi', clearance = 9")
    text = text.replace("low = 20, high = 26", "low = 0, high = 0.1")
    assert_refused(text, "bifurcation", "r = 1 with xi = 0", 3, batch)
    text = DIAGRAM.replace(EQUAL, undamped).replace("'clearance'", "'r', clearance = 9")
    text = text.replace("low = 20, high = 26, values = 4", "low = 0.9, high = 1.1, values = 3")
    assert_refused(text, "bifurcation", "r = 1 with xi = 0", 3, batch)


def test_defaults_are_those_of_the_api(tmp_path):
    """Keys omitted in a namelist have the defaults of the API."""
    line = "parameter = 'clearance', low = 9, high = 10, values = 2"
    text = (
        f"{EQUAL}&lyapunov clearance = 9 /\n&bifurcation {line} /\n&bifurcation {line}, sweep = 'states' /\n"
        "&response r_min = 1, r_max = 2, r_points = 2, clearance = 9 /\n"
        "&basins clearance = 9, axes = 'x', 'x_dot', low = 2*0, high = 2*1, values = 2*2 /\n"
    )
    cases = read_namelist(write(tmp_path / "case.nml", text))
    functions = (
        vi.lyapunov,
        vi.bifurcation_diagram,
        vi.bifurcation_diagram,
        vi.response,
        vi.basins,
    )
    compared = 0
    for case, function in zip(cases, functions, strict=True):
        for name, item in inspect.signature(function).parameters.items():
            # the number of impacts of a diagram is its key `points`
            key = {"impacts": "points"}.get(name, name)
            if item.default not in (inspect.Parameter.empty, None) and key in case.keys:
                assert case.keys[key] == (
                    "states" if case is cases[2] and name == "sweep" else item.default
                )
                compared += 1
    assert compared == 5 + 6 + 7 + 5 + 5


@pytest.mark.parametrize("program", ["batch", "command"])
def test_interrupt_leaves_whole_items(program, request):
    """After an interrupt, finished results are complete, and a kept partial result is marked as cut short."""
    run = request.getfixturevalue(program)
    longest = "&bifurcation parameter = 'clearance', low = 9, high = 10, values = 100, settling = 1000000 /\n"
    done = f"&lyapunov clearance = 9, cycles = 50, {MOVING} /\n"
    write(run.cwd / "case.nml", EQUAL + done + longest)
    with subprocess.Popen(
        [*run.start, "case.nml", "-o", "out"],
        cwd=run.cwd,
        stderr=subprocess.PIPE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        for _ in range(400):
            if contents(run.cwd / "out").keys() >= {"case_1.csv"}:
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
    assert process.returncode != 0
    kept = contents(run.cwd / "out")
    whole = kept.pop("case_1.csv")
    assert kept.keys() <= {"case_2.csv"}
    assert all(b"\n# ! cut short: " in table for table in kept.values())
    assert run("out/case_1.csv", "-o", "again").status == 0
    assert contents(run.cwd / "again") == {"case_1.csv": whole}
