"""Results as Jupyter shows them: the kind of result, a summary, and a small picture if matplotlib is installed."""

from __future__ import annotations

from html import escape
from typing import Any

from ..interchange.page import picture


def html(noun: Any) -> str:
    """A short piece of HTML."""
    notes = "".join(f"<li>{escape(text)}</li>" for _, text in noun._result.notes)
    title = f"<code>{escape(repr(noun))}</code>"
    return f"<div>{title}{f'<ul>{notes}</ul>' if notes else ''}{picture(noun)}</div>"
