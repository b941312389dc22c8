"""The explorer's server, a real browser, and the page in it."""

import os
import shutil
import signal

import pytest
from vibroimpact.explorer.process import SETTLED, start


def lacking(what):
    """Without a browser, skip the tests of the page; fail them where all tests are required."""
    (pytest.fail if os.environ.get("CI") else pytest.skip)(f"{what} is not installed")


@pytest.fixture(scope="session")
def server():
    """The explorer's address."""
    process, url = start()
    yield url
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=20)
    assert (process.returncode, err) == (0, "")


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A browser without any page."""
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
    """The page, with the actions and queries that the tests use."""

    def __init__(self, page, url):
        """Take the page of the browser."""
        self.page, self.url = page, url

    def open(self, query=""):
        """Open the page at a query, and wait until everything is computed."""
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
        """The text of an element of the page."""
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
        """A position in a figure, in pixels, given as fractions of its box."""
        box = self.page.locator(f"#{figure}").bounding_box()
        return box["x"] + right * box["width"], box["y"] + down * box["height"]

    def data(self, model, key):
        """A column of a table of the chart or the diagram, as held by the browser."""
        return self.page.evaluate(
            "([model, key]) => Array.from(Bokeh.documents[0].get_model_by_name(model).data[key])",
            [model, key],
        )

    def curve(self, figure, name):
        """The coordinates along a named part of a small figure, as held by the browser."""
        return self.page.evaluate(
            """([figure, name]) => {
              const part = vibroimpact.sketches[figure].shown().parts.find((one) => one.name === name)
              return (part.line ?? part.marks).slice(0, 2).map((numbers) => Array.from(numbers))
            }""",
            [figure, name],
        )


@pytest.fixture
def page(browser, server):
    """The page in a new tab; at the end, check that it logged no errors and requested nothing from other hosts."""
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
    """Label, X_max/A and |lambda| of the rows of the table, except the row of the simulation."""
    return [(label, ratio, leading.split()[0]) for label, _, ratio, leading in rows if ratio]


def shown_numbers(motions):
    """The same entries, formatted from the numbers of the motions."""
    return [(f"{m.attenuation:.6g}", f"{abs(m.multipliers[0]):.6g}") for m in motions]
