"""The kept cases take the work that was kept: a fast path that no longer decides changes the speed, but no answer.

Where a change is meant, `python tests/quality/find_answers.py --renew` counts again, and shows what changed.
"""

import platform
import sys

import pytest
from installed_library import BUILD, ROOT

sys.path[:0] = [str(ROOT / "tests" / folder) for folder in ("python", "quality")]

import work  # noqa: E402
from shared_answers import load, put_files  # noqa: E402

pytestmark = pytest.mark.skipif(
    (sys.platform, platform.machine()) != ("linux", "x86_64"),
    reason="the counters are written in the assembly language of x86-64, for Linux",
)


@pytest.mark.usefixtures("installed")
def test_work(tmp_path, monkeypatch):
    """Each procedure is called as often as was kept, where two compilers and two LAPACK libraries agree."""
    put_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    library, kept, changed = work.Work(BUILD), load(), []
    for item, calls in zip(kept, work.load(len(kept)), strict=True):
        found = library.count(item["text"])[2]
        changed += [
            f"{name}: {found.get(name, 0)} calls, {calls.get(name, 0)} kept, of\n{item['text']}"
            for name in work.differences(calls, found)
        ]
    assert not changed, "\n".join([f"{len(changed)} changes, such as", *changed[:5]])


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize("rows", [3, 6])
def test_calls_are_counted(rows, tmp_path, monkeypatch):
    """In a chart of exact motions [P] is computed once for each motion, and lanes are called once for a row."""
    monkeypatch.chdir(tmp_path)
    library = work.Work(BUILD)
    answer, _, calls = library.count(f"""
&system xi = 0.1, mu = 0.2, restitution = 0.6 /
&chart sides = 'RL', r_min = 0.8, r_max = 1.2, r_points = {rows}, clearance_min = 1, clearance_max = 3,
  clearance_points = 5 /
""")
    assert calls["equispaced_row.new_row"] == calls["lane_half.lane_halves"] == rows
    # a symmetric motion has a map of half a period, too
    motions, halves = calls["points.exact_point"] * 2, calls["stability.multipliers_of_half"]
    assert answer["notes"][0].startswith(f"{motions} motions"), answer["notes"]
    assert calls["stability.stability_matrix"] == motions
    assert calls["lapack.eigenvalues"] == motions + halves
    assert calls["progress.done"] == calls["progress.expected"] > 0


def test_differences_of_calls():
    """More calls, a new one, and one that is missing differ; what depends on the compiler does not."""
    kept = {"a.a": 3, "b.b": None, "c.c": 1}
    assert work.differences(kept, {"a.a": 3, "b.b": 7, "c.c": 1}) == []
    assert work.differences(kept, {"a.a": 4, "c.c": 1, "d.d": 1}) == ["a.a", "d.d"]
    assert work.differences(kept, {"a.a": 3}) == ["c.c"]
    assert work.merged(kept, {"a.a": 4, "c.c": 1, "b.b": 2}) == {"a.a": None, "b.b": None, "c.c": 1}
