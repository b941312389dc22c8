"""Whether the installed wheel is self-contained; run by test_wheel.py with the Python it is installed for.

    python packaging/check_installed.py FILE.nml [compiler runtime lapack]

The words after the namelist say what should be out of sight, which is looked at first.
"""

import ctypes
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy.linalg

BIN = Path(sys.executable).parent
PACKAGES = Path(sysconfig.get_path("platlib"))
STDLIB = Path(sysconfig.get_config_var("DESTSHARED"))
#: What every machine has: the C library, and the compiler's library for unwinding the stack.
SYSTEM = re.compile(r"(libc|libm|libpthread|libdl|librt|libutil|libgcc_s|ld-linux[\w-]*)\.so\.\d+")
SOUGHT = {
    "runtime": ("libgfortran.so.5", "libgomp.so.1", "libquadmath.so.0"),
    "lapack": ("liblapack.so.3", "libblas.so.3", "libopenblas.so.0"),
}


def libraries():
    """The shared libraries that this process has loaded."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return {Path(line.split(maxsplit=5)[5]) for line in lines if ".so" in line}


def outsiders(loaded):
    """Those that are not in the environment, nor Python's own, nor on every machine."""
    own = (PACKAGES, STDLIB)
    return [
        path
        for path in loaded
        if not any(folder in path.parents for folder in own) and not SYSTEM.fullmatch(path.name)
    ]


def loadable(name):
    """Whether the system has that library."""
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


def run(*command, **environment):
    """What a command prints; it must succeed."""
    done = subprocess.run(
        [BIN / command[0], *command[1:]],
        env=os.environ | environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{command}: status {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def check_hidden(kinds):
    """What should be out of sight is."""
    if "compiler" in kinds:
        assert not [name for name in ("gfortran", "gcc", "cc", "f95") if shutil.which(name)]
    for kind in kinds:
        assert not [name for name in SOUGHT.get(kind, ()) if loadable(name)]


def check_module():
    """What the package loads when it computes on threads."""
    # Python's own modules go before, with the libraries that they need
    for path in STDLIB.glob("*.so"):
        loadable(path)
    before = libraries()
    import vibroimpact as vi

    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    motions = vi.equispaced(osc, r=0.94, clearance=37.0)
    vi.simulate_bundle(osc, r=numpy.linspace(0.9, 1, 9), clearance=37.0, cycles=9, threads=2)
    assert len(motions) == 2
    loaded = libraries() - before
    assert any(path.name.startswith("_core.") for path in loaded), loaded
    assert not outsiders(loaded), f"loaded from outside: {outsiders(loaded)}"
    return loaded


def check_program():
    """What the loader finds for the stand-alone program."""
    program = PACKAGES / "vibroimpact" / "_bin" / "vibroimpact-batch"
    done = subprocess.run(
        [program], env={"LD_TRACE_LOADED_OBJECTS": "1"}, capture_output=True, text=True
    )
    assert "not found" not in done.stdout + done.stderr, done.stdout + done.stderr
    found = {Path(path) for path in re.findall(r"(/\S+) \(0x", done.stdout)}
    assert any(path.name.startswith("libc.") for path in found), done.stderr
    # with its ../.. resolved
    found = {Path(os.path.normpath(path)) for path in found}
    assert not outsiders(found), f"the program needs from outside: {outsiders(found)}"
    return found


if __name__ == "__main__":
    check_hidden(sys.argv[2:])
    loaded = check_module() | check_program()
    print("libraries:", *sorted({path.name for path in loaded if PACKAGES in path.parents}))
    print(run("vibroimpact", "reproduce", "table1", "-o", "table1").splitlines()[-1])
    print(run("vibroimpact-batch", sys.argv[1], "-o", "results"), end="")
    told = run("vibroimpact", "doctor", OMP_NUM_THREADS="3")
    threads = re.search(r"threads: +(.*)", told)[1]
    assert threads.startswith("3 of ") or "without OpenMP" in threads, told
    print("threads:", threads)
