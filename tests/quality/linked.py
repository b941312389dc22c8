"""Compiles a mutant alone and links it before the library that a build has made; and limits what tries it."""

import contextlib
import functools
import gzip
import json
import os
import re
import resource
import shlex
import subprocess
import sys
from pathlib import Path

from mutants import Mutant
from package import variables

ROOT = Path(__file__).resolve().parents[2]
#: The folders that are tried, and the Fortran tests that see a change there: their own first.
ROOMS = {
    "numerics": ("numerics", "mechanics", "motions", "studies"),
    "mechanics": ("mechanics", "motions", "studies"),
    "motions": ("motions", "studies"),
    "cases": ("cases", "studies"),
    "studies": ("studies",),
}
#: The last line of output of tests that pass.
FORTRAN_END, PYTHON_END = rb" passed, 0 failed", rb"\d+ passed.* in [\d.]+s( \(.*\))?"
#: Cases of all studies with kept answers.
ANSWERS = "tests/python/test_answers.py"
#: Fill uninitialised values, so that they are not 0 or false by chance.
OPTIONS = ("-finit-real=nan", "-finit-logical=true")


class Build:
    """A folder with a build, whose commands are repeated with another source."""

    def __init__(self, folder: Path, options: tuple[str, ...] = OPTIONS):
        if not (folder / "compile_commands.json").exists():
            sys.exit(f"mutate: nothing is built in {folder}; ./run test builds")
        self.folder, self.options = folder, options
        self.commands: dict[str, list[list[str]]] = {}
        for entry in json.loads((folder / "compile_commands.json").read_text(encoding="utf-8")):
            # files of the core are compiled again in single precision, those of lanes for wide registers
            name = re.sub(r"_(single|wide)\.f90$", ".f90", Path(entry["file"]).name)
            self.commands.setdefault(name, []).append(shlex.split(entry["command"]))

    @functools.cache  # noqa: B019
    def linking(self, target: str) -> tuple[str, ...]:
        """Return the command that links a target."""
        ask = ["ninja", "-C", self.folder, "-t", "commands", "-s", target]
        said = subprocess.run(ask, check=True, capture_output=True, text=True).stdout
        return tuple(shlex.split(said.splitlines()[-1]))

    def compile(self, mutant: Mutant, folder: Path) -> list[str] | None:
        """Return the objects of a mutant; None if it does not compile, or changes what its users see."""
        objects = []
        folder.mkdir()
        plain = folder / Path(mutant.file).name
        plain.write_text(mutant.source(ROOT), encoding="utf-8")
        for words in self.commands[plain.name]:
            source = plain
            for twin in ("single", "wide"):
                if words[-1].endswith(f"_{twin}.f90"):
                    source = folder / Path(words[-1]).name
                    subprocess.run(
                        [sys.executable, ROOT / f"src/{twin}_source.py", plain, source], check=True
                    )
            modules = folder / f"{source.stem}.modules"
            modules.mkdir()
            objects.append(str(source.with_suffix(".o")))
            kept = [word for word in words[:-1] if not word.startswith(("-J", "-W"))]
            kept[kept.index("-o") + 1] = objects[-1]
            kept += ["-O1", "-w", "-finit-integer=-77777", *self.options, f"-J{modules}"]
            if subprocess.run(
                [*kept, str(source)],
                cwd=self.folder,
                capture_output=True,
            ).returncode:
                return None
            there = self.folder / next(word[2:] for word in words if word.startswith("-J"))
            if any(
                declared(module) != declared(there / module.name) for module in modules.iterdir()
            ):
                return None
        return objects

    def link(self, target: str, objects: list[str], out: Path) -> bool:
        """Link a target, with these objects in the place of the library's; return whether that went well."""
        words = list(self.linking(target))
        words[words.index("-o") + 1] = str(out)
        first = next(
            i for i, word in enumerate(words) if word.endswith(".a") or word == "-Wl,--start-group"
        )
        command = [*words[:first], *objects, *words[first:]]
        return subprocess.run(command, cwd=self.folder, capture_output=True).returncode == 0


def declared(module: Path) -> bytes:
    """Return the contents of a module file without the name of its source."""
    return gzip.decompress(module.read_bytes()).split(b"\n", 1)[1]


def passes(command: list, folder: Path, cpu: int, end: bytes, more: dict | None = None) -> bool:
    """Return whether a command succeeds within these CPU seconds and 8 GiB; `more` adds to its environment."""
    return ended(command, folder, cpu, end, more)[0]


def ended(
    command: list, folder: Path, cpu: int, end: bytes, more: dict | None = None
) -> tuple[bool, str]:
    """Return whether a command succeeds, as in `passes`, and what it printed.

    The end of its output has to match `end`, because a library may end a program with a success status, as LAPACK
    does where an argument is not a number.
    """

    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (cpu, cpu))
        resource.setrlimit(resource.RLIMIT_AS, (2**33, 2**33))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    with contextlib.suppress(subprocess.TimeoutExpired):
        done = subprocess.run(
            command, cwd=folder, capture_output=True, preexec_fn=limit, timeout=30 * cpu, stdin=subprocess.DEVNULL,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "STOP_AT_FAILURE": "1", "MALLOC_PERTURB_": "1"}
            | (more or {}),
        )  # fmt: skip
        well = done.returncode == 0 and re.search(end + rb"\s*\Z", done.stdout) is not None
        return well, done.stdout.decode(errors="replace")
    return False, ""


def pytest(site: Path, program: Path, *tests: str) -> tuple[list, Path, int, bytes]:
    """Return the command that runs a file of Python tests with a copy of the package, its folder, CPU seconds."""
    return (
        [
            "env", *(f"{name}={value}" for name, value in variables(site, program).items()),
            sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider",
            "-m", "not browser", *tests,
        ], ROOT, 120 if tests == (ANSWERS,) else 600, PYTHON_END,
    )  # fmt: skip
