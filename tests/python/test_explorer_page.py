"""The explorer's page in a real browser: what it shows and does, and what it stands."""

import itertools
import os
import re
import shutil
import signal
from types import SimpleNamespace

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.explorer.process import SETTLED, start
from vibroimpact.explorer.state import State
from vibroimpact.explorer.zones import families
from vibroimpact.plot.zone import LINES
from vibroimpact.run import read_namelist


def lacking(what):
    """Without a browser the page cannot be tested: a reason to skip here, a fault where all is to be tested."""
    (pytest.fail if os.environ.get("CI") else pytest.skip)(f"{what} is not installed")


@pytest.fixture(scope="module")
def server():
    """The explorer's address."""
    process, url = start()
    yield url
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A browser with nothing in it."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        lacking("playwright")
    path = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )
    if path is None:
        lacking("chromium")
    flags = (
        "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
        "--disable-component-update --disable-sync"
    )
    with sync_playwright() as driver:
        context = driver.chromium.launch_persistent_context(
            tmp_path_factory.mktemp("profile"), executable_path=path, headless=True, args=flags.split(),
            has_touch=True, accept_downloads=True, viewport={"width": 1280, "height": 900},
            permissions=["clipboard-read", "clipboard-write"],
        )  # fmt: skip
        context.set_default_timeout(60_000)
        yield context
        context.close()


class Page:
    """The page, and what the tests do with it."""

    def __init__(self, page, url):
        """`page` is the browser's."""
        self.page, self.url = page, url

    def open(self, query=""):
        """Go there, and wait until everything is computed."""
        self.page.goto(f"{self.url}?{query}" if query else self.url)
        self.page.wait_for_function(
            "window.vibroimpact && document.getElementById('table').children.length"
        )
        return self.settle()

    def settle(self):
        """Wait until every question is answered and every thread is done."""
        self.page.wait_for_function(SETTLED)
        return self

    def text(self, name):
        """What an element says."""
        return self.page.locator(f"#{name}").text_content().strip()

    def field(self, name, kind="field"):
        """The value of a field."""
        return self.page.locator(f"[data-{kind}='{name}']").input_value()

    def rows(self):
        """The cells of the table, as text."""
        return self.page.evaluate(
            "[...document.querySelectorAll('#table tr')].map(r => [...r.cells].map(c => c.innerText.trim()))"
        )

    def place(self, right, down, figure="chart"):
        """A place in a figure, in pixels; parts of its box."""
        box = self.page.locator(f"#{figure}").bounding_box()
        return box["x"] + right * box["width"], box["y"] + down * box["height"]

    def data(self, model, key):
        """A column of a table of the chart or the diagram, as the browser has it."""
        return self.page.evaluate(
            "([model, key]) => Array.from(Bokeh.documents[0].get_model_by_name(model).data[key])",
            [model, key],
        )

    def curve(self, figure, name):
        """The coordinates along a named part of a small figure, as the browser has them."""
        return self.page.evaluate(
            """([figure, name]) => {
              const part = vibroimpact.sketches[figure].shown().parts.find((one) => one.name === name)
              return (part.line ?? part.marks).slice(0, 2).map((numbers) => Array.from(numbers))
            }""",
            [figure, name],
        )


@pytest.fixture
def page(browser, server):
    """The page in a new tab; afterwards: no errors were logged, and nothing was asked of the network."""
    tab, faults, asked = browser.new_page(), [], []
    tab.set_viewport_size({"width": 1280, "height": 900})
    tab.on("console", lambda m: faults.append(m.text) if m.type in ("error", "warning") else None)
    tab.on("pageerror", lambda error: faults.append(str(error)))
    tab.on("request", lambda request: asked.append(request.url))
    yield Page(tab, server)
    tab.close()
    assert faults == []
    assert asked
    own = (server, f"blob:{server}", "data:")
    assert [url for url in asked if not url.startswith(own)] == []


def numbers(rows):
    """Of the table without the simulation: label, X_max/A, |lambda|."""
    return [(label, ratio, leading.split()[0]) for label, _, ratio, leading in rows if ratio]


def shown_numbers(motions):
    """The same of motions, by their own digits."""
    return [(f"{m.attenuation:.6g}", f"{abs(m.multipliers[0]):.6g}") for m in motions]


def test_page_shows_what_the_library_computes(page):
    """The table has the motions that `find` finds here, the figures have their curves, the chart the zones."""
    page.open("r=1.04&clearance=20")
    osc = vi.Oscillator(0.0114, 0.028, 0.75)
    found = set(shown_numbers(vi.find(osc, 1.04, 20.0)))
    rows = page.rows()
    assert found <= {row[1:] for row in numbers(rows)}
    assert {row[1].split()[-1] for row in rows} == {"stable", "unstable"}
    named = [family.name for family in families(osc, State().patterns)]
    assert list(map(str.strip, page.page.locator("#families li").all_inner_texts())) == named
    boundaries = page.page.locator(".legend[aria-label=Boundaries] line")
    styles = [(line.get_attribute("stroke-dasharray")) for line in boundaries.all()]
    assert len(set(styles)) == len(styles) == len(LINES) - 1  # told apart without colour
    motion = next(m for m in vi.find(osc, 1.04, 20.0) if m.stable)
    x = page.curve("history", "x")[1]
    assert max(x) == pytest.approx(max(motion.x_max, -motion.x_min), rel=0.2)


def test_pointer_tap_and_drag(page):
    """The pointer looks, a click chooses, a drag draws a line and its diagram."""
    page.open()
    before = page.rows()
    mouse = page.page.mouse
    mouse.move(*page.place(0.45, 0.3))
    page.page.wait_for_selector("#motions.peeking")
    assert page.text("where") == "under the pointer"
    assert page.rows() != before
    assert page.field("r") == "1.04"  # not chosen
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
    osc = vi.Oscillator(0.0114, 0.028, 0.75)
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
    """A slider changes the zones, the motions and its field; what cannot be says so and is not taken."""
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


def test_keyboard(page):
    """The chart is reached by Tab, its focus is seen, arrows move the point, L draws a line."""
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
    page.page.locator("#table input").first.focus()
    page.page.keyboard.press("ArrowDown")
    page.page.wait_for_function("location.search.includes('motion=')")
    assert page.page.locator("#table tr").nth(1).get_attribute("class").endswith("chosen")
    assert page.page.evaluate("document.activeElement.name") == "motion"


def test_names_for_screen_readers(page):
    """Whatever can be used has a name, and the texts that change are announced."""
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


def test_share_link_restores_everything(page):
    """A new tab on the link shows the same: system, point, motion, simulation, line, texts and curves."""
    page.open("R2=0.61&r=0.9&clearance=6&patterns=RL,RLL")
    page.page.locator("#table input").nth(1).check()
    page.page.wait_for_function("location.search.includes('motion=')")
    page.page.locator("[data-run=discard]").fill("20")
    page.page.locator("#run").get_by_role("button", name="Let it run").click()
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


def test_bad_link_is_one_message(page):
    """What is wrong is named once, the rest is there, and the address is not touched."""
    query = "xi=lots&r=0.97&colour=%3Cb%3E&clearance=12"
    page.open(query)
    said = page.text("fault")
    assert page.page.locator("[role=alert]:visible").count() == 1
    assert "xi = 'lots': must be a number with 0 <= xi < 1" in said
    assert "colour = '<b>'" in said
    assert [page.field(name) for name in ("xi", "r", "clearance")] == ["0.0114", "0.97", "12"]
    assert page.page.url.endswith(query)


def test_saved_and_copied_give_the_digits_of_the_table(page, tmp_path):
    """What is saved and what is copied is run; every digit in the table is theirs."""
    page.open("r=1.04&clearance=20")
    page.page.locator("#run").get_by_role("button", name="Let it run").click()
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
    # both equispaced motions are one case, and the result says which is admissible
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
    """A click in the portrait puts the free mass there."""
    page.open()
    page.page.mouse.click(*page.place(0.6, 0.4, "portrait"))
    page.page.wait_for_function("location.search.includes('show=run')")
    y = float(page.field("z", "run")) - float(page.field("x", "run"))
    assert -12.5 < y < 12.5
    assert page.rows()[0][0] == "the simulation"
    page.page.click("#stop")
    page.page.wait_for_function("!location.search.includes('run')")
    page.settle()


def test_the_page_tells_that_the_server_has_ended(browser):
    """In the middle of computing: it says how to go on, and its address still holds what is shown."""
    process, url = start()
    tab = browser.new_page()
    page = Page(tab, url)
    page.open("patterns=RL")
    tab.locator("[data-slider=xi]").focus()
    tab.keyboard.press("ArrowRight")
    tab.wait_for_function("location.search.includes('xi=')")
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 0
    tab.wait_for_selector("#fault:not([hidden])")
    assert "vibroimpact explore" in page.text("fault")
    assert "computing" not in page.text("status")
    assert tab.url.endswith("xi=0.0115&patterns=RL")
    tab.close()


#: Nothing that takes longer than a frame comes to its end.
BROKEN = """
from vibroimpact.explorer import background
def broken(*_):
    raise RuntimeError("broken on purpose")
background.compute = background.fuller = background.diagram_of = broken
"""


def test_a_fault_in_a_thread_is_told(browser):
    """Zones, search and diagram that fail are said to, nothing goes on "computing", and the page still answers."""
    process, url = start(prelude=BROKEN)
    tab = browser.new_page()
    page = Page(tab, url)
    tab.goto(url)
    tab.wait_for_function("document.getElementById('searched').textContent.startsWith('Not all')")
    assert page.text("status") == "not computed"
    assert "broken on purpose" in page.text("fault")
    assert "\n" not in page.text("fault")
    before = page.rows()
    tab.mouse.move(*page.place(0.45, 0.3))
    tab.wait_for_function(
        "document.querySelector('.peeking') && document.getElementById('searched').textContent.startsWith('Not')"
    )
    assert page.rows() != before
    assert page.page.is_visible("#fault")
    tab.locator("#chart").focus()
    tab.keyboard.press("l")
    tab.wait_for_function("document.getElementById('windows').textContent === 'not computed'")
    assert "the diagram could not be computed" in page.text("fault")
    tab.close()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert process.returncode == 0
    assert "RuntimeError: broken on purpose" in err  # with its place in the program


def test_two_tabs_do_not_know_of_each_other(page, browser, server):
    """Both compute at once; what is changed in one changes nothing in the other, and both are right."""
    other = Page(browser.new_page(), server)
    queries = (
        "R2=0.61&r=0.9&clearance=6&patterns=RL,RLL",
        "xi=0.02&r=1.04&clearance=20&patterns=RL",
    )
    for one, query in zip((page, other), queries, strict=True):
        one.page.goto(f"{server}?{query}")
    for one in (page, other):
        one.settle()
    before = other.rows(), other.text("families"), other.page.url
    page.page.locator("[data-slider=R1]").focus()
    page.page.keyboard.press("ArrowLeft")
    page.page.wait_for_function("location.search.includes('R1=')")
    page.settle()
    assert (other.rows(), other.text("families"), other.page.url) == before
    for one, osc, r, clearance in (
        (page, vi.Oscillator(0.0114, 0.028, (0.745, 0.61)), 0.9, 6.0),
        (other, vi.Oscillator(0.02, 0.028, 0.75), 1.04, 20.0),
    ):
        found = set(shown_numbers(vi.find(osc, r, clearance)))
        assert found
        assert found <= {row[1:] for row in numbers(one.rows())}
    other.page.close()


def test_reload_in_the_middle_of_computing(page):
    """The page comes back with what its address holds, however often."""
    page.page.goto(f"{page.url}?r=1.04&clearance=20&patterns=RL,RRL")
    for value in ("0.012", "0.013", "0.014"):
        page.page.wait_for_function(
            "window.vibroimpact && document.getElementById('table').children.length"
        )
        page.page.fill("#xi", value)
        page.page.keyboard.press("Enter")
        page.page.wait_for_function(f"location.search.includes('xi={value}')")
        page.page.reload()
    page.settle()
    found = set(shown_numbers(vi.find(vi.Oscillator(0.014, 0.028, 0.75), 1.04, 20.0)))
    assert found <= {row[1:] for row in numbers(page.rows())}
    assert page.text("fault") == ""


def test_tab_reaches_everything_in_order(page):
    """Tab goes through all that can be used, from top to bottom of each part, and its place is seen."""
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
    """In shades of grey the patterns and lines of the legends differ; the figures have the same ones."""
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
        assert all(np.ptp(picture, axis=-1).max() < 0.02 for picture in seen)  # it is grey
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
    """On a phone too: no zone's name lies on the chosen point, on another name, or across the frame."""
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


def test_a_slider_goes_back_to_its_range(page):
    """A number beyond its end stretches it for as long as the number stands there."""
    page.open("mu=7&patterns=RL")
    slider = page.page.locator("[data-slider=mu]")
    assert float(slider.get_attribute("max")) == 7
    page.page.fill("#mu", "0.1")
    page.page.keyboard.press("Enter")
    page.page.wait_for_function("document.querySelector('[data-slider=mu]').value === '0.1'")
    assert float(slider.get_attribute("max")) == 0.2


@pytest.mark.parametrize("width", [1280, 390])
def test_it_fits(page, width, tmp_path):
    """Nothing is wider than the window, every figure has a picture in it, and a finger can use it."""
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
        inside = picture[10:-60, 80:-20]  # without the axes
        assert (inside.min(axis=-1) < 0.9).mean() > 0.002, name
        assert len(np.unique(inside.reshape(-1, 3).round(2), axis=0)) > 20, name
