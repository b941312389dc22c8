#!/usr/bin/env python3
"""Write docs/static/explorer.png: the page of `vibroimpact explore` as a headless Chromium shows it."""

import io
from pathlib import Path

from PIL import Image
from vibroimpact.explorer.process import visited

with visited(1280, 830) as (_, tab):
    tab.wait_for_timeout(500)  # the last picture is drawn
    picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB").quantize(256, dither=0)
    picture.save(Path(__file__).with_name("static") / "explorer.png", optimize=True)
