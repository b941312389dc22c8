"""The keys of the namelist groups, as the program itself tells them: it is asked with wrong input."""

import re
import subprocess
import tempfile
from pathlib import Path

from .shared import PROGRAM, ROOT

SYSTEM = "&system\n xi = 0.01, mu = 0.03, restitution = 0.7, r = 0.9\n/\n"
MOTION = "&motion\n kind = 'equispaced', clearance = 20\n/\n"
#: What a group needs so that the key asked about is the first fault.
REST = {
    "motion": "sides = 'RL', phases = 0, 3",
    "zone": "sides = 'RL', r_min = 0.8, r_max = 1.2, clearance_min = 2, clearance_max = 20",
    "chart": "sides = 'RL', r_min = 0.8, r_max = 1.2, clearance_min = 2, clearance_max = 20, "
    "r_points = 3, clearance_points = 3",
    "branch": "parameter = 'clearance', low = 10, high = 30",
}


def complaint(group, key):
    """What the program says about `key = '?'` in a group; empty if another fault comes first."""
    system = (
        SYSTEM.replace(", r = 0.9", "")
        if group in ("chart", "zone", "atlas", "response")
        else SYSTEM
    )
    before = "" if group == "system" else system + (MOTION if group in ("branch", "output") else "")
    others = [
        item for item in re.split(r", (?=[a-z_]+ =)", REST.get(group, "")) if f"{key} =" not in item
    ]
    text = f"{before}&{group}\n {', '.join([*filter(None, others), key + ' = ' + repr('?')])}\n/\n"
    text += MOTION if group == "system" else ""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "case.nml"
        path.write_text(text, encoding="utf-8")
        done = subprocess.run(
            [PROGRAM, path, "-o", folder], capture_output=True, text=True, check=False
        )
    wanted = re.search(rf"&{group} {key} = '\?': .*?must be (.*)", done.stderr)
    return wanted[1] if wanted else ""


def explained():
    """(group, key) -> (what it is, what is taken if it is missing), from the table of inputs/README.md."""
    table, group = {}, ""
    for line in (ROOT / "inputs" / "README.md").read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if len(cells) != 4 or not line.startswith("| "):
            continue
        group = cells[0].strip("`&| ") or group
        keys = re.findall(r"`(\w+)`", cells[1])
        values = cells[3].rstrip(" |").split(", ")
        each = values if len(values) == len(keys) else [", ".join(values)] * len(keys)
        note = re.search(r"\([^)]*\)$", cells[1])
        for key, value in zip(keys, each, strict=True):
            takes = f"{note[0]} {cells[2]}" if note else cells[2]
            same = re.match(r"as of `&(\w+)`", cells[2])
            if other := same and table.get((same[1], key)):
                # what holds for the kinds of a &motion alone stays there
                plain = re.sub(r"^\([^)]*\) |; odd for .*", "", other[0])
                takes = takes.replace(same[0], plain)
                value = other[1] if value == "as there" else value
            table[group, key] = (takes, value)
    return table


def pages():
    """One table a group, with the program's words where the table leaves out a number that they hold.

    Neighbours of which the same is told share a row.
    """
    known = explained()
    lines = []
    said = subprocess.run([PROGRAM, "--help"], capture_output=True, text=True, check=True).stdout
    for group in re.findall(r"&(\w+)", said.split("Groups:")[1]):
        keys = complaint(group, "nokey").removeprefix("one of ").split(", ")
        lines += [f"## `&{group}`", "", "| key | takes | if it is missing |", "|---|---|---|"]
        rows = []
        for key in keys:
            if (group, key) not in known:
                raise RuntimeError(f"&{group} {key} is not in the table of inputs/README.md")
            takes, default = known[group, key]
            words = complaint(group, key)
            number = re.compile(r"\b\d[\de-]*")
            if takes.startswith("as ") and words:
                takes = words
            elif set(number.findall(words)) - set(number.findall(takes)):
                takes += "; " + words.replace("<=", "≤")
            if rows and rows[-1][1:] == (takes, default):
                rows[-1] = (f"{rows[-1][0]}, `{key}`", takes, default)
            else:
                rows.append((f"`{key}`", takes, default))
        lines += [*(f"| {' | '.join(row)} |" for row in rows), ""]
    return {"namelist.md": "\n".join(lines)}
