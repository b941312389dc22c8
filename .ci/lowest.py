"""Write the constraints that make pip install the lowest release that pyproject.toml allows of each library.

usage: python .ci/lowest.py EXTRA... > constraints.txt, with the Python that will install them.
"""

import re
import sys
from pathlib import Path

from packaging.requirements import Requirement

TEXT = (Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8")


def requirements(key):
    """The requirements of a list in pyproject.toml."""
    listed = re.search(rf"^{key} = \[(.*?)\]\n", TEXT, re.M | re.S)
    if not listed:
        sys.exit(f"pyproject.toml: {key} is no list of requirements")
    return [Requirement(text) for text in re.findall(r'"([^"]+)"', listed[1])]


if __name__ == "__main__":
    lowest = {}
    for key in ["dependencies", *sys.argv[1:]]:
        for one in requirements(key):
            if one.marker is None or one.marker.evaluate():
                bounds = [part.version for part in one.specifier if part.operator == ">="]
                # a library that two extras want in different releases needs the higher of the lowest
                lowest.setdefault(one.name, set()).update(bounds)
    # the releases of xarray that the bounds allow are older than pandas 3
    print("pandas<3")
    for name, bounds in sorted(lowest.items()):
        if bounds:
            print(
                f"{name}=={max(bounds, key=lambda text: [int(part) for part in text.split('.')])}"
            )
