"""A small campaign, its store, and the command that runs one."""

import subprocess
import sys
from pathlib import Path

import vibroimpact as vi

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
SWEEP = """&system
  xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1
/
&motion
  kind = 'equispaced', clearance = 20
/
&sweep
  keys = 'r', 'clearance', low = 0.9, 2, high = 1.1, 200, counts = 8, 12, spacing = 'linear', 'geometric'
/
"""


def equispaced_case():
    """A case with one or two motions."""
    return vi.equispaced(OSC, r=1.0, clearance=20.0)[0].to_namelist()


def small_sweep():
    """Cases, some of which have no motion."""
    return vi.Sweep(
        equispaced_case(), {"r": [0.9, 1.0, 1.1], "clearance": [5.0, 20.0, 80.0, 500.0]}
    )


def files_of(folder):
    """All files of a store with their bytes."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*")) if path.is_file()
    }  # fmt: skip


def command(*words, **options):
    """Run the program in its own process."""
    return subprocess.Popen(
        [Path(sys.executable).parent / "vibroimpact", "campaign", *map(str, words)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **options,
    )  # fmt: skip
