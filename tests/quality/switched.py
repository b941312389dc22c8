"""Builds a core that contains nearly all mutants; a number selects one of them at run time.

usage: switched.py [FOLDER]

Mutants therefore need no separate compilation. The sources in FOLDER (build/switched) contain each statement
together with its mutants. Programs, package and C library behave like the original core or, with
VIBROIMPACT_MUTANT=N, like mutant N. Mutants that are not in executable statements (such as declarations of
constants) or do not compile are omitted. `mutants.json` contains, for each number, the mutant and the lines of its
statement in the compiled sources. There are two builds: `plain`, and `counted`, which counts the blocks that it
reaches (reached.c) and so shows which tests reach a statement.
"""

import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from itertools import groupby
from pathlib import Path

from mutants import DECLARATION, Mutant, closing, code_of, mutants_of
from package import copy_package, core_of
from statements import Statements

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
ROOMS = ("numerics", "mechanics", "motions", "studies", "cases")
#: File with the statements that the Python tests reach (reaching.py).
REACHED_BY_TESTS = "python.json"
#: The variable, in a module that all others can use.
MODULE = """
!> Which mutant is tried; 0 for none.
module which_mutant
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none
   integer(c_int), bind(C, name='vibroimpact_mutant') :: mutant_here = 0
end module which_mutant
"""
#: What chooses it by the environment; a build that counts begins with the first address of its file.
CHOICE = """
extern int vibroimpact_mutant;
extern void count_from(uintptr_t) __attribute__((weak));
extern const char __ehdr_start[] __attribute__((visibility("hidden")));
__attribute__((constructor)) void vibroimpact_choose(void)
{
    const char *number = getenv("VIBROIMPACT_MUTANT");
    vibroimpact_mutant = number ? atoi(number) : 0;
    if (count_from)
        count_from((uintptr_t)__ehdr_start);
}
"""
CONDITION = re.compile(r"((?:\w+\s*:\s*)?(?:(?:else\s+)?if|do\s+while)\s*)\(", re.IGNORECASE)
LOOP = re.compile(r"((?:\w+\s*:\s*)?do\s+\w+\s*=)\s*(.*)$", re.IGNORECASE)
#: What opens a block in another way, or is no statement.
OTHER = re.compile(
    r"(else\b|case\b|select\b|associate\b|block\b|do\b|(\w+\s*:\s*)(select|associate|block|do|if)\b"
    r"|where\s*\(.*\)$|elsewhere|forall)",
    re.IGNORECASE,
)
ELEMENT = re.compile(r"\w\(\d+\)%")
LONG = "-ffree-line-length-none"


class Source:
    """A source in which the mutants of a statement follow it."""

    def __init__(self, file: str, mutants: list[Mutant], first: int):
        self.lines = (ROOT / file).read_text(encoding="utf-8").splitlines()
        self.file, self.first = file, first
        self.out: list[str] = []
        #: By number: the mutant; of each statement its lines; and of each line of a mutant its number.
        self.held: dict[int, Mutant] = {}
        self.places: dict[int, tuple[int, int]] = {}
        self.owners: dict[int, int] = {}
        self.here: list[tuple[int, Mutant]] = []
        by_line = {line: list(items) for line, items in groupby(mutants, key=lambda m: m.line)}
        directive = False
        for begin, end in statements(self.lines):
            text = self.lines[begin:end]
            changes = [m for line in range(begin, end) for m in by_line.get(line + 1, ())]
            if (
                not changes
                or directive
                or any(map(in_text, text))
                or DECLARATION.match(joined(text))
            ):
                self.out += text
            else:
                self.statement(begin, text, changes)
            if re.match(r"\s*(sub)?module\s+(?!procedure|subroutine|function|pure)", text[0]):
                self.out.append("   use which_mutant, only: mutant_here")
            if text[0].strip():
                directive = text[0].strip().startswith("!$omp")

    def number(self, changes: list[Mutant]) -> list[int]:
        """Number the mutants of one statement consecutively."""
        numbers = [self.first + len(self.held) + i for i in range(len(changes))]
        self.held |= dict(zip(numbers, changes, strict=True))
        return numbers

    def mutated(self, begin: int, text: list[str], mutant: Mutant) -> list[str]:
        """Return the lines of a statement with a mutant."""
        place = mutant.line - 1 - begin
        return [*text[:place], mutant.after, *text[place + 1 :]]

    def emit(self, lines: list[str], owner: int) -> None:
        """Add lines of one mutant."""
        for line in lines:
            self.out.append(line)
            self.owners[len(self.out)] = owner

    def place(self, numbers: list[int], begin: int) -> None:
        """Note which lines tell that a statement was reached."""
        for number in numbers:
            self.places[number] = begin, len(self.out)

    def statement(self, begin: int, text: list[str], changes: list[Mutant]) -> None:
        """Add a statement with its mutants."""
        whole = joined(text)
        if (found := CONDITION.match(whole)) and re.fullmatch(
            r"(then)?( \w+)?", rest(whole, found.end())
        ):
            # gfortran may evaluate what is not asked for: an element that is not there has no components
            safe = [m for m in changes if ELEMENT.findall(m.before) == ELEMENT.findall(m.after)]
            if safe:
                self.condition(begin, text, safe, whole, found.end())
            else:
                self.out += text
        elif found := LOOP.match(whole):
            self.loop(begin, text, changes, found)
        elif OTHER.match(whole):
            self.out += text
        else:
            numbers = self.number(changes)
            self.out.append(
                f"if (mutant_here < {numbers[0]} .or. mutant_here > {numbers[-1]}) then"
            )
            start = len(self.out) + 1
            self.out += text
            self.place(numbers, start)
            self.out += ["else", "select case (mutant_here)"]
            for number, mutant in zip(numbers, changes, strict=True):
                self.out.append(f"case ({number})")
                self.emit(self.mutated(begin, text, mutant), number)
            self.out += ["end select", "end if"]

    def condition(self, begin, text, changes, whole, opens):
        """Add the head of a block that depends on a condition."""
        numbers = self.number(changes)
        start = len(self.out) + 1
        self.out.append(whole[:opens] + " &")
        for number, mutant in zip(numbers, changes, strict=True):
            changed = joined(self.mutated(begin, text, mutant))
            begins = CONDITION.match(changed).end()
            inner = changed[begins : closing(code_of(changed), begins)]
            self.emit([f"(mutant_here == {number} .and. ({inner})) .or. &"], number)
        inner = whole[opens : closing(code_of(whole), opens)]
        outside = f"mutant_here < {numbers[0]} .or. mutant_here > {numbers[-1]}"
        self.out.append(f"(({outside}) .and. ({inner}))) {rest(whole, opens)}")
        self.place(numbers, start)

    def loop(self, begin, text, changes, found):
        """Add the head of a counted loop; both forms of a bound are evaluated."""
        bounds = split(found[2])
        usable = []
        for mutant in changes:
            changed = split(LOOP.match(joined(self.mutated(begin, text, mutant)))[2])
            different = [i for i, bound in enumerate(changed) if bound != bounds[i]]
            if len(changed) == len(bounds) and len(different) == 1:
                usable.append((mutant, different[0], changed[different[0]]))
        numbers = self.number([mutant for mutant, _, _ in usable])
        start = len(self.out) + 1
        self.out.append(found[1] + " &")
        for place, bound in enumerate(bounds):
            own = [(n, new) for n, (_, at, new) in zip(numbers, usable, strict=True) if at == place]
            for number, new in own:
                self.emit([f"merge({new}, &"], number)
            self.out.append(f"{bound} &")
            for number, _ in reversed(own):
                self.out.append(f", mutant_here == {number}) &")
            if place + 1 < len(bounds):
                self.out.append(", &")
        self.out[-1] = self.out[-1][:-1]
        self.place(numbers, start)


def statements(lines):
    """Yield the lines of each statement: begin and end, counted from 0."""
    place = 0
    while place < len(lines):
        begin, more = place, True
        while more:
            code, open_text = code_of(lines[place]), in_text(lines[place])
            comment = lines[place].strip()[:1] in ("", "!")
            more = open_text or code.rstrip().endswith("&") or (place > begin and comment)
            while open_text:
                # a text that continues in the next line
                place += 1
                open_text = lines[place].rstrip().endswith("&")
            place += 1
        yield begin, place


def in_text(line):
    """Return whether a text that begins in a line continues in the next one."""
    return line.rstrip().endswith("&") and any(
        # code follows a closed text
        code_of(line + quote + "x").endswith("x") and not code_of(line + "x").endswith("x")
        for quote in "'\""
    )


def joined(lines):
    """Return a statement on one line, without comments."""
    parts = []
    for line in lines:
        # a ! within a text does not begin a comment
        marks = (i for i, char in enumerate(line) if char == "!")
        part = line[
            : next((i for i in marks if code_of(line[:i] + "x").endswith("x")), None)
        ].strip()
        parts.append(part.removeprefix("&").removesuffix("&").strip())
    return " ".join(part for part in parts if part)


def rest(text, opens):
    """Return what follows the parenthesis that closes the one opened before an index."""
    return text[closing(code_of(text), opens) + 1 :].strip()


def split(text):
    """Split a text at the commas outside parentheses."""
    parts, depth = [""], 0
    for char, real in zip(code_of(text), text, strict=True):
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(char, 0)
        if char == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += real
    return [part.strip() for part in parts]


def checked(file, mutants, first, commands, folder):
    """Return the source without the mutants that do not compile."""
    while True:
        source = Source(file, mutants, first)
        path = folder / Path(file).name
        path.write_text("\n".join(source.out) + "\n", encoding="utf-8")
        words = [word for word in commands[path.name] if not word.startswith(("-J", "-W", "-MD"))]
        home = next(word[2:] for word in commands[path.name] if word.startswith("-J"))
        words[words.index("-o") + 1] = str(folder / "no.o")
        modules = folder / "modules"
        modules.mkdir(exist_ok=True)
        words = [*words[:-1], "-fsyntax-only", "-fmax-errors=0", "-fdiagnostics-color=never", "-w", LONG,
                 f"-J{modules}", f"-I{folder}"]  # fmt: skip
        done = subprocess.run(
            [*words, f"-I{home}", str(path)],
            cwd=ROOT / "build/fortran",
            capture_output=True,
            text=True,
        )
        if done.returncode == 0:
            return source
        wrong = {
            source.owners.get(int(line))
            for line in re.findall(rf"^{re.escape(str(path))}:(\d+):", done.stderr, re.MULTILINE)
        }
        bad = {source.held[number] for number in wrong if number is not None}
        if not bad:
            sys.exit(f"switched: {file} does not compile:\n{done.stderr[:3000]}")
        mutants = [mutant for mutant in mutants if mutant not in bad]


def prepare(folder: Path) -> None:
    """Bring the builds in a folder up to date with the sources and the tests."""
    mark, tree = folder / "mark", folder / "tree"
    sources = [path for path in tracked() if path.is_relative_to(ROOT / "src")]
    now = digest(*sources, Path(__file__), HERE / "mutants.py")
    if not mark.exists() or mark.read_text(encoding="utf-8") != now:
        before = reached_by_tests(folder)
        shutil.rmtree(folder, ignore_errors=True)
        write(folder, tree)
        carry(before, folder)
        build(folder, tree, counted=False)
        build(folder, tree, counted=True)
        mark.write_text(now, encoding="utf-8")
        return
    changed = [
        path for path in tracked()
        if path.is_relative_to(ROOT / "tests/fortran")
        and (not (copy := tree / path.relative_to(ROOT)).exists() or copy.read_bytes() != path.read_bytes())
    ]  # fmt: skip
    for path in changed:
        shutil.copy(path, tree / path.relative_to(ROOT))
    if changed:
        ninja(folder / "plain")
        ninja(folder / "counted")


def reached_by_tests(folder: Path) -> dict[str, dict]:
    """Return the notes of reaching.py about files of Python tests, with statements by name."""
    note = folder / REACHED_BY_TESTS
    if not note.exists():
        return {}
    names = Statements(folder).names()
    files = json.loads(note.read_text(encoding="utf-8"))
    for noted in files.values():
        noted["tests"] = [
            [test, seconds, [names[number] for number in reached]]
            for test, seconds, reached in noted["tests"]
        ]
    return files


def carry(files: dict[str, dict], folder: Path) -> None:
    """Note it for a new build, in which most statements are what they were: to find it takes half an hour."""
    numbers = {name: number for number, name in Statements(folder).names().items()}
    for noted in files.values():
        noted["tests"] = [
            [test, seconds, [numbers[name] for name in reached if name in numbers]]
            for test, seconds, reached in noted["tests"]
        ]
    if files:
        (folder / REACHED_BY_TESTS).write_text(json.dumps(files), encoding="utf-8")


def tracked() -> list[Path]:
    """Return the files of the project."""
    listed = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    said = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [path for name in said.splitlines() if (path := ROOT / name).is_file()]


def digest(*paths: Path) -> str:
    """Return a fingerprint of files."""
    made = hashlib.sha256()
    for path in sorted(paths):
        made.update(path.read_bytes())
    return made.hexdigest()[:16]


def write(folder: Path, tree: Path) -> None:
    """Write the sources with their mutants, and the list of these."""
    check = folder / "check"
    check.mkdir(parents=True)
    for path in tracked():
        copy = tree / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, copy)
    commands = {}
    for entry in json.loads((ROOT / "build/fortran/compile_commands.json").read_text()):
        commands.setdefault(Path(entry["file"]).name, shlex.split(entry["command"]))
    (check / "which.f90").write_text(MODULE, encoding="utf-8")
    subprocess.run(["gfortran", "-fsyntax-only", "which.f90"], cwd=check, check=True)
    index, first = [], 1
    for path in (path for room in ROOMS for path in sorted((ROOT / "src" / room).glob("*.f90"))):
        file = str(path.relative_to(ROOT))
        mutants = mutants_of(ROOT, file)
        source = checked(file, mutants, first, commands, check)
        (tree / file).write_text("\n".join(source.out) + "\n", encoding="utf-8")
        for number, mutant in source.held.items():
            begin, end = source.places[number]
            index.append(
                [number, mutant.file, mutant.line, mutant.before, mutant.after, begin, end]
            )
        print(f"{file}: {len(source.held)} of {len(mutants)}", flush=True)
        first += len(source.held)
    kinds = tree / "src/numerics/kinds.f90"
    kinds.write_text(MODULE + kinds.read_text(encoding="utf-8"), encoding="utf-8")
    chosen = tree / "src/numerics/process.c"
    chosen.write_text(chosen.read_text(encoding="utf-8") + CHOICE, encoding="utf-8")
    shown = tree / "src/c/vibroimpact.map"
    text = shown.read_text(encoding="utf-8")
    shown.write_text(
        text.replace("  local:", "    vibroimpact_mutant;\n  local:"), encoding="utf-8"
    )
    (folder / "mutants.json").write_text(json.dumps(index), encoding="utf-8")


def build(folder: Path, tree: Path, counted: bool) -> None:
    """Build the core in a separate folder; with `counted` it counts the blocks that it reaches."""
    made = folder / ("counted" if counted else "plain")
    args = f"-g1 -w -finit-integer=-77777 -finit-real=-inf -finit-logical=true {LONG} -fno-frontend-optimize"
    links = "-Wl,-u,vibroimpact_choose"
    if counted:
        counter = [
            "gcc",
            "-O2",
            "-shared",
            "-fPIC",
            "-o",
            folder / "libreached.so",
            HERE / "reached.c",
        ]
        subprocess.run(counter, check=True)
        args += " -fsanitize-coverage=trace-pc"
        links += f" -L{folder} -lreached -Wl,-rpath,{folder}"
    run("meson", "setup", made, tree, "-Dpython=enabled", "-Dlibrary_for_c=enabled", "-Doptimization=1",
        "-Ddebug=false", "-Db_lundef=false", f"-Dfortran_args={args}", f"-Dfortran_link_args={links}",
        f"-Dc_link_args={links}")  # fmt: skip
    ninja(made)
    core = copy_package(made / "site", made)
    core.symlink_to(core_of(made))


def ninja(made: Path) -> None:
    """Build all in a folder, and the programs of the Fortran tests."""
    run("ninja", "-C", made, "all", *(f"tests/fortran/test_{room}" for room in ROOMS))


def run(*words) -> None:
    """Run meson or ninja from the folder of the Python interpreter."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    subprocess.run(words, check=True, env=os.environ | {"PATH": path}, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    prepare((ROOT / "build/switched") if len(sys.argv) < 2 else Path(sys.argv[1]).resolve())
