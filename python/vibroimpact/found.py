"""All motions that a search found at a point, as one result: to be saved, read back and drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .find import FoundMotions, Search
from .interchange.result import Result
from .model import Oscillator
from .motion import Motion

__all__ = ["Findings"]


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Findings(Result):
    """The motions that `find` found at a point, stable ones first, and how they were searched for.

    Attributes
    ----------
    osc : Oscillator
    r, clearance, load : float
    motions : list of Motion
    search : Search

    Examples
    --------
    >>> import pathlib, tempfile, vibroimpact as vi
    >>> osc = vi.Oscillator(xi=0.005, mu=0.042, restitution=0.75)
    >>> motions = vi.find(osc, 0.94, 37.0, max_impacts=2, max_cycles=1)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "motions.json"
    >>> vi.Findings.of(osc, 0.94, 37.0, motions).save(path)
    >>> vi.load(path)
    <Findings at r = 0.94, d K/F0 = 37: 5 motions, 3 of them stable>
    """

    osc: Oscillator
    r: float
    clearance: float
    load: float
    motions: list[Motion]
    search: Search

    @classmethod
    def of(
        cls, osc: Oscillator, r: float, clearance: float, motions: FoundMotions, load: float = 1.0
    ) -> Findings:
        """What `find` gave for these arguments."""
        return cls(osc, r, clearance, load, list(motions), motions.search)

    def plot(self, ax: Any = None) -> Any:
        """Draw the history of each motion over a period, and the multipliers of all (extra `plot`).

        Parameters
        ----------
        ax : matplotlib Axes, optional
            With it the multipliers alone are drawn, into it.

        Returns
        -------
        Axes, or an array of Axes
        """
        from .plot.found import draw_found

        return draw_found(self, ax)

    def __repr__(self) -> str:
        stable = sum(motion.stable is True for motion in self.motions)
        there = f"{len(self.motions)} motion{'' if len(self.motions) == 1 else 's'}"
        return f"<Findings at r = {self.r:.6g}, d K/F0 = {self.clearance:.6g}: {there}, {stable} of them stable>"
