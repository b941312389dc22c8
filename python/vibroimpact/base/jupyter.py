"""Small tables as Jupyter shows them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape

LEFT = "style='text-align:left'"


def facts_html(text: str, facts: Mapping[str, str], after: str = "") -> str:
    """A line of code, and names with their values below it; `after` is HTML.

    Examples
    --------
    >>> from vibroimpact.base.jupyter import facts_html
    >>> facts_html("<Units>", {})
    '<div><code>&lt;Units&gt;</code></div>'
    """
    rows = "".join(
        f"<tr><th {LEFT}>{escape(name)}</th><td {LEFT}>{escape(value)}</td></tr>"
        for name, value in facts.items()
    )
    return (
        f"<div><code>{escape(text)}</code>{f'<table>{rows}</table>' if rows else ''}{after}</div>"
    )


def rows_html(
    text: str, names: Iterable[str], rows: Iterable[Iterable[str]], note: str = ""
) -> str:
    """A line of code, a table with a heading for each column, and a note."""
    head = "".join(f"<th {LEFT}>{escape(name)}</th>" for name in names)
    body = "".join(
        f"<tr>{''.join(f'<td {LEFT}>{escape(value)}</td>' for value in row)}</tr>" for row in rows
    )
    table = f"<table><tr>{head}</tr>{body}</table>" if body else ""
    return (
        f"<div><code>{escape(text)}</code>{table}{f'<p>{escape(note)}</p>' if note else ''}</div>"
    )
