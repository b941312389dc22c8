"""The studies, as the core declares them, and the meaning of a row of each table."""

import inspect

import vibroimpact
from vibroimpact.commands import STUDIES
from vibroimpact.commands.init import MOTIONS
from vibroimpact.noun import RESULTS
from vibroimpact.tables import language

from .shared import ROOT

#: Functions of other modules for the same study.
FUNCTIONS = {"simulate": ("simulate_bundle",)}


def functions(study):
    """The public functions of the module of a study."""
    home = RESULTS[study].__module__
    public = [getattr(vibroimpact, name) for name in vibroimpact.__all__]
    return [
        thing.__name__
        for thing in public
        if inspect.isfunction(thing) and inspect.unwrap(thing).__module__ == home
    ]


def code(words):
    """Words as code, with commas between."""
    return ", ".join(f"`{word}`" for word in words)


def pages():
    """The table of studies, and that of the rows in inputs/README.md."""
    lines = ["| it can | in Python | in a namelist | as a command |", "|---|---|---|---|"]
    lines += [
        f"| {does} | `{kind}` | `&motion kind = '{kind}'` | `run` |"
        for kind, (does, _) in MOTIONS.items()
    ]
    for study, does in STUDIES.items():
        words = code([*functions(study), *FUNCTIONS.get(study, ())])
        lines.append(f"| {does.replace('|', chr(92) + '|')} | {words} | `&{study}` | `{study}` |")
    for about in language()["results"].values():
        if about["of_structure"]:
            group = about["group"]
            lines.append(
                f"| {about['meaning']} | `{group}` | `&{group}` of a `&structure` | `{group}` |"
            )
    readme = (ROOT / "inputs" / "README.md").read_text(encoding="utf-8")
    rows = "| result of " + readme.partition("\n| result of ")[2].partition("\n\n")[0] + "\n"
    return {"studies.md": "\n".join(lines) + "\n", "rows.md": rows}
