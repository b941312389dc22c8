"""Pictures of motions, trajectories and charts, and a sketch of the system.

The panels of a motion are those of Figures 2 and 9 of the 1983 paper.

matplotlib is imported when a picture is drawn (extra `plot`).
"""

from __future__ import annotations

from .animation import animate
from .chart import draw_chart
from .history import KINDS, draw
from .sketch import draw_system

__all__ = ["KINDS", "animate", "draw", "draw_chart", "draw_system"]
