"""Bytes of memory that a study keeps for a state of basins, an event, a point of a campaign.

The bounds are some 1.4 times what was measured; `benchmarks/scaling.py` has the table up to 10^8.
"""

import subprocess
import sys

import numpy as np
import pytest
import vibroimpact as vi

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="memory is read from /proc"
)

#: Prints the growth of the peak memory from a small to a large number, divided by the difference.
MEASURE = """
import resource, tempfile
from pathlib import Path

import numpy as np
import vibroimpact as vi

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
CASE = '''&system
  xi = 0.01
  mu = 0.028
  restitution = 0.75
/
&chart
  sides = 'RL'
  symmetric = 'yes'
  r_min = 0.8
  r_max = 1.2
  r_points = 60
  clearance_min = 2
  clearance_max = 200
  clearance_points = 60
/
'''

def states(count):
    osc = vi.Oscillator(xi=0.02, mu=0.042, restitution=0.75)
    side = round(count**0.5)
    axis = (-30.0, 30.0)
    vi.basins(osc, 0.94, 37.0, (("x", *axis, side), ("x_dot", *axis, side)), threads=1)

def events(count):
    vi.simulate(OSC, 1.02, 11.25, count / 3.2)

def points(count):
    sweep = vi.Sweep(CASE, {"xi": np.linspace(0.005, 0.02, count // 3600)})
    with tempfile.TemporaryDirectory() as folder:
        vi.campaign(sweep, Path(folder) / "store", chunk=4, threads=1)

def most():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
"""


@pytest.mark.parametrize(
    ("work", "small", "large", "most"),
    [
        ("states", 40**2, 160**2, 210),  # 150 measured
        ("events", 50_000, 400_000, 250),  # 177: 88 are kept, and as many while they are passed on
        ("points", 28_800, 144_000, 40),  # on disk; 4 cases are in memory at a time
    ],
)
def test_bytes(work, small, large, most):
    code = f"{MEASURE}\n{work}({small})\nfirst = most()\n{work}({large})\nprint(most() - first)"
    run = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    each = int(run.stdout) / (large - small)
    assert each < most


def test_an_event_is_as_small_as_its_numbers():
    """Six times and velocities, kind and side."""
    run = vi.simulate(vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75), 1.02, 11.25, 100)
    assert run.events.itemsize <= 88
    assert run.events.nbytes == run.events.itemsize * len(run.events)
    assert np.shares_memory(run.events, run.events["time"])
