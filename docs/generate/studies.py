"""The studies, as the core declares them, and the meaning of a row of each table."""

import inspect

import vibroimpact
from vibroimpact.commands import STUDIES
from vibroimpact.commands.init import MOTIONS
from vibroimpact.results.noun import result_class
from vibroimpact.results.tables import MODELS, language

from .shared import ROOT

#: Functions of other modules for the same study.
FUNCTIONS = {"simulate": ("simulate_bundle",)}
#: The meaning of a &motion of a structure, and its functions.
OF_STRUCTURE = (
    "compute a periodic motion of a structure from its phases, or simulate until it repeats",
    ("periodic", "exact"),
)
#: Studies without a group.
IN_PYTHON = {
    "compute the probability that motions are stable if parameters are uncertain": ("uncertainty",),
    "compute how far the boundaries of a zone move if parameters are uncertain": (
        "boundary_bands",
    ),
    "estimate the probability that a system stays within limits": ("limit_probability",),
    "compute the exact derivatives of a motion or a simulation": (
        "Motion.gradient",
        "Trajectory.gradient",
    ),
    "compute accelerations, forces, harmonics and energies": (
        "Motion.quantities",
        "Trajectory.quantities",
    ),
}


def functions(study):
    """The public functions of the module of a study."""
    home = result_class(study).__module__
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
    lines = ["| purpose | in Python | in a namelist | as a command |", "|---|---|---|---|"]
    lines += [
        f"| {does} | `{kind}` | `&motion kind = '{kind}'` | `run` |"
        for kind, (does, _) in MOTIONS.items()
    ]
    does, words = OF_STRUCTURE
    lines.append(f"| {does} | {code(words)} | `&motion` of a `&structure` | `run` |")
    for study, does in STUDIES.items():
        words = code([*functions(study), *FUNCTIONS.get(study, ())])
        both = len(language()["results"][study]["rows"]) == len(MODELS)
        group = f"`&{study}`" + " of a `&system` or a `&structure`" * both
        lines.append(f"| {does.replace('|', chr(92) + '|')} | {words} | {group} | `{study}` |")
    lines += [f"| {does} | {code(words)} | – | – |" for does, words in IN_PYTHON.items()]
    readme = (ROOT / "inputs" / "README.md").read_text(encoding="utf-8")
    rows = "| result of " + readme.partition("\n| result of ")[2].partition("\n\n")[0] + "\n"
    return {"studies.md": "\n".join(lines) + "\n", "rows.md": rows}
