"""Answers of procedures that no case calls, to arguments from other tests, equal the kept answers.

They tell that an answer has changed, not which one is right: for that there are the laws of other tests. Where a
change is meant, `python tests/quality/find_calls.py --renew` writes the answers again, and shows what changed.
"""

import json

import pytest
from shared_kept_calls import answer, differences, load, procedures


@pytest.mark.parametrize("procedure", procedures())
def test_kept_calls(procedure):
    """The calls on which builds agree still give the kept answers, except for rounding."""
    kept = [call for call in load() if call["procedure"] == procedure]
    assert kept, "no call is kept"
    for call in kept:
        found = json.loads(json.dumps(answer(procedure, call["arguments"])))
        assert not differences(call["answer"], found), call["arguments"]
