"""Untrusted texts in links, fields, results and file names: none of them runs in a real browser."""

import dataclasses
from pathlib import Path
from urllib.parse import urlencode

import pytest
import vibroimpact as vi
from vibroimpact.explorer.state import State
from vibroimpact.reproduce.report import pretty, verdict

#: A text that ends an attribute, a text or a script of either kind, and would run in each.
HOSTILE = (
    "\"onload=\"hit()\" 'onerror='hit()'--></title></style></script></svg>"
    "<script>hit()</script><img src=x onerror=hit()><svg onload=hit()>{{hit()}}`${hit()}`"
)
#: Counts scripts that run, and elements that the text creates.
WATCH = "window.hits = 0; window.hit = () => { window.hits += 1 }"
FOUND = """() => {
  const parts = document.querySelectorAll("img[src=x], svg[onload], [onerror]")
  const scripts = [...document.scripts].filter((script) => script.text === "hit()")
  return [window.hits, parts.length, scripts.length]
}"""


@pytest.fixture
def tab(browser):
    """A browser tab with the counter."""
    found = browser.new_page()
    found.add_init_script(WATCH)
    yield found
    found.close()


def show(tab, path, body):
    """Open a page with this body from a file, and wait until it is loaded."""
    path.write_text(f"<!doctype html><meta charset=utf-8><body>{body}</body>", encoding="utf-8")
    tab.goto(path.as_uri())
    tab.wait_for_load_state("load")


def test_the_watch_sees_what_runs(tab, tmp_path):
    """A page with this text unescaped runs it."""
    show(tab, tmp_path / "page.html", HOSTILE)
    tab.wait_for_function("window.hits > 1")
    assert all(tab.evaluate(FOUND))


def test_links_and_fields_of_the_explorer(page):
    """Every part of a link, an unknown one, and every field show or refuse such a text; nothing runs."""
    page.page.add_init_script(WATCH)
    names = [*(item.name for item in dataclasses.fields(State) if item.name != "map"), "nonsense"]
    page.open(urlencode(dict.fromkeys([*names, HOSTILE], HOSTILE)))
    assert [name for name in names if name not in page.text("fault")] == []
    assert page.page.evaluate(FOUND) == [0, 0, 0]
    assert "<script>" in page.text("fault")
    page.page.evaluate(
        "document.querySelectorAll('details').forEach((item) => { item.open = true })"
    )
    for name in ("patterns", "units"):
        field = page.page.locator(f"[data-field={name}]")
        field.fill(HOSTILE)
        field.press("Enter")
        page.page.wait_for_function("document.querySelector('#fault:not([hidden])')")
    page.page.evaluate(
        "text => document.querySelectorAll('input').forEach((item) => {"
        " if (item.type === 'text') { item.value = text; item.dispatchEvent(new Event('change')) } })",
        HOSTILE,
    )
    page.settle()
    assert page.page.evaluate(FOUND) == [0, 0, 0]


def hostile(noun):
    """A result with hostile texts."""
    changed = {
        "notes": ((True, HOSTILE),),
        "remarks": (HOSTILE,),
        "case": f"{noun._result.case}! {HOSTILE}\n",
    }
    return type(noun).of_result(dataclasses.replace(noun._result, **changed))


def test_pages_of_notebooks_and_reports(tab, tmp_path, results):
    """Results, also through xarray, and the report; a picture and an animation with such a name."""
    found = [hostile(results[name]) for name in ("motion", "zone")]
    assert "&lt;script" in found[1]._repr_html_()
    texts = [result._repr_html_() for result in found]
    texts += [found[0].to_xarray()._repr_html_(), pretty(HOSTILE), verdict(HOSTILE)]
    axes = found[1].plot()
    axes.figure.set_layout_engine("none")
    axes.set(title=HOSTILE, xlabel=HOSTILE)
    axes.plot([0], [0], label=HOSTILE)
    axes.legend()
    axes.figure.savefig(tmp_path / "picture.svg", metadata={"Title": HOSTILE, "Creator": HOSTILE})
    texts.append((tmp_path / "picture.svg").read_text().partition("<svg")[2].join(["<svg", ""]))
    for text in texts:
        show(tab, tmp_path / "page.html", text)
        assert tab.evaluate(FOUND) == [0, 0, 0], text[:200]


def test_names_of_files(tmp_path, results):
    """A result is saved and read under such a name, and messages repeat the name literally."""
    name = HOSTILE.replace("/", "_")[:200]
    path = Path(tmp_path) / f"{name}.json"
    results["motion"].save(path)
    assert repr(vi.load(path)) == repr(results["motion"])
    path.write_text("{")
    with pytest.raises(vi.ParameterError) as caught:
        vi.load(path)
    assert repr(str(path)) in str(caught.value)
