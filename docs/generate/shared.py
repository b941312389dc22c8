"""Functions for several generators."""

import re
from importlib.resources import files
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROGRAM = str(files("vibroimpact") / "_bin" / "vibroimpact-batch")


def sentence(text):
    """Plain text as Markdown: characters of markup are escaped, except in code."""
    parts = re.split(r"(`[^`]*`)", " ".join(text.split()))
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<\[\]$|])", r"\\\1", part) for part in parts
    )
