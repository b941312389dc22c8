"""Examples of all results, and whether two results are the same."""

import tempfile
from pathlib import Path

import numpy as np
import vibroimpact as vi
from vibroimpact.commands import STUDIES
from vibroimpact.commands.init import template

NAMES = (
    "motion",
    "rest",
    "free",
    "pair",
    "linear",
    "trajectory",
    "rests",
    "still",
    "branch",
    "zone",
    "atlas",
)
#: Studies without a result among these or in separate tests of their files, and further results of studies.
STUDIES_NAMED = (
    "one",
    "states",
    *(name for name in STUDIES if name not in (*NAMES, "simulate", "find", "chart")),
)


def example(study):
    """The result of the case that `vibroimpact init` writes for a study."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.nml"
        path.write_text(template(study, path.name))
        return vi.read_namelist(path)[0].compute()


def same(one, other):
    """Whether two results are equal in type and in every bit, including NaN, -0.0 and structure."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
        )
    if isinstance(one, float):
        return np.float64(one).tobytes() == np.float64(other).tobytes()
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if hasattr(one, "_result"):
        return same(one.to_dict(), other.to_dict())
    if hasattr(one, "__dataclass_fields__"):
        return all(
            same(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__
        )
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


def write(path, text):
    """A file, and its path."""
    path.write_text(text, encoding="utf-8")
    return path
