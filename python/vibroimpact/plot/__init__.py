"""Pictures of motions and trajectories, in the manner of Figures 2 and 9 of the 1983 paper.

matplotlib is imported when a picture is drawn (extra `plot`).
"""

from __future__ import annotations

from .history import KINDS, draw

__all__ = ["KINDS", "draw"]
