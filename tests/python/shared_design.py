"""Small cases of a design that its tests share."""

from contextlib import contextmanager

import pytest
import vibroimpact as vi
from vibroimpact.designs import confirmation, design, search

OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
FEW = {"samples": 0, "evaluations": 16, "specimens": 4, "nodes": 3}
QUICK = FEW | {"settling": 120, "keep": 16}
GOOD = {"r": (1.0, 1.02), "free": {"clearance": (20, 45)}}


@contextmanager
def short_searches():
    """Designs by few steps and few runs, for tests of what is made of a design, not of how good it is."""
    with pytest.MonkeyPatch.context() as patch:
        for name, number in (
            ("STEPS", 1), ("TURNS", 0), ("LEAST", 24), ("VERIFIED", 400), ("SETTLING", 800),
        ):  # fmt: skip
            patch.setattr(search, name, number)
        patch.setattr(confirmation, "FEW", 500)
        yield


def asked(osc, **options):
    """The problem and the order of a design, without its searches."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design, "designed", lambda problem, order, *_: (problem, order))
        return vi.design(osc, **options)
