"""The command find: what it prints, writes in each form, and draws, against the function."""

import json
import math
import re

import numpy as np
import pytest
import vibroimpact as vi
from programs import (
    PAIR,
    POINT,
    SYSTEM,
    assert_same,
    contents,
    floats,
    motions,
    write,
)

LIMITS = ["--max-impacts", "2", "--max-cycles", "1"]
OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)


@pytest.fixture(scope="module")
def found():
    """What the function finds at that point."""
    return vi.find(OSC, 0.94, 37.0, max_impacts=2, max_cycles=1)


def test_find_prints_what_find_finds(tool, found):
    """`find` prints one line for each motion, the same for a file and for options; nothing is written."""
    write(tool.cwd / "pair.nml", SYSTEM + "&motion kind = 'equispaced', clearance = 37 /\n")
    done = tool("find", "pair.nml", *LIMITS)
    assert tool("find", *POINT, *LIMITS) == done
    assert (done.status, done.err) == (0, b"")
    text = done.out.decode()
    moduli = [float(item) for item in re.findall(r"max\|lambda\| = ([\d.]+),", text)]
    assert len(found) == 5
    assert moduli == pytest.approx([abs(motion.multipliers[0]) for motion in found], rel=1e-3)
    assert "".join(text.split()).endswith("".join(str(found.search).split()))
    assert list(contents(tool.cwd)) == ["pair.nml"]


def test_find_at_the_clearance_of_given_phases(tool):
    """A case with phases is searched at the clearance of its motion, and the search finds that motion."""
    write(tool.cwd / "pair.nml", PAIR)
    text = tool("find", "pair.nml", *LIMITS).out.decode()
    motion = vi.periodic(OSC, 0.94, [0, 1.37 * math.pi], vi.Pattern("RL"))
    assert f"clearance = {motion.clearance:.10g}\n" in text
    assert f"{motion.x_max:.6g}" in text


def test_groups_of_their_own(tool, found):
    """A &find case has its own limits, which options override; `run` writes the same table."""
    text = SYSTEM + "&find clearance = 37, max_impacts = {}, max_cycles = 1 /\n"
    write(tool.cwd / "find.nml", text.format(2))
    done = tool("find", "find.nml")
    assert done == tool("find", *POINT, *LIMITS)
    assert done.status == 0
    write(tool.cwd / "find.nml", text.format(3))
    assert tool("find", "find.nml", "--max-impacts", "2") == done
    assert tool("find", "find.nml", *LIMITS, "-o", "one").status == 0
    write(tool.cwd / "find.nml", text.format(2))
    done = tool("run", "find.nml", "-o", "two")
    stable = sum(motion.stable is True for motion in found)
    assert done.out.decode().splitlines()[0] == f"find: {len(found)} motions, {stable} stable"
    assert contents(tool.cwd / "one") == contents(tool.cwd / "two")
    assert list(contents(tool.cwd / "two")) == ["find.csv"]


def test_find_where_there_is_nothing(tool):
    """If no motion is found the status is 1 and no file is written."""
    wide = [
        "--xi",
        "0.3",
        "--mu",
        "0.04",
        "--restitution",
        "0.5",
        "--r",
        "0.9",
        "--clearance",
        "1e6",
    ]
    done = tool("find", *wide, *LIMITS, "-o", "out", "--plot")
    assert (done.status, done.err) == (1, b"")
    assert "no periodic motion was found" in done.out.decode()
    assert list(contents(tool.cwd)) == []
    write(
        tool.cwd / "wide.nml",
        "&system xi = 0.3, mu = 0.04, restitution = 0.5, r = 0.9 /\n"
        "&find clearance = 1e6, max_impacts = 2, max_cycles = 1 /\n",
    )
    done = tool("run", "wide.nml")
    assert (done.status, done.out) == (1, b"")
    assert done.faults == ["wide: no periodic motion was found"]
    assert list(contents(tool.cwd)) == ["wide.nml"]
    write(tool.cwd / "free.nml", PAIR.replace("1.37", "1"))
    done = tool("find", "free.nml")
    assert (done.status, done.out) == (1, b"")
    assert "do not determine the load amplitude" in done.faults[0]


def test_table_of_motions(tool, found):
    """The table has one row for each impact, and its header is the case, which gives the same bytes again."""
    done = tool("find", *POINT, *LIMITS, "-o", "out")
    assert (done.status, done.err) == (0, b"")
    assert done.files == ("out/find.csv",)
    assert list(contents(tool.cwd)) == ["out/find.csv"]
    table = motions(tool.cwd / "out/find.csv")
    assert len(table) == len(found)
    for motion, expected in zip(table, found, strict=True):
        assert_same(motion, expected)
        assert motion["side"] == expected.pattern.symbols
        assert floats(motion, "phase") == expected.alpha.tolist()
    head = [line for line in (tool.cwd / "out/find.csv").read_text().split("\n") if line[:1] == "#"]
    assert head[-1] == f"# ! searched: {found.search}"
    (case,) = vi.read_namelist(tool.cwd / "out/find.csv")
    assert (case.kind, case.osc, case.r) == ("find", OSC, 0.94)
    keys = {"clearance": 37.0, "load": 1.0, "max_impacts": 2, "max_cycles": 1, "guesses": 96}
    assert keys.items() <= case.keys.items()
    assert tool("run", "out/find.csv", "-o", "again").status == 0
    assert (tool.cwd / "again/find.csv").read_bytes() == (tool.cwd / "out/find.csv").read_bytes()


@pytest.mark.parametrize(
    ("form", "suffix"), [("json", "json"), ("netcdf", "nc"), ("matlab", "mat")]
)
def test_forms_of_motions(form, suffix, tool, found):
    """Each form is read back bit for bit by `load`; --format writes to the usual folder."""
    for library in ("h5netcdf", "scipy"):
        pytest.importorskip(library)
    assert tool("find", *POINT, *LIMITS, "--format", form).status == 0
    assert list(contents(tool.cwd)) == [f"results/find.{suffix}"]
    read = vi.load(tool.cwd / f"results/find.{suffix}")
    assert read.to_json() == found.to_json()
    assert [motion.to_json() for motion in read] == [motion.to_json() for motion in found]


def test_labels_of_motions_with_rest(tool):
    """Motions with different numbers of impacts share a netCDF file, and a motion with rest has its letters."""
    xarray = pytest.importorskip("xarray")
    system = [
        "--xi",
        ".0114",
        "--mu",
        ".028",
        "--restitution",
        ".75",
        ".61",
        "--r",
        ".9",
        "--clearance",
        "6",
    ]
    done = tool("find", *system, "--max-impacts", "3", "--max-cycles", "1", "-o", "mine.nc")
    assert (done.status, done.err) == (0, b"")
    found = vi.load(tool.cwd / "mine.nc")
    assert {len(motion.pattern) for motion in found} == {2, 3}
    with xarray.open_dataset(tool.cwd / "mine.nc", engine="h5netcdf") as data:
        assert data.sides.values.tolist() == [motion.pattern.sides for motion in found]
        assert "RL*" in data.sides.values
        for i, motion in enumerate(found):
            own = data.impacts_motions.values == i
            np.testing.assert_array_equal(data.X[own], motion.X)
            assert data.impacts_side.values[own].tolist() == motion.pattern.symbols
            np.testing.assert_array_equal(data.multipliers_real[i], motion.multipliers.real)
            times = data.time.values[data.events_motions.values == i]
            wanted = motion.rest_events["time"] if motion.pattern.has_rest else []
            np.testing.assert_array_equal(times, wanted)
        assert data.x_max.values.tolist() == [motion.x_max for motion in found]
        assert data.attrs["clearance"] == 6.0


@pytest.mark.parametrize("kind", ["png", "svg"])
def test_picture_of_motions(kind, tool, found):
    """The picture has a history of each motion and a panel of the multipliers."""
    done = tool("find", *POINT, *LIMITS, "--plot", kind)
    assert (done.status, done.err) == (0, b"")
    assert sorted(contents(tool.cwd)) == ["results/find.csv", f"results/find.{kind}"]
    if kind == "svg":
        picture = (tool.cwd / "results/find.svg").read_text()
        assert len(re.findall(r'id="axes_\d+"', picture)) == len(found) + 1


def test_the_document_of_a_search(tool, found):
    """The JSON document has all motions found."""
    done = tool("find", *POINT, *LIMITS, "--json")
    (point,) = json.loads(done.out)["results"].values()
    assert vi.FoundMotions.from_dict(point).to_json() == found.to_json()


@pytest.mark.parametrize(("text", "words", "output"), [
    (SYSTEM + "&motion kind = 'equispaced', clearance = 37 /\n&motion kind = 'equispaced', clearance = 36 /\n",
     ["-o", "a.json"], "-o a.json: names a file, and there are 2 points; must be a folder"),
    (PAIR, ["-o", "a.txt"], "-o a.txt: must be a folder, or a file whose name ends with one of .csv"),
    (PAIR, ["--max-impacts", "99"], "--max-impacts 99: must be "),
    (PAIR, ["--r", "1"], "--r: must be left out if a namelist file is given"),
    ("&system xi = .1, mu = .1, restitution = .5 /\n"
     "&response r_min = 1, r_max = 2, r_points = 3, clearance = 1 /\n",
     [], "case.nml: case: must be at one point of r and clearance; this &response is not"),
])  # fmt: skip
def test_bad_searches(text, words, output, tool):
    """An invalid search gives one line and status 2, and writes nothing."""
    write(tool.cwd / "case.nml", text)
    done = tool("find", "case.nml", *words)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith(f"vibroimpact find: {output}")
    assert list(contents(tool.cwd)) == ["case.nml"]


def test_names_of_several_points(tool):
    """Results of several points have the names of the cases; one name for two points is refused."""
    pair = SYSTEM + "&motion kind = 'equispaced', clearance = {} /\n"
    write(tool.cwd / "two.nml", pair.format(37) + pair.format(36))
    done = tool("find", "two.nml", *LIMITS, "-o", "out")
    assert (done.status, sorted(contents(tool.cwd / "out"))) == (0, ["two_1.csv", "two_2.csv"])
    write(tool.cwd / "other.nml", pair.format(35) + "&output name = 'two_2' /\n")
    done = tool("find", "two.nml", "other.nml", *LIMITS)
    assert (done.status, done.out) == (2, b"")
    assert (
        "other.nml: &output name = 'two_2': is already the name of another point" in done.faults[0]
    )
    done = tool("find", *POINT[2:], "--xi", "5")
    assert done.faults[0].startswith(
        "vibroimpact find: --xi 5.0: must be a number with 0 <= xi < 1"
    )


@pytest.mark.parametrize(("words", "output"), [
    (["--r", "1e400"], "--r 1e400: must be a number representable in double precision"),
    (["--r", "-1e999"], "--r -1e999: must be a number representable in double precision"),
    (["--r", "0.9", "--clearance", "1e-400"],
     "--clearance 1e-400: must be a number representable in double precision"),
    (["--r", "1_0"], "--r 1_0: must be a number"),
    (["--r", "0.9", "--guesses", "1_0"], "--guesses 1_0: must be a whole number")])  # fmt: skip
def test_numbers_are_repeated_as_typed(words, output, tool):
    """Invalid numbers are repeated as typed, not as infinity or zero; numbers with separators are refused."""
    system = ["--xi", "0.01", "--mu", "0.05", "--restitution", "0.75", "--clearance", "20"]
    done = tool("find", *system, *words)
    assert done.status == 2
    assert done.faults[-1] == f"vibroimpact find: {output}; see `vibroimpact find --help`"
