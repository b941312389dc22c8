"""Results as Jupyter shows them: kind of result, some numbers, and a picture."""

from __future__ import annotations

from html import escape
from typing import Any

LEFT = "style='text-align:left'"


def html(noun: Any, picture: str) -> str:
    """A short piece of HTML; `picture` is the address of an image, or empty."""
    rows = "".join(
        f"<tr><th {LEFT}>{escape(name)}</th><td {LEFT}>{escape(value)}</td></tr>"
        for name, value in noun._facts().items()
    )
    notes = "".join(f"<li>{escape(text)}</li>" for _, text in noun._result.notes)
    image = f"<img alt='{escape(repr(noun), quote=True)}' src='{picture}'/>"
    return (
        f"<div><code>{escape(repr(noun))}</code>{f'<table>{rows}</table>' if rows else ''}"
        f"{f'<ul>{notes}</ul>' if notes else ''}{image if picture else ''}</div>"
    )
