"""Saving files: completely or not at all, with concurrent threads, links, limits and interrupts."""

import csv
import os
import secrets
import stat
import subprocess
import sys
import threading
import time

import pytest
import vibroimpact as vi
from vibroimpact.base.files import write_bytes

OSC = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
FORMS = ["json", "csv", "nc", "mat"]


@pytest.fixture(scope="module")
def motion():
    return vi.equispaced(OSC, r=0.94, clearance=37.0)[0]


@pytest.mark.parametrize("form", FORMS)
def test_threads_that_save_to_one_path(form, motion, tmp_path):
    """Each of four threads succeeds each time, and a reader never sees part of a file."""
    path = tmp_path / f"motion.{form}"
    motion.save(path)
    whole, errors = path.read_bytes(), []
    times = 5 if form == "nc" else 25  # a netCDF file takes 50 times as long as another

    def save():
        try:
            for _ in range(times):
                motion.save(path)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=save) for _ in range(4)]
    for thread in threads:
        thread.start()
    # a .mat file starts with its date
    skip = 128 if form == "mat" else 0
    while any(thread.is_alive() for thread in threads):
        seen = path.read_bytes()
        assert (len(seen), seen[skip:]) == (len(whole), whole[skip:])
        time.sleep(1e-3)  # otherwise the threads mostly wait for each other in the interpreter
    assert errors == []
    assert [item.name for item in tmp_path.iterdir()] == [path.name]


def test_threads_that_save_one_result_under_other_names(motion, tmp_path):
    """Threads that save one result as CSV under several names each get their own name in the header."""
    names = [f"name_{i}" for i in range(8)]

    def save(name):
        for _ in range(25):
            motion.save(tmp_path / f"{name}.csv")

    threads = [threading.Thread(target=save, args=(name,)) for name in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in names:
        assert f"\n#   name = '{name}'\n" in (tmp_path / f"{name}.csv").read_text()


def test_planted_links_are_not_followed(motion, tmp_path, monkeypatch):
    """If a link has the name of the temporary file, another name is taken; the names differ each time."""
    victim = tmp_path / "victim"
    victim.write_text("mine")
    token = secrets.token_hex
    names = ["planted", "planted", token(8)]
    (tmp_path / "motion.planted.part").symlink_to(victim)
    monkeypatch.setattr(secrets, "token_hex", lambda _: names.pop(0))
    motion.save(tmp_path / "motion.json")
    assert victim.read_text() == "mine"
    assert names == []
    assert not (tmp_path / "motion.json").is_symlink()


@pytest.mark.parametrize("call", ["open", "close", "replace"])
def test_an_interrupt_in_any_call_leaves_no_temporary_file(call, tmp_path, monkeypatch):
    """Ctrl-C during one of the calls of the system leaves the old file or the new one, and nothing else."""
    (tmp_path / "file").write_bytes(b"old")
    real = getattr(os, call)

    def interrupted(*words):
        real(*words)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, call, interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_bytes(tmp_path / "file", b"new")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_bytes() == (b"new" if call == "replace" else b"old")


def test_permissions_follow_the_umask(tmp_path):
    """A saved file has the permissions of any new file."""
    before = os.umask(0o027)
    try:
        write_bytes(tmp_path / "file", b"x")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o640


def test_long_names(motion, tmp_path):
    """The name of the temporary file is not longer than the file system allows."""
    motion.save(tmp_path / f"{'n' * 250}.json")
    assert len([*tmp_path.iterdir()]) == 1


LIMITED = """
import resource, sys, vibroimpact as vi
sys.dont_write_bytecode = True  # Python renames a bytecode file even if the limit cut it off
motion = vi.equispaced(vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75), r=0.94, clearance=37.0)[0]
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
try:
    motion.save(sys.argv[1])
except OSError as error:
    print(error)
"""


@pytest.mark.parametrize("form", FORMS)
def test_file_size_limit(form, tmp_path):
    """A file that becomes too large raises an OSError that names it, and leaves no file."""
    path = tmp_path / f"motion.{form}"
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, path], capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stderr) == (0, "")
    # the runtime library of Fortran does not always give the reason
    assert "File too large" in done.stdout or (
        form == "csv" and "written completely" in done.stdout
    )
    assert str(path) in done.stdout
    assert [*tmp_path.iterdir()] == []


SLOW = """
import os, signal, sys, threading, time, vibroimpact as vi
from pathlib import Path
signal.signal(signal.SIGINT, signal.default_int_handler)
osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
run = vi.simulate(osc, 1.04, 9.0, 200_000, state={"t": 0, "x": 0, "x_dot": 6, "z": 0, "z_dot": 9})
folder = Path(sys.argv[1])

def interrupt():
    while not any(folder.iterdir()):
        time.sleep(0.001)
    os.kill(os.getpid(), signal.SIGINT)

threading.Thread(target=interrupt).start()
begin = time.process_time()
try:
    run.save(folder / "run.csv")
    print("saved", time.process_time() - begin)
except KeyboardInterrupt:
    print("stopped", time.process_time() - begin)
print(os.listdir(folder))
"""


def test_interrupt_stops_the_writing_of_a_csv(tmp_path):
    """Ctrl-C stops the core at once while it writes a large CSV, and leaves no file."""
    done = subprocess.run(
        [sys.executable, "-c", SLOW, tmp_path], capture_output=True, text=True, timeout=300
    )
    assert done.stderr == ""
    first, second = done.stdout.splitlines()
    assert first.startswith("stopped")
    assert second == "[]"


@pytest.mark.parametrize(
    "word", [" ", "  ", "a ", "a,b", 'say "a"', "=1+1", "+1", "-1", "@a", "'a", "\u03be", "=a,b"]
)
def test_words_of_any_characters_in_a_csv(word, tmp_path):
    """Each stays one cell, as the csv module reads it; one that a spreadsheet would compute as a formula has an
    apostrophe before it. A blank word ended the interpreter, and left a part of the file."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    data = vi.branch(vi.equispaced(osc, 0.94, 37.0)[0], "clearance", (36.0, 38.0)).to_dict()
    details = data["tables"]["points"]["columns"]["detail"]
    details[:] = [word] * len(details)
    branch = vi.Branch.from_dict(data)
    branch.save(tmp_path / "branch.csv")
    lines = [line for line in (tmp_path / "branch.csv").read_text().splitlines() if line[:1] != "#"]
    rows = list(csv.DictReader(lines))
    assert len(rows) == len(details)
    assert {row["detail"] for row in rows} == {f"'{word}" if word[0] in "=+-@" else word}
    assert [item.name for item in tmp_path.iterdir()] == ["branch.csv"]


@pytest.mark.parametrize("word", ["a\nb", "a\tb", "\ud800", "\x00"])
def test_words_that_no_file_holds_are_refused(word):
    """The core stores words as lines."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    data = vi.branch(vi.equispaced(osc, 0.94, 37.0)[0], "clearance", (36.0, 38.0)).to_dict()
    data["tables"]["points"]["columns"]["detail"][0] = word
    with pytest.raises(
        vi.ParameterError, match=r"points.detail = .*: must be (a text|valid Unicode)"
    ):
        vi.Branch.from_dict(data)
