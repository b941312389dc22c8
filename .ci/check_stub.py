"""Write _core.pyi from what f2py says of each procedure, or compare it: stubtest cannot see f2py's arguments.

usage: check_stub.py [--write]
"""

import re
import sys
import textwrap
from pathlib import Path

from vibroimpact import _core

HEAD = """# The procedures of python/boundary, which describes their arguments; written by .ci/check_stub.py. At
# run time each is an object of f2py's that can be called, not a function: hence a protocol for each.

from typing import Protocol, TypeAlias, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Real: TypeAlias = NDArray[np.float64]
_Complex: TypeAlias = NDArray[np.complex128]
_Integer: TypeAlias = NDArray[np.intc]
_Bytes: TypeAlias = NDArray[np.bytes_]

__f2py_numpy_version__: str
"""
#: Types of arrays by the letter of NumPy.
ARRAYS = {"i": "_Integer", "d": "_Real", "D": "_Complex", "S": "_Bytes"}


def type_of(told, result):
    """The type of an argument or a result, from its line in f2py's text."""
    array = re.search(r"rank-\d array\('(\w)'\)", told)
    if array:
        inout = "in/output" in told
        return ARRAYS[array[1]] if result or inout else "ArrayLike"
    if "string" in told:
        return "bytes"
    number = re.search(
        r"int\b|long|float|complex", told.removeprefix("input ").removeprefix("in/output ")
    )
    return {"long": "int"}.get(number[0], number[0])


def stub_of(name):
    """The protocol of a procedure, and its name."""
    text = getattr(_core, name).__doc__
    told = dict(re.findall(r"^(\w+) : (.*)$", text, re.M))
    first = text.splitlines()[0]
    results, _, call = first.rpartition(" = ") if " = " in first else ("", "", first)
    needed, _, optional = call.partition("(")[2].rstrip(")").partition("[")
    arguments = [item for item in needed.split(",") if item]
    extras = [item for item in optional.rstrip("]").split(",") if item]
    given = [item for item in results.split(",") if item]
    lines = [f"        {item}: {type_of(told[item], False)}," for item in arguments]
    lines += [f"        {item}: {type_of(told[item], False)} = ...," for item in extras]
    types = [type_of(told[item], True) for item in given]
    answer = f"tuple[{', '.join(types)}]" if len(types) > 1 else "".join(types) or "None"
    kind = "_" + "".join(part.title() for part in name.split("_"))
    said = textwrap.wrap(", ".join(given), 105, initial_indent="    # ", subsequent_indent="    # ")
    lines = [
        "@type_check_only",
        f"class {kind}(Protocol):",
        *said,
        "    def __call__(",
        "        self,",
        *lines,
    ]
    return "\n".join([*lines, f"    ) -> {answer}: ...", ""]), f"{name}: {kind}"


def whole_stub():
    """The text of the stub."""
    names = [name for name in vars(_core) if type(getattr(_core, name)).__name__ == "fortran"]
    stubs = [stub_of(name) for name in sorted(names)]
    return "\n".join([HEAD, *(stub for stub, _ in stubs), *(line for _, line in stubs), ""])


def bare(text):
    """A text without what a formatter may change."""
    return "".join(text.split()).replace(",]", "]")


place = Path(__file__).parents[1] / "python" / "vibroimpact" / "_core.pyi"
if "--write" in sys.argv:
    place.write_text(whole_stub(), encoding="utf-8")
elif bare(place.read_text(encoding="utf-8")) != bare(whole_stub()):
    sys.exit(f"{place.name} differs from python/boundary: python .ci/check_stub.py --write")
