#!/usr/bin/env python3
"""Milliseconds from a pointer's or a slider's move to the picture, taken by the clock of a headless Chromium.

The page is the explorer's own: the time runs from the event in the browser to the frame that shows the answer.
"""

import os
import random
import re
import shutil
import signal
import statistics
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright
from table import row, show

MOVES = 150
SLIDES = 12
#: In turn, each to anywhere between two values.
SLIDERS = (("xi", 0.002, 0.05), ("mu", 0.01, 0.1), ("R1", 0.5, 0.9), ("R2", 0.5, 0.9))
READY = """() => window.vibroimpact?.idle() && document.getElementById('families').children.length
  && document.getElementById('status').textContent === ''
  && document.getElementById('searched').textContent.endsWith('were searched.')"""
#: Milliseconds from what `act` does to the frame behind the first change of an element.
TIMED = """([name, act]) => new Promise((done) => {
  const begin = performance.now(), element = document.getElementById(name)
  const seen = new MutationObserver(() => {
    seen.disconnect()
    requestAnimationFrame(() => setTimeout(() => done(performance.now() - begin)))
  })
  seen.observe(element, { childList: true, characterData: true, subtree: true })
  new Function(act)()
})"""


def moved(tab, right, down):
    """The pointer goes to a place of the chart (parts of its box): until the motions there are drawn."""
    box = tab.locator("#chart").bounding_box()
    x, y = box["x"] + right * box["width"], box["y"] + down * box["height"]
    waits = tab.evaluate_handle(
        """() => ({ time: new Promise((done) => {
          let begin = 0
          addEventListener("pointermove", (e) => { begin ||= e.timeStamp }, { capture: true, once: true })
          const seen = new MutationObserver(() => {
            if (!begin) return
            seen.disconnect()
            requestAnimationFrame(() => setTimeout(() => done(performance.now() - begin)))
          })
          seen.observe(document.getElementById("place"), { childList: true })
        }) })"""
    )
    tab.mouse.move(x, y)
    return tab.evaluate("waits => waits.time", waits)


def slid(tab, name, value):
    """A slider goes to a value: until the zones are drawn."""
    act = (
        f"const s = document.querySelector('[data-slider={name}]'); s.value = {value}; "
        "s.dispatchEvent(new Event('input'))"
    )
    return tab.evaluate(TIMED, ["families", act])


def measured(tab):
    """(pointer, slider) milliseconds."""
    draw = random.Random(1)
    tab.wait_for_function(READY)
    moves = [moved(tab, draw.uniform(0.15, 0.95), draw.uniform(0.1, 0.8)) for _ in range(MOVES)]
    tab.mouse.move(2, 2)
    slides = []
    for i in range(SLIDES):
        tab.wait_for_function(READY)
        name, low, high = SLIDERS[i % 4]
        slides.append(slid(tab, name, round(draw.uniform(low, high), 4)))
    return moves, slides


def rows():
    """Median and 95 % of both."""
    command = [Path(sys.executable).with_name("vibroimpact"), "explore", "--no-browser"]
    server = subprocess.Popen([*command, "--port", "0"], stdout=subprocess.PIPE, text=True)
    try:
        url = re.search(r"http://\S+/", server.stdout.readline()).group()
        with sync_playwright() as driver:
            flags = ["--no-sandbox", "--disable-gpu"]
            browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=flags)
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            tab.goto(url)
            found = measured(tab)
            browser.close()
    finally:
        server.send_signal(signal.SIGINT)
        server.wait(20)
    table = []
    for name, times, target in zip(("pointer", "slider"), found, (100, 1000), strict=True):
        ends = statistics.quantiles(times, n=20)
        table.append(
            row(f"explorer: {name} to picture, median", "ms", statistics.median(times), target)
        )
        table.append(row(f"explorer: {name} to picture, 95 %", "ms", ends[-1], target))
    return table


if __name__ == "__main__":
    print(f"load of the machine: {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors")
    show(rows())
