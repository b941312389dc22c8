"""The attempts on records that no fit describes, the best of them, and possible remedies, for the message."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..base.errors import SingularError
from .fit import Fit
from .known import HINT
from .steps import NotTriedError, Step, cycles_of

#: Samples of the median flight, load cycles of a record, and noise over the motion, beyond which a higher rate, a
#: longer record or less noise would hardly help.
SAMPLES, CYCLES, QUIET = 40, 100.0, 0.03
#: The names of the attempts in messages.
CALLED = {
    "as it is": "the impacts of the record",
    "joined": "one impact in each pulse",
    "other walls": "weak impacts on the other wall",
    "fewer": "without the weakest impact",
    "exactly": "sensors as if they were exact",
    "apart": "flight by flight, without a period",
    "twice": "twice the period",
}


class Attempt(NamedTuple):
    """One attempt: its pattern or period, its misfit (NaN without a fit), and why it was rejected."""

    name: str
    pattern: str
    misfit: float
    why: str

    def __str__(self) -> str:
        what = f" ({self.pattern})" if self.pattern else ""
        return f"{CALLED[self.name]}{what}: {self.why}"


class Attempts:
    """All attempts on some records, in sequence."""

    def __init__(self) -> None:
        self.all: list[Attempt] = []

    def refused(self, name: str, steps: Sequence[Step], error: SingularError) -> None:
        """Note an attempt that led to no fit, with the misfit of its flights alone if these were fitted."""
        if isinstance(error, NotTriedError):
            return
        free = steps[0].free
        misfit = free.misfit if free is not None else math.nan
        self.all.append(Attempt(name, pattern_of(steps), misfit, short(error)))

    def misfitting(self, name: str, steps: Sequence[Step], found: Fit) -> None:
        """Note an attempt whose fit does not describe the records."""
        misfit = max(found.misfits)
        why = f"misfit of {misfit:.3g}"
        if found.undetermined:
            why += f", without {', '.join(found.undetermined)}"
        self.all.append(Attempt(name, pattern_of(steps), misfit, why))

    def said(self, steps: Sequence[Step], shared: Mapping[str, float]) -> str:
        """The attempts, the best of them, and possible remedies, as a text."""
        texts = []
        if self.all:
            texts.append("tried: " + "; ".join(map(str, self.all)))
        best = min(
            (one for one in self.all if math.isfinite(one.misfit)),
            key=lambda one: one.misfit,
            default=None,
        )
        if best is not None:
            what = f"{CALLED[best.name]}{f' ({best.pattern})' if best.pattern else ''}"
            of_flights = "" if best.why.startswith("misfit") else " of its flights alone"
            texts.append(f"the best is {what} with a misfit{of_flights} of {best.misfit:.3g}")
        return "; ".join([*texts, f"what would help most: {', '.join(helping(steps[0], shared))}"])


def short(error: SingularError) -> str:
    """The reason of an error, without the general hint."""
    return str(error).removesuffix(HINT).rstrip("; :")


def pattern_of(steps: Sequence[Step]) -> str:
    """The pattern of the records, or the period if there is no pattern."""
    each = []
    for step in steps:
        data = step.data
        if data is None:
            continue
        cycles = f"{data.k} load cycle{'s' if data.k > 1 else ''}"
        each.append(f"{data.sides}/{data.k}" if data.sides else f"a period of {cycles}")
    return ", ".join(dict.fromkeys(each))


def helping(step: Step, shared: Mapping[str, float]) -> list[str]:
    """Changes that would help most with a record, the most effective first."""
    found: list[str] = []
    record = step.record
    if record is None:
        return ["a record of the motion"]
    if step.times.size > 2:
        samples = float(np.median(np.diff(np.sort(step.times)))) * record.rate
        if samples < SAMPLES:
            found.append(f"a higher sampling rate (the median flight has {samples:.0f} samples)")
    noise = step.noise if math.isfinite(step.noise) else math.nan
    if step.windows is not None and math.isfinite(step.windows.noise):
        noise = step.windows.noise
    share = noise / float(np.std(getattr(record, step.quantity)))
    if share > QUIET:
        found.append(f"less noise (its standard deviation is {100 * share:.2g} % of the motion's)")
    if "mu" not in shared:
        found.append("a known free mass m (with the mass M)")
    cycles = cycles_of(record, step.Omega)
    if cycles < CYCLES:
        found.append(f"a longer record (now {cycles:.0f} load cycles)")
    return [*found, "a record at another load frequency"]
