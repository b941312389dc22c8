"""Write the constraints that make pip install the lowest release that pyproject.toml allows of each library.

usage: python .ci/lowest.py EXTRA_OR_GROUP... > constraints.txt, with the Python that will install them.
"""

import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

SETTINGS = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETTINGS["project"]
LISTS = (
    PROJECT["optional-dependencies"]
    | SETTINGS["dependency-groups"]
    | {"package": PROJECT["dependencies"]}
)


if __name__ == "__main__":
    lowest = {}
    for key in ["package", *sys.argv[1:]]:
        for one in map(Requirement, LISTS[key]):
            if one.marker is None or one.marker.evaluate():
                bounds = [part.version for part in one.specifier if part.operator == ">="]
                # a library that two lists want in different releases needs the higher of the lowest
                lowest.setdefault(one.name, set()).update(bounds)
    # the releases of xarray that the bounds allow are older than pandas 3
    print("pandas<3")
    for name, bounds in sorted(lowest.items()):
        if bounds:
            print(
                f"{name}=={max(bounds, key=lambda text: [int(part) for part in text.split('.')])}"
            )
