"""Wrong keys of branches, zones and atlases, and incompatible groups: one clear error each."""

import pytest
from programs import PAIR, SYSTEM, assert_refused, contents

from studies import ALONG, ATLAS, BRANCH, WALLS, ZONE

BAD_BRANCH = [
    *[("parameter = 'clearance'", f"parameter = {v}", "'r', 'clearance', 'xi'")
      for v in ("'q'", "''", "r", "'restitutio'", "'clearance x'")],
    ("parameter = 'clearance', ", "", "&branch parameter: is missing"),
    *[("low = 10", f"low = {v}", "1e-12 <= clearance <= 1e12, and the motion has clearance = 37")
      for v in ("0", "-1", "1e-13", "38")],
    *[("low = 10", f"low = {v}", "a number, at most") for v in ("nan", "inf", "1, 2")],
    ("low = 10, ", "", "&branch low: is missing"),
    *[("high = 60", f"high = {v}", "above low") for v in ("nan", "36.9", "5", "inf", "1e13", "x")],
    (", high = 60", "", "&branch high: is missing"),
    ("low = 10, high = 60", "low = 37, high = 37", "above low"),
    *[("high = 60", f"high = 60, longest_step = {v}", "longest_step <= 1")
      for v in ("0", "-1", "nan", "2", "1e-7")],
    *[("high = 60", f"high = 60, max_points = {v}", "max_points <= 100000")
      for v in ("9", "100001", "1.5", "nan")],
    ("high = 60", "high = 60, steps = 3", "is not a key of &branch; must be one of parameter, low"),
    ("high = 60", "high = 60, mu = 0.03", "max_points; mu belongs in &system"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted"), BAD_BRANCH)
def test_bad_branch(old, new, wanted, batch):
    """A wrong key of &branch is named with its line, the third."""
    assert old in BRANCH
    assert_refused(BRANCH.replace(old, new), "branch", wanted, 3, batch)


BAD_ZONE = [
    *[("sides = 'RL'", f"sides = {v}", "2 to 24", 2)
      for v in ("'R'", "'RR'", "''", "'RXL'", "'*RL'", "'RL**'", "'R*'", f"'{'RL' * 13}'", "RL")],
    *[("'no'", v, "'yes'", 2) for v in ("'maybe'", "''", ".true.", "1")],
    *[("symmetric = 'no'", f"cycles = {v}", "cycles <= 10000", 2) for v in ("0", "10001", "1.5")],
    ("sides = 'RL', symmetric = 'no'", "sides = 'RRL', symmetric = 'yes'", "mirrors the first", 2),
    *[("r_min = 0.8", f"r_min = {v}", "r_min <= 1e6", 3) for v in ("nan", "0", "-1", "inf", "1e7")],
    *[("r_max = 1.2", f"r_max = {v}", "r_min below r_max", 3) for v in ("0.8", "0.5", "nan", "inf")],
    *[("clearance_min = 2", f"clearance_min = {v}", "clearance_min <= 1e12", 4)
      for v in ("nan", "0", "-1", "1e13")],
    *[("clearance_max = 200", f"clearance_max = {v}", "clearance_min below clearance_max", 4)
      for v in ("2", "1", "nan", "inf")],
    *[("symmetric = 'no'", f"lines = {v}", "5 <= lines <= 129", 2) for v in ("4", "130", "nan")],
    *[("symmetric = 'no'", f"guesses = {v}", "guesses <= 100000", 2) for v in ("-1", "100001")],
    *[("symmetric = 'no'", f"max_points = {v}", "max_points <= 200000", 2) for v in ("99", "200001")],
    ("symmetric = 'no'", "parameter = 'r'", "is not a key of &zone; must be one of sides", 2),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_ZONE)
def test_bad_zone(old, new, wanted, line, batch):
    assert old in ZONE
    assert_refused(ZONE.replace(old, new), "zone", wanted, line, batch)


@pytest.mark.parametrize(("key", "belongs"), [("r", False), ("mu", True)])
def test_keys_of_the_system(key, belongs, batch):
    """A key of &system is sent there, but not r, of which &zone has the limits."""
    done = batch.case(ZONE.replace("symmetric = 'no'", f"{key} = 1"))
    assert done.faults[0].endswith(f"; {key} belongs in &system") is belongs


BAD_ATLAS = [
    *[("max_impacts = 2", f"max_impacts = {v}", "2 <= max_impacts <= 8", 2)
      for v in ("1", "9", "2.5", "x")],
    *[("max_impacts = 2", f"max_cycles = {v}", "1 <= max_cycles <= 4", 2) for v in ("0", "5", "nan")],
    *[("survey = 12", f"survey = {v}", "0 <= survey <= 1000000", 2) for v in ("-1", "1000001", "1e3")],
    *[("survey = 12", f"settling = {v}", "1 <= settling <= 1000000", 2) for v in ("0", "1000001")],
    *[("r_min = 1.0", f"r_min = {v}", "r_min <= 1e6", 3) for v in ("nan", "0", "inf")],
    *[("r_max = 1.1", f"r_max = {v}", "r_min below r_max", 3) for v in ("1", "0.5", "nan")],
    *[("clearance_min = 20", f"clearance_min = {v}", "clearance_min <= 1e12", 4) for v in ("nan", "0")],
    *[("clearance_max = 60", f"clearance_max = {v}", "clearance_min below clearance_max", 4)
      for v in ("20", "inf")],
    *[("survey = 12", f"lines = {v}", "5 <= lines <= 129", 2) for v in ("4", "130")],
    *[("survey = 12", f"guesses = {v}", "guesses <= 100000", 2) for v in ("-1", "100001")],
    *[("survey = 12", f"max_points = {v}", "max_points <= 200000", 2) for v in ("99", "200001")],
    ("survey = 12", "survey = 12, survey = 3", "was given before", 2),
    ("survey = 12", "sides = 'RL'", "is not a key of &atlas; must be one of max_impacts", 2),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "wanted", "line"), BAD_ATLAS)
def test_bad_atlas(old, new, wanted, line, batch):
    assert old in ATLAS
    assert_refused(ATLAS.replace(old, new), "atlas", wanted, line, batch)


@pytest.mark.parametrize(("text", "message"), [
    (WALLS + "&branch parameter = 'r' /\n", "&system r: is missing"),
    (SYSTEM + ALONG, "&branch: no &motion of this &system precedes it"),
    (PAIR + "&output name = 'm' /\n" + SYSTEM + ALONG, "&branch: no &motion of this &system"),
    (ALONG, "&branch: no &system or &structure precedes it"),
    (ZONE.replace(WALLS, ""), "&zone: no &system or &structure precedes it"),
    (SYSTEM + ZONE.replace(WALLS, ""),
     "&system r = 0.94: must be left out: it does not apply to a &chart, &zone, &atlas or &response"),
    (ATLAS.replace(WALLS, ""), "&atlas: no &system or &structure precedes it"),
    (SYSTEM + ATLAS.replace(WALLS, ""), "&system r = 0.94: must be left out: it does not apply to a &chart"),
    (ATLAS.replace("xi = 0.0114", "xi = 0"), "&atlas r_min = 1.0: must be a number with 1e-6"),
    (ZONE.replace("xi = 0.0114", "xi = 0"), "&zone r_min = 0.8: must be a number with 1e-6"),
    (BRANCH.replace("clearance = 37", "clearance = 37, impact_restitution = 2*0.5"),
     "&branch: the &motion before it has impact_restitution; must not have it"),
    (BRANCH.replace("kind = 'exact'", "kind = 'periodic'").replace("clearance = 37", "precision = 'single'"),
     "&branch: the &motion before it has precision = 'single'"),
    (BRANCH.replace("clearance = 37", "clearance = 37, acceptance = 0.1"),
     "&motion acceptance = 0.1: must be left"),
    (BRANCH.replace("clearance = 37", "clearance = 37, precision = 'single'"), "&motion precision = 'single'"),
    (BRANCH.replace("clearance = 37,", ""), "&motion clearance: is missing; must be a number"),
    (BRANCH.replace("0.75", "0.75, 0.6").replace("'clearance'", "'restitution'"),
     "&branch parameter = 'restitution': must be 'r'"),
    (BRANCH.replace("xi = 0.005", "xi = 0").replace("'clearance', low = 10, high = 60", "'r', low = .9, high = 2"),
     "&branch low = .9: must be a number"),
])  # fmt: skip
def test_bad_company(text, message, batch):
    """Incompatible groups give one message, status 2 and no result."""
    done = batch.case(text)
    assert (done.status, done.out, len(done.faults)) == (2, b"", 1)
    assert message in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]


def test_bounds_without_the_motion_of_given_phases(batch):
    """The clearance follows from the phases (38.22), and is compared with the bounds before anything runs."""
    text = BRANCH.replace("kind = 'exact'", "kind = 'periodic'").replace("clearance = 37,", "")
    done = batch.case(PAIR + text.replace("low = 10", "low = 39"))
    assert (done.status, done.out) == (2, b"")
    assert "&branch low = 39: must be a number, at most" in done.faults[0]
    assert "the motion has clearance = 38.22" in done.faults[0]
    assert list(contents(batch.cwd)) == ["case.nml"]
