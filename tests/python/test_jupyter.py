"""The HTML that Jupyter shows for a result."""

import base64
import sys
from xml.etree import ElementTree

import numpy as np
import pytest
import vibroimpact as vi
from shared_results import NAMES, STUDIES_NAMED
from shared_systems import FIGURE6


@pytest.mark.parametrize("name", NAMES)
def test_jupyter_shows_a_picture(name, results):
    """The HTML is valid, and has the representation of the result and one image; no figure stays open."""
    plt = pytest.importorskip("matplotlib.pyplot")
    before = plt.get_fignums()
    text = results[name]._repr_html_()
    assert plt.get_fignums() == before
    root = ElementTree.fromstring(text)
    assert root.find("code").text == repr(results[name])
    assert len(text) < 100_000
    kind, _, data = root.find("img").get("src").partition("base64,")
    assert kind == "data:image/png;"
    picture = base64.b64decode(data)
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 3000
    if isinstance(results[name], vi.Motion):
        cells = {row[0].text: row[1].text for row in root.iter("tr")}
        moduli = [float(word) for word in cells["|λ|"].split(", ")]
        assert moduli == pytest.approx(np.abs(results[name].multipliers), rel=1e-3)


def test_jupyter_without_matplotlib(results, monkeypatch):
    """Without matplotlib the HTML has a table of numbers and no image."""
    for module in [name for name in sys.modules if name.split(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = results["motion"]._repr_html_()
    assert "img" not in text
    assert "<table>" in text


def test_jupyter_of_an_empty_zone():
    """The HTML of an empty zone states that it is empty."""
    zone = vi.zone(FIGURE6, vi.Pattern("RL"), (0.9, 1.0), (1e5, 1e6), lines=5, guesses=1)
    assert "0 loops" in zone._repr_html_()
    assert "img" not in zone._repr_html_()


@pytest.mark.parametrize("name", [name for name in STUDIES_NAMED if name != "one"])
def test_jupyter_shows_studies_of_attractors(name, attractors):
    """Studies of attractors are shown with a picture, except basins of states outside a plane."""
    pytest.importorskip("matplotlib")
    root = ElementTree.fromstring(attractors[name]._repr_html_())
    assert root.find("code").text == repr(attractors[name])
    assert (root.find("img") is None) == (name == "states")
