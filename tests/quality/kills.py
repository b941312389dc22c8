"""Finds which mutants the kept answers detect, in the libraries that contain nearly all mutants (switched.py).

A case is run only for the mutants whose statement it reaches, each mutant in a separate process. A mutant is
killed if the answer differs from the kept answer, the process crashes, or it takes much longer.
"""

import fcntl
import hashlib
import json
import os
import resource
import signal
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/python")]

from shared_answers import differences, load, put_files  # noqa: E402
from statements import Statements  # noqa: E402

from door import Counted, Library  # noqa: E402

LIBRARY = "src/c/libvibroimpact.so"
#: How a process ends that has tried a mutant; LAPACK ends one with 0 where an argument is not a number, and the
#: Fortran runtime with 2 where it meets an error.
NOTICED, IN_VAIN = 1, 77
#: Outcome of a mutant: the kept answers detect it, miss it, or do not reach its statement.
KILLED, PASSED, UNREACHED = "killed", "passed", "unreached"

#: A case: text, answer, CPU seconds.
Case = tuple[str, dict, float]


class Trial:
    """Tries mutants on cases."""

    def __init__(self, folder: Path):
        self.statements = Statements(folder)
        self.folder = folder
        self.library = Library(folder / "plain" / LIBRARY)
        self.cases: list[Case] = []
        #: Answers of the core to other texts; None if they take too long.
        self.answers: dict[str, Case | None] = {}
        #: By the first number of a statement: the cases that reach it, the shortest first.
        self.reaching: dict[int, list[int]] = defaultdict(list)

    def add(self, cases, reached) -> None:
        """Store cases and the statements that each of them reaches."""
        for case, statements in zip(cases, reached, strict=True):
            for statement in statements:
                self.reaching[statement].append(len(self.cases))
            self.cases.append(case)
        for places in self.reaching.values():
            places.sort(key=lambda i: self.cases[i][2])

    def __call__(self, number: int, alone: str = "") -> tuple[str, int]:
        """Return the outcome of a mutant, and the number of the case that killed it (-1: none).

        number: 0 for a mutant that the library does not contain; then any case may kill it.
        alone: a library with this mutant only, and with run-time checks, which take longer.
        """
        if number:
            statement = self.statements.nearest(self.statements.of_number[number], self.reaching)
            places = self.reaching.get(statement, [])
        else:
            places = sorted(range(len(self.cases)), key=lambda i: self.cases[i][2])
        if not places:
            return UNREACHED, -1
        noticed = self.noticed(number, [self.cases[i] for i in places], alone)
        return (PASSED, -1) if noticed < 0 else (KILLED, places[noticed])

    def noticed(self, number: int, cases, alone: str = "") -> int:
        """Return the index of the first case that detects a mutant; -1 if none does."""
        into, out = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                os.close(into)
                os._exit(NOTICED if self.notices(number, cases, out, alone) else IN_VAIN)
            except BaseException:
                os._exit(NOTICED)
        os.close(out)
        last = -1
        with os.fdopen(into, "rb") as pipe:
            while piece := pipe.read(4):
                last = int.from_bytes(piece, "little")
        _, status = os.waitpid(child, 0)
        return -1 if status == IN_VAIN << 8 else last

    def first_that_notices(self, number: int, texts: list[str], longest: float = 0.3) -> str | None:
        """Return the first text that detects a mutant, without one that takes longer."""
        cases = []
        for text in texts:
            if text not in self.answers:
                found, took = self.library.run(text, longest)
                good = found is not None and took < longest and len(json.dumps(found)) < 6000
                self.answers[text] = (text, found, took) if good else None
            if self.answers[text]:
                cases.append(self.answers[text])
        place = self.noticed(number, sorted(cases, key=lambda case: case[2]))
        return None if place < 0 else sorted(cases, key=lambda case: case[2])[place][0]

    def notices(self, number: int, cases, out: int, alone: str = "") -> bool:
        """Return whether a case detects a mutant; the index of each case is written before it runs."""
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        resource.setrlimit(resource.RLIMIT_AS, (2**33, 2**33))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        library = Library(alone) if alone else self.library
        if not alone:
            self.library.choose(number)
        for place, (text, kept, took) in enumerate(cases):
            os.write(out, place.to_bytes(4, "little"))
            signal.setitimer(signal.ITIMER_PROF, (100 if alone else 10) * took + 1)
            found, _ = library.run(text)
            if any(True for _ in differences(kept, found)):
                return True
        return False


def kept_trial(folder: Path) -> Trial:
    """Return the object that tries the kept answers."""
    kept = load()
    with (folder / "reached.lock").open("w") as lock:
        # if processes start together, one runs the cases and the others read what it noted
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = what_they_do(folder, kept)
    trial = Trial(folder)
    cases, reached = [], []
    for item, (took, statements, good) in zip(kept, done, strict=True):
        if good:
            cases.append((item["text"], item["answer"], took))
            reached.append(statements)
    trial.add(cases, reached)
    return trial


def what_they_do(folder: Path, kept: list[dict]) -> list[tuple]:
    """Return, for each kept case, its CPU seconds, its statements, and whether these libraries give its answer.

    The results are stored in the folder.
    """
    note, numbers = folder / "reached.json", (folder / "mutants.json").read_bytes()
    noted = json.loads(note.read_text(encoding="utf-8")) if note.exists() else {}
    # the numbers of statements belong to one build
    known = noted.get(mark := hashlib.sha256(numbers).hexdigest(), {})
    names = [hashlib.sha256(json.dumps(item).encode()).hexdigest() for item in kept]
    new = {name: item for name, item in zip(names, kept, strict=True) if name not in known}
    if new:
        known |= zip(new, run_all(folder, new.values()), strict=True)
        known = {name: known[name] for name in names}
        written = note.with_suffix(".new")
        written.write_text(json.dumps({mark: known}), encoding="utf-8")
        written.replace(note)
    return [known[name] for name in names]


def run_all(folder: Path, kept) -> list[tuple[float, list[int], bool]]:
    """Run the kept cases in these libraries and return what they do."""
    path = folder / "counted" / LIBRARY
    counted, plain, statements = (
        Counted(path),
        Library(folder / "plain" / LIBRARY),
        Statements(folder),
    )
    known: dict[int, int] = {}
    found = []
    for item in kept:
        _, _, places = counted.reach(item["text"])
        new = [place for place in places if place not in known]
        if new:
            known |= statements.of_places(path, new)
        answer, took = plain.run(item["text"])
        # a case whose answer these libraries do not reproduce would detect any mutant that it reaches
        good = not [*differences(item["answer"], answer)]
        reached = sorted({known[place] for place in places} - {0})
        found.append((took, reached, good))
    return found


def main() -> None:
    """Print the outcome of each mutant whose number is read from standard input."""
    folder = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as home:
        put_files(Path(home))
        os.chdir(home)
        trial = kept_trial(folder)
        print("ready", flush=True)
        for line in sys.stdin:
            number, _, alone = line.rstrip("\n").partition(" ")
            print(*trial(int(number), alone), flush=True)


if __name__ == "__main__":
    main()
