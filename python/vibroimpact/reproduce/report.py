"""One self-contained page with figures, statements, misprints, corrections and timings."""

from __future__ import annotations

import base64
import csv
import json
import re
from collections.abc import Iterable, Sequence
from html import escape
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from ..base.files import write_text
from .appendix import CORRECTIONS, TABLE_1
from .captions import CAPTIONS, INTRODUCTION, PHASE_ERRORS
from .statements import counted
from .table1 import MISPRINTS
from .tasks import NAMES, ON_REQUEST, SWEEPS, seconds

DOI = "10.1016/0022-460X(83)90438-8"


#: The note on the last column of the statements.
PROVEN = (
    "Proven: by interval arithmetic (<code>prove</code>), which bounds every rounding error. Everything else is "
    "computed in double precision."
)
NOT_PROVEN = (
    "Nothing was proven, because python-flint is not installed: "
    "<code>pip install 'vibroimpact[proof]'</code>."
)


def cells(row: Iterable[Any], tag: str = "td", numbers: int = 99) -> str:
    """A row of a table; cells from column `numbers` on are formatted as numbers."""
    return "<tr>" + "".join(
        f"<{tag}{' class=n' if i >= numbers else ''}>{item}</{tag}>" for i, item in enumerate(row)
    ) + "</tr>"  # fmt: skip


def grid(header: Sequence[str], rows: Iterable[Iterable[Any]], numbers: int = 99) -> str:
    """A table that scrolls sideways if the window is narrow."""
    body = "\n".join(cells(row, numbers=numbers) for row in rows)
    head = cells(header, "th", numbers)
    return (
        f'<div class="scroll"><table><thead>{head}</thead><tbody>\n{body}\n</tbody></table></div>'
    )


def whole(text: str) -> str:
    """A text on one line."""
    return f'<span class="whole">{escape(text)}</span>'


#: The markup of names in the tables.
SYMBOLS = (
    ("alpha", "α"), ("lambda", "λ"), ("Omega ", "Ω"), ("Omega", "Ω"), ("tau", "τ"), (" pi xi", "πξ"),
    ("/pi", "/π"), ("X'", "Ẋ"), ("Z'", "Ż"), ("R1^2 R2^2", "R₁²R₂²"),
)  # fmt: skip


def pretty(text: str) -> str:
    """A text with its symbols and subscripts marked up."""
    text = escape(text, quote=False)
    for name, symbol in SYMBOLS:
        text = text.replace(name, symbol)
    return re.sub(r"_(\w+)", r"<sub>\1</sub>", text)


def verdict(text: str) -> str:
    """A verdict, marked up in its colour."""
    kind = text.split()[0].lower().rstrip(":")
    return f'<span class="{kind}">{escape(text)}</span>'


def picture(folder: Path, name: str) -> str:
    """A figure with its caption and the messages of its computation."""
    title, text, wide = CAPTIONS[name]
    image = base64.b64encode((folder / f"{name}.svg").read_bytes()).decode()
    messages = json.loads((folder / "data" / f".{name}.done").read_text(encoding="utf-8"))[
        "messages"
    ]
    return (
        f'<section id="{name}"><h2>{title}</h2>\n<figure class="{"wide" if wide else "one"}">'
        f'<img alt="{escape(title)}" src="data:image/svg+xml;base64,{image}">'
        f"<figcaption>{text}</figcaption></figure>\n"
        f"<details><summary>Messages of the computation</summary><pre>{escape(messages)}</pre></details></section>"
    )


def rows_of(folder: Path) -> list[dict[str, str]]:
    """The statements of the paper with their verdicts."""
    rows: list[dict[str, str]] = json.loads(
        (folder / "data" / "statements.json").read_text(encoding="utf-8")
    )
    return rows


def statements(folder: Path) -> str:
    """The statements of the paper and the findings."""
    rows = rows_of(folder)
    lines = [
        (whole(x["where"]), pretty(x["statement"]), pretty(x["found"]), verdict(x["verdict"]), pretty(x["proven"]))
        for x in rows
    ]  # fmt: skip
    note = PROVEN if any(x["proven"] for x in rows) else NOT_PROVEN
    header = "Where", "What the paper says", "What is found here", "Verdict", "Proven"
    return grid(header, lines) + f"<p>{note}</p>"


def table_1(folder: Path) -> str:
    """Table 1, with printed and computed values side by side, and its misprints."""
    with (folder / "table1.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = list(dict.fromkeys(row["column"] for row in rows))
    at = {(row["column"], row["quantity"]): row for row in rows}
    lines = []
    for quantity in dict.fromkeys(row["quantity"] for row in rows):
        line = [pretty(quantity)]
        for column in columns:
            row = at[column, quantity]
            value = row["computed"]
            value = value if value.isalpha() else f"{float(value):.4f}"
            mark = " *" if row["verdict"].startswith("misprint") else ""
            line += [value, f"<b>{row['printed']}{mark}</b>" if mark else row["printed"]]
        lines.append(line)
    header = ["", *(name for column in columns for name in (column, "printed"))]
    notes = "".join(
        f"<p>* {pretty(q)}, {c}: {pretty(why)}.</p>" for (q, c), why in MISPRINTS.items()
    )
    return grid(header, lines, numbers=1) + notes


def corrections(folder: Path) -> str:
    """The three corrections of (A6), (A7), and the effect of each."""
    rows = json.loads((folder / "data" / "appendix.json").read_text(encoding="utf-8"))
    what = grid(
        ("Correction", "printed", "correct"),
        ([pretty(x) for x in c] for c in CORRECTIONS.values()),
    )
    lines = []
    for row in rows:
        left = [
            CORRECTIONS[name][0].split()[0] for name in CORRECTIONS if name not in row["corrected"]
        ]
        outcome = "all three corrected" if not left else pretty(f"{', '.join(left)} as printed")
        moduli = ", ".join(f"{x:.4g}" if x > 1e-12 else "0" for x in row["multipliers"])
        determinant = row["determinant"] if abs(row["determinant"]) > 1e-12 else 0.0
        lines.append((
            whole(row["motion"]), outcome, moduli, f"{row['largest_in_table_1']:.4g}",
            f"{determinant:.6g}", f"{row['law']:.6g}", f"{row['largest_error']:.0e}",
        ))  # fmt: skip
    header = ("Motion", "", "|λ|, lengths in F₀/K", f"max|λ|, unit with d = {TABLE_1:g}", "det[P]", "law",
              "error of P<sub>i</sub>")  # fmt: skip
    return what + grid(header, lines, numbers=2)


def phase_errors(folder: Path) -> str:
    """The results for misread phases under the rule of 3 %."""
    rows = json.loads((folder / "data" / "phase_errors.json").read_text(encoding="utf-8"))
    lines = [
        (whole(f"{len(x['sides'])} ({x['sides']}, r = {x['r']:g})"), f"{x['error']:g}", f"{x['milliseconds']:.2f}",
         " – ".join(f"{100 * q:.1f}" for q in (x["residual"][0], x["residual"][2])),
         f"{100 * x['accepted'][0]:.0f}", f"{100 * x['wrong'][0]:.1f}", f"{100 * x['accepted'][1]:.0f}",
         f"{100 * x['wrong'][1]:.1f}", f"{100 * x['clearance_off']:.1f}") for x in rows
    ]  # fmt: skip
    header = ("Impacts/cycle", "misread by (rad)", "(ms)", "residual, % (5–95 %)", "3 % takes, %", "wrong, %",
              "1.5 % takes, %", "wrong, %", "error of dK/F₀, %")  # fmt: skip
    return grid(header, lines, numbers=1)


def timings(folder: Path) -> str:
    """Processor time of each task."""
    parts = {f"simulated holds, {rig} R": sum(seconds(folder, x) for x in names)
             for rig, names in SWEEPS.items()}  # fmt: skip
    parts |= {
        name: seconds(folder, name)
        for name in (*NAMES, "phase_errors", "appendix", "statements")
        if name != "report" and name not in ON_REQUEST
    }
    parts["sum"] = sum(parts.values())
    return grid(
        ("Item", "seconds of one processor"),
        ((name, f"{x:.2f}") for name, x in parts.items()),
        numbers=1,
    )


def reproduce(folder: Path, resolution: float = 1.0) -> bool:
    """Write report.html."""
    style = (files(__package__) / "report.css").read_text(encoding="utf-8")
    figures = [name for name in NAMES if name in CAPTIONS]
    rows = rows_of(folder)
    links = {
        "statements": "Statements",
        "table1": "Table 1",
        "appendix": "(A6), (A7)",
        "phase_errors": "3 % rule",
    }
    links |= {name: CAPTIONS[name][0].split(":")[0] for name in figures} | {"timing": "Timing"}
    rough = (
        f"<p><b>Made at resolution {resolution:g}: a rough draft.</b></p>"
        if resolution != 1
        else ""
    )
    text = "\n".join([
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Stable periodic vibroimpacts, recomputed</title>\n<style>\n{style}</style></head><body>",
        "<h1>Stable periodic vibroimpacts of an oscillator, recomputed</h1>",
        f'<p class="lead">Every table and figure of N. Popplewell, C. N. Bapat and K. McLachlan, J. Sound Vib. 87 '
        f"(1983) 41–59, doi {DOI}, computed by vibroimpact {escape(version('vibroimpact'))}.</p>{rough}",
        f"<p><b>{len(rows)} statements of the paper:</b> {escape(counted([row['verdict'] for row in rows]))}. "
        'Each is listed <a href="#statements">below</a> with what is found here.</p>',
        "<nav>" + " ".join(f'<a href="#{key}">{name}</a>' for key, name in links.items()) + "</nav>",
        INTRODUCTION,
        '<section id="statements"><h2>What the paper says, and what is found</h2>',
        statements(folder), "</section>",
        '<section id="table1"><h2>Table 1</h2>', table_1(folder), "</section>",
        '<section id="appendix"><h2>Three corrections to (A6) and (A7)</h2>', corrections(folder), "</section>",
        '<section id="phase_errors"><h2>The rule of 3 %</h2>', PHASE_ERRORS, phase_errors(folder), "</section>",
        *(picture(folder, name) for name in figures),
        '<section id="timing"><h2>Timing</h2>', timings(folder), "</section>",
        "</body></html>\n",
    ])  # fmt: skip
    write_text(folder / "report.html", text)
    return True
