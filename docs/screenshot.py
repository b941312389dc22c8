#!/usr/bin/env python3
"""Write docs/static/explorer.png and explorer_design.png: the page of `vibroimpact explore` as a headless Chromium
shows it, at its start, and with units, a map and a box of tolerances."""

import io
from pathlib import Path

from PIL import Image
from vibroimpact.explorer.process import visited

PICTURES = {
    "explorer": (830, ""),
    "explorer_design": (1000, "units=0.0027,42,6,mm,N,s&map=on&box=1.03,30,0.03,8&limit=0.5"),
}

for name, (height, query) in PICTURES.items():
    with visited(1280, height, query) as (_, tab):
        tab.wait_for_timeout(500)  # the last picture is drawn
        picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB").quantize(256, dither=0)
        picture.save(Path(__file__).with_name("static") / f"{name}.png", optimize=True)
