"""Answers to thousands of small cases, which together reach most of the core, equal the kept answers.

They tell that an answer has changed, not which one is right: for that there are the laws of other tests. Where a
change is meant, `python tests/quality/find_answers.py --renew` writes the answers again, and shows what changed.
"""

import json
import os

from shared_answers import DECLARED, answer, declarations, differences, load, put_files


def test_answers(kept_cases, tmp_path, monkeypatch):
    """Two compilers and two LAPACK libraries agree with the kept answers, except for rounding."""
    put_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    changed = []
    for kept in kept_cases:
        found = json.loads(json.dumps(answer(kept["text"])))
        changed += [f"{name} of\n{kept['text']}" for name in differences(kept["answer"], found)]
        # a test of the tests asks only whether there is any
        if changed and "STOP_AT_FAILURE" in os.environ:
            break
    assert not changed, "\n".join(["what changed:", *changed[:5]])


def test_declarations():
    """The keys with their limits and defaults, and the columns with their units, equal the kept ones."""
    kept = json.loads(DECLARED.read_text(encoding="utf-8"))
    for part, found in declarations().items():
        names = kept[part].keys() | found.keys()
        assert [name for name in sorted(names) if kept[part].get(name) != found.get(name)] == []


def test_differences_are_seen():
    """A change of one value, a missing column and a different note are reported as differences."""
    kept = load()
    place = next(i for i, item in enumerate(kept) if item["answer"].get("columns"))
    one = kept[place]["answer"]
    assert not [*differences(one, one)]
    assert [*differences(one, one | {"notes": ["other"]})] == ["notes"]
    columns = dict(one["columns"])
    name = next(iter(columns))
    columns[name] = [columns[name][0] + 1, *columns[name][1:]]
    assert [*differences(one, one | {"columns": columns})] == [name]
    del columns[name]
    assert [*differences(one, one | {"columns": columns})] == [name]
