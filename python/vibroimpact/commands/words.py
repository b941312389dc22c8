"""What is said of the result of a case, as the compiled program says it."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import Any

from ..interchange.csv_file import counted
from ..run import RunLog
from . import Record

#: What was said, what is missing, and whether there is a result.
Words = tuple[list[str], list[str], bool]


def noun_words(noun: Any) -> Words:
    """What the study said."""
    result = noun._result
    news, faults = ([text for fault, text in result.notes if fault == bad] for bad in (False, True))
    return news, faults, not result.empty


def simulate_words(run: Any) -> Words:
    """Impacts and rests."""
    impacts, rests = (int((run.events["kind"] == kind).sum()) for kind in ("impact", "stick"))
    cut = [] if run.complete else ["cut short, max_events was reached"]
    return [f"{counted(impacts, 'impact')}, {counted(rests, 'rest')}"], cut, True


#: The kinds that are computed once, in Python, for table, picture and document.
WORDS: dict[str, Callable[..., Words]] = {
    "simulate": simulate_words, "branch": noun_words, "zone": noun_words, "atlas": noun_words,
    "chart": noun_words, "find": noun_words, "lyapunov": noun_words, "bifurcation": noun_words,
    "basins": noun_words, "response": noun_words, "decay": noun_words,
}  # fmt: skip
#: Those of which Ctrl-C leaves a part of a case.
PARTIAL = ("find", "branch", "chart", "lyapunov", "bifurcation", "basins", "response", "decay")


def tell(log: RunLog, record: Record | None = None) -> None:
    """Print what was said while namelist files ran, faults to standard error."""
    for fault, line in log.lines:
        if fault and record is not None:
            record.faults.append(line)
        stream = sys.stderr if fault else sys.stdout
        # a path need not be text: its bytes are printed as they are
        buffer = getattr(stream, "buffer", None)
        if buffer is None:
            print(line, file=stream)
        else:
            stream.flush()
            buffer.write(os.fsencode(line + "\n"))
            buffer.flush()
