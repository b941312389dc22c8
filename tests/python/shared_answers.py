"""Answers of the core to the namelists of tests/data/answers, in a form that can be kept and compared."""

import json
import re
import shutil
import zlib
from math import prod
from pathlib import Path

import numpy as np
from vibroimpact import _core
from vibroimpact.base.interrupt import new_counters
from vibroimpact.cases.case import study_of
from vibroimpact.results.namelist import has_structure
from vibroimpact.results.tables import STORED, Handle, declared, language, shown, text_of

FOLDER = Path(__file__).parents[1] / "data" / "answers"
INPUTS = Path(__file__).parents[2] / "inputs"
KEPT = FOLDER / "answers.jsonl"
DECLARED = FOLDER / "declared.json"
#: Sums agree within this fraction of the sum of magnitudes; differences smaller than FLOOR are rounding.
SHARE, FLOOR = 1e-8, 1e-12
#: The first line of a case that is stopped before it begins.
STOPPED = "! stopped before it begins\n"
#: Replaces a sum on which two builds, compilers or libraries do not agree: rounding alone.
ROUNDING = "rounding"


def answer(text):
    """The answer to one case: a message, or notes and a fingerprint of each column."""
    counters = new_counters()
    counters[2] = text.startswith(STOPPED)
    handle, status = _core.run_case(np.frombuffer(text.encode(), "S1"), 1, counters)
    owner = Handle(handle)
    return read(owner, status, text_of(_core.describe_result, handle))


def read(owner, status, described):
    """An answer, made from the core's result in JSON."""
    about = json.loads(described)
    if status == 2:
        return {"status": status, "message": about["message"]}
    lines = [line[2:] for line in about["case"]]
    text = "\n".join(lines)
    known = declared(study_of(text), has_structure(text))
    sizes = {item["name"]: [size for _, size in item["dims"]] for item in about["tables"]}
    columns = {
        f"{item['table']}.{item['name']}": fingerprint(
            column(owner, item, known[item["table"], item["name"]], sizes)
        )
        for item in about["columns"]
        if item["address"] is not None
    }
    owners = {
        f"{item['name']} of {item['parent']}": fingerprint(
            shown(owner, item["owners"], (prod(sizes[item["name"]]),))
        )
        for item in about["tables"]
        if item["parent"]
    }
    return {
        "status": status,
        "case": zlib.crc32(text.encode()),
        "notes": [rounded(text) for _, text in about["notes"]],
        "remarks": [rounded(text) for text in about["remarks"]],
        "columns": columns | owners,
    }


def rounded(text):
    """A text in which numbers with more than five digits are rounded to five."""
    return re.sub(r"-?\d\.\d{6,}E[+-]\d+", lambda number: f"{float(number[0]):.4e}", text)


def column(owner, item, about, sizes):
    """The values of a column as a one-dimensional array."""
    length = prod(sizes[item["table"]]) * (item["inner"] if about["each"] else 1)
    values = shown(owner, item["address"], (length,), STORED.get(about["kind"], "<i4"))
    return values.view("<f8") if about["kind"] == "complex" else values


def fingerprint(values):
    """Number of values, and for integers a checksum; for reals also the number of NaNs, and two weighted sums."""
    if values.dtype.kind == "i":
        return [values.size, zlib.crc32(values.tobytes())]
    finite = np.where(np.isfinite(values), values, 0.0)
    # neither an exchange of two values nor a change of one leaves the sum unchanged
    weighted = (1 + np.modf(0.618033988749895 * np.arange(values.size))[0]) * finite
    return [
        values.size, int(values.size - np.isfinite(values).sum()),
        float(f"{weighted.sum():.13g}"), float(f"{np.abs(weighted).sum():.4g}"),
    ]  # fmt: skip


def declarations():
    """A checksum of the declarations of each group and study, without the sentences on their meaning."""
    text = json.dumps(language())
    bare = json.loads(
        text, object_hook=lambda about: {key: about[key] for key in about if key != "meaning"}
    )
    return {
        part: {name: zlib.crc32(json.dumps(about).encode()) for name, about in items.items()}
        for part, items in bare.items()
    }


def differences(kept, found):
    """The names of the items that differ between two answers."""
    for name in dict.fromkeys([*kept, *found]):
        if name == "columns" or kept.get(name) == found.get(name):
            continue
        if kept.get(name) != ROUNDING:
            yield name
    columns, others = kept.get("columns", {}), found.get("columns", {})
    for name in dict.fromkeys([*columns, *others]):
        if not close(columns.get(name, []), others.get(name, [])):
            yield name


def close(kept, found):
    """Whether two fingerprints agree."""
    if len(kept) != 4 or len(found) != 4:
        rounded = [ROUNDING] in (kept[1:], found[1:])
        return kept == found or (rounded and kept[:1] == found[:1])
    if kept[:2] != found[:2]:
        return False
    return (
        ROUNDING in (kept[2], found[2])
        or abs(kept[2] - found[2]) <= SHARE * max(kept[3], found[3]) + FLOOR
    )


def merged(kept, found):
    """An answer without the parts on which two builds differ by rounding; None if they differ in more."""
    both = {name: value if found.get(name) == value else ROUNDING for name, value in kept.items()}
    if both["status"] == ROUNDING or "message" in kept:
        return both if ROUNDING not in both.values() else None
    if both["case"] == ROUNDING or kept["columns"].keys() != found["columns"].keys():
        return None
    both["columns"] = {
        name: common(column, found["columns"][name]) for name, column in kept["columns"].items()
    }
    return both if None not in both["columns"].values() else None


def common(kept, found):
    """The part of a fingerprint on which two builds agree; None if they differ in more than rounding."""
    if close(kept, found):
        return kept
    if kept[0] != found[0] or (len(kept) == 4 and kept[1] != found[1]):
        return None
    return [*kept[:2], ROUNDING, kept[3]] if len(kept) == 4 else [kept[0], ROUNDING]


def put_files(folder):
    """Copy the files that cases refer to."""
    for path in (*FOLDER.iterdir(), *INPUTS.iterdir()):
        if path.suffix in (".mtx", ".csv", ".npy"):
            shutil.copy(path, folder)


def same_build(item):
    """The kept answer of a case; if rounding makes it unusable, the answer of this build."""
    kept = item["answer"]
    return kept if ROUNDING not in json.dumps(kept) else answer(item["text"])


def load():
    """The kept cases: text and answer of each."""
    with KEPT.open(encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def few_of_each(cases):
    """Every thirtieth of the refused cases, and of the others with the same groups, or two of few."""
    kinds = {}
    for case in cases:
        groups = frozenset(re.findall(r"&\w+|\brecord\b", case["text"]))
        kinds.setdefault(groups if case["answer"]["status"] != 2 else None, []).append(case)
    steps = {kind: max(1, min(30, len(same) // 2)) for kind, same in kinds.items()}
    # from the first one on, the longest cases would be among them
    return [case for kind, same in kinds.items() for case in same[steps[kind] - 1 :: steps[kind]]]
