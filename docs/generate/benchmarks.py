"""The page of benchmarks: the table of the last run, if there is one, and how it was measured."""

from .shared import ROOT


def pages():
    """docs/benchmarks.md where it exists, and benchmarks/README.md."""
    table, method = ROOT / "docs" / "benchmarks.md", ROOT / "benchmarks" / "README.md"
    text = method.read_text(encoding="utf-8")
    if table.exists():
        text = table.read_text(encoding="utf-8") + "\n" + text.replace("# Benchmarks", "## How", 1)
    return {"benchmarks.md": text}
