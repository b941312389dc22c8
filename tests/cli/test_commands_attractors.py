"""The commands lyapunov, bifurcation, basins and response: files or options, and the bytes of the program."""

import json
import re
import sys

import numpy as np
import pytest
import vibroimpact as vi
from programs import (
    bars,
    bound_by_permissions,
    column,
    contents,
    kinds,
    on_terminal,
    rows,
    write,
)

EQUAL = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
SYSTEM = ["--xi", "0.0114", "--mu", "0.028", "--restitution", "0.75"]
#: The options of some cases, and their groups.
CASES = {
    "lyapunov": [
        ("--r 1.04 --clearance 14 30 2 --cycles 400 --discard 300",
         "parameter = 'clearance', low = 14, high = 30, values = 2, cycles = 400, discard = 300"),
        ("--r 1 1.05 3 --clearance 20 --cycles 400 --state 1 6 -2 9",
         "parameter = 'r', low = 1, high = 1.05, values = 3, clearance = 20, cycles = 400, x = 1, x_dot = 6,"
         " z = -2, z_dot = 9"),
        ("--r 1.04 --clearance 20 --cycles 400", "clearance = 20, cycles = 400"),
        ("--r 1.04 --clearance 14 30 3 --spacing geometric --cycles 400",
         "parameter = 'clearance', low = 14, high = 30, values = 3, spacing = 'geometric', cycles = 400"),
    ],
    "bifurcation": [
        ("--r 1.04 --parameter clearance --values 20 40 3",
         "parameter = 'clearance', low = 20, high = 40, values = 3"),
        ("--clearance 20 --parameter r --values .9 1.1 3 --sweep states --states 2",
         "parameter = 'r', low = .9, high = 1.1, values = 3, clearance = 20, sweep = 'states', states = 2"),
        ("--r 1.04 --parameter clearance --values 20 40 3 --spacing geometric --sweep down",
         "parameter = 'clearance', low = 20, high = 40, values = 3, spacing = 'geometric', sweep = 'down'"),
        ("--r 1.04 --clearance 20 --parameter mu --values 0 .1 2 --sweep up",
         "parameter = 'mu', low = 0, high = .1, values = 2, clearance = 20, sweep = 'up'"),
    ],
    "basins": [
        ("--r 1.04 --clearance 14 --plane x -9 9 6 x_dot -9 9 5",
         "clearance = 14, axes = 'x', 'x_dot', low = -9, -9, high = 9, 9, values = 6, 5"),
        ("--r 1.04 --clearance 14 --states 30 --seed 5", "clearance = 14, states = 30, seed = 5"),
    ],
    "response": [
        ("--r 1 1.04 3 --clearance 25 --states 4",
         "r_min = 1, r_max = 1.04, r_points = 3, clearance = 25, states = 4"),
        ("--r 1 1.04 3 --inverse-clearance .03 --states 3",
         "r_min = 1, r_max = 1.04, r_points = 3, inverse_clearance = .03, states = 3"),
    ],
    "decay": [
        ("--clearance .3 .7 --cycles 5", "clearance = .3, .7, cycles = 5"),
        ("--inverse-clearance 2 --amplitude -3 --x-dot 1 --y .2 --z-dot -1",
         "inverse_clearance = 2, amplitude = -3, x_dot = 1, y = .2, z_dot = -1"),
    ],
}  # fmt: skip
EACH = [(name, *case) for name, cases in CASES.items() for case in cases]


@pytest.mark.parametrize(("name", "options", "keys"), EACH, ids=lambda word: word[:20])
def test_options_are_a_namelist(name, options, keys, tool):
    """Options, a file, and `run` (the compiled program) give the same bytes and first lines of output."""
    r = ", r = 1.04" if "--r 1.04 " in options else ""
    write(
        tool.cwd / f"{name}.nml",
        f"&system xi = 0.0114, mu = 0.028, restitution = 0.75{r} /\n&{name} {keys} /\n",
    )
    done = tool(name, *SYSTEM, *options.split())
    assert (done.status, done.err) == (0, b"")
    assert tool(name, f"{name}.nml", "-o", "file") == done
    run = tool("run", f"{name}.nml", "-o", "run")
    assert done.out.startswith(run.out)
    found = contents(tool.cwd / "results")
    assert list(found) == [f"{name}.csv"]
    assert contents(tool.cwd / "file") == found == contents(tool.cwd / "run")
    assert tool(name, f"results/{name}.csv", "-o", "again") == done
    assert contents(tool.cwd / "again") == found


def test_windows_are_printed_and_a_quantity_is_drawn(tool):
    """The printed windows are those of the function; --quantity changes the picture, not the table."""
    write(tool.cwd / "case.nml", kinds()["bifurcation"])
    done = tool("bifurcation", "case.nml", "--plot", "svg", "-o", "x")
    assert (done.status, done.err) == (0, b"")
    (result,) = vi.read_namelist(tool.cwd / "case.nml")[0].run()
    assert result.windows
    for window in result.windows:
        line = f"{window.run}: {window.label} from {window.low:.6g} to {window.high:.6g}\n"
        assert line in done.out.decode()
    assert (
        tool("bifurcation", "case.nml", "--plot", "svg", "--quantity", "phase", "-o", "p").status
        == 0
    )
    one, other = contents(tool.cwd / "x"), contents(tool.cwd / "p")
    assert one["case.csv"] == other["case.csv"]
    assert one["case.svg"] != other["case.svg"]


def test_shares_are_printed(tool):
    """Shares are printed with standard errors, and with the uncertainty exponent of the plane."""
    point = "--r 1.04 --clearance 14 --plane x -9 9 18 x_dot -9 9 17"
    done = tool("basins", *SYSTEM, *point.split(), "--plot")
    assert sorted(contents(tool.cwd / "results")) == ["basins.csv", "basins.png"]
    result = vi.basins(EQUAL, 1.04, 14.0, (("x", -9, 9, 18), ("x_dot", -9, 9, 17)))
    output = re.findall(r"(\S+(?: \(\d\))?) ([\d.]+)% \+- ([\d.]+)%", done.out.decode())
    assert [name for name, *_ in output] == [item.name for item in result.attractors]
    shares = np.array([[float(item) / 100 for item in line[1:]] for line in output]).T
    assert shares[0] == pytest.approx(result.fractions, abs=1e-4)
    assert shares[1] == pytest.approx(result.standard_error, abs=1e-4)
    assert f"uncertainty exponent {result.uncertainty_exponent:.3f}" in done.out.decode()


def test_planes_of_uneven_values(tool):
    """Listed values of the axes are those of the function with arrays; --plane is then refused."""
    point = [*SYSTEM, "--r", "1.04", "--clearance", "14"]
    values = ["--first-values", "-9", "0", "4", "--second-values", "-3", "8"]
    assert tool("basins", *point, "--axes", "x", "x_dot", *values).status == 0
    result = vi.basins(EQUAL, 1.04, 14.0, (("x", [-9.0, 0, 4]), ("x_dot", [-3.0, 8])))
    table = rows(tool.cwd / "results/basins.csv")
    assert column(table, "x").tolist() == [-9, -9, 0, 0, 4, 4]
    assert column(table, "label").tolist() == np.ravel(result.labels).tolist()
    plane = "--plane x -9 9 3 x_dot -9 9 3"
    for given, fault in (
        (values[:4], f"{plane}: must be left out if --first-values is given; use --axes NAME NAME"),
        (["--axes", "x", "x_dot"], "--axes x x_dot: must be left out if --plane is given, which"),
    ):
        done = tool("basins", *point, *plane.split(), *given)
        assert done.status == 2
        assert fault in done.faults[0]


def test_random_states(tool):
    """Random states are those of the function with the same seed; another seed gives others."""
    options = "--r 1.04 --clearance 14 --states 30 --seed 5"
    assert tool("basins", *SYSTEM, *options.split()).status == 0
    result = vi.basins(EQUAL, 1.04, 14.0, states=30, rng=5)
    table = rows(tool.cwd / "results/basins.csv")
    assert column(table, "x").tolist() == result.states[1].tolist()
    assert column(table, "label").tolist() == result.labels.tolist()
    done = tool("basins", "results/basins.csv", "--plot", "-o", "again")
    assert b"basins: random states have no picture\n" in done.out
    assert list(contents(tool.cwd / "again")) == ["basins.csv"]
    assert tool("basins", *SYSTEM, *options.split()[:-1], "6", "-o", "six").status == 0
    assert column(rows(tool.cwd / "six/basins.csv"), "x").tolist() != result.states[1].tolist()


@pytest.mark.parametrize(("words", "fault"), [
    (["basins", *SYSTEM, "--r", "1", "--clearance", "9"], "--plane: must be given"),
    (["basins", *SYSTEM, "--r", "1", "--clearance", "9", "--plane", *"abcdefgh"], "--plane"),
    (["basins", *SYSTEM, "--r", "1", "--clearance", "-9", "--plane", *["x", "0", "1", "9", "y", "0", "1", "9"]],
     "--clearance -9.0: must be a number with 1e-12 <="),
    (["bifurcation", *SYSTEM, "--parameter", "r", "--values", "1", "2", "5"], "--clearance: must be given"),
    (["bifurcation", *SYSTEM, "--r", "1", "--parameter", "clearance", "--values", "1", "2", "5", "--states", "3"],
     "--states 3: must be left out: it requires --sweep states"),
    (["lyapunov", *SYSTEM, "--r", "1", "2", "--clearance", "9"], "--r 1 2: must be a number, or LOW HIGH N"),
    (["lyapunov", *SYSTEM, "--r", "1", "--clearance", "9", "--state", "0", "1", "7", "0"],
     "--state 0 1 7 0: must have -1e100 <= Z <= 1e100; z - x must be within half the clearance"),
    (["response", *SYSTEM, "--r", "1", "2", "3", "--clearance", "-9"], "--clearance -9: must be"),
    (["response", *SYSTEM, "--r", "1", "2", "3"],
     "--clearance: must be given, or a namelist file instead of the options; it must be a number with"),
    (["response", "--r", "1", "2", "3"], "--xi: must be given, or a namelist file"),
    (["response", "case.nml", "--states", "3"], "--states: must be left out if a namelist file is given"),
])  # fmt: skip
def test_bad_input_is_named(tool, words, fault):
    """Invalid input is repeated as typed; nothing is written."""
    done = tool(*words)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert f"vibroimpact {words[0]}: " in done.faults[0]
    assert fault in done.faults[0]
    assert list(contents(tool.cwd)) == []


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_file_does_not_stop_the_others(name, tool):
    """A file with an error is named, with status 2, and the others run."""
    write(tool.cwd / "case.nml", kinds()[name])
    write(tool.cwd / "other.nml", kinds()["equispaced"])
    write(tool.cwd / "bad.nml", kinds()[name].replace("xi = ", "xi = -"))
    done = tool(name, "other.nml", "bad.nml", "nope.nml", "case.nml", "case.nml", "--quiet")
    assert (done.status, done.out, len(done.faults)) == (2, b"", 4)
    starts = (f"other.nml: must contain a group &{name}", "bad.nml:", "nope.nml: cannot be read",
              "case.nml: &output name = 'case': is already the name of another case")  # fmt: skip
    for line, start in zip(done.faults, starts, strict=True):
        assert line.startswith(start)
    assert list(contents(tool.cwd / "results")) == ["case.csv"]


@pytest.mark.parametrize("name", CASES)
def test_an_input_is_not_overwritten(name, tool):
    """A table does not replace a namelist of the same name; a table may be run onto itself."""
    text = kinds()[name]
    write(tool.cwd / "case.csv", text)
    done = tool(name, "case.csv", "-o", ".")
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert (
        "case.csv: &output name = 'case': its result would overwrite this input" in done.faults[0]
    )
    assert contents(tool.cwd) == {"case.csv": text.encode()}


@pytest.mark.parametrize("line", ["--clearance 72", "--clearance 72 80 2"])
def test_lyapunov_without_impacts_says_so(line, tool):
    """Without impacts there is a message, and a second line with an option that helps; the test tries it."""
    point = ["--r", "1.04", *line.split(), "--cycles", "400", "--discard", "50"]
    done = tool("lyapunov", *SYSTEM, *point)
    n = 1 if line.endswith("72") else 2
    points = "1 of 1 point" if n == 1 else "2 of 2 points"
    assert (done.status, done.out) == (1, b"")
    assert done.faults == [
        f"lyapunov: no exponents at {points}: no impacts in a batch",
        "vibroimpact lyapunov: another initial state may lead to impacts: --state X X_DOT Z Z_DOT",
    ]
    assert list(contents(tool.cwd)) == []
    head = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
    write(tool.cwd / "far.nml", head + "&lyapunov clearance = 72, cycles = 400, discard = 50 /\n")
    from_file = tool("lyapunov", "far.nml")
    assert from_file.faults == ["far: no exponents at 1 of 1 point: no impacts in a batch"]
    done = tool("lyapunov", *SYSTEM, *point, "--state", "0", "6", "0", "9")
    assert (done.status, done.err) == (0, b"")
    start = {"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9}
    result = vi.lyapunov(EQUAL, 1.04, np.linspace(72, 80, 2)[:n], 400, start, discard=50)
    table = rows(tool.cwd / "results/lyapunov.csv")
    assert column(table, "exponent_1").tolist() == result.per_cycle[0].tolist()


#: Options for a second of work each, or several: they are interrupted.
LONG = {
    "lyapunov": ["--r", "1.04", "--clearance", "10", "24", "150"],
    "bifurcation": ["--r", "1.04", "--parameter", "clearance", "--values", "50", "75", "900"],
    "response": ["--r", "1", "1.02", "300", "--inverse-clearance", "0.03"],
    "basins": ["--r", "0.94", "--clearance", "37",
               "--plane", "x", "-30", "30", "199", "x_dot", "-30", "30", "199"],
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize("name", LONG)
def test_bar_and_interrupt_on_a_terminal(name, tool):
    """The bar never decreases; Ctrl-C leaves a table of the finished part, which is an input, with status 1."""
    # half way, something is finished in any order of the work
    status, output = on_terminal(tool.cwd, name, *SYSTEM, *LONG[name], stop=r"\[#{15}")
    assert status == 1
    assert len(bars(output)) > 5
    assert bars(output) == sorted(bars(output))
    assert f"\r{name} [" in output
    assert " s left " in output
    kept = f"interrupted; finished results are kept: results/{name}.csv"
    assert output.splitlines()[-1].endswith(f"vibroimpact {name}: {kept}")
    assert list(contents(tool.cwd / "results")) == [f"{name}.csv"]
    assert len(rows(tool.cwd / "results" / f"{name}.csv")) > 1
    assert [case.kind for case in vi.read_namelist(tool.cwd / "results" / f"{name}.csv")] == [name]
    assert f"vibroimpact {name}: interrupted; writing what is finished ..." in output
    lines = (tool.cwd / "results" / f"{name}.csv").read_text().splitlines()
    (cut,) = (line for line in lines if line.startswith("# ! cut short: "))
    n, asked = map(
        int, re.match(r"# ! cut short: (\d+) of (\d+) (?:states|simul|points)", cut).groups()
    )
    assert 0 < n < asked
    table = rows(tool.cwd / "results" / f"{name}.csv")
    if name == "basins":
        assert (n, asked) == ((column(table, "label") != -2).sum(), 199**2)
        assert not any("disc" in line or "exponent" in line for line in lines if line[0] == "#")
    elif name == "bifurcation":
        assert asked == 1800
    else:
        assert (n, asked) == (len(table), {"lyapunov": 150, "response": 300}[name])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
@pytest.mark.parametrize("name", LONG)
def test_what_was_cut_short_says_so(name, tool):
    """A loaded partial result is marked as cut short, also in its repr; its numbers are those of the part."""
    words = (name, *SYSTEM, *LONG[name], "--format", "json")
    assert on_terminal(tool.cwd, *words, stop=r"\[#{15}")[0] == 1
    result = vi.load(tool.cwd / f"results/{name}.json")
    assert not result.complete
    assert f"; cut short, {result.cut}>" in repr(result)
    data = json.loads(result.to_json())
    assert data["cut"] == result.cut
    if name == "basins":
        reached = result.labels[result.labels != -2]
        shares = [(reached == i).mean() for i in range(len(result.attractors))]
        assert result.fractions.tolist() == pytest.approx(shares, rel=1e-12)
        with pytest.raises(
            vi.errors.ParameterError, match=r"must be the whole plane .*; cut short"
        ):
            result.integrity(0)
    if name == "bifurcation":
        ends = result.values.searchsorted([window[1:3] for window in result.windows])
        for window, (low, high) in zip(result.windows, ends.tolist(), strict=True):
            beside = result.status[result.runs.index(window.run), max(0, low - 1) : high + 2]
            assert (beside == 0).all()


#: Slow the disk so that a partial file exists until an interrupt.
SLOW_DISK = """
import pathlib, time
def write_bytes(path, content):
    with path.open("wb") as file:
        file.write(content[: len(content) // 2])
        file.flush()
        time.sleep(60)
pathlib.Path.write_bytes = write_bytes
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
def test_a_second_interrupt_stops_writing(tool):
    """A second interrupt stops the writing with one line, and leaves no partial file."""
    words = ("response", *SYSTEM, *LONG["response"], "--format", "json")
    status, output = on_terminal(
        tool.cwd, *words, stop=r"\[#{15}", again="results/*.part", more=SLOW_DISK
    )
    message = [line.rpartition("\r")[2] for line in output.splitlines() if "vibroimpact " in line]
    assert (status, message) == (1, [
        "vibroimpact response: interrupted; writing what is finished ...",
        "vibroimpact response: interrupted; writing was stopped, no incomplete file is left",
    ])  # fmt: skip
    assert not (tool.cwd / "results").exists()


#: Each would take hours to compute.
ENDLESS = {
    "lyapunov": ["--r", "1.04", "--clearance", "20", "--cycles", "1000000000"],
    "basins": ["--r", "0.94", "--clearance", "37", "--states", "9000000"],
    "find": ["--r", "0.94", "--clearance", "37", "--max-impacts", "12", "--max-cycles", "8"],
    "zone": ["--sides", "RL", "--r", ".9", "1.1", "--clearance", "5", "90", "--lines", "129", "--plot"],
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_the_place_is_tested_first(name, tool):
    """A folder without write permission is refused first: one line, status 2, nothing computed or left."""
    (tool.cwd / "taken").write_text("mine")
    done = tool(name, *SYSTEM, *ENDLESS[name], "-o", "taken")
    output = f"vibroimpact {name}: -o taken: taken is a file; must be a folder"
    assert (done.status, done.out, done.faults) == (2, b"", [output])
    (tool.cwd / "closed").mkdir(mode=0o555)
    done = tool(name, *SYSTEM, *ENDLESS[name], "-o", "closed", preexec_fn=bound_by_permissions)
    must = "the folder and the disk must be writable"
    output = f"vibroimpact {name}: closed: Permission denied; {must}"
    assert (done.status, done.out, done.faults) == (2, b"", [output])
    assert contents(tool.cwd) == {"taken": b"mine"}
