"""The commands simulate and plot, against the API and `run`."""

import json
import sys

import pytest
import vibroimpact as vi
from programs import (
    INPUTS,
    PAIR,
    POINT,
    SYSTEM,
    Runner,
    bars,
    contents,
    find_command,
    floats,
    motions,
    on_terminal,
    rows,
    write,
)
from vibroimpact.cases.case import read_namelist

SIMULATION = SYSTEM + "&simulate clearance = 37, cycles = 20, x = 3.5, z_dot = -2 /\n"
MAGIC = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


@pytest.fixture
def no_matplotlib(tmp_path_factory):
    """An environment in which matplotlib cannot be imported."""
    folder = tmp_path_factory.mktemp("path")
    write(folder / "matplotlib.py", "raise ImportError('not here')\n")
    return {"PYTHONPATH": str(folder), "PATH": ""}


#: test_batch_chart.py, test_batch_studies.py and test_batch_attractors.py compare those of other studies.
COMPARED = ("simulate", "periodic", "equispaced", "exact")


@pytest.mark.parametrize(
    "path",
    [path for path in INPUTS if any(case.kind in COMPARED for case in read_namelist(path))],
    ids=lambda path: path.stem,
)
def test_cases_are_those_that_run(path, tmp_path):
    """Cases that Python reads from a file have the digits that running the file writes."""
    results = {item.stem: item for item in vi.run_namelists([path], tmp_path).results}
    cases = read_namelist(path)
    assert [case.name for case in cases if not case.in_python] == list(results)
    for case in cases:
        if case.kind == "simulate":
            (run,) = case.run()
            in_units = not case.structure and run.osc.F0 is not None
            table, events = rows(results[case.name]), run.events
            assert len(table) == len(events)
            numbers = ("speed", "impulse") if case.structure else ("x", "z_dot_after")
            for key in ("time", *numbers):
                wanted = run.physical("mm N s").events[key] if in_units else events[key]
                assert [float(row[key]) for row in table] == pytest.approx(
                    wanted.tolist(), rel=1e-13 if in_units else 0, abs=1e-11 if in_units else 0
                )
            continue
        if case.kind not in COMPARED:
            continue
        table, found = motions(results[case.name]), case.motions()
        assert len(table) == len(found)
        for row, motion in zip(table, found, strict=True):
            assert floats(row, "x") == motion.X.tolist()
            assert floats(row, "phase") == motion.alpha.tolist()
            assert floats(row, "restitution") == motion.restitution.tolist()
            assert row["stable"][0] == str(motion.stable).lower()


def test_cases_of_a_result_are_the_same(tmp_path):
    """A result read as an input gives the case that produced it."""
    write(tmp_path / "case.nml", SIMULATION)
    (result,) = vi.run_namelists([tmp_path / "case.nml"], tmp_path).results
    assert read_namelist(result) == read_namelist(tmp_path / "case.nml")


def test_long_lists_are_read_whole(tmp_path):
    """A list written with repeats, which is far longer than the file, is read completely."""
    n = 1000
    text = (
        f"{SYSTEM}&motion sides = '{'RL' * (n // 2)}', cycles = 500, impact_restitution = {n}*0.5\n"
        f"phases = {', '.join(map(str, range(n)))} /\n"
    )
    (case,) = read_namelist(write(tmp_path / "long.nml", text * 40))[:1]
    assert case.keys["impact_restitution"] == [0.5] * n
    assert case.keys["phases"] == list(range(n))


def test_simulate_writes_what_run_writes(tool):
    """`simulate` writes the bytes of `run`, and runs only the simulations of a file with other cases."""
    write(tool.cwd / "mixed.nml", PAIR + SIMULATION)
    assert tool("run", "mixed.nml", "-o", "run").status == 0
    done = tool("simulate", "mixed.nml", "-o", "simulate")
    assert (done.status, done.err) == (0, b"")
    every = contents(tool.cwd / "run")
    assert sorted(every) == ["mixed_1.csv", "mixed_2.csv"]
    assert contents(tool.cwd / "simulate") == {"mixed_2.csv": every["mixed_2.csv"]}


def test_options_of_a_simulation_are_a_namelist(tool):
    """Options give the bytes of the same case in a file; errors use the words of the options."""
    options = [*POINT, "--cycles", "20", "--state", "3.5", "0", "0", "-2"]
    assert tool("simulate", *options).status == 0
    write(tool.cwd / "simulate.nml", SIMULATION)
    assert tool("run", "simulate.nml", "-o", "run").status == 0
    assert contents(tool.cwd / "results") == contents(tool.cwd / "run")
    for form in ("csv", "json"):
        done = tool("simulate", *options[:-2], "30", "-2", "--format", form)
        assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
        assert done.faults[0].startswith("vibroimpact simulate: --state 3.5 0 30 -2: must have ")
    done = tool("simulate", *POINT)
    assert done.faults == [
        "vibroimpact simulate: --cycles: must be given, or a namelist file instead of the options; it must be "
        "a number of load cycles with 0 <= cycles <= 1e9"
    ]


@pytest.mark.parametrize(("words", "kind"), [
    (["--plot", "case.nml"], "png"), (["case.nml", "--plot"], "png"), (["case.nml", "--plot", "pdf"], "pdf"),
    (["--plot", "svg", "case.nml"], "svg"), (["--plot=svg", "case.nml"], "svg")])  # fmt: skip
def test_simulate_draws(words, kind, tool):
    """--plot, anywhere among the arguments, adds a picture of its format to the table."""
    write(tool.cwd / "case.nml", SIMULATION)
    done = tool("simulate", *words)
    assert (done.status, done.err) == (0, b"")
    found = contents(tool.cwd / "results")
    assert sorted(found) == ["case.csv", f"case.{kind}"]
    assert found[f"case.{kind}"].startswith(MAGIC[kind])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs a terminal of POSIX")
def test_bar_of_a_simulation(tool):
    """The bar of a simulation gives the time left, also with --plot, and includes the discarded cycles."""
    write(
        tool.cwd / "case.nml", SIMULATION.replace("cycles = 20", "cycles = 9000, discard = 90000")
    )
    status, output = on_terminal(tool.cwd, "simulate", "case.nml", "--plot")
    assert status == 0
    assert " s left " in output
    assert len(set(bars(output))) > 2
    assert bars(output) == sorted(bars(output))


def test_simulation_of_no_time_is_drawn(tool):
    """A trajectory with a single instant is drawn without an error."""
    write(tool.cwd / "case.nml", SIMULATION.replace("cycles = 20", "cycles = 0"))
    assert tool("simulate", "case.nml", "--plot").status == 0


def test_simulate_says_what_is_missing(tool):
    """A file without &simulate is named in a message, and the other files run."""
    write(tool.cwd / "pair.nml", PAIR)
    write(tool.cwd / "case.nml", SIMULATION)
    done = tool("simulate", "pair.nml", "case.nml")
    assert done.status == 2
    assert done.faults == ["pair.nml: must contain a group &simulate; there is none"]
    assert list(contents(tool.cwd / "results")) == ["case.csv"]


def test_simulation_cut_short_is_drawn_too(tool):
    """A simulation cut short has status 1, with a table and a picture of its events so far."""
    write(tool.cwd / "case.nml", SIMULATION.replace("cycles", "max_events = 9, cycles"))
    assert tool("simulate", "case.nml", "--plot").status == 1
    assert sorted(contents(tool.cwd / "results")) == ["case.csv", "case.png"]


@pytest.mark.parametrize("words", [["simulate", "case.nml", "--plot"], ["plot", "case.nml"]])
def test_missing_matplotlib(words, tool, no_matplotlib):
    """If matplotlib is missing the extra is named before anything runs; tables do not need it."""
    write(tool.cwd / "case.nml", SIMULATION)
    done = tool(*words, env=no_matplotlib)
    assert (done.status, done.out, len(done.faults)) == (1, b"", 1)
    assert "pip install 'vibroimpact[plot]'" in done.faults[0]
    assert list(contents(tool.cwd)) == ["case.nml"]
    assert tool("simulate", "case.nml", env=no_matplotlib).status == 0


def test_pipe(tool):
    """A pipe, which can be read only once, is simulated and drawn."""
    done = tool("simulate", "/dev/stdin", "--plot", input=SIMULATION.encode())
    assert (done.status, done.err) == (0, b"")
    assert sorted(contents(tool.cwd / "results")) == ["stdin.csv", "stdin.png"]


def test_plot_draws_every_case(tool):
    """`plot` draws one picture for each motion and simulation."""
    equispaced = "&motion kind = 'equispaced', clearance = 37 /\n&output name = 'pair' /\n"
    write(tool.cwd / "case.nml", SIMULATION + "&output name = 'run' /\n" + equispaced)
    write(tool.cwd / "single.nml", PAIR)
    done = tool("plot", "case.nml", "single.nml", "--format", "svg", "-o", "out")
    assert (done.status, done.err) == (0, b"")
    found = contents(tool.cwd / "out")
    assert sorted(found) == ["pair_1.svg", "pair_2.svg", "run.svg", "single.svg"]
    assert all(picture.startswith(MAGIC["svg"]) for picture in found.values())


def test_faults_of_plot_are_in_the_document(tool):
    """The JSON document has the errors of `plot`; a result folder that stays empty is removed."""
    write(tool.cwd / "case.nml", SYSTEM + "&motion kind = 'equispaced', clearance = 200 /\n")
    document = json.loads(tool("plot", "case.nml", "--json").out)
    assert document["faults"] == ["case: there is no such motion for these parameters"]
    assert (document["status"], document["files"]) == (1, [])
    assert list(contents(tool.cwd)) == ["case.nml"]


@pytest.mark.parametrize("form", ["csv", "json"])
def test_simulation_cut_short_in_what_is_discarded(form, tool):
    """A simulation cut short during the discarded cycles has status 1 in every form; the limit is an option."""
    write(
        tool.cwd / "case.nml", SIMULATION.replace("cycles", "max_events = 9, discard = 90, cycles")
    )
    done = tool("simulate", "case.nml", "--format", form)
    assert (done.status, len(done.faults)) == (1, 1)
    assert done.faults[0].startswith("case: ")
    assert "max_events" in done.faults[0]
    start = ["--cycles", "90", "--state", "3.5", "0", "0", "-2"]
    assert tool("simulate", *POINT, *start, "--max-events", "9").status == 1
    assert (tool.cwd / "results/simulate.csv").read_text().count(",impact,") == 9


def test_plot_of_what_is_cut_short(tool):
    """What fails is reported beside the picture of the rest."""
    write(tool.cwd / "case.nml", SIMULATION.replace("cycles", "max_events = 9, cycles"))
    done = tool("plot", "case.nml")
    assert (done.status, done.faults) == (1, ["case: cut short, max_events was reached"])
    assert list(contents(tool.cwd / "results")) == ["case.png"]


def test_plot_of_what_is_not_there(tool):
    """A motion that does not exist gives status 1, and the others are drawn; a repeated name gives status 2."""
    nothing = SYSTEM + "&motion kind = 'equispaced', clearance = 200 /\n"
    write(tool.cwd / "case.nml", nothing + PAIR)
    done = tool("plot", "case.nml")
    assert done.status == 1
    assert done.faults == ["case_1: there is no such motion for these parameters"]
    assert list(contents(tool.cwd / "results")) == ["case_2.png"]
    random = "&basins clearance = 37, states = 4, seed = 1 /\n"
    write(tool.cwd / "random.nml", SYSTEM + random)
    done = tool("plot", "random.nml", "case.nml")
    assert done.status == 1
    assert done.faults[0] == "random: random states have no picture"
    assert list(contents(tool.cwd / "results")) == ["case_2.png"]
    write(tool.cwd / "other.nml", PAIR + "&output name = 'case_2' /\n")
    done = tool("plot", "case.nml", "other.nml")
    assert done.status == 2
    assert "other.nml: &output name = 'case_2': " in done.faults[-1]


@pytest.mark.slow
def test_pictures_are_drawn_from_the_motion(tmp_path):
    """One case gives the same bytes every time, and a different case another picture."""
    pictures = []
    for clearance in (37, 36):
        run = Runner([find_command()], tmp_path)
        text = SYSTEM + f"&motion kind = 'equispaced', clearance = {clearance} /\n"
        write(tmp_path / "case.nml", text)
        assert run("plot", "case.nml", "--format", "svg").status == 0
        pictures.append((tmp_path / "results/case_1.svg").read_bytes())
        assert run("plot", "case.nml", "--format", "svg").status == 0
        assert (tmp_path / "results/case_1.svg").read_bytes() == pictures[-1]
    assert pictures[0] != pictures[1]


def test_simulate_animates(tool):
    """--animate writes an animation and the table, and no picture without --plot."""
    write(tool.cwd / "case.nml", SIMULATION.replace("cycles = 20", "cycles = 0.1"))
    done = tool("simulate", "case.nml", "--animate", "gif")
    assert (done.status, done.err) == (0, b"")
    found = contents(tool.cwd / "results")
    assert sorted(found) == ["case.csv", "case.gif"]
    assert found["case.gif"].startswith(b"GIF89a")
    assert done.files == ("results/case.csv", "results/case.gif")


def test_simulate_without_ffmpeg_writes_nothing(tool):
    """Without ffmpeg the message about it comes before any computation, and nothing is written."""
    write(tool.cwd / "case.nml", SIMULATION)
    done = tool(
        "simulate", "case.nml", "--animate", "mp4", env={"PATH": "", "IMAGEIO_FFMPEG_EXE": "none"}
    )
    assert done.status == 1
    assert "ffmpeg" in done.faults[0]
    assert not (tool.cwd / "results").exists()
