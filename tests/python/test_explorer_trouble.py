"""The explorer's page in a real browser: invalid links, failures, long computations, several tabs."""

import signal

import vibroimpact as vi
from shared_explorer import Page, numbers, shown_numbers
from vibroimpact.explorer.process import start


def test_bad_link_is_one_message(page):
    """An invalid link gives one message that names the invalid part; the rest is used, and the address is kept."""
    query = "xi=lots&r=0.97&colour=%3Cb%3E&clearance=12"
    page.open(query)
    output = page.text("fault")
    assert page.page.locator("[role=alert]:visible").count() == 1
    assert "xi = 'lots': must be a number with 0 <= xi < 1" in output
    assert "colour = '<b>'" in output
    assert [page.field(name) for name in ("xi", "r", "clearance")] == ["0.0114", "0.97", "12"]
    assert page.page.url.endswith(query)


def test_the_page_tells_that_the_server_has_ended(browser):
    """When the server ends during a computation the page says how to restart it; its address keeps the state."""
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


#: Make every computation fail that takes longer than a frame.
BROKEN = """
from vibroimpact.explorer import background
def broken(*_, **__):
    raise RuntimeError("broken on purpose")
background.compute = background.fuller = background.diagram_of = broken
"""


def test_a_fault_in_a_thread_is_told(browser):
    """The page names failed zones, searches and diagrams, does not stay "computing", and still answers."""
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
    assert "RuntimeError: broken on purpose" in err  # with its traceback


#: Zones that take minutes: a motion with rest over a window far larger than its zone.
LONG = "R1=0.5&R2=0.5&r_min=0.05&r_max=5&clearance_min=0.01&clearance_max=1000&patterns="


def test_newer_zones_replace_those_that_take_long(page):
    """After moves of a slider or new patterns, slow zones are dropped and the new ones are soon shown."""
    page.page.goto(f"{page.url}?{LONG}R*L*")
    page.page.wait_for_function("document.getElementById('status').textContent === 'computing …'")
    page.page.locator("[data-slider=xi]").focus()
    for value in ("0.0115", "0.0116"):
        page.page.keyboard.press("ArrowRight")
        page.page.wait_for_function(f"location.search.includes('xi={value}')")
    page.page.evaluate("document.querySelector('details').open = true")
    page.page.fill("[data-field=patterns]", "RL")
    page.page.keyboard.press("Enter")
    page.page.wait_for_function(
        "document.getElementById('families').textContent.includes('RL sym')"
    )
    assert page.text("families").split() == ["RL", "symmetric", "RL", "unsymmetric"]
    assert page.text("status") in ("refining …", "")


def test_zones_that_take_too_long_are_given_up(browser):
    """The page names abandoned zones and shows the others; after a change of patterns it shows all."""
    process, url = start(
        prelude="from vibroimpact.explorer import background as b; b.LIMITS[b.COARSE] = 5"
    )
    tab = browser.new_page()
    page = Page(tab, url)
    tab.goto(f"{url}?{LONG}RL,R*L*")
    output = "R*L*: not computed, given up after 5 s"
    tab.wait_for_function(f"document.getElementById('status').textContent.startsWith('{output}')")
    assert page.text("families").split() == ["RL", "symmetric", "RL", "unsymmetric"]
    tab.evaluate("document.querySelector('details').open = true")
    tab.fill("[data-field=patterns]", "RL")
    tab.keyboard.press("Enter")
    tab.wait_for_function("!document.getElementById('status').textContent.includes('given up')")
    assert page.text("fault") == ""
    tab.close()
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")


def test_no_zone_is_said(page):
    """The page gives the reason for an empty chart."""
    page.open("patterns=RRRRRRRL")
    assert page.text("families") == ""
    assert page.text("status") == "no stable motion was found in this window"


def test_two_tabs_do_not_know_of_each_other(page, browser, server):
    """Two tabs compute at the same time; a change in one does not affect the other; both show correct motions."""
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
        (page, vi.Oscillator(xi=0.0114, mu=0.028, restitution=(0.745, 0.61)), 0.9, 6.0),
        (other, vi.Oscillator(xi=0.02, mu=0.028, restitution=0.75), 1.04, 20.0),
    ):
        found = set(shown_numbers(vi.find(osc, r, clearance)))
        assert found
        assert found <= {row[1:] for row in numbers(one.rows())}
    other.page.close()


def test_reload_in_the_middle_of_computing(page):
    """The page shows the state of its address however often it is reloaded."""
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
    found = set(
        shown_numbers(vi.find(vi.Oscillator(xi=0.014, mu=0.028, restitution=0.75), 1.04, 20.0))
    )
    assert found <= {row[1:] for row in numbers(page.rows())}
    assert page.text("fault") == ""


def test_a_slider_goes_back_to_its_range(page):
    """A number beyond a slider's range extends the range until a number within it is set."""
    page.open("mu=7&patterns=RL")
    slider = page.page.locator("[data-slider=mu]")
    assert float(slider.get_attribute("max")) == 7
    page.page.fill("#mu", "0.1")
    page.page.keyboard.press("Enter")
    page.page.wait_for_function("document.querySelector('[data-slider=mu]').value === '0.1'")
    assert float(slider.get_attribute("max")) == 0.2
