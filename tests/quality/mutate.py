"""Mutation testing of the Fortran core: does a test fail if one place of one line is wrong?

One build contains nearly all mutants, one of which is selected by an environment variable (build/switched: the
first run makes it, and finds which tests reach which statement; this takes forty minutes). A mutant is first run
on the kept answers, then on the Fortran tests and the Python tests that reach its statement. The few mutants that
are not in executable statements, and all mutants with --fortran-only, are instead compiled separately and linked
before the library. A mutant that survives is run once more with the checks of the debug build (build/checked),
which stop a program at an array element out of bounds, and then on the slow Python tests. A test that fails,
crashes or exceeds its limits kills the mutant. A mutant that no test kills must be in `survivors.txt`, with the
reason. Results are kept (build/mutation), so that a run can be stopped and continued: a mutant that was killed is
not run again until its file changes, and a mutant that survived is not run again until the tests change.
"""

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path

import reaching
from checked import Checked
from linked import ANSWERS, FORTRAN_END, ROOMS, Build, ended, passes, pytest
from mutants import Mutant, mutants_of
from package import copy_package, core_of
from statements import Statements
from switched import digest, prepare

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent


class Compiled:
    """What compiles a mutant and links it with the library of a build: for the Fortran tests, and a package."""

    def __init__(self, fortran: Path, package: Path | None):
        self.fortran = Build(fortran)
        self.package = Build(package) if package else None

    def python_tests(self, file: str) -> list[str]:
        """Return the Python tests that are affected by a change of a file."""
        return []

    def __call__(self, mutant: Mutant) -> str:
        """Return what became of a mutant: killed by some test, survived, or not valid."""
        with tempfile.TemporaryDirectory(prefix="mutant-") as made:
            folder = Path(made)
            objects = self.fortran.compile(mutant, folder / "fortran")
            if objects is None:
                return "not valid"
            for room in ROOMS[mutant.file.split("/")[1]]:
                program = folder / f"test_{room}"
                if not self.fortran.link(f"tests/fortran/{program.name}", objects, program):
                    return "not valid"
                if not passes([program], folder, 60, FORTRAN_END):
                    return f"killed by {room}"
                program.unlink()
            if self.package is not None:
                # the package and the Fortran library are compiled by the same commands
                for tests in ([ANSWERS], self.python_tests(mutant.file)):
                    if tests and not passes(*self.pytest(objects, folder, tests)):
                        return f"killed by {tests[0]}, or what follows"
        return "survived"

    def pytest(self, objects: list[str], folder: Path, tests: list[str]) -> tuple:
        """Return the command that runs Python tests with the mutant, its folder, and its CPU seconds."""
        site = folder / "site"
        if not site.exists():
            core = copy_package(site, self.package.folder)
            self.package.link(f"python/{core_of(self.package.folder).name}", objects, core)
            self.package.link("src/vibroimpact-batch", objects, site / "vibroimpact-batch")
        return pytest(site, site / "vibroimpact-batch", *tests)


class Switched(Compiled):
    """What tries a mutant where one build holds nearly all of them (switched.py); the others are compiled."""

    #: Seconds of Python tests that are tried, as they took in the build that counts; and of those that take long.
    MOST, MOST_LONG = 80.0, 300.0

    def __init__(self, fortran: Path, package: Path, folder: Path, jobs: int, long: bool):
        super().__init__(fortran, package)
        self.try_long = long
        self.folder = folder
        self.checked = Checked(ROOT / "build/checked")
        statements = Statements(folder)
        self.statements = statements
        self.numbers, self.of_number = statements.numbers, statements.of_number
        self.programs = reaching.fortran(folder)
        self.tests, self.long = reaching.python(folder, jobs)
        self.reached = self.tests.keys() | set().union(*self.programs.values())
        self.asked = threading.local()
        self.seconds = {name: seconds for found in self.tests.values() for seconds, name in found}
        #: Of each test, whether it passes without a mutant.
        self.sound: dict[str, bool] = {}

    def python_tests(self, file: str) -> list[str]:
        """Return the tests that reach most of the statements of a file."""
        first = {self.of_number[number] for key, number in self.numbers.items() if key[0] == file}
        seconds = {name: took for number in first for took, name in self.tests.get(number, ())}
        often = Counter(name for number in first for _, name in self.tests.get(number, ()))
        return self.affordable([(seconds[name], name) for name, _ in often.most_common()])

    def affordable(self, tests: list[tuple[float, str]], long: bool = False) -> list[str]:
        """Return the first of some tests that do not take too long together."""
        chosen, left = [], self.MOST_LONG if long else self.MOST
        for seconds, name in tests:
            if (name in self.long) is long and seconds <= left and self.sound.get(name, True):
                chosen.append(name)
                left -= seconds
        return chosen

    def __call__(self, mutant: Mutant) -> str:
        """Return what became of a mutant."""
        number = self.numbers.get((mutant.file, mutant.line, mutant.after))
        outcome = super().__call__(mutant) if number is None else self.switched(number)
        if outcome == "survived" and self.checked(
            mutant, lambda library: self.kept_answers(number or 0, library)
        ):
            return "killed by the checks of the debug build"
        if outcome == "survived" and number and self.try_long:
            failing = self.failing(number, long=True)
            outcome = f"killed by {failing}" if failing else outcome
        return outcome

    def switched(self, number: int) -> str:
        """Return what became of a mutant that the build holds."""
        statement = self.statements.nearest(self.of_number[number], self.reached)
        # a case takes less time than any test
        if not self.kept_answers(number):
            return "killed by the kept answers"
        for room in (room for room in ROOMS if statement in self.programs[room]):
            if not self.passes(room, number) and self.is_sound(room):
                return f"killed by {room}"
        failing = self.failing(number)
        return f"killed by {failing}" if failing else "survived"

    def failing(self, number: int, long: bool = False) -> str:
        """Return the Python test that detects a mutant, "" if none does."""
        statement = self.statements.nearest(self.of_number[number], self.reached)
        chosen = self.affordable(sorted(self.tests.get(statement, ())), long)
        while chosen and (failed := self.failed(chosen, number)) is not None:
            if failed in chosen and not self.passes([failed], number):
                if self.is_sound(failed):
                    return failed
                chosen.remove(failed)
                continue
            # a crash does not name the test, or the test fails only after others: do they fail without a mutant?
            wrong = self.failed(chosen, 0)
            if wrong is None:
                return "Python tests"
            if wrong not in chosen:
                return ""
            chosen.remove(wrong)
        return ""

    def kept_answers(self, number: int, library: Path | None = None) -> bool:
        """Return whether the kept answers let a mutant pass (or a library); each thread asks a process."""
        if not hasattr(self.asked, "process"):
            self.asked.process = subprocess.Popen(
                [sys.executable, HERE / "kills.py", self.folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                text=True, bufsize=1,
                # fill allocated memory so that it holds -1e303 and -16843010, not zeros by chance
                env=os.environ | {"MALLOC_PERTURB_": "1"},
            )  # fmt: skip
            if self.asked.process.stdout.readline() != "ready\n":
                raise RuntimeError("the kept answers cannot be tried")
        print(number, library or "", file=self.asked.process.stdin, flush=True)
        return not self.asked.process.stdout.readline().startswith("killed")

    def is_sound(self, test: str) -> bool:
        """Return whether a test passes without a mutant; otherwise it would kill all of them."""
        if test not in self.sound:
            self.sound[test] = self.passes(test if test in ROOMS else [test], 0)
            if not self.sound[test]:
                print(f"{test} is left out: it fails without a mutant", flush=True)
        return self.sound[test]

    def failed(self, tests: list[str], number: int) -> str | None:
        """Return the first of some Python tests that fails, "" if it is not known which, None if all pass."""
        plain = self.folder / "plain"
        command, folder, _, end = pytest(plain / "site", plain / "src/vibroimpact-batch", *tests)
        # they took longer in the counting build
        seconds = int(30 + 3 * sum(self.seconds[name] for name in tests))
        well, said = ended(command, folder, seconds, end, {"VIBROIMPACT_MUTANT": str(number)})
        if well:
            return None
        found = re.search(r"^FAILED (.*?)(?: - .*)?$", said, re.MULTILINE)
        return found[1] if found else ""

    def passes(self, test: str | list[str], number: int) -> bool:
        """Return whether the Fortran tests of a folder pass, or some Python tests."""
        chosen = {"VIBROIMPACT_MUTANT": str(number)}
        if isinstance(test, list):
            return self.failed(test, number) is None
        with tempfile.TemporaryDirectory(prefix="mutant-") as home:
            program = self.folder / f"plain/tests/fortran/test_{test}"
            return passes([program], Path(home), 150, FORTRAN_END, chosen)


def listed() -> dict[tuple[str, str, str], str]:
    """Return the survivors that are known: file, line and mutated line, and the reason."""
    known = {}
    for entry in re.split(r"\n\s*\n", (HERE / "survivors.txt").read_text(encoding="utf-8")):
        lines = [line for line in entry.splitlines() if line.strip() and not line.startswith("#")]
        if lines:
            file, before, after, *reason = lines
            known[file.strip(), before[2:].strip(), after[2:].strip()] = " ".join(reason)
    return known


def core_files() -> list[str]:
    """Return the files of the folders that are tried."""
    return [
        str(path.relative_to(ROOT))
        for folder in ROOMS
        for path in sorted((ROOT / "src" / folder).glob("*.f90"))
    ]


def sample(files: list[str], size: int | None, seed: int) -> list[Mutant]:
    """Return mutants of files, `size` of them drawn by the seed; a change of one line changes few of them."""

    ranked, seen = [], Counter()
    for file in files:
        for mutant in mutants_of(ROOT, file):
            text = f"{seed} {mutant.file} {mutant.before} {mutant.after}"
            # the same change of another line is drawn on its own
            seen[text] += 1
            text += f" {seen[text]}" if seen[text] > 1 else ""
            ranked.append((hashlib.sha256(text.encode()).digest(), mutant))
    return [mutant for _, mutant in sorted(ranked, key=lambda pair: pair[0])[:size]]


def count(text: str) -> int:
    """Return a whole number >= 1 of the command line."""
    if not re.fullmatch(r"0*[1-9]\d{0,8}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to 999999999")
    return int(text)


def percentage(text: str) -> float:
    """Return a percentage of the command line."""
    if not re.fullmatch(r"\d{1,3}(\.\d*)?", text) or float(text) > 100:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0 to 100")
    return float(text)


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        prog="./run mutate",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--sample", type=count, metavar="N", help="so many mutants, drawn at random (default: all)"
    )
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="seed of the sample (1)")
    parser.add_argument(
        "--file",
        action="append",
        default=[],
        metavar="PATTERN",
        help="files, such as 'src/studies/zones/*.f90'",
    )
    parser.add_argument(
        "--fortran-only",
        action="store_true",
        help="leave the Python tests out; then survivors need no reason",
    )
    parser.add_argument(
        "--long",
        action="store_true",
        help="try survivors on the tests that take long, too: five minutes for each",
    )
    parser.add_argument(
        "--least",
        type=percentage,
        default=95,
        metavar="P",
        help="percentage of mutants to be killed at least (95)",
    )
    parser.add_argument(
        "-j", "--jobs", type=count, default=1, metavar="N", help="mutants at a time (1)"
    )
    parser.add_argument(
        "--switched", type=Path, default=ROOT / "build/switched", help=argparse.SUPPRESS
    )
    parser.add_argument(
        "--build", type=Path, default=ROOT / "build/fortran", help=argparse.SUPPRESS
    )
    return parser.parse_args()


def main() -> int:
    """Try mutants and report their outcomes."""
    asked = arguments()
    files = [
        file
        for file in core_files()
        if not asked.file or any(fnmatch(file, pattern) for pattern in asked.file)
    ]
    if not files:
        sys.exit(f"mutate: no file of {', '.join(ROOMS)} is named so: {', '.join(asked.file)}")
    if asked.fortran_only:
        trial = Compiled(asked.build, None)
    else:
        prepare(asked.switched)
        trial = Switched(
            asked.build, ROOT / "build/editable", asked.switched, asked.jobs, asked.long
        )
    tests = digest(
        *(ROOT / "tests").glob("*/*.py"),
        *(ROOT / "tests/fortran").glob("*.f90"),
    )
    what = f"{tests}{asked.fortran_only}{asked.long}"
    store = ROOT / "build/mutation/results.jsonl"
    store.parent.mkdir(parents=True, exist_ok=True)
    kept = {}
    if store.exists():
        for line in store.read_text(encoding="utf-8").splitlines():
            key, outcome, under = json.loads(line)
            if not outcome.startswith("survived") or under == what:
                kept[key] = outcome
    known, lock = listed(), threading.Lock()
    prints = {file: digest(ROOT / file) for file in files}

    def run(mutant: Mutant) -> tuple[Mutant, str]:
        key = f"{mutant} {prints[mutant.file]}"
        outcome = kept.get(key)
        if outcome is None:
            outcome = trial(mutant)
            with lock, store.open("a", encoding="utf-8") as out:
                print(json.dumps([key, outcome, what]), file=out)
            if outcome == "survived":
                print(f"{mutant}\n", flush=True)
        return mutant, outcome

    with ThreadPoolExecutor(asked.jobs) as pool:
        outcomes = list(pool.map(run, sample(files, asked.sample, asked.seed)))
    return report(outcomes, known, asked)


def report(outcomes: list[tuple[Mutant, str]], known: dict, asked: argparse.Namespace) -> int:
    """Print the table by folder and the survivors that are not listed; return the exit status."""
    counts: dict[str, Counter] = {folder: Counter() for folder in (*ROOMS, "all")}
    new = []
    for mutant, outcome in outcomes:
        word = outcome.split(" by ")[0]
        if word == "survived":
            reason = known.get((mutant.file, mutant.before.strip(), mutant.after.strip()))
            word = (
                "unlisted"
                if reason is None
                else "equivalent"
                if reason.startswith("equivalent")
                else "listed"
            )
            if reason is None:
                new.append(mutant)
        for row in (mutant.file.split("/")[1], "all"):
            counts[row][word] += 1
    words = ("killed", "listed", "unlisted", "equivalent", "not valid")
    print(f"{'folder':<10}" + "".join(f"{word:>12}" for word in words) + f"{'ratio':>9}")
    for folder, count in counts.items():
        real = count["killed"] + count["listed"] + count["unlisted"]
        ratio = f"{100 * count['killed'] / real:8.1f}%" if real else ""
        print(f"{folder:<10}" + "".join(f"{count[word]:>12}" for word in words) + ratio)
    if not asked.fortran_only:
        for mutant in new:
            print(f"\nno test fails, and survivors.txt gives no reason:\n{mutant}")
    count = counts["all"]
    real = count["killed"] + count["listed"] + count["unlisted"]
    return int(100 * count["killed"] < asked.least * real or (bool(new) and not asked.fortran_only))


if __name__ == "__main__":
    sys.exit(main())
