"""The page of a design: its contents, and the room for its texts."""

import functools
import itertools

import numpy as np
import pytest
import vibroimpact as vi

pytest.importorskip("matplotlib")
from matplotlib.text import Text
from shared_design import short_searches
from vibroimpact.plot.design import _lines

QUICK = {
    "evaluations": 8,
    "specimens": 2,
    "nodes": 2,
    "settling": 20,
    "keep": 4,
    "states": 1,
    "samples": 40,
    "searches": 3,
}
LIMITS = {
    "displacement": 40.0, "rms": 30.0, "acceleration": 50.0, "force": 45.0, "speed": 33.3333,
    "multiplier": 0.98, "least_speed": 0.001, "least_gap": 1e-4,
}  # fmt: skip
RIG = vi.Oscillator.from_dimensional(M=2.7, K=42e3, C=7.6, m=0.11, restitution=0.7, F0=6.0)
LONG = "_of_the_absorber_below_the_upper_floor"


@functools.cache
def full():
    """A design of an oscillator with all options."""
    free = {
        "clearance": (20, 40),
        "mu": (0.03, 0.05),
        "xi": (0.01, 0.02),
        "R1": (0.5, 0.7),
        "R2": (0.5, 0.7),
    }
    spread = dict.fromkeys(("mu", "xi"), (0.98, 1.02)) | {"clearance": (-1, 1), "R1": (0.9, 1, 1.2)}
    with short_searches():
        return vi.design(
            RIG, r=(1.0, 1.02), free=free, tolerance=spread, load=(0.9, 1.1), limit=0.55, limits=LIMITS,
            **QUICK,
        )  # fmt: skip


def chain(r, load, **values):
    """A mass with a free mass between walls; its parameters may have any names."""
    osc = vi.Oscillator(xi=0.02, mu=0.05, restitution=0.7)
    return osc.structure(10 + sum(values.values())), vi.Load(r, sine=[load, 0])


def named():
    """A design of a structure with long names."""
    free = {f"height_{i}{LONG}": (1, 2) for i in range(6)}
    with short_searches():
        return vi.design(
            chain, r=(1.0, 1.02), free=free, tolerance={f"width{LONG}": (0.5, 0.6)}, limit=0.9,
            limits={"displacement": 30.0, "rms": 20.0, "speed": 40.0}, **QUICK | {"samples": 10, "searches": 1},
        )  # fmt: skip


@pytest.mark.parametrize("ask", [full, named])
def test_no_text_leaves_the_page_or_covers_another(ask, tmp_path, monkeypatch):
    """The boxes of all drawn texts, compared with the page and each other."""
    found, boxes, draw = ask(), {}, Text.draw

    def spied(text, renderer, *args, **kwargs):
        if text.get_visible() and text.get_text():
            page = text.get_figure(root=True).transFigure.inverted()
            boxes[text] = text.get_window_extent(renderer).transformed(page)
        return draw(text, renderer, *args, **kwargs)

    monkeypatch.setattr(Text, "draw", spied)
    for kind in ("pdf", "png"):
        boxes.clear()
        found.report(tmp_path / f"page.{kind}")
        assert len(boxes) > 30
        for text, box in boxes.items():
            assert np.all((np.array(box.extents) >= 0) & (np.array(box.extents) <= 1)), text
        for one, other in itertools.combinations(boxes, 2):
            # to a tenth of a millimetre
            a, b = boxes[one].padded(-1.7e-4), boxes[other].padded(-1.7e-4)
            assert not a.overlaps(b), (one, other)


def test_the_page_says_what_was_asked(tmp_path):
    """The band, tolerances, limits, and physical dimensions with their units; also of a design from a file."""
    found = full()
    found.save(tmp_path / "design.json")
    units = found.osc.units().to("mm N s")
    length = units.length
    for one in (found, vi.load(tmp_path / "design.json")):
        text = " ".join(_lines(one))
        for part in (
            f"Load frequencies {units.frequency:.6g} to {1.02 * units.frequency:.6g} Hz.",
            f"clearance {-length:.6g} to {length:.6g} mm (deviations)", "mu 0.98 to 1.02 (factors)",
            "R1 0.9 to 1.2 by 3 quantiles (factors)", "load 5.4 to 6.6 N.",
            f"displacement <= {40 * length:.6g} mm",
            f"least_gap >= {1e-4 * length:.6g} mm", "multiplier <= 0.98",
            f"m = {found.values['mu'] * 2.7:.5g} kg, with M = 2.7 kg",
            f"= {found.values['clearance'] * length:.6g} mm (wall to wall, from ",
        ):  # fmt: skip
            assert part in text
