"""Comparison of three pictures with those kept in tests/data/pictures.

They are compared as means over squares of pixels: a line of another style, colour or place changes the
squares that it crosses, another anti-aliasing does not. Text is left out altogether, since fonts differ
from one machine to the next. After an intended change, look at the new pictures and keep them:

    .venv/bin/python tests/python/test_pictures.py
"""

import io
import sys
from pathlib import Path

import numpy as np
import pytest
import vibroimpact as vi

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.text import Text  # noqa: E402
from PIL import Image  # noqa: E402

KEPT = Path(__file__).parents[1] / "data" / "pictures"
#: Side of a square in pixels, and the largest difference allowed between squares, of 255.
SQUARE, MOST = 6, 16
OSC = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)


def zone(ax):
    """The zone of Figure 6(b), traced coarsely."""
    vi.zone(OSC, vi.Pattern("RRL"), r=(0.8, 1.2), clearance=(2, 200)).plot(ax, inverse=True)


def motion(ax):
    """The motion near the third column of Table 1."""
    osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    guess = ([0, 1.37 * np.pi], vi.Pattern("RL"))
    vi.exact(osc, 0.94, 37.0, guess).plot(ax, "history")


def bifurcation(ax):
    """A sweep over periodic motions, which does not depend on rounding."""
    vi.bifurcation_diagram(
        OSC, "clearance", np.linspace(16, 18.4, 25), r=1.0, sweep="up", settling=100
    ).plot(ax)


DRAWN = {"zone": zone, "motion": motion, "bifurcation": bifurcation}


def picture(name, change=lambda ax: None):
    """The pixels (height, width, 3) of a picture of 600 x 420, without its text."""
    with plt.rc_context(matplotlib.rcParamsDefault):
        figure = plt.figure(figsize=(6, 4.2), dpi=100)
        # the axes are fixed: the size of letters must not move the lines
        ax = figure.add_axes((0.1, 0.1, 0.85, 0.8))
        DRAWN[name](ax)
        change(ax)
        figure.canvas.draw()  # tick labels exist only from here on
        for text in figure.findobj(Text):
            text.set_visible(False)
        for one in figure.axes:
            if one.get_legend() is not None:
                one.get_legend().set_visible(False)
        content = io.BytesIO()
        figure.savefig(content, format="png")
        plt.close(figure)
    with Image.open(content) as image:
        return np.asarray(image.convert("RGB"))


def difference(one, other):
    """The largest difference between the means over squares."""
    means = [
        np.asarray(item, float)
        .reshape(item.shape[0] // SQUARE, SQUARE, item.shape[1] // SQUARE, SQUARE, 3)
        .mean(axis=(1, 3))
        for item in (one, other)
    ]
    return np.abs(means[0] - means[1]).max()


def kept(name):
    """The stored picture."""
    with Image.open(KEPT / f"{name}.png") as image:
        return np.asarray(image.convert("RGB"))


@pytest.mark.parametrize("name", DRAWN)
def test_picture_is_the_one_that_is_kept(name):
    """Lines, colours and places are those of the stored picture."""
    assert difference(picture(name), kept(name)) < MOST


def dashed(ax):
    """Draw all lines and points in another style."""
    for line in ax.get_lines():
        line.set(linestyle=":", marker="", color="0.5")


def thicker(ax):
    """Draw all lines twice as thick."""
    for line in ax.get_lines():
        line.set_linewidth(2 * line.get_linewidth() + 1)
        line.set_markersize(2 * line.get_markersize() + 1)


def moved(ax):
    """Show a different window."""
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.1 * (high - low))


@pytest.mark.parametrize("name", DRAWN)
@pytest.mark.parametrize("change", [dashed, thicker, moved])
def test_changes_are_seen(name, change):
    """A different line style or a different window far exceeds the allowed difference."""
    assert difference(picture(name, change), kept(name)) > 2 * MOST


def test_letters_are_not_seen():
    """A different font does not change the compared pictures."""

    def other_font(ax):
        for text in ax.findobj(Text):
            text.set(family="serif", size=12)

    assert difference(picture("motion", other_font), kept("motion")) < MOST


if __name__ == "__main__":
    KEPT.mkdir(exist_ok=True)
    for each in DRAWN:
        Image.fromarray(picture(each)).save(KEPT / f"{each}.png", optimize=True)
        print(KEPT / f"{each}.png", file=sys.stderr)
