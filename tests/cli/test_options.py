"""Options and messages about them: short, and in the words typed."""

import os
import signal
import subprocess
import sys

import pytest
import vibroimpact as vi
from programs import PAIR, SYSTEM, contents, find_command, write
from vibroimpact.commands.command import main

EQUAL = ["--xi", ".0114", "--mu", ".028", "--restitution", ".75"]


@pytest.mark.parametrize(
    "group", ["zone sides = 'RL',", "atlas", "chart sides = 'RL', r_points = 3,"]
)
def test_reversed_windows_name_both_ends(group, batch):
    """The message about a reversed window gives both ends."""
    window = f"&{group} r_min = 1.2, r_max = 0.8, clearance_min = 2, clearance_max = 200 /\n"
    done = batch.case("&system xi = 0.1, mu = 0.1, restitution = 0.7 /\n" + window)
    assert (done.status, len(done.faults)) == (2, 1)
    assert "r_max = 0.8" in done.faults[0]
    assert "; r_min is 1.2" in done.faults[0]
    done = batch.case("&system xi = 0.1, mu = 0.1, restitution = 0.7 /\n" + window.replace("1.2", "0.7", 1)
                      .replace("= 200", "= 1"))  # fmt: skip
    assert "clearance_max = 1" in done.faults[0]
    assert "; clearance_min is 2" in done.faults[0]


@pytest.mark.parametrize("text", [
    "x" * 100_000, "&system xi = " + "7" * 100_000 + " /\n&simulate /\n", "&" + "q" * 50_000 + " /\n",
    SYSTEM + "&motion sides = 'R" + "L" * 30_000 + "' /\n", "&system mu = '" + "v" * 100_000])  # fmt: skip
def test_a_long_line_is_not_echoed(text, batch):
    """The message gives the error, the file and the beginning of the line."""
    done = batch.case(text)
    assert (done.status, len(done.faults)) == (2, 1)
    assert len(done.err) < 700
    assert done.faults[0].startswith("case.nml:")
    assert (
        text[:10] in done.faults[0] or "sides = 'RLLL" in done.faults[0] or "mu" in done.faults[0]
    )


def test_plane_outside_of_the_walls(tool):
    """A plane beyond the walls is refused, with the range of y."""
    plane = ["--plane", "x", "-9", "9", "5", "y", "-9", "8", "5"]
    done = tool("basins", *EQUAL, "--r", "1", "--clearance", "9", *plane)
    assert (done.status, len(done.faults)) == (2, 1)
    wanted = (
        "two numbers from -1e100 to 1e100, one for each axis, and low below high; "
        "y must be within half the clearance"
    )
    assert done.faults == [f"vibroimpact basins: --plane x -9 9 5 y -9 8 5: must be {wanted}"]


@pytest.mark.parametrize("threads", [0, -1, 1025, 1.5, True])
def test_threads_of_an_atlas(threads):
    """`threads` of an atlas must be a whole number from 1."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    with pytest.raises(
        (vi.errors.ParameterError, vi.errors.ParameterTypeError), match="threads = "
    ):
        vi.atlas(osc, (1.0, 1.1), (20, 60), threads=threads)


@pytest.mark.parametrize(("words", "output"), [
    ("basins --r 1.04 --clearance 9", "--plane: must be given, or a namelist file instead of the options"),
    ("basins --r 1.04 --clearance 9 --states 9 --plane x 0 1 2 y 0 1 2",
     "--plane x 0 1 2 y 0 1 2: must be left out if --states is given: it applies only to a plane"),
    ("basins --r 1.04 --clearance 9 --states 9 --plot", "--plot png: must be used with --plane"),
    ("lyapunov --r 1 1.05 3 --clearance 9 12 5", "--r, --clearance: one of them must be a number"),
    ("response --r 1.05 1 3 --clearance 9",
     "--r 1.05 1 3: must have 1e-6 <= HIGH <= 1e6, and LOW below HIGH; LOW is 1.05"),
    ("response --r 1 nan 3 --clearance 9", "--r 1 nan 3: must have 1e-6 <= HIGH <= 1e6"),
    ("response --r 1 1.05 inf --clearance 9", "--r 1 1.05 inf: must be a whole number with 2 <= N <= 1000000"),
    ("lyapunov --r 1 2 --clearance 9", "--r 1 2: must be a number, or LOW HIGH N"),
    ("basins --r 1.04 --clearance 9 --plane x 0 1 2 y 1 0 2",
     "--plane x 0 1 2 y 1 0 2: must be two numbers from -1e100 to 1e100, one for each axis, and low below "
     "high"),
    ("bifurcation --r 1 --parameter clearance --values 9 9 3",
     "--values 9 9 3: must be a number in the range of the parameter"),
    ("branch --r .9 --clearance 9 --sides RRL --parameter r --bounds .8 1",
     "--sides RRL: must be used with --phases"),
    ("branch --restitution .7 .6 --r .9 --clearance 9 --parameter r --bounds .8 1",
     "--restitution 0.7 0.6: must be the same for both walls, or be used with --sides and --phases-over-pi"),
])  # fmt: skip
def test_options_that_do_not_go_together(words, output, tmp_path, monkeypatch, capsys):
    """Incompatible options are refused by name, before anything is computed."""
    monkeypatch.chdir(tmp_path)
    name, *others = words.split()
    assert main([name, *["--xi", ".0114", "--mu", ".028", "--restitution", ".75"], *others]) == 2
    assert capsys.readouterr().err.startswith(f"vibroimpact {name}: {output}")
    assert list(tmp_path.iterdir()) == []


def test_wrong_format_of_a_picture(tmp_path, monkeypatch, capsys):
    """An invalid format of a picture is reported as such, and not as a missing namelist file."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main(["zone", "case.nml", "--plot", "gif"])
    assert ended.value.code == 2
    assert "argument --plot: invalid choice: 'gif'" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "missing", "output"), [
    ("--format netcdf", "xarray", "netCDF files need xarray: pip install 'vibroimpact[data]'"),
    ("--format netcdf", "h5netcdf", "netCDF files need h5netcdf: pip install 'vibroimpact[data]'"),
    ("--format matlab", "scipy", "MATLAB files need scipy: pip install 'vibroimpact[matlab]'"),
    ("--plot", "matplotlib", "pictures need matplotlib: pip install 'vibroimpact[plot]'"),
])  # fmt: skip
def test_missing_extra_is_told_before_work(words, missing, output, tmp_path, monkeypatch, capsys):
    """A missing extra for the result is reported before the computation."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "meta_path", [Absent(missing), *sys.meta_path])
    for name in [name for name in sys.modules if name.split(".")[0] == missing]:
        monkeypatch.delitem(sys.modules, name)
    point = "--xi .0114 --mu .028 --restitution .75 --r 1.04 --clearance 20 --cycles 1000000000"
    assert main(["lyapunov", *point.split(), *words.split()]) == 1
    assert capsys.readouterr().err == f"vibroimpact lyapunov: {output}\n"
    assert list(tmp_path.iterdir()) == []


class Absent:
    """A library that is not installed."""

    def __init__(self, name):
        self.name = name

    def find_spec(self, name, path=None, target=None):
        """Return None, as for a module that does not exist."""
        if name.split(".")[0] == self.name:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def test_folder_that_cannot_be_made(tmp_path, monkeypatch, capsys):
    """The message gives the option, the reason, and what is allowed."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    point = "--xi .0114 --mu .028 --restitution .75 --r 1.04 --clearance 20 --cycles 80"
    assert main(["lyapunov", *point.split(), "-o", "file/x"]) == 2
    output = capsys.readouterr().err
    assert output == "vibroimpact lyapunov: -o file/x: file is a file; must be a folder\n"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
@pytest.mark.parametrize("words", ["completion bash", "doctor", "init --list"])
def test_output_on_a_full_disk(words, tool):
    """Output on a full disk gives one line and status 1, without a traceback."""
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            [find_command(), *words.split()], stdout=full, stderr=subprocess.PIPE, text=True, cwd=tool.cwd
        )  # fmt: skip
    name = words.split()[0]
    assert done.returncode == 1
    assert done.stderr == f"vibroimpact {name}: standard output: No space left on device\n"


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
@pytest.mark.parametrize("form", ["csv", "json", "netcdf", "matlab"])
def test_result_on_a_full_disk(form, tool):
    """The message names the result and what it needs; no partial file is left (a size limit fills the disk)."""
    import resource

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        os.environ["PYTHONDONTWRITEBYTECODE"] = (
            "1"  # Python keeps bytecode files that the limit cut off
        )
        resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))

    plane = [
        "--r",
        "1.04",
        "--clearance",
        "14",
        "--plane",
        "x",
        "-9",
        "9",
        "20",
        "x_dot",
        "-9",
        "9",
        "20",
    ]
    done = subprocess.run(
        [find_command(), "basins", *EQUAL, *plane, "--format", form],
        capture_output=True, text=True, cwd=tool.cwd, preexec_fn=limit,
    )  # fmt: skip
    assert done.returncode == 2
    suffix = {"netcdf": "nc", "matlab": "mat"}.get(form, form)
    # the core writes tables, and detects partial ones by their size
    core = "the disk is full, or the file could not be written completely"
    reason = core if form == "csv" else "File too large"
    output = f"vibroimpact basins: results/basins.{suffix}: {reason}; the folder and the disk must be writable"
    assert done.stderr.startswith(output)
    assert len(done.stderr.splitlines()) == 1
    assert list(tool.cwd.iterdir()) == []


def test_no_command(tool):
    """Without a command all commands are listed with status 2; with --help the same list has status 0."""
    done = tool()
    helped = tool("--help")
    assert (done.status, done.out, helped.status) == (2, b"", 0)
    assert done.err == helped.out


@pytest.mark.parametrize("name", ["lyapunov", "zone", "find"])
def test_help_names_units(name, tool):
    """The help names the units of options and results."""
    assert "time in 1/omega, angles in radians" in tool(name, "--help").out.decode()


@pytest.mark.parametrize("words", [
    ["run", "case.nml"], ["simulate", "case.nml"], ["plot", "case.nml"], ["reproduce", "table1"],
    ["find", "case.nml"],
])  # fmt: skip
@pytest.mark.parametrize("name", ["q.txt", "new/pic.png", "a.h5", "b.JSONL"])
def test_a_name_of_no_form_is_refused(words, name, tool):
    """A file name with an unknown suffix is refused with the allowed ones, and no folder of that name is made."""
    write(tool.cwd / "case.nml", PAIR)
    done = tool(*words, "-o", name)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    forms = ", or a file whose name ends with one of .csv, .nc, .json, .mat"
    allowed = "must be a folder" + (forms if words[0] not in ("plot", "reproduce") else "")
    output = (
        f"vibroimpact {words[0]}: -o {name}: {allowed}; for a folder of this name, write -o {name}/"
    )
    assert done.faults == [output]
    assert list(contents(tool.cwd)) == ["case.nml"]


@pytest.mark.parametrize(
    "name", ["q.txt/", "a.json/", "there.txt", "r0.94", "run.2026-11-21", ".hidden"]
)
def test_folders_with_a_dot(name, tool):
    """Names that end in a slash, names of existing folders, and names unlike those of files are folders."""
    (tool.cwd / "there.txt").mkdir()
    write(tool.cwd / "case.nml", PAIR)
    assert tool("run", "case.nml", "-o", name).status == 0
    assert list(contents(tool.cwd / name)) == ["case.csv"]


@pytest.mark.parametrize("value", [
    "2+1", "2-1", "1e-5000", "1e400", "1_0", "\u0661", "0x10", "1e", "1,5", "1e1.5", ".", "- 1", "1 2", "true",
])  # fmt: skip
@pytest.mark.parametrize("option", ["--clearance", "--r", "--xi"])
def test_forms_of_numbers(option, value, tool):
    """Options take the number formats of namelists; numbers that would become 0 or infinite are refused."""
    done = found_with(tool, option, value)
    assert (done.status, done.out) == (2, b"")
    assert f"{option}: {value}: must be a number" in done.faults[-1] or (
        f"{option} {value}: must be a number" in done.faults[-1]
    )


@pytest.mark.parametrize("value", ["2+1", "1_0", "٣", "1e3", "2.0", "0x10"])
def test_forms_of_whole_numbers(value, tool):
    done = found_with(tool, "--max-impacts", value)
    assert (done.status, done.out) == (2, b"")
    assert f"{value}: must be a whole number" in done.faults[-1]
    assert done.faults[-1].endswith("; see `vibroimpact find --help`")


def found_with(tool, option, value):
    """`vibroimpact find` with one option changed."""
    words = {"--xi": "0.01", "--mu": "0.1", "--r": "0.9", "--clearance": "9"} | {option: value}
    return tool("find", "--restitution", "0.7", *[f"{name}={text}" for name, text in words.items()])


@pytest.mark.parametrize("command", ["identify", "design", "decay"])
def test_studies_without_a_given_frequency_ratio_have_no_option(tool, command):
    """A study without a load, with a band of frequency ratios, or that finds the ratio has no option --r."""
    assert b"--r " not in tool(command, "--help").out
    assert b"--r " in tool("bifurcation", "--help").out
