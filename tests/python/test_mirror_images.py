"""A structure with all displacements reversed has the mirror images of its motions."""

import re

import pytest
from shared_answers import STOPPED, answer, put_files, same_build
from shared_case_texts import multiplied

#: Keys whose values are negated when all coordinates are reversed.
REVERSED = ("direction", "sine", "cosine", "constant", "record", "q", "q_dot")
#: Columns whose values are not compared: extremes are exchanged; of the coefficients of a path those of the load
#: are negated; residuals and small determinants are rounding; of two longest flights rounding chooses the one
#: in whose middle [P] begins.
LEFT_OUT = ("q_min", "q_max", "series", "residual", "determinant", "P")
#: A text with one of these words is excluded: its numbers come from a file, or its starts from a window that is
#: not reversed or from a seed; rounding decides the course of a long chaotic run.
OTHERS = re.compile(
    r"_file\b|&(find|basins|lyapunov)\b|\b(base|axes|weights|sweep|entries|states)\b"
    r"|'(sine|cosine|constant)_|parameter\w*\s*=\s*'(sine|cosine|constant)"
)


def mirrored(text):
    """The case of the mirror image."""
    return multiplied(text, lambda group, key: -1 if key in REVERSED else 1)


def test_answers_of_mirror_images(kept_cases, tmp_path, monkeypatch):
    """The status, integers such as verdicts, and reals, up to the sign of negated ones, agree."""
    put_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    compared = reversed_branches = 0
    for item in kept_cases:
        text = item["text"]
        if "&structure" not in text or item["answer"]["status"] == 2:
            continue
        if text.startswith(STOPPED) or OTHERS.search(text):
            continue
        one, other = same_build(item), answer(mirrored(text))
        assert other["status"] == one["status"], mirrored(text)
        ends = [answer["columns"].get("points.special") for answer in (one, other)]
        if "branch" in text and ends[0] != ends[1]:
            # it starts at a fold, where rounding decides the direction in which it is followed
            reversed_branches += 1
            continue
        for name, kept in one["columns"].items():
            table, column = name.split(".") if "." in name else ("", name)
            # the least value becomes the greatest one
            column = {"q_min": "q_max", "q_max": "q_min"}.get(column, column)
            found = other["columns"][f"{table}.{column}" if table else name]
            assert found[:2] == kept[:2], (name, text)
            if len(kept) == 4 and column not in LEFT_OUT:
                compared += 1
                sign = -1 if column in REVERSED or name == "record.value" else 1
                assert sign * found[2] == pytest.approx(
                    kept[2], rel=0, abs=1e-9 * kept[3] + 1e-11
                ), (name, text)
    assert compared > len(kept_cases) / 5
    assert reversed_branches <= 1
