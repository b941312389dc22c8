"""Run a command that cannot see the machine's compiler, its run-time libraries or its LAPACK.

    python packaging/hide.py compiler runtime lapack -- COMMAND...

In a mount namespace of its own, gone with the command, files read as empty and folders have nothing
in them. Exit status 125: this machine allows no such namespace, and nothing was run.
"""

import os
import subprocess
import sys
from glob import glob
from pathlib import Path
from shutil import which

LIBRARIES = "/{usr/lib,lib,lib64,usr/lib64,usr/local/lib}/{*-linux-gnu/,}"
PROGRAMS = "/usr/{bin,local/bin}/{*-linux-gnu-,}"
HIDDEN = {
    "compiler": (
        *(PROGRAMS + name for name in ("gcc*", "cc", "c[89]9*", "gfortran*", "f77", "f95")),
        "/usr/{lib,libexec,lib64}/gcc",
    ),
    "runtime": tuple(f"{LIBRARIES}lib{name}.*" for name in ("gfortran", "quadmath", "gomp")),
    "lapack": (
        *(f"{LIBRARIES}{name}" for name in ("lapack", "blas", "lib*lapack*", "lib*blas*")),
        *(f"{LIBRARIES}pkgconfig/*{name}*.pc" for name in ("lapack", "blas")),
    ),
}
MOUNT = """
for path in $HIDDEN; do
  if [ -d "$path" ]; then mount --bind "$EMPTY" "$path"; else mount --bind /dev/null "$path"; fi || exit 125
done
unset HIDDEN EMPTY
exec "$@"
"""


def braces(pattern: str) -> list[str]:
    """What a pattern with alternatives in braces stands for, as in a shell."""
    if "{" not in pattern:
        return [pattern]
    front, _, rest = pattern.partition("{")
    choices, _, back = rest.partition("}")
    return [one for choice in choices.split(",") for one in braces(front + choice + back)]


def paths(kinds: list[str]) -> list[str]:
    """The files and folders to hide, without links; folders last, as they hold some of the files."""
    patterns = [one for kind in kinds for pattern in HIDDEN[kind] for one in braces(pattern)]
    found = {os.path.realpath(path) for pattern in patterns for path in glob(pattern)}
    return sorted(filter(os.path.exists, found), key=lambda path: (os.path.isdir(path), path))


def namespace() -> list[str]:
    """The command that makes a mount namespace here; empty if none does."""
    for command in (["unshare", "-m"], ["unshare", "-rm"]):
        probe = [*command, "mount", "--bind", "/dev/null", os.path.realpath("/bin/true")]
        if which("unshare") and subprocess.run(probe, capture_output=True).returncode == 0:
            return command
    return []


def hidden(kinds: list[str], command: list[str]) -> list[str]:
    """The command that runs a command without them; empty if this machine does not allow it."""
    start = namespace()
    empty = Path(__file__).parents[1] / "build" / "empty"
    empty.mkdir(parents=True, exist_ok=True)
    environment = [f"HIDDEN={' '.join(paths(kinds))}", f"EMPTY={empty}"]
    return start and [*start, "env", *environment, "sh", "-c", MOUNT, "hide", *command]


if __name__ == "__main__":
    split = sys.argv.index("--")
    line = hidden(sys.argv[1:split], sys.argv[split + 1 :])
    if not line:
        sys.exit(125)
    os.execvp(line[0], line)
