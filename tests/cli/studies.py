"""Cases of branches, zones and atlases, and the comparison of their results with those of the API."""

import re

import pytest
from programs import SYSTEM, column, rows

WALLS = "&system xi = 0.0114, mu = 0.028, restitution = 0.75 /\n"
EXACT = "&motion kind = 'exact', sides = 'RL', clearance = 37, phases_over_pi = 0, 1.37 /\n"
ALONG = "&branch parameter = 'clearance', low = 10, high = 60 /\n"
BRANCH = SYSTEM + EXACT + ALONG
ZONE = f"""{WALLS}&zone sides = 'RL', symmetric = 'no'
  r_min = 0.8, r_max = 1.2
  clearance_min = 2, clearance_max = 200
/
"""
ATLAS = f"""{WALLS}&atlas max_impacts = 2, survey = 12
  r_min = 1.0, r_max = 1.1
  clearance_min = 20, clearance_max = 60
/
"""
PARAMETERS = ("r", "clearance", "xi", "mu", "R1", "R2")


def assert_branch(table, branch):
    """Check that the rows of a branch have the digits of the API."""
    assert [int(row["point"]) for row in table] == list(range(1, len(branch) + 1))
    for name in (*PARAMETERS, "A", "tau", "residual", "x_min", "x_max", "attenuation"):
        assert column(table, name).tolist() == getattr(branch, name).tolist(), name
    for i in range(len(branch.pattern)):
        assert column(table, f"phase_{i + 1}").tolist() == branch.alpha[i].tolist()
        assert column(table, f"x_{i + 1}").tolist() == branch.X[i].tolist()
    for i in range(4):
        moduli = column(table, f"multiplier_{i + 1}_modulus")
        # none where an approach speed is zero
        assert moduli == pytest.approx(abs(branch.multipliers[i]), rel=1e-15, nan_ok=True)
    for name in ("admissible", "stable"):
        words = [{1: "true", 0: "false", -1: "unknown"}[int(x)] for x in getattr(branch, name)]
        assert [row[name] for row in table] == words
    special = {point.index: point.type for point in branch.special_points}
    assert [row["special"] for row in table] == [special.get(i, "") for i in range(len(table))]
    for point in branch.special_points:
        if point.type == "grazing":
            wanted = f"flight {point.impact + 1} touches {point.side}"
            assert table[point.index]["detail"] == wanted


def assert_zone(table, zone):
    """Check that the rows of a zone have the digits of the API, piece by piece."""
    assert {row["piece"] for row in table} == {str(i + 1) for i in range(len(zone.boundary))}
    for i, piece in enumerate(zone.boundary, start=1):
        part = [row for row in table if row["piece"] == str(i)]
        assert {(row["type"], row["detail"], row["loop"]) for row in part} == {
            (piece.type, piece.detail, str(piece.loop + 1))
        }
        for name in ("x", "y") if zone.of_structure else ("r", "clearance"):
            assert column(part, name).tolist() == getattr(piece, name).tolist()


def assert_atlas(path, atlas):
    """Check that a table has the zones of the API in the same order, with lost attractors in its header."""
    table = rows(path)
    words = {True: "true", False: "false", None: "false"}  # with rest, there is no symmetric family
    wanted = {
        (zone.pattern.sides, str(zone.pattern.cycles), words[zone.symmetric]): zone
        for zone in atlas.zones if zone.boundary
    }  # fmt: skip
    assert list(
        dict.fromkeys((row["sides"], row["cycles"], row["symmetric"]) for row in table)
    ) == [*wanted]
    for name, zone in wanted.items():
        assert_zone(
            [row for row in table if (row["sides"], row["cycles"], row["symmetric"]) == name], zone
        )
    head = path.read_text().split("\n")
    assert f"# ! {atlas.survey}" in head
    assert any(line.startswith("# ! without impacts") for line in head)
    lost = [line for line in head if "in no zone" in line or "# ! beyond the limits" in line]
    items = atlas.unexplained + atlas.beyond
    assert len(lost) == len(items)
    for line, item in zip(lost, items, strict=True):
        assert ("in no zone" in line) == (item in atlas.unexplained)
        place = re.search(r": (\S+)/(\d+) at r = (\S+), clearance = (\S+)$", line).groups()
        assert (place[0], int(place[1])) == (item.pattern.sides, item.pattern.cycles)
        assert (float(place[2]), float(place[3])) == (item.r, item.clearance)


def assert_result(path, case):
    """The result of a case has the digits of the API."""
    if case.kind == "atlas":
        (atlas,) = case.run()
        if not atlas.of_structure:
            assert_atlas(path, atlas)
            return
        pieces = [piece for zone in atlas.zones for piece in zone.boundary]
        for name in ("x", "y"):
            found = [value for piece in pieces for value in getattr(piece, name).tolist()]
            assert column(rows(path), name).tolist() == found
        return
    table = rows(path)
    if case.kind == "zone":
        assert_zone(table, case.run()[0])
        return
    branches = case.run()
    if branches[0].of_structure:
        (branch,) = branches
        assert column(table, "value").tolist() == branch.values.tolist()
        for i, speeds in enumerate(branch.speeds, start=1):
            assert column(table, f"speed_{i}").tolist() == speeds.tolist()
        special = {point.index: point.type for point in branch.special_points}
        assert [row["special"] for row in table] == [special.get(i, "") for i in range(len(table))]
        return
    assert {row["branch"] for row in table} == {str(i + 1) for i in range(len(branches))}
    for i, branch in enumerate(branches, start=1):
        assert_branch([row for row in table if row["branch"] == str(i)], branch)
