"""The explorer's page in a real browser: layout, keyboard, shades of grey, phones."""

import itertools
import re
from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest


def test_keyboard(page):
    """Tab reaches the chart and shows its focus, arrow keys move the point, and L draws a line."""
    page.open()
    for _ in range(40):
        page.page.keyboard.press("Tab")
        if page.page.evaluate("document.activeElement.id") == "chart":
            break
    style = page.page.evaluate(
        "(s => [s.outlineStyle, parseFloat(s.outlineWidth)])(getComputedStyle(document.activeElement))"
    )
    assert style == ["solid", 3]
    page.page.keyboard.press("ArrowRight")
    page.page.keyboard.press("Shift+ArrowUp")
    page.page.wait_for_function("document.querySelector('[data-field=clearance]').value !== '25'")
    page.settle()
    assert float(page.field("r")) == pytest.approx(1.044)
    assert float(page.field("clearance")) == pytest.approx(25 * 100**0.1)
    page.page.keyboard.press("l")
    page.page.wait_for_selector("#along:not([hidden])")
    page.page.keyboard.press("Escape")
    page.page.wait_for_selector("#along", state="hidden")
    # keys are faster than the answers: every step counts, and the line goes through the last point
    page.page.evaluate(
        """() => {
          const press = (key, shiftKey) => document.getElementById("chart").dispatchEvent(
            new KeyboardEvent("keydown", { key, shiftKey, bubbles: true }))
          for (const key of ["ArrowRight", "ArrowRight", "ArrowRight", "ArrowDown", "ArrowLeft"]) press(key, false)
          press("L", true)
        }"""
    )
    page.page.wait_for_selector("#along:not([hidden])")
    page.settle()
    assert float(page.field("r")) == pytest.approx(1.044 + 2 * 0.004)
    clearance = float(page.field("clearance"))
    assert clearance == pytest.approx(25 * 100**0.09)
    line = parse_qs(urlsplit(page.page.url).query)["line"][0]
    assert list(map(float, line.split(","))) == [0.8, clearance, 1.2, clearance]
    page.page.keyboard.press("Escape")
    page.page.wait_for_selector("#along", state="hidden")
    page.page.locator("#table input").first.focus()
    page.page.keyboard.press("ArrowDown")
    page.page.wait_for_function("location.search.includes('motion=')")
    assert page.page.locator("#table tr").nth(1).get_attribute("class").endswith("chosen")
    assert page.page.evaluate("document.activeElement.name") == "motion"


def test_names_for_screen_readers(page):
    """All controls have accessible names, and changing texts are announced."""
    page.open("patterns=RL&line=0.9,10,1.1,10")
    nameless = page.page.evaluate(
        """[...document.querySelectorAll('input, button, textarea, summary, [role=img], #chart')]
        .filter(e => !(e.labels?.length || e.ariaLabel || e.textContent.trim()
                       || e.getAttribute('aria-labelledby')))
        .map(e => e.outerHTML)"""
    )
    assert nameless == []
    assert page.page.locator("[role=status]").count() >= 4
    assert page.page.get_by_role("slider", name="damping ratio ξ").count() == 1
    assert (
        page.page.get_by_role("application", name=re.compile("Zones of stable motions")).count()
        == 1
    )


def test_tab_reaches_everything_in_order(page):
    """Tab visits all controls, from top to bottom in each part, with a visible focus."""
    page.open("patterns=RL&line=0.9,10,1.1,10")
    page.page.evaluate("document.querySelector('details').open = true")
    wanted = page.page.evaluate(
        """() => {
          const every = [...document.querySelectorAll("a, button, input, summary, [tabindex='0']")]
            .filter((one) => one.checkVisibility() && (one.type !== "radio" || one.checked))
          every.forEach((one, i) => { one.dataset.order = i })
          return every.length
        }"""
    )
    page.page.keyboard.press("Tab")
    assert page.page.evaluate("document.activeElement.className") == "skip"
    reached = []
    while len(reached) < wanted:
        reached.append(page.page.evaluate(
            """() => {
              const { left, top } = document.activeElement.getBoundingClientRect()
              const { outlineStyle, outlineWidth } = getComputedStyle(document.activeElement)
              const part = document.activeElement.closest("header, #system, #zones, #motions")
              return { order: Number(document.activeElement.dataset.order), part: part?.id || part?.tagName,
                       top: top + scrollY, left, outline: outlineStyle + parseFloat(outlineWidth) }
            }"""
        ))  # fmt: skip
        page.page.keyboard.press("Tab")
    assert [one["order"] for one in reached] == list(range(wanted))
    assert {one["outline"] for one in reached} == {"solid3"}
    parts = [one["part"] for one in reached]
    assert list(dict.fromkeys(parts)) == [None, "HEADER", "system", "zones", "motions"]
    for part in ("zones", "motions"):
        tops = [one["top"] for one in reached if one["part"] == part]
        assert all(later > before - 10 for before, later in itertools.pairwise(tops)), (part, tops)


def test_nothing_is_told_by_colour_alone(page, tmp_path):
    """In shades of grey the patterns and lines of the legends differ, and the figures use the same ones."""
    page.open("r=1.04&clearance=20&patterns=RL,RRL,RRLL,RRRL")
    hatches = page.page.locator("#families .swatch").evaluate_all(
        "all => all.map(one => one.dataset.hatch)"
    )
    assert len(hatches) == len(set(hatches)) == 6
    assert set(page.data("zones.fills", "hatch")) == set(hatches)
    assert (
        page.page.evaluate("Bokeh.documents[0].get_model_by_name('zones.fills').data.hatch.length")
        >= 6
    )
    page.page.context.new_cdp_session(page.page).send(
        "Emulation.setEmulatedVisionDeficiency", {"type": "achromatopsia"}
    )
    from matplotlib.image import imread

    def pictures(selector):
        found = []
        for i, one in enumerate(page.page.locator(selector).all()):
            one.screenshot(path=tmp_path / f"{i}.png")
            found.append(imread(tmp_path / f"{i}.png")[..., :3])
        shape = np.min([picture.shape for picture in found], axis=0)
        return [picture[: shape[0], : shape[1]] for picture in found]

    for selector in ("#families .swatch", ".legend[aria-label=Boundaries] svg"):
        seen = pictures(selector)
        assert len(seen) >= 6
        assert all(np.ptp(picture, axis=-1).max() < 0.02 for picture in seen)  # the picture is grey
        for one, other in itertools.combinations(seen, 2):
            assert (np.abs(one - other).max(axis=-1) > 0.2).mean() > 0.04
    widths = page.page.evaluate(
        "vibroimpact.sketches.history.shown().parts.filter(one => one.name).map(one => one.width)"
    )
    assert len(set(widths)) == 2
    stable = {row[1].split()[0] for row in page.rows() if row[1].endswith(" stable")}
    assert stable.isdisjoint(
        row[1].split()[0] for row in page.rows() if row[1].endswith("unstable")
    )


def test_names_keep_off_the_point_and_each_other(page):
    """No zone name covers the chosen point, another name or the frame, including on a phone."""
    page.page.set_viewport_size({"width": 390, "height": 844})
    page.open()
    for right, down in ((0.55, 0.4), (0.7, 0.35), (0.3, 0.4)):
        page.page.touchscreen.tap(*page.place(right, down))
        page.page.wait_for_function("location.search.includes('clearance=')")
        page.settle()
        boxes = page.page.evaluate(
            """() => {
              const model = (name) => Bokeh.documents[0].get_model_by_name(name)
              const plot = model("zones.plot"), { inner_width, inner_height, x_range, y_range } = plot
              const place = (x, y) => [(x - x_range.start) / (x_range.end - x_range.start) * inner_width,
                Math.log(y / y_range.start) / Math.log(y_range.end / y_range.start) * inner_height]
              const pen = document.createElement("canvas").getContext("2d")
              pen.font = "12px sans-serif"
              const { x, y, text } = model("zones.labels").data, point = model("zones.point").data
              const boxes = text.map((word, i) => [...place(x[i], y[i]), pen.measureText(word).width + 4, 16])
              const mark = [...place(point.x[0], point.y[0]), 15, 15]
              return { size: [inner_width, inner_height], boxes: [mark, ...boxes] }
            }"""
        )
        assert len(boxes["boxes"]) > 2
        for (x, y, wide, high), (x2, y2, wide2, high2) in itertools.combinations(boxes["boxes"], 2):
            assert abs(x - x2) > 0.5 * (wide + wide2) or abs(y - y2) > 0.5 * (high + high2)
        for x, _, wide, _ in boxes["boxes"][1:]:
            assert 0.5 * wide <= x <= boxes["size"][0] - 0.5 * wide


@pytest.mark.parametrize("width", [1280, 390])
def test_it_fits(page, width, tmp_path):
    """Nothing is wider than the window, every figure is drawn, and controls are large enough to touch."""
    page.page.set_viewport_size({"width": width, "height": 844})
    page.open("patterns=RL,RRL&line=0.9,10,1.1,30")
    assert page.page.evaluate("document.documentElement.scrollWidth") == width
    if width == 390:
        page.page.touchscreen.tap(*page.place(0.5, 0.4))
        page.page.wait_for_function("document.querySelector('[data-field=r]').value !== '1.04'")
        page.settle()
        assert not page.page.locator("#motions.peeking").count()
    page.page.wait_for_function("document.getElementById('windows').textContent")
    from matplotlib.image import imread

    for name in ("chart", "diagram", "history", "portrait", "circle"):
        box = page.page.locator(f"#{name}").bounding_box()
        assert 0 <= box["x"] < box["x"] + box["width"] <= width
        page.page.locator(f"#{name}").screenshot(path=tmp_path / f"{name}.png")
        picture = imread(tmp_path / f"{name}.png")[..., :3]
        inside = picture[10:-60, 80:-20]  # excluding the axes
        assert (inside.min(axis=-1) < 0.9).mean() > 0.002, name
        assert len(np.unique(inside.reshape(-1, 3).round(2), axis=0)) > 20, name


def test_a_long_table_shows_that_it_scrolls(page):
    """A table that does not fit has a visible scroll bar that can be dragged, also on a phone."""
    for width in (1280, 390):
        page.page.set_viewport_size({"width": width, "height": 900})
        page.open("r=0.96&clearance=20&patterns=RL")
        rows, high, whole, bar, style = page.page.evaluate(
            """() => {
              const box = document.querySelector(".scroll"), bar = getComputedStyle(box, "::-webkit-scrollbar")
              return [document.querySelectorAll("#table tr").length, box.clientHeight, box.scrollHeight,
                      parseFloat(bar.width), getComputedStyle(box, "::-webkit-scrollbar-thumb").backgroundColor]
            }"""
        )
        assert rows > 9
        assert high < whole
        assert high > 270
        assert bar >= 10
        assert style == "rgb(140, 140, 140)"


def test_a_swipe_over_the_chart_scrolls(browser, page):
    """A swipe scrolls the page and draws nothing; after a press of the button it draws a line instead."""
    page.page.set_viewport_size({"width": 390, "height": 844})
    page.open("patterns=RL")
    touch = browser.new_cdp_session(page.page)

    def swipe(right, down):
        """Swipe from the middle of the chart."""
        x, y = page.place(0.5, 0.5)
        for part in range(11):
            kind = "touchMove" if part else "touchStart"
            place = {"x": x + 0.1 * part * right, "y": y + 0.1 * part * down}
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [place]})
            page.page.wait_for_timeout(20)
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.page.wait_for_timeout(500)

    for right, down in ((0, -200), (60, -200), (100, 5)):
        page.page.evaluate("scrollTo(0, 0)")
        swipe(right, down)
        assert (page.page.evaluate("scrollY") > 50) == (down == -200)
        assert "line=" not in page.page.url
    page.page.evaluate("scrollTo(0, 0)")
    page.page.locator("#draw").tap()
    assert page.page.locator("#draw").get_attribute("aria-pressed") == "true"
    page.page.evaluate("scrollTo(0, 0)")
    swipe(90, -80)
    page.page.wait_for_function("location.search.includes('line=')")
    assert page.page.evaluate("scrollY") == 0
    assert page.page.locator("#draw").get_attribute("aria-pressed") == "false"
    page.settle()


def test_a_swipe_that_begins_on_a_slider_scrolls(browser, page):
    """A swipe across a slider scrolls the page and keeps the value; a swipe along the slider changes the value."""
    page.page.set_viewport_size({"width": 390, "height": 500})
    page.open("patterns=RL")
    touch = browser.new_cdp_session(page.page)
    slider = page.page.locator("[data-slider=mu]")

    def swipe(right, down):
        """Swipe from a third of the slider's length."""
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        x, y = box["x"] + box["width"] / 3, box["y"] + box["height"] / 2
        for part in range(11):
            kind = "touchMove" if part else "touchStart"
            place = {"x": x + 0.1 * part * right, "y": y + 0.1 * part * down}
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [place]})
            page.page.wait_for_timeout(20)
        touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        page.page.wait_for_timeout(500)
        page.settle()

    before, where = page.field("mu"), page.page.evaluate("scrollY")
    swipe(0, -200)
    assert page.page.evaluate("scrollY") != where
    assert (page.field("mu"), slider.input_value()) == (before, before)
    swipe(60, 0)
    assert page.field("mu") != before
