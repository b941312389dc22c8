"""Results as Jupyter shows them: kind of result, some numbers, and a picture."""

from __future__ import annotations

from html import escape
from typing import Any

from ..base.jupyter import facts_html


def html(noun: Any, picture: str) -> str:
    """A short piece of HTML; `picture` is the address of an image, or empty."""
    notes = "".join(f"<li>{escape(text)}</li>" for _, text in noun._result.notes)
    image = f"<img alt='{escape(repr(noun), quote=True)}' src='{picture}'/>"
    after = f"{f'<ul>{notes}</ul>' if notes else ''}{image if picture else ''}"
    return facts_html(repr(noun), noun._facts(), after)
