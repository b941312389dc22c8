"""The installed library for C, and calls of programs."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ.get("VIBROIMPACT_FORTRAN_BUILD", ROOT / "build/fortran"))


def call(*words, **options):
    """Run a program that must succeed; its stdout."""
    options = {"timeout": 1800, "stdin": subprocess.DEVNULL, **options}
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{words[0]}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def tool(name):
    """A program of the environment, or of the system."""
    beside = Path(sys.executable).parent / name
    return str(beside) if beside.exists() else name


@dataclass(frozen=True)
class Installed:
    """The program, the folder with include and lib, and the flags by pkg-config."""

    program: Path
    prefix: Path
    libdir: Path
    flags: tuple[str, ...]

    def environment(self):
        """Environment in which other programs find the library."""
        return {
            **os.environ,
            "LD_LIBRARY_PATH": str(self.libdir),
            "CMAKE_PREFIX_PATH": str(self.prefix),
            "PKG_CONFIG_PATH": str(self.libdir / "pkgconfig"),
        }

    def compile(self, source, target, *options, compiler="cc"):
        """Compile one file against the library."""
        paths = [source, "-o", target, *self.flags, f"-Wl,-rpath,{self.libdir}", "-lm", "-lpthread"]
        call(*compiler.split(), *options, *paths)
        return target
