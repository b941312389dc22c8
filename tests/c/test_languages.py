"""The examples of docs/languages print the same rows in every language installed here."""

import csv
import shutil
import subprocess

import pytest
import vibroimpact as vi
from installed_library import ROOT, call

EXAMPLES = ROOT / "docs/languages"
CASE = (
    "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
    "&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, states = 6 /\n"
)


def need(program, name):
    if shutil.which(program) is None:
        pytest.skip(f"no {name} on this machine")


@pytest.fixture(scope="module")
def rows(installed, tmp_path_factory):
    """The rows that each example must print, from the CSV of the program."""
    folder = tmp_path_factory.mktemp("rows")
    (folder / "case.nml").write_text(CASE)
    call(installed.program, "case.nml", "-o", ".", cwd=folder)
    lines = (folder / "case.csv").read_text().splitlines()
    table = list(csv.DictReader(line for line in lines if line[0] != "#"))
    assert len(table) == 5
    return "".join(
        f"{float(row['r']):.2f} {float(row['lowest']):.10f} {float(row['highest']):.10f}\n"
        for row in table
    )


def test_c(installed, rows, tmp_path):
    program = installed.compile(
        EXAMPLES / "response.c", tmp_path / "response", "-std=c99", "-Wall", "-Wextra", "-Werror"
    )
    assert call(program) == rows
    assert rows in (ROOT / "docs/howto/languages.md").read_text(encoding="utf-8")


def test_structure(installed, tmp_path):
    """The impacts printed by C are those of the call in Python."""
    source = EXAMPLES / "structure.c"
    program = installed.compile(source, tmp_path / "s", "-std=c99", "-Wall", "-Wextra", "-Werror")
    printed = call(program)
    gaps = [vi.Gap([-1, 1], 0.5, 0.8), vi.Gap([1, -1], 0.5, 0.8)]
    host = vi.Structure([1, 0.1], [0.02, 0], [1, 0], gaps)
    events = vi.simulate(host, vi.Load(1.04, sine=[0.1, 0]), cycles=4).events
    wanted = [f"{row['time']:.10f} {row['gap']} {row['speed']:.10f}" for row in events]
    assert printed.splitlines() == wanted
    assert printed in (ROOT / "docs/howto/structures.md").read_text(encoding="utf-8")


def test_c_plus_plus(installed, rows, tmp_path):
    need("c++", "C++ compiler")
    strict = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    source = EXAMPLES / "response.cpp"
    program = installed.compile(source, tmp_path / "response", *strict, compiler="c++")
    assert call(program) == rows


def test_fortran(installed, rows, tmp_path):
    source, strict = EXAMPLES / "response.f90", ["-std=f2018", "-Wall", "-Werror"]
    program = installed.compile(source, tmp_path / "response", *strict, compiler="gfortran")
    assert call(program) == rows


def test_cmake(installed, rows, tmp_path):
    need("cmake", "CMake")
    where = f"-DCMAKE_PREFIX_PATH={installed.prefix}"
    call("cmake", "-S", EXAMPLES, "-B", tmp_path, where)
    call("cmake", "--build", tmp_path)
    assert call(tmp_path / "response") == rows


@pytest.mark.slow
def test_octave(installed, rows, tmp_path):
    """The MEX function for Octave and MATLAB gives the rows; a wrong case raises its message as an error."""
    need("octave-cli", "Octave")
    need("mkoctfile", "Octave")
    where = [f"-Wl,-rpath,{installed.libdir}", *installed.flags]
    call("mkoctfile", "--mex", EXAMPLES / "vibroimpact.c", *where, cwd=tmp_path)
    octave = ["octave-cli", "--no-gui", "--quiet", "--norc"]
    assert call(*octave, EXAMPLES / "response.m", cwd=tmp_path) == rows
    wrong = "vibroimpact('&system xi = 3 /')"
    done = subprocess.run([*octave, "--eval", wrong], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode != 0
    assert "&system: no &motion" in done.stderr
    # words, owners, complex numbers and several values in a row
    message = call(
        *octave, "--eval",
        "m = vibroimpact(['&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /' 10 "
        "'&motion sides = ''RL'', phases_over_pi = 0, 1.37 /' 10]); "
        "disp(iscomplex(m.motions.multipliers)); disp(m.impacts.owners'); disp(m.motions.sides{1})",
        cwd=tmp_path,
    )  # fmt: skip
    assert message.split() == ["1", "1", "1", "RL"]


@pytest.mark.slow
def test_julia(installed, rows, tmp_path):
    need("julia", "Julia")
    example = EXAMPLES / "response.jl"
    assert call("julia", "--startup-file=no", example, env=installed.environment()) == rows
