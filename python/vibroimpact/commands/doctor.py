"""`vibroimpact doctor`: what is installed, whether it computes correctly, and what is missing."""

from __future__ import annotations

import argparse
import ctypes
import math
import os
import platform
import re
import subprocess
import sys
from importlib import import_module, metadata
from importlib.resources import as_file, files
from typing import Any

from .. import _core
from ..base.errors import VibroimpactError
from ..motions.exact import exact
from ..systems.oscillator import Oscillator, Pattern

DESCRIPTION = """Report the compiler, the LAPACK library and the number of OpenMP threads in use, whether a
motion of the 1983 paper is computed correctly, and which optional libraries are installed;
for each missing one, its purpose and how to install it. Missing optional libraries are not
an error: the exit status is 0 if the package computes correctly."""
EXAMPLE = "vibroimpact doctor"

#: The purpose of each extra; those for developers are not checked.
PURPOSES = {
    "campaign": "campaigns (`vibroimpact campaign`), from Python 3.11 on",
    "completion": "completion in a shell (`vibroimpact completion`)",
    "data": "labelled tables (chart, to_xarray, to_pandas) and netCDF files",
    "design": "designs (`vibroimpact design`)",
    "explorer": "the explorer in a browser (`vibroimpact explore`)",
    "film": "MP4 films, if the program ffmpeg is missing",
    "identify": "identification from records (`vibroimpact identify`)",
    "jax": "derivatives in JAX (`vibroimpact.jax`)",
    "matlab": "MATLAB files",
    "plot": "pictures",
    "proof": "proofs with certificates (`Motion.prove`)",
    "reproduce": "`vibroimpact reproduce`",
    "uff": "records in universal files (UFF)",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    """It has no arguments."""


def run(options: argparse.Namespace) -> int:
    """Check everything, and print the results."""
    facts: dict[str, Any] = {
        "vibroimpact": metadata.version("vibroimpact"),
        "python": f"{platform.python_version()} ({platform.machine()} {platform.system()})",
        "numpy": metadata.version("numpy"),
        **{key: value for key, value in built().items() if key not in ("numpy", "openmp")},
        "threads": threads(),
        "program": program(),
        "computes": computes(),
    }
    for name, value in facts.items():
        print(f"{name + ':':<13} {value}")
    found = extras()
    advice = []
    for extra, libraries in found.items():
        missing = [name for name, version in libraries.items() if version is None]
        versions = ", ".join(
            f"{name} {version or 'MISSING'}" for name, version in libraries.items()
        )
        print(f"{'extra ' + extra + ':':<18} {versions}")
        if missing:
            advice.append(f"for {PURPOSES[extra]}: pip install 'vibroimpact[{extra}]'")
    if advice:
        advice.append("in a copy of the project: pip install '.[NAME]', with the name of the extra")
    advice += counsel(facts)
    for line in advice:
        print(line)
    options.record.add("doctor", {**facts, "extras": found, "advice": advice})
    return 0 if facts["computes"] == "yes" and facts["program"] != MISSING else 1


MISSING = "MISSING"


def built() -> dict[str, str]:
    """The build of the package."""
    facts: dict[str, str] = import_module("vibroimpact._build").FACTS
    return {**facts, "compiler": re.sub(r"^gcc\b", "gfortran", facts["compiler"])}


def threads() -> str:
    """How many threads OpenMP uses, and the number of processors."""
    processors = f"{os.cpu_count()} processors"
    if not built()["openmp"]:
        return f"1 of {processors} (built without OpenMP)"
    try:
        most = ctypes.CDLL(_core.__file__).omp_get_max_threads()
    except (OSError, AttributeError):  # the symbol is hidden in this library
        return processors
    chosen = os.environ.get("OMP_NUM_THREADS")
    setting = f" (OMP_NUM_THREADS = {chosen})" if chosen else ""
    return f"{most} of {processors}{setting}, OpenMP {built()['openmp']}"


def program() -> str:
    """The version that the stand-alone program reports."""
    with as_file(files("vibroimpact") / "_bin" / "vibroimpact-batch") as path:
        try:
            done = subprocess.run(
                [str(path), "--version"], capture_output=True, text=True, timeout=60
            )
        except (OSError, subprocess.SubprocessError):
            return MISSING
    return done.stdout.strip() or MISSING


def computes() -> str:
    """Whether the motion of the third column of Table 1 satisfies its equations, and det[P] its law."""
    try:
        osc = Oscillator(xi=0.005, mu=0.042, restitution=0.75)
        motion = exact(osc, 0.94, 37.0, ([0, 1.37 * math.pi], Pattern("RL")))
    except VibroimpactError as error:
        return f"NO: {error}"
    product = abs(motion.multipliers.prod())
    law = math.exp(-4 * math.pi * osc.xi / motion.r) * 0.75**4
    if motion.residual < 1e-12 and abs(product / law - 1) < 1e-9:
        return "yes"
    return f"NO: residual {motion.residual:.1e}, det[P] = {product:.15g} and not {law:.15g}"


def extras() -> dict[str, dict[str, str | None]]:
    """The libraries of each extra with their versions, or None for a missing library."""
    found: dict[str, dict[str, str | None]] = {}
    for line in metadata.requires("vibroimpact") or []:
        match = re.match(r"([\w.-]+).*;.*\bextra\s*==\s*['\"](\w+)['\"]", line)
        if match is None or match[2] not in PURPOSES:
            continue
        version: str | None
        try:
            version = metadata.version(match[1])
        except metadata.PackageNotFoundError:
            version = None
        found.setdefault(match[2], {})[match[1]] = version
    return dict(sorted(found.items()))


def counsel(facts: dict[str, Any]) -> list[str]:
    """Advice on anything slow or broken."""
    lines = []
    if not built()["openmp"]:
        lines.append(
            "charts and atlases would be faster with OpenMP: build with a compiler that supports it"
        )
    if "openblas" in facts["lapack"].lower() and os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        lines.append(
            "set OPENBLAS_NUM_THREADS=1: the systems are too small for several threads of OpenBLAS"
        )
    if facts["buildtype"] not in ("release", "debugoptimized"):
        lines.append(
            f"a build of type {facts['buildtype']} is slow: build with -Dbuildtype=release"
        )
    if facts["program"] == MISSING or facts["computes"] != "yes":
        lines.append(
            "reinstall the package, in a copy of the project: "
            f"{sys.executable} -m pip install --force-reinstall ."
        )
    return lines
