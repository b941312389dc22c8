"""The tables and figures of Popplewell, Bapat and McLachlan (1983), computed and compared."""

from __future__ import annotations

from .run import reproduce
from .tasks import NAMES

__all__ = ["NAMES", "reproduce"]
