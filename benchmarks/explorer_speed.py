#!/usr/bin/env python3
"""Milliseconds from a pointer's or a slider's move to the picture, taken by the clock of a headless Chromium.

The page is the explorer's own: the time runs from the event in the browser to the frame that shows the answer.
"""

import math
import os
import random
import statistics
from pathlib import Path

from table import row, show
from vibroimpact.explorer.process import SETTLED, visited

MOVES = 150
SLIDES = 12
#: Sliders moved in turn, each to random values between these two.
SLIDERS = (("xi", 0.002, 0.05), ("mu", 0.01, 0.1), ("R1", 0.5, 0.9), ("R2", 0.5, 0.9))
#: Milliseconds from the event of `act` to the frame after the first change of an element.
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
    """Milliseconds from a move of the pointer (in parts of the chart's box) until the motions there are drawn."""
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
    """Milliseconds from a move of a slider until the zones are drawn."""
    act = (
        f"const s = document.querySelector('[data-slider={name}]'); s.value = {value}; "
        "s.dispatchEvent(new Event('input'))"
    )
    return tab.evaluate(TIMED, ["families", act])


def cpu(process):
    """Milliseconds of CPU that a process has taken; NaN where the system does not tell."""
    try:
        words = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return math.nan
    return 1e3 * (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def measured(process, tab):
    """For pointer and slider: milliseconds of each move, and the server's mean CPU time."""
    draw = random.Random(1)
    begin = cpu(process)
    moves = [moved(tab, draw.uniform(0.15, 0.95), draw.uniform(0.1, 0.8)) for _ in range(MOVES)]
    yield "pointer", moves, (cpu(process) - begin) / MOVES, 100
    tab.mouse.move(2, 2)
    slides, spent = [], 0.0
    for i in range(SLIDES):
        tab.wait_for_function(SETTLED)
        name, low, high = SLIDERS[i % 4]
        begin = cpu(process)
        slides.append(slid(tab, name, round(draw.uniform(low, high), 4)))
        spent += cpu(process) - begin
    yield "slider", slides, spent / SLIDES, 1000


def rows():
    """Median and 95 % of both, and the CPU time of the server, which hardly depends on other work."""
    with visited(1280, 800) as (process, tab):
        found = list(measured(process, tab))
    table = []
    for name, times, spent, target in found:
        ends = statistics.quantiles(times, n=20)
        table += [
            row(f"explorer: {name} to picture, median", "ms", statistics.median(times), target),
            row(f"explorer: {name} to picture, 95 %", "ms", ends[-1], target),
        ]
        if spent == spent:
            table.append(row(f"explorer: {name}, CPU of the server", "ms", spent))
    return table


if __name__ == "__main__":
    print(f"load of the machine: {os.getloadavg()[0]:.1f}, {os.cpu_count()} processors")
    show(rows())
