"""Computations that take longer than a frame: they run in threads, where only the newest job of each kind
counts."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Collection
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import Zone
from .attenuation import SIZE, Judged, box_points, filled, judged, map_parts
from .explorer import diagram_of
from .latest import Current, Latest, Stale
from .limits import TooLong, watched
from .motions import Shown, fuller
from .shapes import zone_shapes
from .state import State
from .zones import COARSE, FINE, Family, compute, families

__all__ = ["Background"]

#: Seconds for which the pointer must rest before a fuller search starts at its position.
REST = 0.3
#: Seconds in which the browser can draw the coarse zones before finer computations occupy the processors.
PAUSE = 0.1
#: Seconds after which the fuller search begins even if the zones are not finished.
PATIENCE = 10
#: Seconds for which the computation of coarse zones continues, and draws them, while a slider moves.
GRACE = 2.0
#: Seconds after which the computation of all coarse zones, or of one fine zone, is abandoned.
LIMITS = {COARSE: 30.0, FINE: 120.0}
#: Seconds after which a fuller search or a diagram is abandoned.
LONGEST = 120.0


class Background:
    """The background jobs: zones, thorough searches at the chosen point and where the pointer rests, the diagram,
    the map and the box.

    Each job takes a callable `show`, which receives the result in the thread of the page unless a newer job has
    been requested by then.

    Parameters
    ----------
    at_its_turn : callable
        Runs a function in the thread of the page; the job threads use it to return their results.
    failed : callable
        Called in the thread of the page with the kind of job (the name of the method) and the exception.
    """

    def __init__(
        self,
        at_its_turn: Callable[[Callable[[], None]], None],
        failed: Callable[[str, Exception], None],
    ) -> None:
        self.at_its_turn, self.failed = at_its_turn, failed

        def worker(kind: str, niceness: int = 5) -> Latest:
            return Latest(lambda error: at_its_turn(lambda: failed(kind, error)), niceness)

        self.coarse_zones, self.fine_zones = worker("zones", 0), worker("zones")
        self.search, self.rest, self.sweep = worker("motions"), worker("rest"), worker("diagram")
        self.map, self.box = worker("map"), worker("box")
        self.coarse_done = threading.Event()

    def drop(self) -> None:
        """Stop all jobs; their results are no longer needed."""
        for worker in (
            self.coarse_zones, self.fine_zones, self.search, self.rest, self.sweep, self.map, self.box
        ):  # fmt: skip
            worker.drop()

    def zones(
        self, state: State, show: Callable[[dict[Family, Zone], Any, bool, str], None]
    ) -> None:
        """Compute all zones: first coarse ones, which are shown immediately, then fine ones.

        Arguments of `show`: zones, shapes, whether all zones are finished, and a text on abandoned zones.
        """
        named = list(families(state.osc, state.patterns))

        def one(family: Family, lines: int, look: Callable[..., None]) -> Zone | None:
            try:
                look()
                return watched(look, compute, state.osc, family, state.window, lines)
            except TooLong:
                return None

        def coarsely(current: Current) -> None:
            try:
                look = watch(current, COARSE, GRACE)
                with ThreadPoolExecutor(os.cpu_count()) as pool:
                    found = pool.map(lambda family: one(family, COARSE, look), named)
                    every = dict(zip(named, found, strict=True))
                zones = {family: zone for family, zone in every.items() if zone is not None}
                shapes = zone_shapes(zones)
                lacking = given_up(every.keys() - zones.keys(), COARSE)
                # zones are shown even while a slider still moves
                self._later("zones", lambda: True, lambda: show(zones, shapes, False, lacking))
                threading.Event().wait(PAUSE)
            finally:
                if current():
                    self.coarse_done.set()
            if current():
                self.fine_zones.submit(lambda current: finely(current, zones, lacking))

        def finely(current: Current, coarse: dict[Family, Zone], lacking: str) -> None:
            found = {family: one(family, FINE, watch(current, FINE)) for family in coarse}
            zones = {
                family: coarse[family] if zone is None else zone for family, zone in found.items()
            }
            shapes = zone_shapes(zones)
            rough = given_up([family for family, zone in found.items() if zone is None], FINE)
            remark = "; ".join(filter(None, (lacking, rough)))
            self._later("zones", current, lambda: show(zones, shapes, True, remark))

        self.fine_zones.drop()
        self.coarse_done.clear()
        self.coarse_zones.submit(coarsely)

    def motions(self, state: State, kept: list[Shown], show: Callable[[list[Shown]], None]) -> None:
        """Run the fuller search at the point; its motions are added to the known ones."""

        def search(current: Current) -> None:
            self._after_zones(current)
            self._search("motions", current, state, kept, show)

        self.search.submit(search)

    def attenuation(self, state: State, show: Callable[[NDArray[np.float64], float], None]) -> None:
        """Compute the map of max|X|/A, which is shown after each part.

        Arguments of `show`: the picture (rows along the clearance), and the fraction that is finished.
        """

        def search(current: Current) -> None:
            self._after_zones(current)
            picture = np.full(SIZE[::-1], np.nan)
            done, whole = 0, picture.size
            for r, clearance, places, step in map_parts(state.window):
                look = within(current, LONGEST)
                found = watched(look, judged, state.osc, r, clearance)
                filled(picture, places, found.attenuation, step)
                done += len(r)
                self._later("map", current, partial(show, picture.copy(), done / whole))

        self.map.submit(search)

    def tolerances(self, state: State, show: Callable[[Judged], None]) -> None:
        """Simulate at points of the box."""

        def search(current: Current) -> None:
            assert state.box is not None
            points = box_points(state.box)
            found = watched(within(current, LONGEST), judged, state.osc, *points)
            self._later("box", current, lambda: show(found))

        self.box.submit(search)

    def pointer(self, state: State, kept: list[Shown], show: Callable[[list[Shown]], None]) -> None:
        """Run the fuller search at the position of the pointer once it rests."""

        def search(current: Current) -> None:
            threading.Event().wait(REST)
            self._search("rest", current, state, kept, show)

        self.rest.submit(search)

    def diagram(self, state: State, show: Callable[[Any], None]) -> None:
        """Compute the bifurcation diagram along the line."""

        def sweep(current: Current) -> None:
            diagram = watched(within(current, LONGEST), diagram_of, state)
            self._later("diagram", current, lambda: show(diagram))

        self.sweep.submit(sweep)

    def _search(
        self, kind: str, current: Current, state: State, kept: list[Shown],
        show: Callable[[list[Shown]], None],
    ) -> None:  # fmt: skip
        stop(current)
        look = within(current, LONGEST)
        found = watched(look, fuller, state.osc, state.r, state.clearance, kept)
        self._later(kind, current, lambda: show(found))

    def _after_zones(self, current: Current) -> None:
        """Wait for the coarse zones, which a user who moves a slider is watching."""
        begin = time.monotonic()
        while time.monotonic() - begin < PATIENCE and not self.coarse_done.wait(0.05):
            stop(current)

    def _later(self, kind: str, current: Current, work: Callable[[], None]) -> None:
        """Run a function in the page's thread, unless a newer job has been requested by then."""

        def turn() -> None:
            try:
                if current():
                    work()
            except Stale:
                raise  # the page has been closed
            except Exception as error:
                self.failed(kind, error)

        self.at_its_turn(turn)


def watch(current: Current, lines: int, grace: float = 0.0) -> Callable[..., None]:
    """A progress callback that ends a search for zones when a newer job waits or it takes too long."""
    begin = time.monotonic()

    def look(*_: object) -> None:
        taken = time.monotonic() - begin
        if taken >= grace:
            stop(current)
        if taken > LIMITS[lines]:
            raise TooLong(f"given up after {LIMITS[lines]:g} s")

    return look


def within(current: Current, seconds: float) -> Callable[..., None]:
    """A progress callback that ends a job when a newer one waits or it takes too long."""
    begin = time.monotonic()

    def look(*_: object) -> None:
        stop(current)
        if time.monotonic() - begin > seconds:
            raise TooLong(f"given up after {seconds:g} s")

    return look


def given_up(families: Collection[Family], lines: int) -> str:
    """A text on the zones that were abandoned, with the reason."""
    what = {COARSE: "not computed", FINE: "only coarse"}[lines]
    names = ", ".join(sorted(family.name for family in families))
    return f"{names}: {what}, given up after {LIMITS[lines]:g} s" if names else ""


def stop(current: Current) -> None:
    """Stop a job whose result is no longer needed."""
    if not current():
        raise Stale
