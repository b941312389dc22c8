"""The map of max|X|/A behind the zones, and the box of tolerances on it."""

from urllib.parse import parse_qs, urlsplit

import numpy as np
import pytest
import vibroimpact as vi
from vibroimpact.explorer.attenuation import SAMPLES, SIZE, box_points, filled, judged, map_parts
from vibroimpact.explorer.state import Box, State

OSC = State().osc
WINDOW = ((0.95, 1.1), (10.0, 60.0))


def whole_map(osc, window):
    """The map computed part by part, and the points of its picture."""
    picture = np.full(SIZE[::-1], np.nan)
    r, clearance = np.full_like(picture, np.nan), np.full_like(picture, np.nan)
    for x, y, places, step in map_parts(window):
        filled(picture, places, judged(osc, x, y).attenuation, step)
        assert np.isnan(r[tuple(places)]).all()
        r[tuple(places)], clearance[tuple(places)] = x, y
    return picture, r, clearance


def test_the_parts_make_up_the_map():
    """Each point is computed once, at its own position, and has the value that it has alone."""
    picture, r, clearance = whole_map(OSC, WINDOW)
    assert (np.ptp(r, axis=0) == 0).all()
    assert (np.ptp(clearance, axis=1) == 0).all()
    assert (np.diff(r[0]) > 0).all()
    np.testing.assert_allclose(np.diff(np.log(clearance[:, 0])), np.log(6) / SIZE[1])
    some = (slice(None, None, 7), slice(None, None, 11))
    alone = judged(OSC, r[some].ravel(), clearance[some].ravel())
    np.testing.assert_array_equal(picture[some].ravel(), alone.attenuation)


def test_values_are_those_of_motions():
    """Where only one motion is stable, simulations alone give its max|X|/A and stability."""
    compared = 0
    for r, clearance in ((1.04, 25.0), (1.02, 30.0), (1.0, 20.0), (1.08, 12.0)):
        stable = [m for m in vi.find(OSC, r, clearance) if m.stable]
        ratios = {round(m.attenuation, 6) for m in stable}
        found = judged(OSC, np.array([r]), np.array([clearance]))
        if len(ratios) == 1 and found.stable[0]:
            assert found.attenuation[0] == pytest.approx(stable[0].attenuation, rel=1e-5)
            compared += 1
    assert compared >= 2


def test_points_of_a_box_are_spread_evenly():
    """Each strip, in both directions, has exactly one point; the box moves all points alike."""
    box = Box(1.0, 20.0, 0.02, 4.0)
    r, clearance = box_points(box)
    for values, (low, high) in zip((r, clearance), box.ends, strict=True):
        strip = np.floor((values - low) / (high - low) * SAMPLES).astype(int)
        assert sorted(strip.tolist()) == list(range(SAMPLES))
    assert abs(np.corrcoef(r, clearance)[0, 1]) < 0.15
    shifted = box_points(Box(1.1, 30.0, 0.02, 4.0))
    np.testing.assert_allclose(shifted[0] - r, 0.1)
    np.testing.assert_allclose(shifted[1] - clearance, 10)


def picture_of(page):
    """The map that the browser shows."""
    return np.array(
        page.page.evaluate(
            "Array.from(Bokeh.documents[0].get_model_by_name('zones.map').data.image[0])"
        )
    ).reshape(SIZE[::-1])


def visible(page, name):
    """Whether a part of the chart is visible."""
    return page.page.evaluate(
        "(name) => Bokeh.documents[0].get_model_by_name(name).visible", f"zones.{name}"
    )


def test_the_map_on_the_page(page):
    """The button shows the map that the library computes, with its colour bar; a slider makes a new map."""
    query = "r_min=0.95&r_max=1.1&clearance_min=10&clearance_max=60&patterns=RL"
    page.open(query)
    assert not visible(page, "image")
    assert not visible(page, "bar")
    page.page.click("#map")
    page.page.wait_for_function("document.getElementById('mapped').textContent.endsWith('…')")
    page.page.wait_for_function("location.search.includes('map=on')")
    page.settle()
    assert page.page.locator("#map").get_attribute("aria-pressed") == "true"
    assert visible(page, "image")
    assert visible(page, "bar")
    np.testing.assert_array_equal(picture_of(page), whole_map(OSC, WINDOW)[0])
    place = {name: page.data("zones.map", name)[0] for name in ("x", "y", "dw", "dh")}
    assert list(place.values()) == pytest.approx([0.95, 10, 0.15, 50])
    # two changes in quick succession: the map is that of the last one
    for value in ("0.5", "0.6"):
        page.page.fill("#R1", value)
        page.page.keyboard.press("Enter")
    page.page.wait_for_function("location.search.includes('R1=0.6')")
    page.settle()
    changed = State(R1=0.6)
    np.testing.assert_array_equal(picture_of(page), whole_map(changed.osc, WINDOW)[0])
    page.page.click("#map")
    page.page.wait_for_function("!location.search.includes('map=on')")
    assert not visible(page, "image")


def test_the_box_is_dragged(page):
    """A drag from within the box moves it; on release the share of its points below the limit is that of the
    library."""
    page.open("box=1.02,25,0.02,5&limit=0.6&patterns=RL")
    mouse, seen = page.page.mouse, []
    for part in (0.3, 0.7):  # two points with known pixels; two quick clicks give two points
        pixel = page.place(part, part)
        address = page.page.url
        mouse.click(*pixel)
        page.page.wait_for_function("address => location.href !== address", arg=address)
        page.settle()
        seen.append((pixel, float(page.field("r")), np.log(float(page.field("clearance")))))

    def at(r, clearance):
        """A position in the chart, in pixels of the window."""
        ((x0, y0), r0, d0), ((x1, y1), r1, d1) = seen
        return (
            x0 + (r - r0) / (r1 - r0) * (x1 - x0),
            y0 + (np.log(clearance) - d0) / (d1 - d0) * (y1 - y0),
        )

    before = page.text("boxed")
    mouse.move(*at(1.025, 26.0))
    mouse.down()
    mouse.move(*at(1.04, 40.0), steps=4)
    shifted = page.data("zones.box", "left")[0]
    assert shifted > 1.005
    assert page.text("boxed") == before  # until it is released
    mouse.move(*at(1.065, 52.0), steps=4)
    mouse.up()
    page.page.wait_for_function("!location.search.includes('box=1.02,')")
    mouse.move(5, 5)
    page.settle()
    query = parse_qs(urlsplit(page.page.url).query)
    assert "line" not in query
    box = Box(*map(float, query["box"][0].split(",")))
    assert (box.r_half, box.clearance_half) == (0.02, 5.0)
    assert box.r == pytest.approx(1.06, abs=0.002)
    assert box.clearance == pytest.approx(50, rel=0.03)
    assert float(page.field("r", "box")) == box.r
    found = judged(OSC, *box_points(box))
    good = found.attenuation <= 0.6
    assert page.text("boxed").startswith(
        f"{100 * good.mean():.4g} % of 400 points have max|X|/A ≤ 0.6 on every attractor reached, "
        f"{100 * found.stable.mean():.4g} % settle on periodic motions."
    )
    assert page.text("boxed") != before
    np.testing.assert_array_equal(page.data("zones.bad", "x"), found.r[~good])
    # another limit applies to the same points
    limit = float(np.quantile(found.attenuation, 0.3))
    page.page.fill("[data-field=limit]", f"{limit:.4g}")
    page.page.keyboard.press("Enter")
    page.page.wait_for_function("document.getElementById('boxed').textContent.startsWith('30')")
    # a drag from outside the box draws a line
    mouse.move(*at(0.85, 10.0))
    mouse.down()
    mouse.move(*at(0.95, 30.0), steps=4)
    mouse.up()
    page.page.wait_for_function("location.search.includes('line=')")
    page.page.click("#box")
    page.page.wait_for_function("!location.search.includes('box=')")
    assert page.data("zones.box", "left") == []
    assert page.page.locator("#tolerances").is_hidden()


def test_the_fields_of_the_box(page):
    """The button shows a box around the point; its fields change it, and invalid values are named."""
    page.open("patterns=RL")
    page.page.click("#box")
    page.page.wait_for_selector("#tolerances:not([hidden])")
    page.settle()
    assert (page.field("r", "box"), page.field("clearance", "box")) == ("1.04", "25")
    page.page.fill("[data-box=r_half]", "0.03")
    page.page.keyboard.press("Enter")
    page.page.wait_for_function("location.search.includes('box=1.04,25,0.03,2.5')")
    page.settle()
    assert page.data("zones.box", "right")[0] == pytest.approx(1.07)
    page.page.fill("[data-box=clearance_half]", "40")
    page.page.keyboard.press("Enter")
    page.page.wait_for_selector("#fault:not([hidden])")
    assert page.text("fault").startswith("clearance_half of the box = 40.0: must be")
    assert "box=1.04,25,0.03,2.5" in page.page.url
