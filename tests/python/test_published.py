"""Published bifurcations of the one-wall impact oscillator, all rows, and the page of published numbers."""

import importlib
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi
from shared_published import CYCLES, DRAG, RESTITUTION, balance, phase_of_speed, published, zero

ROOT = Path(__file__).parents[2]


def check(rows):
    """At each published point: the exact motion, with the published approach speed and multiplier.

    The authors accept a point as soon as the multiplier is within 1e-5 of 1 or -1. Near a fold a motion moves with
    the square root of the load, so there the linear problem is solved at the phase with the published speed.
    """
    wall = vi.Structure([1], [DRAG], [1], [vi.Gap([1], 1, RESTITUTION)])
    for kind, omega, load, speed, multiplier in rows:
        phase = phase_of_speed(omega, load, speed)
        assert balance(phase, omega)[0] == pytest.approx(load, abs=1e-9)
        if kind == "flip":
            motion = vi.exact(wall, vi.Load(omega, cosine=[load]), ([phase], [0], CYCLES))
            assert motion.consistent
            assert motion.speeds[0] == pytest.approx(speed, abs=2e-10)
            # one row ends the list past the grazing of its impact
            assert motion.admissible is (speed > 0)
            if speed < 0:
                continue
        else:
            motion = vi.periodic(
                wall, vi.Load(omega, cosine=[balance(phase, omega)[0]]), [phase], [0], CYCLES
            )
            assert motion.residual < 1e-12
            # the fold, where the load is extreme, is within 1e-7 in F
            top = zero(lambda t, w=omega: balance(t + 1e-30j, w)[0].imag / 1e-30, phase)
            assert balance(top, omega)[0] == pytest.approx(load, abs=1e-7)
        side = -1 if kind == "flip" else 1
        assert abs(multiplier - side) < 1e-5
        assert np.abs(motion.multipliers - multiplier).min() < 1e-7


def test_published_bifurcations_in_part():
    check(published()[::40])


@pytest.mark.slow
def test_all_published_bifurcations():
    rows = published()
    assert len(rows) == 2616
    check(rows)


def validation(monkeypatch):
    """The module that computes the tables on the page of published numbers."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    return importlib.import_module("generate.validation")


def test_page_of_published_numbers_is_up_to_date(monkeypatch):
    page = validation(monkeypatch)
    text = page.PAGE.read_text(encoding="utf-8")
    assert [found[1] for found in page.TABLE.findall(text)] == [
        "one_wall", "bifurcations", "chain", "ball", "elements", "wear",
    ]  # fmt: skip
    assert page.written(text, ("one_wall", "chain", "ball", "elements", "wear")) == text


@pytest.mark.slow
def test_table_of_published_bifurcations_is_up_to_date(monkeypatch):
    page = validation(monkeypatch)
    text = page.PAGE.read_text(encoding="utf-8")
    assert page.written(text, ("bifurcations",)) == text


def test_measured_errors_are_not_larger_than_on_the_page(monkeypatch):
    """Quantities and numbers of cases equal those of the page, and no error is larger beyond rounding."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    page = importlib.import_module("generate.right")
    start = page.PAGE.read_text(encoding="utf-8").partition("<!-- table measured")[2]
    lines = start.partition("<!-- end -->")[0].splitlines()[3:]
    printed = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    computed = page.rows()
    assert [row[:3] for row in printed] == [
        [result, other, str(len(errors))] for result, other, errors in computed
    ]
    for (*_, text), (*_, errors) in zip(printed, computed, strict=True):
        assert max(errors) <= page.SLACK * page.number(text)
