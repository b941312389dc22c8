"""Try mutants in a build with run-time checks of bounds, pointers and uninitialised numbers."""

import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from linked import FORTRAN_END, ROOMS, Build, passes, pytest
from mutants import Mutant
from package import copy_package, core_of

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = "src/c/libvibroimpact.so.0.1.0"
#: Calls of procedures that no case reaches.
CALLS = "tests/python/test_kept_calls.py"
CHECKS = ("-fcheck=all", "-finit-real=snan", "-finit-integer=-987654321", "-finit-logical=true",
          "-finit-derived")  # fmt: skip


class Checked:
    """A debug build, in a folder of its own."""

    def __init__(self, folder: Path):
        if not (folder / "build.ninja").exists():
            words = ["meson", "setup", folder, ROOT, "-Dpython=enabled", "-Dlibrary_for_c=enabled",
                     "-Dbuildtype=debug", f"-Dfortran_args={' '.join(CHECKS)}"]  # fmt: skip
            subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        programs = (f"tests/fortran/test_{room}" for room in ROOMS)
        subprocess.run(
            ["ninja", "-C", folder, "all", *programs], check=True, stdout=subprocess.DEVNULL
        )
        self.build = Build(folder, CHECKS)

    def __call__(self, mutant: Mutant, kept_answers: Callable[[Path], bool]) -> bool:
        """Return whether a mutant is killed: by kept answers, kept calls, or Fortran tests for its file."""
        with tempfile.TemporaryDirectory(prefix="checked-") as made:
            folder = Path(made)
            objects = self.build.compile(mutant, folder / "core")
            library = folder / "library.so"
            if objects is None or not self.build.link(LIBRARY, objects, library):
                return False
            if not kept_answers(library):
                return True
            site, core = folder / "site", core_of(self.build.folder)
            program = self.build.folder / "src/vibroimpact-batch"
            self.build.link(f"python/{core.name}", objects, copy_package(site, self.build.folder))
            if not passes(*pytest(site, program, CALLS)):
                return True
            for room in ROOMS[mutant.file.split("/")[1]]:
                program = folder / f"test_{room}"
                if self.build.link(f"tests/fortran/{program.name}", objects, program):
                    if not passes([program], folder, 300, FORTRAN_END):
                        return True
                    program.unlink()
        return False
