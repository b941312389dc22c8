"""Calls of the module _core that no case makes: arguments and answers, in a form that can be kept and compared."""

import json
import re
from pathlib import Path

import numpy as np
from shared_answers import FOLDER, close, fingerprint
from vibroimpact import _core

KEPT = FOLDER / "calls.jsonl"
#: Procedures that run cases, read or write results, or describe the language: other tests keep their answers.
CASES = re.compile(r"handle|describe_|read_namelist|run_|status_text|write_")


def procedures():
    """The names of the procedures that are kept: they take arrays only."""
    return sorted(
        name for name in dir(_core)
        if type(getattr(_core, name)).__name__ == "fortran"
        and not CASES.search(getattr(_core, name).__doc__.split("\n")[0])
    )  # fmt: skip


def pack(argument):
    """An argument in a form for JSON; None if it cannot be kept."""
    if isinstance(argument, bool | int | float | str) or argument is None:
        return {"value": argument}
    if isinstance(argument, np.generic) and argument.dtype.kind in "bif":
        return {"value": argument.item()}
    if isinstance(argument, list | tuple):
        argument = np.array(argument)
    if isinstance(argument, np.ndarray) and argument.dtype.kind in "bifc":
        order = "C" if argument.flags.c_contiguous else "F"
        values = argument.ravel(order)
        return {
            "dtype": str(values.dtype), "order": order, "shape": argument.shape,
            "values": (values.view("<f8") if values.dtype.kind == "c" else values).tolist(),
        }  # fmt: skip
    return None


def unpack(kept):
    """The argument that was packed, in new memory."""
    if "value" in kept:
        return kept["value"]
    values = np.array(kept["values"], "<f8" if kept["dtype"][0] == "c" else kept["dtype"])
    return values.view(kept["dtype"]).reshape(kept["shape"], order=kept["order"])


def answer(procedure, arguments):
    """The fingerprints of the results of a call, and of its argument arrays, which it may change."""
    given = [unpack(argument) for argument in arguments]
    result = getattr(_core, procedure)(*given)
    values = [*(result if isinstance(result, tuple) else (result,))]
    values += [array for array in given if isinstance(array, np.ndarray)]
    return [fingerprint(plain(value)) for value in values if not isinstance(value, bytes)]


def plain(value):
    """Numbers in one dimension; complex numbers as pairs."""
    array = np.atleast_1d(value)
    if array.dtype.kind not in "iufcb":
        return np.frombuffer(array.tobytes(), np.uint8).astype(int)
    array = array.ravel("F")
    return (
        array.view("<f8")
        if array.dtype.kind == "c"
        else array.astype(int)
        if array.dtype.kind in "ub"
        else array
    )


def differences(kept, found):
    """The places of the differences."""
    if len(kept) != len(found):
        return [len(found)]
    return [
        i for i, (one, other) in enumerate(zip(kept, found, strict=True)) if not close(one, other)
    ]


def load(path: Path = KEPT):
    """The kept calls: procedure, arguments and answer of each."""
    with path.open(encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]
