"""The answers to cases of structures do not depend on the units of length, mass and time."""

import json
import re

import pytest
from shared_answers import ROUNDING, STOPPED, answer, put_files
from shared_case_texts import multiplied

#: The new units are powers of 2 times the old ones, so that only the exponent bits of a number change; those of
#: length and mass are even powers, so that this holds for square roots too.
LENGTH, MASS, TIME = 10, -8, 3
FORCE = (1, 1, -2)
#: The dimension of each key: its exponents of length, mass and time.
DIMENSIONS = {
    "mass": (0, 1, 0), "damping": (0, 1, -1), "stiffness": (0, 1, -2), "frequency": (0, 0, -1),
    "sine": FORCE, "cosine": FORCE, "constant": FORCE, "record": FORCE, "step": (0, 0, 1),
    "opening": (1, 0, 0), "law_speed": (1, 0, -1), "law_speeds": (1, 0, -1),
    "preload": FORCE, "slip": FORCE, "stick": FORCE, "speed": (1, 0, -1),
    "q": (1, 0, 0), "q_dot": (1, 0, -1), "start": (0, 0, 1), "duration": (0, 0, 1),
}  # fmt: skip
#: The dimension of result columns that share no name with a key.
OF_COLUMNS = {
    "time": (0, 0, 1), "speed": (1, 0, -1), "speeds": (1, 0, -1), "impulse": (1, 1, -1), "impulses": (1, 1, -1),
    "q_min": (1, 0, 0), "q_max": (1, 0, 0), "phase": (0, 0, 0), "phases": (0, 0, 0), "begin": (0, 0, 0),
    "end": (0, 0, 0), "determinant": (0, 0, 0), "multiplier": (0, 0, 0), "law": (0, 0, 0),
}  # fmt: skip
#: Bounds have the dimension of the parameter that varies between them; in a response this is the frequency.
BOUNDS = {
    "low": "parameter", "high": "parameter", "x_low": "x", "x_high": "x", "y_low": "y", "y_high": "y",
}  # fmt: skip
#: A text with one of these words is excluded: its numbers have other dimensions or leave the range of doubles or
#: that of their keys, or rounding decides the course of a long chaotic run.
OTHERS = re.compile(
    r"_file\b|-3\d\d\b|\b1e12\b|\b(frequencies|shapes|base|axes|weights|sweep|entries|lyapunov)\b"
)


def factor(dimension):
    """The factor by which the change of units multiplies a number of this dimension."""
    return 2.0 ** (dimension[0] * LENGTH + dimension[1] * MASS + dimension[2] * TIME)


def in_other_units(text):
    """The same case, with its numbers in the new units."""
    varied = dict(re.findall(r"\b(parameter|x|y)\s*=\s*'([a-z]+)", text))

    def factor_of(group, key):
        if key in BOUNDS:
            of = varied.get(BOUNDS[key], "frequency")
            return factor(DIMENSIONS[of]) if of in ("frequency", "opening") else 1
        return factor(DIMENSIONS.get(key, (0, 0, 0)))

    return multiplied(text, factor_of)


def cases(kept_cases):
    """The kept cases of structures with stiffness, without those that rounding decides."""
    for item in kept_cases:
        text, kept = item["text"], item["answer"]
        if "&structure" not in text or kept["status"] == 2 or text.startswith(STOPPED):
            continue
        # without stiffness nothing defines a unit of time, and the end of an accumulation depends on the unit
        if OTHERS.search(text) or not re.search(r"stiffness\s*=\s*[^a-z]*[1-9]", text):
            continue
        # rounding decides which of two simultaneous coupled impacts comes first, and a touch at zero speed
        touches = any(
            speeds[0] and speeds[3] < 1e-9
            for name, speeds in kept["columns"].items() if name.split(".")[-1] in ("speed", "speeds")
        )  # fmt: skip
        if ROUNDING in json.dumps(kept) or touches or "direction = 1, 0.5" in text:
            continue
        # the bounds of a single matrix entry have the dimension of the matrix
        if not re.search(r"parameter\s*=\s*'(mass|damping|stiffness)_", text):
            yield text, kept


def has_special_points(one):
    """Whether a branch has special points, at which rounding decides the verdict and the next step."""
    return not all(re.match(r"\d+ points?;", note) for note in one["notes"])


def test_answers_in_other_units(kept_cases, tmp_path, monkeypatch):
    """The status, integers such as verdicts, and sums of reals with a dimension agree."""
    put_files(tmp_path)
    monkeypatch.chdir(tmp_path)
    compared = 0
    for text, one in cases(kept_cases):
        if "&branch" in text and has_special_points(one):
            continue
        other = answer(in_other_units(text))
        assert other["status"] == one["status"], in_other_units(text)
        for name, kept in one["columns"].items():
            found, column = other["columns"][name], name.split(".")[-1]
            # the number of values, and of reals that are not finite; or the checksum of integers
            assert found[:2] == kept[:2], (name, text)
            if len(kept) == 4 and column in DIMENSIONS | OF_COLUMNS:
                compared += 1
                scale = factor((DIMENSIONS | OF_COLUMNS)[column])
                assert found[2] / scale == pytest.approx(
                    kept[2], rel=0, abs=1e-6 * kept[3] + 1e-11
                ), (name, text)
    assert compared > len(kept_cases) / 5
