"""Mutated namelists: any bytes give one line and status 2, or a result that is an input."""

import random

import pytest
from programs import COMPLETE, PAIR, SYSTEM, Runner, contents, find_twin, write

SEEDS = [
    COMPLETE[: COMPLETE.index("&output")], PAIR,
    SYSTEM + "&motion kind = 'equispaced', clearance = 37 / ! note\n&output format = 'both' /\n",
    SYSTEM + "&motion sides=\"RRL\" phases(1) = 0 phases(2:3) = 2, 4.d0 cycles = 1 &end\n",
]  # fmt: skip
PIECES = [
    b"&", b"/", b"'", b'"', b"!", b"=", b",", b";", b"(", b")", b"*", b"%", b":", b"\n", b"\r",
    b"\t", b"\0", b"\x1b", b"\xff", b"#", b"nan", b"inf", b"-", b"1e999", b"99999999999", b"&end",
    b"$", b"?", b"=?", b"(1)", b"(0)", b"(1001)", b"(1:2)", b"(::-1)", b"(:)", b"(1,1)", b"phases",
    b"name='../x'", b"3*", b"0*1", b"-1*1", b"99999999999*1", b".true.", b" " * 300, b"R" * 1200,
    b"&motion", b"&system", b"&output",
]  # fmt: skip
COUNT = 400


def mutated(rng):
    """A namelist with a few random changes."""
    text = bytearray(rng.choice(SEEDS).encode())
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(text) + 1)
        kind = rng.randrange(4)
        if kind == 0:
            text[at : at + 1] = bytes([rng.randrange(256)])
        elif kind == 1:
            del text[at : at + rng.choice((1, 1, 2, 8, 40))]
        elif kind == 2:
            text[at:at] = rng.choice(PIECES)
        else:
            text[at : at + rng.randrange(1, 5)] = rng.choice(PIECES)
    return bytes(text)


@pytest.fixture(scope="module")
def ran(tmp_path_factory, binary):
    """A folder of mutated files, and the outcome of the program for each of them alone."""
    folder = tmp_path_factory.mktemp("fuzz")
    rng = random.Random(87)
    names = [f"f{i}.nml" for i in range(COUNT)]
    for name in names:
        write(folder / name, mutated(rng))
    run = Runner([binary], folder)
    return folder, {name: run(name, "-o", f"out/{name}/") for name in names}


def test_no_breakdown_and_one_line_a_fault(ran):
    """Status 0 comes with an empty stderr, status 2 with one line that starts with the file's name."""
    folder, output = ran
    assert {done.status for done in output.values()} >= {0, 2}
    for name, done in output.items():
        lines = done.err.count(b"\n")
        if done.status == 0:
            assert lines == 0, name
        elif done.status == 1:
            assert lines >= 1, name
        else:
            assert lines == 1, name
            assert done.err.startswith(name.encode() + b":"), name
            assert not (folder / "out" / name).exists(), name


def test_nothing_outside_the_folder(ran):
    """The folder holds only the input files and `out`, and `out` only results."""
    folder, output = ran
    assert {path.name for path in folder.iterdir()} - {"out", *output} == set()
    assert all(name.endswith((".csv", ".txt")) for name in contents(folder / "out"))


def test_survivors_are_inputs(ran, binary, tmp_path):
    """Running each result of a mutated file reproduces it."""
    folder, _ = ran
    run = Runner([binary], folder / "out")
    for path in sorted((folder / "out").rglob("*.csv")):
        name = path.relative_to(folder / "out")
        assert run(str(name), "-o", f"{tmp_path / name.parent}/").status in (0, 1)
        assert (tmp_path / name).read_bytes() == path.read_bytes(), name


def test_command_agrees(ran, tmp_path):
    """The command gives the same messages, except for names of results that collide in one call."""
    folder, output = ran
    done = Runner(find_twin(), folder)(*output, "-o", str(tmp_path / "out"))
    lines = set(done.err.decode(errors="replace").split("\n"))
    expected = {
        line for one in output.values() for line in one.err.decode(errors="replace").split("\n")
    }
    assert {line for line in lines ^ expected if "already the name" not in line} == set()
