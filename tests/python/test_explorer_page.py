"""The explorer's page in a real browser: contents and actions."""

import re
from types import SimpleNamespace

import pytest
import vibroimpact as vi
from shared_explorer import numbers, shown_numbers
from vibroimpact.cases.case import read_namelist
from vibroimpact.explorer.state import State
from vibroimpact.explorer.zones import families
from vibroimpact.plot.zone import LINES


def test_page_shows_what_the_library_computes(page):
    """The table has the motions that `find` finds, the figures their curves, and the chart the zones."""
    page.open("r=1.04&clearance=20")
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    found = set(shown_numbers(vi.find(osc, 1.04, 20.0)))
    rows = page.rows()
    assert found <= {row[1:] for row in numbers(rows)}
    assert {row[1].split()[-1] for row in rows} == {"stable", "unstable"}
    named = [family.name for family in families(osc, State().patterns)]
    assert list(map(str.strip, page.page.locator("#families li").all_inner_texts())) == named
    boundaries = page.page.locator(".legend[aria-label=Boundaries] line")
    styles = [(line.get_attribute("stroke-dasharray")) for line in boundaries.all()]
    assert len(set(styles)) == len(styles) == len(LINES) - 1  # distinguishable without colour
    motion = next(m for m in vi.find(osc, 1.04, 20.0) if m.stable)
    x = page.curve("history", "x")[1]
    assert max(x) == pytest.approx(max(motion.x_max, -motion.x_min), rel=0.2)


def test_pointer_tap_and_drag(page):
    """Hovering shows the motions at the pointer, a click chooses the point, a drag draws the line of a diagram."""
    page.open()
    before = page.rows()
    mouse = page.page.mouse
    mouse.move(*page.place(0.45, 0.3))
    page.page.wait_for_selector("#motions.peeking")
    assert page.text("where") == "under the pointer"
    assert page.rows() != before
    assert page.field("r") == "1.04"  # the point is not chosen
    mouse.move(5, 5)
    page.page.wait_for_selector("#motions:not(.peeking)")
    page.settle()
    assert page.rows() == before
    mouse.click(*page.place(0.45, 0.5))
    page.page.wait_for_function("document.querySelector('[data-field=r]').value !== '1.04'")
    mouse.move(5, 5)
    page.settle()
    r, clearance = float(page.field("r")), float(page.field("clearance"))
    assert 0.9 < r < 1.04
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    assert set(shown_numbers(vi.find(osc, r, clearance))) <= {
        row[1:] for row in numbers(page.rows())
    }
    mouse.move(*page.place(0.3, 0.7))
    mouse.down()
    mouse.move(*page.place(0.7, 0.4), steps=4)
    mouse.up()
    page.page.wait_for_selector("#along:not([hidden])")
    page.page.wait_for_function("document.getElementById('windows').textContent.includes('2/1')")
    along = page.data("diagram.R", "along")
    line = re.search("line=([^&]+)", page.page.url).group(1)
    ends = [float(word) for word in line.split(",")]
    assert [min(along), max(along)] == [ends[0], ends[2]]
    page.page.click("#erase")
    page.page.wait_for_selector("#along", state="hidden")


def test_sliders_redraw(page):
    """A slider changes the zones, the motions and its field; an impossible value is refused with a message."""
    page.open("patterns=RL,RLL")
    fills = page.data("zones.fills", "xs")
    slider = page.page.get_by_role("slider", name="restitution, left wall R₂")
    slider.focus()
    for _ in range(4):
        page.page.keyboard.press("ArrowLeft")
    page.page.wait_for_function("document.getElementById('families').textContent.includes('RLL')")
    page.settle()
    assert page.field("R2") == "0.73"
    assert "symmetric" not in page.text("families")
    assert page.data("zones.fills", "xs") != fills
    page.page.fill("#xi", "1.5")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#fault:not([hidden])")
    assert page.text("fault").startswith("xi = 1.5: must be a number with 0 <= xi < 1")
    page.page.fill("#xi", "0.02")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#fault", state="hidden")
    assert "xi=0.02" in page.page.url


def test_share_link_restores_everything(page):
    """A new tab with the link shows the same system, point, motion, simulation, line, texts and curves."""
    page.open("R2=0.61&r=0.9&clearance=6&patterns=RL,RLL")
    page.page.locator("#table input").nth(1).check()
    page.page.wait_for_function("location.search.includes('motion=')")
    page.page.locator("[data-run=discard]").fill("20")
    page.page.locator("#run").get_by_role("button", name="Simulate").click()
    page.page.wait_for_function("location.search.includes('run=')")
    page.page.locator("#chart").focus()
    page.page.keyboard.press("Shift+L")
    page.page.wait_for_function("location.search.includes('line=')")
    page.settle()
    page.page.click("#link")
    page.page.wait_for_function("document.getElementById('done').textContent === 'Link copied'")
    link = page.page.evaluate("navigator.clipboard.readText()")
    page.page.wait_for_function("document.getElementById('windows').textContent")

    def seen():
        names = ("xi", "mu", "R1", "R2", "r", "clearance", "r_min", "clearance_max", "patterns")
        return SimpleNamespace(
            fields=[page.field(name) for name in names], rows=page.rows(), ran=page.text("ran"),
            runs=[page.field(name, "run") for name in ("x", "z", "t", "cycles", "discard")],
            place=page.text("place"), windows=page.text("windows"), zones=page.text("families"),
            curves=[page.curve("history", key) for key in ("x", "z")],
            impacts=page.data("diagram.R", "x"),
            chosen=page.page.locator("#table tr.chosen td").first.inner_text(),
        )  # fmt: skip

    before = seen()
    assert "the simulation" in before.chosen
    assert before.runs[-1] == "20"
    page.page.goto("about:blank")
    page.open(link.split("?")[1])
    page.page.wait_for_function("document.getElementById('windows').textContent")
    assert page.page.url == link
    assert seen() == before


def test_saved_and_copied_give_the_digits_of_the_table(page, tmp_path):
    """The saved and the copied code give every digit of the table when run."""
    page.open("r=1.04&clearance=20")
    page.page.locator("#run").get_by_role("button", name="Simulate").click()
    page.page.wait_for_function("document.getElementById('ran').textContent.includes('impacts')")
    table = sorted(row[1:] for row in numbers(page.rows()))
    with page.page.expect_download() as saved:
        page.page.click("#namelist")
    saved.value.save_as(tmp_path / saved.value.suggested_filename)
    assert vi.run_namelists([tmp_path / "explorer.nml"], tmp_path / "out").status == 0
    cases = [
        case
        for case in read_namelist(tmp_path / "explorer.nml")
        if case.kind in ("exact", "equispaced")
    ]
    motions = [m for case in cases for m in case.motions()]
    # both equispaced motions are one case, and the result shows which one is admissible
    assert sorted(shown_numbers(m for m in motions if m.admissible)) == table
    page.page.click("#python")
    page.page.wait_for_function("document.getElementById('done').textContent === 'Python copied'")
    copied, names = page.page.evaluate("navigator.clipboard.readText()"), {}
    assert copied == page.page.locator("#export textarea").input_value()
    page.page.click("#close")
    exec(copied, names)
    assert sorted(shown_numbers(names["motions"])) == table
    x = page.curve("history", "x")[1]
    assert (min(x), max(x)) == (
        names["run"].sample(names["run"].events["time"]).X.min(),
        max(x),
    ) or len(x) > 400
    run = names["run"]
    assert page.text("ran").startswith(f"{(run.events['kind'] == 'impact').sum()} impacts")


def test_a_run_from_the_portrait(page):
    """A click in the portrait starts a simulation from the free mass at that point."""
    page.open()
    page.page.locator("#portrait").scroll_into_view_if_needed()
    page.page.mouse.click(*page.place(0.6, 0.4, "portrait"))
    page.page.wait_for_function("location.search.includes('show=run')")
    y = float(page.field("z", "run")) - float(page.field("x", "run"))
    assert -12.5 < y < 12.5
    assert page.rows()[0][0] == "the simulation"
    page.page.click("#stop")
    page.page.wait_for_function("!location.search.includes('run')")
    page.settle()


def test_two_quick_clicks_are_two_points(page):
    """A second click within the time of a double click chooses a separate point."""
    page.open()
    first, second = page.place(0.3, 0.3), page.place(0.7, 0.7)
    page.page.mouse.click(*first)
    page.page.mouse.click(*second)
    page.page.wait_for_function("location.search.includes('clearance=')")
    page.settle()
    quick = page.page.url
    page.page.wait_for_timeout(400)
    page.page.mouse.click(*first)
    page.page.wait_for_function("address => location.href !== address", arg=quick)
    page.page.wait_for_timeout(400)
    page.page.mouse.click(*second)
    page.page.wait_for_function("address => location.href === address", arg=quick)
