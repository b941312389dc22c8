"""A bar on the terminal for what takes longer than two seconds."""

from __future__ import annotations

import sys
import time

#: Seconds before the bar appears, and between two of its pictures.
PATIENCE, INTERVAL = 2.0, 0.2
WIDTH = 30


class Progress:
    """A bar on standard error, if that is a terminal; `with` takes it away at the end."""

    def __init__(self, label: str, wanted: bool | None = None) -> None:
        self.label = label
        self.wanted = sys.stderr.isatty() if wanted is None else wanted
        self.begin = self.last = time.monotonic()
        self.reached = 0.0
        self.shown = False

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        if self.shown:
            print("\r" + " " * (len(self.label) + WIDTH + 70) + "\r", end="", file=sys.stderr)

    def show(self, share: float, note: str = "") -> None:
        """Draw the bar for a share of the work between 0 and 1, with the time that is left at this pace.

        The share falls where more work comes in sight: the time left is told anew then, the bar stays.
        """
        now = time.monotonic()
        self.reached = max(self.reached, min(1.0, share))
        if not self.wanted or now - self.begin < PATIENCE or now - self.last < INTERVAL:
            return
        self.last = now
        self.shown = True
        bar = "#" * int(WIDTH * self.reached)
        spent = now - self.begin
        left = f", about {spent * (1 / share - 1):.0f} s left" if 0 < share < 1 else ""
        print(
            f"\r{self.label} [{bar:<{WIDTH}}] {spent:.0f} s{left} {note:<30}",
            end="",
            file=sys.stderr,
            flush=True,
        )
