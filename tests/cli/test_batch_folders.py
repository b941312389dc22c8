"""Files and folders: whatever fails, a result is written completely or not at all."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import pytest
from programs import (
    COMPLETE,
    PAIR,
    Runner,
    bound_by_permissions,
    chain,
    contents,
    find_twin,
    many_cases,
    write,
)

LINUX = os.path.isdir("/proc/self")


@pytest.fixture(scope="module")
def complete_run(tmp_path_factory, binary):
    """A folder with many.nml (200 cases) and the results of an undisturbed run."""
    folder = tmp_path_factory.mktemp("many")
    done = Runner([binary], folder).case(many_cases(200), name="many.nml")
    assert (done.status, len(done.out.splitlines())) == (0, 200)
    assert len(contents(folder / "results")) == 200
    return folder


def results_of(folder):
    """The results in a folder, without temporary files."""
    return {name: text for name, text in contents(folder).items() if name.endswith(".csv")}


def start(program, folder, *arguments):
    """Start a program without waiting for it."""
    return subprocess.Popen(
        [*program, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def test_command_runs_many_cases(complete_run, tmp_path):
    """For two hundred cases in one file the command gives the files and lines of the program."""
    run = Runner(find_twin(), complete_run)
    done = run("many.nml", "-o", str(tmp_path / "out"))
    assert (done.status, len(done.out.splitlines())) == (0, 200)
    assert contents(tmp_path / "out") == contents(complete_run / "results")


GROWTH = """
import sys, vibroimpact as vi

def pages(runs):
    for _ in range(runs):
        vi.run_namelists(["many.nml"], sys.argv[1])
    return int(open("/proc/self/statm").read().split()[1])

print(-pages(5) + pages(20))
"""


@pytest.mark.slow
@pytest.mark.skipif(not LINUX, reason="no /proc")
def test_runs_give_their_memory_back(complete_run, tmp_path):
    """In one Python process the 25th run of a file needs no more memory than the 5th."""
    call = [sys.executable, "-c", GROWTH, str(tmp_path)]
    done = subprocess.run(call, cwd=complete_run, capture_output=True, text=True, check=True)
    assert int(done.stdout) * resource.getpagesize() < 2e6


def test_ten_thousand_lines(batch):
    """A file of 500 cases in 10,000 lines, with comments and blank lines, runs completely."""
    lines = many_cases(500).splitlines()
    filler = ["! a comment with = and / and ' in it", ""]
    text = "".join("\n".join([line, *filler * 5]) + "\n" for line in lines)
    assert text.count("\n") > 10_000
    done = batch.case(text)
    assert (done.status, done.err) == (0, b"")
    assert len(contents(batch.cwd / "results")) == 500


def test_ten_thousand_lines_in_one_group(batch):
    """A list of 400 phases spread over 10,000 lines is read as one list."""
    text = chain(400).replace(", ", ",\n! next\n" + "\n" * 24)
    assert text.count("\n") > 10_000
    assert batch.case(text).status == 0
    assert batch.case(chain(400), "-o", "plain").status == 0
    assert contents(batch.cwd / "results") == contents(batch.cwd / "plain")


@pytest.mark.parametrize("program", ["program", "command"])
def test_kill_leaves_whole_results(program, complete_run, binary, tmp_path):
    """After kill -9 during a run every result is complete, either the new one or the old one."""
    call = [binary] if program == "program" else find_twin()
    expected = contents(complete_run / "results")
    old = dict.fromkeys(list(expected)[::2], b"old\n")
    (tmp_path / "out").mkdir()
    for name, text in old.items():
        write(tmp_path / "out" / name, text)
    process = start(call, complete_run, "many.nml", "-o", str(tmp_path / "out"))
    end = time.monotonic() + 30
    while process.poll() is None and time.monotonic() < end:
        if len(results_of(tmp_path / "out")) > len(old) + 5:
            break
    process.kill()
    process.communicate()
    for name, text in results_of(tmp_path / "out").items():
        assert text in (expected[name], old.get(name)), name


def limit_file_size():
    """Limit files of the child process to 1000 bytes; a write then fails as on a full disk."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    os.environ["PYTHONDONTWRITEBYTECODE"] = (
        "1"  # Python keeps bytecode files that the limit cut off
    )
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


@pytest.mark.parametrize("old", [b"the old result\n", None])
def test_command_on_a_full_disk(old, command, same_build):
    """If writing fails in the middle of a file the status is 2; the old result stays, and no new one appears."""
    (command.cwd / "results").mkdir()
    if old:
        write(command.cwd / "results/case.csv", old)
    done = command.case(PAIR, preexec_fn=limit_file_size)
    assert contents(command.cwd / "results") == ({"case.csv": old} if old else {})
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert "case.csv" in done.faults[0]


def test_program_at_its_file_size_limit(binary, tmp_path):
    """At the limit the program fails or is killed, and only the old result remains."""
    (tmp_path / "results").mkdir()
    write(tmp_path / "results/case.csv", "old\n")
    write(tmp_path / "case.nml", PAIR)
    call = [binary, "case.nml"]
    done = subprocess.run(call, cwd=tmp_path, preexec_fn=limit_file_size, capture_output=True)
    assert done.returncode != 0
    assert results_of(tmp_path / "results") == {"case.csv": b"old\n"}


@pytest.fixture
def small_disk(tmp_path):
    """A folder on a file system of 16 KiB, if the system permits mounting one."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = shutil.which("mount")
    call = [mount or "mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(disk)]
    if mount is None or subprocess.run(call, capture_output=True).returncode != 0:
        pytest.skip("no small file system can be mounted here")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


@pytest.mark.parametrize("program", ["program", "command"])
def test_full_disk(program, small_disk, complete_run, binary):
    """On a disk that fills up, earlier results are complete, the status is 2, and no file is empty or partial."""
    call = [binary] if program == "program" else find_twin()
    # in a separate process: a file that could not be closed would keep the disk busy
    done = Runner(call, complete_run)("many.nml", "-o", str(small_disk), timeout=300)
    expected = contents(complete_run / "results")
    found = contents(small_disk)
    assert 0 < len(found) < 200
    assert all(found[name] == expected.get(name) for name in found)
    assert done.status == 2
    assert len(done.faults) >= 1


def test_concurrent_runs_into_one_folder(complete_run, binary, tmp_path):
    """Concurrent runs into one folder all succeed, and leave the results of a single run."""
    runs = [start([binary], complete_run, "many.nml", "-o", str(tmp_path / "out"))
            for _ in range(8)]  # fmt: skip
    output = [run.communicate(timeout=60)[1] for run in runs]
    assert [(run.returncode, text) for run, text in zip(runs, output, strict=True)] == [
        (0, b"")
    ] * 8
    assert contents(tmp_path / "out") == contents(complete_run / "results")


@pytest.mark.parametrize("folder", [
    "file", "file/below", pytest.param("/proc/nowhere", marks=pytest.mark.skipif(
        not LINUX, reason="no /proc"))])  # fmt: skip
def test_folder_that_cannot_be_made(folder, batch, command):
    """A folder that cannot be created, such as one below a file, gives one line and status 2 in both programs."""
    write(batch.cwd / "file", "mine")
    done = batch.case(PAIR, "-o", folder)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    below = folder.startswith("file")
    reason = "file is a file" if below else "cannot be created"
    wanted = "must be a folder" if below else "the folder and the disk must be writable"
    assert done.faults == [f"{folder}: {reason}; {wanted}"]
    again = command("case.nml", "-o", folder)
    assert (again.status, again.out, len(again.faults)) == (2, b"", 1)
    if again != done and below:
        assert again.faults == [f"vibroimpact run: -o {done.faults[0]}"]
    elif again != done:  # here the system gives the reason
        assert again.faults[0].startswith(f"vibroimpact run: {folder}: ")
        assert again.faults[0].endswith(f"; {wanted}")
    assert sorted(contents(batch.cwd)) == ["case.nml", "file"]
    assert (batch.cwd / "file").read_bytes() == b"mine"


def test_reason_of_a_long_folder(batch):
    """The message has the reason, however long the path is."""
    folder = "case.nml/" + "d" * 250
    assert "d: case.nml is a file; must be a folder" in batch.case(PAIR, "-o", folder).faults[0]


def test_read_only_folder(batch):
    """A folder without write permission: status 2, and the old result stays."""
    batch.case(PAIR)
    before = contents(batch.cwd / "results")
    (batch.cwd / "results").chmod(0o555)
    done = batch.case(PAIR.replace("1.37", "1.38"), preexec_fn=bound_by_permissions)
    (batch.cwd / "results").chmod(0o755)
    assert (done.status, contents(batch.cwd / "results")) == (2, before)
    assert "ermission denied" in done.faults[0]
    assert done.faults[0].startswith("results: ")  # the folder, before anything is computed


def test_result_that_cannot_be_replaced(batch, command):
    """A folder with the name of the result is kept and named in the message; no temporary file is left."""
    keep = batch.cwd / "results/case.csv/keep"
    keep.parent.mkdir(parents=True)
    write(keep, "kept")
    done = batch.case(PAIR)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert done.faults[0].startswith("results/case.csv: ")
    assert contents(batch.cwd / "results") == {"case.csv/keep": b"kept"}
    assert command("case.nml") == done


def test_read_only_result_is_replaced_whole(batch):
    """A result is replaced by renaming, which needs the folder's permission, not the file's."""
    (batch.cwd / "results").mkdir()
    write(batch.cwd / "results/case.csv", "old").chmod(0o444)
    assert batch.case(PAIR).status == 0
    assert (batch.cwd / "results/case.csv").read_bytes().startswith(b"# ! vibroimpact")


@pytest.mark.parametrize("link", ["case.csv", "case.csv.part", "case.txt", "case.txt.part"])
def test_links_are_not_written_through(link, batch):
    """A result replaces a link with its name; it is not written to the target of the link."""
    victim = write(batch.cwd / "victim", "mine")
    (batch.cwd / "results").mkdir()
    (batch.cwd / "results" / link).symlink_to(victim)
    batch.case(COMPLETE.replace("'csv'", "'both'"))
    assert victim.read_bytes() == b"mine"


def test_left_over_temporary_file_is_no_obstacle(batch):
    """A temporary file of a killed run does not disturb the next run."""
    (batch.cwd / "results").mkdir()
    write(batch.cwd / "results/case.csv.part", "half")
    assert batch.case(PAIR).status == 0
    assert batch("results/case.csv", "-o", "again").status == 0


def test_table_does_not_replace_its_input(batch):
    """A printout does not replace its own namelist file, even if it has the same path."""
    text = COMPLETE.replace("'csv'", "'table'")
    batch.case(text, "-o", ".", name="case.txt")
    assert (batch.cwd / "case.txt").read_text() == text


def test_default_folder(batch, command):
    """Without -o results go to `results` in the current folder, in both programs."""
    assert batch.case(PAIR).status == 0
    before = contents(batch.cwd / "results")
    shutil.rmtree(batch.cwd / "results")
    assert command("case.nml").status == 0
    assert contents(batch.cwd / "results") == before
    assert list(before) == ["case.csv"]


@pytest.mark.parametrize("folder", [
    "out", "./out", "out/", "a/b/c", "../{name}/out", "{absolute}/deep/er", "mit Leer zeichen",
    "Ergebniß/Ünï", "./-", "dot.dot/", "trailing ", "o'quote\"s"])  # fmt: skip
def test_folders(folder, batch, command):
    """The named folder is created, be it relative, absolute, nested, with blanks or in UTF-8."""
    folder = folder.format(name=batch.cwd.name, absolute=batch.cwd)
    assert batch.case(PAIR, "-o", folder).status == 0
    assert list(contents(batch.cwd / folder)) == ["case.csv"]
    assert command("case.nml", "-o", folder).status == 0
    assert len(contents(batch.cwd)) == 2


@pytest.mark.parametrize("name", ["mit Leer zeichen.nml", "Ünï cödé.nml", "a/b/c.nml", "case",
                                  "./case.nml", "'quoted'.nml", "per%cent.nml"])  # fmt: skip
def test_files(name, batch, command):
    """Input files may have any name, in both programs."""
    (batch.cwd / name).parent.mkdir(parents=True, exist_ok=True)
    done = batch.case(PAIR, "-o", "out", name=name)
    assert (done.status, done.err) == (0, b"")
    assert command(name, "-o", "again") == done
    assert contents(batch.cwd / "again") == contents(batch.cwd / "out")


def test_file_by_absolute_path(batch):
    """A file can be given by its absolute path, which appears in the messages."""
    path = write(batch.cwd / "case.nml", PAIR.replace("0.005", "5"))
    assert batch(str(path)).faults[0].startswith(f"{path}:1: &system xi = 5: ")


def test_blank_at_the_end_of_a_name_counts(batch):
    """'case.nml ' is not 'case.nml'."""
    write(batch.cwd / "case.nml", PAIR)
    done = batch("case.nml ")
    assert done.status == 2
    assert not (batch.cwd / "results").exists()


def test_input_from_a_pipe(batch):
    """A pipe is read, or refused because it cannot be read; the message does not call it empty."""
    done = batch("/dev/stdin", "-o", "out", input=PAIR.encode())
    assert done.status == 0 or "cannot be read" in done.faults[0], done


def test_result_over_itself(batch):
    """Running a result into its own folder replaces it by the same bytes."""
    batch.case(PAIR)
    before = contents(batch.cwd / "results")
    assert batch("results/case.csv").status == 0
    assert contents(batch.cwd / "results") == before
