"""Physical units in the explorer: next to dimensionless numbers, in texts, on axes, in links and exports."""

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.base.errors import ParameterError
from vibroimpact.cases.case import read_namelist
from vibroimpact.explorer.explorer import Explorer
from vibroimpact.explorer.export import as_namelist, as_python
from vibroimpact.explorer.sketches import history
from vibroimpact.explorer.state import State
from vibroimpact.explorer.words import physical_text

#: 2.7 kg on 42 N/mm under 6 N.
UNITS = vi.Units(0.0027, 42.0, 6.0, "mm N s")
TEXT = "units=0.0027,42,6,mm,N,s"


def test_units_are_part_of_the_link():
    """A link has the units, with or without their names; invalid ones are named."""
    state = State(units=UNITS)
    assert state.query == TEXT
    assert State.read(TEXT) == (state, [])
    assert State.read("units=2.7,42000,6")[0].units == vi.Units(2.7, 42000.0, 6.0)
    assert state.osc.units() == UNITS
    for text, word in (("1 2", "must be M, K and F0"), ("1 2 -3", "F0 = -3.0"), ("1 2 3 mm N day", "names"),
                       ("1 x 3", "K = 'x'")):  # fmt: skip
        with pytest.raises(ParameterError, match=word):
            State().changed({"units": text})


def test_exports_keep_the_units(tmp_path):
    """The namelist and the Python of the page have a system with units."""
    explorer = Explorer(State(units=UNITS))
    path = tmp_path / "explorer.nml"
    path.write_text(as_namelist(explorer))
    assert all(case.osc.units() == UNITS for case in read_namelist(path))
    names = {}
    exec(as_python(explorer), names)
    assert names["osc"].units() == UNITS


def test_numbers_are_those_of_the_physical_result():
    """The text has the numbers of the motion in physical units, and the second axes have its scales."""
    motion = next(m for m in vi.find(State(units=UNITS).osc, 1.04, 20.0) if m.stable)
    physical = motion.physical()
    found = physical.quantities()
    text = physical_text(motion, UNITS)
    assert f"max|X| = {found.x.peak:.4g} mm" in text
    assert f"rms X = {found.x.rms:.4g} mm" in text
    assert f"max|Ẋ| = {found.x_dot.peak:.4g} mm/s" in text
    assert f"max|Ẍ| = {found.x_ddot.peak:.4g} mm/s²" in text
    assert f"greatest impact speed = {found.impacts['speed'].max():.4g} mm/s" in text
    assert f"period = {physical.period:.4g} s" in text
    picture = history(motion, 2, UNITS)
    (time, seconds), (x, length) = picture["history"]["second"]
    assert (time, x) == ("time  (s)", "X, Z  (mm)")
    assert seconds == pytest.approx(physical.period)
    assert length == UNITS.length
    assert picture["portrait"]["second"][1] == ["dY/dt  (mm/s)", UNITS.velocity]
    # lengths of a rig in metres are shown in millimetres
    assert physical_text(motion, UNITS.to("SI")) == text
    assert "second" not in history(motion, 2)["history"]


def test_units_on_the_page(page):
    """The field sets the units: axes in Hz and mm, numbers of the chosen motion, and their removal."""
    page.open("r=1.04&clearance=20&patterns=RL")
    assert page.page.locator("#physical").is_hidden()
    page.page.evaluate("document.querySelector('details').open = true")
    page.page.fill("[data-field=units]", "0.0027 42 6 mm N s")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#physical:not([hidden])")
    page.settle()
    assert TEXT in page.page.url

    def of(name, key):
        return page.page.evaluate(
            "([name, key]) => Bokeh.documents[0].get_model_by_name(name)[key]", [name, key]
        )

    f = UNITS.frequency
    assert [of("zones.f", "start"), of("zones.f", "end")] == pytest.approx([0.8 * f, 1.2 * f])
    assert [of("zones.d", "start"), of("zones.d", "end")] == pytest.approx(
        [2 * UNITS.length, 200 * UNITS.length]
    )
    assert of("zones.above", "axis_label") == "load frequency  (Hz)"
    assert of("zones.beside", "axis_label") == "clearance d  (mm)"
    assert of("zones.above", "visible")
    assert f"r = 1.04 ({1.04 * f:.5g} Hz)" in page.text("place")
    assert f"(d = {20 * UNITS.length:.5g} mm)" in page.text("place")
    motion = max(
        (m for m in vi.find(State().osc, 1.04, 20.0) if m.stable), key=lambda m: -len(m.pattern)
    )
    second = page.page.evaluate("vibroimpact.sketches.history.shown().second")
    assert second[0][1] == pytest.approx(2 * np.pi / 1.04 * UNITS.time)
    assert f"max|X| = {motion.quantities().x.peak * UNITS.length:.3g}"[:12] in page.text("physical")
    page.page.fill("[data-field=units]", "0.0027 42")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#fault:not([hidden])")
    assert page.text("fault").startswith("units = '0.0027 42': must be M, K and F0")
    page.page.fill("[data-field=units]", "")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#physical", state="hidden")
    assert not of("zones.above", "visible")
    assert "units=" not in page.page.url
