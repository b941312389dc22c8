"""The pages of the Python reference: one for each subject."""

import functools
import inspect
import re
from fnmatch import fnmatch

import vibroimpact
import vibroimpact.plot

#: Modules by subject; public names of modules not listed here come last.
SUBJECTS = {
    "System, pattern, units": ("systems.oscillator", "systems.units", "physical_results", "systems.excitations"),
    "Motions": ("motions.periodic", "motions.exact", "studies.find", "motions.motion", "results.events",
                "motions.likeness", "motions.flags", "results.gradient", "base.status"),
    "Simulation": ("motions.trajectory", "motions.bundle"),
    "Response quantities": ("motions.quantities",),
    "Proofs": ("proofs.certificate", "proofs.prove", "proofs.complete"),
    "Structures": ("systems.structure", "systems.restitution", "systems.record"),
    "Branches, zones, atlases, charts": ("studies.branch", "studies.zone",
                                         "studies.atlas", "studies.chart"),
    "Attractors": ("studies.basins", "studies.bifurcation", "studies.lyapunov", "studies.response",
                   "base.spacing"),
    "Records of a rig": ("identification.identify", "identification.measured", "identification.virtual_rig",
                         "identification.sensor_files"),
    "Uncertain parameters": ("studies.uncertainty", "studies.boundary_band"),
    "Campaigns": ("campaigns.run", "campaigns.sweep", "campaigns.campaign"),
    "Other studies": ("studies.*", "designs.*"),
    "Namelists": ("cases.run", "cases.case"),
    "Results in files": ("formats.load",),
}  # fmt: skip
#: What computes an attribute of a class.
ATTRIBUTES = (property, functools.cached_property)
#: Functions of modules that need an extra, which are documented without it.
OF_EXTRAS = {
    "Functions for JAX (extra `jax`)": ("jax.motion", "jax.response", "jax.final_state"),
    "The interactive page (extra `explorer`)": ("explorer.server.explore",),
}
EXTRA = {
    "Parts of results": (
        "motions.trajectory.Period",
        "motions.quantities.Signal",
        "studies.find.Search",
        "studies.zone.ZoneSearch",
        "studies.branch.Branches",
        "studies.bifurcation.PeriodicWindow",
        "cases.run.RunLog",
    ),
    "What all results can do": ("results.noun.Savable",),
    "Pictures": ("plot.draw", "plot.draw_chart", "plot.draw_system"),
}


def directive(name, thing):
    """The directive that documents a name."""
    kind = "class" if isinstance(thing, type) else "function"
    if isinstance(thing, type) and issubclass(thing, BaseException):
        kind = "exception"
    # the fields of a named tuple have no docstrings
    members = kind == "class" and not issubclass(thing, tuple)
    options = ["   :members:"] * members
    if members and (listed := attributes_alone(thing)):
        options.append(f"   :exclude-members: {', '.join(listed)}")
    return [f".. auto{kind}:: vibroimpact.{name}", *options, ""]


def attributes_alone(thing):
    """Properties of a class that say no more than its list of attributes, which is on the page already."""
    _, _, text = inspect.cleandoc(thing.__doc__ or "").partition("Attributes\n----------\n")
    text = re.split(r"^.*\n---+$", text, maxsplit=1, flags=re.MULTILINE)[0]
    heads = re.findall(r"^\w[\w, ]*", text, re.MULTILINE)
    names = [name for head in heads for name in head.replace(" ", "").split(",")]
    return [
        name
        for name in names
        if isinstance(item := inspect.getattr_static(thing, name, None), ATTRIBUTES)
        and "\n" not in (item.__doc__ or "").strip()
    ]


def pages():
    """All public names, functions before classes."""
    left = {name: getattr(vibroimpact, name) for name in vibroimpact.__all__ if name != "errors"}
    sections = {}
    for subject, modules in SUBJECTS.items():
        homes = [f"vibroimpact.{module}" for module in modules]
        places = {name: place(home(thing), homes) for name, thing in left.items()}
        names = [name for name in left if places[name] < len(homes)]
        sections[subject] = sorted(names, key=lambda name: (places[name], name[0].isupper()))
        left = {name: thing for name, thing in left.items() if name not in names}
    sections["Errors"] = list(vibroimpact.errors.__all__)
    left = {name: thing for name, thing in left.items() if name not in vibroimpact.errors.__all__}
    assert not left, f"{', '.join(left)}: must be in a subject"
    sections |= EXTRA
    found = {}
    for subject, names in sections.items():
        lines = []
        for name in names:
            thing = vibroimpact
            for part in name.split("."):
                thing = getattr(thing, part)
            lines += directive(name, thing)
        found[subject] = lines
    for subject, names in OF_EXTRAS.items():
        found[subject] = [
            line for name in names for line in (f".. autofunction:: vibroimpact.{name}", "")
        ]
    files = {subject: f"python-{slug(subject)}" for subject in found}
    listed = [f"../generated/{file}" for file in files.values()]
    contents = ["```{toctree}", ":maxdepth: 2", "", *listed, "```", ""]
    return {"python.md": "\n".join(contents)} | {
        f"{files[subject]}.md": "\n".join([f"# {subject}", "", "```{eval-rst}", *lines, "```", ""])
        for subject, lines in found.items()
    }


def slug(subject):
    """A subject as part of a name of a file: "Results in files" is results-in-files."""
    return re.sub(r"\W+", "-", subject.split(" (")[0].lower()).strip("-")


def place(module, homes):
    """Index of the first name or pattern that matches a module; their number if none does."""
    return next((i for i, name in enumerate(homes) if fnmatch(module, name)), len(homes))


def home(thing):
    """The module that defines a thing."""
    return getattr(thing, "__wrapped__", thing).__module__
