"""Namelist files of millions of lines or thousands of cases: the time is proportional to their size."""

import os
import resource
import subprocess

import pytest
from programs import PAIR, SYSTEM, find_twin, many_cases, write

#: The end of each file: an error that is found after everything else has been read.
FAULT = f"{SYSTEM}&motion x = 1 /\n"
BIG = {
    "empty lines": "\n" * 20_000_000 + FAULT,
    "empty lines in a group": f"{SYSTEM}&motion " + "\n" * 2_000_000 + " x = 1 /\n",
    "comments in a group": f"{SYSTEM}&motion x = 1\n" + "! c = 1 /\n" * 1_000_000 + "/\n",
    "ampersands in a comment": "!" + "&" * 20_000_000 + f"\n{FAULT}",
    "groups in one line": SYSTEM + "&motion x = 1 /" * 1_000_000,
    "keys in one group": f"{SYSTEM}&motion " + "a) = 1 " * 500_000 + "/\n",
    "a list and blanks": f"{SYSTEM}&motion phases = " + "0, " * 900 + " " * 20_000_000 + "x /\n",
    "a list without blanks": f"{SYSTEM}&motion phases = " + "0," * 5_000_000 + "x /\n",
}


def seconds(call, folder):
    """Processor time of a program, and the finished process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(call, cwd=folder, capture_output=True, timeout=300)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done


@pytest.mark.parametrize("kind", BIG)
def test_long_files_are_read(kind, binary, tmp_path):
    """A file of up to 20 MB takes seconds; a reader that copied the rest at each step would take minutes."""
    write(tmp_path / "case.nml", BIG[kind])
    time, done = seconds([binary, "case.nml"], tmp_path)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert time < 20


@pytest.mark.slow
def test_many_cases(binary, tmp_path):
    """Sixteen times as many cases take about sixteen times as long, and not 256 times."""
    times = []
    for number in (500, 8000):
        write(tmp_path / "case.nml", many_cases(number) + "&motion x = 1 /\n")
        times.append(min(seconds([binary, "case.nml"], tmp_path)[0] for _ in range(3)))
    assert times[1] < 60 * max(times[0], 0.01)


def test_names_of_many_cases(binary, tmp_path):
    """The name that occurs twice is found among 8000, at any position."""
    text = many_cases(8000).replace("'case_7998'", "'CASE_3'")
    write(tmp_path / "case.nml", text)
    _, done = seconds([binary, "case.nml"], tmp_path)
    assert done.returncode == 2
    assert b"name = 'CASE_3': is already the name of the case at case.nml:9; " in done.stderr


LETTERS = ["ü.nml", "é.nml", "Ψ.nml", "激.nml", "😀.nml"]


def test_names_keep_their_letters(batch, command):
    """Files whose names differ in letters beyond ASCII have separate results, in both programs."""
    for name in LETTERS:
        write(batch.cwd / name, PAIR)
    assert batch(*LETTERS, "-o", "out").status == 0
    made = sorted(path.name for path in (batch.cwd / "out").iterdir())
    assert made == sorted(name.replace(".nml", ".csv") for name in LETTERS)
    assert command(*LETTERS, "-o", "again").status == 0
    for name in made:
        text = (batch.cwd / "out" / name).read_bytes()
        assert text == (batch.cwd / "again" / name).read_bytes()
        assert f"name = '{name[:-4]}'".encode() in text
    # a result as an input reproduces itself
    assert batch("out/ü.csv", "-o", "third").status == 0
    assert (batch.cwd / "third/ü.csv").read_bytes() == (batch.cwd / "out/ü.csv").read_bytes()


@pytest.mark.parametrize("name", [
    b"\xff", b"a\xe9", b"\xc0\xaf", b"\xed\xa0\x80", "\u202egnp", "a\u00a0b", "a\u2028b", "a\nb", "a b", "\u0085",
])  # fmt: skip
def test_names_without_letters(name, batch, command):
    """Bytes that are not UTF-8, blanks and direction marks become _, in both programs."""
    raw = name if isinstance(name, bytes) else name.encode()
    write(batch.cwd / os.fsdecode(raw + b".nml"), PAIR)
    for program, folder in ((batch, "out"), (command, "again")):
        assert program(os.fsdecode(raw + b".nml"), "-o", folder).status == 0
    (one,), (other,) = ([*(batch.cwd / folder).iterdir()] for folder in ("out", "again"))
    assert one.name == other.name
    assert set(one.name) <= set("ab_gnp.csv")


def test_long_name_is_cut_between_letters(batch):
    """A name cut to 100 bytes ends with a complete letter."""
    done = batch.case(PAIR, "-o", "out", name="a" + "ü" * 60 + ".nml")
    assert done.status == 0
    assert [path.name for path in (batch.cwd / "out").iterdir()] == ["a" + "ü" * 49 + ".csv"]


def test_line_feed_in_a_path(batch, command):
    """The message of an error is one line in both programs."""
    write(batch.cwd / "a\nb.nml", "x")
    output = [program("a\nb.nml", "-o", "out") for program in (batch, command)]
    assert output[0] == output[1]
    assert output[0].faults == [
        "a?b.nml:1: x: is outside a group; a group starts with & and ends with /"
    ]


def limit_file_size():
    """Limit files of the child process to 1000 bytes as `ulimit -f` does; the signal has its default action."""
    os.environ["PYTHONDONTWRITEBYTECODE"] = (
        "1"  # Python keeps bytecode files that the limit cut off
    )
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


@pytest.mark.parametrize("program", ["program", "command"])
@pytest.mark.parametrize("old", [b"the old result\n", None])
def test_file_size_limit(program, old, binary, tmp_path):
    """One line says that the file became too large; the old result stays, and no other file appears."""
    call = [binary] if program == "program" else find_twin()
    (tmp_path / "results").mkdir()
    if old:
        write(tmp_path / "results/case.csv", old)
    write(tmp_path / "case.nml", PAIR)
    done = subprocess.run(
        [*call, "case.nml"],
        cwd=tmp_path,
        preexec_fn=limit_file_size,
        capture_output=True,
        timeout=300,
    )
    assert done.returncode == 2
    (output,) = done.stderr.decode().splitlines()
    assert output.startswith("results/case.csv: ")
    assert "File too large" in output or "could not be written completely" in output
    assert output.endswith("; the folder and the disk must be writable")
    left = {path.name: path.read_bytes() for path in (tmp_path / "results").iterdir()}
    assert left == ({"case.csv": old} if old else {})
