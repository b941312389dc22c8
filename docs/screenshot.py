#!/usr/bin/env python3
"""Write docs/static/explorer.png: the page of `vibroimpact explore` as a headless Chromium shows it."""

import io
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

READY = """() => window.vibroimpact?.idle() && document.getElementById('families').children.length
  && document.getElementById('status').textContent === ''
  && document.getElementById('searched').textContent.endsWith('were searched.')"""

command = [Path(sys.executable).with_name("vibroimpact"), "explore", "--no-browser", "--port", "0"]
server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
try:
    url = re.search(r"http://\S+/", server.stdout.readline()).group()
    with sync_playwright() as driver:
        flags = ["--no-sandbox", "--disable-gpu"]
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
        tab = browser.new_page(viewport={"width": 1280, "height": 830})
        tab.goto(url)
        tab.wait_for_function(READY)
        tab.wait_for_timeout(500)  # the last picture is drawn
        picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB").quantize(256, dither=0)
        picture.save(Path(__file__).with_name("static") / "explorer.png", optimize=True)
        browser.close()
finally:
    server.send_signal(signal.SIGINT)
    server.wait(20)
