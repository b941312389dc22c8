#!/usr/bin/env python3
"""Write docs/static: system.svg, overview.png (README.md), published.png, zones.png (of the tutorial)."""

import contextlib
import io
import os
import re
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import vibroimpact as vi
from generate import validation
from PIL import Image
from vibroimpact.plot import draw_system, style

DOCS = Path(__file__).parent
STYLE = {"font.size": 8, "axes.spines.top": False, "axes.spines.right": False}


def system():
    """The sketch of the system."""
    figure = draw_system().figure
    with plt.rc_context({"svg.hashsalt": "system"}):
        figure.savefig(DOCS / "static" / "system.svg", metadata={"Date": None})


def overview():
    """Two impacts a cycle, and the zones of two, three and four."""
    osc = vi.Oscillator(xi=0.0114, mu=0.028, restitution=0.75)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.4, 3.5), layout="constrained")
    vi.equispaced(osc, r=1.04, clearance=25.0)[0].plot(ax=left, kind="history")
    for sides, label in (("RL", "2"), ("RRL", "3"), ("RRLL", "4")):
        window = {"r": (0.8, 1.2), "clearance": (2, 400)}
        symmetric = True if sides == "RL" else None
        vi.zone(osc, vi.Pattern(sides), **window, symmetric=symmetric).plot(right, True, label)
    style.log_scale(right, "y")
    right.set_ylim(bottom=0.002)
    right.legend(loc="lower center", ncols=2, frameon=False)
    right.set_title("where 2, 3 and 4 impacts a cycle are stable", fontsize=9)
    left.set_title("$r$ = 1.04, $dK/F_0$ = 25", fontsize=9, loc="left")
    figure.suptitle(style.given(style.system(osc)), fontsize=9)
    figure.savefig("overview.png", dpi=200)


def published():
    """Published bifurcations of an oscillator with one wall, and the same curves computed here."""
    wall, rows = validation.stop(), [row for row in validation.published() if row[3] > 0]
    figure, ax = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    for kind, side, color, mark in (("flip", -1, "#0072B2", "o"), ("fold", 1, "#D55E00", "s")):
        of_kind = [row for row in rows if row[0] == kind]
        omega, load = np.array([row[1:3] for row in of_kind[::10]]).T
        computed = np.array(
            [
                validation.critical(wall, side, row[1], validation.phase_of_speed(*row[1:4]))[0]
                for row in of_kind[::10]
            ]
        )
        # a new list of points begins where omega jumps
        parts = np.flatnonzero(np.abs(np.diff(omega)) > 0.005) + 1
        for i, part in enumerate(np.split(np.arange(len(omega)), parts)):
            ax.plot(
                omega[part], computed[part], color=color, label=None if i else f"{kind}, computed"
            )
        ax.plot(
            omega[::4], load[::4], mark, color=color, mfc="none", ms=4, label=f"{kind}, published"
        )
    ax.set_xlabel(r"$\omega$")
    ax.set_ylabel("$F$")
    ax.legend(frameon=False)
    figure.savefig("published.png", dpi=200)


def tutorial():
    """The blocks of the tutorial, in order; one of them writes zones.png."""
    blocks = re.findall(
        r"^```python\n(.*?)^```", (DOCS / "tutorial.md").read_text("utf-8"), re.M | re.S
    )
    names = {}
    for block in blocks:
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(block, "tutorial.md", "exec"), names)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        system()
        with plt.rc_context(STYLE):
            overview()
            published()
        tutorial()
        for name in ("overview.png", "published.png", "zones.png"):
            picture = Image.open(name).convert("RGB").quantize(256, dither=0)
            picture.save(DOCS / "static" / name, optimize=True)
        os.chdir(DOCS)
