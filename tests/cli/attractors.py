"""Cases of studies of attractors, and the checks of each of their results."""

import re

from programs import contents, rows
from vibroimpact.cases.case import read_namelist

TABLE = "&system xi = 0.005, mu = 0.042, restitution = 0.75, r = 0.94 /\n"
EQUAL = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, r = 1.04 /\n"
WALLS = "&system xi = 0.0114, mu = 0.028, restitution = 0.75, 0.61, r = 0.9 /\n"
FREE = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
MOVING = "x_dot = 6, z_dot = 9"
LYAPUNOV = f"""{EQUAL}&lyapunov parameter = 'clearance'
  low = 5, high = 40, values = 6
  cycles = 400, discard = 300, {MOVING}
/
"""

DIAGRAM = f"""{EQUAL}&bifurcation parameter = 'clearance'
  low = 20, high = 26, values = 4
  sweep = 'both', settling = 60
/
"""
RESPONSE = f"""{FREE}&response inverse_clearance = 0.03, states = 3
  r_min = 1.0, r_max = 1.04, r_points = 5
/
"""
PLANE = f"""{TABLE}&basins clearance = 37
  axes = 'x', 'x_dot'
  low = -30, -30, high = 30, 30, values = 8, 9
  probes = 50
/
"""


def assert_both(text, batch, command, status=0):
    """The rows of a case; both programs must write them, and write the same from the result."""
    done = batch.case(text)
    assert done.status == status, done
    assert command("case.nml", "-o", "command") == done
    found = contents(batch.cwd / "results")
    assert contents(batch.cwd / "command") == found
    again = batch("results/case.csv", "-o", "again")
    assert (again.status, contents(batch.cwd / "again")) == (status, found)
    assert read_namelist(batch.cwd / "case.nml") == read_namelist(batch.cwd / "results/case.csv")
    return rows(batch.cwd / "results/case.csv")


def case_of(batch):
    """The case of the file that was run."""
    (case,) = read_namelist(batch.cwd / "case.nml")
    return case


def told(path):
    """The header's entries of each attractor: name, kind, share, greatest multiplier or exponent."""
    pattern = (
        r"# ! (\d+): (.+) \((.+)\), share (\S+?)(?:, (?:greatest|largest)[^,;]* (\S+?))?[,;].*"
    )
    found = [re.fullmatch(pattern, line) for line in path.read_text().split("\n")]
    return [item.groups() for item in found if item]
