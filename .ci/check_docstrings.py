"""Check the docstrings of public objects by numpydoc, as pyproject.toml configures it."""

import inspect
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import vibroimpact as vi
from numpydoc.validate import get_doc_object, validate

ROOT = Path(__file__).resolve().parents[1]


def public() -> Iterator[tuple[str, Any]]:
    """All public names with their objects, and the methods and properties of classes."""
    for name in vi.__all__:
        thing = getattr(vi, name)
        yield name, thing
        for inner in dir(thing) if inspect.isclass(thing) else ():
            owner = next((kind for kind in thing.__mro__ if inner in vars(kind)), object)
            if inner[0] == "_" or not owner.__module__.startswith("vibroimpact"):
                continue
            item = inspect.getattr_static(thing, inner)
            if isinstance(item, property):
                yield f"{name}.{inner}", item
            elif inspect.isfunction(item) or isinstance(item, (classmethod, staticmethod)):
                yield f"{name}.{inner}", getattr(thing, inner)


def main() -> int:
    """Print what is wrong; 1 if anything is."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        _, *left_out = tomllib.load(file)["tool"]["numpydoc_validation"]["checks"]
    wrong = [
        f"{name}: {code} {text}"
        for name, thing in public()
        for code, text in validate(get_doc_object(thing))["errors"]
        if code not in left_out
    ]
    print(*wrong, sep="\n", end="\n" * bool(wrong))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
