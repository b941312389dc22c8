"""How the tests find and run the program `vibroimpact-batch` and the command `vibroimpact run`."""

import contextlib
import csv
import ctypes
import importlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

BIN = Path(sys.executable).parent
ROOT = Path(__file__).resolve().parents[2]
#: Studies that the Python package computes, and the namelists that come with the project without their cases.
IN_PYTHON = ("design", "identify")
INPUTS = sorted(
    path for path in (ROOT / "inputs").glob("*.nml")
    if not any(f"&{group}\n" in path.read_text(encoding="utf-8") for group in (*IN_PYTHON, "sweep"))
)  # fmt: skip
OTHER_BUILD = bool(os.environ.get("VIBROIMPACT_BATCH"))

SYSTEM = "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
#: The same point by options.
POINT = [
    "--xi",
    "0.005",
    "--mu",
    "0.042",
    "--restitution",
    "0.75",
    "--r",
    "0.94",
    "--clearance",
    "37",
]
PAIR = SYSTEM + "&motion sides = 'RL', phases_over_pi = 0, 1.37 /\n"
#: A complete case with one key a line; the tables of bad input change single lines of it.
COMPLETE = """&system
  xi = 0.005
  mu = 0.042
  restitution = 0.75
  r = 0.94
/
&motion
  sides = 'RL'
  cycles = 1
  phases_over_pi = 0, 1.37
/
&output
  name = 'case'
  format = 'csv'
/
"""
#: Columns of each impact, those that all impacts share, and the words of verdicts.
IMPACT = ["x", "z", "x_dot_before", "x_dot_after", "z_dot_before", "z_dot_after"]
SHARED = ["clearance", "A", "tau", "residual", "x_min", "x_max", "attenuation"]
WORDS = {True: "true", False: "false", None: "unknown"}
#: Messages of a sanitizer or the compiler's runtime library when a program breaks.
BREAKDOWN = ("Fortran runtime", "Backtrace", "Sanitizer", "runtime error", "SIG", "Traceback")


def kinds():
    """The kinds of cases, each with the namelist to start from."""
    from vibroimpact.commands import init

    return {kind: init.template(kind, f"{kind}.nml") for kind in init.kinds()}


#: A line of output that names a written file.
WRITTEN = re.compile(
    rb"^[\w.\x80-\xff-]+: (.+\.(?:csv|txt|json|nc|mat|png|svg|pdf|gif|mp4))\n", re.MULTILINE
)


@dataclass(frozen=True)
class Outcome:
    """Exit status, standard output and error, and the names of the files reported, without their folders."""

    status: int
    out: bytes
    err: bytes
    files: tuple[str, ...] = field(default=(), compare=False)

    @property
    def faults(self):
        """Lines on stderr."""
        return self.err.decode(errors="surrogateescape").splitlines()


class Runner:
    """Runs one program in a folder; relative paths start from that folder."""

    def __init__(self, start, cwd):
        """`start` is the program with its first arguments."""
        self.start = [str(item) for item in start]
        self.cwd = cwd

    def __call__(self, *arguments, **options):
        """Run with arguments; a breakdown (crash, backtrace, hang) fails the test.

        Without options the command `vibroimpact` is called in this process, which saves its start.
        """
        call = [*self.start, *arguments]
        if not options and call[0] == find_command():
            done = call_here(call, self.cwd)
        else:
            # the limit stops a hanging program, but not one slowed by a busy machine
            options = {"cwd": self.cwd, "timeout": 600, "stdin": subprocess.DEVNULL, **options}
            if "input" in options:
                del options["stdin"]
            done = subprocess.run(call, capture_output=True, **options)
        output = done.stderr.decode(errors="replace")
        assert done.returncode in (0, 1, 2), f"exit status {done.returncode}: {output[:500]}"
        assert not any(word in output for word in BREAKDOWN), output[:500]
        files = tuple(map(os.fsdecode, WRITTEN.findall(done.stdout)))
        return Outcome(done.returncode, WRITTEN.sub(b"", done.stdout), done.stderr, files)

    def case(self, text, *arguments, name="case.nml", **options):
        """Write a namelist file and run it."""
        write(self.cwd / name, text)
        return self(name, *arguments, **options)


def call_here(call, cwd):
    """Call the command `vibroimpact` in this process, with the streams, folder and filters of a new process."""
    from vibroimpact.commands.command import main

    words = [os.fsdecode(word) for word in call]
    before, python = os.getcwd(), (sys.stdout, sys.stderr, sys.argv)
    with (
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as err,
        warnings.catch_warnings(),
    ):
        warnings.resetwarnings()
        warnings.simplefilter("ignore", DeprecationWarning)
        kept = [os.dup(1), os.dup(2)]
        try:
            os.chdir(cwd)
            os.dup2(out.fileno(), 1)
            os.dup2(err.fileno(), 2)
            sys.stdout, sys.stderr = (
                io.TextIOWrapper(io.FileIO(stream, "w", closefd=False), "utf-8", errors)
                for stream, errors in ((1, "surrogateescape"), (2, "backslashreplace"))
            )
            sys.argv = words
            try:
                status = main(words[1:])
            except SystemExit as end:
                status = end.code or 0
            except Exception:
                traceback.print_exc()
                status = 1
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            sys.stdout, sys.stderr, sys.argv = python
            for stream, copy in enumerate(kept, 1):
                os.dup2(copy, stream)
                os.close(copy)
            os.chdir(before)
        out.seek(0)
        err.seek(0)
        return subprocess.CompletedProcess(call, status, out.read(), err.read())


def bound_by_permissions():
    """Run in a child process before it starts: even root then has only the access that file permissions allow.

    Root bypasses permissions by two capabilities, which are removed from the bounding set.
    """
    if os.geteuid() != 0:
        return
    drop_from_bounding_set, override, read_search = 24, 1, 2
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    for capability in (override, read_search):
        if prctl(drop_from_bounding_set, capability, 0, 0, 0) != 0:
            raise OSError(ctypes.get_errno(), "prctl")


def write(path, text):
    """Write text or bytes exactly as they are."""
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


#: Show a progress bar at once, and redraw it at every update.
EAGER = (
    "import vibroimpact.base.progress as p, vibroimpact.base.interrupt as r\n"
    "p.PATIENCE = p.INTERVAL = 0.0; r.INTERVAL = 0.001\n"
)


def on_terminal(cwd, *words, stop=None, again=None, more=""):
    """Exit status of `vibroimpact`, and its output on a terminal, with a bar from the start.

    It is interrupted when its output matches the pattern `stop`, and again when a file exists whose name
    fits the pattern `again`. Python lines `more` are run before the program.
    """
    (cwd / "eager").mkdir(exist_ok=True)
    write(cwd / "eager/sitecustomize.py", EAGER + more)
    ours, theirs = os.openpty()
    with subprocess.Popen(
        [find_command(), *words],
        cwd=cwd, stderr=theirs, stdout=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(cwd / "eager")},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:  # fmt: skip
        os.close(theirs)
        output, stopped = "", False
        with contextlib.suppress(OSError):  # the end of a terminal
            while part := os.read(ours, 4096):
                output += part.decode()
                if stop and not stopped and re.search(stop, output):
                    stopped = True
                    process.send_signal(signal.SIGINT)
                    if again:
                        wait_for(lambda: [*cwd.glob(again)] or process.poll() is not None)
                        process.send_signal(signal.SIGINT)
    os.close(ours)
    assert stopped == bool(stop), output[-500:]
    return process.returncode, output


def wait_for(there):
    """Wait until a condition holds, half a minute at most."""
    end = time.monotonic() + 30
    while not there() and time.monotonic() < end:
        time.sleep(0.02)


def bars(output):
    """Length of the bar at each time it was drawn."""
    return [len(item) for item in re.findall(r"\[(#*) *\]", output)]


def find_batch():
    """The compiled program: $VIBROIMPACT_BATCH, else the installed one without its launcher."""
    chosen = os.environ.get("VIBROIMPACT_BATCH")
    if chosen:
        return str(Path(chosen).resolve(strict=True))
    importlib.import_module("vibroimpact")  # the import builds all changes, also of the program
    found = find_launcher()
    if found and Path(found).read_bytes()[:2] != b"#!":
        return found
    from importlib.resources import files

    return str(files("vibroimpact") / "_bin" / "vibroimpact-batch")


def find_launcher():
    """`vibroimpact-batch` in the folder of the running interpreter, or None."""
    return shutil.which("vibroimpact-batch", path=str(BIN))


def find_command():
    """`vibroimpact` in the folder of the running interpreter."""
    return shutil.which("vibroimpact", path=str(BIN)) or "vibroimpact"


def find_twin():
    """The command line of `vibroimpact run`, or of the program itself if another build was chosen.

    Other compiler options may change last bits, so another build is compared with itself.
    """
    return [find_batch()] if OTHER_BUILD else [find_command(), "run"]


def contents(folder):
    """Name and bytes of every file below a folder; files renamed meanwhile may be missing."""
    found = {}
    for path in Path(folder).rglob("*"):
        if path.is_file():
            with contextlib.suppress(FileNotFoundError):
                found[str(path.relative_to(folder))] = path.read_bytes()
    return found


def rows(path):
    """The rows of a result as dictionaries of text."""
    lines = Path(path).read_text().splitlines()
    table = "\n".join(line for line in lines if not line.startswith("#"))
    return list(csv.DictReader(io.StringIO(table)))


def motions(path):
    """The motions of a result: for each, a dictionary of the columns as lists of text."""
    found = {}
    for row in rows(path):
        motion = found.setdefault(row["motion"], {key: [] for key in row})
        for key, value in row.items():
            motion[key].append(value)
    return list(found.values())


def floats(motion, key):
    """A column as numbers."""
    return [float(item) for item in motion[key]]


def column(table, name):
    """A column of rows as numbers."""
    return np.array([float(row[name]) for row in table])


def multipliers(motion):
    """The four multipliers of a motion."""
    first = {key: value[0] for key, value in motion.items()}
    return [
        complex(float(first[f"multiplier_{i}_re"]), float(first[f"multiplier_{i}_im"]))
        for i in range(1, 5)
    ]


def assert_same(motion, expected):
    """A motion of a result equals one of the Python API, bit for bit."""
    for key in IMPACT:  # the attribute of a motion is a capital letter
        own = key[0].upper() + key[1:]
        assert floats(motion, key) == getattr(expected, own).tolist(), key
    for key in SHARED:
        assert floats(motion, key) == [getattr(expected, key)] * len(motion["r"]), key
    assert multipliers(motion) == expected.multipliers.tolist()
    for key in ("consistent", "admissible", "stable"):
        assert motion[key][0] == WORDS[getattr(expected, key)], key


def many_cases(count):
    """A file of cases `case_0` to `case_{count-1}`, their second phases spread over a range."""
    lines = [SYSTEM]
    for i in range(count):
        phase = 1.3 + 0.1 * i / count
        lines.append(f"&motion sides = 'RL', phases_over_pi = 0, {phase!r} /\n")
        lines.append(f"&output name = 'case_{i}' /\n")
    return "".join(lines)


def chain(count):
    """A namelist of one motion with `count` (even) alternating impacts, one each half cycle."""
    phases = ", ".join(repr(i + 0.001 * (i % 7)) for i in range(count))
    return (
        f"{SYSTEM}&motion sides = '{'RL' * (count // 2)}', cycles = {count // 2}, acceptance = 1\n"
        f"phases_over_pi = {phases} /\n"
    )


def changed(line, text):
    """The complete case with one line replaced."""
    lines = COMPLETE.splitlines()
    lines[line - 1] = text
    return "\n".join(lines) + "\n"


def assert_refused(text, group, wanted, line, batch):
    """Check for one line with file, line, group, key, value and allowed values; status 2; no result."""
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1), done
    assert done.faults[0].startswith(f"case.nml:{line}: &{group} ")
    assert wanted in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]
