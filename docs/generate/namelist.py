"""The keys of the namelist groups: the tables of inputs/README.md, which are made from those of the core."""

from .shared import ROOT


def pages():
    """One table for each group, and notes on what the tables omit."""
    text = (ROOT / "inputs" / "README.md").read_text(encoding="utf-8")
    tables = text.partition(".ci/check_keys.py --write. -->\n")[2].partition("## The result")[0]
    return {
        "namelist.md": tables.replace("\n### ", "\n## ").replace(
            "\nWhat the tables", "\n## Notes\n\nWhat the tables"
        )
    }
