"""Check the docstrings of public objects by numpydoc, as pyproject.toml configures it."""

import inspect
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import vibroimpact as vi
from numpydoc.validate import Validator, get_doc_object, validate

ROOT = Path(__file__).resolve().parents[1]


def public() -> Iterator[tuple[str, Any]]:
    """All public names with their objects, and the methods and properties of classes.

    What several classes inherit from one base is listed once.
    """
    seen = set()
    for name in vi.__all__:
        thing = getattr(vi, name)
        yield name, thing
        for inner in dir(thing) if inspect.isclass(thing) else ():
            owner = next((kind for kind in thing.__mro__ if inner in vars(kind)), object)
            if inner[0] == "_" or not owner.__module__.startswith("vibroimpact"):
                continue
            item = inspect.getattr_static(thing, inner)
            if id(item) in seen:
                continue
            seen.add(id(item))
            if isinstance(item, property):
                yield f"{name}.{inner}", item
            elif inspect.isfunction(item) or isinstance(item, (classmethod, staticmethod)):
                yield f"{name}.{inner}", getattr(thing, inner)


def findings(thing: Any) -> Iterator[tuple[str, str]]:
    """The codes and texts of numpydoc, without those that the form of the package rules out."""
    doc = get_doc_object(thing)
    of_structure = getattr(thing, "of_structure", None)
    for code, text in validate(doc)["errors"]:
        # results are made by functions and not by users: their classes list attributes instead of parameters
        if code == "PR01" and inspect.isclass(thing) and doc["Attributes"]:
            continue
        # the docstring of a verb explains the arguments of its form for structures, too
        if code == "PR02" and callable(of_structure):
            known = {
                *inspect.signature(thing).parameters,
                *inspect.signature(of_structure).parameters,
            }
            if {*Validator(doc).doc_all_parameters} <= known:
                continue
        yield code, text
    if callable(of_structure):
        lacking = {*inspect.signature(of_structure).parameters} - {
            *Validator(doc).doc_all_parameters
        }
        if lacking:
            yield "PR01", f"Parameters {lacking} of the form for structures not documented"


def main() -> int:
    """Print what is wrong; 1 if anything is."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        _, *left_out = tomllib.load(file)["tool"]["numpydoc_validation"]["checks"]
    wrong = [
        f"{name}: {code} {text}"
        for name, thing in public()
        for code, text in findings(thing)
        if code not in left_out
    ]
    print(*wrong, sep="\n", end="\n" * bool(wrong))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
